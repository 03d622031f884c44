"""JND regions: published and derived crossings, every region against an independent scan of random scenes, and bounds for any environment."""

from __future__ import annotations

import cmath
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import assume
from hypothesis import strategies as st
from jnds import jnds
from marks import rarely
from mpmath import mp, mpf
from oracles import DIGITS, MP, Case
from regions import margin, outside
from strategies import cases, scene
from sympy import Rational, pi

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.bounds import ANY_ENVIRONMENT
from haptisym.judge.crossings import noticed
from haptisym.judge.evaluation import half_widths
from haptisym.judge.percepts import Property, felt_of
from haptisym.model.jnd import read_threshold
from haptisym.programs.floats import floats_of

E, F = environments, effects


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
    assert [felt_of(together, part) for part in (hs.Part.REAL, hs.Part.IMAG)] == ["lower mass", "higher damping"]
    row = next(x for x in found.to_dict()["percepts"] if x["part"] == "joint")
    assert (row["property"], row["change"]) == (["damping", "mass"], ["higher", "lower"])


def test_an_ellipse_whose_axes_lie_along_the_parts_is_left_before_the_rectangle_around_it() -> None:
    rectangle, ellipse = judged({"real": 0.1, "imag": 0.12}), judged({"shape": "ellipse", "real": 0.1, "imag": 0.12})
    assert float(ellipse.bandwidth or 0) < float(rectangle.bandwidth or 0)


def numeric(case: Case, omega: float) -> tuple[complex, complex]:
    H, G = case.dynamics(MP.mpc(0, omega), DIGITS)
    return complex(H), complex(G)


def between(found: hs.Evaluation) -> list[float]:
    """Frequencies well inside all pieces of the band on which nothing changes."""
    ends = [float(point.omega) for point in found.chart.points]
    return [a + share * (b - a) for a, b in pairwise(ends) if b - a > 1e-6 * b for share in (0.03, 0.35, 0.8, 0.98)]


@rarely(cases(order=3), jnds())
def test_a_region_is_left_exactly_where_plain_arithmetic_says_so(case: Case, jnd: dict[str, Any]) -> None:
    found = judged(jnd, scene(case))
    spans = [(float(x.low.omega), float(x.high.omega)) for x in found.transparent]
    assume(not found.unbounded)
    checked = 0
    for omega in between(found):
        H, G = numeric(case, omega)
        by = margin(jnd, H, G, omega)
        if abs(by) > 1e-9 * (1 + abs(G / H)):
            checked += 1
            assert (by <= 0) == any(low <= omega <= high for low, high in spans), (omega, by)
    assume(checked)


@pytest.mark.slow
@rarely(cases(order=3), jnds())
def test_a_part_is_named_exactly_where_it_alone_would_be_outside(case: Case, jnd: dict[str, Any]) -> None:
    assume("shape" in jnd)
    found = judged(jnd, scene(case))
    felt = [(x.part, float(x.band.low.omega), float(x.band.high.omega)) for x in found.felt]
    checked = 0
    for omega in between(found):
        H, G = numeric(case, omega)
        x, y = (G - H).real / abs(H), (G - H).imag / abs(H)
        signs = [outside(jnd, *at, omega) for at in ((x, y), (x, 0), (0, y))]
        if min(map(abs, signs)) < 1e-9 * (1 + abs(G / H)):
            continue
        checked += 1
        told = {part for part, low, high in felt if low <= omega <= high}
        real, imag = signs[1] > 0, signs[2] > 0
        if signs[0] <= 0:
            assert not told
        elif G.imag < 0:  # outside the model: the imaginary part has no name there
            assert told == ({hs.Part.REAL} if real and not imag else {hs.Part.REAL, None} if real else {None})
        else:
            assert told == ({p for p, out in zip(hs.Part, (real, imag), strict=True) if out} or {None})
    assume(checked)


