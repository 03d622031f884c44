"""Values of a parameter beside delays, holds, clocks and powers of s: against closed forms, scans in plain numbers, and both checkers."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from itertools import count
from math import inf
from typing import Any

import mpmath
import numpy as np
import pytest
from certificates import fractional_scene, late_scene, of_requirement, text_of
from forgeries import LATE_GAIN, slab, with_slabs
from marks import FLEXIBLE
from sympy import Rational
from valuesets import contradictions, ends, is_transparent, shown, undecided, within, wrong_edges

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.bindings import Kind
from haptisym.kernel.budget import timed_by
from haptisym.kernel.reals import ExactNumber
from haptisym_check import check

REAL, IMAG = hs.Part.REAL, hs.Part.IMAG
SPRING = environments.mass_spring_damper(k=100)
PAPER = hs.load_scene("fu2019")
LATE = hs.Scene(SPRING, (effects.delay("5 ms"),), (0, 15))
SLACK = environments.spring_pot(k_alpha=50, alpha="0.4", k=20)


# --- closed forms ----------------------------------------------------------------------------------------------------


def test_a_delay_on_a_spring_is_asin_c_to_any_digits() -> None:
    found = hs.require(LATE, "tau", digits=50)
    [span] = found.feasible
    with mpmath.workdps(60):
        assert span.high.digits(50) == f"{mpmath.nstr(mpmath.asin(mpmath.mpf(1) / 10) / 15, 49)}0"
    assert shown(found)[0][2:] == (True, True)
    assert not contradictions(LATE, found, random.Random(5), 2)


TURNS: list[tuple[hs.Scene, str, Any, Callable[[Any], Any], Any]] = [
    # of the least x > 0 with f(x) = 0, x = 15 T or 15 tau
    (hs.Scene(SPRING, (effects.zero_order_hold("1 ms"),), (0, 15)), "T", ("10 ms", "20 ms"), lambda x: (1 - mpmath.cos(x)) / x - 0.1, 0.2),
    (hs.Scene(SPRING, LATE.effects, (0, 15), hs.Threshold.of("3/2", 3)), "tau", (0, 1), lambda x: 1 - mpmath.cos(x) - 1.5, 2),
    (hs.Scene(SPRING, LATE.effects, (0, 15), hs.Threshold.of("1/2", "1/5")), "tau", None, lambda x: mpmath.sin(x) - 0.2, 0.2),
]  # fmt: skip


@pytest.mark.few("a hold")
@pytest.mark.parametrize(
    ("told", "path", "asked", "f", "near"), TURNS, ids=["a hold", "beyond a quarter turn", "two limits"]
)
def test_a_turn_may_last_as_long_as_the_spring_at_the_end_of_the_band_says(
    told: hs.Scene, path: str, asked: Any, f: Any, near: float
) -> None:
    found = hs.require(told, path, asked)
    assert found.certified
    assert ends(found)[0][1] == pytest.approx(float(mpmath.findroot(f, near)) / 15, rel=1e-13)


@pytest.mark.parametrize(
    ("felt", "gain", "jnd"),
    [
        (SPRING, "1", (2, 1)),  # both ratios just reach their limits, at some frequency of every long delay
        (environments.mass_spring_damper(m=1, b=5, k=80), "1", (2, 2)),
        (environments.maxwell(90, 3), "9/10", ("19/10", "5/2")),
        (SPRING, "9/10", ("19/10", "9/10")),
        (SPRING, "-1/2", ("3/2", "3/5")),
    ],
)
def test_a_limit_that_no_phase_exceeds_is_kept_by_every_delay_0_among_them(felt: Any, gain: str, jnd: Any) -> None:
    """Behind g exp(-j x) no change is more than |g| + 1 times H_env, of a spring its imaginary part no more than |g| times."""
    chain = effects.series("g", parameters={"g": gain}), effects.delay("10 ms")
    for asked, expected in ((None, (0, None, True, False)), ((0, "50 ms"), (0, 0.05, True, True))):
        found = hs.require(hs.Scene(felt, chain, (0, 15), hs.Threshold.of(*jnd)), "tau", asked)
        assert (shown(found), undecided(found)) == ([expected], [])


@pytest.mark.few("20-None")
@pytest.mark.parametrize("asked", [None, (0, "50 ms"), ("5 ms", "9 ms")])
@pytest.mark.parametrize("seconds", [8, 20, 60, 150])
def test_when_the_time_is_over_0_and_the_ends_of_a_range_are_told_as_they_are_or_left_open(
    seconds: int, asked: Any
) -> None:
    """A second passes whenever the clock is read."""
    late = hs.Scene(SPRING, (effects.first_order_lag(40), effects.delay("10 ms")), (0, 15), hs.Threshold.of(2, "1/2"))
    with timed_by(count().__next__):
        found = hs.require(late, "tau", asked, limit=seconds)
    assert not wrong_edges(late, found)
    assert not any(x.low is x.high for x in found.feasible)
    assert found.undecided or seconds > 20


R2 = 2**0.5


@pytest.mark.parametrize(
    ("felt", "needed"),
    [
        ("100*s^(1/2) + 2*s", (10 * R2 + 2) / 80),  # r_i at the high end
        ("70*s^(1/2) - 3*s", (5 * R2 + 3) / 80),
        ("100*s^(1/2) - 2*s", R2 / 8),  # r_r everywhere, and r_i at rest
    ],
)
def test_a_threshold_beside_powers_that_leave_0_over_0_at_rest_is_the_largest_ratio(felt: str, needed: float) -> None:
    """80 s^(1/2) is 40 sqrt(2) (1 + j) sqrt(omega), and its modulus 80 sqrt(omega)."""
    pot = hs.Scene(environments.spring_pot(80, "1/2"), (), (0, 1), rendered=environments.expression(felt))
    found = hs.require(pot, "evaluation.jnd")
    assert found.certified
    assert [float(x.value) for x in found.ends] == pytest.approx([needed], rel=1e-14)


def test_a_threshold_of_one_part_beside_a_hold_leaves_the_other_part_as_it_is() -> None:
    fluid = hs.Scene(environments.maxwell(2, 9), (effects.zero_order_hold("30 ms"),), (0, "2/3"))
    one, both = (hs.require(fluid, path) for path in ("evaluation.jnd.imag", "evaluation.jnd"))
    assert one.certified
    assert [x.low.digits(12) for x in one.feasible] == [x.low.digits(12) for x in both.feasible]


# --- scans in plain complex numbers ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Plain:
    """A scene, and what is felt and rendered, written out for s = j omega and a value."""

    scene: hs.Scene
    path: str
    asked: Any
    H: Callable[[Any, Any], Any]
    G: Callable[[Any, Any], Any]

    def worst(self, value: float, near: list[float]) -> float:
        """How many times its threshold the worse ratio is."""
        low, high = (float(x) for x in self.scene.band)
        marks = [x + d for x in near for d in np.linspace(-1e-3, 1e-3, 41)]
        s = 1j * np.array([x for x in [*np.linspace(low, high, 2001), *marks] if max(low, 1e-9) <= x <= high])
        H = self.H(s, value)
        change = (self.G(s, value) - H) / abs(H)
        real, imag = (float(self.scene.threshold[x]) for x in hs.Part)
        return float(max(np.max(abs(change.real)) / real, np.max(abs(change.imag)) / imag))


def hold(s: Any, T: Any) -> Any:
    return (1 - np.exp(-s * T)) / (s * T)


def lag(s: Any, w: Any) -> Any:
    return w / (s + w)


def lowpass(s: Any, w: Any, z: Any) -> Any:
    return w**2 / (s**2 + 2 * z * w * s + w**2)


def paper(s: Any) -> Any:
    return 1.8 * s**2 + 15 * s + 100


def soft(s: Any, order: float = 0.4) -> Any:
    return 20 + 50 * s**order


SCANS = {
    "a delay of a mass": Plain(
        hs.Scene(PAPER.environment, (effects.delay("5 ms"),), (0, 7)), "tau", (0, "30 ms"), lambda s, _: paper(s),
        lambda s, t: paper(s) * np.exp(-s * t),
    ),
    "damping of a filter behind a delay": Plain(
        hs.Scene(PAPER.environment, (*PAPER.effects, effects.delay("1 ms")), (0, 7)), "zeta", ("0.3", "0.8"), lambda s, _: paper(s),
        lambda s, z: paper(s) * lowpass(s, 80, z) * np.exp(-s / 1000),
    ),
    "a hold of a fluid": Plain(
        hs.Scene(environments.maxwell(2, 9), (effects.zero_order_hold("30 ms"),), (0, 2)), "T", ("20 ms", "0.2 s"),
        lambda s, _: 18 * s / (2 + 9 * s), lambda s, T: 18 * s / (2 + 9 * s) * hold(s, T),
    ),
    "a hold beside a filter": Plain(
        hs.Scene(SPRING, (effects.zero_order_hold("9 ms"), effects.second_order_lowpass(90, "0.7")), (0, 9)), "zeta", ("0.1", "0.8"),
        lambda s, _: 100 + 0 * s, lambda s, z: 100 * hold(s, 0.009) * lowpass(s, 90, z),
    ),
    "a lag of a spring-pot": Plain(
        hs.Scene(SLACK, (effects.first_order_lag(200),), (0, 15)), "omega_c", (20, 400), lambda s, _: soft(s),
        lambda s, w: soft(s) * lag(s, w),
    ),
    "the order of a spring-pot": Plain(
        hs.Scene(SLACK, (effects.first_order_lag(130),), (0, 15)), "environment.alpha", ("0.43", "0.46"), lambda s, a: soft(s, a),
        lambda s, a: soft(s, a) * lag(s, 130),
    ),
    "one of two delays": Plain(
        hs.Scene(environments.kelvin_voigt(90, 4), (effects.delay("2 ms", name="a"), effects.delay("3 ms", name="b")), (1, 12)),
        "effects.a.tau", ("1 ms", "11 ms"), lambda s, _: 90 + 4 * s, lambda s, t: (90 + 4 * s) * np.exp(-s * (t + 0.003)),
    ),
    "a mass too much before a delay": Plain(
        hs.Scene(SPRING, (effects.shunt(m=1), effects.delay("1 ms")), (0, 6)), "effects.shunt.m", (-1, 1), lambda s, _: 100 + 0 * s,
        lambda s, m: (100 + m * s**2) * np.exp(-s / 1000),
    ),
    "a peak before a delay": Plain(
        hs.Scene(SPRING, (effects.series("1 + a*s/(s^2 + 2*s + 9)", parameters={"a": "0.1"}), effects.delay("1 ms")), (1, 9)), "a",
        (-1, 1), lambda s, _: 100 + 0 * s, lambda s, a: 100 * (1 + a * s / (s**2 + 2 * s + 9)) * np.exp(-s / 1000),
    ),
    "two sets": Plain(
        hs.Scene(SPRING, (effects.series("a^2", parameters={"a": 1}), effects.delay("1 ms")), (0, 9)), "a", (-2, 2),
        lambda s, _: 100 + 0 * s, lambda s, a: 100 * a**2 * np.exp(-s / 1000),
    ),
}  # fmt: skip


@cache
def answer(name: str) -> Any:
    own = SCANS[name]
    return hs.require(own.scene, own.path, own.asked)


@pytest.mark.dear("a delay of a mass", "a hold of a fluid")
@pytest.mark.few("a delay of a mass", "a hold of a fluid", "a lag of a spring-pot")
@pytest.mark.parametrize("name", SCANS)
def test_a_set_is_where_a_scan_in_complex_numbers_stays_below_the_thresholds(name: str) -> None:
    own = SCANS[name]
    found = answer(name)
    near = [float(b.omega) for x in found.ends for b in x.bindings]
    low, high = (float(x) for x in (found.domain.low, found.domain.high))
    marks = [x for pair in ends(found) for x in pair if x is not None and low < x < high]
    assert found.certified
    assert marks
    for value in [*np.linspace(low, high, 14)[1:-1], *(x + d * (abs(x) or 1) for x in marks for d in (-1e-6, 1e-6))]:
        assert within(ends(found), value) is (own.worst(float(value), near) <= 1)
    for at, b in ((float(x.value), b) for x in found.ends for b in x.bindings):
        assert own.worst(at, [float(b.omega)]) == pytest.approx(1, rel=1e-9)
        places = {float(x): kind for x, kind in zip(own.scene.band, (Kind.START, Kind.EDGE), strict=True)}
        assert b.kind is places.get(float(b.omega), Kind.TOUCH)


def test_a_peak_binds_at_the_frequency_at_which_two_crossings_meet() -> None:
    """On both sides of the end an evaluation says so too; r_r is about a/2 at 3 rad/s."""
    told = SCANS["a peak before a delay"].scene
    [end] = hs.require(told, "a", ("0.19", "0.21")).ends
    [b] = end.bindings
    value = Rational(end.value.digits(16))
    assert (b.kind, b.part) == (Kind.TOUCH, REAL)
    for sign in (1, -1):
        assert is_transparent(told.with_values({"a": value + Rational(sign, 10**9)})) is (sign < 0)
    outside = hs.evaluate(told.with_values({"a": value + Rational(1, 10**7)}))
    first, last = [float(x.omega) for x in outside.crossings if x.part is REAL]
    assert first < float(b.omega) < last < first + 0.01


def test_a_maximum_far_below_its_threshold_keeps_nothing_open() -> None:
    """r_r is 0.027 at 20 rad/s, whichever way it goes with zeta; the end lies where r_i is 0.1 at the band's high end."""
    tool = hs.load_scene(FLEXIBLE)
    [(_, end)] = ends(hs.require(tool, "effects.drive.zeta", ("0.1732", "0.1735")))
    assert end == pytest.approx(0.17340335, abs=1e-7)
    for zeta, crossed in (("0.1734033", 0), ("0.1734034", 1)):
        assert len(hs.evaluate(tool.with_values({"effects.drive.zeta": zeta})).crossings) == crossed


