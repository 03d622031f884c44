"""An evaluation's results on a page: findings, tables and the sentences that go with them, each with its certainty."""

from __future__ import annotations

from collections.abc import Iterable

from sympy import Expr

from haptisym.judge.criteria import Criterion
from haptisym.judge.crossings import Crossing, CrossingKind
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.peaks import Peak
from haptisym.judge.percepts import Percept, felt
from haptisym.kernel.hertz import Hertz
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Interval, Point
from haptisym.model.jnd import Part, is_irrational_algebraic
from haptisym.pages.tex.results import short
from haptisym.pages.words import NOT_HELD
from haptisym.writing.boxes import Equation, Numeral, Operator, Prefixed
from haptisym.writing.htmltext import Html, element, joined, listed, table
from haptisym.writing.layout import layout
from haptisym.writing.mathematics import inline
from haptisym.writing.names import named
from haptisym.writing.numerals import rounded

RATIOS = {part: inline(named(name)) for part, name in ((Part.REAL, "r_r"), (Part.IMAG, "r_i"))}
PART_NAMES = {Part.REAL: "real", Part.IMAG: "imaginary"}
OMEGA = inline(named("omega"))
H_ENV, H_PERC = inline(named("H_env")), inline(named("H_perc"))


def number(x: RealNumber, shown: str) -> Html:
    """A number as it is shown, with the nearest double beside it for programs that read the page."""
    return element("data", shown, given={"value": repr(float(x))})


def frequency(x: RealNumber) -> Html:
    """A frequency to five digits, without its unit."""
    return number(x, short(x))


def both(x: RealNumber) -> Html:
    """A frequency in rad/s and Hz."""
    return joined([frequency(x), f" rad/s ({short(Hertz(x))} Hz)"])


def span(x: Interval) -> Html:
    """The ends of an interval, or its only point, without unit."""
    low, high = frequency(x.low.omega), frequency(x.high.omega)
    return low if x.low is x.high else joined([low, high], " to ")


def places(points: Iterable[Point]) -> Html:
    return joined([listed(frequency(p.omega) for p in points), " rad/s"])


def equality(name: str, value: Expr) -> Html:
    """``c = 0.1``, or with ≈ where the number is not rational and was rounded."""
    is_rounded = is_irrational_algebraic(value)
    box = layout(value.evalf(6) if is_rounded else value if value.is_Rational else rounded(value))
    return inline(Equation((named(name), box), ("=" if value.is_Rational else "≈",)))


# Step 1, when.


def crossing_table(e: Evaluation) -> Html:
    """Every crossing on the band: digits, enclosure, what happens."""
    if not e.crossings:
        return element("p", f"No ratio meets its threshold on the band ({_certainty(e)}).")
    head = [
        "part", joined([OMEGA, " (rad/s)"]), "Hz", "what happens", "distortion", joined(["enclosure of ", OMEGA]),
    ]  # fmt: skip
    caption = f"All crossings of the thresholds on the band, {_certainty(e)}."
    return table(head, [_crossing(e, c) for c in e.crossings], caption, numbers=(1, 2, 5))


_VERBS = {CrossingKind.EXCEEDS: "rises above", CrossingKind.RETURNS: "falls below", CrossingKind.TOUCHES: "touches"}


def _crossing(e: Evaluation, c: Crossing) -> list[str]:
    low, high = c.omega.enclosure(e.digits)
    ends = [_wrapped(f"[{low}, "), element("br"), _wrapped(f"{high}]")]
    enclosure = element("span", *ends, given={"class": "enclosure"})
    hertz = Hertz(c.omega).digits(min(e.digits, 6))
    return [
        c.criterion.words.removesuffix(" part"),
        number(c.omega, _wrapped(c.omega.digits(e.digits))),
        hertz,
        event(c),
        sense(c),
        enclosure,
    ]


_LONG = 25  # characters of a number; a longer one is set on several lines


def _wrapped(digits: str) -> str:
    return element("span", digits, given={"class": "long"}) if len(digits) > _LONG else digits


def event(c: Crossing) -> Html:
    """``r_r rises above 0.1``."""
    times = f" ({c.multiplicity}-fold)" if c.multiplicity > 1 else ""
    return joined([ratio(c.criterion), f" {_VERBS[c.kind]} ", limit(c.criterion.threshold), times])


def limit(c: Expr) -> str:
    """A threshold as a percentage."""
    return f"{float(100 * c):.6g}\xa0%"


def ratio(x: Criterion) -> Html:
    """What a criterion judges, as a formula."""
    return inline(named(x.symbol))


def sense(c: Crossing) -> Html:
    """The sign of the component of dH that is judged; nothing where both are."""
    if not c.sign:
        return Html()
    part = Prefixed(Operator(c.criterion.component), Prefixed(named("Delta"), named("H")))
    return inline(Equation((part, Numeral("0")), (">" if c.sign > 0 else "<",)))


def transparency(e: Evaluation) -> Html:
    """Where neither ratio exceeds its threshold."""
    if not e.transparent:
        return joined(["At every frequency of the band a ratio exceeds its threshold: it is transparent nowhere."])
    pieces = joined([listed(map(span, e.transparent)), " rad/s"])
    found = joined(["The display is perceptually transparent at ", pieces])
    if is_transparent_throughout(e):
        return joined([found, ": on the whole band."])
    if e.bandwidth is None:
        return joined([found, ", and not at the low end of the band: there is no transparent bandwidth."])
    return joined([found, "; the bandwidth of transparency is ", both(e.bandwidth), "."])


