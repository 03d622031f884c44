"""Rate and frequency of what lasts longest in a motion: a matrix pencil (Hua and Sarkar, 1990) on even samples."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from haptisym.programs.values import Array
from haptisym.verbs.simulate.propagate import Record

_WINDOWS = 6
_PER_TURN = 1.5  # radians between samples, at the most
_MOST = 480
_COUNT = 240  # samples of a window
_RANK = 1e-9  # relative: smaller singular values are rounding
_SHARE = 1e-3  # of the largest amplitude at the end of the window: less is no mode of the motion


@dataclass(frozen=True)
class Mode:
    """x = a exp(rate t) cos(omega t + phase): 1/s and rad/s; ``samples`` how many it was read from."""

    s: complex
    samples: int

    @property
    def rate(self) -> float:
        """Of growth, 1/s."""
        return self.s.real

    @property
    def omega(self) -> float:
        """At which it swings, rad/s."""
        return self.s.imag


def slowest(
    record: Record, column: int, start: float, period: float, *, waving: bool = False, turn: float = 0.0
) -> Mode | None:
    """The mode that is left at the end of a record, read from what comes after that share of it; None where nothing moves.

    ``waving`` : among those that oscillate, beside a creep that fades as a power of time. ``period`` : that of a clock, s, so
    that every sample sees the clock alike; 0 without one. ``turn`` : a frequency, rad/s, that samples must still tell.
    """
    last = record.count - 1
    end = float(record.times[last] + record.lengths[last])
    first = start * end
    if period:
        most = int(_PER_TURN / (turn * period)) if turn else _COUNT
        step = period * max(1, min(int((end - first) / (_COUNT * period)), most))
        first = max(first, end - _MOST * step)
    else:
        step = (end - first) / _COUNT
    times = np.arange(np.ceil(first / step), np.floor(end / step), dtype=np.float64) * np.float64(step)
    if len(times) < 8:
        return None
    x = record.at(times, [column])[:, 0]
    if not np.abs(x).max():
        return None
    s, weights = modes(x, step)
    if not len(s):
        return None
    last_sizes = np.abs(weights) * np.exp(s.real * step * (len(x) - 1))
    strong = last_sizes > _SHARE * last_sizes.max()
    if waving:
        strong = (np.abs(weights) > _SHARE * _SHARE * np.abs(weights).max()) & (np.abs(s.imag) > np.abs(s.real) / 10)
    if not strong.any():
        return None
    found = max(s[strong], key=lambda y: y.real)
    return Mode(complex(found.real, abs(found.imag)), len(x))


def envelope(record: Record, column: int, start: float) -> tuple[Mode, float]:
    """The rate at which the largest values rise or fall after that share of a record, and how far it varies, of many modes."""
    values = np.abs(record.values[: record.count, :, column])
    times = record.times[: record.count]
    end = float(times[-1])
    edges = np.linspace(start * end, end, _WINDOWS + 1)
    places = np.searchsorted(times, edges)
    sizes = [float(values[a : max(b, a + 1)].max()) for a, b in pairwise(places)]
    steps = np.diff(np.log(np.maximum(sizes, 1e-300))) / (edges[1] - edges[0])
    return Mode(complex(float(steps.mean()), 0), _WINDOWS), float(np.abs(steps - steps.mean()).max())


def modes(x: Array, step: float) -> tuple[Array, Array]:
    """Exponents, 1/s, and amplitudes of a sum of exponentials, sampled every ``step`` seconds.

    >>> t = 0.01 * np.arange(200)
    >>> s, _ = modes(np.exp(-0.5 * t) * np.cos(7 * t), 0.01)
    >>> sorted(round(float(y.imag), 6) for y in s), round(float(s[0].real), 6)
    ([-7.0, 7.0], -0.5)
    """
    n = len(x)
    width = n // 3
    hankel = np.lib.stride_tricks.sliding_window_view(x, width + 1)
    _, sizes, v = np.linalg.svd(hankel, full_matrices=False)
    rank = max(1, int((sizes > _RANK * sizes[0]).sum()))
    basis = v[:rank].T
    z = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0])
    z = z[np.abs(z) > 0]
    powers = np.vander(z, n, increasing=True).T
    scale = np.abs(powers).max(axis=0)
    weights = np.linalg.lstsq(powers / scale, x.astype(complex), rcond=None)[0] / scale
    return np.log(z) / step, weights
