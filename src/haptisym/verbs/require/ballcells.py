"""What balls show of conditions for all values of a parameter in an interval at once: the work of
``floatcells`` where there is no NumPy.

A condition is a set of functions N/D, of which at no frequency of the band all may be positive.
Over a piece of the band and a cell of values, balls enclose N and D, and the slope of N along the
values. All that is told of a cell is proven:

- all conditions are *kept* if on every piece one function of each is negative,
- one is *broken* if at one frequency all its functions are positive for all values of the cell,
- the verdicts on its two ends decide if on every piece that is left what may be positive grows
  with the values, or falls on every one: what is broken for a value is then broken at the same
  frequency for all values on one side of it.

Other cells are cut, the widest first: at once where a condition is broken in the middle of a cell
but not shown to be so on all of it. What is left after many cells stays open. Begin with
``BallCells.told``; ``Sheet`` and ``Alone`` are how a function is enclosed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, lru_cache
from itertools import pairwise
from math import prod, sqrt
from typing import TypeAlias

import flint
from flint import arb, arb_mat, fmpq
from sympy import Expr, Pow, Rational, Symbol, sinc

from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import Ball, dyadic, expression_ball, rational
from haptisym.kernel.rings import Polynomial, PolynomialRing, monomials, omega
from haptisym.kernel.zeros import sign_of
from haptisym.programs.balls import power
from haptisym.verbs.require.freeparameter import Conditions, JudgedValues, ladder, merged, pieces

_BITS = 128
# Frequencies at which the middle of a cell is tried.
_SAMPLES = 32
# How many pieces of the band may be left, fewer in wide cells, which are mostly to be cut; and how
# often they are halved.
_MOST_PIECES, _MOST_LEVELS = (400, 40), 60
# Frequencies that a cell hands on to its halves, and how often an open end is halved.
_MOST_HINTS, _MOST_HALVES = 4, 40
_MOST_CELLS = 3000
# Relative width of cells that are cut no further.
_NARROW = Fraction(1, 2**31)
# Cells are cut widest first down to this relative width, and narrower ones in order.
_COARSE = Fraction(1, 32)

Span: TypeAlias = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Bounds:
    """What is known of a function on a piece of the band for all values of a cell: its ``sign``,
    and its ``trend``, the sign of its slope along the values; 0 where that is not known."""

    sign: int
    trend: int


@dataclass(frozen=True, eq=False)
class Sheet:
    """A polynomial of a ring as a function of the frequency and one parameter: a sum of a_i(omega)
    m_i.

    m_i is a product of what depends on the parameter: of its powers, or of cos(omega tau/2), say.
    The a_i, which do not, are enclosed once for each piece of the band and serve all cells of
    values.
    """

    polynomial: Polynomial
    ring: PolynomialRing
    free: Symbol

    def over(self, piece: Span, values: Span) -> Iterator[tuple[Ball, Ball]]:
        """Balls around the function and around its slope along the values, over a piece and a cell:
        three pairs, each narrower than the one before and dearer.

        By its terms; by the mean value theorem along the values; by that along the band too.
        """
        own, slope, tilt = self._at(piece, values)
        yield own, slope
        value, place = _ball(values), _ball(piece)
        side = value - value.mid()
        middle = _point(_middle_of(values))
        own = _both(own, self._at(piece, middle)[0] + slope * side)
        yield own, slope
        if place.rad():
            there = _point(_middle_of(piece))
            along, change, _ = self._at(there, values)
            along = _both(along, self._at(there, middle)[0] + change * side)
            yield _both(own, along + tilt * (place - place.mid())), slope

    def _at(self, piece: Span, values: Span) -> tuple[Ball, Ball, Ball]:
        """Balls around the function and around its slopes along the values and along the band, by
        its terms."""
        products = self._products(piece if self._is_mixed else None, values)
        found = self._column(piece) * products
        return found[0, 0], found[0, 1], found[1, 0] + found[0, 2]

    @cached_property
    def _factors(self) -> list[tuple[int, Expr]]:
        """The variables of the ring that depend on the parameter and are in the polynomial, each
        with its index."""
        degrees = self.polynomial.degrees()
        return [
            (i, x) for i, x in enumerate(self.ring.meanings) if x.has(self.free) and degrees[i] > 0
        ]

    @cached_property
    def _is_mixed(self) -> bool:
        """Whether one of the factors depends on the frequency too."""
        return any(x.has(omega) for _, x in self._factors)

    @cached_property
    def _terms(self) -> dict[tuple[int, ...], Alone]:
        """The a_i, by the exponents of the factors in m_i."""
        places = [i for i, _ in self._factors]
        rows = dict[tuple[int, ...], dict[tuple[int, ...], fmpq]]()
        for exponents, coefficient in monomials(self.polynomial):
            own = [int(n) for n in exponents]
            rest = tuple(0 if i in places else n for i, n in enumerate(own))
            rows.setdefault(tuple(own[i] for i in places), {})[rest] = coefficient
        return {
            x: Alone(self.polynomial.context().from_dict(row), self.ring) for x, row in rows.items()
        }

    @cached_property
    def _column(self) -> Callable[[Span], arb_mat]:
        """A function that encloses, on a piece of the band, all a_i in one row and their slopes in
        another."""

        @cache
        def column(piece: Span) -> arb_mat:
            pairs = [x.over(_ball(piece)) for x in self._terms.values()]
            return arb_mat([[x for x, _ in pairs], [x for _, x in pairs]])

        return column

    @cached_property
    def _products(self) -> Callable[[Span | None, Span], arb_mat]:
        """A function that encloses, over a piece (None: they do not depend on it) and a cell, each
        m_i with its slopes along the values and along the band, as a row."""

        @lru_cache(64)
        def products(piece: Span | None, values: Span) -> arb_mat:
            known: dict[Expr, Ball] = {self.free: _ball(values)}
            if piece is not None:
                known[omega] = _ball(piece)
            factors = [_value(x, known) for _, x in self._factors]
            changes = [[_change(x, by, known) for _, x in self._factors] for by in [*known]]
            rows = list[list[Ball]]()
            for n in self._terms:
                row = [_product(factors, n), *(_product_rule(factors, x, n) for x in changes)]
                # What does not depend on the frequency has the slope 0 along the band.
                missing = [arb(0)] * (3 - len(row))
                rows.append([*row, *missing])
            return arb_mat(rows)

        return products


@dataclass(frozen=True, eq=False)
class Alone:
    """A polynomial of a ring as a function of the frequency alone."""

    polynomial: Polynomial
    ring: PolynomialRing

    def over(self, place: Ball) -> tuple[Ball, Ball]:
        """Balls around the function, by its terms and by the mean value theorem, and around its
        slope."""
        known = self._known(place)
        slope = sum(
            (_sum(p, self.ring, known) * _change(x, omega, known) for x, p in self._partial), arb(0)
        )
        own = _sum(self.polynomial, self.ring, known)
        if not place.rad():
            return own, slope
        middle = _sum(self.polynomial, self.ring, self._known(place.mid()))
        return _both(own, middle + slope * (place - place.mid())), slope

    @cached_property
    def _used(self) -> list[tuple[int, Expr]]:
        """The variables of the ring that stand in the polynomial, with their places."""
        return [
            (i, x) for i, x in enumerate(self.ring.meanings) if self.polynomial.degrees()[i] > 0
        ]

    @cached_property
    def _partial(self) -> list[tuple[Expr, Polynomial]]:
        """Its partial derivatives by the variables that depend on the frequency."""
        return [(x, self.polynomial.derivative(i)) for i, x in self._used if x.has(omega)]

    def _known(self, place: Ball) -> dict[Expr, Ball]:
        """Balls around what the variables are at a frequency."""
        known: dict[Expr, Ball] = {omega: place}
        return known | {x: _value(x, known) for _, x in self._used}


def _product(factors: Sequence[Ball], exponents: Sequence[int]) -> Ball:
    return prod((_to_the(x, n) for x, n in zip(factors, exponents, strict=True)), start=arb(1))


def _product_rule(
    factors: Sequence[Ball], changes: Sequence[Ball], exponents: Sequence[int]
) -> Ball:
    """A ball around the slope of a product of powers whose factors have these slopes."""
    total = arb(0)
    for i, n in enumerate(exponents):
        if n:
            less = [m - (j == i) for j, m in enumerate(exponents)]
            total += n * changes[i] * _product(factors, less)
    return total


def _to_the(x: Ball, n: int) -> Ball:
    """A ball around the powers of all numbers in another: narrower than a product of wide balls."""
    if n < 2 or not x.rad():
        return x**n
    found = (x.lower() ** n).union(x.upper() ** n)
    return found if n % 2 or not x.contains(0) else found.union(arb(0))


def _sum(polynomial: Polynomial, ring: PolynomialRing, known: dict[Expr, Ball]) -> Ball:
    """A ball around a polynomial's value where its variables are worth these balls."""
    powers, total = dict[tuple[Expr, int], Ball](), arb(0)
    for exponents, coefficient in monomials(polynomial):
        term = arb(coefficient)
        for place in zip(ring.meanings, exponents, strict=True):
            if place[1]:
                if place not in powers:
                    powers[place] = _to_the(known[place[0]], int(place[1]))
                term *= powers[place]
        total += term
    return total


