"""For which values of a parameter do conditions hold on a whole band? Verdicts on intervals of
values, by ball arithmetic: the work of ``floatcells`` where there is no NumPy.

A condition is a set of functions f_i(omega, q) = N_i/D_i of the frequency omega and the parameter
q. It is *broken* at (omega, q) where all its f_i are positive, and *kept* for q where it is broken
at no omega of the band. A *ball* is an interval of real numbers, given by its middle and radius
(Arb); functions of balls are balls that contain all values.

The values asked about are cut into *cells*, intervals of q, and the band into *pieces*, intervals
of omega. Over a cell times a piece balls enclose each N and D, and dN/dq. Of a cell one of three
things is proven, or it is cut in two:

- All conditions are kept for all its values: on every piece some f_i of each condition is negative.
- A condition is broken for all its values: at one frequency all its f_i are positive for all of
  them.
- It is *monotone*: on every piece on which a condition is not proven to be kept, all f_i whose sign
  is not known can cross 0 only upward as q grows (or only downward, on all pieces). A condition
  that is broken at (omega, q) is then broken at the same omega for all larger (smaller) values of
  the cell. So the verdicts on the two ends of the cell settle it, or bound the one value at which
  the verdict changes.

**Guaranteed**: a verdict on an interval holds for all its values. Where the limits of cells, width
or time end the search, the verdict is None, not known. Values at which a condition holds with
equality are such: cells about them are cut to the smallest width.

Begin reading at ``BallCells.told``. Functions are enclosed by ``ConditionFunction``, their
polynomials by ``ParametricPolynomial``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
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

Span: TypeAlias = tuple[Fraction, Fraction]
"""The two ends of a closed interval, of frequencies or of values of the parameter: dyadic."""
Functions: TypeAlias = "Sequence[ConditionFunction]"
"""A condition: it is broken where all of these are positive."""

# Bits of working precision: the balls are as wide as cells and pieces make them, and these bits
# leave rounding far below that, also in cells of relative width ``_NARROW``.
_BITS = 128
# Relative widths of cells (``BallCells._width``). Cells are cut widest first down to the first one,
# so that all of the range is known roughly when the time is over, and narrower ones in ascending
# order; those below the second one are cut no further.
_COARSE = Fraction(1, 32)
_NARROW = Fraction(1, 2**31)
# Cells that are examined for one question: bounds the work where no time does.
_MOST_CELLS = 3000
# The band is divided into so many equal parts, at whose ends the middle of a cell is tried first.
_SAMPLE_PARTS = 32
# The pieces of the band that a cell may have at a time. A cell wider than ``_COARSE`` is mostly to
# be cut anyway, and has fewer.
_MOST_PIECES, _MOST_PIECES_IF_COARSE = 400, 40
# How often the pieces of one cell are halved; the number of pieces mostly ends that before.
_MOST_HALVINGS_OF_PIECES = 60
# Frequencies at which a condition is broken in the middle of a cell and that are tried in its
# halves: the first few are enough, as neighbouring ones tell the same.
_MOST_HINTS = 4
# How often the interval around the value at which a verdict changes is halved until a value is
# found that keeps all conditions: to 2^-40 of the cell.
_MOST_HALVINGS_OF_VALUES = 40
# Pairs of piece and cell whose products are remembered: all pieces of a cell share them where they
# do not depend on the frequency.
_REMEMBERED = 64
# Where a cell is cut: a little below the half, and so at no simple number at which a verdict may
# change, as cells about such a value are never settled.
_CUT = 509 / 1024


@dataclass(frozen=True)
class BallCells:
    """Conditions on a band in which one parameter is free.

    ``conditions`` : the functions of each, by its criterion. ``free`` : the parameter's symbol.
    ``band`` : the lowest and the highest frequency, rad/s.
    ``scale`` : a usual size of the parameter, > 0.
    ``verdict`` : gives, exactly, whether a single value keeps all conditions: False only where one
    of these is broken, as that is inferred for values beyond; None where it is undecided, or the
    conditions have no meaning.
    """

    conditions: Conditions
    free: Symbol
    band: tuple[Expr, Expr]
    scale: Fraction
    verdict: Callable[[Rational], bool | None]

    def told(self, low: Fraction, high: Fraction) -> list[JudgedValues]:
        """Return what is known of all values from ``low`` to ``high``: intervals in ascending order
        that cover them, neighbours with one verdict merged. What the time did not reach has the
        verdict None."""
        marks = map(Fraction, ladder(float(low), float(high), float(self.scale)))
        start = [_Cell(a, b) for a, b in pairwise(marks)]
        waiting = Waiting(start, self._rank, most=_MOST_CELLS, what="cells of values")
        judged = list[JudgedValues]()
        with suppress(LimitError):
            for cell in waiting:
                verdicts, hints = self._examined(cell)
                if verdicts:
                    judged += verdicts
                elif self._width(cell) < _NARROW:
                    judged.append(JudgedValues(cell.low, cell.high, None))
                else:
                    cut = _cut(cell.low, cell.high)
                    waiting.add(_Cell(cell.low, cut, hints), _Cell(cut, cell.high, hints))
        judged += [JudgedValues(x.low, x.high, None) for x in waiting.rest]
        return merged(sorted(judged, key=lambda x: x.low))

    @cached_property
    def _conditions(self) -> list[Functions]:
        """The conditions, without their criteria."""
        listed = list[Functions]()
        for condition in self.conditions.values():
            listed.append([ConditionFunction.of(f, self.free) for f in pieces(condition)])
        return listed

    @cached_property
    def _whole(self) -> Span:
        """The band, its ends rounded outward to floats."""
        with flint.ctx.workprec(53):
            low, high = map(expression_ball, self.band)
            return Fraction(float(low.lower())), Fraction(float(high.upper()))

    @cached_property
    def _samples(self) -> list[Fraction]:
        """Frequencies on the band at which conditions are tried first: beside its high end, then
        from high to low at equal distances, and ever nearer to its low end, where long delays show
        themselves."""
        low, high = self._whole
        shares = {Fraction(n, _SAMPLE_PARTS) for n in range(1, _SAMPLE_PARTS)}
        shares |= {Fraction(1, 2**n) for n in range(1, 20)}
        descending = [1 - Fraction(1, 2**20), *sorted(shares, reverse=True)]
        return [low + (high - low) * x for x in descending]

    def _examined(self, cell: _Cell) -> tuple[list[JudgedValues], tuple[Fraction, ...]]:
        """Return the verdicts on a cell and hints for its halves.

        The verdicts cover the cell; the list is empty where the cell has to be cut. The hints are
        frequencies at which a condition is broken in the middle of the cell, and only for a cell
        that has to be cut.
        """
        most = _MOST_PIECES_IF_COARSE if self._width(cell) > _COARSE else _MOST_PIECES
        with flint.ctx.workprec(_BITS):
            frequencies = [*cell.hints, *self._samples]
            tried = [(x, frequency) for x in self._conditions for frequency in frequencies]
            # Conditions, each with a piece of the band on which it is not known to be kept.
            left = [(x, self._whole) for x in self._conditions]
            for _ in range(_MOST_HALVINGS_OF_PIECES):
                # First the value in the middle, which is cheap: a condition that is not broken
                # there is not broken on all of the cell.
                broken = [(x, at) for x, at in tried if _is_positive(x, at, cell.middle)]
                if any(self._is_broken(x, at, cell) for x, at in broken):
                    return [JudgedValues(cell.low, cell.high, kept=False)], ()
                if broken:
                    return [], tuple({at for _, at in broken[:_MOST_HINTS]})
                left, trends = _unsettled(left, cell.values)
                if not left:
                    return [JudgedValues(cell.low, cell.high, kept=True)], ()
                if trends in ({1}, {-1}):
                    return self._monotone(cell, is_growing=trends == {1}), ()
                left = [(x, half) for x, piece in left for half in _halves(piece)]
                if len(left) > most:
                    break
                tried = [(x, _middle_of(piece)) for x, piece in left]
        return [], ()

    def _is_broken(self, condition: Functions, frequency: Fraction, cell: _Cell) -> bool:
        """Return whether it is proven that a frequency is on the band, and a condition is broken
        there for all values of a cell."""
        low, high = map(expression_ball, self.band)
        is_on_band = bool(low <= dyadic(frequency) <= high)
        return is_on_band and _is_positive(condition, frequency, cell.values)

    def _monotone(self, cell: _Cell, *, is_growing: bool) -> list[JudgedValues]:
        """Return the verdicts on a cell in which what is broken for one value is broken for all
        larger ones (``is_growing``), or for all smaller ones.

        At the end that breaks least a condition may be broken: then it is so on all of the cell. At
        the end that breaks most all may be kept: then they are so on all of the cell. Otherwise the
        verdict changes at one value. The interval around that value is halved from the side that
        breaks most, until a value is found that keeps all conditions; in it the verdict is None,
        and ``slant`` is 0, as what is broken stays so at the same frequency. Where a verdict is not
        known it is no less true that at most one end lies in there; that there is one show the
        values on both sides, which whoever uses ``slant`` has.
        """
        least_broken, most_broken = cell.values if is_growing else cell.values[::-1]
        if self.verdict(rational(least_broken)) is False:
            return [JudgedValues(cell.low, cell.high, kept=False)]
        if self.verdict(rational(most_broken)) is True:
            return [JudgedValues(cell.low, cell.high, kept=True)]
        keeps, breaks = least_broken, most_broken
        for _ in range(_MOST_HALVINGS_OF_VALUES):
            middle = _middle_of((keeps, breaks))
            kept = self.verdict(rational(middle))
            if kept is not False:
                keeps = middle if kept else keeps
                break
            breaks = middle
        parts = (
            (least_broken, keeps, True, None),
            (keeps, breaks, None, 0.0),
            (breaks, most_broken, False, None),
        )
        verdicts = list[JudgedValues]()
        for a, b, kept, slant in parts:
            if a != b:
                verdicts.append(JudgedValues(min(a, b), max(a, b), kept, slant))
        return verdicts

    def _rank(self, cell: _Cell) -> tuple[Fraction, Fraction]:
        """Return the key by which cells are examined, the least one first."""
        return -max(self._width(cell), _COARSE), cell.low

    def _width(self, cell: _Cell) -> Fraction:
        """Return the width of a cell relative to its largest value, or, for values near 0, to a
        thousandth of a usual size."""
        largest = max(-cell.low, cell.high, self.scale / 1000)
        return (cell.high - cell.low) / largest


@dataclass(frozen=True)
class _Cell:
    """All values from ``low`` to ``high``, and ``hints``, frequencies at which a condition is
    likely broken for them."""

    low: Fraction
    high: Fraction
    hints: tuple[Fraction, ...] = ()

    @property
    def values(self) -> Span:
        """The two ends of the cell."""
        return self.low, self.high

    @property
    def middle(self) -> Span:
        """The single value in the middle."""
        return _point(_middle_of(self.values))


def _is_positive(condition: Functions, frequency: Fraction, values: Span) -> bool:
    """Return whether all functions of a condition are proven to be positive at a frequency for all
    values of an interval; False where that is not known."""
    return all(x.over(_point(frequency), values).sign > 0 for x in condition)


def _unsettled(
    left: Sequence[tuple[Functions, Span]], values: Span
) -> tuple[list[tuple[Functions, Span]], set[int]]:
    """Return those pairs of a condition and a piece of the band for which the condition is not
    proven to be kept on the piece for all values, and the trends of all of them.

    The trend of a pair is the one that all its functions of unknown sign have in common: 1 or -1; 0
    where they have none, or it is not known.
    """
    unsettled = list[tuple[Functions, Span]]()
    trends = set[int]()
    for condition, piece in left:
        bounds = [x.over(piece, values) for x in condition]
        if any(x.sign < 0 for x in bounds):
            continue
        unsettled.append((condition, piece))
        crossing = {x.trend for x in bounds if not x.sign}
        trends.add(crossing.pop() if len(crossing) == 1 else 0)
    return unsettled, trends


def _cut(low: Fraction, high: Fraction) -> Fraction:
    """Return a dyadic number between two others at which a cell is cut."""
    a, b = float(low), float(high)
    # Values of one sign over several octaves are cut by size, at the geometric mean, so that small
    # ones are found as soon as large ones.
    if a >= 0 and (a == 0 or b / a > 4):
        cut = sqrt(a * b) if a > 0 else b / 16
    elif b <= 0 and (b == 0 or a / b > 4):
        cut = -sqrt(a * b) if b < 0 else a / 16
    else:
        cut = a + (b - a) * _CUT
    # Floats may round the cut to an end of a narrow cell.
    return Fraction(cut) if a < cut < b else (low + high) / 2


# Functions over a piece of the band and a cell of values


@dataclass(frozen=True)
class Bounds:
    """What is known of a function f on a piece of the band for all values of a cell.

    ``sign`` : of f, 1 or -1 everywhere; 0 where that is not known. ``trend`` : 1 where f can cross
    0 only upward as the parameter grows, -1 only downward; 0 where that is not known, or the sign
    is known.
    """

    sign: int
    trend: int


@dataclass(frozen=True, eq=False)
class ConditionFunction:
    """One of the functions f = N/D of a condition."""

    numerator: ParametricPolynomial
    denominator: ParametricPolynomial

    @classmethod
    def of(cls, f: RealFunction, free: Symbol) -> ConditionFunction:
        """Return the function of omega and the parameter ``free``. Its angles are halved, so that
        numerator and denominator share no factor and D vanishes nowhere without need."""
        halved = f.half_angled
        return cls(
            ParametricPolynomial(halved.numerator, halved.ring, free),
            ParametricPolynomial(halved.denominator, halved.ring, free),
        )

    def over(self, piece: Span, values: Span) -> Bounds:
        """Return the sign and the trend of N/D over a piece and a cell.

        The trend is the sign of dN/dq times that of D. Where D has one sign, N/D is 0 where N is,
        and at such a value it crosses 0 in the direction in which N/sign(D) does, whatever the
        slope of D.
        """
        sign_of_d = _first_sign(x for x, _ in self.denominator.over(piece, values))
        if not sign_of_d:
            return Bounds(0, 0)
        trend = 0
        for value, slope in self.numerator.over(piece, values):
            if sign_of_n := sign_of(value):
                return Bounds(sign_of_n * sign_of_d, 0)
            trend = sign_of(slope) * sign_of_d
        return Bounds(0, trend)


def _first_sign(balls: Iterable[Ball]) -> int:
    """Return the sign of the first ball that does not contain 0; 0 where all do."""
    return next((sign for x in balls if (sign := sign_of(x))), 0)


@dataclass(frozen=True, eq=False)
class ParametricPolynomial:
    """A polynomial of a ring as a function of the frequency omega and one parameter q: a sum of
    a_i(omega) m_i(omega, q).

    The generators of the ring stand for functions (``ring.meanings``): omega, q, or cos(omega
    tau/2) of a delay, say. m_i is a product of powers of those that depend on q, its *factors*; a_i
    has all others. The a_i are enclosed once for each piece of the band and serve all cells of
    values.
    """

    polynomial: Polynomial
    ring: PolynomialRing
    free: Symbol

    def over(self, piece: Span, values: Span) -> Iterator[tuple[Ball, Ball]]:
        """Yield pairs of balls that contain f and df/dq over a piece and a cell: up to three, each
        no wider than the one before, and dearer.

        1. By its terms.
        2. By the mean value theorem in q: f(omega, m) + df/dq (q - m), m the middle of the cell.
        3. Where the piece is more than one frequency, by that theorem in omega too:
           f(n, q) + df/domega (omega - n), n the middle of the piece.
        """
        value, slope_q, slope_omega = self._by_terms(piece, values)
        yield value, slope_q
        q, frequency = _ball(values), _ball(piece)
        from_middle_q = q - q.mid()
        middle_q = _point(_middle_of(values))
        at_middle_q, _, _ = self._by_terms(piece, middle_q)
        value = _both(value, at_middle_q + slope_q * from_middle_q)
        yield value, slope_q
        if frequency.rad():
            middle_omega = _point(_middle_of(piece))
            along_q, slope_there, _ = self._by_terms(middle_omega, values)
            at_both_middles, _, _ = self._by_terms(middle_omega, middle_q)
            along_q = _both(along_q, at_both_middles + slope_there * from_middle_q)
            from_middle_omega = frequency - frequency.mid()
            yield _both(value, along_q + slope_omega * from_middle_omega), slope_q

    def _by_terms(self, piece: Span, values: Span) -> tuple[Ball, Ball, Ball]:
        """Return balls that contain f, df/dq and df/domega over a piece and a cell, by its
        terms."""
        products = self._products(piece if self._is_mixed else None, values)
        # Rows a_i and da_i/domega times columns m_i, dm_i/dq and dm_i/domega.
        sums = self._coefficients(piece) * products
        value, slope_q = sums[0, 0], sums[0, 1]
        return value, slope_q, sums[1, 0] + sums[0, 2]

    @cached_property
    def _factors(self) -> list[tuple[int, Expr]]:
        """The generators that occur and depend on the parameter: the index of each in the ring, and
        the function that it stands for."""
        degrees = self.polynomial.degrees()
        occurring = [(i, x) for i, x in enumerate(self.ring.meanings) if degrees[i] > 0]
        return [(i, x) for i, x in occurring if x.has(self.free)]

    @cached_property
    def _is_mixed(self) -> bool:
        """Whether one of the factors depends on the frequency too."""
        return any(x.has(omega) for _, x in self._factors)

    @cached_property
    def _terms(self) -> dict[tuple[int, ...], FrequencyPolynomial]:
        """The a_i, each by the exponents of the factors in its m_i."""
        indices = [i for i, _ in self._factors]
        # The monomials of each a_i, in the exponents of all generators, those of the factors 0.
        rows = dict[tuple[int, ...], dict[tuple[int, ...], fmpq]]()
        for monomial, coefficient in monomials(self.polynomial):
            exponents = [int(n) for n in monomial]
            of_factors = tuple(exponents[i] for i in indices)
            rest = tuple(0 if i in indices else n for i, n in enumerate(exponents))
            rows.setdefault(of_factors, {})[rest] = coefficient
        context = self.polynomial.context()
        return {n: FrequencyPolynomial(context.from_dict(x), self.ring) for n, x in rows.items()}

    @cached_property
    def _coefficients(self) -> Callable[[Span], arb_mat]:
        """A function that encloses, on a piece of the band, all a_i as one row of a matrix and all
        da_i/domega as another."""

        @cache
        def coefficients(piece: Span) -> arb_mat:
            pairs = [x.over(_ball(piece)) for x in self._terms.values()]
            return arb_mat([[value for value, _ in pairs], [slope for _, slope in pairs]])

        return coefficients

    @cached_property
    def _products(self) -> Callable[[Span | None, Span], arb_mat]:
        """A function that encloses, over a piece (None: they do not depend on it) and a cell, the
        m_i: a row of m_i, dm_i/dq and dm_i/domega for each."""

        @lru_cache(_REMEMBERED)
        def products(piece: Span | None, values: Span) -> arb_mat:
            known: dict[Expr, Ball] = {self.free: _ball(values)}
            if piece is not None:
                known[omega] = _ball(piece)
            factors = [_value(x, known) for _, x in self._factors]
            # For q, and for omega where it is known, the slopes of all factors.
            slopes = list[list[Ball]]()
            for by in [*known]:
                slopes.append([_slope(x, by, known) for _, x in self._factors])
            rows = list[list[Ball]]()
            for exponents in self._terms:
                row = [_product(factors, exponents)]
                row += [_product_rule(factors, x, exponents) for x in slopes]
                # What does not depend on the frequency has the slope 0 along the band.
                missing = [arb(0)] * (3 - len(row))
                rows.append([*row, *missing])
            return arb_mat(rows)

        return products


@dataclass(frozen=True, eq=False)
class FrequencyPolynomial:
    """A polynomial of a ring as a function of the frequency alone."""

    polynomial: Polynomial
    ring: PolynomialRing

    def over(self, frequency: Ball) -> tuple[Ball, Ball]:
        """Return balls that contain the function and its slope over a ball of frequencies: the
        function by its terms and by the mean value theorem, the slope by the chain rule."""
        known = self._known(frequency)
        slope = arb(0)
        for x, partial in self._partial:
            slope += _sum(partial, self.ring, known) * _slope(x, omega, known)
        value = _sum(self.polynomial, self.ring, known)
        if not frequency.rad():
            return value, slope
        at_middle = _sum(self.polynomial, self.ring, self._known(frequency.mid()))
        return _both(value, at_middle + slope * (frequency - frequency.mid())), slope

    @cached_property
    def _used(self) -> list[tuple[int, Expr]]:
        """The generators that occur: the index of each in the ring, and its function."""
        degrees = self.polynomial.degrees()
        return [(i, x) for i, x in enumerate(self.ring.meanings) if degrees[i] > 0]

    @cached_property
    def _partial(self) -> list[tuple[Expr, Polynomial]]:
        """The partial derivatives by the generators that depend on the frequency, each after the
        generator's function."""
        return [(x, self.polynomial.derivative(i)) for i, x in self._used if x.has(omega)]

    def _known(self, frequency: Ball) -> dict[Expr, Ball]:
        """Return balls around the values of omega and of all generators that occur."""
        known: dict[Expr, Ball] = {omega: frequency}
        return known | {x: _value(x, known) for _, x in self._used}


