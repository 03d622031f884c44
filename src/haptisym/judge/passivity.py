"""Whether a display is passive, and whether its force under prescribed motion is stable.

**Question.** A display is a one-port. The hand moves it by X(s) and feels the force H_perc(s) X, so
that its impedance, the force over the velocity s X, is Z(s) = H_perc(s)/s. At s = j omega, with the
amplitude A, it takes up the energy pi A^2 Im H_perc(j omega) per cycle. Is it passive, so that it
is stable in the hand of any passive operator? If not, how much damping of the hand compensates it?

**Passive.** A display is passive if and only if Z is positive real: analytic, with Re Z >= 0, in
Re s > 0 (Brune 1931 for rational Z; Youla, Castriota and Carlin 1959 for all linear one-ports).
Passive is just what coupled stability with any passive operator needs (Colgate and Hogan 1988). It
is decided by four conditions:

1. Re Z = Im H_perc(j omega)/omega >= 0 at all omega > 0 that are no poles,
2. Z has no pole in Re s > 0,
3. the poles of Z at s = 0, at other points of the axis Re s = 0 and at infinity are simple, with
   positive residues; at infinity: on the axis Z grows more slowly than omega, or is near m s with
   a mass m > 0,
4. Z has no *advance*: it does not grow as exp(s tau), tau > 0, for large s > 0.

Each is necessary: a positive real function satisfies abs(Z(s)) <= const s for s >= 1. Together they
are sufficient. Z is a quotient of sums of powers of s and delays exp(-s tau); in Re s > 0 these
grow at most exponentially, and by conditions 2 to 4 Z grows there no faster than s (Phragmen and
Lindelof, for Z/(s + 1); Titchmarsh, The Theory of Functions, 5.6). Its poles on the axis and m s
are imaginary on the axis, and have Re >= 0 in Re s > 0: with these taken off, Re Z >= 0 carries
over from the axis to Re s > 0 by the maximum principle. Rational functions have no advance.

**How each is decided.** Condition 1 is read off a *chart* (``kernel.roots``: all zeros and signs of
a function from 0 to some frequency) and, above it, off the sign of Im H_perc at high frequency
(``asymptotic_sign``). Conditions 2 to 4 are decided by ``poles_allow``, 2 and 3 by an exact count
of the zeros of the denominator.

**Passive parts.** An environment that is a passive one-port, behind passive two-ports (effects with
a chain matrix), is a passive one-port: then no pole need be counted. The wave-variable link is a
line without losses (Niemeyer and Slotine 1991).

**Stable under prescribed motion.** The force is stable where all poles of H_perc lie in Re s < 0.
Let all parts be passive, and let the environment dissipate energy at every omega > 0 and have no
pole on the axis. By condition 2 there is no pole in Re s > 0. Nor is there one on the axis: there a
force would act on a hand at rest, X = 0, into which no energy flows. So none is dissipated, the
environment is at rest, and its force, finite times 0, is 0. As a chain matrix of passive parts is
finite on the axis and has an inverse there, the force at the hand is 0 too, a contradiction. With
delays the poles may still come as near to the axis as one likes: *stable* says no more here than
that none is on it.

**What is returned.** True and False are proven, in exact or ball arithmetic; None means undecided.
Of a ``bool`` alone, False proves nothing where its docstring says so.

**Words.** A *turn* is the frequency 2 pi/tau, rad/s, at which the phase of the longest delay tau
has turned once. The *ring* of H_perc is the polynomial ring in s, exp(-s tau) of each of its unit
delays (``lags``) and s^alpha of each of its fractional powers (``orders``). In code an ``axis`` is
the corresponding ring for s = j omega, with the *angles* omega tau; in words the axis is that of Re
s = 0. *Raw* real and imaginary parts are not reduced: their common denominator is abs(denominator
of H_perc)^2 >= 0.

Begin with ``passivity`` and ``force_is_stable``. Sampled loops, of which H_perc is an
approximation, are judged by ``judge.colgate``; a chart of them ends at pi/T, with the sampling
period T.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from math import isfinite, prod
from typing import Any

import flint
from flint import arb
from sympy import Expr, Integer, Poly, Rational, pi

from haptisym.judge.colgate import SampledPassivity, sampled_passivity
from haptisym.judge.crossings import PASSIVE
from haptisym.judge.peaks import LargestValue, supremum
from haptisym.kernel.asymptoticsign import AsymptoticSign, Sense, asymptotic_sign
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import RealFunction, Response, Ring, on_axis, ring_of
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import Polynomial, RationalFunction, omega, s
from haptisym.kernel.rootcount import count_roots, is_stable, order_at_0
from haptisym.kernel.roots import Chart, Interval, chart, sign_of_number
from haptisym.model.catalogue import Effect
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene, clocks, sampled_loop

# The verdict on passivity.


class Beyond(Enum):
    """The sign of Im H_perc above the highest frequency of a chart, or why it is not known; where
    it is 0 everywhere, it is ``NEVER`` negative.

    The values are printed, and are part of the documents of ``--json``.
    """

    NEVER = "never negative"
    ALWAYS = "negative everywhere"
    AGAIN = "negative again and again"
    UNKNOWN = "not decided"
    CLOCK = "not looked at: the clock samples no faster motion"
    LATE = "not looked at: the delays turn many times before it settles"


_BEYOND_BY_SENSE = {
    Sense.POSITIVE: Beyond.NEVER,
    Sense.NEGATIVE: Beyond.ALWAYS,
    Sense.BOTH: Beyond.AGAIN,
    Sense.UNKNOWN: Beyond.UNKNOWN,
}


def passivity(scene: Scene, distortion: Distortion | None = None) -> Passivity:
    """Find where a display generates energy on [0, infinity).

    The parameters of the scene must be numbers. Im H_perc is charted at least over its band, and
    above the chart its sign at high frequency is determined; but with a clock it is charted up to
    pi/T, and nothing is said of what is above.

    ``distortion`` : that of the scene, if it is known already.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = passivity(load_scene("zener-tissue"))
    >>> found.holds, found.beyond.name, [x.low.omega.digits(7) for x in found.active]
    (False, 'ALWAYS', ['92.70739'])
    """
    distortion = distortion or scene.closed
    periods = clocks(scene)
    # Above pi/T a sampled display takes a motion for a slower one, and its formula means nothing.
    if periods:
        settled = AsymptoticSign(Sense.UNKNOWN)
        high, beyond = pi / max(periods, key=float), Beyond.CLOCK
    else:
        settled = asymptotic_sign(distortion.perc_response.raw_imag)
        high, is_late = _chart_end(scene, distortion, settled)
        beyond = Beyond.LATE if is_late else _BEYOND_BY_SENSE[settled.sense]
    # PASSIVE has the measure -Im H_perc and the limit 0: its function is positive where the display
    # is active.
    table = chart({PASSIVE: PASSIVE.function(distortion)}, Integer(0), high)
    return Passivity(scene, distortion, table, high, beyond, settled)


@dataclass(frozen=True)
class Passivity:
    """Where a display generates energy, and whether it is passive: proven.

    ``chart`` : that of -Im H_perc, from 0 to ``high``, rad/s.
    ``beyond`` : the sign of Im H_perc above ``high``.
    ``settled`` : the sign of Im H_perc at high frequency, and from which frequency on; it is not
    determined for a scene with a clock.

    A scene has a *clock* if an effect is a sampler, of period T: its chart ends at pi/T
    (``Beyond.CLOCK``), and ``sampled`` is not None. It is a *sampled loop* if, further, the held
    force moves an element that is sampled again: then H_perc itself is an approximation.
    """

    scene: Scene
    distortion: Distortion
    chart: Chart
    high: Expr
    beyond: Beyond
    settled: AsymptoticSign = AsymptoticSign(Sense.UNKNOWN)

    @cached_property
    def holds(self) -> bool | None:
        """Whether the display is passive; a sampled one by ``sampled``. None where undecided.

        The order of the four tests below is the argument: what denies passivity, what alone decides
        with a clock, what proves it without a count of poles, and at last all conditions.
        """
        # 1. Condition 1 fails. In a sampled loop the sign of H_perc proves nothing about the loop.
        if self.is_active and not sampled_loop(self.scene):
            return False
        # 2. With a clock.
        if self.sampled is not None:
            with suppress(UndecidedError):
                return self.sampled.passive
            return None
        # 3. Passive parts need no count of poles, of which there may be infinitely many.
        if self.has_passive_parts:
            return True
        # 4. Condition 1 is proven only where neither the chart nor the sign above it is open.
        if self.beyond is not Beyond.NEVER or self.chart.undecided:
            return None
        return self.poles_allow

    @cached_property
    def sampled(self) -> SampledPassivity | None:
        """Colgate and Schenkel's condition for a sampled display; None for any other."""
        return sampled_passivity(self.scene)

    @cached_property
    def active(self) -> tuple[Interval, ...]:
        """The intervals up to ``high`` on which Im H_perc < 0, in ascending order: the display
        generates the energy -pi A^2 Im H_perc per cycle of amplitude A there."""
        return self.chart.where(lambda signs: signs[PASSIVE] > 0)

    @property
    def is_active(self) -> bool:
        """Whether Im H_perc < 0 is proven at some frequency.

        False proves nothing above ``high`` where ``beyond`` is not known, nor below it where the
        chart is undecided.
        """
        return bool(self.active) or self.stays_active

    @property
    def is_nowhere_active(self) -> bool:
        """Whether Im H_perc >= 0 is proven at all frequencies, by the chart or as the display is
        passive; of a sampled one, which has no sign above its chart, that it is passive. False
        proves nothing."""
        is_charted = self.beyond is Beyond.NEVER and not self.chart.undecided
        return not self.active and bool(is_charted or self.holds)

    @property
    def stays_active(self) -> bool:
        """Whether Im H_perc < 0 is proven at arbitrarily high frequencies. False proves nothing."""
        return self.beyond in (Beyond.ALWAYS, Beyond.AGAIN) or self.active_from is not None

    @property
    def active_from(self) -> Expr | None:
        """The frequency, rad/s, above which Im H_perc < 0 everywhere, where that lies above
        ``high`` and the gap between them was not examined; otherwise None."""
        is_late = self.beyond is Beyond.LATE and self.settled.sense is Sense.NEGATIVE
        return self.settled.radius if is_late else None

    @cached_property
    def has_passive_parts(self) -> bool:
        """Whether the display is proven to be made of passive parts: an environment behind passive
        two-ports. False proves nothing."""
        alone = environment_alone(self.scene)
        return alone is not None and passivity(alone).holds is True

    @cached_property
    def poles_allow(self) -> bool | None:
        """Whether H_perc/s satisfies conditions 2 to 4, those on its poles and on an advance; None
        where that is undecided."""
        return True if self.has_passive_parts else poles_allow(self.distortion.perc)

    @property
    def dissipates(self) -> bool:
        """Whether the display is passive, and Im H_perc > 0 at every omega > 0 that is no pole.
        False proves nothing; it is always False with delays and fractional powers of s.

        Up to ``high`` the chart shows the sign. Above, Im H_perc is never negative
        (``Beyond.NEVER``); nor is it 0: without delays its sign is that of a polynomial in omega,
        whose highest power exceeds all others together there (``asymptotic_sign``).
        """
        ring = ring_of(self.distortion.perc)
        is_rational = not (ring.lags or ring.orders)
        if not self.holds or self.beyond is not Beyond.NEVER or not is_rational:
            return False
        # Signs are those of -Im H_perc: above each point, and at it, 0 at a zero. At omega = 0
        # itself it vanishes, as an odd function.
        signs = {x for point in self.chart.points for x in point.after.values()}
        for point in self.chart.points:
            if float(point.omega) > 0:
                signs.update(point.at.values())
        # Where the chart is undecided it may come to 0.
        return signs == {-1} and not self.chart.undecided

    @cached_property
    def damping(self) -> LargestValue | None:
        """The damping b* = sup(-Im H_perc/omega) over omega > 0, N s/m, at least 0.

        A hand with more damping is stable with the display, whatever its mass and stiffness, if
        ``poles_allow`` is True: H_perc/s + b* satisfies condition 1, and the other conditions as
        H_perc/s does. Where it is False, no damping is enough.

        The frequency of b* is None where b* is 0, and where the supremum is only approached, at
        high frequency. The result is None where b* is infinite: at high frequency
        (``is_unbounded``), or as omega goes to 0, where H_perc has a pole that ``poles_allow``
        denies. It is None too where b* is undecided, as where the sign above ``high`` is not known,
        or not found within the seconds of ``_DAMPING_SECONDS``.
        """
        if self.is_nowhere_active:
            return LargestValue(ExactNumber(Integer(0)), None)
        # Activity that was not found may be above ``high``, and need more damping than 0.
        if not self.is_active or self.beyond is Beyond.CLOCK:
            return None
        try:
            with limited(_DAMPING_SECONDS):
                return _needed_damping(self.distortion, self.high)
        except UndecidedError:
            return None

    @cached_property
    def is_unbounded(self) -> bool:
        """Whether -Im H_perc/omega is proven to be unbounded at high frequency, so that no damping
        of a hand is enough. False proves nothing.

        It is where the display stays active and Im H_perc grows faster than omega. To see that the
        growth of ``_growth_exponent`` is attained where Im H_perc < 0:

        - Multiplied by powers of the cosines of half angles, numerator and denominator of Im H_perc
          are N = omega^p W(omega) + lower powers, W a sum of sines and cosines, and 0 < D <= const
          omega^q. The quotient is the same, as both have the same powers.
        - ``asymptotic_sign`` has proven W <= -d < 0 everywhere or, for both signs, at one
          frequency; of a W <= 0 that has zeros it tells no sign. W is almost periodic: then W <=
          -d/2 at arbitrarily high frequencies, which can be chosen such that no cosine is near 0.
        - At these frequencies -Im H_perc/omega >= const omega^(p - q - 1).
        """
        if not self.stays_active:
            return False
        return sign_of_number(_growth_exponent(self.distortion.perc_response.raw_imag) - 1) > 0

    @cached_property
    def most_given(self) -> LargestValue | None:
        """The largest -Im H_perc up to ``high``, N/m, and its frequency: times pi A^2 it is the
        energy per cycle of amplitude A. None if it is unbounded."""
        return supremum(PASSIVE.measure(self.distortion), Integer(0), self.high)

    def row(self) -> dict[str, Any]:
        """The verdict as a part of a document, rad/s; an interval without an end ends in None."""
        ends: list[list[float | None]] = [
            [float(x.low.omega), float(x.high.omega)] for x in self.active
        ]
        if self.beyond is Beyond.ALWAYS:
            # Im H_perc < 0 at the end of the chart itself too, where the bound of
            # ``asymptotic_sign`` holds already: so there is a last interval, which ends there and
            # goes on. (What a chart leaves undecided is whether there is a zero, not a sign.)
            ends = [*ends[:-1], [ends[-1][0], None]]
        if self.active_from is not None:
            ends.append([float(self.active_from), None])
        return {
            "holds": self.holds,
            "active": ends,
            "beyond": self.beyond.value,
            "reach": float(self.high),
            "poles_allow": self.poles_allow,
        }


