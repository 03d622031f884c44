"""Whether a display is passive, and whether the force under prescribed motion is stable: proven.

A display is a one-port. The hand moves it by X(s) and feels the force F = H_perc(s) X, so that its
impedance F/V, with the velocity V = s X, is Z(s) = H_perc(s)/s. At s = j omega with the amplitude A
it takes the energy pi A^2 Im H_perc(j omega) per cycle.

**Passive.** A display is passive, and so stable in the hand of any passive operator, if and only if
Z is positive real (Brune 1931; Youla, Castriota and Carlin 1959):

1. Re Z = Im H_perc(j omega)/omega >= 0 at all omega > 0 that are no poles,
2. Z has no pole in Re s > 0,
3. its poles on the axis Re s = 0, at 0 and at infinity are simple, with positive residues.

Condition 1 is read off a *chart* (``kernel.roots``: all zeros and signs of a function up to some
frequency) and, above it, off the sign of Im H_perc at high frequency (``asymptotic_sign``).
Conditions 2 and 3 are those of ``poles_allow``.

**Passive parts.** An environment that is a passive one-port, behind passive two-ports (effects with
a chain matrix), is a passive one-port: then no pole need be counted. The wave-variable link is a
line without losses (Niemeyer and Slotine 1991).

**Stable under prescribed motion.** The force is stable where all poles of H_perc lie in Re s < 0.
Let all parts be passive, and let the environment dissipate energy at every omega > 0 and have no
pole on the axis. By condition 2 there is no pole in Re s > 0. Nor is there one on the axis: there a
force would act on a hand at rest, X = 0, into which no energy flows. So none is dissipated, the
environment is at rest, and its force, finite times 0, is 0. As a chain matrix has an inverse, the
force at the hand is 0 too, a contradiction. With delays the poles may still come as near to the
axis as one likes.

Begin with ``passivity`` and ``force_is_stable``. Sampled loops, for which H_perc is an
approximation, are judged by ``judge.colgate``; a chart of them ends at pi/T, with the sampling
period T. A *turn* is the frequency 2 pi/tau, rad/s, in which the phase of the longest delay tau
turns once. The *ring* of H_perc is the polynomial ring in s, exp(-s tau) of each of its delays
(``lags``) and s^alpha of each of its ``orders``; its *axis* the one for s = j omega, with the
*angles* omega tau.
"""

from __future__ import annotations

from collections.abc import Iterable
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

# Turns up to which active intervals are listed where they never end, or go on for too long.
_FIRST_TURNS = 2
# A chart goes up to the frequency at which a sign settles if that is no more turns away. Each turn
# brings some zeros, and nobody reads thousands.
_MOST_TURNS = 500
# Frequencies at which a first guess of the needed damping is looked for: enough to see a resonance
# or two. More would only save a second try.
_GRID = 200
# The share by which a bound is tried below the largest value on the grid: so that it is below the
# supremum in spite of rounding.
_BELOW = 1e-3
# Working precision at which a maximum is compared with a limit; equal numbers never differ.
_BITS = 128
# Seconds for the needed damping: where roots and delays meet, thousands of peaks may have to be
# compared.
_PATIENCE = 10.0
# The key of Re H_perc on a chart of its own.
_REAL = "H_perc"


# The verdict on passivity.


class Beyond(Enum):
    """The sign of Im H_perc above the highest frequency of a chart, or why it is not known.

    The values are printed and stand in documents.
    """

    NEVER = "never negative"
    ALWAYS = "negative everywhere"
    AGAIN = "negative again and again"
    UNKNOWN = "not decided"
    CLOCK = "not looked at: the clock samples no faster motion"
    LATE = "not looked at: the delays turn many times before it settles"


_BEYOND = {
    Sense.POSITIVE: Beyond.NEVER,
    Sense.NEGATIVE: Beyond.ALWAYS,
    Sense.BOTH: Beyond.AGAIN,
    Sense.UNKNOWN: Beyond.UNKNOWN,
}