# Balls


def _product(factors: Sequence[Ball], exponents: Sequence[int]) -> Ball:
    """Return a ball around a product of powers."""
    powers = (_to_the(x, n) for x, n in zip(factors, exponents, strict=True))
    return prod(powers, start=arb(1))


def _product_rule(
    factors: Sequence[Ball], slopes: Sequence[Ball], exponents: Sequence[int]
) -> Ball:
    """Return a ball around the slope of a product of powers, given the slopes of its factors."""
    total = arb(0)
    for i, n in enumerate(exponents):
        if n:
            one_less = [m - (j == i) for j, m in enumerate(exponents)]
            total += n * slopes[i] * _product(factors, one_less)
    return total


def _to_the(x: Ball, n: int) -> Ball:
    """Return a ball around the n-th powers of all numbers in a ball, n >= 0: by the powers of its
    ends, which is narrower than a product of wide balls."""
    if n < 2 or not x.rad():
        return x**n
    between = (x.lower() ** n).union(x.upper() ** n)
    # The least value of an even power is that at 0.
    return between.union(arb(0)) if n % 2 == 0 and x.contains(0) else between


def _sum(polynomial: Polynomial, ring: PolynomialRing, known: dict[Expr, Ball]) -> Ball:
    """Return a ball around the value of a polynomial; ``known`` : a ball for the function that each
    of its generators stands for."""
    powers = dict[tuple[Expr, int], Ball]()
    total = arb(0)
    for exponents, coefficient in monomials(polynomial):
        term = arb(coefficient)
        for key in zip(ring.meanings, exponents, strict=True):
            x, n = key
            if n:
                if key not in powers:
                    powers[key] = _to_the(known[x], int(n))
                term *= powers[key]
        total += term
    return total


