"""Does it survive another JND model?

Of one environment the distortion's way through the plane of Re and Im, with the regions that it may leave; of several the
bandwidth of each by every region.
"""

from __future__ import annotations

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Affine2D

from haptisym.figures import pen
from haptisym.figures.sampling import sampled
from haptisym.figures.sheet import one_column
from haptisym.figures.square import outline
from haptisym.figures.style import band_scale, dots, draw_origin, dress, dress_changes, handle, legend, limit
from haptisym.judge.crossings import noticed
from haptisym.judge.evaluation import Compared, Evaluation, half_widths
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array
from haptisym.verbs.family.entry import FamilyEvaluation

_LOOKS = (
    (pen.GREY, pen.SOLID, "s"),
    (pen.BLUE, pen.DASHED, "o"),
    (pen.RED, pen.DOTTED, "D"),
    (pen.SCENES[1], pen.SOLID, "x"),
)
"""Of each region: colour, stroke of its border, mark of its bandwidth."""
_BROAD = 16
"""Letters of a name in a line of it: more leave the axes no room."""


def draw_regions(ax: Axes, evaluation: Evaluation) -> list[Line2D]:
    """(Re dH, Im dH)/``|H_env|`` over the band, with the regions of ``evaluation.regions``; a dot where each is first met.

    A region that depends on the frequency, as a floor and limits for each way do, is drawn as it is where it is first met, or
    else at the high end of the band. Returns the line of the distortion.
    """
    f = evaluation.distortion.compile()
    omega = sampled(evaluation)
    way = _way(f(omega))
    corners = [_draw_region(ax, evaluation, x, look) for x, look in zip(evaluation.regions, _LOOKS, strict=False)]
    [line] = ax.plot(*way.T, color=pen.INK, linewidth=1.1)
    for x, (color, _, _) in zip(evaluation.regions, _LOOKS, strict=False):
        if x.crossing:
            [place] = _way(f(np.array([float(x.crossing.omega)])))
            ax.plot(*place[:, None], marker="o", markersize=3.6, color=color, zorder=4)
    reach = 1.6 * np.abs(np.concatenate(corners)).max()
    limit(ax, (-reach, reach), (-reach, reach))
    ax.set_aspect("equal", adjustable="box")
    draw_origin(ax)
    dress_changes(ax)
    shown = [
        handle(color, style, x.name, 1.0) for x, (color, style, _) in zip(evaluation.regions, _LOOKS, strict=False)
    ]
    legend(ax, [handle(pen.INK, pen.SOLID, r"$\Delta H$ over the band", 1.1), *shown])
    return [line]


def _way(values: object) -> Array:
    """Both ratios with their signs."""
    v = values
    found: Array = np.stack(
        [np.copysign(v.ratio_real, v.real), np.copysign(v.ratio_imag, v.imag)],  # type: ignore[attr-defined]
        axis=1,
    )
    return found


def _draw_region(ax: Axes, evaluation: Evaluation, x: Compared, look: tuple[str, object, str]) -> Array:
    """One region about 0, where H_env is real and 1; its corners."""
    at = float(x.crossing.omega if x.crossing else evaluation.chart.points[-1].omega)
    color, style, _ = look
    given = {"facecolor": "none", "edgecolor": color, "linewidth": 1.0, "linestyle": style, "zorder": 2}
    criteria = noticed(x.threshold)
    if criteria[0].joint:
        around, tip = outline(criteria, np.zeros(2), at, given, size=1.0), np.zeros(2)
    else:  # a floor, and which limit holds, depend on H_env
        here = evaluation.distortion.compile()(np.array([at]))
        tip = np.array([float(here.environment_real[0]), float(here.environment_imag[0])])
        around = outline(criteria, tip, at, given)
    size = 1.0 if criteria[0].joint else float(np.hypot(*tip))
    if not np.isfinite(size) or not size:
        widths = np.array([floats_of(c, at) for c in half_widths(x.threshold)])  # H_env has no size there
        return np.array([-widths, widths])
    for patch in around.patches:
        patch.set_transform(Affine2D().translate(*-tip).scale(1 / size) + ax.transData)
        ax.add_patch(patch)
    return (around.corners - tip) / size


def draw_family_regions(ax: Axes, evaluation: FamilyEvaluation) -> list[Line2D]:
    """A row for each environment and one for all together; a mark for the bandwidth that each region gives.

    A region that gives no bandwidth has no mark in that row. Returns the marks of each region.
    """
    names = [*evaluation.family, "all together"]
    scale = band_scale(evaluation.family.first.band)
    low, high = (scale.of(float(evaluation.chart.points[i].omega)) for i in (0, -1))
    rows, marks = np.arange(len(names)), list[Line2D]()
    for i, (x, (color, _, marker)) in enumerate(zip(evaluation.regions, _LOOKS, strict=False)):
        widths = [*(x.answers[name].bandwidth for name in evaluation.family), x.bandwidth]
        at = [np.nan if w is None else float(scale.of(float(w))) for w in widths]
        marks += ax.plot(at, rows + 0.2 * (i - 1.5), color=color, label=x.name, **dots(3.4, marker))
        marks[-1].set(zorder=3, clip_on=False)
    empty = np.isnan(np.array([x.get_xdata() for x in marks], dtype=float)).all(axis=0)
    for row in rows[empty]:
        ax.text(low + 0.01 * (high - low), row, "no bandwidth", fontsize=pen.SMALL, color=pen.INK, va="center")
    ax.axhline(len(names) - 1.5, color=pen.GREY, linewidth=0.5)
    ax.set(xlim=(low, high), ylim=(len(names) - 0.5, -0.5))
    dress(ax)
    ax.set_yticks(range(len(names)), [fill(x, _BROAD, max_lines=3, placeholder="…") for x in names])
    ax.set_xlabel(f"bandwidth ({scale.unit})", fontsize=pen.TEXT)
    legend(ax, marks)
    return marks


def family_regions_figure(evaluation: FamilyEvaluation) -> Figure:
    """The figure, as high as its rows need."""

    def draw(ax: Axes) -> None:
        draw_family_regions(ax, evaluation)
        figure = ax.get_figure(root=True)
        assert figure is not None
        engine = figure.get_layout_engine()
        assert engine is not None
        engine.execute(figure)
        legend(ax, [])  # in as many columns as the names leave room for

    return one_column(0.6 + 0.36 * (len(evaluation.family) + 1), draw)
