"""The page of a measured evaluation: what the uncertainty discs show at each point, and what would
resolve the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from operator import itemgetter
from typing import Any

import numpy as np

from haptisym.judge.percepts import NOT_NAMED, felt_words
from haptisym.kernel.objects import counted
from haptisym.kernel.rings import s
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement, Welch, coherence_for
from haptisym.model.quantities import RADIANS, unit_text
from haptisym.pages import words as w
from haptisym.verbs.measured.entry import Between, MeasuredEvaluation, Remedy, Stretches
from haptisym.verbs.measured.judging import CODES, certainty, limits_of
from haptisym.writing import document as doc
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, Strong

_UNLIKELY = 0.01
"""A chance below which a display is called not linear."""


def measured_words(m: Measurement) -> Phrase:
    """Return what a measurement is, ``bench.csv: 60 frequency points from 1 to 15 rad/s``, and what
    its discs come from."""
    low, high = float(m.omega[0]), float(m.omega[-1])
    where: Phrase = (
        ("at ", w.cell(low)) if len(m) == 1 else ("from ", w.cell(low), " to ", w.cell(high))
    )
    lines: Phrase = (
        m.name,
        ": ",
        counted(len(m), "frequency point"),
        " ",
        where,
        "\xa0",
        FREQUENCY_UNIT,
    )
    if m.welch is not None:
        return lines, "; ", m.welch.words
    if m.coherence is None:
        return lines, "; ", certainty(m)
    seen = f"{float(m.coherence.min()):.4g} to {float(m.coherence.max()):.4g}"
    return lines, f"; coherence {seen}, {m.averages:.4g} averages"


def linearity(found: Welch) -> Phrase | None:
    """Return how far the force follows the cube of what the response predicts, with the probability
    of as much by chance; None where that was not tested."""
    if found.cube is None or found.cube_chance is None:
        return None
    words = (
        "the force has a cubic part of {} standard errors (probability if the display is linear: "
        "{})"
    )
    result = w.phrased(words, w.near(found.cube, most=3), w.near(found.cube_chance, most=2))
    if found.cube_chance >= _UNLIKELY:
        return result
    # A force below what the linear response predicts at large motions saturates; one above it
    # hardens.
    as_if = "saturating" if found.cube < 0 else "hardening, or with play"
    words = f"{{}} ({as_if}): {{}}. The response holds for motions of this size alone"
    return w.phrased(words, Strong("not linear"), result)


MOST_ROWS = 40
"""Rows of a table of frequency points, at most; where there are more, neighbours with equal
verdicts share one."""


def shape(e: MeasuredEvaluation) -> str:
    """Return the name of the region's shape, as ``ellipse``."""
    return str(e.scene.threshold.region.shape.value)


def _judgements(e: MeasuredEvaluation) -> list[tuple[str, Any]]:
    """The columns of verdicts: their headings and codes."""
    alone = " alone" if e.joint else ""
    found = [(f"{w.PART_NAMES[part]}{alone}", e.verdict[part]) for part in Part]
    return [(shape(e), e.joint.verdict), *found] if e.joint else found


def _groups(e: MeasuredEvaluation) -> Any:
    """Return a number for each point: the same for points with equal verdicts."""
    code = np.zeros(len(e), dtype=int)
    for _, own in _judgements(e):
        # Each verdict is -1, 0 or 1: as digits of base 3 they give different numbers for different
        # rows of verdicts.
        code = 3 * code + own
    return code


def _verdict_at(own: Any) -> w.Cell:
    """Return the cell of the verdicts in one column."""
    return lambda i: verdict(CODES[int(own[i])].value)


def _lines(e: MeasuredEvaluation) -> Block:
    """Return the table of verdicts: a row for each point or, where there are many, for neighbours
    with equal ones."""
    judged = [w.Field(name, _verdict_at(codes)) for name, codes in _judgements(e)]
    caption = (
        "Each frequency point: exceeds or below where the whole uncertainty disc does, else "
        "unresolved."
    )
    if len(e) <= MOST_ROWS:
        rows = list(e.rows)
        numbers = (
            w.hertz(lambda i: w.cell(rows[i].omega)),
            w.number(w.RATIOS[Part.REAL], lambda i: _ratio(rows[i].ratio_real)),
            w.number(w.RATIOS[Part.IMAG], lambda i: _ratio(rows[i].ratio_imag)),
            w.number("radius", lambda i: _ratio(rows[i].radius)),
        )
        return w.table(range(len(e)), caption, *numbers, *judged)
    # The index of the first point of each run of equal verdicts, and that of the last.
    last = dict(islice(runs(_groups(e)), MOST_ROWS))
    points = w.number("points", lambda i: str(last[i] - i + 1))
    return w.table(
        last, caption, w.Field(w.IN_UNIT, lambda i: ends(e, i, last[i])), points, *judged
    )


