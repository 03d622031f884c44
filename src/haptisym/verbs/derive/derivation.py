"""The formulas of a scene for the parameters that a user wants to keep as symbols.

A scene is a haptic display: an environment to be felt, H_env(s), effects (filters, delays, samplers
...) behind which it is felt as H_perc(s), a band of frequencies and a threshold c. With dH = H_perc
- H_env, on s = j omega a change is noticed where r_r = |Re dH|/|H_env| or r_i = |Im dH|/|H_env|
exceeds c. Begin reading at ``derive`` (in the last section) and the ``Derivation`` that it returns:
all closed forms by name, in steps, crossings solved for omega or as equations.

Two further forms have sections of their own, which come first.

**Leading terms** (``expansion``): what is left of dH when the devices are fast. Every time constant
of an effect (a delay, a sampling period, one over a corner frequency) is multiplied by epsilon: dH
is then a power series in epsilon, whose coefficients are rational functions of s. At epsilon = 1 it
is the scene's own distortion. Nothing is said of convergence: what the terms leave out is bounded
on the scene's band by its certified largest value.

**Dimensionless groups** (``groups``) are fewer than parameters, and give one formula for all sizes.
By Buckingham's theorem (Phys. Rev. 4, 1914) a relation between n quantities of r independent
dimensions is one between n - r groups. As many parameters as there are dimensions, the *base*,
serve as units: mass and stiffness of the environment where it has both. In these units they are 1,
and every other parameter is a number, its group; so the dimensionless scene is the scene with these
values.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from math import prod
from operator import add, attrgetter
from pathlib import Path
from pkgutil import resolve_name
from types import MappingProxyType
from typing import Any, ClassVar, TypeAlias

from sympy import (
    Add,
    Dummy,
    Expr,
    Integer,
    Matrix,
    Mul,
    Poly,
    Rational,
    Symbol,
    cosh,
    count_ops,
    exp,
    factorial,
    linsolve,
    sinh,
    symbols,
    together,
)

from haptisym import effects, environments
from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, noticed, opened
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.judge.peaks import largest_value
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis
from haptisym.kernel.errors import SceneError, meant, quoted, several
from haptisym.kernel.objects import titled
from haptisym.kernel.reals import RealNumber, SquareRoot
from haptisym.kernel.rings import (
    Polynomial,
    PolynomialRing,
    RationalFunction,
    c,
    coefficients,
    omega,
    s,
)
from haptisym.kernel.roots import Lattice, LatticePiece
from haptisym.kernel.solutions import Equation, Solution, solve
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion, Elements, part_of
from haptisym.model.jnd import Part
from haptisym.model.parameters import Parameter, in_place
from haptisym.model.quantities import Dimension, MotionKind, Number, dimension_exponents
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.steps import Steps

# Leading terms for fast devices.


@dataclass(frozen=True)
class Expansion:
    """dH = terms[0] + terms[1] + ... + remainder, for fast devices.

    ``terms`` : in the scene's symbols, of ascending order in the devices' time constants; the
    first, of order 0, is what devices without any delay would do. ``fast`` : the parameters in
    which it is expanded, time constants and frequencies of effects.
    """

    scene: Scene = field(repr=False)
    terms: tuple[RationalFunction, ...] = field(repr=False)
    fast: tuple[Symbol, ...]

    def part(self, part: Part) -> Expr:
        """Re or Im of the terms together, a closed form in omega."""
        return Add(*(part_of(on_axis(term), part).factored() for term in self.terms))

    @cached_property
    def bounds(self) -> Mapping[Part, RealNumber | None]:
        """The largest error that the terms make in r_r and r_i on the scene's band: certified; None
        where it is infinite.

        Empty where a parameter has no number.
        """
        values = {p.symbol: p.value for p in self.scene.parameters}
        if any(value.free_symbols for value in values.values()):
            return {}
        exact = self.scene.distortion()
        ring = exact.chain.ring
        terms = [ring.convert(term.expression().xreplace(values)) for term in self.terms]
        # The bound is on the difference itself, in the scene's numbers: it needs no estimate of the
        # next terms of the series, and holds where this does not converge.
        remainder = on_axis((exact.difference - reduce(add, terms)).reduced())
        bounds: dict[Part, RealNumber | None] = {}
        for part in Part:
            error = part_of(remainder, part)
            square = largest_value(error * error / exact.squared_modulus, *self.scene.band)
            bounds[part] = None if square is None else SquareRoot(square)
        return bounds


def expansion(scene: Scene, order: int = 1) -> Expansion:
    """The distortion of a scene to some order in the time constants of its effects.

    Raises SceneError where no effect has a time constant, or where the distortion of infinitely
    fast devices is infinite.

    >>> from haptisym import effects, environments
    >>> from haptisym.kernel.rings import symbols
    >>> k, tau = symbols("k tau")
    >>> scene = Scene(environments.mass_spring_damper(k=100), (effects.delay("5 ms"),))
    >>> found = expansion(scene)
    >>> found.part(Part.IMAG), found.bounds[Part.IMAG].digits(3), found.bounds[Part.REAL].digits(3)
    (-k*omega*tau, '0.0000703', '0.00281')
    """
    fast: dict[Symbol, Dimension] = {}
    for effect in scene.effects:
        for p in effect.parameters:
            if p.dimension in _POWER_OF_EPSILON:
                fast[p.symbol] = p.dimension
    if not fast:
        raise SceneError(
            "no effect of this scene has a time constant: there is no high-bandwidth approximation"
        )
    epsilon = Dummy("epsilon", positive=True)
    powers = {x: x * epsilon ** _POWER_OF_EPSILON[dimension] for x, dimension in fast.items()}
    in_epsilon = scene.chain.put(powers)
    # A division by epsilon, as that of a hold by its period, costs an order each time. Two more for
    # each time constant are left for a common factor of a matrix, which cancels.
    divisions = (_divisions(entry, epsilon) for entry in in_epsilon.entries())
    depth = order + 2 + 2 * len(fast) + sum(divisions)
    cut = Distortion.of(in_epsilon.map(lambda entry: _truncated(entry, epsilon, depth)))
    terms = _series(cut.difference, epsilon, order)
    return Expansion(scene, tuple(terms), tuple(fast))


_POWER_OF_EPSILON = {Dimension.TIME: 1, Dimension.FREQUENCY: -1}
"""The power of epsilon by which a parameter of this dimension is multiplied."""


def _divisions(entry: Expr, epsilon: Symbol) -> int:
    """How often an entry divides by epsilon where it is not in lowest terms: the lowest power in
    its denominator."""
    denominator = together(entry).as_numer_denom()[1]
    if not denominator.has(epsilon):
        return 0
    terms = Poly(_truncated(denominator, epsilon, _MOST_DIVISIONS).expand(), epsilon).monoms()
    return min(int(power) for (power,) in terms)


_MOST_DIVISIONS = 20
"""The order up to which exponentials in a denominator are expanded."""


def _truncated(entry: Expr, epsilon: Symbol, depth: int) -> Expr:
    """The entry with a Taylor polynomial of degree ``depth`` for each exp, cosh and sinh that holds
    epsilon."""
    # With polynomials in place of exponentials the entries are rational in epsilon, and the ring
    # has no functions of it; terms of an order above ``depth`` do not reach the order that is
    # wanted.
    for function, first, step in ((exp, 0, 1), (cosh, 0, 2), (sinh, 1, 2)):
        powers = range(first, depth + 1, step)
        for call in entry.atoms(function):
            if call.has(epsilon):
                x = call.args[0]
                polynomial = Add(*(x**n / factorial(n) for n in powers))
                entry = entry.xreplace({call: polynomial})
    return entry


def _series(f: RationalFunction, epsilon: Symbol, order: int) -> Iterator[RationalFunction]:
    """Yield the coefficients of the power series of ``f``, in lowest terms, in epsilon, from order
    0 up to an order; SceneError where f has a pole at epsilon = 0."""
    numerator = _by_powers(f.numerator, f.ring, epsilon)
    denominator = _by_powers(f.denominator, f.ring, epsilon)
    # In lowest terms a denominator without a term of order 0 is divided by epsilon, and the
    # numerator is not: a pole.
    if 0 not in denominator:
        raise SceneError(
            "the distortion increases without bound with the bandwidth of the effects: there "
            "is no high-bandwidth approximation"
        )
    # (sum of b_j e^j)(sum of t_n e^n) = sum of a_n e^n gives t_n from those before it.
    terms: list[RationalFunction] = []
    for n in range(order + 1):
        remainder = numerator.get(n, f.ring.zero)
        for j, term in enumerate(terms):
            remainder = remainder - denominator.get(n - j, f.ring.zero) * term
        terms.append((remainder / denominator[0]).reduced())
        yield terms[-1]


def _by_powers(
    polynomial: Polynomial, ring: PolynomialRing, variable: Symbol
) -> dict[int, RationalFunction]:
    """The coefficients of a polynomial by the powers of one variable, without those that are 0."""
    if variable not in ring.meanings:  # nothing depends on it
        return {0: ring.function(polynomial)}
    rows = coefficients(polynomial, ring.meanings.index(variable))
    return {power: ring.function(row) for power, row in enumerate(rows) if row}


# Dimensionless groups.

_DIMENSIONS = ("mass", "length", "time")
_BASE = (
    Dimension.STIFFNESS,
    Dimension.MASS,
    Dimension.DAMPING,
    Dimension.FREQUENCY,
    Dimension.TIME,
)
"""The dimensions that serve as units first, in this order."""
_LETTERS = {
    Dimension.MASS: "mu",
    Dimension.STIFFNESS: "kappa",
    Dimension.DAMPING: "beta",
    Dimension.FREQUENCY: "rho",
    Dimension.TIME: "theta",
    Dimension.FORCE: "phi",
    Dimension.DISPLACEMENT: "chi",
    Dimension.ANY: "gamma",
}
"""The letters of the groups of parameters of these dimensions."""


@dataclass(frozen=True)
class DimensionlessGroup:
    """A dimensionless group: its ``symbol``, and its ``value`` in the scene's parameters."""

    symbol: Symbol
    value: Expr


