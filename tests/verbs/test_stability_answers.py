"""What an answer about stability says, made of parts that are known: its document, its line, and whether nothing was left open."""

from __future__ import annotations

import random
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Integer, Rational, Symbol, sqrt

import haptisym as hs
from haptisym.judge.passivity import Beyond
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.verbs.stability.answer import Stability
from haptisym.verbs.stability.boxes import Box, Share
from haptisym.verbs.stability.critical import Critical, Nearest
from haptisym.verbs.stability.held import Held, Imposed
from haptisym.verbs.stability.passive import EveryPassiveHand

SCENE = hs.load_scene("delayed-spring")
SEEDS = range(12)
SAID = {None: "undecided", True: "holds", False: "does not hold"}


def roots(draw: random.Random) -> Roots | None:
    return draw.choice([
        None, Roots(0, 0), Roots(2, 2), Roots(1, 0, (ExactNumber(Integer(3)),)), Roots(None, None, (), RootChain.RIGHT), Roots(None, None, (), RootChain.NEAR),
    ])  # fmt: skip


def nearest(draw: random.Random) -> Nearest:
    found = tuple(
        Critical(
            f"path{n}",
            ExactNumber(draw.choice([Rational(1, 3), sqrt(2), Integer(-7)])),
            draw.choice([None, ExactNumber(Integer(5))]),
            draw.choice([None, 0, 1, 2]),
            draw.choice([None, 0, 1, 2]),
            is_crowded=draw.choice([True, False]),
        )
        for n in range(draw.randint(0, 2))
    )
    low, high = draw.choice([(None, None), (Fraction(1, 2), Fraction(3)), (None, Fraction(3)), (Fraction(1), None)])
    return Nearest(draw.choice("xy"), found, draw.choice(["", "", "open"]), low, high)


