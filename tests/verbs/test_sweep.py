"""Sweeps: every set against its exact evaluation, the floats behind it against exact zeros, and nothing lost where a sweep is killed."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from math import isnan, log2, prod
from pathlib import Path
from random import Random
from typing import Any

import flint
import numpy as np
import pytest
from flint import arb
from hypothesis import assume, given
from hypothesis import strategies as st
from jnds import jnds
from marks import often
from oracles import Case
from regions import margin
from strategies import Seeded, case, cases, scene
from sympy import Integer, Rational, Symbol, pi, sympify

import haptisym as hs
from haptisym.figures import sweep as sweep_charts
from haptisym.figures.layers import draw
from haptisym.kernel.errors import UndecidedError
from haptisym.model.files import claimed
from haptisym.verbs.sweep.axes import INFINITE, axes, spaced
from haptisym.verbs.sweep.batch import (
    MOST_TERMS,
    Batch,
    Monomial,
    Monomials,
    coefficients,
    count_right,
    error,
    monomial,
    nearest,
    within_reach,
)
from haptisym.verbs.sweep.curves import FamilyLattice, SignedProduct
from haptisym.verbs.sweep.delayterms import Family, Variables
from haptisym.verbs.sweep.entry import SweepGrid, Swept, compute
from haptisym.verbs.sweep.passes import Band
from haptisym.verbs.sweep.signchanges import SignChanges, lattice_changes

PAPER = hs.load_scene("fu2019")
NATURAL, MASS = "effects.filter.omega_n", "environment.m"
SPRING = hs.environments.mass_spring_damper(k=100)
GAIN = hs.effects.series("g", parameters={"g": "9/10"})
UNIT = hs.effects.series("g", parameters={"g": 1})


def exactly(x: float) -> Rational:
    return Rational(*Fraction(float(x)).as_integer_ratio())


def agrees(one: Any, e: hs.Evaluation) -> None:
    """One set of a sweep with its evaluation: counts are equal, frequencies within a relative 1e-10."""
    low, high = (float(x) for x in e.scene.band)
    told: dict[str, float] = {}
    rows: dict[str, list[Any]] = {
        name: [x.omega for x in e.crossings if x.criterion.name == name] for name in (x.name for x in e.criteria)
    }
    for name, own in rows.items():
        assert int(one[f"crossings_{name}"]) == len(own), name
        told[f"first_crossing_{name}"] = float(own[0]) if own else np.nan
    for system in ("environment", "perceived"):
        turns = getattr(e, f"changeovers_{system}")
        assert int(one[f"changeovers_{system}"]) == len(turns), system
        told[f"changeover_{system}"] = float(turns[0].omega) if turns else np.nan
    told["bandwidth"] = np.nan if e.bandwidth is None else float(e.bandwidth)
    for name, value in told.items():
        assert float(one[name]) == pytest.approx(value, rel=1.0001e-10, nan_ok=True), name
    clear = sum(float(x.high.omega) - float(x.low.omega) for x in e.transparent) / (high - low)
    assert float(one["transparent"]) == pytest.approx(clear, abs=1e-9)


def sets(found: Any, every: int = 1) -> list[tuple[Any, dict[str, Rational]]]:
    """Each set of a sweep with its exact values."""
    places = [*np.ndindex(*found.method.shape)][::every]
    chosen = [found[dict(zip(found.method.dims, at, strict=True))] for at in places]
    return [(one, {path: exactly(one[path]) for path in found.method.dims}) for one in chosen]


# --- answers ---------------------------------------------------------------------------------------------------------

SIDED = {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1}
RIPPLES = hs.effects.series("1 + 0.4*s/(s^2 + 0.2*s + 4) - 0.3*s/(s^2 + 0.3*s + 25) + 0.5*s/(s^2 + 0.5*s + 64)")
RIPPLED = hs.Scene(hs.environments.mass_spring_damper(m=1, b=2, k=90), (RIPPLES,), (0, 12))
BEGINNING = hs.Scene(
    hs.environments.kelvin_voigt(100, 3),
    (hs.effects.series("(s + a)/(s + 1)*(1 + s/d)", parameters={"a": "1/2", "d": "90"}),),
    (0, 15),
)
THREE = hs.Scene(
    hs.environments.two_mass(m1="8.1", b1="5.8", k1="41", m2="0.041", b2="2.7", k2="45"),
    (
        hs.effects.admittance_display("w^2/(s^2+w*s+w^2)", parameters={"w": "4.9"}),
        hs.effects.series("g", parameters={"g": "0.045"}),
        hs.effects.series("g", parameters={"g": "0.02"}),
    ),
    (0, 4000),
    hs.Threshold.of(1, 1),
)
PAIR = {NATURAL: [25.0, 91.0], MASS: [0.3, 4.9]}
SQUARED = hs.environments.expression("(k + s^2)*(100 + s^2)^2", parameters={"k": 50})
CASES: dict[str, tuple[hs.Scene, dict[str, list[float]], list[int] | int | None]] = {
    "from 0": (PAPER, PAIR, 0),
    "between Hz and rad/s": (PAPER.with_band("2 rad/s", "5 Hz").with_values({"c": "0.05"}), PAIR, 0),
    "between two Hz": (PAPER.with_band("1 Hz", "100 Hz").with_values({"c": "0.2"}), PAIR, 0),
    "one limit for both parts": (PAPER, {"evaluation.jnd": [0.05, 0.125]}, 0),
    "a limit for each part": (PAPER, {"evaluation.jnd.imag": [0.2, 0.05], "evaluation.jnd.real": [0.05, 0.125]}, 0),
    "many crossings and none": (RIPPLED, {"evaluation.jnd": [0.07, 3.0]}, 0),
    "many crossings on a part of the band": (RIPPLED.with_band("1/3 Hz", "5/3 Hz"), {"evaluation.jnd": [0.02, 0.4]}, [0, 1]),
    "noticed from the beginning": (BEGINNING, {"effects.series.a": [0.25, 0.9375, 2.0]}, 0),
    "noticed at a low end that is not 0": (BEGINNING.with_band(1, 9), {"effects.series.a": [0.9375, 2.0, 8.0]}, 0),
    "three zeros between two signs that are known": (
        THREE,
        {"effects.admittance-display.w": [882710825641131 / 2**53], "environment.b1": [8887457865645333 / 2**56]},
        None,
    ),
    "little damping, where doubles alone do not tell": (
        PAPER.with_values({"c": "0.05"}), {"environment.b": np.geomspace(1e-5, 1e-2, 4).tolist()}, None,
    ),
    "zeros of even order are no changes": (
        hs.Scene(SQUARED, (hs.effects.first_order_lag(30),), (5, 15)), {"environment.k": [64.0, 100.0, 144.0]}, None,
    ),
    "cubes, and poles beyond the band": (
        hs.Scene(
            hs.environments.expression("(k + s^2)^3/(s^2 + 400)", parameters={"k": 50}),
            (hs.effects.first_order_lag(30),), (5, 15),
        ),
        {"environment.k": [49.0, 100.0]},
        None,
    ),
    "a limit reached without being passed": (
        hs.Scene(SPRING, (hs.effects.first_order_lag(1),), (0, 10), "1/2"), {"effects.first-order-lag.omega_c": [1.0, 2.0]}, 1,
    ),
    "an environment that vanishes at its resonance": (
        hs.Scene(hs.environments.mass_spring_damper(m=1, b=0, k=100), (hs.effects.shunt(b=1),), (0, 20)),
        {"environment.b": [0.0, 1.0]},
        0,
    ),
    "numbers beyond any device": (PAPER, {MASS: [1e-200, 1.0]}, [1, 0]),
    "a display that changes nothing": (
        hs.Scene(hs.environments.mass_spring_damper(b=3), (hs.effects.series("(1+5*s)/(1+5*s)"),)),
        {"environment.b": [1.0, 3.0]},
        0,
    ),
    "a display that changes nothing, in a region": (
        hs.Scene(hs.environments.kelvin_voigt(90, 3), (hs.effects.series("(1+5*s)/(1+5*s)"),), threshold=SIDED),
        {"environment.b": [1.0, 3.0]},
        0,
    ),
    "friction behind a lag, whose real part is odd in omega": (
        hs.Scene(
            hs.environments.mass_spring_damper(b=3), (hs.effects.coulomb_friction("0.2 N", "5 cm"), hs.effects.first_order_lag(20)), (0, 15),
        ),
        {"environment.b": [1.0, 30.0]},
        None,
    ),
    "a gain beside its limit, with the binary numbers that they are": (
        hs.Scene(SPRING, (GAIN,), (0, 10), "0.1"), {"effects.series.g": [0.9, 0.5, 0.95]}, None,
    ),
}  # fmt: skip
DEAR = ("many crossings on a part of the band", "between Hz and rad/s")


@cache
def swept(name: str) -> Any:
    return hs.sweep(*CASES[name][:2])


@pytest.mark.few(
    "between Hz and rad/s",
    "one limit for both parts",
    "many crossings on a part of the band",
    "noticed at a low end that is not 0",
    "cubes, and poles beyond the band",
    "an environment that vanishes at its resonance",
    "a display that changes nothing",
    "a display that changes nothing, in a region",
    "a gain beside its limit, with the binary numbers that they are",
)
@pytest.mark.parametrize("name", often(CASES, lambda name: name not in DEAR))
def test_every_set_is_what_its_evaluation_says(name: str) -> None:
    """``method`` 0 where floats must prove it, 1 where only exact arithmetic can."""
    (given, _, method), found = CASES[name], swept(name)
    if method is not None:
        assert (found.method == (method if isinstance(method, int) else np.array(method))).all()
    for one, values in sets(found):
        agrees(one, hs.evaluate(given.with_values(values)))


def test_sets_with_many_crossings_do_have_many_and_noticed_ones_no_bandwidth() -> None:
    """That the table above holds what it says."""
    many, begun = swept("many crossings and none"), swept("noticed from the beginning")
    assert many.crossings_real.values[0] > 3 < many.crossings_imag.values[0]
    assert many.crossings_real.values[1] == 0
    assert np.isnan(begun.bandwidth.values).tolist() == [True, False, True]
    assert begun.transparent.values[2] > 0.1
    assert swept("three zeros between two signs that are known").crossings_real.item() == 3


@pytest.mark.parametrize(
    ("given", "path", "counts"),
    [
        (hs.Scene(SPRING, (hs.effects.first_order_lag(20),)), "environment.k", "crossings_real"),
        (hs.Scene(hs.environments.mass_spring_damper(b=3), (UNIT,)), "environment.b", "changeovers_environment"),
        (
            hs.Scene(
                hs.environments.mass_spring_damper(b=3), (UNIT,), threshold={"shape": "diamond", "real": 1, "imag": 1}
            ),
            "environment.b",
            "changeovers_environment",
        ),
    ],
)
def test_a_set_without_dynamics_is_not_answered_and_stops_nothing(given: hs.Scene, path: str, counts: str) -> None:
    found = hs.sweep(given, {path: [0.0, 2.0]})
    assert found.method.values.tolist() == [2, 0]
    assert found[counts].values[0] == -1 < found[counts].values[1]
    assert np.isnan(found.bandwidth[0])


@pytest.mark.dear("8")
@pytest.mark.few("8", "11")
@pytest.mark.parametrize("seed", range(12))
def test_random_scenes_are_answered_as_they_are_evaluated(seed: int) -> None:
    asked = scene(case(Seeded(1000 + seed), order=5))
    names = [p.path for p in asked.parameters if p.value.is_Rational and p.value > 0][:2]
    found = hs.sweep(asked, {x: (float(asked.knobs[x].value) * np.geomspace(0.2, 5, 9)).tolist() for x in names})
    assert (found.method == 0).mean() > 0.5
    for one, values in sets(found, max(1, found.method.size // 8)):
        if int(one.method) == 0:
            agrees(one, hs.evaluate(asked.with_values(values)))


@pytest.mark.slow
def test_parameters_of_very_different_size_are_never_counted_wrong() -> None:
    spans = {MASS: (1e-3, 1e3), "environment.b": (1e-6, 1e3), NATURAL: (1.0, 1e4), "effects.filter.zeta": (1e-3, 1.0)}
    wide = PAPER.with_band(0, 300)
    found = hs.sweep(wide, {path: np.geomspace(*span, 4).tolist() for path, span in spans.items()})
    assert (found.method == 0).mean() > 0.5
    for one, values in sets(found, 5):
        agrees(one, hs.evaluate(wide.with_values(values)))


def test_units_are_read_and_numbers_without_one_have_none() -> None:
    found = hs.sweep(PAPER, {NATURAL: ["10 Hz", 80], "effects.filter.zeta": [0.5, 0.7]})
    assert found[NATURAL].values.tolist() == [20 * np.pi, 80.0]
    assert [found[x].attrs["units"] for x in found.method.dims] == ["rad/s", "1"]
    assert spaced(f"{NATURAL}=40 rad/s:160:3:log", PAPER)[1] == pytest.approx([40, 80, 160], rel=1e-15)
    assert spaced(f"{NATURAL}=40:160:4", PAPER) == (NATURAL, [40, 80, 120, 160])


# --- JND regions -----------------------------------------------------------------------------------------------------

WIDE = {"real": 0.1, "imag": 0.1}
JNDS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", **WIDE, "tilt": -0.5},
    "diamond": {"shape": "diamond", **WIDE},
    "polygon": {"shape": "polygon", "corners": [[0.12, 0.02], [0.03, 0.1], [-0.1, 0.05], [-0.04, -0.08], [0.05, -0.09]]},
    "sided": SIDED,
    "floor": {**WIDE, "floor": "15 N/m"},
    "formula": {"real": "0.08 + 0.004*omega", "imag": 0.1},
    "formulas": {"shape": "ellipse", "real": "0.08 + 0.004*omega", "imag": "1/(omega + 5)", "tilt": "omega/20"},
}  # fmt: skip


def with_jnd(jnd: Any, plain: hs.Scene = PAPER) -> hs.Scene:
    return hs.Scene(plain.environment, plain.effects, plain.band, jnd)


@pytest.mark.dear("ellipse", "formulas", "sided")
@pytest.mark.few("ellipse", "sided", "floor", "formulas")
@pytest.mark.parametrize("name", JNDS)
def test_regions_are_left_as_often_as_each_evaluation_says_and_floats_prove_it(name: str) -> None:
    asked = with_jnd(JNDS[name])
    found = hs.sweep(asked, {NATURAL: [25.0, 160.0], MASS: [0.3, 1.8]})
    assert (found.method == 0).all()
    for one, values in sets(found):
        agrees(one, hs.evaluate(asked.with_values(values)))


@pytest.mark.dear("parts1-diamond")
@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["ellipse", "diamond", "sided", "floor", "formula"])
@pytest.mark.parametrize("parts", [("",), (".real",), (".imag", ".real")])
def test_half_widths_of_a_region_are_swept_together_apart_and_alone(name: str, parts: tuple[str, ...]) -> None:
    asked = with_jnd(JNDS[name])
    found = hs.sweep(asked, {f"evaluation.jnd{part}": [0.0625, 0.25] for part in parts})
    assert (found.method == 0).all()
    for one, values in sets(found):
        agrees(one, hs.evaluate(asked.with_values(values)))


@pytest.mark.slow
@pytest.mark.parametrize("name", JNDS)
def test_the_transparent_part_is_that_of_a_dense_scan(name: str) -> None:
    """In plain complex arithmetic."""
    jnd, omega = JNDS[name], np.linspace(1e-3, 15, 1501)
    found = hs.sweep(with_jnd(jnd), {NATURAL: [40.0, 80.0]})
    written = json.loads(json.dumps(jnd).replace(" N/m", ""))
    for i, w in enumerate((40.0, 80.0)):
        s = 1j * omega
        H = 1.8 * s**2 + 15 * s + 100
        G = H * w**2 / (s**2 + w * s + w**2)
        inside = [margin(written, complex(h), complex(g), x) <= 0 for h, g, x in zip(H, G, omega, strict=True)]
        assert float(found.transparent[i]) == pytest.approx(np.mean(inside), abs=5e-3)


def test_a_change_that_is_the_same_at_all_frequencies_is_noticed_on_all_or_on_none() -> None:
    spring = hs.Scene(SPRING, (GAIN,))
    found = hs.sweep(with_jnd(JNDS["diamond"], spring), {"effects.series.g": [0.5, 0.875, 0.9375, 1.0, 2.0]})
    assert found.transparent.values.tolist() == [0, 0, 1, 1, 0]
    for real, clear in ((0.6, 1), (0.05, 0)):
        jnd = {"shape": "ellipse", "real": real, "imag": 0.1}
        assert hs.sweep(with_jnd(jnd, spring), {"environment.k": [3.0]}).transparent == clear


@pytest.mark.slow
@given(cases(order=3), jnds(), st.lists(st.integers(1, 64), min_size=2, max_size=4, unique=True))
def test_random_regions_are_left_as_often_as_their_evaluations_say(
    case: Case, jnd: dict[str, Any], steps: list[int]
) -> None:
    asked = with_jnd(jnd, scene(case))
    knob = next((p for p in asked.parameters if p.value.is_Rational and p.value > 0), None)
    assume(knob is not None)
    assert knob is not None
    found = hs.sweep(asked, {knob.path: sorted(float(knob.value) * n / 16 for n in steps)})
    for one, values in sets(found):
        if int(one.method) != 2:
            agrees(one, hs.evaluate(asked.with_values(values)))


LOW, NEAR = 0.5, 0.01
NAMES = {name: Family((Monomial(0, 1.0, 0.0, ()),), Variables((), ()), ((i,),)) for i, name in enumerate("pqr")}
"""Functions that are told apart; where they vanish is given."""


def sign(lattice: FamilyLattice, signs: dict[Family, int], at_0: int | None = None) -> int:
    """The largest of its terms, each the least of its functions."""

    def of(x: SignedProduct) -> int:
        return at_0 if at_0 is not None and x.vanishes_at_0 else x.sign * prod(signs[f] for f in x.factors)

    return max(min(map(of, term)) for term in lattice.terms)


def followed(
    lattice: FamilyLattice, zeros: dict[Family, list[float]], first: dict[Family, int]
) -> tuple[list[float], int, bool]:
    """Where it changes its sign, its sign at the low end, and whether that is certain."""
    signs, places, found = dict(first), sorted(x for own in zeros.values() for x in own), []
    certain = all(b - a > NEAR * b for a, b in pairwise(places))
    certain &= (sign(lattice, signs, 1) > 0) is (sign(lattice, signs, -1) > 0)
    start = 1 if sign(lattice, signs) > 0 else -1
    for x in places:
        [own] = [f for f, row in zeros.items() if x in row][:1]
        before, at = sign(lattice, signs) > 0, sign(lattice, {**signs, own: 0})
        signs[own] = -signs[own]
        changed = (sign(lattice, signs) > 0) is not before
        certain &= (at == 0) is changed
        found += [x] * changed
    return found, start, certain


@pytest.mark.parametrize("seed", range(6))
def test_a_lattice_changes_its_sign_where_its_values_do_and_says_where_that_is_not_known(seed: int) -> None:
    """Zeros far from each other; next to each other; and functions that are 0 at omega = 0, beside which others decide or not."""
    draw, count, families = Random(seed), 60, list(NAMES.values())

    def drawn() -> SignedProduct:
        factors = tuple(draw.sample(families, draw.randint(1, 2)))
        return SignedProduct(draw.choice([-1, 1]), factors, bool(seed % 3) and draw.random() < 0.5)

    lattice = FamilyLattice(tuple(tuple(drawn() for _ in range(draw.randint(1, 3))) for _ in range(draw.randint(1, 3))))
    rows, told = [], []
    for _ in range(count):
        places = [n / 2 for n in draw.sample(range(2, 30), 6)]
        if draw.random() < 0.3:
            places[1] = places[0] * (1 + draw.choice([0.004, 0.02]))
        if draw.random() < 0.3:
            places[2] = LOW * 1.004  # the low end itself is no zero
        zeros: dict[Family, list[float]] = {f: [] for f in families}
        for x in places:
            zeros[draw.choice(families)].append(x)
        rows.append(zeros)
        told.append({f: draw.choice([-1, 1]) for f in families})
    given: dict[Family, SignChanges] = {}
    for f in families:
        own = [(i, x) for i, zeros in enumerate(rows) for x in sorted(zeros[f])]
        numbers, omega = (np.array([x[k] for x in own], dtype=kind) for k, kind in ((0, int), (1, float)))
        given[f] = SignChanges(numbers, omega, np.array([x[f] for x in told], dtype=np.int8))
    found, certain = lattice_changes(lattice, given, LOW, NEAR)
    for i, (zeros, first) in enumerate(zip(rows, told, strict=True)):
        places, start, sure = followed(lattice, zeros, first)
        assert (bool(certain[i]), found.first[i]) == (sure, start)
        if sure:
            assert found.omega[found.sets == i].tolist() == places


# --- hands -----------------------------------------------------------------------------------------------------------


def test_unstable_roots_are_those_of_the_characteristic_polynomial() -> None:
    """Of the paper's example, written out; floats prove every set."""
    natural, stiff = np.geomspace(2, 200, 9), np.geomspace(10, 3000, 8)
    found = hs.sweep(PAPER, {"omega_n": natural, "environment.k": stiff}, hand="light-touch")
    assert (found.method == 0).all()
    m, b, k = (float(x.value) for x in hs.hands["light-touch"].parameters)
    for (i, w), (j, stiffness) in product(enumerate(natural), enumerate(stiff)):
        lag = np.array([1.0, w, w**2])
        roots = np.roots(np.polyadd(np.polymul([m, b, k], lag), w**2 * np.array([1.8, 15, stiffness])))
        assert min(abs(roots.real)) > 1e-6 * max(abs(roots))
        assert int(found.unstable_light_touch[i, j]) == (roots.real > 0).sum()


