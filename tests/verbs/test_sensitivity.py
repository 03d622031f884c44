"""How frequencies move with parameters: against differences of certified crossings, and against scenes whose powers are known by hand."""

from __future__ import annotations

import json
from fractions import Fraction
from math import pi
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from marks import FLEXIBLE, UNDAMPED, examples, often
from mpmath import mp
from sympy import Expr, Integer, Rational, Symbol

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.kernel.rings import PolynomialRing, omega
from haptisym.kernel.solutions import Equation
from haptisym.model.quantities import dimension_exponents
from haptisym.verbs.sensitivity.entry import FLAT, STEEP, TOUCH, Sensitive, Slope

STEP = Rational(1, 10**15)
SCENES = ["fu2019", "delayed-spring", "organ-tissue", "position-force-teleoperation", "sidestick"]


def slope(before: str, after: str, step: Expr) -> float:
    return float((Rational(after) - Rational(before)) / (2 * step))


def changed(scene: hs.Scene, name: str, value: Expr) -> hs.Evaluation:
    return hs.evaluate(scene.with_values({name: value}))


@pytest.mark.dear("fu2019", "sidestick")
@pytest.mark.parametrize("name", often(SCENES, {"fu2019", "delayed-spring", "sidestick"}.__contains__))
def test_a_sensitivity_is_the_slope_of_certified_crossings(name: str) -> None:
    scene = hs.load_scene(name)
    found = hs.sensitivity(scene).crossings[0]
    values = {p.symbol.name: p.value for p in scene.parameters} | {"c": scene.threshold.real}
    for row in found.parameters:
        here = values.get(row.name)
        if not here:  # 0, or the limit of one part alone
            continue
        down, up = (changed(scene, row.name, here * (1 + n * STEP)).crossings[0].omega.digits(60) for n in (-1, 1))
        assert float(row.derivative) == pytest.approx(slope(down, up, here * STEP), rel=1e-12, abs=1e-18)
        assert float(row.elasticity) == pytest.approx(
            float(here) * float(row.derivative) / float(found.omega), rel=1e-13
        )
    assert {row.name for row in found.parameters} >= {p.symbol.name for p in scene.parameters}


@pytest.mark.dear("m")
@pytest.mark.few("m", "zeta")
@pytest.mark.parametrize("name", ["m", "b", "k", "omega_n", "zeta"])
def test_changeovers_move_as_certified_changeovers_do(name: str) -> None:
    """The paper's example has one of each system."""
    scene = hs.load_scene("fu2019")
    found, value = hs.sensitivity(scene), next(p.value for p in scene.parameters if p.symbol.name == name)
    ends = [changed(scene, name, value * (1 + n * STEP)) for n in (-1, 1)]
    for system in ("changeovers_environment", "changeovers_perceived"):
        [x] = getattr(found, system)
        down, up = (getattr(e, system)[0].omega.digits(60) for e in ends)
        assert float(x[name].derivative) == pytest.approx(slope(down, up, value * STEP), rel=1e-12, abs=1e-25)


def sums(scene: hs.Scene, x: Sensitive) -> dict[str, Fraction]:
    """Of the elasticities, each times its parameter's power of a base unit, to 25 digits."""
    total = dict.fromkeys(("mass", "time", "length"), Fraction(0))
    for p in scene.parameters:
        for base, n in dimension_exponents(p.dimension, scene.motion) or p.exponents or ():
            total[base] += n * Fraction(x[p.symbol.name].elasticity.digits(25))
    return total


@pytest.mark.dear("steering-wheel", "stick-with-friction")
@pytest.mark.few("delayed-spring", "steering-wheel", "stick-with-friction")
@pytest.mark.parametrize("name", ["fu2019", "delayed-spring", "steering-wheel", "stick-with-friction", FLEXIBLE])
def test_elasticities_keep_the_sum_rules_of_dimensional_analysis(name: str) -> None:
    """Forces scaled leave every frequency alone; a time unit u times as long makes it u times as large a number."""
    scene = hs.load_scene(name)
    found = hs.sensitivity(scene)
    for x in (*found.crossings, *found.changeovers_environment, *found.changeovers_perceived):
        total = sums(scene, x)
        for base, expected in (("mass", 0), ("length", 0), ("time", -1)):
            assert abs(total[base] - expected) < Fraction(1, 10**20)


