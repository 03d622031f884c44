"""What is told between the lines of a measured evaluation, by the bound on the slope that was stated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from haptisym.kernel.shown import counted
from haptisym.model.jnd import Part
from haptisym.model.quantities import unit_text
from haptisym.model.slope import Slope
from haptisym.pages.measuredlines import MOST_ROWS, shape, verdict
from haptisym.pages.words import OMEGA, PART_NAMES, RATIOS, rounded
from haptisym.verbs.measured.between import Between, Stretches
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.judging import CODES
from haptisym.writing.document import Block, Column, Notes, Paragraph, Phrase, Section, Strong, Table

_LONGEST = 12
_OF = {"perceived": "", "environment": " of the environment"}


def slope_words(x: Slope) -> str:
    """``|dH/dω| at most 40 N·s/m``."""
    bound = f"{x.bound:.6g} {unit_text(x.unit)}"
    return f"|dH/dω| at most {bound}{' times |H|' if x.relative else ''}"


def stated(e: MeasuredEvaluation) -> str:
    """All bounds that were stated."""
    return "; ".join(f"{slope_words(x)}{_OF[key]}" for key, x in e.scene.slopes.items())


def between_section(e: MeasuredEvaluation) -> Iterator[Section]:
    """A section, where a bound was stated."""
    if e.between is not None:
        yield Section("Between the lines, by the bound on the slope", tuple(_blocks(e, e.between)), "between")


def _blocks(e: MeasuredEvaluation, found: Between) -> Iterator[Block]:
    yield Paragraph(
        f"With {stated(e)} the disc of each line holds on beside it, larger by as much as the bound allows; half-way between "
        f"lines its radius is at most {100 * found.grown:.4g}\xa0% of the environment's magnitude."
    )
    if not len(found.told[Part.REAL]):
        yield Paragraph("There are no two lines with discs that have an end: nothing is told.")
        return
    for part, own in found.told.items():
        yield Paragraph(_summary(e, part, own))
    if found.contradicted:
        yield Notes((_contradicted(found),))
    rows = list(_chosen(found))
    yield Table(
        (Column("part"), Column((OMEGA, " (rad/s)")), Column("told")),
        tuple(_row(e, part, found.told[part], i) for part, i in rows),
        "Stretches between the lines: exceeds or below where swept discs tell, else unresolved.",
    )
    count = sum(map(len, found.told.values()))
    if len(rows) < count:
        yield Notes(
            (f"The {_LONGEST} longest of each part that are told, of {count} stretches in all; JSON has every one.",)
        )


def _chosen(found: Between) -> Iterator[tuple[Part | None, int]]:
    """All stretches; of many the longest of each part that are told, in order."""
    few = sum(map(len, found.told.values())) <= MOST_ROWS
    for part, own in found.told.items():
        length = np.where(own.code == 0, 0, own.high - own.low)
        longest = np.sort(np.argsort(-length, kind="stable")[:_LONGEST])
        yield from ((part, int(i)) for i in (range(len(own)) if few else longest) if few or own.code[i])


def _summary(e: MeasuredEvaluation, part: Part | None, own: Stretches) -> Phrase:
    lengths = [f"{own.length(code):.5g}" for code in (1, -1, 0)]
    whole = f"{float(own.high[-1] - own.low[0]):.5g}"
    what: Phrase = (RATIOS[part], f" ({PART_NAMES[part]} part) exceeds its threshold") if part else (
        f"The change lies outside the {shape(e)}"
    )  # fmt: skip
    below = "is below it" if part else "inside it"
    return what, f" on {lengths[0]} of {whole} rad/s, {below} on {lengths[1]}, and is unresolved on {lengths[2]} rad/s."


def _contradicted(found: Between) -> Phrase:
    low, high = found.contradicted[0]
    return (
        Strong("CONTRADICTED"), f": in {counted(len(found.contradicted), 'gap')} between lines, the first from ", rounded(low),
        " to ", rounded(high), " rad/s, lines differ by more than their discs and the bound allow. Nothing is told there: ",
        "the bound is too small, or a disc misses the truth.",
    )  # fmt: skip


def _row(e: MeasuredEvaluation, part: Part | None, own: Stretches, i: int) -> tuple[Phrase, ...]:
    ends: Phrase = (rounded(float(own.low[i])), " to ", rounded(float(own.high[i])))
    return PART_NAMES[part] if part else shape(e), ends, verdict(CODES[int(own.code[i])].value)
