"""Functions over many small boxes at once, with proven bounds: Taylor models of second order for
values and slopes.

A ``TaylorModel`` is a function of t in [-1, 1]^n as ``c0 + c1.t + t.c2.t``, and a radius ``r`` that
bounds all the rest, together with the same for each of its n slopes d/dt_i: rows of the arrays, the
value first; and all that for each of many boxes. What intervals lose where a variable occurs twice,
models keep to third order. Of many variables slopes may be kept to first order alone: n^2 numbers
then, where n^3 take most of the time. Floats, with every rounding error in ``r``: a model is a
proof, not an estimate. Where ``r`` is not finite nothing is known.

A *box* is a product of intervals, one *side* for each variable, and t runs over [-1, 1] along each
side. A model is *linear* where its slopes are kept to first order alone. Begin with
``TaylorModel`` and the two functions ``_product`` and ``_quotient`` that its arithmetic rests on.
Programs (``Modelled``) and rational formulas (``valued``) run in such models.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any, TypeAlias

import flint
from sympy import Add, Expr, Mul, Pow, Rational

from haptisym.kernel.arrays import np
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import expression_ball
from haptisym.programs.balls import FUNCTIONS, constant_ball
from haptisym.programs.floats import sinc_and_slopes, sincm1
from haptisym.programs.program import Program

Array: TypeAlias = Any  # numpy arrays of floats

# The error counted for an operation, relative to the largest values of its operands: room for some
# ten roundings of 2^-53 in each of them.
_ROUNDING = 1e-14
_TINY = 1e-290  # counted against underflow: of a value, and of a coefficient


@dataclass(frozen=True, eq=False)
class TaylorModel:
    """``c0`` (boxes, m), ``c1`` (boxes, m, n), ``c2`` (boxes, m, n, n), ``r`` (boxes, m).

    m = 1 + n: the value and its slopes; or m = 1: the value alone. Slopes of first order have no
    rows in ``c2``.
    """

    c0: Array
    c1: Array
    c2: Array
    r: Array

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Coefficients and remainder."""
        return self.c0, self.c1, self.c2, self.r

    @cached_property
    def deviation(self) -> Array:
        """Bounds on the distance from ``c0``."""
        return self._first + self._second + self.r

    @cached_property
    def _first(self) -> Array:
        return _sum_of_sizes(self.c1, 1)

    @cached_property
    def _second(self) -> Array:
        sizes = _sum_of_sizes(self.c2, 2)
        if sizes.shape == self.c0.shape:
            return sizes
        # Rows of first order have no second part.
        rows = sizes.shape[1]
        none = np.zeros_like(self.c0[:, rows:])
        return np.concatenate([sizes, none], 1)

    @property
    def is_linear(self) -> bool:
        """Whether some of its rows are of first order."""
        return bool(self.c2.shape[1] < self.c0.shape[1])

    def bounds(self) -> tuple[Array, Array]:
        """The least and the greatest that the value and each slope can be, (boxes, m); infinite
        where nothing is known."""
        # Widened outward: the sums of the radius round, and so do middle -+ radius below.
        with np.errstate(over="ignore", invalid="ignore"):  # what is too large is unknown
            of_middle = np.abs(self.c0) * _ROUNDING
            radius = self.deviation * (1 + _ROUNDING) + of_middle
        known = np.isfinite(radius) & np.isfinite(self.c0)
        radius = np.where(known, radius, np.inf)
        middle = np.where(known, self.c0, 0.0)
        return middle - radius, middle + radius

    def __add__(self, other: TaylorModel) -> TaylorModel:
        sizes = np.abs(self.c0) + self.deviation + np.abs(other.c0) + other.deviation
        return TaylorModel(
            self.c0 + other.c0,
            self.c1 + other.c1,
            self.c2 + other.c2,
            self.r + other.r + _ROUNDING * sizes,
        )

    def __neg__(self) -> TaylorModel:
        return TaylorModel(-self.c0, -self.c1, -self.c2, self.r)

    def __sub__(self, other: TaylorModel) -> TaylorModel:
        return self + -other

    def __mul__(self, other: TaylorModel) -> TaylorModel:
        """The product, its slopes by the product rule."""
        if self.is_linear:
            slopes = _product(self._slopes, other._value)
            other_half = slopes if other is self else _product(self._value, other._slopes)
            value = _product(self._value, other._value)
            return value._over(slopes + other_half)
        # (x y)' = x' y + x y': all rows of x times the value of y give the value and the first
        # half. Of a square both halves are equal, which spares a product.
        whole = _product(self, other._value)
        if other is self:
            doubled = []
            for x in whole.arrays:
                value, slopes = x[:, :1], x[:, 1:]
                doubled.append(np.concatenate([value, 2 * slopes], 1))
            return TaylorModel(*doubled)
        if self.c0.shape[1] > 1:
            second_half = _product(self._value, other._slopes)
            for array, more in zip(whole.arrays, second_half.arrays, strict=True):
                array[:, 1:] += more
        return whole

    @cached_property
    def _value(self) -> TaylorModel:
        if self.c0.shape[1] == 1:
            return self
        return TaylorModel(*(x[:, :1] for x in self.arrays))

    @cached_property
    def _slopes(self) -> TaylorModel:
        return TaylorModel(*(x[:, 1:] for x in self.arrays))

    def times(self, x: float) -> TaylorModel:
        """The product with a number that is known to within some roundings."""
        whole = abs(x) * (np.abs(self.c0) + self.deviation)
        r = self.r * abs(x) + _ROUNDING * whole + _TINY
        return TaylorModel(self.c0 * x, self.c1 * x, self.c2 * x, r)

    def __truediv__(self, other: TaylorModel) -> TaylorModel:
        """The quotient q, its slopes (x' - q y')/y; unknown where the divisor may be 0."""
        # Not (x' y - x y')/y^2, in which two large terms would cancel over a square: the quotient
        # is already known to third order.
        y = other._value
        q = _quotient(self._value, y)
        if self.c0.shape[1] == 1:
            return q
        rest = self._slopes - _product(q, other._slopes)
        return q._over(_quotient(rest, y))

    def number(self, x: float) -> TaylorModel:
        """A number that is known to within some roundings, over the same boxes."""
        boxes, rows, sides = self.c1.shape
        order = 1 if self.is_linear else 2
        return constant(x, boxes, sides, slopes=0 if rows == 1 else order)

    def plus(self, x: float) -> TaylorModel:
        """The sum with a number that is known to within some roundings."""
        c0 = self.c0.copy()
        r = self.r.copy()
        c0[:, 0] += x
        middle = self.c0[:, 0]
        sizes = abs(x) + np.abs(middle) + self.deviation[:, 0]
        r[:, 0] += _ROUNDING * sizes + _TINY
        return TaylorModel(c0, self.c1, self.c2, r)

    def cosine_and_sine(self) -> tuple[TaylorModel, TaylorModel]:
        """The cosine and the sine of this function, an angle in radians."""
        # Taylor's theorem about the middle a: no third derivative exceeds 1.
        a = self.c0[:, :1]
        rest = self.deviation[:, :1] ** 3 / 6
        c = np.cos(a)
        s = np.sin(a)
        cosine = self._composed(c, -s, -c / 2, rest)
        sine = self._composed(s, c, -s / 2, rest)
        return self._chained(cosine, -sine), self._chained(sine, cosine)

    def sinc(self) -> TaylorModel:
        """sin x/x, whose n-th derivative is nowhere larger than 1/(n + 1); the first is a
        difference of larger numbers."""
        # sin x/x is the mean of cos(u x) for u from 0 to 1, so its n-th derivative is at most the
        # mean of u^n: 1/4 bounds the remainder of the value, 1/5 that of the slope.
        a = self.c0[:, :1]
        rest = self.deviation[:, :1] ** 3 / 6
        f, df, d2f, d3f = sinc_and_slopes(a)
        lost = _ROUNDING * np.minimum(np.abs(a), 1)
        value = self._composed(f, df, d2f / 2, rest / 4)
        slope = self._composed(df, d2f, d3f / 2, rest / 5 + lost)
        return self._chained(value, slope)

    def sincm1(self) -> TaylorModel:
        """sin x/x - 1, to within roundings of itself also where x is small."""
        a = self.c0[:, :1]
        # The third derivative is that of sinc, at most 1/4; and so are the slopes those of sinc.
        _, df, d2f, _ = sinc_and_slopes(a)
        rest = self.deviation[:, :1] ** 3 / 24
        value = self._composed(sincm1(a), df, d2f / 2, rest)
        if self.c0.shape[1] == 1:
            return value
        return value._over(self.sinc()._slopes)

    def to_the(self, order: TaylorModel) -> TaylorModel:
        """A function >= 0 to a power > 0: where it may be 0 its slopes are unknown."""
        smooth = (self.log() * order).exp()
        # The logarithm has no bound where the function may be 0. There the power lies between 0 and
        # that of the upper bound, which is monotone in the exponent and so largest at one of its
        # ends; 1e-12 is for the rounding of floating-point powers.
        lowest_order, highest_order = (x[:, 0] for x in order.bounds())
        _, upper = self.bounds()
        top = np.maximum(upper[:, 0], 0.0)
        greatest = np.maximum(top**lowest_order, top**highest_order)
        rough = between(np.zeros(len(top)), greatest * (1 + 1e-12), self)
        _, smooth_upper = smooth.bounds()
        known = np.isfinite(smooth_upper).all(-1)
        return smooth.where(known, rough)

    def log(self) -> TaylorModel:
        """The logarithm; unknown where the function may be 0."""
        # log(a + x) = log a + x/a - x^2/(2 a^2) + ..., and all later terms are at most rho^3/3 (1 +
        # rho + ...). At rho = 1 the function may be 0, and near it the bound is useless.
        a = self.c0[:, :1]
        rho = self.deviation[:, :1] / a
        useful = (rho >= 0) & (rho < 0.9)
        later_terms = rho**3 / 3 / (1 - rho)
        rest = np.where(useful, later_terms, np.inf)
        half_of_second = -1 / (2 * a**2)
        value = self._composed(np.log(a), 1 / a, half_of_second, rest)
        one = self._value.number(1.0)
        return self._chained(value, _quotient(one, self._value))

    def exp(self) -> TaylorModel:
        """The exponential."""
        # The third derivative is at most exp(a + d); exp(a) may underflow to 0, its remainder not.
        e = np.exp(self.c0[:, :1])
        d = self.deviation[:, :1]
        largest = np.maximum(e, _TINY)
        rest = largest * d**3 / 6 * np.exp(d)
        value = self._composed(e, e, e / 2, rest)
        return self._chained(value, value)

    def _composed(self, f: Array, df: Array, half: Array, rest: Array) -> TaylorModel:
        """The model of f + df x + half x^2 + rest for x = the value minus its middle; without
        slopes."""
        x1 = self.c1[:, :1]
        x2 = self.c2[:, :1]
        r = self.r[:, :1]
        d1 = _sum_of_sizes(x1, 1)
        d2 = _sum_of_sizes(x2, 2)
        df_row = df[..., None]
        df_size = np.abs(df)
        half_size = np.abs(half)
        c1 = df_row * x1
        # Of x^2 = (x1.t + ...)^2 the product of the linear parts is of second order and stays a
        # coefficient; its cross terms with x2 and r, and their squares, go to the remainder.
        column = x1[..., :, None]
        row = x1[..., None, :]
        outer = column * half[..., None, None] * row
        c2 = df_row[..., None] * x2 + outer
        later = d2 + r
        square = 2 * d1 * later + later**2
        size = np.abs(f) + df_size * (d1 + d2)
        size = size + half_size * d1**2
        # Rounding is relative to the size of f, c1 and c2 together. What may underflow in df and
        # half is multiplied by x and by x^2, hence the square.
        underflow = _TINY * (1 + self.deviation[:, :1]) ** 2
        lost = _ROUNDING * size + underflow
        radius = df_size * r + half_size * square + rest
        return TaylorModel(f, c1, c2, radius * (1 + _ROUNDING) + lost)

    def _chained(self, value: TaylorModel, slope: TaylorModel) -> TaylorModel:
        """The value in row 0, and slope times each slope of this function in the others."""
        if self.c0.shape[1] == 1:
            return value
        return value._over(_product(slope, self._slopes))

    def _over(self, slopes: TaylorModel) -> TaylorModel:
        """This value with those slopes."""
        pairs = zip(self.arrays, slopes.arrays, strict=True)
        return TaylorModel(*(np.concatenate(pair, 1) for pair in pairs))

    def where(self, known: Array, other: TaylorModel) -> TaylorModel:
        """This model for the boxes where ``known`` holds, and the other one for the rest."""
        rows = known[:, None]
        return TaylorModel(
            np.where(rows, self.c0, other.c0),
            np.where(rows[..., None], self.c1, other.c1),
            np.where(rows[..., None, None], self.c2, other.c2),
            np.where(rows, self.r, other.r),
        )


