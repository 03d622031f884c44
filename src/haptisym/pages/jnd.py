"""The pages of just-noticeable differences.

Of a measured one: the threshold, its interval, the line for a scene, and the answers beside the
fitted curve psi(x) = gamma + (1 - gamma - lambda) Phi((x - mu)/sigma). Of the published ones: a
table, and their sources.
"""

from __future__ import annotations

from collections.abc import Iterator
from statistics import NormalDist

import numpy as np

from haptisym.model.jnd import Published
from haptisym.pages.words import Field, near, noted, number, phrased, table
from haptisym.verbs.jnd.entry import METHODS, IntervalEstimate, Psychometric, PublishedThresholds
from haptisym.writing import document as doc
from haptisym.writing.boxes import Applied, Box, Fenced, Fraction, Numeral, SideBySide, Sum
from haptisym.writing.document import Block, Document, Phrase, Strong
from haptisym.writing.layout import named


def page(p: Psychometric) -> Document:
    """Return the whole page of a measured JND."""
    caption = (
        "Shares of the answers at each level (the larger a dot, the more answers) and the fitted "
        "curve."
    )
    blocks: tuple[Block, ...] = (
        doc.Facts(tuple(_found(p)), "findings"),
        *_warned(p),
        *_for_a_scene(p),
        doc.Section(
            "The curve", (doc.Equations((_equation(p),)), doc.Facts(tuple(_facts(p)))), "curve"
        ),
        doc.Figure("answers", caption, p.figure),
        doc.Section("The responses", (_answers(p),), "answers"),
        *noted(p.notes),
        doc.Notes((_ESTIMATED, f"Method: {METHODS[p.method]}.")),
    )
    return Document(p.answers.name, (), blocks, "A just-noticeable difference, measured")


_ESTIMATED = (
    "Estimated from these responses: another person, or another day, gives others. The "
    "interval is what chance alone "
    "makes of them, "
    "if the curve is the right one."
)


def _percent(share: float) -> str:
    """Return a share in per cent."""
    return f"{100 * share:.4g}\xa0%"


def _estimate(p: Psychometric, x: IntervalEstimate) -> Phrase:
    """Return an estimate with its interval, where that has an end."""
    ends = tuple("unbounded" if end is None else near(end) for end in (x.low, x.high))
    if ends == ("unbounded", "unbounded"):
        return near(x.value)
    return near(x.value), f" ({_percent(p.confidence)}: ", ends[0], " to ", ends[1], ")"


def _found(p: Psychometric) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the JND, the fraction, whether the curve fits, and how it stands in a scene."""
    share, choices = _percent(p.asked.proportion), p.asked.alternatives
    of = "right" if choices else "“more”"
    where = (
        f", of {choices} alternatives" if choices else ", beyond the point of subjective equality"
    )
    curve, chance = p.fit.curve, p.asked.chance if choices else 0.0
    # The proportion is that of a curve without lapses. With lapses, or guesses beyond chance, two
    # levels are told apart: where it would be reached without these, and where it is.
    if curve.guess == chance and not curve.lapse:
        yield "JND", (_estimate(p, p.jnd), f", where {share} of the responses are {of}{where}")
    else:
        level = p.jnd.value if choices else curve.mu + p.jnd.value
        without = "lapses" if choices else "guesses and lapses"
        seen = _percent(float(curve(np.array([level]))[0]))
        yield (
            "JND",
            (
                _estimate(p, p.jnd),
                f", where without {without} {share} of the responses would be {of}{where}",
            ),
        )
        # The share p of all answers belongs to Phi = (p - gamma)/(1 - gamma - lambda), which has a
        # level only between 0 and 1.
        inner = (p.asked.proportion - curve.guess) / (1 - curve.guess - curve.lapse)
        there: Phrase = "at no level"
        if 0 < inner < 1:
            there = near(curve.mu * bool(choices) + NormalDist().inv_cdf(inner) * curve.sigma)
        yield "with lapses", (f"{seen} of all responses are {of} there; {share} of all: ", there)
    if p.fraction and p.reference:
        yield "fraction", (_estimate(p, p.fraction), " of the standard, ", near(p.reference))
    yield "fit", _fit(p)
    if not p.table:
        how = "a threshold is a fraction of the standard: give its level with "
        yield "in a scene", (how, doc.Code("--reference"), " (1 for fractions)")


def _for_a_scene(p: Psychometric) -> Iterator[Block]:
    """The threshold as a table of a scene file, line by line."""
    if p.table:
        lines = ("[evaluation.jnd]", *(f"{key} = {value}" for key, value in p.table.items()))
        yield doc.Section("In a scene", (doc.Notes(tuple(map(doc.Code, lines))),), "scene")


def _fit(p: Psychometric) -> Phrase:
    """Return whether the answers scatter about the curve no more than by chance."""
    tested = p.deviance
    if tested.p is None:
        return "cannot be tested: no more levels with enough answers than numbers that are fitted"
    within: Phrase = "within chance" if tested.fits else (Strong("not"), " within chance")
    words = f"deviance {{}}, {tested.degrees} degrees of freedom, p = {{}}: {{}}"
    return phrased(words, near(tested.value), near(tested.p, most=2), within)


def _warned(p: Psychometric) -> Iterator[Block]:
    """Yield what forbids to rely on the JND: a curve that does not fit, an interval without an
    end."""
    if p.deviance.fits is False:
        words = (
            "The curve does {} fit these responses: neither the JND nor its interval can be "
            "relied on. See the figure; causes "
            "are lapses, learning, or responses of several people put together."
        )
        yield doc.Paragraph(phrased(words, Strong("not")))
    if p.jnd.high is None:
        words = (
            "The interval has {} upper end: these responses do not bound the JND. It takes "
            "more of them, or levels farther from "
            "the standard."
        )
        yield doc.Paragraph(phrased(words, Strong("no")))


def _equation(p: Psychometric) -> doc.Line:
    """Return the equation of the fitted curve."""
    curve = p.fit.curve
    x, mu, sigma = (named(name) for name in ("x", "mu", "sigma"))
    phi = Applied(named("Phi"), (Fraction(Sum(((1, x), (-1, mu))), sigma),))
    if not curve.guess and not curve.lapse:
        return doc.Line(Applied(named("psi"), (x,)), phi)
    share: Box = Sum(((1, Numeral("1")), (-1, named("gamma")), (-1, named("lambda"))))
    return doc.Line(
        Applied(named("psi"), (x,)),
        Sum(((1, named("gamma")), (1, SideBySide((Fenced(share), phi))))),
    )


def _facts(p: Psychometric) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the parameters of the fitted curve."""
    curve = p.fit.curve
    middle = "middle of the curve" if p.asked.alternatives else "point of subjective equality"
    yield named("mu"), (_estimate(p, p.middle), f", the {middle}")
    yield named("sigma"), near(curve.sigma)
    if curve.guess or curve.lapse:
        yield named("gamma"), (near(curve.guess), ", guesses")
        yield named("lambda"), (near(curve.lapse), ", lapses")
    if p.answers.earlier:
        yield "in the file", p.answers.earlier


