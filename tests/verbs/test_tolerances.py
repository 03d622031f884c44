"""What is claimed for all values in a box, against sets of values answered one by one, and against boxes solved by hand."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from fractions import Fraction
from itertools import count, pairwise, product
from math import ceil, sqrt
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st
from marks import examples, often
from sympy import Rational, Symbol

import haptisym as hs
from haptisym.judge.crossings import noticed
from haptisym.judge.excess import Box, Excess, LargerExcess, box_of
from haptisym.kernel.budget import timed_by
from haptisym.model.parameters import ranged
from haptisym.model.quantities import Dimension

F = hs.effects
SPRING = hs.environments.mass_spring_damper(k=100)
SOFT = hs.environments.mass_spring_damper(k="100 N/m +- 10 %")
LAG = F.first_order_lag("40 rad/s +- 10 %")
C = Fraction(1, 5)
HEAD = 'environment = {{ model = "mass-spring-damper", m = {m} }}\n'

# --- ranges as they are written ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "interval"),
    [
        *((x, ("9/5", "11/5")) for x in ("2 kg +- 10 %", "2 kg ± 10 %", "2 kg +- 200 g", "2 kg +/- 0.2 kg", [1.8, 2.2])),
        (["1.8 kg", "2200 g"], ("9/5", "11/5")), ("-45 g +- 10 %", ("-99/2000", "-81/2000")), ("2 kg +- 0 %", None),
        (["2 kg", "2 kg"], None),
    ],
)  # fmt: skip
def test_a_range_is_read_exactly_however_it_is_written(given: object, interval: Any) -> None:
    found = ranged(given, Dimension.MASS)
    assert found.interval == (interval and tuple(map(Rational, interval)))
    assert interval is None or found.nominal.value == sum(found.interval or ()) / 2


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ('["1.9 kg", "1.7 kg"]', "lower end"), ('["1.9 kg"]', "is not a range"), ('["1.9 kg", "2 kg", "3 kg", "4 kg"]', "is not a range"),
        ('["1.9 kg", "2 N"]', "not a mass"), ('["1.9 kg", 2]', "units of the same kind"), ('"0 kg +- 5 %"', "percentage of zero"),
        ('"1 kg +- -5 %"', "must be >= 0"), ('"1 kg +- 200 %"', "needs m >= 0"), ('["-1 kg", "1 kg"]', "needs m >= 0"),
        ('"1 kg +- 0.1"', "units of the same kind"), ('"1 +- 0.1 kg"', "units of the same kind"), ('"1 kg +- "', "not a range"),
        ('"1 kg +- 1 % +- 1 %"', "not a range"), ('"1 kg +- many %"', "finite decimal number"),
    ],
)  # fmt: skip
def test_a_wrong_range_is_refused_where_it_is(given: str, word: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.parse_scene(HEAD.format(m=given), "mine")
    assert all(x in str(error.value) for x in ("mine", "environment", "m", word))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('effects = [{model = "pade-delay", tau = "5 ms", order = [1, 3]}]', "without a range"),
        ('evaluation = {band = ["0 rad/s", "15 rad/s +- 5 %"]}', "band"), ("evaluation = {jnd = [-0.1, 0.1]}", "jnd"),
    ],
)  # fmt: skip
def test_what_cannot_vary_has_no_range(text: str, words: str) -> None:
    with pytest.raises(hs.SceneError, match=words):
        hs.parse_scene(HEAD.format(m=1) + text)


def test_other_verbs_take_the_nominal_values() -> None:
    plain, ranges = hs.evaluate("fu2019"), hs.evaluate("fu2019-tolerances")
    assert [x.omega.digits(40) for x in plain.crossings] == [x.omega.digits(40) for x in ranges.crossings]
    assert hs.load_scene("fu2019-tolerances").with_values({"m": 2}).nominal_but().startswith("b, k,")


# --- the box ----------------------------------------------------------------------------------------------------------


def test_a_box_has_a_side_for_each_range_in_its_units_and_the_threshold_last() -> None:
    wheel = hs.environments.mass_spring_damper("0.05 kg*m^2 +- 5 %", "0.3 N*m*s/rad", "5 N*m/rad +- 10 %")
    for jnd, names in (
        (hs.Threshold.of("0.1 +- 20 %"), ["c"]), (hs.Threshold.of("0.2", "0.1 +- 20 %"), ["c_imag"]),
        (hs.Threshold.of("0.1 +- 20 %", "0.1 +- 10 %"), ["c_real", "c_imag"]),
    ):  # fmt: skip
        box = box_of(hs.Scene(wheel, (LAG,), (0, 15), jnd))
        units = ["kg*m^2", "N*m/rad", "rad/s", *["1"] * len(names)]
        assert [(x.name, x.unit) for x in box.sides] == [*zip(["m", "k", "omega_c", *names], units, strict=True)]
        own = box.values({x.name: Fraction(i, 7) for i, x in enumerate(box.sides)})
        assert own["k"] == Rational(9, 2) + Rational(1, 7)
        told = box.scene.with_values(own)
        assert all(told.threshold[part] == own.get(box.part_name(part), jnd[part]) for part in hs.Part)
        assert box_of(told.with_values({"k": [1, 2]})).sides[0].low == 1
    bare = hs.environments.mass_spring_damper([1, 2], [3, 4], [90, 110])
    assert [x.unit for x in box_of(hs.Scene(bare, (LAG,))).sides] == ["kg", "N*s/m", "N/m", "rad/s"]


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (hs.Scene(SPRING, (F.first_order_lag(40),)), r"no parameter has a range.*\+-"),
        (hs.Scene(SPRING, (F.first_order_lag(40),), hands=(hs.Hand("x", 1, 1, 1),)), "no parameter has a range"),
        (hs.Scene(SOFT, (F.first_order_lag(Symbol("w", positive=True)),)), "omega_c = w is a symbol"),
    ],
)  # fmt: skip
def test_a_box_needs_numbers_and_ranges(scene: hs.Scene, words: str) -> None:
    with pytest.raises(hs.SceneError, match=words):
        hs.tolerances(scene)


@pytest.mark.parametrize("samples", [-1, 2.5, "9"])
def test_samples_must_be_a_whole_number(samples: Any) -> None:
    with pytest.raises(hs.SceneError, match="samples"):
        hs.tolerances(hs.Scene(SOFT, (LAG,)), samples=samples)


# --- boxes solved by hand ---------------------------------------------------------------------------------------------


def gain(G: str, band: Any = (0, 15), jnd: Any = None, **ranges: Any) -> hs.Scene:
    """A spring behind a gain: r_r and r_i are the parts of G - 1."""
    effect = F.series(G, parameters={key: text(x) for key, x in ranges.items()})
    return hs.Scene(SPRING, (effect,), band, jnd or hs.Threshold.of(str(C)))


def text(x: Any) -> Any:
    """A range as a scene has it, or the one number in it."""
    return (str(x[0]) if x[0] == x[1] else [str(y) for y in x]) if isinstance(x, list) else x


def rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def ends_of(x: Any) -> list[float]:
    return [float(x.low), float(x.high)]


@pytest.mark.slow
def test_behind_a_lag_all_is_known_by_hand() -> None:
    """r_i of a spring is t/(1 + t^2), t = omega/omega_c: 1/10 at t = 5 - sqrt 24, whatever the stiffness."""
    low, high = (x * (5 - sqrt(24)) for x in (36, 44))
    found = hs.tolerances(hs.Scene(SOFT, (LAG,), (2, 10)), samples=0)
    [x] = found.enclosures
    assert (x.part, x.count, dict(x.monotonic)) == (hs.Part.IMAG, 1, {"k": 0, "omega_c": 1})
    assert ends_of(x) == pytest.approx([low, high], rel=1e-14)
    assert (x.at_low["omega_c"], x.at_high["omega_c"]) == (36, 44)
    assert [float(y) for y in found.bandwidth] == ends_of(x)
    assert (found.verdict.value, found.certified) == ("none", True)
    within = hs.tolerances(hs.Scene(SOFT, (LAG,), (2, 3)), samples=0)
    assert (within.verdict.value, [float(y) for y in within.bandwidth], within.enclosures) == ("all", [3, 3], ())
    assert (within.transparent.values.keys(), within.noticed) == ({"k", "omega_c"}, None)
    started = hs.tolerances(hs.Scene(SOFT, (LAG,), (5, 10)), samples=0)
    assert (started.verdict.value, started.bandwidth, started.enclosures) == ("none", None, ())
    some = hs.tolerances(hs.Scene(SOFT, (LAG,), (4, 10)), samples=0)  # the low end lies within the enclosure
    assert (some.bandwidth, some.enclosures[0].count) == (None, None)
    edge = hs.tolerances(hs.Scene(SOFT, (LAG,), (2, 4)), samples=0)
    assert (edge.verdict.value, edge.enclosures[0].count) == ("depends", None)
    assert [float(y) for y in edge.bandwidth] == [pytest.approx(low, rel=1e-14), 4]
    assert (edge.transparent.transparent, edge.noticed.transparent) == (True, False)


@pytest.mark.dear("jnd1")
@pytest.mark.parametrize("jnd", [("0.1", ["0.08", "0.12"]), ("0.1 +- 10 %", "0.3 +- 10 %")])
def test_thresholds_that_vary_move_the_crossings_of_their_own_part(jnd: Any) -> None:
    """Behind a delay r_i = sin(omega tau) and r_r = 2 sin(omega tau/2)^2."""
    threshold = hs.Threshold.of(*jnd)
    found = hs.tolerances(hs.Scene(SPRING, (F.delay("10 ms"),), (0, 60), threshold), samples=0)
    places = {"real": lambda c: 200 * np.arcsin(sqrt(c / 2)), "imag": lambda c: 100 * np.arcsin(c)}
    for x in found.enclosures:
        low, high = threshold.interval(x.part) or (threshold[x.part],) * 2
        assert ends_of(x) == pytest.approx([places[x.part.value](float(c)) for c in (low, high)], rel=1e-13)
        own = f"c_{x.part.value}"
        assert all(x.monotonic[key] == (key == own) for key in x.monotonic)
    assert {x.part for x in found.enclosures} == {*hs.Part}


def test_of_two_crossings_each_has_its_enclosure_and_the_bandwidth_ends_at_the_first() -> None:
    """r_r = 2 a w^2/((9 - w^2)^2 + 4 w^2), up to a/2 at 3: it comes and goes."""
    scene = gain("1 + a*s/(s^2 + 2*s + 9)", (0, 9), hs.Threshold.of("0.1", 1), a=["0.3", "0.4"])
    found = hs.tolerances(scene, samples=6)
    first, second = found.enclosures
    assert [(x.count, dict(x.monotonic)) for x in (first, second)] == [(1, {"a": -1}), (1, {"a": 1})]

    def ends(a: float) -> list[float]:
        """(9 - x)^2 + 4 x = 20 a x with x = w^2."""
        b = 14 + 20 * a
        return [sqrt((b + sign * sqrt(b * b - 324)) / 2) for sign in (-1, 1)]

    expected = [ends(0.4)[0], ends(0.3)[0], ends(0.3)[1], ends(0.4)[1]]
    assert [*ends_of(first), *ends_of(second)] == pytest.approx(expected, rel=1e-13)
    assert [float(x) for x in found.bandwidth] == pytest.approx(expected[:2], rel=1e-13)
    assert all(len(x.crossings["real"]) == 2 for x in found.samples)


@pytest.mark.dear("0.3-False-2")
@pytest.mark.parametrize(("least", "whole", "crossings"), [("0.2", True, 0), ("0.3", False, 2)])
def test_a_touch_is_no_crossing_of_a_set_of_values(least: str, crossings: int, *, whole: bool) -> None:
    """With a = 0.2 r_r touches 0.1 at 3 rad/s."""
    scene = gain("1 + a*s/(s^2 + 2*s + 9)", (0, 9), hs.Threshold.of("0.1", 1), a=["0.2", "0.4"])
    one = hs.tolerances(scene, samples=0).one({"a": Rational(least)})
    assert (len(one.crossings["real"]), one.transparent) == (crossings, whole)
    assert float(one.bandwidth) == (9 if whole else float(one.crossings["real"][0]))


def test_one_part_may_be_noticed_for_all_values_where_the_other_is_for_none() -> None:
    """A mass of 1 kg on 100 N/m: r_r = w^2/100, c at sqrt(10); r_i = b w/100 is at most 0.03."""
    found = hs.tolerances(hs.Scene(SPRING, (F.shunt(m="1 kg +- 10 %", b="0.2 N*s/m"),), (0, 15)), samples=0)
    [x] = found.enclosures
    assert (x.part, x.count, dict(x.monotonic), found.verdict.value) == (hs.Part.REAL, 1, {"m": -1}, "none")
    assert ends_of(x) == pytest.approx([sqrt(10 / 1.1), sqrt(10 / 0.9)], rel=1e-14)
    assert [float(y) for y in found.bandwidth] == ends_of(x)


def test_what_is_noticed_from_the_band_s_beginning_has_no_bandwidth_though_it_is_transparent_later() -> None:
    """r_i is 0.1/omega, above 10 % up to 1 rad/s, then below."""
    late = gain("1 + a/(10*s)", ("0.5", 5), hs.Threshold.of("0.1"), a=["0.9", "1.1"])
    one = hs.tolerances(late, samples=0).nominal
    assert (one.bandwidth, one.transparent) == (None, False)
    assert [float(x) for x in one.crossings["imag"]] == [pytest.approx(1)]
    assert hs.tolerances(late.with_band(2, 5), samples=0).verdict.value == "all"


@pytest.mark.parametrize(
    ("G", "status", "verdict"),
    [
        ("a", 0, "all"),  # r_r grows with a; below it is largest in the middle
        pytest.param("(0.4 - 100*(a - 0.35)^2)", 3, "undecided", marks=pytest.mark.slow),
    ],
)
def test_a_touch_is_told_at_a_corner_and_elsewhere_left_undecided(
    call: Any, tmp_path: Path, G: str, status: int, verdict: str
) -> None:
    """r_r is at most half the gain (at 3 rad/s): at its largest just the threshold, so that neither a margin nor a witness exists."""
    path = tmp_path / "touch.toml"
    path.write_text(
        'environment = { model = "mass-spring-damper", k = "100 N/m" }\n'
        f'effects = [{{ model = "series", G = "1 + {G}*s/(s^2 + 2*s + 9)", parameters = {{ a = [0.3, 0.4] }} }}]\n'
        "evaluation = { jnd = { real = 0.2, imag = 1 } }\n"
    )
    done, out, _ = call("tolerances", str(path), "--samples", "5", "--json")
    assert (done, json.loads(out)["verdict"]) == (status, verdict)


@pytest.mark.slow
@pytest.mark.parametrize(("top", "q", "verdict"), [("1", "1", "all"), ("1", "0.6", "all"), ("1.001", "1", "depends")])
def test_a_gain_that_is_off_by_the_threshold_within_its_range_and_nowhere_more_is_never_noticed(
    top: str, q: str, verdict: str
) -> None:
    """p (2 - p) is largest, 1, at p = 1, between the corners and no middle of any cell; it grows with q to the threshold."""
    scene = gain(f"1 + {top}*p*(2 - p)*q/5", p=["0.5", "1.7"], q=[q, "1"])
    assert hs.tolerances(scene, samples=0).verdict.value == verdict


@pytest.mark.dear("0.41")
@pytest.mark.parametrize("most", ["0.39", "0.41"])
def test_what_no_corner_and_no_sample_shows_is_not_said_of_all_values(most: str) -> None:
    """r_r is at most half of 0.39, or 0.41, at a = 0.33, between the nominal value and a corner; a second passes with each look."""
    scene = gain(f"1 + ({most} - 100*(a - 0.33)^2)*s/(s^2 + 2*s + 9)", jnd=hs.Threshold.of("0.2", 1), a=["0.3", "0.4"])
    with timed_by(count().__next__):
        found = hs.tolerances(scene, samples=0, limit=700)
    assert found.nominal.transparent
    assert found.verdict.value in ("undecided", "all" if most == "0.39" else "depends")


BUMP = "-0.12*(10*(p - 1))^2*(1 - (10*(p - 1))^2)*s^2"


@pytest.mark.few("effect1-30-all", "effect4-60-depends")
@pytest.mark.parametrize(
    ("effect", "top", "verdict"),
    [
        (
            F.shunt(Z="10*p - 0.0001*(s^2 + 100)^2/(1 + s^4/10000)", parameters={"p": ["0.5", "1"]}),
            40,
            "all",
        ),  # at 10 rad/s
        (F.series("g", parameters={"g": ["0.9", "1.1"]}), 30, "all"),  # both ends, at every frequency
        (F.series("g*h", parameters={"g": ["0.95", "1.1"], "h": ["0.96", "1"]}), 30, "all"),
        (F.series("g*h", parameters={"g": ["0.9", "1.1"], "h": ["0.99", "1"]}), 30, "depends"),
        (F.shunt(Z=BUMP, parameters={"p": "1 +- 10 %"}), 60, "depends"),  # neither nominal nor corners
    ],
)
def test_a_verdict_is_that_of_all_members_and_hangs_on_no_sample(effect: hs.Effect, top: int, verdict: str) -> None:
    """The largest r_r is known by hand: it just reaches 0.1, or goes beyond it between the middle and an end."""
    scene = hs.Scene(SPRING, (effect,), (0, top))
    found = [hs.tolerances(scene, samples=n) for n in (0, 3)]
    assert [x.verdict.value for x in found] == [verdict] * 2
    for x in found:
        assert verdict != "all" or [float(y) for y in x.bandwidth] == [top, top]
        assert verdict != "all" or {y.count for y in x.enclosures} <= {0}
        agrees_with_evaluate(x)


@pytest.mark.slow
def test_where_no_phase_exceeds_a_limit_all_delays_are_transparent() -> None:
    """Of a delay on a spring r_r is at most 2 and r_i at most 1, and each is reached, inside of the box."""
    found = hs.tolerances(hs.Scene(SPRING, (F.delay(["1 ms", "0.3 s"]),), (0, 15), hs.Threshold(2, 1)), samples=0)
    assert (found.verdict.value, [float(x) for x in found.bandwidth]) == ("all", [15, 15])
    agrees_with_evaluate(found)


def agrees_with_evaluate(found: Any) -> None:
    """Bandwidth and verdict against the other verb's answers for members of the box: its corners, its middle, and some inside."""
    pick = Random(1)
    sides = [(x.name, x.low, x.high) for x in found.box.sides]
    shares = [[pick.choice([0, 1]) for _ in sides] for _ in range(3)] + [
        [pick.randrange(65) / 64 for _ in sides] for _ in range(3)
    ]
    for row in [[0.5] * len(sides), *shares]:
        values = {name: a + Rational(n) * (b - a) for n, (name, a, b) in zip(row, sides, strict=True)}
        one = hs.evaluate(found.box.scene.with_values(values))
        if found.bandwidth:
            assert one.bandwidth is not None
            assert float(found.bandwidth[0]) <= float(one.bandwidth) <= float(found.bandwidth[1])
        if not one.undecided:
            whole = one.bandwidth is not None and float(one.bandwidth) == float(one.scene.band[1])
            assert found.verdict.value in (
                {"all", "depends", "undecided"} if whole else {"none", "depends", "undecided"}
            )


