"""Polynomials times sines, cosines and powers of omega, and sums of them: values, Taylor
coefficients, beginnings at 0.

Derivatives of polynomials times waves of half angles are of the same kind, in balls; where all that
turns is known exactly they are exact. A function with powers of omega, f = sum over l of
omega^(alpha l) A_l with A_l analytic, begins at omega = 0 with the first term of its expansion that
is not zero. Where alpha is rational, terms of different l meet at one exponent, and their
coefficients, sums of products of cosines and sines of parts of a turn, may cancel: Re s^(2 alpha)
is 0 for alpha = 1/2. These are algebraic, beside pi, which is not: whether such a number is zero is
decided.
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
_Blocks: TypeAlias = Mapping[Turns, arb_mat]
"""Coefficients of powers of omega (columns) times waves of the last angle (rows), by the turns of
the other angles."""
Place: TypeAlias = tuple[Mapping[Turns, Ball], arb_mat, arb_mat]
"""Products of sines and cosines of all half angles but the last, by turns; those of the last one in
a row; powers of omega."""


class Derivatives:
    """A sum of polynomials times waves and its derivatives, which are of the same kind: exact, and
    no longer.

    d sin(a)^k cos(a)^(n - k) = (k sin(a)^(k - 1) cos(a)^(n - k + 1) - (n - k) sin(a)^(k + 1)
    cos(a)^(n - k - 1)) da.
    """

    def __init__(
        self, angles: Sequence[tuple[Ball, int]], width: int, terms: Mapping[Turns, Sequence[Ball]]
    ) -> None:
        *self._outer, (rate, degree) = angles
        self._turn, self._shift = _turning(rate, degree), _shift(width)
        entries: dict[Turns, list[Ball]] = {}
        for (*others, k), row in terms.items():
            block = entries.setdefault(tuple(others), [NOTHING] * (width * (degree + 1)))
            block[k * width : k * width + len(row)] = row
        self._known: list[_Blocks] = [
            {o: arb_mat(degree + 1, width, block) for o, block in entries.items()}
        ]

    def series(self, place: Place, start: int, stop: int) -> list[Ball]:
        """The Taylor coefficients of these orders."""
        outer, last, columns = place
        while len(self._known) < stop:
            self._known.append(self._derived(self._known[-1]))
        if () in outer:
            found = [(last * (blocks[()] * columns))[0, 0] for blocks in self._known[start:stop]]
        else:
            found = [
                sum(
                    (
                        outer[turns] * (last * (block * columns))[0, 0]
                        for turns, block in blocks.items()
                    ),
                    NOTHING,
                )
                for blocks in self._known[start:stop]
            ]
        return list(map(mul, found, _shares(stop, flint.ctx.prec)[start:])) if stop > 2 else found

    def _derived(self, blocks: _Blocks) -> _Blocks:
        found: dict[Turns, arb_mat] = {}
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
                found[turns] = found[turns] + part if turns in found else part
        return found


@lru_cache(maxsize=64)
def _shares(count: int, bits: int) -> list[Ball]:
    """1/0!, 1/1!, 1/2!, ..."""
    with flint.ctx.workprec(bits):
        return [arb(1) / factorial(n) for n in range(count)]


@lru_cache(maxsize=64)
def _shift(width: int) -> arb_mat:
    """What d/d omega does to the coefficients of 1, omega, omega^2, ... in a row: whole numbers,
    exact at any precision."""
    shift = arb_mat(width, width)
    for n in range(1, width):
        shift[n, n - 1] = n
    return shift


def _turning(rate: Ball, degree: int) -> arb_mat:
    """What d/d omega does to the coefficients of sin^k cos^(degree - k), k = 0 ... degree, of one
    half angle."""
    turn = arb_mat(degree + 1, degree + 1)
    for k in range(degree):
        turn[k, k + 1] = rate * (k + 1)
        turn[k + 1, k] = rate * (k - degree)
    return turn


def powers_of(x: Ball, count: int) -> list[Ball]:
    """1, x, x^2, ..."""
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
    """The Taylor coefficients of x^exponent."""
    found = [(x.log() * exponent).exp()]
    inverse = 1 / x if length > 1 else x
    for n in range(length - 1):
        found.append(found[-1] * ((exponent - n) / (n + 1)) * inverse)
    return found


def product(a: Sequence[Ball], b: Sequence[Ball], start: int = 0) -> list[Ball]:
    """The product of two Taylor series, as long as they are, from an order on."""
    if start == len(a) - 1:
        return [reduce(add, map(mul, a, reversed(b)))]
    found = arb_poly(a) * arb_poly(b)
    return [found[n] for n in range(start, len(a))]


_TAYLOR_ORDER = 8


class WaveTerm(NamedTuple):
    """Part of a sum: a polynomial in omega times sines, cosines and powers.

    ``coefficients``: of ascending powers of omega, each a polynomial in pi over the integers.
    ``turns``: the power of the half angle's sine, for each angle (the cosine has what is missing to
    the sum's degree). ``powers``: of each omega^alpha.
    """

    turns: tuple[int, ...]
    powers: tuple[int, ...]
    coefficients: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class WaveSum:
    """sum of p(omega) prod sin(a_i/2)^k_i cos(a_i/2)^(n_i - k_i) prod omega^(alpha l): entire for
    omega > 0, no divisions.

    ``rates``: of each angle d a_i/d omega, rad per rad/s, with False; of a constant angle itself,
    rad, with True. ``degrees``:
    the n_i.
    """

    terms: tuple[WaveTerm, ...]
    rates: tuple[tuple[Expr, bool], ...]
    degrees: tuple[int, ...]
    orders: tuple[Expr, ...]
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
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
        """Taylor coefficients about every point of a ball: each of what stands before a product of
        omega^alpha, and its order."""
        return _compiled(self, flint.ctx.prec).before(x, wanted)

    def parts(self, x: Ball) -> list[Ball]:
        """Balls around the values at a ball of frequencies of what stands before each product of
        powers of omega^alpha."""
        return _compiled(self, flint.ctx.prec).parts(x)

    @property
    def begins_with_zero(self) -> bool:
        """Whether it is 0 at omega = 0, no powers of omega in it, as each term holds a sine that
        turns, or omega."""
        turning = [i for i, (_, constant) in enumerate(self.rates) if not constant]
        still = (
            term.coefficients[0] for term in self.terms if not any(term.turns[i] for i in turning)
        )
        return not any(map(any, still))

    @property
    def shows_itself(self) -> bool:
        """Whether its coefficients prove that it is not 0 everywhere; all orders of powers must be
        rational.

        Waves of one angle are linearly independent over all algebraic functions. So are then all
        terms, where no two products of powers are a whole power of omega apart: one coefficient
        that is not 0 is enough. False proves nothing.
        """
        if sum(not constant for _, constant in self.rates) > 1:
            return False
        common = lcm(*(int(order.q) for order in self.orders))
        units = [int(order.p) * (common // int(order.q)) for order in self.orders]
        products = {term.powers for term in self.terms}
        apart = {sum(map(mul, units, powers)) % common for powers in products}
        return len(apart) == len(products) and _compiled(self, flint.ctx.prec).has_clear_coefficient

    def ranges(self, box: Ball) -> dict[tuple[int, ...], Ball]:
        """The same, tight for a short ball."""
        return _compiled(self, flint.ctx.prec).ranges(box)


_Key: TypeAlias = tuple[Turns, tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class CompiledWaves:
    """A sum with balls of one precision for its constants: waves of constant angles are among the
    coefficients.

    ``rates``, ``degrees``: of the half angles that turn. ``terms``: sine powers, powers of
    omega^alpha, ascending coefficients.
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
        place, found = self._place(x), list[Ball]()
        for powers, sums in self._sums.items():
            if any(powers):
                exponent = reduce(add, map(mul, self.exponents, powers))
                own = product(sums.series(place, 0, stop), power_series(x, exponent, stop), start)
            else:
                own = sums.series(place, start, stop)
            found = list(map(add, found, own)) if found else own
        return found

    def before(self, x: Ball, wanted: Sequence[tuple[tuple[int, ...], int]]) -> list[Ball]:
        """Taylor coefficients about every point of a ball: each of what stands before a product of
        omega^alpha, and its order."""
        place = self._place(x)
        return [self._sums[powers].series(place, order, order + 1)[0] for powers, order in wanted]

    def parts(self, x: Ball) -> list[Ball]:
        """Balls around the values at a ball of frequencies of what stands before each product of
        powers of omega^alpha."""
        place = self._place(x)
        return [sums.series(place, 0, 1)[0] for sums in self._sums.values()]

    def ranges(self, box: Ball) -> dict[tuple[int, ...], Ball]:
        """Enclosures over a ball of frequencies of what stands before each product of powers of
        omega^alpha, as in ``over``."""
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
        """Rate and degree of the half angles that turn; one that stands still where there is
        none."""
        return list(zip(self.rates, self.degrees, strict=True)) or [(arb(0), 0)]

    def _place(self, x: Ball) -> Place:
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
        """By powers of omega^alpha, what stands before them."""
        groups: dict[tuple[int, ...], dict[Turns, Sequence[Ball]]] = {}
        for turns, powers, row in self.terms:
            groups.setdefault(powers, {})[turns or (0,)] = row
        return {
            powers: Derivatives(self._angles, self._width, own) for powers, own in groups.items()
        }


