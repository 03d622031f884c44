"""Loops with a clock over boxes of values: against roots that were put at known places, and a table of plants."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from math import prod
from typing import Any

import flint
import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Poly, Rational, Symbol, pi

import haptisym as hs
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.pulse import Plant, SampledLoop
from haptisym.kernel.schurcohn import Circle
from haptisym.verbs.stability import oncircle
from haptisym.verbs.stability.clocked import loop_of
from haptisym.verbs.stability.oncircle import Cell, OnCircle, halves

k, h = Symbol("k", real=True), Symbol("h", real=True)
w = Symbol("w")
UNIT = (Fraction(0), Fraction(1))


def loop_with(C: Expr) -> SampledLoop:
    """1/s behind a hold of 1 s is w/(1 - w), w = 1/z: with (C - 1)/w + 1 for a controller the loop is C, if C(0) = 1."""
    row = Poly(((C - 1) / w + 1).expand(), w).all_coeffs()[::-1]
    return SampledLoop(
        Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),)), Integer(1), (*row,), (Integer(1),)
    )


class Asked(OnCircle):
    """One that is not clear where bad shares lie, nor where a cell is wider than a bound, and that knows what it was asked."""

    def is_clear(self, cell: Cell) -> bool:
        looked.append(cell)
        holds = any(all(a <= x <= b for x, (a, b) in zip(at, cell, strict=True)) for at in bad)
        return not holds and all(b - a <= widest for a, b in cell)


looked: list[Cell] = []
bad: list[tuple[Fraction, ...]] = []
widest = Fraction(1)


def volume(cells: list[Cell]) -> Fraction:
    assert all(0 <= a < b <= 1 for cell in cells for a, b in cell)
    return sum((prod((b - a for a, b in cell), start=Fraction(1)) for cell in cells), Fraction(0))


@pytest.mark.parametrize("sides", [1, 2, 3])
@pytest.mark.parametrize("hidden", [0, 1, 2])
def test_cells_that_are_left_hold_all_that_is_not_clear_and_with_those_that_are_clear_they_are_the_whole(
    sides: int, hidden: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw = random.Random(10 * sides + hidden)
    ranges = {Symbol(f"x{i}"): (Integer(0), Integer(1)) for i in range(sides)}
    own = Asked(loop_with(1 - w / 2), ranges)
    bad[:] = [tuple(Fraction(draw.randint(0, 97), 97) for _ in range(sides)) for _ in range(hidden)]
    monkeypatch.setitem(globals(), "widest", Fraction(1, draw.choice([1, 2, 4])))
    for most in (1, 40, 300):
        monkeypatch.setattr(oncircle, "_MOST_CELLS", most)
        looked.clear()
        left = own.left()
        clear = [cell for cell in looked if OnCircle.is_clear is not Asked.is_clear and is_clear(own, cell)]
        assert looked[0] == (UNIT,) * sides
        assert volume(left) + volume(clear) == 1
        assert all(any(all(a <= x <= b for x, (a, b) in zip(at, y, strict=True)) for y in left) for at in bad)
        if most == 300:
            assert bool(left) is bool(bad)
            assert len(looked) >= 300 or not bad
        assert len(looked) <= most + 1
    with limited(1e-9), pytest.raises(LimitError):
        own.left()


def is_clear(own: Asked, cell: Cell) -> bool:
    before = len(looked)
    found = own.is_clear(cell)
    del looked[before:]
    return found


@pytest.mark.parametrize("error", [UndecidedError("why"), ZeroDivisionError(), ValueError()])
def test_where_balls_fail_a_cell_is_not_clear(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> bool:
        raise error

    own = OnCircle(loop_with(1 - k * w), {k: (Integer(0), Rational(1, 2))})
    assert own.is_clear((UNIT,)) is True
    monkeypatch.setattr(oncircle, "is_clear", fails)
    assert own.is_clear((UNIT,)) is False


@pytest.mark.parametrize("seed", range(3))
def test_values_that_put_a_root_on_the_circle_lie_in_a_cell_that_is_left(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """z = k/K or -k/K, and a pair of |z|^2 = h/H."""
    draw = random.Random(seed)
    monkeypatch.setattr(oncircle, "_MOST_CELLS", 60)
    for _ in range(3):
        K, H = (Rational(draw.randint(4, 20), 4) for _ in range(2))
        C = (1 - draw.choice([1, -1]) * k / K * w) * (1 - Rational(draw.randint(-9, 9), 10) * w + h / H * w**2)
        ranges = {}
        for symbol in (k, h):
            low = Rational(draw.randint(0, 30), 8)
            ranges[symbol] = low, low + Rational(draw.randint(1, 16), 8)
        own = OnCircle(loop_with(C), ranges)
        met = [low <= x <= high for x, (low, high) in zip((K, H), ranges.values(), strict=True)]
        near = [min(abs(x - low), abs(x - high)) for x, (low, high) in zip((K, H), ranges.values(), strict=True)]
        left = own.left()
        if any(met):
            shares = [(x - low) / (high - low) for x, (low, high) in zip((K, H), ranges.values(), strict=True)]
            for i, share in enumerate(shares):
                for at in ([Rational(n, 7) for n in range(8)]) if met[i] else ():
                    place = [at, at]
                    place[i] = share
                    assert any(all(a <= x <= b for x, (a, b) in zip(place, y, strict=True)) for y in left)
        elif min(near) > Rational(1, 4):
            assert left == []
        values = {symbol: low + (high - low) * Rational(1, 3) for symbol, (low, high) in ranges.items()}
        stable = bool(values[k] < K and values[h] < H)
        assert own.is_stable(values) is stable


@pytest.mark.parametrize("hidden", [False, True])
def test_of_values_without_roots_that_last_all_are_stable_and_of_others_none_if_nothing_hides(
    monkeypatch: pytest.MonkeyPatch, *, hidden: bool
) -> None:
    own = OnCircle(loop_with(1 - k * w), {k: (Integer(0), Integer(1))})
    monkeypatch.setattr(OnCircle, "hides_none", not hidden)
    for inside, on in product(range(3), repeat=2):
        monkeypatch.setattr(oncircle, "count_on_circle", lambda *_, x=inside, y=on: Circle(x, y, 1))
        expected = True if (inside, on) == (0, 0) else None if hidden else False
        assert own.is_stable({k: Integer(1)}) is expected


@pytest.mark.parametrize("seed", range(4))
def test_nothing_hides_where_all_poles_decay_or_lie_at_0_and_the_controller_has_none_outside_of_the_circle(
    seed: int,
) -> None:
    """Of numbers alone: zeros of the plant's denominator that were put there, and a controller by its coefficients."""
    draw, told = random.Random(seed), set()
    s = Symbol("s")
    for _ in range(25):
        roots = [draw.choice([-3, -2, -1, -1, 1]) for _ in range(draw.randint(0, 2))]
        pairs = [(draw.choice([-2, -1, -1, -1, 0, 1]), draw.choice([1, 2])) for _ in range(draw.randint(0, 1))]
        order = draw.randint(0, 2)
        shape = prod([s - x for x in roots], start=Integer(1)) * prod(
            ((s - x) ** 2 + y**2 for x, y in pairs), start=Integer(1)
        )
        row = Poly(draw.choice([-2, 1]) * s**order * shape + 0 * s, s).all_coeffs()[::-1]
        below = [draw.choice([-2, 2, 3]), *(draw.randint(-1, 1) for _ in range(draw.randint(0, 3)))]
        plant = Plant((*row,), ((Integer(0), (Integer(1),)),))
        own = OnCircle(SampledLoop(plant, Integer(1), (Integer(1),), (*map(Integer, below),)), {})
        decays = all(x < 0 for x in [*roots, *(x for x, _ in pairs)])
        expected = decays and abs(below[0]) >= sum(map(abs, below[1:]))
        assert own.hides_none is expected, (row, below)
        told.add(expected)
    assert told == {True, False}


