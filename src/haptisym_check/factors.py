"""Factors of functions: polynomials in omega (rule 2)."""

from fractions import Fraction
from functools import cached_property
from math import prod

from haptisym_check.polynomials import sign, signs, sliced
from haptisym_check.reading import Polynomial
from haptisym_check.scene import MOST_DELAYS, Value


class Factor:
    """A polynomial in omega^step."""

    step = 1
    waves: tuple[int, ...] = ()
    terms: list[tuple[tuple[int, ...], Polynomial]]

    def __init__(self, rows: Polynomial, step: int = 1, delays: int = 0) -> None:
        self.rows, self.step, self.waves, self.terms = rows, step, (0,) * delays, [((0,) * delays, rows)]
        self.cost = len(rows) ** 3  # of signs in one cell, with numbers of one bit

    @cached_property
    def slices(self) -> list[list[int]]:
        """Polynomials whose sum, with positive weights, it is for pi between its bounds."""
        return sliced(self.rows)

    def at(self, x: int, pi: int, tangents: tuple[int, ...]) -> Value:
        """The value, over cos(omega tau/2)^n for each delay, where its tangent is a whole number."""
        total, power = 0, x**self.step
        for turns, rows in self.terms:
            own = 0
            for row in reversed(rows):
                own = own * power + (row[0] if len(row) == 1 else sum(c * pi**i for i, c in enumerate(row)))
            total += own * prod(t**k for t, k in zip(tangents, turns, strict=True))
        high = self.step * max(len(p) - 1 for _, p in self.terms), max(len(row) - 1 for _, p in self.terms for row in p)
        return Value(total, 0, (*high, *self.waves, *[0] * (MOST_DELAYS - len(self.waves))))

    def signs(self, a: Fraction, b: Fraction) -> list[int]:
        """Of which the changes are the zeros between a and b, and zeros in front and behind the orders at them."""
        return signs(self.slices, (a**self.step).as_integer_ratio(), (b**self.step).as_integer_ratio())

    def sign(self, x: Fraction) -> int:
        """Of its value at a rational number."""
        return sign(self.slices, x**self.step)
