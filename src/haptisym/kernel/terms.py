"""Polynomials of dynamics by their powers of s, and how they begin at s = 0."""

from __future__ import annotations

from collections.abc import Mapping
from heapq import merge
from itertools import groupby
from typing import TypeAlias

from sympy import Expr, Integer, Rational, factorial, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import sign_of_number

_MOST_TERMS = 64  # of the expansion at s = 0 that are tried

Terms: TypeAlias = dict[Rational, dict[tuple[int, ...], Expr]]
"""By the power of s, and by how often each unit delay is in them."""


def terms_of(polynomial: Polynomial, ring: Ring) -> Terms:
    """A polynomial by its powers of s, each with a number for every product of unit delays; none of them 0."""
    found: Terms = {}
    lags = len(ring.lags)
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        turns, powers = tuple(own[ring.size : ring.size + lags]), own[ring.size + lags :]
        power = sum((n * order for n, order in zip(powers, ring.orders, strict=False)), Integer(own[0]))
        group = found.setdefault(power, {})
        number = Rational(int(value.p), int(value.q))
        group[turns] = group.get(turns, Integer(0)) + (number * pi ** own[1] if own[1] else number)
    exact = {p: {turns: c for turns, c in group.items() if sign_of_number(c)} for p, group in found.items()}
    return {p: group for p, group in exact.items() if group}


def size(number: Expr) -> Expr:
    """The absolute value of an exact number."""
    return number * sign_of_number(number)


def order_at_0(polynomial: Polynomial, ring: Ring) -> Rational:
    """The order of a zero at s = 0, where 1 - exp(-s tau) has one too, and s^alpha one of order alpha."""
    if not ring.functions:  # powers of s with numbers before them, none of which is 0
        return Integer(min(int(exponents[0]) for exponents in polynomial.monoms()))
    return beginning_at_0(terms_of(polynomial, ring), ring)[0]


def at_least(order: Rational) -> int:
    """How often a zero of that order counts: a fractional one, of s^alpha, as the next whole number."""
    return -int(-order.p // order.q)


def beginning_at_0(terms: Terms, ring: Ring) -> tuple[Rational, int]:
    """Exponent and sign of the first term of the expansion at s = 0."""
    rising = merge(*(map(p.__add__, map(Integer, range(_MOST_TERMS))) for p in terms))
    for exponent, _ in groupby(rising):
        meeting = ((group, exponent - p) for p, group in terms.items() if exponent >= p)
        total = sum((_coefficient(group, int(k), ring) for group, k in meeting if k.is_Integer), Integer(0))
        if sign := sign_of_number(total):
            return exponent, sign
    raise UndecidedError("the order of a characteristic function at s = 0")


def _coefficient(group: Mapping[tuple[int, ...], Expr], k: int, ring: Ring) -> Expr:
    """Of s^k in the sum of c exp(-s lag)."""
    if not k:
        return sum(group.values(), Integer(0))
    lags = {turns: sum((n * x for n, x in zip(turns, ring.lags, strict=True)), Integer(0)) for turns in group}
    return sum((c * (-lags[turns]) ** k for turns, c in group.items()), Integer(0)).expand() / factorial(k)
