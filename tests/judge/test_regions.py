"""JND regions: published and derived crossings, and every region against an independent scan of random scenes."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from jnds import jnds
from oracles import DIGITS, MP, Case
from regions import margin, outside
from strategies import cases, scene
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.criteria import noticed
from haptisym.judge.percepts import Property
from haptisym.judge.spread import half_widths
from haptisym.model.jndtables import read_threshold
from haptisym.programs.formulas import floats_of

PAPER = hs.load_scene("fu2019")
UNEQUAL = [["0.2", 0], [0, "0.3"], ["-0.2", 0], [0, "-0.05"]]


def judged(jnd: Any, plain: hs.Scene = PAPER) -> hs.Evaluation:
    """A scene with another JND."""
    return hs.evaluate(hs.Scene(plain.environment, plain.effects, plain.band, jnd))


WIDE = {"real": 0.1, "imag": 0.1}
SQUARE_CORNERS = [[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]]
FACTS: dict[str, tuple[Any, list[tuple[str, str, float]]]] = {
    "square": (0.1, [("real", "exceeds", 7.978916790174708), ("imag", "exceeds", 11.937310924322059)]),
    "disc": ({"shape": "ellipse", **WIDE}, [("joint", "exceeds", 7.922311857140609)]),
    "ellipse along the diagonal": (
        {"shape": "ellipse", **WIDE, "tilt": 0.5},
        [("joint", "exceeds", 5.919946018706412)],
    ),
    "ellipse across it": ({"shape": "ellipse", **WIDE, "tilt": -0.5}, [("joint", "exceeds", 7.147634692279112)]),
    "diamond": ({"shape": "diamond", **WIDE}, [("joint", "exceeds", 7.627045310833144)]),
    "diamond by its corners": (
        {"shape": "polygon", "corners": [[0.1, 0], [0, 0.1], [-0.1, 0], [0, -0.1]]},
        [("joint", "exceeds", 7.627045310833144)],
    ),
    "square by its corners": (
        {"shape": "polygon", "corners": SQUARE_CORNERS},
        [("joint", "exceeds", 7.978916790174708)],
    ),
    "sooner noticed where it grows": (
        {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1},
        [
            ("real", "exceeds", 6.533581844485884),
            ("real", "returns", 7.657526552494918),
            ("imag", "exceeds", 11.937310924322059),
        ],
    ),
    "sooner noticed where it shrinks": (
        {"real": {"higher": 0.12, "lower": 0.08}, "imag": 0.1},
        [("real", "exceeds", 7.657526552494918), ("imag", "exceeds", 11.937310924322059)],
    ),
    "floor": (
        {**WIDE, "floor": "15 N/m"},
        [("real", "exceeds", 8.88766189298739), ("imag", "exceeds", 11.937310924322059)],
    ),
    "limit that grows with omega": ("0.08 + 0.004*omega", [("imag", "exceeds", 13.845284093670381)]),
}


@pytest.mark.parametrize("name", FACTS)
def test_the_papers_example_is_noticed_where_an_independent_scan_found_it(name: str) -> None:
    jnd, expected = FACTS[name]
    found = judged(jnd).crossings
    assert [(c.criterion.name, c.kind.value) for c in found] == [(part, kind) for part, kind, _ in expected]
    for crossing, (_, _, omega) in zip(found, expected, strict=True):
        assert float(crossing.omega) == pytest.approx(omega, rel=3e-15)


def test_a_limit_that_jumps_is_said_to_and_splits_the_transparent_set() -> None:
    found = judged(FACTS["sooner noticed where it grows"][0])
    assert [c.jump for c in found.crossings] == [False, True, False]
    assert [x["limit"] for x in found.to_dict()["crossings"] if "limit" in x] == ["changes"]
    assert len(found.transparent) == 2
    assert found.transparent[1].low.omega is found.crossings[1].omega


def test_what_neither_part_alone_would_show_is_felt_in_both_the_nearer_one_last() -> None:
    found = judged(FACTS["disc"][0])
    [together] = [p for p in found.percepts if p.part is None]
    assert [float(x.omega) for x in (together.band.low, together.band.high)] == pytest.approx(
        [7.922311857140609, 7.978916790174708], rel=1e-15
    )
    assert together.property is Property.MASS  # r_r is nearly 0.1 there, r_i is 0.01
    row = next(x for x in found.to_dict()["percepts"] if x["part"] == "joint")
    assert (row["property"], row["change"]) == (["damping", "mass"], ["higher", "lower"])


def test_an_ellipse_whose_axes_lie_along_the_parts_is_left_before_the_rectangle_around_it() -> None:
    rectangle, ellipse = judged({"real": 0.1, "imag": 0.12}), judged({"shape": "ellipse", "real": 0.1, "imag": 0.12})
    assert float(ellipse.bandwidth or 0) < float(rectangle.bandwidth or 0)


# --- every region, at random scenes, against plain complex arithmetic ------------------------------------------------


def numeric(case: Case, omega: float) -> tuple[complex, complex]:
    H, G = case.dynamics(MP.mpc(0, omega), DIGITS)
    return complex(H), complex(G)


def between(found: hs.Evaluation) -> list[float]:
    """Frequencies well inside all pieces of the band on which nothing changes."""
    ends = [float(point.omega) for point in found.chart.points]
    return [a + share * (b - a) for a, b in pairwise(ends) if b - a > 1e-6 * b for share in (0.03, 0.35, 0.8, 0.98)]


@given(cases(order=3), jnds())
def test_a_region_is_left_exactly_where_plain_arithmetic_says_so(case: Case, jnd: dict[str, Any]) -> None:
    found = judged(jnd, scene(case))
    spans = [(float(x.low.omega), float(x.high.omega)) for x in found.transparent]
    assume(not found.unbounded)
    for omega in between(found):
        H, G = numeric(case, omega)
        by = margin(jnd, H, G, omega)
        if abs(by) > 1e-9 * (1 + abs(G / H)):
            assert (by <= 0) == any(low <= omega <= high for low, high in spans), (omega, by)


@given(cases(order=3), jnds())
def test_a_part_is_named_exactly_where_it_alone_would_be_outside(case: Case, jnd: dict[str, Any]) -> None:
    assume("shape" in jnd)
    found = judged(jnd, scene(case))
    felt = [(x.part, float(x.band.low.omega), float(x.band.high.omega)) for x in found.felt]
    for omega in between(found):
        H, G = numeric(case, omega)
        x, y = (G - H).real / abs(H), (G - H).imag / abs(H)
        signs = [outside(jnd, *at, omega) for at in ((x, y), (x, 0), (0, y))]
        if min(map(abs, signs)) < 1e-9 * (1 + abs(G / H)):
            continue
        told = {part for part, low, high in felt if low <= omega <= high}
        real, imag = signs[1] > 0, signs[2] > 0
        if signs[0] <= 0:
            assert not told
        elif G.imag < 0:  # outside the model: the imaginary part has no name there
            assert told == ({hs.Part.REAL} if real and not imag else {hs.Part.REAL, None} if real else {None})
        else:
            assert told == ({p for p, out in zip(hs.Part, (real, imag), strict=True) if out} or {None})


@given(cases(order=3))
def test_more_regions_agree_where_one_holds_the_other(case: Case) -> None:
    """The diamond lies in the disc, the disc in the square: who is transparent in the smaller is so in the larger."""
    plain = scene(case)
    sets = [judged(jnd, plain).transparent for jnd in ({"shape": "diamond", **WIDE}, {"shape": "ellipse", **WIDE}, 0.1)]
    for smaller, larger in pairwise(sets):
        for x in smaller:
            low, high = (float(end.omega) for end in (x.low, x.high))
            assert any(
                float(y.low.omega) <= low * (1 + 1e-12) and high <= float(y.high.omega) * (1 + 1e-12) for y in larger
            )


# --- side by side ----------------------------------------------------------------------------------------------------


def test_square_disc_and_diamond_stand_beside_the_scenes_own_region() -> None:
    found = hs.evaluate(PAPER, regions=True)
    rows = found.to_dict()["regions"]
    assert [x["region"] for x in rows] == ["square", "disc", "diamond", "the scene's own"]
    assert [x["bandwidth"] for x in rows] == pytest.approx(
        [7.978916790174708, 7.922311857140609, 7.627045310833144, 7.978916790174708], rel=1e-15
    )
    assert [x["crossing"]["part"] for x in rows] == ["real", "joint", "joint", "real"]
    assert "Does it survive another JND model?" in str(found)
    assert "regions" not in hs.evaluate(PAPER).to_dict()


@pytest.mark.few(2)
@pytest.mark.parametrize("name", FACTS)
def test_side_by_side_each_region_says_what_it_says_alone(name: str) -> None:
    jnd = FACTS[name][0]
    found = hs.evaluate(hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd), regions=True)
    for x in found.regions:
        alone = judged(x.threshold)
        assert (x.bandwidth and x.bandwidth.digits(20)) == (alone.bandwidth and alone.bandwidth.digits(20))
        assert (x.crossing and x.crossing.omega.digits(20)) == (
            alone.crossings[0].omega.digits(20) if alone.crossings else None
        )


def test_a_region_beside_others_is_told_with_its_first_crossing_and_its_bandwidth() -> None:
    found = hs.evaluate(PAPER, digits=7, regions=True)
    for x, row in zip(found.regions, found.to_dict()["regions"], strict=True):
        first = x.crossing
        assert first is not None
        assert x.bandwidth is not None
        low, high = (float(y) for y in row["crossing"]["enclosure"])
        assert low <= float(first.omega) <= high < low * (1 + 1e-6)
        assert row == {
            "region": x.name,
            "threshold": x.threshold.row(),
            "bandwidth": float(x.bandwidth),
            "crossing": {
                "part": first.criterion.name, "omega": float(first.omega), "kind": "exceeds", "digits": first.omega.digits(7),
                "enclosure": row["crossing"]["enclosure"],
            },
            "certified": True,
        }  # fmt: skip
        assert repr(x) == f"<Compared {x.name}: bandwidth {x.bandwidth.digits(5)}>"
    tight = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.series("2"),), PAPER.band, 0.1)
    for x in hs.evaluate(tight, regions=True).regions:  # noticed from the start on
        assert (x.crossing, x.bandwidth, x.transparent) == (None, None, ())
        assert (x.row(5)["crossing"], x.row(5)["bandwidth"], repr(x)) == (
            None,
            None,
            f"<Compared {x.name}: bandwidth none>",
        )


def test_a_polygon_that_moves_has_no_half_widths() -> None:
    corners = [[0.1, 0], [0, 0.1], [-0.1, 0], [0, "-0.1 - 0.001*omega"]]
    with pytest.raises(hs.SceneError, match="half widths"):
        hs.evaluate(
            hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, {"shape": "polygon", "corners": corners}),
            regions=True,
        )


# --- what is no region -----------------------------------------------------------------------------------------------

FAULTS: dict[str, tuple[Any, str]] = {
    "0 on an edge": ([[0, 0.1], [0, -0.1], [0.1, 0]], "0 must lie inside"),
    "0 outside": ([[0.1, 0.1], [0.3, 0.1], [0.2, 0.3]], "0 must lie inside"),
    "0 at a corner": ([[0, 0], [0.1, 0], [0, 0.1]], "0 must lie inside"),
    "two equal corners": ([[0.1, 0], [0, 0.1], [0, 0.1], [-0.1, 0], [0, -0.1]], "2 and 3 are one point"),
    "not convex": ([[0.1, 0], [0.01, 0.01], [0, 0.1], [-0.1, 0], [0, -0.1]], "convex"),
    "a corner on a straight edge": ([[0.1, 0], [0.05, 0.05], [0, 0.1], [-0.1, 0], [0, -0.1]], "convex"),
    "twice around": (
        [[0.1, 0], [-0.0809, 0.0588], [0.0309, -0.0951], [0.0309, 0.0951], [-0.0809, -0.0588]],
        "in their order around it",
    ),
    "two corners": ([[0.1, 0], [-0.1, 0]], "3 to"),
    "no pairs": ([1, 2, 3], "pair"),
    "not convex at the high end of the band": (
        [[0.1, 0], ["0.06 - 0.003*omega", "0.06 - 0.003*omega"], [0, 0.1], [-0.1, 0], [0, -0.1]],
        "convex",
    ),
    "0 on an edge at one frequency": (
        [["0.1 - omega/150", 0.1], ["0.1 - omega/150", -0.1], [-0.1, 0]],
        "0 must lie inside",
    ),
    "a formula that is no formula": ([["0.1 + omga", 0], [0, 0.1], [-0.1, -0.1]], "omga"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_polygon_that_is_none_is_refused_with_the_reason(name: str) -> None:
    corners, why = FAULTS[name]
    with pytest.raises(hs.SceneError, match="corners.*") as refused:
        judged({"shape": "polygon", "corners": corners})
    assert why in str(refused.value)


WRONG: dict[str, tuple[Any, str]] = {
    "limit that falls to 0": ("0.15 - 0.01*omega", "real: .* must be > 0 on the whole band"),
    "limit with a pole": ("0.1/(omega - 3)^2", "on the whole band"),
    "root": ("0.1*omega^0.5", "no rational formula"),
    "other name": ("0.1*w + omega", "unknown name"),
    "tilt of 1": ({"shape": "ellipse", **WIDE, "tilt": 1}, "tilt: 1 must lie strictly between -1 and 1"),
    "tilt that gets there": ({"shape": "ellipse", **WIDE, "tilt": "omega/15"}, "tilt: .* on the whole band"),
    "unknown shape": ({"shape": "elipse", **WIDE}, 'did you mean "ellipse"'),
    "floor of an ellipse": ({"shape": "ellipse", **WIDE, "floor": 1}, "of a square"),
    "tilt of a square": ({**WIDE, "tilt": 1}, "of a ellipse|of an ellipse"),
    "one way only": ({"real": {"higher": 0.1}, "imag": 0.1}, "both higher and lower"),
    "ways of an ellipse": ({"shape": "ellipse", "real": {"higher": 0.1, "lower": 1}, "imag": 0.1}, "square alone"),
    "floor of nothing": ({**WIDE, "floor": 0}, "floor: .* must be > 0"),
    "floor about an axis": ({**WIDE, "floor": "3 N*m/rad"}, "rotational, but the scene is translational"),
    "floor in kilograms": ({**WIDE, "floor": "3 kg"}, "floor"),
    "half a diamond": ({"shape": "diamond", "real": 0.1}, "both real and imag"),
    "negative way": ({"real": {"higher": 0.1, "lower": -1}, "imag": 0.1}, "real: lower: .* must be > 0"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_region_that_is_none_is_refused_in_a_sentence(name: str) -> None:
    jnd, why = WRONG[name]
    with pytest.raises(hs.SceneError, match=why):
        judged(jnd)


def test_of_a_polygon_with_unequal_limits_the_part_nearer_its_own_corner_is_last() -> None:
    """The limit downwards is not that of a change upwards."""
    found = judged({"shape": "polygon", "corners": UNEQUAL}, hs.Scene(PAPER.environment, PAPER.effects, (0, 30)))
    together = [p for p in found.percepts if p.part is None]
    assert together
    for p in together:
        low, high = (float(x.omega) for x in (p.band.low, p.band.high))
        v = found.distortion.compile()(np.array([(low + high) / 2]))
        x, y = (v.perceived_real - v.environment_real)[0], (v.perceived_imag - v.environment_imag)[0]
        is_real = bool(max(x / 0.2, -x / 0.2) > max(y / 0.3, -y / 0.05))
        assert (p.property is not Property.DAMPING) == is_real


def test_a_polygon_reaches_along_the_axes_as_far_as_its_nearer_corners() -> None:
    region = read_threshold({"shape": "polygon", "corners": UNEQUAL})
    assert half_widths(region) == (Rational(1, 5), Rational(1, 20))


@pytest.mark.parametrize(
    "shape",
    [
        {"shape": "polygon", "corners": UNEQUAL},
        {"shape": "polygon", "corners": [["0.1", "-0.1"], ["0.1", "0.3"], ["-0.2", "0.1"]]},
        {"shape": "polygon", "corners": [["0.3", 0], ["0.2", "0.1"], [0, "0.2"], ["-0.1", "0.1"], ["-0.2", "-0.3"], ["0.1", "-0.2"]]},
        {"shape": "diamond", "real": "0.1", "imag": "0.3"},
        {"shape": "ellipse", "real": "0.1", "imag": "0.3", "tilt": "-0.7"},
    ],
)  # fmt: skip
def test_in_each_direction_a_region_enlarged_as_much_has_the_change_on_its_border(shape: dict[str, Any]) -> None:
    [criterion] = noticed(read_threshold(shape))
    assert criterion.joint is not None
    for x, y in ((np.cos(n / 5), np.sin(n / 5)) for n in range(32)):
        much = float(criterion.joint.enlarged(x, y, lambda c: float(floats_of(c, 2.0))))
        assert outside(shape, x / much, y / much, 2) == pytest.approx(0, abs=1e-12)
        assert much > 0


@given(jnds(), st.floats(-1, 1), st.floats(-1, 1))
def test_enlarged_as_much_as_is_said_a_region_has_the_change_on_its_border(
    jnd: dict[str, Any], x: float, y: float
) -> None:
    assume(jnd.get("shape") and abs(x) + abs(y) > 1e-3)
    [criterion] = noticed(read_threshold(jnd))
    assert criterion.joint is not None
    much = float(criterion.joint.enlarged(x, y, lambda c: float(floats_of(c, 2.0))))
    assert outside(jnd, x / much, y / much, 2) == pytest.approx(0, abs=1e-12)


def test_where_a_pole_turns_the_change_round_a_polygon_may_be_returned_into_at_once() -> None:
    """Re dH/|H_env| is just above 1/10 below the pole at 5 rad/s and just below -1/10 beyond, where the polygon reaches to -1/5."""
    environment = environments.expression("1/(s^2 + 25)")
    corners = [[0.1, 0], [0, 0.1], [-0.2, 0], [0, -0.1]]
    jnd = {"shape": "polygon", "corners": corners}
    found = hs.evaluate(hs.Scene(environment, (effects.series("1.1 + (s^2 + 25)^2/1000"),), (1, 9), jnd))
    assert [(float(x.omega), x.kind.value) for x in found.crossings] == [
        (5.0, "returns"),
        (pytest.approx(35**0.5), "exceeds"),
    ]
    [kept] = found.transparent
    assert (float(kept.low.omega), float(kept.high.omega)) == (5.0, pytest.approx(35**0.5))
