"""The two-step evaluation of a measured scene, at its frequency points alone. Measured, not proven.

Each point is judged by its uncertainty disc (``judging``). Of the unresolved ones it is computed
what would resolve them: the coherence, the number of averages or the radius at which their discs
decide (``needed``).

Between the points something follows only where a bound on the slope of the response is stated:
intervals that exceed, lie below or stay unresolved (``between``). A cell of frequency lies between
two neighbouring points. Over all of it the true response lies in the disc of the left point as
grown at the cell's right end, in the disc of the right point as grown at its left end, and so in
the smallest disc around what both have in common. H_env is a disc over a cell as well, and the
border of a region moves by no more than ``spread`` where its numbers are formulas in omega. Cells
are halved until each is decided or no wider than rounding: an end of a decided interval lies within
that of where the swept discs cease to decide, always on the safe side. Read from ``judge``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import isfinite
from typing import Any, ClassVar, NamedTuple

import numpy as np
from sympy import Expr

from haptisym.judge.answers import Answer
from haptisym.judge.percepts import Change, Property
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.rings import omega
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.measured import (
    Complexes,
    Measurement,
    Reals,
    SlopeBound,
    averages_for,
    coherence_for,
)
from haptisym.model.measuredscene import MeasuredScene
from haptisym.programs.program import Program, Writer
from haptisym.programs.taylormodels import Modelled, TaylorModel, variable
from haptisym.verbs.measured.judging import (
    CODES,
    JudgedLine,
    Lines,
    PartVerdict,
    Signs,
    depth_of,
    ends_of,
    judged,
    lines_of,
    signs,
    upright,
    values_of,
)


def spread(c: Threshold, low: Reals, high: Reals, least: Reals) -> Reals:
    """Bound how far the border is anywhere in a cell from where it is at its middle, relative to
    ``|H_env|``; infinite where no bound is known.

    ``least`` : the least ``|H_env|`` in the cell, with which a floor is compared.
    """
    if c.is_constant:
        return np.zeros(len(low))
    moves = _Moves(low, high)
    with np.errstate(all="ignore"):
        if c.region.corners:
            bound = _of_polygon(c, moves)
        else:
            # A rectangle whose sides move: each point of its border by no more than all together.
            sides = [c.real, c.imag, *(x for x in c.region.lower if x is not None)]
            bound = sum((moves(x) for x in sides), np.zeros(len(low)))
        if c.region.shape is Shape.ELLIPSE:
            bound = _of_ellipse(c, moves, bound)
        if c.region.floor is not None and c.region.floor.has(omega):
            bound = bound + moves(c.region.floor) / least
    return np.where(np.isfinite(bound), bound, np.inf)


class _Moves:
    """A bound, for each cell, on how much a formula differs from its value at the middle of the
    cell."""

    def __init__(self, low: Reals, high: Reals) -> None:
        self.middle = (low + high) / 2
        self._at = variable(self.middle, (high - low) / 2, float(high.max()), 0, 1)._value

    def __call__(self, formula: Expr) -> Reals:
        if not formula.has(omega):
            return np.zeros(len(self.middle))
        # A Taylor model bounds the formula over the whole cell, all cells at once.
        model = _modelled(formula).run([self._at])[""]
        assert isinstance(model, TaylorModel)
        middle = values_of(formula, self.middle)
        lower, upper = (x[:, 0] for x in model.bounds())
        moved: Reals = np.maximum(upper - middle, middle - lower)
        return moved


@lru_cache(maxsize=64)
def _modelled(formula: Expr) -> Modelled:
    """Return a formula as a program that runs on Taylor models."""
    write = Writer((omega,))
    return Modelled(write.program({"": write.expression(formula)}))


def _of_ellipse(c: Threshold, moves: _Moves, sides: Reals) -> Reals:
    """Bound how far the border of an ellipse moves, its limits a and b together by ``sides``.

    Its support function is the length of M u with M = [[a, t b], [0, b sqrt(1 - t^2)]], |u| = 1,
    and changes by no more than the sum of the changes of the entries.
    """
    tilt = np.abs(values_of(c.region.tilt, moves.middle))
    turned = moves(c.region.tilt)
    # sqrt(1 - t^2) falls with |t|: it is furthest from its middle at one of the two ends.
    root = upright(tilt)
    ends = tilt - turned, tilt + turned
    roots = [np.abs(root - upright(np.clip(x, 0, 1))) for x in ends]
    size = values_of(c.real, moves.middle) + values_of(c.imag, moves.middle)
    size = size + sides
    bound: Reals = 2 * sides + size * (turned + np.maximum(*roots))
    return bound


def _of_polygon(c: Threshold, moves: _Moves) -> Reals:
    """Bound how far the border of a polygon moves: corners that move by d change where it meets an
    axis by at most d times its farthest over its nearest point."""
    corners = c.region.corners
    zero = np.zeros(len(moves.middle))
    d = sum((np.hypot(moves(x), moves(y)) for x, y in corners), zero)
    distances = [
        np.hypot(values_of(x, moves.middle), values_of(y, moves.middle)) for x, y in corners
    ]
    farthest = np.max(distances, axis=0) + d
    nearest = depth_of(c, moves.middle) - d
    return np.where(nearest > 0, d * farthest / nearest, np.inf)


_ROUNDING = 1e-13
"""Relative error of what is computed with discs, as a share of 1, of the change and of its radius:
far above the few roundings of each."""


@dataclass(frozen=True, eq=False)
class BetweenLines:
    """Cells of frequency between neighbouring points. ``gap`` : the index of the point before each;
    ``low``, ``high`` : its ends, rad/s."""

    gap: Any
    low: Reals
    high: Reals

    def at(self, chosen: Any) -> BetweenLines:
        """Return some of the cells."""
        return BetweenLines(self.gap[chosen], self.low[chosen], self.high[chosen])

    def halves(self) -> BetweenLines:
        """Return the two halves of each cell, in order."""
        middle = (self.low + self.high) / 2
        ends = (np.stack(x, 1).ravel() for x in ((self.low, middle), (middle, self.high)))
        return BetweenLines(np.repeat(self.gap, 2), *ends)


@dataclass(frozen=True, eq=False)
class Discs:
    """Discs in the complex plane, one for each cell: ``centre`` and ``radius`` in the unit of H."""

    centre: Complexes
    radius: Reals


class BoundedLines:
    """The points of a scene whose discs are bounded, and the discs between them."""

    def __init__(self, scene: MeasuredScene, x: Lines) -> None:
        # A point whose disc is the whole plane says nothing: its neighbours reach across it.
        kept = np.isfinite(x.perc_radius) & np.isfinite(x.env_radius)
        self.scene, self.omega = scene, x.omega[kept]
        self._felt = _Response(x.felt, self.omega, x.perceived[kept], x.perc_radius[kept])
        self._own = (
            None
            if x.own is None
            else _Response(x.own, self.omega, x.environment[kept], x.env_radius[kept])
        )

    @property
    def contradicted(self) -> Any:
        """For each gap, whether discs and bound contradict each other there: no response satisfies
        both."""
        felt = self._felt.contradicted
        return felt if self._own is None else felt | self._own.contradicted

    def lines(self, cells: BetweenLines) -> Iterator[Lines]:
        """Yield all cells as points, in three ways (``_Response.discs``); a verdict on any of
        them holds over the whole cell wherever the discs contain the true response."""
        env = self._environment(cells) if self._own is None else self._own.discs(cells)[-1]
        middle = (cells.low + cells.high) / 2
        size = np.abs(env.centre)
        more = spread(self.scene.threshold, cells.low, cells.high, np.maximum(size - env.radius, 0))
        for felt in self._felt.discs(cells):
            with np.errstate(all="ignore"):
                # The disc of a quotient, as in ``lines_of``, and larger by how far the border
                # moves: the region at the cell's middle then stands for that of the whole cell.
                change, share = (felt.centre - env.centre) / size, env.radius / size
                radius = ((env.radius + felt.radius) / size + np.abs(change) * share) / (1 - share)
                slack = _ROUNDING * (1 + np.abs(change) + radius)
                radius = np.where(share < 1, radius + more + slack, np.inf)
            source = self._felt.measurement
            yield Lines(
                middle,
                env.centre,
                felt.centre,
                env.radius,
                felt.radius,
                change,
                radius,
                source,
                None,
            )

    @cached_property
    def _program(self) -> Program:
        return self.scene.frame.distortion().chain.program(["environment_real", "environment_imag"])

    def _environment(self, cells: BetweenLines) -> Discs:
        """Return discs around all values of the environment's model over each cell: proven, but
        for the roundings of the last square root."""
        program = self._program
        middle, half = (cells.low + cells.high) / 2, (cells.high - cells.low) / 2
        at = variable(middle, half, float(cells.high.max()), 0, 1)._value
        parts = Modelled(program).run([at] if program.inputs else [])
        with np.errstate(all="ignore"):
            # A part that does not depend on omega comes back as a number.
            models = (x if isinstance(x, TaylorModel) else at.number(x) for x in parts.values())
            bounds = (x.bounds() for x in models)
            (a, b), (c, d) = ((low[:, 0], high[:, 0]) for low, high in bounds)
            # The rectangle of both parts lies in the disc around its centre, over its corners.
            centre = (a + b) / 2 + 0.5j * (c + d)
            known = np.isfinite(centre)
            to_corner = np.hypot(b - a, d - c) / 2 * (1 + _ROUNDING)
            radius = np.where(known, to_corner, np.inf)
        return Discs(np.where(known, centre, 0), radius)


@dataclass(frozen=True, eq=False)
class _Response:
    """A measured response with discs that grow away from their points as the slope allows."""

    measurement: Measurement
    omega: Reals
    H: Complexes
    radius: Reals

    def discs(self, cells: BetweenLines) -> list[Discs]:
        """Return the discs of the left point, of the right one, and around what both have in
        common."""
        left, right = self._of(cells.gap, cells.high), self._of(cells.gap + 1, cells.low)
        return [left, right, _common(left, right)]

    def _of(self, line: Any, at: Reals) -> Discs:
        """Return the discs of points, given by index, as grown at other frequencies, rad/s."""
        H = self.H[line]
        apart = np.abs(at - self.omega[line])
        return Discs(H, self._slope.grown(np.abs(H), self.radius[line], apart))

    @property
    def _slope(self) -> Any:
        return self.measurement.slope

    @property
    def contradicted(self) -> Any:
        """For each gap, whether the grown discs of its two points do not meet at some frequency."""
        sizes = np.abs(self.H) + self.radius
        apart = np.diff(self.omega)
        lines = np.arange(len(apart))
        # Where both radii together are least: if the discs meet there, they meet all over the gap.
        nearest = self._slope.nearest((sizes[:-1], sizes[1:]), apart)
        meeting = self.omega[:-1] + nearest
        left, right = self._of(lines, meeting), self._of(lines + 1, meeting)
        # With an allowance for rounding: discs that touch do not contradict each other.
        rounding = 1e-14 * (sizes[:-1] + sizes[1:])
        reach = (left.radius + right.radius) * (1 + 1e-12) + rounding
        return np.abs(left.centre - right.centre) > reach


def _common(x: Discs, y: Discs) -> Discs:
    """Return a disc around what two discs have in common, hardly larger than the smallest: that
    over their common chord, or one of the two.

    The foot of the chord is measured from the centre of the smaller disc, to which it is nearer:
    its error is then some roundings of that distance. The chord is made longer by as much.
    """
    first = x.radius <= y.radius
    begin, other = np.where(first, x.centre, y.centre), np.where(first, y.centre, x.centre)
    small, large = np.minimum(x.radius, y.radius), np.maximum(x.radius, y.radius)
    step = other - begin
    apart = np.abs(step)
    with np.errstate(all="ignore"):
        # (d^2 + r^2 - R^2)/(2 d) and half the chord sqrt(r^2 - foot^2), as products: squares of
        # nearly equal radii would cancel.
        foot = (apart - (large - small) * (large + small) / apart) / 2
        centre = begin + step * (foot / apart)
        square = np.maximum((small - foot) * (small + foot), 0)
        chord = np.sqrt(square + 1e-14 * small * (small + apart))
        chord += 1e-14 * (apart + np.abs(centre))
        # With the foot on the far side of its centre, or concentric discs (apart 0, no number),
        # what they have in common is no smaller than the small disc.
        between = (foot > 0) & (chord < small)
    return Discs(np.where(between, centre, begin), np.where(between, chord, small))


_NARROW = 1e-12
"""Share of its frequency at which a cell is not halved any more: floats have little more."""
_MOST = 200
"""Undecided cells of one gap at a time: more only come where a disc follows the border, and stay
undecided however often they are halved."""
_TOGETHER = 100_000
"""Gaps that are examined together: bounds the memory."""


@dataclass(frozen=True, eq=False)
class Stretches:
    """Neighbouring intervals of frequency from ``low`` to ``high``, rad/s; ``code`` : 1 exceeds,
    -1 below, 0 unresolved."""

    low: Reals
    high: Reals
    code: Any

    def __len__(self) -> int:
        return len(self.code)

    def rows(self) -> list[dict[str, Any]]:
        """Return the intervals as documents have them."""
        ends = zip(self.low.tolist(), self.high.tolist(), self.code.tolist(), strict=True)
        return [{"band": [low, high], "verdict": CODES[code].value} for low, high, code in ends]

    def length(self, code: int) -> float:
        """Return the total length of all intervals with a code, rad/s."""
        chosen = self.code == code
        return float((self.high[chosen] - self.low[chosen]).sum())


@dataclass(frozen=True, eq=False)
class Between:
    """The verdicts between the points. ``told`` : intervals of each part, and of None where the
    region judges both together. ``contradicted`` : from where to where lines differ by more than
    discs and bound allow, so that nothing is said. ``grown`` : the radius that discs have at most
    between the lines, relative to ``|H_env|``; of a stretch of none, 0."""

    told: Mapping[Part | None, Stretches]
    contradicted: tuple[tuple[float, float], ...]
    grown: float

    def row(self, slopes: Mapping[str, SlopeBound]) -> dict[str, Any]:
        """Return the verdicts as documents have them. ``slopes`` : each bound by its response."""
        bounds = {
            key: {"bound": x.bound, "unit": x.unit, "relative": x.relative}
            for key, x in slopes.items()
        }
        told = {part.value if part else "joint": x.rows() for part, x in self.told.items()}
        contradicted = [list(x) for x in self.contradicted]
        return {
            "slope": bounds,
            **told,
            "contradicted": contradicted,
            "grown": self.grown if isfinite(self.grown) else None,
        }


def between(scene: MeasuredScene, x: Lines) -> Between | None:
    """Judge all gaps between the points of a scene; None without a bound on the slope."""
    if scene.perceived.slope is None:
        return None
    swept = BoundedLines(scene, x)
    wrong = swept.contradicted
    parts = [part for part in (*Part, None) if judged(scene, x, part)]
    told = {part: _joined(swept, wrong, part) for part in parts}
    lost = [
        (float(a), float(b))
        for a, b in zip(swept.omega[:-1][wrong], swept.omega[1:][wrong], strict=True)
    ]
    return Between(told, tuple(lost), _grown(swept))


def _grown(swept: BoundedLines) -> float:
    """Return the largest radius, relative to ``|H_env|``, that a disc has halfway between two
    points, where the smaller of both is largest."""
    gaps = np.arange(len(swept.omega) - 1)
    if not len(gaps):
        return 0.0
    middle = (swept.omega[:-1] + swept.omega[1:]) / 2
    cells = BetweenLines(gaps, middle, middle)
    radii = [x.radius for x in swept.lines(cells) if x.radius is not None]
    return float(np.min(radii[:2], axis=0).max())


def _joined(swept: BoundedLines, wrong: Any, part: Part | None) -> Stretches:
    """Join neighbouring cells that have the same verdict; gaps that are contradicted are
    unresolved."""
    gaps = np.flatnonzero(~wrong)
    lost = np.flatnonzero(wrong)
    contradicted = BetweenLines(lost, swept.omega[lost], swept.omega[lost + 1])
    settled = [(contradicted, np.zeros(len(lost), int))]
    for start in range(0, len(gaps), _TOGETHER):
        settled += _settled(swept, gaps[start : start + _TOGETHER], part)
    low = np.concatenate([cells.low for cells, _ in settled])
    high = np.concatenate([cells.high for cells, _ in settled])
    code = np.concatenate([codes for _, codes in settled])
    order = np.argsort(low, kind="stable")
    low, high, code = low[order], high[order], code[order]
    if not len(code):
        return Stretches(low, high, code)
    # 2 is no code: the first cell begins an interval.
    starts = np.flatnonzero(np.diff(code, prepend=2))
    return Stretches(low[starts], high[np.append(starts[1:], len(code)) - 1], code[starts])


def _settled(swept: BoundedLines, gaps: Any, part: Part | None) -> list[tuple[BetweenLines, Any]]:
    """Return cells that cover gaps, each with its code."""
    settled = []
    cells = BetweenLines(gaps, swept.omega[gaps], swept.omega[gaps + 1])
    while len(cells.gap):
        code, is_open = _code(swept, cells, part)
        undecided = cells.gap[~is_open & (code == 0)]
        crowd = np.bincount(undecided, minlength=len(swept.omega)) > _MOST
        is_narrow = cells.high - cells.low <= _NARROW * cells.high
        done = (code != 0) | is_open | is_narrow | crowd[cells.gap]
        settled.append((cells.at(done), code[done]))
        cells = cells.at(~done).halves()
    return settled


def _code(swept: BoundedLines, cells: BetweenLines, part: Part | None) -> tuple[Any, Any]:
    """Return for each cell the code that one of its discs decides, and whether it lies so deep
    inside an unresolved interval that halving cannot decide it."""
    middle = (cells.low + cells.high) / 2
    codes, is_open = np.zeros(len(middle), int), np.ones(len(middle), bool)
    middles = BetweenLines(cells.gap, middle, middle)
    for whole, point in zip(swept.lines(cells), swept.lines(middles), strict=True):
        over_cell, at_middle = (judged(swept.scene, x, part) for x in (whole, point))
        assert over_cell
        assert at_middle
        assert whole.radius is not None
        assert point.radius is not None
        codes = np.where(codes == 0, over_cell.verdict, codes)
        # A disc straddles the border by radius - |distance|. At the middle alone, the cell's width
        # adds nothing: if it straddles by twice what the width makes, halves will straddle, too.
        with np.errstate(invalid="ignore"):
            difference = np.abs(over_cell.distance - at_middle.distance)
            moved = whole.radius - point.radius + difference
            is_open &= point.radius - np.abs(at_middle.distance) > 2 * moved
    return codes, is_open & (codes == 0)


MOST_AVERAGES = 1e6
"""More averages than anyone takes: a point that would need more lies at its threshold, for any
practical measurement."""

MOST_COHERENCE = 1 - 1e-6
"""A coherence above that of any bench."""


@dataclass(frozen=True)
class Remedy:
    """The value that resolves half of the unresolved points, and all of them; None where no
    practical one does."""

    half: float | None
    all: float | None

    def row(self) -> dict[str, Any]:
        """Return the values as a document has them."""
        return {"half": self.half, "all": self.all}


@dataclass(frozen=True)
class Needed:
    """What would resolve the unresolved points if the estimates stay where they are, each quantity
    alone, the others as they are.

    ``radius`` : at most, relative to ``|H_env|``. ``coherence``, ``averages`` : at least; None
    where the discs do not come from them, or not from them alone.
    """

    lines: int
    radius: Remedy
    coherence: Remedy | None
    averages: Remedy | None


def needed(x: Lines, found: Sequence[JudgedLine]) -> Needed | None:
    """Return what would resolve the points that are unresolved in some judgement; None if all
    are resolved."""
    open_lines = np.any([one.verdict == 0 for one in found], axis=0)
    if not open_lines.any():
        return None
    # A disc decides as soon as its radius is below the distance of the change from the border; of
    # several judgements the smallest counts.
    margins = [np.where(one.verdict == 0, np.abs(one.distance), np.inf) for one in found]
    margin = np.min(margins, axis=0)[open_lines]
    felt, env = x.felt, x.own
    coherence = averages = None
    if felt.coherence is not None and (env is None or env.discs is None):
        coherence, averages = _of_coherence(felt, x, margin, open_lines)
    return Needed(int(open_lines.sum()), _shares(-margin, negated=True), coherence, averages)


def _of_coherence(felt: Measurement, x: Lines, margin: Reals, at: Any) -> tuple[Remedy, Remedy]:
    """Return coherence and number of averages that would be enough, each with the other as it
    is."""
    assert felt.averages is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = margin * np.abs(x.environment[at]) / np.abs(x.perceived[at])
    coherence = coherence_for(relative, felt.averages, felt.confidence)
    averages = averages_for(relative, felt.coherence[at], felt.confidence)
    return _shares(coherence, most=MOST_COHERENCE), _shares(averages, most=MOST_AVERAGES)


def _shares(values: Reals, *, most: float = np.inf, negated: bool = False) -> Remedy:
    """Return the value that is enough for at least half of the points, and for all; None for one
    above ``most``. ``negated`` : the values are, so that the smallest is asked for."""
    row, middle = np.nan_to_num(values, nan=np.inf), (len(values) - 1) // 2
    # A partition gives what sorting would, in a fourth of the time.
    enough = float(np.partition(row, middle)[middle]), float(row.max())
    remedies: list[float | None] = []
    for value in enough:
        if value > most or not np.isfinite(value):
            remedies.append(None)
        else:
            remedies.append(-value if negated else value)
    return Remedy(*remedies)


class LineResult(NamedTuple):
    """The result at one frequency point. ``radius`` : of the disc around the change, relative to
    ``|H_env|``; None where none is known."""

    omega: float
    ratio_real: float
    ratio_imag: float
    radius: float | None
    real: PartVerdict
    imag: PartVerdict
    joint: PartVerdict | None = None


class MeasuredPercept(NamedTuple):
    """What is felt of a part at one frequency point, as far as the discs decide it.

    ``part`` : None where both are noticed together, neither by itself; ``property`` and ``change``
    are then of the part that lies nearer its own limit, and ``other`` is how the other one has
    changed.
    """

    part: Part | None
    omega: float
    property: Property
    change: Change
    other: tuple[Property, Change] | None = None


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredEvaluation(Answer):
    """The two steps at each measured frequency point: dH/abs(H_env) with its uncertainty disc,
    against the threshold.

    ``lines`` : arrays over the points: ``omega``, rad/s, both responses and radii, N/m or N m/rad,
    ``change`` = dH/abs(H_env)
    (complex) and its ``radius``. ``distance`` : of each part's ratio from its threshold, positive
    above it. ``verdict`` : of each part 1 where the whole disc exceeds, -1 where all of it is
    below, 0 where it is unresolved; ``joint`` : the same of a region that judges both parts
    together, else None. ``signs`` : those that step 2 needs. ``rows``, ``percepts`` : the same as
    values. ``needed`` : which radius, coherence or averages would resolve the rest. ``scene`` :
    with the data.

    Measured: it is true at the points, where the discs contain the response (``confidence`` of the
    file); between points only with a bound on the slope. ``certified`` is False.

    >>> import haptisym as hs
    >>> row = hs.evaluate("fu2019-bench").rows[0]
    >>> round(row.omega, 4), row.real.value
    (1.5708, 'below')
    """

    _schema: ClassVar[str] = "haptisym.measured/1"
    _page: ClassVar[str] = "haptisym.pages.measured:page"
    settled = True
    _figure: ClassVar[str] = "haptisym.figures.measured:MEASURED"

    scene: MeasuredScene
    lines: Lines
    distance: Mapping[Part, Reals]
    verdict: Mapping[Part, Any]
    joint: JudgedLine | None
    signs: Mapping[Part, Signs]
    needed: Needed | None

    def _line(self) -> str:
        counts = [
            f"{int((self.verdict[part] == code).sum())} {x.value}"
            for part in Part
            for code, x in CODES.items()
        ]
        lines = counted(len(self), "line")
        return (
            f"{titled(self.scene.title)}: {lines}, real {', '.join(counts[:3])}, imaginary "
            f"{', '.join(counts[3:])}"
        )

    def __len__(self) -> int:
        return len(self.lines.omega)

    @cached_property
    def between(self) -> Between | None:
        """The verdicts between the points; None without a bound on the slope."""
        return between(self.scene, self.lines)

    @property
    def _points(self) -> list[Stretches]:
        """The verdicts that decide the bandwidth at the points: of each part, or of both."""
        codes = [self.joint.verdict] if self.joint else [self.verdict[part] for part in Part]
        return [Stretches(self.lines.omega, self.lines.omega, x) for x in codes]

    @property
    def _intervals(self) -> list[Stretches]:
        """The same between the points; none without a bound on the slope."""
        told = {} if self.between is None else self.between.told
        parts: Sequence[Part | None] = [None] if self.joint else [*Part]
        return [told[part] for part in parts if part in told and len(told[part])]

    @cached_property
    def reach(self) -> tuple[float | None, float | None]:
        """Return bounds of the bandwidth, rad/s: up to the first everything is below its threshold,
        at the second something exceeds it. None where not even the first point is below, and where
        nothing exceeds."""
        least = []
        # With a bound on the slope what lies between the points must be below, too.
        for x in self._intervals or self._points:
            open_ = np.flatnonzero(x.code != -1)
            end = int(open_[0]) if len(open_) else len(x)
            least.append(float(x.high[end - 1]) if end else -1.0)
        exceeding = [x.low[x.code == 1] for x in (*self._points, *self._intervals)]
        most = min((float(x[0]) for x in exceeding if len(x)), default=None)
        return (min(least) if min(least) >= 0 else None), most

    @property
    def is_below_throughout(self) -> bool:
        """Whether nothing is noticed at any point, and nothing is unresolved."""
        return all((x.code == -1).all() for x in (*self._points, *self._intervals))

    @property
    def limited_by(self) -> tuple[Part, ...]:
        """The parts, one of which ends the bandwidth: up to where something exceeds they are not
        below their thresholds at all points, or exceed them between two. None where nothing does,
        or both are judged together."""
        _, most = self.reach
        if most is None or self.joint:
            return ()
        at_points, between_ = self._points, self._intervals or self._points
        judged = zip(Part, at_points, between_, strict=True)
        return tuple(
            part
            for part, x, y in judged
            if (x.code[x.low <= most] != -1).any() or (y.code[y.low <= most] == 1).any()
        )

    @property
    def certified(self) -> bool:
        """False: what is measured is not proven."""
        return False

    @property
    def left_out(self) -> int:
        """Lines of the perceived response that are not judged: off the band, or without a line of
        the environment."""
        return len(self.scene.perceived) - len(self)

    @property
    def is_turned_round(self) -> bool:
        """Whether the response is nearer to -H_env than to H_env at every point: the reaction to
        the force may have been measured."""
        felt, wanted = self.lines.perceived, self.lines.environment
        return len(self) > 1 and bool((np.abs(felt + wanted) < np.abs(felt - wanted)).all())

    @property
    def is_active_throughout(self) -> bool:
        """Whether Im H is negative at every point, and that of the environment is not: the sign of
        the imaginary part may be turned round."""
        felt, wanted = self.lines.perceived.imag, self.lines.environment.imag
        return len(self) > 1 and bool(((felt < 0) & (wanted >= 0)).all())

    @cached_property
    def rows(self) -> tuple[LineResult, ...]:
        """The result at every point that is judged."""
        return tuple(self._rows())

    def _rows(self) -> Iterator[LineResult]:
        """Yield the result at each point: column by column from arrays, as files may have many."""
        x = self.lines
        radius = [None] * len(self) if x.radius is None else x.radius.tolist()
        ratios = np.abs(x.change.real).tolist(), np.abs(x.change.imag).tolist()
        codes = [self.verdict[part] for part in Part]
        if self.joint:
            codes.append(self.joint.verdict)
        verdicts = ((CODES[code] for code in row.tolist()) for row in codes)
        yield from map(LineResult, x.omega.tolist(), *ratios, radius, *verdicts)

    def noticed(self, part: Part | None) -> Any:
        """Return at which points step 2 asks how a part is felt; for None, where both are
        noticed together and neither by itself."""
        if self.joint is None:
            return self.verdict[part] == 1 if part else np.zeros(len(self), dtype=bool)
        alone = [self.verdict[x] for x in Part]
        chosen = self.verdict[part] == 1 if part else (alone[0] == -1) & (alone[1] == -1)
        return (self.joint.verdict == 1) & chosen

    def named(self, part: Part | None) -> Any:
        """Return at which points a property is named: the part is noticed, and the signs that
        name it are known."""
        asked = Part if part is None else (part,)
        known = np.all([self.signs[x].known for x in asked], axis=0)
        named = self.noticed(part) & known
        if part is Part.REAL:
            return named
        # A negative imaginary part is no damping: what is active has no name in the model.
        return named & ~(self.signs[Part.IMAG].perceived < 0)

    @cached_property
    def percepts(self) -> tuple[MeasuredPercept, ...]:
        """What is felt, at each point where the discs decide it."""
        wanted = (*Part, None)
        return tuple(
            self._percept(part, i)
            for part in wanted
            for i in np.flatnonzero(self.named(part)).tolist()
        )

    def order(self, line: int) -> list[Part]:
        """Both parts, the one that lies nearer its own limit last, as estimated."""
        return [Part.IMAG, Part.REAL] if self.real_nearer[line] else [Part.REAL, Part.IMAG]

    @cached_property
    def real_nearer(self) -> Any:
        """Where, over the points, the real part's change is a larger share of its own limit than
        the imaginary part's."""
        x = self.lines
        sides = {Part.REAL: x.change.real, Part.IMAG: x.change.imag}
        ends = {part: ends_of(self.scene.threshold, part, x.omega) for part in Part}
        real, imag = (
            np.maximum(side / ends[part][1], side / ends[part][0]) for part, side in sides.items()
        )
        return real > imag

    def _percept(self, part: Part | None, i: int) -> MeasuredPercept:
        omega = float(self.lines.omega[i])
        if part is not None:
            return MeasuredPercept(part, omega, *self.signs[part].label(part, i))
        far, near = self.order(i)
        return MeasuredPercept(
            None, omega, *self.signs[near].label(near, i), self.signs[far].label(far, i)
        )

    @property
    def _understood(self) -> dict[str, str]:
        """How each file was understood: its units and columns, in words."""
        both = {"environment": self.scene.environment, "perceived": self.scene.perceived}
        return {
            key: x.understood
            for key, x in both.items()
            if isinstance(x, Measurement) and x.understood
        }

    def _body(self) -> dict[str, Any]:
        felt = self.scene.perceived
        return {
            "lines": len(self),
            "left_out": self.left_out,
            "threshold": self.scene.threshold.row(),
            **({"understood": read} if (read := self._understood) else {}),
            "averages": felt.averages,
            **({} if felt.welch is None else {"estimate": felt.welch.row()}),
            "confidence": None if self.lines.radius is None else felt.confidence,
            "rows": [_row(x) for x in self._rows()],
            "percepts": [_percept(p) for p in self.percepts],
            **({} if self.between is None else {"between": self.between.row(self.scene.slopes)}),
            "needed": None if self.needed is None else _needed(self.needed),
            "certified": self.certified,
        }

    def to_json(self) -> str:
        """Return the document as text, with one line for each frequency point."""

        def told(key: str, value: Any) -> str:
            if key in ("rows", "percepts") and value:
                return "[\n    " + ",\n    ".join(map(json.dumps, value)) + "\n  ]"
            return json.dumps(value, indent=2, ensure_ascii=False).replace("\n", "\n  ")

        parts = (f"{json.dumps(key)}: {told(key, value)}" for key, value in self.to_dict().items())
        return "{\n  " + ",\n  ".join(parts) + "\n}"

    def kinds(self, part: Part | None) -> Any:
        """Return a number for each point: the same where a part, or None for both together, is
        felt in the same way."""
        # Signs are -1 to 2: in base 3 with an offset different signs have different numbers, unless
        # one is open, and then nothing is named.
        kind = np.zeros(len(self), dtype=int)
        for x in Part if part is None else (part,):
            signs_of = self.signs[x]
            code = 27 + 9 * signs_of.environment + 3 * signs_of.perceived + signs_of.compared
            kind = 1000 * kind + code
        return kind if part else 2 * kind + self.real_nearer


