"""Everything in a scene that a question may vary, by one set of names: the numbers of its elements, and the thresholds."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol, TypeVar

from sympy import Expr

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.rings import c, omega
from haptisym.model.jnd import Part, Threshold, threshold_value
from haptisym.model.parameters import Parameter, Rule, Slot, read_parameter
from haptisym.model.quantities import Dimension, Number, number

THRESHOLD = "evaluation.jnd"
"""The path of both thresholds as one."""

SceneT = TypeVar("SceneT", bound="HasKnobs")


class HasKnobs(Protocol):
    """A scene, as far as it is needed here."""

    def with_values(self: SceneT, values: dict[str, Number]) -> SceneT:
        """The same scene with other values of some numbers, by path."""


@dataclass(frozen=True, repr=False)
class Knob(Parameter):
    """A number of a scene: ``value`` in SI, its ``rule`` and, where the scene gives one, its range ``interval``.

    ``place``: in a scene file, ``environment``, ``effects.filter``, ``evaluation``; ``model``: of what has it. ``motion``: the
    scene's. ``also``: the paths of what refers to it. ``parts``: of a threshold those whose it is; its symbol is c.
    """

    place: str = ""
    model: str = ""
    also: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()

    @property
    def path(self) -> str:
        """``effects.filter.omega_n``."""
        return f"{self.place}.{self.key}"

    @property
    def paths(self) -> tuple[str, ...]:
        """Its own path and those of what refers to it."""
        return self.path, *self.also

    @property
    def is_of_hand(self) -> bool:
        """Whether it is a hand's, which changes nothing of what is felt."""
        return self.model == "hand"

    def felt(self) -> Knob:
        """The same; SceneError for a hand's, of which what is felt holds nothing."""
        if self.is_of_hand:
            raise SceneError(f"{self.path} changes nothing of what is felt: haptisym stability tells what it changes")
        return self

    @property
    def name(self) -> str:
        """The name of its symbol; ``c_real`` and ``c_imag`` tell the thresholds of the parts apart."""
        return f"c_{self.parts[0].value}" if len(self.parts) == 1 else self.symbol.name

    @property
    def unit(self) -> str:
        """The name of its unit; ``SI`` where none is known."""
        return self.unit_in(self.motion) or "SI"

    def number(self, given: Number) -> Expr:
        """A number for it, SI, exact; SceneError for a unit that does not fit, and for a symbol."""
        try:
            read = number(given, self.dimension)
        except SceneError as error:
            raise error.within(self.path) from None
        if read.motion and self.motion and read.motion is not self.motion:
            raise SceneError(f'{self.path}: "{given}" is {read.motion.value}, but the scene is {self.motion.value}')
        return read.value

    def check(self, given: Number) -> None:
        """SceneError, with the path, unless its rule allows the value: a number, a range or a symbol."""
        if self.parts:
            threshold_value(self.path, given)
        else:
            read_parameter(self.path, given, Slot(self.dimension, self.rule), self.symbol.name)

    def put(self, scene: SceneT, given: Number) -> SceneT:
        """The scene with this value for it; SceneError where the model does not allow it."""
        return scene.with_values({self.path: given})


def threshold_knobs(threshold: Threshold) -> tuple[Knob, ...]:
    """Both thresholds as one (the value is the real part's), then each; none of a polygon, which is given by its corners."""
    if threshold.region.corners:
        return ()
    keys = {"jnd": tuple(Part), **{f"jnd.{part.value}": (part,) for part in Part}}
    return tuple(
        Knob(
            c, threshold[parts[0]], Dimension.RATIO, key=key, rule=Rule.POSITIVE, interval=threshold.interval(parts[0]),
            place="evaluation", parts=parts,
        )
        for key, parts in keys.items()
    )  # fmt: skip


@dataclass(frozen=True)
class Knobs(Collection[Knob]):
    """The knobs of a scene, the thresholds last: three, of which ``evaluation.jnd`` is the other two as one.

    ``knobs[name]``: by path, by the name of a symbol (``c`` the threshold), or by the end of a path, where that is unique.

    >>> from haptisym.model.scenefile import load_scene
    >>> knobs = load_scene("fu2019").knobs
    >>> {knobs[x].path for x in ("omega_n", "filter.omega_n", "effects.filter.omega_n")}, knobs["c"].path
    ({'effects.filter.omega_n'}, 'evaluation.jnd')
    """

    all: tuple[Knob, ...]

    def __iter__(self) -> Iterator[Knob]:
        return iter(self.all)

    def __len__(self) -> int:
        return len(self.all)

    def __contains__(self, knob: object) -> bool:
        return knob in self.all

    def __getitem__(self, name: str) -> Knob:
        given = str(name)
        named = [x for x in self if given == x.name]
        ended = [x for x in self if any(path.endswith(f".{given}") for path in x.paths)]
        if any(x.parts for x in named):  # a number of the scene that is written c as well is no threshold
            named = [x for x in self if x in named or x in ended]
        found = [x for x in self if given in x.paths] or named or ended
        if len(found) > 1:
            raise SceneError(f'"{given}" may be {" or ".join(x.path for x in found)}: give the path')
        if not found:
            paths = [path for x in self for path in x.paths]
            hint = meant(given, [*paths, *(x.name for x in self)])
            raise SceneError(f'the scene has no parameter "{given[:60]}": {hint}valid are {", ".join(paths)}')
        return found[0]

    @property
    def parameters(self) -> tuple[Knob, ...]:
        """Those of the display: all but the thresholds and the hands'."""
        return tuple(x for x in self if not x.parts and not x.is_of_hand)

    @property
    def limits(self) -> dict[Part, Knob]:
        """Of each part the threshold: one for both where they are alike, else its own; none of a polygon."""
        found = [x for x in self if x.parts]
        if not found:
            return {}
        both, *each = found
        alike = len({(x.value, x.interval) for x in each}) == 1
        return {part: both if alike else own for part, own in zip(Part, each, strict=True)}

    def chosen(self, names: Iterable[str]) -> tuple[Knob, ...]:
        """Several, each by its name; SceneError where two names mean one number."""
        found: list[Knob] = []
        for knob in map(self.__getitem__, names):
            for other in found:
                if other.path == knob.path:
                    raise SceneError(f"{knob.path} is given twice")
                if set(other.parts) & set(knob.parts):
                    raise SceneError(
                        f"{THRESHOLD} is both thresholds: give it, or {THRESHOLD}.real and {THRESHOLD}.imag"
                    )
            found.append(knob)
        return tuple(found)

    def need_numbers(self, besides: Collection[Knob] = ()) -> None:
        """SceneError where one that is not ``besides`` is a symbol."""
        for x in self:
            if x.value.free_symbols - {omega} and x not in besides:
                raise SceneError(
                    f"{x.path} = {x.value} is a symbol where a number is needed: put one in, as by "
                    f'with_values({{"{x.path}": ...}}); derive and distort answer in symbols'
                )