def passivity(scene: Scene, distortion: Distortion | None = None) -> Passivity:
    """Where a scene with numbers generates energy on [0, infinity): charted at least over its band,
    and the sign above the chart.

    ``distortion`` : that of the scene, if it is known already.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = passivity(load_scene("zener-tissue"))
    >>> found.holds, found.beyond.name, [x.low.omega.digits(7) for x in found.active]
    (False, 'ALWAYS', ['92.70739'])
    """
    d = distortion or scene.closed
    periods = clocks(scene)
    # Above pi/T a sampled display does not see the motion, and its formula means nothing.
    if periods:
        settled = AsymptoticSign(Sense.UNKNOWN)
        high, beyond = pi / max(periods, key=float), Beyond.CLOCK
    else:
        settled = asymptotic_sign(d.perc_response.raw_imag)
        high, is_late = _charted_up_to(scene, d, settled)
        beyond = Beyond.LATE if is_late else _BEYOND[settled.sense]
    # The function of the criterion is its measure -Im H_perc less the limit 0.
    table = chart({PASSIVE: PASSIVE.function(d)}, Integer(0), high)
    return Passivity(scene, d, table, high, beyond, settled)


@dataclass(frozen=True)
class Passivity:
    """Where a display generates energy, and whether it is passive: proven.

    ``chart`` : of -Im H_perc, from 0 to ``high``, rad/s. ``beyond`` : the sign of Im H_perc above
    that. ``settled`` : its sign at high frequency, and from which frequency on; of a scene with a
    clock it is not asked for.

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
        """Whether the display is passive; a sampled one by ``sampled``. None where undecided."""
        # In a sampled loop the sign of H_perc proves nothing about the loop.
        if self.is_active and not sampled_loop(self.scene):
            return False
        if self.sampled is not None:
            return self._sampled_holds()
        # Passive parts need no count of poles, of which there may be infinitely many.
        if self.has_passive_parts:
            return True
        if self.beyond is not Beyond.NEVER or self.chart.undecided:
            return None
        return self.poles_allow

    def _sampled_holds(self) -> bool | None:
        """Whether a sampled display is passive; None where that is undecided."""
        try:
            return self.sampled.passive if self.sampled else None
        except UndecidedError:
            return None

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
        """Whether Im H_perc < 0 is proven at some frequency; False proves nothing above ``high``
        where ``beyond`` is not known, nor below where the chart is undecided."""
        return bool(self.active) or self.stays_active

    @property
    def is_nowhere_active(self) -> bool:
        """Whether Im H_perc >= 0 is proven at all frequencies (of a sampled display, that it is
        passive); False proves nothing."""
        is_charted = self.beyond is Beyond.NEVER and not self.chart.undecided
        return not self.active and bool(is_charted or self.holds)

    @property
    def stays_active(self) -> bool:
        """Whether Im H_perc < 0 is proven at frequencies above every frequency."""
        return self.beyond in (Beyond.ALWAYS, Beyond.AGAIN) or self.active_from is not None

    @property
    def active_from(self) -> Expr | None:
        """The frequency, rad/s, above which Im H_perc < 0 everywhere, where that lies beyond
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
        """Whether H_perc/s satisfies conditions 2 and 3, those on its poles; None where that is
        undecided."""
        return True if self.has_passive_parts else poles_allow(self.distortion.perc)

    @property
    def dissipates(self) -> bool:
        """Whether the display is passive, and Im H_perc > 0 at every omega > 0; False also where
        that is not proven, as with delays and powers s^alpha.

        Up to ``high`` the chart shows it. Above, Im H_perc is never negative
        (``Beyond.NEVER``). Without delays its sign is that of a polynomial in omega, whose highest
        power there exceeds all others together (``asymptotic_sign``): so it is not 0 either.
        """
        ring = ring_of(self.distortion.perc)
        has_waves = bool(ring.lags or ring.orders)
        if not self.holds or self.beyond is not Beyond.NEVER or has_waves:
            return False
        # Signs are those of -Im H_perc. At omega = 0 itself it vanishes, as an odd function.
        signs = {x for point in self.chart.points for x in point.after.values()}
        for point in self.chart.points:
            if float(point.omega) > 0:
                signs.update(point.at.values())
        return signs == {-1}

    @cached_property
    def damping(self) -> LargestValue | None:
        """The damping b* = sup(-Im H_perc/omega), N s/m, at least 0: a hand with more damping is
        stable with the display, whatever its mass and stiffness.

        This holds where the force under prescribed motion is stable. Its frequency is None where
        b* is 0, and where the supremum is only approached, at high frequency. None where it is
        unbounded (``is_unbounded`` is then True) or undecided, as where the sign above ``high`` is
        not known; it is searched for ten seconds at most.
        """
        if self.is_nowhere_active:
            return LargestValue(ExactNumber(Integer(0)), None)
        # Activity that was not found may be above ``high``, and need more damping than 0.
        if not self.is_active or self.beyond is Beyond.CLOCK:
            return None
        try:
            with limited(_PATIENCE):
                return _damping(self.distortion, self.high)
        except UndecidedError:
            return None

    @cached_property
    def is_unbounded(self) -> bool:
        """Whether -Im H_perc/omega is proven to be unbounded at high frequency, so that no damping
        of a hand is enough; False proves nothing.

        Where the display stays active, the power of omega in ``_growth`` is attained. Times powers
        of the cosines of half angles, which do not change it, Im H_perc is N/D with N = omega^p
        W(omega) + lower powers and 0 < D <= const omega^q, W a sum of sines and cosines.
        ``asymptotic_sign`` has proven W <= -d < 0 everywhere, or, for both signs, at one frequency;
        then, as W is almost periodic, W <= -d < 0 at arbitrarily high ones, which can be chosen
        such that no cosine is near 0. So at these -Im H_perc/omega >= const omega^(p - q - 1).
        """
        if not self.stays_active:
            return False
        return sign_of_number(_growth(self.distortion.perc_response.raw_imag) - 1) > 0

    @cached_property
    def most_given(self) -> LargestValue | None:
        """The largest -Im H_perc up to ``high``, N/m, and its frequency: times pi A^2 it is the
        energy per cycle of amplitude A. None if unbounded."""
        return supremum(PASSIVE.measure(self.distortion), Integer(0), self.high)

    def row(self) -> dict[str, Any]:
        """The verdict as a part of a document, rad/s; an interval without an end ends in None."""
        ends: list[list[float | None]] = [
            [float(x.low.omega), float(x.high.omega)] for x in self.active
        ]
        if self.beyond is Beyond.ALWAYS:
            # Im H_perc < 0 at the end of the chart itself too, where the bound of
            # ``asymptotic_sign`` holds already: so the last interval ends there, and goes on.
            ends = [*ends[:-1], [ends[-1][0], None]]
        if self.active_from is not None:
            ends.append([float(self.active_from), None])
        keys = {
            "holds": self.holds,
            "active": ends,
            "beyond": self.beyond.value,
            "reach": float(self.high),
        }
        return {**keys, "poles_allow": self.poles_allow}


