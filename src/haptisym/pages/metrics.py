"""The page of the measures of transparency: for each its formulas, its numbers, its source, and
what it says."""

from __future__ import annotations

import re
from collections.abc import Iterator

from haptisym.judge.passivity import Beyond
from haptisym.kernel.objects import counted
from haptisym.kernel.reals import RealNumber, short
from haptisym.kernel.rings import RationalFunction, omega, s
from haptisym.model.quantities import unit_text
from haptisym.pages import words as w
from haptisym.verbs.metrics.controlloading import ControlLoading, Trial
from haptisym.verbs.metrics.freeresponse import FlightRule
from haptisym.verbs.metrics.metric import Form, Metric, Metrics, MetricValue
from haptisym.writing import boxes
from haptisym.writing import document as doc
from haptisym.writing.boxes import Box, text
from haptisym.writing.document import Block, Document, Phrase, Strong
from haptisym.writing.latex import tex
from haptisym.writing.layout import layout, meaning, named, quantity
from haptisym.writing.mathml import readable

_MOST_LETTERS = 180  # of a formula in symbols; a longer one is told in numbers


def page(m: Metrics) -> Document:
    """Return the whole page of the measures."""
    shown = (
        "Distance of each measure from transparency over the band, and below where each measure "
        "is satisfied."
    )
    # A note on absolute stability is left out where that measure is.
    remarks = (x for x in m.notes if m.tell_absolute or "absolutely stable" not in x)
    notes = doc.Section("Where they disagree", w.noted(map(formulated, remarks)))
    blocks: tuple[Block, ...] = (
        _overview(m),
        notes,
        doc.Formulas(lambda: map(_measure, m.told)),
        doc.Figure("metrics", shown, m.figure),
        *w.caveats(m.evaluation.caveats),
    )
    return w.page_about(
        m.scene,
        (("JND", jnd_verdict(m)),),
        blocks,
        _proven(m),
        "Measures of transparency",
        m.asides(),
        ("--all",),
    )


def control_page(found: ControlLoading) -> Document:
    """The report on a control by a rule: the tests, what was not tested and why, the JND's
    verdict."""
    # None is a test that could not be made, which neither passes nor fails.
    tested = [x for x in found.trials if x.passes is not None]
    failed, unmade = len(found.failed), len(found.untested)
    result: Phrase = (
        Strong(f"fails {failed} of {counted(len(tested), 'test')}")
        if failed
        else f"passes {counted(len(tested), 'test')}"
    )
    travel: Phrase = "" if found.travel is None else ("; travel ", w.near(found.travel), " m")
    answer = (
        ("Result", (result, f"; {unmade} not tested" if unmade else "")),
        ("Rule", (f"14 CFR Part 60, table {found.rule.value}, {found.control}", travel)),
        ("JND", jnd_verdict(found)),
    )
    caption = "The tests: the environment is the aircraft's control, the display is the device's."
    judged = {True: "yes", False: "no", None: ""}
    shown = w.table(
        [x for x in found.trials if x.environment is not None],
        caption,
        w.Field("entry", lambda x: x.entry, full=True),
        w.Field("test", _test),
        w.Field("tolerance", _tolerance),
        w.number("aircraft", lambda x: _plain(x.environment)),
        w.number("display", lambda x: _plain(x.display)),
        w.number("margin", lambda x: "" if x.margin is None else f"{100 * x.margin:.1f}\xa0%"),
        w.Field("result", lambda x: _RESULT[x.passes]),
        w.Field("noticed", lambda x: judged[x.noticed]),
    )
    untested = doc.Section(
        "Not tested", w.noted((f"{x.entry} {x.name}", f": {x.why}") for x in found.untested)
    )
    figure = doc.Figure(
        "free-response",
        (
            "Free response of the aircraft's control and of the display; dotted: 5 % of the "
            "displacement."
        ),
        found.figure,
    )
    released = doc.Versions((), lambda: [figure])
    meanings = doc.Notes(tuple(map(formulated, _meanings(found))))
    blocks: tuple[Block, ...] = (
        shown,
        meanings,
        released,
        untested,
        *w.caveats(found.evaluation.caveats),
    )
    proven = (
        (w.undecided("a test"),)
        if not found.certified
        else (w.proof(found.scene, "results, and all digits printed but margins"),)
    )
    return w.page_about(
        found.scene, answer, blocks, proven, "Control-loading report", found.asides(), ()
    )


_RESULT: dict[bool | None, Phrase] = {True: "passes", False: Strong("fails"), None: "not tested"}


def _meanings(found: ControlLoading) -> Iterator[str]:
    """Yield what the names of the tests mean, for those that were made."""
    tested = {x.name.partition(" ")[0] for x in found.trials if x.environment is not None}
    start = "the release" if found.rule is FlightRule.HELICOPTER else "90 % of A_d"
    response = (
        f"P_0: from {start} to the first zero crossing; P_1, P_2: periods; A_1, A_2: overshoots."
    )
    swept = "Sweep: force above the slow one, per travel."
    known = [
        x
        for x, made in (
            (response, tested - {"static", "breakout", "sweep"}),
            (swept, "sweep" in tested),
        )
        if made
    ]
    if known:
        yield " ".join(known)
    yield (
        "Margin: share of the tolerance left (100 %: no change, 0: at the limit). Noticed: "
        "by the JND, at the frequency of "
        "the test; of a free response, on the band."
    )


