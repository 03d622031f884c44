"""Boxes with JND regions: against regions solved by hand, plain complex arithmetic, and sets of values answered one by one."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import pairwise, product
from math import cos, sin, sqrt
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from regions import margin

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.programs.taylormodels import Model, variable
from haptisym.verbs.tolerances.box import box_of
from haptisym.verbs.tolerances.joined import enclosing, joined
from haptisym.verbs.tolerances.regional import excess_of

WIDE = {"real": 0.1, "imag": 0.1}
CORNERS = {"shape": "polygon", "corners": [[0.12, 0.02], [0.03, 0.1], [-0.1, 0.05], [-0.04, -0.08], [0.05, -0.09]]}
JNDS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", **WIDE, "tilt": -0.5},
    "diamond": {"shape": "diamond", "real": 0.12, "imag": 0.1},
    "polygon": CORNERS,
    "higher and lower": {"real": {"higher": 0.08, "lower": 0.12}, "imag": {"higher": 0.2, "lower": 0.05}},
    "floor": {**WIDE, "floor": "15"},
    "formula": {"real": "0.08 + 0.004*omega", "imag": "1/(omega + 2)"},
    "formulas of a region": {"shape": "ellipse", "real": "0.08 + 0.004*omega", "imag": 0.2, "tilt": "omega/20"},
}  # fmt: skip
PAPER = hs.load_scene("fu2019")


def lagged(jnd: Any, top: float = 10, k: Any = "100 N/m", damper: Any = 0) -> hs.Scene:
    """A spring behind a lag of 36 to 44 rad/s: dH/|H_env| = -j t/(1 + j t) with t = omega/omega_c."""
    felt = hs.environments.mass_spring_damper(b=damper, k=k)
    return hs.Scene(felt, (hs.effects.first_order_lag(["36 rad/s", "44 rad/s"]),), (0, top), jnd)


def ends(found: Any) -> list[float]:
    [x] = found.enclosures
    assert x.count == 1
    assert x.at_low is not None
    assert x.at_high is not None
    return [float(x.low), float(x.high)]


def test_the_ends_of_a_discs_crossing_are_known_by_hand() -> None:
    """|dH/H| = t/sqrt(1 + t^2) = c."""
    t = 0.2 / sqrt(1 - 0.04)
    found = hs.tolerances(lagged({"shape": "ellipse", "real": 0.2, "imag": 0.2}), samples=0)
    assert found.verdict.value == "none"
    assert ends(found) == pytest.approx([36 * t, 44 * t], rel=1e-14)
    assert found.to_dict()["bandwidth"] == pytest.approx([36 * t, 44 * t], rel=1e-14)


def test_the_ends_of_a_diamonds_crossing_are_known_by_hand() -> None:
    """|x| + |y| = (t^2 + t)/(1 + t^2) = c: t is the positive root of (1 - c) t^2 + t - c."""
    t = (-1 + sqrt(1 + 4 * 0.8 * 0.2)) / (2 * 0.8)
    corners = [[0.2, 0], [0, 0.2], [-0.2, 0], [0, -0.2]]
    for jnd in ({"shape": "diamond", "real": 0.2, "imag": 0.2}, {"shape": "polygon", "corners": corners}):
        assert ends(hs.tolerances(lagged(jnd), samples=0)) == pytest.approx([36 * t, 44 * t], rel=1e-14)


def test_a_damper_alone_turns_the_region_by_a_quarter() -> None:
    """H_env = j omega b has its zero at 0: what is real of a spring is imaginary of a damper."""
    corners = [[0.3, -0.3], [0.3, 0.1], [-0.3, 0.1], [-0.3, -0.3]]
    found = hs.tolerances(lagged({"shape": "polygon", "corners": corners}, k=0, damper="5 N*s/m", top=30), samples=0)
    t = sqrt(0.3 / 0.7)  # y = Im(j (1/(1 + j t) - 1)) = -t^2/(1 + t^2) = -0.3 comes after x = t/(1 + t^2) = 0.3
    first = (1 - sqrt(1 - 4 * 0.3**2)) / (2 * 0.3)
    assert first < t
    assert ends(found) == pytest.approx([36 * first, 44 * first], rel=1e-13)


def test_a_damper_alone_turns_the_tilt_of_an_ellipse_too() -> None:
    """x = t/(1 + t^2), y = -t x: within c^2 (1 - r^2) = x^2 - 2 r x y + y^2, a quartic in t."""
    c, r = 0.2, 0.5
    disc = {"shape": "ellipse", "real": c, "imag": c, "tilt": r}
    found = hs.tolerances(lagged(disc, k=0, damper="5 N*s/m", top=30), samples=0)
    roots = np.roots([1 - c * c * (1 - r * r), 2 * r, 1 - 2 * c * c * (1 - r * r), 0, -c * c * (1 - r * r)])
    [t] = [x.real for x in roots if abs(x.imag) < 1e-12 and x.real > 0]
    assert ends(found) == pytest.approx([36 * t, 44 * t], rel=1e-13)


@pytest.mark.slow
def test_a_floor_counts_where_it_is_above_the_limit() -> None:
    """k t^2/(1 + t^2) must exceed 3 N/m, and 0.02 k: with k from 90 to 160 the floor for small k, the limit for large k."""
    jnd = {"real": 0.02, "imag": 5, "floor": "3 N/m"}
    found = hs.tolerances(lagged(jnd, k=["90 N/m", "160 N/m"]), samples=0)
    [x] = [y for y in found.enclosures if y.criterion.name == "real"]
    at = [sqrt(r / (1 - r)) for r in (0.02, 3 / 90)]
    assert float(x.low) == pytest.approx(36 * at[0], rel=2e-3)
    assert float(x.low) <= 36 * at[0] * (1 + 1e-12)
    assert 44 * at[1] * (1 - 1e-12) <= float(x.high) == pytest.approx(44 * at[1], rel=2e-3)


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("turns", range(4))
def test_a_region_that_is_alike_on_no_two_sides_is_left_where_its_first_edge_is_met(turns: int, seed: int) -> None:
    """H_env = s^n is j^n on the axis: x + j y = j^n (-t^2 - j t)/(1 + t^2), and p x + q y = 1 of an edge is quadratic in t."""
    draw = Random(seed)
    angles = [2.1 * n + draw.uniform(0, 0.7) + seed for n in range(3)]
    sizes = [draw.uniform(0.1, 0.4) for _ in angles]
    corners = [[round(r * cos(a), 3), round(r * sin(a), 3)] for a, r in zip(angles, sizes, strict=True)]
    felt = hs.environments.expression(f"s^{turns}") if turns else hs.environments.mass_spring_damper(k=1)
    scene = hs.Scene(
        felt, (hs.effects.first_order_lag(["36", "44"]),), (0, 90), {"shape": "polygon", "corners": corners}
    )
    X, Y = ((0, -1), (-1, 0)) if turns % 2 == 0 else ((1, 0), (0, -1))  # before t and t^2
    X, Y = (X, Y) if turns < 2 else ((-X[0], -X[1]), (-Y[0], -Y[1]))
    places = []
    for one, other in zip(corners, [*corners[1:], corners[0]], strict=True):
        p, q = np.linalg.solve([one, other], [1, 1])
        roots = np.roots([p * X[1] + q * Y[1] - 1, p * X[0] + q * Y[0], -1])
        places += [x.real for x in roots if abs(x.imag) < 1e-12 and x.real > 0]
    first = hs.tolerances(scene, samples=0).enclosures[0]
    assert float(first.low) == pytest.approx(36 * min(places), rel=1e-9)


@pytest.mark.few(2)
@pytest.mark.parametrize("floor", [{}, {"floor": "1 N/m"}])
@pytest.mark.parametrize(("lower", "higher"), [("0.2", "0.05"), ("0.05", "0.2"), ("0.3", "0.3")])
def test_what_shrinks_is_judged_by_the_lower_limit_and_what_grows_by_the_higher(
    lower: str, higher: str, floor: dict[str, str]
) -> None:
    """Behind the lag a spring shrinks by k t^2/(1 + t^2); beside a negative mass it grows by |m| omega^2."""
    sided = {"real": {"lower": lower, "higher": higher}, "imag": 9, **floor}
    t = sqrt(float(lower) / (1 - float(lower)))
    assert ends(hs.tolerances(lagged(sided, top=40), samples=0)) == pytest.approx([36 * t, 44 * t], rel=1e-13)
    felt = hs.environments.mass_spring_damper(k="100 N/m")
    beside = hs.Scene(felt, (hs.effects.shunt(m=["-0.5 kg", "-0.1 kg"]),), (0, 40), sided)
    places = [sqrt(float(higher) * 100 / m) for m in (0.5, 0.1)]
    assert ends(hs.tolerances(beside, samples=0)) == pytest.approx(places, rel=1e-13)


@pytest.mark.parametrize(("top", "verdict"), [(7, "all"), (8, "depends"), (9.5, "none")])
def test_the_verdict_is_for_all_for_some_or_for_none(top: float, verdict: str) -> None:
    """The disc of 0.2 is left between 7.35 and 8.98 rad/s."""
    found = hs.tolerances(lagged({"shape": "ellipse", "real": 0.2, "imag": 0.2}, top), samples=0)
    assert found.verdict.value == verdict


# --- every region against plain arithmetic ---------------------------------------------------------------------------


def ranged(jnd: Any) -> hs.Scene:
    ranges = {"m": "1.8 +- 20 %", "b": "15 +- 20 %", "k": "100 +- 20 %", "omega_n": "60 +- 20 %"}
    return hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd).with_values(ranges)


def changed(values: dict[str, float], omega: float) -> tuple[complex, complex]:
    s = 1j * omega
    H = values["m"] * s**2 + values["b"] * s + values["k"]
    w = values["omega_n"]
    return H, H * w**2 / (s**2 + w * s + w**2)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", JNDS)
def test_a_model_has_the_sign_of_the_region_everywhere_in_a_cell(name: str) -> None:
    asked, random = ranged(JNDS[name]), np.random.default_rng(5)
    box, decided = box_of(asked), 0
    written = json.loads(json.dumps(JNDS[name]))
    forms = [excess_of(box, x) for x in noticed(asked.threshold)]
    for width in (0.02, 0.2):
        start = random.uniform(0, 1 - width, (40, 5))
        cells = np.stack([start, start + width], -1)
        low, high = (
            np.stack(x) for x in zip(*((y[:, 0] for y in form.model(cells).bounds()) for form in forms), strict=True)
        )
        for i, cell in enumerate(cells):
            shares = cell[:, 0] + random.uniform(0, 1, 5) * width
            values = {
                x.name: float(x.at(Fraction(float(share)))) for x, share in zip(box.sides, shares[1:], strict=True)
            }
            is_out = margin(written, *changed(values, 15 * shares[0]), 15 * shares[0]) > 0
            decided += bool((low[:, i] > 0).any() or (high[:, i] < 0).all())
            assert is_out or not (low[:, i] > 0).any()
            assert not is_out or not (high[:, i] < 0).all()
    assert decided > 30


@pytest.mark.slow
@pytest.mark.parametrize("name", JNDS)
def test_no_set_of_values_leaves_the_region_outside_the_enclosures(name: str) -> None:
    """Against a scan of the band for random sets of values."""
    asked, random = ranged(JNDS[name]), np.random.default_rng(9)
    found = hs.tolerances(asked, samples=0)
    written = json.loads(json.dumps(JNDS[name]))
    spans = [(float(x.low), float(x.high)) for x in found.enclosures]
    omega = np.linspace(1e-3, 15, 601)
    for _ in range(12):
        values = {x.name: float(x.low + (x.high - x.low) * random.uniform()) for x in found.box.sides}
        out = [margin(written, *changed(values, w), w) > 0 for w in omega]
        for i in np.flatnonzero(np.diff(out)):
            assert any(low <= omega[i + 1] and omega[i] <= high for low, high in spans)
    assert found.verdict.value != "all"
    if found.bandwidth:
        drawn = [float(x.bandwidth) for x in hs.tolerances(asked, samples=8).samples if x.bandwidth]
        assert float(found.bandwidth[0]) <= min(drawn)
        assert max(drawn) <= float(found.bandwidth[1])


def test_the_largest_of_the_smallest_of_models_is_told_by_those_that_decide_it() -> None:
    """max(min(x - 1/2, 2), min(x + 1/4, -1), x/2 - 1/8) over four cells of x in [-1, 1], against points."""
    edges = np.linspace(-1, 1, 9)
    x = variable((edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2, 1.0, 0, 1)
    terms = [[x.plus(-0.5), x.number(2.0)], [x.plus(0.25), x.number(-1.0)], [x.times(0.5).plus(-0.125)]]
    found: Model = joined(terms)
    low, high = found.bounds()
    for i, (a, b) in enumerate(pairwise(edges)):
        for at in np.linspace(a, b, 11):
            exact = max(min(at - 0.5, 2), min(at + 0.25, -1), at / 2 - 0.125)
            assert exact >= 0 or not low[i, 0] > 0
            assert exact <= 0 or not high[i, 0] < 0
    undecided = (low[:, 0] <= 0) & (high[:, 0] >= 0)
    assert edges[:-1][undecided].tolist() == [0.0, 0.25]
    assert (low[undecided, 1] > 0).all()


# --- as a user has it ------------------------------------------------------------------------------------------------

TEXT = """
[environment]
model = "mass-spring-damper"
k = "100 N/m"
[[effects]]
model = "first-order-lag"
omega_c = ["36 rad/s", "44 rad/s"]
[evaluation]
band = ["0 rad/s", "{top} rad/s"]
jnd = {{ shape = "diamond", real = 0.2, imag = 0.2 }}
"""


def test_the_command_tells_of_the_regions_border(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    file = tmp_path / "diamond.toml"
    file.write_text(TEXT.format(top=10), encoding="utf-8")
    status, out, _ = call("tolerances", str(file), "--samples", "5", "--figure", str(tmp_path / "a.svg"))
    assert status == 0
    assert "where the distortion meets the border of the diamond" in out
    assert "ratio" not in out
    assert "diamond" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    _, out, _ = call("tolerances", str(file), "--samples", "5", "--json")
    assert [x["part"] for x in json.loads(out)["crossings"]] == ["joint"]
    file.write_text(TEXT.format(top=3), encoding="utf-8")
    status, out, _ = call("tolerances", str(file), "--samples", "0")
    assert status == 0
    assert "does not meet the border of the diamond" in out


def test_a_half_width_may_vary_with_all_else() -> None:
    """A disc of 0.15 to 0.2 and a lag of 36 to 44 rad/s: t = c/sqrt(1 - c^2)."""
    region = {"shape": "ellipse", "real": ["0.15", "0.2"], "imag": ["0.15", "0.2"]}
    found = hs.tolerances(lagged(region), samples=0)
    t = [c / sqrt(1 - c**2) for c in (0.15, 0.2)]
    assert ends(found) == pytest.approx([36 * t[0], 44 * t[1]], rel=1e-14)
    assert found.enclosures[0].monotonic == {"omega_c": 1, "c": 1}


@pytest.mark.parametrize("seed", range(3))
def test_a_model_about_two_others_holds_all_that_either_holds_and_little_else(seed: int) -> None:
    """Of values and slopes: what is off at a place, and the remainder there, is within its own."""
    draw = np.random.default_rng(seed)
    sizes = (5, 4), (5, 4, 3), (5, 4, 3, 3)

    def one() -> Model:
        return Model(*(draw.normal(size=x) * 10.0 ** draw.integers(-3, 3) for x in sizes), draw.uniform(0, 1, (5, 4)))

    def at(x: Model, t: Any) -> Any:
        return x.c0 + x.c1 @ t + (x.c2 @ t) @ t

    for _ in range(5):
        f, g = one(), one()
        found = enclosing(f, g)
        apart = [abs(x - y) / 2 for x, y in zip(f.arrays[:3], g.arrays[:3], strict=True)]
        most = apart[0] + apart[1].sum(-1) + apart[2].sum((-1, -2)) + np.maximum(f.r, g.r)
        for signs in product((-1.0, 1.0), repeat=3):
            for t in (np.array(signs), draw.uniform(-1, 1, 3)):
                for x in (f, g):
                    assert (abs(at(x, t) - at(found, t)) + x.r <= found.r).all()
        assert (found.r <= most * (1 + 1e-9)).all()
        assert (enclosing(f, f).r <= f.r * (1 + 1e-9) + 1e-9).all()
        known = enclosing(f, Model(*f.arrays[:3], f.r + 1))
        assert (abs(known.r - f.r - 1) <= 1e-9).all()


@pytest.mark.parametrize(("gains", "verdict"), [(["0.89", "0.9"], "all"), (["1.11", "1.13"], "none")])
def test_gains_before_a_mass_are_told_from_0_on_by_limits_for_each_way(gains: list[str], verdict: str) -> None:
    series = hs.effects.series("g", parameters={"g": gains})
    jnd = {"real": {"higher": "0.1", "lower": "0.12"}, "imag": "0.1"}
    found = hs.tolerances(hs.Scene(hs.environments.mass_spring_damper(m=1), (series,), (0, 3), jnd), samples=0)
    assert (found.verdict.value, found.enclosures) == (verdict, ())
    assert (found.bandwidth is None) is (verdict == "none")
