"""First harmonics of elements that are not linear: what describing functions are made of.

Each is a real function of one ratio of two sizes, for an input A sin(omega t). With symbols it is
left as it is, and is one more variable of a ring; of a number it is a rational number, its value
rounded to ``_BITS`` binary digits. Derivations: 22_quantiser, 23_backlash, 24_dead_zone.
"""

from __future__ import annotations

import flint
from flint import arb
from sympy import Expr, Function, Rational

from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import Ball, expression_ball

_BITS = 200
"""Binary digits of a first harmonic: 60 decimal ones, far more than an amplitude has."""
_MOST_STEPS = 100_000
"""Steps of a quantiser along its input's amplitude, whose terms are summed one by one."""


class Harmonic(Function):  # type: ignore[misc]
    """A part of a first harmonic over the input's amplitude; a number where its ratio is one."""

    is_real = True

    @classmethod
    def eval(cls, ratio: Expr) -> Expr | None:
        """Return the value of a number, rounded; None leaves a ratio with symbols as it is."""
        if not ratio.is_number:
            return None
        with flint.ctx.workprec(_BITS + 64):
            middle, power = cls.value(expression_ball(ratio)).mid().man_exp()
        cut = max(0, int(middle).bit_length() - _BITS)
        return Rational(int(middle) >> cut) * Rational(2) ** (int(power) + cut)

    @property
    def name(self) -> str:
        """What it is called where a step needs the names of its inputs."""
        return str(self)

    @staticmethod
    def value(ratio: Ball) -> Ball:
        """Return a ball around the value at a ratio."""
        raise NotImplementedError


class limiter(Harmonic):  # noqa: N801 - named as SymPy names functions
    """The first harmonic of a limit, over A, by u = limit/A: 2/pi (asin u + u sqrt(1 - u^2)); 1 for
    u >= 1, and odd in u.

    >>> from sympy import Integer
    >>> limiter(Integer(1)), limiter(Integer(-2)), float(limiter(Rational(1, 2))).__round__(12)
    (1, -1, 0.608997781044)
    """

    @staticmethod
    def value(ratio: Ball) -> Ball:
        # A ball that reaches beyond 1 has no arc sine: at 1 the number is 1 itself.
        if not abs(ratio) < 1:
            return ratio.sgn()
        return 2 * (ratio.asin() + ratio * (1 - ratio * ratio).sqrt()) / arb.pi()


class lagging(Harmonic):  # noqa: N801 - as above
    """The part of a play's first harmonic that lags by a quarter turn, over A, by u = 1 - gap/A:
    (1 - u^2)/pi; 0 for u <= -1, where nothing passes."""

    @staticmethod
    def value(ratio: Ball) -> Ball:
        return (1 - ratio * ratio) / arb.pi() if abs(ratio) < 1 else arb(0)


class quantiser(Harmonic):  # noqa: N801 - as above
    """The first harmonic of q round(x/q), over A, by u = q/(2 A): 8 u/pi times the sum of
    sqrt(1 - ((2 i - 1) u)^2) over i = 1, 2, ... with (2 i - 1) u < 1; 0 for u >= 1.

    >>> from sympy import Integer
    >>> quantiser(Integer(1)), float(quantiser(Rational(1, 2))).__round__(12)
    (0, 1.102657790844)
    """

    @staticmethod
    def value(ratio: Ball) -> Ball:
        steps = float(1 / ratio) / 2
        if steps > _MOST_STEPS:
            raise SceneError(
                f"amplitude: {steps:.3g} steps of the encoder are more than {_MOST_STEPS}: leave "
                f"the encoder out, as its first harmonic differs from 1 by less than 1e-7"
            )
        total = arb(0)
        for i in range(1, int(steps) + 2):
            # A step that the input just reaches takes no time, and adds nothing.
            if (square := 1 - ((2 * i - 1) * ratio) ** 2) > 0:
                total += square.sqrt()
        return 8 * ratio * total / arb.pi()
