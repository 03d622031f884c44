"""From meetings to critical values: whatever lies between gaps, what is told is where the number of roots changes next."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import product
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Integer, Rational, Symbol, exp, lambdify, pi
from windings import winding

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.symbols import s
from haptisym.model.parameters import Rule
from haptisym.verbs.require.held import _wider as wider
from haptisym.verbs.stability import critical
from haptisym.verbs.stability.curves import Gap, Meeting, Meetings
from haptisym.verbs.stability.loops import ALLOWED, Loop

q = Symbol("q", positive=True)


def exact(value: int) -> ExactNumber:
    return ExactNumber(Integer(value))


@pytest.mark.parametrize("seed", range(30))
def test_the_nearest_change_is_told_unless_it_may_lie_in_a_gap(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Places at whole numbers, at some of which a count changes; those inside of a gap are hidden."""
    draw = random.Random(seed)
    changes = {place: draw.choice([-2, 0, 2]) for place in draw.sample(range(-9, 10), 8)}
    a = draw.choice([-6, -5, 2, 3])
    gaps = [] if seed % 3 == 0 else [(a, a + draw.randint(1, 4))]
    start = Rational(draw.choice([-1, 1, 3]), 2)
    hidden = {x for low, high in gaps for x in changes if low < x < high}

    def at(value: Any) -> Roots:
        number = 40 + sum(change for place, change in changes.items() if place < value)
        return Roots(number, number)

    def meetings(*_: Any) -> list[Meetings]:
        found = tuple(Meeting(exact(x), exact(1)) for x in changes if x not in hidden)
        return [Meetings(found, gaps=tuple(Gap(exact(low), exact(high)) for low, high in gaps))]

    monkeypatch.setattr(critical, "meetings", meetings)
    free: Any = SimpleNamespace(path="q", value=start, rule=Rule.ANY)
    loop: Any = SimpleNamespace(at=at, turns=False)
    told = critical._Walk(loop, free).nearest()
    for side in (-1, 1):
        ahead = sorted((x for x in changes if (x - start) * side > 0), key=lambda x: abs(x - start))
        true = next((x for x in ahead if changes[x]), None)
        first = min((abs(x - start) for gap in gaps for x in gap if (x - start) * side > 0), default=None)
        clear = true is not None and (first is None or abs(true - start) < first)
        row = next((x for x in told.found if (float(x.value) > start) == (side > 0)), None)
        assert (row is not None) == clear or (row is not None and true == float(row.value))
        if row is not None:
            assert (float(row.value), row.below, row.above) == (true, at(true).number, at(true + Rational(1, 2)).number)
        elif first is not None:
            assert told.reason


class World:
    """Values at which the count of roots changes, as it is between them and right there; endless counts have a chain."""

    def __init__(self, draw: random.Random, rule: Rule) -> None:
        self.low, self.high, self.closed = ALLOWED[rule]
        chosen = sorted(draw.sample(range(-3, 16), draw.randint(1, 7)))
        self.places = [Rational(x, 16) if rule is Rule.FRACTION else Rational(x) for x in chosen]
        self.between = [draw.choice([0, 0, 1, 2, None]) for _ in range(len(chosen) + 1)]
        self.right_there = [draw.choice([0, 1, 2]) for _ in chosen]

    def at(self, value: Any) -> Roots:
        below = sum(bool(x < value) for x in self.places)
        number = self.right_there[below] if value in self.places else self.between[below]
        return Roots(number, number, chain=RootChain.RIGHT if number is None else None)

    def allows(self, value: Any) -> bool:
        """Whether it lies inside of what is allowed."""
        return (self.low is None or value > self.low) and (self.high is None or value < self.high)

    def is_end(self, value: Any) -> bool:
        return value in (self.low, self.high)

    def sides(self, i: int) -> tuple[int | None, int | None] | None:
        """The counts on both sides of a place; at an end that is allowed the one right there; None if nothing is there."""
        value = self.places[i]
        below, above = self.between[i], self.between[i + 1]
        if self.is_end(value):
            if not self.closed:
                return None
            return (self.right_there[i], above) if value == self.low else (below, self.right_there[i])
        return below, above


