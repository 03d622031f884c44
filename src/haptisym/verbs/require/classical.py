"""The classical bounds on the stiffness of a virtual wall, for scenes that have what they need: to
compare with the exact limits. Begin with ``lines``.

Colgate and Schenkel (1997): K < 2 (b - |B|)/T, for any passive operator. Gil and Hulin (2009): K <
(b + B)/(T/2 + t_d), to first order in K T^2/m and B T/m, in a hand. Abbott and Okamura (2005): K <
2 f_c/Delta beside Colgate's, for any passive operator and a spring alone. b is the damping of the
device (in a hand, the hand's with it), B that which is rendered, T the period of the clock, t_d
what the force comes late besides, f_c the device's Coulomb friction, Delta the step of its encoder.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import s
from haptisym.model.catalogue import CLOCKS, SAMPLED_LOOP, Effect, samples
from haptisym.model.parameters import Slot, read_parameter
from haptisym.model.quantities import Dimension, Number
from haptisym.model.scene import Knob, Scene

STIFFNESS, DAMPING = "environment.k", "environment.b"
"""The paths of a wall's K and B."""


@dataclass(frozen=True)
class _Wall:
    """What the bounds are made of, in SI: stiffness ``K`` and damping ``B`` that are rendered,
    damping ``b`` of the device and ``hand`` of the hand, period ``T`` and further delay
    ``late``."""

    K: float
    B: float
    b: float
    hand: float
    T: float
    late: float


@dataclass(frozen=True)
class StiffnessBound:
    """A bound on the stiffness. ``excess`` : K minus the bound, for values of both free parameters,
    by path.

    ``assumes`` : what it takes for granted. ``where`` : values of free parameters, by path, at
    which alone it is defined.
    """

    name: str
    rule: str
    assumes: str
    excess: Callable[[Mapping[str, float]], float] = field(repr=False)
    where: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Encoder:
    """What a device does that no linear model has: Coulomb friction, N or N m, and the step of its
    encoder, m or rad."""

    friction: float
    resolution: float

    @classmethod
    def of(cls, scene: Scene, friction: Number | None, resolution: Number | None) -> Encoder | None:
        """The encoder as given; None without it. SceneError for one alone, for what is not > 0, for
        a wrong unit."""
        if friction is None and resolution is None:
            return None
        if friction is None or resolution is None:
            missing = "friction" if friction is None else "resolution"
            raise SceneError(
                f"{missing} is missing: Abbott and Okamura's bound 2 f_c/Delta needs "
                f"friction and resolution"
            )
        known = {
            "friction": (friction, Dimension.FORCE),
            "resolution": (resolution, Dimension.DISPLACEMENT),
        }
        read = [read_parameter(key, x, Slot(of), key) for key, (x, of) in known.items()]
        for x in read:
            if scene.motion and x.motion and x.motion is not scene.motion:
                raise SceneError(
                    f"{x.key}: {known[x.key][0]} is {x.motion.value}, but the scene is "
                    f"{scene.motion.value}"
                )
        return cls(*(float(x.value) for x in read))


