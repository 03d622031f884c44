"""Held in a hand, for all values of a box: whether a display is stable for all of them, for some, or for none."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice, product
from typing import Any

import numpy as np
from sympy import Expr, I, Rational, Symbol

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.rootcount import count_roots
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.parameters import values as values_of
from haptisym.model.scene import Scene
from haptisym.programs.onaxis import OnAxis
from haptisym.verbs.stability.boxes import Share
from haptisym.verbs.stability.clocked import OnCircle
from haptisym.verbs.stability.held import characteristic, unstable_roots

_MOST_CORNERS = 64
_MOST_MIDDLES = 12  # of cells where roots may meet the axis, that are tried as examples


@dataclass(frozen=True)
class HeldInBox:
    """For which values a display is stable in a hand; ``share`` None where not decided, for the ``reason``.

    ``stable``, ``unstable`` : sets of values of either kind, by path, counted exactly; None if none was found.
    """

    hand: Hand
    share: Share | None
    stable: Mapping[str, Expr] | None = None
    unstable: Mapping[str, Expr] | None = None
    reason: str = ""

    def row(self) -> dict[str, Any]:
        """As a row of a document."""
        examples = {"stable": self.stable, "unstable": self.unstable}
        shown = {key: x and {name: str(value) for name, value in x.items()} for key, x in examples.items()}
        reason = {"reason": self.reason} if self.reason else {}
        ranges = {p.key: [float(end) for end in p.interval] for p in self.hand.parameters if p.interval}
        return {
            "hand": self.hand.name,
            **({"ranges": ranges} if ranges else {}),
            "stable": self.share.value if self.share else None,
            "witnesses": shown,
            **reason,
        }


def held_in_box(scene: Scene, hand: Hand) -> HeldInBox:
    """For which values within the ranges of display and hand a display is stable in that hand of the scene.

    Guaranteed: some, by an example of either kind, counted exactly; all and none, where no root meets the axis for any values
    (``OnAxis``), so that the number of roots is that of the nominal ones.
    """
    try:
        return _Question(scene, hand).answer()
    except LimitError:
        return HeldInBox(hand, None, reason="the limit of time was reached")


class _Question:
    """One hand, and what varies."""

    def __init__(self, scene: Scene, hand: Hand) -> None:
        self.scene, self.hand = scene, hand
        own = {p.symbol for p in hand.parameters}
        display = [x for x in scene.ranges().values() if not x.parts]
        self.sides = [*display, *(x for x in scene.knobs if x.is_of_hand and x.interval and x.symbol in own)]
        self.found: dict[bool, Mapping[str, Expr]] = {}

    def answer(self) -> HeldInBox:
        """The verdict, with examples."""
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
        told = (reason or "whether the number of roots changes within the ranges") if share is None else ""
        return HeldInBox(self.hand, share, self.found.get(True), self.found.get(False), told)

    def _look(self, sets: Iterator[dict[str, Expr]]) -> str:
        """Count the roots of single sets of values until there are both kinds; why some of them stayed open."""
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
        yield from (dict(zip((x.path for x in self.sides), corner, strict=True)) for corner in product(*ends))

    def _for_all(self) -> bool | None:
        """Whether all are stable, or none is; None where there are both, which are then among the examples."""
        if clocks(self.scene):
            return self._with_a_clock()
        ring, top, bottom = quotient(self.scene, self.hand, {x.symbol for x in self.sides})
        number = self._everywhere(ring, top)
        if number is None:
            return None
        if number == 0:
            return True
        poles = self._everywhere(ring, bottom)  # what top and bottom share is no root
        return False if poles is not None and poles < number else None

    def _with_a_clock(self) -> bool | None:
        """The same by the roots of the sampled loop."""
        used = {x.symbol: x.interval for x in self.sides if x.interval}
        loop = OnCircle.of(self.scene, self.hand, used)
        left = loop.left()
        if left:
            self._look(self._middles(list(used), np.array([[(0, 0), *cell] for cell in left], float)))
            return None
        return loop.is_stable({x.symbol: x.value for x in self.sides})

    def _everywhere(self, ring: Ring, polynomial: Polynomial) -> int | None:
        """The number of zeros in Re s >= 0, if it is one for all values; None where it may not be."""
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
                values[x.path] = low + Rational(share.numerator, share.denominator) * (high - low)
            yield values


def quotient(scene: Scene, hand: Hand, symbols: Collection[Symbol]) -> tuple[Ring, Polynomial, Polynomial]:
    """H_perc + Z as a quotient, with what varies as symbols, the denominator without its zeros at 0. UndecidedError: friction."""
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
