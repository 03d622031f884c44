"""The symbols that every formula shares, and exact arithmetic of quotients of polynomials, on which
all closed forms rest.

A ring holds polynomials over the rational numbers in a frequency variable, ``pi``, the parameters
and whatever else a formula is made of (``exp(-s tau)``, ``s^alpha``, ``cos(omega tau)``): each is
one more variable. ``pi`` is transcendental and exponentials of different delays are algebraically
independent, so that tests for zero stay exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from math import gcd, lcm, prod
from operator import add, mul
from typing import Any, TypeAlias

from flint import Ordering, arb, fmpq, fmpq_mpoly_ctx, fmpq_poly
from sympy import Add, Expr, Integer, Mul, Rational, Symbol, count_ops, pi

from haptisym.kernel.budget import MOST_TERMS, afford, room
from haptisym.kernel.errors import SceneError, need

s = Symbol("s")
"""Laplace variable, rad/s; plain, so that an ordinary ``Symbol("s")`` of the user is the same
one."""

omega = Symbol("omega", positive=True)
"""Angular frequency, rad/s."""

c = Symbol("c", positive=True)
"""JND threshold, a fraction of ``|H_env|`` (eq. 4)."""

X = Symbol("X")
"""Complex amplitude of the hand's motion, m or rad (eqs. 5 and 6)."""


def symbols(names: str) -> tuple[Symbol, ...] | Symbol:
    """Positive SymPy symbols, for parameters; one symbol if ``names`` holds one name.

    >>> m, b, k = symbols("m b k")
    >>> m.is_positive
    True
    >>> symbols("omega_n")
    omega_n
    """
    need("symbols", names, str, 'give names in one string, as "m b k"')
    made = tuple(Symbol(name, positive=True) for name in names.replace(",", " ").split())
    return made[0] if len(made) == 1 else made


def finite(total: Expr) -> Expr:
    """The same sum: once seen to be finite, SymPy does not count the real roots of its terms to
    raise it to a power."""
    all(x.is_finite for x in total.args)
    return total


def conflicting(expressions: list[Expr]) -> Symbol | None:
    """A symbol that shares its name, but not its assumptions, with another one; None if there is
    none.

    >>> conflicting([Symbol("m") + Symbol("m", positive=True)]) is None
    False
    """
    seen: dict[str, Symbol] = {}
    for symbol in {x for e in expressions for x in e.free_symbols}:
        if seen.setdefault(symbol.name, symbol) != symbol:
            return symbol
    return None


def monomials(polynomial: Any) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """The exponents of each term, and its coefficient: what ``to_dict().items()`` gives, in less
    than a third of its time.

    >>> from haptisym.kernel.rings import PolynomialRing
    >>> from haptisym.kernel.rings import s
    >>> [(int(power), value) for (power, _), value in monomials(PolynomialRing(s).variable ** 2 - 3)]
    [(2, 1), (0, -3)]
    """
    return zip(polynomial.monoms(), polynomial.coeffs(), strict=True)


Polynomial: TypeAlias = Any  # flint.fmpq_mpoly, which ships no types


def coefficients(polynomial: Polynomial, index: int) -> list[Polynomial]:
    """The coefficients of a polynomial by ascending powers of the variable of that number: they are
    polynomials of the same ring, without the variable.

    >>> ring = PolynomialRing(s)
    >>> s_, pi_ = ring.context.gens()
    >>> coefficients(pi_ * s_**2 + 3 * s_ - 1, 0), coefficients(pi_ * s_**2 + 3 * s_ - 1, 1)
    ([-1, 3, x1], [3*x0 - 1, x0^2])
    """
    degree = degree_in([polynomial], index)
    rows: list[dict[tuple[int, ...], object]] = [{} for _ in range(degree + 1)]
    for exponents, c in monomials(polynomial):
        others = [int(n) for n in exponents]
        power, others[index] = others[index], 0
        rows[power][tuple(others)] = c
    context = polynomial.context()
    return [context.from_dict(row) for row in rows]


