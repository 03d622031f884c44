"""An evaluation says how its crossings were computed, to which precision, and in which time."""

from __future__ import annotations

from dataclasses import replace
from itertools import count

import pytest

import haptisym as hs
from haptisym.judge import evaluation
from haptisym.kernel.reals import RealNumber


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("fu2019", "certified polynomial roots"),
        ("delayed-spring", "arctangents of certified polynomial roots"),
        ("satellite-contact", "interval Newton in ball arithmetic"),
    ],
)
def test_the_effort_names_the_method_and_grows_with_the_digits(name: str, method: str) -> None:
    few, many = (hs.evaluate(hs.load_scene(name), digits=n).effort for n in (15, 300))
    assert few.method == many.method
    assert method in few.method
    assert 15 * 3.3 < few.bits < 300 * 3.3 < many.bits


def test_crossings_in_closed_form_say_so() -> None:
    """r_r of a spring with a mass is m W/k: at the band's end it is c exactly."""
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.shunt(m="0.1"),), (0, 10))
    assert hs.evaluate(scene).effort.method == "closed form"


def test_the_time_is_that_of_finding_the_crossings_and_of_all_their_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that stands still but for the digits: a second for each crossing, after ten seconds of isolation."""
    scene = hs.load_scene("fu2019").with_band(0, 1000)
    result = replace(hs.evaluate(scene, digits=20), isolation=10.0)
    asked: list[int] = []
    digits = RealNumber.digits

    def counted(self: RealNumber, n: int = 15) -> str:
        asked.append(n)
        return digits(self, n)

    monkeypatch.setattr(RealNumber, "digits", counted)
    monkeypatch.setattr(evaluation.time, "perf_counter", lambda: 1e6 + len(asked))
    assert result.effort.seconds == 10.0 + len(result.crossings)
    assert asked == [20] * len(result.crossings)
    assert len(asked) > 2


def test_the_time_of_isolation_is_that_between_two_looks_at_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = count(1000)
    monkeypatch.setattr(evaluation.time, "perf_counter", lambda: float(next(ticks)))
    result = hs.evaluate(hs.load_scene("fu2019"))
    assert result.isolation == 1.0
    assert result.effort.seconds == 2.0
    assert hs.Evaluation(result.scene, result.distortion, result.chart, stable=True).isolation == 0.0


def test_without_crossings_nothing_was_needed() -> None:
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag("1 MHz"),))
    assert hs.evaluate(scene).effort.method == "none needed"


@pytest.mark.parametrize("digits", [0, -3, 2.5, "7", None])
def test_digits_are_a_whole_number_from_one_on(digits: object) -> None:
    with pytest.raises(hs.SceneError, match=f"digits: {digits} must be a whole number, at least 1"):
        hs.evaluate(hs.load_scene("fu2019"), digits)  # type: ignore[arg-type]


def test_one_digit_will_do_and_fifteen_are_given_unasked() -> None:
    paper = hs.load_scene("fu2019")
    assert [c["digits"] for c in hs.evaluate(paper, 1).to_dict()["crossings"]] == ["8", "10"]
    assert [len(c["digits"]) for c in hs.evaluate(paper).to_dict()["crossings"]] == [16, 16]


def test_a_symbol_has_no_evaluation() -> None:
    free = hs.Scene(hs.environments.mass_spring_damper(k=hs.symbols("k")), (hs.effects.delay("1 ms"),))
    with pytest.raises(hs.SceneError, match=r"environment.k = k is a symbol where a number is needed"):
        hs.evaluate(free)


def test_the_document_names_the_bounds_for_any_environment_only_where_there_are_some() -> None:
    spring, shunt = hs.environments.mass_spring_damper(k=100), hs.effects.shunt(m="0.1")
    gain, none = hs.effects.series("1.3"), hs.Scene(spring)
    assert hs.evaluate(hs.Scene(spring, (shunt,))).to_dict()["any_environment"] is None
    assert hs.evaluate(hs.Scene(spring, (gain,))).to_dict()["any_environment"] == {
        "transparent_below": None,
        "opaque_above": 0.0,
    }
    assert hs.evaluate(none).to_dict()["any_environment"] == {"transparent_below": 15.0, "opaque_above": None}


def test_the_document_is_written_for_people_too() -> None:
    scene = replace(hs.load_scene("fu2019"), title="Prüfstand α")
    lines = hs.evaluate(scene).to_json().splitlines()
    assert lines[:3] == ["{", '  "schema": "haptisym.evaluation/1",', '  "title": "Prüfstand α",']
    assert lines[3:6] == ['  "band": [', "    0.0,", "    15.0"]
    assert not any("relevance" in line or "undecided" in line for line in lines)
