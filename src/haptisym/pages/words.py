"""The words of all pages: frequencies, bands, thresholds and the names of the ratios, as
phrases.

A phrase is a text, a box, a number, or a tuple of these; the kind of output decides how each is
set. Numbers keep their rounding with them: to the nearest for places, down for lower bounds, up for
upper ones, into a set for its ends. Begin with ``page_about``, of which most pages are made.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, TypeAlias

from sympy import Add, Expr, Symbol

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel import reals
from haptisym.kernel.reals import Printable, RealNumber, Way, in_unit
from haptisym.kernel.rings import RationalFunction, omega
from haptisym.kernel.roots import Interval, Point
from haptisym.kernel.sets import Piece, ValueSet
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.quantities import Dimension, MotionKind, Unit, unit_text
from haptisym.model.scene import Knob, Scene, first_harmonics
from haptisym.model.scenefile import SceneFamily
from haptisym.writing import document as doc
from haptisym.writing.boxes import (
    Absolute,
    Box,
    Numeral,
    Operator,
    Prefixed,
    Relation,
    Sum,
    Titled,
    text,
)
from haptisym.writing.document import (
    FREQUENCY,
    FREQUENCY_UNIT,
    Block,
    Document,
    Phrase,
    Strong,
    listed,
)
from haptisym.writing.layout import approximate, equation, layout, named, quantity
from haptisym.writing.mathml import readable
from haptisym.writing.rounding import DIGITS, Band, faithful

if TYPE_CHECKING:
    from haptisym.model.measuredscene import MeasuredScene
    from haptisym.verbs.effects.differences import Supremum

RATIOS: dict[Part, Box] = {Part.REAL: named("r_r"), Part.IMAG: named("r_i")}
PART_NAMES = {Part.REAL: "real", Part.IMAG: "imaginary"}
OPERATORS = {Part.REAL: Operator("Re"), Part.IMAG: Operator("Im")}
OMEGA, H_ENV, H_PERC = named("omega"), named("H_env"), named("H_perc")
SYSTEMS = {"environment": H_ENV, "perceived": H_PERC}
CHANGE = Titled("dH", Prefixed(named("Delta"), named("H")))


def page_about(
    scene: Scene | SceneFamily | MeasuredScene,
    answer: Iterable[tuple[Phrase, Phrase]],
    blocks: Iterable[Block],
    proof: Iterable[Phrase],
    kind: str = "",
    asides: Iterable[str] | None = None,
    further: Sequence[str] = (),
) -> Document:
    """A page about a scene: the answer in a few lines, what there is besides, how sure it is, then
    model and source.

    ``kind`` : what a report calls itself. ``asides`` : remarks about the scene, by default its own.
    ``further`` : commands that lead on; one of the options that print formulas is left out where
    they are printed.
    """
    lines = tuple(answer)
    notes = [doc.coded(x) for x in (scene.asides() if asides is None else asides)]
    about: list[Phrase] = [("Model: ", x) for x in model_words(scene)]
    about += [f"Source: {scene.source}"] if scene.source else []
    content: list[Block] = [doc.Facts(lines, "findings")] if lines else []
    content += [*blocks, doc.Notes((*proof, *notes))]

    def last(commands: Iterable[str]) -> list[Block]:
        # Each command with a semicolon before it; the first semicolon is cut off.
        steps = tuple(y for x in commands for y in ("; ", doc.Code(x)))[1:]
        return [doc.Notes((*about, ("Next: ", *steps)) if steps else tuple(about))]

    # Two versions of the last line: where formulas are printed already, the option that prints them
    # is no next step.
    used = doc.Formulas(lambda: last(x for x in further if not x.startswith("--")), last(further))
    blocks = (*content, doc.Versions((used,), lambda: last(())))
    return Document(scene.title or "Untitled scene", (), blocks, kind, scene.frequency)


_MOST_LETTERS = 280  # of a formula: three lines


def in_numbers(
    name: str, function: RationalFunction, variable: Symbol, band: Band, unit: str = ""
) -> Phrase:
    """A closed form, rounded where it stays true; of one that is too long to be read, how long it
    is."""
    shown = readable(function, variable, band)
    written = equation(name, shown[0], relation=shown[1]) if shown else None
    if written and len(text(written)) <= _MOST_LETTERS:
        return written, unit
    reduced = function.reduced()
    # The closed form is too long, or no rounding of its numbers is true on the band: its length is
    # said instead.
    above, below = (
        _terms(reduced.ring.coefficients(p)) for p in (reduced.numerator, reduced.denominator)
    )
    see = doc.Brief((": see ", doc.Code("haptisym derive")))
    return quantity(name), f" has {above} terms over {below}", see


def _terms(coefficients: Iterable[Expr]) -> int:
    """Return the number of terms of a polynomial whose coefficients are sums, multiplied out."""
    return sum(len(Add.make_args(c.expand())) for c in coefficients if c != 0)


# Sentences and tables.


def phrased(words: str, *given: Phrase) -> Phrase:
    """Words with what is given in place of each ``{}``.

    >>> phrased("from {} to {}.", "2", H_ENV)[0]
    'from '
    """
    first, *others = words.split("{}")
    # strict: a placeholder without a phrase, or the reverse, is an error of the page, not of the
    # scene.
    return (first, *(x for pair in zip(given, others, strict=True) for x in pair))


Cell: TypeAlias = Callable[[Any], Phrase]


@dataclass(frozen=True)
class Field:
    """A column of a table of things: its heading, and the cell of each thing."""

    heading: Phrase
    cell: Cell
    number: bool = False
    full: bool = False
    hertz: bool = False


def number(heading: Phrase, cell: Cell) -> Field:
    """Return a column of numbers, which is set to the right."""
    return Field(heading, cell, number=True)


def hertz(cell: Cell, heading: Phrase = FREQUENCY) -> Field:
    """A column of frequencies, and of the same in Hz where the page is in rad/s."""
    return Field(heading, cell, number=True, hertz=True)


def table(things: Iterable[Any], caption: Phrase, *fields: Field) -> doc.Table:
    """A row for each thing; ``caption`` : what a report calls it."""
    rows = tuple(tuple(x.cell(one) for x in fields) for one in things)
    return doc.Table(
        tuple(doc.Column(x.heading, x.number, x.full, x.hertz) for x in fields), rows, caption
    )


IN_UNIT: Phrase = (FREQUENCY, " (", FREQUENCY_UNIT, ")")
"""The heading of a column of intervals of frequencies."""


_LONGEST = 110  # characters of an environment's formula in the line of the model


def model_words(scene: Scene | SceneFamily | MeasuredScene) -> Iterator[Phrase]:
    """Environment and effects in a line: ``H_env = 1.8 s^2 + 15 s + 100 N/m; filter
    (second-order-lowpass)``."""
    if isinstance(scene, SceneFamily):
        yield f"{len(scene)} environments; ", _effects(scene.first)
    elif isinstance(scene, Scene):
        environment = scene.environment
        H = environment.H
        # First the digits of a page, then more, until the rounded H_env is true on the band.
        shown_ = faithful(
            lambda n: approximate(H, n) if n else H, scene.band, (doc.DIGITS, *DIGITS)
        )
        form = equation("H_env", shown_[0], relation=shown_[1]) if shown_ else None
        rendered = f"; rendered: {scene.rendered.model}" if scene.rendered else ""
        is_read = form is not None and len(text(form)) <= _LONGEST
        shown: Phrase = (
            (form, f"\xa0{stiffness_unit(scene)}") if form and is_read else environment.model
        )
        yield shown, f"{rendered}; ", _effects(scene)


def _effects(scene: Scene) -> str:
    """Return the effects of a scene in a line, each with its model."""
    named_ = (x.name if x.name == x.model else f"{x.name} ({x.model})" for x in scene.effects)
    return ", ".join(named_) or "no effects"


def proof(scene: Scene | SceneFamily, what: Phrase) -> Phrase:
    """Return what is proven, as the last line of a page; for a fitted scene of the fitted model
    alone."""
    # The weakest premise decides: what is proven for a fitted model is no more certain than the
    # fit.
    fitted = "" if scene.level is None else " for the fitted model"
    return f"Proven{fitted}: ", what, "."


def undecided(what: Phrase) -> Phrase:
    """Return a line for what was examined and not settled."""
    return Strong("Undecided"), ": ", what, "."


def left_open(left: Mapping[str, str]) -> Iterator[Phrase]:
    """Parts of an answer that were not found in time."""
    return (undecided((name, ": ", why)) for name, why in left.items())


def near(x: Printable, *, unit: Unit | None = None, most: int = 1000) -> doc.Real:
    """A number to the nearest: of a place, a value, an estimate with so many digits at most."""
    return doc.Real(x, Way.NEAREST, unit=unit or Unit(""), most=most)


def at_least(x: Printable) -> doc.Real:
    """A lower bound: rounded down."""
    return doc.Real(x, Way.DOWN)


def at_most(x: Printable) -> doc.Real:
    """An upper bound: rounded up."""
    return doc.Real(x, Way.UP)


def cell(x: Printable, way: Way = Way.NEAREST) -> doc.Frequency:
    """A frequency in a table whose heading has the unit."""
    return doc.Frequency(x, way, alone=True)


def both(x: Printable, way: Way = Way.NEAREST) -> doc.Frequency:
    """A frequency with its unit; of rad/s in Hz, too."""
    return doc.Frequency(x, way)


def apart(values: Sequence[RealNumber]) -> list[doc.Frequency]:
    """Frequencies in order, without their unit: those that would look the same with more digits."""
    need = [1] * len(values)
    # Digits are added to both neighbours until they print differently; values that are equal in 50
    # digits stay as they are.
    for i, (low, high) in enumerate(pairwise(values)):
        enough = (n for n in _DIGITS if reals.short(low, n) != reals.short(high, n))
        count = next(enough, 1)
        need[i] = max(need[i], count)
        need[i + 1] = max(need[i + 1], count)
    return [doc.Frequency(x, Way.NEAREST, n, alone=True) for x, n in zip(values, need, strict=True)]


_DIGITS = range(1, 51)


def span(x: Interval) -> Phrase:
    """``from 2 to 3 rad/s``, ``at 2 rad/s (0.3183 Hz) alone``."""
    if x.low is x.high:
        return "at ", both(x.low.omega), " alone"
    return "from ", ends(x), "\xa0", FREQUENCY_UNIT


def ends(x: Interval) -> Phrase:
    """``2 to 3``."""
    if x.low is x.high:
        return cell(x.low.omega)
    low, high = apart((x.low.omega, x.high.omega))
    return low, " to ", high


def spans(bands: Iterable[Interval]) -> Phrase:
    """Several intervals of frequencies, in words."""
    return listed(map(span, bands))


def places(points: Iterable[Point]) -> Phrase:
    """``2, 3 and 4 rad/s``."""
    return listed(apart([p.omega for p in points])), "\xa0", FREQUENCY_UNIT


def value_of(knob: Knob, x: Printable, way: Way) -> doc.Real:
    """A value of a parameter in the unit that the scene wrote."""
    return doc.Real(x, way, unit=knob.shown_unit(knob.motion))


def reach_of(knob: Knob, x: Printable, way: Way) -> doc.Real:
    """The end of a search in the unit that the scene wrote; of a time in s, if it is 1 s or
    more."""
    shown = knob.shown_unit(knob.motion)
    long = knob.dimension is Dimension.TIME and shown.size < 1 <= float(x)
    return doc.Real(x, way, unit=Unit("s") if long else shown)


def bare(x: doc.Real) -> doc.Real:
    """A number without the name of its unit, which follows or stands in the heading."""
    return replace(x, value=in_unit(x.value, x.unit.size), unit=Unit(""))


def values_of(found: ValueSet, knob: Knob, name: Phrase = "", *, in_table: bool = False) -> Phrase:
    """The values that hold, as in a sentence: ``omega_n ≥ 122.4 rad/s``; ``no value`` for none.
    Ends are rounded inward.

    ``in_table`` : without the unit, which stands in the heading.
    """
    name = name or named(knob.symbol.name)
    return (
        listed((values_in(x, found, knob, name, in_table=in_table) for x in found.feasible), "or")
        or "no value"
    )


def values_in(
    x: Piece, found: ValueSet, knob: Knob, name: Phrase, *, in_table: bool = False
) -> Phrase:
    """Return one interval of the values that hold, as in a sentence. A single value is ``alone``
    where those beside it are known not to hold."""
    shown = bare if in_table else lambda x: x
    if x.low is None and x.high is None:
        return "every value of ", name
    if x.low is not None and x.is_single:
        alone = " alone" if found.is_alone(x) else ""
        return name, " = ", shown(value_of(knob, x.low, Way.NEAREST)), alone
    # Ends are rounded into the set: what is printed is never a value that does not hold.
    least = None if x.low is None else value_of(knob, x.low, Way.UP)
    most = "" if x.high is None else shown(value_of(knob, x.high, Way.DOWN))
    signs = [" ≤ " if closed else " < " for closed in x.closed]
    if least is not None and x.high is None:
        return name, " ≥ " if x.closed[0] else " > ", shown(least)
    # Between two ends the unit is printed once, behind the upper one.
    return (bare(least), signs[0]) if least is not None else (), name, signs[1], most


_SYMBOLS = {"|G - 1|": Absolute(Sum(((1, named("G")), (-1, Numeral("1")))))}


def symbol(text: str) -> Phrase:
    """Return the symbol of what a criterion judges, or of its threshold."""
    return named(text) if text.isidentifier() else _SYMBOLS.get(text, text)


def rule(x: Criterion) -> Phrase:
    """``r_r ≤ c_real``."""
    left, relation, right = x.rule.partition(" <= ")
    return (symbol(left), " ≤ ", symbol(right)) if relation else x.rule.replace(">=", "≥")


def percent(c: Expr) -> str:
    """A share in per cent."""
    return f"{float(100 * c):.6g}\xa0%"


def limits(c: Threshold) -> Phrase:
    """Return the threshold of both parts, or of each where they differ; the region in words where
    both parts are judged at once."""
    if c.conversion:
        # The threshold as it is used, without the conversion, then what the conversion made of the
        # published one.
        f, (p, q) = c.conversion, (percent(x) for x in (c.conversion.start, c.conversion.end))
        own = limits(replace(c, conversion=None))
        return (
            own,
            f", converted from {p} to {q} correct answers by a cumulative Gaussian: times ",
            near(f.exact),
        )
    if not c.is_plain:
        return region(c)
    said = (
        percent(c.real)
        if c.real == c.imag
        else f"{percent(c.real)} (real) and {percent(c.imag)} (imaginary)"
    )
    return said, " of ", Absolute(H_ENV)


def amount(c: Expr) -> Phrase:
    """``10 %``, or a formula in omega."""
    return layout(c) if c.has(omega) else percent(c)


def region(c: Threshold) -> Phrase:
    """A region in words: ``an ellipse, 10 % (real) and 12 % (imaginary) of |H_env|, tilt 0.5``."""
    of, own = (" of ", Absolute(H_ENV)), c.region
    if own.corners:
        corners = listed(("(", amount(x), ", ", amount(y), ")") for x, y in own.corners)
        return "a polygon with the corners ", corners, *of
    # Four half widths where shrinking and growing parts have limits of their own; one where all are
    # equal.
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
    """Return the threshold of one part; two where growing and shrinking have limits of their
    own."""
    lower = c.lower(part)
    return (
        amount(c[part])
        if lower is None
        else (amount(c[part]), " higher or ", amount(lower), " lower")
    )


def bounds(found: Mapping[Part, Supremum]) -> Phrase:
    """``r_r by at most 0.01 and r_i by at most 0.02``."""
    return listed((RATIOS[part], " by at most ", at_most(found[part].most)) for part in Part)


def compared(left: Box, relation: str) -> Box:
    """``left < 0``, with any relation."""
    return Relation((left, Numeral("0")), (relation,))


def unit(of: Dimension, motion: MotionKind | None) -> str:
    """Return a unit as it is printed: that of a translation where no motion is known."""
    return unit_text(of.unit(motion or MotionKind.TRANSLATION))


def stiffness_unit(scene: Scene) -> str:
    """The unit of all dynamics of a scene."""
    return unit(Dimension.STIFFNESS, scene.motion)


def enough_damping(least: Phrase, scene: Scene) -> Phrase:
    """Return the sentence on the damping of a hand that compensates all that a display
    generates."""
    least = least, f" {unit(Dimension.DAMPING, scene.motion)}"
    return phrased("Stable in any hand with damping above {}, for any mass and stiffness.", least)


def endless() -> Phrase:
    """Return the sentence that no damping of a hand compensates what a display generates."""
    words = "No damping of a hand is enough for all masses and stiffnesses: −{}/{} is unbounded."
    return phrased(words, Prefixed(OPERATORS[Part.IMAG], H_PERC), OMEGA)


def noted(remarks: Iterable[Phrase]) -> tuple[doc.Notes, ...]:
    """Remarks as a block; nothing where there is none."""
    entries = tuple(remarks)
    return (doc.Notes(entries),) if entries else ()


def caveats(found: Iterable[str]) -> tuple[doc.Notes, ...]:
    """Limits of the results, a remark each; the commands in them are for a page in brief alone."""

    def said(caveat: str) -> Phrase:
        # A split by a pattern with one group gives words and clauses with a command in turn.
        parts = _COMMAND.split(caveat)
        return tuple(doc.Brief(x) if i % 2 else x for i, x in enumerate(parts))

    return noted((Strong("Note:"), " ", said(caveat)) for caveat in found)


_COMMAND = re.compile(r"([;:] haptisym [^.;]*| \(haptisym [^)]*\))")
"""A clause, or a remark in brackets, that names a command."""


def of_linear_model(scene: Scene | SceneFamily, *, in_hand: bool = False) -> str:
    """What is added to a verdict where elements stand for their first harmonic; empty elsewhere.
    Friction is one of them ``in_hand`` alone, as ``first_harmonics`` says."""
    one = scene.first if isinstance(scene, SceneFamily) else scene
    return (
        " (of the linear model at this amplitude)" if first_harmonics(one, in_hand=in_hand) else ""
    )


def is_transparent_throughout(e: Evaluation) -> bool:
    """Whether neither ratio exceeds its threshold anywhere on the band."""
    # One transparent interval that has both ends of the band: identity of the points, no rounding.
    found = [(x.low, x.high) for x in e.transparent]
    return found == [(e.chart.points[0], e.chart.points[-1])]


# What reports have besides words, loaded only where one is made.


def drawing(answer: Answer, name: str, caption: Phrase, *, wide: bool = False) -> doc.Figure:
    """Return a figure of an answer by its name, one column wide, or one and a half."""

    def drawn() -> Any:
        # Resolved by name when the figure is drawn: pages alone never load matplotlib.
        return resolve_name("haptisym.figures.files:draw_figure")(answer, name, wide=wide)

    return doc.Figure(name, caption, drawn, wide)