@lru_cache(maxsize=512)
def _compiled(waves: WaveSum, bits: int) -> CompiledWaves:
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
            own = units[tuple([turns[i] for i, _ in fixed])]
            row = terms.setdefault(
                (tuple([turns[i] for i in turning]) if fixed else turns, powers), []
            )
            row += [NOTHING] * (len(coefficients) - len(row))
            for n, c in enumerate(coefficients):
                for whole, unit in zip(c, own):  # noqa: B905 - not all have all powers of pi
                    if whole:
                        row[n] = row[n] + unit * whole if fixed or unit is not ONE else arb(whole)
        return CompiledWaves(
            tuple(halves[i] for i in turning),
            tuple(waves.degrees[i] for i in turning),
            tuple(expression_ball(order) for order in waves.orders),
            tuple((*key, row) for key, row in terms.items()),
        )


Wave: TypeAlias = tuple[int, int] | None
_EIGHTHS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def exact_waves(f: WaveSum, place: Expr) -> list[Wave] | None:
    """Cosine and sine of the half angles, up to a factor, at multiples of an eighth of a turn; None
    if one is at another angle.

    In all terms of a factor the powers of both add up to the same, so that a common factor is none
    of the zeros' business. The entry of a constant angle is None: its cosine and sine stay symbols.
    """
    if place != 0 and place.is_Rational and any(rate.is_Rational for rate, _ in f.rates):
        return None  # a rational angle, but 0, is no part of a turn
    found: list[Wave] = []
    for rate, constant in f.rates:
        eighths = Integer(0) if constant else 2 * rate * place / pi
        if not eighths.is_Integer:
            return None
        found.append(None if constant else _EIGHTHS[int(eighths) % 8])
    return found


