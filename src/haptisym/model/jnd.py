"""The just-noticeable difference: how large a change of the dynamics must be for a person to notice
it.

A threshold is a region in the plane of x = Re dH/|H_env| and y = Im dH/|H_env|: the paper's square,
or an ellipse, a diamond, a polygon; each number exact, or a rational formula in omega; read from
``jnd = ...``, a number, a formula or a table.

Published thresholds go by name, each with the criterion at which it was taken. A change of size x
is told with the probability Phi(x/sigma), so that the change told with probability p is z(p) sigma,
z the inverse of Phi: thresholds at two proportions are to each other as their z. The quotient is
transcendental; it is rounded to a decimal number of DIGITS digits, each proven, so that everything
that follows is exact for that number.
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
        """In per cent."""
        low, high = (f"{float(100 * x):.4g}" for x in (self.low, self.high))
        return f"{low} %" if low == high else f"{low} to {high} %"

    @property
    def given(self) -> Expr | ExactRange:
        """As a threshold is given: a number, or the pair of its ends."""
        return self.low if self.low == self.high else (self.low, self.high)


@cache
def published_by_name() -> Mapping[str, Published]:
    """All of them, in the order of the shipped table."""
    table = tomllib.loads(
        (files("haptisym") / "data" / "published.toml").read_text(encoding="utf-8")
    )
    return {name: _read_published(name, row) for name, row in table.items()}


def _read_published(name: str, row: Mapping[str, Any]) -> Published:
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
    """The one of that name, fit for a scene; SceneError for any other name, and where it is not
    one."""
    known = published_by_name()
    if not isinstance(name, str) or name not in known:
        shown = str(name)[:60]
        raise SceneError(
            f'like: unknown published threshold "{shown}": {meant(shown, known)}valid are '
            f"{', '.join(known)}"
        )
    found = known[name]
    if found.apart:
        raise SceneError(f'like: "{name}" is no threshold for a scene: {found.apart}')
    return found


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
        with flint.ctx.workprec(bits + 16):
            one, other = (2 * expression_ball(x) - arb(1) for x in (self.start, self.end))
            return other.erfinv() / one.erfinv()


@dataclass(frozen=True)
class Conversion:
    """From one proportion of right answers to another: times ``factor``, which is ``exact`` rounded
    to DIGITS digits."""

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
        """As documents have it."""
        shown = {
            "factor": self.exact.digits(DIGITS),
            "enclosure": list(self.exact.enclosure(DIGITS)),
        }
        return {"from": float(self.start), "to": float(self.end), **shown}


def read_proportion(key: str, given: Number) -> Expr:
    """A proportion of right answers, above one half and below 1; SceneError for any other."""
    with within(key):
        value = number(given, Dimension.RATIO).value
    if not value.is_Rational or not Rational(1, 2) < value < 1:
        raise SceneError(f'{key}: "{given}" must be rational, above 0.5 and below 1')
    return value


Corner: TypeAlias = tuple[Expr, Expr]
MOST_CORNERS = 24


class Shape(Enum):
    """Of the region. A further one that has corners is a row here and in ``_KEYS`` and
    ``_CORNERS``: nothing else names it."""

    SQUARE = "square"
    ELLIPSE = "ellipse"
    DIAMOND = "diamond"
    POLYGON = "polygon"

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Counterclockwise, in half widths, where the shape alone tells them."""
        return _CORNERS.get(self, ())

    @property
    def words(self) -> str:
        """With its article: ``an ellipse``."""
        return f"{'an' if self.value[0] in 'aeio' else 'a'} {self.value}"


_CORNERS: Mapping[Shape, tuple[Corner, ...]] = {
    Shape.DIAMOND: tuple((Integer(x), Integer(y)) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)))
}