def _value(x: Expr, known: dict[Expr, Ball]) -> Ball:
    """A ball around what a variable of a ring stands for."""
    # A ball about 0 has no logarithm, so that a power of the frequency is more than its formula.
    if isinstance(x, Pow):
        return power(expression_ball(x.base, known), expression_ball(x.exp, known))
    return expression_ball(x, known)


def _both(a: Ball, b: Ball) -> Ball:
    """The intersection of two enclosures of one number; one of them where the other is not
    finite."""
    if not (a.is_finite() and b.is_finite()):
        return a if a.is_finite() else b
    return a.intersection(b)


def _change(x: Expr, by: Symbol, known: dict[Expr, Ball]) -> Ball:
    """A ball around the slope of a variable of a ring; of sinc, whose own formula ends at 0,
    |sinc'(a)| <= |a|/3."""
    if not isinstance(x, sinc):
        return expression_ball(_derivative(x, by), known)
    angle = expression_ball(x.args[0], known)
    bent = (
        (angle.cos() - angle.sinc()) / angle if sign_of(angle) else arb(0, (angle / 3).abs_upper())
    )
    return bent * expression_ball(_derivative(x.args[0], by), known)


@cache
def _derivative(x: Expr, by: Symbol) -> Expr:
    return x.diff(by)


