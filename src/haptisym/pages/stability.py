"""The page of stability: imposed, held, every passive hand, a section each; with a clock, too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from sympy import Rational

from haptisym.judge.colgate import SampledPassivity
from haptisym.judge.passivity import Beyond, Passivity
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand, hands
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, unit_text
from haptisym.pages.held import not_looked_at
from haptisym.pages.late import proof
from haptisym.pages.words import (
    H_PERC,
    OMEGA,
    OPERATORS,
    both,
    certainty,
    compared,
    exactly,
    noted,
    page_about,
    rounded,
    short,
    span,
    unit,
)
from haptisym.verbs.stability.critical import Critical, Nearest
from haptisym.verbs.stability.entry import Stability, has_plane
from haptisym.verbs.stability.held import Box, EveryPassiveHand, Held, Share
from haptisym.writing.boxes import Prefixed
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Figure,
    Notes,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import named

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


_IM = Prefixed(OPERATORS[Part.IMAG], H_PERC)
_REAL = Prefixed(OPERATORS[Part.REAL], named("s"))
_LEFT, _RIGHT = compared(_REAL, "<"), compared(_REAL, "≥")
_PLANE = "Hands of one mass: where the display is stable in them, and the number of roots on the right where it is not."
_WALLS = "Walls on the clock: where the display is stable with them, and the number of roots with |z|\xa0≥\xa01 where it is not."
_MOST = 6  # active intervals that are told
_CHAINS = {
    RootChain.RIGHT: "infinitely many roots lie to the right of the imaginary axis: the highest power of s comes late too "
    "(the system is neutral), or late alone (advanced)",
    RootChain.NEAR: "infinitely many roots come as near to the imaginary axis as one likes: the system is neutral",
}


def page(found: Stability) -> Document:
    """The whole page."""
    drawn = (
        (Figure("plane", _WALLS if clocks(found.scene) else _PLANE, found.figure),) if has_plane(found.scene) else ()
    )
    blocks = (
        Section("Imposed: the force under imposed motion", (Paragraph(_imposed(found)),)),
        Section("Held: the display in a hand", (*_held(found), *drawn)),
        Section("Every passive hand", tuple(_every(found.every_passive_hand, *_units(found)[1:]))),
        Paragraph(_certain(found)),
        proof(found, found.scene),
    )
    return page_about(found.scene, blocks, "Stability", found.asides())


def _imposed(found: Stability) -> Phrase:
    x = found.imposed
    if x.stable is None:
        return Strong("UNDECIDED"), ": whether all poles of ", H_PERC, " lie in ", _LEFT, "."
    if x.stable:
        near = "; infinitely many come as near to the imaginary axis as one likes" if x.chain else ""
        return "Stable: all poles of ", H_PERC, " lie in ", _LEFT, near, "."
    count = "" if x.unstable is None else f" {x.unstable}"
    if x.chain is RootChain.NEAR:
        return Strong("NOT"), " stable: ", H_PERC, " has poles on the imaginary axis."
    if x.chain:
        return Strong("NOT"), " stable: of the poles of ", H_PERC, f", {_CHAINS[x.chain]}."
    return Strong("NOT"), " stable: poles of ", H_PERC, " in ", _RIGHT, f":{count or ' at least one'}."


def _held(found: Stability) -> Iterator[Block]:
    if not found.held:
        ask = "No hand was given: write ", Code("[hand]"), " in the scene, or ask with ", Code("--hand NAME"), "."
        yield Paragraph((*ask, " The package ships ", listed(hands), "."))
        return
    keys = (Column((named(key), f" ({unit})"), number=True) for key, unit in zip("mbk", _units(found), strict=True))
    where = ("roots in ", _RIGHT) if found.sampled is None else "roots with |z|\xa0≥\xa01"
    columns = (Column("hand"), *keys, Column("stable"), Column(where, number=True))
    yield Table(columns, tuple(map(_row, found.held)), "The display in each hand.")
    notes: list[Phrase] = [
        (x.hand.name, ": ", _reason(x), _none_grows(found, x), ".") for x in found.held if _reason(x)
    ]
    notes += [_box(x.hand, box) for x, box in zip(found.held, found.boxes, strict=True) if box]
    yield from noted(notes)
    yield from (_going(found, x, rows) for x, rows in zip(found.held, found.critical, strict=True) if rows)


def _none_grows(found: Stability, x: Held) -> str:
    """Of a chain of roots that comes to the axis: whether it is known to stay on its left."""
    p, near = found.every_passive_hand.passivity, x.roots is not None and x.roots.chain is RootChain.NEAR
    return "; none of them grows, as all parts only take energy" if near and p and p.has_passive_parts else ""


def _box(hand: Hand, box: Box) -> Phrase:
    """In which hands of a box it is stable."""
    ranges = listed(
        (named(p.key), f" from {float(p.interval[0]):.6g} to {float(p.interval[1]):.6g}")
        for p in hand.parameters
        if p.interval
    )
    if box.share is None:
        return Strong("UNDECIDED"), f": {hand.name} with ", ranges, f": {box.reason}."
    verdict: dict[Share, Phrase] = {
        Share.ALL: "stable in all of these hands",
        Share.SOME: (Strong("NOT"), " stable in all of these hands, but in some"),
        Share.NONE: (Strong("NOT"), " stable in any of these hands"),
    }
    return f"{hand.name} with ", ranges, ": ", verdict[box.share], "."


def _going(found: Stability, x: Held, rows: tuple[Nearest, ...]) -> Section:
    """How far each number may go."""
    heads = ("number", False), ("critical at", True), ("in", False), ("stable", False), ((OMEGA, " (rad/s)"), True)
    columns = tuple(Column(words, number=is_number) for words, is_number in heads)
    lines = tuple(_critical(found, one) for near in rows for one in near.found)
    caption = (
        "The nearest values, either way, at which the number of roots that shake changes, and where it then oscillates."
    )
    blocks: list[Block] = [Table(columns, lines, caption)] if lines else []
    never = [x.path for x in rows if not x.found and not x.reason and x.low is x.high is None]
    notes: list[Phrase] = (
        [(listed(never), ": the number of roots that shake is the same for all values.")] if never else []
    )
    notes += [(Strong("UNDECIDED"), f": {near.path}: {near.reason}.") for near in rows if near.reason]
    notes += looked_at(rows)
    if lines and notes:
        blocks.append(Notes(tuple(notes)))
    else:
        blocks += map(Paragraph, notes)
    return Section(f"How far a number may go in the hand {x.hand.name}", tuple(blocks))


def _critical(found: Stability, x: Critical) -> tuple[Phrase, ...]:
    unit = unit_text(found.scene.knobs[x.path].unit)
    place: Phrase = "from infinity" if x.omega is None else short(x.omega)
    side = x.stable_side or (f"not {x.chain_side}" if x.is_crowded else "on neither side")
    return x.path, exactly(x.value, 8), "" if unit == "1" else unit, side, place


def _units(found: Stability) -> list[str]:
    """Of mass, damping and stiffness."""
    return [unit(x, found.scene.motion) for x in (Dimension.MASS, Dimension.DAMPING, Dimension.STIFFNESS)]


def _row(x: Held) -> tuple[Phrase, ...]:
    drifts = x.shakes is False and x.drifts
    verdict: Phrase = (
        Strong("UNDECIDED") if x.stable is None else "yes" if x.stable else "drifts" if drifts else Strong("NO")
    )
    return x.hand.name, *(rounded(float(p.value), 6) for p in x.hand.parameters), verdict, _count(x)


def _count(x: Held) -> str:
    """How many roots lie in Re s >= 0, as far as that is known."""
    if x.roots is None or x.roots.chain is RootChain.NEAR:  # of a chain that only comes near, none need lie there
        return "" if x.roots is None else "a chain near it"
    return "infinite" if x.unstable is None else str(x.unstable)


def _reason(x: Held) -> Phrase:
    if x.roots is None:
        return "not decided: ", x.reason
    if x.roots.chain:
        return _CHAINS[x.roots.chain]
    on_axis = x.on_axis[bool(x.drifts) :]
    if x.shakes is False and x.drifts:
        return "does not shake; drifts: nothing holds it in place"
    if on_axis:
        where = listed(map(short, on_axis))
        return "on the imaginary axis, at ", where, " rad/s, lie roots that neither grow nor decay"
    return ""


def _every(x: EveryPassiveHand, damping: str, stiffness: str) -> Iterator[Block]:
    p = x.passivity
    if x.sampled is not None:
        yield from sampled_condition(x, damping, stiffness)
        if x.holds is False and p is not None and p.active:
            yield Notes((_active(p),))
        return
    if p is None or p.holds is None:
        yield Paragraph((Strong("UNDECIDED"), (": ", x.reason) if p is None else _open(p), "."))
    elif p.has_passive_parts:
        yield Paragraph("Holds: all parts only take energy, the environment and each two-port between it and the hand.")
    elif p.holds:
        yield Paragraph(("Holds: ", _IM, " ≥ 0 on all of [0, ∞), and no pole of ", H_PERC, "/s forbids it."))
    else:
        yield Paragraph((Strong("Does NOT hold"), ": there is a passive hand in which a motion grows."))
    if p is not None:
        yield from noted(_notes_in_stability(p, damping))


def _open(p: Passivity) -> Phrase:
    if p.beyond is Beyond.NEVER:
        return ": ", _IM, " ≥ 0 on all of [0, ∞), but where poles lie stayed open"
    return ": beyond ", both(ExactNumber(p.high)), " the sign of ", _IM, f" is {p.beyond.value}"


def _notes_in_stability(p: Passivity, unit: str) -> Iterator[Phrase]:
    if p.active:
        yield _active(p)
    if p.holds is False and p.poles_allow is False:
        yield "Whatever a hand damps: a pole of ", H_PERC, "/s to the right, on the axis, at 0 or at ∞ forbids it."
    if p.is_unbounded:
        none = "No damping of a hand is enough for all its masses and stiffnesses: −"
        yield none, _IM, "/", OMEGA, " grows without bound."
    elif p.is_active and p.damping:
        place: Phrase = ", approached as ω grows" if p.damping.omega is None else (", at ", both(p.damping.omega))
        value = "b* = sup(−", _IM, "/", OMEGA, ") = ", short(p.damping.value), f" {unit}", place
        enough = "; in a hand that damps more no motion grows, whatever its mass and stiffness" if p.poles_allow else ""
        yield (*value, enough, ".")
    elif p.is_active and p.beyond is not Beyond.CLOCK:
        yield Strong("UNDECIDED"), ": how large −", _IM, "/", OMEGA, " becomes."


def _active(p: Passivity) -> Phrase:
    energy = ": there a motion of amplitude A draws the energy −π A² "
    return "Active (", _IM, " < 0) ", _bands(p), energy, _IM, " per cycle."


def _bands(p: Passivity) -> Phrase:
    shown = [span(x) for x in p.active[:_MOST]]
    if p.beyond is Beyond.ALWAYS and len(p.active) <= _MOST:
        shown[-1] = ("from ", short(p.active[-1].low.omega), " rad/s on")
    more = [f"{len(p.active) - _MOST} more intervals"] if len(p.active) > _MOST else []
    again = [("again and again beyond ", short(ExactNumber(p.high)), " rad/s")] if p.beyond is Beyond.AGAIN else []
    return listed([*shown, *more, *again]), not_looked_at(p) if p.beyond is Beyond.LATE else ""


def _certain(found: Stability) -> Phrase:
    if not found.certified:
        return Strong("UNDECIDED"), " where it says so. Everything else is proven."
    p = found.every_passive_hand.passivity
    signs = "where they were looked at" if p is not None and p.beyond is Beyond.LATE else "on [0, ∞)"
    proven = f"Certain: roots are counted, and signs {signs} decided, with every delay as it is. "
    if found.sampled is not None:
        proven = "Certain: roots are counted on the exact polynomial of the loop with its clock, and signs decided on 0 < θ ≤ π. "
    apart = "Imposed, held and every passive hand are three statements; each is proven by itself."
    return certainty(found.scene, (proven, apart))
