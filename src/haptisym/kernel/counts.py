"""Whole numbers that a caller gives: of digits, of sets, of slices."""

from __future__ import annotations

from operator import index
from typing import SupportsIndex

from haptisym.kernel.errors import SceneError


def whole(name: str, given: SupportsIndex, least: int = 1, most: int | None = None, *, of: str = "") -> int:
    """A whole number of whatever kind, in its limits; SceneError with its ``name`` and the rule. ``of`` : what it counts.

    >>> from sympy import Integer
    >>> whole("digits", 3), whole("digits", Integer(3))
    (3, 3)
    >>> whole("every", 0, 1, 100)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: every: 0 must be a whole number from 1 to 100
    """
    try:
        number = None if isinstance(given, bool) else index(given)
    except TypeError:
        number = None
    if number is None or number < least or (most is not None and number > most):
        limits = f", at least {least}" if most is None else f" from {least} to {most}"
        raise SceneError(f"{name}: {given} must be a whole number{of}{limits}")
    return number
