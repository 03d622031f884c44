"""The page of a measured evaluation.

Measured lines on a page: where they come from, and a row of a table for each, or for neighbours that are judged alike.

What is told between the lines of a measured evaluation, by the bound on the slope that was stated.

The page of a measured evaluation: what the discs tell at each line, what they do not, and what would resolve the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from math import tau
from typing import Any

import numpy as np

from haptisym.judge.percepts import NOT_NAMED, felt_words
from haptisym.kernel.objects import counted
from haptisym.kernel.rings import s
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement, Slope, Welch, coherence_for
from haptisym.model.quantities import unit_text
from haptisym.pages.late import drawing
from haptisym.pages.words import OMEGA, PART_NAMES, RATIOS, limits, page_about, rounded, stiffness_unit
from haptisym.verbs.measured.entry import Between, MeasuredEvaluation, Share, Stretches
from haptisym.verbs.measured.judging import CODES, certainty, limits_of
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Facts,
    Figure,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
)
from haptisym.writing.equations import equation
from haptisym.writing.mathml import readable

_UNLIKELY = 0.01
"""A chance below which a display is called not linear."""


def measured_words(m: Measurement) -> Phrase:
    """``bench.csv: 60 lines from 1 to 15 rad/s``, and what its discs come from."""
    low, high = float(m.omega[0]), float(m.omega[-1])
    where: Phrase = ("at ", rounded(low)) if len(m) == 1 else ("from ", rounded(low), " to ", rounded(high))
    if m.welch is not None:
        return (m.name, ": ", counted(len(m), "line"), " ", where, " rad/s; ", m.welch.words)
    lines: Phrase = (m.name, ": ", counted(len(m), "line"), " ", where, " rad/s")
    if m.coherence is None:
        return lines, "; ", certainty(m)
    seen = f"{float(m.coherence.min()):.4g} to {float(m.coherence.max()):.4g}"
    return lines, f"; coherence {seen}, {m.averages:g} averages"


def linearity(w: Welch) -> Phrase | None:
    """How far the force follows the cube of what the response predicts; None where that was not asked."""
    if w.cube is None or w.cube_chance is None:
        return None
    told: Phrase = (
        "the force follows the cube of what the response predicts by ", Number(f"{w.cube:.3g}", w.cube), " standard errors; so ",
        "many or more have a chance of ", Number(f"{w.cube_chance:.3g}", w.cube_chance), " if the display is linear",
    )  # fmt: skip
    if w.cube_chance >= _UNLIKELY:
        return told
    as_if = "stays behind, as one that saturates" if w.cube < 0 else "grows beyond, as one that hardens or has play"
    return (
        Strong("NOT LINEAR"), f": it {as_if}: ", told, ". The response is that of a motion as large as this one; less motion ",
        "gives another",
    )  # fmt: skip


MOST_ROWS = 40
"""Of a table with a row for each line; where there are more, lines that are judged alike and follow each other share one."""


def shape(e: MeasuredEvaluation) -> str:
    """Of the region: ``ellipse``."""
    return str(e.scene.threshold.region.shape.value)


def _judgements(e: MeasuredEvaluation) -> list[tuple[str, Any]]:
    """The columns of verdicts: their headings and codes."""
    alone = " alone" if e.joint else ""
    found = [(f"{PART_NAMES[part]}{alone}", e.verdict[part]) for part in Part]
    return [(shape(e), e.joint.verdict), *found] if e.joint else found


def _groups(e: MeasuredEvaluation) -> Any:
    """A number for each line: the same for lines that are judged alike."""
    code = np.zeros(len(e), dtype=int)
    for _, own in _judgements(e):
        code = 3 * code + own
    return code


def table(e: MeasuredEvaluation) -> Block:
    """All lines."""
    judgements = _judgements(e)
    names = tuple(Column(name) for name, _ in judgements)
    caption = "Each measured line: exceeds or below where the whole disc does, unresolved where the disc does not tell."
    heading: Phrase = (OMEGA, " (rad/s)")
    if len(e) <= MOST_ROWS:
        numbers = (
            Column(heading, number=True),
            Column("Hz", number=True),
            *(Column(RATIOS[x], number=True) for x in Part),
        )
        columns = (*numbers, Column("radius", number=True), *names)
        rows: tuple[tuple[Phrase, ...], ...] = tuple(
            (rounded(x.omega), f"{x.omega / tau:.5g}", _ratio(x.ratio_real), _ratio(x.ratio_imag), _ratio(x.radius),
             *(verdict(CODES[int(own[i])].value) for _, own in judgements))
            for i, x in enumerate(e.rows)
        )  # fmt: skip
        return Table(columns, rows, caption)
    rows = tuple(
        (
            ends(e, first, last),
            str(last - first + 1),
            *(verdict(CODES[int(own[first])].value) for _, own in judgements),
        )
        for first, last in islice(runs(_groups(e)), MOST_ROWS)
    )
    return Table((Column(heading), Column("lines", number=True), *names), rows, caption)


def cut(e: MeasuredEvaluation) -> Iterator[Block]:
    """That the table does not hold everything."""
    groups = 1 + np.count_nonzero(np.diff(_groups(e)))
    if len(e) > MOST_ROWS and groups > MOST_ROWS:
        yield Notes((f"The first {MOST_ROWS} of {groups} groups of lines that are judged alike; JSON has every line.",))


def verdict(word: str) -> Phrase:
    """A verdict as a cell has it."""
    return Strong(word) if word == "exceeds" else word


def _ratio(x: float | None) -> Phrase:
    return "" if x is None else rounded(x, 4) if np.isfinite(x) else "unbounded"


def runs(codes: Any) -> Iterator[tuple[int, int]]:
    """First and last index of equal neighbours."""
    edges = np.flatnonzero(np.diff(codes)) + 1
    starts, stops = [0, *edges.tolist()], [*(edges - 1).tolist(), len(codes) - 1]
    yield from zip(starts, stops, strict=True)


def ends(e: MeasuredEvaluation, first: int, last: int) -> Phrase:
    """``2 to 3``, or one frequency."""
    low, high = (rounded(float(e.lines.omega[i])) for i in (first, last))
    return low if first == last else (low, " to ", high)


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


def page(e: MeasuredEvaluation) -> Document:
    """The whole page."""
    blocks: tuple[Block, ...] = (
        Facts(tuple(_about(e))),
        Section("Step 1. When does the hand begin to notice?", tuple(_step_1(e)), "step-1"),
        *between_section(e),
        Section("Step 2. How is it felt?", tuple(_step_2(e)), "step-2"),
        Paragraph(_certain(e)),
    )
    return page_about(e.scene, blocks, "Two-step evaluation of a measured display")


def _share(x: float, digits: int = 4) -> str:
    return f"{100 * x:.{digits}g}\xa0%"


def _about(e: MeasuredEvaluation) -> Iterator[tuple[str, Phrase]]:
    """Environment, measurement, discs, band and threshold."""
    own, felt = e.scene.environment, e.scene.perceived
    if isinstance(own, Measurement):
        yield "environment", measured_words(own)
    else:
        function = e.scene.frame.distortion().env
        form, is_rounded = readable(function, s)
        unit = f"  {stiffness_unit(e.scene.frame)}"
        yield "environment", (equation("H_env", form, relation="≈" if is_rounded else "="), unit)
    yield "perceived", measured_words(felt)
    if felt.welch and (told := linearity(felt.welch)):
        yield "linear", told
    if e.left_out:
        yield "left out", f"{counted(e.left_out, 'line')}, off the band or without a line of the environment"
    if e.scene.band is not None:
        low, high = map(float, e.scene.band)
        yield "band", (rounded(low), " to ", rounded(high), " rad/s")
    yield "threshold", limits(e.scene.threshold)
    if felt.coherence is not None and felt.averages is not None:
        c = min(float(x.min()) for x in limits_of(e.scene, e.lines.omega).values())
        least = float(coherence_for(c, felt.averages, felt.confidence))
        told = f"with {felt.averages:g} averages a disc of {_share(c)} of what is felt needs a coherence of at least "
        yield "discs", (_discs(e), "; ", told, rounded(least, 7))
    else:
        yield "discs", _discs(e)
    if e.scene.slopes:
        yield "slope", stated(e)


def _discs(e: MeasuredEvaluation) -> Phrase:
    radius = e.lines.radius
    if radius is None:
        unknown = ": neither coherence nor radius is given, and every line is judged as if it were exact"
        return Strong("UNKNOWN"), unknown
    ends = [float(x) for x in (radius.min(), radius.max())]
    seen = tuple("unbounded" if np.isinf(x) else _share(x) for x in ends)
    return f"{_share(e.scene.perceived.confidence)} confidence, radius {seen[0]} to {seen[1]} of ", _SIZE


_SIZE: Phrase = "the environment's magnitude"


# Step 1, when.


def _step_1(e: MeasuredEvaluation) -> Iterator[Block]:
    if e.joint is not None:
        outside = f"The change lies outside the {shape(e)}"
        yield Paragraph((*_counted(e, e.joint.verdict, outside, "inside it"), " A part by itself:"))
    for part in Part:
        exceeds = f" ({PART_NAMES[part]} part) exceeds its threshold"
        yield Paragraph((RATIOS[part], *_counted(e, e.verdict[part], exceeds, "below it")))
    yield table(e)
    yield from cut(e)
    yield _figure(e, "ratios", "Distortion ratios at the measured lines. Bars: how far the disc of each line reaches. Filled: "
                  "the whole disc exceeds the threshold or is below it; open: it does not tell.", wide=True)  # fmt: skip
    if e.joint is not None:
        shown = "The change of each line with its disc, in the plane of both parts, and the region that is not noticed."
        yield _figure(e, "plane", shown)
    if e.needed is not None:
        yield Notes(tuple(_resolving(e)))


def _counted(e: MeasuredEvaluation, codes: Any, exceeds: str, below: str) -> tuple[Phrase, ...]:
    """At how many lines discs exceed, are below or open, and where they first exceed."""
    count = {code: int((codes == code).sum()) for code in CODES}
    lines = counted(len(e), "line")
    said = (
        f"{exceeds} at {count[1] or 'none'} of {lines}, is {below} at {count[-1] or 'none'} and unresolved at "
        f"{count[0] or 'none'}"
    )
    if not count[1]:
        return said, "."
    first = int(np.argmax(codes == 1))
    which = "outside" if e.joint and codes is e.joint.verdict else "that exceeds"
    return said, f"; the first line {which} is at ", rounded(float(e.lines.omega[first])), " rad/s."


def _resolving(e: MeasuredEvaluation) -> Iterator[Phrase]:
    """What would resolve the open lines."""
    found, felt = e.needed, e.scene.perceived
    assert found is not None
    open_lines = counted(found.lines, "line")
    half, every = (_bound(x, _share) for x in (found.radius.half, found.radius.all))
    yield (
        f"Unresolved in a part or in both: {open_lines}. If the estimates stay where they are, half of them are resolved by ",
        f"discs of at most {half}, all of them by {every} of ", _SIZE, ".",
    )  # fmt: skip
    if found.coherence and found.averages:
        yield (
            f"With {felt.averages:g} averages that is a coherence of at least ", _both(found.coherence, lambda x: f"{x:.7g}"),
            "; with the coherence that was measured, ", _both(found.averages, lambda x: f"{x:.0f}"), " averages.",
        )  # fmt: skip


def _both(x: Share, words: Callable[[float], str]) -> Phrase:
    return _bound(x.half, words), " (half), ", _bound(x.all, words), " (all)"


def _bound(x: float | None, words: Callable[[float], str]) -> str:
    return "more than can be measured" if x is None else words(x)


# Step 2, how.


def _step_2(e: MeasuredEvaluation) -> Iterator[Block]:
    rows = tuple(islice(_felt(e), MOST_ROWS + 1))
    if rows:
        caption = "What is felt at the lines that exceed, where their discs tell it; how it is felt between lines is not told."
        columns = Column((OMEGA, " (rad/s)")), Column("lines", number=True), Column("part"), Column("felt as")
        yield Table(columns, rows[:MOST_ROWS], caption)
    if len(rows) > MOST_ROWS:
        yield Notes((f"The first {MOST_ROWS} groups of lines that are felt alike; JSON has every line.",))
    if not rows:
        yield Paragraph("Nothing is noticed for certain at any line, or not in which part: nothing is named.")
    yield _figure(e, "nyquist", "Environment and what is felt in the complex plane, a disc around each measured line.")


def _felt(e: MeasuredEvaluation) -> Iterator[tuple[Phrase, ...]]:
    """Neighbouring lines that are felt alike, as one row."""
    for part in (*Part, None) if e.joint else Part:
        named, noticed = e.named(part), e.noticed(part)
        label = np.where(named, e.kinds(part), np.where(noticed, -1, -2))
        for first, last in runs(label):
            if noticed[first]:
                words = _felt_words(e, part, first) if named[first] else NOT_NAMED
                yield ends(e, first, last), str(last - first + 1), part.value if part else "both", words


def _felt_words(e: MeasuredEvaluation, part: Part | None, line: int) -> str:
    if part is not None:
        return felt_words(*e.signs[part].label(part, line))
    far, near = e.order(line)
    return " and ".join(felt_words(*e.signs[x].label(x, line)) for x in (far, near))


def _figure(e: MeasuredEvaluation, name: str, caption: str, *, wide: bool = False) -> Figure:
    return drawing(name, caption, "measured:draw_measured_figure", e, name, wide=wide)


def _certain(e: MeasuredEvaluation) -> Phrase:
    start = (
        "Measured, not proven: this is said line by line, at the measured frequencies alone, and nothing is said between "
        "the lines."
    )
    if e.between is not None:
        start = (
            "Measured, not proven: this is said at the measured frequencies, and between them as far as the bound on the "
            "slope tells, which was stated and is not tested; nothing is said beyond the first line and the last."
        )
    if e.lines.radius is None:
        return start, " How certain the lines themselves are, nothing here tells."
    share = 1 - e.scene.perceived.confidence
    both = isinstance(e.scene.environment, Measurement) and e.scene.environment.discs is not None
    missed = min(1.0, share * (2 if both else 1)) * len(e)
    return (
        start, f" Each disc misses the truth with a chance of {_share(share)}, if the noise is as the estimate assumes; of ",
        counted(len(e), "line"), f" about {missed:.2g} may be judged by a disc that does. Whether the display is stable was not ",
        "looked at.",
    )  # fmt: skip
