"""Imposed, held, every passive hand: against facts computed elsewhere, roots found by mpmath and winding numbers."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from sympy import Rational

import haptisym as hs
from haptisym.verbs.stability.held import held

LATE = 'environment = {{ model = "mass-spring-damper", k = "{k} N/m" }}\neffects = [{{ model = "delay", tau = "36 ms" }}]\n'


def unstable(scene: hs.Scene | str, **hand: Any) -> int | None:
    own = hs.load_scene(scene) if isinstance(scene, str) else scene
    return held(own, hs.Hand("own", **hand)).unstable


@pytest.mark.parametrize(
    ("k", "critical"),
    [
        ("0", "3.4635997327677041"), ("100", "3.3297497532862284"), ("500", "2.81972833105523"), ("1000", "2.238659408552519"),
    ],
)  # fmt: skip
def test_a_spring_that_comes_late_is_held_from_a_certain_damping_on(k: str, critical: str) -> None:
    for change, expected in (("-1e-12", 2), ("1e-12", 0)):
        assert unstable("delayed-spring", m="0.5 kg", k=k, b=Rational(critical) + Rational(change)) == expected


def test_the_arm_that_was_measured_holds_a_late_spring_of_no_more_than_200_newtons_per_metre() -> None:
    arm = hs.hands["postural-arm"]
    for k, expected in (("199.8521022587101", 0), ("199.8521022587102", 2), ("290", 2)):
        assert held(hs.parse_scene(LATE.format(k=k)), arm).unstable == expected


@pytest.mark.parametrize("name", hs.hands)
def test_a_satellite_is_held_by_no_lighter_hand(name: str) -> None:
    [found] = hs.stability("satellite-contact", name).held
    assert (found.stable, found.unstable) == (False, None)
    assert "right" in str(found.roots.chain.value)
    assert unstable("satellite-contact", m=499, b=10**3, k=10**5) is None
    assert unstable("satellite-contact", m=600, b=10**3, k=10**5) is not None


@pytest.mark.parametrize(
    "name", ["fu2019", "steering-wheel", "sidestick", "two-mass-resonance", "desktop-device-soft-tissue"]
)
def test_displays_that_are_nowhere_active_are_held_by_every_passive_hand(name: str) -> None:
    found = hs.stability(name).to_dict()["every_passive_hand"]
    assert (found["holds"], found["active"]) == (True, [])


def test_a_spring_of_290_newtons_per_metre_needs_ten_and_a_half() -> None:
    found = hs.stability(hs.parse_scene(LATE.format(k=290)), digits=20).to_dict()["every_passive_hand"]
    assert (found["damping"], found["digits"], found["omega"]) == (10.44, "10.440000000000000000", 0)  # K tau


def test_no_damping_is_enough_where_a_mass_comes_late() -> None:
    for name in ("satellite-contact", "four-channel-teleoperation"):
        found = hs.stability(name)
        assert found.to_dict()["every_passive_hand"]["damping"] is None
        assert "grows without bound" in " ".join(str(found).split())


def display(perceived: str) -> hs.Scene:
    """A display whose H_perc is what is written."""
    return hs.Scene(hs.environments.mass_spring_damper(k=1), (hs.effects.series(perceived),))


@pytest.mark.parametrize(
    ("perceived", "holds"),
    [
        ("1 + s", True), ("s^2 + 1", True), ("1", True), ("s", True), ("s - 1", False), ("s - s^2", False), ("1 - s", False), ("s^3 + s", False),
        ("s^2/(s^2 + 4)", True), ("4 - s^2/(s^2 + 4)", False), ("s/(s - 1)", False), ("1/s", False), ("s^2*1/(s^2 + 4)^2", False), ("s^4", False),
        ("2 + s^2*(s^2 + 5)/(s^2 + 4)", True), ("2 + s^2*(s^2 + 1)/(s^2 + 4)", False), ("s*(s - 2)/(s + 1)", False),
    ],
)  # fmt: skip
def test_impedances_of_textbooks_are_positive_real_or_not(perceived: str, *, holds: bool) -> None:
    """s^2/(s^2 + 4) is a mass on a spring; 4 - that is one of negative residue; 1/s integrates position to force."""
    assert hs.stability(display(perceived)).every_passive_hand.holds is holds


def count(a: list[float], m: float, b: float, k: float) -> int:
    """Roots of a polynomial plus a hand in Re s > 0, by eigenvalues of its companion matrix."""
    own = np.polyadd(a, [m, b, k])
    return int((np.roots(own).real > 0).sum())


@pytest.mark.parametrize("b", [0.1, 1, 5])
def test_a_display_of_negative_damping_is_held_where_the_hand_damps_more(b: float) -> None:
    assert unstable(display("1 - 2*s + s^2"), m=1, b=b, k=3) == count([1, -2, 1], 1, b, 3)


def test_the_three_statements_are_in_the_document_each_by_its_name() -> None:
    found = json.loads(hs.stability("delayed-spring", ["light-touch", "postural-arm"], digits=20).to_json())
    assert (found["schema"], found["imposed"]) == ("haptisym.stability/1", {"stable": True, "unstable": 0})
    light, arm = found["held"]
    assert (light["stable"], light["unstable"], arm["stable"], arm["unstable"]) == (False, 2, True, 0)
    assert {key: arm["hand"][key] for key in ("name", "m", "b", "k")} == {
        "name": "postural-arm",
        "m": 0.554,
        "b": 6.45,
        "k": 135.0,
    }
    every = found["every_passive_hand"]
    assert (every["holds"], every["damping"], every["omega"]) == (False, 3.6, 0.0)
    assert every["active"][0] == pytest.approx([0, np.pi / 0.036])
    assert (found["sampled"], found["certified"]) == (None, True)


def test_what_has_a_clock_or_a_friction_is_not_decided() -> None:
    for name in ("stick-with-friction", "wave-variable-link"):
        assert not hs.stability(name, "postural-arm").certified


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--hand", "postral-arm"], 'there is no hand "postral-arm": did you mean "postural-arm"? the package ships'),
        (["--hand", "light-touch", "--hand", "light-touch"], 'the hand "light-touch" is asked about twice'),
    ],
)
def test_a_wrong_hand_is_told_in_one_sentence(call: Any, words: list[str], told: str) -> None:
    status, out, err = call("stability", "fu2019", *words)
    assert (status, out) == (2, "")
    assert told in err.replace("\n", " ")


def test_a_hand_that_moves_along_a_line_does_not_turn_a_wheel(call: Any) -> None:
    status, _, err = call("stability", "steering-wheel", "--hand", "postural-arm")
    assert status == 2
    assert "translation and rotation cannot be mixed" in err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[hand]\nm = "-1 kg"', 'hand: m: "-1 kg" must be >= 0'),
        ("[hand]\nmass = 1", 'hand: unknown key "mass": '),
        ("[[hands]]\nm = 1", "hands[1]: name: each of several hands needs one"),
        ("[[hand]]\nm = 1", "hand: one is written [hand]; several are written [[hands]], with an s"),
        ('[[hands]]\nname = "a"\n[[hands]]\nname = "a"', 'hands: "a" is there twice'),
        ('[hand]\nm = 1\n[[hands]]\nname = "a"', "hand: give either [hand] or [[hands]]"),
        ('[hand]\nm = "1 kg"\nb = "1 N*m*s/rad"', "translation and rotation cannot be mixed"),
        ('[hand]\nb = "1 N"', '"1 N" is not a damping: expected N*s/m or N*m*s/rad'),
        ("[hand]\nsource = 3", 'source: "3" must be a string'),
    ],
)
def test_a_wrong_hand_in_a_file_is_told_in_one_sentence(text: str, told: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.parse_scene(LATE.format(k=100) + text)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_hands_have_knobs_that_change_nothing_of_what_is_felt() -> None:
    text = (
        LATE.format(k=100) + '[[hands]]\nname = "weak"\nb = ["1 N*s/m", "2 N*s/m"]\n[[hands]]\nname = "strong"\nb = 9\n'
    )
    scene = hs.parse_scene(text)
    assert [x.path for x in scene.parameters] == ["environment.k", "effects.delay.tau"]
    assert scene.nominal_note == ""
    assert scene.knobs["hands.weak.b"].interval == (1, 2)
    moved = scene.with_values({"hands.strong.m": "2 kg"})
    assert [x.m.value for x in moved.hands] == [0, 2]
    one = hs.parse_scene(LATE.format(k=100) + "[hand]\nm = 1\n")
    assert {one.knobs[x].path for x in ("hand.m", "hands.hand.m", "m_h")} == {"hand.m"}
    for name in hs.hands:
        assert hs.hands[name].source