# How far a chart goes.


def _charted_up_to(scene: Scene, d: Distortion, settled: AsymptoticSign) -> tuple[Expr, bool]:
    """The highest frequency of a chart of Im H_perc, rad/s, at least that of the band; and whether
    its sign settles, but only after too many turns, beyond the chart."""
    band = scene.band[1]
    is_settled = settled.sense in (Sense.POSITIVE, Sense.NEGATIVE)
    high = most_charted(d, settled.radius) if is_settled else _FIRST_TURNS * _turn(d)
    is_late = is_settled and high != settled.radius
    return (high if sign_of_number(high - band) > 0 else band), is_late


def most_charted(d: Distortion, high: Expr) -> Expr:
    """The frequency up to which a chart is made, rad/s: ``high`` if it is at most ``_MOST_TURNS``
    turns, or if there is no delay; else two turns."""
    turn = _turn(d)
    if turn and sign_of_number(high - _MOST_TURNS * turn) > 0:
        return _FIRST_TURNS * turn
    return high


def _turn(d: Distortion) -> Expr:
    """The turn 2 pi/tau of the longest delay tau, rad/s; 0 where there is no delay."""
    lags = ring_of(d.perc).lags
    return 2 * pi / max(lags, key=float) if lags else Integer(0)


# The damping that a hand needs.