REAL = {"1/10": Fraction(1, 3), "1/5": Fraction(1, 2), "1/2": Fraction(1), "5": None}
IMAG = {"3/10": Fraction(1, 3), "2/5": Fraction(1, 2), "5": None}
"""Thresholds, and the t at which t^2/(1 + t^2), or t/(1 + t^2), gets there first."""


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("imag", IMAG)
@pytest.mark.parametrize("real", REAL)
def test_a_bandwidth_is_that_of_the_first_of_two_parts_or_the_end_of_the_band_whichever_is_nearer(
    real: str, imag: str
) -> None:
    """Behind a lag of 36 to 44 rad/s; bands that end before, in, at the ends of and beyond where either part may be noticed."""
    t = min((x for x in (REAL[real], IMAG[imag]) if x is not None), default=None)
    for top in (x * (t or 1) for x in (30, 36, 40, 44, 50)):
        scene = hs.Scene(
            SPRING,
            (F.first_order_lag(["36 rad/s", "44 rad/s"]),),
            (0, rational(Fraction(top))),
            hs.Threshold(real, imag),
        )
        found = hs.tolerances(scene, samples=0)
        ends = [top, top] if t is None else [min(top, 36 * t), min(top, 44 * t)]
        assert [float(x) for x in found.bandwidth] == pytest.approx([float(x) for x in ends], rel=1e-12)
        told = "all" if t is None or top <= 36 * t else "depends" if top <= 44 * t else "none"
        assert found.verdict.value == told
        assert (found.transparent is not None) is (told != "none")
        assert (found.noticed is not None) is (told != "all" and (t is None or top > 36 * t))


