"""The page and the document of a derivation: sections of equations with sentences between them, for
text, LaTeX and MathML.

A derivation goes from H_env and H_perc to Re dH and Im dH, the polynomials p whose sign decides
what is noticed, and their roots solved for omega. All of it is exact algebra. As a script of SymPy
it is its symbols with their assumptions, the dynamics, then the distortion in named steps. Begin
with ``sections``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import sympy
from sympy import Abs, Expr, Integer, Symbol, count_ops, exp
from sympy.core.function import Application
from sympy.printing.str import StrPrinter

from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.regions import Cornered, Ellipse, Joint
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError
from haptisym.kernel.harmonics import STEP, Harmonic, named_harmonics
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import omega, s
from haptisym.kernel.roots import Lattice, Signed
from haptisym.kernel.solutions import Solution, solve
from haptisym.model.jnd import Part, Shape
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import Dimension, unit_text
from haptisym.pages.words import H_ENV, OMEGA, Field, both, cell, noted, page_about, region, table
from haptisym.programs.steps import DISTORTION, Steps
from haptisym.verbs.derive.derivation import QUANTITIES, Derivation, bare, listed_name
from haptisym.verbs.derive.groups import Groups
from haptisym.writing import document as doc
from haptisym.writing.boxes import Absolute, Box, Fraction, Name, Relation, SideBySide, text
from haptisym.writing.code import Language, comment, identifiers
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, listed
from haptisym.writing.latex import formula, fragment, tex
from haptisym.writing.layout import function, layout, named, plain, quantity
from haptisym.writing.mathml import mathml
from haptisym.writing.plain import said

MOST_STEPS = 150  # operations of the steps beyond which closed forms would fill pages
MOST_TERMS = 2000
"""Terms of the numerator of a function that is written, or solved, unasked: SymPy takes a second or
two for so many."""


@dataclass
class Written:
    """What a section says, as it is put together: equations, and what they mean or why there is
    none."""

    lines: list[doc.Line] = field(default_factory=list)
    notes: list[Phrase] = field(default_factory=list)

    def solve(self, left: Box, solutions: Iterable[Solution], of: Phrase) -> None:
        """Some solutions as formulas, and what is to be said about the others; ``of`` : what is
        solved."""
        lines, said = answers(left, solutions)
        self.lines += lines
        self.notes += [(of, ": ", x) for x in said]

    def section(self, title: Phrase) -> doc.Section:
        """Return the section: its heading, then the sentences, then the equations."""
        equations = (doc.Equations(tuple(self.lines)),) if self.lines else ()
        return doc.Section(title, (*noted(self.notes), *equations))


def answers(left: Box, solutions: Iterable[Solution]) -> tuple[list[doc.Line], list[Phrase]]:
    """The formulas among some solutions, and what to say about the others."""
    rows: list[doc.Line] = []
    notes: list[Phrase] = []
    for x in solutions:
        # A factor of a degree that radicals do not solve, or with sines and cosines of omega.
        if x.omega is None:
            what = "a solution is a root of a factor ", *_degree(x.equation)
            notes.append((*what, ": no readable formula; the equation is the result."))
            continue
        rows.append(doc.Line(left, x.omega))
        notes += _in_force(x)
        if x.period:
            notes.append(("so are these plus any multiple of ", layout(x.period), "."))
    # Several solutions share a condition: it is said once.
    return rows, list(dict.fromkeys(notes))


def _in_force(x: Solution) -> list[Phrase]:
    """Under which conditions a formula holds, in words."""
    if not x.conditions:
        return []
    # A condition of more operations is harder to read than the formula that it guards.
    if max(map(count_ops, x.conditions)) > 4:
        return [("a formula holds where it is real and not negative.",)]
    bounds = (Relation((layout(y), layout(Integer(0))), ("≥",)) for y in x.conditions)
    return [("holds where ", listed((x,) for x in bounds), ".")]


def _degree(equation: Expr) -> tuple[Phrase, ...]:
    """Return the degree of an equation in omega, or that it has sines and cosines as well."""
    if not equation.is_polynomial(omega):
        return "in ", OMEGA, " and its sines and cosines"
    return f"of degree {_power(equation)} in ", OMEGA


def _power(x: Expr) -> int:
    """The degree in omega of a polynomial whose sums are collected by its powers: nothing in them
    cancels."""
    if x.is_Pow:
        return int(x.exp) * _power(x.base) if x.base.has(omega) else 0
    if x.is_Add or x.is_Mul:
        # The degree of a sum is the largest of its terms, that of a product the sum.
        return (max if x.is_Add else sum)(map(_power, x.args))
    return int(x == omega)


_LONGEST = 250  # operations of a function that is written out unasked
_MOST = 16  # functions that are
_LARGEST = 200_000
"""Products of terms of both parts of dH: beyond that the functions that decide take seconds, then
minutes, and nobody reads them."""


def ways(x: Criterion, found: Signed) -> tuple[Phrase, list[tuple[Box, Signed]]]:
    """Where a criterion is broken, in words, and the functions that these name."""
    terms: Sequence[Sequence[Signed]] = found.terms if isinstance(found, Lattice) else ((found,),)
    names = [
        [_called(x, i, j, terms) for j, _ in enumerate(row, 1)] for i, row in enumerate(terms, 1)
    ]
    # A lattice is broken where all functions of some row are positive: and within a row, or between
    # rows.
    said = listed((listed((name, " > 0") for name in row) for row in names), "or")
    what = f"The {x.joint.kind} is left" if x.joint else (named(x.symbol), " exceeds its limit")
    return (what, " exactly where ", said, "."), list(
        zip(chain(*names), chain(*terms), strict=True)
    )


def _called(x: Criterion, i: int, j: int, terms: Sequence[Sequence[Signed]]) -> Box:
    """Return the name p of a function that decides; with indices where a criterion has several."""
    one = len(terms) == 1 and len(terms[0]) == 1
    return function(f"p_{x.name}" if one else f"p_{x.name}_{i}{j}", OMEGA)


def when_of_region(d: Derivation) -> doc.Section:
    """Return the section of a region, or of limits that are formulas in omega: its border, and each
    function that decides, in closed form where it is short."""
    limits = "The limits are " if d.scene.threshold.region.shape is Shape.SQUARE else "The JND is "
    out = Written(notes=[(limits, region(d.scene.threshold), ".")])
    long: list[Phrase] = []
    is_short = _is_short(d)
    for x in noticed(d.scene.threshold):
        if x.joint:
            borders = [(named(f"q_{i}"), form) for i, form in enumerate(_borders(x.joint), 1)]
            one_of = "one of " if len(borders) > 1 else ""
            shown = listed((name for name, _ in borders), "or")
            out.notes.append(
                ("The ", x.joint.kind, " is left where ", one_of, shown, " is positive.")
            )
            out.lines += [
                _relative("x_r", "Re dH"),
                _relative("x_i", "Im dH"),
                *(doc.Line(*pair) for pair in borders),
            ]
        if not is_short:
            continue
        excess = x.function(d.distortion)
        said, functions = ways(x, excess)
        out.notes.append(said)
        for name, f in functions:
            # Only a function that is rational in omega has a form in factors; others are named and
            # left to the numbers.
            form = (
                f.factored()
                if isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS
                else None
            )
            if form is None or count_ops(form) > _LONGEST or len(long) + len(out.lines) >= _MOST:
                long.append(name)
            else:
                out.lines.append(doc.Line(name, form))
        solved, remarks = _solved(x, excess, d)
        out.lines += solved
        out.notes += remarks
    if not is_short:
        out.notes.append("Closed forms of this chain are long and not expanded here.")
    if long:
        out.notes.append(
            ("Too long to be expanded here: ", listed(long), "; fewer symbols make them shorter.")
        )
    out.notes.append(doc.Brief(("Its crossings, as numbers: ", doc.Code("haptisym evaluate"), ".")))
    return out.section("When it is noticed")


def _is_short(d: Derivation) -> bool:
    """Whether the functions that decide are found at once."""
    if d.steps.operations > MOST_STEPS:
        return False
    # The functions that decide have products of both parts of dH: their size bounds the work before
    # it is done.
    change = d.distortion.difference_response
    return len(change.real.function.numerator) * len(change.imag.function.numerator) <= _LARGEST


def _solved(x: Criterion, found: Signed, d: Derivation) -> tuple[list[doc.Line], list[Phrase]]:
    """Where what is judged meets its limit, solved for omega: of one function its crossings, of
    several where they may lie."""
    terms: Sequence[Sequence[Signed]] = found.terms if isinstance(found, Lattice) else ((found,),)
    if not any(
        isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS
        for row in terms
        for f in row
    ):
        return [], []
    # The first functions of a row say where it applies; a root of these alone is no crossing of the
    # limit.
    conditions = [len(term.where) for term in x.region.terms(d.distortion)] if x.region else [0]
    is_one = len(terms) == len(terms[0]) == 1
    lines: list[doc.Line] = []
    notes: list[Phrase] = []
    for i, row in enumerate(terms):
        for j, f in enumerate(row[conditions[i] :], conditions[i] + 1):
            if isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS:
                place = "" if is_one else f"_{i + 1}{j}"
                formulas, said = answers(named(f"omega_{x.name}{place}"), solve(f))
                lines += [
                    line for line in formulas if line.value not in [known.value for known in lines]
                ]
                notes += [note for note in said if note not in notes]
    if lines and not is_one:
        notes.insert(
            0,
            (
                "each crossing is one of the solutions, or a frequency at which another function "
                "changes its sign."
            ),
        )
    return lines, [(named(x.symbol), ": ", note) for note in notes]


def _relative(name: str, part: str) -> doc.Line:
    """Return the line that defines a part of the distortion relative to |H_env|."""
    return doc.Line(named(name), Fraction(quantity(part), Absolute(H_ENV)))


def _borders(of: Joint) -> list[Expr]:
    """What is positive outside of a region, in x_r and x_i: one, or for each edge one."""
    x, y = Symbol("x_r", real=True), Symbol("x_i", real=True)
    assert isinstance(of, Cornered | Ellipse)
    u, v = x / of.real, y / of.imag
    if isinstance(of, Cornered):
        # An edge and its opposite are one condition, |p u + q v| > 1.
        return [Abs(p * u + q * v) - 1 for p, q in of.pairs] or [
            p * u + q * v - 1 for p, q in of.edges
        ]
    # With tilt t the ellipse is u^2 - 2 t u v + v^2 = 1 - t^2 in half widths.
    return [u**2 - 2 * of.tilt * u * v + v**2 - (1 - of.tilt**2)]


LONGEST = 120  # operations of a closed form that is written out unasked
_MOST_PARAMETERS = 20  # beyond which groups are many, and take long to prove
_RATIOS = {Part.REAL: "r_r", Part.IMAG: "r_i"}
_SHOWN = dict(
    zip(("Re dH", "Im dH", "r_r", "r_i", "Re(dH/H_env)", "Im(dH/H_env)"), DISTORTION, strict=True)
)
"""Names of quantities, and of the results of ``Steps``."""


def _section(
    title: Phrase, rows: Iterable[doc.Line] = (), notes: Iterable[Phrase] = ()
) -> doc.Section:
    """A heading, sentences that say what the equations mean or what is missing, and these."""
    return Written(list(rows), list(notes)).section(title)


def explained(blocks: Iterable[Block]) -> tuple[Any, ...]:
    """Return blocks whose equations call first harmonics n_p and n_q, defined below the first
    equation that has one; blocks without any are as they were."""
    blocks = tuple(blocks)
    forms = [x.value for x in _equations(blocks) if isinstance(x.value, Expr)]
    harmonics = {x for form in forms for x in form.atoms(Harmonic)}
    if not harmonics:
        return blocks
    taken = {x.name for form in forms for x in form.free_symbols}
    taken |= {x.left.text for x in _equations(blocks) if isinstance(x.left, Name)}
    symbols, definitions = named_harmonics(harmonics, taken)
    waiting = [_defined(*pair) for pair in definitions]

    def renamed(line: doc.Line) -> Iterator[doc.Line]:
        if not isinstance(line.value, Expr) or not line.value.atoms(Harmonic):
            yield line
            return
        yield replace(line, value=line.value.xreplace(symbols))
        yield from waiting
        waiting.clear()

    def changed(block: Block) -> Block:
        if isinstance(block, doc.Section):
            return replace(block, blocks=tuple(map(changed, block.blocks)))
        if isinstance(block, doc.Equations):
            return replace(block, lines=tuple(x for line in block.lines for x in renamed(line)))
        return block

    return tuple(map(changed, blocks))


def _equations(blocks: Iterable[Block]) -> Iterator[doc.Line]:
    """Yield the equations of blocks, also of those within sections."""
    for block in blocks:
        if isinstance(block, doc.Section):
            yield from _equations(block.blocks)
        elif isinstance(block, doc.Equations):
            yield from block.lines


def sections(d: Derivation) -> tuple[doc.Section, ...]:
    """Return the sections that were asked for, or all of them if none was named."""
    if d.of:
        return explained(asked(d, d.of))
    when = _when(d) if d.scene.threshold.is_plain else when_of_region(d)
    found = [
        _dynamics(d),
        _in_steps(d),
        _written_out(d),
        when,
        _changeovers(d),
        *(_dimensionless(d) if d.shows_groups else ()),
        *_slow(d),
        *_fast(d),
    ]
    return explained(section for section in found if section.blocks)


def beyond(d: Derivation) -> tuple[doc.Section, ...]:
    """What closed forms alone do not show: short steps, crossings solved for omega, leading
    terms."""
    found = [
        _in_steps(d),
        *([_solved_in_sections(d)] if d.scene.threshold.is_plain else []),
        *_fast(d),
    ]
    return tuple(
        section for section in found if any(isinstance(x, doc.Equations) for x in section.blocks)
    )


def asked(d: Derivation, names: Iterable[str]) -> tuple[doc.Section, ...]:
    """Return the section of the quantities with these names; raise SceneError for a name that is
    none."""
    written = Written()
    for name in names:
        # Three kinds of names: a derivative of a crossing, a solution, or a quantity in closed
        # form.
        slope = _SLOPE.fullmatch("".join(name.split()))
        key = bare(name)
        if slope:
            written.lines.append(_sensitivity(d, slope[1], slope[2]))
            written.notes += _touches(d, slope[1])
        elif key in _SOLVED:
            written.solve(quantity(_SOLVED[key]), _solutions(d, _SOLVED[key]), named(_SOLVED[key]))
        else:
            written.lines.append(_named(canonical(name), d[name]))
    return (written.section("Formulas"),)


_SLOPE = re.compile(r"domega_([ri])/d([\w.\[\]-]+)")


def _sensitivity(d: Derivation, letter: str, parameter: str) -> doc.Line:
    """d omega/d parameter at a crossing, in omega and the parameters."""
    part, knob = _part(letter), d.scene.knobs[parameter]
    if knob.symbol in d.chain.harmonic_symbols:
        raise SceneError(
            f'"{parameter}" is a size in a describing function: there is no formula for its '
            f"sensitivity; set another value (with_values), and evaluate again"
        )
    if knob.symbol not in d.kept and part not in {*knob.parts} & {*d.kept_thresholds}:
        raise SceneError(
            f'"{parameter}" does not stay a symbol: {", ".join(map(str, d.kept)) or "none does"}'
        )
    above, below = (
        SideBySide((named("d"), named(name))) for name in (f"omega_{letter}", knob.symbol.name)
    )
    return doc.Line(Fraction(above, below), d.sensitivity(part, knob.symbol))


def _part(letter: str) -> Part:
    """Return the part that the letter r or i stands for."""
    return next(part for part, ratio in _RATIOS.items() if ratio[-1] == letter)


def _touches(d: Derivation, letter: str) -> list[Phrase]:
    """Return where the formula of a sensitivity does not hold: at tangencies."""
    # Places are known only where every parameter has a number.
    crossings = (
        d.at().crossings if not any(p.value.free_symbols for p in d.scene.parameters) else ()
    )
    # d omega/dp = -(df/dp)/(df/domega), and df/domega is 0 at a tangency.
    places = [both(x.omega) for x in crossings if x.part is _part(letter) and x.multiplicity > 1]
    at = (", here at ", listed(places)) if places else ""
    said = ": at a crossing. Undefined where the display only touches its threshold", at, "."
    return [("d ", named(f"omega_{letter}"), *said)]


def _solutions(d: Derivation, name: str) -> tuple[Solution, ...]:
    """Return the solutions of a quantity's equation: crossings of a part, or changeovers of a
    system."""
    parts = {"omega_r": Part.REAL, "omega_i": Part.IMAG}
    return d.crossings(parts[name]) if name in parts else d.changeovers(name.removeprefix("omega_"))


def canonical(name: str) -> str:
    """Return the name of a quantity as it is listed; raise SceneError for any other."""
    known = listed_name(name)
    if known is None:
        valid = ", ".join(
            [*QUANTITIES, *_SOLVED.values(), "d omega_r/d PARAMETER", "d omega_i/d PARAMETER"]
        )
        raise SceneError(f'"{name}" is not a quantity: these are {valid}')
    return known


_SOLVED = {bare(name): name for name in ("omega_r", "omega_i", "omega_env", "omega_perc")}
"""Quantities that are solutions of an equation."""


def _defined(symbol: Symbol, value: Expr) -> doc.Line:
    """Return the line that defines a symbol."""
    return doc.Line(layout(symbol), value)


def _named(name: str, value: Expr, relation: str = "=") -> doc.Line:
    """Return the line of a quantity by its name."""
    return doc.Line(quantity(name), value, relation)


def _dynamics(d: Derivation) -> doc.Section:
    """Return the section of H_env and H_perc, and of the order of the effects."""
    chain = " then ".join(e.name for e in d.scene.effects)
    note = (
        f"From the environment to the hand: {chain}."
        if chain
        else "No effects between environment and hand."
    )
    rows = [_named("H_env", d["H_env"])]
    perceived = d["H_perc"] if d.steps.operations <= MOST_STEPS else None
    if perceived is not None and count_ops(perceived) <= LONGEST:
        rows.append(_named("H_perc", perceived))
    return _section("Dynamics", rows, [note])


def _in_steps(d: Derivation) -> doc.Section:
    """Return the section of the distortion in named intermediate steps."""
    return _section(f"Intermediate steps ({d.steps.operations} operations)", step_lines(d.steps))


def step_lines(steps: Steps) -> Iterator[doc.Line]:
    """Yield the steps that the distortion needs, then the quantities in terms of these."""
    named = {name: result for name, result in _SHOWN.items() if result in steps.results}
    shown = steps.only(named.values())
    for symbol, value in shown.definitions:
        yield _defined(symbol, value)
    for name, result in named.items():
        yield _named(name, shown.results[result])


def _elsewhere(d: Derivation, name: str) -> Phrase:
    """Return the end of a sentence: what gives a quantity that is left out, for a distortion, which
    no command line has, in Python."""
    return doc.Brief("; --of prints it" if d.of_scene else f'; derivation["{name}"] has it'), "."


def _written_out(d: Derivation) -> doc.Section:
    """Re dH and Im dH as quotients of polynomials in lowest terms, if they are short."""
    if d.steps.operations > MOST_STEPS:
        way = "--of prints" if d.of_scene else "derivation[name] has"
        option = doc.Brief(f" {way} one of: {', '.join(QUANTITIES)}.")
        return _section("Expanded", notes=[("Closed forms of this chain are long.", option)])
    names = ("Re dH", "Im dH", "|H_env|^2")
    short = [name for name in names if d.operations(name) <= LONGEST]
    notes: list[Phrase] = []
    if long := [name for name in names if name not in short]:
        way = f'--of "{long[0]}" prints' if d.of_scene else f'derivation["{long[0]}"] has'
        what = listed((quantity(name),) for name in long)
        see = doc.Brief(f"; {way} {'one' if len(long) > 1 else 'it'}")
        notes.append((f"Longer than {LONGEST} operations: ", what, see, "."))
    rows = (_named(name, d[name]) for name in short)
    return _section("Expanded, common factors cancelled", rows, notes)


def _when(d: Derivation) -> doc.Section:
    """Return the section of the polynomials p: positive exactly where a ratio exceeds; and of their
    roots."""
    title = "When it is noticed"
    if d.steps.operations > MOST_STEPS:
        return _section(title)
    out = Written(notes=["A ratio exceeds its threshold exactly where its p is positive."])
    for part in Part:
        letter = _RATIOS[part][-1]
        see = _elsewhere(d, f"p_{letter}")
        terms = len(d.excess(part).function.numerator)
        if terms > MOST_TERMS:
            out.notes.append((named(f"p_{letter}"), f" has {terms} terms", see))
            continue
        written = d.excess(part).written
        terms = sum(len(factor) for factor, _ in written.ring.factors(written.numerator)[1])
        # Each term takes an operation at least: so it is known to be too long before SymPy puts it
        # together, which takes seconds.
        if terms > LONGEST:
            out.notes.append((named(f"p_{letter}"), f" has {terms} terms", see))
        elif (operations := count_ops(polynomial := d[f"p_{letter}"])) <= LONGEST:
            out.lines.append(_named(f"p_{letter}", polynomial))
        else:
            out.notes.append((named(f"p_{letter}"), f" takes {operations} operations", see))
        out.solve(quantity(f"omega_{letter}"), d.crossings(part), named(_RATIOS[part]))
    return out.section(title)


def _solved_in_sections(d: Derivation) -> doc.Section:
    """Return the section of the crossings that have a readable formula."""
    out = Written()
    for part in Part if d.steps.operations <= MOST_STEPS else ():
        if len(d.excess(part).function.numerator) <= MOST_TERMS:
            readable = d.crossings(part, readable=True)
            out.solve(quantity(f"omega_{_RATIOS[part][-1]}"), readable, named(_RATIOS[part]))
    return out.section("Crossings, solved")


def _changeovers(d: Derivation) -> doc.Section:
    """Return the section of the frequencies at which Re H changes its sign."""
    found = Written()
    for system in ("env", "perc") if d.steps.operations <= MOST_STEPS else ("env",):
        found.solve(quantity(f"omega_{system}"), d.changeovers(system), named(f"H_{system}"))
    return found.section("Changeover frequencies")


def _dimensionless(d: Derivation) -> Iterator[doc.Section]:
    """Yield the dimensionless groups of the parameters, and the ratios as functions of these."""
    title = "Dimensionless"
    if len(d.scene.parameters) > _MOST_PARAMETERS:
        return
    try:
        groups = d.groups
    except SceneError as error:
        yield _section(title, notes=[f"Not possible: {error}."])
        return
    # A group that is one of the parameters as it was needs no equation.
    named = [x for x in (groups.frequency, *groups.groups) if x.symbol.name != str(x.value)]
    rows = [_defined(group.symbol, group.value) for group in named]
    before, after = (
        _counted(len(x), what)
        for x, what in ((d.scene.parameters, "parameter"), (groups.groups, "group"))
    )
    note = (
        f"{before} and ",
        layout(omega),
        " become ",
        layout(groups.frequency.symbol),
        f" and {after}; H is in units of ",
        layout(groups.stiffness),
        ". The ratios, as functions of these:",
    )
    yield _section(title, rows, [note])
    steps = _in_x(groups, groups.distortion.chain.steps)
    yield _section((), step_lines(steps))


def _counted(n: int, what: str) -> str:
    """Return a number with its noun: ``2 groups``, ``no parameters``."""
    return f"{n or 'no'} {what}{'' if n == 1 else 's'}"


def _in_x(found: Groups, steps: Steps) -> Steps:
    """Return steps in which the frequency is the dimensionless one."""
    return Steps(
        tuple((name, found.forwards(value)) for name, value in steps.definitions),
        {name: found.forwards(value) for name, value in steps.results.items()},
    )


def _fast(d: Derivation) -> Iterator[doc.Section]:
    """Yield the leading terms for fast devices, with proven bounds of what they leave out."""
    if d.steps.operations > MOST_STEPS:
        return
    try:
        expansion = d.expansion()
    except SceneError:
        return
    rows = [
        _named(name, form, "≈")
        for name, part in (("Re dH", Part.REAL), ("Im dH", Part.IMAG))
        if count_ops(form := expansion.part(part)) <= LONGEST
    ]
    if not rows:
        return
    low, high = (cell(ExactNumber(x)) for x in d.scene.band)
    errors = [
        # The upper end of an enclosure of one digit: what is printed is still a bound.
        (f"{x.enclosure(1)[1]} in ", named(_RATIOS[part]))
        for part, x in expansion.bounds.items()
        if x is not None
    ]
    on = " on ", low, " to ", high, "\xa0", FREQUENCY_UNIT, " with the scene's numbers: proven."
    said: Phrase = ("The terms left out change at most ", listed(errors), *on)
    fast = listed((named(x.name), f" {_direction(d, x)}") for x in expansion.fast)
    yield _section(("High-bandwidth approximation: ", fast), rows, [said] if errors else ())


def _slow(d: Derivation) -> Iterator[doc.Section]:
    """Yield stiffness, damping and mass at low frequency of a chain with delays, whose closed form
    is long."""
    if d.steps.operations > MOST_STEPS or not d["H_perc"].has(exp):
        return
    try:
        coefficients = d.distortion.low_frequency
    except SceneError:
        return
    rows = [
        doc.Line(named(name), x)
        for name, x in zip(("k_0", "b_0", "m_0"), coefficients, strict=True)
        if count_ops(x) <= LONGEST
    ]
    said = ("Stiffness, damping and mass at low frequency, of ", named("H_perc"), ":")
    yield _section("Low frequency", rows, [said])


def _direction(d: Derivation, fast: Symbol) -> str:
    """Return whether a device is fast where its parameter is large, or where it is small, as a time
    is."""
    dimension = next(p.dimension for p in d.scene.parameters if p.symbol == fast)
    return "small" if dimension is Dimension.TIME else "large"


_HOW_SURE = (
    "Proven: all equations, by exact algebra; haptisym.verify compares them with independent "
    "evaluations."
)


def page(d: Derivation) -> Document:
    """Return the page of a derivation: the parameters, then the sections."""
    mixed = 0 < len(d.kept) < len(d.scene.parameters)
    # Of a symbol of an expression all is said: it is its own value, and may measure anything.
    told = [
        p for p in d.scene.parameters if p.dimension is not Dimension.ANY or not p.value.is_Symbol
    ]
    shown = table(
        told,
        f"The parameters, in the units of the {'scene' if d.of_scene else 'distortion'}.",
        Field("symbol", lambda p: named(p.symbol.name)),
        Field("quantity", lambda p: _meaning(p, p.shown_unit(d.scene.motion).text)),
        Field(
            "in the scene" if d.of_scene else "value",
            lambda p: layout(p.value / p.shown_unit(d.scene.motion).size),
        ),
        Field("", lambda p: ("kept" if p.symbol in d.kept else "inserted") * mixed),
    )
    blocks = *((shown,) if shown.rows else ()), *sections(d)
    return page_about(d.scene, (), blocks, (_HOW_SURE,), "Derivation", _asides(d))


def latex(d: Derivation) -> str:
    r"""LaTeX for a paper: a paragraph for each section, its equations in an ``align*``; amsmath is
    all it needs."""
    return (
        fragment((*(doc.Paragraph(doc.coded(x)) for x in _asides(d)), *sections(d)), depth=2) + "\n"
    )


def _asides(d: Derivation) -> list[str]:
    """Return the scene's remarks; formulas in symbols hold for all values that vary."""
    kept = any(p.interval for p in d.scene.parameters if p.symbol in d.kept)
    return [
        note + " Formulas in their symbols hold for all values." * kept for note in d.scene.asides()
    ]


