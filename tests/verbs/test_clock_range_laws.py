"""How far a number of a display with a clock may go, without end: against eigenvalues of the sampled matrix, and counts one by one."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from sympy import Integer, Rational

import haptisym as hs
from haptisym.judge.colgate import sampled_passivity
from haptisym.kernel.reals import ExactNumber
from haptisym.model.hand import Hand
from haptisym.verbs.stability.clockcritical import opened
from haptisym.verbs.stability.clockrange import inverted, is_held, passages, passages_in
from haptisym.verbs.stability.clockvalues import Inverse, Passage
from haptisym.verbs.stability.held import held

E, F = hs.environments, hs.effects
SEEDS = range(24)


class Drawn:
    """A wall of any sign in a sampled loop, a device and a hand; the spectral radius of what is sampled tells whether it is stable."""

    def __init__(self, draw: random.Random) -> None:
        self.k, self.b = draw.choice([0, 40, 900]), draw.choice(["0", "0.5", "3"])
        self.T, self.late = draw.choice(["0.001", "0.004", "0.02"]), draw.choice([0, 0, 1, 2])
        self.device = {"m": draw.choice(["0.05", "0.3"]), "b": draw.choice(["0", "0.2", "2"])}
        self.hand = Hand("own", m=draw.choice([0, "0.2"]), b=draw.choice(["0.1", "4", "30"]), k=draw.choice([5, 200]))
        self.scene = hs.Scene(
            E.expression("k + b*s", parameters={"k": f"{self.k} N/m", "b": f"{self.b} N*s/m"}),
            (F.sampled_loop(f"{self.T} s", "backward-difference", self.late), F.shunt(**self.device)),
        )

    def radius(self, **own: float) -> float:
        """Largest |z|, K, B, device and hand as given here or drawn."""
        m, b, k = (float(x.value) for x in self.hand.parameters)
        known = {"k": self.k, "b": float(self.b), "m_h": m, "b_h": b, "k_h": k, "b_d": float(self.device["b"]), **own}
        T, mass = float(self.T), float(self.device["m"]) + known["m_h"]
        free = np.array([[0, 1, 0], [-known["k_h"] / mass, -(known["b_h"] + known["b_d"]) / mass, 1 / mass], [0, 0, 0]])
        moved = expm(free * T)
        n = 2 + self.late + 1  # x, v, and x of this many samples before
        step = np.zeros((n, n))
        step[:2, :2] = moved[:2, :2]
        force = np.zeros(n)
        places = [0, *range(2, n)]
        force[places[self.late]] -= known["k"] + known["b"] / T
        force[places[self.late + 1]] += known["b"] / T
        step[:2] += np.outer(moved[:2, 2], force)
        step[2, 0] = 1
        for i in range(3, n):
            step[i, i - 1] = 1
        return float(max(abs(np.linalg.eigvals(step))))


def is_in(found: Any, x: float) -> bool:
    """Whether a value lies in one of the intervals that were found."""
    ends = [
        [None if end.value is None else float(end.value) for end in (span.low, span.high)] for span in found.feasible
    ]
    return any((low is None or low < x) and (high is None or x < high) for low, high in ends)


VALUES = [sign * mantissa * 10.0**n for n in range(-3, 13) for mantissa in (1, 3.3) for sign in (1, -1)]


@pytest.mark.few(3)
@pytest.mark.parametrize("free", ["k", "b"])
@pytest.mark.parametrize("seed", SEEDS)
def test_stiffness_and_damping_of_a_wall_on_a_clock_are_told_for_all_values_of_either_sign(
    seed: int, free: str
) -> None:
    own = Drawn(random.Random(seed))
    found = hs.require(own.scene, f"environment.{free}", that="stable", hand=own.hand)
    assert found.certified
    assert not found.undecided
    for x in VALUES:
        radius = own.radius(**{free: x})
        if abs(radius - 1) > 1e-6:  # of eigenvalues in floats
            assert is_in(found, x) == (radius < 1), x


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_of_a_number_and_its_inverse_a_loop_has_as_many_roots_outside(seed: int) -> None:
    draw = random.Random(seed)
    own = Drawn(draw)
    held = F.zero_order_hold(f"{own.T} s"), F.shunt(**own.device)
    filtered = E.expression("k + c*k^2*s/(s + 90)", parameters={"k": 60, "c": "1/70"})
    scenes = {
        "a sampled wall": (own.scene, "environment.b"),
        "Tustin's rule": (
            replace(own.scene, effects=(F.sampled_loop(f"{own.T} s", "tustin", 1), F.shunt(**own.device))),
            "environment.k",
        ),
        "a held force": (hs.Scene(E.expression("k", parameters={"k": 3}), held), "environment.k"),
        "a square": (replace(own.scene, environment=filtered), "environment.k"),
    }
    for name, (scene, path) in scenes.items():
        loop = opened(scene, own.hand, scene.knobs[path])
        for side in (1, -1):
            far = inverted(loop, side)
            assert far is not None, name
            for _ in range(3):
                u = Rational(draw.randint(1, 90), draw.choice([1, 40, 9000]))
                assert far.count(u) == loop.count(side / u), (name, u)
                one = loop.at_one.xreplace({loop.symbol: side / u}), far.at_one.xreplace({far.symbol: u})
                assert (one[0] == 0) == (one[1] == 0)
            assert far.at_one.xreplace({far.symbol: Integer(0)}) not in (0, Integer(0))


HAND = Hand("hand", m="0.2", b=4, k=200)
OTHERS = ("hand.m", "hand.b", "hand.k", "effects.shunt.m", "effects.shunt.b", "effects.sampled-loop.T")


def held_wall(
    k: Any = 900, b: Any = 0, device: dict[str, Any] | None = None, hand: Hand = HAND, T: str = "0.004"
) -> hs.Scene:
    """The condition of Colgate and Schenkel: damping of device and hand above k T/2 + b."""
    environment = E.kelvin_voigt(k, b) if b else E.mass_spring_damper(k=k)
    device = {"m": "0.05", "b": "0.3"} if device is None else device
    return hs.Scene(environment, (F.sampled_loop(f"{T} s", "backward-difference"), F.shunt(**device)), hands=(hand,))


@pytest.mark.parametrize("path", OTHERS)
def test_what_is_not_over_the_loop_alone_has_no_inverse(path: str) -> None:
    scene = held_wall()
    assert inverted(opened(scene, HAND, scene.knobs[path]), 1) is None
    assert inverted(opened(scene, HAND, scene.knobs["environment.k"]), 1) is not None


@pytest.mark.parametrize("path", OTHERS)
def test_a_hand_that_damps_enough_holds_whatever_else_adds_to_it(path: str) -> None:
    scene = held_wall()  # 900 * 0.004/2 = 1.8 = 0.3 + 1.5
    for b, value, enough in (("1.5", 7, False), ("1.500001", 7, True), ("1.4", 7, False)):
        hand = HAND.with_values({"b_h": Rational(b)})
        own = {"hand.b": True, "effects.shunt.b": True, "effects.sampled-loop.T": False}.get(path, enough)
        assert is_held(scene, hand, scene.knobs[path], Rational(value)) == own
    for key, least in (("hand.b", "1.5"), ("effects.shunt.b", "-2.2")):
        told = [
            is_held(scene, HAND, scene.knobs[key], Rational(least) + x)
            for x in (Rational(-1, 10**9), 0, Rational(1, 10**9))
        ]
        assert told == [False, False, True], key


def test_it_does_not_where_the_number_is_in_the_wall_or_the_clock_or_takes_away() -> None:
    wall = held_wall(b="0.1")
    for path in ("environment.k", "environment.b", "effects.sampled-loop.T"):
        assert not is_held(wall, HAND, wall.knobs[path], Rational(1, 10**6)), path
    less = held_wall(device={"Z": "(2 - c)*s + m*s^2", "parameters": {"c": "0.1", "m": "0.05"}})
    assert not is_held(less, HAND, less.knobs["effects.shunt.c"], Rational(1, 2))
    assert is_held(less, HAND, less.knobs["effects.shunt.m"], Rational(1, 2))
    both = held_wall(device={"Z": "c*s + (c + m)*s^2", "parameters": {"c": "0.1", "m": "0.05"}})
    assert is_held(both, HAND, both.knobs["effects.shunt.c"], Rational(1, 2))
    yielding = replace(held_wall(), effects=(*held_wall().effects, F.compliance(k=800)))
    assert not is_held(yielding, HAND, yielding.knobs["hand.b"], Rational(100))
    assert not is_held(yielding, HAND, yielding.knobs["effects.compliance.k"], Rational(100))
    continuous = replace(held_wall(), effects=(F.shunt(m=1),))
    assert not is_held(continuous, HAND, continuous.knobs["hand.b"], Rational(100))


ADDING = {"hand.b": "b_h", "hand.m": "m_h", "hand.k": "k_h", "effects.shunt.b": "b_d"}


@pytest.mark.few("effects.shunt.b-0", "hand.b-3")
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("path", ADDING)
def test_damping_and_what_it_holds_is_told_for_all_values(path: str, seed: int) -> None:
    own = Drawn(random.Random(seed))
    own.device["b"] = "0.4"
    scene = replace(own.scene, effects=(own.scene.effects[0], F.shunt(**own.device)))
    sampled = sampled_passivity(scene)
    assert sampled is not None
    assert sampled.hand_needed is not None
    own.hand = replace(own.hand.with_values({"b_h": Rational(float(sampled.hand_needed) * 1.01 + 0.01)}), name="hand")
    scene = scene.with_hands(own.hand)
    free = scene.knobs[path]
    assert passages_in(scene, own.hand, free, (None, None))[1].high is None
    assert passages(scene, own.hand, free).high is None
    found = hs.require(scene, path, that="stable")
    for x in VALUES[::2]:
        radius = own.radius(**{ADDING[path]: x})
        ends = [[None if end is None else float(end) for end in pair] for pair in found.undecided]
        is_open = any((low is None or low < x) and (high is None or x < high) for low, high in ends)
        assert not (is_open and x > float(free.value))
        if abs(radius - 1) > 1e-6 and not is_open:
            assert is_in(found, x) == (radius < 1), x


def test_where_a_number_has_no_end_on_a_side_nothing_is_said_to_be_left() -> None:
    scene = held_wall(hand=Hand("hand", m="0.2", b="1.6", k=200))
    found = hs.stability(scene, free=["effects.shunt.b", "environment.k"])
    words = " ".join(str(found).split())
    assert "hand.m and hand.k: the number of unstable roots is the same for all values" in words
    assert "looked at" not in words.replace("was not looked at", "")
    [row] = json.loads(found.to_json())["held"]
    looked = {x["path"]: (x["from"], x["to"]) for x in row["looked_at"]}
    assert looked["effects.shunt.b"][1] is looked["hand.b"][1] is looked["environment.k"][0] is None
    assert [x["stable_side"] for x in row["critical"]] == ["above", "above", "below"]


@pytest.mark.slow
def test_where_it_has_one_the_page_says_how_far_it_was_looked_at() -> None:
    weak = hs.stability(held_wall(k=400, hand=Hand("hand", m="0.2", b="0.4", k=200)), free="effects.sampled-loop.T")
    words = " ".join(str(weak).split())
    [row] = json.loads(weak.to_json())["held"]
    critical = {x["path"] for x in row["critical"]}
    assert "effects.sampled-loop.T" in critical
    for x in (x for x in row["looked_at"] if x["path"] not in critical):
        start = f"{x['path']}: looked at "
        if x["from"] is None:
            assert f"{start}up to {x['to']:.5g}; what is beyond was not." in words
        elif x["to"] is None:
            assert f"{start}from {x['from']:.5g} on; what is below was not." in words
        else:
            assert f"{start}from {x['from']:.5g} to {x['to']:.5g}; what is beyond was not." in words


def test_the_inverse_of_a_number_and_of_a_passage() -> None:
    number = ExactNumber(Rational(3, 7))
    assert [Inverse(number, sign).digits(30) for sign in (1, -1)] == [
        "2.33333333333333333333333333333",
        "-2.33333333333333333333333333333",
    ]
    passage = Passage(number, ExactNumber(Integer(5)), 2, 4)
    for side, ends in ((1, (4, 2)), (-1, (2, 4))):
        turned = passage.inverse(side)
        assert (turned.value, turned.omega, turned.below, turned.above) == (Inverse(number, side), passage.omega, *ends)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(6))
def test_with_tustins_rule_a_spring_beside_a_damper_is_told_for_all_values(seed: int) -> None:
    """The controller has a pole at z = -1, where the damper alone is felt, however stiff the spring is."""
    draw = random.Random(seed)
    wall = E.kelvin_voigt(draw.choice([20, 900]), draw.choice(["0.4", "3"]))
    effects = F.sampled_loop(draw.choice(["1 ms", "7 ms"]), "tustin", draw.choice([0, 1])), F.shunt(m="0.2", b="0.3")
    scene = hs.Scene(wall, effects, hands=(HAND,))
    found = hs.require(scene, "environment.k", that="stable")
    assert found.certified
    for x in VALUES[::4]:
        if x > 0:
            own = held(scene.with_values({"environment.k": Rational(x)}), HAND)
            assert own.stable is is_in(found, x), x


@pytest.mark.parametrize(("T", "late"), [("1 ms", 0), pytest.param("4 ms", 1, marks=pytest.mark.slow)])
def test_the_corner_of_a_filter_is_told_for_all_values_and_at_0_by_what_is_left_there(T: str, late: int) -> None:
    """At a corner of 0 the filter passes nothing, and the spring alone is held; below it its own pole grows, unless T jumps over it."""
    felt = E.expression("k + b*s*w/(s + w)", parameters={"k": 300, "b": 3, "w": 400})
    hand = Hand("hand", m="0.1", b=5, k=100)
    scene = hs.Scene(felt, (F.sampled_loop(T, "backward-difference", late), F.shunt(m="0.2", b="0.3")), hands=(hand,))
    found = hs.require(scene, "environment.w", that="stable")
    assert found.certified
    for x in VALUES[::3]:
        assert held(scene.with_values({"environment.w": Rational(x)}), hand).stable is is_in(found, x)
    assert held(scene.with_values({"environment.w": Integer(0)}), hand).stable
    ends = [span.low for span in found.feasible if span.low.value is not None]
    assert [(x.value, x.closed) for x in ends] == [(ExactNumber(Integer(0)), True)]