def _damping(d: Distortion, high: Expr) -> LargestValue | None:
    """sup(-Im H_perc/omega) over omega > 0, where it is positive; None where it is unbounded, or no
    bound at high frequency was found. ``high`` : rad/s, at least charted up to there."""
    raw = d.perc_response.raw_imag
    axis: Any = raw.ring
    needed = PASSIVE.measure(d) / RealFunction(axis.convert(omega))
    if _is_wave_over_power(needed):
        # It repeats, or falls with that power: so it is largest within the first turn.
        return supremum(needed, Integer(0), 2 * pi / axis.angles[0].rate)
    for bound in _bounds_to_try(needed, high):
        # -Im H/omega <= bound above the radius where bound omega + Im H >= 0.
        settled = asymptotic_sign(axis.convert(bound * omega) + raw)
        if settled.sense is Sense.POSITIVE:
            far = settled.radius if sign_of_number(settled.radius - high) > 0 else high
            largest = supremum(needed, Integer(0), far)
            # All values below the radius, and so all values, are less than the bound. It is the
            # limit at high frequency, as the other bounds are below a value on the grid.
            if largest and largest.value.ball(_BITS) < ExactNumber(bound).ball(_BITS):
                return LargestValue(ExactNumber(bound), None)
            return largest
    return None


def _is_wave_over_power(f: RealFunction) -> bool:
    """Whether f is a function of sin and cos of one angle omega tau, divided by a power of
    omega."""
    axis: Any = f.axis
    numerator, denominator = f.function.numerator, f.function.denominator
    if numerator.degrees()[0] or len(axis.angles) != 1 or axis.orders:
        return False
    return len({exponents[0] for exponents in denominator.monoms()}) == 1


def _bounds_to_try(needed: RealFunction, high: Expr) -> list[Expr]:
    """Positive bounds at high frequency of -Im H_perc/omega to try, in this order: a little less
    than the largest value on a grid, and, of a rational function, its limit."""
    # The grid is quadratic, denser at low frequencies. It only proposes: ``_damping`` proves.
    lowest: list[float] = []
    with flint.ctx.workprec(64):
        end = float(high)
        for k in range(1, _GRID + 1):
            value = needed.ball(arb(end * (k / _GRID) ** 2))
            lowest.append(float(value.lower()))
    most = max((x for x in lowest if isfinite(x)), default=0.0)
    bounds = [Rational(most * (1 - _BELOW))] if most > 0 else []
    numerator, denominator = needed.function.numerator, needed.function.denominator
    degrees = [int(p.degrees()[0]) for p in (numerator, denominator)]
    if needed.axis.functions or degrees[0] != degrees[1]:
        return bounds
    leading = [needed.axis.coefficients(p)[-1] for p in (numerator, denominator)]
    limit = leading[0] / leading[1]
    return [*bounds, limit] if sign_of_number(limit) > 0 else bounds


# Conditions 2 and 3: the poles of H_perc/s.


def poles_allow(F: RationalFunction) -> bool | None:
    """Whether F/s, F in lowest terms, satisfies conditions 2 and 3, those on the poles of a
    positive real function; None where that is undecided.

    >>> from haptisym.kernel.rings import s
    >>> def of(Z): return poles_allow(Ring.of([s * Z]).convert(s * Z).reduced())
    >>> of(1 / s), of(-1 / s), of(s / (s - 1)), of(s / (s**2 + 1)), of(s**2), of(-s)
    (True, False, False, True, False, False)
    """
    if F.is_zero:
        return True
    try:
        return _poles_satisfy(F, on_axis(F))
    except UndecidedError:
        return None


def has_no_pole_right(f: RationalFunction) -> bool | None:
    """Whether a function in lowest terms has no pole in Re s > 0; None where that is undecided."""
    try:
        poles = count_roots(f.denominator, ring_of(f))
    except UndecidedError:
        return None
    return None if poles.right is None else poles.right == 0


def _poles_satisfy(F: RationalFunction, response: Response) -> bool:
    """As ``poles_allow``, with F(j omega); UndecidedError where it is undecided."""
    # A pole of F at 0 is a multiple one of F/s.
    ring = ring_of(F)
    if order_at_0(F.denominator, ring) > order_at_0(F.numerator, ring):
        return False
    if not _is_allowed_at_infinity(response):
        return False
    count = count_roots(F.denominator, ring)
    if count.right is None:
        raise UndecidedError("where infinitely many poles lie")
    if count.right or _sign_at_0(response.real) < 0:  # F(0) is the residue of F/s at 0
        return False
    on_positive_axis = [float(x) for x in count.on_axis if float(x) > 0]
    if not on_positive_axis:
        return True
    parts = {"real": response.real, "imag": response.imag}
    table = chart(parts, Integer(0), Integer(int(max(on_positive_axis)) + 1))
    for point in table.points:
        if point.undecided:
            raise UndecidedError("whether a pole on the axis has a positive residue")
        real_order, imaginary_order = (point.orders.get(name, 0) for name in parts)
        if min(real_order, imaginary_order) >= 0:
            continue  # no pole
        # Let F/s have the residue r at j omega_0. There F(j omega) is near to r omega_0/(omega -
        # omega_0): for r > 0 real, and it goes to -infinity and comes back from +infinity.
        signs = point.before["real"], point.after["real"]
        if real_order != -1 or signs != (-1, 1) or imaginary_order < 0:
            return False
    return True


