"""A scene under a motion, being simulated: its equations put together, its dangers checked, its force locked in to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from math import exp, inf, log, pi

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.kernel.rootcount import is_stable
from haptisym.model.quantities import Dimension, Number, quantity
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.scene import Scene
from haptisym.verbs.simulate.blocks import Port, build_controller, build_effect, build_environment
from haptisym.verbs.simulate.descriptor import Reading
from haptisym.verbs.simulate.engine import Engine
from haptisym.verbs.simulate.frictions import join_frictions
from haptisym.verbs.simulate.lockin import Lock, lock
from haptisym.verbs.simulate.motions import Motion, Sines, positive
from haptisym.verbs.simulate.network import MOTION, Network, SignalSum, Step, Switch, name_of
from haptisym.verbs.simulate.results import EncoderQuantisation, Extra

_MOST_STEPS = 400_000
WINDOW = 4
"""Base periods of a lock-in: the taper needs them to keep neighbouring frequencies apart."""
_ENOUGH = 1e-11  # relative: two windows that agree so well have no transient left
_ENOUGH_FRACTIONAL = 1e-8
"""The same where a transient fades only as a power of time."""
_IDLE = 3
"""Base periods without progress after which more of them will not help."""
_NEVER = 0.3
"""Relative: a drift so large after that is no image."""
_PATIENCE = 60  # base periods after which a transient is given up on


class Run:
    """A scene under a motion, being simulated with steps of a given length."""

    def __init__(
        self,
        scene: Scene,
        motion: Motion,
        extras: Sequence[Extra],
        step: float,
        progress: Callable[[float, float], None] | None,
    ) -> None:
        self.scene, self.motion, self.extras, self.progress = scene, motion, tuple(extras), progress
        self.until = 0.0  # where the simulation is known to go on to, s
        self.net = Network(motion.span)
        self.ports = build(self.net, scene, self.extras)
        self.net.equal(self.ports[-1].X, SignalSum.of(MOTION))
        join_frictions(self.net)
        outputs = [(name_of(signal), 0) for port in (self.ports[0], self.ports[-1]) for signal in port]
        longest = step / motion.span[1] if motion.omegas or motion.name == "chirp" else step * pi / motion.span[1]
        self.engine = self._engine(outputs, longest)
        _check_poles(scene, self.engine)
        _check_clocks(self.net, motion)

    def _engine(self, outputs: Sequence[Reading], longest: float) -> Engine:
        try:
            return Engine(self.net, self.motion, outputs, longest)
        except SceneError as error:
            if not self.net.foreign:
                raise
            raise SceneError(
                f"{error}; of {', '.join(self.net.foreign)} only the chain matrix is known: its equations of motion must not "
                "need the future; if they do, build it of the catalogue's effects"
            ) from None

    def advance(self, until: float) -> None:
        """Simulate until a time, s."""
        steps, self.until = (until - self.engine.t) / self.engine.longest, max(until, self.until)
        if steps > _MOST_STEPS:
            raise SceneError(
                f"duration: {until:.4g} s in steps of {self.engine.longest:.3g} s are more than {_MOST_STEPS} steps; "
                "simulate a shorter time or higher frequencies"
            )
        grid = self.engine.longest
        ends = np.linspace(self.engine.t, until, 1 + int(np.ceil(steps / 500)) if steps > 0 else 1)[1:]
        # steps of odd length cost a matrix exponential each; only jumps need windows that end to the point
        whole = np.ceil(ends / grid - 1e-9) * grid
        to_the_point = self.net.jumps or not isinstance(self.motion, Sines)
        for end in [*whole[:-1], *(ends[-1:] if to_the_point else whole[-1:])]:
            self.engine.advance(float(end), self._watch)

    def _watch(self, time: float) -> None:
        if self.progress is not None:
            self.progress(time, self.until)

    def locked(self, length: float | None) -> Lock:
        """Simulate until two windows agree, or as long as is said."""
        assert isinstance(self.motion, Sines)
        period = period_of(self.motion)
        self.to_windows(length or self.motion.fade + self.settling() + (WINDOW + 1) * period)
        found, before, idle, falling = self.lock(2), inf, 0, self._falling(period)
        while (
            length is None and idle < _IDLE and self.engine.t < self.motion.fade + self.settling() + _PATIENCE * period
        ):
            worst = found.relative_drift
            if worst < (_ENOUGH_FRACTIONAL if self.net.fractional else _ENOUGH):
                break
            # images and quantisation do not fade; what a fractional derivative remembers does, but ever more slowly
            idle = idle + 1 if worst > 0.9 * before and not self.net.fractional else 0
            falling, before = max(self._falling(period), worst / before), worst
            for _ in range(round(self.engine.t / period) if self.net.fractional else 1):
                self.advance(self.engine.t + period)
            found = self.lock(2)
        if idle and found.relative_drift > _NEVER:
            raise SceneError("the simulated force does not become periodic: the scene is not stable, or only just")
        falling = min(falling, 0.95)
        # what a transient that falls by this factor in each period has still to go
        return Lock(found.values, found.drift * max(1.0, falling / (1 - falling)))

    def to_windows(self, until: float) -> None:
        """Simulate up to a time, with steps that end where windows end: half a step would spoil their quadrature."""
        period, self.until = period_of(self.motion), max(until, self.until)
        for back in range(WINDOW + 1, -1, -1):
            self.advance(max(until - back * period, self.engine.t))

    def lock(self, windows: int) -> Lock:
        """Amplitudes and phases of the force, from so many of its last windows."""
        assert isinstance(self.motion, Sines)
        force = self.engine.signal(name_of(self.ports[-1].F))
        # what a fractional derivative remembers fades as a power of time: too slowly to wait for, but as a parabola
        fading = bool(self.net.fractional)
        return lock(self.engine.record, force, self.motion, WINDOW * period_of(self.motion), windows, drift=fading)

    def again(self, until: float) -> Lock:
        """The same window as another run's."""
        self.to_windows(until)
        return self.lock(1)

    def settling(self, tolerance: float = 1e-12) -> float:
        """How long the slowest pole needs to fade to that, s; what loops with delays need shows only as they run."""
        return -log(tolerance) / self._slowest if self._slowest else 0.0

    def _falling(self, period: float) -> float:
        """By which factor the slowest pole fades in a period."""
        return exp(-self._slowest * period) if self._slowest else 0.0

    @cached_property
    def _slowest(self) -> float:
        """The smallest rate at which a transient fades, 1/s; 0 where none is known."""
        rates = -self.engine.system.poles().real
        return 0.0 if self.net.fractional or not len(rates) else max(0.0, float(rates.min()))


