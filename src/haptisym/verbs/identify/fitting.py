"""A model with free numbers, where a fit begins, and weighted least squares.

A model with free parameters as a function of numbers: the response at all lines, for many sets of values at once.

Values to begin a fit with: of models from their units and the lines' own scales, of fractions from linear least squares.

Weighted least squares: the values with which a model lies nearest to measured lines, and how well the lines tell them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import counted
from haptisym.model.distortion import distort
from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.parameters import Rule
from haptisym.model.quantities import Dimension
from haptisym.verbs.identify.wanted import Free, Wanted


@dataclass(frozen=True, eq=False)
class Curve:
    """H_perc of what is wanted at frequencies, rad/s."""

    wanted: Wanted
    omega: Reals

    @cached_property
    def _compiled(self) -> Callable[..., Any]:
        own, effects = self.wanted.elements(lambda x: x.symbol)
        return distort(own, *effects).compile(of=["perceived_real", "perceived_imag"])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the free parameters, in their order."""
        return tuple(x.symbol.name for x in self.wanted.free)

    def __call__(self, values: Reals) -> Complexes:
        """Of sets of values (sets, parameters) the responses (sets, lines); NaN where there is none."""
        sets = np.atleast_2d(values)
        columns = {name: sets[:, i, None] for i, name in enumerate(self.names)}
        with np.errstate(all="ignore"):
            found = self._compiled(self.omega[None, :], **columns)
            H: Complexes = found.perceived_real + 1j * found.perceived_imag
        return np.broadcast_to(H, (len(sets), len(self.omega)))

    def at(self, values: Reals) -> Complexes:
        """Of one set of values."""
        found: Complexes = self(values)[0]
        return found

    def slopes(self, values: Reals, steps: Reals) -> Complexes:
        """Central differences, (lines, parameters)."""
        shifts = np.diag(steps)
        H = self(np.concatenate([values + shifts, values - shifts]))
        count = len(steps)
        found: Complexes = ((H[:count] - H[count:]) / (2 * steps[:, None])).T
        return found


_MOST_LINES = 200
"""Looked at for a start."""
_DRAWN, _REFINED = 64, 10
"""Sets of values for each parameter and one more, and how many of the best are refined."""
_DECADES = {
    Dimension.MASS: (-2.5, 1.0), Dimension.DAMPING: (-2.5, 1.0), Dimension.STIFFNESS: (-1.5, 1.5),
    Dimension.FREQUENCY: (-0.5, 2.5), Dimension.TIME: (-3.0, 0.3), Dimension.RATIO: (-1.0, 0.3),
}  # fmt: skip
"""Of a parameter around its scale."""


def scales(free: tuple[Free, ...], m: Measurement) -> Reals:
    """How large each parameter is likely to be: the middle of the lines in its unit."""
    size, omega = float(np.median(np.abs(m.H))) or 1.0, float(np.exp(np.log(m.omega[m.omega > 0]).mean()))
    known = {
        Dimension.MASS: size / omega**2, Dimension.DAMPING: size / omega, Dimension.STIFFNESS: size,
        Dimension.FREQUENCY: omega, Dimension.TIME: 1 / omega, Dimension.RATIO: 1.0, Dimension.FORCE: size,
        Dimension.DISPLACEMENT: 1.0, Dimension.ANY: size,
    }  # fmt: skip
    return np.array([known[x.dimension] for x in free])


