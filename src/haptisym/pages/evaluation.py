"""The page of an evaluation: the answer in three lines, step 1 (when the distortion is noticed),
step 2 (as what it is felt), and what is proven.

The same document is printed, set in LaTeX and HTML, and shown in a notebook. A report has more of
it: the scene, the values of each parameter that satisfy the JND, an explorer, the derivation. Begin
with ``page`` and ``findings``.

The pages of several environments at once, and of the peaks of the ratios, follow it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

from sympy import Rational

from haptisym.figures import pen
from haptisym.judge.bandwidths import Bandwidths, Jump
from haptisym.judge.crossings import JOINT, Criterion, Crossing, CrossingKind, noticed
from haptisym.judge.evaluation import Compared, Evaluation, Reported, different, region_label
from haptisym.judge.passivity import Beyond, Passivity
from haptisym.judge.peaks import Peaks
from haptisym.judge.regions import Joint
from haptisym.kernel.reals import ExactNumber, RealNumber, Scaled, Way
from haptisym.kernel.rings import omega, s
from haptisym.kernel.roots import Chart
from haptisym.model.jnd import Part, Threshold, like
from haptisym.model.parameters import ExactRange
from haptisym.model.quantities import Dimension, Unit
from haptisym.model.scene import caveats as cautions
from haptisym.pages import words as w
from haptisym.writing import document as doc
from haptisym.writing.boxes import Operator, Prefixed, Titled
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, Strong, listed
from haptisym.writing.layout import named

if TYPE_CHECKING:
    from haptisym.pages.scene import SceneForms
    from haptisym.verbs.family.entry import FamilyCompared, FamilyEvaluation


def page(e: Evaluation) -> Document:
    """Return the whole page of an evaluation."""
    full = _InFull(e)
    low, high = (w.cell(e.chart.points[i].omega) for i in (0, -1))
    judged = w.limits(e.scene.threshold), published_words(e.scene.threshold)
    step_1: Phrase = (
        "Step 1: crossings on ",
        low,
        " to ",
        high,
        "\xa0",
        FREQUENCY_UNIT,
        ", JND ",
        judged,
    )
    # Versions, Formulas and Live hold functions: what a kind of output does not show is not
    # computed.
    blocks = (
        *_left_out(e),
        doc.Section("Scene", (doc.Versions((), full.scene),), "scene"),
        doc.Section(step_1, tuple(_step_1(e)), "step-1"),
        *regions(e),
        *deciding(e),
        doc.Section("Step 2: perceived change", tuple(_step_2(e)), "step-2"),
        *_movement(e),
        *w.noted(_remarks(e)),
        doc.Section(
            "Formulas",
            (doc.Versions((doc.Formulas(lambda: [doc.Facts(tuple(_dynamics(e)))]),)),),
            "formulas",
        ),
        doc.Section(
            "Which values satisfy the JND?", (doc.Versions((), full.design),), "which-values"
        ),
        doc.Section("Explorer", (doc.Live(full.explorer),), "explorer"),
        *w.caveats(e.caveats),
        doc.Section(
            "Derivation", (doc.Versions((), full.derivation),), "derivation", appendix=True
        ),
    )
    kind = "Two-step evaluation of a haptic display"
    further = ("--formulas", "haptisym stability SCENE --hand NAME")
    return w.page_about(e.scene, findings(e), blocks, proven(e), kind, e.asides(), further)


def _percent(x: float) -> str:
    """Return a share in per cent with its sign: to a tenth, or three digits of what is smaller than
    that."""
    return f"{100 * x:+{'.1f' if not x or abs(x) >= 5e-4 else '.3g'}}\xa0%"


_FITTED = {
    "k": ("stiffness", Dimension.STIFFNESS),
    "b": ("damping", Dimension.DAMPING),
    "m": ("mass", Dimension.MASS),
}


def _movement(e: Evaluation) -> Iterator[doc.Block]:
    """Yield what a fit to a movement reports of the environment and of what is felt."""
    fit = e.movement
    if fit is None:
        return
    rows = w.table(
        _FITTED,
        f"Least squares over a {fit.spectrum}.",
        w.Field("", lambda x: _FITTED[x][0]),
        w.number("environment", lambda x: _fitted(fit, "environment", fit.environment[x])),
        w.number("perceived", lambda x: _fitted(fit, "perceived", fit.perceived[x])),
        w.Field("unit", lambda x: w.unit(_FITTED[x][1], e.scene.motion)),
        w.number("change", lambda x: "" if (change := fit.change[x]) is None else _percent(change)),
    )
    said: list[Phrase] = [
        (
            f"Least squares over a {fit.spectrum}: what a fit to this movement reports, not "
            f"what a person was shown to perceive."
        )
    ]
    for name, places in fit.poles.items():
        at = listed(w.both(x) for x in places)
        said.append((w.SYSTEMS[name], " is infinite at ", at, ": there is no fit of it."))
    # Below the bandwidth no single frequency is noticed; yet a fit to the whole movement may report
    # a parameter that is off by more than the threshold. That is said.
    largest = max(_FITTED, key=lambda x: abs(fit.change[x] or 0.0))
    change = fit.change[largest] or 0.0
    if (
        e.bandwidth is not None
        and fit.band[1] <= float(e.bandwidth)
        and abs(change) > float(e.scene.threshold.real)
    ):
        more = "higher" if change > 0 else "lower"
        said.append(
            f"Nothing is noticed at any one frequency of this movement; still the fitted "
            f"{_FITTED[largest][0]} is"
            f" {abs(100 * change):.1f}\xa0% {more}."
        )
    yield doc.Section("What a fit to a movement reports", (rows, *w.noted(said)), "movement")


def _fitted(found: Reported, system: str, x: float | None) -> Phrase:
    """A number of a fit; a double has 15 digits."""
    if x is None:
        return "none" if system in found.poles else Strong("undecided")
    # A double has 15 to 17 correct decimal digits, and a fit is computed in doubles.
    return w.near(x, most=15)


@dataclass(frozen=True)
class _InFull:
    """The sections that a report has and a printed page has not; each imports what writes it when
    it is written."""

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

        return explorer(self.evaluation, self._forms, at_rest(self.evaluation))

    def derivation(self) -> Iterable[Block]:
        from haptisym.pages.scene import derivation

        return derivation(self._forms)


# The answer.


def findings(e: Evaluation) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the three lines of the answer: bandwidth, what is felt, stability."""
    yield "Bandwidth", _bandwidth(e)
    yield "Felt as", felt_as(e)
    yield "Stability", stability(e)


