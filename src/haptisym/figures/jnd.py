"""Figures of just-noticeable differences: of a measured one the shares of the answers, the fitted
curve, and the JND with its interval; bars for the published ones."""

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
    # The area of a dot is in proportion to its number of answers, hence the square root; the
    # smallest are still seen.
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
    entry = Words(label="answers", look=dots(5, color=pen.BLUE))
    note = [Note("the curve does not fit these answers")] if p.deviance.fits is False else []
    upright = DrawnAxis(
        "share of right answers" if p.asked.alternatives else "share of “more”", ends=(-0.03, 1.03)
    )
    return Panel(
        [curve, *shares, entry, *_jnd(p, low), *note],
        DrawnAxis("level", ends=(low, high)),
        upright,
        height=2.3,
    )


def _reach(p: Psychometric) -> tuple[float, float]:
    """Return the levels from which to which is drawn: those of the answers, and the threshold with
    the upper end of its interval where these are near."""
    levels = [x.level for x in p.answers.rows]
    first, last = levels[0], levels[-1]
    span = last - first
    # With alternatives the JND is a level; else it is a distance from the point of equality.
    start = 0.0 if p.asked.alternatives else p.middle.value
    ends = [x + start for x in (p.jnd.value, p.jnd.high) if x is not None]
    # An end farther off than the answers reach is not drawn: it would press them together.
    near = [x for x in (*ends, p.middle.value) if first - span < x < last + span]
    shown = [*levels, *near]
    low, high = min(shown), max(shown)
    margin = 0.06 * (high - low)
    return low - margin, high + margin


@dataclass(frozen=True)
class _First(Polyline):
    """A line that is drawn for the first answers on the axes alone."""

    styled: bool = field(default=False, kw_only=True)

    def draw(self, on: On) -> list[Artist]:
        return [] if on.number else super().draw(on)


def _jnd(p: Psychometric, low: float) -> list[Layer]:
    """The middle of the curve, and where the JND is taken, with its interval as a bar."""
    start = 0.0 if p.asked.alternatives else p.middle.value
    level = start + p.jnd.value
    # The height is that of the curve at the JND: with guesses and lapses it is not the proportion
    # that was asked for.
    share, made, under = float(p.fit.curve(np.array([level]))[0]), list[Layer](), {"zorder": 1}
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
    label = f"JND at {100 * p.asked.proportion:.4g} %"
    made.append(
        _First(
            [low, level, level],
            [share, share, -0.03],
            pen.RED,
            pen.DASHED,
            0.8,
            label=label,
            look=under,
        )
    )
    if p.jnd.low is not None and p.jnd.high is not None:
        ends = [start + p.jnd.low, start + p.jnd.high]
        look = {"alpha": 0.35, "solid_capstyle": "butt", "zorder": 1}
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
