"""What figures share: lines, colours, numbers, names, labels and axes.

In which unit an axis of frequencies is drawn: Hz where the scene says Hz, rad/s elsewhere.

What figures share: thin lines, colours, numbers and names as they are set, legends above the axes.

What is marked along an axis of frequencies: bands, and labels above it, each tied to its place, that do not meet.

Names beside points that meet neither each other, nor points, lines or the edge of the axes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from math import tau
from typing import Any, Protocol

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Annotation
from matplotlib.ticker import FuncFormatter, MaxNLocator, ScalarFormatter
from matplotlib.transforms import ScaledTranslation
from sympy import Expr, Symbol, pi

from haptisym.figures import pen
from haptisym.figures.sampling import ends_of
from haptisym.judge.crossings import Criterion
from haptisym.kernel.reals import Hertz, RealNumber
from haptisym.kernel.roots import Interval
from haptisym.model.quantities import MotionKind, unit_text
from haptisym.programs.values import Array
from haptisym.writing.latex import formula


@dataclass(frozen=True)
class Scale:
    """A unit of frequency: its name, the label of its axis, and how many rad/s it is."""

    unit: str
    label: str
    factor: float

    def of(self, omega: Any) -> Any:
        """Frequencies, rad/s, in this unit."""
        return omega if self.factor == 1 else omega / self.factor

    def digits(self, omega: RealNumber, count: int) -> str:
        """A frequency to that many correct digits in this unit."""
        return (omega if self.factor == 1 else Hertz(omega)).digits(count)


RADIANS = Scale("rad/s", r"$\omega$ (rad/s)", 1.0)
HERTZ = Scale("Hz", "frequency (Hz)", tau)


def scale_of(ax: Axes, band: Iterable[Expr], *, hertz: bool | None = None) -> Scale:
    """The unit of the horizontal axis: what was asked for, else the one that it has, else that of the band."""
    return wanted_scale(hertz=hertz) or labelled_scale(ax.get_xlabel()) or band_scale(band)


def wanted_scale(*, hertz: bool | None) -> Scale | None:
    """What was asked for; None where nothing was."""
    return None if hertz is None else HERTZ if hertz else RADIANS


def labelled_scale(label: str) -> Scale | None:
    """That of an axis with this label; None where that tells none."""
    return next((x for x in (HERTZ, RADIANS) if x.label == label), None)


def band_scale(band: Iterable[Expr]) -> Scale:
    """Hz where a frequency is a multiple of pi rad/s: then it was written in Hz, or in turns of another kind.

    >>> from haptisym.model.scenefile import load_scene
    >>> band_scale(load_scene("steering-wheel").band).unit, band_scale(load_scene("fu2019").band).unit
    ('Hz', 'rad/s')
    """
    return HERTZ if any(x.has(pi) for x in band) else RADIANS


def floats_scale(values: Iterable[float]) -> Scale:
    """The same of floats: Hz where all are short decimals in Hz, and not all are in rad/s.

    >>> floats_scale([0.0, 31.41592653589793]).unit, floats_scale([20.0, 200.0]).unit
    ('Hz', 'rad/s')
    """
    given = [float(x) for x in values]
    return (
        HERTZ if all(map(_is_short, (x / HERTZ.factor for x in given))) and not all(map(_is_short, given)) else RADIANS
    )


def _is_short(x: float) -> bool:
    return abs(x - float(f"{x:.6g}")) <= 1e-13 * abs(x)


CURVES = ((pen.BLUE, pen.SOLID, r"H_\mathrm{env}"), (pen.RED, pen.DASHED, r"H_\mathrm{perc}"))
MOST_LABELS, MOST_NUMBERS = 4, 8


def written(x: Criterion) -> str:
    """The symbol of what a criterion judges, for a legend or an axis."""
    return f"${_index(x.symbol)}$"


def threshold_symbol(x: Criterion) -> str:
    """Its threshold, with the index that the symbol has."""
    return f"${_index(re.sub('^[^_]*', 'c', x.symbol))}$"


def _index(symbol: str) -> str:
    return re.sub(r"_(\w+)", r"_\\mathrm{\1}", symbol)


@dataclass(frozen=True)
class Look:
    """How one of perhaps several scenes is drawn on the same axes.

    ``color``: the caller's, or the next one; ``given``: whether the caller chose it. ``suffix``: what its entries in the legend
    end with. ``number``: of scenes that were drawn before.
    """

    color: str
    given: bool
    suffix: str
    number: int

    @classmethod
    def on(cls, ax: Axes, name: str, color: str | None, label: str) -> Look:
        """The look of a scene on axes where each one has an entry of that name in the legend."""
        number = sum(text.startswith((f"{name}, ", f"{name} (")) or text == name for text in entries(ax))
        suffix = f", {label}" if label else f" ({number + 1})" if number else ""
        return cls(color or pen.SCENES[number % len(pen.SCENES)], color is not None, suffix, number)

    @property
    def plain(self) -> bool:
        """Whether the scene is alone so far, and drawn in the usual colours."""
        return not (self.given or self.number)

    def ink(self, usual: str) -> str:
        """The colour of something that usually has one of its own."""
        return usual if self.plain else self.color


def thin(ax: Axes) -> None:
    """Thin lines and no box."""
    ax.tick_params(labelsize=pen.SMALL, width=0.5, length=2.5, color=pen.GREY)
    ax.spines[["top", "right"]].set_visible(False)
    for spine in ax.spines.values():
        spine.set(linewidth=0.5, color=pen.GREY)


def dress(ax: Axes, x: str = "", y: str = "") -> None:
    """Thin lines, no box, few and plain numbers; ``x``, ``y`` : the labels of the axes, which stay as they are if not given."""
    thin(ax)
    for axis, label in ((ax.xaxis, x), (ax.yaxis, y)):
        axis.set_major_formatter(_Plain())
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        if label:
            axis.set_label_text(label, fontsize=pen.TEXT)


def dress_rows(ax: Axes, names: Sequence[str], size: float = pen.SMALL) -> None:
    """Of axes with rows that have names, the first on top: no lines but the lower one."""
    ax.set_yticks(range(len(names)), names, fontsize=size)
    ax.set_ylim(len(names) - 0.5, -0.5)
    ax.tick_params(labelsize=pen.SMALL, length=2, width=0.5, color=pen.INK)
    ax.tick_params(axis="y", length=0, labelsize=size)
    ax.spines[["top", "right", "left"]].set_visible(False)


def draw_origin(ax: Axes) -> None:
    """Thin lines through 0, both ways."""
    ax.axhline(0, color=pen.GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=pen.GREY, linewidth=0.4, zorder=0)


class _Plain(ScalarFormatter):
    """All decimals of all ticks; powers of ten only where numbers would be long."""

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(False)

    def __call__(self, x: float, pos: int | None = None) -> str:
        most = float(np.abs(self.axis.get_view_interval()).max()) if self.axis else 1.0
        return number(x) if not 1e-3 <= most < 1e6 else super().__call__(x, pos)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 6) -> str:
    """A number as print has it: a real minus, and powers of ten with an exponent that is raised.

    >>> number(-0.5), number(2.79e-05, 3), number(1e-7), number(12.0)
    ('−0.5', '2.79·10⁻⁵', '10⁻⁷', '12')
    """
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"10{str(int(exponent)).translate(_RAISED)}" if exponent else ""
    shown = {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa}·{power}") if power else mantissa
    return shown.replace("-", "−")


def raised(text: str) -> str:
    """A text with its powers and differences as print has them.

    >>> raised("grid of 10^4, 10^-3"), raised("H_perc - H_env")
    ('grid of 10⁴, 10⁻³', 'H_perc − H_env')
    """
    text = text.replace(" - ", " − ")
    return re.sub(r"\^(-?\d+)", lambda found: found[1].translate(_RAISED), text)


class _Moving(Protocol):
    @property
    def motion(self) -> MotionKind | None: ...


def name_dynamics(axis: Axis, name: str, scene: _Moving) -> None:
    """The label of an axis of force per position, in thousands or millions of its unit where numbers are large."""
    most = np.abs(axis.get_view_interval()).max()
    factor, prefix = next(((f, p) for f, p in ((1e6, "M"), (1e3, "k")) if most >= 100 * f), (1.0, ""))
    unit = "N·m/rad" if scene.motion is MotionKind.ROTATION else "N/m"
    axis.set_label_text(f"${name}$ ({prefix}{unit})", fontsize=pen.TEXT)
    if prefix:
        axis.set_major_formatter(FuncFormatter(lambda value, _: number(value / factor)))


def dress_plane(ax: Axes, scene: _Moving) -> None:
    """The complex plane of dynamics."""
    dress(ax)
    name_dynamics(ax.xaxis, r"\mathrm{Re}\,H", scene)
    name_dynamics(ax.yaxis, r"\mathrm{Im}\,H", scene)


def dress_changes(ax: Axes) -> None:
    """The complex plane of what is noticed: changes as fractions of the environment."""
    dress(ax, r"$\mathrm{Re}\,\Delta H/|H_\mathrm{env}|$", r"$\mathrm{Im}\,\Delta H/|H_\mathrm{env}|$")


def keep_scales(ax: Axes) -> None:
    """Equal scales both ways, where that leaves a drawing."""
    width, height = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
    ax.set_aspect("equal" if 0.25 < width / height < 4 else "auto", adjustable="box")


def shown_length(largest: float, unit: str) -> tuple[float, str]:
    """How many of the unit in which lengths are drawn make one of their own, and that unit: mm for small ones."""
    return (1e3, "mm") if unit == "m" and largest < 0.2 else (1.0, unit)


def name_parameter(name: str, unit: str) -> str:
    """The label of an axis of a parameter: its symbol and its unit.

    >>> name_parameter("omega_n", "rad/s"), name_parameter("zeta", "1")
    ('$\\\\omega_n$ (rad/s)', '$\\\\zeta$')
    """
    symbol = f"${formula(Symbol(name))}$"
    return symbol if unit in ("", "1") else f"{symbol} ({unit_text(unit)})"


def name_frequency(ax: Axes, scale: Scale) -> None:
    """The label of the horizontal axis where that is frequency."""
    ax.set_xlabel(scale.label, fontsize=pen.TEXT)


def limit(ax: Axes, x: tuple[float, float], y: tuple[float, float], *, number: int = 0) -> None:
    """Limits of the axes; wide enough for what was drawn before, too, if that is some number of scenes."""
    for asked, get, put in ((x, ax.get_xlim, ax.set_xlim), (y, ax.get_ylim, ax.set_ylim)):
        low, high = get() if number else asked
        put(min(low, asked[0]), max(high, asked[1]))


def rectangles(ax: Axes, x: Array, y: Array, color: str, zorder: float = 0) -> None:
    """Rectangles side by side, without a seam: from where to where they go, a column each."""
    (a, b), (c, d) = x, y
    corners = np.stack([np.stack(corner, -1) for corner in ((a, c), (b, c), (b, d), (a, d))], 1)
    ax.add_collection(PolyCollection(list(corners), facecolors=color, linewidths=0, antialiased=False, zorder=zorder))


def text_width(ax: Axes, text: str) -> float:
    """About the width of a small text with a margin, as a fraction of the axes."""
    return (0.54 * max(map(len, text.split("\n"))) + 0.7) * em(ax)


def em(ax: Axes) -> float:
    """The size of a small text, as a fraction of the width of the axes."""
    return pen.SMALL * ax.figure.dpi / (72 * ax.bbox.width)


def entries(ax: Axes) -> dict[str, Any]:
    """What the legend of the axes holds: from each label to its handle."""
    found = ax.get_legend()
    return dict(zip([x.get_text() for x in found.get_texts()], found.legend_handles, strict=True)) if found else {}


def legend(ax: Axes, handles: Iterable[Artist], *, lines: int = 0) -> int:
    """The legend above the axes, where no curve is, and above that many lines of other text; how many rows it has.

    Entries of a legend that is there already stay; no label occurs twice.
    """
    told = entries(ax)
    for x in handles:
        told.setdefault(str(x.get_label()), x)
    columns = _columns(ax, list(told))
    raised = ScaledTranslation(0, (0.5 + 1.9 * lines) * pen.SMALL / 72, ax.figure.dpi_scale_trans)
    ax.legend(
        handles=list(told.values()), labels=list(told), ncols=columns, loc="lower left",
        bbox_to_anchor=(0, 1), bbox_transform=ax.transAxes + raised, borderaxespad=0, borderpad=0, fontsize=pen.SMALL,
        frameon=False, handlelength=2.2, handletextpad=0.5, columnspacing=1.2, labelspacing=0.3,
    )  # fmt: skip
    return -(-len(told) // columns)


def _columns(ax: Axes, labels: Sequence[str]) -> int:
    """The most columns of a legend that together are no wider than the axes."""
    widths = [text_width(ax, _as_seen(label)) + 3.2 * em(ax) for label in labels]
    for columns in range(len(labels), 1, -1):
        if sum(max(column) for column in np.array_split(widths, columns)) - 1.2 * em(ax) <= 1.05:
            return columns
    return 1


def _as_seen(label: str) -> str:
    """A label without the marks of its mathematics."""
    return re.sub(r"\\[a-z]+|[\\${}_,]", "", label)


def curves(look: Look) -> tuple[tuple[str, Any, str], ...]:
    """Colour, style and name of the curves of H_env and H_perc: blue and red, or both in the colour of a scene."""
    return CURVES if look.plain else tuple((look.color, style, name) for _, style, name in CURVES)


def curve_handles(look: Look, before: str = "", after: str = "") -> list[Line2D]:
    """Entries of the legend for the curves of H_env and H_perc."""
    rows = curves(look)
    return [handle(color, style, f"${before}{name}{after}${look.suffix}") for color, style, name in rows]


def handle(color: str, style: Any, label: str, width: float = 1.1, **marker: Any) -> Line2D:
    """An entry of the legend: a line, a mark, or words alone."""
    return Line2D([], [], color=color, linestyle=style, linewidth=width, label=label, **marker)


def dots(size: float, shape: str = "o", **more: Any) -> dict[str, Any]:
    """The style of marks that no line joins."""
    return {"linestyle": "none", "marker": shape, "markersize": size, **more}


def entry(label: str) -> Line2D:
    """A legend entry of words alone."""
    return handle(pen.INK, "none", label)


def plate(color: str) -> dict[str, Any]:
    """What keeps a text readable on a curve."""
    return {"facecolor": color, "edgecolor": "none", "pad": 0.6}


def write_note(ax: Axes, text: str) -> None:
    """A sentence in the middle of the axes, at the top."""
    ax.text(0.5, 0.97, text, transform=ax.transAxes, ha="center", va="top", fontsize=pen.SMALL, bbox=plate(pen.SHADE))


_ABOVE = "_above"
"""The mark of labels above the axes, by which those of a scene drawn before are found."""


def mark_bands(ax: Axes, intervals: Iterable[Interval], look: Look, scale: Scale, label: str) -> Sequence[Artist]:
    """Some bands of a scene: a grey ground, or bars at the top for a further one; the first bears the label."""
    label = f"{label}{look.suffix}"
    return bars(ax, intervals, look, scale, label) if look.number else shade(ax, intervals, scale, label)


def shade(ax: Axes, intervals: Iterable[Interval], scale: Scale = RADIANS, label: str = "") -> list[Patch]:
    """Grey bands at some frequencies; the first one bears the label."""
    made: list[Patch] = []
    for low, high in (scale.of(np.array(ends_of(x))) for x in intervals):
        if low == high:
            ax.axvline(low, color=pen.SHADE, linewidth=1, zorder=0)
        else:
            made.append(ax.axvspan(low, high, facecolor=pen.SHADE, linewidth=0, zorder=0))
    if made and label:
        made[0].set_label(label)
    return made


def bars(ax: Axes, intervals: Iterable[Interval], look: Look, scale: Scale, label: str) -> list[Line2D]:
    """The bands of a further scene as bars of its colour at the top of the axes, each scene below the one before."""
    made: list[Line2D] = []
    for ends in (scale.of(np.array(ends_of(x))) for x in intervals):
        place = [0.985 - 0.03 * look.number] * 2
        made += ax.plot(
            ends, place, color=look.color, transform=ax.get_xaxis_transform(), zorder=1, linewidth=2.5, alpha=0.6,
            solid_capstyle="butt",
        )  # fmt: skip
    if made:
        made[0].set_label(label)
    return made


def label_above(ax: Axes, labels: Iterable[tuple[float, str]], color: str = pen.INK) -> None:
    """Texts side by side on top of the axes, each tied to its place; those that are there already move for new ones.

    Where they have no room beside each other, only those that were there first stay.
    """
    before = [x for x in ax.texts if isinstance(x, Annotation) and x.get_label() == _ABOVE]
    rows = [(float(x.xy[0]), x.get_text(), str(x.get_color())) for x in before]
    new = [(x, text, color) for x, text in labels]
    if rows and sum(text_width(ax, text) for _, text, _ in [*rows, *new]) > 1:
        new = []
    for old in before:
        old.remove()
    for x, _, ink in new:
        ax.axvline(x, color=pen.GREY if ink == pen.INK else ink, linewidth=0.5, linestyle=pen.DOTTED, zorder=1)
    ordered = sorted([*rows, *new])
    places = spread([share_of(ax, x) for x, _, _ in ordered], [text_width(ax, text) for _, text, _ in ordered])
    for (x, text, ink), place in zip(ordered, places, strict=True):
        ax.annotate(
            text, xy=(x, 1), xytext=(place, 1.05), xycoords=ax.get_xaxis_transform(), textcoords="axes fraction",
            ha="center", va="bottom", fontsize=pen.SMALL, color=ink, arrowprops=pen.LEADER, label=_ABOVE,
        )  # fmt: skip


def spread(centres: Sequence[float], widths: Sequence[float]) -> Array:
    """Places near the wanted ones, in the same order, at which labels of these widths stand side by side within 0 to 1.

    >>> spread([0.1, 0.5, 0.52], [0.1, 0.1, 0.1]).round(2).tolist()
    [0.1, 0.46, 0.56]
    """
    offsets = np.cumsum(widths) - np.asarray(widths) / 2
    free = np.asarray(centres) - offsets
    free = (np.maximum.accumulate(free) + np.minimum.accumulate(free[::-1])[::-1]) / 2
    return np.clip(free, 0, max(0.0, 1 - sum(widths))) + offsets


def share_of(ax: Axes, x: float) -> float:
    """Where a frequency is on the axes, from 0 to 1."""
    low, high = ax.get_xlim()
    return (x - low) / (high - low)


_WIDE, _HIGH = 0.51, 0.95
"""Of a letter, and of a line, in sizes of the font."""
_MARK = 3.0  # half of a point's width, pt
_NEAR, _FAR = 5.0, 14.0  # pt from a point to its name
_OUTSIDE, _MET, _DOUBTFUL, _CROSSED, _LONG = 50.0, 20.0, 12.0, 8.0, 0.35
"""What a place costs: to leave the axes, to meet something, to seem another point's, to be crossed by a line; per pt away."""

