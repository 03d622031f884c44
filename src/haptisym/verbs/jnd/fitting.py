"""A psychometric function fitted to answers by maximum likelihood, with intervals from the profile of the likelihood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from scipy.stats import chi2

from haptisym.kernel.errors import SceneError
from haptisym.verbs.jnd.answers import Answers, Row
from haptisym.verbs.jnd.curve import Asked, Curve
from haptisym.verbs.jnd.fit import LEAST_TRIALS, Deviance, Estimate, Fit
from haptisym.verbs.jnd.likelihood import Best, Likelihood, crossing

_FARTHEST = 1e4
"""Standard deviations (about) within which the end of an interval is looked for."""


def fitted(answers: Answers, asked: Asked, guess: float, lapse: float | None, confidence: float) -> Fit:
    """The most likely curve. SceneError where the answers do not determine one."""
    likelihood = Likelihood(answers.rows, guess, lapse)
    best = likelihood.best()
    _refuse(answers, best)
    middle = _profiled(likelihood, best, (1, 0.0), confidence)
    jnd = middle if asked.weights == (1, 0.0) else _profiled(likelihood, best, asked.weights, confidence)
    if jnd.value <= 0:
        raise SceneError(
            f"{answers.name}: the JND would be {jnd.value:.4g}, which is not > 0: levels of a forced choice must be differences "
            "from the standard"
        )
    return Fit(best.curve, middle, jnd, deviance(answers.rows, best.curve, likelihood.free))


def _refuse(answers: Answers, best: Best) -> None:
    level = [row.level for row in answers.rows]
    if best.flat or best.outside:
        told = (
            "counts fall as levels rise; count the other answers"
            if _falls(answers.rows)
            else "the levels do not reach it"
        )
        raise SceneError(f"{answers.name}: the answers do not go from one kind to the other as the level rises: {told}")
    if best.steep:
        below = max((x for x in level if x <= best.curve.mu), default=level[0])
        above = min((x for x in level if x > best.curve.mu), default=level[-1])
        raise SceneError(
            f"{answers.name}: the answers jump from one kind to the other between {below:g} and {above:g}: how steeply is not "
            "determined; measure at levels in between"
        )


def _falls(rows: Sequence[Row]) -> bool:
    half = len(rows) // 2
    low, high = rows[:half], rows[-half:]
    return sum(x.share for x in low) > sum(x.share for x in high)


def _profiled(likelihood: Likelihood, best: Best, weights: tuple[int, float], confidence: float) -> Estimate:
    """a mu + z sigma and the values of it that the likelihood does not refuse: twice its fall is chi-squared at most."""
    a, z = weights
    curve = best.curve
    value, most = a * curve.mu + z * curve.sigma, float(chi2.ppf(confidence, 1))

    def excess(x: float) -> float:
        if a == 0 and x <= 0:
            return 1e300
        return 2 * (likelihood.best((a, z, x), curve).loss - best.loss) - most

    step = curve.sigma / max(1.0, sum(x.trials for x in likelihood.rows)) ** 0.5
    low, high = (crossing(excess, value, sign * step, _FARTHEST) for sign in (-1, 1))
    return Estimate(value, low, high)


def deviance(rows: Sequence[Row], curve: Curve, free: int) -> Deviance:
    """The deviance of answers from a curve with so many fitted numbers; levels with few answers are put together."""
    groups = tuple(_grouped(rows))
    found = Likelihood(groups, curve.guess, curve.lapse).deviance(curve)
    degrees = len(groups) - free
    return Deviance(found, degrees, float(chi2.sf(found, degrees)) if degrees > 0 else None, len(groups))


def _grouped(rows: Sequence[Row]) -> list[Row]:
    """Neighbouring levels put together until each group has enough trials, at the mean of their levels."""
    groups: list[Row] = []
    for row in rows:
        if groups and groups[-1].trials < LEAST_TRIALS:
            groups[-1] = _together(groups[-1], row)
        else:
            groups.append(row)
    if len(groups) > 1 and groups[-1].trials < LEAST_TRIALS:
        last = groups.pop()
        groups[-1] = _together(groups[-1], last)
    return groups


def _together(one: Row, other: Row) -> Row:
    trials = one.trials + other.trials
    level = (one.level * one.trials + other.level * other.trials) / trials
    return replace(one, level=level, count=one.count + other.count, trials=trials)
