"""What is assumed of NumPy's sin, cos, exp and log, and whether it holds here: all other bounds of a sweep are proven.

Assumed: for a double x the value returned is within ``ULPS`` units in the last place of the true one, for |x| <= ``MOST_ANGLE``
(sin, cos), -40 <= x <= 1 (exp), 0 < x <= 1 (log). IEEE 754 does not say so, and no library proves it. So it is tested where a
sweep runs, once in a process, against balls: at random numbers, and at those nearest to multiples of pi/2. If the test
fails, floats are not used for scenes that need these functions, and every set is answered exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import pi
from typing import Any

import flint
import numpy as np
from flint import arb

from haptisym.verbs.sweep.batch import Array

ULPS = 4.0
MOST_ANGLE = 1e4
"""Radians: beyond it floats are not asked for a sine or a cosine."""
_POINTS = 600
_BITS = 160


def ulp_errors() -> dict[str, float]:
    """The largest error found of each function, in units in the last place of the true value.

    >>> sorted(ulp_errors()), max(ulp_errors().values()) < ULPS
    (['cos', 'exp', 'log', 'sin'], True)
    """
    return {name: _worst(function, points, exact) for name, (function, points, exact) in _tested().items()}


@cache
def is_trusted() -> bool:
    """Whether the assumption holds at all points tested, in this process."""
    return all(error <= ULPS for error in ulp_errors().values())


def _tested() -> dict[str, tuple[Callable[[Array], Array], Array, Callable[[Any], Any]]]:
    rng = np.random.default_rng(2019)
    angles = np.exp(rng.uniform(np.log(1e-9), np.log(MOST_ANGLE), _POINTS))
    hard = np.arange(1, 200) * (pi / 2)
    angles = np.concatenate([angles, hard, -angles[::3]])
    small = np.exp(rng.uniform(np.log(1e-16), 0.0, _POINTS))
    near = 1.0 - np.exp(rng.uniform(np.log(1e-15), 0.0, _POINTS))
    return {
        "sin": (np.sin, angles, arb.sin),
        "cos": (np.cos, angles, arb.cos),
        "exp": (np.exp, np.concatenate([rng.uniform(-40.0, 1.0, _POINTS), -small]), arb.exp),
        "log": (np.log, np.concatenate([small, near]), arb.log),
    }


def _worst(function: Callable[[Array], Array], points: Array, exact: Callable[[Any], Any]) -> float:
    """Of an array, whose values may come from other code than those of single numbers, and of single numbers."""
    found = 0.0
    singles = np.array([function(x) for x in points[::7]])
    with flint.ctx.workprec(_BITS):
        for x, y in [*zip(points, function(points), strict=True), *zip(points[::7], singles, strict=True)]:
            truth = exact(arb(float(x)))
            apart = abs(arb(float(y)) - truth) / arb(float(np.spacing(abs(float(truth)))))
            found = max(found, float(apart.upper()))
    return found
