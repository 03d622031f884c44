"""A parameter of a model: its place in the signature, the rule that its values keep, and how it is read from what was given."""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import chain, count
from typing import Any

from sympy import Expr, Symbol, nan, zoo

from haptisym.kernel.errors import SceneError, SignError, meant, quoted
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.shown import Shown
from haptisym.model.quantities import Dimension, Exponents, MotionKind, Number, expected, fits, implied_motion
from haptisym.model.ranges import ExactRange, ranged
from haptisym.model.units import si_unit


class Rule(Enum):
    """What values a parameter may have."""

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
            self, other, key=[Rule.ORDER, Rule.WHOLE, Rule.FRACTION, Rule.POSITIVE, Rule.NONNEGATIVE, Rule.ANY].index
        )

    def allows(self, value: Expr) -> bool:
        """Whether an exact number keeps the rule; symbols are taken at their word."""
        if value.free_symbols:
            return self not in WHOLE_NUMBERS
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


@dataclass(frozen=True)
class Slot:
    """A place for a parameter in a model: what it measures, what it may be, whether it may be absent or a list."""

    dimension: Dimension
    rule: Rule = Rule.POSITIVE
    required: bool = True
    several: bool = False
    formula: bool = False
    choices: tuple[str, ...] = ()

    @property
    def is_setting(self) -> bool:
        """Whether what stands here is chosen, and no number that may be varied."""
        return bool(self.choices) or self.rule in WHOLE_NUMBERS


NAMED = Slot(Dimension.ANY, Rule.ANY)
"""Of a name in a formula."""


@dataclass(frozen=True, repr=False)
class Parameter(Shown):
    """A named number of a scene: its symbol in formulas and its exact value (SI; or a symbol that the user chose)."""

    symbol: Symbol
    value: Expr
    dimension: Dimension
    motion: MotionKind | None = None
    key: str = ""
    """Its name in the model, as a scene file writes it."""
    exponents: Exponents | None = None
    """Of the base dimensions, as far as the unit that was given tells."""
    rule: Rule = Rule.ANY
    interval: ExactRange | None = None
    """Where the value may lie, if the scene gives a range; ``value`` is then the nominal one."""
    tie: str = ""
    """The environment's parameter that it is ("environment.k"), with its symbol, value and range; empty for one of its own."""

    def _line(self) -> str:
        return self.stated()

    def unit_in(self, motion: MotionKind | None) -> str:
        """Its unit; what the given one tells where the model knows no dimension, and empty where nothing does."""
        return self.dimension.unit(motion) or si_unit(self.exponents or ())

    def stated(self) -> str:
        """``m = 9/5 kg``, and between which values it may lie."""
        own = self.unit_in(self.motion or MotionKind.TRANSLATION)
        unit = "" if own in ("", "1") or self.value == self.symbol else f" {own}"
        spread = f", from {self.interval[0]} to {self.interval[1]}{unit}" if self.interval else ""
        return f"{self.symbol} = {self.value}{unit}{spread}" if self.value != self.symbol else str(self.symbol)

    def with_value(self, given: Number) -> Parameter:
        """The same parameter with another value (in place of a range, too), checked like the first one."""
        read = read_parameter(self.key, given, Slot(self.dimension, self.rule), self.symbol.name)
        if read.exponents is None:  # a bare number is one in the unit that was there
            read = replace(read, motion=self.motion, exponents=self.exponents)
        return replace(read, symbol=self.symbol, tie=self.tie)


_REFERENCE = re.compile(r"\s*[^\W\d]\w*\.[\w.\[\]-]+\s*")  # no quantity begins with a name


def enter_parameter(key: str, given: Number, slot: Slot, name: str) -> Parameter:
    """A parameter of a call: a quantity, a range, or a reference to one of the environment's, which waits for ``tied_to``."""
    if not isinstance(given, str) or not ("environment." in given or _REFERENCE.match(given)):
        return read_parameter(key, given, slot, name)
    if not _REFERENCE.fullmatch(given):
        raise SceneError(f'{key}: {quoted(given)}: a reference stands alone, as in {key} = "environment.{key}"')
    symbol = _symbol(name, slot.rule)
    return Parameter(symbol, symbol, slot.dimension, key=key, rule=slot.rule, tie=given.strip())


def refuse_references(parameters: Iterable[Parameter]) -> None:
    """SceneError where a parameter refers to another and is not one of what is rendered."""
    for p in parameters:
        if p.tie:
            raise SceneError(
                f'{p.key}: "{p.tie}": only what is rendered can refer to another value, the environment\'s'
            )


