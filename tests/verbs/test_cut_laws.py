"""How cells of values are cut, how far the limits at 0 and without bound reach, and from which delay on all phases are there."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import cos, nextafter, pi, sin
from random import Random
from typing import Any

import pytest
from plainshapes import function_of, q, rational, real_part
from sympy import Expr, Integer, Rational, exp, sqrt

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.response import on_axis
from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s
from haptisym.verbs.require.cells import Leaf, ValueSearch, _bound_by_phase, _middle, _not_below
from haptisym.verbs.require.places import CellVerdict

REAL, IMAG = noticed(hs.Threshold())
BAND = Integer(1), Integer(5)
KEPT, BROKEN, OPEN = CellVerdict.KEPT, CellVerdict.BROKEN, CellVerdict.OPEN


# How cells are cut


class Marked(ValueSearch):
    """Cells that are open while one of some numbers is inside, kept and broken in turn between these; each look is noted."""

    def __init__(self, marks: list[Fraction], most: int = 10**6) -> None:
        super().__init__({}, q, BAND, Fraction(1))
        self.__dict__.update(marks=marks, looked=[], most=most)

    def _judged(self, low: Fraction, high: Fraction) -> Leaf:
        own: dict[str, Any] = self.__dict__
        if len(own["looked"]) == own["most"]:
            raise LimitError("the time is over")
        own["looked"].append((low, high))
        if any(low < x < high for x in own["marks"]):
            return Leaf(low, high, OPEN)
        return Leaf(low, high, KEPT if sum(x <= low for x in own["marks"]) % 2 else BROKEN)


@pytest.mark.parametrize("seed", range(6))
def test_cells_are_cut_widest_first_down_to_what_is_narrow_and_what_no_time_is_left_for_stays_open(seed: int) -> None:
    pick = Random(seed)
    low, high = pick.choice(
        [
            (Fraction(1), Fraction(9)),
            (Fraction(-6), Fraction(-1)),
            (Fraction(1, 64), Fraction(7)),
            (Fraction(3), Fraction(900)),
        ]
    )
    marks = sorted(low + (high - low) * Fraction(pick.randint(1, 9999), 10007) for _ in range(3))
    whole = Marked(marks)
    for search in (whole, Marked(marks, pick.randint(1, 40))):
        leaves: list[Any] = search._cut(low, high)
        assert (leaves[0].low, leaves[-1].high) == (low, high)
        assert all(a.high == b.low for a, b in pairwise(leaves))
        widths = [
            (x.high - x.low) / max(abs(x.low), abs(x.high)) for x in leaves if x.high is not None and x.low is not None
        ]
        for x, width in zip(leaves, widths, strict=True):
            inside = [m for m in marks if x.low < m < x.high]
            assert x.verdict is OPEN or not inside
            if search is whole:
                assert (x.verdict is OPEN) is bool(inside)
                assert x.verdict is not OPEN or width < 1e-13
        looked = search.__dict__["looked"]
        ranks = [(-max((b - a) / max(abs(a), abs(b)), Fraction(1, 32)), a) for a, b in looked]
        assert ranks == sorted(ranks)
    assert len(whole.__dict__["looked"]) < 3 * 2 * 60


def test_no_more_than_eight_hundred_cells_are_looked_at() -> None:
    search = Marked([Fraction(n, 53) for n in range(54, 106)])
    leaves: list[Any] = search._cut(Fraction(1), Fraction(2))
    assert len(search.__dict__["looked"]) == 800
    assert (leaves[0].low, leaves[-1].high) == (1, 2)
    assert all(a.high == b.low for a, b in pairwise(leaves))


@pytest.mark.parametrize("seed", range(4))
def test_a_cell_is_cut_inside_nearer_the_geometric_mean_where_its_ends_are_far_apart(seed: int) -> None:
    pick = Random(seed)
    for _ in range(40):
        a = Fraction(pick.uniform(0.1, 10)) * Fraction(10) ** pick.randint(-6, 6)
        a = Fraction(float(a))
        b = Fraction(float(a * Fraction(pick.choice([1.0001, 1.5, 3, 5, 100, 10**9]))))
        for low, high in ((a, b), (-b, -a)):
            cut = _middle(low, high)
            assert low < cut < high
            assert Fraction(float(cut)) == cut
            if b > 4 * a:
                assert abs(cut * cut / (a * b) - 1) < Fraction(1, 10**12)
            else:
                share = (cut - low) / (high - low)
                assert Fraction(2, 5) < share < Fraction(3, 5)
                assert share != Fraction(1, 2)
        assert _middle(Fraction(0), b) == b / 16
        assert _middle(-b, Fraction(0)) == -b / 16
        assert Fraction(2, 5) < (_middle(-a, b) + a) / (a + b) < Fraction(3, 5)
        beside = Fraction(nextafter(float(a), 1e300))
        assert _middle(a, beside) == (a + beside) / 2


def test_how_wide_a_cell_is_is_told_by_its_values_or_a_thousandth_of_the_usual_size() -> None:
    search = ValueSearch({}, q, BAND, Fraction(5))
    for low, high, size in (
        (1, 3, 3),
        (-3, -1, 3),
        (-3, 1, 3),
        (0, Fraction(1, 1000), Fraction(1, 200)),
        (Fraction(-1, 999), 0, Fraction(1, 200)),
    ):
        assert search._width(Fraction(low), Fraction(high)) == (Fraction(high) - Fraction(low)) / size


@pytest.mark.parametrize(
    "x", [Fraction(1, 3), Fraction(2, 3), Fraction(-1, 3), Fraction(7, 2), Fraction(10**20 + 1), Fraction(1, 10)]
)
def test_a_double_that_is_not_below_is_the_next_one(x: Fraction) -> None:
    found = _not_below(x)
    assert Fraction(float(found)) == found >= x
    assert Fraction(nextafter(float(found), -1e300)) < x


# Next to 0, and without bound


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("function", "near", "far"),
    [
        (q - 1, KEPT, BROKEN), (1 - q, BROKEN, KEPT), (q**2 - q * w, KEPT, BROKEN), (w * q - q**2, BROKEN, KEPT),
        (w - 3 - q, BROKEN, KEPT), (w - 7 + q**2, KEPT, BROKEN), (-1 - q * w, KEPT, KEPT), (q**2 * w + q, BROKEN, BROKEN),
    ],
)  # fmt: skip
def test_next_to_0_and_without_bound_the_limit_tells_up_to_a_number_much_nearer(
    function: Expr, near: CellVerdict, far: CellVerdict, sign: int
) -> None:
    """For all sizes of q up to it, or beyond it; of both signs, the function mirrored."""
    search = ValueSearch({REAL: function_of(function.subs(q, sign * q))}, q, BAND, Fraction(1))
    for inverse, verdict in ((False, near), (True, far)):
        for reach in (Fraction(1), Fraction(1, 64)):
            found, up_to = search._limit(sign, reach, inverse=inverse)
            assert found is verdict
            assert 0 < up_to <= reach / 1024
            for n in (1, 2, 1000):
                t = rational(n / up_to if inverse else up_to / n)
                top = max(function.subs({q: t, w: Integer(x)}) for x in (1, 2, 3, 4, 5))
                assert bool(top > 0) is (verdict is BROKEN)
    leaf: Any = search._tail(sign, Fraction(sign * 4))
    assert leaf.verdict is far
    ends = (leaf.low, leaf.high) if sign > 0 else (leaf.high, leaf.low)
    assert ends[1] is None
    assert ends[0] is not None
    assert ends[0] * sign >= 4 * 1024


def test_of_two_conditions_next_to_0_one_that_is_broken_is_enough_and_both_must_be_kept() -> None:
    for functions, verdict in (
        ((q - 1, -1 - q), KEPT),
        ((q - 1, 1 - q), BROKEN),
        ((1 - q, q - 1), BROKEN),
        ((1 + q, 1 - q), BROKEN),
    ):
        own = dict(zip((REAL, IMAG), map(function_of, functions), strict=True))
        search = ValueSearch(own, q, BAND, Fraction(1))
        assert search._limit(1, Fraction(1), inverse=False)[0] is verdict
    pair = Lattice(((function_of(q - 1), function_of(q - 2)),))
    both = ValueSearch({REAL: pair}, q, BAND, Fraction(1))
    assert both._limit(1, Fraction(1, 8), inverse=False) == (
        OPEN,
        Fraction(1, 8),
    )  # of several functions a limit is not told


@pytest.mark.parametrize(
    ("function", "verdict"), [(exp(-q * s) - 2, KEPT), (2 * exp(-q * s) - 1, BROKEN), (1 - exp(-q * s), BROKEN)]
)
def test_of_a_delay_that_goes_to_0_the_first_term_tells_and_of_a_negative_or_a_long_one_nothing(
    function: Expr, verdict: CellVerdict
) -> None:
    search = ValueSearch({REAL: real_part(function)}, q, BAND, Fraction(1))
    found, up_to = search._limit(1, Fraction(1), inverse=False)
    assert (found, 0 < up_to <= Fraction(1, 1024)) == (verdict, True)
    for sign, inverse in ((-1, False), (1, True), (-1, True)):
        assert search._limit(sign, Fraction(1, 3), inverse=inverse) == (OPEN, Fraction(1, 3))
    leaves: list[Any] = search.leaves(Fraction(0), Fraction(1, 4))
    assert (leaves[0].low, leaves[0].verdict) == (0, verdict)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("verdict", [KEPT, BROKEN])
@pytest.mark.parametrize("step", [0, 1, 4, 5])
def test_where_no_limit_tells_multiples_of_eight_are_tried_five_times_until_one_does(
    step: int,
    verdict: CellVerdict,
    sign: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start = Fraction(3 * sign, 7)
    search = ValueSearch({REAL: function_of(q - 1)}, q, BAND, Fraction(1))
    monkeypatch.setattr(ValueSearch, "_limit", lambda *_, **__: (OPEN, Fraction(1)))
    monkeypatch.setattr(ValueSearch, "_near_limit", lambda *_, **__: None)
    monkeypatch.setattr(ValueSearch, "_beyond", lambda _, own, x: verdict if x * own >= abs(start) * 8**step else OPEN)
    bound = start * 8 ** min(step, 5)
    expected = verdict if step < 5 else OPEN
    assert search._tail(sign, start) == (Leaf(bound, None, expected) if sign > 0 else Leaf(None, bound, expected))
    monkeypatch.setattr(
        ValueSearch, "_near_limit", lambda *_, **__: object()
    )  # a limit that did not tell is asked once
    first = verdict if step == 0 else OPEN
    assert search._tail(sign, start).verdict is first


def test_where_the_time_is_over_values_without_bound_are_open_from_where_they_begin(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def over(*_: Any, **__: Any) -> Any:
        raise LimitError("the time is over")

    search = ValueSearch({REAL: function_of(q - 1)}, q, BAND, Fraction(1))
    monkeypatch.setattr(ValueSearch, "_limit", over)
    assert search._tail(1, Fraction(3)) == Leaf(Fraction(3), None, OPEN)
    assert search._tail(-1, Fraction(-3)) == Leaf(None, Fraction(-3), OPEN)


# A delay that turns all phases


@pytest.mark.parametrize("rate", [1, 3])
@pytest.mark.parametrize("seed", range(6))
def test_beyond_a_delay_all_phases_lie_in_the_longest_piece_on_which_one_of_four_is_broken(
    seed: int, rate: int
) -> None:
    """a cos + b w sin of rate q w, and c: at half angles with the tangents 1, -1, 3 and -3; 1 to 1.05 full turns."""
    pick = Random(seed)
    a, b, c = pick.randint(-6, 6), pick.choice([-2, -1, 1, 2]), pick.randint(-6, 6)
    function = real_part(a * exp(-rate * q * s) + b * s * exp(-rate * q * s) + c)
    lengths = []
    for tangent in (1, -1, 3, -3):
        x, y = Fraction(1 - tangent**2, 1 + tangent**2), Fraction(2 * tangent, 1 + tangent**2)
        zero = -(a * x + c) / (b * y)  # of a x + c + b y w
        lengths.append(5 - max(Fraction(1), zero) if b * y > 0 else min(Fraction(5), zero) - 1)
    found = _bound_by_phase([function], q, BAND)
    if max(lengths) <= 0:
        assert found is None
        return
    assert found is not None
    turns = float(found) * rate * float(max(lengths)) / (2 * pi)
    assert 1 < turns < 1.05
    tops = [
        max(a * cos(rate * t * x) + b * x * sin(rate * t * x) + c for x in [1 + n / 500 for n in range(2001)])
        for t in (float(found), 2.3 * float(found))
    ]
    assert min(tops) > -0.05
    search = ValueSearch({REAL: function}, q, BAND, Fraction(1))
    assert search._tail_by_phase(1) == Leaf(found, None, BROKEN) == search._tail(1, Fraction(1))
    assert search._tail_by_phase(-1) is None


def test_no_delay_is_long_enough_where_a_number_stands_beside_it_where_two_turn_or_none_breaks() -> None:
    late, later = exp(-q * s), exp(-sqrt(2) * q * s)
    for function in (q * late + 3, late - 2, late + later + 3, exp(-s / 3) + 2 + 0 * q):
        assert _bound_by_phase([real_part(function)], q, BAND) is None


@pytest.mark.parametrize(("other", "length"), [(-(s**2) - 9, 2), (s**2 + 9, 2), (s**2, 0), (-(s**2), 4)])
def test_of_two_functions_the_phases_count_at_which_both_are_positive(other: Expr, length: int) -> None:
    """cos q w + 1/2, beside w^2 - 9, 9 - w^2, -w^2 and w^2."""
    ring = Ring.of([exp(-q * s), s, q])
    own = [on_axis(ring.convert(x)).real for x in (exp(-q * s) + Rational(1, 2), other)]
    for pair in (own, own[::-1]):
        found = _bound_by_phase(pair, q, BAND)
        assert (found is None) is (length == 0)
        assert found is None or 1 < float(found) * length / (2 * pi) < 1.05
