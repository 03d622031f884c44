"""The explorer of a page without a browser: its sliders, the record that its script reads, and what is said around them."""

from __future__ import annotations

import json
import re
from functools import cache
from html import unescape
from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Rational

import haptisym as hs
from haptisym.model.parameters import Rule
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.model.scenefile import parse_scene
from haptisym.pages.explorer import _parameter, _probe, explorer
from haptisym.pages.sceneforms import SceneForms
from haptisym.pages.sliders import Slider, limit_sliders, region_record
from haptisym.writing.htmltext import Html

E, F = hs.environments, hs.effects
SPRING = E.mass_spring_damper(k="100 N/m")
WALL = parse_scene("""
environment = { model = "mass-spring-damper", m = "2 kg", b = 3, k = 100 }
effects = [{ model = "second-order-lowpass", omega_n = 80, zeta = "0.5", name = "filter" }, { model = "shunt", b = 1 }]
evaluation = { band = [1, 12], jnd = "0.1" }
""")


@cache
def shown(scene: hs.Scene) -> str:
    e = hs.evaluate(scene)
    return str(explorer(e, SceneForms(e)))


def record(scene: hs.Scene) -> dict[str, Any]:
    found = re.search(r'id="explorer-data"[^>]*>(.*?)</script>', shown(scene), re.DOTALL)
    assert found
    return dict(json.loads(unescape(found[1])))


def words(scene: hs.Scene) -> str:
    """What is to be read, without scripts."""
    text = re.sub(r"<(script|style|math)\b.*?</\1>", "", shown(scene), flags=re.DOTALL)
    return " ".join(unescape(re.sub(r"<[^>]*>", " ", text)).split())


# One slider for each parameter


def slider(
    value: object, rule: Rule, dimension: Dimension = Dimension.STIFFNESS, motion: MotionKind | None = None
) -> Slider:
    own: Any = Made(value=Rational(str(value)), rule=rule, dimension=dimension, unit_in=dimension.unit)
    return _parameter(own, "x", Html("k"), motion)


@pytest.mark.parametrize("value", ["7", "0.02", "1000"])
@pytest.mark.parametrize("rule", [Rule.POSITIVE, Rule.NONNEGATIVE])
def test_a_positive_number_has_a_decade_to_each_side_on_a_logarithmic_scale(value: str, rule: Rule) -> None:
    x = slider(value, rule)
    own = float(value)
    assert (x.low, x.high, x.is_logarithmic, x.value, x.unit) == (own / 10, own * 10, True, own, "N/m")
    assert (x.record()["open"], x.record()["least"], x.record()["most"]) == (rule is Rule.POSITIVE, 0, None)


@pytest.mark.parametrize(
    ("dimension", "most"),
    [(Dimension.TIME, 0.1), (Dimension.FORCE, 1.0), (Dimension.DAMPING, 1.0), (Dimension.RATIO, 1.0)],
)
def test_a_number_that_is_zero_moves_up_from_there(dimension: Dimension, most: float) -> None:
    x = slider(0, Rule.NONNEGATIVE, dimension)
    assert (x.low, x.high, x.value, x.is_logarithmic) == (0.0, most, 0.0, False)
    assert (x.unit == "") == (dimension is Dimension.RATIO)


@pytest.mark.parametrize("value", [-3, 0, 5])
def test_a_number_of_either_sign_moves_as_far_to_both_sides_and_may_be_typed_without_bounds(value: int) -> None:
    x = slider(value, Rule.ANY)
    reach = 2.0 * abs(value) or 1.0
    assert (x.low, x.high, x.is_logarithmic) == (-reach, reach, False)
    assert (x.record()["least"], x.record()["most"], x.record()["open"], x.record()["log"]) == (
        None,
        None,
        False,
        False,
    )


def test_a_share_stays_between_0_and_1() -> None:
    x = slider("0.3", Rule.FRACTION, Dimension.RATIO)
    assert (x.low, x.high, x.is_logarithmic) == (0.01, 0.99, False)
    told = x.record()
    assert (told["least"], told["open"], told["most"]) == (0, True, 1 - 2**-53)
    assert told["most"] < 1


def test_units_are_those_of_the_scenes_motion() -> None:
    assert slider(2, Rule.POSITIVE, motion=MotionKind.ROTATION).unit == "N·m/rad"
    assert slider(2, Rule.POSITIVE, motion=MotionKind.TRANSLATION).unit == "N/m"


def test_the_frequency_at_which_values_are_told_is_the_middle_of_the_band_at_first() -> None:
    x, what = _probe(hs.evaluate(hs.Scene(SPRING, (F.first_order_lag(20),), (Rational(1, 3), 12), "0.1")))
    assert (x.low, x.high, x.most, x.unit) == (1 / 3, 12.0, 12.0, "rad/s")
    assert x.value == float(f"{(1 / 3 + 12) / 2:.4g}") == 6.167
    assert (x.identity, x.rule, x.is_logarithmic) == ("explorer-omega", Rule.NONNEGATIVE, False)
    assert what == "frequency at which values are told"


# A control


