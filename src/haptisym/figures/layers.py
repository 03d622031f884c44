"""A figure as a list of layers on axes that it is given: curves, marks, bands, limits, grounds,
arrows and words.

A ``Panel`` says what is seen: its layers from back to front, and what is along its two axes.
Numbers are in SI and rad/s; a ``DrawnAxis`` has the unit in which they are drawn, which is that of
the scene.
``draw`` puts a chart on axes of matplotlib, and alone decides what a second scene on the same axes
looks like: the next colour, its name at its curves (behind each entry of the legend where it has no
curve), bars at the top in place of grey grounds, limits that leave the first scene in sight, the
unit of frequency that is there already. What scenes share has one entry. A new kind of figure is
one function that lists layers.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.text import Annotation
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator, ScalarFormatter
from matplotlib.transforms import ScaledTranslation
from sympy import Symbol

from haptisym.figures import pen
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber, Scaled
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import RADIANS, Dimension, MotionKind, Unit, quantity
from haptisym.programs.values import Array
from haptisym.writing.characters import printable
from haptisym.writing.latex import formula

Span = tuple[float, float]

# Axes.


@dataclass(frozen=True)
class DrawnAxis:
    """An axis: its symbol, the unit in which it is drawn, its ends in SI, and how it is divided.

    ``dimension`` : where the unit may be that of a scene which is there already. ``names`` : of
    rows, the first on top. ``large`` : whether large numbers are in thousands or millions of the
    unit.
    """

    label: str = ""
    unit: Unit = field(default_factory=lambda: Unit(""))
    ends: Span | None = None
    dimension: Dimension | None = None
    names: Sequence[str] = ()
    log: bool = False
    large: bool = False

    def of(self, values: Any) -> Any:
        """Return numbers in SI as they are drawn, as an array of floats in the unit of the axis."""
        size = float(self.unit.size)
        return (
            np.asarray(values, dtype=float) / size if size != 1 else np.asarray(values, dtype=float)
        )

    @property
    def text(self) -> str:
        """The label with the unit.

        >>> frequency(Unit("rad/s")).text, DrawnAxis("$m$", Unit("kg*m^2")).text
        ('$\\\\omega$ (rad/s)', '$m$ (kg·m²)')
        """
        return f"{self.label} ({self.unit.text})".strip() if self.unit.name else self.label

    def digits(self, value: RealNumber, count: int) -> str:
        """A proven number of this axis to that many correct digits."""
        # A proven number is divided as a number, before it is rounded to decimals: so its digits in
        # the unit are proven too.
        return (value if self.unit.size == 1 else Scaled(value, self.unit.size)).digits(count)

    def short(self, value: Any, digits: int = 4) -> str:
        """A number of this axis with its unit."""
        return f"{number(float(self.of(value)), digits)} {self.unit.text}".strip()


def frequency(unit: Unit, ends: Span | None = None) -> DrawnAxis:
    """An axis of frequencies in the scene's unit; ``ends`` : rad/s."""
    return DrawnAxis(
        # The symbol omega is an angular frequency; over values in Hz it would be false.
        r"$\omega$" if unit == RADIANS else "frequency",
        unit,
        ends,
        Dimension.FREQUENCY,
    )


def parameter(x: Parameter, name: str = "", ends: Span | None = None) -> DrawnAxis:
    """An axis of a parameter in the unit in which the scene gives it."""
    return DrawnAxis(
        f"${formula(Symbol(name or x.symbol.name))}$", x.shown_unit(x.motion), ends, x.dimension
    )


class Moving(Protocol):
    """A thing whose motion is known to be a translation or a rotation, or is not known."""

    @property
    def motion(self) -> MotionKind | None:
        """The kind of motion; None where nothing in the scene determines it."""


def force_per_position(name: str, scene: Moving, ends: Span | None = None) -> DrawnAxis:
    """An axis of dynamics, in thousands or millions of its unit where numbers are large."""
    unit = Unit("N*m/rad") if scene.motion is MotionKind.ROTATION else Unit("N/m")
    return DrawnAxis(f"${name}$", unit, ends, large=True)


def _kept_unit(axis: DrawnAxis, text: str) -> DrawnAxis:
    """Return the axis in the unit that the label of an earlier scene has, where both units are of
    one kind; else as it is."""
    # matplotlib keeps no unit: the text in brackets at the end of the label is all that is left of
    # the first scene's.
    brackets = re.search(r"\(([^()]+)\)$", text)
    if axis.dimension is None or brackets is None or not axis.unit.name:
        return axis
    # Brackets that hold no unit of this dimension raise, and the axis keeps its own.
    with suppress(SceneError):
        read = quantity(f"1 {brackets[1]}", axis.dimension)
        unit = read.unit or Unit(brackets[1])
        return replace(
            frequency(unit, axis.ends) if axis.dimension is Dimension.FREQUENCY else axis, unit=unit
        )
    return axis


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 6) -> str:
    """A number as print has it: a real minus, and powers of ten with an exponent that is raised.

    >>> number(-0.5), number(2.79e-05, 3), number(1e-7), number(12.0)
    ('−0.5', '2.79·10⁻⁵', '10⁻⁷', '12')
    """
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    # The format g writes a power of ten as 1e-07: print has the power without the factor 1.
    power = f"10{str(int(exponent)).translate(_RAISED)}" if exponent else ""
    shown = (
        {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa}·{power}") if power else mantissa
    )
    return shown.replace("-", "−")


