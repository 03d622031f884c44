"""A plant between a hold and a sampler: its pulse transfer function in balls and exactly, and roots about the unit circle.

Exact numbers made of exponentials: polynomials in algebraic numbers p, in exp(p t) at rational times t, and in pi.

By Lindemann and Weierstrass exponentials of different algebraic numbers are linearly independent over the algebraic numbers. So
such a number is 0 only if it is so once equal exponents are collected, which is a question about algebraic numbers alone; and
those are decided by how near to 0 a number of their size can be without being it. pi stands for itself, as an unknown would.

The polynomial of a loop with a clock in exact numbers: the pulse transfer function by residues at the poles of G(s)/s.

How many roots a polynomial has inside the unit circle and on it: Schur and Cohn's recursion on certified signs.

With f* the polynomial whose coefficients are those of f in reverse, b f - a f* (a the lowest coefficient of f, b its highest)
has as many roots inside as f where |b| > |a|, those on the circle among them, and one of its roots is 0. Each step decides
|b| - |a| by balls; where these cannot, whether a = b or a = -b is asked of the exact coefficients. Where it is so: f = +-f* has
its roots in pairs z, 1/z or on the circle, and as many outside as its derivative (Cohn); any other f is multiplied by 2 z - 1.

A plant in states: where a force that is held takes it, by matrix exponentials in balls.

A continuous plant between a hold and a sampler: its pulse transfer function, and the polynomial of the loop that is closed.

The plant G(s) = sum over i of exp(-s tau_i) N_i(s)/Q(s) is proper. It is driven by a force held for T at a time, and read the
moment before the force changes. In w = 1/z its samples are w^l (w F_1(w) + w^2 F_2(w))/|1 - w exp(A T)|, with A the companion
matrix of Q and tau = l T + theta: F_1 belongs to the force held last, F_2 to the one before, which a delay that is no whole
sample lets in (the modified z-transform). In balls that is a matrix exponential; exactly it is the sum of residues of
G(s)/s exp(s (T - theta)) w/(1 - w exp(s T)).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial, reduce
from math import factorial, frexp, lcm, prod
from operator import mul
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeAlias

import flint
from flint import Ordering, acb, arb, arb_mat, arb_poly, fmpq, fmpq_mpoly_ctx, fmpq_poly, fmpz_poly
from sympy import Expr, Symbol, pi

from haptisym.kernel.budget import afford
from haptisym.kernel.enclosures import Value, joined, like, parts, value
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import MOST_BITS, Ball, at_rising_precision, expression_ball
from haptisym.kernel.rings import monomials

Element: TypeAlias = Any  # flint.fmpq_mpoly, which ships no types
Exponent: TypeAlias = tuple[fmpq, ...]

_MOST_BITS = 1 << 19  # of the precision at which an algebraic number of some degree is known to be 0


class Exponentials:
    """Q[w, pi, p_1, ..., exp(p_1 t_1), ...] over the roots p_i of irreducible polynomials with whole coefficients (ascending).

    >>> ring = Exponentials([(1, 1)], [fmpq(1, 2), fmpq(1)])                # p = -1
    >>> half, whole = ring.exponential(0, 0), ring.exponential(0, 1)
    >>> ring.is_zero(half * half - whole), ring.is_zero(half - whole)
    (True, False)
    >>> ring = Exponentials([(-2, 0, 1)], [fmpq(1)])                        # +- sqrt 2
    >>> ring.is_zero(ring.exponential(0, 0) * ring.exponential(1, 0) - 1), ring.is_zero(ring.root(0) ** 2 - 2)
    (True, True)
    """

    def __init__(self, factors: Sequence[tuple[int, ...]], times: Sequence[fmpq]) -> None:
        self.factors, self.times = tuple(factors), tuple(times)
        self.owner = [i for i, f in enumerate(factors) for _ in range(len(f) - 1)]
        count = len(self.owner)
        names = ["w", "pi", *(f"p{i}" for i in range(count))]
        names += [f"e{i}_{k}" for i in range(count) for k in range(len(times))]
        self.context = fmpq_mpoly_ctx.get(tuple(names), Ordering.lex)
        self.gens = self.context.gens()

    @property
    def w(self) -> Element:
        """An unknown, in which polynomials may be written."""
        return self.gens[0]

    @property
    def pi(self) -> Element:
        """The generator that stands for pi."""
        return self.gens[1]

    def constant(self, value: Any) -> Element:
        """A rational number."""
        return self.context.constant(value)

    def root(self, i: int) -> Element:
        """The generator that stands for the i-th algebraic number."""
        return self.gens[2 + i]

    def exponential(self, i: int, k: int) -> Element:
        """exp(p_i t_k)."""
        return self.gens[2 + len(self.owner) + i * len(self.times) + k]

    def is_zero(self, x: Element) -> bool:
        """Whether an element without w is 0, exactly but for pi, which is taken as an unknown."""
        groups: list[tuple[int, Exponent, Element]] = []
        for power, exponent, term in self._terms(x):
            place = next((i for i, (n, e, _) in enumerate(groups) if n == power and self._same(e, exponent)), None)
            if place is None:
                groups.append((power, exponent, term))
            else:
                groups[place] = (*groups[place][:2], groups[place][2] + term)
        return all(self._vanishes(total) for _, _, total in groups)

    def _terms(self, x: Element) -> Iterator[tuple[int, Exponent, Element]]:
        """Power of pi, exponent over the roots and what stands before it, of each term."""
        count, size = len(self.owner), len(self.times)
        for powers, number in monomials(x):
            own = [int(n) for n in powers]
            late = own[2 + count :]
            exponent = tuple(
                sum((late[i * size + k] * t for k, t in enumerate(self.times)), fmpq(0)) for i in range(count)
            )
            yield own[1], exponent, self.context.from_dict({(0, 0, *own[2 : 2 + count], *[0] * len(late)): number})

    def _same(self, one: Exponent, other: Exponent) -> bool:
        if one == other:
            return True
        apart = sum(((a - b) * self.root(i) for i, (a, b) in enumerate(zip(one, other, strict=True))), self.constant(0))
        return self._vanishes(apart)

    def _vanishes(self, f: Element) -> bool:
        """Whether a polynomial in the roots is 0: by a bound below which no other algebraic number of its size can be."""
        if f.is_constant():
            return bool(f.is_zero())
        with flint.ctx.workprec(128):
            if not self._value(f).contains(0):
                return False
        bits = self._gap(f)
        if bits > _MOST_BITS:
            raise UndecidedError("whether an algebraic number of high degree is 0")
        with flint.ctx.workprec(bits + 64):
            value = self._value(f)
            while value.contains(0) and value.abs_upper() > arb(2) ** -bits:
                flint.ctx.prec *= 2
                value = self._value(f)
            return bool(value.contains(0))

    def _gap(self, f: Element) -> int:
        """n such that |f| is 0 or above 2^-n: times A it is an algebraic integer, whose conjugates multiply to a whole number."""
        conjugates = prod(factorial(len(q) - 1) for q in self.factors)
        degrees = [int(n) for n in f.degrees()[2 : 2 + len(self.owner)]]
        common = prod({int(c.q) for c in f.coeffs()})
        scale = common * prod(abs(self.factors[j][-1]) ** n for j, n in zip(self.owner, degrees, strict=True))
        sizes = [1 + max(abs(c) for c in q[:-1]) // abs(q[-1]) + 1 for q in self.factors]
        size = sum((abs(int(c.p)) // int(c.q) + 1) for c in f.coeffs())
        size *= prod(sizes[j] ** n for j, n in zip(self.owner, degrees, strict=True))
        bits: int = (conjugates - 1) * (scale * size).bit_length() + int(scale).bit_length() + 1
        return bits

    def _value(self, f: Element) -> Any:
        roots = self._roots(flint.ctx.prec)
        total = acb(0)
        for powers, number in monomials(f):
            total += acb(arb(number)) * prod(
                (z ** int(n) for z, n in zip(roots, powers[2:], strict=False) if n), start=acb(1)
            )
        return total

    @cached_property
    def _roots(self) -> Callable[[int], tuple[Any, ...]]:
        """From a precision to balls around the roots, always in the same order."""
        first = [_roots_of(q, 128) for q in self.factors]

        @lru_cache(maxsize=8)
        def at(bits: int) -> tuple[Any, ...]:
            found: list[Any] = []
            for q, known in zip(self.factors, first, strict=True):
                finer = _roots_of(q, max(bits, 128))
                found += [next(z for z in finer if z.overlaps(own)) for own in known]
            return tuple(found)

        return at


def _roots_of(factor: tuple[int, ...], bits: int) -> list[Any]:
    """Balls around the roots of an irreducible polynomial, no two of which meet."""
    with flint.ctx.workprec(bits):
        return [acb(z) for z, _ in fmpz_poly(list(factor)).complex_roots()]


Numbers: TypeAlias = Sequence[Expr]
"""Coefficients, ascending: rational numbers times powers of pi, and sums of such."""
Late: TypeAlias = tuple[Expr, int, Numbers]
"""Of a way through the plant: the part of a sample that it is late by (s), the whole samples, and its numerator."""


def residues(
    denominator: Numbers, ways: Sequence[Late], T: Expr, controller: tuple[Numbers, Numbers]
) -> tuple[Exponentials, list[Element]]:
    """The ring, and the coefficients of ``SampledLoop`` in w, ascending, times a number that is not 0.

    Rational: the plant's denominator, T and what the ways are late by; the other numbers may hold pi.
    """
    return _Residues(denominator, ways, T, controller).polynomial()


def _fmpq(x: Expr) -> fmpq:
    return fmpq(int(x.p), int(x.q))


class _Residues:
    def __init__(
        self, denominator: Numbers, ways: Sequence[Late], T: Expr, controller: tuple[Numbers, Numbers]
    ) -> None:
        self.ways, self.T, self.controller = ways, _fmpq(T), controller
        Q = fmpq_poly([_fmpq(x) for x in denominator])
        if not Q:
            raise UndecidedError("the roots of a loop in which nothing resists the force")
        self.at_0 = next(i for i, x in enumerate(Q.coeffs()) if x)
        self.lead = Q.coeffs()[-1]
        split = fmpq_poly(Q.coeffs()[self.at_0 :]).factor()[1]
        rows = [_whole(f) for f, _ in split]
        times = sorted({self.T, *(self.T - _fmpq(late) for late, _, _ in ways)})
        self.ring, self.times = Exponentials(rows, times), times
        self.poles = [n for row, (_, n) in zip(rows, split, strict=True) for _ in range(len(row) - 1)]
        # s, exp(s t) and what is differentiated live in a ring of the same kind, with s a root of its own
        self.free = Exponentials([*rows, (0, 1)], times)

    def polynomial(self) -> tuple[Exponentials, list[Element]]:
        """In w, ascending, times a number that is not 0."""
        ring, one = self.ring, self.ring.constant(1)
        T = self.times.index(self.T)
        lines = [one - ring.w] + [one - ring.exponential(i, T) * ring.w for i in range(len(self.poles))]
        orders = [self.at_0 + 1, *self.poles]  # of G(s)/s; the samples of its sum are taken 1 - w times
        tops, scales = zip(*(self._residue(i, n) for i, n in enumerate(orders)), strict=True)
        total, common = ring.constant(0), one
        for x in scales:
            common = common * x
        for i, top in enumerate(tops):
            others = one
            for j, (line, n) in enumerate(zip(lines, orders, strict=True)):
                if j != i:
                    others = others * line**n * scales[j]
            total = total + top * others
        den = one
        for line, n in zip(lines, [self.at_0, *self.poles], strict=True):
            den = den * line**n
        above, below = (self._row(row) for row in self.controller)
        found = below * den * common + above * total
        return ring, _by_power(ring, found)

    def _row(self, coefficients: Numbers) -> Element:
        """A polynomial in w whose coefficients may hold pi."""
        total = self.ring.constant(0)
        for n, x in enumerate(coefficients):
            for term in x.expand().as_ordered_terms():
                number, rest = term.as_coeff_Mul()
                power = 0 if rest == 1 else int(rest.as_base_exp()[1])
                assert rest == pi**power
                total = total + self.ring.constant(_fmpq(number)) * self.ring.pi**power * self.ring.w**n
        return total

    def _residue(self, place: int, order: int) -> tuple[Element, Element]:
        """Of a pole, 0 or one of the roots: what stands over (1 - w exp(p T))^order, times a number, and that number."""
        free, count = self.free, len(self.poles)
        s, k = free.root(count), self.times.index(self.T)
        R = free.constant(self.lead)  # Q(s) s without the pole
        for j, n in enumerate([self.at_0 + 1, *self.poles]):
            if j != place:
                R = R * (s - (free.root(j - 1) if j else free.constant(0))) ** n
        line = free.constant(1) - free.exponential(count, k) * free.w
        top = self._above(s, count)
        scale = free.constant(1)
        for n in range(1, order):  # (top/(R line)^n)' = (top' R line - n top (R line)')/(R line)^(n + 1)
            below = R * line
            top = self._slope(top, count) * below - n * top * self._slope(below, count)
            scale = scale * n
        return self._put(top, place), self._put(scale * R**order, place)

    def _above(self, s: Element, count: int) -> Element:
        """Sum over the delays of N(s) exp(s (T - theta)) w^(l + 1)."""
        free, total = self.free, self.free.constant(0)
        for late, ell, above in self.ways:
            k = self.times.index(self.T - _fmpq(late))
            N = sum((self._number(x) * s**n for n, x in enumerate(above)), free.constant(0))
            total = total + N * free.exponential(count, k) * free.w ** (ell + 1)
        return total

    def _number(self, x: Expr) -> Element:
        total = self.free.constant(0)
        for term in x.expand().as_ordered_terms():
            number, rest = term.as_coeff_Mul()
            power = 0 if rest == 1 else int(rest.as_base_exp()[1])
            total = total + self.free.constant(_fmpq(number)) * self.free.pi**power
        return total

    def _slope(self, x: Element, count: int) -> Element:
        """d/ds, where s and its exponentials are the last root's."""
        free = self.free
        total = x.derivative(2 + count)
        for k, t in enumerate(self.times):
            place = 2 + count + 1 + count * len(self.times) + k
            total = total + t * free.exponential(count, k) * x.derivative(place)
        return total

    def _put(self, x: Element, place: int) -> Element:
        """At s = the pole, in the ring of the poles alone."""
        ring, count = self.ring, len(self.poles)
        at = ring.root(place - 1) if place else ring.constant(0)
        roots = [*(ring.root(i) for i in range(count)), at]
        own = [ring.exponential(place - 1, k) if place else ring.constant(1) for k in range(len(self.times))]
        exponentials = [ring.exponential(i, k) for i in range(count) for k in range(len(self.times))]
        return x.compose(ring.w, ring.pi, *roots, *exponentials, *own, ctx=ring.context)


