"""Simulation in time as an independent check: the force at the hand, and from it back to H_perc.

The hand's motion is prescribed. Each element of the scene adds its equations of motion
(``network``); their algebraic part is solved exactly (``statespace``), and between events they are
integrated exactly (``engine``). The closed form of H_perc is used nowhere. Once the transient is
over, a lock-in recovers Re and Im of H_perc: least squares with sines and cosines of the excited
frequencies, under a taper that fades a window in and out, so that what is not fitted (images of a
clock, harmonics, the last of a transient) leaks into the fit by orders of magnitude less than
through a plain window. These are held against the closed form.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, inf, log, pi
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from haptisym.judge.answers import Answer
from haptisym.kernel.budget import ONE_THREAD, SECONDS, limited
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.rootcount import is_stable
from haptisym.model.catalogue import DESCRIBED, ENCODER, Effect
from haptisym.model.motions import Motion, Sines, chirp, multisine, positive, recording, sine
from haptisym.model.quantities import Dimension, Number, quantity
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.values import Array
from haptisym.verbs.simulate.engine import Engine
from haptisym.verbs.simulate.network import (
    MOTION,
    Network,
    Port,
    SignalSum,
    Step,
    bank_error,
    build_controller,
    build_effect,
    build_environment,
    float_of,
    join,
    limit_force,
    name_of,
    size_of,
)
from haptisym.verbs.simulate.statespace import Reading, Record, StateSpace


@dataclass(frozen=True)
class EncoderQuantisation:
    """The display measures the hand's motion only in whole multiples of ``resolution``, m or rad
    (or with a unit)."""

    resolution: Number


@dataclass(frozen=True)
class ForceSaturation:
    """The display can render no force beyond ``limit``, N or N m (or with a unit)."""

    limit: Number


Extra = EncoderQuantisation | ForceSaturation
"""Elements that only a simulation has: no closed form contains them, as it does the effects
``encoder`` and ``saturation``."""


@dataclass(frozen=True)
class RecoveredResponse:
    """H_perc at one excited frequency, rad/s: recovered from the simulated force, and by its closed
    form. N/m or N m/rad.

    ``error`` bounds the numerical error of ``simulated`` (steps, transient, images; an estimate,
    not a proof).
    ``agrees`` is None where the closed form itself is an approximation; ``approximate`` then says
    why.
    """

    omega: float
    simulated: complex
    closed: complex
    error: float
    approximate: str = ""

    @property
    def difference(self) -> float:
        """The distance of simulation and closed form, N/m or N m/rad."""
        return abs(self.simulated - self.closed)

    @property
    def agrees(self) -> bool | None:
        """Whether the difference is within the estimated error; None where the closed form is an
        approximation."""
        return None if self.approximate else self.difference <= self.error


@dataclass(frozen=True)
class ForceError:
    """The error that encoder and force limit make in the force at the hand, N or N m, against the
    force of the same motion without them.

    ``largest``, ``rms`` : of all of it. ``quantised_largest``, ``quantised_rms`` : the part that
    the encoder makes, against the same with the limit alone; 0 without an encoder. ``at_limit`` :
    the share of the time at which the force is at its limit.
    """

    largest: float
    rms: float
    quantised_largest: float
    quantised_rms: float
    at_limit: float

    def row(self) -> dict[str, Any]:
        """Return the numbers as a document has them."""
        parts = {"largest": self.quantised_largest, "rms": self.quantised_rms}
        return {
            "largest": self.largest,
            "rms": self.rms,
            "quantisation": parts,
            "at_limit": self.at_limit,
        }


class _Runs(Answer):
    """Simulated runs of one scene: what is said of them together. Their errors are estimated."""

    __slots__ = ()
    _schema: ClassVar[str] = "haptisym.simulation/1"
    _figure: ClassVar[str] = "haptisym.figures.simulate:SIMULATION"
    _page: ClassVar[str] = "haptisym.pages.simulate:page"

    @property
    @abstractmethod
    def runs(self) -> tuple[Simulation, ...]:
        """All of them."""

    @property
    def certified(self) -> bool:
        """False: errors of a simulation are estimated."""
        return False

    @property
    def settled(self) -> bool:
        """Whether no estimate disagrees with the closed form; True where there is none to
        compare."""
        return self.agrees is not False

    @property
    def agrees(self) -> bool | None:
        """Whether all estimates agree with the closed forms; None where no exact closed form could
        be compared."""
        verdicts = [x.agrees for run in self.runs for x in run.estimates if x.agrees is not None]
        return all(verdicts) if verdicts else None

    def _body(self) -> dict[str, Any]:
        runs, first = self.runs, self.runs[0]
        return {
            "motion": {
                "kind": first.motion.name,
                "amplitude": first.motion.amplitude,
                "omega": [omega for run in runs for omega in run.motion.omegas],
                **_smoothing(first.motion),
            },
            "time": [0.0, max(float(run.time[-1]) for run in runs)],
            "samples": sum(len(run.time) for run in runs),
            "built": list(first.built),
            "force": {
                "least": min(float(r.force.min()) for r in runs),
                "most": max(float(r.force.max()) for r in runs),
            },
            **({"error": first.error.row()} if first.error else {}),
            "estimates": [_estimate_row(x) for run in runs for x in run.estimates],
            "agrees": self.agrees,
            **({"notes": list(first.notes)} if first.notes else {}),
        }


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(_Runs):
    """A run in time: force at the hand for a prescribed ``motion`` of ``scene``, from the equations
    of motion of its elements.

    ``time``, s; ``displacement``, m or rad, and ``force``, N or N m, at the hand;
    ``environment_displacement`` and
    ``environment_force``, the same at the environment: arrays of one length. ``estimates`` : for
    each excited frequency
    ``omega``, rad/s, ``simulated`` and ``closed`` H_perc (complex, N/m or N m/rad), their
    ``difference``, an estimated ``error``, and whether they agree; none for a chirp, a recording or
    a short run. ``built`` : the models that were simulated.
    ``extras`` : encoder and force limit. ``notes`` : what a reader of the force should know.
    ``error`` : of a chirp or recording with extras, the force against that of ideal hardware, N or
    N m; else None.

    Computed: floating point; errors are estimated from runs of different accuracy, not bounded.

    >>> import haptisym as hs
    >>> [x] = hs.simulate("fu2019", hs.sine("5 cm", "10 rad/s")).estimates
    >>> x.agrees, round(x.simulated.real, 3)
    (True, -60.937)
    """

    scene: Scene
    motion: Motion
    time: Array
    displacement: Array
    force: Array
    environment_displacement: Array
    environment_force: Array
    estimates: tuple[RecoveredResponse, ...]
    built: tuple[str, ...]
    extras: tuple[Extra, ...] = ()
    notes: tuple[str, ...] = ()
    error: ForceError | None = None

    def _line(self) -> str:
        return (
            f"{titled(self.scene.title)}: {self.motion.name}, "
            f"{counted(len(self.estimates), 'frequency', 'frequencies')}"
        )

    @property
    def runs(self) -> tuple[Simulation, ...]:
        """This one alone: ``Simulations`` are several."""
        return (self,)

    def to_csv(self) -> str:
        """The run in time as a table, units in its header; rows are as far apart as the steps of
        the simulation want them."""
        hand, environment = (
            (self.displacement, self.force),
            (self.environment_displacement, self.environment_force),
        )
        return in_time(self.scene, self.time, {"": hand, "environment ": environment})


class Simulations(_Runs, tuple[Simulation, ...]):
    """Runs of one scene, one for each frequency: as a page and as a document they are one
    answer."""

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {counted(len(self), 'run')}"

    @property
    def scene(self) -> Scene:
        """The scene of all runs."""
        return self[0].scene

    @property
    def runs(self) -> tuple[Simulation, ...]:
        """All of them."""
        return tuple(self)


def in_time(scene: Scene, time: Array, ports: Mapping[str, tuple[Array, Array]]) -> str:
    """Displacement and force at ports, by the beginning of their headings, over time: CSV with
    units in the header."""
    length, force = ("rad", "N m") if scene.motion is Kind.ROTATION else ("m", "N")
    heads = [
        "time [s]",
        *(
            head
            for name in ports
            for head in (f"{name}displacement [{length}]", f"{name}force [{force}]")
        ),
    ]
    columns = (time, *(column for port in ports.values() for column in port))
    rows = (",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True))
    return "\n".join([",".join(heads), *rows]) + "\n"


def _smoothing(motion: Motion) -> dict[str, Any]:
    lowpass = getattr(motion, "lowpass", None)  # of recordings alone
    if lowpass is None:
        return {}
    return {"lowpass": {"cutoff": lowpass.cutoff, "order": lowpass.order, "phase": "zero"}}


def _estimate_row(x: RecoveredResponse) -> dict[str, Any]:
    return {
        "omega": x.omega,
        "simulated": {"real": x.simulated.real, "imag": x.simulated.imag},
        "closed": {"real": x.closed.real, "imag": x.closed.imag},
        "difference": x.difference,
        "error": x.error,
        "agrees": x.agrees,
        **({"approximate": x.approximate} if x.approximate else {}),
    }


@dataclass(frozen=True, eq=False)
class Lock:
    """Phasors Y with y(t) = Im(Y exp(j omega t)), one for each frequency, and how much they still
    drift between windows."""

    values: Any
    drift: Array

    @property
    def relative_drift(self) -> float:
        """The largest drift, as a fraction of the largest phasor."""
        largest = np.abs(self.values).max()
        return float(self.drift.max() / largest) if largest else 0.0


def lock(
    record: Record,
    signal: Array,
    motion: Sines,
    window: float,
    windows: int,
    *,
    drift: bool = False,
) -> Lock:
    """The phasors of a recorded signal in the last window of its record, compared with a window a
    quarter earlier.

    ``window``: s. With ``windows`` = 1 the two are not compared. ``drift``: fit a parabola along
    instead of a constant; only a constant is orthogonal to harmonics and images. Raises SceneError
    where the record is too short.
    """
    times = record.instants
    end = float(record.times[record.count - 1] + record.lengths[record.count - 1])
    # A quarter of a window is a base period: the excited frequencies repeat, and what differs
    # between both windows is transient, or at other frequencies.
    shift = window / 4 if windows > 1 else 0.0
    if end - window - shift < motion.fade * (1 - 1e-9):
        shift = 0.0
    if end - window < motion.fade * (1 - 1e-9):
        raise SceneError(
            f"duration: {end:g} s are too short to recover H_perc: give at least "
            f"{motion.fade + window:g} s are needed"
        )
    terms = 3 if drift else 1
    values = _fitted(record, times, signal, motion, (end - window, window, terms))
    if not shift:
        return Lock(values, np.zeros(len(values)))
    earlier = _fitted(record, times, signal, motion, (end - window - shift, window, terms))
    return Lock(values, np.abs(values - earlier))


def _fitted(
    record: Record, times: Array, signal: Array, motion: Sines, window: tuple[float, float, int]
) -> Any:
    """Return the phasors fitted on a window: start and length, s, and number of trend terms."""
    start, length, terms = window
    place = (times - start) / length
    inside = (place > 0) & (place < 1)
    t, x = times[inside], place[inside]
    # The taper sin^4 and its first three derivatives vanish at both ends: leakage falls with the
    # fifth power of the distance in frequency. The Gauss weights make sums over nodes integrals.
    weight = np.sin(np.pi * x) ** 4 * record.quadrature[inside]
    angle = np.multiply.outer(t, np.array(motion.omegas))
    trend = np.power.outer(2 * x - 1, np.arange(terms))
    columns = np.concatenate([np.cos(angle), np.sin(angle), trend], axis=1)
    # the columns are nearly orthogonal under the taper: normal equations lose nothing
    weighted = (columns * weight[:, None]).T
    weights = np.linalg.solve(weighted @ columns, weighted @ signal[inside])
    count = len(motion.omegas)
    # y = Im(Y exp(j omega t)) = Re Y sin + Im Y cos.
    return weights[count : 2 * count] + 1j * weights[:count]


_MOST_STEPS = 400_000
WINDOW = 4
"""Base periods of a lock-in: the taper needs them to keep neighbouring frequencies apart."""
_ENOUGH = 1e-11  # relative: two windows that agree so well have no transient left
_ENOUGH_FRACTIONAL = 1e-8
"""As ``_ENOUGH``, where a transient fades only as a power of time."""
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
        outputs = [
            (name_of(signal), 0) for port in (self.ports[0], self.ports[-1]) for signal in port
        ]
        # between two samples of a recording it is one polynomial
        longest = (
            step / motion.span[1]
            if motion.omegas or motion.name == "chirp"
            else pi / motion.span[1]
        )
        self.engine = self._engine(outputs, longest)
        _check_poles(scene, self.engine)
        _check_clocks(self.net, motion)

    def _engine(self, outputs: Sequence[Reading], longest: float) -> Engine:
        # A user's formula may be anything, also a pure derivative of the force: then the error
        # names the model.
        try:
            return Engine(self.net, self.motion, outputs, longest)
        except SceneError as error:
            if not self.net.foreign:
                raise
            raise SceneError(
                f"{error}; of {', '.join(self.net.foreign)} only the chain matrix is known: "
                f"its equations of motion must not "
                "need the future; if they do, build it of the catalogue's effects"
            ) from None

    def advance(self, until: float) -> None:
        """Simulate until a time, s."""
        steps, self.until = (until - self.engine.t) / self.engine.longest, max(until, self.until)
        if steps > _MOST_STEPS:
            raise SceneError(
                f"duration: {until:.4g} s in steps of {self.engine.longest:.3g} s are more "
                f"than {_MOST_STEPS} steps; "
                "simulate a shorter time or higher frequencies"
            )
        grid = self.engine.longest
        # Pieces of some 500 steps, so that progress is reported in between.
        count = 1 + int(np.ceil(steps / 500)) if steps > 0 else 1
        ends = np.linspace(self.engine.t, until, count)[1:]
        # steps of odd length cost a matrix exponential each; only jumps need windows that end to
        # the point
        whole = np.ceil(ends / grid - 1e-9) * grid
        to_the_point = self.net.jumps or not isinstance(self.motion, Sines)
        for end in [*whole[:-1], *(ends[-1:] if to_the_point else whole[-1:])]:
            self.engine.advance(float(end), self._watch)

    def _watch(self, time: float) -> None:
        if self.progress is not None:
            self.progress(time, self.until)

    def locked(self, length: float | None) -> Lock:
        """Simulate until two windows agree, or for ``length`` seconds; return the phasors of the
        last window."""
        assert isinstance(self.motion, Sines)
        period = period_of(self.motion)
        self.to_windows(length or self.motion.fade + self.settling() + (WINDOW + 1) * period)
        found, before, idle = self.lock(2), inf, 0
        falling = self._falling(period)
        while (
            length is None
            and idle < _IDLE
            and self.engine.t < self.motion.fade + self.settling() + _PATIENCE * period
        ):
            worst = found.relative_drift
            if worst < (_ENOUGH_FRACTIONAL if self.net.fractional else _ENOUGH):
                break
            # images and quantisation do not fade; what a fractional derivative remembers does, but
            # ever more slowly
            idle = idle + 1 if worst > 0.9 * before and not self.net.fractional else 0
            falling, before = max(self._falling(period), worst / before), worst
            # A transient that falls as a power of time is halved only when the time is doubled.
            more = round(self.engine.t / period) if self.net.fractional else 1
            for _ in range(more):
                self.advance(self.engine.t + period)
            found = self.lock(2)
        if idle and found.relative_drift > _NEVER:
            raise SceneError(
                "the simulated force does not become periodic: the scene is not, or hardly, stable"
            )
        # What a transient that falls by this factor in each period has still to go: the sum of a
        # geometric series. Images and quantisation do not fall at all, and are bounded by 0.95.
        falling = min(falling, 0.95)
        return Lock(found.values, found.drift * max(1.0, falling / (1 - falling)))

    def to_windows(self, until: float) -> None:
        """Simulate up to a time, with steps that end where windows end: half a step would spoil
        their quadrature."""
        period, self.until = period_of(self.motion), max(until, self.until)
        for back in range(WINDOW + 1, -1, -1):
            self.advance(max(until - back * period, self.engine.t))

    def lock(self, windows: int) -> Lock:
        """Amplitudes and phases of the force, from so many of its last windows."""
        assert isinstance(self.motion, Sines)
        force = self.engine.signal(name_of(self.ports[-1].F))
        # what a fractional derivative remembers fades as a power of time: too slowly to wait for,
        # but as a parabola
        fading = bool(self.net.fractional)
        return lock(
            self.engine.record,
            force,
            self.motion,
            WINDOW * period_of(self.motion),
            windows,
            drift=fading,
        )

    def again(self, until: float) -> Lock:
        """Simulate up to a time and return the phasors of the last window: for another run with
        other steps."""
        self.to_windows(until)
        return self.lock(1)

    def settling(self) -> float:
        """Return how long the slowest pole needs to fade to 1e-12, s; 0 where none is known, as in
        loops with delays."""
        return -log(1e-12) / self._slowest if self._slowest else 0.0

    def _falling(self, period: float) -> float:
        """Return the factor by which the slowest pole fades in a period; 0 where none is known."""
        return exp(-self._slowest * period) if self._slowest else 0.0

    @cached_property
    def _slowest(self) -> float:
        """The smallest rate at which a transient fades, 1/s; 0 where none is known."""
        rates = -self.engine.system.poles().real
        return 0.0 if self.net.fractional or not len(rates) else max(0.0, float(rates.min()))


def least_duration(motion: Sines) -> float:
    """Return how long a run must last, s, for two windows after the fade-in."""
    return motion.fade + (WINDOW + 1) * period_of(motion) * (1 - 1e-9)


def period_of(motion: Motion) -> float:
    """Return the base period of a motion, s: that of its lowest frequency."""
    return 2 * pi / motion.span[0]


_RESOLUTION = "resolution of the encoder"


def build(net: Network, scene: Scene, extras: Sequence[Extra] = ()) -> list[Port]:
    """The scene's equations but for what the hand does; ports from the environment to the hand."""
    ports = [Port(net.signal("F"), net.signal("X")) for _ in range(len(scene.effects) + 1)]
    near, resolution = ports[0], 0.0
    sampled = bool(scene.effects) and scene.effects[0].renders
    # An encoder next to a sampled controller is read at its ticks alone: rounding the samples is
    # the same, and needs no event for each step in between.
    encoder = next((x for x in scene.effects[1:2] if sampled and x.model == ENCODER), None)
    if encoder:
        resolution = size_of(encoder)
    for extra in extras:
        if sampled and isinstance(extra, EncoderQuantisation):
            resolution = max(
                resolution, _sized(_RESOLUTION, extra.resolution, Dimension.DISPLACEMENT, scene)
            )
            net.built.append("encoder-quantisation")
        else:
            near = _build_extra(net, extra, near, scene)
    if sampled:
        build_controller(net, scene.effects[0], near, resolution)
    else:
        build_environment(net, scene.rendered or scene.environment, near)
    for effect, inner, outer in zip(scene.effects, ports, ports[1:], strict=False):
        if effect is encoder:
            join(net, inner, outer)
            net.built.append(effect.model)
        else:
            build_effect(net, effect, inner, outer)
    net.hold_whole_delays()
    return ports


