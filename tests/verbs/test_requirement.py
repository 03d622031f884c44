"""Inverse design: which values of a parameter keep a display transparent on its whole band."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb
from marks import often, spread
from matplotlib.figure import Figure
from strategies import Seeded, case, coincident_case, scene
from sympy import Expr, Integer, Poly, Rational, Symbol, asin, degree, pi, sqrt, symbols, sympify

import haptisym as hs
from haptisym import effects, environments
from haptisym.cli import main
from haptisym.figures.designmap import draw_map
from haptisym.figures.require import draw_requirement
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import ExactNumber, Sliver
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega as OMEGA  # noqa: N812
from haptisym.model.distortion import Distortion
from haptisym.model.knobs import THRESHOLD
from haptisym.model.parameters import values
from haptisym.verbs.require.boundary import irreducible, real_roots
from haptisym.verbs.require.cells import BITS, Leaf, ValueSearch, _bound_by_phase, _middle
from haptisym.verbs.require.clusters import Strips, _Box, _clusters, _place, places
from haptisym.verbs.require.criticalvalues import Problem
from haptisym.verbs.require.entry import is_quick
from haptisym.verbs.require.feasible import End, Kind, Span, spanned
from haptisym.verbs.require.freeparameter import Domain, conditions, domain
from haptisym.verbs.require.places import CellVerdict, CriticalPlace, MaximumAt, Strip
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.solving import ValueLine
from haptisym.verbs.require.strips import Shape, _wave
from haptisym.verbs.require.touches import Surface, touch

PAPER = hs.load_scene("fu2019")
REAL, IMAG = hs.Part.REAL, hs.Part.IMAG
JND = dict(zip(hs.Part, noticed(hs.Threshold()), strict=True))
SPRING = environments.mass_spring_damper(k=100)
LATE = hs.Scene(SPRING, (effects.delay("5 ms"),), (0, 15))


# --- witnesses -------------------------------------------------------------------------------------------------------


def is_transparent(scene: hs.Scene, parts: tuple[hs.Part, ...] = tuple(hs.Part)) -> bool:
    """By an evaluation at this one value, exact: no ratio rises above its threshold, nor is above it at the low end."""
    e = hs.evaluate(scene)
    if set(parts) == set(hs.Part):
        return (
            len(e.transparent) == 1
            and e.transparent[0].low is e.chart.points[0]
            and e.transparent[0].high is e.chart.points[-1]
        )
    [part] = parts
    loose = (scene.threshold[x] if x is part else Rational(10**9) for x in hs.Part)
    return is_transparent(hs.Scene(scene.environment, scene.effects, scene.band, hs.Threshold.of(*loose)))


def holds(found: Requirement, value: Expr) -> bool:
    """Whether a number that is no end lies in the set that was found."""
    limits = [[None if x.value is None else float(x.value) for x in (s.low, s.high)] for s in found.feasible]
    return any((a is None or a < value) and (b is None or value < b) for a, b in limits)


def ends(found: Requirement) -> list[float]:
    return sorted({float(end.value) for x in found.feasible for end in (x.low, x.high) if end.value is not None})


def contradictions(scene: hs.Scene, found: Requirement, random: Random, count: int = 6) -> list[tuple[float, bool]]:
    """Values close to each end on both sides, and random ones, at which an evaluation says otherwise."""
    own = values(scene.parameters).get(found.free.symbol, Rational(1, 10))
    bases = [*ends(found), float(own), 1.0]
    tried = {Rational(end * f).limit_denominator(10**15) for end in ends(found) for f in (1 - 1e-7, 1 + 1e-7)}
    tried |= {
        Rational(random.choice(bases) * random.choice((1, 1, 1, -1)) * 10 ** random.uniform(-1, 1)).limit_denominator(
            10**6
        )
        for _ in range(count)
    }
    low, high = found.domain.low, found.domain.high
    asked = [x for x in tried if x and (low is None or x > low) and (high is None or x < high)]
    wrong = []
    for value in asked:
        try:
            expected = is_transparent(found.free.put(scene, value), tuple(x.part for x in found.criteria))
        except SceneError:
            continue
        if holds(found, value) is not expected:
            wrong.append((float(value), expected))
    return wrong


# --- the paper's example ---------------------------------------------------------------------------------------------

KNOWN = [
    ("omega_n", None, ">=", "122.355814770431", (IMAG, "band-edge", "15.0000")),
    ("omega_n", REAL, ">=", "91.9531066948107", (REAL, "band-edge", "15.0000")),
    ("zeta", None, "<=", "0.264345145449365", (IMAG, "band-edge", "15.0000")),
    ("zeta", REAL, "<=", "0.445250007278434", (REAL, "tangency", "11.6778")),
    (THRESHOLD, None, ">=", "0.155424076383943", (IMAG, "band-edge", "15.0000")),
    (THRESHOLD, REAL, ">=", "0.116246915081956", (REAL, "band-edge", "15.0000")),
]


@pytest.mark.parametrize(("path", "part", "sense", "digits", "binds"), KNOWN)
def test_the_papers_example_needs_these_values(path, part, sense, digits, binds) -> None:  # type: ignore[no-untyped-def]
    found = hs.require(PAPER, path, part=part)
    [span] = found.feasible
    end = span.low if sense == ">=" else span.high
    [b] = end.bindings
    assert end.value.digits(15) == digits
    assert (b.part, b.kind.value, b.omega.digits(6)) == binds
    assert end.closed
    assert found.certified
    assert not contradictions(PAPER, found, Random(1))


@pytest.mark.parametrize("path", ["environment.m", "environment.b", "environment.k"])
def test_no_environment_of_its_kind_hides_the_papers_filter(path: str) -> None:
    found = hs.require(PAPER, path)
    assert found.feasible == ()
    assert not contradictions(PAPER, found, Random(2), 20)


def test_the_mass_may_be_chosen_where_the_filter_is_faster() -> None:
    faster = PAPER.with_values({"omega_n": 150})
    found = hs.require(faster, "m")
    assert found.feasible
    assert not contradictions(faster, found, Random(3), 20)


def test_with_less_damping_a_touch_inside_the_band_binds() -> None:
    light = PAPER.with_values({"b": 5}).with_band(0, 9)
    [span] = hs.require(light, "omega_n").feasible
    [b] = span.low.bindings
    assert span.low.value.digits(12) == "76.6513047708"
    assert (b.part, b.kind.value) == (REAL, "tangency")
    near = hs.evaluate(light.with_values({"omega_n": Rational(span.low.value.digits(14)) - Rational(1, 10**9)}))
    first, last = (float(x.omega) for x in near.crossings)
    assert first < float(b.omega) < last
    assert last - first < 1e-3


# --- sets of every shape ---------------------------------------------------------------------------------------------


def gain(formula: str, **parameters: object) -> hs.Scene:
    """A spring behind a constant gain: r_r = |gain - 1|, c = 1/10."""
    return hs.Scene(SPRING, (effects.series(formula, parameters=parameters),), (0, 15))


def test_a_condition_without_frequency_has_exact_ends() -> None:
    [span] = hs.require(gain("g", g=1), "g").feasible
    assert (span.low.value.value, span.high.value.value) == (Rational(9, 10), Rational(11, 10))


def test_two_intervals_on_both_sides_of_zero() -> None:
    found = hs.require(gain("g^2", g=1), "g")
    assert [[round(float(x), 6) for x in (s.low.value, s.high.value)] for s in found.feasible] == [
        [-1.048809, -0.948683],
        [0.948683, 1.048809],
    ]
    assert found.feasible[0].low.value.digits(20) == f"-{found.feasible[1].high.value.digits(20)}"


@pytest.mark.parametrize(("formula", "expected"), [("(g-2)^2", ["2.00000"]), ("(g^2-2)^2", ["-1.41421", "1.41421"])])
def test_single_values_that_touch_are_found(formula: str, expected: list[str]) -> None:
    found = hs.require(gain(f"1 + (1 + {formula})/10", g=1), "g")
    assert [x.low.value.digits(6) for x in found.feasible] == expected
    assert all(x.low.value is x.high.value and x.low.closed and x.high.closed for x in found.feasible)


@pytest.mark.parametrize(("formula", "expected"), [("(g-2)^2", [2.0]), ("(g^2-2)^2", [-(2**0.5), 2**0.5])])
def test_single_values_that_do_not_do_are_left_out(formula: str, expected: list[float]) -> None:
    """r = (1 - (g - 2)^2)/10 is below 10 % but at g = 2, where it touches: no value is left out."""
    found = hs.require(gain(f"1 + (1 - {formula})/10", g=1), "g")
    inside = [g for g in expected if any(float(x.low.value) < g < float(x.high.value) for x in found.feasible)]
    assert inside == expected


def test_a_pole_in_the_band_is_left_out_alone() -> None:
    """A spring behind 1 + g^2 s^2/(s^2 + 9)/1000...: any g but 0 has an infinite ratio at 3 rad/s."""
    found = hs.require(gain("1 + g*s^2/(s^2 + 9)", g=1), "g")
    assert [(x.low.value.value, x.high.value.value) for x in found.feasible] == [(0, 0)]


def test_a_range_limits_the_answer_and_nothing_binds_at_its_ends() -> None:
    [span] = hs.require(PAPER, "omega_n", ("100 rad/s", "40 Hz")).feasible
    assert (span.low.value.digits(6), span.high.value.digits(6)) == ("122.356", "251.327")
    assert span.high.closed
    assert span.high.bindings == ()


def test_pi_in_band_and_range() -> None:
    hertz = PAPER.with_band("0 Hz", "2 Hz")
    found = hs.require(hertz, "omega_n", ("1 Hz", "100 Hz"))
    [span] = found.feasible
    low = span.low.value
    just = Rational(1, 10**9)
    assert is_transparent(hertz.with_values({"omega_n": Rational(low.digits(14)) * (1 + just)}))
    assert not is_transparent(hertz.with_values({"omega_n": Rational(low.digits(14)) * (1 - just)}))


def test_compensation_may_be_negative() -> None:
    device = hs.Scene(PAPER.environment, (effects.shunt(m="0.2 kg"),), (0, 15))
    found = hs.require(device, "effects.shunt.m")
    [span] = found.feasible
    assert float(span.low.value) == pytest.approx(-float(span.high.value))
    assert not contradictions(device, found, Random(4))


# --- every environment at once ---------------------------------------------------------------------------------------


def test_for_any_environment_the_end_is_that_of_the_bandwidth() -> None:
    [span] = hs.require(PAPER, "omega_n", any_environment=True).feasible
    value = Rational(span.low.value.digits(20))
    for factor, full in ((1 + Rational(1, 10**9), True), (1 - Rational(1, 10**9), False)):
        below = hs.evaluate(PAPER.with_values({"omega_n": value * factor})).any_environment.transparent_below
        assert (float(below) == 15) is full


def test_any_environment_needs_effects_in_series() -> None:
    with pytest.raises(SceneError, match="series"):
        hs.require(hs.Scene(SPRING, (effects.shunt(m=1),)), "m", any_environment=True)
    with pytest.raises(SceneError, match="no parameter of the environment"):
        hs.require(PAPER, "m", any_environment=True)


# --- delays and powers -----------------------------------------------------------------------------------------------


def test_a_delay_on_a_spring_has_the_closed_form_asin_c() -> None:
    found = hs.require(LATE, "tau")
    [span] = found.feasible
    with mpmath.workdps(60):
        assert span.high.value.digits(50) == f"{mpmath.nstr(mpmath.asin(mpmath.mpf(1) / 10) / 15, 49)}0"
    c, end = symbols("c omega_max", positive=True)
    assert found.forms == (asin(c) / end,)
    assert found.closed_form == "tau <= asin(c)/omega_max"
    assert span.low.closed
    assert not contradictions(LATE, found, Random(5), 10)


def test_a_lag_on_a_spring_has_the_closed_form_of_derivation_10() -> None:
    lag = hs.Scene(SPRING, (effects.first_order_lag(80),), (0, 15))
    c, end = symbols("c omega_max", positive=True)
    [form] = hs.require(lag, "omega_c").forms
    exact = end * (1 + sqrt(1 - 4 * c**2)) / (2 * c)
    at = {c: Rational(1, 10), end: 15}
    assert abs((form - exact).subs(at).evalf(50)) < 1e-45


def test_a_delay_behind_a_filter() -> None:
    both = hs.Scene(PAPER.environment, (*PAPER.effects, effects.delay("1 ms")), (0, 7))
    found = hs.require(both, "zeta", ("0.3", "0.8"))
    [span] = found.feasible
    assert span.high.value.digits(20) == "0.53270790639032784558"
    assert not contradictions(both, found, Random(6), 3)


def test_a_spring_pot_and_a_range_that_is_decided_without_an_end() -> None:
    soft = hs.Scene(environments.spring_pot(k_alpha=5, alpha="0.5"), (effects.first_order_lag(200),), (0, 15))
    found = hs.require(soft, "omega_c", (100, 400))
    assert found.certified
    assert not contradictions(soft, found, Random(7), 4)


def test_a_hold_on_a_spring() -> None:
    """Half a period of delay, all but exactly: omega T = 0.20067 (derivation 03)."""
    held = hs.Scene(SPRING, (effects.zero_order_hold("1 ms"),), (0, 15))
    found = hs.require(held, "T", ("10 ms", "20 ms"))
    [span] = found.feasible
    assert found.certified
    assert (15 * float(span.high.value)) == pytest.approx(0.20067, abs=1e-5)


def test_a_threshold_of_one_part_beside_a_hold_leaves_the_other_part_as_it_is() -> None:
    fluid = hs.Scene(environments.maxwell(2, 9), (effects.zero_order_hold("30 ms"),), (0, "2/3"))
    one, both = (hs.require(fluid, path) for path in ("evaluation.jnd.imag", "evaluation.jnd"))
    assert one.certified
    assert [x.low.value.digits(12) for x in one.feasible] == [x.low.value.digits(12) for x in both.feasible]


# --- many scenes -----------------------------------------------------------------------------------------------------


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", spread(range(10, 100), 2))
def test_random_problems_agree_with_an_evaluation_at_each_value(seed: int) -> None:
    pick = Seeded(seed)
    told = scene(case(pick, order=4) if seed % 3 else coincident_case(pick))
    paths = [f"{place}.{p.key}" for place, element in told.elements() for p in element.parameters] + [THRESHOLD]
    path = pick.random.choice(paths)
    assert not contradictions(told, hs.require(told, path), pick.random)


@pytest.mark.parametrize("seed", often(range(40), lambda seed: seed == 3))
def test_a_dense_scan_finds_no_value_that_is_said_otherwise(seed: int) -> None:
    """Floats on a grid of values and frequencies: where the set says kept, no sample may exceed."""
    random = Random(seed)
    m, b, k = (10 ** random.uniform(x, x + 1.5) for x in (-1, 0, 1))
    low_pass = effects.second_order_lowpass(10 ** random.uniform(1, 2.5), 10 ** random.uniform(-1, 0))
    told = hs.Scene(environments.mass_spring_damper(m, b, k), (low_pass,), (0, 10 ** random.uniform(0.5, 1.5)))
    path = random.choice(["omega_n", "zeta", "m", "b", "k"])
    found = hs.require(told, path)
    own = float(values(told.parameters)[found.free.symbol])
    grid = own * np.logspace(-1, 1, 200)
    known = {x: v for x, v in values(told.parameters).items() if x != found.free.symbol}
    f = Distortion.of(told.chain.at(known)).compile()
    at = f(np.linspace(0, float(told.band[1]), 2000)[:, None], **{path: grid[None, :]})
    worst = np.maximum(np.nanmax(at.ratio_real, axis=0), np.nanmax(at.ratio_imag, axis=0)) / 0.1
    for value, ratio in zip(grid, worst, strict=True):
        if holds(found, Rational(value)):
            assert ratio <= 1 + 1e-9
        else:  # a scan may miss a little of a peak
            assert ratio > 1 - 1e-3


# --- charts ----------------------------------------------------------------------------------------------------------


def test_a_map_is_made_of_exact_slices() -> None:
    found = hs.design_map(PAPER, ["zeta", "omega_n"], [("0.1", "0.5"), (20, 200)], slices=3)
    last = found.slices[-1]
    [span] = hs.require(PAPER, "omega_n", (20, 200)).feasible
    assert last.requirement.feasible[0].low.value.digits(20) == span.low.value.digits(20)
    assert found.certified
    assert json.loads(found.to_json())["schema"] == "haptisym.designmap/1"


@pytest.mark.slow
def test_every_boundary_point_is_a_zero_of_one_of_the_curves() -> None:
    light = PAPER.with_values({"b": 5}).with_band(0, 9)
    found = hs.design_map(light, ["zeta", "omega_n"], [("0.3", "0.7"), (20, 200)], slices=3)
    curves = {(x.part, kind.value): curve for (x, kind), curve in found.curves().items()}
    zeta, omega_n = (x.symbol for x in found.free)
    points = [(x.at, end) for x in found.slices for end in x.requirement.ends]
    assert points
    for at, end in points:
        for b in end.bindings:
            curve = curves[b.part, b.kind.value].subs(zeta, at)
            sides = [curve.subs(omega_n, Rational(end.value.digits(25)) * (1 + Rational(i, 10**15))) for i in (-1, 1)]
            assert sides[0] * sides[1] < 0


@pytest.mark.slow
def test_figures_of_one_and_two_parameters_are_written(tmp_path: Path) -> None:

    hs.require(PAPER, "omega_n").save_figure(tmp_path / "one.svg")
    hs.design_map(PAPER, ["zeta", "omega_n"], [("0.1", "0.5"), (20, 200)], slices=3).save_figure(tmp_path / "two.png")
    assert (tmp_path / "one.svg").stat().st_size > 5000
    assert (tmp_path / "two.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(SceneError, match="svg"):
        hs.require(PAPER, "omega_n").save_figure(tmp_path / "one.docx")


def legend_of(ax: Any) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.slow
def test_a_map_shows_each_exact_slice_and_says_what_is_interpolated() -> None:
    found = hs.design_map(PAPER, ["omega_n", "zeta"], [(60, 200), ("0.1", 1)], slices=5)
    ax = Figure().add_subplot()
    strokes, *marks = draw_map(ax, found)
    exact = [
        [(float(x.at), float(end.value)) for end in (span.low, span.high)]
        for x in found.slices
        for span in x.requirement.feasible
    ]
    assert [[tuple(point) for point in line] for line in strokes.get_segments()] == exact
    [mark] = marks
    assert [*zip(*mark.get_data(), strict=True)] == [ends[1] for ends in exact]  # below, the range itself ends
    assert legend_of(ax) == [
        "transparent on the slice",
        "transparent, proven",
        "imaginary part, band-edge",
        "left open, holds the boundary",
        "exact slices",
    ]
    ax = Figure().add_subplot()
    draw_map(ax, replace(found, proofs=()))
    assert legend_of(ax)[1::2] == ["between slices: interpolated", "boundary between slices, estimated"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega_n$ (rad/s)", r"$\zeta$")


def test_a_map_with_nothing_feasible_says_so() -> None:
    found = hs.design_map(PAPER, ["omega_n", "zeta"], [(10, 20), ("0.1", 1)], slices=3)
    ax = Figure().add_subplot()
    draw_map(ax, found)
    assert [text.get_text() for text in ax.texts] == ["transparent nowhere: on none of 3 exact slices"]
    assert legend_of(ax) == ["exact slices"]


@pytest.mark.slow
def test_what_a_map_leaves_open_is_hatched_and_named() -> None:
    found = hs.design_map(PAPER, ["omega_n", "zeta"], [(60, 200), ("0.1", 1)], slices=3)
    first, second, third = found.slices
    gap = (ExactNumber(Rational(1, 2)), ExactNumber(Rational(3, 4)))
    opened = replace(second, requirement=replace(second.requirement, undecided=(gap,)))
    emptied = replace(third, requirement=replace(third.requirement, feasible=()))
    for slices, low, high, left, right in (
        ((first, opened, third), 0.5, 0.75, 95, 165),  # halfway to both neighbours
        ((first, second, emptied), 0.1, float(second.requirement.feasible[0].high.value), 130, 200),
    ):
        ax = Figure().add_subplot()
        draw_map(ax, replace(found, slices=slices, proofs=()))
        assert "undecided" in legend_of(ax)
        [hatched] = [x for x in ax.collections if x.get_hatch()]
        box = hatched.get_paths()[0].get_extents()
        assert (box.x0, box.x1, box.y0, box.y1) == pytest.approx((left, right, low, high))


@pytest.mark.slow
def test_two_requirements_and_two_maps_are_drawn_in_one_axes() -> None:
    ax = Figure().add_subplot()
    for b in (15, 30):
        lines = draw_requirement(ax, hs.require(PAPER.with_values({"b": b}), "omega_n"), label=f"b = {b}")
        assert [line.get_linestyle() for line in lines] == ["-", "--"]
    assert len(legend_of(ax)) == len(set(legend_of(ax)))
    assert {"real part, b = 15", "imaginary part, b = 30", "threshold"} <= set(legend_of(ax))
    assert len([patch for patch in ax.patches if patch.get_label().startswith("transparent")]) == 1
    ax = Figure().add_subplot()
    for m in (1, 3):
        scene = PAPER.with_values({"m": m})
        draw_map(ax, hs.design_map(scene, ["omega_n", "zeta"], [(60, 200), ("0.1", 1)], slices=3), label=f"m = {m}")
    assert len(legend_of(ax)) == len(set(legend_of(ax)))
    assert {"exact slices, m = 1", "exact slices, m = 3"} <= set(legend_of(ax))
    assert legend_of(ax).count("transparent, proven") == 1


@pytest.mark.parametrize("formula", ["1/(1 + s/w)", "w/(s + w)"])
def test_where_a_formula_is_divided_by_zero_the_curve_has_a_gap_and_only_there(formula: str) -> None:
    lag = hs.effects.series(formula, parameters={"w": 75})
    found = hs.require(hs.Scene(PAPER.environment, (lag,), (0, 15)), "w")
    lines = draw_requirement(Figure().add_subplot(), found)
    for line in lines:
        w, worst = (np.asarray(x, float) for x in line.get_data())
        assert (w == 0).any()
        assert [*np.isnan(worst)] == [*((w == 0) & (formula == "1/(1 + s/w)"))]


def test_a_range_in_hz_is_drawn_in_hz() -> None:
    ax = Figure().add_subplot()
    found = hs.require(PAPER, "omega_n", ("5 Hz", "50 Hz"))
    draw_requirement(ax, found)
    assert (ax.get_xlabel(), ax.get_xlim()) == (r"$\omega_n$ (Hz)", (5, 50))
    [dots] = [line for line in ax.lines if line.get_marker() == "o"]
    assert float(dots.get_xdata()[0]) == pytest.approx(float(found.feasible[0].low.value) / (2 * np.pi))


# --- the command line ------------------------------------------------------------------------------------------------


def call(*arguments: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> tuple[int, str, str]:
    monkeypatch.setattr("sys.argv", ["haptisym", "require", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    out, err = capsys.readouterr()
    return int(stop.value.code or 0), out, err


def test_the_contract_document(capsys, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    arguments = ("fu2019", "--free", "effects.filter.omega_n", "--json", "--digits", "40")
    status, out, err = call(*arguments, capsys=capsys, monkeypatch=monkeypatch)
    document = json.loads(out)
    assert (status, err) == (0, "")
    assert document["ends"][0][0].pop("enclosure")[0].startswith("122.35581477043092118744")
    assert document == {
        "schema": "haptisym.requirement/1",
        "title": "Numerical example of Fu, van Paassen and Mulder (2019)",
        "free": "effects.filter.omega_n",
        "unit": "rad/s",
        "range": [0.0, None],
        "band": [0.0, 15.0],
        "condition": ["real", "imag"],
        "criteria": ["transparent"],
        "feasible": [[122.35581477043092, None]],
        "ends": [[{"digits": "122.3558147704309211874431712767197563518", "closed": True}, None]],
        "binding": [
            {
                "at": 122.35581477043092,
                "part": "imag",
                "criterion": "transparent",
                "omega": 15.0,
                "kind": "band-edge",
                "closed_form": None,
            }
        ],
        "closed_form": None,
        "undecided": [],
        "certified": True,
    }


def test_the_page_says_the_value_what_binds_and_the_formula(capsys, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    status, out, _ = call("delayed-spring", "--free", "tau", capsys=capsys, monkeypatch=monkeypatch)
    assert status == 0
    assert "exactly for 0 ≤ τ ≤ 0.0066778 s" in out
    assert "r_i (imag)   the band's high end, 15 rad/s" in out
    assert "τ = asin(c)/ω_max" in out


WRONG = [
    (("fu2019", "--free", "effects.filter.omega"), "valid are environment.m, environment.b"),
    (("fu2019", "--free", "zeta", "--range", "1", "0"), "the range must go up"),
    (("fu2019", "--free", "zeta", "--range", "-2", "-1"), "must be >= 0"),
    (("fu2019", "--free", "zeta", "--range", "1 kg", "2 kg"), "is not a ratio"),
    (("fu2019", "--free", "zeta", "--part", "real", "--any-environment"), "no parts"),
    (("fu2019", "--free", "zeta", "--free", "omega_n"), "needs a --range for each"),
    (("fu2019", "--free", "zeta", "--free", "zeta", "--range", "0", "1", "--range", "0", "1"), "twice"),
    (("fu2019", "--free", "zeta", "--range", "0", "1", "--range", "0", "1"), "as often"),
    (("nowhere", "--free", "zeta"), "nowhere"),
]


@pytest.mark.parametrize(("arguments", "said"), WRONG)
def test_what_is_wrong_is_said_in_one_line(arguments, said, capsys, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*arguments, capsys=capsys, monkeypatch=monkeypatch)
    assert (status, out) == (2, "")
    assert said in err
    assert "Traceback" not in err


def test_undecided_values_are_status_3(tmp_path, capsys, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    held = tmp_path / "held.toml"
    held.write_text(
        '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 0\n[[effects]]\nmodel = "zero-order-hold"\nT = "1 ms"\n'
    )
    monkeypatch.setattr("haptisym.verbs.require.floatcells._MOST", 0)
    monkeypatch.setattr("haptisym.verbs.require.cells._MOST_CELLS", 2)
    arguments = (str(held), "--free", "T", "--range", "0", "1 ms")
    status, out, _ = call(*arguments, capsys=capsys, monkeypatch=monkeypatch)
    assert status == 3
    assert "UNDECIDED" in out
    assert "exactly" not in out


def test_what_one_part_breaks_is_settled_whatever_is_open_of_the_other() -> None:
    """A delay beside a hold: r_r of short delays is hard to enclose, but r_i alone is above its threshold."""
    wheel = hs.environments.mass_spring_damper("0.05 kg*m^2", "0.3 N*m*s/rad", "5 N*m/rad")
    held = (hs.effects.delay("8 ms"), hs.effects.zero_order_hold("2 ms"))
    scene = hs.Scene(wheel, held, ("0.1 Hz", "6 Hz"), hs.Threshold.of("0.12", "0.15"))
    found = hs.require(scene, "tau", ("5 ms", "40 ms"))
    assert (found.feasible, found.undecided) == ((), ())


def test_a_path_and_a_symbol_name_the_same_parameter() -> None:
    assert PAPER.knobs["omega_n"] == PAPER.knobs["effects.filter.omega_n"]


# --- bounds, operation by operation ----------------------------------------------------------------------------------

T = symbols("t", real=True)
FINE = mpmath.MPContext()
FINE.dps = 40


def condition(formula: Expr) -> RealFunction:
    """A function of omega and t that must not be positive."""
    return RealFunction(Ring([T]).axis.convert(sympify(formula)))


HELD = hs.Scene(environments.maxwell(2, 9), (effects.zero_order_hold("30 ms"),), (0, 2))
SLACK = environments.spring_pot(k_alpha=50, alpha="0.4", k=20)
TOLD = {
    "a delay": (LATE, "tau", (0.004, 0.0125)),
    "a hold": (HELD, "T", (0.02, 0.05)),
    "a hold beside a filter": (
        hs.Scene(SPRING, (effects.zero_order_hold("9 ms"), effects.second_order_lowpass(90, "0.7")), (0, 20)), "zeta", (0.3, 0.8),
    ),
    "a fractional power": (hs.Scene(SLACK, (effects.first_order_lag(200),), (0, 15)), "omega_c", (120, 250)),
    "an order": (hs.Scene(SLACK, (effects.first_order_lag(200),), (0, 15)), "environment.alpha", (0.3, 0.5)),
    "two delays": (
        hs.Scene(hs.environments.kelvin_voigt(90, 4), (effects.delay("6 ms"), effects.delay("9 ms")), (1, 30)),
        "effects.delay.tau", (0.002, 0.011),
    ),
    "a compensated device": (
        hs.Scene(SPRING, (effects.delay("5 ms"), effects.shunt(m=1)), ("1 Hz", "3 Hz")), "effects.shunt.m", (-2.0, 1.0),
    ),
}  # fmt: skip
"""Scenes with angles or powers, one parameter left open, and two values of it."""


class Form:
    """A condition times its half angles' cosines, term by term in mpmath at many digits."""

    def __init__(self, scene: hs.Scene, path: str) -> None:
        self.free = scene.knobs[path]
        found = conditions(scene, [self.free], noticed(scene.threshold))
        self.conditions = {x.part: f for x, f in found.items()}
        self.shapes = {part: Shape.of(f, self.free.symbol) for part, f in self.conditions.items()}

    @cache  # noqa: B019 - lives as long as a test
    def numbers(self, part: hs.Part, t: object) -> tuple[list[object], list[object], list[object]]:
        """What the symbols, half the rates and the orders are for a value of the parameter."""
        axis, names = self.shapes[part].axis, {self.free.symbol: t, pi: FINE.pi}

        def number(x: Expr) -> object:
            if x.is_Rational or x in names:
                return names[x] if x in names else FINE.mpf(int(x.p)) / int(x.q)
            found = [number(y) for y in x.args]
            return FINE.fsum(found) if x.is_Add else FINE.fprod(found) if x.is_Mul else found[0] ** found[1]

        own = [names.get(x, FINE.mpf(1)) for x in axis.meanings[1 : axis.size]]
        return own, [number(a.rate) / 2 for a in axis.angles], [number(x) for x in axis.orders]

    def __call__(self, part: hs.Part, omega: object, t: object) -> object:
        shape = self.shapes[part]
        own, rates, orders = self.numbers(part, t)
        halves = [x * (1 if a.constant else omega) for x, a in zip(rates, shape.axis.angles, strict=True)]
        values = [omega, *own, *(FINE.tan(x) for x in halves), *(omega**x for x in orders)]
        total = FINE.mpf(0)
        for exponents, c in shape.polynomial.to_dict().items():
            powers = (x ** int(n) for x, n in zip(values, exponents, strict=True) if n)
            total += FINE.fprod(powers) * int(c.p) / int(c.q)
        return total * FINE.fprod(FINE.cos(x) ** n for x, n in zip(halves, shape.degrees, strict=True))