def _bandwidth(e: Evaluation) -> Phrase:
    """Return the bandwidth with what limits it, the whole band, or none."""
    if e.bandwidth is None:
        onward: Phrase = "noticed on the whole band"
        if e.transparent:
            onward = "noticed from the low end of the band on; transparent ", w.spans(e.transparent)
        return Strong("none"), ": ", onward
    if w.is_transparent_throughout(e):
        low, high = (w.cell(e.chart.points[i].omega) for i in (0, -1))
        return (
            Strong("the whole band"),
            ", ",
            low,
            " to ",
            high,
            "\xa0",
            FREQUENCY_UNIT,
            _range_of(e),
        )
    # Identity, not equality: a crossing that ends the first transparent interval has that very
    # number. Both parts may cross at it.
    by = listed(dict.fromkeys(_limit(c) for c in e.crossings if c.omega is e.bandwidth))
    more: Phrase = (
        ("; transparent again ", w.spans(e.transparent[1:])) if len(e.transparent) > 1 else ""
    )
    return Strong((w.both(e.bandwidth),)), (", limited by ", by) if by else "", _range_of(e), more


def _limit(c: Crossing) -> str:
    """Return what a crossing is about, in words: the region, or one of the parts."""
    if c.criterion.joint or c.criterion.part is None:
        return f"the {c.criterion.joint.kind if c.criterion.joint else 'region'}"
    return f"the {w.PART_NAMES[c.criterion.part]} part"


def _range_of(e: Evaluation) -> Phrase:
    """Return the bandwidths that a threshold with a range gives; nothing for a single number."""
    found = e.bandwidths
    if found is None or found.least is None or found.most is None:
        return ""
    # Outwards: the printed range holds all bandwidths that there are.
    ends_ = w.cell(found.least, Way.DOWN), w.cell(found.most, Way.UP)
    return w.phrased("; {} to {}\xa0{} for the range of the JND", *ends_, FREQUENCY_UNIT)


def felt_as(e: Evaluation) -> Phrase:
    """How each part is felt where it is first noticed: ``lower mass from 7.979 rad/s, higher
    damping from 11.94 rad/s``."""
    # From the last band to the first: of each part the first one is what stays in the dictionary.
    first = {x.part: x for x in reversed(e.felt)}
    in_order = sorted(first.values(), key=lambda x: float(x.band.low.omega))
    if not in_order:
        return "nothing noticed on the band"
    each = ((x.words, " from ", w.cell(x.band.low.omega), "\xa0", FREQUENCY_UNIT) for x in in_order)
    return tuple(y for x in each for y in (", ", x))[1:]


def stability(e: Evaluation) -> Phrase:
    """Return two statements: stability under prescribed motion, and passivity. Neither stands for
    the other."""
    model = w.of_linear_model(e.scene)
    if e.passivity is not None and e.passivity.holds:
        return Strong("passive"), ": stable in the hand of any passive operator", model
    prescribed: dict[bool | None, Phrase] = {
        True: "stable",
        False: (Strong("unstable"), ""),
        None: (Strong("undecided"), ""),
    }
    passivity = e.passivity
    passive: Phrase = "passivity undecided"
    if passivity is not None and passivity.holds is False:
        passive = Strong("not passive"), _active(passivity)
    return prescribed[e.stable], " under prescribed motion; ", passive, model


_MOST_BANDS = 2


def _active(found: Passivity) -> Phrase:
    """Return the frequencies at which the display is active; nothing where poles or a clock forbid
    passivity."""
    if not found.is_active or not found.active:
        return ""
    shown = found.active[:_MOST_BANDS]
    # The last active interval goes on for ever, and is among those that are printed.
    on = found.beyond is Beyond.ALWAYS and len(shown) == len(found.active)
    # One interval from 0 on that never ends.
    if on and not float(shown[-1].low.omega) and len(shown) == 1:
        return ", active at all frequencies"
    last: Phrase = ("above ", w.both(shown[-1].low.omega)) if on else ""
    before: Phrase = w.spans(shown[:-1] if on else shown) if len(shown) > bool(on) else ""
    more = (
        ", and in further bands"
        if len(found.active) > _MOST_BANDS or found.beyond in (Beyond.AGAIN, Beyond.LATE)
        else ""
    )
    return ", active ", before, " and " if before and last else "", last, more


def not_looked_at(found: Passivity) -> Phrase:
    """Return, for a sign that settles only after very many turns of a delay, where it settles, and
    from where on it was not tested."""
    high = w.both(ExactNumber(found.high))
    if found.active_from is None:
        return " (not tested above ", high, ")"
    settled = w.both(ExactNumber(found.active_from))
    return " and everywhere above ", settled, " (not tested from ", high, " to there)"


