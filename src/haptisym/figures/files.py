"""All figures of an evaluation as files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.figures.bandwidths import draw_bandwidths, has_bandwidths
from haptisym.figures.kinds import UNDATED
from haptisym.figures.nyquist import draw_nyquist
from haptisym.figures.projections import draw_projections
from haptisym.figures.ratios import draw_ratios
from haptisym.figures.regions import draw_regions
from haptisym.figures.sampling import band_of, ends_of, poles_of
from haptisym.figures.sheet import one_column, save
from haptisym.figures.square import draw_jnd_square
from haptisym.figures.style import WIDTH
from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part


def save_figures(evaluation: Evaluation, directory: str | Path, kinds: Iterable[str] = tuple(UNDATED)) -> list[Path]:
    """All figures as SVG, PDF and PNG, or as some of them, one column (3.4 in) wide, in a directory that is made if need be.

    The same evaluation gives the same files, byte for byte.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    return [path for name in _names(evaluation) for path in save(folder / name, draw_figure(evaluation, name), kinds)]


def _names(evaluation: Evaluation) -> list[str]:
    without = {"regions": not evaluation.regions, "bandwidths": not has_bandwidths(evaluation)}
    return [name for name in _DRAWINGS if not without.get(name)]


def draw_figure(evaluation: Evaluation, name: str, *, wide: bool = False) -> Figure:
    """One of the figures by its name, one column wide, or one and a half."""
    height, draw = _DRAWINGS[name]
    return one_column(height, lambda ax: draw(ax, evaluation), 1.5 * WIDTH if wide else WIDTH)


_DRAWINGS: Mapping[str, tuple[float, Callable[[Axes, Evaluation], object]]] = MappingProxyType({
    "ratios": (2.1, draw_ratios),
    "bandwidths": (2.1, draw_bandwidths),
    "nyquist": (2.6, draw_nyquist),
    "projections-real": (2.0, lambda ax, e: draw_projections(ax, e, Part.REAL)),
    "projections-imag": (2.0, lambda ax, e: draw_projections(ax, e, Part.IMAG)),
    "regions": (2.9, draw_regions),
    "jnd-square": (2.6, lambda ax, e: draw_jnd_square(ax, e, _telling_frequency(e))),
})  # fmt: skip


def _telling_frequency(evaluation: Evaluation) -> float:
    """The middle of the first percept band, else the end of the band; beside it if a dynamics is infinite there."""
    low, high = ends_of(evaluation.percepts[0].band) if evaluation.percepts else band_of(evaluation)
    shares = (0.5, 0.4, 0.6, 0.45, 0.55) if evaluation.percepts else (1.0, 0.9, 0.8, 0.95, 0.85)
    infinite = {float(pole.omega) for pole in poles_of(evaluation)}
    return next(x for x in (low + share * (high - low) for share in shares) if x not in infinite)
