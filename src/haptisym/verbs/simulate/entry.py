"""Simulation in time as an independent witness: the question, and what the command line asks.

Simulation in time as an independent witness: the force at the hand, and from it back to H_perc.

Design. The hand's motion is prescribed. Each element of the scene adds its equations of motion (``blocks``) to a
network; the algebraic part of these is solved exactly (``descriptor``), which leaves a state equation whose inputs are
the motion and its derivatives, delay lines, and what clocks, friction and quantisers set. Between events it is solved by
SciPy's matrix exponential (``propagate``), events are hit exactly (``engine``). The closed form of H_perc is used nowhere.
Once the transient is over, least squares with sines and cosines of the excited frequencies (a lock-in) recover Re and Im of
H_perc, and these are held against the closed form.

What ``haptisym simulate`` asks for, as simulations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi
from pathlib import Path

import numpy as np

from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.errors import SceneError
from haptisym.model.quantities import Dimension, Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.values import Array
from haptisym.verbs.simulate.motions import Motion, Sines, chirp, multisine, positive, recording, sine
from haptisym.verbs.simulate.network import Network, name_of
from haptisym.verbs.simulate.results import (
    EncoderQuantisation,
    Estimate,
    Extra,
    ForceSaturation,
    Simulation,
    Simulations,
)
from haptisym.verbs.simulate.run import Lock, Run, check_question, least_duration, noise_notes, why_approximate
from haptisym.verbs.simulate.threads import one_thread

STEP = 0.9
"""Radians of the highest frequency on a step; the error estimate compares with steps that are half as long again."""
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
    """The force at the hand for a prescribed motion, and H_perc recovered from it at the frequencies of the motion.

    ``duration``: s, or with a unit (a step is not cut short); as long as transient and lock-in need if not given. ``extras``:
    encoder quantisation or force saturation. ``progress`` is called with the simulated time and, as far as it is known, the
    time to simulate, s. ``limit`` : seconds that it may take, LimitError after them; None for none.
    Guaranteed: events are hit exactly, and linear parts are integrated without a stability limit; the error of each estimate is
    estimated, not proven.
    Raises SceneError for scenes that are not stable or not causal, for symbols, for motions whose derivatives do not exist or
    whose unit does not fit, and at and beyond the Nyquist frequency of a clock.

    >>> from haptisym.model.scenefile import load_scene
    >>> run = simulate(load_scene("fu2019"), sine("5 cm", 10))
    >>> [estimate] = run.estimates
    >>> run.agrees, bool(abs(estimate.simulated - estimate.closed) < 1e-6 * abs(estimate.closed))
    (True, True)
    """
    with one_thread(), limited(limit):
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
    fine = Run(scene, motion, extras, STEP, progress)
    if not isinstance(motion, Sines) or (length is not None and length < least_duration(motion)):
        fine.advance(length or 0.0)
        return _result(fine, ())
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
    """Simulate along the band of a scene, at ``count`` frequencies: all at once, or, with friction, one after the other.

    ``limit`` : seconds that all may take, LimitError after them; None for none.

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
    one_by_one = any(effect.model == "coulomb-friction" for effect in scene.effects)
    motions = [sine(size, omega) for omega in omegas] if one_by_one else [multisine(size, omegas)]
    with limited(limit):
        return Simulations(simulate(scene, x, progress=progress, limit=None) for x in motions)


def band_frequencies(scene: Scene, count: int) -> list[float]:
    """Frequencies along the band, whole multiples of one, so that they repeat together."""
    low, high = (float(end) for end in scene.band)
    base = high / (2 * count)
    multiples = [n for n in range(1, 2 * count + 1) if n * base >= low]
    chosen = np.unique(np.round(np.linspace(multiples[0], multiples[-1], min(count, len(multiples)))).astype(int))
    return [float(n * base) for n in chosen]


def default_amplitude(scene: Scene) -> float:
    """That of the scene's friction, or 5 cm (0.05 rad)."""
    given = [
        float(p.value)
        for e in scene.effects
        if e.model == "coulomb-friction"
        for p in e.parameters
        if p.key == "amplitude"
    ]
    return given[0] if given else 0.05


# Results