def _point(x: Fraction) -> Span:
    return x, x


def _middle_of(between: Span) -> Fraction:
    return (between[0] + between[1]) / 2


def _halves(between: Span) -> tuple[Span, Span]:
    middle = _middle_of(between)
    return (between[0], middle), (middle, between[1])


def _ball(between: Span) -> Ball:
    low, high = between
    return dyadic(low) if low == high else dyadic(low).union(dyadic(high))


@dataclass(frozen=True, eq=False)
class ConditionFunction:
    """One of the functions of a condition: N (``above``) over D (``below``)."""

    above: Sheet
    below: Sheet

    @classmethod
    def of(cls, f: RealFunction, free: Symbol) -> ConditionFunction:
        """A function in which a parameter is free."""
        own = f.half_angled
        return cls(*(Sheet(x, own.ring, free) for x in (own.numerator, own.denominator)))

    def over(self, piece: Span, values: Span) -> Bounds:
        """The sign and the trend of N/D over a piece and a cell.

        The trend is that of N times the sign of D: where N/D is 0 it grows along the values as N
        does, D having one sign, whatever the slope of D.
        """
        below = _first_sign(x for x, _ in self.below.over(piece, values))
        if not below:
            return Bounds(0, 0)
        trend = 0
        for value, change in self.above.over(piece, values):
            if sign := sign_of(value):
                return Bounds(sign * below, 0)
            trend = sign_of(change) * below
        return Bounds(0, trend)