def _sum_of_sizes(x: Array, axes: int) -> Array:
    """The sum of sizes along the last axes, or a little more: each addition rounds, and of many
    variables there are many."""
    last = tuple(range(-axes, 0))
    total = np.add.reduce(np.abs(x), last)
    count = x.shape[-1] ** axes
    return total * (1 + count * 2.0**-53)


def _product(x: TaylorModel, y: TaylorModel) -> TaylorModel:
    """The product, row by row; one of the two factors may have a single row."""
    x0 = x.c0[..., None]
    y0 = y.c0[..., None]
    x0_size, x1_size, x2_size = np.abs(x.c0), x._first, x._second
    y0_size, y1_size, y2_size = np.abs(y.c0), y._first, y._second
    c0 = x.c0 * y.c0
    c1 = x0 * y.c1 + y0 * x.c1
    x_size = x0_size + x1_size + x2_size
    y_size = y0_size + y1_size + y2_size
    # Products of polynomial parts that are of third order or higher, then each remainder times all
    # of the other factor.
    r = x1_size * y2_size + x2_size * (y1_size + y2_size)
    r = r + x_size * y.r
    r = r + x.r * (y_size + y.r)
    if x.is_linear or y.is_linear:
        # Rows of first order have nowhere to keep second-order terms: these are bounded as well.
        sides = c1.shape[-1]
        c2 = np.empty((len(c0), 0, sides, sides))
        r = r + x0_size * y2_size + y0_size * x2_size
        r = r + x1_size * y1_size
    else:
        c2 = x0[..., None] * y.c2 + y0[..., None] * x.c2
        column = x.c1[..., :, None]
        row = y.c1[..., None, :]
        c2 = c2 + column * row
    lost = _ROUNDING * (x_size * y_size)
    r = r * (1 + _ROUNDING) + lost + _TINY
    return TaylorModel(c0, c1, c2, r)


