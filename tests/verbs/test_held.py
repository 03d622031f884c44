"""Imposed, in a hand, in a box of hands, in every passive hand: counts of roots against winding numbers and eigenvalues."""

from __future__ import annotations

import json
import random
from dataclasses import dataclass
from itertools import product
from random import Random
from typing import Any

import numpy as np
import pytest
from heldloops import closed, display, drawn, number, poles_on_the_right
from marks import FLEXIBLE
from refusals import refusal
from scipy.linalg import expm
from sympy import Expr, I, Integer, Rational, Symbol, exp
from windings import winding

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.sets import Verdict
from haptisym.model.quantities import MotionKind
from haptisym.verbs.stability.held import Share, held, imposed, whole_box, zeros_of

E, F = hs.environments, hs.effects
LATE = 'environment = {{ model = "mass-spring-damper", k = "{k} N/m" }}\neffects = [{{ model = "delay", tau = "36 ms" }}]\n'
SPRING, LATE_BY = E.mass_spring_damper(k=100), F.delay("36 ms")


def unstable(scene: hs.Scene | str, **hand: Any) -> int | None:
    own = hs.load_scene(scene) if isinstance(scene, str) else scene
    return held(own, hs.Hand("own", **hand)).unstable


# In a hand


@pytest.mark.parametrize(
    ("k", "critical"),
    [("0", "3.4635997327677041"), ("100", "3.3297497532862284"), ("500", "2.81972833105523"), ("1000", "2.238659408552519")],
)  # fmt: skip
def test_a_spring_that_comes_late_is_held_from_a_certain_damping_on(k: str, critical: str) -> None:
    for change, expected in (("-1e-12", 2), ("1e-12", 0)):
        assert unstable("delayed-spring", m="0.5 kg", k=k, b=Rational(critical) + Rational(change)) == expected


def test_the_arm_that_was_measured_holds_a_late_spring_of_no_more_than_200_newtons_per_metre() -> None:
    arm = hs.hands["postural-arm"]
    for k, expected in (("199.8521022587101", 0), ("199.8521022587102", 2), ("290", 2)):
        assert held(hs.parse_scene(LATE.format(k=k)), arm).unstable == expected


@pytest.mark.few(7)
@pytest.mark.parametrize("seed", range(40))
def test_held_and_imposed_are_what_contours_wind_around(seed: int) -> None:
    draw = Random(seed)
    scene = drawn(draw, late=seed % 3 > 0)
    hand = hs.Hand("any", number(draw, 0.1, 3), number(draw, 0, 9), number(draw, 0, 300))
    told, poles = held(scene, hand), imposed(scene)
    count, right = winding(closed(scene, hand), 500.0), poles_on_the_right(scene)
    assert told.roots is not None
    if count is not None and told.roots.chain is None and not told.on_axis:
        assert (told.unstable, told.stable) == (count, count == 0)
    if right is not None and poles.unstable is not None:
        assert (poles.unstable, poles.stable) == (right, right == 0)


@pytest.mark.parametrize("b", [0.1, 1, 5])
def test_a_display_of_negative_damping_is_held_where_the_hand_damps_more(b: float) -> None:
    assert unstable(display("1 - 2*s + s^2"), m=1, b=b, k=3) == (np.roots([2, b - 2, 4]).real > 0).sum()


@pytest.mark.parametrize("b", [-9, -1, 9])
def test_behind_waves_a_part_that_gives_energy_is_not_taken_for_one_that_takes_it(b: int) -> None:
    scene, hand = (
        hs.Scene(E.kelvin_voigt(100, 1), (F.wave_variables(2, "5 ms"), F.shunt(b=b))),
        hs.Hand("hand", 1, 1, 20),
    )
    f = closed(scene, hand)
    count = winding(lambda z: f(z + 1e-3), 500.0)  # at 0 line and denominator vanish both
    assert count is not None
    assert held(scene, hand).unstable == count
    assert (count == 0) is (b > -9)


def test_an_environment_that_grows_too_fast_makes_a_hand_shake() -> None:
    """k + c s^4 behind a cable, though Im H is nowhere negative."""
    cable, tissue = 5000, [1, 0, 0, 0, 100]
    own = hs.Scene(E.expression("k+c*s^4", parameters={"k": 100, "c": 1}), (F.compliance(k=cable),))
    row = np.polyadd(np.polymul([1, 5, 20], np.polyadd(tissue, [cable])), cable * np.array(tissue))
    assert unstable(own, m=1, b=5, k=20) == (np.roots(row).real >= 0).sum() == 2