def _left_out(e: Evaluation) -> Iterator[Block]:
    """Yield which effects were left out of the scene, and what that changes at most."""
    r = e.relevance
    if r is None or not r.dropped:
        return
    # Enclosures of crossings are rounded outwards.
    intervals = listed(
        (
            w.cell(x.bounds[0], Way.DOWN),
            " to ",
            w.cell(x.bounds[1], Way.UP),
            f" ({x.criterion.name})",
        )
        for x in r.crossings
    )
    lie: Phrase = "The full scene has no crossings."
    if intervals:
        lie = w.phrased("Crossings of the full scene: {}\xa0{}.", intervals, FREQUENCY_UNIT)
    words = (
        "Without {}, which changes {} anywhere on the band (proven; tolerance {}). All below is "
        "for the scene without. {}"
    )
    yield doc.Paragraph(
        w.phrased(
            words,
            listed(x.name for x in r.dropped),
            w.bounds(r.bound),
            w.near(float(r.tolerance)),
            lie,
        )
    )


# Step 1, when.


def _step_1(e: Evaluation) -> Iterator[Block]:
    """Yield the blocks of step 1: bandwidths of a threshold with a range, the ratios, the
    crossings."""
    yield from bandwidths(e)
    yield w.drawing(e, "ratios", ratios_caption(e), wide=True)
    yield crossings(e)
    if e.undecided:
        yield undecided_table(e)


def joint(criteria: Iterable[Criterion]) -> Joint | None:
    """Return the region that judges both parts at once; None where each part has a threshold."""
    return next((x.joint for x in criteria if x.joint), None)


def nothing_meets(region: Joint | None) -> str:
    """Return the words for a distortion that crosses no limit."""
    return (
        f"The distortion does not reach the border of the {region.kind}"
        if region
        else "No ratio crosses its threshold"
    )


def crossings(e: Evaluation) -> Block:
    """Every crossing on the band: frequency, what happens, enclosure."""
    if not e.crossings:
        # Where a tangency is undecided, that nothing crosses is proven elsewhere alone.
        decided = ", up to what is undecided" if e.undecided else ""
        return doc.Paragraph(f"{nothing_meets(joint(e.criteria))} on the band{decided}.")
    # Of a fitted model the digits of an enclosure would be those of an estimate.
    fitted = e.scene.level is not None
    enclosure = w.Field(("enclosure of ", w.IN_UNIT), lambda c: _enclosure(c.omega, e), full=True)
    numbers = [w.Field("no.", lambda c: str(e.crossings.index(c) + 1))] if _is_numbered(e) else []
    return w.table(
        e.crossings,
        f"All crossings of the thresholds on the band, {how_sure(e)}.",
        *numbers,
        w.Field("part", lambda c: c.criterion.name),
        w.hertz(lambda c: w.cell(c.omega)),
        w.Field("ratio", event),
        w.Field("distortion", sense),
        *([] if fitted else [enclosure]),
    )


def _enclosure(x: RealNumber, e: Evaluation) -> str:
    """Return the interval that holds a frequency, in the unit of the scene."""
    size = e.scene.frequency.size
    return "[{}, {}]".format(*(x if size == 1 else Scaled(x, size)).enclosure(e.digits))


def how_sure(e: Evaluation) -> str:
    """Return how sure a table of crossings is, in a word or two."""
    # A fitted scene has ranges that are estimated at some level; its crossings are proven for the
    # fitted values only.
    if e.scene.level is not None:
        return "of the fitted model"
    return "proven" if e.certified else "proven up to what is undecided"


_MOST_AT_REST = 6


def at_rest(e: Evaluation) -> Phrase:
    """Return bandwidth and crossings in a sentence, which a report has next to its sliders."""
    shown = [(event(c), " at ", w.both(c.omega)) for c in e.crossings[:_MOST_AT_REST]]
    more = len(e.crossings) - len(shown)
    entries: Phrase = ("; ", listed(shown), f"; {more} more" if more else "") if shown else ""
    return f"The scene's values, {how_sure(e)}: bandwidth ", _bandwidth(e), entries, "."


VERBS = {
    CrossingKind.EXCEEDS: "exceeds",
    CrossingKind.RETURNS: "returns below",
    CrossingKind.TOUCHES: "is tangent to",
}


def event(c: Crossing, kind: str | None = None) -> Phrase:
    """``r_r exceeds 10 %``, ``ΔH leaves the ellipse``; ``kind`` : what a region is called, if not
    by its shape."""
    times = f" ({c.multiplicity}-fold)" if c.multiplicity > 1 else ""
    if c.criterion.joint:
        return w.CHANGE, f" {_LEAVES[c.kind]} the {kind or c.criterion.joint.kind}{times}"
    ratio = named(c.criterion.symbol)
    # The limit depends on whether the part grows or shrinks: where that changes, the ratio may be
    # on the other side without a crossing.
    if c.jump:
        return "the limit of ", ratio, " changes: ", _JUMPS[c.kind]
    limit = "its limit" if c.criterion.region else w.amount(c.criterion.threshold)
    return ratio, f" {VERBS[c.kind]} ", limit, times


_LEAVES = {
    CrossingKind.EXCEEDS: "leaves",
    CrossingKind.RETURNS: "returns into",
    CrossingKind.TOUCHES: "is tangent to",
}
_JUMPS = {
    CrossingKind.EXCEEDS: "exceeded above",
    CrossingKind.RETURNS: "exceeded below",
    CrossingKind.TOUCHES: "not exceeded at this frequency alone",
}


def sense(c: Crossing) -> Phrase:
    """``Re dH > 0``; nothing where both parts are judged."""
    return (
        w.compared(Prefixed(Operator(c.criterion.component), w.CHANGE), ">" if c.sign > 0 else "<")
        if c.sign
        else ""
    )


def undecided_table(e: Evaluation) -> doc.Table:
    """Return the table of places where crossings stayed undecided at the precision limit."""
    return w.table(
        e.undecided,
        "Undecided at the precision limit: whether the ratio is tangent to its threshold "
        "here, crosses it twice or "
        "stays clear.",
        w.Field("part", lambda x: x[0].name),
        w.Field(("near ", w.IN_UNIT), lambda x: _enclosure(x[1].omega, e)),
    )


