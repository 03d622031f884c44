"""Whether a display is passive, and whether the force under prescribed motion is stable.

A display is passive, and so stable in the hand of any passive operator, where H_perc/s is positive
real: Im H_perc(j omega) >= 0 on [0, infinity), for a sampled display up to pi/T; no poles in Re s >
0; those on the axis, at 0 and at infinity simple, with positive residues. The force is stable under
prescribed motion where all poles of H_perc lie in Re s < 0.

A passive one-port behind passive two-ports is passive, however many poles it has. And where the
environment dissipates energy at every frequency and has no pole on the axis, H_perc has no pole
there either: with the hand at rest no energy flows, so that the environment would be at rest, and
with it, as a chain matrix has an inverse, all of the chain. So all poles of H_perc lie in Re s < 0,
however near to the axis. Source: Youla, Castriota and Carlin (1959); Niemeyer and Slotine (1991)
for the wave-variable link, which is a line without losses.

Begin with ``passivity`` and ``force_is_stable``. Sampled loops are judged by ``judge.colgate``.
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
from haptisym.judge.peaks import Greatest, greatest
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


def environment_alone(scene: Scene) -> Scene | None:
    """The scene without its effects, where these are passive two-ports; None where some are not."""
    if scene.rendered is not None or not scene.effects or not are_passive(scene.effects):
        return None
    return Scene(scene.environment, (), scene.band)


def rests(scene: Scene, chain: Chain) -> bool:
    """Whether a display coupled to any hand with damping has no root in Re s >= 0 but at 0, because
    no part of the display generates energy.

    In Re s > 0 the hand's share of Re F/V is positive, and the display's is not negative. On the
    axis the hand would not move, nor feel a force: then all that is behind chain matrices is at
    rest too, as they have inverses. ``chain`` : the scene's, in which a parameter may be a symbol:
    then True holds for all of its values > 0. False where it stands in a shunt, and says nothing.
    """
    shunts = [
        m[1] for x, m in zip(scene.effects, chain.matrices, strict=True) if x.model == "shunt"
    ]
    return (
        environment_alone(scene) is not None
        and all(map(_takes_energy, shunts))
        and takes_energy(chain.environment)
    )


def takes_energy(environment: Expr) -> bool:
    """Whether H/s is positive real, and H finite at all frequencies > 0, for all values > 0 of the
    symbols in it.

    A sufficient test by signs alone, so that False proves nothing: Im H >= 0 as no coefficient of
    it is negative; the denominator has its zeros in Re s < 0, as those of degree 2 with
    coefficients > 0 have; H(0) is finite, and at high frequency H grows no faster than s^2, both >
    0.

    >>> from sympy.abc import k, q
    >>> each = k + q * s, k * q * s / (k + q * s), k * s**q, 1 / (s**2 + q), k - q * s, q * s - k
    >>> [takes_energy(H) for H in each]
    [True, True, True, False, False, False]
    """
    ring = Ring.of([environment])
    if ring.lags:
        return False
    H, axis = ring.convert(environment).reduced(), ring.axis
    top, bottom = H.numerator, H.denominator
    # Hurwitz: up to degree 2, coefficients of one sign are enough, but none may be missing.
    powers = {int(x[0]) for x in bottom.monoms()}
    signs = {c > 0 for c in (*top.coeffs(), *bottom.coeffs())}
    if len(signs) > 1 or powers not in ({0}, {0, 1}, {0, 1, 2}):
        return False
    # Powers s^alpha in the denominator are not covered; in the numerator they count as growth.
    if any(any(x[ring.size :]) for x in bottom.monoms()) or _growth(top, ring) > max(powers) + 2:
        return False
    # Im (a + j b)/(c + j d) has the sign of b c - a d.
    (a, b), (c, d) = axis.parts([top, bottom])
    power = axis.without_circles(b * c - a * d)[0]
    return all(x > 0 for x in power.coeffs())


def _growth(polynomial: Polynomial, ring: Ring) -> Expr:
    """The highest power of s in a polynomial, or an upper bound: an order that is a symbol is below
    1."""
    orders = [x if x.is_Rational else Integer(1) for x in ring.orders]
    powers = (
        int(x[0]) + sum(int(n) * a for n, a in zip(x[ring.size :], orders, strict=False))
        for x in polynomial.monoms()
    )
    return max(powers, default=Integer(0))


def are_passive(effects: Iterable[Effect]) -> bool:
    """Whether effects are passive two-ports, by their models; False says nothing of others.

    >>> from haptisym import effects
    >>> link = effects.wave_variables(10, "20 ms")
    >>> are_passive([link, effects.shunt(m=1)]), are_passive([link, effects.shunt(m=-1)]), are_passive([effects.delay(1)])
    (True, False, False)
    """
    return all(
        x.model in ("wave-variables", "compliance")
        or (x.model == "shunt" and _takes_energy(x.matrix[1]))
        for x in effects
    )


def _takes_energy(Z: Expr) -> bool:
    """Whether a dynamics is m s^2 + b s + k, none of them negative."""
    if not Z.is_polynomial(s):
        return False
    row = Poly(Z, s).all_coeffs()
    return len(row) <= 3 and all(
        not x.free_symbols and x.is_real and sign_of_number(x) >= 0 for x in row
    )


def poles_allow(F: RationalFunction) -> bool | None:
    """Whether the poles of F/s, F in lowest terms, satisfy the conditions on those of a positive
    real function; None where that is undecided.

    >>> from haptisym.kernel.rings import s
    >>> def of(Z): return poles_allow(Ring.of([s * Z]).convert(s * Z).reduced())
    >>> of(1 / s), of(-1 / s), of(s / (s - 1)), of(s / (s**2 + 1)), of(s**2), of(-s)
    (True, False, False, True, False, False)
    """
    if F.is_zero:
        return True
    try:
        return _allowed(F, on_axis(F))
    except UndecidedError:
        return None


def has_no_pole_right(f: RationalFunction) -> bool | None:
    """Whether a function in lowest terms has no pole in Re s > 0; None where that is undecided."""
    try:
        poles = count_roots(f.denominator, ring_of(f))
    except UndecidedError:
        return None
    return None if poles.right is None else poles.right == 0


def _allowed(F: RationalFunction, response: Response) -> bool:
    """As ``poles_allow``; UndecidedError where it is undecided."""
    # A pole of F at 0 is a multiple one of F/s.
    ring = ring_of(F)
    if order_at_0(F.denominator, ring) > order_at_0(F.numerator, ring):
        return False
    if not _allowed_far_out(response):
        return False
    count = count_roots(F.denominator, ring)
    if count.right is None:
        raise UndecidedError("where infinitely many poles lie")
    if count.right or _sign_at_0(response.real) < 0:  # F(0) is the residue of F/s at 0
        return False
    places = [float(x) for x in count.on_axis if float(x) > 0]
    if not places:
        return True
    parts = {"real": response.real, "imag": response.imag}
    table = chart(parts, Integer(0), Integer(int(max(places)) + 1))
    poles = [p for p in table.points if min(p.orders.get(name, 0) for name in parts) < 0]
    # With the residue r > 0, F is near omega_0 r/(omega - omega_0): real, it comes back from
    # -infinity as +infinity.
    return all(
        p.orders.get("real") == -1
        and (p.before["real"], p.after["real"]) == (-1, 1)
        and p.orders.get("imag", 0) >= 0
        for p in poles
    )


def _sign_at_0(real: RealFunction) -> int:
    """The sign of F(0), from its real part."""
    # F is in lowest terms and has no pole at 0: the lowest coefficients of both polynomials decide.
    if not real.axis.functions:
        f = real.function
        return prod(sign_of_number(f.ring.coefficients(p)[0]) for p in (f.numerator, f.denominator))
    first = chart({"real": real}, Integer(0), Integer(1)).points[0]
    return 0 if first.orders.get("real", 0) else first.after["real"]


def _allowed_far_out(response: Response) -> bool:
    """Whether F grows more slowly than s^2, or as a positive mass does, whose real part is -m
    omega^2."""
    raw = response.raw_real
    grown = max(
        power(x.numerator, x) - power(x.denominator, x)
        for x in (raw, response.raw_imag)
        if not x.is_zero
    )
    faster = sign_of_number(grown - 2)
    if faster:
        return faster < 0
    sense = asymptotic_sign(raw).sense
    if sense in (Sense.BOTH, Sense.UNKNOWN):
        raise UndecidedError("whether a display is a positive mass at high frequency")
    return sense is Sense.NEGATIVE


def power(polynomial: Any, f: RationalFunction) -> Expr:
    """The highest power of omega in a polynomial of an axis, powers omega^alpha among them."""
    axis: Any = f.ring
    first = axis.size + len(axis.angles)
    return max(
        sum((int(n) * x for n, x in zip(e[first:], axis.orders, strict=False)), Integer(int(e[0])))
        for e in polynomial.monoms()
    )


_TURNS = 2  # of the longest delay: how far activity is listed that goes on for ever, or for long
_MOST_TURNS = 500  # of the longest delay: a chart goes no further to where a sign settles
_GRID = 200  # frequencies at which a first guess of the needed damping is looked for
_BELOW = 1e-3  # by what share a bound is tried below the largest value seen
_BITS = 128  # of balls that compare a maximum with a limit
_PATIENCE = 10.0  # s: where roots and delays meet, thousands of peaks may have to be compared


class Beyond(Enum):
    """The sign of Im H_perc above the highest frequency of a chart."""

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


@dataclass(frozen=True)
class Passivity:
    """Where a display generates energy, and whether it is passive: proven.

    ``chart`` : of -Im H_perc, from 0 to ``high``, rad/s. ``beyond`` : the sign of Im H_perc above
    that. ``settled`` : its sign at high frequency, and from which frequency on.
    """

    scene: Scene
    distortion: Distortion
    chart: Chart
    high: Expr
    beyond: Beyond
    settled: AsymptoticSign = AsymptoticSign(Sense.UNKNOWN)

    @cached_property
    def active(self) -> tuple[Interval, ...]:
        """Where Im H_perc < 0, up to ``high``: the display gives -pi A^2 Im H_perc per cycle of
        amplitude A."""
        return self.chart.where(lambda signs: signs[PASSIVE] > 0)

    @property
    def is_active(self) -> bool:
        """Whether Im H_perc < 0 anywhere."""
        return bool(self.active) or self.stays_active

    @property
    def stays_active(self) -> bool:
        """Whether Im H_perc < 0 at frequencies above every frequency."""
        return self.beyond in (Beyond.ALWAYS, Beyond.AGAIN) or self.active_from is not None

    @property
    def active_from(self) -> Expr | None:
        """The frequency, rad/s, above which Im H_perc < 0 everywhere, where that lies beyond
        ``high`` and the gap between them was not examined; otherwise None."""
        is_late = self.beyond is Beyond.LATE and self.settled.sense is Sense.NEGATIVE
        return self.settled.radius if is_late else None

    @cached_property
    def holds(self) -> bool | None:
        """Whether the display is passive; a sampled one by ``sampled``. None where undecided."""
        # In a sampled loop H_perc is an approximation, whose sign proves nothing about the loop.
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
        try:
            return self.sampled.passive if self.sampled else None
        except UndecidedError:
            return None

    @cached_property
    def sampled(self) -> SampledPassivity | None:
        """Colgate and Schenkel's condition for a sampled display; None for any other."""
        return sampled_passivity(self.scene)

    @cached_property
    def has_passive_parts(self) -> bool:
        """Whether the display is made of passive parts: an environment behind passive two-ports."""
        alone = environment_alone(self.scene)
        return alone is not None and passivity(alone).holds is True

    @property
    def takes_energy(self) -> bool:
        """Whether the display is passive, and Im H_perc > 0 at every frequency: for rational
        dynamics."""
        if not self.holds or _ring_of(self.distortion).lags:
            return False
        # Signs are those of -Im H_perc. At omega = 0 itself it vanishes, as an odd function.
        points = [x for x in self.chart.points if float(x.omega) > 0]
        between = {x for p in self.chart.points for x in p.after.values()}
        at_points = {x for p in points for x in p.at.values()}
        return not _ring_of(self.distortion).orders and between | at_points == {-1}

    @cached_property
    def poles_allow(self) -> bool | None:
        """Whether H_perc/s has no poles in Re s > 0, and on the axis simple ones with positive
        residues alone."""
        return True if self.has_passive_parts else poles_allow(self.distortion.perc)

    @cached_property
    def damping(self) -> Greatest | None:
        """The damping b* = sup(-Im H_perc/omega), N s/m, at least 0: a hand with more damping is
        stable with the display, whatever its mass and stiffness.

        This holds where the force under prescribed motion is stable. Its frequency is None where
        the supremum is only approached, at high frequency. None where it is unbounded
        (``is_unbounded`` is then True) or undecided; it is searched for ten seconds at most.
        """
        if not self.is_active:
            return Greatest(ExactNumber(Integer(0)), None)
        if self.beyond is Beyond.CLOCK:
            return None
        try:
            with limited(_PATIENCE):
                return _damping(self.distortion, self.high)
        except UndecidedError:
            return None

    @cached_property
    def is_unbounded(self) -> bool:
        """Whether -Im H_perc/omega is proven to be unbounded at high frequency, so that no damping
        of a hand is enough."""
        if not self.stays_active:
            return False
        raw = self.distortion.perc_response.raw_imag
        top, below = (power(p, raw) for p in (raw.numerator, raw.denominator))
        return sign_of_number(top - below - 1) > 0

    @cached_property
    def most_given(self) -> Greatest | None:
        """The largest -Im H_perc up to ``high``, N/m, and its frequency: times pi A^2 it is the
        energy per cycle of amplitude A. None if unbounded."""
        return greatest(PASSIVE.measure(self.distortion), Integer(0), self.high)

    def row(self) -> dict[str, Any]:
        """The verdict as a part of a document, rad/s."""
        ends: list[list[float | None]] = [
            [float(x.low.omega), float(x.high.omega)] for x in self.active
        ]
        if self.beyond is Beyond.ALWAYS:
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


