"""Step 2 of the evaluation: as which mechanical property a noticeable distortion is felt, and
whether as more or less of it; friction among them.

A property is read off signs alone: Re H > 0 is stiffness, Re H < 0 mass, Im H > 0 damping; more or
less is the sign of |H_perc|^2 - |H_env|^2 of that part. All signs come from the chart of step 1, so
that percepts are proven on whole intervals. Begin with ``find_percepts``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

from sympy import Add, Expr

from haptisym.judge.crossings import NEARER, Criterion, PerceptFunction, judged
from haptisym.kernel.objects import Shown
from haptisym.kernel.roots import Chart, Interval, Point, Signs, sign_of_number
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene


class Property(Enum):
    """What the distorted part of the dynamics feels like (section 2.3): Im H is damping, or
    friction; Re H stiffness where it is positive and mass where it is negative, from one to the
    other where its sign is not the environment's."""

    STIFFNESS = "stiffness"
    MASS = "mass"
    STIFFNESS_TO_MASS = "stiffness-to-mass"
    MASS_TO_STIFFNESS = "mass-to-stiffness"
    DAMPING = "damping"
    FRICTION = "friction"


class Change(Enum):
    """How the perceived magnitude of a part compares with the environment's: |Re H_perc| with |Re
    H_env|, or the same of the imaginary parts."""

    HIGHER = "higher"
    LOWER = "lower"
    EQUAL = "equal"


@dataclass(frozen=True, repr=False)
class Percept(Shown):
    """Step 2: how what exceeds its threshold on a whole piece of the band is felt.

    ``part`` : ``Part.REAL`` or ``Part.IMAG``, whose ratio exceeds its threshold on all of ``band``;
    None where both are noticed together, neither by itself; ``property`` and ``change`` are then of
    the part that is nearer its own limit, and ``other`` is how the other one has changed.
    ``band`` : an ``Interval``, rad/s, on which neither ``property`` nor ``change`` changes.
    ``property`` : of the real part stiffness where Re H is positive in both, mass where it is
    negative in both, else from one to the other; of the imaginary part damping. ``change`` : higher
    or lower, by the magnitudes of that part. Source: Fu, van Paassen and Mulder (2019), section 2.

    >>> import haptisym as hs
    >>> [(x.part.value, x.property.value, x.change.value) for x in hs.evaluate("fu2019").percepts]
    [('real', 'mass', 'lower'), ('imag', 'damping', 'higher')]
    """

    part: Part | None
    band: Interval
    property: Property
    change: Change
    other: tuple[Property, Change] | None = None

    def _line(self) -> str:
        low, high = (x.omega.digits(5) for x in (self.band.low, self.band.high))
        which = f"{self.part.value} part" if self.part else "both parts together"
        return f"{felt(self)} ({which}) from {low} to {high} rad/s"


class Felt(NamedTuple):
    """An interval of the band on which a part, or None for both together, is noticed, and as what
    it is felt, in words."""

    part: Part | None
    band: Interval
    words: str


NOT_NAMED = "noticed (active)"
"""The words where the imaginary part is noticed while Im H_perc < 0: the paper's model has no
property for that."""

_OF_IMAG = (Property.DAMPING, Property.FRICTION)
_EXCHANGED = {
    Property.STIFFNESS_TO_MASS: "mass instead of stiffness",
    Property.MASS_TO_STIFFNESS: "stiffness instead of mass",
}


def felt(percept: Percept) -> str:
    """The words for a percept, the same in text, pages, figures and LaTeX: "lower mass".

    Where a property takes the place of another, the magnitudes compared are those of the force.
    """
    words = felt_words(percept.property, percept.change)
    return words if percept.other is None else f"{felt_words(*percept.other)} and {words}"


def felt_of(percept: Percept, part: Part) -> str:
    """The words for one part of what is noticed of both together."""
    labels = [(percept.property, percept.change), *([percept.other] if percept.other else [])]
    return next(felt_words(*x) for x in labels if (x[0] in _OF_IMAG) == (part is Part.IMAG))


