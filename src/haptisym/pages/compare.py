"""The page of a comparison: which device is transparent furthest, what each is noticed as, in what
they differ, and stability in the hands that all have."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial

from sympy import Integer

from haptisym.judge.evaluation import Evaluation
from haptisym.judge.percepts import NOT_NAMED
from haptisym.kernel.reals import ExactNumber, Negative, RealNumber, Way, ordered
from haptisym.model.scene import Scene
from haptisym.pages import words as w
from haptisym.pages.measured import bandwidth as measured_bandwidth
from haptisym.verbs.compare.entry import ComparedDisplay, Comparison, SceneDifference
from haptisym.writing import document as doc
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, Strong, listed

_VERDICTS: dict[bool | None, Phrase] = {
    True: "stable",
    False: (Strong("unstable"), ""),
    None: (Strong("undecided"), ""),
}
_PASSIVE = {True: "passive", False: "not passive", None: "passivity undecided"}


def page(found: Comparison) -> Document:
    """Return the page: the answer in three lines, what differs, the devices, the figure."""
    notes = tuple(_notes(found))
    following = ("Next: ", doc.Code("haptisym evaluate SCENE"))
    blocks = (
        doc.Facts(tuple(_answer(found)), "findings"),
        doc.Section("Side by side", tuple(_side_by_side(found)), "side-by-side"),
        *_differences(found),
        # What to type next is for a terminal, not for a paper or a report.
        doc.Versions((doc.Notes((*notes, following)),), lambda: (doc.Notes(notes),)),
    )
    frequency = found[0].scene.frequency
    return Document(found._about.title, (), blocks, "Comparison of haptic displays", frequency)


def _answer(found: Comparison) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the three lines of the answer, device by device."""
    yield "Bandwidth", _ranked(found)
    yield "Felt as", _in_turn((x.name, ": ", x.felt_as or _unnamed(x)) for x in found)
    yield "Stability", _in_turn((x.name, ": ", _stability(x)) for x in found)


def _in_turn(phrases: Iterable[Phrase]) -> Phrase:
    """Return phrases one after the other, with semicolons between them."""
    return tuple(y for x in phrases for y in ("; ", x))[1:]


def _ranked(found: Comparison) -> Phrase:
    """Return the devices by bandwidth, the largest first; equal ones are joined by "="."""
    if found.order is None:
        # With one pair it is all of them; several have their lines below.
        pair = found.undecided[0] if len(found.undecided) == 1 else ()
        of = (" of ", " and ".join(pair)) if pair else ""
        return Strong("order undecided"), of, "; ", _in_turn(map(_width, found))
    groups: list[Phrase] = []
    for places in found.order:
        names = " = ".join(found[i].name for i in places)
        name: Phrase = names if groups else Strong(names)
        groups.append((name, ": ", _width_alone(found[places[0]])))
    return _in_turn(groups)


def _width(x: ComparedDisplay) -> Phrase:
    return x.name, ": ", _width_alone(x)


def _width_alone(x: ComparedDisplay) -> Phrase:
    """Return a bandwidth: proven, the whole band, none, or between two measured points."""
    if isinstance(x.answer, Evaluation):
        if x.bandwidth is None:
            return "none"
        return ("the whole band, up to " if x.is_whole_band else ""), w.both(x.bandwidth)
    return measured_bandwidth(x.answer), " (measured)"


def _unnamed(x: ComparedDisplay) -> str:
    """Return what is said in place of a percept: that there is none, or that discs show none."""
    measured = not isinstance(x.answer, Evaluation)
    return "unresolved" if measured and not x.is_whole_band else "nothing noticed"


