"""Windows, strips and bounds of a search over frequency and value: which are taken, and in which gaps others may lie."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.symbols import s
from haptisym.verbs.stability import search
from haptisym.verbs.stability.curves import Gap
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.pairs import Characteristic
from haptisym.verbs.stability.search import _Cells

q = Symbol("q", positive=True)


def loop_of(expression: Expr, low: Expr | None = Integer(0)) -> Loop:  # noqa: B008  exact and constant
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), q, low)


# Up to which frequency is searched


@pytest.mark.parametrize("known", [None, Rational(7, 3)])
@pytest.mark.parametrize("own", [None, 5.0])
@pytest.mark.parametrize("turns", [False, True])
def test_where_all_phases_together_give_no_bound_that_of_the_highest_power_is_taken_unless_delays_are_open(
    monkeypatch: pytest.MonkeyPatch, *, known: Rational | None, own: float | None, turns: bool
) -> None:
    asked: list[Any] = []

    def on_axis(ring: Any, polynomial: Any, ranges: Any) -> Any:
        asked.append((ring, polynomial, ranges))
        return SimpleNamespace(reach=own)

    def radius(value: Any, turning: int, *, inverse: bool) -> Rational | None:
        asked.append((value, turning, inverse))
        return known

    monkeypatch.setattr(search, "OnAxis", on_axis)
    monkeypatch.setattr(search, "reach_of_axis", lambda _: SimpleNamespace(radius=radius))
    loop = loop_of((s**2 + s * 3 + s * q * exp(-s / 2)) if not turns else s**3 + s * exp(-s * q))
    cells = _Cells(Characteristic(loop), Rational(-1, 3), Rational(2))
    ring, polynomial, ranges = asked[0]
    assert (ring, ranges) == (loop.ring, {q: (Rational(-1, 3), Rational(2))})
    whole = loop.ring.expression(loop.top)
    assert (loop.ring.expression(polynomial) * s - whole).expand() == 0  # without the power of s that all terms share
    if own is not None or turns:
        assert cells.axis.reach == own
        assert len(asked) == 1
        return
    value, turning, inverse = asked[1]
    assert (turning, inverse) == (search._MOST_TURNING, False)
    assert value.contains(-arb(1) / 3)
    assert value.contains(2)
    assert not value.contains(2.1)
    assert not value.contains(-0.4)
    if known is None:
        assert cells.axis.reach is None
    else:
        assert known < Rational(cells.axis.reach or 0) < known * (1 + Rational(1, 10**12))


@pytest.mark.parametrize("reach", [None, 3.0])
@pytest.mark.parametrize("start", [Integer(5), Integer(0)])
def test_a_search_begins_where_close_to_the_value_frequencies_have_a_bound(
    reach: float | None, start: Expr, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[tuple[Any, Any]] = []

    def cells(_: Any, low: Any, high: Any) -> Any:
        made.append((low, high))
        return SimpleNamespace(axis=SimpleNamespace(reach=reach))

    monkeypatch.setattr(search, "_Cells", cells)
    monkeypatch.setattr(search, "_in_strip", lambda *_: ([], []))
    loop = loop_of(s**2 + s + 9 + q * exp(-s / 2), None)
    found: Iterator[Any] = search.searched(loop, start, "the reason")
    if reach is None:
        with pytest.raises(UndecidedError, match="the reason"):
            next(found)
    else:
        assert len([*found]) == 8
    ends = [search._end(loop, Rational(start), side, 0) for side in (-1, 1)]
    assert made == [tuple(start + (x - start) / 64 for x in ends)]

    def needed(*_: Any) -> None:
        raise UndecidedError("no roots")

    monkeypatch.setattr(search, "need_roots", needed)
    with pytest.raises(UndecidedError, match="no roots"):
        next(search.searched(loop, start, "the reason"))


def test_windows_of_a_search_are_four_times_as_wide_each_or_come_four_times_as_near_to_what_is_allowed() -> None:
    """From a fourth of the value on both sides; of 0 from 1/1024; where a number may not go on, from a fourth of the way."""
    for start, side, j in product((Rational(3), Rational(-2, 7)), (-1, 1), range(6)):
        loop: Any = SimpleNamespace(low=None, high=None)
        assert search._end(loop, start, side, j) == start + side * abs(start) * Rational(4**j, 4)
        assert search._end(loop, Rational(0), side, j) == side * Rational(64**j, 1024)
        last = start + side * 5
        loop = SimpleNamespace(low=last, high=last)
        left = abs(search._end(loop, start, side, j) - last)
        assert left == 5 * Rational(3, 4) / 4**j
    assert search._end(loop, start, side, 6) == last


@pytest.mark.parametrize("reach", [True, False])
def test_where_no_bound_is_known_a_strip_is_cut_into_parts_of_a_sixty_fourth_and_these_are_gaps(
    monkeypatch: pytest.MonkeyPatch, *, reach: bool
) -> None:
    """From -3 on, of values near and far from 0; two parts that touch are one gap."""
    made: list[tuple[Any, Any]] = []

    class Cells:
        def __init__(self, _: Any, a: Any, b: Any) -> None:
            made.append((a, b))
            known = reach and not a <= Rational(5, 3) <= b
            self.axis, self.found, self.settle = SimpleNamespace(reach=1.0 if known else None), [(a, b)], list[Gap]

    monkeypatch.setattr(search, "_Cells", Cells)
    for low, high in ((-3, 5), (1, 3), (-1, 1)):
        made.clear()
        found, gaps = search._in_strip(SimpleNamespace(), Rational(low), Rational(high))  # type: ignore[arg-type]
        ends = [search._ends(x) for x in gaps]
        assert all(x.reason == search._FAR for x in gaps)
        if not reach:
            assert (found, ends) == ([], [(low, high)])
            assert min(b - a for a, b in made) == Rational(high - low, 64)
            continue
        spans: Any = found
        assert sum(b - a for a, b in [*spans, *ends]) == high - low
        assert ends == [] if high < 2 else [b - a for a, b in ends] == [Rational(high - low, 64)]
