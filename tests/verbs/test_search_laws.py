"""Branch and bound over band and box, on functions whose zeros were placed: clusters, slopes, ends, and which side is cut."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from random import Random
from typing import Any

import numpy as np
import pytest
from forms import Form

from haptisym.kernel.budget import limited
from haptisym.programs.taylormodels import Model
from haptisym.verbs.tolerances.search import _start, beyond, clusters, together

# --- crossings that were placed ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Branch:
    """One crossing, at a number, a multiple of p, one of q and one of p q."""

    at: float
    p: float
    q: float
    both: float

    def __call__(self, p: float, q: float) -> float:
        return self.at + self.p * p + self.q * q + self.both * p * q

    @property
    def ends(self) -> tuple[float, float]:
        """A bilinear function is least and greatest at corners."""
        found = [self(p, q) for p, q in product((0, 1), repeat=2)]
        return min(found), max(found)

    def moves(self) -> tuple[int, int]:
        """Its way with each parameter, 0 where that turns."""
        along = [(self.p, self.p + self.both), (self.q, self.q + self.both)]
        return tuple((min(x) > 0) - (max(x) < 0) for x in along)  # type: ignore[return-value]


def placed(pick: Random) -> tuple[Form, list[Branch], int]:
    """Up to three crossings that keep apart, the function of either sign beyond the last one."""
    count, sign = pick.randint(1, 3), pick.choice([-1, 1])
    branches = []
    for n in range(count):
        wide = 0.6 / count / 3
        p, q, both = (round(pick.uniform(-wide, wide), 3) for _ in range(3))
        lowest = Branch(0, p, q, both).ends[0]
        branches.append(Branch(0.15 + 0.8 * n / count - lowest, p, q, both))
    lift = pick.choice([0.0, 0.5])

    def of(w: Model, p: Model, q: Model, c: Callable[[float], Model]) -> Model:
        found = c(float(sign)) + (p * q).times(sign * lift)
        for x in branches:
            found = found * (w - c(x.at) - p.times(x.p) - q.times(x.q) - (p * q).times(x.both))
        return found

    return Form(of, 2), branches, sign


@pytest.mark.parametrize("seed", range(6))
def test_each_crossing_that_keeps_apart_has_a_cluster_with_its_ends_and_the_ways_in_which_it_moves(seed: int) -> None:
    form, branches, sign = placed(Random(seed))
    found = clusters(form)  # type: ignore[arg-type]
    assert len(found) == len(branches)
    for n, (x, branch) in enumerate(zip(found, branches, strict=True)):
        low, high = branch.ends
        assert low - 0.03 < x.low <= low <= high <= x.high < high + 0.03
        rising = sign * (-1) ** (len(branches) - 1 - n)
        moves = branch.moves()
        assert x.signs[0] == rising
        assert all(a in (-rising * b, 0) for a, b in zip(x.signs[1:], moves, strict=True))
        if len(branches) == 1:
            assert x.signs[1:] == tuple(-rising * b for b in moves)
        assert x.regular
        assert x.inside
        for p, q in product(np.linspace(0, 1, 6), repeat=2):
            at = [branch(p, q), p, q]
            assert ((x.cells[:, :, 0] <= at) & (at <= x.cells[:, :, 1])).all(-1).any()
    assert all(a.high + 1e-8 < b.low for a, b in pairwise(found))


@pytest.mark.parametrize("seed", range(2))
def test_between_two_shares_of_the_band_the_crossings_there_alone_are_found(seed: int) -> None:
    form, branches, _ = placed(Random(100 + seed))
    for own in branches:
        low, high = own.ends
        start, end = max(low - 0.02, 0), min(high + 0.02, 1)
        [x] = clusters(form, (start, end))  # type: ignore[arg-type]
        assert start <= x.low <= low <= high <= x.high <= end
        cells = np.concatenate(form.asked[-3:])
        assert (start <= cells[:, 0, 0]).all()
        assert (cells[:, 0, 1] <= end).all()
    gap = branches[0].ends[0]
    assert clusters(form, (0, gap * 0.9)) == ()  # type: ignore[arg-type]


def test_without_being_told_where_the_whole_band_is_looked_at_and_nothing_beyond() -> None:
    form = Form(lambda w, p, c: w - p.times(0.5) - c(0.7), 1)
    [x] = clusters(form)  # type: ignore[arg-type]
    assert x.high == pytest.approx(1, abs=1e-12)
    first = form.asked[0]
    assert (first[:, 0, 0].min(), first[:, 0, 1].max()) == (0, 1)
    assert (first[:, 1] == [0, 1]).all()
    cells = _start(3, 0.25, 0.5)
    assert (cells[0, 0, 0], cells[-1, 0, 1]) == (0.25, 0.5)
    assert (cells[1:, 0, 0] == cells[:-1, 0, 1]).all()
    assert (cells[:, 1:] == [0, 1]).all()


@pytest.mark.parametrize("power", [3, 5])
@pytest.mark.parametrize("end", [0.9, 0.99, 0.999])
def test_a_bent_crossing_that_stops_short_of_an_end_of_the_band_is_known_to_keep_clear_of_it(
    end: float, power: int
) -> None:
    """At 0.6 + (end - 0.6) p^power - q/10, and mirrored; it moves one way with both, least with p next to p = 0."""

    def bent(p: Model) -> Model:
        found = p
        for _ in range(power - 1):
            found = found * p
        return found.times(end - 0.62) + p.times(0.02)

    rises = Form(lambda w, p, q, c: w - c(0.6) - bent(p) + q.times(0.1), 2)
    falls = Form(lambda w, p, q, c: w - c(0.4) + bent(p) - q.times(0.1), 2)
    for form, ends, signs in ((rises, (0.5, end), (1, -1, 1)), (falls, (1 - end, 0.5), (1, 1, -1))):
        [x] = clusters(form)  # type: ignore[arg-type]
        assert x.signs == signs
        assert x.inside
        assert x.low <= ends[0]
        assert x.high >= ends[1]
        assert [x.low, x.high] == pytest.approx(ends, abs=0.02)
        assert sum(map(len, form.asked)) < 1500


def test_crossings_that_turn_with_a_parameter_are_soon_told_as_regular() -> None:
    """At 0.3 + (p - 0.4)^2 - q/10: no cell about p = 0.4 has a sign along p, however small."""
    form = Form(lambda w, p, q, c: w - c(0.3) - (p - c(0.4)) * (p - c(0.4)) + q.times(0.1), 2)
    [x] = clusters(form)  # type: ignore[arg-type]
    assert (x.signs, x.inside) == ((1, 0, 1), True)
    assert [x.low, x.high] == pytest.approx([0.2, 0.66], abs=0.02)
    assert sum(map(len, form.asked)) < 1500


def test_what_is_said_to_be_done_is_never_more_than_all_there_is() -> None:
    told: list[tuple[float, float | None, str]] = []
    touching = Form(lambda w, p, c: (w - c(0.5)) * (w - c(0.5)) - p.times(0.01), 1)
    with limited(None, lambda *x: told.append(x)) as budget:
        budget._next = -1e9
        clusters(touching)  # type: ignore[arg-type]
        last = budget._last
    done, total, what = last
    assert total is not None
    assert 0 < done <= total
    assert "cells" in what
    assert sum(map(len, touching.asked)) < 5 * total


# --- how far crossings go ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("highest", [False, True])
def test_a_bound_on_crossings_is_what_was_reached_or_hardly_beyond_the_farthest_one(
    seed: int, *, highest: bool
) -> None:
    """At a +- b (p - m)^2 + c q: the farthest crossing by hand, from a reach short of it, at it and past it."""
    pick = Random(seed)
    out = 1 if highest else -1
    b, m, c = pick.choice([-1, 1]) * pick.uniform(0.1, 0.3), pick.uniform(0.2, 0.8), pick.uniform(-0.1, 0.1)
    form = Form(lambda w, p, q, k: w - k(0.5) - ((p - k(m)) * (p - k(m))).times(b) - q.times(c), 2)
    ends = [0.5 + b * x + c * q for x in (0, m**2, (1 - m) ** 2) for q in (0, 1)]
    farthest = out * max(out * x for x in ends)
    cells = np.concatenate([x.cells for x in clusters(form)])  # type: ignore[arg-type]
    for short in (0.02,):
        found = beyond(form, cells, farthest - out * short, highest=highest)  # type: ignore[arg-type]
        assert -1e-12 <= out * (found - farthest) < 2e-3
    for past in (1e-3, 0.2):
        reached = farthest + out * past
        assert beyond(form, cells, reached, highest=highest) == reached  # type: ignore[arg-type]
    assert beyond(form, cells[:0], 0.4, highest=highest) == 0.4  # type: ignore[arg-type]
    start = np.array(pick.sample(range(400), 400)) / 1000 + 0.3
    many = np.stack([np.stack([start, start + 0.001], -1), *[np.tile([0.0, 1.0], (400, 1))] * 2], 1)
    form.asked.clear()
    beyond(form, many, 0.2 if highest else 0.8, highest=highest)  # type: ignore[arg-type]
    assert sorted(form.asked[0][:, 0, 0]) == sorted(sorted(start, key=lambda x: -out * x)[:256])  # the farthest first
    nowhere = Form(lambda w, p, q, k: w + k(2.0) + p + q, 2)
    assert beyond(nowhere, cells, farthest - out * 0.05, highest=highest) == farthest - out * 0.05  # type: ignore[arg-type]


# --- cells that touch -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_labels_are_those_of_the_heaps_that_touching_cells_make(seed: int) -> None:
    """Boxes on a lattice, which touch at corners, along sides, or not: against heaps merged pair by pair."""
    pick = Random(seed)
    sides = pick.choice([1, 2, 3])
    rows = [[pick.randint(0, 9 if sides > 1 else 40) for _ in range(sides)] for _ in range(30)]
    cells = np.array([[[x, x + pick.choice([0.5, 1, 1])] for x in row] for row in rows], float)

    def touch(a: Sequence[Any], b: Sequence[Any]) -> bool:
        return all(x[0] <= y[1] and y[0] <= x[1] for x, y in zip(a, b, strict=True))

    heap = list(range(len(cells)))
    for i, k in product(range(len(cells)), repeat=2):
        if touch(cells[i], cells[k]) and heap[i] != heap[k]:
            a, b = heap[i], heap[k]
            heap = [min(a, b) if x in (a, b) else x for x in heap]
    assert together(cells).tolist() == heap
    assert together(cells[:0]).tolist() == []
