"""A continuous plant between a hold and a sampler: its pulse transfer function, and the polynomial of the loop that is closed.

The plant G(s) = sum over i of exp(-s tau_i) N_i(s)/Q(s) is proper. It is driven by a force held for T at a time, and read the
moment before the force changes. In w = 1/z its samples are w^l (w F_1(w) + w^2 F_2(w))/|1 - w exp(A T)|, with A the companion
matrix of Q and tau = l T + theta: F_1 belongs to the force held last, F_2 to the one before, which a delay that is no whole
sample lets in (the modified z-transform). In balls that is a matrix exponential; exactly it is the sum of residues of
G(s)/s exp(s (T - theta)) w/(1 - w exp(s T)).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import lcm
from types import MappingProxyType
from typing import Any, TypeAlias

from flint import arb, arb_mat, arb_poly, fmpq, fmpq_poly
from sympy import Expr, pi

from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.exponentials import Element, Exponentials
from haptisym.kernel.precision import at_rising_precision
from haptisym.kernel.reals import Ball, expression_ball

Numbers: TypeAlias = Sequence[Expr]
"""Coefficients, ascending: rational numbers times powers of pi, and sums of such."""


@dataclass(frozen=True)
class Plant:
    """G(s), by its denominator and, for each delay (s), a numerator; none of them improper."""

    denominator: tuple[Expr, ...]
    terms: tuple[tuple[Expr, tuple[Expr, ...]], ...]

    def __post_init__(self) -> None:
        if any(len(above) > len(self.denominator) for _, above in self.terms):
            raise SceneError("a force that jumps would move the sampled position by an impulse")


@dataclass(frozen=True)
class SampledLoop:
    """The loop of a plant and a controller D(w) = above/below, w = 1/z, with a clock: 1 + D G = 0, as a polynomial in w.

    A root w in the closed unit disc is a root z = 1/w that does not fade. ``coefficients`` are those of w, ascending.

    >>> half = Rational(1, 2)
    >>> plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))            # 1/s, T = 1
    >>> loop = SampledLoop(plant, Integer(1), (half,), (Integer(1),))
    >>> loop.balls()                                                                       # 1 - w + w/2
    [1.00000000000000, -0.500000000000000]
    """

    plant: Plant
    T: Expr
    above: tuple[Expr, ...]
    below: tuple[Expr, ...]

    def balls(self, known: Mapping[Expr, Ball] = MappingProxyType({})) -> list[Ball]:
        """The coefficients at the current working precision; ``known`` : balls that symbols in the loop stand for."""
        above, below = (arb_poly([expression_ball(x, known) for x in row]) for row in (self.above, self.below))
        den, num = pulse(self.plant, self.T, self.samples(known), known)
        return [*(below * den + above * num).coeffs()]

    @cached_property
    def whole(self) -> tuple[int, ...]:
        """Of each delay the whole samples."""
        return self.samples({})

    def samples(self, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        """Of each delay the whole samples."""
        return tuple(_floor(lag / self.T, known) for lag, _ in self.plant.terms)

    def exact(self) -> list[Element] | None:
        """The same times a number that is not 0; None where the plant holds pi."""
        return None if self._exact is None else self._exact[1]

    def is_zero(self, x: Element) -> bool:
        assert self._exact
        return self._exact[0].is_zero(x)

    @cached_property
    def _exact(self) -> tuple[Exponentials, list[Element]] | None:
        lags = [lag - n * self.T for (lag, _), n in zip(self.plant.terms, self.whole, strict=True)]
        if not all(x.is_Rational for x in (self.T, *lags, *self.plant.denominator)):
            return None
        return _Residues(self, [_fmpq(x) for x in lags]).polynomial()


def pulse(plant: Plant, period: Expr, whole: Sequence[int], known: Mapping[Expr, Ball]) -> tuple[Any, Any]:
    """Denominator and numerator of the pulse transfer function, polynomials in w, in balls."""
    lead, T = expression_ball(plant.denominator[-1], known), expression_ball(period, known)
    Q = [expression_ball(x, known) / lead for x in plant.denominator]
    A, n = _matrix(_companion(Q)), len(Q) - 1
    Phi = (A * T).exp()
    den, total = _reversed_characteristic(Phi), arb_poly([])
    for (lag, above), ell in zip(plant.terms, whole, strict=True):
        N = [expression_ball(x, known) / lead for x in above]
        N += [arb(0)] * (n + 1 - len(N))
        C, late = [x - N[n] * q for x, q in zip(N, Q, strict=True)][:n], expression_ball(lag - ell * period, known)
        own = arb_poly([arb(0), N[n]]) * den + _response(Phi, _held(Q, T - late), C, den)
        if not late.is_zero():
            before = (A * (T - late)).exp() * _held(Q, late)
            own += arb_poly([arb(0), arb(1)]) * _response(Phi, before, C, den)
        total += arb_poly([arb(0)] * ell + [arb(1)]) * own
    return den, total


def _floor(ratio: Expr, known: Mapping[Expr, Ball]) -> int:
    """The whole part of a number."""

    def whole(_: int) -> int | None:
        found = expression_ball(ratio, known).floor().unique_fmpz()
        return None if found is None else int(found)

    if ratio.is_Rational:
        return int(ratio.p // ratio.q)
    found = at_rising_precision(whole)
    if found is None:
        raise UndecidedError("whether a delay is a whole number of samples")
    return found


def _fmpq(x: Expr) -> fmpq:
    return fmpq(int(x.p), int(x.q))


def _matrix(rows: list[list[Ball]], columns: int | None = None) -> Any:
    """A matrix, which may be of no size."""
    width = len(rows) if columns is None else columns
    return arb_mat(rows) if rows and width else arb_mat(len(rows), width)


def _companion(Q: Sequence[Ball]) -> list[list[Ball]]:
    n = len(Q) - 1
    return [[arb(int(j == i + 1)) if i < n - 1 else -Q[j] for j in range(n)] for i in range(n)]


def _held(Q: Sequence[Ball], time: Ball) -> Any:
    """Where a unit force that is held for some time takes a plant at rest."""
    n = len(Q) - 1
    rows = [[*row, arb(int(i == n - 1))] for i, row in enumerate(_companion(Q))]
    moved = (_matrix([*rows, [arb(0)] * (n + 1)]) * time).exp()
    return _matrix([[moved[i, n]] for i in range(n)], 1)


def _reversed_characteristic(M: Any) -> Any:
    """|1 - w M|."""
    return arb_poly(M.charpoly().coeffs()[::-1])


def _response(Phi: Any, start: Any, C: Sequence[Ball], den: Any) -> Any:
    """w C adj(1 - w Phi) start: |1 - w (Phi - start C)| is the denominator and that."""
    return _reversed_characteristic(Phi - start * _matrix([list(C)], len(C))) - den


class _Residues:
    """The polynomial of a loop in exact numbers, by residues at the poles of G(s)/s."""

    def __init__(self, loop: SampledLoop, late: Sequence[fmpq]) -> None:
        self.loop, self.late = loop, late
        Q = fmpq_poly([_fmpq(x) for x in loop.plant.denominator])
        self.at_0 = next(i for i, x in enumerate(Q.coeffs()) if x)
        self.lead = Q.coeffs()[-1]
        split = fmpq_poly(Q.coeffs()[self.at_0 :]).factor()[1]
        rows = [_whole(f) for f, _ in split]
        times = sorted({_fmpq(loop.T), *(_fmpq(loop.T) - x for x in late)})
        self.ring, self.times = Exponentials(rows, times), times
        self.poles = [n for row, (_, n) in zip(rows, split, strict=True) for _ in range(len(row) - 1)]
        # s, exp(s t) and what is differentiated live in a ring of the same kind, with s a root of its own
        self.free = Exponentials([*rows, (0, 1)], times)

    def polynomial(self) -> tuple[Exponentials, list[Element]]:
        """In w, ascending, times a number that is not 0."""
        ring, one = self.ring, self.ring.constant(1)
        T = self.times.index(_fmpq(self.loop.T))
        lines = [one - ring.w] + [one - ring.exponential(i, T) * ring.w for i in range(len(self.poles))]
        orders = [self.at_0 + 1, *self.poles]  # of G(s)/s; the samples of its sum are taken 1 - w times
        tops, scales = zip(*(self._residue(i, n) for i, n in enumerate(orders)), strict=True)
        total, common = ring.constant(0), one
        for x in scales:
            common = common * x
        for i, top in enumerate(tops):
            others = one
            for j, (line, n) in enumerate(zip(lines, orders, strict=True)):
                if j != i:
                    others = others * line**n * scales[j]
            total = total + top * others
        den = one
        for line, n in zip(lines, [self.at_0, *self.poles], strict=True):
            den = den * line**n
        above, below = (self._row(row) for row in (self.loop.above, self.loop.below))
        found = below * den * common + above * total
        return ring, _by_power(ring, found)

    def _row(self, coefficients: Numbers) -> Element:
        """A polynomial in w whose coefficients may hold pi."""
        total = self.ring.constant(0)
        for n, x in enumerate(coefficients):
            for term in x.expand().as_ordered_terms():
                number, rest = term.as_coeff_Mul()
                power = 0 if rest == 1 else int(rest.as_base_exp()[1])
                assert rest == pi**power
                total = total + self.ring.constant(_fmpq(number)) * self.ring.pi**power * self.ring.w**n
        return total

    def _residue(self, place: int, order: int) -> tuple[Element, Element]:
        """Of a pole, 0 or one of the roots: what stands over (1 - w exp(p T))^order, times a number, and that number."""
        free, T = self.free, _fmpq(self.loop.T)
        count = len(self.poles)
        s, k = free.root(count), self.times.index(T)
        R = free.constant(self.lead)  # Q(s) s without the pole
        for j, n in enumerate([self.at_0 + 1, *self.poles]):
            if j != place:
                R = R * (s - (free.root(j - 1) if j else free.constant(0))) ** n
        line = free.constant(1) - free.exponential(count, k) * free.w
        top = self._above(s, count)
        scale = free.constant(1)
        for n in range(1, order):  # (top/(R line)^n)' = (top' R line - n top (R line)')/(R line)^(n + 1)
            below = R * line
            top = self._slope(top, count) * below - n * top * self._slope(below, count)
            scale = scale * n
        return self._put(top, place), self._put(scale * R**order, place)

    def _above(self, s: Element, count: int) -> Element:
        """Sum over the delays of N(s) exp(s (T - theta)) w^(l + 1)."""
        free, total = self.free, self.free.constant(0)
        for (_, above), late, ell in zip(self.loop.plant.terms, self.late, self.loop.whole, strict=True):
            k = self.times.index(_fmpq(self.loop.T) - late)
            N = sum((self._number(x) * s**n for n, x in enumerate(above)), free.constant(0))
            total = total + N * free.exponential(count, k) * free.w ** (ell + 1)
        return total

    def _number(self, x: Expr) -> Element:
        total = self.free.constant(0)
        for term in x.expand().as_ordered_terms():
            number, rest = term.as_coeff_Mul()
            power = 0 if rest == 1 else int(rest.as_base_exp()[1])
            total = total + self.free.constant(_fmpq(number)) * self.free.pi**power
        return total

    def _slope(self, x: Element, count: int) -> Element:
        """d/ds, where s and its exponentials are the last root's."""
        free = self.free
        total = x.derivative(2 + count)
        for k, t in enumerate(self.times):
            place = 2 + count + 1 + count * len(self.times) + k
            total = total + t * free.exponential(count, k) * x.derivative(place)
        return total

    def _put(self, x: Element, place: int) -> Element:
        """At s = the pole, in the ring of the poles alone."""
        ring, count = self.ring, len(self.poles)
        at = ring.root(place - 1) if place else ring.constant(0)
        roots = [*(ring.root(i) for i in range(count)), at]
        own = [ring.exponential(place - 1, k) if place else ring.constant(1) for k in range(len(self.times))]
        exponentials = [ring.exponential(i, k) for i in range(count) for k in range(len(self.times))]
        return x.compose(ring.w, ring.pi, *roots, *exponentials, *own, ctx=ring.context)


def _whole(factor: fmpq_poly) -> tuple[int, ...]:
    """An irreducible polynomial with whole coefficients."""
    scale = lcm(*(int(c.q) for c in factor.coeffs()))
    return tuple(int((c * scale).p) for c in factor.coeffs())


def _by_power(ring: Exponentials, polynomial: Element) -> list[Element]:
    rows: dict[int, dict[tuple[int, ...], Any]] = {}
    for (n, *rest), value in polynomial.to_dict().items():
        rows.setdefault(int(n), {})[(0, *map(int, rest))] = value
    return [ring.context.from_dict(rows.get(n, {})) for n in range(max(rows) + 1)]