POSITIVE = st.fractions(Fraction(1, 20), Fraction(20), max_denominator=50)
DAMPING = st.fractions(Fraction(1, 10), Fraction(2), max_denominator=20)


@pytest.mark.slow
@examples(8)
@given(m=POSITIVE, b=POSITIVE, k=POSITIVE, omega_n=POSITIVE, zeta=DAMPING)
def test_the_sum_rules_hold_for_any_values(
    m: Fraction, b: Fraction, k: Fraction, omega_n: Fraction, zeta: Fraction
) -> None:
    env = environments.mass_spring_damper(m, b, k)
    found = hs.sensitivity(hs.Scene(env, (effects.second_order_lowpass(omega_n, zeta),), (0, 50)))
    assume(not all(x.reason for x in found.crossings))
    for x in found.crossings:
        assert x.reason or abs(sums(found.evaluation.scene, x)["time"] + 1) < Fraction(1, 10**20)


# --- frequencies that are powers of parameters -----------------------------------------------------------------------

UNITS = {
    "k": ("environment.k", "N/m"), "m": ("effects.shunt.m", "kg"), "b": ("effects.shunt.b", "N*s/m"),
    "c_real": ("evaluation.jnd.real", "1"), "c_imag": ("evaluation.jnd.imag", "1"),
}  # fmt: skip
VALUES = st.fractions(Fraction(1, 4), 9, max_denominator=12)
HALF = Fraction(1, 2)


def shunted(k: Any, m: Any, b: Any, jnd: Any, band: tuple[Any, Any] = (0, 60)) -> hs.Scene:
    """A spring that is felt with a mass and a damper beside it: r_r = m omega^2/k, r_i = b omega/k."""
    return hs.Scene(environments.mass_spring_damper(k=k), (effects.shunt(m=m, b=b),), band, jnd)


def elasticities(x: Sensitive) -> dict[str, Fraction | None]:
    return {
        p.name: None if p.elasticity is None else Fraction(p.elasticity.digits(25)).limit_denominator(10**9)
        for p in x.parameters
    }


@pytest.mark.slow
@given(VALUES, VALUES, VALUES, st.integers(1, 9), st.integers(1, 9))
def test_frequencies_that_are_powers_of_parameters_have_these_powers_as_elasticities(
    k: Fraction, m: Fraction, b: Fraction, p: int, q: int
) -> None:
    """In the answer and in its document."""
    real, imag = Fraction(p, 10), Fraction(q, 11)
    assume(real * k / m != (imag * k / b) ** 2)
    jnd = {"real": f"{real}", "imag": f"{imag}"}
    e = hs.sensitivity(shunted(f"{k} N/m", f"{m} kg", f"{b} N*s/m", jnd, (0, 1000)), digits=18)
    by_part = {
        "real": (mp.sqrt(float(real * k / m)), {"k": HALF, "m": -HALF, "b": 0, "c_real": HALF}),
        "imag": (mp.mpf(float(imag * k / b)), {"k": 1, "m": 0, "b": -1, "c_imag": 1}),
    }
    values, document = {"k": k, "m": m, "b": b, "c_real": real, "c_imag": imag}, e.to_dict()
    assert [x.criterion.name for x in e.crossings if x.criterion] == sorted(by_part, key=lambda part: by_part[part][0])
    for x, row in zip(e.crossings, document["crossings"], strict=True):
        where, powers = by_part[row["part"]]
        assert float(x.omega) == row["omega"] == pytest.approx(float(where), rel=1e-12)
        assert elasticities(x) == powers
        for own, told in zip(x.parameters, row["parameters"], strict=True):
            derivative = float(powers[own.name]) * float(where) / float(values[own.name])
            assert float(own.derivative or 0) == told["derivative"] == pytest.approx(derivative, rel=1e-12)
            assert (told["path"], told["unit"]) == UNITS[own.name]
            assert told["elasticity"] == float(powers[own.name])
            assert told["digits"]["derivative"] == own.derivative.digits(18)  # type: ignore[union-attr]
        sizes = [abs(float(y.elasticity or 0)) for y in x.ranked]
        assert sizes == sorted(sizes, reverse=True)
        assert x["environment.k"] is x["k"]
    assert e.bandwidth is e.crossings[0]
    assert document["bandwidth"] == document["crossings"][0]
    [turn] = e.changeovers_perceived
    assert (elasticities(turn), e.changeovers_environment) == ({"k": HALF, "m": -HALF, "b": 0}, ())
    assert e.certified


