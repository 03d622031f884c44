"""Two to six devices side by side: which one is transparent furthest, as what each is noticed, and
whether it is stable in a hand.

Each device is evaluated alone. Their bandwidths are then put in order: two different numbers are
told apart by enclosures, ever tighter ones. No enclosure shows that two are equal, so for those the
functions of both devices are charted in one ring of polynomials, in which equal zeros of different
functions are found to be one number. A device that is transparent on its whole band has only a
lower bound, and a measured one has both bounds only at its frequency points; where the bounds of
two devices overlap their order stays undecided, and so does the order of all.

Begin with ``compare``; ``ComparedDisplay.reach`` says what is known of one bandwidth.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, cmp_to_key
from itertools import chain, combinations, compress
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import flint
from sympy import Expr, Integer, Rational, Symbol

from haptisym.judge.answers import Answer, NoScene
from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.judge.percepts import felt_words
from haptisym.kernel.budget import SECONDS, limited, share
from haptisym.kernel.errors import SceneError, UndecidedError, several, within
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, ordered, whole
from haptisym.kernel.rings import s
from haptisym.kernel.roots import Chart, Interval, Key, Signed, chart
from haptisym.model.catalogue import Effect, Environment, Hand
from haptisym.model.distortion import Distortion
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.parameters import free_name
from haptisym.model.quantities import Number
from haptisym.model.scene import Knob, Scene, in_hands
from haptisym.model.scenefile import chosen, common_ring, open_scenes
from haptisym.verbs.measured.entry import MeasuredEvaluation, judge
from haptisym.verbs.stability.held import Held, held

MOST = 6
"""Devices that are compared at once: a page and a figure have room for no more."""
Given = Scene | MeasuredScene | Evaluation | MeasuredEvaluation | str | Path
"""What may be compared: a scene, its name or its file, or an answer of ``evaluate``."""
NOWHERE = ExactNumber(Integer(-1))
"""The bandwidth, in comparisons alone, of a device that is noticed from the low end of its band on:
less than that of any other device."""


class Reach(NamedTuple):
    """Bounds of a bandwidth, rad/s: it is at least ``least`` and at most ``most``.

    Both are one number where it is proven. ``most`` is None where nothing is noticed up to the high
    end of the band, so that there is no upper bound.
    """

    least: RealNumber
    most: RealNumber | None


@dataclass(frozen=True)
class NumberDifference(RealNumber):
    """The number ``high`` - ``low``."""

    high: RealNumber
    low: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.high.ball(bits) - self.low.ball(bits)


@dataclass(frozen=True, repr=False)
class ComparedDisplay(Shown):
    """One of the devices that are compared.

    ``name`` : by which it is called here. ``answer`` : of ``evaluate``. ``held`` : its stability in
    each hand that is asked about, in their order; empty for a measured device, which has no
    formulas.
    """

    name: str
    answer: Evaluation | MeasuredEvaluation
    held: tuple[Held, ...] = ()

    def _line(self) -> str:
        width = self.bandwidth
        return f"{self.name}: {'no bandwidth' if width is None else width.digits(5) + ' rad/s'}"

    @property
    def scene(self) -> Scene | MeasuredScene:
        """The scene that was evaluated."""
        return self.answer.scene

    @property
    def bandwidth(self) -> RealNumber | None:
        """The proven bandwidth, rad/s; None where there is none, or none that is proven as the
        device is measured."""
        return self.answer.bandwidth if isinstance(self.answer, Evaluation) else None

    @property
    def is_whole_band(self) -> bool:
        """Whether nothing is noticed on the whole band; of a measured device whether that is shown
        at each of its frequencies."""
        if isinstance(self.answer, MeasuredEvaluation):
            return self.answer.is_below_throughout
        return self.reach.most is None

    @cached_property
    def reach(self) -> Reach:
        """What is known of its bandwidth: proven of formulas, measured at the points of a file."""
        if isinstance(self.answer, Evaluation):
            width = self.answer.bandwidth
            if width is None:
                return Reach(NOWHERE, NOWHERE)
            return Reach(width, None if width is self.answer.chart.points[-1].omega else width)
        least, most = self.answer.reach
        return Reach(
            NOWHERE if least is None else _double(least), None if most is None else _double(most)
        )

    @property
    def limited_by(self) -> tuple[Criterion, ...]:
        """The criteria that end the bandwidth; none where nothing does, or it is measured."""
        if not isinstance(self.answer, Evaluation):
            return ()
        crossings = self.answer.crossings
        return tuple(
            dict.fromkeys(x.criterion for x in crossings if x.omega is self.answer.bandwidth)
        )

    @cached_property
    def felt_as(self) -> str:
        """What is noticed first, in words: ``lower mass``; empty where nothing is. Of a measured
        device it is what the first point shows at which that is decided."""
        if isinstance(self.answer, Evaluation):
            first = min(self.answer.felt, key=lambda x: float(x.band.low.omega), default=None)
            return first.words if first else ""
        percept = min(self.answer.percepts, key=lambda x: x.omega, default=None)
        return felt_words(percept.property, percept.change) if percept else ""

    @property
    def knobs(self) -> dict[str, Knob]:
        """Its parameters and thresholds by their paths; those of hands are no part of a device."""
        if not isinstance(self.scene, Scene):
            return {}
        limits = self.scene.knobs.limits.values()
        return {x.path: x for x in (*self.scene.parameters, *dict.fromkeys(limits))}

    @property
    def parts(self) -> dict[str, str]:
        """What has no number: the model of each part by its path, with its choices and formulas;
        the order of the effects; and the shape of the JND's region."""
        scene = self.scene
        if not isinstance(scene, Scene):
            return {}
        found: dict[str, str] = {}
        for place, x in scene.elements():
            found[f"{place}.model"] = x.model
            if isinstance(x, Effect):
                found |= {f"{place}.{key}": str(choice) for key, choice in x.settings}
            if x.model in _WITH_FORMULAS:
                found |= _formulas(place, x)
        found["effects"] = ", ".join(x.name for x in scene.effects)
        return found | {"evaluation.jnd.shape": str(scene.threshold.region.shape.value)}

    @property
    def band(self) -> tuple[Expr, Expr] | None:
        """Its band, rad/s, exact; None of a measured device."""
        return self.scene.band if isinstance(self.scene, Scene) else None

    def row(self, digits: int) -> dict[str, Any]:
        """The device as a part of a document."""
        document = self.answer.to_dict()
        width = self.bandwidth
        exact: dict[str, Any] = {}
        if width is not None:
            exact = {"digits": width.digits(digits), "enclosure": list(width.enclosure(digits))}
        if not isinstance(self.answer, Evaluation):
            least, most = self.reach
            exact = {"reach": [None if x in (None, NOWHERE) else float(x) for x in (least, most)]}
        return {
            "name": self.name,
            "title": document["title"],
            "bandwidth": None if width is None else float(width),
            **exact,
            "whole_band": self.is_whole_band,
            "limited_by": [x.name for x in self.limited_by],
            "percepts": document["percepts"],
            "held": [
                {"hand": x.hand.name, "stable": x.stable, "unstable": x.unstable} for x in self.held
            ],
            "stable": document.get("stable"),
            "passive": self.is_passive,
            "parameters": {path: str(x.value) for path, x in self.knobs.items()},
            "certified": document["certified"],
        }

    @property
    def is_passive(self) -> bool | None:
        """Whether it is passive: proven; None where that is undecided, or the device is
        measured."""
        found = self.answer.passivity if isinstance(self.answer, Evaluation) else None
        return found.holds if found is not None else None


