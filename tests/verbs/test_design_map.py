"""Maps of two parameters: their slices, what lies between them, what is proven all over the plane, and the lines of classical bounds."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from random import Random
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure
from schemas import faults
from sympy import Rational

import haptisym as hs
from haptisym.cli import app
from haptisym.figures import requirement as requirement_charts
from haptisym.figures.layers import draw
from haptisym.judge.bindings import Kind
from haptisym.judge.crossings import noticed
from haptisym.kernel.budget import timed_by
from haptisym.verbs.require.classical import Encoder, lines
from haptisym.verbs.require.designmap import Asked, Rectangles, Slice, common, held_rectangles, rectangles
from haptisym.verbs.stability.plane import plane

E, F = hs.environments, hs.effects
PLANE, RANGES = ["omega_c", "evaluation.jnd"], [(20, 300), ("0.01", "0.6")]
WALL = ["environment.b", "environment.k"]

LAG = hs.Scene(E.mass_spring_damper(k=100), (F.first_order_lag(50),), (0, 15))
"""The imaginary part is W omega_c/(W^2 + omega_c^2) at the end W = 15 of the band, and the real part is less."""

HELD = hs.Scene(
    E.kelvin_voigt(300, 1), (F.first_order_lag(100), F.shunt(m="0.04 kg", b="0.8 N*s/m")), (0, 10),
    hands=(hs.Hand("own", m="0.1 kg", b="0.2 N*s/m"),),
)  # fmt: skip
"""With w for omega_c: stable iff (1 + 0.14 w)(1 + B) > 0.14 K, by Routh; the ratio at 10 rad/s is at most 10/w."""


def least(omega_c: Any) -> Any:
    """The jnd with which a lag is not noticed."""
    return 15 * omega_c / (225 + omega_c**2)


@cache
def lag_map(slices: int = 41, within: str | None = None, *, uniform: bool = False) -> hs.DesignMap:
    return hs.design_map(LAG, PLANE, RANGES, slices=slices, within=within, uniform=uniform)


def off(f: Any, a: float, b: float) -> float:
    """How far a function is from the line between two of its points."""
    at = np.linspace(a, b, 301)
    return float(np.abs(np.interp(at, [a, b], [f(np.array(a)), f(np.array(b))]) - f(at)).max())


def spans(r: Any) -> list[tuple[float, float]]:
    return [(float(x.low), float(x.high)) for x in r.feasible]


# --- slices ---------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("within", [None, *(pytest.param(x, marks=pytest.mark.slow) for x in ("0.02", "0.002"))])
def test_slices_are_exact_go_where_the_boundary_bends_and_lines_are_off_by_what_is_estimated(
    within: str | None,
) -> None:
    found = lag_map(within=within)
    for x in found.slices:
        assert spans(x.requirement) == [(pytest.approx(least(x.place), rel=1e-14), 0.6)]
    steps = [x.high - x.low for x in found.gaps]
    assert steps[0] < steps[-1]  # it bends below 60 rad/s
    assert len(found.slices) < 41
    assert [(x.low, x.high) for x in found.gaps] == [(a.place, b.place) for a, b in pairwise(found.slices)]
    share = 0.005 if within is None else float(within)
    for gap in found.gaps:
        assert gap.deviation is not None
        assert off(least, gap.low, gap.high) <= 1.1 * gap.deviation <= 1.1 * share * 0.59
    assert (found.deviation, found.is_coarse) == (max(x.deviation for x in found.gaps if x.deviation), False)


def test_even_slices_are_as_many_as_are_asked_for_and_few_are_said_to_be_too_few() -> None:
    assert [x.at for x in lag_map(3, uniform=True).slices] == [20, 160, 300]
    coarse = lag_map(5)
    assert (len(coarse.slices), coarse.is_coarse, coarse.height) == (5, True, pytest.approx(0.59))
    assert coarse.deviation is not None
    for share in (0.5, 0.99, 1.01, 3):
        within = Rational(coarse.deviation / coarse.height * share)
        assert replace(coarse, within=within).is_coarse is (share < 1)


def test_slices_that_differ_in_kind_are_near_each_other_and_nothing_is_said_between() -> None:
    """With c = 0.1 nothing will do below some omega_c, and from there on every k."""
    found = hs.design_map(LAG, ["omega_c", "environment.k"], [(20, 300), (10, 1000)])
    [gap] = [x for x in found.gaps if x.deviation is None]
    edge = 15 * (5 + np.sqrt(24))  # W omega_c/(W^2 + omega_c^2) = 1/10
    assert gap.low < edge < gap.high <= gap.low + 280 * 0.005
    assert {len(x.requirement.feasible) for x in found.slices if x.place > edge} == {1}


def test_the_plane_goes_as_far_as_the_rules_of_both_parameters_allow() -> None:
    found = hs.design_map(LAG, PLANE, [(-60, 60), (-1, "0.6")], slices=3, uniform=True)
    assert [x.at for x in found.slices] == [60]
    [proof] = found.proofs
    cells = np.concatenate(proof.rectangles.parts)
    assert (cells[:, :, 0].min(0).tolist(), cells[:, :, 1].max(0)) == ([0, 0], pytest.approx([60, 0.6]))


@pytest.mark.parametrize("limit", [30, 200])
def test_what_time_did_not_last_for_is_open_and_the_rest_true(limit: int) -> None:
    """A clock counts how often it is read."""
    with timed_by(iter(range(10**9)).__next__):
        found = hs.design_map(LAG, PLANE, RANGES, slices=3, uniform=True, limit=limit)
    assert len(found.slices) == 3
    assert not found.certified
    for x in found.slices:
        assert x.requirement.undecided or spans(x.requirement) == [(pytest.approx(least(x.place)), 0.6)]


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"slices": 1}, "slices: 1"), ({"slices": 2.5}, "slices: 2.5"), ({"within": 0}, "within: 0"), ({"within": "3 N"}, "3 N"),
        ({"ranges": RANGES[:1]}, "ranges"), ({"ranges": [*RANGES, (1, 2)]}, "ranges"), ({"ranges": [(1, 1), (0, 1)]}, "omega_c"),
        ({"ranges": [(9, 2), (0, 1)]}, "omega_c"), ({"ranges": [(-3, -1), (0, 1)]}, "omega_c"), ({"jnd": ["0.2"]}, "free"),
        ({"that": "passive", "jnd": ["0.2"]}, "transparent"), ({"jnd": ["0.2 N"], "paths": ["omega_c", "k"]}, "0.2 N"),
        ({"jnd": ["-0.1"], "paths": ["omega_c", "k"]}, "-0.1"), ({"friction": "0.05 N"}, "resolution"),
        ({"friction": "0.05 N", "resolution": 0}, "> 0"), ({"friction": "0.05 N", "resolution": "1 um"}, "not defined here"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_said(asked: dict[str, Any], said: str) -> None:
    given = {"paths": PLANE, "ranges": RANGES, **asked}
    with pytest.raises(hs.SceneError, match=said):
        hs.design_map(LAG, **given)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--uniform",), "--uniform"), (("--jnd", "0.05"), "--jnd"), (("--friction", "1"), "--resolution"),
        (("--free", "zeta", "--range", "50", "500", "--range", "0.4", "0.6", "--uniform", "--within", "0.01"), "leave out one"),
    ],
)  # fmt: skip
def test_the_command_line_takes_what_belongs_to_a_map_with_a_map_alone_and_one_way_to_place_slices(
    options: tuple[str, ...], said: str
) -> None:
    assert said in str(CliRunner().invoke(app, ["require", "fu2019", "--free", "omega_n", *options]).exception)


# --- all sets of a map ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_map_tells_each_of_its_sets_by_itself_and_all_together() -> None:
    ranges: list[Any] = [(100, 400), (0, 4)]
    asked: Any = {"that": ["stable", "transparent"], "jnd": ["5 %", "0.05"]}
    found = hs.design_map(HELD, ["omega_c", "environment.b"], ranges, slices=3, uniform=True, **asked)
    bound = {w: max(0.0, 42 / (1 + 0.14 * w) - 1) for w in (100, 250, 400)}
    row = found.to_dict()
    assert faults(row) == []
    assert [row[x] for x in ("free", "unit", "range", "band", "criteria", "certified")] == [
        ["effects.first-order-lag.omega_c", "environment.b"], ["rad/s", "N*s/m"], [[100, 400], [0, 4]], [0, 10],
        ["transparent", "stable"], True,
    ]  # fmt: skip
    for w, x in zip(bound, row["slices"], strict=True):
        assert x["at"] == w
        assert x["feasible"] == x["apart"]["stable"] == [[pytest.approx(bound[w], rel=1e-15), 4]]
        assert x["apart"]["transparent"] == [[0, 4]]
        assert x["contours"] == [{"jnd": 0.05, "feasible": [] if w == 100 else [[0, 4]], "certified": True}]
        told = [(y["at"], y["part"], y["criterion"], y["kind"]) for y in x["binding"]]
        assert told == ([(pytest.approx(bound[w]), None, "stable", "axis")] if bound[w] else [])
    first, second = row["between"]
    assert first["deviation"] is None  # one contour is empty on one side
    assert row["deviation"] == second["deviation"] == pytest.approx((bound[100] - 2 * bound[250]) / 2)
    known = [("transparent", None, 1), ("transparent", Rational(1, 20), 3), ("stable", None, 2)]
    assert [(x.of, x.jnd, x.set) for x in found.proofs] == known
    for x, y in zip(row["proven"], found.proofs, strict=True):
        assert (x["of"], x["jnd"]) == (y.of, None if y.jnd is None else float(y.jnd))
        assert x["bound"] == found.bound(y) == max(z for z in x["between"] if z is not None)
    noticed_, contour, stable = row["proven"]
    assert (noticed_["open"], noticed_["between"], contour["between"]) == (0, [0, 0], [None, 0])
    for (a, b), most in zip(((100, 250), (250, 400)), stable["between"], strict=True):
        true = off(lambda w: np.maximum(0, 42 / (1 + 0.14 * w) - 1), a, b)
        assert true - 4 / 512 <= most < true + 0.1  # of what stays open at an end of the range it is told from there


def test_the_stiffest_wall_of_a_map_is_named_where_it_is_known_and_below_the_end_of_its_range() -> None:
    """K < (1 + 0.14 w)(1 + B)/0.14 at w = 100: 535.7 for B = 4."""
    for top, is_told in ((600, True), (500, False)):
        options = {"part": None, "any_environment": False}
        asked = Asked.of(HELD, WALL, [(0, 4), (10, top)], options, ("stable",), ())
        low, high = map(asked.cut, (Rational(0), Rational(4)))
        found = hs.DesignMap(HELD, asked.free, asked.ranges, (low, high), asked.criteria, asked.wanted)
        assert (found.stiffest is not None) is is_told
        if found.stiffest is not None:
            at, value = found.stiffest
            assert (at.place, float(value)) == (4, pytest.approx(15 * 5 / 0.14, rel=1e-14))
        open_ = replace(high, requirement=known(high.requirement, holds=None))
        none = replace(high, requirement=known(high.requirement, holds=False))
        assert replace(found, slices=(low, open_)).stiffest is None
        assert replace(found, slices=(none,)).stiffest is None
        below = replace(found, slices=(low, none)).stiffest
        assert below is not None
        assert below[0] is low
        assert replace(found, free=found.free[::-1]).stiffest is None
        assert replace(found, that=("transparent",)).stiffest is None


@pytest.mark.parametrize("damping", [27, pytest.param(60, marks=pytest.mark.slow)])
def test_the_stiffest_wall_of_an_undamped_sampled_device_is_the_closed_form(damping: int) -> None:
    """alpha = 2 beta (2 - beta)/(2 + beta) with alpha = K T^2/m and beta = B T/m, T = 1 ms and m = 0.04 kg."""
    loop, device, beta = F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="0.04 kg"), damping / 40
    scene = hs.Scene(E.kelvin_voigt(1000, damping), (loop, device), ("0 Hz", "10 Hz"))
    found = hs.require(scene, "environment.k", (1, 40_000), that=["stable"], hand=hs.Hand("nothing"))
    assert spans(found) == [(1, pytest.approx(40_000 * 2 * beta * (2 - beta) / (2 + beta), rel=1e-13))]


def test_curves_of_a_map_vanish_on_its_boundary() -> None:
    """W omega_c = c (W^2 + omega_c^2) at the end W = 15 of the band, and at omega = omega_c, where it is 1/2."""
    options = {"part": None, "any_environment": False}
    asked = Asked.of(LAG, PLANE, RANGES, options, ("transparent",), ())
    found = hs.DesignMap(asked.scene, asked.free, asked.ranges, (), asked.criteria)
    curves = {(x.name, kind): y for (x, kind), y in found.curves().items()}
    assert set(curves) == {(x, kind) for x in ("real", "imag") for kind in (Kind.START, Kind.EDGE, Kind.TOUCH)}
    wc, c = (x.symbol for x in found.free)
    for w, jnd in ((20, Rational(300, 625)), (35, Rational(525, 1450)), (300, Rational(4500, 90225))):
        assert (
            curves["imag", Kind.EDGE].subs({wc: w, c: jnd}) == 0 != curves["imag", Kind.EDGE].subs({wc: w, c: jnd + 1})
        )
    assert curves["imag", Kind.TOUCH].subs(c, Rational(1, 2)) == 0 != curves["imag", Kind.TOUCH].subs(c, Rational(1, 3))
    late = replace(found, scene=hs.Scene(LAG.environment, (*LAG.effects, F.delay("1 ms")), LAG.band))
    with pytest.raises(hs.SceneError, match="delays or powers"):
        late.curves()


def known(r: hs.Requirement, *, holds: bool | None) -> hs.Requirement:
    return replace(r, values=hs.ValueSet.all_of(r.domain, holds=holds))


@pytest.mark.slow
def test_no_line_of_the_figure_closes_a_set_between_slices_and_what_lies_between_unlike_ones_is_hatched() -> None:
    found = hs.design_map("fu2019", ["zeta", "omega_n"], [("0.2", "0.9"), (50, 100)], slices=3, jnd=["0.2"])

    def drawn(x: hs.DesignMap) -> tuple[int, set[tuple[float, float]]]:
        ax = Figure().add_subplot()
        draw(ax, requirement_charts.wishes(x))
        boxes = [y.get_paths()[0].get_extents() for y in ax.collections if y.get_hatch()]
        upright = sum(len(set(map(float, y.get_xdata()))) == 1 < len(y.get_xdata()) for y in ax.lines)
        return upright, {(float(y.x0), float(y.x1)) for y in boxes}

    def counts(x: Slice) -> list[int]:
        return [len(r.feasible) for r in (x.requirement, *x.contours)]

    bare = replace(found, proofs=())
    unlike = {(float(a.at), float(b.at)) for a, b in pairwise(found.slices) if counts(a) != counts(b)}
    assert unlike
    assert (drawn(found), drawn(bare)) == ((0, set()), (0, unlike))  # a band in which the boundary lies is proven
    unknown = partial(known, holds=None)
    rows = [(unknown(x.requirement), tuple(map(unknown, x.contours))) for x in found.slices]
    cut = tuple(replace(x, requirement=r, contours=c) for x, (r, c) in zip(found.slices, rows, strict=True))
    upright, hatched = drawn(replace(bare, slices=cut))
    assert (upright, hatched & unlike) == (0, set())


# --- what is proven all over a plane --------------------------------------------------------------------------------------


def area(cells: Any) -> float:
    return float((cells[..., 1] - cells[..., 0]).prod(-1).sum())


@pytest.mark.parametrize(
    "slices", [3, pytest.param(2, marks=pytest.mark.slow), pytest.param(8, marks=pytest.mark.slow)]
)
def test_rectangles_lie_on_one_side_of_the_boundary_and_bound_what_lines_are_off_by_however_few_there_are(
    slices: int,
) -> None:
    found = lag_map(slices, uniform=True)
    [(proof, bounds)] = found.bounds.items()
    cells = proof.rectangles
    assert (cells.kept[:, 1, 0] >= least(cells.kept[:, 0, 0])).all()  # the boundary goes down beyond 15 rad/s
    assert (cells.broken[:, 1, 1] <= least(cells.broken[:, 0, 1])).all()
    assert sum(map(area, cells.parts)) == pytest.approx(280 * 0.59, rel=1e-12)
    assert cells.share_left == pytest.approx(area(cells.left) / (280 * 0.59))
    assert cells.share_left < 0.01
    for (a, b), bound in zip(pairwise(found.slices), bounds, strict=True):
        assert bound is not None
        assert off(least, a.place, b.place) <= bound <= off(least, a.place, b.place) + 0.03 * 0.59


@pytest.mark.few("1")
@pytest.mark.parametrize("seed", range(6))
def test_each_rectangle_is_kept_or_broken_at_all_of_its_points_as_samples_over_the_band_are(seed: int) -> None:
    """A wall behind a lag and a delay, by its ratios; two of its four numbers are free."""
    pick = Random(seed)
    own = {"environment.k": 100.0, "environment.b": 3.0, "omega_c": 60.0, "tau": 0.004}
    scene = hs.Scene(
        E.kelvin_voigt(100, 3), (F.first_order_lag(60), F.delay("4 ms")), (0, 12), pick.choice(["0.1", "0.2"])
    )
    paths = pick.sample([*own], 2)
    one, other = scene.knobs.chosen(paths)
    first, second = ((Rational(own[x]) / 4, Rational(own[x]) * 4) for x in paths)
    found = rectangles(scene, (one, other), (first, second), noticed(scene.threshold))
    assert found is not None
    z, c = 1j * np.linspace(0.01, 12, 1200), float(scene.threshold[hs.Part.REAL])

    def most(values: Any) -> float:
        k, b, corner, tau = (own | dict(zip(paths, values, strict=True))).values()
        r = (k + b * z) / abs(k + b * z) * (np.exp(-z * tau) / (1 + z / corner) - 1)
        return float(np.maximum(abs(r.real), abs(r.imag)).max()) - c

    rng = np.random.default_rng(seed)
    for cells, side in ((found.kept, -1), (found.broken, 1)):
        for cell in cells[rng.permutation(len(cells))[:60]]:
            for share in ((0, 0), (1, 1), (0, 1), (1, 0), (0.5, 0.5)):
                assert side * most(cell[:, 0] + (cell[:, 1] - cell[:, 0]) * share) > -1e-4
    whole = float((first[1] - first[0]) * (second[1] - second[0]))
    assert sum(map(area, found.parts)) == pytest.approx(whole, rel=1e-12)
    assert found.share_left < 0.05


@pytest.mark.slow
def test_what_is_stable_all_over_a_plane_is_what_rouths_rule_says() -> None:
    """(1 + 0.14 w)(1 + B) > 0.14 K at w = 100."""
    free: Any = tuple(HELD.knobs.chosen(WALL))
    found = held_rectangles(HELD, free, ((Rational(0), Rational(4)), (Rational(10), Rational(600))))
    assert found is not None

    def most(b: Any) -> Any:
        return 15 * (1 + b) / 0.14

    assert (found.kept[:, 1, 1] <= most(found.kept[:, 0, 0]) + 1e-9).all()
    assert (found.broken[:, 1, 0] >= most(found.broken[:, 0, 1]) - 1e-9).all()
    assert min(len(found.kept), len(found.broken)) > 0
    assert found.share_left < 0.02


@pytest.mark.slow
def test_what_is_stable_of_a_late_spring_is_proven_between_exact_slices_too() -> None:
    paths, ranges = ["tau", "environment.k"], [("1 ms", "60 ms"), (10, 1000)]
    asked: Any = {"that": ["stable"], "hand": "postural-arm"}
    found = hs.design_map("delayed-spring", paths, ranges, slices=9, uniform=True, **asked)
    [stable] = found.proofs
    assert stable.rectangles.share_left < 0.01
    for x in found.slices:
        [(_, end)] = spans(x.requirement)
        for cells, side in ((stable.rectangles.kept, 1), (stable.rectangles.broken, -1)):
            own = cells[(cells[:, 0, 0] <= float(x.at)) & (cells[:, 0, 1] >= float(x.at))]
            assert len(own) or side < 0
            assert (side * (end - own[:, 1, (1 + side) // 2]) >= 0).all()


@pytest.mark.slow
def test_further_thresholds_are_proven_too() -> None:
    found = hs.design_map(LAG, ["omega_c", "k"], [(20, 300), (10, 1000)], slices=3, jnd=["0.2", "0.3"])
    assert [(x.set, x.jnd and float(x.jnd)) for x in found.proofs] == [(0, None), (1, 0.2), (2, 0.3)]
    for x, c in zip(found.proofs, (0.1, 0.2, 0.3), strict=True):
        edge = 15 / c * (1 + np.sqrt(1 - 4 * c**2)) / 2  # W omega_c/(W^2 + omega_c^2) = c
        assert (x.rectangles.kept[:, 0, 0] >= edge).all()
        assert (x.rectangles.broken[:, 0, 1] <= edge).all()


@pytest.mark.slow
def test_what_stays_open_at_an_end_of_the_range_is_as_near_as_that_end() -> None:
    """A wall's lowest stiffness is undecided on a strip; the boundary far above it is no further off for that."""
    found = hs.design_map("virtual-wall", WALL, [(16, 24), (10, 4000)], slices=3, uniform=True)
    [bounds] = found.bounds.values()
    assert all(x is not None and x < 0.01 * 3990 for x in bounds)