def passivity(scene: Scene, distortion: Distortion | None = None) -> Passivity:
    """Where a scene with numbers generates energy on [0, infinity): charted at least over its band,
    and the sign above the chart.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = passivity(load_scene("zener-tissue"))
    >>> found.holds, found.beyond.name, [x.low.omega.digits(7) for x in found.active]
    (False, 'ALWAYS', ['92.70739'])
    """
    d = distortion or scene.closed
    periods = clocks(scene)
    # Above pi/T a sampled display does not see the motion, and its formula means nothing.
    if periods:
        settled = AsymptoticSign(Sense.POSITIVE)
        high, beyond = pi / max(periods, key=float), Beyond.CLOCK
    else:
        settled = asymptotic_sign(d.perc_response.raw_imag)
        high, is_late = _reach(scene, d, settled)
        beyond = Beyond.LATE if is_late else _BEYOND[settled.sense]
    table = chart({PASSIVE: PASSIVE.function(d)}, Integer(0), high)
    return Passivity(scene, d, table, high, beyond, settled)


def _reach(scene: Scene, d: Distortion, settled: AsymptoticSign) -> tuple[Expr, bool]:
    """The highest frequency of a chart, rad/s, at least that of the band: where the sign is
    settled, or else some turns of the longest delay. And whether it settles only after too many
    turns."""
    band, is_settled = scene.band[1], settled.sense in (Sense.POSITIVE, Sense.NEGATIVE)
    wanted = most_charted(d, settled.radius) if is_settled else _TURNS * _turn(d)
    is_late = is_settled and wanted != settled.radius
    return (wanted, is_late) if sign_of_number(wanted - band) > 0 else (band, is_late)


