"""What is asked of a map: which slices, of which sets, in how much of the time; and where further slices go."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Integer, Rational

import haptisym as hs
from haptisym.kernel.budget import Budget
from haptisym.verbs.require import asking, placing
from haptisym.verbs.require.asking import Asked, Plan
from haptisym.verbs.require.placing import _worst, even, first_places, refined
from haptisym.verbs.require.slices import Slice
from haptisym.verbs.require.wishes import WISHES

PAPER = hs.load_scene("fu2019")
PATHS = ["zeta", "omega_n"]
RANGES = [("0.4", "0.6"), (50, 500)]
HELD = replace(PAPER, hands=(hs.Hand("one", m=1), hs.Hand("two", m=2)))


@pytest.mark.parametrize("count", [2, 3, 7, 41])
def test_places_are_as_far_from_each_other_from_end_to_end(count: int) -> None:
    low, high = Rational(-7, 3), Rational(5)
    found = even(low, high, count)
    assert (len(found), found[0], found[-1]) == (count, low, high)
    assert {b - a for a, b in pairwise(found)} == {(high - low) / (count - 1)}
    assert first_places(low, high, count) == even(low, high, min(count, 9))


# Where further slices go


@dataclass(frozen=True)
class Cut:
    """A slice at a place, of sets of which some may be open."""

    place: float
    open: bool = False

    @property
    def at(self) -> Rational:
        return Rational(self.place)

    @property
    def ends(self) -> tuple[Any, ...]:
        return ((), None) if self.open else ((), ())


def _gaps(deviations: dict[float, float | None]) -> Any:
    return lambda found: [
        SimpleNamespace(low=a.place, high=b.place, deviation=deviations[a.place]) for a, b in pairwise(found)
    ]


@pytest.mark.parametrize("seed", range(8))
def test_a_gap_is_worth_a_slice_where_lines_are_off_by_more_than_the_share_and_not_far_better_than_the_worst(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By its deviation over the second range, or its width over the first where it has none; never beside what stays open."""
    pick = Random(seed)
    for _ in range(40):
        marks = [0.0]
        for _ in range(7):
            marks.append(marks[-1] + pick.choice([0.25, 1.0, 4.0]))
        found = [Cut(x, pick.random() < 0.1) for x in marks]
        deviations = {x: pick.choice([None, 0.0, 1.0, 2.0, 8.0, 16.0, 64.0]) for x in marks}
        share = pick.choice([0.25, 0.5, 1.0, 4.0])
        monkeypatch.setattr(placing, "gaps", _gaps(deviations))
        size = pick.choice([(2.0, 4.0), (8.0, 1.0)])
        scores = {}
        for i, (a, b) in enumerate(pairwise(found)):
            off = deviations[a.place]
            scores[i] = 0.0 if a.open or b.open else (b.place - a.place) / size[0] if off is None else off / size[1]
        most = max(scores.values())
        told = _worst(found, size, share)  # type: ignore[arg-type]
        assert set(told) == {i for i, x in scores.items() if x > share and 8 * x >= most}
        assert all(scores[i] > scores[j] or (scores[i] == scores[j] and i < j) for i, j in pairwise(told))
    monkeypatch.setattr(placing, "gaps", lambda _: [])
    assert _worst([Cut(0.0)], (1.0, 1.0), 0.5) == []  # type: ignore[list-item]