def test_beside_a_critical_value_no_set_is_counted_wrong() -> None:
    """The neighbouring doubles of the exact critical stiffness, where eigenvalues lie on the axis to within rounding."""
    filtered = PAPER.with_values({"omega_n": 20})
    [found] = hs.stability(filtered, "postural-arm", ["environment.k"]).critical
    [near] = found["environment.k"].ends
    is_below = found["environment.k"].feasible[0].last is near
    at, (low, high) = float(near.value), near.value.bounds(400)
    values = sorted({at * (1 + n * 2.0**-52) for n in range(-3, 4)} | {0.5 * at, 2 * at})
    swept = hs.sweep(filtered, {"environment.k": values}, hand="postural-arm")
    for x, count in zip(values, swept.unstable_postural_arm.values, strict=True):
        assert low != high or Fraction(x) != low
        assert count == (0 if (Fraction(x) < low) == is_below else 2)


def test_a_root_that_the_quotient_shares_for_one_set_alone_is_none_there() -> None:
    """k (s - 1)/(s - p): with p = 1 a spring, else a display with an unstable zero of its own."""
    shared = hs.effects.series("(s - 1)/(s - p)", parameters={"p": "1/2"})
    asked = hs.Scene(hs.environments.mass_spring_damper(k=10), (shared,))
    found = hs.sweep(asked, {"effects.series.p": [0.5, 1.0, 2.0]}, hand=hs.Hand("mine", m=1, b=20))
    for p, count in zip([0.5, 1.0, 2.0], found.unstable_mine.values, strict=True):
        roots = np.roots([1, 20, 10] if p == 1 else np.polyadd(np.polymul([1, 20, 0], [1, -p]), [10, -10]))
        assert count == (roots.real >= 0).sum()