def _test(x: Trial) -> Phrase:
    """A test in a few letters; what they mean is below the table."""
    short = (
        x.name.partition(",")[0]
        .replace("time from ", "")
        .replace(" of A_d", "")
        .replace("above", ">")
    )
    return (formulated(short), f" ({unit_text(x.unit)})" if x.unit else "")


def _tolerance(x: Trial) -> Phrase:
    """Return the tolerance of a test in a few letters."""
    return formulated(
        x.tolerance.replace("the same number to within ", "±").replace(" above static", "")
    )


def _plain(x: RealNumber | int | None) -> Phrase:
    """Return a number of a test; none where it has none, as a motion without overshoot."""
    return "none" if x is None else w.near(x) if isinstance(x, RealNumber) else str(x)


def jnd_verdict(m: Metrics | ControlLoading) -> Phrase:
    """Return the verdict of the JND evaluation in a line."""
    bands = m.evaluation.transparent
    return (
        "transparent ",
        w.spans(bands) if bands else "nowhere on the band",
        " (",
        w.limits(m.scene.threshold),
        ")",
    )


_DESCRIBED = "relative distortion", "impedance range", "sensitivity", "effective impedance"
"""Measures without a verdict of their own: their sentence, which is true of every display, stands
below their formulas."""


def _overview(m: Metrics) -> doc.Table:
    """Return the table of verdicts, one row for measures with the same one."""
    names: dict[Phrase, list[str]] = {}
    for x in m.told:
        if x.name not in _DESCRIBED:
            # Measures with the same verdict share a row.
            names.setdefault(_at(x.verdict, x.at), []).append(x.name)
    rows = [
        # Several measures that share a verdict are named by the first, without what follows its
        # comma.
        (x[0] if len(x) == 1 else x[0].partition(",")[0], verdict)
        for verdict, x in names.items()
    ]
    return doc.Table(
        (doc.Column("measure"), doc.Column("verdict")), tuple(rows), "The verdict of each measure."
    )


def _at(words: str, omega: RealNumber | None) -> Phrase:
    """Words in which the frequency is in the unit of the page."""
    if omega is None:
        return formulated(words)
    # The verdict has the frequency as text in rad/s: it is cut out and put back as a frequency,
    # which each page prints in its own unit.
    before, found, after = words.partition(f"{short(omega)} rad/s")
    return (formulated(before), w.both(omega), formulated(after)) if found else formulated(words)


def _measure(x: Metric) -> doc.Section:
    """Return the section of one measure: formulas, numbers, source."""
    blocks: list[Block] = []
    if formulas := tuple(written(x)):
        blocks.append(doc.Equations(formulas))
    numbers = []
    for v in x.values:
        label = _WHAT.get(v.what, v.what)
        numbers.append((_at(label, v.at), _value(v)))
    if numbers:
        blocks.append(doc.Facts(tuple(numbers)))
    source = f"Source: {x.source} [{x.evidence}]"
    if x.name in _DESCRIBED:
        verdict = f"{x.verdict[0].upper()}{x.verdict[1:]}."
        blocks.append(doc.Notes((formulated(verdict), source)))
    else:
        blocks.append(doc.Notes((source,)))
    return doc.Section(f"{x.name[0].upper()}{x.name[1:]}", tuple(blocks))


_WHAT = {"Im H_perc beyond that": "Im H_perc above that"}
_WORDS = {
    Beyond.NEVER.value: "≥ 0 everywhere",
    Beyond.ALWAYS.value: "< 0 everywhere",
    Beyond.AGAIN.value: "< 0 at infinitely many higher frequencies",
    Beyond.UNKNOWN.value: "undecided",
    Beyond.CLOCK.value: "not tested: above half the sampling rate",
    "holds": "passive",
    "does not hold": "not passive",
    Beyond.LATE.value: "not tested: the delays turn many times before it settles",
    "not decided": "undecided",
}
"""Values of the document of JSON, and the words for them on the page."""


def _value(x: MetricValue) -> Phrase:
    """Return a value of a measure in words."""
    if isinstance(x.value, str) and x.value in _WORDS:
        return _WORDS[x.value]
    if x.value is None:
        return "infinite"
    if isinstance(x.value, tuple):
        return w.spans(x.value) if x.value else "nowhere"
    if x.reference is None:
        return _number(x.value, x.unit)
    verdict: Phrase = "satisfied" if x.kept else Strong("not satisfied")
    return (
        _number(x.value, x.unit),
        ", environment ",
        _number(x.reference, x.unit),
        f"; tolerance {x.tolerance}: ",
        verdict,
    )


