"""Cells of values: of conditions with known ends what each leaf says, and a cell by the places of its conditions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from plainshapes import exact, function_of, q, rational
from sympy import Expr, Integer

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.symbols import omega as w
from haptisym.verbs.require import cells
from haptisym.verbs.require.cells import ValueSearch
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.floatcells import Told
from haptisym.verbs.require.places import CellVerdict, CriticalPlace

REAL, IMAG = noticed(hs.Threshold())
BAND = Integer(1), Integer(5)
KEPT, BROKEN, OPEN = CellVerdict.KEPT, CellVerdict.BROKEN, CellVerdict.OPEN


@dataclass
class Line:
    """Conditions a (q - v) - c (w - m)^2 on 1 to 5 rad/s, each kept on one side of a value where it binds."""

    pick: Random
    ends: list[tuple[Fraction, bool, Any, Kind, Fraction]] = field(default_factory=list)
    formulas: list[Expr] = field(default_factory=list)

    def add(self, criterion: Any, v: Fraction, *, kept_below: bool) -> None:
        c, m = Fraction(self.pick.randint(1, 6), 4), Fraction(self.pick.choice([-1, 0, 2, 3, 4, 7, 9]))
        a = self.pick.choice([1, 2]) * (1 if kept_below else -1)
        at = min(max(m, Fraction(1)), Fraction(5))
        offset = c * (at - m) ** 2 / a
        self.formulas.append(a * (q - rational(v - offset)) - rational(c) * (w - rational(m)) ** 2)
        kind = Kind.START if at == 1 else Kind.EDGE if at == 5 else Kind.TOUCH
        self.ends.append((v, kept_below, criterion, kind, at))

    def holds(self, t: Fraction) -> bool:
        return all(t < v if below else t > v for v, below, *_ in self.ends)

    def told(self, low: float, high: float) -> Sequence[Told]:
        """In pieces, of which some are told right."""
        marks = sorted({low, high, *(x for x in (-40.3, -3.51, 0.0, 0.26, 6.03, 90.3) if low < x < high)})
        found = []
        for a, b in pairwise(marks):
            clear = not any(Fraction(a) <= v <= Fraction(b) for v, *_ in self.ends) and self.pick.random() < 0.4
            found.append(Told(a, b, self.holds((Fraction(a) + Fraction(b)) / 2) if clear else None))
        return found


def _agrees(leaf: Any, line: Line) -> None:
    low = min(leaf.high - 1000, 2 * leaf.high) if leaf.low is None else leaf.low
    high = max(low + 1000, 2 * low) if leaf.high is None else leaf.high
    inside = [v for v, *_ in line.ends if low < v < high]
    if leaf.above is None:
        assert leaf.value is None
        assert leaf.verdict in (KEPT, BROKEN)
        for n in (1, 50, 99):
            t = low + (high - low) * n / 100
            assert line.holds(t) is (leaf.verdict is KEPT)
        assert line.holds(low + (high - low) / 10**6) is (leaf.verdict is KEPT)
        return
    [(v, below, criterion, kind, at)] = [x for x in line.ends if x[0] in inside]
    assert (leaf.verdict, leaf.above) == ((KEPT, BROKEN) if below else (BROKEN, KEPT))
    assert leaf.value is not None
    assert leaf.value.ball(100).contains(exact(v))
    assert leaf.binding is not None
    assert leaf.binding.omega is not None
    assert (leaf.binding.criterion, leaf.binding.kind) == (criterion, kind)
    assert leaf.binding.omega.ball(100).overlaps(exact(at))


@pytest.mark.parametrize("seed", range(7))
def test_leaves_lie_side_by_side_and_each_says_what_holds_for_its_values(seed: int) -> None:
    """Kept between two values, or beyond one; asked about from anywhere to anywhere, through 0, from 0 on, without bound."""
    pick = Random(seed)
    ranges = [
        (None, None),
        (0, None),
        (None, 0),
        (-8, 60),
        (0, 9),
        (-70, 0),
        (5, None),
        (None, -5),
        (2, 7),
        (9000, None),
        (None, -9000),
    ]
    for low, high in pick.sample(ranges, 4):
        line = Line(pick)
        a, b = sorted(pick.sample([Fraction(n, 8) for n in range(-99, 99) if n], 2))
        which = pick.choice(["both", "low", "high"])
        if which != "low":
            line.add(REAL, b, kept_below=True)
        if which != "high":
            line.add(IMAG, a, kept_below=False)
        own = {x[2]: function_of(f) for x, f in zip(line.ends, line.formulas, strict=True)}
        quick = {"quick": line.told} if pick.random() < 0.5 else {}
        search = ValueSearch(own, q, BAND, Fraction(pick.choice([1, 4]), pick.choice([1, 8])), **quick)
        start, end = (None if x is None else Fraction(x) for x in (low, high))
        leaves: list[Any] = search.leaves(start, end)
        assert (leaves[0].low, leaves[-1].high) == (start, end)
        assert all(x.high == y.low is not None for x, y in pairwise(leaves))
        assert all(x.low is None or x.high is None or x.low < x.high for x in leaves)
        for leaf in leaves:
            _agrees(leaf, line)
        known = [v for v, *_ in line.ends if (start is None or start < v) and (end is None or v < end)]
        assert len([x for x in leaves if x.above is not None]) == len(known)


def test_a_corner_of_two_functions_is_an_end_with_its_frequency() -> None:
    """The least of w - 3 and q - w is positive somewhere for q > 3."""
    pair = Lattice(((function_of(w - 3), function_of(q - w)),))
    leaves = ValueSearch({REAL: pair}, q, BAND, Fraction(1)).leaves(Fraction(1533, 512), Fraction(1538, 512))
    [end] = [x for x in leaves if x.above is not None]
    assert (end.verdict, end.above) == (KEPT, BROKEN)
    assert end.binding is not None
    assert end.binding.omega is not None
    assert end.binding.kind is Kind.TOUCH
    assert end.binding.omega.ball(100).contains(3)
    assert end.value is not None
    assert end.value.ball(100).contains(3)


# What is known of a cell by the places of each condition


@dataclass(frozen=True)
class Placed:
    """A condition of which it is given what its places are, and the signs at each."""

    found: Any
    at: tuple[tuple[int, int] | None, ...] = ()

    def signs(self, place: CriticalPlace) -> tuple[int, int] | None:
        return self.at[place.piece]

    def crossing(self, place: CriticalPlace) -> str:
        return f"value {place.piece}"


@pytest.mark.parametrize("seed", range(4))
def test_a_cell_is_broken_by_any_place_kept_by_all_and_has_an_end_where_one_alone_changes(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pick = Random(seed)
    monkeypatch.setattr(cells, "places", lambda strip, band: strip.found)
    monkeypatch.setattr(cells, "_binding", lambda *given: given)
    search = ValueSearch({}, q, BAND, Fraction(1))
    for _ in range(150):
        strips = dict[Any, Any]()
        for criterion in (REAL, IMAG):
            kind = pick.choice([BROKEN, OPEN, KEPT, "places", "places", "places", "places"])
            rows = tuple(
                pick.choice([(-1, -1), (-1, -1), (1, 1), None, (-1, 1), (1, -1)]) for _ in range(pick.randint(0, 2))
            )
            places = [CriticalPlace(Kind.TOUCH, exact(1), exact(2), piece=i) for i in range(len(rows))]
            strips[criterion] = Placed(places, rows) if kind == "places" else Placed(kind)
        leaf: Any = search._leaf(Fraction(3), Fraction(4), strips)
        signs = [(c, i, x) for c, own in strips.items() for i, x in enumerate(own.at)]
        told = [own.found for own in strips.values()]
        changing = [(c, i, x) for c, i, x in signs if x in ((-1, 1), (1, -1))]
        wanted: list[Any] = [OPEN, None, None]
        if BROKEN in told or (1, 1) in [x for *_, x in signs]:
            wanted = [BROKEN, None, None]
        elif {OPEN, KEPT} & {x for x in told if isinstance(x, CellVerdict)} or None in [x for *_, x in signs]:
            pass  # of a condition that is known without places nothing more is asked
        elif not changing:
            wanted = [KEPT, None, None]
        elif len(changing) == 1:
            [(criterion, i, x)] = changing
            wanted = [*((KEPT, BROKEN) if x == (-1, 1) else (BROKEN, KEPT)), f"value {i}"]
            assert leaf.binding == (criterion, strips[criterion].found[i], f"value {i}")
        assert [leaf.verdict, leaf.above, leaf.value] == wanted
        assert (leaf.low, leaf.high) == (3, 4)