@pytest.mark.dear("cutoff7-1/10-none")
@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("cutoff", "limit", "told"),
    [
        (["36", "44"], "1/10", "all"), (["35.99", "44"], "1/10", "depends"), (["30", "36"], "1/10", "depends"),
        ("36", ["1/10", "1/5"], "all"), ("36", ["1/20", "1/10"], "depends"), (["36", "44"], ["1/10", "1/5"], "all"),
        (["30", "36"], ["1/20", "1/10"], "depends"), (["30", "35.99"], "1/10", "none"),
    ],
)  # fmt: skip
def test_a_range_that_begins_where_a_requirement_ends_is_one_for_which_all_values_will_do(
    cutoff: Any, limit: Any, told: str
) -> None:
    """The least cutoff that keeps r_r to 1/10 up to 12 rad/s is 36 rad/s, exactly."""
    [span] = hs.require(
        hs.Scene(SPRING, (F.first_order_lag(50),), (0, 12), hs.Threshold("1/10", 5)), "omega_c"
    ).feasible
    assert span.low is not None
    assert span.low.enclosure() == ("36", "36")
    scene = hs.Scene(SPRING, (F.first_order_lag(cutoff),), (0, 12), hs.Threshold.of(limit, 5))
    found = hs.tolerances(scene, samples=0)
    assert (found.verdict.value, found.certified) == (told, True)


