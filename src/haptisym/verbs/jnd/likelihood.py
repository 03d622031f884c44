"""The likelihood of answers under a psychometric function, and where it is largest: freely, or with one quantity held."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import approx_fprime, brentq, minimize
from scipy.special import log_ndtr, ndtr, xlogy

from haptisym.programs.values import Array
from haptisym.verbs.jnd.answers import Row
from haptisym.verbs.jnd.curve import Curve

MOST_LAPSES = 0.1
"""Where a free share of lapses ends."""
_STEEP, _FLAT = 1e-3, 1e3
"""The least sigma, of the smallest step between levels, and the largest, of the whole range."""
_FAR = 40
"""Sigmas beyond the bounds of mu where sigma is held."""
_MOST_SIGMAS = 1e5
"""Between the middle of the levels and mu."""
_NEWTON = 4
"""Steps to the last digits."""
_ROOT_2_PI = float(np.log(np.sqrt(2 * np.pi)))

Held: TypeAlias = "tuple[int, float, float]"
"""a, z and the value of a mu + z sigma."""


@dataclass(frozen=True)
class Best:
    """Where the likelihood is largest: the curve, minus its logarithm there, whether it is a step, or ran out of bounds."""

    curve: Curve
    loss: float
    steep: bool
    flat: bool
    outside: bool


@dataclass(frozen=True)
class Likelihood:
    """Of the answers, with a share of guesses; the share of lapses is a number, or free where it is None."""

    rows: tuple[Row, ...]
    guess: float
    lapse: float | None

    @cached_property
    def table(self) -> tuple[Array, Array, Array]:
        """Levels, counts and trials."""
        level, count, trials = (
            np.array(x, float) for x in zip(*((r.level, r.count, r.trials) for r in self.rows), strict=True)
        )
        return level, count, trials

    @property
    def free(self) -> int:
        """How many numbers are fitted."""
        return 2 + (self.lapse is None)

    @cached_property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Of mu, and of the logarithm of sigma."""
        level = self.table[0]
        span = level[-1] - level[0]
        return (level[0] - 5 * span, level[-1] + 5 * span), (
            float(np.log(_STEEP * np.diff(level).min())),
            float(np.log(_FLAT * span)),
        )

    def loss(self, mu: float, spread: float, lapse: float) -> tuple[float, Array]:
        """Minus the log-likelihood without its constant, and its slopes by mu, log sigma and lapse."""
        level, count, trials = self.table
        with np.errstate(all="ignore"):
            sigma = np.exp(spread)
            z, width = (level - mu) / sigma, np.log(1 - self.guess - lapse)
            more = np.logaddexp(np.log(self.guess), width + log_ndtr(z))
            less = np.logaddexp(np.log(lapse), width + log_ndtr(-z))
            density = width - z * z / 2 - _ROOT_2_PI
            pull = _times(count, np.exp(density - more)) - _times(trials - count, np.exp(density - less))
            by_lapse = _times(trials - count, ndtr(z) / np.exp(less)) - _times(count, ndtr(z) / np.exp(more))
            total = -(_times(count, more) + _times(trials - count, less)).sum()
            slopes = np.array([pull.sum() / sigma, (pull * z).sum(), -by_lapse.sum()])
        return (float(total), slopes) if np.isfinite(total) and np.isfinite(slopes).all() else (1e300, np.zeros(3))

    def best(self, held: Held | None = None, begun: Curve | None = None) -> Best:
        """The best of all curves, or of those with a value of a mu + z sigma; ``begun`` : where to look, else all over."""
        way = _Way(self, held)
        found = [way.down(x) for x in ([way.numbers(begun)] if begun else way.starts())]
        loss, numbers = way.refined(*min(found, key=lambda x: x[0]))
        mu, spread, lapse = way.parameters(numbers)
        curve, (around, (_, high)) = Curve(mu, float(np.exp(spread)), self.guess, lapse), self.bounds
        inside = around[0] + 1e-9 < mu < around[1] - 1e-9
        return Best(curve, loss, self._is_step(curve), spread > high - 0.1, not inside)

    def _is_step(self, curve: Curve) -> bool:
        """Whether fewer than two levels lie on the slope, so far that some answer could tell."""
        level, _, trials = self.table
        z = (level - curve.mu) / curve.sigma
        return bool((trials * np.minimum(ndtr(z), ndtr(-z)) > 1e-3).sum() < 2)

    def deviance(self, curve: Curve) -> float:
        """Twice what the log-likelihood lacks from that of the shares themselves."""
        _, count, trials = self.table
        kept = xlogy(count, count / trials) + xlogy(trials - count, 1 - count / trials)
        return max(0.0, 2 * float(kept.sum() + self.loss(curve.mu, float(np.log(curve.sigma)), curve.lapse)[0]))


def _times(weight: Array, value: Array) -> Array:
    """Their product, 0 where the weight is."""
    found: Array = np.where(weight > 0, weight * value, 0.0)
    return found


