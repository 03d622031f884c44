"""What is proven of a map all over its plane: rectangles, held against closed forms and against exact verdicts at points."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from schemas import faults
from sympy import Integer
from test_slices import PLANE, RANGES, lag, least

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.programs.taylormodels import variable
from haptisym.verbs.require.plane import _FINEST_HELD, Rectangles, _Search, common, rectangles
from haptisym.verbs.require.proven import Proof, _Between, _unbounded

MAPS: dict[str, tuple[list[str], list[tuple[Any, Any]]]] = {
    "fu2019": (["omega_n", "zeta"], [(60, 200), ("0.1", 1)]),
    "virtual-wall": (["environment.b", "environment.k"], [(0, 40), (10, 4000)]),
    "delayed-spring": (["tau", "environment.k"], [("1 ms", "60 ms"), (10, 1000)]),
}


def proof_of(scene: hs.Scene | str, paths: list[str], ranges: list[tuple[Any, Any]], **asked: Any) -> Proof:
    [found] = hs.design_map(scene, paths, ranges, slices=3, uniform=True, **asked).proofs
    return found


def test_rectangles_lie_on_one_side_of_the_boundary_and_leave_little_open() -> None:
    found = proof_of(lag(), PLANE, RANGES).rectangles
    assert (found.kept[:, 1, 0] >= least(found.kept[:, 0, 0])).all()  # the boundary goes down beyond 15 rad/s
    assert (found.broken[:, 1, 1] <= least(found.broken[:, 0, 1])).all()
    assert found.share_left < 0.01
    area = sum((x[..., 1] - x[..., 0]).prod(-1).sum() for x in found.parts)
    assert area == pytest.approx(280 * 0.59, rel=1e-12)


@pytest.mark.parametrize("slices", [2, 3, 8])
def test_the_bound_holds_what_lines_are_off_by_however_few_there_are(slices: int) -> None:
    found = hs.design_map(lag(), PLANE, RANGES, slices=slices, uniform=True)
    [bounds] = found.bounds.values()
    for (a, b), bound in zip(pairwise(found.slices), bounds, strict=True):
        at = np.linspace(a.place, b.place, 201)
        off = np.abs(np.interp(at, [a.place, b.place], least(np.array([a.place, b.place]))) - least(at)).max()
        assert bound is not None
        assert off <= bound <= off + 0.03 * 0.59


def plane_of(name: str) -> Rectangles:
    if name not in PLANES:
        paths, ranges = MAPS[name]
        scene = hs.load_scene(name)
        one, other = scene.knobs.chosen(paths)
        a, b = ((x.number(low), x.number(high)) for x, (low, high) in zip((one, other), ranges, strict=True))
        found = rectangles(scene, (one, other), (a, b), noticed(scene.threshold))
        assert found is not None
        PLANES[name] = found
    return PLANES[name]


PLANES: dict[str, Rectangles] = {}


def is_as_said(name: str, number: float, shares: tuple[float, float], *, kept: bool) -> bool:
    """Whether at a point of a rectangle the exact crossings, of which at omega = 0 there are none, say the same."""
    cells = plane_of(name).kept if kept else plane_of(name).broken
    cell = cells[int(number * (len(cells) - 1))]
    values = cell[:, 0] + (cell[:, 1] - cell[:, 0]) * shares
    scene = hs.load_scene(name).with_values(dict(zip(MAPS[name][0], map(float, values), strict=True)))
    return (not hs.evaluate(scene).crossings) == kept


UNIT = st.integers(0, 997).map(lambda n: n / 997)


@pytest.mark.slow
@pytest.mark.parametrize("name", MAPS)
@given(number=UNIT, shares=st.tuples(UNIT, UNIT), side=st.sampled_from(["kept", "broken"]))
def test_points_of_rectangles_are_as_they_are_said_to_be(
    name: str, number: float, shares: tuple[float, float], side: str
) -> None:
    assert is_as_said(name, number, shares, kept=side == "kept")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fu2019", "delayed-spring"])
def test_some_points_of_rectangles_are_as_they_are_said_to_be(name: str) -> None:
    for number, *shares, side in np.random.default_rng(19).random((12, 4)):
        assert is_as_said(name, number, (shares[0], shares[1]), kept=bool(side < 0.5))


@pytest.mark.slow
def test_what_stays_open_at_an_end_of_the_range_is_as_near_as_that_end() -> None:
    """A wall's lowest stiffness is undecided on a strip; the boundary far above it is no further off for that."""
    found = hs.design_map("virtual-wall", MAPS["virtual-wall"][0], [(16, 24), (10, 4000)], slices=3, uniform=True)
    [bounds] = found.bounds.values()
    assert all(x is not None and x < 0.01 * 3990 for x in bounds)


