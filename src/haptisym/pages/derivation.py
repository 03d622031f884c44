"""The derivation in an evaluation's report: from the dynamics to closed forms, threshold polynomials and what is perceived."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from sympy import Expr, I

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.rings import omega, s
from haptisym.model.catalogue import Effect
from haptisym.model.jnd import Part
from haptisym.pages.scene import DIFFERENCE, DYNAMICS, FELT, RELATIVE, FormulaGroup, SceneForms
from haptisym.pages.scene import RATIO_FORMS as RATIO_FORMS
from haptisym.pages.sections import beyond, ways
from haptisym.pages.words import CHANGE, H_ENV, H_PERC, OPERATORS, RATIOS
from haptisym.verbs.derive.derivation import derive
from haptisym.writing.boxes import Box, Equation, Prefixed, Sum
from haptisym.writing.document import Block, Equations, Line, Paragraph, Phrase, Section, listed
from haptisym.writing.equations import function, quantity
from haptisym.writing.latex import LINE, formula, is_long, width
from haptisym.writing.layout import layout, named

_H = named("H")
_VALUES = "the scene's values"
_MOST_POLYNOMIALS = 12


def derivation(forms: SceneForms) -> Iterator[Block]:
    """All steps, each below its heading, and what lies beyond them: short steps, crossings solved for omega, groups.

    Closed forms stand in symbols; in numbers, rounded where they are long, if they would be too long to read.
    """
    steps = _Steps(forms)
    yield Section("Dynamics", tuple(steps.dynamics()))
    yield Section("Distortion", tuple(steps.distortion()))
    yield Section("Threshold polynomials", tuple(steps.thresholds()))
    yield Section("Perceived properties", tuple(steps.properties()))
    yield from filter(_is_readable, beyond(derive(forms.evaluation.scene)))


def _is_readable(section: Section) -> bool:
    """Whether no formula of a section holds numbers or sums that nobody reads."""
    lines = [line for x in section.blocks if isinstance(x, Equations) for line in x.lines]
    return not any(is_long(line.value) for line in lines)


@dataclass(frozen=True)
class _Steps:
    """The steps as paragraphs and equations."""

    forms: SceneForms

    @property
    def evaluation(self) -> Evaluation:
        return self.forms.evaluation

    def dynamics(self) -> Iterator[Block]:
        scene = self.evaluation.scene
        yield Paragraph(("Dynamics are force per position, as functions of the Laplace variable ", named("s"), "."))
        lines = [Line(quantity("H_env"), scene.environment.dynamics)]
        if scene.rendered:
            yield Paragraph(("The controller renders ", quantity("H_rendered"), " for ", quantity("H_env"), "."))
            lines.append(Line(quantity("H_rendered"), scene.rendered.dynamics))
        said = []
        for i, effect in enumerate(scene.effects, 1):
            words, entries = _action(i, effect)
            said.append((f"Effect {i}, {effect.name}, ", words, ". "))
            lines += entries
        if said:
            yield Paragraph(tuple(said))
        yield self._equations([*lines, *(self.forms.in_symbols(DYNAMICS) or [])[1:]])
        if scene.parameters:
            yield Paragraph(f"With {_VALUES} (here and below, long numbers are rounded to six digits after ≈):")
            yield self._equations(self.forms.in_numbers(DYNAMICS))

    def distortion(self) -> Iterator[Block]:
        where = Equation((named("s"), layout(I * omega)), ("=",))
        change = Equation((CHANGE, Sum(((1, H_PERC), (-1, H_ENV)))), ("=",))
        yield from self._formulas(("On ", where, " the distortion ", change, " has the parts"), DIFFERENCE)
        yield from self._formulas("The distortion ratios, which the threshold judges, are", RATIO_FORMS)
        yield from self._formulas("The relative distortion, not to be confused with them, is", RELATIVE)
        if self.evaluation.scene.parameters and self.forms.in_symbols(DIFFERENCE):
            yield Paragraph(f"With {_VALUES} the distortion is")
            yield self._equations(self.forms.in_numbers(DIFFERENCE))

    def thresholds(self) -> Iterator[Block]:
        if not self.evaluation.scene.threshold.is_plain:
            yield from self._regions()
            return
        functions = self.evaluation.distortion.squared_modulus.axis.functions
        kind = "polynomials in ω, its powers, sines and cosines" if functions else "polynomials in ω²"
        exceeds = listed((RATIOS[part], " exceeds exactly where ", _excess(part), " > 0") for part in Part)
        yield Paragraph((
            "A ratio exceeds its threshold where its square does, and so no root is needed: ", exceeds, f". These are {kind} ",
            "with exact coefficients (to ten digits after ≈); the crossings are their roots on the band. Written up to a ",
            "positive factor:",
        ))  # fmt: skip
        yield self._equations([self.forms.threshold(part) for part in Part])

    def _regions(self) -> Iterator[Block]:
        """Of what is judged by a region or by a formula in omega: which functions must not all be positive."""
        said: list[Phrase] = []
        lines: list[Line] = []
        for x in self.evaluation.criteria:
            found = x.function(self.evaluation.distortion)
            where, functions = ways(x, found)
            said += [where, " "]
            moves = bool(x.joint) and not self.evaluation.scene.threshold.is_constant  # corners may change sign
            singles = ((name, f) for name, f in functions if isinstance(f, RealFunction))
            lines += [self.forms.polynomial(name, _whole(f) if moves else f) for name, f in singles]
        if len(lines) > _MOST_POLYNOMIALS:
            yield Paragraph(f"{len(lines)} functions of ω decide what is noticed: too many to be written here.")
            return
        yield Paragraph((*said, "Written up to a positive factor (to ten digits after ≈):"))
        yield self._equations(lines)

    def properties(self) -> Iterator[Block]:
        real, imag = (Prefixed(OPERATORS[part], _H) for part in Part)
        lead = (
            real, " is felt as stiffness where it is positive and as mass where it is negative, ", imag, " as damping. The ",
            "stiffness, mass and damping perceived are",
        )  # fmt: skip
        yield from self._formulas(lead, FELT)
        d = self.forms.symbolic
        found = {"env": d.changeover_environment, "perc": d.changeover_perceived} if d else {}
        shown = {name: x for name, x in found.items() if x is not None and width(formula(x)) < LINE - 5}
        if shown:
            yield Paragraph("The lowest frequencies of changeover, while they are real and positive, are")
            yield self._equations([Line(quantity(f"omega_{name}"), x) for name, x in shown.items()])

    def _formulas(self, lead: Phrase, group: FormulaGroup) -> Iterator[Block]:
        """Closed forms in symbols; in numbers if they would be too long to read."""
        has_parameters = bool(self.evaluation.scene.parameters)
        in_symbols = self.forms.in_symbols(group) if has_parameters else None
        lines = in_symbols or self.forms.in_numbers(group)
        is_explained = in_symbols or not has_parameters or all(x.optional for x in lines)
        yield Paragraph(lead if is_explained else (lead, f" (with {_VALUES}; too long in symbols)"))
        yield self._equations(lines)

    def _equations(self, lines: Iterable[Line]) -> Block:
        return Equations(tuple(self.forms.named(list(lines))))


def _whole(f: RealFunction) -> RealFunction:
    """A polynomial of the sign of a function, whatever that of its denominator."""
    return RealFunction(f.axis.function(f.function.numerator * f.function.denominator))


def _excess(part: Part) -> Box:
    return quantity("p_r" if part is Part.REAL else "p_i")


def _action(i: int, effect: Effect) -> tuple[Phrase, list[Line]]:
    """What the effect of that number does to H, in words, and the formulas that the words name."""
    a, b, c, d = effect.dynamics
    if effect.renders:
        words = (f"renders it with a clock ({effect.setting('method')}): ", _H, " becomes ", named(f"G_{i}"), " (", _H)
        return (*words, " + ", named(f"Z_{i}"), ")"), [_of_s("Z", i, b / a), _of_s("G", i, a)]
    names = {x: named(f"{x}_{i}") for x in "GZYABCD"}
    if (b, c, d) == (0, 0, 1):
        return ("multiplies the force by ", names["G"]), [_of_s("G", i, a)]
    if (a, c, d) == (1, 0, 1):
        return ("adds the impedance ", names["Z"]), [_of_s("Z", i, b)]
    if (a, b, d) == (1, 0, 1):
        return ("adds the compliance ", names["Y"], " in series"), [_of_s("Y", i, c)]
    above, below = ((names[x], "\xa0", _H, " + ", names[y]) for x, y in ("AB", "CD"))
    mapped = (_H, " becomes (", above, ")/(", below, ")")
    return ("is a two-port: ", mapped), [_of_s(x, i, y) for x, y in zip("ABCD", effect.dynamics, strict=True)]


def _of_s(letter: str, i: int, value: Expr) -> Line:
    return Line(function(f"{letter}_{i}", layout(s)), value)
