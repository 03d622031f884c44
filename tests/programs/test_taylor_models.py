"""Taylor models hold what they promise: each operation against balls of 600 bits, formulas and zeros on the axis against mpmath."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import wraps
from itertools import product
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, cos, diff, exp, lambdify, pi, sin, sinc, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import s
from haptisym.programs.onaxis import OnAxis
from haptisym.programs.program import Writer
from haptisym.programs.taylormodels import Modelled, TaylorModel, between, constant, floated, valued, variable

Array = Any

ROUNDING = 2.0**-53

exactly = np.frompyfunc(arb, 1, 1)

certainly_above = np.frompyfunc(lambda x, y: x > y, 2, 1)


def with_many_digits(test: Callable[..., None]) -> Callable[..., None]:
    @wraps(test)
    def tried(**given: Any) -> None:
        with flint.ctx.workprec(600):
            test(**given)

    return tried


@dataclass(frozen=True)
class Points:
    """Points t of boxes with ``sides`` sides; at the first half of them, corners, operands reach their farthest.

    ``order`` : of the slopes of operands.
    """

    t: Array
    extreme: Array
    order: int = 2

    @classmethod
    def drawn(cls, random: np.random.Generator, boxes: int, sides: int, order: int = 2) -> Points:
        t = random.choice([-1.0, -0.75, 0.0, 0.5, 1.0], (boxes, sides))
        inside = random.uniform(size=boxes) < 0.2
        t[inside] = random.uniform(-1, 1, (boxes, sides))[inside]
        extreme = np.arange(boxes) < boxes // 2
        t[extreme] = random.choice([-1.0, 1.0], (boxes, sides))[extreme]
        return cls(t, extreme, order)

    def operand(self, random: np.random.Generator, middle: Array, reach: Array) -> tuple[TaylorModel, Array]:
        """A model, and what it may stand for: rows of any kind, but with values up to ``reach`` away from ``middle``."""
        boxes, n = self.t.shape
        first = rows_of(random, self, middle[:, None], reach[:, None])
        sizes = ten_to(random, (2, boxes, n), *random.choice([(-1, 1), (-18, 18)]))
        slopes = rows_of(random, self, sizes[0] * random.choice([-1, 0, 1], (boxes, n)), sizes[1])
        both = [np.concatenate(pair, 1) for pair in zip(first, slopes, strict=True)]
        if self.order == 1:
            both[2] = both[2][:, :1]
        model = TaylorModel(*both[:4])
        return model, at(model, self.t) + exactly(both[4]) * exactly(model.r)


def rows_of(random: np.random.Generator, points: Points, middle: Array, reach: Array) -> tuple[Array, ...]:
    """c0, c1, c2, r of rows, some of them 0, with sum of |c1|, |c2| and r about reach; and the share of r that is taken."""
    (boxes, n), m = points.t.shape, middle.shape[1]
    weights = ten_to(random, (boxes, m, n * n + n + 1), *random.choice([(-0.5, 0), (-6, 0)]))
    weights *= random.uniform(size=weights.shape) < random.choice([0.3, 0.8, 1.0], (boxes, m, 1))
    weights /= np.maximum(weights.sum(-1, keepdims=True), 1e-9)
    signs, share = random.choice([-1.0, 1.0], weights.shape), random.choice([-1.0, 0.5, 1.0], (boxes, m))
    turned = np.concatenate([points.t, (points.t[:, :, None] * points.t[:, None, :]).reshape(boxes, n * n)], 1)
    way = random.choice([-1.0, 1.0], (boxes, m))
    signs[..., :-1] = np.where(points.extreme[:, None, None], turned[:, None] * way[..., None], signs[..., :-1])
    share = np.where(points.extreme[:, None], way, share)
    parts = weights * reach[..., None]
    signed = parts[..., :-1] * signs[..., :-1]
    return middle, signed[..., :n], signed[..., n:].reshape(boxes, m, n, n), parts[..., -1], share


def ten_to(random: np.random.Generator, shape: Any, low: float, high: float) -> Array:
    return 10.0 ** random.uniform(low, high, shape)


def at(model: TaylorModel, t: Array) -> Array:
    """The polynomials of all rows at t, without rounding."""
    t, c2 = exactly(t), exactly(model.c2)
    found = exactly(model.c0) + (exactly(model.c1) * t[:, None, :]).sum(-1)
    found[:, : c2.shape[1]] += (c2 * t[:, None, :, None] * t[:, None, None, :]).sum((-1, -2))
    return found


def known(model: TaylorModel) -> Array:
    """Where something is known; there all numbers are finite."""
    finite = np.isfinite(model.r)
    for array in (model.c0, model.c1, model.c2):
        assert np.isfinite(array[finite[:, : array.shape[1]]]).all()
    return finite


def outside(model: TaylorModel, t: Array, true: Array) -> Array:
    """Boxes and rows of which the model, or its bounds, do not hold what is true."""
    low, high = model.bounds()
    far = certainly_above(abs(true - at(model, t)), exactly(model.r)).astype(bool) & known(model)
    assert (~np.isfinite(low[~known(model)])).all()
    above, below = certainly_above(true, exactly(high)), certainly_above(exactly(low), true)
    return np.argwhere(far | above.astype(bool) | below.astype(bool))


# Sums and products


SIZES = [(-1, 1), (-18, 18), (-323, -290), (-160, -140), (100, 150)]

RULES: dict[str, tuple[Callable[..., TaylorModel], Callable[..., Any], Callable[..., Any]]] = {
    "sum": (lambda x, y: x + y, lambda v, w: v + w, lambda v, w, a, b: a + b),
    "difference": (lambda x, y: x - y, lambda v, w: v - w, lambda v, w, a, b: a - b),
    "product": (lambda x, y: x * y, lambda v, w: v * w, lambda v, w, a, b: v * b + w * a),
    "square": (lambda x, y: x * x, lambda v, w: v * v, lambda v, w, a, b: 2 * v * a),
}


def pair_of_operands(
    random: np.random.Generator, boxes: int, sides: int, order: int = 2
) -> tuple[Points, list[tuple[TaylorModel, Array]]]:
    points, operands = Points.drawn(random, boxes, sides, order), []
    for _ in range(2):
        low, high = np.array([SIZES[i] for i in random.choice(len(SIZES), boxes, p=[0.4, 0.3, 0.1, 0.1, 0.1])]).T
        size, reach = 10 ** random.uniform(low, high, (2, boxes))
        operands.append(points.operand(random, size * random.choice([-1, 0, 1], boxes), reach))
    return points, operands


@pytest.mark.parametrize(("sides", "boxes", "order"), [(1, 1000, 2), (3, 300, 2), (3, 300, 1)])
@pytest.mark.parametrize("rule", RULES)
@with_many_digits
def test_a_sum_and_a_product_hold_those_of_all_that_the_operands_may_be(
    rule: str, sides: int, boxes: int, order: int
) -> None:
    ours, value, slope = RULES[rule]
    points, ((x, v), (y, w)) = pair_of_operands(np.random.default_rng(len(rule) + sides), boxes, sides, order)
    first = value(v[:, :1], w[:, :1])
    true = np.concatenate([first, slope(v[:, :1], w[:, :1], v[:, 1:], w[:, 1:])], 1)
    with np.errstate(all="ignore"):
        found = ours(x, y)
        assert outside(found, points.t, true).tolist() == []
        assert known(found)[:, 0].mean() > 0.98


@pytest.mark.dear("3-300-2")
@pytest.mark.parametrize(("sides", "boxes", "order"), [(1, 1000, 2), (3, 300, 2), (3, 300, 1)])
@with_many_digits
def test_a_quotient_holds_those_of_all_that_the_operands_may_be(sides: int, boxes: int, order: int) -> None:
    random = np.random.default_rng(sides)
    points, ((x, v), _) = pair_of_operands(random, boxes, sides, order)
    y, w = points.operand(random, *away_from_zero(random, boxes))
    first = v[:, :1] / w[:, :1]
    true = np.concatenate([first, (v[:, 1:] - first * w[:, 1:]) / w[:, :1]], 1)
    with np.errstate(all="ignore"):
        found = x / y
        assert outside(found, points.t, true).tolist() == []
        ordinary = (abs(y.c0[:, 0]) > 1e-3) & (abs(y.c0[:, 0]) < 1e3) & (abs(x.c0) + x.deviation < 1e100).all(1)
        assert known(found)[ordinary].mean() > 0.98


@with_many_digits
def test_of_numerator_and_denominator_that_vary_alike_a_quotient_loses_nothing() -> None:
    """However much they vary: x/x is 1, and a x/(b x) to within what is dropped of the two products."""
    random = np.random.default_rng(21)
    points = Points.drawn(random, 100, 3)
    x, _ = points.operand(random, np.ones(100), np.full(100, 0.8))
    x = replace(x, r=x.r * 0)
    alike = x / x
    assert (abs(alike.c0[:, 0] - 1) <= 1e-15).all()
    assert (alike.deviation[:, 0] < 1e-11).all()
    narrow = replace(flat(1.0), c1=np.array([[[0.3], [0.0]]]))
    a, b = narrow.times(7.0).plus(1e-3), narrow.times(2.0)
    found = a * narrow / (b * narrow)
    assert found.r[0, 0] < (a / b).r[0, 0] + 0.01
    assert found.r[0, 0] < 0.1 * (a * narrow * (b.number(1.0) / (b * narrow))).r[0, 0]


@pytest.mark.few("1-2")
@pytest.mark.parametrize(("sides", "order"), [(1, 2), (3, 2), (3, 1)])
@with_many_digits
def test_a_sum_with_a_number_holds_it_and_a_number_has_no_slopes(sides: int, order: int) -> None:
    random = np.random.default_rng(sides)
    for number in (-3.7, 0.1, -1e-20, 1e15, 3e-310, 0.0):
        points, ((x, v), _) = pair_of_operands(random, 100, sides, order)
        off = arb(number) * (1 + 4 * arb(ROUNDING) * random.choice([-1, 1]))
        assert outside(x.plus(number), points.t, np.concatenate([v[:, :1] + off, v[:, 1:]], 1)).tolist() == []
        own = x.number(number)
        true = np.concatenate([np.full((100, 1), off), np.full((100, sides), arb(0))], 1)
        assert outside(own, points.t, true).tolist() == []
        assert [array.shape for array in own.arrays] == [array.shape for array in x.arrays]


@pytest.mark.dear("1")
@pytest.mark.parametrize("order", [2, 1])
@with_many_digits
def test_exact_numbers_that_have_no_float_near_them_are_held_where_they_are_put_in(order: int) -> None:
    """From 10^-420 on, many of which are 0 as floats: sums and products with them hold those of the numbers themselves."""
    sizes = [Integer(0), *(Rational(sign * 7, 3) * Rational(10) ** n for n in (-420, -309, -16, 9) for sign in (1, -1))]
    like = constant(1.0, 1, 1, slopes=order)
    for x, y in product(sizes, repeat=2):
        own = like.number(floated(x))
        for model, true in (
            (own, x), (own.plus(floated(y)), x + y), (own.times(floated(y)), x * y),
            (own + like.number(floated(y)), x + y), (own * like.number(floated(y)), x * y),
        ):  # fmt: skip
            least, most = (Fraction(end[0, 0].item()) for end in model.bounds())
            assert least <= Fraction(int(true.p), int(true.q)) <= most


@pytest.mark.parametrize("slopes", [2, 1])
@with_many_digits
def test_a_function_to_a_power_holds_that_of_all_that_both_may_be(slopes: int) -> None:
    """Also where the function may be 0, between 0 and the largest power; its slopes are unknown there."""
    random = np.random.default_rng(31)
    points = Points.drawn(random, 400, 2, slopes)
    middle = ten_to(random, 400, -2, 2)
    x, v = points.operand(random, middle, middle * random.choice([0, 1e-6, 1e-2, 0.3, 0.8, 1.0, 1.5], 400))
    order, a = points.operand(random, random.uniform(0.2, 2.5, 400), random.choice([0, 1e-4, 0.1], 400))
    real = np.array([bool(value >= 0) for value in v[:, 0]])
    base = np.where(v[:, :1] > 0, v[:, :1], arb(1))
    whole = np.frompyfunc(lambda p, q: (p.log() * q).exp(), 2, 1)(base, a[:, :1])
    slopes = whole * (a[:, 1:] * np.frompyfunc(arb.log, 1, 1)(base) + a[:, :1] / base * v[:, 1:])
    whole = np.where(v[:, :1] > 0, whole, arb(0))
    with np.errstate(all="ignore"):
        found = x.to_the(order)
        kept = np.flatnonzero(real)
        cut = TaylorModel(found.c0[kept], found.c1[kept], found.c2[kept], found.r[kept])
        assert outside(cut, points.t[kept], np.concatenate([whole, slopes], 1)[kept]).tolist() == []
        assert known(found)[:, 0].mean() > 0.98
        low, high = (end[x.deviation[:, 0] > x.c0[:, 0], 0] for end in found.bounds())
    assert (low >= -1e-10 * high).all()


@pytest.mark.few("1-2")
@pytest.mark.parametrize(("sides", "order"), [(1, 2), (3, 2), (3, 1)])
@with_many_digits
def test_a_product_with_a_number_and_a_negative_hold_them(sides: int, order: int) -> None:
    """The number may be some roundings off."""
    random = np.random.default_rng(sides)
    for factor in (-3.7, 0.1, -1e-20, 1e15, 3e-310, -1e-200, 0.0):
        points, ((x, v), _) = pair_of_operands(random, 100, sides, order)
        off = arb(factor) * (1 + 4 * arb(ROUNDING) * random.choice([-1, 1]))
        assert outside(x.times(factor), points.t, off * v).tolist() == []
        assert outside(-x, points.t, -v).tolist() == []
        assert ((-x).r == x.r).all()


@pytest.mark.parametrize("order", [2, 1])
@with_many_digits
def test_where_takes_each_box_from_one_model_or_the_other(order: int) -> None:
    points, ((x, v), (y, w)) = pair_of_operands(np.random.default_rng(8), 200, 2, order)
    choice = np.arange(200) % 3 == 0
    found = x.where(choice, y)
    assert outside(found, points.t, np.where(choice[:, None], v, w)).tolist() == []
    for one, a, b in zip(
        (found.c0, found.c1, found.c2, found.r), (x.c0, x.c1, x.c2, x.r), (y.c0, y.c1, y.c2, y.r), strict=True
    ):
        assert (one[choice] == a[choice]).all()
        assert (one[~choice] == b[~choice]).all()


# Beginnings


@with_many_digits
def test_a_sum_of_many_coefficients_is_rounded_up() -> None:
    """1 and 3599 times 2^-54, each of which is lost where it is added to 1."""
    c2 = np.full((3, 1, 60, 60), 2.0**-54, order="F")
    c2[..., 0, 0] = 1
    none = np.zeros((3, 1), order="F")
    _, high = TaylorModel(none, np.zeros((3, 1, 60), order="F"), c2, none).bounds()
    assert min(map(Fraction, high.ravel().tolist())) >= 1 + Fraction(3599, 2**54)


def test_a_constant_a_variable_and_what_lies_between_hold_what_they_stand_for() -> None:
    """To within four roundings, and no more than a hundred; slopes of constants are 0, those of what lies between unknown."""
    random = np.random.default_rng(4)
    for value in (0.0, 1.5, -3e-7, 2e200, -7e-300, 5e-324, *random.normal(size=20)):
        found = constant(value, 3, 2)
        assert (found.c0[:, 1:] == 0).all()
        assert (found.r[:, 1:] == 0).all()
        assert not found.c1.any()
        assert not found.c2.any()
        for sign in (-1, 1):
            true = np.full((3, 3), arb(0))
            true[:, 0] = arb(value) * (1 + sign * 4 * arb(ROUNDING)) + sign * arb(2) ** -1075
            assert outside(found, np.zeros((3, 2)), true).tolist() == []
        assert (found.r[:, 0] <= 100 * ROUNDING * abs(value) + 1e-280).all()
    middle, radius = random.normal(size=(2, 30)) * [[3], [1]]
    for side in range(3):
        points = Points.drawn(random, 30, 3)
        found, straight = (variable(middle, abs(radius), 8.0, side, 3, slopes=n) for n in (2, 1))
        assert [x.c2.shape[1] for x in (found, straight)] == [4, 1]
        true = np.full((30, 4), arb(0))
        off = 8 * 4 * arb(ROUNDING) * random.choice([-1, 1])
        true[:, 0] = exactly(middle) + exactly(abs(radius) * points.t[:, side]) + off
        true[:, 1 + side] = exactly(abs(radius)) + off
        assert outside(found, points.t, true).tolist() == []
        assert outside(straight, points.t, true).tolist() == []
        assert (found.r <= 8 * 100 * ROUNDING).all()
        assert (np.delete(found.r, [0, 1 + side], 1) == 0).all()
    ends = np.sort(
        np.concatenate(
            [
                random.normal(size=(40, 2)),
                [[0, 5e-324], [-1 - 2**-52, 1], [-1, 1 + 2**-52], [-1e308, 1e308], [3, 3], [-5, -1]],
            ]
        ),
        1,
    )
    with np.errstate(over="ignore"):
        found = between(ends[:, 0], ends[:, 1], constant(0.0, 46, 2))
    low, high = (x[:, 0] for x in found.bounds())
    assert (low <= ends[:, 0]).all()
    assert (high >= ends[:, 1]).all()
    drawn = ends[:40]
    assert ((high - low)[:40] <= drawn[:, 1] - drawn[:, 0] + 1e-12 * np.abs(drawn).max(1)).all()
    for end in ends.T:
        true = np.repeat(exactly(end)[:, None], 3, 1)
        assert outside(found, np.zeros((46, 2)), true).tolist() == []
    assert not np.isfinite(found.r[:, 1:]).any()


# Functions


def slope_of_sinc(x: arb) -> arb:
    if abs(x) > 1:
        return (x.cos() - x.sin() / x) / x
    term, total = -x / 3, arb(0)
    for k in range(1, 60):  # term = (-1)^k 2 k x^(2 k - 1)/(2 k + 1)!
        total += term
        term *= -x * x * (k + 1) / (k * (2 * k + 2) * (2 * k + 3))
    return total


def away_from_zero(random: np.random.Generator, boxes: int) -> tuple[Array, Array]:
    """Middles of all sizes, and reaches that leave out 0."""
    size = np.where(random.uniform(size=boxes) < 0.7, ten_to(random, boxes, -2, 2), ten_to(random, boxes, -300, 300))
    share = random.choice([0, 1e-13, 1e-8, 1e-3, 1e-2, 0.1, 0.5, 0.85, 0.89], boxes)
    return size * random.choice([-1, 1], boxes), size * share


def positive(random: np.random.Generator, boxes: int) -> tuple[Array, Array]:
    middle, reach = away_from_zero(random, boxes)
    return abs(middle), reach


def angles(random: np.random.Generator, boxes: int) -> tuple[Array, Array]:
    """Some where a sine, a cosine, sin x/x or one of its first derivatives is 0, others huge, tiny or 0."""
    special = [0.0, np.pi, -np.pi / 2, 4.493409457909064, -7.725251836937707, 2.0815759778181, 1.5, -1.5, 1e-200, 3e9]
    middle = np.where(random.uniform(size=boxes) < 0.4, random.choice(special, boxes), random.normal(0, 4, boxes))
    return middle, random.choice([0, 1e-200, 1e-12, 1e-8, 1e-4, 1e-2, 0.3, 2], boxes)


def exponents(random: np.random.Generator, boxes: int) -> tuple[Array, Array]:
    middle = np.where(random.uniform(size=boxes) < 0.7, random.normal(0, 3, boxes), random.uniform(-900, 800, boxes))
    return middle, random.choice([0, 1e-12, 1e-6, 1e-2, 0.3, 2, 30, 700], boxes)


@dataclass(frozen=True)
class Function:
    ours: Callable[[TaylorModel], TaylorModel]
    value: Callable[[arb], arb]
    slope: Callable[[arb], arb]
    operands: Callable[..., tuple[Array, Array]]
    third: Callable[[float, float], float]
    """A bound on the size of the third derivative between two positive numbers."""


FUNCTIONS = {
    "cosine": Function(lambda x: x.cosine_and_sine()[0], arb.cos, lambda v: -v.sin(), angles, lambda x, y: 1.0),
    "sine": Function(lambda x: x.cosine_and_sine()[1], arb.sin, arb.cos, angles, lambda x, y: 1.0),
    "sinc": Function(TaylorModel.sinc, arb.sinc, slope_of_sinc, angles, lambda x, y: 0.25),
    "log": Function(TaylorModel.log, arb.log, lambda v: 1 / v, positive, lambda x, y: 2 / x**3),
    "exp": Function(TaylorModel.exp, arb.exp, arb.exp, exponents, lambda x, y: np.exp(y)),
    "sinc less 1": Function(TaylorModel.sincm1, lambda v: v.sinc() - 1, slope_of_sinc, angles, lambda x, y: 0.25),
    "reciprocal": Function(
        lambda x: x.number(1.0) / x, lambda v: 1 / v, lambda v: -1 / v**2, away_from_zero, lambda x, y: 6 / x**4
    ),
}


@pytest.mark.parametrize(("sides", "boxes", "order"), [(1, 500, 2), (3, 100, 2), (3, 100, 1)])
@pytest.mark.parametrize("name", FUNCTIONS)
@with_many_digits
def test_a_function_of_a_model_holds_that_of_all_that_the_operand_may_be(
    name: str, sides: int, boxes: int, order: int
) -> None:
    f, random = FUNCTIONS[name], np.random.default_rng(sum(map(ord, name)) + sides)
    points = Points.drawn(random, boxes, sides, order)
    x, v = points.operand(random, *f.operands(random, boxes))
    value = np.frompyfunc(f.value, 1, 1)(v[:, :1])
    true = np.concatenate([value, np.frompyfunc(f.slope, 1, 1)(v[:, :1]) * v[:, 1:]], 1)
    with np.errstate(all="ignore"):
        found = f.ours(x)
        assert outside(found, points.t, true).tolist() == []
        assert known(found)[:, 0].mean() > 0.6
        ordinary = (abs(x.c0[:, 0]) < 100) & ((abs(x.c0[:, 0]) > 1e-2) | (f.operands in (angles, exponents)))
        assert known(found)[ordinary & (x.deviation[:, 0] < 100)].mean() > 0.98


@pytest.mark.parametrize("name", ["log", "reciprocal"])
@with_many_digits
def test_nothing_is_known_where_a_pole_or_the_log_of_zero_may_lie_in_the_box(name: str) -> None:
    """Of no slope either, whatever it is."""
    random = np.random.default_rng(1)
    points = Points.drawn(random, 400, 2)
    size = ten_to(random, 400, -200, 200)
    middle = size * random.choice([-1.0, 0.0, 1.0], 400)
    x, _ = points.operand(random, middle, size * random.choice([1.0001, 2, 1e9], 400))
    for operand in (x, replace(x, r=x.r + np.inf), replace(x, c0=x.c0 * np.nan), replace(x, c0=x.c0 * 0, c1=x.c1 * 0)):
        near = ~(operand.deviation[:, 0] < abs(operand.c0[:, 0]))
        with np.errstate(all="ignore"):
            low, high = FUNCTIONS[name].ours(operand).bounds()
        assert near.mean() > 0.5
        assert (low[near] == -np.inf).all()
        assert (high[near] == np.inf).all()
    with np.errstate(all="ignore"):
        below = replace(x, c0=-abs(x.deviation) * 3 - 1).log()
        assert np.isinf(np.array(below.bounds())[:, :, 0]).all()


# How near


def flat(middle: float) -> TaylorModel:
    """A number without error, as a function on one side, whose slope is 1."""
    return TaylorModel(np.array([[middle, 1.0]]), np.zeros((1, 2, 1)), np.zeros((1, 2, 1, 1)), np.zeros((1, 2)))


@pytest.mark.parametrize("name", FUNCTIONS)
@with_many_digits
def test_a_function_of_an_exact_straight_line_is_known_to_third_order(name: str) -> None:
    """The radius is at most the largest |f'''| rho^3/6, and not much more than what the parabola misses at an end."""
    f = FUNCTIONS[name]
    for middle in (1.3, 0.7, 2.4):
        for reach in (0.5, -1e-2, 1e-4, 1e-7):
            x = replace(flat(middle), c1=np.array([[[reach], [0.0]]]))
            found, v = f.ours(x), [arb(middle) + sign * arb(reach) for sign in (-1, 1)]
            lost = 300 * ROUNDING * (abs(float(f.value(arb(middle)))) + 1)
            assert (
                found.r[0, 0]
                <= (1 + 1e-12) * f.third(middle - abs(reach), middle + abs(reach)) / 6 * abs(reach) ** 3 + lost
            )
            missed = [f.value(y) - at(found, np.array([[sign]]))[0, 0] for sign, y in zip((-1.0, 1.0), v, strict=True)]
            assert max(map(abs, missed)) <= arb(float(found.r[0, 0]))
            if abs(reach) < 0.1 and name not in ("cosine", "sine", "sinc", "sinc less 1"):
                assert found.r[0, 0] <= 1.3 * float(max(map(abs, missed))) + lost
            slopes = [f.slope(y) - at(found, np.array([[sign]]))[0, 1] for sign, y in zip((-1.0, 1.0), v, strict=True)]
            assert max(map(abs, slopes)) <= arb(float(found.r[0, 1]))


@with_many_digits
def test_the_slope_of_sinc_is_known_to_within_roundings_of_its_size_near_zero_and_to_fourth_order() -> None:
    for middle in (0.0, 1e-9, -1e-3):
        found = flat(middle).sinc()
        assert found.r[0, 1] <= 300 * ROUNDING * abs(middle) + 1e-280
    for reach in (0.5, 0.1, 1e-3):
        found = replace(flat(0.0), c1=np.array([[[reach], [0.0]]])).sinc()
        missed = slope_of_sinc(arb(reach)) - at(found, np.array([[1.0]]))[0, 1]
        assert missed <= arb(float(found.r[0, 1]))
        assert found.r[0, 1] <= 1.1 * float(missed) + 1e-14


@with_many_digits
def test_what_a_product_misses_is_attained() -> None:
    """All signs the same, t at a corner: the third and fourth order of the product, and each radius times the other's size."""
    random = np.random.default_rng(11)
    for _ in range(30):
        n = int(random.integers(1, 4))
        x, y = (
            TaylorModel(
                *(random.choice([0.0, 1.0, 2.5], (1, 1, *(n,) * order)) for order in (0, 1, 2)),
                random.choice([0.0, 1.0], (1, 1)),
            )
            for _ in range(2)
        )
        lone = [
            replace(z, **{k: np.pad(getattr(z, k), [(0, 0), (0, n), *[(0, 0)] * d]) for k, d in KEYS}) for z in (x, y)
        ]
        found = lone[0] * lone[1]
        most = [float((np.abs(z.c0) + z.deviation)[0, 0]) for z in lone]
        assert (np.abs(found.c0) + found.deviation)[0, 0] == pytest.approx(most[0] * most[1], rel=1e-12)


KEYS = (("c0", 0), ("c1", 1), ("c2", 2), ("r", 0))


# Programs and formulas


X, Y = Symbol("x", positive=True), Symbol("y", positive=True)

X, Y = Symbol("x", positive=True), Symbol("y", positive=True)

C = Rational(7, 3)

RATIONAL: list[Expr] = [
    X + C, C - X, X - C, 5 * X, -X / 3, X / C, C / X, X + Y, X - Y, Y - X, X * Y, X / Y, 1 / (X * Y), -X, X**3 - 2 * X, (X + 2 * Y) / (3 - X * Y / 40), X**-2 + Y, pi * X - Y / pi**2, X + 0 * Y,
]  # fmt: skip

OTHERS: list[Expr] = [
    cos(X * Y), sin(X + 1), cos(1) * X - sin(Rational(2)) / Y, sinc(X) + Y, X**Y, (X + Y) ** Rational(1, 3), X * sqrt(2) + sqrt(Y), X * cos(C) ** 2 + Rational(3, 2) ** Rational(1, 3),
]  # fmt: skip


def boxes(draw: random.Random, radius: float) -> list[TaylorModel]:
    middles = np.array([[draw.uniform(0.5, 3) for _ in range(2)] for _ in range(6)])
    return [variable(middles[:, i], np.full(6, radius), 4.0, i, 2) for i in range(2)]


def assert_holds(found: TaylorModel, given: list[TaylorModel], formula: Expr, radius: float) -> None:
    """The value and both slopes, in units of half a box, at corners and inside; nothing is given away in points."""
    exact = [lambdify((X, Y), f, "mpmath") for f in (formula, radius * diff(formula, X), radius * diff(formula, Y))]
    low, high = found.bounds()
    with mpmath.workdps(40):
        for n in range(6):
            for t in ((0, 0), (1, 1), (-1, 1), (0.5, -1)):
                at = [mpmath.mpf(float(x.c0[n, 0])) + radius * mpmath.mpf(u) for x, u in zip(given, t, strict=True)]
                for i, f in enumerate(exact):
                    assert low[n, i] <= f(*at) <= high[n, i]
    size = 1 + np.abs(found.c0[:, :1])
    assert ((high - low) <= (1e-11 + 40 * radius * (radius + (np.arange(3) == 0))) * size).all()


@pytest.mark.parametrize("radius", [0.0, 1 / 64])
@pytest.mark.parametrize("formula", [*RATIONAL, *OTHERS], ids=str)
def test_a_program_has_the_values_and_slopes_of_its_formula(formula: Expr, radius: float) -> None:
    write = Writer((X, Y))
    given = boxes(random.Random(str(formula)), radius)
    found = Modelled(write.program({"it": write.expression(formula)})).run(given)["it"]
    assert isinstance(found, TaylorModel)
    assert_holds(found, given, formula, radius)


@pytest.mark.parametrize("formula", RATIONAL, ids=str)
def test_a_rational_formula_has_its_values_and_slopes(formula: Expr) -> None:
    for radius in (0.0, 1 / 64):
        given = boxes(random.Random(str(formula)), radius)
        assert_holds(valued(formula, dict(zip((X, Y), given, strict=True)), given[0]), given, formula, radius)


def test_a_number_that_no_input_is_in_is_one_float_and_what_is_too_large_is_none() -> None:
    write = Writer((X, Y))
    numbers = {"one": cos(1) / pi + 2, "two": sqrt(2) - 5, "three": Rational(1, 3)}
    found = Modelled(write.program({name: write.expression(x) for name, x in numbers.items()})).run(
        boxes(random.Random(1), 0.0)
    )
    assert found == {name: pytest.approx(float(x.evalf(30)), rel=1e-15) for name, x in numbers.items()}
    for x in (*numbers.values(), 10**400 / Rational(10**399)):
        assert floated(x) == pytest.approx(float(x.evalf(30)), rel=1e-15)
    with pytest.raises(UndecidedError, match="too large for floats"):
        floated(Rational(10**400))


# Zeros on the axis over boxes of values


P, Q, U = (Symbol(name, real=True) for name in "pqu")

P, Q, U = (Symbol(name, real=True) for name in "pqu")

P, Q, U = (Symbol(name, real=True) for name in "pqu")

ALPHA = Symbol("alpha", positive=True)

LATE = exp(-s)

Ranges = Mapping[Symbol, tuple[Any, Any]]


def form(D: Expr, ranges: Ranges) -> OnAxis:
    ring = Ring.of([D])
    exact = {x: (Rational(low), Rational(high)) for x, (low, high) in ranges.items()}
    return OnAxis(ring, ring.convert(D.expand()).numerator, exact)


EXPONENT: Ranges = {ALPHA: ("1/2", "3/4")}


@pytest.mark.parametrize(
    ("D", "ranges", "reach"),
    [
        (s**2 + 12, {}, 4), (s**2 - 12, {}, 4), (s**2 + 16, {}, 8), (2 * s**2 - 12, {}, 4), (3 * s**3 + 100, {}, 4), (s**2 - 3 * s - 2, {}, 4),
        # a s + b is as large as either of the two where both have one sign and neither comes late: 100/r > 1/r^2
        (s**2 + 100 * s + 1, {}, Rational(1, 64)), (-(s**2) - 100 * s + 1, {}, Rational(1, 64)), (s**2 + 100 * s - 1, {}, Rational(1, 64)),
        (s**2 - 100 * s + 1, {}, 128), (s**2 + 100 * s * LATE + 1, {}, 128), (s**2 + 100 * s + LATE, {}, Rational(1, 64)),
        (s**2 * (1 + LATE / 2) + 100 * s + 1, {}, 256), (s**2 * (1 - LATE / 2) + 100 * s + 1, {}, 256), (s**2 * LATE / 2 + s**2 + 100, {}, 16),
        (s**2 + 100 * s + 10 * sqrt(s) + 1, {}, Rational(1, 32)), (s**2 + 100 * s + 10 * s * sqrt(s) + 1, {}, 512),
        (s**2 + 100 * s + P * s + 1, {P: (0, 1)}, Rational(1, 64)), (s**2 + 100 * s + P * s + 1, {P: ("-1/9", 1)}, 128), (s + 1, {}, Rational(1, 2**20)), (s**2 + P * s + 1, {P: (1, 100)}, 2),
        # a power of s that is not known: r^(1/4) > 2, and r^(1/2) > 1/4
        (s + 2 * s**ALPHA, EXPONENT, 32), (s + s**ALPHA / 4, EXPONENT, Rational(1, 8)), (s**2 + 2 * s**ALPHA * s - s**ALPHA, EXPONENT, 32),
        (s**ALPHA + s ** Rational(5, 8), EXPONENT, None), (s ** Rational(3, 4) + s**ALPHA, EXPONENT, None), (s * (1 + 2 * LATE) + 1, {}, None), (s * (1 + LATE) + 1, {}, None),
        (P * s + 1, {P: (0, 1)}, Rational(1, 2**20)), (P * s - 1, {P: (0, 1)}, None), ((1 + P) * s - 1, {P: (0, 1)}, 2), (s - P, {P: (-3, 1)}, 4), (s - P, {P: (-1, 3)}, 4),
    ],
    ids=str,
)  # fmt: skip
def test_the_reach_is_the_first_power_of_two_at_which_the_highest_power_exceeds_all_others(
    D: Expr, ranges: Ranges, reach: Any
) -> None:
    assert form(D, ranges).reach == (None if reach is None else float(reach))


@pytest.mark.parametrize("order", [{P: (0, 2), Q: (0, 2)}, {Q: (0, 2), P: (0, 2)}])
def test_a_coefficient_is_bounded_over_pieces_of_all_ranges(order: Ranges) -> None:
    """3/4 (1 - p)^4 (1 - q)^4 is at most 3/4 where p and q are 0 to 2, and its terms together 192."""
    assert form(s - Rational(3, 4) * (1 - P) ** 4 * (1 - Q) ** 4, order).reach in (1, 2)


@pytest.mark.dear("-1/2-True")
@pytest.mark.parametrize(
    ("low", "left"), [("1/8", False), ("-1/2", True), pytest.param("0", True, marks=pytest.mark.slow)]
)
def test_cells_are_left_where_a_zero_is_on_the_axis_and_nowhere_else(low: str, *, left: bool) -> None:
    """s^2 + p s + 9, p up to 1: omega = 3 at p = 0."""
    found = form(s**2 + P * s + 9, {P: (low, 1)})
    cells = found.left()
    assert (len(cells) > 0) is left
    if left:
        assert found.reach is not None
        place = np.array([3 / found.reach, float(-Rational(low) / (1 - Rational(low)))])
        assert ((cells[:, :, 0] <= place) & (place <= cells[:, :, 1])).all(-1).any()
        assert np.abs(cells.mean(-1) - place).max() < 0.01


def test_both_parts_in_points_are_those_of_complex_numbers() -> None:
    """(20 + p^2 q) s^2 + 3 pi p s exp(-s) - q at j omega; u is in none."""
    D = (20 + P**2 * Q) * s**2 + 3 * pi * P * s * LATE - Q
    found = form(D, {U: (5, 9), P: (1, 3), Q: (-2, 2)})
    assert found.reach is not None
    at = np.array([[0.5, 0.5, 0.25, 0.75], [0.125, 0.0, 1.0, 0.0], [1.0, 1.0, 0.0, 1.0]])
    real, imag = found.parts(np.stack([at, at], -1))
    for n, (x, _, y, z) in enumerate(at.tolist()):
        w, p, q = 1j * found.reach * x, 1 + 2 * y, -2 + 4 * z
        true = (20 + p**2 * q) * w**2 + 3 * np.pi * p * w * np.exp(-w) - q
        assert (real.c0[n, 0], imag.c0[n, 0]) == pytest.approx((true.real, true.imag), rel=1e-12, abs=1e-11)