_RATIOS = (
    "Distortion ratios over the band. Grey: neither exceeds its threshold, the display is "
    "transparent. A dot "
    "marks where the ratio of the real part crosses its threshold, a ring that of the "
    "imaginary part."
)
_JOINT_RATIOS = (
    "How many times the region must be enlarged to hold the distortion, over the band. Grey: "
    "not more than once, the display is "
    "transparent. A dot marks where the distortion leaves or enters the region."
)


def ratios_caption(e: Evaluation) -> str:
    """Return the caption of the figure of ratios."""
    numbers = " The numbers are those of the table." if _is_numbered(e) else ""
    return (_JOINT_RATIOS if joint(e.criteria) else _RATIOS) + numbers


def _is_numbered(e: Evaluation) -> bool:
    """Whether a figure has numbers in place of the frequencies of its many crossings."""
    return len(e.crossings) > pen.MOST_LABELS


# A threshold that is a range.


def bandwidths(e: Evaluation) -> Iterator[Block]:
    """Yield, for a threshold with a range, the least and the largest bandwidth, the values between
    that are not attained, and a drawing."""
    attained, threshold = e.bandwidths, e.scene.threshold
    if attained is None:
        return
    yield doc.Paragraph(
        (
            "For ",
            _range(threshold),
            ": ",
            _between(attained, threshold),
            _blocked(attained, threshold),
        )
    )
    if attained.is_one_curve:
        caption = "The bandwidth over the range; a dot is attained, a ring is not."
        yield w.drawing(e, "bandwidths", caption)


def _range(threshold: Threshold) -> Phrase:
    """Return the numbers of the threshold that have ranges, in words."""
    ranges = threshold.ranges
    if "scale" in ranges:
        return "a JND ", _from_to(ranges["scale"]), " times as large"
    limits = {name: x for name, x in ranges.items() if name != "floor"}
    # Both parts with one threshold are named once; with a limit for shrinking, each is named.
    equal = threshold.real == threshold.imag and threshold.real_interval == threshold.imag_interval
    parts: list[Phrase] = []
    if limits and equal and threshold.region.lower == (None, None):
        parts = [("thresholds ", _ends(limits["real"]))]
    elif limits:
        parts = [
            (
                "thresholds ",
                listed((_ends(x), f" ({_named(name, threshold)})") for name, x in limits.items()),
            )
        ]
    if "floor" in ranges:
        parts.append(("a floor ", _from_to(ranges["floor"]), f" {_unit(threshold)}"))
    return listed(parts)


def _from_to(interval: ExactRange) -> Phrase:
    """Return the ends of a range as numbers without a unit."""
    return "from ", w.near(ExactNumber(interval[0])), " to ", w.near(ExactNumber(interval[1]))


def _named(name: str, threshold: Threshold) -> str:
    """``real``, or ``real part, where it decreases``."""
    return _of_part(name, threshold).removesuffix(" part")


def _of_part(name: str, threshold: Threshold) -> str:
    """``real part``, or ``real part, where it decreases``."""
    part, _, lower = name.partition(".")
    has_two = threshold.lower(Part(part)) is not None
    way = ", where it decreases" if lower else ", where it increases" if has_two else ""
    return f"{w.PART_NAMES[Part(part)]} part{way}"


def _unit(threshold: Threshold) -> str:
    """Return the unit of a floor: that of dynamics."""
    return w.unit(Dimension.STIFFNESS, threshold.region.motion)


def _ends(interval: ExactRange) -> str:
    """Return the ends of a range in per cent."""
    low, high = interval
    return f"from {w.percent(low)} to {w.percent(high)}"


def _between(found: Bandwidths, threshold: Threshold) -> Phrase:
    """Return the least and the largest bandwidth for a threshold with a range, and which values
    between are attained."""
    if found.most is None:
        return "no bandwidth, the distortion is noticed at the low end of the band."
    if found.least is None:
        return "the bandwidth is at most ", w.both(found.most, Way.UP), "; for some there is none."
    least, most = found.least, found.most
    # Equal balls of 200 bits are taken as one number in two forms.
    if least is most or least.bounds(200) == most.bounds(200):
        return (
            "the bandwidth is ",
            w.both(least),
            ", where there is one." if found.blocked else " for all.",
        )
    between: Phrase = ", and each value between"
    if found.undecided:
        between = ""
    elif found.ends_alone:
        between = (
            ", as the region increases with each of these numbers; which values between are "
            "attained is not tested"
        )
    elif found.jumps:
        between = (between, " but those ", listed(_jump(x, threshold) for x in found.jumps))
    words = "the bandwidth is at least {} and at most {}; both are attained{}."
    return w.phrased(words, w.both(least, Way.DOWN), w.both(most, Way.UP), between)


def _jump(x: Jump, threshold: Threshold) -> Phrase:
    """Return a gap in the bandwidths, and the threshold at which it is jumped over."""
    gap: Phrase = (
        "above " if x.includes_low else "from ",
        w.both(x.low),
        " to below ",
        w.both(x.high),
    )
    if x.threshold is None:
        return gap
    name = next(iter(threshold.ranges))
    passed = (
        "the threshold passes a peak of " if name not in ("scale", "floor") else f"at a {name} of "
    )
    return gap, " (", passed, _size(x.threshold, name, threshold), ")"


def _size(x: RealNumber, name: str, threshold: Threshold) -> Phrase:
    """Return a value of the number that has a range, in its unit: a factor, a stiffness, or per
    cent."""
    if name == "scale":
        return w.near(x)
    return (w.near(x), f" {_unit(threshold)}") if name == "floor" else w.near(x, unit=_PERCENT)


_PERCENT = Unit("%", Rational(1, 100))


