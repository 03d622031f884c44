"""Whether a fitted model holds, by its residuals; and between which values each parameter lies, by its curvature."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from math import erfc, sqrt
from statistics import NormalDist

import numpy as np

from haptisym.model.measured import Complexes
from haptisym.model.parameters import Rule
from haptisym.verbs.identify.fitting import Fit
from haptisym.verbs.identify.wanted import Free

_EXACT = 1e-9  # of the largest response
_LEAST_LINES = 8
"""For a test of neighbours."""


@dataclass(frozen=True)
class Verdict:
    """What the residuals tell of a model.

    ``square`` : their chi^2, None where no disc is known; ``chance`` : of one that large where the model holds. ``neighbours`` :
    correlation of the residuals of neighbouring lines; ``neighbours_chance`` : of one that large. ``cube_chance`` : of
    records, of a force that follows the cube of what is predicted so much. ``fits`` : False where one of these is less likely
    than its part of what the confidence leaves; None where no disc is known and the others tell nothing.
    """

    square: float | None
    freedom: int
    chance: float | None
    neighbours: float | None
    neighbours_chance: float | None
    cube_chance: float | None
    fits: bool | None


def verdict(found: Fit) -> Verdict:
    """Are the residuals as large as the discs say, is one line's residual independent of the next one's, are records linear?"""
    from scipy.special import gammaincc

    known, welch = found.noise.freedom is not None, found.lines.welch
    square = float(found.noise.squares(found.residuals).sum()) if known else None
    chance = None if square is None or not found.freedom else float(gammaincc(found.freedom / 2, square / 2))
    # residuals that are no more than where least squares end tell nothing of the model
    is_exact = bool(np.abs(found.model - found.lines.H).max() <= _EXACT * np.abs(found.lines.H).max())
    together = None if is_exact else _neighbours(even(found))
    by_chance = None if together is None else erfc(together * sqrt(len(found.lines) - 1)) / 2
    by_cube = welch.cube_chance if welch else None
    spare = (1 - found.lines.confidence) / (2 if by_cube is None else 3)
    wrong = any(x is not None and x < spare for x in (chance, by_chance, by_cube))
    fits = False if wrong else True if chance is not None else None
    return Verdict(square, found.freedom, chance, together, by_chance, by_cube, fits)


def even(found: Fit) -> Complexes:
    """The residuals with their tails brought to those of a normal distribution."""
    size = np.abs(found.residuals)
    with np.errstate(invalid="ignore", divide="ignore"):
        shown = np.where(size > 0, found.residuals / size * np.sqrt(found.noise.squares(found.residuals)), 0)
    return np.asarray(shown, dtype=complex)


def _neighbours(residuals: Complexes) -> float | None:
    """The correlation of one line's residual with the next one's."""
    size = float(np.square(np.abs(residuals)).mean())
    if len(residuals) < _LEAST_LINES or size == 0:
        return None
    return float((residuals[1:] * np.conj(residuals[:-1])).real.mean() / size)


@dataclass(frozen=True)
class Estimate:
    """A parameter that was found, SI. ``low``, ``high`` : its confidence interval by itself; ``least``, ``most`` : its side of
    the box that holds all parameters together with the confidence, at least. ``error`` : standard error."""

    parameter: Free
    value: float
    error: float
    low: float
    high: float
    least: float
    most: float

    @property
    def told(self) -> bool:
        """Whether the lines tell it well enough for a range to mean anything: a positive one within a factor of two."""
        if self.parameter.rule is Rule.POSITIVE:
            return self.most <= 2 * self.value
        return self.parameter.rule is not Rule.FRACTION or self.most - self.least < 0.9


def estimates(found: Fit) -> tuple[Estimate, ...]:
    """Of all parameters; the box is Bonferroni's, each side with its share of what the confidence leaves."""
    spare, free = 1 - found.lines.confidence, found.wanted.free
    one, all_of_them = (_reach(found, 1 - spare / (2 * parts)) for parts in (1, len(free)))
    made = []
    for x, value, variance in zip(free, found.values.tolist(), np.diag(found.covariance).tolist(), strict=True):
        error = float(np.sqrt(variance))
        made.append(Estimate(x, value, error, *_ends(x, value, one * error), *_ends(x, value, all_of_them * error)))
    return tuple(made)


def _reach(found: Fit, share: float) -> float:
    """Standard errors from the middle to that share of the distribution."""
    from scipy.special import stdtrit

    if found.noise.freedom is None:
        return float(stdtrit(max(found.freedom, 1), share))
    return NormalDist().inv_cdf(share)


def _ends(x: Free, value: float, reach: float) -> tuple[float, float]:
    """An interval that keeps the parameter's rule: even in the logarithm where it must be positive."""
    if x.rule is Rule.POSITIVE:
        factor = float(np.exp(min(reach / value, 600.0)))
        low, high = value / factor, value * factor
    elif x.rule is Rule.FRACTION:
        step = float(np.exp(min(reach / (value * (1 - value)), 30.0)))
        odds = value / (1 - value)
        low, high = odds / step / (1 + odds / step), odds * step / (1 + odds * step)
    else:
        low, high = value - reach, value + reach
    return rounded(max(low, 0.0) if x.rule is Rule.NONNEGATIVE else low, ROUND_FLOOR), rounded(high, ROUND_CEILING)


_DIGITS = 6


def rounded(value: float, way: str) -> float:
    """A few digits, outward, so that a range stays one."""
    return float(Context(prec=_DIGITS, rounding=way).create_decimal_from_float(value))
