"""Motions of the hand, prescribed: sines, sums of sines, sweeps and recordings, with all their derivatives.

A motion is a displacement X_h(t), m or rad, of time in s. What is sinusoidal is derived exactly; a recording becomes a spline
of degree 5 through its samples, whose first four derivatives are continuous.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from math import comb, factorial, pi
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from .errors import SceneError
from .numeric import Array
from .quantities import Dimension, Number, quantity
from .quantities import Motion as Kind

_SMOOTH = 7  # derivatives of a fade-in that vanish at its ends
_GAP = 1.5  # of the usual spacing of samples; a longer one is a gap


class Motion(Protocol):
    """A prescribed motion of the hand. ``amplitude`` in m or rad; ``omegas`` in rad/s, empty if it is not a sum of sines."""

    @property
    def name(self) -> str: ...
    @property
    def amplitude(self) -> float: ...
    @property
    def omegas(self) -> tuple[float, ...]: ...
    @property
    def span(self) -> tuple[float, float]:
        """The lowest and the highest frequency in it, rad/s."""
        ...

    @property
    def duration(self) -> float | None:
        """How long it lasts, s; None if it goes on."""
        ...

    @property
    def smoothness(self) -> int:
        """How many of its derivatives exist."""
        ...

    @property
    def kind(self) -> Kind | None:
        """Translation or rotation, where a unit told."""
        ...

    def derivatives(self, t: Array, order: int) -> Array:
        """The motion and its derivatives up to an order, along a new first axis."""
        ...


@dataclass(frozen=True)
class Sines:
    """A sum of sines a sin(omega t + phase) that fades in smoothly over ``fade`` seconds from rest at t = 0."""

    amplitudes: tuple[float, ...]
    omegas: tuple[float, ...]
    phases: tuple[float, ...]
    fade: float
    name: str = "sine"
    kind: Kind | None = None
    duration: float | None = None
    smoothness: int = 1000

    @property
    def amplitude(self) -> float:
        return float(sum(self.amplitudes))

    @property
    def span(self) -> tuple[float, float]:
        return min(self.omegas), max(self.omegas)

    def phasor(self, omega: float) -> complex:
        """X with X_h(t) = Im(X exp(j omega t)) once the fade-in is over."""
        i = self.omegas.index(omega)
        return complex(self.amplitudes[i] * np.exp(1j * self.phases[i]))

    def derivatives(self, t: Array, order: int) -> Array:
        waves = np.zeros((order + 1, *t.shape))
        for a, omega, phase in zip(self.amplitudes, self.omegas, self.phases, strict=True):
            angle = omega * t + phase
            pair = np.sin(angle), np.cos(angle)
            for k in range(order + 1):
                waves[k] += a * omega**k * (-1) ** (k // 2) * pair[k % 2]
        return waves if bool((t >= self.fade).all()) else _product(_fade(t, self.fade, order), waves)


@dataclass(frozen=True)
class Chirp:
    """A sin(phase) whose frequency rises linearly from ``low`` to ``high`` rad/s, with the same fade-in."""

    amplitude: float
    low: float
    high: float
    length: float
    name: str = "chirp"
    kind: Kind | None = None
    omegas: tuple[float, ...] = ()
    smoothness: int = 1000

    @property
    def span(self) -> tuple[float, float]:
        return self.low, self.high

    @property
    def duration(self) -> float | None:
        return self.length

    def derivatives(self, t: Array, order: int) -> Array:
        rate = (self.high - self.low) / self.length
        speed, wave = self.low + rate * t, np.zeros((order + 1, *t.shape), dtype=complex)
        wave[0] = self.amplitude * np.exp(1j * (self.low * t + rate * t * t / 2))
        for k in range(order):  # y' = j phase' y, differentiated k times
            wave[k + 1] = 1j * (speed * wave[k] + (k * rate * wave[k - 1] if k else 0))
        return _product(_fade(t, min(2 * pi / self.low, self.length / 4), order), wave.imag)


@dataclass(frozen=True, eq=False)
class Recording:
    """A recorded motion: a spline of degree 5 through samples at ``times``, s."""

    times: Array
    values: Array
    name: str = "recording"
    kind: Kind | None = None
    omegas: tuple[float, ...] = ()
    smoothness: int = 4

    @property
    def amplitude(self) -> float:
        return float(np.abs(self.values).max())

    @property
    def span(self) -> tuple[float, float]:
        return 2 * pi / self.times[-1], pi / float(np.diff(self.times).max())

    @property
    def duration(self) -> float | None:
        return float(self.times[-1])

    def derivatives(self, t: Array, order: int) -> Array:
        from scipy.interpolate import make_interp_spline

        spline: Any = make_interp_spline(self.times, self.values, k=5)
        inside = np.clip(t, self.times[0], self.times[-1])
        # before its first sample the hand is at rest there
        return np.stack([np.where((t >= self.times[0]) | (k == 0), spline(inside, nu=k), 0.0) for k in range(order + 1)])


def sine(amplitude: Number, omega: Number) -> Sines:
    """A sine: ``amplitude`` in m or rad, ``omega`` in rad/s, bare or with a unit.

    >>> sine("5 cm", "1 Hz").amplitude
    0.05
    """
    return multisine(amplitude, [omega])


def multisine(amplitude: Number, omegas: Sequence[Number]) -> Sines:
    """Sines of equal size, together at most ``amplitude``; phases after Schroeder, so that they do not all peak at once.

    >>> multisine("1 cm", [1, 2]).amplitudes
    (0.005, 0.005)
    """
    size, kind = _amplitude(amplitude)
    listed = tuple(_frequency(omega) for omega in omegas)
    if not listed or len(set(listed)) < len(listed):
        raise SceneError("a multisine needs at least one frequency, and each only once")
    count = len(listed)
    phases = tuple(-pi * i * (i + 1) / count for i in range(count))
    name = "sine" if count == 1 else "multisine"
    return Sines((size / count,) * count, listed, phases, 2 * pi / min(listed), name, kind)


def chirp(amplitude: Number, low: Number, high: Number, duration: Number) -> Chirp:
    """A sweep from one frequency up to another, rad/s, in so many seconds."""
    size, kind = _amplitude(amplitude)
    first, last = _frequency(low), _frequency(high)
    length = positive("duration", duration, Dimension.TIME)
    if last <= first:
        raise SceneError(f"a chirp must end above where it begins: {first:g} to {last:g} rad/s")
    return Chirp(size, first, last, length, kind=kind)


def recording(path: str | Path) -> Recording:
    """A motion from a CSV file: two columns, time and displacement, with units in the header (``t [s], x [mm]``).

    Without a unit they are s and m (or rad). SceneError names the line of what is missing, not a number, or not in order,
    and gaps: spacings more than 1.5 times the usual one.
    """
    rows = _rows(Path(path))
    units = [_unit(path, header) for header in rows[0]] if not _is_number(rows[0][0]) else ["", ""]
    body = rows[1:] if not _is_number(rows[0][0]) else rows
    first = 2 if body is not rows else 1
    if len(body) < 6:
        raise SceneError(f"{path}: {len(body)} samples; a recorded motion needs at least 6")
    time = _column(path, body, 0, first) * float(_scale(path, units[0], Dimension.TIME)[0])
    factor, kind = _scale(path, units[1], Dimension.DISPLACEMENT)
    values = _column(path, body, 1, first) * factor
    _regular(path, time, first)
    return Recording(time - time[0], values, Path(path).name, kind)


def _rows(path: Path) -> list[list[str]]:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a text file (UTF-8)"
        raise SceneError(f"{path}: {reason.lower()}") from None
    rows = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines())]
    while rows and not any(rows[-1]):
        rows.pop()
    if not rows:
        raise SceneError(f"{path}: the file is empty")
    for number, row in enumerate(rows, 1):
        if len(row) != 2 or not all(row):
            raise SceneError(f"{path}: line {number}: needs a time and a displacement, separated by a comma")
    return rows


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _unit(path: str | Path, header: str) -> str:
    if "[" not in header:
        return ""
    name, _, rest = header.partition("[")
    unit, closed, _ = rest.partition("]")
    if not closed or not unit.strip():
        raise SceneError(f'{path}: line 1: "{header}": write the unit in brackets, as in "{name.strip() or "x"} [mm]"')
    return unit.strip()


def _scale(path: str | Path, unit: str, dimension: Dimension) -> tuple[float, Kind | None]:
    try:
        read = quantity(f"1 {unit}", dimension)
    except SceneError as error:
        raise error.within(f"{path}: line 1") from None
    return float(read.value), read.motion


def _column(path: str | Path, rows: list[list[str]], index: int, first: int) -> Array:
    for number, row in enumerate(rows, first):
        if not _is_number(row[index]) or not np.isfinite(float(row[index])):
            raise SceneError(f'{path}: line {number}: "{row[index][:40]}" is not a finite number')
    return np.array([float(row[index]) for row in rows])


def _regular(path: str | Path, time: Array, first: int) -> None:
    steps = np.diff(time)
    if (steps <= 0).any():
        raise SceneError(f"{path}: line {int(np.argmax(steps <= 0)) + first + 1}: time does not increase")
    usual = float(np.median(steps))
    if (steps > _GAP * usual).any():
        i = int(np.argmax(steps > _GAP * usual))
        raise SceneError(
            f"{path}: line {i + first + 1}: a gap of {steps[i]:.6g} s between samples that are {usual:.6g} s apart"
        )


def _amplitude(given: Number) -> tuple[float, Kind | None]:
    return positive("amplitude", given, Dimension.DISPLACEMENT), quantity(given, Dimension.DISPLACEMENT).motion


def _frequency(given: Number) -> float:
    return positive("frequency", given, Dimension.FREQUENCY)


def positive(key: str, given: Number, dimension: Dimension) -> float:
    """A quantity > 0 as a float in SI units; SceneError names the key."""
    try:
        value = quantity(given, dimension).value
        if value.free_symbols or not value > 0:
            raise SceneError(f'"{given}" must be a number > 0')
    except SceneError as error:
        raise error.within(key) from None
    return float(value)


def _fade(t: Array, length: float, order: int) -> Array:
    """A polynomial step from 0 to 1 on [0, length] with as many vanishing derivatives at its ends as ``_SMOOTH``, and its own."""
    n = _SMOOTH
    terms = {n + 1 + i: (-1) ** i * comb(n + i, i) * comb(2 * n + 1, n - i) for i in range(n + 1)}
    x = np.clip(t / length, 0.0, 1.0)
    rows = []
    for k in range(order + 1):
        value = sum(
            (c * factorial(p) // factorial(p - k) * x ** (p - k) for p, c in terms.items() if p >= k), np.zeros_like(x)
        )
        rows.append(np.where((x < 1) | (k == 0), value, 0.0) / length**k)
    rows[0] = np.where(x >= 1, 1.0, rows[0])
    return np.stack(rows)


def _product(one: Array, other: Array) -> Array:
    """Derivatives of a product after Leibniz."""
    orders = range(len(one))
    return np.stack([sum((comb(k, i) * one[i] * other[k - i] for i in range(k + 1)), np.zeros_like(one[0])) for k in orders])