def _whole(factor: fmpq_poly) -> tuple[int, ...]:
    """An irreducible polynomial with whole coefficients."""
    scale = lcm(*(int(c.q) for c in factor.coeffs()))
    return tuple(int((c * scale).p) for c in factor.coeffs())


def _by_power(ring: Exponentials, polynomial: Element) -> list[Element]:
    rows: dict[int, dict[tuple[int, ...], Any]] = {}
    for (n, *rest), number in monomials(polynomial):
        rows.setdefault(int(n), {})[(0, *map(int, rest))] = number
    return [ring.context.from_dict(rows.get(n, {})) for n in range(max(rows) + 1)]


Exact: TypeAlias = Any
_EXACT_FROM = 512  # bits from which on a ball around 0 makes one ask whether it is 0


class Circle(NamedTuple):
    """The roots of a polynomial, each as often as it counts."""

    inside: int
    on: int
    outside: int


class Coefficients(Protocol):
    """A polynomial, ascending: balls around its coefficients, and, if they are ever needed, the coefficients themselves."""

    def balls(self) -> Sequence[Ball]:
        """At the current working precision."""

    def exact(self) -> Sequence[Exact] | None:
        """Elements of some ring, or a common multiple of them; None where they are not known exactly."""

    def is_zero(self, x: Exact) -> bool:
        """Whether a coefficient is 0, decided exactly."""