def _blocked(found: Bandwidths, threshold: Threshold) -> Phrase:
    """Return for which values of the threshold there is no bandwidth."""
    if not found.blocked:
        return ""
    below: list[Phrase] = []
    for name, x in found.blocked.items():
        what = f" {name}" if name in ("scale", "floor") else " threshold"
        whose = (
            f" for the {_of_part(name, threshold)}" if name not in ("scale", "floor", "jnd") else ""
        )
        below.append((f"a{what} below ", _size(x, name, threshold), whose))
    return " There is none for ", listed(below), "."


def published_words(threshold: Threshold) -> Phrase:
    """Return the published threshold that the scene names; nothing where it names none."""
    if not threshold.source:
        return ""
    found = like(threshold.source)
    taken = f" at {float(100 * found.criterion):g}\xa0%" if found.criterion else ""
    return ", as ", doc.Code(found.name), f": {found.quantity}{taken} ({found.source})"


_SURVIVES = "Does it hold for another JND model?"
_PLANE = (
    "The distortion relative to the environment over the band, and the regions within which "
    "it is not noticed; a dot where it "
    "first meets the border of each. A region that depends on the frequency is drawn as it "
    "is there, or else at the high end."
)
_WIDTHS = (
    "Bandwidth of each environment, and of all together, by JND region; none: no transparent "
    "band starts at the low end."
)
_KINDS = {"disc": "disc"}
"""Names of regions for which the shape alone says too little, as events call them."""


def regions(e: Evaluation) -> Iterator[Block]:
    """A sentence that says how far the models are apart, a row for each, and a drawing; nothing
    where that was not asked."""
    if not e.regions:
        return
    rows = w.table(
        different(e.regions),
        "Bandwidth and first crossing by region, proven.",
        *_REGION,
        w.hertz(lambda x: _width(e.chart, x.bandwidth), "bandwidth"),
        w.hertz(lambda x: w.cell(x.crossing.omega) if x.crossing else "none", "first crossing"),
        w.Field(
            "what happens there",
            lambda x: event(x.crossing, _KINDS.get(x.name)) if x.crossing else "",
        ),
    )
    figure = w.drawing(e, "regions", _PLANE)
    yield doc.Section(_SURVIVES, (doc.Paragraph(_spread(e.regions)), rows, figure), "regions")


_DECIDING = (
    "The regions of the models, the numbers of the changes that would decide between them, "
    "and the distortion of the display "
    "over the band. Regions that depend on the frequency are drawn as they are at that of "
    "the first change."
)


def deciding(e: Evaluation) -> Iterator[Block]:
    """Which changes would decide between models of the JND, and where the display is one; nothing
    where that was not asked."""
    discrimination = e.discrimination
    if discrimination is None:
        return
    # Changes are numbered as in the figure; two may be equal, hence the identity.
    place = {id(x): i for i, x in enumerate(discrimination.stimuli, 1)}
    who = w.Field("noticed by", lambda x: x.noticed_by), w.Field("not by", lambda x: x.not_by)
    margin = w.number("margin", lambda x: w.near(x.margin))
    more = named("Delta")
    units = [w.unit(x, e.scene.motion) for x in (Dimension.STIFFNESS, Dimension.DAMPING)]
    rows = w.table(
        discrimination.stimuli,
        "For each two models the change of stiffness and damping that one notices and the "
        "other does not by the "
        "largest margin, computed.",
        w.Field("", lambda x: str(place[id(x)])),
        *who,
        w.number(w.IN_UNIT, lambda x: w.cell(x.omega)),
        w.number(
            (Titled("dk", Prefixed(more, named("k"))), f" ({units[0]})"),
            lambda x: w.near(x.stiffness),
        ),
        w.number(
            (Titled("db", Prefixed(more, named("b"))), f" ({units[1]})"),
            lambda x: w.near(x.damping),
        ),
        margin,
    )
    words = (
        "Computed predictions of the models, not results with persons. Each change exceeds "
        "the limit of one model by its margin, "
        "and stays below that of the other by the same factor. The opposite change is judged "
        "equally."
    )
    near = listed(map(w.both, discrimination.undecided))
    said = [words, *([w.undecided(("whether a region is reached near ", near))] if near else [])]
    figure = w.drawing(e, "discriminate", _DECIDING)
    yield doc.Section(
        "Which changes would decide between the models?",
        (rows, *w.noted(said), figure),
        "discriminate",
    )
    display: Block = doc.Paragraph("All models judge the display equally on the whole band.")
    if discrimination.display:
        display = w.table(
            discrimination.display,
            (
                "Where two models judge the display differently, proven; where by the largest "
                "margin, computed."
            ),
            *who,
            w.Field(w.IN_UNIT, lambda x: w.ends(x.interval)),
            w.number("clearest at", lambda x: w.cell(x.omega)),
            margin,
        )
    yield doc.Section("Where does the display decide?", (display,), "display-decides")


_REGION = (
    w.Field("region", region_label),
    w.Field("what it is", lambda x: w.limits(x.threshold), full=True),
)


def family_regions(many: FamilyEvaluation) -> Iterator[Block]:
    """How far the models are apart in the worst case, a row for each, and a row for each
    environment."""
    if not many.regions:
        return
    worst = w.table(
        different(many.regions),
        "Common bandwidth by region, and what limits it, proven.",
        *_REGION,
        w.hertz(lambda x: _width(many.chart, x.bandwidth), "bandwidth"),
        w.Field(
            "limited by", lambda x: listed(f"{y.environment} ({y.criterion.name})" for y in x.first)
        ),
    )
    together = "all together"

    def width(name: str, x: FamilyCompared) -> Phrase:
        return _width(many.chart, x.bandwidth if name == together else x.answers[name].bandwidth)

    each = w.table(
        [*many.family, together],
        ("Bandwidth of each environment by region, ", FREQUENCY_UNIT, ", proven."),
        w.Field("environment", str),
        *(w.number(region_label(x), partial(width, x=x)) for x in different(many.regions)),
    )
    figure = w.drawing(many, "regions", _WIDTHS)
    yield doc.Section(
        _SURVIVES,
        (doc.Paragraph(_spread(many.regions, "common bandwidth")), worst, each, figure),
        "regions",
    )


