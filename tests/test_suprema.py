"""Branch and bound: the enclosure holds the supremum, is narrow, and says on which side of a limit it lies."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, isclose

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptisym.pruning.suprema import WIDTH, supremum


@dataclass(frozen=True)
class Span:
    """An interval."""

    low: float
    high: float

    def halves(self) -> tuple[Span, Span]:
        middle = (self.low + self.high) / 2
        return Span(self.low, middle), Span(middle, self.high)


def waves(amplitudes: list[float], slope: float):  # type: ignore[no-untyped-def]
    """A sum of cosines, with bounds from its largest slope."""

    def value(x: float) -> float:
        return abs(sum(a * cos(n * x) for n, a in enumerate(amplitudes, 1)))

    def bounds(x: Span) -> tuple[float, float]:
        middle = value((x.low + x.high) / 2)
        return middle, middle + slope * (x.high - x.low) / 2

    return value, bounds


@given(st.lists(st.floats(0.1, 2), min_size=1, max_size=4))
def test_the_largest_value_of_a_sum_of_waves_is_enclosed(amplitudes: list[float]) -> None:
    _, bounds = waves(amplitudes, sum(n * a for n, a in enumerate(amplitudes, 1)))
    found = supremum(Span(-1.0, 1.5), bounds)
    assert found.least <= sum(amplitudes) * (1 + 1e-12)  # all are 1 at 0
    assert found.most >= sum(amplitudes) * (1 - 1e-12)
    assert isclose(found.least, found.most, rel_tol=2 * WIDTH)


@pytest.mark.parametrize(("limit", "above"), [(2.9, True), (3.1, False)])
def test_a_limit_is_compared_with_no_more_work_than_that_takes(limit: float, above: bool) -> None:  # noqa: FBT001
    asked = []
    _, bounds = waves([1, 2], 5)
    found = supremum(Span(-1, 1.5), lambda x: (asked.append(x), bounds(x))[1], limit)  # type: ignore[func-returns-value]
    assert (found.least > limit, found.most <= limit) == (above, not above)
    assert len(asked) < 200


def test_what_is_proven_to_be_unbounded_ends_the_search() -> None:
    found = supremum(Span(0, 1), lambda x: (inf, inf) if x.low <= 0.3 < x.high <= 0.4 else (0.0, inf))
    assert not found.is_finite
    assert found.least == inf
