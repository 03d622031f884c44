"""Slabs of values of one parameter, and cells of the band, in which coefficients show the sign of what must not be positive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import isqrt
from typing import Any, TypeAlias

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import UndecidedError
from haptisym.verbs.evaluate.products import Factor
from haptisym.verbs.evaluate.waves import WaveFactor
from haptisym.verbs.require.slicing import Slices, WaveSlices, sliced

Value: TypeAlias = Fraction | None
"""A value of the parameter; None where it is unbounded."""

_MOST_CELLS, _MOST_SLABS = 50, 150
_MOST_WITH_WAVES = 40


@dataclass(frozen=True)
class Ends:
    """The ends of a slab of values, and whether each belongs to it."""

    low: Value
    high: Value
    holds_low: bool = False
    holds_high: bool = False

    def halves(self) -> tuple[Ends, Ends]:
        """Two of them that meet inside."""
        cut = _middle(self.low, self.high)
        return Ends(self.low, cut, self.holds_low, True), Ends(cut, self.high, True, self.holds_high)  # noqa: FBT003

    def slices(self, factors: Sequence[Factor | WaveFactor]) -> list[Slices | WaveSlices]:
        """Of each factor, over the slab."""
        low = (-1, 0) if self.low is None else self.low.as_integer_ratio()
        high = (1, 0) if self.high is None else self.high.as_integer_ratio()
        return [sliced(f, low, high) for f in factors]


def _middle(low: Value, high: Value) -> Fraction:
    if high is None:
        return Fraction(0) if low is None else max(2 * low, low + 1) if low else Fraction(1)
    if low is None:
        return min(2 * high, high - 1)
    if low == 0:
        return high / 16
    if 0 < 8 * low < high:
        scale = 10**6
        while low * scale < 1:
            scale *= 1000
        return Fraction(isqrt(int(low * high * scale**2)) + 1, scale)
    return (low + high) / 2


@dataclass(frozen=True)
class Problem:
    """Excesses as products of factors, on a band; ``starts`` : points of the band at which something binds."""

    factors: Sequence[Factor | WaveFactor]
    functions: Mapping[str, Mapping[str, Any]]
    band: tuple[Fraction, Fraction, Fraction, Fraction]
    starts: Sequence[Fraction]

    def slabs(self, ends: Ends, *, holds: bool) -> Iterator[dict[str, Any]]:
        """Slabs from end to end, each with its proof. UndecidedError where so many as a certificate may have do not suffice."""
        most = _MOST_WITH_WAVES if any(isinstance(f, WaveFactor) for f in self.factors) else _MOST_SLABS
        waiting, count = [*ends.halves()[::-1]] if ends.low is ends.high is None else [ends], 1
        while waiting:
            tick()
            here = waiting.pop()
            found = self._slab(here, holds=holds)
            if found is not None:
                yield {"from": _text(here.low), "to": _text(here.high), **found}
            elif count < most:
                waiting += here.halves()[::-1]
                count += 1
            else:
                raise UndecidedError(
                    "a certificate: so many slabs of values, and cells of the band, as it may have are not enough"
                )

    def _slab(self, ends: Ends, *, holds: bool) -> dict[str, Any] | None:
        slab = Slab(self, ends, ends.slices(self.factors))
        if not holds:
            found = next(((x, part) for x in self._tried for part in self.functions if slab.fails(part, x)), None)
            return None if found is None else {"points": [str(found[0])], "part": found[1].partition(".")[2]}
        points = slab.cells()
        return None if points is None else {"points": [str(x) for x in points], "part": None}

    @property
    def _tried(self) -> list[Fraction]:
        """Points of the band at which an excess may be positive: those that bind, and some between."""
        _, low, high, _ = self.band
        near_0 = [Fraction(1, 10**n) for n in (15, 40, 70)] if low == 0 and _have_powers(self.factors) else []
        return [*self.starts, *near_0, high, low, *(low + (high - low) * n / 16 for n in range(1, 16))]


def _have_powers(factors: Sequence[Factor | WaveFactor]) -> bool:
    """Whether there are powers of omega, which have no bounds at 0."""
    return any(isinstance(f, WaveFactor) and f.orders for f in factors)


def _text(x: Value) -> str | None:
    return None if x is None else str(x)


@dataclass(frozen=True)
class Slab:
    """Values between two, with the factors as sums, of positive weights, of functions of omega alone."""

    problem: Problem
    ends: Ends
    slices: Sequence[Slices | WaveSlices]

    def fails(self, name: str, x: Fraction) -> bool:
        """Whether an excess is positive at a point of the band for all values."""
        return self._sign(self.problem.functions[name], x, x, firm=True) == 1

    def cells(self) -> list[Fraction] | None:
        """Points between which no excess is positive; None where so many as a slab may have do not suffice."""
        low, *_, high = self.problem.band
        inner = sorted({x for x in self.problem.starts if low < x < high})
        found, waiting = [low], [high, *inner[::-1]]
        while waiting:
            if self._is_kept(found[-1], waiting[-1]):
                found.append(waiting.pop())
            elif len(found) + len(waiting) < _MOST_CELLS:
                waiting.append((found[-1] + waiting[-1]) / 2)
            else:
                return None
        return found

    def _is_kept(self, a: Fraction, b: Fraction) -> bool:
        return all(self._sign(told, a, b, firm=False) in (-1, 0) for told in self.problem.functions.values())

    def _sign(self, told: Mapping[str, Any], a: Fraction, b: Fraction, *, firm: bool) -> int | None:
        number = Fraction(told["number"])
        found = (number > 0) - (number < 0)
        held = self.ends.holds_low, self.ends.holds_high
        for i, n in told["powers"]:
            own = self.slices[i].side(a, b, held if firm or n < 0 else None)
            if own is None:
                return None
            found *= own ** (n % 2)
        return found


def ascending(values: Sequence[tuple[Value, Value, bool]]) -> bool:
    """Whether the intervals come one after the other, and no two neighbours say the same."""
    return all(a[1] is not None and b[0] is not None and a[1] <= b[0] and a[2] is not b[2] for a, b in pairwise(values))
