"""Displays with a clock, held in a hand and in every passive hand: the published table, and simulation as a witness."""

from __future__ import annotations

import json
import random
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Integer, N, Rational, Symbol, exp, pi

import haptisym as hs
from haptisym.judge.colgate import sampled_passivity
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import s as symbol
from haptisym.model.hand import Hand
from haptisym.verbs.stability.clockcritical import opened
from haptisym.verbs.stability.clocked import plant_of
from haptisym.verbs.stability.clockrange import passages
from haptisym.verbs.stability.held import held
from haptisym.verbs.stability.oncircle import OnCircle, halves

E, F = hs.environments, hs.effects
FREE = Hand("let go")
DEVICE = {"m": "0.04", "b": "0.8"}


def wall(
    K: Any,
    B: Any = 0,
    T: str = "1 ms",
    delay: int = 0,
    device: dict[str, str] = DEVICE,
    method: str = "backward-difference",
) -> hs.Scene:
    environment = E.kelvin_voigt(K, B) if B else E.mass_spring_damper(k=K)
    return hs.Scene(environment, (F.sampled_loop(T, method, delay), F.shunt(**device)))


P3 = Hand("P3", b=8, k=400)
SUN = {"m": "0.032", "b": "3.62"}
TABLE: dict[str, tuple[float, dict[str, Any], Hand]] = {
    "held by nothing": (1605.35113477512, {}, FREE),
    "one sample late": (536.278559788946, {"delay": 1}, FREE),
    "two": (322.743931195746, {"delay": 2}, FREE),
    "three": (231.251826734561, {"delay": 3}, FREE),
    "T = 5 ms": (325.422809758905, {"T": "5 ms"}, FREE),
    "in a hand": (18284.7872144337, {}, P3),
    "in a hand, T = 5 ms": (4387.83474049539, {"T": "5 ms"}, P3),
    "in a hand without damping": (1606.69137940911, {}, Hand("k", k=400)),
    "B = 0.4": (2384.3034697805, {"B": "0.4"}, FREE),
    "KTU": (2001.66805601833, {"device": {"m": "0.05", "b": "0.5"}, "T": "0.5 ms"}, FREE),
    "b = 0.1": (200.083368061341, {"device": {"m": "0.04", "b": "0.1"}}, FREE),
    "Sun": (7379.09706084562, {"device": SUN}, FREE),
    "Sun, in a hand": (18273.4389482611, {"device": SUN}, Hand("Sun", "0.8", "5.5", "30")),
}


@pytest.mark.parametrize("case", TABLE)
def test_a_wall_is_stable_up_to_the_published_stiffness(case: str) -> None:
    K, keys, hand = TABLE[case]
    below, above = (held(wall(repr(K * (1 + sign * 1e-13)), **keys), hand) for sign in (-1, 1))
    assert (below.stable, below.unstable) == (True, 0)
    assert (above.stable, above.unstable) == (False, 2)


FILTERED = "k + b*s*w/(s + w)"


def test_the_filtered_wall_let_go() -> None:
    def scene(K: float) -> hs.Scene:
        H = E.expression(FILTERED, parameters={"k": repr(K), "b": 3, "w": "314.159"})
        return hs.Scene(H, (F.sampled_loop("1 ms", "backward-difference", 1), F.shunt(m="45 g")))

    assert [held(scene(1124.64856112794 * f), FREE).stable for f in (1 - 1e-13, 1 + 1e-13)] == [True, False]


@given(beta=st.fractions(min_value=Rational(1, 50), max_value=Rational(19, 10), max_denominator=60))
def test_without_damping_the_boundary_is_alpha_of_beta_exactly(beta: Any) -> None:
    """alpha = K T^2/m = 2 beta (2 - beta)/(2 + beta), beta = B T/m: on it a pair lies on the circle, exactly."""
    beta = Rational(beta.numerator, beta.denominator)
    alpha = 2 * beta * (2 - beta) / (2 + beta)
    found = [
        held(wall(alpha * f, beta, "1 s", device={"m": "1"}), FREE).roots
        for f in (Rational(99, 100), 1, Rational(101, 100))
    ]
    assert [(x.number, x.right) for x in found if x] == [(0, 0), (2, 0), (2, 2)]


LARGEST = [
    (0, 0.686291501015240, 0.828427124746190),
    (1, 0.144469349226052, 0.424693789882598),
    (2, 0.0624304893523135, 0.291392227931262),
]


