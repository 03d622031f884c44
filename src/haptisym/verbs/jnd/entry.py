"""The just-noticeable difference (JND) of a person from answers at several levels, ready for a
scene, and published JNDs. Estimated.

A psychometric function psi(x) = guess + (1 - guess - lapse) Phi((x - mu)/sigma), a cumulative
Gaussian between the rate of guesses and that of lapses, is fitted by maximum likelihood
(``Likelihood``). The interval of a quantity a mu + z sigma, such as the JND, has the values that
the likelihood does not refuse: with the quantity held at a value the best curve is found again, and
twice the fall of the logarithm is chi-squared with one degree of freedom (``_profiled``). The
descent goes over log sigma and (m - mu)/sigma with m in the middle of the levels, as over mu itself
the valley of a flat curve bends, and ends with Newton's steps (``_Way``). psignifit 4 fits the same
curve by Bayes' rule, and allows for answers that vary more than by chance. Read from ``jnd``.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context
from functools import cached_property
from itertools import product
from math import isfinite
from pathlib import Path
from statistics import NormalDist
from typing import Any, ClassVar, TypeAlias

import numpy as np

from haptisym.judge.answers import Answer, NoScene
from haptisym.kernel.budget import ONE_THREAD
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import Viewed, counted
from haptisym.model.jnd import Published, published_by_name
from haptisym.programs.values import Array
from haptisym.verbs.jnd.tables import (
    Answers,
    Coding,
    LevelAnswers,
    condensed,
    grouped,
    read_answers,
)

_NORMAL = NormalDist()


@dataclass(frozen=True, slots=True)
class PsychometricCurve(Viewed):
    """psi(x) = guess + (1 - guess - lapse) Phi((x - mu)/sigma).

    ``mu``, ``sigma`` : in the unit of the levels. ``guess``, ``lapse`` : shares of answers that do
    not depend on the level.
    """

    mu: float
    sigma: float
    guess: float = 0.0
    lapse: float = 0.0

    def __call__(self, level: Array) -> Array:
        from scipy.special import ndtr

        shares: Array = self.guess + (1 - self.guess - self.lapse) * ndtr(
            (level - self.mu) / self.sigma
        )
        return shares


@dataclass(frozen=True)
class WantedJnd:
    """The JND that is wanted of a curve: at ``proportion``, where it is a mu + z sigma.

    ``alternatives`` : of a forced choice between so many, whose levels are differences: the JND is
    the level at which that share of the answers would be right without lapses. None where a
    comparison with a standard is answered "more" or "less": the JND is then how much further than
    the point of subjective equality the share of "more", without guesses and lapses, is that.

    >>> WantedJnd(0.75, None).weights, WantedJnd(0.75, 2).weights
    ((0, 0.6744897501960817), (1, 0.0))
    """

    proportion: float
    alternatives: int | None

    def __post_init__(self) -> None:
        if not self.chance < self.proportion < 1:
            what = (
                f"of {self.alternatives} alternatives" if self.alternatives else "of a comparison"
            )
            raise SceneError(
                f"proportion: {self.proportion:g} must lie between chance, {self.chance:g} "
                f"{what}, and 1"
            )

    @classmethod
    def of(cls, proportion: float | None, alternatives: int | None) -> WantedJnd:
        """Return the wanted JND; without a proportion, halfway between chance and 1."""
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
        """The weights a and z of mu and sigma."""
        # Answers "more": the distance from mu to where Phi is the proportion. Forced choice: the
        # level at which guess + (1 - guess) Phi is the proportion.
        if not self.alternatives:
            return 0, _NORMAL.inv_cdf(self.proportion)
        return 1, _NORMAL.inv_cdf((self.proportion - self.chance) / (1 - self.chance))


LEAST_TRIALS = 5
"""The least number of answers in a group of levels when the deviance is tested: with fewer it is
far from chi-squared."""


@dataclass(frozen=True, slots=True)
class IntervalEstimate:
    """An estimated number and its interval; None where the interval has no end on a side."""

    value: float
    low: float | None
    high: float | None

    def scaled(self, factor: float) -> IntervalEstimate:
        """Return the estimate times a positive number."""
        low, high = (None if x is None else factor * x for x in (self.low, self.high))
        return IntervalEstimate(factor * self.value, low, high)

    @property
    def as_size(self) -> IntervalEstimate:
        """The same for a size: the lower end of its interval is at least 0."""
        return IntervalEstimate(
            self.value, None if self.low is None else max(self.low, 0.0), self.high
        )


@dataclass(frozen=True, slots=True)
class Deviance:
    """The deviance of answers from a curve: with so many degrees of freedom chi-squared is larger
    with probability ``p``.

    None where there are too few answers to tell. ``groups`` : of neighbouring levels, put together
    so that each has enough.
    """

    value: float
    degrees: int
    p: float | None
    groups: int

    @property
    def fits(self) -> bool | None:
        """Whether the curve fits: chance alone makes a larger deviance in at least one of twenty
        times. None where there are too few answers."""
        return None if self.p is None else self.p >= 0.05


@dataclass(frozen=True, slots=True)
class CurveFit:
    """A fitted curve, with the point of subjective equality (of a forced choice the middle of the
    curve), the JND and the deviance."""

    curve: PsychometricCurve
    middle: IntervalEstimate
    jnd: IntervalEstimate
    deviance: Deviance
    notes: tuple[str, ...] = ()


def grouped_words(found: Deviance, levels: int) -> str:
    """Return words for what was put together for the test of a fit; empty where nothing was."""
    if found.groups == levels:
        return ""
    return (
        f"{counted(levels, 'level')} put into {counted(found.groups, 'group')} of at least "
        f"{LEAST_TRIALS} answers"
    )


MOST_LAPSES = 0.1
"""Upper bound of a free share of lapses: without one a flat end of the curve could be all
lapses."""
_STEEP, _FLAT = 1e-3, 1e3
"""The least sigma, as a share of the smallest step between levels, and the largest, as a multiple
of the whole range: a step between two levels, and a curve that is flat over all of them."""
_FAR = 40
"""Sigmas by which the bounds of mu are wider where sigma is held."""
_MOST_SIGMAS = 1e5
"""Bound of |m - mu|/sigma, m in the middle of the levels."""
_NEWTON = 4
"""Newton's steps after the descent, to the last digits."""
_ROOT_2_PI = float(np.log(np.sqrt(2 * np.pi)))