@pytest.mark.parametrize(("most", "stop"), [(3, None), (9, None), (10, None), (40, None), (40, 5), (40, 7)])
def test_slices_are_put_halfway_the_worst_gaps_first_until_all_are_good_or_there_are_no_more(
    most: int, stop: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lines are off by the square of a gap's width; from 0 to 1 narrow, from 1 on wide; ``stop`` : then the time is over."""
    monkeypatch.setattr(
        placing,
        "gaps",
        lambda found: [
            SimpleNamespace(low=a.place, high=b.place, deviation=(b.place - a.place) ** 2) for a, b in pairwise(found)
        ],
    )
    budget, asked = Budget(None, None), list[tuple[float, int]]()

    def cut(at: Any, n: int) -> Any:
        asked.append((float(at), n))
        budget.reached = len(asked) == stop
        return Cut(float(at))

    start: list[Any] = [Cut(x) for x in (0.0, 0.5, 1.0, 3.0, 7.0)]
    found = refined(start, cut, budget, most, (7.0, 1.0), 0.3)
    places = [x.place for x in found]
    assert places == sorted(places)
    assert len(set(places)) == len(places) == max(5, min(most, 5 + (stop or 99), len(places)))
    assert [n for _, n in asked] == list(range(5, 5 + len(asked)))
    known = [0.0, 0.5, 1.0, 3.0, 7.0]
    for at, _ in asked:
        known.append(at)
        assert any(2 * at == a + b for a, b in combinations(known[:-1], 2))
    assert asked[:1] == ([(5.0, 5)] if most > 5 else [])
    widths = [b - a for a, b in pairwise(places)]
    if most == 40 and stop is None:
        assert max(widths) ** 2 <= 0.3
        assert min(widths) == 0.5
        assert len(places) == 5 + 3 + 7
    elif stop:
        assert len(places) == 5 + stop
    else:
        assert len(places) == max(most, 5)


def test_where_the_time_is_over_already_no_slice_is_added() -> None:
    budget = Budget(1.0, 0.0, reached=True)
    start: Any = [Cut(0.0), Cut(9.0)]
    assert refined(start, lambda *_: pytest.fail("asked"), budget, 9, (1.0, 1.0), 0.1) == start


# What is asked


def asked(
    scene: hs.Scene = PAPER, wanted: tuple[str, ...] = ("transparent",), jnd: Any = (), ranges: Any = RANGES
) -> Asked:
    return Asked.of(scene, PATHS, ranges, {"part": None, "any_environment": False}, wanted, jnd)


def test_of_a_map_is_known_what_is_asked_where_and_by_which_criteria() -> None:
    every = [x for n in (1, 2, 3) for x in combinations(WISHES, n)]
    for wanted in every:
        own = asked(HELD, wanted)
        names = [
            *(["real", "imag"] if "transparent" in wanted else []),
            *(["stable"] * 2 if "stable" in wanted else []),
        ]
        assert [x.name for x in own.criteria] == names + (["passive"] if "passive" in wanted else [])
        assert own.ranges == ((Rational(2, 5), Rational(3, 5)), (50, 500))
        assert [x.path for x in own.free] == ["effects.filter.zeta", "effects.filter.omega_n"]
        assert own.wanted == wanted
    ranges: Any
    for ranges in ([], RANGES[:1], [*RANGES, (1, 2)]):
        with pytest.raises(hs.SceneError, match="ranges"):
            asked(ranges=ranges)
    for wrong in ([(1, 1), (50, 500)], [("0.4", "0.6"), (9, 2)], [(-3, -1), (50, 500)]):
        with pytest.raises(hs.SceneError):
            asked(ranges=wrong)


def test_further_thresholds_are_each_asked_once_and_only_where_they_mean_something() -> None:
    assert asked(jnd=()).thresholds == ()
    assert asked(jnd=("10 %", Rational(1, 10), "0.2", "1/10")).thresholds == (Rational(1, 10), Rational(1, 5))
    with pytest.raises(hs.SceneError, match="ask for transparent too"):
        asked(wanted=("passive",), jnd=("0.2",))
    assert asked(wanted=("passive",)).thresholds == ()
    with pytest.raises(hs.SceneError, match="which is free, say the same"):
        Asked.of(
            PAPER,
            ["c", "omega_n"],
            [("0.1", "0.2"), (50, 500)],
            {"part": None, "any_environment": False},
            ("transparent",),
            ["0.2"],
        )
    square = {"shape": "polygon", "corners": [[1, 0], [0, 1], [-1, 0], [0, -1]]}
    polygon = hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, square)
    with pytest.raises(hs.SceneError, match="given by its corners"):
        asked(polygon, jnd=("0.2",))
    for wrong in ("-0.1", "0.2 N", 0):
        with pytest.raises(hs.SceneError):
            asked(jnd=("0.1", wrong))


def required(scene: hs.Scene, path: str, along: Any, *, that: Any = ("transparent",), **options: Any) -> Any:
    """What a slice is asked, and of which scene."""
    assert (path, along) == ("effects.filter.omega_n", (50, 500))
    assert options == {"part": None, "any_environment": False}
    return SimpleNamespace(that=(*that,), zeta=scene.knobs["zeta"].value, c=scene.threshold[hs.Part.REAL])