@dataclass(frozen=True)
class Groups:
    """The dimensionless form of a scene.

    ``frequency`` : x, omega in units of the scene's own frequency. ``groups`` : what everything
    else depends on. ``units`` : the base, parameters that became 1. ``stiffness`` : the unit of H,
    N/m or N m/rad, in the scene's parameters. ``chain`` : the dynamics in the scene's parameters.
    """

    frequency: DimensionlessGroup
    groups: tuple[DimensionlessGroup, ...]
    units: tuple[Symbol, ...]
    stiffness: Expr
    values: Mapping[Symbol, Expr]
    """Each parameter of the scene, in these units."""
    chain: Chain

    @cached_property
    def distortion(self) -> Distortion:
        """The closed forms in x and the groups: ratios are those of the scene, dynamics are in
        units of ``stiffness``."""
        return Distortion.of(self.chain.map(lambda entry: in_place(entry, self.values)))

    def forwards(self, form: Expr) -> Expr:
        """A form of ``distortion``, which is written in omega, with x for it."""
        return form.xreplace({omega: self.frequency.symbol})

    def back(self, form: Expr) -> Expr:
        """A form in x and the groups, in the scene's own parameters again: exact."""
        return form.xreplace(
            {group.symbol: group.value for group in (self.frequency, *self.groups)}
        )


