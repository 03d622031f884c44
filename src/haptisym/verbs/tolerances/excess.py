"""The excess r^2 - c^2 over cells of band and box, as Taylor models: proven bounds on it and on its slopes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from flint import arb
from sympy import Add, Expr, I, Integer, Mul, Pow, Rational, Symbol, pi

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.symbols import omega, s
from haptisym.model.jnd import Part, is_irrational_algebraic
from haptisym.programs.taylormodels import Array, Model, between, constant, variable
from haptisym.verbs.tolerances.box import Box

Pair: TypeAlias = tuple[Model, Model]
"""Real and imaginary part."""


class Excess:
    """r^2 - c^2 of one part, for every frequency of the band and every set of values of the box.

    r = |Re dH|/|H_env| (or Im) with dH = P/Q and H_env = A/B in lowest terms: r^2 = Re(P conj Q)^2 |B|^2/(|A|^2 |Q|^4). What is
    real on s = j omega and common to P and A is taken out before, as a power of s is. Each factor of them is written as a
    monomial of parameters, which mostly cancel, times a rest that varies little: bounds are the better for it.

    ``model`` takes cells, an array (cells, sides, 2): for omega, then for each side of the box, from which share of its way to
    which, 0 the low end and 1 the high end.
    """

    def __init__(self, box: Box, part: Part) -> None:
        scene, varying = box.scene, {side.name for side in box.sides}
        fixed = {p.symbol: p.value for p in scene.parameters if p.symbol.name not in varying}
        d = scene.chain.at(fixed).distortion()
        assert isinstance(d.env.ring, Ring)
        self.ring: Ring = d.env.ring
        self.is_zero = d.difference.is_zero
        symbols = {p.symbol.name: p.symbol for p in scene.parameters}
        own = [(symbols.get(x.name, Symbol(x.name)), x.low, x.high) for x in box.sides]
        self._intervals = [(x, _float(low), _float(high - low)) for x, low, high in [(omega, *scene.band), *own]]
        self.sides = len(self._intervals)
        name = box.part_name(part)
        self._limit = Symbol(name) if name in varying else None
        self._c = _float(scene.threshold[part])
        P, Q, A, B = d.difference.numerator, d.difference.denominator, d.env.numerator, d.env.denominator
        self._smooth = any(_is_zero_at_0(x, self.ring) for x in (Q, A))
        if self._smooth:
            P, Q, A, B = (_smoothed(x, self.ring) for x in (P, Q, A, B))
            (P, Q), (A, B) = _without_powers(P, Q), _without_powers(A, B)
        P, A, turned = _without_real_factors(P, A, self.ring)
        self._imag = (part is Part.IMAG) != turned
        scale = [low + width / 2 for _, low, width in self._intervals]
        weights = dict(zip([x for x, _, _ in self._intervals], scale, strict=True))
        steady = {x for x, low, width in self._intervals[1:] if low * (low + width) > 0}
        self._P, self._Q, self._A, self._B = (_Form.of(x, self.ring, weights, steady) for x in (P, Q, A, B))

    def model(self, cells: Array) -> Model:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole may lie in the cell."""
        known = {x: self._variable(i, low, width, cells) for i, (x, low, width) in enumerate(self._intervals)}
        count = len(cells)
        with np.errstate(all="ignore"):  # what is not finite is unknown, which every caller asks about
            generators = [self._generator(x, known, count) for x in self.ring.meanings]
            (p, q), Q, A, B = (self._product(x, generators, count) for x in (self._P, self._Q, self._A, self._B))
            x, y = Q
            turned = q * x - p * y if self._imag else p * x + q * y
            c = known[self._limit] if self._limit else constant(self._c, count, self.sides)
            over = turned * self._monomial(known, count) * _square(Q).power(-1)
            return over * over * _square(B) * _square(A).power(-1) - c * c

    @cached_property
    def matters(self) -> Array:
        """For omega and each side, whether the excess depends on it."""
        forms = (self._P, self._Q, self._A, self._B)
        used = {i for form in forms for terms, _ in form.factors for e in terms for i, n in enumerate(e) if n}
        seen = {y for i in used for y in self.ring.meanings[i].free_symbols} | self._net_monomial().keys() | {omega}
        return np.array([x in seen or x == self._limit for x, _, _ in self._intervals])

    def _variable(self, i: int, low: float, width: float, cells: Array) -> Model:
        start, end = cells[:, i, 0], cells[:, i, 1]
        middle, radius = low + width * (start + end) / 2, width * (end - start) / 2
        return variable(middle, radius, abs(low) + width, i, self.sides)

    def _net_monomial(self) -> dict[Symbol, int]:
        """What was taken out of the factors, without what cancels."""
        powers: dict[Symbol, int] = {}
        for form, sign in ((self._P, 1), (self._B, 1), (self._Q, -1), (self._A, -1)):
            for x, n in form.monomial.items():
                powers[x] = powers.get(x, 0) + sign * n
        return {x: n for x, n in powers.items() if n}

    def _monomial(self, known: Mapping[Expr, Model], count: int) -> Model:
        total = constant(self._P.unit * self._B.unit / self._Q.unit / self._A.unit, count, self.sides)
        for x, n in self._net_monomial().items():
            total = total * known[x].power(n)
        return total

    def _product(self, form: _Form, generators: Sequence[Pair | None], count: int) -> Pair:
        total: Pair | None = None
        for terms, n in form.factors:
            factor = self._sum(terms, generators, count)
            for _ in range(n):
                total = factor if total is None else _times(total, factor)
        one = constant(1.0, count, self.sides), constant(0.0, count, self.sides)
        return total or one

    def _sum(self, terms: Mapping[tuple[int, ...], float], generators: Sequence[Pair | None], count: int) -> Pair:
        total = (constant(0.0, count, self.sides),) * 2
        for exponents, coefficient in terms.items():
            tick()
            real, pair = None, None
            for x, n in zip(generators, exponents, strict=True):
                if n and x is not None and x[1] is _REAL:
                    real = x[0].power(n) if real is None else real * x[0].power(n)
                elif n and x is not None:
                    pair = _power(x, n) if pair is None else _times(pair, _power(x, n))
            real = constant(coefficient, count, self.sides) if real is None else real.times(coefficient)
            total = (total[0] + (real * pair[0] if pair else real)), (total[1] + real * pair[1] if pair else total[1])
        return total

    def _generator(self, x: Expr, known: Mapping[Expr, Model], count: int) -> Pair | None:
        """What a variable of the ring is on s = j omega; None for one that does not occur."""
        zero = constant(0.0, count, self.sides)
        if x == s:
            return zero, known[omega]
        if x == I:
            return zero, constant(1.0, count, self.sides)
        if x.is_Symbol:
            return (known[x], _REAL) if x in known else None
        if isinstance(x, Pow) and x.base == s:
            return self._power_of_s(self._value(x.exp, known, count), known[omega], count)
        if x == pi:
            return self._value(x, known, count), _REAL
        angle = self._value(-(x.args[0] / s), known, count) * known[omega]  # exp(-s lag)
        if self._smooth:
            half = angle.times(0.5)
            cosine, sine = half.cosine_and_sine()
            return half.sinc() * cosine, -(half.sinc() * sine)
        cosine, sine = angle.cosine_and_sine()
        return cosine, -sine

    def _power_of_s(self, order: Model, w: Model, count: int) -> Pair:
        """s^order = omega^order (cos + j sin)(order pi/2), 0 < order < 1."""
        smooth = (w.log() * order).exp()
        (least, most), top = (x[:, 0] for x in order.bounds()), np.maximum(w.bounds()[1][:, 0], 0.0)
        rough = between(np.zeros(count), np.maximum(top**least, top**most) * (1 + 1e-12), self.sides)
        size = smooth.where(np.isfinite(smooth.bounds()[1]).all(-1), rough)
        cosine, sine = order.times(np.pi / 2).cosine_and_sine()
        return size * cosine, size * sine

    def _value(self, form: Expr, known: Mapping[Expr, Model], count: int) -> Model:
        """A number, or a sum or product of numbers and parameters."""
        if form in known:
            return known[form]
        if form.is_number:
            return constant(_float(form), count, self.sides)
        models = [self._value(x, known, count) for x in form.args if not isinstance(form, Pow)]
        if isinstance(form, Pow) and isinstance(form.exp, Integer):
            return self._value(form.base, known, count).power(int(form.exp))
        assert isinstance(form, Add | Mul)
        total = models[0]
        for x in models[1:]:
            total = total + x if isinstance(form, Add) else total * x
        return total


