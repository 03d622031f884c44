"""Which value comes nearest, step by step: what is tried, how far a value is from doing, and what is proven of all others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from math import sqrt
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from plainshapes import rational
from sympy import Expr, Integer, Rational

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.require import nearest as module
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.nearest import Nearest, _at, _bounded, _tried, nearest

REAL, IMAG = noticed(hs.Threshold())


def spring(gain: str, band: tuple[Any, Any], real: str, imag: str) -> Any:
    """A spring behind a gain in t, and what is asked of it."""
    effect = hs.effects.series(gain, parameters={"t": "1/10"})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (effect,), band, hs.Threshold(real, imag))
    return SimpleNamespace(
        scene=scene,
        free=scene.knobs["t"],
        domain=Domain(None, None),
        criteria=noticed(scene.threshold),
        feasible=(),
        undecided=(),
    )


@pytest.mark.parametrize("seed", range(5))
def test_how_far_a_value_is_from_doing_is_its_largest_ratio_over_the_threshold(seed: int) -> None:
    """|t - a w^2 + b w^4| and |d w|: at the ends of the band, and where a w^2 - b w^4 is largest inside of it."""
    pick = Random(seed)
    for _ in range(3):
        a, b, d = Fraction(pick.randint(1, 9), 10), Fraction(pick.randint(0, 2), 40), Fraction(pick.randint(1, 9), 8)
        low = pick.choice([0, 1])
        high = low + pick.randint(2, 4)
        real, imag = Fraction(pick.randint(1, 9), 10), Fraction(pick.randint(1, 9), 10)
        r = spring(f"1 + t + ({a})*s^2 + ({b})*s^4 + ({d})*s", (low, high), str(real), str(imag))
        value = Fraction(pick.randint(-20, 40), 10)
        places = [Fraction(low) ** 2, Fraction(high) ** 2]
        places += [a / (2 * b)] if b and places[0] < a / (2 * b) < places[1] else []
        reals = {x: abs(value - a * x + b * x**2) / real for x in places}
        found = _at(r, rational(value))
        assert found is not None
        assert found.value == rational(value)
        worst = max(*reals.values(), d * high / imag)
        assert found.times == pytest.approx(float(worst), rel=1e-12)
        if worst == d * high / imag:
            assert (found.binding.criterion.name, found.binding.kind) == ("imag", Kind.EDGE)
            assert float(found.ratio) == pytest.approx(float(d * high), rel=1e-12)
            continue
        at = max(reals, key=lambda x: reals[x])
        kind = Kind.START if at == low**2 else Kind.EDGE if at == high**2 else Kind.TOUCH
        assert (found.binding.criterion.name, found.binding.kind) == ("real", kind)
        assert found.binding.omega is not None
        assert float(found.binding.omega) == pytest.approx(sqrt(at), abs=1e-12)
        assert float(found.ratio) == pytest.approx(float(worst * real), rel=1e-12)


def test_a_value_without_a_scene_or_with_a_ratio_that_has_no_bound_is_not_near() -> None:
    pole = spring("1 + t/(s^2 + 4)", (0, 5), "1/10", "1/10")
    assert _at(pole, Integer(1)) is None
    assert _at(pole, Integer(0)) is not None
    beside = spring("1 + t/(s^2 + 4)", (3, 5), "1/10", "1/10")
    found = _at(beside, Integer(1))
    assert found is not None
    assert found.times == pytest.approx(10 / 5)  # 1/(9 - 4), over 1/10
    absent = spring("1 + s/(t - 3)", (0, 5), "1/10", "1/10")
    assert _at(absent, Integer(3)) is None
    assert _at(absent, Integer(13)) is not None
    alone = spring("1 + t", (0, 5), "1/10", "1/10")
    assert _at(SimpleNamespace(**{**vars(alone), "criteria": ()}), Integer(3)) is None


@pytest.mark.parametrize("own", [Rational(-3), Rational(1, 10), Rational(2)])
def test_guesses_are_tried_first_and_the_scenes_own_value_where_it_is_inside_of_what_is_asked_about(
    own: Rational, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = list[Any]()

    class Guessed:
        def __init__(self, *asked: Any) -> None:
            given.append(asked)

        def best(self) -> Iterator[Expr]:
            yield from (Integer(7), Integer(8))

    monkeypatch.setattr(module, "Guesses", Guessed)
    for low in (None, -4, -3, -2, own):
        for high in (None, 1, 2, 3, own):
            free = SimpleNamespace(value=own)
            domain = Domain(None if low is None else Rational(low), None if high is None else Rational(high))
            r: Any = SimpleNamespace(scene="scene", free=free, domain=domain, criteria=("criteria",))
            inside = (low is None or low < own) and (high is None or own < high)
            assert [*_tried(r)] == [7, 8, *([own] if inside else [])]
            assert given[-1] == ("scene", free, domain, ("criteria",))


# What is proven of all others


def between(low: int | None, high: int | None) -> Solved:
    ends = [End(None if x is None else ExactNumber(Integer(x))) for x in (low, high)]
    return Solved((Span(*ends),))


def best(times: float, value: int = 3) -> Nearest:
    return Nearest(Integer(value), ExactNumber(Integer(1)), Binding(REAL, None, Kind.EDGE), times)


class Answers:
    """What is answered about larger thresholds, in turn; and the thresholds that were asked about."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *answers: Solved) -> None:
        self.asked, self.left = list[list[Any]](), list(answers)
        monkeypatch.setattr(module, "solve", self.solve)

    def solve(self, scene: Any, free: Any, domain: Any, criteria: Any) -> Solved:
        assert (scene, free, domain) == ("scene", "free", "domain")
        self.asked.append([x.threshold for x in criteria])
        return self.left.pop(0)