def _quotient(x: TaylorModel, y: TaylorModel) -> TaylorModel:
    """Each row over a value: the parabola q for which x - q y begins with the third order, and how
    large (x - q y)/y is.

    Of rows of first order it is the line for which that begins with the second. Of numerator and
    denominator that vary alike nothing is lost so, and little of others.
    """
    # x = q y, solved order by order. These coefficients need no error bounds: whatever q is, it is
    # off by (x - q y)/y, which is bounded afterwards, rounding included.
    y0 = y.c0
    y0_row = y0[..., None]
    y0_matrix = y0[..., None, None]
    w1 = y.c1 / y0_row
    w2 = y.c2 / y0_matrix
    c0 = x.c0 / y0
    c0_row = c0[..., None]
    c1 = x.c1 / y0_row - c0_row * w1
    c2 = x.c2
    if not x.is_linear:
        c2 = c2 / y0_matrix - c0_row[..., None] * w2
        column = c1[..., :, None]
        row = w1[..., None, :]
        c2 = c2 - column * row
    quotient = TaylorModel(c0, c1, c2, np.zeros(c0.shape))
    missed = x - _product(quotient, y)
    missed_size = np.abs(missed.c0) + missed.deviation
    # The least size that the divisor has; not positive where it may be 0.
    farthest = y.deviation * (1 + _ROUNDING)
    least = np.abs(y0) * (1 - _ROUNDING) - farthest
    r = missed_size / least * (1 + _ROUNDING) + _TINY
    r = np.where(least > 0, r, np.inf)
    return TaylorModel(c0, c1, c2, r)


