"""The page of stability: each hand, any passive operator, and prescribed motion, which are three
statements; the limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import inf, log10

from sympy import Expr, Integer, Rational, exp

from haptisym.judge.colgate import SampledPassivity
from haptisym.judge.passivity import Beyond, Passivity
from haptisym.kernel.reals import ExactNumber, RealNumber, Way, in_unit
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.sets import UNSEARCHED, SingleValue, ValueSet, Verdict
from haptisym.model.catalogue import Hand, hands
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.pages import words as w
from haptisym.pages.evaluation import not_looked_at
from haptisym.verbs.stability.entry import Stability, has_plane
from haptisym.verbs.stability.held import HandsOfBox, Held, Share
from haptisym.verbs.stability.limits import looked_at, open_beside
from haptisym.verbs.stability.margins import MOST_DELAY, MOST_GAIN, Margins
from haptisym.writing import document as doc
from haptisym.writing.boxes import Prefixed
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, Strong, listed
from haptisym.writing.layout import named

_IM = Prefixed(w.OPERATORS[Part.IMAG], w.H_PERC)
_REAL = Prefixed(w.OPERATORS[Part.REAL], named("s"))
_LEFT, _RIGHT = w.compared(_REAL, "<"), w.compared(_REAL, "≥")
_PLANE = (
    "Hands of one mass: where the display is stable in them, and the number of unstable poles "
    "where it is not."
)
_WALLS = (
    "Sampled walls: where the display is stable with them, and the number of unstable poles "
    "(|z|\xa0≥\xa01) where it is not."
)
_MOST = 6  # active intervals that are printed
_FEW = 2  # limits that the answer has of a hand
_CHAINS = {
    RootChain.RIGHT: "infinitely many poles lie to the right of the imaginary axis: the highest power of s is "
    "delayed (the "
    "system is neutral, or advanced)",
    RootChain.NEAR: "infinitely many poles come arbitrarily near to the imaginary axis: the system is neutral",
}


def page(found: Stability) -> Document:
    """The whole page."""
    is_sampled = bool(clocks(found.scene))
    drawn = (
        (doc.Figure("plane", _WALLS if is_sampled else _PLANE, found.figure),)
        if has_plane(found.scene)
        else ()
    )
    blocks = (
        *_hands(found),
        *_limits(found),
        *_margins(found),
        *drawn,
        *w.noted((("Prescribed motion: ", _prescribed(found)), *_passivity(found))),
        w.certificate(found, found.scene),
    )
    return w.page_about(
        found.scene, _answer(found), blocks, _proven(found), "Stability", found.asides()
    )


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
        return (
            Strong("unstable"),
            " (poles on the imaginary axis at ",
            listed(map(w.both, on_axis)),
            ")",
        )
    return Strong("unstable"), f" ({x.unstable} unstable pole{'' if x.unstable == 1 else 's'})"


def _nearest_limits(found: Stability, x: Held, sets: Mapping[str, ValueSet]) -> Phrase:
    """Of a stable display how far the nearest parameters may go; of an unstable one what makes it
    stable."""
    if not (x.stable or x.shakes):
        return ""
    told: list[tuple[float, Phrase]] = []
    for path, values in sets.items():
        knob = found.scene.knobs[path]
        for piece in (
            y for y in values.feasible if not y.is_single
        ):  # a single value is in the table alone
            limits = [y for y in piece.ends if y in values.ends]
            if x.stable:
                ends = (
                    (("down to ", Way.UP) if y is piece.first else ("up to ", Way.DOWN), y)
                    for y in limits
                )
                told += [
                    (
                        _distance(knob, y),
                        (words, _name(knob), " = ", w.value_of(knob, y.value, way)),
                    )
                    for (words, way), y in ends
                ]
            else:
                now = w.value_of(knob, ExactNumber(knob.value), Way.NEAREST)
                reach = min((_distance(knob, y) for y in limits), default=inf)
                told.append(
                    (reach, (w.values_in(piece, values, knob, _name(knob)), " (is ", now, ")"))
                )
    few = [words for _, words in sorted(told, key=lambda y: y[0])[:_FEW]]
    so = ": " if x.stable else ": does not shake for " if x.drifts else ": needs "
    return (so, listed(few, "and" if x.stable else "or")) if few else ""


def _distance(knob: Knob, x: SingleValue) -> float:
    """From the value that a parameter has, relative to it."""
    now = float(knob.value)
    return abs(float(x.value) - now) / (abs(now) or 1)


def _any_operator(found: Stability) -> Phrase:
    x = found.every_passive_hand
    if x.holds:
        return Strong("passive"), ": stable in the hand of any passive operator"
    if x.holds is None:
        p = x.passivity
        why: Phrase = x.reason if p is None or x.sampled is not None else _why_open(p)
        return Strong("undecided"), " whether it is passive", (": ", why) if why else ""
    return Strong("not passive"), _needs(
        x.sampled, w.unit(Dimension.DAMPING, found.scene.motion)
    ) if x.sampled else ""


def _needs(x: SampledPassivity, damping: str) -> Phrase:
    """What Colgate and Schenkel's condition asks of the device's damping."""
    if x.sides is None:
        return ""
    has = " (is ", w.near(ExactNumber(x.damping)), ")"
    if x.needed is None or x.pushes:
        return ": no damping of the device is enough"
    if x.asks_nothing:
        return ": needs device damping ≥ 0", *has
    return (
        (": needs device damping > ", w.at_most(x.needed.value), f" {damping}", *has)
        if x.passive is False
        else ""
    )


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
    units = [
        w.unit(x, found.scene.motion)
        for x in (Dimension.MASS, Dimension.DAMPING, Dimension.STIFFNESS)
    ]
    keys = (
        w.number((named(key), f" ({unit_})"), _of_hand(i))
        for i, (key, unit_) in enumerate(zip("mbk", units, strict=True))
    )
    notes = [_box(x.hand, box) for x, box in zip(found.held, found.boxes, strict=True) if box]
    notes += [
        f"{x.hand.name}: no motion grows, as all parts are passive."
        for x in found.held
        if _only_near(found, x)
    ]
    shown = w.table(
        found.held,
        "The display in each hand.",
        w.Field("hand", lambda x: x.hand.name),
        *keys,
        w.Field("stable", _stable),
        w.number("unstable poles", _count),
    )
    yield doc.Section("Does it shake?", (shown, *w.noted(notes)))


def _only_near(found: Stability, x: Held) -> bool:
    """Whether a chain of poles that comes to the axis is known to stay on its left."""
    p = found.every_passive_hand.passivity
    return bool(
        x.roots is not None and x.roots.chain is RootChain.NEAR and p and p.has_passive_parts
    )


def _stable(x: Held) -> Phrase:
    drifts = x.shakes is False and x.drifts
    return (
        Strong("undecided")
        if x.stable is None
        else "yes"
        if x.stable
        else "drifts"
        if drifts
        else Strong("no")
    )


def _count(x: Held) -> str:
    """How many poles are unstable, where that is known."""
    if (
        x.roots is None or x.roots.chain is RootChain.NEAR
    ):  # of a chain that only comes near, none need lie there
        return "" if x.roots is None else "a chain near the axis"
    return "infinite" if x.unstable is None else str(x.unstable)


def _box(hand: Hand, box: HandsOfBox) -> Phrase:
    """In which hands of given ranges it is stable."""
    within = [(p.key, *map(ExactNumber, p.interval)) for p in hand.parameters if p.interval]
    ranges = listed(
        (named(str(key)), " from ", w.near(low), " to ", w.near(high)) for key, low, high in within
    )
    if box.share is None:
        return w.undecided((f"{hand.name} with ", ranges, f": {box.reason}"))
    verdict: dict[Share, Phrase] = {
        Share.ALL: "stable in all of these hands",
        Share.SOME: (Strong("not"), " stable in all of these hands, but in some"),
        Share.NONE: (Strong("not"), " stable in any of these hands"),
    }
    return f"{hand.name} with ", ranges, ": ", verdict[box.share], "."


def _limits(found: Stability) -> Iterator[Block]:
    """What is stable of each parameter, one varied at a time, the nearest first; those that change
    nothing in a line."""
    lines: list[tuple[str, Knob, ValueSet]] = []
    notes: list[Phrase] = []
    for x, sets in zip(found.held, found.critical, strict=True):
        rows = [(found.scene.knobs[path], values) for path, values in sets.items()]
        shown = sorted(((knob, y) for knob, y in rows if y.ends), key=lambda row: _reach(*row))
        lines += [("" if i else x.hand.name, *row) for i, row in enumerate(shown)]
        notes += _notes(x, rows)
    holds = "does not shake for" if any(x.drifts for x in found.held) else "stable for"
    limits = w.table(
        lines,
        (
            "The values, next to the present ones, for which it is stable, and the frequency of "
            "the pole at each end."
        ),
        w.Field("hand", lambda x: x[0]),
        w.Field("parameter", lambda x: _name_and_unit(x[1])),
        w.Field("is", lambda x: w.bare(w.value_of(x[1], ExactNumber(x[1].value), Way.NEAREST))),
        w.Field(
            holds, lambda x: (_least(*x[1:]), w.values_of(x[2], x[1], _name(x[1]), in_table=True))
        ),
        w.Field(
            ("pole at limit (", FREQUENCY_UNIT, ")"), lambda x: listed(_place(y) for y in x[2].ends)
        ),
    )
    if lines or notes:
        blocks = (limits,) if lines else ()
        yield doc.Section(
            "Stability limits, one parameter varied at a time", (*blocks, *w.noted(notes))
        )


def _notes(x: Held, rows: Sequence[tuple[Knob, ValueSet]]) -> Iterator[Phrase]:
    """Of a hand: which parameters change nothing, how far was searched, and what stayed open."""
    looked = [(knob, looked_at(knob, values), values) for knob, values in rows]
    none = [
        (knob, ends)
        for knob, ends, values in looked
        if not (values.ends or any(open_beside(knob, values)))
    ]
    if none:
        ends, kept = listed(_searched(none)), listed(_name(knob) for knob, _ in none)
        yield f"{x.hand.name}: {_kept(x)}", kept, (" (", ends, ")") if ends else "", "."
    further = [
        (knob, ends) for knob, ends, values in looked if values.ends and _least(knob, values)
    ]
    if ends := listed(_searched(further)):
        yield f"{x.hand.name}: searched ", ends, "."
    why: dict[str, list[Phrase]] = {}
    for knob, values in rows:
        for reason in open_beside(knob, values):
            why.setdefault(reason, []).append(_name(knob))
    for reason, names in why.items():
        yield w.undecided((listed(names), f" in {x.hand.name}: {reason}"))


def _least(knob: Knob, values: ValueSet) -> str:
    """Whether what is stable may go on beyond what is known of it."""
    open_ = [
        y for side in (-1, 1) if (y := values.unknown(ExactNumber(knob.value), side)) is not None
    ]
    points = [y for piece in open_ for y in piece.ends]
    return "at least " if any(y in points for piece in values.feasible for y in piece.ends) else ""


def _name(knob: Knob) -> Phrase:
    """A parameter by its symbol; a hand's by its path."""
    return f"hand.{knob.key}" if knob.is_of_hand else named(knob.symbol.name)