def raised(text: str) -> str:
    """A text with its powers and differences as print has them, without what cannot be seen.

    >>> raised("grid of 10^4, 10^-3"), raised("H_perc - H_env")
    ('grid of 10⁴, 10⁻³', 'H_perc − H_env')
    """
    return re.sub(
        r"\^(-?\d+)",
        lambda found: found[1].translate(_RAISED),
        printable(text).replace(" - ", " − "),
    )


class _Plain(ScalarFormatter):
    """Formatter of ticks with all decimals; powers of ten only where numbers would be long."""

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(False)

    def __call__(self, x: float, pos: int | None = None) -> str:
        # What the axis shows decides, not a single number: at usual sizes all ticks have the same
        # count of decimals, which ScalarFormatter finds.
        most = float(np.abs(self.axis.get_view_interval()).max()) if self.axis else 1.0
        return number(x) if not 1e-3 <= most < 1e6 else super().__call__(x, pos)


_TICKS, _DECADES = 6, 3.5
"""Numbers along an axis, at most; decades from which on a logarithmic axis has powers of ten
alone."""


def thin(ax: Axes, style: pen.FigureStyle = pen.SCREEN) -> None:
    """Thin lines and no box; the style's size of small text is from here on that of the axes."""
    ax.tick_params(labelsize=style.small, width=0.5, length=2.5, color=pen.GREY)
    ax.spines[["top", "right"]].set_visible(False)
    for spine in ax.spines.values():
        spine.set(linewidth=0.5, color=pen.GREY)


def small(ax: Axes) -> float:
    """The size of small text on axes, pt: that of their ticks."""
    return float(ax.xaxis.get_tick_params()["labelsize"])


def _dress(ax: Axes, which: str, axis: DrawnAxis, beside: DrawnAxis) -> None:
    """Limits, numbers and label of one axis; ``beside`` : the other one, whose numbers are in the
    same thousands or millions if they are of the same unit."""
    direction = getattr(ax, f"{which}axis")
    if axis.names:
        _dress_rows(ax, axis.names)
    else:
        direction.set_major_formatter(_Plain())
        direction.set_major_locator(MaxNLocator(_TICKS, steps=[1, 2, 5, 10]))
    if axis.log:
        getattr(ax, f"set_{which}scale")("log")
        low, high = getattr(ax, f"get_{which}lim")()
        is_wide = np.log10(high / low) > _DECADES
        # set_xscale has just replaced locators and formatters, so they are set after it.
        direction.set_major_locator(
            LogLocator(numticks=8) if is_wide else LogLocator(subs=(1, 2, 5))
        )
        direction.set_minor_locator(NullLocator())
        direction.set_major_formatter(FuncFormatter(lambda value, _: number(value)))
    shared = axis.large and beside.large and axis.unit == beside.unit
    seen = [ax.xaxis, ax.yaxis] if shared else [direction]
    most = max(np.abs(x.get_view_interval()).max() for x in seen)
    # Thousands from 1e5 on and millions from 1e8 on: at least three digits stay before the point.
    factor, prefix = next(
        ((f, p) for f, p in ((1e6, "M"), (1e3, "k")) if axis.large and most >= 100 * f), (1.0, "")
    )
    if prefix:
        direction.set_major_formatter(FuncFormatter(lambda value, _: number(value / factor)))
    if axis.text:
        direction.set_label_text(
            f"{axis.label} ({prefix}{axis.unit.text})" if prefix else axis.text, fontsize=pen.TEXT
        )


def _dress_rows(ax: Axes, names: Sequence[str]) -> None:
    """Rows that have names, the first on top: no lines but the lower one."""
    ax.set_yticks(range(len(names)), [*map(printable, names)], fontsize=small(ax))
    ax.tick_params(axis="y", length=0, labelsize=small(ax))
    ax.spines["left"].set_visible(False)
    # Limits from high to low turn the axis upside down, so that the first row is on top.
    ax.set_ylim(len(names) - 0.5, -0.5)


# Charts and layers.


@dataclass(frozen=True)
class On:
    """The axes that layers are drawn on, and which of the scenes on them is being drawn.

    ``number`` : of scenes that were drawn before; ``color`` : the caller's or the next one;
    ``label`` : the scene's name, empty of a first one that has none.
    """

    ax: Axes
    x: DrawnAxis
    y: DrawnAxis
    number: int = 0
    color: str = pen.INK
    given: bool = False
    label: str = ""

    def ink(self, usual: str) -> str:
        """Return the colour of a layer: its usual one where the scene is alone and no colour was
        given, else that of the scene."""
        return self.color if self.given or self.number else usual

    def labelled(self, words: str) -> str:
        """Return words with the name of the scene behind them, where it has one."""
        gap = " " if self.label.startswith("(") else ", "
        return f"{words}{gap}{self.label}" if words and self.label else words or self.label