@rarely(cases(order=3))
def test_more_regions_agree_where_one_holds_the_other(case: Case) -> None:
    """The diamond lies in the disc, the disc in the square: who is transparent in the smaller is so in the larger."""
    plain = scene(case)
    sets = [judged(jnd, plain).transparent for jnd in ({"shape": "diamond", **WIDE}, {"shape": "ellipse", **WIDE}, 0.1)]
    assume(sets[0])
    for smaller, larger in pairwise(sets):
        for x in smaller:
            low, high = (float(end.omega) for end in (x.low, x.high))
            assert any(
                float(y.low.omega) <= low * (1 + 1e-12) and high <= float(y.high.omega) * (1 + 1e-12) for y in larger
            )


def test_square_disc_and_diamond_stand_beside_the_scenes_own_region() -> None:
    found = hs.evaluate(PAPER, regions=True)
    rows = found.to_dict()["regions"]
    assert [x["region"] for x in rows] == ["square", "disc", "diamond", "the scene's own"]
    assert [x["bandwidth"] for x in rows] == pytest.approx(
        [7.978916790174708, 7.922311857140609, 7.627045310833144, 7.978916790174708], rel=1e-15
    )
    assert [x["crossing"]["part"] for x in rows] == ["real", "joint", "joint", "real"]
    assert "regions" not in hs.evaluate(PAPER).to_dict()


@pytest.mark.dear("diamond by its corners")
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


def test_a_polygon_that_moves_has_no_half_widths() -> None:
    corners = [[0.1, 0], [0, 0.1], [-0.1, 0], [0, "-0.1 - 0.001*omega"]]
    with pytest.raises(hs.SceneError, match="polygon that depends on omega"):
        hs.evaluate(
            hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, {"shape": "polygon", "corners": corners}),
            regions=True,
        )


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


@rarely(jnds(), st.floats(-1, 1), st.floats(-1, 1))
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


def test_a_region_beside_others_has_no_bandwidth_where_it_is_left_from_the_start_on() -> None:
    tight = hs.Scene(E.mass_spring_damper(k=100), (F.series("2"),), PAPER.band, 0.1)
    found = hs.evaluate(tight, regions=True).regions
    assert found
    for x in found:
        assert (x.crossing, x.bandwidth, x.transparent) == (None, None, ())


@pytest.mark.parametrize(("more", "band", "begins"), [("1/(s/9 + 1)^2", (0, 60), False), ("1/(s/9 + 1)^2", (20, 60), False), ("(s/30)^2", (0, 60), True), ("1/20", (0, 60), True)])  # fmt: skip
@pytest.mark.parametrize("jnd", [0.1, {"shape": "ellipse", "real": 0.2, "imag": 0.1, "tilt": -0.6}])
def test_what_is_noticed_from_the_bands_low_end_on_has_no_bandwidth_in_any_region(
    more: str,
    band: tuple[int, int],
    begins: bool,  # noqa: FBT001
    jnd: Any,
) -> None:
    """A change that dies away with frequency is noticed first and not later: an interval that begins inside is no bandwidth."""
    found = hs.evaluate(hs.Scene(E.mass_spring_damper(k=100), (F.series(f"1 + {more}"),), band, jnd), regions=True)
    assert len(found.regions) == 4
    for x in (found, *found.regions):
        assert x.transparent
        assert (x.bandwidth is not None) == begins
        assert (float(x.transparent[0].low.omega) == band[0]) == begins
        if begins and more != "1/20":
            assert x.bandwidth is x.transparent[0].high.omega
            assert 1 < float(x.bandwidth) < 20
    for x in found.regions:
        alone = judged(x.threshold, found.scene)
        assert [str(y) for y in x.transparent] == [str(y) for y in alone.transparent]
        assert (x.bandwidth and float(x.bandwidth)) == (alone.bandwidth and float(alone.bandwidth))


# --- environments that begin at 0 or give way ------------------------------------------------------------------------


