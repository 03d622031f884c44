"""The page of an evaluation, which reads like section 3 of the paper.

What is said of a threshold that is published or a range, and of all bandwidths that the range gives.

Step 1 on a page: where a display is transparent, a table of all crossings, and each in words.

Other JND models on a page: what square, disc and diamond of the same half widths say, beside the scene's own region.

Of one environment, and of several: what each model says of every one of them, and of all together.

The page of an evaluation, which reads like section 3 of the paper: the questions, the answers, what is certain.

The answers of an evaluation in brief, at the head of its report.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from sympy import Add, Expr, Symbol

from haptisym.judge.bandwidths import Bandwidths, Jump
from haptisym.judge.crossings import JOINT, Criterion, Crossing, CrossingKind
from haptisym.judge.evaluation import Compared, Evaluation
from haptisym.judge.passivity import Passivity
from haptisym.judge.regions import Joint
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import RationalFunction, omega, s
from haptisym.kernel.roots import Chart
from haptisym.model.jnd import Part, Threshold, like
from haptisym.model.parameters import ExactRange
from haptisym.model.quantities import Dimension
from haptisym.pages.held import held
from haptisym.pages.late import drawing, proof
from haptisym.pages.words import (
    CHANGE,
    H_ENV,
    H_PERC,
    OMEGA,
    OPERATORS,
    PART_NAMES,
    amount,
    both,
    bounds,
    caveats,
    certainty,
    compared,
    ends,
    exactly,
    hertz,
    is_transparent_throughout,
    limits,
    page_about,
    percent,
    places,
    short,
    span,
    spans,
    stiffness_unit,
    unit,
)
from haptisym.writing.boxes import Operator, Prefixed
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Facts,
    Figure,
    Live,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    Versions,
    listed,
)
from haptisym.writing.equations import equation, quantity
from haptisym.writing.layout import named
from haptisym.writing.mathml import readable
from haptisym.writing.mathtext import text

if TYPE_CHECKING:
    from haptisym.pages.scene import SceneForms
    from haptisym.verbs.family.entry import FamilyCompared, FamilyEvaluation


def bandwidths(e: Evaluation) -> Iterator[Block]:
    """Where the threshold is a range: the least and the most bandwidth, both reached, what between is not, and a drawing."""
    found, threshold = e.bandwidths, e.scene.threshold
    if found is None:
        return
    yield Paragraph(("For ", _range(threshold), " ", _said(found, threshold), _blocked(found, threshold), _open(found)))
    if found.is_one_curve:
        caption = "The bandwidth over the range; a dot is reached, a ring is not."
        yield drawing("bandwidths", caption, "files:draw_figure", e, "bandwidths")


def _range(threshold: Threshold) -> Phrase:
    ranges = threshold.ranges
    if "scale" in ranges:
        low, high = ranges["scale"]
        return f"a JND from {float(low):.6g} to {float(high):.6g} times as large"
    limits = {name: x for name, x in ranges.items() if name != "floor"}
    alike = threshold.real == threshold.imag and threshold.real_interval == threshold.imag_interval
    found: list[Phrase] = []
    if limits and alike and threshold.region.lower == (None, None):
        found = [("thresholds ", _ends(limits["real"]))]
    elif limits:
        found = [("thresholds ", listed((_ends(x), f" ({_named(name, threshold)})") for name, x in limits.items()))]
    if "floor" in ranges:
        low, high = ranges["floor"]
        found.append(f"a floor from {float(low):.6g} to {float(high):.6g} {_unit(threshold)}")
    return listed(found)


def _named(name: str, threshold: Threshold) -> str:
    """``real``, or ``real part, where it shrinks``."""
    return _of_part(name, threshold).removesuffix(" part")


def _of_part(name: str, threshold: Threshold) -> str:
    """``real part``, or ``real part, where it shrinks``."""
    part, _, lower = name.partition(".")
    way = ", where it shrinks" if lower else ", where it grows" if threshold.lower(Part(part)) is not None else ""
    return f"{PART_NAMES[Part(part)]} part{way}"


def _unit(threshold: Threshold) -> str:
    return unit(Dimension.STIFFNESS, threshold.region.motion)


def _ends(interval: ExactRange) -> str:
    low, high = interval
    return f"from {percent(low)} to {percent(high)}"


def _said(found: Bandwidths, threshold: Threshold) -> Phrase:
    if found.most is None:
        return "there is no bandwidth: the distortion is noticed at the band's low end."
    if found.least is None:
        return "the bandwidth is at most ", both(found.most), "; some give none."
    least, most = found.least, found.most
    if least is most or least.bounds(200) == most.bounds(200):
        return "the bandwidth is ", both(least), ", where there is one." if found.blocked else ", whichever it is."
    ends: Phrase = ("the bandwidth is at least ", both(least), " and at most ", both(most), "; ")
    if found.undecided:
        return ends, "both are reached."
    if found.ends_alone:
        grows = "both are reached, as the region grows with each of these numbers."
        return ends, grows, " Which of the values between are is not told."
    if not found.jumps:
        return ends, "each value between is reached."
    return ends, "each value between is reached but those ", listed(_jump(x, threshold) for x in found.jumps), "."


def _jump(x: Jump, threshold: Threshold) -> Phrase:
    gap: Phrase = "above " if x.includes_low else "from ", short(x.low), " to below ", short(x.high), " rad/s"
    if x.threshold is None:
        return gap
    name = next(iter(threshold.ranges))
    passed = "the threshold passes a peak of " if name not in ("scale", "floor") else f"at a {name} of "
    return gap, " (", passed, _size(x.threshold, name, threshold), ")"


def _size(x: RealNumber, name: str, threshold: Threshold) -> Phrase:
    if name == "scale":
        return short(x)
    return (short(x), f" {_unit(threshold)}") if name == "floor" else _share(x)


def _blocked(found: Bandwidths, threshold: Threshold) -> Phrase:
    if not found.blocked:
        return ""
    below: list[Phrase] = []
    for name, x in found.blocked.items():
        what = f" {name}" if name in ("scale", "floor") else " threshold"
        whose = f" for the {_of_part(name, threshold)}" if name not in ("scale", "floor", "jnd") else ""
        below.append((f"a{what} below ", _size(x, name, threshold), whose))
    return (" There is none for ", listed(below), ".")


def _share(x: RealNumber) -> Phrase:
    return Number(f"{100 * float(x):.5g}", float(x)), "\xa0%"


def _open(found: Bandwidths) -> Phrase:
    return (" ", Strong("UNDECIDED"), f": {found.undecided}; there may be jumps between.") if found.undecided else ""


def published_words(threshold: Threshold) -> Phrase:
    """Which published threshold it is; nothing where it is none."""
    if not threshold.source:
        return ""
    found = like(threshold.source)
    taken = f" at {float(100 * found.criterion):g}\xa0%" if found.criterion else ""
    return ", as ", Code(found.name), f": {found.quantity}{taken} ({found.source})"


def joint(criteria: Iterable[Criterion]) -> Joint | None:
    """The region that judges both parts at once, where there is one."""
    return next((x.joint for x in criteria if x.joint), None)


def nothing_meets(region: Joint | None) -> str:
    """That what is judged meets no limit."""
    return f"The distortion does not meet the border of the {region.kind}" if region else "No ratio meets its threshold"


def crossings(e: Evaluation) -> Block:
    """Every crossing on the band: digits, what happens, enclosure."""
    if not e.crossings:
        decided = ", as far as that was decided" if e.undecided else ""
        return Paragraph(f"{nothing_meets(joint(e.criteria))} on the band{decided}.")
    columns = (
        Column("part"), Column((OMEGA, " (rad/s)"), number=True), Column("Hz", number=True), Column("what happens"),
        Column("distortion"), Column(("enclosure of ", OMEGA), full=True),
    )  # fmt: skip
    caption = f"All crossings of the thresholds on the band, {proven(e)}."
    return Table(columns, tuple(_crossing(e, c) for c in e.crossings), caption)


def proven(e: Evaluation) -> str:
    """How certain a table is."""
    if e.scene.level is not None:
        return "of the fitted model: none missed, none invented"
    return "proven: none missed, none invented" if e.certified else "proven, but for what is listed as undecided"


def _crossing(e: Evaluation, c: Crossing) -> tuple[Phrase, ...]:
    low, high = c.omega.enclosure(e.digits)
    return c.criterion.name, exactly(c.omega, e.digits), hertz(c.omega), event(c), sense(c), f"[{low}, {high}]"


VERBS = {CrossingKind.EXCEEDS: "rises above", CrossingKind.RETURNS: "falls below", CrossingKind.TOUCHES: "touches"}


def event(c: Crossing, kind: str | None = None) -> Phrase:
    """``r_r rises above 10 %``, ``ΔH leaves the ellipse``; ``kind`` : what a region is called, if not by its shape."""
    times = f" ({c.multiplicity}-fold)" if c.multiplicity > 1 else ""
    if c.criterion.joint:
        return CHANGE, f" {_LEAVES[c.kind]} the {kind or c.criterion.joint.kind}{times}"
    ratio = named(c.criterion.symbol)
    if c.jump:
        return "the limit of ", ratio, " changes: ", _JUMPS[c.kind]
    limit = "its limit" if c.criterion.region else amount(c.criterion.threshold)
    return ratio, f" {VERBS[c.kind]} ", limit, times


_LEAVES = {CrossingKind.EXCEEDS: "leaves", CrossingKind.RETURNS: "returns into", CrossingKind.TOUCHES: "touches"}
_JUMPS = {
    CrossingKind.EXCEEDS: "exceeded from here on",
    CrossingKind.RETURNS: "exceeded up to here",
    CrossingKind.TOUCHES: "not exceeded at this frequency alone",
}


def sense(c: Crossing) -> Phrase:
    """``Re dH > 0``; nothing where both parts are judged."""
    return compared(Prefixed(Operator(c.criterion.component), CHANGE), ">" if c.sign > 0 else "<") if c.sign else ""


def undecided(e: Evaluation) -> Table:
    """What stayed open at the precision limit."""
    found = [(x.name, point.omega.enclosure(e.digits)) for x, point in e.undecided]
    rows = tuple((name, f"[{low}, {high}]") for name, (low, high) in found)
    caption = "Undecided at the precision limit: whether the ratio touches its threshold here, crosses it twice or stays clear."
    return Table((Column("part"), Column(("near ", OMEGA, " (rad/s)"))), rows, caption)


_RATIOS = (
    "Distortion ratios over the band. Grey: neither exceeds its threshold, the display is transparent. A dot "
    "marks where the ratio of the real part meets its threshold, a ring that of the imaginary part."
)
_JOINT_RATIOS = (
    "How many times the region must be enlarged to hold the distortion, over the band. Grey: not more than once, the display is "
    "transparent. A dot marks where the distortion leaves or enters the region."
)


def ratios_caption(e: Evaluation) -> str:
    """What the figure of ratios shows."""
    return _JOINT_RATIOS if joint(e.criteria) else _RATIOS


def transparency(e: Evaluation) -> Phrase:
    """Where neither ratio exceeds its threshold."""
    if not e.transparent:
        return "At every frequency of the band: the display is transparent nowhere."
    if is_transparent_throughout(e):
        return "Never on this band: the display is perceptually transparent on the whole of it."
    pieces = spans(e.transparent)
    if e.bandwidth is None:
        return "From the low end of the band on. The display is perceptually transparent only ", pieces, "."
    if len(e.transparent) == 1:
        width = both(e.bandwidth)
        return "At ", width, ". Below that the display is perceptually transparent: this is its bandwidth."
    return "At ", both(e.bandwidth), ", its bandwidth. The display is perceptually transparent ", pieces, "."


_SURVIVES = "Does it survive another JND model?"
_PLANE = (
    "The distortion relative to the environment over the band, and the regions within which it is not noticed; a dot where it "
    "first meets the border of each. A region that depends on the frequency is drawn as it is there, or else at the high end."
)
_WIDTHS = "Bandwidth of each environment, and of all together, by JND region; none: no transparent band starts at the low end."
_KINDS = {"disc": "disc"}
"""Of a region that is more than its shape says."""


def regions(e: Evaluation) -> Iterator[Block]:
    """A sentence that says how far the models are apart, a row for each, and a drawing; nothing where that was not asked."""
    if not e.regions:
        return
    columns = (
        Column("region"), Column("what it is", full=True), Column("bandwidth (rad/s)", number=True),
        Column("first crossing (rad/s)", number=True), Column("what happens there"),
    )  # fmt: skip
    table = Table(columns, tuple(_row(e, x) for x in e.regions), "Bandwidth and first crossing by region, proven.")
    figure = drawing("regions", _PLANE, "files:draw_figure", e, "regions")
    yield Section(_SURVIVES, (Paragraph(_spread(e.regions)), table, figure), "regions")


def _row(e: Evaluation, x: Compared) -> tuple[Phrase, ...]:
    crossing = x.crossing
    first: tuple[Phrase, Phrase] = ("none", "")
    if crossing is not None:
        first = exactly(crossing.omega, e.digits), event(crossing, _KINDS.get(x.name))
    return x.name, limits(x.threshold), _width(e.chart, x.bandwidth, e.digits), *first


def family_regions(w: FamilyEvaluation) -> Iterator[Block]:
    """How far the models are apart in the worst case, a row for each, and a row for each environment."""
    if not w.regions:
        return
    columns = (
        Column("region"), Column("what it is", full=True), Column("bandwidth (rad/s)", number=True), Column("who binds"),
    )  # fmt: skip
    worst = Table(columns, tuple(_worst(w, x) for x in w.regions), "Common bandwidth by region, and who binds, proven.")
    by_name = Column("environment"), *(Column(x.name, number=True) for x in w.regions)
    rows = [(name, *(_width(w.chart, x.answers[name].bandwidth) for x in w.regions)) for name in w.family]
    rows.append(("all", *(_width(w.chart, x.bandwidth) for x in w.regions)))
    each = Table(by_name, tuple(rows), "Bandwidth of each environment by region (rad/s), proven.")
    figure = drawing("regions", _WIDTHS, "regions:family_regions_figure", w)
    yield Section(_SURVIVES, (Paragraph(_spread(w.regions, "common bandwidth")), worst, each, figure), "regions")


def _worst(w: FamilyEvaluation, x: FamilyCompared) -> tuple[Phrase, ...]:
    who = listed(f"{y.environment} ({y.criterion.name})" for y in x.first)
    return x.name, limits(x.threshold), _width(w.chart, x.bandwidth, w.digits), who


def _width(chart: Chart, x: RealNumber | None, digits: int = 0) -> Phrase:
    """A bandwidth as a cell has it; ``digits`` : so many, or a few."""
    if x is None:
        return "none"
    if float(x) == float(chart.points[-1].omega):
        return "whole band"
    return exactly(x, digits) if digits else short(x)


def _spread(found: Sequence[Compared | FamilyCompared], what: str = "bandwidth") -> Phrase:
    """How far apart the bandwidths are; ``what`` : as they are called."""
    widths = [x.bandwidth for x in found if x.bandwidth is not None]
    if not widths:
        return f"No region gives a {what}: that survives another JND model."
    least, most = min(widths, key=float), max(widths, key=float)
    between = short(least), " and ", short(most), " rad/s"
    if len(widths) < len(found):
        return f"Whether there is a {what} depends on the JND model; where there is, it lies between ", *between, "."
    if float(least) == float(most):
        return f"All regions give the same {what}, ", short(most), " rad/s."
    times = f": the largest is {float(most) / float(least):.3g} times the smallest." if float(least) else "."
    return f"By these regions the {what} lies between ", *between, times


_MOST_LETTERS = 280  # of a formula: three lines


def page(e: Evaluation) -> Document:
    """The whole page."""
    full = _InFull(e)
    certain: tuple[Block, ...] = (*caveats(e.caveats), Paragraph(_certain(e)))
    blocks = (
        *_left_out(e),
        Versions((Facts(tuple(_dynamics(e))),), full.findings),
        Section("Scene", (Versions((), full.scene),), "scene"),
        Section("Step 1. When does the hand begin to notice?", tuple(_step_1(e)), "step-1"),
        *regions(e),
        Section("Step 2. How is it felt?", tuple(_step_2(e)), "step-2"),
        Section("Which values would do?", (Versions((), full.design),), "which-values-would-do"),
        Section("Explorer", (Live(full.explorer),), "explorer"),
        Versions(
            certain, lambda: [Section("What is certain", (*certain, proof(e, e.scene), *_assumed()), "certainty")]
        ),
        Section("Derivation", (Versions((), full.derivation),), "derivation", appendix=True),
    )
    return page_about(e.scene, blocks, "Two-step evaluation of a haptic display", e.asides())


@dataclass(frozen=True)
class _InFull:
    """What reports alone say; what writes it is loaded where one is written."""

    evaluation: Evaluation

    @cached_property
    def _forms(self) -> SceneForms:
        from haptisym.pages.scene import SceneForms

        return SceneForms(self.evaluation)

    def findings(self) -> Iterable[Block]:

        return [Facts(tuple(findings(self.evaluation)), "findings")]

    def scene(self) -> Iterable[Block]:
        from haptisym.pages.scene import scene_blocks

        return scene_blocks(self.evaluation.scene, self._forms.short_names)

    def design(self) -> Iterable[Block]:
        from haptisym.pages.require import design

        return design(self.evaluation)

    def explorer(self) -> str:
        from haptisym.pages.explorer import explorer

        return explorer(self.evaluation, self._forms)

    def derivation(self) -> Iterable[Block]:
        from haptisym.pages.derivation import derivation

        return derivation(self._forms)


def _left_out(e: Evaluation) -> Iterator[Block]:
    """What was left out of the scene, and what that changes at most."""
    r = e.relevance
    if r is None or not r.dropped:
        return
    found = listed(f"[{x.bounds[0]:.6g}, {x.bounds[1]:.6g}] ({x.criterion.name})" for x in r.crossings)
    them = "it" if len(r.dropped) == 1 else "them"
    lie: Phrase = ("Its crossings lie in ", found, " rad/s.") if found else "It has no crossings on the band."
    yield Paragraph((
        "Without ", listed(x.name for x in r.dropped), f": leaving {them} out changes ", bounds(r.bound), " anywhere on the ",
        f"band, proven (tolerance {float(r.tolerance):g}). What follows is exact for the scene without {them}. The full scene ",
        "differs by no more than that. ", lie,
    ))  # fmt: skip


def _dynamics(e: Evaluation) -> Iterator[tuple[str, Phrase]]:
    """Environment, effects and what they make of it; the band and the threshold."""
    d, rendered = e.distortion, e.scene.rendered
    unit = f"  {stiffness_unit(e.scene)}"
    yield "environment", _equation("H_env", d.env, s, unit)
    if rendered:
        yield "rendered", _equation("H_rendered", d.env.ring.convert(rendered.H), s, unit)
    yield "effects", ", ".join(_effect(x.name, x.model) for x in e.scene.effects) or "none"
    yield "perceived", _equation("H_perc", d.perc, s, unit)
    yield "distortion", _equation("Re dH", d.difference_response.real.written, omega)
    yield "", _equation("Im dH", d.difference_response.imag.written, omega)
    low, high = (e.chart.points[i].omega for i in (0, -1))
    yield "band", (both(low), " to ", both(high))
    yield "threshold", (limits(e.scene.threshold), published_words(e.scene.threshold))


def _equation(name: str, function: RationalFunction, variable: Symbol, unit: str = "") -> Phrase:
    """A closed form; of one that is too long to be read, how long it is."""
    form, is_rounded = readable(function, variable)
    written = equation(name, form, relation="≈" if is_rounded else "=")
    if len(text(written)) <= _MOST_LETTERS:
        return written, unit
    reduced = function.reduced()
    above, below = (_terms(reduced.ring.coefficients(p)) for p in (reduced.numerator, reduced.denominator))
    return quantity(name), f" has {above} terms over {below}: see ", Code("haptisym derive")


def _terms(coefficients: Iterable[Expr]) -> int:
    return sum(len(Add.make_args(c.expand())) for c in coefficients if c != 0)


def _effect(name: str, model: str) -> str:
    return name if name == model else f"{name} ({model})"


# Step 1, when.


def _step_1(e: Evaluation) -> Iterator[Block]:
    yield Paragraph(transparency(e))
    yield from bandwidths(e)
    yield _figure(e, "ratios", ratios_caption(e), wide=True)
    yield crossings(e)
    if e.undecided:
        yield undecided(e)
    yield from _any_environment(e)


def _any_environment(e: Evaluation) -> Iterator[Block]:
    found = e.any_environment
    if found is None or not e.scene.effects:
        return
    below, above, end = found.transparent_below, found.opaque_above, e.chart.points[-1].omega
    if below == end:
        yield Paragraph("These effects in series stay unnoticed with any environment whatever on this band.")
        return
    upto: Phrase = "Already at the low end of the band these effects in series are noticed with some environment"
    if below is not None:
        upto = ("With any environment whatever, up to ", short(below), " rad/s these effects in series stay unnoticed")
    beyond = () if above is None else ("; with every one they are noticed above ", short(above), " rad/s")
    yield Paragraph((upto, beyond, "."))


# Step 2, how.


def _step_2(e: Evaluation) -> Iterator[Block]:
    yield percepts(e)
    for part, name in ((Part.REAL, "real"), (Part.IMAG, "imaginary")):
        yield _figure(
            e, f"projections-{part.value}", f"Magnitude of the {name} part of environment and of what is felt: bold where "
            "the difference is noticed, with what it is felt as.",
        )  # fmt: skip
    yield Notes((*_friction(e), *_changeovers(e), *_outside_model(e), *_unbounded(e), *held(e)))
    yield _figure(
        e, "nyquist", "Environment (solid) and what is felt (dashed) in the complex plane; arrows towards higher frequencies.",
    )  # fmt: skip
    yield _figure(
        e, "jnd-square", "Environment and what is felt at one frequency; the grey region holds the changes that are not noticed.",
    )  # fmt: skip


def _figure(e: Evaluation, name: str, caption: str, *, wide: bool = False) -> Figure:
    return drawing(name, caption, "files:draw_figure", e, name, wide=wide)


def percepts(e: Evaluation) -> Block:
    """What is felt where a ratio exceeds its threshold."""
    region = joint(e.criteria)
    if not e.felt:
        why = f"the distortion never leaves the {region.kind}" if region else "neither ratio exceeds its threshold"
        return Paragraph(f"Nothing is noticed on the band: {why}.")
    rows = tuple((ends(x.band), x.part.value if x.part else JOINT, x.words) for x in e.felt)
    where = f"outside the {region.kind}" if region else "where a ratio exceeds its threshold"
    caption = f"What is felt {where}, {proven(e)}."
    return Table((Column("band (rad/s)"), Column("part"), Column("felt as")), rows, caption)


def _friction(e: Evaluation) -> Iterable[Phrase]:
    if e.friction is None:
        return
    newton = unit(Dimension.FORCE, e.scene.motion)
    found = f"Friction of {float(e.friction.force):.4g} {newton} in the display"
    source = "(Veldhuis, Mulder and van Paassen, 2024: a Weber fraction and a floor)"
    if e.friction.noticed is None or e.friction.least is None:
        how = Code('friction = { weber = ..., floor = "... N" }'), " in ", Code("[evaluation]"), "."
        yield f"{found} has a threshold of its own {source}, which the scene does not give: ", *how
    else:
        verdict: Phrase = Strong("noticed") if e.friction.noticed else "not noticed"
        least, reference = (float(x or 0) for x in (e.friction.least, e.friction.reference))
        more = "differs by more" if e.friction.noticed else "differs by no more"
        meant = f"the {reference:.4g} {newton} that should be felt {source}."
        limit = f" as friction, as it {more} than {least:.4g} {newton} from {meant}"
        yield f"{found} is ", verdict, limit


def _changeovers(e: Evaluation) -> Iterable[Phrase]:
    if e.changeovers_environment or e.changeovers_perceived:
        env, perc = (places(x) if x else "no frequency" for x in (e.changeovers_environment, e.changeovers_perceived))
        yield "Spring and inertia change over at ", env, " in the environment, at ", perc, " as felt."


def _outside_model(e: Evaluation) -> Iterable[Phrase]:
    if e.outside_model:
        noticed = "so that no property is named for what is noticed there" if e.unnamed else "but not noticed there"
        active = compared(Prefixed(OPERATORS[Part.IMAG], H_PERC), "<")
        yield (
            "The imaginary part is outside the paper's model ", spans(e.outside_model), f", {noticed}: the display is active (",
            active, ").",
        )  # fmt: skip


def _unbounded(e: Evaluation) -> Iterable[Phrase]:
    if e.unbounded:
        why = (compared(H_ENV, "="), ", or ", CHANGE, " infinite")
        yield "A ratio is unbounded at ", places(e.unbounded), ": nothing to compare with there (", why, ")."


def _certain(e: Evaluation) -> Phrase:
    if e.undecided:
        where = listed((short(point.omega), f" rad/s ({x.name})") for x, point in e.undecided)
        return (
            Strong("UNDECIDED"), " at the precision limit: whether a ratio touches its threshold, crosses it twice or stays ",
            "clear of it near ", where, ". Everything else is proven.",
        )  # fmt: skip
    return certainty(
        e.scene,
        "Certain: these are all crossings on the band, none is missed and none invented; every digit, sign and interval "
        "is proven by exact polynomials and ball arithmetic, not sampled.",
    )


def _assumed() -> Iterator[Block]:
    yield Paragraph((
        "Assumed: that the dynamics are linear, and the threshold of human perception (Fu, van Paassen and Mulder, 2019, eq. ",
        "4). Figures, and an explorer, are drawn in floating point; the figures have every proven frequency among their samples.",
    ))  # fmt: skip


def findings(e: Evaluation) -> Iterator[tuple[Phrase, Phrase]]:
    """The answers in brief, at the head of a report."""
    yield "bandwidth", _bandwidth(e)
    yield "first felt as", _first(e)
    pole = compared(Prefixed(OPERATORS[Part.REAL], named("s")), "≥")
    stable: dict[bool | None, Phrase] = {
        True: (Strong("stable"), " (no pole with ", pole, ")"),
        False: (Strong("NOT stable"), " (a pole with ", pole, ")"),
        None: (Strong("undecided"), " (whether a pole has ", pole, " is open)"),
    }
    yield "under imposed motion", stable[e.stable]
    yield "every passive hand", _of_hands(e.passivity)
    number = len(e.undecided)
    tangencies = (
        f"{number} tangenc{'y' if number == 1 else 'ies'} stayed open"
        if number
        else "jumps of the bandwidth stayed open"
    )
    if not e.certified:
        yield "these answers", (Strong("in part undecided"), f" ({tangencies})")
    elif e.scene.level is not None:
        yield "these answers", (Strong("estimates"), " (exact for the fitted model)")
    else:
        yield "these answers", (Strong("proven"), " (none missed, none invented)")


def _of_hands(found: Passivity | None) -> Phrase:
    if found is None or found.holds is None:
        return Strong("undecided"), ""
    if found.holds:
        return Strong("holds"), " (at all frequencies)"
    where: Phrase = (" (active ", span(found.active[0]), ")") if found.active else " (poles forbid it)"
    return Strong("does not hold"), where


def _bandwidth(e: Evaluation) -> Phrase:
    if e.bandwidth is None:
        onwards = ("transparent from ", short(e.transparent[0].low.omega), " rad/s on") if e.transparent else ()
        return Strong("none"), " (", onwards or "transparent nowhere on the band", ")"
    more = f", and on {len(e.transparent) - 1} more" if len(e.transparent) > 1 else ""
    whole = ", the whole band" if is_transparent_throughout(e) else more
    return Strong((short(e.bandwidth), " rad/s")), f" ({hertz(e.bandwidth)} Hz{whole})", _from_to(e)


def _from_to(e: Evaluation) -> Phrase:
    """The bandwidths that the range of the threshold gives."""
    found = e.bandwidths
    if found is None or found.least is None or found.most is None:
        return ""
    return "; ", short(found.least), " to ", short(found.most), " rad/s for the range of the threshold"


def _first(e: Evaluation) -> Phrase:
    if not e.felt:
        return Strong("nothing"), " is noticed on the band"
    first = min(e.felt, key=lambda x: float(x.band.low.omega))
    return Strong(first.words), " from ", short(first.band.low.omega), " rad/s on"