def _build_extra(net: Network, extra: Extra, far: Port, scene: Scene) -> Port:
    """Add a quantiser or a limit between the environment and a port; return the port that is
    left for the environment."""
    if isinstance(extra, EncoderQuantisation):
        measured = net.signal("measured")
        size = _sized(_RESOLUTION, extra.resolution, Dimension.DISPLACEMENT, scene)
        net.steps.append(Step(name_of(far.X), name_of(measured), size, "encoder-quantisation"))
        net.built.append("encoder-quantisation")
        return Port(far.F, measured)
    near = Port(net.signal("wanted-force"), net.signal("unlimited"))
    limit = _sized("limit of the force", extra.limit, Dimension.FORCE, scene)
    limit_force(net, limit, "force-saturation", near, far)
    net.built.append("force-saturation")
    return near


def _sized(key: str, given: Number, dimension: Dimension, scene: Scene) -> float:
    """Return a positive quantity of an extra in SI; SceneError where its unit does not fit."""
    value = positive(key, given, dimension)
    same_kind(key, quantity(given, dimension).motion, scene)
    return value


def same_kind(key: str, kind: Kind | None, scene: Scene) -> None:
    """SceneError where a unit is of the other kind of motion than the scene."""
    if kind is not None and scene.motion is not None and kind is not scene.motion:
        raise SceneError(f"{key}: its unit is {kind.value}, the scene {scene.motion.value}")


