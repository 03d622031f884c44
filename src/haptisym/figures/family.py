"""Figures of several environments: the ratios of each, the largest of them, and what limits it;
bandwidths by JND region.

The largest ratio decides: a display is transparent with all environments exactly where the largest
is within its threshold.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from haptisym.figures import pen
from haptisym.figures.curves import broken, columns, ends_of, limit_of, name_of, sampled
from haptisym.figures.evaluation import REGIONS
from haptisym.figures.files import Drawings, drawings_of, sheet
from haptisym.figures.layers import (
    Above,
    DrawnAxis,
    Intervals,
    Layer,
    Limit,
    Mark,
    On,
    Panel,
    Polyline,
    Words,
    frequency,
    small,
)
from haptisym.judge.crossings import noticed
from haptisym.judge.evaluation import different, region_label
from haptisym.kernel.errors import NothingToDrawError
from haptisym.programs.values import Array
from haptisym.verbs.family.answers import FamilyAnswers
from haptisym.verbs.family.entry import FamilyEvaluation
from haptisym.writing.characters import printable

_LIMITING = (
    (pen.BLUE, pen.SOLID),
    (pen.RED, pen.DASHED),
    ("#7cc0c8", pen.SOLID),
    ("#d0701f", pen.DASHED),
)
"""Colours and strokes of the environments that limit, in the order in which they do."""
_BROAD = 16
"""Letters of a name in a line of it: more leave the axes no room."""


def worst(
    w: FamilyEvaluation, which: int = 0, *, shared: tuple[Array, dict[str, Array]] | None = None
) -> Panel:
    """One ratio of each environment as a thin line, the largest as a thick one, the limiting
    environments in colour with their names.

    Grey: where every environment is transparent. A dot marks each end of that at which this
    criterion, the ``which``-th, limits.
    ``shared`` : frequencies, rad/s, and what is judged there of each environment, where that is at
    hand.
    """
    omega, judged = shared or _sampled(w)
    values = {name: all_[:, which] for name, all_ in judged.items()}
    # A gap is a pole: the largest ratio is infinite there.
    envelope = np.max(np.nan_to_num(np.stack(list(values.values())), nan=np.inf), axis=0)
    criterion = noticed(w.family.threshold)[which]
    c, looks = limit_of(criterion), _looks(w)
    lines, marks = list[Layer](), list[Layer]()
    # Legends list limiting environments in the order in which they limit, then the others.
    for name, ratio in sorted(
        values.items(), key=lambda x: list(looks).index(x[0]) if x[0] in looks else len(looks)
    ):
        color, stroke = looks.get(name, (pen.GREY, pen.SOLID))
        label, width = ("", 1.1) if name in looks else ("others", 0.6)
        lines.append(
            Polyline(
                omega,
                ratio,
                color,
                stroke,
                width,
                label=label,
                name=printable(name) if name in looks else "",
                look={"zorder": 3},
            )
        )
    for x in (x for x in w.binding if x.criterion == criterion):
        look = {"zorder": 4, "clip_on": False}
        marks.append(
            Mark([float(x.omega)], [c], looks[x.environment][0], size=3.8, look=look, styled=True)
        )
    layers = [
        Polyline(omega, envelope, width=2.2, label="largest", styled=False, look=_ENVELOPE),
        *lines,
        *marks,
        Limit(c, stroke=pen.DOTTED, label="threshold"),
        Intervals([ends_of(x) for x in w.transparent], label="all transparent", firm=True),
    ]
    finite = envelope[np.isfinite(envelope)]
    # The threshold is seen in all cases, and what is above four thresholds in none.
    top = min(max(1.08 * float(finite.max(initial=0.0)), 1.6 * c), 4 * c)
    axis = frequency(w.family.frequency, (float(omega[0]), float(omega[-1])))
    return Panel(layers, axis, DrawnAxis(name_of(criterion), ends=(0, top)), height=1.3)


_ENVELOPE = {"alpha": 0.35, "zorder": 2, "solid_capstyle": "butt"}


def _sampled(w: FamilyEvaluation) -> tuple[Array, dict[str, Array]]:
    """Frequencies, rad/s, and what is judged there of each environment, a column for each
    criterion."""
    grids = [sampled(x) for x in w.answers.values()]
    # One grid for all environments, or else no largest ratio could be taken sample by sample.
    omega = np.unique(np.concatenate([*grids, [float(point.omega) for point in w.chart.points]]))
    judged = {}
    for name, x in w.answers.items():
        judged[name] = broken(
            columns(x.criteria, x.distortion.compile()(omega), omega), omega, x.unbounded
        )
    return omega, judged


def _looks(w: FamilyEvaluation) -> dict[str, tuple[str, Any]]:
    """Return the colour and stroke of each environment that limits somewhere."""
    names = list(dict.fromkeys(x.environment for x in w.binding))
    return {name: _LIMITING[i % len(_LIMITING)] for i, name in enumerate(names)}


def worst_case(w: FamilyEvaluation, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """A chart for each criterion, one above the other, with one legend."""
    shared, count = _sampled(w), len(noticed(w.family.threshold))
    first, *others = (worst(w, i, shared=shared) for i in range(count))
    ends = dict.fromkeys(x.omega for x in w.binding)
    above = Above([(float(x), first.x.digits(x, 4)) for x in ends])
    # One legend for all criteria: its entries are those of the first panel.
    quiet = [
        replace(chart, layers=[replace(x, label="") for x in chart.layers]) for chart in others
    ]
    return sheet(Panel([*first.layers, above], first.x, first.y, first.height), *quiet, style=style)


def regions(w: FamilyEvaluation) -> Panel:
    """A row for each environment and one for all together; a mark for the bandwidth that each
    region gives.

    A region that gives no bandwidth has no mark in that row. NothingToDrawError where no regions
    were asked for.
    """
    if not w.regions:
        raise NothingToDrawError(
            "kind: no regions were compared: ask for them with evaluate_all(scenes, regions=True)"
        )
    names = [*w.family, "all together"]
    low, high = (float(w.chart.points[i].omega) for i in (0, -1))
    layers, empty = list[Layer](), np.ones(len(names), bool)
    for i, (x, (color, _, shape)) in enumerate(zip(different(w.regions), REGIONS, strict=False)):
        widths = [*(x.answers[name].bandwidth for name in w.family), x.bandwidth]
        # Marks of up to four regions side by side about the middle of the row.
        at = [(float(b), row + 0.2 * (i - 1.5)) for row, b in enumerate(widths) if b is not None]
        empty &= np.array([b is None for b in widths])
        look = {"zorder": 3, "clip_on": False}
        marks = Mark(
            [a for a, _ in at],
            [b for _, b in at],
            color,
            shape,
            3.4,
            look=look,
            label=region_label(x),
            styled=True,
        )
        layers.append(marks if at else Words(label=f"{region_label(x)}: none"))
    layers += [_Said("no bandwidth", int(row)) for row in np.flatnonzero(empty)]
    # A line between the environments and the last row, that of all together.
    layers.append(Limit(len(names) - 1.5, width=0.5))
    rows = [fill(x, _BROAD, max_lines=3, placeholder="…") for x in names]
    axis = frequency(w.family.frequency, (low, high))
    axis = DrawnAxis("bandwidth", axis.unit, axis.ends, axis.dimension)
    return Panel(layers, axis, DrawnAxis(names=rows), height=0.6 + 0.36 * len(names))


@dataclass(frozen=True)
class _Said(Layer):
    """Words at the left of a row."""

    text: str
    row: int

    def draw(self, on: On) -> list[Artist]:
        return [
            on.ax.text(
                0.01,
                self.row,
                self.text,
                transform=on.ax.get_yaxis_transform(),
                fontsize=small(on.ax),
                va="center",
            )
        ]


FAMILY = Drawings[FamilyEvaluation](
    {"real": worst, "imag": partial(worst, which=1), "regions": regions},
    {"worst-case": worst_case, "regions": lambda w, style: sheet(regions(w), style=style)},
)


def one_of(many: FamilyAnswers) -> Panel:
    """Axes show one answer: NothingToDrawError names the ways out."""
    raise NothingToDrawError(
        f"ax: several environments are a sheet: use figure(), or plot one of "
        f"{', '.join(many.answers)}"
    )


def each(many: FamilyAnswers, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """Return a sheet of what each answer draws first, one below the other, under the environments'
    names."""
    charts = [
        (name, next(iter(drawings_of(x).kinds.values()))(x)) for name, x in many.answers.items()
    ]
    return sheet(*(replace(chart, title=name) for name, chart in charts), joined=False, style=style)


EACH = Drawings[FamilyAnswers]({"each": one_of}, {"each": each})