FROM_REST = [{"m": 1}, {"b": 2}, {"m": 1, "b": 2}]
"""Environments that vanish at omega = 0, where a region is judged by the limit of dH/|H_env|, as the square is."""


@pytest.mark.few("-1-numbers2")
@pytest.mark.parametrize("numbers", FROM_REST)
@pytest.mark.parametrize("gain", ["-1", "3/4", "5/2"])
def test_a_polygon_that_is_the_square_tells_what_the_square_does_where_the_environment_begins_at_0(
    numbers: dict[str, int], gain: str
) -> None:
    lag = hs.effects.series("g*w/(s + w)", parameters={"g": gain, "w": 5})
    corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]]
    one, other = (
        hs.Scene(hs.environments.mass_spring_damper(**numbers), (lag,), (0, 3), jnd)
        for jnd in (1, {"shape": "polygon", "corners": corners})
    )
    square, polygon = map(hs.evaluate, (one, other))
    assert [str(x) for x in polygon.transparent] == [str(x) for x in square.transparent]
    assert str(polygon.bandwidth) == str(square.bandwidth)
    wide = hs.tolerances(other.with_values({"g": [Fraction(gain) - Fraction(1, 100), gain]}), samples=0)
    assert (wide.bandwidth is None) is (polygon.bandwidth is None)


@pytest.mark.parametrize("numbers", FROM_REST[:2])
@pytest.mark.parametrize(("gain", "bandwidth"), [("0.89", 3), ("1.11", None), ("0.87", None), ("1.09", 3)])
def test_a_gain_is_noticed_by_its_own_limit_from_0_on_where_the_environment_vanishes_there(
    numbers: dict[str, int], gain: str, bandwidth: int | None
) -> None:
    """It makes a mass or a damping larger, or smaller, by one share of it at all frequencies."""
    sides = {"higher": "0.1", "lower": "0.12"}
    series = hs.effects.series("g", parameters={"g": gain})
    scene = hs.Scene(hs.environments.mass_spring_damper(**numbers), (series,), (0, 3), {"real": sides, "imag": sides})
    found = hs.evaluate(scene)
    assert found.crossings == ()
    assert (found.bandwidth and float(found.bandwidth)) == bandwidth


@pytest.mark.parametrize("stiffness", [100, 200])
def test_a_polygon_is_touched_where_an_undamped_environment_gives_way_and_other_regions_go_by_the_limit(
    stiffness: int,
) -> None:
    lead, environment = hs.effects.series("1 + s/20"), hs.environments.mass_spring_damper(m=1, k=stiffness)

    def found(jnd: object) -> list[tuple[str, float]]:
        e = hs.evaluate(hs.Scene(environment, (lead,), (0, 30), jnd))  # type: ignore[arg-type]
        return [(x.kind.value, float(x.omega)) for x in e.crossings]

    corners = [["1/10", "1/10"], ["-1/10", "1/10"], ["-1/10", "-1/10"], ["1/10", "-1/10"]]
    leaves = ("exceeds", 2.0)
    others = (0.1, *({"shape": x, "real": 0.1, "imag": 0.1} for x in ("ellipse", "diamond")))
    assert [found(x) for x in others] == [[leaves]] * 3
    assert found({"shape": "polygon", "corners": corners}) == [leaves, ("touches", pytest.approx(stiffness**0.5))]


# --- bounds for any environment behind effects in series -------------------------------------------------------------


def filtered(environment: hs.Environment, high: object = 15, c: object = 0.1) -> hs.Evaluation:
    return hs.evaluate(hs.Scene(environment, (F.second_order_lowpass("80 rad/s", "0.5"),), (0, high), c))