@pytest.mark.parametrize(("delay", "alpha", "beta"), LARGEST)
def test_the_stiffest_wall_without_damping(delay: int, alpha: float, beta: float) -> None:
    def stable(a: float, b: float) -> bool | None:
        return held(wall(repr(a), repr(b), "1 s", delay, {"m": "1"}), FREE).stable

    assert stable(alpha * (1 - 1e-12), beta)
    assert not any(stable(alpha * (1 + 1e-12), beta * (1 + x)) for x in (-1e-3, -1e-5, 0, 1e-5, 1e-3))


def test_late_by_a_delay_or_by_samples_is_the_same() -> None:
    """The delay effect behind a clock that samples at once, and whole samples of computation."""
    K = 536.278559788946
    for factor, stable in ((1 - 1e-13, True), (1 + 1e-13, False)):
        late = hs.Scene(
            E.mass_spring_damper(k=repr(K * factor)),
            (F.sampled_loop("1 ms", "tustin"), F.delay("1 ms"), F.shunt(**DEVICE)),
        )
        assert held(late, FREE).stable is stable
        assert held(wall(repr(K * factor), delay=1), FREE).stable is stable


def test_a_spring_before_a_hold_is_a_spring_behind_its_sampler() -> None:
    for factor, stable in ((1 - 1e-13, True), (1 + 1e-13, False)):
        spring = E.mass_spring_damper(k=repr(1605.35113477512 * factor))
        assert held(hs.Scene(spring, (F.zero_order_hold("1 ms"), F.shunt(**DEVICE))), FREE).stable is stable


def test_what_leaves_the_place_free_has_a_root_at_one() -> None:
    found = held(
        hs.Scene(E.mass_spring_damper(b=3), (F.sampled_loop("1 ms", "tustin", 1), F.shunt(m="0.1", b="0.3"))), FREE
    )
    assert (found.stable, found.unstable) == (False, 1)


@pytest.mark.parametrize("seed", range(2))
def test_a_plant_has_the_values_of_its_dynamics_whatever_symbols_and_delays_are_in_it(seed: int) -> None:
    """Sums of powers of s, of pi and of two symbols, some of them late."""
    draw = random.Random(seed)
    a, b = Symbol("a", positive=True), Symbol("b", positive=True)
    known = {a: Rational(3, 2), b: Rational(7, 3)}
    for _ in range(3):

        def some(most: int) -> Any:
            return sum(
                (
                    Rational(draw.randint(-9, 9), draw.randint(1, 3))
                    * symbol**n
                    * a ** draw.randint(0, 2)
                    * draw.choice([1, 1, b, pi, pi * b])
                    for n in range(most + 1)
                    for _ in range(3)
                ),
                Integer(0),
            )

        top = some(2) + (some(1) + 1) * exp(-symbol / 4) + some(1) * exp(-3 * symbol / 4)
        early, bottom = draw.choice([0, 0, Rational(1, 4)]), some(2) + (1 + a + b**2) * symbol**4
        G = top * exp(-symbol * Rational(1, 2)) / (bottom * exp(-symbol * early))
        ring = Ring.of([G])
        plant = plant_of(ring.convert(G).reduced(), ring)
        at = Rational(5, 7)
        value = sum(
            (sum((c * at**n for n, c in enumerate(row)), Integer(0)) * exp(-at * lag) for lag, row in plant.terms),
            Integer(0),
        )
        value /= sum((c * at**n for n, c in enumerate(plant.denominator)), Integer(0))
        assert abs(N((value - G.subs(symbol, at)).subs(known), 30)) < 1e-20 * (
            1 + abs(N(G.subs(symbol, at).subs(known), 30))
        )
        assert all(lag >= 0 for lag, _ in plant.terms)


@pytest.mark.parametrize("damper", ["1/2", "3", "40"])
def test_a_root_that_is_always_at_one_is_counted_and_stands_in_the_way_of_no_walk(damper: str) -> None:
    """A damper in a clock leaves the place free; too large a one shakes."""
    scene = hs.Scene(E.mass_spring_damper(b=damper), (F.sampled_loop("1 ms", "tustin", 1), F.shunt(m="0.01", b="0.3")))
    found = held(scene, FREE)
    loop = opened(scene, FREE, scene.knobs["environment.b"])
    for value in ("1/2", "3", "40"):
        at = held(scene.with_values({"environment.b": value}), FREE)
        assert loop.count(Rational(value)) == (at.unstable, 0)
    for x in passages(scene, FREE, scene.knobs["environment.b"]).found:
        below, above = (
            held(scene.with_values({"environment.b": Rational(float(x.value)) * n}), FREE).unstable
            for n in (Rational(999, 1000), Rational(1001, 1000))
        )
        assert (x.below, x.above) == (below, above)
        assert (below, found.unstable) == (1, 1 if float(x.value) > float(Rational(damper)) else 3)
        assert above == 3


