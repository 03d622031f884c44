"""Dynamics in ``s``: quotients of polynomials in ``s``, the parameters, delays and powers of ``s``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property, reduce
from math import inf

from sympy import Add, Expr, I, Integer, Rational, Symbol, cosh, exp, gcd, sinh

from haptisym.kernel.axis import Axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.kernel.symbols import s

_MOST_MULTIPLE = 32  # of a common unit delay; beyond it commensurable delays are treated as independent of each other


class Ring(PolynomialRing):
    """Dynamics: polynomials in ``s``, pi, the parameters, and the delays ``exp(-s tau)`` and powers ``s^alpha`` of a scene.

    >>> m, k = Symbol("m"), Symbol("k")
    >>> ring = Ring.of([m * s**2 + k, exp(-2 * s)])
    >>> ring.meanings, ring.convert(exp(-4 * s) * s).expression()
    ((s, pi, k, m, exp(-2*s)), s*exp(-4*s))
    """

    def __init__(
        self, symbols: Iterable[Symbol] = (), lags: Sequence[Expr] = (), orders: Sequence[Expr] = (), *, j: bool = False
    ) -> None:
        self.lags, self.orders = tuple(lags), tuple(orders)
        functions = [*(exp(-s * lag) for lag in lags), *(s**order for order in orders), *([I] if j else [])]
        super().__init__(s, symbols, functions)

    @classmethod
    def of(cls, expressions: Iterable[Expr]) -> Ring:
        """The smallest ring that holds the given expressions."""
        found = set(_named(expressions))
        symbols = {x for x in found if x.is_Symbol} - {s}
        lags = {lag for x in found if x.func is exp for lag in _lags(x)}
        orders = {_order(x)[1] for x in found if x.is_Pow}
        return cls(symbols, _units(lags), sorted(orders, key=str), j=I in found)

    def convert(self, expression: Expr) -> RationalFunction:
        if expression.func in (cosh, sinh):
            return self.convert(_exponentials(expression))
        if expression.func is exp:
            return reduce(lambda x, y: x * y, (self._delayed(lag, n) for lag, n in _lags(expression).items()))
        if _is_fractional(expression):
            whole, order, sign = _order(expression)
            return self.function(self.variable) ** whole * self.function(self.generators[s**order]) ** sign
        return super().convert(expression)

    def _delayed(self, lag: Expr, sign: int) -> RationalFunction:
        """exp(-s lag) as a power of the unit delay that it is a multiple of."""
        for unit in reversed(self.lags):  # the longest first: a delay of its own before a thousand of another one
            multiple = lag / unit
            if multiple.is_Integer:
                return self.function(self.generators[exp(-s * unit)]) ** (sign * int(multiple))
        raise SceneError(f"the delay {lag} is not in this ring")

    def order_at_0(self, polynomial: Polynomial) -> float:
        """The order of the zero at s = 0, where every delay is 1; powers s^alpha are taken as if they were independent of s.

        >>> from sympy import exp
        >>> ring = Ring.of([exp(-s)])
        >>> [ring.order_at_0(ring.convert(x).numerator) for x in (s**3, 1 - exp(-s), s - 1 + exp(-s), s - s)]
        [3, 1, 2, inf]
        """
        order = 0
        while self.at_0(polynomial).is_zero():
            if polynomial.is_zero():
                return inf
            polynomial, order = self.slope(polynomial), order + 1
        return order

    def at_0(self, polynomial: Polynomial) -> Polynomial:
        """The value at s = 0, in pi and the symbols."""
        delays = dict.fromkeys(range(self.size, self.size + len(self.lags)), 1)
        return polynomial.subs({0: 0, **delays})

    def slope(self, polynomial: Polynomial) -> Polynomial:
        """d/ds, with d/ds exp(-s tau) = -tau exp(-s tau), times the denominators of the delays."""
        rates = [self.convert(lag) for lag in self.lags]
        common = reduce(lambda x, y: x * y, (rate.denominator for rate in rates), self.constant(1))
        total = common * polynomial.derivative(0)
        for i, rate in enumerate(rates, self.size):
            total -= rate.numerator * (common / rate.denominator) * self.context.gens()[i] * polynomial.derivative(i)
        return total

    @cached_property
    def axis(self) -> Axis:
        """The ring of real functions of omega that these dynamics become."""
        return Axis(self.symbols, self.lags, self.orders, j=I in self.generators)


def _named(expressions: Iterable[Expr]) -> Iterator[Expr]:
    """What a ring needs names for: symbols, j, exponentials and the powers of s that are not whole."""
    waiting = [*expressions]
    while waiting:
        x = waiting.pop()
        if x.is_Symbol or x is I:
            yield x
        elif x.func in (cosh, sinh):
            waiting.append(_exponentials(x))
            continue
        elif x.func is exp or _is_fractional(x):
            yield x
        waiting += x.args


def _is_fractional(x: Expr) -> bool:
    """Whether it is a power of s that is not whole."""
    return bool(x.is_Pow and x.base == s and not x.exp.is_Integer)


def _exponentials(expression: Expr) -> Expr:
    """Hyperbolic functions as exponentials."""
    if not expression.has(cosh, sinh):
        return expression
    return expression.replace(cosh, lambda x: (exp(x) + exp(-x)) / 2).replace(sinh, lambda x: (exp(x) - exp(-x)) / 2)


def _lags(exponential: Expr) -> dict[Expr, int]:
    """The delays in exp(-s (tau_1 + tau_2 - ...)), each with its sign."""
    argument = exponential.args[0].expand()
    rate = argument.coeff(s)
    if rate.has(s) or (argument - rate * s).expand() != 0:
        raise SceneError(f"{exponential} is not a delay: the exponent must be -s times a time")
    found = {}
    for term in Add.make_args(-rate):
        number, rest = term.as_coeff_Mul()
        found[abs(number) * rest] = 1 if number > 0 else -1
    return found


def _units(lags: set[Expr]) -> list[Expr]:
    """Unit delays: of the rational multiples of one time, their greatest common divisor where that is not too fine."""
    classes: dict[Expr, list[Rational]] = {}
    for lag in lags:
        number, rest = lag.as_coeff_Mul()
        classes.setdefault(rest, []).append(number)
    units = []
    for rest, numbers in sorted(classes.items(), key=str):
        unit = reduce(gcd, numbers)
        alone = max(numbers) / unit > _MOST_MULTIPLE
        units += [number * rest for number in sorted(numbers)] if alone else [unit * rest]
    return units


def _order(power: Expr) -> tuple[int, Expr, int]:
    """s^p as s^whole (s^order)^sign, with 0 < order < 1 where it is a number."""
    whole, order = power.exp.as_coeff_Add()
    if power.exp.is_Rational:
        whole = Integer(power.exp.p // power.exp.q)
        return int(whole), power.exp - whole, 1
    number, rest = order.as_coeff_Mul()
    if not whole.is_Integer or order.has(s):
        raise SceneError(f"{power}: a power of s must be a number or a symbol")
    return int(whole), abs(number) * rest, 1 if number > 0 else -1
