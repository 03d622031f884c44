"""A frequency response estimated from records in time, with the confidence disc of each line.

Of motion x, force f and a reference r that drives the loop, Welch's method gives mean spectra over
segments. The estimators are H1 = S_xf/S_xx, for errors in the force; H2 = S_ff/S_fx, for errors in
the motion; and the joint one S_rf/S_rx, for a loop that is closed through the hand. Discs hold the
truth with a stated confidence for Gaussian, stationary errors: of H1 from coherence and averages,
of H2 by inversion of the disc of X/F, of the joint estimate from Fieller's inequality.

``cube`` tests whether the display is linear: the force of a linear one does not follow the cube of
what the response predicts. Begin with ``estimated``.
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
"""The least coherence of a line at which the force is predicted from the motion."""
_NEW = 1e-9
"""The least share of the cube's power on a line that the motion leaves unexplained; a smaller one
is rounding."""


class Cube(NamedTuple):
    """How much of the cube is in the force: its ``share``, and in ``errors`` the share over its
    standard error, which is standard normal where the display is linear.

    ``share`` : below 0 where the display gives less than in proportion, as one that saturates.
    """

    share: float
    errors: float


def cube(w: Welch, x: Reals, f: Reals) -> Cube | None:
    """The cube's share in the force f for the motion x; None where no line is coherent, or where
    the motion explains the cube.

    u = h * x is the predicted force in units of its deviation, h by H1. On every second line the
    cross spectrum of u^3 - 3 u and f, both less what x explains on that line, tells one real share
    for all lines (conditioned spectra; Bendat, 1998).
    """
    xx, xf, ff = (_spectrum(w, *pair) for pair in ((x, x), (x, f), (f, f)))
    with np.errstate(all="ignore"):
        coherence = np.square(np.abs(xf)) / np.abs(xx * ff)
        predicted = _predicted(w, x, xf / xx, coherence)
        if not predicted.any():
            return None
        # The third Hermite polynomial: of a Gaussian u it is uncorrelated with u itself, so that
        # the linear part of the force adds nothing to it on average.
        u = predicted / predicted.std()
        c = u**3 - 3 * u
        cc, xc, cf = (_spectrum(w, *pair) for pair in ((c, c), (x, c), (c, f)))
        # Conditioned spectra: what is left of c, of f and of both when x has explained its part
        # of each on the line, S_ab - conj(S_xa) S_xb/S_xx.
        own = (cc - np.square(np.abs(xc)) / xx).real
        rest = (ff - np.square(np.abs(xf)) / xx).real
        both = (cf - np.conj(xc) * xf / xx).real
        # A window correlates neighbouring lines: every second one is taken as independent. The
        # lines at 0 and at the Nyquist frequency are real and would count as half.
        kept = (own > _NEW * cc.real) & (rest > 0) & (np.arange(len(xx)) % 2 == 0)
        kept[[0, -1]] = False
        # Least squares for one share on all lines, each weighted by the inverse of its variance:
        # ``known`` is the information, and the estimate is the weighted mean of both/own.
        known = float((own / rest)[kept].sum())
        share = float((both / rest)[kept].sum()) / known if known else 0.0
    if not known or not np.isfinite(share):
        return None
    # Of each line two real degrees of freedom for each average, less one average for x.
    return Cube(share, share * np.sqrt(2 * (w.averages - 1) * known))


def _spectrum(w: Welch, a: Reals, b: Reals) -> Any:
    """The mean of conj(A) B over segments, at all lines."""
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
    """The force that the response H makes of the motion x, N or N m, at frequencies where the two
    are coherent; 0 at all others."""
    lines, frequencies = np.fft.rfftfreq(w.length), np.fft.rfftfreq(len(x))
    is_coherent = np.nan_to_num(coherence) > _COHERENT
    # The mean is removed from each segment: the line at 0 tells nothing.
    is_coherent[0] = False
    # The record has more frequencies than a segment has lines. One between two lines is used where
    # both of them are coherent: only there is the interpolated indicator 1.
    is_used = np.interp(frequencies, lines, is_coherent.astype(float)) > 1 - 1e-9
    known = np.where(is_coherent, H, 0)
    real = np.interp(frequencies, lines, known.real)
    imag = np.interp(frequencies, lines, known.imag)
    response = np.where(is_used, real + 1j * imag, 0)
    return np.fft.irfft(response * np.fft.rfft(x), len(x))


WINDOWS = ("hann", "hamming", "blackman", "boxcar")
LEAST_SEGMENTS = 4
_SAMPLES = 16
"""The least number of samples of a segment."""


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
    out, as a window makes neighbours equal; 1 keeps all. The line at 0 and the last are left out.

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
    method = _estimator(estimator)
    x, f = _row("position", position), _row("force", force)
    r = None if reference is None else _row("reference", reference)
    if method is Estimator.JOINT and r is None:
        raise SceneError("estimator: joint needs reference, the signal that drives the loop")
    if method is not Estimator.JOINT and r is not None:
        raise SceneError(f"reference: {method.value} needs none: leave it out")
    for key, row in (("force", f), ("reference", r)):
        if row is not None and len(row) != len(x):
            raise SceneError(f"{key} has {len(row)} samples, and position {len(x)}")
    welch = _welch(method, len(x), _hertz(rate), _seconds(segment), overlap, window, every)
    omega, spectra = _spectra(welch, x, f, x if r is None else r)
    H, coherence, radius = _response(method, spectra, welch.averages, confidence)
    # A Measurement takes averages with a coherence only; the other estimators give the radius.
    averages = welch.averages if coherence is not None else None
    cubic = cube(welch, x, f) if method is Estimator.H1 else None
    settings = replace(welch, cube=cubic.errors if cubic else None)
    return Measurement(
        omega, H, coherence, averages, confidence, radius, motion, name, welch=settings
    )


def _estimator(given: str) -> Estimator:
    """The estimator of that name, in any letters."""
    for x in Estimator:
        if str(given).lower() == x.value.lower():
            return x
    valid = [x.value for x in Estimator]
    raise SceneError(
        f'estimator: "{str(given)[:60]}" is unknown: {meant(str(given), valid)}valid are '
        f"{', '.join(valid)}"
    )


def _row(key: str, given: ArrayLike) -> Reals:
    """A record, checked: finite, and not the same at all samples."""
    row: Reals = one_row(key, given, float)
    if not np.isfinite(row).all():
        raise SceneError(f"{key}: sample {int(np.argmin(np.isfinite(row))) + 1} is not finite")
    if len(row) and np.ptp(row) == 0:
        raise SceneError(
            f"{key}: all samples are {row[0]:.6g}: nothing moved, or the sensor was off"
        )
    return row


def _hertz(rate: Number) -> float:
    """The samples a second."""
    try:
        read = number(rate, Dimension.FREQUENCY).value
    except SceneError as error:
        raise error.within("rate") from None
    # A bare rate is samples a second; one with a unit was read as a frequency in rad/s, and "100
    # Hz" is 100 samples a second, not 200 pi.
    is_turns = isinstance(rate, str) and any(x.isalpha() for x in rate)
    rate_in_hertz = float(read / (2 * pi) if is_turns else read)
    if not rate_in_hertz > 0:
        raise SceneError(f"rate: {rate} must be > 0")
    return rate_in_hertz


def _seconds(segment: Number | None) -> float | None:
    """The length of a segment, s; None where it is not given."""
    if segment is None:
        return None
    try:
        seconds = float(number(segment, Dimension.TIME).value)
    except SceneError as error:
        raise error.within("segment") from None
    if not seconds > 0:
        raise SceneError(f"segment: {segment} must be > 0")
    return seconds


def _welch(
    way: Estimator,
    samples: int,
    rate: float,
    seconds: float | None,
    overlap: float,
    window: str,
    every: int,
) -> Welch:
    """The settings of Welch's method. SceneError for a window that is unknown, an overlap out of
    range, and segments that are too short or too few."""
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
    """The number of independent segments whose mean would have the same variance as the mean of
    these overlapping ones (Welch, 1967)."""
    length, power = len(window), float(np.square(window).sum())
    excess = 0.0
    for j in range(1, min(count, -(-length // shift))):
        # Two periodograms that are j shifts apart have, for a flat spectrum, the square of the
        # windows' normalised autocorrelation as their correlation.
        overlap = float((window[j * shift :] * window[: length - j * shift]).sum())
        excess += 2 * (1 - j / count) * (overlap / power) ** 2
    return count / (1 + excess)


@dataclass(frozen=True, eq=False)
class _Spectra:
    """Spectra of motion x, force f and reference r, averaged over segments: ``xf`` is the mean of
    conj(X) F."""

    xx: Reals
    ff: Reals
    rr: Reals
    xf: Complexes
    rx: Complexes
    rf: Complexes


def _spectra(w: Welch, x: Reals, f: Reals, r: Reals) -> tuple[Reals, _Spectra]:
    """The frequencies of the lines that are kept, rad/s, and the spectra there."""
    from scipy.signal import csd

    def mean(a: Reals, b: Reals) -> tuple[Reals, Any]:
        """All lines, Hz, and the mean of conj(A) B over segments."""
        overlap = w.length - w.shift
        lines: tuple[Reals, Any] = csd(
            a, b, fs=w.rate, window=w.window, nperseg=w.length, noverlap=overlap, detrend="constant"
        )
        return lines

    hertz, xf = mean(x, f)
    rows = (
        mean(x, x)[1].real,
        mean(f, f)[1].real,
        mean(r, r)[1].real,
        xf,
        mean(r, x)[1],
        mean(r, f)[1],
    )
    # Neither the line at 0, from which the mean was removed, nor the last one, which is real.
    kept = slice(w.every, len(hertz) - 1, w.every)
    if not len(hertz[kept]):
        raise SceneError(
            "segment: no frequency point is left: make segment longer, or every smaller"
        )
    return 2 * np.pi * hertz[kept], _Spectra(*(row[kept] for row in rows))


def _response(
    way: Estimator, s: _Spectra, averages: float, confidence: float
) -> tuple[Complexes, Reals | None, Reals | None]:
    """The response, and what tells the size of its discs: the coherence, or the radius in the unit
    of the response; the other one is None."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if way is Estimator.JOINT:
            return _known(s.rf / s.rx), None, _fieller(s, averages, confidence)
        coherence = np.clip(np.square(np.abs(s.xf)) / (s.xx * s.ff), 0, 1)
        if way is Estimator.H1:
            return _known(s.xf / s.xx), coherence, None
        H = _known(s.ff / np.conj(s.xf))
        # 1/H2 is the estimate H1 of X/F, force and motion changed about, with a disc of relative
        # radius rho. Its inverse lies within rho/(1 - rho) |H| of H, and where rho >= 1 the disc
        # holds 0, so that F/X is unbounded.
        share = np.sqrt(spread_of(averages, confidence) * (1 - coherence) / coherence)
        return H, None, np.where(share < 1, np.abs(H) * share / (1 - share), np.inf)


