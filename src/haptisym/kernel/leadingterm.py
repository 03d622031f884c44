"""How a sum of delay terms begins at omega = 0: its leading term, the order of its zero there, and
an interval (0, r] on which it has no zero.

A delay tau enters a real function of omega by cosines and sines of omega tau, a power s^alpha by
omega^alpha and a constant angle alpha pi/2. Such a function f is a ``WaveSum``
(``kernel.delayterms``),

    f(omega) = sum over l of omega^(e_l) A_l(omega),      e_l = alpha_1 l_1 + alpha_2 l_2 + ...,

with *cofactors* A_l that are analytic everywhere, sums of polynomials in omega times sines and
cosines of half angles. With A_l = sum over n of a_(l,n) omega^n this is the expansion of f at 0 in
powers omega^(e_l + n).

**Problem.** Which is the first term of the expansion that is not 0, and how far to its right is f
without a zero? Where alpha is rational, terms of several l may have the same exponent, and their
coefficients may cancel: Re s^(2 alpha) is 0 for alpha = 1/2. No ball decides that a sum is 0, so
that coefficients are needed as exact numbers.

**Method.** At omega = 0 every delay angle is 0, its cosine 1 and its sine 0, so that the Taylor
coefficients of cofactors are exact (``taylor_coefficients``): polynomials in pi and in cosines and
sines of constant angles, for which ``kernel.zerotest`` decides whether they are 0. Exponents are
taken in ascending order; the coefficients that meet at one are added, in balls first, which prove
most sums to be other than 0 at once. To the right of 0, let e be the exponent of the leading term
and n_l >= 0 the lowest integer with e_l + n_l >= e. Taylor's theorem with Lagrange's remainder
(W. Rudin, Principles of Mathematical Analysis, theorem 5.15) for each A_l about 0 leaves, as all
terms of exponents below e cancel,

    f(x) = x^e sum over l of x^(e_l + n_l - e) A_l^(n_l)(xi_l)/n_l!,      0 <= xi_l <= x.

Where a ball around that sum over [0, r] is clear of 0, f has no zero in (0, r].

**Returned** are exact exponents and orders, and a number r that is proven.

**Failure.** UndecidedError where it is not decided whether a coefficient is 0, where all terms that
are tried vanish, or where no r is found. What None means is said at each function.

Begin reading with ``leading_term`` and ``clear_of_zero``; sums without powers of omega have a
faster way (``order_at_0``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce
from heapq import heapify, heapreplace
from itertools import accumulate, islice, repeat
from operator import mul
from typing import NamedTuple, TypeAlias

import flint
from flint import arb, fmpq, fmpq_poly
from sympy import Expr, Integer, Symbol, cancel, pi

from haptisym.kernel.delayterms import Powers, WaveSum
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, at_rising_precision, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, monomials, omega
from haptisym.kernel.zeros import is_clear
from haptisym.kernel.zerotest import is_zero_number

# The largest ratio b/a of the ends of a piece [a, b] on which a sum with powers of omega is
# expanded. The midpoint is then at most 2 a, and the radius at most half of it: Taylor's terms of
# omega^alpha fall as (1/2)^n, and the bound of the remainder, taken at a, does not grow with n.
LARGEST_RATIO = 3.0
# ``clear_of_zero`` first shortens (0, r] by that ratio, so that r is not much smaller than it must
# be; after so many steps r is by orders of magnitude too large, and is divided by 16.
_FINE_STEPS = 4
# They reach 2^-790 of the first r; the numbers of a scene do not span that much.
_MOST_STEPS = 200
# Floats order irrational exponents that differ by more: they are a few units large, and their
# roundings, also in ``_MOST_TERMS`` steps by 1, add up to less.
_APART = 1e-9
# Terms of an expansion that are tried: orders 1/5 and 1/12 alone give sixty between two integers.
_MOST_TERMS = 2000
# Lengths of the Taylor polynomials that are tried in turn in ``order_at_0``: mostly the order of a
# zero is small, and the work grows with the square of the length.
_LENGTHS = 8, 32, 128
_BITS = 128
_ZERO, _ONE = fmpq_poly([0]), fmpq_poly([1])


# The leading term


class ExpansionPart(NamedTuple):
    """One l of the expansion: omega^(e_l) A_l. ``exponent``: e_l; ``order``: n_l, so that all terms
    with exponents e_l + n, n < n_l, are below the leading term."""

    powers: Powers
    exponent: Expr
    order: int


@dataclass(frozen=True)
class LeadingTerm:
    """Where the expansion at omega = 0 begins: ``exponent`` e, and a part for each l. All terms
    with exponents below e cancel, those with exponent e do not."""

    exponent: Expr
    parts: tuple[ExpansionPart, ...]


_Coefficient: TypeAlias = tuple[Powers, int]
"""(l, n) for the coefficient a_(l,n) of the expansion."""


@lru_cache(maxsize=1024)
def leading_term(f: WaveSum) -> LeadingTerm:
    """The first term of the expansion at omega = 0 that is not 0: exact.

    UndecidedError where it is not decided whether one before it is 0, or where ``_MOST_TERMS`` of
    them are.
    """
    exponents: dict[Powers, Expr] = {}
    for term in f.terms:
        products = [a * n for a, n in zip(f.orders, term.powers, strict=True)]
        exponents.setdefault(term.powers, sum(products, Integer(0)))
    for exponent, coefficients in _ascending(list(exponents.items())):
        if not _cancel(f, coefficients):
            parts = (ExpansionPart(x, e, _order(exponent - e)) for x, e in exponents.items())
            return LeadingTerm(exponent, tuple(parts))
    raise UndecidedError("whether a function vanishes near omega = 0")


def _ascending(parts: list[tuple[Powers, Expr]]) -> Iterator[tuple[Expr, list[_Coefficient]]]:
    """The first ``_MOST_TERMS`` exponents e_l + n in ascending order, each once, with all
    coefficients a_(l,n) that have it. ``parts``: pairs of l and e_l. UndecidedError where two
    differ, and by less than their keys show."""
    # A merge of the ascending sequences e_l, e_l + 1, e_l + 2, ...: each has one entry in the heap,
    # (key of the next exponent, index of the part, n).
    heap = [(_key(exponent), i, 0) for i, (_, exponent) in enumerate(parts)]
    heapify(heap)
    for _ in range(_MOST_TERMS):
        least, first, n = heap[0]
        exponent = parts[first][1] + n
        coefficients: list[_Coefficient] = []
        while True:
            key, i, n = heap[0]
            powers, start = parts[i]
            if not _is_equal(key, least, start + n, exponent):
                is_exact = isinstance(key, Fraction) and isinstance(least, Fraction)
                if not is_exact and float(key) - float(least) < _APART:
                    raise UndecidedError("which of two powers of omega that are close is lower")
                break
            coefficients.append((powers, n))
            heapreplace(heap, (key + 1, i, n + 1))
        yield exponent, coefficients


_Key: TypeAlias = Fraction | float


def _key(exponent: Expr) -> _Key:
    """A key by which exponents are ordered: exact for a rational one, a float for any other, which
    does not decide equality (``_is_equal``)."""
    if exponent.is_Rational:
        return Fraction(int(exponent.p), int(exponent.q))
    return float(exponent)


def _is_equal(key: _Key, other_key: _Key, exponent: Expr, other: Expr) -> bool:
    """Whether two exponents are equal, exact: by their keys where both are rational; floats of
    equal irrational numbers may differ."""
    if isinstance(key, Fraction) and isinstance(other_key, Fraction):
        return key == other_key
    is_near = abs(float(key) - float(other_key)) < _APART
    return is_near and _is_zero(exponent - other)


@lru_cache(maxsize=1024)
def _is_zero(difference: Expr) -> bool:
    """Whether a difference of exponents is 0, exact: the orders of a scene are rational in pi, so
    that it is 0 exactly where its numerator is in lowest terms (pi is transcendental)."""
    return bool(cancel(difference) == 0)


def _order(rise: Expr) -> int:
    """The lowest integer n >= 0 with n >= ``rise``."""
    if rise.is_Rational:
        return max(0, -int((-rise).p // (-rise).q))
    # An irrational number is no integer: 30 digits find the next one above it.
    return max(0, int(rise.evalf(30) // 1) + 1)


def _cancel(f: WaveSum, coefficients: list[_Coefficient]) -> bool:
    """Whether these coefficients a_(l,n) add up to 0: exact. UndecidedError where it is not known.

    Balls prove most sums to be other than 0. That a sum is 0 can only be proven exactly; where the
    exact test has no answer, as angles are no rational parts of a turn, finer balls may still show
    that the sum is not 0.
    """

    def by_balls(_: int) -> bool | None:
        """True: the sum is 0; False: it is not; None: not known at this precision."""
        total = sum(f.cofactor_series(arb(0), coefficients), arb(0))
        if is_clear(total):
            return False
        return True if total.is_zero() else None

    verdict = at_rising_precision(by_balls, _BITS, _BITS)
    if verdict is None:
        verdict = is_zero_number(_exact_sum(f, coefficients), [rate for rate, _ in f.rates])
    if verdict is None:
        verdict = at_rising_precision(by_balls, 2 * _BITS)
    if verdict is None:
        raise UndecidedError("whether a function vanishes near omega = 0")
    return verdict


def _exact_sum(f: WaveSum, coefficients: list[_Coefficient]) -> Polynomial:
    """A polynomial in pi, cosines and sines of half angles, in the ring of ``taylor_coefficients``,
    whose value is 0 exactly where these coefficients a_(l,n) add up to 0."""
    directions, cofactors = exact_directions(f, Integer(0)), f.cofactors()
    # At omega = 0 every delay angle is 0, a multiple of an eighth of a turn.
    assert directions is not None
    total: RationalFunction | None = None
    for powers, n in coefficients:
        series = taylor_coefficients(cofactors[powers], Integer(0), directions)
        coefficient = next(islice(series, n, None))
        total = coefficient if total is None else total + coefficient
    assert total is not None
    return total.numerator


# To the right of 0


def clear_of_zero(f: WaveSum, first: Ball) -> Ball:
    """A dyadic number r > 0 such that f has no zero for 0 < omega <= r; ``first`` is tried first,
    then smaller ones. UndecidedError where none of ``_MOST_STEPS`` is shown to be one."""
    start = leading_term(f)
    wanted = [(part.powers, part.order) for part in start.parts]
    with flint.ctx.workprec(_BITS):
        # The exponents e_l + n_l - e >= 0 of the formula at the top.
        exponents = (part.exponent + part.order for part in start.parts)
        rises = [expression_ball(exponent - start.exponent) for exponent in exponents]
        reach = first.mid()
        for step in range(_MOST_STEPS):
            total, log_reach = arb(0), reach.log()
            remainders = f.cofactor_series(arb(0).union(reach), wanted)
            for rise, remainder in zip(rises, remainders, strict=True):
                # omega^rise grows from 0 to reach^rise on the interval; with rise 0 it is 1.
                if not rise.is_zero():
                    remainder = remainder * arb(0).union((rise * log_reach).exp())
                total = total + remainder
            if is_clear(total):
                return reach
            reach = (reach / (LARGEST_RATIO if step < _FINE_STEPS else 16)).mid()
    raise UndecidedError("whether a function vanishes near omega = 0")


# Exact Taylor coefficients of sums without powers of omega


Direction: TypeAlias = tuple[int, int] | None
"""Cosine and sine of the half angle of a delay, up to a common factor > 0, which stands for nothing
but scale; None for a constant angle, whose cosine and sine stay variables."""
# Half angles of 0, 1, ... 7 eighths of a turn; (1, 1) leaves out sqrt(2)/2, so that all are
# integers.
_EIGHTHS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def exact_directions(f: WaveSum, frequency: Expr) -> list[Direction] | None:
    """The direction of each half angle at an exact frequency; None where one of a delay is at no
    multiple of an eighth of a turn, so that no exact value is known.

    A sum is homogeneous in cosine and sine of each half angle: a common factor of both scales the
    function and its derivatives, and does not move its zeros.
    """
    is_rational = frequency != 0 and frequency.is_Rational
    if is_rational and any(rate.is_Rational for rate, _ in f.rates):
        return None  # a rational angle other than 0 is no rational part of a turn, as pi is not
    directions: list[Direction] = []
    for rate, constant in f.rates:
        if constant:
            directions.append(None)
            continue
        # An eighth of a turn is pi/4, and the half angle is rate frequency/2.
        eighths = 2 * rate * frequency / pi
        if not eighths.is_Integer:
            return None
        directions.append(_EIGHTHS[int(eighths) % 8])
    return directions


def taylor_coefficients(
    f: WaveSum, frequency: Expr, directions: list[Direction]
) -> Iterator[RationalFunction]:
    """c f^(n)(x)/n! for n = 0, 1, 2, ... at an exact frequency x, for a sum without powers of
    omega; c is one number other than 0, the same for all n, that is not given.

    ``directions``: those of the half angles at x. Each is a polynomial in cosines and sines of
    constant half angles over a polynomial in pi. Its ring has the variables omega, pi, then cosine
    and sine of each half angle in turn: 2 + 2 i and 3 + 2 i are the places of those of angle i.
    """
    names = [Symbol(f"{kind}{i}") for i in range(len(f.rates)) for kind in ("cos", "sin")]
    ring = PolynomialRing(omega, functions=names)
    variables = ring.context.gens()
    rates = [ring.convert(rate / 2) for rate, _ in f.rates]
    # Derivatives are multiplied by the common denominator of all rates, so that they stay
    # polynomials; ``scale`` is n! times the n-th power of it.
    common = reduce(mul, (rate.denominator for rate in rates), ring.constant(1))
    derivative, scale, n = _as_polynomial(f, ring), ring.one, 0
    while True:
        yield _value_at(ring, derivative, frequency, directions) / scale
        change = common * derivative.derivative(0)
        for i, (rate, (_, constant)) in enumerate(zip(rates, f.rates, strict=True)):
            if constant:
                continue
            # The chain rule with d sin = cos da and d cos = -sin da.
            cosine, sine = 2 + 2 * i, 3 + 2 * i
            by_angle = variables[cosine] * derivative.derivative(sine)
            by_angle -= variables[sine] * derivative.derivative(cosine)
            change += rate.numerator * (common / rate.denominator) * by_angle
        derivative, n = change, n + 1
        scale = scale * ring.function(common * n)


def _as_polynomial(f: WaveSum, ring: PolynomialRing) -> Polynomial:
    """A sum without powers of omega as a polynomial of the ring of ``taylor_coefficients``."""
    terms: dict[tuple[int, ...], int] = {}
    for term in f.terms:
        waves: list[int] = []
        for k, degree in zip(term.sines, f.degrees, strict=True):
            waves += [degree - k, k]
        for of_omega, coefficient in enumerate(term.coefficients):
            for of_pi, number in enumerate(coefficient):
                if number:
                    terms[(of_omega, of_pi, *waves)] = number
    return ring.context.from_dict(terms)


def _value_at(
    ring: PolynomialRing, polynomial: Polynomial, frequency: Expr, directions: list[Direction]
) -> RationalFunction:
    """The value of a polynomial of the ring of ``taylor_coefficients`` at an exact frequency, with
    these directions in place of cosines and sines."""
    x, total = ring.convert(frequency), ring.zero
    for (of_omega, of_pi, *waves), number in monomials(polynomial):
        if of_omega and frequency == 0:
            continue
        value, exponents = number, [0, int(of_pi)]
        for direction, cosine, sine in zip(directions, waves[::2], waves[1::2], strict=True):
            if direction is None:
                exponents += [int(cosine), int(sine)]
            else:
                exponents += [0, 0]
                value = value * direction[0] ** int(cosine) * direction[1] ** int(sine)
        term = ring.function(ring.context.from_dict({tuple(exponents): value}))
        total = total + term * x ** int(of_omega)
    return total


# The order of the zero at 0 of sums without powers of omega


def order_at_0(f: WaveSum) -> int | None:
    """The order of the zero at omega = 0 of a sum without powers of omega: exact.

    None: not known, as an angle is constant or has an irrational rate, or as all orders below the
    largest of ``_LENGTHS`` vanish.

    Divided by cosines of half angles, which are 1 at omega = 0, the sum becomes sum of p(omega)
    prod tan(a_i/2)^k_i, which has a zero of the same order. Its Taylor coefficients are polynomials
    in pi over the rational numbers; as pi is transcendental (Lindemann, 1882), one is 0 only if it
    is so before every power of pi.
    """
    if not all(rate.is_Rational and not constant for rate, constant in f.rates):
        return None
    for length in _LENGTHS:
        tangents = [
            _tangent_powers(fmpq(int(rate.p), 2 * int(rate.q)), degree, length)
            for (rate, _), degree in zip(f.rates, f.degrees, strict=True)
        ]
        series_by_pi: dict[int, fmpq_poly] = {}
        for term in f.terms:
            waves = _ONE
            for powers, k in zip(tangents, term.sines, strict=True):
                waves = waves.mul_low(powers[k], length)
            for i in range(max(map(len, term.coefficients))):
                p = fmpq_poly([c[i] if i < len(c) else 0 for c in term.coefficients])
                series_by_pi[i] = series_by_pi.get(i, _ZERO) + p.mul_low(waves, length)
        orders: list[int] = []
        for series in series_by_pi.values():
            orders += [n for n, c in enumerate(series.coeffs()) if c]
        if orders:
            return min(orders)
    return None


def _tangent_powers(rate: fmpq, highest: int, length: int) -> list[fmpq_poly]:
    """tan(rate omega)^k for k = 0, 1, ... ``highest``, as Taylor polynomials at 0 with that many
    coefficients."""
    tangent = fmpq_poly([c * rate**n for n, c in enumerate(_tangent(length))])

    def times(x: fmpq_poly, y: fmpq_poly) -> fmpq_poly:
        return x.mul_low(y, length)

    return list(accumulate(repeat(tangent, highest), times, initial=_ONE))


@lru_cache(maxsize=8)
def _tangent(length: int) -> list[fmpq]:
    """The Taylor coefficients of the tangent at 0, from t' = 1 + t^2."""
    row = [fmpq(0)]
    for n in range(1, length):
        # The coefficient of order n - 1 of t', which is n times that of order n of t.
        slope = fmpq(1 if n == 1 else 0)
        for i in range(n):
            slope += row[i] * row[n - 1 - i]
        row.append(slope / n)
    return row