WALL = """
environment = { model = "mass-spring-damper", k = "1000 N/m" }
effects = [{ model = "sampled-loop", T = "1 ms", method = "backward-difference" }, { model = "shunt", m = "0.04 kg", b = "0.8 N*s/m" }]
hand = { m = "0 kg" }
"""


@pytest.mark.few("asked2-vary2-None-unstable2")
@pytest.mark.parametrize(
    ("asked", "vary", "hand", "unstable"),
    [
        # the critical damping of a mass of 0.5 kg on delayed-spring is 3.4635997327677037
        ("delayed-spring", {"hand.b": [3.46, 3.4636]}, hs.Hand("hand", m="0.5 kg", b=1), [2, 0]),
        ("satellite-contact", {"environment.k": [5000.0]}, ["light-touch", "firm-grip"], [INFINITE]),
        # a device of 0.04 kg and 0.8 N s/m with T = 1 ms, held by nothing: K < 1605.35113477512
        (hs.parse_scene(WALL), {"environment.k": [1605.0, 1606.0]}, None, [0, 2]),
    ],
)
def test_with_delays_and_clocks_roots_are_counted_exactly(
    asked: Any, vary: Any, hand: Any, unstable: list[int]
) -> None:
    found = hs.sweep(asked, vary, hand=hand)
    for name in found.data_vars:
        assert not name.startswith("unstable") or found[name].values.tolist() == unstable
    assert (found.method == 1).all()
    assert sum(name.startswith("unstable") for name in found.data_vars) == (len(hand) if isinstance(hand, list) else 1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(24))