def exactly(x: object) -> object:
    mantissa, exponent = x.man_exp()  # type: ignore[attr-defined]
    return FINE.mpf(int(mantissa)) * FINE.mpf(2) ** int(exponent)


def misses(ball: object, value: object) -> bool:
    """Whether a number lies outside of a ball, by more than the witness rounds."""
    middle, radius = exactly(ball.mid()), exactly(ball.rad())  # type: ignore[attr-defined]
    return abs(middle - value) > radius + FINE.mpf(10) ** -18 * (abs(value) + abs(middle)) + FINE.mpf(10) ** -28


def wide(low: float, high: float) -> object:
    return arb(low).union(arb(high))


def inside(low: float, high: float) -> list[object]:
    return [FINE.mpf(low) + (FINE.mpf(high) - FINE.mpf(low)) * x for x in (0, FINE.mpf("0.77"), 1)]


@pytest.mark.few("a delay", "a hold", "an order")
@pytest.mark.parametrize("name", TOLD)
def test_a_condition_over_balls_of_frequency_and_parameter_holds_all_its_values(name: str) -> None:
    scene, path, (low, high) = TOLD[name]
    form = Form(scene, path)
    start, end = (float(x) for x in scene.band)
    near = low + (high - low) / 1024
    with flint.ctx.workprec(BITS):
        for part, shape in form.shapes.items():
            for a, b in ((low, near), (low, high)):
                strip = Strip.of(shape, arb(a), arb(b))
                for x, y in ((start + (end - start) / 3, start + (end - start) / 3 + 0.01), (end * 0.5, end * 0.75)):
                    value, slope, bend = strip.over(wide(x, y))
                    at_left = strip.value(arb(x))
                    change = None if strip.change is None else strip.change.over(wide(x, y))[0]
                    for t in inside(a, b):
                        assert not misses(at_left, form(part, FINE.mpf(x), t))
                        for w in inside(x, y):
                            series = FINE.taylor(lambda v, t=t, part=part: form(part, v, t), w, 2)
                            assert not any(misses(*pair) for pair in zip((value, slope, bend), series, strict=True))
                            assert change is None or not misses(
                                change, FINE.diff(lambda v, w=w, part=part: form(part, w, v), t)
                            )
                if b == near:  # what is narrow is known well
                    size = max(abs(form(part, FINE.mpf(end) * k / 8, FINE.mpf(a))) for k in range(1, 8))
                    assert exactly(strip.value(arb(end * 0.5)).rad()) < size / 4
                    point = shape.over(arb(a)).value(arb(end * 0.5))
                    assert exactly(point.rad()) < size * FINE.mpf(10) ** -22
                    assert not misses(point, form(part, FINE.mpf(end * 0.5), FINE.mpf(a)))
            independent = (name, part) == ("a compensated device", IMAG)  # of a mass: what cancels in r_i
            assert (shape.change is None) == (name == "an order" or independent)