def count_on_circle(polynomial: Coefficients) -> Circle:
    """Inside, on and outside the unit circle, certified.

    UndecidedError where a sign stays open as the coefficients are not known exactly.

    >>> from flint import arb, fmpq
    >>> @dataclass
    ... class Rational:
    ...     c: list
    ...     def balls(self): return [arb(fmpq(x)) for x in self.c]
    ...     def exact(self): return [fmpq(x) for x in self.c]
    ...     def is_zero(self, x): return x == 0
    >>> count_on_circle(Rational([2, -5, 2])), count_on_circle(Rational([1, 0, 2, 0, 1]))          # (2 z - 1)(z - 2), (z^2 + 1)^2
    (Circle(inside=1, on=0, outside=1), Circle(inside=0, on=4, outside=0))
    """

    def ask(bits: int) -> Circle | None:
        known = _Known(polynomial, bits)
        try:
            return known.count([_Lazy(x, partial(known.coefficient, i)) for i, x in enumerate(polynomial.balls())])
        except _RiseError:
            return None

    found = at_rising_precision(ask, 128, MOST_BITS)
    if found is None:
        raise UndecidedError("whether a root lies on the unit circle")
    return found


class _RiseError(Exception):
    """More precision is needed."""


def _product(x: Exact, y: Exact) -> Exact:
    if hasattr(x, "__len__"):  # a polynomial in exponentials: products grow from step to step
        afford(len(x), len(y))
    return x * y