_MOST_ROWS = 40


def _answers(p: Psychometric) -> Block:
    """Return the table of the answers, or their number where there are many levels."""
    rows = p.answers.rows
    if len(rows) > _MOST_ROWS:
        trials = sum(x.trials for x in rows)
        return doc.Paragraph(
            f"{trials} responses at {len(rows)} levels, from {rows[0].level:g} to "
            f"{rows[-1].level:g}."
        )
    curve = p.fit.curve(np.array([x.level for x in rows]))
    return table(
        zip(rows, curve, strict=True),
        ("The responses: how many (k) of how many (n) counted at each level, and the curve there."),
        number("level", lambda x: near(x[0].level)),
        number("k", lambda x: str(x[0].count)),
        number("n", lambda x: str(x[0].trials)),
        number("share", lambda x: f"{x[0].share:.3f}"),
        number("curve", lambda x: f"{x[1]:.3f}"),
    )


def published_page(found: PublishedThresholds) -> Document:
    """The page of published thresholds: what they are, and where they come from."""
    named = next(x.name for x in found if x.criterion)
    like = doc.Code(f'jnd = {{ like = "{named}" }}')
    lead = phrased("By its name in a scene: {}; a range gives a range of bandwidths.", like)
    shown = table(
        found,
        (
            "Published thresholds, and the share of answers at which each was taken where that "
            "is known."
        ),
        Field("name", lambda x: doc.Code(x.name)),
        Field("JND", lambda x: x.written.replace(" %", "\xa0%")),
        Field("criterion", _criterion),
        Field("of what", lambda x: x.quantity),
    )
    blocks = (
        shown,
        doc.Section(
            "Sources, and how far they were read", (doc.Notes(tuple(map(_reference, found))),)
        ),
        doc.Paragraph(_DIFFER),
    )
    return Document("Published thresholds", (lead,), blocks, "Just-noticeable differences")


_DIFFER = (
    "They differ in what was felt, by whom, in movement and criterion. None was measured on your "
    "display."
)


def _criterion(x: Published) -> str:
    """Return at which share of correct answers a threshold was taken, where that is known."""
    return "" if x.criterion is None else f"{float(100 * x.criterion):g}\xa0%"


def _reference(x: Published) -> Phrase:
    """Return the source of a published threshold, and how far it was read."""
    doi = f", doi:{x.doi}" if x.doi else ""
    apart = f". Not for a scene: {x.apart}" if x.apart else ""
    return doc.Code(x.name), f": {x.source}{doi} [{x.read}]; {x.reference}{apart}."