REASONS = {
    "two clocks": ((F.zero_order_hold("1 ms"), F.zero_order_hold("2 ms"), F.shunt(m="0.1")), "two clocks"),
    "a line": (
        (F.sampled_loop("1 ms", "tustin"), F.wave_variables(3, "5 ms")),
        "a delay comes back between clock and hand",
    ),
    "friction": ((F.sampled_loop("1 ms", "tustin"), F.coulomb_friction("0.1", "1 cm"), F.shunt(m="0.1")), "friction"),
    "nothing": ((F.sampled_loop("1 ms", "tustin"),), "nothing that has mass"),
}


@pytest.mark.parametrize("case", REASONS)
def test_what_is_not_decided_is_said(case: str) -> None:
    effects, words = REASONS[case]
    found = held(hs.Scene(E.mass_spring_damper(k=100), effects), FREE)
    assert found.stable is None
    assert words in found.reason


# How far a number may go


def critical(scene: hs.Scene, hand: Hand, path: str) -> dict[str, Any]:
    document = json.loads(
        hs.stability(scene, hand, free=[path] if not path.startswith("hand") else [], digits=15).to_json()
    )
    (row,) = document["held"]
    found = [x for x in row["critical"] if x["path"] == path]
    (looked,) = [x for x in row["looked_at"] if x["path"] == path]
    return {"found": found, "looked": looked}


@pytest.mark.few("Sun, in a hand", "held by nothing")
@pytest.mark.parametrize("case", ["held by nothing", "in a hand", "B = 0.4", "Sun, in a hand"])
def test_the_stiffest_wall_is_found_from_a_softer_one(case: str) -> None:
    K, keys, hand = TABLE[case]
    (x,) = [x for x in critical(wall(round(K / 3), **keys), hand, "environment.k")["found"] if x["value"]]
    assert x["value"] == pytest.approx(K, rel=1e-14)
    assert float(x["digits"]) == pytest.approx(K, rel=1e-14)
    assert x["stable_side"] == "below"
    assert 0 < x["omega"] < 3141


def test_a_wall_of_no_stiffness_lets_the_handle_go() -> None:
    low = critical(wall(500), FREE, "environment.k")["found"][0]
    assert (low["value"], low["omega"], low["stable_side"]) == (0, 0, "above")


@pytest.mark.slow
def test_the_damping_that_holds_a_stiff_wall_is_where_the_count_changes() -> None:
    (x,) = critical(wall(20000), P3, "hand.b")["found"]
    assert x["stable_side"] == "above"
    b = Rational(x["digits"])
    counts = [held(wall(20000), Hand("P3", b=b * (1 + sign * Rational(1, 10**14)), k=400)).unstable for sign in (-1, 1)]
    assert counts == [2, 0]


@pytest.mark.slow
def test_the_period_and_the_stiffness_have_one_boundary() -> None:
    """K(T) and T(K) are inverse to each other."""
    (x,) = critical(wall(300, T="4 ms"), FREE, "effects.sampled-loop.T")["found"]
    assert x["stable_side"] == "below"
    counts = [
        held(wall(300, T=Rational(x["digits"]) * (1 + sign * Rational(1, 10**13))), FREE).unstable for sign in (-1, 1)
    ]
    assert counts == [0, 2]


@pytest.mark.slow
def test_a_number_given_in_hertz_may_go_as_far_as_one_in_radians() -> None:
    """50 Hz are 100 pi rad/s, no rational number."""

    def told(w: str) -> dict[str, Any]:
        H = E.expression(FILTERED, parameters={"k": 300, "b": 3, "w": w})
        loop = F.sampled_loop("1 ms", "backward-difference", 1), F.shunt(m="45 g")
        return critical(hs.Scene(H, loop), FREE, "environment.w")

    in_hertz, in_radians = told("50 Hz"), told("314 rad/s")
    assert [(x["digits"], x["stable_side"]) for x in in_hertz["found"]] == [
        (x["digits"], x["stable_side"]) for x in in_radians["found"]
    ]
    assert len(in_hertz["found"]) == 1