@pytest.mark.dear("asked0")
@pytest.mark.parametrize("asked", [{"any_environment": True}, {"that": ["passive"]}])
def test_where_no_models_are_nothing_is_claimed_between_slices(asked: dict[str, Any]) -> None:
    found = hs.design_map("fu2019", ["omega_n", "zeta"], [(60, 200), ("0.1", 1)], slices=2, uniform=True, **asked)
    assert (found.proofs, "proven" in found.to_dict()) == ((), False)


def test_what_several_planes_keep_is_kept_in_each_wherever_their_ranges_begin() -> None:
    """By pixels, of three planes that are cut at other places each."""
    rng, size, none = np.random.default_rng(3), 512, np.empty((0, 2, 2))
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
    told = np.zeros((size, size), int)
    for (i, j), (m, n) in np.rint((common(planes) - low) / width * size).astype(int):
        told[i:j, m:n] += 1
    assert (told == every).all()


# --- the plane of a hand --------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.few("1")
@pytest.mark.parametrize("seed", range(3))
def test_all_pixels_of_a_cell_of_the_plane_of_a_hand_have_the_roots_that_are_counted_in_it(seed: int) -> None:
    """(m s^2 + b s + k)(s + w) + w (0.2 s^2 + 2 s + 30): roots in numpy, but next to the boundary."""
    pick = Random(seed)
    corner, mass = pick.randint(5, 40), Rational(pick.randint(2, 9), 10)
    scene = hs.Scene(E.mass_spring_damper(m="0.2 kg", b=2, k=30), (F.first_order_lag(corner),))
    low, high, least_b, most_b = window = (-100.0, 400.0, -6.0, 10.0)
    found = plane(scene, hs.Hand("any", m=mass), window)
    assert len(found.cells) > 1
    rng, told = np.random.default_rng(seed), 0
    for cell in found.cells:
        assert cell.roots is not None
        inner = cell.pixels & np.roll(cell.pixels, 1, 0) & np.roll(cell.pixels, -1, 0)
        inner &= np.roll(cell.pixels, 1, 1) & np.roll(cell.pixels, -1, 1)
        inner[[0, -1]] = inner[:, [0, -1]] = False
        size = len(inner)
        for i, j in rng.permutation(np.argwhere(inner))[:80]:
            k, b = low + (i + 0.5) * (high - low) / size, least_b + (j + 0.5) * (most_b - least_b) / size
            row = np.polyadd(np.polymul([1, corner], [float(mass), b, k]), corner * np.array([0.2, 2, 30]))
            assert int((np.roots(row).real > 0).sum()) == cell.roots.number
            told += 1
        assert cell.is_stable is (cell.roots.number == 0)
    assert told > 100
    assert found.at_0 == -30


