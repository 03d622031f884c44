"""Rules 7 and 8: signs of factors with sines, cosines and powers of omega.

Such a factor has no finite list of coefficients whose signs decide, so it is replaced by its
Taylor polynomial on the cell, omega = m + h v with -1 <= v <= 1, and a bound of everything that is
lost: f = sum_{n<N} c_n v^n + r, with Lagrange's remainder and all errors of rounding in r. A sign
is proven where the polynomial's Bernstein coefficients are larger than r in size. What the bounds
leave undecided is refused.

Numbers are integers that count parts of one, 2^-280, with bounds of their errors in the same parts;
nothing here is a float.

A *factor* is one of the factors of the proof's products, a *cell* an interval [a, b] of omega, a
*certificate* the file with the claim and its proof. A *series* is a pair: the coefficients c_n, and
a bound of the sum of all their errors. Begin with ``WaveFactor.signs``, then ``model``; the
arithmetic they need stands before them.
"""

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from functools import cache, cached_property, lru_cache, partial, reduce
from itertools import accumulate, groupby, repeat, zip_longest
from math import factorial, lcm
from operator import mul
from typing import Any

from haptisym_check.polynomials import PI, OmegaFactor, moved, pairs
from haptisym_check.scene import Numbers
from haptisym_check.values import Polynomial, keyed, listed, need, polynomial, whole

# Numbers with bounds of their errors (rules 7 and 8): sines, cosines and powers, all in parts of
# one.

# 280 bits are 84 decimals, more than the 80 of rule 7. The guard bits take what up to 50 doublings
# of an angle do to an error: a factor of 2^50.
BITS, GUARD = 280, 64
SCALE, FINER = 1 << BITS, 1 << (BITS + GUARD)
Ball = tuple[int, int]
"""All numbers within a radius of a middle."""


def parts(x: Fraction) -> int:
    """A number to one part of one."""
    return (x.numerator << BITS) // x.denominator


