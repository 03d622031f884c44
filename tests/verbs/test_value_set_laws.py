"""Requirements whose critical values are all known by hand: which values do, which ends belong, and what binds at them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import prod
from random import Random

import mpmath
import pytest
from sympy import Expr, Integer, Poly, Rational, pi, symbols

import haptisym as hs
from haptisym.judge.criteria import Criterion, noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega
from haptisym.verbs.require.closedforms import closed_form
from haptisym.verbs.require.criticalvalues import Problem
from haptisym.verbs.require.feasible import Kind, Solved
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.solving import _outward
from haptisym.verbs.require.thresholds import ThresholdProblem

T = symbols("t", real=True)
REAL, IMAG = noticed(hs.Threshold())
SPAN = tuple[Fraction | None, bool, Fraction | None, bool]


@dataclass(frozen=True)
class Line:
    """c0 + c1 x + c2 u to a power: x is omega or omega^2, u the parameter or its cube."""

    c0: int
    c1: int
    c2: int
    power: int

    def at(self, x: Fraction, u: Fraction) -> Fraction:
        return (self.c0 + self.c1 * x + self.c2 * u) ** self.power

    def zero(self, u: Fraction) -> Fraction | None:
        """Of x."""
        return Fraction(-self.c0 - self.c2 * u, self.c1) if self.c1 else None

    def value(self, x: Fraction) -> Fraction | None:
        """Of u, at which it is 0 there."""
        return Fraction(-self.c0 - self.c1 * x, self.c2) if self.c2 else None

    def meets(self, other: Line) -> Fraction | None:
        below = self.c2 * other.c1 - other.c2 * self.c1
        return Fraction(other.c0 * self.c1 - self.c0 * other.c1, below) if below else None


@dataclass(frozen=True)
class Product:
    """Lines above the line, with a sign, and numbers u - b below it, squared."""

    sign: int
    lines: tuple[Line, ...]
    below: tuple[int, ...]

    def at(self, x: Fraction, u: Fraction) -> Fraction:
        return self.sign * prod((line.at(x, u) for line in self.lines), start=Fraction(1))

    def function(self, x: Expr, u: Expr) -> RealFunction:
        top = prod(((y.c0 + y.c1 * x + y.c2 * u) ** y.power for y in self.lines), start=Integer(self.sign))
        return RealFunction(Ring([T]).axis.convert(top / prod(((u - b) ** 2 for b in self.below), start=Integer(1))))


@dataclass(frozen=True)
class Posed:
    """Conditions, each of one function or of two that must not both be positive, on a band of x."""

    conditions: tuple[tuple[Product, ...], ...]
    band: tuple[Fraction, Fraction]

    @property
    def critical(self) -> list[Fraction]:
        own = [line for x in self.conditions for f in x for line in f.lines]
        found = [line.value(end) for line in own for end in self.band]
        found += [a.meets(b) for x in self.conditions for a in _lines(x) for b in _lines(x) if a != b]
        found += [Fraction(b) for x in self.conditions for f in x for b in f.below]
        return sorted({x for x in found if x is not None})

    def holds(self, u: Fraction) -> bool:
        """By the signs between the zeros of the lines."""
        return not any(self._is_broken(x, u) for x in self.conditions)

    def _is_broken(self, condition: tuple[Product, ...], u: Fraction) -> bool:
        if any(u in f.below for f in condition):
            return True
        zeros = [z for line in _lines(condition) if (z := line.zero(u)) is not None]
        marks = sorted({*self.band, *(z for z in zeros if self.band[0] < z < self.band[1])})
        return any(all(f.at((a + b) / 2, u) > 0 for f in condition) for a, b in pairwise(marks))

    def spans(self, low: Fraction | None, high: Fraction | None) -> list[SPAN]:
        """The values that do, between two ends that belong."""
        marks = [x for x in self.critical if (low is None or x > low) and (high is None or x < high)]
        marks = [*([low] if low is not None else []), *marks, *([high] if high is not None else [])]
        if not marks:
            return _runs([(None, self.holds(Fraction(0)))])
        places: list[tuple[Fraction | None, Fraction]] = [] if low is not None else [(None, marks[0] - 1)]
        for a, b in pairwise(marks):
            places += [(a, a), (None, (a + b) / 2)]
        places += [(marks[-1], marks[-1])]
        places += [] if high is not None else [(None, marks[-1] + 1)]
        told = [(at, self.holds(u)) for at, u in places]
        return _runs(told)


def _lines(condition: tuple[Product, ...]) -> list[Line]:
    return [line for f in condition for line in f.lines]


def _runs(told: list[tuple[Fraction | None, bool]]) -> list[SPAN]:
    """Values (a number) and what lies between them (None) in turn, each with whether it does, as spans."""
    found, first = list[SPAN](), None
    for i, (_, does) in enumerate([*told, (None, False)]):
        if does and first is None:
            first = i
        if not does and first is not None:
            low, high = told[first][0], told[i - 1][0]
            before = told[first - 1][0] if first and low is None else low
            after = told[i][0] if i < len(told) and high is None else high
            found.append((before, low is not None, after, high is not None))
            first = None
    return found


def drawn(pick: Random) -> Posed:
    def line() -> Line:
        while True:
            found = Line(
                pick.randint(-4, 4), pick.choice([0, 1, 1, -1, 2]), pick.randint(-2, 2), pick.choice([1, 1, 2])
            )
            if found.c1 or found.c2:
                return found

    def function() -> Product:
        lines = [line() for _ in range(pick.randint(1, 3))]
        below = [
            b for b in pick.sample(range(-3, 4), pick.choice([0, 0, 1])) if all(x.c1 or x.c0 + x.c2 * b for x in lines)
        ]
        return Product(pick.choice([1, -1]), tuple(lines), tuple(below))

    low = pick.choice([0, 0, 1])
    return Posed(
        tuple(tuple(function() for _ in range(pick.choice([1, 1, 2]))) for _ in range(pick.choice([1, 2]))),
        (Fraction(low), Fraction(low + pick.randint(1, 4))),
    )


def _agree(pick: Random) -> int:
    posed, squared, cubed, bounded = drawn(pick), pick.random() < 0.6, pick.random() < 0.4, pick.random() < 0.4
    x, u = omega**2 if squared else omega, T**3 if cubed else T
    band = tuple(Rational(e) ** (Rational(1, 2) if squared else 1) for e in posed.band)
    if not all(e.is_Rational for e in band):
        return 0
    conditions = {
        name: f[0].function(x, u) if len(f) == 1 else Lattice((tuple(y.function(x, u) for y in f),))
        for name, f in zip((REAL, IMAG), posed.conditions, strict=False)
    }
    ends = (Fraction(-8), Fraction(1)) if bounded else (None, None)
    own = [None if e is None else Integer(-2 if cubed and e < 0 else int(e)) for e in ends]
    found = Problem(conditions, T, band, Domain(*own, holds_low=True, holds_high=True), lambda _: True).solve()
    assert found.undecided == ()
    expected = posed.spans(*ends)
    assert [(a is None, b, c is None, d) for a, b, c, d in expected] == [
        (s.low.value is None, s.low.closed, s.high.value is None, s.high.closed) for s in found.feasible
    ]
    for (low, _, high, _), span in zip(expected, found.feasible, strict=True):
        for truth, end in ((low, span.low), (high, span.high)):
            if truth is not None:
                a, b = end.value.bounds(80)
                assert (a**3 <= truth <= b**3) if cubed else (a <= truth <= b)
    _bind(posed, found, {REAL: 0, IMAG: 1}, (ends, cubed, squared))
    return len(expected)


def _bind(posed: Posed, found: Solved, places: dict[Criterion, int], asked: tuple[object, bool, bool]) -> None:
    """What binds is at the band's end that is said, or inside; a function of that condition vanishes there."""
    ends, cubed, squared = asked
    marks = posed.critical
    for span in found.feasible:
        for end in (span.low, span.high):
            if end.value is None:
                continue
            a, b = (y**3 if cubed else y for y in end.value.bounds(80))
            u = next((x for x in (*marks, *(e for e in ends if e is not None)) if a <= x <= b), None)
            assert u is not None
            for binding in end.bindings:
                own = posed.conditions[places[binding.criterion]]
                if binding.omega is None:
                    continue
                x0, x1 = (y**2 if squared else y for y in binding.omega.bounds(80))
                low, high = posed.band
                assert {Kind.START: x0 <= low <= x1, Kind.EDGE: x0 <= high <= x1}.get(
                    binding.kind, low <= x1 and x0 <= high
                )
                if u not in (y for f in own for y in f.below):
                    assert any(
                        line.zero(u) is None or x0 <= line.zero(u) <= x1
                        for line in _lines(own)
                        if line.zero(u) is not None or line.value(Fraction(0)) == u
                    )


