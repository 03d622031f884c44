"""How crossings, changeovers and the bandwidth move with each parameter: derivatives and
elasticities, exact and certified.

A crossing is a simple zero of F(omega, p) = r^2 - c^2, so that d omega/dp = -(dF/dp)/(dF/d omega)
there (implicit differentiation). ``Derivation.sensitivity`` has the formula; here it is evaluated
in ball arithmetic at the certified frequency. Where the display touches its threshold dF/d omega is
0 and the derivative does not exist, nor at a triple zero, which moves as the cube root of what p
moves by. Where a parameter has the least value that it may have, and at the ends of the band, it
may exist from one side. Where several zeros and poles meet, as at a pole without damping, it is
undecided. ``at`` is where to begin reading. Derivation: 14_sensitivity.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer, Symbol, pi

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, Crossing, CrossingKind, PerceptFunction
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, at_rising_precision
from haptisym.kernel.rings import c, omega
from haptisym.kernel.roots import Lattice, LatticePiece, Point, Signed, chart
from haptisym.kernel.solutions import Equation, ImplicitSlope
from haptisym.kernel.zeros import is_clear
from haptisym.model.jnd import Part
from haptisym.model.parameters import Rule
from haptisym.model.scene import THRESHOLD, Knob, Knobs, Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.derive.derivation import Derivation, derive

_USUAL_BITS = 128  # at least, so that most questions about one slope share one evaluation
Factors: TypeAlias = tuple[tuple[Equation, int], ...]
"""Irreducible factors as equations, each with its order."""
SymbolValues: TypeAlias = tuple[tuple[Symbol, RealNumber], ...]
ZERO = ExactNumber(Integer(0))
"""The derivative of what does not move at first order."""


def not_clear(factors: Factors, values: SymbolValues) -> Factors:
    """The factors that are not proven to differ from 0 at these values, of which at least one
    vanishes there."""

    # Balls prove that a factor is not 0, never that it is: where all but one are clear, the one
    # that is left vanishes. Where two vanish the precision rises to its limit.
    def alone(bits: int) -> Factors | None:
        nonlocal factors
        known = balls(values, bits)
        factors = tuple(
            (factor, order) for factor, order in factors if not is_clear(factor.ball(known))
        )
        return factors if len(factors) <= 1 else None

    if len(factors) > 1:
        at_rising_precision(alone, 64)
    return factors


def balls(values: SymbolValues, bits: int) -> dict[Expr, Ball]:
    """Enclosures of exact values, and of pi at the working precision."""
    return {pi: arb.pi(), **{symbol: number.ball(bits) for symbol, number in values}}


@dataclass(frozen=True, repr=False)
class Slope(RealNumber):
    """The number that an implicit derivative is where its symbols have these values."""

    slope: ImplicitSlope
    values: SymbolValues

    def ball(self, bits: int) -> Ball:
        above, below = self._parts(bits)
        with flint.ctx.workprec(bits):
            return -above / below

    def _parts(self, bits: int) -> tuple[Ball, Ball]:
        """Balls around dF/dp and dF/d omega; a float, five digits and a sign are read off the same
        ones."""
        enough = max(bits, _USUAL_BITS)
        if enough not in self._known:
            with flint.ctx.workprec(enough):
                self._known[enough] = self.slope.balls(balls(self.values, enough))
        return self._known[enough]

    @cached_property
    def _known(self) -> dict[int, tuple[Ball, Ball]]:
        return {}

    def changes(self) -> bool:
        """Whether dF/dp is not 0: proven."""
        return bool(
            at_rising_precision(lambda bits: is_clear(self._parts(bits)[0]) or None, _USUAL_BITS)
        )

    def is_clear(self) -> bool:
        """Whether neither dF/dp nor dF/d omega is 0: proven."""
        return bool(
            at_rising_precision(
                lambda bits: all(map(is_clear, self._parts(bits))) or None, _USUAL_BITS
            )
        )


# A reason that begins with "undefined" is an answer, one with "undecided" is none (``certified``).
TOUCH = "undefined: the display touches its threshold here"
_MEET = "undecided: several zeros and poles meet here"
STEEP = "undefined: at this multiple zero the slope is infinite"
_NOT_CLEAR = "undecided: dF/dp or dF/d omega is 0 here, or too near to it"
FLAT = "undefined: the ratio crosses its threshold at 0 rad/s, where it is flat"
_LEAST = "from above; below there is no scene"


@dataclass(frozen=True)
class Sensitivity:
    """How a frequency moves with one parameter p: ``derivative`` = d omega/dp in rad/s per
    ``unit``, ``elasticity`` = (p/omega) d omega/dp (1). Certified; None where the derivative does
    not exist.

    ``side``: "above" or "below" where the derivative holds only for larger or for smaller values of
    the parameter.
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
        """The name of its symbol; ``c`` (or ``c_real``, ``c_imag``) for the threshold."""
        return self.knob.name

    @property
    def unit(self) -> str:
        """The parameter's unit; empty where it is not known."""
        return self.knob.unit_in(self.knob.motion)


