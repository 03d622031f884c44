"""Sums of polynomials times sines, cosines and powers of omega: enclosures, beginnings at omega =
0, and the exact test whether such a sum, or its leading coefficient, is zero.

On s = j omega a delay tau brings an angle a = omega tau, and s^alpha brings omega^alpha and the
constant angle alpha pi/2. Such functions are quotients of polynomials in t = tan(a/2); multiplied
by powers of cos(a/2) the numerator becomes a ``WaveSum``,

    f(omega) = sum of p(omega) prod sin(a_i/2)^k_i cos(a_i/2)^(n_i - k_i) prod omega^(alpha l),

analytic for omega > 0, with exact coefficients.

*Enclosures.* Derivatives of such sums are sums of the same kind, with as many coefficients
(``Derivatives``), so that Taylor coefficients of any order are had in balls about every point of a
ball, and Taylor's theorem encloses value, slope and curvature.

*Beginnings at 0.* Gathered by powers, f = sum over l of omega^(alpha l) A_l with A_l analytic, and
f begins with the first term of that expansion that is not zero (``leading_term``). Where alpha is
rational, terms of different l meet at one exponent, and their coefficients may cancel: Re s^(2
alpha) is 0 for alpha = 1/2.

*The zero test.* Coefficients are sums of products of cosines and sines of rational parts of a turn,
which are algebraic, and of powers of pi, which is transcendental: it is decided whether such a
number is zero (``is_zero_number``).

Balls hold for every point that they were asked for, at the working precision. Where neither balls
nor exact numbers decide, the answer is None, or an UndecidedError.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, lru_cache, reduce
from heapq import heapify, heapreplace
from itertools import accumulate, islice, repeat
from math import factorial, lcm
from operator import add, mul
from typing import NamedTuple, TypeAlias

import flint
from flint import arb, arb_mat, arb_poly, fmpq, fmpq_poly, fmpz_poly
from sympy import Expr, Integer, Symbol, pi

from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import tick
from haptisym.kernel.enclosures import range_of
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, at_rising_precision, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, monomials, omega
from haptisym.kernel.zeros import is_clear

NOTHING, ONE = arb(0), arb(1)

Turns: TypeAlias = tuple[int, ...]
"""The exponents of the sines of some half angles; a cosine has the rest of its angle's degree."""
_Blocks: TypeAlias = Mapping[Turns, arb_mat]
"""For the turns of all angles but the last, a matrix of coefficients: a row for each exponent of
the last angle's sine, a column for each power of omega."""
Place: TypeAlias = tuple[Mapping[Turns, Ball], arb_mat, arb_mat]
"""What ``Derivatives.series`` needs of a ball of frequencies: the products of sines and cosines of
all half angles but the last, by turns; those of the last one, as a row; powers of omega, as a
column."""


class Derivatives:
    """A sum of polynomials times sines and cosines, and its derivatives of all orders, which have
    no more terms than the sum.

    d sin(a)^k cos(a)^(n - k) = (k sin(a)^(k - 1) cos(a)^(n - k + 1) - (n - k) sin(a)^(k + 1)
    cos(a)^(n - k - 1)) da.

    ``angles`` : rate and degree n of each half angle. ``width`` : how many powers of omega there
    are. ``terms`` : coefficients of ascending powers of omega, by turns.
    """

    def __init__(
        self, angles: Sequence[tuple[Ball, int]], width: int, terms: Mapping[Turns, Sequence[Ball]]
    ) -> None:
        *self._outer, (rate, degree) = angles
        self._turn, self._shift = _turning(rate, degree), _shift(width)
        # The last angle and omega are handled by products of matrices; only further angles need a
        # loop.
        entries: dict[Turns, list[Ball]] = {}
        for (*others, k), row in terms.items():
            block = entries.setdefault(tuple(others), [NOTHING] * (width * (degree + 1)))
            block[k * width : k * width + len(row)] = row
        self._known: list[_Blocks] = [
            {o: arb_mat(degree + 1, width, block) for o, block in entries.items()}
        ]

    def series(self, place: Place, start: int, stop: int) -> list[Ball]:
        """The Taylor coefficients of orders from ``start`` to before ``stop``."""
        outer, last, columns = place
        while len(self._known) < stop:
            self._known.append(self._derived(self._known[-1]))
        wanted = self._known[start:stop]
        if () in outer:
            derivatives = [(last * (blocks[()] * columns))[0, 0] for blocks in wanted]
        else:
            derivatives = []
            for blocks in wanted:
                total = NOTHING
                for turns, block in blocks.items():
                    total = total + outer[turns] * (last * (block * columns))[0, 0]
                derivatives.append(total)
        # 0! = 1! = 1: orders below 2 need no division.
        if stop <= 2:
            return derivatives
        return list(map(mul, derivatives, _shares(stop, flint.ctx.prec)[start:]))

    def _derived(self, blocks: _Blocks) -> _Blocks:
        """The coefficients of the derivative: by the product rule a term for omega and the last
        angle, and two for each other angle."""
        total: dict[Turns, arb_mat] = {}
        for others, block in blocks.items():
            tick()
            parts = [(others, block * self._shift + self._turn * block)]
            for i, (rate, degree) in enumerate(self._outer):
                k = others[i]
                if k:
                    parts.append(((*others[:i], k - 1, *others[i + 1 :]), block * (rate * k)))
                if k < degree:
                    parts.append(
                        ((*others[:i], k + 1, *others[i + 1 :]), block * (rate * (k - degree)))
                    )
            for turns, part in parts:
                total[turns] = total[turns] + part if turns in total else part
        return total


