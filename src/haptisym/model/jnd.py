"""The just-noticeable difference: how large a change of the dynamics must be for a person to notice
it.

A threshold is a region in the plane of x = Re dH/|H_env| and y = Im dH/|H_env|: the paper's square,
or an ellipse, a diamond, a polygon; each number exact, or a rational formula in omega; read from
``jnd = ...``, a number, a formula or a table. Begin with ``Threshold``.

Published thresholds go by name, each with the criterion at which it was taken. A change of size x
is noticed with the probability Phi(x/sigma), so that the change noticed with probability p is z(p)
sigma, z the inverse of Phi: thresholds at two proportions have the quotient of their z. It is
transcendental, and is rounded to a decimal number of DIGITS digits, each proven, so that
everything that follows is exact for that number.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cache
from importlib.resources import files
from itertools import combinations
from typing import Any, TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer, Rational, pi

from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import SceneError, meant, quoted, within
from haptisym.kernel.objects import Shown, Viewed
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.rings import omega
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.model.parameters import ExactRange, ranged, read_confidence
from haptisym.model.quantities import (
    Dimension,
    MotionKind,
    Number,
    decimal,
    evaluate,
    number,
    require_number,
)


@dataclass(frozen=True, repr=False)
class Published(Shown):
    """A just-noticeable difference as its source gives it: a fraction from ``low`` to ``high``,
    dimensionless (1/10 is 10 %).

    ``criterion`` : the proportion of correct answers at which it was taken, None where that is not
    known. ``quantity`` : of what; ``reference`` : at which levels, with whom. ``read`` : how much
    of ``source`` was read. ``apart`` : why it is no threshold for a scene; empty where it may be
    one. Measured by its authors, not proven.

    >>> like("weight").written, like("weight").low
    ('22 to 44 %', 11/50)
    """

    name: str
    quantity: str
    low: Expr
    high: Expr
    criterion: Expr | None
    reference: str
    source: str
    doi: str
    read: str
    apart: str

    def _line(self) -> str:
        return f"{self.name}: {self.written}, {self.quantity}"

    @property
    def written(self) -> str:
        """The value or the range in per cent, four digits."""
        low, high = (f"{float(100 * x):.4g}" for x in (self.low, self.high))
        return f"{low} %" if low == high else f"{low} to {high} %"

    @property
    def given(self) -> Expr | ExactRange:
        """The value as a Threshold takes it: a number, or the pair of the ends of its range."""
        return self.low if self.low == self.high else (self.low, self.high)


@cache
def published_by_name() -> Mapping[str, Published]:
    """All published thresholds by name, in the order of the shipped table."""
    table = tomllib.loads(
        (files("haptisym") / "data" / "published.toml").read_text(encoding="utf-8")
    )
    return {name: _read_published(name, row) for name, row in table.items()}


def _read_published(name: str, row: Mapping[str, Any]) -> Published:
    """A published threshold from its row in the shipped table."""
    value, criterion = row["value"], row.get("criterion")
    low, high = map(decimal, (value, value) if isinstance(value, str) else value)
    return Published(
        name,
        row["quantity"],
        low,
        high,
        None if criterion is None else decimal(criterion),
        row["reference"],
        row["source"],
        row.get("doi", ""),
        row["read"],
        row.get("apart", ""),
    )


def like(name: object) -> Published:
    """The published threshold of that name; SceneError for any other name, and for one that is no
    threshold for a scene."""
    known = published_by_name()
    if not isinstance(name, str) or name not in known:
        shown = str(name)[:60]
        raise SceneError(
            f'like: unknown published threshold "{shown}": {meant(shown, known)}valid are '
            f"{', '.join(known)}"
        )
    published = known[name]
    if published.apart:
        raise SceneError(f'like: "{name}" is no threshold for a scene: {published.apart}')
    return published


# Digits to which the factor of a conversion is rounded. Each is proven, and from there on the
# factor is this decimal, exactly.
DIGITS = 30


@dataclass(frozen=True, repr=False)
class Quotient(RealNumber):
    """z(q)/z(p): the threshold at the proportion q, for one of 1 at p.

    >>> Quotient(Rational(3, 4), Rational(21, 25)).digits(17)
    '1.4743854638571648'
    """

    start: Expr
    end: Expr

    def ball(self, bits: int) -> Ball:
        # z(p) = sqrt(2) erfinv(2 p - 1), and sqrt(2) cancels. Balls are rigorous at any
        # precision; 16 bits more than wanted keep the quotient as narrow as was asked.
        with flint.ctx.workprec(bits + 16):
            one, other = (2 * expression_ball(x) - arb(1) for x in (self.start, self.end))
            return other.erfinv() / one.erfinv()


@dataclass(frozen=True)
class Conversion:
    """The conversion of a threshold from one proportion of right answers to another: a product
    with ``factor``, which is ``exact`` rounded to DIGITS digits."""

    start: Expr
    end: Expr

    @property
    def exact(self) -> RealNumber:
        """The factor of a threshold, as a number that can be enclosed."""
        return Quotient(self.start, self.end)

    @property
    def factor(self) -> Rational:
        """The factor of a threshold, as the decimal that is said; 1 where nothing is converted."""
        return decimal(self.exact.digits(DIGITS)) if self.start != self.end else Rational(1)

    def row(self) -> dict[str, object]:
        """The conversion as JSON documents have it."""
        shown = {
            "factor": self.exact.digits(DIGITS),
            "enclosure": list(self.exact.enclosure(DIGITS)),
        }
        return {"from": float(self.start), "to": float(self.end), **shown}


def read_proportion(key: str, given: Number) -> Expr:
    """A proportion of right answers, above one half and below 1; SceneError for any other."""
    with within(key):
        value = number(given, Dimension.RATIO).value
    # At one half z = 0: no threshold can be scaled from there, and below it z is negative.
    if not value.is_Rational or not Rational(1, 2) < value < 1:
        raise SceneError(f'{key}: "{given}" must be rational, above 0.5 and below 1')
    return value


Corner: TypeAlias = tuple[Expr, Expr]
MOST_CORNERS = 24


class Shape(Enum):
    """The shape of the region. A further one that has corners is a row here and in ``_KEYS`` and
    ``_CORNERS``: nothing else names it."""

    SQUARE = "square"
    ELLIPSE = "ellipse"
    DIAMOND = "diamond"
    POLYGON = "polygon"

    @property
    def corners(self) -> tuple[Corner, ...]:
        """The corners, counterclockwise, in half widths; empty where the shape alone does not give
        them."""
        return _CORNERS.get(self, ())

    @property
    def words(self) -> str:
        """The name with its article: ``an ellipse``."""
        return f"{'an' if self.value[0] in 'aeio' else 'a'} {self.value}"


_CORNERS: Mapping[Shape, tuple[Corner, ...]] = {
    Shape.DIAMOND: tuple((Integer(x), Integer(y)) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)))
}


@dataclass(frozen=True, slots=True)
class RegionDetails:
    """All that defines a region besides its half widths; each number exact, or a rational formula
    in omega.

    ``tilt`` : of an ellipse. ``corners`` : of a polygon, counterclockwise. ``lower`` : of a square,
    the limits of Re and Im for changes that make the part smaller; None where they are those for
    changes that make it larger. ``floor`` : of a square, N/m or N m/rad, the least change that is
    noticed; ``motion`` : as its unit tells. ``ranges`` : where numbers of it may lie, by name:
    ``real.lower``, ``imag.lower``, ``floor``, and ``scale``, how many times all of it is as large
    as was given; ``size`` : that, nominal.
    """

    shape: Shape = Shape.SQUARE
    tilt: Expr = Integer(0)
    corners: tuple[Corner, ...] = ()
    lower: tuple[Expr | None, Expr | None] = (None, None)
    floor: Expr | None = None
    motion: MotionKind | None = None
    ranges: tuple[tuple[str, ExactRange], ...] = ()
    size: Expr = Integer(1)

    @property
    def numbers(self) -> dict[str, Expr]:
        """The numbers that must be positive besides the half widths, by name."""
        named = {"real: lower": self.lower[0], "imag: lower": self.lower[1], "floor": self.floor}
        return {name: x for name, x in named.items() if x is not None}

    def scaled(self, c: Expr) -> RegionDetails:
        """The same region c times as large, with its ranges."""
        corners = tuple((x * c, y * c) for x, y in self.corners)
        real, imag = (None if x is None else x * c for x in self.lower)
        floor = None if self.floor is None else self.floor * c
        # ``scale`` is a factor already, and tilt is dimensionless: both stay.
        ranges = []
        for key, interval in self.ranges:
            low, high = interval
            ranges.append((key, interval if key == "scale" else (low * c, high * c)))
        return replace(self, corners=corners, lower=(real, imag), floor=floor, ranges=tuple(ranges))

    def check(self, low: Expr, high: Expr) -> None:
        """SceneError unless the region has 0 inside and is convex at every frequency of a band."""
        if self.shape is Shape.ELLIPSE and not positive(1 - self.tilt**2, low, high):
            raise SceneError(
                f"tilt: {self.tilt} must lie strictly between -1 and 1{_everywhere([self.tilt])}"
            )
        if self.shape is Shape.POLYGON:
            _check_polygon(self.corners, low, high)


SQUARE = RegionDetails()


def positive(value: Expr, low: Expr, high: Expr) -> bool:
    """Whether a number, or a rational formula in omega, is positive (and finite) on a whole band:
    exact.

    >>> positive(1 - omega / 10, Integer(0), Integer(9)), positive(1 - omega / 10, Integer(0), Integer(10))
    (True, False)
    """
    if not value.has(omega):
        return sign_of_number(value) > 0
    # Between neighbouring points of the chart neither zeros nor poles lie, so that the signs at its
    # points, which include both ends of the band, decide; a negative order is a pole.
    table = chart({"": RealFunction(Ring().axis.convert(value).reduced())}, low, high)
    return all(point.at[""] > 0 and point.orders.get("", 0) >= 0 for point in table.points)


def turning(corners: Sequence[Corner], at: Expr) -> Expr:
    """Twice the area of a polygon at a frequency: positive where its corners go
    counterclockwise."""
    area = sum((_cross(p, q) for p, q in _edges(corners)), Integer(0))
    value: Expr = area.subs(omega, at)
    return value


def _check_polygon(corners: Sequence[Corner], low: Expr, high: Expr) -> None:
    """SceneError unless corners go once around 0, convex, at every frequency of a band."""
    # Equal corners first: they would make a cross product 0 below, and a message that hides why.
    everywhere = _everywhere(x for corner in corners for x in corner)
    for (i, p), (j, q) in combinations(enumerate(corners, 1), 2):
        if not positive((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2, low, high):
            where = " at some frequency" if everywhere else ""
            raise SceneError(f"corners: {i} and {j} are the same point, [{p[0]}, {p[1]}]{where}")
    # With p x q > 0 on each edge 0 lies strictly to the left of all edges. That holds of a
    # pentagram too, which goes around twice: the winding number must be 1.
    if (
        not all(positive(_cross(p, q), low, high) for p, q in _edges(corners))
        or _turns(corners, low, high) != 1
    ):
        order = "0 must be inside, not on an edge, and the corners in order around it"
        raise SceneError(f"corners: {_written(corners)}: {order}{everywhere}")
    # A closed curve that winds once is convex where it turns to the left at every corner.
    steps = [(q[0] - p[0], q[1] - p[1]) for p, q in _edges(corners)]
    if not all(positive(_cross(p, q), low, high) for p, q in _edges(steps)):
        convex = "the polygon must be convex, without corners on a straight edge"
        raise SceneError(f"corners: {_written(corners)}: {convex}{everywhere}")


def _written(corners: Sequence[Corner]) -> str:
    """The first corners as text: ``[[1/10, 0], [0, 1/10], ...]``."""
    more = ", ..." if len(corners) > _MOST_SHOWN else ""
    return f"[{', '.join(f'[{x}, {y}]' for x, y in corners[:_MOST_SHOWN])}{more}]"


_MOST_SHOWN = 5


def _everywhere(values: Iterable[Expr]) -> str:
    """The end of a message on numbers that depend on the frequency; empty where none does."""
    return " on the whole band" if any(x.has(omega) for x in values) else ""


def _edges(corners: Sequence[Corner]) -> list[tuple[Corner, Corner]]:
    """The edges of a closed polygon, as pairs of corners."""
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _cross(p: Corner, q: Corner) -> Expr:
    """p x q, twice the area of the triangle (0, p, q): positive where q is to the left of p."""
    return (p[0] * q[1] - p[1] * q[0]).expand()


def _turns(corners: Sequence[Corner], low: Expr, high: Expr) -> int:
    """The winding number around 0 of corners each of which is to the left of the one before: how
    often their edges come up over the axis of x."""
    # On a band whose edges never pass through 0 the winding number is constant: one frequency will
    # do.
    heights = [sign_of_number(y.subs(omega, (low + high) / 2)) for _, y in corners]
    return sum(a < 0 <= b for a, b in zip(heights, [*heights[1:], heights[0]], strict=True))


class Part(Enum):
    """Real part (stiffness and mass) or imaginary part (damping) of a dynamics."""

    # Members are singletons; the hash by name is slow, and charts look up much.
    __hash__ = object.__hash__

    REAL = "real"
    IMAG = "imag"


@dataclass(frozen=True, slots=True)
class Threshold(Viewed):
    """The JND c of eq. (4): a change is noticed where ``|Re dH| > real |H_env|`` or ``|Im dH| >
    imag |H_env|``.

    Each a number > 0, dimensionless: rational or rational in pi; a range (``"0.1 +- 20 %"`` or a
    pair); or a rational formula in omega, as a string. ``region`` : what it is besides, where it is
    not the paper's square. SceneError for anything else.
    Source: Fu, van Paassen and Mulder (2019), eq. (4); 10 % for the impedances of manual control.

    >>> Threshold.of(0.1)
    Threshold(real=1/10, imag=1/10)
    """

    real: Expr = Rational(1, 10)
    imag: Expr = Rational(1, 10)
    real_interval: ExactRange | None = field(default=None, repr=False)
    imag_interval: ExactRange | None = field(default=None, repr=False)
    """Where they may lie, if they are given as ranges (``"0.1 +- 20 %"`` or a pair)."""
    source: str = field(default="", repr=False)
    """The name of the published threshold that it is, if it is one."""
    region: RegionDetails = SQUARE
    proportion: Expr | None = field(default=None, repr=False)
    conversion: Conversion | None = field(default=None, repr=False)
    """At which proportion of right answers it holds, if that is told, and how it was brought there,
    if it was."""
    confidence: Expr | None = field(default=None, repr=False)
    """Of the interval that its ranges are, where they were estimated."""

    @classmethod
    def of(cls, real: Number, imag: Number | None = None) -> Threshold:
        """A threshold from numbers; the imaginary part's is the real part's unless given.
        SceneError unless > 0."""
        return cls(real, real if imag is None else imag)

    @classmethod
    def like(cls, name: str) -> Threshold:
        """A published one, by its name, with its range where the source gives one. SceneError for a
        name that there is not.

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
        # A tilted ellipse with one half width larger does not hold the smaller one, so that the
        # ends of its ranges would not bound what is between them.
        if self.region.tilt and self.ranges and not ("scale" in self.ranges or self.is_scaled):
            raise SceneError(f"{_TILTED}: give both the same range, or a scale")
        if "scale" in self.ranges and len(self.ranges) > 1:
            raise SceneError("scale: leave out the other ranges of the JND")

    def __repr__(self) -> str:
        region = "" if self.region == SQUARE else f", region={self.region!r}"
        return f"Threshold(real={self.real}, imag={self.imag}{region})"

    def __getitem__(self, part: Part) -> Expr:
        return {Part.REAL: self.real, Part.IMAG: self.imag}[part]

    # Python would iterate over __getitem__(0), (1), ...: its parts are named, not counted.
    __iter__ = None

    def lower(self, part: Part) -> Expr | None:
        """The limit for changes that make a part smaller; None where it is the one for changes that
        make it larger."""
        return self.region.lower[0 if part is Part.REAL else 1]

    @property
    def corners(self) -> tuple[Corner, ...]:
        """The corners of a region that judges both parts at once, counterclockwise, as fractions of
        ``|H_env|``; empty for a square and an ellipse."""
        return self.region.corners or tuple(
            (x * self.real, y * self.imag) for x, y in self.region.shape.corners
        )

    @property
    def is_constant(self) -> bool:
        """Whether no number of it depends on the frequency."""
        region = self.region
        numbers = (
            self.real,
            self.imag,
            region.tilt,
            *region.numbers.values(),
            *(x for p in region.corners for x in p),
        )
        return not any(x.has(omega) for x in numbers)

    @property
    def is_plain(self) -> bool:
        """Whether it is the paper's square: a constant number for each part."""
        return self.region == SQUARE and self.is_constant

    @property
    def is_scaled(self) -> bool:
        """Whether both half widths are one number, of an ellipse or a diamond: such a region holds
        all smaller ones of its kind."""
        alike = self.real == self.imag and self.real_interval == self.imag_interval
        judges_both = self.region.shape is not Shape.SQUARE and not self.region.corners
        return alike and judges_both and not self.region.ranges

    @property
    def ranges(self) -> dict[str, ExactRange]:
        """The ranges of its numbers by name: ``real``, ``imag``, and those of the region."""
        named = {"real": self.real_interval, "imag": self.imag_interval, **dict(self.region.ranges)}
        return {name: x for name, x in named.items() if x}

    @property
    def is_box(self) -> bool:
        """Whether its ranges, if it has any, are those of numbers that a box of parameters can
        hold."""
        return not self.ranges or self.is_plain or self.is_scaled

    @property
    def kind(self) -> str:
        """The kind of region in words: ``an ellipse``, ``a square with a floor``."""
        region = self.region
        if region.shape is not Shape.SQUARE:
            return region.shape.words
        if region.floor is not None:
            return "a square with a floor"
        if region.lower != (None, None):
            return "a square with limits for higher and lower"
        return "a square" if self.real == self.imag else "a rectangle"

    def need_plain(self, question: str) -> None:
        """SceneError, beginning with the question, unless it is the paper's square: for what is
        defined, or answered, for that alone."""
        if not self.is_plain:
            kind = self.kind if self.is_constant else f"{self.kind} that depends on omega"
            raise SceneError(
                f"{question}: the JND is {kind}; give one number for each part, as jnd = 0.1"
            )

    def check(self, low: Expr, high: Expr, motion: MotionKind | None) -> None:
        """SceneError unless it makes a region at every frequency of a band, for a scene of that
        motion."""
        with within("jnd"):
            self.region.check(low, high)
            for key, x in {"real": self.real, "imag": self.imag, **self.region.numbers}.items():
                if x.has(omega) and not positive(x, low, high):
                    raise SceneError(f"{key}: {x} must be > 0 on the whole band")
        if self.region.motion and motion and self.region.motion is not motion:
            raise SceneError(
                f"jnd: floor: the unit is {self.region.motion.value}, the scene {motion.value}"
            )

    def with_limits(self, limits: Mapping[Part, Number]) -> Threshold:
        """The threshold with other numbers for some parts, in place of their ranges, formulas and
        limits for each direction."""
        if limits and self.region.shape is Shape.POLYGON:
            raise SceneError("jnd: a polygon has no limit for one part: change its corners")
        # A new number has no range of its own and ends the old one; the other part keeps its own.
        given = {
            part: (limits[part], None) if part in limits else (self[part], self.interval(part))
            for part in Part
        }
        (real, real_interval), (imag, imag_interval) = given.values()
        lower = [None if part in limits else self.lower(part) for part in Part]
        replaced = {f"{part.value}.lower" for part in limits}
        ranges = tuple((name, x) for name, x in self.region.ranges if name not in replaced)
        region = replace(self.region, lower=(lower[0], lower[1]), ranges=ranges)
        return Threshold(
            real,
            imag,
            real_interval,
            imag_interval,
            "" if limits else self.source,
            region,
            self.proportion,
        )

    def scaled(self, c: Expr) -> Threshold:
        """The same threshold c times as large, without ranges."""
        # The size of a region with corners is in its corners: its half widths stay what they are.
        region = replace(self.region, ranges=(), size=Integer(1)).scaled(c)
        widths = (self.real, self.imag) if region.corners else (self.real * c, self.imag * c)
        return Threshold(*widths, region=region, proportion=self.proportion)

    def at_end(self, end: int) -> Threshold:
        """The smallest (0) or the largest (1) one of its ranges: the region grows with each of
        them."""
        at = {name: interval[end] for name, interval in self.ranges.items()}
        # All numbers are those of the nominal scale already.
        if "scale" in at:
            return self.scaled(at["scale"] / self.region.size)
        lower = [at.get(f"{part.value}.lower", self.lower(part)) for part in Part]
        region = replace(
            self.region,
            lower=(lower[0], lower[1]),
            floor=at.get("floor", self.region.floor),
            ranges=(),
        )
        return Threshold(at.get("real", self.real), at.get("imag", self.imag), region=region)

    def at_proportion(self, end: Number) -> Threshold:
        """The threshold at another proportion of right answers, by a cumulative Gaussian;
        SceneError where its own proportion is not given."""
        to = read_proportion("proportion", end)
        start = self.proportion or (like(self.source).criterion if self.source else None)
        if start is None:
            raise SceneError(
                "proportion: the JND has none of its own: add one to its table, as "
                "proportion = 0.75"
            )
        conversion = Conversion(read_proportion("proportion", start), to)
        c = conversion.factor
        intervals = (self.real_interval, self.imag_interval)
        real, imag = (x and (x[0] * c, x[1] * c) for x in intervals)
        # A polygon is as large as its corners, which ``region`` scales; its half widths are 1.
        region, has_widths = self.region.scaled(c), self.region.shape is not Shape.POLYGON
        widths = (self.real * c, self.imag * c) if has_widths else (self.real, self.imag)
        return Threshold(*widths, real, imag, self.source, region, to, conversion)

    def row(self) -> dict[str, Any]:
        """The threshold as JSON documents have it: the half widths, and what else the region is."""
        region = self.region
        proportion: dict[str, Any] = (
            {} if self.proportion is None else {"proportion": float(self.proportion)}
        )
        proportion |= {"conversion": self.conversion.row()} if self.conversion else {}
        if region.shape is Shape.POLYGON:
            return {
                "shape": region.shape.value,
                "corners": [[str(x), str(y)] for x, y in region.corners],
            } | proportion
        row: dict[str, Any] = {"real": str(self.real), "imag": str(self.imag)}
        row |= {} if region.shape is Shape.SQUARE else {"shape": region.shape.value}
        row |= {"tilt": str(region.tilt)} if region.tilt else {}
        lower = {part.value: str(x) for part in Part if (x := self.lower(part)) is not None}
        return (
            row
            | ({"lower": lower} if lower else {})
            | ({"floor": str(region.floor)} if region.floor else {})
            | proportion
        )

    def interval(self, part: Part) -> ExactRange | None:
        """The range of a part's threshold, if it has one."""
        return self.real_interval if part is Part.REAL else self.imag_interval


