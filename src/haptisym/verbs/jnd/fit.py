"""What a fit of a psychometric function holds: estimates with their intervals, and how well the curve fits."""

from __future__ import annotations

from dataclasses import dataclass

from haptisym.kernel.shown import counted
from haptisym.verbs.jnd.curve import Curve

LEAST_TRIALS = 5
"""Of a group of levels of which the deviance is tested: with fewer answers chi-squared says nothing."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number and the interval of it; None where that has no end on a side."""

    value: float
    low: float | None
    high: float | None

    def scaled(self, factor: float) -> Estimate:
        """Times a positive number."""
        low, high = (None if x is None else factor * x for x in (self.low, self.high))
        return Estimate(factor * self.value, low, high)

    @property
    def as_size(self) -> Estimate:
        """Of a size, which is at least 0: so is the lower end of its interval."""
        return Estimate(self.value, None if self.low is None else max(self.low, 0.0), self.high)


@dataclass(frozen=True, slots=True)
class Deviance:
    """How far answers are from a curve: with so many degrees of freedom chi-squared is larger with probability ``p``.

    None where there are too few answers to tell. ``groups`` : of neighbouring levels, put together so that each has enough.
    """

    value: float
    degrees: int
    p: float | None
    groups: int

    @property
    def fits(self) -> bool | None:
        """Whether chance alone makes a larger one in at least one of twenty times."""
        return None if self.p is None else self.p >= 0.05


@dataclass(frozen=True, slots=True)
class Fit:
    """The curve, the point of subjective equality (of a forced choice the middle of the curve), the JND and the deviance."""

    curve: Curve
    middle: Estimate
    jnd: Estimate
    deviance: Deviance
    notes: tuple[str, ...] = ()


def grouped_words(found: Deviance, levels: int) -> str:
    """What was put together for the test of a fit; empty where nothing was."""
    if found.groups == levels:
        return ""
    return f"{counted(levels, 'level')} put into {counted(found.groups, 'group')} of at least {LEAST_TRIALS} answers"