# How far a chart goes.

# Turns up to which active intervals are listed where they never end, or go on for too long.
_FIRST_TURNS = 2
# A chart goes up to the frequency at which a sign settles if that is no more turns away. Each turn
# brings some zeros, and nobody reads thousands.
_MOST_TURNS = 500


def _chart_end(scene: Scene, distortion: Distortion, settled: AsymptoticSign) -> tuple[Expr, bool]:
    """The highest frequency of a chart of Im H_perc, rad/s, at least that of the band; and whether
    the sign of Im H_perc settles only beyond it, after too many turns."""
    is_settled = settled.sense in (Sense.POSITIVE, Sense.NEGATIVE)
    wanted = settled.radius if is_settled else _FIRST_TURNS * _turn(distortion)
    high, band_end = most_charted(distortion, wanted), scene.band[1]
    if sign_of_number(high - band_end) < 0:
        high = band_end
    return high, is_settled and sign_of_number(settled.radius - high) > 0


def most_charted(distortion: Distortion, high: Expr) -> Expr:
    """The frequency up to which a chart is made, rad/s: ``high`` if it is at most ``_MOST_TURNS``
    turns, or if there is no delay; else ``_FIRST_TURNS`` turns."""
    turn = _turn(distortion)
    if turn and sign_of_number(high - _MOST_TURNS * turn) > 0:
        return _FIRST_TURNS * turn
    return high


