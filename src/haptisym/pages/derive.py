"""A derivation: sections of equations with a sentence between them, for text, LaTeX and MathML; its
page and document.

As a script of SymPy it is its symbols with their assumptions, the dynamics, then the distortion in
named steps.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import sympy
from sympy import Abs, Expr, Function, Integer, Symbol, count_ops, exp
from sympy.printing.str import StrPrinter

from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.regions import Cornered, Ellipse, Joint
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import omega, s
from haptisym.kernel.roots import Lattice, Signed
from haptisym.kernel.solutions import Solution, solve
from haptisym.model.jnd import Part, Shape
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import Dimension, MotionKind, unit_text
from haptisym.pages.words import H_ENV, OMEGA, Field, noted, page_about, region, table
from haptisym.programs.steps import DISTORTION, Steps
from haptisym.verbs.derive.derivation import QUANTITIES, Derivation, Groups, bare, listed_name
from haptisym.writing import document as doc
from haptisym.writing.boxes import Absolute, Box, Fraction, Relation, SideBySide, text
from haptisym.writing.code import Language, comment, identifiers
from haptisym.writing.document import Document, Phrase, listed
from haptisym.writing.latex import formula, fragment, tex
from haptisym.writing.layout import function, layout, named, plain, quantity
from haptisym.writing.mathml import mathml
from haptisym.writing.plain import said

MOST_STEPS = 150  # operations of the steps beyond which closed forms would fill pages
MOST_TERMS = 2000  # above the line of a function that is written, or solved, unasked: SymPy takes a second or two for them


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
        """It below a heading, the words before the equations."""
        equations = (doc.Equations(tuple(self.lines)),) if self.lines else ()
        return doc.Section(title, (*noted(self.notes), *equations))


def answers(left: Box, solutions: Iterable[Solution]) -> tuple[list[doc.Line], list[Phrase]]:
    """The formulas among some solutions, and what to say about the others."""
    rows: list[doc.Line] = []
    notes: list[Phrase] = []
    for x in solutions:
        if x.omega is None:
            what = "a solution is a root of a factor ", *_degree(x.equation)
            notes.append((*what, ": no readable formula; the equation is the result."))
            continue
        rows.append(doc.Line(left, x.omega))
        notes += _in_force(x)
        if x.period:
            notes.append(("so are these plus any multiple of ", layout(x.period), "."))
    return rows, list(dict.fromkeys(notes))


def _in_force(x: Solution) -> list[Phrase]:
    """Under which conditions a formula holds, in words."""
    if not x.conditions:
        return []
    if max(map(count_ops, x.conditions)) > 4:
        return [("a formula holds where it is real and not negative.",)]
    bounds = (Relation((layout(y), layout(Integer(0))), ("≥",)) for y in x.conditions)
    return [("holds where ", listed((x,) for x in bounds), ".")]


def _degree(equation: Expr) -> tuple[Phrase, ...]:
    if not equation.is_polynomial(omega):
        return "in ", OMEGA, " and its sines and cosines"
    return f"of degree {_power(equation)} in ", OMEGA


def _power(x: Expr) -> int:
    """The degree in omega of a polynomial whose sums are collected by its powers: nothing in them
    cancels."""
    if x.is_Pow:
        return int(x.exp) * _power(x.base) if x.base.has(omega) else 0
    if x.is_Add or x.is_Mul:
        return (max if x.is_Add else sum)(map(_power, x.args))
    return int(x == omega)


_LONGEST = 250  # operations of a function that is written out unasked
_MOST = 16  # functions that are
_LARGEST = 200_000  # products of terms of both parts of dH: beyond, what decides takes seconds, then minutes, and nobody reads it


def ways(x: Criterion, found: Signed) -> tuple[Phrase, list[tuple[Box, Signed]]]:
    """Where a criterion is broken, in words, and the functions that these name."""
    terms: Sequence[Sequence[Signed]] = found.terms if isinstance(found, Lattice) else ((found,),)
    names = [
        [_called(x, i, j, terms) for j, _ in enumerate(row, 1)] for i, row in enumerate(terms, 1)
    ]
    said = listed((listed((name, " > 0") for name in row) for row in names), "or")
    what = f"The {x.joint.kind} is left" if x.joint else (named(x.symbol), " exceeds its limit")
    return (what, " exactly where ", said, "."), list(
        zip(chain(*names), chain(*terms), strict=True)
    )


def _called(x: Criterion, i: int, j: int, terms: Sequence[Sequence[Signed]]) -> Box:
    one = len(terms) == 1 and len(terms[0]) == 1
    return function(f"p_{x.name}" if one else f"p_{x.name}_{i}{j}", OMEGA)


def when_of_region(d: Derivation) -> doc.Section:
    """Of a region, or of limits that are formulas in omega: its border, and each function in closed
    form where it is short."""
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
        found = x.function(d.distortion)
        said, functions = ways(x, found)
        out.notes.append(said)
        for name, f in functions:
            form = (
                f.factored()
                if isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS
                else None
            )
            if form is None or count_ops(form) > _LONGEST or len(long) + len(out.lines) >= _MOST:
                long.append(name)
            else:
                out.lines.append(doc.Line(name, form))
        solved, told = _solved(x, found, d)
        out.lines += solved
        out.notes += told
    if not is_short:
        out.notes.append("Closed forms of this chain are long and not expanded here.")
    if long:
        out.notes.append(
            ("Too long to be expanded here: ", listed(long), "; fewer symbols make them shorter.")
        )
    out.notes.append("Its crossings, as numbers: `haptisym evaluate`.")
    return out.section("When it is noticed")


def _is_short(d: Derivation) -> bool:
    """Whether the functions that decide are found at once."""
    if d.steps.operations > MOST_STEPS:
        return False
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
    conditions = [len(term.where) for term in x.region.terms(d.distortion)] if x.region else [0]
    is_one = len(terms) == len(terms[0]) == 1
    lines: list[doc.Line] = []
    notes: list[Phrase] = []
    for i, row in enumerate(terms):
        for j, f in enumerate(row[conditions[i] :], conditions[i] + 1):
            if isinstance(f, RealFunction) and len(f.function.numerator) <= MOST_TERMS:
                place = "" if is_one else f"_{i + 1}{j}"
                own, said = answers(named(f"omega_{x.name}{place}"), solve(f))
                lines += [
                    line for line in own if line.value not in [known.value for known in lines]
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
    return doc.Line(named(name), Fraction(quantity(part), Absolute(H_ENV)))


def _borders(of: Joint) -> list[Expr]:
    """What is positive outside of a region, in x_r and x_i: one, or for each edge one."""
    x, y = Symbol("x_r", real=True), Symbol("x_i", real=True)
    assert isinstance(of, Cornered | Ellipse)
    u, v = x / of.real, y / of.imag
    if isinstance(of, Cornered):
        return [Abs(p * u + q * v) - 1 for p, q in of.pairs] or [
            p * u + q * v - 1 for p, q in of.edges
        ]
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


def sections(d: Derivation) -> tuple[doc.Section, ...]:
    """What a derivation was asked for, or all that it says unasked."""
    if d.of:
        return asked(d, d.of)
    when = _when(d) if d.scene.threshold.is_plain else when_of_region(d)
    found = [
        _dynamics(d),
        _in_steps(d),
        _written_out(d),
        when,
        _changeovers(d),
        *_dimensionless(d),
        *_slow(d),
        *_fast(d),
    ]
    return tuple(section for section in found if section.blocks)


def beyond(d: Derivation) -> tuple[doc.Section, ...]:
    """What closed forms alone do not show: short steps, crossings solved for omega, groups, leading
    terms."""
    found = [
        _in_steps(d),
        *([_solved_in_sections(d)] if d.scene.threshold.is_plain else []),
        *_dimensionless(d),
        *_fast(d),
    ]
    return tuple(
        section for section in found if any(isinstance(x, doc.Equations) for x in section.blocks)
    )


def asked(d: Derivation, names: Iterable[str]) -> tuple[doc.Section, ...]:
    """The quantities with these names, each written out; SceneError for a name that is none."""
    found = Written()
    for name in names:
        slope = _SLOPE.fullmatch("".join(name.split()))
        key = bare(name)
        if slope:
            found.lines.append(_sensitivity(d, slope[1], slope[2]))
            found.notes += _touches(d, slope[1])
        elif key in _SOLVED:
            found.solve(quantity(_SOLVED[key]), _solutions(d, _SOLVED[key]), named(_SOLVED[key]))
        else:
            found.lines.append(_named(canonical(name), d[name]))
    return (found.section("Formulas"),)


_SLOPE = re.compile(r"domega_([ri])/d([\w.\[\]-]+)")


def _sensitivity(d: Derivation, letter: str, parameter: str) -> doc.Line:
    """d omega/d parameter at a crossing, in omega and the parameters."""
    part, knob = _part(letter), d.scene.knobs[parameter]
    if knob.symbol not in d.kept and part not in {*knob.parts} & {*d.kept_thresholds}:
        raise SceneError(
            f'"{parameter}" does not stay a symbol: {", ".join(map(str, d.kept)) or "none does"}'
        )
    above, below = (
        SideBySide((named("d"), named(name))) for name in (f"omega_{letter}", knob.symbol.name)
    )
    return doc.Line(Fraction(above, below), d.sensitivity(part, knob.symbol))


def _part(letter: str) -> Part:
    return next(part for part, ratio in _RATIOS.items() if ratio[-1] == letter)


def _touches(d: Derivation, letter: str) -> list[Phrase]:
    """Where the formula of a sensitivity does not hold."""
    crossings = (
        d.at().crossings if not any(p.value.free_symbols for p in d.scene.parameters) else ()
    )
    places = [
        x.omega.digits(5) for x in crossings if x.part is _part(letter) and x.multiplicity > 1
    ]
    at = f", here at {' and '.join(places)} rad/s" if places else ""
    said = f": at a crossing. Undefined where the display only touches its threshold{at}."
    return [("d ", named(f"omega_{letter}"), said)]


def _solutions(d: Derivation, name: str) -> tuple[Solution, ...]:
    parts = {"omega_r": Part.REAL, "omega_i": Part.IMAG}
    return d.crossings(parts[name]) if name in parts else d.changeovers(name.removeprefix("omega_"))


def canonical(name: str) -> str:
    """The name of a quantity as it is listed; SceneError for any other."""
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
    return doc.Line(layout(symbol), value)


def _named(name: str, value: Expr, relation: str = "=") -> doc.Line:
    return doc.Line(quantity(name), value, relation)


def _dynamics(d: Derivation) -> doc.Section:
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
    return _section(f"Intermediate steps ({d.steps.operations} operations)", _steps(d.steps))


def _steps(steps: Steps) -> Iterator[doc.Line]:
    shown = steps.only(_SHOWN.values())
    for symbol, value in shown.definitions:
        yield _defined(symbol, value)
    for name, result in _SHOWN.items():
        yield _named(name, shown.results[result])


def _written_out(d: Derivation) -> doc.Section:
    """Re dH and Im dH as quotients of polynomials in lowest terms, if they are short."""
    if d.steps.operations > MOST_STEPS:
        note = f"Closed forms of this chain are long. --of prints one of: {', '.join(QUANTITIES)}."
        return _section("Expanded", notes=[note])
    names = ("Re dH", "Im dH", "|H_env|^2")
    short = [name for name in names if d.operations(name) <= LONGEST]
    return _section("Expanded, common factors cancelled", (_named(name, d[name]) for name in short))


def _when(d: Derivation) -> doc.Section:
    title = "When it is noticed"
    if d.steps.operations > MOST_STEPS:
        return _section(title)
    found = Written(notes=["A ratio exceeds its threshold exactly where its p is positive."])
    for part in Part:
        letter = _RATIOS[part][-1]
        terms = len(d.excess(part).function.numerator)
        if terms > MOST_TERMS:
            found.notes.append((named(f"p_{letter}"), f" has {terms} terms; --of prints it."))
            continue
        written = d.excess(part).written
        terms = sum(len(factor) for factor, _ in written.ring.factors(written.numerator)[1])
        if (
            terms > LONGEST
        ):  # each takes an operation at least; to put them together in SymPy takes seconds
            found.notes.append((named(f"p_{letter}"), f" has {terms} terms; --of prints it."))
        elif (operations := count_ops(polynomial := d[f"p_{letter}"])) <= LONGEST:
            found.lines.append(_named(f"p_{letter}", polynomial))
        else:
            found.notes.append(
                (named(f"p_{letter}"), f" takes {operations} operations; --of prints it.")
            )
        found.solve(quantity(f"omega_{letter}"), d.crossings(part), named(_RATIOS[part]))
    return found.section(title)


def _solved_in_sections(d: Derivation) -> doc.Section:
    """The crossings that have a readable formula."""
    found = Written()
    for part in Part if d.steps.operations <= MOST_STEPS else ():
        if len(d.excess(part).function.numerator) <= MOST_TERMS:
            readable = d.crossings(part, readable=True)
            found.solve(quantity(f"omega_{_RATIOS[part][-1]}"), readable, named(_RATIOS[part]))
    return found.section("Crossings, solved")


def _changeovers(d: Derivation) -> doc.Section:
    found = Written()
    for system in ("env", "perc") if d.steps.operations <= MOST_STEPS else ("env",):
        found.solve(quantity(f"omega_{system}"), d.changeovers(system), named(f"H_{system}"))
    return found.section("Changeover frequencies")


def _dimensionless(d: Derivation) -> Iterator[doc.Section]:
    title = "Dimensionless"
    if len(d.scene.parameters) > _MOST_PARAMETERS:
        return
    try:
        found = d.groups
    except SceneError as error:
        yield _section(title, notes=[f"Not possible: {error}."])
        return
    named = [
        x for x in (found.frequency, *found.groups) if x.symbol.name != str(x.value)
    ]  # what stays is not told
    rows = [_defined(group.symbol, group.value) for group in named]
    before, after = (
        _counted(len(x), what)
        for x, what in ((d.scene.parameters, "parameter"), (found.groups, "group"))
    )
    note = (
        f"{before} and ",
        layout(omega),
        " become ",
        layout(found.frequency.symbol),
        f" and {after}; H is in units of ",
        layout(found.stiffness),
        ". The ratios, as functions of these:",
    )
    yield _section(title, rows, [note])
    steps = _in_x(found, found.chain.at(found.values).steps)
    yield _section((), _steps(steps))


def _counted(n: int, what: str) -> str:
    return f"{n or 'no'} {what}{'' if n == 1 else 's'}"


def _in_x(found: Groups, steps: Steps) -> Steps:
    return Steps(
        tuple((name, found.forwards(value)) for name, value in steps.definitions),
        {name: found.forwards(value) for name, value in steps.results.items()},
    )


def _fast(d: Derivation) -> Iterator[doc.Section]:
    if d.steps.operations > MOST_STEPS:
        return
    try:
        found = d.expansion()
    except SceneError:
        return
    rows = [
        _named(name, form, "≈")
        for name, part in (("Re dH", Part.REAL), ("Im dH", Part.IMAG))
        if count_ops(form := found.part(part)) <= LONGEST
    ]
    if not rows:
        return
    low, high = (layout(x) for x in d.scene.band)
    errors = [
        (f"{x.enclosure(1)[1]} in ", named(_RATIOS[part]))
        for part, x in found.bounds.items()
        if x is not None
    ]
    on = " on ", low, " to ", high, " rad/s with the scene's numbers: proven."
    said: Phrase = ("The terms left out change at most ", listed(errors), *on)
    fast = listed((named(x.name), f" {_direction(d, x)}") for x in found.fast)
    yield _section(("High-bandwidth approximation: ", fast), rows, [said] if errors else ())


def _slow(d: Derivation) -> Iterator[doc.Section]:
    """Of a chain with delays, whose closed form is long: what authors print of it."""
    if d.steps.operations > MOST_STEPS or not d["H_perc"].has(exp):
        return
    try:
        found = d.distortion.low_frequency
    except SceneError:
        return
    rows = [
        doc.Line(named(name), x)
        for name, x in zip(("k_0", "b_0", "m_0"), found, strict=True)
        if count_ops(x) <= LONGEST
    ]
    said = ("Stiffness, damping and mass at low frequency, of ", named("H_perc"), ":")
    yield _section("Low frequency", rows, [said])


def _direction(d: Derivation, fast: Symbol) -> str:
    dimension = next(p.dimension for p in d.scene.parameters if p.symbol == fast)
    return "small" if dimension is Dimension.TIME else "large"


_HOW_SURE = (
    "Proven: all equations, by exact algebra; haptisym.verify compares them with independent "
    "evaluations."
)


def page(d: Derivation) -> Document:
    """The parameters, and the sections."""
    mixed = 0 < len(d.kept) < len(d.scene.parameters)
    shown = table(
        d.scene.parameters,
        "The parameters, in SI units.",
        Field("symbol", lambda p: named(p.symbol.name)),
        Field("quantity", lambda p: _meaning(p, d.scene.motion)),
        Field("in the scene", lambda p: layout(p.value)),
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
    """That parameters vary, and what of the formulas holds for all of their values."""
    kept = any(p.interval for p in d.scene.parameters if p.symbol in d.kept)
    return [
        note + " Formulas in their symbols hold for all values." * kept for note in d.scene.asides()
    ]


def _meaning(p: Parameter, motion: MotionKind | None) -> str:
    plain, unit = p.dimension in (Dimension.ANY, Dimension.RATIO), p.unit_in(motion)
    kind = "number" if plain else p.dimension.name.lower()
    return f"{kind}, {unit_text(unit)}" if unit not in ("", "1") else kind


def body(d: Derivation) -> dict[str, Any]:
    """What its document holds."""
    return {
        "parameters": [_parameter(d, p) for p in d.scene.parameters],
        "operations": d.steps.operations,
        "sections": [_section_row(section) for section in sections(d)],
        "quantities": list(QUANTITIES),
    }


def _parameter(d: Derivation, p: Parameter) -> dict[str, Any]:
    shown = {"text": plain(p.value), "latex": formula(p.value)}
    return {
        "name": p.symbol.name,
        "meaning": _meaning(p, d.scene.motion),
        "symbol": p.symbol in d.kept,
        "value": shown,
    }


def _section_row(section: doc.Section) -> dict[str, Any]:
    boxes = [line.equation for line in lines_of(section)]
    rows = [{"text": text(e), "latex": tex(e), "mathml": mathml(e)} for e in boxes]
    notes = [
        said(x) for block in section.blocks if isinstance(block, doc.Notes) for x in block.entries
    ]
    return {"title": said(section.title), "notes": notes, "equations": rows}


def lines_of(section: doc.Section) -> Iterator[doc.Line]:
    """The equations of a section."""
    return (
        line for block in section.blocks if isinstance(block, doc.Equations) for line in block.lines
    )


# A script of SymPy.


_FUNCTIONS = frozenset(dir(sympy)) - {"s"}
_ALWAYS = (
    "Abs",
    "I",
    "Rational",
    "Symbol",
    "exp",
    "pi",
    "sqrt",
)  # what a script may call, whatever its names
_ASSUMED = ("positive", "nonnegative", "real")
_FACTORED = 400  # operations of H_perc up to which it is written in lowest terms


class _Printer(StrPrinter):  # type: ignore[misc]
    """Fractions stay exact where Python would divide them."""

    def _print_Rational(self, x: Expr) -> str:
        return str(x.p) if x.q == 1 else f"Rational({x.p}, {x.q})"

    def _print_Abs(self, x: Expr) -> str:
        return f"Abs({self._print(x.args[0])}, evaluate=False)"  # or SymPy multiplies out what stands in it


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
    steps = d.steps.only(DISTORTION)
    perceived = d["H_perc"]
    if perceived.count_ops() > _FACTORED:  # as the chain builds it
        perceived = d.chain.rendered
        for a, b, c, e in d.chain.matrices:
            perceived = (a * perceived + b) / (c * perceived + e)
    dynamics = {"H_env": d["H_env"], "H_perc": perceived}
    own = sorted(steps.free_symbols - {omega} | d.distortion.free_symbols, key=str)
    every = [omega, s, *own, *(x for x, _ in steps.definitions)]
    called = {f.func.__name__ for _, value in steps.definitions for f in value.atoms(Function)}
    taken = (*called, *_ALWAYS, *dynamics, *steps.results)
    names = identifiers((x.name for x in every), Language.NUMPY, taken)
    named = {x: Symbol(names[x.name]) for x in every}

    def text(form: Expr) -> str:
        return str(_Printer().doprint(form.xreplace(named)))

    rows = [(names[x.name], text(value)) for x, value in steps.definitions]
    rows += [(name, text(value)) for name, value in steps.results.items()]
    above = [(name, text(value)) for name, value in dynamics.items()]
    words = {word for _, value in (*rows, *above) for word in re.findall(r"[A-Za-z]\w*", value)}
    used = words & _FUNCTIONS - {*names.values()}
    yield f'"""{comment(d.scene.title or "Distortion of a haptic display")}'
    yield from (
        "",
        "H is force per position; s the Laplace variable, omega the frequency in rad/s. SI units.",
        '"""',
    )
    yield from ("", f"from sympy import {', '.join(sorted({*used, 'Symbol'}))}", "")
    for x in (s, omega, *own):
        assumed = next((f", {a}=True" for a in _ASSUMED if getattr(x, f"is_{a}")), "")
        yield f'{names[x.name]} = Symbol("{comment(x.name)}"{assumed})'
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
