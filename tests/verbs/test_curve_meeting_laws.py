"""Meetings on a curve, with zeros and poles that were put there; the sense in which roots cross, by NumPy; remainders by hand."""

from __future__ import annotations

import random
from itertools import product
from math import prod
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Integer, Poly, Rational, Symbol, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import omega, s
from haptisym.verbs.stability import curves
from haptisym.verbs.stability.curves import Curve, Meeting, _remainder, curve_of
from haptisym.verbs.stability.loops import Loop

Q = Symbol("q", positive=True)


def loop_of(expression: Expr) -> Loop:
    ring = Ring.of([expression, Q])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), Q)


def exact(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


def test_two_meetings_are_alike_if_value_and_frequency_are_or_both_come_from_infinity() -> None:
    kinds = [(v, w) for v in (1, 2) for w in (None, 3, 4)]
    for (v, w), (v2, w2) in product(kinds, repeat=2):
        one, other = (Meeting(exact(a), None if b is None else exact(b)) for a, b in ((v, w), (v2, w2)))
        assert one.is_like(other) is ((v, w) == (v2, w2))


@pytest.mark.parametrize("linear", [True, False])
@pytest.mark.parametrize("seed", range(2))
def test_on_a_curve_roots_meet_the_axis_where_its_condition_vanishes_and_its_value_is_finite(
    seed: int, *, linear: bool
) -> None:
    """At 0 it tells nothing; where the value has a zero it is 0; a sign of the condition that falls sends a pair to the right."""
    draw = random.Random(seed)
    axis = Ring().axis
    for _ in range(8):
        zeros = [draw.randint(0, 8) for _ in range(draw.randint(1, 5))]
        poles, nought = (draw.sample(range(1, 9), draw.randint(0, 3)) for _ in range(2))
        sign, half = draw.choice([-1, 1]), Rational(1, 2)
        f = sign * prod((omega - half * x for x in zeros), start=Integer(1))
        above = prod((omega - half * x for x in nought), start=omega + 3)
        below = prod((omega - half * x for x in poles), start=Integer(1))
        value = axis.function(
            axis.convert((above * below).expand()).numerator, axis.convert((below**2).expand()).numerator
        )
        reach = draw.choice([Rational(7, 4), Rational(9, 2)])
        found = Curve(axis.convert(f.expand()), value, value, is_linear=linear).meetings(reach)
        expected = []
        for x in sorted({*zeros} - {0}):
            order = nought.count(x) - poles.count(x)
            if half * x > reach or order < 0:
                continue
            change = (-1) ** sum(z > x for z in zeros) * sign if zeros.count(x) % 2 else 0
            other = Rational(0) if order else ((above / below).cancel()).subs(omega, half * x)
            expected.append((float(half * x), float(other), -change if linear else None))
        told = [(float(x.omega or 0), float(x.value), x.sense) for x in found]
        assert [x[0::2] for x in told] == [x[0::2] for x in expected]
        assert [x[1] for x in told] == pytest.approx([x[1] for x in expected], abs=1e-12)
        assert all(x.value == exact(0) for x, y in zip(found, expected, strict=True) if y[1] == 0)


def test_a_touch_that_is_not_told_leaves_it_open(monkeypatch: pytest.MonkeyPatch) -> None:
    axis = Ring().axis
    curve = Curve(axis.convert(omega - 1), axis.convert(omega), axis.convert(omega**2))
    plain = SimpleNamespace(undecided=frozenset(), orders={})
    for names, is_open in ((frozenset({"0"}), True), (frozenset({"q"}), False)):
        point = SimpleNamespace(undecided=names, orders={})
        monkeypatch.setattr(curves, "chart", lambda *_, point=point: SimpleNamespace(points=(plain, point)))
        if is_open:
            with pytest.raises(UndecidedError, match="touches the imaginary axis"):
                curve.meetings(Integer(3))
        else:
            assert curve.meetings(Integer(3)) == ()


def right(expression: Expr, value: float) -> int:
    row = [float(x) for x in Poly(expression.subs(Q, Rational(value)), s).all_coeffs()]
    return int((np.roots(row).real > 0).sum())


@pytest.mark.parametrize("seed", range(4))
def test_the_sense_of_a_meeting_is_how_many_pairs_come_to_the_right_as_the_number_grows(seed: int) -> None:
    draw, seen = random.Random(seed), set()
    for _ in range(3):
        A = s**3 + sum((draw.randint(0, 5) * s**n for n in range(3)), Integer(0))
        B = sum((draw.randint(-3, 3) * s**n for n in range(3)), Integer(0)) + Rational(1, 2)
        curve = curve_of(loop_of(A + Q * B))
        assert curve is not None
        for x in curve.meetings(Integer(40)):
            value = float(x.value)
            assert x.sense is not None
            at_0 = float((A + Rational(value) * B).subs(s, 0))  # a root may pass through 0 as well
            if abs(value) > 1e-6 and abs(at_0) > 1e-6:
                counts = [right(A + Q * B, value + side * 1e-6 * abs(value)) for side in (-1, 1)]
                assert counts[1] - counts[0] == 2 * x.sense, (A, B, value)
                seen.add(x.sense)
    assert seen


def test_where_all_values_put_roots_on_the_axis_those_count_at_which_their_number_changes() -> None:
    """s^4 + 5 s^2 + 4 + q s^2: q = omega^2 - 5 + 4/omega^2, which turns at -1 where omega^2 = 2: (s^2 + 2)^2."""
    curve = curve_of(loop_of(s**4 + 5 * s**2 + 4 + Q * s**2))
    assert curve is not None
    [met] = curve.meetings(Integer(9))
    assert (float(met.value), float(met.omega or 0)) == pytest.approx((-1, 2**0.5), rel=1e-15)
    assert curve_of(loop_of(s**2 + 3 * s + exp(-s))) is None


@pytest.mark.parametrize(
    "expression",
    [
        (Q - 1) * (Q - 2) + (s**2 + 1) * (s + 3),  # both 1 and 2 at 1 rad/s
        (Q - s**2 - 3) * (Q + s**2 + 1),  # real for all values
        Q**2 + s**2 + 1,
    ],
)
def test_where_real_and_imaginary_part_do_not_tell_one_value_alone_it_is_left_open(expression: Expr) -> None:
    with pytest.raises(UndecidedError, match="where roots meet the imaginary axis"):
        curve_of(loop_of(expression.expand()))


def test_a_remainder_is_none_where_both_share_a_factor_or_one_has_none() -> None:
    x = Symbol("x")
    ring = Ring.of([x, Q])
    index = ring.meanings.index(Q)

    def told(f: Expr, g: Expr) -> list[Expr] | None:
        one, other = (ring.convert(z.expand()).numerator for z in (f, g))
        found = _remainder(one, other, index)
        return None if found is None else [ring.expression(z) for z in found]

    assert told((Q - x) * (Q + 1), (Q - x) * (Q**2 + 3)) == told((Q - x) * (Q**2 + 3), (Q - x) * (Q + 1)) is not None
    assert told((Q**2 - x) * (Q + 1), (Q**2 - x) * (Q + 3)) is None
    assert told(Q**2 - x, Q**2 - x) is None
    assert told(Q**3 + Q, x + 2 + 0 * Q) is None
    assert told(Integer(3) + 0 * Q, Q**2 + 1) is None
    assert told(Q**2 + 1, 3 * Q - x) == [-x, Integer(3)]
    assert told(3 * Q - x, Q**4 + 1) == [-x, Integer(3)]
    found = told(Q**2 + x * Q + 5, Q**2 + 3 * Q + x)  # their difference
    assert found is not None
    assert (found[1] * (5 - x) - found[0] * (x - 3)).expand() == 0
    found = told(Q**3 + 2, Q**2 - x)  # Q^3 + 2 - Q (Q^2 - x)
    assert found is not None
    assert (found[0] * x - found[1] * 2).expand() == 0
