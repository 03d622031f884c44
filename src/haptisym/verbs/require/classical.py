"""The classical bounds on the stiffness of a virtual wall, for scenes that have what they need: drawn beside what is exact.

Colgate and Schenkel (1997): K < 2 (b - |B|)/T, for every passive hand. Gil and Hulin (2009): K < (b + B)/(T/2 + t_d), to first
order in K T^2/m and B T/m, in a hand. b is the damping of the device (in a hand, the hand's with it), B that which is rendered,
T the period of the clock, t_d what the force comes late besides. Abbott and Okamura's 2 f_c/Delta needs the resolution of an
encoder, which no scene has.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from haptisym.model.knobs import Knob
from haptisym.model.sampled import CLOCKS, SAMPLED_LOOP, samples
from haptisym.model.scene import Scene


@dataclass(frozen=True)
class _Wall:
    """What the bounds are made of, in floats: stiffness and damping that are rendered, damping of device and hand, s."""

    K: float
    B: float
    b: float
    hand: float
    T: float
    late: float


@dataclass(frozen=True)
class Line:
    """A bound on the stiffness. ``excess`` : K minus the bound, for values of both free parameters, by path."""

    name: str
    rule: str
    excess: Callable[[Mapping[str, float]], float] = field(repr=False)


def lines(scene: Scene, free: Sequence[Knob]) -> tuple[Line, ...]:
    """Those that hold of a scene's kind and depend on what is free: a wall, a clock or a delay, a damped device."""
    if scene.environment.model not in ("mass-spring-damper", "kelvin-voigt") or scene.rendered is not None:
        return ()
    if any(x.model not in (*CLOCKS, "delay", "shunt") for x in scene.effects):
        return ()
    nominal = {x.path: float(x.value) for x in free}
    if not _depends(scene, nominal):
        return ()

    def of(bound: Callable[[_Wall], float]) -> Callable[[Mapping[str, float]], float]:
        def excess(given: Mapping[str, float]) -> float:
            wall = _wall(scene, given)
            return wall.K - bound(wall)

        return excess

    found = [Line("Gil and Hulin", "K < (b + B)/(T/2 + t_d)", of(lambda w: (w.b + w.hand + w.B) / (w.T / 2 + w.late)))]
    if _wall(scene, nominal).T and not _wall(scene, nominal).late:
        found.append(Line("Colgate and Schenkel", "K < 2 (b - |B|)/T", of(lambda w: 2 * (w.b - abs(w.B)) / w.T)))
    return tuple(found)


def _depends(scene: Scene, nominal: Mapping[str, float]) -> bool:
    """Whether the bounds are there and something free moves them."""
    at = _wall(scene, nominal)
    if at.T / 2 + at.late <= 0:
        return False
    return any(_wall(scene, {**nominal, path: 2 * value + 1}) != at for path, value in nominal.items())


def _wall(scene: Scene, given: Mapping[str, float]) -> _Wall:
    def of(place: str, key: str) -> float:
        return given.get(f"{place}.{key}", known.get(f"{place}.{key}", 0.0))

    known = {x.path: float(x.value) for x in scene.knobs if not x.value.free_symbols}
    places = [(x.model, f"effects.{x.name}") for x in scene.effects]
    T = sum(of(place, "T") for model, place in places if model in CLOCKS)
    late = sum(of(place, "tau") for model, place in places if model == "delay")
    late += sum(of(f"effects.{x.name}", "T") * samples(x) for x in scene.effects if x.model == SAMPLED_LOOP)
    b = sum(of(place, "b") for model, place in places if model == "shunt")
    held = "hand" if len(scene.hands) == 1 else f"hands.{scene.hands[0].name}" if scene.hands else "hand"
    return _Wall(of("environment", "k"), of("environment", "b"), b, of(held, "b"), T, late)
