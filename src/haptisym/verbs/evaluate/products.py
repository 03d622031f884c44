"""The functions behind an evaluation as a certificate tells them: products, waves and powers.

Distortions whose powers s^alpha are Re and Im of (j omega)^alpha, as a certificate tells them, not modulus and angle.

Factors with sines and cosines, as delays bring them, and powers: their signs in a cell, as a certificate shows them.

The functions behind an evaluation as products of polynomials with whole coefficients, as a certificate tells them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import accumulate
from math import factorial
from operator import add
from typing import Any, TypeAlias

import flint
from flint import arb, arb_poly, fmpq, fmpq_poly
from sympy import Expr, Rational, Symbol

from haptisym.kernel.axis import Axis, ComplexPolynomial
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.model.distortion import Distortion

_LAST = "\U0010ffff"
"""Symbols are sorted by their names: no other one stands behind those with this."""


class RectangularAxis(Axis):
    """Real functions in omega, pi, tan(omega tau/2) and two independent variables for each power: its real and imaginary part."""

    def __init__(self, symbols: Sequence[Symbol], lags: Sequence[Expr], powers: Sequence[Expr], *, j: bool) -> None:
        names = [Symbol(f"{_LAST}{i:02}{part}") for i in range(len(powers)) for part in "ab"]
        super().__init__([*symbols, *names], lags, (), j=j)
        self.powers = tuple(powers)
        self._inner = Ring([*symbols, *names], lags, (), j=j)
        self._start = 2 + len(symbols)

    def parts(self, polynomials: Sequence[Polynomial]) -> list[ComplexPolynomial]:
        split = [self._by_powers(p) for p in polynomials]
        found = iter(super().parts([q for row in split for q in row.values()]))
        return [self._joined([*row], found) for row in split]

    def _by_powers(self, polynomial: Polynomial) -> dict[tuple[int, ...], Polynomial]:
        """What stands before each product of powers: the dynamics' variables are s, pi, symbols, delays, powers and j."""
        start = self._start
        first, rows = start + self.delays, dict[tuple[int, ...], dict[tuple[int, ...], object]]()
        for exponents, value in polynomial.to_dict().items():
            own = tuple(map(int, exponents))
            powers, rest = own[first : first + len(self.powers)], own[first + len(self.powers) :]
            inner = (*own[:start], *[0] * (2 * len(self.powers)), *own[start:first], *rest)
            rows.setdefault(powers, {})[inner] = value
        return {powers: self._inner.context.from_dict(row) for powers, row in rows.items()}

    def _joined(self, powers: Sequence[tuple[int, ...]], found: Iterator[ComplexPolynomial]) -> ComplexPolynomial:
        """The sum of parts times their powers (x + j y)^n."""
        gens, real, imag = self.context.gens(), self.constant(0), self.constant(0)
        for exponents, (x, y) in zip(powers, found, strict=False):
            for i, n in enumerate(exponents):
                a, b = gens[self._start + 2 * i : self._start + 2 * i + 2]
                for _ in range(n):
                    x, y = x * a - y * b, x * b + y * a
            real, imag = real + x, imag + y
        return real, imag


class RectangularRing(Ring):
    """The same dynamics as a ring, on such an axis."""

    @classmethod
    def like(cls, ring: Ring) -> RectangularRing:
        """With the same variables."""
        return cls(ring.symbols, ring.lags, ring.orders, j=ring.axis.complex)

    @cached_property
    def axis(self) -> RectangularAxis:
        return RectangularAxis(self.symbols, self.lags, self.orders, j=super().axis.complex)


def rectangular(d: Distortion) -> Distortion:
    """A distortion as it is, but for the axis of its real functions."""
    ring = d.env.ring
    assert isinstance(ring, Ring)
    if not ring.orders:
        return d
    other = RectangularRing.like(ring)
    env, perc = (RationalFunction(other, x.numerator, x.denominator) for x in (d.env, d.perc))
    return replace(d, env=env, perc=perc)


