"""The largest circle in a region and the smallest one around it: against how far each of many directions reaches its border."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sympy import Integer, sqrt

import haptisym as hs
from haptisym.judge.bounds import around
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.symbols import omega
from haptisym.model.jndtables import read_threshold

ANGLES = np.linspace(0, 2 * np.pi, 100_001)
X, Y = np.cos(ANGLES), np.sin(ANGLES)


def square(a: float, b: float) -> Any:
    return np.maximum(abs(X) / a, abs(Y) / b)


def ellipse(a: float, b: float, t: float) -> Any:
    return np.sqrt(((X / a) ** 2 - 2 * t * X * Y / (a * b) + (Y / b) ** 2) / (1 - t * t))


def polygon(corners: list[list[float]]) -> Any:
    rows = [(p, q) for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)]
    return np.max([(X * (v - y) - Y * (u - x)) / (x * v - y * u) for (x, y), (u, v) in rows], axis=0)


SKEW = [[0.5, 0.1], [0.2, 0.6], [-0.3, 0.3], [-0.4, -0.2], [0.1, -0.5]]
TURNED = [[0.1, 0.6], [-0.5, 0.1], [-0.2, -0.3], [0.3, -0.2]]
REGIONS: dict[str, tuple[Any, Any]] = {
    "square": (0.3, square(0.3, 0.3)),
    "wide": ({"real": 0.5, "imag": 0.2}, square(0.5, 0.2)),
    "high": ({"real": 0.2, "imag": 0.5}, square(0.2, 0.5)),
    "disc": ({"shape": "ellipse", "real": 0.3, "imag": 0.3}, ellipse(0.3, 0.3, 0)),
    "ellipse": ({"shape": "ellipse", "real": 0.3, "imag": 0.6}, ellipse(0.3, 0.6, 0)),
    "tilted": ({"shape": "ellipse", "real": 0.3, "imag": 0.6, "tilt": 0.5}, ellipse(0.3, 0.6, 0.5)),
    "tilted back": ({"shape": "ellipse", "real": 0.4, "imag": 0.4, "tilt": -0.8}, ellipse(0.4, 0.4, -0.8)),
    "diamond": ({"shape": "diamond", "real": 0.3, "imag": 0.3}, abs(X) / 0.3 + abs(Y) / 0.3),
    "long diamond": ({"shape": "diamond", "real": 0.6, "imag": 0.2}, abs(X) / 0.6 + abs(Y) / 0.2),
    "upright diamond": ({"shape": "diamond", "real": 0.2, "imag": 0.6}, abs(X) / 0.2 + abs(Y) / 0.6),
    "polygon": ({"shape": "polygon", "corners": SKEW}, polygon(SKEW)),
    "turned polygon": ({"shape": "polygon", "corners": TURNED}, polygon(TURNED)),
}
"""Each with how many times it must be enlarged to reach 1 in each direction."""


@pytest.mark.parametrize("name", REGIONS)
def test_some_change_leaves_a_region_beyond_its_largest_circle_and_every_one_beyond_the_smallest_around_it(
    name: str,
) -> None:
    """Of changes whose squared length is omega."""
    given, times = REGIONS[name]
    some, every = around(read_threshold(given), RealFunction(Ring().axis.convert(omega)))
    table = chart({"some": some, "every": every}, Integer(0), Integer(2))
    for key, radius in (("some", 1 / times.max()), ("every", 1 / times.min())):
        [inside] = table.where(lambda signs, key=key: signs[key] <= 0)  # type: ignore[misc]
        assert inside.low is table.points[0]
        assert float(inside.high.omega) == pytest.approx(radius**2, rel=1e-4)


def test_a_limit_for_each_way_and_a_floor_keep_the_circle_inside_that_of_the_least_limit() -> None:
    for given, least in (
        ({"real": {"higher": 0.3, "lower": 0.2}, "imag": 0.4}, 0.2), ({"real": {"higher": 0.3, "lower": 0.5}, "imag": 0.4}, 0.3),
        ({"real": 0.6, "imag": {"higher": 0.3, "lower": 0.1}}, 0.1), ({"real": 0.3, "imag": 0.4, "floor": "1 N/m"}, 0.3),
    ):  # fmt: skip
        some, _ = around(read_threshold(given), RealFunction(Ring().axis.convert(omega)))
        [inside] = chart({"some": some}, Integer(0), Integer(2)).where(lambda signs: signs["some"] <= 0)
        assert float(inside.high.omega) == pytest.approx(least**2, rel=1e-15)


def test_every_environment_is_judged_by_those_circles() -> None:
    """A gain 1 + omega^2/100 behind a spring: |G - 1| is the largest circle's radius, and the smallest's around it, where it is."""
    for name, (given, times) in REGIONS.items():
        effect = hs.effects.series("1 - s^2/100")
        found = hs.evaluate(
            hs.Scene(hs.environments.mass_spring_damper(k=1), (effect,), (0, 30), given)
        ).any_environment
        assert found is not None
        assert found.transparent_below is not None
        assert found.opaque_above is not None
        ends = [float(found.transparent_below) ** 2 / 100, float(found.opaque_above) ** 2 / 100]
        assert ends == pytest.approx([1 / times.max(), 1 / times.min()], rel=1e-4), name


GAIN = hs.effects.series("1 - s^2/100")


def of_any(given: Any) -> Any:
    return hs.evaluate(hs.Scene(hs.environments.mass_spring_damper(k=1), (GAIN,), (0, 30), given)).any_environment


@pytest.mark.parametrize(
    "given",
    [
        {"real": 0.3, "imag": 0.3, "floor": "1 N/m"}, {"real": {"higher": 0.3, "lower": 0.2}, "imag": 0.3},
        {"real": 0.3, "imag": {"higher": 0.3, "lower": 0.2}}, {"real": {"higher": 0.3, "lower": 0.2}, "imag": 0.3, "floor": "1 N/m"},
    ],
    ids=str,
)  # fmt: skip
def test_where_more_than_the_length_of_a_change_matters_nothing_is_said_of_any_environment(given: Any) -> None:
    assert of_any(given) is None


def test_thresholds_that_are_no_fractions_have_their_circles_too() -> None:
    found = of_any(hs.Threshold(sqrt(2) / 10, sqrt(2) / 5))
    assert [float(x) ** 4 / 10**4 for x in (found.transparent_below, found.opaque_above)] == pytest.approx(
        [0.02, 0.1], rel=1e-14
    )