Held: TypeAlias = "tuple[int, float, float]"
"""a, z and the value of a mu + z sigma."""


@dataclass(frozen=True)
class Best:
    """Where the likelihood is largest: the curve, minus its logarithm there, whether it is a step,
    or ran out of bounds."""

    curve: PsychometricCurve
    loss: float
    steep: bool
    flat: bool
    outside: bool


@dataclass(frozen=True)
class Likelihood:
    """The likelihood of curves, given the answers and a share of guesses; the share of lapses is a
    number, or free where it is None."""

    rows: tuple[LevelAnswers, ...]
    guess: float
    lapse: float | None

    @cached_property
    def table(self) -> tuple[Array, Array, Array]:
        """Levels, counts and trials."""
        level, count, trials = (
            np.array(x, float)
            for x in zip(*((r.level, r.count, r.trials) for r in self.rows), strict=True)
        )
        return level, count, trials

    @property
    def free(self) -> int:
        """Number of fitted parameters."""
        return 2 + (self.lapse is None)

    @cached_property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Bounds of mu, and of the logarithm of sigma."""
        level = self.table[0]
        # A middle that far outside the levels means that the answers do not reach the threshold.
        span = level[-1] - level[0]
        return (level[0] - 5 * span, level[-1] + 5 * span), (
            float(np.log(_STEEP * np.diff(level).min())),
            float(np.log(_FLAT * span)),
        )

    def loss(self, mu: float, spread: float, lapse: float) -> tuple[float, Array]:
        """Return minus the log-likelihood, without the binomial coefficients, and its slopes by
        mu, log sigma and lapse."""
        from scipy.special import log_ndtr, ndtr

        level, count, trials = self.table
        # Logarithms of psi and 1 - psi, and quotients of density over these as differences of
        # logarithms: far from mu, where psi is 1e-300, they still have all digits.
        with np.errstate(all="ignore"):
            sigma = np.exp(spread)
            z, width = (level - mu) / sigma, np.log(1 - self.guess - lapse)
            # psi = guess + (1 - guess - lapse) Phi(z), 1 - psi = lapse + (1 - guess - lapse)
            # Phi(-z).
            more = np.logaddexp(np.log(self.guess), width + log_ndtr(z))
            less = np.logaddexp(np.log(lapse), width + log_ndtr(-z))
            density = width - z * z / 2 - _ROOT_2_PI
            rest = trials - count
            by_more = _times(count, np.exp(density - more))
            by_less = _times(rest, np.exp(density - less))
            pull = by_more - by_less
            lapse_less = _times(rest, ndtr(z) / np.exp(less))
            lapse_more = _times(count, ndtr(z) / np.exp(more))
            by_lapse = lapse_less - lapse_more
            total = -(_times(count, more) + _times(rest, less)).sum()
            slopes = np.array([pull.sum() / sigma, (pull * z).sum(), -by_lapse.sum()])
        # An impossible curve is merely a very bad one, so that a search turns back from it.
        if np.isfinite(total) and np.isfinite(slopes).all():
            return float(total), slopes
        return 1e300, np.zeros(3)

    def best(self, held: Held | None = None, begun: PsychometricCurve | None = None) -> Best:
        """Return the best of all curves, or of those with a held value of a mu + z sigma.
        ``begun`` : a curve at which the search begins, else many."""
        way = _Way(self, held)
        starts = [way.numbers(begun)] if begun else way.starts()
        bottoms = [way.down(x) for x in starts]
        loss, numbers = way.refined(*min(bottoms, key=lambda x: x[0]))
        mu, spread, lapse = way.parameters(numbers)
        curve = PsychometricCurve(mu, float(np.exp(spread)), self.guess, lapse)
        (lowest, highest), (_, flattest) = self.bounds
        is_inside = lowest + 1e-9 < mu < highest - 1e-9
        is_flat = spread > flattest - 0.1
        return Best(curve, loss, self._is_step(curve), is_flat, not is_inside)

    def _is_step(self, curve: PsychometricCurve) -> bool:
        """Whether fewer than two levels lie on the slope of a curve, so that steeper ones are as
        likely."""
        from scipy.special import ndtr

        level, _, trials = self.table
        # Expected answers of the rarer kind at a level: below a thousandth it lies on a flat end.
        z = (level - curve.mu) / curve.sigma
        return bool((trials * np.minimum(ndtr(z), ndtr(-z)) > 1e-3).sum() < 2)

    def deviance(self, curve: PsychometricCurve) -> float:
        """Return twice the difference of the largest possible log-likelihood, that of the
        observed shares, and the curve's."""
        from scipy.special import xlogy

        _, count, trials = self.table
        observed = xlogy(count, count / trials) + xlogy(trials - count, 1 - count / trials)
        loss, _ = self.loss(curve.mu, float(np.log(curve.sigma)), curve.lapse)
        return max(0.0, 2 * float(observed.sum() + loss))


