"""Limits in time and words about the work, on a clock that stands where the test puts it; cells that wait, of which none is lost."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count, pairwise
from time import process_time, sleep
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import haptisym as hs
from haptisym.kernel.budget import Waiting, afford, left, limited, share, spared, spent, tick, timed_by
from haptisym.kernel.errors import LimitError, SceneError


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Iterator[Clock]:
    found = Clock()
    with timed_by(found):
        yield found


def over(work: Any, *given: Any) -> bool:
    try:
        work(*given)
    except LimitError:
        return True
    return False


def test_a_word_is_said_at_most_ten_times_a_second(clock: Clock) -> None:
    words: list[tuple[float, Any]] = []
    with limited(told=lambda *word: words.append((clock.now, word))) as own:
        for n in range(40):
            tick(n, 40, "cells")
            tick()
            clock.now += 1 / 32
        own.say(40, None, "end")
    times = [x for x, _ in words]
    assert times[0] == 100
    assert all(0.1 <= b - a <= 0.1 + 1 / 32 for a, b in pairwise(times))
    assert words == [*((x, (32 * (x - 100), 40, "cells")) for x in times[:-1]), (101.25, (40, None, "end"))]


def test_while_work_goes_on_inside_that_nobody_is_told_of_the_last_word_outside_is_said_again(clock: Clock) -> None:
    words: list[Any] = []
    with limited(told=lambda *word: words.append(word)) as own:
        tick(3, 8, "samples")
        for inner in (None, lambda *_: None, None):
            with limited(50, inner):
                clock.now += 1
                tick(1, 99, "cells")
        own.say(4, 8, "samples")
    assert words == [*[(3, 8, "samples")] * 3, (4, 8, "samples")]
    words.clear()
    with (
        limited(told=lambda *word: words.append(word)),
        limited(50),
    ):  # who says nothing outside leaves it to the inside
        tick(1, 99, "cells")
        for _ in range(3):  # which has loops without a name in it
            clock.now += 1
            tick(5, 6)
    assert words == [(1, 99, "cells")] * 4


def test_the_time_is_over_after_the_limit_and_not_at_it_for_the_nearer_of_two(clock: Clock) -> None:
    assert (left(), over(tick)) == (None, False)
    for outer, inner, own in ((8, 4, 4), (8, None, 8), (8, 12, 8), (None, 4, 4)):
        clock.now = 100.0
        with limited(outer) as around, limited(inner) as within:
            assert left() == own
            clock.now = 100.0 + own
            assert (left(), over(tick), within.reached) == (0, False, False)
            clock.now += 1
            assert (left(), over(within.say, 1, 2, "")) == (0, False)
            with pytest.raises(LimitError, match=f"limit of {own} s"):
                tick()
            assert (within.reached, around.reached) == (True, False)
            with spared():
                assert (left(), over(tick)) == (None, False)
        assert around.reached == (own == outer)  # a nearer limit inside cuts nothing else short
    for wrong in (0, -1, float("inf"), float("nan"), "3"):
        with pytest.raises(SceneError, match="limit"), limited(wrong):  # type: ignore[arg-type]
            pass


def test_a_share_of_what_is_left_may_be_used_and_the_rest_is_there_afterwards(clock: Clock) -> None:
    with share(0.5):
        assert left() is None
    words: list[Any] = []
    with limited(16, lambda *word: words.append(word)):
        clock.now += 8
        with share(0.25):
            assert left() == 2
            clock.now += 3
            assert over(tick, 1, 2, "first")
        assert (left(), over(tick, 2, 2, "next")) == (5, False)
        clock.now += 9
        with share(0.5):
            assert left() == 0
            clock.now += 1
            assert over(tick)
    assert words == [(2, 2, "next")]


def test_products_that_take_longer_than_what_is_left_are_not_begun(clock: Clock) -> None:
    assert not over(afford, 10**30)
    with limited(10) as own:
        clock.now += 6
        most = 4 * 50_000_000
        assert [over(afford, most), over(afford, most // 10, 10), own.reached] == [False, False, False]
        assert [over(afford, most + 1), own.reached] == [True, True]
        assert [over(afford, most // 10, 11), over(afford, 11, most // 10)] == [True, True]
        clock.now += 5
        assert over(afford, 0)


def test_memory_is_bounded_without_a_limit_too() -> None:
    """Tangents of 24 angles: a common denominator of 2^24 terms, each with 24 exponents."""
    powers = "+".join(f"s^({k}/89)" for k in range(1, 25))
    lag = 'effects = [{ model = "first-order-lag", omega_c = 20 }]'
    scene = hs.parse_scene(f'{lag}\nenvironment = {{ model = "expression", H = "{powers}" }}')
    with pytest.raises(LimitError, match="memory"):
        hs.evaluate(scene, limit=None)


def test_a_share_of_a_limit_that_is_over_is_that_limit_and_a_nearer_limit_inside_is_not(clock: Clock) -> None:
    reason = "^stopped at the limit of 8 s; a longer limit may decide it$"
    with limited(8) as own:
        clock.now += 0.5
        with limited(1) as nearer:
            clock.now += 2
            assert over(tick)
        assert (nearer.cut, own.cut, spent()) == (1, None, (2.5, 8))
        with share(1 / 4), share(1 / 2):
            assert (left(), spent()) == (5.5 / 8, (2.5, 8))
            clock.now += 1
            with pytest.raises(LimitError, match=reason), limited(60):
                tick()
        assert (own.cut, spent()) == (8, (3.5, 8))
    assert spent() is None


def test_work_that_is_stopped_ends_at_its_next_tick_in_whatever_limits_it_is_and_says_so(clock: Clock) -> None:
    with limited(None) as outer, limited(60) as own, share(1 / 2):
        assert not over(tick)
        own.stop()
        with limited(5), pytest.raises(LimitError, match=r"^stopped at the limit \(interrupted\)$"):
            tick()
        with spared():
            assert not over(tick)
        assert over(afford, 1)
    assert (own.reached, own.cut, outer.cut) == (True, None, None)
    assert not over(tick)


def test_a_limit_counts_processor_time_not_how_long_one_waits() -> None:
    with limited(0.05):
        sleep(0.06)
        tick()
        began = process_time()
        while process_time() - began < 0.06:
            pass
        assert over(tick)


# Cells


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


def test_a_limit_in_time_leaves_the_cell_in_hand_among_the_rest() -> None:
    waiting, seen = Waiting([1, 2, 3]), list[int]()
    with timed_by(count().__next__), limited(2), pytest.raises(LimitError):
        seen.extend(waiting)
    assert seen
    assert sorted([*seen, *waiting.rest]) == [1, 2, 3]
