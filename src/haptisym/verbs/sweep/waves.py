"""Families of functions made of powers of omega, sines and cosines, for many values of the parameters at once.

On x = omega/(high end of the band), 0 <= x <= 1, each is a polynomial in x, in C = cos(k x) and S = sin(k x)/(k x) of some
half angles k x (k = rate of the angle times high end/2) and in z = x^alpha, whose coefficients are a ``Family`` in the
parameters. All of these lie between -1 and 1, so that sizes (``batch``) are had with 1 for each wave, and grow with x.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import flint
from flint import arb
from sympy import Expr, Symbol

from haptisym.kernel.reals import expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.verbs.sweep.families import BITS, Family, Monomial, monomial

Exponents: TypeAlias = tuple[int, ...]


@dataclass(frozen=True)
class Variables:
    """``rates``: k of each half angle, a monomial in the parameters. ``orders``: alpha of each power of x."""

    rates: tuple[Monomial, ...]
    orders: tuple[float, ...]

    @property
    def waves(self) -> int:
        """How many variables there are beside x: C and S of each angle, and the powers."""
        return 2 * len(self.rates) + len(self.orders)


@dataclass(frozen=True)
class WaveFamily(Family):
    """``terms``: coefficients of the monomials listed in ``rows``, by their place there.

    ``rows``: exponents of x, then of C and S of each angle, then of the powers.
    """

    variables: Variables
    rows: tuple[Exponents, ...]

    @property
    def degree(self) -> int:
        """The last row."""
        return len(self.rows) - 1

    @cached_property
    def groups(self) -> dict[Exponents, list[tuple[int, int]]]:
        """For each product of waves the powers of x that stand with it, descending, and their rows."""
        found: dict[Exponents, list[tuple[int, int]]] = {}
        for row in sorted(range(len(self.rows)), key=lambda i: -self.rows[i][0]):
            power, *waves = self.rows[row]
            found.setdefault(tuple(waves), []).append((power, row))
        return found

    @cached_property
    def degrees(self) -> Exponents:
        """The highest exponent of x; of C and S of an angle together; of each power."""
        angles = len(self.variables.rates)
        each = [max(column) for column in zip(*self.rows, strict=True)]
        pairs = [max(row[1 + 2 * i] + row[2 + 2 * i] for row in self.rows) for i in range(angles)]
        return (each[0], *pairs, *each[1 + 2 * angles :])

    @property
    def roundings(self) -> int:
        """Of one value, beside those of the coefficients: Horner's rule, products of waves, the sum."""
        return 3 * self.degrees[0] + sum(self.degrees[1:]) + len(self.groups) + 1


def is_readable(function: RealFunction) -> bool:
    """Whether every power of s is a number, and every delay a number times powers of parameters."""
    ring, axis = function.half_angled.ring, function.axis
    rates = [ring.convert(x).reduced() for x in axis.lags]
    return all(x.is_number for x in axis.orders) and all(
        len(f.numerator) == 1 and f.denominator.is_constant() for f in rates
    )


class WaveReader:
    """Reads functions in half angles (``RealFunction.half_angled``), the swept parameters being the only symbols in them."""

    def __init__(self, function: RealFunction, parameters: Sequence[Symbol], scale: Expr) -> None:
        self.ring, axis = function.half_angled.ring, function.axis
        self.orders, self.angles = axis.orders, axis.angles
        self.parameters, self.scale = tuple(parameters), scale
        known = {x: i for i, x in enumerate(self.ring.meanings)}
        self.columns = [known.get(x) for x in parameters]

    def constant(self, value: Monomial) -> WaveFamily:
        """Of degree 0 in all variables."""
        return WaveFamily((value,), self._variables, ((0,) * (1 + self._variables.waves),))

    def family(self, polynomial: Polynomial, factor: Expr) -> WaveFamily:
        """``factor`` times a polynomial of the ring."""
        with flint.ctx.workprec(BITS):
            unit, found = expression_ball(factor), dict[tuple[Exponents, Exponents], arb]()
            for given, coefficient in polynomial.to_dict().items():
                row, exponents, ball = self._term([int(n) for n in given])
                key = row, exponents
                found[key] = found.get(key, arb(0)) + ball * arb(coefficient) * unit
            rows = sorted({row for row, _ in found})
            place = {row: i for i, row in enumerate(rows)}
            terms = sorted((place[row], exponents, ball) for (row, exponents), ball in found.items() if ball != 0)
            return WaveFamily(tuple(monomial(*term) for term in terms), self._variables, tuple(rows))

    def _term(self, given: Sequence[int]) -> tuple[Exponents, Exponents, Any]:
        """The row that a monomial belongs to, its exponents of the parameters, and its constant."""
        scale = expression_ball(self.scale)
        exponents = [given[i] if i is not None else 0 for i in self.columns]
        ball = arb.pi() ** given[1] * scale ** given[0]
        start = self.ring.size
        powers, waves = given[start : start + len(self.orders)], given[start + len(self.orders) :]
        for order, n in zip(self.orders, powers, strict=True):
            ball *= (scale.log() * expression_ball(order)).exp() ** n
        turning: list[int] = []
        for angle, c, s in zip(self.angles, waves[::2], waves[1::2], strict=True):
            if angle.constant:
                half = expression_ball(angle.rate) / 2
                ball *= half.cos() ** c * half.sin() ** s
                continue
            constant, own = self._half_rate(angle.rate)
            ball *= constant**s
            exponents = [n + s * m for n, m in zip(exponents, own, strict=True)]
            turning += [c, s]
        return (given[0], *turning, *powers), tuple(exponents), ball

    def _half_rate(self, rate: Expr) -> tuple[Any, Exponents]:
        """Half of a rate as a number times powers of the parameters."""
        f = self.ring.convert(rate).reduced()
        [(given, coefficient)] = f.numerator.to_dict().items()
        ball = arb(coefficient) / arb(f.denominator.leading_coefficient()) * arb.pi() ** int(given[1]) / 2
        return ball, tuple(int(given[i]) if i is not None else 0 for i in self.columns)

    @cached_property
    def _variables(self) -> Variables:
        rates = []
        with flint.ctx.workprec(BITS):
            scale = expression_ball(self.scale)
            for angle in self.angles:
                if not angle.constant:
                    ball, exponents = self._half_rate(angle.rate)
                    rates.append(monomial(0, exponents, ball * scale))
        return Variables(tuple(rates), tuple(float(x) for x in self.orders))