def test_the_papers_filter_is_noticed_with_no_environment_below_8_and_with_all_above_11() -> None:
    with mp.workdps(40):

        def length(w):  # type: ignore[no-untyped-def]
            s = 1j * w
            return abs(6400 / (s**2 + 80 * s + 6400) - 1)

        ends = [mp.findroot(lambda w, c=c: length(w) - c, 9) for c in (mpf("0.1"), mp.sqrt(2) / 10)]
    found = hs.load_scene("fu2019")
    answer = hs.evaluate(found).any_environment
    assert answer.transparent_below.digits(30) == mp.nstr(ends[0], 30)
    assert answer.opaque_above.digits(30) == mp.nstr(ends[1], 30)


def test_both_bounds_are_attained() -> None:
    """By environments whose phase turns dH onto an axis, or halfway between both, at that frequency."""
    answer = hs.load_scene("fu2019")
    bounds = hs.evaluate(answer).any_environment
    for end, turn in ((float(bounds.transparent_below), 0), (float(bounds.opaque_above), cmath.pi / 4)):
        s = 1j * end
        phase = turn - cmath.phase(6400 / (s**2 + 80 * s + 6400) - 1)
        H = cmath.exp(1j * (phase % cmath.pi))
        environment = E.mass_spring_damper(m=max(0, -H.real) / end**2, b=H.imag / end, k=max(0, H.real))
        assert float(filtered(environment).bandwidth) == pytest.approx(end, rel=1e-9)


def test_where_nothing_stands_between_every_environment_is_transparent() -> None:
    answer = hs.evaluate(hs.Scene(E.mass_spring_damper(k=100))).any_environment
    assert (float(answer.transparent_below), answer.opaque_above) == (15.0, None)


def test_a_gain_that_is_wrong_from_the_start_is_never_unnoticed() -> None:
    answer = hs.evaluate(hs.Scene(E.mass_spring_damper(k=100), (F.series("1.3"),))).any_environment
    assert (answer.transparent_below, float(answer.opaque_above)) == (None, 0.0)


def test_different_thresholds_bound_by_the_smaller_and_by_both_together() -> None:
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.delay("10 ms"),), (0, 60), hs.Threshold.of("0.06", "0.08"))
    answer = hs.evaluate(scene).any_environment
    with mp.workdps(30):
        ends = [200 * mp.asin(mpf(c) / 2) for c in ("0.06", "0.1")]
    assert [x.digits(15) for x in (answer.transparent_below, answer.opaque_above)] == [
        mp.nstr(x, 15, strip_zeros=False) for x in ends
    ]


def any_environment(gain: str, c: object, imag: object = None, band: tuple[object, object] = (0, 15)):  # type: ignore[no-untyped-def]
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.series(gain),), band, hs.Threshold.of(c, imag))
    return hs.evaluate(scene).any_environment


def test_a_touch_from_below_leaves_every_environment_transparent() -> None:
    """|G - 1| of a band-pass on a circle peaks at half its gain, at 3 rad/s."""
    found = any_environment("1 + 0.2*s/(s^2 + 2*s + 9)", "0.1")
    assert (float(found.transparent_below), found.opaque_above) == (15.0, None)
    above = any_environment("1 + 0.2000001*s/(s^2 + 2*s + 9)", "0.1")
    assert 2.9 < float(above.transparent_below) < 3


def test_a_touch_from_above_is_the_last_frequency_that_some_environment_passes() -> None:
    """|G - 1| of a notch dips to half its gain at 3 rad/s: to sqrt(c_real^2 + c_imag^2) there, and nowhere else."""
    found = any_environment("1 + 0.2*(s^2 + s + 9)/(s^2 + 2*s + 9)", "0.06", "0.08")
    assert (found.transparent_below, float(found.opaque_above)) == (None, 3.0)
    never = any_environment("1 + 0.2*(s^2 + s + 9)/(s^2 + 2*s + 9)", "0.06", "0.0799")
    assert (never.transparent_below, float(never.opaque_above)) == (None, 0.0)


