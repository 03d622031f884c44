"""Step 1 of the evaluation: at which frequencies a distortion becomes, or stops being, noticeable.

A criterion is a real function of omega that must not be positive: r^2 - c^2 of a ratio r = |Re
dH|/|H_env| or |Im dH|/|H_env| with its threshold c, or the function of a JND region. All questions
about a band are answered from one chart of the signs of all these functions (``curves``), without
sampling. Begin with ``noticed`` and ``find_crossings``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import partial
from operator import attrgetter
from typing import Any, TypeAlias

from sympy import Expr, Integer

from haptisym.judge.regions import Cornered, Ellipse, Joint, Region, Sided
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.rings import RationalFunction, c, omega
from haptisym.kernel.roots import Chart, Interval, Key, Point, Signed
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part, Shape, Threshold

Measure: TypeAlias = Callable[[Distortion], RealFunction]


@dataclass(frozen=True)
class Criterion:
    """A condition on a display at each frequency: ``measure`` - ``limit`` must not be positive.

    ``name`` : as JSON calls it. ``words`` : in a legend. ``symbol`` : of what is judged. ``rule`` :
    the condition, written.
    ``measure`` : of a distortion, an exact real function of omega and of what is a symbol in it;
    for a ratio r it is r^2.
    ``sampled`` : the ratio from the fields of compiled values, for drawings.
    ``threshold`` : c of a ratio, a number, a symbol or a formula in omega; 0 where the measure
    itself must not be positive.
    ``part`` : the component of dH that is judged; None where both are.
    ``kept`` : what a display is called that keeps it on a whole band.
    ``region`` : of a JND that is more than a number for each part: what is judged instead.
    """

    name: str
    words: str
    symbol: str
    rule: str
    measure: Measure = field(compare=False)
    sampled: Callable[[Any], Any] | None = field(default=None, compare=False)
    threshold: Expr = Integer(0)
    part: Part | None = None
    kept: str = "transparent"
    region: Region | None = None

    def __hash__(self) -> int:
        # The hash of all fields would be taken at each of a chart's many look-ups.
        return hash(self.name)

    @property
    def component(self) -> str:
        """The operator that gives the component of dH that is judged; empty where both are."""
        return {Part.REAL: "Re", Part.IMAG: "Im"}.get(self.part, "") if self.part else ""

    @property
    def joint(self) -> Joint | None:
        """The region that judges both parts at once; None where it is one part, or a ratio, that is
        judged."""
        return self.region if self.part is None else None  # type: ignore[return-value]

    @property
    def limit(self) -> Expr:
        """The limit of the measure: c^2, or 0."""
        # Squares instead of |x| and square roots: a rational function of omega stays one.
        return (self.threshold**2).expand()

    def depends_on(self, parts: Collection[Part]) -> bool:
        """Whether its threshold is that of one of some parts."""
        return bool(parts) and self.threshold != 0 and (self.part is None or self.part in parts)

    def function(self, d: Distortion) -> Signed:
        """r^2 - c^2 in lowest terms: positive exactly where the criterion is broken, a pole where
        the measure is unbounded.

        As common factors are gone, a resonance at which H_env and dH vanish together invents no
        crossing.
        """
        if self.region:
            return self.region.exceeded(d)
        return self.exceeded(self.measure(d))

    def exceeded(self, measure: RealFunction) -> RealFunction:
        """As ``function``, from a measure that is known already."""
        return level(measure, self.limit)


class Judged:
    """Base of results that concern one criterion."""

    criterion: Criterion

    @property
    def part(self) -> Part | None:
        """The component of dH that is judged; None where both are."""
        return self.criterion.part


def level(measure: RealFunction, limit: Expr) -> RealFunction:
    """A real function minus a limit, a number or a formula in omega: positive where it is above."""
    # A number shares no factor with a measure in lowest terms; a formula may bring one.
    f = measure.function
    bound = f.ring.convert(limit)
    top = f.numerator * bound.denominator - bound.numerator * f.denominator
    difference = RationalFunction(f.ring, top, f.denominator * bound.denominator)
    return RealFunction(difference.reduced() if limit.has(omega) else difference)


def _given_away(d: Distortion) -> RealFunction:
    """-Im H_perc: times pi A^2 the energy that the display generates per cycle of amplitude A."""
    return RealFunction(d.perc_response.imag.axis.zero) - d.perc_response.imag


def _square(part: Part, d: Distortion) -> RealFunction:
    return d.squared_ratios[part]


_JND: Mapping[Part, Criterion] = {
    part: Criterion(
        part.value,
        f"{words} part",
        symbol,
        f"{symbol} <= c_{part.value}",
        partial(_square, part),
        attrgetter(f"ratio_{part.value}"),
        part=part,
    )
    for part, words, symbol in ((Part.REAL, "real", "r_r"), (Part.IMAG, "imaginary", "r_i"))
}


def noticed(threshold: Threshold) -> tuple[Criterion, ...]:
    """The criteria that must all hold so that nothing is noticed: r_r <= c_real and r_i <= c_imag,
    eq. (4), or that a JND region is not left."""
    details = threshold.region
    if details.shape is Shape.SQUARE:
        return tuple(_of_part(threshold, part) for part in Part)
    region: Joint = Ellipse(threshold.real, threshold.imag, details.tilt)
    if corners := details.corners or details.shape.corners:
        region = Cornered(threshold.real, threshold.imag, corners, details.shape)
    rule = f"dH/|H_env| within the {region.kind}"
    return (
        Criterion(
            JOINT, "both parts at once", "r_j", rule, region, threshold=Integer(1), region=region
        ),
    )


def _of_part(threshold: Threshold, part: Part) -> Criterion:
    """The criterion of one part: r <= c, or a region of one part where there is more than c."""
    higher, lower, floor = threshold[part], threshold.lower(part), threshold.region.floor
    plain = replace(_JND[part], threshold=higher)
    if lower is None and floor is None:
        return plain
    sided = Sided(part, higher, higher if lower is None else lower, floor)
    return replace(
        plain, measure=sided, region=sided, rule=f"|{plain.component} dH| within its limit"
    )


JOINT = "joint"
"""The name of the criterion of a region that judges both parts of dH at once."""


def opened(criteria: Iterable[Criterion], parts: Collection[Part]) -> tuple[Criterion, ...]:
    """Criteria with the symbol c for the thresholds of some parts."""
    return tuple(_opened(x, parts) if x.depends_on(parts) else x for x in criteria)


def _opened(x: Criterion, parts: Collection[Part]) -> Criterion:
    if x.region is None:
        return replace(x, threshold=c)
    region = x.region.opened(dict.fromkeys(parts, c))
    return replace(x, measure=region, region=region)


PASSIVE = Criterion(
    "passive", "passive", "-Im H_perc", "Im H_perc >= 0", _given_away, kept="passive"
)
"""The criterion that the display generates no energy at a frequency."""


def judged(chart: Chart) -> tuple[Criterion, ...]:
    """The criteria among the functions of a chart."""
    return tuple(x for x in chart.points[0].after if isinstance(x, Criterion))


def kept(chart: Chart) -> tuple[Interval, ...]:
    """All frequencies of the band at which every criterion is kept: closed intervals, perhaps
    none."""
    criteria = judged(chart)
    return chart.where(lambda signs: all(signs[x] <= 0 for x in criteria))


class CrossingKind(Enum):
    """How a ratio r crosses or touches its threshold c as omega grows.

    ``EXCEEDS`` : r goes from at most c to more. ``RETURNS`` : from more to at most c. ``TOUCHES`` :
    r = c at one frequency and the sign of r - c is the same on both sides; touched from below, the
    display stays transparent there.

    >>> [CrossingKind(x).name for x in ("exceeds", "returns", "touches")]
    ['EXCEEDS', 'RETURNS', 'TOUCHES']
    """

    EXCEEDS = "exceeds"
    RETURNS = "returns"
    TOUCHES = "touches"


_MEETS = {
    CrossingKind.EXCEEDS: "exceeds",
    CrossingKind.RETURNS: "returns below",
    CrossingKind.TOUCHES: "touches",
}

_LEAVES = {
    CrossingKind.EXCEEDS: "leaves",
    CrossingKind.RETURNS: "returns into",
    CrossingKind.TOUCHES: "touches",
}


@dataclass(frozen=True, repr=False)
class Crossing(Judged, Shown):
    """A frequency at which a ratio equals its threshold, or dH lies on the border of a joint
    region.

    ``criterion`` : which ratio and threshold; ``criterion.part`` is the part, None of a joint
    region.
    ``omega`` : rad/s, an algebraic or enclosed real number; ``float(omega)``, ``omega.digits(n)``
    and ``omega.enclosure(n)`` give it correctly rounded, and proven bounds.
    ``kind`` : a ``CrossingKind``. ``sign`` : of Re dH or Im dH there, 0 of a joint region.
    ``multiplicity`` : of the root.
    ``jump`` : whether the threshold passes the ratio there, from the one for higher to the one for
    lower or back.

    >>> import haptisym as hs
    >>> first, _ = hs.evaluate("fu2019").crossings
    >>> first.kind.value, first.sign, first.multiplicity, first.omega.digits(20)
    ('exceeds', 1, 1, '7.9789167901747077028')
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