# --- crossings that were placed: r is a line, or a product of lines, in the square of the frequency -----------------------


PART = {"real": "1 + b + a*s^2", "imag": "1 + s*(b + a*s^2)"}
"""Gains with r = |b - a w^2|, and w |b - a w^2|; the other ratio is 0."""


def told(box: Mapping[str, list[Fraction]], band: tuple[Any, Any], part: str = "real", samples: int = 0) -> Any:
    scene = gain(PART[part], band, hs.Threshold.of(text(box["c"])), a=box["a"], b=box["b"])
    return hs.tolerances(scene, samples=samples)


def boxes(pick: Random, b: tuple[int, int]) -> dict[str, list[Fraction]]:
    """Ranges of up to 10 per cent of a, b and c, of which one may have no width."""
    share = lambda low, high: Fraction(pick.randint(low, high), 100)  # noqa: E731
    found = {
        "a": [share(90, 98) / 10, share(100, 105) / 10], "b": [share(*b), share(b[1] + 1, b[1] + 3)],
        "c": [share(20, 21), share(22, 23)],
    }  # fmt: skip
    for key in pick.sample(sorted(found), pick.choice([0, 0, 1])):
        found[key] = found[key][:1] * 2
    return found


def ends(box: Mapping[str, list[Fraction]], side: int) -> list[float]:
    """From where to where |b - a w^2| crosses c with b - a w^2 = -c (side 1) or c (-1)."""
    a, b, c = box["a"], box["b"], box["c"]
    near, far = (c[0], c[1]) if side > 0 else (-c[1], -c[0])
    return [sqrt((b[0] + near) / a[1]), sqrt((b[1] + far) / a[0])]


def corners(box: Mapping[str, list[Fraction]], side: int, *, highest: bool) -> dict[str, Rational]:
    """What varies, at the values for which that crossing is highest (lowest)."""
    at = {"a": box["a"][not highest], "b": box["b"][highest], "c": box["c"][highest is (side > 0)]}
    return {key: rational(at[key]) for key in "abc" if box[key][0] != box[key][1]}


@pytest.mark.parametrize("seed", range(3))
def test_a_crossing_inside_the_band_has_exact_ends_at_the_corners_to_which_it_moves(seed: int) -> None:
    """From rest, or from a frequency on; below c at b: all that is told is of the one crossing w^2 = (b + c)/a."""
    pick = Random(seed)
    box, low = boxes(pick, (2, 8)), pick.choice([Fraction(0), Fraction(1, 2)])
    found = told(box, (low, 3), samples=4)
    [x] = found.enclosures
    assert (x.criterion.name, x.count) == ("real", 1)
    assert ends_of(x) == pytest.approx(ends(box, 1), rel=1e-13)
    assert (x.at_low, x.at_high) == tuple(corners(box, 1, highest=y) for y in (False, True))
    assert x.monotonic == {key: -1 if key == "a" else 1 for key in corners(box, 1, highest=True)}
    assert (found.verdict.value, found.bandwidth, found.certified) == ("none", (x.low, x.high), True)
    assert (found.transparent, found.noticed and found.noticed.transparent) == (None, False)
    for one in found.samples:
        values = {key: Fraction(str(y)) for key, y in one.values.items()}
        assert all(box[key][0] <= y <= box[key][1] for key, y in values.items())
        a, b, c = (values.get(key, box[key][0]) for key in "abc")
        assert [float(y) for y in one.crossings["real"]] == [pytest.approx(sqrt((b + c) / a), rel=1e-13)]
        assert (one.crossings["imag"], one.bandwidth, one.transparent) == ((), one.first, False)
    assert len({str(one.values) for one in found.samples}) == 4


@pytest.mark.dear("0")
@pytest.mark.parametrize("seed", range(2))
def test_what_is_noticed_at_rest_for_all_values_is_not_between_two_crossings(seed: int) -> None:
    """b > c: noticed up to w^2 = (b - c)/a, and from (b + c)/a on."""
    box = boxes(Random(50 + seed), (40, 44))
    found = told(box, (0, 4))
    for x, side in zip(found.enclosures, (-1, 1), strict=True):
        assert (x.criterion.name, x.count) == ("real", 1)
        assert ends_of(x) == pytest.approx(ends(box, side), rel=1e-13)
        assert (x.at_low, x.at_high) == tuple(corners(box, side, highest=y) for y in (False, True))
        assert x.monotonic == {key: {"a": -1, "b": 1, "c": side}[key] for key in corners(box, 1, highest=True)}
    assert (found.verdict.value, found.bandwidth, found.transparent) == ("none", None, None)
    inside = told(box, (Fraction(ends(box, -1)[1]) + Fraction(1, 100), Fraction(ends(box, 1)[0]) - Fraction(1, 100)))
    assert (inside.verdict.value, inside.enclosures, inside.noticed) == ("all", (), None)
    assert {float(x) for x in inside.bandwidth or ()} == {float(inside.box.scene.band[1])}
    outside = told(box, (Fraction(1, 4), Fraction(1, 2)))
    assert (outside.verdict.value, outside.enclosures, outside.bandwidth, outside.transparent) == (
        "none",
        (),
        None,
        None,
    )


