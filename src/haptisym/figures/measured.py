"""The figures of a measured evaluation: ratios with their discs against the thresholds, and both responses in the plane."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.transforms import ScaledTranslation

from haptisym.figures.kinds import UNDATED
from haptisym.figures.measuredbetween import draw_swept
from haptisym.figures.measuredplane import draw_measured_plane
from haptisym.figures.scales import HERTZ, RADIANS, Scale, band_scale, floats_scale
from haptisym.figures.sheet import one_column, save
from haptisym.figures.style import (
    BLUE,
    DASHED,
    GREY,
    INK,
    RED,
    SOLID,
    TEXT,
    WIDTH,
    dress,
    entry,
    handle,
    legend,
    limit,
    name_dynamics,
    name_frequency,
)
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement
from haptisym.model.regions import SQUARE
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.judging import limits_of
from haptisym.verbs.measured.regions import values_of

_MOST_LINES = 800
"""Drawn; of more, every so many."""
_COLOURS = {Part.REAL: BLUE, Part.IMAG: RED}
_SYMBOLS = {Part.REAL: r"$r_\mathrm{r}$", Part.IMAG: r"$r_\mathrm{i}$"}
_STYLES = {Part.REAL: SOLID, Part.IMAG: DASHED}
_APART = 1.3
"""Points to the left and to the right of a line's frequency, so that the bars of both parts can be told apart."""


def draw_measured_ratios(ax: Axes, e: MeasuredEvaluation, *, hertz: bool | None = None) -> list[Line2D]:
    """r_r and r_i at the measured lines, a bar as far as each disc reaches, and the thresholds. Returns the dots.

    Filled where the whole disc exceeds the threshold or is below it, open where it does not tell. Nothing joins the
    lines but what discs leave possible that a bound on the slope sweeps.
    """
    drawn, scale = _drawn(e), _scale(e, hertz=hertz)
    omega = scale.of(e.lines.omega[drawn])
    radius = np.zeros(len(omega)) if e.lines.radius is None else e.lines.radius[drawn]
    top = _top(e, radius)
    limit(ax, _span(omega), (0, top))
    dots: list[Line2D] = []
    for part, change, side in zip(Part, (e.lines.change.real, e.lines.change.imag), (-1, 1), strict=True):
        ratio, place = np.abs(change[drawn]), _beside(ax, side)
        ends = np.clip(ratio - radius, 0, None), np.minimum(ratio + radius, 2 * top)
        ax.vlines(omega, *ends, transform=place, color=_COLOURS[part], linewidth=0.7, alpha=0.55, zorder=2)
        dots += _dots(ax, omega, ratio, _codes(e, part)[drawn], part, place)
    thresholds = _thresholds(ax, e, scale)
    swept = draw_swept(ax, e, scale, _COLOURS) if e.scene.slopes else []
    dress(ax)
    if omega[0] > 0 and omega[-1] > 30 * omega[0]:
        ax.set_xscale("log")
        ax.tick_params(which="minor", width=0.4, length=1.5, color=GREY)
    name_frequency(ax, scale)
    ax.set_ylabel(r"ratio to $|H_\mathrm{env}|$", fontsize=TEXT)
    legend(ax, [*_told(e), *swept, *thresholds, *_thinned(e, len(drawn))])
    return dots


def _codes(e: MeasuredEvaluation, part: Part) -> Any:
    """What is told of a part, or of both where the region judges them together."""
    return e.joint.verdict if e.joint else e.verdict[part]


def _dots(ax: Axes, at: Any, ratio: Any, codes: Any, part: Part, place: Any) -> list[Line2D]:
    made: list[Line2D] = []
    is_cut = bool((ratio > ax.get_ylim()[1]).any())
    for told, face in ((codes != 0, _COLOURS[part]), (codes == 0, "white")):
        if told.any():
            made += ax.plot(
                at[told], ratio[told], linestyle="none", marker="os"[part is Part.IMAG], markersize=3.2, color=_COLOURS[part],
                markerfacecolor=face, markeredgewidth=0.7, zorder=3, transform=place, clip_on=is_cut,
            )  # fmt: skip
    return made


