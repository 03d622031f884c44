"""The page of tolerances: what holds for all values in the ranges, where crossings lie, and apart from that what is estimated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from sympy import Expr

from haptisym.kernel.reals import ExactNumber, RealNumber, Way
from haptisym.model.catalogue import Hand
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import MotionKind
from haptisym.model.scene import clocks
from haptisym.pages.evaluation import joint, nothing_meets
from haptisym.pages.late import drawing
from haptisym.pages.words import (
    CHANGE,
    both,
    cell,
    near,
    noted,
    page_about,
    region_of_fit,
    symbol,
    undecided,
    value_of,
)
from haptisym.verbs.stability.held import Share
from haptisym.verbs.tolerances.proofs import LEVELS, Enclosure, Tolerances, Verdict, quantiles
from haptisym.writing.document import (
    FREQUENCY_UNIT,
    Block,
    Column,
    Document,
    Frequency,
    Paragraph,
    Phrase,
    Real,
    Section,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import named


def page(a: Tolerances) -> Document:
    """The whole page."""
    scene = a.box.scene
    asides = filter(None, [scene.estimated, scene.untied_note(scene.ranges())])
    blocks = (*_examples(a), *_hands_figure(a), _enclosures(a), *noted(_ranges(a)), *_quantiles(a))
    return page_about(scene, _answer(a), blocks, _proven(a), "What holds for all values in the ranges", asides)


# The answer.


def _answer(a: Tolerances) -> Iterator[tuple[Phrase, Phrase]]:
    yield "Bandwidth", _bandwidth(a)
    yield "Verdict", _verdict(a)
    if not a.held:
        yield "Stability", "not tested: add --hand NAME"
    for x in a.held:
        yield f"In {x.hand.name}", _SHARES[x.share] if x.share else (Strong("undecided"), f": {x.reason}")


def _bandwidth(a: Tolerances) -> Phrase:
    if a.bandwidth is None:
        return "none common to all values is proven: for some the display may be noticed at the low end of the band"
    low, high = a.bandwidth
    nominal = a.nominal.bandwidth
    if low == high:
        return both(low), " for all values in the ranges"
    shown: Phrase = (" (nominal ", cell(nominal), ")") if nominal is not None else ""
    return (
        cell(low, Way.DOWN),
        " to ",
        cell(high, Way.UP),
        "\xa0",
        FREQUENCY_UNIT,
        " for all values in the ranges",
        shown,
    )


def _verdict(a: Tolerances) -> Phrase:
    low, high = (cell(ExactNumber(x)) for x in a.box.scene.band)
    band: Phrase = (" on ", low, " to ", high, "\xa0", FREQUENCY_UNIT)
    words: dict[Verdict, Phrase] = {
        Verdict.ALL: ("transparent", band, " for ", Strong("every"), " combination of values"),
        Verdict.NONE: ("noticed", band, " for ", Strong("every"), " combination of values"),
        Verdict.DEPENDS: (Strong("depends"), " on the values whether it is transparent", band),
        Verdict.UNDECIDED: (Strong("undecided"), " whether it is transparent", band),
    }
    return words[a.verdict]


_SHARES: dict[Share, Phrase] = {
    Share.ALL: ("stable for ", Strong("every"), " combination of values"),
    Share.NONE: ("unstable for ", Strong("every"), " combination of values"),
    Share.SOME: (Strong("depends"), " on the values whether it is stable"),
}


def _examples(a: Tolerances) -> Iterator[Block]:
    """Values of either kind where it depends."""
    told: list[Phrase] = []
    if a.verdict in (Verdict.DEPENDS, Verdict.UNDECIDED):
        examples = (("Transparent", a.transparent), ("Noticed", a.noticed))
        told = [(f"{how}, for example, with ", _at(a, one.values), ".") for how, one in examples if one is not None]
    for x in a.held:
        if x.share not in (Share.ALL, Share.NONE):
            pairs = ((f"Stable in {x.hand.name}", x.stable), (f"Unstable in {x.hand.name}", x.unstable))
            told += [(f"{how}, for example, with ", _at(a, found), ".") for how, found in pairs if found]
    yield from noted(told)


def _at(a: Tolerances, found: Mapping[str, Expr]) -> Phrase:
    knobs = a.box.scene.knobs
    rows = ((knobs[name], x) for name, x in found.items())
    return listed((named(knob.name), " = ", value_of(knob, ExactNumber(x), Way.NEAREST)) for knob, x in rows)


_HANDS = (
    "Hands of the first one's mass, by stiffness and damping. White: the display is stable for all values within the ranges, "
    "and red: for none; both proven. Grey: it depends, or was not shown."
)
_LINE = " Line: the boundary for the nominal values, computed."


def _hands_figure(a: Tolerances) -> Iterator[Block]:
    if a.held:
        yield drawing("hands", _HANDS + ("" if clocks(a.box.scene) else _LINE), "sheet:draw_figure", a, "hands")


# Where crossings lie.


def _enclosures(a: Tolerances) -> Block:
    region = joint(a.criteria)
    if not a.enclosures:
        return Paragraph(f"{nothing_meets(region)} on the band, for any values in the ranges.")
    columns = (
        Column("distortion" if region else "ratio"), Column(("from (", FREQUENCY_UNIT, ")"), number=True),
        Column(("to (", FREQUENCY_UNIT, ")"), number=True), Column("crossings"), Column("increases with"),
        Column("decreases with"),
    )  # fmt: skip
    attained = any(x.at_low is not None or x.at_high is not None for x in a.enclosures)
    said = (
        "* attained at a corner of the ranges; any other end is a bound."
        if a.box.sides
        else "* a crossing; any other end is a bound."
    )
    dots = "Dots: crossings of the sets that were drawn at random." if a.samples else ""
    shown = f"Grey: where crossings may lie, proven for all values. {dots}".strip()
    figure = drawing("enclosures", shown, "sheet:draw_figure", a, "enclosures")
    table = Table(columns, tuple(map(_row, a.enclosures)), "Where crossings lie, proven.")
    of = f"the distortion meets the border of the {region.kind}" if region else "the ratios cross their thresholds"
    return Section(f"Where {of}", (table, *([Paragraph(said)] if attained else []), figure))


def _row(x: Enclosure) -> tuple[Phrase, ...]:
    count = "any number" if x.count is None else _COUNTS.get(x.count, f"exactly {x.count}")
    moves = [[named(name) for name, n in x.monotonic.items() if n == sign] for sign in (1, -1)]
    what = CHANGE if x.criterion.joint else symbol(x.criterion.symbol)
    ends = _end(x.low, x.at_low, Way.DOWN), _end(x.high, x.at_high, Way.UP)
    return what, *ends, count, *map(_series, moves)


_COUNTS = {1: "exactly one", 2: "exactly two"}


def _series(names: Iterable[Phrase]) -> Phrase:
    """One, two, three; a stroke for none."""
    return tuple(x for name in names for x in (", ", name))[1:] or "-"


def _end(x: RealNumber, at: Mapping[str, Expr] | None, way: Way) -> Phrase:
    return Frequency(x, way, alone=True), "" if at is None else "*"


# The ranges, and what is estimated.


def _ranges(a: Tolerances) -> Iterator[Phrase]:
    """What varies, of the display and of its hands."""
    knobs = a.box.scene.knobs
    rows: list[Phrase] = [
        (
            named(x.name), " ", Real(ExactNumber(x.low / knobs[x.name].shown_unit(None).size), Way.DOWN), " to ",
            value_of(knobs[x.name], ExactNumber(x.high), Way.UP),
        )
        for x in a.box.sides
    ]  # fmt: skip
    motion = a.box.scene.motion or MotionKind.TRANSLATION
    for found in a.held:
        rows += [
            (f"hand.{p.key} ", near(ExactNumber(low)), " to ", near(ExactNumber(high), unit=p.shown_unit(motion)))
            for p, (low, high) in _of_hand(found.hand)
        ]
    yield "Ranges: ", tuple(y for x in rows for y in (", ", x))[1:], "."


def _of_hand(hand: Hand) -> list[tuple[Parameter, tuple[Expr, Expr]]]:
    return [(p, p.interval) for p in hand.parameters if p.interval]


def _quantiles(a: Tolerances) -> Iterator[Block]:
    """In full only the table; a line in brief is with what is proven."""
    if not a.samples:
        return
    q = quantiles(a.samples)
    rows = (("first crossing", q.first), ("bandwidth", q.bandwidth))
    cells = tuple((name, *(_quantile(found[p]) for p in LEVELS)) for name, found in rows)
    columns = Column(FREQUENCY_UNIT), *(Column(f"{p}\xa0%", number=True) for p in LEVELS)
    title = f"Estimated: quantiles over {len(a.samples)} random sets of values (uniform, seed {a.seed})"
    share = Paragraph(f"Of these sets {q.transparent} are transparent on the whole band.")
    yield Section(title, (Table(columns, cells, "Quantiles, estimated."), share))


def _quantile(x: float | None) -> Phrase:
    return "none" if x is None else cell(x)


def _proven(a: Tolerances) -> Iterator[Phrase]:
    fit = region_of_fit(a.box.scene)
    parts = [
        *(["verdict"] if a.verdict is not Verdict.UNDECIDED else []),
        *(["bandwidth"] if a.bandwidth is not None else []), "crossings",
        *(["stability"] if any(x.share for x in a.held) else []),
    ]  # fmt: skip
    what = listed(parts)
    if fit:
        yield "Proven for the fitted model: ", what, f", for every value in the {fit}; the ranges are estimated."
    else:
        yield "Proven: ", what, ", for every value in the ranges."
    if a.verdict is Verdict.UNDECIDED:
        yield undecided("whether the display is transparent on the whole band for all values, some or none")
    if a.limit is not None:
        yield f"Stopped after {a.limit:g} s: intervals may be wider than they need be, and {len(a.samples)} sets were drawn."