_TILTED = "separate ranges of the half widths of a tilted ellipse are not supported"


def threshold_value(key: str, given: Number) -> tuple[Expr, ExactRange | None]:
    """Read a threshold and its range, None if it has none; SceneError, with the key, unless all
    numbers are > 0. Whether a formula in omega is positive is not tested here: no band is known."""
    # A formula in which omega cancels is a number, and is checked as one.
    in_omega = formula(key, given)
    if in_omega is not None and in_omega.has(omega):
        return in_omega, None
    given = given if in_omega is None else in_omega
    try:
        read = ranged(given, Dimension.RATIO)
        value = require_number(given, read.nominal).value
    except SceneError as error:
        if isinstance(given, str) and _NAMES_SOMETHING.search(given):
            valid = "write a number, a percentage, or a formula in omega (rad/s)"
            raise SceneError(f'{key}: "{given[:60]}": {valid}, as "0.08 + 0.004*omega"') from None
        raise error.within(key) from None
    if any(sign_of_number(x) <= 0 for x in (value, *(read.interval or ()))):
        raise SceneError(f'{key}: "{given}" must be > 0')
    return value, read.interval


_NAMES_OMEGA = re.compile(r"(?<!\w)omega(?!\w)")
_NAMES_SOMETHING = re.compile(r"[A-Za-z_ω]\w*\s*[-+*/^(]|[-+*/^(]\s*[A-Za-z_ω]")
"""Text that reads as a formula, though not one in omega."""


