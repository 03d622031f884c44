"""The values of one parameter with which conditions hold, or thresholds; which values are asked about.

For which thresholds a display is transparent: from the largest value of its ratio on, exact, whatever the environment.

The condition r <= c on the whole band holds for c at least as large as the supremum of r there. That is the value at an end of
the band or at one of its local maxima, which are certified zeros of the slope: no value of c needs to be tried.

The values of one parameter with which conditions hold on a whole band, by the way that fits the conditions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial

import flint
from sympy import Expr, Rational, S

from haptisym.judge.crossings import Criterion
from haptisym.judge.peaks import Largest, Top, tops
from haptisym.judge.regions import Sided
from haptisym.kernel.budget import share
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, SquareRoot, expression_ball
from haptisym.kernel.roots import Signed, chart
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.scene import THRESHOLD, Knob, Scene
from haptisym.verbs.require.cells import Leaf, ValueSearch
from haptisym.verbs.require.criticalvalues import Problem, allowed, missing, without
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span, bound_ends, runs
from haptisym.verbs.require.floatcells import FloatCells
from haptisym.verbs.require.freeparameter import Conditions, Domain, conditions, each, pieces
from haptisym.verbs.require.places import CellVerdict

_TOLD_APART = (64, 256, 1024)
"""Bits with which the values of two local maxima are compared; what is alike to the last of them binds with the other."""


@dataclass(frozen=True)
class ThresholdProblem:
    """Squared ratios that one threshold judges on a band; ``kept``: what must not be positive besides, as it is."""

    squares: Mapping[Criterion, RealFunction]
    kept: Mapping[Criterion, Signed]
    band: tuple[Expr, Expr]
    domain: Domain

    def solve(self) -> tuple[Span, ...]:
        """All thresholds of the domain with which every ratio is kept on the whole band: one interval, or none."""
        low, high = self.domain.low, self.domain.high
        assert low is not None
        if self._exceeds(self.kept):
            return ()
        if high is not None and self._exceeds(self._excess(high)):
            return ()
        top = End(None if high is None else ExactNumber(high), self.domain.holds_high and high is not None)
        if not self._exceeds(self._excess(low)):
            return (Span(End(ExactNumber(low), self.domain.holds_low), top),)
        found = self._tops()
        if found is None:
            return ()
        bottom = End(SquareRoot(Largest(tuple(x.value for _, x in found))), closed=True, bindings=_bindings(found))
        if high is not None and self._touches(high):
            return (Span(bottom, bottom),) if self.domain.holds_high else ()
        return (Span(bottom, top),)

    def _excess(self, limit: Expr) -> dict[Criterion, Signed]:
        return {x: replace(x, threshold=limit).exceeded(square) for x, square in self.squares.items()}

    def _exceeds(self, conditions: Mapping[Criterion, Signed]) -> bool:
        table = chart(conditions, *self.band)
        exceeds = bool(table.where(lambda signs: any(sign > 0 for sign in signs.values())))
        if not exceeds and table.undecided:
            raise UndecidedError("whether a ratio that touches an end of the range goes beyond it")
        return exceeds

    def _touches(self, limit: Expr) -> bool:
        """Whether a ratio that does not exceed a limit meets it."""
        excess = self._excess(limit)
        if any(isinstance(x, RealFunction) and x.is_zero for x in excess.values()):
            return True  # at every frequency
        table = chart(excess, *self.band)
        return any(n > 0 for point in table.points for n in point.orders.values())

    def _tops(self) -> list[tuple[Criterion, Top]] | None:
        """The places at which the largest ratio is reached; None where one has no bound."""
        found: list[tuple[Criterion, Top]] = []
        for criterion, square in self.squares.items():
            own = tops(square, *self.band)
            if own is None:
                return None
            found += [(criterion, x) for x in own]
        for bits in _TOLD_APART:
            with flint.ctx.workprec(bits):
                balls = [x.value.ball(bits) for _, x in found]
                most = Largest(tuple(x.value for _, x in found)).ball(bits)
                found = [x for x, ball in zip(found, balls, strict=True) if not ball < most]
        return found


def _bindings(found: list[tuple[Criterion, Top]]) -> tuple[Binding, ...]:
    return tuple(Binding(criterion, x.omega, _KINDS[x.end]) for criterion, x in found)


_KINDS = {None: Kind.TOUCH, False: Kind.START, True: Kind.EDGE}


_SLIVER = Fraction(1, 10**9)
"""Relative width of values that may be given as an end by their enclosure alone."""


def solve(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> Solved:
    """All values of the domain that keep the conditions; those about which the time did not last are undecided."""
    try:
        if free.parts and not any(_has_floor(x) for x in criteria if x.depends_on(free.parts)):
            return Solved(_threshold_problem(scene, free, asked, criteria).solve())
        found, gone = conditions(scene, [free], criteria), missing(scene, free)
        if not any(free.symbol in f.axis.meanings for own in found.values() for f in pieces(own)):
            solved = _all_alike(scene, free, asked, found)
        else:
            solved = (_by_balls if _has_functions(found) else _exactly)(scene, free, asked, criteria, found)
        return replace(solved, feasible=without(solved.feasible, gone))
    except LimitError:
        return Solved((), ((_exact(asked.low), _exact(asked.high)),))


def _has_floor(x: Criterion) -> bool:
    return isinstance(x.region, Sided) and x.region.floor is not None


def _has_functions(found: Conditions) -> bool:
    return any(f.axis.functions for own in found.values() for f in pieces(own))


def _all_alike(scene: Scene, free: Knob, asked: Domain, found: Conditions) -> Solved:
    """Of a parameter that has left the conditions: all values at which the scene exists, or none."""
    for own in found.values():
        tops = [RealFunction(f.axis.function(f.function.numerator)) for f in pieces(own)]
        if chart(dict(enumerate(tops)), *scene.band).where(lambda signs: min(signs.values()) > 0):
            return Solved(())
    line = ValueLine([Leaf(None, None, CellVerdict.KEPT)], asked, partial(allowed, scene, free))
    return Solved(line.spans())


def _exactly(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion], found: Conditions) -> Solved:
    """By critical values; where these take too long, by balls in the time that is left."""
    problem = Problem(found, free.symbol, scene.band, asked, partial(allowed, scene, free))
    if problem.is_large:
        with share(_FOR_BALLS):
            quick = _by_balls(scene, free, asked, criteria, found)
        if not quick.undecided and not any(isinstance(x.value, Sliver) for x in bound_ends(quick.feasible)):
            return quick
    try:
        with share(_FOR_CRITICAL_VALUES):
            problem.prepare()
    except LimitError:
        return _by_balls(scene, free, asked, criteria, found)
    return problem.solve()


_FOR_BALLS, _FOR_CRITICAL_VALUES = 0.4, 0.6
"""Of the time that is left: balls are quick about large devices; where critical values are not known by then, balls must do."""


def _threshold_problem(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> ThresholdProblem:
    """The question for a threshold: the conditions that it is not part of stay as they are."""
    d = scene.distortion()
    own: dict[Criterion, RealFunction] = {}
    for x in criteria:
        if x.depends_on(free.parts):
            own |= _squares(x, d, free)
    return ThresholdProblem(
        own, {x: x.function(d) for x in criteria if not x.depends_on(free.parts)}, scene.band, asked
    )


def _squares(x: Criterion, d: Distortion, free: Knob) -> dict[Criterion, RealFunction]:
    """What a free threshold c judges, squares to be at most c^2: of a region about both parts where both limits are c."""
    if x.region is None:
        return {x: x.measure(d)}
    if x.joint and len(free.parts) < len(Part):
        raise SceneError(f"{free.path}: the {x.joint.kind} judges both parts at once: leave {THRESHOLD} free")
    squares = x.region.opened(dict.fromkeys(free.parts, S.One)).squares(d)
    return {each(x, i) if len(squares) > 1 else x: f for i, f in enumerate(squares, 1)}


def _by_balls(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion], found: Conditions) -> Solved:
    exists = {x: allowed(scene, free, x) for x in (asked.low, asked.high) if x is not None}
    usual = (0.0 if free.value.free_symbols else abs(float(free.value))) or 1.0  # a limit may be a formula
    quick = FloatCells(scene, free, criteria, usual)
    search = ValueSearch(found, free.symbol, scene.band, Fraction(usual), quick.told)
    low, high = _outward(asked)
    line = ValueLine(search.leaves(low, high), asked, exists.__getitem__)
    return Solved(line.spans(), line.undecided)


def _outward(asked: Domain) -> tuple[Fraction | None, Fraction | None]:
    """Doubles that enclose the values that are asked about."""
    with flint.ctx.workprec(53):
        low, high = (None if x is None else expression_ball(x) for x in (asked.low, asked.high))
        return (
            None if low is None else Fraction(float(low.lower())),
            None if high is None else Fraction(float(high.upper())),
        )


@dataclass(frozen=True)
class ValueLine:
    """The leaves of a search as points and gaps between them."""

    leaves: list[Leaf]
    domain: Domain
    allowed: Callable[[Expr], bool] = field(repr=False)

    @cached_property
    def _merged(self) -> list[Leaf]:
        """The leaves with neighbours of one verdict joined, and narrow open ones between two verdicts made ends."""
        joined: list[Leaf] = []
        for leaf in self.leaves:
            last = joined[-1] if joined else None
            if last and last.above is None and leaf.above is None and last.verdict is leaf.verdict:
                joined[-1] = replace(last, high=leaf.high)
            else:
                joined.append(leaf)
        return [self._as_end(i, joined) for i in range(len(joined))]

    def _as_end(self, i: int, leaves: list[Leaf]) -> Leaf:
        leaf = leaves[i]
        if leaf.verdict is not CellVerdict.OPEN or not 0 < i < len(leaves) - 1:
            return leaf
        before, after = leaves[i - 1].above or leaves[i - 1].verdict, leaves[i + 1].verdict
        assert leaf.low is not None
        assert leaf.high is not None
        if before is after or leaf.high - leaf.low > _SLIVER * max(-leaf.low, leaf.high):
            return leaf
        return replace(leaf, verdict=before, above=after, value=Sliver(leaf.low, leaf.high))

    def spans(self) -> tuple[Span, ...]:
        """The values for which the conditions are kept."""
        low, high = self.domain.low, self.domain.high
        points: list[End] = [End(_exact(low))]
        gaps: list[CellVerdict] = []
        for leaf in self._merged:
            if leaf.above is not None:
                gaps.append(leaf.verdict)
                points.append(End(leaf.value, bindings=(leaf.binding,) if leaf.binding else ()))
            gaps.append(leaf.above or leaf.verdict)
            points.append(End(None if leaf.high is None else ExactNumber(_rational(leaf.high))))
        points[-1] = End(_exact(high))
        kept = [gap is CellVerdict.KEPT for gap in gaps]
        at = [bool(near) for near in (any(kept[max(i - 1, 0) : i + 1]) for i in range(len(points)))]
        at[0] = at[0] and low is not None and self.domain.holds_low and self.allowed(low)
        at[-1] = at[-1] and high is not None and self.domain.holds_high and self.allowed(high)
        return tuple(Span(replace(points[i], closed=a), replace(points[j], closed=b)) for i, j, a, b in runs(at, kept))

    @property
    def undecided(self) -> tuple[tuple[RealNumber | None, RealNumber | None], ...]:
        """The values about which nothing is proven."""
        return tuple(
            (_number(leaf.low), _number(leaf.high)) for leaf in self._merged if leaf.verdict is CellVerdict.OPEN
        )


def _number(x: Fraction | None) -> RealNumber | None:
    return None if x is None else ExactNumber(_rational(x))


def _rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def _exact(x: Expr | None) -> RealNumber | None:
    return None if x is None else ExactNumber(x)
