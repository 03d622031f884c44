"""The page of sensitivities: for each frequency a table, the parameter that moves it most first."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.kernel.reals import RealNumber
from haptisym.model.quantities import unit_text
from haptisym.pages.words import OMEGA, both, near, noted, page_about, proof, undecided
from haptisym.verbs.sensitivity.entry import Sensitive, Sensitivities, Sensitivity
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Figure,
    Paragraph,
    Phrase,
    Section,
    Table,
    listed,
)
from haptisym.writing.layout import named

_FEW = 3


def page(found: Sensitivities) -> Document:
    """The whole page."""
    blocks = [*_crossings(found), *_changeovers(found)]
    further = ('haptisym derive SCENE --of "d omega_r/d NAME"',) if found.scene.threshold.is_plain else ()
    kind = "Sensitivity to each parameter"
    return page_about(found.scene, _answer(found), blocks, _proven(found), kind, found.asides(), further)


def _answer(found: Sensitivities) -> Iterator[tuple[Phrase, Phrase]]:
    """The bandwidth, and what moves it most."""
    x = found.bandwidth
    if x is None:
        yield "Bandwidth", "none: noticed from the low end of the band on"
    elif x.reason:
        yield "Bandwidth", (both(x.omega), f"; its derivative is {x.reason}")
    elif x.criterion is None:
        yield "Bandwidth", (both(x.omega), ", the whole band: small changes of parameters leave it as it is")
    else:
        yield "Bandwidth", (both(x.omega), ", limited by ", named(x.criterion.symbol))
    crossing = x and next(
        (y for y in found.crossings if y.omega is x.omega or (x.criterion and y.criterion == x.criterion)), None
    )
    most = [p for p in crossing.ranked if p.elasticity is not None][:_FEW] if crossing else []
    if most:
        yield (
            "Moved most by",
            listed(
                (named(p.name), " (", _signed(p.elasticity), "\xa0% per %)") for p in most if p.elasticity is not None
            ),
        )


def _crossings(found: Sensitivities) -> Iterator[Block]:
    if not found.crossings:
        yield Paragraph("No ratio crosses its threshold on the band.")
    yield from (_moved(("Crossing of ", named(x.criterion.symbol)), x) for x in found.crossings if x.criterion)


def _changeovers(found: Sensitivities) -> Iterator[Block]:
    systems = (("H_env", found.changeovers_environment), ("H_perc", found.changeovers_perceived))
    moved = [_moved(("Changeover of ", named(name)), x) for name, listed in systems for x in listed]
    yield from moved
    if found.crossings or moved:
        words = "Elasticities: per cent by which each frequency moves as a parameter increases by 1 per cent."
        yield Figure("elasticities", words, found.figure)


def _moved(what: Phrase, x: Sensitive) -> Section:
    heading = what, " at ", both(x.omega)
    if x.reason:
        return Section(heading, (Paragraph(f"{x.reason[0].upper()}{x.reason[1:]}."),))
    columns = (
        Column("parameter"), Column("path"), Column("elasticity", number=True),
        Column(("d", OMEGA, "/d", named("p")), number=True), Column("rad/s per"),
    )  # fmt: skip
    caption = "How it moves with each parameter, the one that moves it most first."
    reasons = {
        p.reason: [q.name for q in x.ranked if q.reason == p.reason] for p in x.ranked if p.derivative and p.reason
    }
    told = tuple((listed(map(named, names)), f": {reason}.") for reason, names in reasons.items())
    return Section(heading, (Table(columns, tuple(map(_row, x.ranked)), caption), *noted(told)))


def _row(p: Sensitivity) -> tuple[Phrase, ...]:
    name, unit = named(p.name), unit_text(p.unit)
    if p.derivative is None or p.elasticity is None:
        return name, p.path, p.reason, "", unit
    derivative = _signed(p.derivative), f" {p.side}" if p.side else ""
    return name, p.path, _signed(p.elasticity), derivative, unit or "unit"


def _signed(x: RealNumber) -> Phrase:
    return "+" if float(x) > 0 else "", near(x)


def _proven(found: Sensitivities) -> Iterator[Phrase]:
    yield "Elasticity: per cent of the frequency per per cent of the parameter."
    if found.certified:
        yield proof(found.scene, "derivatives by implicit differentiation of the threshold equation, all digits")
    else:
        yield undecided("what is marked so, at the precision limit")
        yield "Proven: all else."