def test_random_scenes_have_as_many_unstable_roots_as_stability_says(seed: int) -> None:
    asked, rng = scene(case(Seeded(7000 + seed), order=5)), np.random.default_rng(seed)
    m, b, k = (float(x) for x in 10.0 ** rng.uniform([-2, -1, 0], [1, 2, 3]))
    mine = hs.Hand("mine", m=m, b=b, k=k)
    paths = [p.path for p in asked.parameters if p.value.is_Rational and p.value > 0][:1]
    vary = {path: (float(asked.knobs[path].value) * np.geomspace(0.2, 5.0, 5)).tolist() for path in paths}
    for one, values in sets(hs.sweep(asked, {**vary, "hand.b": [b / 4, b]}, hand=mine)):
        try:
            exact = hs.stability(asked.with_hands(mine).with_values(values)).held[0].unstable
        except hs.SceneError:
            exact = -1
        assert int(one.unstable_mine) == (-1 if exact is None else exact)


@given(
    st.lists(st.tuples(st.integers(-20, 20), st.integers(1, 12)), max_size=4),
    st.lists(st.integers(-15, 15), max_size=3),
    st.integers(-3, 3),
)
def test_zeros_on_the_right_are_counted_or_left_open(
    pairs: list[tuple[int, int]], single: list[int], scale: int
) -> None:
    """Polynomials made of their zeros: pairs x +- j y, and real ones; those on the axis are never called proven."""
    p = np.array([10.0**scale])
    for x, y in pairs:
        p = np.convolve(p, [x * x + y * y, -2 * x, 1])
    for x in single:
        p = np.convolve(p, [-x, 1])
    [count], [proven] = count_right(Batch(p[:, None], abs(p[:, None]), 4))
    zeros = [x for x, _ in pairs for _ in range(2)] + single
    assert not proven or (count == sum(x > 0 for x in zeros) and 0 not in zeros)
    assert proven or not zeros or len(zeros) >= 5 or max(zeros) >= 0


def test_a_leading_coefficient_that_is_perhaps_0_proves_nothing() -> None:
    p = np.array([[1.0, 1.0], [2.0, 2.0], [1.0, 1.0], [1e-20, 1e-3]])
    assert count_right(Batch(p, np.ones_like(p), 1))[1].tolist() == [False, True]


# --- their errors ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float64, np.longdouble])
def test_a_bound_is_that_of_so_many_roundings_and_a_constant_is_rounded_once(dtype: type) -> None:
    u = Fraction(2) ** -(int(np.finfo(dtype).nmant) + 1)
    for size, roundings in product((1.0, 3.7, 1e-200), (0, 1, 7, 1000, MOST_TERMS)):
        [found] = error(np.array([size], dtype), roundings)
        gamma = roundings * u / (1 - roundings * u) * Fraction(size)
        assert gamma <= Fraction(*found.as_integer_ratio()) <= Fraction(1002, 1000) * gamma
    for x in (Fraction(1, 3), Fraction(-22, 7), Fraction(10**30, 7**20), Fraction(5, 2)):
        with flint.ctx.workprec(300):
            found = nearest(arb(x.numerator) / x.denominator, dtype)
        assert type(found) is dtype
        assert abs(Fraction(*found.as_integer_ratio()) - x) <= u * abs(x)


