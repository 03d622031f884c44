"""Where no value of a parameter makes a display transparent: the one that comes nearest, what binds there, and what is proven.

A value comes nearer than another if thresholds that are a smaller multiple of the scene's would do for it. For one value that
multiple is the largest r/c on the band, exact. Whether any value does with less is the question itself, asked once more with
larger thresholds: where the answer is empty, none does, proven.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, sqrt
from typing import Any, Protocol

from sympy import Expr, Integer, Rational

from haptisym.judge.criteria import Criterion
from haptisym.judge.peaks import Top, tops
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import RealNumber, SquareRoot, rational_between
from haptisym.kernel.symbols import omega
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.require.feasible import Binding, Kind, Span
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.solving import solve


class Asked(Protocol):
    """What a requirement is about, and what was found."""

    @property
    def scene(self) -> Scene: ...
    @property
    def free(self) -> Knob: ...
    @property
    def domain(self) -> Domain: ...
    @property
    def feasible(self) -> tuple[Span, ...]: ...
    @property
    def undecided(self) -> tuple[Any, ...]: ...
    @property
    def criteria(self) -> tuple[Criterion, ...]: ...


_SECONDS = 10.0
_STEPS, _CLOSE = 12, 1.02
_KINDS = {None: Kind.TOUCH, False: Kind.START, True: Kind.EDGE}


@dataclass(frozen=True)
class Nearest:
    """A value of the parameter, and by how much it fails.

    ``value``: SI. ``ratio``: the largest ratio at it, proven; ``binding``: of what, and where. ``times``: by how much the
    thresholds would have to be larger for this value; ``at_least``: by how much, at least, for any value asked about, proven.
    """

    value: Expr
    ratio: RealNumber
    binding: Binding
    times: float
    at_least: float


def nearest(r: Asked) -> Nearest | None:
    """The value that comes nearest where none will do, found in ten seconds; None where none shows."""
    plain = all(x.region is None and not x.threshold.has(omega) and x.threshold != 0 for x in r.criteria)
    if r.feasible or r.undecided or r.free.parts or not plain:
        return None
    best: Nearest | None = None
    least = 1.0
    try:
        with limited(_SECONDS):
            for value in _tried(r):
                best = _nearer(best, _at(r, value, least))
            for _ in range(_STEPS if best else 0):
                assert best is not None
                if best.times < least * _CLOSE:
                    break
                between = _simple(sqrt(least * best.times))
                if not least < float(between) < best.times:
                    break
                larger = [replace(x, threshold=(x.threshold * between).expand()) for x in r.criteria]
                found = solve(r.scene, r.free, r.domain, larger)
                if found.undecided:
                    break
                if not found.feasible:
                    least = float(between) * (1 - 1e-15)
                    continue
                span = found.feasible[0]
                inside = span.low.value if span.low is span.high else rational_between(span.low.value, span.high.value)
                if isinstance(inside, RealNumber):  # a single value, which need not be rational
                    break
                best = _nearer(best, _at(r, inside, least))
    except UndecidedError:
        pass
    return None if best is None else replace(best, at_least=least)


def _simple(x: float) -> Rational:
    near = Fraction(x).limit_denominator(1000)
    return Rational(near.numerator, near.denominator)


def _tried(r: Asked) -> Iterator[Expr]:
    """Some values of the domain: the scene's own, and its ends or powers of ten."""
    low, high = r.domain.low, r.domain.high
    listed = [r.free.value, low, high, *(Integer(10) ** n for n in range(-6, 7, 2))]
    for x in listed:
        if x is None or (low is not None and bool(x < low)) or (high is not None and bool(x > high)):
            continue
        if (x == low and not r.domain.holds_low) or (x == high and not r.domain.holds_high):
            continue
        yield x


def _nearer(one: Nearest | None, other: Nearest | None) -> Nearest | None:
    if one is None or other is None:
        return one or other
    return one if one.times <= other.times else other


def _at(r: Asked, value: Expr, least: float) -> Nearest | None:
    """How far a value is from doing; None where the scene does not exist at it, or a ratio has no bound."""
    try:
        scene = r.free.put(r.scene, value)
        d = scene.distortion()
    except SceneError:
        return None
    worst: tuple[float, Criterion, Top] | None = None
    for x in r.criteria:
        found = tops(x.measure(d), *scene.band)
        if found is None:
            return None
        top = max(found, key=lambda top: float(top.value))
        times = sqrt(max(float(top.value), 0.0)) / float(x.threshold)
        if worst is None or times > worst[0]:
            worst = times, x, top
    if worst is None or worst[0] == inf:
        return None
    times, x, top = worst
    return Nearest(value, SquareRoot(top.value), Binding(x, top.omega, _KINDS[top.end]), times, least)