ODD: list[tuple[hs.Scene, dict[str, Any], bool]] = [
    (hs.Scene(SPRING), {}, True), (hs.Scene(SPRING), {"m": 1}, False), (hs.Scene(SPRING), {"b": 1}, True),
    (hs.Scene(E.mass_spring_damper(m=1)), {"m": 1}, False), (hs.Scene(E.mass_spring_damper(b=1)), {}, False),
    (hs.Scene(SPRING, (LATE_BY,)), {}, True), (hs.Scene(SPRING, (LATE_BY,)), {"k": 50}, False), (hs.Scene(SPRING, (LATE_BY,)), {"k": 100}, False),
    (hs.Scene(SPRING, (LATE_BY,)), {"k": 150}, True), (hs.Scene(SPRING, (LATE_BY,)), {"b": 3}, True),
    (hs.Scene(SPRING, (F.shunt(m="-0.2 kg"),)), {"m": "0.1 kg", "b": 1}, False),
    (hs.Scene(SPRING, (F.shunt(m="-0.2 kg"),)), {"m": "0.2 kg", "b": 1}, True),
    (hs.Scene(E.kelvin_voigt(100, 2), (LATE_BY,)), {"b": 1}, False), (hs.Scene(SPRING, (F.series("1/s"),)), {"m": 1, "b": 1}, False),
]  # fmt: skip


@pytest.mark.dear("scene5-hand5-True", "scene6-hand6-False", "scene9-hand9-True")
@pytest.mark.few(5)
@pytest.mark.parametrize(("scene", "hand", "stable"), ODD)
def test_displays_at_the_edge_of_sense_get_an_answer(scene: hs.Scene, hand: dict[str, Any], *, stable: bool) -> None:
    """A spring alone has no motion of its own; a late one bounces from a weaker spring more each time, from a stiffer one less."""
    answer = hs.stability(scene, hs.Hand("hand", **hand), [x.path for x in scene.parameters])
    assert json.loads(answer.to_json())["held"][0]["stable"] is stable


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize("below", range(4))
def test_what_top_and_bottom_share_at_0_is_no_root(order: int, below: int) -> None:
    """s^a (1 - exp(-s))^b (s^2 + 4) (s - 2) over s^c: a root at 0 of order a + b - c, if that is positive."""
    for late in range(order + 1):
        top = s ** (order - late) * (1 - exp(-s)) ** late * (s**2 + 4) * (s - 2)
        ring = Ring.of([top, exp(-s)])
        found = zeros_of(ring.convert(top.expand()).numerator, ring.convert(s**below).numerator, ring)
        left = max(order - below, 0)
        if found.chain is None:
            assert (found.number, found.right) == (3 + left, 1)
            assert [float(x) for x in found.on_axis] == [0.0] * bool(left) + [2.0]
        else:
            assert late


Q = Symbol("q", positive=True)


@pytest.mark.parametrize(
    ("top", "why"), [(0 * s, "force is zero"), (s**2 + I * s + 3, "describing function"), (s**2 + Q * s + 3, "")]
)
def test_of_no_dynamics_at_all_and_with_j_among_its_numbers_no_roots_are_told(top: Expr, why: str) -> None:
    ring = Ring.of([s, top])
    if why:
        with pytest.raises(UndecidedError, match=why):
            zeros_of(ring.convert(top).numerator, ring.convert(s).numerator, ring)
    else:
        assert zeros_of(ring.convert(top.subs(Q, 2)).numerator, ring.convert(s + 1).numerator, ring).number == 0


@pytest.mark.parametrize("name", hs.hands)
def test_a_satellite_is_held_by_no_lighter_hand(name: str) -> None:
    found = held(hs.load_scene("satellite-contact"), hs.hands[name])
    assert found.roots is not None
    assert (found.stable, found.unstable, found.roots.chain) == (False, None, RootChain.RIGHT)


def test_the_satellite_has_finitely_many_roots_on_the_right_in_a_heavier_hand_alone() -> None:
    assert unstable("satellite-contact", m=499, b=10**3, k=10**5) is None
    assert unstable("satellite-contact", m=600, b=10**3, k=10**5) is not None


# Imposed


@pytest.mark.parametrize(
    ("perceived", "poles"),
    [("1/(s + 1)", 0), ("s/(s - 1)", 1), ("1/(s^2 - s + 4)", 2), ("1/s", 1), ("1/(s^2 + 4)", 2), ("s^3", 0)],
)
def test_a_force_is_stable_under_imposed_motion_without_poles_on_the_right_or_on_the_axis(
    perceived: str, poles: int
) -> None:
    found = imposed(display(perceived))
    assert (found.unstable, found.stable) == (poles, poles == 0)


def test_a_force_that_comes_back_larger_each_time_has_a_chain_of_poles() -> None:
    """1 + 20 exp(-s/1000)."""
    port = F.two_port("-40", "0", "20/s^2", "1")
    found = imposed(hs.Scene(E.mass_spring_damper(m=1), (F.delay("1 ms"), port)))
    assert (found.stable, found.unstable, found.chain) == (False, None, RootChain.RIGHT)


# A box of hands


