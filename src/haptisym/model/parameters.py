"""A parameter of a model: its place in the signature, its rule, and how its value or range is read
from what was given.

The rule (what it measures, and which values it may have) is an annotation of the model's function,
a ``Slot``. Values are exact, in SI: a rational number times a power of pi, or a symbol. What is not
known exactly is ``"1.8 kg +- 5 %"``, ``"1.8 kg +- 0.1 kg"`` or a list of the lowest and the highest
value, with a third between them as the nominal one. Begin with ``Parameter`` and ``ranged``.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import chain, count
from typing import Annotated, Any, TypeAlias

from sympy import Expr, Integer, Symbol, nan, zoo

from haptisym.kernel.errors import SceneError, SignError, meant, quoted, within
from haptisym.kernel.objects import Shown
from haptisym.kernel.roots import sign_of_number
from haptisym.model.quantities import (
    Dimension,
    Exponents,
    MotionKind,
    Number,
    Quantity,
    Unit,
    decimal,
    dimension_exponents,
    expected,
    fits,
    implied_motion,
    number,
    quantity,
    si_unit,
)

ExactRange: TypeAlias = tuple[Expr, Expr]
"""The lowest and the highest value, exact, in SI."""

_PLUS_MINUS = re.compile(r"\+/?-|±")


@dataclass(frozen=True, slots=True)
class Ranged:
    """A quantity at its nominal value, and the interval in which it may lie; None if it has just
    that value."""

    nominal: Quantity
    interval: ExactRange | None = None


def ranged(given: Any, dimension: Dimension) -> Ranged:
    """Read a quantity or a range of it, exactly.

    ``given`` : whatever ``quantity`` reads; a string with ``+-`` (or a plus-minus sign) and a
    deviation, with a unit or in per cent of the centre; a pair of quantities, whose middle is the
    nominal value, or three: the lowest, the nominal, the highest.
    Raises SceneError for anything else.

    >>> ranged("1.8 kg +- 5 %", Dimension.MASS).interval, ranged(["1.7 kg", "1.9 kg"], Dimension.MASS).nominal.value
    ((171/100, 189/100), 9/5)
    >>> ranged("0 kg +- 5 %", Dimension.MASS)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: "0 kg +- 5 %": a percentage of zero is no range: give the deviation a unit
    """
    if isinstance(given, str) and _PLUS_MINUS.search(given):
        return _around(given, dimension)
    if isinstance(given, Sequence) and not isinstance(given, str):
        return _between(given, dimension)
    return Ranged(quantity(given, dimension))


def _around(text: str, dimension: Dimension) -> Ranged:
    """Read a range that is written as a centre and a deviation."""
    parts = _PLUS_MINUS.split(text)
    if len(parts) != 2 or not all(part.strip() for part in parts):
        raise SceneError(
            f'"{text[:60]}" is not a range: write it as "1.8 kg +- 5 %" or "1.8 kg +- 0.1 kg"'
        )
    centre = quantity(parts[0], dimension)
    deviation = _deviation(text, centre, parts[1].strip(), dimension)
    if sign_of_number(deviation) < 0:
        raise SceneError(f'"{text[:60]}": the deviation after +- must be >= 0')
    # A deviation of 0 is no range: the parameter has just that value.
    low, high = centre.value - deviation, centre.value + deviation
    return Ranged(centre, None if deviation == 0 else (low, high))


def _deviation(text: str, centre: Quantity, given: str, dimension: Dimension) -> Expr:
    """Read what stands behind +-, in SI: a share of the centre in per cent, or a quantity."""
    if given.endswith("%"):
        if centre.value == 0:
            raise SceneError(
                f'"{text[:60]}": a percentage of zero is no range: give the deviation a unit'
            )
        # "10 % +- 5 %" may mean 5 points or 5 % of 10 %: it is refused, with both written out.
        if _PLUS_MINUS.split(text)[0].rstrip().endswith("%"):
            raise SceneError(_two_readings(text, centre.value, decimal(given[:-1].strip()) / 100))
        # A share of the centre's absolute value, so that the lower end stays below the upper one.
        return centre.value * sign_of_number(centre.value) * decimal(given[:-1].strip()) / 100
    deviation = quantity(given, dimension)
    if deviation.exponents != centre.exponents:
        raise SceneError(
            f'"{text[:60]}": give value and deviation in units of the same kind, or the '
            f"deviation in per cent"
        )
    return deviation.value


def _two_readings(text: str, centre: Expr, deviation: Expr) -> str:
    """The error for a deviation in per cent of a value in per cent: both meanings, each as a list
    that has only that one."""
    ways = [
        ", ".join(f'"{float(100 * x):g} %"' for x in (centre - off, centre, centre + off))
        for off in (deviation, centre * deviation)
    ]
    return (
        f'"{text[:60]}" is ambiguous: write [{ways[0]}], or, if it is {float(100 * deviation):g} '
        f"% of it, [{ways[1]}]"
    )


def _between(given: Sequence[Any], dimension: Dimension) -> Ranged:
    """Read a range that is given by its two ends, and maybe a nominal value between them."""
    shown = f"[{', '.join(map(str, given))}]"[:60]
    if len(given) not in (2, 3):
        raise SceneError(
            f"{shown} is not a range: give the lowest and the highest value, or three "
            f"numbers with the nominal value between"
        )
    low, *between, high = (quantity(x, dimension) for x in given)
    if any(x.value.free_symbols for x in (low, *between, high)):
        raise SceneError(f"{shown} is not a range: its ends must be numbers")
    # Units may differ in size, as [900 g, 1.1 kg], but one bare number among them is refused: it
    # would be SI whatever the others are.
    if any(x.exponents != low.exponents for x in (*between, high)):
        raise SceneError(f"{shown}: both ends of a range must have units of the same kind")
    if sign_of_number(high.value - low.value) < 0:
        raise SceneError(f"{shown}: the lower end of a range must not be above the upper end")
    middle = (
        between[0]
        if between
        else Quantity((low.value + high.value) / 2, low.motion, low.exponents, low.unit)
    )
    if any(sign_of_number(x) < 0 for x in (middle.value - low.value, high.value - middle.value)):
        raise SceneError(f"{shown}: the nominal value must lie between the other two")
    return Ranged(middle, None if low.value == high.value else (low.value, high.value))


def spread(nominal: Expr, interval: ExactRange, unit: Unit | None = None) -> str:
    """How far a range goes, in words: by per cent of the nominal value where it lies in the middle,
    else from where to where in a unit.

    >>> from sympy import Rational
    >>> spread(Rational(9, 5), (Rational(171, 100), Rational(189, 100)))
    'by 5 %'
    """
    # Per cent would mislead where the range holds 0 or where the nominal value is not its middle.
    low, high = interval
    if (
        nominal == 0
        or sign_of_number(low) * sign_of_number(high) <= 0
        or nominal - low != high - nominal
    ):
        size, name = (unit.size, f" {unit.text}".rstrip()) if unit else (Integer(1), "")
        return f"from {float(low / size):.6g} to {float(high / size):.6g}{name}"
    return f"by {float(50 * (high - low) / (nominal * sign_of_number(nominal))):.4g} %"


def read_confidence(key: str, given: Any) -> Expr:
    """Read the confidence of estimated ranges: a number between 0 and 1, or "95 %".

    SceneError, with the key, for any other.

    >>> read_confidence("confidence", "95 %")
    19/20
    """
    with within(key):
        value = number(given, Dimension.RATIO).value
    if not value.is_Rational or not 0 < value < 1:
        raise SceneError(f'{key}: "{given}" must lie between 0 and 1, as 0.95')
    return value


class Rule(Enum):
    """The values that a parameter may have; the text is what an error says of it."""

    POSITIVE = "must be > 0"
    NONNEGATIVE = "must be >= 0"
    ANY = "may have any value"
    FRACTION = "must lie between 0 and 1"
    ORDER = "must be a whole number from 1 to 10"
    WHOLE = "must be a whole number from 0 to 100"

    def and_also(self, other: Rule) -> Rule:
        """The stricter one of two rules that one value keeps.

        >>> Rule.ANY.and_also(Rule.NONNEGATIVE).and_also(Rule.POSITIVE).name
        'POSITIVE'
        """
        return min(
            self,
            other,
            # From the strictest rule to none: of two rules that one value keeps, one implies the
            # other.
            key=[
                Rule.ORDER,
                Rule.WHOLE,
                Rule.FRACTION,
                Rule.POSITIVE,
                Rule.NONNEGATIVE,
                Rule.ANY,
            ].index,
        )

    def allows(self, value: Expr) -> bool:
        """Whether an exact number keeps the rule. A value with symbols does, except where a whole
        number is needed: what the symbols stand for is not known."""
        # An order or a number of samples shapes the formula itself: it cannot stay a symbol.
        if value.free_symbols:
            return self not in WHOLE_NUMBERS
        # Exact, for numbers with pi too.
        sign = sign_of_number(value)
        if self is Rule.POSITIVE:
            return sign > 0
        if self is Rule.NONNEGATIVE:
            return sign >= 0
        if self is Rule.FRACTION:
            return sign > 0 and sign_of_number(value - 1) < 0
        if self is Rule.ORDER:
            return bool(value.is_Integer) and 1 <= int(value) <= 10
        if self is Rule.WHOLE:
            return bool(value.is_Integer) and 0 <= int(value) <= 100
        return True


WHOLE_NUMBERS = (Rule.ORDER, Rule.WHOLE)
SIGNS = (Rule.POSITIVE, Rule.NONNEGATIVE)


@dataclass(frozen=True)
class Slot:
    """A place for a parameter in a model: what it measures, which values it may have, whether it is
    ``required``, one of ``several`` in a list, a formula, or one of some ``choices``."""

    dimension: Dimension
    rule: Rule = Rule.POSITIVE
    required: bool = True
    several: bool = False
    formula: bool = False
    """Whether it is a formula, in s or with ``in_z`` in z."""
    in_z: bool = False
    choices: tuple[str, ...] = ()

    @property
    def is_setting(self) -> bool:
        """Whether it takes a choice, a word or a whole number, and no number that may be varied."""
        return bool(self.choices) or self.rule in WHOLE_NUMBERS


NAMED = Slot(Dimension.ANY, Rule.ANY)
"""The place of a name in a formula: any dimension and any value."""


@dataclass(frozen=True, repr=False)
class Parameter(Shown):
    """A named number of a scene: its symbol in formulas and its exact value (SI; or a symbol that
    the user chose)."""

    symbol: Symbol
    value: Expr
    dimension: Dimension
    motion: MotionKind | None = None
    key: str = ""
    """Its name in the model, as a scene file writes it."""
    exponents: Exponents | None = None
    """Exponents of the base dimensions; None where no unit was given."""
    rule: Rule = Rule.ANY
    interval: ExactRange | None = None
    """Where the value may lie, if the scene gives a range; ``value`` is then the nominal one."""
    tie: str = ""
    """The environment's parameter that it is ("environment.k"), with its symbol, value and range;
    empty for one of its own."""
    written: Unit | None = field(default=None, compare=False)
    """The unit in which it was given, where that is no SI unit."""

    def _line(self) -> str:
        return self.stated()

    def unit_in(self, motion: MotionKind | None) -> str:
        """The SI unit of its dimension; where the model has none, that of the unit it was given in,
        and empty where it was given without one."""
        return self.dimension.unit(motion) or si_unit(self.exponents or ())

    def shown_unit(self, motion: MotionKind | None) -> Unit:
        """The unit in which pages print it: as it was written, else that of SI; without a name
        where none is known."""
        unit = self.unit_in(motion or MotionKind.TRANSLATION)
        return self.written or Unit("" if unit == "1" else unit)

    def stated(self) -> str:
        """The parameter as a text, ``m = 9/5 kg``, with its range if it has one."""
        si_unit_text = self.unit_in(self.motion or MotionKind.TRANSLATION)
        unit = "" if si_unit_text in ("", "1") or self.value == self.symbol else f" {si_unit_text}"
        spread = f", from {self.interval[0]} to {self.interval[1]}{unit}" if self.interval else ""
        return (
            f"{self.symbol} = {self.value}{unit}{spread}"
            if self.value != self.symbol
            else str(self.symbol)
        )

    def with_value(self, given: Number) -> Parameter:
        """The parameter with another value, in place of its range too; checked as the first one."""
        read = read_parameter(self.key, given, Slot(self.dimension, self.rule), self.symbol.name)
        # A bare number is in SI. What the unit before told of motion and dimension still holds, and
        # pages go on printing in that unit.
        if read.exponents is None:
            read = replace(read, motion=self.motion, exponents=self.exponents, written=self.written)
        return replace(read, symbol=self.symbol, tie=self.tie)

    def on_lever(self, length: Expr) -> Parameter:
        """The parameter of a motion along a line, at a distance from the axis of a rotation, m."""
        interval = self.interval and (self.interval[0] * length**2, self.interval[1] * length**2)
        return replace(
            self,
            value=self.value * length**2,
            motion=MotionKind.ROTATION,
            exponents=dimension_exponents(self.dimension, MotionKind.ROTATION),
            interval=interval,
            written=None,
        )


# A name with a dot, as environment.k. No quantity begins with a name, so that none is taken for it.
_REFERENCE = re.compile(r"\s*[^\W\d]\w*\.[\w.\[\]-]+\s*")


def enter_parameter(key: str, given: Number, slot: Slot, name: str) -> Parameter:
    """A parameter of a call: a quantity, a range, or a reference to one of the environment's, which
    waits for ``tied_to``."""
    if not isinstance(given, str) or not ("environment." in given or _REFERENCE.match(given)):
        return read_parameter(key, given, slot, name)
    if not _REFERENCE.fullmatch(given):
        raise SceneError(
            f'{key}: {quoted(given)}: write a reference alone, as {key} = "environment.{key}"'
        )
    symbol = _symbol(name, slot.rule)
    return Parameter(symbol, symbol, slot.dimension, key=key, rule=slot.rule, tie=given.strip())


def refuse_references(parameters: Iterable[Parameter]) -> None:
    """SceneError where a parameter refers to another and is not one of what is rendered."""
    for p in parameters:
        if p.tie:
            raise SceneError(f'{p.key}: "{p.tie}": only [rendered] can refer to another value')


def _symbol(name: str, rule: Rule) -> Symbol:
    """The symbol of a parameter, positive unless its rule allows any value; SceneError for a name
    that cannot be written in a formula."""
    if not name.isidentifier() or name in ("s", "omega", "pi", "j"):
        raise SceneError(
            f'"{name}" is no name for a parameter: use letters, digits and _, not s, omega, pi or j'
        )
    return Symbol(name, real=True) if rule is Rule.ANY else Symbol(name, positive=True)


def read_parameter(key: str, given: Number, slot: Slot, name: str) -> Parameter:
    """A parameter from a quantity or a range, checked; ``key`` is what errors call it, ``name`` its
    symbol's."""
    symbol = _symbol(name, slot.rule)
    with within(key):
        if slot.rule in WHOLE_NUMBERS and isinstance(given, str) and not given.strip().isdecimal():
            raise SceneError(f"{quoted(given)} {slot.rule.value}, without a unit")
        found = ranged(given, slot.dimension)
    read = found.nominal
    # A value may be a symbol of the user's; these three have a meaning in all closed forms.
    reserved = {x.name for x in read.value.free_symbols} & {"s", "omega", "X"}
    if reserved:
        raise SceneError(
            f"{key}: {quoted(given)} contains {min(reserved)}, which is reserved: give another name"
        )
    if found.interval and slot.rule in WHOLE_NUMBERS:
        raise SceneError(f"{key}: {quoted(given)} {slot.rule.value}, without a range")
    if not all(slot.rule.allows(x) for x in (read.value, *(found.interval or ()))):
        # A SignError carries what the message of an environment needs to offer a way out: the
        # bound, and whether the value is 0.
        error = (SignError if slot.rule in SIGNS else SceneError)(
            f"{key}: {quoted(given)} {slot.rule.value}"
        )
        if isinstance(error, SignError):
            error.zero = bool(read.value == 0)
            error.bound = (
                f"{key} {slot.rule.value.removeprefix('must be ')} (is {_shown(given, slot)})"
            )
        raise error
    return Parameter(
        symbol,
        read.value,
        slot.dimension,
        read.motion,
        key,
        read.exponents,
        slot.rule,
        found.interval,
        written=read.unit,
    )


