"""Dynamics in ``s``, and the real functions that they become on ``s = j omega``.

Dynamics are quotients of polynomials in ``s``, the parameters, delays ``exp(-s tau)`` and powers
``s^alpha``. On ``s = j omega`` even powers of ``s`` are real and odd ones imaginary, so that real
part, imaginary part and squared modulus are had by polynomial arithmetic alone: no complex numbers,
no ``as_real_imag``, no ``simplify``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from itertools import combinations
from math import inf, lcm
from operator import mul

from sympy import (
    Add,
    Expr,
    I,
    Integer,
    Mul,
    Rational,
    Symbol,
    cosh,
    coth,
    exp,
    gcd,
    perfect_power,
    sinh,
    tanh,
)

from haptisym.kernel.axis import Axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.harmonics import Harmonic
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import (
    Polynomial,
    PolynomialRing,
    RationalFunction,
    finite,
    monomials,
    omega,
    s,
    times,
)

# Commensurable delays are powers of a common unit delay, up to this one; beyond it they are treated
# as independent of each other. The degree in the unit is what polynomials grow with.
_MOST_MULTIPLE = 32


class Ring(PolynomialRing):
    """Dynamics: polynomials in ``s``, pi, the parameters, and the delays ``exp(-s tau)`` and powers
    ``s^alpha`` of a scene.

    >>> m, k = Symbol("m"), Symbol("k")
    >>> ring = Ring.of([m * s**2 + k, exp(-2 * s)])
    >>> ring.meanings, ring.convert(exp(-4 * s) * s).expression()
    ((s, pi, k, m, exp(-2*s)), s*exp(-4*s))
    """

    def __init__(
        self,
        symbols: Iterable[Symbol] = (),
        lags: Sequence[Expr] = (),
        orders: Sequence[Expr] = (),
        *,
        j: bool = False,
    ) -> None:
        self.lags, self.orders = tuple(lags), tuple(orders)
        functions = [
            *(exp(-s * lag) for lag in lags),
            *(s**order for order in orders),
            *([I] if j else []),
        ]
        super().__init__(s, symbols, functions)

    @classmethod
    def of(cls, expressions: Iterable[Expr]) -> Ring:
        """The smallest ring that holds the given expressions."""
        # Fractional powers of a parameter, or of a number, are powers of one root: all exponents
        # have a common denominator. That root then is the symbol, in place of the parameter.
        atoms = set(_named(expressions))
        roots = [x for x in atoms if _is_root(x)]
        denominators = [x.exp.q for x in roots]
        order = Rational(1, lcm(*denominators))
        radicands = {x.base for x in roots}
        numbers = {x for x in radicands if x.is_Integer}
        parameters = radicands - numbers
        bases = _independent(numbers) | parameters
        plain = {x for x in atoms if x.is_Symbol or isinstance(x, Harmonic)} - {s} - bases
        symbols = plain | {x**order for x in bases}
        lags: set[Expr] = set()
        for x in atoms:
            if x.func is exp:
                lags.update(_lags(x))
        orders = {_order(x)[1] for x in atoms if _is_fractional(x)}
        return cls(symbols, _units(lags), sorted(orders, key=str), j=I in atoms)

    def convert(self, expression: Expr) -> RationalFunction:
        if expression.func in _HYPERBOLIC:
            return self.convert(_exponentials(expression))
        if expression.func is exp:
            delays = (self._delayed(lag, n) for lag, n in _lags(expression).items())
            return reduce(lambda x, y: x * y, delays)
        if _is_fractional(expression):
            whole, order, sign = _order(expression)
            return (
                self.function(self.variable) ** whole
                * self.function(self.generators[s**order]) ** sign
            )
        return super().convert(expression)

    def _delayed(self, lag: Expr, sign: int) -> RationalFunction:
        """exp(-s lag) as a power of the unit delay that it is a multiple of."""
        # The longest first: a delay that has a variable of its own, before a power of another one.
        for unit in reversed(self.lags):
            multiple = lag / unit
            if multiple.is_Integer:
                return self.function(self.generators[exp(-s * unit)]) ** (sign * int(multiple))
        raise SceneError(f"the delay {lag} is not in this ring")

    def order_at_0(self, polynomial: Polynomial) -> float:
        """The order of the zero at s = 0, where every delay is 1; powers s^alpha are taken as if
        they were independent of s.

        >>> from sympy import exp
        >>> ring = Ring.of([exp(-s)])
        >>> [ring.order_at_0(ring.convert(x).numerator) for x in (s**3, 1 - exp(-s), s - 1 + exp(-s), s - s)]
        [3, 1, 2, inf]
        """
        # The order is the number of derivatives that vanish at s = 0; delays are 1 there, so that
        # each value is a polynomial, exactly zero or not.
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
            total -= (
                rate.numerator
                * (common / rate.denominator)
                * self.context.gens()[i]
                * polynomial.derivative(i)
            )
        return total

    @cached_property
    def axis(self) -> Axis:
        """The ring of real functions of omega that these dynamics become."""
        return Axis(self.symbols, self.lags, self.orders, j=I in self.generators)


def _named(expressions: Iterable[Expr]) -> Iterator[Expr]:
    """The parts of expressions that a ring needs variables for: symbols, j, exponentials,
    fractional powers of s, roots of parameters and numbers, and first harmonics."""
    waiting = [*expressions]
    while waiting:
        x = waiting.pop()
        if isinstance(x, Harmonic):
            yield x
            continue
        if x.is_Symbol or x is I:
            yield x
        elif x.func in _HYPERBOLIC:
            waiting.append(_exponentials(x))
            continue
        elif x.func is exp or _is_fractional(x) or _is_root(x):
            yield x
        waiting += x.args


def _is_fractional(x: Expr) -> bool:
    """Whether an expression is a power of s with an exponent that is no whole number."""
    return bool(x.is_Pow and x.base == s and not x.exp.is_Integer)


def _is_root(x: Expr) -> bool:
    """Whether an expression is a fractional power of a constant that is not negative."""
    is_power = x.is_Pow and x.exp.is_Rational and not x.exp.is_Integer
    return bool(is_power and x.base.is_nonnegative and not x.base.has(s))


def _independent(numbers: set[Integer]) -> set[Integer]:
    """Numbers without common factors and no powers, of which the given ones are products: then
    their roots are independent.

    >>> sorted(_independent({Integer(6), Integer(10), Integer(7)}))
    [2, 3, 5, 7]
    """
    factors = {Integer(power[0]) if (power := perfect_power(x)) else x for x in numbers} - {1}
    # A common factor of two numbers takes its part out of both, so that this ends.
    for x, y in combinations(factors, 2):
        if (common := gcd(x, y)) != 1:
            return _independent(factors - {x, y} | {common, x / common, y / common})
    return factors


_HYPERBOLIC = (cosh, sinh, tanh, coth)


def _exponentials(expression: Expr) -> Expr:
    """Hyperbolic functions as exponentials."""
    return expression.rewrite(_HYPERBOLIC, exp) if expression.has(*_HYPERBOLIC) else expression


def _lags(exponential: Expr) -> dict[Expr, int]:
    """The delays in exp(-s (tau_1 + tau_2 - ...)), each with its sign."""
    argument = exponential.args[0].expand()
    rate = argument.coeff(s)
    if rate.has(s) or (argument - rate * s).expand() != 0:
        raise SceneError(
            f"{exponential} is not a delay, whose exponent is -s times a time: give a constant a "
            f"symbol"
        )
    signs = {}
    for term in Add.make_args(-rate):
        number, rest = term.as_coeff_Mul()
        signs[abs(number) * rest] = 1 if number > 0 else -1
    return signs


def _units(lags: set[Expr]) -> list[Expr]:
    """Unit delays: for the rational multiples of one time their greatest common divisor, where that
    is not too fine; else these delays themselves."""
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
    # The whole part is rounded down, so that one variable s^(1/2) serves s^(1/2) and s^(-1/2).
    whole, order = power.exp.as_coeff_Add()
    if power.exp.is_Rational:
        whole = Integer(power.exp.p // power.exp.q)
        return int(whole), power.exp - whole, 1
    number, rest = order.as_coeff_Mul()
    if not whole.is_Integer or order.has(s):
        raise SceneError(f"{power}: a power of s must be a number or a symbol")
    return int(whole), abs(number) * rest, 1 if number > 0 else -1


@dataclass(frozen=True)
class Response:
    """A dynamics on ``s = j omega``: real and imaginary part as exact real functions of omega."""

    raw_real: RationalFunction
    raw_imag: RationalFunction

    @cached_property
    def real(self) -> RealFunction:
        """The real part, a real function of omega."""
        return RealFunction(_lowest(self.raw_real))

    @cached_property
    def imag(self) -> RealFunction:
        """The imaginary part, a real function of omega."""
        return RealFunction(_lowest(self.raw_imag))


def ring_of(dynamics: RationalFunction) -> Ring:
    """The ring of a dynamics."""
    assert isinstance(dynamics.ring, Ring)
    return dynamics.ring


def on_axis(dynamics: RationalFunction) -> Response:
    """The values of a dynamics on ``s = j omega``, as real functions of omega.

    >>> from sympy.abc import k, m
    >>> from haptisym.kernel.rings import s
    >>> response = on_axis(Ring.of([m * s**2 + k]).convert(m * s**2 + k))
    >>> response.real.expression(), response.imag.expression()
    (k - m*omega**2, 0)
    """
    # (a + j b)/(c + j d), extended by the conjugate of the denominator.
    axis = _axis(dynamics)
    (a, b), (c, d) = axis.parts([dynamics.numerator, dynamics.denominator])
    modulus = times(c, c) + times(d, d)
    real, imag = times(a, c) + times(b, d), times(b, c) - times(a, d)
    return Response(axis.function(real, modulus), axis.function(imag, modulus))


def squared_modulus(dynamics: RationalFunction) -> RealFunction:
    """|f(j omega)|^2, in lowest terms; its denominator is nowhere negative."""
    # Nor is it when factors cancel: one that changes its sign divides Re and Im both where it
    # divides the sum of their squares, so that an even power of it does, and cancels.
    axis = _axis(dynamics)
    (a, b), (c, d) = axis.parts([dynamics.numerator, dynamics.denominator])
    return RealFunction(
        axis.function(times(a, a) + times(b, b), times(c, c) + times(d, d)).reduced()
    )


def over_squares(dynamics: RationalFunction, *, real: bool, multiplied: bool = True) -> Expr:
    """Real or imaginary part on s = j omega, over the squared modulus of the denominator as sums of
    two squares; ``multiplied`` : whether the products above are multiplied out.

    >>> over_squares(Ring().convert(1 / (s**2 + s + 4)), real=False)
    -omega/(omega**2 + (4 - omega**2)**2)
    """
    axis, response = _axis(dynamics), on_axis(dynamics)
    # With delays, or with j among the numbers, parts are not those of polynomials: the general way.
    if axis.functions or axis.complex:
        return (response.real if real else response.imag).factored()
    whole = dynamics.reduced().cleared()
    # With n = a + j b and d = c + j d on the axis, n/d = (a c + b d + j (b c - a d))/(c^2 + d^2).
    (a, b), (c, d) = axis.parts([whole.numerator, whole.denominator])
    above, below = (a * c + b * d if real else b * c - a * d), c * c + d * d
    # If something cancels, c^2 + d^2 is not the denominator in lowest terms, and a sum of squares
    # would hide that.
    if not above.gcd(below).is_constant():
        return axis.function(above, below).factored()
    if multiplied:
        return axis.factored_expression(above) / squares(whole, whole.denominator)
    n, m, p, q = map(axis.factored_expression, (a, b, c, d))
    return (n * p + m * q if real else m * p - n * q) / squares(whole, whole.denominator)


def squares(function: RationalFunction, polynomial: Polynomial) -> Expr:
    """A polynomial's squared modulus on the axis of a function, as a product of sums of two
    squares."""
    axis = _axis(function)
    unit, factors = function.ring.factors(polynomial)
    # A single simple factor keeps its number inside, so that the polynomial is seen as it is.
    if len(factors) == 1 and factors[0][1] == 1:
        unit, factors = Rational(1), [(polynomial, 1)]
    moduli = []
    for factor, exponent in factors:
        # |p q|^2 = |p|^2 |q|^2: each factor gives a sum of two squares of its own.
        real, imag = map(axis.expression, axis.parts([factor])[0])
        moduli.append(finite(real**2 + imag**2) ** exponent)
    return Mul(unit**2, *moduli)


def _axis(dynamics: RationalFunction) -> Axis:
    """The ring of real functions that a dynamics becomes on the imaginary axis."""
    ring = dynamics.ring
    assert isinstance(ring, Ring)
    return ring.axis


def _lowest(function: RationalFunction) -> RationalFunction:
    """A function of an axis in lowest terms."""
    axis = function.ring
    assert isinstance(axis, Axis)
    # Circles 1 + tan^2 of several angles make a common divisor slow to find: they are tried first.
    return axis.reduced(function) if len(axis.angles) > 1 else function.reduced()


def _square_over(f: Polynomial, g: Polynomial) -> tuple[Polynomial, Polynomial, Polynomial]:
    """f^2/g in lowest terms: two factors of the numerator, and the denominator.

    Two greatest common divisors with f are enough, each much cheaper than one with f^2: a factor
    that g shares with f^2 divides f, and what is left of it in g can divide only the other f.
    """
    one, other = f, f
    common = f.gcd(g)
    if not common.is_constant():
        one, g = f / common, g / common
        common = f.gcd(g)
        if not common.is_constant():
            other, g = f / common, g / common
    return one, other, g


@dataclass(frozen=True)
class RealFunction:
    """A real function of omega, in lowest terms as a quotient of polynomials of an ``Axis``.

    ``above``, ``below`` : polynomials whose products numerator and denominator are known to be, up
    to a number; empty where none are known. To factor them one by one is quicker.
    """

    function: RationalFunction
    above: tuple[Polynomial, ...] = field(default=(), repr=False, compare=False)
    below: tuple[Polynomial, ...] = field(default=(), repr=False, compare=False)

    def __add__(self, other: RealFunction) -> RealFunction:
        return RealFunction(_lowest(self.function + other.function))

    def __mul__(self, other: RealFunction) -> RealFunction:
        return RealFunction(_lowest(self.function * other.function))

    def __truediv__(self, other: RealFunction) -> RealFunction:
        return RealFunction(_lowest(self.function / other.function))

    def __sub__(self, other: RealFunction) -> RealFunction:
        return RealFunction(_lowest(self.function - other.function))

    def square_over(self, other: RealFunction) -> RealFunction:
        """f^2/g, in lowest terms.

        >>> f, g = (RealFunction(Ring().axis.convert(x)) for x in (omega, omega**2 + omega**4))
        >>> f.square_over(g).expression()
        1/(omega**2 + 1)
        """
        f, g = self.function, other.function
        if g.is_zero:
            raise SceneError("division by zero")
        # As f and g are in lowest terms, numerators cancel only with numerators, and denominators
        # with denominators.
        *above, below = _square_over(f.numerator, g.numerator)
        *right, left = _square_over(f.denominator, g.denominator)
        parts = (*above, left), (*right, below)
        return RealFunction(f.ring.function(*(reduce(mul, x) for x in parts)).monic(), *parts)

    @property
    def is_zero(self) -> bool:
        """Whether it vanishes at every frequency."""
        return self.function.is_zero

    def derivative(self) -> RealFunction:
        """d/d omega, in lowest terms.

        >>> RealFunction(Ring().axis.convert(1 / (omega**2 + 1))).derivative().factored()
        -2*omega/(omega**2 + 1)**2
        """
        axis, f = self.axis, self.function
        if f.is_zero:
            return self
        top, bottom = (
            _Derived.of(axis, f.numerator, self.above),
            _Derived.of(axis, f.denominator, self.below),
        )
        # The quotient rule, but for all that is known to cancel (``_Derived``).
        core = top.change * axis.function(bottom.own) - bottom.change * axis.function(top.own)
        if core.is_zero:
            return RealFunction(axis.function(core.numerator))
        small, rest = bottom.doubtful
        core = _lowest(core / axis.function(small))
        common = top.shared.gcd(core.denominator)
        above, below = (top.shared / common, core.numerator), (*rest, core.denominator / common)
        return RealFunction(
            axis.function(reduce(mul, above), reduce(mul, below)).monic(), above, below
        )

    def ball(self, x: Ball) -> Ball:
        """A ball around the values at a ball of frequencies, at the current working precision; at
        omega = 0 exactly, around the limit. The function must hold no parameters.
        """
        ring = self.half_angled.ring
        values = {
            g: expression_ball(g, {omega: x})
            for g in ring.meanings
            if not g.is_Symbol or g == omega
        }
        # With fractional powers of omega numerator and denominator may both vanish at 0.
        beginning = self._beginning if self.axis.orders and x.is_zero() else None
        above, below = beginning or (self.half_angled.numerator, self.half_angled.denominator)
        return ring.ball(above, values) / ring.ball(below, values)

    @cached_property
    def _beginning(self) -> tuple[Polynomial, Polynomial] | None:
        """Numerator and denominator, both divided by the lowest power of omega in either of them,
        at omega = 0; None where an order alpha is a parameter."""
        ring = self.half_angled.ring
        weights = [
            x.as_base_exp()[1] if x.as_base_exp()[0] == omega else Integer(0) for x in ring.meanings
        ]
        if not all(x.is_Rational for x in weights):
            return None
        parts = [
            [(sum(map(mul, row, weights)), row, c) for row, c in monomials(p)]
            for p in (self.half_angled.numerator, self.half_angled.denominator)
        ]
        least = min(x[0] for part in parts for x in part)

        def leading(part: list[tuple[Expr, tuple[int, ...], object]]) -> Polynomial:
            # The terms of the lowest power, without their powers of omega.
            terms = {}
            for power, row, c in part:
                if power == least:
                    terms[tuple(0 if w else n for n, w in zip(row, weights, strict=True))] = c
            return ring.context.from_dict(terms)

        above, below = map(leading, parts)
        return above, below

    @cached_property
    def half_angled(self) -> RationalFunction:
        """In cos(a/2) and sin(a/2)/omega of its angles a, in lowest terms: nothing cancels that
        need not."""
        return self.axis.half_angles(self.function).reduced() if self.axis.angles else self.function

    @property
    def axis(self) -> Axis:
        """The axis on which its variables live."""
        ring = self.function.ring
        assert isinstance(ring, Axis)
        return ring

    @property
    def written(self) -> RationalFunction:
        """As a person would write it: polynomials in omega, cosines and sines."""
        return self.axis.trigonometric(self.function) if self.axis.angles else self.function

    def expression(self) -> Expr:
        """The closed form in omega, in lowest terms, the denominator in factors."""
        return self.written.expression()

    def factored(self) -> Expr:
        """The closed form in omega, numerator and denominator in factors."""
        return self.written.factored()


@dataclass(frozen=True)
class _Derived:
    """A polynomial p = shared own, and its derivative p' = shared change: own has each factor of p
    once, if p' lacks one of it.

    So (p/q)' = p.shared (p.change q.own - q.change p.own)/(q q.own), where hardly more than
    numbers, powers and 1 + tan^2 can cancel: of the quotient rule it would be most of p and q, and
    the search for it takes minutes where this takes a second.
    """

    axis: Axis
    shared: Polynomial
    own: Polynomial
    change: RationalFunction

    @classmethod
    def of(cls, axis: Axis, polynomial: Polynomial, parts: Sequence[Polynomial]) -> _Derived:
        """``parts`` : of which it is known to be the product, up to a number; a power of one is
        derived by that one."""
        one, *others = [x for x in parts if not x.is_constant()] or [polynomial]
        is_power = all(x == one for x in others)
        base, n = (one, 1 + len(others)) if is_power else (polynomial, 1)
        slope = axis.derivative(base).reduced()
        shared = base.gcd(slope.numerator)
        own = base / shared
        return cls(
            axis,
            polynomial / own,
            own,
            axis.function(n * slope.numerator / shared, slope.denominator),
        )

    @property
    def doubtful(self) -> tuple[Polynomial, list[Polynomial]]:
        """What (p q.own - q p.own)/(q q.own), a derivative over q, may still cancel with, and the
        factors of all else.

        A factor of q that is not one of q' becomes one power more of the denominator. That leaves
        factors of q' that q has as often, as powers and 1 + tan^2 are, and powers of omega, of
        which omega^alpha loses one.
        """
        special, common = self.shared, self.shared.gcd(self.own)
        while not common.is_constant():
            special = special / common
            common = special.gcd(self.own)
        small, rest = special, list[Polynomial]()
        for factor in (self.shared / special, self.own, self.own):
            power = self.axis.context.gens()[0] ** int(factor.deflation_index()[1][0])
            small, rest = small * power, [*rest, factor / power]
        return small, rest
