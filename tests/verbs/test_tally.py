"""Roots on the right at one value after another: those that come and go against counts of their own at each value."""

from __future__ import annotations

import random

import pytest
from sympy import Expr, Integer, Rational, Symbol, exp

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.held import window_of
from haptisym.verbs.stability.curves import Meetings
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.tally import Tally

E = hs.effects
q = Symbol("q", real=True)


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
