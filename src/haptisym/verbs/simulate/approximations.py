"""Where a closed form is itself an approximation of what happens in time, so that a simulation must not agree with it."""

from __future__ import annotations

from haptisym.model.catalogue import Effect
from haptisym.model.scene import Scene
from haptisym.verbs.simulate.blocks import float_of
from haptisym.verbs.simulate.descriptor import Input, StateSpace
from haptisym.verbs.simulate.engine import Engine
from haptisym.verbs.simulate.motions import Motion
from haptisym.verbs.simulate.network import MOTION, Network


def why_approximate(engine: Engine, scene: Scene) -> str:
    """Why the closed form is not what a simulation must give, or nothing."""
    system = engine.systems[frozenset()]
    assert system is not None
    for switch, effect in zip(engine.net.frictions, _frictions(scene), strict=True):
        reason = _friction_reason(system.exact, switch.driver, effect, engine.motion)
        if reason:
            return reason
    for hold in engine.net.holds:
        if _jumps_behind(system.exact, engine.net, hold.source):
            return f"{hold.name} samples what jumps or comes back to it: its images count, the closed form has the base band"
    return ""


def _frictions(scene: Scene) -> list[Effect]:
    return [effect for effect in scene.effects if effect.model == "coulomb-friction"]


def _friction_reason(system: StateSpace, velocity: str, effect: Effect, motion: Motion) -> str:
    name, amplitude = effect.name, next(float(p.value) for p in effect.parameters if p.key == "amplitude")
    row, hand = (
        system.signal(velocity),
        system.inputs.index(next(x for x in system.inputs if x.name == MOTION and x.lag == 0)),
    )
    weights = [float_of(c[0, i]) for c in row.inputs for i in range(c.ncols())]
    prescribed = len(row.inputs) > 1 and float_of(row.inputs[1][0, hand]) == 1.0 and sum(map(abs, weights)) == 1.0
    if not prescribed or any(row.state[0, i] != 0 for i in range(system.size)):
        return f"{name} does not move as the hand does: its describing function is an approximation"
    if len(motion.omegas) > 1:
        return f"{name}: a describing function holds for one sine, not for several"
    if abs(motion.amplitude / amplitude - 1) > 1e-12:
        return f"{name}: its describing function is for an amplitude of {amplitude:g}, the hand moves by {motion.amplitude:g}"
    return ""


def _jumps_behind(system: StateSpace, net: Network, source: str) -> set[str]:
    """Clocks and switches that act on a signal, also through delay lines."""
    found: set[str] = set()
    seen, todo = {source}, [source]
    for name in todo:
        if name in net.jumps:
            found.add(name)
            continue
        for channel in _acting(system, name):
            if channel.name != MOTION and channel.name not in seen:
                seen.add(channel.name)
                todo.append(channel.name)
    return found


def _acting(system: StateSpace, name: str) -> list[Input]:
    return [channel for channel in system.inputs if system.reach(name, 0, channel) is not None]