def _sign_at_0(real: RealFunction) -> int:
    """The sign of F(0), from its real part; 0 where F(0) = 0."""
    # F is in lowest terms and has no pole at 0: the lowest coefficients of both polynomials decide.
    if not real.axis.functions:
        f = real.function
        lowest = (f.ring.coefficients(p)[0] for p in (f.numerator, f.denominator))
        return prod(map(sign_of_number, lowest))
    first = chart({"real": real}, Integer(0), Integer(1)).points[0]
    return 0 if first.orders.get("real", 0) else first.after["real"]


def _is_allowed_at_infinity(response: Response) -> bool:
    """Whether F/s has no pole at infinity, or a simple one with a positive residue m: whether F
    grows more slowly than s^2, or as m s^2, whose real part is -m omega^2. UndecidedError where the
    sign of the real part at high frequency is not known."""
    parts = (response.raw_real, response.raw_imag)
    growth = max(_growth(x) for x in parts if not x.is_zero)
    faster = sign_of_number(growth - 2)
    if faster:
        return faster < 0
    sense = asymptotic_sign(response.raw_real).sense
    if sense in (Sense.BOTH, Sense.UNKNOWN):
        raise UndecidedError("whether a display is a positive mass at high frequency")
    return sense is Sense.NEGATIVE


def _growth(f: RationalFunction) -> Expr:
    """The exponent with which a function of an axis, not 0, grows at most with omega, where its
    denominator is not small: the highest power of its numerator less that of its denominator."""
    return _highest_power(f.numerator, f.ring) - _highest_power(f.denominator, f.ring)


def _highest_power(polynomial: Any, axis: Any) -> Expr:
    """The highest power of omega in a polynomial of an axis, powers omega^alpha among them."""
    # Exponents are those of omega, pi and the parameters, of the tangent of half of each angle,
    # then of each omega^alpha.
    first = axis.size + len(axis.angles)
    powers: list[Expr] = []
    for exponents in polynomial.monoms():
        power = Integer(int(exponents[0]))
        for n, alpha in zip(exponents[first:], axis.orders, strict=False):
            power = power + int(n) * alpha
        powers.append(power)
    return max(powers)


# Passive parts. All tests here are sufficient ones: False proves nothing.


def environment_alone(scene: Scene) -> Scene | None:
    """The scene without its effects, where these are passive two-ports; None where some are not
    known to be, where there are none, and where something else is rendered."""
    if scene.rendered is not None or not scene.effects or not are_passive(scene.effects):
        return None
    return Scene(scene.environment, (), scene.band)


def are_passive(effects: Iterable[Effect]) -> bool:
    """Whether effects are passive two-ports, by their models; False says nothing of others.

    A shunt is passive if its force per position, the second entry of its matrix, is m s^2 + b s + k
    with no negative number. A compliance always is, as its parameters k and b are positive by their
    rules; a wave-variable link is by its theory.

    >>> from haptisym import effects
    >>> link = effects.wave_variables(10, "20 ms")
    >>> are_passive([link, effects.shunt(m=1)]), are_passive([link, effects.shunt(m=-1)]), are_passive([effects.delay(1)])
    (True, False, False)
    """
    for x in effects:
        is_passive_shunt = x.model == "shunt" and _is_passive_polynomial(x.matrix[1])
        if not is_passive_shunt and x.model not in ("wave-variables", "compliance"):
            return False
    return True


