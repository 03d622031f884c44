"""The parameters of a scene reduced to independent dimensionless groups: fewer of them, and one formula for all sizes.

By Buckingham's theorem a relation between n quantities of r independent dimensions is one between n - r groups. As many
parameters as there are dimensions serve as units: mass and stiffness of the environment where it has both. In these units
they are 1, and every other parameter is a number, its group; so the dimensionless scene is the scene with these values.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import TypeAlias

from sympy import Dummy, Expr, Integer, Matrix, Mul, Rational, Symbol, linsolve, symbols

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.symbols import omega, s
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import Dimension, MotionKind, dimension_exponents
from haptisym.model.scene import Scene

_BASE = (Dimension.STIFFNESS, Dimension.MASS, Dimension.DAMPING, Dimension.FREQUENCY, Dimension.TIME)
_LETTERS = {
    Dimension.MASS: "mu", Dimension.STIFFNESS: "kappa", Dimension.DAMPING: "beta", Dimension.FREQUENCY: "rho",
    Dimension.TIME: "theta", Dimension.FORCE: "phi", Dimension.DISPLACEMENT: "chi", Dimension.ANY: "gamma",
}  # fmt: skip


@dataclass(frozen=True)
class DimensionlessGroup:
    """A dimensionless group: its symbol, and what it is in the scene's parameters."""

    symbol: Symbol
    value: Expr


@dataclass(frozen=True)
class Groups:
    """The dimensionless form of a scene.

    ``frequency`` : x, omega in units of the scene's own frequency. ``groups`` : what everything else depends on.
    ``units`` : the parameters that became 1. ``stiffness`` : the unit of H.
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
        """The closed forms in x and the groups: ratios are those of the scene, dynamics are in units of ``stiffness``."""
        return Distortion.of(self.chain.at(self.values))

    def forwards(self, form: Expr) -> Expr:
        """A form of ``distortion``, which is written in omega, with x for it."""
        return form.xreplace({omega: self.frequency.symbol})

    def back(self, form: Expr) -> Expr:
        """A form in x and the groups, in the scene's own parameters again: exact."""
        return form.xreplace({group.symbol: group.value for group in (self.frequency, *self.groups)})


def groups(scene: Scene) -> Groups:
    """The dimensionless form of a scene, found from the units of its parameters.

    Raises SceneError where the unit of a parameter is not known, as for a bare number in an expression.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = groups(load_scene("fu2019"))
    >>> [(g.symbol, g.value) for g in (found.frequency, *found.groups)]
    [(x, sqrt(m)*omega/sqrt(k)), (zeta_env, b/(2*sqrt(k)*sqrt(m))), (rho, sqrt(m)*omega_n/sqrt(k)), (zeta, zeta)]
    """
    orders = {x for order in scene.chain.ring.orders for x in order.free_symbols}
    fixed = {p.symbol: p.value for p in scene.parameters if p.symbol in orders}
    given = [p for p in scene.parameters if p.symbol not in orders]
    sizes = {p.symbol: _size(p, scene.motion) for p in given}
    chain = scene.chain.at(fixed)
    _check(chain, sizes, scene.motion)
    base = _base(given, sizes)
    others = [p for p in given if p.symbol not in base]
    named = dict(zip([p.symbol for p in others], _named(others, base, sizes, scene), strict=True))
    units = {x: Integer(1) for x in base}
    return Groups(
        DimensionlessGroup(Symbol("x", positive=True), omega / _unit({"time": Rational(-1)}, base, sizes)),
        tuple(group for group, _ in named.values()),
        tuple(base),
        _unit(_exponents(Dimension.STIFFNESS, scene.motion), base, sizes),
        {**fixed, **units, **{x: factor * group.symbol for x, (group, factor) in named.items()}},
        chain,
    )


_Size: TypeAlias = Mapping[str, Rational]
"""The exponents of the base dimensions, as far as they are not 0."""


def _size(p: Parameter, motion: MotionKind | None) -> _Size:
    """Of a parameter; a bare number in a formula counts as a pure number."""
    if p.dimension is Dimension.ANY:
        return {name: Rational(n.numerator, n.denominator) for name, n in p.exponents or ()}
    return _exponents(p.dimension, motion)


def _exponents(dimension: Dimension, motion: MotionKind | None) -> _Size:
    return {name: Rational(n.numerator, n.denominator) for name, n in dimension_exponents(dimension, motion) or ()}