def test_what_one_part_breaks_is_settled_whatever_is_open_of_the_other() -> None:
    """A delay beside a hold: r_r of short delays is hard to enclose, but r_i alone is above its threshold."""
    wheel = environments.mass_spring_damper("0.05 kg*m^2", "0.3 N*m*s/rad", "5 N*m/rad")
    held = (effects.delay("8 ms"), effects.zero_order_hold("2 ms"))
    told = hs.Scene(wheel, held, ("0.1 Hz", "6 Hz"), hs.Threshold.of("0.12", "0.15"))
    found = hs.require(told, "tau", ("5 ms", "40 ms"))
    assert (found.feasible, found.undecided) == ((), ())


@pytest.mark.slow
def test_two_conditions_that_end_at_one_value_are_told_apart() -> None:
    """|g e^(-j w/1000) - 1|: the real part of g = 1.1 binds at rest, the imaginary one a little above at 15 rad/s."""
    jnd = hs.Threshold.of("1/10", Rational(str(1.1001 * np.sin(0.015))))
    told = hs.Scene(SPRING, (effects.series("g", parameters={"g": 1}), effects.delay("1 ms")), (0, 15), jnd)
    [end] = hs.require(told, "g", ("1.05", "1.2")).ends
    assert [(b.part, b.kind) for b in end.bindings] == [(REAL, Kind.START)]
    assert float(end.value) == pytest.approx(1.1, rel=1e-14)


