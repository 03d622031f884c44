"""Noticed or not: the JND square and regions at one frequency (the paper's Figs. 2 and 3).

JND regions as they are drawn at one frequency: patches around the tip of H_env, and the stretches of one part alone.

Noticed or not: the JND square at one frequency (the paper's Figs. 2 and 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Polygon, Rectangle

from haptisym.figures import pen
from haptisym.figures.nyquist import HEAD, arrow, responses, stacked
from haptisym.figures.sampling import band_of
from haptisym.figures.style import (
    Look,
    band_scale,
    curve_handles,
    curves,
    draw_origin,
    dress_plane,
    handle,
    legend,
    limit,
    number,
)
from haptisym.judge.crossings import Criterion
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.regions import Joint, Sided
from haptisym.judge.regions import Polygon as Cornered
from haptisym.kernel.errors import SceneError
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array

_DIRECTIONS = 720


@dataclass(frozen=True)
class Outline:
    """A region: ``patches`` about the tip, ``stretches`` of the real and of the imaginary part, ``corners`` of its frame."""

    patches: tuple[Patch, ...]
    stretches: tuple[tuple[tuple[float, float], ...], ...]
    corners: Array


def outline(
    criteria: Sequence[Criterion], tip: Array, omega: float, style: dict[str, Any], size: float | None = None
) -> Outline:
    """The changes that are not noticed where H_env has this tip (and, if it is given, that size), at a frequency in rad/s."""
    size = float(np.hypot(*tip)) if size is None else size
    if criteria[0].joint:
        return _joint(criteria[0].joint, tip, omega, style, size)
    stretches = tuple(_stretches(x, float(own), size, omega) for x, own in zip(criteria, tip, strict=True))
    patches = tuple(
        Rectangle((x0, y0), x1 - x0, y1 - y0, **(style if not i else {**style, "label": "_nolegend_"}))
        for i, ((x0, x1), (y0, y1)) in enumerate(product(*stretches))
    )
    ends = np.array([[own[0][0] for own in stretches], [own[-1][1] for own in stretches]])
    return Outline(patches, stretches, ends)


def _stretches(x: Criterion, own: float, size: float, omega: float) -> tuple[tuple[float, float], ...]:
    """The values of one part that are not told from its own."""
    if not isinstance(x.region, Sided):
        reach = floats_of(x.threshold, omega) * size
        return ((own - reach, own + reach),)
    least = 0.0 if x.region.floor is None else floats_of(x.region.floor, omega)
    higher, lower = (max(least, floats_of(c, omega) * size) for c in (x.region.higher, x.region.lower))
    way, turn = (1.0 if own >= 0 else -1.0), 2 * abs(own)  # beyond its mirror image a part grows again
    grown, shrunk = own + way * higher, own - way * min(lower, turn)
    if higher <= turn:
        return (_sorted(shrunk, grown),)
    again = own - way * higher
    if lower >= turn:
        return (_sorted(again, grown),)
    return tuple(sorted((_sorted(shrunk, grown), _sorted(again, own - way * turn))))


def _sorted(a: float, b: float) -> tuple[float, float]:
    return min(a, b), max(a, b)


def _joint(region: Joint, tip: Array, omega: float, style: dict[str, Any], size: float) -> Outline:
    angles = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    if isinstance(region, Cornered):
        corners = np.array([[floats_of(c, omega) for c in corner] for corner in region.corners])
        angles = np.sort(np.concatenate([angles, np.arctan2(corners[:, 1], corners[:, 0]) % (2 * np.pi)]))
    across, up = np.cos(angles), np.sin(angles)
    reach = size / region.enlarged(across, up, lambda x: floats_of(x, omega))
    border = tip + np.stack([across, up], axis=1) * reach[:, None]
    quarters = [reach[np.argmin(np.abs(angles - n * np.pi / 2))] for n in range(4)]
    stretches = tuple(((float(tip[i] - quarters[i + 2]), float(tip[i] + quarters[i])),) for i in (0, 1))
    ends = np.array([border.min(axis=0), border.max(axis=0)])
    return Outline((Polygon(border, closed=True, **style),), stretches, ends)


def draw_jnd_square(
    ax: Axes, evaluation: Evaluation, omega: float, *, color: str | None = None, label: str = ""
) -> list[Artist]:
    """H_env and H_perc at one frequency of the band, rad/s, with the region of changes that are not noticed (Fig. 2).

    The square is c_real ``|H_env|`` wide and c_imag ``|H_env|`` high to each side of the tip of H_env; other regions are drawn as
    they are. What is not noticed of one part alone are bars on the axes. Raises SceneError outside the band and where H_env or
    H_perc is infinite.

    ``color``, ``label`` : of the scene; the verdict stands in the title, that of a further scene in the legend.
    Returns the region and the two arrows.

    >>> from haptisym import evaluate, load_scene
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().add_subplot()
    >>> region, *arrows = draw_jnd_square(ax, evaluate(load_scene("fu2019")), 10)
    >>> ax.get_title()
    '$\\\\omega$ = 10 rad/s: noticed in the real part'
    """
    noticed = [x for x in evaluation.criteria if _sign_at(evaluation, omega, x) > 0]
    tips = stacked(responses(evaluation.distortion.compile(), np.array([omega])))
    if not np.isfinite(tips).all():
        raise SceneError(f"omega: the dynamics are infinite at {omega:g} rad/s")
    look = Look.on(ax, r"$H_\mathrm{env}$", color, label)
    around = outline(evaluation.criteria, tips[0], omega, _style(look))
    region = _draw_region(ax, around, look)
    frame = _frame(np.array([[0, 0], *tips, *around.corners]))
    limit(ax, *frame, number=look.number)
    ax.set_aspect("equal", adjustable="box")
    arrows = [_draw_vector(ax, tip, colour, style) for tip, (colour, style, _) in zip(tips, curves(look), strict=True)]
    dress_plane(ax, evaluation.scene)
    handles = curve_handles(look)
    scale = band_scale(evaluation.scene.band)
    at = rf"$\omega$ = {number(omega, 4)} rad/s" if scale.factor == 1 else f"{number(scale.of(omega), 4)} Hz"
    if look.number:
        handles[1].set_label(f"{handles[1].get_label()}: {_verdict(noticed)}")
    title = ax.get_title() if look.number else f"{at}: {_verdict(noticed)}"
    rows = legend(ax, [*handles, region, *_projected()])
    ax.set_title(title, fontsize=pen.TEXT, pad=(0.8 + 1.42 * rows) * pen.SMALL)
    return [region, *arrows]


def _projected() -> list[Artist]:
    return [
        handle(pen.INK, pen.DOTTED, "projections", 0.6),
        handle(pen.GREY, "-", "not noticed in one part", 3, alpha=0.5, solid_capstyle="butt"),
    ]


def _verdict(noticed: Sequence[Criterion]) -> str:
    if not noticed:
        return "not noticed"
    if noticed[0].joint:
        return f"outside the {noticed[0].joint.kind}"
    return f"noticed in {'both parts' if len(noticed) == 2 else f'the {noticed[0].words}'}"


def _sign_at(evaluation: Evaluation, omega: float, criterion: Criterion) -> int:
    """The proven sign of what is judged at a frequency."""
    points = evaluation.chart.points
    below = [point for point in points if float(point.omega) <= omega]
    if not below or omega > float(points[-1].omega):
        raise SceneError(
            f"omega: {omega:g} rad/s is not on the band, {' to '.join(f'{x:g}' for x in band_of(evaluation))}"
        )
    return (below[-1].at if float(below[-1].omega) == omega else below[-1].after)[criterion]


def _style(look: Look) -> dict[str, Any]:
    """Of the region; of a further scene its outline alone."""
    style: dict[str, Any] = {"facecolor": pen.SHADE, "edgecolor": pen.GREY, "label": "not noticed"}
    if look.number:
        style = {"facecolor": "none", "edgecolor": look.color, "label": f"not noticed{look.suffix}"}
    return {**style, "linewidth": 0.6, "zorder": 1}


def _draw_region(ax: Axes, around: Outline, look: Look) -> Patch:
    """The region of changes that are not noticed, and what is not noticed of one part alone on the axes."""
    for patch in around.patches:
        ax.add_patch(patch)
    if not look.number:
        draw_origin(ax)
        bar: dict[str, Any] = {"color": pen.GREY, "alpha": 0.5, "linewidth": 3, "solid_capstyle": "butt", "zorder": 1}
        for low, high in around.stretches[0]:
            ax.plot([low, high], [0, 0], **bar)
        for low, high in around.stretches[1]:
            ax.plot([0, 0], [low, high], **bar)
    return around.patches[0]


def _draw_vector(ax: Axes, tip: Array, color: str, style: Any) -> Artist:
    """An arrow from the origin whose shaft ends where its head begins, and the projections of its tip on both axes."""
    ax.plot([tip[0], tip[0], 0], [0, tip[1], tip[1]], color=color, linewidth=0.6, linestyle=pen.DOTTED, zorder=2)
    if not tip.any():
        [spot] = ax.plot([0], [0], color=color, marker="o", markersize=3.6, zorder=3)
        return spot
    shaft = {"arrowstyle": "-", "color": color, "linewidth": 1.2, "linestyle": style, "shrinkA": 0, "shrinkB": HEAD}
    made = ax.annotate("", xy=(tip[0], tip[1]), xytext=(0, 0), arrowprops=shaft, zorder=3)
    arrow(ax, 0.95 * tip, tip, color)
    return made


def _frame(points: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits that hold the points with a margin, at equal scales, neither very wide nor very high."""
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.57 * np.maximum(high - low, 0.6 * np.max(high - low) or 1.0)
    low, high = (low + high) / 2 - half, (low + high) / 2 + half
    return (low[0], high[0]), (low[1], high[1])
