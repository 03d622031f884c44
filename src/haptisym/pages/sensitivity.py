"""The page of sensitivities: for each frequency a table, the parameter that moves it most first."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.kernel.reals import RealNumber
from haptisym.model.quantities import unit_text
from haptisym.pages.words import OMEGA, both, certainty, noted, page_about
from haptisym.verbs.sensitivity.entry import Sensitive, Sensitivities, Sensitivity
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Figure,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import named

_DIGITS = 5


def page(found: Sensitivities) -> Document:
    """The whole page."""
    frequencies = [*_crossings(found), *_changeovers(found)]
    blocks = [*frequencies, Paragraph(_bandwidth(found)), Paragraph(_certain(found))]
    return page_about(found.scene, blocks, "Sensitivity to each parameter", found.asides())


def _crossings(found: Sensitivities) -> Iterator[Block]:
    if not found.crossings:
        yield Paragraph("No ratio meets its threshold on the band: there is no crossing to move.")
    yield from (_moved(("Crossing of ", named(x.criterion.symbol)), x) for x in found.crossings if x.criterion)


def _changeovers(found: Sensitivities) -> Iterator[Block]:
    systems = (("H_env", found.changeovers_environment), ("H_perc", found.changeovers_perceived))
    moved = [_moved(("Changeover of ", named(name)), x) for name, listed in systems for x in listed]
    yield from moved
    if found.crossings or moved:
        words = "Elasticities: per cent by which each frequency moves when a parameter grows by 1 per cent."
        yield Figure("elasticities", words, found.figure)


def _bandwidth(found: Sensitivities) -> Phrase:
    x = found.bandwidth
    if x is None:
        return "No transparent band starts at the low end of the band: there is no bandwidth to move."
    width = "Bandwidth: ", both(x.omega)
    if x.criterion is not None:
        return width, ", the first crossing of ", named(x.criterion.symbol), "; it moves as that one does."
    if x.reason:
        return width, f"; its derivative is {x.reason}."
    return width, ", the whole band, which small changes of parameters leave as it is."


def _moved(what: Phrase, x: Sensitive) -> Section:
    heading = what, " at ", both(x.omega)
    if x.reason:
        return Section(heading, (Paragraph(f"{x.reason[0].upper()}{x.reason[1:]}."),))
    columns = (
        Column("parameter"), Column("where"), Column("elasticity", number=True),
        Column(("d", OMEGA, "/d", named("p")), number=True), Column("rad/s per"),
    )  # fmt: skip
    caption = "How it moves with each parameter, the one that moves it most first."
    alike = {
        p.reason: [q.name for q in x.ranked if q.reason == p.reason] for p in x.ranked if p.derivative and p.reason
    }
    told = tuple((listed(map(named, names)), f": {reason}.") for reason, names in alike.items())
    return Section(heading, (Table(columns, tuple(map(_row, x.ranked)), caption), *noted(told)))


def _row(p: Sensitivity) -> tuple[Phrase, ...]:
    name, unit = named(p.name), unit_text(p.unit)
    if p.derivative is None or p.elasticity is None:
        return name, p.path, p.reason, "", unit
    derivative = _signed(p.derivative), f" {p.side}" if p.side else ""
    return name, p.path, _signed(p.elasticity), derivative, unit or "unit"


def _signed(x: RealNumber) -> Number:
    digits = x.digits(_DIGITS)
    return Number(digits if digits.startswith("-") or digits == "0" else f"+{digits}", float(x))


def _certain(found: Sensitivities) -> Phrase:
    if not found.certified:
        return Strong("UNDECIDED"), " at the precision limit where it says so. Everything else is proven."
    formulas = " Their formulas: ", Code('haptisym derive SCENE --of "d omega_r/d NAME"'), "."
    proven = "Certain: derivatives by implicit differentiation of the threshold equation, every digit proven."
    return (
        "Elasticity: per cent of frequency per per cent of the parameter. ", certainty(found.scene, proven),
        formulas if found.scene.threshold.is_plain else (),
    )  # fmt: skip
