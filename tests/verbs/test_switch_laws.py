"""Delays at which roots switch sides: frequencies and angles that are given, so that all of their turns are known one by one."""

from __future__ import annotations

import cmath
import random
from dataclasses import dataclass
from math import cos, pi, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, exp, lambdify
from sympy import pi as exact_pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import s
from haptisym.verbs.stability import switches
from haptisym.verbs.stability.curves import Meeting
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.switches import DelayAt, Switches, _first, _ratio, _turned

q = Symbol("q", positive=True)


def loop_of(expression: Expr) -> Loop:
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), q, Integer(0))


@dataclass(frozen=True)
class Fixed:
    """One value at all frequencies."""

    value: float

    def ball(self, _: Any) -> Any:
        return arb(self.value)


def delay_at(angle: float, omega: Any, multiple: Any = 1, turn: int = 0) -> DelayAt:
    """-A/B turns back by an angle: 0, or beyond -pi and up to pi."""
    parts: Any = (Fixed(cos(angle)), Fixed(-sin(angle)))
    return DelayAt(parts, ExactNumber(Integer(0) + omega), turn, Integer(0) + multiple, is_real=angle in (0, pi))


class Drawn:
    """Some frequencies, each with an angle and a sense: the switches, and their delays one by one."""

    def __init__(self, draw: random.Random) -> None:
        self.omegas = [Rational(x, 4) for x in draw.sample(range(3, 40), draw.randint(1, 4))]
        self.angles = [draw.choice([0.0, pi, draw.uniform(-3, 3), draw.uniform(-3, 3)]) for _ in self.omegas]
        self.multiple = draw.choice([Rational(1), Rational(2), Rational(1, 3)])
        order = sorted(range(len(self.omegas)), key=lambda i: -self.omegas[i])
        self.senses = [0] * len(order)
        for n, i in enumerate(order):  # the highest one to the right, and from there on one way and the other
            self.senses[i] = 1 - 2 * (n % 2)
        if draw.random() < 0.3:
            self.senses[order[-1]] = 0
        firsts = [_first(delay_at(a, x, self.multiple)) for a, x in zip(self.angles, self.omegas, strict=True)]
        self.switches = Switches((*firsts,), (*self.senses,), is_still=True)
        self.rates = [float(x * self.multiple) for x in self.omegas]
        self.begins = [a % (2 * pi) / rate for a, rate in zip(self.angles, self.rates, strict=True)]

    def delays(self, i: int, count: int) -> list[float]:
        return [self.begins[i] + 2 * pi * n / self.rates[i] for n in range(count)]

    def passed(self, value: float) -> int:
        """The sum of senses of all delays up to one."""
        return sum(sense * sum(x <= value for x in self.delays(i, 400)) for i, sense in enumerate(self.senses))