def check_question(scene: Scene, motion: Motion, extras: Sequence[Extra]) -> None:
    """Raise SceneError for what is no motion, no extra, or has symbols or units that cannot be
    simulated."""
    if not hasattr(motion, "derivatives"):
        given = (
            f'recording("{motion}")'
            if isinstance(motion, str) and motion.lower().endswith(".csv")
            else ""
        )
        makers = given or 'sine("5 cm", "2 Hz"), multisine, chirp or recording("hand.csv")'
        raise SceneError(f"motion: {motion!r:.60} is no motion: make one with {makers}")
    check_extras(extras)
    scene.knobs.need_numbers()
    same_kind("motion", motion.kind, scene)


def check_extras(extras: Sequence[Extra]) -> None:
    """Raise SceneError for what is no list of extras."""
    if not isinstance(extras, Sequence) or not all(isinstance(x, Extra) for x in extras):
        raise SceneError(
            f"extras: {extras!r:.60}: give a list of EncoderQuantisation and ForceSaturation"
        )


def _check_poles(scene: Scene, engine: Engine) -> None:
    """Raise SceneError, naming the pole, where the scene is not stable."""
    system, held = engine.system, {hold.target for hold in engine.net.holds}
    # Where delayed or held signals drive the state, eigenvalues of the state equation are no poles
    # of the loop: the characteristic function must be asked.
    returning = [
        i
        for i, (x, _) in enumerate(system.drives)
        if (x.lag != 0 and x.name != MOTION) or x.name in held
    ]
    fed_back = any(system.propagator.N[:, i].any() for i in returning)
    poles = system.poles()
    worst = max(poles, key=lambda p: p.real, default=complex(-inf))
    if is_stable(scene.distortion().perc) is False:
        from haptisym.verbs.simulate.rightmost import rightmost_pole

        transcendental = fed_back or bool(engine.net.holds)
        pole = rightmost_pole(scene.distortion().perc) if transcendental else worst
        # A clock's factor 1 - exp(-s T) leaves a pole at 0 that is none: whether a loop grows will
        # show in the run.
        if engine.net.holds and (pole is None or pole.real < 0):
            return
        raise SceneError(
            f"the scene is unstable{_named(pole)}: there is no steady motion to simulate"
        )
    # H_perc may cancel an unstable mode that the equations of motion still have: it would overflow
    # in the run. Poles on the axis count up to rounding as stable.
    if not fed_back and worst.real > 1e-9 * max(1.0, float(np.abs(poles).max(initial=0.0))):
        raise SceneError(
            f"the scene has an unstable internal motion{_named(worst)} that H_perc does not contain"
        )


