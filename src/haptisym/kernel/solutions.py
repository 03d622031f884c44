"""Zeros of a real function of omega as formulas in its parameters, where there are readable ones,
and the derivatives of zeros with respect to a parameter.

Each irreducible factor is solved on its own. One that holds omega only by its square (or only by
omega^alpha, or only by the angle omega tau of one delay) and is of degree one or two in it is
inverted in square roots, powers, asin or acos. All others stay what they are: the polynomial is the
answer.

Every root is given, each with what must hold for it to be a frequency: that it is real, and that it
is not negative. Of the two roots x of a x^2 + b x + d the signs are those of Vieta: their product
is d/a and their sum -b/a. So where a d < 0 both are real, and one is positive; where a d > 0 both
have the sign of -b/a. What the assumptions on the symbols settle is not asked: a condition that
holds is left out, and so is a formula with a condition that cannot hold.

A zero omega of F(omega, p) = 0 moves with a parameter by d omega/dp = -(dF/dp)/(dF/d omega).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pkgutil import resolve_name
from typing import Any, NamedTuple, TypeAlias

from flint import fmpq
from sympy import (
    Add,
    Dummy,
    Expr,
    Integer,
    Mul,
    Poly,
    Rational,
    S,
    Symbol,
    acos,
    asin,
    atan,
    atan2,
    cos,
    factor,
    factor_terms,
    gcd,
    nan,
    pi,
    sqrt,
    zoo,
)

from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, quoted
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, coefficients, monomials, omega


@dataclass(frozen=True, repr=False)
class Solution(Shown):
    """A zero of a real function as a formula in its parameters.

    ``omega``: the frequency, rad/s, or what ``parameter`` is where one was solved for; None for a
    factor with no readable inverse, whose zeros are those of ``equation``.
    ``period``: adding any multiple of it gives the further zeros of a delay's angle; 0 for a single
    zero. ``order``: of the zero. ``conditions``: what must be positive; where all of them are
    ``omega`` is real and not negative. Of one function the formulas whose conditions hold are all
    its zeros, unless there is one without ``omega`` beside them or a delay is negative. Where a
    condition is 0 a formula may hold or not: ask again with the numbers. ``float(x)`` and
    ``sympify(x)`` are those of ``omega``, so that formulas and numbers are used alike.
    """

    omega: Expr | None
    equation: Expr
    period: Expr = S.Zero
    order: int = 1
    conditions: tuple[Expr, ...] = ()
    parameter: Symbol = omega
    known: Mapping[Symbol, Any] = field(default_factory=dict, compare=False)
    """The parameters of the system, which ``put`` takes whether they are in the formula or not, and
    the dimension of each."""

    def __float__(self) -> float:
        return float(self._sympy_())

    def _sympy_(self) -> Expr:
        if self.omega is None:
            raise SceneError(f"there is no formula: it is where {quoted(self.equation)} vanishes")
        return self.omega

    def _line(self) -> str:
        name = self.parameter.name
        return f"{name} = {self.omega}" if self.omega is not None else f"of {self.equation} = 0"

    def put(self, values: Mapping[Symbol | str, Any]) -> Solution | None:
        """The solution with values for some symbols, by symbol or name, as ``Distortion.at`` takes
        them; None where a condition fails for them.

        SceneError for a name that is none of the parameters, and where the formula is no number, as
        it may be where a condition is 0.
        """
        forms = [self.equation, self.period, *self.conditions, *filter(None, [self.omega])]
        free = {x for form in (*forms, *self.known) for x in form.free_symbols} - {self.parameter}
        measured = {x: self.known.get(x) for x in sorted(free, key=str)}
        # What users write is read where models are; the search for zeros needs none of it.
        found = self.replaced(resolve_name("haptisym.model.distortion:values_of")(values, measured))
        if found and found.omega is not None and found.omega.has(nan, zoo):
            raise SceneError(
                f"{self.parameter} = {self.omega} is no number for these values: put them into the "
                f"distortion, with at(), and ask again"
            )
        return found

    def replaced(self, values: Mapping[Symbol, Expr]) -> Solution | None:
        """``put`` of expressions for symbols, whatever comes of it."""
        left = left_to_ask(x.xreplace(values) for x in self.conditions)
        if left is None:
            return None
        omega = None if self.omega is None else self.omega.xreplace(values)
        equation, period = self.equation.xreplace(values), self.period.xreplace(values)
        return replace(self, omega=omega, equation=equation, period=period, conditions=left)


def solve(function: RealFunction, *, readable: bool = False) -> tuple[Solution, ...]:
    """All positive zeros of a real function, as formulas where there are readable ones;
    ``readable`` : these alone, sooner.

    >>> from sympy import symbols
    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.rings import omega
    >>> m, k = symbols("m k", positive=True)
    >>> f = RealFunction(Ring([m, k]).axis.convert(k - m * omega**2))
    >>> [solution.omega for solution in solve(f)]
    [sqrt(k)/sqrt(m)]
    """
    axis = function.axis
    factors = axis.factors(function.function.numerator)[1]
    solved = (x for f, order in factors for x in _solved(f, order, axis, readable=readable))
    return (*solved, *_half_turns(function))


def solved_for(function: RealFunction, parameter: Symbol) -> tuple[Solution, ...]:
    """All positive values of a parameter at which a real function vanishes, as formulas in omega
    and the other parameters where there are readable ones.

    >>> from sympy import symbols
    >>> from haptisym.kernel.dynamics import Ring
    >>> m, k = symbols("m k", positive=True)
    >>> f = RealFunction(Ring([m, k]).axis.convert(k - m * omega**2))
    >>> solved_for(f, m)
    (<Solution m = k/omega**2>,)
    """
    place = Symbol("omega of the equation", positive=True)
    # A parameter of which there are roots is solved for by its root.
    form = function.axis.roots.get(parameter, parameter)
    turned = exchanged(function, form, place)
    if turned is None:
        return (Solution(None, function.factored(), parameter=parameter),)
    back = {omega: form, place: omega}
    # The parameter is this power of its root.
    power = parameter.as_base_exp()[1] / form.as_base_exp()[1]
    solutions = []
    for x in solve(turned):
        value = None if x.omega is None else x.omega.xreplace(back) ** power
        equation, period = x.equation.xreplace(back), x.period.xreplace(back)
        conditions = tuple(y.xreplace(back) for y in x.conditions)
        solutions.append(Solution(value, equation, period, x.order, conditions, parameter))
    return tuple(solutions)


def exchanged(function: RealFunction, free: Expr, place: Symbol) -> RealFunction | None:
    """The function of the parameter ``free``, which takes the place of omega, which is called
    ``place``; None where it is no such function."""
    axis = function.axis
    inside = free.free_symbols
    # A phase is omega times its rate. As omega and the parameter change place it must still be
    # one, so that its rate is proportional to the parameter, or be constant.
    turning = [x for x in axis.angles if x.rate.has(*inside)]
    resting = [x for x in axis.angles if x not in turning]
    rates = [(x.rate / free).cancel() * place for x in turning]
    others = [x for x in axis.symbols if x != free]
    if any(x.has(*inside) for x in (*rates, *others, *axis.orders)):
        return None
    values = [x.value.xreplace({omega: place}) for x in resting]
    powers = [place**order for order in axis.orders]
    target = Axis([*others, place], rates, (), turned=values, fixed=powers)
    names = {omega: place, free: omega}
    where = [target.meanings.index(names.get(x, x)) for x in axis.meanings[: axis.size]]
    where += [target.size + [*turning, *resting].index(x) for x in axis.angles]
    where += range(target.size + len(target.angles), len(target.meanings))

    def moved(polynomial: Polynomial) -> Polynomial:
        terms = {}
        for exponents, value in monomials(polynomial):
            own = [0] * len(target.meanings)
            for i, n in zip(where, exponents, strict=True):
                own[i] = int(n)
            terms[tuple(own)] = value
        return target.context.from_dict(terms)

    # What is below has no zeros, but where its degree in a tangent is higher there is half a turn.
    quotient = function.function
    return RealFunction(target.function(moved(quotient.numerator), moved(quotient.denominator)))


def _half_turns(function: RealFunction) -> list[Solution]:
    """The zeros at omega tau = pi, 3 pi, ... of a function whose degree in a half-angle tangent is
    higher in the denominator than in the numerator: there the tangent is infinite."""
    axis, solutions = function.axis, list[Solution]()
    quotient = function.function
    above = quotient.numerator.degrees()[axis.size :]
    below = quotient.denominator.degrees()[axis.size :]
    for angle, up, down in zip(axis.angles, above, below, strict=False):
        if not angle.constant and down > up:
            equation, period = cos(angle.value / 2), 2 * pi / angle.rate
            zero = _Zero(pi / angle.rate, (angle.rate,), period)
            solutions += _told([zero], equation, int(down - up))
    return solutions


def _solved(polynomial: Polynomial, order: int, axis: Axis, *, readable: bool) -> list[Solution]:
    """The solutions of one irreducible factor: formulas, or one without a formula; none where the
    factor is omega itself or does not depend on it."""
    degrees = [int(n) for n in polynomial.degrees()]
    # Omega is in it as itself, in the tangent of half of an angle, or in a power.
    has_omega = bool(degrees[0])
    first_power = axis.size + len(axis.angles)
    has_powers = any(degrees[first_power : first_power + len(axis.orders)])
    turning = []
    for i, angle in enumerate(axis.angles):
        if not angle.constant and degrees[axis.size + i]:
            turning.append(i)
    if polynomial == axis.variable or not (has_omega or turning or has_powers):
        return []
    # Omega in two ways at once, as omega + tan(omega), has no inverse in known functions. With
    # roots of numbers a factor over Q may not be irreducible.
    ways = len(turning) + bool(has_omega or has_powers)
    if ways > 1 or axis.root_in(polynomial):
        zeros = None
    else:
        zeros = _angles(polynomial, axis, turning[0]) if turning else _frequencies(polynomial, axis)
    if zeros is None:
        row = axis.univariate(polynomial)
        if readable or (row is not None and not _has_positive_root(row)):
            return []
        return [Solution(None, _equation(polynomial, axis), order=order)]
    return _told(zeros, _equation(polynomial, axis), order)


def _has_positive_root(row: Sequence[fmpq]) -> bool:
    """Whether a polynomial with these coefficients, ascending, has one: by Sturm's theorem."""
    falling = [Rational(int(x.p), int(x.q)) for x in reversed(row)]
    return bool(Poly(falling, omega).count_roots(0, None) - (falling[-1] == 0))