def lines(
    scene: Scene, free: Sequence[Knob], encoder: Encoder | None = None
) -> tuple[StiffnessBound, ...]:
    """The bounds that are defined for a scene and depend on what is free: for a spring and damper,
    behind a clock or a delay, on a device of mass, damping and stiffness."""
    if not _is_wall(scene):
        return ()
    nominal = {x.path: float(x.value) for x in free}

    def of(bound: Callable[[_Wall], float]) -> Callable[[Mapping[str, float]], float]:
        def excess(given: Mapping[str, float]) -> float:
            wall = _wall(scene, given)
            return wall.K - bound(wall)

        return excess

    found, at = list[StiffnessBound](), _wall(scene, nominal)
    if _depends(scene, nominal):
        small = "K T^2/m and B T/m small, in a hand"
        linear = of(lambda w: (w.b + w.hand + w.B) / (w.T / 2 + w.late))
        found.append(StiffnessBound("Gil and Hulin", "K < (b + B)/(T/2 + t_d)", small, linear))
        # Colgate and Schenkel's closed form is for a force that is not late beyond the clock
        # itself.
        if at.T and not at.late:
            bound = of(lambda w: 2 * (w.b - abs(w.B)) / w.T)
            found.append(
                StiffnessBound(
                    "Colgate and Schenkel",
                    "K < 2 (b - |B|)/T",
                    "any passive operator, no delay",
                    bound,
                )
            )
    if (
        encoder
        and STIFFNESS in nominal
        and at.T
        and not at.late
        and (not at.B or DAMPING in nominal)
    ):
        step = 2 * encoder.friction / encoder.resolution
        words = (
            f"any passive operator, a spring alone (B = 0), no delay, f_c = "
            f"{encoder.friction:.6g}, "
        )
        words += (
            f"Delta = {encoder.resolution:.6g}; in addition to Colgate and Schenkel's bound, not "
            f"in place of it"
        )
        where = ((DAMPING, 0.0),) if DAMPING in nominal else ()
        found.append(
            StiffnessBound(
                "Abbott and Okamura", "K < 2 f_c/Delta", words, of(lambda _: step), where
            )
        )
    return tuple(found)


def need_encoder(scene: Scene, free: Sequence[Knob], encoder: Encoder | None) -> None:
    """SceneError where friction and resolution are given and the bound that they make is not
    defined."""
    if encoder and not any(x.name == "Abbott and Okamura" for x in lines(scene, free, encoder)):
        raise SceneError(
            "friction and resolution make Abbott and Okamura's bound 2 f_c/Delta, which is "
            "not defined here: it is about the "
            f"stiffness ({STIFFNESS}, free) of a spring alone, sampled without delay, on a "
            f"device of mass and damping"
        )


def _is_wall(scene: Scene) -> bool:
    """Whether a scene is a spring and damper behind clocks, delays and a device."""
    if (
        scene.environment.model not in ("mass-spring-damper", "kelvin-voigt")
        or scene.rendered is not None
    ):
        return False
    if any(x.path == "environment.m" and x.value != 0 for x in scene.knobs):
        return False
    return all(
        x.model in (*CLOCKS, "delay") or (x.model == "shunt" and _is_device(x))
        for x in scene.effects
    )


def _is_device(shunt: Effect) -> bool:
    """Whether its m, b and k are mass, damping and stiffness, and no names in a formula of its
    own."""
    powers = {"m": 2, "b": 1, "k": 0}
    known = [(p.symbol, powers[p.key]) for p in shunt.parameters if p.key in powers]
    return bool((shunt.dynamics[1] - sum(x * s**n for x, n in known)).expand() == 0)


def _depends(scene: Scene, nominal: Mapping[str, float]) -> bool:
    """Whether the bounds are there and something free moves them."""
    at = _wall(scene, nominal)
    if at.T / 2 + at.late <= 0:
        return False
    return any(
        # Moved by a trial: any other value shows whether the wall depends on it.
        _wall(scene, {**nominal, path: 2 * value + 1}) != at
        for path, value in nominal.items()
    )


def _wall(scene: Scene, given: Mapping[str, float]) -> _Wall:
    """The wall of a scene, with some parameters at given values, by path."""

    def of(place: str, key: str) -> float:
        return given.get(f"{place}.{key}", known.get(f"{place}.{key}", 0.0))

    known = {x.path: float(x.value) for x in scene.knobs if not x.value.free_symbols}
    places = [(x.model, f"effects.{x.name}") for x in scene.effects]
    T = sum(of(place, "T") for model, place in places if model in CLOCKS)
    late = sum(of(place, "tau") for model, place in places if model == "delay")
    late += sum(
        of(f"effects.{x.name}", "T") * samples(x) for x in scene.effects if x.model == SAMPLED_LOOP
    )
    b = sum(of(place, "b") for model, place in places if model == "shunt")
    held = (
        "hand"
        if len(scene.hands) == 1
        else f"hands.{scene.hands[0].name}"
        if scene.hands
        else "hand"
    )
    return _Wall(of("environment", "k"), of("environment", "b"), b, of(held, "b"), T, late)