def groups(scene: Scene) -> Groups:
    """The dimensionless form of a scene, found from the units of its parameters.

    Raises SceneError where the unit of a parameter is not known, as for a bare number in an
    expression, and where parameters that are not 0 have too few dimensions to make all units.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = groups(load_scene("fu2019"))
    >>> [(g.symbol, g.value) for g in (found.frequency, *found.groups)]
    [(x, sqrt(m)*omega/sqrt(k)), (zeta_env, b/(2*sqrt(k)*sqrt(m))), (rho, sqrt(m)*omega_n/sqrt(k)), (zeta, zeta)]
    """
    # The unit of a coefficient of s^alpha depends on alpha: orders must be numbers, and are put in
    # first.
    orders = {x for order in scene.chain.ring.orders for x in order.free_symbols}
    fixed = {p.symbol: p.value for p in scene.parameters if p.symbol in orders}
    parameters = [p for p in scene.parameters if p.symbol not in orders]
    sizes = {p.symbol: _size(p, scene.motion) for p in parameters}
    chain = scene.chain.put(fixed)
    _check(chain, sizes, scene.motion)
    base = _base(parameters, sizes)
    others = [p for p in parameters if p.symbol not in base]
    values: dict[Symbol, Expr] = {**fixed, **{x: Integer(1) for x in base}}
    found = []
    named = _named(others, base, sizes, scene)
    for p, (group, factor) in zip(others, named, strict=True):
        found.append(group)
        values[p.symbol] = factor * group.symbol
    # Where no parameter has a unit of time, other units of time change nothing (``_check``): omega
    # is in no formula then, and 1 will do.
    unit_of_frequency = _unit({"time": Rational(-1)}, base, sizes) or Integer(1)
    stiffness = _exponents(Dimension.STIFFNESS, scene.motion)
    unit_of_stiffness = _unit(stiffness, base, sizes)
    if unit_of_stiffness is None:
        raise _without_unit("H", base)
    return Groups(
        DimensionlessGroup(Symbol("x", positive=True), omega / unit_of_frequency),
        tuple(found),
        tuple(base),
        unit_of_stiffness,
        values,
        chain,
    )