_REAL = constant(0.0, 1, 1)
"""Marks a generator that is real, by its imaginary part."""


@dataclass(frozen=True)
class _Form:
    """A polynomial as ``unit * monomial * factors``, the factors with the monomial taken out of them."""

    unit: float
    monomial: Mapping[Symbol, int]
    factors: tuple[tuple[Mapping[tuple[int, ...], float], int], ...]

    @classmethod
    def of(cls, polynomial: Polynomial, ring: Ring, weights: Mapping[Symbol, float], steady: set[Symbol]) -> _Form:
        """``weights``: about how large the variables are; ``steady``: parameters that are 0 nowhere in the box."""
        if polynomial.is_zero():
            return cls(0.0, {}, ())
        unit, factors = ring.factors(polynomial)
        monomial: dict[Symbol, int] = {}
        found = []
        for factor, n in factors:
            terms = {tuple(int(x) for x in e): float(arb(c)) for e, c in factor.to_dict().items()}
            largest = max(terms, key=lambda e, terms=terms: abs(terms[e]) * _size(e, ring, weights))  # type: ignore[misc]
            out = tuple(x if ring.meanings[i] in steady else 0 for i, x in enumerate(largest))
            for i, x in enumerate(out):
                if x:
                    monomial[ring.meanings[i]] = monomial.get(ring.meanings[i], 0) + n * x
            found.append(({tuple(x - y for x, y in zip(e, out, strict=True)): c for e, c in terms.items()}, n))
        return cls(_float(unit), monomial, tuple(found))