@pytest.mark.dear("0-real", "3-imag")
@pytest.mark.few(3)
@pytest.mark.parametrize("part", PART)
@pytest.mark.parametrize("seed", range(4))
def test_a_band_that_ends_short_of_among_or_beyond_the_crossings_gives_the_three_verdicts(part: str, seed: int) -> None:
    """r = a w^2, or a w^3: w from (c/a)^(1/2), or (c/a)^(1/3)."""
    box = boxes(Random(seed), (0, 0)) | {"b": [Fraction(0)] * 2}
    root = 2 if part == "real" else 3
    least, most = (float(x) ** (1 / root) for x in (box["c"][0] / box["a"][1], box["c"][1] / box["a"][0]))
    for top, verdict in ((least * 0.98, "all"), ((least + most) / 2, "depends"), (most * 1.02, "none")):
        end = Fraction(round(top * 10**6), 10**6)
        found = told(box, (0, end), part)
        assert found.verdict.value == verdict
        assert [float(x) for x in found.bandwidth] == pytest.approx(
            [min(x, float(end)) for x in (least, most)], rel=1e-13
        )
        assert (found.transparent is None, found.noticed is None) == (verdict == "none", verdict == "all")
        if verdict == "all":
            assert found.enclosures == ()
            continue
        [x] = found.enclosures
        assert (x.criterion.name, x.count) == (part, 1 if verdict == "none" else None)
        assert float(x.low) == pytest.approx(least, rel=1e-13)
        assert (x.at_low, x.at_high is not None) == (corners(box, 1, highest=False), verdict == "none")
        if verdict == "depends":
            assert float(x.high) == pytest.approx(float(end), rel=1e-9)
            values = [
                {key: Fraction(str(y)) for key, y in one.values.items()} for one in (found.transparent, found.noticed)
            ]
            over = [(x.get("a", box["a"][0])) * end**root > x.get("c", box["c"][0]) for x in values]
            assert over == [False, True]


@pytest.mark.dear("11", "16", "7")
@pytest.mark.parametrize("seed", often(range(20), lambda seed: seed not in {6, 8, 10, 12, 13}))  # these stay undecided
def test_whatever_box_of_a_line_is_drawn_all_members_are_as_it_is_told(seed: int) -> None:
    """r_r = |b - a omega^2| about c = 1/5, touching it at the ends of the band or not, with or without width in a or b."""
    pick = Random(seed)
    a, b = Fraction(pick.randint(5, 40), 1000), pick.choice([Fraction(n, 20) for n in (0, 2, 3, 4, 6, 10)])
    across = [a, a * (1 + Fraction(pick.choice([0, 1, 5, 20, 60]), 100))]
    along = [b, b + Fraction(pick.choice([1, 5, 10, 30]), 100)]
    places = [(x + sign * C) / y for x in along for y in across for sign in (-1, 1) if x + sign * C > 0]
    low = Fraction(pick.choice([0, 0, 1, 2]))
    near = float(pick.choice(places)) * pick.choice([0.5, 0.9, 1, 1.1, 2])
    high = max(Fraction(round(sqrt(near) * 100), 100), low + 1)
    found = hs.tolerances(gain("1 + b + a*s^2", (low, high), a=across, b=along), samples=0)
    sets = [*product(across, along)]
    sets += [tuple(x + (y - x) * Fraction(pick.randint(0, 16), 16) for x, y in (across, along)) for _ in range(20)]
    kept = [max(abs(y - x * w**2) for w in (low, high)) <= C for x, y in sets]
    verdict = found.verdict.value
    assert verdict != "all" or all(kept)
    assert verdict != "none" or not any(kept)
    touching = any(abs(y - x * w**2) == C for x, y in sets[:4] for w in (low, high))
    assert verdict != "undecided" or touching or not any(kept)
    assert verdict != "depends" or (found.transparent and found.noticed)
    spans = [(x * (1 - 1e-12), y * (1 + 1e-12)) for x, y in map(ends_of, found.enclosures)]
    for x, y in sets:
        own = [sqrt(z) for z in ((y - C) / x, (y + C) / x) if low**2 < z < high**2]
        assert all(any(p <= z <= q for p, q in spans) for z in own)
    if found.bandwidth is not None:
        widths = [min(sqrt((C + y) / x), float(high)) for x, y in sets if abs(y - x * low**2) <= C]
        assert len(widths) == len(sets)
        least, most = map(float, found.bandwidth)
        assert all(least * (1 - 1e-12) <= z <= most * (1 + 1e-12) for z in widths)
        assert least >= 0.99 * min(widths)


def branches(pick: Random) -> list[Callable[[float, float], float]]:
    """Up to three squares of frequencies between 1 and 9 that keep apart for p and q in [0, 1], each bilinear in these."""
    count = pick.randint(1, 3)
    found = []
    for n in range(count):
        p, q, both = (round(pick.uniform(-1, 1) * 5 / count / 6, 2) for _ in range(3))
        at = round(2 + 6 * (n + 0.5) / count, 2)
        found.append(lambda x, y, at=at, p=p, q=q, both=both: at + p * x + q * y + both * x * y)
    return found


@pytest.mark.dear("11", "1")
@pytest.mark.parametrize("seed", often(range(24), {1, 2, 4, 8, 11, 14, 18, 21, 22}.__contains__))
def test_each_crossing_that_keeps_apart_is_counted_and_told_to_its_ends_and_the_ways_in_which_it_moves(
    seed: int,
) -> None:
    """r_r = |c + S (x - x_1(p, q)) (x - x_2(p, q)) ...|, x = w^2: extreme at corners, where it is told exactly if slopes tell so."""
    pick = Random(seed)
    own, sign = branches(pick), pick.choice([-1, 1])
    rows = [[x(0, 0), x(1, 0) - x(0, 0), x(0, 1) - x(0, 0), x(1, 1) - x(1, 0) - x(0, 1) + x(0, 0)] for x in own]
    factors = "*".join("(-s^2 - ({:.6f} + {:.6f}*p + {:.6f}*q + {:.6f}*p*q))".format(*x) for x in rows)
    size = float(C) * 1.5 / 9 ** len(own)
    found = hs.tolerances(gain(f"1 + {float(C)} + {sign * size:.9f}*{factors}", (0, 3), p=[0, 1], q=[0, 1]), samples=0)
    assert len(found.enclosures) == len(own)
    for x, branch, (_, p, q, both) in zip(found.enclosures, own, rows, strict=True):
        places = {sqrt(branch(*at)): at for at in product((0, 1), repeat=2)}
        low, high = min(places), max(places)
        assert (x.part, x.count) == (hs.Part.REAL, 1)
        assert float(x.low) <= low * (1 + 1e-12)
        assert float(x.high) >= high * (1 - 1e-12)
        assert ends_of(x) == pytest.approx([low, high], rel=2e-3)
        ways = {"p": (p, p + both), "q": (q, q + both)}
        for key, way in ways.items():
            moves = int(min(way) > 0) - int(max(way) < 0)
            assert x.monotonic[key] in (0, moves)
            assert x.monotonic[key] == moves or len(own) > 1
        for end, corner, true in ((x.low, x.at_low, low), (x.high, x.at_high, high)):
            assert corner is not None or 0 in x.monotonic.values()
            if corner is not None:
                assert tuple(int(corner[key]) for key in "pq") == places[true]
                assert float(end) == pytest.approx(true, rel=1e-12)