Rows: TypeAlias = tuple[tuple[int, ...], ...]
"""The coefficients of a polynomial, ascending, each as those of ascending powers of pi."""
Turns: TypeAlias = tuple[int, ...]
Balls: TypeAlias = list[tuple[Turns, list[tuple[int, Any]]]]
"""Terms: the coefficients that are not zero, with pi in them, and their powers of omega."""

ORDER = 14  # of Taylor's sums in a cell, as a checker has it
_MOST, _MOST_TERMS = 40, 300
_MARGIN = 1e-6  # so that a checker that rounds otherwise finds the same signs
_LEAST = 1e-60  # as it knows numbers to 80 digits behind the point
_BITS = 280  # a checker computes with 80 digits


@dataclass(frozen=True)
class WaveFactor:
    """The sum over ``terms`` of p(omega) prod sin(omega tau_i/2)^k_i cos(omega tau_i/2)^(n_i - k_i) prod x_i^a_i y_i^b_i.

    The n_i are ``waves``, x_i + j y_i is (j omega)^alpha_i, the alpha_i being ``orders``; turns are the k_i, then a_0, b_0, ....
    """

    terms: tuple[tuple[Turns, Rows], ...]
    waves: Turns
    delays: tuple[Fraction, ...]
    orders: tuple[Fraction, ...] = ()

    def moved(self, low: Fraction, high: Fraction) -> tuple[int, ...] | None:
        """Signs whose changes are the zeros between two numbers; None where not shown."""
        with flint.ctx.workprec(_BITS):
            if not low:
                return self._moved_from_0(high)
            model, rest = self._model(self._balls, low, high)
            if side := _side(model, rest):
                return (side,)
            if not _side([n * c for n, c in enumerate(model)][1:], ORDER * rest):
                return None
            ends = _sides([sum((-c if n % 2 else c for n, c in enumerate(model)), rest), sum(model, rest)])
            return ends if all(ends) else None

    def _moved_from_0(self, high: Fraction) -> tuple[int, ...] | None:
        """All partial sums of coefficients have one sign, from the lowest power of omega on (Abel)."""
        total, more = dict[Fraction, Any](), arb(0)
        for (powers, there), balls in zip(self._beginnings.items(), self._apart, strict=True):
            exponent = sum((a * sum(pair) for a, pair in zip(self.orders, _pairs(powers), strict=True)), Fraction(0))
            model, rest = self._model(balls, Fraction(0), high)
            more += rest
            for n in (n for n in range(ORDER + 1) if n == ORDER or there[n]):
                total[exponent + n] = total.get(exponent + n, arb(0)) + [*model, arb(0)][n]
        sides = _sides([x + more for x in accumulate(total[e] for e in sorted(total))])
        return sides[:1] if sides[0] and len({*sides}) == 1 else None

    def sign_at(self, x: Fraction) -> int:
        """The sign at a number > 0; 0 where it is zero, or open."""
        with flint.ctx.workprec(_BITS):
            return _sides([self._series(self._balls, x, x, Fraction(0), order=0)[0]])[0]

    def _model(self, balls: Balls, low: Fraction, high: Fraction) -> tuple[list[Any], Any]:
        """Balls c_n, and one about 0 for what the sum of c_n v^n, v from -1 to 1 (0 to 1 from 0 on), leaves of that of terms."""
        middle = (low + high) / 2 if low else low
        here = self._series(balls, middle, middle, high - middle)
        largest = self._series(self._sized(balls), low, high, high - middle)[ORDER]
        return [here[n] for n in range(ORDER)], arb(0, largest.abs_upper()) * arb(1, _MARGIN)

    def _sized(self, balls: Balls) -> Balls:
        """Nowhere is a term of them as large: those of cosines alone, as all sizes of sines are those of cosines."""
        return [
            ((0,) * len(self.waves) + turns[len(self.waves) :], [(n, arb(x.abs_upper())) for n, x in own])
            for turns, own in balls
        ]

    def _series(self, balls: Balls, low: Fraction, high: Fraction, step: Fraction, order: int = ORDER) -> Any:
        """Balls that hold h^n f^(n)/n! for the step h, n up to ``order``, at a number, or their sizes wherever between two."""
        omega, tables = _place(self.delays, self.orders, low, high, step, order)
        total = arb_poly([0])
        for turns, own in balls:
            term = sum((x * omega[n] for n, x in own), arb_poly([0]))
            for table, n in zip(tables, self._exponents(turns), strict=True):
                term = (term * table[n]).truncate(order + 1) if n else term
            total = total + term
        return total

    def _exponents(self, turns: Turns) -> Turns:
        """Of each sine and its cosine, then of each real part and its imaginary part."""
        own = [n for k, most in zip(turns, self.waves, strict=False) for n in (k, most - k)]
        return (*own, *turns[len(self.waves) :])

    @cached_property
    def _apart(self) -> list[Balls]:
        """The terms of each product of powers."""
        return [[x for x in self._balls if x[0][len(self.waves) :] == powers] for powers in self._beginnings]

    @cached_property
    def _balls(self) -> Balls:
        with flint.ctx.workprec(_BITS):
            powers = Powers(arb.pi())
            return [
                (
                    turns,
                    [
                        (n, sum((c * powers[k] for k, c in enumerate(row)), arb(0)))
                        for n, row in enumerate(own)
                        if any(row)
                    ],
                )
                for turns, own in self.terms
            ]

    @cached_property
    def _beginnings(self) -> dict[Turns, list[bool]]:
        """Which of Taylor's coefficients at 0 are not zero, exactly, beside each product of powers."""
        total: dict[Turns, dict[int, fmpq_poly]] = {}
        tables = [[Powers(x, lambda p: p.truncate(ORDER)) for x in _series(tau)] for tau in self.delays]
        for turns, rows in self.terms:
            wave, own = fmpq_poly([1]), total.setdefault(turns[len(self.waves) :], {})
            for (cosines, sines), k, n in zip(tables, turns, self.waves, strict=False):
                wave = (wave * cosines[n - k] * sines[k]).truncate(ORDER)
            for q in range(max(map(len, rows))):
                column = fmpq_poly([row[q] if q < len(row) else 0 for row in rows])
                own[q] = own.get(q, fmpq_poly([0])) + (column * wave).truncate(ORDER)
        return {powers: [any(p[n] for p in own.values()) for n in range(ORDER)] for powers, own in total.items()}

    @property
    def cost(self) -> int:
        """Of a sign of it, as the limits of the format have it."""
        rows = [row for _, own in self.terms for row in own]
        sizes = sum(max(n.bit_length() for n in row) + len(row) + 40 for row in rows)
        powers = zip(*([sum(x) for x in _pairs(turns[len(self.waves) :])] for turns, _ in self.terms), strict=True)
        widths: int = 1 + sum(self.waves) + sum(map(max, powers))
        return 2 * (sizes + 500 * len(self.terms) * widths)

    def told(self) -> dict[str, Any]:
        """As a certificate tells it."""
        terms = [[list(turns), [[str(n) for n in row] for row in rows]] for turns, rows in self.terms]
        return {"waves": list(self.waves), "terms": terms}


