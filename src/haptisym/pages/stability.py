"""The page of stability: each hand, any passive operator, and prescribed motion, which are three statements; the limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from math import inf, log10

from sympy import Expr, Integer, Rational, exp

from haptisym.judge.colgate import SampledPassivity
from haptisym.judge.passivity import Beyond, Passivity
from haptisym.kernel.reals import ExactNumber, Way, in_unit
from haptisym.kernel.rootcount import RootChain
from haptisym.model.catalogue import Hand, hands
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.pages import words as w
from haptisym.pages.evaluation import not_looked_at
from haptisym.verbs.stability.critical import Critical, Nearest, Window
from haptisym.verbs.stability.entry import Stability, has_plane
from haptisym.verbs.stability.held import Box, Held, Share
from haptisym.verbs.stability.margins import MOST_DELAY, MOST_GAIN, Limit, Margins
from haptisym.writing import document as doc
from haptisym.writing.boxes import Prefixed
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, Strong, listed
from haptisym.writing.layout import named

_IM = Prefixed(w.OPERATORS[Part.IMAG], w.H_PERC)
_REAL = Prefixed(w.OPERATORS[Part.REAL], named("s"))
_LEFT, _RIGHT = w.compared(_REAL, "<"), w.compared(_REAL, "≥")
_PLANE = "Hands of one mass: where the display is stable in them, and the number of unstable poles where it is not."
_WALLS = "Sampled walls: where the display is stable with them, and the number of unstable poles (|z|\xa0≥\xa01) where it is not."
_MOST = 6  # active intervals that are printed
_FEW = 2  # limits that the answer has of a hand
_CHAINS = {
    RootChain.RIGHT: "infinitely many poles lie to the right of the imaginary axis: the highest power of s is delayed (the "
    "system is neutral, or advanced)",
    RootChain.NEAR: "infinitely many poles come arbitrarily near to the imaginary axis: the system is neutral",
}


def page(found: Stability) -> Document:
    """The whole page."""
    is_sampled = bool(clocks(found.scene))
    drawn = (doc.Figure("plane", _WALLS if is_sampled else _PLANE, found.figure),) if has_plane(found.scene) else ()
    blocks = (
        *_hands(found), *_limits(found), *_margins(found), *drawn,
        *w.noted((("Prescribed motion: ", _prescribed(found)), *_passivity(found))), w.certificate(found, found.scene),
    )  # fmt: skip
    return w.page_about(found.scene, _answer(found), blocks, _proven(found), "Stability", found.asides())


# The answer.


def _answer(found: Stability) -> Iterator[tuple[Phrase, Phrase]]:
    if not found.held:
        yield "Hand", ("none given: --hand NAME; the package ships ", ", ".join(hands))
    for x, rows in zip(found.held, found.critical, strict=True):
        yield x.hand.name, (_verdict(x), _nearest_limits(found, x, rows))
    yield "Any operator", _any_operator(found)


def _verdict(x: Held) -> Phrase:
    if x.roots is None:
        return Strong("undecided"), ": ", x.reason
    if x.stable:
        return Strong("stable"), ""
    if x.shakes is False and x.drifts:
        return "does not shake; drifts: nothing holds it in place"
    if x.roots.chain is not None:
        return Strong("unstable"), ": ", _CHAINS[x.roots.chain]
    on_axis = x.on_axis[bool(x.drifts) :]
    if on_axis and len(on_axis) * 2 >= (x.unstable or 0):
        return Strong("unstable"), " (poles on the imaginary axis at ", listed(map(w.both, on_axis)), ")"
    return Strong("unstable"), f" ({x.unstable} unstable pole{'' if x.unstable == 1 else 's'})"


def _nearest_limits(found: Stability, x: Held, rows: Sequence[Nearest]) -> Phrase:
    """Of a stable display how far the nearest parameters may go; of an unstable one what makes it stable."""
    if not (x.stable or x.shakes):
        return ""
    told: list[tuple[float, Phrase]] = []
    for row in rows:
        knob = found.scene.knobs[row.path]
        for low, high in (y for y in row.windows if y[0] is not y[1]):  # a single value is in the table alone
            if x.stable:
                ends = (("down to ", low, Way.UP), ("up to ", high, Way.DOWN))
                told += [
                    (_distance(knob, y), (words, _name(knob), " = ", w.value_of(knob, y.value, way)))
                    for words, y, way in ends if y
                ]  # fmt: skip
            else:
                now = w.value_of(knob, ExactNumber(knob.value), Way.NEAREST)
                reach = min(_distance(knob, y) for y in (low, high) if y)
                unit = f"\xa0{now.unit.text}" if now.unit.text else ""
                told.append((reach, (*_between(knob, low, high), unit, " (is ", now, ")")))
    few = [words for _, words in sorted(told, key=lambda y: y[0])[:_FEW]]
    so = ": " if x.stable else ": does not shake for " if x.drifts else ": needs "
    return (so, listed(few, "and" if x.stable else "or")) if few else ""


def _distance(knob: Knob, x: Critical) -> float:
    """From the value that a parameter has, relative to it."""
    now = float(knob.value)
    return abs(float(x.value) - now) / (abs(now) or 1)


def _between(knob: Knob, low: Critical | None, high: Critical | None) -> tuple[Phrase, ...]:
    """``hand.b > 2``, ``2 < hand.b < 5``, without a unit."""
    least, most = _ends(knob, low, high)
    if low and high:
        return least, "\xa0<\xa0", _name(knob), "\xa0<\xa0", most
    return (_name(knob), " > ", least) if low else (_name(knob), " < ", most)


def _ends(knob: Knob, low: Critical | None, high: Critical | None) -> tuple[Phrase, Phrase]:
    """As printed, without a unit, rounded inward."""
    least, most = low and w.value_of(knob, low.value, Way.UP), high and w.value_of(knob, high.value, Way.DOWN)
    return (least and w.bare(least)) or "", (most and w.bare(most)) or ""


def _name(knob: Knob) -> Phrase:
    """A parameter by its symbol; a hand's by its path."""
    return f"hand.{knob.key}" if knob.is_of_hand else named(knob.symbol.name)


