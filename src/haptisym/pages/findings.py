"""The answers of an evaluation in brief, at the head of its report."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.evaluation import Evaluation
from haptisym.judge.passivity import Passivity
from haptisym.model.jnd import Part
from haptisym.pages.words import OPERATORS, compared, hertz, is_transparent_throughout, short, span
from haptisym.writing.boxes import Prefixed
from haptisym.writing.document import Phrase, Strong
from haptisym.writing.names import named


def findings(e: Evaluation) -> Iterator[tuple[Phrase, Phrase]]:
    """The answers in brief, at the head of a report."""
    yield "bandwidth", _bandwidth(e)
    yield "first felt as", _first(e)
    pole = compared(Prefixed(OPERATORS[Part.REAL], named("s")), "≥")
    stable: dict[bool | None, Phrase] = {
        True: (Strong("stable"), " (no pole with ", pole, ")"),
        False: (Strong("NOT stable"), " (a pole with ", pole, ")"),
        None: (Strong("undecided"), " (whether a pole has ", pole, " is open)"),
    }
    yield "under imposed motion", stable[e.stable]
    yield "every passive hand", _of_hands(e.passivity)
    number = len(e.undecided)
    tangencies = (
        f"{number} tangenc{'y' if number == 1 else 'ies'} stayed open"
        if number
        else "jumps of the bandwidth stayed open"
    )
    if not e.certified:
        yield "these answers", (Strong("in part undecided"), f" ({tangencies})")
    elif e.scene.level is not None:
        yield "these answers", (Strong("estimates"), " (exact for the fitted model)")
    else:
        yield "these answers", (Strong("proven"), " (none missed, none invented)")


def _of_hands(found: Passivity | None) -> Phrase:
    if found is None or found.holds is None:
        return Strong("undecided"), ""
    if found.holds:
        return Strong("holds"), " (at all frequencies)"
    where: Phrase = (" (active ", span(found.active[0]), ")") if found.active else " (poles forbid it)"
    return Strong("does not hold"), where


def _bandwidth(e: Evaluation) -> Phrase:
    if e.bandwidth is None:
        onwards = ("transparent from ", short(e.transparent[0].low.omega), " rad/s on") if e.transparent else ()
        return Strong("none"), " (", onwards or "transparent nowhere on the band", ")"
    more = f", and on {len(e.transparent) - 1} more" if len(e.transparent) > 1 else ""
    whole = ", the whole band" if is_transparent_throughout(e) else more
    return Strong((short(e.bandwidth), " rad/s")), f" ({hertz(e.bandwidth)} Hz{whole})", _from_to(e)


def _from_to(e: Evaluation) -> Phrase:
    """The bandwidths that the range of the threshold gives."""
    found = e.bandwidths
    if found is None or found.least is None or found.most is None:
        return ""
    return "; ", short(found.least), " to ", short(found.most), " rad/s for the range of the threshold"


def _first(e: Evaluation) -> Phrase:
    if not e.felt:
        return Strong("nothing"), " is noticed on the band"
    first = min(e.felt, key=lambda x: float(x.band.low.omega))
    return Strong(first.words), " from ", short(first.band.low.omega), " rad/s on"