def formula(key: str, given: object) -> Expr | None:
    """A rational formula in omega; None for what does not name it. SceneError, with the key, where
    it is not rational.

    >>> formula("real", "0.08 + 0.004*omega"), formula("real", "10 %")
    (omega/250 + 2/25, None)
    """
    if isinstance(given, Expr) and {x.name for x in given.free_symbols} == {omega.name}:
        value: Expr = given.xreplace(dict.fromkeys(given.free_symbols, omega))
    elif isinstance(given, str) and _NAMES_OMEGA.search(given):
        with within(key):
            value = evaluate(given, number=decimal, name={omega.name: omega, "pi": pi}.__getitem__)
    else:
        return None
    # Converted only to see that it is rational: roots, powers and unknown functions fail here.
    try:
        Ring().axis.convert(value)
    except SceneError:
        raise SceneError(
            f'{key}: "{given}" is not a rational formula: use numbers, pi, omega, + - * / '
            f"and whole powers"
        ) from None
    return value


_KEYS = {
    Shape.SQUARE: ("real", "imag", "floor"),
    Shape.ELLIPSE: ("real", "imag", "tilt"),
    Shape.DIAMOND: ("real", "imag"),
    Shape.POLYGON: ("corners",),
}
_OPTIONAL = ("shape", "floor", "tilt")
_ANY = ("shape", "scale", "proportion", "confidence")