def _number(x: RealNumber | int | str, unit: str) -> Phrase:
    """Return a number with its unit; frequencies also in Hz."""
    if isinstance(x, RealNumber) and unit == "rad/s":
        return w.both(x)
    return (
        w.near(x) if isinstance(x, RealNumber) else str(x)
    ), f"\xa0{unit_text(unit)}" if unit else ""


_SYMBOL = re.compile(r"\b((?:H|Z|r|P|A)_(?:env|perc|min|max|width|r|i|d|\d+))\b")


def formulated(words: str) -> Phrase:
    """Words in which the names of quantities are formulas."""
    return tuple(
        # A split by a pattern with one group gives words and names in turn.
        named(x) if i % 2 else x
        for i, x in enumerate(_SYMBOL.split(words.replace(">=", "≥")))
        if x
    )


def _proven(m: Metrics) -> Iterator[Phrase]:
    """Yield what is proven of the measures."""
    if not m.decided:
        yield w.proof(m.scene, "all else")
    elif not m.certified:
        yield w.undecided(
            "whether some function is tangent to its limit, crosses it twice or stays clear "
            "of it, at the precision limit"
        )
        yield w.proof(m.scene, "all else")
    else:
        yield w.proof(m.scene, "every limit, band and number")


# Formulas.


def formulas(x: Metric) -> list[dict[str, str]]:
    """The formulas of a measure for its document of JSON."""
    return [{"text": text(line.equation), "latex": tex(line.equation)} for line in written(x)]


def written(x: Metric) -> Iterator[doc.Line]:
    """The formulas of a measure: what defines it, and the closed forms of what it is."""
    yield from _CONDITIONS.get(x.name, ())
    yield from map(_closed, x.forms)


def _closed(form: Form) -> doc.Line:
    """Return the closed form of a quantity: its name, its definition, and its value."""
    left, means = _DEFINITIONS[form.name]
    # In symbols where that is short, else in numbers, else by its definition alone.
    known = form.symbolic.factored() if form.symbolic else None
    if known is not None and len(text(layout(known))) <= _MOST_LETTERS:
        return doc.Line(left, known, meaning=means)
    if form.numeric is None:
        return doc.Line(left, means)
    function = form.numeric
    shown = (
        readable(function, s)
        if isinstance(function, RationalFunction)
        else readable(function.written, omega)
    )
    return doc.Line(left, *shown, means) if shown else doc.Line(left, means)


def _of_s(name: str) -> Box:
    """Return a function of s by its name."""
    return boxes.Titled(f"{name}(s)", boxes.Applied(named(name), (named("s"),)))


def _im(of: Box) -> Box:
    """Return the imaginary part of a box."""
    return boxes.Prefixed(boxes.Operator("Im"), of)


_H_ENV, _H_PERC, _DH = (quantity(x) for x in ("H_env", "H_perc", "dH"))
_A, _B, _C, _D, _G = (named(x) for x in ("A", "B", "C", "D", "g"))
_ZERO, _TWO = boxes.Numeral("0"), boxes.Numeral("2")
_DET = boxes.Sum(((1, boxes.SideBySide((_A, _D))), (-1, boxes.SideBySide((_B, _C)))))
_SLOPE = boxes.Titled(
    "dH_perc/dH_env",
    boxes.Fraction(
        boxes.SideBySide((boxes.Operator("d"), _H_PERC)),
        boxes.SideBySide((boxes.Operator("d"), _H_ENV)),
    ),
)
_DEFINITIONS: dict[str, tuple[Box, Box]] = {
    "Gamma": (_of_s("Gamma"), boxes.Fraction(_H_PERC, _H_ENV)),
    "Theta": (_of_s("Theta"), boxes.Fraction(_DH, _H_ENV)),
    "Z_min": (_of_s("Z_min"), boxes.Fraction(_B, _D)),
    "Z_max": (_of_s("Z_max"), boxes.Fraction(_A, _C)),
    "Z_width": (_of_s("Z_width"), boxes.Fraction(_DET, boxes.SideBySide((_C, _D)))),
    "dH_perc/dH_env": (
        _SLOPE,
        boxes.Fraction(
            _DET,
            boxes.Power(
                boxes.Fenced(boxes.Sum(((1, boxes.SideBySide((_C, _H_ENV))), (1, _D)))), _TWO
            ),
        ),
    ),
    "g": (_G, boxes.Fraction(_DET, boxes.Power(_D, _TWO))),
    **{name: (quantity(name), meaning(name)) for name in ("k_perc", "m_perc", "b_perc")},
}
_FIRST, _SECOND = _im(boxes.Fraction(_B, _D)), _im(boxes.Fraction(_C, _D))
_MARGIN = boxes.Sum(
    ((1, boxes.Prefixed(boxes.Operator("Re"), _G)), (-1, boxes.SideBySide((_TWO, _FIRST, _SECOND))))
)
_CONDITIONS = {
    "passivity": (doc.Line(_im(_H_PERC), _ZERO, "≥"),),
    "absolute stability": (
        doc.Line(_FIRST, _ZERO, "≥"),
        doc.Line(_SECOND, _ZERO, "≤"),
        doc.Line(_MARGIN, boxes.Absolute(_G), "≥"),
    ),
}
