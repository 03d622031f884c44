"""The page of which effects matter and the head of a report, of answers put together by hand."""

from __future__ import annotations

import itertools
from types import SimpleNamespace as Made
from typing import Any

import pytest
from pagewords import flat, lines
from sympy import Rational

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.roots import Interval, Point
from haptisym.model.jnd import Part
from haptisym.pages import effects as page
from haptisym.pages.findings import findings
from haptisym.writing.document import Figure, Section
from haptisym.writing.plain import plain, said

SCENE = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("10 ms"),), (0, 15), "0.1")


def change(real: float, imag: float, *, is_finite: bool = True) -> dict[Part, Any]:
    return {x: Made(most=y, is_finite=is_finite) for x, y in zip(Part, (real, imag), strict=True)}


def one(name: str, real: float, imag: float, *, kept: bool = False, is_finite: bool = True) -> Any:
    return Made(
        effect=Made(name=name, model=f"{name}-model"), change=change(real, imag, is_finite=is_finite), kept=kept
    )


def relevant(*effects: Any, **own: Any) -> Any:
    kept, dropped = ([x.effect for x in effects if x.kept is y] for y in (True, False))
    given: dict[str, Any] = {
        "scene": Made(effects=effects, title="T", source="", asides=list), "effects": effects, "pruned": Made(effects=kept), "dropped": dropped,
        "operations": (40, 12), "bound": change(0.00123456, 0.25), "tolerance": Rational(1, 50), "dominance": (), "crossings": (), "smallest": True, "figure": None,
    }  # fmt: skip
    return Made(**(given | own))


def text(*effects: Any, **own: Any) -> str:
    return flat(plain(page.page(relevant(*effects, **own))))


A, B, C = one("a", 0.0078125, 0.5, kept=True), one("b", 0.25, 0.125), one("c", 0.03125, 0.0625)
OUT = "changes r_r by at most 0.00124 and r_i by at most 0.25 anywhere on the band (tolerance 0.02). The distortion then takes 12 operations, written in steps, where it took 40."


@pytest.mark.parametrize(
    ("effects", "told"),
    [
        ((A, B, C), f"1 of 3 effects matter: a. Leaving out all others together {OUT}"), ((B, C), f"0 of 2 effects matter: none. Leaving out all of them together {OUT}"),
        ((A,), "1 of 1 effects matter: a."), ((), "0 of 0 effects matter: none."),
    ],
)  # fmt: skip
def test_how_many_matter_is_told_and_what_leaving_out_the_others_changes(effects: tuple[Any, ...], told: str) -> None:
    assert text(*effects).startswith(f"T {told}")
    assert ("Leaving out" in text(*effects)) == any(not x.kept for x in effects)


def test_effects_are_listed_by_the_larger_of_their_two_changes() -> None:
    for order in itertools.permutations((A, B, C)):
        shown = lines(plain(page.page(relevant(*order))))
        rows = [x for x in shown if x.split()[1:2] in (["a-model"], ["b-model"], ["c-model"])]
        assert rows == ["a a-model 0.00782 0.5 kept", "b b-model 0.25 0.125", "c c-model 0.0313 0.0625"]
    assert "effect model r_r r_i" in lines(plain(page.page(relevant(A))))
    assert "The scene has no effects." in text()
    assert "The scene has no effects." not in text(A)


def test_a_change_without_bound_is_said_to_have_none() -> None:
    wild = one("w", float("inf"), 0.5, kept=True, is_finite=False)
    assert "Unbounded: near a frequency where H_env = 0 or a dynamics is infinite, no bound exists." in text(A, wild)
    assert "w w-model unbounded 0.5 kept" in lines(plain(page.page(relevant(A, wild))))
    assert "Unbounded" not in text(A, B)


def test_which_effect_changes_most_is_told_where_there_are_several_and_any_is_known() -> None:
    dominance = (
        Made(low=Rational(0), high=Rational("1.23456"), effect=A.effect),
        Made(low=Rational("1.23456"), high=Rational(15), effect=B.effect),
    )
    shown = lines(plain(page.page(relevant(A, B, dominance=dominance))))
    assert shown.count("0 to 1.235 a") == shown.count("1.235 to 15 b") == 1
    title = "Which one changes the ratios most"
    assert title in shown
    for effects, own in (((A,), dominance), ((A, B), ()), ((), ())):
        assert title not in text(*effects, dominance=own)


def crossing(low: float, high: float, *, certain: bool = True, name: str = "real") -> Any:
    return Made(criterion=Made(name=name), bounds=(low, high), certain=certain)