def test_a_control_has_a_slider_and_a_box_and_each_says_what_it_is() -> None:
    for unit in ("N/m", ""):
        text = str(Slider("x-1", Html("k"), unit, 1.0, 0.1, 10.0, Rule.POSITIVE).control("k of environment"))
        assert text.count('for="x-1"') == text.count('id="x-1"') == text.count('id="x-1-value"') == 1
        assert 'aria-label="k of environment"' in text
        assert (f'aria-label="k of environment, {unit}"' in text) == bool(unit)
        assert text.count('aria-label="k of environment"') == (1 if unit else 2)
        assert text.count('type="range"') == text.count('type="number"') == 1
        assert f"<span>{unit}</span>" in text


# The record


def test_the_record_tells_the_band_the_unit_and_where_each_number_stands_in_the_file() -> None:
    told = record(WALL)
    assert told["band"] == [1.0, 12.0]
    assert told["unit"] == "N/m"
    names = [f"explorer-{n}" for n in range(6)]
    assert [x["id"] for x in told["sliders"]] == [*names, "explorer-c", "explorer-omega"]
    assert told["limits"] == ["explorer-c"]
    assert sorted(told["arguments"]) == names
    assert told["paths"] == [
        ["explorer-0", "environment", "m"], ["explorer-1", "environment", "b"], ["explorer-2", "environment", "k"],
        ["explorer-3", 0, "omega_n"], ["explorer-4", 0, "zeta"], ["explorer-5", 1, "b"],
    ]  # fmt: skip
    assert [x["value"] for x in told["sliders"]] == [2.0, 3.0, 100.0, 80.0, 0.5, 1.0, 0.1, 6.5]
    assert told["environment"] is None
    assert told["region"] == region_record(WALL.threshold, limit_sliders(WALL))
    assert 'title="omega_n of filter"' in shown(WALL)
    assert 'title="k of environment"' in shown(WALL)


def test_a_number_that_stands_in_several_places_has_a_path_for_each() -> None:
    tied = parse_scene("""
environment = { model = "mass-spring-damper", k = 100, b = 2 }
rendered = { model = "mass-spring-damper", k = 120, b = "environment.b" }
effects = [{ model = "first-order-lag", omega_c = 20 }]
evaluation = { band = [1, 12], jnd = "0.1" }
""")
    places: dict[str, list[Any]] = {}
    for identity, *place in record(tied)["paths"]:
        places.setdefault(identity, []).append(place)
    for place in ([["environment", "k"]], [["rendered", "k"]], [[0, "omega_c"]]):
        assert place in places.values()
    assert len(places) == 4
    assert [["environment", "b"], ["rendered", "b"]] in places.values()


def test_of_several_environments_of_a_file_the_record_names_the_one_of_the_page() -> None:
    text = """
environments = [{ model = "mass-spring-damper", k = 100, name = "soft" }, { model = "mass-spring-damper", k = 900, name = "stiff" }]
effects = [{ model = "first-order-lag", omega_c = 20 }]
evaluation = { band = [1, 12], jnd = "0.1" }
"""
    for name in ("soft", "stiff"):
        assert record(parse_scene(text, environment=name))["environment"] == name


@cache
def delayed() -> hs.Scene:
    return hs.Scene(SPRING, (F.delay("10 ms"), F.shunt(b=1)), (1, 12), {"real": "0.1", "imag": "0.2"})


def many() -> hs.Scene:
    """More factors than are multiplied out in symbols."""
    own = tuple(F.second_order_lowpass(f"{350 + n} rad/s", "0.5", name=f"f{n}") for n in range(12))
    return hs.Scene(E.mass_spring_damper(m=2, b=3, k=100), own, (1, 12), "0.1")


def test_what_is_proven_when_sliders_rest_is_said_only_where_it_can_be() -> None:
    exact = "When the sliders rest, crossings are found once more in exact arithmetic: that line is proven."
    for scene, is_proven in ((WALL, True), (delayed(), False), (many(), False)):
        assert (exact in words(scene)) == is_proven
        assert ('id="explorer-proven"' in shown(scene)) == is_proven
        assert bool(record(scene)["paths"]) == is_proven
        assert shown(scene).count('id="explorer-band"') == shown(scene).count('id="explorer-probe"') == 1


def test_where_parameters_are_too_many_only_the_threshold_moves() -> None:
    told = "The parameters are too many for a formula in all of them, so only the JND moves."
    for scene, is_small in ((WALL, True), (many(), False)):
        assert (told in words(scene)) is not is_small
        assert bool(record(scene)["arguments"]) == is_small
    assert [x["id"] for x in record(many())["sliders"]] == ["explorer-c", "explorer-omega"]
    assert [x["id"] for x in record(delayed())["sliders"]][-3:] == [
        "explorer-c-real",
        "explorer-c-imag",
        "explorer-omega",
    ]
    assert record(delayed())["limits"] == ["explorer-c-real", "explorer-c-imag"]


