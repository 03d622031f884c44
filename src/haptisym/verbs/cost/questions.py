"""Questions with certified answers: the ratios at frequencies, the crossings on a band; and how right another answer is.

An answer may come from anywhere: floats of a formula, roots of a companion matrix, sign changes on a grid. It is held against
a reference of higher precision. How hard the question itself is, whoever answers it, says its condition number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, isinf, isnan, log, log10
from typing import Any, TypeAlias

import flint
from flint import arb
from sympy import Expr, Rational

from haptisym.judge.criteria import Criterion, noticed
from haptisym.judge.crossings import Curve, find_crossings
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, SquareRoot
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import Chart, chart
from haptisym.kernel.symbols import omega as omega_
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part, Threshold
from haptisym.model.scene import Scene

DOUBLE = 53 * log10(2)
"""Decimal digits that a double holds."""
_LEAST = arb(2) ** -1075  # half the smallest double
_LIKE_IT = Rational(1, 100)  # an answer with fewer than two right digits is no answer to that crossing

AnswerNumber: TypeAlias = Any  # a float, a flint.arb, or decimal digits as text


@dataclass(frozen=True)
class Score:
    """How right an answer is: right decimal digits of its worst number; crossings that it lacks and that are none.

    A crossing that is missed has no right digits. ``wrong`` : of sets of parameters those with a wrong count, and how many
    were held against the truth.
    """

    digits: float
    missed: int = 0
    invented: int = 0
    wrong: tuple[int, int] | None = None


@dataclass(frozen=True)
class Found:
    """Crossings that somebody found, rad/s, by the names of the criteria; ``undecided``: places that are said to be left open."""

    omegas: Mapping[str, Sequence[AnswerNumber]]
    undecided: int = 0


@dataclass(frozen=True)
class RatioQuestion:
    """r_r and r_i at frequencies, rad/s, each a double taken at its exact value."""

    distortion: Distortion = field(repr=False)
    omegas: tuple[float, ...]

    def truth(self, digits: int) -> list[tuple[Ball, Ball]]:
        """Balls around both ratios at each frequency, so many digits right; infinite where a ratio is unbounded."""
        return [(self.ratio(Part.REAL, x, digits), self.ratio(Part.IMAG, x, digits)) for x in self.omegas]

    def ratio(self, part: Part, omega: float, digits: int) -> Ball:
        """A ball around one ratio at one frequency."""
        return _tight(SquareRoot(ValueAt(self.distortion.squared_ratios[part], _exact(omega))), digits)

    @cached_property
    def condition(self) -> float:
        """The largest relative change of a ratio for a relative change of the frequency, ``|omega r'/r|``; certified."""
        return max((self._sensitivity(part, x) for part in Part for x in self.omegas), default=0.0)

    def _sensitivity(self, part: Part, omega: float) -> float:
        if not omega or not 0 < self.ratio(part, omega, 5) < arb("inf"):
            return 0.0
        found = _Growth(self.distortion.squared_ratios[part], _exact(omega)).ball(_GROWTH_BITS)
        return abs(omega * float(found.mid()) / 2) if found.is_finite() else inf

    def score(self, answer: Iterable[Sequence[AnswerNumber]], truth: Sequence[Sequence[Ball]], held: float) -> Score:
        """The right digits of the worst of the values; no more than the ``held`` ones that their numbers can hold."""
        pairs = [p for given, true in zip(answer, truth, strict=True) for p in zip(given, true, strict=True)]
        return Score(min((right_digits(x, y, held) for x, y in pairs), default=held))


_GROWTH_BITS = 1024  # of what may be 0, and so has no relative accuracy


