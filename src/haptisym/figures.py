"""Figures of an evaluation, after the paper's: ratios, Nyquist plot, projections and JND square.

Each ``draw_`` function draws on the axes that it is given and changes nothing else; ``save_figures`` writes them all to
files. Curves are sampled as finely as they bend, with every proven frequency of the evaluation (crossings, changeovers,
poles) among the samples, so that nothing that decides something falls between two of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FuncFormatter, MaxNLocator, ScalarFormatter
from matplotlib.transforms import ScaledTranslation
from sympy import Expr, Poly, PolynomialError, fraction

from .crossings import Curve
from .distortion import Distortion
from .errors import SceneError
from .evaluation import Evaluation
from .exact.roots import Interval, Point
from .jnd import Part
from .numeric.values import Array, Values
from .quantities import Motion
from .symbols import s

WIDTH = 3.4
"""Inches: one column of a journal."""
TEXT, SMALL = 8.0, 7.0
"""Points: labels of axes; ticks, legends and notes."""
INK, BLUE, RED, GREY, SHADE = "#222222", "#1f4e9e", "#c03028", "#7a7a7a", "#e6e6e6"
_SOLID: Any = "-"
_DASHED: Any = (0, (4, 1.6))
_DOTTED: Any = (0, (1, 2))
_LEADER = {"arrowstyle": "-", "linewidth": 0.5, "color": GREY, "shrinkA": 0, "shrinkB": 0}
_CURVES = ((BLUE, _SOLID, r"H_\mathrm{env}"), (RED, _DASHED, r"H_\mathrm{perc}"))
_FREQUENCY = r"$\omega$ (rad/s)"
_FULL_NAMES = {Part.REAL: "real", Part.IMAG: "imaginary"}
_MOST_LABELS, _MOST_NUMBERS = 4, 8

# When: the ratios (Fig. 5).


def draw_ratios(ax: Axes, evaluation: Evaluation) -> None:
    """r_r and r_i over the band with their thresholds, crossings and the transparent bands in grey (the paper's Fig. 5).

    The axis is cut where a ratio is unbounded or has a narrow high peak; how high that is, and where, stands above it.
    """
    f, limits = evaluation.distortion.compile(), _limits(evaluation)
    grid = _grid(evaluation)
    top = max(_top(_ratios(f, grid), _ratios(f, _evenly(evaluation)), max(limits)), 2 * max(limits))
    omega = _refined(lambda w: _in_window(_ratios(f, w), 0, top), grid)
    ratios = _broken(_ratios(f, omega), omega, evaluation.unbounded)
    _shade(ax, evaluation.transparent)
    for values, c, style in zip(ratios.T, limits, (_SOLID, _DASHED), strict=True):
        ax.axhline(c, color=GREY, linewidth=0.6, linestyle=style if len(set(limits)) > 1 else _SOLID)
        ax.plot(omega, values, color=INK, linewidth=1.1, linestyle=style)
    ax.set(xlim=_band(evaluation), ylim=(0, top))
    _dress(ax)
    ax.set_xlabel(_FREQUENCY, fontsize=TEXT)
    ax.set_ylabel(r"ratio to $|H_\mathrm{env}|$", fontsize=TEXT)
    _mark_crossings(ax, evaluation)
    _label_above(ax, _frequency_labels(evaluation, omega, ratios.max(axis=1), top))
    _legend(ax, _ratio_handles(evaluation), lines=1)


def _limits(evaluation: Evaluation) -> tuple[float, float]:
    threshold = evaluation.scene.threshold
    return float(threshold.real), float(threshold.imag)


def _ratios(f: Callable[..., Values], omega: Array) -> Array:
    values = f(omega)
    return np.stack([values.ratio_real, values.ratio_imag], axis=1)


def _mark_crossings(ax: Axes, evaluation: Evaluation) -> None:
    """A dot where r_r, a ring where r_i meets its threshold."""
    for part, c, face in zip(Part, _limits(evaluation), (INK, "white"), strict=True):
        omega = [float(crossing.omega) for crossing in evaluation.crossings if crossing.part is part]
        if not omega:  # an unclipped line without points would upset the layout
            continue
        ax.plot(
            omega, [c] * len(omega), linestyle="none", marker="o", markersize=3.6, color=INK,
            markerfacecolor=face, markeredgewidth=0.8, zorder=4, clip_on=False,
        )  # fmt: skip


def _frequency_labels(evaluation: Evaluation, omega: Array, highest: Array, top: float) -> list[tuple[float, str]]:
    """What stands above the axes: crossing frequencies while they are few, and the two highest peaks that are cut."""
    crossings = [(float(c.omega), c.omega.digits(4)) for c in evaluation.crossings]
    values = np.where(np.isnan(highest), np.inf, highest)
    peaks = [(float(omega[i]), f"{_height(values[i])} at {omega[i]:.4g}") for i in _peaks(values, top)[:2]]
    return (crossings if len(crossings) <= _MOST_LABELS else []) + peaks


def _peaks(values: Array, top: float) -> list[int]:
    """Of each run of samples above the top the highest, the highest of all first."""
    runs = [list(run) for above, run in groupby(range(len(values)), key=lambda i: bool(values[i] > top)) if above]
    return sorted((max(run, key=lambda i: values[i]) for run in runs), key=lambda i: -values[i])


def _height(value: float) -> str:
    return "∞" if np.isinf(value) else f"{float(f'{value:.2g}'):g}"


def _ratio_handles(evaluation: Evaluation) -> list[Any]:
    limits = _limits(evaluation)
    names = (r"c_\mathrm{r}", r"c_\mathrm{i}") if len(set(limits)) > 1 else ("c",)
    thresholds = [
        _line(GREY, style, f"${name} = {c:.3g}$", 0.6)
        for name, c, style in zip(names, limits, (_SOLID, _DASHED), strict=False)
    ]
    shade = Patch(facecolor=SHADE, label="transparent") if evaluation.transparent else _words("nowhere transparent")
    count = len(evaluation.crossings)
    counted = [_words(f"{count} crossings")] if count > _MOST_LABELS else []
    return [_line(INK, _SOLID, r"$r_\mathrm{r}$"), _line(INK, _DASHED, r"$r_\mathrm{i}$"), *thresholds, shade, *counted]


# How: the Nyquist plot (Fig. 6).


def draw_nyquist(ax: Axes, evaluation: Evaluation, marks: Sequence[float] | None = None) -> None:
    """H_env and H_perc in the complex plane over the band (the paper's Fig. 6), with arrows towards higher frequencies.

    ``marks``: frequencies, rad/s, marked alike on both curves; about a third, two thirds and the end of the band if not
    given. Where a dynamics is infinite, or far from where it is on most of the band, its curve leaves the axes.
    """
    f, grid = evaluation.distortion.compile(), _grid(evaluation)
    low, high = _window(_responses(f, grid), _responses(f, _evenly(evaluation)))
    omega = _refined(lambda w: _in_window(_responses(f, w), np.tile(low, 2), np.tile(high, 2)), grid)
    values = _broken(_responses(f, omega), omega, _poles(evaluation))
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    marked = np.asarray(_default_marks(evaluation, f, (low, high)) if marks is None else marks, dtype=float)
    for points, (color, style, _), share in zip(_points(values), _CURVES, (0.42, 0.58), strict=True):
        ax.plot(*points.T, color=color, linestyle=style, linewidth=1.1)
        length = _visible_length((points - low) / (high - low))
        for tail, head in _directions(length, np.interp(marked, omega, length), share):
            _arrow(ax, points[tail], points[head], color)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    width, height = high - low
    if 0.25 < width / height < 4:
        ax.set_aspect("equal", adjustable="box")
    _dress(ax)
    _name_dynamics(ax.xaxis, r"\mathrm{Re}\,H", evaluation)
    _name_dynamics(ax.yaxis, r"\mathrm{Im}\,H", evaluation)
    _legend(ax, [*_curve_handles("", ""), *_mark_frequencies(ax, f, marked)])


def _responses(f: Callable[..., Values], omega: Array) -> Array:
    """Re and Im of H_env, then of H_perc, in four columns."""
    values = f(omega)
    return np.stack(
        [values.environment_real, values.environment_imag, values.perceived_real, values.perceived_imag], axis=1
    )


def _points(responses: Array) -> tuple[Array, Array]:
    """H_env and H_perc as points of the plane."""
    return responses[:, :2], responses[:, 2:]


def _window(everywhere: Array, evenly: Array) -> tuple[Array, Array]:
    """The lower left and upper right corner that hold both curves, but for excursions far from most of the band."""
    reached, common = (points[np.isfinite(points).all(axis=1)] for points in map(_stacked, (everywhere, evenly)))
    first, last = np.quantile(common, (0.05, 0.95), axis=0)
    least, most, span = reached.min(axis=0), reached.max(axis=0), last - first
    far = 4 * span.max()
    low, high = np.where(least < first - far, first - span, least), np.where(most > last + far, last + span, most)
    size = np.maximum(high - low, 0.1 * (np.max(high - low) or np.abs(low).max() or 1.0))
    middle = (low + high) / 2
    return middle - 0.56 * size, middle + 0.56 * size


def _stacked(responses: Array) -> Array:
    return np.concatenate(_points(responses))


def _visible_length(points: Array) -> Array:
    """The length of a curve, given in fractions of the axes, from its start to each sample, as far as it is on them."""
    visible: Any = (np.abs(points - 0.5) <= 0.5).all(axis=1)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(np.where(visible[1:] & visible[:-1], steps, 0.0))])


def _directions(length: Array, marked: Array, share: float) -> list[tuple[int, int]]:
    """Tail and head samples of arrows in the two longest pieces of a curve between its marks; none on mere spots."""
    edges = np.unique([0.0, *marked, length[-1]])
    longest = np.argsort(np.diff(edges))[-2:]
    heads = [edges[i] + share * (edges[i + 1] - edges[i]) for i in longest if edges[i + 1] - edges[i] > 0.1]
    return [(int(np.searchsorted(length, head - 0.01)) - 1, int(np.searchsorted(length, head))) for head in heads]


def _arrow(ax: Axes, tail: Array, head: Array, color: str) -> None:
    head_style = "-|>, head_length=0.65, head_width=0.27"
    style = {"arrowstyle": head_style, "color": color, "linewidth": 0, "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(head[0], head[1]), xytext=(tail[0], tail[1]), arrowprops=style)


def _default_marks(evaluation: Evaluation, f: Callable[..., Values], window: tuple[Array, Array]) -> tuple[float, ...]:
    """About a third, two thirds and the end of the frequencies at which both curves are on the axes, as short numbers."""
    low, high = _band(evaluation)
    omega = _evenly(evaluation)
    places = _in_window(_responses(f, omega), np.tile(window[0], 2), np.tile(window[1], 2))
    inside = omega[(np.abs(places - 0.5) <= 0.5).all(axis=1)]
    step = 10.0 ** (np.floor(np.log10(high - low)) - 1)
    chosen = inside[[round(share * (len(inside) - 1)) for share in (1 / 3, 2 / 3, 1)]]
    rounded = np.minimum(np.round(chosen / step), np.floor(inside[-1] / step + 1e-9)) * step
    return tuple(dict.fromkeys(max(low, float(f"{x:.12g}")) for x in rounded))


def _mark_frequencies(ax: Axes, f: Callable[..., Values], marks: Array) -> list[Line2D]:
    """The same marker on both curves at each frequency, and what the legend says of it."""
    handles = []
    for omega, marker in zip(marks, "osDv^*" * len(marks), strict=False):
        look: dict[str, Any] = {"marker": marker, "markersize": 4.2, "markeredgewidth": 0.9, "linestyle": "none"}
        for [point], (color, _, _), face in zip(
            _points(_responses(f, np.array([omega]))), _CURVES, (BLUE, "white"), strict=True
        ):
            ax.plot(*point, color=color, markerfacecolor=face, zorder=4, **look)
        handles.append(Line2D([], [], color=INK, markerfacecolor="none", label=f"{omega:g} rad/s", **look))
    return handles


# How: the projections (Fig. 7).


@dataclass(frozen=True)
class _Label:
    """What is felt from ``low`` to ``high``, in words."""

    low: float
    high: float
    words: str


def draw_projections(ax: Axes, evaluation: Evaluation, part: Part) -> None:
    """``|Re|`` or ``|Im|`` of H_env and H_perc over the band (the paper's Fig. 7a and 7b).

    Bold where the part's ratio exceeds its threshold, with the percept in words; thin on grey where it does not.
    """
    f, grid, labels = evaluation.distortion.compile(), _grid(evaluation), _percept_labels(evaluation, part)
    noticed = evaluation.chart.where(lambda signs: signs[Curve.EXCESS, part] > 0)
    unnoticed = evaluation.chart.where(lambda signs: signs[Curve.EXCESS, part] <= 0)
    top = 1.3 * _top(_magnitudes(f, grid, part), _magnitudes(f, _evenly(evaluation), part)) or 1.0
    omega = _refined(lambda w: _in_window(_magnitudes(f, w, part), 0, top), grid)
    values = _broken(_magnitudes(f, omega, part), omega, _poles(evaluation))
    _shade(ax, unnoticed)
    for magnitude, (color, style, _) in zip(values.T, _CURVES, strict=True):
        for weight, where in ((1.6, noticed), (0.7, unnoticed)):
            shown = np.where(_within(omega, where), magnitude, np.nan)
            ax.plot(omega, shown, color=color, linestyle=style, linewidth=weight)
    ax.set(xlim=_band(evaluation), ylim=(0, top))
    name = rf"\mathrm{{{'Re' if part is Part.REAL else 'Im'}}}"
    _dress(ax)
    ax.set_xlabel(_FREQUENCY, fontsize=TEXT)
    _name_dynamics(ax.yaxis, rf"|{name}\,H|", evaluation)
    shade = [Patch(facecolor=SHADE, label="not noticed")] if unnoticed else []
    _draw_boundaries(ax, labels)
    numbered = _write_percepts(ax, labels)
    _legend(ax, [*_curve_handles(rf"|{name}\,", "|"), *shade, *numbered])
    if not labels:
        _note(ax, "never exceeds the threshold")


def _magnitudes(f: Callable[..., Values], omega: Array, part: Part) -> Array:
    return np.abs(_responses(f, omega)[:, (0 if part is Part.REAL else 1) :: 2])


def _percept_labels(evaluation: Evaluation, part: Part) -> list[_Label]:
    """The percepts of a part, and where it is noticed but active, so that the paper's model has no percept for it."""
    percepts = [
        _Label(*_ends(p.band), f"{p.property.value}, {p.change.value}") for p in evaluation.percepts if p.part is part
    ]
    active = evaluation.chart.where(
        lambda signs: signs[Curve.EXCESS, part] > 0 and part is Part.IMAG and signs[Curve.PERCEIVED, part] < 0
    )
    return sorted([*percepts, *(_Label(*_ends(x), "active, no percept") for x in active)], key=lambda label: label.low)


def _within(omega: Array, intervals: Iterable[Interval]) -> Any:
    """Which samples lie on closed intervals."""
    found = np.zeros(omega.shape, dtype=bool)
    for low, high in map(_ends, intervals):
        found |= (omega >= low) & (omega <= high)
    return found


def _write_percepts(ax: Axes, labels: Sequence[_Label]) -> list[Line2D]:
    """The words of each percept inside its band, or a number where it is too narrow, and the legend of these numbers."""
    fitting = {label: text for label in labels if (text := _fitting(ax, label))}
    narrow = sorted((x for x in labels if x not in fitting), key=lambda x: x.low - x.high)
    named = sorted(narrow[:_MOST_NUMBERS], key=lambda x: x.low)
    numbers = {words: str(n) for n, words in enumerate(dict.fromkeys(x.words for x in named), 1)}
    _write_inside(ax, {x: fitting.get(x) or numbers[x.words] for x in labels if x in fitting or x in named})
    handles = [
        _line(INK, "none", words, marker=f"${n}$", markersize=4, markeredgewidth=0) for words, n in numbers.items()
    ]
    return handles + ([_words(f"and {len(narrow) - len(named)} narrower")] if len(narrow) > len(named) else [])


def _write_inside(ax: Axes, texts: Mapping[_Label, str]) -> None:
    """Texts side by side at the top of the axes, each in its band or tied to it."""
    centres = [_share(ax, (label.low + label.high) / 2) for label in texts]
    places = _spread(centres, [_text_width(ax, text) for text in texts.values()])
    for (label, text), centre, place in zip(texts.items(), centres, places, strict=True):
        beside = abs(place - centre) > _share(ax, label.high) - centre
        ax.annotate(
            text, xy=(centre, 0.82), xytext=(place, 0.98), xycoords="axes fraction", textcoords="axes fraction",
            ha="center", va="top", fontsize=SMALL, linespacing=1.1, bbox=_plate("white"),
            arrowprops=_LEADER if beside else None,
        )  # fmt: skip


def _fitting(ax: Axes, label: _Label) -> str:
    """The words on one line or two, as fits into the band; nothing if neither does."""
    room = _share(ax, label.high) - _share(ax, label.low)
    layouts = (label.words, label.words.replace(", ", ",\n"))
    return next((text for text in layouts if _text_width(ax, text) <= room), "")


def _draw_boundaries(ax: Axes, labels: Iterable[_Label]) -> None:
    for omega in sorted({x for label in labels for x in (label.low, label.high)} - set(ax.get_xlim())):
        ax.axvline(omega, color=GREY, linewidth=0.5, linestyle=_DOTTED, zorder=1)


def _plate(color: str) -> dict[str, Any]:
    """What keeps a text readable on a curve."""
    return {"facecolor": color, "edgecolor": "none", "pad": 0.6}


def _note(ax: Axes, text: str) -> None:
    ax.text(0.5, 0.97, text, transform=ax.transAxes, ha="center", va="top", fontsize=SMALL, bbox=_plate(SHADE))


# Noticed or not: the JND square (Figs. 2 and 3).


def draw_jnd_square(ax: Axes, evaluation: Evaluation, omega: float) -> None:
    """H_env and H_perc at one frequency of the band, rad/s, with the region of changes that are not noticed (Fig. 2).

    The region is c_real ``|H_env|`` wide and c_imag ``|H_env|`` high to each side of the tip of H_env; its projections are
    bars on the axes. Raises SceneError outside the band and where H_env or H_perc is infinite.
    """
    noticed = [part for part in Part if _sign_at(evaluation, omega, (Curve.EXCESS, part)) > 0]
    tips = _stacked(_responses(evaluation.distortion.compile(), np.array([omega])))
    if not np.isfinite(tips).all():
        raise SceneError(f"omega: the dynamics are infinite at {omega:g} rad/s")
    reach = np.array(_limits(evaluation)) * np.hypot(*tips[0])
    _draw_region(ax, tips[0], reach)
    for tip, (color, style, _) in zip(tips, _CURVES, strict=True):
        _draw_vector(ax, tip, color, style)
    _frame(ax, np.array([[0, 0], *tips, tips[0] - reach, tips[0] + reach]))
    _dress(ax)
    _name_dynamics(ax.xaxis, r"\mathrm{Re}\,H", evaluation)
    _name_dynamics(ax.yaxis, r"\mathrm{Im}\,H", evaluation)
    region = Patch(facecolor=SHADE, edgecolor=GREY, linewidth=0.6, label="not noticed")
    _legend(ax, [*_curve_handles("", ""), region])
    ax.set_title(rf"$\omega$ = {omega:.4g} rad/s: {_verdict(noticed)}", fontsize=TEXT, pad=2.2 * SMALL)


def _verdict(noticed: Sequence[Part]) -> str:
    if not noticed:
        return "not noticed"
    return f"noticed in {'both parts' if len(noticed) == 2 else f'the {_FULL_NAMES[noticed[0]]} part'}"


def _sign_at(evaluation: Evaluation, omega: float, key: tuple[Curve, Part]) -> int:
    """The proven sign of a function of the chart at a frequency."""
    points = evaluation.chart.points
    below = [point for point in points if float(point.omega) <= omega]
    if not below or omega > float(points[-1].omega):
        raise SceneError(
            f"omega: {omega:g} rad/s is not on the band, {' to '.join(f'{x:g}' for x in _band(evaluation))}"
        )
    return below[-1].at[key] if float(below[-1].omega) == omega else below[-1].after[key]


def _draw_region(ax: Axes, tip: Array, reach: Array) -> None:
    """The region of changes that are not noticed, and its projections on the axes."""
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    corner, size = tip - reach, 2 * reach
    ax.add_patch(Rectangle((corner[0], corner[1]), *size, facecolor=SHADE, edgecolor=GREY, linewidth=0.6, zorder=1))
    bar: dict[str, Any] = {"color": GREY, "alpha": 0.5, "linewidth": 3, "solid_capstyle": "butt", "zorder": 1}
    ax.plot([corner[0], corner[0] + size[0]], [0, 0], **bar)
    ax.plot([0, 0], [corner[1], corner[1] + size[1]], **bar)


def _draw_vector(ax: Axes, tip: Array, color: str, style: Any) -> None:
    """An arrow from the origin, and the projections of its tip on both axes."""
    ax.plot([tip[0], tip[0], 0], [0, tip[1], tip[1]], color=color, linewidth=0.6, linestyle=_DOTTED, zorder=2)
    ax.plot([0, tip[0]], [0, tip[1]], color=color, linewidth=1.2, linestyle=style, zorder=3)
    if tip.any():
        _arrow(ax, 0.95 * tip, tip, color)
    else:
        ax.plot([0], [0], color=color, marker="o", markersize=3.6, zorder=3)


def _frame(ax: Axes, points: Array) -> None:
    """Limits that hold the points with a margin, at equal scales, neither very wide nor very high."""
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.57 * np.maximum(high - low, 0.6 * np.max(high - low) or 1.0)
    low, high = (low + high) / 2 - half, (low + high) / 2 + half
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ax.set_aspect("equal", adjustable="box")


# Files.


def save_figures(evaluation: Evaluation, directory: str | Path) -> list[Path]:
    """All figures as SVG, PDF and PNG, one column (3.4 in) wide, in a directory that is made if need be.

    The same evaluation gives the same files, byte for byte.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    drawings: dict[str, tuple[float, Callable[[Axes], None]]] = {
        "ratios": (2.1, lambda ax: draw_ratios(ax, evaluation)),
        "nyquist": (2.6, lambda ax: draw_nyquist(ax, evaluation)),
        "projections-real": (2.0, lambda ax: draw_projections(ax, evaluation, Part.REAL)),
        "projections-imag": (2.0, lambda ax: draw_projections(ax, evaluation, Part.IMAG)),
        "jnd-square": (2.6, lambda ax: draw_jnd_square(ax, evaluation, _telling_frequency(evaluation))),
    }
    return [path for name, (height, draw) in drawings.items() for path in _save(folder / name, _figure(height, draw))]


def _telling_frequency(evaluation: Evaluation) -> float:
    """The middle of the first percept band, else the end of the band; beside it if a dynamics is infinite there."""
    low, high = _ends(evaluation.percepts[0].band) if evaluation.percepts else _band(evaluation)
    shares = (0.5, 0.4, 0.6, 0.45, 0.55) if evaluation.percepts else (1.0, 0.9, 0.8, 0.95, 0.85)
    infinite = {float(pole.omega) for pole in _poles(evaluation)}
    return next(x for x in (low + share * (high - low) for share in shares) if x not in infinite)


def _save(stem: Path, figure: Figure) -> list[Path]:
    undated: dict[str, dict[str, Any]] = {
        "svg": {"Date": None},
        "pdf": {"CreationDate": None},
        "png": {"Software": None},
    }
    paths = [stem.with_name(f"{stem.name}.{kind}") for kind in undated]
    for path, metadata in zip(paths, undated.values(), strict=True):
        with mpl.rc_context({"svg.hashsalt": "haptisym", "pdf.fonttype": 42}):
            figure.savefig(path, metadata=metadata, dpi=400)
    return paths


def _figure(height: float, draw: Callable[[Axes], None]) -> Figure:
    """A drawing of that height, in inches, without its legend; one with equal scales takes the height that it needs."""
    figure = Figure(figsize=(WIDTH, height), layout="compressed")
    ax = figure.add_subplot()
    draw(ax)
    figure.draw_without_rendering()
    if ax.get_aspect() == 1:
        height = min(0.7 + 2.8 * ax.get_data_ratio(), 3.6)
    figure.set_figheight(height + _legend_height(ax))
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out once, so that all files look the same
    return figure


def _legend_height(ax: Axes) -> float:
    legend = ax.get_legend()
    return legend.get_window_extent().height / ax.figure.dpi if legend else 0.0


# Sampling.


def _band(evaluation: Evaluation) -> tuple[float, float]:
    points = evaluation.chart.points
    return float(points[0].omega), float(points[-1].omega)


def _ends(interval: Interval) -> tuple[float, float]:
    return float(interval.low.omega), float(interval.high.omega)


def _evenly(evaluation: Evaluation) -> Array:
    return np.linspace(*_band(evaluation), 801)


def _grid(evaluation: Evaluation) -> Array:
    """Even frequencies, all points of the chart, and ever closer ones around these and around resonances."""
    low, high = _band(evaluation)
    points = np.array([float(point.omega) for point in evaluation.chart.points])
    steps = (high - low) * 2.0 ** -np.arange(3, 34)
    centres = np.concatenate([points, _resonances(evaluation.distortion)])
    around = (centres[:, None] + np.concatenate([-steps, [0.0], steps])).ravel()
    return np.unique(np.concatenate([_evenly(evaluation), points, around[(around > low) & (around < high)]]))


def _resonances(distortion: Distortion) -> Array:
    """The frequencies of all poles and zeros of H_env and H_perc: a lightly damped one makes a narrow feature."""
    polynomials = [p for H in (distortion.environment, distortion.perceived) for p in fraction(H)]
    return np.concatenate([_frequencies_of_roots(p) for p in polynomials])


def _frequencies_of_roots(polynomial: Expr) -> Array:
    try:
        coefficients = Poly(polynomial, s).all_coeffs()
    except PolynomialError:  # H(s) is transcendental: the points of the chart have to do
        return np.array([])
    found: Array = np.abs(np.roots([complex(c / coefficients[0]) for c in coefficients]).imag)
    return found


def _refined(seen: Callable[[Array], Array], grid: Array) -> Array:
    """The grid, halved wherever a straight line strays from what is ``seen`` by more than 1/2000 of the axes."""
    for _ in range(10):
        ends, middle = seen(grid), (grid[1:] + grid[:-1]) / 2
        bent = (np.abs(seen(middle) - (ends[1:] + ends[:-1]) / 2) > 5e-4).any(axis=1)
        if not bent.any():
            break
        grid = np.union1d(grid, middle[bent])
    return grid


def _in_window(values: Array, low: Any, high: Any) -> Array:
    """Values as fractions of the axes, those far outside brought near."""
    inside: Array = np.clip(np.nan_to_num((values - low) / (high - low), nan=2, posinf=2, neginf=-1), -1, 2)
    return inside


def _broken(values: Array, omega: Array, poles: Iterable[Point]) -> Array:
    """Values with a gap at each pole, so that no line is drawn through infinity."""
    gaps = np.isin(omega, [float(point.omega) for point in poles]) | ~np.isfinite(values).all(axis=1)
    broken: Array = np.where(gaps[:, None], np.nan, values)
    return broken


def _poles(evaluation: Evaluation) -> list[Point]:
    """Where H_env or H_perc is infinite."""
    keys = [(curve, part) for curve in (Curve.ENVIRONMENT, Curve.PERCEIVED) for part in Part]
    return [point for point in evaluation.chart.points if any(point.orders.get(key, 0) < 0 for key in keys)]


def _top(everywhere: Array, evenly: Array, least: float = 0.0) -> float:
    """The upper end of an axis from 0: the highest value, unless that is a narrow peak far above most others."""
    highest, upper = float(np.nanmax(everywhere)), evenly.max(axis=1)
    most, nearly_all = np.quantile(upper[np.isfinite(upper)], (0.75, 0.9))
    return 1.06 * highest if highest <= 3 * nearly_all else max(2.5 * float(most), 4 * least)


# What the figures share.


def _dress(ax: Axes) -> None:
    """Thin lines, no box, few and plain numbers."""
    ax.tick_params(labelsize=SMALL, width=0.5, length=2.5, color=GREY)
    ax.spines[["top", "right"]].set_visible(False)
    for spine in ax.spines.values():
        spine.set(linewidth=0.5, color=GREY)
    for axis in (ax.xaxis, ax.yaxis):
        plain = ScalarFormatter(useOffset=False)
        plain.set_scientific(False)
        axis.set_major_formatter(plain)
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))


def _name_dynamics(axis: Axis, name: str, evaluation: Evaluation) -> None:
    """The label of an axis of force per position, in thousands or millions of its unit where numbers are large."""
    most = np.abs(axis.get_view_interval()).max()
    factor, prefix = next(((f, p) for f, p in ((1e6, "M"), (1e3, "k")) if most >= 100 * f), (1.0, ""))
    unit = "N·m/rad" if evaluation.scene.motion is Motion.ROTATION else "N/m"
    axis.set_label_text(f"${name}$ ({prefix}{unit})", fontsize=TEXT)
    if prefix:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / factor:g}".replace("-", "−")))


def _shade(ax: Axes, intervals: Iterable[Interval]) -> None:
    for low, high in map(_ends, intervals):
        if low == high:
            ax.axvline(low, color=SHADE, linewidth=1, zorder=0)
        else:
            ax.axvspan(low, high, facecolor=SHADE, linewidth=0, zorder=0)


def _label_above(ax: Axes, labels: Iterable[tuple[float, str]]) -> None:
    """Texts side by side on top of the axes, each tied to its frequency."""
    ordered = sorted(labels)
    places = _spread([_share(ax, x) for x, _ in ordered], [_text_width(ax, text) for _, text in ordered])
    for (x, text), place in zip(ordered, places, strict=True):
        ax.axvline(x, color=GREY, linewidth=0.5, linestyle=_DOTTED, zorder=1)
        ax.annotate(
            text, xy=(_share(ax, x), 1), xytext=(place, 1.05), xycoords="axes fraction", textcoords="axes fraction",
            ha="center", va="bottom", fontsize=SMALL, arrowprops=_LEADER,
        )  # fmt: skip


def _spread(centres: Sequence[float], widths: Sequence[float]) -> Array:
    """Places near the wanted ones, in the same order, at which labels of these widths stand side by side within 0 to 1.

    >>> _spread([0.1, 0.5, 0.52], [0.1, 0.1, 0.1]).round(2).tolist()
    [0.1, 0.46, 0.56]
    """
    offsets = np.cumsum(widths) - np.asarray(widths) / 2
    free = np.asarray(centres) - offsets
    free = (np.maximum.accumulate(free) + np.minimum.accumulate(free[::-1])[::-1]) / 2
    return np.clip(free, 0, max(0.0, 1 - sum(widths))) + offsets


def _share(ax: Axes, x: float) -> float:
    """Where a frequency is on the axes, from 0 to 1."""
    low, high = ax.get_xlim()
    return (x - low) / (high - low)


def _text_width(ax: Axes, text: str) -> float:
    """About the width of a small text with a margin, as a fraction of the axes."""
    return (0.54 * max(map(len, text.split("\n"))) + 0.7) * _em(ax)


def _em(ax: Axes) -> float:
    """The size of a small text, as a fraction of the width of the axes."""
    return SMALL * ax.figure.dpi / (72 * ax.bbox.width)


def _legend(ax: Axes, handles: Sequence[Line2D | Patch], *, lines: int = 0) -> None:
    """The legend above the axes, where no curve is, and above that many lines of other text."""
    raised = ScaledTranslation(0, (0.5 + 1.9 * lines) * SMALL / 72, ax.figure.dpi_scale_trans)
    ax.legend(
        handles=handles, ncols=_columns(ax, handles), loc="lower left", bbox_to_anchor=(0, 1),
        bbox_transform=ax.transAxes + raised, borderaxespad=0, borderpad=0, fontsize=SMALL, frameon=False,
        handlelength=2.2, handletextpad=0.5, columnspacing=1.2, labelspacing=0.3,
    )  # fmt: skip


def _columns(ax: Axes, handles: Sequence[Line2D | Patch]) -> int:
    """The most columns of a legend that together are no wider than the axes."""
    widths = [_text_width(ax, _as_seen(str(handle.get_label()))) + 3.2 * _em(ax) for handle in handles]
    for columns in range(len(handles), 1, -1):
        if sum(max(column) for column in np.array_split(widths, columns)) - 1.2 * _em(ax) <= 1.05:
            return columns
    return 1


def _as_seen(label: str) -> str:
    """A label without the marks of its mathematics."""
    return re.sub(r"\\[a-z]+|[\\${}_,]", "", label)


def _curve_handles(before: str, after: str) -> list[Line2D]:
    return [_line(color, style, f"${before}{name}{after}$") for color, style, name in _CURVES]


def _line(color: str, style: Any, label: str, width: float = 1.1, **marker: Any) -> Line2D:
    return Line2D([], [], color=color, linestyle=style, linewidth=width, label=label, **marker)


def _words(label: str) -> Line2D:
    """A legend entry of words alone."""
    return _line(INK, "none", label)