def _stability(x: ComparedDisplay) -> Phrase:
    """Return in which of the hands a device is stable, or else whether under prescribed motion; and
    whether it is passive."""
    if not isinstance(x.answer, Evaluation):
        return "not tested (measured)"
    verdicts: dict[bool | None, list[str]] = {}
    for held in x.held:
        verdicts.setdefault(held.stable, []).append(held.hand.name)
    shown: list[Phrase] = [(_VERDICTS[y], " in ", listed(z)) for y, z in verdicts.items()]
    if not shown:
        shown = [(_VERDICTS[x.answer.stable], " under prescribed motion")]
    model = w.of_linear_model(x.answer.scene, in_hand=bool(verdicts))
    return listed(shown), ", ", _PASSIVE[x.is_passive], model


def _differences(found: Comparison) -> Iterator[Block]:
    """Yield what differs: parameters, models and band, then each device against the first one."""
    rows = [x for x in found.differences if _is_of_shared_part(found, x)]
    if rows:
        shown = w.table(
            rows,
            "What is not the same in all devices.",
            w.Field("", lambda x: x.path),
            *(w.Field(device.name, partial(_value, i)) for i, device in enumerate(found)),
        )
        yield doc.Section("What differs", (shown,), "what-differs")
    elif all(isinstance(x.answer, Evaluation) for x in found):
        yield doc.Paragraph("All devices have the same models and the same values.")
    lines = [_against_first(found, i) for i in range(1, len(found))]
    yield from w.noted(lines)


def _is_of_shared_part(found: Comparison, x: SceneDifference) -> bool:
    """Whether a difference is in a part that all devices have, or is the model of one: of a part
    that some lack, and of one with different models, the row of the model is enough."""
    place, _, key = x.path.rpartition(".")
    models = {y.parts.get(f"{place}.model") for y in found if isinstance(y.scene, Scene)}
    return key == "model" or len(models) == 1


def _value(place: int, x: SceneDifference) -> Phrase:
    """Return the cell of a device in the row of a difference."""
    value, knob = x.values[place], x.knobs[place] if x.knobs else None
    if value is None:
        return "-"
    if isinstance(value, tuple):
        low, high = (w.cell(ExactNumber(end)) for end in value)
        return low, " to ", high, "\xa0", FREQUENCY_UNIT
    if knob is None or value.free_symbols:
        return str(value)
    # A row is in one unit, that of the first device: but for what turns beside what moves along.
    first = next(y for y in x.knobs if y is not None)
    unit = first if first.motion is knob.motion else knob
    return w.value_of(unit, ExactNumber(value), Way.NEAREST)


def _against_first(found: Comparison, place: int) -> Phrase:
    """``B is noticed 2.1 rad/s later than A, as higher damping instead of lower mass.``"""
    first, other = found[0], found[place]
    as_what = _instead(first, other)
    change = found.later(place)
    if change is not None:
        return (f"{other.name} is noticed ", _later(change, first), as_what, ".")
    if other.is_whole_band and first.reach.most is not None:
        return f"On its whole band {other.name} is not noticed; {first.name} is."
    if first.is_whole_band and other.reach.most is not None:
        return (f"{other.name} is noticed, {first.name} is not on its whole band", as_what, ".")
    if first.is_whole_band and other.is_whole_band:
        return f"Neither {first.name} nor {other.name} is noticed on its whole band."
    return (f"{other.name}: ", _width_alone(other), "; ", _width(first), as_what, ".")


def _later(change: RealNumber, first: ComparedDisplay) -> Phrase:
    """Return a difference of bandwidths in words, with its sign in them."""
    sign = ordered(ExactNumber(Integer(0)), change)
    if not sign:
        return "at the same frequency as ", first.name
    size = change if sign > 0 else Negative(change)
    return w.both(size), f" {'later' if sign > 0 else 'earlier'} than ", first.name


def _instead(first: ComparedDisplay, other: ComparedDisplay) -> str:
    """Return as what a device is noticed first, where that is not as the first one is."""
    # "as noticed" would say nothing: no property is named there.
    if other.felt_as in ("", NOT_NAMED):
        return ""
    if first.felt_as in ("", NOT_NAMED, other.felt_as):
        return f", as {other.felt_as}"
    return f", as {other.felt_as} instead of {first.felt_as}"