def _shown(given: Any, slot: Slot) -> str:
    """A value as it was written; a bare number with the SI unit of translation."""
    unit = slot.dimension.unit(MotionKind.TRANSLATION)
    return str(given) if isinstance(given, str) or unit in ("", "1") else f"{given} {unit}"


def chosen(key: str, given: object, choices: Sequence[str]) -> str:
    """Return the word that is given; SceneError where it is none of the choices."""
    if given not in choices:
        raise SceneError(
            f"{key}: {quoted(given)} is unknown: {meant(str(given), choices)}valid are "
            f"{', '.join(choices)}"
        )
    return str(given)


def enter_list(key: str, given: Any, slot: Slot) -> list[Parameter]:
    """The entries of a list as parameters ``key[1]``, ``key[2]``, ..., with symbols ``key_1``,
    ``key_2``, ...; SceneError for an empty list and for one that is too long."""
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        raise SceneError(f"{key}: {quoted(given)}: give a list of quantities, as [100, 50]")
    if len(given) > MOST_BRANCHES:
        raise SceneError(f"{key}: at most {MOST_BRANCHES} entries, not {len(given)}")
    return [
        replace(enter_parameter(f"{key}[{i}]", x, slot, f"{key}_{i}"), key=f"{key}[{i}]")
        for i, x in enumerate(given, 1)
    ]