@pytest.mark.parametrize("name", TOLD)
def test_the_enclosure_of_a_mean_value_is_of_second_order(name: str) -> None:
    """An eighth of the width of a cell leaves about 1/64 of what the enclosure has too much."""
    scene, path, (low, _) = TOLD[name]
    form, (start, end) = Form(scene, path), (float(x) for x in scene.band)
    x = start + (end - start) * 0.71
    with flint.ctx.workprec(BITS):
        for part, shape in form.shapes.items():
            if shape.change is None:
                continue
            for kind in (0, 1):
                excess = []
                for width in (2**-6, 2**-9):
                    strip = Strip.of(shape, arb(low), arb(low * (1 + width)))
                    own = [form(part, FINE.mpf(x), t) for t in inside(low, low * (1 + width))]
                    ball = strip.over(wide(x, x + 1e-15))[0] if kind else strip.value(arb(x))
                    excess.append(2 * exactly(ball.rad()) - (max(own) - min(own)))
                    plain = ball < 0 or (ball > 0 and not kind)  # then nothing more is asked
                assert plain or excess[1] < excess[0] / 30 + FINE.mpf(10) ** -10 * max(map(abs, own))


@pytest.mark.parametrize("name", [x for x in TOLD if x != "an order"])
def test_a_condition_for_values_without_bound_holds_all_of_them(name: str) -> None:
    """Over an even power of the parameter, at least its degree; a delay without bound has any phase."""
    scene, path, (low, _) = TOLD[name]
    form = Form(scene, path)
    with flint.ctx.workprec(BITS):
        for part, shape in form.shapes.items():
            power = int(shape.polynomial.degrees()[shape.axis.meanings.index(form.free.symbol)])
            power += power % 2
            for sign in (1, -1) if name == "a compensated device" else (1,):
                strip = Strip.beyond(shape, arb(0).union(arb(sign) / low if low > 0 else arb(sign)))
                x = float(scene.band[1]) * 0.6
                value, slope, bend = strip.over(wide(x, x + 0.5))
                for t in (abs(FINE.mpf(low)) * n * sign for n in (1, 1.7, 40, 10**5)):
                    for w in inside(x, x + 0.5):
                        series = FINE.taylor(lambda v, t=t, part=part, n=power: form(part, v, t) / t**n, w, 2)
                        if name == "a delay" or name == "a hold" or "two" in name:
                            series = series[:1]  # of a phase no slope is known
                        assert not any(misses(*pair) for pair in zip((value, slope, bend), series, strict=False))
                assert strip.ends is None
                assert strip.middle is None
                assert strip.change is None