def least_duration(motion: Sines) -> float:
    """How long a run must last, s, for two windows after the fade-in."""
    return motion.fade + (WINDOW + 1) * period_of(motion) * (1 - 1e-9)


def period_of(motion: Motion) -> float:
    """The longest of its periods, s."""
    return 2 * pi / motion.span[0]


def build(net: Network, scene: Scene, extras: Sequence[Extra] = ()) -> list[Port]:
    """The scene's equations but for what the hand does; ports from the environment to the hand."""
    ports = [Port(net.signal("F"), net.signal("X")) for _ in range(len(scene.effects) + 1)]
    near = ports[0]
    for extra in extras:
        near = _build_extra(net, extra, near, scene)
    if scene.effects and scene.effects[0].renders:
        build_controller(net, scene.effects[0], near)
    else:
        build_environment(net, scene.rendered or scene.environment, near)
    for effect, inner, outer in zip(scene.effects, ports, ports[1:], strict=False):
        build_effect(net, effect, inner, outer)
    return ports


def _build_extra(net: Network, extra: Extra, far: Port, scene: Scene) -> Port:
    """A quantiser or a limit between the environment and the port; the port that is left for the environment."""
    if isinstance(extra, EncoderQuantisation):
        measured = net.signal("measured")
        size = _sized("resolution of the encoder", extra.resolution, Dimension.DISPLACEMENT, scene)
        net.steps.append(Step(name_of(far.X), name_of(measured), size, "encoder-quantisation"))
        net.built.append("encoder-quantisation")
        return Port(far.F, measured)
    wanted = net.signal("wanted-force")
    limit = _sized("limit of the force", extra.limit, Dimension.FORCE, scene)
    closed = wanted - far.F
    net.switches.append(Switch(name_of(far.F), closed, name_of(wanted), limit, limit, "force-saturation"))
    net.built.append("force-saturation")
    return Port(wanted, far.X)