# Entries of a list parameter: as many Maxwell branches as any published tissue model has.
MOST_BRANCHES = 20


def tied_to(p: Parameter, known: Mapping[str, Parameter], slot: Slot) -> Parameter:
    """The environment's parameter to which p refers, under the key of p. SceneError where there is
    none, or where it does not fit the dimension or the rule of its new place."""
    shown, other = f'{p.key}: "{p.tie}"', known.get(p.tie)
    if other is None:
        valid = f"valid are {', '.join(known)}" if known else "it has none"
        raise SceneError(
            f"{shown} is no parameter of the environment: {meant(p.tie, known)}{valid}"
        )
    if not fits(other.dimension, other.exponents, slot.dimension):
        raise SceneError(
            f"{shown} is not a {slot.dimension.name.lower()}.{expected(slot.dimension)}"
        )
    if not all(slot.rule.allows(x) for x in (other.value, *(other.interval or ()))):
        raise SceneError(f"{shown} {slot.rule.value}")
    motion = other.motion or implied_motion(slot.dimension, other.exponents)
    # The rule becomes that of the new place: the value must keep both, which the scene sees to.
    return replace(other, key=p.key, tie=p.tie, rule=slot.rule, motion=motion)


def free_name(name: str, taken: Container[str], joint: str = "_") -> str:
    """The name, or with a number behind it the first one that is not taken."""
    return next(x for x in chain([name], (f"{name}{joint}{i}" for i in count(2))) if x not in taken)