@pytest.mark.few("1")
@pytest.mark.parametrize("seed", range(3))
def test_an_end_inside_the_box_is_a_bound_hardly_beyond_it_and_one_at_a_corner_is_exact(seed: int) -> None:
    """r_i = omega T (1 + p^2) = c at omega = c/(T (1 + p^2)): highest at p = 0 if it is in the box, lowest at the larger |p|."""
    pick = Random(seed)
    T = [Fraction(pick.randint(9, 10), 1000), Fraction(pick.randint(11, 12), 1000)]
    p = [Fraction(pick.randint(-12, 3), 10), Fraction(pick.randint(4, 12), 10)]
    c = [Fraction(1, 10), Fraction(pick.choice([10, 11]), 100)]
    found = hs.tolerances(
        gain("1 + s*T*(1 + p^2)", (pick.choice([0, 1]), 20), hs.Threshold.of(text(c)), T=T, p=p), samples=0
    )
    [x] = found.enclosures
    least, most = min(y**2 for y in (p if p[0] > 0 else [Fraction(0)])), max(y**2 for y in p)
    true = [float(c[0] / (T[1] * (1 + most))), float(c[1] / (T[0] * (1 + least)))]
    assert float(x.low) <= true[0] * (1 + 1e-13)
    assert float(x.high) >= true[1] * (1 - 1e-13)
    assert ends_of(x) == pytest.approx(true, rel=1e-13 if p[0] > 0 else 2e-3)
    assert (x.count, x.monotonic["T"], x.monotonic.get("c", 1), found.verdict.value) == (1, -1, 1, "none")
    if p[0]:
        assert x.monotonic["p"] == (-1 if p[0] > 0 else 0)
        assert (x.at_high is not None) is (p[0] > 0)
    assert float(found.bandwidth[0]) == float(x.low)


@pytest.mark.dear("1")
@pytest.mark.parametrize("seed", range(2))
def test_crossings_that_merge_within_the_box_are_one_enclosure_that_holds_both(seed: int) -> None:
    """r_r = |b - a x|, x = omega^2, b - c about 0: the lower crossing comes from omega = 0."""
    pick = Random(seed)
    a, b = Fraction(pick.randint(8, 12), 100), [C + sign * Fraction(pick.randint(1, 5), 100) for sign in (-1, 1)]
    found = hs.tolerances(gain(f"1 + b + {a}*s^2", (0, 4), b=b), samples=0)
    first, second = found.enclosures
    assert (first.count, second.count, float(first.low)) == (None, 1, 0)
    assert float(first.high) == pytest.approx(sqrt((b[1] - C) / a), rel=1.01e-3)
    assert float(first.high) >= sqrt((b[1] - C) / a) * (1 - 1e-13)
    assert ends_of(second) == pytest.approx([sqrt((x + C) / a) for x in b], rel=1e-13)
    assert (found.bandwidth, found.verdict.value) == (None, "none")


# --- enclosures against sets of values answered one by one ----------------------------------------------------------------


def counts_match(found: Any) -> None:
    """Of the nominal values, of those that were drawn and of all corners."""
    by_part = sorted(found.enclosures, key=lambda x: (x.part.value, float(x.low)))
    assert all(x.part is not y.part or float(x.high) < float(y.low) for x, y in pairwise(by_part))
    names = [x.name for x in found.box.sides]
    shares = (dict(zip(names, map(Fraction, x), strict=True)) for x in product((0, 1), repeat=len(names)))
    for one in (found.nominal, *found.samples, *(found.one(found.box.values(x)) for x in shares)):
        for part in hs.Part:
            own, crossings = [x for x in by_part if x.part is part], [float(x) for x in one.crossings[part.value]]
            inside = [[c for c in crossings if a * (1 - 1e-12) <= c <= b * (1 + 1e-12)] for a, b in map(ends_of, own)]
            assert sorted(x for y in inside for x in y) == crossings
            assert all(x.count in (None, len(y)) for x, y in zip(own, inside, strict=True))
        if found.bandwidth and one.bandwidth:
            assert float(found.bandwidth[0]) <= float(one.bandwidth) <= float(found.bandwidth[1])
        assert found.verdict.value not in {True: ("none",), False: ("all",), None: ()}[one.transparent]


def random_scene(seed: int) -> hs.Scene:
    draw = Random(seed)
    k, b = (f"{x} +- {draw.choice([1, 2, 5])} %" for x in (draw.randint(50, 300), draw.randint(1, 20)))
    felt = draw.choice([
        lambda: hs.environments.mass_spring_damper(m=draw.choice([1, 2]), b=9, k=k), lambda: hs.environments.maxwell(k=k, b=b),
        lambda: hs.environments.zener(k0=50, k1=k, b1=7),
    ])()  # fmt: skip
    effect = draw.choice([
        lambda: F.second_order_lowpass(f"{draw.randint(10, 90)} +- 5 %", Rational(draw.randint(1, 9), 10)),
        lambda: F.compliance(k="900 +- 2 %", b=draw.randint(1, 9)), lambda: F.delay("10 ms +- 20 %"),
        lambda: F.shunt(m=Rational(1, 5), b=draw.randint(1, 3), k="5 +- 5 %"),
    ])()  # fmt: skip
    return hs.Scene(felt, (effect,), (0, draw.choice([15, 40])))


@pytest.mark.dear("5", "7")
@pytest.mark.parametrize("seed", often([1, 2, *range(5, 30)], {1, 5, 7}.__contains__))
def test_an_enclosure_holds_as_many_crossings_as_it_says(seed: int) -> None:
    counts_match(hs.tolerances(random_scene(seed), samples=4))


@pytest.mark.slow
@examples(20)
@given(st.integers(100, 10**6))
def test_what_is_told_of_all_members_is_what_evaluate_tells_of_each(seed: int) -> None:
    agrees_with_evaluate(hs.tolerances(random_scene(seed), samples=0))


@pytest.mark.few("fu2019")
@pytest.mark.parametrize("name", hs.scene_names())
def test_a_shipped_scene_known_to_a_percent_is_as_each_of_its_members(name: str) -> None:
    scene = hs.load_scene(name)
    free = [x for x in scene.parameters if x.value and x.symbol not in scene.chain.harmonic_symbols][:3]
    box = scene.with_values({x.path: [x.value * Rational(n, 100) for n in (99, 101)] for x in free})
    agrees_with_evaluate(hs.tolerances(box, samples=0, limit=20))