_Size: TypeAlias = Mapping[str, Rational]
"""The exponents of mass, length and time, by their names; without those that are 0."""


def _size(p: Parameter, motion: MotionKind | None) -> _Size:
    """The dimensions of a parameter; a bare number in a formula counts as a pure number."""
    if p.dimension is Dimension.ANY:
        return {name: Rational(n.numerator, n.denominator) for name, n in p.exponents or ()}
    return _exponents(p.dimension, motion)


def _exponents(dimension: Dimension, motion: MotionKind | None) -> _Size:
    """The dimensions of a kind of quantity, which depend on whether the ``motion`` is a rotation;
    none where they are not known."""
    return {
        name: Rational(n.numerator, n.denominator)
        for name, n in dimension_exponents(dimension, motion) or ()
    }


def _check(chain: Chain, sizes: Mapping[Symbol, _Size], motion: MotionKind | None) -> None:
    """SceneError unless other units of mass, length and time change the dynamics as they should:
    exact.

    With every parameter times its unit, and s over the unit of time, H must be itself times the
    unit of stiffness K, and a chain matrix (A, B; C, D) must be (A, B K; C/K, D), up to a factor.
    """
    irrational = [order for order in chain.ring.orders if not order.is_Rational]
    if irrational:
        raise SceneError(f"dimensionless groups need rational powers of s, not {irrational[0]}")
    # Units are given powers of which all roots that occur are whole again: then the ring needs no
    # roots of them.
    roots = {n.q for size in sizes.values() for n in size.values()}
    roots |= {order.q for order in chain.ring.orders}
    power = prod(map(int, roots))
    units = {name: Dummy(name, positive=True) ** power for name in _DIMENSIONS}

    def unit_of(size: _Size) -> Expr:
        return Mul(*(units[name] ** n for name, n in size.items()))

    in_other_units = {x: x * unit_of(size) for x, size in sizes.items()}
    in_other_units[s] = s / units["time"]
    stiffness = unit_of(_exponents(Dimension.STIFFNESS, motion))
    # Each with the powers of K; a chain matrix counts up to a common factor, H does not, beside
    # which stands a 1.
    rows: list[tuple[Sequence[Expr], Sequence[int]]]
    rows = [((H, Integer(1)), (1, 0)) for H in (chain.environment, chain.rendered)]
    rows += [(matrix, (0, 1, -1, 0)) for matrix in chain.matrices]
    for row, powers in rows:
        expected = [entry * stiffness**n for entry, n in zip(row, powers, strict=True)]
        scaled = [entry.xreplace(in_other_units) for entry in row]
        if not _proportional(expected, scaled):
            raise SceneError(
                f"{row[0]}: its units contradict each other: give each parameter its unit"
            )


def _proportional(row: Sequence[Expr], other: Sequence[Expr]) -> bool:
    """Whether two rows, the first not all 0, are the same up to a common factor: by cross
    products with an entry that is not 0."""
    ring = Ring.of([*row, *other])
    pairs = []
    for entry, other_entry in zip(row, other, strict=True):
        pairs.append((ring.convert(entry.expand()), ring.convert(other_entry.expand())))
    # x y_i = y x_i for all i, with x not 0: then y_i = (y/x) x_i.
    x, y = next(pair for pair in reversed(pairs) if not pair[0].is_zero)
    return all((x_i * y).equals(y_i * x) for x_i, y_i in pairs)


def _base(parameters: Sequence[Parameter], sizes: Mapping[Symbol, _Size]) -> list[Symbol]:
    """Parameters of independent dimensions, as many as there are: stiffness and mass first, the
    environment's before others."""

    def preference(p: Parameter) -> int:
        return _BASE.index(p.dimension) if p.dimension in _BASE else len(_BASE)

    base: list[Symbol] = []
    for p in sorted(parameters, key=preference):
        # Independent of those before it: the rank grows with it. What is 0 cannot be a unit: the
        # others would be infinite in it.
        is_independent = _rows([*base, p.symbol], sizes).rank() > len(base)
        if is_independent and not p.value.is_zero:
            base.append(p.symbol)
    return base


def _rows(symbols: Sequence[Symbol], sizes: Mapping[Symbol, _Size]) -> Matrix:
    """The matrix of dimensions, a parameter a row: its rank is the number of independent units."""
    return Matrix([_row(sizes[x]) for x in symbols])


def _row(size: _Size) -> list[Any]:
    """The exponents of mass, length and time, in this order."""
    return [size.get(name, 0) for name in _DIMENSIONS]