def test_down_to_0_a_wall_in_a_clock_is_told_as_its_roots_are_counted() -> None:
    """In a hand with stiffness no root comes to 1 as the wall gets softer, down to none at all."""
    hand = hs.Hand("hand", m="0.1 kg", b=2, k=50)
    found = hs.require("virtual-wall", "environment.k", that="stable", hand=hand)
    [span] = [x for x in found.feasible if float(x.high.value or 0) > 1]
    assert (span.low.value, span.low.closed) == (ExactNumber(Integer(0)), True)
    assert all(low is not None and float(low) > 1 for low, _ in found.undecided)
    scene = hs.load_scene("virtual-wall")
    for value in (0, 10**-9, 0.01, 0.3, 5):
        assert held(scene.with_values({"environment.k": value}), hand).stable is True


def test_what_every_passive_hand_that_damps_so_holds_is_told_for_all_values() -> None:
    found = hs.stability(wall(500), P3)  # 500 * 0.001/2 is less than 8 + 0.8
    same = "hand.m, hand.b and hand.k: the number of unstable roots is the same for all values."
    assert same in " ".join(str(found).split())
    [row] = json.loads(found.to_json())["held"]
    assert row["critical"] == []
    assert "looked_at" not in row


@pytest.mark.slow
def test_beyond_what_was_looked_at_nothing_is_said() -> None:
    found = hs.stability(wall(18000), P3)  # 9 is more
    words = " ".join(str(found).split())
    [row] = json.loads(found.to_json())["held"]
    assert {x["path"] for x in row["critical"]} == {"hand.m", "hand.b"}
    looked = {x["path"]: (x["from"], x["to"]) for x in row["looked_at"]}
    assert looked["hand.k"][0] is None
    assert looked["hand.k"][1] >= 500 * 400
    assert looked["hand.b"][1] is None
    assert f"hand.k: looked at up to {looked['hand.k'][1]:g}; what is beyond was not." in words
    assert "same for all values" not in words


@given(
    st.lists(
        st.tuples(st.integers(0, 3), st.integers(-5, 5).filter(bool)), min_size=1, max_size=3, unique_by=lambda x: x[0]
    ),
    st.integers(0, 3),
)
def test_delays_below_the_line_are_taken_off_those_above_it_and_none_may_be_left_over(
    above: list[tuple[int, int]], early: int
) -> None:
    """Sum of c exp(-n s/8) over (s + 2) exp(-m s/8): late by (n - m)/8 s, and of the future where n < m."""
    late = [exp(-n * symbol / 8) for n in range(4)]
    ring = Ring.of([late[1]])
    top = sum((c * (1 + n * symbol) * late[n] for n, c in above), Integer(0))
    G = ring.convert(top) / ring.convert((symbol + 2) * late[early])
    if min(n for n, _ in above) < early:
        with pytest.raises(UndecidedError, match="the future"):
            plant_of(G.reduced(), ring)
        return
    found = plant_of(G.reduced(), ring)
    expected = {Rational(n - early, 8): Rational(c, 1) * (n * symbol + 1) / (symbol + 2) for n, c in above}
    below = sum((x * symbol**i for i, x in enumerate(found.denominator)), Integer(0))
    said = {lag: sum((x * symbol**i for i, x in enumerate(N)), Integer(0)) / below for lag, N in found.terms}
    assert said.keys() == expected.keys()
    assert all((said[lag] - expected[lag]).together().expand() == 0 for lag in said)


@pytest.mark.parametrize("order", [Rational(1, 2), Rational(-1, 3), Rational(7, 4)])
@pytest.mark.parametrize("late", [False, True])
def test_a_power_of_s_above_or_below_the_line_makes_no_plant(order: Rational, *, late: bool) -> None:
    wave = exp(-symbol / 8) if late else Rational(1)
    for top, bottom in (
        (1 + symbol**order, symbol**3 + 2),
        (wave, symbol**3 + symbol**order),
        (symbol**order * wave, symbol**3),
    ):
        ring = Ring.of([top, bottom, wave])
        with pytest.raises(UndecidedError, match="a power of s comes back"):
            plant_of((ring.convert(top) / ring.convert(bottom)).reduced(), ring)


