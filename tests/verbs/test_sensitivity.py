"""How frequencies move with parameters: the certified numbers against differences of certified crossings, and against laws."""

from __future__ import annotations

import json
from fractions import Fraction
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from marks import examples, often
from sympy import Expr, Rational

import haptisym as hs
from haptisym.cli import app
from haptisym.model.quantities import dimension_exponents
from haptisym.verbs.sensitivity.entry import sensitivity
from haptisym.verbs.sensitivity.slopes import TOUCH, Sensitive

STEP = Rational(1, 10**15)
SCENES = ["fu2019", "delayed-spring", "organ-tissue", "position-force-teleoperation", "sidestick"]


def changed(scene: hs.Scene, name: str, value: Expr) -> hs.Evaluation:
    return hs.evaluate(scene.with_values({name: value}))


def slope(before: str, after: str, step: Expr) -> float:
    return float((Rational(after) - Rational(before)) / (2 * step))


@pytest.mark.parametrize("name", often(SCENES, {"fu2019", "delayed-spring", "sidestick"}.__contains__))
def test_a_sensitivity_is_the_slope_of_certified_crossings(name: str) -> None:
    scene = hs.load_scene(name)
    found = sensitivity(scene).crossings[0]
    values = {p.symbol.name: p.value for p in scene.parameters} | {"c": scene.threshold.real}
    for row in found.parameters:
        here = values["c" if row.name.startswith("c_") else row.name]
        if here == 0 or row.name.startswith("c_"):
            continue
        down, up = (changed(scene, row.name, here * (1 + n * STEP)).crossings[0].omega.digits(60) for n in (-1, 1))
        assert float(row.derivative) == pytest.approx(slope(down, up, here * STEP), rel=1e-12, abs=1e-18)
        assert float(row.elasticity) == pytest.approx(
            float(here) * float(row.derivative) / float(found.omega), rel=1e-13
        )


def test_a_line_counts_what_the_tables_list() -> None:
    """Both kinds of changeovers: the paper's example has one of each."""
    found = sensitivity(hs.load_scene("fu2019"))
    rows = found.to_dict()
    assert {name: len(own) for name, own in rows["changeovers"].items()} == {"environment": 1, "perceived": 1}
    assert f": {len(rows['crossings'])} crossings, 2 changeovers>" in repr(found)


@pytest.mark.slow
def test_changeovers_move_as_certified_changeovers_do() -> None:
    scene = hs.load_scene("fu2019")
    found = sensitivity(scene)
    for system in ("changeovers_environment", "changeovers_perceived"):
        for p in scene.parameters:
            ends = [changed(scene, p.symbol.name, p.value * (1 + n * STEP)) for n in (-1, 1)]
            down, up = (getattr(e, system)[0].omega.digits(60) for e in ends)
            row = getattr(found, system)[0][p.symbol.name]
            assert float(row.derivative) == pytest.approx(slope(down, up, p.value * STEP), rel=1e-12, abs=1e-25)


def sums(scene: hs.Scene, x: Sensitive) -> dict[str, Fraction]:
    """Of the elasticities, each times its parameter's power of a base unit, to 25 digits."""
    total = dict.fromkeys(("mass", "time", "length"), Fraction(0))
    for p in scene.parameters:
        for base, n in dimension_exponents(p.dimension, scene.motion) or p.exponents or ():
            total[base] += n * Fraction(x[p.symbol.name].elasticity.digits(25))
    return total


@pytest.mark.parametrize("name", [*SCENES[:2], "steering-wheel", "stick-with-friction", "two-mass-resonance"])
def test_elasticities_keep_the_sum_rules_of_dimensional_analysis(name: str) -> None:
    """Forces scaled leave every frequency alone; a time unit u times as long makes it u times as large a number."""
    scene = hs.load_scene(name)
    found = sensitivity(scene)
    for x in (*found.crossings, *found.changeovers_environment, *found.changeovers_perceived):
        total = sums(scene, x)
        assert abs(total["mass"]) < Fraction(1, 10**20)
        assert abs(total["length"]) < Fraction(1, 10**20)
        assert abs(total["time"] + 1) < Fraction(1, 10**20)


POSITIVE = st.fractions(Fraction(1, 20), Fraction(20), max_denominator=50)


