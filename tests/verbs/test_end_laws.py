"""Ends of enclosures that no corner reaches, pieces behind rectangles, single sets of values: closed forms, plain loops."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt
from random import Random
from typing import Any

import numpy as np
import pytest
from sympy import Rational

import haptisym as hs
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.tolerances.box import box_of
from haptisym.verbs.tolerances.quantiles import quantiles
from haptisym.verbs.tolerances.rectangles import Pieces, RectangleSearch
from haptisym.verbs.tolerances.single import One, drawn, in_time, one

SPRING = hs.environments.mass_spring_damper(k=100)


def text(x: list[Fraction]) -> Any:
    return [str(y) for y in x] if x[0] != x[1] else str(x[0])


def number(x: Any) -> Any:
    return None if x is None else ExactNumber(Rational(x))


@pytest.mark.parametrize("seed", range(3))
def test_an_end_inside_the_box_is_a_bound_hardly_beyond_it_and_one_at_a_corner_is_exact(seed: int) -> None:
    """r_i = omega T (1 + p^2) = c at omega = c/(T (1 + p^2)): highest at p = 0 if it is in the box, lowest at the larger |p|."""
    pick = Random(seed)
    T = [Fraction(pick.randint(9, 10), 1000), Fraction(pick.randint(11, 12), 1000)]
    p = [Fraction(pick.randint(-12, 3), 10), Fraction(pick.randint(4, 12), 10)]
    c = [Fraction(1, 10), Fraction(pick.choice([10, 11]), 100)]
    effect = hs.effects.series("1 + s*T*(1 + p^2)", parameters={"T": text(T), "p": text(p)})
    low = pick.choice([0, 1])
    found = hs.tolerances(hs.Scene(SPRING, (effect,), (low, 20), hs.Threshold.of(text(c))), samples=0)
    [x] = found.enclosures
    least, most = min(y**2 for y in (p if p[0] > 0 else [Fraction(0)])), max(y**2 for y in p)
    true = [float(c[0] / (T[1] * (1 + most))), float(c[1] / (T[0] * (1 + least)))]
    assert float(x.low) <= true[0] * (1 + 1e-13)
    assert float(x.high) >= true[1] * (1 - 1e-13)
    assert [float(x.low), float(x.high)] == pytest.approx(true, rel=2e-3)
    assert x.count == 1
    assert x.monotonic["T"] == -1
    assert x.monotonic.get("c", 1) == 1
    if p[0] > 0:
        assert x.monotonic["p"] == -1
        assert [float(x.low), float(x.high)] == pytest.approx(true, rel=1e-13)
        assert x.at_high is not None
        assert x.at_high["p"] == Rational(p[0].numerator, p[0].denominator)
    elif p[0] < 0:
        assert x.monotonic["p"] == 0
        assert x.at_high is None
    assert found.verdict.value == "none"


@pytest.mark.parametrize("seed", range(2))
def test_crossings_that_merge_within_the_box_are_one_enclosure_that_holds_both(seed: int) -> None:
    """r_r = |b - a x|, x = omega^2, a b and c about which b - c goes through 0: the lower crossing comes from omega = 0."""
    pick = Random(seed)
    a, c = Fraction(pick.randint(8, 12), 100), Fraction(2, 10)
    b = [c - Fraction(pick.randint(1, 5), 100), c + Fraction(pick.randint(1, 5), 100)]
    effect = hs.effects.series(f"1 + b + {a}*s^2", parameters={"b": [str(x) for x in b]})
    found = hs.tolerances(hs.Scene(SPRING, (effect,), (0, 4), hs.Threshold(str(c), str(c))), samples=0)
    first, second = found.enclosures
    assert (first.count, second.count) == (None, 1)
    assert float(first.low) == 0
    assert float(first.high) == pytest.approx(sqrt((b[1] - c) / a), rel=1.01e-3)
    assert float(first.high) >= sqrt((b[1] - c) / a) * (1 - 1e-13)
    assert [float(second.low), float(second.high)] == pytest.approx([sqrt((x + c) / a) for x in b], rel=1e-13)
    assert (found.bandwidth, found.verdict.value) == (None, "none")


# --- pieces and rectangles --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_pieces_stand_behind_their_rectangles_however_these_are_cut(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first = np.sort(rng.uniform(0, 1, (3, 2, 2)), -1)
    plane = np.sort(rng.uniform(0, 1, (4, 2, 2)), -1)
    every = Pieces.all(4, first)
    assert every.owner.tolist() == [n for n in range(4) for _ in range(3)]
    assert (every.rest == np.tile(first, (4, 1, 1))).all()
    cells = every.cells(plane)
    for i, (owner, rest) in enumerate(zip(every.owner, every.rest, strict=True)):
        assert cells[i].tolist() == [rest[0].tolist(), *plane[owner].tolist(), *rest[1:].tolist()]
    mask = rng.random(12) < 0.5
    some = every.where(mask)
    assert some.owner.tolist() == every.owner[mask].tolist()
    assert (some.rest == every.rest[mask]).all()
    side = rng.integers(0, 2, 12)
    cut = every.cut(mask, side)
    assert len(cut.owner) == len(cut.rest) == 12 + mask.sum()
    rows = sorted((int(o), r.tolist()) for o, r in zip(cut.owner, cut.rest, strict=True))
    expected = [(int(every.owner[i]), every.rest[i].tolist()) for i in range(12) if not mask[i]]
    for i in np.flatnonzero(mask).tolist():
        for half in range(2):
            rest = every.rest[i].copy()
            rest[side[i], 1 - half] = every.rest[i, side[i]].mean()
            expected.append((int(every.owner[i]), rest.tolist()))
    assert rows == sorted(expected)
    which = np.array([3, 1])
    halved = every.within(which, 4)
    kept = [i for i in range(12) if every.owner[i] in which]
    places = [which.tolist().index(every.owner[i]) for i in kept]
    assert halved.owner.tolist() == [*places, *(x + 2 for x in places)]
    assert (halved.rest == np.tile(every.rest[kept], (2, 1, 1))).all()


class Disc(RectangleSearch):
    """Rectangles on either side of a circle about the origin, or across it; ``limit`` : rounds before the time is over."""

    limit = 10**6
    rounds = 0

    def _round(self, plane: Any, pieces: Any) -> Any:
        type(self).rounds += 1
        if self.rounds > self.limit:
            raise LimitError("over")
        self.before = self.looked
        self.looked += len(pieces[0].owner)
        least, most = ((plane[..., i] ** 2).sum(-1) for i in (0, 1))
        doubtful = (least < 0.5) & (most > 0.5)
        self.done = [*getattr(self, "done", []), plane[~doubtful]]
        changes = plane[..., 1] ** 2 - plane[..., 0] ** 2
        return self._cut(plane, doubtful, changes, [x.where(doubtful[x.owner]) for x in pieces])


@pytest.mark.parametrize(("most", "limit"), [(10**6, 10**6), (200, 10**6), (10**6, 2)])
def test_rectangles_are_cut_until_they_are_told_or_small_or_too_much_was_looked_at(most: int, limit: int) -> None:
    Disc.limit, Disc.rounds = limit, 0
    search: Any = Disc(2.0**-6, most)
    search._search([np.array([[[0.0, 1.0]]]), np.array([[[0.0, 0.5]], [[0.5, 1.0]]])])
    told, left = np.concatenate(search.done), np.concatenate(search.left)
    areas = [(x[..., 1] - x[..., 0]).prod(-1).sum() for x in (told, left)]
    assert sum(areas) == 1
    if limit == 10**6:
        assert ((left[..., 0] ** 2).sum(-1) < 0.5).all()
        assert ((left[..., 1] ** 2).sum(-1) > 0.5).all()
    if most == limit == 10**6:
        assert (left[..., 1] - left[..., 0] == 2.0**-6).all()
        assert areas[1] < 0.05
    else:
        assert areas[1] > 0.02
        assert search.rounds == 3 if limit == 2 else search.before <= most < search.looked


# --- single sets of values --------------------------------------------------------------------------------------------


def test_one_set_of_values_has_the_crossings_bandwidth_and_verdict_of_its_scene() -> None:
    """Behind a lag: r_i = t/(1 + t^2) and r_r = t^2/(1 + t^2), t = omega/omega_c; c = 1/10."""
    t = 5 - sqrt(24), 1 / 3, 5 + sqrt(24)
    box = box_of(hs.Scene(SPRING, (hs.effects.first_order_lag(["1", "40"]),), (0, 12)))
    for omega_c in (1, 2, 20, 40):
        found = one(box, {"omega_c": Rational(omega_c)})
        places = [x * omega_c for x in t]
        assert [float(x) for x in found.crossings["imag"]] == pytest.approx([x for x in places[::2] if x < 12])
        assert [float(x) for x in found.crossings["real"]] == pytest.approx([x for x in places[1:2] if x < 12])
        assert found.bandwidth is not None
        assert float(found.bandwidth) == pytest.approx(min(places[0], 12))
        assert found.transparent is False
        assert found.first is not None
        assert float(found.first) == pytest.approx(places[0])
        assert found.values == {"omega_c": omega_c}
    assert one(box, {}).values == {"omega_c": box.scene.knobs["omega_c"].value}
    wide = one(box_of(hs.Scene(SPRING, (hs.effects.first_order_lag(["200", "400"]),), (0, 12))), {})
    assert (wide.transparent, wide.first, wide.bandwidth and float(wide.bandwidth)) == (True, None, 12)


def test_sets_are_drawn_evenly_from_end_to_end_the_same_for_the_same_seed() -> None:
    box = box_of(hs.Scene(SPRING, (hs.effects.first_order_lag(["36", "44"]),), (0, 1)))
    first, again, other = (drawn(box, 12, seed) for seed in (1, 1, 2))
    values = [[float(x.values["omega_c"]) for x in row] for row in (first, again, other)]
    assert values[0] == values[1] != values[2]
    assert all(36 <= x <= 44 for row in values for x in row)
    assert min(values[0] + values[2]) < 38
    assert max(values[0] + values[2]) > 42
    assert drawn(box, 0, 1) == ()
    assert len({round(x, 9) for x in values[0]}) == 12

    def late() -> Any:
        yield 1
        yield 2
        raise LimitError("over")

    assert list(in_time(late())) == [1, 2]


@pytest.mark.parametrize("seed", range(3))
def test_a_quantile_is_the_least_value_that_enough_of_all_do_not_exceed(seed: int) -> None:
    pick = Random(seed)
    for count in (1, 2, 19, 20, 21, 40):
        rows = [
            (
                pick.choice([None, pick.randint(1, 9)]),
                pick.choice([None, pick.randint(1, 9)]),
                pick.choice([True, False, None]),
            )
            for _ in range(count)
        ]
        ones = [One({}, {"real": () if a is None else (number(a),)}, number(b), kept) for a, b, kept in rows]
        found = quantiles(ones)
        assert found.transparent == sum(kept is True for *_, kept in rows)
        for given, told, absent in ((0, found.first, np.inf), (1, found.bandwidth, -np.inf)):
            values = [absent if row[given] is None else float(row[given]) for row in rows]  # type: ignore[arg-type]
            assert set(told) == {5, 50, 95}
            for p, x in told.items():
                least = min(y for y in values if 100 * sum(z <= y for z in values) >= p * count)
                assert x == (None if np.isinf(least) else least)
