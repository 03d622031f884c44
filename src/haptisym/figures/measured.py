"""The figures of a measured evaluation: ratios with their discs against the thresholds, and both responses in the plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from haptisym.figures import pen
from haptisym.figures.lines import codes_of, disc_handle, left_out, scale_of_lines, spread_out, thinned
from haptisym.figures.measuredplane import draw_measured_nyquist, draw_measured_plane
from haptisym.figures.scales import Scale
from haptisym.figures.sheet import Drawings
from haptisym.figures.style import dots, dress, legend, limit, name_frequency
from haptisym.model.jnd import Part
from haptisym.model.regions import SQUARE
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.judging import limits_of
from haptisym.verbs.measured.regions import values_of
from haptisym.verbs.measured.swept import Cells, Swept

_COLOURS = {Part.REAL: pen.BLUE, Part.IMAG: pen.RED}
_SYMBOLS = {Part.REAL: r"$r_\mathrm{r}$", Part.IMAG: r"$r_\mathrm{i}$"}
_STYLES = {Part.REAL: pen.SOLID, Part.IMAG: pen.DASHED}
_APART = 1.3
"""Points to the left and to the right of a line's frequency, so that the bars of both parts can be told apart."""


def draw_measured_ratios(ax: Axes, e: MeasuredEvaluation, *, hertz: bool | None = None) -> list[Line2D]:
    """r_r and r_i at the measured lines, a bar as far as each disc reaches, and the thresholds. Returns the dots.

    Filled where the whole disc exceeds the threshold or is below it, open where it does not tell. Nothing joins the
    lines but what discs leave possible that a bound on the slope sweeps.
    """
    drawn, scale = thinned(len(e)), scale_of_lines(e.lines.omega, e.scene.band, hertz=hertz)
    omega = scale.of(e.lines.omega[drawn])
    radius = np.zeros(len(omega)) if e.lines.radius is None else e.lines.radius[drawn]
    top = _top(e, radius)
    limit(ax, _span(omega), (0, top))
    dots: list[Line2D] = []
    for part, change, side in zip(Part, (e.lines.change.real, e.lines.change.imag), (-1, 1), strict=True):
        ratio, place = np.abs(change[drawn]), _beside(ax, side)
        ends = np.clip(ratio - radius, 0, None), np.minimum(ratio + radius, 2 * top)
        ax.vlines(omega, *ends, transform=place, color=_COLOURS[part], linewidth=0.7, alpha=0.55, zorder=2)
        dots += _dots(ax, omega, ratio, codes_of(e, part)[drawn], part, place)
    thresholds = _thresholds(ax, e, scale)
    swept = _draw_swept(ax, e, scale) if e.scene.slopes else []
    dress(ax)
    spread_out(ax, omega)
    name_frequency(ax, scale)
    ax.set_ylabel(r"ratio to $|H_\mathrm{env}|$", fontsize=pen.TEXT)
    legend(ax, [*_told(e), *swept, *thresholds, *left_out(len(drawn), len(e))])
    return dots


def _dots(ax: Axes, at: Any, ratio: Any, codes: Any, part: Part, place: Any) -> list[Line2D]:
    made: list[Line2D] = []
    is_cut = bool((ratio > ax.get_ylim()[1]).any())
    for told, face in ((codes != 0, _COLOURS[part]), (codes == 0, "white")):
        if told.any():
            made += ax.plot(
                at[told], ratio[told], color=_COLOURS[part], zorder=3, transform=place, clip_on=is_cut,
                **dots(3.2, "os"[part is Part.IMAG], markerfacecolor=face, markeredgewidth=0.7),
            )  # fmt: skip
    return made


def _told(e: MeasuredEvaluation) -> list[Line2D]:
    """Entries of the legend: the parts, what a disc does not tell, and its bar."""
    rows: list[tuple[str, str, str, dict[str, Any]]] = [
        (_COLOURS[x], "os"[x is Part.IMAG], _SYMBOLS[x], {}) for x in Part
    ]
    if any((codes_of(e, part) == 0).any() for part in Part):
        rows.append((pen.INK, "o", "unresolved", {"markerfacecolor": "white"}))
    parts = [
        Line2D([], [], color=color, label=label, **dots(3.2, shape, markeredgewidth=0.7, **face))
        for color, shape, label, face in rows
    ]
    if e.lines.radius is not None:
        parts.append(disc_handle(e.scene.perceived.confidence))
    return parts