@examples(8)
@given(
    m=POSITIVE,
    b=POSITIVE,
    k=POSITIVE,
    omega_n=POSITIVE,
    zeta=st.fractions(Fraction(1, 10), Fraction(2), max_denominator=20),
)
def test_the_sum_rules_hold_for_any_values(
    m: Fraction, b: Fraction, k: Fraction, omega_n: Fraction, zeta: Fraction
) -> None:
    env = hs.environments.mass_spring_damper(m, b, k)
    found = sensitivity(hs.Scene(env, (hs.effects.second_order_lowpass(omega_n, zeta),), (0, 50)))
    for x in found.crossings:
        if not x.reason:
            assert abs(sums(found.evaluation.scene, x)["time"] + 1) < Fraction(1, 10**20)


def test_a_delay_alone_has_elasticity_minus_one() -> None:
    found = sensitivity(hs.load_scene("delayed-spring")).crossings[0]
    assert found["tau"].elasticity.digits(30) == "-1.00000000000000000000000000000"
    assert float(found["k"].elasticity) == 0  # behind a delay, a spring of any stiffness is noticed alike


def test_a_parameter_that_is_zero_has_elasticity_zero_and_the_right_derivative() -> None:
    """A mass beside a spring: |m| omega^2/k = c, with a further shunt mass of 0 the crossing moves by -omega/(2 m)."""
    effects = (hs.effects.shunt(m=2, name="own"), hs.effects.shunt(m=0, name="further"))
    found = sensitivity(hs.Scene(hs.environments.mass_spring_damper(k=100), effects)).crossings[0]
    name = next(p.name for p in found.parameters if "further" in p.path)
    assert float(found[name].elasticity) == 0
    assert float(found[name].derivative) == pytest.approx(-float(found.omega) / 4, rel=1e-15)


def touching() -> hs.Scene:
    """|dH/H| has its largest real part, 1/5, at 3 rad/s exactly: the threshold is touched there."""
    effect = hs.effects.series("1 + a*s/(s^2 + 2*s + 9)", parameters={"a": "0.4"})
    return hs.Scene(hs.environments.mass_spring_damper(k=100), (effect,), (0, 15), hs.Threshold.of(Rational(1, 5), 1))


def test_at_a_touch_there_is_no_derivative_and_it_is_said() -> None:
    found = sensitivity(touching())
    [x] = found.crossings
    assert x.kind is hs.CrossingKind.TOUCHES
    assert {p.name: (p.derivative, p.elasticity, p.reason) for p in x.parameters if p.name != "k"} == {
        "a": (None, None, TOUCH), "c_real": (None, None, TOUCH)
    }  # fmt: skip
    assert float(x["k"].derivative) == 0  # behind a series effect a spring of any stiffness is noticed alike
    assert "touches its threshold" in " ".join(str(found).split())
    row = next(p for p in found.to_dict()["crossings"][0]["parameters"] if p["name"] == "a")
    assert (row["derivative"], row["elasticity"], row["reason"]) == (None, None, TOUCH)
    assert "within the bandwidth" in found.bandwidth.reason


def test_the_formula_says_where_it_does_not_hold() -> None:
    from haptisym.pages.sections import asked
    from haptisym.verbs.derive.entry import derive

    [section] = asked(derive(touching(), ["a"]), ["d omega_r/d a"])
    assert "here at 3.0000 rad/s" in str(section.blocks[0])


def test_a_bandwidth_that_is_the_whole_band_does_not_move() -> None:
    found = sensitivity(hs.load_scene("fu2019").with_band(0, 5))
    assert all(float(p.derivative) == 0 for p in found.bandwidth.parameters)


def test_factors_that_meet_for_the_scenes_values_do_no_harm() -> None:
    """Re H_perc = (k - m omega^2) times something: that zero moves with m and k alone."""
    found = sensitivity(hs.load_scene("undamped-resonance")).changeovers_perceived[0]
    assert {p.name: float(p.elasticity) for p in found.parameters} == {"m": -0.5, "k": 0.5, "omega_n": 0, "zeta": 0}


def test_the_formula_and_the_numbers_are_one() -> None:
    found = sensitivity(hs.load_scene("fu2019"))
    values = {p.symbol: p.value for p in found.evaluation.scene.parameters}
    x = found.crossings[1]
    known = {**values, hs.omega: Rational(x.omega.digits(60)), hs.symbols("c"): Rational(1, 10)}
    for name in ("m", "zeta", "c"):
        form = found.formula(hs.Part.IMAG, name)
        assert float(form.subs(known).evalf(30)) == pytest.approx(float(x[name].derivative), rel=1e-14)


