"""What is drawn along a band, in floats: where curves are sampled, and what criteria judge there.

Curves are sampled as finely as they bend, with every proven frequency of the evaluation among the
samples. What is judged is a ratio against its threshold or, where a criterion has no number for its
limit, how many times its region must be enlarged.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from sympy import Expr, Poly, PolynomialError, fraction

from haptisym.judge.crossings import Criterion, PerceptFunction
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.regions import Joint, Sided
from haptisym.kernel.rings import omega, s
from haptisym.kernel.roots import Interval, Point
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array, Values


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
    """Even frequencies, all points of the chart, and ever closer ones around these and around
    resonances."""
    low, high = band_of(evaluation)
    points = np.array([float(point.omega) for point in evaluation.chart.points])
    # Distances from 1/8 of the band down to 1/2^33 of it, each half of the one before: whatever the
    # width of a feature about a centre, some samples lie as close together as it is wide.
    steps = (high - low) * 2.0 ** -np.arange(3, 34)
    centres = np.concatenate([points, _resonances(evaluation.distortion)])
    around = (centres[:, None] + np.concatenate([-steps, [0.0], steps])).ravel()
    return np.unique(
        np.concatenate([evenly(evaluation), points, around[(around > low) & (around < high)]])
    )


def _resonances(distortion: Distortion) -> Array:
    """The frequencies of all poles and zeros of H_env and H_perc: a lightly damped one makes a
    narrow feature."""
    polynomials = [p for H in (distortion.environment, distortion.perceived) for p in fraction(H)]
    return np.concatenate([_frequencies_of_roots(p) for p in polynomials])


def _frequencies_of_roots(polynomial: Expr) -> Array:
    """Return the imaginary parts of a polynomial's roots, rad/s; none if it is no polynomial in
    s."""
    try:
        coefficients = Poly(polynomial, s).all_coeffs()
    except PolynomialError:
        # H(s) is transcendental, as with a delay: the points of the chart have to do.
        return np.array([])
    # Roots in floats do: one that is a little off moves a sample, and decides nothing. The exact
    # division by the leading coefficient keeps numbers within the range of a float.
    frequencies: Array = np.abs(np.roots([complex(c / coefficients[0]) for c in coefficients]).imag)
    return frequencies


def refined(seen: Callable[[Array], Array], grid: Array) -> Array:
    """The grid, halved wherever a straight line strays from what is ``seen`` by more than 1/2000 of
    the axes."""
    # Ten halvings at most: at a pole or a jump the curve never becomes straight.
    for _ in range(10):
        ends, middle = seen(grid), (grid[1:] + grid[:-1]) / 2
        bent = (np.abs(seen(middle) - (ends[1:] + ends[:-1]) / 2) > 5e-4).any(axis=1)
        if not bent.any():
            break
        grid = np.union1d(grid, middle[bent])
    return grid


def in_window(values: Array, low: Any, high: Any) -> Array:
    """Values as fractions of the axes, those far outside brought near."""
    # What is more than a window away from the axes is not seen: brought near, it does not make
    # refined halve the grid about infinite values.
    inside: Array = np.clip(
        np.nan_to_num((values - low) / (high - low), nan=2, posinf=2, neginf=-1), -1, 2
    )
    return inside


def broken(values: Array, omega: Array, poles: Iterable[Point]) -> Array:
    """Values with a gap at each pole, so that no line is drawn through infinity."""
    gaps = np.isin(omega, [float(point.omega) for point in poles]) | ~np.isfinite(values).all(
        axis=1
    )
    broken: Array = np.where(gaps[:, None], np.nan, values)
    return broken


def poles_of(evaluation: Evaluation) -> list[Point]:
    """Return the points of the chart at which H_env or H_perc is infinite."""
    # A function whose order of vanishing at a point is negative has a pole there.
    keys = [
        (curve, part)
        for curve in (PerceptFunction.ENVIRONMENT, PerceptFunction.PERCEIVED)
        for part in Part
    ]
    return [
        point
        for point in evaluation.chart.points
        if any(point.orders.get(key, 0) < 0 for key in keys)
    ]


def top_of(everywhere: Array, evenly: Array, least: float = 0.0) -> float:
    """The upper end of an axis from 0: the highest value, unless that is a narrow peak far above
    most others."""
    # Even samples give each frequency the same weight in the quantiles; the closer ones about a
    # peak would make it count for most of the band.
    highest, upper = float(np.nanmax(everywhere)), evenly.max(axis=1)
    most, nearly_all = np.quantile(upper[np.isfinite(upper)], (0.75, 0.9))
    return 1.06 * highest if highest <= 3 * nearly_all else max(2.5 * float(most), 4 * least)


def responses(f: Callable[..., Values], omega: Array) -> Array:
    """Re and Im of H_env, then of H_perc, in four columns."""
    values = f(omega)
    return np.stack(
        [
            values.environment_real,
            values.environment_imag,
            values.perceived_real,
            values.perceived_imag,
        ],
        axis=1,
    )


def points_of(responses: Array) -> tuple[Array, Array]:
    """H_env and H_perc as points of the plane."""
    return responses[:, :2], responses[:, 2:]


def written(x: Criterion) -> str:
    """Return the symbol of what a criterion judges, for a legend or an axis."""
    return f"${_index(x.symbol)}$"


def threshold_symbol(x: Criterion) -> str:
    """Return the symbol of a criterion's threshold, with the index that its ratio has."""
    return f"${_index(re.sub('^[^_]*', 'c', x.symbol))}$"


