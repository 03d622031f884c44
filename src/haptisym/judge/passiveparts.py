"""Displays made of parts that only take energy: an environment that does, behind two-ports that do.

A passive one-port behind passive two-ports is passive, however many poles it has: H_perc/s is positive real. And where the
environment takes energy at every frequency and has no pole on the axis, H_perc has no pole there either: with the hand at rest
no energy flows, so that the environment would be at rest, and with it, as a chain matrix has an inverse, all of the chain. So
all poles of H_perc lie in Re s < 0, however near to the axis. Source: Youla, Castriota and Carlin (1959); Niemeyer and Slotine
(1991) for the wave-variable link, which is a line without losses.
"""

from __future__ import annotations

from collections.abc import Iterable

from sympy import Expr, Poly

from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.symbols import s
from haptisym.model.catalogue import Effect
from haptisym.model.scene import Scene


def environment_alone(scene: Scene) -> Scene | None:
    """The scene without its effects, where these are two-ports that only take energy; None where some are not."""
    if scene.rendered is not None or not scene.effects or not are_passive(scene.effects):
        return None
    return Scene(scene.environment, (), scene.band)


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
