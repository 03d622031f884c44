"""Walks along a number until roots reach the unit circle, cells of values, windows and pixels: against zeros that were put there."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import prod
from types import SimpleNamespace
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import acb, arb
from scipy import ndimage
from sympy import Expr, Integer, Rational, Symbol, pi

from haptisym.kernel.budget import limited
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.pulse import Plant, SampledLoop
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import clockrange, neutral, plane, search
from haptisym.verbs.stability.clockcritical import Opened, Walk
from haptisym.verbs.stability.clockvalues import CriticalValue, Swing
from haptisym.verbs.stability.curves import Gap
from haptisym.verbs.stability.oncircle import _is_hurwitz, halves
from haptisym.verbs.stability.rightroot import RightRoots, _Values

SEEDS = range(20)
k = Symbol("k", positive=True)


class Placed:
    """A loop of which three tests vanish at given values, and whose count changes there: by 1, 1 and 2."""

    symbol, always = k, 0

    def __init__(self, draw: random.Random, *, twins: bool = True) -> None:
        values = [*draw.sample([Fraction(n, 7) for n in range(-30, 60) if n], 5), Fraction(4000), Fraction(1, 3000)]
        self.zeros: list[list[Fraction]] = [[], [], []]
        for x in values:
            self.zeros[draw.randrange(3)].append(x)
        self.signs = {x: draw.choice([-1, 1]) for x in values}
        self.twin: Fraction | None = None
        if (
            twins and draw.random() < 0.3 and self.zeros[0]
        ):  # a root that leaves at 1, and another one that comes back at -1 at once
            twin = self.zeros[0][0]
            self.twin = min(twin, twin * (1 + Fraction(1, 10**10)))
            self.zeros[1].append(twin * (1 + Fraction(1, 10**10)))
            self.signs[self.zeros[1][-1]] = -self.signs[twin]
        self.at_0 = draw.random() < 0.5
        factors = [k - Rational(x.numerator, x.denominator) for x in self.zeros[0]]
        self.at_one: Expr = prod(factors, start=Integer(1)) * (k if self.at_0 else 1)

    def tests(self, q: Any) -> tuple[Any, ...]:
        found = [arb(1), arb(1), arb(1)]
        for i, own in enumerate(self.zeros):
            for x in own:
                found[i] *= q - arb(x.numerator) / x.denominator
        return (found[0] * q if self.at_0 else found[0], *found[1:])

    def count(self, value: Any) -> tuple[int, int]:
        here = Fraction(int(value.p), int(value.q))
        number = 40 + sum((1 + (i == 2)) * self.signs[x] for i, own in enumerate(self.zeros) for x in own if x < here)
        at_0 = int(self.at_0 and here == 0)
        return number + at_0, at_0 + any(here in own for own in self.zeros)

    def is_clear(self, q: Any) -> bool:
        return not any(x.contains(0) for x in self.tests(q))

    def angle(self, q: Any, bits: int) -> Any:
        return q.atan()

    def period(self, q: Any) -> Any:
        return 1 / (1 + q**2)


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("rule", [Rule.ANY, Rule.NONNEGATIVE, Rule.POSITIVE])
def test_a_walk_finds_the_nearest_change_and_says_as_far_as_it_went(rule: Rule, seed: int) -> None:
    draw = random.Random(f"{rule} {seed}")
    loop: Any = Placed(draw)
    start = Fraction(draw.randint(1, 40), 5)
    if rule is Rule.ANY:
        start *= draw.choice([-1, 1]) if loop.at_0 else draw.choice([-1, 0, 1])
    start += Fraction(1, 1000) if any(start in own for own in loop.zeros) else 0
    walk = Walk(loop, start, loop.count(Rational(start.numerator, start.denominator))[0], rule)
    far = (abs(start) or Fraction(1)) * 1024
    for side in (-1, 1):
        end = start + side * far if rule is Rule.ANY or side > 0 else start / 1024
        ahead = [x for own in loop.zeros for x in own if (x - start) * side > 0 and (end - x) * side > 0]
        true = min(ahead, key=lambda x: abs(x - start), default=None)
        found, known = walk.towards(side)
        if true is not None and loop.twin is not None and abs(true - loop.twin) < abs(true) / 10**9:
            assert found is None
            assert 0 <= (true - known) * side <= abs(true) / 10**6
        elif true is not None:
            assert found is not None
            assert abs(known - true) < abs(true) * Fraction(1, 10**6)
            assert (known - true) * side >= 0
            assert abs(mpmath.mpf(found.value.digits(40)) - mpmath.mpf(true.numerator) / true.denominator) < 1e-15
            below, above = (
                loop.count(Rational(x.numerator, x.denominator))[0]
                for x in (true - Fraction(1, 10**5), true + Fraction(1, 10**5))
            )
            assert (found.below, found.above) == (below, above)
            i = next(i for i, own in enumerate(loop.zeros) if true in own)
            angle = (0.0, float(np.pi), float(np.arctan(float(true))))[i]
            assert float(found.omega) == pytest.approx(angle * (1 + float(true) ** 2))
        elif found is not None:  # a root that comes to 1 at 0 itself
            assert (rule, side, loop.at_0) == (Rule.NONNEGATIVE, -1, True)
            assert not any(0 <= x <= end for own in loop.zeros for x in own)
            assert (found.value, found.omega) == (ExactNumber(Integer(0)),) * 2
            assert (found.below, found.above, known) == (loop.count(Integer(0))[0], walk.home, 0)
        else:
            assert known == end
            others = [x for own in loop.zeros for x in own if 0 <= x <= end]
            assert not (rule is Rule.NONNEGATIVE and side < 0 and loop.at_0) or others


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", SEEDS)
def test_in_a_range_all_changes_are_found_in_order(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    draw = random.Random(seed)
    loop: Any = Placed(draw, twins=False)
    loop.is_fixed = False
    monkeypatch.setattr(clockrange, "opened", lambda *_: loop)
    for name in ("inverted", "is_held"):
        monkeypatch.setattr(clockrange, name, lambda *_: None)
    start = Fraction(draw.randint(1, 40), 5) + Fraction(1, 1000)
    free: Any = SimpleNamespace(value=Rational(start.numerator, start.denominator), rule=Rule.POSITIVE)
    low, high = start / draw.choice([2, 8, 900]), start * draw.choice([2, 8, 900])
    ends = Rational(low.numerator, low.denominator), Rational(high.numerator, high.denominator)
    _, told = clockrange.passages_in(Any, Any, free, ends)  # type: ignore[arg-type]
    found, first, last = told.found, told.low, told.high
    assert first is not None
    assert last is not None
    assert first <= low
    assert last >= high or last >= 1000 * start
    inside = sorted(x for own in loop.zeros for x in own if first <= x <= last)
    assert sorted(float(x.value) for x in found) == pytest.approx([float(x) for x in inside])
    for x in found:
        at = Rational(round(float(x.value) * 42000), 42000)
        near = [loop.count(at + sign * Rational(1, 10**7))[0] for sign in (-1, 1)]
        assert [x.below, x.above] == near
    loop.is_fixed = True
    assert clockrange.passages_in(Any, Any, free, (None, None))[1] == clockrange.Passages(())  # type: ignore[arg-type]
    loop.is_fixed = False
    there = loop.zeros[max(range(3), key=lambda i: len(loop.zeros[i]))][0]
    free.value = Rational(there.numerator, there.denominator)
    with pytest.raises(UndecidedError, match="how far a number may go"):
        clockrange.passages_in(Any, Any, free, (None, None))  # type: ignore[arg-type]
    free.value = pi + Rational(1, 1000)
    near = clockrange.passages_in(Any, Any, free, (Rational(3), Rational(4)))[1].found  # type: ignore[arg-type]
    assert all(
        any(abs(float(x.value) - float(y)) < 1e-9 for x in near) for own in loop.zeros for y in own if 3 <= y <= 4
    )


class Given:
    """A loop of which the tests are given; its period is a fourth of the number."""

    def __init__(self, tests: Callable[[Any], tuple[Any, ...]]) -> None:
        self.tests = tests

    def angle(self, q: Any, bits: int) -> Any:
        return q.atan()

    def period(self, q: Any) -> Any:
        return q / 4


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(8))
def test_a_value_between_two_others_is_closed_in_on_to_any_bits(seed: int) -> None:
    """The one zero of (x - a)^3 + c (x - a) near a that is a square root: against mpmath."""
    draw = random.Random(seed)
    square, slope = draw.randint(2, 90), draw.choice([0, 1, 100, -1]) * draw.choice([1, 1000])
    bend = slope or 1
    loop = Given(lambda q: (arb(1), arb(2), bend * (q - arb(square).sqrt()) + (q - arb(square).sqrt()) ** 3 * bend))
    low, high = Fraction(round(square**0.5 * 1000) - 3, 1000), Fraction(round(square**0.5 * 1000) + 2, 1000)
    value = CriticalValue(loop, 2, low, high)
    for bits in (30, 64, 400):
        ball = value.ball(bits)
        with flint.ctx.workprec(1000):
            true = arb(square).sqrt()
            assert ball.contains(true)
            assert ball.rad() <= true * arb(2) ** (3 - bits)
    assert value.digits(50) == mpmath.nstr(_root(square), 50, strip_zeros=False)
    for test, angle in ((0, 0), (1, np.pi)):
        pair = Swing(CriticalValue(Given(lambda q: (q - 2, q - 2, arb(1))), test, Fraction(1), Fraction(7, 2)))
        assert float(pair) == pytest.approx(angle * 2)


def _root(n: int) -> Any:
    with mpmath.workdps(70):
        return mpmath.sqrt(n)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(6))
def test_two_changes_that_are_close_to_each_other_are_never_passed_by(seed: int) -> None:
    """z = 1 - a(k), a = 2 + e - c (k - 1)^2: outside of the circle for |k - 1| < (e/c)^(1/2), however narrow that is."""
    draw = random.Random(seed)
    e, c = Rational(1, 10 ** draw.randint(2, 17)), Rational(draw.randint(1, 9), 9)
    plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))
    for sign in (1, -1):  # with -e it comes near to the circle, and no further
        a = 2 + sign * e - c * (k - 1) ** 2
        loop = Opened(SampledLoop(plant, Integer(1), (a.expand(),), (Integer(1),)), k)
        home = loop.count(Rational(1, 2))
        assert home == (0, 0)
        found, known = Walk(loop, Fraction(1, 2), 0, Rule.POSITIVE).towards(1)
        first = 1 - float(e / c) ** 0.5 if sign > 0 else 1 + float((2 - e) / c) ** 0.5
        assert float(known) <= first or (found is not None and float(found.value) == pytest.approx(first, abs=1e-12))
        for low, high in ((0.6, 0.61), (0.9999, 1.0001), (1.05, 1.06)):
            with flint.ctx.workprec(128):
                clear = loop.is_clear(arb(low).union(arb(high)))
            grid = np.linspace(low, high, 101)
            assert not clear or (abs(2 + float(sign * e) - float(c) * (grid - 1) ** 2 - 2) > 0).all()


def _at_its_delay(k: Symbol) -> Opened:
    """z = 1 - k."""
    plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))
    return Opened(SampledLoop(plant, Integer(1), (k,), (Integer(1),)), k)


def test_a_walk_whose_time_is_over_knows_of_no_value_but_its_first() -> None:
    with limited(1e-9) as budget:
        assert Walk(_at_its_delay(k), Fraction(1, 2), 0, Rule.POSITIVE).towards(1) == (None, Fraction(1, 2))
    assert budget.reached


def test_a_walk_that_gets_ahead_by_the_shortest_cells_alone_gives_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """It had taken minutes where roots stay beside the circle, without getting anywhere; what it passed is told."""
    walk, asked = Walk(_at_its_delay(k), Fraction(1, 2), 0, Rule.POSITIVE), []

    def over(_: Walk, at: Fraction, step: Fraction) -> tuple[None, Fraction]:
        asked.append(at)
        return None, at + step

    monkeypatch.setattr(Walk, "_is_clear", lambda *_: False)
    monkeypatch.setattr(Walk, "_over", over)
    found, known = walk.towards(1)
    assert found is None
    assert Fraction(1, 2) < known < Fraction(1, 2) + Fraction(1, 1000)
    assert 20 < len(asked) < 100


# Cells between values at which chains come to the axis


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(8))
def test_cells_are_cut_inside_and_pieces_are_the_whole(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        a, b = sorted(draw.sample(range(-20, 20), 2))
        low = None if draw.random() < 0.3 else ExactNumber(Rational(a, 3))
        high = None if draw.random() < 0.3 else ExactNumber(Rational(b, 3))
        cell = neutral._Cell(low, high)
        middle = cell.middle
        assert low is None or middle > low.value
        assert high is None or middle < high.value
        if low is not None and high is None:
            assert middle > 0
            assert middle >= 2 * low.value - 1
        if low is None and high is not None:
            assert middle < 0
            assert middle <= 2 * high.value + 1
        one, other = cell.halves
        assert (one.low, other.high, one.high, other.low) == (low, high, ExactNumber(middle), ExactNumber(middle))
    close = ExactNumber(Rational(1, 3)), ExactNumber(Rational(1, 3) + Rational(1, 10**40))
    assert close[0].value < neutral._Cell(*close).middle < close[1].value
    assert neutral._Cell(None, None).middle == 0


class Hidden:
    """A reach that knows nothing of balls that hold one of some values, nor of wide ones."""

    def __init__(self, values: list[Fraction]) -> None:
        self.values = values

    def radius(self, q: Any, turning: int, *, inverse: bool) -> Rational | None:
        if any(
            (q * x.numerator / x.denominator).contains(1) if inverse else q.contains(arb(x.numerator) / x.denominator)
            for x in self.values
        ):
            return None
        return Rational(7) if q.rad() < (1 if inverse else 3) else None


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(8))
def test_what_is_left_of_a_cell_is_about_the_values_that_hide(seed: int) -> None:
    draw = random.Random(seed)
    hidden = [Fraction(draw.randint(1, 300), 7) for _ in range(draw.randint(0, 3))]
    low, high = draw.choice(
        [(Integer(0), None), (Integer(0), Integer(50)), (None, None), (None, Integer(60)), (Integer(-5), Integer(44))]
    )
    cell = neutral._Cell(*(None if x is None else ExactNumber(x) for x in (low, high)))
    reach: Any = Hidden(hidden)
    pieces = [*neutral._pieces(cell, reach, 40, 24)]
    assert pieces[0][0].low is cell.low
    assert pieces[-1][0].high is cell.high
    assert all(x.high == y.low for (x, _), (y, _) in pairwise(pieces))
    width = 0.0
    for piece, radius in pieces:
        a = -np.inf if piece.low is None else float(piece.low)
        b = np.inf if piece.high is None else float(piece.high)
        holds = [x for x in hidden if a <= x <= b]
        if radius is not None:
            assert radius == 7
            assert not holds
        elif not holds:
            width += b - a if np.isfinite(b - a) else 0
    assert width < 1 or low is None
    gaps = [*neutral._joined([x for x, radius in pieces if radius is None])]
    ends = [(-np.inf if x.low is None else float(x.low), np.inf if x.high is None else float(x.high)) for x in gaps]
    assert all(a < b for a, b in ends)
    assert all(ends[i][1] < ends[i + 1][0] for i in range(len(ends) - 1))
    for piece, radius in pieces:
        inside = any(g.holds(piece.low, piece.high) for g in gaps)
        assert inside is (radius is None)


def test_without_an_end_all_inverses_down_to_0_are_asked_about() -> None:
    asked: list[tuple[Any, int, bool]] = []

    def radius(q: Any, turning: int, *, inverse: bool) -> Rational:
        asked.append((q, turning, inverse))
        return Rational(5)

    reach: Any = SimpleNamespace(radius=radius)
    ends = {n: ExactNumber(Integer(n)) for n in (-8, -4, 0, 4, 8)}
    for low, high, holds, avoids, inverse in (
        (4, None, (0, 0.125, 0.25), (-0.01, 0.26), True), (None, -4, (0, -0.125, -0.25), (0.01, -0.26), True), (4, 8, (4, 6, 8), (3.9, 8.1), False), (-8, 4, (-8, 0, 4), (-8.1, 4.1), False),
    ):  # fmt: skip
        cell = neutral._Cell(*(None if x is None else ends[x] for x in (low, high)))
        asked.clear()
        assert cell.radius(reach, 33) == 5
        [(q, turning, was_inverse)] = asked
        assert (turning, was_inverse) == (33, inverse)
        assert all(q.contains(x) for x in holds)
        assert not any(q.contains(x) for x in avoids)
    for low, high in ((0, None), (-4, None), (None, 0), (None, 4), (None, None)):
        assert neutral._Cell(*(None if x is None else ends[x] for x in (low, high))).radius(reach, 33) is None


def test_cells_lie_between_what_comes_from_infinity_as_far_as_a_number_may_go() -> None:
    none: Any = SimpleNamespace(chain=None)
    loop: Any = SimpleNamespace(low=Integer(0), high=None, at=lambda _: none)
    met = [SimpleNamespace(value=ExactNumber(Integer(x)), omega=None) for x in (5, -1, 2, 0, 5)]
    ends = [(x.low and float(x.low), x.high and float(x.high)) for x in neutral.cells(loop, met)]  # type: ignore[arg-type]
    assert ends == [(0, 2), (2, 5), (5, None)]
    loop = SimpleNamespace(low=None, high=Integer(4), at=lambda _: none)
    ends = [(x.low and float(x.low), x.high and float(x.high)) for x in neutral.cells(loop, met)]  # type: ignore[arg-type]
    assert ends == [(None, -1), (-1, 0), (0, 2), (2, 4)]
    loop = SimpleNamespace(low=Integer(0), high=Integer(5), at=lambda _: none)  # what comes at an end parts nothing
    ends = [(x.low and float(x.low), x.high and float(x.high)) for x in neutral.cells(loop, met)]  # type: ignore[arg-type]
    assert ends == [(0, 2), (2, 5)]
    loop = SimpleNamespace(
        low=None, high=Integer(4), at=lambda x: SimpleNamespace(chain=RootChain.RIGHT if x > 0 else None)
    )
    assert [float(x.high or 9) for x in neutral.cells(loop, met)] == [-1, 0]  # type: ignore[arg-type]


# Windows of a search


@pytest.mark.parametrize(
    ("low", "high"), [(Integer(0), None), (None, None), (Integer(0), Integer(1)), (Integer(-2), Integer(9))]
)
@pytest.mark.parametrize("start", [Rational(1, 3), Rational(0), Rational(7, 8)])
def test_windows_of_a_search_grow_about_the_value_up_to_what_is_allowed(low: Expr, high: Expr, start: Rational) -> None:
    loop: Any = SimpleNamespace(low=low, high=high)
    for side, last in ((-1, low), (1, high)):
        ends = [search._end(loop, start, side, j) for j in range(search._WINDOWS)]
        assert all((b - a) * side >= 0 for a, b in pairwise(ends))
        assert all((x - start) * side > 0 or x == start == last for x in ends)
        if last is None:
            assert all((b - start) == (a - start) * (4 if start else 64) for a, b in pairwise(ends))
        else:
            assert ends[-1] == last
            assert all((last - x) * 4 == (last - before) for before, x in pairwise(ends[:-1]))
            assert all((last - x) * side > 0 or start == last for x in ends[:-1])


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(10))
def test_gaps_that_touch_are_one_and_the_whole_stays_what_it_was(seed: int) -> None:
    draw = random.Random(seed)
    given = [
        search._gap(Integer(a), Integer(a + draw.randint(1, 4)), str(a))
        for a in draw.sample(range(30), draw.randint(0, 8))
    ]
    joined = search._joined(given)
    ends = [search._ends(x) for x in joined]
    assert all(a[1] < b[0] for a, b in pairwise(ends))
    for n in range(36):
        at = Rational(2 * n + 1, 2)
        assert any(a < at < b for a, b in ends) == any(x.low.value < at < x.high.value for x in given)  # type: ignore[union-attr]
    assert all(x.reason == min((y for y in given if y.low == x.low), key=lambda y: y.reason).reason for x in joined)


@pytest.mark.few(9)
@pytest.mark.parametrize("seed", range(10))
def test_a_strip_is_cut_until_frequencies_have_a_bound_and_nothing_is_lost(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bounds are known of values that keep away from one of them."""
    draw = random.Random(seed)
    hard = Rational(draw.randint(-2, 100), 64)
    looked: list[tuple[Any, Any]] = []

    class Cells:
        def __init__(self, _: object, low: Rational, high: Rational) -> None:
            self.low, self.high = low, high
            self.axis = SimpleNamespace(reach=None if low <= hard <= high else 3.0)
            self.found = [low]

        def settle(self) -> list[Gap]:
            looked.append((self.low, self.high))
            return [search._gap(self.low, self.low + (self.high - self.low) / 4, "left")] if draw.random() < 0.3 else []

    monkeypatch.setattr(search, "_Cells", Cells)
    found, gaps = search._in_strip(SimpleNamespace(), Rational(0), Rational(1))  # type: ignore[arg-type]
    assert found == [low for low, _ in looked]
    for n in range(257):
        at = Rational(n, 256) + Rational(1, 1000)
        if at < 1:
            assert any(a <= at <= b for a, b in [*looked, *map(search._ends, gaps)])
    if 0 <= hard <= 1:
        assert any(a <= hard <= b for a, b in map(search._ends, gaps))
        assert sum(b - a for a, b in looked) >= 1 - Rational(2, search._THINNEST)
    else:
        assert looked == [(0, 1)]


