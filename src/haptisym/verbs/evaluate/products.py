"""Real functions as products of polynomials with whole coefficients, as a certificate writes them
(haptisym_check/FORMAT.md).

A function is ``number * product of factor^exponent``. A factor is a polynomial in omega (or s) and
pi; where there are delays, one in sine and cosine of omega tau/2 as well: the tangents in which a
ring has delays are made homogeneous, and what is missing to equal powers is a power of the cosine.
Powers s^alpha are written as real and imaginary part of (j omega)^alpha, two independent variables,
where a ring has modulus and angle: for that a distortion is put on another axis first. The signs of
factors are decided by the checker's own objects (``certificate``), so that what is written is what
is accepted. ``products`` is where to begin reading.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

from sympy import Expr, Rational, Symbol

from haptisym.kernel.axis import Axis, ComplexPolynomial
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.model.distortion import Distortion
from haptisym_check.delayterms import factor_of
from haptisym_check.polynomials import OmegaFactor

_LAST = "\U0010ffff"
"""Symbols are sorted by their names: no other one stands behind those with this."""


class RectangularAxis(Axis):
    """Real functions in omega, pi, tan(omega tau/2) and two independent variables for each power:
    its real and imaginary part."""

    def __init__(
        self, symbols: Sequence[Symbol], lags: Sequence[Expr], powers: Sequence[Expr], *, j: bool
    ) -> None:
        names = [Symbol(f"{_LAST}{i:02}{part}") for i in range(len(powers)) for part in "ab"]
        super().__init__([*symbols, *names], lags, (), j=j)
        self.powers = tuple(powers)
        self._inner = Ring([*symbols, *names], lags, (), j=j)
        self._start = 2 + len(symbols)

    def parts(self, polynomials: Sequence[Polynomial]) -> list[ComplexPolynomial]:
        split = [self._by_powers(p) for p in polynomials]
        # all coefficients in one call, which multiplies all of them by the same factor
        found = iter(super().parts([q for row in split for q in row.values()]))
        return [self._joined([*row], found) for row in split]

    def _by_powers(self, polynomial: Polynomial) -> dict[tuple[int, ...], Polynomial]:
        """The coefficient of each product of powers s^alpha, by the exponents of these.

        The dynamics' variables are s, pi, symbols, delays, powers and j; the coefficient's have the
        real and imaginary parts of powers behind the symbols, and no powers.
        """
        behind_symbols = self._start
        behind_delays = behind_symbols + self.delays
        behind_powers = behind_delays + len(self.powers)
        no_parts = [0] * (2 * len(self.powers))
        rows = dict[tuple[int, ...], dict[tuple[int, ...], object]]()
        for exponents, value in polynomial.to_dict().items():
            all_of_them = tuple(map(int, exponents))
            symbols = all_of_them[:behind_symbols]
            delays = all_of_them[behind_symbols:behind_delays]
            powers = all_of_them[behind_delays:behind_powers]
            rest = all_of_them[behind_powers:]
            rows.setdefault(powers, {})[(*symbols, *no_parts, *delays, *rest)] = value
        return {powers: self._inner.context.from_dict(row) for powers, row in rows.items()}

    def _joined(
        self, powers: Sequence[tuple[int, ...]], found: Iterator[ComplexPolynomial]
    ) -> ComplexPolynomial:
        """The sum of parts times their powers (x + j y)^n."""
        gens, real, imag = self.context.gens(), self.constant(0), self.constant(0)
        # ``found`` is shared by all polynomials of a call: this one takes as many as it has powers
        for exponents, (x, y) in zip(powers, found, strict=False):
            for i, n in enumerate(exponents):
                place = self._start + 2 * i
                a, b = gens[place : place + 2]
                for _ in range(n):
                    x, y = x * a - y * b, x * b + y * a
            real, imag = real + x, imag + y
        return real, imag


class RectangularRing(Ring):
    """A ring of dynamics whose real functions are on a rectangular axis."""

    @classmethod
    def like(cls, ring: Ring) -> RectangularRing:
        """The ring with the same variables as another one."""
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


PI = 1  # the place of pi among what a polynomial is in
_MOST, _MOST_TERMS = 40, 300
_MOST_OTHERS, _LARGEST = 4, 2**100
Coefficients: TypeAlias = dict[tuple[int, int], int]
"""By the powers of the variable and of pi, or of what takes its place."""
Told: TypeAlias = list[tuple[str, int]]
"""Factors as a certificate writes them, as JSON, with their exponents."""

NOT_RATIONAL = (
    "a certificate needs a rational scene: this one has a delay, a hold or a fractional "
    "power of s, "
    "so that its functions are no quotients of polynomials"
)
BESIDE_PI = (
    "a certificate with a free parameter needs a scene without pi, in formulas too: write "
    "frequencies in rad/s, not in Hz"
)
NO_ROOM = (
    f"a certificate of a scene with delays or powers of s has room for {_MOST_OTHERS} delays "
    f"that are no multiples of each "
    "other and orders together, each a rational number (a delay in seconds) of at most 30 digits"
)


def _rows(coefficients: Mapping[tuple[int, int], int]) -> list[list[str]]:
    """The coefficients as a certificate has them: rows ascending in the variable, each ascending in
    pi."""
    degree = max((n for n, _ in coefficients), default=0)
    rows: list[dict[int, int]] = [{} for _ in range(degree + 1)]
    for (n, q), value in coefficients.items():
        rows[n][q] = value
    return [[str(row.get(q, 0)) for q in range(max(row, default=0) + 1)] for row in rows]


@dataclass
class Factors:
    """The factors of some functions, each of them once, and the functions as products of them.

    ``delays`` : tau of the half angles omega tau/2, the longest first, ``orders`` : of powers;
    ``second`` : the place in the ring of what stands beside the variable; ``in_square`` : whether
    factors that are even are written in the square of the variable.
    """

    delays: tuple[Fraction, ...] = ()
    orders: tuple[Fraction, ...] = ()
    second: int = PI
    in_square: bool = False
    listed: dict[str, int] = field(default_factory=dict)
    known: list[tuple[Polynomial, tuple[Rational, Told]]] = field(default_factory=list)

    def quotient(self, ring: PolynomialRing, top: Polynomial, bottom: Polynomial) -> dict[str, Any]:
        """``number * product of factor^exponent`` of a quotient of polynomials."""
        if top.is_zero():
            return {"number": "0", "powers": []}
        number, exponents = Rational(1), Counter[str]()
        for polynomial, sign in ((top, 1), (bottom, -1)):
            unit, factors = self._taken(ring, polynomial)
            number *= unit**sign
            for factor, n in factors:
                exponents[factor] += sign * n
        powers = {
            self.listed.setdefault(factor, len(self.listed)): n
            for factor, n in exponents.items()
            if n
        }
        return {"number": str(number), "powers": [list(x) for x in sorted(powers.items())]}

    def _taken(self, ring: PolynomialRing, polynomial: Polynomial) -> tuple[Rational, Told]:
        """As ``_factors``, but each polynomial is factored once."""
        # polynomials have no hash: a list, which is short
        found = next((taken for other, taken in self.known if other == polynomial), None)
        if found is None:
            found = self._factors(ring, polynomial)
            self.known.append((polynomial, found))
        return found

    def _factors(self, ring: PolynomialRing, polynomial: Polynomial) -> tuple[Rational, Told]:
        """A polynomial as a number times factors: those with tangents made homogeneous, with powers
        of the cosines that this brings in."""
        if not (self.delays or self.orders):
            number, found = ring.factors(polynomial, in_square=self.in_square)
            return number, [(self._plain(factor), n) for factor, n in found]
        assert isinstance(ring, Axis)
        number, found = ring.factors(ring.without_circles(polynomial)[0], in_square=False)
        first = ring.size - 2 * len(self.orders)
        written = [
            (self._waved(x, first) if any(x.degrees()[first:]) else self._plain(x), n)
            for x, n in found
        ]
        # A polynomial of degree n in tan x is one in sin x and cos x over cos^n x: the degrees of
        # the whole one, not those of its factors. The ring has its delays the other way round.
        degrees = polynomial.degrees()[ring.size : ring.size + len(self.delays)]
        turning = [int(n) for n in degrees][::-1]
        nowhere = [0] * (len(self.delays) + 2 * len(self.orders))
        # the factor cos(omega tau/2) of each delay
        for i, n in enumerate(turning):
            alone = {
                "waves": [int(k == i) for k in range(len(turning))],
                "terms": [[nowhere, [["1"]]]],
            }
            written += [(json.dumps(alone), -n)] if n else []
        return number, written

    def _plain(self, factor: Polynomial) -> str:
        """The JSON of a factor that is a polynomial in the variable and one more, such as pi."""
        coefficients: Coefficients = {}
        for powers, value in factor.to_dict().items():
            self._need_alone([int(n) for n in powers])
            coefficients[int(powers[0]), int(powers[self.second])] = int(value.p)
        even = self.in_square and not any(n % 2 for n, _ in coefficients)
        if even:
            coefficients = {(n // 2, q): x for (n, q), x in coefficients.items()}
        return json.dumps({"step": 2 if even else 1, "polynomial": _rows(coefficients)})

    def _waved(self, factor: Polynomial, first: int) -> str:
        """A polynomial made homogeneous in cosine and sine; tangents, the last one's first, stand
        behind Re and Im of powers."""
        degrees = [int(n) for n in factor.degrees()]
        self._need_alone(degrees[:first])
        raised = slice(first, first + 2 * len(self.orders))
        places = slice(raised.stop, raised.stop + len(self.delays))
        if max(degrees[places], default=0) > _MOST:
            raise SceneError(
                f"certificate: delays must be at most about {_MOST} times a common one"
            )
        terms: dict[tuple[int, ...], Coefficients] = {}
        for exponents, value in factor.to_dict().items():
            powers = [int(n) for n in exponents]
            coefficients = terms.setdefault((*powers[places][::-1], *powers[raised]), {})
            coefficients[powers[0], powers[self.second]] = int(value.p)
        if len(terms) > _MOST_TERMS or any(n > _MOST for n in degrees[raised]):
            raise SceneError(
                f"certificate: at most {_MOST_TERMS} products of sines and powers in a "
                f"factor, to at most {_MOST}"
            )
        rows = [[list(turns), _rows(powers)] for turns, powers in sorted(terms.items())]
        return json.dumps({"waves": degrees[places][::-1], "terms": rows})

    def _need_alone(self, powers: Sequence[int]) -> None:
        """SceneError where a polynomial has more variables than the first and ``second``."""
        others = [i for i, n in enumerate(powers) if n and i not in (0, self.second)]
        if others:
            raise SceneError(BESIDE_PI if others == [PI] else NOT_RATIONAL)


@dataclass(frozen=True)
class Linked:
    """Functions as products of factors, and the factors as the checker has them."""

    told: dict[str, dict[str, Any]]
    listed: Sequence[dict[str, Any]]
    delays: tuple[Fraction, ...]
    orders: tuple[Fraction, ...]

    @property
    def has_waves(self) -> bool:
        """Whether there are factors with sines, or powers."""
        return any("waves" in x for x in self.listed)

    def proof(self, **more: Any) -> dict[str, Any]:
        """The part of a proof with the functions and their factors, and more entries."""
        others = {"delays": [str(x) for x in self.delays], "orders": [str(x) for x in self.orders]}
        return {**others, **more, "factors": self.listed, "functions": self.told}

    @cached_property
    def factors(self) -> list[OmegaFactor]:
        """The factors as objects of the checker, with their signs and what those cost. RefusedError
        where one is too large."""
        return [factor_of(x, self.delays, self.orders) for x in self.listed]


def products(functions: Mapping[str, RealFunction], second: int = PI) -> Linked:
    """The factors of real functions, and each function as the product of them; ``second`` : as of
    ``Factors``."""
    axis = next(iter(functions.values())).axis
    others = [*axis.lags[::-1], *(axis.powers if isinstance(axis, RectangularAxis) else ())]
    if len(others) > _MOST_OTHERS or not all(
        x.is_Rational and max(x.p, x.q) < _LARGEST for x in others
    ):
        raise SceneError(NO_ROOM)
    exact = tuple(Fraction(int(x.p), int(x.q)) for x in others)
    delays, orders = exact[: len(axis.lags)], exact[len(axis.lags) :]
    factors = Factors(delays, orders, second, not others and are_even(list(functions.values())))
    quotients = {
        name: factors.quotient(x.axis, x.function.numerator, x.function.denominator)
        for name, x in functions.items()
    }
    return Linked(quotients, [json.loads(x) for x in factors.listed], delays, orders)


def are_even(functions: Sequence[RealFunction]) -> bool:
    """Whether all numerators and denominators are even or odd in omega; those of Coulomb friction
    are not."""
    every = (
        p
        for f in functions
        for p in (f.function.numerator, f.function.denominator)
        if not p.is_zero()
    )
    return all(len({int(e[0]) % 2 for e in p.monoms()}) == 1 for p in every)
