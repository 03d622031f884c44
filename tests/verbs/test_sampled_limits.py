"""How far a number of a display with a clock may go: against roots that were placed, eigenvalues, and single counts."""

from __future__ import annotations

import cmath
import math
import random
from fractions import Fraction
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from refusals import refusal
from sampledloops import NOTHING, Wall, placed, w, wall
from scipy.linalg import expm
from sympy import Expr, Integer, Poly, Rational, Symbol, pi, sqrt

import haptisym as hs
from haptisym.judge.bindings import stable_in
from haptisym.judge.colgate import sampled_passivity
from haptisym.kernel.budget import limited, timed_by
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.sampledloop import Plant, SampledLoop
from haptisym.kernel.sets import SingleValue, ValueSet, solve
from haptisym.model.valueranges import domain
from haptisym.verbs.stability.criticaldelays import CriticalDelays
from haptisym.verbs.stability.held import held
from haptisym.verbs.stability.opened import Opened, Passage
from haptisym.verbs.stability.sampled import clocked_question, is_held
from haptisym_check import RefusedError, check

E, F = hs.environments, hs.effects
k = Symbol("k")
VALUES = [sign * mantissa * 10.0**n for n in range(-3, 13) for mantissa in (1, 3.3) for sign in (1, -1)]


def nearest(scene: hs.Scene, path: str) -> ValueSet:
    """Of the scene's own hand, as ``stability`` asks."""
    free, hand = scene.knobs[path], scene.hands[0]
    asked = domain(free, None)
    return solve(clocked_question(scene, hand, free, asked, stable_in(hand), near=True), asked, near=True)


def limits(scene: hs.Scene, path: str) -> list[tuple[SingleValue, str]]:
    """The ends of what is stable, each with the side on which it is."""
    return [
        (x, side) for y in nearest(scene, path).feasible for x, side in ((y.first, "above"), (y.last, "below"))
        if x is not None and x.bindings
    ]  # fmt: skip


def told_up_to(found: ValueSet, value: Any) -> tuple[float, float]:
    """From where to where about a value nothing is undecided."""
    low, high = -np.inf, np.inf
    for x in found.undecided:
        if x.high is not None and float(x.high) <= value:
            low = max(low, float(x.high))
        elif x.low is not None:
            high = min(high, float(x.low))
    return low, high


def counted(scene: hs.Scene, path: str, value: Any) -> int | None:
    moved = scene.with_values({path: Rational(value)})
    return held(moved, moved.hands[0]).unstable


def spans(pairs: Any) -> list[tuple[float, float]]:
    return [(-np.inf if a is None else float(a), np.inf if b is None else float(b)) for a, b in pairs]


def told(found: Any) -> Any:
    """Of a value, whether it lies in one of the intervals that were found; None where that was left open."""
    doubt, feasible = (spans((y.low, y.high) for y in x) for x in (found.undecided, found.feasible))

    def of(x: float) -> bool | None:
        return None if any(a <= x <= b for a, b in doubt) else any(a < x < b for a, b in feasible)

    return of


# --- roots that were placed -------------------------------------------------------------------------------------------


def angles(p: Any) -> list[Any]:
    return [0.0, np.pi, np.arccos(float(p) / 2)]


@pytest.mark.dear("0")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(16))
def test_the_nearest_critical_values_are_where_roots_were_put_on_the_circle(seed: int) -> None:
    """Roots z = k/x, -k/y and a pair of |z| = |k|/v: at 1, at -1 and beside, with roots that stay at 1 whatever k is: drift."""
    draw = random.Random(seed)
    x, y, v = places = [Rational(n, 8) for n in draw.sample(range(9, 40), 3)]
    p, stays = Rational(draw.randint(-7, 7), 8), draw.choice([0, 0, 1])
    C = (1 - k / x * w) * (1 + k / y * w) * (1 - p * w + (k / v) ** 2 * w**2) * (1 - w) ** stays
    start = draw.choice([Rational(1), sorted(places)[0] + Rational(1, 20), sorted(places)[1] + Rational(1, 20)])
    # with a root that stays at 1 nothing is stable, but it may drift: what else there is counts
    hand, own = NOTHING, placed(C, {"k": str(start)})
    free = own.knobs["environment.k"]
    asked = domain(free, None)
    question = clocked_question(own, hand, free, asked, stable_in(hand, "steady" if stays else "stable"))
    found = solve(question, asked)
    least = min(places)
    i = places.index(least)
    [piece] = found.feasible
    for end, sign in ((piece.first, -1), (piece.last, 1)):
        angle = angles(p)[i if sign > 0 or i == 2 else 1 - i]
        assert end is not None
        assert (float(end.value), float(end.bindings[0].omega)) == pytest.approx(
            (float(sign * least), angle), rel=1e-12, abs=1e-12
        )
    everywhere = {x.value.digits(12) for x in found.points if x.bindings}
    assert everywhere == {ExactNumber(sign * x).digits(12) for x in places for sign in (1, -1)}


def test_a_critical_value_and_its_frequency_are_told_to_any_digits() -> None:
    """|z|^2 = k^2/7 at an angle with the cosine 3/8: 7^(1/2), and arccos(3/8)/(1 s)."""
    C = 1 - Rational(3, 4) * w + k**2 / 7 * w**2
    found, _ = limits(placed(C, {"k": 1}), "environment.k")[-1]
    with mpmath.workdps(60):
        true = mpmath.sqrt(7), mpmath.acos(mpmath.mpf(3) / 8)
        assert [x.digits(50) for x in (found.value, found.bindings[0].omega)] == [
            mpmath.nstr(x, 50, strip_zeros=False) for x in true
        ]


def largest(C: Expr, value: float) -> float:
    """The size of the largest root by NumPy."""
    return float(abs(np.roots([float(c.subs(k, value)) for c in Poly(C, w).all_coeffs()[::-1]])).max())


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(12))
def test_all_values_are_told_for_which_roots_by_numpy_lie_inside(seed: int) -> None:
    """Roots that go in and out of the circle several times as k grows, for k of either sign."""
    draw = random.Random(seed)

    def some(most: int) -> Expr:
        return sum((Rational(draw.randint(-99, 99), 101 * 3**n) * k**n for n in range(most + 1)), Integer(0))

    C = 1 - some(1) * w + some(2) * w**2
    found = hs.require(placed(C, {"k": 1}), "environment.k", that="stable")
    is_in = told(found)
    for x in [*np.linspace(-9, 9, 121), *VALUES[::5]]:
        size = largest(C, x)
        if abs(size - 1) > 1e-6:
            assert is_in(x) in ((size < 1), None), x
    assert sum(is_in(x) is None for x in np.linspace(-9, 9, 121)) < 12


