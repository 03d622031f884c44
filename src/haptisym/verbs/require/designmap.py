"""Design charts: where in the plane of two parameters a display is transparent on its whole band, by exact slices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

from sympy import Expr

from haptisym.judge.answers import Answer
from haptisym.judge.criteria import Criterion
from haptisym.kernel.budget import Told, limited, share
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.shown import counted, titled
from haptisym.model.hand import Hand
from haptisym.model.jnd import Part
from haptisym.model.knobs import THRESHOLD, Knob
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.require.boundary import edge_polynomial, touch_polynomial
from haptisym.verbs.require.classical import DAMPING, STIFFNESS, Encoder, Line, lines, need_encoder
from haptisym.verbs.require.entry import require
from haptisym.verbs.require.feasible import Kind, Solved
from haptisym.verbs.require.freeparameter import asked_of, conditions, domain, pieces
from haptisym.verbs.require.held import with_hands
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.verdicts import together
from haptisym.verbs.require.wishes import STABLE, SUITS_ALL, TRANSPARENT, further, wishes

_CLOSER = 6
"""Times that the gap between two slices that differ in kind is halved."""


@dataclass(frozen=True)
class Slice:
    """The exact requirement on the second parameter where the first one has a value; ``apart`` : on each thing asked, alone.

    ``contours`` : the values for which nothing is noticed with each of the other thresholds that were asked about.
    """

    at: Expr
    requirement: Requirement
    apart: tuple[Requirement, ...] = ()
    contours: tuple[Requirement, ...] = ()


@dataclass(frozen=True, repr=False)
class DesignMap(Answer):
    """The transparent region of a scene in two parameters: exact along each slice, the first parameter being constant there.

    ``slices``: in ascending order of the first parameter. Between two slices nothing is claimed but by ``curves``.
    """

    _schema: ClassVar[str] = "haptisym.designmap/1"
    _page: ClassVar[str] = "haptisym.pages.require:map_page"
    _figure: ClassVar[str] = "haptisym.figures.maps:map_figure"

    scene: Scene
    free: tuple[Knob, Knob]
    ranges: tuple[tuple[Expr, Expr], tuple[Expr, Expr]]
    slices: tuple[Slice, ...]
    criteria: tuple[Criterion, ...] = ()
    that: tuple[str, ...] = (TRANSPARENT,)
    thresholds: tuple[Expr, ...] = ()
    encoder: Encoder | None = None

    def _line(self) -> str:
        first, second = (x.path for x in self.free)
        return f"{titled(self.scene.title)}: {second} over {first}, {counted(len(self.slices), 'slice')}"

    @property
    def certified(self) -> bool:
        """Whether all slices are."""
        return all(r.certified for x in self.slices for r in (x.requirement, *x.contours))

    def curves(self) -> dict[tuple[Criterion, Kind], Expr]:
        """Polynomials in both parameters (and pi) that vanish on the boundary: at the band's ends, and the discriminants.

        Every point of the boundary is a zero of one of them. SceneError for scenes with delays or powers of s. Those of
        touches are large for devices of order 4 and more.
        """
        judged = [x for x in self.criteria if x.name not in (STABLE, SUITS_ALL)]
        found = {x: pieces(own) for x, own in conditions(self.scene, self.free, judged).items()}
        return {
            (x, kind): edge_polynomial(own, end)
            for x, own in found.items()
            for kind, end in zip((Kind.START, Kind.EDGE), self.scene.band, strict=True)
        } | {(x, Kind.TOUCH): touch_polynomial(own) for x, own in found.items()}

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """The classical bounds on a stiffness for which the scene has what they need, where stability is asked."""
        return lines(self.scene, self.free, self.encoder) if STABLE in self.that else ()

    @property
    def stiffest(self) -> tuple[Slice, RealNumber] | None:
        """Of slices along a wall's damping the one that is stable furthest up, and how far; None if beyond the range."""
        if STABLE not in self.that or [x.path for x in self.free] != [DAMPING, STIFFNESS]:
            return None
        i = self.that.index(STABLE)
        held = [(x, (x.apart or (x.requirement,))[i]) for x in self.slices]
        tops = [(x, r.feasible[-1].high) for x, r in held if r.feasible]
        if any(r.undecided for _, r in held) or not all(end.bindings for _, end in tops):
            return None
        return max(((x, end.value) for x, end in tops if end.value), key=lambda row: float(row[1]), default=None)

    @property
    def _varied(self) -> tuple[list[str], list[str]]:
        paths = [x.path for x in self.free]
        return paths, paths

    def _body(self) -> dict[str, Any]:
        return {
            "free": [x.path for x in self.free],
            "unit": [x.unit for x in self.free],
            "range": [[float(x) for x in pair] for pair in self.ranges],
            "band": [float(x) for x in self.scene.band],
            "criteria": list(self.that),
            "slices": [
                {"at": float(x.at), **x.requirement.rows(), **_apart(x), **self._contours(x)} for x in self.slices
            ],
            **(
                {"lines": [{"name": x.name, "rule": x.rule, "assumes": x.assumes} for x in self.lines]}
                if self.lines
                else {}
            ),
            "certified": self.certified,
        }

    def _contours(self, x: Slice) -> dict[str, Any]:
        """The values for which nothing is noticed with other thresholds."""
        rows = [
            {"jnd": float(jnd), "feasible": r.spans(), "certified": r.certified}
            for jnd, r in zip(self.thresholds, x.contours, strict=True)
        ]
        return {"contours": rows} if rows else {}


