"""The page of ``haptisym design``: which values of the free parameters make the bandwidth largest.

The bandwidth is the end of the interval from the band's low end on which no distortion is noticed.
``Design`` (verbs.design.entry) holds the answer of a search by branch and bound: the best values
that were found; two numbers between which the largest bandwidth lies, both proven; what limits it;
and what it costs to miss the best values. This module only writes it down. Begin with ``page``,
which puts the parts together in the order in which they are printed:

- the answer in a few lines (``_answer``), with what limits it and which conditions are kept: the
  user may demand that a display stays passive or stable (``keep``), for all values that are off by
  a share (``robust``);
- a table of what it costs to miss the values, and the figure (``_blocks``);
- what was searched and what is proven (``_proven``);
- the next command (``_require``).

A *phrase* is a text, a number that keeps its rounding, or a tuple of these. Every number is rounded
to the side on which its sentence stays true: lower bounds down (``Way.DOWN``), upper ones up, the
searched range inwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from decimal import Context, Decimal
from fractions import Fraction
from shlex import quote
from typing import Any

from sympy import Expr

from haptisym.kernel.reals import Way
from haptisym.model.scene import Knob
from haptisym.pages.words import bare, both, cell, page_about, proof, undecided, value_of
from haptisym.verbs.design.attained import PASSIVE, STABLE, STEADY, Attained
from haptisym.verbs.design.entry import Design
from haptisym.writing.document import (
    FREQUENCY_UNIT,
    Block,
    Brief,
    Code,
    Column,
    Document,
    Figure,
    Phrase,
    Real,
    Table,
    listed,
)
from haptisym.writing.layout import named

_DIGITS = 17
"""Digits that give a double back: values that are rounded further may have another bandwidth."""
_DIGITS_OF_END = 6
"""Digits of an end of the range that is the best value, where no digits are all of it."""
_MOST_IN_FRACTION = 10**6
"""Numerators and denominators below this are printed, where digits are not all of a value."""
_MOST_DRAWN = 2
"""Free parameters over which a figure is drawn, and which ``haptisym require`` takes."""
_MOST_BOXES = 4
"""Boxes of values that are listed: more are counted."""
_KEPT = {True: "yes", False: "not by all", None: "not proven"}
"""Whether all values that are off keep what must be kept, in words."""


def page(a: Design) -> Document:
    """Return the whole page of the best values."""
    further = []
    if a.is_whole and len(a.free) <= _MOST_DRAWN:
        further.append(_require(a))
    return page_about(
        a.about,
        _answer(a),
        _blocks(a),
        _proven(a),
        "Values with the largest bandwidth",
        a.asides(),
        further,
    )


def _answer(a: Design) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the lines of the answer, each a heading and its phrase: the best values, the bandwidth
    that they attain, what limits it, and what was kept."""
    if a.best is None:
        such = listed(a.keep) if a.keep else "fit for the model"
        begin = "no values in the range are " if a.certified else "no values were found that are "
        yield "Best values", (begin, such)
        yield "Bandwidth", "none" if a.certified else ("at most ", both(a.bandwidth[1], Way.UP))
        return
    values = []
    for x, value in zip(a.free, a.best.values, strict=True):
        values.append((named(x.name), " = ", *_written(x, value), _in_scene(x, value)))
    yield "Best values", listed(values)
    yield "Bandwidth", _bandwidth(a)
    if not a.is_whole:
        yield "Limited by", _limits(a)
    if a.keep:
        yield "Kept", (listed(a.keep), _whether_kept(a))


def _whether_kept(a: Design) -> str:
    """Return for which values the conditions that must be kept are proven: the best ones, or all
    about them that the user wants."""
    if not a.robust:
        return " (proven at these values)"
    near = f"for all values that are off by {_percent(a.robust)} at most"
    return f" (proven {near})" if a.best and a.best.kept else f" (not proven {near})"


def _written(x: Knob, value: Expr) -> tuple[Phrase, ...]:
    """Return a best value in full digits, in the scene's unit; as a fraction too, or with a note,
    where it has more digits, as what is proven holds for the value itself alone."""
    unit = x.shown_unit(x.motion)
    in_unit, full = value / unit.size, Real(value, Way.NEAREST, _DIGITS, unit)
    if not in_unit.is_Rational:
        return full, " (rounded)"
    if _is_decimal(in_unit):
        return (full,)
    is_short = max(abs(int(in_unit.p)), int(in_unit.q)) < _MOST_IN_FRACTION
    return full, f" (exactly {in_unit})" if is_short else " (rounded)"