def _name_and_unit(knob: Knob) -> Phrase:
    shown = knob.shown_unit(knob.motion).text
    return _name(knob), f" ({shown})" if shown else ""


def _kept(x: Held) -> str:
    """What holds where no value changes anything."""
    if x.shakes is False and x.drifts:
        return "does not shake for any value searched of "
    return f"{'stable' if x.stable else 'unstable'} for all values searched of "


def _reach(knob: Knob, values: ValueSet) -> float:
    """How near its nearest limit is, relative to the value."""
    return min(_distance(knob, x) for x in values.ends)


def _searched(
    rows: Iterable[tuple[Knob, tuple[RealNumber | None, RealNumber | None]]],
) -> Iterator[Phrase]:
    """Parameters of which not all values were searched, and which were."""
    for knob, (low, high) in rows:
        if low is not None or high is not None:
            first: Phrase = "" if low is None else (" from ", w.bare(w.value_of(knob, low, Way.UP)))
            last: Phrase = "" if high is None else (" up to ", w.value_of(knob, high, Way.DOWN))
            yield _name(knob), first, last


def _place(x: SingleValue) -> Phrase:
    omega = x.bindings[0].omega
    return "from infinity" if omega is None else w.cell(omega)


# Margins.


def _margins(found: Stability) -> Iterator[Block]:
    """By how much the rendered force may change in each hand."""
    rows = [(x.hand.name, own) for x, own in zip(found.held, found.margins, strict=True) if own]
    if not rows:
        return

    def gain(of: Callable[[RealNumber, Way], Phrase]) -> w.Cell:
        return lambda row: _factors(row[1], of)

    phase = [w.number("phase (deg)", lambda x: _up_to(x[1].phase, Integer(1)))] * (
        not clocks(found.scene)
    )
    yield doc.Section(
        "Margins: how much the rendered force may change",
        (
            w.table(
                rows,
                (
                    "By which factor, and by how much more delay or angle at one frequency, "
                    "until it is unstable."
                ),
                w.Field("hand", lambda x: x[0]),
                w.Field("factor", gain(doc.Real)),
                w.Field("dB", gain(lambda x, way: doc.Real(20 * log10(float(x)), way, most=3))),
                w.number("more delay (ms)", lambda x: _up_to(x[1].delay, Rational(1, 1000))),
                *phase,
            ),
            *w.noted([_SEARCHED, *map(w.undecided, _open_margins(rows))]),
        ),
    )


