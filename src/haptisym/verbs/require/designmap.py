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
from haptisym.kernel.budget import Told, limited
from haptisym.kernel.shown import counted, titled
from haptisym.model.hand import Hand
from haptisym.model.jnd import Part
from haptisym.model.knobs import Knob
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.require.boundary import edge_polynomial, touch_polynomial
from haptisym.verbs.require.classical import Line, lines
from haptisym.verbs.require.entry import require
from haptisym.verbs.require.feasible import Kind, Solved
from haptisym.verbs.require.freeparameter import asked_of, conditions, domain
from haptisym.verbs.require.held import with_hands
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.verdicts import together
from haptisym.verbs.require.wishes import STABLE, SUITS_ALL, TRANSPARENT, further, wishes

_CLOSER = 6
"""Times that the gap between two slices that differ in kind is halved."""


@dataclass(frozen=True)
class Slice:
    """The exact requirement on the second parameter where the first one has a value; ``apart`` : on each thing asked, alone."""

    at: Expr
    requirement: Requirement
    apart: tuple[Requirement, ...] = ()


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

    def _line(self) -> str:
        first, second = (x.path for x in self.free)
        return f"{titled(self.scene.title)}: {second} over {first}, {counted(len(self.slices), 'slice')}"

    @property
    def certified(self) -> bool:
        """Whether all slices are."""
        return all(x.requirement.certified for x in self.slices)

    def curves(self) -> dict[tuple[Criterion, Kind], Expr]:
        """Polynomials in both parameters (and pi) that vanish on the boundary: at the band's ends, and the discriminants.

        Every point of the boundary is a zero of one of them. SceneError for scenes with delays or powers of s. Those of
        touches are large for devices of order 4 and more.
        """
        judged = [x for x in self.criteria if x.name not in (STABLE, SUITS_ALL)]
        found = conditions(self.scene, self.free, judged)
        return {
            (x, kind): edge_polynomial(condition, end)
            for x, condition in found.items()
            for kind, end in zip((Kind.START, Kind.EDGE), self.scene.band, strict=True)
        } | {(x, Kind.TOUCH): touch_polynomial(condition) for x, condition in found.items()}

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """The classical bounds on a stiffness for which the scene has what they need, where stability is asked."""
        return lines(self.scene, self.free) if STABLE in self.that else ()

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
            "slices": [{"at": float(x.at), **x.requirement.rows(), **_apart(x)} for x in self.slices],
            **({"lines": [{"name": x.name, "rule": x.rule} for x in self.lines]} if self.lines else {}),
            "certified": self.certified,
        }


def _apart(x: Slice) -> dict[str, Any]:
    """Of several things asked, the values for each alone."""
    if not x.apart:
        return {}
    return {"apart": {name: r.rows()["feasible"] for r in x.apart for name in r.that}}


def design_map(
    scene: Scene | str | Path,
    paths: Sequence[str],
    ranges: Sequence[tuple[Number, Number]],
    *,
    part: Part | None = None,
    any_environment: bool = False,
    that: Sequence[str] = (TRANSPARENT,),
    hand: str | Hand | None = None,
    slices: int = 41,
    limit: float | None = None,
    told: Told | None = None,
) -> DesignMap:
    """The transparent region in two parameters, by that many slices, and more where their number of intervals changes.

    ``paths``: of both parameters; ``ranges``: of each, SI or with a unit. Every slice is a ``Requirement`` on the second one.
    ``that``, ``hand``, ``limit``, ``told``: as in ``require``; of slices that were not reached in time every value is undecided.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = design_map(load_scene("fu2019"), ["zeta", "omega_n"], [("0.4", "0.6"), (50, 500)], slices=3)
    >>> [x.requirement.feasible[0].low.value.digits(6) for x in found.slices]
    ['103.831', '122.356', '141.462']
    """
    scene = as_scene(scene)
    wanted = wishes(that)
    scene = with_hands(scene, hand) if STABLE in wanted else scene
    first, second = scene.knobs.chosen(paths)
    judged = asked_of(scene, (first, second), part, any_environment=any_environment) if TRANSPARENT in wanted else ()
    criteria = (*judged, *further(scene, wanted))
    (low, high), other = (
        (free.number(a), free.number(b)) for free, (a, b) in zip((first, second), ranges, strict=True)
    )
    for free, pair in zip((first, second), ((low, high), other), strict=True):
        domain(free, pair)

    def cut(at: Expr, n: int, count: int) -> Slice:
        budget.say(n, count, "slices")
        here = first.put(scene, at)
        apart = [
            require(here, second.path, other, part=part, any_environment=any_environment, that=[x]) for x in wanted
        ]
        return Slice(at, apart[0]) if len(apart) == 1 else _of_several(at, apart)

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
    return DesignMap(scene, (first, second), ((low, high), other), tuple(found), criteria, wanted)


def _of_several(at: Expr, apart: Sequence[Requirement]) -> Slice:
    """A slice of several things that were asked, from the values for each alone."""
    one = apart[0]
    both = together(one.domain, [Solved(x.feasible, x.undecided) for x in apart])
    names = tuple(name for x in apart for name in x.that)
    criteria = tuple(y for x in apart for y in x.criteria)
    return Slice(
        at, replace(one, feasible=both.feasible, undecided=both.undecided, criteria=criteria, that=names), tuple(apart)
    )


def _differ(a: Slice, b: Slice) -> bool:
    """Whether two slices differ in the number of intervals, or in what binds at their ends."""
    return _pattern(a) != _pattern(b)


def _pattern(x: Slice) -> list[list[list[tuple[str, Kind]]]]:
    spans = x.requirement.feasible
    return [[[(b.criterion.name, b.kind) for b in end.bindings] for end in (span.low, span.high)] for span in spans]
