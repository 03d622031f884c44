"""Sums of polynomials times sines, cosines and powers of omega: their values and Taylor coefficients in balls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, reduce
from itertools import accumulate, repeat
from math import factorial, lcm
from operator import add, mul
from typing import NamedTuple, TypeAlias

import flint
from flint import arb, arb_mat, arb_poly
from sympy import Expr

from haptisym.kernel.bernstein import range_of
from haptisym.kernel.budget import tick
from haptisym.kernel.reals import Ball, expression_ball

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


_Turns: TypeAlias = tuple[int, ...]
_Key: TypeAlias = tuple[_Turns, tuple[int, ...]]
_Blocks: TypeAlias = Mapping[_Turns, arb_mat]
"""Coefficients of powers of omega (columns) times waves of the last angle (rows), by the turns of the other angles."""
_Place: TypeAlias = tuple[Mapping[_Turns, Ball], arb_mat, arb_mat]
"""Products of sines and cosines of all half angles but the last, by turns; those of the last one in a row; powers of omega."""


@dataclass(frozen=True, eq=False)
class CompiledWaves:
    """A sum with balls of one precision for its constants: waves of constant angles are among the coefficients.

    ``rates``, ``degrees``: of the half angles that turn. ``terms``: sine powers, powers of omega^alpha, ascending coefficients.
    """

    rates: tuple[Ball, ...]
    degrees: tuple[int, ...]
    exponents: tuple[Ball, ...]
    terms: tuple[tuple[_Turns, tuple[int, ...], Sequence[Ball]], ...]

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
        middle, reach = box.mid(), _powers(box.rad(), _TAYLOR_ORDER + 1)
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
                own = _product(sums.series(place, 0, stop), _power_series(x, exponent, stop), start)
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
        n, reach = _TAYLOR_ORDER, _powers(box.rad(), _TAYLOR_ORDER + 1)
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

    def _place(self, x: Ball) -> _Place:
        *others, last = [_waves(rate * x, degree) for rate, degree in self._angles]
        outer: dict[_Turns, Ball] = {(): _ONE}
        for waves in others:
            outer = {(*turns, k): known * wave for turns, known in outer.items() for k, wave in enumerate(waves)}
        return outer, arb_mat(1, len(last), last), arb_mat(self._width, 1, _powers(x, self._width))

    @cached_property
    def _width(self) -> int:
        return max([1, *(len(row) for _, _, row in self.terms)])

    @cached_property
    def _sums(self) -> Mapping[tuple[int, ...], _Derivatives]:
        """By powers of omega^alpha, what stands before them."""
        groups: dict[tuple[int, ...], dict[_Turns, Sequence[Ball]]] = {}
        for turns, powers, row in self.terms:
            groups.setdefault(powers, {})[turns or (0,)] = row
        return {powers: _Derivatives(self._angles, self._width, own) for powers, own in groups.items()}


class _Derivatives:
    """A sum of polynomials times waves and its derivatives, which are of the same kind: exact, and no longer.

    d sin(a)^k cos(a)^(n - k) = (k sin(a)^(k - 1) cos(a)^(n - k + 1) - (n - k) sin(a)^(k + 1) cos(a)^(n - k - 1)) da.
    """

    def __init__(self, angles: Sequence[tuple[Ball, int]], width: int, terms: Mapping[_Turns, Sequence[Ball]]) -> None:
        *self._outer, (rate, degree) = angles
        self._turn, self._shift = _turning(rate, degree), _shift(width)
        entries: dict[_Turns, list[Ball]] = {}
        for (*others, k), row in terms.items():
            block = entries.setdefault(tuple(others), [_NOTHING] * (width * (degree + 1)))
            block[k * width : k * width + len(row)] = row
        self._known: list[_Blocks] = [{o: arb_mat(degree + 1, width, block) for o, block in entries.items()}]

    def series(self, place: _Place, start: int, stop: int) -> list[Ball]:
        """The Taylor coefficients of these orders."""
        outer, last, columns = place
        while len(self._known) < stop:
            self._known.append(self._derived(self._known[-1]))
        if () in outer:
            found = [(last * (blocks[()] * columns))[0, 0] for blocks in self._known[start:stop]]
        else:
            found = [
                sum((outer[turns] * (last * (block * columns))[0, 0] for turns, block in blocks.items()), _NOTHING)
                for blocks in self._known[start:stop]
            ]
        return list(map(mul, found, _shares(stop, flint.ctx.prec)[start:])) if stop > 2 else found

    def _derived(self, blocks: _Blocks) -> _Blocks:
        found: dict[_Turns, arb_mat] = {}
        for others, block in blocks.items():
            tick()
            parts = [(others, block * self._shift + self._turn * block)]
            for i, (rate, degree) in enumerate(self._outer):
                k = others[i]
                if k:
                    parts.append(((*others[:i], k - 1, *others[i + 1 :]), block * (rate * k)))
                if k < degree:
                    parts.append(((*others[:i], k + 1, *others[i + 1 :]), block * (rate * (k - degree))))
            for turns, part in parts:
                found[turns] = found[turns] + part if turns in found else part
        return found


@lru_cache(maxsize=64)
def _shares(count: int, bits: int) -> list[Ball]:
    """1/0!, 1/1!, 1/2!, ..."""
    with flint.ctx.workprec(bits):
        return [arb(1) / factorial(n) for n in range(count)]


@lru_cache(maxsize=64)
def _shift(width: int) -> arb_mat:
    """What d/d omega does to the coefficients of 1, omega, omega^2, ... in a row: whole numbers, exact at any precision."""
    shift = arb_mat(width, width)
    for n in range(1, width):
        shift[n, n - 1] = n
    return shift


def _turning(rate: Ball, degree: int) -> arb_mat:
    """What d/d omega does to the coefficients of sin^k cos^(degree - k), k = 0 ... degree, of one half angle."""
    turn = arb_mat(degree + 1, degree + 1)
    for k in range(degree):
        turn[k, k + 1] = rate * (k + 1)
        turn[k + 1, k] = rate * (k - degree)
    return turn


def _powers(x: Ball, count: int) -> list[Ball]:
    """1, x, x^2, ..."""
    return list(accumulate(repeat(x, count - 1), mul, initial=_ONE))


def _waves(half: Ball, degree: int) -> list[Ball]:
    """sin^k cos^(degree - k) of a half angle, k = 0 ... degree."""
    sine, cosine = half.sin_cos()
    if degree == 1:
        return [cosine, sine]
    if degree == 2:
        return [cosine**2, sine * cosine, sine**2]
    return list(map(mul, _powers(sine, degree + 1), reversed(_powers(cosine, degree + 1))))


def _power_series(x: Ball, exponent: Ball, length: int) -> list[Ball]:
    """The Taylor coefficients of x^exponent."""
    found = [(x.log() * exponent).exp()]
    inverse = 1 / x if length > 1 else x
    for n in range(length - 1):
        found.append(found[-1] * ((exponent - n) / (n + 1)) * inverse)
    return found


def _product(a: Sequence[Ball], b: Sequence[Ball], start: int = 0) -> list[Ball]:
    """The product of two Taylor series, as long as they are, from an order on."""
    if start == len(a) - 1:
        return [reduce(add, map(mul, a, reversed(b)))]
    found = arb_poly(a) * arb_poly(b)
    return [found[n] for n in range(start, len(a))]


@lru_cache(maxsize=512)
def _compiled(waves: WaveSum, bits: int) -> CompiledWaves:
    with flint.ctx.workprec(bits):
        halves = [expression_ball(rate) / 2 for rate, _ in waves.rates]
        turning = [i for i, (_, constant) in enumerate(waves.rates) if not constant]
        fixed = [(i, _waves(halves[i], waves.degrees[i])) for i, (_, constant) in enumerate(waves.rates) if constant]
        pis = _powers(arb.pi(), max(len(c) for term in waves.terms for c in term.coefficients))
        units: dict[_Turns, list[Ball]] = {(): pis}
        for _, wave in fixed:  # powers of pi times the waves of all constant angles
            units = {(*known, k): [x * w for x in row] for known, row in units.items() for k, w in enumerate(wave)}
        terms: dict[_Key, list[Ball]] = {}
        for turns, powers, coefficients in waves.terms:
            own = units[tuple([turns[i] for i, _ in fixed])]
            row = terms.setdefault((tuple([turns[i] for i in turning]) if fixed else turns, powers), [])
            row += [_NOTHING] * (len(coefficients) - len(row))
            for n, c in enumerate(coefficients):
                for whole, unit in zip(c, own):  # noqa: B905 - not all have all powers of pi
                    if whole:
                        row[n] = row[n] + unit * whole
        return CompiledWaves(
            tuple(halves[i] for i in turning),
            tuple(waves.degrees[i] for i in turning),
            tuple(expression_ball(order) for order in waves.orders),
            tuple((*key, row) for key, row in terms.items()),
        )


_NOTHING, _ONE = arb(0), arb(1)