def _factors(x: Margins, of: Callable[[RealNumber, Way], Phrase]) -> Phrase:
    """From which factor to which one it is stable; of a side on which that is not known as far as
    it is."""
    about, at_1 = x.gain.about(ExactNumber(Integer(1))), ExactNumber(Integer(1))
    if about.verdict is Verdict.UNDECIDED or about.low is None or about.high is None:
        return Strong("undecided")
    low, high = of(about.low, Way.UP), of(about.high, Way.DOWN)
    if any(x.gain.unknown(at_1, side) for side in (-1, 1)):
        return "at least ", low, " to ", high
    if x.below is None:
        return "any" if x.above is None else ("< ", high)
    return ("> ", low) if x.above is None else (low, " to ", high)


def _up_to(x: ValueSet | None, size: Expr) -> Phrase:
    """The delay, or the angle, up to which it is stable, or is known to be."""
    zero = ExactNumber(Integer(0))
    if x is None:
        return ""
    about, end, more = x.about(zero), x.end(zero, 1), x.unknown(zero, 1)
    if end is not None:
        return doc.Real(in_unit(end.value, size), Way.DOWN)
    if more is None:
        return "any"
    if about.verdict is Verdict.UNDECIDED or about.is_single or about.high is None:
        return Strong("undecided")
    beyond = "; not searched above" if more.reason == UNSEARCHED else ""
    return "at least ", doc.Real(in_unit(about.high, size), Way.DOWN), beyond


