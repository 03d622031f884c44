"""What a chart answers about a scene: when a distortion is noticed, and how it is felt."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from haptisym.judge.bounds import AnyEnvironment, any_environment
from haptisym.judge.crossings import Crossing, Curve, find_crossings, transparent_set, unbounded_points
from haptisym.judge.percepts import Felt, Percept, changeovers, find_felt, find_percepts, outside_model, unnamed
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Chart, Interval, Point
from haptisym.model.caveats import caveats
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene

if TYPE_CHECKING:
    from haptisym.verbs.effects.relevance import Relevance  # loaded where a tolerance is given


@dataclass(frozen=True)
class Answers:
    """The answers for a scene, all proven: nothing is missed on the band and nothing is invented.

    ``crossings``: where r_r or r_i meets its threshold. ``transparent``: where neither exceeds it, a union of closed
    intervals. ``changeovers``: where Re H_env and Re H_perc change sign. ``percepts``: what is felt where a ratio
    exceeds; ``felt`` : the same in words, with what has no name. ``outside_model``: where Im H_perc < 0; ``unnamed`` : where
    the imaginary part is noticed there. ``unbounded``: where a ratio is infinite. ``stable``: whether the force under imposed
    motion is stable, which is to say all poles of H_perc lie in the open left half plane; it says nothing about a display
    that is held in a hand. None where that is not decided, or the poles do not tell it (a sampled loop).
    ``digits``: decimal digits shown of each crossing. ``undecided``: where
    something stayed open at the precision limit (a tangency of a scene with delays): empty for every rational scene.
    ``relevance`` : what was left out, where a tolerance was given; all answers are then those of the pruned scene, ``scene``.
    """

    scene: Scene
    distortion: Distortion = field(repr=False)
    chart: Chart = field(repr=False)
    stable: bool | None
    digits: int = 15
    relevance: Relevance | None = field(default=None, repr=False)

    @property
    def given(self) -> Scene:
        """The scene that was asked about, with what was left out of it."""
        return self.scene if self.relevance is None else self.relevance.scene

    @cached_property
    def crossings(self) -> tuple[Crossing, ...]:
        return find_crossings(self.chart)

    @cached_property
    def transparent(self) -> tuple[Interval, ...]:
        return transparent_set(self.chart)

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the transparent interval that starts at the band's low end; None if none does."""
        first = self.transparent[0] if self.transparent else None
        return first.high.omega if first and first.low is self.chart.points[0] else None

    @cached_property
    def changeovers_environment(self) -> tuple[Point, ...]:
        return changeovers(self.chart, Curve.ENVIRONMENT)

    @cached_property
    def changeovers_perceived(self) -> tuple[Point, ...]:
        return changeovers(self.chart, Curve.PERCEIVED)

    @cached_property
    def percepts(self) -> tuple[Percept, ...]:
        return find_percepts(self.chart)

    @cached_property
    def felt(self) -> tuple[Felt, ...]:
        """Everything that is noticed, as what it is felt, in words: percepts, and where no property is named."""
        return find_felt(self.chart)

    @cached_property
    def unnamed(self) -> tuple[Interval, ...]:
        """Where Im H_perc < 0 and the imaginary part is noticed all the same: no property is named for it there."""
        return unnamed(self.chart)

    @cached_property
    def outside_model(self) -> tuple[Interval, ...]:
        return outside_model(self.chart)

    @cached_property
    def unbounded(self) -> tuple[Point, ...]:
        return unbounded_points(self.chart)

    @cached_property
    def undecided(self) -> tuple[tuple[Part, Point], ...]:
        """Where it stayed open at the precision limit whether a ratio touches its threshold, crosses it twice or not at all."""
        return tuple((p, x) for x in self.chart.undecided for p in Part if (Curve.EXCESS, p) in x.undecided)

    @cached_property
    def any_environment(self) -> AnyEnvironment | None:
        """What the scene's effects do to every environment at once; None unless all of them are in series."""
        return any_environment(self.scene)

    @property
    def caveats(self) -> tuple[str, ...]:
        """Where the scene's formulas stand for more than they hold, a sentence each."""
        return caveats(self.scene)

    @property
    def certified(self) -> bool:
        """Whether every number here is proven, none estimated, and nothing was left undecided."""
        return not self.undecided
