"""What sign a real function of omega has at high frequency, or that it changes sign at infinitely
many frequencies.

A function is a sum of powers of omega, each times a sum of waves: sines and cosines of multiples of
angles. The highest power decides where what does not turn in it outweighs all that does: from some
frequency on all lower powers are less. Where its waves take both signs, they take both infinitely
often: sums of waves are almost periodic, and come as near as one likes, again and again, to every
value they have. Where neither shows, the sign is ``UNKNOWN``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from itertools import product
from math import prod
from typing import TypeAlias

import flint
from flint import arb, fmpq
from sympy import Integer, Rational, tan

from haptisym.kernel.axis import CONSTANT, Axis, harmonics
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials
from haptisym.kernel.zeros import sign_of

_BITS = 128
_SAMPLES = 400  # frequencies at which both signs are looked for
# The radius is doubled from here, about 1e-6 rad/s, up to about 1e18 rad/s.
_FIRST = Rational(1, 1 << 20)
_MOST_DOUBLINGS = 80


class Sense(Enum):
    """The sign of a function above a frequency; ``POSITIVE`` and ``NEGATIVE`` allow for zeros."""

    POSITIVE = 1
    NEGATIVE = -1
    BOTH = 2
    UNKNOWN = 0


@dataclass(frozen=True)
class AsymptoticSign:
    """The sign of a function above ``radius``, rad/s; where it is ``BOTH`` or ``UNKNOWN`` there is
    no such radius."""

    sense: Sense
    radius: Rational = Integer(0)


def asymptotic_sign(f: RationalFunction) -> AsymptoticSign:
    """The sign at high frequency of a function of an axis, with numbers only, over a square:
    proven, or ``UNKNOWN``.

    The sign is that of its numerator, as its denominator must nowhere be negative: such is a
    response that is not reduced.

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
    polynomial = axis.without_circles(f.numerator)[0]
    if polynomial.is_zero():
        return AsymptoticSign(Sense.POSITIVE)
    waves = _Waves(axis, polynomial)
    highest = max(waves.groups)
    with flint.ctx.workprec(_BITS):
        # Without a constant part that outweighs the rest there is no radius, whatever lower powers
        # do.
        sign, least = waves.dominated(highest)
        if not least > 0:
            return AsymptoticSign(Sense.BOTH if waves.takes_both_signs(highest) else Sense.UNKNOWN)
        radius = waves.prevails(highest, least)
    return AsymptoticSign(Sense.UNKNOWN) if radius is None else AsymptoticSign(Sense(sign), radius)


_Group: TypeAlias = dict[tuple[int, ...], Ball]


