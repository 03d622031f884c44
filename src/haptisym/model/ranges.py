"""Quantities that are not known exactly: ``"1.8 kg +- 5 %"``, ``"1.8 kg +- 0.1 kg"``, or a list of the lowest and the highest.

A third number between them is the nominal value.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from sympy import Expr

from haptisym.kernel.errors import SceneError
from haptisym.kernel.roots import sign_of_number
from haptisym.model.quantities import Dimension, Quantity, decimal, number, quantity

ExactRange: TypeAlias = tuple[Expr, Expr]
"""The lowest and the highest value, exact, in SI."""

_PLUS_MINUS = re.compile(r"\+/?-|±")


@dataclass(frozen=True, slots=True)
class Ranged:
    """A quantity at its nominal value, and the interval in which it may lie; None if it has just that value."""

    nominal: Quantity
    interval: ExactRange | None = None


def ranged(given: Any, dimension: Dimension) -> Ranged:
    """Read a quantity or a range of it, exactly.

    ``given`` : whatever ``quantity`` reads; a string with ``+-`` (or a plus-minus sign) and a deviation, with a unit or in per
    cent of the centre; a pair of quantities, whose middle is the nominal value, or three: the lowest, the nominal, the highest.
    Raises SceneError for anything else.

    >>> ranged("1.8 kg +- 5 %", Dimension.MASS).interval, ranged(["1.7 kg", "1.9 kg"], Dimension.MASS).nominal.value
    ((171/100, 189/100), 9/5)
    >>> ranged("0 kg +- 5 %", Dimension.MASS)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: "0 kg +- 5 %": a percentage of zero is no range; give the deviation a unit
    """
    if isinstance(given, str) and _PLUS_MINUS.search(given):
        return _around(given, dimension)
    if isinstance(given, Sequence) and not isinstance(given, str):
        return _between(given, dimension)
    return Ranged(quantity(given, dimension))


def _around(text: str, dimension: Dimension) -> Ranged:
    parts = _PLUS_MINUS.split(text)
    if len(parts) != 2 or not all(part.strip() for part in parts):
        raise SceneError(f'"{text[:60]}" is not a range: write it as "1.8 kg +- 5 %" or "1.8 kg +- 0.1 kg"')
    centre = quantity(parts[0], dimension)
    deviation = _deviation(text, centre, parts[1].strip(), dimension)
    if sign_of_number(deviation) < 0:
        raise SceneError(f'"{text[:60]}": the deviation after +- must be >= 0')
    low, high = centre.value - deviation, centre.value + deviation
    return Ranged(centre, None if deviation == 0 else (low, high))


def _deviation(text: str, centre: Quantity, given: str, dimension: Dimension) -> Expr:
    if given.endswith("%"):
        if centre.value == 0:
            raise SceneError(f'"{text[:60]}": a percentage of zero is no range; give the deviation a unit')
        if _PLUS_MINUS.split(text)[0].rstrip().endswith("%"):
            raise SceneError(_two_readings(text, centre.value, decimal(given[:-1].strip()) / 100))
        return centre.value * sign_of_number(centre.value) * decimal(given[:-1].strip()) / 100
    found = quantity(given, dimension)
    if found.exponents != centre.exponents:
        raise SceneError(f'"{text[:60]}": give the value and its deviation units alike, or the deviation in per cent')
    return found.value


def _two_readings(text: str, centre: Expr, deviation: Expr) -> str:
    """What a deviation in per cent of a value in per cent may mean, each as it is written without doubt."""
    ways = [
        ", ".join(f'"{float(100 * x):g} %"' for x in (centre - off, centre, centre + off))
        for off in (deviation, centre * deviation)
    ]
    return f'"{text[:60]}" has two readings: write [{ways[0]}], or, if it is {float(100 * deviation):g} % of it, [{ways[1]}]'


def _between(given: Sequence[Any], dimension: Dimension) -> Ranged:
    shown = f"[{', '.join(map(str, given))}]"[:60]
    if len(given) not in (2, 3):
        raise SceneError(
            f"{shown} is not a range: a list here must be a pair, the lowest and the highest value, or three, the nominal between"
        )
    low, *between, high = (quantity(x, dimension) for x in given)
    if any(x.value.free_symbols for x in (low, *between, high)):
        raise SceneError(f"{shown} is not a range: its ends must be numbers")
    if any(x.exponents != low.exponents for x in (*between, high)):
        raise SceneError(f"{shown}: both ends of a range must have units of the same kind")
    if sign_of_number(high.value - low.value) < 0:
        raise SceneError(f"{shown}: the lower end of a range must not be above the upper end")
    middle = between[0] if between else Quantity((low.value + high.value) / 2, low.motion, low.exponents)
    if any(sign_of_number(x) < 0 for x in (middle.value - low.value, high.value - middle.value)):
        raise SceneError(f"{shown}: the value in the middle, the nominal one, must lie between the other two")
    return Ranged(middle, None if low.value == high.value else (low.value, high.value))


def spread(nominal: Expr, interval: ExactRange) -> str:
    """How far a range goes, in words.

    >>> from sympy import Rational
    >>> spread(Rational(9, 5), (Rational(171, 100), Rational(189, 100)))
    'by 5 %'
    """
    low, high = interval
    if nominal == 0 or sign_of_number(low) * sign_of_number(high) <= 0 or nominal - low != high - nominal:
        return f"from {float(low):.6g} to {float(high):.6g}"
    return f"by {float(50 * (high - low) / (nominal * sign_of_number(nominal))):.4g} %"


def read_confidence(key: str, given: Any) -> Expr:
    """Of the region that ranges are: a number between 0 and 1, "95 %". SceneError, with the key, for any other.

    >>> read_confidence("confidence", "95 %")
    19/20
    """
    try:
        value = number(given, Dimension.RATIO).value
    except SceneError as error:
        raise error.within(key) from None
    if not value.is_Rational or not 0 < value < 1:
        raise SceneError(f'{key}: "{given}" must lie between 0 and 1, as 0.95')
    return value
