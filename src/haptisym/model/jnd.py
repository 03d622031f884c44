"""The just-noticeable difference: how large a change of the dynamics must be for a person to notice it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from sympy import Expr, Rational

from haptisym.kernel.errors import SceneError
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.shown import Viewed
from haptisym.model.published import like
from haptisym.model.quantities import Dimension, Number, require_number
from haptisym.model.ranges import Interval, ranged


class Part(Enum):
    """Real part (stiffness and mass) or imaginary part (damping) of a dynamics."""

    __hash__ = object.__hash__  # members are singletons; the hash by name is slow, and charts look up much

    REAL = "real"
    IMAG = "imag"


@dataclass(frozen=True, slots=True)
class Threshold(Viewed):
    """The JND c of eq. (4): a change of Re H or Im H is noticed when it exceeds that fraction of ``|H|``.

    Each a number > 0: rational, rational in pi, or algebraic as a SymPy expression (for scenes whose numbers are rational).
    Source: Fu, van Paassen and Mulder (2019), eq. (4); 10 % for the impedances of manual control.

    >>> Threshold.of(0.1)
    Threshold(real=1/10, imag=1/10)
    """

    real: Expr = Rational(1, 10)
    imag: Expr = Rational(1, 10)
    real_interval: Interval | None = field(default=None, repr=False)
    imag_interval: Interval | None = field(default=None, repr=False)
    """Where they may lie, if they are given as ranges (``"0.1 +- 20 %"`` or a pair)."""
    source: str = field(default="", repr=False)
    """The name of the published threshold that it is, if it is one."""

    @classmethod
    def of(cls, real: Number, imag: Number | None = None) -> Threshold:
        """A threshold from numbers; the imaginary part's is the real part's unless given. SceneError unless > 0."""
        return cls(real, real if imag is None else imag)

    @classmethod
    def like(cls, name: str) -> Threshold:
        """A published one, by its name, with its range where the source gives one. SceneError for a name that there is not.

        >>> Threshold.like("weight").real_interval
        (11/50, 11/25)
        """
        given: Any = like(name).given
        return cls(given, given, source=name)

    def __post_init__(self) -> None:
        for key in ("real", "imag"):
            value, interval = threshold_value(key, getattr(self, key))
            object.__setattr__(self, key, value)
            if interval:
                object.__setattr__(self, f"{key}_interval", interval)

    def __getitem__(self, part: Part) -> Expr:
        return self.real if part is Part.REAL else self.imag

    def with_limits(self, limits: Mapping[Part, Number]) -> Threshold:
        """The same with other thresholds (in place of ranges, too) for some parts."""
        given = {part: (limits[part], None) if part in limits else (self[part], self.interval(part)) for part in Part}
        (real, real_interval), (imag, imag_interval) = given.values()
        return Threshold(real, imag, real_interval, imag_interval)

    def interval(self, part: Part) -> Interval | None:
        """The range of a part's threshold, if it has one."""
        return self.real_interval if part is Part.REAL else self.imag_interval


def threshold_value(key: str, given: Number) -> tuple[Expr, Interval | None]:
    """A threshold and its range, if it has one; SceneError, with the key, unless both are > 0."""
    if isinstance(given, Expr) and is_irrational_algebraic(given) and given.evalf() > 0:
        return given, None
    try:
        found = ranged(given, Dimension.RATIO)
        value = require_number(given, found.nominal).value
    except SceneError as error:
        raise error.within(key) from None
    if any(sign_of_number(x) <= 0 for x in (value, *(found.interval or ()))):
        raise SceneError(f'{key}: "{given}" must be > 0')
    return value, found.interval


def is_irrational_algebraic(value: Expr) -> bool:
    """Whether a number is real and algebraic, but not rational."""
    return bool(value.is_number and not value.is_Rational and value.is_algebraic and value.is_real)
