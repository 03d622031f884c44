"""First harmonics of elements that are not linear: what describing functions are made of.

The answer of an element to A sin(omega t) has the first harmonic A (n_p sin(omega t) + n_q
cos(omega t)): n_p is its part in phase, n_q the one a quarter turn ahead (Gelb and Vander Velde).
Each is a real function of one ratio of two sizes. With symbols it is left as it is, and is one more
variable of a ring; of a number it is a rational number, its value rounded to ``_BITS`` binary
digits. Written out (``explicit``) it has an arc sine, roots and sums. Derivations: 22_quantiser,
23_backlash, 24_dead_zone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import flint
from flint import arb
from sympy import Expr, Float, Function, Max, Min, Rational, Sum, Symbol, asin, floor, pi, sqrt

from haptisym.kernel.arrays import np
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import Ball, expression_ball

_BITS = 200
"""Binary digits of a first harmonic: 60 decimal ones, far more than an amplitude has."""
MOST_STEPS = 100_000
"""Steps of a quantiser along its input's amplitude, whose terms are summed one by one."""
STEP = Symbol("i", integer=True, positive=True)
"""The number of a step in a sum over them."""


class Harmonic(Function):  # type: ignore[misc]
    """A part of a first harmonic over the input's amplitude; a number where its ratio is one."""

    is_real = True
    letter = "n_p"
    """What formulas call it: n_p in phase, n_q a quarter turn ahead."""

    @classmethod
    def eval(cls, ratio: Expr) -> Expr | None:
        """Return the value of a number, rounded; None leaves a ratio with symbols as it is."""
        if not ratio.is_number:
            return None
        # A float is taken for what it is, and the value is a float.
        if ratio.has(Float):
            return Float(cls(Rational(float(ratio))))
        # A step that the input just reaches leaves half of the digits open.
        with flint.ctx.workprec(2 * _BITS + 64):
            middle, power = cls.value(expression_ball(ratio)).mid().man_exp()
        cut = max(0, int(middle).bit_length() - _BITS)
        return Rational(int(middle) >> cut) * Rational(2) ** (int(power) + cut)

    @property
    def name(self) -> str:
        """What it is called where a step needs the names of its inputs."""
        return str(self)

    @property
    def within(self) -> Expr:
        """The ratio, kept from -1 to 1: beyond, the function is what it is at the end."""
        return Max(-1, Min(1, self.args[0]))

    @property
    def explicit(self) -> Expr:
        """The function written out, for all values of its symbols."""
        return self.form(self.within)

    @staticmethod
    def form(u: Expr) -> Expr:
        """Return the function written out in a ratio from -1 to 1."""
        raise NotImplementedError

    @classmethod
    def value(cls, ratio: Ball) -> Ball:
        """Return a ball around all values at the ratios in a ball."""
        raise NotImplementedError


class limiter(Harmonic):  # noqa: N801 - named as SymPy names functions
    """The first harmonic of a limit, by u = limit/A: 2/pi (asin u + u sqrt(1 - u^2)); 1 for u >= 1,
    and odd in u.

    >>> from sympy import Integer
    >>> limiter(Integer(1)), limiter(Integer(-2)), float(limiter(Rational(1, 2))).__round__(12)
    (1, -1, 0.608997781044)
    """

    @staticmethod
    def form(u: Expr) -> Expr:
        return 2 / pi * (asin(u) + u * sqrt(1 - u**2))

    @classmethod
    def value(cls, ratio: Ball) -> Ball:
        # It grows with u. A ball that reaches beyond 1 has no arc sine: at 1 the number is 1
        # itself.
        low, high = (_limited(x) for x in (ratio.lower(), ratio.upper()))
        return low.union(high)


def _limited(u: Ball) -> Ball:
    """The first harmonic of a limit at one ratio, an exact number."""
    if not abs(u) < 1:
        return u.sgn()
    return 2 * (u.asin() + u * (1 - u * u).sqrt()) / arb.pi()


class deadband(Harmonic):  # noqa: N801 - as above
    """The first harmonic of a dead zone, by u = width/A: what a limit at its width leaves, 1 -
    limiter(u); 0 for u >= 1."""

    @staticmethod
    def form(u: Expr) -> Expr:
        return 1 - limiter.form(u)

    @classmethod
    def value(cls, ratio: Ball) -> Ball:
        return 1 - limiter.value(ratio)


class following(Harmonic):  # noqa: N801 - as above
    """The part in phase of a play's first harmonic, by u = 1 - gap/A: (1 + limiter(u))/2; 0 for u <=
    -1, where nothing passes."""

    @staticmethod
    def form(u: Expr) -> Expr:
        return Rational(1, 2) + limiter.form(u) / 2

    @classmethod
    def value(cls, ratio: Ball) -> Ball:
        return (1 + limiter.value(ratio)) / 2


