"""What is said of all bandwidths of a range, and of a display in several environments, of answers put together by hand."""

from __future__ import annotations

from types import SimpleNamespace as Made
from typing import Any

import pytest
from pagewords import flat, lines, row
from sympy import Rational

import haptisym as hs
from haptisym.judge.climb import Bandwidths, Jump
from haptisym.judge.crossings import CrossingKind
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.roots import Interval, Point
from haptisym.pages import crossings as crossing_page
from haptisym.pages import family as family_page
from haptisym.pages.bandwidths import bandwidths
from haptisym.writing.document import Document
from haptisym.writing.plain import plain, said

SPRING = hs.environments.mass_spring_damper(k="100 N/m")


def number(x: object) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


def threshold(jnd: Any) -> hs.Threshold:
    found = hs.Scene(SPRING, (hs.effects.first_order_lag(20),), (1, 12), jnd).threshold
    assert isinstance(found, hs.Threshold)
    return found


def told(found: Bandwidths | None, jnd: Any = ("0.05", "0.2")) -> str:
    own: Any = Made(bandwidths=found, scene=Made(threshold=threshold(list(jnd) if isinstance(jnd, tuple) else jnd)))
    blocks = tuple(bandwidths(own))
    return " ".join(plain(Document("", (), blocks)).replace("\xa0", " ").split()) if blocks else ""


AT: dict[str, Any] = {"least": number(2), "most": number(4)}
BOTH = (
    "For thresholds from 5 % to 20 % the bandwidth is at least 2 rad/s (0.31831 Hz) and at most 4 rad/s (0.63662 Hz); "
)


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (Bandwidths(**AT), BOTH + "each value between is reached."),
        (Bandwidths(**AT, undecided="it turns"), BOTH + "both are reached. UNDECIDED: it turns; there may be jumps between."),
        (Bandwidths(**AT, ends_alone=True), BOTH + "both are reached, as the region grows with each of these numbers. Which of the values between are is not told."),
        (Bandwidths(**AT, jumps=(Jump(number("2.5"), number(3), number("0.125")),)), BOTH + "each value between is reached but those from 2.5 to below 3 rad/s (the threshold passes a peak of 12.5 %)."),
        (
            Bandwidths(**AT, jumps=(Jump(number("2.5"), number(3), None, True), Jump(number("3.5"), number(4)))),  # noqa: FBT003
            BOTH + "each value between is reached but those above 2.5 to below 3 rad/s and from 3.5 to below 4 rad/s.",
        ),
        (Bandwidths(None, None), "For thresholds from 5 % to 20 % there is no bandwidth: the distortion is noticed at the band's low end."),
        (Bandwidths(None, number(4)), "For thresholds from 5 % to 20 % the bandwidth is at most 4 rad/s (0.63662 Hz); some give none."),
        (Bandwidths(number(2), number(2)), "For thresholds from 5 % to 20 % the bandwidth is 2 rad/s (0.31831 Hz), whichever it is."),
        (
            Bandwidths(number(2), number(2), blocked={"jnd": number("0.0625")}),
            "For thresholds from 5 % to 20 % the bandwidth is 2 rad/s (0.31831 Hz), where there is one. There is none for a threshold below 6.25 %.",
        ),
        (
            Bandwidths(**AT, blocked={"real": number("0.0625"), "imag": number("0.125")}),
            BOTH + "each value between is reached. There is none for a threshold below 6.25 % for the real part and a threshold below 12.5 % for the imaginary part.",
        ),
        (None, ""),
    ],
)  # fmt: skip
def test_the_bandwidths_of_a_range_are_told_with_what_between_is_not_reached(
    found: Bandwidths | None, words: str
) -> None:
    assert told(found) == words


