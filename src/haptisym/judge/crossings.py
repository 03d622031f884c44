"""Step 1, when: the frequencies at which a distortion becomes, or stops being, noticeable."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from haptisym.judge.criteria import Criterion, Judged, judged
from haptisym.judge.regions import Sided
from haptisym.kernel.lattices import Signed
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.roots import Chart, Key, Point
from haptisym.kernel.shown import Shown
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part


class CrossingKind(Enum):
    """How a ratio r meets its threshold c as omega grows."""

    EXCEEDS = "exceeds"
    RETURNS = "returns"
    TOUCHES = "touches"


_MEETS = {CrossingKind.EXCEEDS: "exceeds", CrossingKind.RETURNS: "returns below", CrossingKind.TOUCHES: "touches"}

_LEAVES = {CrossingKind.EXCEEDS: "leaves", CrossingKind.RETURNS: "returns into", CrossingKind.TOUCHES: "touches"}


@dataclass(frozen=True, repr=False)
class Crossing(Judged, Shown):
    """A frequency at which a ratio equals its threshold; ``sign`` is that of Re dH or Im dH there, 0 where both are judged.

    ``jump`` : whether it is the threshold that passes the ratio there, from the one for higher to the one for lower or back.
    """

    criterion: Criterion
    omega: RealNumber
    kind: CrossingKind
    sign: int
    multiplicity: int
    jump: bool = False

    def _line(self) -> str:
        what = f"dH {_LEAVES[self.kind]} the {x.kind}" if (x := self.criterion.joint) else ""
        said = what or f"{self.criterion.symbol} {_MEETS[self.kind]} its threshold"
        return f"{said} at {self.omega!r} rad/s"


class Curve(Enum):
    """The real functions whose signs tell how a distortion is felt; each is of one part."""

    __hash__ = object.__hash__  # members are singletons; the hash by name is slow, and charts look up much

    ENVIRONMENT = "Re or Im of H_env"
    PERCEIVED = "Re or Im of H_perc"
    DIFFERENCE = "Re or Im of dH"
    SUM = "Re or Im of H_env + H_perc; its sign times that of dH compares the magnitudes"
    WITHOUT_FRICTION = "a criterion of the display without its friction"
    OUTSIDE = "where a region judges both parts at once: whether that part alone would be outside"


NEARER = "real nearer"
"""The function that is positive where the real part is nearer its own limit than the imaginary part, of such a region."""


def curves(
    d: Distortion, criteria: Iterable[Criterion], without_friction: Distortion | None = None
) -> dict[Key, Signed]:
    """All real functions that an evaluation asks about."""
    responses = {
        Curve.ENVIRONMENT: d.env_response,
        Curve.PERCEIVED: d.perc_response,
        Curve.DIFFERENCE: d.difference_response,
    }
    listed = list(criteria)
    found: dict[Key, Signed] = {x: x.function(d) for x in listed}
    for region in (x.joint for x in listed if x.joint):
        found |= {(Curve.OUTSIDE, part): region.projected(d, part) for part in Part}
        found[NEARER] = region.nearer(d)
    if without_friction is not None:
        own = [x for x in listed if x.part is Part.IMAG or x.joint]
        found |= {(Curve.WITHOUT_FRICTION, x): x.function(without_friction) for x in own}
    for part in Part:
        found |= {(name, part): part_of(x, part) for name, x in responses.items()}
        found[Curve.SUM, part] = part_of(d.env_response, part) + part_of(d.perc_response, part)
    return found


def find_crossings(chart: Chart) -> tuple[Crossing, ...]:
    """All crossings on the band in ascending order; () means proved none."""
    criteria = judged(chart)
    return tuple(_crossing(point, x) for point in chart.points for x in criteria if _is_crossing(point, x))


def _is_crossing(point: Point, x: Criterion) -> bool:
    return point.orders.get(x, 0) > 0 and x not in point.undecided


def _crossing(point: Point, x: Criterion) -> Crossing:
    before, after = point.before[x], point.after[x]
    mirrored = isinstance(point.omega, ExactNumber) and point.omega.value == 0  # where all functions are even or odd
    if before == after and not (mirrored and after > 0):
        kind = CrossingKind.TOUCHES
    else:
        kind = CrossingKind.EXCEEDS if after > 0 else CrossingKind.RETURNS
    jump = isinstance(x.region, Sided) and x.region.has_sides and point.orders.get((Curve.SUM, x.part), 0) > 0
    return Crossing(x, point.omega, kind, point.after.get((Curve.DIFFERENCE, x.part), 0), point.orders[x], jump)


def unbounded_points(chart: Chart) -> tuple[Point, ...]:
    """Where a ratio has a pole: H_env = 0 while dH does not vanish with it, or dH itself is infinite."""
    criteria = judged(chart)
    return tuple(p for p in chart.points if any(p.orders.get(x, 0) < 0 for x in criteria))
