"""Boxes and planes of hands and displays whose stability is known by Hurwitz' condition of third order, or by roots in floats."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from lagged import lagged, room, text
from sympy import Integer, Rational, Symbol

import haptisym as hs
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.verbs.stability.boxes import Share
from haptisym.verbs.tolerances.heldbox import HeldInBox, _Question, held_in_box


@pytest.mark.parametrize("seed", range(3))
def test_a_box_is_held_for_all_some_or_none_of_its_values_as_its_corners_say(seed: int) -> None:
    """The room grows with b and omega_c, falls with k, and goes one way with m: its least and most lie at corners."""
    pick = Random(seed)
    for _ in range(2):
        near = [Fraction(pick.randint(*x), 10) for x in ((100, 600), (5, 20), (10, 30), (40, 120))]
        ends = [[x, x * (1 + Fraction(pick.choice([0, 5, 10, 40]), 100))] for x in near]
        rooms = [room(*x) for x in product(*ends)]
        if 0 in rooms or min(map(abs, rooms)) < Fraction(1, 2):
            continue
        found = lagged(*map(text, ends))
        told = held_in_box(found, found.hands[0])
        expected = Share.ALL if min(rooms) > 0 else Share.NONE if max(rooms) < 0 else Share.SOME
        assert (told.share, told.reason) == (expected, "")
        varying = {"environment.k", "hand.m", "hand.b", "omega_c", "effects.first-order-lag.omega_c"}
        for example, is_stable in ((told.stable, True), (told.unstable, False)):
            assert (example is None) is (expected is (Share.NONE if is_stable else Share.ALL))
            if example is not None:
                assert set(example) <= varying
                now = found.with_values(dict(example))
                knobs = [now.knobs[x].value for x in ("environment.k", "hand.m", "hand.b", "omega_c")]
                assert all(a <= x <= b for x, (a, b) in zip(knobs, ends, strict=True))
                assert bool(room(*knobs) > 0) is is_stable


@pytest.mark.parametrize(
    ("a", "k", "expected"),
    [
        ((1, 2), ("0.25", "0.5"), None),  # one root, which the pole could hide
        ((1, 2), (90, 100), Share.NONE),  # two roots, of which the pole could hide one
        ((-2, -1), (90, 100), Share.NONE),
        ((-20, -10), (1, 2), Share.ALL),
    ],
)
def test_a_display_with_poles_on_the_right_is_never_held_where_more_roots_than_poles_are(
    a: Any, k: Any, expected: Share | None
) -> None:
    """k/(s - a) in a hand of m = 1, b = 1, k = 1: (s^2 + s + 1)(s - a) + k; the number of roots is the same in all corners."""
    felt = hs.environments.expression("g/(s - a)", parameters={"g": list(map(str, k)), "a": list(map(str, a))})
    found = hs.Scene(felt, (), hands=(hs.Hand("mine", 1, 1, 1),))
    counts = {sum(np.roots([1, 1 - x, 1 - x, y - x]).real > 0) for x, y in product(map(float, a), map(float, k))}
    poles = int(max(a) > 0)
    assert len(counts) == 1
    [count] = counts
    assert expected is (Share.ALL if count == 0 else Share.NONE if count > poles else None)
    told = held_in_box(found, found.hands[0])
    assert told.share is expected
    assert bool(told.reason) is (expected is None)


HANDS = [hs.Hand("other", 1, 1, 1), hs.Hand("mine", 1, 1, 1)]


def question(**known: Any) -> Any:
    found: Any = _Question.__new__(_Question)
    found.hand, found.sides, found.found = hs.Hand("mine", 1, 1, 1), [1], {}
    found.__dict__.update(known)
    found._corners = lambda: iter(range(1000))
    return found


def test_what_is_told_of_a_box_comes_from_examples_of_both_kinds_or_from_a_proof_for_all() -> None:
    """All that examples, sides, proofs and reasons may be."""
    some_kinds = ((), (True,), (False,), (True, False))
    for first, later, sides, proof, reason in product(
        some_kinds, some_kinds[::3], ([], [1]), (True, False, None, "open"), ("", "friction")
    ):
        asked = question(sides=sides)
        looked: list[int] = []

        def look(sets: Any, asked: Any = asked, first: Any = first, reason: str = reason, looked: Any = looked) -> str:
            looked.append(len(list(sets)))
            asked.found |= {x: {"p": Integer(x)} for x in first}
            return reason

        def for_all(asked: Any = asked, later: Any = later, proof: Any = proof) -> Any:
            assert len(asked.found) == 1
            if proof == "open":
                raise UndecidedError("it stays open")
            if proof is None:
                asked.found |= {x: {"p": Integer(x)} for x in later}
            return proof

        asked._look, asked._for_all = look, for_all
        told = asked.answer()
        assert looked == [65]  # the nominal values, and so many corners
        alone = len(first) == 1
        proven = (proof if proof != "open" else None) if sides else True in first
        some = len(first) == 2 or (alone and bool(sides) and proof is None and bool(later))
        known = None if not alone or proven is None else Share.ALL if proven else Share.NONE
        share = Share.SOME if some else known
        assert told.share is share
        why = "it stays open" if alone and sides and proof == "open" else reason
        assert told.reason == ("" if share else why or "whether the number of roots changes within the ranges")
        assert (told.stable, told.unstable) == (asked.found.get(True), asked.found.get(False))


def test_sets_of_values_are_counted_until_there_are_both_kinds(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of each kind is the example; what stays open is passed over, and the last reason is told."""
    pick = Random(4)
    for _ in range(40):
        counts = [pick.choice([0, 0, 1, 2, None, "friction", "scene"]) for _ in range(8)]
        seen: list[int] = []

        def unstable(scene: Any, hand: Any, counts: Any = counts, seen: Any = seen) -> Any:
            seen.append(scene.at)
            told = counts[scene.at]
            if told == "friction":
                raise UndecidedError(f"open at {scene.at}")
            if told == "scene":
                raise SceneError(f"none at {scene.at}")
            return SimpleNamespace(number=told)

        monkeypatch.setattr("haptisym.verbs.tolerances.heldbox.unstable_roots", unstable)
        asked = question(scene=SimpleNamespace(with_values=lambda x: SimpleNamespace(at=x, hands=HANDS)))
        reason = asked._look(iter(range(8)))
        kinds = [x == 0 if x is None or isinstance(x, int) else None for x in counts]
        firsts = {kind: kinds.index(kind) for kind in (True, False) if kind in kinds}
        stop = max(firsts.values()) + 1 if len(firsts) == 2 else 8
        assert asked.found == firsts
        assert seen == list(range(stop))
        opened = [n for n in range(stop) if kinds[n] is None]
        last = f"{'open' if counts[opened[-1]] == 'friction' else 'none'} at {opened[-1]}" if opened else ""
        assert reason == last