def drawn(pick: Random) -> tuple[list[list[Monomial]], np.ndarray]:
    """Sums of few terms whose constants are powers of two, small ones, large ones or usual, and sets of two such parameters."""
    most, families = pick.choice([40, 500, 700]), []
    for _ in range(pick.randint(1, 2)):
        spread = [2.0 ** pick.randint(-most // 2, most) for _ in range(pick.randint(1, 3))]
        rows = [x if pick.random() < 0.6 else 1 / x for x in spread]
        families.append([Monomial(pick.randint(0, 3), x, 0.0, (pick.randint(0, 3), pick.randint(0, 3))) for x in rows])
    reach = pick.choice([3, 45, 300])
    values = [[pick.choice([0.0, *[2.0 ** pick.randint(-reach, reach)] * 5]) for _ in range(4)] for _ in range(2)]
    return families, np.array(values)


def value_of(term: Monomial, values: np.ndarray) -> Fraction:
    return Fraction(term.constant) * prod(Fraction(float(x)) ** n for x, n in zip(values, term.exponents, strict=True))


@pytest.mark.parametrize("seed", range(4))
def test_within_reach_no_product_leaves_the_floats_and_coefficients_lie_within_their_error(seed: int) -> None:
    """And sets of usual numbers are within reach of usual constants."""
    pick, u = Random(seed), Fraction(1, 2**53)
    for _ in range(20):
        families, values = drawn(pick)
        for i in np.flatnonzero(within_reach(values, [families])):
            for terms in product(*families):
                value = prod((value_of(t, values[:, i]) for t in terms), start=Fraction(1))
                assert value == 0 or Fraction(1, 2**1000) <= value <= 2**1000
        usual = ((values == 0) | (np.abs(np.log2(np.where(values, values, 1.0))) < 45)).all(axis=0)
        if all(abs(log2(t.constant)) < 200 for terms in families for t in terms):
            assert within_reach(values, [families])[usual].all()
        values = values * np.array([[1.1], [1 / 3]])  # no powers of two
        with np.errstate(all="ignore"):
            found = coefficients(families[0], 4, Monomials(values))
        for i in np.flatnonzero(within_reach(values, [[families[0]]])):
            for power in range(4):
                exact = sum(value_of(t, values[:, i]) for t in families[0] if t.power == power)
                size = Fraction(float(found.sizes[power, i]))
                off = abs(Fraction(float(found.values[power, i])) - exact)
                assert off <= found.roundings * u * size * Fraction(1001, 1000)
                assert exact <= size * (1 + 1000 * u)


def test_a_constant_is_read_only_where_128_bits_of_it_are_known() -> None:
    with flint.ctx.workprec(200):
        for ball in (arb(3), arb(2) ** 500, arb(1) / 3, arb.pi() * 10**30):
            own = monomial(2, (1,), ball)
            assert (own.power, own.exponents, own.constant) == (2, (1,), float(ball.mid()))
            assert abs(arb(own.constant) + arb(own.rest) - ball) < abs(ball) * 2.0**-104
        assert monomial(0, (), arb(1, 2.0**-140)).constant == 1
        with pytest.raises(UndecidedError, match="fewer than 128"):
            monomial(0, (), arb(1, 2.0**-120))


@pytest.mark.parametrize("step", [1, 2])
def test_a_band_begins_with_the_doubles_around_its_low_end(step: int) -> None:
    """However near its ends are: also where only few doubles lie between them, or none."""
    for low in (0, 1, "1/3", 7, "99/10", *(10 - Rational(10) ** -n for n in (3, 8, 13, 15, 16, 17, 30)), pi, "5"):
        band, share = Band.of(sympify(low), Integer(10), step), (sympify(low) / 10) ** step
        first, last = (Rational(x) for x in (band.ends[0], band.ends[-1]))
        assert bool(first <= share <= last)
        assert band.doubtful is bool(first < last) is not bool(share == first)
        assert not band.doubtful or last == Rational(float(np.nextafter(float(first), 2)))


# --- blocks and files ------------------------------------------------------------------------------------------------

FEW = {NATURAL: [40.0, 120.0], MASS: [0.5, 1.0, 2.0]}


@pytest.fixture(scope="module")
def few() -> Any:
    return hs.sweep(PAPER, FEW)


def stored(out: Path, **named: Any) -> tuple[Any, list[int]]:
    """A sweep in a file, one block of three sets after the other, and what was told to be done on the way."""
    import dask  # half a second for each process that collects tests, as zarr and what draws

    told: list[int] = []
    with dask.config.set(scheduler="synchronous", num_workers=1):
        found = hs.sweep(PAPER, FEW, out=out, block=3, progress=lambda done, _: told.append(done), **named)
    return found, told


@pytest.mark.dear("1")
@pytest.mark.parametrize("block", [1, 4])
def test_blocks_change_nothing(few: Any, block: int) -> None:
    assert hs.sweep(PAPER, FEW, block=block).identical(few)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "path"), [("fu2019", NATURAL), ("delayed-spring", "environment.k")])
def test_of_very_many_sets_each_is_what_it_is_alone(name: str, path: str) -> None:
    """More than are computed at once."""
    values = np.linspace(20, 200, 9000)
    whole = hs.sweep(name, {path: values})
    for i in range(0, 9000, 1701):
        assert hs.sweep(name, {path: values[i : i + 1]}).equals(whole.isel({path: [i]}))


@pytest.mark.slow
def test_a_block_that_takes_longer_than_is_waited_for_is_done_in_parts_and_all_there(tmp_path: Path) -> None:
    """Each set is answered exactly."""
    tissue = hs.Scene(hs.environments.spring_pot(80, "0.5"), (hs.effects.first_order_lag(40),), (1, 2))
    vary = {"environment.alpha": np.linspace(0.2, 0.8, 40)}
    assert hs.sweep(tissue, vary, out=tmp_path / "a.zarr").load().identical(hs.sweep(tissue, vary))


@pytest.mark.slow
def test_blocks_are_computed_when_they_are_asked_for_and_are_the_same(few: Any) -> None:
    found = hs.sweep(PAPER, FEW, lazy=True, block=3)
    assert found.bandwidth.chunks == ((1, 1), (3,))
    assert found.compute(scheduler="threads").identical(few)


@pytest.mark.slow  # a cluster takes longer to start than all other tests
@pytest.mark.filterwarnings("ignore")  # of the cluster's own making
def test_workers_of_a_cluster_give_the_same_and_what_they_are_sent_can_be_copied(few: Any, tmp_path: Path) -> None:
    import distributed

    quiet = {"n_workers": 2, "threads_per_worker": 1, "processes": False, "dashboard_address": None, "silence_logs": 50}
    with distributed.LocalCluster(**quiet) as found, distributed.Client(found):
        assert hs.sweep(PAPER, FEW, lazy=True, block=5).compute().identical(few)
        assert hs.sweep(PAPER, FEW, out=tmp_path / "a.zarr", block=5).load().identical(few)
    copy = pickle.loads(pickle.dumps(SweepGrid.of(PAPER, axes(PAPER, FEW))))
    for own, name in zip(compute(copy.evaluator, np.ix_(*FEW.values())), copy.variables, strict=True):
        assert np.array_equal(own, few[name].values, equal_nan=True)


