"""What a scene says of the JND, ``jnd = ...``, read: a number, a formula, or a table with a region."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from sympy import Expr, Integer

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.symbols import omega
from haptisym.model.jnd import Threshold, formula, threshold_value
from haptisym.model.proportions import read_proportion
from haptisym.model.quantities import Dimension, MotionKind, number, require_number
from haptisym.model.ranges import ExactRange, ranged, read_confidence
from haptisym.model.regions import MOST_CORNERS, Corner, Region, Shape, turning

_KEYS = {
    Shape.SQUARE: ("real", "imag", "floor"),
    Shape.ELLIPSE: ("real", "imag", "tilt"),
    Shape.DIAMOND: ("real", "imag"),
    Shape.POLYGON: ("corners",),
}
_OPTIONAL = ("shape", "floor", "tilt")
_ANY = ("shape", "scale", "proportion", "confidence")


def read_threshold(given: Any) -> Threshold:
    """A threshold as a scene file gives it. SceneError names key and rule.

    A table may have a ``scale``, a range: how many times the whole region is as large.

    >>> read_threshold({"shape": "diamond", "real": 0.1, "imag": "12 %"}).row()
    {'real': '1/10', 'imag': '3/25', 'shape': 'diamond'}
    """
    if not isinstance(given, Mapping):
        return Threshold.of(given)
    if "confidence" in given:
        found = read_threshold({key: x for key, x in given.items() if key != "confidence"})
        return replace(found, confidence=read_confidence("confidence", given["confidence"]))
    if "like" in given:
        for key in given:
            if key != "like":
                raise SceneError(f'unknown key "{str(key)[:60]}": a published threshold stands alone: valid are like')
        return Threshold.like(given["like"])
    if "scale" in given:
        scale, interval = threshold_value("scale", given["scale"])
        if not interval:
            raise SceneError('scale: must be a range, "1 +- 20 %" or [0.8, 1.2]')
        found = _table({key: x for key, x in given.items() if key != "scale"})
        if found.ranges:
            raise SceneError("scale: has a range where no other number of the JND has one")
        large = found.scaled(scale)
        return replace(large, region=replace(large.region, ranges=(("scale", interval),), size=scale))
    return _table(given)


def _table(given: Mapping[str, Any]) -> Threshold:
    shape = _shape(given.get("shape", "square"))
    keys = _KEYS[shape]
    for key in given:
        if key not in (*keys, *_ANY):
            owners = [x.value for x, own in _KEYS.items() if key in own]
            hint = f"it is of a {' or '.join(owners)}; " if owners else meant(str(key), keys)
            what = "" if shape is Shape.SQUARE else f" of a {shape.value}"
            raise SceneError(
                f'unknown key "{str(key)[:60]}"{what}: {hint}valid are {", ".join(("shape", *keys, *_ANY[1:]))}'
            )
    missing = [key for key in keys if key not in given and key not in _OPTIONAL]
    if missing:
        raise SceneError("must give both real and imag" if "real" in keys else "corners is missing")
    taken = read_proportion("proportion", given["proportion"]) if "proportion" in given else None
    if shape is Shape.POLYGON:
        region = Region(shape, corners=_corners(given["corners"]))
        return Threshold(Integer(1), Integer(1), region=region, proportion=taken)
    real, imag = (_sided(key, given[key], allowed=shape is Shape.SQUARE) for key in ("real", "imag"))
    floor, motion, lowest = _floor(given["floor"]) if "floor" in given else (None, None, None)
    tilt = _number("tilt", given["tilt"]) if "tilt" in given else Integer(0)
    named = {"real.lower": real[2], "imag.lower": imag[2], "floor": lowest}
    ranges = tuple((name, x) for name, x in named.items() if x)
    region = Region(shape, tilt, (), (real[1], imag[1]), floor, motion, ranges)
    return Threshold(real[0], imag[0], region=region, proportion=taken)


def _shape(given: Any) -> Shape:
    valid = [x.value for x in Shape]
    if given not in valid:
        shown = str(given)[:60]
        raise SceneError(f'shape: unknown shape "{shown}": {meant(shown, valid)}valid are {", ".join(valid)}')
    return Shape(given)


def _sided(key: str, given: Any, *, allowed: bool) -> tuple[Any, Expr | None, ExactRange | None]:
    """A limit, and that for changes which make the part smaller where it is given apart, with its range."""
    if not isinstance(given, Mapping):
        return given, None, None
    if not allowed:
        raise SceneError(f"{key}: limits for higher and lower are of a square alone")
    if set(given) != {"higher", "lower"}:
        raise SceneError(f"{key}: must be a number, or give both higher and lower")
    threshold_value(f"{key}: higher", given["higher"])
    return given["higher"], *threshold_value(f"{key}: lower", given["lower"])


def _floor(given: Any) -> tuple[Expr, MotionKind | None, ExactRange | None]:
    """The least change that is noticed, N/m or N m/rad, and its range."""
    found = formula("floor", given)
    if found is not None and found.has(omega):
        return found, None, None
    try:
        read = ranged(given, Dimension.STIFFNESS)
        value = require_number(given, read.nominal).value
    except SceneError as error:
        raise error.within("floor") from None
    if any(sign_of_number(x) <= 0 for x in (value, *(read.interval or ()))):
        raise SceneError(f'floor: "{given}" must be > 0')
    return value, read.nominal.motion, read.interval


def _number(key: str, given: Any) -> Expr:
    """A number of any sign, or a formula."""
    found = formula(key, given)
    if found is not None:
        return found
    try:
        return number(given, Dimension.RATIO).value
    except SceneError as error:
        raise error.within(key) from None


def _corners(given: Any) -> tuple[Corner, ...]:
    """The corners, counterclockwise at the middle of the paper's band."""
    if not isinstance(given, Sequence) or isinstance(given, str) or not 3 <= len(given) <= MOST_CORNERS:
        raise SceneError(f"corners: must be a list of 3 to {MOST_CORNERS} pairs [x, y]")
    found: list[Corner] = []
    for i, pair in enumerate(given, 1):
        if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
            raise SceneError(f"corners: {i}: must be a pair [x, y]")
        found.append((_number(f"corners: {i}", pair[0]), _number(f"corners: {i}", pair[1])))
    clockwise = sign_of_number(turning(found, Integer(1))) < 0
    return tuple(reversed(found)) if clockwise else tuple(found)