def is_transparent_throughout(e: Evaluation) -> bool:
    """Whether neither ratio exceeds its threshold anywhere on the band."""
    ends = e.chart.points[0], e.chart.points[-1]
    return len(e.transparent) == 1 and (e.transparent[0].low, e.transparent[0].high) == ends


def crossing_sentence(c: Crossing) -> Html:
    """``r_r rises above its threshold at 7.97891679017471 rad/s``."""
    where = number(c.omega, c.omega.digits())
    return joined([ratio(c.criterion), f" {_VERBS[c.kind]} its threshold at ", where, " rad/s (", sense(c), ")"])


def peak_sentence(x: Peak) -> Html:
    """``r_r has a local maximum of 0.2 at 3 rad/s``."""
    height = number(x.ratio, short(x.ratio))
    return joined([ratio(x.criterion), " has a local maximum of ", height, " at ", frequency(x.omega), " rad/s"])


# Step 2, how.


def percept_table(e: Evaluation) -> Html:
    """What is felt where a ratio exceeds its threshold."""
    if not e.felt:
        nothing = f"Nothing is noticed on the band: neither ratio exceeds its threshold ({_certainty(e)})."
        return element("p", nothing)
    head = ["part", joined([OMEGA, " (rad/s)"]), "felt as"]
    rows = [[PART_NAMES[x.part], span(x.band), x.words] for x in e.felt]
    return table(head, rows, f"What is felt where a ratio exceeds its threshold, {_certainty(e)}.", numbers=(1,))


def percept_sentence(p: Percept) -> Html:
    """``lower mass (real part), from 7.9789 to 15 rad/s``."""
    return joined([f"{felt(p)} ({PART_NAMES[p.part]} part), from ", span(p.band), " rad/s"])


def changeovers(e: Evaluation) -> Html:
    """Where Re H changes its sign, of the environment and of what is felt."""
    env, perc = (
        joined(["at ", places(x)]) if x else "nowhere on the band"
        for x in (e.changeovers_environment, e.changeovers_perceived)
    )
    return joined(["Spring and inertia change over ", env, " in the environment, and ", perc, " in what is felt."])


def reservations(e: Evaluation) -> list[Html]:
    """Where the model says nothing: an active display, an unbounded ratio."""
    found = []
    if e.outside_model:
        where, active = listed(map(span, e.outside_model)), joined(["Im\xa0", H_PERC, " < 0"])
        noticed = "so that no property is named for what is noticed there" if e.unnamed else "but not noticed there"
        told = [" rad/s, ", noticed, ": the display is active (", active, ")."]
        found.append(joined(["The imaginary part is outside the paper's model at ", where, *told]))
    if e.unbounded:
        why = joined([H_ENV, " = 0, or the distortion is infinite"])
        found.append(
            joined(["A ratio is unbounded at ", places(e.unbounded), ": nothing to compare with (", why, ")."])
        )
    return found


# Certainty.


def _certainty(e: Evaluation) -> str:
    if e.certified:
        return "proven: none missed, none invented"
    return "proven, but for what is listed as undecided"


def stability(e: Evaluation) -> Html:
    """Whether the force under imposed motion is stable, which says nothing about a display in a hand."""
    if e.stable is None:
        open_ = element("strong", "not decided")
        return joined(["Whether the force under imposed motion is stable was ", open_, f". {NOT_HELD}"])
    if e.stable:
        poles = joined([": all poles of ", H_PERC, " lie in the open left half plane. "])
        return joined(["The force under imposed motion is stable", poles, NOT_HELD])
    not_stable = element("strong", "not stable")
    return joined(["The force under imposed motion is ", not_stable, ": a pole of ", H_PERC, " has Re\xa0s ≥ 0."])


def undecided_table(e: Evaluation) -> Html:
    """What stayed open at the precision limit; nothing where everything is decided."""
    if not e.undecided:
        return Html()
    rows = [
        [x.words.removesuffix(" part"), joined(["[", low, ", ", high, "]"])]
        for x, (low, high) in ((x, point.omega.enclosure(e.digits)) for x, point in e.undecided)
    ]
    caption = "Undecided at the precision limit: whether the ratio touches its threshold here, crosses it twice or stays clear."
    return table(["part", joined(["near ", OMEGA, " (rad/s)"])], rows, caption, numbers=(1,))


def certainty(e: Evaluation) -> Html:
    """What is proven and what is assumed."""
    rest = "" if e.certified else " but for what is listed as undecided"
    proven = (
        f"Proven{rest}: the tables list all crossings and all percepts on the band; every digit, sign and interval follows "
        "from exact polynomials and ball arithmetic, and nothing was sampled. "
    )
    assumed = (
        "Assumed: that the dynamics are linear, and the threshold of human perception (Fu, van Paassen and Mulder, 2019, "
        "eq. 4)."
    )
    return joined([proven, assumed, *(joined([" ", element("strong", "But: "), caveat]) for caveat in e.caveats)])