def _index(symbol: str) -> str:
    """Return a symbol with its index set upright."""
    return re.sub(r"_(\w+)", r"_\\mathrm{\1}", symbol)


def is_share(x: Criterion) -> bool:
    """Whether a criterion has no number for its limit, so that what it judges is drawn as a
    multiple of that."""
    return x.region is not None or bool(x.threshold.has(omega))


def limit_of(x: Criterion) -> float:
    """Return the level that the drawn ratio, or multiple of the limit, must not exceed."""
    return 1.0 if is_share(x) else float(x.threshold)


def name_of(x: Criterion) -> str:
    """Return the name of what is drawn of a criterion, for a legend or an axis."""
    if x.joint:
        return f"$\\Delta H$ in the {x.joint.kind}"
    return f"{written(x)[:-1]}/{threshold_symbol(x)[1:]}" if is_share(x) else written(x)


def columns(criteria: Iterable[Criterion], values: Values, at: Array) -> Array:
    """Return what criteria judge, a column each, from compiled values at frequencies."""
    return np.stack(
        [found for x in criteria if (found := judged(x, values, at)) is not None], axis=1
    )


def judged(x: Criterion, values: Values, at: Array) -> Array | None:
    """Return what a criterion judges, at frequencies; None where nothing of the kind can be
    drawn."""
    if x.joint:
        return _enlarged(x.joint, values, at)
    if x.sampled is None:
        return None
    ratio: Array = x.sampled(values)
    if isinstance(x.region, Sided):
        return _share(x.region, ratio, values, at)
    found: Array = ratio / floats_of(x.threshold, at) if is_share(x) else ratio
    return found


def _enlarged(region: Joint, values: Values, at: Array) -> Array:
    """Return by which factor the region must be enlarged to hold the change; infinite where a ratio
    is."""
    across = np.copysign(values.ratio_real, values.real)
    up = np.copysign(values.ratio_imag, values.imag)
    # The formula of a region may take inf - inf or 0 * inf where H_env vanishes: infinite, too.
    with np.errstate(invalid="ignore"):
        factor: Array = region.enlarged(across, up, lambda x: floats_of(x, at))
    shown: Array = np.where(np.isnan(factor), np.inf, factor)
    return shown


def _share(region: Sided, ratio: Array, values: Values, at: Array) -> Array:
    """Return a ratio as a multiple of the limit that holds there."""
    real = region.part is Part.REAL
    env = values.environment_real if real else values.environment_imag
    perc = values.perceived_real if real else values.perceived_imag
    higher, lower = (floats_of(c, at) for c in (region.higher, region.lower))
    grows = np.abs(perc) - np.abs(env)
    # Whether the part has grown or shrunk in magnitude says which limit holds. Equal magnitudes are
    # no change or a change of sign, for which the larger limit holds.
    limit = np.where(grows > 0, higher, np.where(grows < 0, lower, np.maximum(higher, lower)))
    if region.floor is None:
        found: Array = ratio / limit
        return found
    size = np.hypot(values.environment_real, values.environment_imag)
    # With a floor the limit is a dynamics, not a fraction of H_env: the larger of both is compared
    # with the change itself.
    change = np.abs(values.real if real else values.imag)
    noticeable: Array = np.maximum(floats_of(region.floor, at), limit * size)
    return change / noticeable