def test_values_from_zero_on_are_enclosed_where_powers_have_no_slope() -> None:
    for name in ("a fractional power", "an order"):
        scene, path, (low, high) = TOLD[name]
        form = Form(scene, path)
        with flint.ctx.workprec(BITS):
            for part, shape in form.shapes.items():
                for end, top in ((0.5, high), (1e-6, low * 1.0001)):
                    strip = Strip.of(shape, arb(low), arb(top))
                    value, slope, bend = strip.over(wide(0, end))
                    own = [
                        form(part, w, t) for t in inside(low, top) for w in (FINE.mpf(10) ** -30, *inside(0, end)[1:])
                    ]
                    assert not any(misses(value, x) for x in own)
                    assert not slope.is_finite()
                    assert not bend.is_finite()
                    if end < 0.1:
                        assert exactly(value.rad()) < max(map(abs, own)) / 2


def test_what_every_term_vanishes_with_at_zero_is_divided_out_there() -> None:
    scene, path, (low, high) = TOLD["a hold"]
    form = Form(scene, path)
    with flint.ctx.workprec(BITS):
        for part, shape in form.shapes.items():
            k = shape.order_at_zero
            assert k == 2
            for a, b, end in ((low, high, 0.5), (low, low * 1.001, 0.01)):
                strip = Strip.of(shape, arb(a), arb(b))
                value, slope, bend = strip.over(wide(0, end))
                own = [form(part, w, t) / w**k for t in inside(a, b) for w in (FINE.mpf(10) ** -9, *inside(0, end)[1:])]
                assert not any(misses(value, x) for x in own)
                assert not bend.is_finite()
                middle = (a + b) / 2
                rows = [form(part, w, middle) / w**k for w in inside(0, end)[1:]]
                way = 1 if slope > 0 else -1 if slope < 0 else 0  # that of what is left
                assert not way or all(way * (y - x) > 0 for x, y in pairwise(rows))
                if b < low * 1.01:
                    assert exactly(value.rad()) < max(map(abs, own))
    assert Form(*TOLD["a delay"][:2]).shapes[IMAG].order_at_zero == 0


# --- where a condition can bind --------------------------------------------------------------------------------------

BAND = (Integer(0), Integer(15))


def strip_of(formula: Expr, low: float, high: float) -> Strip:
    return Strip.of(Shape.of(condition(formula), T), arb(low), arb(high))


def alone(formula: Expr, low: float, high: float) -> Strips:
    return Strips((strip_of(formula, low, high),))


def kinds(formula: Expr, low: float, high: float, band: tuple[Expr, Expr] = BAND) -> object:
    with flint.ctx.workprec(BITS):
        found = places(alone(formula, low, high), band)
        return found if isinstance(found, CellVerdict) else [x.kind.value for x in found]


PEAK = 1 / (1 + (OMEGA**2 - 49) ** 2 / 400)
BINDS = [
    (OMEGA**2 / 45 - T, 4.9, 5.1, ["band-edge"]),  # rises to 5 at the high end
    (5 - OMEGA**2 / 45 - T, 4.9, 5.1, ["start"]),  # falls from 5 at 0, where the slope is 0
    (5 * PEAK - T, 4.9, 5.1, ["tangency"]),
    (5 * PEAK - T, 5.1, 5.2, []),
    (5 * PEAK - T, 4.0, 4.5, CellVerdict.BROKEN),
    (5 * PEAK - T, 4.0, 6.0, ["tangency"]),  # one maximum of 5, whatever T
    (OMEGA**2 / 45 - T, 5.01, 9, []),
    (OMEGA**2 / 45 - T, -1, 4.5, CellVerdict.BROKEN),
    (Integer(5) - T, 4, 4.9, CellVerdict.BROKEN),
    (T - 5, 4, 4.9, []),
    (T - 5, 4, 6, CellVerdict.OPEN),
    ((OMEGA**2 - 100) ** 2 / 2000 - T, 4.97, 5.05, ["start"]),  # 5 at 0, 7.8 at 15, unless the band ends before
    (OMEGA**2 * (225 - OMEGA**2) ** 2 / 338000 - T, 4.95, 5.05, ["tangency"]),  # largest at 15/sqrt 3: 4.993
]


@pytest.mark.parametrize(("formula", "low", "high", "expected"), BINDS)
def test_a_condition_binds_at_an_edge_or_a_maximum_or_nowhere(
    formula: Expr, low: float, high: float, expected: object
) -> None:
    band = (Integer(0), Integer(14)) if formula.has((OMEGA**2 - 100) ** 2) else BAND
    assert kinds(formula, low, high, band) == expected


def test_a_band_that_starts_above_zero_has_its_start_there() -> None:
    with flint.ctx.workprec(BITS):
        strip = strip_of(5 - OMEGA**2 / 45 - T, 4.85, 5.0)
        [place] = places(Strips((strip,)), (Integer(2), Integer(15)))
        assert (place.kind, place.omega) == (Kind.START, 2)
        assert float(strip.crossing(place)) == pytest.approx(5 - 4 / 45, rel=1e-15)
        [edge] = places(alone(OMEGA**2 / 45 - T, 4.9, 5.1), (Integer(2), Integer(15)))
        assert (edge.kind, edge.omega) == (Kind.EDGE, 15)


def test_a_maximum_is_known_to_many_digits_with_the_value_at_which_it_touches() -> None:
    formula = OMEGA**2 * (225 - OMEGA**2) ** 2 / 338000 - T
    with flint.ctx.workprec(BITS):
        strip = strip_of(formula, 4.95, 5.05)
        [place] = places(Strips((strip,)), BAND)
        assert strip.signs(place) == (1, -1)
        value = strip.crossing(place)
    exact = Rational(75 * 150**2, 338000)
    assert value.digits(40) == ExactNumber(exact).digits(40)
    assert MaximumAt(value).digits(40) == ExactNumber(sqrt(75)).digits(40)
    a, b = value.bounds(60)
    assert a <= Fraction(int(exact.p), int(exact.q)) <= b


def test_signs_are_told_only_where_the_condition_changes_one_way_with_the_parameter() -> None:
    place = CriticalPlace(Kind.EDGE, arb(14), arb(15), Integer(15))
    top = CriticalPlace(Kind.TOUCH, arb(6.5), arb(7.5))
    with flint.ctx.workprec(BITS):
        for at in (place, top):
            rising, falling = (T - 3 + PEAK - PEAK.subs(OMEGA, 15), 3 - T + PEAK - PEAK.subs(OMEGA, 15))
            if at is top:
                rising, falling = T - 4 + PEAK, 2 - T + PEAK
            assert strip_of(rising, 2, 4).signs(at) == (-1, 1)
            assert strip_of(falling, 2, 4).signs(at) == (1, -1)
            assert strip_of(rising, 3.5, 4).signs(at) == (1, 1)
            assert strip_of(rising, 2, 2.5).signs(at) == (-1, -1)
            assert strip_of(rising, 3, 4).signs(at) is None  # zero at an end
            assert strip_of((T - 3) ** 2 - 1, 1.5, 4.5).signs(at) is None  # there and back
        turning = T * (OMEGA**2 - 49) / 10_000 - 1 + PEAK  # at the maximum what changes with the parameter turns round
        assert strip_of(turning, 2, 4).signs(top) is None
        assert strip_of(turning, -1, 1).signs(top) is None
        for pivot, signs in ((45, (1, 1)), (55, (-1, -1))):  # beside it it does not
            beside = T * (OMEGA**2 - pivot) / 10_000 - 1 + PEAK
            assert strip_of(beside, 2, 4).signs(top) == signs
            assert strip_of(beside, -2, 2).signs(top) == (-signs[0], signs[0])
            assert strip_of(beside - 5, 2, 4).signs(top) == (-1, -1)  # far below, or above, whatever changes
            assert strip_of(beside + 5, 2, 4).signs(top) == (1, 1)
            assert strip_of(beside - 5, 2, 4).signs(replace(top, low=arb(6), high=arb(8))) == (-1, -1)
        assert Strip.beyond(Shape.of(condition(T - 3), T), wide(0, 1)).signs(place) is None


