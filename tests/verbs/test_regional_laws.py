"""Excesses of JND regions over band and box: at points the sign of the region's own definition, whatever is felt and varies."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from regions import _part, margin

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.model.jnd import Part
from haptisym.verbs.tolerances.box import box_of
from haptisym.verbs.tolerances.excess import Excess
from haptisym.verbs.tolerances.regional import RegionalExcess, excess_of, seen_as

FELT: dict[str, tuple[Any, Any]] = {
    "spring": (hs.environments.mass_spring_damper(k=["80", "120"]), lambda s, p: p["k"]),
    "damper": (hs.environments.mass_spring_damper(b=["4", "6"]), lambda s, p: p["b"] * s),
    "mass": (hs.environments.mass_spring_damper(m=["1", "2"]), lambda s, p: p["m"] * s**2),
    "all": (
        hs.environments.mass_spring_damper(m=["1", "2"], b=["4", "6"], k=["80", "120"]),
        lambda s, p: p["m"] * s**2 + p["b"] * s + p["k"],
    ),
    "damper and mass": (
        hs.environments.mass_spring_damper(m=["1", "2"], b=["4", "6"]),
        lambda s, p: p["m"] * s**2 + p["b"] * s,
    ),
}
PENTAGON = [[0.22, 0.02], [0.03, 0.2], [-0.1, 0.09], [-0.08, -0.08], [0.05, -0.19]]
JNDS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", "real": 0.2, "imag": 0.1, "tilt": -0.5},
    "round": {"shape": "ellipse", "real": 0.15, "imag": 0.1},
    "diamond": {"shape": "diamond", "real": 0.12, "imag": 0.2},
    "polygon": {"shape": "polygon", "corners": PENTAGON},
    "two limits": {"real": {"higher": 0.08, "lower": 0.2}, "imag": {"higher": 0.2, "lower": 0.05}},
    "two limits and a floor": {"real": {"higher": 0.08, "lower": 0.2}, "imag": {"higher": 0.2, "lower": 0.05}, "floor": "8"},
    "floor": {"real": 0.1, "imag": 0.2, "floor": "12"},
    "formula": {"real": "0.08 + 0.01*omega", "imag": "1/(omega + 2)"},
    "tilt of a formula": {"shape": "ellipse", "real": "0.08 + 0.01*omega", "imag": 0.2, "tilt": "omega/30"},
}  # fmt: skip


def scene_of(felt: str, jnd: Any) -> hs.Scene:
    """Behind a lag, and beside a device whose mass may be negative."""
    effects = hs.effects.first_order_lag(["20", "60"]), hs.effects.series("g", parameters={"g": ["0.8", "1.3"]})
    return hs.Scene(FELT[felt][0], effects, ("0.5", 15), jnd)


def at(box: Any, shares: Any) -> tuple[float, dict[str, float]]:
    low, high = (float(x) for x in box.scene.band)
    values = {x.name: float(x.at(Fraction(y))) for x, y in zip(box.sides, shares[1:].tolist(), strict=True)}
    return low + (high - low) * shares[0], values


def changed(felt: str, omega: float, values: dict[str, float]) -> tuple[complex, complex]:
    s = 1j * omega
    H = complex(FELT[felt][1](s, values))
    return H, H / (1 + s / values["omega_c"]) * values["g"]


@pytest.mark.parametrize(
    ("name", "felt"), [(x, [*FELT][(i + k) % 5]) for i, x in enumerate(JNDS) for k in (0, 2)[: 1 + i % 2]]
)
def test_at_a_point_an_excess_has_the_sign_of_the_region(name: str, felt: str) -> None:
    """Sixty frequencies and sets of values; of several criteria one that is positive is enough."""
    asked = scene_of(felt, JNDS[name])
    box, rng = box_of(asked), np.random.default_rng(7)
    points = rng.uniform(0, 1, (60, 1 + len(box.sides)))
    forms = [excess_of(box, x) for x in noticed(asked.threshold)]
    cells = np.stack([points, points], -1)
    found = [tuple(y[:, 0] for y in form.model(cells, slopes=0).bounds()) for form in forms]
    written = json.loads(json.dumps(JNDS[name]))
    decided, outside = 0, 0
    for i, point in enumerate(points):
        omega, values = at(box, point)
        true = margin(written, *changed(felt, omega, values), omega)
        if abs(true) < 1e-6:
            continue
        assert any(low[i] > 0 for low, _ in found) is bool(true > 0)
        assert all(high[i] < 0 for _, high in found) is bool(true < 0)
        decided += 1
        outside += true > 0
    assert decided > 50
    assert outside > 3


@pytest.mark.parametrize("name", [*JNDS][::2])
def test_along_a_side_on_which_a_slope_keeps_its_sign_the_border_is_crossed_one_way_alone(name: str) -> None:
    """In cells of a tenth of each range: from one end of a side to the other, at random values of all others."""
    asked = scene_of("all", JNDS[name])
    box, rng = box_of(asked), np.random.default_rng(3)
    written, seen = json.loads(json.dumps(JNDS[name])), 0
    for criterion in noticed(asked.threshold):
        form = excess_of(box, criterion)
        assert isinstance(form, RegionalExcess)
        assert form.matters.tolist() == [True] * form.sides
        assert not form.is_zero
        cells = np.sort(rng.uniform(0, 0.9, (40, form.sides, 1)) + np.array([0, 0.1]), -1)
        low, high = form.model(cells).bounds()
        for i in np.flatnonzero((low[:, 0] <= 0) & (high[:, 0] >= 0)):
            for side in range(form.sides):
                way = int(low[i, 1 + side] > 0) - int(high[i, 1 + side] < 0)
                if not way:
                    continue
                ends = []
                point = cells[i, :, 0] + rng.uniform(0, 0.1, form.sides)
                for end in cells[i, side]:
                    point[side] = end
                    omega, values = at(box, point)
                    H, G = changed("all", omega, values)
                    ends.append(one_of(written, criterion, H, G, omega))
                seen += 1
                assert not (way * ends[0] > 1e-9 and way * ends[1] < -1e-9)
    assert seen > 2


def one_of(jnd: Any, criterion: Any, H: complex, G: complex, omega: float) -> float:
    """The margin of one criterion alone."""
    own = criterion.name
    if criterion.part is None:
        return margin(jnd, H, G, omega)
    return _part(jnd, own, getattr(H, own), getattr(G, own), abs(H), omega)


REGION = {"shape": "ellipse", "real": ["0.1", "0.2"], "imag": ["0.1", "0.2"]}


def test_where_one_half_width_varies_it_is_a_side_and_the_region_grows_with_it() -> None:
    """A disc of c: |dH/H|^2 - c^2, times c^2 or not: the sign alone is told."""
    asked = scene_of("spring", REGION)
    box = box_of(asked)
    assert [x.name for x in box.sides] == ["k", "omega_c", "g", "c"]
    [criterion] = noticed(asked.threshold)
    form = excess_of(box, criterion)
    assert form.matters.tolist() == [True] * 5
    rng = np.random.default_rng(2)
    points = rng.uniform(0, 1, (60, 5))
    low, high = (x[:, 0] for x in form.model(np.stack([points, points], -1), slopes=0).bounds())
    for i, point in enumerate(points):
        omega, values = at(box, point)
        H, G = changed("spring", omega, values)
        true = abs(G - H) / abs(H) - values["c"]
        assert (low[i] > 0, high[i] < 0) == (true > 0, true < 0)


def test_a_plain_number_is_judged_by_its_ratio_and_all_else_by_its_region() -> None:
    for jnd, plain in (({"real": 0.1, "imag": 0.2}, True), *((x, False) for x in [*JNDS.values()][::3])):
        asked = scene_of("spring", jnd)
        box = box_of(asked)
        for criterion in noticed(asked.threshold):
            form = excess_of(box, criterion)
            assert isinstance(form, Excess)
            assert isinstance(form, RegionalExcess) is not plain


def test_parts_change_places_with_each_odd_number_of_quarters() -> None:
    for n in range(8):
        assert seen_as(Part.REAL, n) is (Part.IMAG if n % 2 else Part.REAL)
        assert seen_as(Part.IMAG, n) is (Part.REAL if n % 2 else Part.IMAG)


def test_a_region_in_which_nothing_changes_is_zero_and_one_part_alone_of_a_limit_for_each_way() -> None:
    felt = hs.environments.mass_spring_damper(k=["80", "120"])
    damper, mass = (hs.effects.shunt(b=1),), (hs.effects.shunt(m=1),)
    for effects, jnd, zero in (
        ((), "ellipse", [True]), (damper, "ellipse", [False]), (mass, "diamond", [False]), ((), "polygon", [True]),
        (damper, "two limits", [True, False]), (mass, "two limits", [False, True]), ((), "floor", [True, True]),
    ):  # fmt: skip
        asked = hs.Scene(felt, effects, ("0.5", 15), JNDS[jnd])
        forms = [excess_of(box_of(asked), x) for x in noticed(asked.threshold)]
        assert [x.is_zero for x in forms] == zero


@pytest.mark.parametrize("name", JNDS)
def test_a_region_is_left_from_rest_on_as_its_limits_say_where_what_is_felt_vanishes_there(name: str) -> None:
    """A damper, or a mass, behind gains from 0.7 to 1.4: the change is g - 1 at all frequencies, from 0 on."""
    for felt in ("damper", "mass")[len(name) % 2 :][:1]:
        jnd = json.loads(json.dumps(JNDS[name]))
        jnd.pop("floor", None)
        series = hs.effects.series("g", parameters={"g": ["0.7", "1.4"]})
        box = box_of(hs.Scene(FELT[felt][0], (series,), (0, 15), jnd))
        forms = [excess_of(box, x) for x in noticed(box.scene.threshold)]
        shares = np.linspace(0.01, 0.99, 60)
        for omega in (0.0, 1e-9, 0.4):
            cells = np.tile([[[omega, omega], [0.5, 0.5], [0.0, 0.0]]], (60, 1, 1))
            cells[:, 2] = shares[:, None]
            found = [tuple(y[:, 0] for y in form.model(cells, slopes=0).bounds()) for form in forms]
            for i, share in enumerate(shares):
                s = 1j * (15 * omega or 1e-12)
                H = FELT[felt][1](s, {"b": 5.0, "m": 1.5})
                true = margin(jnd, H, H * (0.7 + 0.7 * share), 15 * omega)
                if abs(true) > 1e-4:
                    assert not (true < 0 and any(low[i] > 0 for low, _ in found))
                    assert not (true > 0 and all(high[i] < 0 for _, high in found))
                    assert omega == 0 or any(low[i] > 0 for low, _ in found) is bool(true > 0)