def _width(chart: Chart, x: RealNumber | None) -> Phrase:
    """A bandwidth as a cell has it."""
    return (
        "none"
        if x is None
        else "whole band"
        # The end of the band is an exact number of the scene, and so is a bandwidth that reaches
        # it.
        if float(x) == float(chart.points[-1].omega)
        else w.cell(x)
    )


def _spread(found: Sequence[Compared | FamilyCompared], what: str = "bandwidth") -> Phrase:
    """How far apart the bandwidths are; ``what`` : as they are called."""
    widths = [x.bandwidth for x in found if x.bandwidth is not None]
    if not widths:
        return f"With each region: no {what}."
    # The least is rounded down and the largest up: so no bandwidth is outside of what is said.
    least, most = min(widths, key=float), max(widths, key=float)
    if len(widths) < len(found):
        between: Phrase = (
            "from ",
            w.cell(least, Way.DOWN),
            " to ",
            w.cell(most, Way.UP),
            "\xa0",
            FREQUENCY_UNIT,
        )
        return (
            f"The {what} depends on the JND model: none with some regions, ",
            between,
            " with the others.",
        )
    if float(least) == float(most):
        return f"The {what} is the same with all regions: ", w.both(most), "."
    times: Phrase = (", a factor of ", w.near(float(most) / float(least))) if float(least) else ""
    ends_ = w.cell(least, Way.DOWN), w.cell(most, Way.UP)
    return w.phrased(
        f"The {what} is from {{}} to {{}}\xa0{{}} with these regions{{}}.",
        *ends_,
        FREQUENCY_UNIT,
        times,
    )


def _dynamics(e: Evaluation) -> Iterator[tuple[str, Phrase]]:
    """Environment, what effects make of it, and the distortion, in closed form."""
    d, rendered = e.distortion, e.scene.rendered
    unit = f"  {w.stiffness_unit(e.scene)}"
    band = e.scene.band
    yield "environment", w.in_numbers("H_env", d.env, s, band, unit)
    if rendered:
        yield (
            "rendered",
            w.in_numbers("H_rendered", d.env.ring.convert(e.scene.rendering.H), s, band, unit),
        )
    yield "perceived", w.in_numbers("H_perc", d.perc, s, band, unit)
    yield "distortion", w.in_numbers("Re dH", d.difference_response.real.written, omega, band)
    yield "", w.in_numbers("Im dH", d.difference_response.imag.written, omega, band)


# Step 2, how.


def _step_2(e: Evaluation) -> Iterator[Block]:
    """Yield the blocks of step 2: the percepts, and their figures."""
    yield percepts(e)
    for part, name in ((Part.REAL, "real"), (Part.IMAG, "imaginary")):
        yield w.drawing(
            e,
            f"projections-{part.value}",
            f"Magnitude of the {name} part of environment and perceived dynamics: bold where "
            f"the "
            "difference is noticed, with what it is felt as.",
        )
    yield w.drawing(
        e,
        "nyquist",
        "Environment (solid) and perceived dynamics (dashed) in the complex plane; arrows "
        "towards "
        "higher frequencies.",
    )
    yield w.drawing(
        e,
        "jnd-square",
        "Environment and perceived dynamics at one frequency; the grey region holds the "
        "changes that "
        "are not noticed.",
    )


def percepts(e: Evaluation) -> Block:
    """Return the table of what is felt where a ratio exceeds its threshold."""
    region = joint(e.criteria)
    if not e.felt:
        why = (
            f"the distortion never leaves the {region.kind}"
            if region
            else "neither ratio exceeds its threshold"
        )
        return doc.Paragraph(f"Nothing is noticed on the band: {why}.")
    where = f"outside the {region.kind}" if region else "where a ratio exceeds its threshold"
    return w.table(
        e.felt,
        f"What is felt {where}, {how_sure(e)}.",
        w.Field("part", lambda x: x.part.value if x.part else JOINT),
        w.Field(w.IN_UNIT, lambda x: w.ends(x.band)),
        w.Field("felt as", lambda x: x.words),
    )


def _remarks(e: Evaluation) -> Iterator[Phrase]:
    """Yield all further findings, a line each: friction, changeovers, activity, poles, energy."""
    yield from _friction(e)
    if e.changeovers_environment or e.changeovers_perceived:
        env, perc = (
            w.places(x) if x else "none"
            for x in (e.changeovers_environment, e.changeovers_perceived)
        )
        yield "Changeover frequency: ", env, " (environment), ", perc, " (perceived)."
    yield from _any_environment(e)
    if e.outside_model:
        active = w.compared(Prefixed(w.OPERATORS[Part.IMAG], w.H_PERC), "<")
        noticed = (
            ": no property applies to the imaginary part there."
            if e.unnamed
            else ", not noticed there."
        )
        yield "Active (", active, ") ", w.spans(e.outside_model), noticed
    if e.unbounded:
        why = (w.compared(w.H_ENV, "="), ", or ", w.CHANGE, " infinite")
        yield "A ratio is unbounded at ", w.places(e.unbounded), " (", why, ")."
    yield from _energy(e)


def _any_environment(e: Evaluation) -> Iterator[Phrase]:
    """Yield up to which frequency the effects are unnoticed with any environment, and above which
    they are noticed with any."""
    verdict = e.any_environment
    if verdict is None or not e.scene.effects:
        return
    below, above, end = verdict.transparent_below, verdict.opaque_above, e.chart.points[-1].omega
    if below == end:
        yield "For any environment: unnoticed on this band."
        return
    low: Phrase = "noticed with some at the low end of the band"
    if below is not None:
        low = "unnoticed up to ", w.both(below, Way.DOWN)
    yield (
        "For any environment: ",
        low,
        () if above is None else (", noticed above ", w.both(above, Way.UP)),
        ".",
    )