@pytest.mark.parametrize(
    ("jnd", "words"),
    [
        ({"real": ["0.05", "0.1"], "imag": ["0.1", "0.2"]}, "For thresholds from 5 % to 10 % (real) and from 10 % to 20 % (imaginary) the"),
        ({"real": ["0.05", "0.1"], "imag": ["0.05", "0.1"]}, "For thresholds from 5 % to 10 % the"),
        ({"real": "0.1", "imag": ["0.05", "0.2"]}, "For thresholds from 5 % to 20 % (imaginary) the"),
        ({"real": "0.1", "imag": "0.1", "floor": ["2 N/m", "3 N/m"]}, "For a floor from 2 to 3 N/m the"),
        ({"real": ["0.05", "0.1"], "imag": ["0.05", "0.1"], "floor": ["2 N/m", "3 N/m"]}, "For thresholds from 5 % to 10 % and a floor from 2 to 3 N/m the"),
        ({"real": {"higher": ["0.05", "0.1"], "lower": ["0.02", "0.04"]}, "imag": "0.1"}, "For thresholds from 5 % to 10 % (real part, where it grows) and from 2 % to 4 % (real part, where it shrinks) the"),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2", "scale": ["0.5", "1.5"]}, "For a JND from 0.5 to 1.5 times as large the"),
    ],
)  # fmt: skip
def test_a_range_is_told_by_what_it_is_of(jnd: Any, words: str) -> None:
    assert told(Bandwidths(**AT), jnd).startswith(words)


def test_a_scale_and_a_floor_are_told_as_such_where_they_jump_or_block() -> None:
    scaled = {"shape": "ellipse", "real": "0.1", "imag": "0.2", "scale": ["0.5", "1.5"]}
    found = Bandwidths(**AT, jumps=(Jump(number(3), number(4), number("1.25")),), blocked={"scale": number("0.75")})
    assert "(at a scale of 1.25). There is none for a scale below 0.75." in told(found, scaled)
    floored = {"real": "0.1", "imag": "0.1", "floor": ["2 N/m", "3 N/m"]}
    found = Bandwidths(**AT, jumps=(Jump(number(3), number(4), number("2.25")),), blocked={"floor": number("2.5")})
    assert "(at a floor of 2.25 N/m). There is none for a floor below 2.5 N/m." in told(found, floored)


# Crossings in words


def crossing(kind: CrossingKind, **own: Any) -> Any:
    criterion = {
        "joint": None,
        "symbol": "r_r",
        "region": None,
        "threshold": Rational(1, 8),
        "component": "Re",
        "name": "real",
    } | own.pop("criterion", {})
    return Made(**({"kind": kind, "criterion": Made(**criterion), "multiplicity": 1, "jump": False, "sign": 1} | own))


def test_a_crossing_says_what_happens_to_the_ratio_the_region_or_the_limit() -> None:
    verbs = {CrossingKind.EXCEEDS: "rises above", CrossingKind.RETURNS: "falls below", CrossingKind.TOUCHES: "touches"}
    regions = {CrossingKind.EXCEEDS: "leaves", CrossingKind.RETURNS: "returns into", CrossingKind.TOUCHES: "touches"}
    jumps = {
        CrossingKind.EXCEEDS: "exceeded from here on",
        CrossingKind.RETURNS: "exceeded up to here",
        CrossingKind.TOUCHES: "not exceeded at this frequency alone",
    }
    joint = Made(kind="ellipse")
    for kind in CrossingKind:
        for times, told_times in ((1, ""), (2, " (2-fold)")):
            assert (
                said(crossing_page.event(crossing(kind, multiplicity=times))).replace("\xa0", " ")
                == f"r_r {verbs[kind]} 12.5 %{told_times}"
            )
            leaves = crossing(kind, multiplicity=times, criterion={"joint": joint})
            assert said(crossing_page.event(leaves)) == f"dH {regions[kind]} the ellipse{told_times}"
            assert said(crossing_page.event(leaves, "region")) == f"dH {regions[kind]} the region{told_times}"
        assert said(crossing_page.event(crossing(kind, criterion={"region": True}))) == f"r_r {verbs[kind]} its limit"
        assert said(crossing_page.event(crossing(kind, jump=True))) == f"the limit of r_r changes: {jumps[kind]}"
    assert [said(crossing_page.sense(crossing(CrossingKind.EXCEEDS, sign=x))) for x in (1, -1, 0)] == [
        "Re dH > 0",
        "Re dH < 0",
        "",
    ]