def test_a_maximum_far_below_its_threshold_keeps_no_cell_open() -> None:
    """r_r is 0.027 at 20 rad/s, whichever way it goes with zeta; the end lies where r_i is 0.1 at the band's high end."""
    tool = hs.load_scene("two-mass-resonance")
    free = tool.knobs["effects.drive.zeta"]
    search = ValueSearch(conditions(tool, [free], noticed(tool.threshold)), free.symbol, tool.band, Fraction(3, 5))
    below, at = (search._judged(*map(Fraction, ends)) for ends in ((0.17328125, 0.173359375), (0.173359375, 0.1734375)))
    assert below.verdict is CellVerdict.KEPT
    assert (at.verdict, at.above) == (CellVerdict.KEPT, CellVerdict.BROKEN)
    assert at.value is not None
    for zeta, crossed in (("0.1734033", 0), ("0.1734034", 1)):
        assert float(at.value) == pytest.approx(float(zeta), abs=1e-7)
        assert len(hs.evaluate(tool.with_values({free.path: zeta})).crossings) == crossed


def boxes(*rows: tuple[float, float, int, int]) -> list[_Box]:
    return [_Box(arb(a), arb(b), slope, bend) for a, b, slope, bend in rows]


def placed(cluster: list[_Box], formula: Expr = -((OMEGA**2 - 49) ** 2) - T, low: float = 0) -> object:
    """Where a function that is largest at 7 can bind on some pieces of the band."""
    with flint.ctx.workprec(BITS):
        found = _place(strip_of(formula, 0.1, 0.2), cluster, arb(low), arb(15), (Integer(int(low)), Integer(15)))
        return found if isinstance(found, CellVerdict) else (found.kind.value, float(found.low), float(found.high))


def test_what_is_known_of_slopes_and_curvatures_tells_where_a_piece_can_bind() -> None:
    assert placed(boxes((6, 7, 0, -1), (7, 8, 0, -1))) == ("tangency", 6, 8)
    assert placed(boxes((6, 7, 0, -1), (7, 8, 0, 0))) is CellVerdict.OPEN
    assert (
        placed(boxes((6, 6.5, 0, -1), (6.5, 6.75, 0, -1))) is CellVerdict.KEPT
    )  # rises up to what is known to be kept
    assert placed(boxes((7.5, 8, 0, -1), (8, 9, 0, -1))) is CellVerdict.KEPT
    assert placed(boxes((14, 14.5, 1, 0), (14.5, 15, 1, 0))) == ("band-edge", 14, 15)
    assert placed(boxes((14, 14.5, 1, 0), (14.5, 14.75, 1, 0))) is CellVerdict.KEPT
    assert placed(boxes((14, 14.5, 1, 0), (14.5, 15, 0, 0))) is CellVerdict.OPEN
    assert placed(boxes((14, 14.5, 0, 0), (14.5, 15, 1, -1))) is CellVerdict.OPEN
    assert placed(boxes((14, 15, 0, -1)), formula=OMEGA**2 - T) == ("band-edge", 14, 15)
    assert placed(boxes((14, 15, 0, 1)), formula=OMEGA**2 - T) is CellVerdict.OPEN
    assert placed(boxes((2, 3, -1, 0), (3, 4, -1, 0)), low=2) == ("start", 2, 4)
    assert placed(boxes((2.5, 3, -1, 0), (3, 4, -1, 0)), low=2) is CellVerdict.KEPT
    assert placed(boxes((2, 3, -1, 0), (3, 4, 0, 0)), low=2) is CellVerdict.OPEN
    assert placed(boxes((2, 3, 0, -1)), formula=-(OMEGA**2) - T, low=2) == ("start", 2, 3)
    assert placed(boxes((2, 3, 0, 1)), formula=-(OMEGA**2) - T, low=2) is CellVerdict.OPEN
    assert placed(boxes((0, 1, 0, -1)), formula=-(OMEGA**4) - T) == ("start", 0, 1)  # even: the slope at 0 is 0
    assert placed(boxes((0, 1, 0, 0)), formula=-(OMEGA**4) - T) is CellVerdict.OPEN
    rows = boxes((1, 2, 0, 0), (2, 3, 0, 0), (4, 5, 0, 0), (5, 6, 0, 0))
    assert [[float(x.low) for x in own] for own in _clusters(rows)] == [[1, 2], [4, 5]]


# --- cells -----------------------------------------------------------------------------------------------------------


def told(leaves: list[Leaf], value: float) -> CellVerdict | None:
    """What leaves say of a value; None at an end."""
    for x in leaves:
        if (x.low is None or x.low <= value) and (x.high is None or value <= x.high):
            if x.above is None:
                return x.verdict
            return x.verdict if value < float(x.value) else x.above if value > float(x.value) else None
    raise AssertionError(value)


SETS = [
    (OMEGA**2 / 45 - T, lambda t: t >= 5, [5.0]),
    (5 * PEAK + T, lambda t: t <= -5, [-5.0]),  # negative values
    (5 * PEAK - T**2, lambda t: abs(t) >= 5**0.5, [-(5**0.5), 5**0.5]),
    ((T - 3) * (T - 7) + OMEGA**2 / 100 - Rational(9, 4), lambda t: 3 <= t <= 7, [3.0, 7.0]),
    ((T + 3) * (T + 7) + OMEGA**2 / 100 - Rational(9, 4), lambda t: -7 <= t <= -3, [-7.0, -3.0]),
    (PEAK - 2, lambda _: True, []),
]
RANGES = [(None, None), (-9, 12), (Fraction(1, 8), None), (None, Fraction(-1, 8))]


@pytest.mark.few("5-formula5-<lambda>-ends5")
@pytest.mark.parametrize(("number", "formula", "kept", "ends"), [(i, *x) for i, x in enumerate(SETS)])
def test_cells_cover_the_values_and_end_where_the_set_does(
    number: int, formula: Expr, kept: Callable[[float], bool], ends: list[float]
) -> None:
    for low, high in (RANGES[0], RANGES[1 + number % 3]):
        a, b = (None if x is None else Fraction(x) for x in (low, high))
        leaves = ValueSearch({JND[REAL]: condition(formula)}, T, BAND, Fraction(2)).leaves(a, b)
        assert (leaves[0].low, leaves[-1].high) == (a, b)
        assert all(x.high == y.low for x, y in pairwise(leaves))
        inside = [x for x in ends if (a is None or x > a) and (b is None or x < b)]
        assert [float(x.value) for x in leaves if x.above] == pytest.approx(inside, rel=1e-14)
        values = [s * 10**x for s in (-1, 1) for x in np.linspace(-2, 5, 40)]
        values += [x * f for x in ends for f in (0.999999, 1.000001)]
        for value in (Fraction(float(x)) for x in values):
            if (a is None or value >= a) and (b is None or value <= b):
                verdict = told(leaves, value)
                if verdict is CellVerdict.OPEN:  # far out, where an odd power has both signs
                    assert abs(value) > 4000
                    assert degree(formula.as_numer_denom()[0], T) % 2
                else:
                    assert verdict is (CellVerdict.KEPT if kept(float(value)) else CellVerdict.BROKEN)


@pytest.mark.slow
def test_a_cell_in_which_two_conditions_end_is_cut_and_one_broken_condition_breaks() -> None:
    both = {JND[REAL]: condition(T - 5 - OMEGA**2 / 10**6), JND[IMAG]: condition(T - 5 - Rational(1, 10**4))}
    leaves = ValueSearch(both, T, BAND, Fraction(1)).leaves(Fraction(4), Fraction(6))
    [end] = [x for x in leaves if x.above]
    assert (float(end.value), end.verdict, end.above) == (5, CellVerdict.KEPT, CellVerdict.BROKEN)
    assert (end.binding.part, end.binding.kind) == (REAL, Kind.START)
    assert [told(leaves, Fraction(x)) for x in (4.5, 5.00005, 5.5)] == [
        CellVerdict.KEPT,
        CellVerdict.BROKEN,
        CellVerdict.BROKEN,
    ]
    hard = {
        JND[REAL]: condition(T - 5),
        JND[IMAG]: condition((T - 5) ** 2 - OMEGA**2),
    }  # the second is open on one part of the band
    assert (
        told(ValueSearch(hard, T, BAND, Fraction(1)).leaves(Fraction(4), Fraction(8)), Fraction(7))
        is CellVerdict.BROKEN
    )


def test_binding_places_are_told_with_their_frequency() -> None:
    found = ValueSearch({JND[IMAG]: condition(5 * PEAK - T)}, T, BAND, Fraction(1)).leaves(Fraction(1), Fraction(9))
    [end] = [x for x in found if x.above]
    assert (end.binding.part, end.binding.kind, end.binding.omega.digits(20)) == (
        IMAG,
        Kind.TOUCH,
        "7.0000000000000000000",
    )
    found = ValueSearch({JND[IMAG]: condition(OMEGA**2 / 45 - T)}, T, BAND, Fraction(1)).leaves(
        Fraction(1), Fraction(9)
    )
    [end] = [x for x in found if x.above]
    assert (end.binding.kind, end.binding.omega.value) == (Kind.EDGE, 15)


def test_the_middle_of_a_cell_lies_inside_and_of_a_long_one_near_its_geometric_mean() -> None:
    random = Random(3)
    for _ in range(300):
        a = Fraction(random.choice((1, -1)) * 10 ** random.uniform(-6, 6))
        b = a + abs(a) * Fraction(10 ** random.uniform(-12, 4))
        cut = _middle(a, b)
        assert a < cut < b
        assert cut.denominator & (cut.denominator - 1) == 0  # dyadic
        assert _middle(-b, -a) == pytest.approx(float(-cut), rel=2e-2, abs=float(b - a) / 50)
        if a * b > 0 and max(b / a, a / b) > 4:
            assert float(abs(cut)) == pytest.approx(float(a * b) ** 0.5, rel=1e-12)
        else:
            assert (cut - a) / (b - a) == pytest.approx(0.497, abs=0.01)
    assert [float(_middle(Fraction(x), Fraction(y))) for x, y in ((0, 16), (-16, 0))] == [1, -1]
    assert float(_middle(Fraction(1), Fraction(4))) == 1 + 3 * 0.4970703125
    assert float(_middle(Fraction(-4), Fraction(-1))) == -4 + 3 * 0.4970703125
    tiny = Fraction(1) + Fraction(1, 2**60)  # of no width as floats
    assert 1 < _middle(Fraction(1), tiny) < tiny


def test_a_long_delay_breaks_a_condition_as_soon_as_a_piece_of_the_band_holds_all_its_phases() -> None:
    """r_i = |sin(omega tau)| at a quarter turn is 1 all over the band of 15 rad/s: it holds all phases from 2 pi/15 s on."""
    form = Form(LATE, "tau")
    bound = _bound_by_phase([form.conditions[IMAG]], form.free.symbol, LATE.band)
    assert float(bound) == pytest.approx(2 * np.pi / 15 / 0.99, rel=1e-12)
    wide_band = LATE.with_band(5, 45)
    bound = _bound_by_phase([Form(wide_band, "tau").conditions[IMAG]], form.free.symbol, wide_band.band)
    assert float(bound) == pytest.approx(2 * np.pi / 40 / 0.99, rel=1e-12)
    assert _bound_by_phase([Form(*TOLD["a hold beside a filter"][:2]).conditions[IMAG]], symbols("zeta"), BAND) is None
    loose = Form(hs.Scene(SPRING, (effects.delay("5 ms"),), (0, 15), hs.Threshold.of(3, 3)), "tau")
    assert _bound_by_phase([loose.conditions[IMAG]], form.free.symbol, BAND) is None