def starts(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    """Values to begin with."""
    few = m.at(np.unique(np.linspace(0, len(m) - 1, min(len(m), _MOST_LINES)).astype(int)))
    if wanted.degrees is not None:
        yield from _fractions(wanted, few)
    else:
        yield from _drawn(wanted, few)


# Models: sets of values drawn evenly on logarithmic scales, the best of them refined on the logarithm of the response.


def _drawn(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    free, curve, scale = wanted.free, Curve(wanted, m.omega), scales(wanted.free, m)
    count = _DRAWN * (len(free) + 1)
    points = np.random.default_rng(2019).random((count, len(free)))
    sets = np.stack([_spread(x, c, u) for x, c, u in zip(free, scale, points.T, strict=True)], axis=1)
    misfit = np.nan_to_num(np.square(_logarithm(curve(sets), m.H)).sum(axis=1), nan=np.inf)
    for i in np.argsort(misfit)[:_REFINED]:
        if np.isfinite(misfit[i]):
            yield _refined(curve, m.H, sets[i], scale)


def _spread(x: Free, scale: float, share: Reals) -> Reals:
    if x.rule is Rule.FRACTION:
        return 0.02 + 0.96 * share
    low, high = _DECADES.get(x.dimension, (-2.0, 2.0))
    if x.rule is not Rule.ANY:
        found: Reals = scale * 10 ** (low + (high - low) * share)
        return found
    return scale * np.sign(share - 0.5) * 10 ** (low + (high - low) * np.abs(2 * share - 1))


def _logarithm(H: Complexes, measured: Complexes) -> Reals:
    """Logarithm of magnitude, and phase, of the quotient."""
    with np.errstate(all="ignore"):
        quotient = np.log(H / measured)
    found: Reals = np.concatenate([quotient.real, quotient.imag], axis=-1)
    return found


def _refined(curve: Curve, measured: Complexes, begin: Reals, scale: Reals) -> Reals:
    from scipy.optimize import least_squares  # of the extra simulate

    signed = np.array([x.rule in (Rule.ANY, Rule.FRACTION) for x in curve.wanted.free])
    fraction = np.array([x.rule is Rule.FRACTION for x in curve.wanted.free])

    def values(u: Reals) -> Reals:
        return np.where(signed, u * scale, np.exp(np.clip(u, -300, 300)))

    def rest(u: Reals) -> Reals:
        return np.nan_to_num(_logarithm(curve.at(values(u)), measured), nan=1e3, posinf=1e3, neginf=-1e3)

    def slope(u: Reals) -> Reals:
        at = values(u)
        with np.errstate(all="ignore"):
            steps = 1e-5 * np.maximum(np.abs(at), 1e-3 * scale)
            relative = curve.slopes(at, steps) / curve.at(at)[:, None] * np.where(signed, scale, at)
        told: Reals = np.nan_to_num(np.concatenate([relative.real, relative.imag]), nan=0.0, posinf=1e6, neginf=-1e6)
        return told

    with np.errstate(all="ignore"):
        u = np.where(signed, begin / scale, np.log(np.abs(begin)))
    ends = np.where(fraction, 1e-3, -np.inf), np.where(fraction, 1 - 1e-3, np.inf)
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        found = least_squares(rest, u, slope, ends, max_nfev=40, x_scale=np.where(signed, 1.0, 0.5))
    refined: Reals = values(found.x)
    return refined


# Fractions: numerator and denominator by linear least squares, each time weighted with the denominator before.


def _fractions(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    assert wanted.degrees is not None
    ratio = m.H / _known(wanted, m.omega)
    is_delayed = any(x["model"] == "delay" for x in wanted.effects) and any(x.name == "tau" for x in wanted.free)
    top = float(m.omega[-1])
    for tau in [0.0, *np.geomspace(0.02, 6, 16) / top] if is_delayed else [0.0]:
        yield _linear(wanted, m.omega, ratio * np.exp(1j * m.omega * tau), tau)


def _known(wanted: Wanted, omega: Reals) -> Complexes:
    """What the fraction is multiplied by."""
    if wanted.known is None:
        return np.ones(len(omega), dtype=complex)
    found = distort(wanted.known).compile(of=["environment_real", "environment_imag"])(omega)
    H: Complexes = found.environment_real + 1j * found.environment_imag
    return H


def _linear(wanted: Wanted, omega: Reals, ratio: Complexes, tau: float) -> Reals:
    assert wanted.degrees is not None
    above, below = wanted.degrees
    middle = float(np.exp(np.log(omega[omega > 0]).mean()))
    powers = (1j * omega[:, None] / middle) ** np.arange(max(above, below) + 1)
    weight, found = 1 / np.maximum(np.abs(ratio), 1e-300), np.zeros(above + below + 1)
    for _ in range(20):
        A = np.hstack([powers[:, : above + 1], -ratio[:, None] * powers[:, 1 : below + 1]]) * weight[:, None]
        b = ratio * weight
        found = np.linalg.lstsq(np.vstack([A.real, A.imag]), np.concatenate([b.real, b.imag]), rcond=None)[0]
        bottom = np.abs(1 + powers[:, 1 : below + 1] @ found[above + 1 :])
        weight = 1 / np.maximum(np.abs(ratio) * bottom, 1e-300)
    values = dict(
        zip([*(f"a{i}" for i in range(above + 1)), *(f"d{i}" for i in range(1, below + 1))], found, strict=True)
    )
    own = {key: x / middle ** int(key[1:]) for key, x in values.items()}
    return np.array([own.get(x.name, tau) for x in wanted.free])


LEAST_AVERAGES = 4
_TOLD_APART = 1e-7
"""Of the directions in which parameters move, the least told against the best told: below it they cannot be told apart."""
_SAME = 1e-6
"""Sums of squares that differ by no more than this share are one."""


@dataclass(frozen=True, eq=False)
class Noise:
    """``sigma`` : of the real and of the imaginary part of each line, as estimated from its disc. ``freedom`` : degrees of
    freedom of that estimate, infinite where the disc is given; None where no disc is known and sigma is a share of ``|H|``."""

    sigma: Reals
    freedom: float | None

    def squares(self, residuals: Complexes) -> Reals:
        """Of each line a number that has the distribution chi^2 of 2 degrees of freedom where the model holds.

        ``|r|^2/2`` has F(2, n); n ln(1 + |r|^2/n) is its quantile, carried over.
        """
        size = np.square(np.abs(residuals))
        n = self.freedom
        found: Reals = size if n is None or np.isinf(n) else n * np.log1p(size / n)
        return found

    @property
    def widening(self) -> float:
        """Of variances: weights that are estimated themselves tell less than known ones, by n/(n - 4)."""
        n = self.freedom
        return 1.0 if n is None or np.isinf(n) else n / (n - 4)


def noise_of(m: Measurement) -> Noise:
    """The noise that the discs of a response speak of. SceneError where they cannot be weights."""
    if m.coherence is not None and m.averages is not None:
        if m.averages < LEAST_AVERAGES:
            raise SceneError(
                f"averages: {m.averages:g} are too few to weigh lines by: it takes at least {LEAST_AVERAGES}"
            )
        n = 2 * m.averages - 2
        sigma = np.abs(m.H) * np.sqrt((1 - m.coherence) / (n * m.coherence))
    elif m.radius is not None:
        n, sigma = np.inf, m.radius / np.sqrt(-2 * np.log1p(-m.confidence))
    else:
        size = np.abs(m.H)
        return Noise(np.where(size > 0, size, np.median(size) or 1.0), None)
    if (sigma <= 0).any():
        i = int(np.argmax(sigma <= 0))
        raise SceneError(
            f"the disc at {m.omega[i]:.6g} rad/s has no radius: a line without error cannot be weighed beside others; "
            "leave out coherence and radius if there is no noise"
        )
    return Noise(sigma, n)


def usable(m: Measurement) -> Measurement:
    """The lines that can be fitted: not that at frequency 0, which has no phase, and none whose disc is the whole plane."""
    kept = m.omega > 0
    if m.coherence is not None:
        kept &= m.coherence > 0
    if m.radius is not None:
        kept &= np.isfinite(m.radius)
    if not kept.any():
        raise SceneError(f"{m.name}: no line above 0 rad/s has a disc that tells anything")
    return m.at(kept)


@dataclass(frozen=True, eq=False)
class Fit:
    """What least squares found.

    ``lines`` : those that were fitted. ``model`` : the response there; ``residuals`` : measured less model, in units of sigma.
    ``covariance`` : of the values, linearised. ``starts`` : from how many; ``agreeing`` : how many ended here. ``others`` : other
    values that give the same response; None where that is not known. ``period`` : s, by how much a delay may be longer on
    evenly spaced lines; None where no start found a longer one.
    """

    wanted: Wanted
    lines: Measurement
    noise: Noise
    values: Reals
    covariance: Reals
    model: Complexes
    residuals: Complexes
    starts: int
    agreeing: int
    others: tuple[Reals, ...] | None = None
    period: float | None = None

    @property
    def freedom(self) -> int:
        """Numbers that were measured, less those that were found."""
        return 2 * len(self.lines) - len(self.values)


def fit(wanted: Wanted, m: Measurement, begins: Iterable[Reals] | None = None) -> Fit:
    """The values with which the sum of squares, weighted by the discs, is the least that was found.

    ``begins`` : sets of values to begin with, if not at many that are drawn.
    """
    lines = usable(m)
    free, noise, curve = wanted.free, noise_of(lines), Curve(wanted, lines.omega)
    if 2 * len(lines) <= len(free):
        numbers = counted(len(free), "parameter")
        raise SceneError(
            f"{counted(len(lines), 'line')} cannot tell {numbers}: at least {len(free) // 2 + 1} lines are needed"
        )
    found: list[tuple[float, Reals]] = []
    for begin in begins or starts(wanted, lines):
        tick(len(found), None, "starts")
        if (x := _least(curve, lines, noise, begin)) is not None:
            found.append(x)
    if not found:
        raise SceneError("the model has no finite response at these lines with any values that were tried")
    cost, values = min(found, key=lambda x: x[0])
    alike = [x for sum_, x in found if sum_ <= cost * (1 + _SAME) + 1e-12]
    cost, values, period = _shortest(curve, lines, noise, (cost, values), alike)
    model = curve.at(values)
    residuals = (lines.H - model) / noise.sigma
    covariance = _covariance(curve, lines, noise, values) * noise.widening
    if noise.freedom is None:
        covariance = covariance * 2 * cost / (2 * len(lines) - len(free))
    return Fit(wanted, lines, noise, values, covariance, model, residuals, len(found), len(alike), period=period)


def with_others(found: Fit) -> Fit:
    """The same, with all other values that give the same response, each fitted to the lines."""
    from haptisym.verbs.identify.wanted import twins

    if found.wanted.degrees is not None:
        return replace(found, others=())  # a fraction has its coefficients
    nearly = twins(found.wanted, found.values)
    if nearly is None:
        return found
    curve = Curve(found.wanted, found.lines.omega)
    cost = float(np.square(np.abs(found.residuals)).sum() / 2)
    fitted = filter(None, (_least(curve, found.lines, found.noise, x) for x in nearly))
    others = tuple(x for sum_, x in fitted if sum_ <= cost * (1 + _SAME) + 1e-12)
    return found if len(others) < len(nearly) and not others else replace(found, others=others)


def _shortest(
    curve: Curve, m: Measurement, noise: Noise, best: tuple[float, Reals], alike: list[Reals]
) -> tuple[float, Reals, float | None]:
    """Of values that fit alike those with the shortest delays; and by how much others are longer.

    A delay that is longer by 2 pi over the spacing of lines at multiples of it is the same to all of them.
    """
    late = [i for i, x in enumerate(curve.wanted.free) if x.dimension is Dimension.TIME and ".delay" in x.path]
    steps = np.diff(m.omega)
    if not late or len(steps) < 1 or np.ptp(steps) > 1e-6 * steps.min():
        return *best, None
    period = 2 * np.pi / float(steps.mean())
    cost, values = min([best, *((best[0], x) for x in alike)], key=lambda x: float(x[1][late].sum()))
    for i in late:
        shorter = values.copy()
        shorter[i] %= period
        found = _least(curve, m, noise, shorter) if shorter[i] < values[i] else None
        if found is not None and found[0] <= cost * (1 + _SAME) + 1e-12:
            cost, values = found
    is_longer = any(x[late].sum() > values[late].sum() + period / 2 for x in (best[1], *alike))
    return cost, values, period if is_longer else None


def _least(curve: Curve, m: Measurement, noise: Noise, begin: Reals) -> tuple[float, Reals] | None:
    """The least half sum of squares near a start, and its values."""
    from scipy.optimize import least_squares  # of the extra simulate

    free = curve.wanted.free
    size = np.maximum(np.abs(begin), scales(free, m) * 1e-3)

    def rest(u: Reals) -> Reals:
        return _stacked((curve.at(u * size) - m.H) / noise.sigma)

    def slope(u: Reals) -> Reals:
        return _stacked(_slopes(curve, u * size, size) * (size / noise.sigma[:, None]))

    low, high = _ends(free, size)
    u = np.clip(begin / size, low + 1e-9, np.where(np.isinf(high), np.inf, high - 1e-9))
    if not np.isfinite(rest(u)).all():
        return None
    ways: dict[str, Any] = {"x_scale": "jac", "max_nfev": 100, "xtol": 1e-12, "ftol": 1e-12}
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        found = least_squares(_finite(rest), u, _finite(slope), (low, high), **ways)
    at_end = np.where(
        low == 0, np.where(found.x < 1e-6, 0.0, found.x), found.x
    )  # the search comes near an end, never to it
    cost = float(np.square(_finite(rest)(at_end)).sum() / 2)
    if cost <= found.cost * (1 + _SAME):
        return cost, at_end * size
    return float(found.cost), found.x * size


def _finite(f: Callable[[Reals], Reals]) -> Callable[[Reals], Reals]:
    return lambda u: np.nan_to_num(f(u), nan=1e9, posinf=1e9, neginf=-1e9)


def _stacked(z: Complexes) -> Reals:
    return np.concatenate([z.real, z.imag])


def _slopes(curve: Curve, values: Reals, size: Reals) -> Complexes:
    return curve.slopes(values, 1e-5 * np.maximum(np.abs(values), 1e-3 * size))


def _ends(free: tuple[Free, ...], size: Reals) -> tuple[Reals, Reals]:
    """Between which numbers each parameter may lie, in its own size."""
    least = {Rule.ANY: -np.inf, Rule.POSITIVE: 1e-9, Rule.FRACTION: 1e-4}
    low = np.array([least.get(x.rule, 0.0) for x in free])
    fraction = np.array([x.rule is Rule.FRACTION for x in free])
    return np.where(fraction, low / size, low), np.where(fraction, (1 - 1e-4) / size, np.inf)


def _covariance(curve: Curve, m: Measurement, noise: Noise, values: Reals) -> Reals:
    """Of the values, by the slopes of the response; SceneError where the lines do not tell parameters apart."""
    free = curve.wanted.free
    size = np.maximum(
        np.abs(values), 1e2 * scales(free, m)
    )  # steps so small as rounding hides would tell apart what is one
    J = _stacked(_slopes(curve, values, size) / noise.sigma[:, None])
    norms = np.linalg.norm(J, axis=0)
    blind = [x.path for x, norm in zip(free, norms, strict=True) if not norm > 0]
    if blind:
        raise SceneError(f"the lines tell nothing of {' and '.join(blind)}: give a value, as in model:key=value")
    _, singular, directions = np.linalg.svd(J / norms, full_matrices=False)
    if singular[-1] < _TOLD_APART * singular[0]:
        mixed = [x.path for x, share in zip(free, directions[-1], strict=True) if abs(share) > 0.1]
        raise SceneError(
            f"the lines do not tell {' and '.join(mixed)} apart: give one of them a value, as in model:key=value"
        )
    root = directions.T / singular / norms[:, None]
    found: Reals = root @ root.T
    return found