@lru_cache(maxsize=64)
def _shares(count: int, bits: int) -> list[Ball]:
    """Reciprocal factorials 1/0!, 1/1!, 1/2!, ..., which make derivatives Taylor coefficients."""
    with flint.ctx.workprec(bits):
        return [arb(1) / factorial(n) for n in range(count)]


@lru_cache(maxsize=64)
def _shift(width: int) -> arb_mat:
    """The matrix of d/d omega on coefficients of 1, omega, omega^2, ... in a row: of whole numbers,
    so that it is exact at any precision."""
    shift = arb_mat(width, width)
    for n in range(1, width):
        shift[n, n - 1] = n
    return shift


def _turning(rate: Ball, degree: int) -> arb_mat:
    """The matrix of d/d omega on coefficients of sin^k cos^(degree - k), k = 0 ... degree, of one
    half angle that turns at this rate."""
    turn = arb_mat(degree + 1, degree + 1)
    for k in range(degree):
        turn[k, k + 1] = rate * (k + 1)
        turn[k + 1, k] = rate * (k - degree)
    return turn


def powers_of(x: Ball, count: int) -> list[Ball]:
    """The powers 1, x, x^2, ..., ``count`` of them."""
    # The first one is the very object ``ONE``, by which ``_compiled`` knows a factor 1.
    return list(accumulate(repeat(x, count - 1), mul, initial=ONE))


def waves_of(half: Ball, degree: int) -> list[Ball]:
    """sin^k cos^(degree - k) of a half angle, k = 0 ... degree."""
    sine, cosine = half.sin_cos()
    if degree == 1:
        return [cosine, sine]
    if degree == 2:
        return [cosine**2, sine * cosine, sine**2]
    return list(map(mul, powers_of(sine, degree + 1), reversed(powers_of(cosine, degree + 1))))


def power_series(x: Ball, exponent: Ball, length: int) -> list[Ball]:
    """The first Taylor coefficients of x^exponent about every point of a ball x > 0."""
    # Each from the one before: binomial(e, n + 1) = binomial(e, n) (e - n)/(n + 1).
    row = [(x.log() * exponent).exp()]
    inverse = 1 / x if length > 1 else x
    for n in range(length - 1):
        row.append(row[-1] * ((exponent - n) / (n + 1)) * inverse)
    return row


def product(a: Sequence[Ball], b: Sequence[Ball], start: int = 0) -> list[Ball]:
    """The product of two Taylor series of one length, cut to that length; coefficients from order
    ``start`` on."""
    # The last coefficient alone is one scalar product, much less than a product of polynomials.
    if start == len(a) - 1:
        return [reduce(add, map(mul, a, reversed(b)))]
    full = arb_poly(a) * arb_poly(b)
    return [full[n] for n in range(start, len(a))]


# Of the expansions in ``over`` and ``ranges``: their remainders fall as the eighth power of the
# length of the ball.
_TAYLOR_ORDER = 8