def test_a_delay_is_tried_at_several_phases() -> None:
    """r_r = 1 - cos(omega tau) is above 1.5 about half a turn, not at a quarter of one."""
    late = hs.Scene(SPRING, (effects.delay("5 ms"),), (0, 15), hs.Threshold.of("1.5", 3))
    form = Form(late, "tau")
    bound = _bound_by_phase([form.conditions[REAL]], form.free.symbol, late.band)
    assert float(bound) == pytest.approx(2 * np.pi / 15 / 0.99, rel=1e-12)


def test_the_width_of_a_cell_is_relative_to_its_larger_end_on_either_side_of_zero() -> None:
    form = Form(LATE, "tau")
    search = ValueSearch(form.conditions, form.free.symbol, LATE.band, Fraction(2))
    for low, high, width in ((4, 8, "1/2"), (-8, -4, "1/2"), (-8, 4, "3/2"), (-4, 8, "3/2"), ("-1/1000", "1/1000", 1)):
        assert search._width(Fraction(low), Fraction(high)) == Fraction(width)


def test_sines_and_cosines_of_an_unknown_half_angle_are_between_their_least_and_largest_products() -> None:
    for power in (0, 2, 4):
        for k in range(power + 1):
            found = _wave(None, k, power)
            for angle in np.linspace(0, np.pi, 25):
                value = np.sin(angle) ** k * np.cos(angle) ** (power - k)
                assert float(found.lower()) - 1e-15 <= value <= float(found.upper()) + 1e-15
            assert float(found.upper()) == pytest.approx(1)
            assert float(found.lower()) == pytest.approx(1 if power == 0 else 0 if k % 2 == 0 else -1, abs=1e-8)
    with flint.ctx.workprec(BITS):
        known = _wave(arb("0.3"), 1, 4)
    assert float(known) == pytest.approx(np.sin(0.3) * np.cos(0.3) ** 3, rel=1e-14)


# --- lines of values -------------------------------------------------------------------------------------------------

KEPT, BROKEN, OPEN = CellVerdict.KEPT, CellVerdict.BROKEN, CellVerdict.OPEN


def line(*rows: object, low: object = 0, high: object = 8, closed: tuple[bool, bool] = (True, True), allowed=None):  # type: ignore[no-untyped-def]
    leaves = [Leaf(*(None if x is None else Fraction(x) for x in row[:2]), *row[2:]) for row in rows]  # type: ignore[index]
    ends = [None if x is None else Rational(x) for x in (low, high)]
    return ValueLine(leaves, Domain(*ends, *closed), allowed or (lambda _: True))


def shown(spans: object) -> list[tuple[object, ...]]:
    ends = [(x.low, x.high) for x in spans]  # type: ignore[attr-defined]
    return [(*(None if e.value is None else float(e.value) for e in (a, b)), a.closed, b.closed) for a, b in ends]


def test_leaves_of_one_verdict_join_and_ends_belong_to_the_set() -> None:
    three = ExactNumber(Integer(3))
    own = line((0, 1, BROKEN), (1, 2, BROKEN), (2, 4, BROKEN, KEPT, three), (4, 5, KEPT), (5, 8, KEPT))
    assert shown(own.spans()) == [(3, 8, True, True)]
    assert own.undecided == ()
    assert shown(line((0, 8, KEPT)).spans()) == [(0, 8, True, True)]
    assert shown(line((0, 8, KEPT), closed=(False, True)).spans()) == [(0, 8, False, True)]
    assert shown(line((0, 8, KEPT), closed=(True, False)).spans()) == [(0, 8, True, False)]
    assert shown(line((0, 8, KEPT), allowed=lambda x: x != 0).spans()) == [(0, 8, False, True)]
    assert shown(line((0, 8, KEPT), allowed=lambda x: x != 8).spans()) == [(0, 8, True, False)]
    assert shown(line((0, 8, BROKEN)).spans()) == []
    unbounded = line(
        (None, -1, KEPT), (-1, 1, KEPT, BROKEN, ExactNumber(Integer(0))), (1, None, BROKEN), low=None, high=None
    )
    assert shown(unbounded.spans()) == [(None, 0, False, True)]
    two = line((0, 2, KEPT, BROKEN, ExactNumber(Integer(1))), (2, 4, BROKEN, KEPT, three), (4, None, KEPT), high=None)
    assert shown(two.spans()) == [(0, 1, True, True), (3, None, True, False)]


def test_a_narrow_open_leaf_between_two_verdicts_is_an_end_and_a_wide_one_is_undecided() -> None:
    thin, wider = Fraction(1, 10**10), Fraction(1, 10**7)
    for sign in (1, -1):
        for width, known in ((thin, True), (wider, False)):
            a, b = sorted((Fraction(3 * sign), (3 + width) * sign))
            own = line((-9, a, BROKEN), (a, b, OPEN), (b, 9, KEPT), low=-9, high=9)
            assert (own.undecided == ()) is known
            [span] = own.spans()
            assert isinstance(span.low.value, Sliver) is known
            if known:
                assert (span.low.value.low, span.low.value.high) == (a, b)
            else:
                assert [tuple(float(x) for x in pair) for pair in own.undecided] == [(float(a), float(b))]
                assert float(span.low.value) == float(b)
    same = line((0, 3, KEPT), (3, 3 + thin, OPEN), (3 + thin, 8, KEPT))
    assert len(same.undecided) == 1
    first = line((0, thin, OPEN), (thin, 8, KEPT))
    assert [[float(x) for x in pair] for pair in first.undecided] == [[0, float(thin)]]
    last = line((0, 5, KEPT), (5, None, OPEN), high=None)
    assert [[float(last.undecided[0][0]), last.undecided[0][1]]] == [[5, None]]
    after = line((0, 2, BROKEN, KEPT, ExactNumber(Integer(1))), (2, 2 + thin, OPEN), (2 + thin, 8, BROKEN))
    assert after.undecided == ()
    assert shown(after.spans())[0][0] == 1


# --- exact sets, against values one by one ---------------------------------------------------------------------------


def solved(formula: Expr, domain: Domain = Domain(None, None), band: tuple[Expr, Expr] = BAND, allowed=lambda _: True):  # type: ignore[no-untyped-def]  # noqa: B008
    formulas = formula if isinstance(formula, dict) else {REAL: formula}
    found = Problem({JND[part]: condition(f) for part, f in formulas.items()}, T, band, domain, allowed).solve()
    assert found.undecided == ()
    return found.feasible


@pytest.mark.slow
def test_random_polynomial_conditions_hold_at_each_value_that_they_are_said_to() -> None:
    """Against the largest value over the band, by the roots of the slope in floats."""
    random = Random(11)
    count = 0
    for _ in range(60):
        rows = [[random.randint(-4, 4) for _ in range(random.randint(1, 4))] for _ in range(random.randint(1, 4))]
        formula = sum(c * T**j * OMEGA ** (2 * i) / 40**i for i, row in enumerate(rows) for j, c in enumerate(row))
        band = (Integer(random.choice((0, 2))), Integer(random.choice((6, 15))))
        spans = solved(formula, band=band) if formula != 0 else ()
        limits = [[None if e.value is None else float(e.value) for e in (x.low, x.high)] for x in spans]
        ends = [x for pair in limits for x in pair if x is not None]
        for value in [random.uniform(-6, 6) for _ in range(8)] + [x + d for x in ends for d in (-1e-4, 1e-4)]:
            p = np.polynomial.Polynomial(
                [sum(c * value**j for j, c in enumerate(row)) / 40**i for i, row in enumerate(rows)]
            )
            tops = [x.real for x in p.deriv().roots() if abs(x.imag) < 1e-9] if p.degree() > 1 else []
            w = [float(x) ** 2 for x in band] + [x for x in tops if float(band[0]) ** 2 < x < float(band[1]) ** 2]
            top = max(p(x) for x in w)
            if formula != 0 and abs(top) > 1e-7 * max(1, *(abs(c) for c in p.coef)):
                count += 1
                assert any((a is None or a <= value) and (b is None or value <= b) for a, b in limits) is bool(top < 0)
    assert count > 500


CLOSED, BARE = (True, True), (False, False)


def test_a_span_is_told_from_its_ends() -> None:
    a, b = (End(ExactNumber(Rational(x)), closed=True) for x in ("7/2", "122"))
    unbounded = End(None)
    told = [spanned(Span(*x)) for x in ((unbounded, unbounded), (unbounded, a), (b, unbounded), (a, b), (a, a))]
    assert told == ["any", "up to 3.50000", "from 122.000 on", "3.50000 to 122.000", "3.50000"]


def test_a_domain_cuts_the_set_and_its_ends_belong_as_they_are_told_to() -> None:
    inner = T * (T - 4)  # kept from 0 to 4
    for ends, expected in (
        ((1, 3, *CLOSED), [(1, 3, True, True)]), ((1, 3, *BARE), [(1, 3, False, False)]),
        ((1, 3, True, False), [(1, 3, True, False)]), ((1, 3, False, True), [(1, 3, False, True)]),
        ((0, 4, *BARE), [(0, 4, False, False)]), ((0, 4, *CLOSED), [(0, 4, True, True)]),
        ((-1, 5, *BARE), [(0, 4, True, True)]), ((4, 9, *CLOSED), [(4, 4, True, True)]), ((4, 9, *BARE), []),
        ((5, 9, *CLOSED), []), ((-9, 0, *CLOSED), [(0, 0, True, True)]), ((-9, 0, *BARE), []),
    ):  # fmt: skip
        assert shown(solved(inner, Domain(Integer(ends[0]), Integer(ends[1]), *ends[2:]))) == expected
    assert shown(solved(inner, Domain(None, Integer(2)))) == [(0, 2, True, True)]
    assert shown(solved(inner, Domain(Integer(2), None))) == [(2, 4, True, True)]
    assert shown(solved(-inner)) == [(None, 0, False, True), (4, None, True, False)]
    assert shown(solved(-inner, Domain(Integer(1), None))) == [(4, None, True, False)]
    assert shown(solved(inner, Domain(Integer(0), Integer(9)), allowed=lambda x: x != 0)) == [(0, 4, False, True)]
    negative = solved((T + 3) * (T + 2) * (T**2 - 2), Domain(Integer(-9), Integer(0)))
    assert shown(negative) == [(-3, -2, True, True), (-(2**0.5), 0, True, True)]


def test_what_binds_is_told_with_part_kind_and_frequency() -> None:
    both = {REAL: OMEGA**2 / 45 - T, IMAG: 5 - OMEGA**2 / 100 - T}  # both bind at 5: at the high end and at the low one
    [span] = solved(both)
    told = {(b.part, b.kind, float(b.omega)) for b in span.low.bindings}
    assert told == {(REAL, Kind.EDGE, 15.0), (IMAG, Kind.START, 0.0)}
    [span] = solved({REAL: OMEGA**2 / 45 - T, IMAG: 4 - OMEGA**2 / 100 - T})
    assert [(b.part, b.kind) for b in span.low.bindings] == [(REAL, Kind.EDGE)]
    quartic = 5 - (OMEGA**2 - 49) ** 2 / 100 - T  # 5 at 7
    [span] = solved(quartic)
    assert [(b.part, b.kind, b.omega.digits(12)) for b in span.low.bindings] == [(REAL, Kind.TOUCH, "7.00000000000")]
    [span] = solved(5 - (OMEGA**2 - 49) ** 2 * (OMEGA**2 - 121) ** 2 / 10**5 - T)
    assert [b.omega.digits(6) for b in span.low.bindings] == ["7.00000", "11.0000"]
    [span] = solved(quartic, Domain(Integer(6), Integer(8)))
    assert (span.low.bindings, span.high.bindings) == ((), ())
    [span] = solved(-quartic - 10, band=(Integer(5), Integer(10)))  # deepest at 7; at 5 and 10 5.76 and 26.01 below
    assert [(b.kind, float(b.omega)) for b in span.high.bindings] == [(Kind.EDGE, 10.0)]


