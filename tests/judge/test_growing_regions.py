"""Ranges of any number of a JND: every bandwidth that exact evaluations with numbers of them have is said to be, and at jumps no other."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest
from certificates import region_scene
from flint import arb
from marks import often
from matplotlib.figure import Figure

import haptisym as hs
from haptisym.figures.bandwidths import draw_bandwidths

PAPER = hs.load_scene("fu2019")
DIAMOND = {"shape": "polygon", "corners": [[0.1, 0], [0, 0.1], [-0.1, 0], [0, -0.1]]}
NEAR = Fraction(1, 1 << 60)


def judged(asked: hs.Scene, jnd: Any) -> hs.Evaluation:
    return hs.evaluate(hs.Scene(asked.environment, asked.effects, asked.band, jnd))


def middle(x: hs.RealNumber | None) -> Fraction | None:
    return None if x is None else sum(x.bounds(150), Fraction(0)) / 2


def width(asked: hs.Scene, jnd: Any) -> Fraction | None:
    return middle(judged(asked, jnd).bandwidth)


def times(x: Any, t: Fraction) -> Any:
    """Limits that many times as large."""
    if isinstance(x, dict):
        return {key: y if key in ("shape", "tilt") else times(y, t) for key, y in x.items()}
    if isinstance(x, list):
        return [times(y, t) for y in x]
    return f"({x})*({t})" if "omega" in str(x) else str(Fraction(str(x)) * t)


def is_told(found: Any, x: Fraction) -> bool:
    near = Fraction(1, 1 << 90) * max(x, Fraction(1, 1000))
    inside = any(middle(j.low) + near < x < middle(j.high) - near for j in found.jumps)
    return middle(found.least) - near <= x <= middle(found.most) + near and not inside


def ends_are(found: Any, low: Fraction | None, high: Fraction | None) -> None:
    """The least and the most are those of the ends."""
    assert (found.most is None) == (high is None)
    for told, x in ((found.least, low), (found.most, high)):
        assert x is None or abs(middle(told) - x) <= Fraction(1, 1 << 90) * x


def scales(asked: hs.Scene, jnd: Any, low: Fraction, high: Fraction) -> Any:
    """What is said of a scale from low to high, held against multiples of the region."""
    found = judged(asked, {**jnd, "scale": [str(low), str(high)]}).bandwidths
    ends = [width(asked, times(jnd, t)) for t in (low, high)]
    ends_are(found, *ends)
    if not found.certified or found.most is None:
        return found
    assert (ends[0] is None) == bool(found.blocked)
    for i in range(1, 6):
        t = low + (high - low) * i / 6
        x = width(asked, times(jnd, t))
        assert x is None or is_told(found, x)
        assert all((x is None) == (t < middle(y)) for y in found.blocked.values())
    for jump in found.jumps:
        below, above = jump.threshold.bounds(80)
        before, after = (width(asked, times(jnd, t)) for t in (below * (1 - NEAR), above * (1 + NEAR)))
        assert before is None or before <= middle(jump.low) * (1 + NEAR)
        assert after * (1 + NEAR) >= middle(jump.high)
        if before is not None:
            assert (before == middle(jump.low)) if jump.includes_low else (before < middle(jump.low))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("first", often(range(0, 400, 20), [0].__contains__))
def test_a_region_of_a_random_scene_that_is_scaled_has_the_bandwidths_of_its_multiples(first: int) -> None:
    for seed in range(first, first + (3 if not first else 20)):
        text = region_scene(seed)
        scales(hs.parse_scene(text), tomllib.loads(text)["evaluation"]["jnd"], Fraction(1, 2), Fraction(5, 2))


# --- numbers apart ----------------------------------------------------------------------------------------------------


def places(jnd: Any) -> Iterator[tuple[str, ...]]:
    """Where a number stands that may have a range: not those in omega, tilts and corners."""
    for key, x in jnd.items():
        for path, y in [((key, way), y) for way, y in x.items()] if isinstance(x, dict) else [((key,), x)]:
            if path[0] in ("real", "imag", "floor") and "omega" not in str(y):
                yield path


def put(jnd: Any, path: tuple[str, ...], given: Any) -> Any:
    key, *rest = path
    return {**jnd, key: put(jnd[key], tuple(rest), given) if rest else given}


def apart(asked: hs.Scene, jnd: Any, listed: list[tuple[str, ...]]) -> Any:
    """What is said of ranges of several numbers, held against their values."""
    nominal = {path: Fraction(str(jnd[path[0]][path[1]] if len(path) > 1 else jnd[path[0]])) for path in listed}
    shares = [Fraction(n, 10) for n in (6, 9, 13, 20)]

    def at(chosen: tuple[Fraction, ...]) -> Fraction | None:
        own = jnd
        for path, t in zip(listed, chosen, strict=True):
            own = put(own, path, str(nominal[path] * t))
        return width(asked, own)

    wide = jnd
    for path, x in nominal.items():
        wide = put(wide, path, [str(x * shares[0]), str(x * shares[-1])])
    found = judged(asked, wide).bandwidths
    ends_are(found, *(at((t,) * len(listed)) for t in (shares[0], shares[-1])))
    for chosen in product(shares, repeat=len(listed)) if found.most is not None and found.least is not None else ():
        x = at(chosen)
        assert x is None or is_told(found, x), chosen
    return found


@pytest.mark.parametrize("first", often(range(0, 400, 20), [].__contains__))
def test_ranges_of_the_numbers_of_a_random_region_give_the_bandwidths_of_their_values(first: int) -> None:
    for seed in range(first, first + 20):
        text = region_scene(seed)
        jnd = tomllib.loads(text)["evaluation"]["jnd"]
        listed = list(places(jnd))[: 1 + seed % 3]
        if listed and jnd.get("tilt", "0/10") == "0/10":
            apart(hs.parse_scene(text), jnd, listed)


def test_a_floor_and_limits_for_each_way_move_the_papers_example_between_known_values() -> None:
    """Known: a floor of 15 N/m crosses at 8.88766..., a limit of 8 % for growth at 6.53358... and returns at 7.65752..."""
    floor = judged(PAPER, {"real": 0.1, "imag": 0.1, "floor": ["5 N/m", "15 N/m"]}).bandwidths
    assert (floor.least.digits(15), floor.most.digits(15)) == ("7.97891679017471", "8.88766189298739")
    sides = {"real": {"higher": ["0.06", "0.08"], "lower": 0.12}, "imag": 0.1}
    found = judged(PAPER, sides).bandwidths
    assert (found.most.digits(14), found.jumps, found.ends_alone) == ("6.5335818444859", (), False)
    wide = judged(PAPER, put(sides, ("real", "higher"), ["0.06", "0.2"])).bandwidths
    [jump] = wide.jumps  # where |Re H_perc| = |Re H_env| the lower limit takes over, and is not exceeded
    assert (jump.low.digits(14), jump.includes_low) == ("7.6575265525", False) or jump.low.digits(12) == "7.65752655249"
    assert width(PAPER, put(sides, ("real", "higher"), "0.0962")) < jump.low.bounds(90)[0]


def test_the_bandwidth_stands_where_a_tighter_limit_takes_over_and_leaves_out_what_lies_behind_the_step() -> None:
    """Re G = 1 - 2.5 * 4 w^2/((9 - w^2)^2 + 4 w^2) is -1, where a spring's part is as large as it was, for (9 - w^2)^2 = w^2: at
    (sqrt(37) -+ 1)/2. Between the limit for growth holds. Behind that r_r falls from 2, which the tighter limit 2 - w/10 judges.
    """
    spring = hs.environments.mass_spring_damper(k=100)
    asked = hs.Scene(spring, (hs.effects.series("1 - 5*s/(s^2 + 2*s + 9)"),), (0, 19))
    jnd = {"real": {"higher": "4", "lower": "2 - omega/10"}, "imag": "100"}
    first, second = (Fraction(Decimal(37).sqrt() + n) / 2 for n in (-1, 1))
    found = scales(asked, jnd, Fraction(1, 2), Fraction(3))
    assert [(float(x.low), x.includes_low) for x in found.jumps] == [(float(first), False), (float(second), True)]
    assert float(found.jumps[0].high) == float(second)
    assert float(found.jumps[1].threshold) == pytest.approx(float(2 / (2 - second / 10)), rel=1e-15)
    stands = [width(asked, times(jnd, Fraction(t))) for t in ("1.172", "1.18", "1.19")]
    assert stands == [middle(found.jumps[1].low)] * 3
    page = " ".join(str(judged(asked, {**jnd, "scale": ["0.5", "3"]})).split())
    assert "but those from 2.5414 to below 3.5414 rad/s (at a scale of 1.1456) and above 3.5414 to below" in page


def test_a_diamond_of_corners_jumps_as_the_diamond_does() -> None:
    one = judged(PAPER, {**DIAMOND, "scale": ["0.5", "2"]}).bandwidths
    other = judged(PAPER, {"shape": "diamond", "real": ["0.05", "0.2"], "imag": ["0.05", "0.2"]}).bandwidths
    [a], [b] = one.jumps, other.jumps
    assert [x.digits(15) for x in (one.least, one.most, a.low, a.high)] == [
        x.digits(15) for x in (other.least, other.most, b.low, b.high)
    ]
    assert 10 * float(b.threshold) == pytest.approx(float(a.threshold))


def test_half_widths_apart_tell_the_ends_and_not_what_lies_between() -> None:
    found = judged(PAPER, {"shape": "ellipse", "real": ["0.09", "0.11"], "imag": ["0.108", "0.132"]})
    ends = [
        judged(PAPER, {"shape": "ellipse", "real": a, "imag": b}) for a, b in (("0.09", "0.108"), ("0.11", "0.132"))
    ]
    assert [x.digits(20) for x in (found.bandwidths.least, found.bandwidths.most)] == [
        x.bandwidth.digits(20) for x in ends
    ]
    said = " ".join(str(found).split())
    assert "Which of the values between are is not told." in said
    told = json.loads(found.to_json())["bandwidths"]
    assert (told["ends_alone"], told["jumps"]) == (True, [])


@pytest.mark.parametrize(
    ("jnd", "words"),
    [
        ({"shape": "ellipse", "real": ["0.09", "0.11"], "imag": 0.1, "tilt": 0.5}, "need not hold"),
        ({**DIAMOND, "scale": 1.2}, "scale: must be a range"),
        ({**DIAMOND, "scale": [-1, 1]}, "must be > 0"),
        ({"real": ["0.1", "0.2"], "imag": 0.1, "scale": [1, 2]}, "no other number of the JND has one"),
        ({"real": 0.1, "imag": 0.1, "floor": ["0 N/m", "5 N/m"]}, "floor: .* must be > 0"),
        ({"real": 0.1, "imag": 0.1, "floor": ["1 N/m", "5 kg"]}, "floor: "),
        ({"real": {"higher": 0.1, "lower": [0.2, 0.1]}, "imag": 0.1}, "real: lower: "),
    ],
    ids=str,
)
def test_what_is_no_range_of_a_region_is_said_in_a_sentence(jnd: Any, words: str) -> None:
    with pytest.raises(hs.SceneError, match=words):
        judged(PAPER, jnd)


def test_a_box_has_no_side_for_a_scale_or_a_floor() -> None:
    asked = hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, {**DIAMOND, "scale": [1, 2]})
    with pytest.raises(hs.SceneError, match="a range of scale, which is no side of a box"):
        hs.tolerances(asked)
    assert "scale of the JND" in asked.nominal_note
    assert asked.aside_keys()["nominal"] == {"evaluation.jnd.scale": [1.0, 2.0]}


def test_the_page_says_what_moves_and_in_its_unit() -> None:
    def said(jnd: Any) -> str:
        return " ".join(str(judged(PAPER, jnd)).split())

    assert re.search(
        r"For a JND from 0.5 to 2 times as large the bandwidth .* but those from 6.4776 to below 7.5976 rad/s \(at a scale of 0.98970?\)",
        said({**DIAMOND, "scale": ["0.5", "2"]}),
    )
    assert "and a floor from 5 to 15 N/m the bandwidth" in said(
        {"real": ["0.09", "0.11"], "imag": 0.1, "floor": ["5 N/m", "15 N/m"]}
    )
    assert "from 7 % to 9 % (real part, where it grows)" in said(
        {"real": {"higher": ["0.07", "0.09"], "lower": 0.1}, "imag": 0.1}
    )


def test_a_scale_is_drawn_with_its_jump_and_what_moves_apart_is_not() -> None:
    [line] = draw_bandwidths(Figure().add_subplot(), judged(PAPER, {**DIAMOND, "scale": ["0.5", "2"]}))
    scale, omega = np.array(line.get_data())
    assert (scale[0], scale[-1]) == (0.5, 2)
    for i in np.flatnonzero(np.isfinite(omega))[::40]:
        width_ = judged(PAPER, times(DIAMOND, Fraction(float(scale[i])))).bandwidth
        assert float(width_) == pytest.approx(omega[i], rel=1e-6) or abs(scale[i] - 0.9897) < 1e-3
    gap = int(np.flatnonzero(np.isnan(omega))[0])
    assert [round(float(x), 4) for x in (omega[gap - 1], omega[gap + 1])] == [6.4776, 7.5976]
    with pytest.raises(hs.HaptisymError, match="no one number with a range"):
        draw_bandwidths(
            Figure().add_subplot(), judged(PAPER, {"shape": "diamond", "real": ["0.09", "0.11"], "imag": 0.1})
        )


def felt_by_a_quarter_more(order: str, more: str) -> hs.Evaluation:
    """Of a spring-pot, at 0 rad/s, where its powers of s leave 0/0."""
    felt = hs.environments.expression(f"100*s^({order}) + {more}")
    jnd = {"shape": "ellipse", "real": 0.05, "imag": 0.05, "scale": ["1/2", "90"]}
    return hs.evaluate(hs.Scene(hs.environments.spring_pot(80, order), (), (0, 60), jnd, rendered=felt))


@pytest.mark.parametrize(("order", "more"), [("1/2", "2*s"), ("1/3", "2*s^(2/3)")])
def test_a_scale_that_is_needed_where_powers_of_s_leave_0_over_0_is_that_of_the_limit(order: str, more: str) -> None:
    """Five times a disc of a twentieth."""
    e = felt_by_a_quarter_more(order, more)
    assert e.bandwidths.certified
    assert [float(x) for x in (e.bandwidths.most, *e.bandwidths.blocked.values())] == [60, 5]
    assert json.dumps(e.to_dict())


def test_a_scale_that_balls_cannot_tell_stays_open_and_is_said_to(monkeypatch: pytest.MonkeyPatch) -> None:
    class Unknown(hs.RealNumber):
        def __init__(self, *_: Any) -> None: ...

        def ball(self, bits: int) -> Any:
            return arb("nan")

    monkeypatch.setattr("haptisym.judge.growth.ValueAt", Unknown)
    monkeypatch.setattr("haptisym.kernel.reals.SURE_BITS", 1 << 10)
    e = felt_by_a_quarter_more("1/2", "2*s")
    assert e.bandwidths.least is None
    assert "64 bits of a number were not reached" in e.bandwidths.undecided
    assert "64 bits of a number were not reached" in json.dumps(e.to_dict())
