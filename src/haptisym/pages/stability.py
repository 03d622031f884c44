"""The page of stability: three statements, and the limits of each parameter.

The display in each given hand (no root of H_perc + H_hand in Re s >= 0), in the hand of any passive
operator (H_perc is passive), and under prescribed motion (no pole of H_perc there). None of the
three stands for another. Begin with ``page``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, log10
from typing import TYPE_CHECKING

from sympy import Expr, Integer, Rational, exp

from haptisym.judge.colgate import SampledPassivity
from haptisym.judge.passivity import Beyond, Passivity, has_advance
from haptisym.kernel.reals import ExactNumber, RealNumber, Way, in_unit
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.sets import UNSEARCHED, SingleValue, ValueSet, Verdict
from haptisym.model.catalogue import Hand, hands
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, MotionKind
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

if TYPE_CHECKING:
    from haptisym.verbs.stability.limitcycles import LimitCycle

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
    RootChain.RIGHT: "infinitely many poles lie to the right of the imaginary axis: the highest "
    "power of s is delayed (the "
    "system is neutral, or advanced)",
    RootChain.NEAR: "infinitely many poles come arbitrarily near to the imaginary axis: the system "
    "is neutral",
}


def page(found: Stability) -> Document:
    """Return the whole page of a stability question."""
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
        *limit_cycle_table(
            found.scene.motion,
            [
                (x.hand.name, cycle)
                for x, cycles in zip(found.held, found.limit_cycles, strict=True)
                for cycle in cycles or ()
            ],
        ),
        *drawn,
        *w.noted((("Prescribed motion: ", _prescribed(found)), *_passivity(found))),
        *w.caveats(found.caveats),
    )
    return w.page_about(
        found.scene, _answer(found), blocks, _proven(found), "Stability", found.asides()
    )


# The answer.


def _answer(found: Stability) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield a line for each hand, and one for any passive operator."""
    if not found.held:
        shipped = ", ".join(hands)
        yield "Hand", ("none given", doc.Brief(f": --hand NAME; the package ships {shipped}"))
    in_hand = w.of_linear_model(found.scene, in_hand=True)
    for x, rows in zip(found.held, found.critical, strict=True):
        of = in_hand if x.roots else ""
        yield x.hand.name, (_verdict(x), of, _nearest_limits(found, x, rows))
    is_open = found.every_passive_hand.holds is None
    model = "" if is_open else w.of_linear_model(found.scene)
    yield "Any operator", (_any_operator(found), model)


def _verdict(held: Held) -> Phrase:
    """Return the verdict in one hand: stable, drifting, unstable with its poles, or undecided."""
    if held.roots is None:
        return Strong("undecided"), ": ", held.reason
    if held.stable:
        return Strong("stable"), ""
    # Its only unstable roots are at s = 0, as nothing holds the handle in place: that is no
    # oscillation.
    if held.shakes is False and held.drifts:
        return "does not shake; drifts: nothing holds it in place"
    if held.roots.chain is not None:
        return Strong("unstable"), ": ", _CHAINS[held.roots.chain]
    # The first place on the axis is 0 where it drifts. The others are pairs, at omega and -omega:
    # hence twice as many poles.
    on_axis = held.on_axis[bool(held.drifts) :]
    if on_axis and len(on_axis) * 2 >= (held.unstable or 0):
        return (
            Strong("unstable"),
            " (poles on the imaginary axis at ",
            listed(map(w.both, on_axis)),
            ")",
        )
    return Strong(
        "unstable"
    ), f" ({held.unstable} unstable pole{'' if held.unstable == 1 else 's'})"


