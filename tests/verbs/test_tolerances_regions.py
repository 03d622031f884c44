"""Boxes with JND regions: against regions solved by hand, plain complex arithmetic, and sets of values answered one by one."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from fractions import Fraction
from math import cos, sin, sqrt
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from regions import margin

import haptisym as hs
from haptisym.judge.crossings import noticed
from haptisym.judge.excess import box_of, excess_of

E = hs.environments
PENTAGON = [[0.12, 0.02], [0.03, 0.1], [-0.1, 0.05], [-0.04, -0.08], [0.05, -0.09]]
JNDS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", "real": 0.2, "imag": 0.1, "tilt": -0.5},
    "round": {"shape": "ellipse", "real": 0.15, "imag": 0.1},
    "diamond": {"shape": "diamond", "real": 0.12, "imag": 0.1},
    "polygon": {"shape": "polygon", "corners": PENTAGON},
    "two limits": {"real": {"higher": 0.08, "lower": 0.2}, "imag": {"higher": 0.2, "lower": 0.05}},
    "two limits and a floor": {"real": {"higher": 0.08, "lower": 0.2}, "imag": {"higher": 0.2, "lower": 0.05}, "floor": "8"},
    "floor": {"real": 0.1, "imag": 0.2, "floor": "12"},
    "formula": {"real": "0.08 + 0.01*omega", "imag": "1/(omega + 2)"},
    "tilt of a formula": {"shape": "ellipse", "real": "0.08 + 0.01*omega", "imag": 0.2, "tilt": "omega/30"},
}  # fmt: skip


def lagged(jnd: Any, top: float = 10, k: Any = "100 N/m", damper: Any = 0) -> hs.Scene:
    """A spring behind a lag of 36 to 44 rad/s: dH/|H_env| = -j t/(1 + j t) with t = omega/omega_c."""
    lag = hs.effects.first_order_lag(["36 rad/s", "44 rad/s"])
    return hs.Scene(E.mass_spring_damper(b=damper, k=k), (lag,), (0, top), jnd)


def ends(found: Any) -> list[float]:
    [x] = found.enclosures
    assert x.count == 1
    assert x.at_low is not None
    assert x.at_high is not None
    return [float(x.low), float(x.high)]


# --- solved by hand -----------------------------------------------------------------------------------------------------

ROUND = {"shape": "ellipse", "real": 0.2, "imag": 0.2}


def positive(*row: float) -> float:
    """The one positive root of a polynomial, highest power first."""
    [t] = [x.real for x in np.roots(row) if abs(x.imag) < 1e-12 and x.real > 0]
    return float(t)


@pytest.mark.few("disc")
@pytest.mark.parametrize(
    ("jnd", "damper", "t"),
    [
        (ROUND, 0, 0.2 / sqrt(1 - 0.04)),  # |dH/H| = t/sqrt(1 + t^2)
        ({"shape": "diamond", "real": 0.2, "imag": 0.2}, 0, positive(0.8, 1, -0.2)),  # (t^2 + t)/(1 + t^2)
        ({"shape": "polygon", "corners": [[0.2, 0], [0, 0.2], [-0.2, 0], [0, -0.2]]}, 0, positive(0.8, 1, -0.2)),
        # of a damper H_env = j omega b: what is real of a spring is imaginary of it, x = t/(1 + t^2) and y = -t x
        ({"shape": "polygon", "corners": [[0.3, -0.3], [0.3, 0.1], [-0.3, 0.1], [-0.3, -0.3]]}, "5 N*s/m", 1 / 3),
        # and its tilt turns too: c^2 (1 - r^2) = x^2 - 2 r x y + y^2 with c = 0.2 and r = 1/2
        ({**ROUND, "tilt": 0.5}, "5 N*s/m", positive(0.97, 1, 0.94, 0, -0.03)),
    ],
    ids=["disc", "diamond", "diamond as a polygon", "polygon of a damper", "tilt of a damper"],
)  # fmt: skip
def test_the_ends_of_a_crossing_of_a_region_are_known_by_hand(jnd: Any, damper: Any, t: float) -> None:
    found = hs.tolerances(lagged(jnd, 30 if damper else 10, 0 if damper else "100 N/m", damper), samples=0)
    assert found.verdict.value == "none"
    assert ends(found) == pytest.approx([36 * t, 44 * t], rel=1e-13)
    assert found.to_dict()["bandwidth"] == pytest.approx([36 * t, 44 * t], rel=1e-13)


@pytest.mark.dear("8-depends")
@pytest.mark.parametrize(("top", "verdict"), [(7, "all"), (8, "depends"), (9.5, "none")])
def test_the_verdict_is_for_all_for_some_or_for_none(top: float, verdict: str) -> None:
    """The disc of 0.2 is left between 7.35 and 8.98 rad/s."""
    assert hs.tolerances(lagged(ROUND, top), samples=0).verdict.value == verdict


def test_a_half_width_may_vary_with_all_else() -> None:
    """A disc of 0.15 to 0.2 and a lag of 36 to 44 rad/s: t = c/sqrt(1 - c^2)."""
    region = {"shape": "ellipse", "real": ["0.15", "0.2"], "imag": ["0.15", "0.2"]}
    found = hs.tolerances(lagged(region), samples=0)
    t = [c / sqrt(1 - c**2) for c in (0.15, 0.2)]
    assert ends(found) == pytest.approx([36 * t[0], 44 * t[1]], rel=1e-14)
    assert found.enclosures[0].monotonic == {"omega_c": 1, "c": 1}


@pytest.mark.slow
def test_a_floor_counts_where_it_is_above_the_limit() -> None:
    """k t^2/(1 + t^2) must exceed 3 N/m, and 0.02 k: with k from 90 to 160 the floor for small k, the limit for large k."""
    jnd = {"real": 0.02, "imag": 5, "floor": "3 N/m"}
    found = hs.tolerances(lagged(jnd, k=["90 N/m", "160 N/m"]), samples=0)
    [x] = [y for y in found.enclosures if y.criterion.name == "real"]
    low, high = (w * sqrt(r / (1 - r)) for w, r in ((36, 0.02), (44, 3 / 90)))
    assert low * (1 - 2e-3) <= float(x.low) <= low * (1 + 1e-12)
    assert high * (1 - 1e-12) <= float(x.high) <= high * (1 + 2e-3)


@pytest.mark.dear("0-0", "3-0")
@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("turns", range(4))
def test_a_region_that_is_alike_on_no_two_sides_is_left_where_its_first_edge_is_met(turns: int, seed: int) -> None:
    """H_env = s^n is j^n on the axis: x + j y = j^n (-t^2 - j t)/(1 + t^2), and p x + q y = 1 of an edge is quadratic in t."""
    draw = Random(seed)
    angles = [2.1 * n + draw.uniform(0, 0.7) + seed for n in range(3)]
    corners = [[round(r * cos(a), 3), round(r * sin(a), 3)] for a in angles for r in (draw.uniform(0.1, 0.4),)]
    felt = E.expression(f"s^{turns}") if turns else E.mass_spring_damper(k=1)
    lag = hs.effects.first_order_lag(["36", "44"])
    found = hs.tolerances(hs.Scene(felt, (lag,), (0, 90), {"shape": "polygon", "corners": corners}), samples=0)
    places = []
    for one, other in zip(corners, [*corners[1:], corners[0]], strict=True):
        p, q = np.linalg.solve([one, other], [1, 1])
        p, q = [(p, q), (q, -p), (-p, -q), (-q, p)][turns]  # the edge, turned back
        roots = np.roots([-p - 1, -q, -1])
        places += [x.real for x in roots if abs(x.imag) < 1e-12 and x.real > 0]
    assert float(found.enclosures[0].low) == pytest.approx(36 * min(places), rel=1e-9)


@pytest.mark.dear("0.2-0.05-floor1")
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
    device = hs.effects.shunt(m=["-0.5 kg", "-0.1 kg"])
    beside = hs.Scene(E.mass_spring_damper(k="100 N/m"), (device,), (0, 40), sided)
    places = [sqrt(float(higher) * 100 / m) for m in (0.5, 0.1)]
    assert ends(hs.tolerances(beside, samples=0)) == pytest.approx(places, rel=1e-13)


@pytest.mark.parametrize(("gains", "verdict"), [(["0.89", "0.9"], "all"), (["1.11", "1.13"], "none")])
def test_gains_before_a_mass_are_told_from_0_on_by_limits_for_each_way(gains: list[str], verdict: str) -> None:
    series = hs.effects.series("g", parameters={"g": gains})
    jnd = {"real": {"higher": "0.1", "lower": "0.12"}, "imag": "0.1"}
    found = hs.tolerances(hs.Scene(E.mass_spring_damper(m=1), (series,), (0, 3), jnd), samples=0)
    assert (found.verdict.value, found.enclosures, found.bandwidth is None) == (verdict, (), verdict == "none")


# --- every region against plain arithmetic ------------------------------------------------------------------------------

FELT: dict[str, tuple[dict[str, Any], Callable[[complex, Mapping[str, float]], complex]]] = {
    "spring": ({"k": ["80", "120"]}, lambda s, p: p["k"]),
    "damper": ({"b": ["4", "6"]}, lambda s, p: p["b"] * s),
    "mass": ({"m": ["1", "2"]}, lambda s, p: p["m"] * s**2),
    "all": ({"m": ["1", "2"], "b": ["4", "6"], "k": ["80", "120"]}, lambda s, p: p["m"] * s**2 + p["b"] * s + p["k"]),
    "damper and mass": ({"m": ["1", "2"], "b": ["4", "6"]}, lambda s, p: p["m"] * s**2 + p["b"] * s),
}
CASES = [(x, [*FELT][(i + k) % 5]) for i, x in enumerate(JNDS) for k in (0, 2, 3)]


def scene_of(felt: str, jnd: Any, low: Any = "0.5") -> hs.Scene:
    """Behind a lag, and a gain that makes more or less of it."""
    effects = hs.effects.first_order_lag(["20", "60"]), hs.effects.series("g", parameters={"g": ["0.8", "1.3"]})
    return hs.Scene(E.mass_spring_damper(**FELT[felt][0]), effects, (low, 15), jnd)


def judged(felt: str, jnd: Any, box: Any, shares: Any) -> float:
    """The margin at a point of band and box, in plain arithmetic; positive where the change is noticed."""
    low, high = (float(x) for x in box.scene.band)
    omega = low + (high - low) * float(shares[0])
    values = {x.name: float(x.at(Fraction(float(y)))) for x, y in zip(box.sides, shares[1:], strict=True)}
    H = complex(FELT[felt][1](1j * omega, values))
    return margin(jnd, H, H / (1 + 1j * omega / values["omega_c"]) * values["g"], omega)


@pytest.mark.dear(
    "ellipse-spring",
    "floor-all",
    "floor-damper and mass",
    "polygon-spring",
    "two limits and a floor-mass",
    "two limits-damper and mass",
    "two limits-damper",
)
@pytest.mark.few(8)
@pytest.mark.parametrize(("name", "felt"), CASES)
def test_bounds_over_a_cell_have_the_sign_of_the_region_everywhere_in_it(name: str, felt: str) -> None:
    """At points they decide it, unless at its border; in cells they are never against it. Of several criteria one is enough."""
    box, rng = box_of(scene_of(felt, JNDS[name])), np.random.default_rng(7)
    written = json.loads(json.dumps(JNDS[name]))
    forms = [excess_of(box, x) for x in noticed(box.scene.threshold)]
    outside = 0
    for width in (0, 0.02, 0.2):
        start = rng.uniform(0, 1 - width, (40, 1 + len(box.sides)))
        cells = np.stack([start, start + width], -1)
        found = [tuple(y[:, 0] for y in form.model(cells).bounds()) for form in forms]
        for i, cell in enumerate(cells):
            true = judged(felt, written, box, cell[:, 0] + rng.uniform(0, 1, len(cell)) * width)
            is_out, is_in = any(low[i] > 0 for low, _ in found), all(high[i] < 0 for _, high in found)
            assert true >= 0 or not is_out
            assert true <= 0 or not is_in
            assert width or abs(true) < 1e-6 or is_out is bool(true > 0) is not is_in
            outside += true > 0
    assert 3 < outside < 117


@pytest.mark.dear("floor", "formula")
@pytest.mark.few(3)
@pytest.mark.parametrize(
    "name", ["ellipse", "diamond", "polygon", "two limits", "floor", "formula", "tilt of a formula"]
)
def test_along_a_side_on_which_a_slope_keeps_its_sign_the_border_is_crossed_one_way_alone(name: str) -> None:
    """In cells of a tenth of each range: from one end of a side to the other, at random values of all others."""
    box, rng = box_of(scene_of("all", JNDS[name])), np.random.default_rng(3)
    written, seen = json.loads(json.dumps(JNDS[name])), 0
    criteria = noticed(box.scene.threshold)
    for criterion in criteria:
        form = excess_of(box, criterion)
        alone = written if len(criteria) == 1 else {**written, ({"real", "imag"} - {criterion.name}).pop(): 1e9}
        cells = np.sort(rng.uniform(0, 0.9, (40, form.sides, 1)) + np.array([0, 0.1]), -1)
        low, high = form.model(cells).bounds()
        for i in np.flatnonzero((low[:, 0] <= 0) & (high[:, 0] >= 0)):
            for side in range(form.sides):
                way = int(low[i, 1 + side] > 0) - int(high[i, 1 + side] < 0)
                point = cells[i, :, 0] + rng.uniform(0, 0.1, form.sides)
                margins = []
                for end in cells[i, side]:
                    point[side] = end
                    margins.append(way * judged("all", alone, box, point))
                seen += way != 0
                assert not (margins[0] > 1e-9 and margins[1] < -1e-9)
    assert seen > 2


@pytest.mark.few(3)
@pytest.mark.parametrize("felt", ["damper", "mass"])
@pytest.mark.parametrize("name", [x for x in JNDS if "floor" not in x])
def test_a_region_is_left_from_rest_on_as_its_limits_say_where_what_is_felt_vanishes_there(
    name: str, felt: str
) -> None:
    """Behind gains from 0.7 to 1.4: the change is g - 1 at all frequencies, from 0 on."""
    jnd, series = json.loads(json.dumps(JNDS[name])), hs.effects.series("g", parameters={"g": ["0.7", "1.4"]})
    box = box_of(hs.Scene(E.mass_spring_damper(**FELT[felt][0]), (series,), (0, 15), jnd))
    forms = [excess_of(box, x) for x in noticed(box.scene.threshold)]
    shares = np.linspace(0.01, 0.99, 60)
    for omega in (0.0, 1e-9, 0.4):
        cells = np.tile([[[omega, omega], [0.5, 0.5], [0.0, 0.0]]], (60, 1, 1))
        cells[:, 2] = shares[:, None]
        found = [tuple(y[:, 0] for y in form.model(cells, slopes=0).bounds()) for form in forms]
        H = complex(FELT[felt][1](1j * (15 * omega or 1e-12), {"b": 5.0, "m": 1.5}))
        for i, share in enumerate(shares):
            true = margin(jnd, H, H * (0.7 + 0.7 * share), 15 * omega)
            if abs(true) > 1e-4:
                is_out = any(low[i] > 0 for low, _ in found)
                assert true > 0 or not is_out
                assert true < 0 or not all(high[i] < 0 for _, high in found)
                assert omega == 0 or is_out is bool(true > 0)


@pytest.mark.slow
@pytest.mark.few("round")
@pytest.mark.parametrize("name", ["round", "ellipse", "diamond", "polygon", "floor"])
def test_no_set_of_values_leaves_the_region_outside_the_enclosures(name: str) -> None:
    """Against a scan of the band for random sets of values, and the bandwidths of some."""
    scene, rng = scene_of("spring", JNDS[name]), np.random.default_rng(9)
    found, written = hs.tolerances(scene, samples=2), json.loads(json.dumps(JNDS[name]))
    spans = [(float(x.low), float(x.high)) for x in found.enclosures]
    shares = np.linspace(0, 1, 121)
    omega, kept = 0.5 + 14.5 * shares, set()
    for _ in range(5):
        own = rng.uniform(0, 1, len(found.box.sides))
        out = [judged("spring", written, found.box, [x, *own]) > 0 for x in shares]
        kept.add(not any(out))
        for i in np.flatnonzero(np.diff(out)):
            assert any(low <= omega[i + 1] and omega[i] <= high for low, high in spans)
    assert found.verdict.value != "all" or kept == {True}
    assert found.verdict.value != "none" or kept == {False}
    if found.bandwidth:
        low, high = map(float, found.bandwidth)
        assert all(x.bandwidth is None or low <= float(x.bandwidth) <= high for x in found.samples)


@pytest.mark.parametrize(
    ("effect", "jnd", "verdict"),
    [({}, "ellipse", "all"), ({}, "polygon", "all"), ({}, "floor", "all"), ({"b": 9}, "two limits", "none"), ({"m": 1}, "two limits", "none")],
)  # fmt: skip
def test_a_region_in_which_nothing_changes_is_kept_and_one_part_alone_may_leave_it(
    effect: dict[str, int], jnd: str, verdict: str
) -> None:
    chain = (hs.effects.shunt(**effect),) if effect else ()
    found = hs.tolerances(hs.Scene(E.mass_spring_damper(k=["80", "120"]), chain, ("0.5", 15), JNDS[jnd]), samples=0)
    assert found.verdict.value == verdict
    assert {x.criterion.name for x in found.enclosures} == ({"imag" if "b" in effect else "real"} if effect else set())


def test_the_command_tells_of_the_regions_border(call: Any, tmp_path: Path) -> None:
    file = tmp_path / "diamond.toml"
    file.write_text(
        'environment = { model = "mass-spring-damper", k = "100 N/m" }\n'
        'effects = [{ model = "first-order-lag", omega_c = ["36 rad/s", "44 rad/s"] }]\n'
        'evaluation = { band = ["0 rad/s", "10 rad/s"], jnd = { shape = "diamond", real = 0.2, imag = 0.2 } }\n'
    )
    status, out, _ = call("tolerances", str(file), "--samples", "0", "--json")
    told = json.loads(out)
    assert (status, told["verdict"], [x["part"] for x in told["crossings"]]) == (0, "none", ["joint"])
