"""The designer's questions in a report: which values of each parameter will do, when nobody asks, and the words of ends."""

from __future__ import annotations

import random
from math import sqrt
from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Integer, Rational, Symbol, pi

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.pages import design, require
from haptisym.verbs.require.feasible import Kind
from haptisym.writing.document import Table
from haptisym.writing.plain import said

E, F = hs.environments, hs.effects


def rows(scene: hs.Scene) -> list[list[str]]:
    tables = [x for x in design.design(hs.evaluate(scene)) if isinstance(x, Table)]
    return [[said(x).replace("\xa0", " ") for x in row] for t in tables for row in t.rows]


def test_each_parameter_and_the_threshold_have_the_values_that_will_do_and_what_binds() -> None:
    """Behind a lag r_i is w wc/(w^2 + wc^2), largest at 15 rad/s: a tenth for wc = 15 (5 + sqrt(24)), and 24/73 for wc = 40."""
    found = rows(hs.Scene(E.mass_spring_damper(k="100 N/m"), (F.first_order_lag(40),), (0, 15), "0.1"))
    assert [x[:2] for x in found] == [["k", "100 N/m"], ["ω_c", "40 rad/s"], ["c", "0.1"]]
    assert found[0][2:] == ["no value", "–"]
    assert found[1][2] == f"ω_c ≥ {15 * (5 + sqrt(24)):.5g} rad/s"
    assert found[1][3] == "r_i at 15 rad/s (2.3873 Hz)"
    assert found[2][2:] == [f"c ≥ {24 / 73:.5g}", "r_i at 15 rad/s (2.3873 Hz)"]


def test_more_than_eight_parameters_and_scenes_that_take_their_time_are_not_asked_about(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[str] = []
    monkeypatch.setattr(design, "require", lambda _, path: asked.append(path))
    for count, is_quick, told in ((8, True, 9), (9, True, 0), (3, False, 0), (0, True, 1)):
        asked.clear()
        monkeypatch.setattr(design, "is_quick", lambda _, is_quick=is_quick: is_quick)
        own: Any = Made(scene=Made(parameters=[Made(path=f"p{n}") for n in range(count)]))
        assert len(design.requirements(own)) == len(asked) == told
        assert asked == [*(f"p{n}" for n in range(count)), "evaluation.jnd"][:told]
        if not told:
            assert list(design.design(own)) == []


def test_what_binds_is_told_with_its_frequency_where_it_has_one() -> None:
    def binding(*bound: tuple[str, Any]) -> str:
        ends = [Made(bindings=[Made(criterion=Made(symbol=name), omega=omega)]) for name, omega in bound]
        own: Any = Made(ends=ends)
        return said(design._binding(own))

    at = ExactNumber(2 * pi)
    assert binding() == "–"
    assert binding(("r_r", at)) == "r_r at 6.2832 rad/s (1 Hz)"
    assert binding(("r_r", None), ("r_i", at)) == "r_r and r_i at 6.2832 rad/s (1 Hz)"
    for unit, told in (("1", ""), ("N*s/m", " N·s/m")):
        own: Any = Made(unit=unit, symbol=Symbol("k"))
        assert design._unit(own) == told


# Ends of requirements


@pytest.mark.parametrize(
    ("value", "asked", "told"), [(None, None, True), (None, 3, False), (3, None, False), (3, 3, True), (3, 4, False)]
)
def test_an_end_is_one_of_what_was_asked_about_or_of_what_will_do(
    value: int | None, asked: int | None, told: Any
) -> None:
    own: Any = Made(value=None if value is None else ExactNumber(Integer(value)))
    assert require._is_asked(own, None if asked is None else Integer(asked)) is told


def test_an_end_beside_which_nothing_is_proven_is_rounded_inward() -> None:
    pick = random.Random(3)
    for _ in range(100):
        x = Rational(pick.randint(1, 10**9), pick.choice([7, 10, 999, 10**6]))
        digits = pick.choice([5, 6])
        up, down = (Rational(require._directed(ExactNumber(x), digits, up=way).digits) for way in (True, False))
        assert down <= x <= up
        assert up - down <= x / 10 ** (digits - 2)
        assert require._directed(ExactNumber(x), digits, up=True).value == float(x)
    assert said(require._limit(None, up=True)) == "infinity"
    assert said(require._limit(None, up=False)) == "minus infinity"
    assert said(require._limit(ExactNumber(Rational(1, 3)), up=True)) == "0.333334"
    assert said(require._limit(ExactNumber(Rational(1, 3)), up=False)) == "0.333333"


@pytest.mark.parametrize(
    ("low", "high", "holds", "told"),
    [
        (None, None, True, "all values"), (None, 5, True, "values up to 5"), (0, None, True, "all values ≥ 0"), (0, None, False, "all values > 0"), (1, Rational(5, 2), True, "values from 1 to 2.5"),
    ],
)  # fmt: skip
def test_what_was_asked_about_is_told(low: Any, high: Any, holds: Any, told: str) -> None:
    own: Any = Made(domain=Made(low=low, high=high, holds_low=holds))
    assert require._asked(own) == told


def test_what_binds_where_is_told_with_its_part_and_place() -> None:
    def binding(name: str, kind: Kind, omega: Any = None, *, part: bool = True) -> Any:
        return Made(criterion=Made(name=name, words=f"{name} in a", symbol="r_r"), kind=kind, omega=omega, part=part)

    places = {
        Kind.EDGE: "the band's high end",
        Kind.START: "the band's low end",
        Kind.TOUCH: "a touch inside the band",
        Kind.AXIS: "roots on the imaginary axis",
        Kind.FAR: "far out",
    }
    of_all = {
        Kind.START: "at low frequencies",
        Kind.TOUCH: "a touch",
        Kind.FAR: "at high frequencies",
        Kind.AXIS: "poles",
    }
    assert set(places) == set(Kind)
    for kind, place in places.items():
        assert said(require._where(binding("real", kind))) == place
        assert said(require._where(binding("stable", kind, ExactNumber(2 * pi)))) == f"{place}, 6.2832 rad/s (1 Hz)"
    for kind, place in of_all.items():
        assert said(require._where(binding("passive", kind))) == place
    assert said(require._part(binding("real", Kind.EDGE))) == "r_r (real)"
    assert said(require._part(binding("any", Kind.EDGE, part=False))) == "r_r"
    assert said(require._part(binding("stable", Kind.EDGE))) == "stable in a"
    assert said(require._part(binding("passive", Kind.EDGE))) == "passive in a"
