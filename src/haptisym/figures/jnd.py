"""Figures of JNDs: of a measured one the shares of the answers, the curve, and the JND with its
interval; the published ones."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.artist import Artist

from haptisym.figures import pen
from haptisym.figures.files import Drawings
from haptisym.figures.layers import DrawnAxis, Layer, Mark, Note, On, Panel, Polyline, Words, dots
from haptisym.verbs.jnd.entry import Psychometric, PublishedThresholds

_LEAST, _MOST = 3.0, 7.0
"""Points: the diameters of the dots of the fewest and of the most answers."""


def answers(p: Psychometric) -> Panel:
    """Dots for the shares of the answers, larger where there are more, and the curve; for the first
    on the axes the JND, too."""
    rows, (low, high) = p.answers.rows, _reach(p)
    level = np.linspace(low, high, 400)
    curve = Polyline(level, p.fit.curve(level), pen.BLUE, label="fitted curve", look={"zorder": 2})
    most = max(x.trials for x in rows)
    rim: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.5, "zorder": 3}
    shares = [
        Mark(
            [x.level],
            [x.share],
            pen.BLUE,
            size=max(_LEAST, _MOST * (x.trials / most) ** 0.5),
            look=rim,
            styled=True,
        )
        for x in rows
    ]
    told = Words(label="answers", look=dots(5, color=pen.BLUE))
    note = [Note("the curve does not fit these answers")] if p.deviance.fits is False else []
    upright = DrawnAxis(
        "share of right answers" if p.asked.alternatives else "share of “more”", ends=(-0.03, 1.03)
    )
    return Panel(
        [curve, *shares, told, *_jnd(p, low), *note],
        DrawnAxis("level", ends=(low, high)),
        upright,
        height=2.3,
    )


def _reach(p: Psychometric) -> tuple[float, float]:
    """The levels from which to which is drawn: the answers', and the threshold with its interval as
    far as it is near."""
    level = [x.level for x in p.answers.rows]
    span = level[-1] - level[0]
    start = 0.0 if p.asked.alternatives else p.middle.value
    ends = [x + start for x in (p.jnd.value, p.jnd.high) if x is not None]
    near = [x for x in (*ends, p.middle.value) if level[0] - span < x < level[-1] + span]
    low, high = min([*level, *near]), max([*level, *near])
    return low - 0.06 * (high - low), high + 0.06 * (high - low)


@dataclass(frozen=True)
class _First(Polyline):
    """A line of the first answers on the axes alone."""

    styled: bool = field(default=False, kw_only=True)

    def draw(self, on: On) -> list[Artist]:
        return [] if on.number else super().draw(on)


def _jnd(p: Psychometric, low: float) -> list[Layer]:
    """The middle of the curve, and where the JND is taken, with its interval as a bar."""
    start = 0.0 if p.asked.alternatives else p.middle.value
    at = start + p.jnd.value
    share, made, under = float(p.fit.curve(np.array([at]))[0]), list[Layer](), {"zorder": 1}
    if not p.asked.alternatives:
        half = float(p.fit.curve(np.array([start]))[0])
        made.append(
            _First(
                [start, start],
                [-0.03, half],
                pen.GREY,
                pen.DOTTED,
                0.6,
                label="subjective equality",
                look=under,
            )
        )
    told = f"JND at {100 * p.asked.proportion:.4g} %"
    made.append(
        _First(
            [low, at, at], [share, share, -0.03], pen.RED, pen.DASHED, 0.8, label=told, look=under
        )
    )
    if p.jnd.low is not None and p.jnd.high is not None:
        ends, look = (
            [start + p.jnd.low, start + p.jnd.high],
            {"alpha": 0.35, "solid_capstyle": "butt", "zorder": 1},
        )
        made.append(
            _First(
                ends,
                [share, share],
                pen.RED,
                width=3,
                label=f"{100 * p.confidence:.4g} % interval",
                look=look,
            )
        )
    return made


def published(found: PublishedThresholds) -> Panel:
    """A bar for each threshold that a scene can take, from its least to its largest fraction."""
    rows = [x for x in found if not x.apart]
    style = {"marker": "o", "markersize": 3.5}
    bars = [
        Polyline([100 * float(x.low), 100 * float(x.high)], [i, i], look=style)
        for i, x in enumerate(rows)
    ]
    return Panel(
        bars,
        DrawnAxis("just-noticeable difference (%)"),
        DrawnAxis(names=[x.name for x in rows]),
        height=0.5 + 0.16 * len(rows),
    )


JND, PUBLISHED = (
    Drawings[Psychometric]({"answers": answers}),
    Drawings[PublishedThresholds]({"fractions": published}),
)
