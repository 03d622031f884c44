"""Measured lines on a page: where they come from, and a row of a table for each, or for neighbours that are judged alike."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from math import tau
from typing import Any

import numpy as np

from haptisym.kernel.shown import counted
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement
from haptisym.model.welch import Welch
from haptisym.pages.words import OMEGA, PART_NAMES, RATIOS, rounded
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.judging import CODES, certainty
from haptisym.writing.document import Block, Column, Notes, Number, Phrase, Strong, Table

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