def test_one_threshold_for_both_parts_is_one_parameter_and_a_formula_is_had_by_any_name() -> None:
    e = hs.sensitivity(shunted(100, "0.1", "0.5", 0.1))
    assert [elasticities(x) for x in e.crossings] == [
        {"k": HALF, "m": -HALF, "b": 0, "c": HALF}, {"k": 1, "m": 0, "b": -1, "c": 1},
    ]  # fmt: skip
    here = {"omega": 10, "k": 100, "m": Rational(1, 10), "b": HALF, "c": Rational(1, 10)}
    known = {"k": Rational(1, 20), "environment.k": Rational(1, 20), "m": -50, "shunt.m": -50, "c": 50, "evaluation.jnd.real": 50}  # fmt: skip
    for name, value in known.items():
        form = e.formula(hs.Part.REAL, name)
        assert form.subs({x: here[x.name] for x in form.free_symbols}) == value
    with pytest.raises(hs.SceneError, match='unknown parameter "q"'):
        e.formula(hs.Part.REAL, "q")


@pytest.mark.slow
def test_the_formula_and_the_numbers_are_one() -> None:
    found = hs.sensitivity(hs.load_scene("fu2019"))
    x, values = found.crossings[1], {p.symbol: p.value for p in found.evaluation.scene.parameters}
    known = {**values, omega: Rational(x.omega.digits(60)), hs.symbols("c"): Rational(1, 10)}
    for name in ("zeta", "c"):
        form = found.formula(hs.Part.IMAG, name)
        assert float(form.subs(known).evalf(30)) == pytest.approx(float(x[name].derivative), rel=1e-14)


def test_what_does_not_matter_has_elasticity_zero_and_a_parameter_that_is_0_its_derivative() -> None:
    late = hs.sensitivity(hs.load_scene("delayed-spring")).crossings[0]
    assert late["tau"].elasticity.digits(30) == "-1.00000000000000000000000000000"
    assert float(late["k"].elasticity) == 0  # behind a delay, a spring of any stiffness is noticed alike
    # |m| omega^2/k = c, with a further mass of 0 the crossing moves by -omega/(2 m)
    masses = (effects.shunt(m=2, name="own"), effects.shunt(m=0, name="further"))
    found = hs.sensitivity(hs.Scene(environments.mass_spring_damper(k=100), masses)).crossings[0]
    row = next(p for p in found.parameters if "further" in p.path)
    assert float(row.elasticity) == 0
    assert float(row.derivative) == pytest.approx(-float(found.omega) / 4, rel=1e-15)
    # Re H_perc = (k - m omega^2) times something: that zero moves with m and k alone, though a pole meets it here
    turn = hs.sensitivity(hs.load_scene(UNDAMPED)).changeovers_perceived[0]
    assert {p.name: float(p.elasticity) for p in turn.parameters} == {"m": -0.5, "k": 0.5, "omega_n": 0, "zeta": 0}


def test_a_derivative_that_is_exactly_zero_is_left_undecided() -> None:
    """k/b = omega_c: the lag cancels the environment's zero, and r_i does not depend on k at first order."""
    scene = hs.Scene(environments.kelvin_voigt(100, 5), (effects.first_order_lag(20),))
    found = hs.sensitivity(scene)
    assert not found.certified
    assert [found.crossings[0][x].reason[:9] for x in "kb"] == ["undecided"] * 2


def test_a_slope_is_told_to_as_many_digits_as_wanted() -> None:
    x = hs.sensitivity(shunted(7, "0.3", "0.7", 0.1)).crossings[0]
    found = x["k"].derivative
    assert found is not None
    with mp.workdps(80):
        exact = {"real": mp.sqrt(mp.mpf("0.7") / mp.mpf("0.3")) / 14, "imag": mp.mpf(1) / 7}[x.criterion.name]  # type: ignore[union-attr]
        for digits in (5, 30, 60):
            low, high = (mp.mpf(t) for t in found.enclosure(digits))
            assert low <= exact <= high
            assert high - low <= exact * mp.mpf(10) ** (2 - digits)