def _turn(distortion: Distortion) -> Expr:
    """The turn 2 pi/tau of the longest unit delay tau, rad/s; 0 where there is no delay."""
    lags = ring_of(distortion.perc).lags
    return 2 * pi / max(lags, key=float) if lags else Integer(0)


# The damping that a hand needs.

# Frequencies at which a first guess of the needed damping is computed: enough to see a resonance or
# two. More would only save a second try.
_GUESSES = 200
# The share by which a bound is tried below the largest value on the grid: so that it is below the
# supremum in spite of rounding.
_BELOW = 1e-3
# Working precision for the guess, which nothing relies on.
_GUESS_BITS = 64
# Working precision at which a maximum is compared with a limit. If both are equal, the comparison
# stays open, and either of them may be returned.
_COMPARISON_BITS = 128
# Seconds of processor time for the needed damping: where roots and delays meet, thousands of peaks
# may have to be compared. What is found in them depends on the machine: a number, or nothing.
_DAMPING_SECONDS = 10.0


def _needed_damping(distortion: Distortion, high: Expr) -> LargestValue | None:
    """sup(-Im H_perc/omega) over omega > 0, where it is positive; None where it is infinite, or no
    bound at high frequency was found. ``high`` : rad/s, the end of the chart.

    A bound of -Im H_perc/omega above some frequency reduces the search to the band below it: the
    supremum is the largest value there if that exceeds the bound, and else the bound if that is the
    limit.
    """
    raw = distortion.perc_response.raw_imag
    axis: Any = raw.ring
    needed = PASSIVE.measure(distortion) / RealFunction(axis.convert(omega))
    if _is_periodic_over_power(needed):
        # Each turn repeats the values of the one before, divided by a power that is not smaller:
        # where they are positive, none exceeds those of the first turn.
        return supremum(needed, Integer(0), 2 * pi / axis.angles[0].rate)
    for bound in _candidate_bounds(needed, high):
        # -Im H/omega <= bound above the radius, as bound omega + Im H >= 0 there.
        settled = asymptotic_sign(axis.convert(bound * omega) + raw)
        if settled.sense is Sense.POSITIVE:
            end = settled.radius if sign_of_number(settled.radius - high) > 0 else high
            largest = supremum(needed, Integer(0), end)
            # If all values up to ``end`` are below the bound, so are all values. Then the bound is
            # the limit at high frequency, which is approached: a bound from the grid is below a
            # value on the grid, which is below ``end``.
            is_approached = largest is not None and (
                largest.value.ball(_COMPARISON_BITS) < ExactNumber(bound).ball(_COMPARISON_BITS)
            )
            return LargestValue(ExactNumber(bound), None) if is_approached else largest
    return None