@pytest.mark.parametrize("seed", range(4))
def test_how_many_have_come_is_the_sum_of_the_senses_of_all_delays_up_to_one(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(6):
        own = Drawn(draw)
        for value in [draw.uniform(0, 20) for _ in range(6)]:
            if min(abs(value - x) for i in range(len(own.omegas)) for x in own.delays(i, 40)) > 1e-9:
                assert own.switches.come(ExactNumber(Rational(value))) == own.passed(value)
        for i, first in enumerate(own.switches.firsts):
            for turn in (0, 1, 5):
                delay = DelayAt(first.ratio, first.omega, first.turn + turn, first.multiple, is_real=first.is_real)
                at = own.delays(i, 6)[turn]
                assert float(delay) == pytest.approx(at, rel=1e-12, abs=1e-12)
                near = min(
                    (abs(at - x) for j in range(len(own.omegas)) if j != i for x in own.delays(j, 99)), default=1
                )
                if near > 1e-9:
                    assert own.switches.come(delay) == own.passed(at + 1e-10)


def test_of_a_delay_that_a_number_may_be_what_comes_is_not_counted_and_what_goes_is() -> None:
    """At pi rad/s an angle of pi: delays of 1, 3, 5 s, which no ball tells from these numbers."""
    for sense, come in ((1, [0, 0, 1, 1, 2, 2]), (-1, [0, -1, -1, -2, -2, -2])):
        own = Switches((_first(delay_at(pi, exact_pi)),), (sense,), is_still=True)
        values = [Rational(n, 2) for n in (1, 2, 3, 6, 7, 9)]
        assert [own.come(ExactNumber(x)) for x in values] == come
        assert own.come(ExactNumber(Integer(-7))) == 0
        theirs = DelayAt(own.firsts[0].ratio, own.firsts[0].omega, 3, Integer(1), is_real=True)
        assert own.come(theirs) == 3 * sense  # that is one of them
        twice = Switches((own.firsts[0], own.firsts[0]), (sense, sense), is_still=True)
        assert twice.come(theirs) == (4 if sense > 0 else -6)  # it may be the other's


@pytest.mark.parametrize("seed", range(2))
def test_beyond_a_delay_more_roots_have_come_than_gone_for_ever(seed: int) -> None:
    """(omega tau - theta)/(2 pi) at least have come, theta the angle of the first, and one more at most."""
    draw = random.Random(seed)
    for _ in range(12):
        own = Drawn(draw)
        found = own.switches.unstable_from
        slope = sum(x * rate for x, rate in zip(own.senses, own.rates, strict=True))
        if slope <= 0:
            assert found is None
            continue
        assert found is not None
        lost = 0.0
        for i, sense in enumerate(own.senses):
            angle = own.begins[i] * own.rates[i]
            lost += sense * (angle if angle > 1e-9 or sense < 0 else 2 * pi) + 2 * pi * (sense < 0)
        assert lost / slope <= float(found) < lost / slope * (1 + 1e-8) + 1e-10
        for n in range(60):
            assert own.passed(float(found) + 1e-9 + n * 0.2) >= 1
    assert Switches((), (), is_still=True).unstable_from is None
    assert Switches(own.switches.firsts, own.switches.senses, is_still=False).unstable_from is None


@pytest.mark.parametrize("still", [True, False])
def test_all_turns_up_to_some_beyond_a_value_are_told_with_their_sense_if_nothing_moves_at_0(*, still: bool) -> None:
    draw = random.Random(5)
    for _ in range(8):
        own = Drawn(draw)
        given = Switches(own.switches.firsts, own.switches.senses, is_still=still)
        value = Rational(draw.randint(0, 40), 4)
        found, last = given.up_to(value)
        assert last is not None
        assert last > value
        expected = []
        for i, sense in enumerate(own.senses):
            for x in own.delays(i, 400):
                if x < float(last):
                    told = None if not still or x == 0 else sense
                    expected.append((round(x, 9), round(float(own.omegas[i]), 9), told))
        mine = [
            (round(float(x.value), 9), round(float(x.omega or 0), 9), x.sense)
            for x in found if float(x.value) < float(last)
        ]  # fmt: skip
        assert sorted(mine, key=str) == sorted(expected, key=str)
        assert all(x.value == ExactNumber(Integer(0)) for x in found if abs(float(x.value)) < 1e-12)
    assert Switches((), (), is_still=True).up_to(Integer(3)) == ((), None)


@pytest.mark.parametrize(("last", "rate", "value", "expected"), [
    (None, 1, 3, 3), (Rational(9), 1, 3, 9), (Rational(2), 1, 3, 3),
    (Rational(9), 220, 3, 3), (Rational(9), 205, 3, 9), (Rational(9), 219, 30, 30),
])  # fmt: skip
def test_one_looks_as_far_as_all_that_comes_after_is_told_if_not_too_many_come_on_the_way(
    last: Rational | None, rate: int, value: int, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """9 s at 205 rad/s are less than 300 turns, at 220 rad/s more: of two frequencies together, as here."""
    monkeypatch.setattr(Switches, "unstable_from", last)
    own = Switches((delay_at(1.0, Rational(rate, 4)), delay_at(2.0, Rational(3 * rate, 8), 2)), (1, -1), is_still=True)
    assert own._end(Integer(value)) == expected


def test_a_delay_is_taken_a_turn_later_where_it_would_be_negative_and_no_turn_is_told_before_0() -> None:
    for angle, turn in ((-1.0, 1), (-3.0, 1), (0.0, 0), (2.0, 0), (pi, 1)):
        first = _first(delay_at(angle, 3))
        assert first.turn == turn
        assert 0 <= float(first) < 2 * pi / 3
    omega = ExactNumber(Integer(3))
    for angle, begin in ((2.0, 2.0), (0.0, 0.0), (-1.0, -1.0)):
        found = [*_turned(delay_at(angle, 3), 2, 1)]
        true = [(begin + 2 * pi * n) / 3 for n in range(3) if begin + 2 * pi * n >= 0]
        assert [float(x.value) for x in found] == pytest.approx(true, abs=1e-12)
        assert [x.omega for x in found] == [omega] * len(true)
        assert [x.sense for x in found] == [None if angle == 0 and n == 0 else 1 for n in range(len(true))]
    assert next(_turned(delay_at(0.0, 3), 2, 1)) == Meeting(ExactNumber(Integer(0)), omega)


# Of loops


@pytest.mark.parametrize("seed", range(6))
def test_frequencies_and_senses_are_those_at_which_one_term_grows_through_the_size_of_the_other(seed: int) -> None:
    """A = s^2 + a s + b, B = c s + d: |A|^2 - |B|^2 by NumPy, its slope, and the angle of -B/A."""
    draw = random.Random(seed)
    for _ in range(2):
        a, b, c, d = (
            draw.randint(0, 3),
            draw.randint(0, 40),
            draw.randint(0, 3),
            draw.choice([-1, 1]) * draw.randint(1, 40),
        )
        if draw.random() < 0.3:
            a = c = 0
        multiple = draw.choice([1, 2])
        A, B = s**2 + a * s + b, c * s + Integer(d)
        own = Switches.of(loop_of(A + B * exp(-s * multiple * q)))
        even = np.array([1, a * a - 2 * b - c * c, b * b - d * d], float)
        squares = sorted(x.real for x in np.roots(even) if abs(x.imag) < 1e-9 and x.real > 1e-9)
        at = [cmath.sqrt(x).real for x in squares]
        assert [float(x.omega) for x in own.firsts] == pytest.approx(at)
        assert own.is_still is (b * b != d * d)
        assert own.senses == tuple(int(np.sign(2 * x + even[1])) if abs(2 * x + even[1]) > 1e-9 else 0 for x in squares)
        f, g = lambdify(s, A), lambdify(s, B)
        for x, w in zip(own.firsts, at, strict=True):
            angle = cmath.phase(-g(1j * w) / f(1j * w)) % (2 * pi)
            real = a == c == 0
            assert x.is_real is real
            assert float(x) == pytest.approx(angle / (w * multiple), rel=1e-9, abs=1e-9)


def test_a_touch_goes_neither_way_and_what_grows_and_falls_for_ever_has_no_last_frequency(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """|s^2 + 3 s/2 + 5|^2 - |s/2 + 3|^2 = (omega^2 - 4)^2 on the axis."""
    touch = Switches.of(loop_of(s**2 + s * Rational(3, 2) + 5 + (s / 2 + 3) * exp(-s * q)))
    assert ([float(x.omega) for x in touch.firsts], touch.senses, touch.is_still) == ([2.0], (0,), True)
    assert touch.unstable_from is None
    assert next(x.sense for x in touch.up_to(Integer(1))[0]) == 0
    with pytest.raises(UndecidedError, match="where roots meet"):
        Switches.of(loop_of(s * (1 + exp(-s)) + s * exp(-s * q)))
    below = Switches.of(loop_of(3 * s + 1 + (4 * s + 9) * exp(-s * q)))  # |A| < |B| everywhere
    assert below == Switches((), (), is_still=True)
    point = SimpleNamespace(undecided={""}, orders={})
    monkeypatch.setattr(
        switches, "chart", lambda *_: SimpleNamespace(points=(SimpleNamespace(undecided=set(), orders={}), point))
    )
    with pytest.raises(UndecidedError, match="touches the imaginary axis"):
        Switches.of(loop_of(s**2 + s + 9 + 3 * exp(-s * q)))


@pytest.mark.parametrize("lag", [q, 2 * q, q / 3, q * exact_pi])
@pytest.mark.parametrize("more", [Integer(1), exp(-s / 5), exp(-s * Rational(3, 10))])
def test_both_terms_and_the_multiple_of_the_delay_are_those_of_the_loop(lag: Expr, more: Expr) -> None:
    A, B = s**2 + 3 * s * more + 5, (2 * s + 7) * more
    ratio, multiple = _ratio(loop_of((A + B * exp(-s * lag)).expand()))
    assert multiple == lag / q
    for at in (Rational(1, 2), Rational(2), Rational(7, 3)):
        told = ratio.ring.expression(ratio.numerator) / ratio.ring.expression(ratio.denominator)
        assert abs(float(told.subs(s, at)) + float((A / B).subs(s, at))) < 1e-12


@pytest.mark.parametrize(
    ("expression", "reason"),
    [
        (s**2 + exp(-s * q) + exp(-s * q * exact_pi) + 3, "in several delays"),
        (s**2 + s**q + exp(-s * q) + 3, "in several delays"),
        (s**2 + s**q + 3, "in several delays"),
        (s**2 + exp(-s * q) + exp(-2 * s * q) + 3, "comes back"),
        (s**2 + q * s + exp(-s * q) + 3, "comes back"),
        (s**2 + s + q * exp(-2 * s * q) + 3, "comes back"),
    ],
)
def test_a_number_in_other_places_too_is_told_as_such(expression: Expr, reason: str) -> None:
    with pytest.raises(UndecidedError, match=reason):
        _ratio(loop_of(expression))
