"""Real functions of omega taken apart into irreducible factors, whose zeros then are the zeros and
poles of the functions.

A function is a quotient of polynomials over Q in omega, pi, half-angle tangents and powers of
omega, and these are factored over Q. Denominators of one chart have most factors in common, so that
factors known from before are tried first. To the ring all of its variables are independent of each
other. The constant angles and the powers omega^alpha that s^alpha brings are not: with them a
factor may vanish everywhere, which is decided here, too (``_factored``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import compress
from math import inf, prod
from operator import ge, index
from typing import TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer

from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import tick
from haptisym.kernel.delayterms import WaveTerm
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError
from haptisym.kernel.factors import AnalyticFactor, PolynomialFactor, polynomial_factors
from haptisym.kernel.rings import Polynomial, monomials
from haptisym.kernel.zeros import Factor, is_clear
from haptisym.kernel.zerotest import vanishes

Pieces: TypeAlias = list[tuple[Polynomial, int]]
"""Polynomials, and how often each is a factor."""


def pieces(
    parts: Sequence[Polynomial],
    axis: Axis,
    known: Sequence[Polynomial],
    *,
    longest: float,
    in_square: bool,
) -> tuple[int, Pieces]:
    """The sign of the constant and the irreducible factors of a product of polynomials, without
    factors 1 + tan^2, which are positive.

    ``known`` : irreducible polynomials that are tried first on parts of at most ``longest`` terms.
    """
    sign, factors_found = 1, Pieces()
    for part in parts:
        apart, rest = axis.without_circles(part)[0], Pieces()
        if len(apart) <= longest:
            rest, apart = _divided(apart, known)
        number, factors = axis.factors(apart, in_square=in_square)
        sign *= 1 if number.p > 0 else -1
        factors_found += [*rest, *factors]
    return sign, factors_found


def sign_between(polynomial: Polynomial, parts: Sequence[Polynomial]) -> int:
    """The sign of the constant c where a polynomial is c times the product of others."""
    leading = polynomial.leading_coefficient() * prod(x.leading_coefficient() for x in parts)
    return 1 if leading > 0 else -1


def _divided(polynomial: Polynomial, known: Sequence[Polynomial]) -> tuple[Pieces, Polynomial]:
    """The known factors that divide a polynomial, with their multiplicities, and the quotient."""
    divisors, degrees = Pieces(), polynomial.degrees()
    for factor in known:
        if len(factor) > 1 and all(map(ge, degrees, factor.degrees())):
            often = 0
            quotient, rest = divmod(polynomial, factor)
            while rest.is_zero():
                polynomial, often = quotient, often + 1
                quotient, rest = divmod(polynomial, factor)
            if often:
                divisors.append((factor, often))
    return divisors, polynomial


# Known factors are tried on numerators of at most so many terms; on denominators always.
_SHORT = 16

Factored: TypeAlias = tuple[int, Expr, list[tuple[Factor, int]]]


@dataclass(frozen=True)
class Product:
    """A function as sign and powers: ``sign * omega^power * product of factor^exponent``."""

    sign: int
    power: Expr
    exponents: Mapping[Factor, int]


@dataclass(frozen=True, eq=False)
class Known:
    """The polynomials and factors that were found for one chart, to be tried again: denominators
    are mostly equal, or products of the same factors."""

    polynomials: list[tuple[Polynomial, Factored]] = field(default_factory=list)
    factors: list[tuple[Polynomial, Factor]] = field(default_factory=list)


def factored_function(function: RealFunction, known: Known, *, in_square: bool = True) -> Product:
    """The function taken apart; ``known`` gathers what was on the way.

    ``in_square`` : whether even polynomials may be taken apart in omega^2. Of functions on one
    chart that must be the same, and only where all are even or odd: else one frequency might be the
    zero of two different factors.
    """
    top, bottom = function.function.numerator, function.function.denominator
    if top.is_zero():
        return Product(0, Integer(0), {})
    sign, power, exponents = 1, Integer(0), Counter[Factor]()
    for polynomial, parts, direction in ((top, function.above, 1), (bottom, function.below, -1)):
        factored = next((taken for other, taken in known.polynomials if other == polynomial), None)
        if factored is None:
            factored = _factored(
                polynomial,
                parts or (polynomial,),
                function.axis,
                known,
                in_square=in_square,
                is_below=direction < 0,
            )
            known.polynomials.append((polynomial, factored))
        own_sign, own_power, factors = factored
        # Zero at every frequency, although it is no zero polynomial.
        if own_sign == 0 and direction < 0:
            raise SceneError("division by zero")
        sign *= own_sign
        if own_power:
            power += direction * own_power
        for factor, exponent in factors:
            exponents[factor] += direction * exponent
    return Product(sign, power, {factor: n for factor, n in exponents.items() if n} if sign else {})


def is_even_or_odd(function: RealFunction) -> bool:
    """Whether numerator and denominator each hold only even, or only odd powers of omega."""
    f = function.function
    return all(int(p.deflation_index()[0][0]) % 2 == 0 for p in (f.numerator, f.denominator))


def _factored(
    polynomial: Polynomial,
    parts: Sequence[Polynomial],
    axis: Axis,
    known: Known,
    *,
    in_square: bool,
    is_below: bool,
) -> Factored:
    """Sign, power of omega and irreducible factors; half-angle tangents made homogeneous in cosine
    and sine.

    ``parts`` : polynomials of which it is the product, up to a number; it alone if none are known.
    The sign is 0 where a factor is zero at every frequency, as cos(2 pi/4) is, or omega^(1/2)
    omega^(1/2) - omega.
    """
    plain = axis.univariate(polynomial)
    if plain is not None and not axis.functions:
        own_sign, lowest, simple = polynomial_factors(plain, in_square=in_square)
        return own_sign, Integer(lowest), [*simple]
    # Where sines meet odd powers of omega not all functions are even.
    in_square = in_square and not axis.functions
    tried = [factor for factor, _ in known.factors] if axis.functions else []
    sign, irreducible = pieces(
        parts, axis, tried, longest=inf if is_below else _SHORT, in_square=in_square
    )
    sign *= sign_between(polynomial, parts)
    power, kept_factors = Integer(0), list[tuple[Factor, int]]()
    for factor, exponent in irreducible:
        exponents = _power_of_omega(factor, axis)
        if exponents is not None:
            power += exponent * exponents
            continue
        made = next((made for other, made in known.factors if other == factor), None)
        if made is None:
            is_analytic = any(factor.degrees()[axis.size :])
            made = (_analytic_factor if is_analytic else _polynomial_factor)(factor, axis)
            if _seems_to_vanish(made, axis) and vanishes(factor, axis):
                return 0, Integer(0), []
            known.factors.append((factor, made))
        # A number, of pi and constant angles: it has a sign, and no zero.
        if not _changes(factor, axis):
            sign *= made.sign_at(lambda _: arb(1)) ** exponent
        else:
            kept_factors.append((made, exponent))
    # Factors are homogeneous in cosine and sine: a polynomial of degree n in tan(a/2) is such a
    # form over cos(a/2)^n.
    cosines = [(_cosine(axis, i), -n) for i, n in enumerate(_turning(polynomial, axis)) if n]
    return sign, power, [*kept_factors, *cosines]


def _seems_to_vanish(factor: Factor, axis: Axis) -> bool:
    """Whether a factor may be zero at every frequency, as rational powers of omega and constant
    angles may cancel: a quick test before ``vanishes``, which is dear. True proves nothing."""
    if not axis.orders or not all(x.is_Rational for x in axis.orders):
        return False
    # Any frequency would do for a sign that is not 0.
    with flint.ctx.workprec(128):
        shown = isinstance(factor, AnalyticFactor) and factor.is_shown_nonzero
        return not shown and not is_clear(factor.value(arb(1.25)))


def _power_of_omega(factor: Polynomial, axis: Axis) -> Expr | None:
    """The exponent of a factor that is omega or omega^alpha itself; None for any other factor."""
    if len(factor) > 1:
        return None
    if factor == axis.variable:
        return Integer(1)
    for order, generator in zip(
        axis.orders, axis.context.gens()[axis.size + len(axis.angles) :], strict=True
    ):
        if factor == generator:
            return order
    return None


def _changes(factor: Polynomial, axis: Axis) -> bool:
    """Whether a factor changes with omega: by omega itself, by an angle of a delay or by a power
    omega^alpha."""
    degrees = [int(n) for n in factor.degrees()]
    return (
        bool(degrees[0])
        or any(_turning(factor, axis))
        or any(degrees[axis.size + len(axis.angles) :])
    )


def _turning(polynomial: Polynomial, axis: Axis) -> list[int]:
    """The degree of a polynomial in the half-angle tangent of each angle; 0 for constant angles."""
    degrees = [int(n) for n in polynomial.degrees()[axis.size :]]
    return [0 if angle.constant else n for angle, n in zip(axis.angles, degrees, strict=False)]


def _polynomial_factor(factor: Polynomial, _: Axis) -> PolynomialFactor:
    """A polynomial in omega and pi as a factor, in omega^2 where it is even."""
    rows = _rows([(index(e[0]), index(e[1]), index(c.p)) for e, c in monomials(factor)])
    even = not any(any(row) for row in rows[1::2])
    return PolynomialFactor(rows[::2] if even else rows, 2 if even else 1)


def _rows(terms: Sequence[tuple[int, int, int]]) -> tuple[tuple[int, ...], ...]:
    """Coefficients of ascending powers of omega, each as the coefficients of ascending powers of
    pi, from terms (power of omega, power of pi, coefficient)."""
    # Mostly there is no pi, and one term for each power of omega: that is done without lists.
    rows: list[tuple[int, ...]] = [_NONE] * (max(terms)[0] + 1)
    for power, of_pi, value in terms:
        if of_pi or rows[power] is not _NONE:
            row = rows[power] + (0,) * (of_pi + 1 - len(rows[power]))
            rows[power] = (*row[:of_pi], value, *row[of_pi + 1 :])
        else:
            rows[power] = (value,)
    return tuple(rows)


_NONE = (0,)


def _analytic_factor(factor: Polynomial, axis: Axis) -> AnalyticFactor:
    """A polynomial in omega, pi, half-angle tangents and powers of omega as a factor, homogeneous
    in cosine and sine of each half angle."""
    angles, first = len(axis.angles), axis.size
    groups: dict[tuple[int, ...], list[tuple[int, int, int]]] = {}
    tick()
    # FLINT's irreducible factors have whole coefficients: ``value.q`` is 1.
    for exponents, value in monomials(factor):
        term = index(exponents[0]), index(exponents[1]), index(value.p)
        groups.setdefault(exponents[first:], []).append(term)
    # Sorted, so that equal factors are equal values, whatever way they were found.
    sums = sorted([(tuple(map(index, waves)), _rows(group)) for waves, group in groups.items()])
    terms = tuple([WaveTerm(waves[:angles], waves[angles:], rows) for waves, rows in sums])
    degrees = tuple(map(int, factor.degrees()[first : first + angles]))
    return _made(terms, degrees, axis)


def _cosine(axis: Axis, index: int) -> AnalyticFactor:
    """The cosine of a half angle, which homogeneous forms of different degrees leave behind."""
    degrees = tuple(int(i == index) for i in range(len(axis.angles)))
    one = WaveTerm((0,) * len(axis.angles), (0,) * len(axis.orders), ((1,),))
    return _made((one,), degrees, axis)


def _made(terms: tuple[WaveTerm, ...], degrees: tuple[int, ...], axis: Axis) -> AnalyticFactor:
    """The factor with these terms, without the angles in which its degree is 0."""
    angles = list(compress(axis.angles, degrees))
    shorter = terms
    if len(angles) < len(degrees):
        shorter = tuple(
            [WaveTerm(tuple(compress(x.sines, degrees)), x.powers, x.coefficients) for x in terms]
        )
    rates = tuple([(angle.rate, angle.constant) for angle in angles])
    return AnalyticFactor(shorter, rates, tuple(compress(degrees, degrees)), axis.orders)
