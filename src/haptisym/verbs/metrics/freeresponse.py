"""The free response: displaced and let go, how the environment swings back, and how what is felt instead would.

With no force at the hand H_perc(s) X = 0: the motion is made of the zeros of H_perc. Where one pair -sigma +- j omega_d
outlasts all others, the response to a release from rest at A_d is that pair's,

    x(t) = A_d exp(-sigma t) (cos omega_d t + (sigma/omega_d) sin omega_d t),

which first crosses zero at P_0 = (pi - atan(omega_d/sigma))/omega_d, has the period P = 2 pi/omega_d and the overshoots
A_n = A_d exp(-n pi sigma/omega_d). Tolerances of 14 CFR Part 60: P_0 10 %, P_1 20 %, each A_n 10 % of A_1, and the same
number of overshoots above 5 % of A_d to within one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from typing import Any

import flint
from flint import acb, acb_poly, arb
from sympy import Rational

from haptisym.kernel.precision import SURE_BITS, at_rising_precision
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in
from haptisym.kernel.zeros import sign_of
from haptisym.model.distortion import Distortion

OUTLASTS = 3
"""How many times as fast as the dominant pair every other zero must decay; a rule of ours, which Part 60 does not give."""
_BITS = (64, 256, 1024)
_SIGNIFICANT = arb("0.05")
_MOST_OVERSHOOTS = 1000  # with less damping than that the count says no more


@dataclass(frozen=True, repr=False)
class Swing(RealNumber):
    """A number that follows from sigma and omega_d of a dominant pair; ``function``: with a name, so that it can be copied."""

    pair: ComplexPair
    function: Callable[[Ball, Ball], Ball] = field(repr=False)

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits + 32):
            zero = self.pair.zero(bits + 32)
            return self.function(-zero.real, zero.imag)


def _sigma(sigma: Ball, _: Ball) -> Ball:
    return sigma


def _omega_d(_: Ball, omega: Ball) -> Ball:
    return omega


def _first_crossing(sigma: Ball, omega: Ball) -> Ball:
    return (arb.pi() - (omega / sigma).atan()) / omega


def _period(_: Ball, omega: Ball) -> Ball:
    return 2 * arb.pi() / omega


def _overshoot(n: int, sigma: Ball, omega: Ball) -> Ball:
    return (-n * arb.pi() * sigma / omega).exp()


@dataclass(frozen=True)
class ComplexPair:
    """The dominant pair of complex zeros -sigma +- j omega_d of a polynomial, its coefficients ascending. Certified."""

    coefficients: tuple[Any, ...] = field(repr=False)

    def zero(self, bits: int) -> Any:
        """A ball (flint ``acb``) around the zero above the real axis."""
        return next(x for x in _zeros(self.coefficients, bits) if x.imag > 0)

    @cached_property
    def sigma(self) -> Swing:
        """The real part, 1/s."""
        return Swing(self, _sigma)

    @cached_property
    def omega_d(self) -> Swing:
        """The imaginary part, rad/s."""
        return Swing(self, _omega_d)

    @cached_property
    def first_crossing(self) -> Swing:
        """P_0, s."""
        return Swing(self, _first_crossing)

    @cached_property
    def period(self) -> Swing:
        """P_n, s, the same for every n."""
        return Swing(self, _period)

    def overshoot(self, n: int) -> Swing:
        """A_n/A_d."""
        return Swing(self, partial(_overshoot, n))

    @cached_property
    def significant(self) -> int:
        """How many overshoots are larger than 5 % of A_d."""
        counts = range(_MOST_OVERSHOOTS)
        return next((n for n in counts if not self.overshoot(n + 1).ball(256) > _SIGNIFICANT), _MOST_OVERSHOOTS)


@lru_cache(maxsize=64)
def _zeros(coefficients: tuple[Any, ...], bits: int) -> tuple[Any, ...]:
    """Balls around the simple zeros of a polynomial, the slowest first; more precision until they are apart."""

    def apart(working: int) -> tuple[Any, ...] | None:
        polynomial = acb_poly([acb(expression_ball(c)) for c in coefficients])
        try:
            found = polynomial.roots(tol=arb(2) ** (32 - working // 2), maxprec=2 * working + 128)
        except ValueError:
            return None
        if len(found) < len(coefficients) - 1:
            return None
        return tuple(sorted(found, key=lambda x: (-float(x.real.mid()), -float(x.imag.mid()))))

    return at_rising_precision(apart, 2 * bits + 64, SURE_BITS) or ()


@dataclass(frozen=True)
class Check:
    """One tolerance: what the environment does, what is felt instead, and whether that is close enough."""

    name: str
    environment: RealNumber | int
    perceived: RealNumber | int
    unit: str
    tolerance: str
    passes: bool


@dataclass(frozen=True)
class FreeResponse:
    """The test's checks; or why there are none (``refused``). ``blind``: H_perc has the very zeros of H_env."""

    checks: tuple[Check, ...]
    refused: str
    blind: bool

    @property
    def passes(self) -> bool | None:
        """Whether every tolerance is kept; None where the test is not offered."""
        return all(check.passes for check in self.checks) if self.checks else None


