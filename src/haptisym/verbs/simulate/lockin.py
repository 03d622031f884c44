"""A lock-in: the sines of known frequencies in a signal, by least squares under a taper.

The taper fades a window in and out, so that what is not fitted (images of a clock, harmonics, the last of a transient) leaks
into the fit by orders of magnitude less than through a plain window.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.programs.values import Array
from haptisym.verbs.simulate.motions import Sines
from haptisym.verbs.simulate.propagate import Record


@dataclass(frozen=True, eq=False)
class Lock:
    """Phasors Y with y(t) = Im(Y exp(j omega t)), one for each frequency, and how much they still drift between windows."""

    values: Any
    drift: Array

    @property
    def relative_drift(self) -> float:
        """The largest drift, as a fraction of the largest phasor."""
        return float(self.drift.max() / np.abs(self.values).max())


def lock(record: Record, signal: Array, motion: Sines, window: float, windows: int, *, drift: bool = False) -> Lock:
    """The phasors of a recorded signal in the last window of its record, compared with a window a quarter earlier.

    ``window``: s. With ``windows`` = 1 the two are not compared. ``drift``: fit a parabola along instead of a
    constant; only a constant is orthogonal to harmonics and images. Raises SceneError where the record is too short.
    """
    times = record.instants
    end = float(record.times[record.count - 1] + record.lengths[record.count - 1])
    shift = window / 4 if windows > 1 else 0.0
    if end - window - shift < motion.fade * (1 - 1e-9):
        shift = 0.0
    if end - window < motion.fade * (1 - 1e-9):
        raise SceneError(
            f"duration: {end:g} s are too short to recover H_perc; at least {motion.fade + window:g} s are needed"
        )
    values = _fitted(record, times, signal, motion, (end - window, window, 3 if drift else 1))
    if not shift:
        return Lock(values, np.zeros(len(values)))
    earlier = _fitted(record, times, signal, motion, (end - window - shift, window, 3 if drift else 1))
    return Lock(values, np.abs(values - earlier))


def _fitted(record: Record, times: Array, signal: Array, motion: Sines, window: tuple[float, float, int]) -> Any:
    start, length, terms = window
    place = (times - start) / length
    inside = (place > 0) & (place < 1)
    t, x = times[inside], place[inside]
    weight = np.sin(np.pi * x) ** 4 * record.quadrature[inside]
    angle = np.multiply.outer(t, np.array(motion.omegas))
    trend = np.power.outer(2 * x - 1, np.arange(terms))
    columns = np.concatenate([np.cos(angle), np.sin(angle), trend], axis=1)
    # the columns are nearly orthogonal under the taper: normal equations lose nothing
    weighted = (columns * weight[:, None]).T
    found = np.linalg.solve(weighted @ columns, weighted @ signal[inside])
    count = len(motion.omegas)
    return found[count : 2 * count] + 1j * found[:count]
