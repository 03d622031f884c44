"""Figures of simulations: force and motion in time, loops, H_perc as recovered from the force
against its closed form, and a release.

A simulation is computed in floats and proves nothing; where there is a closed form, it is drawn
with what was simulated.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from matplotlib.artist import Artist

from haptisym.figures import pen
from haptisym.figures.files import Drawings, sheet
from haptisym.figures.layers import (
    DrawnAxis,
    Layer,
    Limit,
    Mark,
    On,
    Origin,
    Panel,
    Polyline,
    force_per_position,
    frequency,
    small,
)
from haptisym.kernel.errors import NothingToDrawError
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, MotionKind, Unit, quantity
from haptisym.programs.values import Array
from haptisym.verbs.simulate.entry import ForceSaturation, Simulation, Simulations
from haptisym.verbs.simulate.release import Release
from haptisym.verbs.simulate.statespace import POINTS, finer

_IN_TIME, _IN_LOOPS = 3, 1
"""Periods that are shown in time, and as a loop."""
_PERIODS, _FOLDS = 12, 5.0
"""Periods of a release that are shown, at most; and by how many powers of e it decays or grows."""

Runs = Simulations | Simulation


def _middle(found: Runs) -> Simulation:
    """Return the run itself, or the middle one of several."""
    return found.runs[len(found.runs) // 2]


def in_time(runs: Runs) -> Panel:
    """Force at the hand over the last periods of a run, the motion of the hand (axis at the right),
    limits of the force.

    Of a further run on the same axes the force alone is drawn.

    >>> from haptisym import load_scene, simulate, sine
    >>> chart = in_time(simulate(load_scene("fu2019"), sine("5 cm", "10 rad/s")))
    >>> [layer.label for layer in chart.layers if layer.label], chart.y.text
    (['force', 'motion'], 'force (N)')
    """
    run = _middle(runs)
    part = _last(run, _IN_TIME)
    time, motion, force = (_smooth(x[part]) for x in (run.time, run.displacement, run.force))
    most, reach = (float(np.abs(x).max()) or 1.0 for x in (force, motion))
    length = _length(reach, "rad" if run.scene.motion is MotionKind.ROTATION else "m")
    limits = _saturated(run)
    layers = [
        Polyline(time, force, width=1.0, label="force", look={"zorder": 3}),
        Origin(level=True),
        _Motion(time, motion, most / reach, length, label="motion"),
        *limits,
    ]
    # A limit of the force far above all that is reached would leave the force no height.
    high = 1.08 * max([most, *(abs(x.at) for x in limits if abs(x.at) < 3 * most)])
    upright = DrawnAxis("force", _newton(run), (-high, high))
    return Panel(layers, DrawnAxis("time", Unit("s"), (time[0], time[-1])), upright, height=2.0)


def _saturated(run: Simulation) -> list[Limit]:
    """Return a line at each limit of the force, on both sides of 0."""
    return [
        Limit(
            sign * float(quantity(extra.limit, Dimension.FORCE).value),
            stroke=pen.DOTTED,
            width=0.9,
            color=pen.RED,
            label="limit of the force",
            shared=True,
        )
        for extra in run.extras
        if isinstance(extra, ForceSaturation)
        for sign in (1, -1)
    ]


@dataclass(frozen=True)
class _Motion(Layer):
    """A motion drawn as high as the force, with an axis at the right; ``share`` : force for each of
    its own, SI."""

    x: Array
    y: Array
    share: float
    unit: Unit
    styled: bool = field(default=True, kw_only=True)

    def draw(self, on: On) -> list[Artist]:
        if on.number:
            return []
        share = self.share * float(self.unit.size)
        # The axis at the right undoes the scale with which the motion is drawn on the force's.
        there: Any = (lambda y: y / share, lambda y: y * share)
        right: Any = on.ax.secondary_yaxis("right", functions=there)
        right.set_ylabel(f"motion ({self.unit.text})", fontsize=pen.TEXT, color=pen.BLUE)
        right.tick_params(
            labelsize=small(on.ax), width=0.5, length=2.5, color=pen.GREY, labelcolor=pen.BLUE
        )
        right.spines["right"].set(linewidth=0.5, color=pen.GREY)
        return list(
            on.ax.plot(
                self.x,
                self.y * self.share,
                color=on.ink(pen.BLUE),
                linestyle=pen.DASHED,
                linewidth=1.0,
            )
        )


def loop(runs: Runs) -> Panel:
    """Force over displacement: at the hand, and what the environment alone would give.

    The environment's loop is that of H_env under the same motion of the hand, where the motion is a
    sum of sines; otherwise it is what the environment itself went through behind the effects.
    """
    run = _middle(runs)
    part = _last(run, _IN_LOOPS)
    x, force, name = _environment_loop(run, part)
    length = _length(
        run.motion.amplitude, "rad" if run.scene.motion is MotionKind.ROTATION else "m"
    )
    layers = [
        Origin(),
        Polyline(_smooth(x), _smooth(force), pen.BLUE, label=name),
        Polyline(
            _smooth(run.displacement[part]),
            _smooth(run.force[part]),
            pen.RED,
            pen.DASHED,
            label="at the hand",
        ),
        *_saturated(run),
    ]
    return Panel(
        layers, DrawnAxis("displacement", length), DrawnAxis("force", _newton(run)), height=2.4
    )


def recovered(runs: Runs, part: Part) -> Panel:
    """Re or Im of H_perc over frequency: the closed form as a line, what was recovered from the
    force as rings.

    NothingToDrawError where no ratio was recovered.
    """
    scene = runs.runs[0].scene
    rows = sorted((x for run in runs.runs for x in run.estimates), key=lambda x: x.omega)
    if not rows:
        raise NothingToDrawError("no ratio is recovered from this motion or from so short a run")
    omegas = np.array([x.omega for x in rows])
    grid = _around(omegas)
    # The closed form is known between the frequencies that were simulated, too.
    values = scene.distortion().compile()(grid)
    curve = values.perceived_real if part is Part.REAL else values.perceived_imag
    estimates = np.array(
        [x.simulated.real if part is Part.REAL else x.simulated.imag for x in rows]
    )
    look = {"markeredgewidth": 0.9}
    layers = [
        Origin(level=True),
        Polyline(grid, curve, pen.RED, pen.DASHED, label="closed form"),
        Mark(
            omegas,
            estimates,
            size=3.8,
            face="white",
            look=look,
            label="from the simulated force",
            styled=True,
        ),
    ]
    name = rf"\mathrm{{{'Re' if part is Part.REAL else 'Im'}}}"
    upright = force_per_position(rf"{name}\,H_\mathrm{{perc}}", scene, _limits(curve, estimates))
    return Panel(
        layers, frequency(scene.frequency, (float(grid[0]), float(grid[-1]))), upright, height=2.0
    )


def _around(omegas: Array) -> Array:
    """Return frequencies close together, from a little below the first of some to a little above
    the last."""
    low, high = omegas[0], omegas[-1]
    margin = 0.04 * (high - low) or 0.1 * high
    return np.linspace(max(low - margin, low / 2), high + margin, 601)


def _last(run: Simulation, periods: int) -> slice:
    """Return the samples of the last periods: of one sine its own periods, of several sines one of
    the lowest, of a chirp the fastest ones."""
    # A motion of no known frequency is shown whole.
    if not run.motion.omegas and run.motion.name != "chirp":
        return slice(0, None)
    low, high = run.motion.span
    span = periods / low if run.motion.omegas else 3 * periods / high
    # Several sines are shown for one period of the lowest.
    length = span if len(run.motion.omegas) < 2 else 1 / low
    start = run.time[-1] - 2 * np.pi * length
    # Samples come in steps of POINTS nodes: a step is shown whole or not.
    first = int(np.searchsorted(run.time, start)) // POINTS * POINTS
    return slice(first, None)


def _smooth(samples: Array) -> Array:
    """Return the curve through samples at the nodes of steps, with both ends of each step, so that
    jumps are upright."""
    return finer(samples, np.linspace(0, 1, 25))


def _environment_loop(run: Simulation, part: slice) -> tuple[Array, Array, str]:
    """Return displacement, force and name of the environment's own loop: of H_env alone under a sum
    of sines, else of what the environment itself went through."""
    if not run.motion.omegas:
        return run.environment_displacement[part], run.environment_force[part], "environment"
    values = run.scene.distortion().compile()(np.array(run.motion.omegas))
    phasors = np.array([run.motion.phasor(omega) for omega in run.motion.omegas])  # type: ignore[union-attr]
    forces = (values.environment_real + 1j * values.environment_imag) * phasors
    # Motions are sines, Im(X exp(j omega t)): so the force is the imaginary part of H_env X exp(j
    # omega t), summed over the frequencies.
    rotations = np.exp(1j * np.multiply.outer(run.time[part], np.array(run.motion.omegas)))
    return run.displacement[part], np.asarray((rotations @ forces).imag), "environment alone"


def _limits(curve: Array, found: Array) -> tuple[float, float]:
    """Limits that hold what was recovered and, unless it runs away to a pole, the curve."""
    low, high = float(found.min()), float(found.max())
    room = max(high - low, 0.1 * max(abs(low), abs(high)), 1e-12)
    # Beyond one extent of the recovered values the curve is on its way to a pole, and may leave the
    # axes.
    is_near = np.isfinite(curve) & (curve > low - room) & (curve < high + room)
    near = curve[is_near]
    low, high = min(low, *near, low), max(high, *near, high)
    return low - 0.08 * room, high + 0.08 * room


def _newton(run: Simulation) -> Unit:
    """Return the unit of forces, N, or of torques, N m."""
    return Unit("N*m") if run.scene.motion is MotionKind.ROTATION else Unit("N")


def _length(largest: float, unit: str) -> Unit:
    """The unit in which lengths are drawn: mm for small ones."""
    return (
        quantity("1 mm", Dimension.DISPLACEMENT).unit or Unit(unit)
        if unit == "m" and largest < 0.2
        else Unit(unit)
    )


SIMULATION = Drawings[Runs](
    {
        "time": in_time,
        "loop": loop,
        "recovered-real": partial(recovered, part=Part.REAL),
        "recovered-imag": partial(recovered, part=Part.IMAG),
    },
    {
        "simulated-time": lambda x, style: sheet(in_time(x), style=style),
        "simulated-loop": lambda x, style: sheet(loop(x), style=style),
        "recovered-real": lambda x, style: sheet(recovered(x, Part.REAL), style=style),
        "recovered-imag": lambda x, style: sheet(recovered(x, Part.IMAG), style=style),
    },
)
"""Time and loops are those of the middle run; H_perc is drawn where at least one ratio was
recovered."""


def release(r: Release) -> Panel:
    """The motion over time, with the envelope of the closed form's rightmost pole where that is
    what was simulated.

    Of a further run on the same axes the motion alone is drawn.

    >>> from haptisym import Hand, release as let_go
    >>> found = let_go("delayed-spring", "1 cm", Hand("own", m="0.5 kg", b="3.6 N*s/m"))
    >>> list(dict.fromkeys(layer.label for layer in release(found).layers if layer.label))
    ['motion', 'envelope of the closed form']
    """
    end = _shown(r)
    # Twelve places of each step, both ends among them: a step is a series, known between its nodes.
    places = np.linspace(0, 1, 12)
    time, x = finer(r.time, places), finer(r.hand_motion, places)
    inside = time <= end
    time, x = time[inside], x[inside]
    motion = Polyline(time, x, width=1.0, label="motion", look={"zorder": 3})
    most = 1.08 * float(np.abs(x).max())
    layers = [motion, Origin(level=True), *_envelope(r, time, x)]
    upright = DrawnAxis("motion", _length(r.displacement, r.unit), (-most, most))
    return Panel(layers, DrawnAxis("time", Unit("s"), (0, end)), upright, height=2.0)


def _shown(r: Release) -> float:
    """Return the time up to which a release is drawn: some periods, or some powers of e."""
    end = float(r.time[-1])
    if r.fitted is None:
        return end
    periods = _PERIODS * 2 * np.pi / max(r.fitted.omega, 1e-9)
    return float(min(end, periods, _FOLDS / max(abs(r.fitted.rate), 1e-9)))


def _envelope(r: Release, time: Array, x: Array) -> list[Layer]:
    """Return A exp(rate t) and its opposite, as high as the motion is after the first third of what
    is drawn."""
    if r.closed is None or r.approximate or r.is_envelope:
        return []
    # The envelope is fitted after the first third: before that, poles that decay faster still add
    # to the motion.
    late, shape = time > time[-1] / 3, np.exp(r.closed.rate * time)
    height = float(np.max(np.abs(x[late]) / shape[late]))
    signs = (1, -1) if r.closed.omega else (1,)
    label = "envelope of the closed form"
    return [
        Polyline(time, sign * height * shape, pen.RED, pen.DASHED, 0.9, label=label, shared=True)
        for sign in signs
    ]


RELEASE = Drawings[Release](
    {"motion": release}, {"release": lambda r, style: sheet(release(r), style=style)}
)
