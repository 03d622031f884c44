"""Second, independent algorithms that the tests hold against the package.

Nothing here comes from the package: a scene is a list of ``Part``s, and each part is written a second time as the
equations of motion that it stands for, ``(F, X)`` at the environment to ``(F, X)`` at the hand. The same equations are
then run over three kinds of numbers:

* ``EXACT``: complex numbers with rational parts, for exact signs at rational frequencies;
* ``DIGITS``: mpmath with 80 digits on a context of its own, for pi and for roots;
* ``SYMBOLS``: SymPy's field of rational functions of s and pi, for the polynomials that Sturm's theorem counts roots of.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any

import mpmath
import sympy
from sympy import QQ, Poly, Rational

MP = mpmath.mp.clone()
MP.dps = 80


# --- numbers ---------------------------------------------------------------------------------------------------------


class Hertz(Fraction):
    """So many turns per second: 2 pi times as many rad/s."""


@dataclass(frozen=True, slots=True)
class Gauss:
    """A complex number with rational parts.

    >>> j = Gauss(0, 1)
    >>> (1 + j) / (1 - j)
    Gauss(real=Fraction(0, 1), imag=Fraction(1, 1))
    """

    real: Fraction | int
    imag: Fraction | int = 0

    def __add__(self, other: Any) -> Gauss:
        z = _gauss(other)
        return Gauss(self.real + z.real, self.imag + z.imag)

    def __neg__(self) -> Gauss:
        return Gauss(-self.real, -self.imag)

    def __sub__(self, other: Any) -> Gauss:
        return self + -_gauss(other)

    def __rsub__(self, other: Any) -> Gauss:
        return _gauss(other) - self

    def __mul__(self, other: Any) -> Gauss:
        z = _gauss(other)
        return Gauss(self.real * z.real - self.imag * z.imag, self.real * z.imag + self.imag * z.real)

    def __truediv__(self, other: Any) -> Gauss:
        z = _gauss(other)
        size = z.squared
        return self * Gauss(Fraction(z.real) / size, -Fraction(z.imag) / size)

    def __rtruediv__(self, other: Any) -> Gauss:
        return _gauss(other) / self

    def __pow__(self, exponent: int) -> Gauss:
        result = Gauss(Fraction(1))
        for _ in range(exponent):
            result = result * self
        return result

    __radd__, __rmul__ = __add__, __mul__

    @property
    def squared(self) -> Fraction:
        return Fraction(self.real * self.real + self.imag * self.imag)


def _gauss(x: Any) -> Gauss:
    return x if isinstance(x, Gauss) else Gauss(x)


def _exact(x: Fraction) -> Gauss:
    assert not isinstance(x, Hertz), "pi is not rational"
    return Gauss(Fraction(x))


def digits_of(x: Fraction) -> Any:
    """A rational number, or one of Hertz, in mpmath."""
    plain = MP.mpf(x.numerator) / x.denominator
    return 2 * MP.pi * plain if isinstance(x, Hertz) else plain


_FIELD, _S, _PI = sympy.field("s, pi_", QQ)


def _symbolic(x: Fraction) -> Any:
    plain = _FIELD(QQ(x.numerator, x.denominator))
    return 2 * _PI * plain if isinstance(x, Hertz) else plain


EXACT, DIGITS, SYMBOLS = _exact, digits_of, _symbolic
Lift = Callable[[Fraction], Any]


# --- physics ---------------------------------------------------------------------------------------------------------

Values = Mapping[str, Any]


def _mass_spring_damper(p: Values, s: Any) -> Any:
    return p.get("m", 0) * s**2 + p.get("b", 0) * s + p.get("k", 0)


def _in_a_row(one: Any, other: Any) -> Any:
    """Two stiffnesses that carry the same force: the displacements add up."""
    return 1 / (1 / one + 1 / other)


def _two_mass(p: Values, s: Any) -> Any:
    hanging = _in_a_row(p["m2"] * s**2, p["k2"] + p["b2"] * s)
    return p["m1"] * s**2 + p["b1"] * s + p["k1"] + hanging


def _prony(p: Values, s: Any) -> Any:
    return p["k0"] + _in_a_row(p["k_1"], p["b_1"] * s) + _in_a_row(p["k_2"], p["b_2"] * s)


FELT: dict[str, Callable[[Values, Any], Any]] = {
    "mass-spring-damper": _mass_spring_damper,
    "kelvin-voigt": lambda p, s: p["k"] + p["b"] * s,
    "maxwell": lambda p, s: _in_a_row(p["k"], p["b"] * s),
    "zener": lambda p, s: p["k0"] + _in_a_row(p["k1"], p["b1"] * s),
    "prony": _prony,
    "two-mass": _two_mass,
    "expression": lambda p, s: p["k"] * (s + p["z"]) / (s + p["q"]) + p["b"] * s,
}
"""Force per displacement of each environment, from springs, dampers and masses side by side and in a row."""


def _lag(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    return F * p["omega_c"] / (s + p["omega_c"]), X


def _lowpass(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    z = s / p["omega_n"]
    return F / (z**2 + 2 * p["zeta"] * z + 1), X


def _lead_lag(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    return F * (1 + s * p["T1"]) / (1 + s * p["T2"]), X


def _pade(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    x = s * p["tau"]
    return F * (12 - 6 * x + x**2) / (12 + 6 * x + x**2), X


def _shunt(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    return F + _mass_spring_damper(p, s) * X, X


def _compliance(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    return F, X + F / (p.get("k", 0) + p.get("b", 0) * s)


def _admittance(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    closed_loop = p["w"] ** 2 / (s**2 + p["w"] * s + p["w"] ** 2)
    return F, X * closed_loop


def _two_port(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    return p["g"] * F + p["d"] * s * X, X + F * p["y"] / (s + p["q"])


def _position_force(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    controller = p["Bs"] * s + p["Ks"]
    master = X + (p["Ms"] * s**2 * X + F) / controller  # the controller's spring moves the slave and carries F
    return p["Mm"] * s**2 * master + F, master


def _position_position(p: Values, s: Any, F: Any, X: Any) -> tuple[Any, Any]:
    slave_side, master_side = p["Bs"] * s + p["Ks"], p["Bm"] * s + p["Km"]
    master = X + (p["Ms"] * s**2 * X + F) / slave_side
    return p["Mm"] * s**2 * master + master_side * (master - X), master


BETWEEN: dict[str, Callable[[Values, Any, Any, Any], tuple[Any, Any]]] = {
    "first-order-lag": _lag,
    "second-order-lowpass": _lowpass,
    "gain": lambda p, s, F, X: (F * p["g"], X),
    "lead-lag": _lead_lag,
    "pade-delay": _pade,
    "shunt": _shunt,
    "compliance": _compliance,
    "admittance-display": _admittance,
    "two-port": _two_port,
    "position-force-teleoperator": _position_force,
    "position-position-teleoperator": _position_position,
}
"""What each effect does to force and displacement, from its equations of motion."""


@dataclass(frozen=True)
class Element:
    """An environment or an effect: its kind and its parameters, exact."""

    kind: str
    values: Mapping[str, Fraction]

    def lifted(self, lift: Lift) -> dict[str, Any]:
        return {name: lift(value) for name, value in self.values.items()}


@dataclass(frozen=True)
class Case:
    """A scene as physics: what is felt, what is in between, where it is evaluated and against which thresholds."""

    felt: Element
    between: tuple[Element, ...] = ()
    band: tuple[Fraction, Fraction] = (Fraction(0), Fraction(15))
    c: Mapping[str, Fraction] = field(default_factory=lambda: {"real": Fraction(1, 10), "imag": Fraction(1, 10)})

    def dynamics(self, s: Any, lift: Lift) -> tuple[Any, Any]:
        """H_env and H_perc at ``s``, in the numbers of ``lift``."""
        H = FELT[self.felt.kind](self.felt.lifted(lift), s)
        F, X = H, lift(Fraction(1))
        for element in self.between:
            F, X = BETWEEN[element.kind](element.lifted(lift), s, F, X)
        return H, F / X

    @property
    def has_pi(self) -> bool:
        return any(isinstance(x, Hertz) for part in (self.felt, *self.between) for x in part.values.values())

    def facts(self, omega: Fraction) -> dict[str, Facts]:
        """Facts about both parts at a rational frequency: exact, or with 80 digits where the scene holds Hertz."""
        lift, j, tiny = (DIGITS, MP.mpc(0, 1), MP.mpf(10) ** -45) if self.has_pi else (EXACT, Gauss(0, 1), 0)
        H, G = self.dynamics(j * lift(omega), lift)
        size = H.real**2 + H.imag**2
        parts = (("real", H.real, G.real), ("imag", H.imag, G.imag))
        return {part: _facts(h, g, lift(self.c[part]).real ** 2 * size, size * tiny) for part, h, g in parts}

    def ratio(self, part: str, omega: Any) -> Any:
        """r_r or r_i in mpmath at a frequency of mpmath."""
        H, G = self.dynamics(MP.mpc(0, omega), DIGITS)
        D = G - H
        return abs(D.real if part == "real" else D.imag) / abs(H)

    @cached_property
    def quotients(self) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """H_env and dH as quotients in lowest terms, with a variable in the place of pi."""
        H, G = self.dynamics(_S, SYMBOLS)
        return (H.numer, H.denom), ((G - H).numer, (G - H).denom)

    @property
    def poles(self) -> list[Any]:
        """The poles of H_perc, in mpmath."""
        denominator = self.dynamics(_S, SYMBOLS)[1].denom
        powers = {n: MP.mpf(int(x.numerator)) / int(x.denominator) for (n, _), x in denominator.terms()}
        c = [powers.get(n, MP.mpf(0)) for n in range(max(powers), -1, -1)]
        return list(MP.polyroots(c, maxsteps=1000, extraprec=1000)) if len(c) > 1 else []

    @cached_property
    def excess(self) -> dict[str, Poly]:
        return {part: self._excess(part) for part in ("real", "imag")}

    def _excess(self, part: str) -> Poly:
        """The polynomial in W = omega^2 that vanishes where r = c: the numerator of r^2 - c^2 in lowest terms."""
        (n, d), (p, q) = (tuple(_on_axis(polynomial) for polynomial in pair) for pair in self.quotients)
        real, imag = p[0] * q[0] + p[1] * q[1], p[1] * q[0] - p[0] * q[1]  # p/q = p conj(q)/|q|^2
        top = (real if part == "real" else imag) ** 2 * _squared(d)
        bottom = _squared(q) ** 2 * _squared(n)
        common = top.gcd(bottom)
        c = Rational(self.c[part].numerator, self.c[part].denominator)
        return in_square(top.quo(common) - c**2 * bottom.quo(common))

    @cached_property
    def counts(self) -> dict[str, int]:
        """How many different frequencies of the band have r = c: Sturm's theorem."""
        low, high = (Rational(x.numerator, x.denominator) ** 2 for x in self.band)
        return {part: 0 if p.is_zero else int(p.count_roots(low, high)) for part, p in self.excess.items()}

    def with_(self, **changes: Any) -> Case:
        return replace(self, **changes)