# --- as a value goes to 0 or without bound ---------------------------------------------------------------------------


def behind(effect: hs.Effect, band: tuple[Any, Any] = (0, 15), late: str = "1 ms") -> hs.Scene:
    return hs.Scene(SPRING, (effect, effects.delay(late)), band)


ONE = effects.series("(g + g*s)/(g + g*s)", parameters={"g": "0.5"})
LAG = float(mpmath.findroot(lambda w: mpmath.im(w / (15j + w) * mpmath.expj(-0.015)) + 0.1, 170))
FAR: dict[str, tuple[hs.Scene, str, list[Any]]] = {
    "a mass, from the scene's own": (behind(effects.shunt(m=-1), (0, 6)), "effects.shunt.m", [(-10 / 36, 10 / 36)]),
    "a mass, from none": (behind(effects.shunt(m=0), (0, 6)), "effects.shunt.m", [(-10 / 36, 10 / 36)]),
    "a lag": (behind(effects.first_order_lag(300)), "omega_c", [(LAG, None)]),
    "a stiffness": (LATE, "environment.k", [(0, None)]),
    "a stiffness too late": (LATE.with_values({"tau": "10 ms"}), "environment.k", []),
    "what has left the conditions": (behind(ONE), "g", [(None, None)]),
    "what has left them, too late": (behind(ONE, late="100 ms"), "g", []),
}


