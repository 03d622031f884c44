"""Sums of monomials with real exponents, drawn at random, and their values term by term."""

from __future__ import annotations

from fractions import Fraction
from random import Random
from typing import Any

from flint import arb, fmpq
from plainshapes import exact

from haptisym.verbs.require.knownsums import ball

Sum = dict[tuple[Fraction, Fraction], Any]
POINTS = [(Fraction(1, 2) ** 6, Fraction(3)), (Fraction(3) ** 6, Fraction(2, 5)), (Fraction(2, 3) ** 6, Fraction(7, 2))]


def drawn(pick: Random, below: int = 6, under: int = 1, count: int = 7) -> Sum:
    """Exponents of X over a number, of Y over another."""
    found: Sum = {}
    for _ in range(count):
        place = (
            Fraction(pick.randint(0, 14), pick.choice([1, below])),
            Fraction(pick.randint(0, 5), pick.choice([1, under])),
        )
        found[place] = fmpq(pick.choice([-5, -3, -1, 2, 4, 7]), pick.choice([1, 3]))
    return found


def value(terms: Any, x: Any, y: Any) -> Any:
    """Term by term, at balls."""
    total = arb(0)
    for (a, b), c in terms.items():
        total += ball(c) * x ** exact(a) * y ** exact(b)
    return total


def alike(one: Any, other: Any) -> bool:
    return bool(one.overlaps(other)) and bool(abs(one - other).upper() <= 1e-25 * (1 + abs(one).upper()))
