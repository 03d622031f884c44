"""Figures of requirements: the worst case over the band against one parameter, and maps of two.

Over one parameter the curve max r/c over the band is sampled, and the set of values that satisfy
the requirement is exact. A map shows exact slices as upright strokes whose ends bear marks by what
limits there, the ground that is proven, and what is undecided. Lines between slices are
interpolation. Its axes go as far as there is something, with some room. Begin with ``requirement``
and ``slices``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.patches import Patch
from sympy import Float, Rational, S

from haptisym.figures import pen
from haptisym.figures.curves import judged, limit_of
from haptisym.figures.files import Drawings, sheet
from haptisym.figures.layers import (
    UNDECIDED,
    DrawnAxis,
    Ground,
    Intervals,
    Layer,
    Limit,
    Mark,
    Note,
    On,
    Panel,
    Polyline,
    Words,
    handle,
    parameter,
)
from haptisym.judge.bindings import Binding, Kind
from haptisym.judge.crossings import Criterion
from haptisym.kernel.errors import SceneError
from haptisym.kernel.sets import Piece
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import values
from haptisym.model.scene import Knob
from haptisym.programs.values import Array, Values
from haptisym.verbs.require.classical import StiffnessBound
from haptisym.verbs.require.designmap import DesignMap, common
from haptisym.verbs.require.required import TRANSPARENT, Requirement, in_words

_GRID, _VALUES = 600, 400
"""Frequencies along the band, and values of the parameter, at which the worst case is sampled."""
Pair = tuple[float, float]


class _Look(NamedTuple):
    """How a criterion is drawn in all figures."""

    color: str
    stroke: Any
    marker: str


_LOOKS = {"real": _Look(pen.BLUE, pen.SOLID, "o"), "imag": _Look(pen.RED, pen.DASHED, "s")}


def _look_of(x: Criterion) -> _Look:
    """Return the look of a criterion: of the real part, of the imaginary part, or that of all
    others."""
    return _LOOKS.get(x.name, _Look(pen.INK, (0, (5, 1.5, 1, 1.5)), "D"))


# One parameter.


def requirement(found: Requirement) -> Panel:
    """The largest r/c over the band against the parameter, sampled; the exact feasible set in grey,
    its ends as dots.

    >>> from haptisym import load_scene, require
    >>> chart = requirement(require(load_scene("fu2019"), "omega_n"))
    >>> [layer.label for layer in chart.layers if isinstance(layer, Polyline)], chart.x.text
    (['real part', 'imaginary part'], '$\\\\omega_n$ (rad/s)')
    """
    low, high = _window(found)
    # The low end may be a value that the model excludes, as a mass of 0: samples begin after it.
    free_values = np.linspace(low, high, _VALUES + 1)[1:]
    curves = _worst(found, free_values)
    lines = [
        Polyline(free_values, curves[x], *_look_of(x)[:2], label=x.words)
        for x in found.criteria
        if x in curves
    ]
    ends = [float(end.value) for end in found.ends]
    marks = Mark(ends, [1.0] * len(ends), label="ends, proven")
    threshold = [Limit(1, label="threshold", shared=True)] if lines else []
    lowest = [float(np.min(worst[np.isfinite(worst)], initial=np.inf)) for worst in curves.values()]
    # At least three thresholds high, and higher until each curve is seen somewhere.
    top = max([3.0, *(1.5 * x for x in lowest if x < np.inf)]) if lines else 2.0
    upright = DrawnAxis("worst case on the band, $r/c$" if lines else "", ends=(0, top))
    layers = [
        *lines,
        *threshold,
        *_set(found, low, high),
        marks,
        *([] if lines else [_Unnumbered()]),
    ]
    return Panel(layers, parameter(found.free, found.free.name, (low, high)), upright, height=2.3)


@dataclass(frozen=True)
class _Unnumbered(Layer):
    """No numbers along the upright axis: what was asked has no course along a band."""

    def draw(self, on: On) -> list[Artist]:
        on.ax.set_yticks([])
        return []


def _set(found: Requirement, low: float, high: float) -> list[Layer]:
    """Return the values that are proven to satisfy what is required, and those that are undecided,
    in strips wide enough to be seen."""
    word = " and ".join(in_words(x, found.criteria) for x in found.that)
    spans = [_limits(piece, low, high) for piece in found.feasible]
    none = f"no value is {word if found.certified else f'proven {word}'}"
    made: list[Layer] = [Intervals(spans, label=word)] if spans else [Words(label=none)]
    undecided = [_visible(*_limits(piece, low, high), high - low) for piece in found.undecided]
    return [
        *made,
        *(
            [Intervals(undecided, label="undecided", firm=True, look=UNDECIDED)]
            if undecided
            else []
        ),
    ]


_STRIP = 0.012
"""Share of an axis: an undecided strip is drawn no narrower."""


def _visible(low: float, high: float, width: float) -> Pair:
    """A strip that is seen."""
    grown = max(0.0, _STRIP * width - (high - low)) / 2
    return low - grown, high + grown


def _window(found: Requirement) -> Pair:
    """Return the values that are drawn: the range; where it is unbounded, about as far as the ends
    of the set and the scene's own value."""
    own = found.free.value
    known = [*([] if own.free_symbols else [float(own)]), *(float(end.value) for end in found.ends)]
    low, high = found.domain.low, found.domain.high
    reach = 2 * max((abs(x) for x in known), default=0.0) or 1.0
    return (float(low) if low is not None else -reach), (float(high) if high is not None else reach)


