"""Values to begin a fit with: of models from their units and the lines' own scales, of fractions from linear least squares."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from haptisym.model.distortion import distort
from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.parameters import Rule
from haptisym.model.quantities import Dimension
from haptisym.verbs.identify.curve import Curve
from haptisym.verbs.identify.wanted import Free, Wanted

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