def _any_operator(found: Stability) -> Phrase:
    x = found.every_passive_hand
    if x.holds:
        return Strong("passive"), ": stable in the hand of any passive operator"
    if x.holds is None:
        p = x.passivity
        why: Phrase = x.reason if p is None or x.sampled is not None else _why_open(p)
        return Strong("undecided"), " whether it is passive", (": ", why) if why else ""
    return Strong("not passive"), _needs(x.sampled, w.unit(Dimension.DAMPING, found.scene.motion)) if x.sampled else ""


def _needs(x: SampledPassivity, damping: str) -> Phrase:
    """What Colgate and Schenkel's condition asks of the device's damping."""
    if x.sides is None:
        return ""
    has = " (is ", w.near(ExactNumber(x.damping)), ")"
    if x.needed is None or x.pushes:
        return ": no damping of the device is enough"
    if x.asks_nothing:
        return ": needs device damping ≥ 0", *has
    return (": needs device damping > ", w.at_most(x.needed.value), f" {damping}", *has) if x.passive is False else ""


def _why_open(p: Passivity) -> Phrase:
    if p.beyond is Beyond.NEVER:
        return _IM, " ≥ 0 at all frequencies, but where poles lie is undecided"
    return "above ", w.both(ExactNumber(p.high)), " the sign of ", _IM, f" is {p.beyond.value}"


# Each hand, and the limits.


def _of_hand(i: int) -> w.Cell:
    return lambda x: w.near(ExactNumber(x.hand.parameters[i].value))


def _hands(found: Stability) -> Iterator[Block]:
    if not found.held:
        return
    units = [w.unit(x, found.scene.motion) for x in (Dimension.MASS, Dimension.DAMPING, Dimension.STIFFNESS)]
    keys = (
        w.number((named(key), f" ({unit_})"), _of_hand(i))
        for i, (key, unit_) in enumerate(zip("mbk", units, strict=True))
    )
    notes = [_box(x.hand, box) for x, box in zip(found.held, found.boxes, strict=True) if box]
    notes += [f"{x.hand.name}: no motion grows, as all parts are passive." for x in found.held if _only_near(found, x)]
    shown = w.table(
        found.held, "The display in each hand.", w.Field("hand", lambda x: x.hand.name), *keys, w.Field("stable", _stable),
        w.number("unstable poles", _count),
    )  # fmt: skip
    yield doc.Section("Does it shake?", (shown, *w.noted(notes)))


