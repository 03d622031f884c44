"""Which hands and numbers stability is asked about, and what is asked of each: tables of what a scene may have."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

import haptisym as hs
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rootcount import Roots
from haptisym.verbs.stability import entry, passive
from haptisym.verbs.stability.critical import Nearest
from haptisym.verbs.stability.entry import chosen, in_hands
from haptisym.verbs.stability.held import Held
from haptisym.verbs.stability.passive import EveryPassiveHand, every_passive_hand

SCENE = hs.load_scene("delayed-spring")
SHIPPED = [*hs.hands]


def test_a_hand_is_the_scenes_own_before_one_that_is_shipped_and_a_given_one_is_itself() -> None:
    own, other = hs.Hand(SHIPPED[0], 1, 2, 3), hs.Hand("mine", 4, 5, 6)
    scene = SCENE.with_hands(own, other)
    given = hs.Hand("mine", 7, 8, 9)
    assert chosen(scene, given) is given
    assert chosen(scene, SHIPPED[0]) is scene.hands[0]
    assert chosen(scene, "mine") is scene.hands[1]
    assert chosen(scene, SHIPPED[1]) == hs.hands[SHIPPED[1]]
    assert chosen(SCENE.with_hands(), SHIPPED[0]) == hs.hands[SHIPPED[0]]
    with pytest.raises(hs.SceneError, match=f"the scene has {SHIPPED[0]}, mine; the package ships"):
        chosen(scene, "nobody")
    with pytest.raises(hs.SceneError, match=r'^there is no hand "nobody": the package ships'):
        chosen(SCENE.with_hands(), "nobody")


def test_without_a_hand_the_scene_stays_as_it_is_and_of_those_that_are_asked_about_each_is_there_once() -> None:
    own, other = hs.Hand("own", 1, 2, 3), hs.Hand("mine", 4, 5, 6)
    scene = SCENE.with_hands(own)
    assert in_hands(scene, None) is scene
    cases: Any = (
        ("own", ["own"]), (other, ["mine"]), ([other, "own"], ["mine", "own"]),
        ((SHIPPED[0], "own", other), [SHIPPED[0], "own", "mine"]), ([], []),
    )  # fmt: skip
    for asked, names in cases:
        assert [x.name for x in in_hands(scene, asked).hands] == names
    repeated: Any = (["own", "own"], [other, "own", hs.Hand("mine")], ["own", hs.Hand("own", 7)])
    for twice in repeated:
        with pytest.raises(hs.SceneError, match="is asked about twice"):
            in_hands(scene, twice)


def test_of_a_hand_that_is_decided_its_own_numbers_are_asked_about_and_those_of_the_display(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = SCENE.with_hands(hs.Hand("one", 1, 2, 3), hs.Hand("two", 4, 5, 6))
    monkeypatch.setattr(entry, "critical", lambda own, hand, knob: (own is scene, hand.name, knob.path))
    free = [x for x in scene.knobs if x.path in ("environment.k", "hands.one.b", "hands.two.m")]
    assert len(free) == 3
    for hand in scene.hands:
        found: Any = entry._critical(scene, Held(hand, Roots(0, 0)), free)
        paths = [*(f"hands.{hand.name}.{key}" for key in "mbk"), "environment.k"]
        assert [*found] == [(True, hand.name, path) for path in paths]
        assert entry._critical(scene, Held(hand, None, "why"), free) == ()
    assert isinstance(Nearest("p").found, tuple)


def test_whether_every_passive_hand_holds_is_open_where_something_that_is_asked_stays_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """H_perc/s, and the damping that makes up for it, or with a clock that of the hand."""

    class Told:
        def __init__(self, sampled: Any, fails: str) -> None:
            self.sampled, self.fails = sampled, fails

        def __getattr__(self, name: str) -> Any:
            if name == self.fails:
                raise UndecidedError(f"open: {name}")
            return True

    for clock in (False, True):
        for fails in ("", "holds", "damping", "hand_needed"):
            sampled: Any = None
            if clock:
                sampled = Told(None, fails)
                sampled.reason = "its reason"
            told: Any = Told(sampled, fails)
            monkeypatch.setattr(passive, "passivity", lambda _, told=told: told)
            found = every_passive_hand(SimpleNamespace())  # type: ignore[arg-type]
            if fails in ({"holds", "hand_needed"} if clock else {"holds", "damping"}):
                assert found == EveryPassiveHand(None, f"open: {fails}")
            else:
                assert (found.passivity, found.sampled) == (told, sampled)
                assert found.reason == ("its reason" if clock else "")