def _formulas(place: str, x: Environment | Effect) -> dict[str, str]:
    """Return the formulas of a part by their paths, in the keys of its parameters, as symbols are
    named by the scene; of an effect those entries of A, B, C, D that change anything."""
    names = {p.symbol: Symbol(p.key) for p in x.parameters}
    if isinstance(x, Environment):
        entries = {"H": x.dynamics}
        plain: dict[str, Expr] = {}
    else:
        entries = dict(zip("ABCD", x.dynamics, strict=True))
        plain = dict(zip("ABCD", map(Integer, (1, 0, 0, 1)), strict=True))
        if x.model == "shunt":
            # A mass and a damping have rows of their own.
            powers = {"m": s**2, "b": s}
            plain["B"] = sum(
                (Symbol(p.key) * powers.get(p.key, 1) for p in x.parameters), plain["B"]
            )
    written = {key: entry.xreplace(names) for key, entry in entries.items()}
    return {f"{place}.{key}": str(y) for key, y in written.items() if y != plain.get(key)}


_WITH_FORMULAS = frozenset(
    ("expression", "difference-equation", "series", "shunt", "admittance-display", "two-port")
)
"""Models whose formulas are the users'."""


def _double(x: float) -> ExactNumber:
    return ExactNumber(Rational(float(x)))