def _only_near(found: Stability, x: Held) -> bool:
    """Whether a chain of poles that comes to the axis is known to stay on its left."""
    p = found.every_passive_hand.passivity
    return bool(x.roots is not None and x.roots.chain is RootChain.NEAR and p and p.has_passive_parts)


def _stable(x: Held) -> Phrase:
    drifts = x.shakes is False and x.drifts
    return Strong("undecided") if x.stable is None else "yes" if x.stable else "drifts" if drifts else Strong("no")


def _count(x: Held) -> str:
    """How many poles are unstable, where that is known."""
    if x.roots is None or x.roots.chain is RootChain.NEAR:  # of a chain that only comes near, none need lie there
        return "" if x.roots is None else "a chain near the axis"
    return "infinite" if x.unstable is None else str(x.unstable)


def _box(hand: Hand, box: Box) -> Phrase:
    """In which hands of given ranges it is stable."""
    within = [(p.key, *map(ExactNumber, p.interval)) for p in hand.parameters if p.interval]
    ranges = listed((named(str(key)), " from ", w.near(low), " to ", w.near(high)) for key, low, high in within)
    if box.share is None:
        return w.undecided((f"{hand.name} with ", ranges, f": {box.reason}"))
    verdict: dict[Share, Phrase] = {
        Share.ALL: "stable in all of these hands",
        Share.SOME: (Strong("not"), " stable in all of these hands, but in some"),
        Share.NONE: (Strong("not"), " stable in any of these hands"),
    }
    return f"{hand.name} with ", ranges, ": ", verdict[box.share], "."


def _limits(found: Stability) -> Iterator[Block]:
    """The limits of each parameter, one varied at a time, the nearest first; those that change nothing in a line."""
    pairs = [
        (x, row)
        for x, rows in zip(found.held, found.critical, strict=True)
        for row in sorted(rows, key=lambda row: _reach(found, row))
    ]
    shown = [(x, row) for x, row in pairs if any(row.windows)]
    first = {x.hand.name: row for x, row in reversed(shown)}
    lines = [
        (x.hand.name if first[x.hand.name] is row else "", found.scene.knobs[row.path], [*row.windows])
        for x, row in shown
    ]
    notes: list[Phrase] = []
    for x in found.held:
        of_hand = [row for y, row in pairs if y is x]
        none = [row for row in of_hand if not row.reason and not any(row.windows)]
        crowded = [row for row in none if any(y.is_crowded for y in row.found)]
        for rows, words in (
            ([row for row in none if not row.found], _kept(x)),
            ([row for row in none if row.found and row not in crowded], _CROSSED),
            (crowded, "a chain of poles leaves open what is stable next to the limit of "),
        ):
            names, ends = (listed(x) for x in (_names(found, rows), _searched(found, rows)))
            notes += [(f"{x.hand.name}: {words}", names, (" (", ends, ")") if ends else "", ".")] if rows else []
        if ends := listed(_searched(found, [row for row in of_hand if any(_is_open(row, *y) for y in row.windows)])):
            notes.append((f"{x.hand.name}: searched ", ends, "."))
        for why in dict.fromkeys(row.reason for row in of_hand if row.reason):
            names = listed(_names(found, [row for row in of_hand if row.reason == why]))
            notes.append(w.undecided((names, f" in {x.hand.name}: {why}")))
    holds = "does not shake for" if any(x.drifts for x in found.held) else "stable for"
    limits = w.table(
        lines, "The nearest values, either way, at which stability changes, and the frequency of the pole there.",
        w.Field("hand", lambda x: x[0]), w.Field("parameter", lambda x: _name_and_unit(x[1])),
        w.Field("is", lambda x: w.bare(w.value_of(x[1], ExactNumber(x[1].value), Way.NEAREST))),
        w.Field(holds, lambda x: listed((_stable_for(x[1], *y) for y in x[2]), "or")),
        w.Field(("pole at limit (", FREQUENCY_UNIT, ")"), lambda x: listed(_places(x[2]))),
    )  # fmt: skip
    if lines or notes:
        blocks = (limits,) if lines else ()
        yield doc.Section("Stability limits, one parameter varied at a time", (*blocks, *w.noted(notes)))


