"""Values and degree bounds of polynomials at integer points, and the readers of a certificate.

How can a checker compare two rational functions without computer algebra? A function of a scene is
a quotient of polynomials in these variables, in this order (a *layout* of degrees):

0. s, or omega where s = j omega,
1. pi, which is transcendental and so as good as a variable,
2. t = tan(omega tau/2) for each *delay* tau of the certificate's proof, in its order,
3. x + j y = (j omega)^alpha for each *order* alpha of the proof, 0 < alpha < 1: one bound for the
   degrees in x and y together.

Nothing is expanded. Each variable is replaced by an integer, so that a polynomial has a Gaussian
integer a + j b for its value. With it an upper bound of its degree in each variable is computed:
deg(p + q) <= max(deg p, deg q), deg(p q) = deg p + deg q. A polynomial of degree < n_i in each
variable that vanishes on a grid of n_1 x n_2 x ... points is zero (rule 1 of
``FORMAT.md``), so values and bounds decide whether it is.

Begin with ``GaussianValue`` (value and bounds) and ``ChainPoint`` (the integers in place of the
variables, and what s^alpha and exp(-s tau) are there). ``keyed``, ``listed``, ``whole``, ``number``
and the readers after them refuse what the format of certificates does not allow, before anything is
computed with it. Arithmetic is exact throughout; whatever is not proven or not understood raises
``RefusedError``.
"""

import re
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from operator import add
from typing import Any, NamedTuple

# Delays and orders of a proof, together. Each is one more dimension of the grid.
MOST_DELAYS_AND_ORDERS = 4
# s and pi, and what delays and orders bring.
VARIABLES = 2 + MOST_DELAYS_AND_ORDERS
# Bits of a Gaussian integer. A short formula, a power of a power, could have a value of any length.
MOST_BITS = 30_000
# The largest n in s^(n + alpha), of one power in a formula: the degree in s, and with it the grid,
# grows with n.
MOST_POWER = 99
# The largest n in exp(-s n tau), as the degree in the tangent is n.
MOST_MULTIPLE = 64
# Delays, in s, and the denominators of delays and orders lie below this: far beyond any display,
# and so small that the integers of a grid stay short.
LARGEST = 2**100
# The coefficients of a polynomial, and of the powers of pi in one of them: more than scenes need,
# and so few that a value is quick.
MOST_COEFFICIENTS, MOST_POWERS_OF_PI = 300, 100
# A number of the format. Without a bound on its exponent a short text could stand for a number of
# any size.
NUMBER_PATTERN = r"-?[0-9]{1,2000}(/[1-9][0-9]{0,1999}|(\.[0-9]{1,2000})?(E[+-]?[0-9]{1,3})?)"
INTEGER_PATTERN = "-?[0-9]{1,2000}"

# Upper bounds of the degrees in all variables, in the order of the layout above.
Degrees = tuple[int, ...]
# Coefficients of a polynomial in omega, ascending. Each is a polynomial in pi, its integer
# coefficients ascending too.
Polynomial = list[list[int]]


class RefusedError(Exception):
    """The certificate does not prove its claim, or something in it is not understood."""


class UnreadableError(RefusedError):
    """There is nothing to check: a file is missing, the certificate is no JSON, or the scene is no
    TOML."""


def need(condition: object, why: str) -> None:
    """Raise RefusedError with the reason unless the condition holds."""
    if not condition:
        raise RefusedError(why)


# Values of polynomials.


def degree(variable: int, n: int = 1) -> Degrees:
    """The degrees of the n-th power of one variable, given its index in the layout of the module.

    >>> degree(1, 3)
    (0, 3, 0, 0, 0, 0)
    """
    before = (0,) * variable
    after = (0,) * (VARIABLES - 1 - variable)
    return (*before, n, *after)


