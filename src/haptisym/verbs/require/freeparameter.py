"""One parameter of a scene left open: how a user names it, what it may be, and the threshold conditions as functions of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from sympy import Expr, Integer, Symbol

from haptisym.judge.bounds import relative_square
from haptisym.judge.crossings import excess, level
from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.symbols import c
from haptisym.model.catalogue import Rule, values
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, Threshold
from haptisym.model.quantities import Dimension, Number, quantity
from haptisym.model.scene import Scene

THRESHOLD = "evaluation.jnd"


@dataclass(frozen=True)
class Free:
    """A parameter that a question leaves open.

    ``path``: its place in a scene file. ``parts``: of a threshold, those whose JND it is; empty for any other parameter.
    """

    path: str
    symbol: Symbol
    dimension: Dimension
    unit: str
    rule: Rule
    parts: tuple[Part, ...] = ()

    def value(self, given: Number) -> Expr:
        """A number for it, SI, exact; SceneError for a wrong unit, or for a symbol."""
        try:
            value = quantity(given, self.dimension).value
        except SceneError as error:
            raise error.within(self.path) from None
        if value.free_symbols:
            raise SceneError(f"{self.path}: {given} must be a number")
        return value

    def put(self, scene: Scene, value: Expr) -> Scene:
        """The scene with this value for it; SceneError where the model does not allow it."""
        if not self.parts:
            return scene.with_values({self.symbol.name: value})
        limits = {part: value if part in self.parts else scene.threshold[part] for part in Part}
        return replace(scene, threshold=Threshold(limits[Part.REAL], limits[Part.IMAG]))


def free_parameter(scene: Scene, path: str) -> Free:
    """The parameter of that path (``effects.filter.omega_n``, ``environment.m``, ``evaluation.jnd``) or of that symbol.

    >>> from haptisym.model.scenefile import load_scene
    >>> free_parameter(load_scene("fu2019"), "omega_n").path
    'effects.filter.omega_n'
    """
    known = _all(scene)
    named = {free.symbol.name: free for free in known.values() if not free.parts}
    if path in known:
        return known[path]
    if path in named:
        return named[path]
    if path == "c":
        return known[THRESHOLD]
    if path in scene.ties:
        raise SceneError(f"{path} is {scene.ties[path]}, to which it refers: leave that free")
    raise SceneError(
        f'no parameter "{path}" can be free in this scene: {meant(path, known)}valid are {", ".join(known)}'
    )


def _all(scene: Scene) -> dict[str, Free]:
    found = {}
    for place, _, p in scene.placed():
        path = f"{place}.{p.key}"
        found[path] = Free(path, p.symbol, p.dimension, p.dimension.unit(scene.motion) or "SI", p.rule)
    limits = {THRESHOLD: tuple(Part), f"{THRESHOLD}.real": (Part.REAL,), f"{THRESHOLD}.imag": (Part.IMAG,)}
    return found | {path: Free(path, c, Dimension.RATIO, "1", Rule.POSITIVE, parts) for path, parts in limits.items()}


@dataclass(frozen=True)
class Domain:
    """The values that are asked about: an interval, None where it is unbounded, and whether its ends belong to it."""

    low: Expr | None
    high: Expr | None
    holds_low: bool = True
    holds_high: bool = True


def domain(free: Free, given: tuple[Number, Number] | None) -> Domain:
    """The values that the rule of a parameter allows, within the range that is given."""
    low, high, closed = _ALLOWED[free.rule]
    if given is None:
        return Domain(low, high, closed, closed)
    start, end = (free.value(x) for x in given)
    if sign_of_number(end - start) <= 0:
        raise SceneError(f"{free.path}: the range must go up, not from {given[0]} to {given[1]}")
    if (low is not None and sign_of_number(end - low) <= 0) or (high is not None and sign_of_number(high - start) <= 0):
        raise SceneError(f"{free.path} {free.rule.value}: no value from {given[0]} to {given[1]} does")
    below = low is not None and sign_of_number(start - low)
    above = high is not None and sign_of_number(high - end)
    return Domain(
        low if below is not False and below < 0 else start,
        high if above is not False and above < 0 else end,
        closed or below is False or below > 0,
        closed or above is False or above > 0,
    )


_ALLOWED: Mapping[Rule, tuple[Expr | None, Expr | None, bool]] = {
    Rule.POSITIVE: (Integer(0), None, False),
    Rule.NONNEGATIVE: (Integer(0), None, True),
    Rule.ANY: (None, None, True),
    Rule.FRACTION: (Integer(0), Integer(1), False),
}


Conditions = Mapping[Part | None, RealFunction]
"""Functions of omega and the free parameters that must not be positive: r^2 - c^2 of a part; None: of every environment."""


def conditions(scene: Scene, free: Iterable[Free], parts: Iterable[Part] = Part) -> dict[Part | None, RealFunction]:
    """r^2 - c^2 of each part, with the free parameters left as symbols."""
    listed = list(free)
    d, limits = _distortion(scene, listed), _limits(scene, listed)
    found: dict[Part | None, RealFunction] = {}
    for part in parts:
        found[part] = _real(excess(d, limits[part], part))
    return found


def any_environment_condition(scene: Scene, free: Iterable[Free]) -> dict[Part | None, RealFunction]:
    """|G - 1|^2 - c^2 of a scene whose effects are all in series, with c the smaller threshold."""
    listed = list(free)
    square, limits = relative_square(_distortion(scene, listed)), _limits(scene, listed)
    if square is None:
        raise SceneError("only effects in series can be judged for any environment: this scene has others")
    if any(x.path.startswith("environment.") for x in listed):
        raise SceneError("for any environment no parameter of the environment can be free")
    if any(len(x.parts) == 1 for x in listed):
        raise SceneError(f"for any environment the thresholds are one: leave {THRESHOLD} free")
    least = limits[Part.REAL] if any(x.parts for x in listed) else min(limits.values())
    return {None: _real(level(square, (least**2).expand()))}


def _distortion(scene: Scene, free: list[Free]) -> Distortion:
    known = {x: v for x, v in values(scene.parameters).items() if x not in {f.symbol for f in free}}
    symbolic = next((x for x, v in known.items() if v.free_symbols), None)
    if symbolic is not None:
        raise SceneError(
            f"{symbolic} = {known[symbolic]} is a symbol: a requirement needs numbers for all but the free one"
        )
    return scene.chain.at(known).distortion()


def _limits(scene: Scene, free: list[Free]) -> dict[Part, Expr]:
    open_parts = {part for x in free for part in x.parts}
    return {part: c if part in open_parts else scene.threshold[part] for part in Part}


def _real(found: object) -> RealFunction:
    if not isinstance(found, RealFunction):
        raise SceneError("a requirement needs thresholds that are rational numbers")
    return found