def test_the_first_plot_is_of_ratios_for_a_square_and_of_how_much_a_region_must_grow_for_another() -> None:
    ellipse = hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), {"shape": "ellipse", "real": "0.1", "imag": "0.2"})
    assert "(solid), (dashed); transparent band in grey" in re.sub(r" (?=[,;])", "", words(WALL))
    told = "how many times the ellipse must be enlarged to hold"
    assert told in words(ellipse)
    assert "more than once where it is noticed; transparent band in grey" in words(ellipse)
    assert told.replace("ellipse", "square") not in words(WALL)
    for scene in (WALL, ellipse):
        assert re.findall(r'<svg[^>]*id="(explorer-\w+)"', shown(scene)) == [
            "explorer-ratios",
            "explorer-nyquist",
            "explorer-region",
        ]


# Limits of the region


def test_one_slider_is_for_both_widths_where_they_are_the_same_number_and_reach_no_further_one_way() -> None:
    def keys(jnd: Any) -> list[str]:
        return list(limit_sliders(hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), jnd)))

    assert keys("0.1") == keys({"real": "0.1", "imag": "0.1"}) == ["real", "imag"]
    found = limit_sliders(hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), "0.1"))
    assert found["real"] is found["imag"]
    apart = limit_sliders(hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), {"real": "0.1", "imag": "0.2"}))
    assert apart["real"][0].identity != apart["imag"][0].identity
    lower = {"higher": "0.1", "lower": "0.05"}
    assert keys({"real": lower, "imag": "0.1"}) == ["real", "real.lower", "imag"]
    assert keys({"real": lower, "imag": lower}) == ["real", "real.lower", "imag", "imag.lower"]
    moving = "(1 + omega)/(20 + omega)"
    assert keys({"real": moving, "imag": moving}) == []
    assert keys({"real": moving, "imag": "0.2"}) == ["imag"]
    assert keys({"real": {"higher": "0.1", "lower": moving}, "imag": "0.1"}) == ["real", "imag"]
    assert keys({"real": "0.1", "imag": "0.1", "floor": "2 N/m"}) == ["real", "imag", "floor"]
    assert keys({"real": "0.1", "imag": "0.1", "floor": "2 + omega"}) == ["real", "imag"]
    disc = {"shape": "ellipse", "real": "0.1", "imag": "0.1"}
    assert keys(disc) == ["real", "imag", "tilt"]
    assert keys(disc | {"tilt": "omega/50"}) == ["real", "imag"]


def test_numbers_of_a_region_that_do_not_move_are_quotients_of_polynomials() -> None:
    moving = {"shape": "ellipse", "real": "(1 + omega)/(20 + omega^2)", "imag": "0.2", "tilt": "omega/50"}
    scene = hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), moving)
    told = region_record(scene.threshold, limit_sliders(scene))
    assert (told["shape"], told["corners"], set(told["numbers"])) == ("ellipse", [], {"real", "imag", "tilt"})
    floored = hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), {"real": "0.1", "imag": "0.1", "floor": "3 + omega"})
    assert region_record(floored.threshold, limit_sliders(floored))["numbers"]["floor"] == {
        "top": [3.0, 1.0],
        "bottom": [1.0],
    }
    numbers = told["numbers"]
    assert numbers["imag"] == {"slider": "explorer-c-imag"}
    cases: list[tuple[str, Any]] = [("real", lambda w: (1 + w) / (20 + w * w)), ("tilt", lambda w: w / 50)]
    for key, true in cases:
        for w in (1.0, 5.0, 12.0):
            top, bottom = (sum(c * w**n for n, c in enumerate(numbers[key][x])) for x in ("top", "bottom"))
            assert top / bottom == pytest.approx(true(w))
    apart = {"real": {"higher": "0.1", "lower": "omega/100"}, "imag": {"higher": "omega/40", "lower": "0.2"}}
    lower = hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), apart)
    numbers = region_record(lower.threshold, limit_sliders(lower))["numbers"]
    assert numbers["real.lower"] == {"top": [0.0, 1.0], "bottom": [100.0]}
    assert numbers["imag"] == {"top": [0.0, 1.0], "bottom": [40.0]}
    assert numbers["real"] == {"slider": "explorer-c-real"}
    assert numbers["imag.lower"] == {"slider": "explorer-c-imag-lower"}
    corners = [["0.1", "0"], ["0", "omega/50"], ["-0.1", "0"], ["0", "-0.1"]]
    polygon = hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), {"shape": "polygon", "corners": corners})
    told = region_record(polygon.threshold, limit_sliders(polygon))
    assert told["numbers"] == {"size": {"slider": "explorer-size"}}
    values = [
        [
            sum(c * 5.0**n for n, c in enumerate(x["top"])) / sum(c * 5.0**n for n, c in enumerate(x["bottom"]))
            for x in corner
        ]
        for corner in told["corners"]
    ]
    assert values == [[0.1, 0], [0, 0.1], [-0.1, 0], [0, -0.1]]
    assert told["corners"][0][0] == {"top": [0.1], "bottom": [1.0]}
    plain = hs.Scene(SPRING, (F.first_order_lag(20),), (1, 12), "0.1")
    assert set(region_record(plain.threshold, limit_sliders(plain))["numbers"]) == {"real", "imag"}
