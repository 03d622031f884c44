"""The dimensionless form of a scene: fewer numbers, and one formula for all sizes.

By Buckingham's theorem (Phys. Rev. 4, 1914) a relation between n quantities of r independent
dimensions is one between n - r *groups*, products of powers of them without dimension. As many
parameters as there are dimensions, the *base*, serve as units: mass and stiffness of the
environment where it has both. In these units they are 1, and every other parameter is a number, its
group; so the dimensionless scene is the scene with these values.

A *size* is the exponents of mass, length and time in the unit of a quantity. The groups are true
only if the dynamics H(s), force over motion, change with the units as a stiffness does, mass/time^2
(a rotation: times length^2): ``_check`` proves it, or there is a SceneError.

Begin with ``groups``, which returns ``Groups``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any, TypeAlias

from sympy import Dummy, Expr, Integer, Matrix, Mul, Rational, Symbol, linsolve, symbols

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import omega, s
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import Parameter, free_name, in_place
from haptisym.model.quantities import Dimension, MotionKind, dimension_exponents
from haptisym.model.scene import Scene

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


_Size: TypeAlias = Mapping[str, Rational]
"""The exponents of mass, length and time, by their names; without those that are 0."""


@dataclass(frozen=True)
class DimensionlessGroup:
    """A dimensionless group has a ``symbol``, and a ``value`` in the scene's parameters."""

    symbol: Symbol
    value: Expr


@dataclass(frozen=True)
class Groups:
    """The dimensionless form of a scene has x for omega and a group for each parameter that is no
    unit.

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
        """Return the closed forms in x and the groups: ratios are those of the scene, dynamics are
        in units of ``stiffness``."""
        return Distortion.of(self.chain.map(lambda entry: in_place(entry, self.values)))

    def forwards(self, form: Expr) -> Expr:
        """Return a form of ``distortion``, which is written in omega, with x for it."""
        return form.xreplace({omega: self.frequency.symbol})

    def back(self, form: Expr) -> Expr:
        """Return a form in x and the groups in the scene's own parameters again: exact."""
        return form.xreplace(
            {group.symbol: group.value for group in (self.frequency, *self.groups)}
        )


def groups(scene: Scene) -> Groups:
    """Return the dimensionless form of a scene, found from the units of its parameters.

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
    chain = scene.chain.replaced(fixed)
    unknown = {p.symbol for p in parameters if p.dimension is Dimension.ANY and not p.exponents}
    _check(chain, sizes, scene.motion, unknown)
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
    # x, unless a pure number of the scene has that name already.
    letter = free_name("x", {x.symbol.name for x in found})
    return Groups(
        DimensionlessGroup(Symbol(letter, positive=True), omega / unit_of_frequency),
        tuple(found),
        tuple(base),
        unit_of_stiffness,
        values,
        chain,
    )


def _size(p: Parameter, motion: MotionKind | None) -> _Size:
    """Return the dimensions of a parameter; a bare number in a formula counts as a pure number."""
    if p.dimension is Dimension.ANY:
        return {name: Rational(n.numerator, n.denominator) for name, n in p.exponents or ()}
    return _exponents(p.dimension, motion)


def _exponents(dimension: Dimension, motion: MotionKind | None) -> _Size:
    """Return the dimensions of a kind of quantity, which depend on whether the ``motion`` is a
    rotation; none where they are not known."""
    return {
        name: Rational(n.numerator, n.denominator)
        for name, n in dimension_exponents(dimension, motion) or ()
    }


def _check(
    chain: Chain, sizes: Mapping[Symbol, _Size], motion: MotionKind | None, unknown: set[Symbol]
) -> None:
    """Raise SceneError unless other units of mass, length and time change the dynamics as they
    should: exact. ``unknown`` : the parameters without a unit, which count as pure numbers.

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
        if _proportional(expected, scaled):
            continue
        missing = sorted({x.name for entry in row for x in entry.free_symbols & unknown})
        if missing:
            raise SceneError(
                f"{row[0]}: no unit of {', '.join(missing)} is known: give each parameter its unit, "
                f"or use models, as environments.mass_spring_damper(m, b, k)"
            )
        raise SceneError(f"{row[0]}: its units contradict each other: give each parameter its unit")


