"""A scene under a motion, being simulated: its dangers checked, its force locked in on.

A lock-in: the sines of known frequencies in a signal, by least squares under a taper.

The taper fades a window in and out, so that what is not fitted (images of a clock, harmonics, the last of a transient) leaks
into the fit by orders of magnitude less than through a plain window.

A scene under a motion, being simulated: its equations put together, its dangers checked, its force locked in to.

Where a closed form is itself an approximation of what happens in time, so that a simulation must not agree with it.

What a scene makes of the noise in a recorded motion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import exp, inf, log, pi
from typing import Any

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.kernel.rootcount import is_stable
from haptisym.model.catalogue import Effect
from haptisym.model.quantities import Dimension, Number, quantity
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.simulate.descriptor import Input, Reading, StateSpace
from haptisym.verbs.simulate.engine import Engine
from haptisym.verbs.simulate.frictions import join_frictions
from haptisym.verbs.simulate.motions import Motion, Sines, positive
from haptisym.verbs.simulate.network import (
    MOTION,
    Network,
    Port,
    SignalSum,
    Step,
    Switch,
    build_controller,
    build_effect,
    build_environment,
    float_of,
    name_of,
)
from haptisym.verbs.simulate.propagate import Record
from haptisym.verbs.simulate.results import EncoderQuantisation, Extra


@dataclass(frozen=True, eq=False)
class Lock:
    """Phasors Y with y(t) = Im(Y exp(j omega t)), one for each frequency, and how much they still drift between windows."""

    values: Any
    drift: Array

    @property
    def relative_drift(self) -> float:
        """The largest drift, as a fraction of the largest phasor."""
        return float(self.drift.max() / np.abs(self.values).max())


def lock(record: Record, signal: Array, motion: Sines, window: float, windows: int, *, drift: bool = False) -> Lock:
    """The phasors of a recorded signal in the last window of its record, compared with a window a quarter earlier.

    ``window``: s. With ``windows`` = 1 the two are not compared. ``drift``: fit a parabola along instead of a
    constant; only a constant is orthogonal to harmonics and images. Raises SceneError where the record is too short.
    """
    times = record.instants
    end = float(record.times[record.count - 1] + record.lengths[record.count - 1])
    shift = window / 4 if windows > 1 else 0.0
    if end - window - shift < motion.fade * (1 - 1e-9):
        shift = 0.0
    if end - window < motion.fade * (1 - 1e-9):
        raise SceneError(
            f"duration: {end:g} s are too short to recover H_perc; at least {motion.fade + window:g} s are needed"
        )
    values = _fitted(record, times, signal, motion, (end - window, window, 3 if drift else 1))
    if not shift:
        return Lock(values, np.zeros(len(values)))
    earlier = _fitted(record, times, signal, motion, (end - window - shift, window, 3 if drift else 1))
    return Lock(values, np.abs(values - earlier))


def _fitted(record: Record, times: Array, signal: Array, motion: Sines, window: tuple[float, float, int]) -> Any:
    start, length, terms = window
    place = (times - start) / length
    inside = (place > 0) & (place < 1)
    t, x = times[inside], place[inside]
    weight = np.sin(np.pi * x) ** 4 * record.quadrature[inside]
    angle = np.multiply.outer(t, np.array(motion.omegas))
    trend = np.power.outer(2 * x - 1, np.arange(terms))
    columns = np.concatenate([np.cos(angle), np.sin(angle), trend], axis=1)
    # the columns are nearly orthogonal under the taper: normal equations lose nothing
    weighted = (columns * weight[:, None]).T
    found = np.linalg.solve(weighted @ columns, weighted @ signal[inside])
    count = len(motion.omegas)
    return found[count : 2 * count] + 1j * found[:count]


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
        from haptisym.verbs.simulate.rightmost import rightmost_pole

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


_NOISE = 1e-6  # m or rad
_MUCH = 10.0  # times the largest |H_perc| of the band: noise then matters before anything else does


def noise_notes(scene: Scene, motion: Motion) -> tuple[str, ...]:
    """A sentence for a recording where |H_perc| is far larger at its highest frequency than on the band; none otherwise.

    A mass differentiates a motion twice: what is a micrometre of noise grows with omega^2.
    """
    if motion.omegas or not hasattr(motion, "times"):
        return ()
    lowpass = getattr(motion, "lowpass", None)
    top = lowpass.cutoff if lowpass else motion.span[1]
    low, high = map(float, scene.band)
    values = scene.distortion().compile()(np.array([*np.linspace(low, high, 50), top]))
    sizes = np.hypot(values.perceived_real, values.perceived_imag)
    usual, most = float(np.nanmax(sizes[:-1])), float(sizes[-1])
    if not np.isfinite(most) or most <= _MUCH * usual:
        return ()
    length, force = ("µrad", "N m") if scene.motion is Kind.ROTATION else ("µm", "N")
    where = "the cutoff of its low-pass" if lowpass else "its Nyquist frequency"
    helps = "A lower cutoff removes more." if lowpass else "--lowpass FREQUENCY (zero phase) removes what is above it."
    note = (
        f"Noise of the recording is amplified: 1 {length} at {top / (2 * pi):.4g} Hz, {where}, is {_NOISE * most:.3g} {force} "
        f"at the hand, {most / usual:.3g} times what it is on the band. {helps}"
    )
    return (note,)
