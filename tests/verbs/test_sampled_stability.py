"""Displays with a clock in a hand: counts of roots against roots that were placed, eigenvalues and published walls."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from sampledloops import NOTHING, placed, w, wall
from sympy import Integer, Rational, prod

import haptisym as hs
from haptisym.verbs.stability.held import held, whole_box

E, F = hs.environments, hs.effects
DEVICE = {"m": "0.04", "b": "0.8"}
P3 = hs.Hand("P3", b=8, k=400)
SUN = {"m": "0.032", "b": "3.62"}
SIDES = (1 - 1e-13, 1 + 1e-13)


def spring(
    K: Any, B: Any = 0, T: str = "1 ms", delay: int = 0, device: dict[str, str] = DEVICE,
    method: str = "backward-difference",
) -> hs.Scene:  # fmt: skip
    felt = E.kelvin_voigt(K, B) if B else E.mass_spring_damper(k=K)
    return hs.Scene(felt, (F.sampled_loop(T, method, delay), F.shunt(**device)))


# --- in one hand ------------------------------------------------------------------------------------------------------

PUBLISHED: dict[str, tuple[float, dict[str, Any], hs.Hand]] = {
    "held by nothing": (1605.35113477512, {}, NOTHING),
    "one sample late": (536.278559788946, {"delay": 1}, NOTHING),
    "two": (322.743931195746, {"delay": 2}, NOTHING),
    "three": (231.251826734561, {"delay": 3}, NOTHING),
    "T = 5 ms": (325.422809758905, {"T": "5 ms"}, NOTHING),
    "in a hand": (18284.7872144337, {}, P3),
    "in a hand, T = 5 ms": (4387.83474049539, {"T": "5 ms"}, P3),
    "in a hand without damping": (1606.69137940911, {}, hs.Hand("k", k=400)),
    "B = 0.4": (2384.3034697805, {"B": "0.4"}, NOTHING),
    "KTU": (2001.66805601833, {"device": {"m": "0.05", "b": "0.5"}, "T": "0.5 ms"}, NOTHING),
    "b = 0.1": (200.083368061341, {"device": {"m": "0.04", "b": "0.1"}}, NOTHING),
    "Sun": (7379.09706084562, {"device": SUN}, NOTHING),
    "Sun, in a hand": (18273.4389482611, {"device": SUN}, hs.Hand("Sun", "0.8", "5.5", "30")),
}
"""The stiffest walls that are held, N/m."""


@pytest.mark.parametrize("case", PUBLISHED)
def test_a_wall_is_stable_up_to_the_published_stiffness(case: str) -> None:
    K, keys, hand = PUBLISHED[case]
    told = [held(spring(repr(K * x), **keys), hand) for x in SIDES]
    assert [(x.stable, x.unstable) for x in told] == [(True, 0), (False, 2)]


FILTERED = "k + b*s*w/(s + w)"


def filtered(delay: int, K: float = 500, b: str = "0", corner: str = "50 Hz") -> hs.Scene:
    felt = E.expression(FILTERED, parameters={"k": repr(K), "b": 3, "w": corner})
    return hs.Scene(felt, (F.sampled_loop("1 ms", "backward-difference", delay), F.shunt(m="45 g", b=b)))


def late(K: float) -> hs.Scene:
    chain = F.sampled_loop("1 ms", "tustin"), F.delay("1 ms"), F.shunt(**DEVICE)
    return hs.Scene(E.mass_spring_damper(k=repr(K)), chain)


def force_held(K: float) -> hs.Scene:
    return hs.Scene(E.mass_spring_damper(k=repr(K)), (F.zero_order_hold("1 ms"), F.shunt(**DEVICE)))


@pytest.mark.parametrize(
    ("scene", "K"),
    [
        (lambda K: filtered(1, K, corner="314.159"), 1124.64856112794), (late, PUBLISHED["one sample late"][0]),
        (force_held, PUBLISHED["held by nothing"][0]),
    ],
    ids=["filtered", "late by a delay", "force held"],
)  # fmt: skip
def test_a_wall_made_in_another_way_is_held_as_far_as_its_equal(scene: Any, K: float) -> None:
    """The filtered one as published; a delay of a sample is a sample of computation; a spring before a hold is one behind its sampler."""
    assert [held(scene(K * x), NOTHING).stable for x in SIDES] == [True, False]


@given(beta=st.fractions(min_value=Rational(1, 50), max_value=Rational(19, 10), max_denominator=60))
@examples(10)
def test_without_damping_the_boundary_is_alpha_of_beta_exactly(beta: Any) -> None:
    """alpha = K T^2/m = 2 beta (2 - beta)/(2 + beta), beta = B T/m: on it a pair lies on the circle, which stays open."""
    beta = Rational(beta.numerator, beta.denominator)
    alpha = 2 * beta * (2 - beta) / (2 + beta)
    shares = Rational(99, 100), 1, Rational(101, 100)
    found = [held(spring(alpha * x, beta, "1 s", device={"m": "1"}), NOTHING) for x in shares]
    assert [(x.unstable, x.stable) for x in found] == [(0, True), (None, None), (2, False)]
    assert "on the unit circle" in found[1].reason


@pytest.mark.parametrize(
    ("delay", "alpha", "beta"),
    [
        (0, 0.686291501015240, 0.828427124746190), (1, 0.144469349226052, 0.424693789882598),
        (2, 0.0624304893523135, 0.291392227931262),
    ],
)  # fmt: skip
def test_the_stiffest_wall_without_damping(delay: int, alpha: float, beta: float) -> None:
    def stable(a: float, b: float) -> bool | None:
        return held(spring(repr(a), repr(b), "1 s", delay, {"m": "1"}), NOTHING).stable

    assert stable(alpha * (1 - 1e-12), beta)
    assert not any(stable(alpha * (1 + 1e-12), beta * (1 + x)) for x in (-1e-3, -1e-5, 0, 1e-5, 1e-3))


FACTORS: list[tuple[Any, int, int]] = [
    (1 - w, 0, 1), (1 + w, 0, 1), (1 + w / 2 + w**2, 0, 2), (1 - 2 * w / 3 + w**2, 0, 2),  # on the circle
    (1 - w / 2, 0, 0), (1 + w / 3, 0, 0), (1 - w / 3 + w**2 / 2, 0, 0),  # inside
    (1 - Rational(1001, 1000) * w, 1, 0), (1 + 2 * w, 1, 0), (1 - w / 2 + 2 * w**2, 2, 0),  # outside
]  # fmt: skip
"""Of 1/z, and how many roots z lie outside of the circle, and on it."""


@pytest.mark.parametrize("seed", range(12))
def test_roots_that_were_placed_are_counted_where_they_are(seed: int) -> None:
    """Also several at one place, and on both sides of the circle; on it one at 1 alone is told."""
    draw = random.Random(seed)
    chosen = [draw.choice(FACTORS) for _ in range(draw.randint(1, 3))]
    found = held(placed(prod(x for x, *_ in chosen), {}), NOTHING).roots
    outside, on = (sum(x[i] for x in chosen) for i in (1, 2))
    at_1 = sum(x == 1 - w for x, *_ in chosen)
    told = (found.number, found.right) if found else None
    assert told == ((outside + on, outside) if on == at_1 < 2 else None)


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(40))
def test_roots_are_eigenvalues_of_what_a_period_does(seed: int) -> None:
    """Late by samples and by parts of one, with either rule, with a soft drive between device and hand, in a wall of any size."""
    draw = random.Random(seed)
    own = wall(draw)
    k, b = draw.choice([20.0, 700.0, 9000.0, -30.0]), draw.choice([0.0, 2.0, 9.0, -1.0])
    sizes = abs(own.eigenvalues(k=k, b=b))
    assert abs(sizes - 1).min() > 1e-9
    scene = own.scene.with_values({"environment.k": repr(k), "environment.b": repr(b)})
    told = held(scene, scene.hands[0])
    assert (told.unstable, told.stable) == ((sizes >= 1).sum(), (sizes < 1).all())


@pytest.mark.parametrize("seed", range(4))
def test_a_force_made_in_continuous_time_is_sampled_as_it_is(seed: int) -> None:
    """A spring behind a lag before the hold: its state is one more of the plant."""
    draw = random.Random(seed)
    k, corner, m, b, T = draw.choice([200, 3000]), draw.choice([9, 200]), 0.25, draw.choice([0.5, 4]), 0.005
    A = np.array([[0, 1, 0, 0], [0, -b / m, 0, 1 / m], [corner, 0, -corner, 0], [0, 0, 0, 0]])
    moved = wall_step(A, T)
    sizes = abs(np.linalg.eigvals(moved[:3, :3] + np.outer(moved[:3, 3], [0, 0, -k])))
    chain = F.first_order_lag(corner), F.zero_order_hold("5 ms"), F.shunt(m="0.25", b=b)
    assert held(hs.Scene(E.mass_spring_damper(k=k), chain), NOTHING).unstable == (sizes >= 1).sum()


def wall_step(A: Any, T: float) -> Any:
    """exp(A T), by its series."""
    found, term = np.eye(len(A)), np.eye(len(A))
    for n in range(1, 40):
        term = term @ A * (T / n)
        found = found + term
    return found


@pytest.mark.parametrize("damper", ["1/2", "3", "40"])
def test_what_leaves_the_place_free_has_a_root_at_one(damper: str) -> None:
    """A damper in a clock; too large a one shakes besides: z^2 (z - p) + D (z - 1) by NumPy."""
    scene = hs.Scene(
        E.mass_spring_damper(b=damper), (F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="0.01", b="0.3"))
    )
    D, b, T = float(Rational(damper)), 0.3, 0.001
    p = np.exp(-b * T / 0.01)
    x, y = (
        T / b - 0.01 / b**2 * (1 - p),
        0.01 / b**2 * (1 - p) - T * p / b,
    )  # 1/(s (m s + b)) held: (x z + y)/((z - 1)(z - p))
    sizes = abs(np.roots(np.polyadd([1, -p, 0], D / T * np.array([x, y]))))
    assert held(scene, NOTHING).unstable == 1 + (sizes >= 1).sum()


REASONS = {
    "two clocks": ((F.zero_order_hold("1 ms"), F.zero_order_hold("2 ms"), F.shunt(m="0.1")), "two samplers"),
    "a line": ((F.sampled_loop("1 ms", "tustin"), F.wave_variables(3, "5 ms")), "a delay returns between sampler and hand"),
    "friction": ((F.sampled_loop("1 ms", "tustin"), F.coulomb_friction("0.1", "1 cm"), F.shunt(m="0.1")), "friction"),
    "nothing": ((F.sampled_loop("1 ms", "tustin"),), "nothing that has mass"),
    "a power of s": ((F.sampled_loop("1 ms", "tustin"), F.shunt(Z="s^2 + s^(1/2)")), "a power of s returns"),
    "no force": ((F.sampled_loop("1 ms", "tustin"), F.series("0*s"), F.shunt(m=1)), "does not reach the hand"),
    "an impulse": ((F.sampled_loop("1 ms", "tustin"), F.series("s^3/(s + 1)"), F.shunt(b=1)), "by an impulse"),
}  # fmt: skip


@pytest.mark.parametrize("case", REASONS)
def test_what_is_not_decided_is_said(case: str) -> None:
    effects, words = REASONS[case]
    found = held(hs.Scene(E.mass_spring_damper(k=100), effects), NOTHING)
    assert found.stable is None
    assert words in found.reason


# --- in every passive hand ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "digits", "theta", "holds"),
    [
        (spring(100, 1, delay=1), "1.05125000000000", 1.545793721895536, False),
        (spring(1599), "0.799500000000000", None, True),
        (spring(1600), "0.800000000000000", None, False),  # what the device has must exceed it
        (spring(1600, delay=2), "4.00000000000000", 0.0, False),
        (spring(800, "0.4"), "0.800000000000000", 3.141592653589793, False),
        (spring(100, method="tustin"), "0.0500000000000000", None, True),
        (filtered(1, b="1"), "1.37175489996054", 0.80523027, False),
        (filtered(0, b="1"), "0.657265744490900", 3.14159265, True),
    ],
)  # fmt: skip
def test_every_passive_hand_asks_the_published_damping_of_the_device(
    scene: hs.Scene, digits: str, theta: float | None, *, holds: bool
) -> None:
    told = hs.stability(scene).to_dict()
    assert told["sampled"]["digits"] == digits
    assert theta is None or told["sampled"]["theta"] == pytest.approx(theta, abs=2e-8)
    assert (told["every_passive_hand"]["holds"], told["sampled"]["passive"]) == (holds, holds)


def test_what_the_device_lacks_a_hand_makes_up_for() -> None:
    told = hs.stability(filtered(1, b="1")).to_dict()["every_passive_hand"]
    assert told["damping"] == pytest.approx(0.3717548999605444, rel=1e-14)


def test_where_the_condition_does_not_apply_a_reason_is_given() -> None:
    chain = F.sampled_loop("1 ms", "tustin"), F.compliance(k=5000), F.shunt(m="0.1")
    told = hs.stability(hs.Scene(E.mass_spring_damper(k=100), chain)).to_dict()["sampled"]
    assert (told["passive"], told["damping_needed"]) == (None, None)
    assert "between sampler and hand" in told["reason"]


def test_a_passive_display_is_stable_in_every_hand_that_is_tried() -> None:
    scene = spring(1590)
    for m in ("0", "0.3", "4"):
        for b, k in ((0, 0), (0, 4000), (2, 90)):
            assert held(scene, hs.Hand("any", m, b, k)).stable


# --- in hands with ranges -----------------------------------------------------------------------------------------------


@pytest.mark.few("1700-b1-some")
@pytest.mark.parametrize(
    ("K", "b", "share"), [(1000, [0, 1], "all"), (1700, [0, 1], "some"), (9000, [0, 1], "none"), (3000, [2, 4], "all")]
)  # fmt: skip
def test_a_box_of_hands_holds_a_sampled_wall_or_does_not(K: int, b: list[int], share: str) -> None:
    """Up to 1605.35 N/m with nothing, about 2 (0.8 + b_h)/T in a hand."""
    [row] = hs.stability(spring(K), hs.Hand("mine", b=b), "environment.k").to_dict()["held"]
    assert row["whole_box"] == share


@pytest.mark.dear("0")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(12))
def test_what_is_said_of_a_box_of_hands_with_a_clock_holds_for_each_of_them(seed: int) -> None:
    draw = random.Random(seed)
    own = wall(draw, plain=True)
    k = draw.choice([100.0, 900.0, 4000.0])
    ends = {key: sorted(round(draw.uniform(*x), 3) for _ in range(2)) for key, x in RANGES.items()}
    radii = [
        own.radius(k=k, b=0, **{f"{key}_h": draw.choice([a, b, draw.uniform(a, b)]) for key, (a, b) in ends.items()})
        for _ in range(12)
    ]
    hand = hs.Hand("any", **{key: [repr(x) for x in pair] for key, pair in ends.items()})
    found = whole_box(own.scene.with_values({"environment.k": repr(k), "environment.b": Integer(0)}), hand)
    assert found is not None
    stable = {x < 1 for x in radii}
    assert found.share is not None or found.reason
    assert stable == {True} or found.share is None or found.share.value != "all"
    assert stable == {False} or found.share is None or found.share.value != "none"


RANGES = {"m": (0.05, 0.4), "b": (0.1, 20), "k": (5, 200)}
