"""The page of tolerances: what holds for all values in the ranges, where crossings lie, and, apart
from that, what is estimated.

Verdicts, enclosures and counts are proven for every value of every range at once. Quantiles are of
random sets of values, and estimates. Begin with ``page``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from sympy import Expr

from haptisym.kernel.reals import ExactNumber, RealNumber, Way
from haptisym.model.catalogue import Hand
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import MotionKind
from haptisym.model.scene import clocks
from haptisym.pages import words as w
from haptisym.pages.evaluation import joint, nothing_meets
from haptisym.verbs.stability.held import Share
from haptisym.verbs.tolerances.proofs import LEVELS, BandVerdict, Enclosure, Tolerances, quantiles
from haptisym.writing import document as doc
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, Strong, listed
from haptisym.writing.layout import named


def page(a: Tolerances) -> Document:
    """Return the whole page of tolerances."""
    scene = a.box.scene
    asides = filter(None, [scene.untied_note(scene.ranges())])
    blocks = (
        *_examples(a),
        *_hands_figure(a),
        _enclosures(a),
        *w.noted(_ranges(a)),
        *_quantiles(a),
    )
    return w.page_about(
        scene, _answer(a), blocks, _proven(a), "What holds for all values in the ranges", asides
    )


# The answer.


def _answer(a: Tolerances) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the bandwidth, the verdict on the band, and that on each hand, for all values."""
    yield "Bandwidth", _bandwidth(a)
    yield "Verdict", _verdict(a)
    if not a.held:
        yield "Stability", ("not tested", doc.Brief(": add --hand NAME"))
    for x in a.held:
        yield (
            f"In {x.hand.name}",
            _SHARES[x.share] if x.share else (Strong("undecided"), f": {x.reason}"),
        )


def _bandwidth(a: Tolerances) -> Phrase:
    """Return the bandwidths of all values in the ranges, or that no common one is proven."""
    if a.bandwidth is None:
        return (
            "none common to all values is proven: for some the display may be noticed at the low "
            "end of the band"
        )
    low, high = a.bandwidth
    nominal = a.nominal.bandwidth
    if low == high:
        return w.both(low), " for all values in the ranges"
    shown: Phrase = (" (nominal ", w.cell(nominal), ")") if nominal is not None else ""
    # Outwards: the range holds the bandwidths of all values.
    ends = w.cell(low, Way.DOWN), w.cell(high, Way.UP), FREQUENCY_UNIT
    return w.phrased("{} to {}\xa0{} for all values in the ranges{}", *ends, shown)


def _verdict(a: Tolerances) -> Phrase:
    """Return whether the display is transparent on the band for all values, for none, or for
    some."""
    low, high = (w.cell(ExactNumber(x)) for x in a.box.scene.band)
    band: Phrase = (" on ", low, " to ", high, "\xa0", FREQUENCY_UNIT)
    words: dict[BandVerdict, Phrase] = {
        BandVerdict.ALL: ("transparent", band, " for ", Strong("every"), " combination of values"),
        BandVerdict.NONE: ("noticed", band, " for ", Strong("every"), " combination of values"),
        BandVerdict.DEPENDS: (Strong("depends"), " on the values whether it is transparent", band),
        BandVerdict.UNDECIDED: (Strong("undecided"), " whether it is transparent", band),
    }
    return words[a.verdict]


_SHARES: dict[Share, Phrase] = {
    Share.ALL: ("stable for ", Strong("every"), " combination of values"),
    Share.NONE: ("unstable for ", Strong("every"), " combination of values"),
    Share.SOME: (Strong("depends"), " on the values whether it is stable"),
}


def _examples(a: Tolerances) -> Iterator[Block]:
    """Values of either kind where it depends."""
    remarks: list[Phrase] = []
    # One example of either kind shows that it depends; of a proven verdict there is only one kind.
    if a.verdict in (BandVerdict.DEPENDS, BandVerdict.UNDECIDED):
        examples = (("Transparent", a.transparent), ("Noticed", a.noticed))
        remarks = [
            (f"{how}, for example, with ", _at(a, one.values), ".")
            for how, one in examples
            if one is not None
        ]
    for x in a.held:
        if x.share not in (Share.ALL, Share.NONE):
            pairs = (
                (f"Stable in {x.hand.name}", x.stable),
                (f"Unstable in {x.hand.name}", x.unstable),
            )
            remarks += [
                (f"{how}, for example, with ", _at(a, found), ".") for how, found in pairs if found
            ]
    yield from w.noted(remarks)


def _at(a: Tolerances, found: Mapping[str, Expr]) -> Phrase:
    """Return values of parameters as in a sentence."""
    knobs = a.box.scene.knobs
    rows = ((knobs[name], x) for name, x in found.items())
    return listed(
        (named(knob.name), " = ", w.value_of(knob, ExactNumber(x), Way.NEAREST)) for knob, x in rows
    )


_HANDS = (
    "Hands of the first one's mass, by stiffness and damping. White: the display is stable "
    "for all values within the ranges, "
    "and red: for none; both proven. Grey: it depends, or was not shown."
)
_LINE = " Line: the boundary for the nominal values, computed."


def _hands_figure(a: Tolerances) -> Iterator[Block]:
    """Yield the plane of hands where a hand was asked about."""
    if a.held:
        yield w.drawing(a, "hands", _HANDS + ("" if clocks(a.box.scene) else _LINE))


# Where crossings lie.