@dataclass(frozen=True, repr=False)
class Sensitive(Shown):
    """A frequency, rad/s, and how it moves with each parameter; ``criterion``, ``kind``: of a
    crossing, None for any other frequency."""

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
        """The parameters in order of the modulus of their elasticity, the largest first."""
        return tuple(sorted(self.parameters, key=lambda x: -abs(float(x.elasticity or 0))))


@dataclass(frozen=True)
class VariedParameter:
    """A parameter, its value, and the formulas of the scene in which its symbol is left, all other
    numbers being in place."""

    knob: Knob
    value: RealNumber
    derivation: Derivation = field(repr=False)

    @property
    def least(self) -> bool:
        """Whether no smaller value makes a scene."""
        return self.knob.rule is Rule.NONNEGATIVE and self.knob.value == 0

    def factors(self, of: Criterion | LatticePiece | str) -> Factors:
        """The factors of numerator and denominator of r^2 - c^2 for a criterion, of a function of a
        region, or of Re H of a system."""
        if of not in self._known:
            self._known[of] = self.derivation.factors(of)
        return self._known[of]

    @cached_property
    def _known(self) -> dict[Criterion | LatticePiece | str, Factors]:
        return {}


def still(p: VariedParameter) -> Sensitivity:
    """The sensitivity of a frequency that does not depend on the parameter."""
    return Sensitivity(p.knob, ZERO, ZERO)


def none(places: tuple[VariedParameter, ...], reason: str) -> tuple[Sensitivity, ...]:
    """The sensitivities of a frequency that has no derivative by any of the parameters."""
    return tuple(Sensitivity(p.knob, None, None, reason) for p in places)


def at(
    p: VariedParameter,
    factors: Factors,
    where: RealNumber,
    known: dict[Symbol, RealNumber],
    flat: str,
    multiplicity: int,
) -> Sensitivity:
    """The sensitivity of a frequency at which one or more of these factors vanish.

    ``flat``: why nothing that depends on the parameter has a derivative; ``multiplicity``: of the
    zero or pole.
    """
    # Of the factor that vanishes alone: it has a simple zero where the whole function may have a
    # multiple one, and then moves like any other.
    values = tuple({**known, omega: where, p.knob.symbol: p.value}.items())
    meeting = not_clear(factors, values)
    if meeting and not any(_depends(equation, p.knob.symbol) for equation, _ in meeting):
        return still(p)
    if flat:
        return replace(still(p), derivative=None, elasticity=None, reason=flat)
    if len(meeting) != 1:
        return Sensitivity(p.knob, None, None, _MEET)
    [(equation, order)] = meeting
    slope = Slope(equation.slope(p.knob.symbol), values)
    # as a zero of the factor alone, apart from the order that this has in the function
    is_simple = multiplicity <= abs(order)
    # dF/dp = 0 identically in omega, as where only p^2 occurs and p = 0: decided by the form, since
    # no ball around 0 shows that it is 0
    if is_simple and slope.slope.vanishes({p.knob.symbol: p.knob.value}):
        return _one_sided(p, ZERO, where)
    if not slope.is_clear():
        # at a multiple zero dF/d omega is 0: where dF/dp is proven not to be, the slope is infinite
        is_undecided = is_simple or not slope.changes()
        return Sensitivity(p.knob, None, None, _NOT_CLEAR if is_undecided else STEEP)
    return _one_sided(p, slope, where)


def _in_time(p: VariedParameter, of: Criterion | LatticePiece | str, *where: Any) -> Sensitivity:
    """The sensitivity of a frequency; undecided where the time is over before it is found."""
    try:
        return at(p, p.factors(of), *where)
    except LimitError as error:
        return Sensitivity(p.knob, None, None, f"undecided: {error}")


