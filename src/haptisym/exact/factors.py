"""Irreducible real functions of omega with certified zeros: polynomials, and the analytic functions that delays bring.

A real function is taken apart into irreducible factors. Different factors vanish at different frequencies (for
polynomials always, for analytic functions except by coincidence) and each has only simple zeros or such tangencies as
cannot be told from simple pairs. A factor knows all its zeros in an interval, its order at a given number, and its sign.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, reduce
from itertools import pairwise
from typing import Any, TypeAlias

import flint
from flint import acb_poly, arb, arb_poly, arb_series, fmpq, fmpq_poly, fmpz_poly
from sympy import Expr, Integer, Symbol, pi

from haptisym.errors import UndecidedError
from haptisym.symbols import omega

from .reals import Ball, RealNumber, expression_ball
from .rings import Polynomial, PolynomialRing, RationalFunction

MOST_BITS = 1 << 13
"""The precision at which a question about an analytic function is given up as undecided."""
_TAYLOR_ORDER = 6
_MOST_BITS_EXACT = 1 << 20  # polynomials are always decided; this only bounds a mistake of ours


def rounded_up(bits: int) -> int:
    """The next power of two, at least 128: so that questions of about the same precision share one isolation."""
    return max(128, 1 << (bits - 1).bit_length())


def _around(low: Expr, high: Expr) -> tuple[Ball, Ball]:
    """Dyadic numbers that enclose an interval."""
    with flint.ctx.workprec(128):
        return expression_ball(low).lower(), expression_ball(high).upper()


def _is_clear(ball: Ball) -> bool:
    """Whether a ball lies on one side of 0; not so for one that is not a number, as a logarithm over 0."""
    return bool(ball > 0 or ball < 0)


class Factor(ABC):
    """An irreducible real function of omega."""

    @abstractmethod
    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        """All zeros strictly between two numbers, and perhaps others outside; a tangency that stays undecided among them."""

    @abstractmethod
    def order_at(self, place: Expr) -> Any:
        """The order of the zero at an exact number, counted in omega; 0 if it is none; a fraction for powers of omega at 0."""

    @abstractmethod
    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies, at the current working precision."""

    def steady_sign(self, low: Expr, high: Expr) -> int:
        """The sign all over a closed interval where a quick look shows that there is no zero on it; 0 where it does not."""
        return 0

    def multiplicity(self, zero: RealNumber) -> int:
        """The order of one of the zeros; that of a tangency that stayed undecided is taken as 2."""
        return 2 if isinstance(zero, Undecided) else 1

    def sign_at(self, place: Callable[[int], Ball], most_bits: int = MOST_BITS) -> int:
        """The sign at a number that is no zero, given as a function from bits to a ball; UndecidedError at the limit."""
        bits = 128
        while bits <= most_bits:
            with flint.ctx.workprec(bits):
                value = self.value(place(bits))
                if value > 0 or value < 0:
                    return 1 if value > 0 else -1
            bits *= 2
        raise UndecidedError(f"the sign of a function at omega = {float(place(64).mid()):.17g} rad/s")


# Polynomials