def _enclosures(a: Tolerances) -> Block:
    """Return the section of where crossings lie; a sentence where there are none for any values."""
    region = joint(a.criteria)
    if not a.enclosures:
        return doc.Paragraph(f"{nothing_meets(region)} on the band, for any values in the ranges.")
    # An end is attained if the crossing is there for some corner of the ranges; any other is a
    # bound.
    attained = any(x.at_low is not None or x.at_high is not None for x in a.enclosures)
    said = (
        f"* {'attained at a corner of the ranges' if a.box.sides else 'a crossing'}; any other "
        f"end is a bound."
    )
    dots = "Dots: crossings of the sets that were drawn at random." if a.samples else ""
    shown = f"Grey: where crossings may lie, proven for all values. {dots}".strip()
    figure = w.drawing(a, "enclosures", shown)
    rows = w.table(
        a.enclosures,
        f"Where crossings lie, proven{' for the fitted model' if a.box.scene.level else ''}.",
        w.Field(
            "distortion" if region else "ratio",
            lambda x: w.CHANGE if x.criterion.joint else w.symbol(x.criterion.symbol),
        ),
        w.number(("from (", FREQUENCY_UNIT, ")"), lambda x: _end(x.low, x.at_low, Way.DOWN)),
        w.number(("to (", FREQUENCY_UNIT, ")"), lambda x: _end(x.high, x.at_high, Way.UP)),
        w.Field(
            "crossings",
            lambda x: (
                "any number" if x.count is None else _COUNTS.get(x.count, f"exactly {x.count}")
            ),
        ),
        w.Field("increases with", lambda x: _moving(x, 1)),
        w.Field("decreases with", lambda x: _moving(x, -1)),
    )
    # If the display is transparent for all values, a ratio can at most touch its threshold.
    meet, cross = ("may touch", "may touch") if a.verdict is BandVerdict.ALL else ("meets", "cross")
    of = (
        f"the distortion {meet} the border of the {region.kind}"
        if region
        else f"the ratios {cross} their thresholds"
    )
    return doc.Section(f"Where {of}", (rows, *([doc.Paragraph(said)] if attained else []), figure))


_COUNTS = {0: "none", 1: "exactly one", 2: "exactly two"}


def _moving(x: Enclosure, sign: int) -> Phrase:
    """Return the parameters with which a crossing moves that way; a stroke for none."""
    return (
        tuple(y for name, n in x.monotonic.items() if n == sign for y in (", ", named(name)))[1:]
        or "-"
    )


def _end(x: RealNumber, at: Mapping[str, Expr] | None, way: Way) -> Phrase:
    """Return an end of an enclosure, with a star if it is attained."""
    return doc.Frequency(x, way, alone=True), "" if at is None else "*"


# The ranges, and what is estimated.


def _ranges(a: Tolerances) -> Iterator[Phrase]:
    """Yield which parameters vary, of the display and of its hands, and how far."""
    knobs = a.box.scene.knobs
    rows: list[Phrase] = [
        (
            named(x.name),
            " ",
            # The lower end without its unit, which stands behind the upper end.
            doc.Real(ExactNumber(x.low / knobs[x.name].shown_unit(None).size), Way.DOWN),
            " to ",
            w.value_of(knobs[x.name], ExactNumber(x.high), Way.UP),
        )
        for x in a.box.sides
    ]
    motion = a.box.scene.motion or MotionKind.TRANSLATION
    for found in a.held:
        rows += [
            (
                f"hand.{p.key} ",
                w.near(ExactNumber(low)),
                " to ",
                w.near(ExactNumber(high), unit=p.shown_unit(motion)),
            )
            for p, (low, high) in _of_hand(found.hand)
        ]
    yield "Ranges: ", tuple(y for x in rows for y in (", ", x))[1:], "."


def _of_hand(hand: Hand) -> list[tuple[Parameter, tuple[Expr, Expr]]]:
    """Return the parameters of a hand that have ranges, with these."""
    return [(p, p.interval) for p in hand.parameters if p.interval]


def _quantiles(a: Tolerances) -> Iterator[Block]:
    """Yield the table of quantiles over random sets of values, which are estimates."""
    if not a.samples:
        return
    q = quantiles(a.samples)
    # Where both have the same quantiles, as every first crossing is a bandwidth, one row is enough.
    rows = [("first crossing", q.first), ("bandwidth", q.bandwidth)][q.first == q.bandwidth :]
    levels = (
        w.number(f"{p}\xa0%", lambda x, p=p: "none" if x[1][p] is None else w.cell(x[1][p]))  # type: ignore[misc]
        for p in LEVELS
    )
    shown = w.table(rows, "Quantiles, estimated.", w.Field(FREQUENCY_UNIT, lambda x: x[0]), *levels)
    title = (
        f"Estimated: quantiles over {len(a.samples)} random sets of values (uniform, seed {a.seed})"
    )
    share = doc.Paragraph(
        f"Transparent on the whole band: {q.transparent or 'none'} of these sets."
    )
    yield doc.Section(title, (shown, share))


def _proven(a: Tolerances) -> Iterator[Phrase]:
    """Yield what is proven for all values, and what is undecided."""
    fit = a.box.scene.region_of_fit
    parts = [
        *(["verdict"] if a.verdict is not BandVerdict.UNDECIDED else []),
        *(["bandwidth"] if a.bandwidth is not None else []),
        "crossings",
        *(["stability"] if any(x.share for x in a.held) else []),
    ]
    what = listed(parts)
    # The ranges of a fitted scene are estimated themselves: proven is only what follows from them.
    if fit:
        yield (
            "Proven for the fitted model: ",
            what,
            f", for every value in the {fit}; the ranges are estimated.",
        )
    else:
        yield "Proven: ", what, ", for every value in the ranges."
    if a.verdict is BandVerdict.UNDECIDED:
        yield w.undecided(
            "whether the display is transparent on the whole band for all values, some or none"
        )
    if a.why:
        yield w.undecided(
            f"whether intervals are narrower; {len(a.samples)} of {a.count} sets were drawn: "
            f"{a.why}"
        )