@pytest.mark.parametrize("seed", range(3))
def test_values_that_do_are_those_of_signs_between_zeros_that_are_known(seed: int) -> None:
    """Products of lines in omega or its square, and in a parameter or its cube, so that ends are algebraic too."""
    pick = Random(seed)
    assert sum(_agree(pick) for _ in range(5)) > 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 106))
def test_values_that_do_are_those_of_signs_between_zeros_that_are_known_of_many_conditions(seed: int) -> None:
    pick = Random(seed)
    assert sum(_agree(pick) for _ in range(100)) > 50


def test_what_binds_at_an_end_of_the_band_is_told_once_though_zeros_meet_there() -> None:
    """(2 w + t - 3)(3 - w - t) is positive between two zeros that meet at frequency 0 for t = 3, and behind which t is free."""
    meeting = Product(1, (Line(-3, 2, 1, 1), Line(3, -1, -1, 1)), ()).function(omega, T)
    found = Problem({REAL: meeting}, T, (Integer(0), Integer(1)), Domain(Integer(2), None), lambda _: True).solve()
    [span] = found.feasible
    assert [(b.kind, b.omega.digits(5)) for b in span.low.bindings if b.omega] == [(Kind.START, "0")]


# --- formulas --------------------------------------------------------------------------------------------------------