def values(parameters: Iterable[Parameter]) -> dict[Symbol, Expr]:
    """The values of parameters by their symbols."""
    return {p.symbol: p.value for p in parameters}


def dimensions(measured: Iterable[tuple[Expr, Dimension]]) -> dict[Symbol, Dimension]:
    """What symbols measure, each by the places where it stands that are not those of any dimension;
    without those whose places differ.

    >>> from sympy.abc import T, k
    >>> dimensions([(T, Dimension.TIME), (T, Dimension.ANY), (k, Dimension.MASS), (k, Dimension.TIME)])
    {T: <Dimension.TIME: ('s', 's')>}
    """
    found: dict[Symbol, set[Dimension]] = {}
    for x, dimension in measured:
        if x.is_Symbol and dimension is not Dimension.ANY:
            found.setdefault(x, set()).add(dimension)
    return {x: known.pop() for x, known in found.items() if len(known) == 1}


def in_place(form: Expr, known: Mapping[Symbol, Expr]) -> Expr:
    """A formula with values in place of symbols; SceneError where they divide it by zero."""
    value = form.xreplace(known)
    if value.has(zoo, nan):
        zeros = ", ".join(sorted(f"{x} = {known[x]}" for x in form.free_symbols & known.keys()))
        raise SceneError(
            f"{form} is divided by zero with {zeros}"
            if zeros
            else f"it is divided by zero: {form} is no number"
        )
    return value


