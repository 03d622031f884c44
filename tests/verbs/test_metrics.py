"""The measures of transparency against complex arithmetic, terminations and simulations, and free responses against closed forms.

What a fit to a movement reports against SciPy's quadrature and NumPy's least squares; its closed forms: derivation
21_fitted_movement.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import cos, exp, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import assume, given
from hypothesis import strategies as st
from marks import QUICK_SCENES, UNDAMPED, often
from scipy import signal
from scipy.integrate import quad
from scipy.optimize import brentq
from sympy import Rational, lambdify

import haptisym as hs
from haptisym import effects, environments
from haptisym.cli import app
from haptisym.verbs.metrics.freeresponse import FreeResponse, free_response
from haptisym.verbs.metrics.metric import Measured, Metric, Metrics, MetricValue

STICK = environments.mass_spring_damper("1.8", 15, 100)


LOWPASS = effects.second_order_lowpass(80, Rational(1, 2))


def stick(w: np.ndarray) -> np.ndarray:
    return -1.8 * w**2 + 15j * w + 100


def lowpass(w: np.ndarray) -> np.ndarray:
    return 6400 / (6400 - w**2 + 80j * w)


def value(m: Metrics, name: str, start: str) -> float:
    [found] = [x.value for x in m[name].values if x.what.startswith(start)]
    return float(found)  # type: ignore[arg-type]


# Ratio and relative distortion


@pytest.mark.slow
def test_the_3_db_edge_is_where_scipy_sees_half_the_power() -> None:
    [edge] = [x for x in hs.metrics(hs.load_scene("fu2019"))["transmitted impedance ratio"].values if "edge" in x.what]
    low, high = (float(x) for x in edge.value.enclosure(12))  # type: ignore[union-attr]
    _, response = signal.freqs([6400], [1, 80, 6400], [low, high])
    assert abs(response[0]) ** 2 > 0.5 > abs(response[1]) ** 2
    assert high - low < 1e-10


def test_a_resonant_filter_has_three_edges_and_the_set_between_them() -> None:
    found = hs.metrics(hs.load_scene(UNDAMPED))["transmitted impedance ratio"]
    *edges, inside = found.values
    assert [x.what for x in edges] == ["+3 dB edge, rising", "+3 dB edge, falling", "-3 dB edge, falling"]
    assert (
        [[round(float(end.omega), 2) for end in (x.low, x.high)] for x in inside.value]
        == [  # type: ignore[union-attr]
            [0, round(float(edges[0].value), 2)],  # type: ignore[arg-type]
            [round(float(x.value), 2) for x in edges[1:]],  # type: ignore[arg-type]
        ]
    )


@pytest.mark.slow
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
    assume(m.within)
    for x in m.within:
        middle = (float(x.low.omega) + float(x.high.omega)) / 2
        assert any(float(y.low.omega) <= middle <= float(y.high.omega) for y in m.evaluation.transparent)


# The two-port


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
    e = hs.evaluate(hs.load_scene(UNDAMPED))
    m = Measured(e)
    for w in (5.0, 9.99, 10.01, 30.0):
        passive = any(float(x.low.omega) <= w <= float(x.high.omega) for x in m.passive)
        assert passive == (w > 10)  # Re of 100 - w^2 through a filter that lags


def test_a_two_port_without_d_has_no_hybrid_matrix() -> None:
    gyrator = effects.two_port(A="0", B="-10*s", C="1/(10*s)", D="0")
    found = hs.metrics(hs.Scene(environments.kelvin_voigt(100, 3), (gyrator,)))
    assert "D = 0" in found["absolute stability"].verdict
    assert found["impedance range"].forms[0].value is None


# Free response


BEYOND = {"never negative": {1}, "negative again and again": {1, -1}}


"""What is said of Im H_perc far out, and which signs it then has there."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["fu2019", pytest.param("position-force-teleoperation", marks=pytest.mark.slow), "sidestick"]
)
def test_what_is_said_of_passive_hands_is_what_samples_show(name: str) -> None:
    e = hs.evaluate(name)
    rows = {x.what: x.value for x in hs.metrics(name)["passivity"].values}
    [(looked, active)] = [(what, x) for what, x in rows.items() if "searched up to" in what]
    assert len(active) == len(e.passivity.active)  # type: ignore[arg-type]
    high = float(looked.split()[-2])
    far, near = (
        hs.sampled(name, high * x).H.imag for x in (np.geomspace(1.01, 30, 4000), np.linspace(0.001, 0.999, 4000))
    )
    assert {int(x) for x in np.sign(far)} == BEYOND[str(rows["Im H_perc beyond that"])]
    assert bool((near < 0).any()) == bool(active)
    assert rows["any passive operator"] == ("does not hold" if active else "holds")
    assert rows["stable under prescribed motion"] == "yes"


@pytest.mark.slow
def test_a_heavy_filtered_device_fails_the_free_response_while_the_jnd_is_kept() -> None:
    scene = hs.load_scene("sidestick").with_band(0, 20)
    m = hs.metrics(scene)
    assert not m.evaluation.crossings
    assert m["free response, aeroplanes"].verdict == "fails"
    assert any("exceeds its tolerances" in note for note in m.notes)


# Output


@pytest.mark.slow
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
        "free response, aeroplanes",
        "free response, helicopters",
    ]
    for metric in document["metrics"]:
        assert {"name", "formula", "values", "unit", "source", "evidence", "verdict"} <= set(metric)
        assert metric["source"]
        assert metric["evidence"]
    assert document["metrics"][0]["values"][0]["value"] == pytest.approx(80 * ((1 + 5**0.5) / 2) ** 0.5, rel=1e-14)
    assert "derived" in document["metrics"][3]["evidence"]
    assert not any("recalled" in x["evidence"] for x in document["metrics"])