def _depends(equation: Equation, x: Symbol) -> bool:
    """Whether a parameter occurs in an equation."""
    return bool(equation.partial(x))


def _one_sided(p: VariedParameter, derivative: RealNumber, where: RealNumber) -> Sensitivity:
    """The sensitivity with this derivative, which holds on both sides of the value, or above it
    where there is no scene below."""
    # at p = 0 the factor p/omega is 0; what does not move has elasticity 0, wherever it is
    elasticity = (
        ZERO if p.knob.value == 0 or derivative is ZERO else _Elasticity(derivative, p.value, where)
    )
    least = p.least and derivative is not ZERO
    side, reason = ("above", _LEAST) if least else ("", "")
    return Sensitivity(p.knob, derivative, elasticity, reason, side)


@dataclass(frozen=True, repr=False)
class _Elasticity(RealNumber):
    """An elasticity: value/omega times a slope."""

    slope: RealNumber
    value: RealNumber
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        slope, value, omega = (x.ball(bits) for x in (self.slope, self.value, self.omega))
        with flint.ctx.workprec(bits):
            return slope * value / omega


_BITS = 256
_SEVERAL = "undefined: several limits of the region meet here"


@dataclass(frozen=True, repr=False)
class Sensitivities(Answer):
    """How each crossing, changeover and the bandwidth moves with each parameter p and with the
    threshold.

    With F(omega, p) = 0, which defines the frequency, ``d omega/dp = -F_p/F_omega``. ``crossings``,
    ``changeovers_environment``,
    ``changeovers_perceived`` : in ascending order; ``bandwidth`` : None where there is none. Each
    has for every parameter
    ``derivative``, rad/s per SI unit of p, and ``elasticity``, (p/omega) d omega/dp: proven
    enclosures; None, with the reason, where there is no derivative, as at a tangency. Derivation:
    14_sensitivity. Made by ``sensitivity``.
    """

    _schema: ClassVar[str] = "haptisym.sensitivity/1"
    _page: ClassVar[str] = "haptisym.pages.sensitivity:page"
    _figure: ClassVar[str] = "haptisym.figures.effects:SENSITIVITY"

    evaluation: Evaluation

    def _line(self) -> str:
        changeovers = len(self.changeovers_environment) + len(self.changeovers_perceived)
        found = counted(len(self.crossings), "crossing"), counted(changeovers, "changeover")
        return f"{titled(self.evaluation.scene.title)}: {', '.join(found)}"

    @property
    def scene(self) -> Scene:
        """The scene of the evaluation."""
        return self.evaluation.scene

    @property
    def _varied(self) -> tuple[tuple[()], None]:
        return (), None

    @cached_property
    def crossings(self) -> tuple[Sensitive, ...]:
        """The crossings, in ascending order."""
        return tuple(self._crossing(x) for x in self.evaluation.crossings)

    @cached_property
    def changeovers_environment(self) -> tuple[Sensitive, ...]:
        """The frequencies at which Re H_env changes its sign."""
        return tuple(
            self._changeover("env", PerceptFunction.ENVIRONMENT, x)
            for x in self.evaluation.changeovers_environment
        )

    @cached_property
    def changeovers_perceived(self) -> tuple[Sensitive, ...]:
        """The frequencies at which Re H_perc changes its sign."""
        return tuple(
            self._changeover("perc", PerceptFunction.PERCEIVED, x)
            for x in self.evaluation.changeovers_perceived
        )

    @cached_property
    def bandwidth(self) -> Sensitive | None:
        """The bandwidth; None where there is none."""
        end = self.evaluation.bandwidth
        if end is None:
            return None
        there = [x for x in self.crossings if x.omega is end and x.kind is not CrossingKind.TOUCHES]
        places = (*self._parameters, *list(self._thresholds.values())[:1])
        reason = self._kink(end, there)
        if reason:
            return Sensitive(end, none(places, reason))
        return there[0] if there else Sensitive(end, tuple(still(p) for p in places))

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        listed = (*self.crossings, *self.changeovers_environment, *self.changeovers_perceived)
        decided = not any(p.reason.startswith("undecided") for x in listed for p in x.parameters)
        return self.evaluation.certified and decided

    @cached_property
    def _parameters(self) -> tuple[VariedParameter, ...]:
        return tuple(
            VariedParameter(x, ExactNumber(x.value), derive(self.scene, [x.path]))
            for x in self.scene.parameters
            if x.symbol not in self.scene.chain.harmonic_symbols
        )

    @cached_property
    def _thresholds(self) -> dict[Criterion, VariedParameter]:
        """The threshold of each criterion as a parameter; none where it is no single number."""
        if not self.scene.threshold.is_plain:
            return {}
        one, knobs = derive(self.scene, [THRESHOLD]), self.scene.knobs.limits.values()
        return {
            x: VariedParameter(knob, ExactNumber(x.threshold), one)
            for x, knob in zip(self.evaluation.criteria, knobs, strict=True)
        }

    def _crossing(self, x: Crossing) -> Sensitive:
        """A crossing and how it moves with each parameter and with its threshold."""
        threshold = self._thresholds.get(x.criterion)
        places = (*self._parameters, *([threshold] if threshold else []))
        known = {c: threshold.value} if threshold else {}
        flat = ""
        if x.kind is CrossingKind.TOUCHES:
            flat = TOUCH
        elif x.multiplicity > 1 and not float(x.omega):
            # r^2 - c^2, even in omega, has a multiple zero at 0 rad/s
            flat = FLAT
        of = self._deciding(x)
        if of is None:
            return Sensitive(x.omega, none(places, flat or _SEVERAL), x.criterion, x.kind)
        rows = (_in_time(p, of, x.omega, known, flat, x.multiplicity) for p in places)
        return Sensitive(
            x.omega, tuple(self._in_band(row, x.omega) for row in rows), x.criterion, x.kind
        )

    def _deciding(self, x: Crossing) -> Criterion | LatticePiece | None:
        """What vanishes at a crossing: the criterion, or one function of its region; None where
        several different ones vanish, as at a corner of the region."""
        lattice = x.criterion.function(self.evaluation.distortion)
        if not isinstance(lattice, Lattice):
            return x.criterion
        pieces = lattice.pieces(x.criterion)
        here = next(
            (p for p in self._points(x.criterion, lattice) if _same(p.omega, x.omega)), None
        )
        if here is None:
            return None
        zeros = [piece for piece in pieces if here.orders.get(piece, 0) > 0]
        alike = [piece for piece in zeros if _alike(pieces[piece], pieces[zeros[0]])]
        return zeros[0] if zeros and len(alike) == len(zeros) else None

    def _points(self, criterion: Criterion, lattice: Lattice) -> tuple[Point, ...]:
        """The points of the band at which functions of a region vanish."""
        if criterion not in self._known:
            self._known[criterion] = chart(lattice.pieces(criterion), *self.scene.band).points
        return self._known[criterion]

    @cached_property
    def _known(self) -> dict[Criterion, tuple[Point, ...]]:
        return {}

    def _changeover(self, system: str, curve: PerceptFunction, x: Point) -> Sensitive:
        """A changeover frequency and how it moves with each parameter."""
        # a change of sign may be at a pole of Re H too, which has a negative order
        multiplicity = abs(x.orders[curve, Part.REAL])
        rows = (_in_time(p, system, x.omega, {}, "", multiplicity) for p in self._parameters)
        return Sensitive(x.omega, tuple(self._in_band(row, x.omega) for row in rows))

    def _in_band(self, row: Sensitivity, where: RealNumber) -> Sensitivity:
        """The sensitivity of a frequency that must stay on the band: at an end of the band it
        leaves it on one side of the parameter's value, and the derivative holds on the other."""
        points = self.evaluation.chart.points
        ends = [point.omega for point in (points[0], points[-1])]
        if (
            row.derivative is None
            or all(where is not end for end in ends)
            or float(row.derivative) == 0
        ):
            return row
        inward = 1 if where is ends[0] else -1
        side = "above" if (float(row.derivative) > 0) == (inward > 0) else "below"
        other = {"above": "below", "below": "above"}[side]
        if row.side and row.side != side:
            return replace(
                row,
                derivative=None,
                elasticity=None,
                side="",
                reason="undefined: it leaves the band",
            )
        return replace(
            row, side=side, reason=row.reason or f"from {side}; {other} it lies beyond the band"
        )

    def _kink(self, end: RealNumber, there: list[Sensitive]) -> str:
        """Why the bandwidth has no derivative; empty where it has one."""
        e = self.evaluation
        # all crossings where the bandwidth is the band's end, and no crossing
        last = max((i + 1 for i, x in enumerate(self.crossings) if x.omega is end), default=None)
        below = self.crossings[:last]
        # A touch may become two crossings with the smallest change of a parameter, and the
        # bandwidth then jumps down to the first of them.
        if e.undecided:
            return "undecided: whether a ratio touches its threshold on the band"
        if any(x.kind is CrossingKind.TOUCHES for x in below):
            return "undefined: the display touches its threshold within the bandwidth"
        if len(there) > 1:
            return "undefined: both ratios cross their thresholds here"
        if end is e.chart.points[0].omega:
            return TOUCH
        if there and there[0].reason:
            return there[0].reason
        if there and end is e.chart.points[-1].omega:
            return "undefined: a ratio crosses its threshold at the very end of the band"
        return ""

    def formula(self, part: Part, name: str) -> Expr:
        """d omega/d parameter at a crossing of that part, in omega and all parameters.

        ``name`` : any that the scene's ``knobs`` know; SceneError for another one.
        """
        return derive(self.scene).sensitivity(part, self.scene.knobs[name].felt().symbol)

    def _body(self) -> dict[str, Any]:
        return {
            "crossings": [self._row(x) for x in self.crossings],
            "changeovers": {
                "environment": [self._row(x) for x in self.changeovers_environment],
                "perceived": [self._row(x) for x in self.changeovers_perceived],
            },
            "bandwidth": None if self.bandwidth is None else self._row(self.bandwidth),
            "certified": self.certified,
        }

    def _row(self, x: Sensitive) -> dict[str, Any]:
        part = {"part": x.criterion.name} if x.criterion else {}
        kind = {"kind": x.kind.value} if x.kind else {}
        reason = {"reason": x.reason} if x.reason else {}
        rows = [self._parameter(p) for p in x.parameters]
        return {**part, "omega": float(x.omega), **kind, **reason, "parameters": rows}

    def _parameter(self, p: Sensitivity) -> dict[str, Any]:
        values = {"derivative": p.derivative, "elasticity": p.elasticity}
        floats = {key: None if x is None else float(x) for key, x in values.items()}
        digits = {
            key: None if x is None else x.digits(self.evaluation.digits)
            for key, x in values.items()
        }
        reason = ({"reason": p.reason} if p.reason else {}) | ({"side": p.side} if p.side else {})
        return {
            "path": p.path,
            "name": p.name,
            "unit": p.unit,
            **floats,
            "digits": digits,
            **reason,
        }