@dataclass(frozen=True)
class PolynomialFactor(Factor):
    """An irreducible polynomial in omega^step: its coefficients, ascending, are polynomials in pi over the integers.

    ``step`` is 2 (the variable is then W = omega^2) but for factors of functions in which odd powers meet sines.
    """

    coefficients: tuple[tuple[int, ...], ...]
    step: int = 2
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((self.coefficients, self.step)))

    def __hash__(self) -> int:
        return self._hash

    @property
    def degree(self) -> int:
        return len(self.coefficients) - 1

    @property
    def is_rational(self) -> bool:
        return all(len(c) == 1 for c in self.coefficients)

    def value(self, x: Ball) -> Ball:
        return _at_precision(self, flint.ctx.prec)[0](x**self.step)

    def taylor(self, x: Ball, order: int) -> Ball:
        """A ball around the Taylor coefficient of order 0 or 1 about every point of a ball of frequencies."""
        if order == 0:
            return self.value(x)
        return _at_precision(self, flint.ctx.prec)[1](x**self.step) * self.step * x ** (self.step - 1)

    def steady_sign(self, low: Expr, high: Expr) -> int:
        if not self.is_rational:
            return 0
        moved = self._moved(*_around(low, high))
        signs = {c > 0 for c in moved if c}
        # the first coefficient belongs to the high end, the last to the low end
        return 0 if len(signs) > 1 or not moved[0] or not moved[-1] else 1 if signs.pop() else -1

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        if self.is_rational and self.degree > 1:
            start, end = _around(low, high)
            signs = [c > 0 for c in self._moved(start, end) if c]
            changes = sum(a != b for a, b in pairwise(signs))
            if changes < 2:  # Descartes' bound, which is then the number
                return [Zero(self, start, end)] * changes
        return list(self.positive_roots())

    def positive_roots(self) -> list[Root]:
        """All positive zeros, ascending."""
        return [Root(self, i) for i in range(len(_roots(self, 128)))]

    def _moved(self, low: Ball, high: Ball) -> list[fmpq]:
        """The coefficients of p(x) (1 + t)^n at x = low + (high - low)/(1 + t), which maps t > 0 to what is in between."""
        start, end = (x.fmpq() ** self.step for x in (low, high))
        moved = fmpq_poly([c[0] for c in self.coefficients])(fmpq_poly([start, end - start]))
        row = [moved[n] for n in range(self.degree, -1, -1)]
        turned = fmpq_poly(row)(fmpq_poly([1, 1]))
        return [turned[n] for n in range(self.degree + 1)]

    def order_at(self, place: Expr) -> int:
        # only a linear factor vanishes at a number rational in pi, and none does at 0: powers of omega are apart
        if self.degree > 1 or place == 0:
            return 0
        if self.is_rational and place.is_Rational:
            return int(self.coefficients[0][0] + self.coefficients[1][0] * place**self.step == 0)
        ring = PolynomialRing(omega)
        x = ring.generators[pi]
        low, high = (sum((n * x**i for i, n in enumerate(c)), ring.constant(0)) for c in self.coefficients)
        square = ring.convert(place) ** self.step
        return int((low * square.denominator + high * square.numerator).is_zero())

    def isolated(self, bits: int) -> tuple[Ball, ...] | None:
        """Balls around all positive roots, ascending; None if that takes more precision than the current one."""
        if self.degree == 1:
            low, high = (fmpz_poly(list(c))(arb.pi()) for c in self.coefficients)
            return _positive([-low / high])
        if self.is_rational:
            if len({c[0] > 0 for c in self.coefficients if c[0]}) == 1:
                return ()  # Descartes: without a change of sign there is no positive root
            every = fmpz_poly([c[0] for c in self.coefficients]).complex_roots()
            return _positive([root.real for root, _ in every if root.imag.is_zero()])
        try:
            isolated = _real_ones(acb_poly(_at_precision(self, bits)[0]).roots(maxprec=4 * bits))
        except ValueError:
            return None
        polynomial, slope = _at_precision(self, bits)
        return _positive([tightened(x.lower(), x.upper(), bits, polynomial, slope) for x in isolated])


def polynomial_factors(coefficients: list[fmpq]) -> tuple[int, int, list[tuple[PolynomialFactor, int]]]:
    """Sign, power of omega and irreducible factors of a polynomial in omega, given ascending: in omega^2 where it is even."""
    lowest = next(n for n, c in enumerate(coefficients) if c)
    rest, step = coefficients[lowest:], 1
    if not any(rest[1::2]):
        rest, step = rest[::2], 2
    number, factors = fmpq_poly(rest).factor()
    found = [(PolynomialFactor(tuple((int(c.p),) for c in f.coeffs()), step), n) for f, n in factors]
    return (1 if number > 0 else -1), lowest, found


@lru_cache(maxsize=1024)
def _at_precision(factor: PolynomialFactor, bits: int) -> tuple[arb_poly, arb_poly]:
    """The polynomial in omega^step with balls for coefficients, and its derivative."""
    with flint.ctx.workprec(bits):
        polynomial = arb_poly([fmpz_poly(list(c))(arb.pi()) for c in factor.coefficients])
        return polynomial, polynomial.derivative()


@lru_cache(maxsize=1024)
def _roots(factor: PolynomialFactor, bits: int) -> tuple[Ball, ...]:
    """Balls around all positive roots in omega^step, ascending, computed with at least that many bits."""
    while bits < _MOST_BITS_EXACT:
        with flint.ctx.workprec(bits):
            found = factor.isolated(bits)
        if found is not None:
            return found
        bits *= 2
    raise UndecidedError("the roots of a polynomial were not told apart at the precision limit")