@dataclass(frozen=True, slots=True)
class RegionDetails:
    """What a region is besides its half widths; each number exact, or a rational formula in omega.

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
        """What must be positive besides the half widths, by name."""
        named = {"real: lower": self.lower[0], "imag: lower": self.lower[1], "floor": self.floor}
        return {name: x for name, x in named.items() if x is not None}

    def scaled(self, c: Expr) -> RegionDetails:
        """That many times as large."""
        corners = tuple((x * c, y * c) for x, y in self.corners)
        one, other = (None if x is None else x * c for x in self.lower)
        floor = None if self.floor is None else self.floor * c
        ranges = tuple(
            (key, x if key == "scale" else (x[0] * c, x[1] * c)) for key, x in self.ranges
        )
        return replace(self, corners=corners, lower=(one, other), floor=floor, ranges=ranges)

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
    table = chart({"": RealFunction(Ring().axis.convert(value).reduced())}, low, high)
    return all(point.at[""] > 0 and point.orders.get("", 0) >= 0 for point in table.points)


def turning(corners: Sequence[Corner], at: Expr) -> Expr:
    """Twice the area of a polygon at a frequency: positive where its corners go
    counterclockwise."""
    area = sum((_cross(p, q) for p, q in _edges(corners)), Integer(0))
    found: Expr = area.subs(omega, at)
    return found


def _check_polygon(corners: Sequence[Corner], low: Expr, high: Expr) -> None:
    """SceneError unless corners go once around 0, convex, at every frequency of a band."""
    everywhere = _everywhere(x for corner in corners for x in corner)
    for (i, p), (j, q) in combinations(enumerate(corners, 1), 2):
        if not positive((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2, low, high):
            where = " at some frequency" if everywhere else ""
            raise SceneError(f"corners: {i} and {j} are the same point, [{p[0]}, {p[1]}]{where}")
    if (
        not all(positive(_cross(p, q), low, high) for p, q in _edges(corners))
        or _turns(corners, low, high) != 1
    ):
        order = "0 must be inside, not on an edge, and the corners in order around it"
        raise SceneError(f"corners: {_written(corners)}: {order}{everywhere}")
    steps = [(q[0] - p[0], q[1] - p[1]) for p, q in _edges(corners)]
    if not all(positive(_cross(p, q), low, high) for p, q in _edges(steps)):
        convex = "the polygon must be convex, without corners on a straight edge"
        raise SceneError(f"corners: {_written(corners)}: {convex}{everywhere}")


def _written(corners: Sequence[Corner]) -> str:
    """``[[1/10, 0], [0, 1/10], ...]``: the first ones."""
    more = ", ..." if len(corners) > _TOLD else ""
    return f"[{', '.join(f'[{x}, {y}]' for x, y in corners[:_TOLD])}{more}]"


_TOLD = 5


def _everywhere(values: Iterable[Expr]) -> str:
    return " on the whole band" if any(x.has(omega) for x in values) else ""


def _edges(corners: Sequence[Corner]) -> list[tuple[Corner, Corner]]:
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _cross(p: Corner, q: Corner) -> Expr:
    return (p[0] * q[1] - p[1] * q[0]).expand()


def _turns(corners: Sequence[Corner], low: Expr, high: Expr) -> int:
    """How often corners, each to the left of the one before, go around 0: how often they come up
    over the axis of x."""
    heights = [sign_of_number(y.subs(omega, (low + high) / 2)) for _, y in corners]
    return sum(a < 0 <= b for a, b in zip(heights, [*heights[1:], heights[0]], strict=True))


class Part(Enum):
    """Real part (stiffness and mass) or imaginary part (damping) of a dynamics."""

    __hash__ = (
        object.__hash__
    )  # members are singletons; the hash by name is slow, and charts look up much

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
        if self.region.tilt and self.ranges and not ("scale" in self.ranges or self.is_scaled):
            raise SceneError(f"{_TILTED}: give both the same range, or a scale")
        if "scale" in self.ranges and len(self.ranges) > 1:
            raise SceneError("scale: leave out the other ranges of the JND")

    def __repr__(self) -> str:
        own = "" if self.region == SQUARE else f", region={self.region!r}"
        return f"Threshold(real={self.real}, imag={self.imag}{own})"

    def __getitem__(self, part: Part) -> Expr:
        return {Part.REAL: self.real, Part.IMAG: self.imag}[part]

    __iter__ = None  # its parts are named, not counted

    def lower(self, part: Part) -> Expr | None:
        """The limit for changes that make a part smaller, where that is another one."""
        return self.region.lower[0 if part is Part.REAL else 1]

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Of a region that has corners and judges both parts at once, counterclockwise; of any
        other none."""
        return self.region.corners or tuple(
            (x * self.real, y * self.imag) for x, y in self.region.shape.corners
        )

    @property
    def is_constant(self) -> bool:
        """Whether no number depends on the frequency."""
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
        """Whether it is the paper's: a number for each part."""
        return self.region == SQUARE and self.is_constant

    @property
    def is_scaled(self) -> bool:
        """Whether its half widths are one number, in a region that holds all smaller ones of its
        kind."""
        alike = self.real == self.imag and self.real_interval == self.imag_interval
        judges_both = self.region.shape is not Shape.SQUARE and not self.region.corners
        return alike and judges_both and not self.region.ranges

    @property
    def ranges(self) -> dict[str, ExactRange]:
        """What may lie in a range, by its name: ``real``, ``imag``, and what the region has."""
        named = {"real": self.real_interval, "imag": self.imag_interval, **dict(self.region.ranges)}
        return {name: x for name, x in named.items() if x}

    @property
    def is_box(self) -> bool:
        """Whether its ranges, if it has any, are those of numbers that a box of parameters can
        hold."""
        return not self.ranges or self.is_plain or self.is_scaled

    @property
    def kind(self) -> str:
        """What it is, in words: ``an ellipse``."""
        region = self.region
        if region.shape is not Shape.SQUARE:
            return region.shape.words
        if region.floor is not None:
            return "a square with a floor"
        if region.lower != (None, None):
            return "a square with limits for higher and lower"
        return "a square" if self.real == self.imag else "a rectangle"

    def need_plain(self, question: str) -> None:
        """SceneError, in a sentence, unless it is the paper's: for what is defined, or answered,
        for that alone."""
        if not self.is_plain:
            own = self.kind if self.is_constant else f"{self.kind} that depends on omega"
            raise SceneError(
                f"{question}: the JND is {own}; give one number for each part, as jnd = 0.1"
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
        """The same with other thresholds (in place of ranges, formulas and limits for each way,
        too) for some parts."""
        if limits and self.region.shape is Shape.POLYGON:
            raise SceneError("jnd: a polygon has no limit for one part: change its corners")
        given = {
            part: (limits[part], None) if part in limits else (self[part], self.interval(part))
            for part in Part
        }
        (real, real_interval), (imag, imag_interval) = given.values()
        below = [None if part in limits else self.lower(part) for part in Part]
        gone = {f"{part.value}.lower" for part in limits}
        ranges = tuple((name, x) for name, x in self.region.ranges if name not in gone)
        region = replace(self.region, lower=(below[0], below[1]), ranges=ranges)
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
        """That many times as large, with no ranges."""
        region = replace(self.region, ranges=(), size=Integer(1)).scaled(c)
        widths = (self.real, self.imag) if region.corners else (self.real * c, self.imag * c)
        return Threshold(*widths, region=region, proportion=self.proportion)

    def at_end(self, end: int) -> Threshold:
        """The smallest (0) or the largest (1) one of its ranges: the region grows with each of
        them."""
        at = {name: interval[end] for name, interval in self.ranges.items()}
        if "scale" in at:
            return self.scaled(at["scale"] / self.region.size)
        below = [at.get(f"{part.value}.lower", self.lower(part)) for part in Part]
        region = replace(
            self.region,
            lower=(below[0], below[1]),
            floor=at.get("floor", self.region.floor),
            ranges=(),
        )
        return Threshold(at.get("real", self.real), at.get("imag", self.imag), region=region)

    def at_proportion(self, end: Number) -> Threshold:
        """The same at another proportion of right answers, by a cumulative Gaussian; SceneError
        where its own is not told."""
        to = read_proportion("proportion", end)
        start = self.proportion or (like(self.source).criterion if self.source else None)
        if start is None:
            raise SceneError(
                "proportion: the JND has none of its own: add one to its table, as "
                "proportion = 0.75"
            )
        found = Conversion(read_proportion("proportion", start), to)
        c = found.factor
        real, imag = (x and (x[0] * c, x[1] * c) for x in (self.real_interval, self.imag_interval))
        region, own = self.region.scaled(c), self.region.shape is not Shape.POLYGON
        widths = (self.real * c, self.imag * c) if own else (self.real, self.imag)
        return Threshold(*widths, real, imag, self.source, region, to, found)

    def row(self) -> dict[str, Any]:
        """As documents have it: the half widths, and what else the region is."""
        found = self.region
        taken: dict[str, Any] = (
            {} if self.proportion is None else {"proportion": float(self.proportion)}
        )
        taken |= {"conversion": self.conversion.row()} if self.conversion else {}
        if found.shape is Shape.POLYGON:
            return {
                "shape": found.shape.value,
                "corners": [[str(x), str(y)] for x, y in found.corners],
            } | taken
        row: dict[str, Any] = {"real": str(self.real), "imag": str(self.imag)}
        row |= {} if found.shape is Shape.SQUARE else {"shape": found.shape.value}
        row |= {"tilt": str(found.tilt)} if found.tilt else {}
        lower = {part.value: str(x) for part in Part if (x := self.lower(part)) is not None}
        return (
            row
            | ({"lower": lower} if lower else {})
            | ({"floor": str(found.floor)} if found.floor else {})
            | taken
        )

    def interval(self, part: Part) -> ExactRange | None:
        """The range of a part's threshold, if it has one."""
        return self.real_interval if part is Part.REAL else self.imag_interval


_TILTED = "separate ranges of the half widths of a tilted ellipse are not supported"


def threshold_value(key: str, given: Number) -> tuple[Expr, ExactRange | None]:
    """A threshold and its range, if it has one; SceneError, with the key, unless both are > 0."""
    found_formula = formula(key, given)
    if found_formula is not None and found_formula.has(omega):
        return found_formula, None
    given = given if found_formula is None else found_formula
    try:
        found = ranged(given, Dimension.RATIO)
        value = require_number(given, found.nominal).value
    except SceneError as error:
        if isinstance(given, str) and _NAMES_SOMETHING.search(given):
            valid = "write a number, a percentage, or a formula in omega (rad/s)"
            raise SceneError(f'{key}: "{given[:60]}": {valid}, as "0.08 + 0.004*omega"') from None
        raise error.within(key) from None
    if any(sign_of_number(x) <= 0 for x in (value, *(found.interval or ()))):
        raise SceneError(f'{key}: "{given}" must be > 0')
    return value, found.interval


_NAMES_OMEGA = re.compile(r"(?<!\w)omega(?!\w)")
_NAMES_SOMETHING = re.compile(r"[A-Za-z_ω]\w*\s*[-+*/^(]|[-+*/^(]\s*[A-Za-z_ω]")
"""What reads as a formula, though not in omega."""


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
        found = read_threshold({key: x for key, x in given.items() if key != "confidence"})
        return replace(found, confidence=read_confidence("confidence", given["confidence"]))
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
        found = _table({key: x for key, x in given.items() if key != "scale"})
        if found.ranges:
            raise SceneError("scale: leave out the other ranges of the JND")
        large = found.scaled(scale)
        return replace(
            large, region=replace(large.region, ranges=(("scale", interval),), size=scale)
        )
    return _table(given)


def _table(given: Mapping[str, Any]) -> Threshold:
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
    taken = read_proportion("proportion", given["proportion"]) if "proportion" in given else None
    if shape is Shape.POLYGON:
        region = RegionDetails(shape, corners=_corners(given["corners"]))
        return Threshold(Integer(1), Integer(1), region=region, proportion=taken)
    real, imag = (
        _sided(key, given[key], allowed=shape is Shape.SQUARE) for key in ("real", "imag")
    )
    floor, motion, lowest = _floor(given["floor"]) if "floor" in given else (None, None, None)
    tilt = _number("tilt", given["tilt"]) if "tilt" in given else Integer(0)
    named = {"real.lower": real[2], "imag.lower": imag[2], "floor": lowest}
    ranges = tuple((name, x) for name, x in named.items() if x)
    region = RegionDetails(shape, tilt, (), (real[1], imag[1]), floor, motion, ranges)
    return Threshold(real[0], imag[0], region=region, proportion=taken)


def _shape(given: Any) -> Shape:
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
    found = formula("floor", given)
    if found is not None and found.has(omega):
        return found, None, None
    with within("floor"):
        read = ranged(given, Dimension.STIFFNESS)
        value = require_number(given, read.nominal).value
    if any(sign_of_number(x) <= 0 for x in (value, *(read.interval or ()))):
        raise SceneError(f'floor: "{given}" must be > 0')
    return value, read.nominal.motion, read.interval


def _number(key: str, given: Any) -> Expr:
    """A number of any sign, or a formula."""
    found = formula(key, given)
    if found is not None:
        return found
    with within(key):
        return number(given, Dimension.RATIO).value


def _corners(given: Any) -> tuple[Corner, ...]:
    """The corners, counterclockwise at the middle of the paper's band."""
    if (
        not isinstance(given, Sequence)
        or isinstance(given, str)
        or not 3 <= len(given) <= MOST_CORNERS
    ):
        raise SceneError(f"corners: give a list of 3 to {MOST_CORNERS} pairs [x, y]")
    found: list[Corner] = []
    for i, pair in enumerate(given, 1):
        if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
            raise SceneError(f"corners: {i}: give a pair [x, y]")
        found.append((_number(f"corners: {i}", pair[0]), _number(f"corners: {i}", pair[1])))
    clockwise = sign_of_number(turning(found, Integer(1))) < 0
    return tuple(reversed(found)) if clockwise else tuple(found)
