"""Values that a loop with a clock has at the unit circle, closed in on: against mpmath, and with few looks."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import flint
import mpmath
import pytest
from flint import arb

from haptisym.verbs.stability.clockvalues import CriticalValue, Swing


class Asked:
    """A test that knows how often it was asked; its angle is an arc cosine and its period a third of the number."""

    def __init__(self, f: Any) -> None:
        self.f, self.asked = f, 0

    def tests(self, q: Any) -> tuple[Any, ...]:
        self.asked += 1
        return arb("nan"), self.f(q), arb("nan")

    def angle(self, q: Any, bits: int) -> Any:
        assert q.rel_accuracy_bits() >= bits
        return (1 / q).acos()

    def period(self, q: Any) -> Any:
        return q / 3


@pytest.mark.parametrize("square", [2, 7, 90])
@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("slope", [-5, Fraction(1, 1000), 10**6])
def test_a_zero_on_either_side_of_0_is_had_to_any_bits_in_few_looks(square: int, sign: int, slope: Any) -> None:
    """slope (x - root) (1 + (x - root)/1000), nearly straight between values whose signs differ."""

    def f(q: Any) -> Any:
        off = q - sign * arb(square).sqrt()
        return off * (1 + off / 1000) * slope.numerator / slope.denominator

    root = sign * square**0.5
    value = CriticalValue(loop := Asked(f), 1, Fraction(int(root * 100) - 1, 100), Fraction(int(root * 100) + 2, 100))
    for bits in (40, 400):
        loop.asked = 0
        ball = value.ball(bits)
        with flint.ctx.workprec(1000):
            true = sign * arb(square).sqrt()
            assert ball.contains(true)
            assert ball.rad() < abs(true) * arb(2) ** (2 - bits)
        assert 2 < loop.asked < 60
        asked = loop.asked
        assert value.ball(bits) is ball
        assert loop.asked == asked
    with mpmath.workdps(60):
        assert value.digits(50) == mpmath.nstr(sign * mpmath.sqrt(square), 50, strip_zeros=False)


@pytest.mark.parametrize("bend", [1, 30, 1000])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_zero_of_what_is_bent_is_had_as_well(bend: int, sign: int) -> None:
    """exp(bend (x - 1/3)) = 2, less and more: from values that are far apart, so that the straight line leads astray."""
    value = CriticalValue(Asked(lambda q: sign * ((bend * (q - arb(1) / 3)).exp() - 2)), 1, Fraction(0), Fraction(3))
    with mpmath.workdps(50):
        true = mpmath.mpf(1) / 3 + mpmath.log(2) / bend
        assert value.digits(30) == mpmath.nstr(true, 30, strip_zeros=False)


def test_where_a_ball_holds_0_no_more_is_told_than_what_signs_showed_before() -> None:
    """A zero at 5/4 is met; one behind noise of 1/1000 stays as wide as that."""
    at = Fraction(5, 4)
    for noise, low, high in ((0, 1, Fraction(3, 2)), (0.001, 1, Fraction(3, 2)), (0.001, Fraction(9, 8), 7)):
        value = CriticalValue(
            Asked(lambda q, noise=noise: q - arb(5) / 4 + arb(0, noise)), 1, Fraction(low), Fraction(high)
        )
        with flint.ctx.workprec(300):
            ball = value.ball(100)
        assert ball.contains(arb(at.numerator) / at.denominator)
        assert ball.upper() <= float(high) + 1e-6  # radii have 30 bits
        assert ball.lower() >= float(low) - 1e-6


def test_a_frequency_is_that_of_the_angle_at_the_value_over_the_period() -> None:
    loop: Any = Asked(lambda q: q**2 - 5)

    class Third:
        """The same as the last of three tests."""

        angle, period = loop.angle, loop.period

        @staticmethod
        def tests(q: Any) -> tuple[Any, ...]:
            return (q**2 - 5,) * 3

    own: Any = Third()
    low, high = Fraction(2), Fraction(5, 2)
    with mpmath.workdps(90):
        period = mpmath.sqrt(5) / 3
        angles = [mpmath.mpf(0), mpmath.pi, mpmath.acos(1 / mpmath.sqrt(5))]
        for test, angle in enumerate(angles):
            found = Swing(CriticalValue(own, test, low, high))
            assert abs(mpmath.mpf(found.digits(70)) - angle / period) < mpmath.mpf(10) ** -69
            assert found.ball(64).is_zero() is (test == 0)