def cut(e: MeasuredEvaluation) -> Iterator[Block]:
    """Yield a note where the table does not hold everything."""
    groups = 1 + np.count_nonzero(np.diff(_groups(e)))
    if len(e) > MOST_ROWS and groups > MOST_ROWS:
        yield doc.Notes(
            (
                (
                    f"The first {MOST_ROWS} of {groups} groups of points with equal verdicts",
                    doc.Brief("; --json has every point"),
                    ".",
                ),
            )
        )


def _each(*headings: Phrase) -> Iterator[w.Field]:
    """Yield the columns of rows that are cells already."""
    for i, x in enumerate(headings):
        yield w.Field(x, itemgetter(i), number=x == "points")


def verdict(word: str) -> Phrase:
    """A verdict as a cell has it."""
    return Strong(word) if word == "exceeds" else word


def _ratio(x: float | None) -> Phrase:
    """Return a ratio in print; nothing where it is not known."""
    return "" if x is None else w.near(x) if np.isfinite(x) else "unbounded"


def runs(codes: Any) -> Iterator[tuple[int, int]]:
    """First and last index of equal neighbours."""
    edges = np.flatnonzero(np.diff(codes)) + 1
    starts, stops = [0, *edges.tolist()], [*(edges - 1).tolist(), len(codes) - 1]
    yield from zip(starts, stops, strict=True)


def ends(e: MeasuredEvaluation, first: int, last: int) -> Phrase:
    """``2 to 3``, or one frequency."""
    low, high = (w.cell(float(e.lines.omega[i])) for i in (first, last))
    return low if first == last else (low, " to ", high)


_LONGEST = 12
_OF = {"perceived": "", "environment": " of the environment"}


def stated(e: MeasuredEvaluation) -> str:
    """Return all bounds on the slope that were stated: ``|dH/dω| at most 40 N·s/m``."""
    bounds = (
        (f"{x.bound:.6g} {unit_text(x.unit)}{' times |H|' * x.relative}", key)
        for key, x in e.scene.slopes.items()
    )
    return "; ".join(f"|dH/dω| at most {bound}{_OF[key]}" for bound, key in bounds)


def _blocks(e: MeasuredEvaluation, found: Between | None) -> Iterator[Block]:
    """Yield what follows between the points from a bound on the slope of the response."""
    if found is None:
        return
    words = (
        "With {} the disc of each point extends to its neighbours, larger by as much as the "
        "bound allows; half-way its radius is "
        "at most {}\xa0% of |H_env|."
    )
    yield doc.Paragraph(w.phrased(words, stated(e), w.at_most(100 * found.grown)))
    if not len(found.told[Part.REAL]):
        yield doc.Paragraph("No two neighbouring points have bounded discs: nothing follows.")
        return
    for part, intervals in found.told.items():
        yield doc.Paragraph(_summary(e, part, intervals))
    if found.contradicted:
        yield doc.Notes((_contradicted(found),))
    rows = list(_chosen(found))
    cells = [_row(e, part, found.told[part], i) for part, i in rows]
    caption = (
        "Intervals between points: exceeds or below where the extended discs do, else unresolved."
    )
    yield w.table(cells, caption, *_each("part", w.IN_UNIT, "verdict"))
    count = sum(map(len, found.told.values()))
    if len(rows) < count:
        yield doc.Notes(
            (
                (
                    f"The {_LONGEST} longest resolved intervals of each part, of {count} in all",
                    doc.Brief("; --json has every one"),
                    ".",
                ),
            )
        )


def _chosen(found: Between) -> Iterator[tuple[Part | None, int]]:
    """Yield all intervals between points; of many the longest resolved ones of each part, in
    order."""
    few = sum(map(len, found.told.values())) <= MOST_ROWS
    for part, intervals in found.told.items():
        # Unresolved intervals count as having no length, so that the longest resolved ones come
        # first.
        length = np.where(intervals.code == 0, 0, intervals.high - intervals.low)
        # The longest are found by length and printed in the order of frequency.
        longest = np.sort(np.argsort(-length, kind="stable")[:_LONGEST])
        yield from (
            (part, int(i))
            for i in (range(len(intervals)) if few else longest)
            if few or intervals.code[i]
        )


