"""Figures of stability and of tolerances: the plane of a hand or of a wall, and where ratios may
cross for all values in ranges.

The plane of a hand is that of its stiffness and damping, for one mass: where the display is stable,
the boundary, published hands, and the ranges of a hand that has some. Of a display with ranges:
where it is stable for all its values, and where for none. Of a display with a clock: the plane of
the stiffness and damping of the wall that it renders. Begin with ``hand_plane``, ``held`` and
``enclosures``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from sympy import Expr, Rational, Symbol

from haptisym.figures import pen
from haptisym.figures.curves import threshold_symbol, written
from haptisym.figures.files import Drawings, sheet
from haptisym.figures.layers import (
    DrawnAxis,
    Ground,
    Layer,
    Limit,
    Mark,
    On,
    Panel,
    PatchLayer,
    Polyline,
    Room,
    Span,
    Words,
    dots,
    frequency,
    handle,
    number,
    parameter,
    small,
)
from haptisym.kernel.errors import NothingToDrawError, UndecidedError
from haptisym.model.catalogue import NOBODY, Hand
from haptisym.model.catalogue import hands as published
from haptisym.model.quantities import Dimension, MotionKind, Unit, unit_text
from haptisym.model.scene import clocks
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability.entry import WALL, Stability, has_plane
from haptisym.verbs.stability.plane import Plane, Window, boundary, plane, wall_plane
from haptisym.verbs.stability.ranges import HeldPlane, held_plane
from haptisym.verbs.tolerances.proofs import Tolerances
from haptisym.writing.characters import printable

_ROOM = 1.25  # of the largest number that is shown
_TOGETHER = 2.5  # pt: marks that are nearer to each other cover each other
_NARROW, _RIM = 9, 4  # pixels of a cell in which nothing is written, and of its rim
_NEAR = 20  # times that a critical value may be beyond the hands
_KINDS = (Dimension.MASS, Dimension.DAMPING, Dimension.STIFFNESS)


def hands(found: Stability) -> Panel:
    """The plane of the mass of the first hand; with a clock that of stiffness and damping of the
    wall, in the first hand.

    NothingToDrawError where a display with a clock renders no wall of stiffness and damping.
    """
    return wall(found) if clocks(found.scene) else hand_plane(found)


def wall(found: Stability) -> Panel:
    """Damping against stiffness of the wall that is rendered: a ground where it is not stable, with
    its unstable poles."""
    if not has_plane(found.scene):
        raise NothingToDrawError(
            "the plane of a sampled display is that of a wall's stiffness and damping, and "
            "the scene has none"
        )
    hand = found.held[0].hand if found.held else Hand(NOBODY)
    k_knob, b_knob = (found.scene.knobs[path] for path in WALL)
    present = float(k_knob.value), float(b_knob.value)
    near = [
        [float(x.value) for sets in found.critical[:1] if path in sets for x in sets[path].ends]
        for path in WALL
    ]
    # The axes show the scene's wall with as much again, and limits that are not too far off.
    k = _ROOM * max([2 * present[0], *(x for x in near[0] if x < _NEAR * present[0])]) or 1.0
    # k T is of the size of the damping that a clock takes from a wall: Colgate and Schenkel ask for
    # more than k T/2.
    b = _ROOM * max(
        [
            2 * present[1],
            k * float(clocks(found.scene)[0]),
            *(x for x in near[1] if x < _NEAR * present[1]),
        ]
    )
    try:
        drawn = wall_plane(found.scene, hand, (0.0, k, 0.0, b))
    except UndecidedError as error:
        raise NothingToDrawError(str(error)) from None
    layers = [
        *_grounds(drawn),
        Mark(
            [present[0]],
            [present[1]],
            size=3.5,
            look={"clip_on": False},
            label=f"the scene, in {printable(hand.name)}",
        ),
        _Counts(drawn),
    ]
    x, y = parameter(k_knob, "", (0, k)), parameter(b_knob, "", (0, b))
    x = replace(x, label=f"stiffness of the wall, {x.label}")
    return Panel(layers, x, replace(y, label=f"damping of the wall, {y.label}"), height=2.6)


def hand_plane(found: Stability) -> Panel:
    """Stiffness against damping of hands of one mass: a ground where the display is not stable,
    with its unstable poles.

    The mass is that of the first hand that was asked about, or 0.5 kg (or 0.01 kg m^2) where none
    was. Filled: the hands that were asked about, if they are of that mass; hollow: published
    ones, whatever theirs.

    >>> from haptisym import stability
    >>> drawn = hand_plane(stability("delayed-spring", "light-touch"))
    >>> [x.label for x in drawn.layers if x.label][0]
    'boundary'
    """
    asked = [x.hand for x in found.held]
    turning = found.scene.motion is MotionKind.ROTATION
    own = asked[0] if asked else Hand("none", "0.01 kg*m^2" if turning else "0.5 kg")
    shown = (
        []
        if turning
        else [x for name, x in published.items() if name not in {y.name for y in asked}]
    )
    drawn = plane(found.scene, own, _window(found, [*asked, *shown]))
    layers = [*_boundary(drawn), *_grounds(drawn), *_ranges(asked), *_hands(asked, shown, drawn)]
    return Panel(layers, *_axes(found.scene.motion, number(drawn.mass), drawn.window), height=2.6)


def _axes(motion: MotionKind | None, mass: str, window: Window) -> tuple[DrawnAxis, DrawnAxis]:
    """Return the axes of the plane of hands of one mass: stiffness, and damping."""
    unit, damping, stiffness = (x.unit(motion or MotionKind.TRANSLATION) for x in _KINDS)
    low, high, least, most = window
    x = DrawnAxis(r"hand's stiffness $k_\mathrm{h}$", Unit(stiffness), (low, high))
    x = replace(x, label=f"{x.label}, mass {mass} {unit_text(unit)}")
    return x, DrawnAxis(r"hand's damping $b_\mathrm{h}$", Unit(damping), (least, most))


def _window(found: Stability, shown: Iterable[Hand]) -> Window:
    """Return the ends of both axes: room for the hands, their ranges, limits that are not far, and
    the line of a pole at 0 if it is near."""
    ends = [[(p.interval or (p.value, p.value))[1] for p in x.parameters] for x in shown]
    most = [max((float(x[i]) for x in ends), default=0.0) for i in (1, 2)]
    b, k = (x or other for x, other in zip(most, (1.0, 100.0), strict=True))
    near = [
        (path, float(x.value))
        for sets in found.critical
        for path, values in sets.items()
        for x in values.ends
    ]

    def reach(key: str, size: float) -> float:
        limits = (v for path, v in near if path.startswith("hand") and path.endswith(key))
        return max([size, *(v for v in limits if v < _NEAR * size)])

    b, k = reach(".b", b), reach(".k", k)
    # H_perc(0) is the stiffness of the display at rest. A hand whose stiffness is the opposite
    # leaves none, which puts a pole at 0: that line is shown if it is near.
    at_0 = float(
        found.scene.closed.compile(of=("perceived_real",))(np.array([0.0])).perceived_real[0]
    )
    low = -1.3 * at_0 if 0 < at_0 < k else -0.05 * k
    return low, _ROOM * k, -0.05 * b, _ROOM * b


@dataclass(frozen=True)
class _Raster(Layer):
    """A ground where pixels of the window are."""

    where: Any
    window: Window
    color: str

    def draw(self, on: On) -> list[Artist]:
        low, high, least, most = self.window
        x = np.linspace(low, high, self.where.shape[0])
        y = np.linspace(least, most, self.where.shape[1])
        on.ax.contourf(
            on.x.of(x), on.y.of(y), self.where.T, levels=[0.5, 1.5], colors=[self.color], zorder=0
        )
        return [Patch(facecolor=self.color)]


def _grounds(drawn: Plane) -> list[Layer]:
    """Return a ground for the cells that are unstable, and one for those that are undecided."""
    grounds = (
        (
            "unstable",
            pen.UNSTABLE,
            [x for x in drawn.cells if x.roots is not None and not x.is_stable],
        ),
        ("undecided", pen.OPEN, [x for x in drawn.cells if x.roots is None]),
    )
    return [
        _Raster(
            np.any([x.pixels for x in cells], axis=0).astype(float),
            drawn.window,
            color,
            label=label,
        )
        for label, color, cells in grounds
        if cells
    ]


def _boundary(drawn: Plane, label: str = "boundary") -> list[Layer]:
    """Return the boundary of stability, and the line on which a pole is at 0."""
    low, high, least, most = drawn.window
    # Where no part of the boundary is in the window, the legend says so.
    is_here = bool(
        ((drawn.k > low) & (drawn.k < high) & (drawn.b > least) & (drawn.b < most)).any()
    )
    made: list[Layer] = [
        Polyline(drawn.k, drawn.b, pen.BLUE, label=label if is_here else f"{label} (elsewhere)")
    ]
    if drawn.at_0 is not None and low < drawn.at_0 < high:
        made.append(
            Limit(
                drawn.at_0,
                upright=True,
                color=pen.RED,
                stroke=pen.DASHED,
                width=0.9,
                label="pole at 0",
            )
        )
    return made


def _ranges(asked: Iterable[Hand]) -> list[Layer]:
    """Return the rectangle of each hand with ranges of damping and stiffness."""
    style: dict[str, Any] = {"fill": False, "edgecolor": pen.INK, "linewidth": 0.9}
    return [
        PatchLayer(Rectangle((k, b), k_high - k, b_high - b, **style))
        for (k, b), (k_high, b_high) in _corners(asked)
    ]


def _corners(asked: Iterable[Hand]) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
    """Yield two opposite corners of the rectangle of each hand with ranges of damping and
    stiffness."""
    for x in asked:
        if x.k.interval or x.b.interval:
            (k, k_high), (b, b_high) = (
                [float(end) for end in p.interval or (p.value, p.value)] for p in (x.k, x.b)
            )
            yield (k, b), (k_high, b_high)


def _hands(asked: list[Hand], shown: list[Hand], drawn: Plane) -> list[Layer]:
    """Hands by their names: filled where their mass is that of the plane; and the number of
    unstable poles in each cell."""
    here = [x for x in asked if float(x.m.value) == drawn.mass]
    marks: list[Layer] = []
    for x in (*asked, *shown):
        face, color = ("" if x in here else "none"), pen.INK if x in asked else pen.GREY
        k, b = _place(x)
        marks.append(Mark([k], [b], color, size=3.5, face=face, look={"markeredgewidth": 0.7}))
    rim: dict[str, Any] = {"markerfacecolor": "none", "markeredgewidth": 0.7, "color": pen.GREY}
    legend = [Words(label="hand of this mass", look=dots(3.5))] if here else []
    legend += (
        [Words(label="of another mass", look=dots(3.5, **rim))]
        if len(here) < len(asked) + len(shown)
        else []
    )
    return [*marks, *legend, _Counts(drawn, tuple(asked), tuple(shown))]


def _place(x: Hand) -> tuple[float, float]:
    """Return the place of a hand in the plane: its stiffness and its damping."""
    return float(x.k.value), float(x.b.value)


@dataclass(frozen=True)
class _Counts(Layer):
    """Names of hands, and the number of unstable poles in the middle of each cell or beside what
    stands there."""

    drawn: Plane
    asked: tuple[Hand, ...] = ()
    shown: tuple[Hand, ...] = ()

    def draw(self, on: On) -> list[Artist]:
        room, made = self._room(on), list[Artist]()
        size = small(on.ax)
        for hand in self.asked:
            at = room.beside(*_place(hand), printable(hand.name), size)
            made.append(self._named(on, printable(hand.name), _place(hand), at, pen.INK))
        for name, place, count in self._names(room):
            # A published hand that nobody asked about has a name where there is room for it; marks
            # that lie on each other have one in any case, or nothing would say what they are.
            free = room.clear(*place, name, size)
            if free is None and count > 1:
                free = room.beside(*place, name, size)
            if free is not None:
                made.append(self._named(on, name, place, free, pen.GREY))
        low, high, least, most = self.drawn.window
        for x in self.drawn.cells:
            # A number would not fit into a cell that is so narrow.
            if min(np.ptp(np.nonzero(x.pixels), axis=1)) < _NARROW:
                continue
            shown = (
                "?" if x.roots is None else "∞" if x.roots.number is None else f"{x.roots.number}"
            )
            inner = np.argwhere(_without_rim(x.pixels))
            # About 400 places do: each is compared with all that is drawn already.
            share = (inner[:: max(1, len(inner) // 400)] + 0.5) / x.pixels.shape
            others = np.array([low, least]) + share * np.array([high - low, most - least])
            places = [(x.k, x.b), *((float(k), float(b)) for k, b in others)]
            # What a number would cover counts first, then how far it is from the middle of its
            # cell.
            costs = [(room.crowded(at, pen.TEXT), room.away(at, (x.k, x.b))) for at in places]
            at = places[min(range(len(places)), key=costs.__getitem__)]
            made.append(
                on.ax.annotate(
                    shown, at, ha="center", va="center", fontsize=pen.TEXT, color=pen.INK
                )
            )
        return made

    @staticmethod
    def _named(on: On, name: str, place: tuple[float, float], at: Span, color: str) -> Artist:
        """Write a name ``at`` points of the page from its mark, with a line to it from afar."""
        size = small(on.ax)
        far = max(at[0], at[1], -at[1] - size) > size
        leader = {**pen.LEADER, "relpos": (0 if at[0] > 0 else 1, 0 if at[1] > 0 else 1)}
        return on.ax.annotate(
            name,
            place,
            at,
            textcoords="offset points",
            fontsize=size,
            color=color,
            arrowprops=leader if far else None,
        )

    def _names(self, room: Room) -> list[tuple[str, tuple[float, float], int]]:
        """Return what is written beside published hands, where, and of how many: of those whose
        marks lie on each other, how many they are; nothing beside one that lies on a hand which was
        asked about."""
        groups: list[list[Hand]] = []
        asked = [_place(x) for x in self.asked]
        for x in self.shown:
            if any(room.away(y, _place(x)) < _TOGETHER for y in asked):
                continue
            near = (g for g in groups if room.away(_place(g[0]), _place(x)) < _TOGETHER)
            group = next(near, None)
            if group is None:
                groups.append([x])
            else:
                group.append(x)
        return [
            (
                printable(g[0].name) if len(g) == 1 else f"{len(g)} published hands",
                _place(g[0]),
                len(g),
            )
            for g in groups
        ]

    def _room(self, on: On) -> Room:
        """Return what lines and marks have taken of the axes."""
        room, drawn = Room(on.ax), self.drawn
        low, high, least, most = drawn.window
        inside = (drawn.k > low) & (drawn.k < high) & (drawn.b > least) & (drawn.b < most)
        # The boundary leaves the window and comes back: parts inside are lines of their own, so
        # that no line is taken between them.
        for piece in np.split(
            np.arange(len(drawn.k)), np.flatnonzero(np.diff(inside.astype(int))) + 1
        ):
            if len(piece) and inside[piece[0]]:
                room.take_line(drawn.k[piece], drawn.b[piece])
        if drawn.at_0 is not None and low < drawn.at_0 < high:
            room.take_line([drawn.at_0] * 2, [least, most])
        for x in (*self.asked, *self.shown):
            room.take_point(*_place(x))
        for (k, b), (k_high, b_high) in _corners(self.asked):
            room.take_line([k, k_high, k_high, k, k], [b, b, b_high, b_high, b])
        return room


def _without_rim(pixels: Any) -> Any:
    """The pixels of a cell that are some way from its rim."""
    moved = [np.roll(pixels, step, axis) for axis in (0, 1) for step in (-_RIM, _RIM)]
    return np.logical_and.reduce([pixels, *moved])


STABILITY = Drawings[Stability]({"hands": hands})


# Displays with ranges.

_FINEST = (2.0**-8, 2.0**-7)
_COARSE = 2.0**-6
"""Shares of both ranges down to which cells are cut: for no other parameter with a range, for one
other, and for more."""
_MOST = 100_000


def held(a: Tolerances) -> Panel:
    """Stiffness against damping of hands of the first one's mass: grounds where a display is stable
    for all values, and for none.

    Both are proven, over rectangles; between them it depends on the values, or is undecided. The
    line is the boundary for the nominal values, in floats (none with a clock); hollow points are
    published hands, whatever their mass. NothingToDrawError without a hand, and where nothing is
    known.

    >>> from haptisym import load_scene, tolerances
    >>> late = load_scene("delayed-spring").with_values({"tau": "36 ms +- 5 %"})
    >>> drawn = held(tolerances(late, samples=0, hand="postural-arm"))
    >>> [x.label for x in drawn.layers if x.label][:3]
    ['stable for all values', 'for none', 'it depends, or undecided']
    """
    if not a.held:
        raise NothingToDrawError("no hand was asked about")
    scene, asked = a.box.scene, [x.hand for x in a.held]
    first, sampled = asked[0], bool(clocks(scene))
    turning = scene.motion is MotionKind.ROTATION
    shown = (
        []
        if turning
        else [x for name, x in published.items() if name not in {y.name for y in asked}]
    )
    window = _held_window([*asked, *shown], sampled=sampled)
    proven = _found(a, first, window)
    drawn = (
        Plane(float(first.m.value), np.empty(0), np.empty(0), None, window)
        if sampled
        else boundary(scene, first, window)
    )
    rows = (
        (proven.stable, "#ffffff", "stable for all values"),
        (proven.unstable, pen.UNSTABLE, "for none"),
        (proven.left, pen.OPEN, "it depends, or undecided"),
    )
    low, high, least, most = window
    size, corner = np.array([high - low, most - least])[:, None], np.array([low, least])[:, None]
    grounds: list[Layer] = []
    for cells, color, label in rows:
        if len(cells):
            # Cells are proven in shares of the window, from 0 to 1.
            places: Array = corner + cells * size
            grounds.append(Ground(places[:, 0].T, places[:, 1].T, color, label=label))
    lines = [] if sampled else _boundary(drawn, "nominal boundary")
    mass = " to ".join(number(float(x)) for x in first.m.interval or (first.m.value,))
    layers = [*grounds, *lines, *_ranges(asked), *_hands(asked, shown, drawn)]
    return Panel(layers, *_axes(scene.motion, mass, window), height=2.6)


def _found(a: Tolerances, hand: Hand, window: Window) -> HeldPlane:
    """Return what is proven of the plane; NothingToDrawError where nothing is."""
    # The shortest decimals of the floats, as exact numbers: their exact binary values are long.
    low, high, least, most = (Rational(str(x)) for x in window)
    ranges = a.box.scene.ranges().values()
    others: dict[Symbol, tuple[Expr, Expr]] = {
        x.symbol: x.interval for x in ranges if x.interval and not x.parts
    }
    if hand.m.interval:
        others[hand.m.symbol] = hand.m.interval
    finest = _FINEST[len(others)] if len(others) < len(_FINEST) else _COARSE
    try:
        free = {hand.k.symbol: (low, high), hand.b.symbol: (least, most)}
        return held_plane(a.box.scene, [hand], free, others, finest=finest, most=_MOST)
    except UndecidedError as error:
        raise NothingToDrawError(f"of hands nothing is known: {error}") from None


def _held_window(listed: Sequence[Hand], *, sampled: bool) -> Window:
    """Return the ends of both axes, from 0 on (a little less without a clock), with room for the
    hands and their ranges."""
    ends = [[float((p.interval or (p.value, p.value))[1]) for p in (x.k, x.b)] for x in listed]
    k, b = (max(column) for column in zip(*ends, strict=True))
    k, b = (k or 100.0, b or 1.0)
    below = 0.0 if sampled else 0.05
    return -below * k, _ROOM * k, -below * b, _ROOM * b


_HEIGHT = 0.7


def enclosures(a: Tolerances) -> Panel:
    """A row for each ratio: grey where it may cross, proven; dots for each drawn set of values; a
    stroke for the nominal ones.

    Enclosures of a further scene are outlines, in the row of what they are about.
    NothingToDrawError where no values bring a crossing.

    >>> from haptisym import load_scene, tolerances
    >>> chart = enclosures(tolerances(load_scene("fu2019-tolerances"), samples=20))
    >>> list(dict.fromkeys(layer.label for layer in chart.layers if layer.label))
    ['for all values', 'drawn at random', 'nominal values']
    """
    if not _has_rows(a):
        raise NothingToDrawError("nothing is met on the band, for any values within the ranges")
    every, drawn, nominal = list[Layer](), list[Layer](), list[Layer]()
    for x in a.criteria:
        # Two formulas become one: the closing and the opening $ between them are cut.
        name = x.joint.kind if x.joint else f"{written(x)[:-1]} = {threshold_symbol(x)[1:]}"
        spans = [(float(i.low), float(i.high)) for i in a.enclosures if i.criterion == x]
        every.append(_Row(name, spans, label="for all values", styled=True))
        drawn.append(
            _Drawn(
                name,
                [(float(w), n) for n, one in enumerate(a.samples) for w in one.crossings[x.name]],
                label="drawn at random",
            )
        )
        nominal.append(
            _Strokes(name, [float(w) for w in a.nominal.crossings[x.name]], label="nominal values")
        )
    low, high = (float(x) for x in a.box.scene.band)
    rows = [x.row for x in every if isinstance(x, _Row)]
    height = 1.5 if len(a.criteria) > 1 else 1.3
    return Panel(
        [*every, *drawn, *nominal],
        frequency(a.box.scene.frequency, (low, high)),
        DrawnAxis(names=rows),
        height=height,
    )


@dataclass(frozen=True)
class _Row(Layer):
    """Bars in a row that has a name."""

    row: str
    spans: Sequence[tuple[float, float]]

    def draw(self, on: On) -> list[Artist]:
        at, made = list(on.y.names).index(self.row), list[Artist]()
        face: dict[str, Any] = {
            "facecolor": pen.SHADE,
            "edgecolor": on.ink(pen.GREY),
            "linewidth": 0.5,
        }
        if on.number:
            face |= {"facecolor": "none", "linewidth": 1.0}
        for low, high in map(on.x.of, self.spans):
            made += on.ax.barh(at, high - low, left=low, height=_HEIGHT, zorder=1, **face)
        return made


@dataclass(frozen=True)
class _Drawn(Layer):
    """Dots in a row, spread upwards by their numbers to tell them apart."""

    row: str
    places: Sequence[tuple[float, int]]

    def draw(self, on: On) -> list[Artist]:
        at = list(on.y.names).index(self.row)
        # Multiples of the golden ratio, without their whole parts, spread evenly however many there
        # are.
        heights = [at + 0.5 * ((n * 0.618) % 1 - 0.5) for _, n in self.places]
        return Mark(
            [x for x, _ in self.places], heights, pen.BLUE, ".", 1.6, look={"zorder": 2}
        ).draw(on)

    def keys(self, on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        return [(self.label, handle(on.ink(pen.BLUE), "none", "", **dots(2.2)))] if made else []


@dataclass(frozen=True)
class _Strokes(Layer):
    """Upright strokes in a row."""

    row: str
    places: Sequence[float]

    def draw(self, on: On) -> list[Artist]:
        if not self.places:
            return []
        at = list(on.y.names).index(self.row)
        ends = at - _HEIGHT / 2, at + _HEIGHT / 2
        return [
            on.ax.vlines(
                on.x.of(self.places), *ends, color=on.ink(pen.INK), linewidth=1.4, zorder=3
            )
        ]

    def keys(self, on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        return (
            [(self.label, handle(on.ink(pen.INK), "none", "", **dots(7, "|", markeredgewidth=1.4)))]
            if made
            else []
        )


def _has_rows(a: Tolerances) -> bool:
    """Return whether any values bring a crossing, so that there are rows to draw."""
    return (
        bool(a.enclosures)
        or any(a.nominal.crossings.values())
        or any(any(x.crossings.values()) for x in a.samples)
    )


def tolerances(a: Tolerances, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """The rows of both parts, and below them the plane of the hand; NothingToDrawError where there
    is neither."""
    if a.held:
        with suppress(NothingToDrawError):
            below = held(a)
            charts = (enclosures(a), below) if _has_rows(a) else (below,)
            return sheet(*charts, joined=False, style=style)
    return sheet(enclosures(a), style=style)


TOLERANCES = Drawings[Tolerances](
    {"enclosures": enclosures, "hands": held},
    {
        "tolerances": tolerances,
        "enclosures": lambda a, style: sheet(enclosures(a), style=style),
        "hands": lambda a, style: sheet(held(a), style=style),
    },
)
