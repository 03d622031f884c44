"""A derivation as a person reads it: sections of equations with a word between them, the same for text, LaTeX and MathML."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from sympy import Expr, Symbol, count_ops, exp

from haptisym.kernel.errors import SceneError
from haptisym.kernel.solutions import Solution
from haptisym.kernel.symbols import omega
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.pages import regionforms
from haptisym.pages.solved import MOST_STEPS, MOST_TERMS, Written
from haptisym.programs.steps import DISTORTION, Steps
from haptisym.verbs.derive.derivation import QUANTITIES, Derivation, bare, listed_name
from haptisym.verbs.derive.groups import Groups
from haptisym.writing.boxes import Fraction, Product
from haptisym.writing.document import Equations, Line, Phrase, Section, listed
from haptisym.writing.equations import quantity
from haptisym.writing.layout import layout
from haptisym.writing.names import named

LONGEST = 120  # operations of a closed form that is written out unasked
_MOST_PARAMETERS = 20  # beyond which groups are many, and take long to prove
_RATIOS = {Part.REAL: "r_r", Part.IMAG: "r_i"}
_SHOWN = dict(zip(("Re dH", "Im dH", "r_r", "r_i", "Re(dH/H_env)", "Im(dH/H_env)"), DISTORTION, strict=True))
"""Names of quantities, and of the results of ``Steps``."""


def _section(title: Phrase, rows: Iterable[Line] = (), notes: Iterable[Phrase] = ()) -> Section:
    """A heading, sentences that say what the equations mean or what is missing, and these."""
    return Written(list(rows), list(notes)).section(title)


def sections(d: Derivation) -> tuple[Section, ...]:
    """What a derivation was asked for, or all that it says unasked."""
    if d.of:
        return asked(d, d.of)
    when = _when(d) if d.scene.threshold.is_plain else regionforms.when(d)
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


def beyond(d: Derivation) -> tuple[Section, ...]:
    """What closed forms alone do not show: short steps, crossings solved for omega, groups, leading terms."""
    found = [_in_steps(d), *([_solved(d)] if d.scene.threshold.is_plain else []), *_dimensionless(d), *_fast(d)]
    return tuple(section for section in found if any(isinstance(x, Equations) for x in section.blocks))


def asked(d: Derivation, names: Iterable[str]) -> tuple[Section, ...]:
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


def _sensitivity(d: Derivation, letter: str, parameter: str) -> Line:
    """d omega/d parameter at a crossing, in omega and the parameters."""
    part, knob = _part(letter), d.scene.knobs[parameter]
    if knob.symbol not in d.kept and part not in {*knob.parts} & {*d.kept_thresholds}:
        raise SceneError(f'"{parameter}" does not stay a symbol: {", ".join(map(str, d.kept)) or "none does"}')
    above, below = (Product((named("d"), named(name))) for name in (f"omega_{letter}", knob.symbol.name))
    return Line(Fraction(above, below), d.sensitivity(part, knob.symbol))


def _part(letter: str) -> Part:
    return next(part for part, ratio in _RATIOS.items() if ratio[-1] == letter)


def _touches(d: Derivation, letter: str) -> list[Phrase]:
    """Where the formula of a sensitivity does not hold."""
    crossings = d.at().crossings if not any(p.value.free_symbols for p in d.scene.parameters) else ()
    places = [x.omega.digits(5) for x in crossings if x.part is _part(letter) and x.multiplicity > 1]
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
        valid = ", ".join([*QUANTITIES, *_SOLVED.values(), "d omega_r/d PARAMETER", "d omega_i/d PARAMETER"])
        raise SceneError(f'"{name}" is not a quantity: these are {valid}')
    return known


_SOLVED = {bare(name): name for name in ("omega_r", "omega_i", "omega_env", "omega_perc")}
"""Quantities that are solutions of an equation."""


def _defined(symbol: Symbol, value: Expr) -> Line:
    return Line(layout(symbol), value)


def _named(name: str, value: Expr, relation: str = "=") -> Line:
    return Line(quantity(name), value, relation)


def _dynamics(d: Derivation) -> Section:
    chain = " then ".join(e.name for e in d.scene.effects)
    note = f"From the environment to the hand: {chain}." if chain else "Nothing stands between environment and hand."
    rows = [_named("H_env", d["H_env"])]
    perceived = d["H_perc"] if d.steps.operations <= MOST_STEPS else None
    if perceived is not None and count_ops(perceived) <= LONGEST:
        rows.append(_named("H_perc", perceived))
    return _section("Dynamics", rows, [note])


def _in_steps(d: Derivation) -> Section:
    return _section(f"In steps ({d.steps.operations} operations in all)", _steps(d.steps))


def _steps(steps: Steps) -> Iterator[Line]:
    shown = steps.only(_SHOWN.values())
    for symbol, value in shown.definitions:
        yield _defined(symbol, value)
    for name, result in _SHOWN.items():
        yield _named(name, shown.results[result])


def _written_out(d: Derivation) -> Section:
    """Re dH and Im dH as quotients of polynomials in lowest terms, if they are short."""
    if d.steps.operations > MOST_STEPS:
        note = f"Closed forms of this chain are long. Ask for one by its name: {', '.join(QUANTITIES)}."
        return _section("Written out", notes=[note])
    names = ("Re dH", "Im dH", "|H_env|^2")
    short = [name for name in names if d.operations(name) <= LONGEST]
    return _section("Written out, in lowest terms", (_named(name, d[name]) for name in short))


def _when(d: Derivation) -> Section:
    title = "When it is noticed"
    if d.steps.operations > MOST_STEPS:
        return _section(title)
    found = Written(notes=["A ratio exceeds its threshold exactly where its p is positive."])
    for part in Part:
        letter = _RATIOS[part][-1]
        terms = len(d.excess(part).function.numerator)
        if terms > MOST_TERMS:
            found.notes.append((named(f"p_{letter}"), f" has {terms} terms; ask for it by its name."))
            continue
        polynomial = d[f"p_{letter}"]
        if count_ops(polynomial) <= LONGEST:
            found.lines.append(_named(f"p_{letter}", polynomial))
        else:
            long = f" takes {count_ops(polynomial)} operations; ask for it by its name."
            found.notes.append((named(f"p_{letter}"), long))
        found.solve(quantity(f"omega_{letter}"), d.crossings(part), named(_RATIOS[part]))
    return found.section(title)


def _solved(d: Derivation) -> Section:
    """The crossings that have a readable formula."""
    found = Written()
    for part in Part if d.steps.operations <= MOST_STEPS else ():
        if len(d.excess(part).function.numerator) <= MOST_TERMS:
            readable = [x for x in d.crossings(part) if x.omega is not None]
            found.solve(quantity(f"omega_{_RATIOS[part][-1]}"), readable, named(_RATIOS[part]))
    return found.section("Crossings, solved")


def _changeovers(d: Derivation) -> Section:
    found = Written()
    for system in ("env", "perc") if d.steps.operations <= MOST_STEPS else ("env",):
        found.solve(quantity(f"omega_{system}"), d.changeovers(system), named(f"H_{system}"))
    return found.section("Where spring and inertia change over")


def _dimensionless(d: Derivation) -> Iterator[Section]:
    title = "Without dimensions"
    if len(d.scene.parameters) > _MOST_PARAMETERS:
        return
    try:
        found = d.groups
    except SceneError as error:
        yield _section(title, notes=[f"Not possible: {error}."])
        return
    named = [x for x in (found.frequency, *found.groups) if x.symbol.name != str(x.value)]  # what stays is not told
    rows = [_defined(group.symbol, group.value) for group in named]
    before, after = (_counted(len(x), what) for x, what in ((d.scene.parameters, "parameter"), (found.groups, "group")))
    note = (
        f"{before} and ", layout(omega), " become ", layout(found.frequency.symbol), f" and {after}; H is in units of ",
        layout(found.stiffness), ". The ratios, as functions of these:",
    )  # fmt: skip
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


def _fast(d: Derivation) -> Iterator[Section]:
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
    errors = [(f"{x.enclosure(1)[1]} in ", named(_RATIOS[part])) for part, x in found.bounds.items() if x is not None]
    on = " on ", low, " to ", high, " rad/s with the scene's numbers: proven."
    said: Phrase = ("What is left out makes at most ", listed(errors), *on)
    fast = listed((named(x.name), f" {_direction(d, x)}") for x in found.fast)
    yield _section(("Fast devices: ", fast), rows, [said] if errors else ())


def _slow(d: Derivation) -> Iterator[Section]:
    """Of a chain with delays, whose closed form is long: what authors print of it."""
    if d.steps.operations > MOST_STEPS or not d["H_perc"].has(exp):
        return
    try:
        found = d.distortion.low_frequency
    except SceneError:
        return
    rows = [
        Line(named(name), x) for name, x in zip(("k_0", "b_0", "m_0"), found, strict=True) if count_ops(x) <= LONGEST
    ]
    said = ("What a slow hand feels, stiffness, damping and mass of ", named("H_perc"), " at rest:")
    yield _section("Slow motion", rows, [said])


def _direction(d: Derivation, fast: Symbol) -> str:
    dimension = next(p.dimension for p in d.scene.parameters if p.symbol == fast)
    return "small" if dimension is Dimension.TIME else "large"