LIMITS = [replace(REAL, threshold=Rational(1, 10)), replace(IMAG, threshold=Rational(1, 5))]
QUESTION: Any = SimpleNamespace(scene="scene", free="free", domain="domain", criteria=LIMITS)


@pytest.mark.parametrize("times", [1.5, 4.0, 90.0])
@pytest.mark.parametrize("open_ones", [0, 1, 2, 3])
def test_thresholds_just_below_those_of_the_best_value_are_asked_first_and_smaller_ones_where_these_stay_open(
    times: float, open_ones: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By powers of how many times the thresholds it needs, to three digits; what none does with is proven for less."""
    undecided = Solved((), ((None, None),))
    for last, wanted in ((Solved(()), "bound"), (between(2, 9), 3), (between(None, 5), 4), (between(6, None), 7)):
        answers = Answers(monkeypatch, *[undecided] * open_ones, last)
        found = _bounded(QUESTION, best(times))
        assert len(answers.asked) == min(open_ones + 1, 3)
        for (one, other), near in zip(answers.asked, (times**x for x in (0.99, 0.9, 0.6)), strict=False):
            assert other == 2 * one
            assert float(10 * one) == pytest.approx(near, rel=1e-3)
            assert (10 * one).q <= 1000
        if open_ones == 3:
            assert found is None
        elif wanted == "bound":
            assert isinstance(found, float)
            assert 1 - 1e-14 < found / float(10 * answers.asked[-1][0]) < 1
        else:
            assert found == wanted


def test_one_value_alone_is_no_better_and_between_the_thresholds_and_what_is_no_larger_is_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    alone, whole = End(ExactNumber(Integer(5)), closed=True), End(None)
    Answers(monkeypatch, Solved((Span(alone, alone),)))
    assert _bounded(QUESTION, best(4.0)) is None  # it is the best itself, as far as is known
    Answers(monkeypatch, Solved((Span(whole, whole),)))
    assert isinstance(_bounded(QUESTION, best(4.0)), Expr)  # any value does
    for near in (1.0, 1.0000001, 0.5):
        answers = Answers(monkeypatch)
        assert (_bounded(QUESTION, best(near)), answers.asked) == (1.0, [])


@pytest.mark.parametrize("steps", [0, 1, 3, 6, 9])
@pytest.mark.parametrize("end", ["bound", "nothing", "worse", "alike", "no scene", "open"])
def test_better_values_are_taken_until_a_bound_is_proven_or_none_is_better(
    steps: int, end: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each step comes nearer by 1; at most six are taken."""
    count = [0]

    def bounded(_: Any, now: Nearest) -> Any:
        count[0] += 1
        if count[0] <= steps:
            return now.value + 1
        if end == "open":
            raise UndecidedError("nobody knows")
        return {"bound": 1.75, "nothing": None, "worse": Integer(-5), "alike": Integer(-6), "no scene": Integer(-7)}[
            end
        ]

    def at(_: Any, value: Any) -> Nearest | None:
        if value in (-7, 0):
            return None
        return best(50.0 if value == -5 else 20.0 - min(steps, 6) if value == -6 else 21.0 - int(value), int(value))

    monkeypatch.setattr(module, "_bounded", bounded)
    monkeypatch.setattr(module, "_at", at)
    monkeypatch.setattr(module, "_tried", lambda _: iter([Integer(0), Integer(1), Integer(2)]))
    r: Any = SimpleNamespace(feasible=(), undecided=(), free=SimpleNamespace(parts=()), criteria=[REAL, IMAG])
    found = nearest(r)
    taken = min(steps, 6)
    assert found is not None
    assert (found.value, found.times) == (1 + taken, 20.0 - taken)
    assert found.at_least == (1.75 if end == "bound" and steps < 6 else 1.0)
    monkeypatch.setattr(module, "_tried", lambda _: iter([Integer(0), Integer(-7)]))
    assert nearest(r) is None
    for other in ({"feasible": (1,)}, {"undecided": (1,)}, {"free": SimpleNamespace(parts=(hs.Part.REAL,))}):
        monkeypatch.setattr(module, "_tried", lambda _: iter([Integer(1)]))
        assert nearest(SimpleNamespace(**{**vars(r), **other})) is None
    zero = [REAL, replace(IMAG, threshold=Integer(0))]
    assert nearest(SimpleNamespace(**{**vars(r), "criteria": zero})) is None