@pytest.mark.dear("-1-2", "-1-8")
@pytest.mark.parametrize("digits", [2, 8, pytest.param(17, marks=pytest.mark.slow)])
@pytest.mark.parametrize("sign", [1, -1])
def test_two_changes_that_are_close_to_each_other_are_never_passed_by(sign: int, digits: int) -> None:
    """z = 1 - a(k), a = 2 + e - c (k - 1)^2: outside for |k - 1| < (e/c)^(1/2) however narrow; with -e it only comes near."""
    e, c = Rational(1, 10**digits), Rational(2 + digits, 20)
    a = 2 + sign * e - c * (k - 1) ** 2
    near = nearest(placed(1 - (1 - a) * w, {"k": "1/2"}), "environment.k")
    first = 1 - float(e / c) ** 0.5 if sign > 0 else 1 + float((2 - e) / c) ** 0.5
    above = [float(x.value) for x in near.ends if float(x.value) > 0.5]
    assert above == pytest.approx([first], abs=1e-12) or (not above and told_up_to(near, 0.5)[1] <= first)


@pytest.mark.slow
@pytest.mark.few("pair-3")
@pytest.mark.parametrize("start", [3, "1/70"])
@pytest.mark.parametrize(
    "of", [lambda x: 1 - w / 2 + (1 - (k / x - 1) ** 2) * w**2, lambda x: (1 - k / x * w) * (1 + x / k * w)],
    ids=["pair", "two"],
)  # fmt: skip
def test_what_touches_the_circle_is_left_open_and_no_change(of: Any, start: Any) -> None:
    """A pair that comes and goes back, or one root that comes at 1 while another one goes at -1."""
    touch = Rational(start) * Rational(4, 3)
    near = nearest(placed(of(touch), {"k": str(start)}), "environment.k")
    assert all(float(x.value) < float(Rational(start)) for x in near.ends)
    assert 0 <= touch - told_up_to(near, float(Rational(start)))[1] < touch / 10**6


def test_a_change_at_0_is_none_on_the_way_up() -> None:
    """z = 1/(1 + k): on the circle at 0 alone, inside for all that is more."""
    near = nearest(placed(1 - w / (1 + k), {"k": "1/2"}), "environment.k")
    assert [float(x.value) for x in near.ends] == [0]
    assert told_up_to(near, 0.5)[1] > 500


def test_a_value_of_a_wall_is_found_far_away() -> None:
    """z = k/10^5: more than a thousand times as far as the number is from 0."""
    scene = placed(1 - k / 10**5 * w, {"k": 1})
    assert [(float(x.value), side) for x, side in limits(scene, "environment.k")] == [
        (-(10**5), "above"),
        (10**5, "below"),
    ]


def test_a_number_that_is_itself_a_limit_has_limits_on_both_sides() -> None:
    """z = k/3 is at 1 for k = 3, and at -1 for k = -3."""
    found = limits(placed(1 - k * w / 3, {"k": 3}), "environment.k")
    assert [(float(x.value), side) for x, side in found] == [(-3, "above"), (3, "below")]


@pytest.mark.parametrize("path", ["effects.series.g", "effects.shunt.b"])
def test_a_limit_that_is_0_is_told_as_such_to_any_digits(path: str) -> None:
    """What damps a spring and mass: g 2 s by backward differences, or the device alone. At 0 they swing with (k/m)^(1/2)."""
    factor, hold, spring_ = F.series("g", parameters={"g": "1"}), F.zero_order_hold("1 ms"), hs.Hand("spring", k=7)
    by_clock = E.kelvin_voigt(0, 2), (factor, hold, F.shunt(m=1, b=0))
    without = E.mass_spring_damper(k=0), (hold, F.shunt(m=1, b="1 N*s/m"))
    (low, side), *_ = limits(hs.Scene(*(by_clock if "series" in path else without), hands=(spring_,)), path)
    assert [low.value.digits(9), low.bindings[0].omega.digits(9), side] == ["0", "2.64575131", "above"]


def test_a_limit_next_to_0_keeps_its_digits() -> None:
    """z = 3 10^(-9) - 1 - 3 k: at -1 for k = 10^(-9), where the walk began in steps that go over 0."""
    C = 1 - (Rational(3, 10**9) - 1 - 3 * k) * w
    [below, above] = nearest(placed(C, {"k": "-1/9"}), "environment.k").ends
    assert (below.value.digits(12), above.value.digits(12)) == ("-0.666666665667", "1.00000000000E-9")


AIR = {"k": "0", "b": "0", "T": "0.001", "m": "0.1", "d": "0.3", "m_h": "0", "b_h": "1", "k_h": "0"}


@pytest.mark.slow
def test_from_free_air_a_wall_is_steady_up_to_where_eigenvalues_leave_the_circle() -> None:
    """Of nothing but a spring, which is not there now: at 0 the handle drifts, which is steady."""
    felt = E.mass_spring_damper(k=0)
    own = hs.Scene(felt, (F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="0.1", b="0.3")))
    own = own.with_hands(hs.Hand("hand", b=1))
    [(x, _)] = [y for y in limits(own, "environment.k") if float(y[0].value)]
    last, air = float(x.value), Wall(AIR)
    assert air.radius(k=last * (1 - 1e-9)) < 1 < air.radius(k=last * (1 + 1e-9))
    [steady] = hs.require(own, "environment.k", that="steady").feasible
    [stable] = hs.require(own, "environment.k", that="stable").feasible
    assert (steady.closed[0], stable.closed[0]) == (True, False)
    assert {float(y.low) for y in (steady, stable)} == {0}
    assert {float(y.high) for y in (steady, stable)} == {last}


