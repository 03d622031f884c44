"""Where curves are sampled: as finely as they bend, with every proven frequency of the evaluation among the samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from sympy import Expr, Poly, PolynomialError, fraction

from haptisym.judge.crossings import Curve
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.rings import s
from haptisym.kernel.roots import Interval, Point
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.programs.values import Array


def band_of(evaluation: Evaluation) -> tuple[float, float]:
    """The ends of the band, rad/s."""
    points = evaluation.chart.points
    return float(points[0].omega), float(points[-1].omega)


def ends_of(interval: Interval) -> tuple[float, float]:
    """The ends of an interval, rad/s."""
    return float(interval.low.omega), float(interval.high.omega)


def evenly(evaluation: Evaluation) -> Array:
    """Frequencies evenly along the band, rad/s."""
    return np.linspace(*band_of(evaluation), 801)


def sampled(evaluation: Evaluation) -> Array:
    """Even frequencies, all points of the chart, and ever closer ones around these and around resonances."""
    low, high = band_of(evaluation)
    points = np.array([float(point.omega) for point in evaluation.chart.points])
    steps = (high - low) * 2.0 ** -np.arange(3, 34)
    centres = np.concatenate([points, _resonances(evaluation.distortion)])
    around = (centres[:, None] + np.concatenate([-steps, [0.0], steps])).ravel()
    return np.unique(np.concatenate([evenly(evaluation), points, around[(around > low) & (around < high)]]))


def _resonances(distortion: Distortion) -> Array:
    """The frequencies of all poles and zeros of H_env and H_perc: a lightly damped one makes a narrow feature."""
    polynomials = [p for H in (distortion.environment, distortion.perceived) for p in fraction(H)]
    return np.concatenate([_frequencies_of_roots(p) for p in polynomials])


def _frequencies_of_roots(polynomial: Expr) -> Array:
    try:
        coefficients = Poly(polynomial, s).all_coeffs()
    except PolynomialError:  # H(s) is transcendental: the points of the chart have to do
        return np.array([])
    found: Array = np.abs(np.roots([complex(c / coefficients[0]) for c in coefficients]).imag)
    return found


def refined(seen: Callable[[Array], Array], grid: Array) -> Array:
    """The grid, halved wherever a straight line strays from what is ``seen`` by more than 1/2000 of the axes."""
    for _ in range(10):
        ends, middle = seen(grid), (grid[1:] + grid[:-1]) / 2
        bent = (np.abs(seen(middle) - (ends[1:] + ends[:-1]) / 2) > 5e-4).any(axis=1)
        if not bent.any():
            break
        grid = np.union1d(grid, middle[bent])
    return grid


def in_window(values: Array, low: Any, high: Any) -> Array:
    """Values as fractions of the axes, those far outside brought near."""
    inside: Array = np.clip(np.nan_to_num((values - low) / (high - low), nan=2, posinf=2, neginf=-1), -1, 2)
    return inside


def broken(values: Array, omega: Array, poles: Iterable[Point]) -> Array:
    """Values with a gap at each pole, so that no line is drawn through infinity."""
    gaps = np.isin(omega, [float(point.omega) for point in poles]) | ~np.isfinite(values).all(axis=1)
    broken: Array = np.where(gaps[:, None], np.nan, values)
    return broken


def poles_of(evaluation: Evaluation) -> list[Point]:
    """Where H_env or H_perc is infinite."""
    keys = [(curve, part) for curve in (Curve.ENVIRONMENT, Curve.PERCEIVED) for part in Part]
    return [point for point in evaluation.chart.points if any(point.orders.get(key, 0) < 0 for key in keys)]


def top_of(everywhere: Array, evenly: Array, least: float = 0.0) -> float:
    """The upper end of an axis from 0: the highest value, unless that is a narrow peak far above most others."""
    highest, upper = float(np.nanmax(everywhere)), evenly.max(axis=1)
    most, nearly_all = np.quantile(upper[np.isfinite(upper)], (0.75, 0.9))
    return 1.06 * highest if highest <= 3 * nearly_all else max(2.5 * float(most), 4 * least)
