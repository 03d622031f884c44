"""Bandwidths of a region that grows, where what is judged stays the same for a while, as a floor makes it: against closed forms."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt
from typing import Any

import pytest
from sympy import Expr, Integer, Rational

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.judge.growth import Growth
from haptisym.judge.regions import Term
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega as w

FELT = hs.environments.mass_spring_damper(k=100, m=1)


def judged(jnd: Any, damper: str, band: tuple[Any, Any]) -> hs.Evaluation:
    """10 N/m and a damper are added: Re dH = 10 and Im dH = b omega, beside |H_env| = |100 - omega^2|."""
    rendered = hs.environments.mass_spring_damper(k=110, m=1, b=damper)
    return hs.evaluate(hs.Scene(FELT, (), band, jnd, rendered=rendered))


def limits(real: Any, floor: str, **more: Any) -> dict[str, Any]:
    """The imaginary part is noticed as soon as it exceeds the floor."""
    return {"real": real, "imag": "0.000001", "floor": f"{floor} N/m", **more}


def told(found: Any) -> list[Any]:
    jumps = [(float(x.low), float(x.high), float(x.threshold), x.includes_low) for x in found.jumps]
    return [float(found.least), float(found.most), jumps, {name: float(x) for name, x in found.blocked.items()}]


def near(x: Any) -> Any:
    return [
        pytest.approx(y, rel=1e-12) if not isinstance(y, list) else [pytest.approx(z, rel=1e-12) for z in y] for y in x
    ]


@pytest.mark.parametrize(("c", "floor"), [("1/5", "10"), ("1/5", "15"), ("1/20", "3"), ("1/6", "7")])
@pytest.mark.parametrize("damper", ["0", "1", "1/2", "1/3"])
def test_a_scale_at_which_a_floor_is_never_exceeded_jumps_over_all_that_it_judges(
    c: str, floor: str, damper: str
) -> None:
    """10/|100 - omega^2| > c t and 10 > f t: from where the first holds for t = 10/f on, to b omega = 10 or the end of the band."""
    limit, f, b = map(Fraction, (c, floor, damper))
    found = judged(limits(c, floor, scale=["1/1000", "20"]), damper, (0, 40)).bandwidths
    assert found is not None
    most = min(float(20 * f / b), 40) if b else 40
    start, top, landing = sqrt(100 - f / limit), 10 / f, float(10 / b) if b else 40
    jumps = [(start, landing, float(top), False)]
    assert found.certified
    assert told(found) == near([0, most, jumps, {"scale": float(1 / (10 * limit))}])
    asked = judged(limits(c, floor), damper, (0, 40))
    assert not hs.peaks(asked.scene)  # nowhere is there more than on both sides


@pytest.mark.parametrize("floor", ["10", "15", "7"])
def test_where_a_tighter_limit_takes_over_and_the_floor_holds_at_once_the_bandwidth_stands_until_it_is_passed(
    floor: str,
) -> None:
    """Re H_perc = -Re H_env at omega^2 = 105: before it grows, by 10 times the limit at the most, behind it shrinks."""
    jnd = limits({"higher": "10", "lower": "1/20"}, floor, scale=["1/100", "5"])
    found = judged(jnd, "0", ("10.1", 30)).bandwidths
    assert found is not None
    top = float(10 / Fraction(floor))
    start = float(1 / (Fraction("10.1") ** 2 - 100))
    assert found.certified
    assert told(found) == near([sqrt(105), 30, [(sqrt(105), 30, top, True)], {"scale": start}])


@pytest.mark.parametrize("floor", ["10", "15", "7"])
@pytest.mark.parametrize(("damper", "landing"), [("1", 10), ("0", 30), ("3", Fraction(10, 3))])
def test_a_floor_that_judges_from_the_low_end_of_the_band_on_is_passed_on_all_of_its_piece_by_the_least_scale(
    floor: str, damper: str, landing: Fraction
) -> None:
    found = judged(limits("1/100", floor, scale=["1/100", "100"]), damper, (0, 30)).bandwidths
    assert found is not None
    assert found.certified
    assert told(found) == near([float(landing), 30, [], {"scale": float(10 / Fraction(floor))}])


@pytest.mark.parametrize(
    ("low", "high", "least", "most", "jumps"),
    [
        ("1/100", "2/3", 0, 10, [(5, 10, 2 / 3, False)]),
        ("2/3", "5", 10, 12, []),
        ("1/100", "333/500", 0, sqrt(100 - 50 * 500 / 333), []),
    ],
)
def test_an_end_of_the_range_may_be_the_very_height_of_a_plateau(
    low: str, high: str, least: float, most: float, jumps: list[Any]
) -> None:
    """50/(100 - omega^2) up to 5 rad/s, 2/3 from there to 10, and omega/15 behind."""
    found = judged(limits("1/5", "15", scale=[low, high]), "1", (0, 12)).bandwidths
    assert found is not None
    assert found.certified
    assert told(found) == near([least, most, jumps, {} if least else {"scale": 0.5}])


@pytest.mark.parametrize(("higher", "lower", "least"), [("1", "3", "2/3"), ("3", "1", "2/3"), ("5", "5/2", "2/5")])
def test_of_a_part_that_is_turned_round_and_as_large_as_it_was_the_larger_limit_holds(
    higher: str, lower: str, least: str
) -> None:
    """A spring that pushes where it pulled: r_r = 2."""
    spring = hs.environments.mass_spring_damper(k=100)
    jnd = {"real": {"higher": higher, "lower": lower}, "imag": "1", "scale": ["1/3", "2"]}
    found = hs.evaluate(hs.Scene(spring, (hs.effects.series("-1"),), (0, 30), jnd)).bandwidths
    assert found is not None
    assert found.certified
    assert told(found) == near([30, 30, [], {"scale": float(Fraction(least))}])


# Steps behind what is not passed


def real(x: Expr) -> RealFunction:
    return RealFunction(Ring().axis.convert(x.together()).reduced())


@pytest.mark.parametrize("behind", [w * 0 + Rational(9, 4), 81 / (4 * w**2), w**2 / 4], ids=str)
@pytest.mark.parametrize(
    ("low", "high", "most"), [("6/5", "2", 2), ("3/2", "2", 2), ("6/5", "3/2", Rational(3, 2)), ("1", "5", 9), ("6/5", "6", 9)]
)  # fmt: skip
def test_a_step_behind_a_peak_that_is_higher_than_the_range_is_no_jump(
    behind: Expr, low: str, high: str, most: Expr
) -> None:
    """5/(1 + 4 (omega - 1)^2) is as much as c where (omega - 1)^2 = (5/c - 1)/4; from 3 rad/s on the other limit holds, at 3/2."""
    hill = real((5 / (1 + 4 * (w - 1) ** 2)) ** 2)
    terms = Term((), (hill,)), Term((real(w - 3),), (real(behind),))
    ends = Rational(low), Rational(high)
    found = Growth(terms, ends, (Integer(0), Integer(9)), noticed(hs.Threshold())[0], "scale", Integer(1)).found

    def before(c: Expr) -> float:
        return 1 - sqrt((5 / float(c) - 1) / 4)

    assert found.blocked == {}
    assert float(found.least or 0) == pytest.approx(before(ends[0]), abs=1e-12)
    if most != 9:
        assert float(found.most or 0) == pytest.approx(before(most))
        assert found.jumps == ()
    else:
        assert [float(x.low) for x in found.jumps] == [1.0]
        assert float(found.most or 0) == 9
