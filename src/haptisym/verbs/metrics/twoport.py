"""A chain of effects as one two-port: what it does to every environment, and to none in particular."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial, RationalFunction, cleared
from haptisym.model.chain import Chain


@dataclass(frozen=True)
class TwoPort:
    """The chain matrix ``[F_h; X_h] = [[A, B], [C, D]] [F_e; X_e]`` of all effects, up to a common factor.

    What is read off it does not see that factor: quotients of entries, and det over a product of two entries.
    """

    ring: Ring
    A: Polynomial
    B: Polynomial
    C: Polynomial
    D: Polynomial

    @classmethod
    def of(cls, chain: Chain, ring: Ring | None = None) -> TwoPort:
        """The product of a chain's matrices, the one nearest the environment applied first."""
        ring = ring or chain.ring
        a, b, c, d = ring.constant(1), ring.constant(0), ring.constant(0), ring.constant(1)
        for matrix in chain.matrices:
            p, q, r, t = cleared([ring.convert(entry) for entry in matrix])
            a, b, c, d = p * a + q * c, p * b + q * d, r * a + t * c, r * b + t * d
        return cls(ring, a, b, c, d)

    @cached_property
    def det(self) -> Polynomial:
        """A D - B C."""
        return self.A * self.D - self.B * self.C

    def _over(self, top: Polynomial, bottom: Polynomial) -> RationalFunction | None:
        return None if bottom.is_zero() else self.ring.function(top, bottom).reduced()

    @property
    def least(self) -> RationalFunction | None:
        """Z_min = B/D, what is felt of no environment at all (H_env -> 0); None where that is infinite everywhere."""
        return self._over(self.B, self.D)

    @property
    def most(self) -> RationalFunction | None:
        """Z_max = A/C, what is felt of a rigid one (H_env -> infinity); None where nothing bounds it."""
        return self._over(self.A, self.C)

    @property
    def width(self) -> RationalFunction | None:
        """Z_width = Z_max - Z_min = det/(C D); None where nothing bounds it."""
        return self._over(self.det, self.C * self.D)

    @property
    def gain(self) -> RationalFunction | None:
        """g = det/D^2 = -h12 h21."""
        return self._over(self.det, self.D * self.D)

    @property
    def leak(self) -> RationalFunction | None:
        """C/D = h22."""
        return self._over(self.C, self.D)

    def sensitivity(self, H: RationalFunction) -> RationalFunction | None:
        """dH_perc/dH_env = det/(C H + D)^2 of the Moebius map, at the environment (or what is rendered) H."""
        below = self.C * H.numerator + self.D * H.denominator
        return self._over(self.det * H.denominator**2, below**2)
