"""What is asked together of a display: transparent, stable in a hand, fit for every passive hand; against closed forms."""

from __future__ import annotations

import json
from math import asin, inf, pi
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.linalg import expm
from sympy import Rational
from valuesets import ends, shown, undecided, within

import haptisym as hs
from haptisym import effects, environments

POSTURAL = "postural-arm"  # 0.554 kg, 6.45 N s/m, 135 N/m
LATE = hs.load_scene("delayed-spring")
NOTHING = hs.Hand("nothing")


def test_what_nothing_holds_in_place_is_steady_up_to_the_damping_at_which_it_shakes() -> None:
    """A damper made by a clock: the eigenvalues of what a period does to place, speed and last place say the same."""
    loop = effects.sampled_loop("1 ms", "backward-difference"), effects.shunt(m="0.2 kg", b="0.1 N*s/m")
    free_air = hs.Scene(environments.kelvin_voigt(k=0, b=0), loop, hands=(NOTHING,))
    [span] = hs.require(free_air, "environment.b", that="steady").feasible
    assert (span.low.digits(3), span.closed[0], span.closed[1]) == ("0", True, False)
    assert hs.require(free_air, "environment.b", that="stable").feasible == ()
    for share, most in ((0.0, 1), (0.5, 1), (0.999, 1), (1.001, 3)):
        force = share * float(span.high) / 1e-3  # held on the place's change in the last period
        A = np.array([[0, 1, 0], [0, -0.1 / 0.2, 1 / 0.2], [0, 0, 0]]) * 1e-3
        P = expm(A)
        step = np.array([[1, P[0, 1], 0], [0, P[1, 1], 0], [1, 0, 0]])
        step[:2, 0] -= P[:2, 2] * force
        step[:2, 2] += P[:2, 2] * force
        assert (abs(np.linalg.eigvals(step)) > 1 - 1e-9).sum() == most


def test_a_delayed_spring_is_stable_in_the_published_hand_up_to_the_known_stiffness() -> None:
    """There m s^2 + b s + k + K exp(-s tau) is 0 on the axis, which two sums of squares tell."""
    found = hs.require(LATE, "environment.k", (1, 1000), that=["stable"], hand=POSTURAL)
    [span] = found.feasible
    [b] = span.last.bindings
    assert (span.high.digits(14), b.omega.digits(14)) == ("199.85210225871", "22.244306341606")
    assert (span.closed[1], found.certified) == (False, True)
    with mpmath.workdps(30):
        m, d, k = (mpmath.mpf(x) for x in ("0.554", "6.45", "135"))
        w, tau = mpmath.mpf(b.omega.digits(25)), mpmath.mpf("0.036")
        root = -m * w**2 + 1j * d * w + k + mpmath.mpf(span.high.digits(25)) * mpmath.expj(-w * tau)
        assert abs(root) < 1e-20
    row = json.loads(found.to_json())
    assert (row["criteria"], row["binding"][0]["criterion"], row["binding"][0]["kind"]) == (
        ["stable"],
        "stable",
        "axis",
    )


@pytest.mark.parametrize(
    ("k", "b"), [(0, 3.4635997327677037), (100, 3.329749753286228), (500, 2.81972833105523), (1000, 2.238659408552519)]
)
def test_the_damping_that_a_hand_needs_is_the_known_one(k: int, b: float) -> None:
    hand = hs.Hand("own", m="0.5 kg", k=k)
    found = hs.require(LATE, "hand.b", that="stable", hand=hand)
    assert (ends(found), found.certified) == ([(pytest.approx(b, rel=1e-14), None)], True)


@pytest.mark.slow
def test_a_delay_has_islands_of_stability_and_a_simulation_agrees() -> None:
    found = ends(hs.require(LATE, "tau", ("1 ms", "0.6 s"), that="stable", hand=POSTURAL))
    assert len(found) == 2
    for tau, inside in (("0.1", True), ("0.105", False), ("0.22", False), ("0.23", True)):
        assert within(found, float(tau)) is inside
        assert hs.release(LATE.with_values({"tau": tau}), "1 cm", POSTURAL).grows is not inside


# --- a spring behind a lag, of which all is known --------------------------------------------------------------------