def felt_words(what: Property, change: Change) -> str:
    """The words for a property and its change."""
    if what is Property.FRICTION:
        return "friction"
    exchanged = _EXCHANGED.get(what)
    return (
        f"{exchanged}, with {change.value} force" if exchanged else f"{change.value} {what.value}"
    )


def find_felt(chart: Chart) -> tuple[Felt, ...]:
    """Everything that is noticed on the band, part by part: the percepts, and the intervals on
    which no property is named."""
    named = [Felt(p.part, p.band, felt(p)) for p in find_percepts(chart)]
    part = None if _joint(chart) else Part.IMAG
    rows = [*named, *(Felt(part, band, NOT_NAMED) for band in unnamed(chart))]
    return tuple(sorted(rows, key=lambda x: (_ORDER.index(x.part), float(x.band.low.omega))))


_ORDER = (Part.REAL, Part.IMAG, None)


def find_percepts(chart: Chart) -> tuple[Percept, ...]:
    """The pieces of the band where a ratio exceeds its threshold, split where property or change
    changes.

    Proven by signs on whole intervals, never sampled. No damping percept is claimed where Im H_perc
    < 0. Of a region that judges both parts at once a part is named where it alone would be outside,
    and both together where neither would.
    """
    # A joint region has one criterion, of which each part, and both together, may be noticed.
    joint = _joint(chart)
    noticed = [_Noticed(x, x.part) for x in judged(chart) if x.part]
    if joint:
        noticed = [_Noticed(joint, part) for part in _ORDER]
    return tuple(percept for x in noticed for percept in _percepts(chart, x))


def _joint(chart: Chart) -> Criterion | None:
    """The criterion that judges both parts at once; None where each is judged by itself."""
    return next((x for x in judged(chart) if x.joint), None)


_Label: TypeAlias = tuple[tuple[Property, Change], tuple[Property, Change] | None]
"""Property and change of a part, and of the other one where both are noticed together."""


class _Noticed(NamedTuple):
    """One thing that may be noticed where a criterion is broken: one part, or both together
    (None)."""

    criterion: Criterion
    part: Part | None

    def at(self, signs: Signs) -> bool:
        """Whether it is noticed where the functions have these signs."""
        if signs[self.criterion] <= 0:
            return False
        if not self.criterion.joint:
            return True
        # Outside of a joint region: a part is noticed if it alone would be outside, both together
        # only if neither would.
        alone = [signs[PerceptFunction.OUTSIDE, part] > 0 for part in Part]
        return not any(alone) if self.part is None else alone[self.part is Part.IMAG]

    def label(self, signs: Signs) -> _Label | None:
        """How it is felt; None where it is not noticed, or no property is named."""
        if not self.at(signs):
            return None
        if self.part:
            of_part = self._of(signs, self.part)
            return of_part and (of_part, None)
        # Both together: named only if both parts have a name. The nearer part comes first.
        real, imag = (self._of(signs, part) for part in Part)
        if real is None or imag is None:
            return None
        return (real, imag) if signs[NEARER] > 0 else (imag, real)

    def _of(self, signs: Signs, part: Part) -> tuple[Property, Change] | None:
        """How one part is felt: as friction where nothing would be noticed without the friction."""
        label = _label(signs, part)
        without = signs.get((PerceptFunction.WITHOUT_FRICTION, self.criterion), 1)
        is_friction = part is Part.IMAG and without <= 0
        return (Property.FRICTION, label[1]) if label and is_friction else label


def _percepts(chart: Chart, noticed: _Noticed) -> list[Percept]:
    """Maximal runs of cells with one label, over points at which the same is still noticed."""
    runs: list[Percept] = []
    for low, high in pairwise(chart.points):
        label = noticed.label(low.after)
        if label is None:
            continue
        # Two cells are one percept only if the point between them belongs to it: where a ratio is
        # tangent to its threshold from above, nothing is noticed at that point.
        last = runs[-1] if runs else None
        main, other = label
        is_adjacent = last is not None and last.band.high is low
        if (
            last
            and is_adjacent
            and (last.property, last.change, last.other) == (*main, other)
            and noticed.at(low.at)
        ):
            runs[-1] = replace(last, band=Interval(last.band.low, high))
        else:
            runs.append(Percept(noticed.part, Interval(low, high), *main, other))
    return runs


