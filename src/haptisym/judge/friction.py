"""Whether the friction of a display is noticed: a percept of its own, beside stiffness, mass and damping."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from sympy import Add, Expr

from haptisym.kernel.roots import sign_of_number
from haptisym.model.scene import Scene

_MODEL = "coulomb-friction"


@dataclass(frozen=True)
class Friction:
    """``force`` : of the display's elements together, N or N m. ``least`` : the least difference from ``reference`` noticed.

    ``noticed`` : None where the scene does not say when friction is.
    """

    force: Expr
    reference: Expr | None
    least: Expr | None
    noticed: bool | None

    def row(self) -> dict[str, Any]:
        """As a document has it."""
        numbers = {"force": self.force, "reference": self.reference, "threshold": self.least}
        return {key: None if x is None else float(x) for key, x in numbers.items()} | {"noticed": self.noticed}


def frictions(scene: Scene) -> Friction | None:
    """The friction of a scene with numbers; None without any."""
    forces = [x.value for e in scene.effects if e.model == _MODEL for x in e.parameters if x.key == "force"]
    if not forces:
        return None
    force, own = Add(*forces), scene.friction
    if own is None:
        return Friction(force, None, None, None)
    change = force - own.reference
    size = change if sign_of_number(change) >= 0 else -change
    return Friction(force, own.reference, own.least, sign_of_number(size - own.least) > 0)


def without_friction(scene: Scene) -> Scene:
    """The scene without its friction."""
    return replace(scene, effects=tuple(x for x in scene.effects if x.model != _MODEL))