def constant(value: float, boxes: int, sides: int, *, slopes: int = 2) -> TaylorModel:
    """A number, known to within some roundings; its slopes are 0."""
    rows = 1 + sides if slopes else 1
    r = np.zeros((boxes, rows))
    return _flat(np.full(boxes, value), r, sides, linear=slopes == 1)


def variable(
    middle: Array, radius: Array, size: Array, side: int, sides: int, *, slopes: int = 2
) -> TaylorModel:
    """middle + radius t_side for each box, to within some roundings of numbers up to ``size``.

    ``slopes`` : their order, 2 or 1; without them if 0.
    """
    r = np.zeros((len(middle), 1 + sides))
    model = _flat(middle, r, sides, linear=slopes == 1)
    model.c1[:, 0, side] = radius
    # The slope along t_side, which is the radius; the others are 0.
    model.c0[:, 1 + side] = radius
    lost = _ROUNDING * size + _TINY
    model.r[:, 0] = lost
    model.r[:, 1 + side] = lost
    return model if slopes else model._value


def between(low: Array, high: Array, like: TaylorModel) -> TaylorModel:
    """A function that lies between two numbers, with slopes of which nothing is known; ``like`` :
    any model over the boxes."""
    r = np.full(like.c0.shape, np.inf)
    r[:, 0] = (high - low) / 2 * (1 + _ROUNDING)
    middle = (low + high) / 2
    sides = like.c1.shape[-1]
    return _flat(middle, r, sides, linear=like.is_linear)


