"""The free response: displaced, held until all rests, and let go; how the environment swings back,
and what is felt instead.

The hand holds A_d with the force H(0) A_d, which it takes away at t = 0: with H = N/D

    x(t)/A_d = 1 - L^-1[H(0) D(s)/(s N(s))] = L^-1[(N(s) - H(0) D(s))/(s N(s))],

a finite sum of t^k exp(p t) over the zeros p of N, with exact coefficients: where it passes a
level, and its extrema, are certified zeros. The whole response is judged, not its slowest pair. 14
CFR Part 60, static and dynamic control checks:

* Table A2A, 2.b (aeroplanes). Underdamped: P_0, from 90 % of A_d to the first zero crossing, within
  10 %; each period P_n after it within 10 (n + 1) %; each overshoot above 5 % of A_d within 10 % of
  the first, A_1; as many of them to within one.
  Overdamped: the time from 90 % to 10 % of A_d within 10 %.
* Table C2A, 2.a.5 (helicopters): the same, but P_0 is the time of the first zero crossing from the
  release on, and second and later overshoots are each within 20 %.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from enum import Enum
from fractions import Fraction
from functools import cached_property, lru_cache
from math import comb, factorial, perm, pi
from typing import Any

import flint
from flint import acb, acb_poly, arb, fmpq
from sympy import Expr, Rational

from haptisym.kernel.budget import Waiting, tick
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import (
    SURE_BITS,
    Ball,
    ExactNumber,
    RealNumber,
    at_rising_precision,
    expression_ball,
)
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in
from haptisym.kernel.zeros import sign_of
from haptisym.model.distortion import Distortion

_BITS = 256  # of all signs; what they do not tell stays open
_FINEST = Fraction(1, 1 << 60)  # of the time looked at
_SIGNIFICANT = Rational(1, 20)
# Overshoots above 5 % of A_d: more mean a damping ratio below some 2 %. No control that is judged
# by these tables is damped so little, and each overshoot takes time.
_MOST_SWINGS = 60

Numbers = tuple[Expr, ...]


class FlightRule(Enum):
    """A table of 14 CFR Part 60."""

    AEROPLANE = "A2A"
    HELICOPTER = "C2A"


@dataclass(frozen=True)
class Motion:
    """The motion x(t)/A_d after a release: its transform is ``above`` over the product of the
    ``factors``, each to its power; coefficients ascending.

    ``order`` : of the first derivative that is not 0 just after t = 0. With order 0 x itself leaps,
    as a part of the force ends at once.
    """

    above: Numbers = field(repr=False)
    factors: tuple[tuple[Numbers, int], ...] = field(repr=False)
    order: int

    def value(self, t: Ball, order: int = 0) -> Ball:
        """Return a derivative at a time, s; the motion itself for order 0."""
        terms = (
            q * _derived(k, order, acb(t), p) * (p * acb(t)).exp()
            for p, row in self._terms
            for k, q in enumerate(row)
        )
        return sum(terms, acb(0)).real

    def most(self, low: Ball, high: Ball, order: int = 0) -> Ball:
        """Bound the modulus of a derivative between two times, s."""
        # Of each term the polynomial in t grows and the exponential decays: the one is taken at the
        # end, the other at the beginning.
        return sum(
            (
                abs(q) * _derived(k, order, high, abs(p)) * (p.real * low).exp()
                for p, row in self._terms
                for k, q in enumerate(row)
            ),
            arb(0),
        )

    @cached_property
    def _terms(self) -> list[tuple[Any, list[Any]]]:
        """Each zero p with the coefficients of exp(p t), t exp(p t), ...: the partial fractions
        of the transform."""
        terms = []
        with flint.ctx.workprec(2 * _BITS):
            above = acb_poly([acb(expression_ball(x)) for x in self.above])
            rows = [
                (acb_poly([acb(expression_ball(x)) for x in row]), n) for row, n in self.factors
            ]
            for i, (factor, times) in enumerate(rows):
                for p in zeros(self.factors[i][0], 2 * _BITS):
                    # In s = p + u: the factor is u times what is left without its constant, which
                    # is exactly 0. The coefficient of u^j in all the rest is that of
                    # 1/(s - p)^(times - j), which is t^(times - 1 - j) exp(p t)/(times - 1 - j)!.
                    moved = acb_poly([p, 1])
                    rest = acb_poly(factor(moved).coeffs()[1:]) ** times
                    for j, (other, n) in enumerate(rows):
                        rest = rest * other(moved) ** n if j != i else rest
                    series = _quotient(above(moved).coeffs(), rest.coeffs(), times)
                    row = [q / factorial(times - 1 - j) for j, q in enumerate(series)]
                    terms.append((p, row[::-1]))
        return terms

    @cached_property
    def slowest(self) -> Any:
        """The zero that outlasts all others."""
        return max((p for p, _ in self._terms), key=lambda p: float(p.real.mid()))

    @cached_property
    def end(self) -> Fraction:
        """A time after which the motion never leaves 5 % of A_d."""
        # t^k exp(Re p t) falls for t > k/|Re p|. From the sum of all multiplicities over the
        # slowest rate on all terms fall, so that a bound at one time holds ever after.
        time = Fraction(sum(n for _, n in self.factors)) / Fraction(float(-self.slowest.real.mid()))
        with flint.ctx.workprec(_BITS):
            while not self.most(_arb(time), _arb(time)) < expression_ball(_SIGNIFICANT):
                time *= 2
        return time

    @cached_property
    def _begun(self) -> Fraction:
        """A time up to which all derivatives that are 0 at first keep the sign that they get."""
        # The first derivative that is not 0 keeps its sign as long as it is larger at the middle
        # than the next one can change it: those before it, 0 at t = 0, are then monotonic.
        order, time = max(self.order, 1), self.end
        while True:
            with flint.ctx.workprec(_BITS):
                middle, half = _arb(time / 2), _arb(time / 2)
                if abs(self.value(middle, order)) > self.most(arb(0), _arb(time), order + 1) * half:
                    return time
            time /= 2
            tick()

    def passages(
        self, level: Rational, order: int = 0, until: Fraction | None = None
    ) -> list[LevelPassage]:
        """Return all passages of a level by a derivative (0: x itself) after the release, up to
        a time, s, in order; proven."""
        start, last = self._begun, until or self.end
        passages: list[LevelPassage] = []
        # Monotonic up to there, x passes a level once if it is on different sides at both ends. Its
        # derivatives keep their sign and pass 0 not at all.
        if order == 0:
            low = sign_of(self.begin - expression_ball(level))
            if low and _sign(self._at(start) - expression_ball(level)) == -low:
                passages.append(LevelPassage(self, level, 0, Fraction(0), start))
        cells = Waiting([(start, max(last, start))])
        for low_end, high_end in cells:
            if self._is_apart(low_end, high_end, level, order):
                continue
            if self._is_apart(low_end, high_end, Rational(0), order + 1):  # it is monotonic
                signs = [
                    _sign(self._at(t, order) - expression_ball(level)) for t in (low_end, high_end)
                ]
                if signs[0] != signs[1]:
                    passages.append(LevelPassage(self, level, order, low_end, high_end))
                continue
            if high_end - low_end < _FINEST * last:
                raise UndecidedError("whether a free response is tangent to a level or crosses it")
            middle = (low_end + high_end) / 2
            cells.add((low_end, middle), (middle, high_end))
        return passages

    @property
    def begin(self) -> Any:
        """x/A_d just after the release: less than 1 where a part of the force ends at once."""
        return arb(1) if self.order else self.value(arb(0))

    def _at(self, t: Fraction, order: int = 0) -> Ball:
        """Return a derivative at an exact time."""
        with flint.ctx.workprec(_BITS):
            return self.value(_arb(t), order)

    def _is_apart(self, low: Fraction, high: Fraction, level: Rational, order: int) -> bool:
        """Whether a derivative is shown not to meet a level between two times."""
        # By the mean value theorem: |f(t) - f(middle)| <= max |f'| times half the width.
        with flint.ctx.workprec(_BITS):
            off = abs(self.value(_arb((low + high) / 2), order) - expression_ball(level))
            return bool(off > self.most(_arb(low), _arb(high), order + 1) * _arb((high - low) / 2))


def _derived(k: int, order: int, t: Any, p: Any) -> Any:
    """Return a derivative of t^k exp(p t), divided by exp(p t)."""
    return sum(
        comb(order, n) * perm(k, n) * t ** (k - n) * p ** (order - n)
        for n in range(min(k, order) + 1)
    )


def _arb(x: Fraction) -> Ball:
    return arb(fmpq(x.numerator, x.denominator))


def _sign(x: Ball) -> int:
    """Return the sign of a ball; UndecidedError where it contains 0."""
    sign = sign_of(x)
    if not sign:
        raise UndecidedError("on which side of a level a free response is")
    return sign


def _quotient(above: list[Any], below: list[Any], count: int) -> list[Any]:
    """Return the first coefficients of a quotient of two power series, constant first."""
    quotient: list[Any] = []
    for n in range(count):
        rest = above[n] if n < len(above) else acb(0)
        known = [(n - i, x) for i, x in enumerate(quotient) if n - i < len(below)]
        rest -= sum((below[k] * x for k, x in known), acb(0))
        quotient.append(rest / below[0])
    return quotient


@lru_cache(maxsize=64)
def zeros(coefficients: Numbers, bits: int) -> tuple[Any, ...]:
    """Balls around the simple zeros of a polynomial, certified; more precision until they are
    apart."""

    def apart(working: int) -> tuple[Any, ...] | None:
        # Coefficients are balls, so the zeros cannot be closer than these are wide: half the
        # working precision is asked for. ValueError where the zeros are not isolated yet.
        polynomial = acb_poly([acb(expression_ball(c)) for c in coefficients])
        try:
            roots = polynomial.roots(tol=arb(2) ** (32 - working // 2), maxprec=2 * working + 128)
        except ValueError:
            return None
        return tuple(roots) if len(roots) == len(coefficients) - 1 else None

    return at_rising_precision(apart, 2 * bits + 64, SURE_BITS) or ()


@dataclass(frozen=True, repr=False)
class LevelPassage(RealNumber):
    """The only time, s, between two others at which a motion, or a derivative of it, passes a
    level."""

    motion: Motion
    level: Rational
    order: int
    low: Fraction
    high: Fraction

    def ball(self, bits: int) -> Ball:
        """Return an enclosure by interval Newton: f(t) = f'(u) (t - x) for a u between t and the
        passage x, and f' is known up to f'' times the width."""
        with flint.ctx.workprec(2 * bits + 64):
            above = self._off(_arb(self.high))
            cell = _arb(self.low).union(_arb(self.high))
            least = cell.rad() * arb(2) ** -(bits + 8)
            while cell.rad() > least:
                middle, half = cell.mid(), cell.rad()
                ends = middle - half, middle + half
                off = self._off(middle)
                bend = self.motion.most(*ends, self.order + 2)
                slope = self.motion.value(middle, self.order + 1) + arb(0, (bend * half).upper())
                inner = middle if slope.contains(0) else middle - off / slope
                # A step that does not halve the cell, or leaves it, is replaced by a bisection: the
                # passage is on the side where the sign differs from that at the middle.
                if slope.contains(0) or not (
                    inner.rad() < half / 2 and inner > ends[0] and inner < ends[1]
                ):
                    if not sign_of(off):
                        break  # as near as the digits of the zeros allow
                    inner = middle.union(ends[0] if sign_of(off) == _sign(above) else ends[1])
                cell = inner
            return cell

    def _off(self, t: Ball) -> Ball:
        return self.motion.value(t, self.order) - expression_ball(self.level)