def _is_periodic_over_power(f: RealFunction) -> bool:
    """Whether f is a function of sin and cos of one angle omega tau, divided by a power of omega:
    all terms of its denominator have the same."""
    axis: Any = f.axis
    numerator, denominator = f.function.numerator, f.function.denominator
    if numerator.degrees()[0] or len(axis.angles) != 1 or axis.orders:
        return False
    return len({exponents[0] for exponents in denominator.monoms()}) == 1


def _candidate_bounds(needed: RealFunction, high: Expr) -> list[Expr]:
    """Positive numbers to try as bounds of -Im H_perc/omega at high frequency, in this order: a
    little less than the largest value on a grid, and, of a rational function, its limit.

    They are proposals alone: ``_needed_damping`` proves that one is a bound.
    """
    # The grid is quadratic, denser at low frequencies. Lower ends of balls: no value is
    # overestimated.
    values: list[float] = []
    with flint.ctx.workprec(_GUESS_BITS):
        end = float(high)
        for k in range(1, _GUESSES + 1):
            value = needed.ball(arb(end * (k / _GUESSES) ** 2))
            values.append(float(value.lower()))
    largest = max((x for x in values if isfinite(x)), default=0.0)
    bounds = [Rational(largest * (1 - _BELOW))] if largest > 0 else []
    numerator, denominator = needed.function.numerator, needed.function.denominator
    degrees = [int(p.degrees()[0]) for p in (numerator, denominator)]
    has_limit = not needed.axis.functions and degrees[0] == degrees[1]
    if not has_limit:
        return bounds
    leading = [needed.axis.coefficients(p)[-1] for p in (numerator, denominator)]
    limit = leading[0] / leading[1]
    return [*bounds, limit] if sign_of_number(limit) > 0 else bounds