class PerceptFunction(Enum):
    """The real functions whose signs tell how a distortion is felt; each is of one part."""

    # Members are singletons; the hash by name is slow, and charts look up much.
    __hash__ = object.__hash__

    ENVIRONMENT = "Re or Im of H_env"
    PERCEIVED = "Re or Im of H_perc"
    DIFFERENCE = "Re or Im of dH"
    SUM = "Re or Im of H_env + H_perc; its sign times that of dH compares the magnitudes"
    WITHOUT_FRICTION = "a criterion of the display without its friction"
    OUTSIDE = "where a region judges both parts at once: whether that part alone would be outside"


NEARER = "real nearer"
"""For a region that judges both parts at once: the function that is positive where the real part is
nearer its own limit than the imaginary part."""


def curves(
    d: Distortion, criteria: Iterable[Criterion], without_friction: Distortion | None = None
) -> dict[Key, Signed]:
    """All real functions whose signs an evaluation needs, by their names on its chart."""
    responses = {
        PerceptFunction.ENVIRONMENT: d.env_response,
        PerceptFunction.PERCEIVED: d.perc_response,
        PerceptFunction.DIFFERENCE: d.difference_response,
    }
    listed = list(criteria)
    functions: dict[Key, Signed] = {x: x.function(d) for x in listed}
    for region in (x.joint for x in listed if x.joint):
        functions |= {(PerceptFunction.OUTSIDE, part): region.projected(d, part) for part in Part}
        functions[NEARER] = region.nearer(d)
    if without_friction is not None:
        # Friction is named for the imaginary part, and for both parts together.
        damped = [x for x in listed if x.part is Part.IMAG or x.joint]
        for x in damped:
            functions[PerceptFunction.WITHOUT_FRICTION, x] = x.function(without_friction)
    for part in Part:
        functions |= {(name, part): part_of(x, part) for name, x in responses.items()}
        # |p|^2 - |e|^2 = (p - e)(p + e): two signs compare the magnitudes.
        environment, perceived = part_of(d.env_response, part), part_of(d.perc_response, part)
        functions[PerceptFunction.SUM, part] = environment + perceived
    return functions