OF_RANGES: list[tuple[tuple[Expr, ...], tuple[Expr, Expr], bool]] = [
    ((k, Integer(1)), (Integer(0), Integer(2)), True),  # s + k
    ((k, Integer(1)), (Integer(1), Integer(2)), True),
    ((k, Integer(1)), (Rational(-1, 9), Integer(2)), False),
    ((-k, Integer(-1)), (Integer(0), Integer(2)), True),
    ((Integer(0), k, Integer(1), Integer(2)), (Integer(0), Integer(2)), True),
    ((k**2 + pi * k, k + 1, Integer(2)), (Integer(0), Integer(2)), True),
    ((k - 1, Integer(1)), (Integer(1), Integer(2)), False),  # a difference, of which that is not seen
    ((Integer(1), 2 - k, Integer(1)), (Integer(0), Integer(1)), True),
    ((Integer(1), 2 - k, Integer(1)), (Integer(0), Integer(2)), False),
    ((Integer(1), 2 - k, Integer(1)), (Integer(0), Integer(3)), False),
    ((Integer(6), Integer(2), Integer(2), k), (Rational(1, 10), Rational(1, 2)), True),  # 2 2 > 6 k
    ((Integer(6), Integer(2), Integer(2), k), (Rational(1, 10), Rational(3, 4)), False),
    ((Integer(1), Integer(1), k - 1), (Integer(0), Integer(3)), False),
]


