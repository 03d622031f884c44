"""Sums of polynomials times sines, cosines and powers of omega: their values and Taylor coefficients in balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, TypeAlias

import flint
from flint import arb, arb_poly, arb_series, fmpz_poly
from sympy import Expr

from .reals import Ball, expression_ball

_TAYLOR_ORDER = 6


@dataclass(frozen=True)
class Term:
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

    terms: tuple[Term, ...]
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

    def series(self, x: Ball, length: int) -> arb_series:
        """Taylor coefficients of the function about every point of a ball: value, slope, half curvature, ..."""
        return _compiled(self, flint.ctx.prec).series(x, length)

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies."""
        return _compiled(self, flint.ctx.prec).over(box)


_Number: TypeAlias = Any  # flint.arb or flint.arb_series: both know sin_cos, log and exp
_Key: TypeAlias = tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Compiled:
    """A sum with balls of one precision for its constants: waves of constant angles are among the coefficients.

    ``rates``, ``degrees``: of the half angles that turn. ``terms``: sine powers, powers of omega^alpha, polynomial.
    """

    rates: tuple[Ball, ...]
    degrees: tuple[int, ...]
    exponents: tuple[Ball, ...]
    terms: tuple[tuple[tuple[int, ...], tuple[int, ...], arb_poly], ...]

    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies."""
        return self._total(x, [p(x) for _, _, p in self.terms])

    def series(self, x: Ball, length: int) -> arb_series:
        """Taylor coefficients of the function about every point of a ball: value, slope, half curvature, ..."""
        cap, flint.ctx.cap = flint.ctx.cap, length  # FLINT cuts series at this length, and what is cut off reads as 0
        try:
            polynomials = [arb_series([p(x) for p in row[:length]], length) for row in self._derivatives]
            return self._total(arb_series([x, 1], length), polynomials)
        finally:
            flint.ctx.cap = cap

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies.

        Taylor's theorem about the middle m, f(m + h) = c_0 + c_1 h + ... + c(xi) h^n, with the last coefficient enclosed over the
        whole ball: tight as soon as the ball is shorter than what the function does, however much its terms cancel.
        """
        about = self.series(box.mid(), _TAYLOR_ORDER)
        last = self.series(box, _TAYLOR_ORDER + 1)[_TAYLOR_ORDER]
        taylor = arb_poly([*(about[i] for i in range(_TAYLOR_ORDER)), last])
        slope = taylor.derivative()
        h = box - box.mid()
        return taylor(h), slope(h), slope.derivative()(h) / 2

    @cached_property
    def _derivatives(self) -> list[list[arb_poly]]:
        """For the polynomial p of each term p, p', p''/2, ...: its Taylor coefficients as functions of where."""
        rows = [[p] for _, _, p in self.terms]
        for row in rows:
            for k in range(1, row[0].degree() + 1):
                row.append(row[-1].derivative() * (arb(1) / k))
        return rows

    def _total(self, at: _Number, polynomials: Sequence[_Number]) -> _Number:
        """The sum of the terms, given the value (or the series) of each one's polynomial."""
        waves = [_Waves(rate * at, degree) for rate, degree in zip(self.rates, self.degrees, strict=True)]
        roots = [_Powers((at.log() * a).exp()) for a in self.exponents]
        total: _Number = 0
        for (turns, powers, _), polynomial in zip(self.terms, polynomials, strict=True):
            term = polynomial
            for wave, k in zip(waves, turns, strict=True):
                term = term * wave[k]
            for root, n in zip(roots, powers, strict=True):
                if n:
                    term = term * root[n]
            total = term + total
        return total


class _Powers(dict[int, Any]):
    """Powers of a number or a series, each computed once and only when it is asked for."""

    def __init__(self, x: _Number) -> None:
        super().__init__({0: x**0, 1: x})

    def __missing__(self, n: int) -> _Number:
        half = self[n // 2]
        self[n] = half * half * self[1] if n % 2 else half * half
        return self[n]


class _Waves(dict[int, Any]):
    """sin^k cos^(degree - k) of a half angle for each k, likewise."""

    def __init__(self, half: _Number, degree: int) -> None:
        super().__init__()
        sine, cosine = half.sin_cos()
        self.degree, self.sines, self.cosines = degree, _Powers(sine), _Powers(cosine)

    def __missing__(self, k: int) -> _Number:
        rest = self.degree - k
        self[k] = self.cosines[rest] if not k else self.sines[k] if not rest else self.sines[k] * self.cosines[rest]
        return self[k]


@lru_cache(maxsize=512)
def _compiled(waves: WaveSum, bits: int) -> Compiled:
    with flint.ctx.workprec(bits):
        halves = [expression_ball(rate) / 2 for rate, _ in waves.rates]
        turning = [i for i, (_, constant) in enumerate(waves.rates) if not constant]
        fixed = {i: _Waves(halves[i], waves.degrees[i]) for i, (_, constant) in enumerate(waves.rates) if constant}
        terms: dict[_Key, arb_poly] = {}
        for term in waves.terms:
            polynomial = arb_poly([fmpz_poly(list(c))(arb.pi()) for c in term.coefficients])
            for i, wave in fixed.items():
                polynomial = polynomial * wave[term.turns[i]]
            key = tuple(term.turns[i] for i in turning), term.powers
            terms[key] = terms[key] + polynomial if key in terms else polynomial
        return Compiled(
            tuple(halves[i] for i in turning),
            tuple(waves.degrees[i] for i in turning),
            tuple(expression_ball(order) for order in waves.orders),
            tuple((*key, polynomial) for key, polynomial in terms.items()),
        )
