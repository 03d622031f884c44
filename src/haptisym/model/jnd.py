"""The just-noticeable difference: how large a change of the dynamics must be for a person to notice it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

from sympy import Expr, Integer, Rational, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.shown import Viewed
from haptisym.kernel.symbols import omega
from haptisym.model import expressions
from haptisym.model.proportions import Conversion, read_proportion
from haptisym.model.published import like
from haptisym.model.quantities import Dimension, MotionKind, Number, decimal, require_number
from haptisym.model.ranges import ExactRange, ranged
from haptisym.model.regions import SQUARE, Region, Shape, positive


class Part(Enum):
    """Real part (stiffness and mass) or imaginary part (damping) of a dynamics."""

    __hash__ = object.__hash__  # members are singletons; the hash by name is slow, and charts look up much

    REAL = "real"
    IMAG = "imag"


@dataclass(frozen=True, slots=True)
class Threshold(Viewed):
    """The JND c of eq. (4): a change of Re H or Im H is noticed when it exceeds that fraction of ``|H|``.

    Each a number > 0: rational, rational in pi, or algebraic as a SymPy expression (for scenes whose numbers are rational); or a
    rational formula in omega, as a string. ``region`` : what it is besides, where it is not the paper's square.
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
    region: Region = SQUARE
    proportion: Expr | None = field(default=None, repr=False)
    conversion: Conversion | None = field(default=None, repr=False)
    """At which proportion of right answers it holds, if that is told, and how it was brought there, if it was."""
    confidence: Expr | None = field(default=None, repr=False)
    """Of the interval that its ranges are, where they were estimated."""

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
        if self.region.tilt and self.ranges and not ("scale" in self.ranges or self.is_scaled):
            raise SceneError(f"{_TILTED}: give both half widths one range, or a scale")
        if "scale" in self.ranges and len(self.ranges) > 1:
            raise SceneError("a scale has a range where no other number of the JND has one")

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
    def is_constant(self) -> bool:
        """Whether no number depends on the frequency."""
        region = self.region
        numbers = (self.real, self.imag, region.tilt, *region.numbers.values(), *(x for p in region.corners for x in p))
        return not any(x.has(omega) for x in numbers)

    @property
    def is_plain(self) -> bool:
        """Whether it is the paper's: a number for each part."""
        return self.region == SQUARE and self.is_constant

    @property
    def is_scaled(self) -> bool:
        """Whether its half widths are one number, in a region that holds all smaller ones of its kind."""
        alike = self.real == self.imag and self.real_interval == self.imag_interval
        return alike and self.region.shape in _SCALED and not self.region.ranges

    @property
    def ranges(self) -> dict[str, ExactRange]:
        """What may lie in a range, by its name: ``real``, ``imag``, and what the region has."""
        named = {"real": self.real_interval, "imag": self.imag_interval, **dict(self.region.ranges)}
        return {name: x for name, x in named.items() if x}

    @property
    def is_box(self) -> bool:
        """Whether its ranges, if it has any, are those of numbers that a box of parameters can hold."""
        return not self.ranges or self.is_plain or self.is_scaled

    @property
    def kind(self) -> str:
        """What it is, in words: ``an ellipse``."""
        region = self.region
        if region.shape is not Shape.SQUARE:
            return f"{'an' if region.shape is Shape.ELLIPSE else 'a'} {region.shape.value}"
        if region.floor is not None:
            return "a square with a floor"
        if region.lower != (None, None):
            return "a square with limits for higher and lower"
        return "a square" if self.real == self.imag else "a rectangle"

    def need_plain(self, question: str) -> None:
        """SceneError, in a sentence, unless it is the paper's: for what is defined, or answered, for that alone."""
        if not self.is_plain:
            own = self.kind if self.is_constant else f"{self.kind} that depends on omega"
            raise SceneError(f"{question}: the JND is {own}; this is answered for one number for each part alone")

    def check(self, low: Expr, high: Expr, motion: MotionKind | None) -> None:
        """SceneError unless it makes a region at every frequency of a band, for a scene of that motion."""
        try:
            self.region.check(low, high)
            for key, x in {"real": self.real, "imag": self.imag, **self.region.numbers}.items():
                if x.has(omega) and not positive(x, low, high):
                    raise SceneError(f"{key}: {x} must be > 0 on the whole band")
        except SceneError as error:
            raise error.within("jnd") from None
        if self.region.motion and motion and self.region.motion is not motion:
            raise SceneError(f"jnd: floor: is {self.region.motion.value}, but the scene is {motion.value}")

    def with_limits(self, limits: Mapping[Part, Number]) -> Threshold:
        """The same with other thresholds (in place of ranges, formulas and limits for each way, too) for some parts."""
        if limits and self.region.shape is Shape.POLYGON:
            raise SceneError("jnd: a polygon is given by its corners: it has no limit for one part")
        given = {part: (limits[part], None) if part in limits else (self[part], self.interval(part)) for part in Part}
        (real, real_interval), (imag, imag_interval) = given.values()
        below = [None if part in limits else self.lower(part) for part in Part]
        gone = {f"{part.value}.lower" for part in limits}
        ranges = tuple((name, x) for name, x in self.region.ranges if name not in gone)
        region = replace(self.region, lower=(below[0], below[1]), ranges=ranges)
        return Threshold(
            real, imag, real_interval, imag_interval, "" if limits else self.source, region, self.proportion
        )

    def scaled(self, c: Expr) -> Threshold:
        """That many times as large, with no ranges."""
        region = replace(self.region, ranges=(), size=Integer(1)).scaled(c)
        widths = (self.real, self.imag) if region.corners else (self.real * c, self.imag * c)
        return Threshold(*widths, region=region, proportion=self.proportion)

    def at_end(self, end: int) -> Threshold:
        """The smallest (0) or the largest (1) one of its ranges: the region grows with each of them."""
        at = {name: interval[end] for name, interval in self.ranges.items()}
        if "scale" in at:
            return self.scaled(at["scale"] / self.region.size)
        below = [at.get(f"{part.value}.lower", self.lower(part)) for part in Part]
        region = replace(self.region, lower=(below[0], below[1]), floor=at.get("floor", self.region.floor), ranges=())
        return Threshold(at.get("real", self.real), at.get("imag", self.imag), region=region)

    def at_proportion(self, end: Number) -> Threshold:
        """The same at another proportion of right answers, by a cumulative Gaussian; SceneError where its own is not told."""
        to = read_proportion("proportion", end)
        start = self.proportion or (like(self.source).criterion if self.source else None)
        if start is None:
            raise SceneError("proportion: the JND does not tell its own: add proportion = 0.75, say, to its table")
        found = Conversion(read_proportion("proportion", start), to)
        c = found.factor
        real, imag = (x and (x[0] * c, x[1] * c) for x in (self.real_interval, self.imag_interval))
        region, own = self.region.scaled(c), self.region.shape is not Shape.POLYGON
        widths = (self.real * c, self.imag * c) if own else (self.real, self.imag)
        return Threshold(*widths, real, imag, self.source, region, to, found)

    def row(self) -> dict[str, Any]:
        """As documents have it: the half widths, and what else the region is."""
        found = self.region
        taken: dict[str, Any] = {} if self.proportion is None else {"proportion": float(self.proportion)}
        taken |= {"conversion": self.conversion.row()} if self.conversion else {}
        if found.shape is Shape.POLYGON:
            return {"shape": found.shape.value, "corners": [[str(x), str(y)] for x, y in found.corners]} | taken
        row: dict[str, Any] = {"real": str(self.real), "imag": str(self.imag)}
        row |= {} if found.shape is Shape.SQUARE else {"shape": found.shape.value}
        row |= {"tilt": str(found.tilt)} if found.tilt else {}
        lower = {part.value: str(x) for part in Part if (x := self.lower(part)) is not None}
        return row | ({"lower": lower} if lower else {}) | ({"floor": str(found.floor)} if found.floor else {}) | taken

    def interval(self, part: Part) -> ExactRange | None:
        """The range of a part's threshold, if it has one."""
        return self.real_interval if part is Part.REAL else self.imag_interval