_SEARCHED = (
    f"Searched: factors from 0.001 to {MOST_GAIN}, delays up to {MOST_DELAY} s; any: no limit in "
    f"that range."
)
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


# Prescribed motion, and passivity.


def _prescribed(found: Stability) -> Phrase:
    x = found.imposed
    if x.stable is None:
        why = f": {x.reason}" if x.reason else ""
        return (
            Strong("undecided"),
            ", whether all poles of ",
            w.H_PERC,
            " lie in ",
            _LEFT,
            f"{why}.",
        )
    if x.stable:
        return (
            "stable",
            "; infinitely many poles come arbitrarily near to the imaginary axis."
            if x.chain
            else ".",
        )
    if x.chain is RootChain.NEAR:
        return Strong("unstable"), ": ", w.H_PERC, " has poles on the imaginary axis."
    if x.chain:
        return Strong("unstable"), ": of the poles of ", w.H_PERC, f", {_CHAINS[x.chain]}."
    count = (
        "at least one pole"
        if x.unstable is None
        else f"{x.unstable} pole{'' if x.unstable == 1 else 's'}"
    )
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
        yield (
            "The stiffness of the display at rest is negative (",
            *value,
            "): no damping compensates it.",
        )
    elif x.passive is False and x.hand_needed is not None:
        yield w.enough_damping(w.at_most(x.hand_needed), scene)


def _bands(p: Passivity) -> Phrase:
    shown = [w.span(x) for x in p.active[:_MOST]]
    if p.beyond is Beyond.ALWAYS and len(p.active) <= _MOST:
        shown[-1] = ("above ", w.both(p.active[-1].low.omega))
    more = [f"{len(p.active) - _MOST} more intervals"] if len(p.active) > _MOST else []
    again = (
        [("at infinitely many frequencies above ", w.both(ExactNumber(p.high)))]
        if p.beyond is Beyond.AGAIN
        else []
    )
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