class _Zero(NamedTuple):
    """A zero and its conditions ``needs``: expressions that must not be negative for it to be real
    and not negative itself."""

    omega: Expr
    needs: tuple[Expr, ...]
    period: Expr = S.Zero


def _told(zeros: Iterable[_Zero], equation: Expr, order: int) -> list[Solution]:
    """The solutions among some zeros, with the conditions that are left to ask."""
    solutions = []
    for x in zeros:
        left = left_to_ask(x.needs)
        if left is not None:
            solutions.append(Solution(x.omega, equation, x.period, order, left))
    return solutions


def left_to_ask(conditions: Iterable[Expr]) -> tuple[Expr, ...] | None:
    """The conditions (expressions that must not be negative) that the assumptions on symbols do not
    settle, in their order; None where one of them fails for sure.

    >>> from sympy.abc import x, y
    >>> left_to_ask([Integer(2), 1 + x, y]), left_to_ask([1 + x, Integer(-2)])
    ((x + 1, y), None)
    """
    asked = dict.fromkeys(conditions)
    if any(as_real(x).is_negative for x in asked):
        return None
    return tuple(x for x in asked if not as_real(x).is_nonnegative)


def as_real(x: Expr) -> Expr:
    """The expression with real symbols in place of those without assumptions: all parameters are
    real, and so of one that is declared nothing else a square is known not to be negative.

    >>> from sympy.abc import T
    >>> (-(T**2)).is_nonpositive, as_real(-(T**2)).is_nonpositive
    (None, True)
    """
    return x.xreplace({y: _real(y) for y in x.free_symbols if y.is_real is None})


