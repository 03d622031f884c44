"""The page of a sweep: what was varied, what was found, and what is proven."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from haptisym.kernel.reals import Way
from haptisym.pages import words as w
from haptisym.verbs.sweep.entry import Swept
from haptisym.writing.document import FREQUENCY_UNIT, Document, Facts, Figure, Frequency, Phrase

_FREQUENCIES = {
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
_ENDLESS = {"infinite": "infinitely many", "undecided": "undecided"}
_MOST_DRAWN = 2  # parameters that one chart shows


def page(found: Swept) -> Document:
    """Return the whole page of a sweep."""
    told = found.to_dict()
    shown = (
        "Bandwidth and first crossings over the parameter, or the bandwidth over both; see the "
        "legend."
    )
    # A parameter with one value has no axis.
    is_drawn = len(told["vary"]) <= _MOST_DRAWN and all(x["values"] > 1 for x in told["vary"])
    figure = (Figure("sweep", shown, found.figure),) if is_drawn else ()
    spans = [
        (name, told["ranges"][key]) for key, name in _FREQUENCIES.items() if told["ranges"].get(key)
    ]
    frequencies = w.table(
        spans,
        "Least and largest of all sets, proven.",
        w.Field(FREQUENCY_UNIT, lambda x: x[0]),
        w.number("least", lambda x: _ends(x[1])[0]),
        w.number("largest", lambda x: _ends(x[1])[1]),
    )
    answer = (
        ("Bandwidth", _frequency(told["ranges"].get("bandwidth"))),
        ("Sets", f"{told['sets']:,}"),
    )
    blocks = frequencies, Facts((*_counts(told), *_held(told), *_varied(found, told))), *figure
    return w.page_about(
        found.scene, answer, blocks, _how_sure(found, told), "Sweep of parameters", found.asides()
    )


def _varied(found: Swept, told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    """Yield what was varied, from where to where, and the band."""
    for x in told["vary"]:
        knob = found.scene.knobs[x["path"]]
        low, high = (w.value_of(knob, end, Way.NEAREST) for end in (x["low"], x["high"]))
        yield x["path"], (w.bare(low), " to ", high, f", {x['values']:,} values")
    yield "band", _frequency(told["band"])


def _frequency(span: list[float] | None) -> Phrase:
    """Return from where to where a frequency goes over all sets."""
    if span is None:
        return "none"
    low, high = _ends(span)
    return (low, " to ", high, "\xa0", FREQUENCY_UNIT) if span[0] != span[1] else w.both(span[0])


def _ends(span: list[float]) -> tuple[Frequency, Frequency]:
    """Return the least and the largest of all sets, rounded outwards; one and the same to the
    nearest."""
    down, up = (Way.DOWN, Way.UP) if span[0] != span[1] else (Way.NEAREST, Way.NEAREST)
    return w.cell(span[0], down), w.cell(span[1], up)


def _counts(told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    """Yield which part of the band is transparent, and in how many sets there are how many
    crossings."""
    clear = told["ranges"]["transparent"]
    share: Phrase = (
        (w.at_least(100 * clear[0]), " to ", w.at_most(100 * clear[1]), "\xa0%")
        if clear
        else "none"
    )
    yield "transparent part of the band", share
    for key, name in _CROSSINGS.items():
        if key in told["counts"]:
            yield name, ", ".join(_in_sets(*x) for x in told["counts"][key].items()) or "none"


def _held(told: Mapping[str, Any]) -> Iterator[tuple[str, Phrase]]:
    """Yield in how many sets the display is stable in each hand."""
    for x in told.get("held", ()):
        yield f"stable in {x['hand']}", f"{x['stable']:,} of {told['sets']:,} sets"
        if x["stable"] == told["sets"]:
            continue
        counts = [
            *x["unstable"].items(),
            *((name, x[key]) for key, name in _ENDLESS.items() if x[key]),
        ]
        yield f"unstable poles in {x['hand']}", ", ".join(_in_sets(*y) for y in counts)


def _in_sets(what: object, sets: int) -> str:
    """Return in how many sets something is so."""
    return f"{what} in {sets:,} set{'s' * (sets != 1)}"


def _how_sure(found: Swept, told: Mapping[str, Any]) -> Iterator[Phrase]:
    """Yield what is proven of the sets, and which are undecided."""
    if there := told["certified_in_floats"] + told["exact"]:
        sets = f"for {there:,} sets of floats"
        yield w.proof(found.scene, f"all counts, and all frequencies to a relative 1e-10, {sets}")
    if told["open"]:
        part = ", or not in all" if "held" in told else ""
        first = ", ".join(f"{name} = {x:.17g}" for name, x in told["open_at"][0].items())
        yield w.undecided(f"{told['open']:,} sets{part}, the first at {first}")
    if told["out"]:
        yield f"Written to {told['out']}."