def test_only_the_first_transparent_and_the_last_opaque_interval_count() -> None:
    """Transparent up to about 2.5 and again from about 3.6 on; opaque only in between, which is not up to the end."""
    found = any_environment("1 + 2*s/(s^2 + 2*s + 9)", "0.5")
    assert 1 < float(found.transparent_below) < 3
    assert found.opaque_above is None
    later = any_environment("1 + 2*s/(s^2 + 2*s + 9)", "0.5", band=(3, 15))
    assert (later.transparent_below, later.opaque_above) == (None, None)
    middle = any_environment("1 + 2*s/(s^2 + 2*s + 9)", "0.5", band=("2.9", "3.1"))
    assert (middle.transparent_below, float(middle.opaque_above)) == (None, 2.9)
    twice = any_environment("1 + 0.2*s^2/9", "0.1", band=(0, 15))  # opaque from a frequency inside up to the end
    assert float(twice.transparent_below) == pytest.approx(4.5**0.5)
    assert float(twice.opaque_above) == pytest.approx((4.5 * 2**0.5) ** 0.5)


def test_effects_that_are_not_all_in_series_and_another_rendering_have_no_such_bounds() -> None:
    spring, lag, shunt, soft = E.mass_spring_damper(k=100), F.first_order_lag(20), F.shunt(m=1), F.compliance(k=1000)
    for chain in ((lag, shunt), (shunt, lag), (soft, lag), (lag, soft), (soft,), (shunt, soft)):
        assert hs.evaluate(hs.Scene(spring, chain)).any_environment is None
    rendered = hs.Scene(spring, (lag,), rendered=E.mass_spring_damper(k=101))
    assert hs.evaluate(rendered).any_environment is None
    same = hs.Scene(spring, (lag,), rendered=E.mass_spring_damper(k=100))
    assert float(hs.evaluate(same).any_environment.transparent_below) == pytest.approx(20 / 99**0.5)


def test_what_is_drawn_for_any_environment_is_how_far_the_effects_are_from_one() -> None:
    s = 9j
    values = hs.load_scene("fu2019").distortion().compile()(np.array([9.0]))
    assert ANY_ENVIRONMENT.sampled is not None
    found = ANY_ENVIRONMENT.sampled(values)
    assert found[0] == pytest.approx(abs(6400 / (s**2 + 80 * s + 6400) - 1), rel=1e-14)
    assert not np.iscomplexobj(found)


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(40))
def test_no_environment_contradicts_the_bounds(seed: int) -> None:
    m, b, k = (seed % 5) / 2, 1 + seed % 7, 10 * (seed % 11)
    result = filtered(E.mass_spring_damper(m=m, b=b, k=k))
    below, above = (float(x) for x in (result.any_environment.transparent_below, result.any_environment.opaque_above))
    assert float(result.bandwidth) >= below
    assert all(float(x.high.omega) <= above * (1 + 1e-15) for x in result.transparent)


ANGLES = np.linspace(0, 2 * np.pi, 100_001)
X, Y = np.cos(ANGLES), np.sin(ANGLES)


def square(a: float, b: float) -> Any:
    return np.maximum(abs(X) / a, abs(Y) / b)


def ellipse(a: float, b: float, t: float) -> Any:
    return np.sqrt(((X / a) ** 2 - 2 * t * X * Y / (a * b) + (Y / b) ** 2) / (1 - t * t))


def polygon(corners: list[list[float]]) -> Any:
    rows = [(p, q) for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)]
    return np.max([(X * (v - y) - Y * (u - x)) / (x * v - y * u) for (x, y), (u, v) in rows], axis=0)


SKEW = [[0.5, 0.1], [0.2, 0.6], [-0.3, 0.3], [-0.4, -0.2], [0.1, -0.5]]

TURNED = [[0.1, 0.6], [-0.5, 0.1], [-0.2, -0.3], [0.3, -0.2]]