def read_threshold(given: Any) -> Threshold:
    """A threshold as a scene file gives it. SceneError names key and rule.

    A table may have a ``scale``, a range: how many times the whole region is as large.

    >>> read_threshold({"shape": "diamond", "real": 0.1, "imag": "12 %"}).row()
    {'real': '1/10', 'imag': '3/25', 'shape': 'diamond'}
    """
    if not isinstance(given, Mapping):
        return Threshold.of(given)
    if "confidence" in given:
        read = read_threshold({key: x for key, x in given.items() if key != "confidence"})
        return replace(read, confidence=read_confidence("confidence", given["confidence"]))
    if "like" in given:
        for key in given:
            if key != "like":
                raise SceneError(
                    f'unknown key "{str(key)[:60]}": "like" takes no other key: leave it out'
                )
        return Threshold.like(given["like"])
    if "scale" in given:
        scale, interval = threshold_value("scale", given["scale"])
        if not interval:
            raise SceneError('scale: give a range, as "1 +- 20 %" or [0.8, 1.2]')
        read = _table({key: x for key, x in given.items() if key != "scale"})
        if read.ranges:
            raise SceneError("scale: leave out the other ranges of the JND")
        # All numbers are kept at the nominal scale; ``size`` remembers it, so that an end of the
        # range can be reached by a quotient.
        large = read.scaled(scale)
        return replace(
            large, region=replace(large.region, ranges=(("scale", interval),), size=scale)
        )
    return _table(given)


