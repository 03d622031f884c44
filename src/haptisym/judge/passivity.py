"""Whether a display is passive, and whether the force under prescribed motion is stable.

Every passive hand may hold it where H_perc/s is positive real: Im H_perc(j omega) >= 0 on [0,
infinity), with a clock up to pi/T; no poles in Re s > 0; those on the axis, at 0 and at infinity
simple, with positive residues. The force is stable where all poles of H_perc lie in Re s < 0.

A passive one-port behind passive two-ports is passive, however many poles it has. And where the
environment takes energy at every frequency and has no pole on the axis, H_perc has no pole there
either: with the hand at rest no energy flows, so that the environment would be at rest, and with
it, as a chain matrix has an inverse, all of the chain. So all poles of H_perc lie in Re s < 0,
however near to the axis. Source: Youla, Castriota and Carlin (1959); Niemeyer and Slotine (1991)
for the wave-variable link, which is a line without losses.
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
    """The scene without its effects, where these are two-ports that only take energy; None where
    some are not."""
    if scene.rendered is not None or not scene.effects or not are_passive(scene.effects):
        return None
    return Scene(scene.environment, (), scene.band)


def rests(scene: Scene, chain: Chain) -> bool:
    """Whether a display has no root in Re s >= 0 but at 0 in any hand that damps, as nothing in it
    gives energy.

    In Re s > 0 the hand's share of Re F/V is positive, and the display's is not negative. On the
    axis the hand would not move, nor feel a force: then all that is behind chain matrices is at
    rest too, as they have inverses. ``chain`` : of the scene, in which a number may be open: then
    it is so for all of its values > 0, and False where it stands in a shunt.
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
    """Whether H/s is positive real, and H finite at all frequencies > 0, for all values > 0 of what
    is open in it.

    Told by signs alone, False says nothing: Im H >= 0 as no coefficient of it is negative; the
    denominator has its zeros in Re s < 0, as those of degree 2 with coefficients > 0 have; H(0) is
    finite, and far out H grows no faster than s^2, both > 0.

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
    powers = {int(x[0]) for x in bottom.monoms()}
    if len({c > 0 for c in (*top.coeffs(), *bottom.coeffs())}) > 1 or powers not in (
        {0},
        {0, 1},
        {0, 1, 2},
    ):
        return False
    if any(any(x[ring.size :]) for x in bottom.monoms()) or _growth(top, ring) > max(powers) + 2:
        return False
    (a, b), (c, d) = axis.parts([top, bottom])
    power = axis.without_circles(b * c - a * d)[0]
    return all(x > 0 for x in power.coeffs())


def _growth(polynomial: Polynomial, ring: Ring) -> Expr:
    """Its highest power of s, or more: an open order is below 1."""
    orders = [x if x.is_Rational else Integer(1) for x in ring.orders]
    powers = (
        int(x[0]) + sum(int(n) * a for n, a in zip(x[ring.size :], orders, strict=False))
        for x in polynomial.monoms()
    )
    return max(powers, default=Integer(0))


def are_passive(effects: Iterable[Effect]) -> bool:
    """Whether effects are two-ports that only take energy, by what they are.

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
    """Whether the poles of F/s, F in lowest terms, are as those of a positive real function; None
    where not decided.

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
    """Whether a function in lowest terms has no pole in Re s > 0; None where not decided."""
    try:
        found = count_roots(f.denominator, ring_of(f))
    except UndecidedError:
        return None
    return None if found.right is None else found.right == 0


def _allowed(F: RationalFunction, response: Response) -> bool:
    ring = ring_of(F)
    if order_at_0(F.denominator, ring) > order_at_0(F.numerator, ring) or not _allowed_far_out(
        response
    ):
        return False
    found = count_roots(F.denominator, ring)
    if found.right is None:
        raise UndecidedError("where infinitely many poles lie")
    if found.right or _sign_at_0(response.real) < 0:  # F(0) is the residue of F/s at 0
        return False
    places = [float(x) for x in found.on_axis if float(x) > 0]
    if not places:
        return True
    table = chart(
        {"real": response.real, "imag": response.imag}, Integer(0), Integer(int(max(places)) + 1)
    )
    poles = [p for p in table.points if min(p.orders.get(name, 0) for name in ("real", "imag")) < 0]
    # with the residue r > 0 F is near omega_0 r/(omega - omega_0): real, it comes back from
    # -infinity as +infinity
    return all(
        p.orders.get("real") == -1
        and (p.before["real"], p.after["real"]) == (-1, 1)
        and p.orders.get("imag", 0) >= 0
        for p in poles
    )


def _sign_at_0(real: RealFunction) -> int:
    """Of F(0)."""
    if not real.axis.functions:
        f = real.function
        return prod(sign_of_number(f.ring.coefficients(p)[0]) for p in (f.numerator, f.denominator))
    first = chart({"real": real}, Integer(0), Integer(1)).points[0]
    return 0 if first.orders.get("real", 0) else first.after["real"]


def _allowed_far_out(response: Response) -> bool:
    """Whether F grows more slowly than s^2, or as a positive mass does."""
    raw = response.raw_real
    grown = max(
        power(x.numerator, x) - power(x.denominator, x)
        for x in (raw, response.raw_imag)
        if not x.is_zero
    )
    faster = sign_of_number(grown - 2)
    if faster:
        return faster < 0
    found = asymptotic_sign(raw).sense
    if found in (Sense.BOTH, Sense.UNKNOWN):
        raise UndecidedError("whether a display is a positive mass at high frequency")
    return found is Sense.NEGATIVE


def power(polynomial: Any, f: RationalFunction) -> Expr:
    """The highest power of omega in a polynomial of an axis, powers omega^alpha among them."""
    axis: Any = f.ring
    first = axis.size + len(axis.angles)
    return max(
        sum((int(n) * x for n, x in zip(e[first:], axis.orders, strict=False)), Integer(int(e[0])))
        for e in polynomial.monoms()
    )


_TURNS = 2  # of the longest delay: as far as is listed what goes on for ever, or for long
_MOST_TURNS = 500  # that are charted where a sign settles later
_GRID = 200
_BELOW = 1e-3
_BITS = 128
_PATIENCE = (
    10.0  # s, as where delays meet in a chain of roots thousands of peaks may have to be compared
)


class Beyond(Enum):
    """What Im H_perc does beyond the reach of a chart."""

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

    ``chart`` : of Im H_perc, from 0 to ``high``. ``beyond`` : what it does above that. ``settled``
    : far out.
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
        """From where on Im H_perc < 0 everywhere, with a gap between ``high`` and that which was
        not looked at; else None."""
        is_late = self.beyond is Beyond.LATE and self.settled.sense is Sense.NEGATIVE
        return self.settled.radius if is_late else None

    @cached_property
    def holds(self) -> bool | None:
        """Whether the display is passive, with a clock by ``sampled``; None where not decided."""
        if self.is_active and not sampled_loop(
            self.scene
        ):  # where the closed form is no approximation
            return False
        if self.sampled is not None:
            return self._sampled_holds()
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
        """With a clock, Colgate and Schenkel's condition."""
        return sampled_passivity(self.scene)

    @cached_property
    def has_passive_parts(self) -> bool:
        """Whether it is made of parts that only take energy."""
        alone = environment_alone(self.scene)
        return alone is not None and passivity(alone).holds is True

    @property
    def takes_energy(self) -> bool:
        """Whether the display is passive, and Im H_perc > 0 at every frequency: for rational
        dynamics."""
        if not self.holds or _ring_of(self.distortion).lags:
            return False
        points = [x for x in self.chart.points if float(x.omega) > 0]
        signs = [x for p in self.chart.points for x in p.after.values()] + [
            x for p in points for x in p.at.values()
        ]
        return not _ring_of(self.distortion).orders and set(signs) == {-1}

    @cached_property
    def poles_allow(self) -> bool | None:
        """Whether H_perc/s has no poles in Re s > 0, and on the axis simple ones with positive
        residues alone."""
        return True if self.has_passive_parts else poles_allow(self.distortion.perc)

    @cached_property
    def damping(self) -> Greatest | None:
        """b* = sup(-Im H_perc/omega), at least 0: with it a hand is held whatever its mass and
        stiffness.

        That, where the force under prescribed motion is stable. Its frequency is None where it is
        only approached, far out.
        None where nothing bounds it, and where that is not decided: ``is_unbounded`` tells. Found
        in ten seconds or not at all.
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
        """Whether -Im H_perc/omega is proven to be unbounded far out, so that no damping of a hand
        is enough."""
        if not self.stays_active:
            return False
        raw = self.distortion.perc_response.raw_imag
        top, below = (power(p, raw) for p in (raw.numerator, raw.denominator))
        return sign_of_number(top - below - 1) > 0

    @cached_property
    def most_given(self) -> Greatest | None:
        """The largest -Im H_perc up to ``high``, N/m, and where: times pi A^2 it is energy per
        cycle. None if unbounded."""
        return greatest(PASSIVE.measure(self.distortion), Integer(0), self.high)

    def row(self) -> dict[str, Any]:
        """As documents have it."""
        ends: list[list[float | None]] = [
            [float(x.low.omega), float(x.high.omega)] for x in self.active
        ]
        if self.beyond is Beyond.ALWAYS:
            ends = [*ends[:-1], [ends[-1][0], None]]
        if self.active_from is not None:
            ends.append([float(self.active_from), None])
        found = {
            "holds": self.holds,
            "active": ends,
            "beyond": self.beyond.value,
            "reach": float(self.high),
        }
        return {**found, "poles_allow": self.poles_allow}


def passivity(scene: Scene, distortion: Distortion | None = None) -> Passivity:
    """Where a scene with numbers gives energy away on [0, infinity): at least as far as its band,
    and what is beyond.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = passivity(load_scene("zener-tissue"))
    >>> found.holds, found.beyond.name, [x.low.omega.digits(7) for x in found.active]
    (False, 'ALWAYS', ['92.70739'])
    """
    d = distortion or scene.closed
    periods = clocks(scene)
    settled = (
        AsymptoticSign(Sense.POSITIVE) if periods else asymptotic_sign(d.perc_response.raw_imag)
    )
    high, is_late = (pi / max(periods, key=float), False) if periods else _reach(scene, d, settled)
    beyond = Beyond.CLOCK if periods else Beyond.LATE if is_late else _BEYOND[settled.sense]
    return Passivity(
        scene, d, chart({PASSIVE: PASSIVE.function(d)}, Integer(0), high), high, beyond, settled
    )


def _reach(scene: Scene, d: Distortion, settled: AsymptoticSign) -> tuple[Expr, bool]:
    """As far as a chart goes: where the sign is settled, else some turns of the delays; the band in
    any case.

    And whether it settles only after too many turns.
    """
    band, is_settled = scene.band[1], settled.sense in (Sense.POSITIVE, Sense.NEGATIVE)
    own = most_charted(d, settled.radius) if is_settled else _TURNS * _turn(d)
    is_late = is_settled and own != settled.radius
    return (own, is_late) if sign_of_number(own - band) > 0 else (band, is_late)


def most_charted(d: Distortion, high: Expr) -> Expr:
    """As far as is looked at, rad/s: all if the longest delay turns some hundred times up to there,
    else two of its turns."""
    turn = _turn(d)
    return _TURNS * turn if turn and sign_of_number(high - _MOST_TURNS * turn) > 0 else high


def _turn(d: Distortion) -> Expr:
    """Of the longest delay, rad/s; 0 where there is none."""
    lags = _ring_of(d).lags
    return 2 * pi / max(lags, key=float) if lags else Integer(0)


def _ring_of(d: Distortion) -> Ring:
    ring = d.perc.ring
    assert isinstance(ring, Ring)
    return ring


# The damping that a hand needs


def _damping(d: Distortion, high: Expr) -> Greatest | None:
    """sup(-Im H_perc/omega): found on a chart that reaches as far as the function may be that
    large."""
    axis: Any = d.perc_response.raw_imag.ring
    raw = d.perc_response.raw_imag
    needed = PASSIVE.measure(d) / RealFunction(axis.convert(omega))
    top, below = needed.function.numerator, needed.function.denominator
    if (
        not top.degrees()[0]
        and len(axis.angles) == 1
        and not axis.orders
        and len({x[0] for x in below.monoms()}) == 1
    ):
        return greatest(
            needed, Integer(0), 2 * pi / axis.angles[0].rate
        )  # a wave, which repeats, or falls with a power
    for value in _tried(needed, high):
        left = asymptotic_sign(axis.convert(value * omega) + raw)
        if left.sense is Sense.POSITIVE:
            reach = left.radius if sign_of_number(left.radius - high) > 0 else high
            found = greatest(needed, Integer(0), reach)
            limit = ExactNumber(value)
            return (
                Greatest(limit, None)
                if found and found.value.ball(_BITS) < limit.ball(_BITS)
                else found
            )
    return None


def _tried(needed: RealFunction, high: Expr) -> list[Expr]:
    """Bounds to try: the limit far out of a rational function, and a little less than the largest
    value seen."""
    with flint.ctx.workprec(64):
        end = float(high)
        seen = (
            float(needed.ball(arb(end * (k / _GRID) ** 2)).lower()) for k in range(1, _GRID + 1)
        )
        most = max((x for x in seen if isfinite(x)), default=0.0)
    found = [Rational(most * (1 - _BELOW))] if most > 0 else []
    top, below = needed.function.numerator, needed.function.denominator
    if needed.axis.functions or int(top.degrees()[0]) != int(below.degrees()[0]):
        return found
    limit = needed.axis.coefficients(top)[-1] / needed.axis.coefficients(below)[-1]
    return [*found, limit] if sign_of_number(limit) > 0 else found


_NAME = "H_perc"


def force_is_stable(scene: Scene, distortion: Distortion) -> bool | None:
    """Whether all poles of H_perc have Re s < 0; None where that is not decided, or they do not
    tell, as with a clock in a loop.

    By ``is_stable``; where that stays open, as infinitely many poles come as near to the axis as
    one likes, by the parts: of an environment that damps none reaches it. A display without losses
    is real on the axis, where its poles show.
    """
    if sampled_loop(scene):
        return None
    found = is_stable(distortion.perc)
    if found is not None:
        return found
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
    if not ring.lags or not perceived.raw_imag.is_zero:
        return False
    high = _TURNS * 2 * pi / max(ring.lags)
    points = chart({_NAME: perceived.real}, Integer(0), high).points
    return any(x.orders.get(_NAME, 0) < 0 and _NAME not in x.undecided for x in points[1:])