def _same(x: RealNumber, y: RealNumber) -> bool:
    """Whether two certified frequencies are one, to ``_BITS``: they are zeros of functions that
    share factors, in two charts of one scene."""
    return bool(x.ball(_BITS).overlaps(y.ball(_BITS)))


def _alike(f: Signed, g: Signed) -> bool:
    """Whether two functions are the same, but for the sign."""
    if not isinstance(f, RealFunction) or not isinstance(g, RealFunction):
        return f is g
    return f.function.equals(g.function) or f.function.equals(-g.function)


def sensitivity(
    scene: Scene | str | Path, digits: int = 15, *, limit: float | None = SECONDS
) -> Sensitivities:
    """How each crossing, changeover and the bandwidth of a scene moves with each parameter and the
    threshold.

    Proven: every number is a certified enclosure of the exact derivative, to as many ``digits``
    as wanted; None, with the reason, where there is no derivative. Works for every scene that can
    be evaluated. ``limit`` : seconds of processor time after which all further derivatives are
    undecided; None for none. LimitError where the crossings are. Raises SceneError if a parameter
    is still a symbol.

    >>> from haptisym.model.scenefile import load_scene
    >>> first = sensitivity(load_scene("fu2019")).crossings[0]
    >>> [(x.name, x.elasticity.digits(4)) for x in first.ranked[:2]]
    [('omega_n', '1.265'), ('zeta', '-1.245')]
    """
    scene = as_scene(scene)
    with limited(limit):
        found = Sensitivities(evaluate(scene, digits))
        # all that takes long, while the limit holds; the bandwidth needs the crossings
        _ = found.bandwidth, found.changeovers_environment, found.changeovers_perceived
    return found