def _summary(e: MeasuredEvaluation, part: Part | None, intervals: Stretches) -> Phrase:
    """Return on how much of the band a part exceeds, is below and is unresolved."""
    exceeds, below, unresolved = (w.cell(intervals.length(code)) for code in (1, -1, 0))
    whole = w.cell(float(intervals.high[-1] - intervals.low[0]))
    what: Phrase = (
        (w.RATIOS[part], f" ({w.PART_NAMES[part]} part) exceeds its threshold")
        if part
        else (f"The change lies outside the {shape(e)}")
    )
    where = "is below it on " if part else "inside it on "
    words = f"{{}} on {{}} of {{}}\xa0{{}}, {where}{{}}, and is unresolved on {{}}."
    return w.phrased(words, what, exceeds, whole, FREQUENCY_UNIT, below, unresolved)


def _contradicted(found: Between) -> Phrase:
    """Return where neighbouring discs are farther apart than the bound allows."""
    low, high = found.contradicted[0]
    return (
        Strong("Contradiction"),
        f": in {counted(len(found.contradicted), 'gap')}, the first from ",
        w.cell(low),
        " to ",
        w.cell(high),
        "\xa0",
        FREQUENCY_UNIT,
        (
            ", neighbouring points differ by more than their discs and the bound allow: the "
            "bound "
            "is too small, "
        ),
        "or a disc misses the true value. Nothing follows there.",
    )


def _row(
    e: MeasuredEvaluation, part: Part | None, intervals: Stretches, i: int
) -> tuple[Phrase, ...]:
    """Return the row of one interval between points: part, ends, verdict."""
    name = w.PART_NAMES[part] if part else shape(e)
    span: Phrase = (w.cell(float(intervals.low[i])), " to ", w.cell(float(intervals.high[i])))
    word = CODES[int(intervals.code[i])].value
    return name, span, verdict(word)


def page(e: MeasuredEvaluation) -> Document:
    """Return the whole page of a measured evaluation."""
    blocks: tuple[Block, ...] = (
        doc.Facts(tuple(_about(e))),
        doc.Section("Step 1: where a hand notices", tuple(_step_1(e)), "step-1"),
        doc.Section(
            "Between frequency points, by the bound on the slope",
            tuple(_blocks(e, e.between)),
            "between",
        ),
        doc.Section("Step 2: perceived change", tuple(_step_2(e)), "step-2"),
    )
    return w.page_about(
        e.scene, _answer(e), blocks, _how_sure(e), "Two-step evaluation of a measured display"
    )