OTHERS = ("delayed-spring", "stick-with-friction", "organ-tissue", "wave-variable-link", "sampled-wall")


@pytest.mark.dear("stick-with-friction")
@pytest.mark.parametrize("name", often(OTHERS, QUICK_SCENES.__contains__))
def test_scenes_that_are_not_rational_are_measured_too(name: str) -> None:
    m = hs.metrics(hs.load_scene(name))
    assert len(m.metrics) == 9
    json.dumps(m.to_dict())


LAG, LOWPASS = effects.first_order_lag(20), effects.second_order_lowpass(80, Rational(1, 2))


KV = environments.kelvin_voigt(100, 3)


SCENES: dict[str, hs.Scene] = {
    "joint": hs.Scene(KV, (LOWPASS, effects.compliance(k=800, b=4), effects.shunt(m="0.1", b="0.6")), (0, 40)),
    "filter": hs.Scene(STICK, (LOWPASS,), (0, 15), {"real": 0.25, "imag": 0.2}),
    "twist": hs.Scene(
        environments.kelvin_voigt("2 N*m/rad", "0.1 N*m*s/rad"), (effects.compliance(k="30 N*m/rad"), effects.shunt(b="0.4")), (1, 9)
    ),
    "slave": hs.Scene(KV, (effects.position_force_teleoperator("0.4", "0.6", 8, 900),), (0, 30)),
    "rendered": hs.Scene(
        STICK, (effects.compliance(k=3000), effects.shunt(m="0.05")), ("1/2", 25), {"shape": "ellipse", "real": 0.2, "imag": 0.1},
        rendered=environments.mass_spring_damper("1.7", 17, 98),
    ),
}  # fmt: skip


@cache
def measured(name: str) -> Metrics:
    return hs.metrics(SCENES[name])


@cache
def compiled(name: str) -> list[Any]:
    """The entries of every effect's matrix, of H_env and of what is rendered, as functions of s."""
    scene = SCENES[name]
    forms = [x for effect in scene.effects for x in effect.matrix]
    return [lambdify(hs.s, x, "numpy") for x in (*forms, scene.environment.H, (scene.rendered or scene.environment).H)]


def ports(name: str, w: Any) -> tuple[Any, ...]:
    """A, B, C, D by multiplied matrices, and H of the environment and of what is rendered."""
    s = 1j * np.asarray(w, dtype=float)
    values = [np.broadcast_to(np.asarray(f(s), dtype=complex), s.shape) for f in compiled(name)]
    *entries, env, rendered = values
    a, b, c, d = np.ones_like(s), 0 * s, 0 * s, np.ones_like(s)
    for p, q, r, t in zip(*[iter(entries)] * 4, strict=True):
        a, b, c, d = p * a + q * c, p * b + q * d, r * a + t * c, r * b + t * d
    return a, b, c, d, env, rendered


def points(scene: hs.Scene, count: int = 5) -> list[float]:
    low, high = map(float, scene.band)
    return (low + (high - low) * (np.arange(count) + 0.37) / count).tolist()


@pytest.mark.few("filter")
@pytest.mark.parametrize("name", SCENES)
def test_every_closed_form_has_the_value_of_complex_arithmetic_in_numbers_and_in_symbols(name: str) -> None:
    scene = SCENES[name]
    forms = Measured(hs.evaluate(scene)).forms
    known = {p.symbol: float(p.value) for p in scene.parameters}
    for w in points(scene, 1):
        a, b, c, d, env, rendered = ports(name, w)
        felt = (a * rendered + b) / (c * rendered + d)
        det = a * d - b * c
        expected = {
            "Gamma": felt / env, "Theta": felt / env - 1, "Z_min": b / d, "Z_max": a / c if c else None, "Z_width": det / c / d if c else None,
            "dH_perc/dH_env": det / (c * rendered + d) ** 2, "g": det / d**2, "k_perc": felt.real, "m_perc": -felt.real / w**2,
            "b_perc": felt.imag / w,
        }  # fmt: skip
        for form in forms(*expected):
            for found in (form.numeric, form.symbolic):
                if found is None:
                    assert expected[form.name] is None or (found is form.symbolic and form.symbols is None)
                    continue
                value = complex(lambdify([hs.s, hs.omega, *known], found.expression())(1j * w, w, *known.values()))
                assert value == pytest.approx(expected[form.name], rel=1e-8)


def within(bands: Any, w: float) -> bool:
    return any(float(x.low.omega) <= w <= float(x.high.omega) for x in bands)


def between(scene: hs.Scene, *bands: Any, high: float | None = None) -> Iterator[float]:
    """Frequencies beside all ends of bands, and between them."""
    low, top = float(scene.band[0]), high or float(scene.band[1])
    ends = sorted({low, top, *(float(end.omega) for x in bands for one in x for end in (one.low, one.high))})
    for a, b in pairwise(ends):
        if b - a > 1e-6:
            yield from (a + (b - a) * share for share in (0.01, 0.5, 0.99))


def row(m: Metric, start: str) -> MetricValue:
    [found] = [x for x in m.values if x.what.startswith(start)]
    return found


