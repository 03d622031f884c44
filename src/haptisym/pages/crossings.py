"""Step 1 on a page: where a display is transparent, a table of all crossings, and each in words."""

from __future__ import annotations

from collections.abc import Iterable

from haptisym.judge.criteria import Criterion
from haptisym.judge.crossings import Crossing, CrossingKind
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.regions import Joint
from haptisym.pages.words import CHANGE, OMEGA, amount, both, compared, exactly, hertz, is_transparent_throughout, spans
from haptisym.writing.boxes import Operator, Prefixed
from haptisym.writing.document import Block, Column, Paragraph, Phrase, Table
from haptisym.writing.names import named


def joint(criteria: Iterable[Criterion]) -> Joint | None:
    """The region that judges both parts at once, where there is one."""
    return next((x.joint for x in criteria if x.joint), None)


def nothing_meets(region: Joint | None) -> str:
    """That what is judged meets no limit."""
    return f"The distortion does not meet the border of the {region.kind}" if region else "No ratio meets its threshold"


def crossings(e: Evaluation) -> Block:
    """Every crossing on the band: digits, what happens, enclosure."""
    if not e.crossings:
        decided = ", as far as that was decided" if e.undecided else ""
        return Paragraph(f"{nothing_meets(joint(e.criteria))} on the band{decided}.")
    columns = (
        Column("part"), Column((OMEGA, " (rad/s)"), number=True), Column("Hz", number=True), Column("what happens"),
        Column("distortion"), Column(("enclosure of ", OMEGA), full=True),
    )  # fmt: skip
    caption = f"All crossings of the thresholds on the band, {proven(e)}."
    return Table(columns, tuple(_crossing(e, c) for c in e.crossings), caption)


def proven(e: Evaluation) -> str:
    """How certain a table is."""
    if e.scene.level is not None:
        return "of the fitted model: none missed, none invented"
    return "proven: none missed, none invented" if e.certified else "proven, but for what is listed as undecided"


def _crossing(e: Evaluation, c: Crossing) -> tuple[Phrase, ...]:
    low, high = c.omega.enclosure(e.digits)
    return c.criterion.name, exactly(c.omega, e.digits), hertz(c.omega), event(c), sense(c), f"[{low}, {high}]"


VERBS = {CrossingKind.EXCEEDS: "rises above", CrossingKind.RETURNS: "falls below", CrossingKind.TOUCHES: "touches"}


def event(c: Crossing, kind: str | None = None) -> Phrase:
    """``r_r rises above 10 %``, ``ΔH leaves the ellipse``; ``kind`` : what a region is called, if not by its shape."""
    times = f" ({c.multiplicity}-fold)" if c.multiplicity > 1 else ""
    if c.criterion.joint:
        return CHANGE, f" {_LEAVES[c.kind]} the {kind or c.criterion.joint.kind}{times}"
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


_RATIOS = (
    "Distortion ratios over the band. Grey: neither exceeds its threshold, the display is transparent. A dot "
    "marks where the ratio of the real part meets its threshold, a ring that of the imaginary part."
)
_JOINT_RATIOS = (
    "How many times the region must be enlarged to hold the distortion, over the band. Grey: not more than once, the display is "
    "transparent. A dot marks where the distortion leaves or enters the region."
)


def ratios_caption(e: Evaluation) -> str:
    """What the figure of ratios shows."""
    return _JOINT_RATIOS if joint(e.criteria) else _RATIOS


def transparency(e: Evaluation) -> Phrase:
    """Where neither ratio exceeds its threshold."""
    if not e.transparent:
        return "At every frequency of the band: the display is transparent nowhere."
    if is_transparent_throughout(e):
        return "Never on this band: the display is perceptually transparent on the whole of it."
    pieces = spans(e.transparent)
    if e.bandwidth is None:
        return "From the low end of the band on. The display is perceptually transparent only ", pieces, "."
    if len(e.transparent) == 1:
        width = both(e.bandwidth)
        return "At ", width, ". Below that the display is perceptually transparent: this is its bandwidth."
    return "At ", both(e.bandwidth), ", its bandwidth. The display is perceptually transparent ", pieces, "."