def _formula(pick: Random) -> tuple[Expr, Expr] | None:
    """A random condition at a frequency, with the formula for the parameter; None where none is told."""
    a, b, place = symbols("a b w", positive=True)
    known = {x: Rational(pick.randint(1, 9), pick.randint(1, 5)) for x in (a, b, place)}
    coefficients = [pick.choice([1, -1, 2, a, b, a * b, -a]) for _ in range(3)]
    shape = sum(c * T**n * omega ** (2 * pick.randint(0, 2)) for n, c in enumerate(coefficients))
    roots = Poly(shape.subs({**known, omega: known[place]}), T).nroots(n=70)
    real = [x for x in roots if x.is_real and x != 0]
    if not real:
        return None
    axis = Ring([T, a, b]).axis
    found = closed_form(RealFunction(axis.convert(shape)), T, place, known, str(pick.choice(real)))
    return None if found is None else (shape.subs(omega, place), found)


@pytest.mark.few("8")
@pytest.mark.parametrize("seed", range(16))
def test_a_formula_for_a_parameter_solves_the_condition_whatever_the_numbers_are(seed: int) -> None:
    """Not only with those for which it was found, whichever of the roots was meant."""
    pick, count = Random(seed), 0
    while count < (2 if seed == 8 else 5):
        told = _formula(pick)
        if told is None:
            continue
        count += 1
        condition, form = told
        with mpmath.workdps(40):
            other = {x: Rational(pick.randint(1, 90), 17) for x in condition.free_symbols - {T}}
            left = condition.subs(T, form).subs(other).evalf(40)
            assert abs(left) < 1e-25


# --- thresholds ------------------------------------------------------------------------------------------------------


def _cubic(pick: Random) -> tuple[Expr, list[Fraction]]:
    """In W = omega^2, with slopes 0 at rational numbers: the function, and these numbers."""
    p, q = (Fraction(pick.randint(-2, 20), pick.randint(1, 2)) for _ in range(2))
    k, c = Fraction(pick.choice([0, 1, -1, 2]), pick.randint(1, 4)), Fraction(pick.randint(-9, 9), 3)
    W = omega**2
    slope = [k * p * q, -k * (p + q), k]
    return sum((Rational(x) * W ** (n + 1) / (n + 1) for n, x in enumerate(slope)), Rational(c)), [p, q] if k else []