# --- classical bounds -----------------------------------------------------------------------------------------------------


def test_classical_bounds_are_there_where_the_scene_has_what_they_need() -> None:
    """b = 0.8 N s/m, T = 1 ms: K < 2 (b - |B|)/T; with 0.05 N and 61.4 um K < 1628.66 N/m."""
    loop, device = F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="0.04 kg", b="0.8 N*s/m", name="device")
    scene = hs.Scene(E.kelvin_voigt(1000, 0), (loop, device), ("0 Hz", "10 Hz"))

    def found(own: hs.Scene, *free: str) -> dict[str, Any]:
        encoder = Encoder.of(own, "0.05 N", "61.4 um")
        return {x.name: x for x in lines(own, [own.knobs[y] for y in free], encoder)}

    abbott = found(scene, "effects.device.b", "environment.k")["Abbott and Okamura"]
    for b in (0.1, 3):
        assert -abbott.excess({"environment.k": 0.0, "effects.device.b": b}) == pytest.approx(1628.664495, rel=1e-9)
    for B in (-0.3, 0.0, 0.5):
        own = found(scene, *WALL)["Colgate and Schenkel"].excess({"environment.k": 1000.0, "environment.b": B})
        assert own == pytest.approx(1000 - 2000 * (0.8 - abs(B)))
    assert found(scene.with_values({"environment.b": 1}), *WALL)["Abbott and Okamura"].where == (
        ("environment.b", 0.0),
    )
    late = hs.Scene(scene.environment, (F.sampled_loop("1 ms", "backward-difference", delay=1), device), scene.band)
    damped = scene.with_values({"environment.b": 1})
    for other, free in ((damped, "effects.device.b"), (late, "effects.device.b"), (scene, "effects.device.m")):
        assert "Abbott and Okamura" not in found(other, free, *(["environment.k"] if free[-1] == "b" else []))
    with pytest.raises(hs.SceneError, match="rotational"):
        Encoder.of(scene, "0.05 N*m", "1 um")
    assert lines(hs.Scene(E.mass_spring_damper(m=1, k=1000), scene.effects), [scene.knobs["environment.k"]]) == ()