def _equal_bandwidths(one: Evaluation, other: Evaluation) -> bool:
    """Whether two bandwidths that no enclosure tells apart are one number: proven where True.

    Both devices are charted together from the higher of the two low ends on: in one ring equal
    zeros of different functions are one point.
    """
    scenes = one.scene, other.scene
    ring = common_ring(scenes)
    functions: dict[tuple[int, Criterion], Signed] = {}
    for i, scene in enumerate(scenes):
        d = Distortion.of(scene.distortion().chain, ring)
        functions |= {(i, x): x.function(d) for x in noticed(scene.threshold)}
    lows, highs = zip(*(scene.band for scene in scenes), strict=True)
    low = lows[0] if ordered(ExactNumber(lows[1]), ExactNumber(lows[0])) >= 0 else lows[1]
    high = highs[0] if ordered(ExactNumber(highs[0]), ExactNumber(highs[1])) >= 0 else highs[1]
    table = chart(dict(functions), low, high)
    if table.undecided:
        return False
    ends = []
    for i in range(len(scenes)):
        keys = [key for key in functions if key[0] == i]
        ends.append(table.reach(_where_none_is_positive(table, keys)))
    return ends[0] is not None and ends[0] is ends[1]


def _where_none_is_positive(table: Chart, keys: Sequence[Key]) -> tuple[Interval, ...]:
    return table.where(lambda signs: all(signs[key] <= 0 for key in keys))


def _order(one: ComparedDisplay, other: ComparedDisplay) -> int | None:
    """-1 where the first device has the larger bandwidth, 1 where the second has, 0 where both are
    equal: proven of formulas; None where it is undecided."""
    a, b = one.reach, other.reach
    if a.most is not None and ordered(a.most, b.least) > 0:
        return 1
    if b.most is not None and ordered(b.most, a.least) > 0:
        return -1
    if a.least is b.least is NOWHERE and a.most is b.most is NOWHERE:
        return 0
    if not (isinstance(one.answer, Evaluation) and isinstance(other.answer, Evaluation)):
        return None
    if a.most is None or b.most is None:
        # Nothing is noticed of one of them up to the end of its band: where both bands end at one
        # frequency nothing is noticed of either, or the other one touches its limit there.
        same_end = one.answer.scene.band[1] == other.answer.scene.band[1]
        return 0 if a.most is b.most and same_end else None
    return 0 if _equal_bandwidths(one.answer, other.answer) else None


@dataclass(frozen=True)
class SceneDifference:
    """What differs between devices at one ``path``: in the order of the devices the values, exact,
    SI; names of models; or bands, rad/s. None where a device has nothing at that path.

    ``knobs`` : the parameters at that path, with their units; None where there is none.
    """

    path: str
    values: tuple[Any, ...]
    knobs: tuple[Knob | None, ...] = ()

    def row(self) -> dict[str, Any]:
        """The difference as a row of a document."""
        return {"path": self.path, "values": [_exact(x) for x in self.values]}


def _exact(value: Any) -> Any:
    """A value as a document has it: exact, as text."""
    if isinstance(value, tuple):
        return [str(x) for x in value]
    return None if value is None else str(value)