def free_response(d: Distortion) -> FreeResponse:
    """The free-response test of what is felt against the environment, all verdicts proven.

    Offered where both have a dominant complex pair of zeros, finitely many zeros in all; otherwise ``refused`` says why. A
    delay in series leaves the zeros as they are; one that enters them makes infinitely many.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = free_response(load_scene("fu2019").distortion())
    >>> found.passes, found.blind, found.checks[0].environment.digits(5)
    (True, True, '0.35015')
    """
    blind = _same_zeros(d.env, d.perc)
    pairs = []
    for name, dynamics in (("environment", d.env), ("perceived dynamics", d.perc)):
        pair = _dominant(dynamics)
        if isinstance(pair, str):
            return FreeResponse((), f"{pair} (in the {name})", blind)
        pairs.append(pair)
    return FreeResponse(tuple(_checks(*pairs)), "", blind)


def _same_zeros(one: RationalFunction, other: RationalFunction) -> bool:
    a, b = (_own(x) for x in (one, other))
    return bool((a / a.leading_coefficient()) == (b / b.leading_coefficient()))


def _own(dynamics: RationalFunction) -> Polynomial:
    """The numerator without delays that all its terms share, which have no zeros."""
    return dynamics.ring.without_common_functions(dynamics.reduced().numerator)[1]


def _dominant(dynamics: RationalFunction) -> ComplexPair | str:
    """The dominant pair, or why there is none."""
    ring, numerator = dynamics.ring, _own(dynamics)
    if any(degree_in([numerator], i) for i in range(ring.size, len(ring.meanings))):
        return "not offered: with delays, powers s^alpha or friction among the zeros they are not finitely many"
    if degree_in([numerator.gcd(numerator.derivative(0))], 0):
        return "not offered: a zero is repeated"
    coefficients = tuple(ring.coefficients(numerator))
    for bits in _BITS:
        zeros = _zeros(coefficients, bits)
        if zeros and any(x.real >= 0 for x in zeros):
            return "not offered: the free response does not die out"
        above = [x for x in zeros if x.imag > 0]
        others = [x for x in zeros if x not in above[:1] and not (above and x.conjugate().overlaps(above[0]))]
        if above and above[0].real < 0 and all(x.real < OUTLASTS * above[0].real for x in others):
            return ComplexPair(coefficients)
    if not above:
        return "not offered: no zero is complex, so that nothing swings"
    return f"not offered: no complex pair of zeros decays {OUTLASTS} times as slowly as every other zero"


def _checks(env: ComplexPair, perc: ComplexPair) -> list[Check]:
    count, own = env.significant, perc.significant
    return [
        _ratio_check("P_0, first zero crossing", env.first_crossing, perc.first_crossing, 10),
        _ratio_check("P_1, period", env.period, perc.period, 20),
        *(_overshoot_check(n, env, perc) for n in range(1, min(max(count, own, 1), 3) + 1)),
        *([_rest(env, perc, max(count, own))] if max(count, own) > 3 else []),
        Check("overshoots above 5 % of A_d", count, own, "", "the same number to within 1", abs(count - own) <= 1),
    ]


def _ratio_check(name: str, env: RealNumber, perc: RealNumber, percent: int) -> Check:
    passes = _at_most(lambda bits: abs(perc.ball(bits) / env.ball(bits) - 1), Rational(percent, 100))
    return Check(name, env, perc, "s", f"{percent} %", passes)


def _overshoot_check(n: int, env: ComplexPair, perc: ComplexPair) -> Check:
    return Check(f"A_{n}/A_d", env.overshoot(n), perc.overshoot(n), "", "10 % of A_1", _close(n, env, perc))


def _rest(env: ComplexPair, perc: ComplexPair, count: int) -> Check:
    """All further significant overshoots in one row, with the numbers of the first of them."""
    passes = all(_close(n, env, perc) for n in range(4, count + 1))
    return Check(f"A_4/A_d to A_{count}/A_d", env.overshoot(4), perc.overshoot(4), "", "10 % of A_1", passes)


def _close(n: int, env: ComplexPair, perc: ComplexPair) -> bool:
    def off(bits: int) -> Ball:
        return abs(perc.overshoot(n).ball(bits) - env.overshoot(n).ball(bits)) / env.overshoot(1).ball(bits)

    return _at_most(off, Rational(1, 10))


def _at_most(value: Callable[[int], Ball], limit: Rational) -> bool:
    """Whether a number is at most a limit; one that cannot be told from it at the last precision is not."""
    return at_rising_precision(lambda bits: -sign_of(value(bits) - expression_ball(limit)) or None, 64) == 1