REGIONS: dict[str, tuple[Any, Any]] = {
    "square": (0.3, square(0.3, 0.3)),
    "wide": ({"real": 0.5, "imag": 0.2}, square(0.5, 0.2)),
    "high": ({"real": 0.2, "imag": 0.5}, square(0.2, 0.5)),
    "disc": ({"shape": "ellipse", "real": 0.3, "imag": 0.3}, ellipse(0.3, 0.3, 0)),
    "ellipse": ({"shape": "ellipse", "real": 0.3, "imag": 0.6}, ellipse(0.3, 0.6, 0)),
    "tilted": ({"shape": "ellipse", "real": 0.3, "imag": 0.6, "tilt": 0.5}, ellipse(0.3, 0.6, 0.5)),
    "tilted back": ({"shape": "ellipse", "real": 0.4, "imag": 0.4, "tilt": -0.8}, ellipse(0.4, 0.4, -0.8)),
    "diamond": ({"shape": "diamond", "real": 0.3, "imag": 0.3}, abs(X) / 0.3 + abs(Y) / 0.3),
    "long diamond": ({"shape": "diamond", "real": 0.6, "imag": 0.2}, abs(X) / 0.6 + abs(Y) / 0.2),
    "upright diamond": ({"shape": "diamond", "real": 0.2, "imag": 0.6}, abs(X) / 0.2 + abs(Y) / 0.6),
    "polygon": ({"shape": "polygon", "corners": SKEW}, polygon(SKEW)),
    "turned polygon": ({"shape": "polygon", "corners": TURNED}, polygon(TURNED)),
}
"""Each with how many times it must be enlarged to reach 1 in each direction."""


def border(real: float, imag: float, tilt: float) -> Any:
    """How many times an ellipse must be enlarged to reach 1 in each direction: as a polygon of 1,000 corners on its border."""
    t = np.linspace(0, 2 * np.pi, 1001)[:-1]
    x, y = real * np.cos(t), imag * (tilt * np.cos(t) + np.sqrt(1 - tilt * tilt) * np.sin(t))
    turns = np.unwrap(np.arctan2(y, x))
    at = np.arctan2(Y, X) % (2 * np.pi)
    i = np.searchsorted(turns - turns[0], (at - turns[0]) % (2 * np.pi), side="right") - 1
    a, b, c, d = x[i], y[i], x[(i + 1) % 1000], y[(i + 1) % 1000]
    return (X * (d - b) - Y * (c - a)) / (a * d - b * c)


TILTS = {
    f"ellipse tilted by {t}": ({"shape": "ellipse", "real": a, "imag": b, "tilt": t}, border(a, b, t))
    for a, b, t in ((0.3, 0.6, 0.6), (0.5, 0.2, -0.6), (0.3, 0.3, 0.9), (0.4, 0.3, 0.0))
}


@pytest.mark.few(8)
@pytest.mark.parametrize("name", [*TILTS, *REGIONS])
def test_a_region_and_its_projections_are_left_where_the_polygon_of_its_border_is(name: str) -> None:
    """A change (-a w^2 + c, b w) of a stick on a bench of 10 N/m and 2 N s/m, to each of four sides: what is felt, and as what."""
    jnd, times = (TILTS | REGIONS)[name]
    joint = isinstance(jnd, dict) and "shape" in jnd

    def enlarged(x: float, y: float) -> float:
        at = np.arctan2(y, x) % (2 * np.pi) / (2 * np.pi) * (len(ANGLES) - 1)
        return float(np.hypot(x, y) * np.interp(at, np.arange(len(ANGLES)), times))

    seen = set()
    for a, b, c in ((0.5, 1.5, 0), (-0.4, -0.9, 0), (0.7, -1.1, 3), (-0.2, 0.6, -1)):
        device = F.shunt(Z=f"{a}*s^2 + ({b})*s + ({c})")
        found = judged(jnd, hs.Scene(E.kelvin_voigt(10, 2), (device,), (0, 12)))
        for omega in between(found):
            size = abs(10 + 2j * omega)
            x, y = (c - a * omega**2) / size, b * omega / size
            out = [enlarged(*at) for at in ((x, y), (x, 0), (0, y))]
            if min(abs(z - 1) for z in out) < 1e-4:
                continue
            told = {z.part for z in found.felt if float(z.band.low.omega) <= omega <= float(z.band.high.omega)}
            parts = {p for p, z in zip(hs.Part, out[1:], strict=True) if z > 1} if out[0] > 1 or not joint else set()
            assert told == (parts or ({None} if joint and out[0] > 1 else set())), (a, b, c, omega)
            seen |= told
            for p in found.percepts:
                if p.part is None and float(p.band.low.omega) < omega < float(p.band.high.omega):
                    assert (p.property is Property.DAMPING) == (out[2] > out[1]), (a, b, c, omega)
    assert seen >= set(hs.Part)