def lagged(k: Any, b: Any, m: Any, d: Any, band: tuple[int, int] = (0, 10), *hands: hs.Hand) -> hs.Scene:
    """(k + b s) w/(s + w) + m s^2 + d s."""
    chain = (effects.first_order_lag(50), effects.shunt(m=m, b=d))
    return hs.Scene(environments.mass_spring_damper(k=k, b=b), chain, band, hands=hands)


@pytest.mark.few("4")
@pytest.mark.parametrize("seed", range(8))
def test_a_lag_is_stable_as_routh_says_and_fit_for_passive_hands_where_dampers_make_up_for_it(seed: int) -> None:
    """Im H/omega is d + (b w - k) w/(omega^2 + w^2); with a hand (d + m w)(b + d) > m k."""
    pick = Random(seed)
    k, b, m, d = (
        pick.randint(10, 400),
        pick.randint(0, 10),
        Rational(pick.randint(1, 9), 20),
        Rational(pick.randint(1, 30), 10),
    )
    hand = hs.Hand("own", m="0.2 kg", b="0.5 N*s/m")
    told = lagged(k, b, m, d)
    M, D = m + Rational(1, 5), d + Rational(1, 2)
    least = {"passive": k / (b + d), "stable": (M * k / (b + D) - D) / M}
    for that, low in least.items():
        found = hs.require(told, "omega_c", (5, 500), that=that, hand=hand if that == "stable" else None)
        at = max(float(low), 5.0)
        assert found.certified
        assert shown(found) == [(pytest.approx(at, rel=1e-14), 500, that == "passive" or at == 5, True)]
    both = hs.require(told, "omega_c", (5, 500), that=["passive", "stable"], hand=hand)
    assert ends(both)[0][0] == pytest.approx(max(5.0, *map(float, least.values())), rel=1e-14)
    assert both.that == ("stable", "passive")
    heavy = hs.Hand("heavy", m="1 kg", b="0.5 N*s/m")
    every = ends(hs.require(told.with_hands(hand, heavy), "omega_c", (5, 500), that="stable"))
    assert every == ends(hs.require(told, "omega_c", (5, 500), that="stable", hand=heavy))  # of more mass it takes more


def test_ends_that_are_no_fractions_belong_to_what_suits_every_passive_hand() -> None:
    """With a^2 for the stiffness Im/omega is 2.5 - a^2/200 at 0, and larger above."""
    squared = environments.expression("a^2 + 2*s", parameters={"a": 10})
    chain = (effects.first_order_lag(200), effects.shunt(m="0.1 kg", b="0.5 N*s/m"))
    found = hs.require(hs.Scene(squared, chain), "a", that="passive")
    assert shown(found) == [(pytest.approx(-(500**0.5)), pytest.approx(500**0.5), True, True)]


def test_the_papers_filter_suits_every_passive_hand_from_a_frequency_on() -> None:
    assert ends(hs.require("fu2019", "omega_n", that="passive")) == [(pytest.approx(25 / 3), None)]
    every = hs.require("fu2019", "omega_n", that=["passive", "stable", "transparent", "stable"], hand=POSTURAL)
    assert ends(every) == ends(hs.require("fu2019", "omega_n"))
    assert every.that == ("transparent", "stable", "passive")


# --- together --------------------------------------------------------------------------------------------------------


@pytest.mark.few("100")
@pytest.mark.parametrize("k", [100, 2000])
def test_of_a_soft_wall_what_is_noticed_comes_first_and_of_a_stiff_one_that_it_shakes(k: int) -> None:
    slow = LATE.with_band(0, 2).with_values({"environment.k": k})
    asked: Any = (slow, "tau", ("1 ms", "0.2 s"))
    both = hs.require(*asked, that=["stable", "transparent"], hand=POSTURAL)
    stable = ends(hs.require(*asked, that="stable", hand=POSTURAL))[0][1] if k > 100 else None
    assert ends(both) == [(0.001, pytest.approx(min(stable or inf, asin(0.1) / 2), rel=1e-14))]
    [b] = both.feasible[0].last.bindings
    assert b.criterion.name == {100: "imag", 2000: "stable"}[k]


