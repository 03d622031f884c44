"""Distortions whose powers s^alpha are Re and Im of (j omega)^alpha, as a certificate tells them, not modulus and angle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property

from sympy import Expr, Symbol

from haptisym.kernel.axis import Axis, ComplexPolynomial
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.model.distortion import Distortion

_LAST = "\U0010ffff"
"""Symbols are sorted by their names: no other one stands behind those with this."""


class RectangularAxis(Axis):
    """Real functions in omega, pi, tan(omega tau/2) and two independent variables for each power: its real and imaginary part."""

    def __init__(self, symbols: Sequence[Symbol], lags: Sequence[Expr], powers: Sequence[Expr], *, j: bool) -> None:
        names = [Symbol(f"{_LAST}{i:02}{part}") for i in range(len(powers)) for part in "ab"]
        super().__init__([*symbols, *names], lags, (), j=j)
        self.powers = tuple(powers)
        self._inner = Ring([*symbols, *names], lags, (), j=j)
        self._start = 2 + len(symbols)

    def parts(self, polynomials: Sequence[Polynomial]) -> list[ComplexPolynomial]:
        split = [self._by_powers(p) for p in polynomials]
        found = iter(super().parts([q for row in split for q in row.values()]))
        return [self._joined([*row], found) for row in split]

    def _by_powers(self, polynomial: Polynomial) -> dict[tuple[int, ...], Polynomial]:
        """What stands before each product of powers: the dynamics' variables are s, pi, symbols, delays, powers and j."""
        start = self._start
        first, rows = start + self.delays, dict[tuple[int, ...], dict[tuple[int, ...], object]]()
        for exponents, value in polynomial.to_dict().items():
            own = tuple(map(int, exponents))
            powers, rest = own[first : first + len(self.powers)], own[first + len(self.powers) :]
            inner = (*own[:start], *[0] * (2 * len(self.powers)), *own[start:first], *rest)
            rows.setdefault(powers, {})[inner] = value
        return {powers: self._inner.context.from_dict(row) for powers, row in rows.items()}

    def _joined(self, powers: Sequence[tuple[int, ...]], found: Iterator[ComplexPolynomial]) -> ComplexPolynomial:
        """The sum of parts times their powers (x + j y)^n."""
        gens, real, imag = self.context.gens(), self.constant(0), self.constant(0)
        for exponents, (x, y) in zip(powers, found, strict=False):
            for i, n in enumerate(exponents):
                a, b = gens[self._start + 2 * i : self._start + 2 * i + 2]
                for _ in range(n):
                    x, y = x * a - y * b, x * b + y * a
            real, imag = real + x, imag + y
        return real, imag


class RectangularRing(Ring):
    """The same dynamics as a ring, on such an axis."""

    @classmethod
    def like(cls, ring: Ring) -> RectangularRing:
        """With the same variables."""
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