class _Waves:
    """A polynomial of an axis as sums of products of harmonics of its angles, gathered by powers of
    omega."""

    def __init__(self, axis: Axis, polynomial: Polynomial) -> None:
        self.axis, self.polynomial = axis, polynomial
        self.turning = [i for i, angle in enumerate(axis.angles) if not angle.constant]
        top = [int(polynomial.degrees()[axis.size + i]) for i in self.turning]
        # Tangents become sines and cosines by a factor cos^n of each half angle; n even, it keeps
        # the sign.
        self.degrees = [n + n % 2 for n in top]

    @cached_property
    def groups(self) -> dict[Rational, _Group]:
        """For each power of omega the coefficients of its products of harmonics."""
        # Shares of harmonics over 2^n cancel where harmonics are few: n bits more make up for it.
        bits = _BITS + sum(self.degrees)
        with flint.ctx.workprec(bits):
            fixed = {
                a: expression_ball(tan(x.value / 2))
                for a, x in enumerate(self.axis.angles)
                if x.constant
            }
            groups: dict[Rational, _Group] = {}
            for power, turns, constants, value in self._terms():
                coefficient = arb(value) * arb.pi() ** constants[0]
                for place, n in constants[1].items():
                    coefficient *= fixed[place] ** n
                group = groups.setdefault(power, {})
                for waves, share in self._spread(turns):
                    group[waves] = group.get(waves, arb(0)) + coefficient * share
            return groups

    def _spread(self, turns: Sequence[int]) -> Iterator[tuple[tuple[int, ...], fmpq]]:
        """Powers of sines and cosines of half angles as a sum of products of waves."""
        sums = [harmonics(k, top).items() for k, top in zip(turns, self.degrees, strict=True)]
        for terms in product(*sums):
            yield (
                tuple(wave for wave, _ in terms),
                prod((share for _, share in terms), start=fmpq(1)),
            )

    def _terms(
        self,
    ) -> Iterator[tuple[Rational, tuple[int, ...], tuple[int, dict[int, int]], fmpq]]:
        """The monomials: power of omega, exponents of tangents that turn, exponents of pi and of
        the constant tangents, coefficient."""
        axis, angles = self.axis, len(self.axis.angles)
        for exponents, value in monomials(self.polynomial):
            degrees = [int(n) for n in exponents]
            turns = degrees[axis.size : axis.size + angles]
            powers = degrees[axis.size + angles :]
            broken = (n * order for n, order in zip(powers, axis.orders, strict=False))
            power = sum(broken, Integer(degrees[0]))
            constants = {i: n for i, n in enumerate(turns) if n and i not in self.turning}
            turning = tuple(turns[i] for i in self.turning)
            of_pi = degrees[1]
            yield power, turning, (of_pi, constants), value

    def _value(self, group: _Group, angles: Sequence[Ball]) -> Ball:
        """A ball around a sum of products of harmonics at these angles."""
        # Each harmonic is computed once, though it occurs in many products.
        rows: list[dict[int, Ball]] = []
        for i, angle in enumerate(angles):
            used = {waves[i] for waves in group}
            rows.append({wave: _wave(wave, angle) for wave in used})
        total = arb(0)
        for waves, coefficient in group.items():
            factors = (row[wave] for row, wave in zip(rows, waves, strict=True))
            total = total + prod(factors, start=coefficient)
        return total

    def dominated(self, power: Rational) -> tuple[int, Ball]:
        """For the waves of a power of omega: the sign of their constant part, and a lower bound of
        the amount by which it outweighs all harmonics; not > 0 where it does not."""
        group, constant = self.groups[power], (CONSTANT,) * len(self.turning)
        still = group.get(constant, arb(0))
        turning = sum((abs(c) for x, c in group.items() if x != constant), arb(0))
        return sign_of(still), (abs(still) - turning).lower()

    def takes_both_signs(self, power: Rational) -> bool:
        """Whether the waves of a power of omega are seen to take both signs. False proves
        nothing."""
        # One sample is enough for a number, which no angle changes.
        signs = set[int]()
        for k in range(_SAMPLES if any(self.degrees) else 1):
            signs |= {sign_of(self._along(self.groups[power], k))} - {0}
            if len(signs) == 2:
                return True
        return False

    def _along(self, group: _Group, k: int) -> Ball:
        """The value of the waves at the k-th of some frequencies."""
        # The fastest angle turns by 0.458 rad from one to the next, no rational part of a turn, so
        # that samples fall everywhere on the circle.
        rates = [expression_ball(self.axis.angles[i].rate) for i in self.turning]
        step = arb(fmpq(229, 500)) / max(rates, key=float, default=arb(1))
        return self._value(group, [rate * step * (k + 1) for rate in rates])

    def prevails(self, power: Rational, least: Ball) -> Rational | None:
        """A frequency from which on ``least`` omega^power exceeds all lower powers together; None
        where none is found."""
        weights = {
            p: sum(map(abs, group.values()), arb(0))
            for p, group in self.groups.items()
            if p < power
        }
        # Over omega^power the lower powers fall with omega: what holds at a radius holds above it.
        radius = _FIRST
        for _ in range(_MOST_DOUBLINGS):
            base = expression_ball(radius)
            lower = (w * base ** expression_ball(p - power) for p, w in weights.items())
            if least > sum(lower, arb(0)):
                return radius
            radius *= 2
        return None


def _wave(wave: int, angle: Ball) -> Ball:
    """The value of a harmonic of an angle, by its number in `harmonics`."""
    if wave == CONSTANT:
        return arb(1)
    turned = angle * (wave // 2 + 1)
    return turned.sin() if wave % 2 else turned.cos()
