"""The same by psignifit 4: a Bayesian fit that allows for answers that vary more than by chance."""

from __future__ import annotations

import warnings
from dataclasses import replace
from statistics import NormalDist
from typing import Any

import numpy as np
import psignifit
from psignifit._utils import PsignifitException

from haptisym.kernel.errors import SceneError
from haptisym.verbs.jnd.answers import Answers
from haptisym.verbs.jnd.curve import Asked, Curve
from haptisym.verbs.jnd.fit import Estimate, Fit
from haptisym.verbs.jnd.fitting import deviance

_WIDTH = 2 * NormalDist().inv_cdf(0.95)
"""What psignifit calls the width of a cumulative Gaussian, in sigma: from 5 % to 95 %."""


def fitted_by_psignifit(answers: Answers, asked: Asked, confidence: float) -> Fit:
    """The curve at the peak of the posterior. Guesses of a comparison are as many as lapses; both are fitted.

    The interval of a JND that depends on sigma alone is that of the width; of a forced choice, that of the threshold.
    """
    kind = f"{asked.alternatives}AFC" if asked.alternatives else "equal asymptote"
    middle = asked.weights[1] if asked.alternatives else 0.0
    data = np.array([(x.level, x.count, x.trials) for x in answers.rows], float)
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            found: Any = psignifit.psignifit(
                data, experiment_type=kind, confP=(confidence,), verbose=True, thresh_PC=NormalDist().cdf(middle)
            )
    except (PsignifitException, ValueError, AssertionError) as error:
        raise SceneError(f"{answers.name}: psignifit cannot fit this: {str(error) or 'it gives no reason'}") from None
    notes = dict.fromkeys(f"psignifit warns: {_first_sentence(str(x.message))}" for x in told)
    return replace(_read(found, answers, asked, str(confidence)), notes=tuple(notes))


def _first_sentence(message: str) -> str:
    return " ".join(message.removeprefix("psignifit:boundWarning").split()).partition(". ")[0].rstrip(".")


def _read(found: Any, answers: Answers, asked: Asked, key: str) -> Fit:
    values = {name: float(x) for name, x in found.parameter_estimate_MAP.items()}
    sigma = values["width"] / _WIDTH
    a, z = asked.weights
    curve = Curve(values["threshold"] - a * z * sigma, sigma, values["gamma"], values["lambda"])
    threshold, width = (
        Estimate(values[name], *map(float, found.confidence_intervals[name][key])) for name in ("threshold", "width")
    )
    jnd = threshold if a else width.scaled(z / _WIDTH)
    middle = threshold if not a or z == 0 else Estimate(curve.mu, None, None)
    return Fit(curve, middle, jnd, deviance(answers.rows, curve, 3))
