"""The page of several environments: one row each, and the worst case."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part
from haptisym.model.scene import caveats as cautions
from haptisym.pages.evaluation import family_regions
from haptisym.pages.words import both, caveats, cell, limits, page_about, proof, spans, undecided
from haptisym.verbs.family.entry import FamilyEvaluation
from haptisym.writing.document import (
    FREQUENCY,
    FREQUENCY_UNIT,
    Block,
    Column,
    Document,
    Figure,
    Notes,
    Phrase,
    Section,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import named


def page(w: FamilyEvaluation) -> Document:
    """The whole page."""
    blocks = _each(w), *_worst(w), *family_regions(w), *caveats(cautions(w.family.first))
    further = ("haptisym evaluate SCENE --environment NAME",)
    return page_about(w.family, _answer(w), blocks, _proven(w), "Evaluation with several environments", None, further)


def _answer(w: FamilyEvaluation) -> Iterator[tuple[Phrase, Phrase]]:
    yield "Bandwidth", _bandwidth_of_all(w)
    felt = {name: first for name, e in w.answers.items() if (first := _first_felt(e))}
    words: dict[str, list[str]] = {}
    for name, first in felt.items():
        words.setdefault(first, []).append(name)
    yield (
        "Felt as",
        listed(f"{first} ({', '.join(names)})" for first, names in words.items()) or "nothing noticed with any",
    )
    unstable = [name for name, e in w.answers.items() if e.stable is False]
    undecided_ = [name for name, e in w.answers.items() if e.stable is None]
    stable: Phrase = (
        (Strong("unstable"), f" with {', '.join(unstable)}") if unstable else "stable with each environment"
    )
    if undecided_ and not unstable:
        stable = Strong("undecided"), f" with {', '.join(undecided_)}"
    yield "Stability", (stable, " under prescribed motion; ", _passive(w))


def _passive(w: FamilyEvaluation) -> str:
    found = {name: None if e.passivity is None else e.passivity.holds for name, e in w.answers.items()}
    if all(found.values()):
        return "passive with each"
    kinds = (("not passive", False), ("passivity undecided", None))
    return "; ".join(
        f"{words} with {', '.join(names)}"
        for words, kind in kinds
        if (names := [n for n, x in found.items() if x is kind])
    )


def _first_felt(e: Evaluation) -> str:
    """How the change that is noticed first is felt."""
    return min(e.felt, key=lambda x: float(x.band.low.omega)).words if e.felt else ""


def _bandwidth_of_all(w: FamilyEvaluation) -> Phrase:
    if w.bandwidth is not None:
        by = listed(f"{x.environment} ({_part(x.criterion)})" for x in w.binding if x.omega is w.bandwidth)
        width: Phrase = both(w.bandwidth)
        if w.bandwidth is w.chart.points[-1].omega:
            return "the whole band with each environment, up to ", width
        return Strong(width), " common to all environments", (", limited by ", by) if by else ""
    onward: Phrase = ("; all are transparent only ", spans(w.transparent)) if w.transparent else ""
    first = [name for name, e in w.answers.items() if e.bandwidth is None]
    low: Phrase = (": noticed from the low end of the band with ", ", ".join(first)) if first else ""
    return Strong("none"), " common to all environments", low, onward


def _part(x: Criterion) -> str:
    return f"{x.name} part" if x.part else x.name


def _each(w: FamilyEvaluation) -> Block:
    criteria = noticed(w.family.threshold)
    columns = (
        Column("environment"), *(Column((named(x.symbol), " > c from"), number=True) for x in criteria),
        Column("bandwidth", number=True), Column("felt as"),
    )  # fmt: skip
    rows = ((name, *(_first(e, x) for x in criteria), _bandwidth(e), _felt(e)) for name, e in w.answers.items())
    caption = ("Each environment: where each part is first noticed, and as what, ", FREQUENCY_UNIT, ", proven.")
    low, high = (cell(w.chart.points[i].omega) for i in (0, -1))
    title = (
        "First crossings on ", low, " to ", high, "\xa0", FREQUENCY_UNIT, ", in ", FREQUENCY_UNIT, ", JND ",
        limits(w.family.threshold),
    )  # fmt: skip
    return Section(title, (Table(columns, tuple(rows), caption),))


def _first(e: Evaluation, criterion: Criterion) -> Phrase:
    """The lowest frequency beyond which a ratio exceeds its threshold."""
    exceeded = e.chart.where(lambda signs: signs[criterion] > 0)
    return cell(exceeded[0].low.omega) if exceeded else "never"


def _bandwidth(e: Evaluation) -> Phrase:
    if e.bandwidth is None:
        return "none"
    return "whole band" if e.bandwidth is e.chart.points[-1].omega else cell(e.bandwidth)


def _felt(e: Evaluation) -> str:
    """How each part is felt where it is first noticed."""
    first = {x.part: x.words for x in reversed(e.felt)}
    return "; ".join(first[part] for part in Part if part in first) or "-"


def _worst(w: FamilyEvaluation) -> Iterator[Block]:
    """What limits the bands on which all are transparent, where that is more than the bandwidth."""
    further = [x for x in w.binding if x.omega is not w.bandwidth]
    if len(w.transparent) > 1:
        yield Notes((("All environments are transparent ", spans(w.transparent), "."),))
    if further:
        rows = tuple((cell(x.omega), x.environment, x.criterion.name) for x in further)
        columns = Column(FREQUENCY, number=True, hertz=True), Column("environment"), Column("part")
        yield Section("Further limits", (Table(columns, rows, "What limits the other transparent intervals."),))
    shown = "The largest ratio of all environments, with the thresholds; grey: the band on which all are transparent."
    yield Figure("worst-case", shown, w.figure)


def _proven(w: FamilyEvaluation) -> Iterator[Phrase]:
    if not w.certified:
        yield undecided("a crossing of some environment, at the precision limit: evaluate each alone")
    else:
        yield proof(w.family, "all crossings of every environment, their order, and all digits printed")
