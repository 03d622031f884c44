"""Scenes that differ in their environment alone: one display, and everything that should be felt through it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from sympy import Expr

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, need
from haptisym.kernel.shown import Shown, titled
from haptisym.kernel.symbols import c
from haptisym.model.jnd import Threshold
from haptisym.model.parameters import free_name
from haptisym.model.quantities import Number, Unit
from haptisym.model.scene import Scene

MOST_ENVIRONMENTS = 100


@dataclass(frozen=True, repr=False)
class SceneFamily(Shown):
    """Scenes by the names of their environments, all with the same effects, band and threshold.

    ``scenes`` : at least one, in order. Valid by construction: SceneError where a scene has other effects, another band or
    another threshold than the first. A mapping: ``family["liver"]``, ``len(family)``, ``for name in family``.

    >>> from haptisym import effects, environments
    >>> lag = (effects.first_order_lag(20),)
    >>> soft, hard = (Scene(environments.kelvin_voigt(k, 2), lag) for k in (100, 1000))
    >>> family = SceneFamily({"soft": soft, "hard": hard})
    >>> list(family), family["hard"].environment.H
    (['soft', 'hard'], 2*s + 1000)
    """

    scenes: Mapping[str, Scene]
    title: str = ""
    source: str = ""

    def _line(self) -> str:
        return f"{titled(self.title)}: {', '.join(self.scenes)}"

    def __post_init__(self) -> None:
        need("environments", self.scenes, Mapping, 'give scenes by name, as {"soft": load_scene(...)}')
        for name, scene in self.scenes.items():
            need(f"environments: {name}", scene, Scene, "give a scene, as load_scene(...) makes one")
        if not 1 <= len(self.scenes) <= MOST_ENVIRONMENTS:
            raise SceneError(f"environments: {len(self.scenes)} were given: at least 1, at most {MOST_ENVIRONMENTS}")
        for name, scene in self.scenes.items():
            if _display(scene) != _display(self.first):
                raise SceneError(f'environments: "{name}" has other effects, another band or another threshold')

    def __getitem__(self, name: str) -> Scene:
        if name not in self.scenes:
            these = "these are" if len(self) > 1 else "there is only"
            raise SceneError(f'there is no environment "{name}": {these} {self.listed()}')
        return self.scenes[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.scenes)

    def __len__(self) -> int:
        return len(self.scenes)

    @property
    def first(self) -> Scene:
        """The first scene, whose effects, band and threshold are those of all."""
        return next(iter(self.scenes.values()))

    @property
    def band(self) -> tuple[Expr, Expr]:
        """Lowest and highest frequency, rad/s."""
        return self.first.band

    @property
    def frequency(self) -> Unit:
        """The unit of frequency in which pages print."""
        return self.first.frequency

    @property
    def threshold(self) -> Threshold:
        """The threshold of all scenes."""
        threshold: Threshold = self.first.threshold
        return threshold

    def at_proportion(self, end: Number) -> SceneFamily:
        """The same with the threshold at another proportion of right answers; SceneError where its own is not told."""
        return replace(self, scenes={name: scene.at_proportion(end) for name, scene in self.scenes.items()})

    def asides(self, besides: Collection[str] = (), varied: Collection[str] | None = ()) -> list[str]:
        """What is to be said beside an answer for all, each thing once: of which scenes, unless it is of all of them."""
        whose: dict[str, list[str]] = {}
        for name, scene in self.scenes.items():
            for note in scene.asides(besides, varied):
                whose.setdefault(note, []).append(name)
        return [x if len(names) == len(self.scenes) else f"{', '.join(names)}: {x}" for x, names in whose.items()]

    def aside_keys(self, besides: Collection[str] = (), varied: Collection[str] | None = ()) -> dict[str, Any]:
        """The same as the key ``nominal`` of a document: the ranges of each scene in which something varies."""
        found = {name: scene.aside_keys(besides, varied).get("nominal") for name, scene in self.scenes.items()}
        ranges = {name: own for name, own in found.items() if own}
        keys = {"confidence": self.level and float(self.level), "nominal": ranges}
        return {key: x for key, x in keys.items() if x}

    @property
    def level(self) -> Expr | None:
        """As of a scene, the lowest."""
        return min((x.level for x in self.scenes.values() if x.level is not None), default=None)

    def listed(self) -> str:
        """The names of the environments in one line."""
        return ", ".join(f'"{name}"' for name in self)

    def only(self) -> Scene:
        """The one scene; SceneError where there are several, which says how to choose."""
        if len(self) > 1:
            raise SceneError(
                f"this scene has {len(self)} environments ({self.listed()}): choose one with --environment NAME "
                '(in Python: load_scene(..., environment="NAME")), or evaluate all of them together with '
                "haptisym evaluate (in Python: evaluate_all(load_scenes(...)))"
            )
        return self.first

    def ring(self) -> Ring:
        """One ring that holds the dynamics of all scenes, so that their functions can be compared exactly."""
        return Ring.of([c, *(entry for scene in self.scenes.values() for entry in scene.distortion().chain.entries())])


def _display(scene: Scene) -> tuple[object, ...]:
    """What the scenes of a family share; effects by their matrices, as symbols differ where an environment uses them too."""
    effects = (
        (e.name, e.settings, tuple(p.value for p in e.parameters) if e.renders else e.matrix) for e in scene.effects
    )
    return tuple(effects), scene.band, scene.threshold


def named(scenes: Iterable[tuple[str, Scene]], title: str = "", source: str = "") -> SceneFamily:
    """A family of scenes under names of their own: the second "liver" becomes "liver-2"."""
    found: dict[str, Scene] = {}
    for name, scene in scenes:
        found[free_name(name, found, "-")] = replace(scene, title=title, source=source)
    return SceneFamily(found, title, source)