@pytest.mark.slow
def test_what_is_there_is_not_computed_again_and_what_is_missing_is(few: Any, tmp_path: Path) -> None:
    import zarr

    first, told = stored(tmp_path / "a.zarr")
    assert (told[0], told[-1]) == (0, 6)
    assert first.load().identical(few)
    group: Any = zarr.open_group(tmp_path / "a.zarr", mode="r+")
    group["bandwidth"][:] = np.full((2, 3), 77.0)
    group["method"][1, 1:3] = -1
    group["method"][0, 2] = -1
    again, told = stored(tmp_path / "a.zarr")
    assert (told[0], told[-1]) == (3, 6)
    fresh = np.zeros((2, 3), bool)
    fresh[1, 1:3] = fresh[0, 2] = True
    assert (np.where(fresh, few.bandwidth, 77.0) == again.bandwidth).all()
    assert again.load().drop_vars("bandwidth").identical(few.drop_vars("bandwidth"))


@pytest.mark.slow
def test_a_sweep_that_is_interrupted_or_killed_goes_on_where_it_was(few: Any, tmp_path: Path) -> None:
    import dask

    def interrupted(done: int, _: int) -> None:
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), dask.config.set(scheduler="synchronous", num_workers=1):
        hs.sweep(PAPER, FEW, out=tmp_path / "a.zarr", block=3, progress=interrupted)
    script = (
        "import os, signal, dask, haptisym as hs\n"
        "dask.config.set(scheduler='synchronous', num_workers=1)\n"
        "said = []\n"
        "def killed(done, sets):\n"
        "    said.append(done)\n"
        "    len(said) < 2 or os.kill(os.getpid(), signal.SIGKILL)\n"
        f"hs.sweep('fu2019', {FEW!r}, out={str(tmp_path / 'a.zarr')!r}, block=3, progress=killed)\n"
    )
    assert subprocess.run([sys.executable, "-c", script], env={**os.environ}).returncode == -signal.SIGKILL
    found, told = stored(tmp_path / "a.zarr")
    assert 1 < told[0] <= 6
    assert found.load().identical(few)


@pytest.mark.slow
def test_a_netcdf_file_holds_the_same_and_is_read_again(few: Any, tmp_path: Path) -> None:
    for _ in range(2):
        with stored(tmp_path / "a.nc")[0] as found:
            assert found.bandwidth.chunks == ((1, 1), (3,))
            assert found.load().identical(few)
    assert [x.name for x in tmp_path.iterdir()] == ["a.nc"]
    with pytest.raises(hs.SceneError, match="exists with another sweep"):
        hs.sweep(PAPER, {MASS: [1.0, 2.0]}, out=tmp_path / "a.nc")


@pytest.mark.slow
@pytest.mark.core
def test_a_relative_name_means_one_place_wherever_workers_are(
    few: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other").mkdir()
    hs.sweep(PAPER, FEW, out="a.zarr", block=3, progress=lambda *_: os.chdir(tmp_path / "other"))
    assert stored(tmp_path / "a.zarr")[0].load().identical(few)
    assert not [*(tmp_path / "other").iterdir()]


def test_one_process_writes_a_file_and_another_is_told(few: Any, tmp_path: Path) -> None:
    with claimed(tmp_path / "a.zarr"), pytest.raises(hs.SceneError, match="another process is writing it"):
        stored(tmp_path / "a.zarr")
    assert not [*tmp_path.iterdir()]
    assert stored(tmp_path / "a.zarr")[0].load().identical(few)


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("method", "not all sets are there"),
        (MASS, "are missing in it"),
        ("bandwidth", "are missing in it"),
        ("band", "exists with another sweep"),
    ],
)
def test_a_file_is_believed_only_where_it_holds_this_sweep(few: Any, tmp_path: Path, what: str, told: str) -> None:
    changed = few.copy(deep=True)
    if what == "band":
        changed = hs.sweep(PAPER.with_band(0, 14), FEW)
    elif what == "bandwidth":
        changed = changed.drop_vars(what)
    else:
        changed = changed.assign_coords({MASS: changed[MASS] * 0}) if what == MASS else changed
        changed["method"][0, 1] = -1
    changed.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    with pytest.raises(hs.SceneError, match=told):
        stored(tmp_path / "a.nc")


HELD = PAPER.with_hands(hs.Hand("one", m=1, b=5, k=40))


@pytest.mark.few("vary3")
@pytest.mark.parametrize(
    "vary",
    [
        {"effects.filter.zeta": [0.4, 0.6]},
        {"evaluation.jnd": [0.1, 0.2], MASS: [1.0, 2.0]},
        {"evaluation.jnd.imag": [0.1, 0.2]},
        {"hand.b": [4.0, 5.0]},
    ],
)
def test_a_sweep_is_another_one_if_anything_differs_but_the_own_values_of_what_is_swept(vary: dict[str, Any]) -> None:
    """Else one would go on with the sets of another."""

    def mark(scene: hs.Scene, values: dict[str, Any] = vary) -> str:
        return SweepGrid.of(scene, axes(scene, values)).fingerprint

    swept = {*vary, *(["evaluation.jnd.real", "evaluation.jnd.imag"] if "evaluation.jnd" in vary else [])}
    limits = [f"evaluation.jnd.{part}" for part in ("real", "imag")]
    for path in [*(p.path for p in HELD.parameters), *limits, "hand.m", "hand.b", "hand.k"]:
        other = HELD.with_values({path: HELD.knobs[path].value * Fraction(6, 5)})
        assert (mark(other) == mark(HELD)) is (path in swept), path
    others = [
        HELD.with_band(1, 15), HELD.with_band(0, 14), PAPER.with_hands(hs.Hand("two", m=1, b=5, k=40)),
        hs.Scene(HELD.environment, HELD.effects * 2, HELD.band, HELD.threshold, hands=HELD.hands),
        hs.Scene(HELD.environment, HELD.effects, HELD.band, HELD.threshold, HELD.environment, hands=HELD.hands),
    ]  # fmt: skip
    backward = dict(reversed(vary.items())) if len(vary) > 1 else {path: x[:1] for path, x in vary.items()}
    marks = [mark(x) for x in (HELD, *others)]
    marks += [mark(HELD, {path: [*x, 3.0] for path, x in vary.items()}), mark(HELD, backward)]
    assert len(set(marks)) == len(marks)


def test_sweeps_of_other_regions_and_hands_are_other_sweeps() -> None:
    asked = [with_jnd(JNDS["diamond"]), with_jnd(JNDS["polygon"]), PAPER, HELD, PAPER.with_hands(hs.Hand("a", b=5))]
    assert len({SweepGrid.of(x, axes(x, {MASS: [1.0, 2.0]})).fingerprint for x in asked}) == len(asked)