@lru_cache(maxsize=256)
def _real(x: Symbol) -> Symbol:
    """A real symbol in place of one that is declared nothing."""
    return Dummy(x.name, real=True)


_Found: TypeAlias = list[_Zero] | None
"""Zeros; None where the degree is too high to invert."""


def _each(roots: list[_Root] | None, change: Callable[[Expr], Expr]) -> _Found:
    """The zeros at the roots that are not negative, each root mapped to its frequency by
    ``change``."""
    # A root that is positive for no real values, as -T^2 (c + 1) for no T, is no frequency.
    kept = [x for x in roots or () if not as_real(x.sign).is_nonpositive]
    return None if roots is None else [_Zero(change(x.value), x.needs()) for x in kept]


def _frequencies(polynomial: Polynomial, axis: Axis) -> _Found:
    """Zeros of a sum of powers of omega, whole or fractional, of which two or three are x^0, x^1
    and x^2 with x = omega^p: all others have no readable formula."""
    # Constant angles, of powers of s, as cosines and sines, whose signs are known.
    written = RealFunction(axis.function(polynomial)).written
    ring = written.ring
    powers = [omega, *(omega**order for order in axis.orders)]
    places = [(ring.meanings.index(x), x.as_base_exp()[1]) for x in powers]
    rows: dict[Expr, dict[tuple[int, ...], object]] = {}
    for exponents, value in monomials(written.numerator):
        rest = list(map(int, exponents))
        power = Add(*(rest[i] * n for i, n in places))
        for i, _ in places:
            rest[i] = 0
        rows.setdefault(power, {})[tuple(rest)] = value
    # A symbolic order is between 0 and 1; which of two powers is higher may depend on it.
    middle = {x: Rational(3, 7) for power in rows for x in power.free_symbols}
    low, *others = sorted(rows, key=lambda power: power.xreplace(middle))
    steps = [power - low for power in others]
    if len(steps) not in (1, 2) or (len(steps) == 2 and steps[1] != 2 * steps[0]):
        return None
    row = [ring.expression(ring.context.from_dict(rows[x])) for x in (low, *others)]
    zeros = _each(_roots(row), lambda x: _inverted(x ** (1 / steps[0])))
    if zeros is None or len(row) < 3 or steps[0] != 2:
        return zeros
    # A polynomial p(omega) p(-omega) has shorter formulas, if no others come with them.
    halves = [f for f, _ in axis.factors(polynomial, in_square=False)[1]]
    others = [z for f in halves if len(halves) > 1 for z in _frequencies(f, axis) or ()]
    told, shorter = (_told(x, Integer(0), 1) for x in (zeros, others))
    return others if 0 < len(shorter) <= len(told) else zeros


