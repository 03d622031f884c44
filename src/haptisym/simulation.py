"""Simulation in time as an independent witness: the force at the hand, and from it back to H_perc.

Design. The hand's motion is prescribed. Each element of the scene adds its equations of motion (``blocks``) to a
network; the algebraic part of these is solved exactly (``descriptor``), which leaves a state equation whose inputs are
the motion and its derivatives, delay lines, and what clocks, friction and quantisers set. Between events it is solved by
SciPy's matrix exponential (``propagate``), events are hit exactly (``engine``). The closed form of H_perc is used nowhere.
Once the transient is over, least squares with sines and cosines of the excited frequencies (a lock-in) recover Re and Im of
H_perc, and these are held against the closed form.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, pi
from typing import Any

import numpy as np

from .blocks import Port, build_effect, build_environment, float_of
from .catalogue import Effect
from .descriptor import Input, StateSpace
from .engine import Engine
from .errors import SceneError
from .lockin import Lock, lock
from .motions import Motion, Sines, multisine, positive, sine
from .network import MOTION, Network, Step, Sum, Switch, name_of
from .numeric import Array
from .quantities import Dimension, Number, quantity
from .quantities import Motion as Kind
from .scene import Scene
from .stability import is_stable

STEP = 0.9
"""Radians of the highest frequency on a step; the error estimate compares with steps that are half as long again."""
_COARSER = 1.5
_MOST_STEPS = 400_000
_FLOOR = 2e-11  # relative: what rounding leaves of a force that is a sum of larger ones


@dataclass(frozen=True)
class EncoderQuantisation:
    """The display measures the hand's motion only in whole multiples of ``resolution``, m or rad (or with a unit)."""

    resolution: Number


@dataclass(frozen=True)
class ForceSaturation:
    """The display can render no force beyond ``limit``, N or N m (or with a unit)."""

    limit: Number


Extra = EncoderQuantisation | ForceSaturation
"""What only simulation knows: neither has a describing function here, and no closed form holds it."""