def _apart(x: Slice) -> dict[str, Any]:
    """Of several things asked, the values for each alone."""
    if not x.apart:
        return {}
    return {"apart": {name: r.spans() for r in x.apart for name in r.that}}


def design_map(
    scene: Scene | str | Path,
    paths: Sequence[str],
    ranges: Sequence[tuple[Number, Number]],
    *,
    part: Part | None = None,
    any_environment: bool = False,
    that: Sequence[str] = (TRANSPARENT,),
    hand: str | Hand | None = None,
    jnd: Sequence[Number] = (),
    friction: Number | None = None,
    resolution: Number | None = None,
    slices: int = 41,
    limit: float | None = None,
    told: Told | None = None,
) -> DesignMap:
    """The transparent region in two parameters, by that many slices, and more where their number of intervals changes.

    ``paths``: of both parameters; ``ranges``: of each, SI or with a unit. Every slice is a ``Requirement`` on the second one.
    ``that``, ``hand``, ``limit``, ``told``: as in ``require``; of slices that were not reached in time every value is undecided.
    ``jnd``: further thresholds, each with the region that is transparent with it. ``friction``, ``resolution``: of a device and
    its encoder, for Abbott and Okamura's bound beside the other classical ones.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = design_map(load_scene("fu2019"), ["zeta", "omega_n"], [("0.4", "0.6"), (50, 500)], slices=3)
    >>> [x.requirement.feasible[0].low.value.digits(6) for x in found.slices]
    ['103.831', '122.356', '141.462']
    """
    scene = as_scene(scene)
    wanted = wishes(that)
    scene = with_hands(scene, hand) if STABLE in wanted else scene
    encoder = Encoder.of(scene, friction, resolution)
    first, second = scene.knobs.chosen(paths)
    judged = asked_of(scene, (first, second), part, any_environment=any_environment) if TRANSPARENT in wanted else ()
    criteria = (*judged, *further(scene, wanted))
    (low, high), other = (
        (free.number(a), free.number(b)) for free, (a, b) in zip((first, second), ranges, strict=True)
    )
    for free, pair in zip((first, second), ((low, high), other), strict=True):
        domain(free, pair)
    need_encoder(scene, (first, second), encoder)
    thresholds = _thresholds(scene, (first, second), jnd, wanted)

    asked: dict[str, Any] = {"part": part, "any_environment": any_environment}

    def cut(at: Expr, n: int, count: int) -> Slice:
        budget.say(n, count, "slices")
        here = first.put(scene, at)
        with share(1 / min(count - n, 2)):  # one that is slow leaves time to the others
            apart = [require(here, second.path, other, that=[x], **asked) for x in wanted]
            contours = [require(here.with_values({THRESHOLD: x}), second.path, other, **asked) for x in thresholds]
        return _slice(at, apart, contours)

    def cut_all(places: Sequence[Expr]) -> list[Slice]:
        return [cut(at, n, len(places)) for n, at in enumerate(places)]

    step = (high - low) / (slices - 1)
    start = [low + step * i for i in range(slices)]
    with limited(limit, told) as budget:
        found = cut_all([at for at in start if first.rule.allows(at)])
        for _ in range(_CLOSER):
            between = [(a.at + b.at) / 2 for a, b in pairwise(found) if _differ(a, b)]
            if budget.reached:  # what could be told apart is
                break
            found = sorted([*found, *cut_all(between)], key=lambda x: float(x.at))
    return DesignMap(scene, (first, second), ((low, high), other), tuple(found), criteria, wanted, thresholds, encoder)


def _slice(at: Expr, apart: Sequence[Requirement], contours: Sequence[Requirement]) -> Slice:
    """A slice of one or several things that were asked, from the values for each alone."""
    one = apart[0]
    if len(apart) == 1:
        return Slice(at, one, (), tuple(contours))
    both = together(one.domain, [Solved(x.feasible, x.undecided) for x in apart])
    names = tuple(name for x in apart for name in x.that)
    criteria = tuple(y for x in apart for y in x.criteria)
    found = replace(one, feasible=both.feasible, undecided=both.undecided, criteria=criteria, that=names)
    return Slice(at, found, tuple(apart), tuple(contours))


def _thresholds(scene: Scene, free: Sequence[Knob], jnd: Sequence[Number], wanted: Sequence[str]) -> tuple[Expr, ...]:
    """The further thresholds, each once. SceneError where nothing is asked of what is noticed, or the threshold is free."""
    if not jnd:
        return ()
    if TRANSPARENT not in wanted:
        raise SceneError("jnd: further thresholds are of what is noticed: ask for transparent too, or leave them out")
    for x in (x for x in free if x.parts):
        raise SceneError(f"jnd: further thresholds and {x.path}, which is free, say the same: leave out one of them")
    if scene.threshold.region.corners:
        raise SceneError("jnd: the scene's threshold is a polygon, which is given by its corners and not by one number")
    knob = scene.knobs[THRESHOLD]
    for c in jnd:
        knob.check(c)
    return tuple(dict.fromkeys(knob.number(c) for c in jnd))


def _differ(a: Slice, b: Slice) -> bool:
    """Whether two slices differ in the number of intervals, or in what binds at their ends."""
    return _pattern(a) != _pattern(b)


def _pattern(x: Slice) -> list[list[list[tuple[str, Kind]]]]:
    spans = x.requirement.feasible
    return [[[(b.criterion.name, b.kind) for b in end.bindings] for end in (span.low, span.high)] for span in spans]