@pytest.mark.dear("a mass, from none", "a stiffness")
@pytest.mark.few("a mass, from none", "a stiffness", "what has left the conditions", "what has left them, too late")
@pytest.mark.parametrize("name", FAR)
def test_of_all_values_those_that_do_are_told_however_small_or_large(name: str) -> None:
    told, path, expected = FAR[name]
    found = hs.require(told, path)
    assert found.certified
    assert ends(found) == [tuple(x and pytest.approx(x, rel=2e-3) for x in pair) for pair in expected]
    for at in (1e-12, 1e-3, 1e6, 1e12):
        if path == "environment.k":
            assert is_transparent(told.with_values({path: Rational(at).limit_denominator(10**14)})) is (expected != [])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["organ-tissue", "sampled-wall"])
def test_a_free_delay_beside_other_angles_is_answered(name: str) -> None:
    """Both scenes are noticed without any delay, and no delay mends that."""
    told = hs.load_scene(name)
    found = hs.require(told, "tau")
    assert (found.feasible, found.undecided) == ((), ())
    for tau in (0, Rational(1, 1000), Rational(1, 10), 3):
        assert hs.evaluate(told.with_values({"tau": Rational(tau)})).crossings


@pytest.mark.slow
def test_a_number_that_is_negative_in_the_scene_is_answered_as_its_mirror_image() -> None:
    """100 + (5 - q) s with q = -2 is 100 + (5 + p) s with p = 2."""
    answers = []
    for sign, name in ((-1, "q"), (1, "p")):
        felt = environments.expression(f"100 + (5 + ({sign})*{name})*s", parameters={name: sign * 2})
        told = hs.Scene(felt, (effects.delay("5 ms"),), (0, 12), {"real": "1/2", "imag": "1/2"})
        found = hs.require(told, name, (-9, 9))
        rows = [sorted(sign * (x or inf) for x in pair) for pair in ends(found)]
        answers.append((sorted(rows), len(found.undecided)))
    assert answers[0][0]
    assert answers[0][1] == answers[1][1]
    assert np.allclose(answers[0][0], answers[1][0], rtol=1e-12)


