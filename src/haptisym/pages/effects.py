"""The page of which effects matter: by how much each changes the ratios, where, and what is
proven."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.kernel.objects import counted
from haptisym.kernel.reals import Way
from haptisym.model.jnd import Part
from haptisym.pages import words as w
from haptisym.verbs.effects.relevance import CrossingEnclosure, Relevance
from haptisym.writing.document import (
    Block,
    Document,
    Figure,
    Notes,
    Paragraph,
    Phrase,
    Section,
    listed,
)


def page(r: Relevance) -> Document:
    """Return the page: which effects matter, by how much each changes the ratios, where, what is
    proven."""
    blocks = [*_effects(r), *_dominance(r), _crossings(r)]
    return w.page_about(r.scene, _answer(r), blocks, _proven(r), "Which effects matter")


def _answer(r: Relevance) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield which effects matter, which are left out, and what that changes and saves."""
    kept, dropped = ([e.name for e in effects] for effects in (r.pruned.effects, r.dropped))
    yield (
        "Matter",
        (
            listed(kept) if kept else "none",
            f" ({len(kept)} of {counted(len(r.scene.effects), 'effect')})",
        ),
    )
    if dropped:
        full, few = r.operations
        changes = w.phrased(
            "changes {} on the band (tolerance {})", w.bounds(r.bound), w.near(float(r.tolerance))
        )
        yield "Left out", (listed(dropped), ": ", changes)
        yield "Operations", f"{few} for the distortion in intermediate steps, instead of {full}"


def _effects(r: Relevance) -> Iterator[Block]:
    """Yield a row of proven bounds for each effect, the largest first."""
    if not r.effects:
        yield Paragraph("The scene has no effects.")
        return
    # The largest of its bounds decides where an effect stands.
    ranked = sorted(r.effects, key=lambda x: -max(change.most for change in x.change.values()))
    changes = (
        w.number(w.RATIOS[part], lambda x, part=part: w.at_most(x.change[part].most))  # type: ignore[misc]
        for part in Part
    )
    names = w.Field("effect", lambda x: x.effect.name), w.Field("model", lambda x: x.effect.model)
    kept = w.Field("", lambda x: "kept" if x.kept and r.dropped else "")
    blocks: list[Block] = [w.table(ranked, "Upper bounds, proven.", *names, *changes, kept)]
    if any(not change.is_finite for x in r.effects for change in x.change.values()):
        why = "Unbounded: near a frequency where {} or a dynamics is infinite, no bound exists."
        blocks.append(Notes((w.phrased(why, w.compared(w.H_ENV, "=")),)))
    shown = (
        "Change of both ratios without each effect; in the strip above, the effect that changes "
        "them most."
    )
    figure = Figure("influences", shown, r.figure, wide=True)
    yield Section("Largest change of each ratio on the band without that effect", (*blocks, figure))


def _dominance(r: Relevance) -> Iterator[Block]:
    """Yield which effect changes the ratios most, along the band."""
    if len(r.effects) >= 2 and r.dominance:
        where = w.Field(w.IN_UNIT, lambda x: (w.cell(x.low), " to ", w.cell(x.high)))
        caption = "The effect that changes the ratios most."
        shown = w.table(r.dominance, caption, where, w.Field("effect", lambda x: x.effect.name))
        yield Section("Which effect changes the ratios most", (shown,))


def _crossings(r: Relevance) -> Block:
    """Return enclosures of the crossings of the full scene."""
    scene = "full scene" if r.dropped else "scene"
    if not r.crossings:
        return Paragraph(f"The {scene} has no crossing on the band.")
    count = w.Field("crossings", lambda x: "at least one" if x.certain else "none, one or several")
    shown = w.table(
        r.crossings,
        f"Where crossings of the {scene} are; outside of these intervals it has none.",
        w.Field("part", lambda x: x.criterion.name),
        w.Field(w.IN_UNIT, _interval),
        *[count] * bool(r.dropped),
    )
    return Section(f"Where the {scene}'s crossings are", (shown,))


def _interval(x: CrossingEnclosure) -> Phrase:
    """Return an enclosure, rounded outwards, or one frequency."""
    low, high = x.bounds
    return (
        w.cell(low)
        # An enclosure that is narrower than what is printed is one frequency.
        if high - low < 1e-6 * high
        else (w.cell(low, Way.DOWN), " to ", w.cell(high, Way.UP))
    )


def _proven(r: Relevance) -> Iterator[Phrase]:
    """Yield what is proven of the bounds, and whether a smaller set of effects exists."""
    what = "bounds on the whole band"
    if r.dropped:
        what += ", for all effects left out together; no crossing of the full scene elsewhere"
    yield w.proof(
        r.scene, what + "; no smaller set of effects stays within the tolerance" * r.smallest
    )
    if not r.smallest:
        yield "Not proven: that no smaller set of effects exists."