def test_the_command_line_prints_the_document(runner) -> None:  # type: ignore[no-untyped-def]
    done = runner.invoke(app, ["sensitivity", "fu2019", "--json", "--digits", "30"])
    document = json.loads(done.stdout)
    assert (done.exit_code, document["schema"]) == (0, "haptisym.sensitivity/1")
    row = document["crossings"][0]["parameters"][3]
    assert (row["path"], row["unit"]) == ("effects.filter.omega_n", "rad/s")
    assert len(row["digits"]["elasticity"]) == 31
    assert document["bandwidth"]["omega"] == document["crossings"][0]["omega"]


@pytest.mark.slow
def test_a_figure_is_written(tmp_path, runner) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "bars.svg"
    assert runner.invoke(app, ["sensitivity", "fu2019", "--figure", str(path)]).exit_code == 0
    assert path.read_text(encoding="utf-8").count("<svg") == 1
    with pytest.raises(hs.SceneError, match="must end in"):
        runner.invoke(app, ["sensitivity", "fu2019", "--figure", str(tmp_path / "bars.doc")], catch_exceptions=False)


@pytest.fixture
def runner():  # type: ignore[no-untyped-def]
    from click.testing import CliRunner

    return CliRunner()


def test_public_names() -> None:
    assert isinstance(hs.sensitivity("delayed-spring"), hs.Sensitivities)
    assert {"sensitivity", "Sensitivities"} <= set(dir(hs))


# Derivatives from one side: every answer against certified evaluations just beside the scene

NEAR = Rational(1, 10**12)


def formula(H: str, **parameters: float | str) -> hs.Scene:
    """An environment as written, alone, from 5 to 15 rad/s: Re H changes its sign at 10 rad/s."""
    return hs.Scene(hs.environments.expression(H, parameters=parameters), (), (5, 15))


def filtered(zeta: object, band: tuple[int, int] = (0, 100), omega_n: str = "80 rad/s") -> hs.Scene:
    env = hs.environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    return hs.Scene(env, (hs.effects.second_order_lowpass(omega_n, zeta),), band)


def beside_a_mass(low: int, high: int) -> hs.Scene:
    """r_r = m omega^2/k meets 1/10 at 10 rad/s."""
    return hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.shunt(m="0.1"),), (low, high))


IN_HZ = 20 * pi
MEETINGS = {
    "a pole without damping goes on as a zero": (filtered(0), "perceived", 80, "zeta", "above", -64 * 15 / 114.2),
    "a pole moves with its frequency": (filtered(0), "perceived", 80, "omega_n", "", 1),
    "a pole at a frequency in Hz moves with it": (filtered(0, omega_n="10 Hz"), "perceived", IN_HZ, "omega_n", "", 1),
    "a pole at a frequency in Hz goes on as a zero": (
        filtered(0, omega_n="10 Hz"), "perceived", IN_HZ, "zeta", "above", 15 * IN_HZ**2 / (100 - 1.8 * IN_HZ**2),
    ),
    "a pole at a frequency in Hz does not move with a mass": (filtered(0, omega_n="10 Hz"), "perceived", IN_HZ, "m", "", 0),
    "a crossing at the least damping": (filtered(0), "crossings", 24.828, "zeta", "above", 27.714),
    "a parameter that does not matter, at its least value": (filtered(0), "environment", 7.4536, "zeta", "", 0),
    "a delay at its least value": (
        hs.Scene(hs.environments.kelvin_voigt(100, 5), (hs.effects.first_order_lag(40), hs.effects.delay(0)), (0, 30)),
        "crossings", 8.5, "tau", "above", None,
    ),
    "a zero that moves through two that stay": (formula("(k + s^2)*(100 + s^2)^2", k=100), "environment", 10, "k", "", 1 / 20),
    "a zero between two poles that part": (formula("(100 + s^2)/((100 + s^2)^2 - q^2)", q=0), "environment", 10, "q", "splits", None),
    "a pole that goes on as a zero, or in three": (formula("(100 + s^2)/((100 + s^2)^2 + q)", q=0), "environment", 10, "q", "above", 0),
    "the same turned round": (formula("(100 + s^2 + q)/((100 + s^2)^2 - q)", q=0), "environment", 10, "q", "below", 1 / 20),
    "three zeros that are one for a moment": (formula("(100 + s^2)^3 + q", q=0), "environment", 10, "q", "infinitely", None),
    "two lines that cross a third": (formula("(100 + s^2)*((100 + s^2)^2 - 4*q^2)", q=0), "environment", 10, "q", "splits", None),
    "a zero with two that are not real": (formula("(100 + s^2 + q)*((100 + s^2)^2 + 4*q^2)", q=0), "environment", 10, "q", "", 1 / 20),
    "a crossing that enters the band at its end": (beside_a_mass(0, 10), "crossings", 10, "m", "above", -50),
    "a crossing that leaves the band at its end": (beside_a_mass(0, 10), "crossings", 10, "k", "below", 1 / 20),
    "a crossing that leaves the band at its start": (beside_a_mass(10, 20), "crossings", 10, "m", "below", -50),
    "a crossing that enters the band at its start": (beside_a_mass(10, 20), "crossings", 10, "k", "above", 1 / 20),
}  # fmt: skip