def _times(weight: Array, value: Array) -> Array:
    """Return weight times value, 0 where the weight is 0, whatever the value: no answers, no
    contribution."""
    weighted: Array = np.where(weight > 0, weight * value, 0.0)
    return weighted


@dataclass(frozen=True)
class _Way:
    """The way down the loss over the free numbers: log sigma, (m - mu)/sigma with m in the middle
    of the levels, and perhaps the lapses.

    Over mu itself the valley of a flat curve bends, and a descent stops on its way. Where a
    quantity is held, mu or log sigma is left.
    """

    likelihood: Likelihood
    held: Held | None

    def parameters(self, x: Sequence[float] | Array) -> tuple[float, float, float]:
        """Return mu, log sigma and lapse."""
        known = self.likelihood.lapse
        lapse = float(x[-1]) if known is None else known
        if self.held is None:
            return self._middle - float(x[0] * np.exp(x[1])), float(x[1]), lapse
        # mu + z sigma is held: log sigma is left. Or z sigma alone is: mu is left.
        a, z, value = self.held
        if a:
            return value - z * float(np.exp(x[0])), float(x[0]), lapse
        return float(x[0]), float(np.log(value / z)), lapse

    def numbers(self, curve: PsychometricCurve) -> list[float]:
        """Return the free numbers of a curve; what is held may be another value."""
        spread = float(np.log(curve.sigma))
        # Along a flat valley mu and sigma grow together, and their quotient hardly changes.
        bent = (self._middle - curve.mu) / curve.sigma
        kept = [bent, spread] if self.held is None else [spread if self.held[0] else curve.mu]
        return [*kept, *([curve.lapse] if self.likelihood.lapse is None else [])]

    @property
    def _middle(self) -> float:
        level = self.likelihood.table[0]
        return float(level[0] + level[-1]) / 2

    def starts(self) -> list[list[float]]:
        """Return starts all over the levels, with steep, middling and flat slopes."""
        level = self.likelihood.table[0]
        span, guess = level[-1] - level[0], self.likelihood.guess
        places = product(
            np.quantile(level, [0.1, 0.3, 0.5, 0.7, 0.9]), (0.05 * span, 0.2 * span, 0.8 * span)
        )
        return [
            self.numbers(PsychometricCurve(float(mu), float(sigma), guess, 0.02))
            for mu, sigma in places
        ]

    def down(self, start: Sequence[float]) -> tuple[float, Array]:
        """Return the loss and the free numbers at the bottom.

        The loss is divided by the number of trials: the first step is as long as the slopes, and
        those of many trials would leap so far that the descent does not return.
        """
        from scipy.optimize import minimize

        trials = self.likelihood.table[2].sum()

        def of_a_trial(x: Array) -> tuple[float, Array]:
            total, slopes = self._loss(x)
            return total / trials, slopes / trials

        options = {"ftol": 1e-15, "maxiter": 500}
        bottom: Any = minimize(
            of_a_trial, start, jac=True, method="SLSQP", bounds=self._bounds, options=options
        )
        return float(bottom.fun) * trials, bottom.x

    def refined(self, loss: float, x: Array) -> tuple[float, Array]:
        """Return loss and numbers to the last digits, where the bottom is inside the bounds;
        else as they are."""
        from scipy.optimize import approx_fprime

        bottom = np.array(x, float)
        with np.errstate(all="ignore"):
            for _ in range(_NEWTON):
                # Slopes are exact, and second derivatives are their differences: errors of these
                # slow the convergence and do not move the end.
                slopes = self._loss(bottom)[1]
                bends = np.atleast_2d(approx_fprime(bottom, lambda x: self._loss(x)[1]))
                if not np.isfinite(bends).all() or np.linalg.matrix_rank(bends) < len(bottom):
                    return loss, x
                bottom = bottom - np.linalg.solve(bends, slopes)
        # Newton's steps may also go to a saddle, or out: the end counts only if it is no worse.
        inside = all(low < x < high for x, (low, high) in zip(bottom, self._bounds, strict=True))
        lower = self._loss(bottom)[0] if inside else np.inf
        return (lower, bottom) if lower <= loss * (1 + 1e-9) else (loss, x)

    @property
    def _bounds(self) -> list[tuple[float, float]]:
        mu, spread = self.likelihood.bounds
        bounds = [(-_MOST_SIGMAS, _MOST_SIGMAS), spread]
        if self.held is not None:
            # A flat curve has its middle far beyond the levels: mu may go some sigmas further.
            a, z, value = self.held
            reach = _FAR * value / z if not a else 0.0
            bounds = [spread] if a else [(mu[0] - reach, mu[1] + reach)]
        return [*bounds, *([(0.0, MOST_LAPSES)] if self.likelihood.lapse is None else [])]

    def _loss(self, x: Array) -> tuple[float, Array]:
        """Return the loss and its slopes by the free numbers."""
        mu, spread, lapse = self.parameters(x)
        total, (by_mu, by_spread, by_lapse) = self.likelihood.loss(mu, spread, lapse)
        # The chain rule: mu = m - u sigma for the free number u, or mu = value - z sigma.
        if self.held is None:
            sigma = float(np.exp(spread))
            slopes = [-sigma * by_mu, by_spread - x[0] * sigma * by_mu]
        else:
            a, z, _ = self.held
            slopes = [by_spread - by_mu * z * np.exp(spread)] if a else [by_mu]
        if self.likelihood.lapse is None:
            slopes.append(by_lapse)
        return total, np.array(slopes)