def _named(pole: complex | None) -> str:
    """Return words that name a pole; empty where none is known."""
    if pole is None or not np.isfinite(pole.real):
        return ""
    size = abs(pole.imag)
    return f" (pole at {pole.real:.4g}{f' ± {size:.4g}j' if size > 1e-9 * abs(pole) else ''} 1/s)"


def _check_clocks(net: Network, motion: Motion) -> None:
    """Raise SceneError for a sine at or above half a clock's rate: its image would be at the same
    frequency or below."""
    for hold in net.holds:
        if motion.omegas and max(motion.omegas) >= pi / hold.period * (1 - 1e-9):
            raise SceneError(
                f"{hold.name}: {max(motion.omegas):.6g} rad/s is not below its Nyquist frequency, "
                f"{pi / hold.period:.6g} rad/s"
            )


def why_approximate(run: Run) -> str:
    """Why the closed form is not what a simulation must give, or nothing."""
    engine = run.engine
    system = engine.systems[frozenset()]
    assert system is not None
    for effect, inner, outer in zip(run.scene.effects, run.ports, run.ports[1:], strict=False):
        if effect.model in DESCRIBED:
            is_force = effect.model == "saturation"
            signal = name_of(inner.F if is_force else outer.X)
            reason = _reason(system.exact, signal, effect, engine.motion, is_force=is_force)
            if reason:
                return reason
    for hold in engine.net.holds:
        if hold.resolution or _jumps_behind(system.exact, engine.net, hold.source):
            return (
                f"{hold.name} samples what jumps or comes back to it: its images count, the "
                f"closed form has the base band"
            )
    return ""