@pytest.mark.few("rendered")
@pytest.mark.parametrize("name", SCENES)
def test_bands_and_largest_values_are_those_of_complex_arithmetic(name: str) -> None:
    scene, m = SCENES[name], measured(name)
    low, high = map(float, scene.band)
    inside = row(m["transmitted impedance ratio"], "within").value
    circle, passive = m["relative distortion"].values[0].value, m["passivity"].values[0].value
    kept = m["absolute stability"].values[0].value
    plain = scene.threshold.is_plain
    limit = min(scene.threshold.real, scene.threshold.imag)
    if plain:
        assert m["relative distortion"].values[0].what == f"at most {float(100 * limit):.6g} %"
        assert m["relative distortion"].verdict.startswith("where it is at most c neither")
    else:
        assert m["relative distortion"].values[0].what == "within the largest circle that the region holds"
        assert m["relative distortion"].verdict.startswith("where it is in that circle no change")
    for w in between(scene, circle, passive, kept):
        a, b, c, d, env, rendered = ports(name, w)
        felt, det = (a * rendered + b) / (c * rendered + d), a * d - b * c
        assert within(circle, w) == (abs(felt / env - 1) <= float(limit))
        assert within(passive, w) == (felt.imag >= 0)
        h11, h22, g = b / d, c / d, det / d**2
        lack = g.real - 2 * h11.imag * h22.imag
        p = h11.imag * h22.imag
        square = 4 * p * (p - g.real) - g.imag**2  # lack^2 - |g|^2
        holds = h11.imag >= -1e-12 and h22.imag <= 1e-12 and lack >= -1e-12 and square >= -1e-15 * abs(g) ** 2
        assert within(kept, w) == holds
    reach = 100 * high
    assert (
        row(m["transmitted impedance ratio"], "within 3 dB").what == "within 3 dB (up to 100 times the band's high end)"
    )
    edges = {float(x.value): x.what for x in m["transmitted impedance ratio"].values[:-1]}  # type: ignore[arg-type]
    for w in between(scene, inside, high=reach):
        a, b, c, d, env, rendered = ports(name, w)
        ratio = abs((a * rendered + b) / (c * rendered + d) / env)
        assert within(inside, w) == (0.5**0.5 <= ratio <= 2**0.5)
    for w, what in edges.items():
        before, after = (abs(_felt(name, x) / ports(name, x)[4]) for x in (w * (1 - 1e-6), w * (1 + 1e-6)))
        assert what == f"{'+' if after > 1 else '-'}3 dB edge, {'rising' if after > before else 'falling'}"
    grid = np.linspace(low, high, 401)
    sizes = np.transpose(_sizes(name, grid))
    assert float(row(m["relative distortion"], "largest").value) == pytest.approx(sizes[:, 0].max(), rel=1e-3)  # type: ignore[arg-type]
    assert float(row(m["sensitivity"], "largest").value) == pytest.approx(sizes[:, 1].max(), rel=1e-3)  # type: ignore[arg-type]
    unit = "N m/rad" if name == "twist" else "N/m"
    for i, (what, form) in enumerate((("|Z_min|", "Z_min"), ("|Z_max|", "Z_max"), ("|Z_width|", "Z_width")), 2):
        if np.isnan(sizes[:, i]).any():
            assert row(m["impedance range"], what).what == f"{what} everywhere"
            assert row(m["impedance range"], what).value is None
            continue
        for end, told in (
            (row(m["impedance range"], f"{what} at low"), sizes[0, i]),
            (row(m["impedance range"], f"{what} at high"), sizes[-1, i]),
        ):
            if np.isfinite(told):
                assert (float(end.value), end.unit) == (pytest.approx(told, rel=1e-9, abs=1e-30), unit), form  # type: ignore[arg-type]
            else:
                assert end.value is None
    empty = "Z_min" if sizes[:, 2].any() else "nothing"
    felt = "rigid" if np.isnan(sizes[:, 3]).any() else "Z_max"
    assert (
        m["impedance range"].verdict
        == f"where there is nothing, {empty} is felt; a rigid environment is felt as {felt}"
    )


def _felt(name: str, w: Any) -> Any:
    a, b, c, d, _, rendered = ports(name, w)
    return (a * rendered + b) / (c * rendered + d)


def _sizes(name: str, w: Any) -> list[Any]:
    a, b, c, d, env, rendered = ports(name, w)
    det, felt = a * d - b * c, (a * rendered + b) / (c * rendered + d)
    with np.errstate(all="ignore"):
        most, width = np.where(c == 0, np.nan, np.abs(a / c)), np.where(c == 0, np.nan, np.abs(det / c / d))
    return [abs(felt / env - 1), abs(det / (c * rendered + d) ** 2), abs(b / d), most, width]


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_effective_properties_stand_at_both_ends_and_at_every_crossing_with_their_units(name: str) -> None:
    scene, m = SCENES[name], measured(name)
    e = m.evaluation
    at = sorted({float(scene.band[0]), *(float(x.omega) for x in e.crossings), float(scene.band[1])})
    turning = name == "twist"
    units = (
        {"stiffness": "N m/rad", "mass": "kg m^2", "damping": "N m s/rad"}
        if turning
        else {"stiffness": "N/m", "mass": "kg", "damping": "N s/m"}
    )
    rows = m["effective impedance"].values
    assert len(rows) == 3 * len(at)
    for i, w in enumerate(at):
        felt = _felt(name, w)
        told = (felt.real, -felt.real / w**2 if w else None, felt.imag / w if w else None)
        for x, (what, unit), value in zip(rows[3 * i : 3 * i + 3], units.items(), told, strict=True):
            assert x.what.startswith(f"{what} at ")
            assert x.unit == unit
            if value is None:
                assert w == 0
            else:
                assert float(x.value) == pytest.approx(value, rel=1e-9)  # type: ignore[arg-type]
    assert [x["unit"] for x in m.to_dict()["metrics"] if x["name"] == "impedance range"] == [
        "N m/rad" if turning else "N/m"
    ]
    with pytest.raises(hs.SceneError, match="unknown measure"):
        m["transparency"]