@dataclass(frozen=True, repr=False)
class Span(RealNumber):
    """The time between two passages, s; or, where it is a ``height``, |x|/A_d at the last one."""

    first: RealNumber
    last: LevelPassage
    height: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits + 32):
            if self.height:
                return abs(self.last.motion.value(self.last.ball(bits + 32)))
            return self.last.ball(bits + 32) - self.first.ball(bits + 32)


_AT_ONCE = ExactNumber(Rational(0))


@dataclass(frozen=True)
class Swings:
    """The quantities that the tables read off a motion: the passages of 90 % and 10 %, the zero
    crossings, and the overshoots after each.

    ``periods`` : how many are asked for, so that so many are found though the motion dies away.
    """

    motion: Motion
    periods: int = 1

    def first(self, level: Rational) -> RealNumber | None:
        """Return the first time at which the motion is at a level, coming from above; 0 where it
        begins at or below it, None where it never is."""
        if not self.motion.begin > expression_ball(level):
            return _AT_ONCE
        return next(iter(self.motion.passages(level)), None)

    @cached_property
    def crossings(self) -> list[LevelPassage]:
        """The zero crossings: all while the motion is larger than 5 % of A_d, and those of all
        ``periods`` where the slowest mode oscillates."""
        # A complex slowest pair crosses zero for ever: the search goes on until the last period
        # has both its ends.
        motion, until = self.motion, self.motion.end
        while len(
            found := motion.passages(Rational(0), 0, until)
        ) <= 2 * self.periods and not motion.slowest.imag.contains(0):
            until *= 2
        return found

    @cached_property
    def overshoots(self) -> list[Span]:
        """After each zero crossing the largest |x|/A_d before the next one, while it may exceed
        5 %, or a period is asked for."""
        ends = [*(x.high for x in self.crossings[1:]), None]
        until = max([self.motion.end, *(x.high for x in self.crossings[-1:])])
        extrema = self.motion.passages(Rational(0), 1, until)
        overshoots = []
        for crossing, end in zip(self.crossings, ends, strict=False):
            between = [x for x in extrema if x.low >= crossing.low]
            heights = [Span(x, x, height=True) for x in between if end is None or x.high <= end]
            # Of several modes there may be more than one extremum between two crossings.
            if heights:
                overshoots.append(max(heights, key=lambda x: float(x.ball(64).mid())))
        return overshoots

    @cached_property
    def significant(self) -> int:
        """How many overshoots exceed 5 % of A_d."""
        return sum(_exceeds(x, _SIGNIFICANT) for x in self.overshoots)

    def period(self, n: int) -> Span | None:
        """Return P_n, the n-th full cycle after the first zero crossing; None where it is not
        completed."""
        cycle = self.crossings[2 * n - 2 : 2 * n + 1]
        return Span(cycle[0], cycle[2]) if len(cycle) == 3 else None


