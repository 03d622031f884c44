"""JND regions as they are drawn at one frequency: patches around the tip of H_env, and the stretches of one part alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.patches import Patch, Polygon, Rectangle

from haptisym.judge.criteria import Criterion
from haptisym.judge.regions import Joint, Sided
from haptisym.judge.regions import Polygon as Cornered
from haptisym.programs.formulas import floats_of
from haptisym.programs.values import Array

_DIRECTIONS = 720


@dataclass(frozen=True)
class Outline:
    """A region: ``patches`` about the tip, ``stretches`` of the real and of the imaginary part, ``corners`` of its frame."""

    patches: tuple[Patch, ...]
    stretches: tuple[tuple[tuple[float, float], ...], ...]
    corners: Array


def outline(
    criteria: Sequence[Criterion], tip: Array, omega: float, style: dict[str, Any], size: float | None = None
) -> Outline:
    """The changes that are not noticed where H_env has this tip (and, if it is given, that size), at a frequency in rad/s."""
    size = float(np.hypot(*tip)) if size is None else size
    if criteria[0].joint:
        return _joint(criteria[0].joint, tip, omega, style, size)
    stretches = tuple(_stretches(x, float(own), size, omega) for x, own in zip(criteria, tip, strict=True))
    patches = tuple(
        Rectangle((x0, y0), x1 - x0, y1 - y0, **(style if not i else {**style, "label": "_nolegend_"}))
        for i, ((x0, x1), (y0, y1)) in enumerate(product(*stretches))
    )
    ends = np.array([[own[0][0] for own in stretches], [own[-1][1] for own in stretches]])
    return Outline(patches, stretches, ends)


def _stretches(x: Criterion, own: float, size: float, omega: float) -> tuple[tuple[float, float], ...]:
    """The values of one part that are not told from its own."""
    if not isinstance(x.region, Sided):
        reach = floats_of(x.threshold, omega) * size
        return ((own - reach, own + reach),)
    least = 0.0 if x.region.floor is None else floats_of(x.region.floor, omega)
    higher, lower = (max(least, floats_of(c, omega) * size) for c in (x.region.higher, x.region.lower))
    way, turn = (1.0 if own >= 0 else -1.0), 2 * abs(own)  # beyond its mirror image a part grows again
    grown, shrunk = own + way * higher, own - way * min(lower, turn)
    if higher <= turn:
        return (_sorted(shrunk, grown),)
    again = own - way * higher
    if lower >= turn:
        return (_sorted(again, grown),)
    return tuple(sorted((_sorted(shrunk, grown), _sorted(again, own - way * turn))))


def _sorted(a: float, b: float) -> tuple[float, float]:
    return min(a, b), max(a, b)


def _joint(region: Joint, tip: Array, omega: float, style: dict[str, Any], size: float) -> Outline:
    angles = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    if isinstance(region, Cornered):
        corners = np.array([[floats_of(c, omega) for c in corner] for corner in region.corners])
        angles = np.sort(np.concatenate([angles, np.arctan2(corners[:, 1], corners[:, 0]) % (2 * np.pi)]))
    across, up = np.cos(angles), np.sin(angles)
    reach = size / region.enlarged(across, up, lambda x: floats_of(x, omega))
    border = tip + np.stack([across, up], axis=1) * reach[:, None]
    quarters = [reach[np.argmin(np.abs(angles - n * np.pi / 2))] for n in range(4)]
    stretches = tuple(((float(tip[i] - quarters[i + 2]), float(tip[i] + quarters[i])),) for i in (0, 1))
    ends = np.array([border.min(axis=0), border.max(axis=0)])
    return Outline((Polygon(border, closed=True, **style),), stretches, ends)