def _first_sign(balls: Iterable[Ball]) -> int:
    return next((sign for x in balls if (sign := sign_of(x))), 0)


@dataclass(frozen=True)
class _Cell:
    """A cell of values, and frequencies at which a condition is likely broken in it."""

    low: Fraction
    high: Fraction
    hints: tuple[Fraction, ...] = ()

    @property
    def values(self) -> Span:
        """The values of the cell, as a pair of ends."""
        return self.low, self.high

    @property
    def middle(self) -> Span:
        """The one in the middle."""
        return _point(_middle_of(self.values))


@dataclass(frozen=True)
class BallCells:
    """Conditions on a band in which one parameter is free.

    ``scale`` : a usual size of the parameter. ``verdict`` : whether a single value keeps all
    conditions, exactly.
    """

    conditions: Conditions
    free: Symbol
    band: tuple[Expr, Expr]
    scale: Fraction
    verdict: Callable[[Rational], bool | None]

    def told(self, low: Fraction, high: Fraction) -> list[JudgedValues]:
        """What is known of the values from one to another, in order."""
        marks = map(Fraction, ladder(float(low), float(high), float(self.scale)))
        start = [_Cell(a, b) for a, b in pairwise(marks)]
        waiting = Waiting(start, self._rank, most=_MOST_CELLS, what="cells of values")
        found = list[JudgedValues]()
        try:
            for cell in waiting:
                verdicts = self._told(cell)
                if isinstance(verdicts, list):
                    found += verdicts
                elif self._width(cell) < _NARROW:
                    found.append(JudgedValues(cell.low, cell.high, None))
                else:
                    middle = _middle(cell.low, cell.high)
                    hints = verdicts
                    waiting.add(_Cell(cell.low, middle, hints), _Cell(middle, cell.high, hints))
        except LimitError:
            pass
        found += [JudgedValues(x.low, x.high, None) for x in waiting.rest]
        return merged(sorted(found, key=lambda x: x.low))

    @cached_property
    def _functions(self) -> list[list[ConditionFunction]]:
        """For each condition the functions that must not all be positive at one frequency."""
        return [
            [ConditionFunction.of(f, self.free) for f in pieces(own)]
            for own in self.conditions.values()
        ]

    @cached_property
    def _whole(self) -> Span:
        """Floats that enclose the band."""
        with flint.ctx.workprec(53):
            low, high = map(expression_ball, self.band)
            return Fraction(float(low.lower())), Fraction(float(high.upper()))

    @cached_property
    def _samples(self) -> list[Fraction]:
        """Frequencies on the band; near its low end, where long delays show themselves, and beside
        the high one."""
        low, high = self._whole
        shares = {Fraction(n, _SAMPLES) for n in range(1, _SAMPLES)} | {
            Fraction(1, 2**n) for n in range(1, 20)
        }
        return [
            low + (high - low) * x for x in [1 - Fraction(1, 2**20), *sorted(shares, reverse=True)]
        ]

    def _told(self, cell: _Cell) -> list[JudgedValues] | tuple[Fraction, ...]:
        """The verdicts on a cell; as a tuple, where there is none, frequencies at which a condition
        is likely broken in it."""
        with flint.ctx.workprec(_BITS):
            suspects = [(own, x) for own in self._functions for x in [*cell.hints, *self._samples]]
            left = [(own, self._whole) for own in self._functions]
            for _ in range(_MOST_LEVELS):
                # First the value in the middle, which is cheap: a condition that is not broken
                # there is not broken on all of the cell.
                broken = [(own, x) for own, x in suspects if _is_positive(own, x, cell.middle)]
                if any(self._is_broken(own, x, cell) for own, x in broken):
                    return [JudgedValues(cell.low, cell.high, kept=False)]
                if broken:
                    return tuple({x for _, x in broken[:_MOST_HINTS]})
                known = [(own, piece, _trend(own, piece, cell.values)) for own, piece in left]
                trends = {trend for _, _, trend in known if trend is not None}
                if not trends:
                    return [JudgedValues(cell.low, cell.high, kept=True)]
                if trends in ({1}, {-1}):
                    return self._monotone(cell, growing=trends == {1})
                left = [
                    (own, half)
                    for own, piece, trend in known
                    if trend is not None
                    for half in _halves(piece)
                ]
                if len(left) > _MOST_PIECES[self._width(cell) > _COARSE]:
                    break
                suspects = [(own, _middle_of(piece)) for own, piece in left]
        return ()

    def _is_broken(
        self, functions: Sequence[ConditionFunction], place: Fraction, cell: _Cell
    ) -> bool:
        """Whether a condition is broken at a frequency, which is on the band, for all values of a
        cell."""
        low, high = map(expression_ball, self.band)
        return bool(low <= dyadic(place) <= high) and _is_positive(functions, place, cell.values)

    def _monotone(self, cell: _Cell, *, growing: bool) -> list[JudgedValues]:
        """The verdicts on a cell in which more and more is broken as the values grow, or fall:
        those on its two ends decide.

        Where the two differ, there is one end in the cell, and what is open around it is halved
        until there are values beside it that keep all conditions.
        """
        best, worst = cell.values if growing else cell.values[::-1]
        if self.verdict(rational(best)) is False:
            return [JudgedValues(cell.low, cell.high, kept=False)]
        if self.verdict(rational(worst)) is True:
            return [JudgedValues(cell.low, cell.high, kept=True)]
        near, far = best, worst
        for _ in range(_MOST_HALVES):
            middle = _middle_of((near, far))
            kept = self.verdict(rational(middle))
            if kept is not False:
                near = middle if kept else near
                break
            far = middle
        parts = (best, near, True, None), (near, far, None, 0.0), (far, worst, False, None)
        return [
            JudgedValues(min(a, b), max(a, b), kept, slant) for a, b, kept, slant in parts if a != b
        ]

    def _rank(self, cell: _Cell) -> tuple[Fraction, Fraction]:
        return -max(self._width(cell), _COARSE), cell.low

    def _width(self, cell: _Cell) -> Fraction:
        """The width of a cell relative to its values, and near 0 to a thousandth of a usual
        size."""
        return (cell.high - cell.low) / max(-cell.low, cell.high, self.scale / 1000)


