"""The derivation on a page: from the dynamics to the closed forms, the threshold polynomials and what is perceived."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from sympy import Expr, I

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.symbols import omega, s
from haptisym.model.catalogue import Effect
from haptisym.model.jnd import Part
from haptisym.pages.report.results import RATIOS
from haptisym.pages.sections import Phrase, Section, beyond
from haptisym.pages.tex.forms import DIFFERENCE, DYNAMICS, FELT, RELATIVE, Group, SceneForms
from haptisym.pages.tex.forms import RATIOS as RATIO_FORMS
from haptisym.verbs.derive.derivation import derive
from haptisym.writing.boxes import Equation, Operator, Prefixed
from haptisym.writing.equations import function, quantity
from haptisym.writing.htmltext import Html, element, joined
from haptisym.writing.layout import layout
from haptisym.writing.mathematics import Formula, Parts, display, formula, inline
from haptisym.writing.names import named
from haptisym.writing.texlines import LINE, Row, width
from haptisym.writing.texprinter import formula as latex_of


def derivation(forms: SceneForms) -> Html:
    """All steps, each with its heading: dynamics, distortion, thresholds, perceived properties, and what lies beyond them.

    Closed forms stand in symbols; in numbers, rounded where they are long, if they would be too long to read.
    """
    steps = _Steps(forms)
    sections = {
        "Dynamics": steps.dynamics(),
        "Distortion": steps.distortion(),
        "Thresholds": steps.thresholds(),
        "Perceived properties": steps.properties(),
    }
    further = (_section(x) for x in beyond(derive(forms.evaluation.scene)))
    return joined([*(joined([element("h3", title), *parts]) for title, parts in sections.items()), *further])


def _section(section: Section) -> Html:
    """A section of the derivation in symbols: its heading, its words, its equations."""
    heading = [element("h3", *_phrase(section.title))] if section.title else []
    lines = [Formula(x.left, x.value, relation=x.relation) for x in section.equations]
    return joined([*heading, *(element("p", *_phrase(note)) for note in section.notes), display(lines)])


def _phrase(phrase: Phrase) -> list[str | Html]:
    return [x if isinstance(x, str) else inline(x) for x in phrase]


_DIFFERENCE = inline(Prefixed(named("Delta"), named("H")))
_REAL, _IMAG = (inline(Prefixed(Operator(name), named("H"))) for name in ("Re", "Im"))
_H = inline(named("H"))


def _q(name: str) -> Html:
    return inline(quantity(name))


def _said(*parts: str) -> Html:
    return element("p", *parts)


_VALUES = "the scene's values"


@dataclass(frozen=True)
class _Steps:
    """The steps as paragraphs and displays. Named numerators and denominators are shared by all of them."""

    forms: SceneForms
    parts: Parts = field(default_factory=Parts)

    @property
    def evaluation(self) -> Evaluation:
        return self.forms.evaluation

    def dynamics(self) -> Iterator[Html]:
        scene = self.evaluation.scene
        yield _said("Dynamics are force per position, as functions of the Laplace variable ", inline(named("s")), ".")
        formulas = [Formula(quantity("H_env"), scene.environment.dynamics)]
        if scene.rendered:
            yield _said("The controller renders ", _q("H_rendered"), " for ", _q("H_env"), ".")
            formulas.append(Formula(quantity("H_rendered"), scene.rendered.dynamics))
        yield self._display(formulas)
        for i, effect in enumerate(scene.effects, 1):
            words, formulas = _action(i, effect)
            yield _said(f"Effect {i}, {effect.name}, ", *words)
            yield self._display(formulas)
        in_symbols = (self.forms.in_symbols(DYNAMICS) or [])[1:]
        if in_symbols:
            yield _said("Together, nearest the environment first, they make the perceived dynamics" + self._comma())
            yield self._rows(in_symbols)
        if scene.parameters:
            yield _said(f"With {_VALUES} (here and below, long numbers are rounded to six digits after ≈):")
            yield self._rows(self.forms.in_numbers(DYNAMICS))

    def _comma(self) -> str:
        return "" if self.evaluation.scene.effects else ", which are the environment itself"

    def distortion(self) -> Iterator[Html]:
        where = inline(Equation((named("s"), layout(I * omega)), ("=",)))
        yield from self._formulas(["On ", where, " the distortion ", _DIFFERENCE, " has the parts"], DIFFERENCE)
        yield from self._formulas(["The distortion ratios, which the threshold judges, are"], RATIO_FORMS)
        yield from self._formulas(["The relative distortion, not to be confused with them, is"], RELATIVE)
        if self.evaluation.scene.parameters and self.forms.in_symbols(DIFFERENCE):
            yield _said(f"With {_VALUES} the distortion is")
            yield self._rows(self.forms.in_numbers(DIFFERENCE))

    def thresholds(self) -> Iterator[Html]:
        names = {part: function(f"p_{'r' if part is Part.REAL else 'i'}", named("omega")) for part in Part}
        functions = self.evaluation.distortion.squared_modulus.axis.functions
        kind = "polynomials in ω, its powers, sines and cosines" if functions else "polynomials in ω²"
        yield _said(
            "A ratio exceeds its threshold where its square does, and so no root is needed: ", RATIOS[Part.REAL],
            " exceeds exactly where ", inline(names[Part.REAL]), " > 0, and ", RATIOS[Part.IMAG], " exactly where ",
            inline(names[Part.IMAG]), f" > 0. These are {kind} with exact coefficients (to ten digits after ≈), written up to "
            "a positive factor; the crossings are their roots on the band.",
        )  # fmt: skip
        rows = self.forms.named([self.forms.threshold(part) for part in Part])
        yield display([formula(row, left) for row, left in zip(rows, names.values(), strict=True)], self.parts)

    def properties(self) -> Iterator[Html]:
        lead = [
            _REAL, " is felt as stiffness where it is positive and as mass where it is negative, ", _IMAG, " as damping. ",
            "The stiffness, mass and damping perceived are",
        ]  # fmt: skip
        yield from self._formulas(lead, FELT)
        d = self.forms.symbolic
        found = {"env": d.changeover_environment, "perc": d.changeover_perceived} if d else {}
        shown = {name: x for name, x in found.items() if x is not None and width(latex_of(x)) < LINE - 5}
        if shown:
            yield _said("The lowest frequencies of changeover, while they are real and positive, are")
            yield self._display([Formula(quantity(f"omega_{name}"), x) for name, x in shown.items()])

    def _formulas(self, lead: Sequence[str], group: Group) -> Iterator[Html]:
        """Closed forms in symbols; in numbers if they would be too long to read."""
        has_parameters = bool(self.evaluation.scene.parameters)
        in_symbols = self.forms.in_symbols(group) if has_parameters else None
        rows = in_symbols or self.forms.in_numbers(group)
        is_explained = in_symbols or not has_parameters or all(row.optional for row in rows)
        yield _said(*lead, "" if is_explained else f" (with {_VALUES}; too long in symbols)")
        yield self._rows(rows)

    def _rows(self, rows: Iterable[Row]) -> Html:
        return display([formula(row) for row in self.forms.named(list(rows))], self.parts)

    def _display(self, formulas: Iterable[Formula]) -> Html:
        short = self.forms.short_names
        return display([replace(f, value=f.value.xreplace(short)) for f in formulas], self.parts)


def _action(i: int, effect: Effect) -> tuple[list[str], list[Formula]]:
    """What the effect of that number does to H, in words, and the formulas that the words name."""
    a, b, c, d = effect.dynamics
    G, Z, Y = (inline(named(f"{x}_{i}")) for x in "GZY")
    if (b, c, d) == (0, 0, 1):
        return ["multiplies the force by ", G, ":"], [_of_s(f"G_{i}", a)]
    if (a, c, d) == (1, 0, 1):
        return ["adds the impedance ", Z, ":"], [_of_s(f"Z_{i}", b)]
    if (a, b, d) == (1, 0, 1):
        return ["adds the compliance ", Y, " in series:"], [_of_s(f"Y_{i}", c)]
    A, B, C, D = (inline(named(f"{x}_{i}")) for x in "ABCD")
    mapped = joined([_H, " becomes (", A, "\xa0", _H, " + ", B, ")/(", C, "\xa0", _H, " + ", D, ")"])
    return ["is a two-port: ", mapped, ", with"], [
        _of_s(f"{x}_{i}", y) for x, y in zip("ABCD", (a, b, c, d), strict=True)
    ]


def _of_s(name: str, value: Expr) -> Formula:
    return Formula(function(name, layout(s)), value)