# Conditions 2 to 4: the poles of H_perc/s, and an advance.


def poles_allow(F: RationalFunction) -> bool | None:
    """Whether F/s, F in lowest terms, satisfies conditions 2 to 4 of a positive real function,
    those on its poles and on an advance; None where that is undecided.

    >>> from sympy import exp
    >>> from haptisym.kernel.rings import s
    >>> def of(Z):
    ...     F = s * Z
    ...     return poles_allow(Ring.of([F]).convert(F).reduced())
    >>> of(1 / s), of(-1 / s), of(s / (s - 1)), of(s / (s**2 + 1)), of(s**2), of(-s)
    (True, False, False, True, False, False)
    >>> of(1 + exp(-s) / s), of(1 + exp(s) / s)
    (True, False)
    """
    if F.is_zero:
        return True
    if has_advance(F):
        return False
    try:
        return _poles_satisfy(F, on_axis(F))
    except UndecidedError:
        return None


def has_no_pole_right(f: RationalFunction) -> bool | None:
    """Whether a function in lowest terms has no pole in Re s > 0; None where that is undecided. It
    is condition 2 alone, for Llewellyn's criterion."""
    try:
        poles = count_roots(f.denominator, ring_of(f))
    except UndecidedError:
        return None
    return None if poles.right is None else poles.right == 0


