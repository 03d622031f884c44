"""The figure of several environments: each one's ratios, their envelope, and the one that binds."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures import pen
from haptisym.figures.judged import columns, limit_of, name_of
from haptisym.figures.regions import family_regions_figure
from haptisym.figures.sampling import broken, sampled
from haptisym.figures.sheet import laid_out, save_all
from haptisym.figures.style import RADIANS, Scale, band_scale, dress, handle, label_above, legend, name_frequency, shade
from haptisym.judge.crossings import noticed
from haptisym.programs.values import Array
from haptisym.verbs.family.entry import FamilyEvaluation

_BINDING: tuple[tuple[str, Any], ...] = (
    (pen.BLUE, pen.SOLID),
    (pen.RED, pen.DASHED),
    ("#7cc0c8", pen.SOLID),
    ("#d0701f", pen.DASHED),
)
"""Colours and strokes of the environments that bind, in the order in which they do."""


SampledCriteria: TypeAlias = dict[str, Array]
"""What is judged, a column for each criterion, by the name of the environment."""


def draw_envelope(
    ax: Axes, evaluation: FamilyEvaluation, which: int, omega: Array, sampled: SampledCriteria, scale: Scale = RADIANS
) -> list[Line2D]:
    """One ratio of each environment as a thin line, the largest as a thick one, the binding environments in colour.

    Grey: where every environment is transparent. A dot marks each end of that at which this criterion, the ``which``-th, binds.
    ``omega`` : rad/s; drawn in the unit of ``scale``. Returns the line of each environment, then the dots.
    """
    ratios = {name: all_[:, which] for name, all_ in sampled.items()}
    envelope = np.max(np.nan_to_num(np.stack(list(ratios.values())), nan=np.inf), axis=0)
    criterion = noticed(evaluation.family.threshold)[which]
    c, at = limit_of(criterion), scale.of(omega)
    looks = binding_looks(evaluation)
    shade(ax, evaluation.transparent, scale)
    ax.axhline(c, color=pen.GREY, linewidth=0.6, linestyle=pen.DOTTED)
    lines = []
    for name, values in ratios.items():
        color, style = looks.get(name, (pen.GREY, pen.SOLID))
        width = 1.1 if name in looks else 0.6
        lines += ax.plot(at, values, color=color, linestyle=style, linewidth=width, zorder=3)
    ax.plot(at, envelope, color=pen.INK, linewidth=2.2, alpha=0.35, zorder=2, solid_capstyle="butt")
    for x in (x for x in evaluation.binding if x.criterion == criterion):
        color, place = looks[x.environment][0], scale.of(float(x.omega))
        lines += ax.plot([place], [c], marker="o", markersize=3.8, color=color, zorder=4, clip_on=False)
    ax.set(xlim=(at[0], at[-1]), ylim=(0, _height(envelope, c)))
    dress(ax, y=name_of(criterion))
    return lines


def draw_worst(ax: Axes, found: FamilyEvaluation, which: int = 0) -> list[Line2D]:
    """One ratio of each environment, and the largest of them: the ``which``-th criterion. Returns a line for each, and dots."""
    scale, (omega, values) = band_scale(found.family.first.band), sampled_family(found)
    lines = draw_envelope(ax, found, which, omega, values, scale)
    name_frequency(ax, scale)
    legend(ax, envelope_handles(found))
    return lines


def _height(envelope: Array, c: float) -> float:
    """The top of the axes: all of the envelope where it is not far above the threshold."""
    finite = envelope[np.isfinite(envelope)]
    highest = float(finite.max()) if finite.size else 0.0
    return min(max(1.08 * highest, 1.6 * c), 4 * c)


def sampled_family(evaluation: FamilyEvaluation) -> tuple[Array, SampledCriteria]:
    """Frequencies, rad/s, and what is judged there of each environment."""
    omega = _common_grid(evaluation)
    return omega, _sampled(evaluation, omega)


def _common_grid(evaluation: FamilyEvaluation) -> Array:
    grids = [sampled(x) for x in evaluation.answers.values()]
    ends = [float(point.omega) for point in evaluation.chart.points]
    return np.unique(np.concatenate([*grids, ends]))


def _sampled(evaluation: FamilyEvaluation, omega: Array) -> SampledCriteria:
    found = {}
    for name, answers in evaluation.answers.items():
        values = answers.distortion.compile()(omega)
        found[name] = broken(columns(answers.criteria, values, omega), omega, answers.unbounded)
    return found


def binding_looks(evaluation: FamilyEvaluation) -> dict[str, tuple[str, Any]]:
    """The colour and stroke of each environment that binds somewhere."""
    names = list(dict.fromkeys(x.environment for x in evaluation.binding))
    return {name: _BINDING[i % len(_BINDING)] for i, name in enumerate(names)}


def save_family_figures(evaluation: FamilyEvaluation, directory: str | Path) -> list[Path]:
    """``worst-case``, and ``regions`` where they were asked for, as files one column wide."""
    more = {"regions": family_regions_figure(evaluation)} if evaluation.regions else {}
    return save_all({"worst-case": family_figure(evaluation), **more}, directory)


def family_figure(evaluation: FamilyEvaluation) -> Figure:
    """A panel for each criterion, one above the other, with one legend."""
    count = len(noticed(evaluation.family.threshold))
    height = 0.7 + 1.3 * count
    figure = Figure(figsize=(pen.WIDTH, height), layout="compressed")
    panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    scale, (omega, sampled) = band_scale(evaluation.family.first.band), sampled_family(evaluation)
    for which, ax in enumerate(panels):
        draw_envelope(ax, evaluation, which, omega, sampled, scale)
    for ax in panels[:-1]:
        ax.tick_params(labelbottom=False)
    name_frequency(panels[-1], scale)
    ends = dict.fromkeys(x.omega for x in evaluation.binding)
    label_above(panels[0], [(scale.of(float(x)), scale.digits(x, 4)) for x in ends])
    legend(panels[0], envelope_handles(evaluation), lines=1)
    return laid_out(figure, height, panels[0])


def envelope_handles(evaluation: FamilyEvaluation) -> list[Any]:
    """What the legend of an envelope says."""
    looks = binding_looks(evaluation)
    bound = [
        handle(color, style, fill(f"limited by {name}", 40), 1.1, marker="o", markersize=3.8)
        for name, (color, style) in looks.items()
    ]
    others = [] if len(looks) == len(evaluation.family) else [handle(pen.GREY, pen.SOLID, "others", 0.6)]
    ground = [Patch(facecolor=pen.SHADE, label="all transparent")] if evaluation.transparent else []
    return [
        handle(pen.INK, pen.SOLID, "largest", 2.2, alpha=0.35),
        *bound,
        *others,
        handle(pen.GREY, pen.DOTTED, "threshold", 0.6),
        *ground,
    ]
