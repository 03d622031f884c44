"""Inverse design: for which values of a parameter a display is transparent on its whole band, and what binds at the ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial
from pathlib import Path

import flint
from sympy import Expr, Rational

from haptisym.judge.bounds import relative_square
from haptisym.judge.crossings import excess
from haptisym.kernel.budget import Told, limited, share
from haptisym.kernel.errors import LimitError, SceneError
from haptisym.kernel.levels import Level
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.shown import Answer, titled
from haptisym.model.jnd import Part
from haptisym.model.knobs import Knob
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.pages.require import page
from haptisym.verbs.require.cells import Leaf, Search
from haptisym.verbs.require.criticalvalues import Problem
from haptisym.verbs.require.feasible import End, Span, runs, spanned
from haptisym.verbs.require.freeparameter import (
    Conditions,
    Domain,
    any_environment_condition,
    conditions,
    domain,
)
from haptisym.verbs.require.nearest import Nearest, nearest
from haptisym.verbs.require.places import Verdict
from haptisym.verbs.require.required import Required
from haptisym.verbs.require.thresholds import ThresholdProblem

_SLIVER = Fraction(1, 10**9)
"""Relative width of values that may be given as an end by their enclosure alone."""


class Requirement(Answer, Required):
    """The values of one parameter for which a scene is transparent; ``print`` shows them as a page of text."""

    def _line(self) -> str:
        spans = " or ".join(map(spanned, self.feasible)) or "none will do"
        unit = f" ({self.free.unit})" if self.free.unit not in ("", "1") else ""
        return f"{titled(self.scene.title)}: {self.free.path}{unit}: {spans}"

    @cached_property
    def nearest(self) -> Nearest | None:
        """Where no value will do, the one that comes nearest; found in ten seconds or not at all."""
        return nearest(self, self._again)

    def _again(self, scene: Scene) -> Required:
        """The same question about another scene."""
        every = self.keys == (None,)
        free, parts = scene.knobs[self.free.path], [part for part in self.keys if part]
        found = any_environment_condition(scene, [free]) if every else conditions(scene, [free], parts)
        return _answered(replace(self, scene=scene, free=free), found)

    def __str__(self) -> str:
        return page(self)


def require(
    scene: Scene | str | Path,
    path: str,
    range: tuple[Number, Number] | None = None,  # noqa: A002 - the word that the question uses
    *,
    part: Part | None = None,
    any_environment: bool = False,
    digits: int = 15,
    limit: float | None = None,
    told: Told | None = None,
) -> Requirement:
    """The values of one parameter for which r_r <= c_real and r_i <= c_imag on the whole band: all of them, exactly.

    ``path`` : of the parameter, as ``effects.filter.omega_n``, ``environment.m``, ``evaluation.jnd``, or its symbol.
    ``range`` : the values asked about, numbers in SI or strings with a unit; all that the model allows if not given.
    ``part`` : ask for one part's condition only. ``any_environment`` : ask for |G - 1| <= c instead, which series effects G
    must keep to go unnoticed with every environment.

    ``limit`` : seconds after which what is proven so far is answered, all other values being undecided; None for no limit.
    ``told`` : is called now and then with how much is done, of how much, and what it is.

    For a rational scene the answer is exact and, without a limit, always complete. With delays, holds or powers of s it is
    certified by ball arithmetic; what that leaves open is in ``undecided``. SceneError where the path, the range or the scene
    is not fit.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = require(load_scene("fu2019"), "effects.filter.omega_n")
    >>> [(x.low.value.digits(12), x.high.value) for x in found.feasible]
    [('122.355814770', None)]
    """
    scene = as_scene(scene)
    if not isinstance(digits, int) or digits < 1:
        raise SceneError(f"digits: {digits} must be a whole number, at least 1")
    if part is not None and any_environment:
        raise SceneError("for any environment there are no parts: ask for one or the other")
    free = scene.knobs[path]
    asked = domain(free, range)
    keys = (part,) if part else tuple(Part)
    start = Requirement(scene, free, asked, (), (), (None,) if any_environment else keys, digits)
    with limited(limit, told) as budget:
        try:
            found = any_environment_condition(scene, [free]) if any_environment else conditions(scene, [free], keys)
            answer = _answered(start, found)
        except LimitError:
            answer = _open(start)
    return replace(answer, limit=budget.seconds if budget.reached else None)


def _open(start: Requirement) -> Requirement:
    """The answer that nothing is known."""
    low, high = (None if x is None else ExactNumber(x) for x in (start.domain.low, start.domain.high))
    return replace(start, undecided=((low, high),))


def _answered(start: Requirement, found: Conditions) -> Requirement:
    """By the way that fits the conditions; where critical values take too long, by balls in the time that is left."""
    scene, free, asked = start.scene, start.free, start.domain
    if free.parts:
        try:
            return replace(start, feasible=_threshold_problem(start).solve())
        except LimitError:
            return _open(start)
    if not any(f.axis.functions for f in found.values()):
        problem = Problem(found, free.symbol, scene.band, asked, partial(_allowed, scene, free))
        if problem.is_large:
            with share(_FOR_BALLS):
                quick = _by_balls(start, found)
            if not quick.undecided and not any(isinstance(x.value, Sliver) for x in quick.ends):
                return quick
        try:
            with share(_FOR_CRITICAL_VALUES):
                problem.prepare()
        except LimitError:
            return _by_balls(start, found)
        solved = problem.solve()
        return replace(start, feasible=solved.feasible, undecided=solved.undecided)
    return _by_balls(start, found)


_FOR_BALLS, _FOR_CRITICAL_VALUES = 0.4, 0.6
"""Of the time that is left: balls are quick about large devices; where critical values are not known by then, balls must do."""


def _threshold_problem(start: Requirement) -> ThresholdProblem:
    """The question for a threshold: the conditions that it is not part of stay as they are."""
    scene, free = start.scene, start.free
    d = scene.distortion()
    parts = [part for part in start.keys if part in (*free.parts, None)]
    squares = {part: d.squared_ratios[part] if part else relative_square(d) for part in parts}
    kept: Mapping[Part | None, RealFunction | Level] = {
        part: excess(d, scene.threshold[part], part) for part in start.keys if part and part not in free.parts
    }
    return ThresholdProblem({x: f for x, f in squares.items() if f is not None}, kept, scene.band, start.domain)


def _allowed(scene: Scene, free: Knob, value: Expr) -> bool:
    """Whether the scene exists at a value of the parameter."""
    try:
        free.put(scene, value).distortion()
    except SceneError:
        return False
    return True


def _by_balls(start: Requirement, found: Conditions) -> Requirement:
    asked, scene, free = start.domain, start.scene, start.free
    exists = {x: _allowed(scene, free, x) for x in (asked.low, asked.high) if x is not None}
    search = Search(found, free.symbol, scene.band, Fraction(abs(float(free.value)) or 1.0))
    low, high = _outward(asked)
    line = _Line(search.leaves(low, high), asked, exists.__getitem__)
    return replace(start, feasible=line.spans(), undecided=line.undecided)


def _outward(asked: Domain) -> tuple[Fraction | None, Fraction | None]:
    """Doubles that enclose the values that are asked about."""
    with flint.ctx.workprec(53):
        low, high = (None if x is None else expression_ball(x) for x in (asked.low, asked.high))
        return (
            None if low is None else Fraction(float(low.lower())),
            None if high is None else Fraction(float(high.upper())),
        )


@dataclass(frozen=True)
class _Line:
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
        if leaf.verdict is not Verdict.OPEN or not 0 < i < len(leaves) - 1:
            return leaf
        before, after = leaves[i - 1].above or leaves[i - 1].verdict, leaves[i + 1].verdict
        assert leaf.low is not None
        assert leaf.high is not None
        if before is after or leaf.high - leaf.low > _SLIVER * max(abs(leaf.low), abs(leaf.high)):
            return leaf
        return replace(leaf, verdict=before, above=after, value=Sliver(leaf.low, leaf.high))

    def spans(self) -> tuple[Span, ...]:
        """The values for which the conditions are kept."""
        low, high = self.domain.low, self.domain.high
        points: list[End] = [End(None if low is None else ExactNumber(low))]
        gaps: list[Verdict] = []
        for leaf in self._merged:
            if leaf.above is not None:
                gaps.append(leaf.verdict)
                points.append(End(leaf.value, bindings=(leaf.binding,) if leaf.binding else ()))
            gaps.append(leaf.above or leaf.verdict)
            points.append(End(None if leaf.high is None else ExactNumber(_rational(leaf.high))))
        points[-1] = End(None if high is None else ExactNumber(high))
        kept = [gap is Verdict.KEPT for gap in gaps]
        at = [bool(near) for near in (any(kept[max(i - 1, 0) : i + 1]) for i in range(len(points)))]
        at[0] = at[0] and low is not None and self.domain.holds_low and self.allowed(low)
        at[-1] = at[-1] and high is not None and self.domain.holds_high and self.allowed(high)
        return tuple(Span(replace(points[i], closed=a), replace(points[j], closed=b)) for i, j, a, b in runs(at, kept))

    @property
    def undecided(self) -> tuple[tuple[RealNumber | None, RealNumber | None], ...]:
        """The values about which nothing is proven."""
        return tuple((_number(leaf.low), _number(leaf.high)) for leaf in self._merged if leaf.verdict is Verdict.OPEN)


def _number(x: Fraction | None) -> RealNumber | None:
    return None if x is None else ExactNumber(_rational(x))


def _rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def is_quick(scene: Scene) -> bool:
    """Whether exact sets take milliseconds: low order, no delays nor powers of s, rational numbers.

    >>> from haptisym.model.scenefile import load_scene
    >>> is_quick(load_scene("fu2019")), is_quick(load_scene("delayed-spring"))
    (True, False)
    """
    d = scene.distortion()
    for part in Part:
        f = excess(d, scene.threshold[part], part)
        if not isinstance(f, RealFunction) or f.axis.functions:
            return False
        coefficients = f.axis.univariate(f.function.numerator)
        if coefficients is None or len(coefficients) > _QUICK_DEGREE + 1:
            return False
    return True


_QUICK_DEGREE = 12  # of the threshold polynomial in omega: a device of order 2