def has_advance(f: RationalFunction) -> bool:
    """Whether a function that is not 0 grows as exp(s tau) with some tau > 0, times a power of s,
    for large s > 0: then it responds before it is excited.

    There each polynomial in s and its delays goes as its terms with the least delay. So an advance
    is a numerator whose least delay is shorter than that of the denominator.
    """
    ring = ring_of(f)
    gained = _least_delay(f.denominator, ring) - _least_delay(f.numerator, ring)
    return sign_of_number(gained) > 0


def _least_delay(polynomial: Polynomial, ring: Ring) -> Expr:
    """The least delay of a term of a polynomial of a ring, s."""
    delays: list[Expr] = []
    for exponents in polynomial.monoms():
        units = zip(exponents[ring.size :], ring.lags, strict=False)
        delays.append(sum((int(n) * lag for n, lag in units), Integer(0)))
    # Not as floats, as which two delays may be equal.
    return min(map(ExactNumber, delays)).value


def _poles_satisfy(F: RationalFunction, response: Response) -> bool:
    """Whether F/s satisfies conditions 2 and 3; UndecidedError where that is undecided.
    ``response`` : F(j omega)."""
    # A pole of F at 0 is a multiple one of F/s.
    ring = ring_of(F)
    if order_at_0(F.denominator, ring) > order_at_0(F.numerator, ring):
        return False
    if not _is_allowed_at_infinity(response):
        return False
    count = count_roots(F.denominator, ring)
    # Where it is known, so are all poles on the axis.
    if count.right is None:
        raise UndecidedError("where infinitely many poles lie")
    # F(0) is the residue of F/s at 0.
    if count.right or _sign_at_0(response.real) < 0:
        return False
    on_positive_axis = [float(x) for x in count.on_axis if float(x) > 0]
    if not on_positive_axis:
        return True
    parts = {"real": response.real, "imag": response.imag}
    # A whole frequency above all of these poles.
    high = Integer(int(max(on_positive_axis)) + 1)
    for point in chart(parts, Integer(0), high).points:
        if point.undecided:
            raise UndecidedError("whether a pole on the axis has a positive residue")
        real_order, imaginary_order = (point.orders.get(name, 0) for name in parts)
        is_pole = min(real_order, imaginary_order) < 0
        # Let F/s have the residue r at j omega_0. There F(j omega) is near to r omega_0/(omega -
        # omega_0): for r > 0 real, and it goes to -infinity and comes back from +infinity.
        signs = point.before["real"], point.after["real"]
        is_simple = real_order == -1 and imaginary_order >= 0
        if is_pole and not (is_simple and signs == (-1, 1)):
            return False
    return True


def _sign_at_0(real: RealFunction) -> int:
    """The sign of F(0), from its real part; 0 where F(0) = 0. F is in lowest terms and has no pole
    at 0."""
    if not real.axis.functions:
        # Neither polynomial has a zero at 0 in common with the other: their lowest coefficients
        # decide, of which that of the numerator may be 0.
        f = real.function
        lowest = (f.ring.coefficients(p)[0] for p in (f.numerator, f.denominator))
        return prod(map(sign_of_number, lowest))
    # At an end of its band a chart leaves nothing undecided.
    first = chart({"real": real}, Integer(0), Integer(1)).points[0]
    return 0 if first.orders.get("real", 0) else first.after["real"]


def _is_allowed_at_infinity(response: Response) -> bool:
    """Whether F/s has no pole at infinity, or a simple one with a positive residue m.

    That is so where F grows more slowly than s^2, or as m s^2, whose real part is -m omega^2 on the
    axis. UndecidedError where the sign of the real part at high frequency is not known.

    With delays F may grow as s^2 V(s), V a quotient of sums of delays. Re F alone is then asked. If
    it is Im F that grows as omega^2, the answer does not matter: Im V is odd and almost periodic,
    so that it takes both signs, and condition 1 fails.
    """
    parts = (response.raw_real, response.raw_imag)
    exponent = max(_growth_exponent(x) for x in parts if not x.is_zero)
    excess = sign_of_number(exponent - 2)
    # With s^alpha a power may be there in form alone: s^(1/2) s^(1/2) - s is not 0 in the ring,
    # where s^(1/2) is a variable. A sign shows that the highest one is there.
    senses = {asymptotic_sign(x).sense for x in parts if excess > 0 and response.real.axis.orders}
    if senses == {Sense.UNKNOWN}:
        raise UndecidedError("how fast H_perc grows, where powers of s may cancel")
    if excess:
        return excess < 0
    sense = asymptotic_sign(response.raw_real).sense
    if sense in (Sense.BOTH, Sense.UNKNOWN):
        raise UndecidedError("whether a display is a positive mass at high frequency")
    return sense is Sense.NEGATIVE


