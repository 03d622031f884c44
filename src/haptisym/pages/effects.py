"""The page of which effects matter."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.model.jnd import Part
from haptisym.pages.words import H_ENV, OMEGA, RATIOS, bounds, certainty, compared, page_about, rounded, rounded_up
from haptisym.verbs.effects.relevance import CrossingEnclosure, Relevance
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Figure,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Table,
    listed,
)


def page(r: Relevance) -> Document:
    """What matters, by how much each changes the ratios, where, and what is certain."""
    blocks = [Paragraph(_verdict(r)), *_effects(r), *_dominance(r), _crossings(r), Paragraph(_certain(r))]
    return page_about(r.scene, blocks, "Which effects matter")


def _verdict(r: Relevance) -> Phrase:
    kept, dropped = ([e.name for e in effects] for effects in (r.pruned.effects, r.dropped))
    of = f"{len(kept)} of {len(r.scene.effects)} effects matter: ", listed(kept) if kept else "none", "."
    if not dropped:
        return of
    full, few = r.operations
    return (
        of, f" Leaving out all{' others' if kept else ' of them'} together changes ", bounds(r.bound), " anywhere on the band ",
        f"(tolerance {float(r.tolerance):g}). ",
        f"The distortion then takes {few} operations, written in steps, where it took {full}.",
    )  # fmt: skip


def _effects(r: Relevance) -> Iterator[Block]:
    if not r.effects:
        yield Paragraph("The scene has no effects.")
        return
    ranked = sorted(r.effects, key=lambda x: -max(change.most for change in x.change.values()))
    rows = [
        (x.effect.name, x.effect.model, *(_most(x.change[part].most) for part in Part), "kept" if x.kept else "")
        for x in ranked
    ]
    columns = Column("effect"), Column("model"), *(Column(RATIOS[part], number=True) for part in Part), Column("")
    caption = "Largest change of each ratio on the band by leaving out that effect alone"
    told: list[Block] = [Table(columns, tuple(rows), "Upper bounds, proven.")]
    if any(not change.is_finite for x in r.effects for change in x.change.values()):
        zero = compared(H_ENV, "=")
        told.append(
            Notes((("Unbounded: near a frequency where ", zero, " or a dynamics is infinite, no bound exists."),))
        )
    shown = (
        "Change of both ratios by leaving out each effect alone; in the strip above, the one that changes them most."
    )
    yield Section(caption, (*told, Figure("influences", shown, r.figure, wide=True)))


def _most(change: float) -> Phrase:
    return Number(rounded_up(change), change)


def _dominance(r: Relevance) -> Iterator[Block]:
    if len(r.effects) < 2 or not r.dominance:
        return
    rows = [(_span(float(x.low), float(x.high), 4), x.effect.name) for x in r.dominance]
    table = Table((Column("band (rad/s)"), Column("effect")), tuple(rows), "The effect that changes the ratios most.")
    yield Section("Which one changes the ratios most", (table,))


def _crossings(r: Relevance) -> Block:
    if not r.crossings:
        return Paragraph("The full scene has no crossing on the band.")
    rows = [
        (x.criterion.name, _interval(x), "at least one" if x.certain else "none, one or several") for x in r.crossings
    ]
    columns = Column("part"), Column((OMEGA, " (rad/s)")), Column("crossings")
    table = Table(
        columns, tuple(rows), "Where crossings of the full scene are; outside of these intervals it has none."
    )
    return Section("Where the full scene's crossings are", (table,))


def _interval(x: CrossingEnclosure) -> Phrase:
    low, high = x.bounds
    return rounded(low, 6) if high - low < 1e-6 * high else _span(low, high, 6)


def _span(low: float, high: float, digits: int) -> Phrase:
    return rounded(low, digits), " to ", rounded(high, digits)


def _certain(r: Relevance) -> Phrase:
    smallest = (
        f"No smaller set of effects stays within the tolerance, {float(r.tolerance):g}."
        if r.smallest
        else "This is the smallest set found; that no smaller one does is not proven."
    )
    return certainty(
        r.scene,
        "Certain: bounds are proven on the whole band by ball arithmetic, for all left-out effects together; outside the "
        f"intervals above the full scene has no crossing. {smallest}",
    )
