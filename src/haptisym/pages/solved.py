"""Sections of equations as they are put together; solutions of one as formulas, when these hold, or that there is none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from sympy import Add, Expr, Integer, count_ops

from haptisym.kernel.solutions import Solution
from haptisym.kernel.symbols import omega
from haptisym.pages.words import OMEGA, noted
from haptisym.writing.boxes import Box, Equation
from haptisym.writing.document import Equations, Line, Phrase, Section, listed
from haptisym.writing.layout import layout

MOST_STEPS = 150  # operations of the steps beyond which closed forms would fill pages
MOST_TERMS = (
    2000  # above the line of a function that is written, or solved, unasked: SymPy takes a second or two for them
)


@dataclass
class Written:
    """What a section says, as it is put together: equations, and what they mean or why there is none."""

    lines: list[Line] = field(default_factory=list)
    notes: list[Phrase] = field(default_factory=list)

    def solve(self, left: Box, solutions: Iterable[Solution], of: Phrase) -> None:
        """Some solutions as formulas, and what is to be said about the others; ``of`` : what is solved."""
        lines, said = answers(left, solutions)
        self.lines += lines
        self.notes += [(of, ": ", x) for x in said]

    def section(self, title: Phrase) -> Section:
        """It below a heading, the words before the equations."""
        equations = (Equations(tuple(self.lines)),) if self.lines else ()
        return Section(title, (*noted(self.notes), *equations))


def answers(left: Box, solutions: Iterable[Solution]) -> tuple[list[Line], list[Phrase]]:
    """The formulas among some solutions, and what to say about the others."""
    rows: list[Line] = []
    notes: list[Phrase] = []
    for x in solutions:
        if x.omega is None:
            what = "a solution is a root of a factor ", *_degree(x.equation)
            notes.append((*what, ": it has no readable formula, the equation is the answer."))
            continue
        rows.append(Line(left, x.omega))
        notes += _in_force(x)
        if x.period:
            notes.append(("so are these plus any multiple of ", layout(x.period), "."))
    return rows, list(dict.fromkeys(notes))


def _in_force(x: Solution) -> list[Phrase]:
    """Under which conditions a formula holds, in words."""
    if not x.conditions:
        return []
    if max(map(count_ops, x.conditions)) > 4:
        return [("a formula is in force where nothing under its roots is negative.",)]
    bounds = (Equation((layout(y), layout(Integer(0))), ("≥",)) for y in x.conditions)
    return [("in force where ", listed((x,) for x in bounds), ".")]


def _degree(equation: Expr) -> tuple[Phrase, ...]:
    if not equation.is_polynomial(omega):
        return "in ", OMEGA, " and its sines and cosines"
    degree = max(int(term.as_powers_dict().get(omega, 0)) for term in Add.make_args(equation.expand()))
    return f"of degree {degree} in ", OMEGA
