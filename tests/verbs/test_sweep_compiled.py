"""Zeros of very many sets in machine code: polynomials against Sturm's theorem and exact signs, sweeps against the slower floats and exact answers."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import reduce
from importlib.util import find_spec
from random import Random

import numpy as np
import pytest
from marks import required
from sympy import Poly, Rational, Symbol
from test_sweep import CASES, PAPER, RIPPLED, SIDED, THREE

from haptisym.verbs.sweep.axes import axes
from haptisym.verbs.sweep.batch import Monomial
from haptisym.verbs.sweep.curves import Curves, FamilyProduct, ThresholdPolynomial
from haptisym.verbs.sweep.delayterms import Family, Variables
from haptisym.verbs.sweep.evaluator import SetEvaluator
from haptisym.verbs.sweep.exactanswers import exact_answers
from haptisym.verbs.sweep.passes import Band

required("Numba, of the extra fast,", find_spec("numba"))

pytestmark = [pytest.mark.slow, pytest.mark.core]  # compiling takes seconds

PLAIN = Variables((), ())
HARD = {
    "environment.m": (1e-3, 1e3), "environment.b": (1e-6, 1e3), "environment.k": (1e-3, 1e3),
    "effects.filter.omega_n": (1.0, 1e4), "effects.filter.zeta": (1e-3, 1.0),
}  # fmt: skip


def family(pick: Random, degree: int) -> Family:
    """A polynomial in x whose coefficients are random polynomials in three parameters."""
    terms = []
    for power in range(degree + 1):
        for _ in range(pick.randint(1, 2)):
            constant = Fraction(pick.choice([-1, 1]) * pick.randint(1, 30), pick.choice([1, 3, 7, 10]))
            high = float(constant)
            exponents = tuple(pick.randint(0, 2) for _ in range(3))
            terms.append(Monomial(power, high, float(constant - Fraction(high)), exponents))
    return Family(tuple(terms), PLAIN, tuple((i,) for i in range(degree + 1)))


def times(a: Sequence[Fraction], b: Sequence[Fraction]) -> list[Fraction]:
    found = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            found[i + j] += x * y
    return found


def exact(factors: FamilyProduct, values: Sequence[float]) -> Poly:
    """The product for one set, in exact numbers."""
    found = [Fraction(1)]
    for f in factors:
        c = [Fraction(0)] * len(f.exponents)
        for t in f.terms:
            powers = (Fraction(x) ** n for x, n in zip(values, t.exponents, strict=True))
            c[t.power] += reduce(Fraction.__mul__, powers, Fraction(t.constant) + Fraction(t.rest))
        found = times(found, c)
    return Poly([Rational(x.numerator, x.denominator) for x in reversed(found)], Symbol("x"))


@pytest.mark.parametrize("seed", range(8))
def test_zeros_are_as_many_as_sturm_counts_and_each_has_a_change_of_sign_beside_it(seed: int) -> None:
    """Of p^2 q - c^4 r: with a small c pairs of zeros lie within any distance of each other."""
    from haptisym.verbs.sweep.compiled import compiled_passes

    pick = Random(seed)
    p, q, r = (family(pick, pick.randint(1, 2)) for _ in "pqr")
    small = Family((Monomial(0, 1.0, 0.0, (0, 0, 4)),), PLAIN, ((0,),))
    above, below = (p, p, q), (small, *pick.choice([(), (q,), (r,)]))
    curves = Curves(1, {"real": ThresholdPolynomial(above, below)}, (None, None), (), has_waves=False)
    low = Rational(pick.choice(["0", "0", "1/10", "1/4", "1/3"]))
    a, b = ([2 ** pick.uniform(-s, s) for _ in range(25)] for s in (4, 8))
    values = np.array([a, b, [10 ** pick.uniform(-10, 1) for _ in range(25)]])
    left = []
    for make in compiled_passes(curves, Band.of(low, Rational(1), 1)):
        answers, decided = make(values).answers()
        left.append(int((~decided).sum()))
        for i in decided.nonzero()[0]:
            one = values[:, i].tolist()
            f = exact(above, one) - exact(below, one)
            assert answers["crossings_real"][i] == f.count_roots(low, 1), one
            assert (answers["bandwidth"][i] > 0) == (f.eval(low) < 0), one
            if answers["crossings_real"][i]:
                x, tolerance = Rational(*answers["first_crossing_real"][i].as_integer_ratio()), Rational(1, 10**10)
                before, after = max(low, x * (1 - tolerance)), min(Rational(1), x * (1 + tolerance))
                assert f.eval(before) * f.eval(after) < 0, one
    doubles, pairs = left
    assert pairs <= doubles <= 15


SCENES = {
    **{name: (given, vary) for name, (given, vary, _) in CASES.items() if given not in (RIPPLED, THREE)},
    "sides of a region": (replace(PAPER, threshold=SIDED), CASES["from 0"][1]),
}


def test_sets_are_counted_as_by_the_slower_floats_and_by_exact_arithmetic() -> None:
    decided = 0
    for name, (given, vary) in SCENES.items():
        swept = [axis.knob for axis in axes(given, vary)]
        values = np.array([x.ravel() for x in np.meshgrid(*vary.values())])
        slow, fast = (SetEvaluator.of(given, swept, many=many) for many in (False, True))
        if fast.curves is None:
            continue
        (expected, left), (found, open_) = slow.in_floats(values), fast.in_floats(values)
        assert set(open_) <= set(left), name
        for i in set(range(values.shape[1])) - set(open_):
            truth = (
                exact_answers(given, swept, values[:, i].tolist())
                if i in left
                else {x: y[i] for x, y in expected.items()}
            )
            if truth["method"] == 2:
                continue
            decided += 1
            assert {x: found[x][i] for x in truth if x != "method"} == pytest.approx(
                {x: y for x, y in truth.items() if x != "method"}, rel=2e-10, abs=1e-9, nan_ok=True
            ), (name, values[:, i])
    assert decided > 40


def test_parameters_of_very_different_size_are_counted_in_machine_code_and_right() -> None:
    rng = np.random.default_rng(2019)
    values = np.exp([rng.uniform(*np.log(span), 400) for span in HARD.values()])
    swept = [axis.knob for axis in axes(PAPER, {path: list(span) for path, span in HARD.items()})]
    slow, fast = (SetEvaluator.of(PAPER, swept, many=many) for many in (False, True))
    (expected, left), (found, open_) = slow.in_floats(values), fast.in_floats(values)
    assert len(open_) < len(left) / 2
    for name in fast.sweep_variables.counts:
        sure = np.setdiff1d(np.arange(400), left)
        assert (found[name][sure] == expected[name][sure]).all()
        for i in np.setdiff1d(left, open_)[:6]:
            assert found[name][i] == exact_answers(PAPER, swept, values[:, i].tolist())[name]


def test_without_numba_very_many_sets_have_the_same_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    given, vary, _ = CASES["from 0"]
    swept = [axis.knob for axis in axes(given, vary)]
    values = np.array([x.ravel() for x in np.meshgrid(*vary.values())])
    monkeypatch.setitem(sys.modules, "haptisym.verbs.sweep.compiled", None)
    expected, found = (SetEvaluator.of(given, swept, many=many).answers(values) for many in (False, True))
    assert all(np.array_equal(expected[name], found[name], equal_nan=True) for name in expected)
