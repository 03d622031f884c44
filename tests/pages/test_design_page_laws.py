"""The designer's questions in a report: which values of each parameter will do, and when nobody asks."""

from __future__ import annotations

from math import sqrt
from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Symbol, pi

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.pages import design
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