def _rows(coefficients: Mapping[tuple[int, int], int]) -> Rows:
    """Ascending in omega, each ascending in pi."""
    size = max((n for n, _ in coefficients), default=0) + 1
    return tuple(
        tuple(coefficients.get((n, q), 0) for q in range(max((k for m, k in coefficients if m == n), default=0) + 1))
        for n in range(size)
    )


def _ball(x: Fraction) -> Any:
    return arb(fmpq(x.numerator, x.denominator))


class Powers:
    """Those of something, each computed once; ``cut`` : what becomes of a product."""

    def __init__(self, x: Any, cut: Callable[[Any], Any] = lambda x: x) -> None:
        self._x, self._cut, self._found = x, cut, [x**0]

    def __getitem__(self, n: int) -> Any:
        while len(self._found) <= n:
            self._found.append(self._cut(self._found[-1] * self._x))
        return self._found[n]


def _pairs(row: Turns) -> list[Turns]:
    return [row[i : i + 2] for i in range(0, len(row), 2)]


@lru_cache(maxsize=16)
def _place(
    delays: tuple[Fraction, ...],
    orders: tuple[Fraction, ...],
    low: Fraction,
    high: Fraction,
    step: Fraction,
    order: int,
) -> tuple[Powers, list[Powers]]:
    """Series of omega, of sine and cosine of each omega tau/2, and of powers, at a number or as large as wherever between two.

    From 0 on powers are those of the step.
    """

    def powers(terms: list[Any]) -> Powers:
        return Powers(arb_poly(terms[: order + 1]), lambda p: p.truncate(order + 1))

    tables = list[Powers]()
    for tau in delays:
        sine, cosine = (_ball(high * tau / 2)).sin_cos() if low == high else (arb(1), arb(1))
        ahead, weights = _ball(step * tau / 2), [arb(1)]
        for n in range(order):
            weights.append(weights[-1] * ahead / (n + 1))
        turns = [cosine, -sine, -cosine, sine] if low == high else [cosine] * 4
        tables += [powers([turns[(n + i) % 4] * w for n, w in enumerate(weights)]) for i in (3, 0)]
    for alpha in orders:
        own = _binomial(alpha, step, low, order) if low else [_raised(step, alpha)]
        if low < high:
            own = [_raised(high, alpha), *map(abs, own[1:])]
        sine, cosine = (_ball(alpha / 2) * arb.pi()).sin_cos()
        tables += [powers([x * wave for x in own]) for wave in (cosine, sine)]
    return powers([_ball(high), _ball(step)]), tables


