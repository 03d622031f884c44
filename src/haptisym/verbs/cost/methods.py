"""Questions with certified answers, and the methods that answer them: haptisym's and usual ones.

The questions are the ratios at frequencies, and the crossings on a band. An answer may come from
anywhere: floats of a formula, transfer functions with expanded coefficients, sign changes on a
grid, eigenvalues of a companion matrix. It is compared with a certified reference of higher
precision. How hard the question itself is for any method is its condition number.

There is one table of methods for each question (``RATIO_METHODS``, ``CROSSINGS``), with what each
needs and whether it proves its answer. ``prepare`` makes what a method may know beforehand (its
formulas, its coefficients); only what it returns is timed.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from importlib import import_module
from math import inf, isinf, isnan, log, log10
from typing import Any, TypeAlias

import flint
import numpy as np
from flint import arb
from sympy import Expr, Float, Integer, Rational, lambdify

from haptisym.interop import to_control, to_scipy
from haptisym.judge.crossings import Criterion, PerceptFunction, find_crossings, noticed
from haptisym.judge.peaks import ValueAt
from haptisym.judge.regions import Sided
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import HaptisymError, SceneError, UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, SquareRoot
from haptisym.kernel.rings import omega as omega_
from haptisym.kernel.rings import s
from haptisym.kernel.roots import Chart, chart
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part, Threshold
from haptisym.model.scene import Scene
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array

DOUBLE = 53 * log10(2)
"""Decimal digits that a double holds."""
_LEAST = arb(2) ** -1075  # half the smallest double: what is nearer to a double rounds to it
_LIKE_IT = 0.01  # relative: an answer with fewer than two correct digits is none to that crossing
# Bits of a slope that may be 0, and so has no relative accuracy that could be reached by more.
_GROWTH_BITS = 1024

AnswerNumber: TypeAlias = Any  # a float, a flint.arb, or decimal digits as text


@dataclass(frozen=True)
class Score:
    """How good an answer is: the correct decimal digits of its worst number, 0 where a crossing is
    missed; the numbers of crossings missed, and of numbers that are no crossings (``invented``)."""

    digits: float
    missed: int = 0
    invented: int = 0


@dataclass(frozen=True)
class FoundCrossings:
    """The crossings that a method found, rad/s, by the names of the criteria; ``undecided``: the
    number of places that it reports as undecided."""

    omegas: Mapping[str, Sequence[AnswerNumber]]
    undecided: int = 0


@dataclass(frozen=True)
class RatioQuestion:
    """r_r and r_i at frequencies, rad/s, each a double taken at its exact value."""

    distortion: Distortion = field(repr=False)
    omegas: tuple[float, ...]

    def truth(self, digits: int) -> list[tuple[Ball, Ball]]:
        """Balls around both ratios at each frequency, with so many correct digits; infinite where a
        ratio is unbounded."""
        return [
            (self.ratio(Part.REAL, x, digits), self.ratio(Part.IMAG, x, digits))
            for x in self.omegas
        ]

    def ratio(self, part: Part, omega: float, digits: int) -> Ball:
        """A ball around one ratio at one frequency."""
        return _tight(
            SquareRoot(ValueAt(self.distortion.squared_ratios[part], ExactNumber(Rational(omega)))),
            digits,
        )

    @cached_property
    def condition(self) -> float:
        """The largest relative change of a ratio for a relative change of the frequency, ``|omega
        r'/r|``; certified."""
        return max((self._sensitivity(part, x) for part in Part for x in self.omegas), default=0.0)

    def _sensitivity(self, part: Part, omega: float) -> float:
        """``|omega r'/r|`` of one ratio: half that of r^2, whose logarithmic slope needs no root; 0
        where the ratio is 0 or infinite."""
        if not omega or not 0 < self.ratio(part, omega, 5) < arb("inf"):
            return 0.0
        found = _Growth(self.distortion.squared_ratios[part], ExactNumber(Rational(omega))).ball(
            _GROWTH_BITS
        )
        return abs(omega * float(found.mid()) / 2) if found.is_finite() else inf

    def score(
        self, answer: Iterable[Sequence[AnswerNumber]], truth: Sequence[Sequence[Ball]], held: float
    ) -> Score:
        """The correct digits of the worst of the values; no more than the ``held`` ones that their
        numbers can hold."""
        digits = [
            right_digits(x, y, held)
            for given, true in zip(answer, truth, strict=True)
            for x, y in zip(given, true, strict=True)
        ]
        return Score(min(digits, default=held))