def test_where_nothing_is_met_it_is_said_as_far_as_it_was_decided() -> None:
    for joint, words in (
        (None, "No ratio meets its threshold on the band"),
        (Made(kind="ellipse"), "The distortion does not meet the border of the ellipse on the band"),
    ):
        for undecided, end in (((), "."), ((1,), ", as far as that was decided.")):
            e: Any = Made(crossings=(), undecided=undecided, criteria=[Made(joint=None), Made(joint=joint)])
            block: Any = crossing_page.crossings(e)
            assert said(block.words) == words + end


# Several environments


POINTS = [Point(number(x), {}, {}, {}) for x in (0, 4, 6, 15)]


def several(transparent: Any, bandwidth: Any, *, certified: bool = True, binding: Any = ()) -> str:
    own: Any = Made(
        transparent=transparent,
        bandwidth=bandwidth,
        chart=Made(points=POINTS),
        binding=binding,
        certified=certified,
        figure=None,
    )
    return " ".join(plain(Document("", (), (family_page._worst(own),))).split()) + " " + said(family_page._certain(own))


def test_the_common_band_is_told_from_its_low_end_or_with_all_of_it() -> None:
    ends = POINTS
    for transparent, bandwidth, words in (
        ((), None, "Nowhere on the band."), ((Interval(ends[1], ends[2]),), None, "Only from 4 to 6 rad/s."),
        ((Interval(ends[0], ends[3]),), ends[3].omega, "On the whole band."),
        ((Interval(ends[0], ends[1]),), ends[1].omega, "Up to 4 rad/s (0.63662 Hz), the common bandwidth. Certain"),
        ((Interval(ends[0], ends[1]), Interval(ends[2], ends[3])), ends[1].omega, "the common bandwidth. All of it: from 0 to 4 rad/s and from 6 to 15 rad/s."),
    ):  # fmt: skip
        assert words in several(transparent, bandwidth)
    assert "Certain: every crossing of every environment on the band is known" in several((), None)
    assert several((), None, certified=False).endswith(
        "UNDECIDED at the precision limit near some frequency: evaluate each environment alone to see where."
    )


def test_what_binds_at_one_frequency_is_told_together() -> None:
    real, imag = Made(name="real", symbol="r_r"), Made(name="imag", symbol="r_i")
    binding = [Made(omega=POINTS[1].omega, environment=x, criterion=y) for x, y in (("soft", real), ("stiff", imag))]
    binding.append(Made(omega=POINTS[2].omega, environment="wet", criterion=real))
    text = several((), None, binding=binding)
    assert (
        "At 4 rad/s soft (real part, r_r) and stiff (imag part, r_i) bind. At 6 rad/s wet (real part, r_r) binds."
        in text
    )


def test_each_environment_has_where_it_is_first_noticed_its_bandwidth_and_as_what() -> None:
    stiff = hs.Scene(hs.environments.mass_spring_damper(k=900), (hs.effects.shunt(k=30),), (0, 15), "0.1")
    soft = hs.Scene(SPRING, (hs.effects.shunt(k=30),), (0, 15), "0.1")
    found = hs.evaluate_all(hs.SceneFamily({"stiff": stiff, "soft": soft}))
    assert row(found, "stiff") == "never never whole band -"
    assert row(found, "soft") == "0 never none higher stiffness"
    assert row(found, "effects") == "shunt"
    assert "environment r_r > c from r_i > c from bandwidth felt as" in lines(found)
    assert "Nowhere on the band." in flat(found)
