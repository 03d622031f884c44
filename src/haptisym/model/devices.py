"""What stands beside the hand: mass, damping and stiffness of a shunt, whatever its numbers are called."""

from __future__ import annotations

from typing import NamedTuple

from sympy import Expr, Integer, Poly

from haptisym.kernel.symbols import s
from haptisym.model.catalogue import Effect


class Device(NamedTuple):
    """Z = k + b s + m s^2."""

    k: Expr = Integer(0)
    b: Expr = Integer(0)
    m: Expr = Integer(0)


def device(effect: Effect) -> Device | None:
    """That of a shunt, its parameters' values in place; None of another effect, and where Z is none of these.

    >>> from haptisym.effects import compliance, shunt
    >>> device(shunt(Z="b*s^2 + 3*s", parameters={"b": 5}))
    Device(k=0, b=3, m=5)
    >>> device(shunt(Z="s^3")) is device(compliance(k=500)) is None
    True
    """
    Z = effect.matrix[1]
    if effect.model != "shunt" or not Z.is_polynomial(s):
        return None
    row = Poly(Z, s).all_coeffs()[::-1]
    return Device(*row) if len(row) <= len(Device._fields) else None