# Every passive hand


NEEDED = {
    "K = 100, B = 1, one late": (wall(100, 1, delay=1), "1.05125000000000", 1.545793721895536),
    "a spring": (wall(1600), "0.800000000000000", None),
    "a spring two late": (wall(1600, delay=2), "4.00000000000000", 0.0),
    "B = 0.4": (wall(800, "0.4"), "0.800000000000000", 3.141592653589793),
    "tustin": (wall(100, method="tustin"), "0.0500000000000000", None),
}


@pytest.mark.parametrize("case", NEEDED)
def test_the_damping_that_every_passive_hand_asks_of_the_device(case: str) -> None:
    scene, digits, theta = NEEDED[case]
    found = sampled_passivity(scene)
    assert found is not None
    assert found.needed is not None
    assert found.needed.value.digits(15) == digits
    assert found.needed.omega is not None
    assert theta is None or float(found.needed.omega) == pytest.approx(theta, rel=1e-15)
    assert found.passive is (float(digits) < 0.8)  # b must exceed it


def filtered(delay: int, b: str) -> hs.Scene:
    H = E.expression(FILTERED, parameters={"k": 500, "b": 3, "w": "50 Hz"})
    return hs.Scene(H, (F.sampled_loop("1 ms", "backward-difference", delay), F.shunt(m="45 g", b=b)))


def test_the_filtered_wall_needs_twice_the_damping_when_it_is_late() -> None:
    late, at_once = (sampled_passivity(filtered(d, "1")) for d in (1, 0))
    assert late is not None
    assert at_once is not None
    assert late.needed is not None
    assert at_once.needed is not None
    assert [float(x.needed.value) for x in (late, at_once) if x.needed] == [1.3717548999605444, 0.6572657444908996]
    assert [float(x.needed.omega) for x in (late, at_once) if x.needed and x.needed.omega] == pytest.approx(
        [0.80523027, 3.14159265], abs=2e-8
    )
    assert (late.passive, at_once.passive) == (False, True)
    assert late.hand_needed is not None
    assert late.hand_needed.digits(8) == "0.37175490"


@given(
    K=st.integers(1, 3000), B=st.integers(-3, 9), delay=st.integers(0, 3), x=st.floats(-0.99, 0.99),
)  # fmt: skip
def test_the_condition_is_a_sum_of_cosines(K: int, B: int, delay: int, x: float) -> None:
    """K T/2 (1 + 2 sum cos k theta) - B cos((d + 1) theta): nowhere larger than what is said, and as large somewhere."""
    import numpy as np

    T = 1e-3
    H = E.expression("k + b*s", parameters={"k": K, "b": B})
    found = sampled_passivity(hs.Scene(H, (F.sampled_loop("1 ms", "backward-difference", delay), F.shunt(m=1))))
    theta = np.linspace(0, np.pi, 20001)
    side = K * T / 2 * (1 + 2 * sum(np.cos(k * theta) for k in range(1, delay + 1))) - B * np.cos((delay + 1) * theta)
    assert found is not None
    assert found.needed is not None
    assert float(found.needed.value) == pytest.approx(side.max(), abs=1e-6 * (K * T + abs(B)))


def test_where_the_condition_does_not_apply_a_reason_is_given() -> None:
    soft = hs.Scene(
        E.mass_spring_damper(k=100), (F.sampled_loop("1 ms", "tustin"), F.compliance(k=5000), F.shunt(m="0.1"))
    )
    document = json.loads(hs.stability(soft, "postural-arm").to_json())
    assert document["held"][0]["stable"] is True
    assert document["sampled"] == {
        "T": 0.001, "passive": None, "damping_needed": None, "digits": None, "theta": None,
        "reason": "something other than mass, spring and damper lies between clock and hand",
    }  # fmt: skip
    assert "does not apply" in str(hs.stability(soft, "postural-arm"))


def test_the_page_and_the_document_say_the_same() -> None:
    scene = filtered(1, "1")
    found = hs.stability(scene, "firm-grip")
    document = json.loads(found.to_json())
    assert document["sampled"]["damping_needed"] == 1.3717548999605444
    assert document["every_passive_hand"]["holds"] is False
    assert document["every_passive_hand"]["damping"] == pytest.approx(0.3717548999605444)
    text = " ".join(str(found).split())
    assert "roots with |z| ≥ 1" in text
    assert "The device's damping must exceed 1.3718 N·s/m; it has 1 N·s/m" in text
    assert "In a hand that damps more than 0.37175 N·s/m no motion grows" in text