def test_where_nothing_will_do_each_thing_that_was_asked_is_told_by_itself() -> None:
    """A lag that is noticed; with a hand of 1 kg it is stable from 18 rad/s on: 2 + w > 60/3."""
    told = lagged(60, 1, 0, 2, (0, 10), hs.Hand("one", m=1))
    asked: Any = (told, "omega_c", (5, 19))
    found = hs.require(*asked, that=["transparent", "stable", "passive"])
    assert (found.feasible, found.certified) == ((), True)
    assert [[x.name for x in y.criteria] for y in found.alone] == [["real", "imag"], ["stable"], ["passive"]]
    assert [ends(x) for x in found.alone] == [[], [(18, 19)], []]
    assert hs.require(told, "omega_c", (100, 900), that=["stable", "passive"]).alone == ()
    damped = told.with_hands(*told.hands, hs.Hand("damped", m=1, b=2))
    each = hs.require(damped, "omega_c", (5, 19), that=["transparent", "stable"]).alone
    assert [ends(x) for x in each] == [[], [(18, 19)], [(8, 19)]]  # (4 + w) 5 > 60


@pytest.mark.slow
def test_a_map_of_several_things_has_each_set_and_what_they_have_in_common() -> None:
    told = lagged(300, 1, "0.04", "0.8", (0, 10), hs.Hand("own", m="0.1 kg", b="0.2 N*s/m"))
    that = ["transparent", "stable", "passive"]
    found = hs.design_map(told, ["omega_c", "environment.k"], [(100, 400), (10, 1000)], that=that, slices=4)
    for x in found.slices:
        w = float(x.at)
        one, held, every = (ends(y) for y in x.apart)
        assert every == [(10, pytest.approx(1.8 * w))]
        assert held == [(10, pytest.approx((1 + 0.14 * w) * 2 / 0.14))]
        assert ends(x.requirement) == [(one[0][0], every[0][1])]
        assert {b.criterion.name for e in x.requirement.ends for b in e.bindings} == {"imag", "passive"}
    row = json.loads(found.to_json())
    assert (row["criteria"], set(row["slices"][0]["apart"])) == (that, set(that))


@pytest.mark.parametrize("that", [["stable"], ["passive"], ["transparent", "stable", "passive"]])
@pytest.mark.parametrize("k", [100, 500])
def test_what_time_does_not_last_for_is_undecided(that: list[str], k: int) -> None:
    told = lagged(k, 1, "0.04", "0.8")
    hand = NOTHING if "stable" in that else None
    for own in (told, wall()):
        found = hs.require(own, "environment.k", (1, 1000), that=that, hand=hand, limit=1e-9)
        assert (found.feasible, undecided(found)) == ((), [(1, 1000)])


def test_beside_a_chain_that_nears_the_axis_all_values_short_of_it_are_stable() -> None:
    """The lead's gain at high frequency times the mass is that of the hand at Td = 0.606*0.00158/0.137: |A| > |B| beyond 30 rad/s."""
    lead = (
        effects.series("(1 + s*Td)/(1 + s*Tf)", parameters={"Td": "0.0176", "Tf": "0.00158"}),
        effects.delay("0.00854"),
    )
    felt = environments.mass_spring_damper(m="0.137", b="6.02", k=591)
    own = hs.Scene(felt, lead, hands=(hs.Hand("hand", m="0.606", b="0.845", k=299),))
    found = hs.require(own, "Td", ("0.00587", "0.0528"), that="stable")
    assert (shown(found), found.undecided) == (
        [(0.00587, pytest.approx(0.606 * 0.00158 / 0.137, rel=1e-15), True, False)],
        (),
    )


@pytest.mark.slow
def test_a_range_is_searched_whole_though_the_scenes_own_value_is_0() -> None:
    """s^2/10 + K + (3 s + 100) exp(-s/100) is 0 on the axis where 3 w cos(w/100) = 100 sin(w/100), at K = w^2/10 - its real part."""
    chain = effects.delay("10 ms"), effects.shunt(m="0.1", k=-100)
    own = hs.Scene(environments.mass_spring_damper(k=100, b=3), chain, hands=(hs.Hand("hand", k=0),))
    found = hs.require(own, "hand.k", (0, 100_000), that="stable")

    def stiffness(near: float) -> float:
        w = mpmath.findroot(lambda w: 3 * w * mpmath.cos(w / 100) - 100 * mpmath.sin(w / 100), near)
        return float(w**2 / 10 - 3 * w * mpmath.sin(w / 100) - 100 * mpmath.cos(w / 100) + 100)

    a, b, c = map(stiffness, (132, 464, 781))
    assert (ends(found), found.certified) == ([(0, pytest.approx(a)), (pytest.approx(b), pytest.approx(c))], True)