def _raised(x: Fraction, alpha: Fraction) -> Any:
    """x^alpha, x > 0."""
    return (_ball(alpha) * _ball(x).log()).exp()


def _binomial(alpha: Fraction, step: Fraction, x: Fraction, order: int) -> list[Any]:
    """h^n/n! times the n-th derivative of omega^alpha at x."""
    weights, ahead = [_raised(x, alpha)], _ball(step / x)
    for n in range(order):
        weights.append(weights[-1] * _ball((alpha - n) / (n + 1)) * ahead)
    return weights


def _series(tau: Fraction) -> tuple[fmpq_poly, fmpq_poly]:
    rate = fmpq(tau.numerator, 2 * tau.denominator)
    terms = [rate**n / factorial(n) for n in range(ORDER)]
    found = [fmpq_poly([(1, 0, -1, 0)[(n + i) % 4] * c for n, c in enumerate(terms)]) for i in (0, 3)]
    return found[0], found[1]


def _side(model: Sequence[Any], rest: Any) -> int:
    """The sign for all v from -1 to 1, if Bernstein's coefficients show it."""
    own = arb_poly([*model])(arb_poly([-1, 2])) + rest
    found = [own[0]]
    for n in range(1, len(model)):  # (1 + u) f + c u^n
        found = [found[0], *map(add, found[1:], found), found[-1] + own[n]]
    return all(x > 0 for x in found) - all(x < 0 for x in found)


def _sides(balls: Sequence[Any]) -> tuple[int, ...]:
    """The signs of numbers; 0 where one is zero, or so small that it is open."""
    return tuple((x > _LEAST) - (x < -_LEAST) for x in balls)


