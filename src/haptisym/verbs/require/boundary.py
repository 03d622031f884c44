"""The polynomials in one parameter or two whose zeros bound a requirement, and their real roots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from math import prod
from typing import TypeAlias

from flint import fmpq
from sympy import Expr, Integer, pi

from haptisym.judge.criteria import Criterion
from haptisym.kernel.axis import Axis
from haptisym.kernel.eliminants import discriminant, resultant
from haptisym.kernel.errors import SceneError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.polynomials import PolynomialFactor
from haptisym.kernel.reals import ExactNumber, Negative, RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.verbs.require.feasible import Kind

Reason: TypeAlias = tuple[Criterion, Kind] | None
"""Which condition is critical, and how; None: the condition is nowhere defined."""


def critical(
    criterion: Criterion, pieces: Sequence[RealFunction], band: tuple[Expr, Expr]
) -> Iterator[tuple[Reason, Polynomial]]:
    """The polynomials in pi and the parameter whose roots are critical for a condition on a band, and why each is.

    ``pieces`` : the functions of the condition, which must not all be positive.
    """
    ring = pieces[0].axis
    factors: list[Polynomial] = []
    for piece in pieces:
        for factor, _ in irreducible(piece.function.denominator):
            if not factor.degrees()[0]:
                yield None, factor
        own = [f for f, n in irreducible(piece.function.numerator) if n % 2 or not f.degrees()[0]]
        factors += [f for f in own if f not in factors]
    for f in factors:
        for kind, end in zip((Kind.START, Kind.EDGE), band, strict=True):
            yield (criterion, kind), substituted(f, 0, ring.convert(end))
        if f.degrees()[0] > (2 if is_even(f) else 1):
            yield (criterion, Kind.TOUCH), discriminant(in_square(f), 0)
    for f, g in combinations([f for f in factors if f.degrees()[0] and f != ring.variable], 2):
        if is_even(f) and is_even(g):
            f, g = in_square(f), in_square(g)
        yield (criterion, Kind.TOUCH), resultant(f, g, 0)


def real_roots(factor: Polynomial, index: int, *, negative: bool) -> Iterator[RealNumber]:
    """The positive roots, and negative ones if wanted, of an irreducible polynomial in pi and the parameter of that index."""
    own = [int(n) for n in factor.degrees()]
    if not own[index]:
        return
    rows = [[0] * (own[1] + 1) for _ in range(own[index] + 1)]
    for exponents, value in monomials(factor):
        rows[int(exponents[index])][int(exponents[1])] = int(value.p)
    if len(rows) == 2:
        value = -_in_pi(rows[0]) / _in_pi(rows[1])
        yield ExactNumber(value.cancel() if value.has(pi) else value)
        return
    yield from _positive_roots(rows)
    if negative:
        mirrored = [[-n for n in row] if i % 2 else row for i, row in enumerate(rows)]
        yield from map(Negative, _positive_roots(mirrored))


def irreducible(polynomial: Polynomial) -> list[tuple[Polynomial, int]]:
    """Irreducible factors, in omega^2 where the whole is even in omega."""
    if not is_even(polynomial):
        return [(f, int(n)) for f, n in polynomial.factor()[1]]
    steps = [2, *[1] * (len(polynomial.degrees()) - 1)]
    return [(f.inflate(steps), int(n)) for f, n in polynomial.deflate(steps).factor()[1]]


def is_even(polynomial: Polynomial) -> bool:
    """Whether it is even in its first variable."""
    return not any(int(e[0]) % 2 for e in polynomial.monoms())


def in_square(polynomial: Polynomial) -> Polynomial:
    """An even polynomial as one in omega^2."""
    return polynomial.deflate([2, *[1] * (len(polynomial.degrees()) - 1)]) if is_even(polynomial) else polynomial


def substituted(polynomial: Polynomial, index: int, value: RationalFunction) -> Polynomial:
    """A polynomial with a number for one of its variables, times a positive number."""
    if value.denominator.is_constant() and value.numerator.is_constant():
        number = _constant(value.numerator) / _constant(value.denominator)
        return polynomial.subs({f"x{index}": number})
    degree = int(polynomial.degrees()[index])
    degree += degree % 2  # an even power of the denominator keeps the sign
    context = polynomial.context()
    powers: dict[int, dict[tuple[int, ...], fmpq]] = {}
    for exponents, coefficient in monomials(polynomial):
        own = [int(n) for n in exponents]
        power, own[index] = own[index], 0
        powers.setdefault(power, {})[tuple(own)] = coefficient
    return sum(
        (
            context.from_dict(terms) * value.numerator**n * value.denominator ** (degree - n)
            for n, terms in powers.items()
        ),
        context.constant(0),
    )


def _constant(polynomial: Polynomial) -> fmpq:
    return next(iter(polynomial.to_dict().values()), fmpq(0))


def _in_pi(row: Sequence[int]) -> Expr:
    return sum((Integer(n) * pi**i for i, n in enumerate(row)), Integer(0))


def _positive_roots(rows: Sequence[Sequence[int]]) -> list[RealNumber]:
    return [*PolynomialFactor(tuple(_trimmed(row) for row in rows), step=1).positive_roots()]


def _trimmed(row: Sequence[int]) -> tuple[int, ...]:
    """A row without the zeros of high powers of pi, so that a rational one is seen to be so."""
    last = max((i for i, n in enumerate(row) if n), default=0)
    return tuple(row[: last + 1])


def of_factor(ring: PolynomialRing, index: int, factor: PolynomialFactor, *, mirrored: bool) -> Polynomial:
    """A factor in the parameter as a polynomial of the ring."""
    terms = {}
    for i, row in enumerate(factor.coefficients):
        for j, n in enumerate(row):
            exponents = [0] * len(ring.meanings)
            exponents[index], exponents[1] = i, j
            terms[tuple(exponents)] = fmpq(-n if mirrored and i % 2 else n)
    return ring.context.from_dict(terms)


def edge_polynomial(pieces: Sequence[RealFunction], end: Expr) -> Expr:
    """The polynomial in the parameters that vanishes where a rational condition binds at a frequency."""
    axis = _without_functions(pieces)
    tops = [substituted(piece.function.numerator, 0, axis.convert(end)) for piece in pieces]
    return axis.factored_expression(prod(tops[1:], start=tops[0]))


def touch_polynomial(pieces: Sequence[RealFunction]) -> Expr:
    """What vanishes where a rational condition binds inside the band: discriminants in omega^2, and of several resultants."""
    axis = _without_functions(pieces)
    own = [[f for f, n in irreducible(piece.function.numerator) if n % 2 and f.degrees()[0]] for piece in pieces]
    found = axis.constant(1)
    for f in (f for factors in own for f in factors):
        found *= discriminant(in_square(f), 0) if f.degrees()[0] > (2 if is_even(f) else 1) else 1
    for f, g in (pair for one, other in combinations(own, 2) for pair in product(one, other) if pair[0] != pair[1]):
        found *= resultant(in_square(f), in_square(g), 0) if is_even(f) and is_even(g) else resultant(f, g, 0)
    return axis.factored_expression(found)


def _without_functions(pieces: Sequence[RealFunction]) -> Axis:
    if pieces[0].axis.functions:
        raise SceneError("with delays or powers of s the boundary is no polynomial's zero")
    return pieces[0].axis
