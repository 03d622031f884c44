"""A scene on a page: the chain, the parameters, the band, and its closed forms.

A scene on a page: the chain from the environment to the hand, the parameters, the band and the threshold.

The closed forms of a scene: in symbols where a person would read them, in numbers, rounded where these are long.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import comb, prod
from types import MappingProxyType
from typing import NamedTuple

from sympy import Abs, Add, Expr, Function, I, Mul, Pow, S, Symbol, pi

from haptisym.judge.crossings import noticed, opened
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.dynamics import RealFunction, on_axis
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, omega, s
from haptisym.kernel.roots import sign_of_number
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, Shape, Threshold, is_irrational_algebraic
from haptisym.model.parameters import values
from haptisym.model.quantities import Dimension, MotionKind, unit_text
from haptisym.model.scene import Knob, Scene
from haptisym.pages.closedforms import ClosedForms
from haptisym.pages.words import H_ENV, H_PERC, both, page_about, region
from haptisym.writing.boxes import Absolute, Box, Equation
from haptisym.writing.document import Block, Column, Document, Flow, Line, Paragraph, Phrase, Strong, Table
from haptisym.writing.equations import quantity
from haptisym.writing.latex import formula, is_long
from haptisym.writing.layout import approximate, layout, named, rounded
from haptisym.writing.mathtext import plain

_AS_THEY_ARE: Mapping[Symbol, Symbol] = MappingProxyType({})


def page(scene: Scene) -> Document:
    """A scene as a notebook shows it."""
    return page_about(scene, (), scene_blocks(scene), ())


def scene_blocks(scene: Scene, short_names: Mapping[Symbol, Symbol] = _AS_THEY_ARE) -> Iterator[Block]:
    """The chain, the table of parameters, and what is judged; ``short_names`` : other symbols for parameters."""
    hand = (Strong("hand"), " feels ", H_PERC)
    yield Flow((*(_link(place, part) for place, part in scene.elements()), hand))
    rows = tuple(_parameter(scene, short_names, x) for x in scene.parameters)
    if rows:
        columns = ("symbol", "of", "parameter", "quantity", "value", "unit")
        yield Table(tuple(Column(x, number=x == "value") for x in columns), rows, "The parameters, in SI units.")
    low, high = (both(ExactNumber(x)) for x in scene.band)
    yield Paragraph(("The band of interest goes from ", low, " to ", high, ". ", noticeable(scene.threshold)))


def noticeable(c: Threshold) -> Phrase:
    """Which changes are noticed, in a sentence."""
    if c.is_plain:
        return (
            "A change of the real or the imaginary part is noticed when it exceeds the fraction ", threshold(c), " of ",
            Absolute(H_ENV), ".",
        )  # fmt: skip
    if c.region.shape is Shape.SQUARE:
        return "A change of the real or the imaginary part is noticed when it exceeds ", region(c), "."
    return "A change, both parts together, is noticed when it leaves the region: ", region(c), "."


def threshold(c: Threshold) -> Phrase:
    """``c = 0.1``, or the thresholds of both parts where they differ; the region in words where it is none of that."""
    if not c.is_plain:
        return region(c)
    if c.real == c.imag:
        return _equality("c", c.real)
    return _equality("c_real", c.real), " (real) or ", _equality("c_imag", c.imag), " (imaginary)"


def _equality(name: str, value: Expr) -> Phrase:
    """``c = 0.1``, or with ≈ where the number is not rational and was rounded."""
    decimal = value.evalf(6) if is_irrational_algebraic(value) else value if value.is_Rational else rounded(value)
    return Equation((named(name), layout(decimal)), ("=" if value.is_Rational else "≈",))


def _link(place: str, part: Environment | Effect) -> Phrase:
    catalogue = ENVIRONMENTS if isinstance(part, Environment) else EFFECTS
    name = place.removeprefix("effects.")
    about = catalogue[part.model].summary.partition(":")[0].rstrip(".")
    return Strong(name), f" ({about if name == part.model else f'{part.model}: {about}'})"


def _parameter(scene: Scene, short_names: Mapping[Symbol, Symbol], p: Knob) -> tuple[Phrase, ...]:
    quantity = "" if p.dimension is Dimension.ANY else p.dimension.name.lower()
    own = unit_text(p.unit_in(scene.motion or MotionKind.TRANSLATION))
    symbol = named(short_names.get(p.symbol, p.symbol).name)
    places = ", ".join(x.removeprefix("effects.").rpartition(".")[0] for x in p.paths)
    return symbol, places, p.key, quantity, _value(p.value), own or "SI"


def _value(value: Expr) -> Phrase:
    """The exact value; a decimal beside it, or instead of it, where that says more."""
    if value.free_symbols:
        return layout(value)
    if value.is_Rational:
        return plain(value) if len(f"{value.p}{value.q}") <= 16 else f"≈ {plain(rounded(value))}"
    return Equation((layout(value), layout(rounded(value))), ("≈",))


class FormulaGroup(NamedTuple):
    """Closed forms that belong together, and the function whose length decides whether they can be read."""

    function: Callable[[Distortion], RationalFunction]
    rows: Callable[[ClosedForms], list[Line]]


DYNAMICS = FormulaGroup(lambda d: d.perc, ClosedForms.dynamics)
DIFFERENCE = FormulaGroup(lambda d: d.difference, ClosedForms.difference)
RATIO_FORMS = FormulaGroup(lambda d: d.difference, ClosedForms.ratios)
RELATIVE = FormulaGroup(lambda d: (d.difference / d.env).reduced(), ClosedForms.relative)
FELT = FormulaGroup(lambda d: d.perc, lambda forms: forms.properties("perc"))

_LARGEST = 50_000  # products of terms in an expansion in symbols: some tenths of a second
_MOST_TERMS = 50  # of a numerator in symbols: a third of a page


@dataclass(frozen=True)
class SceneForms:
    """The closed forms of an evaluated scene; what was found in symbols is kept, as it is asked for again."""

    evaluation: Evaluation
    found: dict[FormulaGroup, list[Line] | None] = field(default_factory=dict, repr=False)

    @cached_property
    def symbolic(self) -> Distortion | None:
        """The distortion in symbols, unless that would be far too long."""
        return self.evaluation.scene.symbolic_distortion() if _size(self.evaluation) <= _LARGEST else None

    def in_symbols(self, group: FormulaGroup) -> list[Line] | None:
        """Closed forms in symbols; None if they would be too long to read."""
        if group not in self.found:
            self.found[group] = self._in_symbols(group)
        return self.found[group]

    def _in_symbols(self, group: FormulaGroup) -> list[Line] | None:
        if self.symbolic is None:
            return None
        response = on_axis(group.function(self.symbolic))
        if max(len(x.numerator) for x in (response.raw_real, response.raw_imag)) > _MOST_TERMS:
            return None
        rows = group.rows(ClosedForms(self.symbolic))
        return None if any(is_long(row.value) for row in rows if not row.optional) else rows

    def in_numbers(self, group: FormulaGroup) -> list[Line]:
        """Closed forms in numbers: exact, in the places of the symbols, if they are short; else rounded."""
        known = values(self.evaluation.scene.parameters)
        rows = self.in_symbols(group) or group.rows(ClosedForms(self.evaluation.distortion))
        return [_evaluated(row, known) for row in rows]

    def threshold(self, part: Part) -> Line:
        """The polynomial in omega^2 that is positive exactly where the ratio exceeds its threshold, in factors."""
        limits = self.evaluation.scene.threshold
        free = [x for x in Part if is_irrational_algebraic(limits[x] ** 2)]
        found = next(x for x in opened(noticed(limits), free) if x.part is part).function(self.evaluation.distortion)
        assert isinstance(found, RealFunction)  # a symbol is no algebraic number
        return self.polynomial(quantity("p_r" if part is Part.REAL else "p_i"), found)

    def polynomial(self, left: Box, found: RealFunction) -> Line:
        """The numerator of a function that is positive where it is, in factors, rounded where that is long."""
        function = found.written
        if function.is_zero:
            return Line(left, S.Zero)
        unit, factors = function.ring.factors(function.numerator)
        exact = Mul(1 if unit > 0 else -1, *(function.ring.expression(f) ** n for f, n in factors))
        if not is_long(exact, lines=2 if exact.has(pi) else 5):
            return Line(left, exact)
        if function.ring.functions:
            return Line(left, approximate(exact, digits=10), relation="≈")
        sign = sign_of_number(_gain(function, function.numerator))
        monic = sign * _monic_factors(function, function.numerator, omega)
        return Line(left, approximate(monic, digits=10), relation="≈")  # fewer lose close roots

    def named(self, rows: list[Line]) -> list[Line]:
        """The rows with short names for the parameters of effects with long names."""
        return [replace(row, value=_expression(row).xreplace(self.short_names)) for row in rows]

    @cached_property
    def short_names(self) -> dict[Symbol, Symbol]:
        """The number of an effect, for its long name, in the subscripts of its parameters."""
        scene = self.evaluation.scene
        taken = {formula(p.symbol) for p in scene.parameters}
        found = {}
        for i, effect in enumerate(scene.effects, 1):
            label = re.sub("[- ]", "_", effect.name)
            for symbol in (p.symbol for p in effect.parameters):
                short_name = Symbol(f"{symbol.name.removesuffix(f'_{label}')}_{i}", **symbol.assumptions0)
                if len(label) > 8 and symbol.name.endswith(f"_{label}") and formula(short_name) not in taken:
                    found[symbol] = short_name
                    taken.add(formula(short_name))
        return found


def _expression(row: Line) -> Expr:
    """The value of a closed form, which is more than what it looks like."""
    assert isinstance(row.value, Expr)
    return row.value


def _evaluated(row: Line, known: Mapping[Symbol, Expr]) -> Line:
    """A row with numbers for its parameters; if they are long, in lowest terms and rounded."""
    exact = _expression(row).xreplace(known)
    if approximate(exact) == exact:
        return replace(row, value=exact)
    return replace(row, value=approximate(_monic(exact)), relation="≈")


def _monic(exact: Expr) -> Expr:
    """A quotient as a number times factors with leading coefficient 1; a polynomial as it is."""
    if any(isinstance(x, Abs) or not x.exp.is_Integer for x in exact.atoms(Abs, Pow)):
        return exact
    variable = s if exact.has(s) else omega
    if exact.has(Function, I):
        return exact
    function = PolynomialRing(variable).convert(exact).reduced()
    if function.denominator.is_constant():
        return exact
    above, below = _gain(function, function.numerator), _gain(function, function.denominator)
    numerator = _monic_factors(function, function.numerator, variable)
    denominator = _monic_factors(function, function.denominator, variable)
    return Mul(above / below, numerator, 1 / denominator)


def _gain(function: RationalFunction, polynomial: Polynomial) -> Expr:
    """The leading coefficient of a polynomial whose parameters are numbers."""
    return function.ring.coefficients(polynomial)[-1]


def _monic_factors(function: RationalFunction, polynomial: Polynomial, variable: Symbol) -> Expr:
    """The product of the factors of a polynomial, each with leading coefficient 1."""
    product = S.One
    for factor, exponent in function.ring.factors(polynomial)[1]:
        row = function.ring.coefficients(factor)
        product *= Add(*(c / row[-1] * variable**n for n, c in enumerate(row))) ** exponent
    return product


# How long an expansion in symbols would be.


def _size(e: Evaluation) -> int:
    """A bound on the products of terms that H_perc makes when all of its parameters are symbols."""
    above, below = _terms((e.scene.rendered or e.scene.environment).dynamics)
    for effect in e.scene.effects:
        (a, p), (b, q), (c, r), (d, t) = map(_terms, effect.dynamics)
        above, below = a * q * r * t * above + b * p * r * t * below, c * p * q * t * above + d * p * q * r * below
    return above * below


def _terms(expression: Expr) -> tuple[int, int]:
    """At most how many terms numerator and denominator have when they are multiplied out."""
    if isinstance(expression, Add):
        found = [_terms(x) for x in expression.args]
        below = prod(d for _, d in found)
        return sum(n * below // d for n, d in found), below
    if isinstance(expression, Mul):
        found = [_terms(x) for x in expression.args]
        return prod(n for n, _ in found), prod(d for _, d in found)
    if isinstance(expression, Pow) and expression.exp.is_Integer:
        n, d = (comb(x + abs(int(expression.exp)) - 1, x - 1) for x in _terms(expression.base))
        return (n, d) if expression.exp > 0 else (d, n)
    return int(expression != 0), 1