def _real_ones(isolated: Iterable[Ball]) -> list[Ball]:
    """Of isolated roots of a real polynomial, the real ones: those whose mirror image meets no other root."""
    roots = list(isolated)
    alone = [
        z
        for i, z in enumerate(roots)
        if not any(_meet(z.conjugate(), other) for j, other in enumerate(roots) if j != i)
    ]
    return [z.real for z in alone if z.imag.contains(0)]


def _meet(z: Ball, other: Ball) -> bool:
    return bool(z.real.overlaps(other.real) and z.imag.overlaps(other.imag))


def tightened(low: Ball, high: Ball, bits: int, value: Callable[[Ball], Ball], slope: Callable[[Ball], Ball]) -> Ball:
    """The enclosure of the one simple zero between two exact numbers, as tight as that many bits allow.

    Interval Newton where the slope is clear of 0, bisection elsewhere. The ends stay exact numbers: a ball around them
    reaches a little beyond, where a twin of the zero may lie.
    """
    left = value(low)
    while True:
        box, middle = low.union(high), ((low + high) / 2).mid()
        at, steep = value(middle), slope(box)
        floor = not _is_clear(at) or not _is_clear(left)  # the working precision shows no more
        before = high - low
        if _is_clear(steep):
            step = middle - at / steep
            low, high = low.max(step.lower()), high.min(step.upper())
        if box.rel_accuracy_bits() >= bits - 24 or (floor and not (high - low) < before / 2):
            return low.union(high)
        if not floor and not (high - low) < before / 2 and low < middle < high:
            low, high = (middle, high) if (at > 0) == (left > 0) else (low, middle)


def _positive(roots: Iterable[Ball]) -> tuple[Ball, ...] | None:
    """The positive ones in order; None if two of them, or one and zero, cannot be told apart at this precision."""
    ordered = sorted(roots, key=lambda ball: ball.mid())
    if not all(_is_clear(ball) for ball in ordered) or any(a.overlaps(b) for a, b in pairwise(ordered)):
        return None
    return tuple(ball for ball in ordered if ball > 0)


@dataclass(frozen=True)
class Root(RealNumber):
    """The frequency at which a polynomial factor vanishes, by its ``index``-th positive root in omega^step."""

    factor: PolynomialFactor
    index: int

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            root = _roots(self.factor, rounded_up(bits))[self.index]
            return root.sqrt() if self.factor.step == 2 else root


# Analytic functions