class lagging(Harmonic):  # noqa: N801 - as above
    """The part of a play's first harmonic a quarter turn ahead, which is negative: -(1 - u^2)/pi by u
    = 1 - gap/A; 0 for u <= -1."""

    letter = "n_q"

    @staticmethod
    def form(u: Expr) -> Expr:
        return (u**2 - 1) / pi

    @classmethod
    def value(cls, ratio: Ball) -> Ball:
        return -(1 - ratio * ratio).max(arb(0)) / arb.pi()


class quantiser(Harmonic):  # noqa: N801 - as above
    """The first harmonic of q round(x/q), by u = q/(2 A): 8 u/pi times the sum of sqrt(1 - ((2 i -
    1) u)^2) over i = 1, 2, ... with (2 i - 1) u < 1; 0 for u >= 1.

    >>> from sympy import Integer
    >>> quantiser(Integer(1)), float(quantiser(Rational(1, 2))).__round__(12)
    (0, 1.102657790844)
    """

    @property
    def within(self) -> Expr:
        return self.args[0]

    @staticmethod
    def form(u: Expr) -> Expr:
        steps = floor(Rational(1, 2) + 1 / (2 * u))
        return 8 * u / pi * Sum(sqrt(1 - ((2 * STEP - 1) * u) ** 2), (STEP, 1, steps))

    @classmethod
    def value(cls, ratio: Ball) -> Ball:
        # As many terms as the smallest ratio has. One that the input does not reach is 0, and so is
        # one that it just reaches: the middle of a ball that is not told from that.
        total = arb(0)
        for i in range(1, 2 * _steps(float(ratio.lower())) + 2, 2):
            if (square := 1 - (i * ratio) ** 2) > 0:
                total += square.sqrt()
            elif square.upper() > 0:
                total += arb(0, square.upper().sqrt())
        return 8 * ratio * total / arb.pi()


def _steps(ratio: float) -> int:
    """How many steps of a quantiser an input may reach; SceneError for too many."""
    if not 2 * MOST_STEPS * ratio > 1:
        raise SceneError(
            f"amplitude: more than {MOST_STEPS} steps of the encoder: leave the encoder out, as its "
            f"first harmonic differs from 1 by less than 1e-7"
        )
    return int(1 / ratio) // 2 + 1


def staircase(u: Any) -> Any:
    """Return the sum of sqrt(1 - (i u)^2) over i = 1, 3, ... with i u < 1, for u > 0, in the
    arithmetic of u: a float or a number of mpmath, or an array of floats."""
    if getattr(u, "ndim", 0):
        return np.vectorize(staircase, otypes=[float])(u)
    total = 0 * u
    for i in range(1, 2 * _steps(float(u)) + 2, 2):
        if i * u < 1:
            total += (1 - (i * u) ** 2) ** 0.5
    return total


def computable(form: Expr) -> Expr:
    """Return a form for ``lambdify``, first harmonics written out; ``staircase`` is to be given to
    it by its name, as its number of terms depends on the sizes."""
    summed = Function("staircase")
    return form.replace(
        lambda x: isinstance(x, Harmonic),
        lambda x: 8 / pi * x.args[0] * summed(x.args[0]) if x.func is quantiser else x.explicit,
    )


def named_harmonics(
    found: Iterable[Expr], taken: Collection[str]
) -> tuple[dict[Expr, Symbol], list[tuple[Symbol, Expr]]]:
    """Return symbols for first harmonics, and the definitions of these symbols, with the ratio as a
    symbol u of its own: for formulas that can be read. ``taken`` : names that are in use.

    >>> from sympy import symbols
    >>> q, A = symbols("q A", positive=True)
    >>> named_harmonics([deadband(q / A)], {"q", "A"})[1]
    [(u, Min(1, q/A)), (n_p, -2*(u*sqrt(1 - u**2) + asin(u))/pi + 1)]
    """
    names = set(taken)
    symbols: dict[Expr, Symbol] = {}
    ratios: dict[Expr, Symbol] = {}
    definitions = []

    def named(letter: str) -> Symbol:
        places = (letter, *(f"{letter}_{n}" for n in range(2, len(names) + 3)))
        name = next(x for x in places if x not in names)
        names.add(name)
        return Symbol(name, real=True)

    for x in sorted(found, key=str):
        if x.within not in ratios:
            ratios[x.within] = named("u")
            definitions.append((ratios[x.within], x.within))
        symbols[x] = named(x.letter)
        definitions.append((symbols[x], x.form(ratios[x.within])))
    return symbols, definitions