def find_crossings(chart: Chart) -> tuple[Crossing, ...]:
    """All crossings on the band in ascending order; () means proved none."""
    criteria = judged(chart)
    crossings: list[Crossing] = []
    # The order of a zero is positive, that of a pole negative.
    for point in chart.points:
        met = (x for x in criteria if point.orders.get(x, 0) > 0 and x not in point.undecided)
        crossings += [_crossing(point, x) for x in met]
    return tuple(crossings)


def _crossing(point: Point, x: Criterion) -> Crossing:
    """The crossing of a criterion at a zero of its function."""
    before, after = point.before[x], point.after[x]
    # At omega = 0 all functions are even or odd, and the sign before it is a mirror image: a ratio
    # that rises from its threshold there exceeds it.
    mirrored = isinstance(point.omega, ExactNumber) and point.omega.value == 0
    if before == after and not (mirrored and after > 0):
        kind = CrossingKind.TOUCHES
    else:
        kind = CrossingKind.EXCEEDS if after > 0 else CrossingKind.RETURNS
    # The limit for higher takes over from that for lower where H_perc = -H_env in this part.
    has_sides = isinstance(x.region, Sided) and x.region.has_sides
    jump = has_sides and point.orders.get((PerceptFunction.SUM, x.part), 0) > 0
    sign = point.after.get((PerceptFunction.DIFFERENCE, x.part), 0)
    return Crossing(x, point.omega, kind, sign, point.orders[x], jump)


def unbounded_points(chart: Chart) -> tuple[Point, ...]:
    """Where a ratio has a pole: H_env = 0 while dH does not vanish with it, or dH itself is
    infinite."""
    criteria = judged(chart)
    return tuple(p for p in chart.points if any(p.orders.get(x, 0) < 0 for x in criteria))
