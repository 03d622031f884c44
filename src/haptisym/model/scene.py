"""A scene: a haptic display and the question of what a person notices of it.

A scene has the *environment* to be felt (a dynamics H_env, force over motion, as of a wall or a
mass), the *effects* between it and the hand (filters, delays, samplers, elastic parts), the *band*
of frequencies of interest, the *threshold* (JND, just-noticeable difference, relative to |H_env|)
and the *hands* that may hold it. Where the controller does not render the environment itself, what
it renders is one more environment, ``rendered``. Begin reading at ``Scene``, which is valid by
construction: SceneError names what is wrong.

**Names.** Each effect has a name and each parameter a symbol of its own, so that closed forms of
the whole scene are unambiguous (``with_names``, ``symbol_names``). A parameter has a *path* in a
scene file, as ``effects.filter.omega_n``. A parameter of ``rendered`` may be *tied* to one of the
environment: a reference in its place, so that both are one parameter in two places.

**Knobs** (``Scene.knobs``) are the numbers of a scene that a question may vary, by one set of
names: the parameters of its elements (environment, effects, hands), and the thresholds.

**Notes.** ``Scene.asides`` are the notes that go with an answer: which numbers were estimated, that
it is for nominal values, which parameters exist twice. ``caveats``, in the last section, are the
limits of an exact answer: where the formulas of a scene are approximations or do not apply.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial, reduce
from typing import Any, Protocol

from sympy import Expr, Integer, Max, Rational, Symbol, pi

from haptisym.kernel.budget import spared
from haptisym.kernel.errors import SceneError, meant, several, within
from haptisym.kernel.objects import Shown, titled
from haptisym.kernel.rings import c, omega
from haptisym.kernel.roots import sign_of_number
from haptisym.model.catalogue import (
    AT,
    CLOCKS,
    DESCRIBED,
    DIFFERENCE_EQUATION,
    FRICTION,
    NOBODY,
    Effect,
    Environment,
    Hand,
    given_band,
    given_effects,
    given_environment,
    given_hands,
    hands,
    with_controller,
)
from haptisym.model.chain import NOTHING_TO_FEEL, Chain
from haptisym.model.distortion import Distortion, felt_instead
from haptisym.model.jnd import Part, Threshold, read_threshold, threshold_value
from haptisym.model.parameters import (
    Parameter,
    Rule,
    Slot,
    dimensions,
    free_name,
    read_confidence,
    read_parameter,
    refuse_references,
    spread,
)
from haptisym.model.quantities import RADIANS, Dimension, MotionKind, Number, Unit, number

THRESHOLD = "evaluation.jnd"
"""The path of both thresholds as one."""
_THRESHOLD_NAMES = ("c", "c_real", "c_imag")
"""The names of the thresholds' symbols."""
_FRICTION_KEYS = {"weber": Dimension.RATIO, "floor": Dimension.FORCE, "reference": Dimension.FORCE}
"""The keys of a friction threshold in a scene file."""


# What may be varied.


@dataclass(frozen=True, repr=False)
class Knob(Parameter):
    """A number of a scene that a question may vary: ``value`` in SI, its ``rule`` (the values that
    it may have) and, where the scene gives one, its range ``interval``.

    ``place``: of its element in a scene file, ``environment``, ``effects.filter``; of a threshold
    ``evaluation``. ``model``: that of the element. ``motion``: the scene's, along a line or about
    an axis. ``also``: the paths of the parameters that are tied to it. ``parts``: of a threshold
    the parts, real and imaginary, that it is for, and its symbol is c; () for any other number.
    """

    place: str = ""
    model: str = ""
    also: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()

    @property
    def path(self) -> str:
        """The path in a scene file: ``effects.filter.omega_n``."""
        return f"{self.place}.{self.key}"

    @property
    def paths(self) -> tuple[str, ...]:
        """The path, and the paths of the parameters that refer to it."""
        return self.path, *self.also

    @property
    def is_of_hand(self) -> bool:
        """Whether it is a parameter of a hand, on which what is felt does not depend."""
        return self.model == "hand"

    def felt(self) -> Knob:
        """Return the knob itself; SceneError for one of a hand, which changes nothing that is
        felt."""
        if self.is_of_hand:
            raise SceneError(
                f"{self.path} does not change what is felt; haptisym stability examines it"
            )
        return self

    @property
    def name(self) -> str:
        """The name of its symbol; of the threshold of a single part ``c_real`` or ``c_imag``."""
        return f"c_{self.parts[0].value}" if len(self.parts) == 1 else self.symbol.name

    @property
    def unit(self) -> str:
        """The name of its unit; ``SI`` where none is known."""
        return self.unit_in(self.motion) or "SI"

    def number(self, given: Number) -> Expr:
        """Read a number for it, exact, in SI; SceneError for a unit that does not fit, and for a
        symbol."""
        with within(self.path):
            read = number(given, self.dimension)
        if read.motion and self.motion and read.motion is not self.motion:
            raise SceneError(
                f'{self.path}: "{given}" is {read.motion.value}, the scene {self.motion.value}'
            )
        return read.value

    def check(self, given: Number) -> None:
        """SceneError, with the path, unless its rule allows a value: a number, a range or a
        symbol."""
        if self.parts:
            threshold_value(self.path, given)
        else:
            read_parameter(self.path, given, Slot(self.dimension, self.rule), self.symbol.name)

    def put(self, scene: Scene, given: Number) -> Scene:
        """The scene with this value for the knob; SceneError where the model does not allow it."""
        return scene.with_values({self.path: given})