# --- regions ---------------------------------------------------------------------------------------------------------


@pytest.mark.dear("jnd2-<lambda>")
@pytest.mark.parametrize(
    ("jnd", "border"),
    [
        ({"shape": "ellipse", "real": 0.2, "imag": 0.1}, lambda x, y: (x / 0.2) ** 2 + (y / 0.1) ** 2 - 1),
        ({"shape": "diamond", "real": 0.2, "imag": 0.1}, lambda x, y: x / 0.2 + y / 0.1 - 1),
        ({"shape": "polygon", "corners": [[0.1, 0], [0, 0.2], [-0.3, 0], [0, -0.1]]}, lambda x, y: x / 0.3 + y / 0.2 - 1),
    ],
)  # fmt: skip
def test_where_a_region_is_left_the_slope_is_that_of_its_border(jnd: dict[str, Any], border: Any) -> None:
    """x = -m omega^2/k, y = b omega/k: differences of the root of the border, in floats of many digits."""
    [x] = hs.sensitivity(shunted(100, "0.1", "0.7", jnd)).crossings
    assert [p.name for p in x.parameters] == ["k", "m", "b"]
    with mp.workdps(30):
        point = {"k": mp.mpf(100), "m": mp.mpf("0.1"), "b": mp.mpf("0.7")}

        def root(**values: Any) -> Any:
            now = point | values
            return mp.findroot(lambda w: border(now["m"] * w**2 / now["k"], now["b"] * w / now["k"]), float(x.omega))

        assert float(x.omega) == pytest.approx(float(root()), rel=1e-12)
        for p in x.parameters:
            known = mp.diff(lambda v, name=p.name: root(**{name: v}), point[p.name])
            assert float(p.derivative) == pytest.approx(float(known), rel=1e-9)  # type: ignore[arg-type]
            assert float(p.elasticity) == pytest.approx(float(known * point[p.name] / root()), rel=1e-9)  # type: ignore[arg-type]


def test_at_a_corner_of_a_region_several_limits_meet_and_beside_it_one_alone() -> None:
    """The corner (-1/10, 1/10) is met at 10 rad/s where b = 1."""
    square = {"shape": "polygon", "corners": [["0.1", "0.1"], ["-0.1", "0.1"], ["-0.1", "-0.1"], ["0.1", "-0.1"]]}
    [x] = hs.sensitivity(shunted(100, "0.1", 1, square)).crossings
    assert (float(x.omega), x.reason) == (10, "undefined: several limits of the region meet here")
    for b, known in (("0.9", {"k": HALF, "m": -HALF, "b": 0}), ("1.1", {"k": 1, "m": 0, "b": -1})):
        [x] = hs.sensitivity(shunted(100, "0.1", b, square)).crossings
        assert elasticities(x) == known


# --- where there is no derivative ------------------------------------------------------------------------------------

SPRING = environments.mass_spring_damper(k=100)
LAGGED = hs.Scene(SPRING, (effects.first_order_lag(10),), (0, 40), {"real": 0.9, "imag": 0.5})
"""r_r crosses at 30 rad/s; the imaginary part's peak, 1/2 at omega_c, touches its threshold."""
SOFT = hs.Scene(SPRING, (effects.compliance(k=900), effects.first_order_lag(50)), (0, 9))
WITHIN = "undefined: the display touches its threshold within the bandwidth"


