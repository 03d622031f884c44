"""Cells of band and values in floats, step by step: which are broken, kept or cut, along which side, and what stays open."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Rational

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import LimitError
from haptisym.verbs.require import floatcells
from haptisym.verbs.require.floatcells import FloatCells, Told, _changes, _larger, _Search


def drawn(pick: Random, count: int) -> Any:
    """Cells with a piece of the band from 0 to 1, and values of any sign and size."""
    cells = []
    for _ in range(count):
        a = pick.choice([0.0, 0.25, 0.5])
        band = [a, a + pick.choice([0.5, 1 / 64, 1e-4, 1e-11])]
        low = pick.choice([-1, 1]) * 10.0 ** pick.randint(-9, 4)
        size = pick.choice([1.0, 0.01, 1e-4])
        values = pick.choice(
            [[low, low + abs(low) * size], [low - abs(low) * size, low], [0.0, abs(low)], [-abs(low), 0.0]]
        )
        cells.append([band, values])
    return np.array(cells, float).reshape(-1, 2, 2)


def _known(cell: Any, change: Sequence[float], least: float) -> tuple[bool, tuple[bool, bool]]:
    """Whether a cell is left open, and else along which sides it is cut."""
    (a, b), (c, d) = cell
    width = b - a, (d - c) / max(abs(c), abs(d), least)
    narrow = width[0] < 1e-10, width[1] < 1e-3
    is_known = all(map(isfinite, change))
    weights = change if is_known else ((b - a) / max(abs(b), abs(a), 1e-300), (d - c) / max(abs(c), abs(d), 1e-300))
    wanted = [not small and 4 * x >= max(weights) for small, x in zip(narrow, weights, strict=True)]
    near_0 = max(abs(c), abs(d)) < least and width[0] < 1e-3 and a > 0
    hopeless = near_0 and (not is_known or 4 * weights[1] >= weights[0])
    if narrow[1] and (not any(wanted) or hopeless):
        return True, (False, False)
    return False, (wanted[0], wanted[1] or not any(wanted))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("count", [40, 64, 65, 90])
def test_a_cell_is_cut_along_what_changes_most_and_left_open_where_it_is_narrow(seed: int, count: int) -> None:
    """In four pieces along a side while they are few, else in two; of values far from each other at geometric means."""
    pick = Random(seed)
    for least in (0.0, 1e-3):
        cells = drawn(pick, count)
        changes = np.array([[pick.choice([1.0, 4.0, 5.0, 0.2, nan]), pick.choice([1.0, 4.0, 5.0, 0.2])] for _ in cells])
        told = [_known(x, y, least) for x, y in zip(cells.tolist(), changes.tolist(), strict=True)]
        search = _Search([], least)
        found = search._cut(cells.copy(), changes).tolist()
        assert sorted(search.open) == sorted(
            (x[1][0], x[1][1]) for x, (done, _) in zip(cells.tolist(), told, strict=True) if done
        )
        parts = 4 if 16 * sum(not done for done, _ in told) <= 1024 else 2
        assert len(found) == sum(parts ** sum(sides) for done, sides in told if not done)
        left = {(*x[0], *x[1], *sides) for x, (done, sides) in zip(cells.tolist(), told, strict=True) if not done}
        for a, b, c, d, *sides in left:
            own = [x for x in found if a <= x[0][0] < x[0][1] <= b and c <= x[1][0] < x[1][1] <= d]
            area = sum((x[0][1] - x[0][0]) * (x[1][1] - x[1][0]) for x in own)
            assert area >= (b - a) * (d - c) * (1 - 1e-9)
            for side, (low, high) in enumerate(((a, b), (c, d))):
                pieces = {tuple(x[side]) for x in own}
                assert (low, high) in pieces if not sides[side] else len(pieces) >= parts


class Noted(_Search):
    """What is probed and cut is written down."""

    def __init__(self) -> None:
        super().__init__([], 0.0)
        self.probed, self.cut = list[float](), list[Any]()

    def _probe(self, excess: Any, own: Any) -> None:
        self.probed += own[:, 1, 0].tolist()

    def _cut(self, own: Any, changes: Any) -> Any:
        self.cut.append((own[:, 1, 0].tolist(), changes.tolist()))
        return own


class Excess:
    """Models of cells by where their values begin: bounds and the middle; coefficients that grow with it."""

    def __init__(self, low: Any, high: Any, middle: Any) -> None:
        self.known, self.sizes = (low, high, middle), list[int]()

    def model(self, own: Any, slopes: int) -> Any:
        assert slopes == 0
        self.sizes.append(len(own))
        at = own[:, 1, 0].tolist()
        low, high, middle = (np.array([[known[x]] for x in at]) for known in self.known)
        c1 = np.array([[[x, -2 * x]] for x in at])
        c2 = np.array([[[[1.0, -2.0], [x, 0.0]]] for x in at])
        return SimpleNamespace(bounds=lambda: (low, high), c0=middle, c1=c1, c2=c2, r=np.array([[x / 8] for x in at]))


@pytest.mark.parametrize("count", [0, 1, 30, 1024, 1025, 2100])
def test_a_cell_is_broken_where_all_of_it_is_positive_probed_where_its_middle_is_and_cut_where_neither_is_told(
    count: int,
) -> None:
    pick = Random(count)
    cells = np.array([[[0.0, 1.0], [float(n), n + 1.0]] for n in range(count)]).reshape(-1, 2, 2)
    low = {float(n): pick.choice([-2.0, -1.0, 0.0, 1.0]) for n in range(count)}
    high = {n: x + pick.choice([0.5, 1.0, 3.0]) for n, x in low.items()}
    middle = {n: pick.uniform(low[n], high[n]) for n in low}
    beyond = {n: pick.choice([-1.0, 0.0, 1.0]) for n in low}
    for larger in (None, Excess(beyond, beyond, beyond)):
        search, own = Noted(), Excess(low, high, middle)
        search._round(own, larger, cells)  # type: ignore[arg-type]
        assert (search.looked, sum(own.sizes)) == (count, count)
        assert not own.sizes or max(own.sizes) <= 1024
        assert sorted(search.broken) == [(n, n + 1) for n in low if low[n] > 0]
        assert search.probed == [n for n in low if low[n] < 0 < middle[n]]
        rest = [n for n in low if not (high[n] < 0 or low[n] > 0) and not (larger and beyond[n] < 0)]
        assert search.cut == ([(rest, [[n + 3 + n / 8, 2 * n + n + n / 8] for n in rest])] if count else [])


def test_how_much_a_model_changes_is_told_along_each_side_with_what_is_left() -> None:
    c1, c2, rest = np.array([[1.0, -2.0]]), np.array([[[1.0, -4.0], [0.5, -8.0]]]), np.array([16.0])
    assert _changes(c1, c2, rest).tolist() == [[1 + 5 + 16, 2 + 8.5 + 16]]


def test_at_the_middle_frequency_all_values_of_a_cell_are_broken_or_nothing_is_told() -> None:
    seen = list[Any]()

    def model(points: Any, slopes: int) -> Any:
        seen.append(points.tolist())
        return SimpleNamespace(bounds=lambda: (np.array([[1.0], [0.0], [-1.0]])[: len(points)], None))

    search, excess = _Search([], 0.0), SimpleNamespace(model=model)
    cells = np.array([[[0.0, 0.5], [1.0, 2.0]], [[0.5, 1.0], [3.0, 4.0]], [[0.25, 1.0], [5.0, 6.0]]])
    search._probe(excess, cells)  # type: ignore[arg-type]
    assert search.broken == [(1.0, 2.0)]
    assert seen == [[[[0.25, 0.25], [1, 2]], [[0.75, 0.75], [3, 4]], [[0.625, 0.625], [5, 6]]]]
    search._probe(excess, cells[:0])  # type: ignore[arg-type]
    assert len(seen) == 1
    assert cells[0].tolist() == [[0, 0.5], [1, 2]]


def test_to_begin_with_the_band_has_sixteen_pieces_between_each_two_ends() -> None:
    cells = _Search([], 0.0)._start([-1.0, 0.5, 4.0])
    assert cells.tolist() == [
        [[n / 16, (n + 1) / 16], list(pair)] for pair in ((-1.0, 0.5), (0.5, 4.0)) for n in range(16)
    ]


@pytest.mark.parametrize("stop", [None, 0, 1, 3])
def test_what_waits_when_the_time_is_over_or_enough_was_looked_at_is_open_and_what_is_broken_is_asked_no_more(
    stop: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two conditions the first breaks values from 2 on at once, the other leaves all open; what is 0 is not asked."""
    rounds = list[tuple[str, int]]()

    def of(self: Any, excess: Any, larger: Any, cells: Any) -> Any:
        assert larger == f"beyond {excess.name}"
        rounds.append((excess.name, len(cells)))
        if stop is not None and len(rounds) > 2 * stop:
            raise LimitError("the time is over")
        if excess.name == "first":
            self.broken += [(2.0, 3.0), (3.0, 4.0)]
            self.looked += len(cells)
            return cells[:0]
        self.looked += len(cells) * 100
        return cells

    monkeypatch.setattr(_Search, "_round", of)
    excesses: Any = [(SimpleNamespace(name=x, is_zero=x == "none"), f"beyond {x}") for x in ("first", "none", "second")]
    search = _Search(excesses, 0.0)
    search.go([1.0, 2.0, 4.0])
    assert {name for name, _ in rounds} == ({"first"} if stop == 0 else {"first", "second"})
    if stop != 0:
        assert search.broken == [(2.0, 4.0)]
        assert {*search.open} == {(1.0, 2.0)}
        assert [n for name, n in rounds if name == "second"][:2] == [32, 16][: stop or 2]
    else:
        assert {*search.open} == {(1.0, 2.0), (2.0, 4.0)}
    if stop is None:
        assert search.looked >= 30_000
        assert search.looked - 1600 < 30_000


