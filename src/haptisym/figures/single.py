"""What answers draw on one axes where their figures have several: the worst case, one frequency, one task; and lists."""

from __future__ import annotations

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures.cost import draw_cost
from haptisym.figures.family import draw_envelope, envelope_handles, sampled_family
from haptisym.figures.hardcosts import draw_table
from haptisym.figures.ratios import draw_ratios
from haptisym.figures.scales import band_scale, scale_of
from haptisym.figures.sensitivity import draw_elasticities, panels
from haptisym.figures.style import INK, SMALL, TEXT, Look, dress, legend, name_frequency
from haptisym.figures.sweep import draw_curves, draw_map
from haptisym.judge.peaks import Peaks
from haptisym.kernel.errors import NothingToDrawError
from haptisym.verbs.cost.entry import Cost
from haptisym.verbs.cost.hardcosts import HardCosts
from haptisym.verbs.derive.derivation import Derivation
from haptisym.verbs.evaluate.entry import evaluate
from haptisym.verbs.family.entry import FamilyEvaluation
from haptisym.verbs.jnd.published import PublishedThresholds
from haptisym.verbs.sensitivity.entry import Sensitivities
from haptisym.verbs.sweep.swept import Swept


def draw_worst(ax: Axes, found: FamilyEvaluation, which: int = 0) -> list[Line2D]:
    """One ratio of each environment, and the largest of them: the ``which``-th criterion. Returns a line for each."""
    scale, (omega, values) = band_scale(found.family.first.band), sampled_family(found)
    lines = draw_envelope(ax, found, which, omega, values, scale)
    name_frequency(ax, scale)
    legend(ax, envelope_handles(found))
    return lines


def draw_first(ax: Axes, found: Sensitivities, *, color: str | None = None, label: str = "") -> list[Patch]:
    """The elasticities of the bandwidth, or of the first frequency where there is none. Returns the bars."""
    listed = [("bandwidth", found.bandwidth)] if found.bandwidth else panels(found)
    if not listed:
        raise NothingToDrawError("there is no crossing nor changeover on the band that parameters could move")
    title, first = listed[0]
    assert first is not None
    scale = band_scale(found.evaluation.scene.band)
    return list(draw_elasticities(ax, first, title, scale, color=color, label=label))


def draw_task(ax: Axes, found: Cost, task: str = "") -> None:
    """Right digits over time for the methods of one task: the first, if none is named."""
    names = list(dict.fromkeys(row.task for row in found.rows))
    draw_cost(ax, found.task(task or names[0]))


def draw_cases(ax: Axes, found: HardCosts) -> None:
    """How many of the hard cases each method answers, for the first task."""
    draw_table(ax, [row for row in found.rows if row.task == found.rows[0].task])


def draw_formulas(ax: Axes, found: Derivation, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """The ratios that the formulas give with the scene's values. Returns the lines."""
    return draw_ratios(ax, evaluate(found.scene), color=color, label=label)


def draw_peaks(ax: Axes, found: Peaks, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """The ratios over the band, and a triangle at each of their local maxima. Returns the lines of the ratios."""
    look, scale = Look.on(ax, "peaks", color, label), scale_of(ax, found.scene.band)
    lines = draw_ratios(ax, evaluate(found.scene), color=color, label=label)
    at = [(scale.of(float(x.omega)), float(x.ratio)) for x in found]
    if at:
        x, y = zip(*at, strict=True)
        legend(ax, ax.plot(x, y, "v", color=look.color, markersize=4, zorder=5, label=f"peaks{look.suffix}"), lines=1)
    return lines


def draw_published(ax: Axes, found: PublishedThresholds) -> list[Line2D]:
    """A bar for each threshold that a scene can take, from its least to its largest fraction. Returns the bars."""
    rows = [x for x in found if not x.apart]
    made = [
        ax.plot([100 * float(x.low), 100 * float(x.high)], [i, i], "o-", color=INK, markersize=3.5, linewidth=1.1)[0]
        for i, x in enumerate(rows)
    ]
    dress(ax)
    ax.set_yticks(range(len(rows)), [x.name for x in rows], fontsize=SMALL)
    ax.invert_yaxis()
    ax.set_xlabel("just-noticeable difference (%)", fontsize=TEXT)
    return made


def draw_swept(ax: Axes, found: Swept) -> list[Artist]:
    """The chart of a sweep over one parameter, or over two. Returns what it is made of."""
    one = len(found.data.bandwidth.dims) == 1
    return list(draw_curves(ax, found.data)) if one else draw_map(ax, found.data)