def test_single_values_algebraic_ones_too_are_in_the_set_or_left_out_as_an_exact_test_tells() -> None:
    """(t^3 - 2)^2 is 0 at one real value alone."""
    touch = (T**3 - 2) ** 2
    assert shown(solved(touch)) == [(2 ** (1 / 3), 2 ** (1 / 3), True, True)]
    assert shown(solved(-touch)) == [(None, None, False, False)]
    assert shown(solved((T**3 + 2) ** 2)) == [(-(2 ** (1 / 3)), -(2 ** (1 / 3)), True, True)]
    alone = solved(touch * (1 + OMEGA**2) + (OMEGA**2 - 49) ** 2 * (T**3 - 2) ** 2)
    assert [x.low.value.digits(10) for x in alone] == ["1.259921050"]
    assert solved(touch + Rational(1, 2)) == ()
    only_at_one_frequency = (
        touch * OMEGA**2 + OMEGA**2 * (225 - OMEGA**2) / 10**4
    )  # broken inside the band at that value
    assert solved(only_at_one_frequency) == ()
    rational = shown(solved((2 * T - 3) ** 2 * (1 + OMEGA**2)))
    assert rational == [(1.5, 1.5, True, True)]
    crossed = solved((T**2 - 2) ** 2 * (OMEGA**2 - 49))  # negative below 7, positive above, but for t^2 = 2
    assert [x.low.value.digits(8) for x in crossed] == ["-1.4142136", "1.4142136"]


def test_a_part_that_is_broken_at_an_algebraic_value_leaves_it_out_though_the_other_part_is_kept_there_alone() -> None:
    """Beside t^3 = 2 the real part is broken first, so that nothing near tells of the imaginary part at that value."""
    at_one_value = (T**3 - 2) ** 2
    assert solved({REAL: at_one_value, IMAG: OMEGA**2 - 49}) == ()
    assert solved({REAL: at_one_value, IMAG: at_one_value + OMEGA**2 - 49}) == ()
    assert len(solved({REAL: at_one_value, IMAG: OMEGA**2 - 225})) == 1


def test_two_factors_that_meet_inside_the_band_do_so_at_single_values() -> None:
    """-(w^2 - a)(w^2 - b) is positive between a and b alone: kept where they are one, or both beyond the band."""
    even = -(OMEGA**2 - T - 5) * (OMEGA**2 - 15 + T)
    assert shown(solved(even, band=(Integer(1), Integer(6)))) == [(5, 5, True, True)]
    odd = -(OMEGA - T) * (OMEGA + T) * (OMEGA**2 + 2 * T - 8)  # squares meet at t = 2 and t = -4
    spans = shown(solved(odd, band=(Integer(1), Integer(5))))
    assert spans == [(None, -8.5, False, True), (-4, -4, True, True), (2, 2, True, True)]
    places = [x.low.bindings for x in solved(odd, band=(Integer(1), Integer(5)))[1:]]
    assert [[(b.kind, b.omega and float(b.omega)) for b in x] for x in places] == [
        [(Kind.TOUCH, 4.0)],
        [(Kind.TOUCH, 2.0)],
    ]


def test_a_resonance_that_cancels_at_one_value_is_transparent_there_alone() -> None:
    """r_r = |(49 - w^2)/(g^2 - w^2)|/20: of both signs of the pole the crossings lie on one side of 7 rad/s."""
    almost = effects.series("1 + (s^2 + 49)/(20*(s^2 + g^2))", parameters={"g": 8})
    spans = hs.require(hs.Scene(SPRING, (almost,), (0, 15)), "g", (0, 100)).feasible
    assert [s.low.value.digits(9) for s in spans] == [
        "7.00000000",
        "17.6918060",
    ]  # from sqrt(313) on the pole is far enough
    assert spans[0].high.value.value == 7
    [b] = spans[0].low.bindings
    assert (b.part, b.kind, b.omega.digits(12)) == (REAL, Kind.TOUCH, "7.00000000000")


def test_pi_may_stand_in_band_and_condition() -> None:
    [span] = solved(OMEGA**2 - T, band=(Integer(0), 2 * pi))
    assert span.low.value.digits(20) == ExactNumber(4 * pi**2).digits(20)
    [span] = solved(T**3 + OMEGA**2 - 100, band=(pi / 7, 2 * pi))
    with mpmath.workdps(30):
        assert span.high.value.digits(20) == mpmath.nstr(mpmath.cbrt(100 - 4 * mpmath.pi**2), 20)


def test_where_a_condition_is_nowhere_defined_it_does_not_hold() -> None:
    formula = (T - 5) / (T - 2) ** 2  # no scene at 2
    assert shown(solved(formula)) == [(None, 2, False, False), (2, 5, False, True)]
    roots = (T - 5) / (T**2 - 2) ** 2
    assert shown(solved(roots))[0] == (None, -(2**0.5), False, False)
    assert [x[2:] for x in shown(solved(roots))] == [(False, False), (False, False), (False, True)]


def test_the_extremum_between_two_frequencies_is_proven_or_not_told() -> None:
    five, ends = ExactNumber(Integer(5)), [ExactNumber(Integer(x)) for x in (6, 9)]
    for sign in (1, -1):
        surface = Surface.of(condition(sign * (OMEGA**2 - 10 * T) ** 2), T)
        found = touch(surface, five, *ends)
        assert found.digits(20) == ExactNumber(sqrt(50)).digits(20)
        assert touch(surface, five, ExactNumber(Integer(8)), ends[1]) is None  # none in between
        assert touch(surface, five, ExactNumber(Integer(1)), ends[1]) is None  # more than one is not excluded
        assert touch(surface, five, ends[0], ExactNumber(Integer(7))) is None  # it has passed neither end
        before = ends[0], ExactNumber(sqrt(50) - Rational(1, 5))
        assert touch(surface, five, *before, beyond=2).digits(20) == found.digits(20)  # 1/4 rad/s outside
        assert touch(surface, five, *before, beyond=3) is None  # 1/8
    assert touch(Surface.of(condition(OMEGA**2 * T), T), five, *ends) is None


# --- questions and answers -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("digits", [0, -3, 2.5, "7"])
def test_digits_must_be_a_whole_number_from_one_on(digits: object) -> None:
    with pytest.raises(SceneError, match="digits"):
        hs.require(PAPER, "zeta", digits=digits)
    assert hs.require(PAPER, "zeta", digits=1).digits == 1


DOMAINS = [
    ("omega_n", None, (0, None, False, False)),
    ("environment.m", None, (0, None, True, True)),
    ("omega_n", (0, 5), (0, 5, False, True)),
    ("omega_n", (2, 5), (2, 5, True, True)),
    ("environment.m", (-1, 5), (0, 5, True, True)),
    ("environment.m", (0, 5), (0, 5, True, True)),
    ("omega_n", (-1, 5), (0, 5, False, True)),
]


@pytest.mark.parametrize(("path", "given", "expected"), DOMAINS)
def test_the_values_asked_about_are_those_that_the_model_allows(path: str, given: object, expected: object) -> None:
    found = domain(PAPER.knobs[path], given)  # type: ignore[arg-type]
    assert (found.low, found.high, found.holds_low, found.holds_high) == expected


def test_an_order_lies_between_0_and_1_and_a_device_may_be_negative() -> None:
    alpha = hs.Scene(SLACK, ()).knobs["environment.alpha"]
    for given, expected in (
        (None, (0, 1, False, False)), ((0, 1), (0, 1, False, False)), ((-1, 2), (0, 1, False, False)),
        (("0.25", "0.5"), (Rational(1, 4), Rational(1, 2), True, True)),
        (("0.25", 3), (Rational(1, 4), 1, True, False)), ((-2, "0.5"), (0, Rational(1, 2), False, True)),
    ):  # fmt: skip
        found = domain(alpha, given)  # type: ignore[arg-type]
        assert (found.low, found.high, found.holds_low, found.holds_high) == expected
    for given in ((1, 2), (-2, 0)):
        with pytest.raises(SceneError, match="no value from"):
            domain(alpha, given)
    with pytest.raises(SceneError, match="must go up"):
        domain(alpha, ("0.5", "0.5"))
    device = domain(hs.Scene(SPRING, (effects.shunt(m=1),)).knobs["m"], None)
    assert (device.low, device.high) == (None, None)


ROOT_2 = 2**0.5


@pytest.mark.parametrize(
    ("felt", "needed"),
    [
        ("100*s^(1/2) + 2*s", (10 * ROOT_2 + 2) / 80),  # r_i at the high end
        ("70*s^(1/2) - 3*s", (5 * ROOT_2 + 3) / 80),
        ("100*s^(1/2) - 2*s", ROOT_2 / 8),  # r_r everywhere, and r_i at rest
    ],
)
def test_a_threshold_beside_powers_of_s_that_leave_0_over_0_at_rest_is_the_largest_ratio(
    felt: str, needed: float
) -> None:
    """80 s^(1/2) is 40 sqrt(2) (1 + j) sqrt(omega), and its modulus 80 sqrt(omega)."""
    pot = hs.Scene(environments.spring_pot(80, "1/2"), (), (0, 1), rendered=environments.expression(felt))
    found = hs.require(pot, "evaluation.jnd")
    assert found.certified
    assert [float(x.value) for x in found.ends] == pytest.approx([needed], rel=1e-14)


def test_a_threshold_may_be_free_of_one_part_or_of_both() -> None:
    """The paper's ratios are at most 0.1162 and 0.1554: the free part's must not be below its own."""
    scene = PAPER.with_band(0, 15)
    loose = hs.Scene(scene.environment, scene.effects, scene.band, hs.Threshold.of("0.2", "0.3"))
    for path, digits, part in (
        ("evaluation.jnd", "0.155424", IMAG), ("evaluation.jnd.real", "0.116247", REAL), ("evaluation.jnd.imag", "0.155424", IMAG),
        ("c", "0.155424", IMAG),
    ):  # fmt: skip
        [span] = hs.require(loose, path).feasible
        assert (span.low.value.digits(6), [b.part for b in span.low.bindings]) == (digits, [part])
    tight = hs.Scene(scene.environment, scene.effects, scene.band, hs.Threshold.of("0.11", "0.3"))
    assert hs.require(tight, "evaluation.jnd.imag").feasible == ()
    free = loose.knobs["evaluation.jnd.real"]
    assert free.put(loose, Rational(1, 2)).threshold == hs.Threshold(Rational(1, 2), Rational(3, 10))
    both = loose.knobs["c"].put(loose, Rational(1, 2)).threshold
    assert both == hs.Threshold(Rational(1, 2), Rational(1, 2))
    assert (free.unit, free.number("0.25")) == ("1", Rational(1, 4))
    for given, words in (("1 kg", "evaluation.jnd.real"), (symbols("q"), "must be a number")):
        with pytest.raises(SceneError, match=words):
            free.number(given)