def _percept(p: MeasuredPercept) -> dict[str, Any]:
    if p.part is None and p.other:
        felt: Any = [p.other[0].value, p.property.value], [p.other[1].value, p.change.value]
    else:
        felt = p.property.value, p.change.value
    return {
        "part": p.part.value if p.part else "joint",
        "omega": p.omega,
        "property": felt[0],
        "change": felt[1],
    }


def _row(x: LineResult) -> dict[str, Any]:
    numbers = {"ratio_real": x.ratio_real, "ratio_imag": x.ratio_imag, "radius": x.radius}
    finite = {
        key: value if value is not None and isfinite(value) else None
        for key, value in numbers.items()
    }
    return {"omega": x.omega, **finite, "real": x.real.value, "imag": x.imag.value} | (
        {} if x.joint is None else {"joint": x.joint.value}
    )


def _needed(x: Needed) -> dict[str, Any]:
    shares = {"radius": x.radius, "coherence": x.coherence, "averages": x.averages}
    return {"lines": x.lines} | {
        key: share.row() for key, share in shares.items() if share is not None
    }


def judge(scene: MeasuredScene) -> MeasuredEvaluation:
    """Judge every measured line of a scene on its band. SceneError where there is none.

    >>> from haptisym import environments
    >>> from haptisym.model.measuring import measured
    >>> felt = measured([2, 8], [92.8 + 30j, -30 + 120j], radius=[2, 2])
    >>> found = judge(MeasuredScene(environments.mass_spring_damper(1.8, 15, 100), felt))
    >>> [(x.real.value, x.imag.value) for x in found.rows]
    [('below', 'below'), ('exceeds', 'below')]
    """
    if not isinstance(scene, MeasuredScene):
        raise SceneError(
            f"{type(scene).__name__} is not a measured scene: make one with "
            f"MeasuredScene(environment, perceived)"
        )
    x = lines_of(scene)
    alone = {part: one for part in Part if (one := judged(scene, x, part))}
    joint = judged(scene, x, None)
    distance = {part: one.distance for part, one in alone.items()}
    verdict = {part: one.verdict for part, one in alone.items()}
    return MeasuredEvaluation(
        scene,
        x,
        distance,
        verdict,
        joint,
        {part: signs(x, part) for part in Part},
        needed(x, [joint] if joint else list(alone.values())),
    )