def threshold_knobs(threshold: Threshold) -> tuple[Knob, ...]:
    """The knobs of a threshold: both parts as one (with the real part's value), then each part;
    none of a polygon, which is given by its corners."""
    if threshold.region.corners:
        return ()
    keys = {"jnd": tuple(Part), **{f"jnd.{part.value}": (part,) for part in Part}}
    return tuple(
        Knob(
            c,
            threshold[parts[0]],
            Dimension.RATIO,
            key=key,
            rule=Rule.POSITIVE,
            interval=threshold.interval(parts[0]),
            place="evaluation",
            parts=parts,
        )
        for key, parts in keys.items()
    )


@dataclass(frozen=True)
class Knobs(Collection[Knob]):
    """The knobs of a scene, the thresholds last: three, of which ``evaluation.jnd`` is the other
    two as one.

    ``knobs[name]``: by path, by the name of a symbol (``c`` the threshold), or by the end of a
    path, where that is unique.

    >>> from haptisym.model.scenefile import load_scene
    >>> knobs = load_scene("fu2019").knobs
    >>> {knobs[x].path for x in ("omega_n", "filter.omega_n", "effects.filter.omega_n")}, knobs["c"].path
    ({'effects.filter.omega_n'}, 'evaluation.jnd')
    """

    all: tuple[Knob, ...]
    settings: tuple[str, ...] = ()
    """Paths of choices and whole numbers, which are written in the scene and never varied."""

    def __iter__(self) -> Iterator[Knob]:
        return iter(self.all)

    def __len__(self) -> int:
        return len(self.all)

    def __contains__(self, knob: object) -> bool:
        return knob in self.all

    def __getitem__(self, name: str) -> Knob:
        # A full path goes before a symbol's name, and that before the end of a path.
        given = str(name)
        by_name = [x for x in self if given == x.name]
        by_end = [x for x in self if any(path.endswith(f".{given}") for path in x.paths)]
        # Where a parameter of the scene is called c as well as the threshold, the name is
        # ambiguous: both go into the list, and the error lists their paths.
        if any(x.parts for x in by_name):
            by_name = [x for x in self if x in by_name or x in by_end]
        matches = [x for x in self if given in x.paths] or by_name or by_end
        if len(matches) > 1:
            raise SceneError(
                f'"{given}" is ambiguous: write {" or ".join(x.path for x in matches)}'
            )
        if not matches:
            raise self._unknown(given)
        return matches[0]

    def _unknown(self, given: str) -> SceneError:
        """The error for a name that no knob has: with the one that may be meant, by its dimension
        ("mass") or its spelling, and with all paths."""
        for setting in self.settings:
            if f".{setting}".endswith(f".{given}"):
                what = "a setting of its model: write another one into the scene"
                if setting.endswith(".delay"):
                    what = (
                        "a whole number of samples: write another one into the scene, or add an "
                        'effect of model = "delay" and vary its tau'
                    )
                return SceneError(f'"{given[:60]}": {setting} cannot be varied, it is {what}')
        paths = [path for x in self for path in x.paths]
        hint = ""
        for x in self:
            if not hint and x.dimension.name.lower() == given.lower():
                hint = f'did you mean "{x.path}"? '
        hint = hint or meant(given, [*paths, *(x.name for x in self)])
        return SceneError(f'unknown parameter "{given[:60]}": {hint}valid are {", ".join(paths)}')

    @property
    def parameters(self) -> tuple[Knob, ...]:
        """The parameters of the display: all knobs but the thresholds and the hands'."""
        return tuple(x for x in self if not x.parts and not x.is_of_hand)

    @property
    def limits(self) -> dict[Part, Knob]:
        """The threshold's knob of each part: the one for both where they are equal, else each its
        own; empty for a polygon, which has no limit for one part."""
        thresholds = [x for x in self if x.parts]
        if not thresholds:
            return {}
        # The first one stands for both parts, as ``threshold_knobs`` lists them.
        both, *each = thresholds
        first, second = each
        are_equal = (first.value, first.interval) == (second.value, second.interval)
        return {part: both if are_equal else knob for part, knob in zip(Part, each, strict=True)}

    def chosen(self, names: Iterable[str]) -> tuple[Knob, ...]:
        """The knobs of several names, in order; SceneError where two names mean one number."""
        knobs: list[Knob] = []
        for knob in map(self.__getitem__, names):
            for other in knobs:
                if other.path == knob.path:
                    raise SceneError(f"{knob.path} is given twice")
                if set(other.parts) & set(knob.parts):
                    raise SceneError(
                        f"{THRESHOLD} sets both thresholds: give it, or {THRESHOLD}.real and "
                        f"{THRESHOLD}.imag"
                    )
            knobs.append(knob)
        return tuple(knobs)

    def need_numbers(self, besides: Collection[Knob] = ()) -> None:
        """SceneError where the value of a knob is a symbol, unless it is among ``besides``."""
        for x in self:
            if x.value.free_symbols - {omega} and x not in besides:
                raise SceneError(
                    f"{x.path} = {x.value} is a symbol; give a number, as "
                    f'with_values({{"{x.path}": ...}}); derive and distort accept symbols'
                )