def _growth_exponent(f: RationalFunction) -> Expr:
    """The exponent of omega with which a function of an axis, not 0, grows where its denominator is
    not small, at most: the highest power of its numerator less that of its denominator, which a sum
    of products of s^alpha may have in form alone."""
    return _highest_power(f.numerator, f.ring) - _highest_power(f.denominator, f.ring)


def _highest_power(polynomial: Any, axis: Any) -> Expr:
    """The highest power of omega in a polynomial of an axis, fractional powers included."""
    # Exponents of an axis are those of omega, pi and the parameters, then of the tangent of half of
    # each angle, then of each omega^alpha.
    return _highest(polynomial, axis.size + len(axis.angles), axis.orders)


def _highest(polynomial: Any, first: int, orders: Iterable[Expr]) -> Expr:
    """The highest power of the first variable of a polynomial, if the variables from ``first`` on
    stand for its powers with the exponents ``orders``; 0 for the polynomial 0."""
    powers: list[Expr] = []
    for exponents in polynomial.monoms():
        fractional = zip(exponents[first:], orders, strict=False)
        powers.append(sum((int(n) * alpha for n, alpha in fractional), Integer(int(exponents[0]))))
    return max(powers, default=Integer(0))


# Passive parts. All tests here are sufficient ones: False proves nothing.


def environment_alone(scene: Scene) -> Scene | None:
    """The scene without its effects, where these are passive two-ports.

    None where some are not known to be passive, where there are none, and where something else than
    the environment is rendered.
    """
    if scene.rendered is not None or not scene.effects or not are_passive(scene.effects):
        return None
    return Scene(scene.environment, (), scene.band)


def are_passive(effects: Iterable[Effect]) -> bool:
    """Whether effects are passive two-ports, by their models. False proves nothing.

    A shunt is passive if its force per position, the second entry of its matrix, is m s^2 + b s + k
    with no negative number. A compliance always is, as its parameters k and b are positive by their
    rules; a wave-variable link is, as a line without losses, whose impedance b is positive by its
    rule.

    >>> from haptisym import effects
    >>> link = effects.wave_variables(10, "20 ms")
    >>> [are_passive([link, x]) for x in (effects.shunt(m=1), effects.shunt(m=-1), effects.delay(1))]
    [True, False, False]
    """
    for x in effects:
        is_passive_shunt = x.model == "shunt" and _is_passive_polynomial(x.matrix[1])
        if not is_passive_shunt and x.model not in ("wave-variables", "compliance"):
            return False
    return True


def is_stable_by_parts(scene: Scene, chain: Chain) -> bool:
    """Whether a display coupled to any hand with damping has no root in Re s >= 0 but at 0, because
    no part of the display generates energy. False proves nothing.

    In Re s > 0 the hand's share of Re Z is positive, and the display's is not negative: their sum
    is not 0. On the axis the hand would not move, nor feel a force: then all that is behind chain
    matrices is at rest too, as they have inverses.

    ``chain`` : the scene's, in which a parameter may be a symbol. Then True holds for all of its
    values > 0, as a power of s up to 1; and the result is False where it stands in a shunt.
    """
    elements = zip(scene.effects, chain.matrices, strict=True)
    shunts = [matrix[1] for effect, matrix in elements if effect.model == "shunt"]
    return (
        environment_alone(scene) is not None
        and all(map(_is_passive_polynomial, shunts))
        and is_positive_real_by_signs(chain.environment)
    )