@pytest.mark.few("twist", "rendered")
@pytest.mark.parametrize("name", SCENES)
def test_what_one_measure_says_and_another_does_not_is_noted(name: str) -> None:
    scene, m = SCENES[name], measured(name)
    free, e = m["free response, aeroplanes"].verdict, m.evaluation
    noticed = e.bandwidth is None or float(e.bandwidth) < float(scene.band[1])
    grid = np.linspace(*map(float, scene.band), 301)
    ratios = np.abs(_felt(name, grid) / ports(name, grid)[4])
    close = bool(((ratios >= 0.5**0.5) & (ratios <= 2**0.5)).all())
    never = all(x.low.omega is x.high.omega for x in m["absolute stability"].values[0].value)  # type: ignore[union-attr]
    told = {
        "sees of it only": noticed and "begins" in free,
        "keeps its tolerances": noticed and free == "passes",
        "breaks its tolerances": not noticed and free == "fails",
        "within 3 dB": noticed and close,
        "not absolutely stable": bool(e.transparent) and never,
    }
    assert {key for key in told if any(key in note for note in m.notes)} == {key for key, x in told.items() if x}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("more", "blind"), [("/(s + 9)", True), ("*5", True), ("*(s + 9)", False), ("*(-1)", True), ("+ 1", False)]
)
def test_the_test_is_blind_to_what_leaves_the_zeros_where_they_are(more: str, blind: bool) -> None:  # noqa: FBT001
    assert response((1, 5), (1, 5, more)).blind is blind


# The free response.


def swinging(sigma: Any, omega: Any, more: str = "") -> hs.Environment:
    return environments.expression(f"(s^2 + 2*({sigma})*s + ({sigma})^2 + ({omega})^2){more}")


def response(env: tuple[Any, ...], perc: tuple[Any, ...]) -> FreeResponse:
    return free_response(hs.distort(swinging(*env), rendered=swinging(*perc)))


# What is said of hands and environments.


@pytest.mark.parametrize(
    ("scene", "passive", "absolute"),
    [
        (hs.Scene(KV, (effects.compliance(k=800, b=3),)), "passive: Im H_perc >= 0 at all frequencies and no pole prevents it",
         "absolutely stable: with any passive operator and environment"),
        (hs.Scene(KV, (LAG,), (0, 60)), "Im H_perc < 0 somewhere on the band: active there; not passive",
         "not absolutely stable: the conditions on the axis fail somewhere on the band"),
        (hs.Scene(KV, (effects.shunt(b=-1),), (0, 5)), "passive: Im H_perc", "fail somewhere on the band"),
        (hs.Scene(environments.kelvin_voigt(100, 6), (LOWPASS,), (0, 1)),
         "Im H_perc >= 0 on the whole band, but < 0 above it, first from 71.181 rad/s; not passive",  # (38400 - 8000)/6, its root
         "not absolutely stable: the conditions on the axis fail somewhere on the band"),
        (hs.Scene(KV, (effects.compliance(k=400, b=30), LOWPASS, effects.shunt(b=4)), (0, 1)), "passive: Im H_perc",
         "not absolutely stable: the conditions on the axis hold on the whole band, but fail above it"),
        (hs.Scene(KV, (effects.shunt(Z="-1/s"),), (1, 5)), "Im H_perc >= 0 at all frequencies, but poles prevent passivity",
         "not absolutely stable: the conditions on the axis hold on the whole band, but poles break those on the poles"),
    ],
)  # fmt: skip
def test_what_is_said_of_every_passive_hand_and_environment_is_what_the_axis_and_the_poles_say(
    scene: hs.Scene, passive: str, absolute: str
) -> None:
    m = hs.metrics(scene)
    assert passive in m["passivity"].verdict
    assert absolute in m["absolute stability"].verdict
    rows = {x.what: x.value for x in m["passivity"].values}
    assert rows["any passive operator"] == ("holds" if "passive: Im" in passive else "does not hold")
    table = {x.what: x.value for x in m["absolute stability"].values}
    holds = {
        "conditions on the axis at all frequencies": "fail" not in absolute,
        "conditions on the poles": "poles" not in absolute,
    }
    assert {key: table[key] for key in holds} == {key: "holds" if x else "does not hold" for key, x in holds.items()}


def test_no_damping_of_a_hand_compensates_a_display_that_poles_forbid() -> None:
    """100 - s - s^2: no damping b > 1 compensates its mass of -1 kg: -s^2/2 + (b - 1) s + 100, in a hand of 0.5 kg, has a root > 0."""
    values = hs.metrics(hs.Scene(KV, (effects.shunt(Z="-s^2 - 4*s"),), (1, 5)))["passivity"].values
    assert [x.value for x in values if "compensates" in x.what] == ["none: poles prevent passivity"]


@pytest.mark.dear("scene0-set at")
@pytest.mark.parametrize(
    ("scene", "where"),
    [
        (hs.Scene(KV, (LAG,), (0, 60)), "set at"),
        (hs.Scene(KV, (LAG, effects.shunt(b="-1/2"))), "set at"),
        (hs.Scene(KV, (effects.compliance(k=500, b=20), effects.shunt(b=-21))), "approached at high frequency"),
        (hs.Scene(KV, (effects.shunt(Z="s^3"),)), "grows without bound"),
    ],
)
def test_what_a_hand_must_damp_is_the_most_that_is_given_away_at_any_frequency(scene: hs.Scene, where: str) -> None:
    m = hs.metrics(scene)["passivity"]
    grid = np.geomspace(1e-3, 1e5, 20_001)
    felt = hs.sampled(scene, grid).H.imag
    damping = row(m, "hand damping that compensates it")
    if where == "grows without bound":
        assert damping.value == "none: the activity is unbounded"
        return
    assert where in damping.what
    assert damping.unit == "N s/m"
    assert float(damping.value) == pytest.approx((-felt / grid).max(), rel=1e-4)  # type: ignore[arg-type]
    if where == "set at" and felt.argmin() < 19_000:
        given_away = row(m, "most energy given per cycle, over π A²")
        assert float(given_away.value) == pytest.approx(-felt.min(), rel=1e-4)  # type: ignore[arg-type]
        assert float(given_away.what.split()[-2]) == pytest.approx(grid[felt.argmin()], rel=2e-3)
        assert given_away.unit == "N/m"