@dataclass(frozen=True)
class Estimate:
    """H_perc at one excited frequency, rad/s: recovered from the simulated force, and by its closed form. N/m or N m/rad.

    ``error`` bounds the numerical error of ``simulated`` (steps, transient, images; an estimate, not a proof).
    ``agrees`` is None where the closed form itself is an approximation; ``approximate`` then says why.
    """

    omega: float
    simulated: complex
    closed: complex
    error: float
    approximate: str = ""

    @property
    def difference(self) -> float:
        return abs(self.simulated - self.closed)

    @property
    def agrees(self) -> bool | None:
        return None if self.approximate else self.difference <= self.error


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated run. Arrays over time, s: the hand's ``displacement``, m or rad, and ``force``, N or N m, and the same of
    the environment (``environment_displacement``, ``environment_force``). ``estimates``: H_perc at each excited frequency,
    none for a chirp or a recording or where the run is too short. ``built``: the models that were simulated.
    """

    scene: Scene
    motion: Motion
    time: Array = field(repr=False)
    displacement: Array = field(repr=False)
    force: Array = field(repr=False)
    environment_displacement: Array = field(repr=False)
    environment_force: Array = field(repr=False)
    estimates: tuple[Estimate, ...]
    built: tuple[str, ...]
    extras: tuple[Extra, ...] = ()

    @property
    def agrees(self) -> bool | None:
        """Whether all estimates agree with the closed forms; None where no exact closed form could be compared."""
        verdicts = [x.agrees for x in self.estimates if x.agrees is not None]
        return all(verdicts) if verdicts else None

    def __str__(self) -> str:
        from .simtext import page

        return page([self])

    def to_dict(self) -> dict[str, Any]:
        """The document of ``haptisym simulate --json``, schema ``haptisym.simulation/1``."""
        return document([self])

    def to_json(self) -> str:
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)


def simulate(
    scene: Scene,
    motion: Motion,
    *,
    duration: Number | None = None,
    extras: Sequence[Extra] = (),
    progress: Callable[[float], None] | None = None,
) -> Simulation:
    """The force at the hand for a prescribed motion, and H_perc recovered from it at the frequencies of the motion.

    ``duration``: s, or with a unit; as long as the transient and the lock-in need if not given. ``progress`` is called with the
    simulated time, s. Guaranteed: events are hit exactly, and linear parts are integrated without a stability limit; the
    error of each estimate is estimated, not proven. Raises SceneError for scenes that are not stable or not causal, for
    symbols, for motions whose derivatives do not exist or whose unit does not fit, and at and beyond the Nyquist frequency.

    >>> from .scenefile import load_scene
    >>> run = simulate(load_scene("fu2019"), sine("5 cm", 10))
    >>> [estimate] = run.estimates
    >>> run.agrees, bool(abs(estimate.simulated - estimate.closed) < 1e-6 * abs(estimate.closed))
    (True, True)
    """
    _check_scene(scene, motion)
    length = motion.duration if duration is None else positive("duration", duration, Dimension.TIME)
    fine = _Run(scene, motion, extras, STEP, progress)
    if not isinstance(motion, Sines) or (length is not None and length < motion.fade + WINDOW * _period(motion)):
        fine.advance(length or 0.0)
        return _result(fine, ())
    found = fine.locked(length)
    coarse = _Run(scene, motion, extras, STEP * _COARSER, progress)
    other = found if coarse.engine.longest == fine.engine.longest else coarse.again(fine.engine.t)
    return _result(fine, _estimates(fine, found, other))


def check(
    scene: Scene, *, amplitude: Number | None = None, count: int = 10, progress: Callable[[float], None] | None = None
) -> tuple[Simulation, ...]:
    """Simulate along the band of a scene, at ``count`` frequencies: all at once, or, with friction, one after the other.

    >>> from .scenefile import load_scene
    >>> [run] = check(load_scene("zener-tissue"), count=4)
    >>> len(run.estimates), run.agrees
    (4, True)
    """
    size = default_amplitude(scene) if amplitude is None else amplitude
    omegas = band_frequencies(scene, count)
    if any(effect.model == "coulomb-friction" for effect in scene.effects):
        return tuple(simulate(scene, sine(size, omega), progress=progress) for omega in omegas)
    return (simulate(scene, multisine(size, omegas), progress=progress),)


def band_frequencies(scene: Scene, count: int) -> list[float]:
    """Frequencies along the band, whole multiples of one, so that they repeat together."""
    low, high = (float(end) for end in scene.band)
    base = high / (2 * count)
    multiples = [n for n in range(1, 2 * count + 1) if n * base >= low]
    chosen = np.unique(np.round(np.linspace(multiples[0], multiples[-1], min(count, len(multiples)))).astype(int))
    return [float(n * base) for n in chosen]


def default_amplitude(scene: Scene) -> float:
    """That of the scene's friction, or 5 cm (0.05 rad)."""
    given = [float(p.value) for e in scene.effects if e.model == "coulomb-friction" for p in e.parameters if p.key == "amplitude"]
    return given[0] if given else 0.05


def document(runs: Sequence[Simulation]) -> dict[str, Any]:
    """Runs of one scene as the document of schema ``haptisym.simulation/1``."""
    first, rows = runs[0], [x for run in runs for x in run.estimates]
    verdicts = [x.agrees for x in rows if x.agrees is not None]
    return {
        "schema": "haptisym.simulation/1",
        "title": first.scene.title,
        "motion": {
            "kind": first.motion.name,
            "amplitude": first.motion.amplitude,
            "omega": [omega for run in runs for omega in run.motion.omegas],
        },
        "time": [0.0, max(float(run.time[-1]) for run in runs)],
        "samples": sum(len(run.time) for run in runs),
        "built": list(first.built),
        "force": {"least": min(float(r.force.min()) for r in runs), "most": max(float(r.force.max()) for r in runs)},
        "estimates": [_estimate_row(x) for x in rows],
        "agrees": all(verdicts) if verdicts else None,
    }


def _estimate_row(x: Estimate) -> dict[str, Any]:
    return {
        "omega": x.omega,
        "simulated": {"real": x.simulated.real, "imag": x.simulated.imag},
        "closed": {"real": x.closed.real, "imag": x.closed.imag},
        "difference": x.difference,
        "error": x.error,
        "agrees": x.agrees,
        **({"approximate": x.approximate} if x.approximate else {}),
    }


# A run