def _flat(value: Array, r: Array, sides: int, *, linear: bool) -> TaylorModel:
    """The model of a constant in each box, with these remainders."""
    # Column order: the boxes lie side by side in memory, and every operation runs along them.
    boxes, rows = r.shape
    c0 = np.zeros((boxes, rows), order="F")
    c1 = np.zeros((boxes, rows, sides), order="F")
    of_second_order = 1 if linear else rows
    c2 = np.zeros((boxes, of_second_order, sides, sides), order="F")
    c0[:, 0] = value
    r[:, 0] += _ROUNDING * np.abs(value) + _TINY
    return TaylorModel(c0, c1, c2, np.asfortranarray(r))


ModelOrFloat: TypeAlias = TaylorModel | float
"""Numbers that are the same everywhere stay floats, to within some roundings."""


def _sum(x: ModelOrFloat, y: ModelOrFloat) -> ModelOrFloat:
    if isinstance(x, TaylorModel):
        return x + y if isinstance(y, TaylorModel) else x.plus(y)
    # Two floats never meet: a step without inputs is among the constants of ``Modelled``.
    assert isinstance(y, TaylorModel)
    return y.plus(x)


def _product_in_modelled(x: ModelOrFloat, y: ModelOrFloat) -> ModelOrFloat:
    if isinstance(x, TaylorModel):
        return x * y if isinstance(y, TaylorModel) else x.times(y)
    assert isinstance(y, TaylorModel)
    return y.times(x)


