"""What an evaluation says of stability: imposed motion, and every passive hand; never the one for the other."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.evaluation import Evaluation
from haptisym.judge.passivity import Beyond, Passivity
from haptisym.kernel.reals import ExactNumber
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.pages.words import H_PERC, NOT_HELD, OPERATORS, compared, short, spans, stiffness_unit, unit
from haptisym.writing.boxes import Prefixed
from haptisym.writing.document import Phrase, Strong
from haptisym.writing.layout import named

_MOST_BANDS = 3
_IMAG = Prefixed(OPERATORS[Part.IMAG], H_PERC)
_KEPT, _BROKEN = compared(_IMAG, "≥"), compared(_IMAG, "<")


def held(e: Evaluation) -> Iterator[Phrase]:
    """A remark on imposed motion, and one on every passive hand."""
    yield _imposed(e)
    found = e.passivity
    yield _of_hands(e, found), "" if found and found.holds else f" {NOT_HELD}"


def _imposed(e: Evaluation) -> Phrase:
    pole = Prefixed(OPERATORS[Part.REAL], named("s"))
    if e.stable is None:
        return "Whether the force under imposed motion is stable was not decided."
    if e.stable:
        left = ("all poles of ", H_PERC, " have ", compared(pole, "<"))
        return "The force under imposed motion is stable: ", left, "."
    right = ("a pole of ", H_PERC, " has ", compared(pole, "≥"))
    return "The force under imposed motion is ", Strong("NOT"), " stable: ", right, "."


def _of_hands(e: Evaluation, found: Passivity | None) -> Phrase:
    if found is not None and found.is_active and found.holds is False:
        return "Not with every passive hand: ", _where(found), ". ", _energy(e, found), _damping(e, found)
    if found is None or found.holds is None:
        return "Every passive hand: not decided", _as_far(found), "."
    if found.holds and (found.sampled or found.has_passive_parts):
        why = (
            "all parts only take energy"
            if found.has_passive_parts
            else "Colgate and Schenkel's condition is met up to θ = π"
        )
        return f"Every passive hand may hold it: {why}."
    if found.holds:
        everywhere = " at all frequencies, not on this band alone, and no pole forbids it."
        return "Every passive hand may hold it: ", _KEPT, everywhere
    if found.sampled:
        return "Not with every passive hand: Colgate and Schenkel's condition is not met."
    return "Not with every passive hand: ", _KEPT, " at all frequencies, but poles forbid it."


def _as_far(found: Passivity | None) -> Phrase:
    if found is None or found.beyond is Beyond.UNKNOWN:
        return ""
    if found.is_active:
        return "; ", _where(found), " in a closed form that leaves out what a clock folds back"
    if found.beyond is Beyond.CLOCK:
        upto = short(ExactNumber(found.high))
        return "; ", _KEPT, " up to ", upto, " rad/s, half the clock's rate, which alone does not tell"
    return "; ", _KEPT, " at all frequencies, but poles were not decided"


def _where(found: Passivity) -> Phrase:
    shown = found.active[:_MOST_BANDS]
    on = found.beyond is Beyond.ALWAYS and len(shown) == len(found.active)
    last = ("from ", short(shown[-1].low.omega), " rad/s on") if on else ()
    before = spans(shown[:-1] if on else shown) if len(shown) > bool(on) else ()
    again: Phrase = " and again and again beyond" if found.beyond is Beyond.AGAIN else ""
    more = " and further on" if len(found.active) > _MOST_BANDS and not again else ""
    if found.beyond is Beyond.LATE:
        again = not_looked_at(found)
    joined = (before, " and ", last) if before and last else before or last
    return _BROKEN, " ", joined, more, again


def not_looked_at(found: Passivity) -> Phrase:
    """Of a sign that settles only after very many turns of a delay: where it settles, and from where on it was not looked at."""
    high = short(ExactNumber(found.high))
    if found.active_from is None:
        return " (beyond ", high, " rad/s it was not looked at)"
    settled = short(ExactNumber(found.active_from))
    return " and everywhere above ", settled, " rad/s (from ", high, " rad/s to there it was not looked at)"


def _energy(e: Evaluation, found: Passivity) -> Phrase:
    given = found.most_given
    if given is None or given.omega is None:
        return "It gives energy away there, ", _per_cycle(), " per cycle of amplitude A."
    most = f"{short(given.value).digits} {stiffness_unit(e.scene)}"
    said = (" per cycle of amplitude A (with ", _IMAG, f" = −{most} at ", short(given.omega), " rad/s).")
    return "It gives energy away there, ", _per_cycle(), said


def _per_cycle() -> Phrase:
    return "−", named("pi"), " A² ", _IMAG


def _damping(e: Evaluation, found: Passivity) -> Phrase:
    """What a hand must damp at least to be held whatever its mass and stiffness."""
    if found.damping is not None and found.poles_allow:
        held = f" {unit(Dimension.DAMPING, e.scene.motion)} holds it, whatever its mass and stiffness."
        return " A hand that damps more than ", short(found.damping.value), held
    if found.is_unbounded:
        return " No damping of a hand makes up for that: it grows faster than frequency."
    return ""
