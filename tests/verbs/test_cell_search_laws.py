"""Cells of frequency and value that a search cuts: boxes, what is likely, proven and left, against NumPy and tables."""

from __future__ import annotations

import random
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import s
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability import search
from haptisym.verbs.stability.curves import Meeting
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.pairs import Characteristic
from haptisym.verbs.stability.search import _Cells

q = Symbol("q", positive=True)


def loop_of(expression: Expr, low: Expr | None = Integer(0)) -> Loop:  # noqa: B008  exact and constant
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), q, low)


def cells_of(low: Any, high: Any) -> Any:
    return _Cells(Characteristic(loop_of(s**2 + s + 9 + q * exp(-s / 2))), Rational(low), Rational(high))


def rows(draw: random.Random, count: int) -> Array:
    """So many cells, as shares of frequencies and of values."""
    return np.array([[sorted(draw.sample([n / 16 for n in range(17)], 2)) for _ in range(2)] for _ in range(count)])


@pytest.mark.parametrize("seed", range(3))
def test_the_box_of_a_cell_is_where_its_shares_of_frequencies_and_of_values_lie_and_hardly_more(seed: int) -> None:
    draw = random.Random(seed)
    low, high = sorted(draw.sample(range(-9, 10), 2))
    own, cells = cells_of(low, high), rows(draw, 12)
    middle, half = own._box(cells)
    for cell, m, r in zip(cells, middle, half, strict=True):
        for i, (start, size) in enumerate(((0.0, own.axis.reach), (low, high - low))):
            a, b = start + size * cell[i][0], start + size * cell[i][1]
            assert m[i] - r[i] <= a
            assert m[i] + r[i] >= b
            assert (m[i] - r[i], m[i] + r[i]) == pytest.approx((a, b), abs=1e-11 * (abs(start) + size))
            assert r[i] > (b - a) / 2


@pytest.mark.parametrize("seed", range(3))
def test_a_cell_lies_in_a_box_if_both_of_its_sides_do_to_their_ends(seed: int) -> None:
    draw = random.Random(seed)
    middle = np.array([[draw.randint(-4, 4), draw.randint(-4, 4)] for _ in range(60)], float)
    half = np.array([[draw.randint(0, 2), draw.randint(0, 2)] for _ in range(60)], float)
    center, size = np.array([draw.randint(-2, 2), draw.randint(-2, 2)], float), np.array([3.0, 2.0])
    true = [
        all(c - z <= m - h and m + h <= c + z for m, h, c, z in zip(a, b, center, size, strict=True))
        for a, b in zip(middle, half, strict=True)
    ]
    assert [*search._inside(middle, half, center, size)] == true
    assert {*true} == {True, False}


@pytest.mark.parametrize("seed", range(4))
def test_a_pair_is_likely_in_cells_whose_straight_part_is_0_near_them_if_they_bend_little(seed: int) -> None:
    """C = c0 + c1 t + t c2 t, |rest| <= r: where c0 + c1 t = 0 by NumPy, and by how much the bent part moves that at most."""
    rng = np.random.default_rng(seed)
    own, count = cells_of(0, 1), 400
    J = rng.normal(size=(2, count, 1, 2))
    values = rng.normal(size=(2, count, 1)) * rng.choice([0.3, 1, 2], count)[:, None]
    bends = rng.normal(size=(2, count, 1, 2, 2)) * 10.0 ** rng.uniform(-4, -1, count)[:, None, None, None]
    rest = 10.0 ** rng.uniform(-4, -1.5, (2, count, 1))
    J[:, 0] = 0  # no slope at all
    parts = [SimpleNamespace(c0=values[i], c1=J[i], c2=bends[i], r=rest[i]) for i in (0, 1)]
    own.axis = SimpleNamespace(parts=lambda _: parts)
    told = dict(own._likely(np.zeros((count, 2, 2))))
    near = 0
    for n in range(1, count):
        inverse = np.linalg.inv(J[:, n, 0])
        place = -inverse @ values[:, n, 0]
        bent = abs(inverse) @ (abs(bends[:, n, 0]).sum((-1, -2)) + rest[:, n, 0])
        assert (n in told) == (max(abs(place)) < search._NEAR and max(bent) < search._STRAIGHT)
        if n in told:
            assert told[n] == pytest.approx(place, rel=1e-9, abs=1e-12)
        near += n in told
    assert 0 not in told
    assert 5 < near < count - 5


class Pairs:
    """Boxes in which one pair is proven, by the frequency in their middle; None where there is none."""

    def __init__(self, pairs: dict[float, Any]) -> None:
        self.pairs, self.asked = pairs, list[tuple[Any, Any]]()

    def only(self, omega: Any, value: Any) -> Any:
        self.asked.append((omega, value))
        return self.pairs.get(round(float(omega.mid()), 6))


def pair(omega: float, value: float) -> Any:
    return SimpleNamespace(
        at=lambda _: (arb(omega), arb(value)),
        value=ExactNumber(Rational(value)),
        frequency=ExactNumber(Rational(omega)),
    )