def _unit(size: _Size, base: Sequence[Symbol], sizes: Mapping[Symbol, _Size]) -> Expr | None:
    """The product of powers of the base parameters that has this size; None if there is none."""
    if not base:
        return None if _without_zeros(size) else Integer(1)
    # Powers n_i with sum of n_i times the row of base parameter i equal to the row of this size.
    powers = symbols(f"n:{len(base)}")
    wanted = Matrix([_row(size)])
    for solution in linsolve((_rows(base, sizes).T, wanted.T), *powers):
        return Mul(*(x**n for x, n in zip(base, solution, strict=True)))
    return None


def _without_unit(name: str, base: Sequence[Symbol]) -> SceneError:
    """The error for a quantity without a group: its unit cannot be made of those of the base."""
    units = f"that of {', '.join(map(str, base))}" if base else "none"
    return SceneError(
        f"dimensionless groups: the unit of {name} cannot be made of {units}, and what is 0 is no "
        f"unit: give another parameter a value other than 0"
    )


def _named(
    others: Sequence[Parameter], base: Sequence[Symbol], sizes: Mapping[Symbol, _Size], scene: Scene
) -> list[tuple[DimensionlessGroup, int]]:
    """The group of each parameter, and how many times it is the parameter in the units of the
    base: 2 for a damping ratio b/(2 sqrt(k m)), else 1.

    A group has the letter of its kind, with an index where several have it, as rho_n; a pure number
    keeps its own name.
    """
    letters = [_letter(p, base, sizes, scene) for p in others]
    taken = {p.symbol.name for p in scene.parameters}
    of_environment = {p.symbol for p in scene.environment.parameters}
    named: list[tuple[DimensionlessGroup, int]] = []
    for p, letter in zip(others, letters, strict=True):
        key = p.symbol.name
        name = key
        if letter:
            name = letter if letters.count(letter) == 1 else f"{letter}_{_index(key)}"
            # A parameter's name stays that parameter's.
            if name in taken:
                name = f"{letter}_{'env' if p.symbol in of_environment else key}"
        if any(name == group.symbol.name for group, _ in named):
            name = f"{name}_{key}"
        factor = 2 if letter == "zeta" else 1
        symbol = Symbol(name, positive=True) if p.symbol.is_positive else Symbol(name, real=True)
        unit = _unit(sizes[p.symbol], base, sizes)
        if unit is None:
            raise _without_unit(key, base)
        value = p.symbol / (factor * unit)
        named.append((DimensionlessGroup(symbol, value), factor))
    return named


def _index(name: str) -> str:
    """What distinguishes a parameter from others of its kind: n of omega_n, 2 of k2."""
    return re.sub(r"^(omega|tau|zeta|[a-zA-Z](?![a-zA-Z]))_?", "", name) or name


def _letter(
    p: Parameter, base: Sequence[Symbol], sizes: Mapping[Symbol, _Size], scene: Scene
) -> str:
    """The letter by which a group is known in the field; empty for a pure number, which keeps its
    name."""
    size = _without_zeros(sizes[p.symbol])
    if not size:
        return ""
    kind = _kind(size, scene.motion)
    # The environment's own damping in units of its stiffness and mass is its damping ratio.
    if kind is Dimension.DAMPING:
        of_environment = {q.symbol for q in scene.environment.parameters}
        kinds_of_base = {_kind(sizes[x], scene.motion) for x in base}
        has_both = kinds_of_base >= {Dimension.STIFFNESS, Dimension.MASS}
        if p.symbol in of_environment and has_both:
            return "zeta"
    return _LETTERS[kind]


def _kind(size: _Size, motion: MotionKind | None) -> Dimension:
    """The dimension with these exponents; ANY where none has them."""
    exponents = _without_zeros(size)
    for dimension in _LETTERS:
        if dimension is not Dimension.ANY and _exponents(dimension, motion) == exponents:
            return dimension
    return Dimension.ANY


def _without_zeros(size: _Size) -> _Size:
    """The exponents that are not 0."""
    return {name: n for name, n in size.items() if n}


# All formulas of a scene.

Factors: TypeAlias = tuple[tuple[Equation, int], ...]
"""Irreducible factors as equations, each with its multiplicity."""