def circle(x: Fraction) -> list[int]:
    """cos x, -sin x, -cos x, sin x, x >= 0, to two parts of one: Taylor's sums at x/2^n < 1/2, and
    n times twice the angle.

    In this order they are the cosine and its derivatives. Each doubling doubles errors, as squares
    of complex numbers of size one do.
    """
    n = (2 * x.numerator // x.denominator).bit_length()
    need(n < 50, "an angle is too large")
    y = x.numerator * FINER // (x.denominator << n)
    terms = [FINER]
    term = FINER
    for k in range(1, 64):
        term = term * y // (FINER * k)
        terms.append(term)
    # The first term that is left out is below 2^-64/64!, less than one part of FINER.
    cosine = sum(terms[::4]) - sum(terms[2::4])
    sine = sum(terms[1::4]) - sum(terms[3::4])
    shift = BITS + GUARD
    for _ in range(n):
        doubled = cosine * cosine - sine * sine
        sine = 2 * cosine * sine >> shift
        cosine = doubled >> shift
    derivatives = cosine, -sine, -cosine, sine
    return [x >> GUARD for x in derivatives]


def artanh(x: Fraction) -> int:
    """The sum of x^n/n, n odd, |x| <= 1/3, to a thousand parts of FINER."""
    y = int(x * FINER)
    square = y * y // FINER
    power = y
    total = 0
    for n in range(1, 221, 2):
        total += power // n
        power = power * square // FINER
    return total


LN_2 = 2 * artanh(Fraction(1, 3))


def power(x: Fraction, alpha: Fraction) -> Ball:
    """x^alpha = exp(alpha ln x), x > 0 and 0 < alpha < 1; ln (1 + y)/(1 - y) = 2 artanh y."""
    n = x.numerator.bit_length() - x.denominator.bit_length()
    need(x > 0 and abs(n) < 10**5, "a number is too large, or too small")
    m = x / Fraction(2) ** n  # between 1/2 and 2
    logarithm = 2 * artanh((m - 1) / (m + 1))
    logarithm += n * LN_2
    exponent = logarithm * alpha.numerator // alpha.denominator
    k, y = divmod(exponent, LN_2)
    # Errors of the logarithm: at most 10^5 times those of LN_2, some thousand parts of FINER, once
    # in n and once in k. A radius of 10^12 of these parts is ample, and still 2^-304 of the value.
    term = FINER
    total = term
    # exp y = 1 + y + y^2/2 + ...: each term is the one before it times y/i.
    for i in range(1, 80):
        term = term * y // (FINER * i)
        total += term
    up = max(k, 0)
    down = GUARD + max(-k, 0)
    radius = 10**12 << up >> down
    return total << up >> down, radius + 2  # 2^k exp y


@cache
def power_of_pi(n: int) -> Ball:
    """pi^n, from the rational bounds of pi."""
    low, high = (Fraction(*bound) ** n for bound in PI)
    middle = parts(low)
    return middle, parts(high) - middle + 1


def coefficient(i: int, row: list[int]) -> Ball:
    """The coefficient of pi^i in a polynomial in pi; 0 beyond its degree."""
    c = row[i] if i < len(row) else 0
    return c * SCALE, 0


def in_pi(row: list[int]) -> Ball:
    """The value of a polynomial in pi."""
    middle, radius = 0, 0
    for n, c in enumerate(row):
        value, error = power_of_pi(n)
        middle += c * value
        radius += abs(c) * error
    return middle, radius


# Taylor's sums with sines, cosines and powers of omega (rules 7 and 8).

# N of rule 7: all series end with the coefficient of v^14, which bounds the remainder.
ORDER = 14
Series = tuple[list[int], int]
"""Coefficients of v^n, n from 0 to ORDER, in parts of one, and a bound of the sum of all their
errors."""
Exponents = tuple[int, ...]
Terms = list[tuple[Exponents, list[Ball]]]
"""Products of powers (see ``SeriesPoint.product``), each with the coefficients of a polynomial in
omega."""


def times(p: Series, q: Series) -> Series:
    """Leibniz: the coefficients of a product; those of p may be fewer."""
    a, r = p
    b, s = q
    # |p q - a b| <= |p| |q - b| + |p - a| |b|; each coefficient loses up to one part by its shift.
    size_of_p = sum(map(abs, a)) + r
    lost = size_of_p * s
    lost += r * sum(map(abs, b))
    count = len(b)
    row = []
    for n in range(count):
        c = sum(map(mul, a, b[n::-1]))
        row.append(c >> BITS)
    return row, (lost >> BITS) + 1 + count


def plus(p: Series, q: Series) -> Series:
    """The coefficients of a sum."""
    a, r = p
    b, s = q
    row = [x + y for x, y in zip(a, b, strict=True)]
    return row, r + s


def waves(turns: list[int], ahead: Fraction, count: int) -> list[Series]:
    """The series of the sine and the cosine of an angle + ahead v, from ``turns``, the ``circle``
    of that angle, or four times the largest size, 1."""
    x, y = ahead.as_integer_ratio()
    weights = []
    for n in range(count):
        divisor = y**n * factorial(n)
        weights.append((x**n << BITS) // divisor)
    # A derivative is off by 2 parts, times the sum of the weights; each weight is off by one part,
    # times a derivative of at most 1, and each product loses one more by its shift.
    lost = 2 * (sum(weights) >> BITS) + 2
    lost += 2 * count
    # The n-th derivative of the cosine is entry n of its circle, that of the sine entry n + 3.
    series = []
    for i in (3, 0):
        row = []
        for n, weight in enumerate(weights):
            derivative = turns[(n + i) % 4]
            row.append(derivative * weight >> BITS)
        series.append((row, lost))
    return series


def binomial(alpha: Fraction, low: Fraction, high: Fraction, step: Fraction, count: int) -> Series:
    """The series of (omega + step v)^alpha at a number, or of its largest sizes from low to high;
    where low is 0 it is the constant step^alpha."""
    ahead = step / low if low else Fraction(0)
    # (1 + ahead v)^alpha: each binomial coefficient is the one before it times (alpha - n + 1)/n.
    weights = [Fraction(1)]
    for n in range(1, count):
        factor = (alpha - n + 1) * ahead / n
        weights.append(weights[-1] * factor)
    # As 0 < alpha < 1, omega^alpha is largest at the high end, and all of its derivatives, powers
    # with negative exponents, are largest in size at the low end.
    first, lost = power(high if low else step, alpha)
    size, more = power(low or step, alpha)
    later = [size * w.numerator // w.denominator for w in weights[1:]]
    if low < high:
        later = [abs(c) for c in later]
    total = sum(map(abs, weights))
    errors = lost + int(more * total) + 1 + count
    return [first, *later], errors


class SeriesPoint:
    """Powers of omega, sines, cosines, Re and Im of (j omega)^alpha, as series with the step h: at
    a number, or from low to high, where coefficients are the largest sizes of theirs.

    Where low is 0 the last two are those of (j h)^alpha: (j omega)^alpha is no power series there,
    and the factor (omega/h)^alpha = v^alpha is taken out.
    """

    def __init__(
        self, delays: Numbers, orders: Numbers, low: Fraction, high: Fraction, step: Fraction
    ) -> None:
        # Without a step, for the value at a point, the constant term is all that is needed.
        count = ORDER + 1 if step else 1
        rest = [0] * (count - 1)
        # omega = high + step v, high being the place itself where low = high.
        omega = [parts(high), parts(step)][:count]
        self.own: list[Series] = [(omega, 2)]
        for tau in delays:
            rate = tau / 2
            # Over a cell no sine or cosine is larger than 1.
            turns = [SCALE] * 4 if low < high else circle(high * rate)
            self.own += waves(turns, step * rate, count)
        lower_pi = Fraction(*PI[0])
        for alpha in orders:
            size = binomial(alpha, low, high, step, count)
            # j^alpha = cos(alpha pi/2) + j sin(alpha pi/2). The lower bound of pi is off by
            # 10^-100, less than the part of one by which 3 exceeds the error of ``circle``.
            cosine, _, _, sine = circle(alpha * lower_pi / 2)
            self.own.append(times(size, ([cosine, *rest], 3)))
            self.own.append(times(size, ([sine, *rest], 3)))
        self.none: Exponents = (0,) * len(self.own)
        one = [SCALE, *rest]
        self.known: dict[Exponents, Series] = {self.none: (one, 0)}
        self.tables: dict[int, tuple[Any, ...]] = {}

    def product(self, powers: Exponents) -> Series:
        """The series of a product of omega (first), a sine, its cosine, the next sine, ..., a real
        part, its imaginary part, ..., to these powers."""
        if powers not in self.known:
            # One of the last function that stands in it, times the rest.
            i = max(i for i, n in enumerate(powers) if n)
            rest = [*powers]
            rest[i] -= 1
            series = self.product(tuple(rest))
            self.known[powers] = times(self.own[i], series)
        return self.known[powers]

    def polynomial(self, p: list[Ball]) -> Series:
        """The series of a polynomial in omega with these coefficients."""
        if len(p) not in self.tables:
            others = self.none[1:]
            powers = [self.product((n, *others)) for n in range(len(p))]
            rows, errors = zip(*powers, strict=True)
            sizes = []
            for row, error in powers:
                size = sum(map(abs, row))
                sizes.append(size + error)
            # By columns, the powers at one v^n, as the coefficients of a sum need them.
            columns = list(zip(*rows, strict=True))
            self.tables[len(p)] = columns, errors, sizes
        columns, errors, sizes = self.tables[len(p)]
        middles, radii = zip(*p, strict=True)
        # An error of a power times its coefficient, and one of a coefficient times its power.
        lost = sum(map(mul, map(abs, middles), errors))
        lost += sum(map(mul, radii, sizes))
        series = [sum(map(mul, middles, x)) >> BITS for x in columns]
        return series, (lost >> BITS) + 1 + len(columns)

    def total(self, terms: Terms) -> Series:
        """The series of the sum of terms."""
        # Exponents beyond those of this place are cut off: ``beginnings`` asks for a place without
        # orders, and treats their powers apart.
        count = len(self.own)
        products = []
        for powers, p in terms:
            beside = self.product(powers[:count])
            products.append(times(self.polynomial(p), beside))
        return reduce(plus, products)


# All factors are examined in one cell before the next: they share its powers, sines and cosines.
place = lru_cache(maxsize=8)(SeriesPoint)


# Rules 7 and 8: signs of factors with sines, cosines and powers of omega, from Taylor's sums and
# his remainder.


class WaveFactor(OmegaFactor):
    """A sum of polynomials in omega times powers of sines and cosines to a common degree, and of Re
    and Im of (j omega)^alpha.

    ``waves`` are these degrees, one for each delay; a term is the polynomial times
    sin^k cos^(n - k) of omega tau/2, and times x^a y^b for each order.
    """

    def __init__(self, x: Any, delays: Numbers, orders: Numbers = ()) -> None:
        waves, terms = keyed(x, "waves", "terms")
        # Limits of the format: 300 terms, and 40 for each exponent.
        n = len(delays)
        rows = [listed(row, 2, 2) for row in listed(terms, 300, 1)]
        self.delays = delays
        self.orders = orders
        given_waves = listed(waves, n, n)
        self.waves = tuple(whole(k, 0, 40) for k in given_waves)
        most_in_powers = [40] * (2 * len(orders))
        most = [*self.waves, *most_in_powers]
        exponents = []
        for row, _ in rows:
            given = listed(row, len(most), len(most))
            exponents.append(tuple(map(whole, given, repeat(0), most)))
        coefficients = [polynomial(p) for _, p in rows]
        self.terms = list(zip(exponents, coefficients, strict=True))
        need(len(set(exponents)) == len(rows), "a term stands twice in a factor")
        self.powers = any(any(x[n:]) for x in exponents)
        bits = 0
        for one in coefficients:
            for row in one:
                longest = max(c.bit_length() for c in row)
                bits += longest + len(row) + 40
        others = sum(self.degrees[2:])
        per_term = 500 * (1 + others)
        self.cost = (bits + len(rows) * per_term) * 2
        need(self.cost < 10**7, "a factor is too large")
        self.all = self.numbers(self.terms)

    def raised(self, term: tuple[Exponents, Polynomial]) -> Exponents:
        """A term's exponents of Re and Im of powers."""
        exponents, _ = term
        return exponents[len(self.delays) :]

    def numbers(self, terms: list[Any], number: Callable[[list[int]], Ball] = in_pi) -> Terms:
        """The terms for a ``SeriesPoint``: exponents of cosines written out, and each coefficient,
        a polynomial in pi, replaced by what ``number`` makes of it."""
        numbered = []
        for exponents, p in terms:
            # The power 0 of omega comes first: omega stands in the polynomial.
            powers = [0]
            for sine, most in zip(exponents, self.waves, strict=False):
                powers += sine, most - sine
            powers += exponents[len(self.waves) :]
            numbered.append((tuple(powers), list(map(number, p))))
        return numbered

    def sizes(self, terms: Terms) -> Terms:
        """Terms that bound the sizes of these, with cosines alone: over a cell sines and cosines
        have the same largest sizes."""
        # So all terms that differ in their sines only become one, with one product.
        cosines = [x for n in self.waves for x in (0, n)]
        bounds: dict[Exponents, list[int]] = {}
        for powers, p in terms:
            in_powers = powers[1 + len(cosines) :]
            key = (0, *cosines, *in_powers)
            before = bounds.get(key, [])
            largest = [abs(middle) + radius for middle, radius in p]
            pairs = zip_longest(before, largest, fillvalue=0)
            bounds[key] = [x + y for x, y in pairs]
        # As balls without a radius.
        terms_of_sizes = []
        for key, row in bounds.items():
            terms_of_sizes.append((key, [(x, 0) for x in row]))
        return terms_of_sizes

    def model(self, terms: Terms, a: Fraction, b: Fraction) -> Series:
        """All c_n, n < N, and what the sum of c_n v^n, v from -1 to 1 (0 to 1 from 0 on), is off
        theirs by at most (Lagrange)."""
        middle = (a + b) / 2 if a else a
        step = b - middle
        at_middle = place(self.delays, self.orders, middle, middle, step)
        in_cell = place(self.delays, self.orders, a, b, step)
        # Lagrange: |f - sum_{n<N} c_n v^n| is at most the N-th coefficient somewhere in the cell,
        # which the series of largest sizes bounds. The one at the middle is dropped.
        row, lost = at_middle.total(terms)
        largest, more = in_cell.total(self.sizes(terms))
        remainder = largest[-1] + more
        return row[:-1], lost + remainder

    @cached_property
    def beginnings(self) -> list[tuple[Fraction, Terms, list[bool]]]:
        """The terms with each power of omega that is not whole, and which of Taylor's coefficients
        are not zero beside it at 0.

        With a step that makes angles multiples of N! coefficients are whole numbers; each power of
        pi in them is looked at alone.
        """
        # (tau step/2)^n/n! is then an integer for all n <= N: the series has no error of rounding,
        # and a zero is exact. A zero must be one in every power of pi, as pi is transcendental.
        denominators = [tau.denominator for tau in self.delays]
        step = Fraction(2 * factorial(ORDER) * lcm(*denominators))
        zero = Fraction(0)
        origin = place(self.delays, (), zero, zero, step)
        beginnings = []
        by_powers = sorted(self.terms, key=self.raised)
        for powers, rows in groupby(by_powers, self.raised):
            terms = list(rows)
            width = max(len(row) for _, p in terms for row in p)
            # For each power of pi the series in which a coefficient is its part at that power.
            each = []
            for i in range(width):
                part = self.numbers(terms, partial(coefficient, i))
                row, _ = origin.total(part)
                each.append(row[:-1])
            columns = zip(*each, strict=True)
            nonzero = [any(column) for column in columns]
            # Re and Im of a power have the same order at 0.
            exponent = zero
            for alpha, exponents in zip(self.orders, pairs(powers), strict=True):
                exponent += alpha * sum(exponents)
            # The last coefficient is somewhere in the cell, not at 0, and never known to be zero.
            beginnings.append((exponent, self.numbers(terms), [*nonzero, True]))
        return beginnings

    def signs(self, a: Fraction, b: Fraction) -> tuple[Fraction | int, list[int]]:
        """The order of the zero at a, and one sign for the whole cell, or one just above a and one
        just below b, with at most one zero between; refused where neither is proven."""
        if not a:
            return self.signs_from_0(b)
        row, lost = self.model(self.all, a, b)
        if sign := side(row, lost):
            return 0, [sign]
        # A derivative of one sign makes the factor monotonic: the signs at both ends tell whether
        # there is a zero. N times the error bounds what differentiation does to the errors.
        derivative = [n * c for n, c in enumerate(row)]
        monotonic = side(derivative[1:], ORDER * lost)
        need(monotonic, "a sign stays open")
        even = sum(row[::2])
        odd = sum(row[1::2])
        # The signs of the values at v = -1 and at v = 1.
        at_a = strict(even - odd, lost)
        at_b = strict(even + odd, lost)
        return 0, [at_a, at_b]

    def signs_from_0(self, b: Fraction) -> tuple[Fraction | int, list[int]]:
        """A sum of c v^e, v from 0 to 1, has one sign if all of its partial sums have, from the
        lowest e on (Abel)."""
        total, lost = Counter[Fraction](), 0
        for exponent, terms, nonzero in self.beginnings:
            row, more = self.model(terms, Fraction(0), b)
            lost += more
            # A 0 stands for the N-th coefficient, which is in ``lost``: its partial sum counts too.
            for n, c in enumerate([*row, 0]):
                if nonzero[n]:
                    total[exponent + n] += c
        ascending = [total[e] for e in sorted(total)]
        signs = [strict(x, lost) for x in accumulate(ascending)]
        need(len(set(signs)) == 1, "a sign stays open")
        return min(total), signs[:1]

    def sign(self, x: Fraction) -> int:
        """The sign of its value at a rational number; refused where its bounds contain 0."""
        at_x = place(self.delays, self.orders, x, x, Fraction(0))
        [value], lost = at_x.total(self.all)
        return strict(value, lost)


@cache
def bernstein(count: int) -> list[tuple[int, ...]]:
    """For each of Bernstein's coefficients on [-1, 1] the weights of 1, v, v^2, ... in it, all
    times the coefficient of (1 + u)^n, which is the weight of 1 and begins the row."""
    rows = []
    for n in range(count):
        unit = [0] * count
        unit[n] = 1
        rows.append(moved(unit, (-1, 1), (1, 1)))
    return list(zip(*rows, strict=True))


def side(row: list[int], lost: int) -> int:
    """The sign for all v from -1 to 1, if Bernstein's coefficients show it; 0 if they do not."""
    # A polynomial lies between the least and the largest of its Bernstein coefficients. They are
    # times binomial coefficients here, and so is the error.
    coefficients = []
    for weights in bernstein(len(row)):
        value = sum(map(mul, row, weights))
        coefficients.append((value, lost * weights[0]))
    positive = all(x > error for x, error in coefficients)
    negative = all(x < -error for x, error in coefficients)
    return positive - negative


def strict(x: int, lost: int) -> int:
    """The sign of a number that is known up to an error; refused where it may be 0."""
    need(abs(x) > lost, "a sign stays open")
    return 1 if x > 0 else -1


def polynomial_factor(x: Any, delays: Numbers = (), orders: Numbers = ()) -> OmegaFactor:
    """A factor without sines and powers."""
    step, rows = keyed(x, "step", "polynomial")
    coefficients = polynomial(rows)
    return OmegaFactor(coefficients, whole(step, 1, 2), len(delays), len(orders))


def factor_of(x: Any, delays: Numbers, orders: Numbers) -> OmegaFactor:
    """A factor of a proof, of either kind."""
    if isinstance(x, dict) and "waves" in x:
        return WaveFactor(x, delays, orders)
    return polynomial_factor(x, delays, orders)
