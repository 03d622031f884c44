"""How the frequencies of an evaluation move with each parameter: derivatives and elasticities, exact and certified.

A crossing is a simple zero of F(omega, p) = r^2 - c^2, so that d omega/dp = -(dF/dp)/(dF/d omega) there (implicit
differentiation). ``Derivation.sensitivity`` has the formula; here it is evaluated in ball arithmetic at the certified
frequency. Where the display touches its threshold dF/d omega is 0 and the derivative does not exist.
Derivation: 14_sensitivity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TypeAlias

import flint
from sympy import Expr, Integer, Symbol

from haptisym.crossings import Crossing, CrossingKind, Curve
from haptisym.evaluation import Evaluation
from haptisym.exact.levels import algebraic
from haptisym.exact.reals import Ball, ExactNumber, RealNumber, SquareRoot
from haptisym.exact.roots import Point
from haptisym.formulas.derivation import Derivation, derive
from haptisym.jnd import Part, is_irrational_algebraic
from haptisym.symbols import c, omega

from .implicit import Equation, ImplicitSlope

TOUCH = "undefined: the display touches its threshold here"
_CLEAR_BITS = 4096  # a derivative that is not 0 shows it long before
_ZERO = ExactNumber(Integer(0))
_MEET = "undecided: several branches of the equation meet here"
_NOT_CLEAR = "undecided: dF/dp or dF/d omega is 0 here, or too near to it"
_Values: TypeAlias = tuple[tuple[Symbol, RealNumber], ...]
_THRESHOLD_NAMES = MappingProxyType({Part.REAL: "c_real", Part.IMAG: "c_imag"})


@dataclass(frozen=True)
class Sensitivity:
    """How a frequency moves with one parameter p: ``derivative`` = d omega/dp in rad/s per ``unit``, ``elasticity`` =
    (p/omega) d omega/dp (1). Certified; None where the derivative does not exist.

    ``path``: the parameter's place in a scene file; ``name``: its symbol, ``c`` (or ``c_real``, ``c_imag``) the threshold.
    """

    path: str
    name: str
    unit: str
    derivative: RealNumber | None
    elasticity: RealNumber | None
    reason: str = ""
    """Why there are none."""


@dataclass(frozen=True)
class Sensitive:
    """A frequency, rad/s, and how it moves with each parameter."""

    omega: RealNumber
    parameters: tuple[Sensitivity, ...]
    part: Part | None = None
    kind: CrossingKind | None = None

    def __getitem__(self, name: str) -> Sensitivity:
        return next(x for x in self.parameters if x.name == name)

    @property
    def reason(self) -> str:
        """Why there are no derivatives by any parameter; empty where there are some."""
        reasons = {x.reason for x in self.parameters}
        return reasons.pop() if len(reasons) == 1 else ""

    @property
    def ranked(self) -> tuple[Sensitivity, ...]:
        """The parameters, that with the largest elasticity first."""
        return tuple(sorted(self.parameters, key=lambda x: -abs(float(x.elasticity or 0))))


@dataclass(frozen=True)
class _Place:
    """A parameter as the rows call it, the symbol that it is in the equations, and its value."""

    path: str
    name: str
    unit: str
    symbol: Symbol
    value: RealNumber
    exact: Expr
    derivation: Derivation = field(repr=False)


@dataclass(frozen=True)
class Slopes:
    """How each crossing, changeover and the bandwidth of an evaluation moves with each parameter and the threshold."""

    evaluation: Evaluation = field(repr=False)

    @cached_property
    def crossings(self) -> tuple[Sensitive, ...]:
        """In ascending order."""
        return tuple(self._crossing(x) for x in self.evaluation.crossings)

    @cached_property
    def changeovers_environment(self) -> tuple[Sensitive, ...]:
        """Where Re H_env changes its sign."""
        return tuple(self._changeover("env", Curve.ENVIRONMENT, x) for x in self.evaluation.changeovers_environment)

    @cached_property
    def changeovers_perceived(self) -> tuple[Sensitive, ...]:
        """Where Re H_perc changes its sign."""
        return tuple(self._changeover("perc", Curve.PERCEIVED, x) for x in self.evaluation.changeovers_perceived)

    @cached_property
    def bandwidth(self) -> Sensitive | None:
        """The bandwidth; None where there is none."""
        end = self.evaluation.bandwidth
        if end is None:
            return None
        there = [x for x in self.crossings if x.omega is end and x.kind is not CrossingKind.TOUCHES]
        places = (*self._parameters, self._threshold(Part.REAL))
        reason = self._kink(end, there)
        if reason:
            return Sensitive(end, _none(places, reason))
        return there[0] if there else Sensitive(end, tuple(_still(p) for p in places))

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        listed = (*self.crossings, *self.changeovers_environment, *self.changeovers_perceived)
        decided = not any(p.reason.startswith("undecided") for x in listed for p in x.parameters)
        return self.evaluation.certified and decided

    @cached_property
    def _parameters(self) -> tuple[_Place, ...]:
        return tuple(self._named())

    def _named(self) -> Iterator[_Place]:
        scene = self.evaluation.scene
        for place, _, p in scene.placed():
            one, unit = derive(scene, [p.symbol.name]), p.dimension.unit(scene.motion)
            yield _Place(f"{place}.{p.key}", p.symbol.name, unit, p.symbol, ExactNumber(p.value), p.value, one)

    def _threshold(self, part: Part) -> _Place:
        limits = self.evaluation.scene.threshold
        alike = limits.real == limits.imag
        path, name = "evaluation.jnd" + ("" if alike else f".{part.value}"), "c" if alike else _THRESHOLD_NAMES[part]
        one = derive(self.evaluation.scene, ["c"])
        return _Place(path, name, "1", c, self._limit(part), limits[part], one)

    def _limit(self, part: Part) -> RealNumber:
        """The threshold as a number."""
        value = self.evaluation.scene.threshold[part]
        return SquareRoot(algebraic((value**2).expand())) if is_irrational_algebraic(value) else ExactNumber(value)

    def _crossing(self, x: Crossing) -> Sensitive:
        places = (*self._parameters, self._threshold(x.part))
        if x.multiplicity > 1:
            return Sensitive(x.omega, _none(places, TOUCH), x.part, x.kind)
        known = {c: self._limit(x.part)}
        rows = tuple(_at(p, p.derivation.factors(x.part), x.omega, known) for p in places)
        return Sensitive(x.omega, rows, x.part, x.kind)

    def _changeover(self, system: str, curve: Curve, x: Point) -> Sensitive:
        order = x.orders[curve, Part.REAL]
        if abs(order) > 1:
            return Sensitive(x.omega, _none(self._parameters, "undefined: Re H is tangent to 0 here"))
        rows = (_at(p, p.derivation.changeover_factors(system, pole=order < 0), x.omega, {}) for p in self._parameters)
        return Sensitive(x.omega, tuple(rows))

    def _kink(self, end: RealNumber, there: list[Sensitive]) -> str:
        """Why the bandwidth has no derivative; empty where it has."""
        e = self.evaluation
        below = self.crossings[: next((i + 1 for i, x in enumerate(self.crossings) if x.omega is end), None)]
        if e.undecided:
            return "undecided: whether a ratio touches its threshold on the band"
        if any(x.kind is CrossingKind.TOUCHES for x in below):
            return "undefined: the display touches its threshold within the bandwidth"
        if len(there) > 1:
            return "undefined: both ratios meet their thresholds here"
        if end is e.chart.points[0].omega or (there and there[0].reason):
            return TOUCH
        if there and end is e.chart.points[-1].omega:
            return "undefined: a ratio meets its threshold at the very end of the band"
        return ""


def _still(p: _Place) -> Sensitivity:
    return Sensitivity(p.path, p.name, p.unit, _ZERO, _ZERO)


def _none(places: tuple[_Place, ...], reason: str) -> tuple[Sensitivity, ...]:
    return tuple(Sensitivity(p.path, p.name, p.unit, None, None, reason) for p in places)


def _at(p: _Place, factors: tuple[Equation, ...], where: RealNumber, known: dict[Symbol, RealNumber]) -> Sensitivity:
    """The sensitivity of a simple zero of the product of some factors in omega and the parameter."""
    values = tuple({**known, omega: where, p.symbol: p.value}.items())
    equation = _the_one_that_holds(factors, values)
    if equation is None:
        return Sensitivity(p.path, p.name, p.unit, None, None, _MEET)
    slope = equation.slope(p.symbol)
    if slope.vanishes({p.symbol: p.exact}):
        return _still(p)
    derivative = _Slope(slope, values)
    if not derivative.is_clear():
        return Sensitivity(p.path, p.name, p.unit, None, None, _NOT_CLEAR)
    elasticity = _ZERO if p.exact == 0 else _Elasticity(derivative, p.value, where)
    return Sensitivity(p.path, p.name, p.unit, derivative, elasticity)


def _the_one_that_holds(factors: tuple[Equation, ...], values: _Values) -> Equation | None:
    """The only factor that is not proven to differ from 0; None if several stay."""
    bits = 64
    while len(factors) > 1 and bits <= _CLEAR_BITS:
        with flint.ctx.workprec(bits):
            balls = _balls(values, bits)
            factors = tuple(x for x in factors if not _is_clear(x.ball(balls)))
        bits *= 2
    return factors[0] if len(factors) == 1 else None


def _is_clear(ball: Ball) -> bool:
    return bool(ball > 0 or ball < 0)


def _balls(values: _Values, bits: int) -> dict[Expr, Ball]:
    return {symbol: number.ball(bits) for symbol, number in values}


@dataclass(frozen=True)
class _Slope(RealNumber):
    """An implicit derivative where its symbols have these values."""

    slope: ImplicitSlope
    values: _Values

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            above, below = self.slope.balls(_balls(self.values, bits))
            return -above / below

    def is_clear(self) -> bool:
        """Whether neither dF/dp nor dF/d omega is 0: proven."""
        bits = 64
        while bits <= _CLEAR_BITS:
            with flint.ctx.workprec(bits):
                if all(map(_is_clear, self.slope.balls(_balls(self.values, bits)))):
                    return True
            bits *= 2
        return False


@dataclass(frozen=True)
class _Elasticity(RealNumber):
    """value/omega times a slope."""

    slope: RealNumber
    value: RealNumber
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        slope, value, omega = (x.ball(bits) for x in (self.slope, self.value, self.omega))
        with flint.ctx.workprec(bits):
            return slope * value / omega
