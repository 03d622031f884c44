"""The one search, at its own seam: what it says of cells against values of polynomials, whose Taylor models are written out here."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count, product
from math import comb, inf
from typing import Any

import numpy as np
import pytest

from haptisym.kernel.budget import limited, timed_by
from haptisym.kernel.errors import LimitError
from haptisym.kernel.where import Batches, Cells, LineBound, Search, halves, no_better, no_worse, search, told, zeros

Array = Any
ROUNDED = 1e-12  # some twenty terms of at most 1.5 in a box of numbers up to 1


@dataclass
class Cubic:
    """The sum of c_n prod x_i^n_i over exponents n of degree up to 3; ``looked`` : cells that were bounded."""

    terms: dict[tuple[int, ...], float]
    looked: int = 0

    def __call__(self, cells: Array) -> LineBound:
        """Terms up to second order about the middles, x_i = m_i + h_i t_i, and the sizes of those of third order."""
        self.looked += len(cells)
        m, h = cells.mean(-1), (cells[..., 1] - cells[..., 0]) / 2
        n, sides = m.shape
        c0, c1, c2, r = np.zeros(n), np.zeros((n, sides)), np.zeros((n, sides, sides)), np.zeros(n)
        for exponents, c in self.terms.items():
            for own in product(*(range(k + 1) for k in exponents)):
                size = np.full(n, c)
                for i, (j, k) in enumerate(zip(own, exponents, strict=True)):
                    size = size * comb(k, j) * m[:, i] ** (k - j) * h[:, i] ** j
                among = [i for i, j in enumerate(own) for _ in range(j)]
                if len(among) < 3:
                    (c0 if not among else c1[:, among[0]] if len(among) == 1 else c2[:, among[0], among[1]])[:] += size
                r += 1e-15 * abs(size) + (abs(size) if len(among) == 3 else 0.0)
        return LineBound.of(c0, c1, c2, r)

    def at(self, points: Array) -> Array:
        """Its values, to within ROUNDED."""
        return sum(c * np.prod(points ** np.array(n), -1) for n, c in self.terms.items())


def cubic(rng: np.random.Generator, sides: int) -> Cubic:
    exponents = [n for n in product(range(4), repeat=sides) if sum(n) <= 3]
    return Cubic({n: float(rng.integers(-8, 9)) / 8 - (not any(n)) / 2 for n in exponents})


def unit(sides: int, pieces: int = 4) -> Array:
    """All of some sides from 0 to 1, the first one in pieces."""
    cells, steps = np.tile([0.0, 1.0], (pieces, sides, 1)), np.arange(pieces + 1) / pieces
    cells[:, 0] = np.stack([steps[:-1], steps[1:]], -1)
    return cells


def wider(finest: float) -> Any:
    return lambda cells: cells[..., 1] - cells[..., 0] > finest


def inside(rng: np.random.Generator, cell: Array, many: int) -> Array:
    """Points of a cell, (points, sides): half of them on its corners, where bounds are nearest to what they bound."""
    shares = rng.random((many, len(cell)))
    shares[: many // 2] = shares[: many // 2].round()
    return cell[:, 0] + (cell[:, 1] - cell[:, 0]) * shares


def volume(cells: Cells) -> float:
    return float(np.prod(cells.outer[..., 1] - cells.outer[..., 0], -1).sum())


def shown(rng: np.random.Generator, judges: list[Cubic], cells: Cells) -> None:
    """Asserts at points of cells what is guaranteed of each of them."""
    for n in rng.permutation(len(cells))[:60]:
        floor, ceiling, by, cell = cells.floor[n], cells.ceiling[n], int(cells.by[n]), cells.outer[n]
        assert (by >= 0) is bool(ceiling < inf)
        if by >= 0:
            q = inside(rng, cell, 20)
            assert (judges[by].at(np.insert(q, 0, ceiling, -1)) > -ROUNDED).all()
        points = inside(rng, np.concatenate([[[0.0, 1.0]], cell]), 400)
        omega = points[:, 0]
        for f, pieces in zip(judges, cells.pieces, strict=True):
            values, own = f.at(points), pieces.inner[pieces.owner == n, 0]
            is_open = ((own[:, :1] <= omega) & (omega <= own[:, 1:])).any(0)
            assert (omega >= floor)[values > ROUNDED].all()
            assert (values < ROUNDED)[~is_open & (omega < ceiling)].all()


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(12))
def test_cells_fill_the_domain_and_are_told_as_values_in_them_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    outer, many = 1 + seed % 3, 1 + seed // 3 % 2
    judges = [cubic(rng, 1 + outer) for _ in range(many)]
    found = search(judges, unit(outer), unit(1), wide=wider([0, 2.0**-9, 2.0**-5, 2.0**-3][outer]))
    assert sum(map(volume, found.parts)) == 1
    assert volume(found.left) < [0, 0.01, 0.2, 0.6][outer]
    assert (found.kept.floor == inf).all()
    assert (found.broken.ceiling < inf).all()
    for part in found.parts:
        shown(rng, judges, part)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(4))
def test_what_else_a_cell_is_to_be_settled_for_counts_for_all_of_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    f = cubic(rng, 3)
    found = search([f], unit(1), unit(2), wide=wider(2.0**-6), last=1, most=4000)
    assert sum(map(volume, found.parts)) == 1
    points = rng.random((100_000, 3))  # omega, q, and what else
    values = f.at(points)
    for cell in found.kept.outer[:, 0]:
        assert (values[(points[:, 1] >= cell[0]) & (points[:, 1] <= cell[1])] < ROUNDED).all()
    never = search([lambda cells: f(cells).never_positive()], unit(1), unit(2), wide=wider(2.0**-6), last=1, most=4000)
    assert not len(never.broken)
    assert volume(never.kept) <= volume(found.kept) + 1e-9
    for cell in found.broken.outer[:8, 0]:
        for q in inside(rng, np.array([cell]), 4)[:, 0]:
            grid = np.stack([x.ravel() for x in np.meshgrid(np.linspace(0, 1, 65), q, np.linspace(0, 1, 65))], -1)
            assert f.at(grid).max() > -1e-3  # the grid may miss by as much where a maximum is narrow


PARABOLA = Cubic({(1, 0): 1.0, (0, 1): -1.0, (0, 2): 1.0})  # omega - q (1 - q): first(q) = q (1 - q)


@pytest.mark.parametrize(("bound", "is_proven"), [(0.2501, True), (0.2499, False)])
def test_that_no_value_is_better_than_a_bound_is_proven_where_the_best_is_not(bound: float, *, is_proven: bool) -> None:
    own = Search([PARABOLA], Cells.of(unit(1), [unit(1)]), wide=wider(2.0**-12), settled=no_better(bound))
    settled = [*own]
    assert (len(own.left) == 0) is is_proven
    assert all((x.ceiling <= bound).all() for x in settled)
    assert is_proven or (own.left.outer.min() < 0.5 < own.left.outer.max())


@pytest.mark.parametrize(("bound", "is_proven"), [(0.0899, True), (0.0901, False)])
def test_that_no_value_is_worse_than_a_bound_is_proven_where_the_worst_is_not(bound: float, *, is_proven: bool) -> None:
    box = np.array([[[0.1, 0.6]]])  # there the least of q (1 - q) is at 0.1
    own = Search(
        [PARABOLA], Cells.of(box, [unit(1)]), wide=wider(2.0**-14), settled=no_worse(bound), rank=lambda x: x.floor
    )
    settled = [*own]
    assert (len(own.left) == 0) is is_proven
    assert all((x.floor >= bound).all() for x in settled)
    assert is_proven or own.left.outer.min() == 0.1


def test_a_stricter_rule_between_rounds_and_more_of_the_band_lose_no_value() -> None:
    own = Search(
        [PARABOLA],
        Cells.of(unit(1), [unit(1) * 0.1]),
        wide=wider(2.0**-9),
        settled=no_better(0.05),
        batch=32,
        rank=lambda x: x.floor,
    )
    seen = []
    for n, settled in enumerate(own):
        seen.append(settled)
        if n == 1:
            own.settled = no_better(0.02)
            own.restart(Cells.together([*seen, own.left]).extended([0.1 + 0.9 * unit(1)]))
            seen = []
    cells = Cells.together([*seen, own.left])
    assert volume(cells) == 1
    shown(np.random.default_rng(0), [PARABOLA], cells)
    assert np.isclose(own.left.outer.min(), 0.0204, atol=1e-3)  # q (1 - q) = 0.02
    assert all((x.ceiling <= 0.02).all() for x in seen)


def test_where_nothing_is_known_nothing_is_told_and_beside_it_all_is() -> None:
    def judge(cells: Array) -> LineBound:
        """-1, but for q from 0.4 to 0.41 and omega from 0.5 to 0.6, where it may be anything."""
        (a, b), (low, high) = cells[:, 0].T, cells[:, 1].T
        lost = (a < 0.6) & (b > 0.5) & (low < 0.41) & (high > 0.4)
        return LineBound.between(np.where(lost, -inf, -1.0), np.where(lost, inf, -1.0), np.zeros(cells.shape[:2]))

    found = search([judge], unit(1), unit(1), wide=wider(2.0**-10))
    assert not len(found.broken)
    assert found.left.outer.min() <= 0.4
    assert found.left.outer.max() >= 0.41
    assert volume(found.left) < 0.01 + 4 * 2.0**-10


def test_a_remainder_of_what_cancels_is_not_cut_along_omega_alone() -> None:
    looked = 0

    def judge(cells: Array) -> LineBound:
        nonlocal looked
        looked += len(cells)
        h = (cells[..., 1] - cells[..., 0]) / 2
        c1 = np.stack([1e-6 * h[:, 0], 1e-12 * h[:, 1]], -1)  # F = -1 + 1e-6 omega, all but free of q
        return LineBound.of(np.full(len(cells), -1.0), c1, np.zeros((len(cells), 2, 2)), 100 * h[:, 1] ** 3)

    found = search([judge], unit(1), unit(1), wide=wider(2.0**-10))
    assert volume(found.kept) == 1
    assert looked < 2000


def test_with_no_function_all_is_kept() -> None:
    assert volume(search([], unit(2), unit(1), wide=wider(0.1)).kept) == 1


@pytest.mark.parametrize("seconds", [1, 3, 10, 30])
def test_whenever_the_time_is_over_what_is_not_told_is_left(seconds: int) -> None:
    judge = cubic(np.random.default_rng(5), 3)
    with timed_by(count().__next__), limited(seconds):
        found = search([judge], unit(2), unit(1), wide=wider(2.0**-7))
    assert sum(map(volume, found.parts)) == 1
    assert len(found.left)
    for part in found.parts:
        shown(np.random.default_rng(seconds), [judge], part)


def test_pieces_that_are_looked_at_are_limited() -> None:
    judge = cubic(np.random.default_rng(5), 3)
    found = search([judge], unit(2), unit(1), wide=wider(2.0**-30), most=500)
    assert sum(map(volume, found.parts)) == 1
    assert judge.looked < 4 * 500


@pytest.mark.parametrize("seed", range(40))
def test_a_curve_is_negative_where_its_largest_value_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middle, slope, bend = rng.normal(size=(3, 50)) * 10.0 ** rng.integers(-6, 3, (3, 50))
    bend[:10] = slope[10:20] = 0.0
    bend[20:30] = slope[20:30] = 0.0
    rest = np.abs(rng.normal(size=50))
    curve = LineBound(middle, slope, bend, rest, np.zeros((50, 1)))
    with np.errstate(all="ignore"):
        top = np.nan_to_num(np.clip(-slope / (2 * bend), -1, 1))
    largest = np.max(
        [middle + rest + t * (slope + t * bend) for t in (np.full(50, -1.0), np.full(50, 1.0), top)], axis=0
    )
    clear = np.abs(largest) > 1e-9 * (np.abs(middle) + np.abs(slope) + np.abs(bend) + rest)
    assert (curve.negative == (largest < 0))[clear].all()
    assert not (curve.never_positive().middle - curve.never_positive().rest > 0).any()
    which = np.flatnonzero(~curve.negative)
    assert curve.known_negative(which).negative.all()
    unknown = LineBound(middle, slope, bend, np.where(middle > 0, np.nan, rest), np.zeros((50, 1)))
    assert (unknown.known == (middle <= 0)).all()
    assert not unknown.negative[middle > 0].any()


@pytest.mark.parametrize("seed", range(3))
def test_a_step_of_newton_s_method_leaves_out_no_zero_and_nothing_where_the_slope_may_vanish(seed: int) -> None:
    """(1 + q) (omega - zero) with q up to ``wide`` off 0, about whose zeros everything is known."""
    rng = np.random.default_rng(seed)
    omega = np.sort(rng.normal(size=(60, 2)))
    (start, end), zero = omega.T, np.linspace(-1, 2, 60) * (omega[:, 1] - omega[:, 0]) + omega[:, 0]
    radius, wide = (end - start) / 2, np.where(np.arange(60) % 5 == 0, 1.5, 0.1)
    at_middle = (start + end) / 2 - zero
    found = zeros(omega, at_middle, wide * abs(at_middle), (radius * (1 - wide), radius * (1 + wide)))
    inside, open_ = (zero > start) & (zero < end), wide > 1
    assert ((found[:, 0] <= zero) & (zero <= found[:, 1]))[inside].all()
    assert (found[open_] == omega[open_]).all()
    width = (found[:, 1] - found[:, 0])[~open_]
    assert (width <= 0.5 * abs(at_middle)[~open_] + 1e-9).all()


@pytest.mark.parametrize("ranked", [False, True])
def test_a_queue_gives_every_row_once_and_keeps_what_a_loop_was_left_with(*, ranked: bool) -> None:
    first = np.random.default_rng(0).permutation(100.0 * np.arange(1, 41))
    waiting = Batches(first, size=7, rank=(lambda x: x) if ranked else None, most=21)
    given = [*map(list, waiting)]
    assert [x for own in given for x in own] == (sorted(first) if ranked else list(first))[:21]
    assert waiting.examined == 21
    assert sorted([*waiting.rest, *(x for own in given for x in own)]) == sorted(first)
    waiting = Batches(first, size=7)
    for own in waiting:
        waiting.add(own[:3])
        break
    assert sorted(waiting.rest) == sorted([*first[7:], *first[:3]])
    with timed_by(count().__next__), limited(2), pytest.raises(LimitError):
        list(waiting)
    assert set(first[21:]) <= {*waiting.rest, *first[:3]}
    waiting.replace(first[:2])
    assert sorted(waiting.rest) == sorted(first[:2])


def test_halves_fill_their_cells_and_told_is_kept_or_broken() -> None:
    cells = np.random.default_rng(1).random((5, 3, 2)).cumsum(-1)
    side = np.array([0, 1, 2, 1, 0])
    lower, upper = np.split(halves(cells, side), 2)
    for n, i in enumerate(side):
        assert lower[n, i, 0] == cells[n, i, 0] < lower[n, i, 1] == upper[n, i, 0] < upper[n, i, 1] == cells[n, i, 1]
        assert (np.delete(lower[n], i, 0) == np.delete(upper[n], i, 0)).all()
    assert told(np.array([inf, 0.0, 0.0]), np.array([inf, 1.0, inf])).tolist() == [True, True, False]
