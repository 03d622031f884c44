"""The figure of an identification: magnitude and phase of the model over the measured lines, and the residuals below."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.measured import disc_handle, scale_of_lines, spread_out, thinned
from haptisym.figures.sheet import stacked
from haptisym.figures.style import dots, dress, legend, name_dynamics, name_frequency
from haptisym.verbs.identify.entry import Identification
from haptisym.verbs.identify.fitting import Curve

_MANY = 8000
"""Lines that show the course of the model by themselves."""


def identification_figure(a: Identification) -> Figure:
    """Three drawings above each other, one column of a journal wide."""
    magnitude = (1.5, lambda ax: draw_magnitude(ax, a))
    phase = (1.1, lambda ax: draw_phase(ax, a))
    residuals = (1.0, lambda ax: draw_residuals(ax, a))
    return stacked(4.2, magnitude, phase, residuals, aligned=True)


def draw_magnitude(ax: Axes, a: Identification, *, hertz: bool | None = None) -> list[Line2D]:
    """``|H|`` of the model as a curve, and of the lines with the reach of their discs. Returns curve and dots."""
    lines = a.fit.lines
    drawn, scale = thinned(len(lines)), scale_of_lines(lines.omega, hertz=hertz)
    at, H, reach = scale.of(lines.omega[drawn]), lines.H[drawn], _reach(a)[drawn]
    omega, model = _model(a)
    size = np.abs(H)
    made = ax.plot(scale.of(omega), np.abs(model), color=pen.RED, linewidth=1.1, label="model", zorder=3)
    ax.vlines(
        at, np.maximum(size - reach, 1e-3 * size), size + reach, color=pen.BLUE, linewidth=0.7, alpha=0.55, zorder=1
    )
    made += ax.plot(at, size, color=pen.BLUE, label="measured", zorder=2, **dots(2.4))
    told = [disc_handle(lines.confidence)] if _knows(a) else []
    dress(ax)
    if size.min() > 0 and size.max() > 8 * size.min():
        ax.set_yscale("log")
    spread_out(ax, at)
    name_frequency(ax, scale)
    name_dynamics(ax.yaxis, "|H|", a)
    legend(ax, [*made, *told])
    return made


def draw_phase(ax: Axes, a: Identification, *, hertz: bool | None = None) -> list[Line2D]:
    """The phase of both, degrees, without jumps. Returns curve and dots."""
    lines = a.fit.lines
    drawn, scale = thinned(len(lines)), scale_of_lines(lines.omega, hertz=hertz)
    at, H, reach = scale.of(lines.omega[drawn]), lines.H[drawn], _reach(a)[drawn]
    omega, model = _model(a)
    phase = np.unwrap(np.angle(model))
    own = np.interp(lines.omega[drawn], omega, phase) + np.angle(H / a.fit.model[drawn])
    half = np.degrees(np.arcsin(np.minimum(reach / np.maximum(np.abs(H), 1e-300), 1)))
    made = ax.plot(scale.of(omega), np.degrees(phase), color=pen.RED, linewidth=1.1, zorder=3)
    ax.vlines(at, np.degrees(own) - half, np.degrees(own) + half, color=pen.BLUE, linewidth=0.7, alpha=0.55, zorder=1)
    made += ax.plot(at, np.degrees(own), color=pen.BLUE, zorder=2, **dots(2.4))
    dress(ax)
    spread_out(ax, at)
    name_frequency(ax, scale)
    ax.set_ylabel("phase (deg)", fontsize=pen.TEXT)
    return made


def draw_residuals(ax: Axes, a: Identification, *, hertz: bool | None = None) -> list[Line2D]:
    """Measured less model, real and imaginary part, in units of their standard error, between lines at plus and minus 2."""
    drawn, scale = thinned(len(a.fit.lines)), scale_of_lines(a.fit.lines.omega, hertz=hertz)
    at, residuals = scale.of(a.fit.lines.omega[drawn]), a.fit.residuals[drawn]
    if not _knows(a):
        residuals = residuals / (np.sqrt(np.square(np.abs(residuals)).mean() / 2) or 1.0)
    for y in (-2, 0, 2):
        ax.axhline(y, color=pen.GREY, linewidth=0.5, linestyle="-" if y == 0 else pen.DASHED, zorder=0)
    looks: Any = ((residuals.real, "o", pen.INK, r"$\mathrm{Re}$"), (residuals.imag, "s", "white", r"$\mathrm{Im}$"))
    made: list[Line2D] = []
    for values, marker, face, label in looks:
        made += ax.plot(
            at, values, color=pen.INK, label=label, **dots(2.4, marker, markerfacecolor=face, markeredgewidth=0.6)
        )
    top = max(3.0, 1.1 * float(np.abs(np.concatenate([residuals.real, residuals.imag])).max()))
    ax.set_ylim(-top, top)
    dress(ax)
    spread_out(ax, at)
    name_frequency(ax, scale)
    ax.set_ylabel("residual / error", fontsize=pen.TEXT)
    legend(ax, made)
    return made


def _model(a: Identification) -> tuple[Any, Any]:
    omega = a.fit.lines.omega
    spread = np.geomspace if omega[-1] > 30 * omega[0] else np.linspace
    at = np.union1d(omega, spread(omega[0], omega[-1], 800)) if len(omega) < _MANY else omega
    return at, Curve(a.wanted, at).at(a.fit.values)


def _reach(a: Identification) -> Any:
    discs = a.fit.lines.discs
    return np.zeros(len(a.fit.lines)) if discs is None else discs


def _knows(a: Identification) -> bool:
    return a.fit.lines.discs is not None