def test_a_passive_display_is_stable_in_every_hand_that_is_tried() -> None:
    scene = wall(1590)
    assert sampled_passivity(scene).passive  # type: ignore[union-attr]
    for m in ("0", "0.01", "0.3", "4"):
        for b in ("0", "2"):
            for k in ("0", "90", "4000"):
                assert held(scene, Hand("any", m, b, k)).stable


@pytest.mark.slow
def test_a_coefficient_that_vanishes_where_the_walk_ends_is_no_error() -> None:
    """A sampled wall without damping: at k = 0, where values are looked at last, nothing is left of the controller."""
    wall = hs.load_scene("sampled-wall").with_values({"environment.b": 0})
    [span] = hs.require(wall, "environment.k", (10, 4000), that="stable", hand="light-touch").feasible
    assert span.high.value is not None
    end = float(span.high.value)
    for k, is_stable in ((end * 0.999, True), (end * 1.001, False)):
        now = wall.with_values({"environment.k": k}).with_hands(hs.hands["light-touch"])
        assert hs.stability(now).held[0].stable is is_stable


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("k", "b", "share"), [(1000, (0, 1), "all"), (1700, (0, 1), "some"), (9000, (0, 1), "none"), (3000, (2, 4), "all")]
)
def test_a_box_of_hands_holds_a_sampled_wall_or_does_not(k: int, b: tuple[int, int], share: str) -> None:
    """T = 1 ms, 0.04 kg, 0.8 N s/m: up to 1605.35 N/m with nothing, about 2 (0.8 + b_h)/T in a hand."""
    loop = hs.effects.sampled_loop("1 ms", "backward-difference"), hs.effects.shunt(m="40 g", b="0.8 N*s/m")
    wall = hs.Scene(hs.environments.mass_spring_damper(k=k), loop)
    [row] = hs.stability(wall, hs.Hand("mine", b=list(b))).to_dict()["held"]
    assert row["whole_box"] == share


@pytest.mark.slow
@pytest.mark.parametrize("method", ["tustin", "backward-difference"])
@pytest.mark.parametrize("late", [0, 1])
def test_every_number_of_a_wall_has_its_stable_values_told_by_either_rule(method: str, late: int) -> None:
    """Tustin's rule has a pole at z = -1, and a fast clock a root beside it: both nearly cancel. At eight values each the roots are counted."""
    scene = wall(300, 4, "0.5 ms", late, {"m": "0.3", "b": "0.2"}, method).with_hands(Hand("hand", "0.5", "0.7", "40"))
    for knob in scene.knobs:
        if knob.parts or "jnd" in knob.path or knob.path.startswith("hands."):
            continue
        found = hs.require(scene, knob.path, that="stable")
        own = knob.value
        doubt = [tuple(None if x is None else float(x) for x in pair) for pair in found.undecided]
        assert not any((a is None or a < 50 * own) and (b is None or b > own / 100) for a, b in doubt), knob.path
        for n in range(8):
            value = Rational(own) * Rational(3) ** n / 81
            spans = [(x.low.value, x.high.value) for x in found.feasible]
            inside = any(
                (a is None or float(a) < value) and (b is None or value < float(b)) for a, b in spans
            )  # none is an end
            known = held(scene.with_values({knob.path: value}), scene.with_values({knob.path: value}).hands[0])
            assert (known.unstable == 0) is inside, (knob.path, value)
        for a, b in spans:
            assert all(x is None or len(x.digits(40)) >= 40 or float(x) == 0 for x in (a, b))


KNOB_TEXT = """
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
"""
KNOB = hs.parse_scene(KNOB_TEXT)


