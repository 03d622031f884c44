"""The page of an identification: whether the model holds, what the lines tell of each parameter, and what that residuals on."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from math import ceil, floor, log10

import numpy as np

from haptisym.kernel.objects import counted
from haptisym.kernel.rings import s
from haptisym.model.distortion import distort
from haptisym.model.quantities import unit_text
from haptisym.pages.measured import linearity, measured_words
from haptisym.pages.words import noted, rounded
from haptisym.verbs.identify.entry import Estimate, Identification, correlation
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Facts,
    Figure,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
)
from haptisym.writing.equations import equation
from haptisym.writing.layout import named
from haptisym.writing.mathml import readable

_ALIKE = 0.95
"""A correlation from which on two parameters are told together rather than apart."""


def page(a: Identification) -> Document:
    """The whole page."""
    shown = "The model over what was measured, with discs, and the residuals in units of their standard error."
    figure = Figure("model", shown, a.figure)
    blocks: tuple[Block, ...] = (
        Facts(tuple(_about(a))),
        Section("Does the model hold?", (Paragraph(_verdict(a)), *noted(_tests(a)), figure), "verdict"),
        Section("Parameters", (_table(a), Notes(tuple(_told(a)))), "parameters"),
        Paragraph(_certain(a)),
    )
    return Document(a.title, (), blocks, "A model fitted to a measured response")


def _about(a: Identification) -> Iterator[tuple[str, Phrase]]:
    yield "measured", measured_words(a.measurement)
    if left := len(a.measurement) - len(a.fit.lines):
        yield "left out", f"{counted(left, 'line')}, off the band, at 0 rad/s or with no coherence at all"
    yield "model", a.wanted.words
    yield "fitted", _response(a)
    same = f"{a.fit.agreeing} of {counted(a.fit.starts, 'start')} ended in the same least sum"
    yield "search", f"least squares weighted by the discs; {same}; another may be lower"


def _response(a: Identification) -> Phrase:
    """H_perc with the numbers that were found, rounded."""
    digits = _digits(a)
    values = {x.parameter: f"{x.value:.{digits + 2}g}" for x in a.estimates}
    own, effects = a.wanted.elements(values.__getitem__)
    form, _ = readable(distort(own, *effects).perc, s, _digits(a))
    limits = "  as far as the errors let one write it; the scene file has every digit"
    return equation("H_perc", form, relation="≈"), limits


def _digits(a: Identification) -> int:
    """Two more than the best told parameter has certain ones."""
    shares = [x.error / abs(x.value) for x in a.estimates if x.value]
    return min(max(2, 1 + ceil(-log10(max(min(shares, default=1), 1e-7)))), 8)


def _certain_digits(x: Estimate, value: float, way: str = ROUND_HALF_EVEN) -> Number:
    """A number to the second digit of the error."""
    last = floor(log10(x.error)) - 1 if x.error > 0 else -12
    least = floor(log10(abs(value))) - 7 if value else last
    exact = Decimal(value).quantize(Decimal(1).scaleb(max(last, least)), rounding=way, context=Context(prec=60))
    return Number(
        f"{float(exact):.{max(0, -max(last, least))}f}" if abs(exact) < 10**7 else f"{float(exact):.8g}", value
    )


def _verdict(a: Identification) -> Phrase:
    if a.verdict.fits is None:
        unknown = ": no discs of the lines are known, so that nothing tells how large the residuals may be."
        return Strong("UNTESTED"), unknown
    if a.verdict.fits:
        return "The model fits: neither the size of the residuals nor their order speaks against it. That does not prove it."
    nearest = " fit what was measured. Its parameters are those nearest to it, and no more."
    return "The model does ", Strong("NOT"), nearest


def _tests(a: Identification) -> Iterator[Phrase]:
    v = a.verdict
    if v.square is not None and v.chance is not None:
        yield (
            "Size of the residuals: chi^2 = ", rounded(v.square), f" of {v.freedom} degrees of freedom; one as large or larger ",
            "has a chance ", *_chance(v.chance), " if the model holds.",
        )  # fmt: skip
    if v.neighbours is not None and v.neighbours_chance is not None:
        yield (
            "Order: residuals of neighbouring lines correlate by ", rounded(v.neighbours, 2), "; so much or more has a chance ",
            *_chance(v.neighbours_chance), " if they are independent.",
        )  # fmt: skip
        if v.neighbours_chance < (1 - a.fit.lines.confidence) / 3 < (v.chance or 1):
            yield "Lines of a Hann window overlap: if these do, keep every second one; that loses next to nothing."
    if a.measurement.welch and (told := linearity(a.measurement.welch)):
        yield "Linearity: ", told, "."


def _chance(x: float) -> tuple[Phrase, ...]:
    """``of 0.003``; a double has none below some 1e-308."""
    return ("of ", rounded(x, 3)) if x else ("below ", Number("1e-300", x))


def _table(a: Identification) -> Block:
    share = f"{100 * a.fit.lines.confidence:g}\xa0%"
    columns = (
        Column("parameter"), Column("value", number=True), Column("± error", number=True), Column(f"{share} interval"),
        Column("box"), Column(""),
    )  # fmt: skip
    caption = (
        "Each parameter: its standard error, its confidence interval by itself, and its side of the box that holds all "
        "parameters together."
    )
    return Table(columns, tuple(_row(a, x) for x in a.estimates), caption)


def _row(a: Identification, x: Estimate) -> tuple[Phrase, ...]:
    unit = a.unit(x)
    sides = (_ends(x, x.low, x.high), _ends(x, x.least, x.most))
    return _name(a, x), _certain_digits(x, x.value), rounded(x.error, 2), *sides, "" if unit == "1" else unit_text(unit)


def _ends(x: Estimate, low: float, high: float) -> Phrase:
    return _certain_digits(x, low, ROUND_FLOOR), " to ", _certain_digits(x, high, ROUND_CEILING)


def _name(a: Identification, x: Estimate) -> Phrase:
    """Its name, where no other parameter has that, else its path."""
    names = [other.parameter.name for other in a.estimates]
    return named(x.parameter.name) if names.count(x.parameter.name) == 1 else Code(x.parameter.path)


def _told(a: Identification) -> Iterator[Phrase]:
    if a.fit.others is None:
        yield "Whether other values give the same response was not decided."
    elif not a.fit.others:
        yield (
            "No other positive values give the same response: by equal coefficients, solved at these values to three digits, "
            "delays as they are."
        )
    else:
        for values in a.fit.others:
            yield Strong("THE SAME RESPONSE"), f" at every frequency: {a.moved(values)}."
        paths = " or ".join(a.ambiguous)
        apart = f"No line of this response tells these answers apart. A value of {paths} from elsewhere does (as in "
        yield apart, Code("model:key=value"), "), or a response of the environment without the effects."
    if a.fit.period is not None:
        apart = f"Lines {2 * np.pi / a.fit.period:.4g} rad/s apart do not tell a delay from one that is"
        yield f"{apart} {a.fit.period:.4g} s longer, which a start found; the shortest is kept."
    for x in a.estimates:
        if not x.told:
            yield "The lines do not tell ", _name(a, x), ": leave it out, or give it a value."
    shares = np.triu(np.abs(correlation(a.fit)), 1)
    for i, j in np.argwhere(shares > _ALIKE).tolist():
        one, other = (_name(a, a.estimates[k]) for k in (i, j))
        yield one, " and ", other, f" are told together more than apart: correlation {correlation(a.fit)[i, j]:.3g}."
    if a.has_ranges:
        takes = Code("haptisym tolerances"), " takes."
        yield "The scene file (", Code("--scene FILE"), ") has the box as its ranges, which ", takes
    else:
        yield "The scene file (", Code("--scene FILE"), ") has values and no ranges: here a range would mean nothing."


def _certain(a: Identification) -> Phrase:
    start = "Estimated, not proven. Errors are those of the curvature at the least sum of squares, and hold if the model is right"
    if a.verdict.square is None:
        return start, "; their size is that of the residuals themselves. Nothing is said of other frequencies."
    return (
        start, ", if the discs are, and if neighbouring lines are independent; then the box holds the true values with a ",
        f"confidence of {a.confidence_words}. Nothing is said of frequencies beyond the lines.",
    )  # fmt: skip