def _quotient_in_modelled(x: ModelOrFloat, y: ModelOrFloat) -> ModelOrFloat:
    one = x if isinstance(x, TaylorModel) else y
    assert isinstance(one, TaylorModel)
    upper = x if isinstance(x, TaylorModel) else one.number(x)
    lower = y if isinstance(y, TaylorModel) else one.number(y)
    return upper / lower


def _power_in_modelled(x: TaylorModel, order: ModelOrFloat) -> TaylorModel:
    return x.to_the(order if isinstance(order, TaylorModel) else x.number(order))


OPERATIONS: dict[str, Callable[..., ModelOrFloat]] = {
    "add": _sum,
    "sub": lambda x, y: _sum(x, -y),
    "mul": _product_in_modelled,
    "div": _quotient_in_modelled,
    "neg": lambda x: -x,
    "cos": lambda x: x.cosine_and_sine()[0],
    "sin": lambda x: x.cosine_and_sine()[1],
    "sinc": TaylorModel.sinc,
    "sincm1": TaylorModel.sincm1,
    "power": _power_in_modelled,
}


@dataclass(frozen=True, eq=False)
class Modelled:
    """A program that runs in Taylor models; it must be one without ``abs`` and ``sqrt``, whose
    slopes are not continuous."""

    program: Program

    def run(self, inputs: Sequence[TaylorModel]) -> dict[str, ModelOrFloat]:
        """The results by name, for inputs in the order of the program's own; a result that depends
        on no input is a float."""
        known: dict[int, ModelOrFloat] = dict(self._constants)
        for i, step in enumerate(self.program.operations):
            if step.name == "input":
                known[i] = inputs[step.arguments[0]]
            elif i not in known:
                tick()
                operands = [known[x] for x in step.arguments]
                known[i] = OPERATIONS[step.name](*operands)
        return {name: known[x] for name, x in self.program.results.items()}

    @cached_property
    def _constants(self) -> Mapping[int, float]:
        """The steps that depend on no input, to within a rounding."""
        # In floats a difference of two constants could lose all its digits, and no remainder would
        # say so: models count constants as known to within some roundings.
        balls: dict[int, Any] = {}
        with flint.ctx.workprec(200):
            for i, step in enumerate(self.program.operations):
                if step.name == "constant":
                    balls[i] = constant_ball(step.value)
                    continue
                is_constant = all(x in balls for x in step.arguments)
                if step.name != "input" and is_constant:
                    operands = [balls[x] for x in step.arguments]
                    balls[i] = FUNCTIONS[step.name](*operands)
            return {i: float(x.mid()) for i, x in balls.items()}


def valued(formula: Expr, known: Mapping[Expr, TaylorModel], like: TaylorModel) -> TaylorModel:
    """The model of a formula: sums, products, quotients and whole powers of exact numbers and of
    the expressions that are ``known``; ``like`` : any model over the same cells."""
    if formula in known:
        return known[formula]
    if not formula.free_symbols & set(known):
        return like.number(floated(formula))
    if isinstance(formula, Add):
        terms = [valued(x, known, like) for x in formula.args]
        return sum(terms[1:], terms[0])
    one = like.number(1.0)
    # Without a start ``prod`` begins with the integer 1, with which models do not multiply.
    if isinstance(formula, Mul):
        return prod((valued(x, known, like) for x in formula.args), start=one)
    assert isinstance(formula, Pow)
    base = valued(formula.base, known, like)
    factors = [base] * abs(int(formula.exp))
    power = prod(factors, start=one)
    return power if formula.exp > 0 else one / power


def floated(value: Expr) -> float:
    """The number to within a rounding or two. UndecidedError where it is too large for a float."""
    if isinstance(value, Rational):
        try:
            return int(value.p) / int(value.q)
        except OverflowError:
            raise UndecidedError("how numbers compare that are too large for floats") from None
    if value.is_algebraic:
        return float(value.evalf(20))
    return float(expression_ball(value))