_CHANGES = {1: Change.HIGHER, -1: Change.LOWER, 0: Change.EQUAL}


def _label(signs: Signs, part: Part) -> tuple[Property, Change] | None:
    """Property and change of a part; None where Im H_perc < 0, for which no property is named."""
    environment = signs[PerceptFunction.ENVIRONMENT, part]
    perceived = signs[PerceptFunction.PERCEIVED, part]
    if part is Part.IMAG and perceived < 0:
        return None
    # |p|^2 - |e|^2 = (p - e)(p + e)
    compared = signs[PerceptFunction.DIFFERENCE, part] * signs[PerceptFunction.SUM, part]
    kind = Property.DAMPING if part is Part.IMAG else real_property(environment, perceived)
    return kind, _CHANGES[compared]


def real_property(env: int, perc: int) -> Property:
    """The property of the real part from the signs of Re H_env and Re H_perc. One that is zero
    throughout takes the sign of the other: nothing becomes something of the same kind."""
    return _SIDES[env or perc, perc or env]


_SIDES = {
    (1, 1): Property.STIFFNESS,
    (-1, -1): Property.MASS,
    (1, -1): Property.STIFFNESS_TO_MASS,
    (-1, 1): Property.MASS_TO_STIFFNESS,
}


def changeovers(chart: Chart, curve: PerceptFunction) -> tuple[Point, ...]:
    """Where Re H_env (or Re H_perc) changes its sign: a spring below, inertia above, or back."""
    return chart.sign_changes((curve, Part.REAL))


def outside_model(chart: Chart) -> tuple[Interval, ...]:
    """Where Im H_perc < 0: the display is active there, which the paper's model excludes."""
    return chart.where(lambda signs: signs[PerceptFunction.PERCEIVED, Part.IMAG] < 0)


def unnamed(chart: Chart) -> tuple[Interval, ...]:
    """The intervals on which Im H_perc < 0 and the imaginary part is noticed, alone or together
    with the real one: no property is named for it there."""
    joint = _joint(chart)
    if joint:
        noticed = [_Noticed(joint, None), _Noticed(joint, Part.IMAG)]
    else:
        noticed = [_Noticed(x, x.part) for x in judged(chart) if x.part is Part.IMAG]

    def is_unnamed(signs: Signs) -> bool:
        is_active = signs[PerceptFunction.PERCEIVED, Part.IMAG] < 0
        return is_active and any(x.at(signs) for x in noticed)

    return chart.where(is_unnamed)


_MODEL = "coulomb-friction"


@dataclass(frozen=True)
class Friction:
    """The display's Coulomb friction, judged by a threshold of its own.

    ``force`` : of all elements together, N or N m. ``reference`` : the force that it is compared
    with. ``least`` : the difference from it above which friction is noticed. ``noticed`` : None
    where the scene has no such threshold; ``reference`` and ``least`` are then None too.
    """

    force: Expr
    reference: Expr | None
    least: Expr | None
    noticed: bool | None

    def row(self) -> dict[str, Any]:
        """The friction as a part of a document, N or N m."""
        numbers = {"force": self.force, "reference": self.reference, "threshold": self.least}
        return {key: None if x is None else float(x) for key, x in numbers.items()} | {
            "noticed": self.noticed
        }


def frictions(scene: Scene) -> Friction | None:
    """The friction of a scene with numbers; None without any."""
    elements = [e for e in scene.effects if e.model == _MODEL]
    forces = [x.value for e in elements for x in e.parameters if x.key == "force"]
    if not forces:
        return None
    force, threshold = Add(*forces), scene.friction
    if threshold is None:
        return Friction(force, None, None, None)
    # |force - reference|, by an exact sign
    change = force - threshold.reference
    size = change if sign_of_number(change) >= 0 else -change
    is_noticed = sign_of_number(size - threshold.least) > 0
    return Friction(force, threshold.reference, threshold.least, is_noticed)


def without_friction(scene: Scene) -> Scene:
    """The scene without its friction."""
    return replace(scene, effects=tuple(x for x in scene.effects if x.model != _MODEL))