def wave_factor(
    factor: Polynomial, first: int, delays: tuple[Fraction, ...], orders: tuple[Fraction, ...] = (), second: int = 1
) -> WaveFactor:
    """A polynomial made homogeneous in cosine and sine of half angles. Tangents begin at ``first``, the last one's first.

    Before them are Re and Im of powers; at ``second`` is pi, or what takes its place.
    """
    places, terms = slice(first, first + len(delays)), dict[Turns, dict[tuple[int, int], int]]()
    raised = slice(first - 2 * len(orders), first)
    waves = tuple(int(n) for n in factor.degrees()[places][::-1])
    if max(waves, default=0) > _MOST:
        raise SceneError(f"a certificate has room for delays that are at most about {_MOST} times a common one")
    for exponents, value in factor.to_dict().items():
        own = [int(n) for n in exponents]
        terms.setdefault((*own[places][::-1], *own[raised]), {})[own[0], own[second]] = int(value.p)
    if len(terms) > _MOST_TERMS or any(n > _MOST for n in factor.degrees()[raised]):
        raise SceneError(
            f"a certificate has room for {_MOST_TERMS} products of sines and powers in a factor, to at most {_MOST}"
        )
    return WaveFactor(tuple((turns, _rows(own)) for turns, own in sorted(terms.items())), waves, delays, orders)


def cosine_factor(i: int, delays: tuple[Fraction, ...], orders: tuple[Fraction, ...] = ()) -> WaveFactor:
    """cos(omega tau/2) of one of the delays."""
    turns = (0,) * (len(delays) + 2 * len(orders))
    return WaveFactor(((turns, ((1,),)),), tuple(int(k == i) for k in range(len(delays))), delays, orders)


PI = 1  # the place of pi among what a polynomial is in
_BITS_PRODUCTS = 330  # of pi: the 100 digits that a checker has


@dataclass(frozen=True)
class Factor:
    """A polynomial in variable^step."""

    rows: Rows
    step: int

    @cached_property
    def bounds(self) -> tuple[fmpq_poly, ...]:
        """Polynomials below and above it for arguments >= 0; one alone where pi is not in it."""
        if all(len(row) == 1 for row in self.rows):
            return (fmpq_poly([row[0] for row in self.rows]),)
        with flint.ctx.workprec(_BITS_PRODUCTS):
            balls = [sum((n * arb.pi() ** i for i, n in enumerate(row)), arb(0)) for row in self.rows]
            return tuple(
                fmpq_poly([x.fmpq() for x in ends]) for ends in ([b.lower() for b in balls], [b.upper() for b in balls])
            )

    @property
    def cost(self) -> int:
        """Of a sign of it, as the limits of the format have it."""
        return len(self.rows) ** 3 * max(map(len, self.rows)) + 1000

    def told(self) -> dict[str, Any]:
        """As a certificate tells it."""
        return {"step": self.step, "polynomial": told_rows(self.rows)}

    def moved(self, low: Fraction, high: Fraction | None) -> tuple[int, ...] | None:
        """The signs of the coefficients of (1 + u)^n p((low + high u)/(1 + u)), (None: p(low + u)); None where one is open."""
        ends = low**self.step, None if high is None else high**self.step
        found = [_signs(p, len(self.rows) - 1, *ends) for p in self.bounds]
        return found[0] if found[0] == found[-1] else None

    def sign_at(self, x: Fraction) -> int:
        """The sign at a number >= 0; 0 where it is zero, or open."""
        return (self.moved(x, None) or (0,))[0]


def _signs(p: fmpq_poly, degree: int, low: Fraction, high: Fraction | None) -> tuple[int, ...]:
    start = flint.fmpq(low.numerator, low.denominator)
    if high is None:
        there = p(fmpq_poly([start, 1]))
        return tuple((there[n] > 0) - (there[n] < 0) for n in range(degree + 1))
    end = flint.fmpq(high.numerator, high.denominator)
    there = p(fmpq_poly([start, end - start]))
    turned = fmpq_poly([there[n] for n in range(degree, -1, -1)])(fmpq_poly([1, 1]))
    return tuple((turned[n] > 0) - (turned[n] < 0) for n in range(degree, -1, -1))


