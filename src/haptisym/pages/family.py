"""The page of several environments: one row each, and the worst case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import RealNumber
from haptisym.model.jnd import Part
from haptisym.model.scene import caveats as cautions
from haptisym.pages.evaluation import family_regions
from haptisym.pages.words import both, caveats, certainty, limits, page_about, short, spans
from haptisym.verbs.family.entry import FamilyBinding, FamilyEvaluation
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Facts,
    Figure,
    Notes,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import named


def page(w: FamilyEvaluation) -> Document:
    """The whole page."""
    family = w.family
    told = Facts(tuple(_asked(w))), _each(w), _worst(w), *family_regions(w)
    blocks = *told, *caveats(cautions(family.first)), Paragraph(_certain(w))
    return page_about(family, blocks, "Evaluation with several environments")


def _asked(w: FamilyEvaluation) -> Iterator[tuple[str, Phrase]]:
    low, high = (both(w.chart.points[i].omega) for i in (0, -1))
    yield "effects", ", ".join(effect.name for effect in w.family.first.effects) or "none"
    yield "band", (low, " to ", high)
    yield "threshold", limits(w.family.threshold)


def _each(w: FamilyEvaluation) -> Block:
    criteria = noticed(w.family.threshold)
    columns = (
        Column("environment"), *(Column((named(x.symbol), " > c from"), number=True) for x in criteria),
        Column("bandwidth", number=True), Column("felt as"),
    )  # fmt: skip
    rows = ((name, *(_first(e, x) for x in criteria), _bandwidth(e), _felt(e)) for name, e in w.answers.items())
    caption = "Each environment: where each part is first noticed, and as what (rad/s), proven."
    return Section("Each environment (rad/s)", (Table(columns, tuple(rows), caption),))


def _first(e: Evaluation, criterion: Criterion) -> Phrase:
    """The lowest frequency beyond which a ratio exceeds its threshold."""
    exceeded = e.chart.where(lambda signs: signs[criterion] > 0)
    return short(exceeded[0].low.omega) if exceeded else "never"


def _bandwidth(e: Evaluation) -> Phrase:
    if e.bandwidth is None:
        return "none"
    return "whole band" if e.bandwidth is e.chart.points[-1].omega else short(e.bandwidth)


def _felt(e: Evaluation) -> str:
    """How each part is felt where it is first noticed."""
    first = {x.part: x.words for x in reversed(e.felt)}
    return "; ".join(first[part] for part in Part if part in first) or "-"


def _worst(w: FamilyEvaluation) -> Block:
    said = Notes((_transparency(w), *map(_bound, _grouped(w.binding))))
    shown = "The largest ratio of all environments, with the thresholds; grey: the band on which all are transparent."
    figure = Figure("worst-case", shown, w.figure)
    return Section("Worst case: transparent with every one of them", (said, figure))


def _transparency(w: FamilyEvaluation) -> Phrase:
    if not w.transparent:
        return "Nowhere on the band."
    if w.bandwidth is None:
        return "Only ", spans(w.transparent), "."
    if w.bandwidth is w.chart.points[-1].omega:
        return "On the whole band."
    rest: Phrase = (" All of it: ", spans(w.transparent), ".") if len(w.transparent) > 1 else ""
    return "Up to ", both(w.bandwidth), ", the common bandwidth.", rest


def _grouped(binding: Iterable[FamilyBinding]) -> list[tuple[RealNumber, list[FamilyBinding]]]:
    found: dict[RealNumber, list[FamilyBinding]] = {}
    for x in binding:
        found.setdefault(x.omega, []).append(x)
    return list(found.items())


def _bound(place: tuple[RealNumber, list[FamilyBinding]]) -> Phrase:
    omega, rows = place
    who = listed((f"{x.environment} ({x.criterion.name} part, ", named(x.criterion.symbol), ")") for x in rows)
    return "At ", short(omega), " rad/s ", who, f" {'binds' if len(rows) == 1 else 'bind'}."


def _certain(w: FamilyEvaluation) -> Phrase:
    if not w.certified:
        where = " at the precision limit near some frequency: evaluate each environment alone to see where."
        return Strong("UNDECIDED"), where
    return certainty(
        w.family,
        "Certain: every crossing of every environment on the band is known, none is missed and none invented; which of "
        "them comes first is proven, and equal ones are found equal.",
    )
