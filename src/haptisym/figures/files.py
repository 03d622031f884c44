"""All figures of an evaluation as files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from matplotlib.axes import Axes

from haptisym.figures.kinds import UNDATED
from haptisym.figures.nyquist import draw_nyquist
from haptisym.figures.projections import draw_projections
from haptisym.figures.ratios import draw_ratios
from haptisym.figures.sampling import band_of, ends_of, poles_of
from haptisym.figures.square import draw_jnd_square
from haptisym.figures.style import one_column, save
from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part


def save_figures(evaluation: Evaluation, directory: str | Path, kinds: Iterable[str] = tuple(UNDATED)) -> list[Path]:
    """All figures as SVG, PDF and PNG, or as some of them, one column (3.4 in) wide, in a directory that is made if need be.

    The same evaluation gives the same files, byte for byte.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    drawings: dict[str, tuple[float, Callable[[Axes], object]]] = {
        "ratios": (2.1, lambda ax: draw_ratios(ax, evaluation)),
        "nyquist": (2.6, lambda ax: draw_nyquist(ax, evaluation)),
        "projections-real": (2.0, lambda ax: draw_projections(ax, evaluation, Part.REAL)),
        "projections-imag": (2.0, lambda ax: draw_projections(ax, evaluation, Part.IMAG)),
        "jnd-square": (2.6, lambda ax: draw_jnd_square(ax, evaluation, _telling_frequency(evaluation))),
    }
    return [
        path
        for name, (height, draw) in drawings.items()
        for path in save(folder / name, one_column(height, draw), kinds)
    ]


def _telling_frequency(evaluation: Evaluation) -> float:
    """The middle of the first percept band, else the end of the band; beside it if a dynamics is infinite there."""
    low, high = ends_of(evaluation.percepts[0].band) if evaluation.percepts else band_of(evaluation)
    shares = (0.5, 0.4, 0.6, 0.45, 0.55) if evaluation.percepts else (1.0, 0.9, 0.8, 0.95, 0.85)
    infinite = {float(pole.omega) for pole in poles_of(evaluation)}
    return next(x for x in (low + share * (high - low) for share in shares) if x not in infinite)