def _limits(piece: Piece, low: float, high: float) -> Pair:
    """Return the ends of an interval; the given ones where it has none."""
    return (
        low if piece.low is None else float(piece.low),
        high if piece.high is None else float(piece.high),
    )


def _worst(found: Requirement, free_values: Array) -> dict[Criterion, Array]:
    """Return the largest ratio to its threshold over a grid of the band, for each criterion that is
    about a ratio.

    There is a gap where there is no scene, as where a formula is divided by zero.
    """
    scene, free = found.scene, found.free
    chain = scene.chain.at({x: v for x, v in values(scene.parameters).items() if x != free.symbol})
    there = np.array([_exists(chain, free, x) for x in free_values])
    free_values = free_values[there]
    f = Distortion.of(chain).compile()
    start, end = (float(x) for x in scene.band)
    # A column of frequencies against a row of values: one call gives the whole grid.
    omega = np.linspace(start, end, _GRID)[:, None]
    with np.errstate(all="ignore"):
        # The function has no parameter where the free one is a threshold or belongs to a hand.
        at = f(omega, **dict.fromkeys(f.parameters, free_values[None, :]))
        curves = {x: _against(x, free, at, omega, free_values) for x in found.criteria}
    given = {
        x: np.broadcast_to(curve, free_values.shape)
        for x, curve in curves.items()
        if curve is not None
    }
    shown = {x: np.full(there.shape, np.nan) for x in given}
    for x, row in shown.items():
        row[there] = given[x]
    return shown


def _exists(chain: Chain, free: Knob, value: float) -> bool:
    """Return whether the model takes this value of the parameter."""
    try:
        # The exact value of the double, so that the model judges the value which is drawn.
        chain.at({free.symbol: Rational(value)})
    except SceneError:
        return False
    return True


def _against(
    criterion: Criterion, free: Knob, at: Values, omega: Array, free_values: Array
) -> Array | None:
    """Return the largest ratio to its limit over the frequencies, for each value of the parameter,
    which may be that limit itself; None where a criterion has no ratio."""
    # The limit is a number, the same for all values of the parameter.
    if not criterion.depends_on(free.parts):
        ratio = judged(criterion, at, omega)
        return None if ratio is None else np.nanmax(ratio / limit_of(criterion), axis=0)
    # The parameter is the limit itself: the ratio to 1, then over each value of it.
    if criterion.region is None:
        ratio = judged(replace(criterion, threshold=S.One), at, omega)
        return None if ratio is None else np.nanmax(ratio / free_values[None, :], axis=0)
    # The parameter is a number of the region, on which the ratio depends in no simple way: one
    # region for each value.
    opened = (
        replace(criterion, region=criterion.region.opened(dict.fromkeys(free.parts, Float(c))))
        for c in free_values
    )
    ratios = (judged(one, at, omega) for one in opened)
    return np.array([np.nan if ratio is None else np.nanmax(ratio) for ratio in ratios])


