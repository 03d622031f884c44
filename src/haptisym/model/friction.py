"""When friction is noticed: by a Weber law and a floor of its own, not by the JND of damping."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sympy import Expr, Integer, Max

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.roots import sign_of_number
from haptisym.model.quantities import Dimension, MotionKind, number

_KEYS = {"weber": Dimension.RATIO, "floor": Dimension.FORCE, "reference": Dimension.FORCE}


@dataclass(frozen=True)
class FrictionThreshold:
    """A friction force F is noticed as another than ``reference`` where they differ by more than max(floor, weber reference).

    ``weber`` : a fraction, >= 0. ``floor``, ``reference`` : N or N m, >= 0; the reference is what should be felt, 0 if not given.
    Source: Veldhuis, Mulder and van Paassen (2024), doi:10.1109/THMS.2024.3368358 (abstract read): Weber's law where friction is
    large, a detection threshold, which the linear dynamics shift, where it is not.
    """

    weber: Expr = Integer(0)
    floor: Expr = Integer(0)
    reference: Expr = Integer(0)
    motion: MotionKind | None = None

    @property
    def least(self) -> Expr:
        """The least difference that is noticed, N or N m."""
        return Max(self.floor, self.weber * self.reference)


def read_friction(given: Any) -> FrictionThreshold:
    """As a scene gives it: a table. SceneError names key and rule.

    >>> read_friction({"weber": "20 %", "floor": "50 mN", "reference": "0.4 N"}).least
    2/25
    """
    if isinstance(given, FrictionThreshold):
        return given
    if not isinstance(given, Mapping) or not given:
        raise SceneError('friction: must be a table, as { weber = 0.2, floor = "0.05 N" }')
    found: dict[str, Any] = {}
    kinds = set()
    for key, x in given.items():
        if key not in _KEYS:
            raise SceneError(
                f'friction: unknown key "{str(key)[:60]}": {meant(str(key), _KEYS)}valid are {", ".join(_KEYS)}'
            )
        try:
            read = number(x, _KEYS[key])
        except SceneError as error:
            raise error.within(f"friction: {key}") from None
        if read.value.free_symbols or sign_of_number(read.value) < 0:
            raise SceneError(f'friction: {key}: "{x}" must be a number >= 0')
        found[key] = read.value
        kinds |= {read.motion} - {None}
    if len(kinds) > 1:
        raise SceneError("friction: floor and reference: one is a force, the other a torque")
    return FrictionThreshold(**found, motion=next(iter(kinds), None))
