"""What criteria judge, in floats: a ratio against its threshold, or against a region how many times it must be enlarged."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from haptisym.figures.style import threshold_symbol, written
from haptisym.judge.crossings import Criterion
from haptisym.judge.regions import Joint, Sided
from haptisym.kernel.rings import omega
from haptisym.model.jnd import Part
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array, Values


def is_share(x: Criterion) -> bool:
    """Whether a criterion has no number for its limit, so that what it judges is drawn as a multiple of that."""
    return x.region is not None or bool(x.threshold.has(omega))


def limit_of(x: Criterion) -> float:
    """The level that what is drawn must not exceed."""
    return 1.0 if is_share(x) else float(x.threshold)


def name_of(x: Criterion) -> str:
    """What is drawn of a criterion, for a legend or an axis."""
    if x.joint:
        return f"$\\Delta H$ in the {x.joint.kind}"
    return f"{written(x)[:-1]}/{threshold_symbol(x)[1:]}" if is_share(x) else written(x)


def columns(criteria: Iterable[Criterion], values: Values, at: Array) -> Array:
    """What criteria judge, a column each, from compiled values at frequencies."""
    return np.stack([found for x in criteria if (found := judged(x, values, at)) is not None], axis=1)


def judged(x: Criterion, values: Values, at: Array) -> Array | None:
    """What a criterion judges; None where nothing of the kind can be drawn."""
    if x.joint:
        return _enlarged(x.joint, values, at)
    if x.sampled is None:
        return None
    ratio: Array = x.sampled(values)
    if isinstance(x.region, Sided):
        return _share(x.region, ratio, values, at)
    found: Array = ratio / floats_of(x.threshold, at) if is_share(x) else ratio
    return found


def _enlarged(region: Joint, values: Values, at: Array) -> Array:
    """By which factor the region must be enlarged; infinite where a ratio is."""
    across, up = np.copysign(values.ratio_real, values.real), np.copysign(values.ratio_imag, values.imag)
    with np.errstate(invalid="ignore"):
        found: Array = region.enlarged(across, up, lambda x: floats_of(x, at))
    shown: Array = np.where(np.isnan(found), np.inf, found)
    return shown


def _share(x: Sided, ratio: Array, values: Values, at: Array) -> Array:
    """A ratio as a multiple of the limit that holds there."""
    real = x.part is Part.REAL
    env = values.environment_real if real else values.environment_imag
    perc = values.perceived_real if real else values.perceived_imag
    higher, lower = (floats_of(c, at) for c in (x.higher, x.lower))
    grows = np.abs(perc) - np.abs(env)
    limit = np.where(grows > 0, higher, np.where(grows < 0, lower, np.maximum(higher, lower)))
    if x.floor is None:
        found: Array = ratio / limit
        return found
    size = np.hypot(values.environment_real, values.environment_imag)
    own = np.abs(values.real if real else values.imag)
    least: Array = np.maximum(floats_of(x.floor, at), limit * size)
    return own / least