@pytest.mark.parametrize("jnd", [(), ("0.2", "0.3")])
@pytest.mark.parametrize("wanted", [x for n in (1, 2, 3) for x in combinations(WISHES, n)])
def test_each_proof_is_of_the_set_that_a_slice_has_at_its_number(
    wanted: tuple[str, ...], jnd: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of each thing asked and of each further threshold one; what leaves all of the plane open proves nothing."""
    if jnd and "transparent" not in wanted:
        return
    own, planes = asked(HELD, wanted, jnd), list[tuple[Any, ...]]()

    def plane(scene: hs.Scene, free: Any, window: Any, *_: Any) -> Any:
        planes.append((scene, free, window))
        return SimpleNamespace(share_left=0.5)

    for name in ("rectangles", "held_rectangles"):
        monkeypatch.setattr(asking, name, plane)
    monkeypatch.setattr(asking, "require", required)

    def of(at: Any, apart: Any, contours: Any) -> Slice:
        whole: Any = SimpleNamespace(that=(*wanted,))
        return Slice(at, whole, (*apart,) if len(wanted) > 1 else (), (*contours,))

    monkeypatch.setattr(Slice, "of", of)
    cut = own.cut(Rational(1, 2))
    proofs = own.proofs()
    expected = [(x, None) for x in ("transparent",) if x in wanted] + [("transparent", Rational(c)) for c in jnd]
    assert [(x.of, x.jnd) for x in proofs] == expected + [(x, None) for x in ("stable",) if x in wanted]
    for x, (scene, free, window) in zip(proofs, planes, strict=True):
        found: Any = cut.sets[x.set]
        assert found.that == (x.of,)
        assert (
            len(wanted) == 1
            or x.jnd is not None
            or (found.zeta, found.c) == (Rational(1, 2), PAPER.threshold[hs.Part.REAL])
        )
        assert x.jnd is None or found.c == x.jnd == scene.threshold[hs.Part.REAL]
        assert (free, window, x.window) == (own.free, own.ranges, own.ranges[1])
    monkeypatch.setattr(asking, "rectangles", lambda *_: SimpleNamespace(share_left=1))
    monkeypatch.setattr(asking, "held_rectangles", lambda *_: None)
    assert own.proofs() == ()


def test_the_plane_goes_as_far_as_the_rules_of_both_parameters_allow() -> None:
    assert asked(ranges=[(-1, 2), (-5, 500)])._window == ((0, 2), (0, 500))
    assert asked()._window == ((Rational(2, 5), Rational(3, 5)), (50, 500))


@pytest.mark.parametrize("within", [None, Rational(1, 50)])
@pytest.mark.parametrize("low", [0, Rational(1, 5)])
def test_slices_are_cut_where_the_rule_allows_and_each_leaves_half_of_the_time_but_the_last_one(
    within: Any, low: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = {"part": None, "any_environment": False}
    own = Asked.of(PAPER, PATHS[::-1], [(low, 1), (1, 10)], options, ("transparent",), ())
    cuts, shares, given, said = list[Any](), list[float](), list[Any](), list[Any]()

    @contextmanager
    def share(x: float) -> Iterator[None]:
        shares.append(x)
        yield

    def more(found: Any, cut: Any, budget: Any, *rest: Any) -> Any:
        given.append(rest)
        return [*found, cut(Integer(7), len(found)), cut(Integer(8), len(found) + 1)]

    def noted(_: Any, at: Any) -> Any:
        cuts.append(at)
        return at

    monkeypatch.setattr(Asked, "cut", noted)
    monkeypatch.setattr(asking, "share", share)
    monkeypatch.setattr(asking, "refined", more)
    budget: Any = SimpleNamespace(say=lambda *x: said.append(x))
    found = own.cut_all(Plan(11, within), budget)
    places = (
        [low + (1 - low) * Rational(i, 10) for i in range(11)]
        if within is None
        else [low + (1 - low) * Rational(i, 8) for i in range(9)]
    )
    places = [x for x in places if x > 0]
    extra = [] if within is None else [Integer(7), Integer(8)]
    assert [*found] == cuts == places + extra
    assert shares == [0.5] * (len(places) - 1) + [1.0] + [0.5] * len(extra)
    assert said == [(n, 11, "slices") for n in range(len(cuts))]
    assert given == ([] if within is None else [(11, (float(1 - low), 9.0), 0.02)])