@dataclass(frozen=True)
class Crossings:
    """All frequencies of a band at which r_r or r_i meets its threshold, or dH the border of its
    region."""

    distortion: Distortion = field(repr=False)
    threshold: Threshold
    band: tuple[Expr, Expr]

    @classmethod
    def of(cls, scene: Scene) -> Crossings:
        """The question about a scene."""
        return cls(scene.distortion(), scene.threshold, scene.band)

    @cached_property
    def criteria(self) -> tuple[Criterion, ...]:
        """The criteria."""
        return noticed(self.threshold)

    @cached_property
    def functions(self) -> Mapping[Any, Any]:
        """The functions that crossings are read from: r^2 - c^2, and both parts of dH."""
        d = self.distortion
        return {
            **{x: x.function(d) for x in self.criteria},
            **{
                (PerceptFunction.DIFFERENCE, part): part_of(d.difference_response, part)
                for part in Part
            },
        }

    def chart(self) -> Chart:
        """The certified answer."""
        return chart(self.functions, *self.band)

    def certified(self, digits: int) -> FoundCrossings:
        """All crossings with so many correct digits, and the number of undecided places."""
        found = self.chart()
        omegas = {
            x.name: [_tight(omega, digits) for omega in _crossings(found, x)] for x in self.criteria
        }
        return FoundCrossings(omegas, len(found.undecided))

    @cached_property
    def condition(self) -> float | None:
        """The largest relative change of a crossing for one of its threshold, ``c/|omega r'|``;
        infinite at a touch.

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
        """The square of the ratio, up to a constant, over that of a threshold that depends on
        omega; for a region that of the factor by which it must be enlarged. SceneError where it is
        not smooth."""
        f = x.measure(self.distortion)
        return (
            RealFunction((f.function / f.axis.convert(x.limit)).reduced())
            if x.threshold.has(omega_)
            else f
        )

    def _sensitivity(self, square: RealFunction, omega: RealNumber) -> float:
        """``c/|omega r'|`` at a crossing, where c = r: 2 over omega times the logarithmic slope of
        r^2. A crossing at 0 rad/s does not move in proportion to itself: 0."""
        if omega == ExactNumber(Rational(0)):
            return 0.0
        try:
            growth = _Growth(square, omega).tight_ball(60)
        # no digit of the slope, however many bits: it is 0
        except UndecidedError:
            return inf
        return inf if growth == 0 else abs(float((2 / (omega.tight_ball(60) * growth)).mid()))

    def score(self, answer: FoundCrossings, truth: FoundCrossings, held: float) -> Score:
        """Right digits of the worst crossing that was found, and those missed and invented."""
        names = [x.name for x in self.criteria]
        scores = [
            _matched(answer.omegas[name], truth.omegas[name], held, float(self.band[1]))
            for name in names
        ]
        return Score(
            min(x.digits for x in scores),
            sum(x.missed for x in scores),
            sum(x.invented for x in scores),
        )


Question: TypeAlias = RatioQuestion | Crossings


@dataclass(frozen=True, repr=False)
class _Growth(RealNumber):
    """The logarithmic slope f'/f of a real function at a frequency: that of its numerator less that
    of its denominator, so that no quotient has to be differentiated."""

    function: RealFunction
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            at, f, axis = self.omega.ball(bits), self.function.function, self.function.axis
            above, below = (
                RealFunction(axis.derivative(p)).ball(at) / RealFunction(axis.function(p)).ball(at)
                for p in (f.numerator, f.denominator)
            )
            return above - below


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
    # 4 bits for a digit, and some to spare: decimal text is read without an error that would count
    with flint.ctx.workprec(max(128, int(4 * held) + 64)):
        # what the reference leaves open counts as error
        error = abs(arb(given).mid() - true).upper()
        # below half the smallest double the given double is the nearest one
        if error == 0 or (isinstance(given, float) and error <= _LEAST):
            return held
        if true == 0:
            return 0.0
        return min(max(0.0, -float((error / abs(true).lower()).log().mid()) / log(10)), held)


def _matched(
    given: Sequence[AnswerNumber], true: Sequence[Ball], held: float, high: float
) -> Score:
    """Each true crossing takes the nearest number that is still free; what is left over is missed
    or invented."""
    with flint.ctx.workprec(max(128, int(4 * held) + 64)):
        near = sorted(
            (
                (float(abs(arb(y).mid() - x).mid()), i, j)
                for i, x in enumerate(true)
                for j, y in enumerate(given)
            )
        )
    left, free, digits = set(range(len(true))), set(range(len(given))), held
    # the nearest pairs first: a number that two crossings could claim goes to the nearer one
    for distance, i, j in near:
        # relative to the crossing, and to the band for one at 0 rad/s
        if i in left and j in free and distance <= _LIKE_IT * (float(true[i].mid()) or high):
            left.remove(i)
            free.remove(j)
            digits = min(digits, right_digits(given[j], true[i], held))
    return Score(0.0 if left else digits, len(left), len(free))


def _crossings(found: Chart, criterion: Criterion) -> list[RealNumber]:
    """The certified crossings of one criterion."""
    return [x.omega for x in find_crossings(found) if x.criterion == criterion]


def _tight(x: RealNumber, digits: int) -> Ball:
    """A ball with so many correct digits; infinite where no ball is finite, as at a pole."""
    # log2(10) bits for a digit, and 8 to spare
    bits = int(3.33 * digits) + 8
    for working in (128, 1024):
        if x.ball(working).is_finite():
            return x.tight_ball(bits)
    return arb("inf")


Attempt: TypeAlias = Callable[[], Any]
"""Something that answers a question when it is called, ready to be timed."""


_BLOCK = 1 << 14  # points that stay in the processor's cache


class UnfitMethodError(HaptisymError):
    """A method does not fit a question, or a package that it needs is missing; the text says
    which."""


# The ratios at frequencies: they answer with a pair (r_r, r_i) for each frequency.


def naive(distortion: Distortion) -> Callable[[Any], tuple[Any, Any]]:
    """H_env and H_perc - H_env on s = j omega, in complex floats as the formulas are written."""
    # effect by effect, as formulas are written: numerator and denominator are not multiplied out
    chain = distortion.chain
    perceived = chain.rendered
    for a, b, c, d in chain.matrices:
        perceived = (a * perceived + b) / (c * perceived + d)
    both = lambdify(s, [_with_floats(x) for x in (chain.environment, perceived)], "numpy", cse=True)

    def functions(omega: Any) -> tuple[Any, Any]:
        H, G = both(1j * omega)
        return H, G - H

    return functions


def _with_floats(form: Expr) -> Expr:
    """Numbers as floats, but for small whole ones: NumPy has no whole numbers as large as
    SymPy's."""
    numbers = {
        x: Float(x, 17)
        for x in form.atoms(Rational)
        if not (isinstance(x, Integer) and abs(x) < 100)
    }
    return form.xreplace(numbers)


