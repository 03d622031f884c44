"""The figures of a measured evaluation: ratios with their discs against the thresholds, and both responses in the plane.

Not too many lines are drawn, each with its disc, over frequencies in a unit and on a scale that fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.transforms import ScaledTranslation
from sympy import Expr

from haptisym.figures import pen
from haptisym.figures.sheet import Drawings
from haptisym.figures.style import (
    Scale,
    band_scale,
    dots,
    draw_origin,
    dress,
    dress_changes,
    dress_plane,
    entry,
    floats_scale,
    handle,
    keep_scales,
    legend,
    limit,
    name_frequency,
    wanted_scale,
)
from haptisym.model.jnd import SQUARE, Part
from haptisym.model.measured import Measurement
from haptisym.verbs.measured.entry import Cells, MeasuredEvaluation, Swept
from haptisym.verbs.measured.judging import joint_distance, limits_of, values_of

_MOST_LINES = 800
"""Drawn; of more, every so many."""


def thinned(count: int) -> Any:
    """Which of so many lines are drawn."""
    return np.arange(0, count, -(-count // _MOST_LINES))


def codes_of(e: MeasuredEvaluation, part: Part) -> Any:
    """What is told of a part, or of both where the region judges them together."""
    return e.joint.verdict if e.joint else e.verdict[part]


def left_out(drawn: int, count: int) -> list[Line2D]:
    """What the legend says where not all lines are drawn."""
    return [entry(f"{drawn} of {count} lines are drawn")] if drawn < count else []


def scale_of_lines(omega: Any, band: Sequence[Expr] | None = None, *, hertz: bool | None = None) -> Scale:
    """The unit of their frequencies: what was asked for, else that of the band, else the one in which they are short."""
    return wanted_scale(hertz=hertz) or (band_scale(band) if band else floats_scale(omega[:50]))


def spread_out(ax: Axes, at: Any) -> None:
    """A logarithmic axis where the lines span decades."""
    if at[0] > 0 and at[-1] > 30 * at[0]:
        ax.set_xscale("log")
        ax.tick_params(which="minor", width=0.4, length=1.5, color=pen.GREY)


def draw_discs(ax: Axes, centres: Any, radii: Any, color: str) -> None:
    """A disc about each point of the plane whose radius is known."""
    seen = np.isfinite(radii) & (radii > 0)
    circles = [Circle((c.real, c.imag), r) for c, r in zip(centres[seen], radii[seen], strict=True)]
    ax.add_collection(PatchCollection(circles, facecolor=color, edgecolor=color, alpha=0.22, linewidth=0.5, zorder=1))


def disc_handle(confidence: float) -> Line2D:
    """What the legend says of the bars that stand for discs."""
    return handle(pen.GREY, "none", f"{100 * confidence:.4g} % disc", 0.7, marker="|", markersize=6)


_PARTS = ((1, pen.RED, "exceeds in a part"), (0, pen.GREY, "unresolved"), (-1, pen.BLUE, "below in both parts"))
_JOINT = ((1, pen.RED, "outside"), (0, pen.GREY, "unresolved"), (-1, pen.BLUE, "inside"))


def draw_measured_nyquist(ax: Axes, e: MeasuredEvaluation) -> list[Line2D]:
    """H_env and the measured H_perc in the complex plane, a disc around each line, in the colour of what it tells.

    Returns the curve (or dots) of the environment and the dots of what is felt.
    """
    drawn = thinned(len(e))
    draw_origin(ax)
    lines = _environment(ax, e, drawn)
    real, imag = (codes_of(e, part) for part in Part)
    codes = np.where((real == 1) | (imag == 1), 1, np.where((real == -1) & (imag == -1), -1, 0))[drawn]
    felt, radius = e.lines.perceived[drawn], e.lines.perc_radius[drawn]
    for code, colour, label in _PARTS:
        if (own := codes == code).any():
            draw_discs(ax, felt[own], radius[own], colour)
            lines += ax.plot(felt[own].real, felt[own].imag, color=colour, zorder=4, label=label, **dots(2.4))
    _frame(ax, np.concatenate([e.lines.environment[drawn], felt]), radius)
    dress_plane(ax, e.scene)
    legend(ax, [*lines, *left_out(len(drawn), len(e))])
    return lines


def _environment(ax: Axes, e: MeasuredEvaluation, drawn: Any) -> list[Line2D]:
    """A curve of the model, or dots with discs where the environment is measured too."""
    x, label = e.lines, r"$H_\mathrm{env}$"
    if isinstance(e.scene.environment, Measurement):
        draw_discs(ax, x.environment[drawn], x.env_radius[drawn], pen.INK)
        env = x.environment[drawn]
        return ax.plot(env.real, env.imag, color=pen.INK, zorder=3, label=label, **dots(3, "x"))
    omega = np.union1d(np.linspace(x.omega[0], x.omega[-1], 801), x.omega[drawn])
    values = e.scene.frame.distortion().compile(of=["environment_real", "environment_imag"])(omega)
    made = ax.plot(
        values.environment_real, values.environment_imag, color=pen.INK, linewidth=1.1, zorder=2, label=label
    )
    env = x.environment[drawn]
    ax.plot(env.real, env.imag, color=pen.INK, zorder=3, **dots(4, "|"))
    return made


def _frame(ax: Axes, points: Any, radius: Any) -> None:
    """Limits that hold the points and most of their discs; equal scales where that leaves a drawing."""
    known = radius[np.isfinite(radius)]
    reach = float(np.quantile(known, 0.9)) if len(known) else 0.0
    sides = [(float(x.min()) - reach, float(x.max()) + reach) for x in (points.real, points.imag)]
    margin = 0.05 * max(high - low for low, high in sides) or 1.0
    limit(ax, *((low - margin, high + margin) for low, high in sides))
    keep_scales(ax)


def draw_measured_plane(ax: Axes, e: MeasuredEvaluation) -> list[Line2D]:
    """dH/|H_env| of each line with its disc, and the region, where that is the same at all. Returns the dots."""
    assert e.joint is not None
    drawn = thinned(len(e))
    at, codes = e.lines.change[drawn], e.joint.verdict[drawn]
    radius = np.zeros(len(at)) if e.lines.radius is None else e.lines.radius[drawn]
    reach = max(0.2, 1.15 * float(np.quantile(np.abs(at[np.isfinite(at)]), 0.9)))
    limit(ax, (-reach, reach), (-reach, reach))
    made: list[Line2D] = []
    for code, colour, label in _JOINT:
        if (own := (codes == code) & np.isfinite(at)).any():
            draw_discs(ax, at[own], radius[own], colour)
            made += ax.plot(at[own].real, at[own].imag, color=colour, label=label, **dots(2.4))
    entries = [*made]
    if e.scene.threshold.is_constant:
        side = np.linspace(-reach, reach, 401)
        x, y = np.meshgrid(side, side)
        distance = joint_distance(e.scene.threshold, np.ones(x.size), x.ravel(), y.ravel())
        assert distance is not None
        ax.contour(x, y, distance.reshape(x.shape), levels=[0], colors=pen.INK, linewidths=0.9)
        entries.append(handle(pen.INK, "-", str(e.scene.threshold.region.shape.value), 0.9))
    dress_changes(ax)
    ax.set_aspect("equal")
    legend(ax, entries)
    return made


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