def test_floats_tell_of_parts_and_regions_of_a_number_of_the_display_alone() -> None:
    scene = hs.load_scene("fu2019")
    own = noticed(scene.threshold)

    def excesses(path: str, criteria: Any) -> Any:
        return FloatCells(scene, scene.knobs[path], criteria, 1.0)._excesses

    assert len(excesses("omega_n", own)) == 2
    assert all(larger is not None for _, larger in excesses("omega_n", own))
    assert excesses("c", own) == ()
    assert excesses("omega_n", (*own, SimpleNamespace(part=None, region=None))) == ()
    port = hs.Scene(scene.environment, (*scene.effects, hs.effects.shunt(m="0.1 kg")), scene.band)
    beside = FloatCells(port, port.knobs["omega_n"], noticed(port.threshold), 1.0)._excesses
    assert [larger for _, larger in beside] == [None, None]
    nothing = FloatCells(scene, scene.knobs["c"], own, 1.0)
    assert nothing.told(1.0, 2.0) == [Told(1.0, 2.0, None)]


def test_a_larger_excess_is_of_one_part_with_a_limit_that_is_the_same_on_all_of_the_band() -> None:
    for jnd, told in (
        (0.1, [True, True]),
        ({"real": 0.1, "imag": "0.1 + omega/1000"}, [True, False]),
        ({"shape": "ellipse", "real": 0.1, "imag": 0.1}, [False]),
    ):
        scene = hs.Scene(hs.environments.kelvin_voigt(90, 3), (hs.effects.first_order_lag(40),), (0, 5), jnd)
        box = floatcells._OneFree(scene, "omega_c")
        assert [_larger(box, x) is not None for x in noticed(scene.threshold)] == told
        [side] = box.sides
        assert (side.name, side.low, side.high) == ("omega_c", 0, Rational(1))