def _exceeds(x: RealNumber, limit: Rational) -> bool:
    """Whether a number exceeds a limit; one that is not distinguished from it at the last precision
    does not."""
    return (
        at_rising_precision(
            lambda bits: sign_of(x.ball(bits) - expression_ball(limit)) or None, 64, _BITS
        )
        == 1
    )


@dataclass(frozen=True)
class Check:
    """The check of one tolerance: the environment's number, the perceived one (None: there is
    none), and whether that is close enough.

    ``margin`` : the share of the tolerance that is left, in floats: 1 with no change, 0 at the
    limit, negative beyond it.
    """

    name: str
    environment: RealNumber | int
    perceived: RealNumber | int | None
    unit: str
    tolerance: str
    passes: bool
    margin: float | None = None


@dataclass(frozen=True)
class FreeResponse:
    """The result of a free-response test: its checks, or why there are none (``refused``).
    ``blind``: H_perc has the same zeros as H_env, and so the same periods and rates of decay."""

    checks: tuple[Check, ...]
    refused: str
    blind: bool

    @property
    def passes(self) -> bool | None:
        """Whether every tolerance is satisfied; None where the test is not offered or not
        decided."""
        return all(check.passes for check in self.checks) if self.checks else None


def free_response(d: Distortion, rule: FlightRule = FlightRule.AEROPLANE) -> FreeResponse:
    """The free-response test of what is felt against the environment by one of the tables, all
    verdicts proven.

    Offered where both have finitely many zeros, all with Re s < 0, a static stiffness, and no more
    poles than zeros; otherwise
    ``refused`` says why. A delay in series leaves the zeros as they are; one that enters them makes
    infinitely many.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = free_response(load_scene("fu2019").distortion())
    >>> found.passes, found.blind, found.checks[0].environment.digits(5)
    (True, True, '0.28401')
    """
    blind = _same_zeros(d.env, d.perc)
    swings = []
    for name, dynamics in (("environment", d.env), ("perceived dynamics", d.perc)):
        motion = motion_of(dynamics)
        if isinstance(motion, str):
            return FreeResponse((), f"not offered: {motion} (in the {name})", blind)
        # Half turns of the slowest pair while the motion may exceed 5 % of A_d, before any search.
        if (many := float(motion.end) * abs(float(motion.slowest.imag.mid())) / pi) > _MOST_SWINGS:
            return FreeResponse(
                (),
                f"not offered: some {many:.0f} overshoots stay above 5 % of A_d (in the {name})",
                blind,
            )
        swings.append(Swings(motion))
    try:
        return FreeResponse(tuple(_checks(swings[0], swings[1], rule)), "", blind)
    except UndecidedError as error:
        return FreeResponse((), f"undecided: {error}", blind)


