"""Motions of the hand: sines and sweeps with all their derivatives, and recordings, read with care,
as splines.

A motion is a displacement X_h(t), m or rad, of time in s; before t = 0 the hand is at rest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from math import comb, factorial, pi
from pathlib import Path
from typing import TypeAlias

import numpy as np

from haptisym.kernel.errors import SceneError, need, several, within
from haptisym.model.quantities import Dimension, Number, number, quantity
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.responsefile import read_motion
from haptisym.programs.values import Array

_SMOOTH = 7  # derivatives of a fade-in that vanish at its ends


@dataclass(frozen=True)
class Sines:
    """A sum of sines a sin(omega t + phase) that fades in smoothly over ``fade`` seconds from rest
    at t = 0."""

    amplitudes: tuple[float, ...]
    omegas: tuple[float, ...]
    phases: tuple[float, ...]
    fade: float
    name: str = "sine"
    kind: Kind | None = None
    duration: float | None = None
    smoothness: int = 1000
    breaks: tuple[float, ...] = ()

    @property
    def amplitude(self) -> float:
        """The sum of all: a bound of the displacement, m or rad."""
        return float(sum(self.amplitudes))

    @property
    def span(self) -> tuple[float, float]:
        """Its lowest and its highest frequency, rad/s."""
        return min(self.omegas), max(self.omegas)

    def phasor(self, omega: float) -> complex:
        """X with X_h(t) = Im(X exp(j omega t)) once the fade-in is over."""
        i = self.omegas.index(omega)
        return complex(self.amplitudes[i] * np.exp(1j * self.phases[i]))

    def derivatives(self, t: Array, order: int) -> Array:
        """Faded in over the first periods, so that it starts at rest."""
        omega, weights = _lines(self.omegas, self.amplitudes, order)
        both = (np.exp(1j * (np.multiply.outer(t, omega) + np.array(self.phases))) @ weights).imag
        waves = both.transpose(-1, *range(both.ndim - 1))
        return (
            waves if bool((t >= self.fade).all()) else _product(_fade(t, self.fade, order), waves)
        )


@lru_cache(maxsize=16)
def _lines(
    omegas: tuple[float, ...], amplitudes: tuple[float, ...], order: int
) -> tuple[Array, Array]:
    """The frequencies of a sum of sines, and the weights of each in the derivatives up to an
    order."""
    omega = np.array(omegas)
    return omega, np.array(amplitudes)[:, None] * np.power.outer(1j * omega, np.arange(order + 1))


@dataclass(frozen=True)
class Chirp:
    """A sin(phase) whose frequency rises linearly from ``low`` to ``high`` rad/s, with the same
    fade-in."""

    amplitude: float
    low: float
    high: float
    length: float
    name: str = "chirp"
    kind: Kind | None = None
    omegas: tuple[float, ...] = ()
    smoothness: int = 1000
    breaks: tuple[float, ...] = ()

    @property
    def span(self) -> tuple[float, float]:
        """Where it starts and where it ends, rad/s."""
        return self.low, self.high

    @property
    def duration(self) -> float | None:
        """Its length, s."""
        return self.length

    def derivatives(self, t: Array, order: int) -> Array:
        """Faded in, so that it starts at rest."""
        rate = (self.high - self.low) / self.length
        speed, wave = self.low + rate * t, np.zeros((order + 1, *t.shape), dtype=complex)
        wave[0] = self.amplitude * np.exp(1j * (self.low * t + rate * t * t / 2))
        for k in range(order):  # y' = j phase' y, differentiated k times
            wave[k + 1] = 1j * (speed * wave[k] + (k * rate * wave[k - 1] if k else 0))
        return _product(_fade(t, min(2 * pi / self.low, self.length / 4), order), wave.imag)


@dataclass(frozen=True)
class LettingGo:
    """The force with which the hand holds: constant, then fading within ``fade`` seconds. In the
    place of a displacement."""

    force: float
    fade: float
    span: tuple[float, float]
    name: str = "release"
    omegas: tuple[float, ...] = ()
    duration: float | None = None
    smoothness: int = 1000
    breaks: tuple[float, ...] = ()
    kind: Kind | None = None

    @property
    def amplitude(self) -> float:
        """The force that holds the hand displaced, N or N m."""
        return abs(self.force)

    def derivatives(self, t: Array, order: int) -> Array:
        """The force and its derivatives."""
        rows = -self.force * _fade(t, self.fade, order)
        rows[0] += self.force
        return rows


def sine(amplitude: Number, omega: Number) -> Sines:
    """A prescribed motion x(t) = A sin(omega t), faded in over its first period.

    ``amplitude`` : A > 0, m or rad, or with a unit. ``omega`` : > 0, rad/s, or with a unit.
    SceneError for other values.

    >>> sine("5 cm", "1 Hz").amplitude
    0.05
    """
    return multisine(amplitude, [omega])


def multisine(amplitude: Number, omegas: Sequence[Number]) -> Sines:
    """A prescribed motion x(t) = A/n sum sin(omega_i t + phi_i), phi_i = -pi i (i + 1)/n.

    These phases of Schroeder (1970) keep the peak low.

    ``amplitude`` : A > 0, m or rad, a bound of the sum. ``omegas`` : n frequencies > 0, rad/s or
    with a unit, each once; SceneError otherwise.

    >>> multisine("1 cm", [1, 2]).amplitudes
    (0.005, 0.005)
    """
    size, kind = _amplitude(amplitude)
    listed = tuple(
        _frequency(omega)
        for omega in several("omegas", omegas, "give several frequencies, as [1, 2]")
    )
    if not listed or len(set(listed)) < len(listed):
        raise SceneError("a multisine needs at least one frequency, each once")
    count = len(listed)
    phases = tuple(-pi * i * (i + 1) / count for i in range(count))
    name = "sine" if count == 1 else "multisine"
    return Sines((size / count,) * count, listed, phases, 2 * pi / min(listed), name, kind)


def chirp(amplitude: Number, low: Number, high: Number, duration: Number) -> Chirp:
    """A prescribed motion of constant amplitude with a frequency that increases from ``low`` to
    ``high``.

    ``amplitude`` : > 0, m or rad. ``low`` < ``high`` : rad/s. ``duration`` : > 0, s. Each bare or
    with a unit; else SceneError.

    >>> chirp("1 cm", "1 Hz", "5 Hz", "10 s").amplitude
    0.01
    """
    size, kind = _amplitude(amplitude)
    first, last = _frequency(low), _frequency(high)
    length = positive("duration", duration, Dimension.TIME)
    if last <= first:
        raise SceneError(f"a chirp must end above where it begins: {first:g} to {last:g} rad/s")
    return Chirp(size, first, last, length, kind=kind)


def _amplitude(given: Number) -> tuple[float, Kind | None]:
    return positive("amplitude", given, Dimension.DISPLACEMENT), quantity(
        given, Dimension.DISPLACEMENT
    ).motion


def _frequency(given: Number) -> float:
    return positive("frequency", given, Dimension.FREQUENCY)


def positive(key: str, given: Number, dimension: Dimension) -> float:
    """A quantity > 0 as a float in SI units; SceneError names the key."""
    with within(key):
        value = number(given, dimension).value
        if not value > 0:
            raise SceneError(f'"{given}" must be > 0')
    return float(value)


def _fade(t: Array, length: float, order: int) -> Array:
    """A polynomial step from 0 to 1 on [0, length] with as many vanishing derivatives at its ends
    as ``_SMOOTH``, and its own."""
    x = np.clip(t / length, 0.0, 1.0)
    low, mirrored = _half_fade(np.minimum(x, 1 - x), order), x > 0.5
    signs = np.array([-1.0, *((-1.0) ** (k + 1) for k in range(1, order + 1))]).reshape(
        -1, *[1] * t.ndim
    )
    rows = np.where(mirrored, signs * low, low)  # 1 - S(1 - x), where the sum below would cancel
    rows[0] += mirrored
    rows[1:] = np.where((x > 0) & (x < 1), rows[1:], 0.0)
    return np.asarray(rows / length ** np.arange(order + 1.0).reshape(signs.shape))


def _half_fade(x: Array, order: int) -> Array:
    """The polynomial and its derivatives on its first half."""
    n = _SMOOTH
    terms = {n + 1 + i: (-1) ** i * comb(n + i, i) * comb(2 * n + 1, n - i) for i in range(n + 1)}
    rows = np.zeros((order + 1, *x.shape))
    for k in range(order + 1):
        for p, c in terms.items():
            rows[k] += c * factorial(p) // factorial(p - k) * x ** (p - k) if p >= k else 0.0
    return rows


def _product(one: Array, other: Array) -> Array:
    """Derivatives of a product after Leibniz."""
    orders = range(len(one))
    return np.stack(
        [
            sum((comb(k, i) * one[i] * other[k - i] for i in range(k + 1)), np.zeros_like(one[0]))
            for k in orders
        ]
    )


_GAP = 1.5  # of the usual spacing of samples; a longer one is a gap
_RESTING = (
    10  # equal samples in a row: what a spline would swing there has faded to some thousandths
)
_STILL = 1e-12  # of the largest displacement: what a filter leaves of a rest


@dataclass(frozen=True)
class Lowpass:
    """A zero-phase low-pass: a Butterworth filter of half the ``order``, run forth and then back
    over the recording.

    |G| = 1/(1 + (tan(omega dt/2)/tan(cutoff dt/2))^order (sqrt(2) - 1)): 3 dB less at the
    ``cutoff``, rad/s, and no delay.
    A causal filter would delay the motion, and with it all that the scene says about phase; a
    recording is whole, so that none is needed. Beyond both ends the recording is continued, turned
    about its end points.
    """

    cutoff: float
    order: int

    def __str__(self) -> str:
        return f"low-passed at {self.cutoff / (2 * pi):.4g} Hz (order {self.order}, zero phase)"

    @classmethod
    def of(cls, cutoff: Number, order: int) -> Lowpass:
        """From a frequency as a user writes it, and an order of 2, 4, 6 or 8."""
        if order not in (2, 4, 6, 8):
            raise SceneError(
                f"order of the low-pass: {order} must be 2, 4, 6 or 8 (it runs forwards and "
                f"backwards)"
            )
        return cls(positive("lowpass", cutoff, Dimension.FREQUENCY), order)

    def smoothed(self, made: Recording) -> Recording:
        """The recording at even spacing, smoothed. Raises SceneError for a cutoff that its spacing
        cannot hold."""
        from scipy.signal import butter, sosfiltfilt

        count = len(made.times)
        times = np.linspace(0.0, made.times[-1], count)
        dt = times[1]
        if self.cutoff >= pi / dt or self.cutoff * made.times[-1] < 2 * pi:
            raise SceneError(
                f"lowpass: {self.cutoff:.6g} rad/s must lie between one period in the whole "
                f"recording, "
                f"{2 * pi / made.times[-1]:.4g} rad/s, and its Nyquist frequency, "
                f"{pi / dt:.4g} rad/s"
            )
        each = np.tan(self.cutoff * dt / 2) / (2**0.5 - 1) ** (
            1 / self.order
        )  # twice this is 3 dB at the cutoff
        sections = butter(self.order // 2, 2 * np.arctan(each) / pi, output="sos")
        even = made.derivatives(times, 0)[0]
        pad = min(count - 1, int(np.ceil(3 * 2 * pi / self.cutoff / dt)))
        return replace(
            made, times=times, values=sosfiltfilt(sections, even, padlen=pad), lowpass=self
        )


@dataclass(frozen=True, eq=False)
class Recording:
    """A recorded motion: a spline of degree 5 through samples at ``times``, s; where ten or more
    are equal the hand rests.

    It then has no velocity at all, which friction would feel: each movement between two rests has a
    spline of its own, that sets out from rest and comes to rest.
    """

    times: Array
    values: Array
    name: str = "recording"
    kind: Kind | None = None
    omegas: tuple[float, ...] = ()
    lowpass: Lowpass | None = None
    """What smoothed it."""

    @cached_property
    def _rests(self) -> list[tuple[int, int]]:
        """From which sample to which the hand rests."""
        moves = np.abs(np.diff(self.values)) > _STILL * self.amplitude
        ends = [-1, *np.flatnonzero(moves), len(moves)]
        return [(int(a) + 1, int(b)) for a, b in pairwise(ends) if b - a >= _RESTING]

    @property
    def breaks(self) -> tuple[float, ...]:
        """Where a rest begins or ends, s: its third derivative jumps there."""
        return tuple(float(self.times[i]) for rest in self._rests for i in rest)

    @property
    def smoothness(self) -> int:
        """How many of its derivatives exist."""
        return 3 if self._rests else 4

    @cached_property
    def _polynomials(self) -> tuple[Array, Array]:
        """Where each begins, s, and the coefficients of its derivatives, ascending: (polynomials,
        derivatives, powers)."""
        from scipy.interpolate import PPoly, make_interp_spline

        last = len(self.times) - 1
        edges = sorted({0, last, *(i for rest in self._rests for i in rest)})
        starts, rows = [], []
        for a, b in pairwise(edges):
            t, x = self.times[a : b + 1], self.values[a : b + 1]
            if (a, b) in self._rests:
                starts.append(t[:1])
                rows.append(np.array([[x[0], 0.0, 0.0, 0.0, 0.0, 0.0]]))
                continue
            free = [(3, 0.0), (4, 0.0)]  # at an end of the recording
            still = [(1, 0.0), (2, 0.0)]
            ends = (
                (free if a == 0 else still, free if b == last else still) if self._rests else None
            )
            made = PPoly.from_spline(make_interp_spline(t, x, k=5, bc_type=ends))
            is_one = np.diff(made.x) > 0
            starts.append(made.x[:-1][is_one])
            rows.append(made.c[::-1, is_one].T)
        row = np.concatenate(rows)
        table = [row]
        for _ in range(5):
            row = np.pad(row[:, 1:] * np.arange(1, 6), ((0, 0), (0, 1)))
            table.append(row)
        return np.concatenate(starts), np.stack(table, axis=1)

    @cached_property
    def amplitude(self) -> float:
        """The largest displacement, m or rad."""
        return float(np.abs(self.values).max())

    @cached_property
    def span(self) -> tuple[float, float]:
        """From one period in the whole record to the Nyquist frequency of its longest gap,
        rad/s."""
        return 2 * pi / self.times[-1], pi / float(np.diff(self.times).max())

    @property
    def duration(self) -> float | None:
        """Until its last sample, s."""
        return float(self.times[-1])

    def derivatives(self, t: Array, order: int) -> Array:
        """Of the spline through its samples; at rest before the first."""
        inside = np.clip(t, self.times[0], self.times[-1])
        starts, table = self._polynomials
        which = np.maximum(np.searchsorted(starts, inside, side="right") - 1, 0)
        powers = np.power.outer(inside - starts[which], np.arange(6))
        found = np.moveaxis((table[which, : order + 1] @ powers[..., None])[..., 0], -1, 0).copy()
        found[1:] = np.where(
            t >= self.times[0], found[1:], 0.0
        )  # before its first sample the hand is at rest there
        return found


Motion: TypeAlias = Sines | Chirp | Recording | LettingGo
"""A prescribed motion of the hand.