def _nearest_limits(found: Stability, held: Held, sets: Mapping[str, ValueSet]) -> Phrase:
    """Return, of a stable display, how far the nearest parameters may go; of an unstable one, which
    values make it stable."""
    if not (held.stable or held.shakes):
        return ""
    candidates: list[tuple[float, Phrase]] = []
    for path, values in sets.items():
        knob = found.scene.knobs[path]
        # A single value for which it is stable is no limit; the table has it.
        for piece in (y for y in values.feasible if not y.is_single):
            # Ends of the search are no limits: nothing changes there.
            limits = [y for y in piece.ends if y in values.ends]
            if held.stable:
                # Rounded into the stable side: a lower limit upwards, an upper one downwards.
                ends = (
                    (("down to ", Way.UP) if y is piece.first else ("up to ", Way.DOWN), y)
                    for y in limits
                )
                candidates += [
                    (
                        _distance(knob, y),
                        (words, _name(knob), " = ", w.value_of(knob, y.value, way)),
                    )
                    for (words, way), y in ends
                ]
            else:
                now = w.value_of(knob, ExactNumber(knob.value), Way.NEAREST)
                reach = min((_distance(knob, y) for y in limits), default=inf)
                candidates.append(
                    (reach, (w.values_in(piece, values, knob, _name(knob)), " (is ", now, ")"))
                )
    few = [words for _, words in sorted(candidates, key=lambda y: y[0])[:_FEW]]
    so = ": " if held.stable else ": does not shake for " if held.drifts else ": needs "
    return (so, listed(few, "and" if held.stable else "or")) if few else ""


def _distance(knob: Knob, x: SingleValue) -> float:
    """Return how far a limit is from the present value, relative to that where it is not 0."""
    now = float(knob.value)
    return abs(float(x.value) - now) / (abs(now) or 1)


def _any_operator(found: Stability) -> Phrase:
    """Return whether the display is passive, and what it lacks."""
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


def _needs(condition: SampledPassivity, damping: str) -> Phrase:
    """Return the damping of the device that Colgate and Schenkel's condition requires."""
    if condition.sides is None:
        return ""
    has = " (is ", w.near(ExactNumber(condition.damping)), ")"
    # A display that pushes at rest is unstable with any damping; and no damping exceeds a right-
    # hand side that has no bound.
    if condition.needed is None or condition.pushes:
        return ": no damping of the device is enough"
    if condition.asks_nothing:
        return ": needs device damping ≥ 0", *has
    return (
        (": needs device damping > ", w.at_most(condition.needed.value), f" {damping}", *has)
        if condition.passive is False
        else ""
    )


def _why_open(p: Passivity) -> Phrase:
    """Return why passivity is undecided: the places of the poles, or the sign above the band that
    was searched."""
    if p.beyond is Beyond.NEVER:
        return _IM, " ≥ 0 at all frequencies, but where poles lie is undecided"
    return "above ", w.both(ExactNumber(p.high)), " the sign of ", _IM, f" is {p.beyond.value}"


# Each hand, and the limits.


def _of_hand(i: int) -> w.Cell:
    """Return the cell of one parameter of a hand: mass, damping or stiffness."""
    return lambda x: w.near(ExactNumber(x.hand.parameters[i].value))


def _hands(found: Stability) -> Iterator[Block]:
    """Yield the table of the hands: parameters, verdicts, counts of unstable poles."""
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
    # Passive parts cannot make a motion grow, so poles that come near to the axis stay on its left.
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


def _only_near(found: Stability, held: Held) -> bool:
    """Whether a chain of poles that comes to the axis is known to stay on its left."""
    passivity = found.every_passive_hand.passivity
    return bool(
        held.roots is not None
        and held.roots.chain is RootChain.NEAR
        and passivity
        and passivity.has_passive_parts
    )


def _stable(held: Held) -> Phrase:
    """Return whether the display is stable in one hand, in a word."""
    return _in_a_word(held, "yes", "no")


def _in_a_word(held: Held, stable: str = "stable", unstable: str = "unstable") -> Phrase:
    """Return the verdict on one hand in a word."""
    if held.stable is None:
        return Strong("undecided")
    if held.stable:
        return stable
    return "drifts" if held.shakes is False and held.drifts else Strong(unstable)


def _count(held: Held) -> str:
    """How many poles are unstable, where that is known."""
    # Of a chain of poles that only comes near to the axis none need lie on its right.
    if held.roots is None or held.roots.chain is RootChain.NEAR:
        return "" if held.roots is None else "a chain near the axis"
    return "infinite" if held.unstable is None else str(held.unstable)