_CROSSED = "stays unstable past the nearest pole crossing of "


def _kept(x: Held) -> str:
    """What holds where no value changes anything."""
    if x.shakes is False and x.drifts:
        return "does not shake for any value searched of "
    return f"{'stable' if x.stable else 'unstable'} for all values searched of "


def _is_open(row: Nearest, low: Critical | None, high: Critical | None) -> bool:
    """Whether what is stable may have an end beyond what was searched."""
    return (low is None and row.low is not None) or (high is None and row.high is not None)


def _reach(found: Stability, row: Nearest) -> float:
    """How near its nearest limit is, relative to the value."""
    knob = found.scene.knobs[row.path]
    return min((_distance(knob, x) for x in row.found), default=inf)


def _margins(found: Stability) -> Iterator[Block]:
    """By how much the rendered force may change in each hand."""
    rows = [(x.hand.name, own) for x, own in zip(found.held, found.margins, strict=True) if own]
    if not rows:
        return

    def sides(of: Callable[[Limit, Way], Phrase]) -> w.Cell:
        def cell(row: tuple[str, Margins]) -> Phrase:
            below, above = row[1].below, row[1].above
            if "gain" in dict(row[1].undecided):
                return Strong("undecided")
            low, high = below and of(below, Way.UP), above and of(above, Way.DOWN)
            return (low, " to ", high) if low and high else ("> ", low) if low else ("< ", high) if high else "any"

        return cell

    def one(name: str, of: Callable[[Margins], Limit | None], size: Expr) -> w.Cell:
        def cell(row: tuple[str, Margins]) -> Phrase:
            x = of(row[1])
            none = Strong("undecided") if name in dict(row[1].undecided) else "any"
            return none if x is None else doc.Real(in_unit(x.value, size), Way.DOWN)

        return cell

    phase = [w.number("phase (deg)", one("phase_deg", lambda x: x.phase, Integer(1)))] * (not clocks(found.scene))
    yield doc.Section(
        "Margins: how much the rendered force may change",
        (
            w.table(
                rows, "By which factor, and by how much more delay or angle at one frequency, until it is unstable.",
                w.Field("hand", lambda x: x[0]), w.Field("factor", sides(lambda x, way: doc.Real(x.value, way))),
                w.Field("dB", sides(lambda x, way: doc.Real(20 * log10(float(x.value)), way, most=3))),
                w.number("more delay (ms)", one("delay", lambda x: x.delay, Rational(1, 1000))), *phase,
            ),
            *w.noted([_SEARCHED, *map(w.undecided, _open_margins(rows))]),
        ),
    )  # fmt: skip


_SEARCHED = f"Searched: factors from 0.001 to {MOST_GAIN}, delays up to {MOST_DELAY} s; any: no limit in that range."
_MARGINS = {"gain": "factor", "delay": "more delay", "phase_deg": "phase"}


def _open_margins(rows: Sequence[tuple[str, Margins]]) -> Iterator[Phrase]:
    """The margins that are not known, and why: those with the same reason together."""
    left: dict[str, list[tuple[str, str]]] = {}
    for hand, x in rows:
        for name, why in x.undecided:
            left.setdefault(why, []).append((hand, _MARGINS[name]))
    for why, found in left.items():
        hands_, names = (listed(dict.fromkeys(x)) for x in zip(*found, strict=True))
        yield names, " in ", hands_, f": {why}"


def _name_and_unit(knob: Knob) -> Phrase:
    shown = knob.shown_unit(knob.motion).text
    return _name(knob), f" ({shown})" if shown else ""


def _names(found: Stability, rows: Sequence[Nearest]) -> Iterator[Phrase]:
    return (_name(found.scene.knobs[row.path]) for row in rows)


def _searched(found: Stability, rows: Sequence[Nearest]) -> Iterator[Phrase]:
    """Parameters of which not all values were searched, and which were."""
    for row in rows:
        if row.low is not None or row.high is not None:
            knob = found.scene.knobs[row.path]
            yield _name(knob), _range(knob, row.low, row.high)


def _range(knob: Knob, low: Fraction | None, high: Fraction | None) -> Phrase:
    first: Phrase = (" from ", w.bare(w.value_of(knob, low, Way.UP))) if low else ""
    return (first, " up to ", w.value_of(knob, high, Way.DOWN)) if high is not None else (first, "")


