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
from types import MappingProxyType
from typing import Any, TypeAlias

from flint import arb, arb_poly
from sympy import Expr, Symbol

from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.exponentials import Element, Exponentials
from haptisym.kernel.jets import value
from haptisym.kernel.precision import at_rising_precision
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.residues import residues
from haptisym.kernel.schurcohn import Circle, count_on_circle
from haptisym.kernel.states import States

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

    def samples(self, period: Expr, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        """Of each delay the whole samples."""
        numbers = {symbol: value(x) for symbol, x in known.items()}
        return tuple(_floor(lag / period, numbers) for lag, _ in self.terms)


@dataclass(frozen=True)
class SampledLoop:
    """The loop of a plant and a controller D(w) = above/below, w = 1/z, with a clock: 1 + D G = 0, as a polynomial in w.

    A root w in the closed unit disc is a root z = 1/w that does not fade. ``coefficients`` are those of w, ascending.

    >>> from sympy import Integer, Rational
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
    hidden: tuple[int, int] = (0, 0)
    """Roots with |z| > 1 and |z| = 1 that the clock does not see, so that they are in no coefficient."""

    def circle(self) -> Circle:
        """How its roots w = 1/z, the hidden ones as well, lie about the unit circle: certified, or UndecidedError."""
        found = count_on_circle(self)
        return Circle(found.inside + self.hidden[0], found.on + self.hidden[1], found.outside)

    def at(self, values: Mapping[Symbol, Expr]) -> SampledLoop:
        """With numbers in place of symbols, nothing cancelled."""

        def put(row: Numbers) -> tuple[Expr, ...]:
            known = [x.xreplace(values) for x in row]
            while len(known) > 1 and known[-1] == 0:
                known.pop()
            return tuple(known)

        plant = self.plant
        terms = tuple((lag.xreplace(values), put(N)) for lag, N in plant.terms)
        return SampledLoop(
            Plant(put(plant.denominator), terms), self.T.xreplace(values), put(self.above), put(self.below), self.hidden
        )

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
        return self.plant.samples(self.T, known)

    @cached_property
    def is_of_numbers(self) -> bool:
        """Whether no symbol stands in the plant nor in the period."""
        plant = self.plant
        every = (self.T, *plant.denominator, *(x for lag, N in plant.terms for x in (lag, *N)))
        return not any(x.free_symbols for x in every)

    def exact(self) -> list[Element] | None:
        """The same times a number that is not 0; None where the plant holds pi."""
        return None if self._exact is None else self._exact[1]

    def is_zero(self, x: Element) -> bool:
        """Whether a coefficient is 0, exactly."""
        assert self._exact
        return self._exact[0].is_zero(x)

    @cached_property
    def _exact(self) -> tuple[Exponentials, list[Element]] | None:
        lags = [lag - n * self.T for (lag, _), n in zip(self.plant.terms, self.whole, strict=True)]
        if not all(x.is_Rational for x in (self.T, *lags, *self.plant.denominator)):
            return None
        own = tuple((lag, ell, N) for lag, ell, (_, N) in zip(lags, self.whole, self.plant.terms, strict=True))
        return residues(self.plant.denominator, own, self.T, (self.above, self.below))


def pulse(plant: Plant, period: Expr, whole: Sequence[int], known: Mapping[Expr, Ball]) -> tuple[Any, Any]:
    """Denominator and numerator of the pulse transfer function, polynomials in w, in balls."""
    lead, T = expression_ball(plant.denominator[-1], known), expression_ball(period, known)
    Q = [expression_ball(x, known) / lead for x in plant.denominator]
    states = States(Q)
    n, Phi = len(Q) - 1, (states.A * T).exp()
    den, total = _reversed_characteristic(Phi), arb_poly([])
    for (lag, above), ell in zip(plant.terms, whole, strict=True):
        N = [expression_ball(x, known) / lead for x in above]
        N += [arb(0)] * (n + 1 - len(N))
        C = states.row([x - N[n] * q for x, q in zip(N, Q, strict=True)][:n])
        late = expression_ball(lag - ell * period, known)
        own = arb_poly([arb(0), N[n]]) * den + _response(Phi, states.held(T - late), C, den)
        if not late.is_zero():
            before = (states.A * (T - late)).exp() * states.held(late)
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


def _reversed_characteristic(M: Any) -> Any:
    """|1 - w M|."""
    return arb_poly(M.charpoly().coeffs()[::-1])


def _response(Phi: Any, start: Any, C: Any, den: Any) -> Any:
    """w C adj(1 - w Phi) start: |1 - w (Phi - start C)| is the denominator and that."""
    return _reversed_characteristic(Phi - start * C) - den