``amplitude`` : the largest displacement, m or rad. ``omegas`` : the frequencies of a sum of sines,
rad/s. ``span`` : the lowest and the highest frequency. ``duration`` : s, None if it goes on.
``smoothness`` : how many derivatives exist; ``breaks`` : where a higher one jumps, s. ``kind`` : of
motion, where a unit told it. ``derivatives`` : up to an order, along a new first axis.
"""


def recording(path: str | Path, *, lowpass: Number | None = None, order: int = 4) -> Recording:
    """A prescribed motion from a table: time and displacement, with units in the header (``t [s], x
    [mm]``).

    Of two columns the first is time; of more they are known by their names. Without a unit they are
    s and m (or rad).
    ``lowpass`` : cutoff, rad/s or with a unit, of a zero-phase Butterworth filter of that ``order``
    (see ``Lowpass``); no filter if None. SceneError gives the line that is missing, not a number or
    not in order, and gaps: intervals more than 1.5 times the usual one.
    """
    need("recording", path, (str, Path), "give a CSV file")
    made = _read(path)
    if lowpass is None:
        return made
    smooth = Lowpass.of(lowpass, order)
    return replace(smooth.smoothed(made), name=f"{made.name}, {smooth}")


def _read(path: str | Path) -> Recording:
    with within(str(path)):
        given = read_motion(Path(path))
        time, values = given.rows["time"], given.rows["position"]
        if len(time) < 6:
            raise SceneError(f"{len(time)} samples; a recorded motion needs at least 6")
        for row in (time, values):
            if not np.isfinite(row).all():
                raise SceneError(
                    f"{given.place(int(np.argmin(np.isfinite(row))))}: not a finite number"
                )
        _refuse_gaps(time, given.place)
    return Recording(time - time[0], values, Path(path).name, given.motion)


def _refuse_gaps(time: Array, place: Callable[[int], str]) -> None:
    """SceneError where time does not increase, or does so by much more than usual."""
    steps = np.diff(time)
    if (steps <= 0).any():
        raise SceneError(f"{place(int(np.argmax(steps <= 0)) + 1)}: time does not increase")
    usual = float(np.median(steps))
    if (steps > _GAP * usual).any():
        i = int(np.argmax(steps > _GAP * usual))
        raise SceneError(
            f"{place(i + 1)}: a gap of {steps[i]:.6g} s between samples that are {usual:.6g} "
            f"s apart"
        )
