"""Closed forms in lowest terms as a straight-line program: where the steps of a chain are 0/0, these have the limit.

Where a factor is the squared modulus of a factor R + j X of the dynamics, it is computed as R^2 + X^2, which is never
negative, and keeps its digits at a resonance.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flint import fmpq
from sympy import Integer, Rational, Symbol, sqrt

from haptisym.kernel.axis import Axis
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.kernel.symbols import omega
from haptisym.programs.program import Program, Writer, sincm1
from haptisym.programs.stable import Author, without_sinc_less_one


def closed_program(
    forms: Mapping[str, RealFunction], dynamics: Iterable[Polynomial], inputs: Sequence[Symbol]
) -> Program:
    """The program of some closed forms by name, of the ratios those of their squares.

    ``dynamics`` : the irreducible factors of H_env and of the denominators, polynomials in s. ``inputs`` : the parameters.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> d = distort(environments.maxwell(90, 4), effects.first_order_lag(20))
    >>> closed_program(d.functions(["ratio_real"]), [d.env.denominator], ()).results.keys()
    dict_keys(['ratio_real'])
    """
    author = _ClosedForms(Writer((omega, *inputs)))
    author.moduli = list(author.squares(next(iter(forms.values())).axis, dynamics))
    found = {name: author.root(f) if name.startswith("ratio") else author.quotient(f) for name, f in forms.items()}
    return author.write.program(found)


@dataclass(frozen=True)
class _Modulus:
    """A squared modulus: as a polynomial with leading coefficient 1, that coefficient, and the step that computes it."""

    monic: Polynomial
    lead: fmpq
    step: int


class _ClosedForms(Author):
    moduli: Sequence[_Modulus] = ()

    def squares(self, axis: Axis, dynamics: Iterable[Polynomial]) -> Iterator[_Modulus]:
        """|R + j X|^2 for each factor of the dynamics that is not a square already."""
        for p in dynamics:
            R, X = axis.parts([p])[0]
            if not R.is_zero() and not X.is_zero():
                halves = axis.half_angles(axis.function(R, X)) if axis.angles else axis.function(R, X)
                common = halves.numerator.gcd(halves.denominator)
                parts = halves.numerator / common, halves.denominator / common
                whole = parts[0] ** 2 + parts[1] ** 2
                lead = whole.leading_coefficient()
                real, imag = (self.write.polynomial(halves.ring, x) for x in parts)
                yield _Modulus(whole / lead, lead, self.square((real, imag)))

    def product(self, ring: PolynomialRing, polynomial: Polynomial) -> int:
        unit, factors = self.factors_of(ring, polynomial)
        total = self.write.expression(unit)
        for step, n, _ in factors:
            total = self.write.mul(total, self.write.power(step, n))
        return total

    def root(self, square: RealFunction) -> int:
        """The root of a real function that is nowhere negative: of each square, its magnitude."""
        hold = without_sinc_less_one(square)
        twice = hold and without_sinc_less_one(hold[1])
        if twice:
            angle, rest = twice
            return self.write.mul(self.write.abs(self.write.expression(sincm1(angle))), self.root(rest))
        f = square.half_angled.cleared()
        return self.write.div(self.root_of(f.ring, f.numerator), self.root_of(f.ring, f.denominator))

    def root_of(self, ring: PolynomialRing, polynomial: Polynomial) -> int:
        unit, factors = self.factors_of(ring, polynomial)
        total, write = self.write.expression(sqrt(unit)), self.write
        for step, n, positive in factors:
            size = step if positive else write.abs(step)
            total = write.mul(total, write.power(size, n // 2))
            total = write.mul(total, write.sqrt(size)) if n % 2 else total
        return total

    def factors_of(self, ring: PolynomialRing, polynomial: Polynomial) -> tuple[Any, list[tuple[int, int, bool]]]:
        """A number, and each factor with its exponent, and whether it is nowhere negative as it is written."""
        unit, factors = ring.factors(polynomial) if polynomial else (Integer(0), [])
        written = []
        for factor, n in factors:
            lead = factor.leading_coefficient()
            known = next((x for x in self.moduli if x.monic * lead == factor), None)
            if known:
                ratio = lead / known.lead
                unit *= Rational(int(ratio.p), int(ratio.q)) ** n
            written.append((known.step if known else self.write.polynomial(ring, factor), n, bool(known)))
        return unit, written
