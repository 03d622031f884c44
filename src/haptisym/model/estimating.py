"""A frequency response from records in time: SciPy's spectra, the estimators H1, H2 and joint
input-output, and their discs.

Beside it stands whether the records are those of a linear display, whose force does not follow the
cube of what the response predicts (``cube``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from sympy import pi

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.reals import whole
from haptisym.model.measured import (
    CONFIDENCE,
    Complexes,
    Estimator,
    Measurement,
    Reals,
    Welch,
    one_row,
    spread_of,
)
from haptisym.model.quantities import Dimension, MotionKind, Number, number

_COHERENT = 0.5
"""Coherence of lines by which the force is predicted."""
_NEW = 1e-9
"""Share of the cube's power on a line that the motion does not explain: what is less is
rounding."""


class Cube(NamedTuple):
    """How much of the cube is in the force, and that over its standard error: standard normal where
    the display is linear.

    ``share`` : below 0 where the display gives less than in proportion, as one that saturates.
    """

    share: float
    errors: float


def cube(w: Welch, x: Reals, f: Reals) -> Cube | None:
    """Of motion x and force f; None where nothing can be told.

    u = h * x is the predicted force in units of its deviation, h by H1. On every second line the
    cross spectrum of u^3 - 3 u and f, both less what x explains on that line, tells one real share
    for all lines (conditioned spectra; Bendat, 1998).
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
    return (
        Cube(share, share * np.sqrt(2 * (w.averages - 1) * known))
        if known and np.isfinite(share)
        else None
    )


def _spectrum(w: Welch, a: Reals, b: Reals) -> Any:
    from scipy.signal import csd

    return csd(
        a,
        b,
        fs=w.rate,
        window=w.window,
        nperseg=w.length,
        noverlap=w.length - w.shift,
        detrend="constant",
    )[1]


def _predicted(w: Welch, x: Reals, H: Complexes, coherence: Reals) -> Reals:
    """The force that the response makes of the motion, on lines where the two are coherent."""
    lines, own = np.fft.rfftfreq(w.length), np.fft.rfftfreq(len(x))
    told = np.nan_to_num(coherence) > _COHERENT
    told[0] = False
    kept = np.interp(own, lines, told.astype(float)) > 1 - 1e-9
    between = np.where(told, H, 0)
    response = np.interp(own, lines, between.real) + 1j * np.interp(own, lines, between.imag)
    return np.fft.irfft(np.where(kept, response, 0) * np.fft.rfft(x), len(x))


WINDOWS = ("hann", "hamming", "blackman", "boxcar")
LEAST_SEGMENTS = 4
_SAMPLES = 16
"""Of a segment, at least."""


