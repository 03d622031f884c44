"""A hand that holds a display, and the devices that stand beside it.

A hand that holds a display: m s^2 + b s + k, which stands beside H_perc where both move together.

What stands beside the hand: mass, damping and stiffness of a shunt, whatever its numbers are called.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from sympy import Expr, Integer, Poly, Symbol

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.objects import Shown
from haptisym.kernel.rings import s
from haptisym.model.catalogue import Effect
from haptisym.model.parameters import Parameter, Rule, Slot, read_parameter, renamed, values, with_values
from haptisym.model.quantities import Dimension, MotionKind, Number

_SLOTS = {
    "m": Slot(Dimension.MASS, Rule.NONNEGATIVE, required=False),
    "b": Slot(Dimension.DAMPING, Rule.NONNEGATIVE, required=False),
    "k": Slot(Dimension.STIFFNESS, Rule.NONNEGATIVE, required=False),
}


@dataclass(frozen=True, repr=False)
class Hand(Shown):
    """A hand of mass ``m``, damping ``b`` and stiffness ``k``, each >= 0: quantities or ranges; 0 where it is not given.

    Valid by construction: SceneError names what is wrong. ``m``, ``b`` and ``k`` are then parameters, with symbols of their own.

    >>> Hand("mine", m="0.5 kg", b=["5 N*s/m", "7 N*s/m"]).dynamics
    b_h*s + k_h + m_h*s**2
    """

    name: str
    m: Any = 0
    b: Any = 0
    k: Any = 0
    source: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError(f'hand: name: "{self.name}" must be a string that is not empty')
        for key, slot in _SLOTS.items():
            given = getattr(self, key)
            if not isinstance(given, Parameter):
                object.__setattr__(self, key, read_parameter(key, given, slot, f"{key}_h"))
        kinds = {p.motion: p for p in self.parameters if p.motion}
        if len(kinds) > 1:
            told = " but ".join(f"{p.key} is {motion.value}" for motion, p in kinds.items())
            raise SceneError(f"hand {self.name}: translation and rotation cannot be mixed: {told}")

    def _line(self) -> str:
        return f"{self.name}: {'; '.join(p.stated() for p in self.parameters)}"

    model = "hand"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Mass, damping, stiffness."""
        return self.m, self.b, self.k

    @property
    def motion(self) -> MotionKind | None:
        """Whether it moves along a line or about an axis; None if no unit tells."""
        return next((p.motion for p in self.parameters if p.motion), None)

    @property
    def has_ranges(self) -> bool:
        """Whether it is a box of hands."""
        return any(p.interval for p in self.parameters)

    @property
    def dynamics(self) -> Expr:
        """In its symbols."""
        return self.m.symbol * s**2 + self.b.symbol * s + self.k.symbol

    @property
    def Z(self) -> Expr:
        """With its values: force per position, that of H_perc."""
        return self.dynamics.xreplace(values(self.parameters))

    def with_values(self, given: Mapping[str, Number]) -> Hand:
        """The same hand with other values for the parameters whose symbols have these names."""
        m, b, k = with_values(self.parameters, given)
        return replace(self, m=m, b=b, k=k)

    def renamed(self, names: Mapping[Symbol, Symbol]) -> Hand:
        """The same hand with other symbols for its parameters."""
        m, b, k = renamed(self.parameters, names)
        return replace(self, m=m, b=b, k=k)


def hand(name: str, given: Mapping[str, Any]) -> Hand:
    """The hand that a table says. SceneError names key, value and rule."""
    valid = (*_SLOTS, "source")
    for key in given:
        if key not in valid:
            raise SceneError(f'unknown key "{str(key)[:60]}": {meant(str(key), valid)}valid are {", ".join(valid)}')
    if not isinstance(given.get("source", ""), str):
        raise SceneError(f'source: "{given["source"]}" must be a string')
    return Hand(name, **given)


class _Shipped(Mapping[str, Hand]):
    """The hands that the package ships, by name."""

    def __getitem__(self, name: str) -> Hand:
        if name not in _tables():
            raise SceneError(
                f'there is no hand "{str(name)[:60]}": {meant(str(name), self)}the package ships {", ".join(self)}'
            )
        return hand(name, _tables()[name])

    def __contains__(self, name: object) -> bool:
        return name in _tables()

    def __iter__(self) -> Iterator[str]:
        return iter(_tables())

    def __len__(self) -> int:
        return len(_tables())

    def __repr__(self) -> str:
        return f"<hands {', '.join(self)}>"


hands: Mapping[str, Hand] = _Shipped()
"""The published hands that the package ships, each with its source.

>>> hands["postural-arm"].b.value
129/20
"""


@cache
def _tables() -> Mapping[str, Mapping[str, Any]]:
    return MappingProxyType(tomllib.loads((Path(__file__).parents[1] / "hands.toml").read_text(encoding="utf-8")))


NOBODY = "none"
"""The name of what holds nothing: the display is let go."""


def how_to_give() -> str:
    """How a hand is given to a question, for an error that lacks one."""
    listed = f"haptisym ships {', '.join(hands)}, and {NOBODY} is no hand at all"
    return f"--hand NAME (in Python hand=NAME), or [hand] in the scene; {listed}"


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