def crossing(
    excess: Callable[[float], float], start: float, step: float, most: float
) -> float | None:
    """Return where a function that is negative at the start becomes positive in a direction;
    None if it does not within ``most`` steps."""
    from scipy.optimize import brentq

    # Steps grow, as an interval may be many standard errors wide; each still brackets one sign
    # change of a likelihood with a single peak.
    low, reach = start, 1.0
    while reach < most:
        high = start + reach * step
        if excess(high) > 0:
            return float(brentq(excess, low, high, xtol=1e-14, rtol=1e-12))
        low, reach = high, 1.7 * reach
    return None


_FARTHEST = 1e4
"""Standard deviations (about) within which the end of an interval is searched."""


def fitted(
    answers: Answers, asked: WantedJnd, guess: float, lapse: float | None, confidence: float
) -> CurveFit:
    """Return the most likely curve with its JND and intervals. SceneError where the answers do
    not determine one."""
    likelihood = Likelihood(answers.rows, guess, lapse)
    best = likelihood.best()
    _refuse(answers, best)
    middle = _profiled(likelihood, best, (1, 0.0), confidence)
    # Halfway between chance and 1 the JND of a forced choice is mu itself.
    jnd = (
        middle
        if asked.weights == (1, 0.0)
        else _profiled(likelihood, best, asked.weights, confidence)
    )
    if jnd.value <= 0:
        raise SceneError(
            f"{answers.name}: the JND would be {jnd.value:.4g}, not > 0: give levels of a "
            f"forced choice as differences "
            "from the standard"
        )
    return CurveFit(best.curve, middle, jnd, deviance(answers.rows, best.curve, likelihood.free))


