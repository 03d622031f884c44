"""Figures of a simulation: force and motion in time, force-displacement loops, recovered against closed-form H_perc.

Each ``draw_`` function draws on the axes that it is given; ``save_simulation_figures`` writes them all to files.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from haptisym.figures.style import BLUE, GREY, INK, RED, TEXT, dress, handle, legend, one_column, save
from haptisym.jnd import Part
from haptisym.numeric.values import Array
from haptisym.quantities import Motion as Kind

from .propagate import POINTS, finer
from .results import Simulated

_SOLID, _DASHED = "-", (0, (4, 1.6))
_IN_TIME, _IN_LOOPS = 3, 1
"""Periods that are shown."""


def draw_time(ax: Axes, run: Simulated) -> None:
    """Force at the hand and motion of the hand, each as a fraction of its largest value, over the last periods of a run."""
    part = _last(run, _IN_TIME)
    time, motion, force = (_smooth(x[part]) for x in (run.time, run.displacement, run.force))
    sizes = [float(np.abs(x).max()) or 1.0 for x in (force, motion)]
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.plot(time, motion / sizes[1], color=BLUE, linestyle=_DASHED, linewidth=1.0)
    ax.plot(time, force / sizes[0], color=INK, linewidth=1.0)
    ax.set(xlim=(time[0], time[-1]), ylim=(-1.08, 1.08))
    dress(ax)
    ax.set_xlabel("time (s)", fontsize=TEXT)
    ax.set_ylabel("fraction of largest", fontsize=TEXT)
    length, newton = _units(run)
    handles = [
        handle(INK, _SOLID, f"force, 1 is {sizes[0]:.3g} {newton}"),
        handle(BLUE, _DASHED, f"motion, 1 is {_short_length(sizes[1], length)}"),
    ]
    legend(ax, handles)


def draw_loop(ax: Axes, run: Simulated) -> None:
    """Force over displacement: at the hand what the display gives, beside what the environment alone would give.

    The environment's loop is that of H_env under the same motion of the hand, as far as the motion is a sum of sines; otherwise
    it is what the environment itself went through behind the effects.
    """
    part = _last(run, _IN_LOOPS)
    length, newton = _units(run)
    factor, shown = (1e3, "mm") if length == "m" and run.motion.amplitude < 0.2 else (1.0, length)
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    x, force, name = _environment_loop(run, part)
    ax.plot(_smooth(x) * factor, _smooth(force), color=BLUE, linewidth=1.1)
    ax.plot(
        _smooth(run.displacement[part]) * factor, _smooth(run.force[part]), color=RED, linestyle=_DASHED, linewidth=1.1
    )
    dress(ax)
    ax.set_xlabel(f"displacement ({shown})", fontsize=TEXT)
    ax.set_ylabel(f"force ({newton})", fontsize=TEXT)
    legend(ax, [handle(BLUE, _SOLID, name), handle(RED, _DASHED, "at the hand")])


def draw_recovered(ax: Axes, runs: Sequence[Simulated], part: Part) -> None:
    """Re or Im of H_perc over frequency: the closed form as a line, what was recovered from the force as rings."""
    rows = sorted((x for run in runs for x in run.estimates), key=lambda x: x.omega)
    omegas = np.array([x.omega for x in rows])
    low, high = omegas[0], omegas[-1]
    margin = 0.04 * (high - low) or 0.1 * high
    grid = np.linspace(max(low - margin, low / 2), high + margin, 601)
    values = runs[0].scene.distortion().compile()(grid)
    curve = values.perceived_real if part is Part.REAL else values.perceived_imag
    found = [x.simulated.real if part is Part.REAL else x.simulated.imag for x in rows]
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.plot(grid, curve, color=RED, linestyle=_DASHED, linewidth=1.1)
    marker: dict[str, Any] = {"marker": "o", "markersize": 3.8, "markerfacecolor": "white", "markeredgewidth": 0.9}
    ax.plot(omegas, found, linestyle="none", color=INK, zorder=4, **marker)
    ax.set(xlim=(grid[0], grid[-1]), ylim=_limits(curve, np.array(found)))
    dress(ax)
    ax.set_xlabel(r"$\omega$ (rad/s)", fontsize=TEXT)
    unit = "N·m/rad" if runs[0].scene.motion is Kind.ROTATION else "N/m"
    name = rf"\mathrm{{{'Re' if part is Part.REAL else 'Im'}}}"
    ax.set_ylabel(rf"${name}\,H_\mathrm{{perc}}$ ({unit})", fontsize=TEXT)
    rings = Line2D([], [], linestyle="none", color=INK, label="from the simulated force", **marker)
    legend(ax, [handle(RED, _DASHED, "closed form"), rings])


def save_simulation_figures(runs: Sequence[Simulated], directory: str | Path) -> list[Path]:
    """All figures of a simulation as SVG, PDF and PNG, one column (3.4 in) wide, in a directory that is made if need be.

    Time and loops are those of the middle run; H_perc is drawn where at least one ratio was recovered.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    run = runs[len(runs) // 2]
    drawings: dict[str, tuple[float, Callable[[Axes], None]]] = {
        "simulated-time": (2.0, lambda ax: draw_time(ax, run)),
        "simulated-loop": (2.4, lambda ax: draw_loop(ax, run)),
    }
    if any(run.estimates for run in runs):
        drawings["recovered-real"] = (2.0, lambda ax: draw_recovered(ax, runs, Part.REAL))
        drawings["recovered-imag"] = (2.0, lambda ax: draw_recovered(ax, runs, Part.IMAG))
    return [path for name, (height, draw) in drawings.items() for path in save(folder / name, one_column(height, draw))]


def _last(run: Simulated, periods: int) -> slice:
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


def _environment_loop(run: Simulated, part: slice) -> tuple[Array, Array, str]:
    if not run.motion.omegas:
        return run.environment_displacement[part], run.environment_force[part], "environment"
    values = run.scene.distortion().compile()(np.array(run.motion.omegas))
    phasors = np.array([run.motion.phasor(omega) for omega in run.motion.omegas])  # type: ignore[attr-defined]
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


def _units(run: Simulated) -> tuple[str, str]:
    return ("rad", "N·m") if run.scene.motion is Kind.ROTATION else ("m", "N")


def _short_length(value: float, unit: str) -> str:
    return f"{value * 1e3:.3g} mm" if unit == "m" and value < 0.2 else f"{value:.3g} {unit}"
