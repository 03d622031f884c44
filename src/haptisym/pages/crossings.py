"""Crossings on a page: a table of all of them, and each in words."""

from __future__ import annotations

from haptisym.judge.crossings import Crossing, CrossingKind
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.regions import Joint
from haptisym.pages.words import CHANGE, OMEGA, amount, compared, exactly, hertz
from haptisym.writing.boxes import Operator, Prefixed
from haptisym.writing.document import Block, Column, Paragraph, Phrase, Table
from haptisym.writing.names import named


def joint(e: Evaluation) -> Joint | None:
    """The region that judges both parts at once, where there is one."""
    return next((x.joint for x in e.criteria if x.joint), None)


def crossings(e: Evaluation) -> Block:
    """Every crossing on the band: digits, what happens, enclosure."""
    if not e.crossings:
        decided = ", as far as that was decided" if e.undecided else ""
        region = joint(e)
        none = (
            f"The distortion does not meet the border of the {region.kind}"
            if region
            else "No ratio meets its threshold"
        )
        return Paragraph(f"{none} on the band{decided}.")
    columns = (
        Column("part"), Column((OMEGA, " (rad/s)"), number=True), Column("Hz", number=True), Column("what happens"),
        Column("distortion"), Column(("enclosure of ", OMEGA), full=True),
    )  # fmt: skip
    caption = f"All crossings of the thresholds on the band, {proven(e)}."
    return Table(columns, tuple(_crossing(e, c) for c in e.crossings), caption)


def proven(e: Evaluation) -> str:
    """How certain a table is."""
    return "proven: none missed, none invented" if e.certified else "proven, but for what is listed as undecided"


def _crossing(e: Evaluation, c: Crossing) -> tuple[Phrase, ...]:
    low, high = c.omega.enclosure(e.digits)
    return c.criterion.name, exactly(c.omega, e.digits), hertz(c.omega), event(c), sense(c), f"[{low}, {high}]"


VERBS = {CrossingKind.EXCEEDS: "rises above", CrossingKind.RETURNS: "falls below", CrossingKind.TOUCHES: "touches"}


def event(c: Crossing) -> Phrase:
    """``r_r rises above 10 %``, ``ΔH leaves the ellipse``."""
    times = f" ({c.multiplicity}-fold)" if c.multiplicity > 1 else ""
    if c.criterion.joint:
        return CHANGE, f" {_LEAVES[c.kind]} the {c.criterion.joint.kind}{times}"
    ratio = named(c.criterion.symbol)
    if c.jump:
        return "the limit of ", ratio, " changes: ", _JUMPS[c.kind]
    limit = "its limit" if c.criterion.region else amount(c.criterion.threshold)
    return ratio, f" {VERBS[c.kind]} ", limit, times


_LEAVES = {CrossingKind.EXCEEDS: "leaves", CrossingKind.RETURNS: "returns into", CrossingKind.TOUCHES: "touches"}
_JUMPS = {
    CrossingKind.EXCEEDS: "exceeded from here on",
    CrossingKind.RETURNS: "exceeded up to here",
    CrossingKind.TOUCHES: "not exceeded at this frequency alone",
}


def sense(c: Crossing) -> Phrase:
    """``Re dH > 0``; nothing where both parts are judged."""
    return compared(Prefixed(Operator(c.criterion.component), CHANGE), ">" if c.sign > 0 else "<") if c.sign else ""


def undecided(e: Evaluation) -> Table:
    """What stayed open at the precision limit."""
    found = [(x.name, point.omega.enclosure(e.digits)) for x, point in e.undecided]
    rows = tuple((name, f"[{low}, {high}]") for name, (low, high) in found)
    caption = "Undecided at the precision limit: whether the ratio touches its threshold here, crosses it twice or stays clear."
    return Table((Column("part"), Column(("near ", OMEGA, " (rad/s)"))), rows, caption)