@dataclass(frozen=True)
class Facts:
    """Signs at one frequency, of r - c, H_env, H_perc, dH and ``|H_perc| - |H_env|``, each of one part."""

    excess: int
    env: int
    perc: int
    difference: int
    larger: int


def _facts(h: Any, g: Any, limit: Any, tiny: Any) -> Facts:
    compared = g**2 - h**2
    return Facts(
        sign((g - h) ** 2 - limit),
        *(sign(x) if x**2 > tiny else 0 for x in (h, g, g - h)),
        sign(compared) if abs(compared) > tiny else 0,
    )


def sign(x: Any) -> int:
    return (x > 0) - (x < 0)


def _on_axis(polynomial: Any) -> tuple[Poly, Poly]:
    """Real and imaginary part of a polynomial on ``s = j omega``, through Gaussian rationals."""
    omega = sympy.Symbol("omega", real=True)
    written = Poly(polynomial.as_expr().subs(sympy.Symbol("s"), sympy.I * omega), omega, domain="QQ_I")
    coefficients = written.rep.to_list()
    return (
        Poly.from_list([z.x for z in coefficients], omega, domain=QQ),
        Poly.from_list([z.y for z in coefficients], omega, domain=QQ),
    )


def _squared(parts: tuple[Poly, Poly]) -> Poly:
    return parts[0] ** 2 + parts[1] ** 2


