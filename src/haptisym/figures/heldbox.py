"""The plane of a hand, of a display whose values are known as ranges: where it is stable for all of them, where for none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from sympy import Expr, Rational, Symbol

from haptisym.figures import pen
from haptisym.figures.sheet import one_column
from haptisym.figures.stability import ROOM, draw_boundary, draw_boxes, draw_points, name_axes
from haptisym.figures.style import legend, number, rectangles
from haptisym.kernel.errors import NothingToDrawError, UndecidedError
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.hand import hands as published
from haptisym.model.quantities import MotionKind
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability.plane import Plane, Window, boundary
from haptisym.verbs.tolerances.heldplane import HeldPlane, held_plane
from haptisym.verbs.tolerances.proofs import Tolerances

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
    window = _window([*hands, *shown], sampled=sampled)
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


def _window(hands: Sequence[Hand], *, sampled: bool) -> Window:
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