@pytest.mark.parametrize(
    ("scene", "where", "reason"),
    [
        (shunted(100, "0.1", 1, {"real": 0.1, "imag": 0.2}), 10, ""),
        (shunted(100, "0.1", 2, {"real": 0.1, "imag": 0.2}), 10, "undefined: both ratios cross their thresholds here"),
        (
            shunted(100, "0.1", 0, 0.1, (0, 10)),
            10,
            "undefined: a ratio crosses its threshold at the very end of the band",
        ),
        (shunted(100, "0.1", 0, 0.1, (0, 9)), 9, ""),
        (shunted(100, "0.1", 0, 0.1, (10, 20)), 10, TOUCH),
        (LAGGED, 30, WITHIN),
        (LAGGED.with_band(11, 40), 30, ""),
        (LAGGED.with_band(0, 20), 20, WITHIN),
        (hs.Scene(SPRING, (effects.first_order_lag(1),), (0, 5), "0.5"), 1, WITHIN),  # r_r crosses where r_i touches
        (SOFT, 0, TOUCH),
    ],
)
def test_a_bandwidth_has_a_derivative_where_one_ratio_alone_ends_it_inside_the_band(
    scene: hs.Scene, where: float, reason: str
) -> None:
    found = hs.sensitivity(scene).bandwidth
    assert found is not None
    assert float(found.omega) == pytest.approx(where, abs=1e-12)
    assert found.reason == reason
    assert {p.derivative is None for p in found.parameters} == {bool(reason)}
    if where == 9:  # the end of the band, which nothing moves
        assert {p.name: float(p.derivative) for p in found.parameters} == dict.fromkeys("kmbc", 0.0)  # type: ignore[arg-type]


def test_without_a_bandwidth_there_is_none_that_moves() -> None:
    e = hs.sensitivity(shunted(100, "0.1", 0, 0.1, (11, 20)))
    assert (e.bandwidth, e.crossings, e.to_dict()["bandwidth"], e.certified) == (None, (), None, True)


def test_where_a_ratio_only_touches_what_matters_has_no_derivative_and_the_rest_does_not_move_it() -> None:
    found = hs.sensitivity(LAGGED)
    touch, cross = found.crossings
    assert (touch.kind, float(touch.omega)) == (hs.CrossingKind.TOUCHES, 10)
    assert {p.name: p.reason for p in touch.parameters} == {"k": "", "omega_c": TOUCH, "c_imag": TOUCH}
    assert [p.derivative is None for p in touch.parameters] == [False, True, True]
    assert float(touch["k"].derivative) == 0  # type: ignore[arg-type]
    assert elasticities(cross) == {"k": 0, "omega_c": 1, "c_real": 5}  # omega_c sqrt(c/(1 - c))
    row = found.to_dict()["crossings"][0]["parameters"][1]
    assert (row["derivative"], row["elasticity"], row["reason"]) == (None, None, TOUCH)
    assert "touches its threshold" in " ".join(str(found).split())


def test_from_a_triple_zero_a_frequency_moves_as_a_cube_root_and_has_no_derivative() -> None:
    """r_r is (10 + a (100 - w^2)^3)/k: at w = 10 it crosses 0.1, whatever a is; there (100 - w^2)^3 grows as k and c do."""
    effect = effects.shunt(Z="10 + a*(s^2 + 100)^3 + d*s", parameters={"a": "-0.0001", "d": "1"})
    found = hs.sensitivity(hs.Scene(SPRING, (effect,), (0, 40)))
    [triple] = [x for x in found.crossings if x.criterion.part is hs.Part.REAL and float(x.omega) == 10]
    assert {p.name: p.reason for p in triple.parameters} == {"k": STEEP, "c": STEEP, "a": "", "d": ""}
    assert (found.certified, float(triple["a"].derivative), float(triple["d"].derivative)) == (True, 0, 0)  # type: ignore[arg-type]
    for sign in (1, -1):  # what the threshold moves by is a (100 - w^2)^3
        moved = hs.evaluate(found.scene.with_values({"c": Rational(1, 10) + sign * Rational(1, 10**8)})).crossings
        near = min(float(x.omega) for x in moved if x.part is hs.Part.REAL and abs(float(x.omega) - 10) < 1)
        assert (100 - near**2) ** 3 == pytest.approx(-sign * 1e-2, rel=1e-6)


def test_where_both_ratios_cross_at_once_the_headline_tells_what_moves_either() -> None:
    """r_r = m w^2/k, r_i = b w/k: the first moves with sqrt(k/m), the second with k/b."""
    headline = str(hs.sensitivity(shunted(100, "0.1", 1, 0.1))).partition("Crossing of")[0]
    first, _, second = headline.partition("Moved most by")[2].partition("r_i")
    assert [x in first for x in ("r_r", "0.5000", "1.000")] == [True, True, False]
    assert [x in second for x in ("0.5000", "1.000")] == [False, True]


