"""What the page of stability says of a display with a clock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from sympy import Rational

from haptisym.judge.colgate import SampledPassivity
from haptisym.kernel.reals import ExactNumber
from haptisym.pages.words import short
from haptisym.verbs.stability.critical import Nearest
from haptisym.verbs.stability.passive import EveryPassiveHand
from haptisym.writing.document import Block, Notes, Paragraph, Phrase, Strong, listed
from haptisym.writing.names import named

_CONDITION = "Colgate and Schenkel's condition"


def looked_at(rows: Sequence[Nearest]) -> list[Phrase]:
    """As far as numbers of a loop with a clock were looked at, where no value was found on a side, and that has an end."""
    told: list[Phrase] = []
    for x in rows:
        low, high = (None if end is None else short(ExactNumber(_rational(end))) for end in _left(x))
        ends = (*((" from ", low) if low else ()), *((" to " if low else " up to ", high) if high else ()))
        if ends:
            told.append((x.path, *ends, "" if high else " on"))
    return [("Looked at: ", listed(told), "; what lies beyond was not.")] if told else []


def _left(x: Nearest) -> tuple[Fraction | None, Fraction | None]:
    """The ends of what was looked at that are not beside a value that was found."""
    low, high = (None, None) if len(x.found) == 2 else (x.low, x.high)
    for value in (Fraction(float(y.value)) for y in x.found):
        if x.high is None or (x.low is not None and abs(value - x.low) < abs(value - x.high)):
            low = None
        else:
            high = None
    return low, high


def _rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def sampled_condition(found: EveryPassiveHand, damping: str, stiffness: str) -> Iterator[Block]:
    """Whether every passive hand holds a sampled loop, and what the device needs for it; the units of damping and stiffness."""
    x = found.sampled
    assert x is not None
    if found.holds is None:
        yield Paragraph((Strong("UNDECIDED"), f": {_CONDITION} does not apply, as {x.reason}."))
    elif found.holds is False and x.passive is not False:
        words = ": there is a passive hand in which a motion grows, as the display gives energy to imposed motion."
        yield Paragraph((Strong("Does NOT hold"), words))
    elif x.passive:
        yield Paragraph((f"Holds: {_CONDITION} is met on all of 0 < ", named("theta"), " = ", *_ANGLE, " ≤ π."))
    elif x.pushes:
        words = ": a passive hand that is softer is pushed away, as the display's stiffness at rest is negative."
        yield Paragraph((Strong("Does NOT hold"), words))
    else:
        words = f": {_CONDITION} is not met, so that there is a passive hand in which a motion grows."
        yield Paragraph((Strong("Does NOT hold"), words))
    if x.pushes:
        value = short(ExactNumber(x.at_rest)), f" {stiffness}"
        yield Notes((("Whatever a hand damps: the display's stiffness at rest is ", *value, "."),))
    elif x.sides is not None:
        yield Notes(tuple(_notes(x, damping)))


_ANGLE: tuple[Phrase, ...] = (named("omega"), " ", named("T"))


def _notes(x: SampledPassivity, unit: str) -> Iterator[Phrase]:
    best = x.needed
    if best is None:
        yield "No damping of the device is enough: what the controller asks for grows without bound."
        return
    assert best.omega is not None
    place = ("at ", named("theta"), " = ", short(best.omega))
    has = " it has ", short(ExactNumber(x.damping)), f" {unit}"
    if x.asks_nothing:
        yield "The device's damping must not be negative;", has, "."
    else:
        needs = short(best.value), f" {unit};", *has
        yield "The device's damping must exceed ", needs, " (the largest right-hand side is ", place, ")."
    if x.passive is False and x.hand_needed is not None:
        lacking = short(x.hand_needed), f" {unit}"
        yield "In a hand that damps more than ", *lacking, " no motion grows, whatever its mass and stiffness."