def _check(chain: Chain, sizes: Mapping[Symbol, _Size], motion: MotionKind | None) -> None:
    """SceneError unless other units of mass, length and time change the dynamics as they should: exact."""
    if irrational := [order for order in chain.ring.orders if not order.is_Rational]:
        raise SceneError(f"natural groups need powers of s that are rational numbers, not {irrational[0]}")
    roots = {n.q for size in sizes.values() for n in size.values()} | {order.q for order in chain.ring.orders}
    units = {name: Dummy(name, positive=True) ** prod(map(int, roots)) for name in ("mass", "length", "time")}
    scale = {x: x * Mul(*(units[name] ** n for name, n in size.items())) for x, size in sizes.items()}
    scale[s] = s / units["time"]
    stiffness = Mul(*(units[name] ** n for name, n in _exponents(Dimension.STIFFNESS, motion).items()))
    # a chain matrix counts up to a common factor, H_env does not
    rows: list[tuple[Sequence[Expr], Sequence[int]]]
    rows = [((H, Integer(1)), (1, 0)) for H in (chain.environment, chain.rendered)]
    rows += [(matrix, (0, 1, -1, 0)) for matrix in chain.matrices]
    for row, powers in rows:
        expected = [entry * stiffness**n for entry, n in zip(row, powers, strict=True)]
        scaled = [entry.xreplace(scale) for entry in row]
        if not _proportional(expected, scaled):
            raise SceneError(f"{row[0]}: its units do not fit together; give every parameter in it its unit")


def _proportional(row: Sequence[Expr], other: Sequence[Expr]) -> bool:
    """Whether two rows are the same up to a common factor."""
    ring = Ring.of([*row, *other])
    x, y = ([ring.convert(e.expand()) for e in entries] for entries in (row, other))
    last = max(i for i, entry in enumerate(x) if not entry.is_zero)
    return all((a * y[last]).equals(b * x[last]) for a, b in zip(x, y, strict=True))


def _base(given: Sequence[Parameter], sizes: Mapping[Symbol, _Size]) -> list[Symbol]:
    """Parameters of independent dimensions, as many as there are: stiffness and mass first, the environment's first."""
    found: list[Symbol] = []
    rank = 0
    for p in sorted(given, key=lambda p: _BASE.index(p.dimension) if p.dimension in _BASE else len(_BASE)):
        if (now := _rows([*found, p.symbol], sizes).rank()) > rank and not p.value.is_zero:
            found.append(p.symbol)
            rank = now
    return found


def _rows(symbols: Sequence[Symbol], sizes: Mapping[Symbol, _Size]) -> Matrix:
    return Matrix([[sizes[x].get(name, 0) for name in ("mass", "length", "time")] for x in symbols])


def _unit(size: _Size, base: Sequence[Symbol], sizes: Mapping[Symbol, _Size]) -> Expr:
    """The product of powers of the base parameters that has this size; 1 if there is none."""
    powers = symbols(f"n:{len(base)}")
    wanted = Matrix([[size.get(name, 0) for name in ("mass", "length", "time")]])
    solved = linsolve((_rows(base, sizes).T, wanted.T), *powers) if base else []
    for solution in solved:
        return Mul(*(x**n for x, n in zip(base, solution, strict=True)))
    return Integer(1)


def _named(
    others: Sequence[Parameter], base: Sequence[Symbol], sizes: Mapping[Symbol, _Size], scene: Scene
) -> list[tuple[DimensionlessGroup, int]]:
    """The group of each parameter, and how many times it is the parameter in the units of the base."""
    letters = [_letter(p, base, sizes, scene) for p in others]
    taken, environment = {p.symbol.name for p in scene.parameters}, {p.symbol for p in scene.environment.parameters}
    found: list[tuple[DimensionlessGroup, int]] = []
    for p, letter in zip(others, letters, strict=True):
        own = p.symbol.name
        if not letter:
            name = own
        else:
            name = letter if letters.count(letter) == 1 else f"{letter}_{_index(own)}"
            if name in taken:  # a parameter's name stays that parameter's
                name = f"{letter}_{'env' if p.symbol in environment else own}"
        name = name if all(name != group.symbol.name for group, _ in found) else f"{name}_{own}"
        factor = 2 if letter == "zeta" else 1
        symbol = Symbol(name, positive=True) if p.symbol.is_positive else Symbol(name, real=True)
        found.append((DimensionlessGroup(symbol, p.symbol / (factor * _unit(sizes[p.symbol], base, sizes))), factor))
    return found


def _index(name: str) -> str:
    """What tells a parameter from its like: n of omega_n, 2 of k2."""
    return re.sub(r"^(omega|tau|zeta|[a-zA-Z](?![a-zA-Z]))_?", "", name) or name


def _letter(p: Parameter, base: Sequence[Symbol], sizes: Mapping[Symbol, _Size], scene: Scene) -> str:
    """What a group is called in the field; nothing for a pure number, which keeps its name."""
    size = {name: n for name, n in sizes[p.symbol].items() if n}
    if not size:
        return ""
    kinds = {_kind(sizes[x], scene.motion) for x in base}
    kind = _kind(size, scene.motion)
    own = {q.symbol for q in scene.environment.parameters}
    if kind is Dimension.DAMPING and p.symbol in own and kinds >= {Dimension.STIFFNESS, Dimension.MASS}:
        return "zeta"
    return _LETTERS[kind]


def _kind(size: _Size, motion: MotionKind | None) -> Dimension:
    """The dimension with these exponents."""
    plain = {name: n for name, n in size.items() if n}
    return next((d for d in _LETTERS if d is not Dimension.ANY and _exponents(d, motion) == plain), Dimension.ANY)
