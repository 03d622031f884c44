"""Branch and bound: the enclosure holds the supremum, is narrow, and says on which side of a limit it lies."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, isclose

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptisym.verbs.effects.suprema import WIDTH, Supremum, supremum


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


@pytest.mark.slow
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


def told(*rows: tuple[float, float]):  # type: ignore[no-untyped-def]
    """Bounds that are given one after the other, and how many were asked for."""
    asked: list[Span] = []

    def bounds(x: Span) -> tuple[float, float]:
        asked.append(x)
        return rows[len(asked) - 1]

    return bounds, asked


def test_cells_with_the_highest_bounds_are_halved_first_and_the_best_of_all_is_told() -> None:
    bounds, asked = told((0.1, 9.0), (0.5, 2.0), (0.2, 3.0), (0.3, 1.0), (1.0, 1.0), (0.6, 1.0), (0.4, 0.5))
    assert supremum(Span(0, 16), bounds) == Supremum(1.0, 1.0)
    assert [(x.low, x.high) for x in asked] == [(0, 16), (0, 8), (8, 16), (8, 12), (12, 16), (0, 4), (4, 8)]


def test_what_is_reached_is_never_told_above_what_is_not_exceeded() -> None:
    bounds, asked = told((0.1, 9.0), (0.5, 2.0), (1.5, 3.0), (0.3, 1.6), (1.5, 1.5), (0.6, 1.1), (0.4, 0.5))
    found = supremum(Span(0, 16), bounds, 1.7)  # the third round leaves at most 1.6
    assert (found, len(asked)) == (Supremum(1.5, 1.6), 7)


@pytest.mark.parametrize(
    ("first", "limit", "asked"),
    [((0.5, 1.0), 1.0, 1), ((0.5, 1.0), 0.49, 1), ((0.5, 1.0), 0.5, 3), ((0.5, 1.0), 0.999, 3), ((0.5, 1.0), None, 3),
     ((1.0, 1.0 + 0.99 * WIDTH), None, 1), ((1.0, 1.0 + 1.01 * WIDTH), None, 3), ((4.0, 4.0 + 2 * WIDTH), None, 1),
     ((0.0, 0.9e-12), None, 1), ((0.0, 1.1e-12), None, 3), ((0.7, 0.7), 0.6, 1)],
)  # fmt: skip
def test_a_search_goes_on_until_the_enclosure_is_narrow_or_on_one_side_of_the_limit(
    first: tuple[float, float], limit: float | None, asked: int
) -> None:
    """Equal to the limit counts as below it, for the bound; a value that is reached must be above."""
    bounds, spans = told(first, (first[1], first[1]), (0.0, 0.0))
    found = supremum(Span(0, 1), bounds, limit)
    assert len(spans) == asked
    assert found == (Supremum(*first) if asked == 1 else Supremum(first[1], first[1]))


def test_a_search_ends_when_bounds_do_not_get_better_and_says_what_it_knows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptisym.verbs.effects.suprema._MOST_CELLS", 30)
    asked: list[Span] = []
    found = supremum(Span(0, 1), lambda x: (asked.append(x), (0.25, 1.0))[1])  # type: ignore[func-returns-value]
    assert found == Supremum(0.25, 1.0)
    assert 10 < len(asked) <= 1 + 2 * 30
    assert found.is_finite
    assert not Supremum(1.0, inf).is_finite