def _answer(e: MeasuredEvaluation) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield between which points the bandwidth is, and as what the change is felt."""
    names = " or the ".join(w.PART_NAMES[x] for x in e.limited_by)
    by = f", limited by the {names} part" if names else ""
    yield "Bandwidth", (Strong((bandwidth(e),)), by)
    yield "Felt as", _felt_first(e)
    yield "Stability", ("not tested: it needs a model", doc.Brief(" (haptisym identify fits one)"))


def bandwidth(e: MeasuredEvaluation) -> Phrase:
    """Return between which frequencies the bandwidth is, the whole band, or that it is
    unresolved."""
    least, most = e.reach
    if most is None:
        if least is None:
            return "unresolved"
        return "the whole band, up to " if e.is_below_throughout else "at least ", w.both(least)
    if least is None:
        return "less than ", w.both(most)
    low = w.both(least) if e.scene.frequency == RADIANS else w.cell(least)
    return "between ", low, " and ", w.both(most)


def _felt_first(e: MeasuredEvaluation) -> Phrase:
    """Return how each part is felt where it is first noticed, the lowest frequency first."""
    first: dict[Part | None, tuple[int, int, str]] = {}
    for at, last, part, words in _felt_runs(e):
        first.setdefault(part, (at, last, words))
    if not first:
        return "nothing noticed" if e.is_below_throughout else "unresolved"
    in_order = sorted(first.values(), key=itemgetter(0))
    each = (
        (words, " at ", ends(e, at, last), "\xa0", FREQUENCY_UNIT) for at, last, words in in_order
    )
    return tuple(y for x in each for y in (", ", x))[1:]


def _share(x: float, digits: int = 4) -> str:
    """Return a share in per cent."""
    return f"{100 * x:.{digits}g}\xa0%"


def _about(e: MeasuredEvaluation) -> Iterator[tuple[str, Phrase]]:
    """Environment, measurement, discs, band and threshold."""
    environment, felt = e.scene.environment, e.scene.perceived
    if isinstance(environment, Measurement):
        yield "environment", measured_words(environment)
        if environment.understood:
            yield "read", environment.understood
    else:
        function = e.scene.frame.distortion().env
        unit = f"\xa0{w.stiffness_unit(e.scene.frame)}"
        yield "environment", w.in_numbers("H_env", function, s, e.scene.frame.band, unit)
    yield "perceived", measured_words(felt)
    if felt.understood:
        yield "read", felt.understood
    if e.is_turned_round:
        is_given = "sign turned round" in felt.understood
        add = "If the sensor measures the reaction, add sign = -1"
        way = "It is turned round by sign = -1: leave that out" if is_given else add
        nearer = f"at every point H is nearer to -H_env than to H_env. {way}"
        yield "sign", (Strong("turned round?"), " ", nearer)
    elif e.is_active_throughout:
        active = (
            "at every point Im H is negative, as of a device that gives energy at all frequencies. "
            "Check the signs of force and phase; sign = -1 turns the force round"
        )
        yield "sign", (Strong("turned round?"), " ", active)
    if felt.welch and (told := linearity(felt.welch)):
        yield "linear", told
    if e.left_out:
        yield (
            "left out",
            f"{counted(e.left_out, 'point')}, off the band or without the environment's value",
        )
    if e.scene.band is not None:
        low, high = map(w.cell, e.scene.band)
        yield "band", (low, " to ", high, "\xa0", FREQUENCY_UNIT)
    yield "threshold", w.limits(e.scene.threshold)
    if felt.coherence is not None and felt.averages is not None:
        # A disc of the radius c about a change of 0 just fits below the threshold: so large may
        # discs be, at most, to show that nothing is noticed.
        c = min(float(x.min()) for x in limits_of(e.scene, e.lines.omega).values())
        least = float(coherence_for(c, felt.averages, felt.confidence))
        told = (
            f"with {felt.averages:.4g} averages a radius of {_share(c)} needs a coherence of at "
            f"least "
        )
        yield "discs", (_discs(e), "; ", told, w.at_least(least))
    else:
        yield "discs", _discs(e)
    if e.scene.slopes:
        yield "slope", stated(e)


def _discs(e: MeasuredEvaluation) -> Phrase:
    """Return the confidence and the radii of the discs, or that none are known."""
    radius = e.lines.radius
    if radius is None:
        return Strong(
            "unknown"
        ), ": neither coherence nor radius is given, each point is judged as if it were exact"
    ends = [float(x) for x in (radius.min(), radius.max())]
    seen = tuple("unbounded" if np.isinf(x) else _share(x) for x in ends)
    return (
        f"{_share(e.scene.perceived.confidence)} confidence, radius {seen[0]} to {seen[1]} of ",
        _SIZE,
    )


_SIZE: Phrase = "|H_env|"


# Step 1, when.


def _step_1(e: MeasuredEvaluation) -> Iterator[Block]:
    """Yield the blocks of step 1: counts of verdicts, the table, figures, what would resolve the
    rest."""
    if e.joint is not None:
        outside = f"The change lies outside the {shape(e)}"
        yield doc.Paragraph(
            (*_counted(e, e.joint.verdict, outside, "inside it"), " Each part by itself:")
        )
    for part in Part:
        exceeds = f" ({w.PART_NAMES[part]} part) exceeds its threshold"
        yield doc.Paragraph((w.RATIOS[part], *_counted(e, e.verdict[part], exceeds, "below it")))
    yield _lines(e)
    yield from cut(e)
    yield w.drawing(
        e,
        "ratios",
        "Distortion ratios at the measured points. Bars: the uncertainty disc of each. Filled: "
        "the whole "
        "disc exceeds the threshold or is below it; open: unresolved.",
        wide=True,
    )
    if e.joint is not None:
        shown = (
            "The change at each point with its disc, in the plane of both parts, and the region "
            "that is not noticed."
        )
        yield w.drawing(e, "plane", shown)
    if e.needed is not None:
        yield doc.Notes(tuple(_resolving(e)))


def _counted(e: MeasuredEvaluation, codes: Any, exceeds: str, below: str) -> tuple[Phrase, ...]:
    """At how many points discs exceed, are below or unresolved, and where they first exceed."""
    count = {code: int((codes == code).sum()) for code in CODES}
    points = counted(len(e), "point")
    said = (
        f"{exceeds} at {count[1] or 'none'} of {points}, is {below} at "
        f"{count[-1] or 'none'}, unresolved at "
        f"{count[0] or 'none'}"
    )
    if not count[1]:
        return said, "."
    return said, "; first at ", w.both(float(e.lines.omega[int(np.argmax(codes == 1))])), "."


def _resolving(e: MeasuredEvaluation) -> Iterator[Phrase]:
    """Yield what would resolve the unresolved points."""
    found, felt = e.needed, e.scene.perceived
    assert found is not None
    half, every = (_bound(x, _share) for x in (found.radius.half, found.radius.all))
    yield (
        (
            f"Unresolved in a part or in both: {counted(found.lines, 'point')}. With the same "
            f"estimates half of them are "
            f"resolved by "
        ),
        f"discs of at most {half}, all by {every} of ",
        _SIZE,
        ".",
    )
    if found.coherence and found.averages:
        yield (
            f"With {felt.averages:.4g} averages that is a coherence of at least ",
            _half_and_all(found.coherence, lambda x: f"{x:.7g}"),
            "; with the measured coherence, ",
            _half_and_all(found.averages, lambda x: f"{x:.0f}"),
            " averages.",
        )


def _half_and_all(x: Remedy, words: Callable[[float], str]) -> Phrase:
    """Return what would resolve half of the points, and all of them."""
    return _bound(x.half, words), " (half), ", _bound(x.all, words), " (all)"


def _bound(x: float | None, words: Callable[[float], str]) -> str:
    """Return a bound in words."""
    return "more than can be measured" if x is None else words(x)


# Step 2, how.


def _step_2(e: MeasuredEvaluation) -> Iterator[Block]:
    # One row more than is printed, to know whether any is left out.
    """Yield the blocks of step 2: what is felt at the points that exceed."""
    rows = tuple(islice(_felt(e), MOST_ROWS + 1))
    if rows:
        caption = "What is felt at the points that exceed, where their discs show it."
        yield w.table(rows[:MOST_ROWS], caption, *_each(w.IN_UNIT, "points", "part", "felt as"))
    more: Phrase = (
        f"The first {MOST_ROWS} groups of points that are felt in the same way",
        doc.Brief("; --json has every point"),
        ".",
    )
    active = "Active: Im H_perc < 0, where no property applies to the imaginary part."
    yield from w.noted(
        [*[more] * (len(rows) > MOST_ROWS), *[active] * (NOT_NAMED in (x[-1] for x in rows))]
    )
    if not rows:
        yield doc.Paragraph(
            "At no point do the discs show that something is noticed, and in which part."
        )
    yield w.drawing(
        e,
        "nyquist",
        (
            "Environment and perceived dynamics in the complex plane, a disc around each "
            "measured point."
        ),
    )


def _felt(e: MeasuredEvaluation) -> Iterator[tuple[Phrase, ...]]:
    """Neighbouring points that are felt in the same way, as one row."""
    for first, last, part, words in _felt_runs(e):
        yield ends(e, first, last), str(last - first + 1), part.value if part else "both", words


def _felt_runs(e: MeasuredEvaluation) -> Iterator[tuple[int, int, Part | None, str]]:
    """Yield the first and the last of neighbouring points that are felt in the same way, the part
    and the words for it, by part and frequency."""
    for part in (*Part, None) if e.joint else Part:
        named, noticed = e.named(part), e.noticed(part)
        # Percepts have numbers from 0 on; -1 is noticed without a property, -2 not noticed: equal
        # neighbours are one row.
        label = np.where(named, e.kinds(part), np.where(noticed, -1, -2))
        for first, last in runs(label):
            if noticed[first]:
                words = _felt_words(e, part, first) if named[first] else NOT_NAMED
                yield first, last, part, words


def _felt_words(e: MeasuredEvaluation, part: Part | None, line: int) -> str:
    """Return what is felt at a point; of both parts together, the one nearer its limit last."""
    if part is not None:
        return felt_words(*e.signs[part].label(part, line))
    far, nearer = e.order(line)
    return " and ".join(felt_words(*e.signs[x].label(x, line)) for x in (far, nearer))


def _how_sure(e: MeasuredEvaluation) -> Iterator[Phrase]:
    """Yield what the verdicts rest on: the points, a bound on the slope, the confidence of the
    discs."""
    if e.between is not None:
        yield (
            "Measured: verdicts at these points, and between them by the stated bound on the "
            "slope, which is not tested."
        )
    else:
        yield "Measured: verdicts at these points alone, none between them."
    if e.lines.radius is None:
        yield "Not tested: how certain the points themselves are."
        return
    share = 1 - e.scene.perceived.confidence
    both_ = isinstance(e.scene.environment, Measurement) and e.scene.environment.discs is not None
    # By the union bound: a verdict is wrong only if one of its discs misses, of which there are two
    # where the environment is measured as well.
    missed = min(1.0, share * (2 if both_ else 1)) * len(e)
    yield (
        (
            f"Estimated: each disc misses the true value with a probability of {_share(share)}, "
            f"if the noise is as assumed; that is "
        ),
        w.near(missed, most=2),
        f" of {counted(len(e), 'point')}.",
    )