@pytest.mark.parametrize(
    "path", ["effects.torsion-bar.k", pytest.param("effects.sampled-loop.T", marks=pytest.mark.slow), *(
        pytest.param(f"hand.{key}", marks=pytest.mark.slow) for key in "mbk"
    )]
)  # fmt: skip
def test_with_a_resonance_between_clock_and_hand_a_number_may_still_go_far(path: str) -> None:
    """A knob on a torsion bar without damping: where the number of roots changes, and at no other value that is tried."""
    [hand] = KNOB.hands
    free = next(x for x in (*KNOB.knobs, *hand.parameters) if getattr(x, "path", f"hand.{x.key}") == path)
    found = passages(KNOB, hand, free)
    start, loop = float(free.value), opened(KNOB, hand, free)
    home = loop.count(free.value)[0]
    assert (found.low or 0) < start / 10
    assert found.high is None or found.high > 2 * start
    changes = [float(x.value) for x in found.found]
    low = max([x for x in changes if x < start], default=float(found.low or 0))
    high = min([x for x in changes if x > start], default=float(found.high or 50 * start))
    draw = random.Random(path)
    for _ in range(12):
        x = draw.choice([start + (high - start) * draw.random(), low + (start - low) * draw.random()])
        assert loop.count(Rational(x))[0] == home
    for x in found.found:
        ends = [loop.count(Rational(float(x.value) * (1 + side * 1e-6)))[0] for side in (-1, 1)]
        assert ends == [x.below, x.above]
    known = {"effects.torsion-bar.k": [356.501596], "effects.sampled-loop.T": [0.00119940417]}.get(path, [])
    assert changes == pytest.approx(known, rel=1e-8)


@pytest.mark.parametrize(
    ("hand", "bar", "cells"), [(1, 2, 20), pytest.param(20, 10, 700, marks=pytest.mark.slow)]
)  # fmt: skip
def test_with_a_resonance_a_box_of_hands_and_bars_is_told_as_a_whole(hand: int, bar: int, cells: int) -> None:
    """Mass and stiffness of the hand and the bar, each within some per cent: no root is on the circle for any of them."""
    text = KNOB_TEXT
    for old, per_cent in (("0.0005 kg*m^2", hand), ("0.3 N*m/rad", hand), ("50 N*m/rad", bar)):
        text = text.replace(f'"{old}"', f'"{old} +- {per_cent} %"')
    scene = hs.parse_scene(text)
    [own] = scene.hands
    sides = [*scene.ranges().values(), *(x for x in scene.knobs if x.is_of_hand and x.interval)]
    loop = OnCircle.of(scene, own, {x.symbol: x.interval for x in sides})
    waiting, looked = [((Fraction(0), Fraction(1)),) * 3], 0
    while waiting and looked < cells:
        cell, looked = waiting.pop(0), looked + 1
        waiting += [] if loop.is_clear(cell) else halves(cell, range(3))
    assert waiting == []
    draw = random.Random(hand)
    for _ in range(8):
        values = {x.symbol: Rational(draw.uniform(*map(float, x.interval))) for x in sides}
        assert loop.is_stable(values) is True


def test_a_box_with_a_critical_value_in_it_is_never_clear() -> None:
    """The bar of the knob is critical at 356.5 N m/rad."""
    wide = KNOB_TEXT.replace('"50 N*m/rad"', '["350 N*m/rad", "360 N*m/rad"]').replace(
        '"0.3 N*m/rad"', '"0.3 N*m/rad +- 1 %"'
    )
    scene = hs.parse_scene(wide)
    [own] = scene.hands
    sides = [*scene.ranges().values(), *(x for x in scene.knobs if x.is_of_hand and x.interval)]
    loop = OnCircle.of(scene, own, {x.symbol: x.interval for x in sides})
    cell = ((Fraction(0), Fraction(1)),) * 2
    for _ in range(12):  # the cells that hold it at the hand's own stiffness
        assert not loop.is_clear(cell)
        cell = next(
            x for x in halves(cell, range(2))
            if 350 + 10 * x[0][0] <= Fraction("356.501596") <= 350 + 10 * x[0][1] and x[1][0] <= Fraction(1, 2) <= x[1][1]
        )  # fmt: skip


def test_when_the_time_is_over_a_number_is_known_as_far_as_it_was_followed() -> None:
    """Time that passes with each look of a walk: half of what is left for each side, so that the other one is followed too."""
    [hand] = KNOB.hands
    mass = hand.parameters[0]
    with limited(0.6):
        found = passages(KNOB, hand, mass)
    assert found.found == ()
    assert 0 < found.low < 0.0005 < found.high
    loop = opened(KNOB, hand, mass)
    for x in (found.low, found.high):
        assert loop.count(Rational(x.numerator, x.denominator)) == (0, 0)
    with limited(1e-9), pytest.raises(UndecidedError):
        passages(KNOB, hand, mass)