_SCALED = (Shape.ELLIPSE, Shape.DIAMOND)
_TILTED = "a tilted ellipse of which one half width is larger need not hold one of which it is smaller"


def threshold_value(key: str, given: Number) -> tuple[Expr, ExactRange | None]:
    """A threshold and its range, if it has one; SceneError, with the key, unless both are > 0."""
    if isinstance(given, Expr) and is_irrational_algebraic(given) and given.evalf() > 0:
        return given, None
    found_formula = formula(key, given)
    if found_formula is not None and found_formula.has(omega):
        return found_formula, None
    given = given if found_formula is None else found_formula
    try:
        found = ranged(given, Dimension.RATIO)
        value = require_number(given, found.nominal).value
    except SceneError as error:
        if isinstance(given, str) and _NAMES_SOMETHING.search(given):
            told = "a threshold is a number, a percentage, or a formula in omega (rad/s) and nothing else"
            raise SceneError(f'{key}: "{given[:60]}": {told}, as "0.08 + 0.004*omega"') from None
        raise error.within(key) from None
    if any(sign_of_number(x) <= 0 for x in (value, *(found.interval or ()))):
        raise SceneError(f'{key}: "{given}" must be > 0')
    return value, found.interval


_NAMES_OMEGA = re.compile(r"(?<!\w)omega(?!\w)")
_NAMES_SOMETHING = re.compile(r"[A-Za-z_ω]\w*\s*[-+*/^(]|[-+*/^(]\s*[A-Za-z_ω]")
"""What reads as a formula, though not in omega."""


def formula(key: str, given: object) -> Expr | None:
    """A rational formula in omega; None for what does not name it. SceneError, with the key, where it is not rational.

    >>> formula("real", "0.08 + 0.004*omega"), formula("real", "10 %")
    (omega/250 + 2/25, None)
    """
    if isinstance(given, Expr) and {x.name for x in given.free_symbols} == {omega.name}:
        value: Expr = given.xreplace(dict.fromkeys(given.free_symbols, omega))
    elif isinstance(given, str) and _NAMES_OMEGA.search(given):
        try:
            value = expressions.evaluate(given, number=decimal, name={omega.name: omega, "pi": pi}.__getitem__)
        except SceneError as error:
            raise error.within(key) from None
    else:
        return None
    try:
        Ring().axis.convert(value)
    except SceneError:
        raise SceneError(
            f'{key}: "{given}" is no rational formula in omega: numbers, pi, omega, + - * / and whole powers'
        ) from None
    return value


def is_irrational_algebraic(value: Expr) -> bool:
    """Whether a number is real and algebraic, but not rational."""
    return bool(value.is_number and not value.is_Rational and value.is_algebraic and value.is_real)