# --- certificates ----------------------------------------------------------------------------------------------------


PROVEN = [(late_scene, x) for x in (3, 4, 8, 13, 14, 15)] + [(fractional_scene, x) for x in (1, 4, 6, 8, 10)]
"""Random scenes whose certificates the checker reads in a second."""


@pytest.mark.slow
@pytest.mark.parametrize(("make", "seed"), PROVEN)
def test_certificates_about_random_scenes_with_waves_are_accepted(make: Callable[[int], str], seed: int) -> None:
    """By the checker; and what they claim an evaluation says at values near both ends of each interval, and between."""
    text = make(seed)
    told = hs.parse_scene(text)
    names = [x.path for x in told.knobs if x.key not in ("tau", "T", "alpha") and "jnd." not in x.path]
    path = random.Random(seed).choice(names)
    proof = hs.require(told, path).certificate()
    assert check(proof.encode(), text.encode()).startswith("Proven")
    for row in json.loads(proof)["claim"]["values"]:
        assert_evaluated(told, path, row)


def assert_evaluated(told: hs.Scene, path: str, row: list[Any]) -> None:
    """That it is transparent on its whole band, or not, for values between two."""
    first, last = (None if x is None else Fraction(x) for x in row[:2])
    low = first if first is not None else last - 1000 if last is not None else Fraction(-1000)
    high = last if last is not None else low + max(abs(low), 1)
    for share in (Fraction(1, 10**12), Fraction(1, 7), Fraction(5, 9), 1 - Fraction(1, 10**12)):
        x = low + (high - low) * share
        assert is_transparent(told.with_values({path: Rational(x.numerator, x.denominator)})) is row[2], (path, x)


