"""The words of all pages: frequencies, bands, thresholds and the names of the ratios, as phrases."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from decimal import ROUND_CEILING, Context
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING

from sympy import Expr

from haptisym.judge.crossings import Criterion
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel import reals
from haptisym.kernel.reals import Hertz, RealNumber
from haptisym.kernel.rings import omega
from haptisym.kernel.roots import Interval, Point
from haptisym.model.jnd import DIGITS, Part, Shape, Threshold
from haptisym.model.quantities import Dimension, MotionKind, unit_text
from haptisym.model.scene import Scene
from haptisym.model.scenefile import SceneFamily
from haptisym.writing.boxes import Absolute, Box, Equation, Numeral, Operator, Prefixed, Sum, Titled
from haptisym.writing.document import Block, Code, Document, Notes, Number, Phrase, Strong, coded, listed
from haptisym.writing.layout import layout, named

if TYPE_CHECKING:
    from haptisym.model.measuredscene import MeasuredScene
    from haptisym.verbs.effects.differences import Supremum

RATIOS: dict[Part, Box] = {Part.REAL: named("r_r"), Part.IMAG: named("r_i")}
PART_NAMES = {Part.REAL: "real", Part.IMAG: "imaginary"}
OPERATORS = {Part.REAL: Operator("Re"), Part.IMAG: Operator("Im")}
OMEGA, H_ENV, H_PERC = named("omega"), named("H_env"), named("H_perc")
CHANGE = Titled("dH", Prefixed(named("Delta"), named("H")))
NOT_HELD = "Whether the display is stable in a hand was not looked at."
"""Said beside every word about imposed motion, which is easily taken for more."""


def page_about(
    scene: Scene | SceneFamily | MeasuredScene,
    blocks: Iterable[Block],
    kind: str = "",
    asides: Iterable[str] | None = None,
) -> Document:
    """A page about a scene: its title and where it comes from, what it says, and what a report calls itself."""
    return Document(title(scene), lead(scene, asides), tuple(blocks), kind)


def title(scene: Scene | SceneFamily | MeasuredScene) -> str:
    """The title of a page about a scene."""
    return scene.title or "Untitled scene"


def lead(scene: Scene | SceneFamily | MeasuredScene, asides: Iterable[str] | None = None) -> tuple[Phrase, ...]:
    """Where a scene comes from, and what holds of it besides: by default its own asides."""
    return tuple(x for x in (scene.source, *map(coded, scene.asides() if asides is None else asides)) if x)


def region_of_fit(scene: Scene | SceneFamily) -> str:
    """What the ranges of a scene are that was fitted; empty for one that was not."""
    return "" if scene.level is None else f"the {float(100 * scene.level):g} % region of the fit"


def certainty(scene: Scene | SceneFamily, words: Phrase) -> Phrase:
    """What is proven of a display; of a fitted one nothing is."""
    region = region_of_fit(scene)
    told = "Exact for the fitted model, not sampled; of the device it is an estimate. For all values in ", region, ": "
    return (*told, Code("haptisym tolerances"), ".") if region else words


def short(x: RealNumber) -> Number:
    """A number with the digits that a sentence takes."""
    return Number(reals.short(x), float(x))


def unlike(values: Sequence[RealNumber], digits: int = 5) -> list[Number]:
    """Numbers in order as a sentence takes them, those that would look like the one before or behind with digits that differ."""
    need = [digits] * len(values)
    for i, (low, high) in enumerate(pairwise(values)):
        if reals.short(low, digits) == reals.short(high, digits):
            count = next((n for n in _MORE_DIGITS if reals.short(low, n) != reals.short(high, n)), digits)
            need[i], need[i + 1] = max(need[i], count), max(need[i + 1], count)
    return [Number(reals.short(x, n), float(x)) for x, n in zip(values, need, strict=True)]


_MORE_DIGITS = range(6, 51)


def rounded(x: float, digits: int = 5) -> Number:
    """A float with a few digits."""
    return Number(f"{x:.{digits}g}", x)


def exactly(x: RealNumber, digits: int) -> Number:
    """A number with so many digits."""
    return Number(x.digits(digits), float(x))


def hertz(x: RealNumber) -> str:
    """A frequency given in rad/s, in Hz."""
    return reals.short(Hertz(x))


def both(x: RealNumber) -> Phrase:
    """A frequency in rad/s and Hz."""
    return short(x), f" rad/s ({hertz(x)} Hz)"


def span(x: Interval) -> Phrase:
    """``from 2 to 3 rad/s``, ``at 2 rad/s (0.31831 Hz) alone``."""
    if x.low is x.high:
        return "at ", both(x.low.omega), " alone"
    return "from ", ends(x), " rad/s"


def ends(x: Interval) -> Phrase:
    """``2 to 3``."""
    if x.low is x.high:
        return short(x.low.omega)
    low, high = unlike((x.low.omega, x.high.omega))
    return low, " to ", high


def spans(bands: Iterable[Interval]) -> Phrase:
    """Several intervals of frequencies, in words."""
    return listed(map(span, bands))


def places(points: Iterable[Point]) -> Phrase:
    """``2, 3 and 4 rad/s``."""
    return listed(unlike([p.omega for p in points])), " rad/s"


_SYMBOLS = {"|G - 1|": Absolute(Sum(((1, named("G")), (-1, Numeral("1")))))}


def symbol(text: str) -> Phrase:
    """What a criterion judges, or its threshold, by its symbol."""
    return named(text) if text.isidentifier() else _SYMBOLS.get(text, text)


def rule(x: Criterion) -> Phrase:
    """``r_r ≤ c_real``."""
    left, relation, right = x.rule.partition(" <= ")
    return (symbol(left), " ≤ ", symbol(right)) if relation else x.rule.replace(">=", "≥")


def percent(c: Expr) -> str:
    """A share in per cent."""
    return f"{float(100 * c):.6g}\xa0%"


def limits(c: Threshold) -> Phrase:
    """The threshold of both parts, or of each where they differ; the region, where it is none of that."""
    if c.conversion:
        f, (p, q) = c.conversion, (percent(x) for x in (c.conversion.start, c.conversion.end))
        factor = short(f.exact)
        own = limits(replace(c, conversion=None))
        said = f", brought from {p} to {q} right answers by a cumulative Gaussian: times "
        return own, said, factor, f" (rounded to {DIGITS} digits, all proven)"
    if not c.is_plain:
        return region(c)
    said = percent(c.real) if c.real == c.imag else f"{percent(c.real)} (real) and {percent(c.imag)} (imaginary)"
    return said, " of ", Absolute(H_ENV)


def amount(c: Expr) -> Phrase:
    """``10 %``, or a formula in omega."""
    return layout(c) if c.has(omega) else percent(c)


def region(c: Threshold) -> Phrase:
    """A region in words: ``an ellipse, 10 % (real) and 12 % (imaginary) of |H_env|, tilt 0.5``."""
    of, own = (" of ", Absolute(H_ENV)), c.region
    if own.shape is Shape.POLYGON:
        corners = listed(("(", amount(x), ", ", amount(y), ")") for x, y in own.corners)
        return "a polygon with the corners ", corners, *of
    widths: Phrase = (_width(c, Part.REAL), " (real) and ", _width(c, Part.IMAG), " (imaginary)")
    if c.real == c.imag and own.lower == (None, None):
        widths = amount(c.real)
    kind = () if own.shape is Shape.SQUARE else f"{c.kind}, "
    tilt = (", tilt ", layout(own.tilt)) if own.tilt else ()
    floor: Phrase = ()
    if own.floor is not None:
        floor = ", and at least ", layout(own.floor), f" {unit(Dimension.STIFFNESS, own.motion)}"
    return kind, widths, *of, *tilt, floor


def _width(c: Threshold, part: Part) -> Phrase:
    lower = c.lower(part)
    return amount(c[part]) if lower is None else (amount(c[part]), " higher or ", amount(lower), " lower")


def bounds(found: Mapping[Part, Supremum]) -> Phrase:
    """``r_r by at most 0.01 and r_i by at most 0.02``."""
    return listed((RATIOS[part], f" by at most {rounded_up(found[part].most)}") for part in Part)


def rounded_up(value: float) -> str:
    """Three digits, rounded up, so that a bound stays one."""
    if value == inf:
        return "unbounded"
    return f"{Context(prec=3, rounding=ROUND_CEILING).create_decimal_from_float(value):.3g}"


def compared(left: Box, relation: str) -> Box:
    """``left < 0``, with any relation."""
    return Equation((left, Numeral("0")), (relation,))


def unit(of: Dimension, motion: MotionKind | None) -> str:
    """A unit as it is printed: that of a translation where nothing tells the motion."""
    return unit_text(of.unit(motion or MotionKind.TRANSLATION))


def stiffness_unit(scene: Scene) -> str:
    """The unit of all dynamics of a scene."""
    return unit(Dimension.STIFFNESS, scene.motion)


def noted(remarks: Iterable[Phrase]) -> tuple[Notes, ...]:
    """Remarks as a block; nothing where there is none."""
    entries = tuple(remarks)
    return (Notes(entries),) if entries else ()


def caveats(found: Iterable[str]) -> tuple[Notes, ...]:
    """What the answers do not say, a remark each."""
    return noted((Strong("But:"), f" {caveat}") for caveat in found)


def is_transparent_throughout(e: Evaluation) -> bool:
    """Whether neither ratio exceeds its threshold anywhere on the band."""
    found = [(x.low, x.high) for x in e.transparent]
    return found == [(e.chart.points[0], e.chart.points[-1])]