def _table(given: Mapping[str, Any]) -> Threshold:
    """Read a table that gives the region by its numbers, without ``like``, ``scale`` and
    ``confidence``."""
    shape = _shape(given.get("shape", "square"))
    keys = _KEYS[shape]
    for key in given:
        if key not in (*keys, *_ANY):
            owners = [x.value for x, own in _KEYS.items() if key in own]
            hint = (
                f"it is for shape = {' or '.join(map(quoted, owners))}; "
                if owners
                else meant(str(key), keys)
            )
            what = "" if shape is Shape.SQUARE else f" of a {shape.value}"
            raise SceneError(
                f'unknown key "{str(key)[:60]}"{what}: {hint}valid are '
                f"{', '.join(('shape', *keys, *_ANY[1:]))}"
            )
    missing = [key for key in keys if key not in given and key not in _OPTIONAL]
    if missing:
        raise SceneError("give both real and imag" if "real" in keys else "corners is missing")
    proportion = (
        read_proportion("proportion", given["proportion"]) if "proportion" in given else None
    )
    if shape is Shape.POLYGON:
        region = RegionDetails(shape, corners=_corners(given["corners"]))
        return Threshold(Integer(1), Integer(1), region=region, proportion=proportion)
    real, imag = (
        _sided(key, given[key], allowed=shape is Shape.SQUARE) for key in ("real", "imag")
    )
    floor, motion, lowest = _floor(given["floor"]) if "floor" in given else (None, None, None)
    tilt = _number("tilt", given["tilt"]) if "tilt" in given else Integer(0)
    named = {"real.lower": real[2], "imag.lower": imag[2], "floor": lowest}
    ranges = tuple((name, x) for name, x in named.items() if x)
    region = RegionDetails(shape, tilt, (), (real[1], imag[1]), floor, motion, ranges)
    return Threshold(real[0], imag[0], region=region, proportion=proportion)


