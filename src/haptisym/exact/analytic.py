"""Irreducible functions of omega that delays and fractional powers bring, and their certified zeros."""

from __future__ import annotations

from functools import lru_cache, reduce
from typing import Any, TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer, Symbol, pi

from haptisym.errors import UndecidedError
from haptisym.symbols import omega

from .isolation import SeriesFactor, clear_of, isolated
from .reals import Ball, RealNumber, expression_ball
from .rings import Polynomial, PolynomialRing, RationalFunction
from .wavesums import Term, WaveSum
from .zeros import MOST_BITS, around, is_clear


class AnalyticFactor(WaveSum, SeriesFactor):
    """An irreducible function that holds sines, cosines or powers of omega."""

    def steady_sign(self, low: Expr, high: Expr) -> int:
        with flint.ctx.workprec(128):
            value = self.value(arb.union(*around(low, high)))
            return 1 if value > 0 else -1 if value < 0 else 0

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        return isolated(self, self._edge(low, above=True), self._edge(high, above=False))

    def _edge(self, place: Expr, *, above: bool) -> Ball:
        """A dyadic number where a search may start or stop, with no zero between it and the place but at the place itself."""
        if place == 0 and self.orders:
            return _clear_of_zero_with_powers(self)
        order = self.order_at(place)
        if order or place == 0:  # even functions have slope 0 at 0: keep away from it
            return clear_of(self, place, order, above=above)
        with flint.ctx.workprec(128):
            ball = expression_ball(place)
            return ball.lower() if above else ball.upper()

    def order_at(self, place: Expr) -> Any:
        return _order_at(self, place)


@lru_cache(maxsize=1024)
def _order_at(factor: AnalyticFactor, place: Expr) -> Any:
    if place == 0 and factor.orders:
        return min((_exponent(factor, powers, part) for powers, part in _by_powers(factor).items()), key=float)
    with flint.ctx.workprec(128):
        if is_clear(factor.value(expression_ball(place))):
            return 0
    if factor.orders:
        return _order_with_powers(factor, place)
    exact = _exact_waves(factor, place)
    if exact is None:
        factor.sign_at(lambda bits: expression_ball(place))
        return 0
    return _exact_order(factor, place, exact)


def _order_with_powers(factor: AnalyticFactor, place: Expr) -> int:
    """Away from 0: all Taylor coefficients vanish that vanish in every part; the next one must not."""
    least = min(int(part.order_at(place)) for part in _by_powers(factor).values())
    with flint.ctx.workprec(MOST_BITS):
        if is_clear(factor.taylor(expression_ball(place), least)):
            return least
    raise UndecidedError(f"the order of a zero at omega = {place} rad/s")


def _by_powers(factor: AnalyticFactor) -> dict[tuple[int, ...], AnalyticFactor]:
    """The factor as a sum of analytic functions, each times powers omega^alpha."""
    groups: dict[tuple[int, ...], list[Term]] = {}
    for term in factor.terms:
        groups.setdefault(term.powers, []).append(Term(term.turns, (), term.coefficients))
    return {powers: AnalyticFactor(tuple(terms), factor.rates, factor.degrees, ()) for powers, terms in groups.items()}


def _exponent(factor: AnalyticFactor, powers: tuple[int, ...], part: AnalyticFactor) -> Expr:
    """The exponent of omega with which a part begins at 0."""
    return sum((a * n for a, n in zip(factor.orders, powers, strict=True)), Integer(part.order_at(Integer(0))))


