"""What stays open of a threshold or a region that grows: a touch that no finite number of digits shows is said to be open, not guessed."""

from __future__ import annotations

from typing import Any

import pytest
from sympy import Expr, Integer, Rational, exp, pi, sin

import haptisym as hs
from haptisym.judge.climb import Climb
from haptisym.judge.criteria import noticed
from haptisym.judge.growth import Growth, bandwidth_of
from haptisym.judge.regions import Term
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.symbols import s

CRITERION = noticed(hs.Threshold())[0]
TOUCH = 1 + exp(-s) + (s**2 + pi**2) ** 2
"""Its real part, 1 + cos(omega) + (omega^2 - pi^2)^2, touches 0 at pi."""
RISING = (1 + pi**4) * s + 2 * pi**2 / 3 * s**3 + s**5 / 5 - exp(-s)
"""The derivative of its imaginary part is that real part."""
BAND = Integer(1), Integer(5)


def real(f: Expr) -> RealFunction:
    return on_axis(Ring.of([f]).convert(f)).real


def imag(f: Expr) -> RealFunction:
    return on_axis(Ring.of([f]).convert(f)).imag


def grown(f: RealFunction, low: Any, high: Any, band: tuple[Expr, Expr] = BAND) -> Growth:
    return Growth((Term((), (f,)),), (low, high), band, CRITERION, "scale", Integer(1))


UNDER = real(1 - TOUCH / 1000)
"""Below 1 but at pi."""


def test_whether_a_ratio_touches_a_limit_stays_open_and_beside_it_nothing_does() -> None:
    for ask in (
        grown(UNDER, Rational(1, 2), Integer(1)).at,
        Climb({CRITERION: UNDER}, (Rational(1, 2), Integer(1)), BAND, "jnd").at,
    ):
        with pytest.raises(hs.UndecidedError, match="whether a ratio touches a"):
            ask(Integer(1))
        found = ask(Rational(1001, 1000))
        assert found is not None
        assert float(found) == 5
        assert ask(Rational(9, 10)) is None  # (9/10)^2 < 1 - (1 + cos 1 + (1 - pi^2)^2)/1000
    touching = Lattice(((RealFunction((UNDER.function - UNDER.function.ring.convert(Integer(1))).reduced()),),))
    with pytest.raises(hs.UndecidedError, match="touches a limit of the range"):
        bandwidth_of(touching, BAND)
    end = bandwidth_of(touching, (Integer(1), Integer(3)))
    assert end is not None
    assert float(end) == 3


def test_whether_there_is_a_peak_stays_open_where_a_slope_nearly_vanishes_and_is_asked_in_the_band_alone() -> None:
    f = imag(RISING)

    def value(x: float) -> float:
        own = float((1 + pi**4) * x - 2 * pi**2 / 3 * x**3 + Rational(1, 5) * x**5 + sin(x))
        assert own > 0
        return own**0.5

    for band, opens in (((2, 4), True), ((2, 3), False), ((4, 5), False)):
        own = Integer(band[0]), Integer(band[1])
        low, high = (Rational(round(value(x) * 100), 100) for x in (band[0] + 0.1, band[1] - 0.1))
        assert low < high
        asked = (
            grown(f, low, high, own),
            Climb({CRITERION: f}, (low, high), own, "jnd"),
        )
        for one in asked:
            if opens:
                with pytest.raises(
                    hs.UndecidedError, match="whether a ratio has a peak where its slope nearly vanishes"
                ):
                    _ = one.found
            else:
                found = one.found
                assert found.jumps == ()
                assert [value(float(x)) for x in (found.least, found.most) if x] == pytest.approx(
                    [float(low), float(high)], rel=1e-12
                )