@pytest.mark.slow
def test_the_first_edge_is_told_beside_the_bandwidth_of_the_jnd() -> None:
    def said(**keys: Any) -> str:
        scene = hs.Scene(**{"environment": STICK, "effects": (LOWPASS,), "band": (0, 15), "threshold": 0.1} | keys)
        return hs.metrics(scene)["transmitted impedance ratio"].verdict

    assert said() == "first 3 dB edge at 101.76 rad/s, 12.8 times the bandwidth by the JND"  # 101.762/7.97892
    assert said(threshold=0.9) == "first 3 dB edge at 101.76 rad/s; the JND is nowhere exceeded on the band"
    assert (
        said(band=(12, 15))
        == "first 3 dB edge at 101.76 rad/s; the JND test finds no transparent band that begins at the band's low end"
    )
    assert said(effects=(effects.delay("5 ms"), LOWPASS)).startswith("no 3 dB edge")  # with delays on the band alone


@pytest.mark.slow
@pytest.mark.parametrize(("form", "share"), [("(s^2 + 14*s + 31)/(s + 5)^2", 1), ("(s + 5)^2/(s^2 + 14*s + 31)", -1)])
def test_where_3_db_are_touched_and_not_exceeded_there_is_no_edge(form: str, share: int) -> None:
    """``|G|^2`` is 2 - (w^2 - 17)^2/(w^2 + 25)^2, or one over that; a little more or less, and there are two edges about it."""
    for more, count in ((Fraction(0), 0), (Fraction(share, 10**4), 2), (Fraction(-share, 10**4), 0)):
        scene = hs.Scene(
            environments.mass_spring_damper(k=100),
            (effects.series(f"({form})*{1 + more.limit_denominator()}"),),
            (0, 15),
        )
        m = hs.metrics(scene)["transmitted impedance ratio"]
        edges = [x for x in m.values if "edge" in x.what]
        assert (m.verdict == "no 3 dB edge", len(edges)) == (count == 0, count)
        for x, way in zip(edges, ("rising", "falling") if share > 0 else ("falling", "rising"), strict=False):
            assert x.what.split()[-1] == way
            assert float(x.value) == pytest.approx(17**0.5, abs=0.3)  # type: ignore[arg-type]


@pytest.mark.slow
def test_with_delays_edges_are_looked_for_on_the_band_and_without_up_to_a_hundred_times_its_end() -> None:
    for more, reach, upto in (((), 1500, "100 times the band's high end"), ((effects.delay("5 ms"),), 15, "the band")):
        scene = hs.Scene(STICK, (*more, LOWPASS), (0, 15))
        [kept] = [x for x in hs.metrics(scene)["transmitted impedance ratio"].values if x.what.startswith("within")]
        assert kept.what == f"within 3 dB (up to {upto})"
        assert float(kept.value[-1].high.omega) <= reach  # type: ignore[index, union-attr, operator]


POUND = 4.4482216152605


def stick_on(*effects: hs.Effect, m: float = 1.8, b: float = 3, k: float = 100) -> hs.Scene:
    return hs.Scene(hs.environments.mass_spring_damper(m, b, k), effects, (0, 15))


def named(found: hs.ControlLoading, name: str):
    [trial] = [x for x in found.trials if x.name.startswith(name)]
    return trial


def free(m: float, b: float, k: float, level: float) -> float:
    """When a mass on spring and damper first passes a level, from its closed form and Brent's method."""
    sigma, w = b / (2 * m), sqrt(k / m - (b / (2 * m)) ** 2)
    return brentq(lambda t: exp(-sigma * t) * (cos(w * t) + sigma / w * sin(w * t)) - level, 0, pi / w)


def test_a_free_response_is_the_closed_form_and_its_margin_what_is_left_of_ten_per_cent() -> None:
    found = hs.control_loading(stick_on(hs.effects.shunt(m=0.3384, b=0.6)))
    own, felt = (free(*x, 0) - free(*x, 0.9) for x in ((1.8, 3, 100), (2.1384, 3.6, 100)))
    trial = named(found, "P_0")
    assert float(trial.environment) == pytest.approx(own, rel=1e-12)
    assert float(trial.display) == pytest.approx(felt, rel=1e-12)
    assert trial.margin == pytest.approx(1 - 10 * (felt / own - 1), abs=1e-9)
    assert (trial.passes, trial.entry) == (False, "2.b.1")
    assert named(hs.control_loading(stick_on(hs.effects.shunt(m=0.3384, b=0.6)), "14cfr60-c2a"), "P_0").passes is True


def test_an_overdamped_control_is_timed_from_90_to_10_per_cent() -> None:
    found = hs.control_loading(stick_on(hs.effects.shunt(m=0.6), m=1, b=30, k=100), control="roll")
    trial = named(found, "time from 90 %")
    assert float(trial.environment) == pytest.approx(0.58582774, abs=1e-8)
    assert float(trial.display) / float(trial.environment) - 1 == pytest.approx(-0.07163, abs=1e-5)
    assert (trial.passes, trial.entry) == (True, "2.b.2")


@pytest.mark.parametrize(("more", "passes"), [(9.999, True), (10, True), ("-10", True)])
def test_static_force_within_ten_per_cent_passes_whatever_the_travel(more: float, passes: bool) -> None:  # noqa: FBT001
    assert named(hs.control_loading(stick_on(hs.effects.shunt(k=more))), "static").passes is passes


