"""What pages of stability say of loops with a clock and of numbers that were looked at, of answers put together by hand."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Integer, Rational

import haptisym as hs
from haptisym.judge.passivity import Beyond
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.roots import Interval, Point
from haptisym.pages import stability as page
from haptisym.pages.clock import looked_at, sampled_condition
from haptisym.verbs.stability.answer import Stability
from haptisym.verbs.stability.critical import Critical, Nearest
from haptisym.verbs.stability.held import Held, Imposed
from haptisym.verbs.stability.passive import EveryPassiveHand
from haptisym.writing.document import Document, Figure, Section, figures_of
from haptisym.writing.plain import plain, said

SPRING = hs.environments.mass_spring_damper(k="100 N/m")
CLOCKED = hs.Scene(SPRING, (hs.effects.sampled_loop("10 ms", "tustin"),), (0, 15), "0.1", rendered=SPRING)
FREE = hs.Scene(SPRING, (hs.effects.delay("10 ms"),), (0, 15), "0.1")
HAND = hs.Hand("tight", m="0.5 kg", b=2, k="30 N/m")


def number(x: object) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


def shown(blocks: Any) -> str:
    return " ".join(plain(Document("T", (), tuple(blocks))).split()).removeprefix("T ")


# Colgate and Schenkel's condition


def condition(*, holds: bool | None, **own: Any) -> str:
    best = Made(omega=number(2), value=number("2.5"))
    given = {
        "passive": True,
        "sides": (1, 2),
        "needed": best,
        "damping": Rational(3, 4),
        "hand_needed": None,
        "pushes": False,
        "asks_nothing": False,
        "at_rest": Rational(-7, 2),
        "reason": "it has an effect between",
    } | own
    return shown(sampled_condition(Made(sampled=Made(**given), holds=holds), "N·s/m", "N/m"))  # type: ignore[arg-type]


YES, NO = True, False
UNMET = "Does NOT hold: Colgate and Schenkel's condition is not met, so that there is a passive hand in which a motion grows."
PUSHED = "Does NOT hold: a passive hand that is softer is pushed away, as the display's stiffness at rest is negative."
SIGN = "The device's damping must not be negative; it has -0.5 N·s/m."
NEEDS = "The device's damping must exceed 2.5 N·s/m; it has 0.75 N·s/m (the largest right-hand side is at θ = 2)."


@pytest.mark.parametrize(
    ("holds", "own", "told"),
    [
        (YES, {}, f"Holds: Colgate and Schenkel's condition is met on all of 0 < θ = ω T ≤ π. {NEEDS}"),
        (YES, {"sides": None}, "Holds: Colgate and Schenkel's condition is met on all of 0 < θ = ω T ≤ π."),
        (NO, {"passive": NO}, f"{UNMET} {NEEDS}"),
        (
            NO, {"passive": NO, "hand_needed": number("1.75")},
            f"{UNMET} {NEEDS} In a hand that damps more than 1.75 N·s/m no motion grows, whatever its mass and stiffness.",
        ),
        (NO, {"passive": None, "sides": None}, "Does NOT hold: there is a passive hand in which a motion grows, as the display gives energy to imposed motion."),
        (NO, {"passive": YES, "sides": None}, "Does NOT hold: there is a passive hand in which a motion grows, as the display gives energy to imposed motion."),
        (YES, {"hand_needed": number(1)}, f"Holds: Colgate and Schenkel's condition is met on all of 0 < θ = ω T ≤ π. {NEEDS}"),
        (None, {"passive": None, "sides": None}, "UNDECIDED: Colgate and Schenkel's condition does not apply, as it has an effect between."),
        (
            NO, {"passive": NO, "pushes": True},
            f"{PUSHED} Whatever a hand damps: the display's stiffness at rest is -3.5 N/m.",
        ),
        (
            NO, {"passive": NO, "asks_nothing": True, "hand_needed": number("0.5"), "damping": Rational(-1, 2)},
            f"{UNMET} {SIGN} In a hand that damps more than 0.5 N·s/m no motion grows, whatever its mass and stiffness.",
        ),
        (
            NO, {"passive": NO, "needed": None},
            UNMET + " No damping of the device is enough: what the controller asks for grows without bound.",
        ),
    ],
)  # fmt: skip
def test_the_condition_on_a_sampled_loop_is_told_with_the_damping_that_it_needs(
    holds: Any, own: dict[str, Any], told: str
) -> None:
    assert condition(holds=holds, **own) == told


# How far numbers were looked at


def crossing(value: object) -> Critical:
    return Critical("k", number(value), number(9), 0, 2)


@pytest.mark.parametrize("found", [0, 1, 2])
@pytest.mark.parametrize("low", [None, Fraction(1, 4)])
@pytest.mark.parametrize("high", [None, Fraction(40)])
def test_how_far_a_number_was_looked_at_is_told_of_sides_that_end_and_on_which_none_was_found(
    found: int, low: Fraction | None, high: Fraction | None
) -> None:
    near = Nearest("hand.b", tuple(crossing(n + 1) for n in range(found)), low=low, high=high)
    told = [said(x) for x in looked_at([near])]
    beyond = "; what is beyond was not."
    expected = {
        (0, True, True): f"from 0.25 to 40{beyond}",
        (0, True, False): "from 0.25 on; what is below was not.",
        (0, False, True): f"up to 40{beyond}",
        (1, True, True): f"up to 40{beyond}",  # 1 lies beside the low end
    }.get((found, low is not None, high is not None))
    assert told == ([f"hand.b: looked at {expected}"] if expected else [])
    assert looked_at([near, near]) == 2 * looked_at([near])


# The page around it


def every(**own: Any) -> EveryPassiveHand:
    given = {
        "holds": True, "active": (), "is_active": False, "has_passive_parts": False, "poles_allow": True, "is_unbounded": False, "damping": None,
        "beyond": Beyond.NEVER, "high": Integer(40), "active_from": None,
    }  # fmt: skip
    return EveryPassiveHand(Made(**(given | own)))  # type: ignore[arg-type]


def stability(scene: hs.Scene, **own: Any) -> Stability:
    given: dict[str, Any] = {
        "imposed": Imposed(YES, 0),
        "held": (),
        "critical": (),
        "boxes": (),
        "every_passive_hand": every(),
    }
    return Stability(scene, **(given | own))


def test_the_plane_of_hands_is_drawn_unless_the_loop_has_a_clock() -> None:
    assert [x.name for x in figures_of(page.page(stability(FREE)).blocks)] == ["plane"]
    assert not [x for x in figures_of(page.page(stability(CLOCKED)).blocks) if isinstance(x, Figure)]


def test_numbers_that_change_nothing_are_listed_and_nothing_is_said_where_none_was_asked_about() -> None:
    def told(*near: Nearest) -> list[str]:
        held = (Held(HAND, Roots(0, 0)),)
        blocks = page.page(stability(FREE, held=held, critical=(near,), boxes=(None,))).blocks
        section = next(x for x in blocks if isinstance(x, Section) and str(x.title).startswith("Held"))
        own = [x for x in section.blocks if isinstance(x, Section)]
        return [shown(x.blocks) for x in own]

    same = ": the number of unstable roots is the same for all values."
    path, tau = "environment.k", "effects.delay.tau"
    assert told() == []
    assert told(Nearest(path)) == [path + same]
    assert told(Nearest(path), Nearest(tau)) == [f"{path} and {tau}{same}"]
    assert told(Nearest(path, reason="too long")) == [f"UNDECIDED: {path}: too long."]
    assert told(Nearest(path, low=Fraction(1), high=Fraction(9))) == [
        f"{path}: looked at from 1 to 9; what is beyond was not."
    ]
    assert told(Nearest(path), Nearest(tau, reason="too long")) == [f"{path}{same} UNDECIDED: {tau}: too long."]
    [table] = told(Nearest(path, (Critical(path, number(80), number(9), 0, 2),)), Nearest(tau))
    assert table.endswith(f"{path} 80.000000 N/m below 9 {tau}{same}")
    assert "critical at in stable ω (rad/s)" in table


def test_roots_are_told_as_a_number_or_as_a_chain_and_verdicts_with_their_reasons() -> None:
    hands = {
        "a": (Roots(0, 0), "yes", "0"), "b": (Roots(4, 3), "NO", "4"), "c": (Roots(None, None, (), RootChain.RIGHT), "NO", "infinite"),
        "d": (Roots(None, None, (), RootChain.NEAR), "NO", "a chain near it"), "e": (None, "UNDECIDED", ""),
    }  # fmt: skip
    held = tuple(
        Held(hs.Hand(name, m="0.5 kg", b=2, k="30 N/m"), roots, "" if roots else "too long")
        for name, (roots, *_) in hands.items()
    )
    found = stability(FREE, held=held, critical=((),) * 5, boxes=(None,) * 5)
    body = [" ".join(x.split()) for x in plain(page.page(found)).splitlines()]
    for name, (_, verdict, count) in hands.items():
        assert body.count(f"{name} 0.5 2 30 {verdict} {count}".strip()) == 1, name
    told = " ".join(body)
    assert told.count("none of them grows, as all parts only take energy") == 0
    passive = stability(
        FREE, held=held, critical=((),) * 5, boxes=(None,) * 5, every_passive_hand=every(has_passive_parts=True)
    )
    again = " ".join(plain(page.page(passive)).split())
    assert again.count("none of them grows, as all parts only take energy") == 1
    assert (
        "d: infinitely many roots come as near to the imaginary axis as one likes: the system is neutral; none of them grows"
        in again
    )


def test_six_bands_of_activity_are_told_and_more_are_counted() -> None:
    for count in (5, 6, 7, 9):
        for beyond in (Beyond.NEVER, Beyond.ALWAYS):
            active = tuple(
                Interval(Point(number(2 * n), {}, {}, {}), Point(number(2 * n + 1), {}, {}, {})) for n in range(count)
            )
            text = " ".join(
                plain(
                    page.page(
                        stability(
                            FREE, every_passive_hand=every(holds=False, is_active=True, active=active, beyond=beyond)
                        )
                    )
                ).split()
            )
            last = count <= 6
            assert (f"from {2 * count - 2} rad/s on: there" in text) == (beyond is Beyond.ALWAYS and last)
            assert (f"and {count - 6} more intervals: there" in text) == (count > 6)
            assert ("from 10 to 11 rad/s" in text) == (count > 6 or (count == 6 and beyond is Beyond.NEVER))
            assert "from 12 to 13 rad/s" not in text
            assert "from 8 to 9 rad/s" in text or (count == 5 and beyond is Beyond.ALWAYS)