def test_at_zero_a_flat_ratio_has_no_derivative_by_what_it_depends_on() -> None:
    [first, *_] = hs.sensitivity(SOFT).crossings
    assert float(first.omega) == 0
    assert {p.name: p.reason for p in first.parameters if p.derivative is None} == {
        x: FLAT for x in ("k_compliance", "k", "c") if x in {p.name for p in first.parameters}
    }


# --- derivatives from one side ---------------------------------------------------------------------------------------

NEAR = Rational(1, 10**12)


def formula(H: str, **parameters: float | str) -> hs.Scene:
    """An environment as written, alone, from 5 to 15 rad/s: Re H changes its sign at 10 rad/s."""
    return hs.Scene(environments.expression(H, parameters=parameters), (), (5, 15))


def filtered(zeta: object, band: tuple[int, int] = (0, 100), omega_n: str = "80 rad/s") -> hs.Scene:
    env = environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    return hs.Scene(env, (effects.second_order_lowpass(omega_n, zeta),), band)


def beside_a_mass(low: int, high: int) -> hs.Scene:
    """r_r = m omega^2/k meets 1/10 at 10 rad/s."""
    return hs.Scene(SPRING, (effects.shunt(m="0.1"),), (low, high))


IN_HZ = 20 * pi
MEETINGS = {
    "a pole moves with its frequency": (filtered(0), "perceived", 80, "omega_n", "", 1),
    "a pole at a frequency in Hz moves with it": (filtered(0, omega_n="10 Hz"), "perceived", IN_HZ, "omega_n", "", 1),
    "a pole at a frequency in Hz does not move with a mass": (filtered(0, omega_n="10 Hz"), "perceived", IN_HZ, "m", "", 0),
    "a crossing at the least damping": (filtered(0), "crossings", 24.828, "zeta", "above", 27.714),
    "a parameter that does not matter, at its least value": (filtered(0), "environment", 7.4536, "zeta", "", 0),
    "a delay at its least value": (
        hs.Scene(environments.kelvin_voigt(100, 5), (effects.first_order_lag(40), effects.delay(0)), (0, 30)),
        "crossings", 8.5, "tau", "above", None,
    ),
    "a crossing that enters the band at its end": (beside_a_mass(0, 10), "crossings", 10, "m", "above", -50),
    "a crossing that leaves the band at its end": (beside_a_mass(0, 10), "crossings", 10, "k", "below", 1 / 20),
    "a crossing that leaves the band at its start": (beside_a_mass(10, 20), "crossings", 10, "m", "below", -50),
    "a crossing that enters the band at its start": (beside_a_mass(10, 20), "crossings", 10, "k", "above", 1 / 20),
    "a crossing that would leave the band upward alone": (
        hs.Scene(environments.kelvin_voigt(100, "7.5"), (effects.shunt(m="0.125"), effects.delay(0)), (0, 10)),
        "crossings", 10, "tau", "leaves", None,
    ),
}  # fmt: skip


def frequencies(e: hs.Evaluation, kind: str, near: float) -> list[str]:
    """Of that kind and within 0.1 rad/s, to 40 digits."""
    listed = [x.omega for x in e.crossings] if kind == "crossings" else getattr(e, f"changeovers_{kind}")
    found = [getattr(x, "omega", x) for x in listed]
    return [x.digits(40) for x in found if abs(float(x) - near) < 0.1]