def test_static_force_beyond_ten_per_cent_passes_while_it_is_within_pounds_at_full_travel() -> None:
    scene = stick_on(hs.effects.shunt(k=40))
    unknown = named(hs.control_loading(scene), "static")
    assert unknown.passes is None
    assert "up to 0.556 m" in unknown.why
    assert pytest.approx(0.556, abs=1e-3) == 5 * POUND / 40
    near, far = (named(hs.control_loading(scene, travel=x), "static") for x in ("0.556 m", "0.5561 m"))
    assert (near.passes, far.passes) == (True, False)
    assert near.margin == pytest.approx(1 - 40 * 0.556 / (5 * POUND))
    roll = named(hs.control_loading(scene, control="roll", travel="0.34 m"), "static")
    assert (roll.passes, roll.entry) == (False, "2.a.2")


def test_a_sweep_is_the_force_above_the_static_one() -> None:
    m, b, d, w = 1.8, 3, 0.3384, 2 * pi / 4
    trial = named(hs.control_loading(stick_on(hs.effects.shunt(m=d)), sweeps=["4 s"], travel=0.1), "sweep")
    assert float(trial.environment) == pytest.approx(abs(complex(-m * w**2, b * w)))
    assert float(trial.display) == pytest.approx(abs(complex(-(m + d) * w**2, b * w)))
    assert trial.margin == pytest.approx(1 - d * w**2 * 0.1 / (2 * POUND))
    late = named(hs.control_loading(stick_on(hs.effects.delay("50 ms")), sweeps=[4]), "sweep")
    h = complex(100 - m * w**2, b * w)
    turned = h * complex(cos(w * 0.05), -sin(w * 0.05))
    assert float(late.display) == pytest.approx(abs(turned - 100))
    assert "needs the travel" in late.why
    assert f"{2 * POUND / abs(turned - h):.4g} m" in late.why


def test_breakout_is_the_friction_of_the_display_and_a_helicopter_is_let_go_without_it() -> None:
    rough = stick_on(hs.effects.coulomb_friction("1.2 N", "5 cm"))
    aeroplane, helicopter = hs.control_loading(rough), hs.control_loading(rough, "14cfr60-c2a")
    assert (named(aeroplane, "breakout").passes, named(helicopter, "breakout").passes) == (True, False)
    assert named(aeroplane, "breakout").margin == pytest.approx(1 - 1.2 / (2 * POUND))
    assert named(aeroplane, "free response").passes is None
    assert named(helicopter, "P_0").margin == 1


TABLES = {
    "14cfr60-a2a": {
        "pitch": ("2.a.1", "2.b.1", "2", "5"),
        "roll": ("2.a.2", "2.b.2", "2", "3"),
        "pedals": ("2.a.3", "2.b.3", "5", "5"),
        "nosewheel": ("2.a.4", None, "2", "3"),
    },
    "14cfr60-c2a": {
        "cyclic": ("2.a.1", "2.a.5", "0.25", "1"),
        "collective": ("2.a.2", "2.a.5", "0.5", "1"),
        "pedals": ("2.a.2", "2.a.5", "0.5", "1"),
    },
}
"""Typed from 14 CFR Part 60, tables A2A and C2A (edition of 1 January 2019): of each control its entries for position
against force and for dynamics, and the tolerances of breakout and force, lb."""


@pytest.mark.parametrize(("rule", "control"), [(rule, control) for rule, rows in TABLES.items() for control in rows])
def test_every_number_of_the_tables_is_that_of_the_regulation(rule: str, control: str) -> None:
    static, dynamic, breakout, force = TABLES[rule][control]
    is_helicopter = rule == "14cfr60-c2a"
    for share, kept in (("0.999999", True), ("1.000001", False)):
        friction = Rational(breakout) * Rational(share) * Rational("4.4482216152605")
        travel = (
            Rational(force) * Rational(share) * Rational("4.4482216152605") / 40
        )  # where 40 N/m more are so many pounds
        scene = stick_on(hs.effects.shunt(k=40), hs.effects.coulomb_friction(friction, "5 cm"))
        found = hs.control_loading(scene, rule, control, travel=travel, sweeps=["4 s"])
        rest, off = named(found, "static"), named(found, "breakout")
        assert (rest.entry, rest.passes, rest.tolerance) == (static, kept, f"10 % or {force} lb")
        assert (off.entry, off.passes) == (static, kept)
        assert off.tolerance == f"{breakout} lb" + (" or 25 %" if is_helicopter else "")
        assert rest.margin == pytest.approx(1 - float(share), abs=1e-12)
        assert off.margin == pytest.approx(1 - float(share), abs=1e-12)
        assert (float(off.display), off.environment, off.unit) == (pytest.approx(float(friction)), 0, "N")
        assert (float(rest.environment), float(rest.display), rest.unit) == (100, 140, "N/m")
        entries = {x.entry for x in found.trials if x.name.startswith(("P_", "A_", "free response", "overshoots"))}
        assert entries == ({dynamic} if dynamic else set())
        sweeps = [(x.entry, x.tolerance) for x in found.trials if x.name.startswith("sweep")]
        assert sweeps == ([] if is_helicopter or not dynamic else [(dynamic, "10 % or 2 lb above static")])
        plays = [(x.entry, x.tolerance) for x in found.trials if x.name == "freeplay"]
        assert plays == ([("2.a.6", "0.10 in")] if is_helicopter else [])
    alone = stick_on(hs.effects.coulomb_friction(Rational(breakout) * Rational("4.4482216152605"), "5 cm"))
    assert named(hs.control_loading(alone, rule, control), "breakout").passes is True  # just as much is allowed


