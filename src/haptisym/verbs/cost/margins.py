"""By how much a change exceeds what is not noticed, as plain floats have it."""

from __future__ import annotations

from typing import Any

import numpy as np

from haptisym.judge.criteria import Criterion
from haptisym.judge.regions import Sided
from haptisym.model.jnd import Part
from haptisym.programs.floats import floats_of


def margin(x: Criterion, omega: Any, H: Any, dH: Any) -> Any:
    """Positive where a change dH of H is noticed: a ratio less its limit, or how many times a region must be enlarged, less 1."""
    size = np.abs(H)
    if x.joint:
        return x.joint.enlarged(np.real(dH) / size, np.imag(dH) / size, lambda c: floats_of(c, omega)) - 1
    part = np.real if x.part is Part.REAL else np.imag
    ratio = np.abs(part(dH)) / size
    if not isinstance(x.region, Sided):
        return ratio - floats_of(x.threshold, omega)
    grows = np.abs(part(H + dH)) - np.abs(part(H))
    higher, lower = (floats_of(c, omega) for c in (x.region.higher, x.region.lower))
    limit = np.where(grows > 0, higher, np.where(grows < 0, lower, np.maximum(higher, lower)))
    least = 0.0 if x.region.floor is None else floats_of(x.region.floor, omega) / size
    return ratio - np.maximum(limit, least)
