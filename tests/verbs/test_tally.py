"""Roots on the right at one value after another: those that come and go against counts of their own at each value."""

from __future__ import annotations

import random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Expr, Integer, Rational, Symbol, exp

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.symbols import s
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.held import window_of
from haptisym.verbs.stability.curves import Gap, Meeting, Meetings
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.tally import Tally

E = hs.effects
q = Symbol("q", real=True)


def exact(x: int) -> ExactNumber:
    return ExactNumber(Integer(x))


class Counted(Loop):
    """A loop that knows how often it was asked for its roots."""

    asked = 0

    def at(self, value: Rational) -> object:  # type: ignore[override]
        Counted.asked += 1
        return super().at(value)


def loop_of(expression: Expr) -> Loop:
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Counted(ring, top, top.context().constant(1), q, Integer(0))


def late(draw: random.Random, *, delay: bool) -> Expr:
    """A mass on spring and damper, and what comes late: q before it, in it, or as its delay."""
    own = draw.choice([1, 2]) * s**2 + draw.randint(1, 9) * s + draw.randint(0, 90)
    back = draw.randint(20, 300) + draw.choice([0, 2, 5]) * s
    if delay:
        return own + back * exp(-s * q * draw.choice([1, 2]))
    wave = exp(-s * Rational(draw.randint(1, 9), 40))
    return draw.choice([own + q * wave, own + back * wave + q * s, own + back * wave + q, own + (back + q * s) * wave])


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(24))
def test_from_one_count_on_all_others_follow(seed: int) -> None:
    draw = random.Random(seed)
    loop = loop_of(late(draw, delay=seed % 3 == 0))

    class Free:
        value = Rational(1, 3)

    asked = Domain(Integer(0), Integer(60) if not loop.turns else Rational(2))
    window = window_of(loop, Free(), asked)  # type: ignore[arg-type]
    tally, alone = Tally(loop, window), Tally(loop)
    highest = float(asked.high or 0) if window.below is None else min(float(asked.high or 0), float(window.below))
    lowest = 0.0 if window.above is None else max(0.0, float(window.above))
    Counted.asked = 0
    values = [Rational(f"{draw.uniform(lowest, highest):.6g}") for _ in range(12)]
    found = [tally.at(x) for x in values]
    told = Counted.asked
    assert found == [alone.at(x) for x in values]
    if not window.gaps and all(x.sense is not None for x in window.found) and found[0][0] is not None:
        assert told == 1


def test_without_what_puts_roots_on_the_axis_each_value_is_counted() -> None:
    loop = loop_of(s**2 + 2 * s + 5 + q * exp(-s / 4))
    tally = Tally(loop, Meetings((), above=Integer(0), below=Integer(3)))
    Counted.asked = 0
    for value, asked in ((Integer(1), 1), (Integer(2), 1), (Integer(4), 2), (Integer(5), 3), (Integer(5), 3)):
        tally.at(value)
        assert Counted.asked == asked, value


@pytest.mark.slow
def test_windows_that_hold_the_same_meeting_count_it_once() -> None:
    """Of a stiffness behind a delay, asked about in windows that grow."""
    own = hs.Scene(hs.environments.kelvin_voigt("100 N/m", 2), (E.delay("36 ms"),))
    own = own.with_hands(hs.Hand("hand", m="0.5 kg", b=8, k=100))
    found = hs.require(own, "environment.k", that="stable", range=(0, 10**6))
    wide = hs.require(own, "environment.k", that="stable", range=(0, 400))
    assert float(found.feasible[0].high.value or 0) == pytest.approx(float(wide.feasible[0].high.value or 0))
    assert len(found.feasible) == 1


@pytest.mark.parametrize("seed", range(3))
def test_across_a_gap_or_what_goes_either_way_or_out_of_a_window_roots_are_counted_anew(seed: int) -> None:
    """At whole numbers roots come and go, some untold; at halves one counts: from there on told unless something is not known."""
    draw = random.Random(seed)
    asked: list[Rational] = []

    def number(x: Any) -> int:
        return 40 + sum(2 * sense for place, sense in senses.items() if place < x)

    for _ in range(60):
        senses = {place: draw.choice([-1, 0, 1]) for place in draw.sample(range(-8, 9), 6)}
        untold = set(draw.sample(sorted(senses), draw.choice([0, 0, 1])))
        found = tuple(Meeting(exact(x), exact(1), None if x in untold else n) for x, n in senses.items())
        a = draw.randint(-9, 8)
        ends = draw.choice([(None, a), (a, None), (a, a + draw.randint(1, 3))])
        gaps = () if draw.random() < 0.4 else (Gap(*(None if x is None else exact(x) for x in ends)),)
        above, below = draw.choice([(None, None), (-5, None), (None, 5), (-6, 6)])
        window = Meetings(found, above and Integer(above), below and Integer(below), gaps)
        loop: Any = SimpleNamespace(at=lambda x: (asked.append(x), Roots(number(x), number(x)))[1])
        tally, start, end = Tally(loop, window), *(Rational(draw.randint(-9, 8)) + Rational(1, 2) for _ in range(2))
        asked.clear()
        assert tally.at(start) == (number(start), None)
        assert asked == [start]
        assert tally.at(end) == (number(end), None)
        low, high = sorted((start, end))
        across = any(low < x < high for x in untold)
        outside = any((above is not None and x < above) or (below is not None and x > below) for x in (low, high))
        meets = bool(gaps) and (ends[0] is None or ends[0] < high) and (ends[1] is None or low < ends[1])
        assert (len(asked) == 2) == (start != end and (across or outside or meets))
        tally.at(start), tally.at(end)
        assert len(asked) <= 2


def test_a_value_at_which_roots_are_on_the_axis_is_counted_and_a_chain_is_not_remembered() -> None:
    asked: list[Any] = []
    loop: Any = SimpleNamespace(at=lambda x: (asked.append(x), Roots(None, None, (), RootChain.NEAR) if x > 4 else Roots(1, 0))[1])  # fmt: skip
    tally = Tally(loop, Meetings((Meeting(exact(1), exact(1), 1),)))
    assert [tally.at(Integer(x)) for x in (0, 1, 1, 5, 5)] == [(1, None)] * 3 + [(None, RootChain.NEAR)] * 2
    assert asked == [0, 1, 5, 5]
