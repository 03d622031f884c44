"""Prescribed motions of the hand: sums of sines, sweeps and recordings, each with its derivatives.

A motion is a displacement X_h(t), m or rad, of time t, s; before t = 0 the hand is at rest. A
simulation under a prescribed motion needs derivatives up to the order of the display. Sines and
sweeps have them in closed form, y' = j phase' y differentiated by Leibniz; a fade-in f(t) with
f = 0 before t = 0 starts them from rest. A recording becomes a spline of degree 5, of which three
derivatives (four without rests) are continuous.

Begin with ``sine`` and ``recording``; ``Motion`` says what every motion has.
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
from haptisym.model.tablefile import reading
from haptisym.programs.values import Array

# How many derivatives of a fade-in vanish at its ends. A higher one jumps there, so that an
# integrator that needs more of them sees a motion that is not smooth at two instants.
_SMOOTH = 7


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
        """The sum of the amplitudes: an upper bound on the displacement, m or rad."""
        return float(sum(self.amplitudes))

    @property
    def span(self) -> tuple[float, float]:
        """The lowest and the highest frequency, rad/s."""
        return min(self.omegas), max(self.omegas)

    def phasor(self, omega: float) -> complex:
        """The complex X with X_h(t) = Im(X exp(j omega t)) once the fade-in is over, m or rad."""
        i = self.omegas.index(omega)
        return complex(self.amplitudes[i] * np.exp(1j * self.phases[i]))

    def derivatives(self, t: Array, order: int) -> Array:
        """The displacement and its derivatives at times t, s; faded in, so that it starts at
        rest."""
        omega, weights = _lines(self.omegas, self.amplitudes, order)
        phases = np.multiply.outer(t, omega) + np.array(self.phases)
        # One exponential serves all derivatives: (d/dt)^k only multiplies it by (j omega)^k.
        values = (np.exp(1j * phases) @ weights).imag
        waves: Array = values.transpose(-1, *range(values.ndim - 1))
        # Behind the fade-in the factor is 1 and its derivatives are 0: for most of a simulation
        # the product by Leibniz would cost time and change nothing.
        if bool((t >= self.fade).all()):
            return waves
        return _product(_fade(t, self.fade, order), waves)


@lru_cache(maxsize=16)
def _lines(
    omegas: tuple[float, ...], amplitudes: tuple[float, ...], order: int
) -> tuple[Array, Array]:
    """The frequencies of a sum of sines, rad/s, and their weights a (j omega)^k, one row for each
    frequency and one column for each derivative k up to an order."""
    omega = np.array(omegas)
    return omega, np.array(amplitudes)[:, None] * np.power.outer(1j * omega, np.arange(order + 1))


@dataclass(frozen=True)
class Chirp:
    """A sine of constant amplitude whose frequency rises linearly from ``low`` to ``high`` rad/s
    within ``length`` seconds; faded in as a sum of sines."""

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
        """The first and the last frequency, rad/s."""
        return self.low, self.high

    @property
    def duration(self) -> float | None:
        """The length of the sweep, s."""
        return self.length

    def derivatives(self, t: Array, order: int) -> Array:
        """The displacement and its derivatives at times t, s; faded in, so that it starts at
        rest."""
        rate = (self.high - self.low) / self.length
        frequency = self.low + rate * t
        phase = self.low * t + rate * t * t / 2
        wave = np.zeros((order + 1, *t.shape), dtype=complex)
        wave[0] = self.amplitude * np.exp(1j * phase)
        # y' = j phase' y, differentiated k times: phase' is linear in t, so that of Leibniz' sum
        # only the terms with phase' and with its constant derivative are left.
        for k in range(order):
            earlier = k * rate * wave[k - 1] if k else 0
            wave[k + 1] = 1j * (frequency * wave[k] + earlier)
        # The first period, as of sines; but a quarter of the sweep at most, where it starts slowly.
        fade = min(2 * pi / self.low, self.length / 4)
        return _product(_fade(t, fade, order), wave.imag)


@dataclass(frozen=True)
class LettingGo:
    """The force of a hand that holds the display and lets go: constant before t = 0, then fading to
    0 within ``fade`` seconds. It stands in the place of a displacement."""

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
        """The force, N or N m, and its derivatives at times t, s."""
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
    # With equal amplitudes these quadratic phases spread the energy over the whole period, as in a
    # sweep: all sines in phase would add to a peak n times as high as each.
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
    """An amplitude > 0, m or rad, and the motion that its unit implies."""
    return positive("amplitude", given, Dimension.DISPLACEMENT), quantity(
        given, Dimension.DISPLACEMENT
    ).motion


def _frequency(given: Number) -> float:
    """A frequency > 0, rad/s."""
    return positive("frequency", given, Dimension.FREQUENCY)


def positive(key: str, given: Number, dimension: Dimension) -> float:
    """Return a quantity > 0 as a float in SI units; SceneError names the key."""
    with within(key):
        value = number(given, dimension).value
        if not value > 0:
            raise SceneError(f'"{given}" must be > 0')
    return float(value)


def _fade(t: Array, length: float, order: int) -> Array:
    """The polynomial step S from 0 to 1 on [0, length] whose first ``_SMOOTH`` derivatives vanish
    at both ends, and its derivatives up to an order, along a new first axis."""
    x = np.clip(t / length, 0.0, 1.0)
    is_mirrored = x > 0.5
    along_orders = (-1, *[1] * t.ndim)
    # S(x) = 1 - S(1 - x), and so its k-th derivative is (-1)^(k+1) that at 1 - x. Near x = 1 the
    # powers of x nearly cancel each other, and near 1 - x = 0 they do not.
    half = _half_fade(np.minimum(x, 1 - x), order)
    signs = np.array([(-1.0) ** (k + 1) for k in range(order + 1)]).reshape(along_orders)
    rows = np.where(is_mirrored, signs * half, half)
    rows[0] += is_mirrored
    rows[1:] = np.where((x > 0) & (x < 1), rows[1:], 0.0)
    # d/dt = (1/length) d/dx
    scales = length ** np.arange(order + 1.0).reshape(along_orders)
    return np.asarray(rows / scales)


def _half_fade(x: Array, order: int) -> Array:
    """The step and its derivatives with respect to x for 0 <= x <= 1/2.

    S(x) = sum over i of (-1)^i C(n + i, i) C(2 n + 1, n - i) x^(n + 1 + i), n = ``_SMOOTH``: the
    polynomial of least degree with S(0) = 0, S(1) = 1 and n vanishing derivatives at both ends.
    """
    n = _SMOOTH
    rows = np.zeros((order + 1, *x.shape))
    for i in range(n + 1):
        power = n + 1 + i
        coefficient = (-1) ** i * comb(n + i, i) * comb(2 * n + 1, n - i)
        for k in range(min(order, power) + 1):
            falling = coefficient * factorial(power) // factorial(power - k)
            rows[k] += falling * x ** (power - k)
    return rows


def _product(one: Array, other: Array) -> Array:
    """Derivatives of a product after Leibniz: (f g)^(k) = sum over i of C(k, i) f^(i) g^(k-i)."""
    derivatives = []
    for k in range(len(one)):
        terms = (comb(k, i) * one[i] * other[k - i] for i in range(k + 1))
        derivatives.append(sum(terms, np.zeros_like(one[0])))
    return np.stack(derivatives)


# A step of time longer than this many usual ones is a gap: a spline would invent what is in it.
_GAP = 1.5
# Equal samples in a row that are a rest: with fewer, what one spline through all samples would
# swing there has not yet faded to some thousandths.
_RESTING = 10
# A change below this share of the largest displacement is none: what a filter leaves of a rest.
_STILL = 1e-12


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
        """Return the filter for a cutoff as a user writes it and an order of 2, 4, 6 or 8;
        SceneError for any other."""
        if order not in (2, 4, 6, 8):
            raise SceneError(
                f"order of the low-pass: {order} must be 2, 4, 6 or 8 (it runs forwards and "
                f"backwards)"
            )
        return cls(positive("lowpass", cutoff, Dimension.FREQUENCY), order)

    def smoothed(self, made: Recording) -> Recording:
        """The recording, resampled evenly and smoothed. SceneError for a cutoff above the Nyquist
        frequency, or below one period in the whole recording."""
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
        # Forth and back |G|^2 = 1/(1 + (u/u_c)^order) of one pass becomes the gain itself. It is
        # 1/sqrt(2) at the cutoff where u_c = u/(sqrt(2) - 1)^(1/order), with u = tan(omega dt/2):
        # the bilinear transform maps frequencies so, and butter takes them in Nyquist frequencies.
        corner = np.tan(self.cutoff * dt / 2) / (2**0.5 - 1) ** (1 / self.order)
        sections = butter(self.order // 2, 2 * np.arctan(corner) / pi, output="sos")
        even = made.derivatives(times, 0)[0]
        # Three periods of the cutoff beyond each end, as far as the record can be turned about it.
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
    """The filter that smoothed it, if any."""

    @cached_property
    def _rests(self) -> list[tuple[int, int]]:
        """The first and the last sample of each rest, in order."""
        moves = np.abs(np.diff(self.values)) > _STILL * self.amplitude
        # Between two neighbouring moves a and b, samples a + 1 to b are equal: b - a of them.
        ends = [-1, *np.flatnonzero(moves), len(moves)]
        return [(int(a) + 1, int(b)) for a, b in pairwise(ends) if b - a >= _RESTING]

    @property
    def breaks(self) -> tuple[float, ...]:
        """The times at which a rest begins or ends, s: the third derivative jumps there."""
        return tuple(float(self.times[i]) for rest in self._rests for i in rest)

    @property
    def smoothness(self) -> int:
        """The number of derivatives that exist everywhere."""
        # A spline of degree 5 has four continuous ones; at the end of a rest, where the first two
        # are made 0, the third jumps.
        return 3 if self._rests else 4

    @cached_property
    def _polynomials(self) -> tuple[Array, Array]:
        """The times at which the polynomials begin, s, and the coefficients of their derivatives 0
        to 5, by ascending powers: an array (polynomial, derivative, power)."""
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
            # Degree 5 needs two conditions at each end. Next to a rest velocity and acceleration
            # vanish; at an end of the recording nothing is known of them, and the conditions
            # are the natural ones, third and fourth derivative 0. Without rests SciPy's own
            # conditions, not-a-knot, hold at both ends.
            free = [(3, 0.0), (4, 0.0)]
            still = [(1, 0.0), (2, 0.0)]
            conditions = None
            if self._rests:
                conditions = free if a == 0 else still, free if b == last else still
            spline = PPoly.from_spline(make_interp_spline(t, x, k=5, bc_type=conditions))
            # The knots at both ends are repeated: the polynomials between equal ones are empty.
            has_length = np.diff(spline.x) > 0
            starts.append(spline.x[:-1][has_length])
            rows.append(spline.c[::-1, has_length].T)
        row = np.concatenate(rows)
        table = [row]
        # (c_1, c_2, ...) -> (1 c_1, 2 c_2, ..., 0): each derivative from the one before
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
        """The lowest and the highest frequency of which it can tell: one period in the whole
        record, and the Nyquist frequency of its longest step, rad/s."""
        return 2 * pi / self.times[-1], pi / float(np.diff(self.times).max())

    @property
    def duration(self) -> float | None:
        """The time of the last sample, s."""
        return float(self.times[-1])

    def derivatives(self, t: Array, order: int) -> Array:
        """The displacement and its derivatives at times t, s, by the spline through the samples; at
        rest before the first."""
        inside = np.clip(t, self.times[0], self.times[-1])
        starts, table = self._polynomials
        which = np.maximum(np.searchsorted(starts, inside, side="right") - 1, 0)
        powers = np.power.outer(inside - starts[which], np.arange(6))
        values = (table[which, : order + 1] @ powers[..., None])[..., 0]
        rows = np.moveaxis(values, -1, 0).copy()
        # Before the first sample the hand rests at its displacement: only derivatives become 0.
        rows[1:] = np.where(t >= self.times[0], rows[1:], 0.0)
        return rows


Motion: TypeAlias = Sines | Chirp | Recording | LettingGo
"""A prescribed motion of the hand.

``amplitude`` : the largest displacement, m or rad. ``omegas`` : the frequencies of a sum of sines,
rad/s. ``span`` : the lowest and the highest frequency. ``duration`` : s, None if it goes on.
``smoothness`` : how many derivatives exist; ``breaks`` : the times at which a higher one jumps, s.
``kind`` : translation or rotation, None where no unit tells. ``derivatives`` : the displacement and
its derivatives up to an order at given times, along a new first axis.
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
    """The recording in a file, its time from 0 on; SceneError with the line of what is wrong."""
    with reading(Path(path)):
        given = read_motion(Path(path))
        time, values = given.rows["time"], given.rows["position"]
        # A spline of degree 5 has at least six coefficients.
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
    # The median: a mean would grow with the very gaps that are looked for.
    usual = float(np.median(steps))
    if (steps > _GAP * usual).any():
        i = int(np.argmax(steps > _GAP * usual))
        raise SceneError(
            f"{place(i + 1)}: a gap of {steps[i]:.6g} s between samples that are {usual:.6g} "
            f"s apart"
        )
