"""Several environments as a page of text: one row each, and the worst case."""

from __future__ import annotations

from collections.abc import Iterable
from textwrap import fill

from haptisym.judge.criteria import Criterion, noticed
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import RealNumber
from haptisym.model.caveats import caveats
from haptisym.model.jnd import Part
from haptisym.pages.lines import WIDTH, both, caveats_text, listed, percent, short, span, table
from haptisym.verbs.family.entry import Binding, FamilyEvaluation


def page(w: FamilyEvaluation) -> str:
    """The whole page."""
    parts = [_heading(w), _each(w), _worst(w), caveats_text(caveats(w.family.first)), _certain(w)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _heading(w: FamilyEvaluation) -> str:
    low, high = (w.chart.points[i].omega for i in (0, -1))
    c = w.family.threshold
    limits = percent(c.real) if c.real == c.imag else f"{percent(c.real)} (real) and {percent(c.imag)} (imaginary)"
    rows = [
        ("effects", ", ".join(effect.name for effect in w.family.first.effects) or "none"),
        ("band", f"{both(low)} to {both(high)}"),
        ("threshold", f"{limits} of |H_env|"),
    ]
    lines = [fill(x, WIDTH) for x in (w.family.title or "Untitled scene", w.family.source) if x]
    lines += [fill(x, WIDTH) for x in w.asides()]
    shown = [fill(x, WIDTH, initial_indent=f"  {key:<13}", subsequent_indent=" " * 15) for key, x in rows]
    return "\n".join([*lines, "", *shown])


def _each(w: FamilyEvaluation) -> str:
    criteria = noticed(w.family.threshold)
    headings = ("environment", *(f"{x.symbol} > c from" for x in criteria), "bandwidth", "felt as")
    rows = [(name, *(_first(e, x) for x in criteria), _bandwidth(e), _felt(e)) for name, e in w.answers.items()]
    return f"Each environment (rad/s)\n\n{table(headings, rows)}"


def _first(e: Evaluation, criterion: Criterion) -> str:
    """The lowest frequency beyond which a ratio exceeds its threshold."""
    exceeded = e.chart.where(lambda signs: signs[criterion] > 0)
    return short(exceeded[0].low.omega) if exceeded else "never"


def _bandwidth(e: Evaluation) -> str:
    if e.bandwidth is None:
        return "none"
    return "whole band" if e.bandwidth is e.chart.points[-1].omega else short(e.bandwidth)


def _felt(e: Evaluation) -> str:
    """How each part is felt where it is first noticed."""
    first = {x.part: x.words for x in reversed(e.felt)}
    return "; ".join(first[part] for part in Part if part in first) or "-"


def _worst(w: FamilyEvaluation) -> str:
    lines = [_transparency(w), *map(_bound, _grouped(w.binding))]
    return "\n".join(["Worst case: transparent with every one of them", "", *(_indented(x) for x in lines)])


def _transparency(w: FamilyEvaluation) -> str:
    whole = w.bandwidth is w.chart.points[-1].omega
    if not w.transparent:
        return "Nowhere on the band."
    if whole:
        return "On the whole band."
    pieces = listed(span(x) for x in w.transparent)
    if w.bandwidth is None:
        return f"Only {pieces}."
    return f"Up to {both(w.bandwidth)}, the common bandwidth." + (
        "" if len(w.transparent) == 1 else f" All of it: {pieces}."
    )


def _grouped(binding: Iterable[Binding]) -> list[tuple[RealNumber, list[Binding]]]:
    found: dict[RealNumber, list[Binding]] = {}
    for x in binding:
        found.setdefault(x.omega, []).append(x)
    return list(found.items())


def _bound(place: tuple[RealNumber, list[Binding]]) -> str:
    omega, rows = place
    who = listed(f"{x.environment} ({x.criterion.name} part, {x.criterion.symbol})" for x in rows)
    return f"At {short(omega)} rad/s {who} {'binds' if len(rows) == 1 else 'bind'}."


def _certain(w: FamilyEvaluation) -> str:
    if not w.certified:
        return "UNDECIDED at the precision limit near some frequency: evaluate each environment alone to see where."
    return fill(
        "Certain: every crossing of every environment on the band is known, none is missed and none invented; which of "
        "them comes first is proven, and equal ones are found equal.",
        WIDTH,
    )


def _indented(text: str) -> str:
    return fill(text, WIDTH, initial_indent="  ", subsequent_indent="  ")