def _refuse(answers: Answers, best: Best) -> None:
    """Raise SceneError where the best curve is flat, out of bounds, or a step."""
    level = [row.level for row in answers.rows]
    if best.flat or best.outside:
        why = (
            "counts decrease as levels increase; count the other responses"
            if _falls(answers.rows)
            else "the levels do not reach the threshold"
        )
        raise SceneError(
            f"{answers.name}: the responses do not change from one kind to the other as the "
            f"level increases: {why}"
        )
    if best.steep:
        below = max((x for x in level if x <= best.curve.mu), default=level[0])
        above = min((x for x in level if x > best.curve.mu), default=level[-1])
        raise SceneError(
            f"{answers.name}: the responses change from one kind to the other between "
            f"{below:g} and {above:g}: the slope is not "
            "determined; measure at levels in between"
        )


def _falls(rows: Sequence[LevelAnswers]) -> bool:
    """Whether answers count less often at high levels than at low ones."""
    half = len(rows) // 2
    low, high = rows[:half], rows[-half:]
    return sum(x.share for x in low) > sum(x.share for x in high)


def _profiled(
    likelihood: Likelihood, best: Best, weights: tuple[int, float], confidence: float
) -> IntervalEstimate:
    """Return a mu + z sigma and the values of it that the likelihood does not refuse: those at
    which twice its fall is at most the quantile of chi-squared."""
    from scipy.stats import chi2

    a, z = weights
    curve = best.curve
    value, most = a * curve.mu + z * curve.sigma, float(chi2.ppf(confidence, 1))

    def excess(x: float) -> float:
        # z sigma > 0: at 0 the interval ends in any case.
        if a == 0 and x <= 0:
            return 1e300
        return 2 * (likelihood.best((a, z, x), curve).loss - best.loss) - most

    # The standard error of mu is about sigma over the root of the number of trials.
    step = curve.sigma / max(1.0, sum(x.trials for x in likelihood.rows)) ** 0.5
    low, high = (crossing(excess, value, sign * step, _FARTHEST) for sign in (-1, 1))
    return IntervalEstimate(value, low, high)


def deviance(rows: Sequence[LevelAnswers], curve: PsychometricCurve, free: int) -> Deviance:
    """Return the deviance of answers from a curve with so many fitted numbers; levels with few
    answers are put together."""
    from scipy.stats import chi2

    groups = grouped(rows, LEAST_TRIALS)
    value = Likelihood(groups, curve.guess, curve.lapse).deviance(curve)
    degrees = len(groups) - free
    p = float(chi2.sf(value, degrees)) if degrees > 0 else None
    return Deviance(value, degrees, p, len(groups))


_WIDTH = 2 * NormalDist().inv_cdf(0.95)
"""The width of a cumulative Gaussian in sigma, as psignifit defines it: from 5 % to 95 %."""