def test_any_environment_takes_the_smaller_threshold_unless_it_is_what_is_free() -> None:
    lag = hs.Scene(SPRING, (effects.first_order_lag(80),), (0, 15), hs.Threshold.of("0.3", "0.2"))
    [span] = hs.require(lag, "omega_c", any_environment=True).feasible
    assert span.low.value.digits(20) == ExactNumber(15 * sqrt(24)).digits(20)  # x/sqrt(1 + x^2) = 1/5
    swapped = hs.Scene(SPRING, lag.effects, lag.band, hs.Threshold.of("0.2", "0.3"))
    assert hs.require(swapped, "omega_c", any_environment=True).feasible[0].low.value.digits(
        9
    ) == span.low.value.digits(9)
    [span] = hs.require(lag, "c", any_environment=True).feasible
    assert span.low.value.digits(15) == ExactNumber(3 / sqrt(265)).digits(15)
    for path in ("evaluation.jnd.real", "evaluation.jnd.imag"):
        with pytest.raises(SceneError, match="the thresholds are one"):
            hs.require(lag, path, any_environment=True)
    late = hs.require(LATE, "tau", any_environment=True)
    assert late.feasible[0].high.value.digits(15) == mpmath.nstr(mpmath.asin(0.05) * 2 / 15, 15)


def test_a_formula_at_the_low_end_of_the_band_is_in_its_terms() -> None:
    """A device k beside a damper: 10/(3 omega), largest at the low end of 2 rad/s."""
    soft = hs.Scene(environments.mass_spring_damper(b=3), (effects.shunt(k=1),), (2, 15))
    found = hs.require(soft, "effects.shunt.k", (0, 50))
    [span] = found.feasible
    assert (span.high.value.value, span.high.bindings[0].kind, span.high.bindings[0].omega.value) == (
        Rational(3, 5),
        Kind.START,
        2,
    )
    assert found.closed_form == "k <= b*c*omega_min"
    lag = hs.require(hs.Scene(SPRING, (effects.first_order_lag(80),), (0, 15)), "omega_c")
    assert lag.closed_form.startswith("omega_c >= ")
    assert "omega_max" in lag.closed_form
    assert hs.require(PAPER, "omega_n").closed_form is None
    named = hs.require(hs.Scene(SPRING, (effects.first_order_lag(80),), (0, 15)), "omega_c", any_environment=True)
    [form] = named.forms
    c, end = symbols("c omega_max", positive=True)
    assert abs(form.subs({c: Rational(1, 10), end: 15}).evalf(30) - 15 * sqrt(99)) < 1e-25


def test_a_requirement_needs_numbers_for_all_that_is_not_free_and_rational_thresholds() -> None:
    open_ = hs.Scene(SPRING, (effects.first_order_lag(symbols("w")), effects.shunt(m=1)), (0, 15))
    with pytest.raises(SceneError, match="effects.first-order-lag.omega_c = w is a symbol where a number is needed"):
        hs.require(open_, "effects.shunt.m")
    root = hs.Scene(SPRING, (effects.first_order_lag(80),), (0, 15), hs.Threshold.of(Rational(1, 10) + sqrt(2) / 100))
    with pytest.raises(SceneError, match="thresholds that are rational"):
        hs.require(root, "omega_c")
    with pytest.raises(SceneError, match="no parameter of the environment"):
        hs.require(root, "environment.k", any_environment=True)


def test_the_document_tells_each_end_with_what_binds_there() -> None:
    found = hs.require(gain("g^2", g=1), "g", (-2, 1)).to_dict()
    assert found["range"] == [-2.0, 1.0]
    assert [[round(x, 6) for x in pair] for pair in found["feasible"]] == [[-1.048809, -0.948683], [0.948683, 1.0]]
    assert [[x["closed"] for x in pair] for pair in found["ends"]] == [[True, True], [True, True]]
    assert [round(x["at"], 6) for x in found["binding"]] == [-1.048809] * 2 + [-0.948683] * 2 + [0.948683] * 2
    assert found["ends"][0][0]["digits"].startswith("-1.0488")
    assert found["condition"] == ["real", "imag"]
    assert hs.require(PAPER, "omega_n", part=REAL).to_dict()["condition"] == ["real"]
    assert hs.require(PAPER, "omega_n", any_environment=True).to_dict()["condition"] == ["any environment"]


def test_an_exact_set_is_said_to_be_quick_up_to_the_order_of_a_device() -> None:
    assert is_quick(hs.Scene(SPRING, (effects.first_order_lag(20), effects.second_order_lowpass(90, 1))))
    assert not is_quick(hs.Scene(SPRING, tuple(effects.second_order_lowpass(90, 1, name=f"f{i}") for i in range(4))))
    assert not is_quick(LATE)


PEAKED = effects.series("1 + a*s/(s^2 + 2*s + 9)", parameters={"a": "0.1"})  # r_r is at most a/2, at 3 rad/s


@pytest.mark.parametrize(
    ("told", "path", "kind", "near"),
    [
        (hs.Scene(SPRING, (PEAKED, effects.delay("1 ms")), (1, 9)), "a", Kind.TOUCH, 0.2),
        (hs.Scene(SPRING, (effects.shunt(m=1), effects.delay("1 ms")), (0, 6)), "effects.shunt.m", Kind.EDGE, 10 / 36),
    ],
)
def test_a_requirement_by_balls_may_end_at_a_tangency_and_at_negative_values(
    told: hs.Scene, path: str, kind: Kind, near: float
) -> None:
    """Witnesses: an evaluation 1e-9 on both sides of each end; the two crossings just beyond a touch hold its frequency."""
    found = hs.require(told, path, (-1, 1))
    [span] = found.feasible
    assert found.undecided == ()
    assert [float(span.low.value), float(span.high.value)] == pytest.approx([-near, near], rel=1e-3)
    for end, inward in ((span.low, 1), (span.high, -1)):
        [b] = end.bindings
        assert (b.kind, b.part) == (kind, REAL)
        value = Rational(end.value.digits(16))
        for shift, full in ((inward, True), (-inward, False)):
            moved = value + Rational(shift, 10**9)
            assert is_transparent(told.with_values({found.free.symbol.name: moved})) is full
        outside = hs.evaluate(told.with_values({found.free.symbol.name: value - Rational(inward, 10**7)}))
        crossed = [float(x.omega) for x in outside.crossings if x.part is REAL]
        if kind is Kind.TOUCH:
            assert len(crossed) == 2
            assert crossed[0] < float(b.omega) < crossed[1] < crossed[0] + 0.01
        else:
            assert b.omega.value == told.band[1]


@pytest.mark.parametrize("own", [-1, 0])
def test_a_requirement_by_balls_over_all_values_does_not_depend_on_the_scenes_own(own: int) -> None:
    shunted = hs.Scene(SPRING, (effects.shunt(m=own), effects.delay("1 ms")), (0, 6))
    found = hs.require(shunted, "effects.shunt.m")
    [span] = found.feasible
    assert found.undecided == ()
    assert [float(span.low.value), float(span.high.value)] == pytest.approx([-10 / 36, 10 / 36], rel=1e-3)


@pytest.mark.parametrize("later", [(), (effects.delay("1 ms"),)])
def test_a_parameter_that_has_left_the_conditions_may_have_any_value(later: tuple[hs.Effect, ...]) -> None:
    gone = effects.series("(g + g*s)/(g + g*s)", parameters={"g": "0.5"})
    scene = hs.Scene(SPRING, (gone, *later), (0, 15), hs.Threshold.of("0.1"))
    assert hs.require(scene, "g")._line().endswith("any")
    late = hs.Scene(SPRING, (gone, effects.delay("100 ms")), (0, 15), hs.Threshold.of("0.1"))
    assert hs.require(late, "g").feasible == ()


@pytest.mark.parametrize("effect", [effects.first_order_lag(700), effects.delay("2 ms")])
def test_an_environment_that_is_zero_at_one_value_is_none_there(effect: hs.Effect) -> None:
    scene = hs.Scene(
        environments.expression("p*(100 + s)", parameters={"p": "0.5"}), (effect,), (0, 15), hs.Threshold.of("0.1")
    )
    found = hs.require(scene, "p")
    spans = [(None if x is None else float(x.value), closed) for y in found.feasible for x, closed in ((y.low.value, y.low.closed), (y.high.value, y.high.closed))]  # fmt: skip
    assert spans == [(None, False), (0, False), (0, False), (None, False)]
    with pytest.raises(hs.SceneError, match="zero at every frequency"):
        hs.evaluate(scene.with_values({"p": 0}))


def test_what_comes_nearest_is_told_beside_a_value_without_a_scene() -> None:
    scene = hs.Scene(
        environments.expression("p*(100 + s)", parameters={"p": "0.5"}), (effects.first_order_lag(70),), (0, 15)
    )
    found = hs.require(scene, "p")
    assert found.feasible == ()
    assert json.loads(found.to_json())["feasible"] == []


@pytest.mark.parametrize("seed", range(6))
def test_real_roots_in_a_parameter_are_those_of_digits_whatever_powers_of_pi_are_in_it(seed: int) -> None:
    """Of irreducible polynomials of degree one to three in q, of up to four in pi; negative ones where they are wanted."""
    pick, q = Random(seed), Symbol("q")
    ring = Ring.of([q]).axis
    index = ring.meanings.index(q)
    for _ in range(8):
        form = sum(
            (pick.randint(-4, 4) * pi ** pick.randint(0, 4) * q**n for n in range(pick.randint(1, 3) + 1)),
            Rational(pick.choice([-3, 2, 5])),
        )
        for factor, _ in irreducible(ring.convert(form).numerator) if form.has(q) else ():
            negative = pick.random() < 0.5
            own = Poly(ring.expression(factor), q)
            with mpmath.workdps(60):
                row = [mpmath.mpf(str(c.evalf(60))) for c in own.all_coeffs()]
                every = mpmath.polyroots(row, maxsteps=500, extraprec=500) if own.degree() > 0 else []
                true = [mpmath.re(z) for z in every if abs(mpmath.im(z)) < mpmath.mpf(10) ** -40]
            wanted = sorted(x for x in true if x > 0 or negative or own.degree() == 1)
            found = sorted(real_roots(factor, index, negative=negative), key=float)
            assert [float(x) for x in found] == pytest.approx([float(x) for x in wanted], rel=1e-13)


@pytest.mark.slow
def test_a_number_that_is_negative_in_the_scene_is_answered_as_its_mirror_image() -> None:
    """By balls, as a delay asks for: 100 + (5 - q) s with q = -2 is 100 + (5 + p) s with p = 2."""
    answers = []
    for sign, name in ((-1, "q"), (1, "p")):
        wall = environments.expression(f"100 + (5 + ({sign})*{name})*s", parameters={name: sign * 2})
        found = hs.require(
            hs.Scene(wall, (effects.delay("5 ms"),), (0, 12), {"real": "1/2", "imag": "1/2"}), name, (-9, 9)
        )
        rows = [
            sorted(sign * float(x.value) for x in (span.low, span.high) if x.value is not None)
            for span in found.feasible
        ]
        answers.append((sorted(rows), len(found.undecided)))
    assert answers[0][0]
    assert answers[0][1] == answers[1][1]
    assert np.allclose(answers[0][0], answers[1][0], rtol=1e-12)