@dataclass(frozen=True)
class _Way:
    """Down the loss by what is free: log sigma, (m - mu)/sigma with m in the middle of the levels, and perhaps the lapses.

    Over mu itself the valley of a flat curve bends, and a descent stops on its way. Where a quantity is held, mu or log sigma
    is left.
    """

    likelihood: Likelihood
    held: Held | None

    def parameters(self, x: Sequence[float] | Array) -> tuple[float, float, float]:
        """mu, log sigma and lapse."""
        known = self.likelihood.lapse
        lapse = float(x[-1]) if known is None else known
        if self.held is None:
            return self._middle - float(x[0] * np.exp(x[1])), float(x[1]), lapse
        a, z, value = self.held
        if a:
            return value - z * float(np.exp(x[0])), float(x[0]), lapse
        return float(x[0]), float(np.log(value / z)), lapse

    def numbers(self, curve: Curve) -> list[float]:
        spread = float(np.log(curve.sigma))
        bent = (self._middle - curve.mu) / curve.sigma
        kept = [bent, spread] if self.held is None else [spread if self.held[0] else curve.mu]
        return [*kept, *([curve.lapse] if self.likelihood.lapse is None else [])]

    @property
    def _middle(self) -> float:
        level = self.likelihood.table[0]
        return float(level[0] + level[-1]) / 2

    def starts(self) -> list[list[float]]:
        level = self.likelihood.table[0]
        span, guess = level[-1] - level[0], self.likelihood.guess
        places = product(np.quantile(level, [0.1, 0.3, 0.5, 0.7, 0.9]), (0.05 * span, 0.2 * span, 0.8 * span))
        return [self.numbers(Curve(float(mu), float(sigma), guess, 0.02)) for mu, sigma in places]

    def down(self, start: Sequence[float]) -> tuple[float, Array]:
        """The loss and the numbers at the bottom.

        The loss is that of a trial: how long the first step is follows from the slopes, and those of many trials leap beyond
        everything, from where a descent does not return.
        """
        trials = self.likelihood.table[2].sum()

        def of_a_trial(x: Array) -> tuple[float, Array]:
            total, slopes = self._loss(x)
            return total / trials, slopes / trials

        options = {"ftol": 1e-15, "maxiter": 500}
        found: Any = minimize(of_a_trial, start, jac=True, method="SLSQP", bounds=self._bounds, options=options)
        return float(found.fun) * trials, found.x

    def refined(self, loss: float, x: Array) -> tuple[float, Array]:
        """The same to the last digits, where the bottom is inside the bounds."""
        bottom = np.array(x, float)
        with np.errstate(all="ignore"):
            for _ in range(_NEWTON):
                slopes, bends = self._loss(bottom)[1], np.atleast_2d(approx_fprime(bottom, lambda x: self._loss(x)[1]))
                if not np.isfinite(bends).all() or np.linalg.matrix_rank(bends) < len(bottom):
                    return loss, x
                bottom = bottom - np.linalg.solve(bends, slopes)
        inside = all(low < x < high for x, (low, high) in zip(bottom, self._bounds, strict=True))
        lower = self._loss(bottom)[0] if inside else np.inf
        return (lower, bottom) if lower <= loss * (1 + 1e-9) else (loss, x)

    @property
    def _bounds(self) -> list[tuple[float, float]]:
        mu, spread = self.likelihood.bounds
        own = [(-_MOST_SIGMAS, _MOST_SIGMAS), spread]
        if self.held is not None:
            a, z, value = self.held
            reach = _FAR * value / z if not a else 0.0  # a flat curve has its middle far beyond the levels
            own = [spread] if a else [(mu[0] - reach, mu[1] + reach)]
        return [*own, *([(0.0, MOST_LAPSES)] if self.likelihood.lapse is None else [])]

    def _loss(self, x: Array) -> tuple[float, Array]:
        mu, spread, lapse = self.parameters(x)
        total, (by_mu, by_spread, by_lapse) = self.likelihood.loss(mu, spread, lapse)
        if self.held is None:
            sigma = float(np.exp(spread))
            own = [-sigma * by_mu, by_spread - x[0] * sigma * by_mu]
        else:
            a, z, _ = self.held
            own = [by_spread - by_mu * z * np.exp(spread)] if a else [by_mu]
        return total, np.array([*own, *([by_lapse] if self.likelihood.lapse is None else [])])


def crossing(excess: Callable[[float], float], start: float, step: float, most: float) -> float | None:
    """Where a function that is negative at the start becomes positive in a direction; None within ``most`` steps."""
    low, reach = start, 1.0
    while reach < most:
        high = start + reach * step
        if excess(high) > 0:
            return float(brentq(excess, low, high, xtol=1e-14, rtol=1e-12))
        low, reach = high, 1.7 * reach
    return None
