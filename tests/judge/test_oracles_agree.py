"""Three hundred random scenes, and some with pi in them, against Sturm's theorem, exact arithmetic and mpmath."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import strategies
import sympy
from answers import (
    below,
    floats,
    is_outside_model,
    is_transparent,
    number_below,
    of_part,
    percepts_at,
)
from marks import often
from oracles import DIGITS, MP, Case, Element, Facts, Hertz, digits_of, excess_roots, in_square, scan, sign
from strategies import Scale, Seeded, evaluate, number

import haptisym as hs

PARTS = ("real", "imag")
BLOCKS, BLOCK = 10, 31

each_block = pytest.mark.parametrize("block", often(range(BLOCKS), lambda block: block < 4))


@cache
def judged(seed: int) -> tuple[Case, hs.Evaluation]:
    case = strategies.case(Seeded(seed), order=4)
    return case, evaluate(case)


def family(block: int) -> list[tuple[Case, hs.Evaluation]]:
    return [judged(seed) for seed in range(block * BLOCK, (block + 1) * BLOCK)]


def samples(case: Case, count: int, seed: int = 0) -> list[Fraction]:
    """Rational frequencies inside the band, in order."""
    pick = Seeded(seed)
    low, high = (Fraction(sympy.Rational(str(digits_of(x)))) for x in case.band)
    return sorted({low + (high - low) * Fraction(pick.whole(1, 99_999), 100_000) ** 2 for _ in range(count)})


# --- the oracles against each other ----------------------------------------------------------------------------------


@pytest.mark.few("3", "1", "4")
@pytest.mark.parametrize("seed", range(5))
def test_the_polynomial_of_the_oracle_is_that_of_sympy_s_real_and_imaginary_parts(seed: int) -> None:
    case = strategies.case(Seeded(seed), order=2)
    omega = sympy.Symbol("omega", positive=True)
    H, G = case.dynamics(sympy.I * omega, strategies.exact)
    square = sympy.together(sympy.expand(H * sympy.conjugate(H), complex=True))
    for part, difference in zip(PARTS, sympy.together(G - H).as_real_imag(), strict=True):
        written_out = sympy.cancel(sympy.together(sympy.expand(difference, complex=True)))
        excess = sympy.cancel(sympy.together(written_out**2 / square - strategies.exact(case.c[part]) ** 2))
        written = sympy.Poly(sympy.fraction(excess)[0], omega, domain="QQ")
        assert in_square(written).monic() == case.excess[part].monic(), case


@pytest.mark.parametrize("seed", range(12))
def test_exact_facts_are_those_of_mpmath(seed: int) -> None:
    case = strategies.case(Seeded(seed))
    for omega in samples(case, 5):
        facts = case.facts(omega)
        for part in PARTS:
            assert facts[part].excess == sign(case.ratio(part, digits_of(omega)) - digits_of(case.c[part]))


@pytest.mark.parametrize("seed", range(8))
def test_roots_of_mpmath_are_as_many_as_sturm_counts(seed: int) -> None:
    case = strategies.case(Seeded(seed), order=3, felt=DAMPED, between=LAGGING)
    for part in PARTS:
        assert len(excess_roots(case, part)) == case.counts[part], case


# --- the package against the oracles ---------------------------------------------------------------------------------


@pytest.mark.few(2)
@each_block
def test_crossings_of_random_scenes_are_as_many_as_sturm_counts(block: int) -> None:
    for case, result in family(block):
        for part in PARTS:
            assert len(of_part(result, part)) == case.counts[part], (part, case)


@pytest.mark.slow
def test_the_random_scenes_have_from_no_crossing_to_many() -> None:
    counts = {len(judged(seed)[1].crossings) for seed in range(BLOCKS * BLOCK)}
    assert set(range(7)) <= counts


@pytest.mark.few(2)
@each_block
def test_at_each_crossing_the_ratio_is_the_threshold(block: int) -> None:
    for case, result in family(block):
        for crossing in above_zero(result):
            part = crossing.part.value
            ratio = case.ratio(part, MP.mpf(crossing.omega.digits(55)))
            assert abs(ratio - digits_of(case.c[part])) < MP.mpf(10) ** -35, (crossing, case)


def above_zero(result: hs.Evaluation) -> list[hs.Crossing]:
    return [c for c in result.crossings if float(c.omega) > 0]


def near(result: hs.Evaluation, crossing: hs.Crossing) -> tuple[Fraction, Fraction]:
    """Rational frequencies just below and just above a crossing, with no other point of the chart in between."""
    points = [p.omega.bounds(120) for p in result.chart.points]
    low, high = crossing.omega.bounds(120)
    gap = min(abs(low - x) for x, _ in points if x != low)
    return low - gap / 1000, high + gap / 1000


@pytest.mark.few(2)
@each_block
def test_kind_and_sign_of_a_crossing_are_those_of_exact_values_on_either_side(block: int) -> None:
    kinds = {(-1, 1): "exceeds", (1, -1): "returns", (-1, -1): "touches", (1, 1): "touches"}
    for case, result in family(block):
        for crossing in above_zero(result):
            before, after = (case.facts(omega)[crossing.part.value] for omega in near(result, crossing))
            assert crossing.kind.value == kinds[before.excess, after.excess], (crossing, case)
            assert crossing.sign == before.difference == after.difference, (crossing, case)


@pytest.mark.few(2)
@each_block
def test_multiplicities_add_up_to_those_of_the_square_free_factors(block: int) -> None:
    for case, result in family(block):
        low, high = (strategies.exact(x) ** 2 for x in case.band)
        for part in PARTS:
            _, factors = case.excess[part].sqf_list() if case.counts[part] else (1, [])
            expected = sum(n * int(f.count_roots(low, high)) for f, n in factors)
            found = of_part(result, part)
            # the multiplicity counts in omega, of which W is the square at 0 and a simple function elsewhere
            assert sum(c.multiplicity if float(c.omega) else c.multiplicity // 2 for c in found) == expected, case


def expected_percepts(part: str, at: Facts) -> list[tuple[str, str]]:
    """Section 2.3 of the paper, for one frequency."""
    if at.excess <= 0 or (part == "imag" and at.perc < 0):
        return []
    sides = {
        (1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness",
        (0, 1): "stiffness", (1, 0): "stiffness", (0, -1): "mass", (-1, 0): "mass",
    }  # fmt: skip
    change = {1: "higher", -1: "lower", 0: "equal"}[at.larger]
    return [("damping" if part == "imag" else sides[at.env, at.perc], change)]


def check_at(case: Case, result: hs.Evaluation, omega: Fraction) -> None:
    """Everything that an evaluation says about one frequency."""
    facts = case.facts(omega)
    assert is_transparent(result, omega) == all(facts[part].excess <= 0 for part in PARTS), (omega, case)
    assert is_outside_model(result, omega) == (facts["imag"].perc < 0), (omega, case)
    for part in PARTS:
        assert percepts_at(result, part, omega) == expected_percepts(part, facts[part]), (omega, case)


@pytest.mark.few(2)
@each_block
def test_transparent_set_percepts_and_activity_hold_exactly_the_frequencies_they_should(block: int) -> None:
    for seed, (case, result) in enumerate(family(block)):
        for omega in samples(case, 7, seed):
            check_at(case, result, omega)


@pytest.mark.few(2)
@each_block
def test_just_beside_every_point_of_the_chart_the_evaluation_is_right(block: int) -> None:
    for case, result in family(block)[::4]:
        points = sorted(p.omega.bounds(120) for p in result.chart.points)
        for (_, below_gap), (above_gap, _) in pairwise(points):
            gap = above_gap - below_gap
            check_at(case, result, below_gap + gap / 10**6)
            check_at(case, result, above_gap - gap / 10**6)


@pytest.mark.few(2)
@each_block
def test_between_changeovers_the_real_part_keeps_its_sign(block: int) -> None:
    for seed, (case, result) in enumerate(family(block)):
        marks = [(omega, case.facts(omega)["real"]) for omega in samples(case, 5, seed)]
        for (low, at_low), (high, at_high) in pairwise(marks):
            for found, a, b in (
                (result.changeovers_environment, at_low.env, at_high.env),
                (result.changeovers_perceived, at_low.perc, at_high.perc),
            ):
                changes = number_below(found, high) - number_below(found, low)
                assert a * b == (-1) ** changes or a == b == 0, (low, high, case)


@pytest.mark.few(1)
@each_block
def test_a_grid_search_finds_no_crossing_that_the_certified_answer_lacks(block: int) -> None:
    for case, result in family(block):
        low, high = map(float, case.band)
        grid = np.unique(np.concatenate([np.linspace(low, high, 300), np.geomspace(max(low, high * 1e-5), high, 300)]))
        grid = grid[grid > 0]
        H, G = case.dynamics(1j * grid, float)
        D, size = G - H, abs(H)
        for part, values in (("real", D.real), ("imag", D.imag)):
            excess = np.abs(values) / size - float(case.c[part])
            crossings = np.array([float(c.omega) for c in of_part(result, part) if c.kind.value != "touches"])
            for i in np.flatnonzero(np.diff(np.sign(excess))):
                if min(abs(excess[i]), abs(excess[i + 1])) > 1e-9:
                    inside = np.count_nonzero((grid[i] < crossings) & (crossings < grid[i + 1]))
                    assert inside % 2 == 1, (part, grid[i], case)


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(40))
def test_where_zeros_poles_and_ends_coincide_the_evaluation_is_still_right(seed: int) -> None:
    case = strategies.coincident_case(Seeded(seed))
    result = evaluate(case)
    assert {part: len(of_part(result, part)) for part in PARTS} == case.counts
    points = sorted(p.omega.bounds(120) for p in result.chart.points)
    for (_, start), (end, _) in pairwise(points):
        for share in (Fraction(1, 10**6), Fraction(1, 2), 1 - Fraction(1, 10**6)):
            check_at(case, result, start + (end - start) * share)


# --- pi --------------------------------------------------------------------------------------------------------------

DAMPED = ("kelvin-voigt", "maxwell", "zener")
LAGGING = ("first-order-lag", "second-order-lowpass", "gain", "lead-lag", "pade-delay", "admittance-display")


@cache
def with_pi(seed: int) -> tuple[Case, hs.Evaluation]:
    """A random scene whose cut-offs are in Hz beside rational numbers, on a band that ends at a number of Hz."""
    pick = Seeded(seed)
    case = strategies.case(pick, order=3, felt=DAMPED, between=LAGGING)
    effects = [Element("first-order-lag", {"omega_c": Hertz(number(pick, Scale(0, 3)))})]
    for old in case.between[:1]:
        turned = {n: Hertz(x) if n in ("omega_c", "omega_n", "w") else x for n, x in old.values.items()}
        effects.append(Element(old.kind, turned))
    case = case.with_(between=tuple(effects), band=(Fraction(0), Hertz(number(pick, Scale(0, 2)))))
    return case, evaluate(case)


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(24))
def test_scenes_with_pi_have_the_crossings_of_mpmath(seed: int) -> None:
    case, result = with_pi(seed)
    for part in PARTS:
        expected = excess_roots(case, part)
        found = [c for c in above_zero(result) if c.part.value == part]
        assert len(found) == len(expected), (part, case)
        for crossing, omega in zip(found, expected, strict=True):
            assert abs(MP.mpf(crossing.omega.digits(40)) / omega - 1) < MP.mpf(10) ** -25, (part, case)


@pytest.mark.parametrize("seed", range(24))
def test_scenes_with_pi_are_judged_as_mpmath_does_at_any_frequency(seed: int) -> None:
    case, result = with_pi(seed)
    for omega in samples(case, 6, seed):
        check_at(case, result, omega)


def test_scenes_with_pi_have_crossings_of_both_parts() -> None:
    found = [crossing.part.value for seed in range(24) for crossing in with_pi(seed)[1].crossings]
    assert min(found.count("real"), found.count("imag")) >= 10


def test_a_scan_with_forty_digits_finds_the_crossings_of_the_paper_s_scene() -> None:
    case = PAPER.with_(band=(Fraction(0), Fraction(200)))
    result = evaluate(case)
    grid = [MP.mpf(n) / 3 for n in range(1, 600)]
    for part in PARTS:
        found = scan(lambda w, part=part: case.ratio(part, w) - digits_of(case.c[part]), grid)
        certified = [MP.mpf(c.omega.digits(50)) for c in of_part(result, part)]
        assert len(found) == len(certified)
        assert all(abs(a - b) < MP.mpf(10) ** -35 for a, b in zip(found, certified, strict=True))


PAPER = Case(
    Element("mass-spring-damper", {"m": Fraction(9, 5), "b": Fraction(15), "k": Fraction(100)}),
    (Element("second-order-lowpass", {"omega_n": Fraction(80), "zeta": Fraction(1, 2)}),),
)


def test_a_scan_of_mpmath_finds_the_changeovers_of_the_paper_s_scene() -> None:
    result = evaluate(PAPER)
    grid = [MP.mpf(n) / 7 for n in range(1, 105)]
    for which, found in enumerate((result.changeovers_environment, result.changeovers_perceived)):
        [expected] = scan(lambda w, which=which: PAPER.dynamics(MP.mpc(0, w), DIGITS)[which].real, grid)
        assert floats(found) == [float(expected)]
        assert below(found[0].omega, Fraction(15))