@dataclass(frozen=True)
class Term:
    """Part of an analytic factor: a polynomial in omega times sines, cosines and powers.

    ``coefficients``: of ascending powers of omega, each a polynomial in pi over the integers. ``turns``: the power of the
    half angle's sine, for each angle (the cosine has what is missing to the factor's degree). ``powers``: of each omega^alpha.
    """

    turns: tuple[int, ...]
    powers: tuple[int, ...]
    coefficients: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class AnalyticFactor(Factor):
    """sum of p(omega) prod sin(a_i/2)^k_i cos(a_i/2)^(n_i - k_i) prod omega^(alpha l): entire for omega > 0, no divisions.

    ``rates``: d a_i/d omega of each angle, rad per rad/s, or ``(angle, None)`` for a constant angle. ``degrees``: the n_i.
    """

    terms: tuple[Term, ...]
    rates: tuple[tuple[Expr, bool], ...]
    degrees: tuple[int, ...]
    orders: tuple[Expr, ...]
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((self.terms, self.degrees)))

    def __hash__(self) -> int:
        return self._hash

    def value(self, x: Ball) -> Ball:
        return _compiled(self, flint.ctx.prec).value(x)

    def taylor(self, x: Ball, order: int) -> Ball:
        """A ball around the Taylor coefficient of that order about every point of a ball of frequencies."""
        return self.series(x, order + 1)[order] if order else self.value(x)

    def series(self, x: Ball, length: int) -> arb_series:
        """Taylor coefficients of the function about every point of a ball: value, slope, half curvature, ..."""
        return _compiled(self, flint.ctx.prec).series(x, length)

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies."""
        return _compiled(self, flint.ctx.prec).over(box)

    def steady_sign(self, low: Expr, high: Expr) -> int:
        with flint.ctx.workprec(128):
            box = arb.union(*_around(low, high))
            value = self.value(box)
            if not _is_clear(value):
                value = self.over(box)[0]
            return 1 if value > 0 else -1 if value < 0 else 0

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        return _isolated(self, self._edge(low, above=True), self._edge(high, above=False))

    def _edge(self, place: Expr, *, above: bool) -> Ball:
        """A dyadic number where a search may start or stop, with no zero between it and the place but at the place itself."""
        if place == 0 and self.orders:
            return _clear_of_zero_with_powers(self)
        order = self.order_at(place)
        if order or place == 0:  # even functions have slope 0 at 0: keep away from it
            return _clear_of(self, place, order, above=above)
        with flint.ctx.workprec(128):
            ball = expression_ball(place)
            return ball.lower() if above else ball.upper()

    def order_at(self, place: Expr) -> Any:
        return _order_at(self, place)


@lru_cache(maxsize=1024)
def _order_at(factor: AnalyticFactor, place: Expr) -> Any:
    if place == 0 and factor.orders:
        return min((_exponent(factor, powers, part) for powers, part in _by_powers(factor).items()), key=float)
    exact = _exact_waves(factor, place)
    if exact is None:
        factor.sign_at(lambda bits: expression_ball(place))
        return 0
    if not factor.orders:
        with flint.ctx.workprec(128):
            if _is_clear(factor.value(expression_ball(place))):
                return 0
    return _exact_order(factor, place, exact)


_Number: TypeAlias = Any  # flint.arb or flint.arb_series: both know sin_cos, log and exp
_Key: TypeAlias = tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Compiled:
    """An analytic function with balls of one precision for its constants: waves of constant angles are among the coefficients.

    ``rates``, ``degrees``: of the half angles that turn. ``terms``: sine powers, powers of omega^alpha, polynomial.
    """

    rates: tuple[Ball, ...]
    degrees: tuple[int, ...]
    exponents: tuple[Ball, ...]
    terms: tuple[tuple[tuple[int, ...], tuple[int, ...], arb_poly], ...]

    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies."""
        return self.total(x, [p(x) for _, _, p in self.terms])

    def series(self, x: Ball, length: int) -> arb_series:
        """Taylor coefficients of the function about every point of a ball: value, slope, half curvature, ..."""
        cap, flint.ctx.cap = flint.ctx.cap, length  # FLINT cuts series at this length, and what is cut off reads as 0
        try:
            polynomials = [arb_series([p(x) for p in row], length) for row in _derivatives(self, length)]
            return self.total(arb_series([x, 1], length), polynomials)
        finally:
            flint.ctx.cap = cap

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies.

        Taylor's theorem about the middle m, f(m + h) = c_0 + c_1 h + ... + c(xi) h^n, with the last coefficient enclosed over the
        whole ball: tight as soon as the ball is shorter than what the function does, however much its terms cancel.
        """
        about = self.series(box.mid(), _TAYLOR_ORDER)
        last = self.series(box, _TAYLOR_ORDER + 1)[_TAYLOR_ORDER]
        taylor = arb_poly([*(about[i] for i in range(_TAYLOR_ORDER)), last])
        slope = taylor.derivative()
        h = box - box.mid()
        return taylor(h), slope(h), slope.derivative()(h) / 2

    def total(self, at: _Number, polynomials: Sequence[_Number]) -> _Number:
        """The sum of the terms, given the value (or the series) of each one's polynomial."""
        waves = [_waves(rate * at, degree) for rate, degree in zip(self.rates, self.degrees, strict=True)]
        highest = [max(powers[i] for _, powers, _ in self.terms) for i in range(len(self.exponents))]
        roots = [_powers((at.log() * a).exp(), most) for a, most in zip(self.exponents, highest, strict=True)]
        total: _Number = 0
        for (turns, powers, _), polynomial in zip(self.terms, polynomials, strict=True):
            term = polynomial
            for wave, k in zip(waves, turns, strict=True):
                term = term * wave[k]
            for root, n in zip(roots, powers, strict=True):
                if n:
                    term = term * root[n]
            total = term + total
        return total


def _waves(half: _Number, degree: int) -> list[_Number]:
    """sin^k cos^(degree - k) of a half angle, for each k."""
    sine, cosine = half.sin_cos()
    sines, cosines = _powers(sine, degree), _powers(cosine, degree)
    return [cosines[degree], *(sines[k] * cosines[degree - k] for k in range(1, degree)), sines[degree]][: degree + 1]