def test_a_device_behind_a_clock_that_holds_no_force_is_as_passive_as_without() -> None:
    """A free mass, and what Colgate and Schenkel's condition does not speak of; a spring that is held makes either active."""
    loop, mass = F.sampled_loop("1 ms", "tustin"), F.shunt(m="0.2")
    for device in ((mass,), (mass, F.compliance(k=900, b=2))):
        scene = hs.Scene(E.mass_spring_damper(k=0), (loop, *device))
        assert hs.stability(scene).every_passive_hand.holds
        assert not hs.stability(scene.with_values({"environment.k": 1})).every_passive_hand.holds
    assert sampled_passivity(hs.Scene(E.mass_spring_damper(k=0), (loop, mass))).passive


# --- walls ------------------------------------------------------------------------------------------------------------

P3 = hs.Hand("P3", b=8, k=400)
SUN = hs.Hand("Sun", "0.8", "5.5", "30")


def spring(K: Any, B: Any = 0, hand: hs.Hand = NOTHING, T: Any = "1 ms", m: str = "0.04", b: str = "0.8") -> hs.Scene:
    felt = E.kelvin_voigt(K, B) if B else E.mass_spring_damper(k=K)
    return hs.Scene(felt, (F.sampled_loop(T, "backward-difference"), F.shunt(m=m, b=b)), hands=(hand,))


@pytest.mark.dear("18284.7872144337-keys1")
@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("K", "keys"),
    [
        (1605.35113477512, {}), (18284.7872144337, {"hand": P3}), (2384.3034697805, {"B": "0.4"}),
        (18273.4389482611, {"hand": SUN, "m": "0.032", "b": "3.62"}),
    ],
)  # fmt: skip
def test_the_stiffest_published_wall_is_found_from_a_softer_one(K: float, keys: dict[str, Any]) -> None:
    """Down to none at all, which lets a handle go that nothing holds."""
    *below, (x, side) = limits(spring(round(K / 3), **keys), "environment.k")
    assert (float(x.value), side) == (pytest.approx(K, rel=1e-14), "below")
    assert 0 < float(x.bindings[0].omega) < 3141
    expected = [] if "hand" in keys else [(0, 0, "above")]
    assert [(float(y.value), float(y.bindings[0].omega), side) for y, side in below] == expected


def test_of_a_damper_that_leaves_its_place_free_the_other_roots_are_told() -> None:
    """One root is at 1 for every b; the others by NumPy as in z^2 (z - p) + (z - 1) b/T G(z), on the circle at the value told."""
    loop = F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="0.01", b="0.3")
    scene = hs.Scene(E.mass_spring_damper(b=3), loop)
    [x] = hs.require(scene, "environment.b", that="steady", hand=NOTHING).ends
    T, p = 1e-3, np.exp(-0.03)
    held_input = np.array([T / 0.3 - (1 - p) / 9, (1 - p) / 9 - T * p / 0.3])
    roots = np.roots(np.polyadd([1, -p, 0], float(x.value) / T * held_input))
    assert max(abs(roots)) == pytest.approx(1, abs=1e-13)
    assert float(x.bindings[0].omega) * T == pytest.approx(abs(np.angle(roots[np.argmax(abs(roots))])), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "path", "counts"),
    [
        (spring(20000, hand=P3), "hand.b", (2, 0)), (spring(300, T="4 ms"), "effects.sampled-loop.T", (0, 2)),
    ],
)  # fmt: skip
def test_at_a_critical_value_the_count_changes(scene: hs.Scene, path: str, counts: tuple[int, int]) -> None:
    [(x, _)] = limits(scene, path)
    value = Rational(x.value.digits(30))
    assert tuple(counted(scene, path, value * (1 + sign * Rational(1, 10**14))) for sign in (-1, 1)) == counts


@pytest.mark.slow
def test_a_number_given_in_hertz_may_go_as_far_as_one_in_radians() -> None:
    """50 Hz are 100 pi rad/s, no rational number."""

    def told(corner: str) -> list[Any]:
        felt = E.expression("k + b*s*w/(s + w)", parameters={"k": 300, "b": 3, "w": corner})
        chain = F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="45 g")
        return [
            (x.value.digits(15), side) for x, side in limits(hs.Scene(felt, chain, hands=(NOTHING,)), "environment.w")
        ]

    assert told("50 Hz") == told("314 rad/s")
    assert len(told("50 Hz")) == 1


@pytest.mark.dear("4-b")
@pytest.mark.few("4-b", "2-k")
@pytest.mark.parametrize("free", ["k", "b"])
@pytest.mark.parametrize("seed", range(10))
def test_stiffness_and_damping_of_a_wall_are_told_for_all_values_of_either_sign(seed: int, free: str) -> None:
    own = wall(random.Random(seed), plain=True)
    found = hs.require(own.scene, f"environment.{free}", that="stable")
    is_in = told(found)
    assert (found.certified, found.undecided) == (True, ())
    for x in VALUES:
        radius = own.radius(**{free: x})
        if abs(radius - 1) > 1e-6:  # of eigenvalues in floats
            assert is_in(x) == (radius < 1), x


ADDING = {"hand.b": "b_h", "hand.m": "m_h", "hand.k": "k_h", "effects.shunt.b": "d"}


@pytest.mark.few("hand.b-1")
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("path", ADDING)
def test_what_damps_enough_holds_for_all_that_is_more(path: str, seed: int) -> None:
    """Colgate and Schenkel's condition, a little more than it asks."""
    own = wall(random.Random(seed), plain=True)
    sampled = sampled_passivity(own.scene)
    assert sampled is not None
    assert sampled.hand_needed is not None
    damping = float(sampled.hand_needed) * 1.01 + 0.01
    scene = own.scene.with_values({"hand.b": repr(damping)})
    found = hs.require(scene, path, that="stable")
    is_in = told(found)
    own.numbers["b_h"] = repr(damping)  # type: ignore[index]
    for x in VALUES[::2]:
        radius, stable = own.radius(**{ADDING[path]: x}), is_in(x)
        assert stable is not None or x < float(scene.knobs[path].value)
        if abs(radius - 1) > 1e-6 and stable is not None:
            assert stable == (radius < 1), x


ENOUGH = {"hand.b": "1.5", "effects.shunt.b": "-2.2", "hand.m": None, "hand.k": None, "effects.shunt.m": None}
"""From which value on a number damps enough; None of one that does not damp."""


