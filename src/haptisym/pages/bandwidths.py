"""What is said of a threshold that is published or a range, and of all bandwidths that the range gives."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.climb import Bandwidths, Jump
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import RealNumber
from haptisym.model.jnd import Part, Threshold
from haptisym.model.published import like
from haptisym.model.quantities import Dimension
from haptisym.model.ranges import ExactRange
from haptisym.pages.late import drawing
from haptisym.pages.words import PART_NAMES, both, percent, short, unit
from haptisym.writing.document import Block, Code, Number, Paragraph, Phrase, Strong, listed


def bandwidths(e: Evaluation) -> Iterator[Block]:
    """Where the threshold is a range: the least and the most bandwidth, both reached, what between is not, and a drawing."""
    found, threshold = e.bandwidths, e.scene.threshold
    if found is None:
        return
    yield Paragraph(("For ", _range(threshold), " ", _said(found, threshold), _blocked(found, threshold), _open(found)))
    if found.is_one_curve:
        caption = "The bandwidth over the range; a dot is reached, a ring is not."
        yield drawing("bandwidths", caption, "files:draw_figure", e, "bandwidths")


def _range(threshold: Threshold) -> Phrase:
    ranges = threshold.ranges
    if "scale" in ranges:
        low, high = ranges["scale"]
        return f"a JND from {float(low):.6g} to {float(high):.6g} times as large"
    limits = {name: x for name, x in ranges.items() if name != "floor"}
    alike = threshold.real == threshold.imag and threshold.real_interval == threshold.imag_interval
    found: list[Phrase] = []
    if limits and alike and threshold.region.lower == (None, None):
        found = [("thresholds ", _ends(limits["real"]))]
    elif limits:
        found = [("thresholds ", listed((_ends(x), f" ({_named(name, threshold)})") for name, x in limits.items()))]
    if "floor" in ranges:
        low, high = ranges["floor"]
        found.append(f"a floor from {float(low):.6g} to {float(high):.6g} {_unit(threshold)}")
    return listed(found)


def _named(name: str, threshold: Threshold) -> str:
    """``real``, or ``real part, where it shrinks``."""
    return _of_part(name, threshold).removesuffix(" part")


def _of_part(name: str, threshold: Threshold) -> str:
    """``real part``, or ``real part, where it shrinks``."""
    part, _, lower = name.partition(".")
    way = ", where it shrinks" if lower else ", where it grows" if threshold.lower(Part(part)) is not None else ""
    return f"{PART_NAMES[Part(part)]} part{way}"


def _unit(threshold: Threshold) -> str:
    return unit(Dimension.STIFFNESS, threshold.region.motion)


def _ends(interval: ExactRange) -> str:
    low, high = interval
    return f"from {percent(low)} to {percent(high)}"


def _said(found: Bandwidths, threshold: Threshold) -> Phrase:
    if found.most is None:
        return "there is no bandwidth: the distortion is noticed at the band's low end."
    if found.least is None:
        return "the bandwidth is at most ", both(found.most), "; some give none."
    least, most = found.least, found.most
    if least is most or least.bounds(200) == most.bounds(200):
        return "the bandwidth is ", both(least), ", where there is one." if found.blocked else ", whichever it is."
    ends: Phrase = ("the bandwidth is at least ", both(least), " and at most ", both(most), "; ")
    if found.undecided:
        return ends, "both are reached."
    if found.ends_alone:
        grows = "both are reached, as the region grows with each of these numbers."
        return ends, grows, " Which of the values between are is not told."
    if not found.jumps:
        return ends, "each value between is reached."
    return ends, "each value between is reached but those ", listed(_jump(x, threshold) for x in found.jumps), "."


def _jump(x: Jump, threshold: Threshold) -> Phrase:
    gap: Phrase = "above " if x.includes_low else "from ", short(x.low), " to below ", short(x.high), " rad/s"
    if x.threshold is None:
        return gap
    name = next(iter(threshold.ranges))
    passed = "the threshold passes a peak of " if name not in ("scale", "floor") else f"at a {name} of "
    return gap, " (", passed, _size(x.threshold, name, threshold), ")"


def _size(x: RealNumber, name: str, threshold: Threshold) -> Phrase:
    if name == "scale":
        return short(x)
    return (short(x), f" {_unit(threshold)}") if name == "floor" else _share(x)


def _blocked(found: Bandwidths, threshold: Threshold) -> Phrase:
    if not found.blocked:
        return ""
    below: list[Phrase] = []
    for name, x in found.blocked.items():
        what = f" {name}" if name in ("scale", "floor") else " threshold"
        whose = f" for the {_of_part(name, threshold)}" if name not in ("scale", "floor", "jnd") else ""
        below.append((f"a{what} below ", _size(x, name, threshold), whose))
    return (" There is none for ", listed(below), ".")


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