# A clock's box, Hurwitz and roots on the right


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(10))
def test_a_polynomial_is_called_hurwitz_where_its_roots_are_on_the_left_or_one_at_0(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        roots: list[complex] = []
        for _ in range(draw.randint(1, 3)):
            x, y = draw.choice([-3, -2, -1, -1, -0.5, 0, 0.5]), draw.choice([0, 1, 2])
            roots += [complex(x, y), complex(x, -y)] if y else [complex(x)]
        row = np.real(np.poly(roots))[::-1] * draw.choice([1, 2])
        at_0 = sum(x == 0 for x in roots)
        left = all(x.real < 0 for x in roots if x != 0) and at_0 <= 1
        with flint.ctx.workprec(96):
            balls = [arb(x) for x in row]
            if balls[0] >= 0:
                assert _is_hurwitz(balls) is left
                assert left or not _is_hurwitz([balls[0], *(x + arb(0, 0.01) for x in balls[1:])])


def test_cells_are_halved_across_their_widest_side_that_is_asked_about() -> None:
    cell = ((Fraction(0), Fraction(1)), (Fraction(0), Fraction(1, 2)), (Fraction(1, 4), Fraction(1)))
    assert halves(cell, (1, 2)) == [
        (*cell[:2], (Fraction(1, 4), Fraction(5, 8))),
        (*cell[:2], (Fraction(5, 8), Fraction(1))),
    ]
    assert [x[0] for x in halves(cell, range(3))] == [(0, Fraction(1, 2)), (Fraction(1, 2), 1)]


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_value_and_slope_along_s_are_those_of_mpmath(seed: int) -> None:
    draw = random.Random(seed)
    rows = {
        (p, n): [draw.randint(-9, 9) for _ in range(draw.randint(1, 3))]
        for p in (0, Fraction(1, 2), 1, 2)
        for n in (0, 1, 3)
    }
    table: dict[Any, dict[tuple[int], list[Expr]]] = {}
    for (p, n), row in rows.items():
        table.setdefault(Rational(p), {})[n,] = [Integer(c) for c in row]
    loop: Any = SimpleNamespace(table=table, ring=SimpleNamespace(lags=(Rational(1, 5),)), turns=False)
    at, q = complex(draw.uniform(0.1, 3), draw.uniform(0.1, 9)), draw.uniform(0.1, 2)

    def f(z: Any) -> Any:
        return sum(
            sum(c * q**i for i, c in enumerate(row)) * z ** mpmath.mpf(float(p)) * mpmath.exp(-z * n / 5)
            for (p, n), row in rows.items()
        )

    endless = seed % 2  # then all is over the highest power of q
    share = q ** (1 - max(map(len, rows.values()))) if endless else 1
    low, high = (ExactNumber(Rational(x)) for x in (q - 0.02, q + 0.02))
    known = _Values.of(low, None if endless else high)
    assert known is not None
    values = replace(known, ball=arb(1 / q if endless else q))
    with flint.ctx.workprec(128):
        value, slope = RightRoots(loop)._value(acb(at.real, at.imag), values)
    assert complex(value) == pytest.approx(complex(f(mpmath.mpc(at)) * share), rel=1e-9, abs=1e-9)
    assert complex(slope) == pytest.approx(complex(mpmath.diff(f, mpmath.mpc(at)) * share), rel=1e-7, abs=1e-7)
    for s in RightRoots(loop)._guesses(values):
        assert s.real > 0
        assert abs(f(mpmath.mpc(s))) < 1e-6 * (1 + abs(mpmath.diff(f, mpmath.mpc(s))))


# Pixels of a hand's plane


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(5))
def test_parts_of_the_plane_are_those_of_scipy_and_their_deepest_pixel_lies_inside(seed: int) -> None:
    rng = np.random.default_rng(seed)
    smooth = ndimage.gaussian_filter(rng.normal(size=(plane._PIXELS,) * 2), 9)
    open_ones = abs(smooth) > 0.004
    own, (theirs, count) = plane._filled(open_ones), ndimage.label(open_ones)
    assert own.max() == count
    assert ((own == 0) == (theirs == 0)).all()
    assert len({*zip(own.ravel(), theirs.ravel(), strict=True)}) == count + (own == 0).any()
    sizes = np.bincount(own.ravel())
    for number in np.argsort(-sizes[1:])[:3] + 1:
        part = own == number
        i, j = plane._deepest(part)
        depth = ndimage.distance_transform_cdt(np.pad(part, 1), "taxicab")[1:-1, 1:-1]
        assert part[i, j]
        assert depth[i, j] == depth.max()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_the_boundary_of_the_plane_parts_pixels_on_both_of_its_sides(seed: int) -> None:
    """A line k = a + c b, and a stiffness with a root at 0."""
    draw = random.Random(seed)
    low, high, least, most = window = (draw.uniform(-5, 0), draw.uniform(5, 9), draw.uniform(-3, 0), draw.uniform(2, 4))
    slope, at_0 = draw.uniform(-0.4, 0.4), draw.uniform(3.9, 4.5)
    b = np.linspace(least - 5, most + 5, 700)
    labels = plane._labels(1 + slope * b, b, at_0, window)
    assert labels.max() == 3
    size = plane._PIXELS
    for _ in range(300):
        i, j = draw.randrange(size), draw.randrange(size)
        x, y = low + (i + 0.5) * (high - low) / size, least + (j + 0.5) * (most - least) / size
        gap, pixel = x - 1 - slope * y, (high - low) / size + abs(slope) * (most - least) / size
        if abs(gap) > 2 * pixel and abs(x - at_0) > 2 * pixel:
            side = (
                labels[1, size // 2],
                labels[int((2.5 - low) / (high - low) * size), size // 2],
                labels[-2, size // 2],
            )
            assert labels[i, j] == side[0 if gap < 0 else 1 if x < at_0 else 2]
    assert (
        plane._labels(1 + slope * b, b, None, window).max(),
        plane._labels(99 + 0 * b, b, high + 1, window).max(),
    ) == (2, 1)


@pytest.mark.parametrize("ends", [((-1, 3), (11, 6)), ((11, 3), (-1, 6)), ((3, 11), (6, -1)), ((6, -1), (3, 11))])
def test_one_straight_piece_of_the_boundary_has_no_hole_whichever_way_it_goes(
    ends: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plane, "_PIXELS", 60)
    (a, b), (c, d) = ((x - 5, y + 20) for x, y in ends)
    window = (-5.0, 5.0, 20.0, 30.0)
    labels = plane._labels(np.array([a, c], float), np.array([b, d], float), None, window)
    assert labels.max() == 2
    on = np.argwhere(labels == 0) / plane._PIXELS * 10 + 5 / plane._PIXELS + (-5, 20)
    off = ((on[:, 0] - a) * (d - b) - (on[:, 1] - b) * (c - a)) / np.hypot(c - a, d - b)
    assert abs(off).max() < 2 * 10 / plane._PIXELS
    still = plane._labels(np.array([a, c], float) + 20, np.array([b, d], float), None, window)
    assert (still == 1).all()
    aside = plane._labels(np.array([a, c], float), np.array([b, d], float) - 20, None, window)
    assert (aside == 1).all()


def test_the_largest_parts_of_the_plane_are_counted_at_the_middle_of_a_pixel_inside(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of thirty squares the twelve largest, if they have sixty pixels at least; the hand is that of the deepest pixel."""
    asked: list[tuple[float, float]] = []
    hand = SimpleNamespace()
    found = [Roots(n % 3, n % 3) if n % 4 else None for n in range(30)]
    monkeypatch.setattr(plane, "_roots", lambda _, own, k, b: (asked.append((k, b)), found[len(asked) - 1])[1])
    window, size = (-2.0, 6.0, 1.0, 5.0), plane._PIXELS
    for widths, count in ((range(3, 33), 12), ([7, 8, 9, 3], 2), ([7], 0)):
        labels, asked[:] = np.zeros((size, size), int), []
        for n, width in enumerate(widths):
            i, j = 33 * (n % 6), 33 * (n // 6)
            labels[i : i + width, j : j + width] = n + 1
        cells = list(plane._cells(Any, hand, labels, window))  # type: ignore[arg-type]
        assert [x.pixels.sum() for x in cells] == sorted((w**2 for w in widths), reverse=True)[:count]
        for cell, at, roots in zip(cells, asked, found, strict=False):
            assert (cell.k, cell.b, cell.roots) == (*at, roots)
            assert cell.is_stable == (roots is not None and roots.number == 0)
            i, j = (cell.k + 2) / 8 * size, (cell.b - 1) / 4 * size
            assert (i % 1, j % 1) == pytest.approx((0.5, 0.5), abs=1e-6)
            assert cell.pixels[int(i) - 2 : int(i) + 3, int(j) - 2 : int(j) + 3].all()
            rows, columns = np.nonzero(cell.pixels)
            width = rows.max() - rows.min() + 1
            if width % 2:  # one pixel alone is the deepest
                assert (int(i), int(j)) == (rows.min() + width // 2, columns.min() + width // 2)


def curve(end: float) -> Iterator[Any]:
    yield lambda w: (w, 0 * w + 1), end
    yield lambda w: (0 * w + 1, w), end
    yield lambda w: (1e4 - w, 0 * w + 1), 1e4


@pytest.mark.parametrize("case", range(3))
def test_the_boundary_is_followed_until_it_leaves_the_window_for_good(case: int) -> None:
    at, leaves = [*curve(50.0)][case]
    window = (-1.0, 50.0, -2.0, 50.0)
    end = plane._end(at, window, [])
    assert 1.1 * leaves < end < 1.3 * leaves
    assert plane._end(at, window, [0.01, 3.0]) == pytest.approx(min(end, 2 * np.pi * plane._TURNS / 3))
    assert plane._end(lambda w: (-2 - w, w), window, []) == 100


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("rule", [Rule.ANY, Rule.NONNEGATIVE, Rule.POSITIVE])
def test_a_walk_ends_before_what_touches_the_circle_and_tells_no_change_there(rule: Rule, side: int) -> None:
    """A pair that comes and goes back at once, or one that comes at 1 while another leaves at -1; on the other side nothing is."""
    for start, share in (
        (Fraction(3), Fraction(4, 3)),
        (Fraction(1, 70), Fraction(9)),
        (Fraction(1, 3), Fraction(11, 10)),
    ):
        touch = start * share**side
        for kind in ("pair", "both"):
            loop: Any = Placed(random.Random(1), twins=False)
            loop.at_0, loop.at_one = False, Integer(1)
            loop.zeros = [[], [], [touch, touch]] if kind == "pair" else [[touch], [touch], []]
            loop.signs = {touch: 0}
            walk = Walk(loop, start, loop.count(Rational(start.numerator, start.denominator))[0], rule)
            found, known = walk.towards(side)
            assert found is None
            assert 0 <= (touch - known) * side <= touch / 10**6
            other, far = walk.towards(-side)
            assert other is None
            if side < 0:
                assert far == start * 1025
            else:
                assert far == (-1023 * start if rule is Rule.ANY else 0)


@pytest.mark.parametrize("rule", [Rule.NONNEGATIVE, Rule.POSITIVE, Rule.ANY])
def test_a_change_at_0_is_no_change_on_the_way_up(rule: Rule) -> None:
    """z = 1/(1 + k): it leaves the circle at 0 alone, and stays inside for all that is more."""
    plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))
    walk = Walk(Opened(SampledLoop(plant, Integer(1), (k / (1 + k),), (Integer(1),)), k), Fraction(1, 2), 0, rule)
    found, known = walk.towards(1)
    assert found is None
    assert known == Fraction(1025, 2)
    found, known = walk.towards(-1)
    if rule is Rule.NONNEGATIVE:
        assert found is not None
        assert known == 0
        assert found.value == ExactNumber(Integer(0))
    elif rule is Rule.POSITIVE:
        assert found is None
