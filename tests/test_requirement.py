"""Inverse design: which values of a parameter keep a display transparent on its whole band."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from marks import often
from matplotlib.figure import Figure
from strategies import Seeded, case, coincident_case, scene
from sympy import Expr, Rational, asin, sqrt, symbols

import haptisym as hs
from haptisym import effects, environments
from haptisym.catalogue import values
from haptisym.cli import main
from haptisym.errors import SceneError
from haptisym.exact.reals import ExactNumber
from haptisym.requirement.figures import draw_map, draw_requirement
from haptisym.requirement.freeparameter import THRESHOLD, free_parameter
from haptisym.requirement.question import Requirement

PAPER = hs.load_scene("fu2019")
REAL, IMAG = hs.Part.REAL, hs.Part.IMAG
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
            expected = is_transparent(found.free.put(scene, value), found.keys)
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


@pytest.mark.parametrize("seed", often(range(120), lambda seed: seed % 12 == 1))
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
    f = told.chain.at(known).distortion().compile()
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


def test_every_boundary_point_is_a_zero_of_one_of_the_curves() -> None:
    light = PAPER.with_values({"b": 5}).with_band(0, 9)
    found = hs.design_map(light, ["zeta", "omega_n"], [("0.3", "0.7"), (20, 200)], slices=3)
    curves = {(part, kind.value): curve for (part, kind), curve in found.curves().items()}
    zeta, omega_n = (x.symbol for x in found.free)
    points = [(x.at, end) for x in found.slices for end in x.requirement.ends]
    assert points
    for at, end in points:
        for b in end.bindings:
            curve = curves[b.part, b.kind.value].subs(zeta, at)
            sides = [curve.subs(omega_n, Rational(end.value.digits(25)) * (1 + Rational(i, 10**15))) for i in (-1, 1)]
            assert sides[0] * sides[1] < 0


def test_figures_of_one_and_two_parameters_are_written(tmp_path: Path) -> None:
    from haptisym.requirement.figures import save_requirement

    save_requirement(hs.require(PAPER, "omega_n"), tmp_path / "one.svg")
    save_requirement(
        hs.design_map(PAPER, ["zeta", "omega_n"], [("0.1", "0.5"), (20, 200)], slices=3), tmp_path / "two.png"
    )
    assert (tmp_path / "one.svg").stat().st_size > 5000
    assert (tmp_path / "two.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(SceneError, match="svg"):
        save_requirement(hs.require(PAPER, "omega_n"), tmp_path / "one.docx")


def legend_of(ax: Any) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


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
        "between slices: interpolated",
        "imaginary part, band-edge",
        "exact slices",
    ]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega_n$ (rad/s)", r"$\zeta$")


def test_a_map_with_nothing_feasible_says_so() -> None:
    found = hs.design_map(PAPER, ["omega_n", "zeta"], [(10, 20), ("0.1", 1)], slices=3)
    ax = Figure().add_subplot()
    draw_map(ax, found)
    assert [text.get_text() for text in ax.texts] == ["transparent nowhere: on none of 3 exact slices"]
    assert legend_of(ax) == ["exact slices"]


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
        draw_map(ax, replace(found, slices=slices))
        assert "undecided" in legend_of(ax)
        [hatched] = [x for x in ax.collections if x.get_hatch()]
        box = hatched.get_paths()[0].get_extents()
        assert (box.x0, box.x1, box.y0, box.y1) == pytest.approx((left, right, low, high))


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
    assert len([x for x in legend_of(ax) if "interpolated" in x]) == 1


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
        "feasible": [[122.35581477043092, None]],
        "ends": [[{"digits": "122.3558147704309211874431712767197563518", "closed": True}, None]],
        "binding": [
            {"at": 122.35581477043092, "part": "imag", "omega": 15.0, "kind": "band-edge", "closed_form": None}
        ],
        "closed_form": None,
        "undecided": [],
        "certified": True,
    }


def test_the_page_says_the_value_what_binds_and_the_formula(capsys, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    status, out, _ = call("delayed-spring", "--free", "tau", capsys=capsys, monkeypatch=monkeypatch)
    assert status == 0
    assert "exactly for 0 <= tau <= 0.0066778 s" in out
    assert "r_i (imag)   the band's high end, 15 rad/s" in out
    assert "tau = asin(c)/omega_max" in out


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
    assert free_parameter(PAPER, "omega_n") == free_parameter(PAPER, "effects.filter.omega_n")
