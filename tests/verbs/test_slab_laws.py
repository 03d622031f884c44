"""How values and frequencies are cut into slabs and cells for a certificate, and which points are tried: rules by hand."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from random import Random
from typing import Any

import pytest

from haptisym.kernel.budget import limited
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.verbs.evaluate.products import Factor
from haptisym.verbs.evaluate.waves import WaveFactor
from haptisym.verbs.require import slabs
from haptisym.verbs.require.slabs import Ends, Problem, Slab, _middle
from haptisym.verbs.require.slicing import sliced

PLAIN = Factor(((1, 2), (3,)), 1)
LATE = WaveFactor((((0,), ((1,),)),), (1,), (Fraction(1, 4),))
POWER = WaveFactor((((0, 1, 0), ((1,),)),), (1,), (Fraction(1, 4),), (Fraction(1, 2),))


def value(x: Any) -> Fraction | None:
    return None if x is None else Fraction(x)


def problem(
    *factors: Any, band: Any = (0, 0, 8, 8), starts: Any = (), names: tuple[str, ...] = ("excess.real",)
) -> Problem:
    told: Any = dict.fromkeys(names), tuple(map(Fraction, band)), list(map(Fraction, starts))
    return Problem(factors, *told)


def test_values_are_cut_by_halves_far_from_each_other_about_in_geometric_mean_and_without_bound_at_twice() -> None:
    F = Fraction
    rows: Any = (
        (None, None, 0), (F(0), None, 1), (F(3), None, 6), (F(1, 4), None, F(5, 4)), (F(-3), None, -2),
        (F(-1, 2), None, F(1, 2)), (None, F(3), 2), (None, F(0), -1), (None, F(-3), -6), (None, F(-1, 4), F(-5, 4)),
        (F(0), F(8), F(1, 2)), (F(0), F(1, 9), F(1, 144)), (F(2), F(4), 3), (F(1), F(8), F(9, 2)), (F(-8), F(8), 0),
        (F(-8), F(-1), F(-9, 2)), (F(-1), F(100), F(99, 2)),
    )  # fmt: skip
    for low, high, cut in rows:
        assert _middle(low, high) == cut
    far = (F(1), F(9)), (F(1), F(10**8)), (F(1, 10**9), F(1)), (F(1, 10**30), F(1, 10**20)), (F(7, 3), F(10**4, 7))
    for low, high in far:
        cut = _middle(low, high)
        assert low < cut < high
        assert float(cut) == pytest.approx((float(low) * float(high)) ** 0.5, rel=1e-3)
        assert cut**2 > low * high
        assert cut.denominator <= max(Fraction(10**6), 1000 / low)


def test_halves_meet_at_a_value_that_belongs_to_both() -> None:
    for held in product((True, False), repeat=2):
        one, other = Ends(Fraction(2), Fraction(4), *held).halves()
        assert one == Ends(Fraction(2), Fraction(3), held[0], True)  # noqa: FBT003
        assert other == Ends(Fraction(3), Fraction(4), True, held[1])  # noqa: FBT003


@pytest.mark.parametrize(("low", "high"), [(None, None), (None, 4), (-3, None), (-3, 4), (0, 1)])
def test_slabs_follow_each_other_from_end_to_end_each_as_wide_as_it_can_be_told(
    low: Any, high: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Told where no value at which the answer changes is inside, and where it is not all of what there is."""
    asked: list[Ends] = []
    low, high = map(value, (low, high))
    marks = [Fraction(-1), Fraction(1, 2), Fraction(3)]

    def slab(own: Problem, ends: Ends, *, holds: bool) -> Any:
        asked.append(ends)
        assert not (ends.low is None and ends.high is None)
        inside = [x for x in marks if (ends.low is None or ends.low < x) and (ends.high is None or x < ends.high)]
        wide = ends.low is not None and ends.high is not None and ends.high - ends.low > Fraction(1, 4)
        return None if inside and (wide or ends.low is None or ends.high is None) else {"holds": holds}

    monkeypatch.setattr(Problem, "_slab", slab)
    for holds in (True, False):
        asked.clear()
        found = list(problem(PLAIN).slabs(Ends(low, high, True, False), holds=holds))  # noqa: FBT003
        assert (value(found[0]["from"]), value(found[-1]["to"])) == (low, high)
        assert all(a["to"] == b["from"] is not None for a, b in pairwise(found))
        assert all(x["holds"] is holds for x in found)
        assert low is high is None or (asked[0].low, asked[0].high) == (low, high)
        told = [(value(x["from"]), value(x["to"])) for x in found]
        assert [(x.low, x.high) for x in asked if (x.low, x.high) in told] == told
        for x in asked:
            assert x.holds_low
            assert x.holds_high is (x.high != high)


