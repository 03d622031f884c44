"""Discs against regions of every shape: what is said holds for every point of a disc, and says no less than it could."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from sympy import Rational

import haptisym as hs
from haptisym.kernel.symbols import omega as OMEGA  # noqa: N812
from haptisym.model.jndtables import read_threshold
from haptisym.verbs.measured.regions import _from_ellipse, _two_way, values_of

FU = hs.load_scene("fu2019")
HEXAGON = [[0.1, 0.01], [0.05, 0.09], [-0.05, 0.12], [-0.1, 0], [-0.05, -0.09], [0.05, -0.07]]
REGIONS: dict[str, Any] = {
    "disc": {"shape": "ellipse", "real": 0.1, "imag": 0.1},
    "ellipse": {"shape": "ellipse", "real": 0.2, "imag": 0.06, "tilt": 0.8},
    "narrow": {"shape": "ellipse", "real": 0.05, "imag": 0.15, "tilt": -0.3},
    "diamond": {"shape": "diamond", "real": 0.1, "imag": 0.16},
    "polygon": {"shape": "polygon", "corners": HEXAGON},
    "ways": {"real": {"higher": 0.08, "lower": 0.14}, "imag": {"higher": 0.2, "lower": 0.05}},
    "floor": {"real": 0.1, "imag": 0.1, "floor": "9 N/m"},
    "formula": {"shape": "ellipse", "real": "0.08 + 0.004*omega", "imag": 0.1, "tilt": "0.05*omega"},
}
JOINT = {"disc", "ellipse", "narrow", "diamond", "polygon", "formula"}
LEAST = {"real": 0.0, "imag": 0.0}


@pytest.mark.parametrize("seed", range(4))
def test_the_way_to_where_a_change_of_one_part_is_noticed_is_that_to_the_ends_of_what_is_not(seed: int) -> None:
    """By the definition in fractions: what grows in magnitude has one limit and what shrinks another; ends are where that changes."""
    draw = random.Random(seed)
    step = Fraction(1, 1000)
    for _ in range(25):
        up, down = (Fraction(draw.randint(1, 12), 4) for _ in range(2))
        e = Fraction(draw.choice([-1, 1]) * draw.randint(1, 20), 8)

        def is_noticed(x: Fraction) -> bool:
            larger, same = abs(e + x) > abs(e), abs(e + x) == abs(e)  # noqa: B023
            return abs(x) > (max(up, down) if same else up if larger else down)  # noqa: B023

        places = {sign * x for x in (up, down, 2 * abs(e)) for sign in (1, -1)}
        ends = [x for x in places if len({is_noticed(y) for y in (x - step, x, x + step)}) == 2]
        for x in (Fraction(draw.randint(-60, 60), 16) for _ in range(12)):
            way = min(abs(x - end) for end in ends)
            [found] = _two_way(*(np.array([float(n)]) for n in (up, down, x, e)))
            assert found == (way if is_noticed(x) else -way)


def noticed(name: str, omega: float, env: np.ndarray, perc: np.ndarray) -> dict[str, np.ndarray]:
    """Which changes are noticed, straight from the definitions of DESIGN: by key ``joint``, or by part."""
    c, size = REGIONS[name], np.abs(env)
    x, y = (perc - env).real / size, (perc - env).imag / size
    if name == "polygon":
        corners = np.array(HEXAGON)
        steps = np.roll(corners, -1, axis=0) - corners
        return {
            "joint": np.any(
                [dx * (y - py) - dy * (x - px) < 0 for (px, py), (dx, dy) in zip(corners, steps, strict=True)], axis=0
            )
        }
    if name == "diamond":
        return {"joint": np.abs(x) / 0.1 + np.abs(y) / 0.16 > 1}
    if name == "formula":
        a, b, t = 0.08 + 0.004 * omega, 0.1, 0.05 * omega
        return {"joint": (x / a) ** 2 - 2 * t * (x / a) * (y / b) + (y / b) ** 2 > 1 - t**2}
    if name in JOINT:
        a, b, t = c["real"], c["imag"], c.get("tilt", 0)
        return {"joint": (x / a) ** 2 - 2 * t * (x / a) * (y / b) + (y / b) ** 2 > 1 - t**2}
    if name == "floor":
        return {part: np.abs(d) * size > np.maximum(9, 0.1 * size) for part, d in (("real", x), ("imag", y))}
    found = {}
    for part, d in (("real", x), ("imag", y)):
        after, before = (np.abs(h.real if part == "real" else h.imag) for h in (perc, env))
        found[part] = np.abs(d) > np.where(after > before, c[part]["higher"], c[part]["lower"])
    return found


EDGE = np.exp(2j * np.pi * np.arange(48) / 48)
DISC = np.concatenate([[0], *(share * EDGE for share in (0.25, 0.5, 0.75, 1 - 1e-9))])


@example(seed=109, name="diamond", measured_too=False)
@given(st.integers(0, 10_000), st.sampled_from(sorted(REGIONS)), st.booleans())
def test_a_verdict_holds_for_every_truth_within_the_discs(seed: int, name: str, measured_too: bool) -> None:  # noqa: FBT001
    rng = np.random.default_rng(seed)
    omega = np.linspace(1, 15, 8)
    env = rng.normal(size=8) * 100 + 1j * rng.normal(size=8) * 50
    env[0] = 3 + 100j  # a real part so small that -2 e lies within the limits
    perc = env + 0.3 * np.abs(env) * rng.uniform(size=8) * (rng.normal(size=8) + 1j * rng.normal(size=8))
    r_env, r_perc = (np.abs(env) * rng.uniform(0, 0.12, 8) for _ in range(2))
    own = hs.measured(omega, env, radius=r_env * measured_too)
    e = hs.evaluate(hs.MeasuredScene(own, hs.measured(omega, perc, radius=r_perc), threshold=_threshold(name)))
    for i, row in enumerate(e.rows):
        a = (env[i] + r_env[i] * measured_too * DISC)[:, None]
        b = (perc[i] + r_perc[i] * DISC)[None, :]
        for key, seen in noticed(name, omega[i], *np.broadcast_arrays(a, b)).items():
            verdict = getattr(row, key).value
            assert verdict != "exceeds" or seen.all()
            assert verdict != "below" or not seen.any()
            if not measured_too:  # and says no less than it could, but for what the points of the disc do not see
                assert (
                    verdict != "unresolved"
                    or (seen.any() and not seen.all())
                    or _close(name, omega[i], a[0, 0], perc[i], r_perc[i], key)
                )
        assert (row.joint is None) == (name not in JOINT)


def _threshold(name: str) -> Any:
    from haptisym.model.jndtables import read_threshold

    return read_threshold(REGIONS[name])


def _close(name: str, omega: float, env: complex, perc: complex, radius: float, key: str) -> bool:
    """Whether many points inside the disc are told differently, or a slightly larger or a slightly smaller disc otherwise."""
    edge = np.exp(2j * np.pi * np.arange(2000) / 2000)
    rings = [noticed(name, omega, np.full(2000, env), perc + radius * share * edge)[key] for share in (0.98, 1.02)]
    differ = (
        rings[0].any() and not rings[0].all()
    )  # as where a corner of the region comes in between two points of the disc
    return bool(differ or rings[0].all() != rings[1].all() or rings[0].any() != rings[1].any())


@pytest.mark.parametrize("name", sorted(set(REGIONS) - {"formula"}))
def test_exact_lines_are_judged_as_the_proven_crossings_say(name: str) -> None:
    omega = np.linspace(0.1, 15, 150)
    exact = hs.sampled("fu2019", omega)
    scene = hs.Scene(FU.environment, FU.effects, (0, 15), _threshold(name))
    proven = hs.evaluate(scene)
    felt = hs.measured(omega, exact.H, radius=1e-9 * np.abs(exact.H))
    e = hs.evaluate(hs.MeasuredScene(scene.environment, felt, threshold=_threshold(name)))
    transparent = np.any(
        [(omega >= float(b.low.omega)) & (omega <= float(b.high.omega)) for b in proven.transparent], axis=0
    )
    if name in JOINT:
        assert e.joint is not None
        assert ((e.joint.verdict == -1) == transparent).all()
        assert ((e.joint.verdict == 1) == ~transparent).all()
    else:
        assert (np.all([e.verdict[part] == -1 for part in hs.Part], axis=0) == transparent).all()
    for p in e.percepts:
        [own] = [
            x
            for x in proven.percepts
            if x.part is p.part and float(x.band.low.omega) <= p.omega <= float(x.band.high.omega)
        ]
        assert (p.property, p.change, p.other) == (own.property, own.change, own.other)


@pytest.mark.slow
@given(st.integers(0, 10_000), st.sampled_from(sorted(REGIONS)))
def test_what_is_told_between_lines_holds_for_all_that_swept_discs_have_in_common(seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    omega, slope = np.sort(rng.uniform(1, 15, 3)), rng.uniform(0, 60)
    env, start = 1j * omega * 15 + 100 - 1.8 * omega**2, rng.normal(size=2)
    perc = env + 0.2 * np.abs(env) * (start[0] + 1j * start[1]) + 5 * (rng.normal(size=3) + 1j * rng.normal(size=3))
    radius = np.abs(env) * rng.uniform(0, 0.05, 3)
    felt = hs.measured(omega, perc, radius=radius, slope=f"{slope:.17g} N*s/m")
    e = hs.evaluate(hs.MeasuredScene(FU.environment, felt, threshold=_threshold(name)))
    for key, own in ((part.value if part else "joint", x) for part, x in e.between.told.items()):  # type: ignore[union-attr]
        if name in JOINT and key != "joint":
            continue
        for low, high, code in zip(own.low, own.high, own.code, strict=True):
            for w in rng.uniform(low, high, 1):
                i = min(int(np.searchsorted(omega, w, side="right")) - 1, 1)
                left, right = radius[i] + slope * (w - omega[i]), radius[i + 1] + slope * (omega[i + 1] - w)
                points = perc[i] + left * DISC
                points = points[np.abs(points - perc[i + 1]) <= right]
                seen = noticed(name, w, np.full(len(points), 15j * w + 100 - 1.8 * w**2), points)[key]
                assert code != 1 or seen.all()
                assert code != -1 or not seen.any()


@pytest.mark.slow
def test_where_neither_part_is_noticed_alone_both_are_named(tmp_path: Path, call: Callable[..., Any]) -> None:
    (tmp_path / "bench.csv").write_text("omega,real,imag,radius\n2,100.6,37,0.1\n3,92,45,30\n", encoding="utf-8")
    (tmp_path / "bench.toml").write_text(
        '[environment]\nmodel = "mass-spring-damper"\nm = "1.8 kg"\nb = "15 N*s/m"\nk = "100 N/m"\n'
        '[perceived]\nfile = "bench.csv"\n[evaluation]\njnd = { shape = "diamond", real = 0.1, imag = 0.1 }\n',
        encoding="utf-8",
    )
    status, out, _ = call("evaluate", str(tmp_path / "bench.toml"), "--json", "--figures", str(tmp_path))
    document = json.loads(out)
    assert (status, [x["joint"] for x in document["rows"]]) == (0, ["exceeds", "unresolved"])
    assert [(x["part"], x["property"], x["change"]) for x in document["percepts"]] == [
        ("joint", ["damping", "stiffness"], ["higher", "higher"])
    ]
    assert document == hs.evaluate(tmp_path / "bench.toml").to_dict()
    assert {x.name for x in tmp_path.glob("*.png")} == {"ratios.png", "nyquist.png", "plane.png"}
    text = " ".join(call("evaluate", str(tmp_path / "bench.toml"))[1].split())
    assert "The change lies outside the diamond at 1 of 2 lines" in text
    assert "both" in text


def test_where_the_environment_is_zero_the_floor_is_what_is_noticed() -> None:
    spring_and_mass = hs.environments.mass_spring_damper(m=1, k=100)
    felt = hs.measured([10.0], [5 + 12j], radius=[2.0])
    e = hs.evaluate(hs.MeasuredScene(spring_and_mass, felt, threshold=_threshold("floor")))
    assert [(x.real.value, x.imag.value) for x in e.rows] == [("below", "exceeds")]


# The distance from an ellipse, with sixty digits.


def from_ellipse(a: float, b: float, tilt: float, x: float, y: float) -> mpmath.mpf:
    """By the foot of the perpendicular in the principal axes, on them in closed form; negative inside."""
    a, b, tilt, x, y = map(mpmath.mpf, (a, b, tilt, x, y))
    mixed, apart = tilt * a * b, (a * a - b * b) / 2
    turned, size = mpmath.atan2(mixed, apart) / 2, mpmath.hypot(mixed, apart)
    long, short = mpmath.sqrt((a * a + b * b) / 2 + size), mpmath.sqrt((a * a + b * b) / 2 - size)
    u, v = abs(x * mpmath.cos(turned) + y * mpmath.sin(turned)), abs(y * mpmath.cos(turned) - x * mpmath.sin(turned))
    if v < mpmath.mpf(10) ** -50:
        known = [abs(u - long)] + [short * mpmath.sqrt(1 - u * u / (2 * size))] * (u * long < 2 * size)
        found = min(known)
    else:
        low, high = short * v, mpmath.hypot(long * u, short * v)
        for _ in range(250):
            t = (low + high) / 2
            low, high = (t, high) if (long * u / (t + 2 * size)) ** 2 + (short * v / t) ** 2 > 1 else (low, t)
        found = mpmath.hypot(u - long**2 * u / (t + 2 * size), v - short**2 * v / t)
    return -found if (u / long) ** 2 + (v / short) ** 2 <= 1 else found


@pytest.mark.slow
def test_the_distance_from_an_ellipse_has_its_digits_on_and_beside_its_axes_too() -> None:
    chance = random.Random(3)
    for _ in range(150):
        a, b = (10 ** chance.uniform(-3, 1) for _ in range(2))
        tilt = chance.choice([0, 0, chance.uniform(-0.999, 0.999), 1 - 10 ** chance.uniform(-8, -1)])
        x, y = (10 ** chance.uniform(-4, 1) * chance.choice([-1, 0, 1, 1, 1e-9]) for _ in range(2))
        [found] = _from_ellipse(*(np.array([float(z)]) for z in (a, b, tilt, x, y)))
        with mpmath.workdps(60):
            assert abs(found - from_ellipse(a, b, tilt, x, y)) < 2e-14 * (1 + abs(complex(x, y)))


@pytest.mark.parametrize(("radius", "verdict"), [(0.099595, "below"), (0.099603, "unresolved")])
def test_a_change_along_an_axis_of_an_ellipse_is_told_up_to_its_depth(radius: float, verdict: str) -> None:
    """0.01 along the long axis of an ellipse of 0.15 by 0.1: sqrt(0.00992) = 0.0995992 deep."""
    felt = hs.measured([2.0], [101.0], radius=[100 * radius])
    jnd = read_threshold({"shape": "ellipse", "real": "0.15", "imag": "0.1"})
    spring = hs.environments.mass_spring_damper(k=100)
    [row] = hs.evaluate(hs.MeasuredScene(spring, felt, threshold=jnd)).rows
    assert row.joint is not None
    assert row.joint.value == verdict


def test_a_formula_is_known_to_its_last_digits_where_its_terms_cancel() -> None:
    """(omega - 15)^8 written out has terms of 10^11, of which floats keep 10^-5: as much as a change is off its threshold here."""
    formula = (Rational(1, 10) + (OMEGA - 15) ** 8 / (OMEGA + 1)).expand()
    at = np.concatenate([np.linspace(14, 16, 41), [0.0, 15.0, 300.0]])
    exact = [Fraction(1, 10) + (Fraction(x) - 15) ** 8 / (Fraction(x) + 1) for x in at.tolist()]
    assert values_of(formula, at).tolist() == pytest.approx(list(map(float, exact)), rel=1e-13, abs=0)
    omega, env = np.array([14.95, 15.0, 15.05]), np.full(3, 100 + 0j)
    c = read_threshold({"real": "0.1 + (omega - 15)^8", "imag": 0.1})
    for change, verdict in ((0.100001, "exceeds"), (0.099999, "below")):
        felt = hs.measured(omega, env * (1 + change), radius=np.full(3, 1e-9))
        rows = hs.evaluate(hs.MeasuredScene(hs.measured(omega, env), felt, threshold=c)).rows
        assert [row.real.value for row in rows] == [verdict] * 3