def _clear_of_zero_with_powers(factor: AnalyticFactor) -> Ball:
    """A dyadic number above 0, with no zero in between, for a function with powers omega^alpha.

    f = sum over l of omega^(alpha l) A_l with A_l analytic and of exact order m_l: divided by the lowest of all powers
    omega^(alpha l + m_l), what remains tends to a constant at 0, and is enclosed on (0, reach].
    """
    parts = _by_powers(factor)
    exponents = {powers: _exponent(factor, powers, part) for powers, part in parts.items()}
    lowest = min(exponents.values(), key=float)
    with flint.ctx.workprec(128):
        reach = arb(1) / 16
        for _ in range(200):
            piece = arb(0).union(reach)
            total = arb(0)
            for powers, part in parts.items():
                order = part.order_at(Integer(0))
                rise = expression_ball(exponents[powers] - lowest)
                factor_range = arb(1) if exponents[powers] == lowest else arb(0).union((rise * reach.log()).exp())
                total = total + factor_range * part.taylor(piece, order)
            if is_clear(total):
                return reach
            reach = reach / 16
    raise UndecidedError("whether a function vanishes near omega = 0")


_EIGHTHS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
Wave: TypeAlias = tuple[int, int] | None


def _exact_waves(factor: AnalyticFactor, place: Expr) -> list[Wave] | None:
    """Cosine and sine of the half angles, up to a factor, at multiples of an eighth of a turn; None if one is at another angle.

    In all terms of a factor the powers of both add up to the same, so that a common factor is none of the zeros' business. The
    entry of a constant angle is None: its cosine and sine stay symbols.
    """
    if place != 0 and place.is_Rational and any(rate.is_Rational for rate, _ in factor.rates):
        return None  # a rational angle, but 0, is no part of a turn
    found: list[Wave] = []
    for rate, constant in factor.rates:
        eighths = Integer(0) if constant else 2 * rate * place / pi
        if not eighths.is_Integer:
            return None
        found.append(None if constant else _EIGHTHS[int(eighths) % 8])
    return found


def _exact_order(factor: AnalyticFactor, place: Expr, waves: list[Wave]) -> int:
    """The order of the zero at a place where the waves are known exactly: the first derivative that is not zero there."""
    names = [Symbol(f"{kind}{i}") for i in range(len(factor.rates)) for kind in ("cos", "sin")]
    ring = PolynomialRing(omega, functions=names)
    derivative = _in_waves(factor, ring)
    rates = [ring.convert(rate / 2) for rate, _ in factor.rates]
    common = reduce(lambda x, y: x * y, (rate.denominator for rate in rates), ring.constant(1))
    for order in range(_HIGHEST_ORDER):
        if not _at(ring, derivative, place, waves).is_zero:
            return order
        change = common * derivative.derivative(0)
        for i, (rate, (_, constant)) in enumerate(zip(rates, factor.rates, strict=True)):
            if not constant:
                cosine, sine = (ring.context.gens()[2 + 2 * i + n] for n in (0, 1))
                turned = cosine * derivative.derivative(3 + 2 * i) - sine * derivative.derivative(2 + 2 * i)
                change += rate.numerator * (common / rate.denominator) * turned
        derivative = change
    raise UndecidedError(f"the order of a zero at omega = {place} rad/s")


_HIGHEST_ORDER = 200


def _in_waves(factor: AnalyticFactor, ring: PolynomialRing) -> Polynomial:
    terms: dict[tuple[int, ...], int] = {}
    for term in factor.terms:
        waves = [n for k, degree in zip(term.turns, factor.degrees, strict=True) for n in (degree - k, k)]
        for power, row in enumerate(term.coefficients):
            for of_pi, value in enumerate(row):
                if value:
                    terms[(power, of_pi, *waves)] = value
    return ring.context.from_dict(terms)


def _at(ring: PolynomialRing, polynomial: Polynomial, place: Expr, waves: list[Wave]) -> RationalFunction:
    """The value at an exact place, a polynomial in pi (and the constant angles' waves)."""
    where, total = ring.convert(place), ring.zero
    for (power, of_pi, *turns), value in polynomial.to_dict().items():
        if power and place == 0:
            continue
        known, kept = value, [0, int(of_pi)]
        for wave, cosine, sine in zip(waves, turns[::2], turns[1::2], strict=True):
            kept += [int(cosine), int(sine)] if wave is None else [0, 0]
            known = known if wave is None else known * wave[0] ** int(cosine) * wave[1] ** int(sine)
        total = total + ring.function(ring.context.from_dict({tuple(kept): known})) * where ** int(power)
    return total