def most_charted(d: Distortion, high: Expr) -> Expr:
    """The frequency up to which a chart is made, rad/s: ``high`` if the longest delay turns at most
    ``_MOST_TURNS`` times up to there, or else two of its turns."""
    turn = _turn(d)
    return _TURNS * turn if turn and sign_of_number(high - _MOST_TURNS * turn) > 0 else high


def _turn(d: Distortion) -> Expr:
    """The frequency 2 pi/tau of the longest delay tau, rad/s; 0 where there is none."""
    lags = _ring_of(d).lags
    return 2 * pi / max(lags, key=float) if lags else Integer(0)


def _ring_of(d: Distortion) -> Ring:
    ring = d.perc.ring
    assert isinstance(ring, Ring)
    return ring


# The damping that a hand needs


def _damping(d: Distortion, high: Expr) -> Greatest | None:
    """sup(-Im H_perc/omega), from a chart that reaches as far as the function may be that large;
    None where it is unbounded, or no bound at high frequency was found."""
    axis: Any = d.perc_response.raw_imag.ring
    raw = d.perc_response.raw_imag
    needed = PASSIVE.measure(d) / RealFunction(axis.convert(omega))
    top, below = needed.function.numerator, needed.function.denominator
    # A wave of one delay, over a single power of omega: it repeats, or falls with that power, so it
    # is largest within its first turn.
    is_one_wave = not top.degrees()[0] and len(axis.angles) == 1 and not axis.orders
    if is_one_wave and len({x[0] for x in below.monoms()}) == 1:
        return greatest(needed, Integer(0), 2 * pi / axis.angles[0].rate)
    for value in _tried(needed, high):
        # Above some radius -Im H_perc/omega is at most this value: what is larger lies below, and a
        # chart up to there finds it. If nothing on it is, the value is a limit that is not
        # attained.
        left = asymptotic_sign(axis.convert(value * omega) + raw)
        if left.sense is Sense.POSITIVE:
            reach = left.radius if sign_of_number(left.radius - high) > 0 else high
            largest = greatest(needed, Integer(0), reach)
            limit = ExactNumber(value)
            if largest and largest.value.ball(_BITS) < limit.ball(_BITS):
                return Greatest(limit, None)
            return largest
    return None