@dataclass(frozen=True)
class _Lazy:
    """A number as a ball, and exactly once that is asked for."""

    ball: Ball
    make: Callable[[], Exact]

    @cached_property
    def exact(self) -> Exact:
        return self.make()

    def __add__(self, other: _Lazy) -> _Lazy:
        return _Lazy(self.ball + other.ball, lambda: self.exact + other.exact)

    def __sub__(self, other: _Lazy) -> _Lazy:
        return _Lazy(self.ball - other.ball, lambda: self.exact - other.exact)

    def __mul__(self, other: _Lazy) -> _Lazy:
        return _Lazy(self.ball * other.ball, lambda: _product(self.exact, other.exact))

    def times(self, factor: int) -> _Lazy:
        return _Lazy(factor * self.ball, lambda: factor * self.exact)


@dataclass(frozen=True)
class _Known:
    """What is asked about a polynomial at one precision."""

    polynomial: Coefficients
    bits: int

    @cached_property
    def exact(self) -> Sequence[Exact]:
        found = self.polynomial.exact()
        if found is None:
            raise _RiseError
        return found

    def coefficient(self, i: int) -> Exact:
        """The exact ones may end before the balls do, at what is 0."""
        return self.exact[i] if i < len(self.exact) else self.exact[0] - self.exact[0]

    def is_zero(self, x: _Lazy) -> bool:
        """_RiseError where only more precision will tell."""
        if x.ball.is_zero():
            return True
        if not x.ball.contains(0):
            return False
        if self.bits >= _EXACT_FROM and self.polynomial.is_zero(x.exact):
            return True
        raise _RiseError

    def count(self, c: list[_Lazy]) -> Circle:
        """The roots of a polynomial whose coefficients are not all 0."""
        inside, on = 0, 0
        while self.is_zero(c[-1]):
            c = c[:-1]
        while self.is_zero(c[0]):
            c, inside = c[1:], inside + 1
        for at in (1, -1):
            while len(c) > 1 and self.is_zero(_value(c, at)):
                c, on = _without(c, at), on + 1
        rest = self.rest(c) if len(c) > 1 else Circle(0, 0, 0)
        return Circle(rest.inside + inside, rest.on + on, rest.outside)

    def rest(self, c: list[_Lazy]) -> Circle:
        """Of a polynomial without roots at 0, 1 and -1."""
        n = len(c) - 1
        for sign in (1, -1):
            if self.is_zero(c[-1] - c[0].times(sign)):
                if all(self.is_zero(x - y.times(sign)) for x, y in zip(c, c[::-1], strict=True)):
                    own = self.count([x.times(i) for i, x in enumerate(c)][1:])
                    return Circle(own.outside, n - 2 * own.outside, own.outside)
                more = self.count(
                    [y.times(2) - x for x, y in zip([*c, _nothing(c)], [_nothing(c), *c], strict=True)]
                )  # (2 z - 1) f
                return Circle(more.inside - 1, more.on, more.outside)
        a, b = c[0], c[-1]
        larger = bool((b.ball - a.ball) * (b.ball + a.ball) > 0)
        if not larger:  # f* has the roots 1/z
            c, a, b = c[::-1], b, a
        found = self.count([b * x - a * y for x, y in zip(c[1:], c[::-1][1:], strict=True)])
        found = Circle(found.inside + 1, found.on, found.outside)
        return found if larger else Circle(found.outside, found.on, found.inside)