@pytest.mark.dear("other.zarr-another sweep")
@pytest.mark.parametrize(
    ("out", "words"),
    [("empty.zarr", "not a Zarr store"), ("text.zarr", "not a Zarr store"), ("text.nc", "not a NetCDF file"),
     ("a.csv", "end the name in .zarr"), ("other.zarr", "another sweep")],
)  # fmt: skip
def test_what_is_no_store_of_this_sweep_is_told(out: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "empty.zarr").mkdir()
    for name in ("text.zarr", "text.nc"):
        (tmp_path / name).write_text("x")
    if out == "other.zarr":
        hs.sweep(PAPER, {MASS: [1.0]}, out=tmp_path / out)
    with pytest.raises(hs.SceneError, match=words):
        hs.sweep(PAPER, FEW, out=tmp_path / out)


# --- what is said, and refused ---------------------------------------------------------------------------------------

HANDS = {"unstable_one": "one", "unstable_no_two_2": "no. two", "unstable_no_two_3": "no two"}
TOLD = PAPER.with_hands(*(hs.Hand(name, 1, 5, 40) for name in HANDS.values()))


@pytest.fixture(scope="module")
def held() -> Any:
    return hs.sweep(TOLD, {**FEW, "evaluation.jnd": [0.1, 0.2]})


@pytest.mark.dear("0", "1")
@pytest.mark.parametrize("seed", range(4))
def test_a_document_of_a_sweep_counts_its_sets(seed: int, held: Any) -> None:
    """Of values that are drawn, of which many, or none, or all are absent; counted a second time in plain Python."""
    draw, data = Random(seed), held.copy(deep=True)
    for name, x in data.data_vars.items():
        absent = draw.choice([0.0, 0.5, 1.0])
        options = [-1, 0, 1, 2] if name == "method" else [0, 1, 2, INFINITE, -1] if name in HANDS else [-1, 0, 1, 2, 5]
        some = draw.sample(options, 2)
        value = (lambda a=absent: np.nan if draw.random() < a else draw.uniform(0, 15)) if x.dtype == float else (lambda s=some: draw.choice(s))  # fmt: skip
        data[name][:] = np.array([value() for _ in range(x.size)]).reshape(x.shape)
    found = Swept(TOLD, data, draw.choice([None, Path("a.zarr")])).to_dict()
    method = data.method.values.ravel().tolist()
    assert [found[x] for x in ("sets", "certified_in_floats", "exact", "open")] == [
        12, method.count(0), method.count(1), method.count(2) + method.count(-1),
    ]  # fmt: skip
    assert [(x["path"], x["unit"], x["low"], x["high"], x["values"]) for x in found["vary"]] == [
        (NATURAL, "rad/s", 40.0, 120.0, 2), (MASS, "kg", 0.5, 2.0, 3), ("evaluation.jnd", "1", 0.1, 0.2, 2),
    ]  # fmt: skip
    for name, row in ((x, data[x].values.ravel().tolist()) for x in data.data_vars):
        if data[name].dtype == float:
            there = [x for x in row if not isnan(x)]
            assert found["ranges"][name] == ([min(there), max(there)] if there else None)
        elif name != "method" and name not in HANDS:
            assert found["counts"][name] == {str(n): row.count(n) for n in sorted(set(row)) if n >= 0}
    assert {x["variable"]: x["hand"] for x in found["held"]} == HANDS
    for x in found["held"]:
        row = data[x["variable"]].values.ravel().tolist()
        assert x["unstable"] == {str(n): row.count(n) for n in sorted(set(row)) if n not in (-1, INFINITE)}
        assert [x[key] for key in ("stable", "infinite", "undecided")] == [row.count(n) for n in (0, INFINITE, -1)]
    left = [
        {path: float(one[path]) for path in data.method.dims} for one, _ in sets(data) if int(one.method) in (-1, 2)
    ]
    assert found.get("open_at", []) == left[:5]
    proven = method.count(0) + method.count(1)
    assert (f"for {proven} sets of floats" in " ".join(str(Swept(TOLD, data)).split())) is (proven > 0)


def test_variables_are_named_with_their_units_and_what_is_proven_is_said() -> None:
    plain = hs.sweep(PAPER, {MASS: [1.0]})
    assert set(plain.data_vars) == {
        "first_crossing_real", "first_crossing_imag", "bandwidth", "transparent", "changeover_environment", "changeover_perceived",
        "crossings_real", "crossings_imag", "changeovers_environment", "changeovers_perceived", "method",
    }  # fmt: skip
    units = {name: x.attrs["units"] for name, x in plain.data_vars.items() if x.dtype == float}
    assert units == {**dict.fromkeys(units, "rad/s"), "transparent": "1"}
    assert (plain.attrs["schema"], plain.attrs["band"]) == ("haptisym.sweep/1", [0.0, 15.0])
    assert plain.attrs["relative_accuracy"] == 1e-10
    late = hs.sweep("delayed-spring", {"environment.k": [1.0]})
    assert ["sines" in x.attrs["floats"] for x in (plain, late)] == [False, True]
    tissue = hs.Scene(hs.environments.spring_pot(80, "0.5"), (hs.effects.first_order_lag(40),), (1, 2))
    assert "every set is answered exactly" in hs.sweep(tissue, {"environment.alpha": [0.5]}).attrs["floats"]


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({}, "vary: name a parameter"),
        (
            {"effects.filter.omega": [1.0]},
            'unknown parameter "effects.filter.omega": did you mean "effects.filter.omega_n"',
        ),
        ([MASS], "give values by path"),
        ({MASS: []}, "give at least one value"),
        ({MASS: [1.0, float("inf")]}, "finite"),
        ({MASS: [float("nan")]}, "finite"),
        ({MASS: [1.0, -0.5]}, "must be >= 0"),
        ({NATURAL: [0.0]}, "must be > 0"),
        ({MASS: [None]}, "is not a number, or a string"),
        ({MASS: [1.0, 1.0]}, "only once"),
        ({MASS: ["1 N/m"]}, "not a mass"),
        ({MASS: ["1 kg*m^2"]}, "rotational"),
        ({"evaluation.jnd": [0.1], "evaluation.jnd.real": [0.1]}, "both thresholds"),
        (
            {MASS: np.linspace(1, 2, 10**5), NATURAL: np.linspace(1, 2, 10**5)},
            "10,000,000,000 sets .*stream them to a file",
        ),
    ],
)
def test_what_cannot_be_swept_is_told(vary: Any, message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.sweep(PAPER, vary)


def test_what_is_left_open_beside_what_is_swept_needs_a_number() -> None:
    free = PAPER.with_values({MASS: Symbol("m", positive=True), NATURAL: Symbol("w", positive=True)})
    with pytest.raises(hs.SceneError, match=r"environment.m = m is a symbol"):
        hs.sweep(free, {NATURAL: [40.0]})
    with pytest.raises(hs.SceneError, match='unknown parameter "evaluation.jnd"'):
        hs.sweep(with_jnd(JNDS["polygon"]), {"evaluation.jnd": [0.1]})


@pytest.mark.parametrize("span", ["", "=1:2", "=1:2:x", "=1:2:1", "=0:2:3:log", "=1:2:3:4"])
def test_a_span_that_is_none_is_told(span: str) -> None:
    with pytest.raises(hs.SceneError):
        spaced(MASS + span, PAPER)


@pytest.mark.slow
def test_the_command_writes_document_store_and_chart(call: Any, tmp_path: Path) -> None:
    import zarr

    vary = ["--vary", f"{NATURAL}=40 rad/s:20 Hz:4", "--vary", f"{MASS}=0.5:2:3:log", "--hand", "light-touch"]
    status, out, _ = call("sweep", "fu2019", *vary, "--out", str(tmp_path / "a.zarr"), "--figure", str(tmp_path / "a.svg"), "--json")  # fmt: skip
    told, own = json.loads(out), hs.sweep(PAPER, dict(spaced(x, PAPER) for x in vary[1:4:2]), hand="light-touch")
    assert (status, told["sets"], told["certified_in_floats"]) == (0, 12, 12)
    assert told["ranges"]["bandwidth"] == [float(own.bandwidth.min()), float(own.bandwidth.max())]
    assert told["held"][0]["stable"] == int((own.unstable_light_touch == 0).sum())
    assert (tmp_path / "a.svg").read_text(encoding="utf-8").startswith("<?xml")
    assert (np.asarray(zarr.open_group(tmp_path / "a.zarr")["bandwidth"]) == own.bandwidth.values).all()


def test_the_command_tells_sets_without_answer_with_status_3(call: Any, tmp_path: Path) -> None:
    text = (
        '[environment]\nmodel = "mass-spring-damper"\nk = 100\n[[effects]]\nmodel = "first-order-lag"\nomega_c = 20\n'
    )
    (tmp_path / "spring.toml").write_text(text, encoding="utf-8")
    status, out, _ = call("sweep", str(tmp_path / "spring.toml"), "--vary", "environment.k=0:100:2")
    assert status == 3
    assert "Undecided: 1 sets" in out
    assert "environment.k = 0" in out


@pytest.mark.dear("words6---out FILE.zarr")
@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--vary", "environment.m=1:2"), "PATH=LO:HI:N"),
        (("--vary", "environment.q=1:2:3"), "environment.q"),
        (("--vary", "environment.m=1:2:3", "--workers", "2"), "workers"),
        (("--vary", "environment.m=1:2:3", "--figure", "a.gif"), "a.gif"),
        (("--vary", "environment.m=1:2:3", "--out", "a.csv"), "a.csv"),
        (("--vary", "environment.m=1:2:3", "--vary", "environment.m=1:2:3"), "only once"),
        (("--vary", "environment.m=1:2:100000", "--vary", "environment.k=1:2:100000"), "--out FILE.zarr"),
        (("--vary", "omega_n=10:100:10", "--hand", "postural arm"), 'did you mean "postural-arm"'),
        ((), "vary"),
    ],
)
def test_a_wrong_command_line_is_one_message_and_status_2(call: Any, words: tuple[str, ...], told: str) -> None:
    status, out, err = call("sweep", "fu2019", *words)
    assert (status, out) == (2, "")
    assert told in err