@dataclass
class Factors:
    """The factors of some functions, each of them once, and the functions as products of them."""

    listed: dict[Factor, int] = field(default_factory=dict)
    known: list[tuple[Polynomial, Any]] = field(default_factory=list)
    second: int = PI
    """The place in the ring of what stands beside the variable."""

    def product(self, x: RealFunction, *, in_square: bool) -> dict[str, Any]:
        """``number * product of factor^exponent``."""
        return self.quotient(x.axis, x.function.numerator, x.function.denominator, in_square=in_square)

    def quotient(self, ring: PolynomialRing, top: Polynomial, bottom: Polynomial, *, in_square: bool) -> dict[str, Any]:
        """The same of a quotient of polynomials."""
        if top.is_zero():
            return {"number": "0", "powers": []}
        number, powers = Rational(1), Counter[int]()
        for polynomial, sign in ((top, 1), (bottom, -1)):
            unit, factors = self._taken(ring, polynomial, in_square=in_square)
            number *= unit**sign
            for factor, n in factors:
                powers[self._index(factor, in_square=in_square)] += sign * n
        return {"number": str(number), "powers": [[i, n] for i, n in sorted(powers.items()) if n]}

    def _taken(self, ring: PolynomialRing, polynomial: Polynomial, *, in_square: bool) -> Any:
        found = next((taken for other, taken in self.known if other == polynomial), None)
        if found is None:
            found = ring.factors(polynomial, in_square=in_square)
            self.known.append((polynomial, found))
        return found

    def _index(self, factor: Polynomial, *, in_square: bool) -> int:
        rows = rows_of(factor, self.second)
        even = in_square and not any(any(row) for row in rows[1::2])
        return self.listed.setdefault(Factor(rows[::2] if even else rows, 2 if even else 1), len(self.listed))


def rows_of(polynomial: Polynomial, second: int = PI) -> Rows:
    """The coefficients of a polynomial with whole ones in the variable and pi, or another; SceneError where it holds more."""
    rows: dict[int, dict[int, int]] = {}
    for powers, value in polynomial.to_dict().items():
        _need_alone([int(n) for n in powers], second)
        rows.setdefault(int(powers[0]), {})[int(powers[second])] = int(value.p)
    return tuple(
        tuple(row.get(i, 0) for i in range(max(row, default=0) + 1))
        for row in (rows.get(n, {}) for n in range(max(rows) + 1))
    )


def _need_alone(powers: Sequence[int], second: int) -> None:
    """SceneError where a polynomial holds more than the variable and what stands beside it."""
    others = [i for i, n in enumerate(powers) if n and i not in (0, second)]
    if others:
        raise SceneError(BESIDE_PI if others == [PI] else NOT_RATIONAL)


def told_rows(rows: Rows) -> list[list[str]]:
    """As a certificate tells them."""
    return [[str(n) for n in row] for row in rows]


NOT_RATIONAL = (
    "a certificate needs a rational scene: this one has a delay, a hold or a fractional power of s, "
    "so that its functions are no quotients of polynomials"
)


BESIDE_PI = "a certificate with a free parameter needs a scene without pi, in formulas too: write frequencies in rad/s, not in Hz"


def are_even(functions: Sequence[RealFunction]) -> bool:
    """Whether all numerators and denominators are even or odd in omega; those of Coulomb friction are not."""
    every = (p for f in functions for p in (f.function.numerator, f.function.denominator) if not p.is_zero())
    return all(len({int(e[0]) % 2 for e in p.monoms()}) == 1 for p in every)


@dataclass(frozen=True)
class Linked:
    """Functions as products of factors; ``delays`` : tau of the half angles omega tau/2 in factors, the longest first.

    ``orders`` : of the powers (j omega)^alpha.
    """

    factors: list[Factor | WaveFactor]
    told: dict[str, dict[str, Any]]
    delays: tuple[Fraction, ...] = ()
    orders: tuple[Fraction, ...] = ()