def _nothing(c: Sequence[_Lazy]) -> _Lazy:
    return c[0].times(0)


def _value(c: Sequence[_Lazy], at: int) -> _Lazy:
    """At 1 or -1."""
    total = c[0]
    for i, x in enumerate(c[1:], 1):
        total = total + x.times(at**i)
    return total


def _without(c: Sequence[_Lazy], at: int) -> list[_Lazy]:
    """The quotient by z - at."""
    row = [c[-1]]
    for x in c[-2:0:-1]:
        row.append(x + row[-1].times(at))
    return row[::-1]


_MOST_DOUBLINGS = 64


def matrix(rows: list[list[Value]], columns: int | None = None) -> Any:
    """A matrix, which may be of no size."""
    width = len(rows) if columns is None else columns
    if not rows or not width:
        return arb_mat(len(rows), width)
    return joined(lambda entries: arb_mat(len(rows), width, entries), [x for row in rows for x in row])


@dataclass(frozen=True)
class States:
    """The companion form of a monic denominator Q(s), coefficients ascending, in balls.

    The i-th state is the i-th derivative times rate^(n - 1 - i): with entries of one size a matrix exponential, whose error is
    one for all of its entries, stays narrow where the numbers it is made of are.
    """

    Q: Sequence[Ball]

    @property
    def size(self) -> int:
        """How many states there are: the degree of Q."""
        return len(self.Q) - 1

    @cached_property
    def rate(self) -> Ball:
        """About how fast the plant is, 1/s."""
        n = self.size
        sizes = [float(abs(value(q)).mid()) ** (1 / (n - i)) for i, q in enumerate(self.Q[:n])]
        return arb(max([*sizes, 1.0]))

    @cached_property
    def A(self) -> Any:
        """The companion matrix of Q, its states scaled by the rate."""
        n, rate = self.size, self.rate
        last = [-q / rate ** (n - 1 - j) for j, q in enumerate(self.Q[:n])]
        return matrix([[rate * int(j == i + 1) for j in range(n)] for i in range(n - 1)] + ([last] if n else []))

    def row(self, C: Sequence[Ball]) -> Any:
        """What reads c_0 y + c_1 y' + ... off the states."""
        n = self.size
        return matrix([[c / self.rate ** (n - 1 - j) for j, c in enumerate(C)]], n)

    def held(self, time: Value) -> Any:
        """Where a unit force that is held for some time takes the plant from rest."""
        return column(self.integral(time), self.size - 1)

    def moved(self, time: Value) -> Any:
        """exp(A time)."""
        return self._one + self.A * self.integral(time)

    def integral(self, time: Value) -> Any:
        """int_0^time exp(A t) dt = time S(A time), S(X) = 1 + X/2! + X^2/3! + ...: by its series of a small X, which is doubled.

        As S(2 X) = S(X) + X S(X)^2/2, nothing is taken off what is nearly equal to it.
        """
        X, total = self.A * time, self._one
        doublings = max(0, frexp(float(norm(X).upper()))[1] + 2)  # then |X| <= 1/4
        if doublings > _MOST_DOUBLINGS:
            return total * arb("nan")
        X, rest, k = X * arb(2) ** -doublings, arb(1), 1
        while rest > arb(2) ** -(flint.ctx.prec + 8):
            k, rest = k + 1, rest / (4 * (k + 1))  # 4^(1 - k)/k!, more than the terms from X^k/(k + 1)! on
        for n in range(k, 1, -1):
            total = self._one + X * total * (arb(1) / n)
        last = reduce(mul, [X] * self.size, self._one)
        if not norm(last).is_zero():  # of masses alone nothing is left out, as no higher power is there
            total = widened(total, rest)
        for _ in range(doublings):
            total, X = total + X * total * total * arb(0.5), X * 2
        return total * time

    @cached_property
    def _one(self) -> Any:
        return matrix([[arb(int(i == j)) for j in range(self.size)] for i in range(self.size)])


