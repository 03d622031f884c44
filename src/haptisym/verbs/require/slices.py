"""Slices of a map: the exact requirement on its second parameter at a value of the first; how far lines between may be off."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

from sympy import Expr

from haptisym.verbs.require.feasible import Kind, Solved
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.verdicts import together


@dataclass(frozen=True)
class Slice:
    """The exact requirement on the second parameter where the first one has a value; ``apart`` : on each thing asked, alone.

    ``contours`` : the values for which nothing is noticed with each of the other thresholds that were asked about.
    """

    at: Expr
    requirement: Requirement
    apart: tuple[Requirement, ...] = ()
    contours: tuple[Requirement, ...] = ()

    @classmethod
    def of(cls, at: Expr, apart: Sequence[Requirement], contours: Sequence[Requirement]) -> Slice:
        """Of one or several things that were asked, from the values for each alone."""
        one = apart[0]
        if len(apart) == 1:
            return cls(at, one, (), tuple(contours))
        both = together(one.domain, [Solved(x.feasible, x.undecided, x.reason) for x in apart])
        names = tuple(name for x in apart for name in x.that)
        criteria = tuple(y for x in apart for y in x.criteria)
        found = replace(
            one, feasible=both.feasible, undecided=both.undecided, reason=both.reason, criteria=criteria, that=names
        )
        return cls(at, found, tuple(apart), tuple(contours))

    @property
    def sets(self) -> tuple[Requirement, ...]:
        """All of its sets: what is asked together, each thing alone, each further threshold."""
        return self.requirement, *self.apart, *self.contours

    @cached_property
    def place(self) -> float:
        """Where it is."""
        return float(self.at)

    @cached_property
    def ends(self) -> tuple[tuple[_End, ...] | None, ...]:
        """Of each of its sets the ends of the intervals, both of each; None where something was left undecided."""
        return tuple(None if r.undecided else tuple(_ends(r)) for r in self.sets)


@dataclass(frozen=True)
class _End:
    """An end of an interval as a double, and what binds there."""

    value: float
    binds: frozenset[tuple[str, Kind]]


def _ends(r: Requirement) -> Iterator[_End]:
    for span in r.feasible:
        for end in (span.low, span.high):
            assert end.value is not None  # a map has a range
            yield _End(float(end.value), frozenset((b.criterion.name, b.kind) for b in end.bindings))


@dataclass(frozen=True)
class Gap:
    """What lies between two neighbouring slices; ``deviation`` : of the sets' boundaries from straight lines, estimated.

    None where no lines join the slices, which differ in how many intervals their sets have, or where something is undecided.
    """

    low: float
    high: float
    deviation: float | None


def gaps(slices: Sequence[Slice]) -> tuple[Gap, ...]:
    """What lies between each two slices, in order.

    A line between two points of a function is off by at most h^2/8 times its second derivative. That is estimated by the
    divided differences with the next slices on either side: an estimate, which knows nothing of what slices do not show. Where
    what binds changes, the boundary has a corner, and is taken to be off by what such a corner may be.
    """
    return tuple(Gap(a.place, b.place, _deviation(i, slices)) for i, (a, b) in enumerate(pairwise(slices)))


def _deviation(i: int, slices: Sequence[Slice]) -> float | None:
    """Of all sets between one slice and the next."""
    found = [_of_set(i, k, slices) for k in range(len(slices[i].sets))]
    known = [x for x in found if x is not None]
    return max(known, default=0.0) if len(known) == len(found) else None


def _of_set(i: int, k: int, slices: Sequence[Slice]) -> float | None:
    here, there = slices[i].ends[k], slices[i + 1].ends[k]
    if here is None or there is None or len(here) != len(there):
        return None
    most = 0.0
    for j, (a, b) in enumerate(zip(here, there, strict=True)):
        if not (a.binds or b.binds):
            continue  # where the range ends
        step = slices[i + 1].place - slices[i].place
        bend = _bent(i, k, j, slices)
        own = abs(b.value - a.value) if bend is None else bend * step**2 / (4 if a.binds == b.binds else 1)
        most = max(most, own)
    return most


def _bent(i: int, k: int, j: int, slices: Sequence[Slice]) -> float | None:
    """How much an end bends between one slice and the next; at an end of the map, as far as its bend goes on changing."""
    before, after = (_bend(first, k, j, slices) for first in (i - 1, i))
    if before is not None and after is not None:
        return max(abs(before), abs(after))
    known, beyond = (before, _bend(i - 2, k, j, slices)) if after is None else (after, _bend(i + 1, k, j, slices))
    return None if known is None else abs(known) + (0.0 if beyond is None else abs(known - beyond))


def _bend(first: int, k: int, j: int, slices: Sequence[Slice]) -> float | None:
    """The second divided difference of one end over three slices; None where there are none, or they differ in kind."""
    if first < 0 or first + 2 >= len(slices):
        return None
    rows = [slices[first + n].ends[k] for n in range(3)]
    if any(row is None or len(row) != len(rows[0] or ()) for row in rows):
        return None
    (x, y, z), (u, v, w) = (
        [slices[first + n].place for n in range(3)],
        [row[j].value for row in rows if row is not None],
    )
    return ((w - v) / (z - y) - (v - u) / (y - x)) / (z - x)