class GaussianValue(NamedTuple):
    """The value re + j im of a polynomial at an integer point, and upper bounds of its degrees.

    >>> omega = GaussianValue(3, 0, degree(0))
    >>> GaussianValue(0, 2).times(omega).plus(ONE)      # 1 + 2 j omega at omega = 3
    GaussianValue(re=1, im=6, degrees=(1, 0, 0, 0, 0, 0))
    """

    re: int
    im: int = 0
    degrees: Degrees = degree(0, 0)

    def plus(self, x: "GaussianValue", sign: int = 1) -> "GaussianValue":
        """The sum (sign 1) or the difference (sign -1) of this polynomial and x."""
        degrees = tuple(map(max, self.degrees, x.degrees))
        real = self.re + sign * x.re
        imaginary = self.im + sign * x.im
        return GaussianValue(real, imaginary, degrees)

    def times(self, x: "GaussianValue") -> "GaussianValue":
        """The product of this polynomial and x. RefusedError from ``MOST_BITS`` bits on."""
        real = self.re * x.re - self.im * x.im
        imaginary = self.re * x.im + self.im * x.re
        need(real.bit_length() + imaginary.bit_length() < MOST_BITS, "a number is too large")
        degrees = tuple(map(add, self.degrees, x.degrees))
        return GaussianValue(real, imaginary, degrees)

    def power(self, n: int) -> "GaussianValue":
        """The n-th power of this polynomial, n >= 0; the 0-th is 1. Callers bound n: it is at most
        100, the largest exponent of the format."""
        if not n:
            return ONE
        return reduce(GaussianValue.times, [self] * n)

    def conjugate(self) -> "GaussianValue":
        """The complex conjugate: for s = j omega, omega real, a polynomial of the same degrees."""
        return GaussianValue(self.re, -self.im, self.degrees)


# Numerator and denominator. Nothing is divided and no common factor is cancelled: two fractions p/q
# and P/Q are compared by p Q - P q alone (``scene.across``). That would hold for 0/0 and any other
# one, so ``scene.link`` first needs a point at which neither q nor Q is 0: then neither is the
# polynomial 0, whatever divisions made it, and p Q = P q for all values of the variables means that
# both are one function.
Ratio = tuple[GaussianValue, GaussianValue]
ONE = GaussianValue(1)
# The degree of the polynomial 0 is minus infinity: this is below all others, also after the degrees
# of any factors were added to it.
ZERO = GaussianValue(0, 0, (-(10**6),) * VARIABLES)


def combined(sign: str, x: Ratio, y: Ratio) -> Ratio:
    """x + y, x - y, x * y or x / y, by the sign "+", "-", "*" or "/". Of a division by 0 the
    denominator is 0: it is refused where functions are compared."""
    (a, b), (c, d) = x, y
    if sign == "*":
        return a.times(c), b.times(d)
    if sign == "/":
        return a.times(d), b.times(c)
    need(sign in ("+", "-"), "an operation is not understood")
    top = a.times(d).plus(c.times(b), 1 if sign == "+" else -1)
    return top, b.times(d)