def column(M: Any, j: int) -> Any:
    """Of a matrix, as one."""
    return matrix([[M[i, j]] for i in range(M.nrows())], 1)


def norm(X: Any) -> Ball:
    """The largest sum of sizes in a row; of a jet that of all its coefficients: the norm of a block matrix that stands for it."""
    n = X.nrows()
    return max(
        (sum((abs(x).upper() for j in range(n) for x in parts(X[i, j])), arb(0)) for i in range(n)), default=arb(0)
    )


def widened(M: Any, radius: Ball) -> Any:
    """With so much more in each entry, and each of its Taylor coefficients."""
    own, columns = arb(0, radius.upper()), range(M.ncols())
    rows = [[like(M[i, j], [own for _ in parts(M[i, j])]) for j in columns] for i in range(M.nrows())]
    return M + matrix(rows, len(columns))


def opposite_response(states: States, C: Any, period: Ball) -> Ball | None:
    """What C reads, just before the force changes, of a force that changes its sign each period: at z = -1.

    C tanh(X)/A e, X = A T/2, is T/2 C e + T/2 C (tanh(X)/X - 1) e, by Taylor's series: where the plant is slow compared with the
    clock little of it is left, without a difference of what is nearly equal. None where the series is of no use.
    """
    n = states.size
    X = states.A * (period / 2)
    if not 4 * norm(X) < arb.pi():
        return None
    column = matrix([[arb(int(i == n - 1))] for i in range(n)], 1)
    found = matrix([[arb(0)] for _ in range(n)], 1)
    for share in _TANH[1:]:
        column = X * (X * column)
        found += column * arb(share)
    most = max((abs(x).upper() for i in range(n) for x in parts(column[i, 0])), default=arb(0))
    found = widened(found, most * (4 / arb.pi() ** 2) ** (len(_TANH) - 1) / 3)
    direct = C[0, n - 1] if n else arb(0)
    return (direct + (C * found)[0, 0] if n else direct) * period / 2


