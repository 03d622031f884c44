"""How far a number of a neutral loop may go: against winding numbers of sampled contours, and closed forms."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import Rational
from windings import late_mass, winding

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.stability.critical import Critical
from haptisym.verbs.stability.critical import critical as nearest
from haptisym.verbs.stability.held import held
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.rightroot import RightRoots

PATHS = ["environment.m", "environment.b", "environment.k", "hand.m", "hand.b", "hand.k"]
LATE = """
environment = {{ model = "mass-spring-damper", m = {0}, b = {1}, k = {2} }}
effects = [{{ model = "delay", tau = {6} }}]
hand = {{ m = {3}, b = {4}, k = {5} }}
"""


def satellite(b: float, k: float, m: float = 600) -> hs.Hand:
    return hs.Hand("hand", m=m, b=b, k=k)


def critical(scene: str | hs.Scene, hand: hs.Hand, path: str) -> tuple[Critical, ...]:
    own = (hs.load_scene(scene) if isinstance(scene, str) else scene).with_hands(hand)
    found = nearest(own, own.hands[0], own.knobs[path])
    assert not found.reason
    return found.found


def count(numbers: list[float], lag: float, most: float = 1e4) -> float | None:
    """Of a late mass in a hand, by its contour; infinite beside a chain; None where the delay turns further than ``most``."""
    loop = late_mass((numbers[0], numbers[1], numbers[2]), (numbers[3], numbers[4], numbers[5]), lag)
    if loop is None:
        return inf
    f, reach = loop
    return winding(f, reach) if reach * lag < most else None


def test_a_hand_that_damps_much_holds_the_satellite_as_soon_as_it_is_heavier() -> None:
    """b^2 - 2 m k + 2 500 11691 - 131.4^2 > 0: far out |m s^2 + b s + k| > |500 s^2 + 131.4 s + 11691| on the axis."""
    [found] = critical("satellite-contact", satellite(5000, 0), "hand.m")
    assert (float(found.value), found.below, found.above, found.stable_side) == (500, None, 0, "above")
    for mass in (501, 505, 600, 5000):
        assert count([500, 131.4, 11691, mass, 5000, 0], 0.108) == 0


def test_between_the_mass_at_which_a_chain_is_lost_and_the_next_critical_one_one_count_holds() -> None:
    chain, shaking = critical("satellite-contact", satellite(300, 5000, 505), "hand.m")
    assert (float(chain.value), chain.below, chain.above, chain.stable_side) == (500, None, 0, "above")
    assert (shaking.below, shaking.above, shaking.stable_side) == (0, 2, "below")
    assert float(shaking.value) == pytest.approx(576.650343874, rel=1e-11)
    for mass, expected in ((500.5, 0), (540, 0), (576.6, 0), (576.7, 2)):
        assert count([500, 131.4, 11691, mass, 300, 5000], 0.108) == expected


def test_in_a_hand_that_damps_little_a_chain_that_is_lost_leaves_two_roots() -> None:
    [found] = critical("satellite-contact", satellite(100, 0), "hand.m")
    assert (float(found.value), found.below, found.above, found.stable_side) == (500, None, 2, None)
    for mass in (500.5, 505, 600, 5000):
        assert count([500, 131.4, 11691, mass, 100, 0], 0.108) == 2


def ends(found: Requirement) -> list[float]:
    return [float(x.value) for span in found.feasible for x in (span.low, span.high) if x.value is not None]


@pytest.mark.slow
def test_where_more_and_more_roots_stay_behind_a_chain_no_value_beside_it_will_do() -> None:
    """A hand of 20 kN/m: m k outweighs 500 11691, and so roots lie on the axis at ever higher frequencies as m falls to 500."""
    hand = satellite(100, 20000, 400)
    found = hs.require("satellite-contact", "hand.m", that="stable", hand=hand)
    assert ends(found) == pytest.approx([509.842, 1151.41], rel=1e-5)
    assert (found.undecided, found.reason) == ((), "")
    scene = hs.load_scene("satellite-contact")
    for mass, expected in ((500.5, 4), (502, 2), (509.8, 2), (509.9, 0), (1151, 0), (1152, 2)):
        assert count([500, 131.4, 11691, mass, 100, 20000], 0.108) == expected
        assert held(scene, satellite(100, 20000, mass)).unstable == expected
    [near] = critical("satellite-contact", hand, "hand.m")
    assert (near.below, near.stable_side, near.is_crowded) == (None, None, True)


def test_a_root_on_the_right_is_proven_for_whole_intervals_and_for_none_that_holds_a_stable_value() -> None:
    scene = hs.load_scene("satellite-contact").with_hands(satellite(100, 20000))
    right = RightRoots(Loop.of(scene, scene.hands[0], scene.knobs["hand.m"]))

    def everywhere(low: str, high: str) -> bool:
        return right.everywhere(ExactNumber(Rational(low)), ExactNumber(Rational(high)))

    assert everywhere("500", "500.1")
    assert everywhere("508", "509")
    assert not everywhere("509", "510")
    assert not everywhere("600", "600")


@pytest.mark.slow
def test_beyond_what_was_looked_at_values_are_told_as_open() -> None:
    tissue = hs.environments.mass_spring_damper("0.15 kg", 0, 23)
    own = hs.Scene(tissue, (hs.effects.delay("20 ms"),)).with_hands(hs.Hand("hand", m="1.8 kg", b=14, k=196))
    found = hs.require(own, "hand.k", that="stable")
    assert ends(found)[:2] == pytest.approx([0, 56493.4], rel=1e-5)
    [(low, high)] = found.undecided
    assert (float(low or 0) > 5e6, high) == (True, None)
    assert "critical values come as near to one as one likes" in found.reason


def test_a_chain_is_there_as_long_as_there_is_a_delay() -> None:
    light = satellite(100, 0, 400)
    [delay] = critical("satellite-contact", light, "tau")
    assert (float(delay.value), delay.below, delay.above) == (0, 0, None)
    found = hs.require("satellite-contact", "tau", that="stable", hand=light)
    assert ([float(x) for x in ends(found)], found.undecided) == ([0, 0], ())


def test_delays_that_are_multiples_of_one_for_few_values_alone_are_not_said_to_be_alike_for_all() -> None:
    """1 + 0.6 exp(-s/100) + 0.6 exp(-s/100 - s tau): no chain at tau = 10 ms, where zeros multiply to 1/0.6, one at 12 ms."""
    late = hs.effects.delay("10 ms")
    own = hs.Scene(
        hs.environments.mass_spring_damper("0.6 kg", 1, 10), (hs.effects.delay("12 ms"), hs.effects.shunt(m="0.6 kg"), late),
    ).with_hands(hs.Hand("hand", m=1, b=8, k=3))  # fmt: skip
    found = nearest(own, own.hands[0], own.knobs["effects.delay.tau"])
    assert (found.found, "no multiples of one" in found.reason) == ((), True)
    alike = own.with_values({"effects.delay.tau": "10 ms"})
    assert (held(own, own.hands[0]).stable, held(alike, own.hands[0]).stable) == (False, True)


def test_a_chain_that_no_mass_of_a_hand_moves_is_there_for_all_of_them() -> None:
    """m s^2 D(exp(-s ms)), D of the display alone: its zeros inside the circle stay where they are."""
    late, link = hs.effects.delay("10 ms"), hs.effects.wave_variables("5 N*s/m", "7 ms")
    own = hs.Scene(hs.environments.kelvin_voigt("200 N/m", "2 N*s/m"), (late, link))
    own = own.with_hands(hs.Hand("hand", m="0.5 kg", b=30, k=100))
    assert critical(own, own.hands[0], "hand.m") == ()
    for mass in ("1 g", "5 kg", "100 t"):
        assert held(own, hs.Hand("hand", m=mass, b=30, k=100)).unstable is None


def test_a_heavy_hand_is_held_between_two_masses() -> None:
    found = hs.require("satellite-contact", "hand.m", (501, 2000), that="stable", hand=satellite(100, 20000))
    assert ends(found) == pytest.approx([509.842, 1151.41], rel=1e-5)
    assert not found.undecided
    for mass, expected in ((509.84, 2), (509.85, 0), (1151.4, 0), (1151.5, 2)):
        assert count([500, 131.4, 11691, mass, 100, 20000], 0.108) == expected


@pytest.mark.slow
def test_four_channels_are_held_again_by_a_stiffer_environment() -> None:
    found = hs.require(
        "four-channel-teleoperation", "environment.k", that="stable", hand=hs.Hand("hand", m=1, b=1, k=10)
    )
    assert ends(found) == pytest.approx([0, 5972.49797743441, 775971, 1120950], rel=1e-5)


def test_a_wave_variable_link_holds_whatever_the_damping_of_a_hand_without_mass() -> None:
    found = hs.require("wave-variable-link", "hand.b", that="stable", hand="firm-grip")
    assert [(float(x.low.value), x.low.closed, x.high.value) for x in found.feasible] == [(0, False, None)]
    assert not found.undecided
    [damping] = critical("wave-variable-link", hs.hands["firm-grip"], "hand.b")
    assert (float(damping.value), damping.above, damping.stable_side) == (0, 0, "above")


@pytest.mark.slow
def test_where_two_delayed_masses_meet_the_chain_is_lost_at_the_zeros_on_the_circle() -> None:
    """q + z/2 + z^2: its two zeros have the product q and lie on |z| = 1 at q = 1, not where q is the sum 3/2."""
    late = hs.effects.delay("10 ms")
    scene = hs.Scene(
        hs.environments.mass_spring_damper("1 kg", "1 N*s/m", "10 N/m"), (late, hs.effects.shunt(m="0.5 kg"), late)
    )
    [mass] = critical(scene, hs.Hand("hand", m="0.9 kg", b=8), "hand.m")
    assert mass.value.digits(20) == "1.0000000000000000000"
    assert mass.below is None
    roots = held(scene, hs.Hand("hand", m="1.1 kg", b=8)).roots
    assert roots is not None
    assert roots.chain is None


sizes = st.tuples(
    st.sampled_from([1, 2, 5]), st.sampled_from([1, 3, 10, 30]), st.sampled_from([3, 40, 700]),
    st.sampled_from(["0.5", 4, 12]), st.sampled_from([0, "0.7", 9, 80]), st.sampled_from([0, 6, 300, 2000]), st.sampled_from(["0.01", "0.06", "0.3"]),
)  # fmt: skip


def asked(found: Requirement, value: float) -> Iterator[float]:
    """Values on both sides of each end, and further ones."""
    for end in ends(found):
        yield from (end * 0.999, end * 1.001)
    yield from (value * x for x in (0.2, 0.9, 1.6, 7))


def verdict(found: Requirement, value: float) -> bool | None:
    """Whether a value is in the set; None where that is open."""
    if any((a is None or float(a) <= value) and (b is None or value <= float(b)) for a, b in found.undecided):
        return None
    lows = [(-inf if x.low.value is None else float(x.low.value)) for x in found.feasible]
    highs = [(inf if x.high.value is None else float(x.high.value)) for x in found.feasible]
    return any(low < value < high for low, high in zip(lows, highs, strict=True))


@pytest.mark.slow
@settings(max_examples=5, deadline=None)
@given(sizes, st.sampled_from(range(6)))
def test_random_late_masses_are_held_where_their_contours_wind_around_no_root(
    numbers: tuple[object, ...], i: int
) -> None:
    scene = hs.parse_scene(LATE.format(*map(float, map(Rational, map(str, numbers)))))
    *row, lag = (float(Rational(str(x))) for x in numbers)
    base = row[i] or 1.0
    found = hs.require(scene, PATHS[i], (base / 20, base * 20), that="stable")
    for value in (x for x in asked(found, base) if base / 20 < x < base * 20):
        told = verdict(found, value)
        wound = count([*row[:i], value, *row[i + 1 :]], lag, 2e3)
        assert told is None or wound is None or told == (wound == 0), (value, told, wound)


@pytest.mark.few(3)
@pytest.mark.parametrize("mass", ["1/2", "99/100", "1", "101/100", "2"])
def test_the_delays_that_will_do_do_not_hang_on_the_one_that_a_scene_has_not_even_if_it_is_0(mass: str) -> None:
    """m s^2 + M s^2 exp(-s tau) + b s + k: with M >= m no delay but 0 will do, as a chain of roots comes."""
    felt, hand = hs.environments.mass_spring_damper(m=mass), hs.Hand("mine", m=1, b=1, k=1)
    found = [
        hs.require(hs.Scene(felt, (hs.effects.delay(x),), hands=(hand,)), "tau", that="stable").to_dict()
        for x in ("0 ms", "1 ms", "3 s")
    ]
    assert found[0] == found[1] == found[2]
    assert found[0]["certified"]
    assert (found[0]["feasible"] == [[0.0, 0.0]]) is bool(Rational(mass) >= 1)
