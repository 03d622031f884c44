"""What is asked of a display together: its words, its criteria, and which way each of them is answered."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from typing import Any

import pytest
from sympy import Integer, Rational

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.require import wishes as module
from haptisym.verbs.require.asking import Plan, share_of
from haptisym.verbs.require.feasible import End, Solved, Span
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.wishes import EVERY_PASSIVE_HAND, WISHES, further, solve_all, wishes

HELD = replace(hs.load_scene("fu2019"), hands=(hs.Hand("one", m=1), hs.Hand("two", m=2)))


def test_wishes_are_told_each_once_in_their_own_order() -> None:
    assert wishes("stable") == ("stable",)
    assert wishes(["passive", "stable", "passive", "transparent"]) == WISHES
    assert wishes(("passive", "transparent")) == ("transparent", "passive")
    for wrong, hint in (("stabel", 'did you mean "stable"?'), ("x" * 90, '"' + "x" * 60 + '"'), (3, '"3" is none of')):
        with pytest.raises(hs.SceneError) as error:
            wishes(["transparent", wrong])  # type: ignore[list-item]
        assert hint in str(error.value)
        assert not str(error.value).endswith((" ", ";"))
    with pytest.raises(hs.SceneError, match="nothing is asked"):
        wishes([])


def test_hands_are_judged_where_stability_is_asked_and_every_passive_one_where_that_is() -> None:
    assert further(HELD, ("transparent",)) == ()
    assert [x.kept for x in further(HELD, ("stable",))] == ["stable in one", "stable in two"]
    assert further(HELD, ("passive",)) == (EVERY_PASSIVE_HAND,)
    assert [x.name for x in further(HELD, ("stable", "passive"))] == ["stable", "stable", "passive"]


@pytest.mark.parametrize(
    ("given", "value"), [("1 %", Rational(1, 100)), (2, 2), ("1/3", Rational(1, 3)), (Fraction(1, 7), Rational(1, 7))]
)
def test_a_share_is_an_exact_positive_number(given: Any, value: Any) -> None:
    assert share_of(given) == value
    for wrong in (0, -1, "-1 %", "0"):
        with pytest.raises(hs.SceneError, match=r"within: .* must be > 0"):
            share_of(wrong)


def test_a_map_has_two_slices_at_least() -> None:
    assert Plan(2, None).most == 2
    for wrong in (1, 0, -3, True, 2.5):
        with pytest.raises(hs.SceneError, match="slices"):
            Plan(wrong, None)  # type: ignore[arg-type]


def between(low: int, high: int) -> Solved:
    return Solved((Span(End(ExactNumber(Integer(low)), closed=True), End(ExactNumber(Integer(high)), closed=True)),))


def ends(x: Solved) -> tuple[float, float]:
    [span] = x.feasible
    assert span.low.value is not None
    assert span.high.value is not None
    return float(span.low.value), float(span.high.value)


@pytest.mark.parametrize("clocked", [False, True])
@pytest.mark.parametrize("wanted", [x for n in (1, 2, 3) for x in combinations(WISHES, n)])
def test_each_thing_is_asked_once_its_own_way_and_what_is_in_all_sets_is_told(
    wanted: tuple[str, ...],
    clocked: bool,  # noqa: FBT001
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    called, domain, free = list[Any](), Domain(Integer(0), Integer(20)), HELD.knobs["zeta"]
    sets = {"transparent": between(0, 10), "one": between(2, 20), "two": between(3, 20), "passive": between(1, 9)}

    def transparent(scene: Any, knob: Any, asked: Any, judged: Any) -> Solved:
        called.append(("transparent", [x.name for x in judged]))
        assert (scene, knob, asked) == (HELD, free, domain)
        return sets["transparent"]

    def stable(scene: Any, hand: Any, knob: Any, asked: Any) -> Solved:
        called.append(("stable", hand.name))
        assert (scene, knob, asked) == (HELD, free, domain)
        return sets[hand.name]

    def passive(way: str) -> Any:
        def solved(*given: Any) -> Solved:
            called.append((way, given == (HELD, free, domain)))
            return sets["passive"]

        return solved

    ways = {"": transparent, "_stable": stable, "_passive": passive("passive"), "_sampled": passive("sampled")}
    for name, way in ways.items():
        monkeypatch.setattr(module, f"solve{name}", way)
    monkeypatch.setattr(module, "clocks", lambda _: ["a clock"] if clocked else [])
    judged = noticed(HELD.threshold) if "transparent" in wanted else ()
    found = solve_all(HELD, free, domain, (*judged, *further(HELD, wanted)))
    expected = [("transparent", ["real", "imag"])] * ("transparent" in wanted)
    expected += [("stable", x) for x in ("one", "two") if "stable" in wanted]  # type: ignore[misc]
    expected += [("sampled" if clocked else "passive", True)] * ("passive" in wanted)  # type: ignore[list-item]
    assert called == expected
    names = [x for x in sets if x in wanted or (x in ("one", "two") and "stable" in wanted)]
    own = [ends(sets[x]) for x in names]
    assert ends(found) == (max(a for a, _ in own), min(b for _, b in own))


@pytest.mark.parametrize(
    ("error", "reason"), [(LimitError("the time is over"), ""), (UndecidedError("nobody knows"), "nobody knows")]
)
def test_of_a_thing_that_is_not_known_all_values_are_open_and_those_that_another_denies_are_not(
    error: Exception, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unknown(*_: Any) -> Solved:
        raise error

    domain = Domain(Integer(0), Integer(20))
    monkeypatch.setattr(module, "solve_passive", unknown)
    monkeypatch.setattr(module, "solve", lambda *_: between(2, 5))
    alone = solve_all(HELD, HELD.knobs["zeta"], domain, further(HELD, ["passive"]))
    assert (alone.feasible, alone.reason) == ((), reason)
    assert [tuple(float(x) for x in pair if x) for pair in alone.undecided] == [(0, 20)]
    both = solve_all(HELD, HELD.knobs["zeta"], domain, (*noticed(HELD.threshold), *further(HELD, ["passive"])))
    assert (both.feasible, both.reason) == ((), reason)
    assert [tuple(float(x) for x in pair if x) for pair in both.undecided] == [(2, 5)]
