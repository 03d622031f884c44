"""The formulas of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from haptisym.kernel.errors import SceneError, several
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.derive.derivation import Derivation


def derive(scene: Scene | Distortion | str | Path, keep: Iterable[str] | None = None) -> Derivation:
    """The formulas of a scene, or of a distortion in its own symbols; ``print`` shows them as a page of text.

    ``keep`` : the names of the parameters that stay symbols; None for all of them and the threshold, () for none. A name
    that the scene does not have raises SceneError, as do names beside a distortion, whose symbols stay.

    >>> found = derive("fu2019", keep=["omega_n"])
    >>> found
    <Derivation "Numerical example of Fu, van Paassen and ...": omega_n as symbols>
    >>> found["H_perc"]
    omega_n**2*(9*s**2 + 75*s + 500)/(5*omega_n**2 + 5*omega_n*s + 5*s**2)
    >>> [x.omega for x in derive("fu2019").changeovers("env")]
    [sqrt(k)/sqrt(m)]
    >>> from haptisym import distort, effects, environments, symbols
    >>> derive(distort(environments.mass_spring_damper(k=100), effects.first_order_lag(symbols("w"))))["Im dH"]
    -100*omega*w/(omega**2 + w**2)
    """
    if isinstance(scene, Distortion):
        return _of_distortion(scene, keep)
    scene = as_scene(scene)
    if keep is None:
        return Derivation(scene, tuple(x.symbol for x in scene.parameters))
    kept = [
        scene.knobs[name].felt()
        for name in ([keep] if isinstance(keep, str) else several("keep", keep, "give names of parameters"))
    ]
    thresholds = tuple(part for part in Part if any(part in x.parts for x in kept))
    return Derivation(scene, tuple(x.symbol for x in kept if not x.parts), thresholds)


def _of_distortion(d: Distortion, keep: Iterable[str] | None) -> Derivation:
    if keep is not None:
        raise SceneError("keep: the symbols of a distortion stay, and its numbers are in place: leave it out")
    if d.elements is None:
        raise SceneError("a distortion of a chain alone has no environment and effects: give what distort() made")
    environment, effects, rendered = d.elements
    return Derivation(Scene(environment, effects, rendered=rendered), ())
