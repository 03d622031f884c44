"""Floats that are proven, point by point: double-doubles with a bound of their error, and balls for what that leaves open."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq
from sympy import Rational

from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import Ball, RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.programs.balls import BallPoint, nearest_double
from haptisym.programs.doubled import Doubled, Doubles
from haptisym.programs.floats import nearest
from haptisym.programs.pointvalues import PointValue
from haptisym.programs.program import Program

FormsAt: TypeAlias = Callable[[Mapping[str, Rational]], Mapping[str, RealFunction]]
"""The closed forms in lowest terms for exact numbers of the parameters; of the ratios their squares."""
SQUARED = ("ratio_real", "ratio_imag")
"""The fields whose closed form is given by its square."""
_BITS = (128, 512, 2048)


@dataclass(frozen=True, eq=False)
class Certified:
    """The results of a program to within one unit in the last place, each of them proven."""

    program: Program
    forms: FormsAt

    def run(self, inputs: Sequence[Any], size: int) -> tuple[dict[str, Any], int]:
        """The doubles by name, and how many points needed balls; inputs are floats or arrays of that size."""
        found = self.doubles.run(inputs, size)
        values = {name: self.constant(name, x) for name, x in found.items()}
        open_ = {name: ~self._proven(name, x) for name, x in found.items()}
        points = np.flatnonzero(np.logical_or.reduce(list(open_.values())))
        for n in points:
            given = tuple(float(x) if np.ndim(x) == 0 else float(x[n]) for x in inputs)
            for name, value in self.at(given, [name for name in open_ if open_[name][n]]).items():
                values[name][n] = value
        return values, len(points)

    @cached_property
    def doubles(self) -> Doubles:
        """The same program in pairs of doubles, with the bounds of their errors."""
        return Doubles(self.program, bounded=True)

    def constant(self, name: str, found: Doubled) -> Any:
        """A result that is the same for all arguments is rounded once, from its exact value."""
        step = self.program.operations[self.program.results[name]]
        return np.full_like(found.hi, nearest(step.value)) if step.name == "constant" else found.hi.copy()

    def _proven(self, name: str, x: Doubled) -> Any:
        """Where the high part alone is within one unit in the last place, also of the smaller binade at a power of 2."""
        if self.program.operations[self.program.results[name]].name == "constant":
            return np.ones(x.hi.shape, dtype=bool)
        size = np.abs(x.hi)
        with np.errstate(all="ignore"):
            return np.abs(x.lo) + x.error <= size - np.nextafter(size, 0)

    def at(self, inputs: tuple[float, ...], names: Sequence[str]) -> dict[str, float]:
        """The doubles nearest to results at one point, limits and poles included; not-a-number for inputs that are none."""
        if not np.isfinite(inputs).all():
            return dict.fromkeys(names, float("nan"))
        if inputs[0] < 0:  # H(-j omega) is the conjugate of H(j omega)
            mirrored = self.at((-inputs[0], *inputs[1:]), names)
            return {
                name: value if name in SQUARED or name.endswith("real") else -value for name, value in mirrored.items()
            }
        point, found = BallPoint(self.program, inputs), {}
        for bits in _BITS:
            left = [name for name in names if name not in found]
            if left:
                balls = point.balls(bits)
                rounded = {name: nearest_double(balls[name], bits) for name in left}
                found.update({name: value for name, value in rounded.items() if value is not None})
        return {name: found[name] if name in found else self._settled(inputs, name) for name in names}

    def _settled(self, inputs: tuple[float, ...], name: str) -> float:
        """By the closed form; not a number where that is not decided."""
        try:
            return float(self.exact(inputs, name))
        except UndecidedError:
            return float("nan")

    def exact(self, inputs: tuple[float, ...], name: str) -> PointValue:
        """A result from its closed form in lowest terms."""
        frequency, *values = (x.as_integer_ratio() for x in inputs)
        known = {x.name: Rational(*value) for x, value in zip(self.program.inputs[1:], values, strict=True)}
        return PointValue(self.forms(known)[name], fmpq(*frequency), name in SQUARED)

    def number(self, inputs: tuple[float, ...], name: str) -> RealNumber | float:
        """A result to any precision; a float where it is 0, infinite or not a number. SceneError for a negative frequency."""
        if inputs[0] < 0:
            raise SceneError(f"digits: omega = {inputs[0]} rad/s must be >= 0")
        if not np.isfinite(inputs).all():
            return float("nan")
        value = ProgramValue(BallPoint(self.program, inputs), name)
        ball = value.ball(_BITS[1])
        if ball.is_finite() and not ball.contains(0):
            return value
        exact = self.exact(inputs, name)
        return exact if exact.special is None else exact.special


@dataclass(frozen=True, slots=True, repr=False)
class ProgramValue(RealNumber):
    """One result of a program at one point."""

    point: BallPoint
    name: str

    def ball(self, bits: int) -> Ball:
        return self.point.balls(bits)[self.name]