def taylor_coefficients(f: WaveSum, place: Expr, waves: list[Wave]) -> Iterator[RationalFunction]:
    """The Taylor coefficients at a place where the waves are known, all times one number that is
    not 0.

    Each is a polynomial in the cosines and sines of the constant half angles, in this order from
    the third variable of its ring on, over a polynomial in pi.
    """
    names = [Symbol(f"{kind}{i}") for i in range(len(f.rates)) for kind in ("cos", "sin")]
    ring = PolynomialRing(omega, functions=names)
    derivative = _in_waves(f, ring)
    rates = [ring.convert(rate / 2) for rate, _ in f.rates]
    common = reduce(lambda x, y: x * y, (rate.denominator for rate in rates), ring.constant(1))
    scale, order = ring.one, 0
    while True:
        yield _at(ring, derivative, place, waves) / scale
        change = common * derivative.derivative(0)
        for i, (rate, (_, constant)) in enumerate(zip(rates, f.rates, strict=True)):
            if not constant:
                cosine, sine = (ring.context.gens()[2 + 2 * i + n] for n in (0, 1))
                turned = cosine * derivative.derivative(3 + 2 * i) - sine * derivative.derivative(
                    2 + 2 * i
                )
                change += rate.numerator * (common / rate.denominator) * turned
        derivative, order = change, order + 1
        scale = scale * ring.function(common * order)