@pytest.mark.parametrize(("share", "kept"), [("0.999999", True), ("1.000001", False)])
def test_a_sweep_may_need_two_pounds_more_than_the_environment_does(share: str, kept: bool) -> None:  # noqa: FBT001
    w = 2 * pi / 2
    off = 0.9 * w**2  # of half the mass more
    travel = Rational(str(2 * POUND / off)) * Rational(share)
    scene = stick_on(hs.effects.shunt(m="0.9"), b=0)
    trial = named(hs.control_loading(scene, control="pedals", sweeps=["2 s"], travel=travel), "sweep")
    assert (trial.passes, trial.entry) == (kept, "2.b.3")
    assert trial.margin == pytest.approx(1 - float(share), abs=1e-9)


def test_what_was_not_tested_says_why_and_counts_for_nothing() -> None:
    found = hs.control_loading("sidestick", "14cfr60-c2a", "collective")
    why = {x.name: x.why for x in found.untested}
    assert set(why) == {"breakout", "freeplay"}
    assert "torque" in why["breakout"]
    body = json.loads(found.to_json())
    assert body["passes"] is (not found.failed)
    assert body["certified"] is True
    assert [x["passes"] for x in body["tests"]].count(None) == 2


def test_a_torque_beyond_ten_per_cent_is_not_judged_as_pounds_need_a_lever() -> None:
    sweep = named(hs.control_loading("sidestick", sweeps=["4 s"]), "sweep")
    assert (sweep.passes, sweep.margin) == (None, None)
    assert "need the lever" in sweep.why


def test_the_jnd_stands_beside_each_test() -> None:
    found = hs.control_loading(stick_on(hs.effects.shunt(m=0.3384)), sweeps=["4 s", "0.5 s", "0.1 s"])
    assert named(found, "static").noticed is False
    assert named(found, "P_0").noticed is True
    assert [x.noticed for x in found.trials if x.name.startswith("sweep")] == [False, True, None]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"rule": "easa"}, 'unknown "easa"'),
        ({"control": "cyclic"}, "of this rule are pitch, roll, pedals, nosewheel"),
        ({"travel": "5 N"}, 'travel: "5 N" is not a'),
        ({"travel": 0}, "must be positive"),
        ({"sweeps": ["-4 s"]}, "must be positive"),
        ({"scene": "sidestick", "travel": 0.1}, "this control turns"),
    ],
)
def test_what_cannot_be_asked_is_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.control_loading(**{"scene": stick_on(), **given})
    assert words in str(error.value)


def test_the_command_prints_the_report_and_refuses_options_without_a_rule() -> None:
    call = CliRunner().invoke
    done = call(app, ["metrics", "sidestick", "--rule", "14cfr60-a2a", "--sweep", "4 s", "--json"])
    assert json.loads(done.stdout)["schema"] == "haptisym.controlloading/1"
    shown = call(app, ["metrics", "sidestick", "--rule", "14cfr60-a2a"]).stdout
    assert "fails 1 of" in shown
    alone = call(app, ["metrics", "sidestick", "--travel", "5 cm"])
    assert alone.exit_code


def test_a_figure_shows_both_responses_or_says_that_there_is_none(tmp_path) -> None:
    found = hs.control_loading(stick_on(hs.effects.shunt(m=0.3)))
    assert found.save_figure(tmp_path / "a.svg").stat().st_size > 1000
    [first, *_] = found.figure().axes
    assert first.lines[0].get_ydata()[0] == pytest.approx(1)
    late = hs.control_loading(stick_on(hs.effects.coulomb_friction(1, "5 cm")))
    with pytest.raises(hs.HaptisymError, match="no free response"):
        late.figure()


def test_a_report_names_the_travel_and_the_meaning_of_the_tests_that_were_made_alone() -> None:
    found = hs.control_loading(stick_on(hs.effects.shunt(m=0.3)), travel="3 in")
    assert found.to_dict()["travel"] == pytest.approx(0.0762, rel=1e-15)
    assert "travel 0.0762 m" in str(found)
    assert "Sweep:" not in str(found)
    rigid = hs.control_loading("helicopter-cyclic", "14cfr60-c2a")
    assert "travel" not in rigid.to_dict()
    assert "P_0" not in str(rigid)


# What a fit to a movement reports


FITTED = ("k", "b", "m")


def by_hand(name, w):
    """H_perc(j w) of some scenes, by hand."""
    s = 1j * w
    if (
        name == "virtual-wall"
    ):  # k + b s by backward difference, one sample late, held; 40 g and 0.8 N s/m of the device
        T = 1e-3
        z = np.exp(s * T)
        D = (400 + 0.4 * (1 - 1 / z) / T) / z
        hold = -np.expm1(-s * T) / (s * T)
        return D * hold + 0.04 * s**2 + 0.8 * s
    if name == "stick-with-friction":
        G = 6400 / (s**2 + 80 * s + 6400)
        return (1.8 * s**2 + 15 * s + 100) * G + 4j * 0.26 / (np.pi * 0.05)
    assert name == "a spring-pot"
    return (200 + 30 * s**0.3) * 40 / (s + 40)


def fitted_scene(name):
    if name != "a spring-pot":
        return hs.load_scene(name)
    return hs.Scene(environments.spring_pot(30, "0.3", k=200), (effects.first_order_lag(40),), (0, 20))


def normal_equations(M, X, Y):
    k, minus_m = np.linalg.solve([[M[0], M[2]], [M[2], M[4]]], X)
    return {"k": k, "b": Y / M[2], "m": -minus_m}


@pytest.mark.few(4)
@pytest.mark.parametrize("name", ["virtual-wall", "stick-with-friction", "a spring-pot"])
@pytest.mark.parametrize("movement", ["0:12", "3:12", "velocity:1:12"])
def test_a_fit_to_a_flat_band_against_quadrature(name, movement):
    """Holds and powers of s from 0 rad/s on, where their formulas are 0/0 or have no derivative."""
    *kind, low, high = movement.split(":")
    low, high, weight = float(low), float(high), -2 if kind else 0

    def moment(f, n):
        return quad(lambda w: f(w) * w ** (n + weight), low, high, epsabs=0, epsrel=1e-10)[0]

    expected = normal_equations(
        {n: moment(lambda _: 1.0, n) for n in (0, 2, 4)},
        [moment(lambda w: by_hand(name, w).real, n) for n in (0, 2)],
        moment(lambda w: by_hand(name, w).imag, 1),
    )
    found = hs.evaluate(fitted_scene(name), movement=movement).movement
    for x in FITTED:
        assert found.perceived[x] == pytest.approx(expected[x], rel=1e-7)