def _same_zeros(one: RationalFunction, other: RationalFunction) -> bool:
    """Whether two functions have the same zeros: numerators that differ by a constant factor."""
    a, b = (_own(x.reduced().numerator, x) for x in (one, other))
    return bool((a / a.leading_coefficient()) == (b / b.leading_coefficient()))


def _own(polynomial: Polynomial, dynamics: RationalFunction) -> Polynomial:
    """Return a polynomial without the delays that all its terms share, which have no zeros."""
    return dynamics.ring.without_common_functions(polynomial)[1]


def motion_of(dynamics: RationalFunction) -> Motion | str:
    """Return the motion after a release, or words for why there is none."""
    ring, reduced = dynamics.ring, dynamics.reduced()
    above, below = (_own(x, dynamics) for x in (reduced.numerator, reduced.denominator))
    if any(degree_in([above, below], i) for i in range(ring.size, len(ring.meanings))):
        return (
            "the response has infinitely many modes, or friction: delays or powers of s enter "
            "its zeros or poles"
        )
    top, bottom = (tuple(ring.coefficients(x)) for x in (above, below))
    if top[0] == 0 or bottom[0] == 0:
        return "there is no steady force at a displacement"
    if len(top) == 1:
        return "without zeros there is no motion: the handle returns at once"
    if len(bottom) > len(top):
        return "without a mass at the handle the motion would begin with an impulse"
    # Zeros can be enclosed apart from each other only where they are simple.
    factors = tuple((tuple(ring.coefficients(f)), n) for f, n in _squarefree(above))
    rates = [p.real for row, _ in factors for p in zeros(row, 128)]
    if not all(x < 0 for x in rates):
        return "the free response does not die out"
    # (N - H(0) D)/s: the constant coefficient is 0 exactly, and left out.
    static = top[0] / bottom[0]
    rest = [x - static * (bottom[n] if n < len(bottom) else 0) for n, x in enumerate(top)][1:]
    while len(rest) > 1 and rest[-1].expand() == 0:
        rest.pop()
    # N is its leading coefficient times the product of monic factors; these here are not monic.
    lead = top[-1]
    for row, n in factors:
        lead = lead / row[-1] ** n
    motion = Motion(tuple((x / lead).expand() for x in rest), factors, len(top) - len(bottom))
    return "the handle passes its rest at once" if motion.begin < 0 else motion