@pytest.mark.parametrize(
    ("factors", "most"), [((PLAIN, PLAIN), 150), ((LATE,), 40), ((PLAIN, LATE), 40), ((LATE, PLAIN), 40)]
)
def test_there_are_as_many_slabs_as_a_certificate_may_have_fewer_with_waves(
    factors: Any, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    for count in (most, most + 1):
        made: list[Ends] = []

        def slab(own: Problem, ends: Ends, *, holds: bool, made: Any = made, count: int = count) -> Any:
            made.append(ends)
            cut = sum(x.high != Fraction(1) for x in made)
            return None if ends.high == 1 and cut < count - 1 else {}

        monkeypatch.setattr(Problem, "_slab", slab)
        whole = problem(*factors).slabs(Ends(Fraction(0), Fraction(1)), holds=True)
        if count == most:
            assert len(list(whole)) == most
        else:
            with pytest.raises(UndecidedError, match="a certificate"):
                list(whole)


def test_when_the_time_is_over_no_slab_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Problem, "_slab", lambda *_, holds: {})
    with limited(1e-9), pytest.raises(LimitError):
        list(problem(PLAIN).slabs(Ends(Fraction(0), Fraction(1)), holds=True))


def test_points_that_bind_are_tried_first_then_some_near_0_where_powers_have_no_bounds_and_sixteenths_of_the_band() -> (
    None
):
    inner = [Fraction(n, 2) for n in range(1, 16)]
    near = [Fraction(1, 10**n) for n in (15, 40, 70)]
    assert problem(PLAIN, starts=(3, 5))._tried == [3, 5, 8, 0, *inner]
    assert problem(PLAIN, LATE)._tried == problem(LATE)._tried == [8, 0, *inner]
    assert (
        problem(PLAIN, POWER, starts=(3,))._tried
        == problem(POWER, LATE, starts=(3,))._tried
        == [3, *near, 8, 0, *inner]
    )
    assert problem(POWER, band=("1/2", 1, 17, 18))._tried == [17, 1, *range(2, 17)]


def test_a_slab_that_fails_names_the_first_point_and_part_at_which_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    pick = Random(5)
    names = ("excess.real", "excess.imag")
    for _ in range(30):
        own = problem(PLAIN, starts=(3,), names=names)
        failing = {(pick.choice(names), x) for x in pick.sample(own._tried, pick.randint(0, 3))}
        monkeypatch.setattr(Slab, "fails", lambda _, part, x, failing=failing: (part, x) in failing)
        ends = Ends(Fraction(0), Fraction(1))
        rows = [(x, part) for x in own._tried for part in names if (part, x) in failing]
        expected = {"points": [str(rows[0][0])], "part": rows[0][1].split(".")[1]} if rows else None
        assert own._slab(ends, holds=False) == expected
    for points in (None, [Fraction(0), Fraction(1, 3), Fraction(8)]):
        monkeypatch.setattr(Slab, "cells", lambda _, points=points: points)
        told = problem(PLAIN)._slab(Ends(Fraction(0), Fraction(1)), holds=True)
        assert told == (None if points is None else {"points": ["0", "1/3", "8"], "part": None})


