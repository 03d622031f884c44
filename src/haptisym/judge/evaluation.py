"""The two-step evaluation of a scene: at which frequencies a distortion is noticed, and as what it
is felt.

``evaluate`` gives an ``Evaluation``, whose answers are read off one chart of signs when they are
asked for. ``compared`` repeats step 1 with other JND regions of the same half widths (square, disc
and diamond), to see whether the conclusion depends on the shape of the region.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

from sympy import Expr, S

from haptisym.judge.answers import Answer
from haptisym.judge.bandwidths import Bandwidths, bandwidths
from haptisym.judge.bounds import AnyEnvironment, any_environment
from haptisym.judge.crossings import (
    JOINT,
    Criterion,
    Crossing,
    PerceptFunction,
    curves,
    find_crossings,
    judged,
    kept,
    noticed,
    unbounded_points,
)
from haptisym.judge.passivity import Passivity, force_is_stable, passivity
from haptisym.judge.percepts import (
    NOT_NAMED,
    Felt,
    Friction,
    Percept,
    changeovers,
    find_felt,
    find_percepts,
    frictions,
    outside_model,
    unnamed,
    without_friction,
)
from haptisym.judge.regions import Cornered
from haptisym.kernel.budget import Left, in_time
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.kernel.reals import RealNumber, whole
from haptisym.kernel.roots import Chart, Interval, Point, chart
from haptisym.model.catalogue import Effect
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import SQUARE, Part, RegionDetails, Shape, Threshold
from haptisym.model.scene import Scene, caveats
from haptisym.model.scenefile import as_scene


@dataclass(frozen=True, repr=False)
class Compared(Shown):
    """Step 1 of a scene with one JND region: the first crossing on the band, and the bandwidth,
    rad/s; None where there is none."""

    name: str
    threshold: Threshold
    crossing: Crossing | None
    bandwidth: RealNumber | None
    transparent: tuple[Interval, ...]
    certified: bool

    def _line(self) -> str:
        return f"{self.name}: bandwidth {self.bandwidth.digits(5) if self.bandwidth else 'none'}"

    def row(self, digits: int) -> dict[str, Any]:
        """As a row of a document."""
        first: dict[str, Any] | None = None
        if self.crossing:
            x, omega = self.crossing, self.crossing.omega
            first = {"part": x.criterion.name, "omega": float(omega), "kind": x.kind.value}
            first |= {"digits": omega.digits(digits), "enclosure": list(omega.enclosure(digits))}
        return {
            "region": self.name,
            "threshold": self.threshold.row(),
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "crossing": first,
            "certified": self.certified,
        }


OWN = "the scene's own"
"""The name of the scene's JND region in documents."""


