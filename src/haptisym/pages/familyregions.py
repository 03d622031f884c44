"""Other JND models on the page of several environments: what each says of every environment, and of all together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from haptisym.kernel.reals import RealNumber
from haptisym.pages.regions import spread
from haptisym.pages.words import exactly, limits, short
from haptisym.verbs.family.entry import FamilyEvaluation
from haptisym.verbs.family.regions import FamilyCompared
from haptisym.writing.document import Block, Column, Figure, Paragraph, Phrase, Section, Table, listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

_SHOWN = "Bandwidth of each environment, and of all together, by JND region; none: no transparent band starts at the low end."


def family_regions(w: FamilyEvaluation) -> Iterator[Block]:
    """How far the models are apart in the worst case, a row for each, and a row for each environment."""
    if not w.regions:
        return
    columns = (
        Column("region"),
        Column("what it is", full=True),
        Column("bandwidth (rad/s)", number=True),
        Column("who binds"),
    )
    worst = Table(columns, tuple(_row(w, x) for x in w.regions), "Common bandwidth by region, and who binds, proven.")
    by_name = Column("environment"), *(Column(x.name, number=True) for x in w.regions)
    rows = [(name, *(_short(w, x.answers[name].bandwidth) for x in w.regions)) for name in w.family]
    rows.append(("all", *(_short(w, x.bandwidth) for x in w.regions)))
    each = Table(by_name, tuple(rows), "Bandwidth of each environment by region (rad/s), proven.")
    blocks = Paragraph(spread(w.regions, "common bandwidth")), worst, each, _figure(w)
    yield Section("Does it survive another JND model?", blocks, "regions")


def _figure(w: FamilyEvaluation) -> Figure:
    def draw() -> Canvas:
        from haptisym.figures.familyregions import (
            family_regions_figure,
        )  # matplotlib is loaded where something is drawn

        return family_regions_figure(w)

    return Figure("regions", _SHOWN, draw)


def _row(w: FamilyEvaluation, x: FamilyCompared) -> tuple[Phrase, ...]:
    who = listed(f"{y.environment} ({y.criterion.name})" for y in x.first)
    width: Phrase = (
        "none" if x.bandwidth is None else "whole band" if _is_whole(w, x.bandwidth) else exactly(x.bandwidth, w.digits)
    )
    return x.name, limits(x.threshold), width, who


def _short(w: FamilyEvaluation, x: RealNumber | None) -> Phrase:
    return "none" if x is None else "whole band" if _is_whole(w, x) else short(x)


def _is_whole(w: FamilyEvaluation, x: RealNumber) -> bool:
    return float(x) == float(w.chart.points[-1].omega)
