"""The page of a measured evaluation: what the discs tell at each line, what they do not, and what would resolve the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from math import tau
from typing import TYPE_CHECKING, Any

import numpy as np

from haptisym.judge.percepts import NOT_NAMED, felt_words
from haptisym.kernel.shown import counted
from haptisym.kernel.symbols import s
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement, coherence_for
from haptisym.pages.words import OMEGA, PART_NAMES, RATIOS, limits, stiffness_unit
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.judging import CODES, certainty, limits_of
from haptisym.verbs.measured.needed import Share
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
    coded,
)
from haptisym.writing.equations import equation
from haptisym.writing.formula import readable

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

_MOST_ROWS = 40
"""Of a table with a row for each line; where there are more, lines that are judged alike and follow each other share one."""


def page(e: MeasuredEvaluation) -> Document:
    """The whole page."""
    lead: tuple[Phrase, ...] = tuple(x for x in (e.scene.source, *map(coded, e.scene.asides())) if x)
    blocks: tuple[Block, ...] = (
        Facts(tuple(_about(e))),
        Section("Step 1. When does the hand begin to notice?", tuple(_step_1(e)), "step-1"),
        Section("Step 2. How is it felt?", tuple(_step_2(e)), "step-2"),
        Paragraph(_certain(e)),
    )
    return Document(e.scene.title or "Untitled scene", lead, blocks, "Two-step evaluation of a measured display")


def _number(x: float, digits: int = 5) -> Number:
    return Number(f"{x:.{digits}g}", x)


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
    if e.left_out:
        yield "left out", f"{counted(e.left_out, 'line')}, off the band or without a line of the environment"
    if e.scene.band is not None:
        low, high = map(float, e.scene.band)
        yield "band", (_number(low), " to ", _number(high), " rad/s")
    yield "threshold", limits(e.scene.threshold)
    if felt.coherence is not None and felt.averages is not None:
        c = min(float(x.min()) for x in limits_of(e.scene, e.lines.omega).values())
        least = float(coherence_for(c, felt.averages, felt.confidence))
        told = f"with {felt.averages:g} averages a disc of {_share(c)} of what is felt needs a coherence of at least "
        yield "discs", (_discs(e), "; ", told, _number(least, 7))
    else:
        yield "discs", _discs(e)


def measured_words(m: Measurement) -> Phrase:
    """``bench.csv: 60 lines from 1 to 15 rad/s``, and what its discs come from."""
    low, high = float(m.omega[0]), float(m.omega[-1])
    where: Phrase = ("at ", _number(low)) if len(m) == 1 else ("from ", _number(low), " to ", _number(high))
    if m.welch is not None:
        return (m.name, ": ", counted(len(m), "line"), " ", where, " rad/s; ", m.welch.words)
    lines: Phrase = (m.name, ": ", counted(len(m), "line"), " ", where, " rad/s")
    if m.coherence is None:
        return lines, "; ", certainty(m)
    seen = f"{float(m.coherence.min()):.4g} to {float(m.coherence.max()):.4g}"
    return lines, f"; coherence {seen}, {m.averages:g} averages"


def _discs(e: MeasuredEvaluation) -> Phrase:
    radius = e.lines.radius
    if radius is None:
        return Strong(
            "UNKNOWN"
        ), ": neither coherence nor radius is given, and every line is judged as if it were exact"
    ends = [float(x) for x in (radius.min(), radius.max())]
    seen = tuple("unbounded" if np.isinf(x) else _share(x) for x in ends)
    return f"{_share(e.scene.perceived.confidence)} confidence, radius {seen[0]} to {seen[1]} of ", _SIZE


_SIZE: Phrase = "the environment's magnitude"


# Step 1, when.


def _step_1(e: MeasuredEvaluation) -> Iterator[Block]:
    for part in Part:
        yield Paragraph(_told(e, part))
    yield _table(e)
    yield from _cut(e)
    yield _figure(e, "ratios", "Distortion ratios at the measured lines. Bars: how far the disc of each line reaches. Filled: "
                  "the whole disc exceeds the threshold or is below it; open: it does not tell.", wide=True)  # fmt: skip
    if e.needed is not None:
        yield Notes(tuple(_resolving(e)))


def _told(e: MeasuredEvaluation, part: Part) -> Phrase:
    """How many lines of a part exceed, stay below or are open, and where it first exceeds."""
    codes = e.verdict[part]
    count = {code: int((codes == code).sum()) for code in CODES}
    lines = counted(len(e), "line")
    said: Phrase = (
        RATIOS[part], f" ({PART_NAMES[part]} part) exceeds its threshold at {count[1] or 'none'} of {lines}, is below it at ",
        f"{count[-1] or 'none'} and unresolved at {count[0] or 'none'}",
    )  # fmt: skip
    if not count[1]:
        return said, "."
    first = int(np.argmax(codes == 1))
    return said, "; the first line that exceeds is at ", _number(float(e.lines.omega[first])), " rad/s."


def _table(e: MeasuredEvaluation) -> Block:
    code = 3 * e.verdict[Part.REAL] + e.verdict[Part.IMAG]
    caption = "Each measured line: exceeds or below where the whole disc does, unresolved where the disc does not tell."
    heading: Phrase = (OMEGA, " (rad/s)")
    if len(e) <= _MOST_ROWS:
        numbers = (
            Column(heading, number=True),
            Column("Hz", number=True),
            *(Column(RATIOS[x], number=True) for x in Part),
        )
        columns = (*numbers, Column("radius", number=True), Column("real"), Column("imaginary"))
        rows: tuple[tuple[Phrase, ...], ...] = tuple(
            (_number(x.omega), f"{x.omega / tau:.5g}", _ratio(x.ratio_real), _ratio(x.ratio_imag), _ratio(x.radius),
             _verdict(x.real.value), _verdict(x.imag.value))
            for x in e.rows
        )  # fmt: skip
        return Table(columns, rows, caption)
    rows = tuple(
        (_ends(e, first, last), str(last - first + 1), *(_verdict(CODES[int(e.verdict[x][first])].value) for x in Part))
        for first, last in islice(_runs(code), _MOST_ROWS)
    )
    return Table((Column(heading), Column("lines", number=True), Column("real"), Column("imaginary")), rows, caption)


def _cut(e: MeasuredEvaluation) -> Iterator[Block]:
    """That the table does not hold everything."""
    code = 3 * e.verdict[Part.REAL] + e.verdict[Part.IMAG]
    groups = 1 + np.count_nonzero(np.diff(code))
    if len(e) > _MOST_ROWS and groups > _MOST_ROWS:
        yield Notes(
            (f"The first {_MOST_ROWS} of {groups} groups of lines that are judged alike; JSON has every line.",)
        )


def _verdict(word: str) -> Phrase:
    return Strong(word) if word == "exceeds" else word


def _ratio(x: float | None) -> Phrase:
    return "" if x is None else _number(x, 4) if np.isfinite(x) else "unbounded"


def _runs(codes: Any) -> Iterator[tuple[int, int]]:
    """First and last index of equal neighbours."""
    edges = np.flatnonzero(np.diff(codes)) + 1
    starts, stops = [0, *edges.tolist()], [*(edges - 1).tolist(), len(codes) - 1]
    yield from zip(starts, stops, strict=True)


def _ends(e: MeasuredEvaluation, first: int, last: int) -> Phrase:
    low, high = (_number(float(e.lines.omega[i])) for i in (first, last))
    return low if first == last else (low, " to ", high)


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
    rows = tuple(islice(_felt(e), _MOST_ROWS + 1))
    if rows:
        caption = "What is felt at the lines that exceed, where their discs tell it; nothing is said between lines."
        yield Table(
            (Column((OMEGA, " (rad/s)")), Column("lines", number=True), Column("part"), Column("felt as")),
            rows,
            caption,
        )
    if len(rows) > _MOST_ROWS:
        yield Notes((f"The first {_MOST_ROWS} groups of lines that are felt alike; JSON has every line.",))
    if not rows:
        yield Paragraph("No line exceeds its threshold for certain: nothing is named.")
    yield _figure(e, "nyquist", "Environment and what is felt in the complex plane, a disc around each measured line.")


def _felt(e: MeasuredEvaluation) -> Iterator[tuple[Phrase, ...]]:
    """Neighbouring lines that are felt alike, as one row."""
    for part in Part:
        own, named = e.signs[part], e.named(part)
        exceeds = e.verdict[part] == 1
        label = np.where(
            named, 27 + 9 * own.environment + 3 * own.perceived + own.compared, np.where(exceeds, 1000, 999)
        )
        for first, last in _runs(label):
            if exceeds[first]:
                words = felt_words(*own.label(part, first)) if named[first] else NOT_NAMED
                yield _ends(e, first, last), str(last - first + 1), part.value, words


def _figure(e: MeasuredEvaluation, name: str, caption: str, *, wide: bool = False) -> Figure:
    def draw() -> Canvas:
        from haptisym.figures.measured import draw_measured_figure  # matplotlib is loaded where something is drawn

        return draw_measured_figure(e, name, wide=wide)

    return Figure(name, caption, draw, wide)


def _certain(e: MeasuredEvaluation) -> Phrase:
    start = (
        "Measured, not proven: this is said line by line, at the measured frequencies alone, and nothing is said between "
        "the lines."
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