@pytest.mark.slow
def test_further_thresholds_are_proven_too() -> None:
    found = hs.design_map(lag(), ["omega_c", "k"], [(20, 300), (10, 1000)], slices=3, jnd=["0.2", "0.3"])
    assert [(x.set, x.jnd and float(x.jnd)) for x in found.proofs] == [(0, None), (1, 0.2), (2, 0.3)]
    for x, c in zip(found.proofs, (0.1, 0.2, 0.3), strict=True):
        edge = 15 / c * (1 + np.sqrt(1 - 4 * c**2)) / 2  # W omega_c/(W^2 + omega_c^2) = c
        assert (x.rectangles.kept[:, 0, 0] >= edge).all()
        assert (x.rectangles.broken[:, 0, 1] <= edge).all()


@pytest.mark.slow
def test_what_is_stable_is_proven_between_slices_too() -> None:
    """Against exact slices, which are found by another way."""
    paths, ranges = MAPS["delayed-spring"]
    that = ["transparent", "stable"]
    found = hs.design_map("delayed-spring", paths, ranges, that=that, hand="postural-arm", slices=5)
    [_, stable] = found.proofs
    assert [(x.of, x.set) for x in found.proofs] == [("transparent", 1), ("stable", 2)]
    assert stable.rectangles.share_left < 0.01
    for x in hs.design_map(
        "delayed-spring", paths, ranges, that=["stable"], hand="postural-arm", slices=9, uniform=True
    ).slices:
        [span] = x.requirement.feasible
        assert span.high.value is not None
        at, end = float(x.at), float(span.high.value)
        for cells, side in ((stable.rectangles.kept, 1), (stable.rectangles.broken, -1)):
            own = cells[(cells[:, 0, 0] <= at) & (cells[:, 0, 1] >= at)]
            assert len(own) or side < 0
            assert (side * (end - own[:, 1, (1 + side) // 2]) >= 0).all()
    rows = found.to_dict()["proven"]
    assert [x["of"] for x in rows] == ["transparent", "stable"]
    assert faults(found.to_dict()) == []
    assert "what is stable in postural-arm, and what is not, but for" in " ".join(str(found).split())


def test_what_is_asked_together_is_what_both_planes_keep() -> None:
    one = Rectangles(np.array([[[0, 1], [0, 2.0]]]), np.array([[[1, 2], [0, 2.0]]]), np.empty((0, 2, 2)))
    other = Rectangles(
        np.array([[[0, 2], [0, 0.5]], [[0.5, 2], [0.5, 1]]]), np.array([[[0, 2], [1, 2.0]]]), np.empty((0, 2, 2))
    )
    cells = common([one, other])
    areas = (cells[..., 1] - cells[..., 0]).prod(-1)
    assert areas.sum() == pytest.approx(1 * 0.5 + 0.5 * 0.5)
    assert (cells[:, 0, 1] <= 1).all()
    assert (cells[:, 1, 1] <= 1).all()


@pytest.mark.parametrize("seed", range(6))
def test_how_far_points_of_rectangles_are_from_intervals_and_inside_of_them_is_bounded_and_of_points_exact(
    seed: int,
) -> None:
    """Intervals between lines that join two slices, some without bound; rectangles between these, and such as are points."""
    rng = np.random.default_rng(seed)
    ends = np.sort(rng.uniform(-5, 5, (rng.integers(1, 4) * 2, 2)), axis=0)
    lows, highs = ends[::2].copy(), ends[1::2].copy()
    if seed % 3 == 1:
        lows[0] = -np.inf
    elif seed % 3 == 2:
        highs[-1] = np.inf

    def off(shares: Any, values: Any) -> tuple[Any, Any]:
        """How far points are from the nearest interval, and how far inside of one from its nearer end."""
        low, high = (x[:, :1] * (1 - shares) + x[:, 1:] * shares for x in (lows, highs))
        return np.maximum(low - values, values - high).min(0), np.minimum(values - low, high - values).max(0)

    one, cells = rng.uniform(0, 1, (40, 1)), np.sort(rng.uniform(-6, 6, (40, 2)), axis=1)
    wide = np.sort(rng.uniform(0, 1, (40, 2)), axis=1)
    points = rng.uniform(0, 1, (2, 200))
    for i in range(40):
        box = _Between(wide[i : i + 1], cells[i : i + 1], lows, highs, (-np.inf, np.inf))
        shares = wide[i, 0] + points[0] * (wide[i, 1] - wide[i, 0])
        values = cells[i, 0] + points[1] * (cells[i, 1] - cells[i, 0])
        away, inside = off(shares, values)
        assert box.distance >= away.max() - 1e-12
        assert box.depth >= inside.max() - 1e-12
        point = _Between(one[[i]][:, [0, 0]], cells[[i]][:, [0, 0]], lows, highs, (-np.inf, np.inf))
        away, inside = off(one[i], cells[i, :1])
        assert point.distance == pytest.approx(max(away[0], 0), abs=1e-12)
        assert point.depth == pytest.approx(max(inside[0], 0), abs=1e-12)
        height = cells[i, 1] - cells[i, 0]
        edge = _Between(wide[i : i + 1], cells[i : i + 1], lows, highs, (cells[i, 0], np.inf))
        assert (edge.distance, edge.depth) == (min(box.distance, height), min(box.depth, height))


@pytest.mark.parametrize("asked", [{"any_environment": True}, {"that": ["passive"]}])
def test_where_no_models_are_nothing_is_claimed_between_slices(asked: dict[str, Any]) -> None:
    found = hs.design_map("fu2019", *MAPS["fu2019"], slices=3, **asked)
    assert found.proofs == ()
    assert "proven" not in found.to_dict()


def test_the_page_and_the_document_say_what_is_proven() -> None:
    found = hs.design_map(lag(), PLANE, RANGES, slices=5)
    [row] = found.to_dict()["proven"]
    assert (row["of"], row["jnd"], len(row["between"])) == ("transparent", None, 4)
    assert row["bound"] == max(row["between"])
    said = " ".join(str(found).split())
    assert (
        "Proven for all values of both, between slices too: what is transparent, and what is not, but for 0.687 %"
        in said
    )
    assert "Where lines join slices, its boundary lies within" in said


@dataclass(frozen=True)
class Hill:
    """a s + b t + c x - d x^2 + e over shares: s, t of a plane, x of a band."""

    numbers: tuple[float, ...]
    is_zero: bool = False

    def model(self, cells: Any, slopes: int) -> Any:
        assert slopes == 0
        low, high = cells[..., 0], cells[..., 1]
        x, s, t = (
            variable((low[:, i] + high[:, i]) / 2, (high[:, i] - low[:, i]) / 2, np.abs(high[:, i]), i, 3, slopes=0)
            for i in range(3)
        )
        a, b, c, d, e = self.numbers
        return s.times(a) + t.times(b) + x.times(c) - (x * x).times(d) + x.number(e)

    def range(self, cells: Any) -> tuple[Any, Any]:
        """The least and the largest over rectangles of what is the largest of all x."""
        a, b, c, d, e = self.numbers
        top = max(c * x - d * x * x for x in (0.0, 1.0, *([c / (2 * d)] if 0 < c < 2 * d else [])))
        own = np.array([a, b]) * cells.swapaxes(-1, -2)
        return own.min(-2).sum(-1) + top + e, own.max(-2).sum(-1) + top + e


@pytest.mark.parametrize("seed", range(4))
def test_rectangles_are_kept_where_no_hill_rises_over_0_broken_where_one_does_and_fine_where_neither_is_shown(
    seed: int,
) -> None:
    """Hills over a band whose height two numbers move: of each rectangle the least and the largest height are known."""
    pick = Random(seed)
    hills = []
    for _ in range(1 + seed % 2):
        a, b, c = (pick.randint(-8, 8) / 4 for _ in range(3))
        hills.append(Hill((a, b, c, pick.randint(0, 8) / 2, pick.randint(-8, 4) / 8)))
    search = _Search(2.0**-6, 10**6, hills)
    search.go()
    kept, broken, left = (np.concatenate([np.empty((0, 2, 2)), *x]) for x in (search.kept, search.broken, search.left))
    least, most = (np.max([hill.range(x)[i] for hill in hills], 0) for i, x in ((0, broken), (1, kept)))
    assert (least > 0).all()
    assert (most < 1e-9).all()
    assert sum((x[..., 1] - x[..., 0]).prod(-1).sum() for x in (kept, broken, left)) == pytest.approx(1, rel=1e-12)
    assert (left[..., 1] - left[..., 0] <= 2.0**-6).all()
    sizes = np.concatenate([kept, broken, left])
    assert (sizes[..., 1] - sizes[..., 0] >= 2.0**-7).all()
    steep = np.abs([hill.numbers[:2] for hill in hills]).sum()
    height = np.max([hill.range(left)[1] for hill in hills], 0)
    depth = np.max([hill.range(left)[0] for hill in hills], 0)
    assert (height >= -steep * 2.0**-5).all()  # pieces of the band are no finer than what the numbers move
    assert (depth <= steep * 2.0**-5).all()
    few = _Search(2.0**-6, 500, hills)
    few.go()
    assert sum((x[..., 1] - x[..., 0]).prod(-1).sum() for y in (few.kept, few.broken, few.left) for x in y) == (
        pytest.approx(1, rel=1e-12)
    )
    assert few.looked <= search.looked


@pytest.mark.parametrize("side", [0, 1])
def test_what_no_hill_depends_on_is_not_cut(side: int) -> None:
    """Heights that one number alone moves: what is told has the width along the other that it had at first."""
    for numbers in ((1.0, 0.0, 0.0, 0.0, -0.3), (-2.0, 0.0, 1.0, 1.0, 0.9)):
        own = (*((numbers[1], numbers[0]) if side else numbers[:2]), *numbers[2:])
        search = _Search(2.0**-6, 10**6, [Hill(own)])
        search.go()
        told = np.concatenate([*search.kept, *search.broken])
        assert (told[:, 1 - side, 1] - told[:, 1 - side, 0] == 1 / 8).all()
        assert (told[:, side, 1] - told[:, side, 0] < 1 / 8).any()


def test_ends_at_an_end_of_the_range_on_both_slices_are_without_bound_there_whatever_their_sign() -> None:
    ends = np.array([[-5.0, -5.0 - 1e-12], [-5.0, -4.999], [3.0, -5.0], [0.0, 0.0]])
    assert _unbounded(ends, -5.0, -np.inf).tolist() == [[-np.inf, -np.inf], *ends[1:].tolist()]
    assert _unbounded(-ends, 5.0, np.inf).tolist() == [[np.inf, np.inf], *(-ends[1:]).tolist()]
    assert _unbounded(ends, 0.0, np.inf)[3].tolist() == [np.inf, np.inf]


def test_what_several_planes_keep_is_kept_in_each_wherever_their_ranges_begin() -> None:
    """By pixels, of three planes that are cut at other places each."""
    rng, size = np.random.default_rng(3), round(1 / _FINEST_HELD)
    none = np.empty((0, 2, 2))
    for _ in range(2):
        low, width = rng.uniform(-9, 9, (2, 1)), rng.uniform(1, 9, (2, 1))
        planes, every = [], np.ones((size, size), bool)
        for _ in range(3):
            a, b = ([0, *sorted(rng.choice(np.arange(1, size), 3, replace=False)), size] for _ in range(2))
            cells = [[a[i : i + 2], b[j : j + 2]] for i in range(4) for j in range(4)]
            kept = rng.random(len(cells)) < 0.7
            for (x, y), own in zip(cells, kept, strict=True):
                every[x[0] : x[1], y[0] : y[1]] &= own
            placed = low + width * np.array(cells) / size
            planes.append(Rectangles(placed[kept], none, placed[~kept]))
        found = (common(planes) - low) / width * size
        pixels, told = np.rint(found).astype(int), np.zeros((size, size), int)
        assert found == pytest.approx(pixels, abs=1e-9)
        for (i, j), (m, n) in pixels:
            told[i:j, m:n] += 1
        assert (told == every).all()


@pytest.mark.parametrize("edge", ["low", "high", None])
def test_between_two_slices_a_bent_set_differs_by_its_bend_whichever_end_of_the_range_it_reaches(
    edge: str | None,
) -> None:
    """From 0.1 (or from the range's end) to 0.3 + 0.4 x + 0.4 x (1 - x), and its mirror image, in a grid of rectangles."""

    def ends(x: float) -> tuple[float, float]:
        bent = 0.3 + 0.4 * x + 0.4 * x * (1 - x)
        return (1 - bent, 1.0) if edge == "high" else (0.0 if edge == "low" else 0.1, bent)

    def a_slice(x: float) -> Any:
        own = SimpleNamespace(low=SimpleNamespace(value=ends(x)[0]), high=SimpleNamespace(value=ends(x)[1]))
        return SimpleNamespace(place=x, sets=[SimpleNamespace(undecided=(), feasible=[own])])

    cells: dict[str, list[Any]] = {"kept": [], "broken": [], "left": []}
    grid = np.linspace(0, 1, 41).tolist()
    for (a, b), (c, d) in product(pairwise(grid), pairwise(grid)):
        rows = np.array([ends(x) for x in np.linspace(a, b, 20)])
        inside, outside = (
            c >= rows[:, 0].max() and d <= rows[:, 1].min(),
            d <= rows[:, 0].min() or c >= rows[:, 1].max(),
        )
        cells["kept" if inside else "broken" if outside else "left"].append([[a, b], [c, d]])
    plane = Rectangles(**{name: np.array(x) for name, x in cells.items()})
    proof = Proof("transparent", 0, None, plane, (Integer(0), Integer(1)))
    [bound] = proof.bounds([a_slice(0.0), a_slice(1.0)])
    assert bound is not None
    assert 0.1 <= bound <= 0.1 + 3 / 40
    assert proof.bounds(
        [a_slice(0.0), SimpleNamespace(place=1.0, sets=[SimpleNamespace(undecided=(), feasible=[])])]
    ) == (None,)
    for n in (0, 1):
        slices = [a_slice(0.0), a_slice(1.0)]
        slices[n].sets[0].undecided = ((None, None),)
        assert proof.bounds(slices) == (None,)
