"""Where no value of a parameter makes a display transparent: the one that comes nearest, what binds there, and what is proven.

A value comes nearer than another if thresholds that are a smaller multiple of the scene's would do for it. For one value that
multiple is the largest r/c on the band, exact. Whether any value does with less is the question itself, asked once more with
larger thresholds: where the answer is empty, none does, proven.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, sqrt
from typing import Any, Protocol

from sympy import Expr, Rational

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
from haptisym.verbs.require.guesses import Guesses
from haptisym.verbs.require.solving import solve


class Asked(Protocol):
    """What a requirement is about, and what was found."""

    @property
    def scene(self) -> Scene:
        """The scene with its own values."""

    @property
    def free(self) -> Knob:
        """The number that is free."""

    @property
    def domain(self) -> Domain:
        """The values that were asked about."""

    @property
    def feasible(self) -> tuple[Span, ...]:
        """The values that were proven to do."""

    @property
    def undecided(self) -> tuple[Any, ...]:
        """The values that were left open."""

    @property
    def criteria(self) -> tuple[Criterion, ...]:
        """What must not be broken."""


_SECONDS = 5.0
"""Who asked for values that do needs to know about how far off all others are, not more."""
_CLOSE = (0.99, 0.9, 0.6)
"""Powers of how many times the thresholds the best value needs, for which no value is asked to do: the next if one stays open."""
_ROUNDS = 6
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
    at_least: float = 1.0


def nearest(r: Asked) -> Nearest | None:
    """The value that comes nearest where none will do, found in five seconds; None where none shows."""
    plain = all(x.region is None and not x.threshold.has(omega) and x.threshold != 0 for x in r.criteria)
    if r.feasible or r.undecided or r.free.parts or not plain:
        return None
    best: Nearest | None = None
    with suppress(UndecidedError), limited(_SECONDS):
        best = next(filter(None, (_at(r, value) for value in _tried(r))), None)
        for _ in range(_ROUNDS if best else 0):
            assert best is not None
            found = _bounded(r, best)
            if isinstance(found, float):
                return replace(best, at_least=found)
            better = None if found is None else _at(r, found)
            if better is None or better.times >= best.times:
                break
            best = better
    return best


def _tried(r: Asked) -> Iterator[Expr]:
    """Values that may come nearest: as floats tell, and the scene's own."""
    yield from Guesses(r.scene, r.free, r.domain, r.criteria).best()
    low, high, own = r.domain.low, r.domain.high, r.free.value
    if (low is None or bool(low < own)) and (high is None or bool(own < high)):
        yield own


def _bounded(r: Asked, best: Nearest) -> float | Expr | None:
    """By how much every value fails at least, or a value that comes nearer than the best; None where neither shows."""
    for power in _CLOSE:
        times = _simple(best.times**power)
        if not 1 < float(times) < best.times:
            return 1.0
        larger = [replace(x, threshold=(x.threshold * times).expand()) for x in r.criteria]
        found = solve(r.scene, r.free, r.domain, larger)
        if found.feasible:
            low, high = found.feasible[0].low.value, found.feasible[0].high.value
            return None if low is high and low is not None else rational_between(low, high)
        if not found.undecided:
            return float(times) * (1 - 1e-15)
    return None


def _simple(x: float) -> Rational:
    near = Fraction(x).limit_denominator(1000)
    return Rational(near.numerator, near.denominator)


def _at(r: Asked, value: Expr) -> Nearest | None:
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
    return Nearest(value, SquareRoot(top.value), Binding(x, top.omega, _KINDS[top.end]), times)