@pytest.mark.few(1)
@pytest.mark.parametrize("threshold", ["0.09999", "0.099999", "0.0999999"])
def test_two_crossings_close_together_have_enclosures_of_their_own(threshold: str) -> None:
    """A peak of r_i that rises little above the threshold: 1/10 at 2.16 and at 4.16 rad/s."""
    chain = F.series("1 + 0.4*s/(s^2 + 2*s + 9)"), F.shunt(m="1e-9 kg +- 1 %")
    counts_match(hs.tolerances(hs.Scene(SPRING, chain, (0, 15), hs.Threshold(1, threshold)), samples=1))


@pytest.mark.slow
def test_the_shipped_scene_crosses_where_it_is_said_to() -> None:
    found = hs.tolerances("fu2019-tolerances", samples=60)
    counts_match(found)
    [imag] = [x for x in found.enclosures if x.part is hs.Part.IMAG]
    assert (imag.count, imag.low.digits(6), imag.high.digits(6)) == (1, "11.0702", "12.8735")
    assert found.verdict.value == "none"


@pytest.mark.slow
def test_a_range_too_wide_to_be_bounded_at_once_is_cut_also_at_the_low_end_of_the_band() -> None:
    """The eighth power of a cut-off known to 20 % spans a factor of 25; by hand r of either part is 0 at rest, and small near it."""
    scene = hs.load_scene("fu2019").with_values({"omega_n": "80 rad/s +- 20 %"})
    low, high = (float(x) for x in hs.tolerances(scene, samples=0).bandwidth or ())
    w, a = np.linspace(0.005, 15, 3000), np.linspace(64, 96, 9)[:, None]
    H = 100 - 1.8 * w**2 + 15j * w
    dH = H * (1 / (1 + 1j * w / a - (w / a) ** 2) - 1)
    larger = np.maximum(abs(dH.real), abs(dH.imag)) > 0.1 * abs(H)
    first = w[larger.argmax(-1)]
    assert low == pytest.approx(first.min(), abs=0.005)
    assert high > first.max() - 0.005


@pytest.mark.slow
def test_an_end_lies_on_a_face_where_more_is_known_of_what_moves_it() -> None:
    """r_r of the paper's example moves one way over the whole box with omega_n alone, yet its high end is a corner."""
    scene = hs.load_scene("fu2019")
    numbers = [x for x in scene.parameters if x.path.startswith("environment") or x.path == "effects.filter.omega_n"]
    scene = scene.with_values({x.path: [x.value * Rational(n, 20) for n in (19, 21)] for x in numbers})
    found = hs.tolerances(scene, samples=40)
    counts_match(found)
    assert [name for name, sign in found.enclosures[0].monotonic.items() if sign] == ["omega_n"]
    assert [(x.at_low is not None, x.at_high is not None) for x in found.enclosures] == [(False, True), (True, True)]
    for x in found.enclosures:
        for end, corner in ((x.low, x.at_low), (x.high, x.at_high)):
            if corner is not None:
                there = hs.evaluate(scene.with_values(corner)).crossings
                assert any(y.part is x.part and y.omega.digits(30) == end.digits(30) for y in there)


@pytest.mark.few("150", "200")
@pytest.mark.parametrize("seconds", [130, 150, 200, 220, 300, 700])
def test_when_the_time_is_over_enclosures_still_hold_all_crossings(seconds: int) -> None:
    """A second passes whenever the clock is read."""
    with timed_by(count().__next__):
        found = hs.tolerances(random_scene(2), samples=3, limit=seconds)
    counts_match(found)
    assert seconds > 200 or (found.limit, found.to_dict()["limit"]) == (seconds, seconds)


# --- bounds over cells --------------------------------------------------------------------------------------------------


def certified_excess(box: Box, part: hs.Part, shares: Any) -> float:
    """r^2 - c^2 at a point of band and box, by the certified value of the ratio."""
    scene = box.scene.with_values(
        box.values({x.name: Fraction(float(y)) for x, y in zip(box.sides, shares[1:], strict=True)})
    )
    low, high = (float(x) for x in scene.band)
    square = scene.distortion().squared_ratios[part].ball(arb(low + float(shares[0]) * (high - low)))
    return float(square) - float(scene.threshold[part]) ** 2


ODD: dict[str, Callable[[], hs.Scene]] = {
    "fu2019-tolerances": lambda: hs.load_scene("fu2019-tolerances"),
    "delayed-spring": lambda: hs.load_scene("delayed-spring").with_values({"tau": ["20 ms", "30 ms"], "k": [90, 110]}),
    "sidestick": lambda: known_to_a_tenth("sidestick"),
    "organ-tissue": lambda: known_to_a_tenth("organ-tissue"),
    "position-force-teleoperation": lambda: known_to_a_tenth("position-force-teleoperation"),
    "a mass behind a delay, with an odd factor of s in common": lambda: hs.Scene(
        hs.environments.mass_spring_damper(m="2 kg +- 10 %"),
        (F.delay("5 ms +- 20 %"), F.shunt(m=[-1, "0.5"], b="-2 +- 1")), (1, 30),
    ),
    "a damper, from 0 on": lambda: hs.Scene(
        hs.environments.mass_spring_damper(b="3 +- 10 %"), (F.zero_order_hold("9 ms +- 30 %"), F.first_order_lag("8 Hz +- 5 %")), (0, 25),
    ),
    "a resonance without damping": lambda: hs.Scene(
        hs.environments.mass_spring_damper(m="1 kg +- 1 %", k=49), (F.first_order_lag("20 +- 20 %"),), (0, 15),
    ),
    "fractional tissue": lambda: hs.Scene(
        hs.environments.spring_pot(k_alpha="50 +- 10 %", alpha=["0.3", "0.5"]), (F.compliance(k="3000 +- 20 %"),), (0, 15),
        hs.Threshold.of("0.1 +- 10 %", "0.2 +- 20 %"),
    ),
    "waves, friction and thresholds that vary alone": lambda: hs.Scene(
        hs.environments.kelvin_voigt("200 +- 10 %", 3),
        (F.coulomb_friction("0.5 N +- 50 %", "2 cm"), F.wave_variables("20 +- 10 %", "5 ms +- 10 %")),
        (2, 20), hs.Threshold.of("0.15", "0.1 +- 20 %"),
    ),
    "a repeated factor and a parameter of both signs": lambda: hs.Scene(
        hs.environments.maxwell("300 +- 5 %", 9),
        (F.series("(s + a)^2*(s^2 + 2*q*s + 90)/(s + 30)^2/(s^2 + 90)", parameters={"a": [-5, 20], "q": "1 Hz"}),), (0, 9),
    ),
    "seven numbers and more": lambda: hs.Scene(SOFT, tuple(F.first_order_lag(["36", "44"], name=f"lag{i}") for i in range(6)), (0, 9)),
}  # fmt: skip