class WaveTerm(NamedTuple):
    """A term of a ``WaveSum``: a polynomial in omega times sines, cosines and powers of omega.

    ``turns``: for each angle the exponent of its half angle's sine; the cosine has the rest of the
    sum's degree. ``powers``: for each order alpha the exponent of omega^alpha. ``coefficients``: of
    ascending powers of omega, each a polynomial in pi over the integers, ascending too.
    """

    turns: tuple[int, ...]
    powers: tuple[int, ...]
    coefficients: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class WaveSum:
    """sum of p(omega) prod sin(a_i/2)^k_i cos(a_i/2)^(n_i - k_i) prod omega^(alpha l): analytic for
    omega > 0, without divisions.

    ``rates``: of each angle d a_i/d omega, rad per rad/s, with False; of a constant angle the angle
    itself, rad, with True. ``degrees``: the n_i. ``orders``: the alpha.
    """

    terms: tuple[WaveTerm, ...]
    rates: tuple[tuple[Expr, bool], ...]
    degrees: tuple[int, ...]
    orders: tuple[Expr, ...]
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        # Sums are keys of caches that are asked at every evaluation: their hash is computed once.
        # It may leave out rates and orders, which equality compares.
        object.__setattr__(self, "_hash", hash((self.terms, self.degrees)))

    def __hash__(self) -> int:
        return self._hash

    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies, at the current working precision."""
        return _compiled(self, flint.ctx.prec).value(x)

    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around the Taylor coefficients of orders from ``start`` to before ``stop`` about
        every point of a ball."""
        return _compiled(self, flint.ctx.prec).series(x, start, stop)

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies."""
        return _compiled(self, flint.ctx.prec).over(box)

    def before(self, x: Ball, wanted: Sequence[tuple[tuple[int, ...], int]]) -> list[Ball]:
        """Taylor coefficients, about every point of a ball, of cofactors of powers of omega: for
        each pair in ``wanted``, of the cofactor of that product of omega^alpha, of that order."""
        return _compiled(self, flint.ctx.prec).before(x, wanted)

    def parts(self, x: Ball) -> list[Ball]:
        """Balls around the values, at a ball of frequencies, of the cofactor of each product of
        powers of omega."""
        return _compiled(self, flint.ctx.prec).parts(x)

    @property
    def begins_with_zero(self) -> bool:
        """Whether every term holds omega or the sine of an angle that turns, so that the sum is 0
        at omega = 0. For sums without powers of omega; False proves nothing."""
        turning = [i for i, (_, constant) in enumerate(self.rates) if not constant]
        still = (
            term.coefficients[0] for term in self.terms if not any(term.turns[i] for i in turning)
        )
        return not any(map(any, still))

    @property
    def shows_itself(self) -> bool:
        """Whether its coefficients prove that the function is not 0 everywhere; all orders of
        powers must be rational. False proves nothing.

        Sines and cosines of one angle that turns are linearly independent over all algebraic
        functions of omega. So are then all terms, where no two products of powers are a whole power
        of omega apart: one coefficient that is not 0 is enough.
        """
        if sum(not constant for _, constant in self.rates) > 1:
            return False
        # Exponents as whole multiples of 1/common: two differ by a whole power of omega exactly
        # where these multiples agree modulo common.
        common = lcm(*(int(order.q) for order in self.orders))
        units = [int(order.p) * (common // int(order.q)) for order in self.orders]
        products = {term.powers for term in self.terms}
        apart = {sum(map(mul, units, powers)) % common for powers in products}
        return len(apart) == len(products) and _compiled(self, flint.ctx.prec).has_clear_coefficient

    def ranges(self, box: Ball) -> dict[tuple[int, ...], Ball]:
        """Enclosures over a ball of frequencies of the cofactor of each product of powers of omega,
        by those powers: as ``parts``, but by Taylor's theorem, which is tight for a short ball."""
        return _compiled(self, flint.ctx.prec).ranges(box)


