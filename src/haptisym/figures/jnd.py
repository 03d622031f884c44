"""Figures of JNDs: of a measured one the shares of the answers, the curve, and the JND with its interval; the published ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.sheet import one_column
from haptisym.figures.style import dots, dress, entries, legend, write_note
from haptisym.verbs.jnd.entry import Psychometric, PublishedThresholds

_HEIGHT = 2.3
_LEAST, _MOST = 3.0, 7.0
"""Points: the diameters of the dots of the fewest and of the most answers."""


def draw_jnd(ax: Axes, p: Psychometric, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """Dots for the shares of the answers, larger where there are more, and the curve; for the first on the axes the JND, too.

    ``color``, ``label`` : of this person or condition; a further one gets the next colour. Returns the curve and the dots.
    """
    before = sum(str(x.get_label()).startswith("fitted curve") for x in ax.lines)
    own = color or (pen.BLUE if not before else pen.SCENES[before % len(pen.SCENES)])
    suffix = f", {label}" if label else ""
    rows, (low, high) = p.answers.rows, _reach(p)
    level = np.linspace(low, high, 400)
    [curve] = ax.plot(level, p.fit.curve(level), color=own, linewidth=1.1, label=f"fitted curve{suffix}", zorder=2)
    most = max(x.trials for x in rows)
    rim: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.5}
    shares: list[Line2D] = []
    for x in rows:
        size = max(_LEAST, _MOST * (x.trials / most) ** 0.5)
        shares += ax.plot([x.level], [x.share], color=own, zorder=3, **dots(size, **rim))
    shares[0].set_label(f"answers{suffix}")
    told = [curve, Line2D([], [], color=own, label=f"answers{suffix}", **dots(5))]
    if not before:
        told += _mark(ax, p)
    ax.set_ylim(-0.03, 1.03)
    ax.set_xlim(low, high)
    dress(ax, "level", "share of right answers" if p.asked.alternatives else "share of “more”")
    legend(ax, [*entries(ax).values(), *told])
    if p.deviance.fits is False:
        write_note(ax, "the curve does not fit these answers")
    return [curve, *shares]


def jnd_figure(p: Psychometric) -> Figure:
    """One column of a journal."""
    return one_column(_HEIGHT, lambda ax: draw_jnd(ax, p))


def _reach(p: Psychometric) -> tuple[float, float]:
    """The levels from which to which is drawn: the answers', and the threshold with its interval as far as it is near."""
    level = [x.level for x in p.answers.rows]
    span = level[-1] - level[0]
    start = 0.0 if p.asked.alternatives else p.middle.value
    ends = [x + start for x in (p.jnd.value, p.jnd.high) if x is not None]
    near = [x for x in (*ends, p.middle.value) if level[0] - span < x < level[-1] + span]
    low, high = min([*level, *near]), max([*level, *near])
    return low - 0.06 * (high - low), high + 0.06 * (high - low)


def _mark(ax: Axes, p: Psychometric) -> list[Line2D]:
    """The middle of the curve, and where the JND is taken, with its interval as a bar."""
    start = 0.0 if p.asked.alternatives else p.middle.value
    at = start + p.jnd.value
    share = float(p.fit.curve(np.array([at]))[0])
    made: list[Line2D] = []
    if not p.asked.alternatives:
        half = float(p.fit.curve(np.array([start]))[0])
        ax.plot([start, start], [-0.03, half], color=pen.GREY, linewidth=0.6, linestyle=pen.DOTTED, zorder=1)
        made.append(Line2D([], [], color=pen.GREY, linewidth=0.6, linestyle=pen.DOTTED, label="subjective equality"))
    ax.plot([at, at], [-0.03, share], color=pen.RED, linewidth=0.8, linestyle=pen.DASHED, zorder=1)
    ax.plot([ax.get_xlim()[0], at], [share, share], color=pen.RED, linewidth=0.8, linestyle=pen.DASHED, zorder=1)
    made.append(
        Line2D(
            [], [], color=pen.RED, linewidth=0.8, linestyle=pen.DASHED, label=f"JND at {100 * p.asked.proportion:.4g} %"
        )
    )
    if p.jnd.low is not None and p.jnd.high is not None:
        ends = [start + p.jnd.low, start + p.jnd.high]
        ax.plot(ends, [share, share], color=pen.RED, linewidth=3, alpha=0.35, solid_capstyle="butt", zorder=1)
        told = f"{100 * p.confidence:.4g} % interval"
        made.append(Line2D([], [], color=pen.RED, linewidth=3, alpha=0.35, label=told))
    return made


def draw_published(ax: Axes, found: PublishedThresholds) -> list[Line2D]:
    """A bar for each threshold that a scene can take, from its least to its largest fraction. Returns the bars."""
    rows = [x for x in found if not x.apart]
    made = [
        ax.plot([100 * float(x.low), 100 * float(x.high)], [i, i], "o-", color=pen.INK, markersize=3.5, linewidth=1.1)[
            0
        ]
        for i, x in enumerate(rows)
    ]
    dress(ax)
    ax.set_yticks(range(len(rows)), [x.name for x in rows], fontsize=pen.SMALL)
    ax.invert_yaxis()
    ax.set_xlabel("just-noticeable difference (%)", fontsize=pen.TEXT)
    return made