def _known(given: Any) -> Complexes:
    """Return a response; SceneError where a quotient of spectra was not finite."""
    H: Complexes = np.asarray(given, dtype=complex)
    if not np.isfinite(H).all():
        raise SceneError(
            "the motion, or its part driven by the reference, is 0 at some frequency: excite "
            "all frequencies of the band"
        )
    return H


def _fieller(s: _Spectra, averages: float, confidence: float) -> Reals:
    """The radius of a disc around S_rf/S_rx that holds all H for which f - H x shows no coherence
    with r beyond chance.

    |S_rf - H S_rx|^2 <= c S_rr S_vv(H), v = f - H x, is a disc where |S_rx|^2 > c S_rr S_xx, and
    unbounded elsewhere; the radius is then infinite.
    """
    # The coherence g2 of v and r is beyond chance where g2/(1 - g2) > q, so where g2 > c.
    q = spread_of(averages, confidence)
    c = q / (1 + q)
    # S_vv = S_ff - 2 Re(conj(H) S_xf) + |H|^2 S_xx makes of the inequality a |H|^2
    # - 2 Re(conj(H) b) + d <= 0: a disc of centre b/a and squared radius |b/a|^2 - d/a for a > 0.
    power = c * s.rr
    a = np.square(np.abs(s.rx)) - power * s.xx
    b = np.conj(s.rx) * s.rf - power * s.xf
    d = np.square(np.abs(s.rf)) - power * s.ff
    centre = b / a
    squared_radius = np.square(np.abs(centre)) - d / a
    # The estimate fulfils the inequality (its left side is 0), so a negative square is rounding.
    # The disc around the estimate must reach over the whole disc around the centre.
    off_centre = np.abs(centre - s.rf / s.rx)
    radius = off_centre + np.sqrt(np.maximum(squared_radius, 0))
    return np.where(a > 0, radius, np.inf)
