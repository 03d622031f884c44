"""Bandwidths as a threshold grows, where every peak of the ratios is at a number that is known by hand: equal ones, and ends at them, too."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import sqrt
from random import Random

import pytest
from flint import fmpq, fmpq_poly
from sympy import Expr, Integer, Rational, pi
from sympy import sqrt as sqrt_

import haptisym as hs
from haptisym.judge.climb import Climb
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega

CRITERIA = noticed(hs.Threshold())


class Ratio:
    """The largest of |p(omega^2)| of some polynomials whose slopes vanish at known places, on a band of omega^2."""

    def __init__(self, pick: Random, count: int) -> None:
        self.low = Fraction(pick.choice([0, 0, 1]))
        self.high = Fraction(pick.choice([4, 9, 16]))
        self.rows, self.stops = list[fmpq_poly](), set[Fraction]()
        for _ in range(count):
            places = [Fraction(pick.randint(-2, 20), pick.choice([1, 1, 2])) for _ in range(pick.randint(0, 3))]
            slope = fmpq_poly([fmpq(pick.choice([1, -1, 2]), pick.randint(1, 3))]) if places else fmpq_poly([0])
            for x in places:
                slope *= fmpq_poly([-_fmpq(x), 1])
            self.rows.append(slope.integral() + fmpq(pick.randint(-12, 12), 2))
            self.stops |= {x for x in places if self.low < x < self.high}

    def at(self, w: Fraction) -> Fraction:
        return max(abs(_fraction(p(_fmpq(w)))) for p in self.rows)

    def function(self, p: fmpq_poly) -> RealFunction:
        form = sum((Rational(int(c.p), int(c.q)) * omega ** (2 * n) for n, c in enumerate(p.coeffs())), Integer(0))
        return RealFunction(Ring().axis.convert((form**2).expand()))

    def bandwidth(self, c: Fraction) -> float | None:
        """Up to where it is nowhere above c: in omega^2."""
        if self.at(self.low) > c:
            return None
        zeros = {self.low, self.high}
        for p in self.rows:
            for level in (c, -c):
                moved = p - _fmpq(level)
                roots = moved.complex_roots() if moved.degree() > 0 else []
                zeros |= {Fraction(float(z.real)) for z, _ in roots if z.imag == 0}
        inside = sorted(x for x in zeros if self.low <= x <= self.high)
        # between zeros that agree as floats nothing is looked at: by less than their rounding
        for a, b in pairwise(inside):
            if b - a > Fraction(1, 10**9) and self.at((a + b) / 2) > c:
                return float(a)
        return float(self.high)

    def records(self) -> list[tuple[Fraction, Fraction]]:
        """The local maxima inside of the band that are higher than all before them, with their heights."""
        found, top = list[tuple[Fraction, Fraction]](), self.at(self.low)
        for w in sorted(self.stops):
            beside = [abs(_fraction(p(_fmpq(w)))) for p in self.rows]
            near = Fraction(1, 10**6)
            is_top = all(self.at(w + e) < max(beside) for e in (-near, near))
            if is_top and max(beside) > top:
                found.append((w, max(beside)))
            top = max(top, *beside)
        return found


def _fmpq(x: Fraction) -> fmpq:
    return fmpq(x.numerator, x.denominator)


def _fraction(x: fmpq) -> Fraction:
    return Fraction(int(x.p), int(x.q))


def _exact(x: Fraction) -> Expr:
    return Rational(x.numerator, x.denominator)


def _is(x: RealNumber | None, w: float | None) -> bool:
    return x is None if w is None else x is not None and abs(float(x) ** 2 - w) <= 1e-8 * max(w, 1e-3)


def _agree(pick: Random) -> bool:
    """Whether it was decided."""
    ratio = Ratio(pick, pick.choice([1, 1, 2]))
    start, records = ratio.at(ratio.low), ratio.records()
    marks = [h for _, h in records] + [start]
    lows = [x for h in marks for x in (h, h / 2, h * Fraction(9, 10)) if x > 0]
    if not lows:
        return True
    low = pick.choice(lows)
    high = pick.choice([low, *(x for x in (*marks, *(2 * x for x in marks)) if x >= low)])
    band = tuple(Integer(round(sqrt(x))) for x in (ratio.low, ratio.high))
    squares = {x: ratio.function(p) for x, p in zip(CRITERIA, ratio.rows, strict=False)}
    try:
        found = Climb(squares, (_exact(low), _exact(high)), band, "jnd").found
    except UndecidedError:
        return False
    assert _is(found.most, ratio.bandwidth(high))
    if found.most is None:
        assert (found.least, found.jumps, found.blocked) == (None, (), {})
        return True
    assert [float(x) for x in found.blocked.values()] == pytest.approx([float(start)] if start > low else [])
    first = max(low, start)
    assert _is(found.least, ratio.bandwidth(first))
    expected = [(w, h) for w, h in records if first < h <= high]
    assert len(found.jumps) == len(expected)
    for jump, (w, h) in zip(found.jumps, expected, strict=True):
        assert _is(jump.low, float(w))
        assert _is(jump.high, ratio.bandwidth(h))
        assert jump.threshold is not None
        assert float(jump.threshold) == pytest.approx(float(h))
        assert not jump.includes_low
    return True


@pytest.mark.parametrize("seed", range(2))
def test_the_bandwidth_jumps_at_each_peak_that_is_higher_than_all_before_it(seed: int) -> None:
    pick = Random(seed)
    assert sum(_agree(pick) for _ in range(6)) >= 5


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 20))
def test_the_bandwidth_jumps_at_each_peak_that_is_higher_than_all_before_it_in_many_ratios(seed: int) -> None:
    pick = Random(seed)
    assert sum(_agree(pick) for _ in range(40)) >= 36


LOW = pi / 3
"""Where a ratio has no value that is a fraction."""


@pytest.mark.parametrize(
    ("ratios", "least", "start"),
    [
        ([omega**2 / 4], LOW, LOW**2 / 4),  # it rises from the start on
        ([omega**2 / 4, Rational(1, 10) + 0 * omega], LOW, LOW**2 / 4),
        ([omega**2 / 4, Rational(1, 2) + 0 * omega], sqrt_(2), Rational(1, 2)),  # the other one is higher there
        ([(omega**2 - 4) / 4], sqrt_(8 - LOW**2), 1 - LOW**2 / 4),  # it falls, and is as high again
        ([(omega**2 - 4) / 4, omega**2 / 9], sqrt_(9 * (1 - LOW**2 / 4)), 1 - LOW**2 / 4),
    ],
)
def test_from_an_end_of_the_band_that_is_no_fraction_bandwidths_begin_with_what_the_ratio_there_gives(
    ratios: list[Expr], least: Expr, start: Expr
) -> None:
    squares = {x: RealFunction(Ring().axis.convert((f**2).expand())) for x, f in zip(CRITERIA, ratios, strict=False)}
    found = Climb(squares, (Rational(1, 20), Integer(4)), (LOW, Integer(3)), "jnd").found
    assert found.least is not None
    assert float(found.least) == pytest.approx(float(least), rel=1e-14)
    assert {name: float(x) for name, x in found.blocked.items()} == {"jnd": pytest.approx(float(start), rel=1e-14)}
    assert float(found.most) == 3
    row = found.row(12)
    assert (row["least"]["value"], row["most"]["value"], row["certified"]) == (float(found.least), 3.0, True)
    assert list(row["none_below"]) == ["jnd"]
    for jump, told in zip(found.jumps, row["jumps"], strict=True):
        assert (told["from"]["value"], told["to"]["value"]) == (float(jump.low), float(jump.high))
        assert told["threshold"]["digits"] == jump.threshold.digits(12)  # type: ignore[union-attr]
        assert "from_reached" not in told


def test_two_peaks_of_one_height_are_passed_at_once_up_to_where_another_ratio_is_as_high() -> None:
    """1 - (w - 1)^2 (w - 5)^2/32 of w = omega^2 is 1 at 1 and 5, and w/6 at 6; at 1/2 and 2 the first one is for roots of 3."""
    w = omega**2
    ratios = 1 - (w - 1) ** 2 * (w - 5) ** 2 / 32, w / 6
    ends = Rational(1, 2), Integer(2)
    for listed in (ratios, ratios[::-1]):
        squares = {x: RealFunction(Ring().axis.convert((f**2).expand())) for x, f in zip(CRITERIA, listed, strict=True)}
        found = Climb(squares, ends, (Integer(0), Integer(3)), "jnd").found
        [jump] = found.jumps
        assert [float(x) ** 2 for x in (found.least, jump.low, jump.high, found.most) if x] == pytest.approx(
            [3 - sqrt(8), 1, 6, 3 + sqrt(4 + sqrt(96))], rel=1e-14
        )
        assert float(jump.threshold or 0) == 1