@pytest.mark.parametrize(("formula", "count"), [("b*s^2", 0), ("b*s + q", 0), ("3*s", 0), ("b*s + m*s^2", 2)])
def test_a_device_that_is_a_formula_is_in_no_classical_bound_whatever_its_numbers_are_called(
    formula: str, count: int
) -> None:
    given = {x: 1 for x in "bqm" if x in formula}
    chain = (F.sampled_loop("1 ms", "backward-difference"), F.shunt(Z=formula, parameters=given))
    scene = hs.Scene(E.kelvin_voigt(500, 1), chain, hands=(hs.Hand("own", m=1, b=1, k=1),))
    assert len(lines(scene, [scene.knobs["environment.k"]])) == count


@pytest.mark.parametrize("seed", range(3))
def test_classical_bounds_are_those_of_the_field_for_any_wall_and_depend_on_what_is_free(seed: int) -> None:
    """K < (b + b_hand + B)/(T/2 + t_d), K < 2 (b - |B|)/T without delay, K < 2 f_c/Delta of a spring alone: written once more."""
    pick = Random(seed)
    for _ in range(4):
        T, tau = (pick.choice([Rational(0), Rational(pick.randint(1, 9), 1000)]) for _ in range(2))
        late, hold = pick.choice([0, 1, 2]), pick.random() < 0.5
        K, B, b = Rational(pick.randint(1, 900)), Rational(pick.choice([0, 1, 3]), 4), Rational(pick.randint(0, 20), 4)
        clock = (
            F.zero_order_hold(T or 1, name="clock") if hold else F.sampled_loop(T or 1, "tustin", late, name="clock")
        )
        parts = [*([clock] if T else []), *([F.delay(tau, name="link")] if tau else [])]
        count = pick.randint(1, 2)
        devices = [F.shunt(m="0.1", b=x, name=f"device{i}") for i, x in enumerate((b, Rational(1, 2))[:count])]
        hands = tuple(hs.Hand(f"hand{n}", m="0.2", b=Rational(n + 1), k=3) for n in range(pick.randint(0, 2)))
        felt = E.kelvin_voigt(K, B) if pick.random() < 0.5 else E.mass_spring_damper(0, B, K)
        scene = hs.Scene(felt, (*parts, *devices), ("0 Hz", "10 Hz"), hands=hands)
        known = [x.path for x in scene.knobs if x.path.startswith(("environment.", "effects.", "hand"))]
        free = pick.sample([x for x in known if x != "environment.m"], 2)
        encoder = Encoder.of(scene, "0.5 N", "1/1000 m") if pick.random() < 0.6 else None
        found = {x.name: x for x in lines(scene, [scene.knobs[x] for x in free], encoder)}
        held = {x for x in known if x.startswith("hand") and x.endswith(".b") and "hand1" not in x}
        at = {"environment.k": K, "environment.b": B, "effects.device0.b": b, **dict.fromkeys(held, 1)}
        at |= {"effects.clock.T": T} if T else {}
        at |= {"effects.link.tau": tau} if tau else {}
        at |= {"effects.device1.b": Rational(1, 2)} if count == 2 else {}
        moving, late = {x for x in free if x in at}, 0 if hold else late
        plain = T > 0 and not tau and not late
        names = {"Gil and Hulin"} if (T or tau) and moving else set()
        names |= {"Colgate and Schenkel"} if plain and moving else set()
        spring = "environment.k" in free and plain and (not B or "environment.b" in free)
        assert set(found) == names | ({"Abbott and Okamura"} if spring and encoder else set())
        given = {x: pick.randint(1, 9) / 7 for x in free}
        new = {x: given.get(x, float(v)) for x, v in at.items()}
        k, B2, T2 = new["environment.k"], new["environment.b"], new.get("effects.clock.T", 0.0)
        damping = sum(new.get(f"effects.device{i}.b", 0.0) for i in range(2))
        wait = T2 / 2 + late * T2 + new.get("effects.link.tau", 0.0)
        expected = {"Abbott and Okamura": 1000.0}
        if names:
            expected["Gil and Hulin"] = (damping + sum(new[x] for x in held) + B2) / wait
            expected["Colgate and Schenkel"] = 2 * (damping - abs(B2)) / T2 if T2 else 0.0
        for name, line in found.items():
            assert line.excess(given) == pytest.approx(k - expected[name], rel=1e-12)