def _is_decimal(x: Expr) -> bool:
    """Return whether the digits that give a double back are all of a number."""
    if not x.is_Rational:
        return False
    decimal = Context(prec=_DIGITS).divide(Decimal(int(x.p)), Decimal(int(x.q)))
    return Fraction(decimal) == Fraction(int(x.p), int(x.q))


def _in_scene(x: Knob, best: Expr) -> Phrase:
    """Return the scene's own value, to stand in brackets after a best one."""
    if best == x.value:
        return " (as in the scene)"
    return " (is ", value_of(x, x.value, Way.NEAREST), ")"


def _bandwidth(a: Design) -> Phrase:
    """Return the bandwidth of the best values, how much others could have, and the scene's own."""
    attained, bound = a.bandwidth
    of_best = both(attained, Way.DOWN)
    of_scene: Phrase = ()
    if a.given not in (None, a.best):
        of_scene = "; is ", _given(a, a.given)
    off: Phrase = ()
    if a.robust:
        off = " if all values are off by ", _percent(a.robust), " at most"
    if a.is_whole:
        return of_best, ", the whole band", off, of_scene
    # The proven upper bound for all values is what the best ones attain.
    if bound <= attained:
        return of_best, off, of_scene, "; no values in the range have more"
    # If values may be off, what is proven is a bandwidth for all of them: a lower bound.
    least = " or more" if a.robust else ""
    most = cell(bound, Way.UP)
    return of_best, least, off, of_scene, "; at most ", most, " with any values in the range"


def _given(a: Design, given: Attained) -> Phrase:
    """Return the bandwidth of the scene's own values; if these may be off, what they attain at
    least, rounded down as the lower bound that it then is."""
    return cell(given.bandwidth, Way.DOWN if a.robust else Way.NEAREST)


def _limits(a: Design) -> Phrase:
    """Return which ratios (r_r, r_i) end the bandwidth, in which environment and from which
    frequency on."""
    if not a.binding:
        # ``seen`` is 0 where something is noticed at the low end already.
        is_undecided = a.best is not None and a.best.seen
        return "undecided" if is_undecided else "the low end of the band: noticed from there on"
    has_several = len(a.family) > 1
    ratios = []
    for x in a.binding:
        where = f" with {x.environment}" if has_several else ""
        ratios.append((named(x.criterion.symbol), where))
    together = " at once" if len(ratios) > 1 else ""
    return listed(ratios), f"{together} from ", both(a.binding[0].omega), " on"


def _blocks(a: Design) -> Iterator[Block]:
    """Yield what it costs to miss the best values, and the figure; nothing where there is neither
    a bandwidth nor a figure."""
    if a.loss and a.best and a.best.bandwidth:
        columns = [
            Column("All values off by at most"),
            Column(("Bandwidth, ", FREQUENCY_UNIT), number=True),
        ]
        if a.keep:
            columns.append(Column(("Kept: ", listed(a.keep))))
        rows = []
        for x in a.loss:
            bandwidth = "at least ", cell(x.bandwidth, Way.DOWN)
            row: list[Phrase] = [_percent(x.relative), bandwidth]
            if a.keep:
                row.append(_KEPT[x.kept])
            rows.append(tuple(row))
        yield Table(tuple(columns), tuple(rows), "What it costs to miss the best values.")
    if len(a.free) <= _MOST_DRAWN and a.best is not None:
        words = (
            "The bandwidth over the free parameter, with proven bounds."
            if len(a.free) == 1
            else "The bandwidth over both parameters."
        )
        yield Figure("design", words, a.figure)


def _percent(x: Expr) -> str:
    """Return a share in per cent."""
    return f"{float(100 * x):.15g}\xa0%"


