"""The box of all values that the parameters of a scene may have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

from sympy import Expr, Rational

from haptisym.kernel.errors import SceneError
from haptisym.model.jnd import Part, Threshold
from haptisym.model.quantities import Motion
from haptisym.model.scene import Scene


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
        return tuple(self._sides())

    def _sides(self) -> Iterator[Side]:
        for p in self.scene.parameters:
            if p.interval:
                yield Side(p.symbol.name, *p.interval, p.dimension.unit(self.scene.motion or Motion.TRANSLATION))
        c = self.scene.threshold
        if c.real_interval and c.real_interval == c.imag_interval:
            yield Side("c", *c.real_interval)
            return
        for name, interval in (("c_real", c.real_interval), ("c_imag", c.imag_interval)):
            if interval:
                yield Side(name, *interval)

    def values(self, shares: Mapping[str, Fraction]) -> dict[str, Expr]:
        """The exact values of what varies, each that share of its way."""
        return {side.name: side.at(shares[side.name]) for side in self.sides}

    def scene_at(self, values: Mapping[str, Expr]) -> Scene:
        """The scene with these exact values, by name; what is not named keeps its nominal value."""
        limits = {"c_real", "c_imag", "c"} & {side.name for side in self.sides}
        scene = self.scene.with_values({name: x for name, x in values.items() if name not in limits})
        c = self.scene.threshold
        both = (values.get(f"c_{part.value}", values.get("c", c[part])) if limits else c[part] for part in Part)
        return replace(scene, threshold=Threshold(*both))

    def part_name(self, part: Part) -> str:
        """The name of the side that is a part's threshold, if it varies."""
        return "c" if any(side.name == "c" for side in self.sides) else f"c_{part.value}"


def box_of(scene: Scene) -> Box:
    """The box of a scene; SceneError if no parameter of it has a range, or one is still a symbol."""
    box = Box(scene)
    free = next((p for p in scene.parameters if p.value.free_symbols), None)
    if free is not None:
        raise SceneError(f"{free.key} = {free.value} is a symbol: tolerances need numbers")
    if not box.sides:
        raise SceneError('no parameter has a range: write one as "1.8 kg +- 5 %" or as ["1.7 kg", "1.9 kg"]')
    return box