def _squarefree(polynomial: Polynomial) -> Iterator[tuple[Polynomial, int]]:
    """Yield factors without repeated zeros in s, each with its multiplicity."""
    # gcd(N, N') has each zero once less often than N: dividing it out again and again leaves, round
    # by round, the zeros of at least that multiplicity.
    times, rest = 1, polynomial
    shared = rest.gcd(rest.derivative(0))
    left = rest / shared
    while degree_in([left], 0):
        again = left.gcd(shared)
        if degree_in([left / again], 0):
            yield left / again, times
        left, shared, times = again, shared / again, times + 1


def _checks(env: Swings, perc: Swings, rule: FlightRule) -> Iterator[Check]:
    """Yield the checks of a table, in its order; the environment decides whether it is
    underdamped."""
    if not env.crossings:
        pair = _fall(env), _fall(perc)
        yield _ratio_check("time from 90 % to 10 % of A_d", *pair, 10)
    else:
        first = (
            "from 90 % of A_d to the first zero crossing"
            if rule is FlightRule.AEROPLANE
            else "first zero crossing"
        )
        yield _ratio_check(f"P_0, {first}", _start(env, rule), _start(perc, rule), 10)
        # Two overshoots to a period: as many periods as have a significant one. What is felt may
        # die away sooner, and is followed as long.
        periods = max(1, (env.significant + 1) // 2)
        env, perc = (
            x if len(x.crossings) > 2 * periods else replace(x, periods=periods)
            for x in (env, perc)
        )
        for n in range(1, periods + 1):
            if (own := env.period(n)) is not None and env.significant:
                yield _ratio_check(f"P_{n}, period", own, perc.period(n), 10 * (n + 1))
        yield from _amplitudes(env, perc, rule)
    count, own_count = env.significant, perc.significant
    apart = abs(count - own_count)
    yield Check(
        "overshoots above 5 % of A_d",
        count,
        own_count,
        "",
        "the same number to within 1",
        apart <= 1,
        1.0 - apart,
    )


def _fall(x: Swings) -> RealNumber | None:
    """Return the time from 90 % to 10 % of A_d; 0 where the motion leaps below both at once."""
    first, last = x.first(Rational(9, 10)), x.first(Rational(1, 10))
    return last if first is None or not isinstance(last, LevelPassage) else Span(first, last)


def _start(x: Swings, rule: FlightRule) -> RealNumber | None:
    """Return P_0: from 90 % of A_d, or from the release, to the first zero crossing."""
    if not x.crossings:
        return None
    first = x.first(Rational(9, 10)) if rule is FlightRule.AEROPLANE else _AT_ONCE
    return None if first is None else Span(first, x.crossings[0])


def _ratio_check(name: str, env: RealNumber | None, perc: RealNumber | None, percent: int) -> Check:
    """Return the check of a time: within so many per cent of the environment's."""
    assert env is not None
    share = expression_ball(Rational(percent, 100))
    passes = perc is env or (
        perc is not None
        and at_most(
            lambda bits: abs(perc.ball(bits) - env.ball(bits)) - share * env.ball(bits), Rational(0)
        )
    )
    known = _float(env)
    margin = None
    if perc is not None and known:
        margin = 1 - 100 * abs(_float(perc) / known - 1) / percent
    return Check(name, env, perc, "s", f"{percent} %", passes, margin)


def _float(x: RealNumber) -> float:
    return float(x.ball(64).mid())


def _amplitudes(env: Swings, perc: Swings, rule: FlightRule) -> Iterator[Check]:
    """Yield the checks of each overshoot that is above 5 % of A_d in either motion; from the
    fourth on one check, with the numbers of that overshoot and the smallest margin."""
    count = min(max(env.significant, perc.significant), len(env.overshoots))
    if not count:
        return
    rows = [_overshoot(n, env, perc, rule) for n in range(1, count + 1)]
    yield from rows[:3]
    later = rows[3:]
    if later:
        fourth = later[0]
        name = f"A_4/A_d to A_{count}/A_d" if count > 4 else fourth.name
        least = min(x.margin for x in later if x.margin is not None)
        passes = all(x.passes for x in later)
        yield Check(name, fourth.environment, fourth.perceived, "", fourth.tolerance, passes, least)


def _overshoot(n: int, env: Swings, perc: Swings, rule: FlightRule) -> Check:
    """Return the check of the n-th overshoot: within 10 % of the first, or for helicopters, from
    the second on, within 20 % of itself. One that is missing counts as 0."""
    felt = perc.overshoots[n - 1] if n <= len(perc.overshoots) else None
    later = rule is FlightRule.HELICOPTER and n > 1
    known, of = env.overshoots[n - 1], env.overshoots[n - 1 if later else 0]
    limit = Rational(1, 5) if later else Rational(1, 10)

    def off(bits: int) -> Ball:
        size = arb(0) if felt is None else felt.ball(bits)
        return abs(size - known.ball(bits)) / of.ball(bits)

    # The margin is for reading; the verdict beside it is decided at rising precision.
    margin = 1 - float(off(64).mid()) / float(limit)
    return Check(
        f"A_{n}/A_d",
        known,
        felt,
        "",
        f"{100 * limit} % of A_{n if later else 1}",
        at_most(off, limit),
        margin,
    )


def at_most(value: Callable[[int], Ball], limit: Rational) -> bool:
    """Whether a number is at most a limit; one that is not distinguished from it at the last
    precision counts as larger, so that no tolerance passes unproven."""
    return (
        at_rising_precision(
            lambda bits: -sign_of(value(bits) - expression_ball(limit)) or None, 64, _BITS
        )
        == 1
    )
