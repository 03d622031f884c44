"""Cells wait, are given in order, and none is lost whatever ends the loop."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptisym.kernel.budget import limited, share, tick
from haptisym.kernel.errors import LimitError
from haptisym.kernel.subdivision import Waiting


def widest(cell: tuple[int, int]) -> int:
    return cell[0] - cell[1]


@given(st.integers(1, 60), st.integers(1, 20), st.integers(0, 40), st.sampled_from([None, widest]))
def test_the_cells_that_are_settled_and_those_that_are_left_are_the_whole(
    size: int, narrow: int, leave: int, rank: Any
) -> None:
    waiting = Waiting([(0, size)], rank, most=37)
    settled = []
    for n, (low, high) in enumerate(waiting):
        if n == leave:
            break
        if high - low > narrow:
            middle = (low + high) // 2
            waiting.add((low, middle), (middle, high))
        else:
            settled.append((low, high))
    assert waiting.examined <= 37
    assert sorted(x for a, b in (*settled, *waiting.rest) for x in range(a, b)) == [*range(size)]
    assert rank or settled == sorted(settled)


def test_the_best_cell_is_given_first_and_of_equal_ones_the_first() -> None:
    waiting = Waiting([3, 1, 2, 11], lambda x: x % 10)
    given_ = []
    for x in waiting:
        given_.append(x)
        if x == 1:
            waiting.add(0, 5)
    assert given_ == [1, 0, 11, 2, 3, 5]


def test_a_limit_in_time_leaves_the_cell_in_hand_among_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter(range(100))
    monkeypatch.setattr("haptisym.kernel.budget.monotonic", lambda: float(next(now)))
    waiting, seen = Waiting([1, 2, 3]), list[int]()
    with limited(2), pytest.raises(LimitError):
        seen.extend(waiting)
    assert seen
    assert len(waiting.rest) == 3 - len(seen)
    assert sorted([*seen, *waiting.rest]) == [1, 2, 3]


def test_a_share_of_a_limit_is_told_beside_the_limit_that_was_set(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("haptisym.kernel.budget.monotonic", lambda: now[0])
    with limited(8), share(1 / 4), share(1 / 2):
        now[0] = 1.01
        with pytest.raises(LimitError, match=r"^not decided within 1 s, its share of the limit of 8 s$"):
            tick()
        with pytest.raises(LimitError, match=r"within 1 s, its share of the limit of 8 s$"), limited(60):
            tick()
    with limited(8):
        now[0] = 9.5
        with pytest.raises(LimitError, match=r"^not decided within the limit of 8 s$"):
            tick()
