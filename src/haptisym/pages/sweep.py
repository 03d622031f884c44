"""The page of a sweep: what was varied, what was found, and what is certain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from haptisym.kernel.reals import Way
from haptisym.pages.words import at_least, at_most, both, cell, page_about, proof, undecided, value_of
from haptisym.verbs.sweep.entry import Swept
from haptisym.writing.document import FREQUENCY_UNIT, Block, Column, Document, Facts, Figure, Phrase, Table

_FREQUENCIES: dict[str, Phrase] = {
    "bandwidth": "bandwidth",
    "first_crossing_real": "first crossing, real part",
    "first_crossing_imag": "first crossing, imaginary part",
    "first_crossing_joint": "first crossing, both parts at once",
    "changeover_environment": "changeover, environment",
    "changeover_perceived": "changeover, perceived",
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
    blocks = _frequencies(told), counts, Facts(tuple(_varied(found, told))), *figure
    return page_about(found.scene, _answer(told), blocks, _how_sure(found, told), "Sweep of parameters", found.asides())


def _answer(told: Mapping[str, Any]) -> Iterator[tuple[Phrase, Phrase]]:
    yield "Bandwidth", _frequency(told["ranges"].get("bandwidth"))
    yield "Sets", f"{told['sets']:,}"


def _varied(found: Swept, told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    for x in told["vary"]:
        knob = found.scene.knobs[x["path"]]
        low, high = (value_of(knob, end, Way.NEAREST) for end in (x["low"], x["high"]))
        yield x["path"], (low, " to ", high, f", {x['values']:,} values")
    yield "band", _frequency(told["band"])


def _frequency(span: list[float] | None) -> Phrase:
    """Of all sets the least and the largest."""
    if span is None:
        return "none"
    low, high = cell(span[0], Way.DOWN), cell(span[1], Way.UP)
    return (low, " to ", high, "\xa0", FREQUENCY_UNIT) if span[0] != span[1] else both(span[0])


def _frequencies(told: Mapping[str, Any]) -> Block:
    spans = {name: told["ranges"][key] for key, name in _FREQUENCIES.items() if key in told["ranges"]}
    rows = tuple(
        (name, *((cell(x[0], Way.DOWN), cell(x[1], Way.UP)) if x else ("none", "none"))) for name, x in spans.items()
    )
    columns = Column(FREQUENCY_UNIT), Column("least", number=True), Column("largest", number=True)
    return Table(columns, rows, "Least and largest of all sets, proven.")


def _counts(told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    clear = told["ranges"]["transparent"]
    share: Phrase = (at_least(100 * clear[0]), " to ", at_most(100 * clear[1]), "\xa0%") if clear else "none"
    yield "transparent part of the band", share
    for key, name in _CROSSINGS.items():
        if key in told["counts"]:
            counts = ", ".join(f"{n}: {sets:,}" for n, sets in told["counts"][key].items())
            yield name, f"{counts or 'none'} sets"


def _held(told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    for x in told.get("held", ()):
        yield f"stable in {x['hand']}", f"{x['stable']:,} of {told['sets']:,} sets"
        counts = [f"{n}: {sets:,}" for n, sets in x["unstable"].items()]
        counts += [f"{name}: {x[key]:,}" for key, name in _ENDLESS.items() if x[key]]
        yield f"unstable poles in {x['hand']}", f"{', '.join(counts)} sets"


_ENDLESS = {"infinite": "infinitely many", "undecided": "undecided"}


def _how_sure(found: Swept, told: Mapping[str, Any]) -> Iterator[Phrase]:
    yield proof(
        found.scene, f"all counts, and all frequencies to a relative 1e-10, for {told['sets']:,} sets of binary numbers"
    )
    if told["open"]:
        part = ", or not in all" if "held" in told else ""
        first = ", ".join(f"{name} = {x:.17g}" for name, x in told["open_at"][0].items())
        yield undecided(f"{told['open']:,} sets{part}, the first at {first}")
    if told["out"]:
        yield f"Written to {told['out']}."