def fitted_by_psignifit(answers: Answers, asked: WantedJnd, confidence: float) -> CurveFit:
    """Return the curve at the peak of psignifit's posterior. Guesses of a comparison are as many as
    lapses; both are fitted.

    The interval of a JND that depends on sigma alone is that of the width; of a forced choice, that
    of the threshold.
    """
    import psignifit  # another package: loaded where it is asked for
    from psignifit._utils import PsignifitException

    # The threshold is asked for where the JND of a forced choice is: its interval is then the
    # JND's.
    kind = f"{asked.alternatives}AFC" if asked.alternatives else "equal asymptote"
    middle = asked.weights[1] if asked.alternatives else 0.0
    data = np.array([(x.level, x.count, x.trials) for x in answers.rows], float)
    try:
        # Its warnings become notes of the answer: a library does not print.
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result: Any = psignifit.psignifit(
                data,
                experiment_type=kind,
                confP=(confidence,),
                verbose=True,
                thresh_PC=NormalDist().cdf(middle),
            )
    except (PsignifitException, ValueError, AssertionError) as error:
        raise SceneError(
            f"{answers.name}: psignifit cannot fit this: {str(error) or 'no reason given'}"
        ) from None
    words = (
        " ".join(str(x.message).removeprefix("psignifit:boundWarning").split()) for x in caught
    )
    sentences = (x.partition(". ")[0].rstrip(".") for x in words)
    notes = dict.fromkeys(f"psignifit warns: {x}" for x in sentences)
    return replace(_read_psignifit(result, answers, asked, str(confidence)), notes=tuple(notes))


def _read_psignifit(result: Any, answers: Answers, asked: WantedJnd, key: str) -> CurveFit:
    """Return psignifit's result as a curve, with its intervals at the confidence ``key``."""
    values = {name: float(x) for name, x in result.parameter_estimate_MAP.items()}
    sigma = values["width"] / _WIDTH
    a, z = asked.weights
    # The threshold of a forced choice was asked for at mu + z sigma, that of a comparison at mu.
    curve = PsychometricCurve(
        values["threshold"] - a * z * sigma, sigma, values["gamma"], values["lambda"]
    )
    threshold, width = (
        IntervalEstimate(values[name], *map(float, result.confidence_intervals[name][key]))
        for name in ("threshold", "width")
    )
    jnd = threshold if a else width.scaled(z / _WIDTH)
    # Of the middle of a forced choice's curve no interval is known, as the posterior was asked for
    # the threshold at another proportion.
    middle = threshold if not a or z == 0 else IntervalEstimate(curve.mu, None, None)
    return CurveFit(curve, middle, jnd, deviance(answers.rows, curve, 3))


METHODS = {"likelihood": "maximum likelihood", "psignifit": "psignifit 4"}