class _Named(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def threshold(self) -> Threshold: ...


_N = TypeVar("_N", bound=_Named)


def region_label(x: _Named) -> str:
    """The name of a region on a page and in a figure."""
    return "of the scene" if x.name == OWN else x.name


def different(found: Sequence[_N]) -> list[_N]:
    """The regions, without the scene's where that equals one of the others."""
    others = [x.threshold for x in found if x.name != OWN]
    return [x for x in found if x.name != OWN or x.threshold not in others]


def compared(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> tuple[Compared, ...]:
    """Step 1 with the square, disc and diamond of the half widths of a JND, and with the JND
    itself.

    With limits for each way the half widths are those for changes that make a part larger; of a
    polygon they are the shorter of its two reaches along each axis. SceneError for a polygon that
    depends on frequency, which has none.
    """
    real, imag = half_widths(threshold)
    plain = Threshold.of(real, imag)
    shapes = {
        "square": SQUARE,
        "disc": RegionDetails(Shape.ELLIPSE),
        "diamond": RegionDetails(Shape.DIAMOND),
    }
    regions = {name: replace(plain, region=region) for name, region in shapes.items()}
    regions[OWN] = threshold
    results = []
    for name, x in regions.items():
        table = chart(curves(d, noticed(x)), *band)
        first, clear = next(iter(find_crossings(table)), None), kept(table)
        width = table.reach(clear)
        results.append(Compared(name, x, first, width, clear, not table.undecided))
    return tuple(results)


def half_widths(threshold: Threshold) -> tuple[Expr, Expr]:
    """How far a region reaches along the axes of x and y; of the two directions of an axis the
    shorter one counts."""
    corners = threshold.region.corners
    if not corners:
        return threshold.real, threshold.imag
    if not threshold.is_constant:
        raise SceneError(
            "regions: a polygon that depends on omega cannot be compared with a square and a "
            "disc: leave regions out"
        )
    # The edge p x + q y = 1 meets the x axis at 1/p: the largest |p| is the nearest.
    edges = Cornered(S.One, S.One, corners).edges
    across, up = (1 / max(max(edge[i], -edge[i]) for edge in edges) for i in (0, 1))
    return across, up


class LeftOut(Protocol):
    """What is proven of a scene when effects are left out of it; ``Relevance`` has this
    interface."""

    @property
    def scene(self) -> Scene:
        """The scene with all effects."""

    @property
    def pruned(self) -> Scene:
        """The scene with the effects that are kept."""

    @property
    def tolerance(self) -> Expr:
        """The largest change of a ratio that was allowed."""

    @property
    def dropped(self) -> tuple[Effect, ...]:
        """The effects that are left out."""

    @property
    def bound(self) -> Mapping[Part, Any]:
        """The largest change of each part's ratio; its ``most`` is a proven upper bound."""

    @property
    def crossings(self) -> Sequence[Any]:
        """Enclosures of the full scene's crossings, each with ``part`` and ``bounds``."""

    def row(self) -> dict[str, Any]:
        """The part of a document about the full scene."""


class Reported(Protocol):
    """What a fit of k, b and m to a movement reports: ``verbs.evaluate.movement``."""

    @property
    def spectrum(self) -> str:
        """The movement."""

    @property
    def band(self) -> tuple[float, float]:
        """The lowest and the highest of its frequencies, rad/s."""

    @property
    def environment(self) -> Mapping[str, float | None]:
        """k, b and m fitted to H_env, by name, SI; None where there is no number or it is
        undecided."""

    @property
    def perceived(self) -> Mapping[str, float | None]:
        """k, b and m fitted to H_perc."""

    @property
    def poles(self) -> Mapping[str, Sequence[float]]:
        """For H_env or H_perc the frequencies, rad/s, at which it is infinite, so that it has no
        fit."""

    @property
    def undecided(self) -> bool:
        """Whether any number is undecided."""

    @property
    def computed(self) -> bool:
        """Whether the numbers are computed, not proven."""

    @property
    def change(self) -> Mapping[str, float | None]:
        """The relative change of k, b and m from the environment to what is perceived."""

    def row(self) -> dict[str, Any]:
        """As a part of a document."""


class Deciding(Protocol):
    """Changes that would decide between models of the JND: ``verbs.evaluate.discriminate``."""

    @property
    def stimuli(self) -> Sequence[Any]:
        """For each pair of models the change that they judge differently with the largest
        margin."""

    @property
    def display(self) -> Sequence[Any]:
        """Where on the band the display itself makes such a change."""

    @property
    def models(self) -> Mapping[str, Threshold]:
        """The models by name."""

    @property
    def undecided(self) -> Sequence[RealNumber]:
        """The frequencies, rad/s, at which a verdict is undecided at the precision limit."""

    def row(self) -> dict[str, Any]:
        """As a part of a document."""


@dataclass(frozen=True, repr=False)
class Evaluation(Answer):
    """The answers for a scene: when a change is noticed, and as what.

    ``crossings`` : each frequency at which r_r or r_i equals its threshold, or dH lies on the
    border of its region.
    ``transparent`` : closed intervals on which neither exceeds it. ``bandwidth`` : the end of the
    one that starts at the band's low end, rad/s; None if none does.
    ``changeovers_environment``, ``changeovers_perceived`` : where Re H_env and Re H_perc change
    sign, rad/s.
    ``percepts`` : what is felt where a ratio exceeds; ``felt`` : the same in words, with what has
    no name.
    ``outside_model`` : intervals with Im H_perc < 0, where the display is active; ``unnamed`` :
    those where the imaginary part is noticed. ``unbounded`` : frequencies at which a ratio is
    infinite, as H_env is 0 there.
    ``stable`` : whether it is stable under prescribed motion: all poles of H_perc in Re s < 0. None
    where that is undecided or poles do not show it (a sampled loop). It holds nothing about a
    display in a hand; ``hs.stability`` does.
    ``undecided`` : where something is undecided at the precision limit, such as a tangency of a
    scene with delays; empty of each rational scene. ``certified`` : nothing is.
    ``digits`` : decimal digits shown of each crossing.
    ``relevance``, ``regions``, ``movement``, ``discrimination`` : where a tolerance was given, what
    was left out (all answers are then those of the pruned scene, ``scene``); the answers for other
    JND regions; what a fit to a movement reports; which changes would decide between JND regions.
    None where they were not asked for. ``left`` : those not found in time, with the reason.

    Proven: each number, and that these are all crossings on the band, but for
    what ``undecided`` names.

    >>> import haptisym as hs
    >>> found = hs.evaluate("fu2019")
    >>> found.bandwidth, found.transparent, found.certified
    (7.97891679017471, (<Interval from 0 to 7.97891679017471 rad/s>,), True)
    """

    _schema: ClassVar[str] = "haptisym.evaluation/1"
    _figure: ClassVar[str] = "haptisym.figures.evaluation:EVALUATION"
    _page: ClassVar[str] = "haptisym.pages.evaluation:page"
    _certificate: ClassVar[str] = "haptisym.verbs.evaluate.certificate:certificate"

    scene: Scene
    distortion: Distortion
    chart: Chart
    stable: bool | None
    digits: int = 15
    relevance: LeftOut | None = None
    regions: tuple[Compared, ...] = ()
    movement: Reported | None = None
    discrimination: Deciding | None = None
    left: Left = field(default_factory=dict)

    def _line(self) -> str:
        width = "no bandwidth"
        if self.bandwidth is not None:
            width = f"bandwidth {self.bandwidth.digits(5)} rad/s"
        counts = [counted(len(self.crossings), "crossing"), counted(len(self.percepts), "percept")]
        if self.unnamed:
            # What has no property is felt as well: ``felt`` has all of it.
            counts.append(f"{counted(len(self.unnamed), 'interval')} {NOT_NAMED}")
        return f"{titled(self.scene.title)}: {width}, {', '.join(counts)}"

    def with_regions(self) -> Evaluation:
        """The same evaluation, with ``regions`` for the square, disc and diamond of the same half
        widths."""
        return replace(
            self, regions=compared(self.distortion, self.scene.threshold, self.scene.band)
        )

    @property
    def given(self) -> Scene:
        """The scene as it was given, with the effects that were left out of ``scene``."""
        return self.scene if self.relevance is None else self.relevance.scene

    @property
    def _about(self) -> Scene:
        return self.given

    @property
    def criteria(self) -> tuple[Criterion, ...]:
        """The criteria that are judged, in the order of their parts."""
        return judged(self.chart)

    @cached_property
    def crossings(self) -> tuple[Crossing, ...]:
        """All crossings on the band, in ascending order."""
        return find_crossings(self.chart)

    @cached_property
    def transparent(self) -> tuple[Interval, ...]:
        """All intervals on which no ratio exceeds its threshold."""
        return kept(self.chart)

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the transparent interval that starts at the band's low end; None if none
        does."""
        return self.chart.reach(self.transparent)

    @cached_property
    def bandwidths(self) -> Bandwidths | None:
        """All bandwidths for the thresholds of a range; None where the threshold is a number."""
        return bandwidths(self.distortion, self.scene.threshold, self.scene.band)

    @cached_property
    def changeovers_environment(self) -> tuple[Point, ...]:
        """Where Re H_env changes its sign."""
        return changeovers(self.chart, PerceptFunction.ENVIRONMENT)

    @cached_property
    def changeovers_perceived(self) -> tuple[Point, ...]:
        """Where Re H_perc changes its sign."""
        return changeovers(self.chart, PerceptFunction.PERCEIVED)

    @cached_property
    def _felt_chart(self) -> Chart:
        """The chart that percepts are read from: with friction also the points at which a ratio
        would equal its threshold without it."""
        # A part that would not be noticed without the friction is felt as friction. These points
        # are no crossings, so they stay out of the chart of step 1.
        if self.friction is None:
            return self.chart
        bare = without_friction(self.scene).distortion()
        return chart(curves(self.distortion, noticed(self.scene.threshold), bare), *self.scene.band)

    @cached_property
    def percepts(self) -> tuple[Percept, ...]:
        """What is felt where a ratio exceeds its threshold."""
        return find_percepts(self._felt_chart)

    @cached_property
    def felt(self) -> tuple[Felt, ...]:
        """Everything that is noticed, in words: percepts, and the intervals on which no property is
        named."""
        return find_felt(self._felt_chart)

    @property
    def friction(self) -> Friction | None:
        """Whether the display's friction is noticed, by its own threshold; None of a display
        without it."""
        return frictions(self.scene)

    @cached_property
    def unnamed(self) -> tuple[Interval, ...]:
        """Where Im H_perc < 0 and the imaginary part is noticed all the same: no property is named
        for it there."""
        return unnamed(self._felt_chart)

    @cached_property
    def outside_model(self) -> tuple[Interval, ...]:
        """Where Im H_perc < 0: the display is active there."""
        return outside_model(self.chart)

    @cached_property
    def unbounded(self) -> tuple[Point, ...]:
        """Where a ratio is infinite: H_env is zero and dH is not."""
        return unbounded_points(self.chart)

    @cached_property
    def undecided(self) -> tuple[tuple[Criterion, Point], ...]:
        """Where it is undecided at the precision limit whether a ratio touches its threshold,
        crosses it twice or not at all."""
        return tuple(
            (x, point)
            for point in self.chart.undecided
            for x in self.criteria
            if x in point.undecided
        )

    @cached_property
    def any_environment(self) -> AnyEnvironment | None:
        """What the scene's effects do to every environment at once; None unless all of them are in
        series."""
        return any_environment(self.scene)

    @cached_property
    def passivity(self) -> Passivity | None:
        """Whether the display is passive, judged at all frequencies; None where not even signs are
        decided."""
        # The evaluation stands without it: the page then says that passivity is undecided.
        try:
            return passivity(self.scene, self.distortion)
        except UndecidedError:
            return None

    @property
    def caveats(self) -> tuple[str, ...]:
        """Where the scene's formulas stand for more than they hold, a sentence each."""
        return caveats(self.scene)

    @property
    def certified(self) -> bool:
        """Whether every number here is proven, none estimated, and nothing was left undecided."""
        is_fitted = self.movement is None or not self.movement.undecided
        return (
            not (self.undecided or self.left)
            and is_fitted
            and (self.bandwidths is None or self.bandwidths.certified)
        )

    def _body(self) -> dict[str, Any]:
        changeovers = {
            "environment": self.changeovers_environment,
            "perceived": self.changeovers_perceived,
        }
        return {
            "band": [float(point.omega) for point in (self.chart.points[0], self.chart.points[-1])],
            "threshold": self.scene.threshold.row(),
            **({"like": name} if (name := self.scene.threshold.source) else {}),
            "crossings": [self._crossing(c) for c in self.crossings],
            "transparent": [_interval(x) for x in self.transparent],
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            **({"bandwidths": self.bandwidths.row(self.digits)} if self.bandwidths else {}),
            "changeovers": {
                system: [float(p.omega) for p in points] for system, points in changeovers.items()
            },
            "percepts": [_percept(p) for p in self.percepts],
            "outside_model": [_interval(x) for x in self.outside_model],
            **({"friction": self.friction.row()} if self.friction else {}),
            **({"unnamed": [_interval(x) for x in self.unnamed]} if self.unnamed else {}),
            "unbounded": [float(p.omega) for p in self.unbounded],
            "stable": self.stable,
            "any_environment": None if self.any_environment is None else self.any_environment.row(),
            "certified": self.certified,
            **({"caveats": list(self.caveats)} if self.caveats else {}),
        }

    def _left(self) -> dict[str, Any]:
        rows: list[Any] = []
        for x, point in self.undecided:
            rows.append({"part": x.name, "enclosure": list(point.omega.enclosure(self.digits))})
        rows += [{"name": name, "reason": why} for name, why in self.left.items()]
        keys: dict[str, Any] = {}
        if rows:
            keys["undecided"] = rows
        if self.regions:
            keys["regions"] = [x.row(self.digits) for x in self.regions]
        if self.movement is not None:
            keys["movement"] = self.movement.row()
        if self.discrimination is not None:
            keys["discriminate"] = self.discrimination.row()
        if self.relevance is not None:
            keys["relevance"] = self.relevance.row()
        return keys

    def _crossing(self, c: Crossing) -> dict[str, Any]:
        return {
            "part": c.criterion.name,
            "omega": float(c.omega),
            "digits": c.omega.digits(self.digits),
            "enclosure": list(c.omega.enclosure(self.digits)),
            "kind": c.kind.value,
            "sign": c.sign,
            "multiplicity": c.multiplicity,
            **({"limit": "changes"} if c.jump else {}),
        }


def evaluate(
    scene: Scene | str | Path, digits: int = 15, *, left_out: LeftOut | None = None
) -> Evaluation:
    """Evaluate a scene with numbers for all parameters; ``digits`` decimal digits of each crossing,
    as many as wanted.

    ``left_out`` : where effects were left out, what is proven of the full scene. Raises SceneError
    if a parameter is still a symbol.

    >>> from haptisym import effects, environments
    >>> scene = Scene(environments.mass_spring_damper(1.8, 15, 100), (effects.second_order_lowpass(80, 0.5),))
    >>> [c.omega.digits(20) for c in evaluate(scene).crossings]
    ['7.9789167901747077028', '11.937310924322057781']
    """
    scene = as_scene(scene)
    digits = whole("digits", digits)
    scene.knobs.need_numbers()
    # One chart of all functions: crossings, percepts and changeovers are then in one exact order.
    distortion = scene.distortion()
    table = chart(curves(distortion, noticed(scene.threshold)), *scene.band)
    left = Left()
    stable = in_time(
        lambda: force_is_stable(scene, distortion), "stability under prescribed motion", left
    )
    return Evaluation(scene, distortion, table, stable, digits, left_out, left=left)


def _interval(x: Interval) -> list[float]:
    return [float(x.low.omega), float(x.high.omega)]


def _percept(p: Percept) -> dict[str, Any]:
    """A percept as a row of a document; one of both parts together has both properties, that of the
    part nearer its own limit last."""
    if p.part:
        return {
            "part": p.part.value,
            "band": _interval(p.band),
            "property": p.property.value,
            "change": p.change.value,
        }
    listed = [*([p.other] if p.other else []), (p.property, p.change)]
    names = {"property": [x.value for x, _ in listed], "change": [x.value for _, x in listed]}
    return {"part": JOINT, "band": _interval(p.band), **names}