@pytest.mark.parametrize("path", [*ENOUGH, "environment.k", "environment.b", "effects.sampled-loop.T"])
def test_a_hand_that_damps_enough_holds_whatever_else_adds_to_it(path: str) -> None:
    """900 N/m every 4 ms ask 1.8 N s/m, of which the device has 0.3: not 1.5 of the hand, but all that is more."""
    for b, enough in (("1.5", False), ("1.500001", True)):
        hand = hs.Hand("hand", m="0.2", b=b, k=200)
        scene = spring(900, "0.000000001" if path == "environment.b" else 0, hand, "4 ms", "0.05", "0.3")
        if path not in ENOUGH or ENOUGH[path] is None:
            assert is_held(scene, hand, scene.knobs[path], Rational(1, 10**6)) is (enough and path in ENOUGH)
    least = Rational(ENOUGH.get(path) or 0)
    for off in (Rational(-1, 10**9), Integer(0), Rational(1, 10**9)) if ENOUGH.get(path) else ():
        hand = hs.Hand("hand", m="0.2", b=4, k=200)
        assert is_held(scene.with_hands(hand), hand, scene.knobs[path], least + off) is bool(off > 0)


@pytest.mark.parametrize(
    ("device", "path"),
    [
        ({"Z": "(2 - c)*s + m*s^2", "parameters": {"c": "0.1", "m": "0.05"}}, "effects.shunt.c"),
        ({"m": "0.05", "b": "0.3"}, "effects.compliance.k"),
    ],
)  # fmt: skip
def test_it_does_not_where_the_number_takes_away_or_something_yields(device: dict[str, Any], path: str) -> None:
    hand = hs.Hand("hand", m="0.2", b=4, k=200)
    drive = (F.compliance(k=800),) if "compliance" in path else ()
    chain = F.sampled_loop("4 ms", "backward-difference"), F.shunt(**device), *drive
    scene = hs.Scene(E.mass_spring_damper(k=900), chain, hands=(hand,))
    assert not is_held(scene, hand, scene.knobs[path], Rational(1, 2))
    assert is_held(scene, hand, scene.knobs["effects.shunt.m"], Rational(1, 2)) is not bool(drive)


@pytest.mark.slow
@pytest.mark.core
def test_every_number_of_a_sampled_wall_is_told_where_eigenvalues_leave_the_circle() -> None:
    """None is asked about; what moves, exactly sampled by SciPy, with the samples that the backward difference keeps."""
    given = {"k": 400.0, "b": 0.4, "T": 1e-3, "m": 0.05, "d": 0.8}
    paths = {
        "environment.k": "k", "environment.b": "b", "effects.loop.T": "T", "effects.device.b": "d", "effects.device.m": "m",
    }  # fmt: skip

    def radius(**moved: float) -> float:
        n = given | moved
        M, B = n["m"] + 0.1, n["d"] + 0.1  # with the hand
        both = expm(np.array([[0, 1, 0], [0, -B / M, 1 / M], [0, 0, 0]]) * n["T"])
        step = np.zeros((4, 4))  # position, velocity, the last two samples
        step[:2, :2] = both[:2, :2]
        step[:2, 2] -= both[:2, 2] * (n["k"] + n["b"] / n["T"])
        step[:2, 3] += both[:2, 2] * n["b"] / n["T"]
        step[2, 0] = step[3, 2] = 1
        return float(max(abs(np.linalg.eigvals(step))))

    scene = hs.load_scene("virtual-wall")
    given |= {"m": float(scene.knobs["effects.device.m"].value), "d": float(scene.knobs["effects.device.b"].value)}
    assert radius() < 1
    [row] = hs.stability(scene, "light-touch").to_dict()["held"]
    told = [(x["path"], x["value"], x["stable_side"]) for x in row["critical"] if x["value"] > 0]
    assert {x for x, _, _ in told} == {*paths} - {"effects.device.m"}
    for path, value, side in told:
        for sign in (1, -1):
            assert (radius(**{paths[path]: value * (1 + sign * 1e-6)}) < 1) == ((sign > 0) == (side == "above")), path
        between = np.linspace(given[paths[path]], value, 40)[:-1]
        assert all(radius(**{paths[path]: float(x)}) < 1 for x in between), path


@pytest.mark.slow
def test_where_a_number_has_no_end_on_a_side_nothing_is_said_to_be_left() -> None:
    hand = hs.Hand("hand", m="0.2", b="1.6", k=200)
    scene = spring(900, hand=hand, T="4 ms", m="0.05", b="0.3")
    [row] = hs.stability(scene, free=["effects.shunt.b", "environment.k"]).to_dict()["held"]
    assert "undecided" not in row
    assert [(x["path"], x["stable_side"]) for x in row["critical"]] == [
        ("hand.b", "above"), ("effects.shunt.b", "above"), ("environment.k", "below"),
    ]  # fmt: skip


@pytest.mark.slow
def test_beyond_what_was_looked_at_nothing_is_said() -> None:
    given = {"environment.k": 18000.0, "effects.sampled-loop.T": 1e-3, "effects.shunt.m": 0.04, "effects.shunt.b": 0.8}
    given |= {"hand.m": 0.0, "hand.b": 8.0}

    def radius(**moved: float) -> float:
        n = given | moved
        M, B, T = n["effects.shunt.m"] + n["hand.m"], n["effects.shunt.b"] + n["hand.b"], n["effects.sampled-loop.T"]
        step = expm(np.array([[0, 1, 0], [-400 / M, -B / M, 1 / M], [0, 0, 0]]) * T)
        step = step @ np.array([[1, 0, 0], [0, 1, 0], [-n["environment.k"], 0, 0]])
        return float(max(abs(np.linalg.eigvals(step))))

    found = hs.stability(spring(18000, hand=P3))  # 9 is more than 8.8
    [row] = found.to_dict()["held"]
    assert radius() < 1
    assert {x["path"] for x in row["critical"]} == {*given}
    for path, value, side in ((x["path"], x["value"], x["stable_side"]) for x in row["critical"] if x["value"] > 0):
        assert [radius(**{path: value * off}) < 1 for off in (1 - 1e-6, 1 + 1e-6)] == [side == "below", side == "above"]
    looked = {x["path"]: (x["from"], x["to"]) for x in row["looked_at"]}
    assert (looked["hand.k"][0], looked["hand.b"][1]) == (None, None)
    assert looked["hand.k"][1] >= 500 * 400


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(6))
def test_with_tustins_rule_a_spring_beside_a_damper_is_told_for_all_values(seed: int) -> None:
    """The controller has a pole at z = -1, where the damper alone is felt, however stiff the spring is."""
    draw = random.Random(seed)
    hand = hs.Hand("hand", m="0.2", b=4, k=200)
    chain = F.sampled_loop(draw.choice(["1 ms", "7 ms"]), "tustin", draw.choice([0, 1])), F.shunt(m="0.2", b="0.3")
    scene = hs.Scene(E.kelvin_voigt(draw.choice([20, 900]), draw.choice(["0.4", "3"])), chain, hands=(hand,))
    found = hs.require(scene, "environment.k", that="stable")
    is_in = told(found)
    assert found.certified
    for x in VALUES[::4]:
        if x > 0:
            assert (counted(scene, "environment.k", x) == 0) is is_in(x), x


