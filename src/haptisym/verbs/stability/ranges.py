"""Is a display stable in a hand for all values of a box, for some or for none, and where in a plane
of two parameters of display or hand.

The number of unstable roots changes only where one meets the imaginary axis (with a clock, the unit
circle). A set of values is *clear* where the characteristic function is nowhere 0 on the axis, for
any of its values: proven in Taylor models (``OnAxis``), with a clock in balls (``OnCircle``). All
values of a clear box, or of clear rectangles that touch, have one number of roots, which is counted
exactly at one of them. A plane is filled with rectangles, cut until each is clear, for any value of
what else varies, or small. Begin with ``held_in_box`` and ``held_plane``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import islice, product
from typing import Any

from sympy import Expr, I, Symbol

from haptisym.kernel.arrays import np
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import rational
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.rootcount import count_roots
from haptisym.kernel.where import Array, search, touching
from haptisym.model.catalogue import Hand
from haptisym.model.parameters import values as values_of
from haptisym.model.scene import Scene, clocks
from haptisym.programs.onaxis import OnAxis
from haptisym.verbs.stability.held import Share, characteristic, unstable_roots
from haptisym.verbs.stability.oncircle import Cell, OnCircle, cell_halves

_MOST_CORNERS = 64
# Cells in which roots may meet the axis whose middles are tried as examples.
_MOST_MIDDLES = 12


@dataclass(frozen=True)
class HeldInBox:
    """For which values a display is stable in a hand; ``share`` None where not decided, for the
    ``reason``.

    ``stable``, ``unstable`` : sets of values of either kind, by path, counted exactly; None if none
    was found.
    """

    hand: Hand
    share: Share | None
    stable: Mapping[str, Expr] | None = None
    unstable: Mapping[str, Expr] | None = None
    reason: str = ""

    def row(self) -> dict[str, Any]:
        """As a row of a document."""
        examples = {"stable": self.stable, "unstable": self.unstable}
        shown = {
            key: x and {name: str(value) for name, value in x.items()}
            for key, x in examples.items()
        }
        reason = {"reason": self.reason} if self.reason else {}
        ranges = {
            p.key: [float(end) for end in p.interval] for p in self.hand.parameters if p.interval
        }
        return {
            "hand": self.hand.name,
            **({"ranges": ranges} if ranges else {}),
            "stable": self.share.value if self.share else None,
            "witnesses": shown,
            **reason,
        }


def held_in_box(scene: Scene, hand: Hand) -> HeldInBox:
    """For which values within the ranges of display and hand a display is stable in that hand of
    the scene.

    Guaranteed: some, by an example of either kind, counted exactly; all and none, where no root
    meets the axis for any values (``OnAxis``), so that the number of roots is that of the nominal
    ones.
    """
    try:
        return _Question(scene, hand).answer()
    except LimitError:
        return HeldInBox(hand, None, reason="the limit of time was reached")


class _Question:
    """The question of ``held_in_box``: one hand, and the parameters that vary, its ``sides``.

    ``found`` : an example of values for either verdict.
    """

    def __init__(self, scene: Scene, hand: Hand) -> None:
        self.scene, self.hand = scene, hand
        own = {p.symbol for p in hand.parameters}
        display = [x for x in scene.ranges().values() if not x.parts]
        self.sides = [
            *display,
            *(x for x in scene.knobs if x.is_of_hand and x.interval and x.symbol in own),
        ]
        self.found: dict[bool, Mapping[str, Expr]] = {}

    def answer(self) -> HeldInBox:
        """The verdict, with examples."""
        # Counts first: two examples that differ settle it, and where they do not, all have one
        # verdict that is then proven or not.
        reason = self._look(islice(self._corners(), 1 + _MOST_CORNERS))
        proven: bool | None = None
        if len(self.found) == 1:
            try:
                proven = self._for_all() if self.sides else True in self.found
            except UndecidedError as error:
                reason = str(error)
        share = None if proven is None else Share.ALL if proven else Share.NONE
        if len(self.found) == 2:
            share = Share.SOME
        told = (
            (reason or "whether the number of roots changes within the ranges")
            if share is None
            else ""
        )
        return HeldInBox(self.hand, share, self.found.get(True), self.found.get(False), told)

    def _look(self, sets: Iterator[dict[str, Expr]]) -> str:
        """Count the roots at single sets of values until there is an example of either kind; return
        why some stayed open."""
        reason = ""
        for values in sets:
            if len(self.found) == 2:
                break
            try:
                scene = self.scene.with_values(values)
                [hand] = [x for x in scene.hands if x.name == self.hand.name]
                self.found.setdefault(unstable_roots(scene, hand).number == 0, values)
            except (UndecidedError, SceneError) as error:
                reason = str(error)
        return reason

    def _corners(self) -> Iterator[dict[str, Expr]]:
        """The nominal values, then the corners."""
        yield {x.path: x.value for x in self.sides}
        ends = (x.interval or (x.value, x.value) for x in self.sides)
        yield from (
            dict(zip((x.path for x in self.sides), corner, strict=True))
            for corner in product(*ends)
        )

    def _for_all(self) -> bool | None:
        """Whether the display is stable for all values, or for none; None where neither is shown.

        Examples of both kinds may have been found on the way.
        """
        if clocks(self.scene):
            return self._with_a_clock()
        ring, top, bottom = quotient(self.scene, self.hand, {x.symbol for x in self.sides})
        number = self._everywhere(ring, top)
        if number is None:
            return None
        if number == 0:
            return True
        # Zeros that top and bottom share at some values are no roots there: as many as bottom has
        # in Re s >= 0 may be hidden, and one more than that is a root for all values.
        poles = self._everywhere(ring, bottom)
        return False if poles is not None and poles < number else None

    def _with_a_clock(self) -> bool | None:
        """What ``_for_all`` returns, by the roots of the sampled loop."""
        used = {x.symbol: x.interval for x in self.sides if x.interval}
        loop = OnCircle.of(self.scene, self.hand, used)
        left = loop.left()
        if left:
            self._look(
                self._middles(list(used), np.array([[(0, 0), *cell] for cell in left], float))
            )
            return None
        return loop.is_stable({x.symbol: x.value for x in self.sides})

    def _everywhere(self, ring: Ring, polynomial: Polynomial) -> int | None:
        """The number of zeros in Re s >= 0, if it is one for all values; None where it may not
        be."""
        used = {x.symbol: x.interval for x in self.sides if x.interval and x.symbol in ring.symbols}
        known = {x.symbol: x.value for x in self.sides}
        count = count_at(ring, polynomial, known)
        if count is None:
            return None
        on_axis = OnAxis(ring, polynomial, used)
        if on_axis.reach is None:
            raise UndecidedError("whether roots come from infinity for some of the values")
        left = on_axis.left()
        if not len(left):  # no cell
            return count
        self._look(self._middles(list(used), left))
        return None

    def _middles(self, symbols: list[Symbol], cells: Any) -> Iterator[dict[str, Expr]]:
        """The values in the middle of some cells."""
        places = {x.symbol: x for x in self.sides}
        for cell in cells[:: max(1, len(cells) // _MOST_MIDDLES)]:
            values = {x.path: x.value for x in self.sides}
            for symbol, (start, end) in zip(symbols, cell[1:].tolist(), strict=True):
                x, share = places[symbol], Fraction((start + end) / 2)
                assert x.interval
                low, high = x.interval
                values[x.path] = low + rational(share) * (high - low)
            yield values


def quotient(
    scene: Scene, hand: Hand, symbols: Collection[Symbol]
) -> tuple[Ring, Polynomial, Polynomial]:
    """H_perc + Z as a ring, numerator and denominator, with what varies as symbols.

    Without the denominator's zeros at 0. UndecidedError for a display with friction.
    """
    chain = scene.chain.at(values_of(p for p in scene.parameters if p.symbol not in symbols))
    Z = hand.dynamics.xreplace(values_of(p for p in hand.parameters if p.symbol not in symbols))
    ring = Ring.of([*chain.entries(), Z])
    if I in ring.generators:
        raise UndecidedError("the roots of a display with friction, for all values at once")
    perceived = chain.perceived(range(len(chain.matrices)), ring)
    bottom = perceived.denominator
    lowest = min(int(exponents[0]) for exponents in bottom.monoms())
    return ring, characteristic(perceived, ring.convert(Z)), bottom / ring.variable**lowest


def count_at(ring: Ring, polynomial: Polynomial, known: Mapping[Symbol, Expr]) -> int | None:
    """The zeros in Re s >= 0 for one set of values; None where there are infinitely many."""
    here = ring.expression(polynomial).xreplace(dict(known))
    own = Ring.of([here])
    return count_roots(own.convert(here).numerator, own).number


# Parts of each range of a plane to begin with.
_FIRST = 8
# Cells of what else varies that are looked at for one rectangle.
_MOST_PIECES = 48


@dataclass(frozen=True)
class ClockPlane:
    """A plane of sampled loops that must all be clear: of the first two of their parameters.

    ``finest`` : the share of both ranges down to which rectangles are cut. ``most`` : cells that
    are looked at.
    """

    loops: Sequence[OnCircle]
    finest: float
    most: int

    def rectangles(self) -> tuple[Array, Array]:
        """The rectangles that are clear, and those that are left; (rectangles, 2, 2), in shares of
        both ranges."""
        clear, left, looked = list[Cell](), list[Cell](), 0
        whole: Cell = ((Fraction(0), Fraction(1)),) * (len(self.loops[0].ranges) - 2)
        sides = [(Fraction(i, _FIRST), Fraction(i + 1, _FIRST)) for i in range(_FIRST)]
        grid: list[Cell] = [(a, b) for a in sides for b in sides]
        first: list[tuple[Cell, Sequence[Sequence[Cell]]]] = [
            (own, [[whole] for _ in self.loops]) for own in grid
        ]
        # The widest first, so that whenever it stops the plane is settled evenly.
        waiting = Waiting(first, lambda x: x[0][0][0] - x[0][0][1], what="rectangles")
        with suppress(LimitError):
            for own, others in waiting:
                if looked > self.most:
                    break
                rest, tried = self._doubtful(own, others)
                looked += tried
                if not any(rest):
                    clear.append(own)
                elif max(b - a for a, b in own) <= self.finest:
                    left.append(own)
                else:
                    waiting.add(*((half, rest) for half in cell_halves(own, (0, 1))))
        left += [x for x, _ in waiting.rest]
        return _array(clear), _array(left)

    def _doubtful(self, own: Cell, rest: Sequence[Sequence[Cell]]) -> tuple[list[list[Cell]], int]:
        """For each loop the cells of what else varies for which a rectangle is not clear, and how
        many were looked at.

        A cell is cut while the rectangle is clear for its middle: else it is the rectangle that is
        too large. The halves of the rectangle begin with the cells that are left here.
        """
        found, looked = list[list[Cell]](), 0
        for loop, others in zip(self.loops, rest, strict=True):
            waiting, most = Waiting(others), looked + _MOST_PIECES
            for cell in waiting:
                looked += 1
                if loop.is_clear((*own, *cell)):
                    continue
                looked += bool(cell)
                if (
                    not cell
                    or looked >= most
                    or not loop.is_clear((*own, *(((a + b) / 2,) * 2 for a, b in cell)))
                ):
                    break
                waiting.add(*cell_halves(cell, range(len(cell))))
            found.append(waiting.rest)
        return found, looked


def _array(cells: Sequence[Cell]) -> Array:
    return np.array([[[float(x) for x in side] for side in cell] for cell in cells]).reshape(
        -1, 2, 2
    )


# Pieces of the frequencies to begin with.
_FIRST_PIECES = 48
# How often the pieces of frequency of a rectangle that is cut no further are.
_AT_LAST = 5
_MOST_COUNTS = 48
# A cell of a loop with a clock, in balls, takes so many times as long as one in floats; and the
# share down to which its rectangles are cut.
_DEARER, _FINEST_SAMPLED = 15, 2.0**-8

Interval = tuple[Expr, Expr]


@dataclass(frozen=True, eq=False)
class HeldPlane:
    """Rectangles that fill a plane, (rectangles, 2, 2), in shares of both ranges.

    ``stable`` : for all of their values; ``unstable`` : for none; ``left`` : neither was shown.
    """

    stable: Array
    unstable: Array
    left: Array


def held_plane(
    scene: Scene,
    hands: Sequence[Hand],
    plane: Mapping[Symbol, Interval],
    others: Mapping[Symbol, Interval] | None = None,
    *,
    finest: float = 2.0**-8,
    most: int = 60_000,
) -> HeldPlane:
    """The plane of two parameters of display or hands, for all values of ``others`` at once.

    ``hands`` : stable is what is so in all of them. ``finest`` : the share of a range down to which
    rectangles are cut; ``most`` : cells that are looked at. UndecidedError where nothing is known
    of the plane.
    """
    ranges = {**plane, **(others or {})}
    if clocks(scene):
        sampled = [_Sampled(OnCircle.of(scene, x, ranges)) for x in hands]
        clear, left = ClockPlane(
            [x.form for x in sampled], max(finest, _FINEST_SAMPLED), most // _DEARER
        ).rectangles()
        return _told(sampled, clear, left)
    loops = [_Loop(*quotient(scene, x, set(ranges)), ranges) for x in hands]
    if any(x.form.reach is None for x in loops):
        raise UndecidedError("whether roots come from infinity for some of the values")
    # Pieces of the frequencies, each with the whole ranges of what else varies; by factors, as
    # roots may lie many decades below the highest frequency.
    first = np.tile([0.0, 1.0], (_FIRST_PIECES, len(ranges) - 1, 1))
    edges = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, _FIRST_PIECES)])
    first[:, 0] = np.stack([edges[:-1], edges[1:]], -1)
    judges = [x.form.curve for x in loops]
    found = search(
        judges, grid(), first, wide=wider_than(finest), last=_AT_LAST, most=most, what="rectangles"
    )
    return _told(loops, found.kept.outer, found.left.outer)


def grid() -> Array:
    """Rectangles to begin with, in shares of both ranges."""
    steps = np.arange(_FIRST + 1) / _FIRST
    sides = np.stack([steps[:-1], steps[1:]], -1)
    return np.array([[a, b] for a in sides for b in sides])


def wider_than(finest: float) -> Callable[[Array], Array]:
    """Which sides of rectangles may be cut."""
    return lambda cells: cells[..., 1] - cells[..., 0] > finest


def _told(loops: Sequence[_Loop | _Sampled], clear: Array, left: Array) -> HeldPlane:
    """The plane, from clear rectangles and those that are left: one count for each set of clear
    ones that touch, the largest sets first."""
    label = touching(clear)
    stable, unstable = np.zeros((2, len(clear)), bool)
    parts = sorted(set(label.tolist()), key=lambda n: -float(_areas(clear[label == n]).sum()))
    for n in parts[:_MOST_COUNTS]:
        # The largest rectangle of a set: its middle is far from where roots meet the axis.
        own = clear[label == n]
        verdicts = [x.is_stable(own[np.argmax(_areas(own))]) for x in loops]
        stable[label == n], unstable[label == n] = all(verdicts), False in verdicts
    return HeldPlane(
        clear[stable], clear[unstable], np.concatenate([left, clear[~stable & ~unstable]])
    )


@dataclass(frozen=True)
class _Loop:
    """H_perc + Z in one hand as a quotient, over the ``ranges`` of what varies."""

    ring: Ring
    top: Polynomial
    bottom: Polynomial
    ranges: Mapping[Symbol, Interval]

    @cached_property
    def form(self) -> OnAxis:
        """The numerator on the axis, for all values of the ranges: clear where it is not 0."""
        return OnAxis(self.ring, self.top, self.ranges)

    def is_stable(self, rectangle: Array) -> bool | None:
        """Whether the loop is stable for all values of a clear rectangle (and of those that touch
        it), or for none; None where not known."""
        try:
            count = count_at(self.ring, self.top, _values_amid(self.ranges, rectangle))
        except (UndecidedError, LimitError):
            return None
        if not count:
            return None if count is None else True
        return False if self._shared is not None and count > self._shared else None

    @cached_property
    def _shared(self) -> int | None:
        """How many zeros in Re s >= 0 numerator and denominator may share: those of the latter;
        None where not known."""
        try:
            form = OnAxis(self.ring, self.bottom, self.ranges)
            if form.reach is None or len(form.left()):
                return None
            return count_at(
                self.ring,
                self.bottom,
                _values_amid(self.ranges, np.array([[0.0, 1.0], [0.0, 1.0]])),
            )
        except (UndecidedError, LimitError):
            return None


@dataclass(frozen=True)
class _Sampled:
    """A sampled loop in one hand."""

    form: OnCircle

    def is_stable(self, rectangle: Array) -> bool | None:
        """Whether the loop is stable for all values of a clear rectangle (and of those that touch
        it), or for none; None where not known."""
        try:
            return self.form.is_stable(_values_amid(self.form.ranges, rectangle))
        except (UndecidedError, LimitError):
            return None


def _values_amid(ranges: Mapping[Symbol, Interval], rectangle: Array) -> dict[Symbol, Expr]:
    """The values in the middle of a rectangle, and of what else varies."""
    middles = [Fraction(float(x)) for x in rectangle.mean(-1)]
    shares = [*middles, *[Fraction(1, 2)] * (len(ranges) - 2)]
    return {
        symbol: low + rational(x) * (high - low)
        for (symbol, (low, high)), x in zip(ranges.items(), shares, strict=True)
    }


def _areas(rectangles: Array) -> Array:
    return (rectangles[..., 1] - rectangles[..., 0]).prod(-1)
