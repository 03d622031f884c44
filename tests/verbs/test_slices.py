"""Where the slices of a map go, and how far lines between them are off: an estimate, held against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from sympy import Expr, Rational

import haptisym as hs
from haptisym.cli import app
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import SceneError
from haptisym.verbs.require.asking import Asked
from haptisym.verbs.require.feasible import End, Kind, Span
from haptisym.verbs.require.placing import even, refined
from haptisym.verbs.require.slices import _End, gaps

PLANE, RANGES = ["omega_c", "evaluation.jnd"], [(20, 300), ("0.01", "0.6")]


def lag() -> hs.Scene:
    """Behind a lag the imaginary part is W omega_c/(W^2 + omega_c^2) at the end W = 15 of the band, and the real part is less."""
    return hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(50),), (0, 15))


def least(omega_c: np.ndarray) -> np.ndarray:
    return 15 * omega_c / (225 + omega_c**2)


def test_slices_go_where_the_boundary_bends() -> None:
    found = hs.design_map(lag(), PLANE, RANGES)
    steps = [x.high - x.low for x in found.gaps]
    assert len(found.slices) < 20
    assert steps[0] < steps[-1] / 3  # it bends below 60 rad/s
    for x in found.slices:
        assert float(x.requirement.feasible[0].low.value) == pytest.approx(least(x.place), rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("within", ["0.02", "0.5 %", "0.002"])
def test_lines_are_off_by_about_what_is_estimated(within: str) -> None:
    found = hs.design_map(lag(), PLANE, RANGES, within=within)
    for (a, b), gap in zip(pairwise(found.slices), found.gaps, strict=True):
        at = np.linspace(a.place, b.place, 101)
        off = np.abs(np.interp(at, [a.place, b.place], least(np.array([a.place, b.place]))) - least(at)).max()
        assert gap.deviation is not None
        assert off <= 1.1 * gap.deviation
    assert found.deviation is not None
    assert found.within is not None
    assert found.deviation <= float(found.within) * found.height
    assert not found.is_coarse


def test_too_few_slices_are_said_to_be_too_few() -> None:
    found = hs.design_map(lag(), PLANE, RANGES, slices=5)
    assert (len(found.slices), found.is_coarse) == (5, True)
    assert (
        "as estimated from how its boundary bends at the slices; that is not proven. --slices N gives more"
        in " ".join(str(found).split())
    )


@pytest.mark.slow
@pytest.mark.parametrize("span", [("0.2", "0.5"), ("0.01", "0.6")])
def test_slices_are_too_few_where_lines_may_be_off_by_more_than_the_share_of_the_range_between_its_ends(
    span: tuple[str, str],
) -> None:
    """Not of its high end."""
    coarse = set()
    for within in ("0.01", "0.05", "0.07", "0.12", "0.3"):
        found = hs.design_map(lag(), PLANE, [(20, 100), span], slices=5, within=within)
        assert found.deviation is not None
        assert found.is_coarse is (found.deviation > float(within) * (float(span[1]) - float(span[0])))
        coarse.add(found.is_coarse)
    assert coarse == {False, True}


def test_even_slices_are_as_many_as_are_asked_for() -> None:
    found = hs.design_map(lag(), PLANE, RANGES, slices=8, uniform=True)
    assert [x.at for x in found.slices] == [20 + Rational(280, 7) * i for i in range(8)]
    assert "bends at the slices; that is not proven. --slices N gives more" in " ".join(str(found).split())


def test_slices_that_differ_in_kind_are_near_each_other_and_nothing_is_said_between() -> None:
    """With c = 0.1 nothing will do below some omega_c, and from there on every k."""
    found = hs.design_map(lag(), ["omega_c", "environment.k"], [(20, 300), (10, 1000)])
    [gap] = [x for x in found.gaps if x.deviation is None]
    edge = 15 * (5 + np.sqrt(24))  # W omega_c/(W^2 + omega_c^2) = 1/10
    assert gap.low < edge < gap.high
    assert gap.high - gap.low <= 280 * 0.005
    assert "Between one pair of slices, which differ in kind" in " ".join(str(found).split())


def test_a_delay_that_is_noticed_whatever_the_stiffness_is_decided_beside_its_threshold() -> None:
    """A spring late by tau is noticed where sin(15 tau) > 1/10, whatever k: 1e-6 s beside that all of them are decided."""
    spring = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"),), (0, 15))
    for tau, count in (("6.677 ms", 1), ("6.679 ms", 0)):  # asin(0.1)/15 = 6.67781 ms
        found = hs.require(spring.with_values({"tau": tau}), "environment.k", (10, 1000))
        assert (len(found.feasible), found.undecided) == (count, ())


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"slices": 1}, "slices: 1 must be a whole number, at least 2"),
        ({"slices": 2.5}, "slices: 2.5 must be a whole number"),
        ({"within": 0}, "within: 0 must be > 0"),
        ({"within": "3 N"}, "3 N"),
    ],
)
def test_what_makes_no_sense_is_said(asked: dict[str, object], said: str) -> None:
    with pytest.raises(SceneError, match=said):
        hs.design_map(lag(), PLANE, RANGES, **asked)  # type: ignore[arg-type]


def test_the_command_line_takes_one_way_to_place_slices() -> None:
    plane = ["--free", "zeta", "--free", "omega_n", "--range", "0.4", "0.6", "--range", "50", "500"]
    said = CliRunner().invoke(app, ["require", "fu2019", *plane, "--uniform", "--within", "0.01"])
    assert "leave out one of them" in str(said.exception)
    said = CliRunner().invoke(app, ["require", "fu2019", "--free", "zeta", "--uniform"])
    assert "--uniform is about a map of two parameters" in str(said.exception)


# --- slices of sets whose boundaries are known ------------------------------------------------------------------------

BOUND = frozenset({("real", Kind.EDGE)})


def cut_at(at: Expr, *boundaries: Callable[[float], float | None]) -> Any:
    """A slice of one set: an interval from 0, where the range ends, to each boundary that there is; undecided where it is NaN."""
    values = [f(float(at)) for f in boundaries]
    if any(x is not None and np.isnan(x) for x in values):
        return SimpleNamespace(at=at, place=float(at), sets=(None,), ends=(None,))
    ends = [_End(0.0, frozenset()), *(_End(x, BOUND) for x in values if x is not None)]
    return SimpleNamespace(at=at, place=float(at), sets=(None,), ends=(tuple(ends),))


@pytest.mark.parametrize("seed", range(3))
def test_lines_between_points_of_a_parabola_are_off_by_just_what_is_estimated(seed: int) -> None:
    """c h^2/4 halfway, whichever way it bends and however the slices lie; of several boundaries the most."""
    pick = Random(seed)
    for _ in range(20):
        shapes = [(pick.uniform(-3, 3), pick.uniform(-2, 2)) for _ in range(pick.randint(1, 2))]
        boundaries = [lambda x, b=b, c=c: 50 + b * x + c * x**2 for b, c in shapes]
        places = sorted(Rational(pick.randint(0, 10**6), 10**5) for _ in range(pick.randint(3, 6)))
        if min(b - a for a, b in pairwise(places)) < Rational(1, 100):
            continue
        found = gaps([cut_at(x, *boundaries) for x in places])
        for gap, (a, b) in zip(found, pairwise(places), strict=True):
            assert (gap.low, gap.high) == (float(a), float(b))
            assert gap.deviation == pytest.approx(max(abs(c) for _, c in shapes) * float(b - a) ** 2 / 4, rel=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_of_the_parabolas_through_three_slices_the_one_that_bends_more_is_taken(seed: int) -> None:
    """Inside the map, of the two that meet between two slices; at its ends, as much more as the next one bends otherwise."""
    pick = Random(seed)
    for _ in range(10):
        places = np.cumsum([pick.uniform(0.5, 3) for _ in range(pick.randint(4, 7))])
        heights = {float(Rational(str(x))): pick.uniform(1, 9) for x in places}
        slices = [cut_at(Rational(str(x)), heights.__getitem__) for x in places]
        bends = [
            np.polyfit([x - places[i + 1] for x in places[i : i + 3]], [*heights.values()][i : i + 3], 2)[0]
            for i in range(len(places) - 2)
        ]
        for i, gap in enumerate(gaps(slices)):
            near = [bends[n] for n in (i - 1, i) if 0 <= n < len(bends)]
            bend = max(map(abs, near)) if len(near) == 2 else abs(near[0]) + abs(near[0] - bends[1 if i == 0 else -2])
            assert gap.deviation == pytest.approx(bend * (places[i + 1] - places[i]) ** 2 / 4)


def test_nothing_is_estimated_where_slices_differ_in_kind_or_are_open() -> None:
    def until(x: float) -> float | None:
        return 7 + x if x < 3 else None

    def open_from(x: float) -> float:
        return 7 + x if x < 3 else float("nan")

    for boundary in (until, open_from):
        found = gaps([cut_at(Rational(n), boundary) for n in range(5)])
        assert [x.deviation is None for x in found[:3]] == [False, False, True]
    assert [x.deviation for x in gaps([cut_at(Rational(n)) for n in range(4)])] == [0.0] * 3  # what ends is the range


@pytest.mark.parametrize("seed", range(3))
def test_slices_are_added_until_lines_are_near_enough_or_there_are_as_many_as_may_be(seed: int) -> None:
    """Halfway between two; where the boundary ends, or bends, and not where it is straight, or where slices are left open."""
    pick = Random(seed)
    for _ in range(10):
        corner, stop, from_here = (pick.uniform(2, 18) for _ in range(3))
        bend, height, share = pick.uniform(0.1, 3), pick.choice([10.0, 40.0]), pick.choice([0.02, 0.1])
        is_open = pick.random() < 0.4

        def boundary(
            x: float,
            corner: float = corner,
            stop: float = stop,
            bend: float = bend,
            here: float = from_here,
            *,
            nan: bool = is_open,
        ) -> float | None:
            if nan and x > here:
                return float("nan")
            return 9 + x + bend * max(x - corner, 0) ** 2 / 10 if x < stop else None

        most = pick.choice([12, 40, 400])
        start = [cut_at(x, boundary) for x in even(Rational(0), Rational(20), 9)]
        with limited() as budget:
            found = refined(start, lambda at, _, f=boundary: cut_at(at, f), budget, most, (20.0, height), share)
        places = [x.at for x in found]
        assert places == sorted(set(places))
        assert len(found) <= most
        assert set(places) >= {x.at for x in start}
        for x in set(places) - {y.at for y in start}:
            whole, wide = Rational(20), Rational(5, 2)
            assert any((x * 2**n / wide).is_integer for n in range(30))
            assert 0 < x < whole
        if len(found) < most:
            for gap, (a, b) in zip(gaps(found), pairwise(found), strict=True):
                if None in (*a.ends, *b.ends):
                    assert gap.high - gap.low >= 1.25  # another slice would be open too
                elif gap.deviation is None:
                    assert gap.high - gap.low <= 20 * share
                else:
                    assert gap.deviation <= height * share


# --- what a map says of all its sets --------------------------------------------------------------------------------------

HELD = hs.Scene(
    hs.environments.kelvin_voigt(300, 1),
    (hs.effects.first_order_lag(100), hs.effects.shunt(m="0.04 kg", b="0.8 N*s/m")),
    (0, 10),
    hands=(hs.Hand("own", m="0.1 kg", b="0.2 N*s/m"),),
)
"""With w for omega_c: stable iff (1 + 0.14 w)(1 + B) > 0.14 K, by Routh; the ratio at 10 rad/s is at most 10/w."""


def test_a_map_tells_each_of_its_sets_by_itself_and_all_together() -> None:
    paths, ranges = ["omega_c", "environment.b"], [(100, 400), (0, 4)]
    found = hs.design_map(
        HELD, paths, ranges, slices=3, uniform=True, that=["stable", "transparent"], jnd=["5 %", "0.05"]
    )  # type: ignore[arg-type]
    least = {w: max(0.0, 42 / (1 + 0.14 * w) - 1) for w in (100, 250, 400)}
    row = found.to_dict()
    assert [row[x] for x in ("unit", "range", "band", "criteria", "certified")] == [
        ["rad/s", "N*s/m"], [[100, 400], [0, 4]], [0, 10], ["transparent", "stable"], True,
    ]  # fmt: skip
    assert row["free"] == ["effects.first-order-lag.omega_c", "environment.b"]
    for w, x in zip(least, row["slices"], strict=True):
        assert x["at"] == w
        for name in ("feasible", "stable"):
            own = x["feasible"] if name == "feasible" else x["apart"][name]
            assert own == [[pytest.approx(least[w], rel=1e-15), 4]]
        assert x["apart"]["transparent"] == [[0, 4]]
        assert x["contours"] == [{"jnd": 0.05, "feasible": [] if w == 100 else [[0, 4]], "certified": True}]
        bound = [(y["at"], y["part"], y["criterion"], y["kind"]) for y in x["binding"]]
        assert bound == ([(pytest.approx(least[w]), None, "stable", "axis")] if least[w] else [])
    first, second = row["between"]
    assert [(x["from"], x["to"]) for x in row["between"]] == [(100, 250), (250, 400)]
    assert first["deviation"] is None  # one contour is empty on one side
    assert row["deviation"] == second["deviation"] == pytest.approx((least[100] - 2 * least[250]) / 2)
    assert [(x["of"], x["jnd"]) for x in row["proven"]] == [
        ("transparent", None),
        ("transparent", 0.05),
        ("stable", None),
    ]
    assert [(x.set, x.window) for x in found.proofs] == [(1, (0, 4)), (3, (0, 4)), (2, (0, 4))]
    noticed, contour, stable = row["proven"]
    assert (noticed["open"], noticed["between"]) == (0, [0, 0])
    assert contour["between"] == [None, 0]
    for x in row["proven"]:
        known = [y for y in x["between"] if y is not None]
        assert x["bound"] == max(known)
    for (a, b), bound in zip(((100, 250), (250, 400)), stable["between"], strict=True):
        at = np.linspace(a, b, 301)
        off = np.abs(np.interp(at, [a, b], [least[a], least[b]]) - np.maximum(0, 42 / (1 + 0.14 * at) - 1)).max()
        assert off - 4 / 512 <= bound < off + 0.1  # of what stays open at an end of the range it is told from there
    assert (found.height, found.thresholds, found.within, found.is_coarse, found.stiffest) == (
        4,
        (Rational(1, 20),),
        None,
        False,
        None,
    )
    for share, coarse in ((Rational(1, 10), True), (Rational(found.deviation) / 4, False)):
        assert replace(found, within=share).is_coarse is coarse
    assert replace(found, slices=found.slices[:1], within=Rational(1, 100)).is_coarse is False
    assert repr(found).endswith(": environment.b over effects.first-order-lag.omega_c, 3 slices>")
    assert found.lines == ()


def test_the_stiffest_wall_of_a_map_is_named_where_it_is_known_and_below_the_end_of_its_range() -> None:
    """K < (1 + 0.14 w)(1 + B)/0.14 at w = 100."""
    options = {"part": None, "any_environment": False}
    asked = Asked.of(HELD, ["environment.b", "environment.k"], [(0, 4), (10, 600)], options, ("stable",), ())
    cuts = tuple(map(asked.cut, (Rational(0), Rational(4))))
    found = hs.DesignMap(HELD, asked.free, asked.ranges, cuts, asked.criteria, asked.wanted)
    assert found.stiffest is not None
    at, top = found.stiffest
    assert (at.place, float(top)) == (4, pytest.approx(15 * 5 / 0.14, rel=1e-14))
    low, high = found.slices
    assert replace(found, slices=(low,)).stiffest == (low, low.requirement.feasible[0].high.value)
    [span] = high.requirement.feasible
    for other in (
        replace(high.requirement, undecided=((None, None),)),
        replace(high.requirement, feasible=(Span(span.low, End(span.high.value)),)),
    ):
        assert replace(found, slices=(low, replace(high, requirement=other))).stiffest is None
    none = replace(high, requirement=replace(high.requirement, feasible=()))
    assert replace(found, slices=(low, none)).stiffest[0] is low  # type: ignore[index]
    assert replace(found, slices=(none,)).stiffest is None
    assert replace(found, that=("transparent",)).stiffest is None
    assert replace(found, free=found.free[::-1]).stiffest is None
    both = replace(high, apart=(none.requirement, high.requirement))
    assert replace(found, that=("transparent", "stable"), slices=(both,)).stiffest == (both, top)


def test_curves_of_a_map_vanish_on_its_boundary() -> None:
    """Behind a lag W omega_c = c (W^2 + omega_c^2) at the end W = 15 of the band, and at omega = omega_c, where it is 1/2."""
    options = {"part": None, "any_environment": False}
    asked = Asked.of(lag(), PLANE, RANGES, options, ("transparent",), ())
    found = hs.DesignMap(asked.scene, asked.free, asked.ranges, (), asked.criteria)
    curves = {(x.name, kind): y for (x, kind), y in found.curves().items()}
    assert set(curves) == {(x, kind) for x in ("real", "imag") for kind in (Kind.START, Kind.EDGE, Kind.TOUCH)}
    wc, c = (x.symbol for x in found.free)
    for w, jnd in ((20, Rational(300, 625)), (35, Rational(525, 1450)), (300, Rational(4500, 90225))):
        assert curves["imag", Kind.EDGE].subs({wc: w, c: jnd}) == 0
        assert curves["imag", Kind.EDGE].subs({wc: w, c: jnd + 1}) != 0
    assert curves["imag", Kind.TOUCH].subs(c, Rational(1, 2)) == 0
    assert curves["imag", Kind.TOUCH].subs(c, Rational(1, 3)) != 0
