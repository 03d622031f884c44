"""What sign a real function of omega has at high frequency, or that it changes sign at infinitely
many frequencies.

A function is a sum of powers of omega, each times a sum of waves: sines and cosines of multiples of
angles. The highest power decides where what does not turn in it outweighs all that does: from some
frequency on all lower powers are less. Where its waves take both signs, they take both infinitely
often, as sums of waves come as near as one likes to every value they have.
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
_SAMPLES = 400
_MOST_DOUBLINGS = 80
_FIRST = Rational(1, 1 << 20)  # rad/s


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
        sign, least = waves.dominated(highest)
        if not least > 0:
            return AsymptoticSign(Sense.BOTH if waves.takes_both_signs(highest) else Sense.UNKNOWN)
        radius = waves.prevails(highest, least)
    return AsymptoticSign(Sense.UNKNOWN) if radius is None else AsymptoticSign(Sense(sign), radius)


_Group: TypeAlias = dict[tuple[int, ...], Ball]


class _Waves:
    """A polynomial of an axis as sums of products of harmonics of its angles, by the powers of
    omega before them."""

    def __init__(self, axis: Axis, polynomial: Polynomial) -> None:
        self.axis, self.polynomial = axis, polynomial
        self.turning = [i for i, angle in enumerate(axis.angles) if not angle.constant]
        top = [int(polynomial.degrees()[axis.size + i]) for i in self.turning]
        self.degrees = [n + n % 2 for n in top]  # even: times cos^n of a half angle keeps the sign

    @cached_property
    def groups(self) -> dict[Rational, _Group]:
        bits = _BITS + sum(
            self.degrees
        )  # sums of powers of a tangent cancel where harmonics are few
        with flint.ctx.workprec(bits):
            fixed = {
                a: expression_ball(tan(x.value / 2))
                for a, x in enumerate(self.axis.angles)
                if x.constant
            }
            found: dict[Rational, _Group] = {}
            for power, turns, constants, value in self._terms():
                own = arb(value) * arb.pi() ** constants[0]
                for place, n in constants[1].items():
                    own *= fixed[place] ** n
                group = found.setdefault(power, {})
                for waves, share in self._spread(turns):
                    group[waves] = group.get(waves, arb(0)) + own * share
            return found

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
        axis, angles = self.axis, len(self.axis.angles)
        for exponents, value in monomials(self.polynomial):
            own = [int(n) for n in exponents]
            turns, powers = own[axis.size : axis.size + angles], own[axis.size + angles :]
            power = sum(
                (n * order for n, order in zip(powers, axis.orders, strict=False)), Integer(own[0])
            )
            constants = {i: n for i, n in enumerate(turns) if n and i not in self.turning}
            yield power, tuple(turns[i] for i in self.turning), (own[1], constants), value

    def _value(self, group: _Group, angles: Sequence[Ball]) -> Ball:
        rows = [
            {wave: _wave(wave, angle) for wave in {waves[i] for waves in group}}
            for i, angle in enumerate(angles)
        ]
        return sum(
            (
                prod((row[x] for row, x in zip(rows, waves, strict=True)), start=c)
                for waves, c in group.items()
            ),
            arb(0),
        )

    def dominated(self, power: Rational) -> tuple[int, Ball]:
        """Of the waves before a power of omega: the sign of what does not turn, and by how much it
        outweighs all that does."""
        group, own = self.groups[power], (CONSTANT,) * len(self.turning)
        still = group.get(own, arb(0))
        return sign_of(still), (
            abs(still) - sum((abs(c) for x, c in group.items() if x != own), arb(0))
        ).lower()

    def takes_both_signs(self, power: Rational) -> bool:
        """Whether these waves are seen to, at some frequencies: then they do again and again."""
        signs = set[int]()
        for k in range(_SAMPLES if any(self.degrees) else 1):
            signs |= {sign_of(self._along(self.groups[power], k))} - {0}
            if len(signs) == 2:
                return True
        return False

    def _along(self, group: _Group, k: int) -> Ball:
        """The waves at one of some frequencies, which turn the fastest angle by about 0.23 each."""
        rates = [expression_ball(self.axis.angles[i].rate) for i in self.turning]
        step = arb(fmpq(229, 500)) / max(rates, key=float, default=arb(1))
        return self._value(group, [rate * step * (k + 1) for rate in rates])

    def prevails(self, power: Rational, least: Ball) -> Rational | None:
        """From where on ``least`` omega^power exceeds all lower powers together."""
        weights = {
            p: sum(map(abs, group.values()), arb(0))
            for p, group in self.groups.items()
            if p < power
        }
        radius = _FIRST
        for _ in range(_MOST_DOUBLINGS):
            base = expression_ball(radius)
            if least > sum(
                (w * base ** expression_ball(p - power) for p, w in weights.items()), arb(0)
            ):
                return radius
            radius *= 2
        return None


def _wave(wave: int, angle: Ball) -> Ball:
    """A harmonic of an angle, as `harmonics` numbers them."""
    if wave == CONSTANT:
        return arb(1)
    turned = angle * (wave // 2 + 1)
    return turned.sin() if wave % 2 else turned.cos()
