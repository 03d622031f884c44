"""What a sweep varies: paths into a scene, and values for each, checked like the scene's own numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haptisym.kernel.errors import SceneError, need
from haptisym.kernel.reals import ExactNumber
from haptisym.model.scene import Knob, Scene

AxisValues: TypeAlias = "Sequence[Any] | ArrayLike"


@dataclass(frozen=True)
class SweepAxis:
    """One dimension of a sweep: a path such as ``effects.filter.omega_n``, its values (SI, rad/s) and their unit."""

    knob: Knob
    values: NDArray[np.float64]

    @property
    def path(self) -> str:
        """Of what varies."""
        return self.knob.path

    @property
    def unit(self) -> str:
        """Empty where it is not known."""
        return self.knob.unit_in(self.knob.motion)


def axes(scene: Scene, vary: Mapping[str, AxisValues]) -> tuple[SweepAxis, ...]:
    """The dimensions of a sweep. SceneError for an unknown path, no values, or a value that the model does not allow.

    Values are floats, taken as exactly these binary numbers, or strings with units, taken as the nearest double in SI units.
    """
    need("vary", vary, Mapping, 'give values by path, as {"effects.filter.omega_n": [20, 40]}')
    if not vary:
        raise SceneError(f"a sweep needs something to vary: the scene has {', '.join(x.path for x in scene.knobs)}")
    chosen = scene.knobs.chosen(vary)
    scene.knobs.need_numbers(chosen)
    return tuple(map(_axis, chosen, vary.values()))


def _axis(knob: Knob, values: AxisValues) -> SweepAxis:
    each = [values] if isinstance(values, str) else np.asarray(values, dtype=object).ravel().tolist()
    floats = np.array([_float(knob, x) for x in each], dtype=np.float64)
    if not len(floats):
        raise SceneError(f"{knob.path}: there are no values")
    if not np.isfinite(floats).all():
        raise SceneError(f'{knob.path}: "{floats[~np.isfinite(floats)][0]}" must be finite')
    if len(np.unique(floats)) < len(floats):
        raise SceneError(f"{knob.path}: each value may be given only once")
    for extreme in (floats.min(), floats.max()):  # every rule is one about an interval
        knob.check(Decimal(repr(float(extreme))))
    return SweepAxis(knob, floats)


def _float(knob: Knob, given: Any) -> float:
    if isinstance(given, str):
        return float(ExactNumber(knob.number(given)))
    try:
        return float(given)
    except (TypeError, ValueError):
        raise SceneError(f'{knob.path}: "{given}" is not a number, nor a string of a number and a unit') from None


def spaced(text: str, scene: Scene) -> tuple[str, list[float]]:
    """A path and its values from ``PATH=LO:HI:N`` or ``PATH=LO:HI:N:log``: N values from LO to HI, evenly or by equal ratios.

    >>> from haptisym.model.scenefile import load_scene
    >>> spaced("effects.filter.omega_n=10 rad/s:20 Hz:3", load_scene("fu2019"))
    ('effects.filter.omega_n', [10.0, 67.83185307179586, 125.66370614359172])
    """
    path, _, span = text.partition("=")
    fields = [x.strip() for x in span.split(":")]
    if len(fields) not in (3, 4) or (len(fields) == 4 and fields[3] not in ("log", "lin")):
        raise SceneError(f'"{text}" is not PATH=LO:HI:N or PATH=LO:HI:N:log, as in effects.filter.omega_n=40:200:100')
    count = int(fields[2]) if fields[2].isdigit() else 0
    if not 2 <= count <= _MOST_VALUES:
        raise SceneError(f'{path}: "{fields[2]}" must be a whole number of values, from 2 to {_MOST_VALUES}')
    low, high = _axis(scene.knobs[path], fields[:2]).values.tolist()
    if fields[-1] != "log":
        return path, np.linspace(low, high, count).tolist()
    if low * high <= 0:
        raise SceneError(f'{path}: "{span}": a logarithmic sweep needs ends of one sign, other than 0')
    return path, np.geomspace(low, high, count).tolist()


_MOST_VALUES = 10_000_000
