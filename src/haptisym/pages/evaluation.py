"""The page of an evaluation: the answer in three lines, step 1 (when a hand notices), step 2 (as what), what is proven.

The same document is printed, set in LaTeX and HTML, and shown in a notebook; a report has more of it: the scene, which values
would do, an explorer, the derivation.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from sympy import Add, Expr, Rational, Symbol

from haptisym.judge.bandwidths import Bandwidths, Jump
from haptisym.judge.crossings import JOINT, Criterion, Crossing, CrossingKind
from haptisym.judge.evaluation import Compared, Evaluation
from haptisym.judge.passivity import Beyond, Passivity
from haptisym.judge.regions import Joint
from haptisym.kernel.reals import ExactNumber, RealNumber, Way
from haptisym.kernel.rings import RationalFunction, omega, s
from haptisym.kernel.roots import Chart
from haptisym.model.jnd import Part, Threshold, like
from haptisym.model.parameters import ExactRange
from haptisym.model.quantities import Dimension, Unit
from haptisym.pages.late import drawing
from haptisym.pages.late import proof as certificate
from haptisym.pages.words import (
    CHANGE,
    H_ENV,
    H_PERC,
    OPERATORS,
    PART_NAMES,
    amount,
    at_most,
    both,
    bounds,
    caveats,
    cell,
    compared,
    ends,
    is_transparent_throughout,
    limits,
    near,
    noted,
    page_about,
    percent,
    places,
    proof,
    spans,
    stiffness_unit,
    undecided,
    unit,
)
from haptisym.writing.boxes import Operator, Prefixed
from haptisym.writing.document import (
    FREQUENCY,
    FREQUENCY_UNIT,
    Block,
    Code,
    Column,
    Document,
    Facts,
    Figure,
    Formulas,
    Live,
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


def page(e: Evaluation) -> Document:
    """The whole page."""
    full = _InFull(e)
    low, high = (cell(e.chart.points[i].omega) for i in (0, -1))
    judged = limits(e.scene.threshold), published_words(e.scene.threshold)
    step_1: Phrase = ("Step 1: crossings on ", low, " to ", high, "\xa0", FREQUENCY_UNIT, ", JND ", judged)
    blocks = (
        *_left_out(e),
        Section("Scene", (Versions((), full.scene),), "scene"),
        Section(step_1, tuple(_step_1(e)), "step-1"),
        *regions(e),
        Section("Step 2: perceived change", tuple(_step_2(e)), "step-2"),
        *noted(_remarks(e)),
        Section("Formulas", (Versions((Formulas(lambda: [Facts(tuple(_dynamics(e)))]),)),), "formulas"),
        Section("Which values satisfy the JND?", (Versions((), full.design),), "which-values"),
        Section("Explorer", (Live(full.explorer),), "explorer"),
        *caveats(e.caveats),
        certificate(e, e.scene),
        Section("Derivation", (Versions((), full.derivation),), "derivation", appendix=True),
    )
    kind, further = "Two-step evaluation of a haptic display", ("--formulas", "haptisym stability SCENE --hand NAME")
    return page_about(e.scene, findings(e), blocks, _proven(e), kind, e.asides(), further)


@dataclass(frozen=True)
class _InFull:
    """What reports alone have; what writes it is loaded where one is written."""

    evaluation: Evaluation

    @cached_property
    def _forms(self) -> SceneForms:
        from haptisym.pages.scene import SceneForms

        return SceneForms(self.evaluation)

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


# The answer.


def findings(e: Evaluation) -> Iterator[tuple[Phrase, Phrase]]:
    """The three lines of the answer."""
    yield "Bandwidth", _bandwidth(e)
    yield "Felt as", felt_as(e)
    yield "Stability", stability(e)


def _bandwidth(e: Evaluation) -> Phrase:
    if e.bandwidth is None:
        onward: Phrase = "noticed on the whole band"
        if e.transparent:
            onward = "noticed from the low end of the band on; transparent ", spans(e.transparent)
        return Strong("none"), ": ", onward
    if is_transparent_throughout(e):
        low, high = (cell(e.chart.points[i].omega) for i in (0, -1))
        return Strong("the whole band"), ", ", low, " to ", high, "\xa0", FREQUENCY_UNIT, _range_of(e)
    by = listed(dict.fromkeys(_limit(c) for c in e.crossings if c.omega is e.bandwidth))
    more: Phrase = ("; transparent again ", spans(e.transparent[1:])) if len(e.transparent) > 1 else ""
    return Strong((both(e.bandwidth),)), (", limited by ", by) if by else "", _range_of(e), more


def _limit(c: Crossing) -> str:
    if c.criterion.joint or c.criterion.part is None:
        return f"the {c.criterion.joint.kind if c.criterion.joint else 'region'}"
    return f"the {PART_NAMES[c.criterion.part]} part"


def _range_of(e: Evaluation) -> Phrase:
    """The bandwidths that the range of the threshold gives."""
    found = e.bandwidths
    if found is None or found.least is None or found.most is None:
        return ""
    return (
        "; ",
        cell(found.least, Way.DOWN),
        " to ",
        cell(found.most, Way.UP),
        "\xa0",
        FREQUENCY_UNIT,
        " for the range of the JND",
    )


def felt_as(e: Evaluation) -> Phrase:
    """How each part is felt where it is first noticed: ``lower mass from 7.979 rad/s, higher damping from 11.94 rad/s``."""
    first = {x.part: x for x in reversed(e.felt)}
    found = sorted(first.values(), key=lambda x: float(x.band.low.omega))
    if not found:
        return "nothing noticed on the band"
    each = ((x.words, " from ", cell(x.band.low.omega), "\xa0", FREQUENCY_UNIT) for x in found)
    return tuple(y for x in each for y in (", ", x))[1:]


def stability(e: Evaluation) -> Phrase:
    """Under prescribed motion, and passivity: two statements, and never the one for the other."""
    if e.passivity is not None and e.passivity.holds:
        return Strong("passive"), ": stable in the hand of any passive operator"
    prescribed: dict[bool | None, Phrase] = {
        True: "stable", False: (Strong("unstable"), ""), None: (Strong("undecided"), ""),
    }  # fmt: skip
    found = e.passivity
    passive: Phrase = "passivity undecided"
    if found is not None and found.holds is False:
        passive = Strong("not passive"), _active(found)
    return prescribed[e.stable], " under prescribed motion; ", passive


_MOST_BANDS = 2


def _active(found: Passivity) -> Phrase:
    """Where the display is active; nothing where poles or a clock forbid passivity."""
    if not found.is_active or not found.active:
        return ""
    shown = found.active[:_MOST_BANDS]
    on = found.beyond is Beyond.ALWAYS and len(shown) == len(found.active)
    if on and not float(shown[-1].low.omega) and len(shown) == 1:
        return ", active at all frequencies"
    last: Phrase = ("above ", both(shown[-1].low.omega)) if on else ""
    before: Phrase = spans(shown[:-1] if on else shown) if len(shown) > bool(on) else ""
    more = ", …" if len(found.active) > _MOST_BANDS or found.beyond in (Beyond.AGAIN, Beyond.LATE) else ""
    return ", active ", before, " and " if before and last else "", last, more


def not_looked_at(found: Passivity) -> Phrase:
    """Of a sign that settles only after very many turns of a delay: where it settles, and from where on it was not tested."""
    high = both(ExactNumber(found.high))
    if found.active_from is None:
        return " (not tested above ", high, ")"
    settled = both(ExactNumber(found.active_from))
    return " and everywhere above ", settled, " (not tested from ", high, " to there)"


def _left_out(e: Evaluation) -> Iterator[Block]:
    """What was left out of the scene, and what that changes at most."""
    r = e.relevance
    if r is None or not r.dropped:
        return
    found = listed(
        (cell(x.bounds[0], Way.DOWN), " to ", cell(x.bounds[1], Way.UP), f" ({x.criterion.name})") for x in r.crossings
    )
    lie: Phrase = (
        ("Crossings of the full scene: ", found, "\xa0", FREQUENCY_UNIT, ".")
        if found
        else "The full scene has no crossings."
    )
    yield Paragraph((
        "Without ", listed(x.name for x in r.dropped), ", which changes ", bounds(r.bound), (" anywhere on the band "
        "(proven; tolerance "),
        near(float(r.tolerance)), "). All below is for the scene without. ", lie,
    ))  # fmt: skip


# Step 1, when.


def _step_1(e: Evaluation) -> Iterator[Block]:
    yield from bandwidths(e)
    yield _figure(e, "ratios", ratios_caption(e), wide=True)
    yield crossings(e)
    if e.undecided:
        yield undecided_table(e)


def joint(criteria: Iterable[Criterion]) -> Joint | None:
    """The region that judges both parts at once, where there is one."""
    return next((x.joint for x in criteria if x.joint), None)


def nothing_meets(region: Joint | None) -> str:
    """That what is judged crosses no limit."""
    return (
        f"The distortion does not reach the border of the {region.kind}" if region else "No ratio crosses its threshold"
    )


def crossings(e: Evaluation) -> Block:
    """Every crossing on the band: frequency, what happens, enclosure."""
    if not e.crossings:
        decided = ", up to what is undecided" if e.undecided else ""
        return Paragraph(f"{nothing_meets(joint(e.criteria))} on the band{decided}.")
    columns = (
        Column("part"), Column(FREQUENCY, number=True, hertz=True), Column("ratio"), Column("distortion"),
        Column(("enclosure of ", named("omega"), " (rad/s)"), full=True),
    )  # fmt: skip
    caption = f"All crossings of the thresholds on the band, {how_sure(e)}."
    return Table(columns, tuple(_crossing(e, c) for c in e.crossings), caption)


def how_sure(e: Evaluation) -> str:
    """How sure a table is."""
    if e.scene.level is not None:
        return "of the fitted model"
    return "proven" if e.certified else "proven up to what is undecided"


def _crossing(e: Evaluation, c: Crossing) -> tuple[Phrase, ...]:
    low, high = c.omega.enclosure(e.digits)
    return c.criterion.name, cell(c.omega), event(c), sense(c), f"[{low}, {high}]"


VERBS = {CrossingKind.EXCEEDS: "exceeds", CrossingKind.RETURNS: "returns below", CrossingKind.TOUCHES: "is tangent to"}


def event(c: Crossing, kind: str | None = None) -> Phrase:
    """``r_r exceeds 10 %``, ``ΔH leaves the ellipse``; ``kind`` : what a region is called, if not by its shape."""
    times = f" ({c.multiplicity}-fold)" if c.multiplicity > 1 else ""
    if c.criterion.joint:
        return CHANGE, f" {_LEAVES[c.kind]} the {kind or c.criterion.joint.kind}{times}"
    ratio = named(c.criterion.symbol)
    if c.jump:
        return "the limit of ", ratio, " changes: ", _JUMPS[c.kind]
    limit = "its limit" if c.criterion.region else amount(c.criterion.threshold)
    return ratio, f" {VERBS[c.kind]} ", limit, times


_LEAVES = {CrossingKind.EXCEEDS: "leaves", CrossingKind.RETURNS: "returns into", CrossingKind.TOUCHES: "is tangent to"}
_JUMPS = {
    CrossingKind.EXCEEDS: "exceeded above",
    CrossingKind.RETURNS: "exceeded below",
    CrossingKind.TOUCHES: "not exceeded at this frequency alone",
}


def sense(c: Crossing) -> Phrase:
    """``Re dH > 0``; nothing where both parts are judged."""
    return compared(Prefixed(Operator(c.criterion.component), CHANGE), ">" if c.sign > 0 else "<") if c.sign else ""


def undecided_table(e: Evaluation) -> Table:
    """What stayed undecided at the precision limit."""
    found = [(x.name, point.omega.enclosure(e.digits)) for x, point in e.undecided]
    rows = tuple((name, f"[{low}, {high}]") for name, (low, high) in found)
    caption = (
        "Undecided at the precision limit: whether the ratio is tangent to its threshold here, crosses it twice "
        "or stays clear."
    )
    return Table((Column("part"), Column(("near ", named("omega"), " (rad/s)"))), rows, caption)


_RATIOS = (
    "Distortion ratios over the band. Grey: neither exceeds its threshold, the display is transparent. A dot "
    "marks where the ratio of the real part crosses its threshold, a ring that of the imaginary part."
)
_JOINT_RATIOS = (
    "How many times the region must be enlarged to hold the distortion, over the band. Grey: not more than once, the display is "
    "transparent. A dot marks where the distortion leaves or enters the region."
)


def ratios_caption(e: Evaluation) -> str:
    """What the figure of ratios shows."""
    return _JOINT_RATIOS if joint(e.criteria) else _RATIOS


# A threshold that is a range.


def bandwidths(e: Evaluation) -> Iterator[Block]:
    """Where the threshold is a range: the least and the largest bandwidth, what between is not attained, a drawing."""
    found, threshold = e.bandwidths, e.scene.threshold
    if found is None:
        return
    yield Paragraph(("For ", _range(threshold), ": ", _between(found, threshold), _blocked(found, threshold)))
    if found.is_one_curve:
        caption = "The bandwidth over the range; a dot is attained, a ring is not."
        yield drawing("bandwidths", caption, "sheet:draw_figure", e, "bandwidths")


def _range(threshold: Threshold) -> Phrase:
    ranges = threshold.ranges
    if "scale" in ranges:
        return "a JND ", _from_to(ranges["scale"]), " times as large"
    limits = {name: x for name, x in ranges.items() if name != "floor"}
    equal = threshold.real == threshold.imag and threshold.real_interval == threshold.imag_interval
    found: list[Phrase] = []
    if limits and equal and threshold.region.lower == (None, None):
        found = [("thresholds ", _ends(limits["real"]))]
    elif limits:
        found = [("thresholds ", listed((_ends(x), f" ({_named(name, threshold)})") for name, x in limits.items()))]
    if "floor" in ranges:
        found.append(("a floor ", _from_to(ranges["floor"]), f" {_unit(threshold)}"))
    return listed(found)


def _from_to(interval: ExactRange) -> Phrase:
    return "from ", near(ExactNumber(interval[0])), " to ", near(ExactNumber(interval[1]))


def _named(name: str, threshold: Threshold) -> str:
    """``real``, or ``real part, where it decreases``."""
    return _of_part(name, threshold).removesuffix(" part")


def _of_part(name: str, threshold: Threshold) -> str:
    """``real part``, or ``real part, where it decreases``."""
    part, _, lower = name.partition(".")
    has_two = threshold.lower(Part(part)) is not None
    way = ", where it decreases" if lower else ", where it increases" if has_two else ""
    return f"{PART_NAMES[Part(part)]} part{way}"


def _unit(threshold: Threshold) -> str:
    return unit(Dimension.STIFFNESS, threshold.region.motion)


def _ends(interval: ExactRange) -> str:
    low, high = interval
    return f"from {percent(low)} to {percent(high)}"


def _between(found: Bandwidths, threshold: Threshold) -> Phrase:
    if found.most is None:
        return "no bandwidth, the distortion is noticed at the low end of the band."
    if found.least is None:
        return "the bandwidth is at most ", both(found.most, Way.UP), "; for some there is none."
    least, most = found.least, found.most
    if least is most or least.bounds(200) == most.bounds(200):
        return "the bandwidth is ", both(least), ", where there is one." if found.blocked else " for all."
    ends: Phrase = (
        "the bandwidth is at least ",
        both(least, Way.DOWN),
        " and at most ",
        both(most, Way.UP),
        "; both are attained",
    )
    if found.undecided:
        return ends, "."
    if found.ends_alone:
        return (
            ends,
            ", as the region increases with each of these numbers; which values between are attained is not tested.",
        )
    if not found.jumps:
        return ends, ", and each value between."
    return ends, ", and each value between but those ", listed(_jump(x, threshold) for x in found.jumps), "."


def _jump(x: Jump, threshold: Threshold) -> Phrase:
    gap: Phrase = "above " if x.includes_low else "from ", both(x.low), " to below ", both(x.high)
    if x.threshold is None:
        return gap
    name = next(iter(threshold.ranges))
    passed = "the threshold passes a peak of " if name not in ("scale", "floor") else f"at a {name} of "
    return gap, " (", passed, _size(x.threshold, name, threshold), ")"


def _size(x: RealNumber, name: str, threshold: Threshold) -> Phrase:
    if name == "scale":
        return near(x)
    return (near(x), f" {_unit(threshold)}") if name == "floor" else near(x, unit=_PERCENT)


_PERCENT = Unit("%", Rational(1, 100))


def _blocked(found: Bandwidths, threshold: Threshold) -> Phrase:
    if not found.blocked:
        return ""
    below: list[Phrase] = []
    for name, x in found.blocked.items():
        what = f" {name}" if name in ("scale", "floor") else " threshold"
        whose = f" for the {_of_part(name, threshold)}" if name not in ("scale", "floor", "jnd") else ""
        below.append((f"a{what} below ", _size(x, name, threshold), whose))
    return " There is none for ", listed(below), "."


def published_words(threshold: Threshold) -> Phrase:
    """Which published threshold it is; nothing where it is none."""
    if not threshold.source:
        return ""
    found = like(threshold.source)
    taken = f" at {float(100 * found.criterion):g}\xa0%" if found.criterion else ""
    return ", as ", Code(found.name), f": {found.quantity}{taken} ({found.source})"


_SURVIVES = "Does it hold for another JND model?"
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
        Column("region"), Column("what it is", full=True), Column("bandwidth", number=True, hertz=True),
        Column("first crossing", number=True, hertz=True), Column("what happens there"),
    )  # fmt: skip
    table = Table(columns, tuple(_row(e, x) for x in e.regions), "Bandwidth and first crossing by region, proven.")
    figure = drawing("regions", _PLANE, "sheet:draw_figure", e, "regions")
    yield Section(_SURVIVES, (Paragraph(_spread(e.regions)), table, figure), "regions")


def _row(e: Evaluation, x: Compared) -> tuple[Phrase, ...]:
    crossing = x.crossing
    first: tuple[Phrase, Phrase] = ("none", "")
    if crossing is not None:
        first = cell(crossing.omega), event(crossing, _KINDS.get(x.name))
    return x.name, limits(x.threshold), _width(e.chart, x.bandwidth), *first


def family_regions(w: FamilyEvaluation) -> Iterator[Block]:
    """How far the models are apart in the worst case, a row for each, and a row for each environment."""
    if not w.regions:
        return
    columns = (
        Column("region"), Column("what it is", full=True), Column("bandwidth", number=True, hertz=True), Column("limited by"),
    )  # fmt: skip
    worst = Table(
        columns, tuple(_worst(w, x) for x in w.regions), "Common bandwidth by region, and what limits it, proven."
    )
    by_name = Column("environment"), *(Column(x.name, number=True) for x in w.regions)
    rows = [(name, *(_width(w.chart, x.answers[name].bandwidth) for x in w.regions)) for name in w.family]
    rows.append(("all together", *(_width(w.chart, x.bandwidth) for x in w.regions)))
    each = Table(by_name, tuple(rows), ("Bandwidth of each environment by region, ", FREQUENCY_UNIT, ", proven."))
    figure = drawing("regions", _WIDTHS, "sheet:draw_figure", w, "regions")
    yield Section(_SURVIVES, (Paragraph(_spread(w.regions, "common bandwidth")), worst, each, figure), "regions")


def _worst(w: FamilyEvaluation, x: FamilyCompared) -> tuple[Phrase, ...]:
    who = listed(f"{y.environment} ({y.criterion.name})" for y in x.first)
    return x.name, limits(x.threshold), _width(w.chart, x.bandwidth), who


def _width(chart: Chart, x: RealNumber | None) -> Phrase:
    """A bandwidth as a cell has it."""
    if x is None:
        return "none"
    if float(x) == float(chart.points[-1].omega):
        return "whole band"
    return cell(x)


def _spread(found: Sequence[Compared | FamilyCompared], what: str = "bandwidth") -> Phrase:
    """How far apart the bandwidths are; ``what`` : as they are called."""
    widths = [x.bandwidth for x in found if x.bandwidth is not None]
    if not widths:
        return f"With each region: no {what}."
    least, most = min(widths, key=float), max(widths, key=float)
    if len(widths) < len(found):
        between: Phrase = ("from ", cell(least, Way.DOWN), " to ", cell(most, Way.UP), "\xa0", FREQUENCY_UNIT)
        return f"The {what} depends on the JND model: none with some regions, ", between, " with the others."
    if float(least) == float(most):
        return f"The {what} is the same with all regions: ", both(most), "."
    times: Phrase = (", a factor of ", near(float(most) / float(least))) if float(least) else ""
    return (
        f"The {what} is from ",
        cell(least, Way.DOWN),
        " to ",
        cell(most, Way.UP),
        "\xa0",
        FREQUENCY_UNIT,
        " with these regions",
        times,
        ".",
    )


_MOST_LETTERS = 280  # of a formula: three lines


def _dynamics(e: Evaluation) -> Iterator[tuple[str, Phrase]]:
    """Environment, what effects make of it, and the distortion, in closed form."""
    d, rendered = e.distortion, e.scene.rendered
    unit = f"  {stiffness_unit(e.scene)}"
    yield "environment", _equation("H_env", d.env, s, unit)
    if rendered:
        yield "rendered", _equation("H_rendered", d.env.ring.convert(rendered.H), s, unit)
    yield "perceived", _equation("H_perc", d.perc, s, unit)
    yield "distortion", _equation("Re dH", d.difference_response.real.written, omega)
    yield "", _equation("Im dH", d.difference_response.imag.written, omega)


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


# Step 2, how.


def _step_2(e: Evaluation) -> Iterator[Block]:
    yield percepts(e)
    for part, name in ((Part.REAL, "real"), (Part.IMAG, "imaginary")):
        yield _figure(
            e, f"projections-{part.value}", f"Magnitude of the {name} part of environment and perceived dynamics: bold where the "
            "difference is noticed, with what it is felt as.",
        )  # fmt: skip
    yield _figure(
        e, "nyquist", "Environment (solid) and perceived dynamics (dashed) in the complex plane; arrows towards "
        "higher frequencies.",
    )  # fmt: skip
    yield _figure(
        e, "jnd-square", "Environment and perceived dynamics at one frequency; the grey region holds the changes that "
        "are not noticed.",
    )  # fmt: skip


def _figure(e: Evaluation, name: str, caption: str, *, wide: bool = False) -> Figure:
    return drawing(name, caption, "sheet:draw_figure", e, name, wide=wide)


def percepts(e: Evaluation) -> Block:
    """What is felt where a ratio exceeds its threshold."""
    region = joint(e.criteria)
    if not e.felt:
        why = f"the distortion never leaves the {region.kind}" if region else "neither ratio exceeds its threshold"
        return Paragraph(f"Nothing is noticed on the band: {why}.")
    rows = tuple((x.part.value if x.part else JOINT, ends(x.band), x.words) for x in e.felt)
    where = f"outside the {region.kind}" if region else "where a ratio exceeds its threshold"
    columns = Column("part"), Column((FREQUENCY, " (", FREQUENCY_UNIT, ")")), Column("felt as")
    return Table(columns, rows, f"What is felt {where}, {how_sure(e)}.")


def _remarks(e: Evaluation) -> Iterator[Phrase]:
    """What else there is, a line each."""
    yield from _friction(e)
    if e.changeovers_environment or e.changeovers_perceived:
        env, perc = (places(x) if x else "none" for x in (e.changeovers_environment, e.changeovers_perceived))
        yield "Changeover frequency: ", env, " (environment), ", perc, " (perceived)."
    yield from _any_environment(e)
    if e.outside_model:
        active = compared(Prefixed(OPERATORS[Part.IMAG], H_PERC), "<")
        noticed = ": no property applies to the imaginary part there." if e.unnamed else ", not noticed there."
        yield "Active (", active, ") ", spans(e.outside_model), noticed
    if e.unbounded:
        why = (compared(H_ENV, "="), ", or ", CHANGE, " infinite")
        yield "A ratio is unbounded at ", places(e.unbounded), " (", why, ")."
    yield from _energy(e)


def _any_environment(e: Evaluation) -> Iterator[Phrase]:
    found = e.any_environment
    if found is None or not e.scene.effects:
        return
    below, above, end = found.transparent_below, found.opaque_above, e.chart.points[-1].omega
    if below == end:
        yield "For any environment: unnoticed on this band."
        return
    low: Phrase = (
        "noticed with some at the low end of the band" if below is None else ("unnoticed up to ", both(below, Way.DOWN))
    )
    yield "For any environment: ", low, () if above is None else (", noticed above ", both(above, Way.UP)), "."


def _friction(e: Evaluation) -> Iterator[Phrase]:
    if e.friction is None:
        return
    newton = unit(Dimension.FORCE, e.scene.motion)
    found = "Friction of ", near(float(e.friction.force)), f" {newton} in the display"
    source = "(Veldhuis, Mulder and van Paassen, 2024: a Weber fraction and a floor)"
    if e.friction.noticed is None or e.friction.least is None:
        how = Code('friction = { weber = ..., floor = "... N" }'), " in ", Code("[evaluation]"), "."
        yield *found, f" has a threshold of its own {source}, which the scene does not give: ", *how
    else:
        verdict: Phrase = Strong("noticed") if e.friction.noticed else "not noticed"
        least, reference = (float(x or 0) for x in (e.friction.least, e.friction.reference))
        how_far = "more than " if e.friction.noticed else "at most "
        yield (
            *found, " is ", verdict, " as friction: it differs by ", how_far, near(least), f" {newton} from the ",
            near(reference),
            f" {newton} that should be felt {source}.",
        )  # fmt: skip


def _energy(e: Evaluation) -> Iterator[Phrase]:
    """Of a display that is not passive: the energy that it generates, and the damping of a hand that compensates it."""
    found = e.passivity
    if found is None or not found.is_active or found.holds is not False:
        return
    if found.damping is not None and found.poles_allow:
        damping = unit(Dimension.DAMPING, e.scene.motion)
        yield (
            "Stable in any hand with damping above ",
            at_most(found.damping.value),
            f" {damping}, for any mass and stiffness.",
        )
    elif found.is_unbounded:
        yield "No damping of a hand compensates this activity at all frequencies: it increases faster than frequency."


# What is proven.


def _proven(e: Evaluation) -> Iterator[Phrase]:
    if e.undecided:
        where = listed((both(point.omega), f" ({x.name})") for x, point in e.undecided)
        yield undecided(
            ("whether a ratio is tangent to its threshold, crosses it twice or stays clear of it near ", where)
        )
        yield "Proven: everything else."
        return
    passive = ", passivity" if e.passivity is not None and e.passivity.holds is not None else ""
    yield proof(e.scene, f"all crossings on the band{passive}, and all digits printed")
    if e.bandwidths is not None and e.bandwidths.undecided:
        yield undecided(e.bandwidths.undecided)