def _friction(e: Evaluation) -> Iterator[Phrase]:
    """Yield whether dry friction of the display is noticed as such, by a threshold of its own."""
    x, newton = e.friction, w.unit(Dimension.FORCE, e.scene.motion)
    if x is None:
        return
    force = w.near(float(x.force))
    source = "(Veldhuis, Mulder and van Paassen, 2024: a Weber fraction and a floor)"
    # The scene has friction in the display, and no threshold for it.
    if x.noticed is None or x.least is None:
        words = (
            f"Friction of {{}} {newton} in the display has a separate threshold {source}, "
            f"which the scene does not give: "
            "{} in {}."
        )
        yield w.phrased(
            words,
            force,
            doc.Code('friction = { weber = ..., floor = "... N" }'),
            doc.Code("[evaluation]"),
        )
        return
    words = (
        f"Friction of {{}} {newton} in the display is {{}} as friction: it differs by "
        f"{'more than' if x.noticed else 'at most'} {{}} {newton} from the {{}} {newton} "
        f"that should be felt {source}."
    )
    verdict: Phrase = Strong("noticed") if x.noticed else "not noticed"
    yield w.phrased(words, force, verdict, w.near(float(x.least)), w.near(float(x.reference or 0)))


def _energy(e: Evaluation) -> Iterator[Phrase]:
    """Yield, for a display that is not passive, the damping of a hand that compensates the energy
    which it generates, or that none does."""
    passivity = e.passivity
    if passivity is None or not passivity.is_active or passivity.holds is not False:
        return
    # No damping of a hand helps against a pole that forbids passivity, nor where -Im H_perc/omega
    # has no bound.
    if passivity.damping is not None and passivity.poles_allow:
        yield w.enough_damping(w.at_most(passivity.damping.value), e.scene)
    elif passivity.is_unbounded:
        yield w.endless()


# What is proven.


def proven(e: Evaluation) -> Iterator[Phrase]:
    """Yield what is proven of an evaluation, and what is undecided."""
    yield from w.left_open(e.left)
    if e.undecided:
        where = listed((w.both(point.omega), f" ({x.name})") for x, point in e.undecided)
        yield w.undecided(
            (
                (
                    "whether a ratio is tangent to its threshold, crosses it twice or stays "
                    "clear of it near "
                ),
                where,
            )
        )
        yield w.proof(e.scene, "everything else")
        return
    if e.movement is not None and e.movement.undecided:
        yield w.undecided("what a fit to this movement reports, where no number stands")
    # Passivity is claimed only where it was decided, either way.
    passive = ", passivity" if e.passivity is not None and e.passivity.holds is not None else ""
    but = (
        ", except computed ones" if e.discrimination or (e.movement and e.movement.computed) else ""
    )
    yield w.proof(e.scene, f"all crossings on the band{passive}, and all digits printed{but}")
    if e.bandwidths is not None and e.bandwidths.undecided:
        yield w.undecided(e.bandwidths.undecided)


# Several environments.


def page_family(many: FamilyEvaluation) -> Document:
    """The page of several environments: one row each, and the worst case."""
    blocks = (
        _each(many),
        *_worst(many),
        *family_regions(many),
        *w.caveats(cautions(many.family.first)),
    )
    further = ("haptisym evaluate SCENE --environment NAME",)
    return w.page_about(
        many.family,
        _answer(many),
        blocks,
        _proven_family(many),
        "Evaluation with several environments",
        None,
        further,
    )