def _reason(
    system: StateSpace, signal: str, effect: Effect, motion: Motion, *, is_force: bool
) -> str:
    """Return why the describing function of what reads a signal is not what its simulation gives;
    empty where it is."""
    name = effect.name
    amplitude = next(float(p.value) for p in effect.parameters if p.key == "amplitude")
    row = system.signal(signal)
    present = next(x for x in system.inputs if x.name == MOTION and x.lag == 0)
    hand = system.inputs.index(present)
    # A motion is the hand's exactly if that has weight 1 and all else has 0; a force may be any
    # sum of the hand's motion and its derivatives.
    weights = [float_of(c[0, i]) for c in row.inputs for i in range(c.ncols())]
    own = [float_of(c[0, hand]) for c in row.inputs]
    is_alone = sum(map(abs, weights)) == sum(map(abs, own))
    prescribed = is_alone and (is_force or (own[0] == 1.0 and not any(own[1:])))
    if not prescribed or any(row.state[0, i] != 0 for i in range(system.size)):
        what = "limits what is filtered before" if is_force else "does not move as the hand does"
        return f"{name} {what}: its describing function is an approximation"
    if len(motion.omegas) > 1:
        return f"{name}: a describing function holds for one sine, not for several"
    sizes = (w * (1j * motion.span[0]) ** n for n, w in enumerate(own))
    size = motion.amplitude * abs(sum(sizes))
    if abs(size / amplitude - 1) > _SAME:
        what = "the force has" if is_force else "the hand moves by"
        return (
            f"{name}: its describing function is for an amplitude of {amplitude:g}, {what} {size:g}"
        )
    return ""


