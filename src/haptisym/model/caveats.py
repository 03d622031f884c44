"""What an exact answer about a scene does not say: where the scene's formulas stand for more than they hold."""

from __future__ import annotations

from sympy import Expr, Rational, pi

from haptisym.kernel.roots import sign_of_number
from haptisym.model.catalogue import Effect
from haptisym.model.jnd import Part
from haptisym.model.sampled import CLOCKS
from haptisym.model.scene import Scene


def caveats(scene: Scene) -> tuple[str, ...]:
    """A sentence for each: thresholds of 100 % and more, bands beyond a Nyquist frequency, clocks, holds inside a loop."""
    return (*_thresholds(scene), *_bands(scene), *_loops(scene), *_hand(scene), *_late_mass(scene))


def _late_mass(scene: Scene) -> list[str]:
    """What people report of a delay is not what step 2 makes of it."""
    models = {x.model for x in scene.effects}
    if not {"admittance-display", "delay"} <= models:
        return []
    words = (
        "People who pushed a mass of 6 kg off a late admittance display reported more mass, 10 % at 25 ms and 20 % at 50 ms "
        "(PLoS ONE 10(9), e0138012; as m T/(T - tau) with a push of T = 275 to 300 ms), where step 2 says less."
    )
    return [words]


def clocks(scene: Scene) -> tuple[Expr, ...]:
    """The periods at which parts of a display work by a clock, s."""
    return tuple(
        x.value for effect in scene.effects if effect.model in CLOCKS for x in effect.parameters if x.key == "T"
    )


def sampled_loop(scene: Scene) -> tuple[Effect, Effect] | None:
    """A clock that holds a force, and what brings that back to a clock: an element that yields, or another clock, beyond it.

    Images of the samples then fold back into the band. The closed form (1 - exp(-s T))/(s T) leaves them out, and its poles
    are not those of the sampled loop.
    """
    for i, effect in enumerate(scene.effects):
        if effect.model not in CLOCKS:
            continue
        for other in scene.effects[i + 1 :]:
            if other.model in CLOCKS or other.dynamics[2] != 0:
                return effect, other
    return None


def _loops(scene: Scene) -> list[str]:
    found = sampled_loop(scene)
    if found is None:
        return []
    hold, other = (x.name for x in found)
    words = (
        f"{hold} holds a force that {other} brings back to a clock: images of the samples fold back into the band, and the "
        "closed form leaves them out. It is an approximation here, and does not tell whether the sampled loop is stable; "
        "haptisym stability decides that in a hand, haptisym simulate runs the loop."
    )
    return [words]


def _hand(scene: Scene) -> list[str]:
    """With a clock the hand closes a sampled loop, which may be unstable however stable the force under imposed motion is."""
    clocks = [x.name for x in scene.effects if x.model in CLOCKS]
    if not clocks:
        return []
    work = f"{' and '.join(clocks)} {'works' if len(clocks) == 1 else 'work'} by a clock"
    words = (
        f"{work}, so that hand and display together are a sampled loop. What is said here holds for imposed motion; "
        "haptisym stability decides that loop in a hand."
    )
    return [words]


def _bands(scene: Scene) -> list[str]:
    high = scene.band[1]
    holds = [
        (x.name, pi / x.parameters[0].value) for x in scene.effects if x.model in CLOCKS
    ]  # their one parameter is T
    return [
        f"The band reaches beyond {float(nyquist):.5g} rad/s, the Nyquist frequency of {name}: above it a motion is sampled as "
        "one of a lower frequency, and the closed form tells the component at its own frequency only."
        for name, nyquist in holds
        if not nyquist.free_symbols and sign_of_number(high - nyquist) > 0
    ]


def _thresholds(scene: Scene) -> list[str]:
    return [
        f"The threshold of the {'real' if part is Part.REAL else 'imaginary'} part is {float(100 * c):.5g} % of |H_env|: "
        'a JND of 12 % is written 0.12 or "12 %".'
        for part in (() if scene.threshold.region.corners else Part)
        if not (c := scene.threshold[part]).free_symbols and isinstance(c, Rational) and c >= 1
    ]
