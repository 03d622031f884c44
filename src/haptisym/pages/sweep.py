"""The page of a sweep: what was varied, what was found, and what is certain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import pi
from typing import Any

from haptisym.model.quantities import unit_text
from haptisym.pages.words import certainty, page_about, rounded
from haptisym.verbs.sweep.entry import Swept
from haptisym.writing.document import Block, Column, Document, Facts, Figure, Notes, Paragraph, Phrase, Strong, Table

_FREQUENCIES: dict[str, Phrase] = {
    "bandwidth": "bandwidth",
    "first_crossing_real": "first crossing, real part",
    "first_crossing_imag": "first crossing, imaginary part",
    "first_crossing_joint": "first crossing, both parts at once",
    "changeover_environment": "changeover of the environment",
    "changeover_perceived": "changeover as felt",
}
_CROSSINGS = {
    "crossings_real": "crossings, real part",
    "crossings_imag": "crossings, imaginary part",
    "crossings_joint": "crossings, both parts at once",
}
_MOST_DRAWN = 2  # parameters that one chart shows


def page(found: Swept) -> Document:
    """The whole page."""
    told = found.to_dict()
    shown = "Bandwidth and first crossings over the parameter, or the bandwidth over both; see the legend."
    is_drawn = len(told["vary"]) <= _MOST_DRAWN and all(x["values"] > 1 for x in told["vary"])
    figure = (Figure("sweep", shown, found.figure),) if is_drawn else ()
    counts = Facts((*_counts(told), *_held(told)))
    blocks = Facts(tuple(_varied(told))), _frequencies(told), counts, *figure, *_certain(found, told)
    return page_about(found.scene, blocks, "Sweep of parameters", found.asides())


def _varied(told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    for x in told["vary"]:
        unit = "" if x["unit"] in ("", "1") else f" {unit_text(x['unit'])}"
        yield x["path"], (_span([x["low"], x["high"]], digits=6), f"{unit}, {x['values']:,} values")
    yield "band", (_span(told["band"], digits=6), " rad/s")


def _frequencies(told: Mapping[str, Any]) -> Block:
    spans = {name: told["ranges"][key] for key, name in _FREQUENCIES.items() if key in told["ranges"]}
    rows = tuple((name, _span(span), _span(span, 2 * pi) if span else "") for name, span in spans.items())
    return Table((Column(""), Column("rad/s"), Column("Hz")), rows, "Least and largest of all sets, proven.")


def _counts(told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    clear = told["ranges"]["transparent"]
    yield "transparent part of the band", (_span(clear, 0.01), "\xa0%" if clear else "")
    for key, name in _CROSSINGS.items():
        if key in told["counts"]:
            counts = ", ".join(f"{n}: {sets:,}" for n, sets in told["counts"][key].items())
            yield name, f"{counts or 'none'} sets"


def _held(told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    for x in told.get("held", ()):
        yield f"stable in {x['hand']}", f"{x['stable']:,} of {told['sets']:,} sets"
        counts = [f"{n}: {sets:,}" for n, sets in x["unstable"].items()]
        counts += [f"{name}: {x[key]:,}" for key, name in _ENDLESS.items() if x[key]]
        yield f"roots that do not decay in {x['hand']}", f"{', '.join(counts)} sets"


_ENDLESS = {"infinite": "a chain of infinitely many", "undecided": "not decided"}


def _span(span: list[float] | None, unit: float = 1.0, digits: int = 5) -> Phrase:
    if span is None:
        return "none"
    low, high = (rounded(x / unit, digits) for x in span)
    return (low, " to ", high) if low != high else low


def _certain(found: Swept, told: Mapping[str, Any]) -> Iterator[Block]:
    proven = (
        f"Certain: {told['sets']:,} sets, {told['certified_in_floats']:,} certified in floats, {told['exact']:,} exact. All "
        "counts are proven, and all frequencies to a relative 1e-10, for parameters that are exactly the binary numbers stored "
        "with the results."
    )
    yield Paragraph(certainty(found.scene, proven))
    if told["open"]:
        part = ", or not in all" if "held" in told else ""
        first = ", ".join(f"{name} = {x:.17g}" for name, x in told["open_at"][0].items())
        sets = f": {told['open']:,} sets (undecided, or no dynamics){part}, the first at {first}."
        yield Notes(((Strong("NOT ANSWERED"), sets),))
    if told["out"]:
        yield Paragraph(f"Written to {told['out']}.")
