"""Reading an evaluation: where a rational frequency lies in it."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import haptisym as hs

BITS = 160


def below(number: Any, omega: Fraction) -> bool:
    """Whether a number of the package lies below a rational frequency; neither may be closer than its enclosure tells."""
    low, high = number.bounds(BITS)
    assert high < omega or omega < low, f"{omega} is too close to {number}"
    return bool(high < omega)


def holds(interval: Any, omega: Fraction) -> bool:
    return below(interval.low.omega, omega) and not below(interval.high.omega, omega)


def number_below(points: Iterable[Any], omega: Fraction) -> int:
    return sum(below(point.omega, omega) for point in points)


def is_transparent(result: hs.Evaluation, omega: Fraction) -> bool:
    return any(holds(interval, omega) for interval in result.transparent)


def is_outside_model(result: hs.Evaluation, omega: Fraction) -> bool:
    return any(holds(interval, omega) for interval in result.outside_model)


def percepts_at(result: hs.Evaluation, part: str, omega: Fraction) -> list[tuple[str, str]]:
    """Property and change of all percepts of a part that hold a frequency: one, or none."""
    found = [p for p in result.percepts if p.part.value == part and holds(p.band, omega)]
    return [(p.property.value, p.change.value) for p in found]


def of_part(result: hs.Evaluation, part: str) -> list[hs.Crossing]:
    return [c for c in result.crossings if c.part.value == part]


def told(result: hs.Evaluation) -> list[tuple[str, float, str, int, int]]:
    """The crossings as plain values: part, omega, kind, sign, multiplicity."""
    return [(c.part.value, float(c.omega), c.kind.value, c.sign, c.multiplicity) for c in result.crossings]


def intervals(found: Iterable[Any]) -> list[tuple[float, float]]:
    return [(float(x.low.omega), float(x.high.omega)) for x in found]


def floats(points: Iterable[Any]) -> list[float]:
    return [float(point.omega) for point in points]
