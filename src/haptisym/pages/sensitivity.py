"""The page of sensitivities: for each frequency a table, the parameter that moves it most first."""

from __future__ import annotations

from collections.abc import Iterator

from sympy import Expr, S

from haptisym.kernel.reals import RealNumber
from haptisym.model.quantities import Unit
from haptisym.model.scene import Scene
from haptisym.pages import words as w
from haptisym.verbs.sensitivity.entry import Sensitive, Sensitivities, Sensitivity
from haptisym.writing.document import (
    FREQUENCY,
    FREQUENCY_UNIT,
    Block,
    Document,
    Figure,
    Paragraph,
    Phrase,
    Section,
    listed,
)
from haptisym.writing.layout import named

_FEW = 3


def page(found: Sensitivities) -> Document:
    """Return the whole page of the sensitivities."""
    blocks = [*_crossings(found), *_changeovers(found)]
    further = (
        ('haptisym derive SCENE --of "d omega_r/d NAME"',) if found.scene.threshold.is_plain else ()
    )
    kind = "Sensitivity to each parameter"
    return w.page_about(
        found.scene, _answer(found), blocks, _proven(found), kind, found.asides(), further
    )


def _answer(found: Sensitivities) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the bandwidth, and the parameters that move it most."""
    x = found.bandwidth
    if x is None:
        yield "Bandwidth", "none: noticed from the low end of the band on"
        return
    limit: Phrase = ", the whole band: small changes of parameters leave it as it is"
    if x.reason or x.criterion:
        limit = (
            f"; its derivative is {x.reason}"
            if x.reason or not x.criterion
            else (", limited by ", named(x.criterion.symbol))
        )
    yield "Bandwidth", (w.both(x.omega), limit)
    # Both parts may cross at the bandwidth: then each has parameters that move it.
    there = [y for y in found.crossings if y.omega is x.omega]
    moved = [(y, _movers(y)) for y in there if _movers(y)]
    several = len(moved) > 1
    rows = (
        (named(y.criterion.symbol), ": ", row) if several and y.criterion else row
        for y, row in moved
    )
    if moved:
        yield "Moved most by", tuple(z for row in rows for z in ("; ", row))[1:]


def _movers(x: Sensitive) -> Phrase:
    """Return the parameters that move a crossing most; nothing if none does."""
    moving = [p for p in x.ranked if p.elasticity is not None and float(p.elasticity)][:_FEW]
    return listed((named(p.name), " (", _signed(p.elasticity), "\xa0% per %)") for p in moving)


def _crossings(found: Sensitivities) -> Iterator[Block]:
    """Yield a section for each crossing."""
    if not found.crossings:
        yield Paragraph("No ratio crosses its threshold on the band.")
    yield from (
        _moved(found.scene, ("Crossing of ", named(x.criterion.symbol)), x)
        for x in found.crossings
        if x.criterion
    )


def _changeovers(found: Sensitivities) -> Iterator[Block]:
    """Yield a section for each changeover frequency, and the figure of all."""
    systems = (("H_env", found.changeovers_environment), ("H_perc", found.changeovers_perceived))
    moved = [
        _moved(found.scene, ("Changeover of ", named(name)), x)
        for name, listed in systems
        for x in listed
    ]
    yield from moved
    if found.crossings or moved:
        words = (
            "Elasticities: per cent by which each frequency moves as a parameter increases by 1 "
            "per cent."
        )
        yield Figure("elasticities", words, found.figure)


def _moved(scene: Scene, what: Phrase, x: Sensitive) -> Section:
    """Return the table of how a frequency moves with each parameter; a sentence where it has no
    derivative."""
    heading = what, " at ", w.both(x.omega)
    if x.reason:
        return Section(heading, (Paragraph(f"{x.reason[0].upper()}{x.reason[1:]}."),))
    units = {p.path: scene.knobs[p.path].shown_unit(scene.motion) for p in x.ranked}

    def slope(p: Sensitivity) -> Phrase:
        # From SI to the units of the page: a frequency's unit per that of the parameter.
        return _signed(
            p.derivative, scene.frequency.size / units[p.path].size
        ), f" {p.side}" * bool(p.side)

    # Proven to be 0 both ways: these have a line below the table.
    still = [
        p
        for p in x.ranked
        if p.elasticity and p.derivative and not (float(p.elasticity) or float(p.derivative))
    ]
    shown = w.table(
        [p for p in x.ranked if p not in still],
        "How it moves with each parameter, the one that moves it most first.",
        w.Field("parameter", lambda p: named(p.name)),
        w.Field("path", lambda p: p.path),
        w.number("elasticity", lambda p: _signed(p.elasticity) if _has(p) else p.reason),
        w.number(("d", FREQUENCY, "/d", named("p")), lambda p: slope(p) if _has(p) else ""),
        w.Field((FREQUENCY_UNIT, " per"), lambda p: units[p.path].text or "1" * _has(p)),
    )
    none: list[Phrase] = (
        [("No effect: ", listed(named(p.name) for p in still), ".")] if still else []
    )
    whose: dict[str, list[Phrase]] = {}
    for p in x.ranked:
        whose.setdefault(p.reason, []).append(named(p.name))
    one_sided = dict.fromkeys(p.reason for p in x.ranked if p.derivative and p.reason)
    remarks = (w.phrased("{}: {}.", listed(whose[reason]), reason) for reason in one_sided)
    return Section(heading, (shown, *w.noted([*none, *remarks])))


def _has(p: Sensitivity) -> bool:
    """Return whether a derivative is known."""
    return p.derivative is not None and p.elasticity is not None


def _signed(x: RealNumber | None, unit: Expr = S.One) -> Phrase:
    """Return a number with its sign; ``unit`` : the size in SI of the unit in which it is
    printed."""
    return "" if x is None else ("+" if float(x) > 0 else "", w.near(x, unit=Unit("", unit)))


def _proven(found: Sensitivities) -> Iterator[Phrase]:
    """Yield what an elasticity is, and what is proven."""
    yield "Elasticity: (p/", FREQUENCY, ") d", FREQUENCY, "/dp, per cent per per cent."
    if found.certified:
        yield w.proof(found.scene, "all derivatives and all digits printed")
    else:
        yield w.undecided("what is marked so")
        yield w.proof(found.scene, "all else")