def _ratios(H: Any, dH: Any, omega: Array) -> Array:
    """Both ratios, one row for each frequency."""
    size = np.abs(H)
    rows: Array = np.stack(
        [np.broadcast_to(np.abs(x) / size, omega.shape) for x in (np.real(dH), np.imag(dH))],
        axis=-1,
    )
    return rows


def _quietly(function: Callable[[], Any]) -> Any:
    """The result of a function, without warnings: what overflows or divides by zero is judged by
    its value, and warnings of other packages are not about a user's own call."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return function()


def naive_way(question: RatioQuestion) -> Attempt:
    """H_perc - H_env in floats, as SymPy's ``lambdify`` writes it."""
    function, omega = naive(question.distortion), np.array(question.omegas)
    return lambda: _quietly(lambda: _ratios(*function(omega), omega))


def control_way(question: RatioQuestion) -> Attempt:
    """The difference of two transfer functions of python-control."""
    H, G = _quietly(lambda: [to_control(x.expression()) for x in _rational(question.distortion)])
    difference, omega = G - H, np.array(question.omegas)
    return lambda: _quietly(lambda: _ratios(H(1j * omega), difference(1j * omega), omega))


def scipy_way(question: RatioQuestion) -> Attempt:
    """The difference of two frequency responses of ``scipy.signal``."""
    from scipy import signal

    H, G = _quietly(lambda: [to_scipy(x.expression()) for x in _rational(question.distortion)])
    omega = np.array(question.omegas)

    def attempt() -> Array:
        felt, given = (signal.freqs(x.num, x.den, omega)[1] for x in (G, H))
        return _ratios(given, felt - given, omega)

    return lambda: _quietly(attempt)


