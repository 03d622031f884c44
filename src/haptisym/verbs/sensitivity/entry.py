"""How each frequency of a scene moves with each parameter, as an answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from sympy import Expr

from haptisym.judge.answers import Answer
from haptisym.judge.criteria import Criterion
from haptisym.judge.crossings import Crossing, CrossingKind, Curve
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.lattices import Lattice, Piece, Signed
from haptisym.kernel.levels import algebraic
from haptisym.kernel.reals import ExactNumber, RealNumber, SquareRoot
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import Point, chart
from haptisym.kernel.shown import counted, titled
from haptisym.kernel.symbols import c
from haptisym.model.jnd import Part, is_irrational_algebraic
from haptisym.model.knobs import THRESHOLD
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.derive.entry import derive
from haptisym.verbs.sensitivity.slopes import (
    FLAT,
    TOUCH,
    Sensitive,
    Sensitivity,
    VariedParameter,
    at,
    none,
    still,
)

_BITS = 256
_SEVERAL = "undefined: several limits of the region meet here"


@dataclass(frozen=True, repr=False)
class Sensitivities(Answer):
    """How each crossing, changeover and the bandwidth of an evaluation moves with each parameter and the threshold."""

    _schema: ClassVar[str] = "haptisym.sensitivity/1"
    _page: ClassVar[str] = "haptisym.pages.sensitivity:page"
    _figure: ClassVar[str] = "haptisym.figures.sensitivity:elasticities_figure"

    evaluation: Evaluation

    def _line(self) -> str:
        changeovers = len(self.changeovers_environment) + len(self.changeovers_perceived)
        found = counted(len(self.crossings), "crossing"), counted(changeovers, "changeover")
        return f"{titled(self.evaluation.scene.title)}: {', '.join(found)}"

    @property
    def scene(self) -> Scene:
        """That of the evaluation."""
        return self.evaluation.scene

    @property
    def _varied(self) -> tuple[tuple[()], None]:
        return (), None

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
            VariedParameter(x, ExactNumber(x.value), derive(self.scene, [x.path])) for x in self.scene.parameters
        )

    @cached_property
    def _thresholds(self) -> dict[Criterion, VariedParameter]:
        if not self.scene.threshold.is_plain:  # no one number that it could be moved by
            return {}
        one, knobs = derive(self.scene, [THRESHOLD]), self.scene.knobs.limits.values()
        return {
            x: VariedParameter(knob, _limit(x), one) for x, knob in zip(self.evaluation.criteria, knobs, strict=True)
        }

    def _crossing(self, x: Crossing) -> Sensitive:
        own = self._thresholds.get(x.criterion)
        places = (*self._parameters, *([own] if own else []))
        known = {c: own.value} if own else {}
        flat = TOUCH if x.kind is CrossingKind.TOUCHES else FLAT if x.multiplicity > 1 and not float(x.omega) else ""
        of = self._deciding(x)
        if of is None:
            return Sensitive(x.omega, none(places, flat or _SEVERAL), x.criterion, x.kind)
        rows = (at(p, p.factors(of), x.omega, known, flat, simple=x.multiplicity == 1) for p in places)
        return Sensitive(x.omega, tuple(self._in_band(row, x.omega) for row in rows), x.criterion, x.kind)

    def _deciding(self, x: Crossing) -> Criterion | Piece | None:
        """What vanishes at a crossing: of a region one of its functions; None where it is not one alone."""
        lattice = x.criterion.function(self.evaluation.distortion)
        if not isinstance(lattice, Lattice):
            return x.criterion
        pieces = lattice.pieces(x.criterion)
        here = next((p for p in self._points(x.criterion, lattice) if _same(p.omega, x.omega)), None)
        if here is None:
            return None
        zeros = [piece for piece in pieces if here.orders.get(piece, 0) > 0]
        alike = [piece for piece in zeros if _alike(pieces[piece], pieces[zeros[0]])]
        return zeros[0] if zeros and len(alike) == len(zeros) else None

    def _points(self, criterion: Criterion, lattice: Lattice) -> tuple[Point, ...]:
        """Where the functions of a region vanish."""
        if criterion not in self._known:
            self._known[criterion] = chart(lattice.pieces(criterion), *self.scene.band).points
        return self._known[criterion]

    @cached_property
    def _known(self) -> dict[Criterion, tuple[Point, ...]]:
        return {}

    def _changeover(self, system: str, curve: Curve, x: Point) -> Sensitive:
        simple = abs(x.orders[curve, Part.REAL]) == 1
        rows = (at(p, p.factors(system), x.omega, {}, simple=simple) for p in self._parameters)
        return Sensitive(x.omega, tuple(self._in_band(row, x.omega) for row in rows))

    def _in_band(self, row: Sensitivity, where: RealNumber) -> Sensitivity:
        """At an end of the band the frequency leaves it on one side of the parameter's value."""
        ends = [point.omega for point in (self.evaluation.chart.points[0], self.evaluation.chart.points[-1])]
        if row.derivative is None or all(where is not end for end in ends) or float(row.derivative) == 0:
            return row
        inward = 1 if where is ends[0] else -1
        side = "above" if (float(row.derivative) > 0) == (inward > 0) else "below"
        other = {"above": "below", "below": "above"}[side]
        if row.side and row.side != side:
            return replace(row, derivative=None, elasticity=None, side="", reason="undefined: it leaves the band")
        return replace(row, side=side, reason=row.reason or f"from {side}; {other} it lies beyond the band")

    def _kink(self, end: RealNumber, there: list[Sensitive]) -> str:
        """Why the bandwidth has no derivative; empty where it has."""
        e = self.evaluation
        below = self.crossings[: max((i + 1 for i, x in enumerate(self.crossings) if x.omega is end), default=None)]
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
        digits = {key: None if x is None else x.digits(self.evaluation.digits) for key, x in values.items()}
        reason = ({"reason": p.reason} if p.reason else {}) | ({"side": p.side} if p.side else {})
        return {"path": p.path, "name": p.name, "unit": p.unit, **floats, "digits": digits, **reason}