def is_stable_by_parts(scene: Scene, chain: Chain) -> bool:
    """Whether a display coupled to any hand with damping has no root in Re s >= 0 but at 0, because
    no part of the display generates energy. False proves nothing.

    In Re s > 0 the hand's share of Re F/V is positive, and the display's is not negative: their sum
    is not 0. On the axis the hand would not move, nor feel a force: then all that is behind chain
    matrices is at rest too, as they have inverses.
    ``chain`` : the scene's, in which a parameter may be a symbol: then True holds for all of its
    values > 0, but it is False where the symbol stands in a shunt.
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
    symbols in it; False proves nothing.

    Shown by signs alone. The denominator of H has degree 0, 1 or 2 and all of its coefficients are
    there and positive, so that its zeros lie in Re s < 0 (Hurwitz). All coefficients of the
    numerator are positive, and at high frequency H grows no faster than s^2: so H/s has at most
    simple poles at 0 and at infinity, with positive residues. No coefficient of the numerator of
    Im H(j omega) over |denominator|^2 is negative, so that Im H >= 0.

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
    signs = {c > 0 for c in (*numerator.coeffs(), *denominator.coeffs())}
    if len(signs) > 1 or powers not in ({0}, {0, 1}, {0, 1, 2}):
        return False
    # Powers s^alpha in the denominator are not covered; in the numerator they count as growth.
    has_broken_power = any(any(exponents[ring.size :]) for exponents in denominator.monoms())
    if has_broken_power or _highest_power_of_s(numerator, ring) > max(powers) + 2:
        return False
    # Im (a + j b)/(c + j d) has the sign of b c - a d, and keeps it without its factors 1 + tan^2
    # of the angle alpha pi/2 of each power.
    (a, b), (c, d) = axis.parts([numerator, denominator])
    imaginary = axis.without_circles(b * c - a * d)[0]
    return all(x > 0 for x in imaginary.coeffs())


def _highest_power_of_s(polynomial: Polynomial, ring: Ring) -> Expr:
    """The highest power of s in a polynomial, or an upper bound: an order that is a symbol is below
    1."""
    orders = [x if x.is_Rational else Integer(1) for x in ring.orders]
    powers: list[Expr] = []
    for exponents in polynomial.monoms():
        power = Integer(int(exponents[0]))
        for n, alpha in zip(exponents[ring.size :], orders, strict=False):
            power = power + int(n) * alpha
        powers.append(power)
    return max(powers, default=Integer(0))


def _is_passive_polynomial(Z: Expr) -> bool:
    """Whether a dynamics is m s^2 + b s + k with numbers, none of them negative."""
    if not Z.is_polynomial(s):
        return False
    row = Poly(Z, s).all_coeffs()
    are_numbers = all(not x.free_symbols and x.is_real for x in row)
    return len(row) <= 3 and are_numbers and all(sign_of_number(x) >= 0 for x in row)


# Stability under prescribed motion.


def force_is_stable(scene: Scene, distortion: Distortion) -> bool | None:
    """Whether all poles of H_perc have Re s < 0; None where that is undecided, and for a sampled
    loop, whose stability the poles of H_perc do not show. True does not bound their distance from
    the axis: with delays they may approach it at high frequencies.

    First by ``is_stable``. Where infinitely many poles approach the axis it is undecided; then by
    the parts: with an environment that dissipates none reaches the axis (see the module), and a
    display without losses is real on the axis, where its poles can be seen.
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
    no pole on the axis; False proves nothing.

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
    alone, powers of s included; False proves nothing."""
    imaginary = scene.closed.env_response.raw_imag
    return is_positive_real_by_signs(scene.environment.H) and not imaginary.is_zero


def _has_pole_on_axis(distortion: Distortion) -> bool:
    """Whether H_perc is real on the axis, and has a pole among the first turns of its longest
    delay; False proves nothing."""
    perceived, lags = distortion.perc_response, ring_of(distortion.perc).lags
    # Without losses H_perc has no imaginary part on the axis: there its poles are those of a real
    # function, which a chart lists. The first of them is enough.
    if not lags or not perceived.raw_imag.is_zero:
        return False
    high = _FIRST_TURNS * 2 * pi / max(lags)
    points = chart({_REAL: perceived.real}, Integer(0), high).points
    # The first point is omega = 0.
    return any(x.orders.get(_REAL, 0) < 0 and _REAL not in x.undecided for x in points[1:])