@pytest.mark.parametrize("m", [2, "3/2"])
def test_nothing_is_said_of_values_beyond_those_that_are_searched(m: Any) -> None:
    """m s^2 + s^2 exp(-s/100) + k is 0 on the axis first at 100 pi rad/s; far beyond 10^6 N/m the search knows nothing."""
    own = hs.Scene(environments.mass_spring_damper(m=1), (effects.delay("10 ms"),), hands=(hs.Hand("hand", m=m),))
    found = hs.require(own, "hand.k", that="steady")
    assert shown(found) == [(0, pytest.approx((float(Rational(m)) - 1) * (100 * pi) ** 2, rel=1e-14), True, False)]
    assert (found.undecided, found.certified) == ((), True)


def test_an_end_of_what_is_searched_is_no_end_of_the_set() -> None:
    """s^2 + 10 + b s exp(-s/100) is 0 on the axis first at w = 50 pi, b = (w^2 - 10)/w: far more than a million times the scene's."""
    own = hs.Scene(
        environments.mass_spring_damper(b="1e-6"), (effects.delay("10 ms"),), hands=(hs.Hand("h", m=1, k=10),)
    )
    for asked in (None, (0, 1000)):
        [told] = ends(hs.require(own, "environment.b", asked, that="stable"))
        assert told == (0, pytest.approx((2500 * pi**2 - 10) / (50 * pi), rel=1e-14))


@pytest.mark.few("sliding")
@pytest.mark.parametrize("name", ["sliding", "sampled-wall"])
def test_what_is_undecided_for_a_reason_says_it(name: str) -> None:
    rough = hs.Scene(environments.mass_spring_damper(k=100, b=1), (effects.coulomb_friction("1 N", "1 cm"),), (1, 99))
    told, asked, why = {
        "sliding": (rough, {"that": "stable", "hand": POSTURAL}, "friction or play is a describing function"),
        "sampled-wall": (hs.load_scene("sampled-wall"), {"that": "passive"}, "the sampled force depends on"),
    }[name]
    found = hs.require(told, "environment.k", (10, 1000), **asked)
    assert (found.feasible, undecided(found)) == ((), [(10, 1000)])
    assert why in found.reason
    assert why in found.to_dict()["reason"]
    assert "Undecided" in str(found)


@pytest.mark.parametrize("that", ["stable", "passive"])
def test_a_value_at_which_there_is_no_dynamics_will_not_do(that: str) -> None:
    """1/(s/w + 1) has no value at w = 0, which the model of a formula does not exclude."""
    lag = effects.series("1/(s/w + 1)", parameters={"w": 30})
    told = hs.Scene(environments.kelvin_voigt(100, 20), (lag,))
    found = hs.require(told, "w", (0, 100), that=that, hand=POSTURAL if that == "stable" else None)
    assert found.certified
    assert found.feasible
    assert shown(found)[0][0::2] != (0, True)