# When friction is noticed.


@dataclass(frozen=True)
class FrictionThreshold:
    """A friction force F is noticed as another than ``reference`` where they differ by more than
    max(floor, weber reference): by Weber's law and a floor of its own, not by the JND of damping.

    ``weber`` : a fraction, >= 0. ``floor``, ``reference`` : N or N m, >= 0; the reference is what
    should be felt, 0 if not given. ``motion`` : that of the units, None where no force is given.
    Source: Veldhuis, Mulder and van Paassen (2024), doi:10.1109/THMS.2024.3368358 (abstract read):
    Weber's law where friction is large, a detection threshold, which the linear dynamics shift,
    where it is not.
    """

    weber: Expr = Integer(0)
    floor: Expr = Integer(0)
    reference: Expr = Integer(0)
    motion: MotionKind | None = None

    @property
    def least(self) -> Expr:
        """The least difference of force that is noticed, N or N m."""
        return Max(self.floor, self.weber * self.reference)


def read_friction(given: Any) -> FrictionThreshold:
    """Read the friction threshold from the table of a scene. SceneError names key and rule.

    >>> read_friction({"weber": "20 %", "floor": "50 mN", "reference": "0.4 N"}).least
    2/25
    """
    if isinstance(given, FrictionThreshold):
        return given
    if not isinstance(given, Mapping) or not given:
        raise SceneError('friction: give a table, as { weber = 0.2, floor = "0.05 N" }')
    numbers: dict[str, Any] = {}
    motions = set()
    for key, x in given.items():
        if key not in _FRICTION_KEYS:
            raise SceneError(
                f'friction: unknown key "{str(key)[:60]}": '
                f"{meant(str(key), _FRICTION_KEYS)}valid are {', '.join(_FRICTION_KEYS)}"
            )
        with within(f"friction: {key}"):
            read = number(x, _FRICTION_KEYS[key])
        if read.value.free_symbols or sign_of_number(read.value) < 0:
            raise SceneError(f'friction: {key}: "{x}" must be a number >= 0')
        numbers[key] = read.value
        motions |= {read.motion} - {None}
    if len(motions) > 1:
        raise SceneError("friction: floor and reference: give both as forces, or both as torques")
    return FrictionThreshold(**numbers, motion=next(iter(motions), None))


# Names that are unique in a scene.


class HasParameters(Protocol):
    """An environment, an effect or a hand: an element of a scene."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters, in the order of the catalogue."""


def with_names(effects: Iterable[Effect]) -> list[Effect]:
    """The effects under names of their own: the second "filter" becomes "filter-2"."""
    listed = list(effects)
    taken = {effect.name for effect in listed}
    named: list[Effect] = []
    for effect in listed:
        name = effect.name
        if any(name == other.name for other in named):
            name = free_name(name, taken, "-")
            taken.add(name)
        named.append(replace(effect, name=name))
    return named


def symbol_names(
    elements: Iterable[tuple[str, HasParameters | None]],
) -> list[dict[Symbol, Symbol]]:
    """For each element, with its label, new symbols for those that another element names alike:
    ``zeta`` becomes ``zeta_filter``. None stands for an element that a scene does not have.

    The first element, which has the label "", is the environment: it keeps its names but for the
    threshold's, as ``c``, which becomes ``c_env``.
    """
    labelled = list(elements)
    # The thresholds' names count as used once, so that a parameter called c is always renamed.
    uses = Counter(_THRESHOLD_NAMES)
    for _, element in labelled:
        if element:
            uses.update(p.symbol.name for p in element.parameters)
    taken = set(uses)
    renamed: list[dict[Symbol, Symbol]] = []
    for label, element in labelled:
        suffix = "_" + re.sub(r"\W", "_", label or "env")
        new: dict[Symbol, Symbol] = {}
        for p in element.parameters if element else ():
            # A tied parameter is the environment's, which comes first: it follows that one's new
            # name.
            if p.tie:
                if p.symbol in renamed[0]:
                    new[p.symbol] = renamed[0][p.symbol]
                continue
            name = p.symbol.name
            may_change = label or name in _THRESHOLD_NAMES
            if may_change and uses[name] > 1:
                new[p.symbol] = Symbol(free_name(name + suffix, taken), **p.symbol.assumptions0)
        taken |= {x.name for x in new.values()}
        renamed.append(new)
    return renamed