def _proportional(row: Sequence[Expr], other: Sequence[Expr]) -> bool:
    """Return whether two rows, the first not all 0, are the same up to a common factor: by cross
    products with an entry that is not 0."""
    ring = Ring.of([*row, *other])
    pairs = []
    for entry, other_entry in zip(row, other, strict=True):
        pairs.append((ring.convert(entry.expand()), ring.convert(other_entry.expand())))
    # x y_i = y x_i for all i, with x not 0: then y_i = (y/x) x_i.
    x, y = next(pair for pair in reversed(pairs) if not pair[0].is_zero)
    return all((x_i * y).equals(y_i * x) for x_i, y_i in pairs)


def _base(parameters: Sequence[Parameter], sizes: Mapping[Symbol, _Size]) -> list[Symbol]:
    """Return parameters of independent dimensions, as many as there are: stiffness and mass first,
    the environment's before others."""

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
    """Return the matrix of dimensions, a parameter a row: its rank is the number of independent
    units."""
    return Matrix([_row(sizes[x]) for x in symbols])


def _row(size: _Size) -> list[Any]:
    """Return the exponents of mass, length and time, in this order."""
    return [size.get(name, 0) for name in _DIMENSIONS]


def _unit(size: _Size, base: Sequence[Symbol], sizes: Mapping[Symbol, _Size]) -> Expr | None:
    """Return the product of powers of the base parameters that has this size; None if there is
    none."""
    if not base:
        return None if _without_zeros(size) else Integer(1)
    # Powers n_i with sum of n_i times the row of base parameter i equal to the row of this size.
    powers = symbols(f"n:{len(base)}")
    wanted = Matrix([_row(size)])
    for solution in linsolve((_rows(base, sizes).T, wanted.T), *powers):
        return Mul(*(x**n for x, n in zip(base, solution, strict=True)))
    return None


def _without_unit(name: str, base: Sequence[Symbol]) -> SceneError:
    """Return the error for a quantity without a group: its unit cannot be made of those of the
    base."""
    units = f"that of {', '.join(map(str, base))}" if base else "none"
    return SceneError(
        f"dimensionless groups: the unit of {name} cannot be made of {units}, and what is 0 is no "
        f"unit: give another parameter a value other than 0"
    )


def _named(
    others: Sequence[Parameter], base: Sequence[Symbol], sizes: Mapping[Symbol, _Size], scene: Scene
) -> list[tuple[DimensionlessGroup, int]]:
    """Return the group of each parameter, and how many times it is the parameter in the units of
    the base: 2 for a damping ratio b/(2 sqrt(k m)), else 1.

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
        if name != key:
            name = free_name(name, taken)
        taken.add(name)
        factor = 2 if letter == "zeta" else 1
        symbol = Symbol(name, positive=True) if p.symbol.is_positive else Symbol(name, real=True)
        unit = _unit(sizes[p.symbol], base, sizes)
        if unit is None:
            raise _without_unit(key, base)
        value = p.symbol / (factor * unit)
        named.append((DimensionlessGroup(symbol, value), factor))
    return named


def _index(name: str) -> str:
    """Return what distinguishes a parameter from others of its kind: n of omega_n, 2 of k2."""
    return re.sub(r"^(omega|tau|zeta|[a-zA-Z](?![a-zA-Z]))_?", "", name) or name


def _letter(
    p: Parameter, base: Sequence[Symbol], sizes: Mapping[Symbol, _Size], scene: Scene
) -> str:
    """Return the letter by which a group is known in the field; empty for a pure number, which
    keeps its name."""
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
    """Return the dimension with these exponents; ANY where none has them."""
    exponents = _without_zeros(size)
    for dimension in _LETTERS:
        if dimension is not Dimension.ANY and _exponents(dimension, motion) == exponents:
            return dimension
    return Dimension.ANY


def _without_zeros(size: _Size) -> _Size:
    """Return the exponents that are not 0."""
    return {name: n for name, n in size.items() if n}