REGIONS: list[tuple[Any, bool]] = [
    (0.1, True), ({"real": 0.1, "imag": 0.2}, True), ({"real": 0.1, "imag": "0.1 + omega/1000"}, False),
    ({"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.1}, False), ({"shape": "ellipse", "real": 0.1, "imag": 0.1}, False),
]  # fmt: skip


@pytest.mark.dear("0.1-True")
@pytest.mark.parametrize(("jnd", "told"), REGIONS)
def test_which_value_comes_nearest_is_told_of_two_ratios_with_a_threshold_alone(jnd: Any, *, told: bool) -> None:
    lag = hs.Scene(environments.kelvin_voigt(90, 3), (effects.first_order_lag(5),), (1, 5), jnd)
    found = hs.require(lag, "omega_c", (5, 6))
    assert found.feasible == ()
    assert (found.nearest is not None) is told


# --- with a clock ----------------------------------------------------------------------------------------------------


def wall(T: str = "1 ms", delay: int = 0, B: object = 0) -> hs.Scene:
    """A virtual wall that a clock renders on a device of 0.04 kg and 0.8 N s/m."""
    loop = effects.sampled_loop(T=T, method="backward-difference", delay=delay)
    device = effects.shunt(m="0.04 kg", b="0.8 N*s/m", name="device")
    return hs.Scene(environments.mass_spring_damper(k=1000, b=B), (loop, device), ("0 Hz", "10 Hz"))


FIRM = hs.Hand("firm", b=8, k=400)
STIFFEST: dict[str, tuple[dict[str, Any], hs.Hand, float]] = {
    "free": ({}, NOTHING, 1605.35113477512), "late": ({"delay": 1}, NOTHING, 536.278559788946),
    "slow": ({"T": "5 ms"}, NOTHING, 325.422809758905), "held": ({}, FIRM, 18284.7872144337),
    "damped": ({"B": "0.4"}, NOTHING, 2384.3034697805),
}  # fmt: skip


def growth(K: float, B: float, T: float, delay: int, hand: hs.Hand) -> float:
    """The largest modulus of a root of the wall's loop, in the states of the device, the last sample and forces on their way."""
    m, b, k = 0.04, 0.8 + float(hand.b.value), float(hand.k.value)
    # x' = v, v' = (-b v - k x - F)/m, F held over T: the exponential of the matrix with F as a third state
    A = np.array([[0, 1, 0], [-k / m, -b / m, -1 / m], [0, 0, 0]]) * T / 64
    step = np.eye(3) + A + A @ A / 2 + A @ A @ A / 6 + A @ A @ A @ A / 24
    step = np.linalg.matrix_power(step, 64)
    n = 3 + delay  # x, v, x of the last sample, forces computed before
    M = np.zeros((n, n))
    force = np.zeros(n)
    force[0], force[2] = K + B / T, -B / T
    acting = force if not delay else np.eye(n)[3]
    M[:2] = step[:2, :2] @ np.eye(n)[:2] + np.outer(step[:2, 2], acting)
    M[2, 0] = 1
    if delay:
        M[3] = force
    return float(max(abs(np.linalg.eigvals(M))))


@pytest.mark.dear("damped", "held")
@pytest.mark.few("late", "held", "damped")
@pytest.mark.parametrize("name", STIFFEST)
def test_with_a_clock_the_stiffest_wall_is_where_the_step_of_its_states_begins_to_grow(name: str) -> None:
    own, hand, stiffest = STIFFEST[name]
    found = hs.require(wall(**own), "environment.k", (1, 30_000), that="stable", hand=hand)
    assert found.certified
    assert ends(found) == [(1, pytest.approx(stiffest, rel=1e-13))]
    assert found.feasible[0].last.bindings[0].kind.value == "axis"
    loop = (float(own.get("B", 0)), float(own.get("T", "1 ms").split()[0]) / 1000, own.get("delay", 0), hand)
    assert growth(stiffest * (1 - 1e-6), *loop) < 1 < growth(stiffest * (1 + 1e-6), *loop)


# --- what is no question ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--that stable", "stable in a hand, and none is given: --hand NAME"),
        ("--that stable --hand nobody", 'there is no hand "nobody"'),
        ("--that pretty", "pretty"),
        ("--hand light-touch", "it needs --that"),
    ],
)
def test_what_cannot_be_asked_on_the_command_line_is_said(call: Any, words: str, said: str) -> None:
    status, out, err = call("require", "fu2019", "--free", "omega_n", *words.split())
    assert (status, out) == (2, "")
    assert said in " ".join(err.split())


@pytest.mark.parametrize(
    ("that", "said"),
    [(["stabel"], 'did you mean "stable"'), (["transparent", "x" * 90], "none of"), ([], "nothing is asked"), ((), "nothing is asked")],
)  # fmt: skip
def test_a_word_that_cannot_be_asked_is_named(that: Any, said: str) -> None:
    with pytest.raises(hs.HaptisymError, match=said):
        hs.require("fu2019", "omega_n", that=that)