BOXES = [
    ("delayed-spring", ("0.3", "1"), ("4", "10"), ("0", "500"), "all"),  # beyond b* = 3.6
    ("delayed-spring", ("0.3", "1"), ("3", "10"), ("0", "500"), "some"),
    ("delayed-spring", ("0.3", "1"), ("3.4", "10"), ("400", "500"), "all"),
    ("delayed-spring", ("0.3", "1"), ("0.1", "0.4"), ("0", "500"), "none"),
    ("delayed-spring", ("0", "1"), ("4", "10"), ("0", "500"), "all"),
    ("fu2019", ("0", "1"), ("0", "10"), ("0", "500"), "all"),
]


@pytest.mark.dear("delayed-spring-m0-b0-k0-all")
@pytest.mark.few("delayed-spring-m2-b2-k2-all", "delayed-spring-m3-b3-k3-none")
@pytest.mark.parametrize(("name", "m", "b", "k", "share"), BOXES)
def test_a_box_of_hands_is_decided_as_a_whole(name: str, m: Any, b: Any, k: Any, share: str) -> None:
    """Held against a grid of hands inside the box: all, none, or both kinds are stable."""
    scene = hs.load_scene(name)
    box = whole_box(scene, hs.Hand("box", [*m], [*b], [*k]))
    ends = [[Rational(x) for x in pair] for pair in (m, b, k)]
    shares = [Rational(n, 3) for n in range(0, 4, 3 if share == "none" else 1)]
    grid = [
        [low + u * (high - low) for u, (low, high) in zip(at, ends, strict=True)] for at in product(shares, repeat=3)
    ]
    inside = {held(scene, hs.Hand("one", *x)).stable for x in grid}
    assert box
    assert box.share is Share(share)
    assert inside == {"all": {True}, "none": {False}}.get(share, {True, False})


def test_a_box_with_one_hand_that_rings_where_a_delay_has_turned_half_is_not_stable_as_a_whole() -> None:
    """s^2 + b s + s (1 + exp(-s)) + k is 0 at s = j pi for b = 0 and k = pi^2, and for no other hand of the box on the axis."""
    late = (hs.effects.delay("1 s"), hs.effects.shunt(b=1))
    scene = hs.Scene(hs.environments.mass_spring_damper(b=1), late)
    box = whole_box(scene, hs.Hand("box", 1, [0, 1], [9, 11]))
    assert box is not None
    assert box.share is Share.SOME
    assert float(box.meeting) == pytest.approx(np.pi, rel=1e-12)
    assert whole_box(scene, hs.Hand("softer", 1, [0, 1], [8, 9])).share is Share.ALL


def corners(hand: hs.Hand) -> list[hs.Hand]:
    return [hs.Hand("corner", *x) for x in product(*(p.interval or (p.value, p.value) for p in hand.parameters))]


def range_of(draw: Random, low: float, high: float) -> Any:
    """A number, a range, or one from 0 on."""
    a, b = (f"{x:.3g}" for x in sorted(draw.uniform(low, high) for _ in range(2)))
    return draw.choice([a, [a, b], [0, b]])


@pytest.mark.dear("19", "29")
@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(40))
def test_what_is_said_of_a_box_of_hands_holds_for_each_of_them(seed: int) -> None:
    draw = Random(seed)
    scene = drawn(draw, late=seed % 2 == 0)
    hand = hs.Hand(
        "any", range_of(draw, 0.05, 3), range_of(draw, 0.1, 25), [number(draw, 0, 50), number(draw, 51, 300)]
    )
    box = whole_box(scene, hand)
    assert box is not None
    counts = set()
    for _ in range(10):
        ends = [[float(x) for x in p.interval or (p.value, p.value)] for p in hand.parameters]
        inner = hs.Hand("inner", *(str(low + draw.random() * (high - low)) for low, high in ends))
        if inner.m.value > 0.02:  # the others have roots further out
            counts.add(winding(closed(scene, inner), 400.0))
    counts -= {None}
    assert box.share is not Share.ALL or counts <= {0}
    assert box.share is not Share.NONE or 0 not in counts
    assert len(counts) < 2 or box.share in (Share.SOME, None) or (box.share is Share.NONE and 0 not in counts)
    assert box.share is not None or box.reason
    if box.share is Share.SOME:
        assert {held(scene, x).stable for x in corners(hand)} == {True, False} or box.meeting is not None
    if (
        box.meeting is not None
    ):  # j omega is a root of some hand of the box: -Im H/omega is its damping, and -Re H its k - m omega^2
        w = float(box.meeting)
        H = (
            complex(scene.distortion().perceived.subs(s, 1j * w).evalf())
            if w
            else complex(scene.distortion().perceived.subs(s, 0))
        )
        (m, m_high), (b, b_high), (k, k_high) = (
            [float(x) for x in p.interval or (p.value, p.value)] for p in hand.parameters
        )
        slack = 1e-6 * (abs(H) + k_high + m_high * w * w)
        assert b * w - slack <= -H.imag <= b_high * w + slack
        assert k - m_high * w * w - slack <= -H.real <= k_high - m * w * w + slack