def _result(run: Run, estimates: tuple[Estimate, ...]) -> Simulation:
    engine = run.engine
    time = engine.record.instants.ravel()
    columns = [engine.signal(name_of(s)).ravel() for s in (run.ports[-1].F, run.ports[0].X, run.ports[0].F)]
    hand = run.motion.derivatives(time, 0)[0]
    return Simulation(
        run.scene, run.motion, time, hand, columns[0], columns[1], columns[2], estimates, tuple(run.net.built), run.extras,
        noise_notes(run.scene, run.motion),
    )  # fmt: skip


def _estimates(run: Run, found: Lock, other: Lock) -> tuple[Estimate, ...]:
    assert isinstance(run.motion, Sines)
    omegas = np.array(run.motion.omegas)
    values = run.scene.distortion().compile()(omegas)
    closed = values.perceived_real + 1j * values.perceived_imag
    phasors = np.array([run.motion.phasor(omega) for omega in run.motion.omegas])
    simulated = found.values / phasors
    numeric = 2 * (found.drift + np.abs(found.values - other.values)) / np.abs(phasors)
    error = numeric + np.abs(simulated).max() * (_FLOOR + _fractional_error(run.net, omegas))
    why = (
        "the closed form knows no quantisation and no saturation"
        if run.extras
        else why_approximate(run.engine, run.scene)
    )
    return tuple(
        Estimate(float(w), complex(h), complex(c), float(e), why)
        for w, h, c, e in zip(omegas, simulated, closed, error, strict=True)
    )


def _fractional_error(net: Network, omegas: Array) -> float:
    """How far the bank of relaxations is from s^alpha, relatively, at its worst."""
    if not net.fractional:
        return 0.0
    from haptisym.verbs.simulate.network import bank_error

    return 3 * max(bank_error(alpha, (low, high), omegas) for alpha, low, high in net.fractional)


def run(
    scene: Scene,
    along_band: bool,  # noqa: FBT001
    options: Mapping[str, str | None],
    progress: Callable[[float, float], None] | None = None,
) -> Simulations:
    """The runs of one call: one, or with ``along_band`` those of a check along the band. ``progress`` as in ``simulate``."""
    refused = [
        key for key in ("omega", "duration", "quantise", "saturate", "lowpass") if along_band and options.get(key)
    ]
    if along_band and (refused or options.get("kind") not in (None, "sine")):
        raise SceneError(f"--check chooses motion and time itself: leave out --{(refused or ['motion'])[0]}")
    if along_band:
        return check(scene, amplitude=options.get("amplitude"), progress=progress, limit=None)
    made = motion(scene, options)
    found = simulate(
        scene, made, duration=options.get("duration"), extras=_extras(options), progress=progress, limit=None
    )
    return Simulations([found])


def motion(scene: Scene, options: Mapping[str, str | None]) -> Motion:
    """The motion that the options describe; what they leave out follows from the scene."""
    kind, top = options.get("kind") or "sine", float(scene.band[1])
    if options.get("lowpass") and not kind.lower().endswith(".csv"):
        raise SceneError("--lowpass smooths a recorded motion: give one with --motion FILE.csv")
    amplitude = options.get("amplitude") or default_amplitude(scene)
    highest = positive("omega", options["omega"], Dimension.FREQUENCY) if options.get("omega") else None
    if kind == "sine":
        return sine(amplitude, highest or top / 3)
    if kind == "multisine":
        shares = [omega / top for omega in band_frequencies(scene, 10)]
        return multisine(amplitude, [share * (highest or top) for share in shares])
    if kind == "chirp":
        high = highest or top
        return chirp(amplitude, high / 20, high, options.get("duration") or 200 * pi / high)
    if not kind.lower().endswith(".csv"):
        raise SceneError(f'--motion: "{kind}" is none of sine, multisine, chirp, nor a file that ends in .csv')
    if options.get("amplitude") or options.get("omega"):
        raise SceneError(
            "--motion: a recording has its own amplitude and frequencies; leave out --amplitude and --omega"
        )
    return recording(kind, lowpass=options.get("lowpass"), order=int(options.get("lowpass_order") or 4))


def _extras(options: Mapping[str, str | None]) -> tuple[Extra, ...]:
    resolution, limit = options.get("quantise"), options.get("saturate")
    extras: list[Extra] = []
    if resolution:
        extras.append(EncoderQuantisation(resolution))
    if limit:
        extras.append(ForceSaturation(limit))
    return tuple(extras)