def in_square(even: Poly) -> Poly:
    """A polynomial of even powers as one of the square of its variable."""
    coefficients = even.all_coeffs()
    assert not any(coefficients[-2::-2]), "not an even polynomial"
    return Poly(coefficients[::-2][::-1], sympy.Symbol("W"), domain=QQ)


# --- roots -----------------------------------------------------------------------------------------------------------


def scan(f: Callable[[Any], Any], points: Sequence[Any], digits: int = 40) -> list[Any]:
    """The sign changes of a function between neighbouring points, each bisected to that many digits.

    >>> [MP.nstr(x, 12) for x in scan(lambda x: x**2 - 2, [0, 1, 2, 3])]
    ['1.41421356237']
    """
    values = [f(x) for x in points]
    return [
        _bisected(f, MP.mpf(a), MP.mpf(b), sign(fa), digits)
        for (a, fa), (b, fb) in pairwise(zip(points, values, strict=True))
        if sign(fa) * sign(fb) < 0
    ]


def _bisected(f: Callable[[Any], Any], low: Any, high: Any, below: int, digits: int) -> Any:
    while high - low > abs(high) * MP.mpf(10) ** -digits:
        middle = (low + high) / 2
        low, high = (middle, high) if sign(f(middle)) == below else (low, middle)
    return (low + high) / 2