@dataclass(frozen=True, repr=False)
class Comparison(Answer):
    """Two to six devices side by side; a sequence of ``ComparedDisplay``.

    ``devices`` : as given. ``differences`` : in which parameters, models, band and threshold they
    differ. ``order`` : their places by bandwidth, the largest first, equal ones together; None
    where it is undecided, by ``undecided``, the pairs of devices that could not be put in order.
    Proven of formulas: the order, and that two bandwidths are equal. ``certified`` is False where a
    device is measured, or something is undecided.

    >>> import haptisym as hs
    >>> found = hs.compare("fu2019", values={"zeta": "0.4"})
    >>> found.order, [x.bandwidth.digits(5) for x in found], found.differences[0].path
    (((1,), (0,)), ['7.9789', '12.760'], 'effects.filter.zeta')
    """

    _schema: ClassVar[str] = "haptisym.comparison/1"
    _page: ClassVar[str] = "haptisym.pages.compare:page"
    _figure: ClassVar[str] = "haptisym.figures.compare:COMPARISON"

    devices: tuple[ComparedDisplay, ...]
    digits: int = 15

    def _line(self) -> str:
        return "; ".join(x._line() for x in self.devices)

    def __len__(self) -> int:
        return len(self.devices)

    def __iter__(self) -> Any:
        return iter(self.devices)

    def __getitem__(self, place: int) -> ComparedDisplay:
        return self.devices[place]

    @property
    def _about(self) -> NoScene:
        return NoScene(" and ".join(x.name for x in self.devices))

    @cached_property
    def _pairs(self) -> Mapping[tuple[int, int], int | None]:
        """The order of each pair of devices, by their places."""
        pairs: dict[tuple[int, int], int | None] = {}
        for i, j in combinations(range(len(self.devices)), 2):
            try:
                found = _order(self.devices[i], self.devices[j])
            except UndecidedError:
                found = None
            pairs[i, j] = found
            pairs[j, i] = None if found is None else -found
        return pairs

    @property
    def undecided(self) -> tuple[tuple[str, str], ...]:
        """The names of each two devices of which it is undecided whose bandwidth is larger."""
        names = [x.name for x in self.devices]
        return tuple(
            (names[i], names[j]) for (i, j), x in self._pairs.items() if i < j and x is None
        )

    @cached_property
    def order(self) -> tuple[tuple[int, ...], ...] | None:
        """The places of the devices by bandwidth, the largest first, equal ones together; None
        where it is undecided."""
        if self.undecided:
            return None

        def before(i: int, j: int) -> int:
            return 0 if i == j else self._pairs[i, j] or 0

        groups: list[list[int]] = []
        for i in sorted(range(len(self.devices)), key=cmp_to_key(before)):
            if groups and not before(groups[-1][0], i):
                groups[-1].append(i)
            else:
                groups.append([i])
        return tuple(map(tuple, groups))

    @cached_property
    def differences(self) -> tuple[SceneDifference, ...]:
        """The paths at which not all devices have the same: models, then parameters and thresholds,
        then the band. Measured devices have no paths, and no part in it."""
        parts = [x.parts for x in self.devices]
        if len({frozenset(x.get("effects", "").split(", ")) for x in parts if x}) > 1:
            # Which effects there are is seen from their models.
            parts = [{key: y for key, y in x.items() if key != "effects"} for x in parts]
        knobs = [x.knobs for x in self.devices]
        rows = []
        for path in _paths(parts):
            models = tuple(x.get(path) for x in parts)
            rows.append(SceneDifference(path, models))
        for path in _paths(knobs):
            there = tuple(x.get(path) for x in knobs)
            values = tuple(None if x is None else x.value for x in there)
            rows.append(SceneDifference(path, values, there))
        bands = tuple(x.band for x in self.devices)
        rows.append(SceneDifference("evaluation.band", bands))
        has_formulas = [isinstance(x.scene, Scene) for x in self.devices]
        return tuple(x for x in rows if len(set(compress(x.values, has_formulas))) > 1)

    def later(self, place: int) -> RealNumber | None:
        """By how much the device at a place is noticed later than the first one, rad/s; negative if
        it is noticed earlier. None where one of the bandwidths has no proven value."""
        first, other = self.devices[0], self.devices[place]
        if first.is_whole_band or other.is_whole_band:
            return None
        if first.bandwidth is None or other.bandwidth is None:
            return None
        # Equal numbers have a difference of exactly 0, which no enclosure would show.
        if self._pairs[0, place] == 0:
            return ExactNumber(Integer(0))
        return NumberDifference(other.bandwidth, first.bandwidth)

    @property
    def certified(self) -> bool:
        """Whether every number is proven, and nothing was left undecided."""
        decided = all(x.is_decided for device in self.devices for x in device.held)
        return decided and self.order is not None and all(x.answer.certified for x in self.devices)

    @property
    def settled(self) -> bool:
        """Whether no question about formulas stayed undecided."""
        decided = all(x.is_decided for device in self.devices for x in device.held)
        return decided and self.order is not None and all(x.answer.settled for x in self.devices)

    def _body(self) -> dict[str, Any]:
        return {
            "scenes": [x.row(self.digits) for x in self.devices],
            "differences": [x.row() for x in self.differences],
            "order": None if self.order is None else [list(x) for x in self.order],
            "certified": self.certified,
        }

    def _left(self) -> dict[str, Any]:
        return {"undecided": [list(x) for x in self.undecided]} if self.undecided else {}


def _paths(tables: Iterable[Mapping[str, Any]]) -> list[str]:
    """All paths of several tables, each once, in the order in which they come."""
    return list(dict.fromkeys(chain.from_iterable(tables)))


