"""The just-noticeable difference: how large a change of the dynamics must be for a person to notice it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from sympy import Expr, Rational

from .errors import SceneError
from .exact.roots import sign_of_number
from .quantities import Dimension, Number, quantity


class Part(Enum):
    """Real part (stiffness and mass) or imaginary part (damping) of a dynamics."""

    __hash__ = object.__hash__  # members are singletons; the hash by name is slow, and charts look up much

    REAL = "real"
    IMAG = "imag"


@dataclass(frozen=True, slots=True)
class Threshold:
    """The JND c of eq. (4): a change of Re H or Im H is noticed when it exceeds that fraction of ``|H|``.

    Each a number > 0: rational, rational in pi, or algebraic as a SymPy expression (for scenes whose numbers are rational).
    Source: Fu, van Paassen and Mulder (2019), eq. (4); 10 % for the impedances of manual control.

    >>> Threshold.of(0.1)
    Threshold(real=1/10, imag=1/10)
    """

    real: Expr = Rational(1, 10)
    imag: Expr = Rational(1, 10)

    @classmethod
    def of(cls, real: Number, imag: Number | None = None) -> Threshold:
        """A threshold from numbers; the imaginary part's is the real part's unless given. SceneError unless > 0."""
        return cls(real, real if imag is None else imag)

    def __post_init__(self) -> None:
        object.__setattr__(self, "real", _fraction("real", self.real))
        object.__setattr__(self, "imag", _fraction("imag", self.imag))

    def __getitem__(self, part: Part) -> Expr:
        return self.real if part is Part.REAL else self.imag


def _fraction(key: str, given: Number) -> Expr:
    if isinstance(given, Expr) and is_irrational_algebraic(given) and given.evalf() > 0:
        return given
    try:
        value = quantity(given, Dimension.RATIO).value
    except SceneError as error:
        raise error.within(key) from None
    if value.free_symbols or sign_of_number(value) <= 0:
        raise SceneError(f'{key}: "{given}" must be a number > 0')
    return value


def is_irrational_algebraic(value: Expr) -> bool:
    """Whether a number is real and algebraic, but not rational."""
    return bool(value.is_number and not value.is_Rational and value.is_algebraic and value.is_real)