@pytest.mark.dear(
    "a crossing at the least damping", "a delay at its least value", "a pole at a frequency in Hz moves with it"
)
@pytest.mark.parametrize("name", MEETINGS)
def test_a_derivative_from_one_side_is_the_slope_of_certified_frequencies_there(name: str) -> None:
    """And where there is none, no single frequency is seen to move away from here on either side."""
    scene, kind, near, parameter, side, expected = MEETINGS[name]
    found = hs.sensitivity(scene)
    rows = found.crossings if kind == "crossings" else getattr(found, f"changeovers_{kind}")
    x = min(rows, key=lambda row: abs(float(row.omega) - near))
    row, value = x[parameter], next(p.value for p in scene.parameters if p.symbol.name == parameter)
    here, seen = Rational(x.omega.digits(40)), {}
    for sign, where in ((-1, "below"), (1, "above")):
        try:
            beside = changed(scene, parameter, value + sign * NEAR)
        except hs.SceneError:  # below the least value there is no scene
            continue
        seen[where] = [(Rational(text) - here) / (sign * NEAR) for text in frequencies(beside, kind, float(here))]
    alone = {where: float(found[0]) for where, found in seen.items() if len(found) == 1 and abs(found[0]) < 10**6}
    if row.derivative is None:
        assert (expected, row.side) == (None, "")
        assert side in row.reason
        assert not alone
        return
    derivative = float(row.derivative)
    assert row.side == side
    assert row.reason.startswith(f"from {side}" if side else "")
    assert alone == pytest.approx(dict.fromkeys([side] if side else list(seen), derivative), abs=1e-8, rel=1e-9)
    if expected is not None:
        assert derivative == pytest.approx(expected, rel=1e-4)


@pytest.mark.slow
def test_one_sided_derivatives_are_said_in_text_and_document() -> None:
    found = hs.sensitivity(filtered(0))
    assert " above" in str(found)
    crossing = next(x for x in found.to_dict()["crossings"] if abs(x["omega"] - 24.828) < 0.01)
    row = next(x for x in crossing["parameters"] if x["name"] == "zeta")
    assert (row["side"], row["reason"]) == ("above", "from above; below there is no scene")


def test_where_several_zeros_and_poles_meet_it_is_undecided_how_they_move() -> None:
    """A pole without damping: a zero above the line on a double zero below it; it stays where its own frequency is."""
    found = min(hs.sensitivity(filtered(0)).changeovers_perceived, key=lambda x: abs(float(x.omega) - 80))
    assert (found["zeta"].derivative, found["zeta"].reason[:9]) == (None, "undecided")


# --- the slope of one factor -----------------------------------------------------------------------------------------

PARAMETER, OTHER = Symbol("p", real=True), Symbol("b", real=True)
RING = PolynomialRing(omega, [PARAMETER, OTHER])


def equation(expression: Expr) -> Equation:
    return Equation(RING, RING.convert(expression.expand()).numerator)


@pytest.mark.parametrize(("p", "b"), [(2, 9), (Rational(1, 3), 5), (Rational(7, 2), 3)])
def test_a_slope_is_minus_one_derivative_over_the_other_and_clear_where_neither_is_0(p: Any, b: int) -> None:
    """omega^2 = b p: omega/(2 p), at irrational frequencies too."""
    w = SquareRoot(ExactNumber(Rational(p) * b))
    values = ((omega, w), (PARAMETER, ExactNumber(Rational(p))), (OTHER, ExactNumber(Integer(b))))
    found, same = (Slope(equation(n * (omega**2 - OTHER * PARAMETER)).slope(PARAMETER), values) for n in (1, 3))
    assert float(found) == pytest.approx(float(w) / (2 * float(p)), rel=1e-15)
    assert found.digits(40) == same.digits(40)
    assert found.is_clear()
    still = omega**2 - b * Rational(p) + (PARAMETER - Rational(p)) ** 2
    assert not Slope(equation(still).slope(PARAMETER), values).is_clear()


# --- as a user has it ------------------------------------------------------------------------------------------------


def test_the_command_line_prints_the_document_and_draws(call: Any, tmp_path: Path) -> None:
    status, out, _ = call("sensitivity", "fu2019", "--json", "--digits", "30")
    document = json.loads(out)
    assert (status, document["schema"]) == (0, "haptisym.sensitivity/1")
    row = document["crossings"][0]["parameters"][3]
    assert (row["path"], row["unit"]) == ("effects.filter.omega_n", "rad/s")
    assert len(row["digits"]["elasticity"]) == 31
    assert document["bandwidth"]["omega"] == document["crossings"][0]["omega"]
    assert {name: len(own) for name, own in document["changeovers"].items()} == {"environment": 1, "perceived": 1}
    status, _, err = call("sensitivity", "fu2019", "--figure", str(tmp_path / "bars.doc"))
    assert (status, "must end in" in err) == (2, True)