def _tanh(count: int) -> list[fmpq]:
    """The coefficients of tanh(x)/x in x^2: tanh' = 1 - tanh^2."""
    row = [fmpq(1)]
    for k in range(1, count):
        row.append(-sum((row[i] * row[k - 1 - i] for i in range(k)), fmpq(0)) / (2 * k + 1))
    return row


_TANH = _tanh(16)
"""Each at most (4/pi^2)^k large: tanh(x)/x is the sum of 8/((2 j - 1)^2 pi^2 + 4 x^2)."""


"""Coefficients, ascending: rational numbers times powers of pi, and sums of such."""


@dataclass(frozen=True)
class Plant:
    """G(s), by its denominator and, for each delay (s), a numerator; none of them improper."""

    denominator: tuple[Expr, ...]
    terms: tuple[tuple[Expr, tuple[Expr, ...]], ...]

    def __post_init__(self) -> None:
        if any(len(above) > len(self.denominator) for _, above in self.terms):
            raise SceneError("a force that jumps would move the sampled position by an impulse")

    def samples(self, period: Expr, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        """Of each delay the whole samples."""
        numbers = {symbol: value(x) for symbol, x in known.items()}
        return tuple(_floor(lag / period, numbers) for lag, _ in self.terms)


@dataclass(frozen=True)
class SampledLoop:
    """The loop of a plant and a controller D(w) = above/below, w = 1/z, with a clock: 1 + D G = 0, as a polynomial in w.

    A root w in the closed unit disc is a root z = 1/w that does not fade. ``coefficients`` are those of w, ascending.

    >>> from sympy import Integer, Rational
    >>> half = Rational(1, 2)
    >>> plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))            # 1/s, T = 1
    >>> loop = SampledLoop(plant, Integer(1), (half,), (Integer(1),))
    >>> loop.balls()                                                                       # 1 - w + w/2
    [1.00000000000000, -0.500000000000000]
    """

    plant: Plant
    T: Expr
    above: tuple[Expr, ...]
    below: tuple[Expr, ...]
    hidden: tuple[int, int] = (0, 0)
    """Roots with |z| > 1 and |z| = 1 that the clock does not see, so that they are in no coefficient."""

    def circle(self) -> Circle:
        """How its roots w = 1/z, the hidden ones as well, lie about the unit circle: certified, or UndecidedError."""
        found = count_on_circle(self)
        return Circle(found.inside + self.hidden[0], found.on + self.hidden[1], found.outside)

    def at(self, values: Mapping[Symbol, Expr]) -> SampledLoop:
        """With numbers in place of symbols, nothing cancelled."""

        def put(row: Numbers) -> tuple[Expr, ...]:
            known = [x.xreplace(values) for x in row]
            while len(known) > 1 and known[-1] == 0:
                known.pop()
            return tuple(known)

        plant = self.plant
        terms = tuple((lag.xreplace(values), put(N)) for lag, N in plant.terms)
        return SampledLoop(
            Plant(put(plant.denominator), terms), self.T.xreplace(values), put(self.above), put(self.below), self.hidden
        )

    def balls(self, known: Mapping[Expr, Ball] = MappingProxyType({})) -> list[Ball]:
        """The coefficients at the current working precision; ``known`` : balls that symbols in the loop stand for."""
        above, below = (arb_poly([expression_ball(x, known) for x in row]) for row in (self.above, self.below))
        den, num = pulse(self.plant, self.T, self.samples(known), known)
        return [*(below * den + above * num).coeffs()]

    @cached_property
    def whole(self) -> tuple[int, ...]:
        """Of each delay the whole samples."""
        return self.samples({})

    def samples(self, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        """Of each delay the whole samples."""
        return self.plant.samples(self.T, known)

    @cached_property
    def is_of_numbers(self) -> bool:
        """Whether no symbol stands in the plant nor in the period."""
        plant = self.plant
        every = (self.T, *plant.denominator, *(x for lag, N in plant.terms for x in (lag, *N)))
        return not any(x.free_symbols for x in every)

    def exact(self) -> list[Element] | None:
        """The same times a number that is not 0; None where the plant holds pi."""
        return None if self._exact is None else self._exact[1]

    def is_zero(self, x: Element) -> bool:
        """Whether a coefficient is 0, exactly."""
        assert self._exact
        return self._exact[0].is_zero(x)

    @cached_property
    def _exact(self) -> tuple[Exponentials, list[Element]] | None:
        lags = [lag - n * self.T for (lag, _), n in zip(self.plant.terms, self.whole, strict=True)]
        if not all(x.is_Rational for x in (self.T, *lags, *self.plant.denominator)):
            return None
        own = tuple((lag, ell, N) for lag, ell, (_, N) in zip(lags, self.whole, self.plant.terms, strict=True))
        return residues(self.plant.denominator, own, self.T, (self.above, self.below))


def pulse(plant: Plant, period: Expr, whole: Sequence[int], known: Mapping[Expr, Ball]) -> tuple[Any, Any]:
    """Denominator and numerator of the pulse transfer function, polynomials in w, in balls."""
    lead, T = expression_ball(plant.denominator[-1], known), expression_ball(period, known)
    Q = [expression_ball(x, known) / lead for x in plant.denominator]
    states = States(Q)
    n, Phi = len(Q) - 1, (states.A * T).exp()
    den, total = _reversed_characteristic(Phi), arb_poly([])
    for (lag, above), ell in zip(plant.terms, whole, strict=True):
        N = [expression_ball(x, known) / lead for x in above]
        N += [arb(0)] * (n + 1 - len(N))
        C = states.row([x - N[n] * q for x, q in zip(N, Q, strict=True)][:n])
        late = expression_ball(lag - ell * period, known)
        own = arb_poly([arb(0), N[n]]) * den + _response(Phi, states.held(T - late), C, den)
        if not late.is_zero():
            before = (states.A * (T - late)).exp() * states.held(late)
            own += arb_poly([arb(0), arb(1)]) * _response(Phi, before, C, den)
        total += arb_poly([arb(0)] * ell + [arb(1)]) * own
    return den, total


def _floor(ratio: Expr, known: Mapping[Expr, Ball]) -> int:
    """The whole part of a number."""

    def whole(_: int) -> int | None:
        found = expression_ball(ratio, known).floor().unique_fmpz()
        return None if found is None else int(found)

    if ratio.is_Rational:
        return int(ratio.p // ratio.q)
    found = at_rising_precision(whole)
    if found is None:
        raise UndecidedError("whether a delay is a whole number of samples")
    return found


def _reversed_characteristic(M: Any) -> Any:
    """|1 - w M|."""
    return arb_poly(M.charpoly().coeffs()[::-1])


def _response(Phi: Any, start: Any, C: Any, den: Any) -> Any:
    """w C adj(1 - w Phi) start: |1 - w (Phi - start C)| is the denominator and that."""
    return _reversed_characteristic(Phi - start * C) - den
