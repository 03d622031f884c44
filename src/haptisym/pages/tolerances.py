"""The page of tolerances: the verdict, the enclosures, and apart from them what is only estimated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from sympy import Expr

from haptisym.kernel.reals import RealNumber
from haptisym.model.catalogue import Hand
from haptisym.model.parameters import Parameter, spread
from haptisym.model.quantities import MotionKind, unit_text
from haptisym.model.scene import clocks
from haptisym.pages.evaluation import joint, nothing_meets
from haptisym.pages.late import drawing
from haptisym.pages.words import CHANGE, both, noted, page_about, region_of_fit, rounded, symbol
from haptisym.verbs.stability.held import Share
from haptisym.verbs.tolerances.proofs import LEVELS, Enclosure, Tolerances, Verdict, quantiles
from haptisym.writing.document import Block, Column, Document, Number, Paragraph, Phrase, Section, Strong, Table, listed
from haptisym.writing.layout import named

_VERDICTS: dict[Verdict, Phrase] = {
    Verdict.ALL: ("Proven: transparent on the whole band for ", Strong("ALL"), " values within the ranges."),
    Verdict.NONE: (
        "Proven: for ", Strong("NONE"), " of the values within the ranges is the display transparent on the whole band.",
    ),
    Verdict.DEPENDS: (
        "Proven: it ", Strong("DEPENDS"), " on the values within the ranges whether the display is transparent on the whole ",
        "band.",
    ),
    Verdict.UNDECIDED: (
        Strong("UNDECIDED"), " within the work budget: whether the display is transparent on the whole band for all values, ",
        "some or none. The enclosures below are proven.",
    ),
}  # fmt: skip


def page(a: Tolerances) -> Document:
    """The whole page."""
    scene = a.box.scene
    low, high = scene.band
    asides = filter(
        None, [scene.estimated, scene.untied_note(scene.ranges()), f"Band: {float(low):.6g} to {float(high):.6g} rad/s"]
    )
    blocks = [_varying(a), *_verdict(a), *_held(a), _enclosures(a), Paragraph(_bandwidth(a)), *_estimates(a)]
    return page_about(scene, blocks, "What holds for all values", asides)


def _varying(a: Tolerances) -> Block:
    """What varies of the display; where nothing of it does, of its hands."""
    nominal = a.nominal.values
    rows = [_side(named(x.name), nominal[x.name], (x.low, x.high), x.unit) for x in a.box.sides]
    if not rows:
        motion = a.box.scene.motion or MotionKind.TRANSLATION
        varied = [x for found in a.held for x in _ranges(found.hand)]
        rows = [_side(named(p.symbol.name), p.value, ends, p.unit_in(motion)) for p, ends in varied]
    columns = Column("varies"), Column("from", number=True), Column("to", number=True), Column(""), Column("")
    return Table(columns, tuple(rows), "The parameters that vary.")


def _side(name: Phrase, nominal: Expr, ends: tuple[Expr, Expr], unit: str) -> tuple[Phrase, ...]:
    told = "" if unit == "1" else unit_text(unit)
    return name, *(rounded(float(x), 6) for x in ends), told, spread(nominal, ends)


def _verdict(a: Tolerances) -> Iterator[Block]:
    yield Paragraph(_told(a, _VERDICTS[a.verdict] if a.box.sides else _ALONE[a.verdict]))
    examples = (("Transparent", a.transparent), ("Noticed", a.noticed))
    told: list[Phrase] = [
        (f"{how}, for example, with ", values(one.values), ".")
        for how, one in examples
        if one is not None and a.verdict in (Verdict.DEPENDS, Verdict.UNDECIDED)
    ]
    if a.limit is not None:
        told.append((
            f"Work was cut short to keep within the limit of {a.limit:g} s: enclosures may be wider than they need be, and ",
            f"{len(a.samples)} sets of values were drawn. What is said to be proven is.",
        ))  # fmt: skip
    yield from noted(told)


_ALONE: dict[Verdict, Phrase] = {
    Verdict.ALL: "Proven: the display, of which nothing varies, is transparent on the whole band.",
    Verdict.NONE: ("Proven: the display, of which nothing varies, is ", Strong("NOT"), " transparent on the whole band."),
    Verdict.UNDECIDED: (Strong("UNDECIDED"), ": whether the display, of which nothing varies, is transparent on the band."),
}  # fmt: skip
"""Where ranges are of hands alone, which change nothing of what is felt."""
_SHARES: dict[Share, Phrase] = {
    Share.ALL: ("the display is stable for ", Strong("ALL"), " values within the ranges."),
    Share.NONE: ("for ", Strong("NONE"), " of the values within the ranges is the display stable."),
    Share.SOME: ("it ", Strong("DEPENDS"), " on the values within the ranges whether the display is stable."),
}


_HANDS = (
    "Hands of the first one's mass, by stiffness and damping. White: the display is stable for all values within the ranges, "
    "and red: for none; both proven. Grey: it depends, or was not shown."
)
_LINE = " Line: the boundary for the nominal values, in floats."


def _held(a: Tolerances) -> Iterator[Block]:
    """Of each hand a sentence, with an example of either kind where it depends."""
    for x in a.held:
        ranges = [
            (named(p.symbol.name), f" from {float(low):.6g} to {float(high):.6g}") for p, (low, high) in _ranges(x.hand)
        ]
        held: Phrase = (f"held in {x.hand.name}", (" (", listed(ranges), ")") if ranges else "", ", ")
        if x.share is None:
            yield Paragraph((Strong("UNDECIDED"), ": ", held, "whether the display is stable: ", x.reason, "."))
        else:
            yield Paragraph(_told(a, ("Proven: ", held, _SHARES[x.share])))
        examples = (("Stable", x.stable), ("Not stable", x.unstable))
        if x.share is not Share.ALL and x.share is not Share.NONE:
            told = [(f"{how}, for example, with ", _at(a, found), ".") for how, found in examples if found]
            yield from noted(told)
    if a.held:
        line = "" if clocks(a.box.scene) else _LINE
        yield drawing("hands", _HANDS + line, "stability:hands_figure", a)


def _ranges(hand: Hand) -> list[tuple[Parameter, tuple[Expr, Expr]]]:
    return [(p, p.interval) for p in hand.parameters if p.interval]


def _at(a: Tolerances, found: Mapping[str, Expr]) -> Phrase:
    knobs = a.box.scene.knobs
    return values({knobs[path].name: x for path, x in found.items()})


def values(found: Mapping[str, Expr]) -> Phrase:
    """Values by name, rounded."""
    return listed((named(name), f" = {float(x):.6g}") for name, x in found.items())


def _enclosures(a: Tolerances) -> Block:
    region = joint(a.criteria)
    if not a.enclosures:
        return Paragraph(f"{nothing_meets(region)} on the band, for any values within the ranges: proven.")
    columns = (
        Column("distortion" if region else "ratio"), Column("from (rad/s)", number=True),
        Column("to (rad/s)", number=True), Column("crossings"), Column("it grows with"), Column("it falls with"),
    )  # fmt: skip
    what = (
        f"where the distortion meets the border of the {region.kind}"
        if region
        else "where the ratios meet their thresholds"
    )
    title = _told(a, f"Guaranteed: {what}, whatever the values")
    said = "An end marked = is reached, at a corner of the ranges; any other is a bound, which crossings may come near or not."
    if not a.box.sides:
        title, said = f"Proven: {what}", "An end marked = is a crossing, exactly; any other is a bound."
    dots = "Dots: crossings of the sets that were drawn at random." if a.samples else ""
    shown = f"Grey: where crossings may lie, proven for all values. {dots}".strip()
    figure = drawing("enclosures", shown, "tolerances:enclosures_figure", a)
    table = Table(columns, tuple(map(_row, a.enclosures)), "Enclosures of the crossings, proven.")
    return Section(title, (table, Paragraph(said), figure))


def _row(x: Enclosure) -> tuple[Phrase, ...]:
    count = "any number" if x.count is None else f"{x.count} always"
    moves = [[named(name) for name, n in x.monotonic.items() if n == sign] for sign in (1, -1)]
    what = CHANGE if x.criterion.joint else symbol(x.criterion.symbol)
    return what, _end(x.low, x.at_low), _end(x.high, x.at_high), count, *map(_series, moves)


def _series(names: Iterable[Phrase]) -> Phrase:
    """One, two, three; a stroke for none."""
    return tuple(x for name in names for x in (", ", name))[1:] or "-"


def _end(x: RealNumber, at: Mapping[str, Expr] | None) -> Number:
    return Number(f"{'' if at is None else '='}{x.digits(6)}", float(x))


def _bandwidth(a: Tolerances) -> Phrase:
    if a.bandwidth is None:
        return "That the display is transparent from the low end of the band on is not proven for all values."
    low, high = a.bandwidth
    if low == high:
        return _told(a, ("Proven: the bandwidth is ", both(low), "."))
    return _told(a, ("Guaranteed: the bandwidth lies between ", both(low), " and ", both(high), "."))


def _told(a: Tolerances, words: Phrase) -> Phrase:
    """What is said of the model, and of a fitted one for the region of the fit."""
    fit = region_of_fit(a.box.scene)
    first, *rest = words if isinstance(words, tuple) else (words,)
    if not fit or not isinstance(first, str):
        return words
    return f"For all values in {fit}:{first.partition(':')[2]}", *rest


def _estimates(a: Tolerances) -> Iterator[Block]:
    if not a.samples:
        return
    q = quantiles(a.samples)
    rows = (("first crossing", q.first), ("bandwidth", q.bandwidth))
    cells = tuple((name, *(_quantile(found[p]) for p in LEVELS)) for name, found in rows)
    columns = Column("rad/s"), *(Column(f"{p}\xa0%", number=True) for p in LEVELS)
    title = f"quantiles over {len(a.samples)} sets of values, drawn uniformly (seed {a.seed})"
    share = Paragraph(f"Of these sets {q.transparent} are transparent on the whole band.")
    table = Table(columns, cells, "Quantiles, estimated.")
    yield Section(("Estimated, ", Strong("NOT"), f" guaranteed: {title}"), (table, share))


def _quantile(x: float | None) -> Phrase:
    return "none" if x is None else rounded(x)
