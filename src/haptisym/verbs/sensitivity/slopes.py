"""How the frequencies of an evaluation move with each parameter: derivatives and elasticities, exact and certified.

A crossing is a simple zero of F(omega, p) = r^2 - c^2, so that d omega/dp = -(dF/dp)/(dF/d omega) there (implicit
differentiation). ``Derivation.sensitivity`` has the formula; here it is evaluated in ball arithmetic at the certified
frequency. Where the display touches its threshold dF/d omega is 0 and the derivative does not exist. Where zeros and poles meet
(``branches``), where a parameter has the least value that it may have, and at the ends of the band it may exist from one side.
Derivation: 14_sensitivity.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import flint
from sympy import Symbol

from haptisym.judge.criteria import Criterion
from haptisym.judge.crossings import CrossingKind
from haptisym.kernel.implicit import Equation
from haptisym.kernel.lattices import Piece
from haptisym.kernel.reals import Ball, RealNumber
from haptisym.kernel.shown import Shown, counted
from haptisym.kernel.symbols import omega
from haptisym.model.knobs import Knob, Knobs
from haptisym.model.parameters import Rule
from haptisym.verbs.derive.derivation import Derivation, Factors
from haptisym.verbs.sensitivity.branches import ZERO, Branch, Meeting, Slope, not_clear

TOUCH = "undefined: the display touches its threshold here"
_MEET = "undecided: several branches of the equation meet here"
_NOT_CLEAR = "undecided: dF/dp or dF/d omega is 0 here, or too near to it"
FLAT = "undefined: the ratio meets its threshold at 0 rad/s, where it is flat"
_LEAST = "from above; below there is no scene"


@dataclass(frozen=True)
class Sensitivity:
    """How a frequency moves with one parameter p: ``derivative`` = d omega/dp in rad/s per ``unit``, ``elasticity`` =
    (p/omega) d omega/dp (1). Certified; None where the derivative does not exist.

    ``side``: "above" or "below" where the derivative holds only for larger or for smaller values of the parameter.
    """

    knob: Knob
    derivative: RealNumber | None
    elasticity: RealNumber | None
    reason: str = ""
    """Why there are none, or only from one side."""
    side: str = ""

    @property
    def path(self) -> str:
        """The parameter's place in a scene file."""
        return self.knob.path

    @property
    def name(self) -> str:
        """That of its symbol, ``c`` (or ``c_real``, ``c_imag``) the threshold."""
        return self.knob.name

    @property
    def unit(self) -> str:
        """The parameter's; empty where it is not known."""
        return self.knob.unit_in(self.knob.motion)


@dataclass(frozen=True, repr=False)
class Sensitive(Shown):
    """A frequency, rad/s, and how it moves with each parameter; ``criterion``: of a crossing, whose it is."""

    omega: RealNumber
    parameters: tuple[Sensitivity, ...]
    criterion: Criterion | None = None
    kind: CrossingKind | None = None

    def _line(self) -> str:
        return f"{self.omega.digits(6)} rad/s: {counted(len(self.parameters), 'parameter')}"

    def __getitem__(self, name: str) -> Sensitivity:
        knob = Knobs(tuple(x.knob for x in self.parameters))[name]
        return next(x for x in self.parameters if x.knob is knob)

    @property
    def reason(self) -> str:
        """Why there are no derivatives by any parameter; empty where there are some."""
        reasons = {x.reason if x.derivative is None else "" for x in self.parameters}
        return reasons.pop() if len(reasons) == 1 else ""

    @property
    def ranked(self) -> tuple[Sensitivity, ...]:
        """The parameters, that with the largest elasticity first."""
        return tuple(sorted(self.parameters, key=lambda x: -abs(float(x.elasticity or 0))))


@dataclass(frozen=True)
class VariedParameter:
    """A parameter, its value, and the equations with its symbol left in."""

    knob: Knob
    value: RealNumber
    derivation: Derivation = field(repr=False)

    @property
    def least(self) -> bool:
        """Whether no smaller value makes a scene."""
        return self.knob.rule is Rule.NONNEGATIVE and self.knob.value == 0

    def factors(self, of: Criterion | Piece | str) -> Factors:
        """Of r^2 - c^2 of a criterion, of a function of a region, or of Re H: the factors above and below the line."""
        if of not in self._known:
            self._known[of] = self.derivation.factors(of)
        return self._known[of]

    @cached_property
    def _known(self) -> dict[Criterion | Piece | str, Factors]:
        return {}