def _powers(x: _Number, most: int) -> list[_Number]:
    found = [x**0]
    for _ in range(most):
        found.append(found[-1] * x)
    return found


@lru_cache(maxsize=512)
def _compiled(factor: AnalyticFactor, bits: int) -> Compiled:
    with flint.ctx.workprec(bits):
        halves = [expression_ball(rate) / 2 for rate, _ in factor.rates]
        turning = [i for i, (_, constant) in enumerate(factor.rates) if not constant]
        fixed = {i: _waves(halves[i], factor.degrees[i]) for i, (_, constant) in enumerate(factor.rates) if constant}
        terms: dict[_Key, arb_poly] = {}
        for term in factor.terms:
            polynomial = arb_poly([fmpz_poly(list(c))(arb.pi()) for c in term.coefficients])
            for i, wave in fixed.items():
                polynomial = polynomial * wave[term.turns[i]]
            key = tuple(term.turns[i] for i in turning), term.powers
            terms[key] = terms[key] + polynomial if key in terms else polynomial
        return Compiled(
            tuple(halves[i] for i in turning),
            tuple(factor.degrees[i] for i in turning),
            tuple(expression_ball(order) for order in factor.orders),
            tuple((*key, polynomial) for key, polynomial in terms.items()),
        )


@lru_cache(maxsize=512)
def _derivatives(compiled: Compiled, length: int) -> list[list[arb_poly]]:
    """For the polynomial p of each term p, p', p''/2, ...: its Taylor coefficients as functions of where."""
    rows = [[p] for _, _, p in compiled.terms]
    for row in rows:
        for k in range(1, length):
            row.append(row[-1].derivative() * (arb(1) / k))
    return rows


@dataclass(frozen=True)
class Zero(RealNumber):
    """A simple zero of a factor, alone between ``low`` and ``high``, where the signs differ."""

    factor: PolynomialFactor | AnalyticFactor
    low: Ball = field(compare=False)
    high: Ball = field(compare=False)
    index: int = 0
    derivative: int = 0
    """0 for a zero of the function itself, 1 for one of its slope."""

    def ball(self, bits: int) -> Ball:
        return _refined(self, self.low, self.high, rounded_up(bits))


@dataclass(frozen=True)
class Undecided(RealNumber):
    """A frequency near which a function has a double zero, or two, or none: not decided at the precision limit."""

    factor: AnalyticFactor
    near: Zero

    def ball(self, bits: int) -> Ball:
        return self.near.ball(bits)


