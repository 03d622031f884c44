"""Where conditions are broken at one value, rational or algebraic; and guesses in floats of which value comes nearest."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plainshapes import function_of, q, rational
from sympy import Expr, Integer, Rational, lambdify

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import omega as w
from haptisym.verbs.require.boundary import real_roots
from haptisym.verbs.require.breaking import Breaking, Cell
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.guesses import Guesses

REAL, IMAG = noticed(hs.Threshold())
BAND = Integer(1), Integer(4)


def condition(*formulas: Expr) -> Any:
    own = tuple(map(function_of, formulas))
    return own[0] if len(own) == 1 else Lattice((own,))


def breaking(*conditions: Any) -> Breaking:
    return Breaking(dict(zip((REAL, IMAG), conditions, strict=False)), q, BAND)


def root(formula: Expr, *, negative: bool = False) -> Any:
    """The positive root of an irreducible polynomial in q, or the negative one."""
    p = function_of(formula)
    found = [*real_roots(p.function.numerator, p.axis.meanings.index(q), negative=True)]
    [value] = [x for x in found if (float(x) < 0) is negative]
    return value


@pytest.mark.parametrize("seed", range(6))
def test_a_condition_is_broken_where_all_of_its_functions_are_positive_at_a_value(seed: int) -> None:
    """Between the zeros of lines w - a q and b - w; the first condition that is broken is told of two."""
    pick = Random(seed)
    for _ in range(4):
        a, b, value = pick.randint(1, 3), pick.randint(2, 6), Fraction(pick.randint(0, 8), 3)
        other = pick.choice([w - 9, w - 3, w + 1])
        own = breaking(condition(w - a * q, b - w), condition(other + 0 * q))
        low, high = max(Fraction(1), a * value), min(Fraction(4), Fraction(b))
        found = own.of(REAL, rational(value))
        if low < high:
            [x] = found
            ends = [x.band.low.omega, x.band.high.omega]
            assert x.criterion == REAL
            assert [float(y) for y in ends] == pytest.approx([float(low), float(high)])
        else:
            assert found == ()
        beside = own.of(IMAG, rational(value))
        assert len(beside) == (0 if other == w - 9 else 1)
        assert [x.criterion for x in own.at(rational(value))] == [x.criterion for x in (found or beside)]
        assert Cell(Rational(1), found).feasible is (found == ())
    nowhere = breaking(condition((w - 9) / (q - 2)))
    assert [x.criterion for x in nowhere.at(Rational(2))] == [REAL]
    assert len(nowhere.of(REAL, Rational(2))) == 1
    assert nowhere.at(Rational(3)) == ()
    assert nowhere.ring is nowhere.pieces[REAL][0].axis
    assert nowhere.ring.meanings[nowhere.index] == q


@pytest.mark.parametrize("seed", range(5))
def test_at_an_algebraic_value_a_condition_is_broken_as_it_is_in_digits(seed: int) -> None:
    """a (q^2 - 2)^n and b (w - c)^2 (w - d)^k and e (q^2 - 2) w of any sign: at the root of 2 and at its negative."""
    pick = Random(seed)
    x = q**2 - 2
    for negative in (False, True):
        value = root(x, negative=negative)
        rows = []
        for _ in range(pick.choice([1, 1, 2])):
            c, d = pick.choice([1, 2, Rational(5, 2), 4]), pick.choice([0, 1, 3, 4, 6])
            rows.append(
                pick.choice([1, -2, 5]) * x ** pick.choice([1, 2])
                + pick.choice([1, -1]) * (w - c) ** 2 * (w - d) ** pick.choice([0, 1])
                + pick.choice([0, 3]) * x * w * q
            )
        if pick.random() < 0.3:
            rows[-1] = x * (w - 2) + q * (w - 3) / 5
        own = breaking(condition(*rows))
        grid = np.linspace(1, 4, 4001)
        at = float(value)
        tops = np.min([np.broadcast_to(lambdify((w, q), f, "numpy")(grid, at), grid.shape) for f in rows], axis=0)
        truth = bool(tops.max() > 1e-6)
        cells = [
            Cell(s, own.of(REAL, s))
            for s in (Rational(value.bounds(64)[0] - Fraction(1, 4)), Rational(value.bounds(64)[1] + Fraction(1, 4)))
        ]
        broken = [c for c in cells if not c.feasible]
        assert own.near(value, broken) is truth
        assert own.near(value, []) is truth  # in its number field
        for f in own.conditions:
            assert own._exceeds_exactly(f, value) is truth or any(
                n.has(q) and not n.subs(q**2, 2).expand().has(q) and n.subs(q**2, 2).expand() == 0 for n in rows
            )


def test_of_several_functions_one_that_is_negative_where_another_vanishes_does_not_bind() -> None:
    for second, binds in ((w - 1, True), (w - 3, False), (w - 2, True), (q - 9, False)):
        for pair in ((w - q, second), (second, w - q)):
            own = breaking(condition(*pair))
            assert own.may_bind(REAL, ExactNumber(Integer(2)), ExactNumber(Integer(2))) is binds
    alone = breaking(condition(w - 9 * q))
    assert alone.may_bind(REAL, ExactNumber(Integer(2)), ExactNumber(Integer(2)))


# Guesses


def guesses(gain: str, band: Any, real: str, imag: str, own: Any, domain: Domain | None = None) -> Guesses:
    effect = hs.effects.series(gain, parameters={"t": own})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (effect,), band, hs.Threshold(real, imag))
    return Guesses(scene, scene.knobs["t"], domain or Domain(None, None), noticed(scene.threshold))


@pytest.mark.parametrize("seed", range(4))
def test_how_bad_values_are_is_the_largest_ratio_over_its_threshold_on_a_grid(seed: int) -> None:
    """|t - a w^2| and |d w|, with a scene at 0 or without one."""
    pick = Random(seed)
    a, d, low = pick.randint(1, 9) / 16, pick.randint(1, 9) / 8, pick.choice([0, 1])
    values = np.array([-3.0, -0.5, 0.0, 0.25, 2.0, 40.0])
    grid = np.linspace(low, 3, 257)[:, None]
    true = np.maximum(np.abs(values - a * grid**2) / 0.1, d * grid / 0.4).max(0)
    found = guesses(f"1 + t + ({a})*s^2 + ({d})*s", (low, 3), "0.1", "0.4", "1/10").times(values)
    assert found == pytest.approx(true, rel=1e-12)
    none = guesses(f"1 + 1/t + ({a})*s^2 + ({d})*s", (low, 3), "0.1", "0.4", "1/10").times(values)
    assert np.isnan(none).tolist() == [False, False, True, False, False, False]
    there = values != 0
    assert none[there] == pytest.approx(
        np.maximum(np.abs(1 / values[there] - a * grid**2) / 0.1, d * grid / 0.4).max(0), rel=1e-12
    )


@pytest.mark.parametrize("own", [0, Rational(1, 2), -2])
def test_a_value_is_asked_about_inside_of_a_range_and_at_ends_that_belong_to_it(own: Any) -> None:
    for low, high, first, last in product((None, -1, own), (None, own, 3), (True, False), (True, False)):
        if low is not None and high is not None and low > high:
            continue
        ends = (None if x is None else Rational(x) for x in (low, high))
        asked = Domain(next(ends), next(ends), first, last)
        given: Any = SimpleNamespace(value=own)
        g = Guesses(given, given, asked, ())
        for x in (Rational(-9), Rational(-2), Rational(-1), Rational(0), Rational(1, 2), Rational(3), Rational(11)):
            above = low is None or x > low or (x == low and first)
            below = high is None or x < high or (x == high and last)
            assert g._holds(x) is bool(above and below)


class Bowl(Guesses):
    """(t - a)^2 + 1, nan below a number, over a line of values; each look is noted."""

    @classmethod
    def at(cls, a: float, least: float, domain: Domain) -> Bowl:
        found = cls(None, SimpleNamespace(value=Integer(1)), domain, ())  # type: ignore[arg-type]
        found.__dict__.update(a=a, least=least)
        return found

    def times(self, t: Any) -> Any:
        own: dict[str, Any] = self.__dict__
        return np.where(t < own["least"], np.nan, (t - own["a"]) ** 2 + 1)


@pytest.mark.parametrize("a", [0.123, 2.0, -1.5, 3.999])
def test_on_finer_grids_the_least_is_found_that_a_grid_shows_nearly(a: float) -> None:
    grid = np.linspace(-2, 4, 25)
    bowl = Bowl.at(a, -9.0, Domain(None, None))
    value, times = bowl._least(grid, bowl.times(grid))
    assert abs(value - a) < 0.25 / 8**4
    assert times == pytest.approx(float(bowl.times(np.array(value))), rel=1e-15)
    cut = Bowl.at(-1.5, 1.1, Domain(None, None))
    value, times = cut._least(grid, cut.times(grid))
    assert 1.1 <= value < 1.1 + 0.25 / 8**3
    assert times == pytest.approx(float(cut.times(np.array(value))))


def simplest(low: Fraction, high: Fraction) -> Fraction:
    """The number between two of one sign whose denominator is least, and of these the least."""
    for below in range(1, 10**6):
        first = (
            Fraction((low * below).__floor__() + 1, below)
            if low >= 0
            else Fraction((high * below).__ceil__() - 1, below)
        )
        if low < first < high:
            return first
    raise AssertionError


@pytest.mark.parametrize("seed", range(6))
def test_of_simple_values_near_a_good_one_the_first_is_taken_that_is_hardly_worse(seed: int) -> None:
    """A tenth, a hundredth, a thousandth and 10^-5 of it away at most; itself where none is as good, if it is asked about."""
    pick = Random(seed)
    for _ in range(12):
        value = pick.choice([-1, 1]) * round(pick.uniform(0.05, 9), pick.randint(0, 5))
        if not value:
            continue
        domain = Domain(
            *pick.choice([(None, None), (Rational(value), None), (None, Rational(value))]),
            *pick.choice([(True, True), (False, False)]),
        )
        bowl = Bowl.at(value, -1e9, domain)
        here, size = Fraction(value), abs(Fraction(value))
        ways = [simplest(here - Fraction(x) * size, here + Fraction(x) * size) for x in (0.1, 0.01, 1e-3, 1e-5)]
        good = [x for x in ways if bowl._holds(rational(x)) and (float(x) - value) ** 2 + 1 <= 1.004]
        own = [here] if bowl._holds(rational(here)) else []
        assert [*bowl._simple(value, 1.0)] == [rational(x) for x in (good or own)[:1]]
    assert [*Bowl.at(0.0, -9.0, Domain(None, None))._simple(0.0, 1.0)] == [0]
    assert [*Bowl.at(0.0, -9.0, Domain(Rational(0), None, holds_low=False))._simple(0.0, 1.0)] == []