def estimated(
    position: ArrayLike,
    force: ArrayLike,
    rate: Number,
    *,
    estimator: str = "H1",
    reference: ArrayLike | None = None,
    segment: Number | None = None,
    overlap: float = 0.5,
    window: str = "hann",
    every: int = 2,
    confidence: float = CONFIDENCE,
    motion: MotionKind | None = None,
    name: str = "records",
) -> Measurement:
    """The response F/X of records of motion and force, with the discs of its lines. It needs SciPy.

    ``position``, ``force`` : m and N, or rad and N m, at an even ``rate`` (samples a second, or
    with a unit).
    ``estimator`` : "H1", for errors in the force; "H2", for errors in the motion; "joint", for
    loops that are closed through the hand: it takes the ``reference`` that drove the loop, to which
    errors of both are strange. ``segment`` : its length, s or with a unit; an eighth of the record
    if not given. ``overlap`` : of segments, a share. ``every`` : with 2, one line of two is left
    out, as a window makes neighbours alike; 1 keeps all. The line at 0 and the last are left out.

    Of H1 it is asked whether the force follows the cube of what the response predicts, which that
    of a linear display does not.

    Errors are taken to be Gaussian and stationary. Of H1 the disc comes from coherence and
    averages; of the joint estimate it is the exact one of the quotient of two means (Fieller), made
    a disc around the estimate; of H2 that of X/F, turned over.

    >>> rng = np.random.default_rng(1)
    >>> x = rng.normal(size=4000)
    >>> found = estimated(x, 100 * x + rng.normal(size=4000), 100, segment=1)
    >>> bool(found.coherence.min() > 0.99), bool(abs(found.H - 100).max() < 1)
    (True, True)
    """
    way = _estimator(estimator)
    x, f = _row("position", position), _row("force", force)
    r = None if reference is None else _row("reference", reference)
    if way is Estimator.JOINT and r is None:
        raise SceneError("estimator: joint needs reference, the signal that drives the loop")
    if way is not Estimator.JOINT and r is not None:
        raise SceneError(f"reference: {way.value} needs none: leave it out")
    for key, row in (("force", f), ("reference", r)):
        if row is not None and len(row) != len(x):
            raise SceneError(f"{key} has {len(row)} samples, and position {len(x)}")
    welch = _welch(way, len(x), _hertz(rate), _seconds(segment), overlap, window, every)
    omega, spectra = _spectra(welch, x, f, x if r is None else r)
    H, coherence, radius = _response(way, spectra, welch.averages, confidence)
    averages = welch.averages if coherence is not None else None
    followed = cube(welch, x, f) if way is Estimator.H1 else None
    asked = replace(welch, cube=followed.errors if followed else None)
    return Measurement(omega, H, coherence, averages, confidence, radius, motion, name, welch=asked)


def _estimator(given: str) -> Estimator:
    for x in Estimator:
        if str(given).lower() == x.value.lower():
            return x
    valid = [x.value for x in Estimator]
    raise SceneError(
        f'estimator: "{str(given)[:60]}" is unknown: {meant(str(given), valid)}valid are '
        f"{', '.join(valid)}"
    )


def _row(key: str, given: ArrayLike) -> Reals:
    row: Reals = one_row(key, given, float)
    if not np.isfinite(row).all():
        raise SceneError(f"{key}: sample {int(np.argmin(np.isfinite(row))) + 1} is not finite")
    if len(row) and np.ptp(row) == 0:
        raise SceneError(
            f"{key}: all samples are {row[0]:.6g}: nothing moved, or the sensor was off"
        )
    return row


def _hertz(rate: Number) -> float:
    try:
        read = number(rate, Dimension.FREQUENCY).value
    except SceneError as error:
        raise error.within("rate") from None
    is_turns = isinstance(rate, str) and any(x.isalpha() for x in rate)
    found = float(read / (2 * pi) if is_turns else read)
    if not found > 0:
        raise SceneError(f"rate: {rate} must be > 0")
    return found


def _seconds(segment: Number | None) -> float | None:
    if segment is None:
        return None
    try:
        found = float(number(segment, Dimension.TIME).value)
    except SceneError as error:
        raise error.within("segment") from None
    if not found > 0:
        raise SceneError(f"segment: {segment} must be > 0")
    return found


def _welch(
    way: Estimator,
    samples: int,
    rate: float,
    seconds: float | None,
    overlap: float,
    window: str,
    every: int,
) -> Welch:
    """The settings. SceneError for what cannot be."""
    from scipy.signal import get_window

    if window not in WINDOWS:
        raise SceneError(
            f'window: "{str(window)[:60]}" is unknown: {meant(str(window), WINDOWS)}valid '
            f"are {', '.join(WINDOWS)}"
        )
    every = whole("every", every, 1, 100)
    if isinstance(overlap, bool) or not isinstance(overlap, int | float) or not 0 <= overlap <= 0.9:
        raise SceneError(f"overlap: {overlap} must lie from 0 to 0.9")
    length = samples // 8 if seconds is None else round(seconds * rate)
    shift = max(1, round(length * (1 - overlap)))
    count = 0 if length > samples else 1 + (samples - length) // shift
    if length < _SAMPLES or count < LEAST_SEGMENTS:
        made = f"{samples} samples make {count} segments of {length}"
        raise SceneError(
            f"segment: {made}: at least {LEAST_SEGMENTS} of at least {_SAMPLES} samples are needed"
        )
    averages = _independent(get_window(window, length), shift, count)
    return Welch(way, samples, rate, window, length, shift, count, averages, every)


