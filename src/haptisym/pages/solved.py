"""Solutions of an equation as lines of a page: the formulas, when they are in force, and where there is none."""

from __future__ import annotations

from collections.abc import Iterable

from sympy import Add, Expr, Integer, count_ops

from haptisym.kernel.solutions import Solution
from haptisym.kernel.symbols import omega
from haptisym.writing.boxes import Box, Equation
from haptisym.writing.document import Line, Phrase, listed
from haptisym.writing.layout import layout

MOST_STEPS = 150  # operations of the steps beyond which closed forms would fill pages
MOST_TERMS = (
    2000  # above the line of a function that is written, or solved, unasked: SymPy takes a second or two for them
)


def answers(left: Box, solutions: Iterable[Solution]) -> tuple[list[Line], list[Phrase]]:
    """The formulas among some solutions, and what to say about the others."""
    rows: list[Line] = []
    notes: list[Phrase] = []
    for x in solutions:
        if x.omega is None:
            what = f"a solution is a root of a factor {_degree(x.equation)}"
            notes.append((f"{what}: it has no readable formula, the equation is the answer.",))
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


def _degree(equation: Expr) -> str:
    if not equation.is_polynomial(omega):
        return "in omega and its sines and cosines"
    degree = max(int(term.as_powers_dict().get(omega, 0)) for term in Add.make_args(equation.expand()))
    return f"of degree {degree} in omega"
