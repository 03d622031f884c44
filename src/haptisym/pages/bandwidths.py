"""What is said of a threshold that is published or a range, and of all bandwidths that the range gives."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from haptisym.judge.climb import Bandwidths, Jump
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import RealNumber
from haptisym.model.jnd import Part, Threshold
from haptisym.model.published import like
from haptisym.model.ranges import ExactRange
from haptisym.pages.words import PART_NAMES, both, percent, short
from haptisym.writing.document import Block, Code, Figure, Number, Paragraph, Phrase, Strong, listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


def bandwidths(e: Evaluation) -> Iterator[Block]:
    """Where the threshold is a range: the least and the most bandwidth, both reached, what between is not, and a drawing."""
    found, threshold = e.bandwidths, e.scene.threshold
    if found is None:
        return
    yield Paragraph(("For thresholds ", _range(threshold), " ", _said(found), _blocked(found), _open(found)))
    if found.is_one_curve:
        caption = "The bandwidth over the range of the threshold; a dot is reached, a ring is not."
        yield Figure("bandwidths", caption, partial(_drawn, e))


def _drawn(e: Evaluation) -> Canvas:
    from haptisym.figures.files import draw_figure  # matplotlib is loaded where something is drawn

    return draw_figure(e, "bandwidths")


def _range(threshold: Threshold) -> Phrase:
    each = {part: threshold.interval(part) for part in Part}
    if (both_parts := each[Part.REAL]) and both_parts == each[Part.IMAG]:
        return _ends(both_parts)
    return listed((_ends(x), f" ({PART_NAMES[part]})") for part, x in each.items() if x)


def _ends(interval: ExactRange) -> str:
    low, high = interval
    return f"from {percent(low)} to {percent(high)}"


def _said(found: Bandwidths) -> Phrase:
    if found.most is None:
        return "there is no bandwidth: the distortion is noticed at the band's low end."
    if found.least is None:
        return "the bandwidth is at most ", both(found.most), "; some give none."
    least, most = found.least, found.most
    if least is most or least.bounds(200) == most.bounds(200):
        return "the bandwidth is ", both(least), ", whichever it is."
    ends: Phrase = ("the bandwidth is at least ", both(least), " and at most ", both(most), "; ")
    if found.undecided:
        return ends, "both are reached."
    if not found.jumps:
        return ends, "each value between is reached."
    return ends, "each value between is reached but those ", listed(map(_jump, found.jumps)), "."


def _jump(x: Jump) -> Phrase:
    gap: Phrase = "from ", short(x.low), " to below ", short(x.high), " rad/s"
    return gap if x.threshold is None else (gap, " (the threshold passes a peak of ", _share(x.threshold), ")")


def _blocked(found: Bandwidths) -> Phrase:
    if not found.blocked:
        return ""
    names = {"jnd": "", "real": " for the real part", "imag": " for the imaginary part"}
    below = listed((_share(x), names[name]) for name, x in found.blocked.items())
    return (" There is none for a threshold below ", below, ".")


def _share(x: RealNumber) -> Phrase:
    return Number(f"{100 * float(x):.5g}", float(x)), "\xa0%"


def _open(found: Bandwidths) -> Phrase:
    return (" ", Strong("UNDECIDED"), f": {found.undecided}; there may be jumps between.") if found.undecided else ""


def published_words(threshold: Threshold) -> Phrase:
    """Which published threshold it is; nothing where it is none."""
    if not threshold.source:
        return ""
    found = like(threshold.source)
    taken = f" at {float(100 * found.criterion):g}\xa0%" if found.criterion else ""
    return ", as ", Code(found.name), f": {found.quantity}{taken} ({found.source})"