@dataclass(frozen=True, repr=False)
class Scene(Shown):
    """A display to be evaluated: environment, effects, band, threshold and hands. Valid by
    construction: SceneError names what is wrong.

    ``environment`` : what should be felt. ``effects`` : nearest the environment first. ``band`` :
    lowest and highest frequency, numbers in rad/s or strings with a unit; in a scene rad/s, exact.
    ``threshold`` : a Threshold, or what a scene file has as its JND: a number, a formula or a
    table.
    ``rendered`` : what the controller really renders, where that is not the environment itself. A
    parameter of it may be the environment's: ``k="environment.k"`` is one parameter in two places,
    with one symbol, one value and one range.
    ``title``, ``source`` : words for pages. ``hands`` : those in which it may be held; they change
    nothing of what is felt.

    >>> from haptisym import effects, environments
    >>> scene = Scene(environments.mass_spring_damper(k=100), (effects.first_order_lag(20),), (Integer(0), Integer(15)))
    >>> scene.distortion().perceived
    2000/(s + 20)
    """

    environment: Environment
    effects: tuple[Effect, ...] = ()
    band: tuple[Any, Any] = (Integer(0), Integer(15))
    threshold: Any = Threshold()
    rendered: Environment | None = None
    title: str = ""
    source: str = ""
    hands: tuple[Hand, ...] = ()
    confidence: Any = None
    """The confidence with which its ranges together hold the true values, where they were
    estimated: 0.95 of a scene that ``identify`` wrote; None where they were not."""
    friction: Any = None
    """When friction is noticed, a FrictionThreshold or its table; None where the scene does not
    say."""
    text: str = field(default="", repr=False, compare=False)
    """The text of the file that it was read from, as it was then."""
    frequency: Unit = field(default=RADIANS, repr=False, compare=False)
    """The unit of frequency in which pages print: that in which the band is given."""

    def _line(self) -> str:
        between = ", ".join(effect.name for effect in self.effects) or "no effects"
        return (
            f"{titled(self.title)}: {self.environment.model}, {between}, {self.band[0]} to "
            f"{self.band[1]} rad/s"
        )

    def __getstate__(self) -> dict[str, Any]:
        """The fields alone: cached results hold what cannot be pickled, and are computed again."""
        return {x.name: getattr(self, x.name) for x in fields(self)}

    @spared()
    def __post_init__(self) -> None:
        # A frozen dataclass: fields are brought to their final form here, and never after.
        shown = self._read()
        low, high = self.band
        if sign_of_number(low) < 0:
            raise SceneError(f"band: the low end, {shown[0]}, must be >= 0")
        if sign_of_number(high - low) <= 0:
            raise SceneError(
                f"band: the high end, {shown[1]}, must be above the low end, {shown[0]}"
            )
        # References first: only then has every parameter of what is rendered a value and a motion.
        self._tie()
        _different(self.hands)
        _one_motion((*self.elements(), *self.held()))
        self.threshold.check(low, high, self.motion)
        of_friction = self.friction.motion if self.friction else None
        of_scene = self.motion
        if of_friction and of_scene and of_friction is not of_scene:
            raise SceneError(
                f"friction: its unit is {of_friction.value}, the scene {of_scene.value}"
            )
        # Symbols last, as suffixes are the names that effects have by then.
        self._name_symbols()

    def _read(self) -> list[str]:
        """Bring every field to its type; return the ends of the band as they were written, for
        messages."""
        put = partial(object.__setattr__, self)
        put("environment", given_environment("environment", self.environment))
        if self.rendered is not None:
            put("rendered", given_environment("rendered", self.rendered))
        put("effects", given_effects(self.effects))
        put("hands", given_hands(self.hands))
        put("band", given_band(self.band))
        shown = [f'"{x}"' if isinstance(x, str) else f"{x} rad/s" for x in self.band]
        # The unit is kept for pages before the band becomes numbers in rad/s.
        units = filter(None, map(frequency_unit, self.band))
        put("frequency", next(units, self.frequency))
        put("band", tuple(frequency("band", x) for x in self.band))
        if self.confidence is not None:
            put("confidence", read_confidence("confidence", self.confidence))
        if self.friction is not None:
            put("friction", read_friction(self.friction))
        if not isinstance(self.threshold, Threshold):
            put("threshold", read_threshold(self.threshold))
        return shown

    def _name_symbols(self) -> None:
        """Give every effect a name and every parameter a symbol of its own."""
        put = partial(object.__setattr__, self)
        effects = with_names(self.effects)
        named: list[Effect | Hand] = [*effects, *self.hands]
        labelled = [(x.name, x) for x in named]
        of_environment, of_rendered, *of_others = symbol_names(
            [("", self.environment), ("rendered", self.rendered), *labelled]
        )
        put("environment", self.environment.renamed(of_environment))
        if self.rendered:
            put("rendered", self.rendered.renamed(of_rendered))
        new = iter(of_others)
        effects = [effect.renamed(next(new)) for effect in effects]
        put("effects", with_controller(effects, self.rendered or self.environment))
        put("hands", tuple(hand.renamed(next(new)) for hand in self.hands))

    def _tie(self) -> None:
        """Resolve the references of what is rendered to the environment's parameters; SceneError
        for a reference anywhere else."""
        with within("environment"):
            refuse_references(self.environment.parameters)
            if self.environment.model == DIFFERENCE_EQUATION:
                raise SceneError(
                    f"{DIFFERENCE_EQUATION} is for [rendered]: write what should be felt in s"
                )
        if self.rendered:
            with within("rendered"):
                object.__setattr__(self, "rendered", self.rendered.tied_to(self.environment))

    def held(self) -> Iterator[tuple[str, Hand]]:
        """The hands, each with its place in a scene file: ``hand`` where there is one, else
        ``hands.NAME``."""
        yield from (("hand" if len(self.hands) == 1 else f"hands.{x.name}", x) for x in self.hands)

    def elements(self) -> Iterator[tuple[str, Environment | Effect]]:
        """Everything in the display that has parameters, with its place in a scene file."""
        yield "environment", self.environment
        if self.rendered is not None:
            yield "rendered", self.rendered
        for effect in self.effects:
            yield f"effects.{effect.name}", effect

    @cached_property
    def knobs(self) -> Knobs:
        """Everything that may be varied, by name: each parameter once, then the thresholds."""
        thresholds = threshold_knobs(self.threshold)
        settings = tuple(f"effects.{x.name}.{key}" for x in self.effects for key, _ in x.settings)
        return Knobs((*self._display_knobs(), *self._hand_knobs(), *thresholds), settings)

    def _hand_knobs(self) -> Iterator[Knob]:
        """The parameters of the hands; that of a single hand, ``hand.m``, by its name too."""
        for place, hand in self.held():
            for p in hand.parameters:
                also = (f"hands.{hand.name}.{p.key}",) if place == "hand" else ()
                as_parameter = vars(replace(p, motion=p.motion or self.motion))
                yield Knob(**as_parameter, place=place, model=hand.model, also=also)

    def _display_knobs(self) -> Iterator[Knob]:
        """The parameters of the display, each once."""
        rendered = self.rendered.parameters if self.rendered else ()
        for place, element in self.elements():
            for p in element.parameters:
                # A tied parameter is listed where it belongs, with the paths of all that refer to
                # it.
                if p.tie:
                    continue
                tied = [q for q in rendered if q.tie == f"{place}.{p.key}"]
                # A value must suit all its places: the strictest of their rules holds.
                rule = reduce(Rule.and_also, (q.rule for q in tied), p.rule)
                as_parameter = vars(replace(p, rule=rule, motion=p.motion or self.motion))
                also = tuple(f"rendered.{q.key}" for q in tied)
                yield Knob(**as_parameter, place=place, model=element.model, also=also)

    @property
    def parameters(self) -> tuple[Knob, ...]:
        """Every parameter of the display, once, with symbols that are unique in the scene; those of
        the hands are knobs alone."""
        return self.knobs.parameters

    def untied(self, varied: Collection[str] | None = None) -> tuple[tuple[str, str], ...]:
        """The parameters that environment and [rendered] have by one name but not tied: pairs of
        paths, of which one is among ``varied`` (None: all pairs)."""
        if not self.rendered:
            return ()
        own_keys = {p.key for p in self.rendered.own}
        pairs = []
        for p in self.environment.parameters:
            pair = f"environment.{p.key}", f"rendered.{p.key}"
            if p.key in own_keys and (varied is None or not set(varied).isdisjoint(pair)):
                pairs.append(pair)
        return tuple(pairs)

    def untied_note(self, varied: Collection[str] | None = None) -> str:
        """A note that these are two parameters each, and how to make them one; empty where there
        are none."""
        pairs = self.untied(varied)
        if not pairs:
            return ""
        listed = ", ".join(f"{a} and {b}" for a, b in pairs)
        ties = ", ".join(f'{b.partition(".")[2]} = "{a}"' for a, b in pairs)
        what = "two parameters" if len(pairs) == 1 else "two parameters each"
        return (
            f"{listed} are {what}: where one varies the other keeps its value. If they are one, "
            f"write {ties} in [rendered]."
        )

    def ranges(self, besides: Collection[str] = ()) -> dict[str, Knob]:
        """The knobs that have a range, by path, except those that ``besides`` lists by path
        (``evaluation.jnd`` stands for both thresholds)."""
        left_out = [self.knobs[path] for path in besides]
        parts_left_out = {part for x in left_out for part in x.parts}
        if parts_left_out:
            # One knob for both thresholds cannot stand for the one that is left.
            parts = [part for part in Part if part not in parts_left_out]
            limits = [self.knobs[f"{THRESHOLD}.{part.value}"] for part in parts]
        else:
            limits = list(self.knobs.limits.values())
        return {x.path: x for x in (*self.parameters, *limits) if x.interval and x not in left_out}

    def nominal_but(self, besides: Collection[str] = ()) -> str:
        """A note that an answer is about nominal values, with the ranges that it leaves out; empty
        where nothing else has a range. ``besides`` : paths of what the question varies."""
        # Parameters that vary by the same per cent share a phrase.
        names_by_range: dict[str, list[str]] = {}
        for x in self.ranges(besides).values():
            assert x.interval
            names_by_range.setdefault(
                spread(x.value, x.interval, x.shown_unit(x.motion)), []
            ).append(x.name)
        # The limits for changes to smaller values, the floor and the scale of a JND are no knobs:
        # they come from its region.
        if THRESHOLD not in besides:
            for name, (low, high) in self.threshold.region.ranges:
                by = f"from {float(low):.6g} to {float(high):.6g}"
                names_by_range.setdefault(by, []).append(f"{name} of the JND")
        if not names_by_range:
            return ""
        phrases = []
        for by, names in names_by_range.items():
            verb = "vary" if len(names) > 1 else "varies"
            phrases.append(f"{', '.join(names)} {verb} {by}")
        listed = "; ".join(phrases)
        what = "these are the nominal values" if besides else "this is the nominal scene"
        # ``tolerances`` examines boxes of numbers; a JND that no box describes is left to
        # ``evaluate``.
        if not self.threshold.is_box:
            return f"{listed}: {what}; `haptisym evaluate` prints which bandwidths the JND gives."
        return f"{listed}: {what}; see `haptisym tolerances`."

    def asides(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> list[str]:
        """The notes to print with an answer: what is estimated, what is nominal, and which of the
        ``varied`` parameters (None: all) exist twice."""
        nominal = self.nominal_but(besides)
        # One sentence for a fitted scene, whose ranges are many and stand in its file.
        ranges = self.estimated(is_nominal=bool(nominal)) if self.level is not None else nominal
        return [x for x in (ranges, self.untied_note(varied)) if x]

    def aside_keys(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> dict[str, Any]:
        """The notes as keys of a JSON document; a key that would be empty is left out.

        ``confidence`` ; ``nominal``, ranges by path; ``untied``, pairs of paths.
        """
        intervals = {path: x.interval or () for path, x in self.ranges(besides).items()}
        for name, interval in self.threshold.region.ranges:
            intervals[f"{THRESHOLD}.{name}"] = interval
        keys: dict[str, Any] = {}
        if self.level is not None:
            keys["confidence"] = float(self.level)
        if intervals:
            keys["nominal"] = {path: [float(end) for end in x] for path, x in intervals.items()}
        if untied := self.untied(varied):
            keys["untied"] = [list(pair) for pair in untied]
        return keys

    @property
    def level(self) -> Expr | None:
        """The confidence, at least, with which all estimated ranges together hold the true values;
        None where nothing was estimated.

        Of two estimates, the scene's with confidence p and its JND's with confidence q, both sets
        of ranges are right with a probability of at least 1 - (1 - p) - (1 - q) (Bonferroni's
        inequality), however they depend on each other, and of no more where they are never wrong
        together.
        """
        given = (self.confidence, self.threshold.confidence)
        doubts = [1 - x for x in given if x is not None]
        return Max(0, 1 - sum(doubts)) if doubts else None

    @property
    def region_of_fit(self) -> str:
        """What the ranges of a fitted scene are: ``95 % region of the fit``; empty for one that was
        not fitted."""
        return "" if self.level is None else f"{float(100 * self.level):g} % region of the fit"

    def estimated(self, *, is_nominal: bool) -> str:
        """A note that the numbers of a scene were estimated; ``is_nominal`` : that the answer is
        about one value of each, with the command that is about all."""
        numbers = f"The numbers of this scene are estimates ({self.region_of_fit})"
        if not is_nominal:
            return f"{numbers}."
        command = "for all values in the region: `haptisym tolerances`"
        if not self.threshold.is_box:
            command = "`haptisym evaluate` prints which bandwidths the JND gives"
        return f"{numbers}, here at their nominal values; {command}."

    @property
    def motion(self) -> MotionKind | None:
        """The kind of motion that the units of the display imply, along a line or about an axis;
        None where none does."""
        for _, element in self.elements():
            for p in element.parameters:
                if p.motion is not None:
                    return p.motion
        return None

    def distortion(self) -> Distortion:
        """The closed forms with every parameter's value in place. SceneError in free air, where
        H_env is zero."""
        if self.closed.env.is_zero:
            raise SceneError(NOTHING_TO_FEEL)
        return self.closed

    @cached_property
    def closed(self) -> Distortion:
        """The closed forms with every parameter's value in place for questions about H_perc alone,
        in free air too."""
        return felt_instead(self.environment, self.effects, self.rendered)

    def symbolic_distortion(self) -> Distortion:
        """The closed forms with every parameter a symbol."""
        measured = dimensions((p.symbol, p.dimension) for p in self.parameters)
        return replace(Distortion.of(self.chain), dimensions=measured)

    @property
    def chain(self) -> Chain:
        """The dynamics of environment and effects with every parameter a symbol."""
        return Chain(
            self.environment.dynamics,
            self.rendering.dynamics,
            tuple(e.dynamics for e in self.effects),
        )

    @property
    def rendering(self) -> Environment:
        """What the controller renders, in s: [rendered] where the scene has it, else the
        environment; a difference equation with z = exp(s T)."""
        return (self.rendered or self.environment).seen_by(self.effects)

    def with_values(self, values: Mapping[str, Number]) -> Scene:
        """The same scene with other values for some parameters or thresholds, each by any name that
        ``knobs`` knows.

        Raises SceneError for a name that the scene does not have, and for a value that the model
        does not allow.

        >>> from haptisym.model.scenefile import load_scene
        >>> load_scene("fu2019").with_values({"omega_n": "40 Hz"}).effects[0].matrix[0]
        6400*pi**2/(s**2 + 80*pi*s + 6400*pi**2)
        """
        # All values are checked before any is put in, so that errors name paths of this scene.
        given = dict(zip(self.knobs.chosen(values), values.values(), strict=True))
        for knob, value in given.items():
            knob.check(value)
        # Symbols are unique in a scene, and tied parameters share one: by its name a value reaches
        # all its places.
        named = {knob.name: value for knob, value in given.items() if not knob.parts}
        limits = {part: value for knob, value in given.items() for part in knob.parts}
        return replace(
            self,
            environment=self.environment.with_values(named),
            effects=tuple(effect.with_values(named) for effect in self.effects),
            rendered=self.rendered.with_values(named) if self.rendered else None,
            hands=tuple(hand.with_values(named) for hand in self.hands),
            threshold=self.threshold.with_limits(limits),
        )

    def with_hands(self, *hands: Hand) -> Scene:
        """The same scene in these hands."""
        return replace(self, hands=hands)

    def at_proportion(self, end: Number) -> Scene:
        """The same scene with its threshold at another proportion of right answers; SceneError
        where the threshold's own is not given."""
        with within("jnd"):
            return replace(self, threshold=self.threshold.at_proportion(end))

    def with_band(self, low: Number, high: Number) -> Scene:
        """The same scene on another band, rad/s or with a unit."""
        return replace(self, band=(low, high))


def in_hands(scene: Scene, hand: str | Hand | Iterable[str | Hand] | None) -> Scene:
    """The scene in the hands that are asked about; as it is where none is. SceneError for one that
    is unknown, or there twice."""
    if hand is None:
        return scene
    asked = [
        chosen_hand(scene, x)
        for x in (
            [hand]
            if isinstance(hand, str | Hand)
            else several("hand", hand, "give a name, a Hand, or several")
        )
    ]
    for name in (x.name for i, x in enumerate(asked) if x.name in [y.name for y in asked[:i]]):
        raise SceneError(f'the hand "{name}" is asked about twice')
    return scene.with_hands(*asked)


def chosen_hand(scene: Scene, given: str | Hand) -> Hand:
    """A hand by its name, the scene's own before one that the package ships; "none" is one that
    holds nothing, and ``postural-arm at 15 cm`` one that holds a lever."""
    if isinstance(given, Hand):
        return given
    own = {x.name: x for x in scene.hands}
    known = {**hands, NOBODY: Hand(NOBODY), **own}
    if given in known:
        return known[given]
    bare, _, lever = str(given).partition(AT)
    if lever and bare in known:
        return known[bare].on_lever(lever)
    theirs = f"the scene has {', '.join(own)}; " if own else ""
    listed = f"{theirs}the package ships {', '.join(hands)}, and {NOBODY} is no hand"
    raise SceneError(
        f'there is no hand "{str(given)[:60]}": {meant(str(given), [*own, *hands])}{listed}'
    )


def frequency(key: str, given: Number) -> Expr:
    """An exact frequency, rad/s."""
    with within(key):
        return number(given, Dimension.FREQUENCY).value


def frequency_unit(given: Any) -> Unit | None:
    """The unit that a frequency is given in; None of a bare number, and of what is no frequency.

    >>> frequency_unit("15 Hz"), frequency_unit(15) is None
    (Unit(name='Hz', size=2*pi), True)
    """
    if not isinstance(given, str):
        return None
    # What is wrong with it is said where the frequency itself is read.
    with suppress(SceneError):
        read = number(given, Dimension.FREQUENCY)
        return read.unit or (RADIANS if read.exponents else None)
    return None


def _different(hands: Iterable[Hand]) -> None:
    """SceneError where two hands have one name."""
    for name, times in Counter(x.name for x in hands).items():
        if times > 1:
            raise SceneError(f'hands: "{name}" is there twice: give each hand another name')


def _one_motion(elements: Iterable[tuple[str, Environment | Effect | Hand]]) -> None:
    """SceneError where units of translation and of rotation meet."""
    # The first parameter of each motion, by its path, for the message. One without a unit fits
    # both.
    first: dict[MotionKind, str] = {}
    turning = Dimension.ANY
    for place, element in elements:
        for parameter in element.parameters:
            if parameter.motion is not None:
                first.setdefault(parameter.motion, f"{place}.{parameter.key}")
            if parameter.motion is MotionKind.ROTATION and turning is Dimension.ANY:
                turning = parameter.dimension
    if len(first) > 1:
        units = ", ".join(f"{path} is {motion.value}" for motion, path in first.items())
        way = "; a hand on a lever: --lever, or lever in [hand]" if "hand" in units else ""
        # Nm is written for N/m.
        if turning in _TORQUES and not way:
            word = _TORQUES[turning]
            about, along = (turning.unit(x) for x in (MotionKind.ROTATION, MotionKind.TRANSLATION))
            way = f"; {word} is read as {about}: along a line write {along}"
        raise SceneError(f"translation and rotation cannot be mixed: {units}{way}")


_TORQUES = {Dimension.STIFFNESS: "Nm", Dimension.DAMPING: "Nms"}


# Samplers. A sampler takes and holds values at multiples of its period T; ``CLOCKS`` are the models
# of the catalogue that do.


def clocks(scene: Scene) -> tuple[Expr, ...]:
    """The sampling periods of a display's samplers, s, in the order of its effects."""
    return tuple(
        x.value
        for effect in scene.effects
        if effect.model in CLOCKS
        for x in effect.parameters
        if x.key == "T"
    )


def unclocked(scene: Scene) -> Scene:
    """The scene without its first sampler and all before it, where these give no force at any value
    of the symbols in them; else the scene itself."""
    first_sampler = next((i for i, x in enumerate(scene.effects) if x.model in CLOCKS), None)
    if first_sampler is None:
        return scene
    # With H = 0 rendered and B = 0 in every matrix before the sampler, (A H + B)/(C H + D) up to it
    # is 0: the sampler holds no force. Its own B is 0 too: a hold is in series, and the D(z) of a
    # sampled loop that renders H = 0 is 0.
    before = scene.effects[:first_sampler]
    if scene.rendering.H != 0 or any(x.matrix[1] != 0 for x in before):
        return scene
    behind = scene.effects[first_sampler + 1 :]
    return replace(scene, environment=scene.rendering, rendered=None, effects=behind)


def sampled_loop(scene: Scene) -> tuple[Effect, Effect] | None:
    """A sampler that holds a force, and the element that brings this back to a sampler: a
    compliance (C is not 0) or another sampler beyond it. None where there is no such pair.

    Images of the samples then fold back into the band. The closed form (1 - exp(-s T))/(s T) leaves
    them out, and its poles are not those of the sampled loop.
    """
    # Effects are in order from the environment on: those after the sampler lie towards the hand.
    for i, effect in enumerate(scene.effects):
        if effect.model not in CLOCKS:
            continue
        for other in scene.effects[i + 1 :]:
            if other.model in CLOCKS or other.dynamics[2] != 0:
                return effect, other
    return None


# Caveats.


def caveats(scene: Scene) -> tuple[str, ...]:
    """The limits of exact answers about a scene, a sentence for each: thresholds of 100 % and more,
    bands beyond a Nyquist frequency, samplers within a loop, samplers in a hand, delayed admittance
    displays. () where there is none."""
    return (
        *_large_thresholds(scene),
        *_beyond_nyquist(scene),
        *_sampled_inside(scene),
        *_sampled_in_hand(scene),
        *_late_mass(scene),
        *first_harmonics(scene),
    )


def _sampled_inside(scene: Scene) -> list[str]:
    """A caveat where a sampled loop is closed inside the display."""
    pair = sampled_loop(scene)
    if pair is None:
        return []
    hold, other = (x.name for x in pair)
    words = (
        f"{hold} holds a force that {other} returns to a sampler: images of the samples fold "
        f"back into the band, and the "
        "closed form leaves them out. It is an approximation here, and does not decide "
        "whether the sampled loop is stable; "
        "haptisym stability decides that in a hand, haptisym simulate runs the loop."
    )
    return [words]


def _sampled_in_hand(scene: Scene) -> list[str]:
    """A caveat for all samplers: a hand closes the sampled loop, which may be unstable however
    stable the force under prescribed motion is."""
    samplers = [x.name for x in scene.effects if x.model in CLOCKS]
    if not samplers:
        return []
    return [
        (
            f"sampled ({', '.join(samplers)}): for prescribed motion; a hand closes the loop "
            f"(haptisym stability)."
        )
    ]


def _beyond_nyquist(scene: Scene) -> list[str]:
    """A caveat for each sampler whose Nyquist frequency pi/T is below the band's high end."""
    high = scene.band[1]
    words = []
    for effect in scene.effects:
        if effect.model not in CLOCKS:
            continue
        # The one parameter of a sampler is its period T.
        nyquist = pi / effect.parameters[0].value
        if nyquist.free_symbols or sign_of_number(high - nyquist) <= 0:
            continue
        words.append(
            f"The band exceeds {float(nyquist / scene.frequency.size):.5g} "
            f"{scene.frequency.text}, the Nyquist frequency of {effect.name}: "
            "above it a motion is sampled as one of a lower frequency, and the closed form gives "
            "the component at the motion's "
            "frequency only."
        )
    return words


def _large_thresholds(scene: Scene) -> list[str]:
    """A caveat for each threshold of 100 % or more: most likely per cent were meant."""
    if scene.threshold.region.corners:
        return []
    large: dict[Rational, list[str]] = {}
    for part, name in ((Part.REAL, "real"), (Part.IMAG, "imaginary")):
        c = scene.threshold[part]
        if isinstance(c, Rational) and c >= 1:
            large.setdefault(c, []).append(name)
    return [
        f"The threshold of the {' and the '.join(names)} part is {float(100 * c):.5g} % of "
        '|H_env|: a JND of 12 % is written 0.12 or "12 %".'
        for c, names in large.items()
    ]


def first_harmonics(scene: Scene, *, in_hand: bool = False) -> list[str]:
    """A caveat for elements that stand for their first harmonic at one amplitude, a linear model:
    of the element itself nothing is proven.

    Friction counts ``in_hand`` alone. It takes energy only, so that no passivity rests on its
    model; where the poles of a loop lie does.
    """
    described = [x for x in scene.effects if x.model in DESCRIBED]
    others = [x for x in described if x.model != FRICTION]
    names = ", ".join(x.name for x in (described if in_hand else others))
    if not names:
        return []
    verdicts = "verdicts on stability and passivity" if others else "verdicts in a hand"
    words = (
        "by the describing function for one sine of its amplitude, which leaves out all harmonics; "
        f"{verdicts} are those of this linear model."
    )
    return [f"{names}: {words}"]


def _late_mass(scene: Scene) -> list[str]:
    """A caveat for delays of an admittance display: people report more mass, step 2 less."""
    models = {x.model for x in scene.effects}
    if not {"admittance-display", "delay"} <= models:
        return []
    words = (
        "People who pushed a mass of 6 kg off a delayed admittance display reported more "
        "mass, 10 % at 25 ms and 20 % at 50 ms "
        "(PLoS ONE 10(9), e0138012; as m T/(T - tau) with a push of T = 275 to 300 ms), "
        "where step 2 gives less."
    )
    return [words]
