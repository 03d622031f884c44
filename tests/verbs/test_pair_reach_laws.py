"""Steps towards a pair, what C is beside 0, and bounds on frequencies: by linear algebra of floats and by hand."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
from flint import acb, arb
from sympy import Expr, Integer, Rational, Symbol, exp, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.pairs import Characteristic, Pair
from haptisym.verbs.stability.reach import Reach, _Squares, _Sums, _value, reach_of, reach_of_axis

q = Symbol("q", positive=True)


def loop_of(expression: Expr) -> Loop:
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), q, Integer(0))


# Pairs


@pytest.mark.parametrize("seed", range(3))
def test_a_step_solves_the_two_linear_equations_of_value_and_slopes(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    draw = random.Random(seed)
    form = Characteristic(loop_of(s + q))
    for _ in range(20):
        f, along, across = (complex(draw.uniform(-3, 3), draw.uniform(-3, 3)) for _ in range(3))
        balls = [acb(z.real, z.imag) for z in (f, along, across)]
        monkeypatch.setattr(Characteristic, "value", lambda *_, balls=balls: balls)
        omega, value = draw.uniform(0.1, 9), draw.uniform(-4, 4)
        found = form.step(arb(omega), arb(value))
        assert found is not None
        J = np.array([[along.real, across.real], [along.imag, across.imag]])
        true = np.array([omega, value]) - np.linalg.solve(J, [f.real, f.imag])
        assert [float(x.mid()) for x in found] == pytest.approx(list(true), rel=1e-6, abs=1e-6)
        assert form.step(arb(0, 1), arb(value)) is form.step(arb(-1), arb(value)) is None
    for along, across in ((acb(1, 2), acb(2, 4)), (acb(1, 2), acb(arb("nan"), 1)), (acb(arb("inf"), 2), acb(1, 1))):
        monkeypatch.setattr(Characteristic, "value", lambda *_, a=along, b=across: (acb(1), a, b))
        assert form.step(arb(1), arb(1)) is None


def test_there_is_one_pair_alone_where_the_step_stays_inside_on_both_sides(monkeypatch: pytest.MonkeyPatch) -> None:
    form = Characteristic(loop_of(s + q))
    omega, value = arb(5, 1), arb(3, 2)
    for (w, r), (v, t) in product(((5, 0.5), (5, 1.5), (6.2, 0.5), (8, 0.5)), ((3, 1), (3, 2.5), (5, 0.5), (0, 0.5))):
        after = arb(w, r), arb(v, t)
        monkeypatch.setattr(Characteristic, "step", lambda *_, after=after: after)
        found = form.only(omega, value)
        inside = w - r > 4 and w + r < 6 and v - t > 1 and v + t < 5
        assert (found is not None) is inside
        if found is not None:
            assert (found.omega, found.q) == after
    monkeypatch.setattr(Characteristic, "step", lambda *_: None)
    assert form.only(omega, value) is None


def test_a_pair_is_closed_in_on_as_long_as_steps_halve_one_side_of_its_box() -> None:
    """Each step quarters the box, up to a width below which it does not."""
    asked: list[float] = []

    def step(omega: Any, value: Any) -> Any:
        asked.append(float(omega.rad()))
        size = max(float(omega.rad()) / 4, 2.0**-flint.ctx.prec)
        return arb(5, size), arb(3, min(float(value.rad()), 0.75))  # the other side stays as wide

    own = Pair(SimpleNamespace(step=step), arb(5, 1), arb(3, 1))  # type: ignore[arg-type]
    for bits in (40, 120, 60):
        before = len(asked)
        omega, value = own.at(bits)
        assert float(omega.rad()) <= (2.0**-bits if bits != 60 else 2.0**-120)
        assert omega.contains(5)
        assert value.contains(3)
        assert len(asked) - before < 80
        assert own.at(bits) == (omega, value)
    assert asked[0] == pytest.approx(1)
    stuck = Pair(SimpleNamespace(step=lambda *_: None), arb(5, 1), arb(3, 1))  # type: ignore[arg-type]
    omega, value = stuck.at(50)
    assert [float(omega.rad()), float(value.rad())] == pytest.approx([1, 1])


@pytest.mark.parametrize(
    ("expression", "zeros"),
    [
        ((q - 3) + s ** Rational(1, 2), [3]),
        ((q + 5) + s, [-5]),
        (s ** Rational(1, 2) * (q - 2) + s, [2]),
        ((1 - exp(-s)) * s ** Rational(1, 2) * (q - 4) + s**2, [4]),
        ((1 - exp(-s)) ** 2 * (q - 4) + s**2 * 3 + s**3, [1]),
        ((exp(-s * q) - 1) + 2 * s + s**2, [2]),
        (s**2 + (1 - exp(-s * pi)) * (q**2 - 4), [-2, 2]),
        ((q - 2) * (q + 3) + s**3, [-3, 2]),
        (q**2 * 2 - 6 * q + s, [0, 3]),
        (s**q + s + 1, []),
        (s + 1 + exp(-s * q), []),
    ],
)
def test_a_root_passes_through_0_where_the_first_term_that_is_there_is_lost(expression: Expr, zeros: list[int]) -> None:
    """C/s^n at 0, by hand."""
    found = Characteristic(loop_of(expression.expand())).at_0()
    assert sorted({round(float(x), 9) for x in found}) == zeros


def test_beside_0_it_is_clear_where_one_of_two_derivatives_has_a_real_part(monkeypatch: pytest.MonkeyPatch) -> None:
    form = Characteristic(loop_of(s**2 * (q + 1) + s**3))
    asked: list[int] = []
    order = 0  # C over the power that all terms share
    for one, other in product((acb(0, 1), acb(2, 1), acb(arb(0, 1), 3)), repeat=2):

        def derivative(_: Any, n: int, omega: Any, value: Any, one: Any = one, other: Any = other) -> Any:
            asked.append(n)
            return one if n == order else other

        monkeypatch.setattr(Characteristic, "_derivative", derivative)
        assert form.is_clear_at_0(arb(0, 1), arb(1)) is any(z.real.mid() == 2 for z in (one, other))
    assert set(asked) == {order, order + 1}
    assert Characteristic(loop_of(s ** Rational(1, 2) + q + s)).is_clear_at_0(arb(0), arb(1)) is False
    assert Characteristic(loop_of(s**q + 1)).is_clear_at_0(arb(0), arb(1)) is False
    deep = Characteristic(loop_of(((1 - exp(-s)) ** 9 * (q + 1)).expand()))  # of an order that is not looked for
    assert (deep.at_0(), deep.is_clear_at_0(arb(0, 1), arb(1))) == ([], False)


# Bounds on frequencies


@dataclass(frozen=True)
class Known(Reach):
    """One that prevails from a frequency on, if it is a number."""

    first: float | None

    def _weights(self, q: Any, *, inverse: bool) -> Any:
        return None if self.first is None else (q, inverse)

    def _prevails(self, at: Any, weights: Any) -> bool:
        assert weights == ("q", True)
        assert self.first is not None
        return bool(at >= self.first)


@pytest.mark.parametrize("longest", [Rational(1, 5), pi])
def test_a_radius_is_found_at_most_a_fourth_beyond_the_first_that_prevails(longest: Expr) -> None:
    last = 300 / float(longest)
    for first in (0.0, last / 1024, last / 700, last / 3, last * 0.79, last * 1.001, last * 5):
        found = Known(longest, first).radius("q", 300, inverse=True)
        if first > last:
            assert found is None
        elif found is None:
            assert first > last * 0.8
        else:
            assert first <= float(found) <= max(1.25 * first, last / 1024) * (1 + 1e-12)
            assert float(found) <= last * (1 + 1e-12)
    assert Known(longest, None).radius("q", 300, inverse=True) is None


@pytest.mark.parametrize("seed", range(3))
def test_weights_bound_coefficients_from_below_and_sums_of_others_from_above(seed: int) -> None:
    draw = random.Random(seed)
    for inverse in (False, True):
        rows = [[Integer(draw.randint(-9, 9)) for _ in range(3)] for _ in range(4)]
        at, width = draw.randint(-3, 3), draw.choice([0, 1])
        ball = arb(at, width)
        values = [
            [
                float(sum(c * x**i for i, c in enumerate(row[::-1] if inverse else row)))
                for x in (at - width, at, at + width)
            ]
            for row in rows
        ]
        with flint.ctx.workprec(192):
            for row, told in zip(rows, values, strict=True):
                assert all(_value(row, ball, inverse=inverse).contains(x) for x in told)
            found = _Squares(Integer(1), rows)._weights(ball, inverse=inverse)
            table: Mapping[Any, Any] = {
                Integer(2): {
                    (0,): [Integer(40)] * 1 + [Integer(0)] * 2 if not inverse else [Integer(0)] * 2 + [Integer(40)]
                },
                Integer(1): {(0,): rows[0], (1,): rows[1]},
                Rational(1, 2): {(2,): rows[2]},
            }
            sums = _Sums(Integer(1), table, 0)._weights(ball, inverse=inverse)
        first, second, *rest = (float(x) for x in found)
        assert 0 <= first <= max(0, *values[0])
        assert second <= min(values[1])
        assert all(x <= min(0, *y) for x, y in zip(rest, values[2:], strict=True))
        if not width:
            assert [first, second, *rest] == [max(0, values[0][0]), values[1][0], *(min(0, y[0]) for y in values[2:])]
        assert sums is not None
        assert float(sums[Integer(0)]) == 40
        for p, own in ((Integer(-1), values[:2]), (Rational(-3, 2), values[2:3])):
            assert float(sums[p]) <= -sum(max(map(abs, y)) for y in own) + 1e-6
            assert width or float(sums[p]) == -sum(abs(y[0]) for y in own)


@pytest.mark.parametrize("seed", range(3))
def test_what_prevails_at_a_frequency_is_a_sum_of_weights_by_their_powers(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(30):
        w, at = [draw.uniform(-3, 3) for _ in range(4)], draw.uniform(0.3, 3)
        squares = w[0] * at**2 + w[1] + w[2] / at**2 + w[3] / at**4
        assert _Squares(Integer(1), ())._prevails(arb(at), [*map(arb, w)]) is (squares > 0)
        powers = [Integer(0), Rational(-1, 2), Integer(-1), Rational(-5, 2)]
        sums = sum(x * at ** float(p) for x, p in zip(w, powers, strict=True))
        assert _Sums(Integer(1), {}, 0)._prevails(arb(at), dict(zip(powers, map(arb, w), strict=True))) is (sums > 0)
    assert _Squares(Integer(1), ())._prevails(arb(1), [arb(1), arb(-1)]) is False
    assert _Sums(Integer(1), {}, 0)._prevails(arb(1), {Integer(0): arb(0)}) is False


def test_the_sharper_bound_is_taken_of_one_delayed_product_if_the_highest_power_stands_in_time() -> None:
    for expression, squares, longest, unit in (
        (s**2 + q * s + 3 * exp(-s / 2), True, Rational(1, 2), 0),
        (s**2 * (1 + exp(-s / 2)) + q, True, Rational(1, 2), 0),
        (s**2 * exp(-s / 2) + q * s, False, Rational(1, 2), 0),
        (s**2 + q * exp(-s / 2) + exp(-s), False, Integer(1), 0),
        (s**2 + q * exp(-s / 2) + exp(-s * pi), False, pi, None),
        (s**2 + q * s + 3, None, Integer(1), None),
    ):
        own, axis = reach_of(loop_of(expression)), reach_of_axis(loop_of(expression))
        assert squares is None or isinstance(own, _Squares) is squares
        assert (own.longest, axis.longest) == (longest, longest)
        assert isinstance(axis, _Sums)
        assert axis.unit == unit