def _meaning(p: Parameter, unit: str) -> str:
    """Return what a parameter is, with a unit."""
    plain = p.dimension in (Dimension.ANY, Dimension.RATIO)
    kind = "number" if plain else p.dimension.name.lower()
    return f"{kind}, {unit}" if unit not in ("", "1") else kind


def body(d: Derivation) -> dict[str, Any]:
    """Return what the document of JSON holds of a derivation."""
    return {
        "parameters": [_parameter(d, p) for p in d.scene.parameters],
        "operations": d.steps.operations,
        "sections": [_section_row(section) for section in sections(d)],
        "quantities": list(QUANTITIES),
    }


def _parameter(d: Derivation, p: Parameter) -> dict[str, Any]:
    """Return a parameter as the document of JSON has it."""
    shown = {"text": plain(p.value), "latex": formula(p.value)}
    return {
        "name": p.symbol.name,
        "meaning": _meaning(p, unit_text(p.unit_in(d.scene.motion))),
        "symbol": p.symbol in d.kept,
        "value": shown,
    }


def _section_row(section: doc.Section) -> dict[str, Any]:
    """Return a section as the document of JSON has it: each equation as text, LaTeX and MathML."""
    boxes = [line.equation for line in _equations([section])]
    rows = [{"text": text(e), "latex": tex(e), "mathml": mathml(e)} for e in boxes]
    notes = [
        said(x) for block in section.blocks if isinstance(block, doc.Notes) for x in block.entries
    ]
    return {"title": said(section.title), "notes": notes, "equations": rows}


