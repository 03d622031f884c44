"""The two kinds of irreducible factors of real functions of omega: polynomials, and sums with
sines, cosines and powers of omega, as delays and powers s^alpha bring them.

A ``PolynomialFactor`` in omega^2 (or omega) has coefficients in Z[pi]; Descartes' rule isolates its
roots. An ``AnalyticFactor`` holds sines, cosines or powers of omega: its zeros are found by
subdivision, as it has all Taylor coefficients. Zeros of a polynomial are always all found; an
analytic factor may have tangencies that stay undecided, and gives them as such.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from operator import ne
from typing import Any

import flint
from flint import acb_poly, arb, arb_poly, fmpq, fmpq_poly, fmpz, fmpz_poly
from sympy import Expr, Rational, pi

from haptisym.kernel.budget import Waiting, tick
from haptisym.kernel.delayterms import WaveSum
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.leadingterm import (
    LARGEST_RATIO,
    Direction,
    clear_of_zero,
    exact_directions,
    leading_term,
    order_at_0,
    taylor_coefficients,
)
from haptisym.kernel.reals import (
    MOST_BITS,
    SURE_BITS,
    Ball,
    RealNumber,
    at_rising_precision,
    expression_ball,
)
from haptisym.kernel.rings import PolynomialRing, omega
from haptisym.kernel.zeros import (
    SeriesFactor,
    SmoothFactor,
    Zero,
    clear_of,
    dyadic_ball,
    dyadic_ends,
    is_clear,
    isolated,
    rounded_up,
    sign_of,
    tightened,
)


@dataclass(frozen=True)
class PolynomialFactor(SmoothFactor):
    """An irreducible polynomial in omega^step: its coefficients, ascending, are polynomials in pi
    over the integers.

    ``step`` is 2 (the variable is then W = omega^2) but for factors of functions in which odd
    powers meet sines.
    """

    coefficients: tuple[tuple[int, ...], ...]
    step: int = 2
    is_rational: bool = field(init=False, repr=False, compare=False)
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "is_rational", max(map(len, self.coefficients)) == 1)
        object.__setattr__(self, "_hash", hash((self.coefficients, self.step)))

    def __hash__(self) -> int:
        return self._hash

    @property
    def degree(self) -> int:
        """The degree in omega^step."""
        return len(self.coefficients) - 1

    def value(self, x: Ball) -> Ball:
        return _at_precision(self, flint.ctx.prec)[0](x**self.step)

    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        # Value and slope, orders 0 and 1, are all that Newton's method for a simple zero asks for.
        return [(self.value, self._slope)[n](x) for n in range(start, stop)]

    def _slope(self, x: Ball) -> Ball:
        """A ball around df/d omega, by the chain rule."""
        derivative = _at_precision(self, flint.ctx.prec)[1]
        return derivative(x**self.step) * self.step * x ** (self.step - 1)

    def steady_sign(self, low: Expr, high: Expr) -> int:
        if not self.is_rational:
            return 0
        # Descartes' rule: without a change of sign there is no zero between the ends. The first
        # coefficient is the value at the high end, the last one that at the low end.
        moved = self._moved(*(x.fmpq() for x in dyadic_ends(low, high)))
        signs = {c > 0 for c in moved if c}
        if len(signs) > 1 or not moved[0] or not moved[-1]:
            return 0
        return 1 if signs.pop() else -1

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        if self.is_rational and self.degree > 1:
            return [
                Zero(self, dyadic_ball(a), dyadic_ball(b), i)
                for i, (a, b) in enumerate(self._apart(*dyadic_ends(low, high)))
            ]
        return list(self.positive_roots())

    def _apart(self, low: Ball, high: Ball) -> Iterator[tuple[fmpq, fmpq]]:
        """Intervals with dyadic ends, ascending, each with exactly one zero in it: bisection until
        Descartes' rule gives 0 or 1 (the method of Vincent, Collins and Akritas).

        As an irreducible polynomial has only simple roots, and no rational ones unless it is
        linear, this ends, and no zero is ever at a cut.
        """
        waiting = Waiting([(low.fmpq(), high.fmpq())])
        for a, b in waiting:
            signs = [c > 0 for c in self._moved(a, b) if c]
            changes = sum(map(ne, signs, signs[1:]))
            if changes == 1:
                yield a, b
            elif changes:
                middle = (a + b) / 2
                waiting.add((a, middle), (middle, b))

    def positive_roots(self) -> list[Root]:
        """All positive zeros, ascending."""
        return [Root(self, i) for i in range(len(_roots(self, 128)))]

    def _moved(self, low: fmpq, high: fmpq) -> list[fmpz]:
        """The coefficients in t of p(x) (1 + t)^n at x = low + (high - low)/(1 + t), times a number
        > 0: t > 0 are the values between low and high."""
        start, end = low**self.step, high**self.step
        moved = fmpq_poly([c for (c,) in self.coefficients])(fmpq_poly([start, end - start]))
        turned: fmpz_poly = fmpz_poly(moved.numer().coeffs()[::-1])(_ONE_MORE)
        return [turned[n] for n in range(self.degree + 1)]

    def order_at(self, place: Expr) -> int:
        # Only a linear factor vanishes at a number rational in pi; and none does at 0, as powers of
        # omega are kept apart.
        if self.degree > 1 or place == 0:
            return 0
        if self.is_rational and place.is_Rational:
            return int(self.coefficients[0][0] + self.coefficients[1][0] * place**self.step == 0)
        ring = PolynomialRing(omega)
        x = ring.generators[pi]
        low, high = (
            sum((n * x**i for i, n in enumerate(c)), ring.constant(0)) for c in self.coefficients
        )
        square = ring.convert(place) ** self.step
        return int((low * square.denominator + high * square.numerator).is_zero())

    def isolated(self, bits: int) -> tuple[Ball, ...] | None:
        """Balls around all positive roots in omega^step, ascending; None if the current precision
        is not enough to isolate them."""
        if self.degree == 1:
            low, high = (fmpz_poly(list(c))(arb.pi()) for c in self.coefficients)
            return _positive([-low / high])
        if self.is_rational:
            if len({c[0] > 0 for c in self.coefficients if c[0]}) == 1:
                return ()  # Descartes: without a change of sign there is no positive root
            # Of whole coefficients FLINT knows which roots are real, exactly.
            every = fmpz_poly([c[0] for c in self.coefficients]).complex_roots()
            return _positive([root.real for root, _ in every if root.imag.is_zero()])
        try:
            isolated = _real_ones(acb_poly(_at_precision(self, bits)[0]).roots(maxprec=4 * bits))
        except ValueError:
            return None
        both = _at_precision(self, bits)

        def jet(x: Ball, count: int) -> list[Ball]:
            return [p(x) for p in both[:count]]

        return _positive([tightened(x.lower(), x.upper(), bits, jet) for x in isolated])


@dataclass(frozen=True, repr=False)
class Root(RealNumber):
    """The frequency at which a polynomial factor vanishes, by its ``index``-th positive root in
    omega^step."""

    factor: PolynomialFactor
    index: int

    def _sympy_(self) -> Expr:
        low, *others = (c for (c, *_) in self.factor.coefficients)
        # The root of a linear factor is exact by itself, or a square root.
        if len(others) == 1 and self.factor.is_rational:
            return Rational(-low, others[0]) ** Rational(1, self.factor.step)
        return super()._sympy_()

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            root = _roots(self.factor, rounded_up(bits))[self.index]
            return root.sqrt() if self.factor.step == 2 else root


def polynomial_factors(
    coefficients: list[fmpq], *, in_square: bool = True
) -> tuple[int, int, list[tuple[PolynomialFactor, int]]]:
    """Sign, power of omega and irreducible factors, each with its multiplicity, of a polynomial in
    omega with these coefficients, ascending: factors in omega^2 where it is even and ``in_square``.
    """
    lowest = next(n for n, c in enumerate(coefficients) if c)
    rest, step = coefficients[lowest:], 1
    if in_square and not any(rest[1::2]):
        rest, step = rest[::2], 2
    number, factors = fmpq_poly(rest).factor()
    multiplicities = [
        (PolynomialFactor(tuple((int(c),) for c in f.numer().coeffs()), step), n)
        for f, n in factors
    ]
    return (1 if number > 0 else -1), lowest, multiplicities


@lru_cache(maxsize=1024)
def _at_precision(factor: PolynomialFactor, bits: int) -> tuple[arb_poly, arb_poly]:
    """The polynomial in omega^step with balls for coefficients, and its derivative."""
    with flint.ctx.workprec(bits):
        if factor.is_rational:
            polynomial = arb_poly([c for (c,) in factor.coefficients])
        else:
            polynomial = arb_poly([fmpz_poly(list(c))(arb.pi()) for c in factor.coefficients])
        return polynomial, polynomial.derivative()


_ONE_MORE = fmpz_poly([1, 1])


@lru_cache(maxsize=1024)
def _roots(factor: PolynomialFactor, bits: int) -> tuple[Ball, ...]:
    """Balls around all positive roots in omega^step, ascending, computed with at least that many
    bits."""
    tick()
    roots = at_rising_precision(factor.isolated, bits, SURE_BITS)
    if roots is None:
        raise UndecidedError("whether two roots of a polynomial are equal")
    return roots


def _real_ones(isolated: Iterable[Ball]) -> list[Ball]:
    """The real ones among isolated roots of a real polynomial."""
    # Roots come in conjugate pairs. A ball whose mirror image meets no other ball holds a root that
    # is its own conjugate.
    roots = list(isolated)
    alone = [
        z
        for i, z in enumerate(roots)
        if not any(
            z.real.overlaps(other.real) and (-z.imag).overlaps(other.imag)
            for j, other in enumerate(roots)
            if j != i
        )
    ]
    return [z.real for z in alone if z.imag.contains(0)]


def _positive(roots: Iterable[Ball]) -> tuple[Ball, ...] | None:
    """The positive roots in order; None if two balls overlap, or one holds zero."""
    ordered = sorted(roots, key=lambda ball: ball.mid())
    if not all(is_clear(ball) for ball in ordered):
        return None
    if any(a.overlaps(b) for a, b in pairwise(ordered)):
        return None
    return tuple(ball for ball in ordered if ball > 0)


class AnalyticFactor(WaveSum, SeriesFactor):
    """An irreducible function that holds sines, cosines or powers of omega."""

    def steady_sign(self, low: Expr, high: Expr) -> int:
        with flint.ctx.workprec(128):
            ends = dyadic_ends(low, high)
            box = arb.union(*ends)
            if not self.orders:
                return 0 if low == 0 and self.is_shown_zero_at_0 else sign_of(self.value(box))
            # With a power of omega in every term it vanishes at omega = 0.
            if low == 0 and not any(not any(term.powers) for term in self.terms):
                return 0
            # Powers of omega are positive: where the cofactors of all of them have one sign, the
            # sum has it. Two signs of cofactors at any place end the search before
            # ``cofactor_ranges``, which is dear.
            seen = set[int]()
            for place in (((ends[0] + ends[1]) / 2).mid(), box, *ends):
                signs = set(map(sign_of, self.cofactor_values(place)))
                if place is box and len(signs) == 1 and 0 not in signs:
                    return signs.pop()
                seen |= signs
                if {1, -1} <= seen:
                    return 0
            every = {sign_of(x) for x in self.cofactor_ranges(box).values()}
            return every.pop() if len(every) == 1 else 0

    @property
    def largest_ratio(self) -> float | None:
        return LARGEST_RATIO if self.orders else None

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        with flint.ctx.workprec(128):
            ends = dyadic_ends(low, high)
            first = (ends[1] - ends[0]) / (LARGEST_RATIO if self.orders else 16)
        return isolated(
            self, self._edge(low, first, above=True), self._edge(high, first, above=False)
        )

    def _edge(self, place: Expr, first: Ball, *, above: bool) -> Ball:
        """A dyadic number where a search may start or stop, such that there is no zero between it
        and an end of the band, other than at the end itself."""
        if place == 0 and self.orders:
            return clear_of_zero(self, first)
        # Even functions have slope 0 at omega = 0, where no piece would be monotone.
        order = self.order_at(place)
        if order or place == 0:
            return clear_of(self, place, order, first, above=above)
        with flint.ctx.workprec(128):
            ball = expression_ball(place)
            return ball.lower() if above else ball.upper()

    def order_at(self, place: Expr) -> Any:
        return _order_at(self, place)

    def shown_sign(self, place: Expr) -> int:
        return _shown_sign(self, place)


@lru_cache(maxsize=1024)
def _shown_sign(factor: AnalyticFactor, place: Expr) -> int:
    """The sign at an exact number if 128 bits show it, else 0."""
    with flint.ctx.workprec(128):
        return sign_of(factor.value(expression_ball(place)))


@lru_cache(maxsize=1024)
def _order_at(factor: AnalyticFactor, place: Expr) -> Any:
    """The order of the zero at an exact number, by the quickest way that decides it; UndecidedError
    where none does."""
    if place == 0 and factor.orders:
        return leading_term(factor).exponent
    if place == 0 and not any(constant for _, constant in factor.rates):
        if not factor.is_shown_zero_at_0:
            return 0
        if (order := order_at_0(factor)) is not None:
            return order
    if _shown_sign(factor, place):
        return 0
    if factor.orders:
        return _order_with_powers(factor, place)
    exact = exact_directions(factor, place)
    # Where no exact value is known only a sign can decide, which proves that there is no zero.
    if exact is None:
        factor.sign_at(lambda bits: expression_ball(place))
        return 0
    return _exact_order(factor, place, exact)


def _order_with_powers(factor: AnalyticFactor, place: Expr) -> int:
    """The order of a zero away from omega = 0 of a factor with powers of omega; UndecidedError
    where cofactors that are not zero may cancel."""
    # Taylor coefficients vanish below the least order of all cofactors. If the next one is clear of
    # 0, that is the order.
    parts = factor.cofactors().values()
    least = min(AnalyticFactor(p.terms, p.rates, p.degrees, ()).order_at(place) for p in parts)
    with flint.ctx.workprec(MOST_BITS):
        if is_clear(factor.taylor(expression_ball(place), least)):
            return int(least)
    raise UndecidedError(f"the order of a zero at omega = {place} rad/s")


def _exact_order(factor: AnalyticFactor, place: Expr, waves: list[Direction]) -> int:
    """The order of the zero at a place where the waves are known exactly: the first derivative that
    is not zero there."""
    for order, coefficient in zip(
        range(_HIGHEST_ORDER), taylor_coefficients(factor, place, waves), strict=False
    ):
        if not coefficient.is_zero:
            return order
    raise UndecidedError(f"the order of a zero at omega = {place} rad/s")


# Taylor coefficients that are tried before the order of a zero is given up.
_HIGHEST_ORDER = 200