def _same(x: RealNumber, y: RealNumber) -> bool:
    """Whether two certified frequencies are one, as far as bits go."""
    return bool(x.ball(_BITS).overlaps(y.ball(_BITS)))


def _alike(f: Signed, g: Signed) -> bool:
    """Whether two functions are the same, but for the sign."""
    if not isinstance(f, RealFunction) or not isinstance(g, RealFunction):
        return f is g
    return f.function.equals(g.function) or f.function.equals(-g.function)


def _limit(x: Criterion) -> RealNumber:
    """The threshold as a number."""
    irrational = is_irrational_algebraic(x.threshold)
    return SquareRoot(algebraic(x.limit)) if irrational else ExactNumber(x.threshold)


def sensitivity(scene: Scene | str | Path, digits: int = 15, *, limit: float | None = SECONDS) -> Sensitivities:
    """How each crossing, changeover and the bandwidth of a scene moves with each parameter and the threshold.

    Guaranteed: every number is a certified enclosure of the exact derivative, to as many ``digits`` as wanted; None, with the
    reason, where there is no derivative. Works for every scene that can be evaluated. ``limit`` : seconds after which a
    LimitError says that it is not decided; None for none. Raises SceneError if a parameter is still a symbol.

    >>> from haptisym.model.scenefile import load_scene
    >>> first = sensitivity(load_scene("fu2019")).crossings[0]
    >>> [(x.name, x.elasticity.digits(4)) for x in first.ranked[:2]]
    [('omega_n', '1.265'), ('zeta', '-1.245')]
    """
    scene = as_scene(scene)
    with limited(limit):
        found = Sensitivities(evaluate(scene, digits))
        _ = found.bandwidth, found.changeovers_environment, found.changeovers_perceived  # all that takes long
    return found
