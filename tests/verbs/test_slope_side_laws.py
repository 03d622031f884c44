"""From which side a frequency moves with a parameter, and why it may not: tables of all that may meet there."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import mpmath
import pytest
from sympy import Rational, Symbol, pi

from haptisym.judge.crossings import CrossingKind
from haptisym.kernel.reals import ExactNumber
from haptisym.model.parameters import Rule
from haptisym.verbs.sensitivity import slopes
from haptisym.verbs.sensitivity.branches import ZERO
from haptisym.verbs.sensitivity.entry import Sensitivities, _same
from haptisym.verbs.sensitivity.slopes import Sensitive, Sensitivity, VariedParameter, _alone, _met, _one_sided, at

LEAST = "from above; below there is no scene"
WHERE = ExactNumber(Rational(4))
x = Symbol("x")


def exact(n: Any) -> ExactNumber:
    return ExactNumber(Rational(n))


def parameter(value: Any, rule: Rule) -> VariedParameter:
    knob: Any = SimpleNamespace(value=Rational(value), rule=rule, symbol=x, path="p", name="p")
    return VariedParameter(knob, exact(value), SimpleNamespace())  # type: ignore[arg-type]


def told(row: Sensitivity) -> tuple[Any, ...]:
    numbers = (None if n is None else float(n) for n in (row.derivative, row.elasticity))
    return (*numbers, row.reason, row.side)


@pytest.mark.parametrize("value", [0, 3])
@pytest.mark.parametrize("rule", [Rule.NONNEGATIVE, Rule.POSITIVE, Rule.ANY])
def test_at_its_least_value_a_parameter_moves_a_frequency_upward_alone_and_by_no_share_of_itself(
    value: int, rule: Rule
) -> None:
    p = parameter(value, rule)
    assert p.least is (value == 0 and rule is Rule.NONNEGATIVE)
    for derivative in (exact(2), exact(-8)):
        row = _one_sided(p, derivative, WHERE)
        share = float(derivative) * value / 4
        assert told(row) == (float(derivative), share, LEAST if p.least else "", "above" if p.least else "")
    assert told(_one_sided(p, ZERO, WHERE)) == (0, 0, "", "")
    row = _one_sided(parameter(5, rule), ExactNumber(pi), exact(3))
    assert row.elasticity is not None
    with mpmath.workdps(60):
        assert row.elasticity.digits(50) == mpmath.nstr(mpmath.pi * 5 / 3, 50)


BRANCHES: list[list[Any]] = [[], [None], [None, None], [exact(2), None], [exact(2)], [exact(3)], [ZERO]]
WORDS = ["it is not there", "it moves infinitely fast", "it splits into several", "it splits into several"]


@pytest.mark.parametrize("least", [False, True])
def test_where_several_branches_meet_the_one_that_is_alone_on_a_side_is_followed(*, least: bool) -> None:
    p = parameter(0 if least else 4, Rule.NONNEGATIVE)
    assert [_alone(row) for row in BRANCHES] == [*WORDS, exact(2), exact(3), ZERO]
    nothing: Any = SimpleNamespace(sides=lambda: None)
    assert told(_met(p, nothing, WHERE)) == (None, None, "undecided: several branches of the equation meet here", "")
    for (i, below), (j, above) in product(enumerate(BRANCHES), repeat=2):
        meeting: Any = SimpleNamespace(sides=lambda below=below, above=above: (below, above))
        low, high = (None if n < 4 else float(BRANCHES[n][0]) for n in (i, j))
        row = told(_met(p, meeting, WHERE))
        if least:
            side = (LEAST, "above") if high else ("", "")
            assert row == ((None, None, f"undefined: {WORDS[j]}", "") if high is None else (high, 0, *side))
        elif low is None and high is None:
            words = WORDS[i] if WORDS[i] == WORDS[j] else f"{WORDS[j]} above, {WORDS[i]} below"
            assert row == (None, None, f"undefined: {words}", "")
        elif low is None:
            assert row == (high, high, f"from above; on the other side {WORDS[i]}", "above")
        elif high is None:
            assert row == (low, low, f"from below; on the other side {WORDS[j]}", "below")
        elif i == j:
            assert row == (low, low, "", "")
        else:
            words = f"{exact(int(low)).digits(5)} from below, {exact(int(high)).digits(5)} from above"
            assert row == (None, None, f"undefined: {words}", "")


class Met:
    """A meeting of which the sides are given, and whether its only zero is still."""

    still, asked = False, 0

    def __init__(self, *_: Any) -> None:
        Met.asked += 1

    def is_still(self) -> bool:
        return Met.still

    def sides(self) -> Any:
        return [exact(7)], [exact(7)]


def test_a_frequency_moves_as_its_own_equation_says_if_one_alone_vanishes_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of none, one or two equations that hold the parameter or do not; flat, simple, with a slope of 0 or not clear."""
    p = parameter(4, Rule.POSITIVE)
    known: dict[Any, Any] = {}
    cases: Any = product((0, 1, 2), (False, True), ("", "flat"), *[(False, True)] * 4)
    for size, moves, flat, simple, vanishes, clear, still in cases:
        Met.still = still
        equation = SimpleNamespace(partial=lambda _, moves=moves: moves, slope=lambda _: "slope")
        meeting = ((equation, 1),) * size
        slope = SimpleNamespace(
            slope=SimpleNamespace(vanishes=lambda numbers, v=vanishes: v and numbers == {x: 4}),
            is_clear=lambda c=clear: c,
        )
        monkeypatch.setattr(slopes, "not_clear", lambda *_, meeting=meeting: meeting)
        monkeypatch.setattr(slopes, "Meeting", Met)
        monkeypatch.setattr(slopes, "Slope", lambda *_, slope=slope: slope)
        monkeypatch.setattr(slopes, "_one_sided", lambda _, slope, __: slope)
        row: Any = at(p, (), WHERE, known, flat, simple=simple)
        if size and not moves:
            assert told(row) == (0, 0, "", "")
        elif flat:
            assert told(row) == (None, None, "flat", "")
        elif size != 1 or not simple:
            assert row == exact(7)
        elif vanishes or (not clear and still):
            assert row is ZERO
        elif not clear:
            assert told(row) == (None, None, "undecided: dF/dp or dF/d omega is 0 here, or too near to it", "")
        else:
            assert row is slope


