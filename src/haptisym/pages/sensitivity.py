"""Sensitivities as a page of text: for each frequency a table, the parameter that moves it most first."""

from __future__ import annotations

from textwrap import fill, indent

from haptisym.kernel.reals import RealNumber
from haptisym.pages.lines import WIDTH, both, table
from haptisym.verbs.sensitivity.entry import Sensitivities
from haptisym.verbs.sensitivity.slopes import Sensitive, Sensitivity

_DIGITS = 5


def page(found: Sensitivities) -> str:
    """The whole page."""
    scene = found.evaluation.scene
    heading = "\n".join(fill(line, WIDTH) for line in (scene.title or "Untitled scene", *found.asides()))
    parts = [heading, *_crossings(found), *_changeovers(found), _bandwidth(found), _certain(found)]
    return "\n\n".join(parts) + "\n"


def _crossings(found: Sensitivities) -> list[str]:
    if not found.crossings:
        return ["No ratio meets its threshold on the band: there is no crossing to move."]
    return [_block(f"Crossing of {_ratio(x)} at {both(x.omega)}", x) for x in found.crossings]


def _ratio(x: Sensitive) -> str:
    return x.criterion.symbol if x.criterion else ""


def _changeovers(found: Sensitivities) -> list[str]:
    systems = (("H_env", found.changeovers_environment), ("H_perc", found.changeovers_perceived))
    return [_block(f"Changeover of {name} at {both(x.omega)}", x) for name, listed in systems for x in listed]


def _bandwidth(found: Sensitivities) -> str:
    x = found.bandwidth
    if x is None:
        return "No transparent band starts at the low end of the band: there is no bandwidth to move."
    if x.criterion is not None:
        same = f"Bandwidth: {both(x.omega)}, the first crossing of {_ratio(x)}; it moves as that one does."
        return fill(same, WIDTH)
    if x.reason:
        return fill(f"Bandwidth: {both(x.omega)}; its derivative is {x.reason}.", WIDTH)
    return fill(f"Bandwidth: {both(x.omega)}, the whole band, which small changes of parameters leave as it is.", WIDTH)


def _block(title: str, x: Sensitive) -> str:
    if x.reason:
        return f"{title}\n\n  {x.reason[0].upper()}{x.reason[1:]}."
    columns = ("parameter", "where", "elasticity", "d ω/dp", "rad/s per")
    notes = {
        p.reason: [q.name for q in x.ranked if q.reason == p.reason] for p in x.ranked if p.derivative and p.reason
    }
    told = [fill(f"{', '.join(names)}: {reason}.", WIDTH - 2) for reason, names in notes.items()]
    return "\n\n".join([title, table(columns, [_row(p) for p in x.ranked]), *(indent(note, "  ") for note in told)])


def _row(p: Sensitivity) -> tuple[str, ...]:
    if p.derivative is None or p.elasticity is None:
        return p.name, p.path, p.reason, "", p.unit
    derivative = _signed(p.derivative) + (f" {p.side}" if p.side else "")
    return p.name, p.path, _signed(p.elasticity), derivative, p.unit or "unit"


def _signed(x: RealNumber) -> str:
    digits = x.digits(_DIGITS)
    return digits if digits.startswith("-") or digits == "0" else f"+{digits}"


def _certain(found: Sensitivities) -> str:
    if not found.certified:
        return fill("UNDECIDED at the precision limit where it says so. Everything else is proven.", WIDTH)
    return fill(
        "Elasticity: per cent of frequency per per cent of the parameter. Certain: derivatives by implicit differentiation of "
        'the threshold equation, every digit proven. Their formulas: haptisym derive SCENE --of "d omega_r/d NAME".',
        WIDTH,
    )
