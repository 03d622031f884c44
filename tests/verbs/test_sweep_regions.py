"""Sweeps with JND regions: each set against its evaluation, which charts exactly, and against plain complex arithmetic."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from jnds import jnds
from oracles import Case
from regions import margin
from strategies import cases, scene
from sympy import Rational

import haptisym as hs
from haptisym.verbs.sweep.told import Told

PAPER = hs.load_scene("fu2019")
NATURAL, MASS = "effects.filter.omega_n", "environment.m"
WIDE = {"real": 0.1, "imag": 0.1}
DIAMOND = {"shape": "diamond", **WIDE}
SIDED = {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1}
CORNERS = {"shape": "polygon", "corners": [[0.12, 0.02], [0.03, 0.1], [-0.1, 0.05], [-0.04, -0.08], [0.05, -0.09]]}
JNDS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", **WIDE, "tilt": -0.5},
    "diamond": DIAMOND,
    "polygon": CORNERS,
    "higher and lower": SIDED,
    "floor": {**WIDE, "floor": "15 N/m"},
    "formula": {"real": "0.08 + 0.004*omega", "imag": 0.1},
    "formulas of a region": {"shape": "ellipse", "real": "0.08 + 0.004*omega", "imag": "1/(omega + 5)", "tilt": "omega/20"},
}  # fmt: skip


def with_jnd(jnd: Any, plain: hs.Scene = PAPER) -> hs.Scene:
    return hs.Scene(plain.environment, plain.effects, plain.band, jnd)


def exactly(x: float) -> Rational:
    return Rational(*Fraction(x).as_integer_ratio())


def agrees(found: Any, e: hs.Evaluation) -> None:
    """One set of a sweep with its evaluation."""
    for name in Told.of(e.scene).criteria:
        own = [float(x.omega) for x in e.crossings if x.criterion.name == name]
        assert int(found[f"crossings_{name}"]) == len(own), name
        assert float(found[f"first_crossing_{name}"]) == pytest.approx(min(own, default=np.nan), rel=1e-10, nan_ok=True)
    low, high = map(float, e.scene.band)
    width = np.nan if e.bandwidth is None else float(e.bandwidth)
    assert float(found["bandwidth"]) == pytest.approx(width, rel=1e-10, nan_ok=True)
    clear = sum(float(x.high.omega) - float(x.low.omega) for x in e.transparent) / (high - low)
    assert float(found["transparent"]) == pytest.approx(clear, abs=1e-9)


@pytest.mark.few("ellipse", "diamond", "higher and lower", "floor", "formula", "formulas of a region")
@pytest.mark.parametrize("name", JNDS)
def test_every_set_is_what_its_evaluation_says_and_floats_prove_it(name: str) -> None:
    asked = with_jnd(JNDS[name])
    found = hs.sweep(asked, {NATURAL: [25.0, 80.0, 160.0], MASS: [0.3, 1.8]})
    assert (found.method == 0).all()
    for at in np.ndindex(3, 2):
        one = found[{NATURAL: at[0], MASS: at[1]}]
        agrees(one, hs.evaluate(asked.with_values({x: exactly(float(one[x])) for x in (NATURAL, MASS)})))


@pytest.mark.few(2)
@pytest.mark.parametrize("jnd", [JNDS["ellipse"], DIAMOND, SIDED, JNDS["floor"], JNDS["formula"]])
def test_half_widths_are_swept_together_apart_and_alone(jnd: dict[str, Any]) -> None:
    asked, both, real, imag = with_jnd(jnd), *(f"evaluation.jnd{part}" for part in ("", ".real", ".imag"))
    for axes in ([both], [real], [imag, real]):
        found = hs.sweep(asked, {path: [0.0625, 0.25] for path in axes})
        assert (found.method == 0).all()
        for at in np.ndindex(*(2 for _ in axes)):
            values = {path: exactly([0.0625, 0.25][i]) for path, i in zip(axes, at, strict=True)}
            agrees(found[dict(zip(axes, at, strict=True))], hs.evaluate(asked.with_values(values)))


@pytest.mark.slow
@pytest.mark.parametrize("name", JNDS)
def test_the_transparent_part_is_that_of_a_dense_scan(name: str) -> None:
    jnd, omega = JNDS[name], np.linspace(1e-3, 15, 1501)
    found = hs.sweep(with_jnd(jnd), {NATURAL: [40.0, 80.0]})
    for i, w in enumerate((40.0, 80.0)):
        s = 1j * omega
        H = 1.8 * s**2 + 15 * s + 100
        G = H * w**2 / (s**2 + w * s + w**2)
        written = json.loads(json.dumps(jnd).replace(" N/m", ""))
        inside = [margin(written, complex(h), complex(g), x) <= 0 for h, g, x in zip(H, G, omega, strict=True)]
        assert float(found.transparent[i]) == pytest.approx(np.mean(inside), abs=5e-3)


def test_a_change_that_is_the_same_at_all_frequencies_is_noticed_on_all_or_on_none() -> None:
    spring = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.series("g", parameters={"g": "9/10"}),))
    found = hs.sweep(with_jnd(DIAMOND, spring), {"effects.series.g": [0.5, 0.875, 0.9375, 1.0, 2.0]})
    assert found.transparent.values.tolist() == [0, 0, 1, 1, 0]
    assert (
        hs.sweep(with_jnd({"shape": "ellipse", "real": 0.6, "imag": 0.1}, spring), {"environment.k": [3.0]}).transparent
        == 1
    )
    assert (
        hs.sweep(
            with_jnd({"shape": "ellipse", "real": 0.05, "imag": 0.1}, spring), {"environment.k": [3.0]}
        ).transparent
        == 0
    )


@pytest.mark.few(3)
@pytest.mark.parametrize("name", JNDS)
def test_a_delayed_scene_is_answered_in_floats_in_its_region_too(name: str) -> None:
    asked = with_jnd(JNDS[name], hs.load_scene("delayed-spring"))
    found = hs.sweep(asked, {"effects.delay.tau": [0.0078125, 0.25]})
    assert found.method.values[0] == 0  # at the longer delay parts change together for one region
    for i, tau in enumerate(("1/128", "1/4")):
        agrees(found[{"effects.delay.tau": i}], hs.evaluate(asked.with_values({"tau": tau})))


@pytest.mark.slow
@given(cases(order=3), jnds(), st.lists(st.integers(1, 64), min_size=2, max_size=4, unique=True))
def test_random_regions_are_left_as_often_as_their_evaluations_say(
    case: Case, jnd: dict[str, Any], steps: list[int]
) -> None:
    asked = with_jnd(jnd, scene(case))
    knob = next((p for p in asked.parameters if p.value.is_Rational and p.value > 0), None)
    assume(knob is not None)
    assert knob is not None
    values = sorted(float(knob.value) * n / 16 for n in steps)
    found = hs.sweep(asked, {knob.path: values})
    for i, x in enumerate(values):
        if int(found.method[i]) != 2:
            agrees(found[{knob.path: i}], hs.evaluate(asked.with_values({knob.path: exactly(x)})))


# --- as a user has it ------------------------------------------------------------------------------------------------

TEXT = """
[environment]
model = "mass-spring-damper"
m = "1.8 kg"
b = "15 N*s/m"
k = "100 N/m"
[[effects]]
name = "filter"
model = "second-order-lowpass"
omega_n = "80 rad/s"
zeta = 0.5
[evaluation]
band = ["0 rad/s", "15 rad/s"]
jnd = { shape = "diamond", real = 0.10, imag = 0.10 }
"""


@pytest.mark.slow
def test_the_command_tells_of_both_parts_at_once(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    file = tmp_path / "diamond.toml"
    file.write_text(TEXT, encoding="utf-8")
    words = ["sweep", str(file), "--vary", f"{NATURAL}=40:160:4"]
    status, out, _ = call(*words, "--json", "--out", str(tmp_path / "a.nc"), "--figure", str(tmp_path / "a.svg"))
    told = json.loads(out)
    assert status == 0
    assert told["certified_in_floats"] == 4
    assert set(told["counts"]) == {"crossings_joint", "changeovers_environment", "changeovers_perceived"}
    assert told["ranges"]["first_crossing_joint"][0] == pytest.approx(told["ranges"]["bandwidth"][0])
    assert "leaves the JND region" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    status, out, _ = call(*words)
    assert status == 0
    assert "first crossing, both parts at once" in out
    assert "crossings, both parts at once" in out
    assert "real part" not in out


@pytest.mark.slow
def test_a_sweep_of_another_region_is_another_sweep(tmp_path: Path) -> None:
    hs.sweep(with_jnd(DIAMOND), {MASS: [1.0, 2.0]}, out=tmp_path / "a.zarr")
    with pytest.raises(hs.SceneError, match="another sweep"):
        hs.sweep(with_jnd(CORNERS), {MASS: [1.0, 2.0]}, out=tmp_path / "a.zarr")
    with pytest.raises(hs.SceneError, match='has no parameter "evaluation.jnd"'):
        hs.sweep(with_jnd(CORNERS), {"evaluation.jnd": [0.1]})