@pytest.mark.parametrize("case", range(len(OF_RANGES)))
def test_with_open_numbers_nothing_hides_if_it_is_so_for_all_of_their_values(case: int) -> None:
    row, ends, expected = OF_RANGES[case]
    plant = Plant(row, ((Integer(0), (Integer(1),)),))
    own = OnCircle(SampledLoop(plant, Integer(1), (Integer(1),), (Integer(1),)), {k: ends})
    assert own.hides_none is expected
    if expected:
        for n in range(5):
            c = [float(x.subs(k, ends[0] + (ends[1] - ends[0]) * Rational(n, 4))) for x in row]
            assert all(z.real < 1e-12 for z in np.roots(c[::-1]))


@pytest.mark.parametrize(
    ("below", "ends", "expected"),
    [((2, -1, 1), (0, 1), True), ((2, -1, 1, -1), (0, 1), False), ((2, -k), (0, 1), True), ((2, k, -k), (0, 2), False),
     ((-2, k), (0, 1), True), ((k, 1), (2, 3), True), ((k, 1), (0, 2), False), ((2, k), (-1, 1), True)],
)  # fmt: skip
def test_a_controller_hides_nothing_whose_first_coefficient_is_as_large_as_all_others_together(
    below: Any, ends: Any, *, expected: bool
) -> None:
    plant = Plant((Integer(2), Integer(1)), ((Integer(0), (Integer(1),)),))
    row = tuple(Integer(0) + x for x in below)
    own = OnCircle(SampledLoop(plant, Integer(1), (Integer(1),), row), {k: (Integer(ends[0]), Integer(ends[1]))})
    assert own.hides_none is expected