@pytest.mark.slow
@pytest.mark.parametrize(("T", "late"), [("1 ms", 0), pytest.param("4 ms", 1, marks=pytest.mark.slow)])
def test_the_corner_of_a_filter_is_told_for_all_values_and_at_0_by_what_is_left_there(T: str, late: int) -> None:
    """At a corner of 0 the filter passes nothing, and the spring alone is held; below it its own pole grows, unless T jumps over it."""
    felt = E.expression("k + b*s*w/(s + w)", parameters={"k": 300, "b": 3, "w": 400})
    hand = hs.Hand("hand", m="0.1", b=5, k=100)
    chain = F.sampled_loop(T, "backward-difference", late), F.shunt(m="0.2", b="0.3")
    scene = hs.Scene(felt, chain, hands=(hand,))
    found = hs.require(scene, "environment.w", that="stable")
    is_in = told(found)
    assert found.certified
    for x in VALUES[::3]:
        assert (counted(scene, "environment.w", x) == 0) is is_in(x)
    assert counted(scene, "environment.w", 0) == 0
    assert [(float(x.low), x.closed[0]) for x in found.feasible if x.low is not None] == [(0, True)]


def test_down_to_0_a_wall_in_a_clock_is_told_as_its_roots_are_counted() -> None:
    """In a hand with stiffness no root comes to 1 as the wall gets softer, down to none at all."""
    hand = hs.Hand("hand", m="0.1 kg", b=2, k=50)
    found = hs.require("virtual-wall", "environment.k", that="stable", hand=hand)
    [span] = [x for x in found.feasible if float(x.high or 0) > 1]
    assert (float(span.low), span.closed[0]) == (0, True)
    scene = hs.load_scene("virtual-wall").with_hands(hand)
    assert [counted(scene, "environment.k", x) for x in (0, 10**-9, 0.3, 5)] == [0] * 4


@pytest.mark.slow
@pytest.mark.parametrize("path", ["environment.b", "hand.k"])
def test_by_tustins_rule_a_fast_wall_is_told_as_roots_are_counted(path: str) -> None:
    """It has a pole at z = -1, and a fast clock a root beside it: both nearly cancel. At eight values each roots are counted."""
    chain = F.sampled_loop("0.5 ms", "tustin", 1), F.shunt(m="0.3", b="0.2")
    scene = hs.Scene(E.kelvin_voigt(300, 4), chain, hands=(hs.Hand("hand", "0.5", "0.7", "40"),))
    found, own = hs.require(scene, path, that="stable"), Rational(scene.knobs[path].value)
    is_in = told(found)
    assert not any(a < 50 * own and b > own / 100 for a, b in spans((x.low, x.high) for x in found.undecided))
    for n in range(8):
        value = own * Rational(3) ** n / 81
        assert is_in(float(value)) in ((counted(scene, path, value) == 0), None), value


KNOB = hs.parse_scene("""
environment = {model = "mass-spring-damper", m = "0.0002 kg*m^2", b = "0.002 N*m*s/rad", k = "0.4 N*m/rad"}
rendered = {model = "mass-spring-damper", b = "environment.b", k = "environment.k"}
hand = {m = "0.0005 kg*m^2", b = "0.004 N*m*s/rad", k = "0.3 N*m/rad"}
[[effects]]
model = "sampled-loop"
T = "0.5 ms"
method = "tustin"
delay = 1
[[effects]]
model = "shunt"
m = "0.0001 kg*m^2"
[[effects]]
name = "torsion-bar"
model = "compliance"
k = "50 N*m/rad"
""")
"""A resonance without damping between clock and hand."""


@pytest.mark.dear("effects.torsion-bar.k-known0")
@pytest.mark.few("effects.torsion-bar.k-known0", "hand.k-known2")
@pytest.mark.parametrize(("path", "known"), [("effects.torsion-bar.k", [356.501596]), ("hand.b", []), ("hand.k", [])])
def test_with_a_resonance_between_clock_and_hand_a_number_may_still_go_far(path: str, known: list[float]) -> None:
    """A knob on a torsion bar: where the number of roots changes, and at no other value that is tried."""
    near, start = nearest(KNOB, path), float(KNOB.knobs[path].value)
    changes = [float(x.value) for x in near.ends]
    assert changes == pytest.approx(known, rel=1e-8)
    told = told_up_to(near, start)
    low = max([x for x in changes if x < start], default=max(told[0], 0))
    high = min([x for x in changes if x > start], default=min(told[1], 50 * start))
    assert low < start / 10
    assert high > 2 * start
    draw, home = random.Random(path), counted(KNOB, path, start)
    for _ in range(4):
        assert counted(KNOB, path, low + (high - low) * draw.random()) == home
    for x in near.ends:
        assert {counted(KNOB, path, float(x.value) * (1 + side * 1e-6)) == 0 for side in (-1, 1)} == {True, False}


