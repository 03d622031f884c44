"""The page of the best values: what they are, how large the bandwidth can be, what limits it, and
what it costs to miss them."""

from __future__ import annotations

from collections.abc import Iterator
from shlex import quote

from sympy import Expr

from haptisym.kernel.reals import Printable, Way
from haptisym.model.scene import Knob
from haptisym.pages.words import bare, both, cell, page_about, proof, undecided, value_of
from haptisym.verbs.design.attained import PASSIVE, STABLE, STEADY, Attained
from haptisym.verbs.design.entry import Design
from haptisym.writing.document import (
    FREQUENCY_UNIT,
    Block,
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


def page(a: Design) -> Document:
    """Return the whole page of the best values."""
    further = [_require(a)] if a.is_whole and len(a.free) < 3 else []
    return page_about(
        a.about,
        _answer(a),
        _blocks(a),
        _proven(a),
        "Values with the largest bandwidth",
        a.asides(),
        further,
    )


def _require(a: Design) -> str:
    """Return the command that gives all values with which nothing is noticed."""
    ranges = zip(a.free, a.ranges, strict=True)
    free = " ".join(
        f"--free {x.path} --range {_bare(low)} {_bare(high)}" for x, (low, high) in ranges
    )
    goals = "".join(f" --that {x}" for x in ("transparent", *a.keep)) if a.keep else ""
    hands = {quote(x.name) for x in a.scene.hands} if {STABLE, STEADY} & {*a.keep} else set()
    # Of several hands the scene itself has the names.
    hand = f" --hand {hands.pop()}" if len(hands) == 1 else ""
    return f"haptisym require SCENE {free}{goals}{hand}"


def _bare(x: Expr) -> str:
    """Return a number as an option of the command line takes it."""
    return repr(float(x)).removesuffix(".0")


def _answer(a: Design) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the best values, the bandwidth that they attain, what limits it, and what was kept."""
    if a.best is None:
        none = "no values in the range are" if a.certified else "no values were found that are"
        yield "Best values", (f"{none} ", listed(a.keep) if a.keep else "fit for the model")
        yield "Bandwidth", "none" if a.certified else ("at most ", both(a.bandwidth[1], Way.UP))
        return
    values = zip(a.free, a.best.values, strict=True)
    yield (
        "Best values",
        listed((named(x.name), " = ", _written(x, v), _now(x, v)) for x, v in values),
    )
    yield "Bandwidth", _bandwidth(a)
    if not a.is_whole:
        yield "Limited by", _limits(a)
    if a.keep:
        yield "Kept", (listed(a.keep), _whether_kept(a))


def _whether_kept(a: Design) -> str:
    """Return for which values the conditions that must be kept are proven."""
    if not a.robust:
        return " (proven at these values)"
    near = f"for all values that are off by {_percent(a.robust)} at most"
    return f" (proven {near})" if a.best and a.best.kept else f" (not proven {near})"


def _written(x: Knob, value: Expr) -> Real:
    """Return a best value in full digits, in the scene's unit."""
    return Real(value, Way.NEAREST, _DIGITS, x.shown_unit(x.motion))


def _now(x: Knob, best: Expr) -> Phrase:
    """Return the scene's own value beside a best one."""
    return (
        " (as in the scene)"
        if best == x.value
        else (" (is ", value_of(x, x.value, Way.NEAREST), ")")
    )


def _bandwidth(a: Design) -> Phrase:
    """Return the bandwidth of the best values, how much others could have, and the scene's own."""
    low, high = a.bandwidth
    now: Phrase = () if a.given in (None, a.best) else ("; is ", _given(a, a.given))
    off: Phrase = (" if all values are off by ", _percent(a.robust), " at most") if a.robust else ()
    if a.is_whole:
        return both(low, Way.DOWN), ", the whole band", off, now
    # The proven upper bound for all values is what the best ones attain.
    if high <= low:
        return both(low, Way.DOWN), off, now, "; no values in the range have more"
    # If values may be off, what is proven is a bandwidth for all of them: a lower bound.
    least = both(low, Way.DOWN), " or more" if a.robust else ""
    return *least, off, now, "; at most ", cell(high, Way.UP), " with any values in the range"


def _given(a: Design, given: Attained) -> Phrase:
    """Return the bandwidth of the scene's own values; if these may be off, what they attain at
    least."""
    # Rounded down as the lower bound that it then is.
    return cell(given.bandwidth, Way.DOWN if a.robust else Way.NEAREST)


def _limits(a: Design) -> Phrase:
    """Return which ratios end the bandwidth, in which environment and from which frequency on."""
    if not a.binding and a.best is not None and a.best.seen:
        return "undecided"
    if not a.binding:
        return "the low end of the band: noticed from there on"
    several = len(a.family) > 1
    first = a.binding[0]
    said = [
        (named(x.criterion.symbol), f" with {x.environment}" if several else "") for x in a.binding
    ]
    together = " at once" if len(said) > 1 else ""
    return listed(said), f"{together} from ", both(first.omega), " on"


def _blocks(a: Design) -> Iterator[Block]:
    """Yield what it costs to miss the best values, and the figure."""
    if a.loss and a.best and a.best.bandwidth:
        columns = (
            Column("All values off by at most"),
            Column(("Bandwidth, ", FREQUENCY_UNIT), number=True),
            *[Column(("Kept: ", listed(a.keep)))] * bool(a.keep),
        )
        rows = [
            (
                _percent(x.relative),
                ("at least ", cell(x.bandwidth, Way.DOWN)),
                *((_KEPT[x.kept],) if a.keep else ()),
            )
            for x in a.loss
        ]
        yield Table(columns, tuple(rows), "What it costs to miss the best values.")
    if len(a.free) < 3 and a.best is not None:
        words = (
            "The bandwidth over the free parameter, with proven bounds."
            if len(a.free) == 1
            else "The bandwidth over both parameters."
        )
        yield Figure("design", words, a.figure)


_KEPT = {True: "yes", False: "not by all", None: "not proven"}


def _percent(x: Expr) -> str:
    """Return a share in per cent."""
    return f"{float(100 * x):g}\xa0%"


def _proven(a: Design) -> Iterator[Phrase]:
    # The range that was searched is rounded inwards, the boxes beyond which nothing is better
    # outwards.
    """Yield the range searched, where better values could lie, and what is proven."""
    spans = (_range(x, *ends, Way.UP, Way.DOWN) for x, ends in zip(a.free, a.ranges, strict=True))
    low, high = (cell(float(x), Way.NEAREST) for x in a.family.band)
    yield (
        "Range searched: ",
        listed(spans),
        "; band: ",
        low,
        " to ",
        high,
        "\xa0",
        FREQUENCY_UNIT,
        ".",
    )
    if a.best is not None and len(a.clusters):
        boxes = [
            listed(_range(x, *ends, Way.DOWN, Way.UP) for x, ends in zip(a.free, box, strict=True))
            for box in a.clusters[:4]
        ]
        further = f" and {len(a.clusters) - 4} more" if len(a.clusters) > 4 else ""
        yield "Nothing better lies outside of ", listed(boxes, "or"), f"{further}."
    if a.certified and a.best is None:
        yield proof(a.scene, ("no values in the range are ", listed(a.keep)))
    elif a.certified:
        most = (
            "" if a.is_whole else ", and that no other values in the range have more than the bound"
        )
        yield proof(a.scene, f"the bandwidth at these values{most}")
    else:
        yield undecided(("whether other values have up to ", both(a.bandwidth[1], Way.UP), _why(a)))


def _why(a: Design) -> str:
    """Return why the search ended without a proof."""
    if a.why:
        return f": {a.why}"
    exact = " and how passive a display is far above the band" if PASSIVE in a.keep else ""
    return f": cells became too narrow{exact}; narrower ranges help"


def _range(x: Knob, low: Printable, high: Printable, down: Way, up: Way) -> Phrase:
    """Return a parameter's range, each end rounded in its own way."""
    return named(x.name), " from ", bare(value_of(x, low, down)), " to ", value_of(x, high, up)
