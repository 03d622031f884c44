"""The page of a map of two parameters, of maps put together by hand: which slices are listed, what is said between them."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace as Made
from typing import Any

import pytest
from pagewords import flat, lines, row
from sympy import Rational, Symbol

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.pages import designmap
from haptisym.writing.plain import plain

SCENE = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(20),), (0, 15), "0.1")
CLEAR = [Made(name=x, kept="transparent", rule=f"r_{x[0]} <= c_{x}") for x in ("real", "imag")]
STABLE = Made(name="stable", kept="stable", rule="stable in the hand a")
FREE = (Made(symbol=Symbol("omega_n"), unit="rad/s"), Made(symbol=Symbol("k"), unit="N/m"))


def number(x: object) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


def slice_of(at: object, *spans: tuple[object, object], kinds: tuple[str, ...] = (), **own: Any) -> Any:
    """Where the first parameter has a value: those of the second one that will do."""
    feasible = [Made(low=Made(value=number(a), closed=True), high=Made(value=number(b), closed=True)) for a, b in spans]
    ends = [Made(bindings=[Made(kind=Made(value=kind)) for kind in kinds])]
    given = {
        "feasible": feasible,
        "ends": ends,
        "undecided": [],
        "free": FREE[1],
        "limit": None,
        "reason": "",
        "certified": True,
    } | own
    requirement = Made(**given)
    return Made(at=Rational(str(at)), requirement=requirement, sets=[requirement], contours=[])


def shown(*slices: Any, **own: Any) -> str:
    given: dict[str, Any] = {
        "scene": SCENE, "free": FREE, "slices": slices, "criteria": CLEAR, "that": ("transparent",), "certified": True, "figure": None, "asides": list,
        "thresholds": (), "deviation": None, "height": 400.0, "gaps": (), "is_coarse": False, "within": None, "proofs": (), "stiffest": None, "lines": (),
    }  # fmt: skip
    return plain(designmap.page(Made(**(given | own))))  # type: ignore[arg-type]


BOTH = (slice_of(1, (2, 3), kinds=("touch", "edge")), slice_of(2), slice_of(3, (4, 5), (6, 7), kinds=("edge",)))


def test_the_slices_that_hold_values_are_counted_and_what_binds_at_them_is_named_once() -> None:
    text = flat(shown(*BOTH))
    assert (
        "3 exact slices along ω_n: 2 of them hold values of k that make the display transparent. What binds at the boundary: edge and touch."
        in text
    )
    assert "What binds" not in flat(shown(slice_of(1, (2, 3)), slice_of(2)))
    assert "0 of them hold values" in flat(shown(slice_of(1), slice_of(2)))
    assert "make the display transparent and stable." in flat(shown(*BOTH, criteria=[*CLEAR, STABLE]))


def test_each_slice_has_its_values_or_says_that_they_are_undecided() -> None:
    page = shown(
        *BOTH,
        slice_of("3.5", undecided=[(number(1), number(2))]),
        slice_of(4, (1, 2), undecided=[(number(5), number(6))]),
    )
    assert "ω_n (rad/s) transparent for" in lines(page)
    body = {
        x.split()[0]: x.partition(" ")[2]
        for x in lines(page)
        if x.split()[1:] and x.split()[0] in ("1", "2", "3", "3.5", "4")
    }
    assert body == {
        "1": "2 ≤ k ≤ 3 N/m",
        "2": "no value",
        "3": "4 ≤ k ≤ 5 N/m or 6 ≤ k ≤ 7 N/m",
        "3.5": "UNDECIDED",
        "4": "1 ≤ k ≤ 2 N/m",
    }
    assert "ω_n (rad/s) will do" in lines(shown(*BOTH, that=("transparent", "stable")))
    assert "ω_n (rad/s) fit for every passive hand for" in lines(shown(*BOTH, that=("passive",)))
    plain_number = (Made(symbol=Symbol("zeta"), unit="1"), FREE[1])
    assert "ζ transparent for" in lines(shown(*BOTH, free=plain_number))


@pytest.mark.parametrize("count", [2, 3, 10, 11, 12, 21, 22, 41, 100])
def test_at_most_eleven_slices_are_listed_evenly_and_the_first_and_the_last_always(count: int) -> None:
    page = shown(*(slice_of(n, (n, n + 1)) for n in range(count)))
    at = [int(x.split()[0]) for x in lines(page) if " ≤ k ≤ " in x]
    assert (at[0], at[-1]) == (0, count - 1)
    assert len(at) <= 11
    steps = {b - a for a, b in pairwise(at[:-1])}
    assert len(steps) <= 1
    assert len(at) == count or steps == {-(-(count - 1) // 10)}
    text = flat(page)
    assert (f"Listed here: {len(at)} of the slices; the others are in --json." in text) == (len(at) < count)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (CLEAR, "r_r ≤ c_real and r_i ≤ c_imag on the whole band"),
        ([*CLEAR, STABLE], "r_r ≤ c_real and r_i ≤ c_imag on the whole band; stable in the hand a"),
        ([STABLE], "stable in the hand a"),
        ([STABLE, Made(name="passive", kept="passive", rule="fit for all")], "stable in the hand a; fit for all"),
    ],
)
def test_the_condition_names_what_is_asked_of_the_band_and_what_is_asked_besides(asked: list[Any], told: str) -> None:
    assert row(shown(*BOTH, criteria=asked), "condition") == told


def test_what_is_undecided_is_told_with_its_reasons_and_nothing_is_called_certain_then() -> None:
    assert "Certain: every value of a slice is proven." in flat(shown(*BOTH))
    late = slice_of(4, undecided=[(number(1), number(2))], limit=2.0, reason="it turns often")
    open_too = slice_of(5, undecided=[(number(1), number(2))], reason="it is long")
    decided = slice_of(6, (1, 2), limit=3.0, reason="not told")
    again = slice_of(7, undecided=[(number(1), number(2))], reason="it is long")
    text = flat(shown(late, open_too, decided, again, certified=False))
    assert (
        "UNDECIDED in some slices, for which there was no time left (it turns often) (it is long): see --json." in text
    )
    assert "Certain" not in text
    assert "UNDECIDED in some slices (it is long): see --json." in flat(shown(open_too, decided, certified=False))


def gaps(*deviations: float | None) -> list[Any]:
    return [Made(deviation=x) for x in deviations]


@pytest.mark.parametrize(
    ("own", "told"),
    [
        ({}, "draws straight lines, off; that is not proven. --slices N gives more of them."),
        ({"deviation": 1.23456}, "off by 1.24 N/m (0.31 % of the range) at the most, as estimated from how its boundary bends at the slices; that is not proven."),
        ({"gaps": gaps(0.5, None)}, "is not proven. Between one pair of slices, which differ in kind or are undecided, nothing is said."),
        ({"gaps": gaps(None, 0.5, None)}, "Between 2 pairs of slices, which differ in kind or are undecided, nothing is said. --slices"),
        ({"gaps": gaps(0.5, 0.25)}, "draws straight lines, off; that is not proven. --slices"),
        ({"within": Rational(1, 100)}, "!--slices N"),
        ({"within": Rational(1, 100), "is_coarse": True}, "that is not proven. --slices N gives more of them."),
    ],
)  # fmt: skip
def test_between_slices_an_estimate_is_told_rounded_up_and_where_there_is_none(own: dict[str, Any], told: str) -> None:
    text = flat(shown(*BOTH, **own))
    assert (told.removeprefix("!") in text) is not told.startswith("!")


def proof(of: str, share: float, *, jnd: object = None) -> Any:
    return Made(of=of, jnd=None if jnd is None else Rational(str(jnd)), rectangles=Made(share_left=share))


def test_what_is_proven_between_slices_too_is_told_with_the_area_that_is_left_and_how_near_the_boundary_is() -> None:
    first, second = proof("transparent", 0.012345), proof("stable", 0.2, jnd="0.075")
    bounds = {id(first): 2.0001, id(second): None}
    page = shown(
        *BOTH,
        proofs=(first, second),
        bound=lambda x: bounds[id(x)],
        criteria=[*CLEAR, Made(name="stable", kept="stable in a", rule="s")],
    )
    text = flat(page)
    assert (
        "Proven for all values of both, between slices too: what is transparent, and what is not, but for 1.24 % of the area of the map, which is left open "
        "and holds its boundary. Where lines join slices, its boundary lies within 2.01 N/m (0.501 % of the range) of them, or of an end of the range."
    ) in text
    assert "what is stable in a with a threshold of 7.5 %, and what is not, but for 20 % of the area" in text
    assert text.count("Where lines join") == 1
    assert "Proven for all" not in flat(shown(*BOTH))


def test_the_stiffest_wall_the_contours_and_the_classical_bounds_are_told_where_there_are_any() -> None:
    wall = (slice_of("2.5"), number(1234))
    asked = [*CLEAR, Made(name="stable", kept="stable in a", rule="s")]
    told = "The stiffest wall of these slices that is stable in a stays below k = 1234 N/m, at ω_n = 2.5 rad/s."
    assert told in flat(shown(*BOTH, stiffest=wall, criteria=asked))
    assert "stiffest" not in flat(shown(*BOTH))
    held = [Made(feasible=[1], certified=True), Made(feasible=[], certified=True), Made(feasible=[1], certified=False)]
    contoured = [
        Made(**(vars(x) | {"contours": [one, two]})) for x, one, two in zip(BOTH, held, held[:1] * 3, strict=True)
    ]
    text = flat(shown(*contoured, thresholds=(Rational(1, 20), Rational(1, 8))))
    assert "With a threshold of 5 % 2 of them hold values that are not noticed, others being undecided." in text
    assert "With a threshold of 12.5 % 3 of them hold values that are not noticed." in text
    assert "With a threshold" not in flat(shown(*BOTH))
    page = shown(*BOTH, lines=[Made(name="Colgate", rule="b > K T/2", assumes="a free hand")])
    assert row(page, "Colgate") == "b > K T/2 (a free hand)"
    assert "Beside the exact sets the figure has classical bounds" in flat(page)
    assert "classical bounds" not in flat(shown(*BOTH))