class ChainPoint(NamedTuple):
    """The point at which the dynamics of a scene are computed.

    ``s`` : its value there over 1, as a fraction is raised to negative powers too. ``pi`` : the
    integer in place of pi. ``delays``, ``orders`` : those of the proof. ``tangents_and_powers`` :
    for each delay an integer, in place of its tangent t, then for each order a pair of integers, in
    place of x and y; so the entry of a variable is at its index in the layout less 2.
    """

    s: Ratio
    pi: int
    delays: tuple[Fraction, ...] = ()
    orders: tuple[Fraction, ...] = ()
    tangents_and_powers: tuple[Any, ...] = ()

    def raised(self, exponent: Fraction) -> Ratio:
        """s^exponent, as s^n (x + j y) with n whole and 0 <= exponent - n < 1.

        RefusedError where exponent - n is neither 0 nor one of the orders, or |n| is too large.
        """
        n, order = int(exponent // 1), exponent % 1
        is_in_proof = not order or order in self.orders
        need(abs(n) <= MOST_POWER and is_in_proof, "a power of s: the proof has no such order")
        base = self.s if n >= 0 else self.s[::-1]
        top, bottom = (x.power(abs(n)) for x in base)
        # s^alpha itself is no Gaussian integer, and no root is taken: x and y are free variables
        # here. What vanishes for all of their values does so for those of s^alpha.
        fractional = ONE
        if order:
            i = len(self.delays) + self.orders.index(order)
            x, y = self.tangents_and_powers[i]
            fractional = GaussianValue(x, y, degree(2 + i))
        return top.times(fractional), bottom

    def delayed(self, lag: Fraction) -> GaussianValue:
        """u = (1 - j t)^n, with which exp(-s lag) = u/conj(u), for s = j omega and lag = n tau.

        Here tau is the first delay of the proof that divides the lag, and t = tan(omega tau/2), so
        that exp(-j omega tau) = (1 - j t)/(1 + j t). RefusedError for a negative lag, where no
        delay divides it, and where n is too large.
        """
        if not lag:
            return ONE
        divisors = [i for i, tau in enumerate(self.delays) if lag % tau == 0]
        n = lag / self.delays[divisors[0]] if divisors else Fraction(0)
        need(0 < n <= MOST_MULTIPLE, "a delay: the proof has none that it is a multiple of")
        i = divisors[0]
        tangent = self.tangents_and_powers[i]
        return GaussianValue(1, -tangent, degree(2 + i)).power(int(n))


# Objects, lists and numbers of a certificate: each is returned as read, or refused.


def keyed(x: Any, *keys: str) -> list[Any]:
    """The values of an object that has these keys and no other, in the order of the keys."""
    good = isinstance(x, dict) and x.keys() == set(keys)
    need(good, f"expected an object with the keys {', '.join(keys)}")
    return [x[key] for key in keys]


def listed(x: Any, most: int, least: int = 0) -> list[Any]:
    """A list of ``least`` to ``most`` entries, which are not examined."""
    good = isinstance(x, list) and least <= len(x) <= most
    need(good, f"expected a list of {least} to {most} entries")
    return list(x)


def whole(x: Any, low: int, high: int) -> int:
    """A whole number of JSON, low <= x <= high."""
    # JSON's true is an int to Python, and no number of the format.
    good = type(x) is int and low <= x <= high
    need(good, f"expected a whole number from {low} to {high}")
    return int(x)


def number(x: Any) -> Fraction:
    """A number of the format, which is a text, exactly.

    >>> number("-2.50E-1"), number("1/3")
    (Fraction(-1, 4), Fraction(1, 3))
    """
    good = isinstance(x, str) and re.fullmatch(NUMBER_PATTERN, x)
    need(good, "a number is not written as one")
    return Fraction(x)


def numbers(x: Any, most: int, least: int = 0) -> list[Fraction]:
    """A list of ``least`` to ``most`` numbers, strictly ascending."""
    row = [number(y) for y in listed(x, most, least)]
    ascends = all(a < b for a, b in pairwise(row))
    need(ascends, "numbers do not ascend")
    return row


def delays_and_orders(delays: Any, orders: Any) -> list[tuple[Fraction, ...]]:
    """The delays, in s, and the orders of a proof: all positive, and orders below 1."""
    lags = tuple(number(x) for x in listed(delays, MOST_DELAYS_AND_ORDERS))
    alphas = tuple(number(x) for x in listed(orders, MOST_DELAYS_AND_ORDERS))
    every = lags + alphas
    in_range = all(0 < x < LARGEST for x in every)
    are_below_1 = all(x < 1 for x in alphas)
    are_short = all(x.denominator < LARGEST for x in every)
    need(
        in_range and are_below_1 and are_short and len(every) <= MOST_DELAYS_AND_ORDERS,
        "delays or orders are not positive, too large, or too many",
    )
    return [lags, alphas]


def polynomial(x: Any) -> Polynomial:
    """A polynomial of the format: coefficients ascending, each a list of integers (texts) at
    ascending powers of pi; its degree is the length less 1."""
    rows = [listed(row, MOST_POWERS_OF_PI, 1) for row in listed(x, MOST_COEFFICIENTS, 1)]
    every = [n for row in rows for n in row]
    are_texts = all(isinstance(n, str) for n in every)
    good = are_texts and all(re.fullmatch(INTEGER_PATTERN, n) for n in every)
    # As pi is transcendental (Lindemann), a leading coefficient with any integer that is not 0 is
    # not 0 itself. So the degree is exactly the length less 1, as rules 2 and 5 need it.
    need(
        good and any(n.strip("-0") for n in rows[-1]),
        "a polynomial is not one, or its leading coefficient is 0",
    )
    return [[int(n) for n in row] for row in rows]