def _box(hand: Hand, box: HandsOfBox) -> Phrase:
    """Return in how many hands of given ranges the display is stable: all, some, or none."""
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
    """Yield the stable values of each parameter, one varied at a time, the nearest limit first;
    those without a limit in a line."""
    lines: list[tuple[Phrase, Knob, ValueSet]] = []
    notes: list[Phrase] = []
    for x, sets in zip(found.held, found.critical, strict=True):
        rows = [(found.scene.knobs[path], values) for path, values in sets.items()]
        shown = sorted(((knob, y) for knob, y in rows if y.ends), key=lambda row: _reach(*row))
        # Name and verdict stand in the first two of its rows alone; the heading says so, as on a
        # narrow terminal each row is a list of its own.
        leads: list[Phrase] = [x.hand.name, _in_a_word(x)]
        if len(shown) == 1:
            leads = [(x.hand.name, ": ", _in_a_word(x))]
        leads += [""] * len(shown)
        lines += [(lead, *row) for lead, row in zip(leads, shown, strict=False)]
        notes += _notes(x, rows)
    holds = "does not shake for" if any(x.drifts for x in found.held) else "stable for"
    limits = w.table(
        lines,
        (
            "The values, next to the present ones, for which it is stable, and the frequency of "
            "the pole at each end."
        ),
        w.Field("hand, verdict", lambda x: x[0]),
        w.Field("parameter", lambda x: _name_and_unit(x[1])),
        w.Field("is", lambda x: w.bare(w.value_of(x[1], ExactNumber(x[1].value), Way.NEAREST))),
        w.Field(
            holds, lambda x: (_least(*x[1:]), w.values_of(x[2], x[1], _name(x[1]), in_table=True))
        ),
        w.Field(
            ("pole at limit (", FREQUENCY_UNIT, ")"), lambda x: listed(_place(y) for y in x[2].ends)
        ),
    )
    # In a paper stand the limits: the table of the hands is what was asked.
    limits = replace(limits, main=True)
    if lines or notes:
        blocks = (limits,) if lines else ()
        yield doc.Section(
            "Stability limits, one parameter varied at a time", (*blocks, *w.noted(notes))
        )


def _notes(x: Held, rows: Sequence[tuple[Knob, ValueSet]]) -> Iterator[Phrase]:
    """Yield, of one hand, which parameters change nothing, how far was searched, and what stayed
    undecided."""
    looked = [(knob, looked_at(knob, values), values) for knob, values in rows]
    # Proven to change nothing: no limit, and nothing open on either side of the present value.
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
    # A stable interval that ends where the unknown begins may in truth go on: only a part of it is
    # proven.
    open_ = [
        y for side in (-1, 1) if (y := values.unknown(ExactNumber(knob.value), side)) is not None
    ]
    points = [y for piece in open_ for y in piece.ends]
    return "at least " if any(y in points for piece in values.feasible for y in piece.ends) else ""


def _name(knob: Knob) -> Phrase:
    """A parameter by its symbol; a hand's by its path."""
    return f"hand.{knob.key}" if knob.is_of_hand else named(knob.symbol.name)


def _name_and_unit(knob: Knob) -> Phrase:
    """Return a parameter with its unit in brackets."""
    shown = knob.shown_unit(knob.motion).text
    return _name(knob), f" ({shown})" if shown else ""


def _kept(held: Held) -> str:
    """Return the words for parameters no value of which changes the verdict."""
    if held.shakes is False and held.drifts:
        return "does not shake for any value searched of "
    return f"{'stable' if held.stable else 'unstable'} for all values searched of "


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
            last: Phrase = "" if high is None else (" up to ", w.reach_of(knob, high, Way.DOWN))
            yield _name(knob), first, last


def _place(x: SingleValue) -> Phrase:
    """Return where on the axis a pole is at a limit; from infinity for one of a chain."""
    omega = x.bindings[0].omega
    return "from infinity" if omega is None else w.cell(omega)


# Margins.


