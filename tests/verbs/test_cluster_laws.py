"""Where on a band a condition can bind, of parabolas and peaks of which all is known; and steps of the search, one by one."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product
from random import Random
from typing import Any

import flint
import numpy as np
import pytest
from flint import arb
from plainshapes import exact, q, rational, shape_of, strips_of
from sympy import Expr, Integer

import haptisym as hs
from haptisym.kernel.symbols import omega as w
from haptisym.verbs.require.clusters import Strips, _Box, _box, _clusters, _decided, _place, _unclear, places
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.places import CellVerdict, CriticalPlace, Strip
from haptisym.verbs.require.strips import Shape

TINY = Fraction(1, 1 << 20)
UNIT = (Integer(0), Integer(1))


@pytest.mark.parametrize("d", ["1/25"])
def test_late_by_a_microsecond_a_polygon_is_met_at_the_maximum_next_to_0_and_not_at_0(d: str) -> None:
    """x = t - w^2, y = d w beside x + y <= 1/2: largest at w = |d|/2; sampled densely beside the end that is told."""
    gain = hs.effects.series("1 + t + s^2 + d*s", parameters={"t": "1/10", "d": d})
    region = {"shape": "polygon", "corners": [["1/2", "0"], ["0", "1/2"], ["-300", "0"], ["0", "-1/2"]]}
    late = (gain, hs.effects.delay("1 us"))
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), late, (0, 5), region)
    [span] = hs.require(scene, "t", (-9, 9)).feasible
    assert span.high.value is not None
    grid, end = np.concatenate([np.linspace(0, 0.1, 4001), np.linspace(0.1, 5, 2001)]), float(span.high.value)
    for t, kept in ((end - 1e-7, True), (end + 1e-7, False)):
        z = (1 + t - grid**2 + 1j * float(Fraction(d)) * grid) * np.exp(-1e-6j * grid) - 1
        assert (np.max(z.real + np.abs(z.imag)) <= 0.5) is np.bool_(kept)
    [binding] = span.high.bindings
    assert binding.kind is Kind.TOUCH
    assert binding.omega is not None
    assert float(binding.omega) == pytest.approx(abs(float(Fraction(d))) / 2, rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_a_parabola_binds_at_its_top_or_at_the_end_of_the_band_that_is_next_to_it(seed: int) -> None:
    """a (q - v) - c (w - m)^2, m far outside, just outside, at an end, just inside and amid a band that begins at 0 or not."""
    pick = Random(seed)
    for low, where in product([Fraction(0), Fraction(1, 2)], range(-3, 4)):
        high = low + pick.choice([1, 4])
        m = {-3: low - 2, -2: low - Fraction(1, 100), -1: low, 0: (low + 2 * high) / 3, 1: high, 2: high + Fraction(1, 99),
             3: low + (high - low) / pick.choice([50, 200])}[where]  # fmt: skip
        a, c, v = pick.choice([1, -1, 3]), Fraction(pick.randint(1, 8), 2), Fraction(pick.randint(-8, 8), 4)
        nearest = min(max(m, low), high)
        end = v + c * (nearest - m) ** 2 / a
        kind = Kind.START if nearest == low else Kind.EDGE if nearest == high else Kind.TOUCH
        function = a * (q - rational(v)) - rational(c) * (w - rational(m)) ** 2
        for below, above in ((1, 1), (3, 1), (1, 3)):  # of the cell: the end in its middle, and to both sides of that
            with flint.ctx.workprec(128):
                condition = strips_of(end - below * TINY, end + above * TINY, function)
                found = places(condition, (rational(low), rational(high)))
                if a * (above - below) > 0 and found is CellVerdict.OPEN:
                    continue  # broken in the middle: it is cut
                if m in (low, high) and m:
                    continue  # level at an end: it stays open, or is told
                assert isinstance(found, list), (low, where, found)
                [place] = found
                assert (place.kind, condition.signs(place)) == (kind, (-1, 1) if a > 0 else (1, -1))
                assert condition.crossing(place).ball(100).contains(exact(end))


@pytest.mark.parametrize("i", [1, 5, 12, 23])
def test_a_cell_whose_middle_is_broken_at_a_sample_is_broken_or_cut(i: int) -> None:
    """Peaks so narrow that one of the samples alone sees them, at it and just beside it; of one function and of two."""
    at, steep = Fraction(i, 24), 10**6
    with flint.ctx.workprec(128):
        for beside in ([], [w + 1]):
            peak = q - steep * (w - rational(at)) ** 2
            for low, high, told in ((TINY, 2 * TINY, CellVerdict.BROKEN), (-TINY, 2 * TINY, CellVerdict.OPEN)):
                assert places(strips_of(low, high, *beside, peak), UNIT) is told
        shifted = q - steep * (w - rational(at + TINY)) ** 2  # at the sample steep 2^-40 is missing
        least = steep * TINY**2
        assert places(strips_of(least / 2, 2 * least, shifted), UNIT) is CellVerdict.BROKEN
        assert places(strips_of(-least, 4 * least, shifted), UNIT) is CellVerdict.OPEN


def test_what_is_broken_next_to_an_end_of_the_band_alone_is_seen_at_once() -> None:
    """As far from the low end as a thousandth of the band, and at the high end itself."""
    with flint.ctx.workprec(128):
        for low, high in ((Fraction(0), Fraction(1)), (Fraction(3), Fraction(7))):
            band = rational(low), rational(high)
            for f in (q - (w - low) * 1000 / (high - low) + 1, q + w - rational(high)):
                assert places(strips_of(TINY, 2 * TINY, f), band) is CellVerdict.BROKEN
                assert places(strips_of(TINY, 2 * TINY, w + 9, f), band) is CellVerdict.BROKEN
                assert places(strips_of(TINY, 2 * TINY, -w - 1, f), band) == []


# Steps of the search


def test_a_peak_at_the_middle_of_a_piece_that_no_sample_saw_breaks_it_or_leaves_it_open() -> None:
    half, steep = Fraction(1, 2), 10**6
    with flint.ctx.workprec(128):
        for shift, low, high, told in (
            (0, TINY, 2 * TINY, CellVerdict.BROKEN),
            (0, -TINY, 2 * TINY, CellVerdict.OPEN),
            (TINY, steep * TINY**2 / 2, 2 * steep * TINY**2, CellVerdict.BROKEN),
            (TINY, -steep * TINY**2, 4 * steep * TINY**2, CellVerdict.OPEN),
        ):
            peak = q - steep * (w - rational(half + shift)) ** 2
            assert _unclear(strips_of(Fraction(low), Fraction(high), peak), arb(0), arb(1)) is told


@pytest.mark.parametrize("seed", range(4))
def test_outside_of_what_is_unclear_a_condition_is_kept_and_inside_it_is_known_which_way_it_goes(seed: int) -> None:
    """q - c (w - m)^2, by itself or beside a line through 0 not far from m."""
    pick = Random(seed)
    for beside in (0, 1, -1):
        start = pick.choice([0, 5, 9])  # of the band
        m, c = start + Fraction(pick.randint(5, 60), 64), pick.randint(1, 9)
        zero = m + Fraction(pick.choice([-1, 1]) * pick.randint(8, 15), 99)
        functions = [q - c * (w - rational(m)) ** 2, *([beside * (w - rational(zero))] if beside else [])]
        low, high = Fraction(-3, 1000), Fraction(pick.choice([-1, 1]), 10**4)
        with flint.ctx.workprec(128):
            boxes = _unclear(strips_of(low, high, *functions), arb(start), arb(start + 1))
        assert isinstance(boxes, list)
        ends = [(Fraction(float(x.low)), Fraction(float(x.high))) for x in boxes]
        assert all(b <= c for (_, b), (c, _) in pairwise(ends))
        for x, (a, b) in zip(boxes, ends, strict=True):
            assert b - a < Fraction(1, 20)
            assert x.pieces == (0,)
            assert x.slope or x.bend < 0
            assert x.slope == (1 if b < m else -1 if m < a else 0)
        for n in range(1, 100):
            at = start + Fraction(n, 100)
            top = min([high - c * (at - m) ** 2, *([beside * (at - zero)] if beside else [])])
            assert top < 0 or any(a <= at <= b for a, b in ends)


@dataclass(frozen=True)
class Said:
    """A function of which all over a box as much is said: signs of value, slope and curvature, 0 for what is not known."""

    signs: tuple[int, int, int]

    def over(self, _: Any) -> list[Any]:
        return [{1: arb(2, 1), -1: arb(-2, 1), 0: arb(0, 1)}[x] for x in self.signs]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_box_is_kept_where_one_function_is_negative_and_named_by_those_that_may_decide(count: int) -> None:
    pick = Random(count)
    for _ in range(150):
        own = [
            Said((pick.choice([1, 0, 0, -1]), pick.choice([-1, 0, 1]), pick.choice([-1, 0, 1]))) for _ in range(count)
        ]
        box = _box(Strips(tuple(own)), arb(1), arb(2))  # type: ignore[arg-type]
        left = [i for i, x in enumerate(own) if x.signs[0] == 0 or (x.signs[0] > 0 and count == 1)]
        if any(x.signs[0] < 0 for x in own):
            assert box is None
            continue
        assert box is not None
        assert (box.low, box.high, box.pieces) == (arb(1), arb(2), tuple(left))
        if len(left) == 1:
            assert (box.slope, box.bend, box.slopes) == (*own[left[0]].signs[1:], ())
        else:
            slopes = tuple(own[i].signs[1] for i in left)
            opposite = slopes in ((1, -1), (-1, 1))
            assert (box.slope, box.bend, box.slopes) == (0, 0, slopes if opposite else ())


@pytest.mark.parametrize("seed", range(5))
def test_boxes_that_follow_each_other_are_one_cluster(seed: int) -> None:
    pick = Random(seed)
    marks = [n for n in range(12) if pick.random() < 0.6]
    found = _clusters([_Box(arb(n), arb(n + 1), 1, 0) for n in marks])
    assert [int(float(x.low)) for cluster in found for x in cluster] == marks
    assert all(a.high == b.low for cluster in found for a, b in pairwise(cluster))
    assert all(a[-1].high < b[0].low for a, b in pairwise(found))


def _parabola(c: Fraction, m: Fraction, top: int = 1) -> Shape:
    return shape_of(rational(c) - top * (w - rational(m)) ** 2)


@pytest.mark.parametrize("m", [Fraction(n, 16) for n in (-16, -1, 0, 1, 3, 4, 9, 15, 16, 17, 40)])
def test_of_a_parabola_over_boxes_the_place_is_told_as_far_as_slopes_and_curvatures_are_known(m: Fraction) -> None:
    """Pieces in quarters from 0 or from 1/4 on, up to 3/4 or 1, ends of the band or not; some of what is known is forgotten."""
    pick = Random(str(m))
    with flint.ctx.workprec(128):
        strip = Strip.of(_parabola(Fraction(1), m), arb(0), arb(0))
        for first, last, at_low, at_high in product([0, 1], [3, 4], [True, False], [True, False]):
            for _ in range(4):
                edges = [Fraction(n, 4) for n in range(first, last + 1)]
                slopes = [(1 if m > b else -1 if m < a else 0) * pick.choice([0, 1, 1]) for a, b in pairwise(edges)]
                bends = [-pick.choice([0, 1, 1, 1, 1]) for _ in slopes]
                boxes = [
                    _Box(exact(a), exact(b), s, x) for (a, b), s, x in zip(pairwise(edges), slopes, bends, strict=True)
                ]
                rows = [*zip(pairwise(edges), slopes, bends, strict=True)]
                low, high = (
                    exact(x if is_end else y) for x, y, is_end in ((edges[0], -9, at_low), (edges[-1], 9, at_high))
                )
                band = Integer(-5), Integer(5)
                found = _place(strip, boxes, low, high, band)
                if all(s > 0 or (x and m > b) for (_, b), s, x in rows):
                    wanted: Any = (Kind.EDGE, band[1]) if at_high else CellVerdict.KEPT
                elif all(s < 0 or (x and (m < a or m == a == 0)) for (a, _), s, x in rows):
                    wanted = (Kind.START, band[0]) if at_low else CellVerdict.KEPT
                else:
                    wanted = (Kind.TOUCH, None) if all(bends) and edges[0] < m < edges[-1] else CellVerdict.OPEN
                assert ((found.kind, found.omega) if isinstance(found, CriticalPlace) else found) == wanted
                if isinstance(found, CriticalPlace):
                    assert (found.low, found.high) == (exact(edges[0]), exact(edges[-1]))


def test_two_functions_decide_at_a_corner_where_one_rises_and_the_other_falls_inside_of_the_band() -> None:
    low, high = arb(0), arb(8)
    for a, b, slopes in product([0, 1], [7, 8], product([-1, 0, 1], repeat=2)):
        own = [Said((0, x, 0)) for x in (1, *slopes)]  # the first one decides nothing
        boxes = [_Box(arb(a), arb(4), 0, 0, (1, 2)), _Box(arb(4), arb(b), 0, 0, (2,))]
        found = _decided(Strips(tuple(own)), boxes, low, high, UNIT)  # type: ignore[arg-type]
        if a == 0 or b == 8 or sorted(slopes) != [-1, 1]:
            assert found is CellVerdict.OPEN
        else:
            assert isinstance(found, CriticalPlace)
            assert (found.kind, found.low, found.high, found.omega) == (Kind.TOUCH, a, b, None)
            assert (found.piece, found.other) == ((1, 2) if slopes[0] > 0 else (2, 1))
    three = [Said((0, x, 0)) for x in (1, -1, 1)]
    boxes = [_Box(arb(1), arb(4), 0, 0, (0, 1)), _Box(arb(4), arb(5), 0, 0, (2,))]
    assert _decided(Strips(tuple(three)), boxes, low, high, UNIT) is CellVerdict.OPEN  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(4))
def test_from_a_suspect_newtons_steps_go_to_the_maximum_beside_the_best_of_them(seed: int) -> None:
    pick = Random(seed)
    m, c = Fraction(pick.randint(20, 44), 64), pick.randint(1, 5)
    suspects = [exact(Fraction(n, 64)) for n in sorted(pick.sample(range(10, 54), 3))]

    def steps(
        f: Expr, low: Fraction = Fraction(0), high: Fraction = Fraction(1), *, beyond: bool = False
    ) -> list[float]:
        with flint.ctx.workprec(128):
            shape = shape_of(f)
            one = Strips.beyond([shape], arb(0, 1)) if beyond else Strips.of([shape], exact(0), exact(2))
            return [float(x) for x in one.risen(suspects, exact(low), exact(high))]

    hill = 1 - c * (w - rational(m)) ** 2
    for beyond in (False, True):
        assert steps(hill, beyond=beyond) == pytest.approx([float(m)] * 3, abs=1e-15)
    assert steps(hill, high=m) == steps(hill, low=m) == []  # it is not between
    assert steps(-hill) == steps(w) == []  # no maximum there
    cubic = steps(hill + (w - rational(m)) ** 3)
    assert len(cubic) == 3
    assert abs(cubic[2] - float(m)) < abs(cubic[0] - float(m)) < 0.5
    near = [x for x in suspects if abs(float(x) - 0.25) < 0.14]
    humps = -((w - rational(Fraction(1, 4))) ** 2) * (w - rational(Fraction(3, 4))) ** 2 * 10 - w / 10**6
    best = min(suspects, key=lambda x: abs((float(x) - 0.25) * (float(x) - 0.75)))
    for x in steps(humps)[2:]:
        assert abs(x - (0.25 if float(best) < 0.5 else 0.75)) < 0.05 or not near
    with flint.ctx.workprec(128):
        assert [*strips_of(Fraction(0), Fraction(2), hill, w).risen(suspects, arb(0), arb(1))] == []