def _tried(needed: RealFunction, high: Expr) -> list[Expr]:
    """Bounds at high frequency to try, in this order: a little less than the largest value on a
    grid, and, of a rational function, its limit."""
    # The grid is quadratic, denser at low frequencies. It only proposes: ``_damping`` proves.
    with flint.ctx.workprec(64):
        end = float(high)
        seen = (
            float(needed.ball(arb(end * (k / _GRID) ** 2)).lower()) for k in range(1, _GRID + 1)
        )
        most = max((x for x in seen if isfinite(x)), default=0.0)
    bounds = [Rational(most * (1 - _BELOW))] if most > 0 else []
    top, below = needed.function.numerator, needed.function.denominator
    if needed.axis.functions or int(top.degrees()[0]) != int(below.degrees()[0]):
        return bounds
    limit = needed.axis.coefficients(top)[-1] / needed.axis.coefficients(below)[-1]
    return [*bounds, limit] if sign_of_number(limit) > 0 else bounds


_NAME = "H_perc"


def force_is_stable(scene: Scene, distortion: Distortion) -> bool | None:
    """Whether all poles of H_perc have Re s < 0; None where that is undecided, and for a sampled
    loop, whose stability the poles of H_perc do not show.

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
        if alone and (passivity(alone).takes_energy or _damps(alone)):
            return True
        return False if _has_pole_on_axis(distortion) else None
    except UndecidedError:
        return None


def _damps(scene: Scene) -> bool:
    """Whether Im H_env > 0 at every frequency > 0 by signs alone, powers of s included."""
    return takes_energy(scene.environment.H) and not scene.closed.env_response.raw_imag.is_zero


def _has_pole_on_axis(distortion: Distortion) -> bool:
    """Whether H_perc is real on the axis, and has a pole among the first turns of its longest
    delay."""
    perceived, ring = distortion.perc_response, distortion.perc.ring
    assert isinstance(ring, Ring)
    # Without losses H_perc has no imaginary part on the axis: there its poles are those of a real
    # function, which a chart lists. The first of them is enough.
    if not ring.lags or not perceived.raw_imag.is_zero:
        return False
    high = _TURNS * 2 * pi / max(ring.lags)
    points = chart({_NAME: perceived.real}, Integer(0), high).points
    return any(x.orders.get(_NAME, 0) < 0 and _NAME not in x.undecided for x in points[1:])
