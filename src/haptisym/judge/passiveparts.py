"""Displays made of parts that only take energy: an environment that does, behind two-ports that do.

A passive one-port behind passive two-ports is passive, however many poles it has: H_perc/s is positive real. And where the
environment takes energy at every frequency and has no pole on the axis, H_perc has no pole there either: with the hand at rest
no energy flows, so that the environment would be at rest, and with it, as a chain matrix has an inverse, all of the chain. So
all poles of H_perc lie in Re s < 0, however near to the axis. Source: Youla, Castriota and Carlin (1959); Niemeyer and Slotine
(1991) for the wave-variable link, which is a line without losses.
"""

from __future__ import annotations

from collections.abc import Iterable

from sympy import Expr, Integer, Poly

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.symbols import s
from haptisym.model.catalogue import Effect
from haptisym.model.chain import Chain
from haptisym.model.scene import Scene


def environment_alone(scene: Scene) -> Scene | None:
    """The scene without its effects, where these are two-ports that only take energy; None where some are not."""
    if scene.rendered is not None or not scene.effects or not are_passive(scene.effects):
        return None
    return Scene(scene.environment, (), scene.band)


def rests(scene: Scene, chain: Chain) -> bool:
    """Whether a display has no root in Re s >= 0 but at 0 in any hand that damps, as nothing in it gives energy.

    In Re s > 0 the hand's share of Re F/V is positive, and the display's is not negative. On the axis the hand would not move,
    nor feel a force: then all that is behind chain matrices is at rest too, as they have inverses. ``chain`` : of the scene, in
    which a number may be open: then it is so for all of its values > 0, and False where it stands in a shunt.
    """
    shunts = [m[1] for x, m in zip(scene.effects, chain.matrices, strict=True) if x.model == "shunt"]
    return environment_alone(scene) is not None and all(map(_takes_energy, shunts)) and takes_energy(chain.environment)


def takes_energy(environment: Expr) -> bool:
    """Whether H/s is positive real, and H finite at all frequencies > 0, for all values > 0 of what is open in it.

    Told by signs alone, False says nothing: Im H >= 0 as no coefficient of it is negative; the denominator has its zeros in
    Re s < 0, as those of degree 2 with coefficients > 0 have; H(0) is finite, and far out H grows no faster than s^2, both > 0.

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
    if len({c > 0 for c in (*top.coeffs(), *bottom.coeffs())}) > 1 or powers not in ({0}, {0, 1}, {0, 1, 2}):
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
        int(x[0]) + sum(int(n) * a for n, a in zip(x[ring.size :], orders, strict=False)) for x in polynomial.monoms()
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
        x.model in ("wave-variables", "compliance") or (x.model == "shunt" and _takes_energy(x.matrix[1]))
        for x in effects
    )


def _takes_energy(Z: Expr) -> bool:
    """Whether a dynamics is m s^2 + b s + k, none of them negative."""
    if not Z.is_polynomial(s):
        return False
    row = Poly(Z, s).all_coeffs()
    return len(row) <= 3 and all(not x.free_symbols and x.is_real and sign_of_number(x) >= 0 for x in row)
