"""Zeros of many functions at once, each alone on a segment where its function is monotone, to a proven accuracy."""

from __future__ import annotations

import numpy as np

from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.wavevalues import WaveFunction

_MOST_ROUNDS = 60
_FINE = 2e-13
_INSIDE = 2.0**-49


def refine(f: WaveFunction, low: Array, high: Array, tolerance: float) -> tuple[Array, Array]:
    """The zero of each function between low and high, where it is monotone, and whether it is proven to that accuracy.

    Proven: f has certain and opposite signs at x (1 - tolerance) and x (1 + tolerance), or at the segment's end if that is
    nearer.
    """
    with np.errstate(all="ignore"):
        x = _approached(f, low, high)
        low, high = low * (1 + _INSIDE), high * (1 - _INSIDE)  # a segment ends where floats round to, or beside it
        below, above = np.maximum(low, x * (1 - tolerance)), np.minimum(high, x * (1 + tolerance))
        return x, _signs(f, below) * _signs(f, above) < 0


def _signs(f: WaveFunction, x: Array) -> Array:
    value, bound = f.values(x[None])[0], f.error(f.sizes(x), x, x)
    signs: Array = (value > bound).astype(np.int8) - (value < -bound).astype(np.int8)
    return signs


def _approached(f: WaveFunction, low: Array, high: Array) -> Array:
    """By inverse quadratic interpolation where that is safe, and bisection elsewhere (Chandrupatla 1997)."""
    found, open_ = (low + high) / 2, np.arange(len(low))
    a, b = low.copy(), high.copy()
    at_a, at_b = f.values(a[None])[0], f.values(b[None])[0]
    share = at_a / (at_a - at_b)
    c, at_c = a, at_a
    for _ in range(_MOST_ROUNDS):
        if not len(open_):
            break
        x = a + share * (b - a)
        at_x = f.values(x[None])[0]
        alike = (at_x > 0) == (at_a > 0)
        c, at_c = np.where(alike, a, b), np.where(alike, at_a, at_b)
        b, at_b = np.where(alike, b, a), np.where(alike, at_b, at_a)
        a, at_a = x, at_x
        best = np.where(np.abs(at_a) < np.abs(at_b), a, b)
        found[open_] = best
        least = _FINE * np.abs(best) / np.abs(b - a)
        left = (least < 0.5) & (at_a != 0) & (at_b != 0)
        share = np.clip(_next(a, b, c, at_a, at_b, at_c), least, 1 - least)
        if not left.all():
            a, b, at_a, at_b, share, open_ = (x[left] for x in (a, b, at_a, at_b, share, open_))
            f = f.of(left.nonzero()[0])
    return found


def _next(a: Array, b: Array, c: Array, at_a: Array, at_b: Array, at_c: Array) -> Array:
    """The part of the way from a to b that is tried next."""
    xi, phi = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
    safe = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
    by_inverse = at_a / (at_b - at_a) * at_c / (at_b - at_c) + (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (
        at_c - at_b
    )
    return np.where(safe & np.isfinite(by_inverse), by_inverse, 0.5)