def test_a_proven_pair_is_found_once_and_its_box_is_known_from_then_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells about 10, 20, 30 and 40 rad/s: a pair, none, one whose value is not told, and the first one once more."""
    own = cells_of(-8, 8)
    half = np.array([0.5, 0.25])
    middle = np.array([[w, 3.0] for w in (10.0, 20.0, 30.0, 40.0, 10.1, 40.2)])
    first, untold = pair(11.25, 3.0), pair(30.25, 3.0)
    own.form = Pairs({10.05: first, 30.05: untold, 40.05: pair(11.25, 3.0), 10.15: first})
    monkeypatch.setattr(_Cells, "_box", lambda *_: (middle, np.tile(half, (6, 1))))
    shift = np.array([0.1, -0.4])
    monkeypatch.setattr(_Cells, "_likely", lambda *_: ((i, shift) for i in range(6)))
    monkeypatch.setattr(_Cells, "_value", lambda _, x: None if x is untold else x.value)
    own._prove(np.zeros((6, 2, 2)))
    assert own.found == [Meeting(first.value, first.frequency)]
    known = [[*map(float, m), *map(float, h)] for m, h in own._known]
    assert known == [pytest.approx([w, 2.9, 1.5, 0.75]) for w in (10.05, 40.05)]
    middles = [round(float(w.mid()), 3) for w, _ in own.form.asked]
    assert middles == [10.05, 20.05, 30.05, 40.05]  # the last two lie in boxes that are known
    for w, value in own.form.asked:
        assert (float(value.mid()), float(w.rad()), float(value.rad())) == pytest.approx((2.9, 1.5, 0.75))


@pytest.mark.parametrize("seed", range(3))
def test_a_cell_is_settled_in_a_known_box_or_where_it_begins_at_0_and_holds_no_pair(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw = random.Random(seed)
    own, cells = cells_of(-1, 3), rows(draw, 40)
    boxes = [
        (np.array([draw.uniform(0, 9), draw.uniform(-1, 3)]), np.array([draw.uniform(2, 9), draw.uniform(1, 3)]))
        for _ in range(2)
    ]
    asked: list[tuple[Any, Any]] = []

    def is_clear_at_0(omega: Any, value: Any) -> bool:
        asked.append((omega, value))
        return bool(value.mid() > 1)

    own._known, own.form = boxes, SimpleNamespace(is_clear_at_0=is_clear_at_0)
    told = own._is_settled(cells)
    middle, half = own._box(cells)
    number = 0
    for i, cell in enumerate(cells):
        inside = any((m - z <= middle[i] - half[i]).all() and (middle[i] + half[i] <= m + z).all() for m, z in boxes)
        at_0 = not inside and cell[0][0] == 0
        number += at_0
        assert told[i] == (inside or (at_0 and middle[i][1] > 1))
    assert len(asked) == number > 0
    assert all(w.contains(0) for w, _ in asked)


def test_a_value_that_looks_like_0_is_0_only_where_it_is_proven_that_0_has_a_root_on_the_axis_there() -> None:
    """s^2 + 4 + q (s + 1) has +-2j at q = 0."""
    own = cells_of(-1, 1)
    inside, beside = arb(2, 0.01), arb(3, 0.01)

    def told(omega: Any, value: Any, at: Any) -> Any:
        own.form = SimpleNamespace(loop=SimpleNamespace(at=at))
        return own._value(SimpleNamespace(at=lambda _: (omega, value), value="its own"))

    def fails(_: Any) -> Any:
        raise UndecidedError("why")

    def roots(x: Any) -> Any:
        return loop_of(s**2 + 4 + q * (s + 1), None).at(x)

    assert [told(inside, v, at) for v in (arb(1, 0.5), arb(-3, 2)) for at in (roots, fails)] == ["its own"] * 4
    for value in (arb(0), arb(0.1, 0.2), arb(-1, 1)):
        assert told(inside, value, roots) == ExactNumber(Integer(0))
        assert told(beside, value, roots) is None
        assert told(inside, value, fails) is None


@pytest.mark.parametrize("seed", range(4))
def test_all_that_is_neither_clear_nor_settled_is_cut_until_it_is_or_left_in_a_gap(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bad values at single frequencies: cells that hold one are open as long as they are wider than a share."""
    draw = random.Random(seed)
    low, high = Rational(draw.randint(-5, 5)), Rational(draw.randint(6, 9))
    own = cells_of(low, high)
    bad = [(draw.random(), draw.random()) for _ in range(draw.randint(0, 3))]
    ends = draw.choice([0.0, 0.05])
    looked: list[Array] = []

    def holds(cell: Array) -> bool:
        return any(all(a <= x <= b for x, (a, b) in zip(at, cell, strict=True)) for at in bad)

    def bounded(cells: Array) -> tuple[Array, Array]:
        looked.append(cells)
        return np.array([not holds(x) for x in cells]), cells[:, :, 1] - cells[:, :, 0]

    own.axis = SimpleNamespace(reach=10.0, bounded=bounded)
    monkeypatch.setattr(_Cells, "_prove", lambda *_: None)
    monkeypatch.setattr(_Cells, "_is_settled", lambda _, cells: (cells[:, :, 1] - cells[:, :, 0]).max(-1) < ends)
    monkeypatch.setattr(search, "_DEEPEST", 24)
    gaps = [search._ends(x) for x in own.settle()]
    first = looked[0]
    assert first.shape[1:] == (2, 2)
    assert (first[:, 1] == [0, 1]).all()
    assert (first[0, 0, 0], first[-1, 0, 1]) == (0, 1)
    assert all(a[0, 1] == b[0, 0] > a[0, 0] for a, b in pairwise(first))
    for cells in looked[14:]:  # from where the side that moves it most was cut as often as columns are narrow
        widths = cells[:, :, 1] - cells[:, :, 0]
        assert (widths.max(-1) < 2.01 * widths.min(-1)).all()
    if ends or not bad:
        assert gaps == []
        assert bool(bad) is (len(looked) > 1)
        return
    assert all(any(a <= low + (high - low) * Rational(y) <= b for a, b in gaps) for _, y in bad)
    assert all(low <= a < b <= high for a, b in gaps)
    assert all(b - a < (high - low) / 100 for a, b in gaps)
    assert len(looked) == 24
