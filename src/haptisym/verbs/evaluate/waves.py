"""Factors with sines and cosines, as delays bring them: their signs between two frequencies, as a certificate shows them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from math import comb, factorial
from typing import Any, TypeAlias

import flint
from flint import arb, arb_poly, fmpq, fmpq_poly

from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.rings import Polynomial

Rows: TypeAlias = tuple[tuple[int, ...], ...]
"""The coefficients of a polynomial, ascending, each as those of ascending powers of pi."""
Turns: TypeAlias = tuple[int, ...]

ORDER = 14  # of Taylor's sums in a cell, as a checker has it
_MOST = 40
_MARGIN = 1e-6  # so that a checker that rounds otherwise finds the same signs
_BITS = 280  # a checker computes with 80 digits


@dataclass(frozen=True)
class WaveFactor:
    """The sum over ``terms`` of p(omega) prod sin(omega tau_i/2)^k_i cos(omega tau_i/2)^(n_i - k_i), the n_i being ``waves``."""

    terms: tuple[tuple[Turns, Rows], ...]
    waves: Turns
    delays: tuple[Fraction, ...]

    def moved(self, low: Fraction, high: Fraction) -> tuple[int, ...] | None:
        """Signs whose changes are the zeros between two numbers, behind as many zeros as the order at 0; None where not shown."""
        with flint.ctx.workprec(_BITS):
            first, step = 0 if low else self.order_at_0, high - low
            here, there = self._series(low, low, step), self._series(low, high, step)
            model = [*(here[n] for n in range(ORDER)), there[ORDER] * arb(1, _MARGIN)]
            if side := _side(model[first:]):
                return (*[0] * first, side)
            if first or not _side([n * c for n, c in enumerate(model)][1:]):
                return None
            ends = model[0], sum(model, arb(0))
            return None if any(x.contains(0) for x in ends) else tuple(1 if x > 0 else -1 for x in ends)

    def sign_at(self, x: Fraction) -> int:
        """The sign at a number >= 0; 0 where it is zero, or open."""
        with flint.ctx.workprec(_BITS):
            return _side([self._series(x, x, Fraction(0), order=0)[0]])

    def _series(self, low: Fraction, high: Fraction, step: Fraction, order: int = ORDER) -> Any:
        """Balls that hold h^n f^(n)/n! for the step h, n up to ``order``, wherever between two numbers."""
        omega, tables = _place(self.delays, low, high, step, order)
        total = arb_poly([0])
        for turns, own in self._balls:
            term = sum((x * omega[n] for n, x in own), arb_poly([0]))
            for (sines, cosines), k, n in zip(tables, turns, self.waves, strict=True):
                for wave, power in ((sines, k), (cosines, n - k)):
                    term = (term * wave[power]).truncate(order + 1) if power else term
            total = total + term
        return total

    @cached_property
    def _balls(self) -> list[tuple[Turns, list[tuple[int, Any]]]]:
        """The coefficients that are not zero, with pi in them, and their powers of omega."""
        with flint.ctx.workprec(_BITS):
            powers = Powers(arb.pi())
            return [
                (
                    turns,
                    [
                        (n, sum((c * powers[k] for k, c in enumerate(row)), arb(0)))
                        for n, row in enumerate(own)
                        if any(row)
                    ],
                )
                for turns, own in self.terms
            ]

    @cached_property
    def order_at_0(self) -> int:
        """The order of the zero at 0, from Taylor's series with exact coefficients."""
        total: dict[int, fmpq_poly] = {}
        tables = [[Powers(x, lambda p: p.truncate(ORDER)) for x in _series(tau)] for tau in self.delays]
        for turns, rows in self.terms:
            wave = fmpq_poly([1])
            for (cosines, sines), k, n in zip(tables, turns, self.waves, strict=True):
                wave = (wave * cosines[n - k] * sines[k]).truncate(ORDER)
            for q in range(max(map(len, rows))):
                column = fmpq_poly([row[q] if q < len(row) else 0 for row in rows])
                total[q] = total.get(q, fmpq_poly([0])) + (column * wave).truncate(ORDER)
        found = [n for n in range(ORDER) if any(p[n] for p in total.values())]
        if not found:
            raise UndecidedError("the order of a zero at omega = 0, of a function in a certificate")
        return found[0]

    def told(self) -> dict[str, Any]:
        """As a certificate tells it."""
        terms = [[list(turns), [[str(n) for n in row] for row in rows]] for turns, rows in self.terms]
        return {"waves": list(self.waves), "terms": terms}