@dataclass(frozen=True)
class Crossings:
    """All frequencies of a band at which r_r or r_i meets its threshold, or dH the border of its region."""

    distortion: Distortion = field(repr=False)
    threshold: Threshold
    band: tuple[Expr, Expr]

    @classmethod
    def of(cls, scene: Scene) -> Crossings:
        """Of a scene."""
        return cls(scene.distortion(), scene.threshold, scene.band)

    @cached_property
    def criteria(self) -> tuple[Criterion, ...]:
        """What is judged."""
        return noticed(self.threshold)

    @cached_property
    def functions(self) -> Mapping[Any, Any]:
        """What tells the crossings: the signs of r^2 - c^2 and of dH."""
        d = self.distortion
        return {
            **{x: x.function(d) for x in self.criteria},
            **{(Curve.DIFFERENCE, part): part_of(d.difference_response, part) for part in Part},
        }

    def chart(self) -> Chart:
        """The certified answer."""
        return chart(self.functions, *self.band)

    def certified(self, digits: int) -> Found:
        """All crossings, so many digits right, and how many places stay open."""
        found = self.chart()
        omegas = {x.name: [_tight(omega, digits) for omega in _crossings(found, x)] for x in self.criteria}
        return Found(omegas, len(found.undecided))

    @cached_property
    def condition(self) -> float | None:
        """The largest relative change of a crossing for one of its threshold, ``c/|omega r'|``; infinite at a touch.

        None for a region whose border has corners.
        """
        found = self.chart()
        try:
            squares = {x: self._square(x) for x in self.criteria}
        except SceneError:
            return None
        pairs = ((square, omega) for x, square in squares.items() for omega in _crossings(found, x))
        return max((self._sensitivity(square, omega) for square, omega in pairs), default=0.0)

    def _square(self, x: Criterion) -> RealFunction:
        """Of the ratio, but for a number, or of how many times the region must be enlarged; SceneError where it is not smooth."""
        f = x.measure(self.distortion)
        return RealFunction((f.function / f.axis.convert(x.limit)).reduced()) if x.threshold.has(omega_) else f

    def _sensitivity(self, square: RealFunction, omega: RealNumber) -> float:
        if omega == ExactNumber(Rational(0)):
            return 0.0
        try:
            growth = _Growth(square, omega).tight_ball(60)
        except UndecidedError:  # no digit of the slope, however many bits: it is 0
            return inf
        return inf if growth == 0 else abs(float((2 / (omega.tight_ball(60) * growth)).mid()))

    def score(self, answer: Found, truth: Found, held: float) -> Score:
        """Right digits of the worst crossing that was found, and those missed and invented."""
        names = [x.name for x in self.criteria]
        scores = [_matched(answer.omegas[name], truth.omegas[name], held, float(self.band[1])) for name in names]
        return Score(
            min(x.digits for x in scores), sum(x.missed for x in scores), sum(x.invented for x in scores)
        )  # fmt: skip


Question: TypeAlias = RatioQuestion | Crossings


@dataclass(frozen=True, repr=False)
class _Growth(RealNumber):
    """f'/f of a real function at a frequency, from its numerator and its denominator."""

    function: RealFunction
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            at, f = self.omega.ball(bits), self.function.function
            above, below = (_growth(self.function, p, at) for p in (f.numerator, f.denominator))
            return above - below


def _growth(function: RealFunction, polynomial: Polynomial, at: Ball) -> Ball:
    axis = function.axis
    return RealFunction(axis.derivative(polynomial)).ball(at) / RealFunction(axis.function(polynomial)).ball(at)


def right_digits(given: AnswerNumber, true: Ball, held: float) -> float:
    """Correct decimal digits of a number, from its relative error; ``held`` at most.

    >>> right_digits(3.14, arb.pi(), DOUBLE)
    3.2950...
    >>> right_digits(float("nan"), arb(1), DOUBLE), right_digits(0.0, arb(0), 15.0)
    (0.0, 15.0)
    """
    if given in ("inf", "-inf", "nan"):
        given = float(given)
    if not true.is_finite():
        return held if isinstance(given, float) and isinf(given) else 0.0
    if isinstance(given, float) and (isnan(given) or isinf(given)):
        return 0.0
    with flint.ctx.workprec(max(128, int(4 * held) + 64)):
        error = abs(arb(given).mid() - true).upper()  # what the reference leaves open counts as error
        if error == 0 or (isinstance(given, float) and error <= _LEAST):
            return held
        if true == 0:
            return 0.0
        return _between(0.0, -float((error / abs(true).lower()).log().mid()) / log(10), held)


def _between(least: float, x: float, most: float) -> float:
    return min(max(least, x), most)


def _matched(given: Sequence[AnswerNumber], true: Sequence[Ball], held: float, high: float) -> Score:
    """Each true crossing takes the nearest number that is still free; what is left over is missed or invented."""
    with flint.ctx.workprec(max(128, int(4 * held) + 64)):
        near = sorted(
            ((float(abs(arb(y).mid() - x).mid()), i, j) for i, x in enumerate(true) for j, y in enumerate(given)),
        )
    left, free, digits = set(range(len(true))), set(range(len(given))), held
    for distance, i, j in near:
        if i in left and j in free and distance <= float(_LIKE_IT) * (float(true[i].mid()) or high):
            left.remove(i)
            free.remove(j)
            digits = min(digits, right_digits(given[j], true[i], held))
    return Score(0.0 if left else digits, len(left), len(free))


def _crossings(found: Chart, criterion: Criterion) -> list[RealNumber]:
    return [x.omega for x in find_crossings(found) if x.criterion == criterion]


def _exact(omega: float) -> ExactNumber:
    return ExactNumber(Rational(omega))


def _tight(x: RealNumber, digits: int) -> Ball:
    """A ball so many digits right; infinite where there is no such number."""
    bits = int(3.33 * digits) + 8
    for working in (128, 1024):
        if x.ball(working).is_finite():
            return x.tight_ball(bits)
    return arb("inf")


Attempt: TypeAlias = Callable[[], Any]
"""Something that answers a question when it is called, ready to be timed."""