def _independent(window: Reals, shift: int, count: int) -> float:
    """Of how many independent segments the mean has the variance (Welch, 1967)."""
    length, power = len(window), float(np.square(window).sum())
    together = 0.0
    for j in range(1, min(count, -(-length // shift))):
        alike = float((window[j * shift :] * window[: length - j * shift]).sum()) / power
        together += 2 * (1 - j / count) * alike**2
    return count / (1 + together)


@dataclass(frozen=True, eq=False)
class _Spectra:
    """Means over segments, of motion x, force f and reference r; ``xf`` : conj(X) F."""

    xx: Reals
    ff: Reals
    rr: Reals
    xf: Complexes
    rx: Complexes
    rf: Complexes


def _spectra(w: Welch, x: Reals, f: Reals, r: Reals) -> tuple[Reals, _Spectra]:
    from scipy.signal import csd

    def mean(a: Reals, b: Reals) -> tuple[Reals, Any]:
        overlap = w.length - w.shift
        found: tuple[Reals, Any] = csd(
            a, b, fs=w.rate, window=w.window, nperseg=w.length, noverlap=overlap, detrend="constant"
        )
        return found

    hertz, xf = mean(x, f)
    rows = (
        mean(x, x)[1].real,
        mean(f, f)[1].real,
        mean(r, r)[1].real,
        xf,
        mean(r, x)[1],
        mean(r, f)[1],
    )
    kept = slice(w.every, len(hertz) - 1, w.every)
    if not len(hertz[kept]):
        raise SceneError(
            "segment: no frequency point is left: make segment longer, or every smaller"
        )
    return 2 * np.pi * hertz[kept], _Spectra(*(row[kept] for row in rows))


def _response(
    way: Estimator, s: _Spectra, averages: float, confidence: float
) -> tuple[Complexes, Reals | None, Reals | None]:
    """Response, coherence, radius: one of the last two."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if way is Estimator.JOINT:
            return _known(s.rf / s.rx), None, _fieller(s, averages, confidence)
        coherence = np.clip(np.square(np.abs(s.xf)) / (s.xx * s.ff), 0, 1)
        if way is Estimator.H1:
            return _known(s.xf / s.xx), coherence, None
        H = _known(s.ff / np.conj(s.xf))
        share = np.sqrt(spread_of(averages, confidence) * (1 - coherence) / coherence)
        return H, None, np.where(share < 1, np.abs(H) * share / (1 - share), np.inf)


def _known(given: Any) -> Complexes:
    H: Complexes = np.asarray(given, dtype=complex)
    if not np.isfinite(H).all():
        raise SceneError(
            "the motion, or its part driven by the reference, is 0 at some frequency: excite "
            "all frequencies of the band"
        )
    return H


def _fieller(s: _Spectra, averages: float, confidence: float) -> Reals:
    """Around S_rf/S_rx a disc that holds all H for which f - H x shows no coherence with r beyond
    chance.

    |S_rf - H S_rx|^2 <= c S_rr S_vv(H), v = f - H x, is a disc where |S_rx|^2 > c S_rr S_xx, and
    unbounded elsewhere.
    """
    q = spread_of(averages, confidence)
    c = q / (1 + q)
    below = np.square(np.abs(s.rx)) - c * s.rr * s.xx
    centre = (np.conj(s.rx) * s.rf - c * s.rr * s.xf) / below
    square = np.square(np.abs(centre)) - (np.square(np.abs(s.rf)) - c * s.rr * s.ff) / below
    found = np.abs(centre - s.rf / s.rx) + np.sqrt(np.maximum(square, 0))
    return np.where(below > 0, found, np.inf)
