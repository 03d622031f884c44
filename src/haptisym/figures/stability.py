"""The plane of a hand or of a wall: where the display is stable.

The plane of a hand: where the display is stable, the boundary, published hands, and the box of a hand with ranges.

The plane of a hand, of a display whose values are known as ranges: where it is stable for all of them, where for none.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from sympy import Expr, Rational, Symbol

from haptisym.figures import pen
from haptisym.figures.sheet import one_column
from haptisym.figures.style import Room, dress, handle, legend, number, rectangles
from haptisym.kernel.errors import NothingToDrawError, UndecidedError
from haptisym.model.catalogue import NOBODY, Hand, hands
from haptisym.model.catalogue import hands as published
from haptisym.model.quantities import Dimension, MotionKind, unit_text
from haptisym.model.scene import clocks
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability.entry import WALL, Stability, has_plane
from haptisym.verbs.stability.plane import Plane, Window, boundary, plane, wall_plane
from haptisym.verbs.tolerances.heldbox import HeldPlane, held_plane
from haptisym.verbs.tolerances.proofs import Tolerances

_SMALLER = pen.SMALL - 1
ROOM = 1.25  # of the largest number that is shown
_TOGETHER = 2.5  # pt: marks that are nearer to each other cover each other
_NARROW, _RIM = 9, 4  # pixels of a cell in which nothing is written, and of its rim
_NEAR = 20  # times that a critical value may be beyond the hands


def stability_figure(found: Stability) -> Figure:
    """The plane of the mass of the first hand; with a clock that of stiffness and damping of the wall, in the first hand.

    NothingToDrawError where a display with a clock renders no wall of stiffness and damping.
    """
    return one_column(2.6, lambda ax: draw_stability(ax, found))


def draw_stability(ax: Axes, found: Stability) -> list[Artist]:
    """On axes: the plane of hands, or with a clock of walls."""
    return draw_wall(ax, found) if clocks(found.scene) else draw_plane(ax, found)


def draw_wall(ax: Axes, found: Stability) -> list[Artist]:
    """Damping against stiffness of the wall that is rendered: a ground where it is not stable, with the number of roots."""
    if not has_plane(found.scene):
        raise NothingToDrawError(
            "with a clock the plane is that of a wall's stiffness and damping, and the scene has none"
        )
    hand = found.held[0].hand if found.held else Hand(NOBODY)
    own = [float(found.scene.knobs[path].value) for path in WALL]
    near = [
        [float(x.value) for rows in found.critical[:1] for row in rows for x in row.found if x.path == path]
        for path in WALL
    ]
    k = ROOM * max([2 * own[0], *(x for x in near[0] if x < _NEAR * own[0])]) or 1.0
    b = ROOM * max([2 * own[1], k * float(clocks(found.scene)[0]), *(x for x in near[1] if x < _NEAR * own[1])])
    try:
        drawn = wall_plane(found.scene, hand, (0.0, k, 0.0, b))
    except UndecidedError as error:
        raise NothingToDrawError(str(error)) from None
    ax.set(xlim=(0, k), ylim=(0, b))
    made = _ground(ax, drawn)
    ax.plot(*own, "o", color=pen.INK, markersize=3.5, clip_on=False)
    _counts(ax, drawn, _room(ax, drawn))
    dress(ax)
    damping, stiffness = (unit_text(x.unit(found.scene.motion or MotionKind.TRANSLATION)) for x in _KINDS[1:])
    ax.set_xlabel(rf"stiffness of the wall, $k$ ({stiffness}), hand: {hand.name}", fontsize=pen.TEXT)
    ax.set_ylabel(rf"damping of the wall, $b$ ({damping})", fontsize=pen.TEXT)
    made.append(handle(pen.INK, "none", "the scene", marker="o", markersize=3.5))
    legend(ax, made)
    return made


def draw_plane(ax: Axes, found: Stability, hand: Hand | None = None) -> list[Artist]:
    """Stiffness against damping of hands of one mass: a ground where the display is not stable, with the number of roots.

    ``hand`` : whose mass it is; the first that was asked about, or 0.5 kg (or 0.01 kg m^2) where none was. Filled: the hands that
    were asked about, if they are of that mass; hollow: published ones, whatever theirs. Returns what the legend has.

    >>> from haptisym import stability
    >>> drawn = draw_plane(Figure().add_subplot(), stability("delayed-spring", "light-touch"))
    >>> [x.get_label() for x in drawn][0]
    'boundary'
    """
    asked = [x.hand for x in found.held]
    turning = found.scene.motion is MotionKind.ROTATION
    own = hand or (asked[0] if asked else Hand("none", "0.01 kg*m^2" if turning else "0.5 kg"))
    shown = [] if turning else [x for name, x in hands.items() if name not in {y.name for y in asked}]
    drawn = plane(found.scene, own, _window(found, [*asked, *shown]))
    low, high, least, most = drawn.window
    ax.set(xlim=(low, high), ylim=(least, most))
    made = [
        *draw_boundary(ax, drawn),
        *_ground(ax, drawn),
        *draw_boxes(ax, asked),
        *draw_points(ax, asked, shown, drawn),
    ]
    name_axes(ax, found.scene.motion, number(drawn.mass))
    legend(ax, made)
    return made


def name_axes(ax: Axes, motion: MotionKind | None, mass: str) -> None:
    """Of a plane of hands of that mass."""
    dress(ax)
    unit, damping, stiffness = (unit_text(x.unit(motion or MotionKind.TRANSLATION)) for x in _KINDS)
    ax.set_xlabel(rf"$k_\mathrm{{h}}$ ({stiffness}), for a hand of {mass} {unit}", fontsize=pen.TEXT)
    ax.set_ylabel(rf"$b_\mathrm{{h}}$ ({damping})", fontsize=pen.TEXT)


_KINDS = (Dimension.MASS, Dimension.DAMPING, Dimension.STIFFNESS)


def _window(found: Stability, shown: Iterable[Hand]) -> Window:
    """Room for the hands, their boxes, critical values that are not far, and the line of the root at 0 if it is near."""
    ends = [[(p.interval or (p.value, p.value))[1] for p in x.parameters] for x in shown]
    most = [max((float(x[i]) for x in ends), default=0.0) for i in (1, 2)]
    b, k = (x or other for x, other in zip(most, (1.0, 100.0), strict=True))
    near = [(x.path, float(x.value)) for rows in found.critical for row in rows for x in row.found]
    b = max([b, *(v for path, v in near if path.startswith("hand") and path.endswith(".b") and v < _NEAR * b)])
    k = max([k, *(v for path, v in near if path.startswith("hand") and path.endswith(".k") and v < _NEAR * k)])
    at_0 = float(found.scene.closed.compile(of=("perceived_real",))(np.array([0.0])).perceived_real[0])
    low = -1.3 * at_0 if 0 < at_0 < k else -0.05 * k
    return low, ROOM * k, -0.05 * b, ROOM * b


def _ground(ax: Axes, drawn: Plane) -> list[Artist]:
    """Cells by whether they are stable."""
    low, high, least, most = drawn.window
    grounds = (
        ("not stable", pen.UNSTABLE, [x for x in drawn.cells if x.roots is not None and not x.is_stable]),
        ("not decided", pen.SHADE, [x for x in drawn.cells if x.roots is None]),
    )
    made: list[Artist] = []
    for label, color, cells in grounds:
        if cells:
            where = np.any([x.pixels for x in cells], axis=0).astype(float)
            x, y = np.linspace(low, high, where.shape[0]), np.linspace(least, most, where.shape[1])
            ax.contourf(x, y, where.T, levels=[0.5, 1.5], colors=[color], zorder=0)
            made.append(Patch(facecolor=color, label=label))
    return made


def draw_boundary(ax: Axes, drawn: Plane, label: str = "boundary") -> list[Artist]:
    """The boundary, and where a root is at 0."""
    ax.plot(drawn.k, drawn.b, color=pen.BLUE, linewidth=1.1)
    low, high, least, most = drawn.window
    is_here = bool(((drawn.k > low) & (drawn.k < high) & (drawn.b > least) & (drawn.b < most)).any())
    made: list[Artist] = [handle(pen.BLUE, pen.SOLID, label if is_here else f"{label} (elsewhere)")]
    if drawn.at_0 is not None and low < drawn.at_0 < high:
        ax.axvline(drawn.at_0, color=pen.RED, linewidth=0.9, linestyle=pen.DASHED)
        made.append(handle(pen.RED, pen.DASHED, "root at 0"))
    return made


def draw_boxes(ax: Axes, asked: Iterable[Hand]) -> list[Artist]:
    """The box of each hand with ranges of damping and stiffness."""
    for (k, b), (k_high, b_high) in _boxes(asked):
        ax.add_patch(Rectangle((k, b), k_high - k, b_high - b, fill=False, edgecolor=pen.INK, linewidth=0.9))
    return []


def _boxes(asked: Iterable[Hand]) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
    """Of each hand with ranges of damping and stiffness, two corners of their box."""
    for x in asked:
        if x.k.interval or x.b.interval:
            (k, k_high), (b, b_high) = ([float(end) for end in p.interval or (p.value, p.value)] for p in (x.k, x.b))
            yield (k, b), (k_high, b_high)


def draw_points(ax: Axes, asked: list[Hand], shown: list[Hand], drawn: Plane) -> list[Artist]:
    """Hands by their names: filled where their mass is that of the plane; and the number of roots in each cell."""
    room, listed = _room(ax, drawn), (*asked, *shown)
    for x in listed:
        room.take_point(*_place(x))
    for (k, b), (k_high, b_high) in _boxes(asked):
        room.take_line([k, k_high, k_high, k, k], [b, b, b_high, b_high, b])
    for x in listed:
        face = pen.INK if x in asked and float(x.m.value) == drawn.mass else "none"
        color = pen.INK if x in asked else pen.GREY
        ax.plot(*_place(x), "o", color=color, markerfacecolor=face, markersize=3.5, markeredgewidth=0.7)
    named = [(x.name, _place(x), pen.INK) for x in asked]
    named += [(name, place, pen.GREY) for name, place in _names(shown, room)]
    for name, (k, b), color in named:
        at = room.beside(k, b, name, _SMALLER)
        ax.annotate(name, (k, b), at, textcoords="offset points", fontsize=_SMALLER, color=color)
    _counts(ax, drawn, room)
    here = [x for x in asked if float(x.m.value) == drawn.mass]
    marker: dict[str, Any] = {"marker": "o", "markersize": 3.5}
    made: list[Artist] = [handle(pen.INK, "none", "of this mass", **marker)] if here else []
    if len(here) < len(listed):
        made.append(handle(pen.GREY, "none", "of another", markerfacecolor="none", markeredgewidth=0.7, **marker))
    return made


def _place(x: Hand) -> tuple[float, float]:
    return float(x.k.value), float(x.b.value)


def _names(shown: list[Hand], room: Room) -> list[tuple[str, tuple[float, float]]]:
    """What is written beside published hands, and where: of those whose marks lie on each other, how many they are."""
    groups: list[list[Hand]] = []
    for x in shown:
        near = (g for g in groups if room.away(_place(g[0]), _place(x)) < _TOGETHER)
        group = next(near, None)
        if group is None:
            groups.append([x])
        else:
            group.append(x)
    return [(g[0].name if len(g) == 1 else f"{len(g)} published hands", _place(g[0])) for g in groups]


def _room(ax: Axes, drawn: Plane) -> Room:
    """What the lines leave free."""
    room, (low, high, least, most) = Room(ax), drawn.window
    inside = (drawn.k > low) & (drawn.k < high) & (drawn.b > least) & (drawn.b < most)
    for piece in np.split(np.arange(len(drawn.k)), np.flatnonzero(np.diff(inside.astype(int))) + 1):
        if len(piece) and inside[piece[0]]:
            room.take_line(drawn.k[piece], drawn.b[piece])
    if drawn.at_0 is not None and low < drawn.at_0 < high:
        room.take_line([drawn.at_0] * 2, [least, most])
    return room


def _counts(ax: Axes, drawn: Plane, room: Room) -> None:
    """The number of roots of each cell, in its middle, or beside what stands there."""
    low, high, least, most = drawn.window
    for x in drawn.cells:
        if min(np.ptp(np.nonzero(x.pixels), axis=1)) < _NARROW:
            continue
        shown = "?" if x.roots is None else "∞" if x.roots.number is None else f"{x.roots.number}"
        inner = np.argwhere(_without_rim(x.pixels))
        share = (inner[:: max(1, len(inner) // 400)] + 0.5) / x.pixels.shape
        others = np.array([low, least]) + share * np.array([high - low, most - least])
        places = [(x.k, x.b), *((float(k), float(b)) for k, b in others)]
        k, b = min(places, key=lambda place: (room.crowded(place, pen.TEXT), room.away(place, (x.k, x.b))))
        ax.annotate(shown, (k, b), ha="center", va="center", fontsize=pen.TEXT, color=pen.INK)


def _without_rim(pixels: Any) -> Any:
    """The pixels of a cell that are some way from its rim."""
    moved = [np.roll(pixels, step, axis) for axis in (0, 1) for step in (-_RIM, _RIM)]
    return np.logical_and.reduce([pixels, *moved])


HEIGHT = 2.6  # inches
_FINEST = (2.0**-8, 2.0**-7)
_COARSE = 2.0**-6
"""Of both ranges, by how many others there are."""
_MOST = 100_000


def hands_figure(a: Tolerances) -> Figure:
    """The plane of the hand alone."""
    return one_column(HEIGHT, lambda ax: draw_held(ax, a))


def draw_held(ax: Axes, a: Tolerances) -> list[Artist]:
    """Stiffness against damping of hands of the first one's mass: grounds where a display is stable for all values, and for none.

    Both are proven, over rectangles; between them it depends on the values, or was not shown. The line is the boundary for the
    nominal values, in floats (none with a clock); hollow points are published hands, whatever their mass. NothingToDrawError
    without a hand, and where nothing is known.

    >>> from haptisym import load_scene, tolerances
    >>> from matplotlib.figure import Figure
    >>> late = load_scene("delayed-spring").with_values({"tau": "36 ms +- 5 %"})
    >>> [x.get_label() for x in draw_held(Figure().add_subplot(), tolerances(late, samples=0, hand="postural-arm"))][:3]
    ['stable for all values', 'for none', 'it depends, or not shown']
    """
    if not a.held:
        raise NothingToDrawError("no hand was asked about")
    scene, hands = a.box.scene, [x.hand for x in a.held]
    own, turning, sampled = hands[0], scene.motion is MotionKind.ROTATION, bool(clocks(scene))
    shown = [] if turning else [x for name, x in published.items() if name not in {y.name for y in hands}]
    window = _window_in_heldbox([*hands, *shown], sampled=sampled)
    found = _found(a, own, window)
    low, high, least, most = window
    ax.set(xlim=(low, high), ylim=(least, most))
    drawn = (
        Plane(float(own.m.value), np.empty(0), np.empty(0), None, window) if sampled else boundary(scene, own, window)
    )
    lines = [] if sampled else draw_boundary(ax, drawn, "nominal boundary")
    made = [
        *_grounds(ax, found, window), *lines, *draw_boxes(ax, hands),
        *draw_points(ax, hands, shown, drawn),
    ]  # fmt: skip
    name_axes(ax, scene.motion, " to ".join(number(float(x)) for x in own.m.interval or (own.m.value,)))
    legend(ax, made)
    return made


def _found(a: Tolerances, hand: Hand, window: Window) -> HeldPlane:
    """What is proven of the plane."""
    low, high, least, most = (Rational(str(x)) for x in window)
    ranges = a.box.scene.ranges().values()
    others: dict[Symbol, tuple[Expr, Expr]] = {x.symbol: x.interval for x in ranges if x.interval and not x.parts}
    if hand.m.interval:
        others[hand.m.symbol] = hand.m.interval
    finest = _FINEST[len(others)] if len(others) < len(_FINEST) else _COARSE
    try:
        free = {hand.k.symbol: (low, high), hand.b.symbol: (least, most)}
        return held_plane(a.box.scene, [hand], free, others, finest=finest, most=_MOST)
    except UndecidedError as error:
        raise NothingToDrawError(f"of hands held nothing is known: {error}") from None


def _window_in_heldbox(hands: Sequence[Hand], *, sampled: bool) -> Window:
    """From 0 on, with room for the hands and their boxes; a little less without a clock."""
    ends = [[float((p.interval or (p.value, p.value))[1]) for p in (x.k, x.b)] for x in hands]
    k, b = (max(column) for column in zip(*ends, strict=True))
    k, b = (k or 100.0, b or 1.0)
    below = 0.0 if sampled else 0.05
    return -below * k, ROOM * k, -below * b, ROOM * b


def _grounds(ax: Axes, found: HeldPlane, window: Window) -> list[Artist]:
    """White, tinted and grey."""
    rows = (
        (found.stable, "white", "stable for all values"), (found.unstable, pen.UNSTABLE, "for none"),
        (found.left, pen.SHADE, "it depends, or not shown"),
    )  # fmt: skip
    made: list[Artist] = []
    low, high, least, most = window
    for cells, color, label in rows:
        if len(cells):
            places: Array = np.array([low, least])[:, None] + cells * np.array([high - low, most - least])[:, None]
            rectangles(ax, places[:, 0].T, places[:, 1].T, color)
            made.append(Patch(facecolor=color, edgecolor="black", linewidth=0.3, label=label))
    return made