@pytest.mark.few("b2-none-None")
@pytest.mark.parametrize(
    ("b", "share", "omega"),
    [([3, 4], "some", 13.320697368492448), (["3.46359973277", 9], "all", None), ([1, "3.46359973276"], "none", None)],
)
def test_where_one_hand_of_a_box_alone_has_roots_on_the_axis_their_frequency_is_told(
    b: Any, share: str, omega: Any
) -> None:
    """Of a mass of 0.5 kg without stiffness that is a damping of 3.4635997327677 N s/m."""
    box = whole_box(hs.load_scene("delayed-spring"), hs.Hand("box", "1/2", b))
    assert box
    assert (box.share, box.meeting and float(box.meeting)) == (Share(share), omega and pytest.approx(omega))


def test_a_mass_behind_a_delay_leaves_a_chain_of_roots_in_hands_that_are_lighter_and_in_no_others() -> None:
    """H_perc = (s^2 + s + 5) exp(-s tau): with much damping all masses above 1 kg are stable; of those below alone all stays open."""
    scene = hs.Scene(E.mass_spring_damper(m=1, b=1, k=5), (F.delay("10 ms"),))
    for low, high, share in ((2, 3, "all"), ("1/5", 3, "some")):
        hand = hs.Hand("any", [low, high], 20, 50)
        box = whole_box(scene, hand)
        assert box is not None
        assert (box.share, box.meeting, box.reason) == (Share(share), None, "")
    for low, high in (("1/5", "1/2"), ("1/5", 1)):
        open_one = whole_box(scene, hs.Hand("any", [low, high], 20, 50))
        assert open_one is not None
        assert (open_one.share, bool(open_one.reason)) == (None, True)
    assert whole_box(scene, hs.Hand("one", 1, 2, 3)) is None


def test_between_masses_with_a_chain_of_roots_there_may_be_one_without() -> None:
    """H_perc = -40 s^2 q/(1 + 20 q), q = exp(-s/1000): m s^2 outweighs (20 m - 40) q s^2 between 40/21 and 40/19 kg alone."""
    port = F.two_port("-40", "0", "20/s^2", "1")
    scene = hs.Scene(E.mass_spring_damper(m=1), (F.delay("1 ms"), port))
    box = whole_box(scene, hs.Hand("box", m=[1, "2.5"], b=1, k=1))
    assert [held(scene, hs.Hand("one", m=m, b=1, k=1)).stable for m in (1, "1.75", 2, "2.5")] == [
        False,
        False,
        True,
        False,
    ]
    assert box
    assert box.share is not Share.NONE


# Every passive hand


@pytest.mark.parametrize("name", ["fu2019", "steering-wheel", "sidestick", FLEXIBLE, "desktop-device-soft-tissue"])
def test_displays_that_are_nowhere_active_are_held_by_every_passive_hand(name: str) -> None:
    found = hs.stability(name).to_dict()["every_passive_hand"]
    assert (found["holds"], found["active"]) == (True, [])


def test_a_spring_of_290_newtons_per_metre_needs_ten_and_a_half() -> None:
    found = hs.stability(hs.parse_scene(LATE.format(k=290)), digits=20).to_dict()["every_passive_hand"]
    assert (found["damping"], found["digits"], found["omega"]) == (10.44, "10.440000000000000000", 0)  # K tau


@pytest.mark.parametrize("name", ["satellite-contact", "four-channel-teleoperation"])
def test_no_damping_is_enough_where_a_mass_comes_late(name: str) -> None:
    found = hs.stability(name).every_passive_hand
    assert found.passivity is not None
    assert (found.holds, found.is_decided, found.passivity.is_unbounded, found.passivity.damping) == (
        False,
        True,
        True,
        None,
    )


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


# The answer and its document


ANSWERS: dict[str, tuple[Any, Any, bool]] = {
    "late spring": ("delayed-spring", ["light-touch", "postural-arm"], True),
    "no hand": ("delayed-spring", [], True),
    "satellite": ("satellite-contact", "postural-arm", True),
    "friction": ("stick-with-friction", "postural-arm", False),
    "a range": ("delayed-spring", hs.Hand("hand", "0.5 kg", "5 N*s/m +- 10 %", source="measured"), True),
    "a range that is open": (hs.Scene(E.mass_spring_damper(m=1, b=1, k=5), (F.delay("10 ms"),)), hs.Hand("any", ["1/5", 1], 20, 50), False),
    "a wall": ("virtual-wall", "light-touch", True),
}  # fmt: skip