def _shape(given: Any) -> Shape:
    """The shape of that name."""
    valid = [x.value for x in Shape]
    if given not in valid:
        shown = str(given)[:60]
        raise SceneError(
            f'shape: unknown shape "{shown}": {meant(shown, valid)}valid are {", ".join(valid)}'
        )
    return Shape(given)


def _sided(key: str, given: Any, *, allowed: bool) -> tuple[Any, Expr | None, ExactRange | None]:
    """A limit, and that for changes which make the part smaller where it is given apart, with its
    range."""
    if not isinstance(given, Mapping):
        return given, None, None
    if not allowed:
        raise SceneError(f"{key}: only a square has limits for higher and lower")
    if set(given) != {"higher", "lower"}:
        raise SceneError(f"{key}: give a number, or both higher and lower")
    threshold_value(f"{key}: higher", given["higher"])
    return given["higher"], *threshold_value(f"{key}: lower", given["lower"])


def _floor(given: Any) -> tuple[Expr, MotionKind | None, ExactRange | None]:
    """The least change that is noticed, N/m or N m/rad, and its range."""
    in_omega = formula("floor", given)
    if in_omega is not None and in_omega.has(omega):
        return in_omega, None, None
    given = given if in_omega is None else in_omega
    with within("floor"):
        read = ranged(given, Dimension.STIFFNESS)
        value = require_number(given, read.nominal).value
    if any(sign_of_number(x) <= 0 for x in (value, *(read.interval or ()))):
        raise SceneError(f'floor: "{given}" must be > 0')
    return value, read.nominal.motion, read.interval


def _number(key: str, given: Any) -> Expr:
    """A number of any sign, or a formula."""
    in_omega = formula(key, given)
    if in_omega is not None:
        return in_omega
    with within(key):
        return number(given, Dimension.RATIO).value


def _corners(given: Any) -> tuple[Corner, ...]:
    """Read the corners, and turn them round where they go clockwise at omega = 1 rad/s."""
    if (
        not isinstance(given, Sequence)
        or isinstance(given, str)
        or not 3 <= len(given) <= MOST_CORNERS
    ):
        raise SceneError(f"corners: give a list of 3 to {MOST_CORNERS} pairs [x, y]")
    corners: list[Corner] = []
    for i, pair in enumerate(given, 1):
        if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
            raise SceneError(f"corners: {i}: give a pair [x, y]")
        corners.append((_number(f"corners: {i}", pair[0]), _number(f"corners: {i}", pair[1])))
    clockwise = sign_of_number(turning(corners, Integer(1))) < 0
    return tuple(reversed(corners)) if clockwise else tuple(corners)
