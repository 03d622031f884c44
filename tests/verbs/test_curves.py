"""The curve on which one open number puts roots on the imaginary axis: through values that were put there."""

from __future__ import annotations

import random
from contextlib import suppress
from itertools import islice
from math import prod
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Expr, Integer, Rational, Symbol, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.symbols import omega, s
from haptisym.verbs.stability.boundary import _windows
from haptisym.verbs.stability.curves import Curve, _remainder, curve_of
from haptisym.verbs.stability.loops import Loop, coefficients
from haptisym.verbs.stability.search import searched

Q = Symbol("q", positive=True)


def drawn(pick: random.Random, degree: int, of: Expr, most: int = 2) -> Expr:
    """A polynomial in s (or another) and q with small whole coefficients."""
    found: Expr = Integer(0)
    for i in range(degree + 1):
        found += Q**i * sum((pick.randint(-3, 3) * of**n for n in range(most + 1)), Integer(0))
    return found


@pytest.mark.few(2)
@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_a_value_that_puts_roots_on_the_axis_is_on_the_curve_at_their_frequency(degree: int, seed: int) -> None:
    """C = (s^2 + w^2) A(s, q) + (q - v) B(s, q) has roots +-j w at q = v; beside delays and whole powers of q."""
    pick = random.Random(10 * degree + seed)
    w, v = Rational(pick.randint(1, 9), pick.randint(1, 4)), Rational(pick.randint(1, 9), pick.randint(1, 4))
    A, B = drawn(pick, degree, s, 1) + s + 1, drawn(pick, degree - 1, s) + s**2 + 2
    if seed % 2:
        A *= exp(-s / 3)
    C = (s**2 + w**2) * A + (Q - v) * B
    ring = Ring.of([C])
    loop = Loop(ring, ring.convert(C).numerator, ring.constant(1), Q)
    try:
        curve = curve_of(loop)
    except UndecidedError:  # of more than one root in common a remainder does not tell the value: it is searched for
        near = [x for window in islice(searched(loop, v, ""), 3) for x in window.found if x.omega is not None]
        assert (float(w), float(v)) in [pytest.approx((float(x.omega or 0), float(x.value))) for x in near]
        return
    assert curve is not None

    def at(f: RationalFunction) -> Expr:
        """Whatever the tangent of the angle is, which has a name of its own."""
        top, bottom = (f.ring.expression(p).subs(omega, w) for p in (f.numerator, f.denominator))
        return top / bottom

    assert at(curve.condition).cancel() == 0
    assert (at(curve.value) - v).cancel() == 0
    assert (at(curve.square) - v**2).cancel() == 0


@pytest.mark.parametrize("seed", range(8))
def test_a_remainder_that_is_linear_vanishes_wherever_both_polynomials_do(seed: int) -> None:
    pick, x = random.Random(seed), Symbol("x")
    ring = Ring.of([x, Q])
    w, v = Rational(pick.randint(-9, 9), 4), Rational(pick.randint(-9, 9), 3)
    both = []
    for _ in range(2):
        f = (x - w) * drawn(pick, 2, x) + (Q - v) * (drawn(pick, pick.randint(1, 2), x) + Q)
        both.append(ring.convert(f).numerator)
    index = ring.meanings.index(Q)
    found = _remainder(both[0], both[1], index)
    assert found is not None
    c0, c1 = (ring.expression(p) for p in found)
    assert Q not in c0.free_symbols | c1.free_symbols
    assert (c0 + c1 * v).subs(x, w) == 0
    assert c1 != 0
    assert len(coefficients(both[0], index)) > 2


@pytest.mark.parametrize("value", [-3, -1, 1, 3])
@pytest.mark.parametrize("most", [-2, 2])
def test_in_each_window_of_values_all_are_known_that_put_roots_on_the_axis(value: int, most: int) -> None:
    """At omega = 1, 2, ... 24 by q = c omega^2/(omega^2 + 9), which goes to c: a window that holds c is left open."""
    axis = Ring.of([]).axis
    zeros = prod((omega**2 - n**2 for n in range(1, 25)), start=Integer(1))
    curve = Curve(
        *(axis.convert(x) for x in (zeros, most * omega**2 / (omega**2 + 9), (most * omega**2 / (omega**2 + 9)) ** 2))
    )
    loop: Any = SimpleNamespace(ring=SimpleNamespace(lags=[]))
    there = [Rational(most * n**2, n**2 + 9) for n in range(1, 25)]
    windows = []
    with suppress(UndecidedError):  # where none is known
        for x in _windows(loop, curve, Integer(value), ()):
            windows.append(x)  # noqa: PERF402  what came before the error counts
    assert windows or value == -3
    for x in windows:
        known = [float(y.value) for y in x.found]
        inside = [y for y in there if (x.above is None or y > x.above) and (x.below is None or y < x.below)]
        assert all(any(abs(float(y) - z) < 1e-9 for z in known) for y in inside)