def _rows(coefficients: Mapping[tuple[int, int], int]) -> Rows:
    """Ascending in omega, each ascending in pi."""
    size = max((n for n, _ in coefficients), default=0) + 1
    return tuple(
        tuple(coefficients.get((n, q), 0) for q in range(max((k for m, k in coefficients if m == n), default=0) + 1))
        for n in range(size)
    )


def _ball(x: Fraction) -> Any:
    return arb(fmpq(x.numerator, x.denominator))


def _about(low: Fraction, high: Fraction) -> Any:
    return _ball((low + high) / 2) + arb(0, 1) * _ball((high - low) / 2)


class Powers:
    """Those of something, each computed once; ``cut`` : what becomes of a product."""

    def __init__(self, x: Any, cut: Callable[[Any], Any] = lambda x: x) -> None:
        self._x, self._cut, self._found = x, cut, [x**0]

    def __getitem__(self, n: int) -> Any:
        while len(self._found) <= n:
            self._found.append(self._cut(self._found[-1] * self._x))
        return self._found[n]


@lru_cache(maxsize=16)
def _place(
    delays: tuple[Fraction, ...], low: Fraction, high: Fraction, step: Fraction, order: int
) -> tuple[Powers, list[tuple[Powers, Powers]]]:
    """Series of omega, and of sine and cosine of each omega tau/2, bounded as a checker does it: no slope is above 1."""

    def powers(terms: list[Any]) -> Powers:
        return Powers(arb_poly(terms[: order + 1]), lambda p: p.truncate(order + 1))

    tables = []
    for tau in delays:
        rate = _ball(tau / 2)
        reach = arb(0, 1) * _ball((high - low) / 2) * rate
        sine, cosine = (x + reach for x in (_ball((low + high) / 2) * rate).sin_cos())
        ahead, weights = _ball(step) * rate, [arb(1)]
        for n in range(order):
            weights.append(weights[-1] * ahead / (n + 1))
        turns = [cosine, -sine, -cosine, sine]
        sines, cosines = (powers([turns[(n + i) % 4] * w for n, w in enumerate(weights)]) for i in (3, 0))
        tables.append((sines, cosines))
    return powers([_about(low, high), _ball(step)]), tables


def _series(tau: Fraction) -> tuple[fmpq_poly, fmpq_poly]:
    rate = fmpq(tau.numerator, 2 * tau.denominator)
    terms = [rate**n / factorial(n) for n in range(ORDER)]
    found = [fmpq_poly([(1, 0, -1, 0)[(n + i) % 4] * c for n, c in enumerate(terms)]) for i in (0, 3)]
    return found[0], found[1]


def _side(model: Sequence[Any]) -> int:
    """The sign for all v from 0 to 1, if Bernstein's coefficients show it."""
    n = len(model) - 1
    found = [sum((comb(n - i, j - i) * model[i] for i in range(j + 1)), arb(0)) for j in range(n + 1)]
    return all(x > 0 for x in found) - all(x < 0 for x in found)


def wave_factor(factor: Polynomial, first: int, delays: tuple[Fraction, ...]) -> WaveFactor:
    """A polynomial made homogeneous in cosine and sine of half angles. Tangents begin at ``first``, the last one's first."""
    places, terms = slice(first, first + len(delays)), dict[Turns, dict[tuple[int, int], int]]()
    waves = tuple(int(n) for n in factor.degrees()[places][::-1])
    if max(waves) > _MOST:
        raise SceneError(f"a certificate has room for delays that are at most about {_MOST} times a common one")
    for exponents, value in factor.to_dict().items():
        own = [int(n) for n in exponents]
        terms.setdefault(tuple(own[places][::-1]), {})[own[0], own[1]] = int(value.p)
    return WaveFactor(tuple((turns, _rows(own)) for turns, own in sorted(terms.items())), waves, delays)


def cosine_factor(i: int, delays: tuple[Fraction, ...]) -> WaveFactor:
    """cos(omega tau/2) of one of the delays."""
    turns = tuple(0 for _ in delays)
    return WaveFactor(((turns, ((1,),)),), tuple(int(k == i) for k in range(len(delays))), delays)