def _answer(many: FamilyEvaluation) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the three lines of the answer for several environments."""
    yield "Bandwidth", _bandwidth_of_all(many)
    words: dict[str, list[str]] = {}
    for name, e in many.answers.items():
        if e.felt:  # the change that is noticed first
            words.setdefault(min(e.felt, key=lambda x: float(x.band.low.omega)).words, []).append(
                name
            )
    felt = listed(f"{first} ({', '.join(names)})" for first, names in words.items())
    yield "Felt as", felt or "nothing noticed with any"
    # False and None are kept apart: unstable is proven, undecided is not.
    unstable = [name for name, e in many.answers.items() if e.stable is False]
    undecided_ = [name for name, e in many.answers.items() if e.stable is None]
    stable: Phrase = "stable with each environment"
    if unstable or undecided_:
        stable = (
            Strong("unstable" if unstable else "undecided"),
            f" with {', '.join(unstable or undecided_)}",
        )
    verdicts: Phrase = (stable, " under prescribed motion; ", _passive(many))
    yield "Stability", (verdicts, w.of_linear_model(many.family))


def _passive(many: FamilyEvaluation) -> str:
    """Return with which environments the display is passive."""
    verdicts = {
        name: None if e.passivity is None else e.passivity.holds for name, e in many.answers.items()
    }
    # None is undecided, and is not True either.
    if all(verdicts.values()):
        return "passive with each"
    kinds = (("not passive", False), ("passivity undecided", None))
    return "; ".join(
        f"{words} with {', '.join(names)}"
        for words, kind in kinds
        if (names := [n for n, x in verdicts.items() if x is kind])
    )


def _bandwidth_of_all(many: FamilyEvaluation) -> Phrase:
    """Return the bandwidth common to all environments, with what limits it."""
    if many.bandwidth is not None:
        by = listed(
            f"{x.environment} ({_part(x.criterion)})"
            for x in many.binding
            if x.omega is many.bandwidth
        )
        width: Phrase = w.both(many.bandwidth)
        # The common bandwidth is the end of the band itself: nothing limits it there.
        if many.bandwidth is many.chart.points[-1].omega:
            return "the whole band with each environment, up to ", width
        return Strong(width), " common to all environments", (", limited by ", by) if by else ""
    onward: Phrase = (
        ("; all are transparent only ", w.spans(many.transparent)) if many.transparent else ""
    )
    first = [name for name, e in many.answers.items() if e.bandwidth is None]
    low: Phrase = (
        (": noticed from the low end of the band with ", ", ".join(first)) if first else ""
    )
    return Strong("none"), " common to all environments", low, onward


def _part(x: Criterion) -> str:
    """Return a criterion in words: a part, or a region."""
    return f"{x.name} part" if x.part else x.name


def _each(many: FamilyEvaluation) -> Block:
    """A row for each environment: the lowest frequencies beyond which ratios exceed their
    thresholds, and as what."""

    def first(name: str, x: Criterion) -> Phrase:
        # The first interval on which the ratio of this environment is above its threshold, by
        # proven signs.
        exceeded = many.answers[name].chart.where(lambda signs: signs[x] > 0)
        return w.cell(exceeded[0].low.omega) if exceeded else "never"

    def bandwidth(name: str) -> Phrase:
        e = many.answers[name]
        return (
            "none"
            if e.bandwidth is None
            else "whole band"
            if e.bandwidth is e.chart.points[-1].omega
            else w.cell(e.bandwidth)
        )

    shown = w.table(
        many.answers,
        (
            "Each environment: where each part is first noticed, and as what, ",
            FREQUENCY_UNIT,
            ", proven.",
        ),
        w.Field("environment", str),
        *(
            w.number((named(x.symbol), " > c from"), partial(first, x=x))
            for x in noticed(many.family.threshold)
        ),
        w.number("bandwidth", bandwidth),
        w.Field("felt as", lambda name: _felt(many.answers[name])),
    )
    low, high = (w.cell(many.chart.points[i].omega) for i in (0, -1))
    words = "First crossings on {} to {}\xa0{}, in {}, JND {}"
    return doc.Section(
        w.phrased(
            words, low, high, FREQUENCY_UNIT, FREQUENCY_UNIT, w.limits(many.family.threshold)
        ),
        (shown,),
    )


def _felt(e: Evaluation) -> str:
    """How each part is felt where it is first noticed."""
    # From the last band to the first, so that the first one of each part stays.
    first = {x.part: x.words for x in reversed(e.felt)}
    return "; ".join(first[part] for part in Part if part in first) or "-"


def _worst(many: FamilyEvaluation) -> Iterator[Block]:
    """Yield what limits the bands on which all environments are transparent, where that is more
    than the bandwidth."""
    further = [x for x in many.binding if x.omega is not many.bandwidth]
    if len(many.transparent) > 1:
        yield doc.Notes((("All environments are transparent ", w.spans(many.transparent), "."),))
    if further:
        shown = w.table(
            further,
            "What limits the other transparent intervals.",
            w.hertz(lambda x: w.cell(x.omega)),
            w.Field("environment", lambda x: x.environment),
            w.Field("part", lambda x: x.criterion.name),
        )
        yield doc.Section("Further limits", (shown,))
    words = (
        "The largest ratio of all environments, with the thresholds; grey: the band on which all "
        "are transparent."
    )
    yield doc.Figure("worst-case", words, many.figure)


def _proven_family(many: FamilyEvaluation) -> Iterator[Phrase]:
    """Yield what is proven of several environments together."""
    if not many.certified:
        yield w.undecided(
            "a crossing of some environment, at the precision limit: evaluate each alone"
        )
    else:
        yield w.proof(
            many.family, "all crossings of every environment, their order, and all digits printed"
        )


# Peaks.


def page_peaks(found: Peaks) -> Document:
    """The page of the peaks of the ratios: where each is largest inside the band, and how large."""
    if found:
        shown = w.table(
            found,
            "All local maxima of the ratios inside the band.",
            w.Field(
                "ratio",
                lambda x: (
                    w.symbol(x.criterion.symbol),
                    " over its limit" if x.in_limits and x.part else "",
                ),
            ),
            w.hertz(lambda x: w.cell(x.omega)),
            w.number("value", lambda x: w.near(x.ratio)),
        )
        block: Block = doc.Section(
            "Where a ratio is larger than on either side", (shown, *w.noted(_remarks_peaks(found)))
        )
    else:
        block = doc.Paragraph("No ratio has a local maximum inside the band.")
    return w.page_about(
        found.scene,
        tuple(_answer_peaks(found)),
        (block,),
        _proven_peaks(found),
        "Peaks of the ratios",
        found.asides(),
    )


def _answer_peaks(found: Peaks) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the largest maximum of each ratio, and its frequency."""
    for criterion in dict.fromkeys(x.criterion for x in found):
        maxima = [x for x in found if x.criterion == criterion]
        largest = max(maxima, key=lambda x: float(x.ratio))
        value: Phrase = (w.near(largest.ratio), " at ", w.both(largest.omega))
        yield ("Largest ", w.symbol(criterion.symbol)), value


def _remarks_peaks(found: Peaks) -> Iterator[Phrase]:
    """Yield what the values of peaks mean where that is not plain."""
    region = joint(x.criterion for x in found)
    if region:
        yield (
            "The value is how many times the ",
            region.kind,
            " must be enlarged to hold the distortion.",
        )
    for x in found:
        if x.jump:
            words = (
                "At {} the limit changes: the ratio comes arbitrarily near to the value, and drops."
            )
            yield w.phrased(words, w.both(x.omega))


def _proven_peaks(found: Peaks) -> Iterator[Phrase]:
    """Yield what is proven of the peaks."""
    if found.undecided:
        where = listed(map(w.both, found.undecided))
        yield w.undecided(
            ("whether a slope changes its sign at ", where, ", at the precision limit")
        )
        yield w.proof(found.scene, "all others")
    else:
        yield w.proof(found.scene, "all local maxima inside the band, and all digits printed")
