"""Critical values of loops that are written down by hand, so that their roots are known; scenes are in test_stability_limits."""

from __future__ import annotations

import mpmath
import pytest
from sympy import Expr, Integer, Rational, Symbol, exp, expand, lambdify

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import s
from haptisym.kernel.sets import Domain
from haptisym.verbs.stability.characteristic import Characteristic
from haptisym.verbs.stability.critical import critical_values
from haptisym.verbs.stability.crossingcurve import curve_of
from haptisym.verbs.stability.loops import Loop

q = Symbol("q")
ALL, ONE = Domain(None, None), Integer(1)


def loop(C: Expr, D: Expr) -> Loop:
    """The loop with that characteristic function over that denominator."""
    ring = Ring.of([C, D])
    return Loop(ring, ring.convert(expand(C)).numerator, ring.convert(expand(D)).numerator, q)


def test_a_root_at_0_of_high_order_is_found_where_the_first_powers_of_s_vanish_for_all_values() -> None:
    # (1 - z)^10 = s^10 + ..., and (1 + z)^10 = 2^10 at s = 0: before s^10 stands q - 1024, below it nothing.
    z = exp(-s)
    C = (1 - z) ** 10 * (q - (1 + z) ** 10) + s**11
    assert [x.value for x in Characteristic(loop(C, ONE)).at_0()] == [1024]


def test_a_delay_at_which_the_display_is_divided_by_0_is_undecided_and_no_error_of_the_scene() -> None:
    # At q = 1 both delays are the same, and what the loop is over is 0.
    difference = exp(-s * q) - exp(-s)
    late = loop(s**4 + 1 + (s**2 + s + 1) * difference, difference)
    with pytest.raises(UndecidedError, match="divided by 0"):
        late.roots_at(Integer(1))
    assert late.roots_at(Integer(2)).number == 2


@pytest.mark.parametrize("value", [-3, Rational(1, 2), Rational(3, 2), 5])
def test_a_factor_that_is_real_on_the_axis_has_a_root_in_the_closed_right_half_plane_for_all_values(
    value: Expr,
) -> None:
    # Of s^4 + q s^2 + 1 four roots come to the axis at q = 2. That is not among the values that elimination returns, as the
    # factor is common to the real and the imaginary part of C; no value beside it is stable.
    C = (s**4 + q * s**2 + 1) * (s**2 + q * s + q**2 + 1)
    [found] = critical_values(loop(C, ONE), Integer(3), ALL)
    assert ([float(x.value) for x in found.values], list(found.open)) == ([0], [])
    number = loop(C, ONE).roots_at(Rational(value)).number
    assert number is not None
    assert number >= 2


HALF_TURN = 1 + exp(-s)
"""It is 0 at odd multiples of j pi, where tan(omega/2), the variable of the elimination, has its poles."""

AT_HALF_TURNS = {
    "retarded": (q + s**2 - 1) * (s + q + 2) + HALF_TURN,
    "with both in one power": (q + s**2 - 1) * (s + q + 2) + HALF_TURN * (s + 3),
    "in a product with s": (q + s**2 - 1) * (q * s + 1) + HALF_TURN * (s / 10 + 3),
}


@pytest.mark.parametrize("case", AT_HALF_TURNS)
def test_a_root_that_crosses_where_a_delay_has_turned_half_is_critical(case: str) -> None:
    """There C = (q - 1 - omega^2) times what is not 0: the root is at j pi for q = 1 + pi^2, and crosses, as a count beside it shows."""
    C = AT_HALF_TURNS[case]
    curve = curve_of(loop(C, ONE))
    assert curve is not None
    found = {(round(float(x.value), 9), round(float(x.omega), 9)) for x in curve.roots(Integer(5))}
    with mpmath.workdps(30):
        critical = 1 + mpmath.pi**2
        assert abs(lambdify((s, q), C, "mpmath")(1j * mpmath.pi, critical)) < 1e-25
    assert (round(float(critical), 9), round(float(mpmath.pi), 9)) in found
    below, above = (loop(C, ONE).roots_at(Rational(x)).number for x in ("10.86", "10.88"))
    assert (below, above) == (2, 0)
    assert curve.radius is None  # all odd multiples of pi are such frequencies


def test_two_values_at_one_half_turn_are_undecided() -> None:
    # There q^2 = omega^2 + 1: two critical values at one frequency, of which elimination gives one.
    with pytest.raises(UndecidedError):
        curve_of(loop((q**2 + s**2 - 1) * (s + 2) + HALF_TURN * (q + 1), ONE))


def test_a_root_that_only_touches_the_axis_again_and_again_leaves_no_set_called_complete() -> None:
    # Of s^2 + s (1 + exp(-s)) + q - 1 the damping is 1 + cos(omega): at each half turn a pair is on the axis, for q = 1 + omega^2.
    touching = loop(s**2 + s * HALF_TURN + q - 1, ONE)
    assert [touching.roots_at(Rational(x)).number for x in ("10.86", "10.88", "89.8", "89.9")] == [0] * 4
    curve = curve_of(touching)
    assert curve is not None
    assert curve.radius is None
    critical = [float(1 + (n * mpmath.pi) ** 2) for n in (1, 3, 5)]
    assert [float(x.value) for x in curve.roots(Integer(16))] == pytest.approx(critical, rel=1e-12)
    first = next(iter(critical_values(touching, Integer(3), ALL)))
    assert first.open
    assert sorted(float(x.value) for x in first.values) == pytest.approx([1, critical[0]], rel=1e-12)


def test_beside_a_chain_that_is_lost_at_a_negative_value_all_values_above_it_are_known() -> None:
    """C = (q + 5 + 2 exp(-s)) s^2 + 3 s + q + 6: a chain is at the axis for |q + 5| = 2, and above q = -3 there is none."""
    C = (q + 5) * s**2 + 2 * s**2 * exp(-s) + 3 * s + q + 6
    neutral = loop(C, ONE)
    *_, last = critical_values(neutral, Integer(1), ALL)
    above = [x for x in last.open if x.low is not None]
    assert [(float(x.low), x.high is not None and float(x.high) < -2.95) for x in above] == [(-3, True)]
    [value] = [x for x in last.values if x.omega is not None and float(x.value) > -2.95]
    with mpmath.workdps(30):
        f = lambdify((s, q), C, "mpmath")
        found = mpmath.findroot(lambda w, x: [f(1j * w, x).real, f(1j * w, x).imag], (3.57, -2.95))
    assert [float(value.omega), float(value.value)] == pytest.approx([float(x) for x in found], rel=1e-12)
    assert [neutral.roots_at(Rational(x)).number for x in ("-2.95", "-2.94", "1000")] == [2, 0, 0]
