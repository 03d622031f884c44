"""An evaluation says how its crossings were computed, to which precision, and in which time."""

from __future__ import annotations

import pytest

import haptisym as hs


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
    assert few.seconds > 0
    assert many.seconds > 0


def test_without_crossings_nothing_was_needed() -> None:
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag("1 MHz"),))
    assert hs.evaluate(scene).effort.method == "none needed"
