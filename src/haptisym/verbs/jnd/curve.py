"""The psychometric function: a cumulative Gaussian between the rate of guesses and that of lapses."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist

from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import Viewed
from haptisym.programs.values import Array

_NORMAL = NormalDist()


@dataclass(frozen=True, slots=True)
class Curve(Viewed):
    """psi(x) = guess + (1 - guess - lapse) Phi((x - mu)/sigma).

    ``mu``, ``sigma`` : in the unit of the levels. ``guess``, ``lapse`` : shares of answers that do not depend on the level.
    """

    mu: float
    sigma: float
    guess: float = 0.0
    lapse: float = 0.0

    def __call__(self, level: Array) -> Array:
        from scipy.special import ndtr

        shares: Array = self.guess + (1 - self.guess - self.lapse) * ndtr((level - self.mu) / self.sigma)
        return shares


@dataclass(frozen=True)
class Asked:
    """What is wanted of a curve: the JND at ``proportion``, which is a mu + z sigma.

    ``alternatives`` : of a forced choice between so many, whose levels are differences: the JND is the level at which that share
    of the answers would be right without lapses. None where a comparison with a standard is answered "more" or "less": the JND
    is then how much further than the point of subjective equality the share of "more", without guesses and lapses, is that.

    >>> Asked(0.75, None).weights, Asked(0.75, 2).weights
    ((0, 0.6744897501960817), (1, 0.0))
    """

    proportion: float
    alternatives: int | None

    def __post_init__(self) -> None:
        if not self.chance < self.proportion < 1:
            what = f"of {self.alternatives} alternatives" if self.alternatives else "of a comparison"
            raise SceneError(f"proportion: {self.proportion:g} must lie between chance, {self.chance:g} {what}, and 1")

    @classmethod
    def of(cls, proportion: float | None, alternatives: int | None) -> Asked:
        """The same; without a proportion, halfway between chance and 1."""
        if alternatives is not None and alternatives < 2:
            raise SceneError(f"a forced choice has at least 2 alternatives, not {alternatives}")
        chance = 1 / alternatives if alternatives else 0.5
        return cls((1 + chance) / 2 if proportion is None else proportion, alternatives)

    @property
    def chance(self) -> float:
        """The share of answers that a person who feels nothing gets."""
        return 1 / self.alternatives if self.alternatives else 0.5

    @property
    def weights(self) -> tuple[int, float]:
        """a and z."""
        if not self.alternatives:
            return 0, _NORMAL.inv_cdf(self.proportion)
        return 1, _NORMAL.inv_cdf((self.proportion - self.chance) / (1 - self.chance))
