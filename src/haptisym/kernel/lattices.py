"""The largest of the smallest of real functions: whatever is decided by several signs at once, as one continuous function."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple, TypeAlias

from haptisym.kernel.polynomials import Level
from haptisym.kernel.response import RealFunction


class Piece(NamedTuple):
    """What a function of a lattice is called on a chart: that of this term and place."""

    name: Hashable
    term: int
    place: int


@dataclass(frozen=True)
class Lattice:
    """max over ``terms`` of the min over each: positive exactly where all functions of one term are."""

    terms: tuple[tuple[RealFunction | Level, ...], ...]

    @classmethod
    def largest(cls, functions: Iterable[RealFunction | Level]) -> Lattice:
        """Positive where any of the functions is."""
        return cls(tuple((f,) for f in functions))

    def pieces(self, name: Hashable) -> dict[Piece, RealFunction | Level]:
        """Its functions, by what a chart calls them."""
        return {Piece(name, i, j): f for i, term in enumerate(self.terms) for j, f in enumerate(term)}

    def sign(self, name: Hashable, of: Callable[[Piece], int]) -> int:
        """max of min of the signs of the pieces."""
        return max(min(of(Piece(name, i, j)) for j in range(len(term))) for i, term in enumerate(self.terms))


Signed: TypeAlias = RealFunction | Level | Lattice
"""A real function whose sign a chart tells."""


class Met(NamedTuple):
    """What happens to a lattice at a point of a chart: its order, its signs to both sides, whether that is undecided."""

    order: int
    before: int
    after: int
    undecided: bool


def met(
    lattice: Lattice,
    name: Hashable,
    orders: Mapping[Hashable, int],
    sides: tuple[Mapping[Hashable, int], Mapping[Hashable, int]],
    doubtful: frozenset[Hashable],
) -> Met:
    """A lattice at a point, from the orders and the signs of its pieces there."""
    before, after = (lattice.sign(name, lambda piece, side=side: side[piece]) for side in sides)  # type: ignore[misc]
    low, high = (_at(lattice, name, orders, side, {}) for side in sides)
    unknown = [x for x in lattice.pieces(name) if x in doubtful]
    found = {_at(lattice, name, orders, sides[1], guess) for guess in _guesses(unknown)} if unknown else set()
    if _INFINITE in (abs(low), abs(high)):
        order = -1 if before != after else -2
    elif low == 0 and (before > 0 or after > 0 or (before, after) == (-1, -1)):
        order = _order(lattice, name, orders, sides, odd=before != after)
    else:
        order = 0
    return Met(order, before, after, len(found) > 1)


_INFINITE = 2


def _guesses(unknown: list[Piece]) -> Iterator[dict[Piece, int]]:
    return (dict(zip(unknown, guess, strict=True)) for guess in product((-1, 0, 1), repeat=len(unknown)))


def _at(
    lattice: Lattice,
    name: Hashable,
    orders: Mapping[Hashable, int],
    side: Mapping[Hashable, int],
    guess: Mapping[Piece, int],
) -> int:
    """The sign right at a point, seen from one side; twice that where it is infinite."""

    def sign(piece: Piece) -> int:
        order = orders.get(piece, 0)
        return guess[piece] if piece in guess else 0 if order > 0 else side[piece] * (_INFINITE if order < 0 else 1)

    return lattice.sign(name, sign)


def _order(
    lattice: Lattice,
    name: Hashable,
    orders: Mapping[Hashable, int],
    sides: tuple[Mapping[Hashable, int], Mapping[Hashable, int]],
    *,
    odd: bool,
) -> int:
    """The least order of a piece that makes the lattice vanish, odd exactly where the sign changes.

    Seen from the side after the point; from that before it where another piece jumps there over a pole.
    """

    def seen(side: Mapping[Hashable, int]) -> Iterator[int]:
        for i, term in enumerate(lattice.terms):
            own = [Piece(name, i, j) for j in range(len(term))]
            if all(orders.get(x, 0) > 0 or side[x] >= 0 for x in own):
                yield from (orders[x] for x in own if orders.get(x, 0) > 0)

    least = next(min(found) for side in sides[::-1] if (found := [*seen(side)]))
    return least if least % 2 == odd else least + 1