def _is_positive(functions: Sequence[ConditionFunction], place: Fraction, values: Span) -> bool:
    """Whether a condition is broken at a frequency for all values between two."""
    return all(x.over(_point(place), values).sign > 0 for x in functions)


def _trend(functions: Sequence[ConditionFunction], piece: Span, values: Span) -> int | None:
    """Whether a condition is broken on a piece of the band for more and more of the values, 1, or
    for fewer, -1.

    0 where that is not known, None where it is kept there for all of them.
    """
    bounds = [x.over(piece, values) for x in functions]
    if any(x.sign < 0 for x in bounds):
        return None
    trends = {x.trend for x in bounds if not x.sign}
    return trends.pop() if len(trends) == 1 else 0


def _middle(low: Fraction, high: Fraction) -> Fraction:
    """A dyadic number inside, between numbers of one sign nearer their geometric mean; never a
    simple one."""
    a, b = float(low), float(high)
    # Values of one sign over several octaves are cut by size, so that small ones are found as soon.
    if a >= 0 and (a == 0 or b / a > 4):
        cut = sqrt(a * b) if a > 0 else b / 16
    elif b <= 0 and (b == 0 or a / b > 4):
        cut = -sqrt(a * b) if b < 0 else a / 16
    else:
        # 509/1024: a little below the half, and so at no simple number that an end may be.
        cut = a + (b - a) * 0.4970703125
    return Fraction(cut) if a < cut < b else (low + high) / 2