def _rational(distortion: Distortion) -> tuple[Any, Any]:
    """H_env and H_perc as quotients of polynomials; UnfitMethodError where they are none."""
    if distortion.perc.ring.functions:
        raise UnfitMethodError("delays and fractional powers are not possible")
    return distortion.env, distortion.perc


# Crossings: they answer with ``FoundCrossings``.


def margin(x: Criterion, omega: Any, H: Any, dH: Any) -> Any:
    """Positive where a change dH of H is noticed: a ratio less its limit, or the factor by which a
    region must be enlarged less 1."""

    def number(c: Expr) -> Any:
        return floats_of(c, omega)

    size = np.abs(H)
    if x.joint:
        real, imag = np.real(dH) / size, np.imag(dH) / size
        return x.joint.enlarged(real, imag, number) - 1
    part = np.real if x.part is Part.REAL else np.imag
    ratio = np.abs(part(dH)) / size
    if not isinstance(x.region, Sided):
        return ratio - number(x.threshold)
    # what grows and what shrinks have limits of their own
    grows = np.abs(part(H + dH)) - np.abs(part(H))
    higher, lower = number(x.region.higher), number(x.region.lower)
    unchanged = np.maximum(higher, lower)
    limit = np.where(grows > 0, higher, np.where(grows < 0, lower, unchanged))
    least = 0.0 if x.region.floor is None else floats_of(x.region.floor, omega) / size
    return ratio - np.maximum(limit, least)


def grid_way(question: Crossings, count: int, *, brent: bool = False) -> Attempt:
    """Changes of sign between the points of a grid, each by a straight line, or found by Brent's
    method."""
    function = naive(question.distortion)
    low, high = (float(x) for x in question.band)

    def excess(omega: Any, criterion: Criterion) -> Any:
        return margin(criterion, omega, *function(omega))

    def attempt() -> FoundCrossings:
        grid = np.linspace(low, high, count)
        found: dict[str, list[float]] = {x.name: [] for x in question.criteria}
        for start in range(0, count - 1, _BLOCK):
            # neighbouring blocks share a point, at which a zero counts once
            block = grid[start : start + _BLOCK + 1]
            H, dH = function(block)
            for x in question.criteria:
                values = np.broadcast_to(margin(x, block, H, dH), block.shape)
                refine = partial(_brent, partial(excess, criterion=x)) if brent else _straight
                found[x.name] += _changes(
                    block, values, refine, is_last=start + _BLOCK >= count - 1
                )
        return FoundCrossings(found)

    return lambda: _quietly(attempt)


Refine: TypeAlias = Callable[[float, float, float, float], float]


def _changes(grid: Array, values: Array, refine: Refine, *, is_last: bool) -> list[float]:
    """The zeros of a block of a grid: points at which a value is 0, and changes of sign."""
    at_points = np.flatnonzero(values == 0)
    # the last point of a block is the first one of the next
    found = [float(grid[i]) for i in at_points if is_last or i < len(grid) - 1]
    for i in np.flatnonzero(values[1:] * values[:-1] < 0):
        a, b = float(grid[i]), float(grid[i + 1])
        at_a, at_b = float(values[i]), float(values[i + 1])
        found.append(refine(a, b, at_a, at_b))
    return sorted(found)


def _straight(a: float, b: float, at_a: float, at_b: float) -> float:
    """The zero of the straight line between two points."""
    return a - at_a * (b - a) / (at_b - at_a)


def _brent(function: Callable[[Any], Any], a: float, b: float, at_a: float, at_b: float) -> float:
    """The zero of a function between two points by Brent's method, to all digits of a double."""
    from scipy.optimize import brentq

    return float(
        brentq(lambda omega: float(function(np.float64(omega))), a, b, xtol=1e-300, rtol=1e-15)
    )


def companion_way(question: Crossings) -> Attempt:
    """numpy.roots on the float coefficients of the exact polynomial in omega^2, or omega: the
    eigenvalues that are real."""
    low, high = (float(x) for x in question.band)
    rows = {x.name: _polynomial(question, x) for x in question.criteria}

    def attempt() -> FoundCrossings:
        found = {}
        for name, row in rows.items():
            is_even = not row[1::2].any()
            zeros = np.roots((row[::2] if is_even else row)[::-1])
            # the usual test: those that are computed to be exactly real
            omegas = zeros[np.isreal(zeros) & (zeros.real >= 0)].real
            omegas = np.sqrt(omegas) if is_even else omegas
            found[name] = sorted(float(x) for x in omegas[(omegas >= low) & (omegas <= high)])
        return FoundCrossings(found)

    return lambda: _quietly(attempt)