def windows_about(draw: random.Random, world: World, start: Any) -> list[Meetings]:
    """Ever wider ones, some of which end at a place, at what is allowed or beyond it; further out some places are listed, and others not."""
    unit = Rational(1, 16) if world.high is not None else Rational(1)
    found, low, high = [], start - unit / 4, start + unit / 4
    for _ in range(draw.randint(1, 4)):
        low, high = low - draw.randint(0, 6) * unit / 4, high + draw.randint(0, 6) * unit / 4
        ends = [None if x is None or draw.random() < 0.15 else x for x in (low, high)]
        told = [
            x for x in world.places
            if ((ends[0] is None or x > ends[0]) and (ends[1] is None or x < ends[1])) or draw.random() < 0.5
        ]  # fmt: skip
        draw.shuffle(told)
        found.append(Meetings(tuple(Meeting(ExactNumber(x), exact(1)) for x in told), *ends))
        low, high = (
            new if kept is not None else Integer(side * 99)
            for new, kept, side in ((low, ends[0], -1), (high, ends[1], 1))
        )
    return found


@pytest.mark.few(19)
@pytest.mark.parametrize("rule", ALLOWED)
@pytest.mark.parametrize("group", range(10))
def test_of_windows_that_grow_each_tells_what_lies_inside_of_it_and_nothing_beyond(
    group: int, rule: Rule, monkeypatch: pytest.MonkeyPatch
) -> None:
    for seed in range(20 * group, 20 * group + 20):
        draw = random.Random(f"{rule} {seed}")
        world = World(draw, rule)
        inside = [x for x in world.places if world.allows(x) or (world.closed and world.is_end(x))]
        half = Rational(draw.randint(0, 12) * 2 + 1, 32 if world.high is not None else 2)
        start = draw.choice(inside) if inside and draw.random() < 0.3 else half
        given, breaks = windows_about(draw, world, start), draw.random() < 0.3

        def meetings(*_: Any, given: list[Meetings] = given, breaks: bool = breaks) -> Iterator[Meetings]:
            yield from given
            if breaks:
                raise UndecidedError("the rest")

        monkeypatch.setattr(critical, "meetings", meetings)
        free: Any = SimpleNamespace(path="q", value=start, rule=rule)
        loop: Any = SimpleNamespace(at=world.at, turns=draw.random() < 0.3)
        expected, is_settled = known_of(world, start, given)
        if breaks and not is_settled and not any(expected):
            with pytest.raises(UndecidedError, match="the rest"):
                critical._Walk(loop, free).nearest()
            continue
        told = critical._Walk(loop, free).nearest()
        assert [(x.value.value, x.below, x.above) for x in told.found] == [x for x in expected if x]  # type: ignore[attr-defined]
        assert bool(told.reason) is not is_settled
        assert is_settled or told.reason == ("the rest" if breaks else critical._ENDLESS)
        for x in told.found:
            has_chain, at_end = None in (x.below, x.above), world.is_end(x.value.value)  # type: ignore[attr-defined]
            assert x.chain_side == (("above" if x.above is None else "below") if has_chain else None)
            stable = "above" if x.above == 0 else "below" if x.below == 0 else None
            assert x.stable_side == (None if has_chain and (loop.turns or at_end) else stable)


Row = tuple[Any, int | None, int | None]


def known_of(world: World, start: Any, given: list[Meetings]) -> tuple[list[Row | None], bool]:
    """What windows tell of both sides, or of the start itself, and whether that is all there is to tell."""
    if start in world.places:
        i = world.places.index(start)
        both = world.sides(i)
        if both is not None and both[0] != both[1]:
            return [(start, *both)], True
    rows: list[Row | None] = []
    settled = 0
    for side in (-1, 1):
        ahead = [i for i, x in enumerate(world.places) if (x - start) * side > 0]
        changes = [
            (world.places[i], *both) for i in ahead[::side]
            if (world.allows(world.places[i]) or world.is_end(world.places[i]))
            and (both := world.sides(i)) is not None and both[0] != both[1]
        ]  # fmt: skip
        ends = [x.above if side < 0 else x.below for x in given]
        limit = world.low if side < 0 else world.high
        reached = [
            bool(changes) and (end is None or (changes[0][0] - end) * side < 0 or changes[0][0] == limit == end)
            for end in ends
        ]
        whole = [end is None or (limit is not None and (end - limit) * side >= 0) for end in ends]
        rows.append(changes[0] if any(reached) else None)
        settled += any(reached) or any(whole)
    return rows, settled == 2


