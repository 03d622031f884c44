"""Rectangles for a loop with a clock: what else varies is cut where that helps, and no more is asked than may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from haptisym.kernel.budget import limited
from haptisym.verbs.tolerances.clockplane import ClockPlane

Cell = Sequence[tuple[Fraction, Fraction]]


@dataclass
class Sheet:
    """Clear where a linear form keeps off a number, and what else varies is no wider than can be seen through."""

    weights: tuple[int, ...]
    number: Fraction
    seen: Fraction
    asked: list[Cell] = field(default_factory=list)

    @property
    def ranges(self) -> tuple[int, ...]:
        return self.weights

    def is_clear(self, cell: Cell) -> bool:
        self.asked.append(cell)
        ends = [sorted((w * a, w * b)) for w, (a, b) in zip(self.weights, cell, strict=True)]
        meets = sum(x[0] for x in ends) <= self.number <= sum(x[1] for x in ends)
        return not meets and all(b - a <= self.seen for a, b in cell[2:])


def areas(*cells: Any) -> list[float]:
    return [float((x[..., 1] - x[..., 0]).prod(-1).sum()) for x in cells]


@pytest.mark.parametrize(("more", "seen"), [(1, "1/4"), (2, "1/2")])
def test_what_else_varies_is_cut_where_a_rectangle_is_clear_for_its_middle(seen: str, more: int) -> None:
    """x + y + a little of the rest about 1: most of the plane is clear, but for whole ranges of the rest nothing shows to be."""
    loop = Sheet((64, 64, *[1] * more), Fraction(64), Fraction(seen))
    clear, left = ClockPlane([loop], 1 / 8, 10**6).rectangles()  # type: ignore[list-item]
    assert sum(areas(clear, left)) == 1
    meeting = [x for x in clear.tolist() if x[0][0] + x[1][0] <= 1 <= x[0][1] + x[1][1] + more / 64]
    assert meeting == []
    assert all(x[0][0] + x[1][0] <= 1 <= x[0][1] + x[1][1] + more / 64 for x in left.tolist())
    assert areas(left)[0] < 0.4


def test_where_the_middle_of_what_else_varies_is_not_clear_the_rectangle_is_cut_and_the_rest_is_not() -> None:
    loop = Sheet((1, 1, 1), Fraction(3, 2), Fraction(1))
    ClockPlane([loop], 1 / 16, 10**6).rectangles()  # type: ignore[list-item]
    half, whole = [Fraction(1, 2)] * 2, [Fraction(0), Fraction(1)]
    across = [x for x in loop.asked if x[0][0] + x[1][0] <= 1 <= x[0][1] + x[1][1]]
    assert len(across) > 30
    assert all(list(x[2]) in (half, whole) for x in across)
    assert any(list(x[2]) not in (half, whole) for x in loop.asked)


@pytest.mark.parametrize(("most", "loops"), [(100, 1), (400, 2), (1000, 1)])
def test_no_more_cells_are_looked_at_than_may_be_and_the_pieces_of_one_rectangle(most: int, loops: int) -> None:
    own = [Sheet((1, 1, 1), Fraction(3, 2), Fraction(1, 64)) for _ in range(loops)]
    clear, left = ClockPlane(own, 2.0**-12, most).rectangles()  # type: ignore[arg-type]
    asked = sum(len(x.asked) for x in own)
    assert 0.8 * most < asked <= most + 100 * loops
    assert sum(areas(clear, left)) == 1


def test_when_the_time_is_over_what_was_not_looked_at_is_left() -> None:
    loop = Sheet((1, 1, 1), Fraction(9), Fraction(1))
    with limited(1e-9):
        clear, left = ClockPlane([loop], 1 / 16, 10**6).rectangles()  # type: ignore[list-item]
    assert (len(clear), len(left), loop.asked) == (0, 64, [])
    assert areas(left) == [1]
    clear, left = ClockPlane([loop], 1 / 16, 10**6).rectangles()  # type: ignore[list-item]
    assert (len(clear), len(left), len(loop.asked)) == (64, 0, 64)
    assert left.shape == (0, 2, 2)
    assert isinstance(clear, np.ndarray)