Box = tuple[float, float, float, float]
"""Left, bottom, right, top, in points of the page."""


@dataclass
class Room:
    """What is on the axes already: boxes, and points of lines, in points of the page."""

    ax: Axes
    boxes: list[Box] = field(default_factory=list)
    lines: list[Array] = field(default_factory=list)
    points: list[tuple[float, float]] = field(default_factory=list)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """A place of the data, in points of the page."""
        found = self._on_page([x], [y])
        return float(found[0, 0]), float(found[0, 1])

    def _on_page(self, x: Sequence[float] | Array, y: Sequence[float] | Array) -> Array:
        transform: Any = self.ax.transData
        found: Array = transform.transform(np.column_stack([x, y])) * 72 / self.ax.figure.dpi
        return found

    def take_point(self, x: float, y: float, half: float = _MARK) -> None:
        """Nothing is written over a point."""
        a, b = self.at(x, y)
        self.points.append((a, b))
        self.boxes.append((a - half, b - half, a + half, b + half))

    def take_line(self, x: Sequence[float] | Array, y: Sequence[float] | Array) -> None:
        """Nothing is written over a line, if there is another place."""
        found = self._on_page(x, y)
        self.lines.append(_dense(found[np.isfinite(found).all(axis=1)]))

    def beside(self, x: float, y: float, text: str, size: float) -> tuple[float, float]:
        """Where a name is best: from its point, pt, to its lower left corner. That place is taken then."""
        a, b = self.at(x, y)
        wide, high = _WIDE * size * len(text), _HIGH * size
        tried = [
            (
                self._cost(box := (a + i, b + j, a + i + wide, b + j + high)) + self._doubt(box, (a, b)) + _LONG * gap,
                n,
                i,
                j,
            )
            for n, (gap, i, j) in enumerate(_tried(wide, high))
        ]
        _, _, right, up = min(tried)
        self.boxes.append((a + right, b + up, a + right + wide, b + up + high))
        return right, up

    def _doubt(self, box: Box, own: tuple[float, float]) -> float:
        """What it costs that another point is nearer to a name than its own."""
        return _DOUBTFUL * any(_apart(box, x) <= _apart(box, own) for x in self.points if x != own)

    def crowded(self, place: tuple[float, float], size: float) -> float:
        """What it costs to write a number about a place."""
        a, b = self.at(*place)
        return self._cost((a - 0.6 * size, b - 0.6 * size, a + 0.6 * size, b + 0.6 * size))

    def away(self, one: tuple[float, float], other: tuple[float, float]) -> float:
        """How far two places are from each other, pt."""
        return float(np.hypot(*np.subtract(self.at(*one), self.at(*other))))

    def _cost(self, box: Box) -> float:
        left, bottom, right, top = box
        extents: Any = self.ax.bbox.extents
        edge = extents * 72 / self.ax.figure.dpi
        cost = _OUTSIDE * (left < edge[0] + 1 or bottom < edge[1] + 1 or right > edge[2] - 1 or top > edge[3] - 1)
        cost += _MET * sum(left < x1 and x0 < right and bottom < y1 and y0 < top for x0, y0, x1, y1 in self.boxes)
        for line in self.lines:
            x, y = line.T
            cost += _CROSSED * bool(((x > left) & (x < right) & (y > bottom) & (y < top)).any())
        return float(cost)


def _tried(wide: float, high: float) -> Iterator[tuple[float, float, float]]:
    """How far places of a name are, and where, the usual ones first: to the right, above and below, to the left; then farther."""
    for gap in (_NEAR, _FAR, 2 * _FAR):
        sides = (-high / 2, gap / 2, -high - gap / 2, gap, -high - gap)
        yield from ((gap, gap, up) for up in sides)
        yield from ((gap, -wide / 2, up) for up in (gap, -high - gap))
        yield from ((gap, -wide - gap, up) for up in sides)


def _apart(box: Box, point: tuple[float, float]) -> float:
    """How far a point is from a box."""
    (left, bottom, right, top), (x, y) = box, point
    return float(np.hypot(max(left - x, 0.0, x - right), max(bottom - y, 0.0, y - top)))


def _dense(points: Array) -> Array:
    """A line as points that are no more than about a point of the page apart."""
    if len(points) < 2:
        return points
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    fine = np.linspace(0, along[-1], min(int(along[-1]) + 2, 20_000))
    return np.column_stack([np.interp(fine, along, points[:, i]) for i in (0, 1)])