@pytest.mark.few("no hand", "friction")
@pytest.mark.parametrize("case", ANSWERS)
def test_a_document_holds_what_the_answer_says_and_is_certified_where_nothing_was_left_open(case: str) -> None:
    scene, hands, certified = ANSWERS[case]
    answer = hs.stability(scene, hands, digits=9)
    told = json.loads(answer.to_json())
    assert (told["schema"], told["certified"], answer.certified) == ("haptisym.stability/1", certified, certified)
    assert told["imposed"] == {"stable": answer.imposed.stable, "unstable": answer.imposed.unstable}
    assert told["every_passive_hand"]["holds"] is answer.every_passive_hand.holds
    for x, row, near, box in zip(answer.held, told["held"], answer.critical, answer.boxes, strict=True):
        hand = row["hand"]
        assert [hand["name"], *(hand[p.key] for p in x.hand.parameters)] == [
            x.hand.name,
            *(float(p.value) for p in x.hand.parameters),
        ]
        ranges = {p.key: [float(end) for end in p.interval] for p in x.hand.parameters if p.interval}
        assert (hand.get("ranges", {}), hand.get("source", "")) == (ranges, x.hand.source)
        assert (row["stable"], row["unstable"], row.get("whole_box")) == (
            x.stable,
            x.unstable,
            box and box.share and box.share.value,
        )
        assert [(y["path"], y["value"]) for y in row["critical"]] == [
            (path, float(y.value)) for path, values in near.items() for y in values.ends
        ]
        own = {path: ExactNumber(answer.scene.knobs[path].value) for path in near}
        for y in row["critical"]:
            far = near[y["path"]].about(own[y["path"]]).verdict is not Verdict.HOLDS
            assert far or (y["stable_side"] == "above") == (y["value"] < float(own[y["path"]]))
        left = any(values.undecided for values in near.values())
        assert bool(row.get("undecided")) is bool(left or (box and box.reason))
        assert bool(row.get("reason")) is (x.stable is None)


def test_the_three_statements_about_a_late_spring_are_told_each_by_its_name() -> None:
    found = hs.stability("delayed-spring", ["light-touch", "postural-arm"], "k", digits=20).to_dict()
    assert found["imposed"] == {"stable": True, "unstable": 0}
    assert [(x["stable"], x["unstable"]) for x in found["held"]] == [(False, 2), (True, 0)]
    every = found["every_passive_hand"]
    assert (every["holds"], every["damping"], every["omega"]) == (False, 3.6, 0.0)
    assert every["active"][0] == pytest.approx([0, np.pi / 0.036])


def test_a_hand_is_the_scenes_own_before_one_that_is_shipped_and_a_given_one_is_itself() -> None:
    shipped = [*hs.hands]
    own, other = hs.Hand(shipped[0], 1, 2, 3), hs.Hand("mine", 4, 5, 6)
    scene, given = hs.Scene(SPRING, hands=(own, other)), hs.Hand("mine", 7, 8, 9)
    for asked, expected in (
        (None, (own, other)), ([], ()), (shipped[0], (own,)), ("mine", (other,)), (given, (given,)), ([given, shipped[0]], (given, own)),
        (shipped[1], (hs.hands[shipped[1]],)),
    ):  # fmt: skip
        found = [x.hand for x in hs.stability(scene, asked).held]
        assert [(x.name, x.m.value, x.b.value, x.k.value) for x in found] == [
            (x.name, x.m.value, x.b.value, x.k.value) for x in expected
        ]


def test_each_hand_is_asked_about_its_own_numbers_and_those_of_the_display() -> None:
    scene = hs.Scene(SPRING, hands=(hs.Hand("one", 1, 2, 3), hs.Hand("two", 4, 5, 6)))
    found = hs.stability(scene, free=["environment.k", "hands.one.b", "hands.two.m"])
    assert [[*sets] for sets in found.critical] == [
        [*(f"hands.{name}.{key}" for key in "mbk"), "environment.k"] for name in ("one", "two")
    ]


