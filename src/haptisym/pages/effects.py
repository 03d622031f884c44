"""The page of which effects matter."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.kernel.reals import Way
from haptisym.model.jnd import Part
from haptisym.pages.words import H_ENV, RATIOS, at_most, bounds, cell, compared, near, page_about, proof
from haptisym.verbs.effects.relevance import CrossingEnclosure, Relevance
from haptisym.writing.document import (
    FREQUENCY,
    FREQUENCY_UNIT,
    Block,
    Column,
    Document,
    Figure,
    Notes,
    Paragraph,
    Phrase,
    Section,
    Table,
    listed,
)


def page(r: Relevance) -> Document:
    """What matters, by how much each changes the ratios, where, and what is certain."""
    blocks = [*_effects(r), *_dominance(r), _crossings(r)]
    return page_about(r.scene, _answer(r), blocks, _proven(r), "Which effects matter")


def _answer(r: Relevance) -> Iterator[tuple[Phrase, Phrase]]:
    kept, dropped = ([e.name for e in effects] for effects in (r.pruned.effects, r.dropped))
    yield "Matter", (listed(kept) if kept else "none", f" ({len(kept)} of {len(r.scene.effects)} effects)")
    if dropped:
        full, few = r.operations
        changes = "changes ", bounds(r.bound), " on the band (tolerance ", near(float(r.tolerance)), ")"
        yield "Left out", (listed(dropped), ": ", changes)
        yield "Operations", f"{few} in the distortion, written in steps, in place of {full}"


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
    caption = "Largest change of each ratio on the band without that effect"
    told: list[Block] = [Table(columns, tuple(rows), "Upper bounds, proven.")]
    if any(not change.is_finite for x in r.effects for change in x.change.values()):
        zero = compared(H_ENV, "=")
        told.append(
            Notes((("Unbounded: near a frequency where ", zero, " or a dynamics is infinite, no bound exists."),))
        )
    shown = "Change of both ratios without each effect; in the strip above, the effect that changes them most."
    yield Section(caption, (*told, Figure("influences", shown, r.figure, wide=True)))


def _most(change: float) -> Phrase:
    return at_most(change)


def _dominance(r: Relevance) -> Iterator[Block]:
    if len(r.effects) < 2 or not r.dominance:
        return
    rows = [((cell(x.low), " to ", cell(x.high)), x.effect.name) for x in r.dominance]
    columns = Column((FREQUENCY, " (", FREQUENCY_UNIT, ")")), Column("effect")
    yield Section(
        "Which effect changes the ratios most",
        (Table(columns, tuple(rows), "The effect that changes the ratios most."),),
    )


def _crossings(r: Relevance) -> Block:
    if not r.crossings:
        return Paragraph("The full scene has no crossing on the band.")
    rows = [
        (x.criterion.name, _interval(x), "at least one" if x.certain else "none, one or several") for x in r.crossings
    ]
    columns = Column("part"), Column((FREQUENCY, " (", FREQUENCY_UNIT, ")")), Column("crossings")
    table = Table(
        columns, tuple(rows), "Where crossings of the full scene are; outside of these intervals it has none."
    )
    return Section("Where the full scene's crossings are", (table,))


def _interval(x: CrossingEnclosure) -> Phrase:
    low, high = x.bounds
    return cell(low) if high - low < 1e-6 * high else (cell(low, Way.DOWN), " to ", cell(high, Way.UP))


def _proven(r: Relevance) -> Iterator[Phrase]:
    yield proof(
        r.scene, "bounds on the whole band, for all effects left out together; no crossing of the full scene elsewhere"
    )
    if r.smallest:
        yield "Proven: no smaller set of effects stays within the tolerance."
    else:
        yield "This is the smallest set found; that no smaller one exists is not proven."
