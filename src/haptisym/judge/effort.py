"""What the digits of crossings took."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from haptisym.kernel.decimals import bits_for
from haptisym.kernel.periodic import Turned
from haptisym.kernel.polynomials import PolynomialFactor, Root
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.zeros import Zero


class Effort(NamedTuple):
    """What the crossings' digits took: the method that encloses them, the least working precision, bits, and the time, s."""

    method: str
    bits: int
    seconds: float


_POLYNOMIAL = "certified polynomial roots"
_METHODS = {
    Root: _POLYNOMIAL,
    Turned: "arctangents of certified polynomial roots",
    Zero: "interval Newton in ball arithmetic",
    ExactNumber: "closed form",
}


def effort(numbers: Iterable[RealNumber], digits: int, seconds: float) -> Effort:
    """Of numbers that took that long to that many digits."""
    kinds = {_method(x) for x in numbers}
    return Effort(", ".join(sorted(kinds)) or "none needed", bits_for(digits), seconds)


def _method(x: RealNumber) -> str:
    if isinstance(x, Zero) and isinstance(x.factor, PolynomialFactor):
        return _POLYNOMIAL
    return _METHODS.get(type(x), "bisection")