REQUIREMENT = Drawings[Requirement]({"worst": requirement})


# Two parameters.

Rows = Sequence[tuple[float, Requirement]]
"""The slices of one set, and where they are."""
Join = tuple[Pair, Pair]
"""A line between two slices: where they are, and the end of an interval on either."""
_VISIBLE = 2.5e-3
"""Share of the height: a narrower band is hidden by the line itself."""
_ROOM = 0.12
"""Share of what is drawn: the room about it, where a map is empty beyond."""
_LEFT = {"transparent": pen.OPEN, "stable": "#f0b3a6"}
_COLORS = {"transparent": pen.BLUE, "stable": pen.RED, "steady": pen.RED, "passive": "#d0701f"}
_STROKES: Sequence[Any] = (pen.DASHED, pen.DOTTED, (0, (6, 1.5, 1, 1.5)))
_CLASSICAL = 160


@dataclass(frozen=True)
class _Plane:
    """The plane of the two parameters of a map."""

    found: DesignMap

    @cached_property
    def asked(self) -> tuple[Pair, Pair]:
        """The ends of both ranges that were searched."""
        (a, b), (low, high) = ((float(x) for x in pair) for pair in self.found.ranges)
        return (a, b), (low, high)

    @property
    def transparent(self) -> str:
        """What the word stands for on this map, which may be about one part alone."""
        return in_words(TRANSPARENT, self.found.criteria)

    @cached_property
    def rows(self) -> Rows:
        """The slices, each with its place, of all that is asked together."""
        return [(float(x.at), x.requirement) for x in self.found.slices]

    def sets(self) -> Iterator[tuple[str, tuple[str, str], Rows]]:
        """Each set that is outlined: what it is asked for, its colour and name, and its slices."""
        for i, name in enumerate(self.found.that):
            rows = [(float(x.at), (x.apart or (x.requirement,))[i]) for x in self.found.slices]
            yield name, (_COLORS[name], in_words(name, self.found.criteria)), rows
        for i, jnd in enumerate(self.found.thresholds):
            look = (
                _paler(i, len(self.found.thresholds)),
                f"{self.transparent}, c = {float(100 * jnd):.6g} %",
            )
            yield "transparent", look, [(float(x.at), x.contours[i]) for x in self.found.slices]

    @cached_property
    def window(self) -> tuple[Pair, Pair]:
        """The part of both ranges that is drawn: where a boundary or something undecided is, with
        some room."""
        (a, b), (low, high) = self.asked
        x, y = list[float](), list[float]()
        for _, _, rows in self.sets():
            ends = [
                (at, float(e.value))
                for at, r in rows
                for e in r.ends
                if low < float(e.value) < high
            ]
            some = [(at, end) for at, r in rows for span in r.feasible for end in self.ends(span)]
            x += [at for at, _ in some]
            # Ends inside the range are boundaries. Where there is none, the intervals go from end
            # to end of the range, and their ends have to do.
            y += [end for _, end in (ends or some)]
        for cells in (x.rectangles.left for x in self.found.proofs if len(x.rectangles.left)):
            x += [float(cells[:, 0, 0].min()), float(cells[:, 0, 1].max())]
            y += [float(cells[:, 1, 0].min()), float(cells[:, 1, 1].max())]
        return _around(x, (a, b)), _around(y, (low, high))

    def places(self) -> list[float]:
        """Return where the slices are that are drawn: some may lie where a map is empty."""
        low, high = self.window[0]
        return [x for x, _ in self.rows if low <= x <= high]

    def axes(self) -> tuple[DrawnAxis, DrawnAxis]:
        """Return the axes of both parameters, cut to what is drawn."""
        one, other = (
            parameter(x, x.name, ends) for x, ends in zip(self.found.free, self.window, strict=True)
        )
        return one, other

    def ends(self, span: Piece) -> Pair:
        """Return the ends of an interval of a slice; those of the range where it has none."""
        return _limits(span, *self.asked[1])

    def strokes(self, color: str, width: float, label: str) -> Layer:
        """An upright stroke along each interval of each slice."""
        lines = [((at, a), (at, b)) for at, r in self.rows for a, b in map(self.ends, r.feasible)]
        return _Lines(lines, color, width, label=label, styled=True)

    def interpolated(self) -> list[Layer]:
        """A light ground between slices with as many intervals, which proves nothing."""
        return [
            _Between(at, *zip(self.ends(left), self.ends(right), strict=True))  # type: ignore[arg-type]
            for at, left, right in _neighbours(self.rows)
        ]

    def undecided(self, boxes: Iterable[Join]) -> list[Layer]:
        """Hatched boxes, wide enough to be seen."""
        (a, b), (low, high) = self.window
        found = [(_visible(*at, b - a), _visible(*ends, high - low)) for at, ends in boxes]
        return [_Boxes(found, label="undecided")] if found else []

    def left_open(self) -> Iterator[Join]:
        """Yield what slices leave undecided, each halfway to its neighbours."""
        low, high = self.asked[1]
        at = [x for x, _ in self.rows]
        # Each slice stands for the values that are nearer to it than to its neighbours.
        middles = [at[0], *((a + b) / 2 for a, b in pairwise(at)), at[-1]] if at else []
        for (_, r), around in zip(self.rows, pairwise(middles), strict=True):
            for piece in r.undecided:
                yield around, _limits(piece, low, high)

    def unlike(self, rows: Rows, *, decided: bool = False) -> Iterator[Join]:
        """Yield the intervals of neighbouring slices that differ in number; ``decided`` : only if
        nothing is open on either."""
        for (x, one), (y, other) in pairwise(rows):
            if not (_are_alike(one, other) or (decided and (one.undecided or other.undecided))):
                yield from (((x, y), self.ends(span)) for span in one.feasible + other.feasible)