@pytest.mark.slow
def test_when_the_time_is_over_verdicts_are_there_and_the_rest_is_marked() -> None:
    """Verdicts come first, hand after hand; then limits, then margins. Nothing is told where not one of them is there."""
    own = spring(300, hand=SUN).with_hands(SUN, P3)
    whole, parts = hs.stability(own, limit=None), list[hs.Stability]()
    for seconds in (30, 100, 300, 2900):
        with timed_by(count().__next__):
            parts.append(hs.stability(own, limit=seconds))
    assert [[x.stable for x in y.held] for y in parts] == [[True, None], *[[True, True]] * 3]
    assert {y.imposed for y in parts} == {whole.imposed}

    def limits(found: hs.Stability) -> set[tuple[str, float]]:
        return {(path, float(x.value)) for sets in found.critical for path, y in sets.items() for x in y.ends}

    assert set() < limits(parts[-1]) <= limits(whole)
    left = parts[1].to_dict()["held"][1]["undecided"]
    assert {x["path"] for x in left} >= {"environment.k", "margins.gain", "margins.delay"}
    assert all("stopped at the limit" in x["reason"] for x in left)
    assert [x.settled for x in (whole, *parts)] == [True, False, False, False, False]
    with timed_by(count().__next__), pytest.raises(LimitError, match="stopped at the limit"):
        hs.stability(spring(301, hand=SUN), limit=3)


def test_when_the_time_is_over_a_number_is_known_as_far_as_it_was_followed() -> None:
    """On both sides in turn."""
    scene = placed(1 - k / 300 * w, {"k": 1})
    parts = []
    for seconds in (1, 15, 30, 3000):
        with timed_by(count().__next__), limited(seconds):
            parts.append(nearest(scene, "environment.k"))
    assert "stopped at the limit" in parts[0].reason
    assert parts[0].feasible == ()
    for part in parts[1:]:
        for x in (-400, -299, 0.99, 299, 400):
            assert part.about(ExactNumber(Rational(x))).verdict in ("undecided", "holds" if abs(x) < 300 else "fails")
    known = [len(x.ends) for x in parts]
    assert known == sorted(known)
    assert known[-1] == 2


LOOP = """
[environment]
model = "mass-spring-damper"
b = "2 N*s/m"
k = "500 N/m"
{rendered}
[[effects]]
model = "sampled-loop"
T = "1 ms"
{clock}
[[effects]]
model = "shunt"
m = "0.1 kg"
b = "0.3 N*s/m"
{behind}
[hand]
m = "0.2 kg"
b = "3 N*s/m"
k = "100 N/m"
[evaluation]
band = ["0 Hz", "10 Hz"]
"""
RENDERED = """
[rendered]
model = "difference-equation"
D = "{D}"
parameters = {{ k = "{k} N/m", b = "{b} N*s/m", T0 = "1 ms", a = {a} }}
"""
FILTERED = "k + b/T0*(1 - a)*(1 - 1/z)/(1 - a/z)"


def scene(k: float = 500, b: float = 2, a: float = 0.9, delay: int = 1, D: str = FILTERED) -> hs.Scene:
    return hs.parse_scene(
        LOOP.format(rendered=RENDERED.format(D=D, k=k, b=b, a=a), clock=f"delay = {delay}", behind="")
    )


def eigenvalues(k: float, b: float, a: float, delay: int) -> Any:
    """Of the loop from sample to sample: x, v, the filtered velocity's state, and the forces that are still computed.

    F = k x + b w, w = a w- + (1 - a)(x - x-)/T: the state is x, v, x-, w-, and F of the last samples.
    """
    T, m, d, s = 1e-3, 0.3, 3.3, 100.0
    plant = np.array([[0, 1, 0], [-s / m, -d / m, -1 / m], [0, 0, 0]])
    step = expm(plant * T)[:2]  # of x and v with a force that is held, exact
    size = 4 + delay
    M = np.zeros((size, size))
    w = np.zeros(size)
    w[[0, 2, 3]] = (1 - a) / T, -(1 - a) / T, a
    force = b * w
    force[0] += k
    held = np.eye(size)[size - 1] if delay else force
    M[:2] = step[:, :1] * np.eye(size)[0] + step[:, 1:2] * np.eye(size)[1] + step[:, 2:3] * held
    M[2, 0] = 1
    M[3] = w
    for i in range(delay):
        M[4 + i] = force if i == 0 else np.eye(size)[3 + i]
    return np.linalg.eigvals(M)


@pytest.mark.parametrize(
    ("k", "b", "a", "delay"),
    [(500, 2, 0.9, 1), (2800, 2, 0.9, 1), (2815, 2, 0.9, 1), (500, 60, 0.5, 0), (500, 400, 0.5, 0), (900, 90, 0.3, 2), (50, 4, 0.99, 3)],
)  # fmt: skip
def test_the_poles_of_a_difference_equation_are_those_of_the_exactly_sampled_state_space(
    k: float, b: float, a: float, delay: int
) -> None:
    sizes = np.abs(eigenvalues(k, b, a, delay))
    assert np.abs(sizes - 1).min() > 1e-6
    asked = scene(k, b, a, delay)
    found = held(asked, asked.hands[0])
    assert found.unstable == (sizes >= 1).sum()
    assert found.stable is not bool((sizes >= 1).any())


@pytest.mark.slow
def test_limits_of_its_parameters_are_where_a_pole_is_on_the_circle() -> None:
    [held] = hs.stability(scene(), free=["rendered.k", "rendered.b"]).to_dict()["held"]
    found = {(x["path"], x["stable_side"]): x for x in held["critical"]}
    assert found["rendered.k", "above"]["value"] == pytest.approx(-100, rel=1e-12)  # against the hand's spring
    limits = [found["rendered.k", "below"], *(x for (path, _), x in found.items() if path == "rendered.b")]
    for limit in limits:
        values = {"k": 500.0, "b": 2.0, limit["path"].removeprefix("rendered."): limit["value"]}
        at = eigenvalues(values["k"], values["b"], 0.9, 1)
        nearest = at[np.argmin(np.abs(np.abs(at) - 1))]
        assert abs(nearest) == pytest.approx(1, abs=1e-9)
        assert abs(cmath.phase(nearest)) / 1e-3 == pytest.approx(limit["omega"], abs=1e-4)
    required = hs.require(scene(), "rendered.k", that=["stable"]).to_dict()
    assert required["feasible"] == [[pytest.approx(-100), pytest.approx(found["rendered.k", "below"]["value"])]]


