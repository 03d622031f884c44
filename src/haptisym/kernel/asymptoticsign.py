"""The sign of a real function of omega at high frequency: positive, negative, or both, again and
again.

**Problem.** On s = j omega a delay tau gives exp(-j omega tau), that is sines and cosines of the
angle omega tau, and a power s^alpha gives omega^alpha. Times a positive function, a polynomial in
all of these is

    f(omega) = sum over q of omega^q W_q(omega),

with finitely many real exponents q and trigonometric polynomials W_q: sums of products of
*harmonics* 1, cos(n a), sin(n a) of the angles a = omega tau of all delays. Is there a radius R, in
rad/s, such that f keeps one sign for omega > R, and which?

**Method.** Let p be the highest exponent, c the constant term of W_p, and w_q the sum of the
absolute values of all coefficients of W_q.

- If abs(c) exceeds the sum of the absolute values of all other coefficients of W_p, by d, then W_p
  has the sign of c and abs(W_p) >= d everywhere. For omega > R with d > sum over q < p of
  w_q R^(q - p) so does f, as the right-hand side falls with R.
- If W_p takes both signs, so does f, at arbitrarily high frequencies. W_p is almost periodic
  (H. Bohr, Almost Periodic Functions, 1947): for every epsilon > 0 there are arbitrarily large T
  with abs(W_p(omega + T) - W_p(omega)) < epsilon for all omega. It comes near both values again and
  again, while all lower powers, over omega^p, go to 0.

**Returned** is an ``AsymptoticSign``; ``POSITIVE``, ``NEGATIVE`` and ``BOTH`` are proven.

**Failure.** Where neither case is shown, the sign is ``UNKNOWN``: W_p may touch 0 without a change
of sign, as 1 - cos(omega tau); both signs may have been missed between samples; or R may be larger
than all that were tried. LimitError comes from a product that is too large (``kernel.budget``).

Begin reading with ``asymptotic_sign``; ``sign_without_zeros`` is for callers that must know of
every zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from itertools import product
from math import prod
from typing import NamedTuple, TypeAlias

import flint
from flint import arb, fmpq
from sympy import Integer, Rational, tan

from haptisym.kernel.axis import CONSTANT, Axis, harmonics
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials
from haptisym.kernel.zeros import sign_of

_BITS = 128
# Frequencies at which W_p is looked at for both signs, and how far the fastest angle turns from one
# to the next, in rad: no rational part of a turn, so that the samples are dense on the circle.
_SAMPLES = 400
_STEP = fmpq(229, 500)
# The first radius that is tried, about 1e-6 rad/s, and how often it is doubled, up to about 1e18
# rad/s: far below and above all frequencies that a scene is about.
_FIRST_RADIUS = Rational(1, 1 << 20)
_MOST_DOUBLINGS = 80


class Sense(Enum):
    """The sign of a function above a frequency. ``POSITIVE`` and ``NEGATIVE`` allow for zeros,
    ``BOTH`` means both at arbitrarily high frequencies, ``UNKNOWN`` that none of these is
    proven."""

    POSITIVE = 1
    NEGATIVE = -1
    BOTH = 2
    UNKNOWN = 0


@dataclass(frozen=True)
class AsymptoticSign:
    """The sign of a function for omega > ``radius``, in rad/s; where it is ``BOTH`` or ``UNKNOWN``
    there is no such radius, and the 0 stands for nothing."""

    sense: Sense
    radius: Rational = Integer(0)


def asymptotic_sign(f: RationalFunction) -> AsymptoticSign:
    """The sign at high frequency of a function of an axis without parameters whose denominator is
    nowhere negative: proven, or ``UNKNOWN``. The function 0 is ``POSITIVE``.

    Real and imaginary part of a response that is not reduced are such functions: their denominator
    is a square of a modulus. The sign is that of the numerator.

    >>> from sympy import cos, exp
    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.dynamics import on_axis
    >>> from haptisym.kernel.rings import s
    >>> def of(expression):
    ...     ring = Ring.of([expression])
    ...     return asymptotic_sign(on_axis(ring.convert(expression)).raw_imag).sense.name
    >>> of(s**2 + 3 * s), of(exp(-s)), of(2 * s + s * exp(-s)), of(s * (1 - exp(-s)))
    ('POSITIVE', 'BOTH', 'POSITIVE', 'UNKNOWN')
    """
    axis = f.ring
    assert isinstance(axis, Axis)
    # Factors 1 + tan^2 are positive.
    polynomial = axis.without_circles(f.numerator)[0]
    if polynomial.is_zero():
        return AsymptoticSign(Sense.POSITIVE)
    expansion = _Expansion(axis, polynomial)
    highest = max(expansion.waves)
    with flint.ctx.workprec(_BITS):
        sign, excess = expansion.constant_excess(highest)
        if not excess > 0:
            takes_both = expansion.takes_both_signs(highest)
            return AsymptoticSign(Sense.BOTH if takes_both else Sense.UNKNOWN)
        radius = expansion.radius(highest, excess)
    if radius is None:
        return AsymptoticSign(Sense.UNKNOWN)
    return AsymptoticSign(Sense(sign), radius)


def sign_without_zeros(f: RationalFunction) -> AsymptoticSign:
    """As ``asymptotic_sign``, for a function that, moreover, has no zero above the radius:
    ``UNKNOWN`` where that is not proven.

    Above the radius the numerator is not 0. But f is, at every frequency at which omega tau is an
    odd multiple of pi, if its denominator has a higher degree in tan(omega tau/2), which has its
    poles there.

    >>> from sympy import exp
    >>> from haptisym.kernel.dynamics import Ring, on_axis
    >>> from haptisym.kernel.rings import s
    >>> damper = s * (1 + exp(-s))
    >>> f = on_axis(Ring.of([damper]).convert(damper)).raw_imag                  # omega (1 + cos omega)
    >>> asymptotic_sign(f).sense.name, sign_without_zeros(f).sense.name
    ('POSITIVE', 'UNKNOWN')
    """
    axis = f.ring
    assert isinstance(axis, Axis)
    above, below = f.numerator.degrees(), f.denominator.degrees()
    of_delays = range(axis.size, axis.size + axis.delays)
    if any(above[i] < below[i] for i in of_delays):
        return AsymptoticSign(Sense.UNKNOWN)
    return asymptotic_sign(f)


_Harmonics: TypeAlias = tuple[int, ...]
"""A product of harmonics, one of each delay angle, by their numbers in ``axis.harmonics``: -1
(``CONSTANT``) for 1, 2 n - 2 for cos(n a), 2 n - 1 for sin(n a), n = 1, 2, ..."""
_Wave: TypeAlias = dict[_Harmonics, Ball]
"""A trigonometric polynomial W_q: coefficients of products of harmonics."""


class _Term(NamedTuple):
    """A term of the polynomial. ``power``: the exponent q of omega, powers omega^alpha counted in.
    ``of_delays``: the exponents of the half-angle tangents of all delay angles. ``of_constants``:
    those of constant angles, by their place among all angles. ``of_pi``: the exponent of pi."""

    power: Rational
    of_delays: tuple[int, ...]
    of_constants: dict[int, int]
    of_pi: int
    coefficient: fmpq


class _Expansion:
    """The numerator of a function as f = sum over q of omega^q W_q.

    The polynomial holds tangents tan(a/2) of *delay angles* a = omega tau and of *constant angles*
    alpha pi/2. Times cos(a/2)^n of each delay angle, n even and not below the degree in its
    tangent, it is a polynomial in sines and cosines and keeps its sign.
    """

    def __init__(self, axis: Axis, polynomial: Polynomial) -> None:
        self.axis, self.polynomial = axis, polynomial
        angles = enumerate(axis.angles)
        self.delay_angles = [i for i, angle in angles if not angle.constant]
        all_degrees = polynomial.degrees()
        degrees = [int(all_degrees[axis.size + i]) for i in self.delay_angles]
        self.even_degrees = [n + n % 2 for n in degrees]

    @cached_property
    def waves(self) -> dict[Rational, _Wave]:
        """W_q for each exponent q."""
        # Coefficients of harmonics have denominators 2^n and may cancel: n more bits allow for it.
        with flint.ctx.workprec(_BITS + sum(self.even_degrees)):
            tangents = {
                i: expression_ball(tan(angle.value / 2))
                for i, angle in enumerate(self.axis.angles)
                if angle.constant
            }
            waves: dict[Rational, _Wave] = {}
            for term in self._terms():
                coefficient = arb(term.coefficient) * arb.pi() ** term.of_pi
                for i, n in term.of_constants.items():
                    coefficient *= tangents[i] ** n
                wave = waves.setdefault(term.power, {})
                for numbers, share in self._in_harmonics(term.of_delays):
                    wave[numbers] = wave.get(numbers, arb(0)) + coefficient * share
            return waves

    def _in_harmonics(self, tangents: Sequence[int]) -> Iterator[tuple[_Harmonics, fmpq]]:
        """A product of powers of the tangents of delay angles, times the cosines, as a sum of
        products of harmonics."""
        sums = [
            harmonics(k, degree).items()
            for k, degree in zip(tangents, self.even_degrees, strict=True)
        ]
        for factors in product(*sums):
            numbers = tuple(number for number, _ in factors)
            yield numbers, prod((share for _, share in factors), start=fmpq(1))

    def _terms(self) -> Iterator[_Term]:
        """The terms of the polynomial."""
        # Exponents of a term: omega, pi, parameters, then tangents of all angles, then omega^alpha.
        axis = self.axis
        first_power = axis.size + len(axis.angles)
        for exponents, coefficient in monomials(self.polynomial):
            each = [int(n) for n in exponents]
            tangents = each[axis.size : first_power]
            power = Integer(each[0])
            for order, n in zip(axis.orders, each[first_power:], strict=True):
                power += n * order
            of_constants = {
                i: n for i, n in enumerate(tangents) if n and i not in self.delay_angles
            }
            of_delays = tuple(tangents[i] for i in self.delay_angles)
            yield _Term(power, of_delays, of_constants, each[1], coefficient)

    def constant_excess(self, power: Rational) -> tuple[int, Ball]:
        """For W_q, q = ``power``: the sign of its constant term, and a lower bound of the amount by
        which its absolute value exceeds the sum of those of all other coefficients. Only where that
        bound is positive the sign is known."""
        wave, constant = self.waves[power], (CONSTANT,) * len(self.delay_angles)
        constant_term = wave.get(constant, arb(0))
        others = arb(0)
        for numbers, coefficient in wave.items():
            if numbers != constant:
                others = others + abs(coefficient)
        return sign_of(constant_term), (abs(constant_term) - others).lower()

    def takes_both_signs(self, power: Rational) -> bool:
        """True: W_q, q = ``power``, is proven to take both signs. False: nothing is known."""
        wave = self.waves[power]
        # Without delay angles it is a number, for which one sample is enough.
        count = _SAMPLES if any(self.even_degrees) else 1
        rates = [expression_ball(self.axis.angles[i].rate) for i in self.delay_angles]
        step = arb(_STEP) / max(rates, key=float, default=arb(1))
        signs = set[int]()
        for k in range(1, count + 1):
            signs.add(sign_of(_value(wave, [rate * step * k for rate in rates])))
            if {1, -1} <= signs:
                return True
        return False

    def radius(self, power: Rational, excess: Ball) -> Rational | None:
        """A frequency from which on ``excess`` omega^q, q = ``power``, exceeds all lower powers
        together; None where none of those tried is shown to be one."""
        weights = {
            lower: sum(map(abs, wave.values()), arb(0))
            for lower, wave in self.waves.items()
            if lower < power
        }
        radius = _FIRST_RADIUS
        for _ in range(_MOST_DOUBLINGS):
            base, total = expression_ball(radius), arb(0)
            for lower, weight in weights.items():
                total = total + weight * base ** expression_ball(lower - power)
            if excess > total:
                return radius
            radius *= 2
        return None


def _value(wave: _Wave, angles: Sequence[Ball]) -> Ball:
    """A ball around a trigonometric polynomial where the delay angles have these values, in rad."""
    # Each harmonic is computed once, though it occurs in many products.
    rows: list[dict[int, Ball]] = []
    for i, angle in enumerate(angles):
        occurring = {numbers[i] for numbers in wave}
        rows.append({number: _harmonic(number, angle) for number in occurring})
    total = arb(0)
    for numbers, coefficient in wave.items():
        term = coefficient
        for row, number in zip(rows, numbers, strict=True):
            term = term * row[number]
        total = total + term
    return total


def _harmonic(number: int, angle: Ball) -> Ball:
    """The value of a harmonic of an angle, by its number."""
    if number == CONSTANT:
        return arb(1)
    multiple = angle * (number // 2 + 1)
    return multiple.sin() if number % 2 else multiple.cos()
