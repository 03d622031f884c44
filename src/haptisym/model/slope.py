"""A bound on how fast a response changes with the frequency: stated by whoever measured it, and tested by nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from haptisym.kernel.errors import SceneError, quoted
from haptisym.model.quantities import Dimension, MotionKind, Number, number

_WAYS = 'give |dH/domega| with its unit, as in "40 N*s/m" or "250 N/m/Hz", or as a share of |H|, as in "20 ms"'
_UP = 1 + 2e-15  # more than some roundings


@dataclass(frozen=True, slots=True)
class Slope:
    """``|dH/domega| <= bound`` (N s/m or N m s/rad), or, where ``relative``, ``<= bound |H|`` (s).

    ``text`` : as it was stated. ``motion`` : as its unit tells.

    >>> read_slope("250 N/m/Hz").bound, read_slope("20 ms").relative
    (39.78873577297384, True)
    """

    bound: float
    relative: bool
    text: str
    motion: MotionKind | None = None

    @property
    def unit(self) -> str:
        """Of the bound, in SI."""
        return "s" if self.relative else Dimension.DAMPING.unit(self.motion or MotionKind.TRANSLATION)

    def grown(self, size: Any, radius: Any, apart: Any) -> Any:
        """The radius of a disc around H, ``size`` = ``|H|``, that holds the truth so many rad/s beside the line.

        radius + bound apart; or radius + (size + radius) (exp(bound apart) - 1), as ``|H|`` itself may grow on the way. Rounded
        up.
        """
        way = self.bound * apart * _UP
        if not self.relative:
            return (radius + way) * _UP
        with np.errstate(over="ignore"):
            return (radius + (size + radius) * np.expm1(way)) * _UP

    def nearest(self, sizes: tuple[Any, Any], apart: Any) -> Any:
        """How far after the first of two lines, ``sizes`` = ``|H|`` + radius, both grown radii together are least."""
        if not self.relative or not self.bound:
            return np.zeros_like(apart)
        with np.errstate(divide="ignore", invalid="ignore"):
            found = apart / 2 + np.log(sizes[1] / sizes[0]) / (2 * self.bound)
        return np.clip(np.nan_to_num(found), 0, apart)


def read_slope(given: Number) -> Slope:
    """What a user states. SceneError for a bare number, of which nothing tells what it bounds."""
    if not isinstance(given, str) or not any(x.isalpha() for x in given):
        raise SceneError(f"slope: {quoted(given)} has no unit: {_WAYS}")
    for dimension in (Dimension.DAMPING, Dimension.TIME):
        try:
            read = number(given, dimension)
        except SceneError:
            continue
        if read.value < 0:
            raise SceneError(f"slope: {quoted(given)} must be >= 0")
        return Slope(float(read.value), dimension is Dimension.TIME, given, read.motion)
    raise SceneError(f"slope: {quoted(given)} bounds no slope: {_WAYS}")