_SAME = 1e-9
"""Relative: so far floats may take an amplitude from the one that is given."""


def _jumps_behind(system: StateSpace, net: Network, source: str) -> set[str]:
    """Return the names of what clocks and switches set that acts on a signal, also through delay
    lines."""
    found: set[str] = set()
    seen, todo = {source}, [source]
    for name in todo:  # grows while it is walked
        if name in net.jumps:
            found.add(name)
            continue
        for channel in (x for x in system.inputs if system.reach(name, 0, x) is not None):
            if channel.name != MOTION and channel.name not in seen:
                seen.add(channel.name)
                todo.append(channel.name)
    return found


_NOISE = 1e-6  # m or rad
_MUCH = 10.0  # times the largest |H_perc| of the band: noise then matters before anything else does


def noise_notes(scene: Scene, motion: Motion) -> tuple[str, ...]:
    """Return a sentence for a recording where |H_perc| is far larger at its highest frequency than
    on the band; none otherwise.

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
    helps = (
        "A lower cutoff removes more."
        if lowpass
        else "--lowpass FREQUENCY (zero phase) removes what is above it."
    )
    note = (
        f"Noise of the recording is amplified: 1 {length} at {top / (2 * pi):.4g} Hz, "
        f"{where}, is {_NOISE * most:.3g} {force} "
        f"at the hand, {most / usual:.3g} times what it is on the band. {helps}"
    )
    return (note,)


STEP = 0.9
"""Radians of the highest frequency on a step; the error estimate compares with steps that are half
as long again."""
_COARSER = 1.5
_FLOOR = 2e-11  # relative: what rounding leaves of a force that is a sum of larger ones


def simulate(
    scene: Scene | str | Path,
    motion: Motion,
    *,
    duration: Number | None = None,
    extras: Sequence[Extra] = (),
    progress: Callable[[float, float], None] | None = None,
    limit: float | None = SECONDS,
) -> Simulation:
    """The force at the hand for a prescribed motion, and H_perc recovered from it at the
    frequencies of the motion.

    ``duration``: s, or with a unit (a step is not cut short); as long as transient and lock-in need
    if not given. ``extras``:
    encoder quantisation or force saturation; of a recording or a chirp ``error`` then gives what
    they make of the force, by further runs. ``progress`` is called with the simulated time and, as
    far as it is known, the time to simulate, s. ``limit`` : seconds of processor time that it may
    take, LimitError after them; None for none.
    Computed: events are hit exactly, and linear parts are integrated without a stability limit;
    the error of each estimate is estimated, not proven.
    Raises SceneError for scenes that are not stable or not causal, for symbols, for motions whose
    derivatives do not exist or whose unit does not fit, and at and beyond the Nyquist frequency of
    a clock.

    >>> from haptisym.model.scenefile import load_scene
    >>> run = simulate(load_scene("fu2019"), sine("5 cm", 10))
    >>> [estimate] = run.estimates
    >>> run.agrees, bool(abs(estimate.simulated - estimate.closed) < 1e-6 * abs(estimate.closed))
    (True, True)
    """
    with ONE_THREAD, limited(limit):
        return _simulated(as_scene(scene), motion, duration, extras, progress)


def _simulated(
    scene: Scene,
    motion: Motion,
    duration: Number | None,
    extras: Sequence[Extra],
    progress: Callable[[float, float], None] | None,
) -> Simulation:
    check_question(scene, motion, extras)
    length = motion.duration if duration is None else positive("duration", duration, Dimension.TIME)
    try:
        fine = Run(scene, motion, extras, STEP, progress)
    except SceneError as error:
        # The one model of the catalogue whose inverse, with a delay, is not causal.
        displays = [x for x in scene.effects if x.model == "admittance-display"]
        late = [x.name for x in displays if any(p.key == "tau" and p.value for p in x.parameters)]
        if not late:
            raise
        why = (
            "with tau the force would precede a prescribed motion: let go of the hand "
            "(--release), which is causal"
        )
        raise SceneError(f"effects.{late[0]}: {why}") from error
    if not isinstance(motion, Sines) or (length is not None and length < least_duration(motion)):
        fine.advance(length or 0.0)
        return replace(
            _result(fine, ()),
            error=None if isinstance(motion, Sines) or not extras else _error(fine),
        )
    # The error is estimated from a second run with longer steps. Where clocks or delays set the
    # steps of both, it would be the same run.
    found = fine.locked(length)
    coarse = Run(scene, motion, extras, STEP * _COARSER, progress)
    other = found if coarse.engine.longest == fine.engine.longest else coarse.again(fine.engine.t)
    return _result(fine, _estimates(fine, found, other))


def check(
    scene: Scene | str | Path,
    *,
    amplitude: Number | None = None,
    count: int = 10,
    progress: Callable[[float, float], None] | None = None,
    limit: float | None = SECONDS,
) -> Simulations:
    """Simulate along the band of a scene, at ``count`` frequencies: all at once, or, with friction,
    one after the other.

    ``limit`` : seconds of processor time that all may take, LimitError after them; None for none.

    >>> from haptisym.model.scenefile import load_scene
    >>> [run] = check(load_scene("zener-tissue"), count=4)
    >>> len(run.estimates), run.agrees
    (4, True)
    """
    scene = as_scene(scene)
    if count < 1:
        raise SceneError(f"count: {count} frequencies; at least 1 is needed")
    size = default_amplitude(scene) if amplitude is None else amplitude
    omegas = band_frequencies(scene, count)
    one_by_one = any(effect.model in DESCRIBED for effect in scene.effects)
    motions = [sine(size, omega) for omega in omegas] if one_by_one else [multisine(size, omegas)]
    with limited(limit):
        return Simulations(simulate(scene, x, progress=progress, limit=None) for x in motions)


def band_frequencies(scene: Scene, count: int) -> list[float]:
    """Frequencies along the band, whole multiples of one, so that they repeat together."""
    low, high = (float(end) for end in scene.band)
    base = high / (2 * count)
    # Multiples of one base frequency: a lock-in window of whole base periods suits them all.
    multiples = [n for n in range(1, 2 * count + 1) if n * base >= low]
    chosen = np.unique(
        np.round(np.linspace(multiples[0], multiples[-1], min(count, len(multiples)))).astype(int)
    )
    return [float(n * base) for n in chosen]


def default_amplitude(scene: Scene) -> float:
    """Return the amplitude for which a describing function of the scene is given, or 0.05 m (0.05
    rad) without one."""
    described = [e for e in scene.effects if e.model in DESCRIBED and e.model != "saturation"]
    given = [float(p.value) for e in described for p in e.parameters if p.key == "amplitude"]
    return given[0] if given else 0.05


# Results


def _result(run: Run, estimates: tuple[RecoveredResponse, ...]) -> Simulation:
    engine = run.engine
    time = engine.record.instants.ravel()
    columns = [
        engine.signal(name_of(s)).ravel() for s in (run.ports[-1].F, run.ports[0].X, run.ports[0].F)
    ]
    hand = run.motion.derivatives(time, 0)[0]
    return Simulation(
        run.scene,
        run.motion,
        time,
        hand,
        columns[0],
        columns[1],
        columns[2],
        estimates,
        tuple(run.net.built),
        run.extras,
        noise_notes(run.scene, run.motion),
    )


def _error(run: Run) -> ForceError:
    """Return the error of the force by further runs of the same motion: without extras, and
    without the encoder where there is a limit too."""
    limits = [x for x in run.extras if isinstance(x, ForceSaturation)]
    record, weights = run.engine.record, run.engine.record.quadrature.ravel()
    weights = weights / weights.sum()
    times, force = record.instants.ravel(), run.engine.signal(name_of(run.ports[-1].F)).ravel()

    def off(extras: Sequence[Extra]) -> tuple[float, float]:
        if len(extras) == len(run.extras):
            return 0.0, 0.0
        other = Run(run.scene, run.motion, extras, STEP, run.progress)
        other.advance(run.engine.t)
        # The runs step differently: the other one's polynomials are read at this one's nodes.
        column = other.engine.column(name_of(other.ports[-1].F))
        by = force - other.engine.record.at(times, [column])[:, 0]
        return float(np.abs(by).max()), float(np.sqrt(weights @ by**2))

    everything = off(())
    most = min((positive("limit", x.limit, Dimension.FORCE) for x in limits), default=inf)
    rendered = np.abs(run.engine.signal(name_of(run.ports[0].F)).ravel())
    share = float(weights @ (rendered >= most * (1 - 1e-9)))
    return ForceError(*everything, *(off(limits) if limits else everything), share)


def _estimates(run: Run, found: Lock, other: Lock) -> tuple[RecoveredResponse, ...]:
    """Return H_perc at each excited frequency: of a run, and against one with other steps."""
    assert isinstance(run.motion, Sines)
    omegas = np.array(run.motion.omegas)
    values = run.scene.distortion().compile()(omegas)
    closed = values.perceived_real + 1j * values.perceived_imag
    phasors = np.array([run.motion.phasor(omega) for omega in run.motion.omegas])
    simulated = found.values / phasors
    # Twice what windows and runs differ by. Small responses next to large ones are known to the
    # rounding of the largest.
    numeric = 2 * (found.drift + np.abs(found.values - other.values)) / np.abs(phasors)
    error = numeric + np.abs(simulated).max() * (_FLOOR + _fractional_error(run.net, omegas))
    why = (
        "the closed form knows no quantisation and no saturation"
        if run.extras
        else why_approximate(run)
    )
    return tuple(
        RecoveredResponse(float(w), complex(h), complex(c), float(e), why)
        for w, h, c, e in zip(omegas, simulated, closed, error, strict=True)
    )


def _fractional_error(net: Network, omegas: Array) -> float:
    """Return the largest relative error of the bank of relaxations against s^alpha; 0 without
    one."""
    if not net.fractional:
        return 0.0
    return 3 * max(bank_error(alpha, (low, high), omegas) for alpha, low, high in net.fractional)


def run(
    scene: Scene,
    along_band: bool,  # noqa: FBT001
    options: Mapping[str, str | None],
    progress: Callable[[float, float], None] | None = None,
) -> Simulations:
    """The runs of one call: one, or with ``along_band`` those of a check along the band.
    ``progress`` as in ``simulate``."""
    refused = [
        key
        for key in ("omega", "duration", "quantise", "saturate", "lowpass")
        if along_band and options.get(key)
    ]
    if along_band and (refused or options.get("kind") not in (None, "sine")):
        raise SceneError(
            f"--check chooses motion and time: leave out --{(refused or ['motion'])[0]}"
        )
    if along_band:
        return check(scene, amplitude=options.get("amplitude"), progress=progress, limit=None)
    made = motion(scene, options)
    found = simulate(
        scene,
        made,
        duration=options.get("duration"),
        extras=extras_of(options),
        progress=progress,
        limit=None,
    )
    return Simulations([found])


def motion(scene: Scene, options: Mapping[str, str | None]) -> Motion:
    """The motion that the options describe; what they leave out follows from the scene."""
    kind, top = options.get("kind") or "sine", float(scene.band[1])
    if options.get("lowpass") and not kind.lower().endswith(".csv"):
        raise SceneError("--lowpass smooths a recorded motion: give one with --motion FILE.csv")
    amplitude = options.get("amplitude") or default_amplitude(scene)
    highest = (
        positive("omega", options["omega"], Dimension.FREQUENCY) if options.get("omega") else None
    )
    if kind == "sine":
        return sine(amplitude, highest or top / 3)
    if kind == "multisine":
        shares = [omega / top for omega in band_frequencies(scene, 10)]
        return multisine(amplitude, [share * (highest or top) for share in shares])
    if kind == "chirp":
        high = highest or top
        return chirp(amplitude, high / 20, high, options.get("duration") or 200 * pi / high)
    if not kind.lower().endswith(".csv"):
        raise SceneError(
            f'--motion: unknown motion "{kind}": valid are sine, multisine, chirp and a file '
            f"that ends in .csv"
        )
    if options.get("amplitude") or options.get("omega"):
        raise SceneError("--motion: leave out --amplitude and --omega, as the recording has them")
    return recording(
        kind, lowpass=options.get("lowpass"), order=int(options.get("lowpass_order") or 4)
    )


def extras_of(options: Mapping[str, str | None]) -> tuple[Extra, ...]:
    """The encoder and the limit of the force that the options describe."""
    resolution, limit = options.get("quantise"), options.get("saturate")
    extras: list[Extra] = []
    if resolution:
        extras.append(EncoderQuantisation(resolution))
    if limit:
        extras.append(ForceSaturation(limit))
    return tuple(extras)