def _value(x: Expr, known: dict[Expr, Ball]) -> Ball:
    """Return a ball around the function that a generator stands for; ``known`` : balls for the
    frequency and the parameter."""
    # ``x**y`` of balls is exp(y log x), and a ball that contains 0 has no logarithm: ``power``
    # encloses it there too.
    if isinstance(x, Pow):
        return power(expression_ball(x.base, known), expression_ball(x.exp, known))
    return expression_ball(x, known)


def _slope(x: Expr, by: Symbol, known: dict[Expr, Ball]) -> Ball:
    """Return a ball around the partial derivative, by omega or the parameter, of the function that
    a generator stands for."""
    if not isinstance(x, sinc):
        return expression_ball(_derivative(x, by), known)
    # sinc a = sin(a)/a has the derivative (cos a - sinc a)/a, which cannot be evaluated where a may
    # be 0: there |sinc'(a)| <= |a|/3.
    angle = expression_ball(x.args[0], known)
    outer = arb(0, (angle / 3).abs_upper())
    if sign_of(angle):
        outer = (angle.cos() - angle.sinc()) / angle
    return outer * expression_ball(_derivative(x.args[0], by), known)


@cache
def _derivative(x: Expr, by: Symbol) -> Expr:
    """Return the derivative of a formula; remembered, as SymPy is slow."""
    return x.diff(by)


def _both(a: Ball, b: Ball) -> Ball:
    """Return the intersection of two balls that contain one number; ``b`` where ``a`` is not
    finite, and ``a`` where ``b`` is not."""
    if not (a.is_finite() and b.is_finite()):
        return a if a.is_finite() else b
    return a.intersection(b)


def _point(x: Fraction) -> Span:
    """Return the interval that is one number."""
    return x, x


def _middle_of(between: Span) -> Fraction:
    """Return the middle of an interval."""
    return (between[0] + between[1]) / 2


def _halves(between: Span) -> tuple[Span, Span]:
    """Return the two halves of an interval."""
    middle = _middle_of(between)
    return (between[0], middle), (middle, between[1])


def _ball(between: Span) -> Ball:
    """Return a ball that contains an interval; exact for a single number."""
    low, high = between
    return dyadic(low) if low == high else dyadic(low).union(dyadic(high))
