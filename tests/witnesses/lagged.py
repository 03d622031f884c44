"""A spring behind a lag in a hand: of third order, so that Hurwitz tells by hand whether it is stable."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import haptisym as hs


def lagged(k: Any, m: Any, b: Any, omega_c: Any) -> hs.Scene:
    """m s^3 + (b + m omega_c) s^2 + b omega_c s + k omega_c: stable where b (b + m omega_c) > k m."""
    felt, lag = hs.environments.mass_spring_damper(k=k), hs.effects.first_order_lag(omega_c)
    return hs.Scene(felt, (lag,), hands=(hs.Hand("mine", m=m, b=b),))


def room(k: Any, m: Any, b: Any, omega_c: Any) -> Any:
    """How far it is from the border, > 0 where it is stable."""
    return b * (b + m * omega_c) - k * m


def text(x: list[Fraction]) -> Any:
    """A range as a scene has it, or the one number in it."""
    return [str(y) for y in x] if x[0] != x[1] else str(x[0])