# A script of SymPy.


_FUNCTIONS = frozenset(dir(sympy)) - {"s"}
_ALWAYS = ("Abs", "I", "Rational", "Symbol", "exp", "pi", "sqrt")
"""Names of SymPy that a script may call, so that no parameter may be called by them."""
_ASSUMED = ("positive", "nonnegative", "real")
_FACTORED = 400  # operations of H_perc up to which it is written in lowest terms


class _Printer(StrPrinter):  # type: ignore[misc]
    """A printer of SymPy expressions as Python, in which fractions stay exact."""

    def _print_Rational(self, x: Expr) -> str:
        # In Python 1/3 is a float.
        return str(x.p) if x.q == 1 else f"Rational({x.p}, {x.q})"

    def _print_Abs(self, x: Expr) -> str:
        # Evaluated, SymPy would multiply out what stands in it.
        return f"Abs({self._print(x.args[0])}, evaluate=False)"


def script(d: Derivation) -> str:
    """The text of the script: run, it defines each symbol and each quantity by its name.

    >>> from haptisym.verbs.derive.derivation import derive
    >>> text = script(derive("delayed-spring"))
    >>> known = {}
    >>> exec(text, known)
    >>> known["H_perc"]
    k*exp(-s*tau)
    """
    return "\n".join(_lines(d)) + "\n"


