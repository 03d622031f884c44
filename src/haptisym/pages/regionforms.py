"""When a region is left, as formulas: the functions of omega that must not all be positive."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

from sympy import Abs, Expr, Symbol, count_ops

from haptisym.judge.criteria import Criterion, noticed
from haptisym.judge.regions import Diamond, Ellipse, Joint, Polygon
from haptisym.kernel.lattices import Lattice, Signed
from haptisym.kernel.response import RealFunction
from haptisym.kernel.solutions import solve
from haptisym.model.regions import Shape
from haptisym.pages.solved import MOST_STEPS, MOST_TERMS, Written, answers
from haptisym.pages.words import H_ENV, OMEGA, region
from haptisym.verbs.derive.derivation import Derivation
from haptisym.writing.boxes import Absolute, Box, Fraction
from haptisym.writing.document import Line, Phrase, Section, listed
from haptisym.writing.equations import function, quantity
from haptisym.writing.names import named

_LONGEST = 250  # operations of a function that is written out unasked
_MOST = 16  # functions that are
_LARGEST = 200_000  # products of terms of both parts of dH: beyond, what decides takes seconds, then minutes, and nobody reads it


def ways(x: Criterion, found: Signed) -> tuple[Phrase, list[tuple[Box, Signed]]]:
    """Where a criterion is broken, in words, and the functions that these name."""
    terms: Sequence[Sequence[Signed]] = found.terms if isinstance(found, Lattice) else ((found,),)
    names = [[_called(x, i, j, terms) for j, _ in enumerate(row, 1)] for i, row in enumerate(terms, 1)]
    said = listed((listed((name, " > 0") for name in row) for row in names), "or")
    what = f"The {x.joint.kind} is left" if x.joint else (named(x.symbol), " exceeds its limit")
    return (what, " exactly where ", said, "."), list(zip(chain(*names), chain(*terms), strict=True))


def _called(x: Criterion, i: int, j: int, terms: Sequence[Sequence[Signed]]) -> Box:
    one = len(terms) == 1 and len(terms[0]) == 1
    return function(f"p_{x.name}" if one else f"p_{x.name}_{i}{j}", OMEGA)


def when(d: Derivation) -> Section:
    """Of a region, or of limits that are formulas in omega: its border, and each function in closed form where it is short."""
    limits = "The limits are " if d.scene.threshold.region.shape is Shape.SQUARE else "The JND is "
    out = Written(notes=[(limits, region(d.scene.threshold), ".")])
    long: list[Phrase] = []
    is_short = _is_short(d)
    for x in noticed(d.scene.threshold):
        if x.joint:
            borders = [(named(f"q_{i}"), form) for i, form in enumerate(_borders(x.joint), 1)]
            one_of = "one of " if len(borders) > 1 else ""
            shown = listed((name for name, _ in borders), "or")
            out.notes.append(("The ", x.joint.kind, " is left where ", one_of, shown, " is positive."))
            out.lines += [_relative("x_r", "Re dH"), _relative("x_i", "Im dH"), *(Line(*pair) for pair in borders)]
        if not is_short:
            continue
        found = x.function(d.distortion)
        said, functions = ways(x, found)
        out.notes.append(said)
        for name, f in functions:
            form = f.factored() if isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS else None
            if form is None or count_ops(form) > _LONGEST or len(long) + len(out.lines) >= _MOST:
                long.append(name)
            else:
                out.lines.append(Line(name, form))
        solved, told = _solved(x, found, d)
        out.lines += solved
        out.notes += told
    if not is_short:
        out.notes.append("Closed forms of this chain are long: which functions of ω decide it is not written out.")
    if long:
        out.notes.append(("Too long to be written out unasked: ", listed(long), ". Fewer symbols make them shorter."))
    out.notes.append("Its crossings, as numbers: `haptisym evaluate`.")
    return out.section("When it is noticed")


def _is_short(d: Derivation) -> bool:
    """Whether the functions that decide are found at once."""
    if d.steps.operations > MOST_STEPS:
        return False
    change = d.distortion.difference_response
    return len(change.real.function.numerator) * len(change.imag.function.numerator) <= _LARGEST


def _solved(x: Criterion, found: Signed, d: Derivation) -> tuple[list[Line], list[Phrase]]:
    """Where what is judged meets its limit, solved for omega: of one function its crossings, of several where they may lie."""
    terms: Sequence[Sequence[Signed]] = found.terms if isinstance(found, Lattice) else ((found,),)
    if not any(isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS for row in terms for f in row):
        return [], []
    conditions = [len(term.where) for term in x.region.terms(d.distortion)] if x.region else [0]
    is_one = len(terms) == len(terms[0]) == 1
    lines: list[Line] = []
    notes: list[Phrase] = []
    for i, row in enumerate(terms):
        for j, f in enumerate(row[conditions[i] :], conditions[i] + 1):
            if isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS:
                place = "" if is_one else f"_{i + 1}{j}"
                own, said = answers(named(f"omega_{x.name}{place}"), solve(f))
                lines += [line for line in own if line.value not in [known.value for known in lines]]
                notes += [note for note in said if note not in notes]
    if lines and not is_one:
        notes.insert(
            0, "each crossing is one of the solutions, or a frequency at which another function changes its sign."
        )
    return lines, [(named(x.symbol), ": ", note) for note in notes]


def _relative(name: str, part: str) -> Line:
    return Line(named(name), Fraction(quantity(part), Absolute(H_ENV)))


def _borders(of: Joint) -> list[Expr]:
    """What is positive outside of a region, in x_r and x_i: one, or for each edge one."""
    x, y = Symbol("x_r", real=True), Symbol("x_i", real=True)
    if isinstance(of, Polygon):
        return [p * x + q * y - 1 for p, q in of.edges]
    assert isinstance(of, Diamond | Ellipse)
    u, v = x / of.real, y / of.imag
    if isinstance(of, Diamond):
        return [Abs(x) / of.real + Abs(y) / of.imag - 1]
    return [u**2 - 2 * of.tilt * u * v + v**2 - (1 - of.tilt**2)]