def still(p: VariedParameter) -> Sensitivity:
    """Of a frequency that does not depend on the parameter."""
    return Sensitivity(p.knob, ZERO, ZERO)


def none(places: tuple[VariedParameter, ...], reason: str) -> tuple[Sensitivity, ...]:
    """Of a frequency that has no derivative by any of them."""
    return tuple(Sensitivity(p.knob, None, None, reason) for p in places)


def at(
    p: VariedParameter,
    factors: Factors,
    where: RealNumber,
    known: dict[Symbol, RealNumber],
    flat: str = "",
    *,
    simple: bool,
) -> Sensitivity:
    """The sensitivity of a frequency at which one or more of these factors vanish.

    ``flat``: why nothing that depends on the parameter has a derivative; ``simple``: whether it is a simple zero or pole.
    """
    values = tuple({**known, omega: where, p.knob.symbol: p.value}.items())
    meeting = not_clear(factors, values)
    if meeting and not any(_depends(equation, p.knob.symbol) for equation, _ in meeting):
        return still(p)
    if flat:
        return replace(still(p), derivative=None, elasticity=None, reason=flat)
    if len(meeting) != 1 or not simple:
        return _met(p, Meeting(meeting, p.knob.symbol, values), where)
    slope = Slope(meeting[0][0].slope(p.knob.symbol), values)
    if slope.slope.vanishes({p.knob.symbol: p.knob.value}):
        return _one_sided(p, ZERO, where)
    if not slope.is_clear():
        if Meeting(meeting, p.knob.symbol, values).is_still():
            return _one_sided(p, ZERO, where)
        return Sensitivity(p.knob, None, None, _NOT_CLEAR)
    return _one_sided(p, slope, where)


def _depends(equation: Equation, x: Symbol) -> bool:
    return bool(equation.partial(x))


def _one_sided(p: VariedParameter, derivative: RealNumber, where: RealNumber) -> Sensitivity:
    """A derivative that holds on both sides, as far as there are two."""
    elasticity = ZERO if p.knob.value == 0 or derivative is ZERO else _Elasticity(derivative, p.value, where)
    least = p.least and derivative is not ZERO
    side, reason = ("above", _LEAST) if least else ("", "")
    return Sensitivity(p.knob, derivative, elasticity, reason, side)


def _met(p: VariedParameter, meeting: Meeting, where: RealNumber) -> Sensitivity:
    """The sensitivity where several zeros and poles meet."""
    sides = meeting.sides()
    if sides is None:
        return Sensitivity(p.knob, None, None, _MEET)
    below, above = (_alone(side) for side in sides)
    nothing = Sensitivity(p.knob, None, None)
    if p.least:
        return replace(nothing, reason=f"undefined: {above}") if isinstance(above, str) else _one_sided(p, above, where)
    if isinstance(below, str) and isinstance(above, str):
        return replace(nothing, reason=f"undefined: {above if above == below else f'{above} above, {below} below'}")
    if isinstance(below, str) or isinstance(above, str):
        side, there, other = ("above", above, below) if isinstance(below, str) else ("below", below, above)
        assert isinstance(there, RealNumber)
        row = _one_sided(p, there, where)
        return replace(row, side=side, reason=f"from {side}; on the other side {other}")
    if below == above:
        return _one_sided(p, above, where)
    return replace(nothing, reason=f"undefined: {below.digits(5)} from below, {above.digits(5)} from above")


def _alone(branches: list[Branch]) -> RealNumber | str:
    """The slope of a branch that is alone, or what there is instead of one."""
    if not branches:
        return "it is not there"
    if len(branches) > 1:
        return "it splits into several"
    return branches[0] or "it moves infinitely fast"


@dataclass(frozen=True, repr=False)
class _Elasticity(RealNumber):
    """value/omega times a slope."""

    slope: RealNumber
    value: RealNumber
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        slope, value, omega = (x.ball(bits) for x in (self.slope, self.value, self.omega))
        with flint.ctx.workprec(bits):
            return slope * value / omega