def _inverted(x: Expr) -> Expr:
    """1/sqrt(y) in place of sqrt(1/y): the same where it is real."""
    return x.replace(
        lambda y: y.is_Pow and y.base.is_Pow and y.base.exp.is_negative,
        lambda y: y.base.base ** (y.base.exp * y.exp),
    )


def _angles(polynomial: Polynomial, axis: Axis, index: int) -> _Found:
    """Zeros of a polynomial in t = tan(omega tau/2) alone: cos = (1 - t^2)/(1 + t^2), sin = 2 t/(1
    + t^2)."""
    rate, turn = axis.angles[index].rate, 2 * pi
    row = _row(polynomial, axis, index)
    # Even in t, it holds t^2 = (1 - cos)/(1 + cos) alone; c (1 + t^2) + b t is c + (b/2) sin over
    # cos^2(omega tau/2), and c (1 - t^2) + b t is c cos + (b/2) sin over it. These three give
    # shorter formulas than the arctangent.
    if not any(row[1::2]):
        angles = _by_cosine(_roots(row[::2]))
    elif len(row) == 3 and row[0] == row[2]:
        angles = _by_sine(_quotient(-2 * row[0], row[1]))
    elif len(row) == 3 and (row[0] + row[2]).expand() == 0:
        angles, turn = _across(2 * row[0], row[1]), pi
    else:
        angles = _by_tangent(_roots(row))
    return angles and [_Zero(x.omega / rate, (*x.needs, rate), turn / rate) for x in angles]


def _by_cosine(squares: list[_Root] | None) -> _Found:
    """Angles from 0 to 2 pi, from the squares t^2 of their half's tangent, both solutions of cos =
    (1 - t^2)/(1 + t^2): t^2 >= 0 is -1 < cos <= 1."""
    if squares is None:
        return None
    pairs = [(acos(((1 - x.value) / (1 + x.value)).cancel()), x.needs()) for x in squares]
    return [_Zero(x, needs) for angle, needs in pairs for x in (angle, 2 * pi - angle)]


def _by_sine(sine: Expr) -> list[_Zero]:
    """Angles from 0 to 2 pi with a given sine: asin in its first or last quarter turn, as its sign
    needs, and pi - asin."""
    needs, sign = (1 - sine, 1 + sine), _of_sign(sine)
    angle = asin(sine)
    return [
        _Zero(angle, (*needs, sign)),
        _Zero(angle + 2 * pi, (*needs, -sign)),
        _Zero(pi - angle, needs),
    ]