def frequencies(e: hs.Evaluation, kind: str, near: float) -> list[str]:
    """Of that kind and within 0.1 rad/s, to 40 digits."""
    listed = [x.omega for x in e.crossings] if kind == "crossings" else getattr(e, f"changeovers_{kind}")
    found = [getattr(x, "omega", x) for x in listed]
    return [x.digits(40) for x in found if abs(float(x) - near) < 0.1]


@pytest.mark.parametrize("name", MEETINGS)
def test_a_derivative_from_one_side_is_the_slope_of_certified_frequencies_there(name: str) -> None:
    scene, kind, near, parameter, side, expected = MEETINGS[name]
    found = sensitivity(scene)
    rows = found.crossings if kind == "crossings" else getattr(found, f"changeovers_{kind}")
    x = min(rows, key=lambda row: abs(float(row.omega) - near))
    row, value = x[parameter], next(p.value for p in scene.parameters if p.symbol.name == parameter)
    here, seen = Rational(x.omega.digits(40)), {}
    for sign, where in ((-1, "below"), (1, "above")):
        try:
            beside = hs.evaluate(scene.with_values({parameter: value + sign * NEAR}))
        except hs.SceneError:  # below the least value there is no scene
            continue
        seen[where] = [(Rational(text) - here) / (sign * NEAR) for text in frequencies(beside, kind, float(here))]
    alone = {where: float(found[0]) for where, found in seen.items() if len(found) == 1 and abs(found[0]) < 10**6}
    if row.derivative is None:
        assert side in row.reason
        assert not alone
        return
    derivative = float(row.derivative)
    assert row.side == side
    assert row.reason.startswith(f"from {side}" if side else "")
    assert alone == pytest.approx(dict.fromkeys([side] if side else list(seen), derivative), abs=1e-8, rel=1e-9)
    if expected is not None:
        assert derivative == pytest.approx(expected, rel=1e-4)


def test_one_sided_derivatives_are_said_in_text_and_document() -> None:
    found = sensitivity(filtered(0))
    text = str(found)
    assert "-8.4063 above" in text
    assert "ζ: from above; below there is no scene." in text
    row = found.to_dict()["changeovers"]["perceived"][-1]["parameters"][-1]
    assert (row["name"], row["side"], row["reason"]) == ("zeta", "above", "from above; below there is no scene")
    assert row["digits"]["derivative"] == "-8.40630472854641"  # -960/114.2


def test_a_derivative_that_is_exactly_zero_is_told_as_zero() -> None:
    """k/b = omega_c: the lag cancels the environment's zero, and r_i does not depend on k at first order."""
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 5), (hs.effects.first_order_lag(20),))
    found = sensitivity(scene)
    assert found.certified
    assert float(found.crossings[0]["k"].derivative) == float(found.crossings[0]["b"].derivative) == 0
    here, *steps = (
        Fraction(hs.evaluate(scene.with_values({"k": k})).crossings[0].omega.digits(40))
        for k in (100, Rational(999, 10), Rational(1001, 10), Rational(9999, 100), Rational(10001, 100))
    )
    far, near = [x - here for x in steps[:2]], [x - here for x in steps[2:]]
    assert all(float(x / y) == pytest.approx(100, rel=0.01) for x, y in zip(far, near, strict=True))  # a parabola
