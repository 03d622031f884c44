"""Figures of a simulation and of a release.

Figures of a simulation: force and motion in time, force-displacement loops, recovered against closed-form H_perc.

Each ``draw_`` function draws on the axes that it is given; ``save_simulation_figures`` writes them all to files.

The figure of a release: the motion after the hand lets go, and the envelope that the closed form gives it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.sheet import Drawings, one_column, save_all
from haptisym.figures.style import Look, dots, draw_origin, dress, legend, limit, scale_of, shown_length
from haptisym.kernel.errors import NothingToDrawError
from haptisym.model.jnd import Part
from haptisym.model.quantities import MotionKind as Kind
from haptisym.programs.values import Array
from haptisym.verbs.simulate.entry import Simulation
from haptisym.verbs.simulate.release import Release
from haptisym.verbs.simulate.statespace import POINTS, finer

_IN_TIME, _IN_LOOPS = 3, 1
"""Periods that are shown."""


def draw_time(ax: Axes, run: Simulation, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """Force at the hand over the last periods of a run, and the motion of the hand with an axis of its own at the right.

    ``color``, ``label`` : of the run; of a further one on the same axes the force alone is drawn. Returns the lines.

    >>> from matplotlib.figure import Figure
    >>> from haptisym import load_scene, simulate, sine
    >>> run = simulate(load_scene("fu2019"), sine("5 cm", "10 rad/s"))
    >>> ax = Figure().add_subplot()
    >>> [line.get_label() for line in draw_time(ax, run)], ax.get_ylabel()
    (['force', 'motion'], 'force (N)')
    """
    look = Look.on(ax, "force", color, label)
    part = _last(run, _IN_TIME)
    time, motion, force = (_smooth(x[part]) for x in (run.time, run.displacement, run.force))
    length, newton = _units(run)
    most, reach = (float(np.abs(x).max()) or 1.0 for x in (force, motion))
    lines = ax.plot(time, force, color=look.color, linewidth=1.0, label=f"force{look.suffix}", zorder=3)
    if not look.number:
        ax.axhline(0, color=pen.GREY, linewidth=0.4, zorder=0)
        factor, shown = shown_length(reach, length)
        share = most / (reach * factor)  # the motion is drawn as high as the force
        lines += ax.plot(
            time,
            motion * factor * share,
            color=pen.BLUE,
            linestyle=pen.DASHED,
            linewidth=1.0,
            label=f"motion{look.suffix}",
        )
        _right_axis(ax, share, f"motion ({shown})")
    limit(ax, (time[0], time[-1]), (-1.08 * most, 1.08 * most), number=look.number)
    dress(ax, "time (s)", f"force ({newton})")
    legend(ax, lines)
    return lines


def _right_axis(ax: Axes, share: float, label: str) -> None:
    """An axis at the right, for what is drawn that many times as high."""
    there: Any = (lambda y: y / share, lambda y: y * share)
    right: Any = ax.secondary_yaxis("right", functions=there)
    right.set_ylabel(label, fontsize=pen.TEXT, color=pen.BLUE)
    right.tick_params(labelsize=pen.SMALL, width=0.5, length=2.5, color=pen.GREY, labelcolor=pen.BLUE)
    right.spines["right"].set(linewidth=0.5, color=pen.GREY)


def draw_loop(ax: Axes, run: Simulation, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """Force over displacement: at the hand what the display gives, beside what the environment alone would give.

    The environment's loop is that of H_env under the same motion of the hand, as far as the motion is a sum of sines; otherwise
    it is what the environment itself went through behind the effects.
    ``color``, ``label`` : of the run. Returns the lines: environment, hand.
    """
    part = _last(run, _IN_LOOPS)
    length, newton = _units(run)
    factor, shown = shown_length(run.motion.amplitude, length)
    look = Look.on(ax, "at the hand", color, label)
    if not look.number:
        draw_origin(ax)
    x, force, name = _environment_loop(run, part)
    blue, red = (pen.BLUE, pen.RED) if look.plain else (look.color, look.color)
    lines = ax.plot(_smooth(x) * factor, _smooth(force), color=blue, linewidth=1.1, label=f"{name}{look.suffix}")
    lines += ax.plot(
        _smooth(run.displacement[part]) * factor, _smooth(run.force[part]), color=red, linestyle=pen.DASHED, linewidth=1.1,
        label=f"at the hand{look.suffix}",
    )  # fmt: skip
    dress(ax, f"displacement ({shown})", f"force ({newton})")
    legend(ax, lines)
    return lines


_RING = dots(3.8, markerfacecolor="white", markeredgewidth=0.9, zorder=4)


def draw_recovered(
    ax: Axes,
    runs: Sequence[Simulation],
    part: Part,
    *,
    color: str | None = None,
    label: str = "",
    hertz: bool | None = None,
) -> list[Line2D]:
    """Re or Im of H_perc over frequency: the closed form as a line, what was recovered from the force as rings.

    ``color``, ``label``, ``hertz`` : as of ``haptisym.figures.ratios.draw_ratios``. Returns the line and the rings.
    NothingToDrawError where no ratio was recovered.
    """
    scene = runs[0].scene
    look, scale = Look.on(ax, "closed form", color, label), scale_of(ax, scene.band, hertz=hertz)
    rows = sorted((x for run in runs for x in run.estimates), key=lambda x: x.omega)
    if not rows:
        raise NothingToDrawError("no ratio is recovered from this motion or from so short a run")
    omegas = np.array([x.omega for x in rows])
    grid = _around(omegas)
    values = scene.distortion().compile()(grid)
    curve = values.perceived_real if part is Part.REAL else values.perceived_imag
    found = [x.simulated.real if part is Part.REAL else x.simulated.imag for x in rows]
    if not look.number:
        ax.axhline(0, color=pen.GREY, linewidth=0.4, zorder=0)
    line, ring = (pen.RED, pen.INK) if look.plain else (look.color, look.color)
    named = {name: f"{name}{look.suffix}" for name in ("closed form", "from the simulated force")}
    lines = ax.plot(scale.of(grid), curve, color=line, linestyle=pen.DASHED, linewidth=1.1, label=named["closed form"])
    lines += ax.plot(scale.of(omegas), found, color=ring, label=named["from the simulated force"], **_RING)
    limit(ax, (scale.of(grid[0]), scale.of(grid[-1])), _limits(curve, np.array(found)), number=look.number)
    dress(ax, scale.label)
    unit = "N·m/rad" if scene.motion is Kind.ROTATION else "N/m"
    name = rf"\mathrm{{{'Re' if part is Part.REAL else 'Im'}}}"
    ax.set_ylabel(rf"${name}\,H_\mathrm{{perc}}$ ({unit})", fontsize=pen.TEXT)
    legend(ax, lines)
    return lines


def _around(omegas: Array) -> Array:
    """Frequencies close together, from a little below the first of some to a little above the last."""
    low, high = omegas[0], omegas[-1]
    margin = 0.04 * (high - low) or 0.1 * high
    return np.linspace(max(low - margin, low / 2), high + margin, 601)


def _last(run: Simulation, periods: int) -> slice:
    """The samples of the last periods: of a sine its own, of several sines one common one, of a chirp the fastest ones."""
    if not run.motion.omegas and run.motion.name != "chirp":
        return slice(0, None)
    low, high = run.motion.span
    span = periods / low if run.motion.omegas else 3 * periods / high
    start = run.time[-1] - 2 * np.pi * (span if len(run.motion.omegas) < 2 else 1 / low)
    return slice(int(np.searchsorted(run.time, start)) // POINTS * POINTS, None)


def _smooth(samples: Array) -> Array:
    """The curve through samples at the nodes of steps, with both ends of each step, so that jumps are upright."""
    return finer(samples, np.linspace(0, 1, 25))


def _environment_loop(run: Simulation, part: slice) -> tuple[Array, Array, str]:
    if not run.motion.omegas:
        return run.environment_displacement[part], run.environment_force[part], "environment"
    values = run.scene.distortion().compile()(np.array(run.motion.omegas))
    phasors = np.array([run.motion.phasor(omega) for omega in run.motion.omegas])  # type: ignore[union-attr]
    forces = (values.environment_real + 1j * values.environment_imag) * phasors
    turning = np.exp(1j * np.multiply.outer(run.time[part], np.array(run.motion.omegas)))
    return run.displacement[part], np.asarray((turning @ forces).imag), "environment alone"


def _limits(curve: Array, found: Array) -> tuple[float, float]:
    """Limits that hold what was recovered and, unless it runs away to a pole, the curve."""
    low, high = float(found.min()), float(found.max())
    room = max(high - low, 0.1 * max(abs(low), abs(high)), 1e-12)
    inside = curve[np.isfinite(curve) & (curve > low - room) & (curve < high + room)]
    low, high = min(low, *inside, low), max(high, *inside, high)
    return low - 0.08 * room, high + 0.08 * room


def _units(run: Simulation) -> tuple[str, str]:
    return ("rad", "N·m") if run.scene.motion is Kind.ROTATION else ("m", "N")


_DRAWINGS = Drawings[Sequence[Simulation]](
    {
        "simulated-time": (2.0, lambda ax, runs: draw_time(ax, runs[len(runs) // 2])),
        "simulated-loop": (2.4, lambda ax, runs: draw_loop(ax, runs[len(runs) // 2])),
        "recovered-real": (2.0, lambda ax, runs: draw_recovered(ax, runs, Part.REAL)),
        "recovered-imag": (2.0, lambda ax, runs: draw_recovered(ax, runs, Part.IMAG)),
    },
    lambda runs: () if any(run.estimates for run in runs) else ("recovered-real", "recovered-imag"),
)
simulation_figure, save_simulation_figures = _DRAWINGS.figure, _DRAWINGS.save
"""Time and loops are those of the middle run; H_perc is drawn where at least one ratio was recovered."""


_PERIODS = 12
_FOLDS = 5.0  # powers of e that are shown


def release_figure(r: Release) -> Figure:
    """One column, with its legend."""
    return one_column(2.0, lambda ax: draw_release(ax, r))


def save_release_figures(r: Release, directory: str | Path) -> list[Path]:
    """The figure as files."""
    return save_all({"release": release_figure(r)}, directory)


def draw_release(ax: Axes, r: Release, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """The motion over time, with the envelope of the closed form's rightmost root where that is what was simulated.

    ``color``, ``label`` : of the run; of a further one on the same axes the motion alone is drawn. Returns the lines.

    >>> from haptisym import Hand, release
    >>> found = release("delayed-spring", "1 cm", Hand("own", m="0.5 kg", b="3.6 N*s/m"))
    >>> [line.get_label() for line in draw_release(Figure().add_subplot(), found)]
    ['motion', 'envelope of the closed form']
    """
    look = Look.on(ax, "motion", color, label)
    end = _shown(r)
    places = np.linspace(0, 1, 12)
    time, x = finer(r.time, places), finer(r.hand_motion, places)
    inside = time <= end
    factor, unit = shown_length(r.displacement, r.unit)
    motion = ax.plot(
        time[inside], x[inside] * factor, color=look.color, linewidth=1.0, label=f"motion{look.suffix}", zorder=3
    )
    lines = motion
    if not look.number:
        ax.axhline(0, color=pen.GREY, linewidth=0.4, zorder=0)
        lines = [*motion, *_envelope(ax, r, time[inside], x[inside], factor)]
    most = 1.08 * factor * float(np.abs(x[inside]).max())
    limit(ax, (0, end), (-most, most), number=look.number)
    dress(ax, "time (s)", f"motion ({unit})")
    legend(ax, lines)
    return lines


def _shown(r: Release) -> float:
    """How much of the run is drawn: some periods, or some powers of e."""
    end = float(r.time[-1])
    if r.fitted is None:
        return end
    periods = _PERIODS * 2 * np.pi / max(r.fitted.omega, 1e-9)
    return float(min(end, periods, _FOLDS / max(abs(r.fitted.rate), 1e-9)))


def _envelope(ax: Axes, r: Release, time: Array, x: Array, factor: float) -> list[Line2D]:
    """A exp(rate t) and its opposite, as high as the motion is in the middle of what is drawn."""
    if r.closed is None or r.approximate or r.is_envelope:
        return []
    late = time > time[-1] / 3
    shape = np.exp(r.closed.rate * time)
    height = float(np.max(np.abs(x[late]) / shape[late])) * factor
    style: dict[str, Any] = {"color": pen.RED, "linestyle": pen.DASHED, "linewidth": 0.9}
    upper = ax.plot(time, height * shape, label="envelope of the closed form", **style)
    if r.closed.omega:
        ax.plot(time, -height * shape, **style)
    return upper