WINDOW = 4
"""Base periods of a lock-in: the taper needs them to keep neighbouring frequencies apart."""
_ENOUGH = 1e-11  # relative: two windows that agree so well have no transient left
_PATIENCE = 60  # base periods after which a transient is given up on


class _Run:
    """A scene under a motion, being simulated with steps of a given length."""

    def __init__(
        self, scene: Scene, motion: Motion, extras: Sequence[Extra], step: float, progress: Callable[[float], None] | None
    ) -> None:
        self.scene, self.motion, self.extras, self.progress = scene, motion, tuple(extras), progress
        self.net = Network(motion.span)
        self.ports = _build(self.net, scene, motion, self.extras)
        outputs = [(name_of(signal), 0) for port in (self.ports[0], self.ports[-1]) for signal in port]
        longest = step / motion.span[1] if motion.omegas or motion.name == "chirp" else step * pi / motion.span[1]
        self.engine = Engine(self.net, motion, outputs, longest)
        _check_poles(scene, self.engine)
        _check_clocks(self.net, motion)

    def advance(self, until: float) -> None:
        steps = (until - self.engine.t) / self.engine.longest
        if steps > _MOST_STEPS:
            raise SceneError(
                f"duration: {until:.4g} s in steps of {self.engine.longest:.3g} s are more than {_MOST_STEPS} steps; "
                "simulate a shorter time or higher frequencies"
            )
        for end in np.linspace(self.engine.t, until, 1 + int(np.ceil(steps / 500)) if steps > 0 else 1)[1:]:
            self.engine.advance(float(end))
            if self.progress is not None:
                self.progress(self.engine.t)

    def locked(self, length: float | None) -> Lock:
        """Simulate until two windows agree, or as long as is said."""
        period = _period(self.motion)
        self.to_windows(length or self.motion.fade + self._settling() + (WINDOW + 1) * period)
        before, found = inf, self.lock(2)
        while length is None and self.engine.t < self.motion.fade + self._settling() + _PATIENCE * period:
            worst = float((found.drift / np.abs(found.values).max()).max())
            if worst < _ENOUGH or (worst > 0.5 * before and worst < 1e-7) or worst > 100 * before:
                break
            before = worst
            self.advance(self.engine.t + period)
            found = self.lock(2)
        return found

    def to_windows(self, until: float) -> None:
        """Simulate up to a time, with steps that end where windows end: half a step would spoil their quadrature."""
        period = _period(self.motion)
        for back in range(WINDOW + 1, -1, -1):
            self.advance(max(until - back * period, self.engine.t))

    def lock(self, windows: int) -> Lock:
        assert isinstance(self.motion, Sines)
        force = self.engine.signal(name_of(self.ports[-1].F))
        # what a fractional derivative remembers fades as a power of time: too slowly to wait for, but as a parabola
        fading = bool(self.net.fractional)
        return lock(self.engine.record, force, self.motion, WINDOW * _period(self.motion), windows, drift=fading)

    def again(self, until: float) -> Lock:
        """The same window as another run's."""
        self.to_windows(until)
        return self.lock(1)

    def _settling(self) -> float:
        """How long the slowest pole needs to fade to 1e-12, s; what loops with delays need shows only as they run."""
        rates = -self.engine.system.poles().real
        if self.net.fractional or not len(rates):
            return 0.0
        return 28.0 / float(rates.min()) if rates.min() > 0 else 0.0


def _period(motion: Motion) -> float:
    return 2 * pi / motion.span[0]


def _build(net: Network, scene: Scene, motion: Motion, extras: Sequence[Extra]) -> list[Port]:
    """The scene's equations; ports from the environment to the hand."""
    ports = [Port(net.signal("F"), net.signal("X")) for _ in range(len(scene.effects) + 1)]
    near = ports[0]
    for extra in extras:
        near = _build_extra(net, extra, near, scene)
    build_environment(net, scene.rendered or scene.environment, near)
    for effect, inner, outer in zip(scene.effects, ports, ports[1:], strict=False):
        build_effect(net, effect, inner, outer)
    net.equal(ports[-1].X, Sum.of(MOTION))
    return ports


