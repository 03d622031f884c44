"""Design charts: where in the plane of two parameters a display is transparent on its whole band, by exact slices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from sympy import Expr, Rational

from haptisym.judge.answers import Answer
from haptisym.judge.criteria import Criterion
from haptisym.kernel.budget import SECONDS, Told, limited
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.shown import counted, titled
from haptisym.model.hand import Hand
from haptisym.model.jnd import Part
from haptisym.model.knobs import Knob
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.require.asking import Asked, Plan, share_of
from haptisym.verbs.require.classical import DAMPING, STIFFNESS, Encoder, Line, lines, need_encoder
from haptisym.verbs.require.criticalvalues import edge_polynomial, touch_polynomial
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.freeparameter import conditions, pieces
from haptisym.verbs.require.held import with_hands
from haptisym.verbs.require.proven import Proof
from haptisym.verbs.require.slices import Gap, Slice, gaps
from haptisym.verbs.require.wishes import STABLE, SUITS_ALL, TRANSPARENT, wishes


@dataclass(frozen=True, repr=False)
class DesignMap(Answer):
    """The transparent region of a scene in two parameters: exact along each slice, the first parameter being constant there.

    ``slices``: in ascending order of the first parameter. How far straight lines between them are off is estimated (``gaps``).
    ``within``: what that was to be, a share of the second range. ``proofs``: of what is transparent, or stable, what is
    proven between the slices too.
    """

    _schema: ClassVar[str] = "haptisym.designmap/1"
    _page: ClassVar[str] = "haptisym.pages.designmap:page"
    _figure: ClassVar[str] = "haptisym.figures.designmap:map_figure"

    scene: Scene
    free: tuple[Knob, Knob]
    ranges: tuple[tuple[Expr, Expr], tuple[Expr, Expr]]
    slices: tuple[Slice, ...]
    criteria: tuple[Criterion, ...] = ()
    that: tuple[str, ...] = (TRANSPARENT,)
    thresholds: tuple[Expr, ...] = ()
    encoder: Encoder | None = None
    within: Expr | None = None
    proofs: tuple[Proof, ...] = ()

    def _line(self) -> str:
        first, second = (x.path for x in self.free)
        return f"{titled(self.scene.title)}: {second} over {first}, {counted(len(self.slices), 'slice')}"

    @property
    def certified(self) -> bool:
        """Whether all slices are."""
        return all(r.certified for x in self.slices for r in (x.requirement, *x.contours))

    @cached_property
    def gaps(self) -> tuple[Gap, ...]:
        """What lies between neighbouring slices, and how far lines between them are off, as estimated."""
        return gaps(self.slices)

    @property
    def deviation(self) -> float | None:
        """The largest estimate of all, in units of the second parameter; None where no slices are joined by lines."""
        return max((x.deviation for x in self.gaps if x.deviation is not None), default=None)

    @cached_property
    def bounds(self) -> dict[Proof, tuple[float | None, ...]]:
        """Of each proof, between each two slices, how far off lines may be; None where no lines join them."""
        return {x: x.bounds(self.slices) for x in self.proofs}

    def bound(self, proof: Proof) -> float | None:
        """The largest of a proof, in units of the second parameter; None where no slices are joined by lines."""
        return max((x for x in self.bounds[proof] if x is not None), default=None)

    @property
    def height(self) -> float:
        """Of the second range."""
        low, high = self.ranges[1]
        return float(high - low)

    @property
    def is_coarse(self) -> bool:
        """Whether the slices were too few for what their lines were to be off by."""
        return (
            self.within is not None and self.deviation is not None and self.deviation > float(self.within) * self.height
        )

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
            "between": [{"from": x.low, "to": x.high, "deviation": x.deviation} for x in self.gaps],
            "deviation": self.deviation,
            **({"proven": [self._proven(x) for x in self.proofs]} if self.proofs else {}),
            "certified": self.certified,
        }

    def _proven(self, x: Proof) -> dict[str, Any]:
        """What is proven of a set between the slices."""
        return {
            "of": x.of,
            "jnd": None if x.jnd is None else float(x.jnd),
            "open": x.rectangles.share_left,
            "bound": self.bound(x),
            "between": list(self.bounds[x]),
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


WITHIN = Rational(1, 200)
"""What a map is refined to: lines between slices off by so much of the second range, as estimated."""


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
    within: Number | None = None,
    uniform: bool = False,
    limit: float | None = SECONDS,
    told: Told | None = None,
) -> DesignMap:
    """The transparent region in two parameters, by at most that many slices, more of them where its boundary bends.

    ``paths``: of both parameters; ``ranges``: of each, SI or with a unit. Every slice is a ``Requirement`` on the second one.
    ``within``: a share of the second range: slices are put in until straight lines between them are off by no more, as
    estimated, and slices that differ in kind no further apart than that share of the first range; 0.5 % if not given.
    ``uniform``: all slices, as far from each other, instead.
    ``that``, ``hand``, ``limit``, ``told``: as in ``require``; of slices that were not reached in time every value is undecided.
    ``jnd``: further thresholds, each with the region that is transparent with it. ``friction``, ``resolution``: of a device and
    its encoder, for Abbott and Okamura's bound beside the other classical ones.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = design_map(load_scene("fu2019"), ["zeta", "omega_n"], [("0.4", "0.6"), (50, 500)], slices=3)
    >>> [x.requirement.feasible[0].low.value.digits(6) for x in found.slices]
    ['103.831', '122.356', '141.462']
    """
    plan = Plan(slices, None if uniform else WITHIN if within is None else share_of(within))
    wanted = wishes(that)
    scene = with_hands(as_scene(scene), hand) if STABLE in wanted else as_scene(scene)
    asked = Asked.of(scene, paths, ranges, {"part": part, "any_environment": any_environment}, wanted, jnd)
    encoder = Encoder.of(scene, friction, resolution)
    need_encoder(scene, asked.free, encoder)
    with limited(limit, told) as budget:
        proofs = asked.proofs()
        found = asked.cut_all(plan, budget)
    return DesignMap(
        scene, asked.free, asked.ranges, found, asked.criteria, wanted, asked.thresholds, encoder, plan.within, proofs
    )