def _largest(f: Expr, stops: list[Fraction], band: tuple[int, int]) -> tuple[Rational, list[Rational]]:
    """Of |f| between two W, and where."""
    low, high = (Fraction(x**2) for x in band)
    places = sorted({low, high, *(x for x in stops if low < x < high)})
    sizes = {x: abs(f.subs(omega**2, Rational(x))) for x in places}
    most = max(sizes.values())
    return most, [Rational(x) for x in places if sizes[x] == most]


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in range(1, 12))])
def test_thresholds_that_do_begin_with_the_largest_ratio_whatever_range_is_asked_about(seed: int) -> None:
    """Of two ratios that are |polynomials| in omega^2, at ends of the range that lie below, at and above it."""
    pick = Random(seed)
    for _ in range(12 if seed else 4):
        band = (pick.choice([0, 1]), pick.randint(2, 4))
        rows = [_cubic(pick) for _ in range(pick.choice([1, 2]))]
        axis = Ring().axis
        squares = {
            x: RealFunction(axis.convert((f**2).expand())) for x, (f, _) in zip((REAL, IMAG), rows, strict=False)
        }
        told = {x: _largest(f, stops, band) for x, (f, stops) in zip((REAL, IMAG), rows, strict=False)}
        most = max(x for x, _ in told.values())
        kept = {} if pick.random() < 0.8 else {IMAG: RealFunction(axis.convert(omega**2 - Integer(band[1] ** 2 - 1)))}
        near = [Integer(0), most / 2, most, most + 1, None]
        i = pick.randrange(4)
        asked = Domain(near[i], near[pick.randrange(i + 1, 5)], pick.random() < 0.5, pick.random() < 0.5)
        if asked.low == asked.high:
            continue
        found = ThresholdProblem(squares, kept, tuple(map(Integer, band)), asked).solve()
        low = max(asked.low, most)
        empty = kept or (asked.high is not None and (low > asked.high or (low == asked.high and not asked.holds_high)))
        assert bool(found) is not bool(empty)
        for span in found:
            assert Rational(str(span.low.value.digits(30))) == Rational(str(ExactNumber(low).digits(30)))
            assert span.low.closed is (bool(asked.low < most) or asked.holds_low)
            assert (span.high.value is None) is (asked.high is None)
            assert span.high.closed is (asked.high is not None and asked.holds_high)
            if asked.low < most:
                places = sorted((x.name, w) for x, (size, own) in told.items() if size == most for w in own)
                told_at = sorted((b.criterion.name, float(b.omega or 0) ** 2) for b in span.low.bindings)
                assert [name for name, _ in told_at] == [name for name, _ in places]
                assert [w for _, w in told_at] == pytest.approx([float(w) for _, w in places], rel=1e-14)
            else:
                assert span.low.bindings == ()


def test_a_ratio_that_is_the_range_s_end_at_all_frequencies_leaves_one_threshold_alone() -> None:
    """Half the force of a spring: r is 1/2 everywhere."""
    half = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.series("1/2"),), (0, 15))
    [span] = hs.require(half, "evaluation.jnd", ("0.1", "0.5")).feasible
    assert span.low is span.high
    assert (span.low.closed, float(span.low.value or 0)) == (True, 0.5)


@pytest.mark.parametrize("seed", range(4))
def test_doubles_enclose_the_values_that_are_asked_about_and_hardly_more(seed: int) -> None:
    pick = Random(seed)
    for _ in range(10):
        low, high = (Rational(pick.randint(-99, 99), 7) * pick.choice([1, pi]) for _ in range(2))
        found = _outward(Domain(low, high))
        assert all(Fraction(float(x)) == x for x in found)
        for x, end, sign in zip(found, (low, high), (-1, 1), strict=True):
            beyond = sign * (Rational(x.numerator, x.denominator) - end)
            assert bool(beyond >= 0)
            assert bool(beyond <= abs(end) * Rational(1, 2**47))
        assert (_outward(Domain(None, high)), _outward(Domain(low, None))) == ((None, found[1]), (found[0], None))
