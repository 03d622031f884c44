"""Does it survive another JND model: the distortion's way through the plane of Re and Im, with the regions that it may leave."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import Affine2D

from haptisym.figures.outlines import outline
from haptisym.figures.sampling import sampled
from haptisym.figures.style import BLUE, DASHED, DOTTED, GREY, INK, RED, SOLID, TEXT, dress, handle, legend, limit
from haptisym.judge.criteria import noticed
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.spread import Compared, half_widths
from haptisym.programs.formulas import floats_of
from haptisym.programs.values import Array

_LOOKS = ((GREY, SOLID), (BLUE, DASHED), (RED, DOTTED), ("#d0701f", SOLID))


def draw_regions(ax: Axes, evaluation: Evaluation) -> list[Line2D]:
    """(Re dH, Im dH)/``|H_env|`` over the band, with the regions of ``evaluation.regions``; a dot where each is first met.

    A region that depends on the frequency, as a floor and limits for each way do, is drawn as it is where it is first met, or
    else at the high end of the band. Returns the line of the distortion.
    """
    f = evaluation.distortion.compile()
    omega = sampled(evaluation)
    way = _way(f(omega))
    corners = [_draw_region(ax, evaluation, x, look) for x, look in zip(evaluation.regions, _LOOKS, strict=False)]
    [line] = ax.plot(*way.T, color=INK, linewidth=1.1)
    for x, (color, _) in zip(evaluation.regions, _LOOKS, strict=False):
        if x.crossing:
            [place] = _way(f(np.array([float(x.crossing.omega)])))
            ax.plot(*place[:, None], marker="o", markersize=3.6, color=color, zorder=4)
    reach = 1.6 * np.abs(np.concatenate(corners)).max()
    limit(ax, (-reach, reach), (-reach, reach))
    ax.set_aspect("equal", adjustable="box")
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    dress(ax)
    ax.set_xlabel(r"$\mathrm{Re}\,\Delta H/|H_\mathrm{env}|$", fontsize=TEXT)
    ax.set_ylabel(r"$\mathrm{Im}\,\Delta H/|H_\mathrm{env}|$", fontsize=TEXT)
    shown = [handle(color, style, x.name, 1.0) for x, (color, style) in zip(evaluation.regions, _LOOKS, strict=False)]
    legend(ax, [handle(INK, SOLID, r"$\Delta H$ over the band", 1.1), *shown])
    return [line]


def _way(values: object) -> Array:
    """Both ratios with their signs."""
    v = values
    found: Array = np.stack(
        [np.copysign(v.ratio_real, v.real), np.copysign(v.ratio_imag, v.imag)],  # type: ignore[attr-defined]
        axis=1,
    )
    return found


def _draw_region(ax: Axes, evaluation: Evaluation, x: Compared, look: tuple[str, object]) -> Array:
    """One region about 0, where H_env is real and 1; its corners."""
    at = float(x.crossing.omega if x.crossing else evaluation.chart.points[-1].omega)
    color, style = look
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