class PolynomialRing:
    """Polynomials over Q in the variable, pi, symbols and further functions; ``meanings`` has what
    each stands for."""

    def __init__(
        self, variable: Symbol, symbols: Iterable[Symbol] = (), functions: Iterable[Expr] = ()
    ) -> None:
        # A root stands before all that is under it, by which its powers are reduced.
        in_order = sorted(
            set(symbols) - {variable},
            key=lambda x: (-count_ops(x.base) if x.is_Pow and x.base.args else 0, str(x)),
        )
        clash = conflicting([*in_order])
        if clash is not None:
            raise SceneError(
                f"two different symbols are both named {clash}: their assumptions differ, as of "
                f'Symbol("{clash}") and Symbol("{clash}", positive=True): declare both equally, or '
                f"give one of them another name"
            )
        self.symbols = tuple(in_order)  # a parameter, or a root of one or of a number
        self.functions = tuple(functions)
        self.meanings: tuple[Expr, ...] = (variable, pi, *self.symbols, *self.functions)
        self.context = fmpq_mpoly_ctx.get(
            tuple(f"x{i}" for i in range(len(self.meanings))), Ordering.lex
        )
        self.generators = dict(zip(self.meanings, self.context.gens(), strict=True))
        self._one = self.context.constant(1)
        # A root of a number or of a sum, x = p^(1/q), is a variable with the relation x^q = p; a
        # root of a parameter takes the parameter's place, and needs none.
        self.roots = {x.base: x for x in in_order if x.is_Pow}
        self._relations: list[Polynomial] = []
        for p, x in reversed(self.roots.items()):
            if not p.is_Symbol:
                under = self.convert(p)
                power = self.generators[x] ** x.exp.q
                self._relations.insert(0, power * under.denominator - under.numerator)

    @property
    def size(self) -> int:
        """The number of variables before the further functions."""
        return 2 + len(self.symbols)

    @property
    def variable(self) -> Polynomial:
        """The first variable, as a polynomial."""
        return self.generators[self.meanings[0]]

    def constant(self, value: int | Rational) -> Polynomial:
        """A rational number as a polynomial."""
        return self.context.constant(
            value if isinstance(value, int) else fmpq(int(value.p), int(value.q))
        )

    def function(
        self, numerator: Polynomial, denominator: Polynomial | None = None
    ) -> RationalFunction:
        """The quotient of two polynomials of this ring."""
        below = self._one if denominator is None else self.short(denominator)
        return RationalFunction(self, self.short(numerator), below)

    def short(self, polynomial: Polynomial) -> Polynomial:
        """A polynomial reduced by the relations of roots. It represents 0 where the result is the
        zero polynomial; and only there, if all are roots of numbers, which are independent."""
        for relation in self._relations:
            polynomial = divmod(polynomial, relation)[1]
        return polynomial

    def root_in(self, *polynomials: Polynomial) -> Expr | None:
        """A root of a number or of a sum that occurs in some polynomials, None if none does. With
        one, factors that are irreducible over Q may have multiple zeros, as x^2 - 2 sqrt(2) x + 2.
        """
        roots = (x for p, x in self.roots.items() if not p.is_Symbol)
        return next((x for x in roots if degree_in(polynomials, self.meanings.index(x))), None)

    @property
    def zero(self) -> RationalFunction:
        """0."""
        return self.function(self.constant(0))

    @property
    def one(self) -> RationalFunction:
        """1."""
        return self.function(self._one)

    def convert(self, expression: Expr) -> RationalFunction:
        """The element that a SymPy expression is; SceneError where it is none.

        >>> from haptisym.kernel.rings import s
        >>> PolynomialRing(s).convert(1 / s + s / (s + 1)).expression()
        (s**2 + s + 1)/(s*(s + 1))
        """
        if expression.is_Rational:
            return self.function(self.constant(expression))
        if expression in self.generators:
            return self.function(self.generators[expression])
        if expression.is_Add:
            return reduce(add, map(self.convert, expression.args))
        if expression.is_Mul:
            return reduce(mul, map(self.convert, expression.args))
        base, power = expression.as_base_exp()
        if base in self.roots and (power * self.roots[base].exp.q).is_Integer:
            return self.function(self.generators[self.roots[base]]) ** int(
                power * self.roots[base].exp.q
            )
        # A root of a number that is a product of those whose roots are variables.
        if base.is_Integer and power.is_Rational and not power.is_Integer and base > 1:
            product, left = self.one, base
            for p in (p for p in self.roots if p.is_Integer):
                while left % p == 0:
                    product, left = product * self.convert(p**power), left / p
            if left == 1:
                return product
        if expression.is_Pow and power.is_Integer:
            return self.convert(base) ** int(power)
        raise SceneError(
            f"{expression} is not made of {self.meanings[0]} and exact numbers by + - * / "
            f"and whole powers"
            + (
                ": give it a symbol of its own, and put it into the closed forms afterwards"
                if not expression.has(self.meanings[0])
                else ""
            )
        )

    def expression(self, polynomial: Polynomial) -> Expr:
        """A polynomial as a SymPy sum over the powers of the variable, each with its coefficient
        collected."""
        return Add(
            *(
                coefficient * self.meanings[0] ** n
                for n, coefficient in self._powers(polynomial).items()
            )
        )

    def coefficients(self, polynomial: Polynomial) -> list[Expr]:
        """The coefficients of a polynomial, ascending in powers of the variable."""
        powers = self._powers(polynomial)
        return [powers.get(n, Integer(0)) for n in range(max(powers, default=0) + 1)]

    def ball(self, polynomial: Polynomial, values: Mapping[Expr, Any]) -> Any:
        """A ball around a polynomial's value where its variables have these balls as values, at the
        current working precision."""
        # Each power of a variable is computed once: the same ones occur in many terms.
        known: list[Any] = [values.get(x) for x in self.meanings]
        powers: dict[tuple[int, int], Any] = {}
        total = arb(0)
        for exponents, coefficient in monomials(polynomial):
            term = arb(coefficient)
            for place in enumerate(exponents):
                if place[1]:
                    if place not in powers:
                        powers[place] = known[place[0]] ** int(place[1])
                    term = term * powers[place]
            total = total + term
        return total

    def univariate(self, polynomial: Polynomial) -> list[fmpq] | None:
        """The coefficients, ascending, of a polynomial that is not 0 and holds the first variable
        alone; None for any other one."""
        if any(polynomial.degrees()[1:]):
            return None
        row = [fmpq(0)] * (int(polynomial.degrees()[0]) + 1)
        for exponents, value in zip(polynomial.monoms(), polynomial.coeffs(), strict=True):
            row[int(exponents[0])] = value
        return row

    def _powers(self, polynomial: Polynomial) -> dict[int, Expr]:
        """The coefficients of a polynomial as expressions, by powers of the variable."""
        powers: dict[int, list[Expr]] = {}
        for (power, *rest), coefficient in monomials(polynomial):
            factors: list[Expr] = [Rational(int(coefficient.p), int(coefficient.q))]
            for x, n in zip(self.meanings[1:], rest, strict=True):
                if n:
                    factors.append(x ** int(n))
            powers.setdefault(int(power), []).append(Mul(*factors))
        return {power: Add(*terms) for power, terms in powers.items()}

    def factored_expression(self, polynomial: Polynomial) -> Expr:
        """A polynomial as the product of its factors."""
        unit, factors = self.factors(polynomial)
        return Mul(unit, *(self.expression(f) ** n for f, n in factors))

    def factors(
        self, polynomial: Polynomial, *, in_square: bool = True
    ) -> tuple[Rational, list[tuple[Polynomial, int]]]:
        """A number and the factors over Q; of an even polynomial, unless told otherwise, those in
        the square of the variable.

        >>> from haptisym.kernel.rings import s
        >>> ring = PolynomialRing(s)
        >>> [ring.expression(f) for f, _ in ring.factors(ring.variable**4 + 4)[1]]   # not (s^2 - 2 s + 2) (s^2 + 2 s + 2)
        [s**4 + 4]
        """
        if polynomial.is_constant():
            return Rational(str(polynomial)), []
        # In the square of the variable a factor is irreducible as a polynomial in that square;
        # powers that all terms share are split off first, which makes omega p(omega^2) even.
        strides, shifts = polynomial.deflation_index()
        step = 2 if in_square and int(strides[0]) % 2 == 0 else 1
        squares = [step, *[1] * (len(self.meanings) - 1)]
        shared = [int(n) for n in shifts]
        shared_powers = [(x, n) for x, n in zip(self.context.gens(), shared, strict=True) if n]
        rest = (
            polynomial / self.context.from_dict({tuple(shared): 1}) if shared_powers else polynomial
        )
        unit, factors = self._split(rest.deflate(squares) if step > 1 else rest)
        inflated = [
            (factor.inflate(squares) if step > 1 else factor, int(n)) for factor, n in factors
        ]
        return Rational(int(unit.p), int(unit.q)), shared_powers + inflated

    def _split(self, polynomial: Polynomial) -> tuple[fmpq, list[tuple[Polynomial, int]]]:
        """A number and the irreducible factors; those of a polynomial in one variable found as
        such, which is much faster."""
        degrees = [int(n) for n in polynomial.degrees()]
        used = [i for i, n in enumerate(degrees) if n]
        # Nothing interrupts FLINT's factoring of many variables; its time is guessed beforehand.
        if len(used) != 1:
            afford(len(polynomial), len(polynomial))
            return polynomial.factor()  # type: ignore[no-any-return]
        terms = {int(exponents[used[0]]): value for exponents, value in monomials(polynomial)}
        unit, factors = fmpq_poly([terms.get(n, fmpq(0)) for n in range(max(terms) + 1)]).factor()
        place = [
            tuple(n if i == used[0] else 0 for i in range(len(degrees)))
            for n in range(max(terms) + 1)
        ]
        return unit, [
            (self.context.from_dict(dict(zip(place, f.coeffs(), strict=False))), n)
            for f, n in factors
        ]

    def without_common_functions(self, polynomial: Polynomial) -> tuple[Expr, Polynomial]:
        """The product of powers of the further functions that all terms share, and the polynomial
        divided by it."""
        terms = list(monomials(polynomial))
        columns = zip(*(e for e, _ in terms), strict=True)
        shared = [
            min(map(int, column)) if i >= self.size else 0 for i, column in enumerate(columns)
        ]
        if not any(shared):
            return Integer(1), polynomial
        rest = {tuple(n - m for n, m in zip(map(int, e), shared, strict=True)): c for e, c in terms}
        return Mul(
            *(x**n for x, n in zip(self.meanings, shared, strict=True))
        ), self.context.from_dict(rest)