def _thresholds(ax: Axes, e: MeasuredEvaluation, scale: Scale) -> list[Line2D]:
    """Lines, or curves where a threshold is a formula in omega."""
    threshold = e.scene.threshold
    if e.joint or threshold.region != SQUARE:
        return []  # a limit that depends on the other part, or on the way, is no line
    parts = [Part.REAL] if threshold.real == threshold.imag else list(Part)
    omega = np.linspace(e.lines.omega[0], e.lines.omega[-1], 400)
    made = []
    for x in parts:
        name = "c" if len(parts) == 1 else rf"c_\mathrm{{{x.value[0]}}}"
        style: dict[str, Any] = {"color": pen.GREY, "linewidth": 0.6, "linestyle": _STYLES[x]}
        if threshold[x].is_number:
            made.append(ax.axhline(float(threshold[x]), label=f"${name} = {float(threshold[x]):.3g}$", **style))
        else:
            made += ax.plot(scale.of(omega), values_of(threshold[x], omega), label=rf"${name}(\omega)$", **style)
    return made


def _beside(ax: Axes, side: int) -> Any:
    """The place of data, a little to the one side."""
    return ax.transData + ScaledTranslation(side * _APART / 72, 0, ax.figure.dpi_scale_trans)


def _span(omega: Any) -> tuple[float, float]:
    low, high = float(omega[0]), float(omega[-1])
    margin = 0.03 * (high - low) or 0.5 * high or 1.0
    return max(low - margin, 0.0 if low == 0 else 0.5 * low), high + margin


def _top(e: MeasuredEvaluation, radius: Any) -> float:
    """The upper end of the ratios: nearly all dots with their bars, and twice the thresholds."""
    drawn = thinned(len(e))
    least = 2 * max(float(x.max()) for x in limits_of(e.scene, e.lines.omega).values())
    reach = np.maximum(np.abs(e.lines.change.real), np.abs(e.lines.change.imag))[drawn]
    reach = reach[np.isfinite(reach)]
    bars = (reach + radius[: len(reach)])[np.isfinite(radius[: len(reach)])]
    highest = [float(np.quantile(x, 0.95)) for x in (reach, bars) if len(x)]
    most = float(reach.max()) if len(reach) else 0.0
    return 1.08 * max(least, *highest, most if most < 3 * max(highest, default=0.0) else 0.0)


def measured_figure(e: MeasuredEvaluation) -> Figure:
    """The ratios, one column of a journal."""
    return draw_measured_figure(e, "ratios")


_MOST_POINTS = 6000


def _draw_swept(ax: Axes, e: MeasuredEvaluation, scale: Scale) -> list[Artist]:
    """The ratios that swept discs leave possible, as a band for each part. Returns the entry of the legend."""
    swept = Swept(e.scene, e.lines)
    gaps = np.flatnonzero(~swept.contradicted)
    steps = min(25, _MOST_POINTS // max(1, len(gaps)))
    if not len(gaps) or steps < 3:
        return []
    share = np.append(np.linspace(0, 1, steps), 1.0)
    low, high = swept.omega[gaps, None], swept.omega[gaps + 1, None]
    omega = (low + (high - low) * share).ravel()
    found = list(swept.lines(Cells(np.repeat(gaps, len(share)), omega, omega)))
    drawn = np.tile(np.append(np.ones(steps, bool), False), len(gaps))  # a break after each gap
    for part in Part:
        with np.errstate(invalid="ignore"):
            ratios = [np.abs(x.change.real if part is Part.REAL else x.change.imag) for x in found]
            least = np.max([np.maximum(r - x.radius, 0) for r, x in zip(ratios, found, strict=True)], axis=0)
            most = np.min([r + x.radius for r, x in zip(ratios, found, strict=True)], axis=0)
        known = drawn & np.isfinite(least) & np.isfinite(most)
        style: dict[str, Any] = {"color": _COLOURS[part], "alpha": 0.16, "linewidth": 0, "zorder": 1}
        ax.fill_between(scale.of(omega), least, np.maximum(least, most), where=known, **style)
    return [Patch(facecolor=pen.GREY, alpha=0.3, linewidth=0, label="swept discs")]


_DRAWINGS = Drawings[MeasuredEvaluation](
    {
        "ratios": (2.1, draw_measured_ratios),
        "nyquist": (2.6, draw_measured_nyquist),
        "plane": (2.8, draw_measured_plane),
    },
    lambda e: () if e.joint else ("plane",),
)
draw_measured_figure, save_measured_figures = _DRAWINGS.figure, _DRAWINGS.save