def test_a_fit_of_the_papers_example():
    rows = {
        "0:15": ("99.8347809537", "16.8292036316", "1.60570315029"),
        "velocity:1:15": ("99.9639491593", "15.5758572891", "1.60745594847"),
        "0:7.978916790174708": ("99.9895907186", "14.6074571324", "1.61090746247"),
    }
    for movement, printed in rows.items():
        found = hs.evaluate("fu2019", movement=movement).movement
        assert [f"{found.perceived[x]:.12g}" for x in FITTED] == list(printed)
        assert found.environment == {"k": 100.0, "b": 15.0, "m": 1.8}
    assert found.row()["change"]["m"] == pytest.approx(-0.105, abs=1e-4)


def test_a_fit_to_a_recording(tmp_path):
    """By weighted least squares over the lines of SciPy's spectrum, of another form than the normal equations."""
    t = np.linspace(0, 20, 2001)
    x = 0.05 * np.sin(2 * t) + 0.02 * np.sin(5 * t + 1) + 0.01 * np.sin(9 * t)
    path = tmp_path / "hand.csv"
    np.savetxt(path, np.c_[t, x], delimiter=",", header="t,x", comments="")
    f, power = signal.periodogram(x, 1 / (t[1] - t[0]), window="hann", detrend="linear")
    w = 2 * np.pi * f
    own = (w > 0) & (w <= 15)
    w, root = w[own], np.sqrt(power[own])
    s = 1j * w
    H = (1.8 * s**2 + 15 * s + 100) * 6400 / (s**2 + 80 * s + 6400)
    (k, m), *_ = np.linalg.lstsq(root[:, None] * np.stack([np.ones_like(w), -(w**2)], -1), root * H.real)
    [b], *_ = np.linalg.lstsq((root * w)[:, None], root * H.imag)
    found = hs.evaluate("fu2019", movement=path).movement
    assert [found.perceived[x] for x in FITTED] == pytest.approx([k, b, m], rel=1e-6)
    wall = hs.evaluate("virtual-wall", movement=path).movement
    assert (wall.environment["m"], wall.change["m"]) == (0.0, None)  # what rounding leaves is no mass


@pytest.mark.parametrize(
    ("movement", "said"),
    [
        ("15:0", "must go up"),
        ("-1:5", "must go up"),
        ("velocity:0:15", "no end at 0 rad/s"),
        ("acceleration:1:5", "is no movement"),
        ("0 kg:1 kg", "not a frequency"),
        ("nowhere.csv", "no such file"),
    ],
)
def test_what_is_no_movement(movement, said):
    with pytest.raises(hs.SceneError, match=said):
        hs.evaluate("fu2019", movement=movement)


NARROW = {
    "10:10.00000000001": ("99.64247721", "16.01190181", "1.605797447"),
    "velocity:10:10.000000001": ("99.64247721", "16.01190181", "1.605797447"),
    "0:1e-12": ("100", "13.75", "1.6125"),
}
"""By mpmath with 120 digits."""


@pytest.mark.parametrize("movement", NARROW)
def test_a_band_however_narrow_has_all_digits_of_its_fit(movement):
    """From a band of a billionth of a rad/s the normal equations take thirty digits."""
    found = hs.evaluate("fu2019", movement=movement)
    assert found.movement.environment == {"k": 100.0, "b": 15.0, "m": 1.8}
    perceived = [found.movement.perceived[x] for x in FITTED]
    assert perceived == pytest.approx([*map(float, NARROW[movement])], rel=1e-9)
    assert found.movement.change["m"] == pytest.approx(float(NARROW[movement][2]) / 1.8 - 1, rel=1e-8)
    assert found.settled


def test_a_number_that_no_digits_decide_is_undecided():
    found = hs.evaluate("fu2019", movement="0:1e-300")
    assert (found.movement.environment, found.settled) == ({"k": 100.0, "b": 15.0, "m": None}, False)
    assert "undecided" in str(found)


def test_a_change_of_nothing_is_none_and_one_of_mass_alone_leaves_the_others():
    scene = hs.Scene(environments.mass_spring_damper(m=2, k=100), (effects.shunt(m="0.5"),), (0, 9))
    found = hs.evaluate(scene, movement="1:4").movement
    assert found.change == {"k": 0.0, "b": None, "m": 0.25}
    assert (found.perceived, found.undecided) == ({"k": 100.0, "b": 0.0, "m": 2.5}, False)


@pytest.mark.parametrize(("of", "system"), [("100*9/(s^2 + 9)", "environment"), ("100", "perceived")])
def test_across_a_pole_there_is_no_fit_and_all_else_is_told(of, system):
    """The integral of the square of H is infinite there, and at an end of the band, too."""
    resonance = effects.series("9/(s^2 + 9)") if system == "perceived" else effects.first_order_lag(20)
    scene = hs.Scene(environments.expression(of, parameters={}), (resonance,), (0, 2))
    for movement in ("0:5", "1:3"):
        found = hs.evaluate(scene, movement=movement)
        assert found.movement.poles[system] == (3.0,)
        assert getattr(found.movement, system) == dict.fromkeys(FITTED)
        assert found.settled
        assert found.bandwidth is not None
    assert hs.evaluate(scene, movement="4:5").movement.poles == {}