@dataclass(frozen=True, slots=True, eq=False)
class RationalFunction:
    """A quotient of two polynomials of one ring. Arithmetic does not cancel: ``reduced`` does,
    once, where it matters."""

    ring: PolynomialRing
    numerator: Polynomial
    denominator: Polynomial

    def __add__(self, other: RationalFunction) -> RationalFunction:
        # An equal denominator is kept: multiplied, it would be squared, as nothing cancels here.
        if self.denominator == other.denominator:
            return self._new(self.numerator + other.numerator, self.denominator)
        top = times(self.numerator, other.denominator) + times(other.numerator, self.denominator)
        return self._new(top, times(self.denominator, other.denominator))

    def __neg__(self) -> RationalFunction:
        return self._new(-self.numerator, self.denominator)

    def __sub__(self, other: RationalFunction) -> RationalFunction:
        return self + -other

    def __mul__(self, other: RationalFunction) -> RationalFunction:
        return self._new(
            times(self.numerator, other.numerator), times(self.denominator, other.denominator)
        )

    def __truediv__(self, other: RationalFunction) -> RationalFunction:
        if other.is_zero:
            raise SceneError("division by zero")
        # Divided by a number the denominator stays what it was, so that sums have it in common.
        if other.numerator.is_constant():
            number = other.numerator.leading_coefficient()
            return self._new(times(self.numerator, other.denominator) / number, self.denominator)
        return self._new(
            times(self.numerator, other.denominator), times(self.denominator, other.numerator)
        )

    def __pow__(self, exponent: int) -> RationalFunction:
        if exponent < 0:
            return self.ring.one / self**-exponent
        return self._new(self.numerator**exponent, self.denominator**exponent)

    def _new(self, numerator: Polynomial, denominator: Polynomial) -> RationalFunction:
        return self.ring.function(numerator, denominator)

    @property
    def is_zero(self) -> bool:
        """Whether it is 0."""
        return bool(self.numerator.is_zero())

    def equals(self, other: RationalFunction) -> bool:
        """Whether both are the same function: exact."""
        return (self - other).is_zero

    def reduced(self) -> RationalFunction:
        """In lowest terms, the denominator with leading coefficient 1."""
        afford(len(self.numerator), len(self.denominator))
        top, bottom = self.numerator, self.denominator
        common = top.gcd(bottom)
        if not common.is_one():
            top, bottom = top / common, bottom / common
        return self._new(top, bottom).monic()

    def monic(self) -> RationalFunction:
        """The same function, the denominator with leading coefficient 1."""
        leading = self.denominator.leading_coefficient()
        if leading == 1:
            return self
        return self._new(self.numerator / leading, self.denominator / leading)

    def cleared(self) -> RationalFunction:
        """The same function with whole coefficients, as small as they can be, in numerator and
        denominator."""
        coefficients = [*self.numerator.coeffs(), *self.denominator.coeffs()]
        below = reduce(lcm, (int(c.q) for c in coefficients), 1)
        above = reduce(gcd, (int(c.p) * (below // int(c.q)) for c in coefficients), 0) or 1
        scale = fmpq(below, above)
        return self._new(self.numerator * scale, self.denominator * scale)

    def expression(self) -> Expr:
        """A SymPy quotient, in lowest terms, the denominator in factors."""
        reduced = self.reduced().cleared()
        return self.ring.expression(reduced.numerator) / self.ring.factored_expression(
            reduced.denominator
        )

    def factored(self) -> Expr:
        """A SymPy quotient, in lowest terms, both numerator and denominator in factors."""
        reduced = self.reduced().cleared()
        return self.ring.factored_expression(reduced.numerator) / self.ring.factored_expression(
            reduced.denominator
        )


def times(x: Polynomial, y: Polynomial) -> Polynomial:
    """The product of two polynomials; LimitError where time or memory do not allow it."""
    if x.is_one():
        return y
    if y.is_one():
        return x
    afford(len(x), len(y))
    # A product has no more terms than there are pairs of terms, or monomials of its degrees.
    if len(x) * len(y) > MOST_TERMS:
        degrees = zip(x.degrees(), y.degrees(), strict=True)
        monomials_at_most = prod(int(n) + int(m) + 1 for n, m in degrees)
        room(min(len(x) * len(y), monomials_at_most))
    return x * y


def cleared(matrix: Sequence[RationalFunction]) -> list[Any]:
    """The entries of a matrix times their least common denominator, as polynomials: a Moebius map
    is the same for a matrix and its multiples."""
    common = matrix[0].denominator
    for entry in matrix[1:]:
        common = common * (entry.denominator / common.gcd(entry.denominator))
    return [entry.numerator * (common / entry.denominator) for entry in matrix]


def degree_in(polynomials: Sequence[Polynomial], index: int) -> int:
    """The highest degree of any of the polynomials in one variable of their ring."""
    return max((int(p.degrees()[index]) for p in polynomials if not p.is_zero()), default=0)
