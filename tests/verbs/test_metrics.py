"""The measures of transparency against frequency responses, terminations and simulations of others."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from marks import QUICK_SCENES, often
from scipy import signal
from scipy.integrate import solve_ivp
from sympy import Expr, Rational, lambdify

import haptisym as hs
from haptisym import effects, environments
from haptisym.verbs.metrics.freeresponse import ComplexPair, _ratio_check
from haptisym.verbs.metrics.measured import Measured
from haptisym.verbs.metrics.metric import Metrics

STICK = environments.mass_spring_damper("1.8", 15, 100)
LOWPASS = effects.second_order_lowpass(80, Rational(1, 2))
LOOSE = hs.Scene(
    environments.kelvin_voigt(100, 3),
    (LOWPASS, effects.compliance(k=5000, b=4), effects.shunt(m="0.1", b="0.6")),
    (0, 40),
)


def stick(w: np.ndarray) -> np.ndarray:
    return -1.8 * w**2 + 15j * w + 100


def lowpass(w: np.ndarray) -> np.ndarray:
    return 6400 / (6400 - w**2 + 80j * w)


def loose(w: float) -> np.ndarray:
    """The chain matrix of LOOSE at a frequency, multiplied by NumPy."""
    s = 1j * w
    filtered = np.array([[lowpass(w), 0], [0, 1]])
    joint = np.array([[1, 0], [1 / (5000 + 4 * s), 1]])
    device = np.array([[1, 0.1 * s**2 + 0.6 * s], [0, 1]])
    return device @ joint @ filtered


def value(m: Metrics, name: str, start: str) -> float:
    [found] = [x.value for x in m[name].values if x.what.startswith(start)]
    return float(found)  # type: ignore[arg-type]


def at(form: Expr, w: float) -> complex:
    return complex(lambdify(hs.s, form)(1j * w))


def numbers(scene: hs.Scene, form: Expr) -> Expr:
    return form.subs({p.symbol: p.value for p in scene.parameters})


# Ratio and relative distortion


def test_the_3_db_edge_is_where_scipy_sees_half_the_power() -> None:
    [edge] = [x for x in hs.metrics(hs.load_scene("fu2019"))["transmitted impedance ratio"].values if "edge" in x.what]
    low, high = (float(x) for x in edge.value.enclosure(12))  # type: ignore[union-attr]
    _, response = signal.freqs([6400], [1, 80, 6400], [low, high])
    assert abs(response[0]) ** 2 > 0.5 > abs(response[1]) ** 2
    assert high - low < 1e-10


def test_a_resonant_filter_has_three_edges_and_the_set_between_them() -> None:
    found = hs.metrics(hs.load_scene("undamped-resonance"))["transmitted impedance ratio"]
    *edges, inside = found.values
    assert [x.what for x in edges] == ["+3 dB edge, rising", "+3 dB edge, falling", "-3 dB edge, falling"]
    assert (
        [[round(float(end.omega), 2) for end in (x.low, x.high)] for x in inside.value]
        == [  # type: ignore[union-attr]
            [0, round(float(edges[0].value), 2)],  # type: ignore[arg-type]
            [round(float(x.value), 2) for x in edges[1:]],  # type: ignore[arg-type]
        ]
    )


def test_a_delay_alone_has_no_edge() -> None:
    found = hs.metrics(hs.Scene(STICK, (effects.delay("5 ms"),)))["transmitted impedance ratio"]
    assert found.verdict == "no 3 dB edge"


def test_the_relative_distortion_crosses_c_where_the_physics_says() -> None:
    m = hs.metrics(hs.load_scene("fu2019"))
    [band] = m["relative distortion"].values[0].value  # type: ignore[misc, union-attr]
    low, high = (float(x) for x in band.high.omega.enclosure(12))  # type: ignore[union-attr]
    assert abs(lowpass(np.array(low)) - 1) < 0.1 < abs(lowpass(np.array(high)) - 1)
    grid = np.linspace(0, 15, 4001)
    assert value(m, "relative distortion", "largest") == pytest.approx(abs(lowpass(grid) - 1).max(), rel=1e-9)


@given(st.integers(20, 300), st.integers(5, 200), st.integers(1, 99))
def test_within_the_disc_the_jnd_is_kept(k: int, cutoff: int, gramme: int) -> None:
    """|dH/H_env| <= c is enough for both ratios, whatever the scene."""
    scene = hs.Scene(
        environments.mass_spring_damper(1, 6, k),
        (effects.first_order_lag(cutoff), effects.shunt(m=Rational(gramme, 1000))),
    )
    m = Measured(hs.evaluate(scene))
    for x in m.within:
        middle = (float(x.low.omega) + float(x.high.omega)) / 2
        assert any(float(y.low.omega) <= middle <= float(y.high.omega) for y in m.evaluation.transparent)


# The two-port


@pytest.mark.parametrize("w", [0.7, 11.0, 39.0])
def test_the_closed_forms_are_those_of_the_multiplied_matrices(w: float) -> None:
    m = hs.metrics(LOOSE)
    a, b, c, d = loose(w).ravel()
    H = 100 + 3j * w
    det = a * d - b * c
    least, most, width = (numbers(LOOSE, x.value) for x in m["impedance range"].forms)  # type: ignore[arg-type]
    sensitivity = numbers(LOOSE, m["sensitivity"].forms[0].value)  # type: ignore[arg-type]
    gamma = numbers(LOOSE, m["transmitted impedance ratio"].forms[0].value)  # type: ignore[arg-type]
    expected = (b / d, a / c, det / (c * d), det / (c * H + d) ** 2, (a * H + b) / (c * H + d) / H)
    for form, witness in zip((least, most, width, sensitivity, gamma), expected, strict=True):
        assert at(form, w) == pytest.approx(witness, rel=1e-4)  # long numbers are shown to six digits


def test_the_limits_are_what_is_felt_of_nothing_and_of_a_rock() -> None:
    m = hs.metrics(LOOSE)
    for k, start in ((Rational(1, 10**9), "|Z_min|"), (10**12, "|Z_max|")):
        felt = hs.distort(environments.kelvin_voigt(k, 0), *LOOSE.effects).compile()([40.0])
        size = np.hypot(felt.perceived_real, felt.perceived_imag)[0]
        assert value(m, "impedance range", f"{start} at high end") == pytest.approx(size, rel=1e-6)


def test_the_sensitivity_is_the_largest_of_finite_differences() -> None:
    grid, step = np.linspace(0, 40, 801), 1e-3
    changed = []
    for w in grid:
        a, b, c, d = loose(w).ravel()
        H = 100 + 3j * w
        changed.append(
            abs((a * (H + step) + b) / (c * (H + step) + d) - (a * (H - step) + b) / (c * (H - step) + d)) / (2 * step)
        )
    assert value(hs.metrics(LOOSE), "sensitivity", "largest") == pytest.approx(max(changed), rel=1e-5)


# Passive


def worst(w: float, matrix: np.ndarray) -> float:
    """The least Re of force over velocity at the hand with any of many passive environments."""
    a, b, c, d = matrix.ravel()
    angles = np.linspace(-np.pi / 2, np.pi / 2, 2001)[1:-1]
    z = np.concatenate([1j * np.tan(angles), 1e-3 + 1j * np.tan(angles), [0.0, 1.0, 100.0]])  # force over velocity
    H = 1j * w * z
    return float(((a * H + b) / (c * H + d) / (1j * w)).real.min())


def test_where_the_criterion_holds_no_passive_environment_makes_the_hand_feel_an_active_one() -> None:
    """A lag beside enough damping is absolutely stable at low frequencies only."""
    scene = hs.Scene(
        environments.kelvin_voigt(100, 3), (effects.compliance(k=400, b=30), LOWPASS, effects.shunt(b=4)), (0, 60)
    )

    def matrix(w: float) -> np.ndarray:
        joint = np.array([[1, 0], [1 / (400 + 30j * w), 1]])
        return np.array([[1, 4j * w], [0, 1]]) @ np.array([[lowpass(w), 0], [0, 1]]) @ joint

    bands = Measured(hs.evaluate(scene)).llewellyn
    assert bands is not None
    seen = 0
    for w in np.linspace(0.37, 59.7, 60):
        holds = any(float(x.low.omega) <= w <= float(x.high.omega) for x in bands)
        edge = min((abs(float(end.omega) - w) for x in bands for end in (x.low, x.high)), default=60)
        if edge > 0.3:
            seen += holds
            assert (worst(w, matrix(w)) >= -1e-9) == holds, w
    assert 0 < seen < 60


def test_a_lossless_link_and_a_passive_joint_are_absolutely_stable_everywhere() -> None:
    for effect in (effects.wave_variables(10, "20 ms"), effects.compliance(k=800, b=3), effects.shunt(m="0.2", b=1)):
        m = Measured(hs.evaluate(hs.Scene(environments.kelvin_voigt(100, 3), (effect,), (0, 20))))
        [band] = m.llewellyn or ()
        assert (float(band.low.omega), float(band.high.omega)) == (0, 20)


def test_the_passive_bands_are_the_rest_of_the_active_ones() -> None:
    e = hs.evaluate(hs.load_scene("undamped-resonance"))
    m = Measured(e)
    for w in (5.0, 9.99, 10.01, 30.0):
        passive = any(float(x.low.omega) <= w <= float(x.high.omega) for x in m.passive)
        assert passive == (w > 10)  # Re of 100 - w^2 through a filter that lags


def test_a_two_port_without_d_has_no_hybrid_matrix() -> None:
    gyrator = effects.two_port(A="0", B="-10*s", C="1/(10*s)", D="0")
    found = hs.metrics(hs.Scene(environments.kelvin_voigt(100, 3), (gyrator,)))
    assert "D = 0" in found["absolute stability"].verdict
    assert found["impedance range"].forms[0].value is None


# Effective stiffness, mass, damping


def test_the_effective_properties_at_the_crossings_are_those_of_the_response() -> None:
    found = Measured(hs.evaluate(hs.load_scene("fu2019"))).effective
    assert len(found) == 4
    for omega, row in found:
        w = float(omega)
        H = stick(np.array(w)) * lowpass(np.array(w))
        assert float(row["k"]) == pytest.approx(H.real, rel=1e-12)  # type: ignore[arg-type]
        if w:
            assert float(row["m"]) == pytest.approx(-H.real / w**2, rel=1e-12)  # type: ignore[arg-type]
            assert float(row["b"]) == pytest.approx(H.imag / w, rel=1e-12)  # type: ignore[arg-type]
    assert found[0][1]["m"] is None


# Free response


def measured(m: float, b: float, k: float) -> tuple[float, float, list[float]]:
    """First zero crossing, period and overshoots of a released stick, from a simulation in time."""

    def zero(_: float, x: np.ndarray) -> float:
        return float(x[0])

    def turn(_: float, x: np.ndarray) -> float:
        return float(x[1])

    run = solve_ivp(
        lambda _, x: [x[1], -(b * x[1] + k * x[0]) / m], (0, 6), [1.0, 0.0], events=[zero, turn], rtol=1e-11, atol=1e-13
    )
    crossings, turns = run.t_events[0], run.y_events[1][:, 0]
    return crossings[0], crossings[2] - crossings[0], [abs(x) for x in turns if abs(x) < 0.999]


def test_the_free_response_is_the_simulated_one() -> None:
    scene = hs.Scene(STICK, (effects.shunt(m="0.1", b="0.4"),))  # m, b and k of what is felt are known
    found = hs.metrics(scene)["free response"].values
    for side, row in (("reference", (1.8, 15.0, 100.0)), ("value", (1.9, 15.4, 100.0))):
        first, period, overshoots = measured(*row)
        shown = [float(getattr(x, side)) for x in found]
        assert shown[:3] == pytest.approx([first, period, overshoots[0]], rel=1e-6)
        assert shown[-1] == sum(x > 0.05 for x in overshoots)


@pytest.mark.parametrize(
    ("mass", "kept"),
    [("0.1", {"P_0": True, "P_1": True}), ("1.2", {"P_0": False, "P_1": True}), ("1.6", {"P_0": False, "P_1": False})],
)
def test_tolerances_break_one_after_the_other(mass: str, kept: dict[str, bool]) -> None:
    found = hs.metrics(hs.Scene(STICK, (effects.shunt(m=mass),)))["free response"].values
    assert {x.what[:3]: x.kept for x in found[:2]} == kept
    for x in found[:2]:
        off = abs(float(x.value) / float(x.reference) - 1)  # type: ignore[arg-type]
        assert x.kept == (off < float(x.tolerance[:2]) / 100)


BEYOND = {"never negative": {1}, "negative again and again": {1, -1}}
"""What is said of Im H_perc far out, and which signs it then has there."""


@pytest.mark.parametrize(
    "name", ["fu2019", pytest.param("position-force-teleoperation", marks=pytest.mark.slow), "sidestick"]
)
def test_what_is_said_of_passive_hands_is_what_samples_show(name: str) -> None:
    e = hs.evaluate(name)
    rows = {x.what: x.value for x in hs.metrics(name)["passivity"].values}
    [(looked, active)] = [(what, x) for what, x in rows.items() if "looked at up to" in what]
    assert len(active) == len(e.passivity.active)  # type: ignore[arg-type]
    high = float(looked.split()[-2])
    far, near = (
        hs.sampled(name, high * x).H.imag for x in (np.geomspace(1.01, 30, 4000), np.linspace(0.001, 0.999, 4000))
    )
    assert {int(x) for x in np.sign(far)} == BEYOND[str(rows["Im H_perc beyond that"])]
    assert bool((near < 0).any()) == bool(active)
    assert rows["every passive hand"] == ("does not hold" if active else "holds")
    assert rows["force stable under imposed motion"] == "yes"


@pytest.mark.parametrize("places", [3, 14, 18, 30, 60])
def test_how_near_a_period_comes_to_its_tolerance_does_not_matter(places: int) -> None:
    """Poles at -1 +- j 6/5 and -1 +- j (1 + x) : periods that differ by a fifth at x = 0, and by less or more beside it."""
    for sign in (-1, 1):
        w = 1 + sign * Rational(1, 10**places)
        env, perc = (ComplexPair((1 + x**2, Rational(2), Rational(1))) for x in (Rational(6, 5), w))
        check = _ratio_check("P_1", env.period, perc.period, 20)
        assert check.passes is (sign > 0)
        assert _ratio_check("P_1", perc.period, env.period, 20).passes is True


def test_the_test_is_blind_to_a_filter_in_series_and_says_so() -> None:
    for effect in (LOWPASS, effects.delay("12.5 ms")):
        m = hs.metrics(hs.Scene(STICK, (effect,)))
        assert m["free response"].verdict.startswith("passes; blind")
        assert any("blind" in note for note in m.notes)
        assert m.evaluation.crossings


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (hs.Scene(environments.kelvin_voigt(100, 3), (LOWPASS,)), "nothing swings"),
        (hs.Scene(environments.mass_spring_damper(m=1, k=9), (LOWPASS,)), "does not die out"),
        (hs.Scene(STICK, (effects.delay("5 ms"), effects.shunt(m="0.1"))), "delays"),
        (hs.load_scene("two-mass-resonance"), "times as slowly"),
        (hs.load_scene("organ-tissue"), "s^alpha"),
        (hs.Scene(environments.expression("(s^2 + s + 9)^2"), ()), "repeated"),
    ],
)
def test_where_the_test_is_not_offered_the_reason_is_given(scene: hs.Scene, reason: str) -> None:
    found = hs.metrics(scene)["free response"]
    assert found.values == ()
    assert found.verdict.startswith("not offered")
    assert reason in found.verdict


def test_a_heavy_filtered_device_fails_the_free_response_while_the_jnd_is_kept() -> None:
    scene = hs.load_scene("sidestick").with_band(0, 20)
    m = hs.metrics(scene)
    assert not m.evaluation.crossings
    assert m["free response"].verdict == "fails"
    assert any("breaks its tolerances" in note for note in m.notes)


# Output


def test_the_document_of_the_papers_example(call) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call("metrics", "fu2019", "--json")
    document = json.loads(out)
    assert (status, err, document["schema"]) == (0, "", "haptisym.metrics/1")
    assert document["jnd"]["bandwidth"] == 7.978916790174708
    assert [x["name"] for x in document["metrics"]] == [
        "transmitted impedance ratio",
        "relative distortion",
        "impedance range",
        "sensitivity",
        "passivity",
        "absolute stability",
        "effective impedance",
        "free response",
    ]
    for metric in document["metrics"]:
        assert {"name", "formula", "values", "unit", "source", "evidence", "verdict"} <= set(metric)
        assert metric["source"]
        assert metric["evidence"]
    assert document["metrics"][0]["values"][0]["value"] == pytest.approx(80 * ((1 + 5**0.5) / 2) ** 0.5, rel=1e-14)
    assert "recalled, not verified" in document["metrics"][3]["evidence"]


@pytest.mark.slow
def test_text_latex_and_figure(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    target = tmp_path / "m.svg"
    status, out, _ = call("metrics", "sidestick", "--figure", str(target))
    assert status == 0
    assert target.read_text(encoding="utf-8").startswith("<?xml")
    assert out == str(hs.metrics(hs.load_scene("sidestick")))
    assert max(map(len, out.splitlines())) <= 96
    for words in (
        "recalled, not verified",
        "tolerance 10 % of A_1: NOT KEPT",
        "Z_min(s) = B/D = m_residual_inertia s^2",
    ):
        assert words in out
    _, tex, _ = call("metrics", "sidestick", "--to", "latex")
    assert tex.count("{") == tex.count("}")
    assert r"Z_{\mathrm{min}}" in tex


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("fu2091",), ["fu2091", "fu2019"]),
        (("palpation-device",), ["--environment"]),
        (("fu2019", "--figure", "m.gif"), ["m.gif", ".svg"]),
        (("fu2019", "--to", "word"), ["word", "latex"]),
    ],
)
def test_wrong_calls_are_status_2(call, arguments: tuple[str, ...], words: list[str]) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call("metrics", *arguments)
    assert (status, out) == (2, "")
    for word in words:
        assert word in err
    assert "Traceback" not in err


OTHERS = ("delayed-spring", "stick-with-friction", "organ-tissue", "wave-variable-link", "sampled-wall")


@pytest.mark.parametrize("name", often(OTHERS, QUICK_SCENES.__contains__))
def test_scenes_that_are_not_rational_are_measured_too(name: str) -> None:
    m = hs.metrics(hs.load_scene(name))
    assert len(m.metrics) == 8
    json.dumps(m.to_dict())
