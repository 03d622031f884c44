"""All figures of an evaluation as files."""

from __future__ import annotations

from haptisym.figures.bandwidths import draw_bandwidths, has_bandwidths
from haptisym.figures.nyquist import draw_nyquist
from haptisym.figures.projections import draw_projections
from haptisym.figures.ratios import draw_ratios
from haptisym.figures.regions import draw_regions
from haptisym.figures.sampling import band_of, ends_of, poles_of
from haptisym.figures.sheet import Drawings
from haptisym.figures.square import draw_jnd_square
from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part


def _without(evaluation: Evaluation) -> list[str]:
    has_none = {"regions": not evaluation.regions, "bandwidths": not has_bandwidths(evaluation)}
    return [name for name, is_so in has_none.items() if is_so]


def _telling_frequency(evaluation: Evaluation) -> float:
    """The middle of the first percept band, else the end of the band; beside it if a dynamics is infinite there."""
    low, high = ends_of(evaluation.percepts[0].band) if evaluation.percepts else band_of(evaluation)
    shares = (0.5, 0.4, 0.6, 0.45, 0.55) if evaluation.percepts else (1.0, 0.9, 0.8, 0.95, 0.85)
    infinite = {float(pole.omega) for pole in poles_of(evaluation)}
    return next(x for x in (low + share * (high - low) for share in shares) if x not in infinite)


_DRAWINGS = Drawings[Evaluation](
    {
        "ratios": (2.1, draw_ratios),
        "bandwidths": (2.1, draw_bandwidths),
        "nyquist": (2.6, draw_nyquist),
        "projections-real": (2.0, lambda ax, e: draw_projections(ax, e, Part.REAL)),
        "projections-imag": (2.0, lambda ax, e: draw_projections(ax, e, Part.IMAG)),
        "regions": (2.9, draw_regions),
        "jnd-square": (2.6, lambda ax, e: draw_jnd_square(ax, e, _telling_frequency(e))),
    },
    _without,
)
draw_figure, save_figures = _DRAWINGS.figure, _DRAWINGS.save