def _told(e: MeasuredEvaluation) -> list[Line2D]:
    """Entries of the legend: the parts, what a disc does not tell, and its bar."""
    shape: dict[str, Any] = {"linestyle": "none", "markersize": 3.2, "markeredgewidth": 0.7}
    parts = [
        Line2D([], [], color=_COLOURS[x], marker="os"[x is Part.IMAG], label=_SYMBOLS[x], **shape) for x in Part
    ]  # fmt: skip
    if any((_codes(e, part) == 0).any() for part in Part):
        parts.append(Line2D([], [], color=INK, marker="o", markerfacecolor="white", label="unresolved", **shape))
    if e.lines.radius is not None:
        parts.append(
            handle(GREY, "none", f"{100 * e.scene.perceived.confidence:.4g} % disc", 0.7, marker="|", markersize=6)
        )
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
        style: dict[str, Any] = {"color": GREY, "linewidth": 0.6, "linestyle": _STYLES[x]}
        if threshold[x].is_number:
            made.append(ax.axhline(float(threshold[x]), label=f"${name} = {float(threshold[x]):.3g}$", **style))
        else:
            made += ax.plot(scale.of(omega), values_of(threshold[x], omega), label=rf"${name}(\omega)$", **style)
    return made


def _drawn(e: MeasuredEvaluation) -> Any:
    return np.arange(0, len(e), -(-len(e) // _MOST_LINES))


def _thinned(e: MeasuredEvaluation, drawn: int) -> list[Line2D]:
    return [entry(f"{drawn} of {len(e)} lines are drawn")] if drawn < len(e) else []


def _scale(e: MeasuredEvaluation, *, hertz: bool | None = None) -> Scale:
    if hertz is not None:
        return HERTZ if hertz else RADIANS
    return band_scale(e.scene.band) if e.scene.band else floats_scale(e.lines.omega[:50])


def _beside(ax: Axes, side: int) -> Any:
    """The place of data, a little to the one side."""
    return ax.transData + ScaledTranslation(side * _APART / 72, 0, ax.figure.dpi_scale_trans)


def _span(omega: Any) -> tuple[float, float]:
    low, high = float(omega[0]), float(omega[-1])
    margin = 0.03 * (high - low) or 0.5 * high or 1.0
    return max(low - margin, 0.0 if low == 0 else 0.5 * low), high + margin


def _top(e: MeasuredEvaluation, radius: Any) -> float:
    """The upper end of the ratios: nearly all dots with their bars, and twice the thresholds."""
    drawn = _drawn(e)
    least = 2 * max(float(x.max()) for x in limits_of(e.scene, e.lines.omega).values())
    reach = np.maximum(np.abs(e.lines.change.real), np.abs(e.lines.change.imag))[drawn]
    reach = reach[np.isfinite(reach)]
    bars = (reach + radius[: len(reach)])[np.isfinite(radius[: len(reach)])]
    highest = [float(np.quantile(x, 0.95)) for x in (reach, bars) if len(x)]
    most = float(reach.max()) if len(reach) else 0.0
    return 1.08 * max(least, *highest, most if most < 3 * max(highest, default=0.0) else 0.0)


# The plane.


_LOOKS = ((1, RED, "exceeds in a part"), (0, GREY, "unresolved"), (-1, BLUE, "below in both parts"))


def draw_measured_nyquist(ax: Axes, e: MeasuredEvaluation) -> list[Line2D]:
    """H_env and the measured H_perc in the complex plane, a disc around each line, in the colour of what it tells.

    Returns the curve (or dots) of the environment and the dots of what is felt.
    """
    drawn = _drawn(e)
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    lines = _environment(ax, e, drawn)
    real, imag = (_codes(e, part) for part in Part)
    codes = np.where((real == 1) | (imag == 1), 1, np.where((real == -1) & (imag == -1), -1, 0))[drawn]
    felt, radius = e.lines.perceived[drawn], e.lines.perc_radius[drawn]
    for code, colour, label in _LOOKS:
        if (own := codes == code).any():
            _discs(ax, felt[own], radius[own], colour)
            lines += ax.plot(
                felt[own].real,
                felt[own].imag,
                linestyle="none",
                marker="o",
                markersize=2.4,
                color=colour,
                zorder=4,
                label=label,
            )
    _frame(ax, np.concatenate([e.lines.environment[drawn], felt]), radius)
    dress(ax)
    name_dynamics(ax.xaxis, r"\mathrm{Re}\,H", e.scene)
    name_dynamics(ax.yaxis, r"\mathrm{Im}\,H", e.scene)
    legend(ax, [*lines, *_thinned(e, len(drawn))])
    return lines


def _environment(ax: Axes, e: MeasuredEvaluation, drawn: Any) -> list[Line2D]:
    """A curve of the model, or dots with discs where the environment is measured too."""
    x, label = e.lines, r"$H_\mathrm{env}$"
    if isinstance(e.scene.environment, Measurement):
        _discs(ax, x.environment[drawn], x.env_radius[drawn], INK)
        env = x.environment[drawn]
        return ax.plot(env.real, env.imag, linestyle="none", marker="x", markersize=3, color=INK, zorder=3, label=label)
    omega = np.union1d(np.linspace(x.omega[0], x.omega[-1], 801), x.omega[drawn])
    values = e.scene.frame.distortion().compile(of=["environment_real", "environment_imag"])(omega)
    made = ax.plot(values.environment_real, values.environment_imag, color=INK, linewidth=1.1, zorder=2, label=label)
    env = x.environment[drawn]
    ax.plot(env.real, env.imag, linestyle="none", marker="|", markersize=4, color=INK, zorder=3)
    return made


def _discs(ax: Axes, centres: Any, radii: Any, colour: str) -> None:
    seen = np.isfinite(radii) & (radii > 0)
    circles = [Circle((c.real, c.imag), r) for c, r in zip(centres[seen], radii[seen], strict=True)]
    ax.add_collection(PatchCollection(circles, facecolor=colour, edgecolor=colour, alpha=0.22, linewidth=0.5, zorder=1))


def _frame(ax: Axes, points: Any, radius: Any) -> None:
    """Limits that hold the points and most of their discs; equal scales where that leaves a drawing."""
    known = radius[np.isfinite(radius)]
    reach = float(np.quantile(known, 0.9)) if len(known) else 0.0
    sides = [(float(x.min()) - reach, float(x.max()) + reach) for x in (points.real, points.imag)]
    margin = 0.05 * max(high - low for low, high in sides) or 1.0
    limit(ax, *((low - margin, high + margin) for low, high in sides))
    width, height = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
    ax.set_aspect("equal" if 0.25 < width / height < 4 else "auto", adjustable="box")


# Files.


def measured_figure(e: MeasuredEvaluation) -> Figure:
    """The ratios, one column of a journal."""
    return draw_measured_figure(e, "ratios")


def draw_measured_figure(e: MeasuredEvaluation, name: str, *, wide: bool = False) -> Figure:
    """One of the figures by its name, one column wide, or one and a half."""
    height, draw = _DRAWINGS[name]
    return one_column(height, lambda ax: draw(ax, e), 1.5 * WIDTH if wide else WIDTH)


def save_measured_figures(
    e: MeasuredEvaluation, directory: str | Path, kinds: Iterable[str] = tuple(UNDATED)
) -> list[Path]:
    """All figures as SVG, PDF and PNG, or as some of them, in a directory that is made if need be."""
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    names = [name for name in _DRAWINGS if name != "plane" or e.joint]
    return [path for name in names for path in save(folder / name, draw_measured_figure(e, name), kinds)]


_DRAWINGS: Mapping[str, tuple[float, Callable[[Axes, MeasuredEvaluation], object]]] = MappingProxyType({
    "ratios": (2.1, draw_measured_ratios),
    "nyquist": (2.6, draw_measured_nyquist),
    "plane": (2.8, draw_measured_plane),
})  # fmt: skip
