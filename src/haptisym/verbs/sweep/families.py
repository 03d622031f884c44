"""Families of polynomials: coefficients that are polynomials in parameters, for many values of the parameters at once.

From the exact polynomials of a ring to batches of floats with bounds (``batch``). Values of parameters are taken as exactly
the binary numbers that the floats are; the other numbers of a formula (rational, or rational in pi) are gathered into one
constant for each monomial and rounded once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import log2

import flint
import numpy as np
from flint import arb
from sympy import Expr, Symbol

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import bounds, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.verbs.sweep.batch import Array, Batch

BITS = 256
_MOST_EXPONENT = 1000  # of two: products within it neither underflow nor overflow, with room for sums


@dataclass(frozen=True)
class Monomial:
    """A monomial of a coefficient: the power of the variable it belongs to, a constant, and the exponents of the parameters.

    ``rest``: what the constant's nearest double leaves of it, for wider floats.
    """

    power: int
    constant: float
    rest: float
    exponents: tuple[int, ...]


@dataclass(frozen=True)
class Family:
    """A polynomial in one variable whose coefficients are polynomials in parameters."""

    terms: tuple[Monomial, ...]

    @property
    def degree(self) -> int:
        """The highest power of any of its terms."""
        return max(term.power for term in self.terms)

    @property
    def reach(self) -> tuple[int, float]:
        """The highest total degree in the parameters, and the largest exponent of two of a constant."""
        return max(sum(t.exponents) for t in self.terms), max(abs(log2(abs(t.constant))) for t in self.terms)

    def at(self, powers: Powers) -> Batch:
        """The polynomial at each set of parameters."""
        shape = (self.degree + 1, powers.sets)
        values, sizes = np.zeros(shape, powers.dtype), np.zeros(shape, powers.dtype)
        for term in self.terms:
            monomial = powers.monomial(term.exponents)
            constant = powers.dtype.type(term.constant) + powers.dtype.type(term.rest)
            values[term.power] += monomial * constant
            sizes[term.power] += np.abs(monomial * constant)
        # a constant's rounding and its product; the products of a monomial; the sum
        return Batch(values, sizes, 2 + self.reach[0] + len(self.terms))


class Powers:
    """Monomials of the parameters' values, each computed once. ``values``: parameters x sets."""

    def __init__(self, values: Array) -> None:
        self.values, self.dtype, self.sets = values, values.dtype, values.shape[1]
        self._known: dict[tuple[int, ...], Array] = {}

    def monomial(self, exponents: tuple[int, ...]) -> Array:
        """The product of the parameters, each to its power; one rounding less than its degree."""
        if exponents not in self._known:
            self._known[exponents] = self._monomial(exponents)
        return self._known[exponents]

    def _monomial(self, exponents: tuple[int, ...]) -> Array:
        last = next((i for i, n in reversed([*enumerate(exponents)]) if n), None)
        if last is None:
            return np.ones(self.sets, self.dtype)
        lower = tuple(n - (i == last) for i, n in enumerate(exponents))
        column: Array = self.values[last]
        return self.monomial(lower) * column if any(lower) else column


def family(
    ring: PolynomialRing, polynomial: Polynomial, parameters: Sequence[Symbol], scale: Expr, step: int, factor: Expr
) -> Family:
    """``factor`` times a polynomial of a ring, as one in (omega/scale)^step, the parameters being the only symbols in it.

    ``factor`` and ``scale``: numbers.
    """
    columns = {x: i for i, x in enumerate(ring.meanings)}
    places = [columns.get(x) for x in parameters]
    with flint.ctx.workprec(BITS):
        numbers = [expression_ball(x) for x in ring.meanings[1:2]]
        unit, scaled = expression_ball(factor), expression_ball(scale)
        found: dict[tuple[int, tuple[int, ...]], arb] = {}
        for given, coefficient in polynomial.to_dict().items():
            own = [int(n) for n in given]
            assert not own[0] % step
            key = own[0] // step, tuple(own[i] if i is not None else 0 for i in places)
            term = arb(coefficient) * unit * numbers[0] ** own[1] * scaled ** own[0]
            found[key] = found.get(key, arb(0)) + term
        return Family(tuple(monomial(*key, ball) for key, ball in sorted(found.items())))


def monomial(power: int, exponents: tuple[int, ...], ball: arb) -> Monomial:
    """One with a constant in that ball; UndecidedError where too few of its bits are known."""
    if not ball.is_exact() and ball.rel_accuracy_bits() < 128:
        raise UndecidedError(f"a coefficient near {float(ball.mid())} has fewer than 128 correct bits")
    middle, _ = bounds(ball.mid())
    constant = float(middle)
    return Monomial(power, constant, float(middle - type(middle)(constant)), exponents)


def within_reach(values: Array, products: Iterable[Sequence[Family]]) -> Array:
    """The sets for which no coefficient of these products of families can underflow or overflow.

    With |log2| of every parameter that is not zero at most e, any product of terms lies within 2^+-(degree e + constants).
    """
    limit = min((_limit([f.reach for f in families]) for families in products), default=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        exponents = np.abs(np.log2(np.abs(values)))
    within: Array = ((values == 0) | (exponents <= limit)).all(axis=0)
    return within


def _limit(reaches: Sequence[tuple[int, float]]) -> float:
    degree, constants = sum(d for d, _ in reaches), sum(c for _, c in reaches)
    return (_MOST_EXPONENT - constants) / max(degree, 1)