def test_examples_are_looked_for_at_the_nominal_values_the_corners_and_the_middles_of_cells() -> None:
    p, q = Symbol("p"), Symbol("q")
    sides = [SimpleNamespace(path="a.p", symbol=p, value=Integer(2), interval=(Integer(1), Integer(4))),
             SimpleNamespace(path="b.q", symbol=q, value=Integer(5), interval=(Rational(1, 2), Integer(8)))]  # fmt: skip
    asked: Any = _Question.__new__(_Question)
    asked.sides = sides
    corners = [{"a.p": x, "b.q": y} for x in (1, 4) for y in (Rational(1, 2), 8)]
    assert [*asked._corners()] == [{"a.p": 2, "b.q": 5}, *corners]
    cells = np.array([[[0, 1], [0.5, 1]], [[0.2, 0.3], [0, 0.5]]], float)
    half = Rational(15, 2) * Rational(1, 4)
    assert [*asked._middles([q], cells)] == [{"a.p": 2, "b.q": 8 - half}, {"a.p": 2, "b.q": Rational(1, 2) + half}]
    many = np.tile(cells[:1], (100, 1, 1))
    assert len([*asked._middles([q], many)]) == 13
    assert len([*asked._middles([q], many[:12])]) == 12


def test_when_the_time_is_over_that_is_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def late(*_: Any) -> Any:
        raise LimitError("over")

    monkeypatch.setattr("haptisym.verbs.tolerances.heldbox._Question", late)
    hand = hs.Hand("mine", 1, 1, 1)
    assert held_in_box(lagged(1, 1, 1, 1), hand) == HeldInBox(hand, None, reason="the limit of time was reached")
