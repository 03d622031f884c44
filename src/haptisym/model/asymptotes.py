"""The leading terms of a dynamics at low and at high frequency: its *asymptotes*, and the
stiffness, damping and mass that a slow hand feels.

A dynamics is a quotient of polynomials in s, pi, parameters and delays exp(-s tau), here with exact
coefficients. Its series in ascending powers of s (at 0), or in descending ones (at infinity), is

    H(s) = h_n s^n + h_(n+1) s^(n+1) + ...,      n whole, h_n not 0,

found by division of two power series, each delay being its Taylor series. On s = j omega the terms
with even powers are real and those with odd powers imaginary, so that the first even and the first
odd power that do not vanish lead Re H and Im H.

Begin with ``asymptote`` and ``low_frequency``. SceneError where there is no such series: with
powers s^alpha, with delays at infinity, or where the first 24 coefficients vanish.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial
from math import factorial
from typing import Any, NamedTuple, TypeAlias

from sympy import Add, Expr, Integer, Mul, Rational, oo, pi

from haptisym.kernel.dynamics import Ring, on_axis, ring_of
from haptisym.kernel.errors import SceneError, quoted
from haptisym.kernel.objects import viewed
from haptisym.kernel.rings import Polynomial, RationalFunction, omega, s

# How many coefficients of numerator and denominator an expansion looks at before it gives up: far
# more than vanish in any scene.
_MOST_COEFFICIENTS = 24
# After this many coefficients without a leading term of Re or Im, the part is tested for being 0.
_COEFFICIENTS_BEFORE_TEST = 8
# Terms of a coefficient up to which it is factored for the reader.
_MOST_FACTORED = 16


class Asymptote(NamedTuple):
    """The leading terms of dH(s), of Re dH and of Im dH in omega."""

    distortion: Expr
    real: Expr
    imag: Expr

    def _repr_latex_(self) -> str | None:
        return viewed(self, "latex")


class LowFrequency(NamedTuple):
    """The perceived dynamics of slow motions: H_perc(s) = stiffness + damping s + mass s^2 + terms
    of higher order."""

    stiffness: Expr
    damping: Expr
    mass: Expr

    def _repr_latex_(self) -> str | None:
        return viewed(self, "latex")


def asymptote(difference: RationalFunction, at: Any) -> Asymptote:
    """The leading terms of dH(s), Re dH and Im dH as omega tends to ``at``, 0 or oo; 0 for one that
    is 0 everywhere. SceneError where an expansion in powers of s does not exist or does not show a
    leading term within ``_MOST_COEFFICIENTS``."""
    if at not in (0, oo):
        raise SceneError(f"at: {quoted(at)}: give 0 or oo")
    if at == oo and ring_of(difference).lags:
        raise SceneError("at = oo: with a delay there is no leading term")
    if difference.is_zero:
        return Asymptote(Integer(0), Integer(0), Integer(0))
    # Of dH, Re dH and Im dH, in this order; None until it is known.
    leading: list[Expr | None] = [None, None, None]
    for n, (power, h) in enumerate(_expansion(difference, at)):
        # A part that does not come soon may vanish at all frequencies, and then never comes. That
        # is asked late, as Re and Im in lowest terms take longer than some coefficients.
        if n == _COEFFICIENTS_BEFORE_TEST:
            exact = on_axis(difference)
            if exact.raw_real.is_zero:
                leading[1] = Integer(0)
            if exact.raw_imag.is_zero:
                leading[2] = Integer(0)
        if h != 0:
            # (j omega)^n = (-1)^(n//2) omega^n, times j for an odd n, whose term belongs to Im; of
            # a negative n too. Python's -1 to such a power would be a float.
            sign = -1 if power // 2 % 2 else 1
            part = 1 + power % 2
            if leading[0] is None:
                leading[0] = h * s**power
            if leading[part] is None:
                leading[part] = sign * h * omega**power
        if None not in leading:
            return Asymptote(*leading)
    raise SceneError(f"no leading term up to order {_MOST_COEFFICIENTS - 1}")


def low_frequency(perceived: RationalFunction) -> LowFrequency:
    """Stiffness, damping and mass at low frequency: the coefficients of s^0, s^1 and s^2 of H_perc.
    SceneError where H_perc has a pole at s = 0."""
    if perceived.is_zero:
        return LowFrequency(Integer(0), Integer(0), Integer(0))
    coefficients = {0: Integer(0), 1: Integer(0), 2: Integer(0)}
    for power, h in _expansion(perceived, 0):
        if power < 0 and h != 0:
            raise SceneError(
                "H_perc is infinite at rest: it has no stiffness, damping and mass there"
            )
        if power > 2:
            break
        if power >= 0:
            coefficients[power] = h
    return LowFrequency(*coefficients.values())


def _expansion(dynamics: RationalFunction, at: Any) -> Iterator[tuple[int, Expr]]:
    """Yield powers of s with their coefficients in the series of a dynamics at 0 (ascending) or oo
    (descending), from the leading one on. Exact: a delay at 0 is its Taylor series.

    SceneError for a display with fractional powers of s.
    """
    ring = ring_of(dynamics)
    if ring.orders:
        raise SceneError("a display with fractional powers of s has no leading term")
    descending = at == oo
    parts = (dynamics.numerator, dynamics.denominator)
    series = [_Coefficients(p, ring, descending=descending) for p in parts]
    # How many coefficients vanish before the first of each part.
    skipped = []
    for coefficients in series:
        indices = (n for n in range(_MOST_COEFFICIENTS) if coefficients(n) != 0)
        skipped.append(next(indices, _MOST_COEFFICIENTS))
    if max(skipped) == _MOST_COEFFICIENTS:
        raise SceneError(f"no leading term up to order {_MOST_COEFFICIENTS - 1}")
    numerator = partial(series[0].from_, skipped[0])
    denominator = partial(series[1].from_, skipped[1])
    first = skipped[0] - skipped[1]
    if descending:
        degrees = [max(int(exponents[0]) for exponents in p.monoms()) for p in parts]
        first = degrees[0] - degrees[1] - first
    # Over a leading sum each coefficient is a quotient that must be reduced in a ring to stay
    # short; over a single product nothing has to be brought to one fraction.
    divide = _divided_in_ring if denominator(0).is_Add else _divided_by_product
    count = _MOST_COEFFICIENTS - max(skipped)
    for n, coefficient in enumerate(divide(numerator, denominator, ring, count)):
        yield (first - n if descending else first + n), coefficient


_Series: TypeAlias = Callable[[int], Expr]
"""A power series in s or 1/s: its n-th coefficient, n = 0, 1, ...; coefficient 0 is not 0."""


def _divided_by_product(
    numerator: _Series, denominator: _Series, _: Ring, count: int
) -> Iterator[Expr]:
    """Yield the first coefficients of a quotient of series whose denominator begins with one
    product, as of a chain of lags; nothing is brought to one fraction."""
    # q_n = a_n/b_0 - sum over i < n of q_i b_(n-i)/b_0: division of power series
    ratios: list[Expr] = []
    quotient: list[Expr] = []
    for n in range(count):
        ratios.append((denominator(n) / denominator(0)).expand())
        earlier = [q * ratios[n - i] for i, q in enumerate(quotient)]
        q_n = (numerator(n) / denominator(0) - Add(*earlier)).expand()
        quotient.append(q_n)
        is_short = len(Add.make_args(q_n)) <= _MOST_FACTORED
        yield q_n.factor() if is_short else q_n


def _divided_in_ring(
    numerator: _Series, denominator: _Series, ring: Ring, count: int
) -> Iterator[Expr]:
    """Yield the first coefficients of a quotient of two series, each in lowest terms, in a ring of
    the parameters and lags (delays in s)."""
    of_parameters = Ring.of([*ring.symbols, *ring.lags, pi])
    divisor: list[RationalFunction] = []
    quotient: list[RationalFunction] = []
    for n in range(count):
        divisor.append(of_parameters.convert(denominator(n)))
        remainder = of_parameters.convert(numerator(n))
        for i, q in enumerate(quotient):
            remainder = remainder - q * divisor[n - i]
        q_n = (remainder / divisor[0]).reduced()
        quotient.append(q_n)
        is_short = len(q_n.numerator) + len(q_n.denominator) <= _MOST_FACTORED
        yield q_n.factored() if is_short else q_n.expression()


class _Coefficients:
    """The coefficients of a polynomial in s and delays as a series in s, expanded: number n is that
    of s^n, each delay exp(-s tau) being its Taylor series; or, ``descending`` and without delays,
    that of the n-th power below the highest."""

    def __init__(self, polynomial: Polynomial, ring: Ring, *, descending: bool) -> None:
        self.ring = ring
        # Monomials, as exponents and value, by the first coefficient to which they add. The ring's
        # generators in order: s, pi, symbols, delays.
        self.monomials: dict[int, list[tuple[list[int], Any]]] = {}
        highest = max(int(exponents[0]) for exponents in polynomial.monoms())
        for exponents, value in polynomial.to_dict().items():
            powers = [int(x) for x in exponents]
            of_s = powers[0]
            index = highest - of_s if descending else of_s
            self.monomials.setdefault(index, []).append((powers, value))

    def from_(self, start: int, n: int) -> Expr:
        """The n-th coefficient after the one of index ``start``."""
        return self(start + n)

    @cache  # noqa: B019 - as short-lived as the question
    def __call__(self, n: int) -> Expr:
        ring = self.ring
        terms = []
        for index, monomials in self.monomials.items():
            if index > n:
                continue
            for powers, value in monomials:
                # A monomial is s^e pi^e ... times delays exp(-s lag). It adds to s^n by the term of
                # order n - e of the delays' series; without a delay only to its own power.
                of_symbols, of_delays = powers[2 : ring.size], powers[ring.size :]
                lag = Add(*(m * x for x, m in zip(ring.lags, of_delays, strict=False)))
                order = n - index
                if order > 0 and lag == 0:
                    continue
                taylor = (-lag) ** order / factorial(order)
                factors = [x**m for x, m in zip(ring.symbols, of_symbols, strict=True)]
                number = Rational(int(value.p), int(value.q))
                terms.append(Mul(number, pi ** powers[1], *factors, taylor))
        return Add(*terms).expand()
