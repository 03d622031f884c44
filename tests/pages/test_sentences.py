"""What pages say, sentence by sentence: each answer put together by hand, so that every branch has its own."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from fractions import Fraction
from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Integer, Rational, Symbol

import haptisym as hs
from haptisym.judge.passivity import Beyond
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.roots import Interval, Point
from haptisym.pages.held import held
from haptisym.pages.measuredlines import ends, runs
from haptisym.pages.require import sets
from haptisym.pages.sliders import limit_sliders, region_record
from haptisym.verbs.simulate.results import Estimate, Simulations
from haptisym.verbs.stability.answer import Stability
from haptisym.verbs.stability.boxes import Box, Share
from haptisym.verbs.stability.critical import Critical, Nearest
from haptisym.verbs.stability.held import Held, Imposed
from haptisym.verbs.stability.passive import EveryPassiveHand
from haptisym.writing.plain import said

YES, NO = True, False
SPRING = hs.environments.mass_spring_damper(k="100 N/m")
SCENE = hs.Scene(SPRING, (hs.effects.delay("10 ms"),), (0, 15), "0.1")


def lines(answer: object) -> list[str]:
    """Of its page, with single spaces."""
    return [" ".join(line.replace("\xa0", " ").split()) for line in str(answer).splitlines()]


def flat(answer: object) -> str:
    return " ".join(" ".join(lines(answer)).split())


# Simulations


def simulated(*estimates: Estimate, notes: tuple[str, ...] = (), force: float = 3.0) -> hs.Simulation:
    t = np.array([0.0, 0.5, 1.25])
    return hs.Simulation(
        SCENE, hs.sine("2 cm", 5), t, 0.1 * t, -force * t, t, t, estimates, ("mass-spring-damper", "delay"), (), notes
    )


@pytest.mark.parametrize(
    ("found", "told"),
    [
        ([simulated()], "No ratio is recovered from this motion or from so short a run."),
        ([simulated(Estimate(5.0, 3 + 4j, 3 + 4j, 0.0))], "Simulation and closed form agree within the estimated error of the simulation at every frequency."),
        (
            [simulated(Estimate(5.0, 3 + 4j, 3 + 4j, 0.0), Estimate(6.25, 1, 2, 0.5)), simulated(Estimate(7.0, 1, 2, 0.5))],
            "Simulation and closed form DISAGREE at 6.25 and 7 rad/s.",
        ),
        ([simulated(Estimate(5.0, -3.3, -3, 0.0, "it rattles"), Estimate(6.0, 1, 2j, 9.0, "it rattles"), Estimate(7, 9, 1, 0))], "The closed form is not exact here: it rattles; it differs by up to 1.1e+02 %."),
        ([simulated(Estimate(5.0, -3.3, -3, 0.0, "it rattles"), Estimate(6.0, 2, 2j, 9.0, "it creaks"))], "The closed form is not exact here: it rattles; it creaks; it differs by up to 1.4e+02 %."),
        ([simulated(Estimate(5.0, 1, 0, 0.0, "it rattles"))], "The closed form is not exact here: it rattles."),
    ],
)  # fmt: skip
def test_a_simulation_ends_with_a_verdict(found: list[hs.Simulation], told: str) -> None:
    assert flat(Simulations(found)).endswith(told)


def test_a_simulation_tells_what_was_simulated_and_each_estimate() -> None:
    one = simulated(
        Estimate(5.0, 3 + 4j, 3 + 4.5j, 1.0),
        Estimate(2 * pi, 1.25 + 2j, 1 + 2j, 0.125),
        Estimate(7, 1, 2, 1, "so"),
        notes=("mind this",),
    )
    both = lines(Simulations([one, simulated(force=4.0)]))
    for line in (
        "simulated mass-spring-damper, delay", "motion sine, 2 runs, up to 0.02 m", "time 0 to 1.25 s", "force up to 5 N at the hand",
        "H_perc recovered from the force, N/m", "rad/s Hz Re simulated Im simulated from closed error up to agrees",
        "5 0.7958 3 4 0.5 1 yes", "6.283 1 1.25 2 0.25 0.12 NO", "7 1.114 1 0 1 1 -", "mind this",
    ):  # fmt: skip
        assert both.count(line) == 1, line
    assert "motion sine, up to 0.02 m" in lines(one)
    assert "recovered" not in flat(replace(simulated(), estimates=())).replace("is recovered", "")


# Stability


def number(x: object) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


def interval(low: object, high: object) -> Interval:
    first = Point(number(low), {}, {}, {})
    return Interval(first, first if low == high else Point(number(high), {}, {}, {}))


def every(**given: Any) -> EveryPassiveHand:
    """As if a passivity had come out so."""
    own = {"holds": True, "active": (), "is_active": False, "has_passive_parts": False, "poles_allow": True, "is_unbounded": False,
           "damping": None, "beyond": Beyond.NEVER, "high": Integer(40), "active_from": None}  # fmt: skip
    return EveryPassiveHand(SimpleNamespace(**(own | given)))  # type: ignore[arg-type]


def stability(**given: Any) -> Stability:
    own: dict[str, Any] = {
        "imposed": Imposed(YES, 0),
        "held": (),
        "critical": (),
        "boxes": (),
        "every_passive_hand": every(),
    }
    return Stability(SCENE, **(own | given))


@pytest.mark.parametrize(
    ("imposed", "told"),
    [
        (Imposed(None, None), "UNDECIDED: whether all poles of H_perc lie in Re s < 0."),
        (Imposed(YES, 0), "Stable: all poles of H_perc lie in Re s < 0."),
        (Imposed(YES, 0, RootChain.NEAR), "Stable: all poles of H_perc lie in Re s < 0; infinitely many come as near to the imaginary axis as one likes."),
        (Imposed(NO, 2), "NOT stable: poles of H_perc in Re s ≥ 0: 2."),
        (Imposed(NO, None), "NOT stable: poles of H_perc in Re s ≥ 0: at least one."),
        (Imposed(NO, None, RootChain.NEAR), "NOT stable: H_perc has poles on the imaginary axis."),
        (Imposed(NO, None, RootChain.RIGHT), "NOT stable: of the poles of H_perc, infinitely many roots lie to the right of the imaginary axis"),
    ],
)  # fmt: skip
def test_what_is_said_of_the_force_under_imposed_motion(imposed: Imposed, told: str) -> None:
    assert flat(stability(imposed=imposed)).count(told) == 1


SUP = SimpleNamespace(value=number("2.5"), omega=number(8))
ACTIVE = {"active": (interval(2, 3), interval(5, 5)), "is_active": True, "holds": False}


@pytest.mark.parametrize(
    ("x", "told"),
    [
        (EveryPassiveHand(None, "it is too long"), ["UNDECIDED: it is too long."]),
        (every(holds=None), ["UNDECIDED: Im H_perc ≥ 0 on all of [0, ∞), but where poles lie stayed open."]),
        (every(holds=None, beyond=Beyond.UNKNOWN), ["UNDECIDED: beyond 40 rad/s (6.3662 Hz) the sign of Im H_perc is "]),
        (every(), ["Holds: Im H_perc ≥ 0 on all of [0, ∞), and no pole of H_perc/s forbids it.", "!Whatever a hand damps", "!UNDECIDED: how"]),
        (every(has_passive_parts=True), ["Holds: all parts only take energy, the environment and each two-port between it and the hand."]),
        (every(holds=False, poles_allow=False), ["Does NOT hold: there is a passive hand in which a motion grows.", "Whatever a hand damps: a pole of H_perc/s to the right", "!Active"]),
        (every(holds=True, poles_allow=False), ["!Whatever a hand damps"]),
        (every(holds=False, poles_allow=None), ["!Whatever a hand damps"]),
        (every(**ACTIVE, damping=SUP), ["Active (Im H_perc < 0) from 2 to 3 rad/s and at 5 rad/s (0.79577 Hz) alone: there a motion", "b* = sup(−Im H_perc/ω) = 2.5 N·s/m, at 8 rad/s (1.2732 Hz); in a hand that damps more no motion grows"]),
        (every(**ACTIVE, damping=SUP, poles_allow=False), ["2.5 N·s/m, at 8 rad/s (1.2732 Hz).", "Whatever a hand damps"]),
        (every(**ACTIVE, damping=SimpleNamespace(value=number(3), omega=None)), ["= 3 N·s/m, approached as ω grows; in a hand"]),
        (every(**ACTIVE, is_unbounded=True), ["No damping of a hand is enough for all its masses and stiffnesses: −Im H_perc/ω grows without bound.", "!b*"]),
        (every(**ACTIVE), ["UNDECIDED: how large −Im H_perc/ω becomes."]),
        (every(**ACTIVE, beyond=Beyond.CLOCK), ["!how large"]),
        (every(**ACTIVE, beyond=Beyond.ALWAYS, damping=SUP), ["from 2 to 3 rad/s and from 5 rad/s on: there"]),
        (every(**ACTIVE, beyond=Beyond.AGAIN, damping=SUP), ["from 2 to 3 rad/s, at 5 rad/s (0.79577 Hz) alone and again and again beyond 40 rad/s"]),
        (every(**ACTIVE, beyond=Beyond.LATE, damping=SUP), ["alone (beyond 40 rad/s it was not looked at)", "signs where they were looked at decided"]),
        (every(**ACTIVE, beyond=Beyond.LATE, damping=SUP, active_from=Integer(900)), ["alone and everywhere above 900 rad/s (from 40 rad/s to there it was not looked at)"]),
        (every(holds=False, is_active=True, active=tuple(interval(n, n + Rational(1, 2)) for n in range(1, 8)), damping=SUP), ["from 6 to 6.5 rad/s and 1 more intervals"]),
        (every(holds=False, is_active=True, active=tuple(interval(n, n + Rational(1, 2)) for n in range(1, 7)), damping=SUP), ["and from 6 to 6.5 rad/s: there", "!more intervals"]),
    ],
)  # fmt: skip
def test_what_is_said_of_every_passive_hand(x: EveryPassiveHand, told: list[str]) -> None:
    text = flat(stability(every_passive_hand=x))
    for sentence in told:
        assert (text.count(sentence.removeprefix("!")) == 1) is not sentence.startswith("!"), sentence


def test_what_is_said_of_hands_how_far_numbers_may_go_and_of_boxes() -> None:
    hands = [hs.Hand(name, m="0.5 kg", b=2, k="30 N/m") for name in "abcdef"]
    ranged = hs.Hand("wide", m=["0.4 kg", "0.6 kg"], b=2, k=["10 N/m", "30 N/m"])
    roots = [
        Roots(0, 0),
        Roots(2, 2),
        Roots(None, None, (), RootChain.RIGHT),
        Roots(None, None, (), RootChain.NEAR),
        Roots(2, 0, (number(4), number(9))),
        None,
    ]
    held = tuple(Held(hand, x, "it is too long" if x is None else "") for hand, x in zip(hands, roots, strict=True))
    path, tau = "environment.k", "effects.delay.tau"
    rows = (
        Nearest(path, (Critical(path, number(80), number(9), 0, 2), Critical(path, number(120), None, 2, 4), Critical(path, number(130), number(1), 0, None, YES))),
        Nearest(tau), Nearest("hand.m", reason="that took too long"), Nearest("hand.b", low=Fraction(1), high=Fraction(9)),
    )  # fmt: skip
    found = stability(held=held, critical=(rows, *[()] * 5), boxes=(None,) * 6)
    shown, text = lines(found), flat(found)
    for line in (
        "hand m (kg) b (N·s/m) k (N/m) stable roots in Re s ≥ 0", "a 0.5 2 30 yes 0", "b 0.5 2 30 NO 2", "c 0.5 2 30 NO infinite",
        "d 0.5 2 30 NO a chain near it", "e 0.5 2 30 NO 2", "f 0.5 2 30 UNDECIDED", "How far a number may go in the hand a",
        "environment.k 80.000000 N/m below 9", "environment.k 120.00000 N/m on neither side from infinity", "environment.k 130.00000 N/m not above 1",
        "effects.delay.tau: the number of unstable roots is the same for all values.", "UNDECIDED: hand.m: that took too long.",
    ):  # fmt: skip
        assert shown.count(line) == 1, (line, shown)
    for sentence in (
        "c: infinitely many roots lie to the right of the imaginary axis", "d: infinitely many roots come as near to the imaginary axis as one likes: the system is neutral.",
        "e: on the imaginary axis, at 4 and 9 rad/s, lie roots that neither grow nor decay.", "f: not decided: it is too long.",
    ):  # fmt: skip
        assert text.count(sentence) == 1, sentence
    assert "a:" not in text.replace("in the hand a", "")[:0]
    passive = flat(
        stability(held=held[3:4], critical=((),), boxes=(None,), every_passive_hand=every(has_passive_parts=True))
    )
    assert "the system is neutral; none of them grows, as all parts only take energy." in passive
    assert "No hand was given: write `[hand]` in the scene, or ask with `--hand NAME`. The package ships" in flat(
        stability()
    )
    for box, told in (
        (Box(Share.ALL), "wide with m from 0.4 to 0.6 and k from 10 to 30: stable in all of these hands."),
        (Box(Share.SOME), "and k from 10 to 30: NOT stable in all of these hands, but in some."),
        (Box(Share.NONE), "and k from 10 to 30: NOT stable in any of these hands."),
        (
            Box(None, reason="that took too long"),
            "UNDECIDED: wide with m from 0.4 to 0.6 and k from 10 to 30: that took too long.",
        ),
    ):
        assert told in flat(stability(held=(Held(ranged, Roots(0, 0)),), critical=((),), boxes=(box,)))
    assert (
        "Certain: roots are counted, and signs on [0, ∞) decided, with every delay as it is. Imposed, held and every"
        in flat(stability(every_passive_hand=every(damping=SUP)))
    )
    assert "UNDECIDED where it says so. Everything else is proven." in flat(found)


# Relevance, environments


def test_effects_are_ranked_by_what_they_change_and_dominance_covers_the_band() -> None:
    found = hs.relevance(
        hs.Scene(
            SPRING, (hs.effects.first_order_lag(900), hs.effects.shunt(b=1), hs.effects.delay("1 us")), (1, 12), "0.1"
        ),
        "0.02",
    )
    shown = lines(found)
    assert {row[0]: row[-1] == "kept" for x in shown if len(row := x.split()) > 3 and row[0] == row[1]} == {
        "shunt": True,
        "first-order-lag": False,
        "delay": False,
    }
    ranked = [x.split() for x in shown if x.split()[:1] in (["shunt"], ["first-order-lag"], ["delay"])]
    assert [row[0] for row in ranked[:3]] == ["shunt", "first-order-lag", "delay"]
    w = np.linspace(1, 12, 2001)
    lag, damper, late = 1 / (1 + 1j * w / 900), 1j * w / 100, np.exp(-1e-6j * w)

    def ratios(H: Any) -> Any:
        return np.abs([H.real - 1, H.imag])

    whole = ratios((lag + damper) * late)
    for row, other in zip(ranked, ((lag * late), (1 + damper) * late, lag + damper), strict=False):
        most = np.abs(ratios(other) - whole).max(axis=1)  # their bounds are rounded up
        assert (most <= 1.001 * np.array(row[2:4], dtype=float)).all()
        assert (np.array(row[2:4], dtype=float) <= 1.05 * most + 1e-12).all()
    bands = [re.fullmatch(r"([\d.]+) to ([\d.]+) (.*)", x) for x in shown]
    cells = [(float(x[1]), float(x[2]), x[3]) for x in bands if x]
    assert (cells[0][0], cells[-1][1]) == (1, 12)
    assert all(
        a[1] == b[0] and a[0] < a[1] and a[2] != b[2] for a, b in zip(cells, [*cells[1:], (12, 13, "")], strict=True)
    )
    text = flat(found)
    assert "1 of 3 effects matter: shunt. Leaving out all others together changes" in text
    assert "(tolerance 0.02)" in text
    none = hs.relevance(hs.Scene(SPRING, (hs.effects.delay("1 us"),), (1, 12), "0.1"), "0.02")
    assert "0 of 1 effects matter: none. Leaving out all of them together changes" in flat(none)
    assert "Which one changes the ratios most" not in flat(none)
    assert "The full scene has no crossing on the band." in flat(none)
    assert "The scene has no effects." in flat(hs.relevance(hs.Scene(SPRING, (), (1, 12), "0.1")))


def test_several_environments_say_what_stands_between_and_where_each_is_noticed_first() -> None:
    """Behind a lag of 20 rad/s every spring is noticed at 20 sqrt(1/9) in its real part, and first at 20 (5 - sqrt(24))."""
    lag = (hs.effects.first_order_lag(20),)
    stiff = hs.Scene(hs.environments.mass_spring_damper(k=900), lag, (0, 15), "0.1")
    soft = hs.Scene(SPRING, lag, (0, 15), "0.1")
    found = hs.evaluate_all(hs.SceneFamily({"stiff": stiff, "soft": soft}))
    text, shown = flat(found), lines(found)
    first = 20 * (5 - 24**0.5)
    assert "effects first-order-lag" in shown
    assert "band 0 rad/s (0 Hz) to 15 rad/s (2.3873 Hz)" in shown
    for name in ("stiff", "soft"):
        assert any(x.startswith(f"{name} 6.6667 {first:.5g} {first:.5g} ") for x in shown)
    assert f"Up to {first:.5g} rad/s ({first / 2 / pi:.5g} Hz), the common bandwidth." in text
    assert "bind." in text
    assert "Certain: every crossing of every environment on the band is known" in text
    bare = hs.evaluate_all(
        hs.SceneFamily(
            {
                "one": hs.Scene(SPRING, (), (0, 15), "0.1"),
                "two": hs.Scene(hs.environments.mass_spring_damper(k=9), (), (0, 15), "0.1"),
            }
        )
    )
    assert "effects none" in lines(bare)
    assert "On the whole band." in flat(bare)
    assert sum("never never whole band -" in x for x in lines(bare)) == 2


# Measured lines, identified models


def test_neighbours_that_are_alike_are_runs_from_first_to_last() -> None:
    for codes in ([1], [1, 1], [1, 2], [3, 3, 1, 1, 1, 2, 3]):
        found = list(runs(np.array(codes)))
        assert [n for a, b in found for n in range(a, b + 1)] == list(range(len(codes)))
        assert all(len({codes[n] for n in range(a, b + 1)}) == 1 for a, b in found)
        assert all(codes[a[1]] != codes[b[0]] for a, b in itertools.pairwise(found))


def test_an_identified_number_is_told_to_the_second_digit_of_its_error_and_its_ends_are_moved_outwards() -> None:
    found = hs.identify(hs.sampled("fu2019", [1, 3, 5, 7, 9, 11, 13]), "mass-spring-damper")
    base = found.estimates[0]
    unit = {}
    for value, error, low, high, told in (
        (12.3456789, 0.0123, 12.3211, 12.3702, "12.346 0.012 12.321 to 12.371"),
        (12.3456789, 0.00987, 12.33581, 12.35549, "12.3457 0.0099 12.3358 to 12.3555"),
        (123456.78, 250.0, 122956.0, 123957.0, "123460 2.5e+02 122950 to 123960"),
        (0.5, 0.0, 0.5, 0.5, "0.50000000 0 0.50000000 to 0.50000000"),
        (1e-5, 3e-6, 4.05e-6, 1.595e-5, "0.0000100 3e-06 0.0000040 to 0.0000160"),
    ):
        changed = replace(base, value=value, error=error, low=low, high=high, least=low, most=high)
        row = next(
            x
            for x in lines(replace(found, estimates=(changed, *found.estimates[1:])))
            if x.startswith(f"{base.parameter.name} ")
        )
        unit[row.split()[-1]] = told
        assert row.removeprefix(f"{base.parameter.name} ").startswith(told), row
    assert set(unit) == {"kg"}


# Sliders of the explorer


def test_sliders_of_a_threshold_reach_a_decade_to_each_side_and_at_least_a_hundredth_to_one() -> None:
    def sliders(jnd: Any) -> dict[str, Any]:
        return {key: x.record() for key, (x, _) in limit_sliders(replace(SCENE, threshold=jnd)).items()}

    one = sliders("0.1")
    assert one["real"] == one["imag"] == {
        "id": "explorer-c", "unit": "", "value": 0.1, "low": 0.01, "high": 1.0, "log": True, "least": 0, "open": True, "most": None,
    }  # fmt: skip
    wide = sliders({"real": "0.05", "imag": {"higher": "3", "lower": "0.2"}, "floor": "15 N/m"})
    assert {key: (x["id"], x["low"], x["high"]) for key, x in wide.items()} == {
        "real": ("explorer-c-real", 0.005, 1.0), "imag": ("explorer-c-imag", 0.01, 30.0), "imag.lower": ("explorer-c-imag-lower", 0.01, 2.0),
        "floor": ("explorer-floor", 1.5, 150.0),
    }  # fmt: skip
    assert (wide["floor"]["unit"], wide["floor"]["log"], wide["floor"]["open"]) == ("N/m", True, True)
    words = {
        key: said
        for key, (_, said) in limit_sliders(
            replace(SCENE, threshold={"real": "0.05", "imag": {"higher": "3", "lower": "0.2"}})
        ).items()
    }
    assert words == {
        "real": "threshold c of the real part", "imag": "threshold c of the imaginary part where it grows",
        "imag.lower": "threshold c of the imaginary part where it shrinks",
    }  # fmt: skip
    tilted = sliders({"shape": "ellipse", "real": "0.1", "imag": "0.2", "tilt": "0.5"})["tilt"]
    assert tilted == {
        "id": "explorer-tilt", "unit": "", "value": 0.5, "low": -0.99, "high": 0.99, "log": False, "least": -1 + 2**-53, "open": False,
        "most": 1 - 2**-53,
    }  # fmt: skip
    corners = [["0.1", "0"], ["0", "omega/50"], ["-0.1", "0"], ["0", "-0.1"]]
    polygon = replace(SCENE, threshold={"shape": "polygon", "corners": corners}, band=(1, 15))
    assert {key: x.record()["id"] for key, (x, _) in limit_sliders(polygon).items()} == {"size": "explorer-size"}
    size = limit_sliders(polygon)["size"][0].record()
    assert (size["value"], size["low"], size["high"], size["log"]) == (1.0, 0.1, 10.0, True)
    record = region_record(polygon.threshold, limit_sliders(polygon))
    assert (record["shape"], record["numbers"]) == ("polygon", {"size": {"slider": "explorer-size"}})
    assert [x["top"] for x in record["corners"][1]] == [[0.0], [0.0, 1.0]] or record["corners"][1][1] == {
        "top": [0.0, 0.02],
        "bottom": [1.0],
    }
    moving = replace(SCENE, threshold={"real": "(1 + omega)/(20 + omega**2)", "imag": "0.2", "floor": "3 + omega"})
    found = region_record(moving.threshold, limit_sliders(moving))["numbers"]
    assert set(found) == {"real", "imag", "floor"}
    assert found["imag"] == {"slider": "explorer-c-imag"}
    for key, true in (("real", lambda w: (1 + w) / (20 + w * w)), ("floor", lambda w: 3 + w)):
        for w in (0.0, 2.0, 7.0):
            top, bottom = (sum(c * w**n for n, c in enumerate(found[key][x])) for x in ("top", "bottom"))
            assert top / bottom == pytest.approx(true(w))


# What an evaluation says of stability, and a requirement of values


def evaluated(stable: bool | None, found: Any) -> Any:  # noqa: FBT001
    return SimpleNamespace(stable=stable, passivity=found, scene=SCENE)


def passivity(**given: Any) -> Any:
    own = {"most_given": None, "sampled": None, "damping": None}
    return SimpleNamespace(**(vars(every(**given).passivity) | own | given))


GIVEN = SimpleNamespace(value=number("2.5"), omega=number(8))


@pytest.mark.parametrize(
    ("found", "told"),
    [
        (None, "Every passive hand: not decided. Whether the display is stable in a hand was not looked at."),
        (passivity(holds=None, beyond=Beyond.UNKNOWN), "Every passive hand: not decided. Whether"),
        (passivity(holds=None), "Every passive hand: not decided; Im H_perc ≥ 0 at all frequencies, but poles were not decided. Whether"),
        (passivity(holds=None, beyond=Beyond.CLOCK), "not decided; Im H_perc ≥ 0 up to 40 rad/s, half the clock's rate, which alone does not tell. Whether"),
        (passivity(holds=None, is_active=True, active=(interval(2, 3),)), "not decided; Im H_perc < 0 from 2 to 3 rad/s in a closed form that leaves out what a clock folds back. Whether"),
        (passivity(), "Every passive hand may hold it: Im H_perc ≥ 0 at all frequencies, not on this band alone, and no pole forbids it."),
        (passivity(has_passive_parts=True), "Every passive hand may hold it: all parts only take energy."),
        (passivity(sampled=True), "Every passive hand may hold it: Colgate and Schenkel's condition is met up to θ = π."),
        (passivity(holds=False, sampled=True), "Not with every passive hand: Colgate and Schenkel's condition is not met. Whether"),
        (passivity(holds=False), "Not with every passive hand: Im H_perc ≥ 0 at all frequencies, but poles forbid it. Whether"),
        (passivity(**ACTIVE), "Not with every passive hand: Im H_perc < 0 from 2 to 3 rad/s and at 5 rad/s (0.79577 Hz) alone. It gives energy away there, −π A² Im H_perc per cycle of amplitude A. Whether"),
        (passivity(**ACTIVE, most_given=GIVEN, damping=SUP), "It gives energy away there, −π A² Im H_perc per cycle of amplitude A (with Im H_perc = −2.5 N/m at 8 rad/s). A hand that damps more than 2.5 N·s/m holds it, whatever its mass and stiffness. Whether"),
        (passivity(**ACTIVE, damping=SUP, poles_allow=False), "per cycle of amplitude A. Whether"),
        (passivity(**ACTIVE, is_unbounded=True), "per cycle of amplitude A. No damping of a hand makes up for that: it grows faster than frequency. Whether"),
        (passivity(**ACTIVE, beyond=Beyond.ALWAYS), "Im H_perc < 0 from 2 to 3 rad/s and from 5 rad/s on. It"),
        (passivity(holds=False, is_active=True, active=(interval(2, 3),), beyond=Beyond.ALWAYS), "Im H_perc < 0 from 2 rad/s on. It"),
        (passivity(**ACTIVE, beyond=Beyond.AGAIN), "alone and again and again beyond. It"),
        (passivity(**ACTIVE, beyond=Beyond.LATE), "alone (beyond 40 rad/s it was not looked at). It"),
        (passivity(**ACTIVE, beyond=Beyond.LATE, active_from=Integer(900)), "alone and everywhere above 900 rad/s (from 40 rad/s to there it was not looked at). It"),
        (passivity(holds=False, is_active=True, active=tuple(interval(n, n + Rational(1, 2)) for n in range(1, 5))), "from 2 to 2.5 rad/s and from 3 to 3.5 rad/s and further on. It"),
        (passivity(holds=False, is_active=True, active=tuple(interval(n, n + Rational(1, 2)) for n in range(1, 4)), beyond=Beyond.AGAIN), "and from 3 to 3.5 rad/s and again and again beyond. It"),
    ],
)  # fmt: skip
def test_an_evaluation_says_of_every_passive_hand_what_was_decided(found: Any, told: str) -> None:
    imposed, hands = (" ".join(said(x).replace("\xa0", " ").split()) for x in held(evaluated(True, found)))  # noqa: FBT003
    assert imposed == "The force under imposed motion is stable: all poles of H_perc have Re s < 0."
    assert told in hands
    for stable, words in (
        (False, "is NOT stable: a pole of H_perc has Re s ≥ 0."),
        (None, "Whether the force under imposed motion is stable was not decided."),
    ):
        assert " ".join(said(next(iter(held(evaluated(stable, found))))).replace("\xa0", " ").split()).endswith(words)


def span(low: object, high: object, *, open_low: bool = False, open_high: bool = False) -> Any:
    ends = [None if x is None else number(x) for x in (low, high)]
    if low is not None and low == high:
        ends[1] = ends[0]
    return SimpleNamespace(
        low=SimpleNamespace(value=ends[0], closed=not open_low),
        high=SimpleNamespace(value=ends[1], closed=not open_high),
    )


@pytest.mark.parametrize(
    ("spans", "unit", "told"),
    [
        ([], "rad/s", "no value"),
        ([span(None, None)], "rad/s", "every value of ω_n"),
        ([span(3, 3)], "rad/s", "ω_n = 3 rad/s alone"),
        ([span("1/3", None)], "1", "ω_n ≥ 0.33333"),
        ([span("1/3", None, open_low=True)], "rad/s", "ω_n > 0.33333 rad/s"),
        ([span(None, 4)], "N*s/m", "ω_n ≤ 4 N·s/m"),
        ([span(None, 4, open_high=True)], "rad/s", "ω_n < 4 rad/s"),
        ([span(1, 2), span(3, 4, open_low=True)], "rad/s", "1 ≤ ω_n ≤ 2 rad/s or 3 < ω_n ≤ 4 rad/s"),
    ],
)  # fmt: skip
def test_values_that_will_do_are_told_with_their_ends(spans: list[Any], unit: str, told: str) -> None:
    free = SimpleNamespace(symbol=Symbol("omega_n"), unit=unit)
    assert said(sets(SimpleNamespace(feasible=spans, free=free, undecided=[]))).replace("\xa0", " ") == told  # type: ignore[arg-type]
    if spans and told.count("0.33333"):  # nothing is proven beside that end: it is rounded inward
        doubtful = [(None, spans[0].low.value)]
        assert "0.33334" in said(sets(SimpleNamespace(feasible=spans, free=free, undecided=doubtful)))  # type: ignore[arg-type]


def test_of_neighbouring_lines_the_ends_are_told_and_of_one_its_frequency() -> None:
    e: Any = SimpleNamespace(lines=SimpleNamespace(omega=np.array([1.0, 2.5, 4.0])))
    assert [said(ends(e, *x)) for x in ((0, 2), (1, 1), (1, 2))] == ["1 to 4", "2.5", "2.5 to 4"]


def test_tolerances_tell_their_box_what_is_proven_and_what_is_only_estimated() -> None:
    """A spring behind a lag of 36 to 44 rad/s is noticed from wc sqrt(1/9) on in Re, and from wc (5 - sqrt(24)) on in Im."""
    scene = hs.Scene(
        hs.environments.mass_spring_damper(k="100 N/m +- 10 %"),
        (hs.effects.first_order_lag("40 rad/s +- 10 %"),),
        (0, 15),
        "0.1",
    )
    found = hs.tolerances(scene, samples=20, seed=3)
    text, shown = flat(found), lines(found)
    assert "k 90 110 N/m by 10 %" in shown
    assert "ω_c 36 44 rad/s by 10 %" in shown
    assert "Proven: for NONE of the values within the ranges is the display transparent on the whole band." in text
    factor = 5 - 24**0.5
    told = re.search(r"the bandwidth lies between ([\d.]+) rad/s .* and ([\d.]+) rad/s", text)
    assert told is not None
    assert [float(x) for x in told.groups()] == pytest.approx([36 * factor, 44 * factor], rel=1e-3)
    assert "Estimated, NOT guaranteed: quantiles over 20 sets of values, drawn uniformly (seed 3)" in text
    assert "Of these sets 0 are transparent on the whole band." in text
    for name in ("first crossing", "bandwidth"):
        row = next(x for x in shown if x.startswith(f"{name} "))
        cells = [float(x) for x in row.removeprefix(f"{name} ").split()]
        assert cells == sorted(cells)
        assert 36 * factor <= cells[0] <= cells[-1] <= 44 * factor
    alone = flat(hs.tolerances(scene, samples=0))
    assert "Estimated" not in alone