@pytest.mark.parametrize("name", [x for x, (jnd, _) in (TILTS | REGIONS).items() if "shape" in str(jnd)])
def test_a_region_is_enlarged_in_every_direction_as_much_as_its_border_is_near(name: str) -> None:
    jnd, times = (TILTS | REGIONS)[name]
    [criterion] = noticed(read_threshold(jnd))
    assert criterion.joint is not None
    found = criterion.joint.enlarged(X[::997], Y[::997], lambda c: float(floats_of(c, 2.0)))
    assert found == pytest.approx(times[::997], rel=1e-4)


def of_any(jnd: Any) -> Any:
    """A gain 1 + omega^2/100 behind a spring: |G - 1| is the radius of the largest circle, and of the smallest around it, where it is."""
    return hs.evaluate(hs.Scene(E.mass_spring_damper(k=1), (F.series("1 - s^2/100"),), (0, 30), jnd)).any_environment


@pytest.mark.parametrize("name", REGIONS)
def test_every_environment_is_judged_by_the_largest_circle_in_a_region_and_the_smallest_around_it(name: str) -> None:
    """Against how far each of many directions reaches its border."""
    jnd, times = REGIONS[name]
    found = of_any(jnd)
    ends = [float(x) ** 2 / 100 for x in (found.transparent_below, found.opaque_above)]
    assert ends == pytest.approx([1 / times.max(), 1 / times.min()], rel=1e-4)


SIDED = {"higher": 0.3, "lower": 0.2}


@pytest.mark.parametrize(
    "jnd",
    [
        {"real": 0.3, "imag": 0.3, "floor": "1 N/m"},
        {"real": SIDED, "imag": 0.3},
        {"real": 0.3, "imag": SIDED},
        {"real": SIDED, "imag": 0.3, "floor": "1 N/m"},
    ],
    ids=str,
)
def test_where_more_than_the_length_of_a_change_matters_nothing_is_said_of_any_environment(jnd: Any) -> None:
    assert of_any(jnd) is None


def test_thresholds_that_are_no_fractions_have_their_circles_too() -> None:
    found = of_any(hs.Threshold(pi / 30, pi / 15))
    assert [float(x) ** 4 / 10**4 for x in (found.transparent_below, found.opaque_above)] == pytest.approx(
        [float(pi / 30) ** 2, float(pi / 30) ** 2 + float(pi / 15) ** 2], rel=1e-14
    )


# --- which changes would decide between models -----------------------------------------------------------------------


def holds(t: hs.Threshold, x: Any, y: Any) -> Any:
    """Whether a region holds changes, by its definition."""
    u, v, tilt = x / float(t.real), y / float(t.imag), float(t.region.tilt)
    if t.region.shape.value == "square":
        return (abs(u) <= 1) & (abs(v) <= 1)
    return u * u - 2 * tilt * u * v + v * v <= 1 - tilt * tilt


def reaches(t: hs.Threshold, across: Any, up: Any) -> Any:
    """How far a region reaches in some directions, by bisection."""
    low, high = np.zeros_like(across), np.full_like(across, 2.0)
    for _ in range(50):
        middle = (low + high) / 2
        inside = holds(t, middle * across, middle * up)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return low


