"""A second count of roots: how often a function winds around 0 along a half disc, sampled until each step is small."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

Function: TypeAlias = Callable[[Any], Any]
_MOST, _HALVINGS = 300_000, 40


def winding(f: Function, reach: float) -> int | None:
    """The zeros of a function of arrays of s with Re s > 0 and |s| < reach; None where it turns too often, or passes too near."""
    turned = [_turn(f, lambda t: 1j * reach * (1 - 2 * t)), _turn(f, lambda t: reach * np.exp(1j * np.pi * (t - 0.5)))]
    return None if None in turned else round(sum(x for x in turned if x is not None) / (2 * np.pi))


def _turn(f: Function, path: Function) -> float | None:
    t = np.linspace(0, 1, 2001)
    value = f(path(t))
    for _ in range(_HALVINGS):
        step = np.abs(np.diff(value)) > 0.4 * np.minimum(np.abs(value[1:]), np.abs(value[:-1]))
        if not step.any():
            return float(np.angle(value[1:] / value[:-1]).sum())
        if t.size > _MOST:
            break
        between = (t[1:] + t[:-1])[step] / 2
        place = np.nonzero(step)[0] + 1
        t, value = np.insert(t, place, between), np.insert(value, place, f(path(between)))
    return None


def late_mass(
    mass: tuple[float, float, float], hand: tuple[float, float, float], lag: float
) -> tuple[Function, float] | None:
    """(M s^2 + B s + K) exp(-s lag) + m s^2 + b s + k, and beyond which |s| it has no zero on the right; None for m <= M."""
    (M, B, K), (m, b, k) = mass, hand
    if m <= M:
        return None
    reach = 1.5 * max(4 * (B + b) / (m - M), 2 * ((K + k) / (m - M)) ** 0.5, 1 / lag)
    return lambda s: (M * s * s + B * s + K) * np.exp(-s * lag) + m * s * s + b * s + k, reach
