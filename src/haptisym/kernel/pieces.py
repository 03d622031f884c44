"""Polynomials on the axis as products of irreducible ones, with the factors and the products that are known beforehand."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from operator import ge
from typing import TypeAlias

from haptisym.kernel.axis import Axis
from haptisym.kernel.rings import Polynomial

Pieces: TypeAlias = list[tuple[Polynomial, int]]
"""Polynomials, and how often each is a factor."""


def pieces(
    parts: Sequence[Polynomial], axis: Axis, known: Sequence[Polynomial], *, longest: float, in_square: bool
) -> tuple[int, Pieces]:
    """The sign of a number and the irreducible factors of a product of polynomials, but for circles 1 + tan^2.

    ``known`` : irreducible polynomials that are tried first on parts of at most ``longest`` terms.
    """
    sign, found = 1, Pieces()
    for part in parts:
        apart, rest = axis.without_circles(part)[0], Pieces()
        if len(apart) <= longest:
            rest, apart = _divided(apart, known)
        number, factors = axis.factors(apart, in_square=in_square)
        sign *= 1 if number.p > 0 else -1
        found += [*rest, *factors]
    return sign, found


def sign_between(polynomial: Polynomial, parts: Sequence[Polynomial]) -> int:
    """The sign of the number by which a polynomial is the product of others."""
    return 1 if polynomial.leading_coefficient() * prod(x.leading_coefficient() for x in parts) > 0 else -1


def _divided(polynomial: Polynomial, known: Sequence[Polynomial]) -> tuple[Pieces, Polynomial]:
    """The known factors of a polynomial, how often each is in it, and what is left."""
    found, degrees = Pieces(), polynomial.degrees()
    for factor in known:
        if len(factor) > 1 and all(map(ge, degrees, factor.degrees())):
            often = 0
            quotient, rest = divmod(polynomial, factor)
            while rest.is_zero():
                polynomial, often = quotient, often + 1
                quotient, rest = divmod(polynomial, factor)
            if often:
                found.append((factor, often))
    return found, polynomial