@pytest.mark.parametrize("seed", range(3))
def test_a_cell_stands_for_its_values_and_hardly_more(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        ends = [sorted(draw.sample(range(-9, 10), 2)) for _ in range(2)]
        shares = [sorted(Fraction(x, 16) for x in draw.sample(range(17), 2)) for _ in range(2)]
        own = OnCircle(loop_with(1 - k * w), {k: tuple(map(Integer, ends[0])), h: tuple(x * pi for x in ends[1])})
        cell = tuple(tuple(x) for x in shares)
        with flint.ctx.workprec(96):
            found = own._at(cell)  # type: ignore[arg-type]
            for symbol, (low, high), (a, b), unit in zip((k, h), ends, shares, (arb(1), arb.pi()), strict=True):
                for share, is_in in (
                    (a, True),
                    ((a + b) / 2, True),
                    (b, True),
                    (a - Fraction(1, 99), False),
                    (b + Fraction(1, 99), False),
                ):
                    true = low + share * (high - low)
                    assert found[symbol].contains(unit * true.numerator / true.denominator) is is_in


@pytest.mark.parametrize("seed", range(3))
def test_a_cell_is_cut_in_the_middle_of_the_widest_of_its_sides_and_both_parts_are_the_whole(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(25):
        cell = tuple(
            tuple(sorted(Fraction(x, 9) for x in draw.sample(range(10), 2))) for _ in range(draw.randint(1, 4))
        )
        sides = sorted(draw.sample(range(len(cell)), draw.randint(1, len(cell))))
        one, other = halves(cell, sides)  # type: ignore[arg-type]
        [i] = [n for n in range(len(cell)) if one[n] != cell[n]]
        assert i == next(n for n in sides if cell[n][1] - cell[n][0] == max(cell[m][1] - cell[m][0] for m in sides))
        middle = (cell[i][0] + cell[i][1]) / 2
        assert (one[i], other[i]) == ((cell[i][0], middle), (middle, cell[i][1]))
        assert all(one[n] == other[n] == cell[n] for n in range(len(cell)) if n != i)


def test_what_is_open_in_the_loop_is_what_has_a_range_and_a_root_that_stays_at_one_is_left_open() -> None:
    sampled, shunt = hs.effects.sampled_loop("1 ms", "backward-difference", 1), hs.effects.shunt(m="0.04", b="0.8")
    wall = hs.Scene(hs.environments.kelvin_voigt(["90 N/m", "110 N/m"], 2), (sampled, shunt))
    hand = hs.Hand("any", "0.1 kg", ["1", "3"], 5)
    numbers = {p.symbol: p for p in (*wall.parameters, *hand.parameters)}
    both = [p for p in numbers.values() if p.interval]
    assert len(both) == 2
    for n in (1, 2):
        own = OnCircle.of(wall, hand, {p.symbol: p.interval for p in both[-n:] if p.interval})
        parts = [own.loop.T, *own.loop.above, *own.loop.below, *own.loop.plant.denominator]
        parts += [x for lag, row in own.loop.plant.terms for x in (lag, *row)]
        assert set().union(*(x.free_symbols for x in parts)) == {p.symbol for p in both[-n:]}
        fixed, given = loop_of(wall, hand), own.loop.at({p.symbol: p.value for p in both})
        assert all(x.overlaps(y) for x, y in zip(fixed.balls(), given.balls(), strict=True))
    free = hs.Scene(hs.environments.mass_spring_damper(b=["1", "2"]), (sampled, shunt))
    damper = next(p for p in free.parameters if p.interval)
    with pytest.raises(UndecidedError, match="stays at z = 1"):
        OnCircle.of(free, hs.Hand("nothing"), {damper.symbol: damper.interval or (Integer(0), Integer(0))})


@pytest.mark.parametrize("seed", range(3))
def test_a_polynomial_in_balls_is_hurwitz_if_each_in_them_is(seed: int) -> None:
    draw, told = random.Random(seed), [0, 0]
    assert oncircle._is_hurwitz([arb(3)]) is oncircle._is_hurwitz([arb(0), arb(1)]) is True
    assert oncircle._is_hurwitz([arb(1), arb(0)]) is oncircle._is_hurwitz([arb(1), arb(-1)]) is False
    with flint.ctx.workprec(96):
        for _ in range(60):
            roots = [
                complex(draw.choice([-3, -2, -1, -0.5, 0.25]), draw.choice([0, 0, 1, 3]))
                for _ in range(draw.randint(1, 3))
            ]
            row = np.real(np.poly([*roots, *(z.conjugate() for z in roots if z.imag)]))[::-1] * draw.choice([1, 2.5])
            wide = draw.choice([0, 1e-9, 0.05])
            if row[0] < 0:  # of which it is not asked
                continue
            found = oncircle._is_hurwitz([arb(c, wide * abs(c)) for c in row])
            for _ in range(12):
                near = [c * (1 + wide * draw.choice([-1, 1])) for c in row]
                if found:
                    assert all(z.real < 0 for z in np.roots(near[::-1]))
            if wide < 0.01:
                assert found is all(z.real < 0 for z in roots)
                told[found] += 1
    assert min(told) > 3