def _sized(key: str, given: Number, dimension: Dimension, scene: Scene) -> float:
    value = positive(key, given, dimension)
    _same_kind(key, quantity(given, dimension).motion, scene)
    return value


def _same_kind(key: str, kind: Kind | None, scene: Scene) -> None:
    if kind is not None and scene.motion is not None and kind is not scene.motion:
        raise SceneError(f"{key}: its unit is {kind.value}, but the scene is {scene.motion.value}")


def check_question(scene: Scene, motion: Motion, extras: Sequence[Extra]) -> None:
    """Raise SceneError for what is no motion, no extra, or has symbols or units that cannot be simulated."""
    if not hasattr(motion, "derivatives"):
        given = f'recording("{motion}")' if isinstance(motion, str) and motion.lower().endswith(".csv") else ""
        makers = given or 'sine("5 cm", "2 Hz"), multisine, chirp or recording("hand.csv")'
        raise SceneError(f"motion: {motion!r:.60} is no motion: make one with {makers}")
    if not isinstance(extras, Sequence) or not all(isinstance(x, Extra) for x in extras):
        raise SceneError(f"extras: {extras!r:.60} is no list of EncoderQuantisation and ForceSaturation")
    scene.knobs.need_numbers()
    _same_kind("motion", motion.kind, scene)


def _check_poles(scene: Scene, engine: Engine) -> None:
    """Raise SceneError, naming the pole, where the scene is not stable."""
    system = engine.system
    fed_back = any(
        x.lag != 0 and x.name != MOTION and system.propagator.N[:, i].any() for i, (x, _) in enumerate(system.drives)
    )
    poles = system.poles()
    worst = max(poles, key=lambda p: p.real, default=complex(-inf))
    if is_stable(scene.distortion().perc) is False:
        from haptisym.verbs.simulate.release import rightmost_pole

        transcendental = fed_back or bool(engine.net.holds)
        pole = rightmost_pole(scene.distortion().perc) if transcendental else worst
        if engine.net.holds and (pole is None or pole.real < 0):
            return  # a clock's factor 1 - exp(-s T) leaves a pole at 0 that is none: whether a loop grows will show
        raise SceneError(f"the scene is not stable{_named(pole)}: there is no steady motion to simulate")
    if not fed_back and worst.real > 1e-9 * max(1.0, float(np.abs(poles).max(initial=0.0))):
        raise SceneError(f"the scene has an inner motion that grows{_named(worst)}, though H_perc does not show it")


def _named(pole: complex | None) -> str:
    if pole is None or not np.isfinite(pole.real):
        return ""
    size = abs(pole.imag)
    return f" (pole at {pole.real:.4g}{f' ± {size:.4g}j' if size > 1e-9 * abs(pole) else ''} 1/s)"


def _check_clocks(net: Network, motion: Motion) -> None:
    for hold in net.holds:
        if motion.omegas and max(motion.omegas) >= pi / hold.period * (1 - 1e-9):
            raise SceneError(
                f"{hold.name}: {max(motion.omegas):.6g} rad/s is not below the Nyquist frequency of its clock, "
                f"{pi / hold.period:.6g} rad/s"
            )