@dataclass(frozen=True, repr=False)
class Derivation(Answer):
    """The formulas of a scene.

    ``scene`` : the scene. ``kept`` : the parameters that stay symbols; the others have the scene's
    values. ``kept_thresholds`` : the parts, real and imaginary, whose threshold stays the symbol c.

    ``derivation["Re dH"]`` is a closed form, under the names of ``QUANTITIES``; ``steps`` is the
    distortion in short named steps; ``crossings`` and ``changeovers`` are solved where a formula is
    readable, and otherwise the equation to solve. Where a part is wanted, ``of`` is a Part or a
    criterion: one condition of the JND by itself (``judge.crossings``).
    """

    scene: Scene
    kept: tuple[Symbol, ...]
    kept_thresholds: tuple[Part, ...] = tuple(Part)
    of: tuple[str, ...] = ()
    """The quantities that its page shows; empty for those that it shows by default."""
    shows_groups: bool = False
    """Whether its page shows the dimensionless form, too."""

    _schema: ClassVar[str] = "haptisym.derivation/1"
    _page: ClassVar[str] = "haptisym.pages.derive:page"
    _figure: ClassVar[str] = "haptisym.figures.evaluation:DERIVATION"

    def _line(self) -> str:
        kept = ", ".join(p.name for p in self.kept) or "nothing"
        return f"{titled(self.scene.title)}: {kept} as symbols"

    def _body(self) -> dict[str, Any]:
        body: dict[str, Any] = resolve_name("haptisym.pages.derive:body")(self)
        return body

    def to_latex(self) -> str:
        r"""LaTeX for a paper, a paragraph for each section: what ``haptisym derive --to latex``
        prints."""
        return str(resolve_name("haptisym.pages.derive:latex")(self))

    @cached_property
    def chain(self) -> Chain:
        """The dynamics with the scene's values for all parameters that are not kept."""
        return self.scene.chain.put(
            {p.symbol: p.value for p in self.scene.parameters if p.symbol not in self.kept}
        )

    @cached_property
    def distortion(self) -> Distortion:
        """The closed forms, exact."""
        return Distortion.of(self.chain)

    @cached_property
    def environment(self) -> Distortion:
        """The closed forms of the environment alone, felt as it is: for these no chain is
        multiplied out."""
        felt = self.chain.environment
        return Distortion.of(Chain(felt, felt, ()))

    @cached_property
    def steps(self) -> Steps:
        """The distortion in named steps, which stay short as devices are cascaded."""
        return self.chain.steps

    def __getitem__(self, name: str) -> Expr:
        key = listed_name(str(name))
        if key is None:
            raise SceneError(
                f"unknown quantity {quoted(name)}: {meant(str(name), QUANTITIES)}valid are "
                f"{', '.join(QUANTITIES)}"
            )
        return QUANTITIES[key](self)

    def __iter__(self) -> Iterator[str]:
        return iter(QUANTITIES)

    def __contains__(self, name: object) -> bool:
        """Whether ``derivation[name]`` is a closed form."""
        return isinstance(name, str) and listed_name(name) is not None

    def operations(self, name: str) -> int:
        """The number of operations of a closed form, expanded."""
        return int(count_ops(self[name]))

    @cached_property
    def criteria(self) -> tuple[Criterion, ...]:
        """The criteria of the scene's JND, each with the symbol c for its threshold where that is
        kept, else with the scene's number."""
        return opened(noticed(self.scene.threshold), self.kept_thresholds)

    def criterion(self, of: Part | Criterion) -> Criterion:
        """The criterion of a part, or the one with the name of a criterion; SceneError for a JND of
        which there are no such formulas."""
        if self.kept_thresholds:
            self.scene.threshold.need_plain("formulas of crossings")
        name = of.value if isinstance(of, Part) else of.name
        return next(x for x in self.criteria if x.name == name)

    def threshold(self, of: Part | Criterion) -> Expr:
        """The threshold of a part: the symbol c, or the scene's number."""
        return self.criterion(of).threshold

    def excess(self, of: Part | Criterion) -> RealFunction:
        """r^2 - c^2: positive exactly where the ratio exceeds its threshold."""
        return self._excess(of, self.distortion)

    def _excess(self, of: Part | Criterion, d: Distortion) -> RealFunction:
        """r^2 - c^2 of a distortion; SceneError for a JND that is no single formula."""
        function = self.criterion(of).function(d)
        if isinstance(function, RealFunction):
            return function
        raise SceneError(
            f"no single formula: the JND is {self.scene.threshold.kind}; give one number for "
            f"each part, as jnd = 0.1"
        )

    def piece(self, of: LatticePiece) -> RealFunction:
        """One function of a JND region that is a maximum of minima of several (a lattice), by the
        region's name, the minimum (``term``) and the place in it."""
        criterion = next(x for x in self.criteria if x == of.name)
        lattice = criterion.function(self.distortion)
        assert isinstance(lattice, Lattice)
        function = lattice.terms[of.term][of.place]
        assert isinstance(function, RealFunction)
        return function

    def crossings(self, of: Part | Criterion, *, readable: bool = False) -> tuple[Solution, ...]:
        """The frequencies at which the ratio crosses its threshold, as formulas; where a factor has
        none that can be read, the equation itself, or with ``readable`` nothing."""
        return solve(self._excess(of, self.distortion.with_one_delay), readable=readable)

    def stiffness(self, system: str) -> RealFunction:
        """Re H of the environment ("env") or of what is felt ("perc")."""
        return (
            self.environment.env_response.real
            if system == "env"
            else self.distortion.perc_response.real
        )

    def changeovers(self, system: str) -> tuple[Solution, ...]:
        """The frequencies at which Re H of the environment ("env") or of what is felt ("perc")
        vanishes, as formulas or equations."""
        return solve(self.stiffness(system))

    def sensitivity(self, of: Part | Criterion, parameter: Symbol) -> Expr:
        """d omega/d parameter at a crossing, by the implicit function theorem: -(dF/d
        parameter)/(dF/d omega) for the equation F = 0 of the crossing.

        At a touch dF/d omega is 0 too and the derivative does not exist: the formula holds at
        simple crossings only.
        """
        return self.equation(of).slope(parameter).expression()

    def equation(self, of: Part | Criterion) -> Equation:
        """F = 0 at the crossings: F is the numerator of r^2 - c^2."""
        return _equation(self.excess(of))

    def factors(self, of: Criterion | LatticePiece | str) -> Factors:
        """The irreducible factors of numerator and denominator of r^2 - c^2, of one function of a
        region (``piece``), or of Re H of a system ("env" or "perc"); at each crossing one of them
        is 0."""
        if isinstance(of, str):
            f = self.stiffness(of)
        elif isinstance(of, LatticePiece):
            f = self.piece(of)
        else:
            f = self.excess(of)
        factors = []
        for polynomial in (f.function.numerator, f.function.denominator):
            # In omega^2, unless there are functions of omega, as cos(omega tau).
            _, pairs = f.axis.factors(polynomial, in_square=not f.axis.functions)
            for factor, multiplicity in pairs:
                written = f.axis.in_half_angles(factor)
                factors.append((Equation(written.ring, written.numerator), multiplicity))
        return tuple(factors)

    @cached_property
    def groups(self) -> Groups:
        """The scene in independent dimensionless groups; SceneError where the units do not show them."""
        return groups(self.scene)

    def expansion(self, order: int = 1) -> Expansion:
        """The leading terms for fast devices, with a proven bound on the rest; SceneError where no
        device has a speed."""
        return expansion(self.scene, order)

    def at(self, /, **values: Number) -> Evaluation:
        """Certified answers for values of the parameters, by name; what is not named keeps the
        scene's value.

        >>> from haptisym.verbs.derive.derivation import derive
        >>> derive("fu2019").at(omega_n="160 rad/s").bandwidth is None
        False
        """
        return evaluate(self.scene.with_values(values))