def _side_by_side(found: Comparison) -> Iterator[Block]:
    """Yield a row for each device, one for each hand, and the figure."""
    yield w.table(
        found,
        (
            "Each device: its bandwidth, ",
            FREQUENCY_UNIT,
            ", what limits it, and as what it is felt.",
        ),
        w.Field("device", lambda x: x.name),
        w.number(("bandwidth (", FREQUENCY_UNIT, ")"), _cell),
        w.Field("limited by", _limit),
        w.Field("first felt as", lambda x: x.felt_as or _unnamed(x)),
    )
    hands = found[0].held or next((x.held for x in found if x.held), ())
    if hands:
        # None in place of a hand's number: the row of prescribed motion.
        yield w.table(
            [*range(len(hands)), None],
            "Whether a device is stable in each hand, and under prescribed motion.",
            w.Field("hand", lambda i: "prescribed motion" if i is None else hands[i].hand.name),
            *(w.Field(x.name, partial(_coupled, x)) for x in found),
        )
    words = "The ratios of all devices with their thresholds; a name stands at each curve."
    yield doc.Figure("compare", words, found.figure)


def _limit(x: ComparedDisplay) -> str:
    """Return what limits a bandwidth; of a measured device the parts of which one does."""
    if isinstance(x.answer, Evaluation):
        return ", ".join(y.name for y in x.limited_by) or "-"
    return " or ".join(part.value for part in x.answer.limited_by) or "-"


def _cell(x: ComparedDisplay) -> Phrase:
    """Return the bandwidth as a cell; of a measured device between which points it lies."""
    if isinstance(x.answer, Evaluation):
        if x.bandwidth is None:
            return "none"
        return "whole band" if x.is_whole_band else w.cell(x.bandwidth)
    least, most = x.reach
    if most is None:
        return "-" if float(least) < 0 else ("≥ ", w.cell(least))
    return ("< " if float(least) < 0 else (w.cell(least), " to ")), w.cell(most)


def _coupled(x: ComparedDisplay, hand: int | None) -> Phrase:
    """Return whether a device is stable in a hand by its number, or under prescribed motion."""
    if not isinstance(x.answer, Evaluation):
        return "-"
    return _VERDICTS[x.answer.stable if hand is None else x.held[hand].stable]


def _notes(found: Comparison) -> Iterator[Phrase]:
    """Yield what is proven, and the remarks of single scenes, with their names."""
    scenes = [x.scene for x in found if isinstance(x.scene, Scene)]
    fitted = " for the fitted models" if any(x.level is not None for x in scenes) else ""
    if found.certified:
        yield f"Proven{fitted}: every bandwidth, their order, and all digits printed."
    elif found.settled and found.order is not None:
        yield "Proven of the formulas alone: measured devices are compared at their points."
    measured = {x.name for x in found if not isinstance(x.answer, Evaluation)}
    for pair in found.undecided:
        yield w.undecided(("which bandwidth is larger, that of ", " or of ".join(pair)))
    if any(measured.intersection(pair) for pair in found.undecided):
        yield _WAY_OUT
    whose: dict[str, list[str]] = {}
    for x in found:
        for note in x.answer.asides():
            whose.setdefault(note, []).append(x.name)
    for note, names in whose.items():
        yield f"{', '.join(names)}: ", doc.coded(note)
    for x in found:
        if isinstance(x.scene, Scene):
            yield from ((f"{x.name}: ", words) for words in w.model_words(x.scene))


_WAY_OUT: Phrase = (
    "More averages make measured intervals shorter; fitted models are put in order exactly",
    doc.Brief((": ", doc.Code("haptisym identify FILE"))),
    ".",
)
"""What would decide an order that measurements leave undecided."""