def test_crossings_of_the_full_scene_are_enclosed_or_told_as_a_number_where_they_are_known_to_a_millionth() -> None:
    found = (crossing(2.0, 2.0000019), crossing(2.0, 2.0000021, certain=False, name="imag"), crossing(5.0, 5.5))
    shown = lines(plain(page.page(relevant(A, crossings=found))))
    assert "real 2 at least one" in shown
    assert "imag 2 to 2 none, one or several" in shown
    assert "real 5 to 5.5 at least one" in shown
    assert "The full scene has no crossing on the band." in text(A)
    assert "no crossing on the band" not in text(A, crossings=found)


def test_whether_a_smaller_set_would_do_is_told_as_far_as_it_is_known() -> None:
    assert text(A).endswith(
        "outside the intervals above the full scene has no crossing. No smaller set of effects stays within the tolerance, 0.02."
    )
    assert text(A, smallest=False).endswith("This is the smallest set found; that no smaller one does is not proven.")
    figures = [
        (x.name, x.wide)
        for y in page.page(relevant(A)).blocks
        if isinstance(y, Section)
        for x in y.blocks
        if isinstance(x, Figure)
    ]
    assert figures == [("influences", True)]


# The head of a report


def number(x: object) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


ENDS = [Point(number(x), {}, {}, {}) for x in (0, 4, 6, 10, 15)]


def evaluated(**own: Any) -> dict[str, str]:
    given: dict[str, Any] = {
        "bandwidth": ENDS[1].omega, "transparent": (Interval(ENDS[0], ENDS[1]),), "chart": Made(points=ENDS), "bandwidths": None, "felt": (), "stable": True,
        "passivity": Made(holds=True, active=()), "undecided": (), "certified": True,
    }  # fmt: skip
    e: Any = Made(**(given | own))
    return {said(key): said(x).replace("\xa0", " ") for key, x in findings(e)}


def test_the_bandwidth_is_told_in_both_units_with_what_else_is_transparent() -> None:
    for own, told in (
        ({}, "4 rad/s (0.63662 Hz)"),
        (
            {"transparent": (Interval(ENDS[0], ENDS[1]), Interval(ENDS[2], ENDS[3]))},
            "4 rad/s (0.63662 Hz, and on 1 more)",
        ),
        (
            {"transparent": (Interval(ENDS[0], ENDS[4]),), "bandwidth": ENDS[4].omega},
            "15 rad/s (2.3873 Hz, the whole band)",
        ),
        ({"bandwidth": None, "transparent": ()}, "none (transparent nowhere on the band)"),
        ({"bandwidth": None, "transparent": (Interval(ENDS[2], ENDS[4]),)}, "none (transparent from 6 rad/s on)"),
        (
            {"bandwidths": Made(least=number(3), most=number(5))},
            "4 rad/s (0.63662 Hz); 3 to 5 rad/s for the range of the threshold",
        ),
        ({"bandwidths": Made(least=None, most=number(5))}, "4 rad/s (0.63662 Hz)"),
        ({"bandwidths": Made(least=number(3), most=None)}, "4 rad/s (0.63662 Hz)"),
    ):
        assert evaluated(**own)["bandwidth"] == told


def test_what_is_felt_first_is_what_begins_lowest() -> None:
    felt = [
        Made(words=words, band=Interval(ENDS[i], ENDS[4]))
        for words, i in (("higher mass", 3), ("lower stiffness", 1), ("higher damping", 2))
    ]
    for order in itertools.permutations(felt):
        assert evaluated(felt=order)["first felt as"] == "lower stiffness from 4 rad/s on"
    assert evaluated()["first felt as"] == "nothing is noticed on the band"


def test_stability_and_passivity_are_told_as_decided_or_not() -> None:
    for stable, told in (
        (True, "stable (no pole with Re s ≥ 0)"),
        (False, "NOT stable (a pole with Re s ≥ 0)"),
        (None, "undecided (whether a pole has Re s ≥ 0 is open)"),
    ):
        assert evaluated(stable=stable)["under imposed motion"] == told
    for own, told in (
        (None, "undecided"), (Made(holds=None, active=()), "undecided"), (Made(holds=True, active=()), "holds (at all frequencies)"),
        (Made(holds=False, active=()), "does not hold (poles forbid it)"),
        (Made(holds=False, active=(Interval(ENDS[1], ENDS[2]), Interval(ENDS[3], ENDS[4]))), "does not hold (active from 4 to 6 rad/s)"),
    ):  # fmt: skip
        assert evaluated(passivity=own)["every passive hand"] == told


def test_what_stayed_open_is_counted() -> None:
    assert evaluated()["these answers"] == "proven (none missed, none invented)"
    for number_open, told in (
        (0, "jumps of the bandwidth stayed open"),
        (1, "1 tangency stayed open"),
        (2, "2 tangencies stayed open"),
    ):
        assert (
            evaluated(certified=False, undecided=range(number_open))["these answers"] == f"in part undecided ({told})"
        )
