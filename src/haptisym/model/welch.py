"""How a response was estimated from records in time: the estimator, and the settings of Welch's method."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import erfc, sqrt
from typing import Any


class Estimator(Enum):
    """What a response is estimated by.

    H1: the cross spectrum of motion and force over that of motion; H2: the spectrum of force over the cross spectrum of force and
    motion; joint: the cross spectrum of a reference with force over that with motion.
    """

    H1 = "H1"
    H2 = "H2"
    JOINT = "joint"


@dataclass(frozen=True)
class Welch:
    """How spectra were estimated.

    ``rate`` : samples a second. ``length``, ``shift`` : samples of a segment, and from one to the next. ``averages`` : of how
    many independent segments the mean has the variance. ``every`` : which lines are kept. ``cube`` : by how many standard errors
    the force follows the cube of what the response predicts, below 0 where it stays behind; None where that is not asked.
    """

    estimator: Estimator
    samples: int
    rate: float
    window: str
    length: int
    shift: int
    segments: int
    averages: float
    every: int
    cube: float | None = None

    @property
    def cube_chance(self) -> float | None:
        """Of so many standard errors or more, either way, where the display is linear."""
        return None if self.cube is None else erfc(abs(self.cube) / sqrt(2))

    @property
    def words(self) -> str:
        """All settings in a sentence."""
        kept = "every line" if self.every == 1 else f"one line of {self.every}"
        overlap = f"{100 * (1 - self.shift / self.length):.3g} %"
        return (
            f"{self.estimator.value} by Welch's method: {self.samples} samples at {self.rate:.6g} Hz, {self.segments} "
            f"segments of {self.length} samples ({self.length / self.rate:.4g} s), window {self.window}, overlap "
            f"{overlap}, mean taken off; as good as {self.averages:.4g} independent averages; {kept}"
        )

    def row(self) -> dict[str, Any]:
        """As documents have it."""
        return {
            "estimator": self.estimator.value, "samples": self.samples, "rate_hz": self.rate, "window": self.window,
            "segment": self.length, "shift": self.shift, "segments": self.segments, "averages": self.averages,
            "every": self.every, "cube": self.cube,
            "cube_probability": self.cube_chance,
        }  # fmt: skip
