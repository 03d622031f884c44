"""Random boxes of ratios that are lines in the square of the frequency: all that is told of them is known in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import sqrt
from random import Random
from typing import Any

import pytest
from sympy import Rational

import haptisym as hs
from haptisym.verbs.tolerances.proofs import Tolerances

SPRING = hs.environments.mass_spring_damper(k=100)
PART = {"real": "1 + b + a*s^2", "imag": "1 + s*(b + a*s^2)"}
"""Gains with r = |b - a w^2|, and w |b - a w^2|; the other ratio is 0."""


def tenth(pick: Random, low: int, high: int) -> Fraction:
    return Fraction(pick.randint(low, high), 100)


def told(box: Mapping[str, list[Fraction]], band: tuple[Any, Any], part: str = "real", samples: int = 0) -> Tolerances:
    """The answer for a gain of a and b with a threshold c for both parts; what has one value is no side."""
    text = {key: [str(x) for x in ends] if ends[0] != ends[1] else str(ends[0]) for key, ends in box.items()}
    gain = hs.effects.series(PART[part], parameters={"a": text["a"], "b": text["b"]})
    return hs.tolerances(hs.Scene(SPRING, (gain,), band, hs.Threshold.of(text["c"])), samples=samples)


def boxes(pick: Random, b: tuple[int, int]) -> dict[str, list[Fraction]]:
    """Ranges of up to 10 per cent of a, b and c, of which one may have no width."""
    found = {
        "a": [Fraction(1, 10) * tenth(pick, 90, 98), Fraction(1, 10) * tenth(pick, 100, 105)],
        "b": [tenth(pick, *b), tenth(pick, b[1] + 1, b[1] + 3)],
        "c": [tenth(pick, 20, 21), tenth(pick, 22, 23)],
    }
    for key in pick.sample(sorted(found), pick.choice([0, 0, 1])):
        found[key] = found[key][:1] * 2
    return found


def rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


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
    least, most = ends(box, 1)
    found = told(box, (low, 3))
    [x] = found.enclosures
    assert (x.criterion.name, x.count) == ("real", 1)
    assert [float(x.low), float(x.high)] == pytest.approx([least, most], rel=1e-13)
    assert (x.at_low, x.at_high) == (corners(box, 1, highest=False), corners(box, 1, highest=True))
    assert x.monotonic == {key: -1 if key == "a" else 1 for key in corners(box, 1, highest=True)}
    assert found.verdict.value == "none"
    assert found.bandwidth == (x.low, x.high)
    assert (found.transparent, found.noticed and found.noticed.transparent) == (None, False)
    assert found.certified


@pytest.mark.parametrize("seed", range(2))
def test_what_is_noticed_at_rest_for_all_values_is_not_between_two_crossings(seed: int) -> None:
    """b > c: noticed up to w^2 = (b - c)/a, and from (b + c)/a on."""
    pick = Random(50 + seed)
    box = boxes(pick, (40, 44))
    found = told(box, (0, 4))
    assert [(x.criterion.name, x.count) for x in found.enclosures] == [("real", 1)] * 2
    for x, side in zip(found.enclosures, (-1, 1), strict=True):
        assert [float(x.low), float(x.high)] == pytest.approx(ends(box, side), rel=1e-13)
        assert (x.at_low, x.at_high) == tuple(corners(box, side, highest=y) for y in (False, True))
        moves = {"a": -1, "b": 1, "c": side}
        assert x.monotonic == {key: moves[key] for key in corners(box, 1, highest=True)}
    assert (found.verdict.value, found.bandwidth, found.transparent) == ("none", None, None)
    assert found.nominal.bandwidth is None
    inside = told(box, (Fraction(ends(box, -1)[1]) + Fraction(1, 100), Fraction(ends(box, 1)[0]) - Fraction(1, 100)))
    assert (inside.verdict.value, inside.enclosures, inside.noticed) == ("all", (), None)
    assert [float(x) for x in inside.bandwidth or ()] == [float(inside.box.scene.band[1])] * 2
    outside = told(box, (Fraction(1, 4), Fraction(1, 2)))
    assert (outside.verdict.value, outside.enclosures, outside.bandwidth) == ("none", (), None)
    assert (outside.transparent, outside.noticed) == (None, outside.nominal)


@pytest.mark.parametrize("part", PART)
@pytest.mark.parametrize("seed", range(2))
def test_a_band_that_ends_short_of_among_or_beyond_the_crossings_gives_the_three_verdicts(part: str, seed: int) -> None:
    """r = a w^2, or a w^3: w from (c/a)^(1/2), or (c/a)^(1/3)."""
    pick = Random(seed)
    box = boxes(pick, (0, 0)) | {"b": [Fraction(0)] * 2}
    root = 2 if part == "real" else 3
    least, most = (float(x) ** (1 / root) for x in (box["c"][0] / box["a"][1], box["c"][1] / box["a"][0]))
    for top, verdict in ((least * 0.98, "all"), ((least + most) / 2, "depends"), (most * 1.02, "none")):
        end = Fraction(round(top * 10**6), 10**6)
        found = told(box, (0, end), part)
        assert found.verdict.value == verdict
        bounds = [float(x) for x in found.bandwidth or ()]
        assert bounds == pytest.approx([min(least, float(end)), min(most, float(end))], rel=1e-13)
        assert (found.transparent is None) is (verdict == "none")
        assert (found.noticed is None) is (verdict == "all")
        if verdict == "all":
            assert found.enclosures == ()
            continue
        [x] = found.enclosures
        assert (x.criterion.name, x.count) == (part, 1 if verdict == "none" else None)
        assert float(x.low) == pytest.approx(least, rel=1e-13)
        assert (x.at_low, x.at_high is not None) == (corners(box, 1, highest=False), verdict == "none")
        if verdict == "depends":
            assert float(x.high) == pytest.approx(float(end), rel=1e-9)
            assert found.transparent
            assert found.noticed
            values = [
                {key: Fraction(str(y)) for key, y in one.values.items()} for one in (found.transparent, found.noticed)
            ]
            over = [(x.get("a", box["a"][0])) * end**root > x.get("c", box["c"][0]) for x in values]
            assert over == [False, True]


@pytest.mark.parametrize("seed", range(2))
def test_sets_that_are_drawn_lie_in_the_box_and_cross_within_the_enclosures(seed: int) -> None:
    pick = Random(seed)
    box = boxes(pick, (2, 8))
    found = told(box, (0, 3), samples=4)
    assert len(found.samples) == 4
    [x] = found.enclosures
    for one in found.samples:
        values = {key: Fraction(str(y)) for key, y in one.values.items()}
        a, b, c = (values.get(key, box[key][0]) for key in "abc")
        assert all(box[key][0] <= y <= box[key][1] for key, y in values.items())
        [crossing] = one.crossings["real"]
        assert float(crossing) == pytest.approx(sqrt((b + c) / a), rel=1e-13)
        assert float(x.low) <= float(crossing) <= float(x.high)
        assert (one.crossings["imag"], one.bandwidth, one.first, one.transparent) == ((), crossing, crossing, False)
    assert len({str(one.values) for one in found.samples}) == 4