def known_to_a_tenth(name: str) -> hs.Scene:
    scene = hs.load_scene(name)
    return scene.with_values(
        {x.path: [x.value * Rational(n, 10) for n in (9, 11)] for x in scene.parameters if x.value}
    )


@pytest.mark.dear("a mass behind a delay, with an odd factor of s in common")
@pytest.mark.few("a mass behind a delay, with an odd factor of s in common", "a resonance without damping")
@pytest.mark.parametrize("name", ODD)
def test_bounds_over_a_cell_hold_the_excess_and_its_slopes_and_narrow_with_it(name: str) -> None:
    """At points against certified values, along each side against differences of these; cells shrink upon the points."""
    scene = ODD[name]()
    box, random = box_of(scene), np.random.default_rng(5)
    for criterion in noticed(scene.threshold):
        form, part = Excess(box, criterion), criterion.part
        start = random.uniform(0.02, 0.6, (2, form.sides))
        points = start + 0.3 * random.uniform(0, 1, (2, form.sides))
        values = [certified_excess(box, part, x) for x in points]
        for width in (0.3, 0.05, 0.005, 0):
            near = points + (start - points) * width / 0.3
            low, high = form.model(np.stack([near, near + width], -1)).bounds()
            assert all(low[i, 0] <= values[i] <= high[i, 0] for i in (0, 1))
            if width == 0.005:
                slopes = low, high
        low, high = slopes
        for i, point in enumerate(points):
            size = abs(values[i]) + float(scene.threshold[part]) ** 2
            assert high[i, 0] - low[i, 0] < 0.2 * size + 4 * abs(high[i, 1:]).sum() + 4 * abs(low[i, 1:]).sum()
            for side in range(form.sides):
                step = 1e-5 * np.eye(form.sides)[side]
                slope = (
                    (certified_excess(box, part, point + step) - certified_excess(box, part, point - step))
                    / 2e-5
                    * 0.0025
                )
                slack = 1e-5 * abs(slope) + 1e-9 * size
                assert low[i, 1 + side] - slack <= slope <= high[i, 1 + side] + slack
                assert form.matters[side] or slope == pytest.approx(0, abs=1e-9 * size)


@pytest.mark.dear("2")
@pytest.mark.parametrize("seed", range(3))
def test_whatever_is_felt_a_gain_is_off_by_the_modulus_of_what_it_is_more_than_1(seed: int) -> None:
    """|g/(1 + j x) - 1|^2 - c^2, behind a gain and a lag in series, for any environment; the threshold varies or does not."""
    rng = np.random.default_rng(seed)
    effects = F.first_order_lag(["36", "44"]), F.series("g", parameters={"g": ["0.9", "1.05"]})
    box = box_of(hs.Scene(SPRING, effects, (0, 10), hs.Threshold.of(["0.05", "0.2"] if seed else "0.1")))
    form = LargerExcess(box, noticed(box.scene.threshold)[seed % 2])
    for _ in range(4):
        at = rng.uniform(0.1, 0.9, form.sides)
        own = {x.name: float(x.low + (x.high - x.low) * y) for x, y in zip(box.sides, at[1:], strict=True)}
        exact = abs(own["g"] / (1 + 10j * at[0] / own["omega_c"]) - 1) ** 2 - own.get("c", 0.1) ** 2
        for width in (0, 0.05):
            low, high = form.model(np.stack([at - width, at + width], -1)[None]).bounds()
            assert low[0, 0] <= exact <= high[0, 0]
            assert width or high[0, 0] <= low[0, 0] + 1e-10


# --- as a user has it -----------------------------------------------------------------------------------------------------


def quantile(values: list[float], per_cent: int) -> float | None:
    """The least value that so many per cent do not exceed."""
    found = sorted(values)[max(ceil(per_cent * len(values) / 100) - 1, 0)]
    return None if np.isinf(found) else found


@pytest.mark.slow
@pytest.mark.parametrize("top", [4, 10])
def test_a_document_holds_what_its_parts_say(top: int) -> None:
    """Some of the sets that were drawn have no crossing up to 4 rad/s: theirs lies beyond; without a bandwidth it is less than any."""
    scene = hs.Scene(SOFT, (LAG,), (2, top))
    found = hs.tolerances(scene, 9, 7)
    again = [hs.tolerances(scene, 9, seed).samples for seed in (7, 8)]
    assert [x.values for x in found.samples] == [x.values for x in again[0]] != [x.values for x in again[1]]
    drawn = [float(x.values["omega_c"]) for x in found.samples]
    assert 36 <= min(drawn) < 38 < 42 < max(drawn) <= 44
    told = found.to_dict()
    assert told["varying"] == [
        {"name": "k", "low": 90.0, "high": 110.0},
        {"name": "omega_c", "low": 36.0, "high": 44.0},
    ]
    assert (told["verdict"], told["certified"]) == (found.verdict.value, True)
    assert told["bandwidth"] == [float(x) for x in found.bandwidth]
    estimates = told["estimates"]
    assert (estimates["samples"], estimates["seed"]) == (9, 7)
    assert estimates["transparent"] == sum(x.transparent is True for x in found.samples)
    for p in (5, 50, 95):
        first = quantile([np.inf if x.first is None else float(x.first) for x in found.samples], p)
        width = quantile([-np.inf if x.bandwidth is None else float(x.bandwidth) for x in found.samples], p)
        # Drawn sets are answered in floats, their roots to within a few units of the last place; those here are exact.
        assert estimates["first_crossing"][str(p)] == (first if first is None else pytest.approx(first, rel=1e-14))
        assert estimates["bandwidth"][str(p)] == (width if width is None else pytest.approx(width, rel=1e-14))
    [row], [x] = told["crossings"], found.enclosures
    assert (row["part"], row["omega"], row["count"], row["monotonic"]) == (
        "imag",
        ends_of(x),
        x.count,
        dict(x.monotonic),
    )
    assert float(row["enclosure"][0]) <= row["omega"][0] < row["omega"][1] <= float(row["enclosure"][1])
    assert row["reached_at"]["low"]["omega_c"] == "36"
    witnesses = told["witnesses"]
    for kind in ("transparent", "noticed"):
        one = getattr(found, kind)
        assert witnesses[kind] == (one and {key: str(y) for key, y in one.values.items()})


def test_the_command_line_tells_proof_and_estimate_apart(call: Any, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'environment = { model = "mass-spring-damper", k = "100 N/m +- 10 %" }\n'
        'effects = [{ model = "first-order-lag", omega_c = "40 rad/s +- 10 %" }]\nevaluation = { band = ["0 rad/s", "4 rad/s"] }'
    )
    status, out, _ = call("tolerances", str(path), "--samples", "3")
    assert (status, "Proven:" in out, "Estimated:" in out) == (0, True, True)
    document = json.loads(call("tolerances", str(path), "--json", "--samples", "0")[1])
    assert (document["schema"], document["verdict"], document["estimates"]) == (
        "haptisym.tolerances/1",
        "depends",
        None,
    )