@dataclass(frozen=True, repr=False)
class Psychometric(Answer):
    """A psychometric function for answers at several levels, and the JND that it gives.

    ``answers`` : the data. ``fit`` : the curve, its middle (the point of subjective equality of a
    comparison), the JND with its interval, the deviance. ``reference`` : the level of the standard;
    the JND as a fraction of it is ``fraction``.
    """

    _schema: ClassVar[str] = "haptisym.jnd/1"
    _page: ClassVar[str] = "haptisym.pages.jnd:page"
    settled = True
    _figure: ClassVar[str] = "haptisym.figures.jnd:JND"

    answers: Answers
    asked: WantedJnd
    fit: CurveFit
    method: str = "likelihood"
    confidence: float = 0.95
    reference: float | None = None

    def _line(self) -> str:
        found = self.fraction or self.jnd
        return (
            f"{self.answers.name}: {'fraction' if self.fraction else 'JND'} {found.value:.4g} at "
            f"{self.asked.proportion:.4g}"
        )

    @property
    def certified(self) -> bool:
        """False: answers are measured, and what is fitted to them is an estimate."""
        return False

    @property
    def _about(self) -> NoScene:
        return NoScene(self.answers.name)

    @property
    def jnd(self) -> IntervalEstimate:
        """The JND, in the unit of the levels."""
        return self.fit.jnd

    @property
    def middle(self) -> IntervalEstimate:
        """The level at which the curve is halfway; for a comparison the point of subjective
        equality."""
        return self.fit.middle

    @property
    def fraction(self) -> IntervalEstimate | None:
        """The JND over the level of the standard; None without one."""
        return None if self.reference is None else self.jnd.scaled(1 / self.reference)

    @property
    def deviance(self) -> Deviance:
        """The deviance of the answers from the curve."""
        return self.fit.deviance

    @cached_property
    def table(self) -> dict[str, str]:
        """The threshold as the table ``jnd`` of a scene's ``[evaluation]``, values as TOML; empty
        without a fraction.

        The interval is a range. A comparison has its proportion, so that it can be brought to
        another one; the curve of a forced choice has another shape, and is asked for the proportion
        itself.
        """
        if self.fraction is None:
            return {}
        table = dict.fromkeys(("real", "imag"), _written(self.fraction))
        table["confidence"] = f"{self.confidence:g}"
        if not self.asked.alternatives:
            table["proportion"] = f"{self.asked.proportion:.15g}"
        return table

    @property
    def line(self) -> str:
        """The table as one line of a scene file; empty without a fraction."""
        entries = ", ".join(f"{key} = {value}" for key, value in self.table.items())
        return f"jnd = {{ {entries} }}" if entries else ""

    @property
    def notes(self) -> tuple[str, ...]:
        """Words for what was put together or left out."""
        grouped = grouped_words(self.deviance, len(self.answers.rows))
        tested = (
            (f"For the test of the fit: {grouped}",)
            if grouped and self.deviance.p is not None
            else ()
        )
        return (*self.answers.notes, *self.fit.notes, *tested)

    def _body(self) -> dict[str, Any]:
        curve, tested = self.fit.curve, self.deviance
        return {
            "alternatives": self.asked.alternatives,
            "proportion": self.asked.proportion,
            "confidence": self.confidence,
            "method": METHODS[self.method],
            "data": [{"level": x.level, "k": x.count, "n": x.trials} for x in self.answers.rows],
            "curve": {
                "mu": curve.mu,
                "sigma": curve.sigma,
                "guess": curve.guess,
                "lapse": curve.lapse,
            },
            "threshold": _row(self.middle),
            "jnd": _row(self.jnd),
            "reference": self.reference,
            "fraction": None if self.fraction is None else _row(self.fraction),
            "deviance": {
                "value": tested.value,
                "degrees": tested.degrees,
                "p": tested.p,
                "fits": tested.fits,
            },
            "line": self.line or None,
            "notes": list(self.notes),
            "certified": self.certified,
        }


def jnd(
    data: Answers | str | Path,
    *,
    proportion: float | None = None,
    alternatives: int | None = None,
    guess: float = 0.0,
    lapse: float | None = 0.0,
    reference: float | None = None,
    confidence: float = 0.95,
    method: str = "likelihood",
    columns: Mapping[str, str] | None = None,
    where: Mapping[str, str] | None = None,
    more: str | None = None,
) -> Psychometric:
    """Fit psi(x) = guess + (1 - guess - lapse) Phi((x - mu)/sigma) to the responses in a file;
    return the JND.

    ``data`` : a table (CSV) of levels with counts k of n, or of single responses 1 and 0, or JSON
    of psignifit 4.
    ``proportion`` : of "more", or of correct responses, at which the JND is taken; 0.75 for a
    comparison, else halfway between chance and 1. ``alternatives`` : number of choices of a forced
    choice, with levels that are differences from the standard.
    ``guess``, ``lapse`` : shares of responses that do not depend on the level; a lapse of None is
    fitted, up to 0.1.
    ``reference`` : level of the standard, in the unit of the levels. ``method`` : "likelihood", or
    "psignifit" (a package), which fits guesses and lapses itself. ``columns`` : names of the
    columns "level", "count", "trials" or "answer"; ``where`` : only lines with these values.
    ``more`` : the answer that means more, where answers are two words.

    Estimated: the interval is that of the profile likelihood at ``confidence``, and may have no
    upper end. SceneError for a table that cannot be read, and for responses without a threshold.
    Needs SciPy. Source: Wichmann and Hill (2001).

    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     table = Path(folder) / "responses.csv"
    ...     _ = table.write_text("level,k,n\\n4.4,5,40\\n4.7,11,40\\n5.0,19,40\\n5.3,26,40\\n5.6,33,40\\n5.9,37,40\\n")
    ...     print(f"{jnd(table, reference=5).jnd.value:.3f}")
    0.395
    """
    if not isinstance(data, Answers):
        data = read_answers(
            data, columns or {}, where or {}, Coding(more, reference, alternatives is not None)
        )
    answers = condensed(data)
    # A file of psignifit knows its forced choice: what the caller gives must not contradict it.
    choices = answers.alternatives if alternatives is None else alternatives
    if answers.alternatives not in (None, choices):
        raise SceneError(f"{answers.name} gives {answers.alternatives} alternatives, not {choices}")
    asked = WantedJnd.of(proportion, choices)
    _check(asked, guess, lapse, reference, confidence)
    if method not in METHODS:
        raise SceneError(f'method: "{str(method)[:60]}": valid are {", ".join(METHODS)}')
    if method == "psignifit":
        if guess or lapse != 0:
            raise SceneError("psignifit fits guesses and lapses itself: leave out guess and lapse")
        fit = fitted_by_psignifit(answers, asked, confidence)
    else:
        with ONE_THREAD:
            # A person who feels nothing is right once in as many trials as there are alternatives.
            fit = fitted(answers, asked, 1 / choices if choices else guess, lapse, confidence)
    # The profile of a forced choice may reach below 0, where a difference between levels has no
    # sense.
    if choices:
        fit = replace(fit, jnd=fit.jnd.as_size)
    return Psychometric(answers, asked, fit, method, confidence, reference)