def passive(draw: random.Random) -> EveryPassiveHand:
    if draw.random() < 0.3:
        return EveryPassiveHand(None, "why")
    best = draw.choice([None, SimpleNamespace(value=ExactNumber(sqrt(5)), omega=draw.choice([None, ExactNumber(Integer(9))]))])  # fmt: skip
    own: Any = SimpleNamespace(
        holds=draw.choice([None, True, False]), damping=best, is_unbounded=draw.choice([True, False]), poles_allow=draw.choice([True, False]),
        beyond=draw.choice(list(Beyond)), row=lambda: {"active": [[1, 2]], "reach": 77.0},
    )  # fmt: skip
    return EveryPassiveHand(own)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_document_holds_what_its_parts_say_and_is_certified_where_none_is_open(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        hands = [hs.Hand(name, 1, 2, 3) for name in ("one", "two")[: draw.randint(0, 2)]]
        imposed = Imposed(draw.choice([None, True, False]), draw.choice([None, 0, 3]))
        held = [Held(x, y, "" if y else "because") for x in hands for y in [roots(draw)]]
        near = tuple(tuple(nearest(draw) for _ in range(draw.randint(0, 2))) for _ in hands)
        boxes = tuple(
            draw.choice([None, Box(Share.SOME), Box(Share.ALL), Box(Share.NONE), Box(None, reason="too wide")])
            for _ in hands
        )
        every, digits = passive(draw), draw.choice([4, 15])
        found = Stability(SCENE, imposed, tuple(held), near, boxes, every, digits)
        told = found.to_dict()
        stable = [None if x.roots is None else x.roots.number == 0 for x in held]
        left = [x.reason for row in near for x in row if x.reason] + [x.reason for x in boxes if x and x.reason]
        decided = None not in (imposed.stable, *stable) and every.is_decided and not left
        assert told["certified"] == found.certified == decided
        assert told["imposed"] == {"stable": imposed.stable, "unstable": imposed.unstable}
        assert told["every_passive_hand"] == every.row(digits)
        assert told["sampled"] is None
        lines = [f"imposed {SAID[imposed.stable]}", *(f"held in {x.hand.name} {SAID[y]}" for x, y in zip(held, stable, strict=True))]  # fmt: skip
        assert found._line().endswith(f": {', '.join(lines)}, every passive hand {SAID[every.holds]}")
        assert len(told["held"]) == len(hands)
        for x, row, rows, box in zip(held, told["held"], near, boxes, strict=True):
            assert row["hand"] == {"name": x.hand.name, "m": 1.0, "b": 2.0, "k": 3.0}
            assert (row["stable"], row["unstable"]) == (x.stable, x.unstable)
            assert row["critical"] == [found._critical(y) for z in rows for y in z.found]
            assert row.get("whole_box", "no box") == ("no box" if box is None else box.share and box.share.value)
            undecided = [{"path": y.path, "reason": y.reason} for y in rows if y.reason]
            undecided += [{"path": x.hand.name, "reason": box.reason}] if box and box.reason else []
            assert row.get("undecided", []) == undecided
            ends = [(y.path, *(None if end is None else float(end) for end in (y.low, y.high))) for y in rows]
            looked = [{"path": y, "from": low, "to": high} for y, low, high in ends if (low, high) != (None, None)]
            assert row.get("looked_at", []) == looked
            assert row.get("chain") == (x.roots.chain.value if x.roots and x.roots.chain else None)
            assert row.get("reason", "") == x.reason
            assert [] not in [row.get(key) for key in ("undecided", "looked_at")]


@pytest.mark.parametrize("digits", [3, 15])
def test_a_critical_value_is_told_with_its_digits_and_its_stable_side(digits: int) -> None:
    found = Stability(SCENE, Imposed(stable=True, unstable=0), (), (), (), EveryPassiveHand(None), digits)
    value, omega = ExactNumber(sqrt(2)), ExactNumber(Rational(5, 2))
    for below, above, crowded, side, chain in (
        (0, 2, False, "below", None), (2, 0, False, "above", None), (1, 2, False, None, None), (0, None, False, "below", "above"), (None, 0, False, "above", "below"),
        (0, None, True, None, "above"), (None, 0, True, None, "below"), (2, None, False, None, "above"),
    ):  # fmt: skip
        for w in (omega, None):
            x = Critical("b", value, w, below, above, crowded)
            assert (x.stable_side, x.chain_side) == (side, chain)
            low, high = value.enclosure(digits)
            assert found._critical(x) == {
                "path": "b", "value": float(sqrt(2)), "digits": value.digits(digits), "enclosure": [low, high], "omega": w and 2.5, "stable_side": side,
            }  # fmt: skip
            assert x._line() == "b = 1.41421"


@pytest.mark.parametrize("seed", SEEDS)
def test_every_passive_hand_is_decided_where_both_it_and_the_damping_are(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        every, digits = passive(draw), draw.choice([4, 15])
        p, row = every.passivity, every.row(digits)
        none = {"damping": None, "digits": None}
        if p is None:
            assert (every.holds, every.is_decided) == (None, False)
            assert row == {"holds": None, "active": [], **none, "omega": None, "reason": "why"}
            continue
        assert every.holds is p.holds
        assert every.is_decided == (p.holds is not None and (p.damping is not None or p.is_unbounded))
        number = {"damping": float(sqrt(5)), "digits": ExactNumber(sqrt(5)).digits(digits)} if p.damping else none
        omega = 9.0 if p.damping and p.damping.omega else None
        expected = {"holds": p.holds, "active": [[1, 2]], **number, "omega": omega, "poles_allow": p.poles_allow}
        again = {Beyond.AGAIN: "active_again_beyond", Beyond.LATE: "not_looked_at_beyond"}
        expected |= {again[p.beyond]: 77.0} if p.beyond in again else {}
        expected |= {"reason": p.beyond.value} if p.holds is None and p.beyond is not Beyond.NEVER else {}
        assert row == expected


def test_with_a_clock_the_condition_for_sampled_walls_is_what_decides() -> None:
    for holds in (None, True, False):
        for theta, needed in ((None, None), (Integer(3), None), (Integer(3), sqrt(7)), (None, sqrt(7))):
            for is_there in (True, False):
                sampled: Any = SimpleNamespace(
                    needed=None if theta is None else SimpleNamespace(omega=ExactNumber(theta)),
                    hand_needed=None if needed is None else ExactNumber(needed), T=Rational(1, 1000), row=lambda n: {"digits": n},
                )  # fmt: skip
                own: Any = SimpleNamespace(holds=holds, row=lambda: {"active": [[4, 5]]})
                every = EveryPassiveHand(own if is_there else None, "", sampled)
                said = holds if is_there else None
                assert (every.holds, every.is_decided) == (said, said is not None)
                told = needed is not None and theta is not None and not said
                assert every.row(5) == {
                    "holds": said, "active": [[4, 5]] if is_there else [], "damping": None if needed is None else float(sqrt(7)),
                    "digits": None if needed is None else ExactNumber(sqrt(7)).digits(5), "omega": 3000.0 if told else None,
                }  # fmt: skip
                answer = Stability(SCENE, Imposed(stable=True, unstable=0), (), (), (), every, 5)
                assert (answer.sampled, answer.to_dict()["sampled"]) == (sampled, {"digits": 5})


def test_what_is_asked_about_is_a_number_of_a_scene_in_a_hand_and_all_others_are_numbers() -> None:
    hand = hs.Hand("own", 1, 2, 3)
    free = SCENE.with_values({"environment.k": Symbol("k", positive=True)})
    with pytest.raises(hs.SceneError, match="is a symbol where a number is needed"):
        hs.stability(free, hand)
    with pytest.raises(hs.SceneError, match="is a threshold, which moves no root"):
        hs.stability(SCENE, hand, "evaluation.jnd")
    with pytest.raises(hs.SceneError, match="how far it may go depends on the hand"):
        hs.stability(SCENE.with_hands(), free=["environment.k"])
    with pytest.raises(hs.SceneError, match='the hand "own" is asked about twice'):
        hs.stability(SCENE, [hand, hs.Hand("other", 1, 2, 3), hs.Hand("own", 1, 2, 4)])
    with pytest.raises(hs.SceneError, match="there is no hand"):
        hs.stability(SCENE, "nobody")
    both = hs.stability(SCENE, [hand, hs.Hand("other", 1, 20, 3)], "environment.k")
    assert [[x.path for x in rows] for rows in both.critical] == [
        [f"hands.{name}.{key}" for key in "mbk"] + ["environment.k"] for name in ("own", "other")
    ]
    assert both.digits == 15
    late = hs.stability("stick-with-friction", "postural-arm")
    assert (late.held[0].roots, late.critical) == (None, ((),))  # of what is not known nothing is critical
