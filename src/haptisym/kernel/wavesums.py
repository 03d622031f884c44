"""Sums of polynomials times sines, cosines and powers of omega: their values and Taylor coefficients in balls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, reduce
from math import lcm
from operator import add, mul
from typing import NamedTuple, TypeAlias

import flint
from flint import arb, arb_mat
from sympy import Expr

from haptisym.kernel.bernstein import range_of
from haptisym.kernel.budget import tick
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.waves import NOTHING, ONE, Derivatives, Place, Turns, power_series, powers_of, product, waves_of

_TAYLOR_ORDER = 8


class WaveTerm(NamedTuple):
    """Part of a sum: a polynomial in omega times sines, cosines and powers.

    ``coefficients``: of ascending powers of omega, each a polynomial in pi over the integers. ``turns``: the power of the
    half angle's sine, for each angle (the cosine has what is missing to the sum's degree). ``powers``: of each omega^alpha.
    """

    turns: tuple[int, ...]
    powers: tuple[int, ...]
    coefficients: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class WaveSum:
    """sum of p(omega) prod sin(a_i/2)^k_i cos(a_i/2)^(n_i - k_i) prod omega^(alpha l): entire for omega > 0, no divisions.

    ``rates``: d a_i/d omega of each angle, rad per rad/s, or ``(angle, None)`` for a constant angle. ``degrees``: the n_i.
    """

    terms: tuple[WaveTerm, ...]
    rates: tuple[tuple[Expr, bool], ...]
    degrees: tuple[int, ...]
    orders: tuple[Expr, ...]
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((self.terms, self.degrees)))

    def __hash__(self) -> int:
        return self._hash

    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies, at the current working precision."""
        return _compiled(self, flint.ctx.prec).value(x)

    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around the Taylor coefficients of orders from ``start`` to before ``stop`` about every point of a ball."""
        return _compiled(self, flint.ctx.prec).series(x, start, stop)

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies."""
        return _compiled(self, flint.ctx.prec).over(box)

    def before(self, x: Ball, wanted: Sequence[tuple[tuple[int, ...], int]]) -> list[Ball]:
        """Taylor coefficients about every point of a ball: each of what stands before a product of omega^alpha, and its order."""
        return _compiled(self, flint.ctx.prec).before(x, wanted)

    def parts(self, x: Ball) -> list[Ball]:
        """Balls around the values at a ball of frequencies of what stands before each product of powers of omega^alpha."""
        return _compiled(self, flint.ctx.prec).parts(x)

    @property
    def begins_with_zero(self) -> bool:
        """Whether it is 0 at omega = 0, no powers of omega in it, as each term holds a sine that turns, or omega."""
        turning = [i for i, (_, constant) in enumerate(self.rates) if not constant]
        still = (term.coefficients[0] for term in self.terms if not any(term.turns[i] for i in turning))
        return not any(map(any, still))

    @property
    def shows_itself(self) -> bool:
        """Whether its coefficients prove that it is not 0 everywhere; all orders of powers must be rational.

        Waves of one angle are linearly independent over all algebraic functions. So are then all terms, where no two products
        of powers are a whole power of omega apart: one coefficient that is not 0 is enough. False proves nothing.
        """
        if sum(not constant for _, constant in self.rates) > 1:
            return False
        common = lcm(*(int(order.q) for order in self.orders))
        units = [int(order.p) * (common // int(order.q)) for order in self.orders]
        products = {term.powers for term in self.terms}
        apart = {sum(map(mul, units, powers)) % common for powers in products}
        return len(apart) == len(products) and _compiled(self, flint.ctx.prec).has_clear_coefficient

    def ranges(self, box: Ball) -> dict[tuple[int, ...], Ball]:
        """The same, tight for a short ball."""
        return _compiled(self, flint.ctx.prec).ranges(box)


_Key: TypeAlias = tuple[Turns, tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class CompiledWaves:
    """A sum with balls of one precision for its constants: waves of constant angles are among the coefficients.

    ``rates``, ``degrees``: of the half angles that turn. ``terms``: sine powers, powers of omega^alpha, ascending coefficients.
    """

    rates: tuple[Ball, ...]
    degrees: tuple[int, ...]
    exponents: tuple[Ball, ...]
    terms: tuple[tuple[Turns, tuple[int, ...], Sequence[Ball]], ...]

    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies."""
        return self.taylor(x, 0)

    def taylor(self, x: Ball, order: int) -> Ball:
        """A ball around the Taylor coefficient of that order about every point of a ball of frequencies."""
        return self.series(x, order, order + 1)[0]

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies.

        Taylor's theorem about the middle m, f(m + h) = c_0 + c_1 h + ... + c(xi) h^n, with the last coefficient enclosed over the
        whole ball: tight as soon as the ball is shorter than what the function does, however much its terms cancel.
        """
        middle, reach = box.mid(), powers_of(box.rad(), _TAYLOR_ORDER + 1)
        row = [*self.series(middle, 0, _TAYLOR_ORDER), self.taylor(box, _TAYLOR_ORDER)]
        slopes = [n * c for n, c in enumerate(row)][1:]
        bends = [n * c / 2 for n, c in enumerate(slopes)][1:]
        return range_of(row, reach), range_of(slopes, reach), range_of(bends, reach)

    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around the Taylor coefficients of orders from ``start`` to before ``stop`` about every point of a ball."""
        tick()
        place, found = self._place(x), list[Ball]()
        for powers, sums in self._sums.items():
            if any(powers):
                exponent = reduce(add, map(mul, self.exponents, powers))
                own = product(sums.series(place, 0, stop), power_series(x, exponent, stop), start)
            else:
                own = sums.series(place, start, stop)
            found = list(map(add, found, own)) if found else own
        return found

    def before(self, x: Ball, wanted: Sequence[tuple[tuple[int, ...], int]]) -> list[Ball]:
        """Taylor coefficients about every point of a ball: each of what stands before a product of omega^alpha, and its order."""
        place = self._place(x)
        return [self._sums[powers].series(place, order, order + 1)[0] for powers, order in wanted]

    def parts(self, x: Ball) -> list[Ball]:
        """Balls around the values at a ball of frequencies of what stands before each product of powers of omega^alpha."""
        place = self._place(x)
        return [sums.series(place, 0, 1)[0] for sums in self._sums.values()]

    def ranges(self, box: Ball) -> dict[tuple[int, ...], Ball]:
        """Enclosures over a ball of frequencies of what stands before each product of powers of omega^alpha, as in ``over``."""
        n, reach = _TAYLOR_ORDER, powers_of(box.rad(), _TAYLOR_ORDER + 1)
        at, around = self._place(box.mid()), self._place(box)
        return {
            powers: range_of([*sums.series(at, 0, n), *sums.series(around, n, n + 1)], reach)
            for powers, sums in self._sums.items()
        }

    @property
    def has_clear_coefficient(self) -> bool:
        """Whether one of the coefficients is known not to be 0."""
        return any(x > 0 or x < 0 for _, _, row in self.terms for x in row)

    @cached_property
    def _angles(self) -> list[tuple[Ball, int]]:
        """Rate and degree of the half angles that turn; one that stands still where there is none."""
        return list(zip(self.rates, self.degrees, strict=True)) or [(arb(0), 0)]

    def _place(self, x: Ball) -> Place:
        *others, last = [waves_of(rate * x, degree) for rate, degree in self._angles]
        outer: dict[Turns, Ball] = {(): ONE}
        for waves in others:
            outer = {(*turns, k): known * wave for turns, known in outer.items() for k, wave in enumerate(waves)}
        return outer, arb_mat(1, len(last), last), arb_mat(self._width, 1, powers_of(x, self._width))

    @cached_property
    def _width(self) -> int:
        return max([1, *(len(row) for _, _, row in self.terms)])

    @cached_property
    def _sums(self) -> Mapping[tuple[int, ...], Derivatives]:
        """By powers of omega^alpha, what stands before them."""
        groups: dict[tuple[int, ...], dict[Turns, Sequence[Ball]]] = {}
        for turns, powers, row in self.terms:
            groups.setdefault(powers, {})[turns or (0,)] = row
        return {powers: Derivatives(self._angles, self._width, own) for powers, own in groups.items()}


@lru_cache(maxsize=512)
def _compiled(waves: WaveSum, bits: int) -> CompiledWaves:
    with flint.ctx.workprec(bits):
        halves = [expression_ball(rate) / 2 for rate, _ in waves.rates]
        turning = [i for i, (_, constant) in enumerate(waves.rates) if not constant]
        fixed = [(i, waves_of(halves[i], waves.degrees[i])) for i, (_, constant) in enumerate(waves.rates) if constant]
        pis = powers_of(arb.pi(), max([len(c) for term in waves.terms for c in term.coefficients]))
        units: dict[Turns, list[Ball]] = {(): pis}
        for _, wave in fixed:  # powers of pi times the waves of all constant angles
            units = {(*known, k): [x * w for x in row] for known, row in units.items() for k, w in enumerate(wave)}
        terms: dict[_Key, list[Ball]] = {}
        for turns, powers, coefficients in waves.terms:
            own = units[tuple([turns[i] for i, _ in fixed])]
            row = terms.setdefault((tuple([turns[i] for i in turning]) if fixed else turns, powers), [])
            row += [NOTHING] * (len(coefficients) - len(row))
            for n, c in enumerate(coefficients):
                for whole, unit in zip(c, own):  # noqa: B905 - not all have all powers of pi
                    if whole:
                        row[n] = row[n] + unit * whole if fixed or unit is not ONE else arb(whole)
        return CompiledWaves(
            tuple(halves[i] for i in turning),
            tuple(waves.degrees[i] for i in turning),
            tuple(expression_ball(order) for order in waves.orders),
            tuple((*key, row) for key, row in terms.items()),
        )
