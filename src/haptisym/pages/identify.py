"""The page of an identification: the parameters with their intervals, whether the model fits, and
what that rests on."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from math import ceil, floor, log10

import numpy as np

from haptisym.kernel.objects import counted
from haptisym.kernel.rings import s
from haptisym.model.distortion import distort
from haptisym.model.quantities import Dimension
from haptisym.pages.measured import linearity, measured_words
from haptisym.pages.words import (
    Field,
    both,
    near,
    noted,
    number,
    page_about,
    phrased,
    table,
    undecided,
    unit,
)
from haptisym.verbs.identify.entry import Estimate, Identification, correlation
from haptisym.verbs.identify.zwidth import ZWidthFit
from haptisym.writing import document as doc
from haptisym.writing.document import Block, Document, Phrase, Strong
from haptisym.writing.layout import equation, named
from haptisym.writing.mathml import estimated

_CORRELATED = 0.95
"""A correlation above which two parameters are called correlated."""


def page(a: Identification) -> Document:
    """Return the whole page of an identification."""
    shown = (
        "The model over the measured points, with discs, and the residuals in units of their "
        "standard error."
    )
    blocks: tuple[Block, ...] = (
        doc.Facts(tuple(_answer(a)), "findings"),
        doc.Section("Parameters", (_table(a), doc.Notes(tuple(_remarks(a)))), "parameters"),
        doc.Section(
            "Does the model fit?",
            (doc.Facts(tuple(_about(a))), *noted(_tests(a)), doc.Figure("model", shown, a.figure)),
            "verdict",
        ),
        doc.Paragraph(_how_sure(a)),
    )
    title = "A model fitted to a measured response"
    return Document(a.title, (), blocks, title, a.frequency)


def page_zwidth(a: ZWidthFit) -> Document:
    """Return the page of a device that was fitted to a Z-width plot."""
    motion = a.scene.motion
    knobs = a.scene.knobs
    rows = [(x, knobs[x.path].shown_unit(motion)) for x in a.estimates]
    shown = table(
        rows,
        "The fitted device: estimates, with the intervals of resampled walls.",
        Field("parameter", lambda x: x[0].path),
        number("estimate", lambda x: near(x[0].value, unit=x[1])),
        number("from", lambda x: near(x[0].low, unit=x[1])),
        number("to", lambda x: near(x[0].high, unit=x[1])),
    )
    walls = table(
        list(zip(a.stiffness, a.damping, a.fitted, strict=True)),
        "The walls that began to shake, and the exact limit of the fitted device.",
        number(f"K ({unit(Dimension.STIFFNESS, motion)})", lambda x: near(float(x[0]))),
        number(f"B ({unit(Dimension.DAMPING, motion)})", lambda x: near(float(x[1]))),
        number("limit of K", lambda x: near(float(x[2]))),
    )
    spread = near(100 * a.error), "\xa0% from the limit, root mean square"
    answer: list[tuple[Phrase, Phrase]] = [
        ("Fitted", (f"{counted(len(a.stiffness), 'wall')}, ", *spread))
    ]
    if a.together:
        several = " separately: fix one" if len(a.together) > 1 else ": fix it"
        named_ones = " and ".join(a.together)
        answer.append(
            ("Unique", (Strong("no"), f": the data do not identify {named_ones}{several}"))
        )
    drawn = doc.Figure("zwidth", "The walls, and the exact limit of the fitted device.", a.figure)
    how = "Estimated (95 %): least squares on the exact stability limit, intervals by bootstrap."
    sections = doc.Section("Parameters", (shown,)), doc.Section("Walls", (walls, drawn))
    return page_about(a.scene, answer, sections, (how,), "A device fitted to a Z-width plot")


def _answer(a: Identification) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the fitted response, whether the model fits, and whether it is unique."""
    yield "Fitted", _response(a)
    if a.verdict.fits is None:
        yield "Fit", "not tested: the uncertainty of the points is unknown"
    elif a.verdict.fits:
        yield (
            "Fit",
            (
                "good: neither size nor order of the residuals contradicts the model, which does "
                "not prove it"
            ),
        )
    else:
        yield (
            "Fit",
            (
                Strong("rejected"),
                ": the model does not fit; its parameters are only those nearest to the points",
            ),
        )
    if a.fit.others:
        yield "Unique", (Strong("no"), ": other values give the same response (below)")


