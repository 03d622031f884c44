"""Sums of delay terms on the imaginary axis: enclosures of such a sum and of its derivatives.

**Where the sums come from.** At s = j omega a delay tau gives exp(-j omega tau), that is cos(omega
tau) - j sin(omega tau), and a power s^alpha gives omega^alpha exp(j alpha pi/2). Both hold an angle
a: the *delay angle* omega tau, which is proportional to omega, and the *constant angle* alpha pi/2.
With t = tan(a/2), exp(-j a) = (1 - j t)/(1 + j t): real and imaginary parts of transfer functions
are quotients of polynomials in omega, pi, omega^alpha and such t (``kernel.axis``). Times
cos(a/2)^n, n its degree in t, such a polynomial is a ``WaveSum``

    f(omega) = sum of p(omega) prod_i sin(a_i/2)^k_i cos(a_i/2)^(n_i - k_i)
                      times prod_m omega^(alpha_m l_m)

over its terms. Each p is a polynomial in omega, its coefficients are polynomials in pi over the
integers. There is no division in it, and f is analytic for omega > 0. Gathered by their powers of
omega, the terms are f = sum over l of omega^(alpha l) A_l(omega); the *cofactors* A_l are analytic
everywhere.

**Problem.** Given a ball X of frequencies, a midpoint with a radius (``flint.arb``), enclose
f(x), f'(x), f''(x)/2, ... for all x in X at once.

**Method.** The functions sin(a/2)^k cos(a/2)^(n - k), k = 0 ... n, of one delay angle span a space
that d/d omega maps into itself, and so do 1, omega, omega^2, ... up to some degree. So each
derivative of a cofactor is a sum of the same shape as the cofactor: its coefficients follow from
those before by multiplication with fixed matrices (``_Cofactor``). The Taylor coefficients of
omega^e have a recurrence (``power_series``), and Leibniz' rule joins both. Over a ball whose width
makes terms cancel badly, ``over`` uses Taylor's theorem with Lagrange's remainder about the
midpoint m,

    f(m + h) = sum over i < 8 of f^(i)(m)/i! h^i + f^(8)(xi)/8! h^8,     xi between m and m + h.

Every operation is one of ball arithmetic (F. Johansson, Arb: efficient arbitrary-precision
midpoint-radius interval arithmetic, IEEE Transactions on Computers 66, 2017): its result holds the
exact result for all points of its operands.

**Returned** are balls, which hold the quantity at every point of the ball that was given, at
FLINT's current working precision (``flint.ctx.prec``). How narrow they are is not guaranteed.

**Failure.** Nothing is ever wrong for want of precision, only wide. A ball that reaches omega <= 0
has no logarithm: where powers of omega occur, values there are not finite. LimitError comes from
``tick`` where a time limit is over (``kernel.budget``).

How f begins at omega = 0 is the subject of ``kernel.leadingterm``, whether it is zero everywhere
that of ``kernel.zerotest``. Begin reading with ``WaveSum``, then ``CompiledWaves``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, reduce
from itertools import accumulate, repeat
from math import factorial, lcm
from operator import add, mul
from typing import NamedTuple, TypeAlias

import flint
from flint import arb, arb_mat, arb_poly
from sympy import Expr

from haptisym.kernel.budget import tick
from haptisym.kernel.enclosures import range_of
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.zeros import is_clear

# The order of the remainder in ``over`` and ``cofactor_ranges``: it falls as the eighth power of
# the ball's radius. Another order gives other widths, never a wrong enclosure.
_TAYLOR_ORDER = 8
_ZERO, _ONE = arb(0), arb(1)

Sines: TypeAlias = tuple[int, ...]
"""For each half angle the exponent k of its sine; that of its cosine is n - k, n being the degree
of the sum in this angle."""
Powers: TypeAlias = tuple[int, ...]
"""A product of powers of omega: for each order alpha the exponent l of omega^alpha."""


# The exact sum


class WaveTerm(NamedTuple):
    """A term of a ``WaveSum``: a polynomial in omega times sines, cosines and powers of omega.

    ``coefficients[n][i]`` stands before omega^n pi^i.
    """

    sines: Sines
    powers: Powers
    coefficients: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class WaveSum:
    """The sum f of the module's text, exact: analytic for omega > 0, without divisions.

    ``terms``: at least one, and no two with the same ``sines`` and ``powers`` (their coefficients
    would not be added). ``rates``: for each angle (a, False), a delay angle a omega with a in rad
    per rad/s, or (a, True), a constant angle a in rad. ``degrees``: the n_i of the angles.
    ``orders``: the alpha_m.
    """

    terms: tuple[WaveTerm, ...]
    rates: tuple[tuple[Expr, bool], ...]
    degrees: tuple[int, ...]
    orders: tuple[Expr, ...]
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        keys = {(term.sines, term.powers) for term in self.terms}
        assert 0 < len(keys) == len(self.terms), "two terms with the same sines and powers"
        # Sums are keys of caches that are asked at every evaluation: their hash is computed once.
        # It may leave out rates and orders, which equality compares.
        object.__setattr__(self, "_hash", hash((self.terms, self.degrees)))

    def __hash__(self) -> int:
        return self._hash

    def value(self, x: Ball) -> Ball:
        """A ball around f at every point of a ball of frequencies."""
        return _compiled(self, flint.ctx.prec).value(x)

    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around the Taylor coefficients f^(n)/n! at every point of a ball of frequencies,
        for ``start`` <= n < ``stop``."""
        return _compiled(self, flint.ctx.prec).series(x, start, stop)

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Balls around f, f' and f''/2 over a ball of frequencies, by Taylor's theorem: much
        narrower than ``series`` where the ball is short and terms cancel."""
        return _compiled(self, flint.ctx.prec).over(box)

    def cofactor_values(self, x: Ball) -> list[Ball]:
        """Balls around the cofactors A_l at every point of a ball of frequencies, in the order in
        which their products of powers first occur in ``terms``."""
        return _compiled(self, flint.ctx.prec).cofactor_values(x)

    def cofactor_series(self, x: Ball, wanted: Sequence[tuple[Powers, int]]) -> list[Ball]:
        """For each pair (l, n) in ``wanted`` a ball around A_l^(n)/n! at every point of a ball of
        frequencies, which may hold 0."""
        return _compiled(self, flint.ctx.prec).cofactor_series(x, wanted)

    def cofactor_ranges(self, box: Ball) -> dict[Powers, Ball]:
        """Balls around the cofactors A_l over a ball of frequencies, by their powers l; by Taylor's
        theorem, as in ``over``."""
        return _compiled(self, flint.ctx.prec).cofactor_ranges(box)

    def cofactors(self) -> dict[Powers, WaveSum]:
        """The cofactors A_l as sums without powers of omega, by their powers l."""
        groups: dict[Powers, list[WaveTerm]] = {}
        for term in self.terms:
            without_powers = WaveTerm(term.sines, (), term.coefficients)
            groups.setdefault(term.powers, []).append(without_powers)
        return {
            powers: WaveSum(tuple(terms), self.rates, self.degrees, ())
            for powers, terms in groups.items()
        }

    @property
    def is_shown_zero_at_0(self) -> bool:
        """True: every term holds omega or the sine of a delay angle, so that f(0) = 0. False:
        nothing is known. For sums without powers of omega."""
        delay_angles = _indices(self.rates, constant=False)
        for term in self.terms:
            has_sine = any(term.sines[i] for i in delay_angles)
            if not has_sine and any(term.coefficients[0]):
                return False
        return True

    @property
    def is_shown_nonzero(self) -> bool:
        """True: f is proven not to vanish identically. False: nothing is known.

        For one delay angle a = omega tau, tau not 0, t = tan(a/2) is transcendental over the
        algebraic functions of omega, so that the products sin^k cos^(n - k) are linearly
        independent over these. Functions omega^e are linearly independent over the polynomials if
        no two exponents e differ by an integer.
        Where both hold, f = 0 only if every coefficient is 0: one that is not 0 is enough.
        """
        if len(_indices(self.rates, constant=False)) > 1:
            return False
        if not all(order.is_Rational for order in self.orders):
            return False
        # As multiples of 1/common, exponents differ by an integer where they agree modulo common.
        common = lcm(*(int(order.q) for order in self.orders))
        multiples = [int(order * common) for order in self.orders]
        products = {term.powers for term in self.terms}
        residues = {sum(map(mul, multiples, powers)) % common for powers in products}
        if len(residues) < len(products):
            return False
        return _compiled(self, flint.ctx.prec).has_clear_coefficient


def _indices(rates: Sequence[tuple[Expr, bool]], *, constant: bool) -> list[int]:
    """The indices of the constant angles, or of the delay angles."""
    return [i for i, (_, is_constant) in enumerate(rates) if is_constant == constant]


# The same sum in balls


@lru_cache(maxsize=512)
def _compiled(f: WaveSum, bits: int) -> CompiledWaves:
    """A sum with balls of that many bits in place of its exact numbers.

    What does not depend on omega, powers of pi and the waves of constant angles, is multiplied
    here, once.
    """
    with flint.ctx.workprec(bits):
        halves = [expression_ball(rate) / 2 for rate, _ in f.rates]
        delay_angles = _indices(f.rates, constant=False)
        constant_angles = _indices(f.rates, constant=True)
        constants = _constants(f, halves, constant_angles)
        rows: dict[tuple[Sines, Powers], list[Ball]] = {}
        for sines, powers, coefficients in f.terms:
            # Terms that differ in constant angles alone share a row.
            sines_of_delays = tuple([sines[i] for i in delay_angles])
            row = rows.setdefault((sines_of_delays, powers), [])
            row += [_ZERO] * (len(coefficients) - len(row))
            sines_of_constants = tuple([sines[i] for i in constant_angles])
            powers_of_pi = constants[sines_of_constants]
            for n, coefficient in enumerate(coefficients):
                # A coefficient need not have all powers of pi that occur in the sum.
                pairs = zip(coefficient, powers_of_pi, strict=False)
                for i, (number, constant) in enumerate(pairs):
                    if not number:
                        continue
                    # Without constant angles each row is of one term, in which pi^0 comes first:
                    # assigned, not added, an integer stays exact, whatever the precision.
                    if constant_angles or i:
                        row[n] = row[n] + constant * number
                    else:
                        row[n] = arb(number)
        return CompiledWaves(
            tuple(halves[i] for i in delay_angles),
            tuple(f.degrees[i] for i in delay_angles),
            tuple(expression_ball(order) for order in f.orders),
            tuple((*key, row) for key, row in rows.items()),
        )


def _constants(
    f: WaveSum, halves: Sequence[Ball], constant_angles: Sequence[int]
) -> dict[Sines, list[Ball]]:
    """For the exponents of the sines of all constant angles, the product of their waves times 1,
    pi, pi^2, ..."""
    length = max(len(c) for term in f.terms for c in term.coefficients)
    constants: dict[Sines, list[Ball]] = {(): powers_of(arb.pi(), length)}
    for i in constant_angles:
        waves = waves_of(halves[i], f.degrees[i])
        constants = {
            (*sines, k): [x * wave for x in row]
            for sines, row in constants.items()
            for k, wave in enumerate(waves)
        }
    return constants


class _Basis(NamedTuple):
    """Values of the functions whose coefficients ``_Cofactor`` holds, at a ball of frequencies.

    ``outer``: products of sines and cosines of all delay angles but the last, by the exponents of
    the sines. ``last``: sin^k cos^(n - k) of the last one, k = 0 ... n, as a row. ``omegas``: 1,
    omega, omega^2, ... as a column.
    """

    outer: Mapping[Sines, Ball]
    last: arb_mat
    omegas: arb_mat


@dataclass(frozen=True, eq=False)
class CompiledWaves:
    """A ``WaveSum`` in balls of one precision, its constant angles multiplied into the
    coefficients; its methods are those of ``WaveSum``.

    ``rates``, ``degrees``: d(a/2)/d omega and n of the delay angles. ``exponents``: the alpha_m.
    ``terms``: exponents of the sines of the delay angles, powers, and coefficients of 1, omega,
    omega^2, ...; no two terms agree in both of the first.
    """

    rates: tuple[Ball, ...]
    degrees: tuple[int, ...]
    exponents: tuple[Ball, ...]
    terms: tuple[tuple[Sines, Powers, Sequence[Ball]], ...]

    def value(self, x: Ball) -> Ball:
        """A ball around f at every point of a ball of frequencies."""
        return self.taylor(x, 0)

    def taylor(self, x: Ball, order: int) -> Ball:
        """A ball around f^(n)/n!, n = ``order``, at every point of a ball of frequencies."""
        return self.series(x, order, order + 1)[0]

    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around f^(n)/n!, ``start`` <= n < ``stop``, at every point of a ball of
        frequencies."""
        tick()
        basis, total = self._basis(x), list[Ball]()
        for powers, cofactor in self._cofactors.items():
            if any(powers):
                # By Leibniz' rule a coefficient of a product takes all lower ones of its factors.
                exponent = reduce(add, map(mul, self.exponents, powers))
                power = power_series(x, exponent, stop)
                part = product(cofactor.series(basis, 0, stop), power, start)
            else:
                part = cofactor.series(basis, start, stop)
            total = list(map(add, total, part)) if total else part
        return total

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Balls around f, f' and f''/2 over a ball of frequencies.

        In the formula at the top f^(i)(m)/i! is enclosed at the midpoint, f^(8)/8! over the whole
        ball, wherever xi lies. Taylor's theorem for f' and for f'', of orders 7 and 6, has the
        coefficients that differentiation of this polynomial in h gives, so that the same
        enclosures serve.
        """
        reach = powers_of(box.rad(), _TAYLOR_ORDER + 1)
        row = self.series(box.mid(), 0, _TAYLOR_ORDER)
        row.append(self.taylor(box, _TAYLOR_ORDER))
        slopes = [n * c for n, c in enumerate(row)][1:]
        half_curvatures = [n * c / 2 for n, c in enumerate(slopes)][1:]
        value = range_of(row, reach)
        slope = range_of(slopes, reach)
        half_curvature = range_of(half_curvatures, reach)
        return value, slope, half_curvature

    def cofactor_values(self, x: Ball) -> list[Ball]:
        """Balls around all cofactors A_l at every point of a ball of frequencies."""
        basis = self._basis(x)
        return [cofactor.series(basis, 0, 1)[0] for cofactor in self._cofactors.values()]

    def cofactor_series(self, x: Ball, wanted: Sequence[tuple[Powers, int]]) -> list[Ball]:
        """Balls around A_l^(n)/n! at every point of a ball of frequencies, for each pair (l, n)."""
        basis = self._basis(x)
        coefficients = []
        for powers, n in wanted:
            coefficients += self._cofactors[powers].series(basis, n, n + 1)
        return coefficients

    def cofactor_ranges(self, box: Ball) -> dict[Powers, Ball]:
        """Balls around all cofactors A_l over a ball of frequencies, as in ``over``."""
        reach = powers_of(box.rad(), _TAYLOR_ORDER + 1)
        at_middle = self._basis(box.mid())
        over_box = self._basis(box)
        ranges = {}
        for powers, cofactor in self._cofactors.items():
            row = cofactor.series(at_middle, 0, _TAYLOR_ORDER)
            row += cofactor.series(over_box, _TAYLOR_ORDER, _TAYLOR_ORDER + 1)
            ranges[powers] = range_of(row, reach)
        return ranges

    @property
    def has_clear_coefficient(self) -> bool:
        """True: a coefficient is known not to be 0. False: none is, at this precision."""
        return any(is_clear(x) for _, _, row in self.terms for x in row)

    @cached_property
    def _angles(self) -> list[tuple[Ball, int]]:
        """Rate and degree of the half angles of delays; without any, one of degree 0, as
        ``_Cofactor`` needs a last angle."""
        return list(zip(self.rates, self.degrees, strict=True)) or [(arb(0), 0)]

    @cached_property
    def _width(self) -> int:
        """How many powers 1, omega, omega^2, ... occur in all cofactors together."""
        return max([1, *(len(row) for _, _, row in self.terms)])

    @cached_property
    def _cofactors(self) -> Mapping[Powers, _Cofactor]:
        """The cofactors A_l, by their powers l."""
        groups: dict[Powers, dict[Sines, Sequence[Ball]]] = {}
        for sines, powers, row in self.terms:
            # Without delay angles the one of degree 0 has the exponent 0.
            groups.setdefault(powers, {})[sines or (0,)] = row
        return {
            powers: _Cofactor(self._angles, self._width, terms) for powers, terms in groups.items()
        }

    def _basis(self, x: Ball) -> _Basis:
        """Sines, cosines and powers of omega at a ball of frequencies: computed once for all orders
        and all cofactors."""
        *others, last = [waves_of(rate * x, degree) for rate, degree in self._angles]
        outer: dict[Sines, Ball] = {(): _ONE}
        for waves in others:
            outer = {
                (*sines, k): known * wave
                for sines, known in outer.items()
                for k, wave in enumerate(waves)
            }
        omegas = powers_of(x, self._width)
        return _Basis(outer, arb_mat(1, len(last), last), arb_mat(self._width, 1, omegas))


_Blocks: TypeAlias = Mapping[Sines, arb_mat]
"""Coefficients of a cofactor, or of a derivative of it. The key has the exponents of the sines of
all delay angles but the last; in row k and column m of its matrix stands the coefficient of
sin^k cos^(n - k) omega^m, sine and cosine being those of the last half angle."""


class _Cofactor:
    """A cofactor A_l and its derivatives of all orders, in coefficients of one fixed set of
    functions (``_Basis``).

    A cofactor is a sum over blocks of (outer product) w C v: w the row of sin^k cos^(n - k) of the
    last half angle, C the block's matrix, v the column of powers of omega. With w' = w T and v' =
    S v, matrices of numbers,

        (w C v)' = w (T C + C S) v,

    and the outer product has a derivative of the same kind (``_differentiated``).

    ``angles``: rate d(a/2)/d omega and degree n of each half angle. ``width``: the number of powers
    of omega. ``terms``: coefficients of 1, omega, ..., at most ``width``, by exponents of sines.
    """

    def __init__(
        self, angles: Sequence[tuple[Ball, int]], width: int, terms: Mapping[Sines, Sequence[Ball]]
    ) -> None:
        *self._outer, (rate, degree) = angles
        self._of_waves = _wave_derivative(rate, degree)
        self._of_powers = _power_derivative(width)
        zeros = [_ZERO] * (width * (degree + 1))
        # The entries of each matrix, row by row.
        entries: dict[Sines, list[Ball]] = {}
        for (*others, k), row in terms.items():
            block = entries.setdefault(tuple(others), list(zeros))
            first = k * width
            block[first : first + len(row)] = row
        blocks = {sines: arb_mat(degree + 1, width, block) for sines, block in entries.items()}
        # The n-th is that of the n-th derivative; they are computed when they are asked for.
        self._derivatives: list[_Blocks] = [blocks]

    def series(self, basis: _Basis, start: int, stop: int) -> list[Ball]:
        """The Taylor coefficients of orders ``start`` <= n < ``stop`` where the functions have
        these values."""
        outer, last, omegas = basis
        while len(self._derivatives) < stop:
            self._derivatives.append(self._differentiated(self._derivatives[-1]))
        values = []
        for blocks in self._derivatives[start:stop]:
            # A single delay angle is the common case: there is one block, and no outer product.
            if () in outer:
                total = (last * (blocks[()] * omegas))[0, 0]
            else:
                total = _ZERO
                for sines, block in blocks.items():
                    total = total + outer[sines] * (last * (block * omegas))[0, 0]
            values.append(total)
        # 0! = 1! = 1: orders below 2 need no division.
        if stop <= 2:
            return values
        factors = _inverse_factorials(stop, flint.ctx.prec)
        return list(map(mul, values, factors[start:]))

    def _differentiated(self, blocks: _Blocks) -> _Blocks:
        """The coefficients of the derivative: by the product rule T C + C S for the last angle and
        omega, and two terms for each other angle a with rate r = d(a/2)/d omega,

        d(sin^k cos^(n - k))/d omega = r k sin^(k - 1) cos^(n - k + 1)
        - r (n - k) sin^(k + 1) cos^(n - k - 1).
        """
        total: dict[Sines, arb_mat] = {}
        for sines, block in blocks.items():
            tick()
            parts = [(sines, block * self._of_powers + self._of_waves * block)]
            for i, (rate, degree) in enumerate(self._outer):
                k = sines[i]
                if k:
                    lower = (*sines[:i], k - 1, *sines[i + 1 :])
                    parts.append((lower, block * (rate * k)))
                if k < degree:
                    higher = (*sines[:i], k + 1, *sines[i + 1 :])
                    parts.append((higher, block * (rate * (k - degree))))
            for key, part in parts:
                total[key] = total[key] + part if key in total else part
        return total


@lru_cache(maxsize=64)
def _power_derivative(width: int) -> arb_mat:
    """The matrix S with v' = S v for the column v = (1, omega, omega^2, ...): of integers, so that
    it is exact at any precision."""
    matrix = arb_mat(width, width)
    for n in range(1, width):
        matrix[n, n - 1] = n
    return matrix


def _wave_derivative(rate: Ball, degree: int) -> arb_mat:
    """The matrix T with w' = w T for the row w of sin^k cos^(degree - k), k = 0 ... degree, of a
    half angle with that rate."""
    matrix = arb_mat(degree + 1, degree + 1)
    for k in range(degree):
        matrix[k, k + 1] = rate * (k + 1)
        matrix[k + 1, k] = rate * (k - degree)
    return matrix


# Series and powers


@lru_cache(maxsize=64)
def _inverse_factorials(count: int, bits: int) -> list[Ball]:
    """1/0!, 1/1!, 1/2!, ...: they make derivatives Taylor coefficients."""
    with flint.ctx.workprec(bits):
        return [arb(1) / factorial(n) for n in range(count)]


def powers_of(x: Ball, count: int) -> list[Ball]:
    """The powers 1, x, x^2, ..., ``count`` >= 1 of them."""
    return list(accumulate(repeat(x, count - 1), mul, initial=_ONE))


def waves_of(half: Ball, degree: int) -> list[Ball]:
    """sin^k cos^(degree - k) of a half angle, k = 0 ... degree."""
    sine, cosine = half.sin_cos()
    if degree == 1:
        return [cosine, sine]
    if degree == 2:
        return [cosine**2, sine * cosine, sine**2]
    cosines = powers_of(cosine, degree + 1)
    return list(map(mul, powers_of(sine, degree + 1), reversed(cosines)))


def power_series(x: Ball, exponent: Ball, length: int) -> list[Ball]:
    """The Taylor coefficients binomial(e, n) x^(e - n), n < ``length``, of x^e at every point of a
    ball x > 0; not finite where the ball reaches 0."""
    # Each from the one before: binomial(e, n + 1) = binomial(e, n) (e - n)/(n + 1).
    row = [(x.log() * exponent).exp()]
    inverse = 1 / x if length > 1 else x
    for n in range(length - 1):
        ratio = (exponent - n) / (n + 1)
        row.append(row[-1] * ratio * inverse)
    return row


def product(a: Sequence[Ball], b: Sequence[Ball], start: int = 0) -> list[Ball]:
    """The product of two Taylor series of one length, cut to that length; its coefficients from
    order ``start`` on."""
    # The last coefficient alone is one scalar product, much less than a product of polynomials.
    if start == len(a) - 1:
        return [reduce(add, map(mul, a, reversed(b)))]
    full = arb_poly(a) * arb_poly(b)
    return [full[n] for n in range(start, len(a))]