def with_values(
    parameters: Sequence[Parameter], given: Mapping[str, Number]
) -> tuple[Parameter, ...]:
    """The parameters with other values for those whose symbols have the given names."""
    return tuple(
        p.with_value(given[p.symbol.name]) if p.symbol.name in given else p for p in parameters
    )


def renamed(
    parameters: Sequence[Parameter], names: Mapping[Symbol, Symbol]
) -> tuple[Parameter, ...]:
    """The parameters with other symbols for some."""
    return tuple(replace(p, symbol=names.get(p.symbol, p.symbol)) for p in parameters)


Mass: TypeAlias = Annotated[Any, Slot(Dimension.MASS, Rule.NONNEGATIVE)]
Damping: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING, Rule.NONNEGATIVE)]
Stiffness: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS, Rule.NONNEGATIVE)]
PositiveMass: TypeAlias = Annotated[Any, Slot(Dimension.MASS)]
PositiveDamping: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING)]
PositiveStiffness: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS)]
StiffnessList: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS, several=True)]
DampingList: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING, several=True)]
SignedMass: TypeAlias = Annotated[Any, Slot(Dimension.MASS, Rule.ANY)]
SignedDamping: TypeAlias = Annotated[Any, Slot(Dimension.DAMPING, Rule.ANY)]
SignedStiffness: TypeAlias = Annotated[Any, Slot(Dimension.STIFFNESS, Rule.ANY)]
Frequency: TypeAlias = Annotated[Any, Slot(Dimension.FREQUENCY)]
Time: TypeAlias = Annotated[Any, Slot(Dimension.TIME, Rule.NONNEGATIVE)]
PositiveTime: TypeAlias = Annotated[Any, Slot(Dimension.TIME)]
Scale: TypeAlias = Annotated[Any, Slot(Dimension.RATIO)]
DampingRatio: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.NONNEGATIVE)]
Order: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.ORDER)]
Samples: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.WHOLE)]
Method: TypeAlias = Annotated[
    Any,
    Slot(Dimension.ANY, Rule.ANY, choices=("backward-difference", "tustin", "forward-difference")),
]
FractionalOrder: TypeAlias = Annotated[Any, Slot(Dimension.RATIO, Rule.FRACTION)]
FractionalStiffness: TypeAlias = Annotated[Any, Slot(Dimension.ANY)]
Force: TypeAlias = Annotated[Any, Slot(Dimension.FORCE, Rule.NONNEGATIVE)]
PositiveForce: TypeAlias = Annotated[Any, Slot(Dimension.FORCE)]
Amplitude: TypeAlias = Annotated[Any, Slot(Dimension.DISPLACEMENT)]
Formula: TypeAlias = Annotated[Any, Slot(Dimension.ANY, Rule.ANY, formula=True)]
FormulaInZ: TypeAlias = Annotated[Any, Slot(Dimension.ANY, Rule.ANY, formula=True, in_z=True)]
