"""How cells of one number make the set that every passive hand may hold, and what tells a cell: on lines that are known."""

from __future__ import annotations

from itertools import pairwise
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Integer, Rational, Symbol

from haptisym.judge.criteria import PASSIVE
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.model.parameters import Rule
from haptisym.verbs.require import passivecells
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.passivecells import _Cell, solve_by_cells

Q = Symbol("q", real=True)


class Line:
    """In place of a search: cells from start to end, with what each says; beside them what begins active, and single values."""

    def __init__(self, pick: Random, start: Rational, end: Rational) -> None:
        inner = sorted(pick.sample(range(1, 40), 6))
        edges = [start, *(start + (end - start) * Rational(x, 40) for x in inner), end]
        self.gone: list[Any] = []
        self.marks: dict[Rational, Kind] = {}
        self.told, self.row, self.inside = pick.random() < 0.9, list[_Cell](), list[Rational]()
        self.active_from = edges[pick.choice([1, 5])] if pick.random() < 0.5 else None
        openings: list[Any] = [ExactNumber(self.active_from)] if self.active_from is not None else []
        for low, high in pairwise(edges):
            verdict: bool | None = pick.choice([True, True, False, None])
            turn: Any = None
            if verdict is None and pick.random() < 0.4:
                middle = (low + high) / 2
                is_root = low > 0 and pick.random() < 0.5
                turn = SquareRoot(ExactNumber(middle**2)) if is_root else ExactNumber(middle)
                openings.append(turn)
                self.inside.append(middle)
            alone = tuple(x for x in (low, high) if pick.random() < 0.2) if verdict is False else ()
            self.row.append(_Cell(low, high, verdict, turn, alone))
            self.marks[low] = pick.choice([Kind.FAR, Kind.START])
        self.openings = tuple(openings)
        self.single = {x: pick.choice([True, False, None]) for x in [*edges, *self.inside]}
        self.further = {side: pick.choice([self.here(side), None]) for side in (-1, 1)}
        if self.active_from is not None:
            self.further[1] = False
        self.asked: list[tuple[Any, Any, Any]] = []

    def is_told(self, value: Any) -> bool:
        self.asked.append(value)
        return self.told and len(self.asked) > 2

    def cells(self, start: Any, end: Any) -> Any:
        assert (start, end) == (self.row[0].low, self.row[-1].high)
        return iter(self.row)

    def is_active(self, value: Any) -> bool:
        """Beyond one value, and on the lower half of a cell that turns."""
        beyond = self.active_from is not None and bool(value > self.active_from)
        return beyond or any(x.turn is not None and x.low <= value < (x.low + x.high) / 2 for x in self.row)

    def holds_at(self, value: Any) -> bool | None:
        return self.single[value]

    def here(self, side: int) -> bool | None:
        """Whether values next to an end will do, as its cell says."""
        cell = self.row[0] if side < 0 else self.row[-1]
        return not self.is_active(cell.low if side < 0 else cell.high) if cell.turn else cell.verdict

    def beyond(self, end: Any, side: int, *, here: bool | None) -> bool | None:
        assert end == (self.row[0].low if side < 0 else self.row[-1].high)
        assert here == self.here(side)
        return self.further[side]

    def verdict(self, x: Rational, start: Rational, end: Rational) -> bool | None:
        """What is to come out for one value."""
        turning = {y.turn.value for y in self.row if isinstance(y.turn, ExactNumber)}
        asked = {y for cell in self.row for y in cell.alone}
        asked |= {y.value for y in self.openings if isinstance(y, ExactNumber) and y.value not in turning}
        if x in asked:
            return self.single[x]
        if self.is_active(x):
            return False
        if x < start or x > end:
            return self.further[-1 if x < start else 1]
        own = [cell for cell in self.row if cell.low <= x <= cell.high]
        if any(cell.turn for cell in own):
            return True
        told = [cell.verdict for cell in own]
        return True if True in told else False if False in told else None


@pytest.mark.parametrize("seed", range(24))
def test_a_set_is_made_of_what_cells_and_single_values_say(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    pick = Random(seed)
    low, high = pick.choice([(None, None), (Integer(1), None), (None, Integer(9)), (Integer(1), Integer(9))])
    free: Any = SimpleNamespace(value=Rational(1, 2), rule=Rule.ANY, path="q", symbol=Q)
    start, end = (-500 if low is None else low), (500 if high is None else high)
    line = Line(pick, Rational(start), Rational(end))
    monkeypatch.setattr(passivecells, "_Search", lambda *_: line)
    monkeypatch.setattr(passivecells, "_window", lambda *_: (Rational(start), Rational(end)))
    monkeypatch.setattr(passivecells, "allowed", lambda *_: True)
    scene: Any = None
    if not line.told:
        with pytest.raises(UndecidedError, match="too near"):
            solve_by_cells(scene, free, Domain(low, high))
        assert line.asked == [Rational(1, 2), start + Rational(end - start) / 3, end]
        return
    found = solve_by_cells(scene, free, Domain(low, high))
    places = sorted({x for cell in line.row for x in (cell.low, cell.high, (cell.low + cell.high) / 2)})
    places += [(3 * a + b) / 4 for a, b in pairwise(places)]
    places += [start - 10] * (low is None) + [end + 10] * (high is None)
    for x in places:
        expected = line.verdict(x, Rational(start), Rational(end))
        inside = any(_holds(span, x, line.inside) for span in found.feasible)
        pairs = [tuple(exact(y, line.inside) for y in pair) for pair in found.undecided]
        opened = any((a is None or a <= x) and (b is None or x <= b) for a, b in pairs)
        assert inside is (expected is True)
        assert opened is (expected is None) or any(x in pair for pair in pairs)
        assert opened or expected is not None
    unseen = any(x is None and y is None for x, y in ((low, line.further[-1]), (high, line.further[1])))
    assert found.reason == (
        "further out was not looked at" if unseen else passivecells._LEFT if found.undecided else ""
    )
    for span in found.feasible:
        for side in (span.low, span.high):
            for binding in side.bindings:
                assert binding.criterion is PASSIVE
                assert (binding.omega is None) is (binding.kind is Kind.FAR)
                assert binding.omega is None or float(binding.omega) == 0


def exact(x: Any, middles: list[Rational]) -> Any:
    """A number as a fraction: the middle of a cell where it is a root."""
    if x is None or isinstance(x, ExactNumber):
        return x and x.value
    return next(y for y in middles if abs(float(x) - float(y)) < 1e-9)


def _holds(span: Any, x: Any, middles: list[Rational]) -> bool:
    low, high = (exact(y.value, middles) for y in (span.low, span.high))
    above = low is None or low < x or (low == x and span.low.closed)
    return above and (high is None or x < high or (high == x and span.high.closed))