def compare(
    *devices: Given,
    values: Mapping[str, Number] | None = None,
    hand: str | Hand | Iterable[str | Hand] | None = None,
    environment: str | None = None,
    files: bool = True,
    digits: int = 15,
    limit: float | None = SECONDS,
) -> Comparison:
    """Compare two to six devices: which one is transparent furthest, as what each is noticed, and
    whether it is stable in a hand.

    ``devices`` : scenes, their names or files, measured ones too, or answers of ``evaluate``. Each
    is felt with its own environment, on its own band, with its own threshold; what differs is
    listed.
    ``values`` : of one device alone, which is then compared with itself at these values, by path or
    symbol. ``hand`` : hands, by name or as ``Hand``; those that all devices have if not given.
    ``environment`` : which one of a scene that has several. ``files`` : whether files that a scene
    names are read. ``digits`` : of each number of the document. ``limit`` : seconds of processor
    time, None for none; LimitError where they are over.

    Proven: each device is evaluated as by ``evaluate``; the order of proven bandwidths, and
    that two are equal, is proven. SceneError for fewer than two or more than six devices, and for a
    symbol without a number.

    >>> found = compare("fu2019", "helicopter-cyclic", hand="postural-arm")
    >>> found.order, [x.held[0].stable for x in found]
    (((0,), (1,)), [True, True])
    """
    digits = whole("digits", digits)
    given = [_opened(x, environment, files=files) for x in devices]
    names = [_name(x, i) for i, x in enumerate(devices)]
    if values is not None:
        if len(given) != 1:
            raise SceneError(
                f"values: they make a second device of one, and there are {len(given)} already: "
                f"give one device, or leave values out"
            )
        given.append(_changed(given[0], values))
        names.append(", ".join(f"{path.rpartition('.')[2]} = {x}" for path, x in values.items()))
    if not 2 <= len(given) <= MOST:
        raise SceneError(
            f"compare takes 2 to {MOST} devices, not {len(given)}; of one device with other "
            f"values: compare(scene, values={{...}}), haptisym compare SCENE --with PATH=VALUE"
        )
    with limited(limit):
        answers = []
        for i, (name, x) in enumerate(zip(names, given, strict=True)):
            # An equal share of the time that is left for each that is still to come.
            with share(1 / (len(given) - i)), within(name):
                answers.append(_answered(x, digits))
        scenes = [x.scene for x in answers if isinstance(x.scene, Scene)]
        hands = _hands(scenes, hand)
        taken: dict[str, ComparedDisplay] = {}
        for name, x in zip(names, answers, strict=True):
            free = free_name(name, taken, "-")
            taken[free] = ComparedDisplay(free, x, _held(name, x, hands))
        comparison = Comparison(tuple(taken.values()), digits)
        _ = comparison.order  # computed when first asked for, which must be within the limit
        return comparison


def _opened(given: Given, environment: str | None, *, files: bool) -> Any:
    """A scene or an answer as it is; the one of that name or in that file."""
    if isinstance(given, Scene | MeasuredScene | Evaluation | MeasuredEvaluation):
        return given
    opened, name = open_scenes(given, files=files)
    if isinstance(opened, MeasuredScene):
        return opened
    return chosen(opened, name, environment if len(opened) > 1 else None)


def _name(given: Given, place: int) -> str:
    """What a device is called: the name of its file, its title, or its place."""
    if isinstance(given, str | Path):
        return Path(str(given)).name.removesuffix(".toml")
    scene = given if isinstance(given, Scene | MeasuredScene) else given.scene
    return scene.title or f"device {place + 1}"


def _changed(given: Any, values: Mapping[str, Number]) -> Scene:
    scene = given.scene if isinstance(given, Evaluation) else given
    if not isinstance(scene, Scene):
        raise SceneError("values: a measured device has no parameters to change")
    return scene.with_values(values)


def _answered(given: Any, digits: int) -> Evaluation | MeasuredEvaluation:
    if isinstance(given, MeasuredScene):
        return judge(given)
    if isinstance(given, Scene):
        return evaluate(given, digits)
    found: Evaluation | MeasuredEvaluation = given
    return found


def _held(
    name: str, answer: Evaluation | MeasuredEvaluation, hands: Sequence[str | Hand]
) -> tuple[Held, ...]:
    """Whether a device is stable in each hand; nothing of a measured one."""
    if not isinstance(answer, Evaluation) or not hands:
        return ()
    # A hand that moves along a line is refused for a device that turns about an axis.
    with within(name):
        scene = in_hands(answer.scene, hands)
    return tuple(held(scene, x) for x in scene.hands)


def _hands(
    scenes: Sequence[Scene], asked: str | Hand | Iterable[str | Hand] | None
) -> Sequence[str | Hand]:
    """The hands that are asked about; those that all scenes have where none are."""
    if asked is None:
        first = scenes[0].hands if scenes else ()
        return [x for x in first if all(_has(scene, x) for scene in scenes[1:])]
    if isinstance(asked, str | Hand):
        return [asked]
    return list(several("hand", asked, "give a name, a Hand, or several"))


def _has(scene: Scene, hand: Hand) -> bool:
    """Whether a scene has this hand: the same name and equal numbers."""
    numbers = {p.key: p.value for p in hand.parameters}
    return any(
        x.name == hand.name and {p.key: p.value for p in x.parameters} == numbers
        for x in scene.hands
    )