@lru_cache(maxsize=4096)
def _refined(zero: Zero, low: Ball, high: Ball, bits: int) -> Ball:
    """An enclosure as tight as that many bits allow: interval Newton, with bisection where the slope is not clear of 0."""
    k = zero.derivative

    def value(x: Ball) -> Ball:
        return zero.factor.taylor(x, k)

    def slope(x: Ball) -> Ball:
        return (k + 1) * zero.factor.taylor(x, k + 1)

    with flint.ctx.workprec(bits):
        if bits > 128:
            rough = _refined(zero, low, high, bits // 2)
            closer = low.max(rough.lower()), high.min(rough.upper())
            if all(_is_clear(value(x)) for x in closer):
                low, high = closer
        return tightened(low, high, bits, value, slope)


def _isolated(factor: AnalyticFactor, low: Ball, high: Ball) -> list[RealNumber]:
    """All zeros between two dyadic numbers: subdivision until each piece is clear, monotone or bent one way only."""
    found: list[RealNumber] = []
    pieces = [(low, high)] if low < high else []
    while pieces:
        a, b = pieces.pop()
        answer = _judged(factor, a, b, len(found))
        if answer is None:
            middle = _cut(factor, a, b)
            pieces += [(middle, b), (a, middle)]
        else:
            found += answer
    return found


def _judged(factor: AnalyticFactor, a: Ball, b: Ball, index: int) -> list[RealNumber] | None:
    """The zeros in a piece, if it is clear enough to tell."""
    with flint.ctx.workprec(128):
        box = a.union(b)
        value, slope, bend = factor.over(box)
        if _is_clear(value):
            return []
        if _is_clear(slope):
            return _between(factor, a, b, index)
        if _is_clear(bend):
            return _on_a_bend(factor, a, b, 1 if bend > 0 else -1, index)
        if (b - a) < abs(box.mid()) * arb(2) ** -60:
            raise UndecidedError(f"how often a function vanishes near omega = {float(box.mid()):.17g} rad/s")
    return None


def _sign(factor: AnalyticFactor, x: Ball, derivative: int = 0) -> int:
    """The sign of the function, or of its slope, at a dyadic number; UndecidedError if it stays open."""
    bits = 128
    while bits <= MOST_BITS:
        with flint.ctx.workprec(bits):
            value = factor.series(x, derivative + 1)[derivative]
            if value > 0 or value < 0:
                return 1 if value > 0 else -1
        bits *= 2
    raise UndecidedError(f"the sign of a function at omega = {float(x.mid()):.17g} rad/s")


def _between(factor: AnalyticFactor, a: Ball, b: Ball, index: int) -> list[RealNumber]:
    """On a monotone piece: one zero or none."""
    return [Zero(factor, a, b, index)] if _sign(factor, a) != _sign(factor, b) else []


def _on_a_bend(factor: AnalyticFactor, a: Ball, b: Ball, bend: int, index: int) -> list[RealNumber]:
    """On a piece that bends one way only: the extremum decides between no zero and two, or stays undecided."""
    left, right = _sign(factor, a), _sign(factor, b)
    if left != right:
        return [Zero(factor, a, b, index)]
    if left != bend or _sign(factor, a, 1) == _sign(factor, b, 1):
        return []
    extremum = Zero(factor, a, b, index, derivative=1)
    bits = 128
    while bits <= MOST_BITS:
        with flint.ctx.workprec(bits):
            at = extremum.ball(bits)
            value = factor.over(at)[0]
            if value > 0 or value < 0:
                if (1 if value > 0 else -1) == left:
                    return []
                return [Zero(factor, a, at.mid(), index), Zero(factor, at.mid(), b, index + 1)]
        bits *= 2
    return [Undecided(factor, extremum)]


def _cut(factor: AnalyticFactor, a: Ball, b: Ball) -> Ball:
    """A dyadic number a little off the middle of a piece, at which the function is not zero."""
    with flint.ctx.workprec(128):
        for share in (127, 131, 113, 149):
            cut = (a + (b - a) * share / 256).mid()
            value = factor.value(cut)
            if value > 0 or value < 0:
                return cut
        return (a + (b - a) * 127 / 256).mid()


def _clear_of(factor: AnalyticFactor, place: Expr, order: int, *, above: bool) -> Ball:
    """A dyadic number beside a zero of known order, with no other zero in between.

    f(x) = f_m(xi) (x - place)^m with f_m the m-th Taylor coefficient about some xi in between, because all lower ones
    vanish at the place: where the enclosure of f_m over the piece is clear of 0, there is no other zero.
    """
    with flint.ctx.workprec(128):
        centre, reach = expression_ball(place), arb(1) / 4
        for _ in range(200):
            end = (centre + (reach if above else -reach)).mid()
            piece = (centre.lower() if above else centre.upper()).union(end)
            if _is_clear(factor.series(piece, order + 1)[order]):
                return end
            reach = reach / 4
    raise UndecidedError(f"whether a function vanishes again near omega = {place} rad/s")


def _by_powers(factor: AnalyticFactor) -> dict[tuple[int, ...], AnalyticFactor]:
    """The factor as a sum of analytic functions, each times powers omega^alpha."""
    groups: dict[tuple[int, ...], list[Term]] = {}
    for term in factor.terms:
        groups.setdefault(term.powers, []).append(Term(term.turns, (), term.coefficients))
    return {powers: AnalyticFactor(tuple(terms), factor.rates, factor.degrees, ()) for powers, terms in groups.items()}


def _exponent(factor: AnalyticFactor, powers: tuple[int, ...], part: AnalyticFactor) -> Expr:
    """The exponent of omega with which a part begins at 0."""
    return sum((a * n for a, n in zip(factor.orders, powers, strict=True)), Integer(part.order_at(Integer(0))))


def _clear_of_zero_with_powers(factor: AnalyticFactor) -> Ball:
    """A dyadic number above 0, with no zero in between, for a function with powers omega^alpha.

    f = sum over l of omega^(alpha l) A_l with A_l analytic and of exact order m_l: divided by the lowest of all powers
    omega^(alpha l + m_l), what remains tends to a constant at 0, and is enclosed on (0, reach].
    """
    parts = _by_powers(factor)
    exponents = {powers: _exponent(factor, powers, part) for powers, part in parts.items()}
    lowest = min(exponents.values(), key=float)
    with flint.ctx.workprec(128):
        reach = arb(1) / 16
        for _ in range(200):
            piece = arb(0).union(reach)
            total = arb(0)
            for powers, part in parts.items():
                order = part.order_at(Integer(0))
                rise = expression_ball(exponents[powers] - lowest)
                factor_range = arb(1) if exponents[powers] == lowest else arb(0).union((rise * reach.log()).exp())
                total = total + factor_range * part.series(piece, order + 1)[order]
            if _is_clear(total):
                return reach
            reach = reach / 16
    raise UndecidedError("whether a function vanishes near omega = 0")


Wave: TypeAlias = tuple[int, int] | None


def _exact_waves(factor: AnalyticFactor, place: Expr) -> list[Wave] | None:
    """Cosine and sine of the half angles where all are 0 or +-1 (at multiples of a quarter turn); None if not.

    The entry of a constant angle is None: its cosine and sine stay symbols.
    """
    if place != 0 and (factor.orders or (place.is_Rational and any(rate.is_Rational for rate, _ in factor.rates))):
        return None  # a rational angle, but 0, is no part of a turn
    found: list[Wave] = []
    for rate, constant in factor.rates:
        quarters = Integer(0) if constant else rate * place / pi
        if not quarters.is_Integer:
            return None
        found.append(None if constant else ((1, 0), (0, 1), (-1, 0), (0, -1))[int(quarters) % 4])
    return found


def _exact_order(factor: AnalyticFactor, place: Expr, waves: list[Wave]) -> int:
    """The order of the zero at a place where the waves are known exactly: the first derivative that is not zero there."""
    names = [Symbol(f"{kind}{i}") for i in range(len(factor.rates)) for kind in ("cos", "sin")]
    ring = PolynomialRing(omega, functions=names)
    derivative = _in_waves(factor, ring)
    rates = [ring.convert(rate / 2) for rate, _ in factor.rates]
    common = reduce(lambda x, y: x * y, (rate.denominator for rate in rates), ring.constant(1))
    for order in range(_HIGHEST_ORDER):
        if not _at(ring, derivative, place, waves).is_zero:
            return order
        change = common * derivative.derivative(0)
        for i, (rate, (_, constant)) in enumerate(zip(rates, factor.rates, strict=True)):
            if not constant:
                cosine, sine = (ring.context.gens()[2 + 2 * i + n] for n in (0, 1))
                turned = cosine * derivative.derivative(3 + 2 * i) - sine * derivative.derivative(2 + 2 * i)
                change += rate.numerator * (common / rate.denominator) * turned
        derivative = change
    raise UndecidedError(f"the order of a zero at omega = {place} rad/s")


_HIGHEST_ORDER = 200


def _in_waves(factor: AnalyticFactor, ring: PolynomialRing) -> Polynomial:
    terms: dict[tuple[int, ...], int] = {}
    for term in factor.terms:
        waves = [n for k, degree in zip(term.turns, factor.degrees, strict=True) for n in (degree - k, k)]
        for power, row in enumerate(term.coefficients):
            for of_pi, value in enumerate(row):
                if value:
                    terms[(power, of_pi, *waves)] = value
    return ring.context.from_dict(terms)


def _at(ring: PolynomialRing, polynomial: Polynomial, place: Expr, waves: list[Wave]) -> RationalFunction:
    """The value at an exact place, a polynomial in pi (and the constant angles' waves)."""
    where, total = ring.convert(place), ring.zero
    for (power, of_pi, *turns), value in polynomial.to_dict().items():
        if power and place == 0:
            continue
        known, kept = value, [0, int(of_pi)]
        for wave, cosine, sine in zip(waves, turns[::2], turns[1::2], strict=True):
            kept += [int(cosine), int(sine)] if wave is None else [0, 0]
            known = known if wave is None else known * wave[0] ** int(cosine) * wave[1] ** int(sine)
        total = total + ring.function(ring.context.from_dict({tuple(kept): known})) * where ** int(power)
    return total