def test_a_spring_and_damper_by_the_backward_difference_is_the_same_loop() -> None:
    text = LOOP.format(rendered="", clock='method = "backward-difference"\ndelay = 1', behind="")
    own, other = hs.parse_scene(text), scene(a=0, D="k + b*(1 - 1/z)/T0")
    one, two = ([(c.part, float(c.omega)) for c in hs.evaluate(x).crossings] for x in (own, other))
    assert one == two
    a, b = (hs.stability(x, limit=0.1).to_dict() for x in (own, other))
    assert (a["sampled"], a["imposed"]) == (b["sampled"], b["imposed"])


def test_simulated_sample_by_sample_it_agrees_with_its_closed_form_and_fades_as_its_largest_pole() -> None:
    run = hs.simulate(scene(), hs.sine("1 cm", 20))
    assert run.agrees
    largest = max(eigenvalues(500, 2, 0.9, 1), key=abs)
    let_go = hs.release(scene(), "1 cm").to_dict()
    assert str(let_go).count(f"{math.log(abs(largest)) / 1e-3:.4f}"[:6]) >= 1


def test_what_a_clock_felt_below_its_nyquist_frequency_is_the_equation_delayed_and_held() -> None:
    d = scene().distortion()
    for omega in (3.0, 40.0, 900.0):
        z, T = cmath.exp(1j * omega * 1e-3), 1e-3
        D = 500 + 2 / T * 0.1 * (1 - 1 / z) / (1 - 0.9 / z)
        expected = D / z * (1 - 1 / z) / (1j * omega * T) + 0.3j * omega - 0.1 * omega * omega
        assert complex(d.perceived.subs(hs.s, 1j * omega).evalf(30)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("rendered", "clock", "behind", "told"),
    [
        (RENDERED.format(D="k", k=1, b=1, a=0), 'method = "tustin"', "", "method: leave it out, as [rendered] is a difference-equation"),
        ("", "", "", "sampled-loop needs method"), (RENDERED.format(D="k*z", k=1, b=1, a=0), "", "", "D needs future samples"),
        (RENDERED.format(D="k*s", k=1, b=1, a=0), "", "", 'unknown name "s"'), (RENDERED.format(D="k*z^0.5", k=1, b=1, a=0), "", "", "rational in z"),
        (RENDERED.format(D="k", k=1, b=1, a=0), "", '[[effects]]\nmodel = "zero-order-hold"\nT = "2 ms"\n', "a second sampler: sampled-loop is the only one"),
    ],
)  # fmt: skip
def test_what_no_controller_computes_is_refused(rendered: str, clock: str, behind: str, told: str) -> None:
    assert told in refusal(hs.parse_scene, LOOP.format(rendered=rendered, clock=clock, behind=behind))


def test_it_stands_behind_a_clock_and_is_never_what_should_be_felt() -> None:
    D = hs.environments.difference_equation("1 - 1/z")
    assert "needs sampled-loop as the first effect" in refusal(hs.Scene, hs.environments.kelvin_voigt(1, 1), rendered=D)
    assert "is for [rendered]" in refusal(hs.Scene, D)


@pytest.mark.slow
def test_crossings_of_a_difference_equation_are_proven_again_by_the_second_checker(tmp_path: Path) -> None:
    for name, text in (("z", LOOP.format(rendered=RENDERED.format(D=FILTERED, k=500, b=2, a=0.9), clock="delay = 1", behind="")), ("late", LATE)):  # fmt: skip
        path = tmp_path / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        certificate = hs.evaluate(path).certificate()
        other = text.replace("a = 0.9", "a = 0.91").replace("60 1/s", "61 1/s")
        assert "crossings" in check(certificate.encode(), text.encode())
        forged = certificate.replace(*(sha256(x.encode()).hexdigest() for x in (text, other)))
        with pytest.raises(RefusedError, match="not that of the scene"):
            check(forged.encode(), other.encode())


# --- position loops that are late --------------------------------------------------------------------------------------

LATE = """
[environment]
model = "mass-spring-damper"
m = "6 kg"
b = "20 N*s/m"
k = "100 N/m"
[[effects]]
model = "admittance-display"
P = "w^2/(s^2 + 2*z*w*s + w^2)"
parameters = { w = "60 1/s", z = 0.8 }
tau = 0.005
[hand]
m = "0.5 kg"
b = "6 N*s/m"
k = "100 N/m"
[evaluation]
band = ["0 rad/s", "30 rad/s"]
"""


def turns(tau: float) -> int:
    """Zeros of H/P + (0.5 s^2 + 6 s + 100) exp(-s tau) in the right half plane: how often it goes around 0 on a large half circle."""
    corner = 3000.0
    up = 1j * np.concatenate([-np.geomspace(corner, 1e-3, 60000), np.geomspace(1e-3, corner, 60000)])
    arc = corner * np.exp(1j * np.linspace(np.pi / 2, -np.pi / 2, 20000))
    s = np.concatenate([up, arc])
    f = (6 * s**2 + 20 * s + 100) * (s**2 + 96 * s + 3600) / 3600 + (0.5 * s**2 + 6 * s + 100) * np.exp(-s * tau)
    return -round(float(np.diff(np.unwrap(np.angle(f))).sum() + np.angle(f[0] / f[-1])) / (2 * math.pi))


@pytest.mark.parametrize("tau", [0, 0.005, 0.3, 0.328, 0.331, 0.6])
def test_a_late_position_loop_has_as_many_unstable_poles_as_the_argument_principle_counts(tau: float) -> None:
    late = hs.parse_scene(LATE).with_values({"tau": tau})
    found = held(late, late.hands[0])
    assert found.unstable == turns(tau)
    assert found.stable is (tau < 0.33)


def test_its_crossings_are_those_of_exp_s_tau_over_p_and_its_delay_is_a_free_parameter() -> None:
    late = hs.parse_scene(LATE)
    for crossing in hs.evaluate(late).crossings:
        s = 1j * float(crossing.omega)
        ratio = (s * s + 96 * s + 3600) / 3600 * cmath.exp(s * 0.005) - 1
        h = 6 * s**2 + 20 * s + 100
        change = ratio * h / abs(h)
        assert abs(change.real if crossing.part is hs.Part.REAL else change.imag) == pytest.approx(0.1, rel=1e-9)
    [(low, high)] = hs.require(late, "tau", ("0 s", "1 s"), that=["stable"]).to_dict()["feasible"]
    assert (low, turns(high * 0.999), turns(high * 1.001)) == (0, 0, 2)
    assert hs.release(late, "5 cm").to_dict()["agrees"]
    assert "would precede a prescribed motion" in refusal(hs.simulate, late, hs.sine("1 cm", 5))