def _across(x: Expr, y: Expr) -> list[_Zero]:
    """Angles from 0 to pi at which x cos + y sin = 0: a quarter turn from that of x + j y, which
    is no quotient, so that x may be 0."""
    x, y = (_in_factors(z / gcd(x, y)) for z in (x, y))
    zeros = []
    for side in (1, -1):
        # Of the two directions that with the upper half of the plane, in its right or left half.
        angle, upper, right = atan2(side * y, side * x), _of_sign(side * y), _of_sign(side * x)
        zeros += [_Zero(pi / 2 + angle, (upper, right)), _Zero(angle - pi / 2, (upper, -right))]
    return zeros


def _by_tangent(tangents: list[_Root] | None) -> _Found:
    """Angles from 0 to 2 pi, from their half's tangent, which is negative in the second half of the
    turn."""
    if tangents is None:
        return None
    # A tangent 0 is the angle 2 pi only, since omega = 0 is no positive zero.
    zeros = [_Zero(2 * atan(x.value), x.needs()) for x in tangents if x.value != 0]
    return zeros + [_Zero(2 * atan(x.value) + 2 * pi, x.needs(-1)) for x in tangents]


def _row(polynomial: Polynomial, axis: Axis, index: int) -> list[Expr]:
    """Coefficients in the tangent of one half angle, ascending, all times the same in cosines and
    sines of the angles that are constant."""
    below = _circles(polynomial, axis, [i for i, x in enumerate(axis.angles) if x.constant])
    rows = coefficients(polynomial, axis.size + index)
    return [RealFunction(axis.function(row, below)).expression() for row in rows]


