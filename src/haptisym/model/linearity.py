"""Are records of motion and force those of a linear display? Its force does not follow the cube of what the response predicts."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from haptisym.model.measured import Complexes, Reals
from haptisym.model.welch import Welch

_COHERENT = 0.5
"""Coherence of lines by which the force is predicted."""
_NEW = 1e-9
"""Share of the cube's power on a line that the motion does not explain: what is less is rounding."""


class Cube(NamedTuple):
    """How much of the cube is in the force, and that over its standard error: standard normal where the display is linear.

    ``share`` : below 0 where the display gives less than in proportion, as one that saturates.
    """

    share: float
    errors: float


def cube(w: Welch, x: Reals, f: Reals) -> Cube | None:
    """Of motion x and force f; None where nothing can be told.

    u = h * x is the predicted force in units of its deviation, h by H1. On every second line the cross spectrum of u^3 - 3 u and
    f, both less what x explains on that line, tells one real share for all lines (conditioned spectra; Bendat, 1998).
    """
    xx, xf, ff = (_spectrum(w, *pair) for pair in ((x, x), (x, f), (f, f)))
    with np.errstate(all="ignore"):
        predicted = _predicted(w, x, xf / xx, np.square(np.abs(xf)) / np.abs(xx * ff))
        if not predicted.any():
            return None
        u = predicted / predicted.std()
        c = u**3 - 3 * u
        cc, xc, cf = (_spectrum(w, *pair) for pair in ((c, c), (x, c), (c, f)))
        own, rest = ((z - np.square(np.abs(y)) / xx).real for z, y in ((cc, xc), (ff, xf)))
        both = (cf - np.conj(xc) * xf / xx).real
        kept = (own > _NEW * cc.real) & (rest > 0) & (np.arange(len(xx)) % 2 == 0)
        kept[[0, -1]] = False
        known = float((own / rest)[kept].sum())
        share = float((both / rest)[kept].sum()) / known if known else 0.0
    return Cube(share, share * np.sqrt(2 * (w.averages - 1) * known)) if known and np.isfinite(share) else None


def _spectrum(w: Welch, a: Reals, b: Reals) -> Any:
    from scipy.signal import csd

    return csd(a, b, fs=w.rate, window=w.window, nperseg=w.length, noverlap=w.length - w.shift, detrend="constant")[1]


def _predicted(w: Welch, x: Reals, H: Complexes, coherence: Reals) -> Reals:
    """The force that the response makes of the motion, on lines where the two are coherent."""
    lines, own = np.fft.rfftfreq(w.length), np.fft.rfftfreq(len(x))
    told = np.nan_to_num(coherence) > _COHERENT
    told[0] = False
    kept = np.interp(own, lines, told.astype(float)) > 1 - 1e-9
    between = np.where(told, H, 0)
    response = np.interp(own, lines, between.real) + 1j * np.interp(own, lines, between.imag)
    return np.fft.irfft(np.where(kept, response, 0) * np.fft.rfft(x), len(x))