def _about(a: Identification) -> Iterator[tuple[str, Phrase]]:
    """Yield what was measured, which model was fitted, and how it was searched for."""
    yield "measured", measured_words(a.measurement)
    if a.measurement.understood:
        yield "read", a.measurement.understood
    if omitted := len(a.measurement) - len(a.fit.lines):
        yield (
            "left out",
            f"{counted(omitted, 'point')}, off the band, at frequency 0 or without coherence",
        )
    yield "model", a.wanted.words
    same = f"{a.fit.agreeing} of {counted(a.fit.starts, 'start')} ended in the same least sum"
    yield "search", f"weighted least squares; {same}; a lower one may exist"


def _response(a: Identification) -> Phrase:
    """H_perc with the numbers that were found, rounded."""
    digits = _digits(a)
    values = {x.parameter: f"{x.value:.{digits + 2}g}" for x in a.estimates}
    own, effects = a.wanted.elements(values.__getitem__)
    form = estimated(distort(own, *effects).perc, s, _digits(a))
    return equation("H_perc", form, relation="≈")


def _digits(a: Identification) -> int:
    """Return how many digits H_perc is printed with: two more than are certain of its best known
    parameter, from 2 to 8."""
    # The smallest relative error is that of the parameter that is known best.
    shares = [x.error / abs(x.value) for x in a.estimates if x.value]
    return min(max(2, 1 + ceil(-log10(max(min(shares, default=1), 1e-7)))), 8)


def _certain_digits(estimate: Estimate, value: float, way: str = ROUND_HALF_EVEN) -> doc.Number:
    """Return a number rounded to the second digit of its error."""
    # The decimal place of the second digit of the error, but no more than eight digits of the
    # value.
    second = floor(log10(estimate.error)) - 1 if estimate.error > 0 else -12
    eighth = floor(log10(abs(value))) - 7 if value else second
    last = max(second, eighth)
    # Decimal rounds in the direction that is asked for; a format rounds to the nearest alone.
    unit = Decimal(1).scaleb(last)
    exact = Decimal(value).quantize(unit, rounding=way, context=Context(prec=60))
    return doc.Number(
        f"{float(exact):.{max(0, -last)}f}" if abs(exact) < 10**7 else f"{float(exact):.8g}", value
    )


def _tests(a: Identification) -> Iterator[Phrase]:
    """Yield the tests of the residuals: their size, their order, and whether the display is
    linear."""
    v = a.verdict
    if v.square is not None and v.chance is not None:
        words = (
            "Size of the residuals: chi^2 = {}, {} degrees of freedom; as large or larger "
            "with a probability {} if the "
            "model holds."
        )
        yield phrased(words, near(v.square), str(v.freedom), _chance(v.chance))
    if v.neighbours is not None and v.neighbours_chance is not None:
        words = (
            "Order: residuals of neighbouring points correlate by {}; as much or more with a "
            "probability {} if they are "
            "independent."
        )
        yield phrased(words, near(v.neighbours, most=2), _chance(v.neighbours_chance))
        # Residuals correlate although their size is not unlikely: overlapping windows would do
        # that, and a wrong model hardly.
        if v.neighbours_chance < (1 - a.fit.lines.confidence) / 3 < (v.chance or 1):
            yield "Points of a Hann window overlap: if these do, keep every second one."
    if a.measurement.welch and (linear := linearity(a.measurement.welch)):
        yield "Linearity: ", linear, "."


def _chance(x: float) -> tuple[Phrase, ...]:
    """``of 0.003``; a double has none below some 1e-308."""
    return ("of ", near(x, most=3)) if x else ("below ", doc.Number("1e-300", x))