def _equation(f: RealFunction) -> Equation:
    """f = 0, by the numerator of f in the form in which it is written for a reader."""
    written = f.written
    return Equation(written.ring, written.numerator)


def _threshold_polynomial(part: Part) -> Callable[[Derivation], Expr]:
    """The function that gives the polynomial with the sign of r^2 - c^2, as a product of
    factors."""

    def polynomial(d: Derivation) -> Expr:
        f = d.excess(part).written
        unit, factors = f.ring.factors(f.numerator)
        # Of a constant factor the sign alone matters.
        product = f.ring.one.expression() * (1 if unit > 0 else -1)
        for factor, n in factors:
            product *= f.ring.expression(factor) ** n
        return product

    return polynomial


def _of_distortion(path: str) -> Callable[[Derivation], Expr]:
    """The function that gives an attribute of the distortion, by its path; of a real function the
    factored form."""

    def form(d: Derivation) -> Expr:
        value = attrgetter(path)(d.distortion)
        return value.factored() if isinstance(value, RealFunction) else value

    return form


def _jnd(name: str) -> Callable[[Derivation], Expr]:
    """The function that gives the JND of a parameter, by its name, that the threshold c amounts
    to."""
    return lambda d: getattr(d.distortion.parameter_jnd(c), name)


_PERCEIVED = {
    "k": "stiffness",
    "m": "mass",
    "b": "damping",
    "F_si": "spring_inertia_force",
    "F_d": "damping_force",
}
"""Attributes of ``model.chain.Properties`` by the letter in a quantity's name: what a person makes
of a dynamics."""
_SYSTEMS = {"env": "environment_properties", "perc": "perceived_properties"}

