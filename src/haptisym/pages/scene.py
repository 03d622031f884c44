"""A scene on a page and its closed forms, and the derivation of a report.

On a page stand the chain from the environment to the hand, the parameters, the band and the
threshold. The formulas of a distortion are lines of equations, each denominator a sum of two
squares where nothing cancels; in symbols where a person would read them, in numbers, rounded where
these are long. A report derives them: from the dynamics to closed forms, threshold polynomials and
what is perceived.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import comb, prod
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from sympy import Abs, Add, Expr, Function, I, Integer, Mul, Pow, S, Symbol, pi, sqrt

from haptisym.judge.crossings import noticed
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel import dynamics as response
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, X, omega, s
from haptisym.kernel.roots import sign_of_number
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment
from haptisym.model.distortion import Distortion, magnitude
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import spread, values
from haptisym.model.quantities import Dimension, MotionKind, Unit, unit_text
from haptisym.model.scene import Knob, Scene
from haptisym.pages.derive import beyond, explained, ways
from haptisym.pages.words import CHANGE, H_ENV, H_PERC, OPERATORS, RATIOS, both, page_about, region
from haptisym.verbs.derive.derivation import derive
from haptisym.writing import document as doc
from haptisym.writing.boxes import (
    Absolute,
    Box,
    Fenced,
    Numeral,
    Power,
    Prefixed,
    Relation,
    SideBySide,
    Sum,
)
from haptisym.writing.document import Block, Document, Phrase, Strong, listed
from haptisym.writing.latex import LINE, formula, is_long, width
from haptisym.writing.layout import (
    QUANTITIES,
    approximate,
    function,
    is_brief,
    layout,
    named,
    plain,
    quantity,
    rounded,
)
from haptisym.writing.rounding import DIGITS, Band, faithful, keeps_zeros

# Closed forms.


Written: TypeAlias = doc.Line | Box
"""A formula as it is printed; its left side alone where no rounding of its numbers leaves it
true."""
_OF_POLYNOMIALS = (10, 12, 15)
"""Digits of the numbers of what is printed for its zeros: fewer lose close ones."""


@dataclass(frozen=True)
class ClosedForms:
    """The formulas of a distortion by their subjects."""

    distortion: Distortion

    def all(self) -> list[doc.Line]:
        """Return all closed forms, in the order of a derivation."""
        return [
            *self.dynamics(),
            *self.difference(),
            *self.ratios(),
            *self.relative(),
            *self.properties("env"),
            *self.properties("perc"),
            *self.parameter_jnds(),
            *self.forces("env"),
            *self.forces("perc"),
        ]

    def dynamics(self) -> list[doc.Line]:
        """H_env(s) and H_perc(s)."""
        d = self.distortion
        return [_row("H_env", d.environment), _row("H_perc", d.perceived)]

    def difference(self) -> list[doc.Line]:
        """Re dH and Im dH (eq. 9), and what they are compared with, |H_env|^2."""
        change = [_row(f"{name} dH", self._change(part)) for part, name in _OPERATORS.items()]
        return [*change, _row("|H_env|^2", self._square)]

    def ratios(self) -> list[doc.Line]:
        """r_r and r_i (eq. 10)."""
        return [_row(name, self._ratio(part), optional=True) for part, name in _RATIOS.items()]

    def relative(self) -> list[doc.Line]:
        """Re(dH/H_env) and Im(dH/H_env), which are not the ratios."""
        relative = (self.distortion.difference / self.distortion.env).reduced()
        forms = {part: self.distortion.relative_form(part) for part in Part}
        return [
            _row(f"{name}(dH/H_env)", on_axis(relative, part) if forms[part][1] else forms[part][0])
            for part, name in _OPERATORS.items()
        ]

    def properties(self, system: str) -> list[doc.Line]:
        """Return what a system is felt as (section 2.3): k = Re H, m = -Re H/omega^2, b = Im
        H/omega."""
        real, imag = self._parts(system)
        return [
            _row(f"k_{system}", real),
            _row(f"m_{system}", -real / omega**2, optional=True),
            _row(f"b_{system}", imag / omega),
        ]

    def parameter_jnds(self) -> list[doc.Line]:
        """Return by how much a single parameter must change to be noticed: c |H_env|, over omega
        for damping and over omega^2 for mass."""
        least = Symbol("c", positive=True) * sqrt(self._square)
        powers = {"k": 0, "b": 1, "m": 2}
        return [
            _row(f"jnd {key}", least / omega**power, optional=True) for key, power in powers.items()
        ]

    def forces(self, system: str) -> list[doc.Line]:
        """The phasors of spring or inertia force and of damping force (eqs. 5 and 6) for a motion
        X."""
        real, imag = self._parts(system)
        return [
            _row(f"F_si_{system}", X * real, optional=True),
            _row(f"F_d_{system}", X * imag * I, optional=True),
        ]

    @property
    def _square(self) -> Expr:
        """|H_env|^2 as a quotient of sums of two squares."""
        return squared_modulus(self.distortion.env)

    def _change(self, part: Part) -> Expr:
        """Re or Im dH."""
        form, is_lowest = self.distortion.form(part)
        return on_axis(self.distortion.difference, part) if is_lowest else form

    def _parts(self, system: str) -> tuple[Expr, Expr]:
        """Return Re H and Im H of the environment or of what is perceived."""
        real, imag = (on_axis(self.distortion.env, part) for part in Part)
        if system == "env":
            return real, imag
        # Re H_perc is written by itself where dH is in lowest terms; else as Re H_env + Re dH,
        # whose terms are shorter.
        if all(self.distortion.form(part)[1] for part in Part):
            return on_axis(self.distortion.perc, Part.REAL), on_axis(
                self.distortion.perc, Part.IMAG
            )
        return real + self._change(Part.REAL), imag + self._change(Part.IMAG)

    def _ratio(self, part: Part) -> Expr:
        """Return r_r or r_i: the magnitude of a part of dH over |H_env|."""
        if (shorter := self.distortion.over_real_factor) is not self.distortion:
            return replace(self, distortion=shorter)._ratio(part)
        form, difference = self._change(part), self.distortion.difference
        # Not in lowest terms: SymPy is kept from multiplying out what stands in the absolute value.
        if not self.distortion.form(part)[1]:
            return Abs(form, evaluate=False) / sqrt(self._square)
        return magnitude(form, difference, evaluate=not is_long(form)) / sqrt(self._square)


_RATIOS = {Part.REAL: "r_r", Part.IMAG: "r_i"}
_OPERATORS = {Part.REAL: "Re", Part.IMAG: "Im"}


def _row(name: str, value: Expr, *, optional: bool = False) -> doc.Line:
    """A row for a quantity by its name, with its meaning if it has one."""
    left, means = QUANTITIES[name]
    return doc.Line(left, value, meaning=means, optional=optional)


def on_axis(function: RationalFunction, part: Part) -> Expr:
    """Real or imaginary part on s = j omega, over the squared modulus of the denominator.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.rings import s
    >>> on_axis(Ring().convert(1 / (s**2 + s + 4)), Part.REAL)
    (4 - omega**2)/(omega**2 + (4 - omega**2)**2)
    """
    return response.over_squares(function, real=part is Part.REAL)


def squared_modulus(function: RationalFunction) -> Expr:
    """|f(j omega)|^2 as sums of two squares.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.rings import s
    >>> squared_modulus(Ring().convert(s**2 + s + 4))
    omega**2 + (4 - omega**2)**2
    """
    if response.ring_of(function).axis.functions or response.ring_of(function).axis.complex:
        return response.squared_modulus(function).factored()
    reduced = function.reduced()
    # Fractions among the coefficients are cleared, unless the denominator is a mere number.
    whole = reduced if reduced.denominator.is_constant() else reduced.cleared()
    return response.squares(whole, whole.numerator) / response.squares(whole, whole.denominator)


# The scene.


_AS_THEY_ARE: Mapping[Symbol, Symbol] = MappingProxyType({})


def page(scene: Scene) -> Document:
    """A scene as a notebook shows it."""
    return page_about(scene, (), scene_blocks(scene), ())


def scene_blocks(
    scene: Scene, short_names: Mapping[Symbol, Symbol] = _AS_THEY_ARE
) -> Iterator[Block]:
    """The chain, the table of parameters, and what is judged; ``short_names`` : other symbols for
    parameters."""
    hand = (Strong("hand"), " feels ", H_PERC)
    yield doc.Flow((*(_link(place, part) for place, part in scene.elements()), hand))
    rows = tuple(_parameter(scene, short_names, x) for x in scene.parameters)
    if rows:
        # The column of ranges is there only if some parameter has one; it stands before the unit.
        ranges = ("range",) * any(x.interval for x in scene.parameters)
        columns = ("symbol", "of", "parameter", "quantity", "value", *ranges, "unit")
        if ranges:
            rows = tuple(
                (*row[:-1], _range(x), row[-1])
                for row, x in zip(rows, scene.parameters, strict=True)
            )
        yield doc.Table(
            tuple(doc.Column(x, number=x == "value") for x in columns),
            rows,
            "The parameters, in the units of the scene.",
        )
    low, high = (both(ExactNumber(x)) for x in scene.band)
    yield doc.Paragraph(
        ("The band of interest goes from ", low, " to ", high, ". ", noticeable(scene.threshold))
    )


def noticeable(c: Threshold) -> Phrase:
    """Which changes are noticed, in a sentence."""
    if c.is_plain:
        return (
            ("A change of the real or the imaginary part is noticed when it exceeds the fraction "),
            threshold(c),
            " of ",
            Absolute(H_ENV),
            ".",
        )
    if c.region.shape is Shape.SQUARE:
        return (
            "A change of the real or the imaginary part is noticed when it exceeds ",
            region(c),
            ".",
        )
    return "A change, both parts together, is noticed when it leaves the region: ", region(c), "."


def threshold(c: Threshold) -> Phrase:
    """``c = 0.1``, or the thresholds of both parts where they differ; the region in words where it
    is none of that."""
    if not c.is_plain:
        return region(c)
    if c.real == c.imag:
        return _equality("c", c.real)
    return _equality("c_real", c.real), " (real) or ", _equality("c_imag", c.imag), " (imaginary)"


def _equality(name: str, value: Expr) -> Phrase:
    """``c = 0.1``, or with ≈ where the number is not rational and was rounded."""
    # A rational number is printed exactly, any other rounded.
    decimal = value if value.is_Rational else rounded(value)
    return Relation((named(name), layout(decimal)), ("=" if value.is_Rational else "≈",))


def _link(place: str, part: Environment | Effect) -> Phrase:
    """Return an element of the chain in words: its name, and what its model is."""
    catalogue = ENVIRONMENTS if isinstance(part, Environment) else EFFECTS
    name = place.removeprefix("effects.")
    about = catalogue[part.model].summary.partition(":")[0].rstrip(".")
    return Strong(name), f" ({about if name == part.model else f'{part.model}: {about}'})"


def _parameter(scene: Scene, short_names: Mapping[Symbol, Symbol], p: Knob) -> tuple[Phrase, ...]:
    """Return the row of a parameter: symbol, elements, key, quantity, value, unit."""
    quantity = "" if p.dimension is Dimension.ANY else p.dimension.name.lower()
    own, si = (
        p.shown_unit(scene.motion),
        unit_text(p.unit_in(scene.motion or MotionKind.TRANSLATION)),
    )
    symbol = named(short_names.get(p.symbol, p.symbol).name)
    places = ", ".join(x.removeprefix("effects.").rpartition(".")[0] for x in p.paths)
    return symbol, places, p.key, quantity, _value(p.value / own.size), own.text or si or "SI"


def _range(p: Knob) -> str:
    """``±5 %``, or from where to where."""
    words = spread(p.value, p.interval, Unit("", p.shown_unit(p.motion).size)) if p.interval else ""
    return words.replace("by ", "±").replace(" %", "\xa0%").removeprefix("from ")


def _value(value: Expr) -> Phrase:
    """The exact value; a decimal beside it, or instead of it, where that says more."""
    if value.free_symbols:
        return layout(value)
    if value.is_Rational:
        # Up to 16 digits of numerator and denominator can be read; a longer fraction is rounded.
        return plain(value) if len(f"{value.p}{value.q}") <= 16 else f"≈ {plain(rounded(value))}"
    return Relation((layout(value), layout(rounded(value))), ("≈",))


class FormulaGroup(NamedTuple):
    """Closed forms that belong together, and the function whose length decides whether they can be
    read."""

    function: Callable[[Distortion], RationalFunction]
    rows: Callable[[ClosedForms], list[doc.Line]]


DYNAMICS = FormulaGroup(lambda d: d.perc, ClosedForms.dynamics)
DIFFERENCE = FormulaGroup(lambda d: d.difference, ClosedForms.difference)
RATIO_FORMS = FormulaGroup(lambda d: d.difference, ClosedForms.ratios)
RELATIVE = FormulaGroup(lambda d: (d.difference / d.env).reduced(), ClosedForms.relative)
FELT = FormulaGroup(lambda d: d.perc, lambda forms: forms.properties("perc"))

_LARGEST = 50_000  # products of terms in an expansion in symbols: some tenths of a second
_MOST_TERMS = 50  # of a numerator in symbols: a third of a page


@dataclass(frozen=True)
class SceneForms:
    """The closed forms of an evaluated scene; what was found in symbols is kept, as it is asked for
    again."""

    evaluation: Evaluation
    found: dict[FormulaGroup, list[doc.Line] | None] = field(default_factory=dict, repr=False)

    @cached_property
    def symbolic(self) -> Distortion | None:
        """The distortion in symbols; None where a bound on its length is too large."""
        return (
            self.evaluation.scene.symbolic_distortion()
            # Bounded before it is computed: an expansion that is too long would take minutes.
            if _size(self.evaluation) <= _LARGEST
            else None
        )

    def in_symbols(self, group: FormulaGroup) -> list[doc.Line] | None:
        """Closed forms in symbols; None if they would be too long to read."""
        if group not in self.found:
            self.found[group] = self._in_symbols(group)
        return self.found[group]

    def _in_symbols(self, group: FormulaGroup) -> list[doc.Line] | None:
        """Find closed forms in symbols; None if these would be too long to read."""
        if self.symbolic is None:
            return None
        # A first and cheap test by the number of terms; only then are the forms made and measured.
        parts = response.on_axis(group.function(self.symbolic))
        if max(len(x.numerator) for x in (parts.raw_real, parts.raw_imag)) > _MOST_TERMS:
            return None
        rows = group.rows(ClosedForms(self.symbolic))
        return None if any(is_long(row.value) for row in rows if not row.optional) else rows

    def in_numbers(self, group: FormulaGroup) -> list[Written]:
        """Closed forms in numbers: exact, in the places of the symbols, if they are short; else
        rounded."""
        known = values(self.evaluation.scene.parameters)
        rows = self.in_symbols(group) or group.rows(ClosedForms(self.evaluation.distortion))
        return [_evaluated(row, known, self.evaluation.scene.band) for row in rows]

    def threshold(self, part: Part) -> doc.Line:
        """The polynomial in omega^2 that is positive exactly where the ratio exceeds its threshold,
        in factors.

        Where it is not written with numbers, what it is a multiple of.
        """
        limits = self.evaluation.scene.threshold
        excess = next(x for x in noticed(limits) if x.part is part).function(
            self.evaluation.distortion
        )
        # Of a plain threshold each part is judged by one function, not by a lattice of several.
        assert isinstance(excess, RealFunction)
        shown = self.polynomial(_excess(part), excess)
        if isinstance(shown, doc.Line) and not is_long(shown.value, _SHORT):
            return shown
        # The polynomial is, up to a positive factor, (Re dH)^2 - c^2 |H_env|^2.
        change = Power(Fenced(quantity(f"{_OPERATORS[part]} dH")), Numeral("2"))
        return doc.Line(
            _excess(part),
            Sum(
                ((1, change), (-1, SideBySide((layout(limits[part] ** 2), quantity("|H_env|^2")))))
            ),
        )

    def polynomial(self, left: Box, found: RealFunction) -> Written:
        """The numerator of a function that is positive where it is, in factors, rounded where that
        is long.

        Rounded it has the same zeros on the band, to four digits: certified.
        """
        function = found.written
        if function.is_zero:
            return doc.Line(left, S.Zero)
        # The sign alone matters, so that the unit of the factorisation is kept as its sign.
        unit, factors = function.ring.factors(function.numerator)
        exact = Mul(1 if unit > 0 else -1, *(function.ring.expression(f) ** n for f, n in factors))
        if not is_long(exact, lines=2 if exact.has(pi) else 5):
            return doc.Line(left, exact)
        # Monic factors keep their roots better when coefficients are rounded. With sines and
        # cosines there is no leading coefficient in omega.
        if not function.ring.functions:
            sign = sign_of_number(_gain(function, function.numerator))
            exact = sign * _monic_factors(function, function.numerator, omega)
        band = self.evaluation.scene.band
        for digits in _OF_POLYNOMIALS:
            shown = _faithful(exact, band, (digits,))
            # Two tests: the rounded formula is true to its digits on the band, and has the same
            # zeros there.
            if shown and keeps_zeros(shown[0], found, band):
                return doc.Line(left, *shown)
        return left

    def named(self, rows: Iterable[doc.Line]) -> list[doc.Line]:
        """The rows with short names for the parameters of effects with long names."""
        return [
            replace(x, value=x.value.xreplace(self.short_names)) if isinstance(x.value, Expr) else x
            for x in rows
        ]

    @cached_property
    def short_names(self) -> dict[Symbol, Symbol]:
        """Short symbols for the parameters of effects with long names: the number of the effect
        stands for its name in the subscript."""
        scene = self.evaluation.scene
        taken = {formula(p.symbol) for p in scene.parameters}
        names = {}
        for i, effect in enumerate(scene.effects, 1):
            label = re.sub("[- ]", "_", effect.name)
            for symbol in (p.symbol for p in effect.parameters):
                short_name = Symbol(
                    f"{symbol.name.removesuffix(f'_{label}')}_{i}", **symbol.assumptions0
                )
                # A long name of an effect fills every subscript: its number stands for it, unless
                # another parameter is called so already.
                if (
                    len(label) > 8
                    and symbol.name.endswith(f"_{label}")
                    and formula(short_name) not in taken
                ):
                    names[symbol] = short_name
                    taken.add(formula(short_name))
        return names


def _expression(row: doc.Line) -> Expr:
    """Return the value of a closed form, which is always an expression."""
    assert isinstance(row.value, Expr)
    return row.value


def _evaluated(row: doc.Line, known: Mapping[Symbol, Expr], band: Band) -> Written:
    """A row with numbers for its parameters; if they are long, in lowest terms and rounded."""
    exact = _expression(row).xreplace(known)
    if is_brief(exact):
        return replace(row, value=exact)
    shown = _faithful(_monic(exact), band, DIGITS)
    return replace(row, value=shown[0], relation=shown[1]) if shown else row.left


def _faithful(exact: Expr, band: Band, digits: Sequence[int]) -> tuple[Expr, str] | None:
    """A formula with its long numbers rounded, where that is true on the band."""
    return faithful(lambda n: exact if n is None else approximate(exact, n), band, digits)


def _distributed(form: Expr, factor: Expr) -> Expr:
    """Return a formula times a number, with all numbers of its products inside of their sums: a
    common factor of long numbers would make others of 50 digits.

    >>> _distributed((omega * (6 * omega + 4) + 8) / (2 * omega), Integer(1))
    (omega*(3*omega + 2) + 4)/omega
    """
    if isinstance(form, Add):
        return Add(*(_distributed(x, factor) for x in form.args))
    number, rest = form.as_coeff_Mul()
    factors = Mul.make_args(rest)
    sums = [x for x in factors if isinstance(x, Add)]
    inside = max(sums, key=lambda x: len(x.args), default=None)
    if inside is None:
        return factor * form
    return Mul(*(_distributed(x, factor * number) if x is inside else x for x in factors))


def _monic(exact: Expr) -> Expr:
    """A quotient as a number times factors with leading coefficient 1; a polynomial as it is."""
    # Roots and absolute values are no quotients of polynomials, nor are sines or complex numbers.
    if any(isinstance(x, Abs) or not x.exp.is_Integer for x in exact.atoms(Abs, Pow)):
        return exact
    variable = s if exact.has(s) else omega
    if exact.has(Function, I):
        return _distributed(exact, Integer(1))
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
    above, below = _terms(e.scene.rendering.dynamics)
    for effect in e.scene.effects:
        # An effect maps H = n/d to (A H + B)/(C H + D). With A = a/p and so on, over a common
        # denominator each term is a product of four numbers of terms and one of n or d.
        (a, p), (b, q), (c, r), (d, t) = map(_terms, effect.dynamics)
        above, below = (
            a * q * r * t * above + b * p * r * t * below,
            c * p * q * t * above + d * p * q * r * below,
        )
    return above * below


def _terms(expression: Expr) -> tuple[int, int]:
    """At most how many terms numerator and denominator have when they are multiplied out."""
    if isinstance(expression, Add):
        found = [_terms(x) for x in expression.args]
        # A common denominator is at most the product of all; each numerator is multiplied by the
        # others' denominators.
        below = prod(d for _, d in found)
        return sum(n * below // d for n, d in found), below
    if isinstance(expression, Mul):
        found = [_terms(x) for x in expression.args]
        return prod(n for n, _ in found), prod(d for _, d in found)
    if isinstance(expression, Pow) and expression.exp.is_Integer:
        # The power n of a sum of x terms has at most C(x + n - 1, x - 1) terms.
        n, d = (comb(x + abs(int(expression.exp)) - 1, x - 1) for x in _terms(expression.base))
        return (n, d) if expression.exp > 0 else (d, n)
    return int(expression != 0), 1


# The derivation in a report.


_H = named("H")
_VALUES = "the scene's values"
_MOST_POLYNOMIALS = 12
_WIDE = "A polynomial too long to print is given by the distortion. "


def derivation(forms: SceneForms) -> Iterator[Block]:
    """All steps, each below its heading, and what lies beyond them: short steps, crossings solved
    for omega, groups.

    Closed forms stand in symbols; in numbers, rounded where they are long, if they would be too
    long to read.
    """
    steps = _Steps(forms)
    yield from explained(
        [
            doc.Section("Dynamics", tuple(steps.dynamics())),
            doc.Section("Distortion", tuple(steps.distortion())),
            doc.Section("Threshold polynomials", tuple(steps.thresholds())),
            doc.Section("Perceived properties", tuple(steps.properties())),
            *filter(_is_readable, beyond(derive(forms.evaluation.scene))),
        ]
    )


def _is_readable(section: doc.Section) -> bool:
    """Whether no formula of a section holds numbers or sums that nobody reads."""
    lines = [line for x in section.blocks if isinstance(x, doc.Equations) for line in x.lines]
    return not any(is_long(line.value) for line in lines)


_SHORT = 2
"""Lines of a formula with numbers, at most: nobody reads a longer one, nor prints it."""


@dataclass(frozen=True)
class _Steps:
    """The steps as paragraphs and equations."""

    forms: SceneForms

    @property
    def evaluation(self) -> Evaluation:
        """The evaluation whose formulas are derived."""
        return self.forms.evaluation

    def dynamics(self) -> Iterator[Block]:
        """Yield the dynamics: the environment, each effect as what it does to H, H_perc."""
        scene = self.evaluation.scene
        yield doc.Paragraph(
            (
                "Dynamics are force per position, as functions of the Laplace variable ",
                named("s"),
                ".",
            )
        )
        lines = [doc.Line(quantity("H_env"), scene.environment.dynamics)]
        if scene.rendered:
            yield doc.Paragraph(
                ("The controller renders ", quantity("H_rendered"), " for ", quantity("H_env"), ".")
            )
            lines.append(doc.Line(quantity("H_rendered"), scene.rendering.dynamics))
        said = []
        for i, effect in enumerate(scene.effects, 1):
            words, entries = _action(i, effect)
            said.append((f"Effect {i}, {effect.name}, ", words, ". "))
            lines += entries
        if said:
            yield doc.Paragraph(tuple(said))
        # The first of the closed forms is H_env, which is there already.
        yield from self._equations([*lines, *(self.forms.in_symbols(DYNAMICS) or [])[1:]])
        if scene.parameters:
            rounded_so = (
                "here and below, long numbers after ≈ are rounded so that four digits of a value "
                "are correct"
            )
            lead = f"With {_VALUES} ({rounded_so}):"
            yield from self._in_numbers(lead, self.forms.in_numbers(DYNAMICS))

    def distortion(self) -> Iterator[Block]:
        """Yield dH, the ratios, and the relative distortion, in symbols and in numbers."""
        where = Relation((named("s"), layout(I * omega)), ("=",))
        change = Relation((CHANGE, Sum(((1, H_PERC), (-1, H_ENV)))), ("=",))
        yield from self._formulas(
            (
                *("On ", where, " the parts of the distortion ", change),
                ", and the modulus of the environment, are",
            ),
            DIFFERENCE,
        )
        yield from self._formulas(
            "The distortion ratios, which the threshold judges, are", RATIO_FORMS
        )
        yield from self._formulas(
            "The relative distortion, not to be confused with them, is", RELATIVE
        )
        if self.evaluation.scene.parameters and self.forms.in_symbols(DIFFERENCE):
            lead = f"With {_VALUES} these parts and the modulus are"
            yield from self._in_numbers(lead, self.forms.in_numbers(DIFFERENCE))

    def thresholds(self) -> Iterator[Block]:
        """Yield the polynomials that are positive exactly where a ratio exceeds its threshold."""
        if not self.evaluation.scene.threshold.is_plain:
            yield from self._regions()
            return
        # With delays Re and Im of H(j omega) have sines and cosines of omega: then p is no
        # polynomial in omega^2.
        functions = self.evaluation.distortion.squared_modulus.axis.functions
        kind = (
            "polynomials in ω, its powers, sines and cosines" if functions else "polynomials in ω²"
        )
        lines = [self.forms.threshold(part) for part in Part]
        wide = "" if all(isinstance(x.value, Expr) for x in lines) else _WIDE
        exceeds = listed(
            (RATIOS[part], " exceeds exactly where ", _excess(part), " > 0") for part in Part
        )
        rounded_so = "Coefficients after ≈ are rounded, with these roots to four digits. "
        lead: Phrase = (
            "A ratio exceeds its threshold where its square does, so no root is needed: ",
            exceeds,
            f". These are {kind}; the crossings are their roots on the band. ",
            rounded_so if any(x.relation == "≈" for x in lines) else "",
            wide,
            "Written up to a positive factor:",
        )
        yield doc.Paragraph(lead)
        yield from self._equations(lines)

    def _regions(self) -> Iterator[Block]:
        """Yield, for a region or limits that are formulas in omega, the functions that decide what
        is noticed."""
        said: list[Phrase] = []
        lines: list[Written] = []
        for x in self.evaluation.criteria:
            found = x.function(self.evaluation.distortion)
            where, functions = ways(x, found)
            said += [where, " "]
            # Corners that are functions of omega may change sign, and with them a denominator.
            moves = bool(x.joint) and not self.evaluation.scene.threshold.is_constant
            singles = ((name, f) for name, f in functions if isinstance(f, RealFunction))
            lines += [self.forms.polynomial(name, _whole(f) if moves else f) for name, f in singles]
        if len(lines) > _MOST_POLYNOMIALS:
            yield doc.Paragraph(
                f"{len(lines)} functions of ω decide what is noticed: too many to be written here."
            )
            return
        yield doc.Paragraph(
            (
                *said,
                "Written up to a positive factor (after ≈ with the same roots, to four digits):",
            )
        )
        yield from self._equations(lines)

    def properties(self) -> Iterator[Block]:
        """Yield what Re H and Im H are felt as, and the changeover frequencies."""
        real, imag = (Prefixed(OPERATORS[part], _H) for part in Part)
        lead = (
            real,
            " is felt as stiffness where it is positive and as mass where it is negative, ",
            imag,
            " as damping. The ",
            "stiffness, mass and damping perceived are",
        )
        yield from self._formulas(lead, FELT)
        d = self.forms.symbolic
        values = {p.symbol: p.value for p in self.evaluation.scene.parameters}
        changeovers = {name: d.changeover(name, values) for name in ("env", "perc")} if d else {}
        # Frequencies whose formulas do not fit into a line are left out.
        shown = {
            name: x
            for name, x in changeovers.items()
            if x is not None and width(formula(x)) < LINE - 5
        }
        if shown:
            yield doc.Paragraph(f"The lowest frequencies of changeover, with {_VALUES}, are")
            yield from self._equations(
                [doc.Line(quantity(f"omega_{name}"), x) for name, x in shown.items()]
            )

    def _formulas(self, lead: Phrase, group: FormulaGroup) -> Iterator[Block]:
        """Closed forms in symbols; in numbers if they would be too long to read."""
        has_parameters = bool(self.evaluation.scene.parameters)
        in_symbols = self.forms.in_symbols(group) if has_parameters else None
        lines: Sequence[Written] = in_symbols or self.forms.in_numbers(group)
        is_explained = (
            in_symbols
            or not has_parameters
            or all(isinstance(x, doc.Line) and x.optional for x in lines)
        )
        yield doc.Paragraph(
            lead if is_explained else (lead, f" (with {_VALUES}; too long in symbols)")
        )
        yield from self._equations(lines)

    def _in_numbers(self, lead: Phrase, lines: Iterable[Written]) -> Iterator[Block]:
        """Yield formulas with numbers that can be read, and which ones are too long for that."""
        formulas = list(lines)
        long = [x for x in formulas if isinstance(x, doc.Line) and is_long(x.value, _SHORT)]
        if kept := [x for x in formulas if x not in long]:
            yield doc.Paragraph(lead)
            yield from self._equations(kept)
        if long:
            names = listed(x.left for x in long)
            why = f"Longer than {_SHORT} lines with numbers: "
            yield doc.Paragraph((why, names, "."))

    def _equations(self, lines: Iterable[Written]) -> Iterator[Block]:
        """Yield the formulas, then which of them have no readable form that is true."""
        formulas = list(lines)
        if shown := self.forms.named(x for x in formulas if isinstance(x, doc.Line)):
            yield doc.Equations(tuple(shown))
        # A box alone is the left side of a formula that no rounding leaves true (see Written).
        if left := [x for x in formulas if not isinstance(x, doc.Line)]:
            why = (
                " with numbers: large terms cancel, and rounded to a length that can be read it "
                "would be false."
            )
            yield doc.Paragraph(("Not written is ", listed(left), why))


def _whole(f: RealFunction) -> RealFunction:
    """A polynomial of the sign of a function, whatever that of its denominator."""
    # n/d and n d have one sign, for every sign of d.
    return RealFunction(f.axis.function(f.function.numerator * f.function.denominator))


def _excess(part: Part) -> Box:
    """Return the name of the polynomial that is positive where a part is noticed."""
    return quantity("p_r" if part is Part.REAL else "p_i")


def _action(i: int, effect: Effect) -> tuple[Phrase, list[doc.Line]]:
    """Return what an effect, by its number, does to H: in words, and the formulas that the words
    name."""
    a, b, c, d = effect.dynamics
    # A sampled rendering is a H + b with b = a Z: H becomes G (H + Z).
    if effect.renders and effect.setting("method"):
        words = (
            f"renders it sampled ({effect.setting('method')}): ",
            _H,
            " becomes ",
            named(f"G_{i}"),
            " (",
            _H,
        )
        return (*words, " + ", named(f"Z_{i}"), ")"), [_of_s("Z", i, b / a), _of_s("G", i, a)]
    names = {x: named(f"{x}_{i}") for x in "GZYABCD"}
    # The usual special cases of the two-port (a H + b)/(c H + d) are named for what they are.
    if (b, c, d) == (0, 0, 1):
        return ("multiplies the force by ", names["G"]), [_of_s("G", i, a)]
    if (a, c, d) == (1, 0, 1):
        return ("adds the impedance ", names["Z"]), [_of_s("Z", i, b)]
    if (a, b, d) == (1, 0, 1):
        return ("adds the compliance ", names["Y"], " in series"), [_of_s("Y", i, c)]
    above, below = ((names[x], "\xa0", _H, " + ", names[y]) for x, y in ("AB", "CD"))
    mapped = (_H, " becomes (", above, ")/(", below, ")")
    return ("is a two-port: ", mapped), [
        _of_s(x, i, y) for x, y in zip("ABCD", effect.dynamics, strict=True)
    ]


def _of_s(letter: str, i: int, value: Expr) -> doc.Line:
    """Return the equation of a function of s with the number of its effect."""
    return doc.Line(function(f"{letter}_{i}", layout(s)), value)
