"""The choice of how accurate the floats of a compiled function are, and of what computes them."""

from __future__ import annotations

from enum import Enum
from typing import TypeVar

from haptisym.kernel.errors import SceneError

Choice = TypeVar("Choice", bound=Enum)


class Accuracy(Enum):
    """What is promised of each float that a compiled function returns.

    ``FAST`` : the structured closed form in floats; a few units in the last place, more where the
    formula itself is sensitive (a light resonance). ``DOUBLE_DOUBLE`` : the same computation with
    twice the digits, rounded once at the end.
    ``CERTIFIED`` : each float proven to lie within one unit in the last place of the true value.

    >>> Accuracy.of("double-double"), Accuracy.of(Accuracy.FAST)
    (<Accuracy.DOUBLE_DOUBLE: 'double-double'>, <Accuracy.FAST: 'fast'>)
    """

    FAST = "fast"
    DOUBLE_DOUBLE = "double-double"
    CERTIFIED = "certified"

    @classmethod
    def of(cls, given: Accuracy | str) -> Accuracy:
        """The level, or the level of that name; SceneError for any other."""
        return _member(cls, "accuracy", given)


class Backend(Enum):
    """What runs the level fast: NumPy block by block, or machine code made by Numba (the extra
    ``fast``)."""

    NUMPY = "numpy"
    NUMBA = "numba"

    @classmethod
    def of(cls, given: Backend | str) -> Backend:
        """The engine, or the engine of that name; SceneError for any other."""
        return _member(cls, "engine", given)


def _member(kind: type[Choice], what: str, given: Choice | str) -> Choice:
    if isinstance(given, kind):
        return given
    known = {member.value: member for member in kind}
    if given not in known:
        raise SceneError(f"{what}: {given!r} is unknown: valid are {', '.join(known)}")
    return known[given]