# --- charts ----------------------------------------------------------------------------------------------------------


def test_charts_show_the_numbers_of_the_sweep_in_the_units_of_the_scene(few: Any) -> None:
    from matplotlib.figure import Figure

    ax = Figure().add_subplot()
    draw(ax, sweep_charts.plane(few))
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_xlim()) == ("$m$ (kg)", r"$\omega_n$ (rad/s)", (0.5, 2.0))
    with pytest.raises(hs.SceneError, match="one or two parameters"):
        draw(ax, sweep_charts.plane(few.isel({MASS: 2}, drop=True)))
    stick = hs.load_scene("sidestick")
    ax = Figure().add_subplot()
    line, *_ = draw(ax, sweep_charts.curves(hs.sweep(stick, {"environment.k": [1.0, 3.0, 9.0]})))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$k$ (N·m/rad)", "frequency (Hz)")
    exact = hs.evaluate(stick.with_values({"k": 3})).bandwidth
    assert exact is not None
    assert np.asarray(line.get_ydata())[1] == pytest.approx(float(exact) / (2 * np.pi))
    ax = Figure().add_subplot()
    hertz = replace(PAPER, effects=(hs.effects.second_order_lowpass("12.5 Hz", "0.5", name="filter"),))
    draw(ax, sweep_charts.curves(hs.sweep(hertz, {NATURAL: ["5 Hz", "20 Hz", "50 Hz"]}), hertz))
    assert (ax.get_xlabel(), ax.get_xlim()) == (r"$\omega_n$ (Hz)", (5, 50))


@pytest.mark.slow
def test_the_bandwidth_is_drawn_in_pieces_that_end_where_crossings_come_or_go() -> None:
    """Witness: exact evaluations at both sides of each break, ever closer, and in the middle of every step that is drawn."""
    from matplotlib.figure import Figure

    def exact(m: float) -> tuple[float, int]:
        found = hs.evaluate(PAPER.with_values({"m": m}))
        assert found.bandwidth is not None
        return float(found.bandwidth), len(found.crossings)

    ax = Figure().add_subplot()
    [*_, line] = draw(ax, sweep_charts.curves(hs.sweep(PAPER, {MASS: np.linspace(0.5, 5, 46)})))
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    jumps = []
    for i in np.flatnonzero(np.isnan(x)):
        low, high = float(x[i - 1]), float(x[i + 1])
        count = exact(high)[1]
        for _ in range(24):
            middle = (low + high) / 2
            low, high = (low, middle) if exact(middle)[1] == count else (middle, high)
        assert high - low < 1e-6
        assert abs(exact(low)[1] - exact(high)[1]) == 2
        jumps.append(abs(exact(low)[0] - exact(high)[0]))
    assert max(jumps) > 0.9  # rad/s: what a line would have hidden
    for a, b, low, high in zip(x[:-1], x[1:], y[:-1], y[1:], strict=True):
        if not np.isnan([a, b]).any():
            assert min(low, high) - 0.2 < exact(float(a + b) / 2)[0] < max(low, high) + 0.2


@pytest.mark.slow
def test_the_exact_boundary_divides_the_sets_of_a_sweep_and_is_drawn_in_its_map() -> None:
    """Two engines on one plane: critical values slice by slice, and Bernstein coefficients set by set."""

    exact = hs.design_map(PAPER, [MASS, NATURAL], [(0.5, 5), (20, 200)], slices=5)
    masses = [float(x.at) for x in exact.slices]
    found = hs.sweep(PAPER, {MASS: masses, NATURAL: np.linspace(21, 199, 90)})
    for x in exact.slices:
        [span] = x.requirement.feasible
        column = found.bandwidth.sel({MASS: float(x.at)})
        assert ((column.values == 15) == (column[NATURAL].values >= float(span.low))).all()
    few = hs.sweep(PAPER, {NATURAL: [60, 100, 140, 180], MASS: [0.5, 1, 2, 4]})
    for of, is_drawn in ((PAPER, True), (None, False)):
        [ax] = sweep_charts.sweep_figure(few, of).axes
        assert any("band's edge" in text.get_text() for text in ax.get_legend().get_texts()) is is_drawn


def test_a_delay_that_turns_more_often_than_anybody_counts_is_not_answered() -> None:
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"),))
    assert hs.sweep(scene, {"tau": [0.005, 1e6, 1e300]}).method.values.tolist() == [0, 2, 2]