def is_positive_real_by_signs(environment: Expr) -> bool:
    """Whether H/s is positive real, and H finite at all frequencies > 0, for all values > 0 of the
    symbols in it, and at most 1 of those that are powers of s. False proves nothing.

    Shown by signs alone:

    - The denominator of H has degree 0, 1 or 2 and all of its coefficients are there and positive,
      so that its zeros lie in Re s < 0 (Hurwitz).
    - All coefficients of the numerator are positive, and at high frequency H grows no faster than
      s^2: so H/s has at most simple poles at 0 and at infinity, with positive residues.
    - Im H(j omega) times |denominator|^2 has no negative coefficient, so that Im H >= 0.

    >>> from sympy.abc import k, q
    >>> each = k + q * s, k * q * s / (k + q * s), k * s**q, 1 / (s**2 + q), k - q * s, q * s - k
    >>> [is_positive_real_by_signs(H) for H in each]
    [True, True, True, False, False, False]
    """
    ring = Ring.of([environment])
    if ring.lags:
        return False
    H, axis = ring.convert(environment).reduced(), ring.axis
    numerator, denominator = H.numerator, H.denominator
    powers = {int(exponents[0]) for exponents in denominator.monoms()}
    # Numerator and denominator may both be negative: then H is as if both were positive.
    signs = {c > 0 for c in (*numerator.coeffs(), *denominator.coeffs())}
    if len(signs) > 1 or powers not in ({0}, {0, 1}, {0, 1, 2}):
        return False
    # Of orders 0 < alpha < 1 the tangents below are positive, and so of a symbol; not of multiples
    # of it.
    if not all(alpha.is_Rational or alpha.is_Symbol for alpha in ring.orders):
        return False
    # Powers s^alpha in the denominator are not covered; in the numerator they count as growth, an
    # order that is a symbol as its upper bound 1.
    if any(any(exponents[ring.size :]) for exponents in denominator.monoms()):
        return False
    orders = [x if x.is_Rational else Integer(1) for x in ring.orders]
    if _highest(numerator, ring.size, orders) > max(powers) + 2:
        return False
    # Im (a + j b)/(c + j d) has the sign of b c - a d, and keeps it without its factors 1 + tan^2
    # of half of the angle alpha pi/2 of each power.
    (a, b), (c, d) = axis.parts([numerator, denominator])
    imaginary = axis.without_circles(b * c - a * d)[0]
    return all(x > 0 for x in imaginary.coeffs())


def _is_passive_polynomial(Z: Expr) -> bool:
    """Whether a dynamics is m s^2 + b s + k with numbers, none of them negative."""
    if not Z.is_polynomial(s):
        return False
    row = Poly(Z, s).all_coeffs()
    are_numbers = all(not x.free_symbols and x.is_real for x in row)
    return len(row) <= 3 and are_numbers and all(sign_of_number(x) >= 0 for x in row)


# Stability under prescribed motion.

# The key of Re H_perc in its chart.
_REAL = "H_perc"


def force_is_stable(scene: Scene, distortion: Distortion) -> bool | None:
    """Whether all poles of H_perc have Re s < 0.

    None where that is undecided, and for a sampled loop, whose stability the poles of H_perc do not
    show. True does not bound their distance from the axis: with delays they may approach it at high
    frequencies. An advance is no pole.

    Three ways are tried in turn: ``is_stable``, which is undecided where infinitely many poles
    approach the axis; the parts, as with an environment that dissipates no pole reaches the axis
    (see the module); and a pole on the axis itself, which a display without losses shows.
    """
    if sampled_loop(scene):
        return None
    verdict = is_stable(distortion.perc)
    if verdict is not None:
        return verdict
    alone = environment_alone(scene)
    try:
        if alone and (_dissipates_without_resonance(alone) or _dissipates_by_signs(alone)):
            return True
        return False if _has_pole_on_axis(distortion) else None
    except UndecidedError:
        return None


def _dissipates_without_resonance(scene: Scene) -> bool:
    """Whether an environment alone is passive, Im H_env > 0 at every frequency > 0, and H_env has
    no pole on the axis. False proves nothing.

    The last does not follow: b s + k s^2/(s^2 + w^2) is passive, and Im H = b omega > 0, but at w
    it has a force without any motion, which a wave-variable link may turn round to the hand.
    """
    alone = passivity(scene)
    if not alone.dissipates:
        return False
    H = alone.distortion.perc
    return not count_roots(H.denominator, ring_of(H)).on_axis


def _dissipates_by_signs(scene: Scene) -> bool:
    """Whether Im H_env > 0 at every frequency > 0 and H_env has no pole on the axis, by signs
    alone, powers of s included. False proves nothing."""
    imaginary = scene.closed.env_response.raw_imag
    return is_positive_real_by_signs(scene.environment.H) and not imaginary.is_zero


def _has_pole_on_axis(distortion: Distortion) -> bool:
    """Whether H_perc is real on the axis, and has a pole there within ``_FIRST_TURNS`` turns. False
    proves nothing."""
    perceived = distortion.perc_response
    # Without losses H_perc has no imaginary part on the axis: there its poles are those of a real
    # function, which a chart lists. The first of them is enough. (Where Re H_perc has a pole,
    # H_perc has one in any case, but with losses its chart may take half a minute.)
    turn = _turn(distortion)
    if not turn or not perceived.raw_imag.is_zero:
        return False
    points = chart({_REAL: perceived.real}, Integer(0), _FIRST_TURNS * turn).points
    # The first point is omega = 0.
    return any(x.orders.get(_REAL, 0) < 0 and _REAL not in x.undecided for x in points[1:])