def _circles(polynomial: Polynomial, axis: Axis, angles: Iterable[int]) -> Polynomial:
    """What makes a polynomial in tangents of half angles one in cosines and sines if it is divided
    by it."""
    # A polynomial of even degree n in tan(a/2), over (1 + tan^2)^(n/2), is one in cos a and sin a;
    # an odd degree counts as the next even one.
    below = axis.constant(1)
    for i in angles:
        degree = int(polynomial.degrees()[axis.size + i])
        below *= (axis.context.gens()[axis.size + i] ** 2 + 1) ** ((degree + 1) // 2)
    return below


class _Root(NamedTuple):
    """A root ``value``; an expression ``sign`` that has its sign where it is real; and expressions
    ``real`` that must not be negative for it to be real."""

    value: Expr
    sign: Expr
    real: tuple[Expr, ...] = ()

    def needs(self, sign: int = 1) -> tuple[Expr, ...]:
        """Expressions that must not be negative for the root to be real, and of this sign or 0."""
        return *self.real, sign * self.sign


def _roots(row: list[Expr]) -> list[_Root] | None:
    """The roots of a polynomial of degree 1 or 2, real or not; None for other degrees. Of two real
    roots the one with the minus sign comes first: the lower one where the highest coefficient is >
    0."""
    if len(row) == 2:
        return [_Root(_quotient(-row[0], row[1]), _of_sign(-row[0] * row[1]))]
    if len(row) != 3:
        return None
    d, b, a = row
    if a.could_extract_minus_sign():
        a, b, d = -a, -b, -d
    # Factored only where that gives a product, which SymPy can take apart under the root.
    whole = b**2 - 4 * a * d
    discriminant = split if (split := factor(whole)).is_Mul else whole
    product, real = _of_sign(a * d), (_of_sign(discriminant),)
    roots = []
    for side in (-1, 1):
        root = _quotient(-b + side * sqrt(discriminant), 2 * a)
        # Vieta: roots of different signs are real, and that of +sqrt/(2 a) is the one with the sign
        # of a. Roots of one sign have that of -b/a. Otherwise the numerator's sign stays to be
        # asked.
        if product.is_negative:
            roots.append(_Root(root, _of_sign(side * a)))
        elif product.is_positive:
            roots.append(_Root(root, _of_sign(-a * b), real))
        else:
            numerator = factor_terms(-b + side * sqrt(discriminant))
            roots.append(_Root(root, _of_sign(a) * _unsized(numerator), real))
    return roots


def _of_sign(x: Expr) -> Expr:
    """An expression of the same sign, as short as possible."""
    return _unsized(_in_factors(x))


def _unsized(x: Expr) -> Expr:
    """An expression with the sign of a product: factors that are not negative are left out,
    divisors become factors."""
    result = Integer(1)
    for part in Mul.make_args(x):
        base, power = part.as_base_exp()
        if as_real(part).is_nonnegative and not part.is_zero:
            continue
        if as_real(part).is_negative:
            result = -result
        elif power.is_odd:
            result = result * base
        else:
            result = result * part
    return result


def _quotient(above: Expr, below: Expr) -> Expr:
    """A quotient in factors, common ones cancelled, with at most one minus sign: in front."""
    above, below = map(_in_factors, (above, below))
    if above.could_extract_minus_sign():
        return -above / _in_factors(-below)
    return factor_terms(above / below)


def _in_factors(x: Expr) -> Expr:
    """A product where it is one, without a minus in front: 1 - c, and not -(c - 1)."""
    split = factor(x)
    sums = [y for y in Mul.make_args(split) if y.is_Add]
    if not split.is_Mul or not split.could_extract_minus_sign() or not sums:
        return split if split.is_Mul else x
    return (-split / sums[0]) * -sums[0]


def _equation(polynomial: Polynomial, axis: Axis) -> Expr:
    """The factor as a person would write it: divided by what makes tangents of half angles cosines
    and sines."""
    below = _circles(polynomial, axis, range(len(axis.angles)))
    return RealFunction(axis.function(polynomial, below)).factored()


FunctionTerms: TypeAlias = tuple[tuple[Expr, Polynomial], ...]
"""A sum of polynomials of a ring, each times an expression; the form of a derivative of a
polynomial in functions."""


@dataclass(frozen=True)
class Equation:
    """F = 0 for a frequency; F is a polynomial in omega, the parameters and functions of them
    (cos(omega tau), omega^alpha).

    >>> from haptisym.kernel.rings import symbols
    >>> m, k = symbols("m k")
    >>> ring = PolynomialRing(omega, [m, k])
    >>> Equation(ring, ring.convert(k - m * omega**2).numerator).slope(k).expression()
    1/(2*m*omega)
    """

    ring: PolynomialRing
    F: Polynomial

    def ball(self, known: Mapping[Expr, Ball]) -> Ball:
        """A ball around F where the symbols have these values, at the current working precision."""
        return self.ring.ball(self.F, _meanings(self.ring, known))

    def partial(self, x: Symbol) -> FunctionTerms:
        """dF/dx by the chain rule over all variables of the ring that depend on x; () where it is
        0."""
        chain = [
            (meaning.diff(x), self.F.derivative(i)) for i, meaning in enumerate(self.ring.meanings)
        ]
        return tuple((factor, p) for factor, p in chain if factor != 0 and not p.is_zero())

    def slope(self, parameter: Symbol) -> ImplicitSlope:
        """d omega/d parameter."""
        return ImplicitSlope(self.ring, self.partial(parameter), self.partial(omega))


@dataclass(frozen=True)
class ImplicitSlope:
    """``-above/below``, which is d omega/d parameter at every zero at which ``below``, dF/d omega,
    is not 0."""

    ring: PolynomialRing
    above: FunctionTerms
    below: FunctionTerms

    def expression(self) -> Expr:
        """The closed form."""
        above, below = (
            Add(*(f * self.ring.expression(p) for f, p in terms))
            for terms in (self.above, self.below)
        )
        return -above / below

    def vanishes(self, known: Mapping[Symbol, Expr]) -> bool:
        """Whether ``above`` is 0 at every frequency for these values of parameters. (False: not
        seen to be.)"""
        return all(f.xreplace(known) == 0 or self._at(p, known).is_zero() for f, p in self.above)

    def _at(self, polynomial: Polynomial, known: Mapping[Symbol, Expr]) -> Polynomial:
        """A polynomial with the rational ones among these values put in."""
        places = {
            self.ring.meanings.index(x): v for x, v in known.items() if isinstance(v, Rational)
        }
        return polynomial.subs({i: fmpq(int(v.p), int(v.q)) for i, v in places.items()})

    def balls(self, known: Mapping[Expr, Ball]) -> tuple[Ball, Ball]:
        """Balls around ``above`` and ``below`` where the symbols have these values, at the current
        working precision."""
        values = _meanings(self.ring, known)
        return self._ball(self.above, values, known), self._ball(self.below, values, known)

    def _ball(
        self, terms: FunctionTerms, values: Mapping[Expr, Ball], known: Mapping[Expr, Ball]
    ) -> Ball:
        parts = (expression_ball(f, known) * self.ring.ball(p, values) for f, p in terms)
        return sum(parts, expression_ball(Integer(0)))


def _meanings(ring: PolynomialRing, known: Mapping[Expr, Ball]) -> dict[Expr, Ball]:
    """Balls for the variables of a ring, as far as all symbols in them are known."""
    return {
        x: expression_ball(x, known)
        for x in ring.meanings
        if all(y in known for y in x.free_symbols)
    }