@pytest.mark.parametrize(
    ("scene", "hand", "free", "told"),
    [
        ("delayed-spring", "postral-arm", (), r'no hand "postral-arm": did you mean "postural-arm"\?'),
        ("delayed-spring", ["light-touch", "light-touch"], (), '"light-touch" is asked about twice'),
        ("delayed-spring", ["light-touch", hs.Hand("light-touch", 7)], (), "twice"),
        ("fu2019", "light-touch", "c", "is a threshold, which moves no root"),
        ("fu2019", None, "omega_n", "depend on the hand"),
        ("steering-wheel", "postural-arm", (), "translation and rotation cannot be mixed"),
        (hs.Scene(E.mass_spring_damper(k=Symbol("k", positive=True))), hs.Hand("any"), (), "k is a symbol"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_is_refused(scene: Any, hand: Any, free: Any, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        hs.stability(scene, hand, free)


# Hands of a scene


def test_what_is_felt_is_not_asked_of_a_hand() -> None:
    scene = hs.parse_scene(LATE.format(k=100) + "[hand]\nb = 4\n")
    for ask in (
        lambda: hs.derive(scene, ["hand.b"]),
        lambda: hs.require(scene, "hand.b"),
        lambda: hs.scene_code(scene, hs.Language.C, parameters=["b_h"]),
    ):
        with pytest.raises(hs.SceneError, match=r"^hand\.b does not change what is felt"):
            ask()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[hand]\nm = "-1 kg"', 'hand: m: "-1 kg" must be >= 0'),
        ("[hand]\nmass = 1", 'hand: unknown key "mass"'),
        ("[[hands]]\nm = 1", "each of several hands needs one"),
        ("[[hand]]\nm = 1", r"write \[hand\] for one"),
        ('[[hands]]\nname = "a"\n[[hands]]\nname = "a"', '"a" is there twice'),
        ('[hand]\nm = 1\n[[hands]]\nname = "a"', r"give either \[hand\] or \[\[hands\]\]"),
        ('[hand]\nm = "1 kg"\nb = "1 N*m*s/rad"', "translation and rotation cannot be mixed"),
        ('[hand]\nb = "1 N"', '"1 N" is not a damping'),
        ("[hand]\nsource = 3", 'source: "3" must be a string'),
    ],
)
def test_a_wrong_hand_in_a_file_is_refused(text: str, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        hs.parse_scene(LATE.format(k=100) + text)


def test_hands_have_knobs_that_change_nothing_of_what_is_felt() -> None:
    text = '[[hands]]\nname = "weak"\nb = ["1 N*s/m", "2 N*s/m"]\n[[hands]]\nname = "strong"\nb = 9\n'
    scene = hs.parse_scene(LATE.format(k=100) + text)
    assert [x.path for x in scene.parameters] == ["environment.k", "effects.delay.tau"]
    assert scene.nominal_but() == ""
    assert scene.knobs["hands.weak.b"].interval == (1, 2)
    assert [x.m.value for x in scene.with_values({"hands.strong.m": "2 kg"}).hands] == [0, 2]
    one = hs.parse_scene(LATE.format(k=100) + "[hand]\nm = 1\n")
    assert {one.knobs[x].path for x in ("hand.m", "hands.hand.m", "m_h")} == {"hand.m"}
    assert all(hs.hands[name].source for name in hs.hands)


# What nothing holds in place drifts, and need not shake


def arms(k: str = "0 N*m/rad", tau: Any = "2 ms") -> hs.Scene:
    units = {"Mm": "0.35 kg*m^2", "Bm": "3.85 N*m*s/rad", "Km": "350 N*m/rad"}
    own = {**units, **{f"{x[0]}s": y for x, y in units.items()}}
    link = F.position_position_teleoperator(**own, tau=tau, name="tele")
    return hs.Scene(E.mass_spring_damper(k=k), (link,), hands=(hs.Hand("light", "0.02 kg*m^2", "0.1 N*m*s/rad"),))


def test_two_arms_in_free_air_drift_and_shake_only_from_a_delay_on() -> None:
    found = hs.stability(arms(), free="tele.tau")
    own, [critical] = found.held[0], found.critical[0]["effects.tele.tau"].ends
    assert (own.stable, own.unstable, own.drifts, own.shakes) == (False, 1, 1, False)
    assert found.critical[0]["effects.tele.tau"].about(ExactNumber(Integer(0))).last == critical
    tau, omega = float(critical.value), float(critical.bindings[0].omega)

    def C(s: Any, late: float) -> Any:  # by hand
        return (0.37 * s**2 + 3.95 * s + 350) * (0.35 * s**2 + 3.85 * s + 350) - np.exp(-2 * s * late) * (
            3.85 * s + 350
        ) ** 2

    assert abs(C(1j * omega, tau)) < 1e-6 * abs(350 * (1j * omega) ** 2)
    for late, beyond in ((tau * 0.999, 0), (tau * 1.001, 2)):
        assert winding(lambda s, late=late: C(s + 1e-6, late), 500.0) == beyond
        assert held(arms(tau=Rational(late)), found.scene.hands[0]).unstable == 1 + beyond


CLOCKS = {
    "a handle that its damping stops": (F.shunt(m="0.1 kg", b="0.5 N*s/m"), "0 N/m", {}, 1, False),
    "a handle that nothing stops": (F.shunt(m="0.1 kg"), "0 N/m", {}, 2, False),
    "a handle that a wall holds": (F.shunt(m="0.1 kg", b="0.5 N*s/m"), "9 N/m", {}, 0, False),
    "a handle that a hand holds": (F.shunt(m="0.1 kg", b="0.5 N*s/m"), "0 N/m", {"k": "3 N/m"}, 0, False),
    "a wall that pushes as hard as the hand holds": (
        F.shunt(m="0.1 kg", b="0.5 N*s/m"),
        "-3 N/m",
        {"k": "3 N/m"},
        0,
        True,
    ),
}


@pytest.mark.parametrize("clock", [False, True])
@pytest.mark.parametrize("case", CLOCKS)
def test_a_root_at_0_is_a_drift_where_no_spring_is_and_none_where_two_cancel(case: str, *, clock: bool) -> None:
    device, k, springs, drifts, shakes = CLOCKS[case]
    effects = (F.sampled_loop("1 ms", "backward-difference"),) if clock else ()
    scene = hs.Scene(E.expression("K", parameters={"K": k}), (*effects, device))
    own = hs.Hand("own", m="0.3 kg", **springs)
    found = held(scene, own)
    assert (found.drifts, found.shakes, found.stable) == (drifts, shakes, not drifts and not shakes)
    assert found.unstable == max(drifts, int(shakes))


def test_free_air_has_a_verdict_about_shaking_and_no_ratio() -> None:
    page = str(hs.stability(arms()))
    assert "does not shake; drifts: nothing holds it in place" in page
    for ask in (hs.evaluate, hs.metrics):
        with pytest.raises(hs.SceneError, match="zero at every frequency: add mass"):
            ask(arms())
    family = hs.SceneFamily(
        {"spring": hs.Scene(hs.environments.kelvin_voigt(1, 1)), "air": hs.Scene(hs.environments.expression("0*s"))}
    )
    with pytest.raises(hs.SceneError, match='^environment "air": the environment is zero'):
        hs.evaluate_all(family)


def test_a_clock_that_holds_nothing_leaves_what_moves_alone() -> None:
    found = held(
        hs.Scene(E.mass_spring_damper(k=0), (F.zero_order_hold("10 ms"), F.shunt(m="0.2 kg"))), hs.hands["light-touch"]
    )
    assert (found.unstable, found.drifts, found.shakes) == (1, 1, False)


@dataclass(frozen=True)
class Hidden:
    """A mass M with s^2 + c s + d = (s - p)(s - q), felt through a hold as g (s - p)(s + a)/((s + e)(s + f)), or with a pair in both."""

    M: int
    moving: tuple[int, int]  # c, d, in eighths
    above: tuple[int, int]  # s^2 + ..., in eighths
    below: tuple[int, int]
    gain: int
    T: int  # ms
    on: int  # roots that the clock does not see on the circle

    @classmethod
    def drawn(cls, seed: int) -> Hidden:
        pick = random.Random(seed)
        p, e, f, a = pick.choice([0, 0, -1, 1, 2]), pick.randint(2, 9), pick.randint(10, 30), pick.randint(3, 20)
        if pick.random() < 0.3:  # s^2 + 4 in both
            moving, above, on = (0, 32), (0, 32), 2
        else:
            q = -pick.randint(1, 8)
            moving, above, on = (-8 * (p + q), 8 * p * q), (8 * (a - p), -8 * a * p), int(p == 0)
        return cls(
            pick.randint(1, 3), moving, above, (8 * (e + f), 8 * e * f), pick.randint(1, 60), pick.randint(5, 40), on
        )

    @property
    def scene(self) -> hs.Scene:
        (n1, n0), (d1, d0), (c, d) = self.above, self.below, self.moving
        felt = f"{self.gain}*(s^2 + {n1}/8*s + {n0}/8)/(s^2 + {d1}/8*s + {d0}/8)".replace("+ -", "- ")
        text = (
            f'[environment]\nmodel = "expression"\nH = "{felt}"\n[[effects]]\nmodel = "zero-order-hold"\nT = "{self.T} ms"\n'
            f'[[effects]]\nmodel = "shunt"\nm = {self.M}\nb = "{self.M * c}/8"\nk = "{self.M * d}/8"\n'
            "[hand]\nm = 0\n[evaluation]\nband = [0, 15]\n"
        )
        return hs.parse_scene(text)

    def sizes(self) -> Any:
        """|z| of position, velocity and the two states of the force, sampled exactly; the force of the last sample is held."""
        (n1, n0), (d1, d0), (c, d) = (np.array(x) / 8 for x in (self.above, self.below, self.moving))
        continuous = np.zeros((5, 5))  # x, v, y, y', and the force that is held
        continuous[0, 1] = continuous[2, 3] = 1
        continuous[1, :2], continuous[1, 4] = (-d, -c), -1 / self.M
        continuous[3, 0], continuous[3, 2:4] = 1, (-d0, -d1)
        over = expm(continuous * self.T / 1000)
        force = self.gain * np.array([1, 0, n0 - d0, n1 - d1])
        return np.abs(np.linalg.eigvals(over[:4, :4] + np.outer(over[:4, 4], force)))

    def is_clear(self) -> bool:
        """Whether floats tell all other roots from the circle."""
        return bool((np.sort(np.abs(self.sizes() - 1))[self.on :] > 1e-5).all())


@pytest.mark.dear("19")
@pytest.mark.few(12)
@pytest.mark.parametrize("seed", range(40))
def test_roots_are_those_of_the_whole_loop(seed: int) -> None:
    case = next(x for x in (Hidden.drawn(seed + 100 * n) for n in range(50)) if x.is_clear())
    assert (np.sort(np.abs(case.sizes() - 1))[: case.on] < 1e-7).all()
    found = held(case.scene, case.scene.hands[0])
    assert case.on == 2 or found.stable is not None
    assert found.unstable in (np.count_nonzero(case.sizes() > 1 - 1e-6), None)


@pytest.mark.slow
def test_a_damper_in_series_with_a_spring_holds_no_handle_also_behind_a_hold() -> None:
    """m s^2 + b s + H_perc(s) vanishes at s = 0: one root at z = 1, as without the hold; no damping of a hand mends it."""
    text = (
        '[environment]\nmodel = "maxwell"\nk = "100 N/m"\nb = "5 N*s/m"\n{}[hand]\nm = "1 kg"\nb = "1 N*s/m"\nk = 0\n'
    )
    late = hs.parse_scene(text.format('[[effects]]\nmodel = "zero-order-hold"\nT = "5 ms"\n'))
    plain = hs.parse_scene(text.format(""))
    assert [hs.stability(x).held[0].unstable for x in (late, plain)] == [1, 1]
    assert hs.require(late, "hand.b", ("0.1", "20"), that=("stable",)).feasible == ()


@pytest.mark.slow
def test_a_handle_without_mass_damping_and_stiffness_at_the_end_of_a_search_ends_no_answer() -> None:
    felt, loop = hs.environments.expression("1.2 + s/2"), hs.effects.sampled_loop("1 s", "backward-difference")
    found = hs.stability(hs.Scene(felt, (loop,), hands=(hs.Hand("mover", b=1),)))
    assert found.held[0].unstable is not None


def test_what_binds_a_sampled_loop_lies_on_the_unit_circle() -> None:
    """b of a centring spring at 60 Hz, one frame late, on a wheel of 0.04 kg m^2 and 0.1 N m s/rad: by eigenvalues."""
    text = (
        '[environment]\nmodel = "kelvin-voigt"\nk = 8\nb = 0\n[[effects]]\nmodel = "sampled-loop"\nT = "16.6666666667 ms"\n'
        'method = "backward-difference"\ndelay = 1\n[[effects]]\nmodel = "shunt"\nm = 0.04\nb = 0.1\n[hand]\nm = 0\n'
    )
    found = hs.require(hs.parse_scene(text), "environment.b", that=("stable",))
    [span] = found.feasible
    assert (span.low.digits(15), span.high.digits(15)) == ("0.107766452952012", "1.87491415916525")
    assert "unit circle" in str(found)
    assert "imaginary axis" not in str(found)


def test_a_hand_on_a_lever_has_the_square_of_its_length_times_mass_damping_and_stiffness() -> None:
    """By hand: 0.15^2 = 9/400 of 0.554 kg, 6.45 N s/m and 135 N/m, about the axis."""
    share, arm = Rational(9, 400), hs.hands["postural-arm"]
    levered = arm.on_lever("15 cm")
    assert [p.value for p in levered.parameters] == [p.value * share for p in arm.parameters]
    assert {p.motion for p in levered.parameters} == {MotionKind.ROTATION}
    wheel = hs.Scene(
        hs.environments.mass_spring_damper("0.05 kgm^2", "0.4 Nms/rad", "8 Nm/rad"),
        [hs.effects.first_order_lag("20 Hz")],
        ("0 Hz", "3 Hz"),
    )
    said = refusal(hs.stability, wheel, "postural-arm")
    assert "cannot be mixed" in said
    assert "--lever" in said
    by_hand = hs.Hand("arm", "0.012465 kg*m^2", "0.145125 N*m*s/rad", "3.0375 N*m/rad")
    answers = [hs.stability(wheel, x, "k").to_dict()["held"][0] for x in ("postural-arm at 15 cm", by_hand)]
    for x in answers:
        x.pop("hand")
    assert answers[0] == answers[1]
    text = '[environment]\nmodel = "kelvin-voigt"\nk = "8 Nm/rad"\nb = "0.4 Nms/rad"\n[hand]\nlever = "15 cm"\n'
    own = hs.parse_scene(text + 'm = "0.5 kg"\nb = ["4 N*s/m", "6 N*s/m"]\n[evaluation]\nband = [0, 9]').hands[0]
    assert (own.name, own.m.value, own.b.interval) == ("hand", share / 2, (4 * share, 6 * share))
    for length, why in (
        ("15 deg", "must be a length"),
        ("0 m", "must be a length > 0"),
        ("1 kg", "not a displacement"),
    ):
        assert why in refusal(arm.on_lever, length)
    assert "rotational already" in refusal(levered.on_lever, "1 m")