def _table(a: Identification) -> Block:
    """Return the table of the parameters, with their intervals."""
    caption = (
        "Each parameter: its standard error, its confidence interval by itself, and its "
        "range where all parameters are "
        "estimated together."
    )
    units = {x.parameter.path: a.unit(x).text for x in a.estimates}
    return table(
        [_in_unit(x, float(a.unit(x).size)) for x in a.estimates],
        caption,
        Field("parameter", lambda x: _name(a, x)),
        number("value", lambda x: _certain_digits(x, x.value)),
        number("± error", lambda x: near(x.error, most=2)),
        Field(f"{100 * a.fit.lines.confidence:g}\xa0% interval", lambda x: _ends(x, x.low, x.high)),
        Field("joint range", lambda x: _ends(x, x.least, x.most)),
        Field("", lambda x: units[x.parameter.path]),
    )


def _in_unit(x: Estimate, size: float) -> Estimate:
    """Return an estimate in a unit of this size, in SI."""
    numbers = (x.value, x.error, x.low, x.high, x.least, x.most)
    return Estimate(x.parameter, *(y / size for y in numbers))


def _ends(x: Estimate, low: float, high: float) -> Phrase:
    """Return the ends of an interval, rounded outwards."""
    return _certain_digits(x, low, ROUND_FLOOR), " to ", _certain_digits(x, high, ROUND_CEILING)


def _name(a: Identification, x: Estimate) -> Phrase:
    """Its name, where no other parameter has that, else its path."""
    names = [other.parameter.name for other in a.estimates]
    return (
        named(x.parameter.name)
        if names.count(x.parameter.name) == 1
        else doc.Code(x.parameter.path)
    )


def _remarks(a: Identification) -> Iterator[Phrase]:
    """Yield which other values give the same response, and what the scene file has."""
    if a.fit.others is None:
        yield undecided("whether other values give the same response")
    elif not a.fit.others:
        yield (
            "No other positive values give the same response: equal coefficients, solved at "
            "these values to three "
            "digits, delays kept."
        )
    else:
        for values in a.fit.others:
            yield Strong("The same response"), f" at every frequency: {a.moved(values)}."
        paths = " or ".join(a.ambiguous)
        fix = (
            doc.Code("model:key=value"),
            "), or measure the response of the environment without the effects.",
        )
        yield f"No point of this response distinguishes them. Fix {paths} (", *fix
    if a.fit.period is not None:
        # At multiples of a frequency d, exp(-j omega tau) is the same for tau and tau + 2 pi/d.
        step, period = both(2 * np.pi / a.fit.period), near(a.fit.period)
        words = (
            "Points {} apart do not distinguish a delay from one that is {} s longer; the "
            "shortest is kept."
        )
        yield phrased(words, step, period)
    yield from _unidentified(a)
    if a.has_ranges:
        yield doc.Brief(
            (
                "The scene file (",
                doc.Code("--scene FILE"),
                ") has the joint ranges, for ",
                doc.Code("haptisym tolerances"),
                ".",
            )
        )
    else:
        option = doc.Brief((" (", doc.Code("--scene FILE"), ")"))
        yield (
            "The scene file",
            option,
            " has values and no ranges: here a range would mean nothing.",
        )


def _unidentified(a: Identification) -> Iterator[Phrase]:
    """Yield which parameters the data do not identify, or hardly separately."""
    for x in a.estimates:
        if not x.told:
            fix = doc.Code("model:key=value")
            yield "The data do not identify ", _name(a, x), ". Leave it out, or fix it: ", fix, "."
    # Each pair once, and no parameter with itself.
    shares = np.triu(np.abs(correlation(a.fit)), 1)
    for i, j in np.argwhere(shares > _CORRELATED).tolist():
        one, other = (_name(a, a.estimates[k]) for k in (i, j))
        words = (
            f"{{}} and {{}} are correlated ({correlation(a.fit)[i, j]:.3g}): the data hardly "
            f"identify them separately."
        )
        yield phrased(words, one, other)


def _how_sure(a: Identification) -> Phrase:
    """Return what the intervals rest on."""
    start = (
        f"Estimated ({100 * a.fit.lines.confidence:g} %): errors from the curvature at the "
        f"least sum of squares, "
        f"if the model is right"
    )
    if a.verdict.square is None:
        return (
            start,
            "; their size is that of the residuals. Nothing follows for other frequencies.",
        )
    return (
        start,
        (
            f", the discs are, and neighbouring points are independent; confidence of the joint "
            f"ranges: "
            f"{a.confidence_words}. "
        ),
        "Nothing follows for other frequencies.",
    )