def _margins(found: Stability) -> Iterator[Block]:
    """Yield by how much the rendered force may change in each hand."""
    rows = [
        (x.hand.name, margins)
        for x, margins in zip(found.held, found.margins, strict=True)
        if margins
    ]
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
                # A logarithm in floats is correct to far more than the three digits that are
                # printed.
                w.Field("dB", gain(lambda x, way: doc.Real(20 * log10(float(x)), way, most=3))),
                w.number("more delay (ms)", lambda x: _up_to(x[1].delay, Rational(1, 1000))),
                *phase,
            ),
            *w.noted([_SEARCHED, *map(w.undecided, _open_margins(rows))]),
        ),
    )


def limit_cycle_table(
    motion: MotionKind | None, rows: Sequence[tuple[str, LimitCycle]]
) -> Iterator[Block]:
    """Yield the table of possible limit cycles, each with its hand; nothing without any."""
    if rows:
        unit = w.unit(rows[0][1].dimension, motion)
        shown = w.table(
            rows,
            "Where the loop with the describing function is on the axis: estimated, without "
            "harmonics. Motions near a cycle that attracts come to it, from one that does not "
            "they go away.",
            w.Field("hand", lambda x: x[0]),
            w.number(
                f"amplitude of {rows[0][1].element} ({unit})", lambda x: w.near(x[1].amplitude)
            ),
            w.hertz(lambda x: w.cell(x[1].omega)),
            w.Field("attracts", lambda x: "yes" if x[1].attracts else "no"),
        )
        yield doc.Section("Possible limit cycles (estimated: describing function)", (shown,))


def _factors(margins: Margins, of: Callable[[RealNumber, Way], Phrase]) -> Phrase:
    """Return from which factor to which one the loop is stable; on a side with an undecided rest,
    as far as that is proven."""
    about, at_1 = margins.gain.about(ExactNumber(Integer(1))), ExactNumber(Integer(1))
    # The margins are those about the present loop, at the factor 1.
    if about.verdict is Verdict.UNDECIDED or about.low is None or about.high is None:
        return Strong("undecided")
    low, high = of(about.low, Way.UP), of(about.high, Way.DOWN)
    if any(margins.gain.unknown(at_1, side) for side in (-1, 1)):
        return "at least ", low, " to ", high
    # On a side without an end every factor that was searched is stable.
    if margins.below is None:
        return "any" if margins.above is None else ("< ", high)
    return ("> ", low) if margins.above is None else (low, " to ", high)


def _up_to(values: ValueSet | None, size: Expr) -> Phrase:
    """Return the delay, or the angle, up to which the loop is proven to be stable."""
    zero = ExactNumber(Integer(0))
    if values is None:
        return ""
    about, end, unknown = values.about(zero), values.end(zero, 1), values.unknown(zero, 1)
    # Three cases: a limit that is known, no limit in the range, or an open rest, below which what
    # is stable is proven.
    if end is not None:
        return doc.Real(in_unit(end.value, size), Way.DOWN)
    if unknown is None:
        return "any"
    if about.verdict is Verdict.UNDECIDED or about.is_single or about.high is None:
        return Strong("undecided")
    beyond = "; not searched above" if unknown.reason == UNSEARCHED else ""
    return "at least ", doc.Real(in_unit(about.high, size), Way.DOWN), beyond


_SEARCHED = (
    f"Searched: factors from 0.001 to {MOST_GAIN}, delays up to {MOST_DELAY} s; any: no limit in "
    f"that range."
)
_MARGINS = {"gain": "factor", "delay": "more delay", "phase_deg": "phase"}


def _open_margins(rows: Sequence[tuple[str, Margins]]) -> Iterator[Phrase]:
    """Yield the margins that are not known, those with the same reason together."""
    reasons: dict[str, list[tuple[str, str]]] = {}
    for hand, x in rows:
        for name, why in x.undecided:
            reasons.setdefault(why, []).append((hand, _MARGINS[name]))
    for why, pairs in reasons.items():
        hands_, names = (listed(dict.fromkeys(x)) for x in zip(*pairs, strict=True))
        yield names, " in ", hands_, f": {why}"