QUANTITIES: Mapping[str, Callable[[Derivation], Expr]] = MappingProxyType(
    {
        "H_env": lambda d: d.environment.environment,
        "H_perc": _of_distortion("perceived"),
        "dH": _of_distortion("distortion"),
        "Re dH": _of_distortion("real"),
        "Im dH": _of_distortion("imag"),
        "|H_env|^2": _of_distortion("squared_modulus"),
        "r_r": _of_distortion("ratio_real"),
        "r_i": _of_distortion("ratio_imag"),
        "Re(dH/H_env)": _of_distortion("relative_real"),
        "Im(dH/H_env)": _of_distortion("relative_imag"),
        "p_r": _threshold_polynomial(Part.REAL),
        "p_i": _threshold_polynomial(Part.IMAG),
        **{
            f"{letter}_{system}": _of_distortion(f"{properties}.{name}")
            for system, properties in _SYSTEMS.items()
            for letter, name in _PERCEIVED.items()
        },
        **{f"jnd {x}": _jnd(_PERCEIVED[x]) for x in ("k", "b", "m")},
    }
)
"""The closed forms that a derivation has, by name."""


def bare(name: str) -> str:
    """A name in lower-case letters and digits alone, as it may be typed in a shell.

    >>> bare("|H_env|^2"), bare("Re dH")
    ('henv2', 'redh')
    """
    return "".join(x for x in name.casefold() if x.isalnum())


def listed_name(name: str) -> str | None:
    """The quantity that a name stands for, as QUANTITIES lists it; None if it is none."""
    return next((known for known in QUANTITIES if bare(known) == bare(name)), None)


def derive(
    scene: Scene | Distortion | str | Path,
    keep: Iterable[str | Symbol] | str | Symbol | None = None,
) -> Derivation:
    """The formulas of a scene, or of a distortion in its own symbols; ``print`` shows them as a
    page of text.

    ``scene`` : a scene, the name of one that comes with haptisym, a file, or a distortion.
    ``keep`` : the parameters that stay symbols, by symbol or name; None for all of them and the
    threshold, () for none. A name that the scene does not have raises SceneError, as do names
    with a distortion, whose symbols stay.

    >>> found = derive("fu2019", keep=["omega_n"])
    >>> found
    <Derivation "Numerical example of Fu, van Paassen and ...": omega_n as symbols>
    >>> found["H_perc"]
    omega_n**2*(9*s**2 + 75*s + 500)/(5*omega_n**2 + 5*omega_n*s + 5*s**2)
    >>> [x.omega for x in derive("fu2019").changeovers("env")]
    [sqrt(k)/sqrt(m)]
    >>> from haptisym import distort, effects, environments, symbols
    >>> derive(distort(environments.mass_spring_damper(k=100), effects.first_order_lag(symbols("w"))))["Im dH"]
    -100*omega*w/(omega**2 + w**2)
    """
    if isinstance(scene, Distortion):
        return _derived(scene, keep)
    scene = as_scene(scene)
    if keep is None:
        return Derivation(scene, tuple(x.symbol for x in scene.parameters))
    listed = [keep] if isinstance(keep, str | Symbol) else keep
    names = several("keep", listed, "give names of parameters")
    kept = [scene.knobs[str(name)].felt() for name in names]
    thresholds = tuple(part for part in Part if any(part in x.parts for x in kept))
    return Derivation(scene, tuple(x.symbol for x in kept if not x.parts), thresholds)


def _derived(d: Distortion, keep: Iterable[str] | None) -> Derivation:
    """The derivation of a distortion, of which all symbols stay symbols."""
    if keep is not None:
        raise SceneError("keep: a distortion keeps its symbols: leave it out")
    if d.value is not None:
        raise SceneError(f"omega is {d.value}: derive the distortion without it")
    environment, elements, rendered = d.elements or _elements(d.chain)
    return Derivation(Scene(environment, elements, rendered=rendered), ())


def _elements(chain: Chain) -> Elements:
    """The dynamics of a chain as environments and two-ports: into those of which it was made values
    have not been put."""
    felt, rendered = map(environments.expression, (chain.environment, chain.rendered))
    ports = tuple(effects.two_port(*matrix) for matrix in chain.matrices)
    return felt, ports, None if chain.rendered == chain.environment else rendered
