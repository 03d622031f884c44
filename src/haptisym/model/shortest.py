"""The shortest closed form of Re or Im: in lowest terms, in magnitudes and angles of the chain's factors, or as Re of a product.

In lowest terms a chain of n devices with parameters of their own has some 2^n terms. Effects in series are factors G_i instead:
H_perc = |H| prod |G_i| exp(j (arg H + sum arg G_i)) grows by one magnitude and one angle with each. What is neither short nor in
series is left as Re or Im of H_perc(j omega) as the chain builds it. Named steps (``Distortion.steps``) are short for all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sympy import Add, Expr, I, Integer, Mul, atan2, cos, count_ops, exp, im, pi, re, sin, sqrt

from haptisym.kernel.dynamics import Ring, on_axis
from haptisym.kernel.rings import RationalFunction, omega, s
from haptisym.model.catalogue import Matrix
from haptisym.model.jnd import Part

_SHORT = 10  # terms of a dynamics up to which lowest terms are it
_FEW, _MOST = 80, 300  # up to which they are looked at beside factors, and are made where there are none
_LONGER = 1.3  # lowest terms are kept where they are no longer than this
_TURN = {Part.REAL: cos, Part.IMAG: sin}
_PART = {Part.REAL: re, Part.IMAG: im}


def shortest(
    dynamics: RationalFunction, lowest: Callable[[], Expr], others: Callable[[], Expr], *, in_series: bool
) -> tuple[Expr, bool]:
    """The shorter of two forms of Re or Im of a dynamics; and whether that is the one in lowest terms.

    ``others`` : in factors, if all effects are ``in_series``, or as Re or Im of H_perc. Lowest terms are preferred where they
    are short, and not made where that would take long.
    """
    terms = len(dynamics.numerator) + len(dynamics.denominator)
    if terms <= _SHORT or (terms <= _MOST and not in_series):
        return lowest(), True
    other = others()
    if terms > _FEW:
        return other, False
    found = lowest()
    return (found, True) if count_ops(found) <= _LONGER * count_ops(other) else (other, False)


@dataclass(frozen=True)
class Factors:
    """What is felt of a chain, as factors on s = j omega: ``environment`` H_env, ``rendered`` what the chain is built on."""

    environment: Expr
    rendered: Expr
    matrices: tuple[Matrix, ...]

    @property
    def in_series(self) -> bool:
        """Whether each effect multiplies the force, and does nothing else."""
        return all(b == 0 and c == 0 for _, b, c, _ in self.matrices)

    def part(self, part: Part, environment: Expr) -> Expr:
        """Re or Im dH, less that part of H_env as it is given: in series in magnitudes and angles."""
        if not self.in_series:
            return _PART[part](self.perceived, evaluate=False) - environment
        return self._turned(part, [self.rendered, *self._gains]) - environment

    def relative(self, part: Part) -> Expr:
        """Re or Im(dH/H_env)."""
        if not self.in_series:
            H = self.environment.xreplace({s: I * omega})
            return _PART[part](self.perceived / H, evaluate=False) - Integer(part is Part.REAL)
        own = [] if self.rendered == self.environment else [self.rendered, 1 / self.environment]
        return self._turned(part, [*own, *self._gains]) - Integer(part is Part.REAL)

    @property
    def perceived(self) -> Expr:
        """H_perc(j omega), as the chain builds it."""
        H = self.rendered
        for a, b, c, d in self.matrices:
            H = (a * H + b) / (c * H + d)
        return H.xreplace({s: I * omega})

    @property
    def _gains(self) -> list[Expr]:
        return [a / d for a, _, _, d in self.matrices]

    @staticmethod
    def _turned(part: Part, factors: Sequence[Expr]) -> Expr:
        polar = [_polar(x) for x in factors]
        return Mul(*(size for size, _ in polar)) * _TURN[part](Add(*(angle for _, angle in polar)))


def _polar(factor: Expr) -> tuple[Expr, Expr]:
    """Magnitude, which may be negative, and angle of a factor on s = j omega."""
    above, below = factor.as_numer_denom()
    size, angle = Integer(1), Integer(0)
    for x, sign in [(x, 1) for x in Mul.make_args(above)] + [(x, -1) for x in Mul.make_args(below)]:
        base, power = x.as_base_exp() if not isinstance(x, exp) else (x, Integer(1))
        n = sign * power if power.is_Integer else Integer(sign)
        own = _own(base if power.is_Integer else x)
        size, angle = size * own[0] ** n, angle + own[1] * n
    return size, angle


def _own(x: Expr) -> tuple[Expr, Expr]:
    base, power = (s, x.args[0] / s) if isinstance(x, exp) else x.as_base_exp()
    if isinstance(x, exp) and not power.has(s):  # a delay
        return Integer(1), omega * power
    if base == s and not power.has(s):
        return omega**power, pi * power / 2
    for sign, rest in ((1, x + 1), (-1, 1 - x)):  # of a hold: +-(exp(s T) - 1) = +-exp(s T/2) 2 sinh(s T/2)
        if isinstance(rest, exp) and not (lag := rest.args[0] / s).has(s):
            return 2 * sign * sin(omega * lag / 2), (pi + omega * lag) / 2
    ring = Ring.of([x])
    response = on_axis(ring.convert(x))
    a, b = (f.function.reduced().expression() for f in (response.real, response.imag))
    return sqrt(a**2 + b**2), atan2(b, a)