def excess_roots(case: Case, part: str) -> list[Any]:
    """All frequencies of the band at which r = c, by mpmath's polynomial roots with 80 digits; pi is welcome.

    For scenes in which H_env and the denominators have no zero on the positive axis: there the uncancelled polynomial has
    none either.
    """
    (n, d), (p, q) = (tuple(_numeric(polynomial) for polynomial in pair) for pair in case.quotients)
    product = _times(p, _mirrored(q))
    chosen = [z.real if part == "real" else z.imag for z in product]
    top = _times(_times(chosen, chosen), _times(d, _mirrored(d)))
    modulus = _times(q, _mirrored(q))
    bottom = _times(_times(modulus, modulus), _times(n, _mirrored(n)))
    c = digits_of(case.c[part])
    polynomial = _minus(top, [c**2 * x for x in bottom])[::2]
    while polynomial[-1] == 0:
        polynomial.pop()
    while polynomial[0] == 0:  # r = c at omega = 0 is not asked for
        polynomial.pop(0)
    squares = MP.polyroots([x.real for x in reversed(polynomial)], maxsteps=500, extraprec=600)
    real = (z.real for z in squares if abs(z.imag) < abs(z) * MP.mpf(10) ** -25 and z.real > 0)
    low, high = map(digits_of, case.band)
    return sorted(w for w in map(MP.sqrt, real) if low <= w <= high)


def _numeric(polynomial: Any) -> list[Any]:
    """Ascending coefficients in omega of a polynomial on ``s = j omega``, with pi in place."""
    terms = [(n, MP.mpf(int(x.numerator)) / int(x.denominator) * MP.pi**m) for (n, m), x in polynomial.terms()]
    degree = max((n for n, _ in terms), default=0)  # of none: what is zero everywhere
    return [MP.fsum(x for n, x in terms if n == power) * MP.mpc(0, 1) ** power for power in range(degree + 1)]


def _mirrored(polynomial: Iterable[Any]) -> list[Any]:
    return [MP.conj(z) for z in polynomial]


def _times(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    result = [MP.mpc(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for k, y in enumerate(b):
            result[i + k] += x * y
    return result


def _minus(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    size = max(len(a), len(b))
    padded = [[*x, *[MP.mpf(0)] * (size - len(x))] for x in (a, b)]
    return [x - y for x, y in zip(*padded, strict=True)]


def rounded(x: Any, count: int) -> str:
    """A number of mpmath to that many significant digits, as a decimal text without an exponent."""
    text = Decimal(MP.nstr(x, MP.dps - 5))
    return f"{Context(prec=count, rounding=ROUND_HALF_EVEN).plus(text):f}"
