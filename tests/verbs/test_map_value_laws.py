"""What a map says of its slices, gaps and proofs, of slices made up; and how it is asked for."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations, product
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Rational

import haptisym as hs
from haptisym.verbs.require import designmap as module
from haptisym.verbs.require.asking import Asked
from haptisym.verbs.require.designmap import DesignMap, _apart
from haptisym.verbs.require.slices import Slice
from haptisym.verbs.require.wishes import WISHES

PAPER = hs.load_scene("fu2019")
FREE: Any = tuple(PAPER.knobs.chosen(["zeta", "omega_n"]))
RANGES: Any = ((Rational(2, 5), Rational(3, 5)), (Rational(50), Rational(500)))


def answer(*, certified: bool = True, that: tuple[str, ...] = ("transparent",)) -> Any:
    return SimpleNamespace(certified=certified, that=that, rows=lambda: {"feasible": [[1, 2]]}, spans=lambda: [[3, 4]])


@dataclass(frozen=True)
class Known:
    """A proof of which the bounds are given."""

    of: str
    jnd: Any
    found: tuple[float | None, ...]
    rectangles: Any = field(default_factory=lambda: SimpleNamespace(share_left=0.25), compare=False)

    def bounds(self, slices: Any) -> tuple[float | None, ...]:
        assert slices == ()
        return self.found


def cut(at: Any, own: Any, apart: Any = (), contours: Any = ()) -> Slice:
    return Slice(Rational(at), own, tuple(apart), tuple(contours))


def chart(slices: Any = (), **more: Any) -> DesignMap:
    return DesignMap(PAPER, FREE, RANGES, tuple(slices), **more)


def test_a_map_is_certain_where_each_slice_is_with_each_of_its_contours() -> None:
    for own, one, other in product([True, False], repeat=3):
        slices = [
            cut(1, answer()),
            cut(2, answer(certified=own), contours=[answer(certified=one), answer(certified=other)]),
        ]
        assert chart(slices).certified is (own and one and other)
        assert chart(slices[::-1]).certified is (own and one and other)


@pytest.mark.parametrize("seed", range(6))
def test_the_largest_deviation_and_bound_are_told_of_gaps_that_have_one(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pick = Random(seed)
    off = [pick.choice([None, 0.0, 1.0, 4.5, 9.0]) for _ in range(pick.randint(0, 4))]
    known = [x for x in off if x is not None]
    monkeypatch.setattr(
        module, "gaps", lambda slices: tuple(SimpleNamespace(low=i, high=i + 1, deviation=x) for i, x in enumerate(off))
    )
    found = chart(within=Rational(1, 100))
    assert found.height == 450.0
    assert found.deviation == max(known, default=None)
    assert found.is_coarse is (bool(known) and max(known) > 4.5)  # a hundredth of 450
    assert replace(found, within=None).is_coarse is False
    proof: Any = Known("transparent", None, tuple(off))
    later: Any = Known("stable", Rational(1, 5), (7.0,))
    found = chart(proofs=(proof, later))
    assert (found.bound(proof), found.bound(later)) == (max(known, default=None), 7.0)
    row = found._body()
    assert row["proven"] == [
        {"of": "transparent", "jnd": None, "open": 0.25, "bound": max(known, default=None), "between": off},
        {"of": "stable", "jnd": 0.2, "open": 0.25, "bound": 7.0, "between": [7.0]},
    ]
    assert row["between"] == [{"from": i, "to": i + 1, "deviation": x} for i, x in enumerate(off)]
    assert row["deviation"] == max(known, default=None)
    assert "proven" not in chart()._body()


def test_the_document_has_of_each_slice_all_of_its_sets() -> None:
    both = [answer(that=("transparent",)), answer(that=("stable",))]
    slices = [cut(1, answer()), cut("5/2", answer(), both, [answer(), answer(certified=False)])]
    row = chart(slices[1:], thresholds=(Rational(1, 5), Rational(2, 5)))._body()
    assert row["slices"] == [
        {
            "at": 2.5, "feasible": [[1, 2]], "apart": {"transparent": [[3, 4]], "stable": [[3, 4]]},
            "contours": [{"jnd": x, "feasible": [[3, 4]], "certified": x == 0.2} for x in (0.2, 0.4)],
        }
    ]  # fmt: skip
    plain = chart(slices[:1])._body()
    assert plain["slices"] == [{"at": 1.0, "feasible": [[1, 2]]}]
    assert (plain["range"], plain["criteria"], plain["certified"]) == ([[0.4, 0.6], [50, 500]], ["transparent"], True)
    assert "lines" not in plain
    assert _apart(slices[0]) == {}


def test_classical_lines_are_drawn_where_stability_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    line = SimpleNamespace(name="one", rule="k < b", assumes="nothing")
    monkeypatch.setattr(
        module,
        "lines",
        lambda scene, free, encoder: (line,) if (scene, free, encoder) == (PAPER, FREE, "encoder") else (),
    )
    for that in (x for n in (1, 2, 3) for x in combinations(WISHES, n)):
        found = chart(that=that, encoder="encoder")
        assert found.lines == ((line,) if "stable" in that else ())
        assert found._body().get("lines") == (
            [{"name": "one", "rule": "k < b", "assumes": "nothing"}] if "stable" in that else None
        )


@pytest.mark.parametrize(
    ("uniform", "given", "within"),
    [(True, None, None), (True, "1 %", None), (False, None, Rational(1, 200)), (False, "2 %", Rational(1, 50))],
)
def test_a_map_is_refined_to_half_a_percent_or_what_is_given_unless_it_is_uniform(
    uniform: bool,  # noqa: FBT001
    given: Any,
    within: Any,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plans = list[Any]()

    def cut_all(_: Asked, plan: Any, budget: Any) -> Any:
        plans.append((plan.most, plan.within, budget.seconds))
        return ()

    monkeypatch.setattr(Asked, "proofs", lambda _: ())
    monkeypatch.setattr(Asked, "cut_all", cut_all)
    for that, hand in ((("transparent",), None), ("stable", hs.Hand("own", m=1)), (["passive", "transparent"], None)):
        found = hs.design_map(
            PAPER,
            ["zeta", "omega_n"],
            [("0.4", "0.6"), (50, 500)],
            that=that,
            hand=hand,
            slices=7,
            within=given,
            uniform=uniform,
            limit=99,
        )
        assert plans.pop() == (7, within, 99)
        assert (found.within, found.ranges, found.free) == (within, RANGES, FREE)
        assert found.that == (("stable",) if hand else tuple(x for x in WISHES if x in that))
        assert [x.name for x in found.scene.hands] == (["own"] if hand else [])