@dataclass(frozen=True, kw_only=True)
class Layer:
    """Something drawn. ``label`` : in the legend; ``name`` : at the curve, in place of an entry in
    the legend; ``shared`` : by all scenes, one entry; ``styled`` : takes a caller's style.

    ``look`` : more that the artist is told, as matplotlib names it.
    """

    label: str = ""
    name: str = ""
    shared: bool = False
    styled: bool = False
    look: Mapping[str, Any] = field(default_factory=dict)

    def draw(self, on: On) -> list[Artist]:
        """Draw on the axes, and return the artists."""
        raise NotImplementedError

    def keys(self, _on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        """Return the entries of the legend, each with its words; none where nothing was drawn."""
        return [(self.label, made[0])] if self.label and made else []

    def named(self, on: On) -> str:
        """Return what stands at the curve: its name; with several scenes, the scene's."""
        return on.labelled(self.name) if self.name else ""


@dataclass(frozen=True)
class Polyline(Layer):
    """A line through places."""

    x: Any
    y: Any
    color: str = pen.INK
    stroke: Any = pen.SOLID
    width: float = 1.1
    styled: bool = field(default=True, kw_only=True)

    def draw(self, on: On) -> list[Artist]:
        style = {
            "color": on.ink(self.color),
            "linestyle": self.stroke,
            "linewidth": self.width,
            **self.look,
        }
        return list(on.ax.plot(on.x.of(self.x), on.y.of(self.y), **style))

    def named(self, on: On) -> str:
        # A curve that the legend explains bears the name of its scene.
        return on.label if self.label and not (self.shared or self.name) else super().named(on)


@dataclass(frozen=True)
class Mark(Layer):
    """Marks that no line joins; ``face`` : of their inside, that of the rim if not given."""

    x: Any
    y: Any
    color: str = pen.INK
    shape: str = "o"
    size: float = 3.6
    face: str = ""

    def draw(self, on: On) -> list[Artist]:
        if not len(self.x):  # an unclipped line without points would upset the layout
            return []
        ink = on.ink(self.color)
        style = {
            **dots(self.size, self.shape),
            "color": ink,
            "markerfacecolor": self.face or ink,
            "zorder": 4,
        }
        return list(on.ax.plot(on.x.of(self.x), on.y.of(self.y), **{**style, **self.look}))


@dataclass(frozen=True)
class Intervals(Layer):
    """Some intervals along the axis: a ground, or bars at the top for a further scene.

    ``firm`` : the ground of a further scene, too.
    """

    intervals: Iterable[Span]
    color: str = pen.SHADE
    firm: bool = False

    def draw(self, on: On) -> list[Artist]:
        made: list[Artist] = []
        for ends in self.intervals:
            low, high = on.x.of(ends)
            if on.number and not self.firm:
                made += self._bar(on, low, high)
            elif low == high:
                # An interval of one point has no width: a stroke keeps it in sight.
                made.append(on.ax.axvline(low, color=self.color, linewidth=2, zorder=0))
            else:
                style: dict[str, Any] = {"facecolor": self.color, "linewidth": 0, "zorder": 0}
                made.append(on.ax.axvspan(low, high, **{**style, **self.look}))
        return made

    @staticmethod
    def _bar(on: On, low: float, high: float) -> list[Line2D]:
        """Draw a bar at the top of the axes, each scene's below that of the one before."""
        return on.ax.plot(
            [low, high],
            [0.985 - 0.03 * on.number] * 2,
            color=on.color,
            transform=on.ax.get_xaxis_transform(),
            zorder=1,
            linewidth=2.5,
            alpha=0.6,
            solid_capstyle="butt",
            marker="o" if low == high else "",
        )


UNDECIDED: Mapping[str, Any] = {
    "facecolor": "#fbf0d3",
    "edgecolor": "#b9892a",
    "hatch": "////",
    "linewidth": 0,
}
"""Where nothing is decided: hatched on a ground of its own, so that a strip of a few points is
seen."""


@dataclass(frozen=True)
class Limit(Layer):
    """A straight line through the axes, level or ``upright``."""

    at: float
    upright: bool = False
    color: str = pen.GREY
    stroke: Any = pen.SOLID
    width: float = 0.6

    def draw(self, on: On) -> list[Artist]:
        draw, axis = (on.ax.axvline, on.x) if self.upright else (on.ax.axhline, on.y)
        look = {"color": self.color, "linestyle": self.stroke, "linewidth": self.width, **self.look}
        return [draw(float(axis.of(self.at)), **look)]


@dataclass(frozen=True)
class Ground(Layer):
    """Rectangles side by side, without a seam: from where to where they go both ways, in
    columns."""

    x: Any
    y: Any
    color: str = pen.SHADE
    zorder: float = 0

    def draw(self, on: On) -> list[Artist]:
        (a, b), (c, d) = on.x.of(self.x), on.y.of(self.y)
        if not len(a):
            return []
        corners = np.stack([np.stack(corner, -1) for corner in ((a, c), (b, c), (b, d), (a, d))], 1)
        style: dict[str, Any] = {
            "facecolors": self.color,
            "linewidths": 0,
            # Antialiased edges of two neighbours cover a shared pixel in part only: seams would
            # show.
            "antialiased": False,
            "zorder": self.zorder,
        }
        return [on.ax.add_collection(PolyCollection(list(corners), **{**style, **self.look}))]

    def keys(self, _on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        style: dict[str, Any] = {
            "facecolor": self.color,
            "edgecolor": pen.GREY,
            "linewidth": 0.3,
            **self.look,
        }
        return [(self.label, Patch(**style))] if self.label and made else []


@dataclass(frozen=True)
class DrawnDiscs(Layer):
    """A disc about each point of the plane whose radius is known."""

    centres: Any
    radii: Any
    color: str

    def draw(self, on: On) -> list[Artist]:
        # A radius that is not finite is unbounded or unknown: there is no disc to draw.
        seen = np.isfinite(self.radii) & (self.radii > 0)
        circles = [
            Circle((c.real, c.imag), r)
            for c, r in zip(self.centres[seen], self.radii[seen], strict=True)
        ]
        style: dict[str, Any] = {
            "facecolor": self.color,
            "edgecolor": self.color,
            "alpha": 0.28,
            "linewidth": 0.6,
        }
        return (
            [on.ax.add_collection(PatchCollection(circles, zorder=1, **style))] if circles else []
        )

    def keys(self, _on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        style: dict[str, Any] = {
            "markerfacecolor": self.color,
            "markeredgecolor": self.color,
            "alpha": 0.4,
        }
        return (
            [(self.label, handle(pen.GREY, "none", "", **dots(6, "o", **style)))]
            if self.label and made
            else []
        )


@dataclass(frozen=True)
class PatchLayer(Layer):
    """A patch of matplotlib, as it is."""

    patch: Patch

    def draw(self, on: On) -> list[Artist]:
        return [on.ax.add_patch(self.patch)]


@dataclass(frozen=True)
class Origin(Layer):
    """Thin lines through 0, both ways or ``level`` alone."""

    level: bool = False

    def draw(self, on: On) -> list[Artist]:
        if on.number:
            return []
        lines = [on.ax.axhline] if self.level else [on.ax.axhline, on.ax.axvline]
        return [draw(0, color=pen.GREY, linewidth=0.4, zorder=0) for draw in lines]


@dataclass(frozen=True)
class Words(Layer):
    """An entry of the legend alone: words, with a line or a mark of a look where one is given."""

    def draw(self, on: On) -> list[Artist]:
        style: dict[str, Any] = {"color": pen.INK, "linestyle": "none", **self.look}
        # The artist is not put on the axes: the legend alone shows it.
        return [Line2D([], [], **{**style, "color": on.ink(style["color"])})]


@dataclass(frozen=True)
class Note(Layer):
    """A sentence in the middle of the axes, at the top."""

    text: str

    def draw(self, on: On) -> list[Artist]:
        place: dict[str, Any] = {
            "transform": on.ax.transAxes,
            "ha": "center",
            "va": "top",
            "fontsize": small(on.ax),
        }
        return [on.ax.text(0.5, 0.97, self.text, bbox=plate(pen.SHADE), zorder=6, **place)]


@dataclass(frozen=True)
class Above(Layer):
    """Texts side by side on top of the axes, each tied to its place; those that are there already
    move for new ones.

    Where they have no room beside each other they stand upright; where not even so, only those
    that were there first stay.
    """

    places: Sequence[tuple[float, str]]

    def draw(self, on: On) -> list[Artist]:
        ax, ink = on.ax, on.color
        # Labels of earlier scenes are taken away and placed anew with those of this one: where each
        # stands depends on all of them.
        before = [x for x in ax.texts if isinstance(x, Annotation) and x.get_label() == _ABOVE]
        rows = [(float(x.xy[0]), x.get_text(), str(x.get_color())) for x in before]
        new = [(float(on.x.of(x)), text, ink) for x, text in self.places]
        # Without room for all, the row of the first scene stays whole.
        if rows and UPRIGHT * em(ax) * len([*rows, *new]) > 1:
            new = []
        for old in before:
            old.remove()
        for x, _, _ in new:
            color = ink if on.given or on.number else pen.GREY
            ax.axvline(x, color=color, linewidth=0.5, linestyle=pen.DOTTED, zorder=1)
        ordered = sorted([*rows, *new])
        widths = [text_width(ax, text) for _, text, _ in ordered]
        is_upright = sum(widths) > 1
        if is_upright:
            widths = [UPRIGHT * em(ax)] * len(ordered)
        places = spread([share_of(ax, x) for x, _, _ in ordered], widths)
        return [
            ax.annotate(
                text,
                xy=(x, 1),
                xytext=(place, 1.05),
                xycoords=ax.get_xaxis_transform(),
                textcoords="axes fraction",
                ha="center",
                va="bottom",
                rotation=90 if is_upright else 0,
                fontsize=small(ax),
                color=own,
                arrowprops=pen.LEADER,
                label=_ABOVE,
            )
            for (x, text, own), place in zip(ordered, places, strict=True)
        ]


UPRIGHT = 1.25
"""Sizes of the font that a text takes along the axes where it stands upright."""
_ABOVE = "_above"
"""The mark of labels above the axes, by which those of a scene drawn before are found."""


@dataclass(frozen=True)
class Panel:
    """What is seen on one pair of axes: layers from back to front, and what is along the axes.

    ``height`` : inches of a sheet; ``equal`` : scales both ways, where that leaves a drawing;
    ``title`` : above the legend.
    """

    layers: Sequence[Layer]
    x: DrawnAxis = field(default_factory=DrawnAxis)
    y: DrawnAxis = field(default_factory=DrawnAxis)
    height: float = 2.1
    equal: bool = False
    title: str = ""


_GROUP = "haptisym-"
"""With a number the mark of what belongs to one scene on the axes."""


def draw(
    ax: Axes, chart: Panel, *, color: str | None = None, label: str = "", **style: Any
) -> list[Any]:
    """Draw a chart on axes, on those of scenes before it; the artists that take ``style``, which
    are its curves where it has any.

    ``color``, ``label`` : of the scene; its label stands at its curves.

    >>> from matplotlib.figure import Figure
    >>> ax = Figure().add_subplot()
    >>> limit = Limit(2.5, label="limit", shared=True)
    >>> [line] = draw(ax, Panel([Polyline([0, 1], [2, 3], label="a line"), limit]), label="one")
    >>> [line] = draw(ax, Panel([Polyline([0, 2], [5, 3], label="a line"), limit]))
    >>> [text.get_text() for text in (*ax.get_legend().get_texts(), *ax.texts)]
    ['a line', 'limit', 'one', '(2)']
    """
    return fill(frame(ax, chart, color=color, label=label), chart, **style)


def frame(
    ax: Axes,
    chart: Panel,
    *,
    color: str | None = None,
    label: str = "",
    style: pen.FigureStyle = pen.SCREEN,
) -> On:
    """Limits, numbers and labels of the axes; for layers to be drawn on."""
    # fill marks every artist of scene N by a gid that begins with the group and N: how many
    # different ones there are is how many scenes were drawn.
    marks = (str(x.get_gid()) for x in ax.get_children())
    number = len({x.partition(".")[0] for x in marks if x.startswith(_GROUP)})
    label = printable(label) or (f"({number + 1})" if number else "")
    x, y = chart.x, chart.y
    if number:
        x, y = _kept_unit(x, ax.get_xlabel()), _kept_unit(y, ax.get_ylabel())
    if chart.y.names:
        before = [t.get_text() for t in ax.get_yticklabels()] if number else []
        y = replace(y, names=list(dict.fromkeys([*before, *y.names])))
    if not number:
        thin(ax, style)
    for axis, get, put in ((x, ax.get_xlim, ax.set_xlim), (y, ax.get_ylim, ax.set_ylim)):
        if axis.ends:
            # Limits only grow, so that scenes before stay in sight.
            (low, high), ends = get() if number else axis.of(axis.ends), axis.of(axis.ends)
            put(min(low, ends[0]), max(high, ends[1]))
    _dress(ax, "x", x, y)
    _dress(ax, "y", y, x)
    if chart.equal:
        width, height = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
        # Equal scales of a very flat or very upright window leave a strip that nobody can read:
        # then true angles are given up.
        ax.set_aspect("equal" if 0.25 < width / height < 4 else "auto", adjustable="box")
    return On(
        ax, x, y, number, color or pen.SCENES[number % len(pen.SCENES)], color is not None, label
    )


def fill(on: On, chart: Panel, **style: Any) -> list[Any]:
    """Draw the layers of a chart on axes that are framed, and the legend; return the artists that
    take ``style``."""
    ax, before = on.ax, set(on.ax.get_children())
    # Layers without given ends let matplotlib fit the axes anew while they are drawn; what was seen
    # before is kept for _refit.
    rest = ax.get_xlim(), ax.get_ylim()
    drawn = [(layer, layer.draw(on)) for layer in chart.layers]
    styled = [artist for layer, made in drawn if layer.styled for artist in made]
    for artist in styled:
        artist.set(**style)
    _refit(on, chart, rest)
    names, handles = _names(on, drawn), list[Artist]()
    known = entries(ax)
    for layer, made in drawn:
        keys = layer.keys(on, made)
        if layer.name and (layer.name, layer.named(on)) not in names:
            # There is no curve on the axes at which the name could stand.
            keys += [(layer.name, x) for x in made[:1]]
        for words, key in keys:
            # Where the scene's name stands at its curves, entries need it only if they are new.
            is_bare = layer.shared or (names and (words in known or not on.number))
            key.set_label(words if is_bare else on.labelled(words))
            handles.append(key)
            # A key that is one of the artists has got the style with them.
            if layer.styled and key not in made:
                key.set(**style)
    rows = legend(ax, handles, above=_height_above(ax))
    if chart.title and not on.number:
        # The title stands above the legend, of which a row takes about 1.42 sizes of its font.
        ax.set_title(chart.title, fontsize=pen.TEXT, pad=(0.8 + 1.42 * rows) * small(ax))
    for n, artist in enumerate(x for x in ax.get_children() if x not in before):
        # A gid becomes an id in SVG, which must occur once in a file: hence the count n.
        artist.set_gid(f"{_GROUP}{on.number + 1}.{n}")
    _name_curves(on, names)
    return styled or [artist for _, made in drawn for artist in made]


def _names(
    on: On, drawn: Iterable[tuple[Layer, list[Artist]]]
) -> dict[tuple[str, str], list[Line2D]]:
    """Return the curves that bear a name, by what they are and by that name: all pieces of one
    together, those alone that are seen."""
    names: dict[tuple[str, str], list[Line2D]] = {}
    for layer, made in drawn:
        if words := layer.named(on):
            seen = [x for x in made if isinstance(x, Line2D) and _seen(on.ax, x)]
            if seen:
                names.setdefault((layer.name or layer.label, words), []).extend(seen)
    return names


_NAME = "_name "
"""The mark of names at curves, before the ids of these."""
_PLACES = 12
"""Places of a curve at which its name is tried."""
_BROAD = 32
"""Letters of a name in each of its two lines, about half of what a column has room for."""


def _name_curves(on: On, names: Mapping[tuple[str, str], Sequence[Line2D]]) -> None:
    """Write names at their curves, where they meet nothing else; those of scenes drawn before move
    for them."""
    ax = on.ax
    before = [x for x in ax.texts if str(x.get_label()).startswith(_NAME)]
    wanted = [(x.get_text(), str(x.get_label())) for x in before]
    wanted += [
        (text, _NAME + " ".join(str(x.get_gid()) for x in made))
        for (_, text), made in names.items()
    ]
    for old in before:
        old.remove()
    if not wanted:
        return
    room, by_gid = Room(ax), {str(x.get_gid()): x for x in ax.lines}
    room.take_all()

    def lines_of(mark: str) -> list[Line2D]:
        return [by_gid[x] for x in mark.removeprefix(_NAME).split() if x in by_gid]

    for count, (text, mark) in enumerate(wanted):
        curves = lines_of(mark)
        places = [place for x in curves for place in _seen(ax, x)]
        if not places:
            continue
        # From the high end down: there curves are farthest apart.
        places.sort(reverse=True)
        tried = [places[i] for i in np.linspace(0, len(places) - 1, _PLACES).round().astype(int)]
        others = [room.curve(x) for other in wanted if other[1] != mark for x in lines_of(other[1])]
        # A text with TeX in it has fewer letters in print, and is no formula any more where broken.
        is_long = _letters(text) > _BROAD
        short = textwrap.fill(text, _BROAD, max_lines=2, placeholder="…") if is_long else text
        which, offset = room.along(tried, short, small(ax), others)
        # Two names on one curve would read as one.
        left, bottom, right, top = room.boxes[-1]
        room.boxes[-1] = left - _MARK, bottom, right + _MARK, top
        made = ax.annotate(
            short,
            xy=tried[which],
            xytext=offset,
            textcoords="offset points",
            fontsize=small(ax),
            color=curves[0].get_color(),
            # The place is of the lower left corner: at the baseline a "g" would reach below it.
            va="bottom",
            label=mark,
        )
        made.set_gid(f"{_GROUP}{on.number + 1}.name.{count}")


def _seen(ax: Axes, line: Line2D) -> list[Span]:
    """Return the points of a line that are within the axes."""
    points = np.asarray(line.get_xydata(), dtype=float)
    points = points[np.isfinite(points).all(axis=1)]
    at = ax.transAxes.inverted().transform(line.get_transform().transform(points))
    inside = ((at >= 0) & (at <= 1)).all(axis=1)
    return [(float(x), float(y)) for x, y in points[inside]]


def _height_above(ax: Axes) -> float:
    """Return the height of the texts that stand above the axes, in sizes of their font."""
    texts = [x for x in ax.texts if x.get_label() == _ABOVE]
    upright = [_WIDE * len(x.get_text()) + 0.7 for x in texts if x.get_rotation()]
    return max(upright, default=1.9 if texts else 0.0)


def _refit(on: On, chart: Panel, rest: tuple[Span, Span]) -> None:
    """Set the limits of axes that have found their own: what earlier scenes show stays in sight,
    and large numbers get their unit."""
    for which, axis, before in (("x", chart.x, rest[0]), ("y", chart.y, rest[1])):
        if axis.ends is not None or axis.names:
            continue
        low, high = getattr(on.ax, f"get_{which}lim")()
        if on.number and low < high:
            wider = min(low, before[0]), max(high, before[1])
            getattr(on.ax, f"set_{which}lim")(*wider)
    for which, axis, beside in (("x", chart.x, chart.y), ("y", chart.y, chart.x)):
        if axis.large and axis.ends is None and not axis.names:
            _dress(on.ax, which, axis, beside)


# Words: legends, and labels that do not meet.


def entries(ax: Axes) -> dict[str, Any]:
    """Return the entries of the axes' legend, from each label to its handle."""
    existing = ax.get_legend()
    return (
        dict(
            zip([x.get_text() for x in existing.get_texts()], existing.legend_handles, strict=True)
        )
        if existing
        else {}
    )


def legend(ax: Axes, handles: Iterable[Artist], *, above: float = 0.0) -> int:
    """Draw the legend above the axes, where no curve is, and above other text of that height, in
    sizes of the font; return how many rows it has.

    Entries of a legend that is there already stay; no label occurs twice.
    """
    known = entries(ax)
    for x in handles:
        # The entry that is there first keeps its handle: what scenes share looks as it did.
        known.setdefault(str(x.get_label()), x)
    if not known:
        return 0
    up = ScaledTranslation(0, (0.5 + above) * small(ax) / 72, ax.figure.dpi_scale_trans)
    look: dict[str, Any] = {
        "handles": list(known.values()),
        "labels": list(known),
        "loc": "lower left",
        "bbox_to_anchor": (0, 1),
        "bbox_transform": ax.transAxes + up,
        "borderaxespad": 0,
        "borderpad": 0,
        "fontsize": small(ax),
        "frameon": False,
        "handlelength": 2.2,
        "handletextpad": 0.5,
        "columnspacing": 1.2,
        "labelspacing": 0.3,
    }
    columns, edge = _columns(ax, list(known)), float(ax.figure.bbox.x1)
    # The count of columns follows from estimates, which may leave the figure by a letter.
    while ax.legend(ncols=columns, **look).get_window_extent().x1 > edge and columns > 1:
        columns -= 1
    # Upwards: a row that is not full is a row.
    return -(-len(known) // columns)


def _columns(ax: Axes, labels: Sequence[str]) -> int:
    """Return the largest number of columns with which a legend is no wider than the axes."""
    # The 3.2 font sizes, with the margin of text_width, are a handle, its gap, and the space to the
    # next column, which the last one has not.
    widths = [text_width(ax, label) + 3.2 * em(ax) for label in labels]
    # array_split deals labels out to columns as the legend of matplotlib does, so these are the
    # widths that it will have.
    for columns in range(len(labels), 1, -1):
        if sum(max(column) for column in np.array_split(widths, columns)) - 1.2 * em(ax) <= 1.05:
            return columns
    return 1


def text_width(ax: Axes, text: str) -> float:
    """About the width of a small text with a margin, as a fraction of the axes."""
    # A letter of the font is about 0.54 of its size wide. Exact widths need a renderer, which there
    # is none of before the layout.
    return (0.54 * max(map(_letters, text.split("\n"))) + 0.7) * em(ax)


def _letters(text: str) -> int:
    """Return how many letters a text has in print: commands and braces of TeX are none."""
    return len(re.sub(r"\\[a-z]+|[\\${}_,]", "", text)) if "$" in text else len(text)


def em(ax: Axes) -> float:
    """The size of a small text, as a fraction of the width of the axes."""
    return small(ax) * ax.figure.dpi / (72 * ax.bbox.width)


def share_of(ax: Axes, x: float) -> float:
    """Return where a place is along the axes, from 0 to 1."""
    low, high = ax.get_xlim()
    return (x - low) / (high - low)


def handle(color: str, stroke: Any, label: str, width: float = 1.1, **more: Any) -> Line2D:
    """An entry of the legend: a line, a mark, or words alone."""
    return Line2D(
        [], [], **{"color": color, "linestyle": stroke, "linewidth": width, "label": label, **more}
    )


def dots(size: float, shape: str = "o", **more: Any) -> dict[str, Any]:
    """The style of marks that no line joins."""
    return {"linestyle": "none", "marker": shape, "markersize": size, **more}


def plate(color: str) -> dict[str, Any]:
    """Return the look of a ground that keeps a text readable on a curve."""
    return {"facecolor": color, "edgecolor": "none", "pad": 0.6}


def spread(centres: Sequence[float], widths: Sequence[float]) -> Array:
    """Places near the wanted ones, in the same order, at which labels of these widths stand side by
    side within 0 to 1.

    >>> spread([0.1, 0.5, 0.52], [0.1, 0.1, 0.1]).round(2).tolist()
    [0.1, 0.46, 0.56]
    """
    # In free = centre - offset, where offset is the room of all labels to the left, labels do not
    # overlap exactly where free does not fall. The mean of the running maximum from the left and
    # the running minimum from the right never falls, and moves labels to both sides alike.
    offsets = np.cumsum(widths) - np.asarray(widths) / 2
    free = np.asarray(centres) - offsets
    free = (np.maximum.accumulate(free) + np.minimum.accumulate(free[::-1])[::-1]) / 2
    return np.clip(free, 0, max(0.0, 1 - sum(widths))) + offsets


_WIDE, _HIGH = 0.56, 0.95
"""Width of a letter and height of a line, in sizes of the font."""
_MARK = 3.0  # half of a point's width, pt
_NEAR, _FAR = 5.0, 14.0  # pt from a point to its name
_OUTSIDE, _MET, _DOUBTFUL, _CROSSED, _LONG = 50.0, 20.0, 12.0, 8.0, 0.35
"""What a place costs: to leave the axes, to meet something, to seem another point's, to be crossed
by a line; per pt away."""

Box = tuple[float, float, float, float]
"""Left, bottom, right, top, in points of the page."""


@dataclass
class Room:
    """The boxes, lines and points that are on the axes already, in points of the page, which names
    beside points should not meet."""

    ax: Axes
    boxes: list[Box] = field(default_factory=list)
    lines: list[Array] = field(default_factory=list)
    points: list[Span] = field(default_factory=list)

    def at(self, x: float, y: float) -> Span:
        """A place of the data, in points of the page."""
        [[a, b]] = self._on_page([x], [y])
        return float(a), float(b)

    def _on_page(self, x: Any, y: Any) -> Array:
        """Return places of the data in points of the page."""
        transform: Any = self.ax.transData
        # transData gives pixels, dpi to an inch; a point of the page is 1/72 inch.
        found: Array = transform.transform(np.column_stack([x, y])) * 72 / self.ax.figure.dpi
        return found

    def take_point(self, x: float, y: float, half: float = _MARK) -> None:
        """Take the place of a point, over which nothing is written."""
        a, b = self.at(x, y)
        self.points.append((a, b))
        self.boxes.append((a - half, b - half, a + half, b + half))

    def take_line(self, x: Any, y: Any) -> None:
        """Take the place of a line, over which nothing is written if there is another place."""
        places = self._on_page(x, y)
        self.lines.append(_dense(places[np.isfinite(places).all(axis=1)]))

    def take_all(self) -> None:
        """Take the places of all lines, marks and texts that are on the axes."""
        for line in self.ax.lines:
            if line.get_linestyle() in ("None", "none", " ", ""):
                self.boxes += [
                    (a - _MARK, b - _MARK, a + _MARK, b + _MARK) for a, b in self.curve(line)
                ]
            else:
                self.lines.append(self.curve(line))
        scale = 72 / self.ax.figure.dpi
        for text in self.ax.texts:
            if text.get_text():
                box = text.get_window_extent()
                self.boxes.append((box.x0 * scale, box.y0 * scale, box.x1 * scale, box.y1 * scale))

    def curve(self, line: Line2D) -> Array:
        """Return the points of a line within the axes, in points of the page: of one that is drawn
        through, no more than about a point apart."""
        points: Any = line.get_transform().transform(np.asarray(line.get_xydata(), dtype=float))
        points = points[np.isfinite(points).all(axis=1)]
        low, high = (np.asarray(x) for x in (self.ax.bbox.min, self.ax.bbox.max))
        if line.get_linestyle() not in ("None", "none", " ", ""):
            # What is far off the axes is brought near: its length would make samples coarse.
            scale = self.ax.figure.dpi / 72
            near = np.clip(points, 2 * low - high, 2 * high - low)
            points = _dense(near / scale) * scale
        within = (points >= low) & (points <= high)
        seen: Array = points[within.all(axis=1)]
        return seen * 72 / self.ax.figure.dpi

    def beside(self, x: float, y: float, text: str, size: float) -> Span:
        """Return the best place of a name, from its point to its lower left corner in points of the
        page; that place is taken then."""
        return self.along([(x, y)], text, size)[1]

    def clear(self, x: float, y: float, text: str, size: float) -> Span | None:
        """Return the best place of a name that can be left out, as ``beside`` does; None where that
        meets something, leaves the axes or is not next to the point."""
        at = self.beside(x, y, text, size)
        taken = self.boxes.pop()
        if self._cost(taken) >= _MET or _apart(taken, np.array([self.at(x, y)])) >= _FAR:
            return None
        self.boxes.append(taken)
        return at

    def along(
        self, places: Sequence[Span], text: str, size: float, others: Sequence[Array] = ()
    ) -> tuple[int, Span]:
        """Return the best place of a name beside one of several points: which point, and the place
        from it to the name's lower left corner in points of the page; that place is taken then.

        ``others`` : points of curves that the name is not of.
        """
        lines = text.split("\n")
        wide, high = _WIDE * size * max(map(_letters, lines)), _HIGH * size * len(lines)
        tried: list[tuple[float, int, int, Span, Box]] = []
        for which, point in enumerate(places):
            a, b = self.at(*point)
            strangers = [np.array([p]) for p in self.points if p != (a, b)]
            strangers += [x for x in others if len(x)]
            for gap, i, j in _tried(wide, high):
                box = (a + i, b + j, a + i + wide, b + j + high)
                # A name nearer to another point than to its own, or as near, would be read as the
                # other's.
                own = _apart(box, np.array([(a, b)]))
                doubtful = any(_apart(box, x) <= own for x in strangers)
                cost = self._cost(box) + _DOUBTFUL * doubtful + _LONG * gap
                # The number settles equal costs: the place that is tried first, the usual one, is
                # taken.
                tried.append((cost, len(tried), which, (i, j), box))
        _, _, which, offset, box = min(tried)
        self.boxes.append(box)
        return which, offset

    def crowded(self, place: Span, size: float) -> float:
        """Return the cost of a number that is written about a place."""
        a, b = self.at(*place)
        half = 0.6 * size
        return self._cost((a - half, b - half, a + half, b + half))

    def away(self, one: Span, other: Span) -> float:
        """How far two places are from each other, pt."""
        return float(np.hypot(*np.subtract(self.at(*one), self.at(*other))))

    def _cost(self, box: Box) -> float:
        """Return the cost of a text in a box: for leaving the axes, for each box it meets, for each
        line that crosses it."""
        left, bottom, right, top = box
        extents: Any = self.ax.bbox.extents
        edge = extents * 72 / self.ax.figure.dpi
        cost = _OUTSIDE * (
            left < edge[0] + 1 or bottom < edge[1] + 1 or right > edge[2] - 1 or top > edge[3] - 1
        )
        cost += _MET * sum(
            left < x1 and x0 < right and bottom < y1 and y0 < top for x0, y0, x1, y1 in self.boxes
        )
        for line in self.lines:
            # Lines are stored as close points: a line crosses the box where one of these lies in
            # it.
            x, y = line.T
            cost += _CROSSED * bool(((x > left) & (x < right) & (y > bottom) & (y < top)).any())
        return float(cost)


def _tried(wide: float, high: float) -> Iterable[tuple[float, float, float]]:
    """Yield places of a name: how far each is from the point, and its lower left corner. The usual
    ones come first: to the right, above and below, to the left; then farther."""
    for gap in (_NEAR, _FAR, 2 * _FAR):
        sides = (-high / 2, gap / 2, -high - gap / 2, gap, -high - gap)
        yield from ((gap, gap, up) for up in sides)
        yield from ((gap, -wide / 2, up) for up in (gap, -high - gap))
        yield from ((gap, -wide - gap, up) for up in sides)


def _apart(box: Box, points: Array) -> float:
    """How far the nearest of some points is from a box."""
    low, high = np.array(box[:2]), np.array(box[2:])
    outside = np.maximum(np.maximum(low - points, points - high), 0.0)
    return float(np.hypot(*outside.T).min())


def _dense(points: Array) -> Array:
    """A line as points that are no more than about a point of the page apart."""
    if len(points) < 2:
        return points
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    # The bound is for a line whose ends are far off the axes: it could be millions of points long.
    fine = np.linspace(0, along[-1], min(int(along[-1]) + 2, 20_000))
    return np.column_stack([np.interp(fine, along, points[:, i]) for i in (0, 1)])