def products(functions: Mapping[str, RealFunction], second: int = PI) -> Linked:
    """The factors of real functions, and each function as the product of them; ``second`` : as of ``Factors``."""
    axis = next(iter(functions.values())).axis
    powers = axis.powers if isinstance(axis, RectangularAxis) else ()
    if not axis.functions and not powers:
        factors, told = rational_products(functions, second)
        return Linked([*factors], told)
    others = [*axis.lags[::-1], *powers]
    if len(others) > _MOST_OTHERS or not all(x.is_Rational and max(x.p, x.q) < _LARGEST for x in others):
        raise SceneError(NO_ROOM)
    exact = tuple(Fraction(int(x.p), int(x.q)) for x in others)
    delays, orders = exact[: len(axis.lags)], exact[len(axis.lags) :]
    waves = WaveProducts(axis, delays, orders, second)
    told = {name: waves.product(f) for name, f in functions.items()}
    return Linked(list(waves.listed), told, delays, orders)


_MOST_OTHERS, _LARGEST = 4, 2**100
NO_ROOM = (
    f"a certificate of a scene with delays or powers of s has room for {_MOST_OTHERS} delays that are no multiples of each "
    "other and orders together, each a rational number (a delay in seconds) of at most 30 digits"
)


class WaveProducts:
    """The factors of functions with delays or powers, each of them once."""

    def __init__(
        self, axis: Axis, delays: tuple[Fraction, ...], orders: tuple[Fraction, ...], second: int = PI
    ) -> None:
        self.axis, self.delays, self.orders, self.second = axis, delays, orders, second
        self.listed: dict[Factor | WaveFactor, int] = {}
        self.known: list[tuple[Polynomial, Any]] = []

    def product(self, x: RealFunction) -> dict[str, Any]:
        """``number * product of factor^exponent``."""
        if x.is_zero:
            return {"number": "0", "powers": []}
        number, found = Rational(1), Counter[Factor | WaveFactor]()
        for polynomial, sign in ((x.function.numerator, 1), (x.function.denominator, -1)):
            unit, factors = self._taken(polynomial)
            number *= unit**sign
            for factor, n in factors:
                found[factor] += sign * n
        powers = {self.listed.setdefault(factor, len(self.listed)): n for factor, n in found.items() if n}
        return {"number": str(number), "powers": [list(x) for x in sorted(powers.items())]}

    def _taken(self, polynomial: Polynomial) -> tuple[Rational, list[tuple[Factor | WaveFactor, int]]]:
        found = next((taken for other, taken in self.known if other == polynomial), None)
        if found is None:
            found = self._factors(polynomial)
            self.known.append((polynomial, found))
        return found

    def _factors(self, polynomial: Polynomial) -> tuple[Rational, list[tuple[Factor | WaveFactor, int]]]:
        """A number, and factors with their exponents: tangents made homogeneous in cosine and sine."""
        size, count = self.axis.size, len(self.delays)
        number, factors = self.axis.factors(self.axis.without_circles(polynomial)[0], in_square=False)
        found = list[tuple[Factor | WaveFactor, int]]()
        first = size - 2 * len(self.orders)
        for factor, n in factors:
            _need_alone([int(k) for k in factor.degrees()[:first]], self.second)
            if any(factor.degrees()[first:]):
                found.append((wave_factor(factor, size, self.delays, self.orders, self.second), n))
            else:
                found.append((Factor(rows_of(factor, self.second), 1), n))
        turning = [int(n) for n in polynomial.degrees()[size : size + count]][::-1]
        cosines = [(cosine_factor(i, self.delays, self.orders), -n) for i, n in enumerate(turning) if n]
        return number, [*found, *cosines]


def rational_products(
    functions: Mapping[str, RealFunction], second: int = PI
) -> tuple[list[Factor], dict[str, dict[str, Any]]]:
    """The same of functions without delays; ``second`` : as of ``Factors``."""
    factors, even = Factors(second=second), are_even(list(functions.values()))
    told = {name: factors.product(f, in_square=even) for name, f in functions.items()}
    return list(factors.listed), told