def _stable_for(knob: Knob, low: Critical | None, high: Critical | None) -> Phrase:
    """Values for which it is stable, in a row of the parameter."""
    least, most = _ends(knob, low, high)
    if low is high:
        return least, " alone"
    return _between(knob, low, high) if low and high else ("> ", least) if low else ("< ", most)


def _places(windows: Sequence[Window]) -> Iterator[Phrase]:
    """The frequencies of the poles at the ends of what is stable."""
    for low, high in windows:
        yield from (_place(x) for x in dict.fromkeys((low, high)) if x)


def _place(x: Critical) -> Phrase:
    return "from infinity" if x.omega is None else w.cell(x.omega)


# Prescribed motion, and passivity.


def _prescribed(found: Stability) -> Phrase:
    x = found.imposed
    if x.stable is None:
        why = f": {x.reason}" if x.reason else ""
        return Strong("undecided"), ", whether all poles of ", w.H_PERC, " lie in ", _LEFT, f"{why}."
    if x.stable:
        return "stable", "; infinitely many poles come arbitrarily near to the imaginary axis." if x.chain else "."
    if x.chain is RootChain.NEAR:
        return Strong("unstable"), ": ", w.H_PERC, " has poles on the imaginary axis."
    if x.chain:
        return Strong("unstable"), ": of the poles of ", w.H_PERC, f", {_CHAINS[x.chain]}."
    count = "at least one pole" if x.unstable is None else f"{x.unstable} pole{'' if x.unstable == 1 else 's'}"
    return Strong("unstable"), f": {count} of ", w.H_PERC, " in ", _RIGHT, "."


def _passivity(found: Stability) -> Iterator[Phrase]:
    """Where the display is active, and what compensates it."""
    x = found.every_passive_hand
    p, sampled = x.passivity, x.sampled
    if p is not None and p.active:
        yield "Active (", _IM, " < 0) ", _bands(p), "."
    if sampled is not None:
        yield from _sampled(sampled, found.scene)
        return
    if p is None:
        return
    if p.holds is False and p.poles_allow is False:
        where = "/s to the right, on the axis, at 0 or at ∞"
        yield "A pole of ", w.H_PERC, where, " prevents passivity, for any damping of the hand."
    if p.is_unbounded:
        yield w.endless()
    elif p.is_active and p.damping:
        if p.poles_allow:
            yield w.enough_damping(w.at_most(p.damping.value), found.scene)
    elif p.is_active and p.beyond is not Beyond.CLOCK:
        yield w.undecided(("how large −", _IM, "/", w.OMEGA, " becomes"))


def _sampled(x: SampledPassivity, scene: Scene) -> Iterator[Phrase]:
    if x.pushes:
        value = w.at_least(ExactNumber(x.at_rest)), f" {w.stiffness_unit(scene)}"
        yield "The stiffness of the display at rest is negative (", *value, "): no damping compensates it."
    elif x.passive is False and x.hand_needed is not None:
        yield w.enough_damping(w.at_most(x.hand_needed), scene)


def _bands(p: Passivity) -> Phrase:
    shown = [w.span(x) for x in p.active[:_MOST]]
    if p.beyond is Beyond.ALWAYS and len(p.active) <= _MOST:
        shown[-1] = ("above ", w.both(p.active[-1].low.omega))
    more = [f"{len(p.active) - _MOST} more intervals"] if len(p.active) > _MOST else []
    again = [("at infinitely many frequencies above ", w.both(ExactNumber(p.high)))] if p.beyond is Beyond.AGAIN else []
    return listed([*shown, *more, *again]), not_looked_at(p) if p.beyond is Beyond.LATE else ""


def _proven(found: Stability) -> Iterator[Phrase]:
    parts = ["pole counts", *(["limits"] if any(found.critical) else []), "passivity"]
    what = f"{', '.join(parts[:-1])} and {parts[-1]}"
    matrices = (x for effect in found.scene.effects for x in effect.dynamics)
    delays = ", with every delay exact" if any(x.has(exp) for x in matrices) else ""
    of = ", for the exact sampled loop" if found.sampled is not None else delays
    if not found.certified:
        yield f"Proven: {what}, but for what is marked undecided."
        return
    yield w.proof(found.scene, f"{what}{of}")