def _polynomial(question: Crossings, criterion: Criterion) -> Array:
    """The float coefficients of the polynomial in omega whose zeros are the crossings, ascending;
    UnfitMethodError where there is none."""
    excess = question.functions[criterion]
    if not isinstance(excess, RealFunction):
        raise UnfitMethodError("the border of the JND region is not one polynomial")
    row = (
        None
        if excess.axis.functions
        else excess.axis.univariate(excess.function.cleared().numerator)
    )
    if row is None:
        raise UnfitMethodError("the equation is not a polynomial with rational coefficients")
    return np.array([float(int(x.p) / int(x.q)) for x in row])


_BOTH = ("ratio_real", "ratio_imag")

Prepare: TypeAlias = Callable[[Any], Attempt]


@dataclass(frozen=True)
class Method:
    """A way to an answer.

    ``proves`` : whether its answers are certified. ``ours`` : whether it is haptisym's. ``held`` :
    decimal digits that its numbers hold. ``packages`` : what must be installed. ``prepare`` takes
    the question and raises UnfitMethodError where it does not fit. ``at_once`` : whether it answers
    for many frequencies at once, and should be timed so.
    """

    name: str
    prepare: Prepare
    proves: bool = False
    ours: bool = False
    held: float = DOUBLE
    packages: tuple[str, ...] = ()
    at_once: bool = True

    def ready(self, question: Any) -> Attempt:
        """The method, ready to answer the question."""
        for package in self.packages:
            try:
                import_module(package)
            except ImportError:
                raise UnfitMethodError(f"{package.partition('.')[0]} is not installed") from None
        try:
            return self.prepare(question)
        except OverflowError:
            raise UnfitMethodError("a coefficient is beyond the range of floats") from None


def _level(question: RatioQuestion, accuracy: str) -> Attempt:
    """The ratios by a function compiled for an accuracy: fast, double-double or certified."""
    function, omega = question.distortion.compile(accuracy, of=_BOTH), np.array(question.omegas)
    return lambda: np.stack([(v := function(omega)).ratio_real, v.ratio_imag], axis=-1)


def _digits(question: RatioQuestion, count: int) -> Attempt:
    """The ratios to so many certified digits, as text."""
    function, omega = question.distortion.compile(of=_BOTH), np.array(question.omegas)

    def attempt() -> list[tuple[str, str]]:
        found = function.digits(omega, count + 1)  # rounding takes up to one
        return [(str(x), str(y)) for x, y in zip(found.ratio_real, found.ratio_imag, strict=True)]

    return attempt


def _certified(question: Crossings, digits: int) -> Attempt:
    return lambda: question.certified(digits)


_ours = partial(Method, ours=True)
_proof = partial(Method, ours=True, proves=True)

NAIVE = Method("H_perc - H_env in floats", naive_way)
RATIO_METHODS: Mapping[str, Method] = {
    x.name: x
    for x in (
        NAIVE,
        Method("python-control", control_way, packages=("control",)),
        Method("scipy.signal", scipy_way, packages=("scipy.signal",)),
        *(_ours(x, partial(_level, accuracy=x)) for x in ("fast", "double-double")),
        _proof("certified", partial(_level, accuracy="certified")),
        *(
            _proof(f"{n} digits", partial(_digits, count=n), held=n, at_once=False)
            for n in (30, 100, 300)
        ),
    )
}
"""Ways to the ratios at given frequencies."""
CROSSINGS: Mapping[str, Method] = {
    x.name: x
    for x in (
        *(Method(f"grid of 10^{n}", partial(grid_way, count=10**n)) for n in range(2, 7)),
        Method(
            "grid of 10^4 + Brent",
            partial(grid_way, count=10**4, brent=True),
            packages=("scipy.optimize",),
        ),
        Method("numpy.roots", companion_way),
        *(
            _proof(f"certified, {n} digits", partial(_certified, digits=n), held=n)
            for n in (15, 50, 100, 300, 1000)
        ),
    )
}
"""Ways to the crossings on a band."""
