"""What a sweep varies: paths into a scene, and values for each, checked like the scene's own numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sympy import Integer, Symbol

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.reals import ExactNumber
from haptisym.model.catalogue import Parameter, Rule
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, quantity
from haptisym.model.scene import Scene
from haptisym.verbs.sweep.exactly import Swept

Values: TypeAlias = "Sequence[Any] | ArrayLike"
_THRESHOLDS = {
    "evaluation.jnd": tuple(Part),
    "evaluation.jnd.real": (Part.REAL,),
    "evaluation.jnd.imag": (Part.IMAG,),
}
_THRESHOLD = Parameter(Symbol("c", positive=True), Integer(1), Dimension.RATIO, key="jnd", rule=Rule.POSITIVE)


@dataclass(frozen=True)
class Axis:
    """One dimension of a sweep: a path such as ``effects.filter.omega_n``, its values (SI, rad/s) and their unit."""

    path: str
    values: NDArray[np.float64]
    unit: str
    swept: Swept


def axes(scene: Scene, vary: Mapping[str, Values]) -> tuple[Axis, ...]:
    """The dimensions of a sweep. SceneError for an unknown path, no values, or a value that the model does not allow.

    Values are floats, taken as exactly these binary numbers, or strings with units, taken as the nearest double in SI units.
    """
    if not vary:
        raise SceneError(f"a sweep needs something to vary: {_listed(scene)}")
    if "evaluation.jnd" in vary and len([x for x in vary if x in _THRESHOLDS]) > 1:
        raise SceneError("evaluation.jnd is both thresholds: vary it, or evaluation.jnd.real and evaluation.jnd.imag")
    return tuple(_axis(scene, path, values) for path, values in vary.items())


def paths(scene: Scene) -> dict[str, Parameter]:
    """Everything in a scene that can be varied, besides the thresholds ``evaluation.jnd`` (also ``.real``, ``.imag``)."""
    return {f"{place}.{p.key}": p for place, _, p in scene.placed()}


def _axis(scene: Scene, path: str, values: Values) -> Axis:
    parameter = _THRESHOLD if path in _THRESHOLDS else paths(scene).get(path)
    if path in scene.ties:
        raise SceneError(f"{path} is {scene.ties[path]}, to which it refers: vary that")
    if parameter is None:
        raise SceneError(f'the scene has nothing called "{path}" to vary: {meant(path, paths(scene))}{_listed(scene)}')
    try:
        floats = np.array([_float(parameter, x, scene) for x in _each(values)], dtype=np.float64)
        _checked(parameter, floats)
    except SceneError as error:
        raise error.within(path) from None
    unit = parameter.dimension.unit(scene.motion)
    return Axis(path, floats, unit, Swept(parameter.symbol, _THRESHOLDS.get(path, ())))


def _listed(scene: Scene) -> str:
    return f"it has {', '.join([*paths(scene), 'evaluation.jnd'])}"


def _each(values: Values) -> Sequence[Any]:
    found = [values] if isinstance(values, str) else np.asarray(values, dtype=object).ravel().tolist()
    if not found:
        raise SceneError("there are no values")
    return found


def _float(parameter: Parameter, given: Any, scene: Scene) -> float:
    if isinstance(given, str):
        read = quantity(given, parameter.dimension)
        if read.motion is not None and scene.motion is not None and read.motion is not scene.motion:
            raise SceneError(f'"{given}" is {read.motion.value}, but the scene is {scene.motion.value}')
        if read.value.free_symbols:
            raise SceneError(f'"{given}" must be a number')
        return float(ExactNumber(read.value))
    try:
        return float(given)
    except (TypeError, ValueError):
        raise SceneError(f'"{given}" is not a number, nor a string of a number and a unit') from None


def _checked(parameter: Parameter, values: NDArray[np.float64]) -> None:
    if not np.isfinite(values).all():
        raise SceneError(f'"{values[~np.isfinite(values)][0]}" must be finite')
    if len(np.unique(values)) < len(values):
        raise SceneError("each value may be given only once")
    for extreme in (values.min(), values.max()):  # every rule is one about an interval
        parameter.with_value(Decimal(repr(float(extreme))))


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
    low, high = _axis(scene, path, fields[:2]).values.tolist()
    if fields[-1] != "log":
        return path, np.linspace(low, high, count).tolist()
    if low * high <= 0:
        raise SceneError(f'{path}: "{span}": a logarithmic sweep needs ends of one sign, other than 0')
    return path, np.geomspace(low, high, count).tolist()


_MOST_VALUES = 10_000_000
