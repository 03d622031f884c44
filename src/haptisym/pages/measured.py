"""The page of a measured evaluation: what the discs tell at each line, what they do not, and what would resolve the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from haptisym.judge.percepts import NOT_NAMED, felt_words
from haptisym.kernel.shown import counted
from haptisym.kernel.symbols import s
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement, coherence_for
from haptisym.pages.late import drawing
from haptisym.pages.measuredbetween import between_section, stated
from haptisym.pages.measuredlines import MOST_ROWS, cut, ends, linearity, measured_words, runs, shape, table
from haptisym.pages.words import OMEGA, PART_NAMES, RATIOS, limits, page_about, rounded, stiffness_unit
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.judging import CODES, limits_of
from haptisym.verbs.measured.needed import Share
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
)
from haptisym.writing.equations import equation
from haptisym.writing.formula import readable


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