_Key: TypeAlias = tuple[Turns, tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class CompiledWaves:
    """A ``WaveSum`` with its constants as balls of one precision; sines and cosines of constant
    angles are multiplied into the coefficients.

    ``rates``, ``degrees``: of the half angles that turn. ``exponents``: the alpha. ``terms``: sine
    exponents, exponents of each omega^alpha, coefficients of ascending powers of omega.
    """

    rates: tuple[Ball, ...]
    degrees: tuple[int, ...]
    exponents: tuple[Ball, ...]
    terms: tuple[tuple[Turns, tuple[int, ...], Sequence[Ball]], ...]

    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies."""
        return self.taylor(x, 0)

    def taylor(self, x: Ball, order: int) -> Ball:
        """A ball around the Taylor coefficient of that order about every point of a ball of
        frequencies."""
        return self.series(x, order, order + 1)[0]

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Enclosures of value, slope and half curvature over a ball of frequencies.

        Taylor's theorem about the middle m, f(m + h) = c_0 + c_1 h + ... + c(xi) h^n, with the last
        coefficient enclosed over the whole ball: tight as soon as the ball is shorter than what the
        function does, however much its terms cancel.
        """
        middle, reach = box.mid(), powers_of(box.rad(), _TAYLOR_ORDER + 1)
        row = [*self.series(middle, 0, _TAYLOR_ORDER), self.taylor(box, _TAYLOR_ORDER)]
        slopes = [n * c for n, c in enumerate(row)][1:]
        bends = [n * c / 2 for n, c in enumerate(slopes)][1:]
        return range_of(row, reach), range_of(slopes, reach), range_of(bends, reach)

    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around the Taylor coefficients of orders from ``start`` to before ``stop`` about
        every point of a ball."""
        tick()
        place, total = self._place(x), list[Ball]()
        for powers, sums in self._sums.items():
            if any(powers):
                # All lower orders go into a coefficient of a product.
                exponent = reduce(add, map(mul, self.exponents, powers))
                part = product(sums.series(place, 0, stop), power_series(x, exponent, stop), start)
            else:
                part = sums.series(place, start, stop)
            total = list(map(add, total, part)) if total else part
        return total

    def before(self, x: Ball, wanted: Sequence[tuple[tuple[int, ...], int]]) -> list[Ball]:
        """Taylor coefficients of cofactors of powers of omega, as ``WaveSum.before``."""
        place = self._place(x)
        return [self._sums[powers].series(place, order, order + 1)[0] for powers, order in wanted]

    def parts(self, x: Ball) -> list[Ball]:
        """Balls around the values of the cofactors of powers of omega, as ``WaveSum.parts``."""
        place = self._place(x)
        return [sums.series(place, 0, 1)[0] for sums in self._sums.values()]

    def ranges(self, box: Ball) -> dict[tuple[int, ...], Ball]:
        """Enclosures of the cofactors of powers of omega over a ball of frequencies, as ``over``
        gives them of the whole sum."""
        n, reach = _TAYLOR_ORDER, powers_of(box.rad(), _TAYLOR_ORDER + 1)
        at, around = self._place(box.mid()), self._place(box)
        return {
            powers: range_of([*sums.series(at, 0, n), *sums.series(around, n, n + 1)], reach)
            for powers, sums in self._sums.items()
        }

    @property
    def has_clear_coefficient(self) -> bool:
        """Whether one of the coefficients is known not to be 0."""
        return any(x > 0 or x < 0 for _, _, row in self.terms for x in row)

    @cached_property
    def _angles(self) -> list[tuple[Ball, int]]:
        """Rate and degree of the half angles that turn; one that stands still where there is none,
        as ``Derivatives`` needs a last angle."""
        return list(zip(self.rates, self.degrees, strict=True)) or [(arb(0), 0)]

    def _place(self, x: Ball) -> Place:
        """Sines, cosines and powers of omega at a ball of frequencies, computed once for all orders
        and all powers."""
        *others, last = [waves_of(rate * x, degree) for rate, degree in self._angles]
        outer: dict[Turns, Ball] = {(): ONE}
        for waves in others:
            outer = {
                (*turns, k): known * wave
                for turns, known in outer.items()
                for k, wave in enumerate(waves)
            }
        return (
            outer,
            arb_mat(1, len(last), last),
            arb_mat(self._width, 1, powers_of(x, self._width)),
        )

    @cached_property
    def _width(self) -> int:
        return max([1, *(len(row) for _, _, row in self.terms)])

    @cached_property
    def _sums(self) -> Mapping[tuple[int, ...], Derivatives]:
        """The cofactor of each product of powers of omega, by its exponents."""
        groups: dict[tuple[int, ...], dict[Turns, Sequence[Ball]]] = {}
        for turns, powers, row in self.terms:
            groups.setdefault(powers, {})[turns or (0,)] = row
        return {
            powers: Derivatives(self._angles, self._width, terms)
            for powers, terms in groups.items()
        }


@lru_cache(maxsize=512)
def _compiled(waves: WaveSum, bits: int) -> CompiledWaves:
    """A sum with balls of that precision in place of its exact numbers.

    What does not depend on omega, pi and the waves of constant angles, is multiplied once, here.
    """
    with flint.ctx.workprec(bits):
        halves = [expression_ball(rate) / 2 for rate, _ in waves.rates]
        turning = [i for i, (_, constant) in enumerate(waves.rates) if not constant]
        fixed = [
            (i, waves_of(halves[i], waves.degrees[i]))
            for i, (_, constant) in enumerate(waves.rates)
            if constant
        ]
        pis = powers_of(arb.pi(), max([len(c) for term in waves.terms for c in term.coefficients]))
        units: dict[Turns, list[Ball]] = {(): pis}
        for _, wave in fixed:  # powers of pi times the waves of all constant angles
            units = {
                (*known, k): [x * w for x in row]
                for known, row in units.items()
                for k, w in enumerate(wave)
            }
        terms: dict[_Key, list[Ball]] = {}
        for turns, powers, coefficients in waves.terms:
            constants = units[tuple([turns[i] for i, _ in fixed])]
            key = tuple([turns[i] for i in turning]) if fixed else turns
            row = terms.setdefault((key, powers), [])
            row += [NOTHING] * (len(coefficients) - len(row))
            for n, c in enumerate(coefficients):
                for whole, unit in zip(c, constants):  # noqa: B905 - not all have all powers of pi
                    if whole:
                        # Without constant angles each key occurs once, and the power pi^0 comes
                        # first: a rational coefficient is then exact, whatever the precision.
                        row[n] = row[n] + unit * whole if fixed or unit is not ONE else arb(whole)
        return CompiledWaves(
            tuple(halves[i] for i in turning),
            tuple(waves.degrees[i] for i in turning),
            tuple(expression_ball(order) for order in waves.orders),
            tuple((*key, row) for key, row in terms.items()),
        )


Wave: TypeAlias = tuple[int, int] | None
"""Cosine and sine of a half angle up to a common factor > 0; None for a constant angle, whose
cosine and sine stay symbols."""
# At multiples of an eighth of a turn; (1, 1) leaves out sqrt(2)/2, so that all are whole numbers.
_EIGHTHS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def exact_waves(f: WaveSum, place: Expr) -> list[Wave] | None:
    """Cosine and sine of each half angle at an exact frequency, up to a factor > 0, if all half
    angles that turn are at multiples of an eighth of a turn; None if one is at another angle.

    A sum is homogeneous in cosine and sine of each angle, so that a common factor of both scales
    the function and does not move its zeros.
    """
    if place != 0 and place.is_Rational and any(rate.is_Rational for rate, _ in f.rates):
        return None  # a rational angle other than 0 is no rational part of a turn
    waves: list[Wave] = []
    for rate, constant in f.rates:
        eighths = Integer(0) if constant else 2 * rate * place / pi
        if not eighths.is_Integer:
            return None
        waves.append(None if constant else _EIGHTHS[int(eighths) % 8])
    return waves


def taylor_coefficients(f: WaveSum, place: Expr, waves: list[Wave]) -> Iterator[RationalFunction]:
    """The Taylor coefficients at a frequency ``place`` where the waves are known exactly, all times
    one and the same number that is not 0 and is not given.

    Each is a polynomial in the cosines and sines of the constant half angles, in this order from
    the third variable of its ring on, over a polynomial in pi.
    """
    names = [Symbol(f"{kind}{i}") for i in range(len(f.rates)) for kind in ("cos", "sin")]
    ring = PolynomialRing(omega, functions=names)
    derivative = _in_waves(f, ring)
    rates = [ring.convert(rate / 2) for rate, _ in f.rates]
    # Derivatives are multiplied by the rates' common denominator, so that they stay polynomials;
    # ``scale`` is its power times the factorial.
    common = reduce(lambda x, y: x * y, (rate.denominator for rate in rates), ring.constant(1))
    scale, order = ring.one, 0
    while True:
        yield _at(ring, derivative, place, waves) / scale
        change = common * derivative.derivative(0)
        for i, (rate, (_, constant)) in enumerate(zip(rates, f.rates, strict=True)):
            if not constant:
                # The chain rule: d sin = cos da, d cos = -sin da.
                cosine, sine = (ring.context.gens()[2 + 2 * i + n] for n in (0, 1))
                by_cosine, by_sine = (derivative.derivative(2 + 2 * i + n) for n in (0, 1))
                turned = cosine * by_sine - sine * by_cosine
                change += rate.numerator * (common / rate.denominator) * turned
        derivative, order = change, order + 1
        scale = scale * ring.function(common * order)


def order_at_0(f: WaveSum) -> int | None:
    """The order of the zero at omega = 0, exact, for sums whose angles all turn at rational rates;
    None where one does not, or where the first 128 orders vanish.

    The cosines of half angles are 1 at omega = 0. Divided by their powers the sum becomes one of
    polynomials times powers of tangents, which has a zero of the same order.
    """
    if not all(rate.is_Rational and not constant for rate, constant in f.rates):
        return None
    for length in (8, 32, 128):
        tangents = [
            _tangent_powers(fmpq(int(r.p), 2 * int(r.q)), n, length)
            for (r, _), n in zip(f.rates, f.degrees, strict=True)
        ]
        in_pi: dict[int, fmpq_poly] = {}
        for term in f.terms:
            waves = reduce(
                lambda x, y: x.mul_low(y, length),
                (x[k] for x, k in zip(tangents, term.turns, strict=True)),
                _ONE,
            )
            for i in range(max(map(len, term.coefficients))):
                row = fmpq_poly([c[i] if i < len(c) else 0 for c in term.coefficients])
                in_pi[i] = in_pi.get(i, _NOTHING) + row.mul_low(waves, length)
        # pi is transcendental: only what is zero before each of its powers is zero
        orders = [n for total in in_pi.values() for n, c in enumerate(total.coeffs()) if c]
        if orders:
            return min(orders)
    return None


_NOTHING, _ONE = fmpq_poly([0]), fmpq_poly([1])


def _tangent_powers(rate: fmpq, most: int, length: int) -> list[fmpq_poly]:
    """tan(rate omega)^k for k = 0, 1, ... ``most``, as Taylor polynomials at 0 with that many
    coefficients."""
    tangent = fmpq_poly([c * rate**n for n, c in enumerate(_tangent(length))])
    return list(accumulate(repeat(tangent, most), lambda x, y: x.mul_low(y, length), initial=_ONE))


@lru_cache(maxsize=8)
def _tangent(length: int) -> list[fmpq]:
    """The Taylor coefficients of the tangent at 0: t' = 1 + t^2."""
    found = [fmpq(0)]
    for n in range(1, length):
        square = sum((found[i] * found[n - 1 - i] for i in range(n)), fmpq(int(n == 1)))
        found.append(square / n)
    return found


def _in_waves(f: WaveSum, ring: PolynomialRing) -> Polynomial:
    """A sum without powers of omega as a polynomial of the ring ``omega, pi, cos, sin, cos, sin,
    ...``."""
    terms: dict[tuple[int, ...], int] = {}
    for term in f.terms:
        waves = [
            n for k, degree in zip(term.turns, f.degrees, strict=True) for n in (degree - k, k)
        ]
        for power, row in enumerate(term.coefficients):
            for of_pi, value in enumerate(row):
                if value:
                    terms[(power, of_pi, *waves)] = value
    return ring.context.from_dict(terms)


def _at(
    ring: PolynomialRing, polynomial: Polynomial, place: Expr, waves: list[Wave]
) -> RationalFunction:
    """The value of a polynomial of the ring at an exact frequency: a function of pi and of the
    cosines and sines of constant angles."""
    where, total = ring.convert(place), ring.zero
    for (power, of_pi, *turns), value in monomials(polynomial):
        if power and place == 0:
            continue
        number, exponents = value, [0, int(of_pi)]
        for wave, cosine, sine in zip(waves, turns[::2], turns[1::2], strict=True):
            if wave is None:
                exponents += [int(cosine), int(sine)]
            else:
                exponents += [0, 0]
                number = number * wave[0] ** int(cosine) * wave[1] ** int(sine)
        term = ring.function(ring.context.from_dict({tuple(exponents): number}))
        total = total + term * where ** int(power)
    return total


# The ratio of the ends of a piece at most. About its middle 2 low, Taylor's terms of omega^alpha
# then fall as (1/2)^n, and the bound of the remainder, taken at the low end, does not grow with n.
NEARER = 3.0
_NEAR = 4  # steps by that ratio in ``clear_of_zero``, before larger ones are taken
# Terms of an expansion that are tried: orders 1/5 and 1/12 alone give sixty between two powers of
# omega.
_MOST_TERMS = 2000

Powers: TypeAlias = tuple[int, ...]
"""A product of powers of omega, by the exponent of each omega^alpha."""


@dataclass(frozen=True)
class LeadingTerm:
    """The first term of an expansion at omega = 0 that is not zero, by its exponent.

    ``parts``: each product of powers of omega, its exponent, and the lowest order of its cofactor's
    Taylor terms that need not lie below the first term. All terms below that one cancel.
    """

    exponent: Expr
    parts: tuple[tuple[Powers, Expr, int], ...]


def by_powers(f: WaveSum) -> dict[Powers, WaveSum]:
    """The cofactors of the products of powers of omega in a sum, each an analytic function."""
    groups: dict[Powers, list[WaveTerm]] = {}
    for term in f.terms:
        groups.setdefault(term.powers, []).append(WaveTerm(term.turns, (), term.coefficients))
    return {
        powers: WaveSum(tuple(terms), f.rates, f.degrees, ()) for powers, terms in groups.items()
    }


@lru_cache(maxsize=1024)
def leading_term(f: WaveSum) -> LeadingTerm:
    """The first term of the expansion at omega = 0 that is not zero; UndecidedError where that is
    not decided for one of them, or where too many vanish."""
    parts = [
        (powers, sum((a * n for a, n in zip(f.orders, powers, strict=True)), Integer(0)))
        for powers in dict.fromkeys(term.powers for term in f.terms)
    ]
    for exponent, meeting in _exponents(parts):
        if not _cancels(f, meeting):
            return LeadingTerm(
                exponent, tuple((powers, e, _order(exponent - e)) for powers, e in parts)
            )
    raise UndecidedError("whether a function vanishes near omega = 0")


def _exponents(parts: list[tuple[Powers, Expr]]) -> Iterator[tuple[Expr, list[tuple[Powers, int]]]]:
    """The exponents of omega in ascending order, and the Taylor coefficients of the parts that meet
    at each."""
    # A merge of the ascending sequences e, e + 1, e + 2, ... of all parts: each leaves one entry in
    # the heap, its next exponent.
    waiting = [(_sortable(e), i, 0) for i, (_, e) in enumerate(parts)]
    heapify(waiting)
    for _ in range(_MOST_TERMS):
        least, first, order = waiting[0]
        exponent, meeting = parts[first][1] + order, list[tuple[Powers, int]]()
        while _is(parts, waiting[0], least, exponent):
            key, i, n = waiting[0]
            meeting.append((parts[i][0], n))
            heapreplace(waiting, (key + 1, i, n + 1))
        yield exponent, meeting


def _sortable(exponent: Expr) -> Fraction | float:
    """An exponent as a key of the heap: exact where it is rational; a float of any other gives the
    order, but not equality (``_is``)."""
    return Fraction(int(exponent.p), int(exponent.q)) if exponent.is_Rational else float(exponent)


def _is(
    parts: list[tuple[Powers, Expr]],
    entry: tuple[Fraction | float, int, int],
    key: Fraction | float,
    exponent: Expr,
) -> bool:
    """Whether an entry of the heap has this exponent: exact, as floats of equal irrational
    exponents may differ."""
    entry_key, i, n = entry
    if isinstance(entry_key, Fraction) and isinstance(key, Fraction):
        return entry_key == key
    return bool((parts[i][1] + n - exponent).expand() == 0)


def _order(rise: Expr) -> int:
    """The lowest whole number >= 0 that is not below ``rise``, the distance from a part's exponent
    to that of the first term."""
    # Irrational numbers are no whole ones: 30 digits find the next one above.
    return max(
        0, -int((-rise).p // (-rise).q) if rise.is_Rational else int(rise.evalf(30) // 1) + 1
    )


def _cancels(f: WaveSum, meeting: list[tuple[Powers, int]]) -> bool:
    """Whether Taylor coefficients at 0 that meet at one exponent add up to zero; UndecidedError
    where neither way decides.

    Balls prove most sums to be other than zero at once. A zero can only be proven exactly; where
    the angles are no rational parts of a turn, finer balls still may show that it is none.
    """

    def in_balls(_: int) -> bool | None:
        total = sum(f.before(arb(0), meeting), arb(0))
        return False if is_clear(total) else True if total.is_zero() else None

    if (verdict := at_rising_precision(in_balls, 128, 128)) is not None:
        return verdict
    # At omega = 0 every angle that turns is 0: there the waves are always known.
    waves, parts = exact_waves(f, Integer(0)), by_powers(f)
    assert waves is not None
    exact = [
        next(islice(taylor_coefficients(parts[powers], Integer(0), waves), n, None))
        for powers, n in meeting
    ]
    top = reduce(lambda x, y: RationalFunction(x.ring, *_sum(x, y)), exact).numerator
    is_zero = is_zero_number(top, [rate for rate, _ in f.rates])
    if is_zero is None:
        is_zero = at_rising_precision(in_balls, 256)
    if is_zero is None:
        raise UndecidedError("whether a function vanishes near omega = 0")
    return is_zero


def _sum(x: RationalFunction, y: RationalFunction) -> tuple[Polynomial, Polynomial]:
    return x.numerator * y.denominator + y.numerator * x.denominator, x.denominator * y.denominator


def clear_of_zero(f: WaveSum, first: Ball) -> Ball:
    """A dyadic number r > 0 such that f has no zero for 0 < omega <= r; ``first`` is tried first,
    then smaller ones. UndecidedError where none of 200 is shown to be one.

    By Taylor's theorem, divided by the leading power omega^e, f is the sum of omega^(alpha l + n_l
    - e) times the n_l-th Taylor coefficient of A_l about some place in between, alpha l + n_l being
    e or the next exponent above: all terms below cancel. If a ball around that sum is clear of 0,
    so is f.
    """
    start = leading_term(f)
    wanted = [(powers, order) for powers, _, order in start.parts]
    with flint.ctx.workprec(128):
        exponents = (exponent + order for _, exponent, order in start.parts)
        rises = [expression_ball(exponent - start.exponent) for exponent in exponents]
        reach = first.mid()
        for n in range(200):
            total, log_reach = arb(0), reach.log()
            for rise, cofactor in zip(rises, f.before(arb(0).union(reach), wanted), strict=True):
                # omega^rise grows from 0 to reach^rise on the piece; with rise 0 it is 1.
                if not rise.is_zero():
                    cofactor = cofactor * arb(0).union((rise * log_reach).exp())
                total = total + cofactor
            if is_clear(total):
                return reach
            reach = (reach / (NEARER if n < _NEAR else 16)).mid()
    raise UndecidedError("whether a function vanishes near omega = 0")


# The order of the root of unity at most: polynomials of that many coefficients are divided.
_MOST_PARTS = 20_000
_HALF = fmpq(1, 2)


def is_zero_number(polynomial: Polynomial, angles: Sequence[Expr]) -> bool | None:
    """Whether a polynomial in pi and the cosines and sines of half of some angles is the number
    zero: exact, True or False.

    None where an angle that occurs is no rational part of a turn, and where the common part of all
    of them is finer than ``_MOST_PARTS`` in a turn. The variables are those of a ring ``omega, pi,
    cos, sin, cos, sin, ...``.

    With z a primitive root of unity of which all angles are powers, cos = (z^k + z^-k)/2 and sin =
    (z^k - z^-k)/(2 i). Since pi is transcendental, the number is zero exactly where the coefficient
    of each power of pi is, and a polynomial in z is zero exactly where the cyclotomic polynomial of
    z, its minimal polynomial, divides it.
    """
    if polynomial.is_zero():
        return True
    exponents = [tuple(map(int, e)) for e in polynomial.monoms()]
    used = [i for i in range(len(angles)) if any(e[2 + 2 * i] or e[3 + 2 * i] for e in exponents)]
    turns = {i: angles[i] / (4 * pi) for i in used}  # half an angle, as parts of a turn
    if not all(x.is_Rational for x in turns.values()):
        return None
    # A multiple of 4, so that 1/i is a power of z too.
    whole = lcm(4, *(int(x.q) for x in turns.values()))
    if whole > _MOST_PARTS:
        return None
    rows: dict[int, dict[int, fmpq]] = {}
    for exponent, value in zip(exponents, polynomial.coeffs(), strict=True):
        product = {0: value}
        for i in used:
            k = int(turns[i] * whole)
            product = _times(product, ((k, _HALF), (-k, _HALF)), exponent[2 + 2 * i], whole)
            quarter = whole // 4  # 1/i = -i
            product = _times(
                product, ((k - quarter, _HALF), (-k - quarter, -_HALF)), exponent[3 + 2 * i], whole
            )
        row = rows.setdefault(exponent[1], {})
        for n, x in product.items():
            row[n] = row.get(n, fmpq(0)) + x
    return all(_is_multiple(row, whole) for row in rows.values())


def _times(
    x: dict[int, fmpq], y: Iterable[tuple[int, fmpq]], count: int, whole: int
) -> dict[int, fmpq]:
    """A sum of powers of a root of unity, by exponents modulo ``whole``, times the ``count``-th
    power of another one."""
    for _ in range(count):
        spread: dict[int, fmpq] = {}
        for i, a in x.items():
            for j, b in y:
                spread[(i + j) % whole] = spread.get((i + j) % whole, fmpq(0)) + a * b
        x = spread
    return x


def _is_multiple(row: dict[int, fmpq], whole: int) -> bool:
    """Whether a sum of powers of a primitive root of unity of order ``whole`` is zero."""
    below = lcm(*(int(x.q) for x in row.values()))
    coefficients = [0] * whole
    for n, x in row.items():
        coefficients[n] = int(x.p) * (below // int(x.q))
    return bool((fmpz_poly(coefficients) % fmpz_poly.cyclotomic(whole)) == 0)


_Terms: TypeAlias = dict[tuple[int, ...], fmpq]


def vanishes(polynomial: Polynomial, axis: Axis) -> bool:
    """Whether a polynomial of an axis is proven to be zero at every frequency, as Re s^(1/2)
    s^(1/2) is. False proves nothing.

    Terms with equal powers of omega, and of half-angle tangents of delays, are gathered: each group
    must have the number zero for its coefficient.
    """
    constant = [i for i, angle in enumerate(axis.angles) if angle.constant]
    every = [int(n) for n in polynomial.degrees()]
    if (
        polynomial.is_zero()
        or not constant
        or any(every[2 : axis.size])
        or not all(x.is_Rational for x in axis.orders)
    ):
        return bool(polynomial.is_zero())
    degrees = every[axis.size :]
    groups: dict[tuple[Expr, tuple[int, ...]], _Terms] = {}
    for exponents, value in zip(polynomial.monoms(), polynomial.coeffs(), strict=True):
        power, of_pi, *others = map(int, exponents)
        in_functions = others[axis.size - 2 :]
        tangents, powers = in_functions[: len(axis.angles)], in_functions[len(axis.angles) :]
        broken = (x * n for x, n in zip(axis.orders, powers, strict=False))
        raised = sum(broken, Integer(power))
        turning = tuple(n for i, n in enumerate(tangents) if i not in constant)
        # tan^k, made homogeneous of its degree: cos^(degree - k) sin^k.
        waves = [n for i in constant for n in (degrees[i] - tangents[i], tangents[i])]
        group, key = groups.setdefault((raised, turning), {}), (0, of_pi, *waves)
        group[key] = group.get(key, fmpq(0)) + value
    angles = [axis.angles[i].value for i in constant]
    ring = PolynomialRing(
        omega, functions=[Symbol(f"{kind}{i}") for i in constant for kind in ("cos", "sin")]
    )
    return all(_is_nothing(ring, group, angles) for group in groups.values())


def _is_nothing(ring: PolynomialRing, terms: _Terms, angles: Sequence[Expr]) -> bool:
    """Whether a polynomial in cosines and sines of constant half angles is proven to be the number
    zero."""
    polynomial = ring.context.from_dict(terms)
    # Balls first: most groups are other than zero, which 128 bits show at once.
    with flint.ctx.workprec(128):
        halves = [expression_ball(angle / 2).sin_cos() for angle in angles]
        waves = [x for sine, cosine in halves for x in (cosine, sine)]
        if is_clear(
            ring.ball(polynomial, dict(zip(ring.meanings[1:], (arb.pi(), *waves), strict=True)))
        ):
            return False
    return bool(is_zero_number(polynomial, angles))
