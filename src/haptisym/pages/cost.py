"""The pages of what accuracy costs: the answer, a table for each question, what was measured on
what; and the hard cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isinf
from statistics import median

from haptisym.model.jnd import Part
from haptisym.pages.words import RATIOS, Field, number, page_about, table
from haptisym.verbs.cost.entry import Cost, duration
from haptisym.verbs.cost.hardcosts import FAMILIES, HardCosts, HardRow, worst_verdict
from haptisym.writing.document import Block, Document, Figure, Number, Paragraph, Phrase, Section

_TASKS: dict[str, Phrase] = {
    "evaluate": (
        "The ratios ",
        RATIOS[Part.REAL],
        " and ",
        RATIOS[Part.IMAG],
        ": time for one frequency",
    ),
    "crossings": "The crossings on the band: time for all of them",
    "delay": "The crossings with approximated delays, against the exact ones",
    "effects": "The crossings with an effect left out, against all effects",
}
"""What each task asks."""
_PROOF = (
    "Measured: correct digits of the worst number, against a proven reference of higher "
    "precision; times are medians of "
    "repeats in turns, with half their interquartile range. Ratios of times carry over to "
    "other machines, times do not."
)
_LEGEND = (
    "Correct: to the digits that the numbers of the method hold but for one, and no crossing "
    "missed or invented. Digits are "
    "those of the worst case, times medians over the cases. Condition number: the relative "
    "change of a result with the "
    "frequency or the threshold; what a method loses beyond its logarithm is due to the method."
)


def page(found: Cost) -> Document:
    """Return the whole page of what accuracy costs."""
    shown = "Correct digits against time for each question; filled marks are proven."
    blocks = (
        *(_table(found, task) for task in _TASKS if found.task(task)),
        Figure("cost", shown, found.figure, wide=True),
    )
    omitted = (f"Left out: {x.method} ({x.reason})." for x in found.left_out)
    proof = _PROOF, *omitted, _measured_on(found.machine)
    return page_about(
        found.scene, (("Result", found.summary),), blocks, proof, "What accuracy costs", ()
    )


def _measured_on(machine: Mapping[str, str]) -> str:
    """On what it was measured."""
    return f"Measured on {', '.join(f'{name} {value}' for name, value in machine.items())}."


def _table(found: Cost, task: str) -> Block:
    """Return the section of one task: methods against digits and times."""
    size = found.condition.get(task)
    condition = (
        ""
        if size is None
        else f" (condition number {'infinite: a tangency' if isinf(size) else f'{size:.2g}'})"
    )
    shown = table(
        found.task(task),
        (_TASKS[task], "."),
        Field("method", lambda x: x.method),
        number("correct digits", lambda x: Number(f"{x.digits:.{int(x.digits < 20)}f}", x.digits)),
        Field("time", lambda x: duration(x.seconds)),
        Field("spread", lambda x: "" if x.spread is None else f"± {100 * x.spread:.0f} %"),
        Field("proven", lambda x: "yes" if x.proven else "no"),
        Field("", lambda x: x.wrong),
    )
    return Section((_TASKS[task], condition), (shown,))


def hard_page(found: HardCosts) -> Document:
    """The page of the hard cases: a section for each family, a line in it for each method."""
    groups = {name: [row for row in found.rows if row.family == name] for name in FAMILIES}
    families = (_family(name, rows) for name, rows in groups.items() if rows)
    shown = (
        "How many questions of each family each method answers right; the darker the fewer. "
        "Filled marks: proven."
    )
    figure = Figure("hard-cases", shown, found.figure, wide=True)
    blocks = (
        Paragraph(found.summary),
        *families,
        figure,
        Paragraph(_LEGEND),
        Paragraph(_measured_on(found.machine)),
    )
    return Document("The hard cases", (), blocks)


def _family(family: str, rows: Sequence[HardRow]) -> Block:
    """Return the section of one family of hard cases."""
    cases = dict.fromkeys(row.case for row in rows)
    hardest = max(row.condition for row in rows)
    condition = "infinity" if isinf(hardest) else f"{hardest:.2g}"
    asks = "values of r_r and r_i" if rows[0].task == "evaluate" else "crossings"
    counted = (
        f"{len(cases)} question{'s' * (len(cases) > 1)} about {asks}, condition number up to "
        f"{condition}"
    )
    names = ("method", "correct", "digits", "time", "proven", "")
    each = [
        _hard_row([x for x in rows if x.method == method])
        for method in dict.fromkeys(row.method for row in rows)
    ]
    fields = (
        Field(x, lambda row, i=i: row[i], number=x == "digits")  # type: ignore[misc]
        for i, x in enumerate(names)
    )
    return Section(
        f"{family}: {FAMILIES[family]}",
        (Paragraph(f"{counted}."), table(each, f"{family}.", *fields)),
    )


def _hard_row(rows: Sequence[HardRow]) -> tuple[Phrase, ...]:
    """Return one method's row: correct answers, the worst digits, the median time, what is
    wrong."""
    answered = [row for row in rows if row.answered]
    if not answered:
        return rows[0].method, "", "", "", "", rows[0].verdict
    right = sum(row.verdict == "right" for row in answered)
    worst = min(row.digits for row in answered)
    proven = "yes" if all(row.proven for row in answered) else "no"
    time = duration(median(row.seconds for row in answered))
    counted = f"{right}/{len(answered)}"
    return (
        rows[0].method,
        counted,
        Number(f"{worst:.1f}", worst),
        time,
        proven,
        worst_verdict(answered),
    )