def _check(
    asked: WantedJnd, guess: float, lapse: float | None, reference: float | None, confidence: float
) -> None:
    if asked.alternatives and guess:
        raise SceneError(
            "guess: leave it out, as a forced choice guesses one over the number of alternatives"
        )
    for key, share in (("guess", guess), ("lapse", lapse)):
        if share is not None and not 0 <= share < 0.5:
            raise SceneError(f"{key}: {share:g} must lie from 0 to below 0.5")
    if reference is not None and not (isfinite(reference) and reference > 0):
        raise SceneError(f"reference: {reference:g} must be a level above 0")
    if not 0 < confidence < 1:
        raise SceneError(f"confidence: {confidence:g} must lie between 0 and 1")


def _row(x: IntervalEstimate) -> dict[str, Any]:
    return {"value": x.value, "interval": [x.low, x.high]}


def _written(x: IntervalEstimate) -> str:
    """Return a range with its nominal value as TOML, the interval rounded outwards; the value alone
    where the interval has no end, or reaches 0, which no threshold may be."""
    nominal = _decimal(x.value, ROUND_HALF_EVEN)
    if x.low is None or x.high is None or x.low <= 0:
        return nominal
    return f"[{_decimal(x.low, ROUND_FLOOR)}, {nominal}, {_decimal(x.high, ROUND_CEILING)}]"


def _decimal(value: float, rounding: str) -> str:
    return f"{Context(prec=4, rounding=rounding).create_decimal_from_float(value):f}"


class PublishedThresholds(Answer, tuple[Published, ...]):
    """Published just-noticeable differences, a tuple of ``Published``; each may be used: ``jnd = {
    like = "fu2019" }``.

    Measured by their authors: ``certified`` is False. Made by ``published``.

    >>> published()[0].name, published()[0].written
    ('fu2019', '10 %')
    """

    _schema: ClassVar[str] = "haptisym.published/1"
    _figure: ClassVar[str] = "haptisym.figures.jnd:PUBLISHED"
    _page: ClassVar[str] = "haptisym.pages.jnd:published_page"
    settled = True

    def __new__(cls, found: Iterable[Published]) -> PublishedThresholds:
        return super().__new__(cls, found)

    def _line(self) -> str:
        return counted(len(self), "published threshold")

    @property
    def certified(self) -> bool:
        """False: they were measured."""
        return False

    @property
    def _about(self) -> NoScene:
        return NoScene("Published thresholds")

    def _body(self) -> dict[str, Any]:
        return {"thresholds": [_row_in_published(x) for x in self], "certified": self.certified}


def _row_in_published(x: Published) -> dict[str, Any]:
    return {
        "name": x.name,
        "quantity": x.quantity,
        "fraction": [float(x.low), float(x.high)],
        "criterion": None if x.criterion is None else float(x.criterion),
        "reference": x.reference,
        "source": x.source,
        "doi": x.doi or None,
        "read": x.read,
        "usable": not x.apart,
    }


def published() -> PublishedThresholds:
    """All published thresholds that the package knows, with their sources.

    >>> [x.name for x in published() if x.criterion]
    ['steering-wheel', 'viscosity-forced-choice', 'viscosity-matching']
    """
    return PublishedThresholds(published_by_name().values())
