"""The box of all values that the parameters of a scene may have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from sympy import Expr, Rational

from haptisym.kernel.errors import SceneError
from haptisym.model.jnd import Part
from haptisym.model.quantities import MotionKind
from haptisym.model.scene import Knob, Scene


@dataclass(frozen=True)
class Side:
    """A parameter that varies: its symbol's name (``c``, ``c_real`` or ``c_imag`` for a threshold), lowest and highest value."""

    name: str
    low: Expr
    high: Expr
    unit: str = "1"

    def at(self, share: Fraction) -> Expr:
        """The exact value that share of the way from the lowest to the highest."""
        return self.low + Rational(share.numerator, share.denominator) * (self.high - self.low)


@dataclass(frozen=True)
class Box:
    """All values of a scene's parameters within their ranges."""

    scene: Scene

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """What varies, in the order of the scene; the threshold last."""
        return tuple(_side(x) for x in self.scene.ranges().values())

    def values(self, shares: Mapping[str, Fraction]) -> dict[str, Expr]:
        """The exact values of what varies, each that share of its way."""
        return {side.name: side.at(shares[side.name]) for side in self.sides}

    def part_name(self, part: Part) -> str:
        """The name of the side that is a part's threshold, if it varies."""
        return self.scene.knobs.limits[part].name


def _side(x: Knob) -> Side:
    assert x.interval
    return Side(x.name, *x.interval, x.unit_in(x.motion or MotionKind.TRANSLATION))


def box_of(scene: Scene) -> Box:
    """The box of a scene, without sides where ranges are of its hands alone; SceneError without any, or with a symbol."""
    if not scene.threshold.is_box:
        names = " and ".join(scene.threshold.ranges)
        own = f"the JND has a range of {names}, which is no side of a box"
        raise SceneError(f"{own}: `haptisym evaluate` tells its bandwidths; give it a number here")
    box = Box(scene)
    scene.knobs.need_numbers()
    if not box.sides and not any(x.has_ranges for x in scene.hands):
        raise SceneError('no parameter has a range: write one as "1.8 kg +- 5 %" or as ["1.7 kg", "1.9 kg"]')
    return box