def _size(exponents: Sequence[int], ring: Ring, weights: Mapping[Symbol, float]) -> float:
    """About how large a monomial is."""
    known = {**weights, s: weights[omega]}
    return float(np.prod([abs(known.get(x, 1.0)) ** n for x, n in zip(ring.meanings, exponents, strict=True)]))


def _power(x: Pair, n: int) -> Pair:
    found = x
    for _ in range(n - 1):
        found = _times(found, x)
    return found


def _times(u: Pair, v: Pair) -> Pair:
    (a, b), (x, y) = u, v
    return a * x - b * y, a * y + b * x


def _square(u: Pair) -> Model:
    return u[0] * u[0] + u[1] * u[1]


def _is_zero_at_0(polynomial: Polynomial, ring: Ring) -> bool:
    """Whether a polynomial with delays in it vanishes at s = 0, where they are 1, without having s as a factor."""
    delays = {ring.size + i: 1 for i in range(len(ring.lags))}
    return bool(delays) and bool(polynomial.subs({0: 0, **delays}).is_zero())


def _smoothed(polynomial: Polynomial, ring: Ring) -> Polynomial:
    """With phi = (1 - exp(-s lag))/(s lag) in the place of each delay, exp(-s lag) = 1 - s lag phi."""
    gens = list(ring.context.gens())
    for i, lag in enumerate(ring.lags, ring.size):
        time = ring.convert(lag)
        gens[i] = 1 - gens[0] * gens[i] * time.numerator / time.denominator
    return polynomial.compose(*gens)


def _without_powers(above: Polynomial, below: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Two polynomials without the power of s that is common to them."""
    if above.is_zero():
        return above, below
    n = min(int(e[0]) for x in (above, below) for e in x.monoms())
    s_n = above.context().gens()[0] ** n
    return above / s_n, below / s_n


def _without_real_factors(P: Polynomial, A: Polynomial, ring: Ring) -> tuple[Polynomial, Polynomial, bool]:
    """Without the common factors that are real or imaginary on s = j omega; whether that turns the phase by a right angle."""
    if P.is_zero():
        return P, A, False
    turned = False
    for factor, n in ring.factors(P.gcd(A))[1]:
        powers = [int(e[0]) for e in factor.monoms()]
        plain = not any(int(x) for x in factor.degrees()[ring.size :])
        if plain and len({power % 2 for power in powers}) == 1:
            P, A = P / factor**n, A / factor**n
            turned ^= bool(powers[0] % 2 and n % 2)
    return P, A, turned


def _float(value: Expr) -> float:
    """The number to within a rounding or two."""
    if isinstance(value, Rational):
        return int(value.p) / int(value.q)
    return float(value.evalf(20)) if is_irrational_algebraic(value) else float(expression_ball(value))