def _symbol(name: str, rule: Rule) -> Symbol:
    if not name.isidentifier() or name in ("s", "omega", "pi", "j"):
        raise SceneError(f'"{name}" cannot name a parameter: use letters, digits and _, and not s, omega, pi or j')
    return Symbol(name, real=True) if rule is Rule.ANY else Symbol(name, positive=True)


def read_parameter(key: str, given: Number, slot: Slot, name: str) -> Parameter:
    """A parameter from a quantity or a range, checked; ``key`` is what errors call it, ``name`` its symbol's."""
    symbol = _symbol(name, slot.rule)
    try:
        found = ranged(given, slot.dimension)
    except SceneError as error:
        raise error.within(key) from None
    read = found.nominal
    reserved = {x.name for x in read.value.free_symbols} & {"s", "omega", "X"}
    if reserved:
        raise SceneError(f"{key}: {quoted(given)} contains {min(reserved)}, which has a meaning of its own here")
    if found.interval and slot.rule in WHOLE_NUMBERS:
        raise SceneError(f"{key}: {quoted(given)} {slot.rule.value}, and no range")
    if not all(slot.rule.allows(x) for x in (read.value, *(found.interval or ()))):
        kind = SignError if slot.rule in (Rule.POSITIVE, Rule.NONNEGATIVE) else SceneError
        raise kind(f"{key}: {quoted(given)} {slot.rule.value}")
    return Parameter(symbol, read.value, slot.dimension, read.motion, key, read.exponents, slot.rule, found.interval)


def chosen(key: str, given: object, choices: Sequence[str]) -> str:
    """One of some words; SceneError for any other."""
    if given not in choices:
        raise SceneError(f"{key}: {quoted(given)} is none: {meant(str(given), choices)}valid are {', '.join(choices)}")
    return str(given)


def enter_list(key: str, given: Any, slot: Slot) -> list[Parameter]:
    """The entries of a list as parameters of their own."""
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        raise SceneError(f"{key}: {quoted(given)} must be a list of at least one quantity")
    if len(given) > MOST_BRANCHES:
        raise SceneError(f"{key}: a list may have at most {MOST_BRANCHES} entries, this one has {len(given)}")
    return [
        replace(enter_parameter(f"{key}[{i}]", x, slot, f"{key}_{i}"), key=f"{key}[{i}]")
        for i, x in enumerate(given, 1)
    ]


MOST_BRANCHES = 20  # of a list parameter: as many Maxwell branches as any published tissue model has


def tied_to(p: Parameter, known: Mapping[str, Parameter], slot: Slot) -> Parameter:
    """The environment's parameter that one refers to, in its place."""
    shown, other = f'{p.key}: "{p.tie}"', known.get(p.tie)
    if other is None:
        valid = f"valid are {', '.join(known)}" if known else "it has none"
        raise SceneError(f"{shown} is no parameter of the environment: {meant(p.tie, known)}{valid}")
    if not fits(other.dimension, other.exponents, slot.dimension):
        raise SceneError(f"{shown} is not a {slot.dimension.name.lower()}{expected(slot.dimension)}")
    if not all(slot.rule.allows(x) for x in (other.value, *(other.interval or ()))):
        raise SceneError(f"{shown} {slot.rule.value}")
    motion = other.motion or implied_motion(slot.dimension, other.exponents)
    return replace(other, key=p.key, tie=p.tie, rule=slot.rule, motion=motion)


def free_name(name: str, taken: Container[str], joint: str = "_") -> str:
    """The name, or with a number behind it the first one that is not taken."""
    return next(x for x in chain([name], (f"{name}{joint}{i}" for i in count(2))) if x not in taken)


def values(parameters: Iterable[Parameter]) -> dict[Symbol, Expr]:
    """From each parameter's symbol to its value."""
    return {p.symbol: p.value for p in parameters}


def in_place(form: Expr, known: Mapping[Symbol, Expr]) -> Expr:
    """A formula with values in place of symbols; SceneError where they divide it by zero."""
    found = form.xreplace(known)
    if found.has(zoo, nan):
        told = ", ".join(sorted(f"{x} = {known[x]}" for x in form.free_symbols & known.keys()))
        raise SceneError(
            f"{form} is divided by zero with {told}" if told else f"it is divided by zero: {form} is no number"
        )
    return found


def with_values(parameters: Sequence[Parameter], given: Mapping[str, Number]) -> tuple[Parameter, ...]:
    """The same parameters with other values for some."""
    return tuple(p.with_value(given[p.symbol.name]) if p.symbol.name in given else p for p in parameters)


def renamed(parameters: Sequence[Parameter], names: Mapping[Symbol, Symbol]) -> tuple[Parameter, ...]:
    """The same parameters under other symbols."""
    return tuple(replace(p, symbol=names.get(p.symbol, p.symbol)) for p in parameters)