def _lines(d: Derivation) -> Iterator[str]:
    """Yield the lines of the script: title, imports, symbols, dynamics, steps, results."""
    steps = d.steps.only(DISTORTION)
    perceived = d["H_perc"]
    # A long H_perc is written as the chain builds it: each effect is a two-port with the matrix
    # (a b; c e), through which H becomes (a H + b)/(c H + e).
    if perceived.count_ops() > _FACTORED:
        perceived = d.chain.rendered
        for a, b, c, e in d.chain.matrices:
            perceived = (a * perceived + b) / (c * perceived + e)
    dynamics = {"H_env": d["H_env"], "H_perc": perceived}
    parameters = sorted(steps.free_symbols - {omega} | d.distortion.free_symbols, key=str)
    symbols = [omega, s, *parameters, *(x for x, _ in steps.definitions)]
    # First harmonics get names of their own, defined in functions that SymPy knows.
    put, harmonics = named_harmonics(d.chain.harmonics, [x.name for x in symbols])
    indices = sorted({x for _, value in harmonics for x in value.atoms(Symbol) if x == STEP})
    symbols += [*indices, *(x for x, _ in harmonics)]
    written = [value for _, value in (*harmonics, *steps.definitions)]
    called = {f.func.__name__ for value in written for f in value.atoms(Application, sympy.Sum)}
    # No symbol may have the name of a function that the script calls, or of a result that it
    # defines.
    taken = (*called, *_ALWAYS, *dynamics, *steps.results)
    names = identifiers((x.name for x in symbols), Language.NUMPY, taken)
    named = {x: Symbol(names[x.name]) for x in symbols}

    def text(form: Expr) -> str:
        return str(_Printer().doprint(form.xreplace(put).xreplace(named)))

    rows = [(names[x.name], text(value)) for x, value in steps.definitions]
    rows += [(name, text(value)) for name, value in steps.results.items()]
    above = [(names[x.name], text(value)) for x, value in harmonics]
    above += [(name, text(value)) for name, value in dynamics.items()]
    # What is imported is what the lines use: words that SymPy has and that are no symbol's name.
    words = {word for _, value in (*rows, *above) for word in re.findall(r"[A-Za-z]\w*", value)}
    used = (words & _FUNCTIONS - {*names.values()}) | ({"Dummy"} if indices else set())
    yield f'"""{comment(d.scene.title or "Distortion of a haptic display")}'
    yield from (
        "",
        "H is force per position; s the Laplace variable, omega the frequency in rad/s. SI units.",
        '"""',
    )
    yield from ("", f"from sympy import {', '.join(sorted({*used, 'Symbol'}))}", "")
    for x in (s, omega, *parameters):
        # The strongest assumption alone: positive implies the others.
        assumed = next((f", {a}=True" for a in _ASSUMED if getattr(x, f"is_{a}")), "")
        yield f'{names[x.name]} = Symbol("{comment(x.name)}"{assumed})'
    yield from (f'{names[x.name]} = Dummy("{x.name}")' for x in indices)
    yield ""
    yield from (f"{name} = {value}" for name, value in above)
    yield from (
        "",
        (
            "# Re and Im of dH = H_perc - H_env at s = j omega, over |H_env|, and of dH/H_env: "
            "in named steps"
        ),
    )
    yield from (f"{name} = {value}" for name, value in rows)