def _around(values: Sequence[float], asked: Pair) -> Pair:
    """An interval about values with some room, within the range asked; all of that where it is
    nearly all or there are none."""
    if not values:
        return asked
    start, end = asked
    whole = end - start
    low, high = max(min(values), start), min(max(values), end)
    room = _ROOM * (high - low) or 0.1 * whole
    low, high = max(start, low - room), min(end, high + room)
    return (low, high) if high - low < 0.7 * whole else asked


def _are_alike(one: Requirement, other: Requirement) -> bool:
    """Whether two slices have as many intervals."""
    return len(one.feasible) == len(other.feasible)


def _neighbours(rows: Rows) -> Iterator[tuple[Pair, Piece, Piece]]:
    """Between slices with as many intervals: where they are, and the intervals that belong
    together."""
    for (x, one), (y, other) in pairwise(rows):
        if _are_alike(one, other):
            yield from (((x, y), *pair) for pair in zip(one.feasible, other.feasible, strict=True))


@dataclass(frozen=True)
class _Lines(Layer):
    """Straight lines, each between two places."""

    lines: Sequence[tuple[Pair, Pair]]
    color: str
    width: float

    def draw(self, on: On) -> list[Artist]:
        segments = [
            np.column_stack([on.x.of([a, c]), on.y.of([b, d])]) for (a, b), (c, d) in self.lines
        ]
        style: dict[str, Any] = {
            "colors": on.ink(self.color),
            "linewidths": self.width,
            "zorder": 1,
            **self.look,
        }
        return [on.ax.add_collection(LineCollection(segments, **style))]

    def keys(self, _on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        return [(self.label, made[0])] if self.label and self.lines else []


@dataclass(frozen=True)
class _Between(Layer):
    """A ground between two upright sides: where they are, and the lower and upper end of either."""

    at: Pair
    low: Pair
    high: Pair
    color: str = pen.SHADE
    alpha: float = 1.0

    def draw(self, on: On) -> list[Artist]:
        if on.number:
            return []
        style: dict[str, Any] = {
            "color": self.color,
            "alpha": self.alpha,
            "linewidth": 0,
            "antialiased": False,
        }
        return [
            on.ax.fill_between(
                on.x.of(self.at),
                on.y.of(self.low),
                on.y.of(self.high),
                zorder=int(self.alpha < 1),
                **style,
            )
        ]


@dataclass(frozen=True)
class _Boxes(Layer):
    """Hatched boxes where nothing is decided."""

    boxes: Sequence[Join]

    def draw(self, on: On) -> list[Artist]:
        made: list[Artist] = []
        for at, (low, high) in self.boxes:
            x, y = on.x.of(at), on.y.of([[low] * 2, [high] * 2])
            made.append(on.ax.fill_between(x, *y, zorder=1, **UNDECIDED))
        return made


def _bands(plane: _Plane, joins: Iterable[Join]) -> list[Layer]:
    """A band about each line, as wide as it may be off, as estimated."""
    widths = {(gap.low, gap.high): gap.deviation or 0.0 for gap in plane.found.gaps}
    bands = list[Layer]()
    for at, (left, right) in joins:
        width = widths.get(at, 0.0)
        # A narrower band would be hidden by the line itself.
        if width > _VISIBLE * plane.found.height:
            low, high = (left - width, right - width), (left + width, right + width)
            bands.append(_Between(at, low, high, pen.OPEN, 0.6))
    if not bands:
        return []
    patch = Patch(facecolor=pen.OPEN, alpha=0.6)
    return [*bands, _Key(patch, label="boundary between slices, estimated")]


@dataclass(frozen=True)
class _Key(Layer):
    """An entry of the legend alone."""

    handle: Artist

    def draw(self, on: On) -> list[Artist]:
        return [] if on.number else [self.handle]


def _ground(cells: Array, label: str, color: str = pen.SHADE, zorder: float = 0) -> list[Layer]:
    """Return proven rectangles as a ground; nothing where there are none."""
    return [Ground(cells[:, 0].T, cells[:, 1].T, color, zorder, label=label)] if len(cells) else []


def _left(found: DesignMap) -> list[Layer]:
    """Return the rectangles in which neither is proven: boundaries of what is transparent, and of
    what is stable, lie in these.

    Where a second pair of roots crosses the axis neither side is stable: such rectangles are
    undecided without a boundary.
    """
    made: list[Layer] = []
    for name, color in _LEFT.items():
        for x in (x for x in found.proofs if x.of == name):
            word = in_words(name, found.criteria)
            what = f"{word}: undecided" if len(found.that) > 1 or found.thresholds else "undecided"
            made += _ground(x.rectangles.left, f"{what}, holds the boundary", color, 0.5)
    return made


_AT = {
    Kind.EDGE: "at the band's edge",
    Kind.START: "at the band's low end",
    Kind.TOUCH: "tangency",
    Kind.AXIS: "poles on the axis",
    Kind.FAR: "at high frequency",
}
_FILL = {
    Kind.EDGE: "full",
    Kind.START: "none",
    Kind.TOUCH: "bottom",
    Kind.AXIS: "full",
    Kind.FAR: "none",
}


def slices(found: DesignMap) -> Panel:
    """The transparent region: each exact slice as an upright stroke with marks where it ends, by
    what limits there.

    Where more than the slices is proven, the ground is, and a band in which the boundary lies;
    lines that join slices are interpolation. Elsewhere the ground is too, and the legend says so; a
    band about lines is as wide as they may be off, as estimated, and what lies between slices that
    differ in kind is hatched, as is what slices leave undecided. Ticks on the lower axis: where the
    slices are.

    >>> from haptisym import design_map, load_scene
    >>> ranges = [(60, 200), (0.1, 1)]
    >>> found = design_map(load_scene("fu2019"), ["omega_n", "zeta"], ranges, slices=5)
    >>> [layer.label for layer in slices(found).layers if isinstance(layer, Limits)]
    ["imaginary part, at the band's edge"]
    """
    plane = _Plane(found)
    word = plane.transparent
    somewhere = any(r.feasible for _, r in plane.rows)
    if found.proofs:
        # A map of transparency for one threshold has one proof, if any.
        [proof] = found.proofs
        ground, bands = _ground(proof.rectangles.kept, f"{word}, proven"), _left(found)
    else:
        between = plane.interpolated()
        key = (
            [_Key(Patch(facecolor=pen.SHADE), label="between slices: interpolated")]
            if between
            else []
        )
        ground, bands = [*between, *key], _bands(plane, [join for join, _ in _joins(plane)])
    boxes = (*plane.left_open(), *(() if found.proofs else plane.unlike(plane.rows)))
    nowhere = f"{word} nowhere" if found.certified else f"nowhere proven {word}"
    note = [] if somewhere else [Note(f"{nowhere}: on none of {len(found.slices)} exact slices")]
    layers = [
        plane.strokes(pen.GREY, 0.7, f"{word} on the slice" if somewhere else ""),
        *ground,
        *boundary(found),
        *bands,
        *plane.undecided(boxes),
        _Ticks(plane.places(), label="exact slices"),
        *note,
    ]
    x, y = plane.axes()
    return Panel(layers, x, y, height=2.6)


@dataclass(frozen=True)
class _Ticks(Layer):
    """Ticks on the lower axis where the slices are."""

    at: Sequence[float]

    def draw(self, on: On) -> list[Artist]:
        style: dict[str, Any] = {
            "color": on.ink(pen.GREY),
            "linestyle": "none",
            "marker": 3,
            "markersize": 2.5,
        }
        return list(
            on.ax.plot(
                on.x.of(self.at),
                [0] * len(self.at),
                transform=on.ax.get_xaxis_transform(),
                clip_on=False,
                **style,
            )
        )

    def keys(self, on: On, _made: list[Artist]) -> list[tuple[str, Artist]]:
        return [(self.label, handle(on.ink(pen.GREY), "none", "", marker="|", markersize=5))]


@dataclass(frozen=True)
class Limits(Layer):
    """The ends of slices at which the same condition limits, as marks; in the legend with the line
    that joins them."""

    x: Sequence[float]
    y: Sequence[float]
    color: str
    stroke: Any
    marker: str
    fill: str
    width: float = 0.6
    styled: bool = field(default=True, kw_only=True)

    def draw(self, on: On) -> list[Artist]:
        return list(
            on.ax.plot(
                on.x.of(self.x),
                on.y.of(self.y),
                color=on.ink(self.color),
                zorder=3,
                **self._mark("none"),
            )
        )

    def keys(self, on: On, _made: list[Artist]) -> list[tuple[str, Artist]]:
        return [
            (
                self.label,
                handle(on.ink(self.color), self.stroke, "", self.width, **self._mark(self.stroke)),
            )
        ]

    def _mark(self, stroke: Any) -> dict[str, Any]:
        """Return the look of the marks, with or without the line that joins them."""
        style = {
            "marker": self.marker,
            "markersize": 2.8,
            "markeredgewidth": 0.6,
            "fillstyle": self.fill,
        }
        return {**style, "markerfacecoloralt": "white", "linestyle": stroke}


def boundary(found: DesignMap, width: float = 0.6) -> list[Layer]:
    """The ends of all slices, marked by what limits there, joined by lines that interpolate;
    ``width`` : of these, points."""
    plane, made = _Plane(found), list[Layer]()
    for (at, ends), binding in _joins(plane):
        look = _look_of(binding.criterion)
        made.append(
            Polyline(at, ends, look.color, look.stroke, width, styled=False, look={"zorder": 2})
        )
    # Ends are grouped by what limits there, for one kind of mark and one entry of the legend each.
    places: dict[tuple[Criterion, Kind], list[Pair]] = {}
    for x in found.slices:
        for end in x.requirement.ends:
            if end.bindings and end.value is not None:
                key = (end.bindings[0].criterion, end.bindings[0].kind)
                places.setdefault(key, []).append((float(x.at), float(end.value)))
    for (criterion, kind), listed in places.items():
        look, label = _look_of(criterion), f"{criterion.words}, {_AT[kind]}"
        xs, ys = [a for a, _ in listed], [b for _, b in listed]
        made.append(
            Limits(xs, ys, look.color, look.stroke, look.marker, _FILL[kind], width, label=label)
        )
    return made


def _joins(plane: _Plane) -> Iterator[tuple[Join, Binding]]:
    """Yield the lines that join the ends of neighbouring slices, and what limits along each; none
    along the ends of the range."""
    for at, left, right in _neighbours(plane.rows):
        pairs = zip(plane.ends(left), plane.ends(right), strict=True)
        for pair, one, other in zip(
            pairs, (left.first, left.last), (right.first, right.last), strict=True
        ):
            if one and other and one.bindings and other.bindings:
                yield (at, pair), one.bindings[0]


def wishes(found: DesignMap) -> Panel:
    """What was asked, each set along its exact slices in its own colour, and what they have in
    common on a grey ground.

    What joins the slices is interpolation. Of what is transparent, and mostly of what is stable, a
    band in which its boundary lies is proven; of other sets one about the lines is as wide as they
    may be off, as estimated, and what lies between slices that differ in kind is hatched, as is
    what slices leave undecided. The ground is proven where all that is asked is, and interpolation
    elsewhere. Classical bounds are thin lines with their names.
    """
    plane = _Plane(found)
    layers, joins, boxes = _whole_ground(plane), list[Join](), list(plane.left_open())
    for name, look, rows in plane.sets():
        layers += _outlined(plane, rows, look)
        if not _is_proven(found, name):
            joins += _inner_joins(plane, rows)
            boxes += plane.unlike(rows, decided=True)
    strokes = plane.strokes(pen.GREY, 0.6, f"{_whole(found)}, exact slices")
    layers += [*_left(found), *_bands(plane, joins), strokes, *plane.undecided(boxes)]
    for line, stroke in zip(found.lines, _STROKES, strict=False):
        layers += _classical(plane, line, stroke)
    x, y = plane.axes()
    return Panel(layers, x, y, height=2.8)


def _is_proven(found: DesignMap, name: str) -> bool:
    """Whether more than slices of a set is proven."""
    return any(x.of == name for x in found.proofs)


def _whole(found: DesignMap) -> str:
    """Return the name of what all sets have in common."""
    return "all that is asked" if len(found.that) > 1 else "this set"


def _whole_ground(plane: _Plane) -> list[Layer]:
    """Proven, where all that is asked is; else interpolated between slices."""
    found, whole = plane.found, _whole(plane.found)
    if all(_is_proven(found, name) for name in found.that):
        return _ground(
            common([x.rectangles for x in found.proofs if x.jnd is None]), f"{whole}, proven"
        )
    return [*plane.interpolated(), _Key(Patch(facecolor=pen.SHADE), label=f"{whole}, interpolated")]


def _inner_joins(plane: _Plane, rows: Rows) -> Iterator[Join]:
    """The lines that join the ends of neighbouring slices, but for those along the ends of the
    range."""
    for at, left, right in _neighbours(rows):
        pairs = zip(plane.ends(left), plane.ends(right), strict=True)
        yield from ((at, pair) for pair in pairs if not all(y in plane.asked[1] for y in pair))


def _outlined(plane: _Plane, rows: Rows, look: tuple[str, str]) -> list[Layer]:
    """Return the ends of one set, in its colour and by its name: lines that interpolate, and a dot
    where each slice has proven one."""
    (color, name), joins = look, list(_inner_joins(plane, rows))
    ends = [(x, float(e.value)) for x, r in rows for e in r.ends if e.value is not None]
    if not (ends or joins):
        return [Words(label=f"{name}: ends on no slice")]
    lines = [
        Polyline(at, pair, color, width=0.9, styled=False, look={"zorder": 2}) for at, pair in joins
    ]
    marks = Mark([x for x, _ in ends], [y for _, y in ends], color, size=1.8, look={"zorder": 3})
    key = {"color": color, "linestyle": "-", "linewidth": 0.9, "marker": "o", "markersize": 2.2}
    return [*lines, marks, Words(label=name, look=key)]


def _paler(i: int, count: int) -> str:
    """The colour of what is transparent, paler for each further threshold."""
    # At most 0.65 of the way to white, so that the palest is seen on white paper.
    r, g, b = (x + (1 - x) * (0.25 + 0.4 * (i + 1) / count) for x in to_rgb(_COLORS["transparent"]))
    return to_hex((r, g, b))


def _classical(plane: _Plane, line: StiffnessBound, stroke: Any) -> list[Layer]:
    """Return the line on which a classical bound is met, by its sign on a grid: drawn, not
    proven."""
    if line.where:
        return _at_an_edge(plane, line)
    x, y = (np.linspace(*ends, _CLASSICAL) for ends in plane.window)
    one, other = (free.path for free in plane.found.free)
    with np.errstate(all="ignore"):
        excess: Array = np.array([[_finite(line, {one: u, other: v}) for u in x] for v in y])
    # Without a change of sign there is no line, and matplotlib would warn that it found none.
    if not (np.nanmin(excess) < 0 < np.nanmax(excess)):
        return []
    return [_Contour(x, y, excess, stroke, label=line.name)]


@dataclass(frozen=True)
class _Contour(Layer):
    """The line on which numbers on a grid are 0."""

    x: Array
    y: Array
    z: Array
    stroke: Any

    def draw(self, on: On) -> list[Artist]:
        style: dict[str, Any] = {
            "colors": pen.INK,
            "linestyles": [self.stroke],
            "linewidths": 0.9,
            "zorder": 2,
        }
        on.ax.contour(on.x.of(self.x), on.y.of(self.y), self.z, [0.0], **style)
        return [handle(pen.INK, self.stroke, "", 0.9)]


def _at_an_edge(plane: _Plane, line: StiffnessBound) -> list[Layer]:
    """Return a bound that is defined at one value of one parameter alone: a mark where it is met
    there, if the map reaches there."""
    [(path, value)] = line.where
    paths, windows = [free.path for free in plane.found.free], plane.window
    i = paths.index(path)
    (low, high), (start, end) = windows[i], windows[1 - i]
    excess = [line.excess({path: value, paths[1 - i]: y}) for y in (start, end)]
    if not (low <= value <= high and excess[0] < 0 < excess[1]):
        return []
    # The excess is the stiffness less a number, a line of slope 1 in the stiffness.
    met = start - excess[0]
    x, y = (value, met) if i == 0 else (met, value)
    look = {"clip_on": False}
    return [
        Mark(
            [x],
            [y],
            shape="D",
            size=4,
            face="none",
            look=look,
            label=f"{line.name} (b = {value:g})",
        )
    ]


def _finite(line: StiffnessBound, at: Mapping[str, float]) -> float:
    """Return the excess in floats; NaN where the bound divides by zero."""
    try:
        return float(line.excess(dict(at)))
    except ZeroDivisionError:
        return float("nan")


def design_map(found: DesignMap) -> Panel:
    """A map of two parameters; of several things or thresholds asked, each set for itself and what
    they have in common."""
    return wishes(found) if found.that != ("transparent",) or found.thresholds else slices(found)


DESIGN_MAP = Drawings[DesignMap](
    {"map": design_map, "wishes": wishes, "slices": slices},
    {"map": lambda m, style: sheet(design_map(m), style=style)},
)
