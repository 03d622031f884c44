"""Step 2, how: as which mechanical property a noticeable distortion is felt, and as more or less of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import NamedTuple

from haptisym.judge.criteria import Criterion, judged
from haptisym.judge.crossings import Curve
from haptisym.kernel.roots import Chart, Interval, Point, Signs
from haptisym.kernel.shown import Shown
from haptisym.model.jnd import Part


class Property(Enum):
    """What the distorted part of the dynamics feels like (section 2.3)."""

    STIFFNESS = "stiffness"
    MASS = "mass"
    STIFFNESS_TO_MASS = "stiffness-to-mass"
    MASS_TO_STIFFNESS = "mass-to-stiffness"
    DAMPING = "damping"


class Change(Enum):
    """How the magnitude felt compares with the environment's."""

    HIGHER = "higher"
    LOWER = "lower"
    EQUAL = "equal"


@dataclass(frozen=True, repr=False)
class Percept(Shown):
    """On this whole piece of the band the part's ratio exceeds its threshold, and this is how that is felt."""

    part: Part
    band: Interval
    property: Property
    change: Change

    def _line(self) -> str:
        low, high = (x.omega.digits(5) for x in (self.band.low, self.band.high))
        return f"{felt(self)} ({self.part.value} part) from {low} to {high} rad/s"


class Felt(NamedTuple):
    """A piece of the band on which a part is noticed, and as what it is felt, in words."""

    part: Part
    band: Interval
    words: str


NOT_NAMED = "noticed, not named"
"""What is said where the imaginary part is noticed while Im H_perc < 0: the paper's model has no property for that."""

_EXCHANGED = {
    Property.STIFFNESS_TO_MASS: "mass instead of stiffness",
    Property.MASS_TO_STIFFNESS: "stiffness instead of mass",
}


def felt(percept: Percept) -> str:
    """The words for a percept, the same in text, pages, figures and LaTeX: "lower mass".

    Where a property takes the place of another, the magnitudes compared are those of the force.
    """
    exchanged = _EXCHANGED.get(percept.property)
    if exchanged:
        return f"{exchanged}, with {percept.change.value} force"
    return f"{percept.change.value} {percept.property.value}"


def find_felt(chart: Chart) -> tuple[Felt, ...]:
    """Everything that is noticed on the band, part by part: the percepts, and where no property is named."""
    named = [Felt(p.part, p.band, felt(p)) for p in find_percepts(chart)]
    rows = [*named, *(Felt(Part.IMAG, band, NOT_NAMED) for band in unnamed(chart))]
    return tuple(sorted(rows, key=lambda x: (x.part is Part.IMAG, float(x.band.low.omega))))


def find_percepts(chart: Chart) -> tuple[Percept, ...]:
    """The pieces of the band where a ratio exceeds its threshold, split where property or change changes.

    Proven by signs on whole intervals, never sampled. No damping percept is claimed where Im H_perc < 0.
    """
    return tuple(percept for x in judged(chart) if x.part for percept in _percepts(chart, x, x.part))


def _percepts(chart: Chart, criterion: Criterion, part: Part) -> list[Percept]:
    """Maximal runs of cells with one label, over points at which the ratio still exceeds its threshold."""
    runs: list[Percept] = []
    for low, high in pairwise(chart.points):
        label = _label(low.after, part) if low.after[criterion] > 0 else None
        if label is None:
            continue
        last = runs[-1] if runs else None
        if last and last.band.high is low and (last.property, last.change) == label and low.at[criterion] > 0:
            runs[-1] = replace(last, band=Interval(last.band.low, high))
        else:
            runs.append(Percept(part, Interval(low, high), *label))
    return runs


def _label(signs: Signs, part: Part) -> tuple[Property, Change] | None:
    env, perc = signs[Curve.ENVIRONMENT, part], signs[Curve.PERCEIVED, part]
    if part is Part.IMAG and perc < 0:
        return None
    change = {1: Change.HIGHER, -1: Change.LOWER, 0: Change.EQUAL}
    compared = signs[Curve.DIFFERENCE, part] * signs[Curve.SUM, part]
    return (Property.DAMPING if part is Part.IMAG else _real_property(env, perc)), change[compared]


def _real_property(env: int, perc: int) -> Property:
    """A part that is zero throughout takes the other's side: nothing becomes something of the same kind."""
    return _SIDES[env or perc, perc or env]


_SIDES = {
    (1, 1): Property.STIFFNESS,
    (-1, -1): Property.MASS,
    (1, -1): Property.STIFFNESS_TO_MASS,
    (-1, 1): Property.MASS_TO_STIFFNESS,
}


def changeovers(chart: Chart, curve: Curve) -> tuple[Point, ...]:
    """Where Re H_env (or Re H_perc) changes its sign: a spring below, inertia above, or back."""
    return chart.sign_changes((curve, Part.REAL))


def outside_model(chart: Chart) -> tuple[Interval, ...]:
    """Where Im H_perc < 0: the display is active there, which the paper's model excludes."""
    return chart.where(lambda signs: signs[Curve.PERCEIVED, Part.IMAG] < 0)


def unnamed(chart: Chart) -> tuple[Interval, ...]:
    """Where Im H_perc < 0 and the imaginary part is noticed all the same: no property is named for it there."""
    damping = [x for x in judged(chart) if x.part is Part.IMAG]
    return chart.where(lambda signs: signs[Curve.PERCEIVED, Part.IMAG] < 0 and any(signs[x] > 0 for x in damping))