@pytest.mark.parametrize("seed", range(4))
def test_cells_go_from_the_low_bound_of_the_band_to_the_high_one_and_are_cut_at_points_that_bind(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kept where they are narrow enough for their place."""
    pick = Random(seed)
    starts = [Fraction(pick.randint(-4, 40), 4) for _ in range(3)]
    own = Slab(problem(PLAIN, band=(0, "1/8", 8, 9), starts=starts), Ends(None, None), [])
    least = Fraction(1, pick.choice([1, 2, 4]))
    monkeypatch.setattr(Slab, "_is_kept", lambda _, a, b: b - a <= least)
    found = own.cells()
    assert found is not None
    assert [found[0], found[-1]] == [0, 9]
    assert all(0 < b - a <= least for a, b in pairwise(found))
    assert {x for x in starts if 0 < x < 9} <= set(found)
    pairs = list(pairwise(sorted({Fraction(0), Fraction(9), *(x for x in starts if 0 < x < 9)})))
    for a, b in pairs:
        inner = [x for x in found if a <= x <= b]
        count = len(inner) - 1
        assert count <= 2 * max(Fraction(1), (b - a) / least)
    monkeypatch.setattr(Slab, "_is_kept", lambda _, a, b: b - a <= Fraction(1, 10))
    assert own.cells() is None  # ninety and more are too many


@pytest.mark.parametrize("most", [50, 51])
def test_a_slab_has_fifty_cells_at_most(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each cut takes a point more: of so many points so many cells less one."""
    starts = [Fraction(n, 8) for n in range(1, most - 1)]
    whole = problem(PLAIN, starts=starts)
    monkeypatch.setattr(Slab, "_is_kept", lambda _, a, b: b - a <= 8)
    found = Slab(whole, Ends(None, None), []).cells()
    assert found is not None
    assert len(found) == most
    monkeypatch.setattr(Slab, "_is_kept", lambda _, a, b: b - a < 8 - Fraction(most - 2, 8))
    cut = Slab(whole, Ends(None, None), []).cells()
    assert (cut is None) is (most >= slabs._MOST_CELLS)


def test_a_product_has_the_sign_of_its_number_and_of_odd_powers() -> None:
    """2 + q and q - 1 from 1 to 3: below the line, or where it must be firm, none may vanish at an end that belongs."""
    up, down = Factor(((2, 1),), 1), Factor(((-1, 1),), 1)
    both_ways = (True, False)
    for number, n, m, firm, held in product(("-3/2", "0", "5"), (-2, -1, 1, 2), (-1, 1, 2), both_ways, both_ways):
        ends = Ends(Fraction(1), Fraction(3), held, True)  # noqa: FBT003
        rows = ends.slices([up, down])
        own = Slab(problem(up, down), ends, rows)
        told = {"number": number, "powers": [[0, n], [1, m]]}
        sign = own._sign(told, Fraction(1), Fraction(2), firm=firm)
        vanishes = held and (firm or m < 0)
        assert sign == (None if vanishes else {"-3/2": -1, "0": 0, "5": 1}[number])
    both = Ends(Fraction(-1), Fraction(0)).slices([up, down])
    own = Slab(problem(up, down), Ends(Fraction(-1), Fraction(0)), both)
    for m, sign in ((1, -1), (2, 1), (3, -1), (-1, -1), (-2, 1)):
        assert own._sign({"number": "1", "powers": [[0, 1], [1, m]]}, Fraction(0), Fraction(1), firm=False) == sign
    assert own._sign({"number": "1", "powers": []}, Fraction(0), Fraction(1), firm=True) == 1


def test_what_must_not_be_positive_is_kept_where_no_part_is_and_fails_where_one_is() -> None:
    up, down = Factor(((2, 1),), 1), Factor(((-9, 1),), 1)
    ends = Ends(Fraction(0), Fraction(3))
    rows = ends.slices([up, down])
    told: dict[str, Any] = {"1": {"number": "1", "powers": [[0, 1]]}, "-1": {"number": "1", "powers": [[1, 1]]}}
    told["0"] = {"number": "0", "powers": []}
    for names in (("1",), ("-1",), ("0",), ("1", "-1"), ("-1", "1"), ("-1", "0")):
        own = Slab(Problem([up, down], {x: told[x] for x in names}, problem().band, []), ends, rows)
        assert own._is_kept(Fraction(0), Fraction(1)) is ("1" not in names)
        assert [own.fails(x, Fraction(1)) for x in names] == [x == "1" for x in names]
    for low, high in ((None, Fraction(3)), (Fraction(4), None), (None, None), (Fraction(4), Fraction(9, 2))):
        pair = (-1, 0) if low is None else (4, 1), (1, 0) if high is None else high.as_integer_ratio()
        assert [sliced(up, *pair)] == Ends(low, high).slices([up])
