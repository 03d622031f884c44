"""The nearest changes of a count beside gaps, chains and counts that stay open: against what follows cell by cell."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb
from sympy import Integer, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import critical
from haptisym.verbs.stability.clockrange import Passages
from haptisym.verbs.stability.clockvalues import Passage
from haptisym.verbs.stability.critical import Critical, Nearest
from haptisym.verbs.stability.curves import Gap, Meeting, Meetings

Count = tuple[Any, Any]
OPEN = "the count of a cell"
RIGHT = (None, RootChain.RIGHT)


def exact(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


class World:
    """Places at whole numbers; of each cell between two its count, or that it stays open, and the gap in which it lies."""

    def __init__(self, draw: random.Random) -> None:
        self.places = sorted(draw.sample(range(-6, 7), draw.randint(1, 5)))
        size = len(self.places) + 1
        self.counts: list[Count | None] = [
            draw.choice([(0, None), (0, None), (2, None), (1, None), RIGHT, RIGHT, None]) for _ in range(size)
        ]
        self.gaps: list[tuple[int, int, str]] = []
        first = 0
        while first < size:
            last = first + draw.choice([0, 0, 0, 1])
            if draw.random() < 0.3 and last < size:
                self.gaps.append((first, last, draw.choice(["", "why"])))
                first = last + 1
            first += 1
        self.turns = draw.random() < 0.3

    def at(self, value: Any) -> Roots:
        found = self.counts[sum(bool(x < value) for x in self.places)]
        if found is None:
            raise UndecidedError(OPEN)
        return Roots(found[0], found[0], chain=found[1])

    def ends(self, i: int) -> tuple[int | None, int | None]:
        return (self.places[i - 1] if i else None), (self.places[i] if i < len(self.places) else None)

    def window(self) -> Meetings:
        gaps = []
        for first, last, why in self.gaps:
            low, high = self.ends(first)[0], self.ends(last)[1]
            gaps.append(Gap(None if low is None else exact(low), None if high is None else exact(high), why))
        return Meetings(tuple(Meeting(exact(x), exact(1)) for x in self.places), gaps=tuple(gaps))

    def gap(self, i: int) -> str | None:
        """Of the gap in which a cell lies what is said."""
        for first, last, why in self.gaps:
            if first <= i <= last:
                low, high = self.ends(first)[0], self.ends(last)[1]
                a, b = (None if x is None else exact(x).digits(8) for x in (low, high))
                where = f"below {b}" if a is None else f"beyond {a}" if b is None else f"from {a} to {b}"
                return f"{why or critical._ENDLESS}, {where}" if a or b else why or critical._ENDLESS
        return None


class OpenError(Exception):
    """A count that is needed stays open."""


def told(world: World, i: int) -> Count:
    found = world.counts[i]
    if found is None:
        raise OpenError
    return found


def from_a_gap_on(world: World, i: int, side: int) -> Count:
    """The first cell outside of gaps whose count is known, on one side; else the one in the gap."""
    while 0 <= i < len(world.counts):
        if world.gap(i) is None and world.counts[i] is not None:
            return told(world, i)
        i += side
    raise OpenError


def seen(world: World, i: int, side: int) -> Count:
    if world.gap(i) is None:
        return told(world, i)
    try:
        return from_a_gap_on(world, i, side)
    except OpenError:
        return told(world, i)


def row_of(world: World, i: int, below: Count, above: Count) -> Critical:
    chain = None in (below[0], above[0])
    alone = [c[0] is not None and world.gap(k) is not None for c, k in ((below, i), (above, i + 1))]
    return Critical("q", exact(world.places[i]), exact(1), below[0], above[0], chain and (world.turns or any(alone)))


def on_a_side(world: World, start: Rational, side: int) -> Critical | str | None:
    """What comes first on one side: a change, a gap that may hold one (its words), or nothing."""
    home_cell = sum(bool(x < start) for x in world.places) + (side > 0 and start in world.places)
    if (words := world.gap(home_cell)) is not None:
        return words
    steps = range(home_cell, len(world.places)) if side > 0 else range(home_cell - 1, -1, -1)
    home = told(world, home_cell) if steps else None
    for i in steps:
        beyond = i + 1 if side > 0 else i
        words = world.gap(beyond)
        assert home is not None
        if words is not None and home[1] is None:
            return words
        other = seen(world, beyond, side)
        if other != home:
            below, above = (home, other) if side > 0 else (other, home)
            return row_of(world, i, below, above)
        if words is not None:
            return words
    return None


def known_of(world: World, start: Rational) -> Nearest | None:
    """All that is told; None where a count that is needed first stays open."""
    if start in world.places:
        i = world.places.index(start)
        below, above = seen(world, i, -1), seen(world, i + 1, 1)
        near_a_gap = world.gap(i) is not None or world.gap(i + 1) is not None
        if below != above and not (near_a_gap and below[1] is None and above[1] is None):
            return Nearest("q", (row_of(world, i, below, above),))
    found: list[Critical] = []
    reasons: list[str] = []
    for side in (-1, 1):
        try:
            x = on_a_side(world, start, side)
        except OpenError:
            if not found:
                raise
            return Nearest("q", tuple(found), OPEN)
        found += [x] if isinstance(x, Critical) else []
        reasons += [x] if isinstance(x, str) else []
    return Nearest("q", tuple(found), "; ".join(dict.fromkeys(reasons)))


@pytest.mark.parametrize("group", range(8))
def test_beside_gaps_chains_and_open_counts_what_comes_first_on_either_side_is_told(
    group: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    kinds = set[object]()
    for seed in range(60 * group, 60 * group + 60):
        draw = random.Random(seed)
        world = World(draw)
        start = (
            Rational(draw.choice(world.places)) if draw.random() < 0.4 else Rational(draw.randint(-13, 13) * 2 + 1, 4)
        )
        monkeypatch.setattr(critical, "meetings", lambda *_, world=world: [world.window()])
        free: Any = SimpleNamespace(path="q", value=start, rule=Rule.ANY)
        walk = critical._Walk(SimpleNamespace(at=world.at, turns=world.turns), free)  # type: ignore[arg-type]
        try:
            expected = known_of(world, start)
        except OpenError:
            with pytest.raises(UndecidedError, match=OPEN):
                walk.nearest()
            kinds.add("open")
            continue
        assert walk.nearest() == expected, (seed, world.places, world.counts, world.gaps, start)
        assert expected is not None
        kinds |= {(bool(expected.reason), x.is_crowded) for x in expected.found}
    assert len(kinds) >= 3


class Nowhere(RealNumber):
    """A number of which no ball tells where it is."""

    def ball(self, bits: int) -> Any:
        return arb("nan")


def test_a_value_that_no_ball_tells_is_no_place(monkeypatch: pytest.MonkeyPatch) -> None:
    found = (Meeting(Nowhere(), exact(1)), Meeting(exact(3), exact(2)), Meeting(Nowhere(), None))
    monkeypatch.setattr(critical, "meetings", lambda *_: [Meetings(found)])
    free: Any = SimpleNamespace(path="q", value=Rational(1), rule=Rule.POSITIVE)
    at = lambda x: Roots(int(bool(x > 3)), 0)  # noqa: E731
    told = critical._Walk(SimpleNamespace(at=at, turns=False), free).nearest()  # type: ignore[arg-type]
    assert told == Nearest("q", (Critical("q", exact(3), exact(2), 0, 1),))


def test_of_a_gap_without_ends_the_reason_alone_is_told() -> None:
    """It had ended with "below", and no number."""
    assert critical._crowded(Gap(None, None, "why")) == "why"
    assert critical._crowded(Gap(None, None)) == critical._ENDLESS
    assert critical._crowded(Gap(None, exact(0), "why")) == "why, below 0"


def test_of_the_ends_of_a_window_and_of_what_is_allowed_the_one_that_comes_first_counts() -> None:
    ends = [None, *map(Integer, (1, 2, 3))]
    for window, allowed, side in product(ends, ends, (-1, 1)):
        found, whole = critical._nearer(window, allowed, side)
        known = [x for x in (window, allowed) if x is not None]
        first = (min(known) if side > 0 else max(known)) if known else None
        assert found == (None if first is None else exact(first))
        assert whole is (window is None or (allowed is not None and allowed == first))


@pytest.mark.parametrize("crowded", [False, True])
def test_the_stable_side_has_no_roots_and_that_of_a_chain_infinitely_many(*, crowded: bool) -> None:
    for below, above in product((0, 1, 2, None), repeat=2):
        row = Critical("q", exact(1), None, below, above, crowded)
        assert row.chain_side == ("above" if above is None else "below" if below is None else None)
        stable = "above" if above == 0 else "below" if below == 0 else None
        assert row.stable_side == (None if crowded else stable)
    assert Critical("q", exact(1), None, 1, 0).is_crowded is False
    assert Critical("q", exact(Fraction(1, 3)), None, 1, 0)._line() == "q = 0.333333"


def test_with_a_clock_changes_are_passages_and_what_stays_open_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    free: Any = SimpleNamespace(path="q", value=Rational(2), rule=Rule.POSITIVE)
    rows = (Passage(exact(1), exact(4), 0, 2), Passage(exact(3), exact(5), 2, 3))
    own: Any = SimpleNamespace()
    monkeypatch.setattr(critical, "clocks", lambda _: ("one",))
    monkeypatch.setattr(critical, "passages", lambda *_: Passages(rows, Fraction(1), Fraction(9)))
    expected = (Critical("q", exact(1), exact(4), 0, 2), Critical("q", exact(3), exact(5), 2, 3))
    assert critical.critical(own, own, free) == Nearest("q", expected, low=Fraction(1), high=Fraction(9))

    def fails(*_: Any) -> Any:
        raise UndecidedError("why")

    monkeypatch.setattr(critical, "passages", fails)
    assert critical.critical(own, own, free) == Nearest("q", reason="why")
    monkeypatch.setattr(critical, "clocks", lambda _: ())
    monkeypatch.setattr(critical, "meetings", lambda *_: [Meetings((Meeting(exact(5), exact(7)),))])
    loop = SimpleNamespace(at=lambda x: Roots(int(bool(x > 5)), 0), turns=False)
    monkeypatch.setattr(critical, "Loop", SimpleNamespace(of=lambda *_: loop))
    assert critical.critical(own, own, free).found == (Critical("q", exact(5), exact(7), 0, 1),)
