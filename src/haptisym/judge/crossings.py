"""Step 1, when: the frequencies at which a distortion becomes, or stops being, noticeable."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from sympy import Expr

from haptisym.kernel.levels import Level, algebraic
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Chart, Interval, Point
from haptisym.kernel.shown import Shown
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part, Threshold, is_irrational_algebraic


class CrossingKind(Enum):
    """How a ratio r meets its threshold c as omega grows."""

    EXCEEDS = "exceeds"
    RETURNS = "returns"
    TOUCHES = "touches"


_MEETS = {CrossingKind.EXCEEDS: "exceeds", CrossingKind.RETURNS: "returns below", CrossingKind.TOUCHES: "touches"}


@dataclass(frozen=True, repr=False)
class Crossing(Shown):
    """A frequency at which r_r or r_i equals its threshold; ``sign`` is that of Re dH or Im dH there."""

    part: Part
    omega: RealNumber
    kind: CrossingKind
    sign: int
    multiplicity: int

    def _line(self) -> str:
        return f"{'r_r' if self.part is Part.REAL else 'r_i'} {_MEETS[self.kind]} its threshold at {self.omega!r} rad/s"


class Curve(Enum):
    """The real functions whose signs answer the questions; each exists for both parts."""

    __hash__ = object.__hash__  # members are singletons; the hash by name is slow, and charts look up much

    EXCESS = "r^2 - c^2"
    ENVIRONMENT = "Re or Im of H_env"
    PERCEIVED = "Re or Im of H_perc"
    DIFFERENCE = "Re or Im of dH"
    SUM = "Re or Im of H_env + H_perc; its sign times that of dH compares the magnitudes"


def curves(d: Distortion, threshold: Threshold) -> dict[tuple[Curve, Part], RealFunction | Level]:
    """All real functions that an evaluation asks about."""
    both = RationalFunction(d.env.ring, d.env.numerator, d.env.denominator) + d.perc
    total = on_axis(both.reduced())
    found: dict[tuple[Curve, Part], RealFunction | Level] = {}
    for part in Part:
        found[Curve.EXCESS, part] = excess(d, threshold[part], part)
        found[Curve.ENVIRONMENT, part] = part_of(d.env_response, part)
        found[Curve.PERCEIVED, part] = part_of(d.perc_response, part)
        found[Curve.DIFFERENCE, part] = part_of(d.difference_response, part)
        found[Curve.SUM, part] = part_of(total, part)
    return found


def excess(d: Distortion, c: Expr, part: Part) -> RealFunction | Level:
    """r^2 - c^2 in lowest terms: positive exactly where r > c, zero exactly where r = c, a pole where r is unbounded.

    As common factors are gone, a resonance at which H_env and dH vanish together invents no crossing.
    """
    return level(d.squared_ratios[part], (c**2).expand())


def level(square: RealFunction, limit: Expr) -> RealFunction | Level:
    """A squared ratio minus a positive number, which may be an irrational algebraic one: positive where the ratio is above."""
    if is_irrational_algebraic(limit):
        return Level(square, algebraic(limit))
    bound = square.function.ring.convert(limit)
    f = square.function
    top = f.numerator * bound.denominator - bound.numerator * f.denominator
    return RealFunction(RationalFunction(f.ring, top, f.denominator * bound.denominator))


def find_crossings(chart: Chart) -> tuple[Crossing, ...]:
    """All crossings on the band in ascending order; () means proved none."""
    return tuple(_crossing(point, part) for point in chart.points for part in Part if _is_crossing(point, part))


def _is_crossing(point: Point, part: Part) -> bool:
    return point.orders.get((Curve.EXCESS, part), 0) > 0 and (Curve.EXCESS, part) not in point.undecided


def _crossing(point: Point, part: Part) -> Crossing:
    before, after = point.before[Curve.EXCESS, part], point.after[Curve.EXCESS, part]
    mirrored = isinstance(point.omega, ExactNumber) and point.omega.value == 0  # where all functions are even or odd
    if before == after and not (mirrored and after > 0):
        kind = CrossingKind.TOUCHES
    else:
        kind = CrossingKind.EXCEEDS if after > 0 else CrossingKind.RETURNS
    sign = point.after[Curve.DIFFERENCE, part]
    return Crossing(part, point.omega, kind, sign, point.orders[Curve.EXCESS, part])


def transparent_set(chart: Chart) -> tuple[Interval, ...]:
    """All frequencies of the band with r_r <= c_real and r_i <= c_imag: closed intervals, perhaps none."""
    return chart.where(lambda signs: all(signs[Curve.EXCESS, part] <= 0 for part in Part))


def unbounded_points(chart: Chart) -> tuple[Point, ...]:
    """Where a ratio has a pole: H_env = 0 while dH does not vanish with it, or dH itself is infinite."""
    return tuple(p for p in chart.points if any(p.orders.get((Curve.EXCESS, part), 0) < 0 for part in Part))