# --- an integrator, sampled at 1 s, with a gain and a delay tau = d + theta: z^(d + 1) (z - 1) + g ((1 - theta) z + theta) -----


def delayed_integrator(gain: Expr) -> Opened:
    one, tau = Integer(1), Symbol("tau", real=True)
    return Opened(SampledLoop(Plant((Integer(0), one), ((tau, (one,)),)), one, (gain,), (one,)), tau)


def test_beyond_the_delays_that_were_searched_no_delay_is_stable_without_a_count() -> None:
    """For a gain of 1/1000 a root is on the circle at (pi - omega)/(2 omega) = 1570 s, sin(omega/2) = 1/2000."""
    late = CriticalDelays.of(delayed_integrator(Rational(1, 1000)), Rational(1, 2), Fraction(100))
    assert late is not None
    assert [*late.advance_to(Fraction(100))] == []
    assert (late.passages, late.undecided, late.frontier) == ([], [], 100)
    assert [late.is_stable_at(Rational(x)) for x in (99, 100, 101, 2000)] == [True, True, None, None]


def test_a_root_that_crosses_after_whole_samples_is_one_in_both_pieces_and_in_two_searches() -> None:
    """z^3 - z^2 + 2 sin(18 deg) has a pair at angles of 36 deg: a delay of 2 samples, or of 1 and a rest of 1."""
    late = CriticalDelays.of(delayed_integrator((sqrt(5) - 1) / 2), Rational(1), Fraction(4))
    assert late is not None
    for _ in range(2):
        known = [*late.advance_to(Fraction(5, 2))]
        assert known == sorted(known)
    assert [float(x.value) for x in late.passages] == [2]
    assert [float(x.omega) for x in late.passages] == pytest.approx([np.pi / 5], rel=1e-12)
    assert late.root_changes == [2]


def test_a_delay_that_puts_a_root_on_the_circle_is_not_told_by_the_sum_of_those_before_it() -> None:
    """z^2 - z/2 + 1 for a gain of 3/2 and tau = 2/3."""
    critical = Passage(ExactNumber(Rational(2, 3)), ExactNumber(Integer(1)))
    late = CriticalDelays(delayed_integrator(Rational(3, 2)), Rational(1, 2), [], None, [critical], [2], frontier=None)
    assert [late.is_stable_at(Rational(x)) for x in ("1/2", "2/3", "3/4")] == [True, None, False]


@pytest.mark.parametrize("path", ["effects.delay.tau", "effects.zero-order-hold.T"])
def test_where_a_force_that_acts_at_once_comes_a_whole_sample_later_the_roots_jump(path: str) -> None:
    """Spring and damper behind a clock, against a hand without mass: c/(s + a) + d, exactly discretized by hand, roots by NumPy."""
    a, c, d = 2.4, 2.1, 0.2
    own = hs.Scene(
        E.kelvin_voigt(Rational("2.58"), Rational("0.2")), (F.delay("1.3 s"), F.zero_order_hold("1 s")),
        hands=(hs.Hand("no mass", b=1, k=Rational("2.4")),),
    )  # fmt: skip

    def size(tau: float = 1.3, T: float = 1.0) -> float:
        samples, rest = divmod(tau, T)
        p, e = np.exp(-a * T), np.exp(-a * (T - rest))
        held_force = [c * (1 - e) / a + d, c * (e - p) / a - d * p]
        loop = np.polyadd([1, -p, 0, *[0] * int(samples)], held_force)
        return float(abs(np.roots(loop)).max())

    found = hs.require(own, path, ("0.55 s", "3.1 s"), that="stable", hand=own.hands[0])
    is_in, key = told(found), path.split(".")[-1]
    for x in np.linspace(0.56, 3.09, 254) + 1e-5:
        assert is_in(x) is (size(**{key: x}) < 1), x
    jumps = [float(x.value) for x in found.ends if any(y.omega is None for y in x.bindings)]
    assert jumps == ([2.0, 3.0] if key == "tau" else [1.3])
    last = nearest(own, path).ends[-1]
    assert float(last.value) == pytest.approx(2 if key == "tau" else 1.160007, rel=1e-6)


def test_what_is_next_to_a_jump_is_told_on_both_sides() -> None:
    """Of the delay 1.3 s, of which 2 s are one whole sample more: stable below it alone."""
    own = hs.Scene(
        E.kelvin_voigt(Rational("2.58"), Rational("0.2")), (F.delay("1.3 s"), F.zero_order_hold("1 s")),
        hands=(hs.Hand("no mass", b=1, k=Rational("2.4")),),
    )  # fmt: skip
    assert told_up_to(nearest(own, "effects.delay.tau"), 2.0)[1] > 2
    assert hs.stability(own).to_dict()["held"][0]["margins"]["delay"] == {"above": pytest.approx(0.7), "omega": None}


def test_a_display_that_acts_at_once_has_limits_of_a_hand_that_is_nothing_but_damping_and_stiffness() -> None:
    """Without the damping the sampled position would move by an impulse: there is no loop, and no error."""
    chain = F.delay("1.3 s"), F.zero_order_hold("1 s")
    own = hs.Scene(E.kelvin_voigt(1, Rational(1, 9)), chain, hands=(hs.Hand("no mass", b=1, k=2),))
    assert hs.stability(own).to_dict()["held"][0]["stable"] is True


def test_a_delay_that_is_a_multiple_of_pi_is_asked_about_as_any_other() -> None:
    """Roots are counted at a rational delay next to it."""
    own = hs.load_scene("sampled-wall").with_hands(hs.hands["postural-arm"])
    sets = [
        hs.require(own.with_values({"effects.computation.tau": tau}), "effects.computation.tau", ("0.2 ms", "40 ms"), that="stable")
        for tau in (Rational(1, 3000), pi / 9000)
    ]  # fmt: skip
    one, other = ([(float(y.low), float(y.high)) for y in x.feasible] for x in sets)
    assert one == other