def test_beside_a_critical_value_at_the_end_of_a_window_the_count_is_that_beside_it() -> None:
    """q s^2 + s + (1 + 15 s/8) exp(-s pi/2) is 0 at s = j for q = 15/8, which is 15/16 of the value 2; at 0 there is a chain."""
    expression = q * s**2 + s + (1 + Rational(15, 8) * s) * exp(-s * pi / 2)
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    loop = Loop(ring, top, ring.constant(1), q, Integer(0))
    free: Any = SimpleNamespace(path="q", value=Integer(2), rule=Rule.NONNEGATIVE)
    [row] = critical._Walk(loop, free).nearest().found
    assert (float(row.value), row.below, row.above, row.stable_side) == (1.875, 2, 0, "above")
    f = lambdify((s, q), expression, "numpy")
    assert [winding(lambda x, at=at: f(x, at), 60.0) for at in (1.85, 1.9)] == [2, 0]


@pytest.mark.parametrize("ends", [(2, 5), (2, None), (-7, -3), (None, -3), (-3, 4), (0, 4)])
@pytest.mark.parametrize("why", ["", "why"])
@pytest.mark.parametrize("chain", [False, True])
def test_beside_a_gap_that_may_have_no_end_its_reason_and_ends_are_told(
    ends: tuple[int | None, int | None], why: str, monkeypatch: pytest.MonkeyPatch, *, chain: bool
) -> None:
    """A place in the middle of the gap, or at the start itself, and two places further out; perhaps a chain before the gap's first end."""
    low, high = (None if x is None else exact(x) for x in ends)
    gap = Gap(low, high, why)
    start = Integer(0)
    count = {-20: (3, 3), -10: (1, 1), 10: (0, 0), 20: (5, 5)}

    def at(value: Any) -> Roots:
        if chain and ends == (0, 4) and 4 < value < 10:
            return Roots(None, None, chain=RootChain.RIGHT)
        number = 7 + sum(1 for x in count if x < value)
        return Roots(number, number)

    found = tuple(Meeting(exact(x), exact(1)) for x in count)
    here = (Meeting(exact(0), None),) if chain else ()
    monkeypatch.setattr(critical, "meetings", lambda *_: [Meetings((*found, *here), gaps=(gap,))])
    free: Any = SimpleNamespace(path="q", value=start, rule=Rule.ANY)
    told = critical._Walk(SimpleNamespace(at=at, turns=False), free).nearest()  # type: ignore[arg-type]
    values = [float(x.value) for x in told.found]
    if chain and ends == (0, 4):  # it begins with the gap: the first count that is known beyond it is told
        assert (values, told.reason) == ([0.0], "")
        assert (told.found[0].below, told.found[0].above, told.found[0].stable_side) == (9, None, None)
        return
    words = why or critical._ENDLESS
    where = {(2, 5): "from 2.0000000 to 5.0000000", (2, None): "beyond 2.0000000", (-7, -3): "from -7.0000000 to -3.0000000",
             (None, -3): "below -3.0000000", (-3, 4): "from -3.0000000 to 4.0000000", (0, 4): "from 0 to 4.0000000"}[ends]  # fmt: skip
    assert told.reason == f"{words}, {where}"
    assert values == {2: [-10.0], -7: [10.0], None: [10.0], -3: [], 0: [-10.0]}[ends[0]]


def test_two_windows_that_overlap_are_one_that_holds_each_meeting_once() -> None:
    """At some values one root, at others two, or one from infinity; windows between any two, about 3."""
    every = [(1, 1), (1, 2), (2, None), (Rational(5, 2), 2), (3, None), (3, 1), (Rational(7, 2), 1), (5, 2)]

    def told(low: int | None, high: int | None) -> Meetings:
        inside = [(x, w) for x, w in every if (low is None or low < x) and (high is None or x < high)]
        found = (Meeting(ExactNumber(Rational(x)), None if w is None else ExactNumber(Integer(w))) for x, w in inside)
        return Meetings(tuple(found), *(None if x is None else Integer(x) for x in (low, high)))

    windows = list(product((None, 0, 2), (None, 4, 6)))
    for one, other in product(windows, repeat=2):
        lows, highs = (
            (None if None in x else own(x)) for x, own in zip(zip(one, other, strict=True), (min, max), strict=True)
        )
        found, whole = wider(told(*one), told(*other)), told(lows, highs)
        assert (found.above, found.below) == (whole.above, whole.below)
        pairs = [[(float(x.value), x.omega and float(x.omega)) for x in y.found] for y in (found, whole)]
        assert sorted(pairs[0], key=str) == sorted(pairs[1], key=str)