@pytest.mark.parametrize(
    "jnd", [0.1, {"real": 0.1, "imag": 0.3}, {"shape": "ellipse", "real": 0.2, "imag": 0.1, "tilt": -0.7}]
)
def test_no_direction_decides_better_between_two_models(jnd: Any) -> None:
    scene = hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd)
    found = hs.evaluate(scene, discriminate=True).discrimination
    assert found is not None
    assert len(found.stimuli) == 6
    phi = np.linspace(0, 2 * np.pi, 7201)
    for x in found.stimuli:
        sizes = [reaches(found.models[name], np.cos(phi), np.sin(phi)) for name in (x.noticed_by, x.not_by)]
        best = max((sizes[1] / sizes[0]).max(), (sizes[0] / sizes[1]).max())
        assert best <= x.margin**2 * (1 + 1e-9)
        assert best == pytest.approx(x.margin**2, rel=1e-3)
        tight, loose = (found.models[name] for name in (x.noticed_by, x.not_by))
        for share, model, inside in ((1.001, tight, False), (0.999, tight, True)):
            assert holds(model, x.real * share / x.margin, x.imag * share / x.margin) == inside
        for share, model, inside in ((1.001, loose, False), (0.999, loose, True)):
            assert holds(model, x.real * share * x.margin, x.imag * share * x.margin) == inside
        H = 100 - 1.8 * x.omega**2 + 15j * x.omega
        assert (x.stiffness, x.damping) == pytest.approx((x.real * abs(H), x.imag * abs(H) / x.omega), rel=1e-12)


def test_the_display_decides_where_the_models_judge_it_differently() -> None:
    found = hs.evaluate(PAPER, discriminate=True).discrimination
    assert found is not None
    assert found.display
    omega = np.linspace(0.001, 15, 5000)
    H = 100 - 1.8 * omega**2 + 15j * omega
    change = H * (80**2 / (80**2 - omega**2 + 80j * omega) - 1) / abs(H)
    for one in found.models:
        for other in found.models:
            inside = [holds(found.models[name], change.real, change.imag) for name in (one, other)]
            rows = [x for x in found.display if (x.noticed_by, x.not_by) == (one, other)]
            ends = [(float(x.interval.low.omega), float(x.interval.high.omega)) for x in rows]
            assert np.array_equal(
                ~inside[0] & inside[1], np.any([(a < omega) & (omega < b) for a, b in ends] or [omega < 0], 0)
            )
            for x in rows:
                i = int(np.argmin(abs(omega - x.omega)))
                assert (x.real, x.imag) == pytest.approx((change[i].real, change[i].imag), rel=0.1, abs=1e-3)
                assert x.margin > 1


def test_what_would_decide_is_asked_for_with_regions_and_of_one_environment(call: Any) -> None:
    for words, said in (
        (["fu2019"], "--discriminate is about a comparison of regions: it needs --regions"),
        (["palpation-device", "--regions"], "--discriminate takes one environment: choose it with --environment NAME"),
        (["fu2019-bench"], "--discriminate is about"),
    ):
        status, out, err = call("evaluate", *words, "--discriminate")
        assert (status, out) == (2, "")
        assert said in err
    status, out, _ = call("evaluate", "fu2019", "--regions", "--discriminate")
    assert status == 0
    assert "Which changes would decide between the models?" in out


@pytest.mark.parametrize("gain", ["1.3", "0.5"])
def test_of_a_power_of_s_times_a_gain_a_polygon_is_left_nowhere_on_the_band(gain: str) -> None:
    """(dH/|H|) is the same at all frequencies, down to 0, and lies outside: there is no crossing, as of a damper."""
    triangle = {"shape": "polygon", "corners": [[0.1, 0], [-0.1, 0.2], [-0.1, -0.2]]}
    for felt in (hs.environments.spring_pot(3, "1/2"), hs.environments.mass_spring_damper(b=3)):
        assert judged(triangle, hs.Scene(felt, (hs.effects.series(gain),))).crossings == ()