@pytest.mark.slow
def test_a_threshold_beside_a_delay_that_is_too_large_gets_no_certificate() -> None:
    """51.41359916... per cent are needed."""
    found = hs.require("delayed-spring", "evaluation.jnd")
    [span] = found.feasible
    low = replace(span.first, value=ExactNumber(Rational("0.51414")))
    points = [low if x == span.first else x for x in found.values.points]
    forged = replace(found.values, points=tuple(points))
    assert [x.low.digits(5) for x in forged.feasible] == ["0.51414"]
    with pytest.raises(hs.UndecidedError):
        replace(found, values=forged).certificate()


@pytest.mark.slow
def test_slabs_of_which_forgeries_are_made_are_accepted_where_what_they_say_is_true() -> None:
    """At omega = 0, or near it, the ratio exceeds its threshold for all values beside 2."""
    late = [slab("21/10", "5/2", ["0"]), slab("5/2", "3", ["1/1000"])], [slab("2000001/1000000", "3", ["0"])]
    asked = [(with_slabs(*told), LATE_GAIN) for told in late]
    assert all(check(proof.encode(), text.encode()).startswith("Proven") for proof, text in asked)


POWERED = """[environment]
model = "spring-pot"
k_alpha = 17
alpha = 0.2
k = 100
[[effects]]
model = "series"
G = "6/5 - s/1000"
[evaluation]
band = [0, 1]
jnd = "1/10"
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "end", "digits"), [(LATE_GAIN, "1/5", 14), (POWERED, "1/5", 14), ("delayed-spring", None, 49)]
)
def test_an_end_lies_between_two_intervals_of_which_one_is_proven_to_do(
    text: str, end: str | None, digits: int
) -> None:
    """At omega = 0 the ratio is 1/5, and nowhere larger: bounds of a sine, or of a power of omega, show no zero there."""
    text = text if end else text_of(text)
    proof = hs.require(hs.parse_scene(text), "evaluation.jnd", digits=digits + 1).certificate()
    (_, high, before), (low, _, after) = json.loads(proof)["claim"]["values"]
    assert (before, after) == (False, True)
    assert end is None or Fraction(high) < Fraction(end) < Fraction(low)
    assert Fraction(low) - Fraction(high) < Fraction(1, 10**digits)
    assert check(proof.encode(), text.encode()).startswith("Proven")


@pytest.mark.slow
def test_lists_of_delays_and_orders_may_be_empty_where_there_are_none() -> None:
    for name in ("from a value on", "a threshold above a delay"):
        proof, text = of_requirement(name)
        told = json.loads(proof)
        told["proof"] = {"delays": [], "orders": []} | told["proof"]
        assert check(json.dumps(told).encode(), text.encode()).startswith("Proven")