# Prescribed motion, and passivity.


def _prescribed(found: Stability) -> Phrase:
    """Return whether the display is stable under prescribed motion, by the poles of H_perc."""
    motion = found.imposed
    if motion.stable is None:
        why = f": {motion.reason}" if motion.reason else ""
        return (
            Strong("undecided"),
            ", whether all poles of ",
            w.H_PERC,
            " lie in ",
            _LEFT,
            f"{why}.",
        )
    if motion.stable:
        return (
            "stable",
            "; infinitely many poles come arbitrarily near to the imaginary axis."
            if motion.chain
            else ".",
        )
    if motion.chain is RootChain.NEAR:
        return Strong("unstable"), ": ", w.H_PERC, " has poles on the imaginary axis."
    if motion.chain:
        return Strong("unstable"), ": of the poles of ", w.H_PERC, f", {_CHAINS[motion.chain]}."
    count = (
        "at least one pole"
        if motion.unstable is None
        else f"{motion.unstable} pole{'' if motion.unstable == 1 else 's'}"
    )
    return Strong("unstable"), f": {count} of ", w.H_PERC, " in ", _RIGHT, "."


def _passivity(found: Stability) -> Iterator[Phrase]:
    """Yield where the display is active, and what compensates it."""
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
        is_early = has_advance(p.distortion.perc)
        what: Phrase = (
            ("An advance exp(s τ) in ", w.H_PERC) if is_early else ("A pole of ", w.H_PERC, where)
        )
        yield what, " prevents passivity, for any damping of the hand."
    if p.is_unbounded:
        yield w.endless()
    elif p.is_active and p.damping:
        # Damping of the hand adds b omega to Im H_perc, and moves no pole of H_perc.
        if p.poles_allow:
            yield w.enough_damping(w.at_most(p.damping.value), found.scene)
    elif p.is_active and p.beyond is not Beyond.CLOCK:
        yield w.undecided(("how large −", _IM, "/", w.OMEGA, " becomes"))


def _sampled(condition: SampledPassivity, scene: Scene) -> Iterator[Phrase]:
    """Yield which damping of the hand compensates a sampled display that is not passive."""
    if condition.pushes:
        value = w.at_least(ExactNumber(condition.at_rest)), f" {w.stiffness_unit(scene)}"
        yield (
            "The stiffness of the display at rest is negative (",
            *value,
            "): no damping compensates it.",
        )
    elif condition.passive is False and condition.hand_needed is not None:
        yield w.enough_damping(w.at_most(condition.hand_needed), scene)


def _bands(p: Passivity) -> Phrase:
    """Return the active intervals in words, and how they go on at high frequency."""
    shown = [w.span(x) for x in p.active[:_MOST]]
    if p.beyond is Beyond.ALWAYS and len(p.active) <= _MOST:
        # The last one goes on for ever; its upper end is only that of the search.
        shown[-1] = ("above ", w.both(p.active[-1].low.omega))
    more = [f"{len(p.active) - _MOST} more intervals"] if len(p.active) > _MOST else []
    again = (
        [("at infinitely many frequencies above ", w.both(ExactNumber(p.high)))]
        if p.beyond is Beyond.AGAIN
        else []
    )
    return listed([*shown, *more, *again]), not_looked_at(p) if p.beyond is Beyond.LATE else ""


def _proven(found: Stability) -> Iterator[Phrase]:
    """Yield what is proven on this page, and for which model of the loop."""
    parts = ["pole counts", *(["limits"] if any(found.critical) else []), "passivity"]
    what = f"{', '.join(parts[:-1])} and {parts[-1]}"
    matrices = (x for effect in found.scene.effects for x in effect.dynamics)
    delays = ", with every delay exact" if any(x.has(exp) for x in matrices) else ""
    of = ", for the exact sampled loop" if found.sampled is not None else delays
    if not found.certified:
        yield w.proof(found.scene, f"{what}, but for what is marked undecided")
        return
    yield w.proof(found.scene, f"{what}{of}")