def _build_extra(net: Network, extra: Extra, far: Port, scene: Scene) -> Port:
    """A quantiser or a limit between the environment and the port; the port that is left for the environment."""
    if isinstance(extra, EncoderQuantisation):
        measured = net.signal("measured")
        size = _sized("resolution", extra.resolution, Dimension.DISPLACEMENT, scene)
        net.steps.append(Step(name_of(far.X), name_of(measured), size, "encoder-quantisation"))
        net.built.append("encoder-quantisation")
        return Port(far.F, measured)
    wanted = net.signal("wanted-force")
    limit = _sized("limit", extra.limit, Dimension.FORCE, scene)
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


def _check_scene(scene: Scene, motion: Motion) -> None:
    free = [p for p in scene.parameters if p.value.free_symbols]
    if free:
        raise SceneError(f"{free[0].key} = {free[0].value} is a symbol: a simulation needs numbers")
    _same_kind("motion", motion.kind, scene)


def _check_poles(scene: Scene, engine: Engine) -> None:
    """Raise SceneError, naming the pole, where the scene is not stable."""
    system = engine.system
    fed_back = any(x.lag != 0 and x.name != MOTION and system.propagator.N[:, i].any() for i, (x, _) in enumerate(system.drives))
    poles = system.poles()
    worst = max(poles, key=lambda p: p.real, default=complex(-inf))
    if is_stable(scene.distortion().perc) is False:
        from .rightmost import rightmost_pole

        pole = rightmost_pole(scene.distortion().perc) if fed_back else worst
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


# Results


def _result(run: _Run, estimates: tuple[Estimate, ...]) -> Simulation:
    engine = run.engine
    time = engine.record.instants.ravel()
    columns = [engine.signal(name_of(s)).ravel() for s in (run.ports[-1].F, run.ports[0].X, run.ports[0].F)]
    hand = run.motion.derivatives(time, 0)[0]
    return Simulation(
        run.scene, run.motion, time, hand, columns[0], columns[1], columns[2], estimates, tuple(run.net.built), run.extras
    )  # fmt: skip


def _estimates(run: _Run, found: Lock, other: Lock) -> tuple[Estimate, ...]:
    assert isinstance(run.motion, Sines)
    omegas = np.array(run.motion.omegas)
    values = run.scene.distortion().compile()(omegas)
    closed = values.perceived_real + 1j * values.perceived_imag
    phasors = np.array([run.motion.phasor(omega) for omega in run.motion.omegas])
    simulated = found.values / phasors
    numeric = 2 * (found.drift + np.abs(found.values - other.values)) / np.abs(phasors)
    error = numeric + np.abs(simulated).max() * (_FLOOR + _fractional_error(run.net, omegas))
    why = _why_approximate(run)
    return tuple(
        Estimate(float(w), complex(h), complex(c), float(e), why)
        for w, h, c, e in zip(omegas, simulated, closed, error, strict=True)
    )


def _fractional_error(net: Network, omegas: Array) -> float:
    """How far the bank of relaxations is from s^alpha, relatively, at its worst."""
    if not net.fractional:
        return 0.0
    from .fractional import bank_error

    return 3 * max(bank_error(alpha, (low, high), omegas) for alpha, low, high in net.fractional)


def _why_approximate(run: _Run) -> str:
    """Why the closed form is not what a simulation must give, or nothing."""
    if run.extras:
        return "the closed form knows no quantisation and no saturation"
    system = run.engine.systems[frozenset()]
    assert system is not None
    for switch, effect in zip(run.net.switches, _frictions(run.scene), strict=True):
        reason = _friction_reason(system.exact, switch.driver, effect, run.motion)
        if reason:
            return reason
    for hold in run.net.holds:
        if _jumps_behind(system.exact, run.net, hold.source):
            return f"{hold.name} samples what jumps or comes back to it: its images count, the closed form has the base band"
    return ""


def _frictions(scene: Scene) -> list[Effect]:
    return [effect for effect in scene.effects if effect.model == "coulomb-friction"]


def _friction_reason(system: StateSpace, velocity: str, effect: Effect, motion: Motion) -> str:
    name, amplitude = effect.name, next(float(p.value) for p in effect.parameters if p.key == "amplitude")
    row, hand = system.signal(velocity), system.inputs.index(next(x for x in system.inputs if x.name == MOTION and x.lag == 0))
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