def order_at_0(f: WaveSum) -> int | None:
    """The order of the zero at omega = 0, where all angles turn at rational rates; None where they
    do not, or it is very high.

    The cosines of half angles are 1 there: it is that of the sum of polynomials times tangents,
    order by order.
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
    """The value at an exact place, a polynomial in pi (and the constant angles' waves)."""
    where, total = ring.convert(place), ring.zero
    for (power, of_pi, *turns), value in monomials(polynomial):
        if power and place == 0:
            continue
        known, kept = value, [0, int(of_pi)]
        for wave, cosine, sine in zip(waves, turns[::2], turns[1::2], strict=True):
            kept += [int(cosine), int(sine)] if wave is None else [0, 0]
            known = known if wave is None else known * wave[0] ** int(cosine) * wave[1] ** int(sine)
        total = total + ring.function(ring.context.from_dict({tuple(kept): known})) * where ** int(
            power
        )
    return total


NEARER = 3.0  # between the ends of a piece: Taylor's terms of omega^alpha fall as (1/2)^n, the remainder's bound does not grow
_NEAR = 4  # of such places, before larger steps are taken
_MOST_TERMS = 2000  # of an expansion that are tried: orders 1/5 and 1/12 meet sixty times between two powers of omega

Powers: TypeAlias = tuple[int, ...]
"""Which product of powers omega^alpha it is that an analytic function stands before."""


@dataclass(frozen=True)
class LeadingTerm:
    """The exponent of the first term; ``parts``: each with its own exponent and its order up to
    which all terms cancel."""

    exponent: Expr
    parts: tuple[tuple[Powers, Expr, int], ...]


def by_powers(f: WaveSum) -> dict[Powers, WaveSum]:
    """A sum as a sum of analytic functions, each times powers omega^alpha."""
    groups: dict[Powers, list[WaveTerm]] = {}
    for term in f.terms:
        groups.setdefault(term.powers, []).append(WaveTerm(term.turns, (), term.coefficients))
    return {
        powers: WaveSum(tuple(terms), f.rates, f.degrees, ()) for powers, terms in groups.items()
    }


@lru_cache(maxsize=1024)
def leading_term(f: WaveSum) -> LeadingTerm:
    """The first term of the expansion at 0; UndecidedError where none of the first ones shows."""
    own = [
        (powers, sum((a * n for a, n in zip(f.orders, powers, strict=True)), Integer(0)))
        for powers in dict.fromkeys(term.powers for term in f.terms)
    ]
    for exponent, meeting in _exponents(own):
        if not _cancels(f, meeting):
            return LeadingTerm(
                exponent, tuple((powers, e, _order(exponent - e)) for powers, e in own)
            )
    raise UndecidedError("whether a function vanishes near omega = 0")


def _exponents(parts: list[tuple[Powers, Expr]]) -> Iterator[tuple[Expr, list[tuple[Powers, int]]]]:
    """The exponents of omega in ascending order, and the Taylor coefficients of the parts that meet
    at each."""
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
    return Fraction(int(exponent.p), int(exponent.q)) if exponent.is_Rational else float(exponent)


def _is(
    parts: list[tuple[Powers, Expr]],
    entry: tuple[Fraction | float, int, int],
    key: Fraction | float,
    exponent: Expr,
) -> bool:
    own, i, n = entry
    if isinstance(own, Fraction) and isinstance(key, Fraction):
        return own == key
    return bool((parts[i][1] + n - exponent).expand() == 0)


def _order(rise: Expr) -> int:
    """The lowest order of a part of which the terms may not all lie below the first one: the
    ceiling, and 0 or more."""
    return max(
        0, -int((-rise).p // (-rise).q) if rise.is_Rational else int(rise.evalf(30) // 1) + 1
    )


def _cancels(f: WaveSum, meeting: list[tuple[Powers, int]]) -> bool:
    """Whether Taylor coefficients at 0 add up to zero: balls first, then exact, finer balls where
    that is not told exactly."""

    def in_balls(_: int) -> bool | None:
        total = sum(f.before(arb(0), meeting), arb(0))
        return False if is_clear(total) else True if total.is_zero() else None

    if (told := at_rising_precision(in_balls, 128, 128)) is not None:
        return told
    waves, parts = exact_waves(f, Integer(0)), by_powers(f)
    assert waves is not None
    exact = [
        next(islice(taylor_coefficients(parts[powers], Integer(0), waves), n, None))
        for powers, n in meeting
    ]
    top = reduce(lambda x, y: RationalFunction(x.ring, *_sum(x, y)), exact).numerator
    found = is_zero_number(top, [rate for rate, _ in f.rates])
    if found is None:
        found = at_rising_precision(in_balls, 256)
    if found is None:
        raise UndecidedError("whether a function vanishes near omega = 0")
    return found


def _sum(x: RationalFunction, y: RationalFunction) -> tuple[Polynomial, Polynomial]:
    return x.numerator * y.denominator + y.numerator * x.denominator, x.denominator * y.denominator


def clear_of_zero(f: WaveSum, first: Ball) -> Ball:
    """A dyadic number above 0, with no zero in between; ``first`` is tried first.

    Divided by the lowest power omega^e of all, what remains is the sum of omega^(alpha l + n_l - e)
    times the n_l-th Taylor coefficient of A_l about some place in between, alpha l + n_l being e or
    the next exponent above: all terms below cancel.
    """
    start = leading_term(f)
    wanted = [(powers, order) for powers, _, order in start.parts]
    with flint.ctx.workprec(128):
        rises = [expression_ball(own + order - start.exponent) for _, own, order in start.parts]
        reach = first.mid()
        for n in range(200):
            total, lengths = arb(0), reach.log()
            for rise, own in zip(rises, f.before(arb(0).union(reach), wanted), strict=True):
                total = total + (
                    own if rise.is_zero() else own * arb(0).union((rise * lengths).exp())
                )
            if is_clear(total):
                return reach
            reach = (reach / (NEARER if n < _NEAR else 16)).mid()
    raise UndecidedError("whether a function vanishes near omega = 0")


_MOST_PARTS = 20_000  # parts of a turn, of which exact cosines are added up
_HALF = fmpq(1, 2)


def is_zero_number(polynomial: Polynomial, angles: Sequence[Expr]) -> bool | None:
    """Whether a polynomial in pi and the cosines and sines of half of some angles is the number
    zero: exact.

    The variables are those of a ring ``omega, pi, cos, sin, cos, sin, ...``. None where a turn
    would have too many parts, and where an angle is no part of a turn. With z a root of unity, cos
    = (z^k + z^-k)/2 and sin = (z^k - z^-k)/(2 i): each coefficient of a power of pi, which is
    transcendental, must be a multiple of z's cyclotomic polynomial.
    """
    if polynomial.is_zero():
        return True
    exponents = [tuple(map(int, e)) for e in polynomial.monoms()]
    used = [i for i in range(len(angles)) if any(e[2 + 2 * i] or e[3 + 2 * i] for e in exponents)]
    turns = {i: angles[i] / (4 * pi) for i in used}  # half an angle, as parts of a turn
    if not all(x.is_Rational for x in turns.values()):
        return None
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
    """A sum of powers of a root of unity times another one, that many times."""
    for _ in range(count):
        found: dict[int, fmpq] = {}
        for i, a in x.items():
            for j, b in y:
                found[(i + j) % whole] = found.get((i + j) % whole, fmpq(0)) + a * b
        x = found
    return x


def _is_multiple(row: dict[int, fmpq], whole: int) -> bool:
    """Whether a sum of powers of a root of unity is zero."""
    below = lcm(*(int(x.q) for x in row.values()))
    coefficients = [0] * whole
    for n, x in row.items():
        coefficients[n] = int(x.p) * (below // int(x.q))
    return bool((fmpz_poly(coefficients) % fmpz_poly.cyclotomic(whole)) == 0)


_Terms: TypeAlias = dict[tuple[int, ...], fmpq]


def vanishes(polynomial: Polynomial, axis: Axis) -> bool:
    """Whether a polynomial of an axis is zero at every frequency, as Re s^(1/2) s^(1/2) is. (False:
    not seen to be.)

    Equal powers of omega, and of tangents that turn, are gathered: what stands before each must be
    the number zero.
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
        power, of_pi, *own = map(int, exponents)
        own = own[axis.size - 2 :]
        raised = sum(
            (x * n for x, n in zip(axis.orders, own[len(axis.angles) :], strict=False)),
            Integer(power),
        )
        turning = tuple(n for i, n in enumerate(own[: len(axis.angles)]) if i not in constant)
        waves = [n for i in constant for n in (degrees[i] - own[i], own[i])]
        group, key = groups.setdefault((raised, turning), {}), (0, of_pi, *waves)
        group[key] = group.get(key, fmpq(0)) + value
    angles = [axis.angles[i].value for i in constant]
    ring = PolynomialRing(
        omega, functions=[Symbol(f"{kind}{i}") for i in constant for kind in ("cos", "sin")]
    )
    return all(_is_nothing(ring, group, angles) for group in groups.values())


def _is_nothing(ring: PolynomialRing, terms: _Terms, angles: Sequence[Expr]) -> bool:
    polynomial = ring.context.from_dict(terms)
    with flint.ctx.workprec(128):
        halves = [expression_ball(angle / 2).sin_cos() for angle in angles]
        waves = [x for sine, cosine in halves for x in (cosine, sine)]
        if is_clear(
            ring.ball(polynomial, dict(zip(ring.meanings[1:], (arb.pi(), *waves), strict=True)))
        ):
            return False
    return bool(is_zero_number(polynomial, angles))