def _proven(a: Design) -> Iterator[Phrase]:
    """Yield the range searched, where better values could lie, and what is proven."""
    searched = listed(_ranges(a, a.ranges))
    low, high = a.family.band
    band = cell(low, Way.UP), " to ", cell(high, Way.DOWN), "\xa0", FREQUENCY_UNIT
    yield "Range searched: ", searched, "; band: ", *band, "."
    if a.best is not None and len(a.clusters):
        first = a.clusters[:_MOST_BOXES]
        boxes = [listed(_ranges(a, box)) for box in first]
        others = len(a.clusters) - _MOST_BOXES
        further = f" and {others} more" if others > 0 else ""
        outside = "Within the range searched, nothing better lies outside of "
        yield outside, listed(boxes, "or"), further, _wider(a), "."
    if a.certified and a.best is None:
        yield proof(a.scene, ("no values in the range are ", listed(a.keep)))
    elif a.certified:
        most = ", and that no other values in the range have more than the bound"
        yield proof(a.scene, f"the bandwidth at these values{'' if a.is_whole else most}")
    else:
        bound = both(a.bandwidth[1], Way.UP)
        yield undecided(("whether other values have up to ", bound, _why(a)))


def _why(a: Design) -> str:
    """Return why the search ended without a proof."""
    if a.why:
        return f": {a.why}"
    exact = " and how passive a display is far above the band" if PASSIVE in a.keep else ""
    return f": cells became too narrow{exact}; narrower ranges help"


def _wider(a: Design) -> Phrase:
    """Return that a wider range may have better values, where a best one is an end of it."""
    found = a.at_ends
    if not found:
        return ""
    options = " ".join(f"--free {x.name}=LO:HI" for x, _ in found)
    typed = Brief((" (", Code(options), ")"))
    if len(found) == 1:
        [(x, upper)] = found
        end = f" is at the {_SIDES[upper]} end of its range: a wider one"
        return "; the best value of ", named(x.name), end, typed, " may have a better one"
    names = [(named(x.name), f" ({_SIDES[upper]} end)") for x, upper in found]
    ends = " are at ends of their ranges: wider ones"
    return "; the best values of ", listed(names), ends, typed, " may have better ones"


_SIDES = {False: "lower", True: "upper"}


def _ranges(a: Design, box: Iterable[Any]) -> Iterator[Phrase]:
    """Yield the range of each free parameter in a box of two ends for each. Ends of the range
    searched are rounded inwards, others outwards: nothing better is beyond what is printed."""
    for i, ends in enumerate(box):
        lower, upper = (_end(a, i, k, x) for k, x in enumerate(ends))
        yield named(a.free[i].name), " from ", bare(lower), " to ", upper


def _end(a: Design, i: int, k: int, end: Any) -> Real:
    """Return the lower or the upper end of a box, k = 0 or 1; an end of the range searched always
    in the same digits, which are those of the best value where that is the end."""
    x, whole = a.free[i], a.ranges[i][k]
    if float(end) != float(whole):
        return value_of(x, end, (Way.DOWN, Way.UP)[k])
    inward = (Way.UP, Way.DOWN)[k]
    if a.best is None or a.best.values[i] != whole:
        return value_of(x, whole, inward)
    unit = x.shown_unit(x.motion)
    digits = _DIGITS if _is_decimal(whole / unit.size) else _DIGITS_OF_END
    return Real(whole, inward, digits, unit)


# The next command.


def _require(a: Design) -> str:
    """Return the command that gives all values with which nothing is noticed, and that keep what
    must be kept."""
    words = ["haptisym require SCENE"]
    for x, (low, high) in zip(a.free, a.ranges, strict=True):
        words.append(f"--free {x.path} --range {_option(x, low)} {_option(x, high)}")
    # ``transparent`` is what it asks for unless there are goals.
    if a.keep:
        words += [f"--that {goal}" for goal in ("transparent", *a.keep)]
    if STABLE in a.keep or STEADY in a.keep:
        # The option takes one hand; where there are several, the scene itself has the names.
        names = {quote(hand.name) for hand in a.scene.hands}
        if len(names) == 1:
            words.append(f"--hand {names.pop()}")
    return " ".join(words)


def _option(x: Knob, end: Expr) -> str:
    """Return an end of a range as an option of the command line takes it: in the unit of the scene,
    where digits are all of it there, or in SI."""
    unit = x.shown_unit(x.motion)
    is_short = _is_decimal(end / unit.size)
    number = repr(float(end / unit.size if is_short else end)).removesuffix(".0")
    return quote(f"{number}{unit.name}" if is_short else number)