def row_of(name: str, derivative: Any, elasticity: Any, reason: str = "", side: str = "") -> Sensitivity:
    knob: Any = SimpleNamespace(path=name, name=name)
    one, other = (None if n is None else exact(n) for n in (derivative, elasticity))
    return Sensitivity(knob, one, other, reason, side)


def test_a_frequency_without_any_derivative_has_one_reason_and_the_strongest_parameter_comes_first() -> None:
    rows = [
        row_of("a", 1, -3),
        row_of("b", None, None, "why"),
        row_of("c", 2, 2),
        row_of("d", 0, 0),
        row_of("e", -9, 5),
    ]
    assert [y.name for y in Sensitive(WHERE, tuple(rows)).ranked] == ["e", "a", "c", "b", "d"]
    assert Sensitive(WHERE, tuple(rows)).reason == ""
    assert Sensitive(WHERE, (rows[1], rows[1])).reason == "why"
    assert Sensitive(WHERE, (rows[1], row_of("f", None, None, "other"))).reason == ""
    assert Sensitive(WHERE, (rows[1], row_of("f", 1, 1, "why"))).reason == ""
    assert Sensitive(WHERE, ()).reason == ""
    assert Sensitive(WHERE, (row_of("f", 1, 1, "from above"),)).reason == ""


def test_at_an_end_of_the_band_a_frequency_is_seen_on_the_side_on_which_it_moves_inward() -> None:
    low, high = exact(1), exact(9)
    own: Any = SimpleNamespace(
        evaluation=SimpleNamespace(
            chart=SimpleNamespace(points=[SimpleNamespace(omega=y) for y in (low, exact(3), high)])
        )
    )
    for where, derivative, side in product((low, exact(3), high, exact(1)), (None, 0, 2, -2), ("", "above", "below")):
        row = row_of("a", derivative, derivative, side and f"from {side}", side)
        found = Sensitivities._in_band(own, row, where)
        if not derivative or not (where is low or where is high):
            assert found is row
            continue
        inward = "above" if (derivative > 0) == (where is low) else "below"
        other = "below" if inward == "above" else "above"
        if side == other:
            assert told(found) == (None, None, "undefined: it leaves the band", "")
        else:
            reason = row.reason or f"from {inward}; {other} it lies beyond the band"
            assert told(found) == (derivative, derivative, reason, inward)


def test_a_bandwidth_has_a_kink_where_more_than_one_thing_ends_it() -> None:
    first, middle, end, last = (exact(n) for n in (1, 3, 5, 9))
    touch, cross = CrossingKind.TOUCHES, CrossingKind.EXCEEDS
    ends = [SimpleNamespace(omega=y) for y in (first, last)]
    for undecided, kinds, at_end, where in product(
        (False, True), product((touch, cross), repeat=3), (0, 1, 2), (first, end, last)
    ):
        marks = (middle, where, exact(20))
        crossings = tuple(Sensitive(y, (), None, kind) for y, kind in zip(marks, kinds, strict=True))
        there = [Sensitive(where, (row_of("a", 1, 1),), None, cross)] * at_end
        evaluation = SimpleNamespace(undecided=(1,) * undecided, chart=SimpleNamespace(points=ends))
        own: Any = SimpleNamespace(evaluation=evaluation, crossings=crossings)
        found = Sensitivities._kink(own, where, there)
        if undecided:
            assert found.startswith("undecided: whether a ratio touches")
        elif touch in kinds[:2]:
            assert found == "undefined: the display touches its threshold within the bandwidth"
        elif at_end == 2:
            assert found == "undefined: both ratios meet their thresholds here"
        elif where is first:
            assert found == slopes.TOUCH
        elif where is last and at_end:
            assert found == "undefined: a ratio meets its threshold at the very end of the band"
        else:
            assert found == ""
            reasoned = [Sensitive(where, (row_of("a", None, None, "why"),), None, cross)]
            assert Sensitivities._kink(own, where, reasoned) == slopes.TOUCH


def test_two_frequencies_are_one_as_far_as_256_bits_go() -> None:
    near = exact(1 + Rational(1, 2**200))
    assert (_same(exact(1), exact(1)), _same(exact(1), near), _same(ExactNumber(pi), exact(Rational(22, 7)))) == (
        True,
        False,
        False,
    )
