"""Motions of the hand, prescribed: sines, sums of sines and sweeps, with all their derivatives.

A motion is a displacement X_h(t), m or rad, of time in s; before t = 0 the hand is at rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb, factorial, pi
from typing import Protocol

import numpy as np

from haptisym.kernel.errors import SceneError, several
from haptisym.model.quantities import Dimension, Number, number, quantity
from haptisym.model.quantities import MotionKind as Kind
from haptisym.programs.values import Array

_SMOOTH = 7  # derivatives of a fade-in that vanish at its ends


class Motion(Protocol):
    """A prescribed motion of the hand. ``amplitude`` in m or rad; ``omegas`` in rad/s, empty if it is not a sum of sines."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def amplitude(self) -> float:
        """The largest displacement, m or rad."""

    @property
    def omegas(self) -> tuple[float, ...]:
        """The frequencies that it is made of, rad/s; none for what is no sum of sines."""

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
    def breaks(self) -> tuple[float, ...]:
        """Where a higher one jumps, s: rests begin and end there."""
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
        omega = np.array(self.omegas)
        turning = np.exp(1j * (np.multiply.outer(t, omega) + np.array(self.phases)))
        weights = np.array(self.amplitudes)[:, None] * np.power.outer(1j * omega, np.arange(order + 1))
        waves = np.moveaxis((turning @ weights).imag, -1, 0)
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
    listed = tuple(_frequency(omega) for omega in several("omegas", omegas, "give several frequencies, as [1, 2]"))
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


def _amplitude(given: Number) -> tuple[float, Kind | None]:
    return positive("amplitude", given, Dimension.DISPLACEMENT), quantity(given, Dimension.DISPLACEMENT).motion


def _frequency(given: Number) -> float:
    return positive("frequency", given, Dimension.FREQUENCY)


def positive(key: str, given: Number, dimension: Dimension) -> float:
    """A quantity > 0 as a float in SI units; SceneError names the key."""
    try:
        value = number(given, dimension).value
        if not value > 0:
            raise SceneError(f'"{given}" must be > 0')
    except SceneError as error:
        raise error.within(key) from None
    return float(value)


def _fade(t: Array, length: float, order: int) -> Array:
    """A polynomial step from 0 to 1 on [0, length] with as many vanishing derivatives at its ends as ``_SMOOTH``, and its own."""
    x = np.clip(t / length, 0.0, 1.0)
    low, mirrored = _half_fade(np.minimum(x, 1 - x), order), x > 0.5
    signs = np.array([-1.0, *((-1.0) ** (k + 1) for k in range(1, order + 1))]).reshape(-1, *[1] * t.ndim)
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
        [sum((comb(k, i) * one[i] * other[k - i] for i in range(k + 1)), np.zeros_like(one[0])) for k in orders]
    )
