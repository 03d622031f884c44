"""The two-step evaluation of a measured scene, at the measured frequencies alone. Measured, never
certified.

Each line is judged by its disc (``judging``), and what would resolve the open ones is told: the
coherence, the number of averages or the radius at which their discs decide.

Between the lines something is told where a bound on the slope is stated: stretches that exceed, lie
below or stay unresolved. A cell of frequency lies between two neighbouring lines. Over all of it
the truth lies in the disc of the left line as grown at the cell's right end, in the disc of the
right line as grown at its left end, and so in the smallest disc around what both have in common;
H_env is a disc over a cell as well, and the border of a region moves by no more than ``spread``
where its numbers are formulas in omega. Cells are halved until each is told or no wider than
rounding: an end of a stretch that is told lies within that of where the swept discs cease to tell,
always on the safe side.
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
    """At most how far the border is anywhere in a cell from where it is at its middle, relative to
    ``|H_env|``.

    ``least`` : the least ``|H_env|`` in the cell, with which a floor is compared.
    """
    if c.is_constant:
        return np.zeros(len(low))
    moves = _Moves(low, high)
    with np.errstate(all="ignore"):
        if c.region.corners:
            found = _of_polygon(c, moves)
        else:
            sides = [c.real, c.imag, *(x for x in c.region.lower if x is not None)]
            found = sum((moves(x) for x in sides), np.zeros(len(low)))
        if c.region.shape is Shape.ELLIPSE:
            found = _of_ellipse(c, moves, found)
        if c.region.floor is not None and c.region.floor.has(omega):
            found = found + moves(c.region.floor) / least
    return np.where(np.isfinite(found), found, np.inf)


class _Moves:
    """By how much a formula differs at most from what it is at the middle of each cell."""

    def __init__(self, low: Reals, high: Reals) -> None:
        self.middle = (low + high) / 2
        self._at = variable(self.middle, (high - low) / 2, float(high.max()), 0, 1)._value

    def __call__(self, formula: Expr) -> Reals:
        if not formula.has(omega):
            return np.zeros(len(self.middle))
        found = _modelled(formula).run([self._at])[""]
        assert isinstance(found, TaylorModel)
        here, (least, most) = values_of(formula, self.middle), (x[:, 0] for x in found.bounds())
        moved: Reals = np.maximum(most - here, here - least)
        return moved


@lru_cache(maxsize=64)
def _modelled(formula: Expr) -> Modelled:
    write = Writer((omega,))
    return Modelled(write.program({"": write.expression(formula)}))


def _of_ellipse(c: Threshold, moves: _Moves, sides: Reals) -> Reals:
    """Its support function is the length of M u with M = [[a, t b], [0, b sqrt(1 - t^2)]]: M moves
    by no more than this."""
    tilt, turned = np.abs(values_of(c.region.tilt, moves.middle)), moves(c.region.tilt)
    root = upright(tilt)
    roots = [np.abs(root - upright(np.clip(x, 0, 1))) for x in (tilt - turned, tilt + turned)]
    size = values_of(c.real, moves.middle) + values_of(c.imag, moves.middle) + sides
    found: Reals = 2 * sides + size * (turned + np.maximum(*roots))
    return found


def _of_polygon(c: Threshold, moves: _Moves) -> Reals:
    """Corners that move by d change where the border meets an axis by at most d times its farthest
    over its nearest point."""
    corners = c.region.corners
    d = sum(
        (np.hypot(*(moves(x) for x in corner)) for corner in corners), np.zeros(len(moves.middle))
    )
    farthest = (
        np.max(
            [np.hypot(*(values_of(x, moves.middle) for x in corner)) for corner in corners], axis=0
        )
        + d
    )
    nearest = depth_of(c, moves.middle) - d
    return np.where(nearest > 0, d * farthest / nearest, np.inf)


_ROUNDING = 1e-13
"""Of what is computed around the discs, relative to 1, to the change and to its radius."""


@dataclass(frozen=True, eq=False)
class BetweenLines:
    """``gap`` : after which line each lies; ``low``, ``high`` : its ends, rad/s."""

    gap: Any
    low: Reals
    high: Reals

    def at(self, chosen: Any) -> BetweenLines:
        """Some of them."""
        return BetweenLines(self.gap[chosen], self.low[chosen], self.high[chosen])

    def halves(self) -> BetweenLines:
        """Each as its two halves, in order."""
        middle = (self.low + self.high) / 2
        ends = (np.stack(x, 1).ravel() for x in ((self.low, middle), (middle, self.high)))
        return BetweenLines(np.repeat(self.gap, 2), *ends)


@dataclass(frozen=True, eq=False)
class Discs:
    """``centre``, ``radius`` : one for each cell."""

    centre: Complexes
    radius: Reals


class BoundedLines:
    """The lines of a scene of which the discs are bounded, and what lies between them."""

    def __init__(self, scene: MeasuredScene, x: Lines) -> None:
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
        """For each gap, whether discs and bound contradict each other there: no response keeps to
        both."""
        found = self._felt.contradicted
        return found if self._own is None else found | self._own.contradicted

    def lines(self, cells: BetweenLines) -> Iterator[Lines]:
        """Each cell as a line, in three ways; what is said of one of them is true wherever the
        discs hold the truth."""
        env = self._environment(cells) if self._own is None else self._own.discs(cells)[-1]
        middle = (cells.low + cells.high) / 2
        size = np.abs(env.centre)
        more = spread(self.scene.threshold, cells.low, cells.high, np.maximum(size - env.radius, 0))
        for felt in self._felt.discs(cells):
            with np.errstate(all="ignore"):
                change, share = (felt.centre - env.centre) / size, env.radius / size
                radius = ((env.radius + felt.radius) / size + np.abs(change) * share) / (1 - share)
                radius = np.where(
                    share < 1, radius + more + _ROUNDING * (1 + np.abs(change) + radius), np.inf
                )
            own = self._felt.measurement
            yield Lines(
                middle, env.centre, felt.centre, env.radius, felt.radius, change, radius, own, None
            )

    @cached_property
    def _program(self) -> Program:
        return self.scene.frame.distortion().chain.program(["environment_real", "environment_imag"])

    def _environment(self, cells: BetweenLines) -> Discs:
        """Around all that the model is over each cell: proven, but for the roundings of the last
        square root."""
        program = self._program
        at = variable(
            (cells.low + cells.high) / 2,
            (cells.high - cells.low) / 2,
            float(cells.high.max()),
            0,
            1,
        )._value
        found = Modelled(program).run([at] if program.inputs else [])
        with np.errstate(all="ignore"):
            models = (x if isinstance(x, TaylorModel) else at.number(x) for x in found.values())
            (a, b), (c, d) = ((low[:, 0], high[:, 0]) for low, high in (x.bounds() for x in models))
            centre = (a + b) / 2 + 0.5j * (c + d)
            known = np.isfinite(centre)
            radius = np.where(known, np.hypot(b - a, d - c) / 2 * (1 + _ROUNDING), np.inf)
        return Discs(np.where(known, centre, 0), radius)


@dataclass(frozen=True, eq=False)
class _Response:
    measurement: Measurement
    omega: Reals
    H: Complexes
    radius: Reals

    def discs(self, cells: BetweenLines) -> list[Discs]:
        """Of the left line, of the right one, and around what they have in common."""
        left, right = self._of(cells.gap, cells.high), self._of(cells.gap + 1, cells.low)
        return [left, right, _common(left, right)]

    def _of(self, line: Any, at: Reals) -> Discs:
        H = self.H[line]
        return Discs(
            H, self._slope.grown(np.abs(H), self.radius[line], np.abs(at - self.omega[line]))
        )

    @property
    def _slope(self) -> Any:
        return self.measurement.slope

    @property
    def contradicted(self) -> Any:
        sizes, apart = np.abs(self.H) + self.radius, np.diff(self.omega)
        lines = np.arange(len(apart))
        at = self.omega[:-1] + self._slope.nearest((sizes[:-1], sizes[1:]), apart)
        left, right = self._of(lines, at), self._of(lines + 1, at)
        reach = (left.radius + right.radius) * (1 + 1e-12) + 1e-14 * (sizes[:-1] + sizes[1:])
        return np.abs(left.centre - right.centre) > reach


def _common(x: Discs, y: Discs) -> Discs:
    """A disc around what two discs have in common, hardly larger than the smallest: that over their
    common chord, or one of them.

    From the smaller one's centre the chord is no further than that of the other, and so its place
    known to roundings of that:
    with them the chord is made longer, and its disc larger.
    """
    first = x.radius <= y.radius
    own, other = np.where(first, x.centre, y.centre), np.where(first, y.centre, x.centre)
    small, large = np.minimum(x.radius, y.radius), np.maximum(x.radius, y.radius)
    step = other - own
    apart = np.abs(step)
    with np.errstate(all="ignore"):
        foot = (apart - (large - small) * (large + small) / apart) / 2
        centre = own + step * (foot / apart)
        chord = np.sqrt(
            np.maximum((small - foot) * (small + foot), 0) + 1e-14 * small * (small + apart)
        )
        chord += 1e-14 * (apart + np.abs(centre))
        between = (foot > 0) & (chord < small)
    return Discs(np.where(between, centre, own), np.where(between, chord, small))


_NARROW = 1e-12
"""Of its frequency: a cell that is not halved any more."""
_MOST = 200
"""Cells of one gap at one time: more are open only where a disc follows the border, and stay so."""
_TOGETHER = 100_000
"""Gaps."""


@dataclass(frozen=True, eq=False)
class Stretches:
    """From ``low`` to ``high``, rad/s, without gaps; ``code`` : 1 exceeds, -1 below, 0
    unresolved."""

    low: Reals
    high: Reals
    code: Any

    def __len__(self) -> int:
        return len(self.code)

    def rows(self) -> list[dict[str, Any]]:
        """As documents have it."""
        ends = zip(self.low.tolist(), self.high.tolist(), self.code.tolist(), strict=True)
        return [{"band": [low, high], "verdict": CODES[code].value} for low, high, code in ends]

    def length(self, code: int) -> float:
        """Of all of one kind together, rad/s."""
        own = self.code == code
        return float((self.high[own] - self.low[own]).sum())


@dataclass(frozen=True, eq=False)
class Between:
    """``told`` : of each part, and of None where the region judges both together. ``contradicted``
    : from where to where lines differ by more than discs and bound allow, so that nothing is said.
    ``grown`` : the radius that discs have at most between the lines, relative to ``|H_env|``; of a
    stretch of none, 0."""

    told: Mapping[Part | None, Stretches]
    contradicted: tuple[tuple[float, float], ...]
    grown: float

    def row(self, slopes: Mapping[str, SlopeBound]) -> dict[str, Any]:
        """As documents have it. ``slopes`` : of which response each bound is."""
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
    """Of all gaps between the lines that a scene judges; None without a bound on the slope."""
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
    """At the places half-way, where grown discs have most."""
    gaps = np.arange(len(swept.omega) - 1)
    if not len(gaps):
        return 0.0
    middle = (swept.omega[:-1] + swept.omega[1:]) / 2
    radii = [
        x.radius for x in swept.lines(BetweenLines(gaps, middle, middle)) if x.radius is not None
    ]
    return float(np.min(radii[:2], axis=0).max())


def _joined(swept: BoundedLines, wrong: Any, part: Part | None) -> Stretches:
    """Neighbouring cells that are told alike as one stretch."""
    gaps = np.flatnonzero(~wrong)
    found = [
        (
            BetweenLines(lost := np.flatnonzero(wrong), swept.omega[lost], swept.omega[lost + 1]),
            np.zeros(len(lost), int),
        )
    ]
    for start in range(0, len(gaps), _TOGETHER):
        found += _settled(swept, gaps[start : start + _TOGETHER], part)
    low, high = (
        np.concatenate([getattr(cells, key) for cells, _ in found]) for key in ("low", "high")
    )
    code, order = np.concatenate([x for _, x in found]), np.argsort(low, kind="stable")
    low, high, code = low[order], high[order], code[order]
    if not len(code):
        return Stretches(low, high, code)
    starts = np.flatnonzero(np.diff(code, prepend=2))
    return Stretches(low[starts], high[np.append(starts[1:], len(code)) - 1], code[starts])


def _settled(swept: BoundedLines, gaps: Any, part: Part | None) -> list[tuple[BetweenLines, Any]]:
    """Cells of gaps, each with what is told of it."""
    found = []
    cells = BetweenLines(gaps, swept.omega[gaps], swept.omega[gaps + 1])
    while len(cells.gap):
        code, is_open = _code(swept, cells, part)
        crowd = np.bincount(cells.gap[~is_open & (code == 0)], minlength=len(swept.omega)) > _MOST
        done = (
            (code != 0)
            | is_open
            | (cells.high - cells.low <= _NARROW * cells.high)
            | crowd[cells.gap]
        )
        found.append((cells.at(done), code[done]))
        cells = cells.at(~done).halves()
    return found


def _code(swept: BoundedLines, cells: BetweenLines, part: Part | None) -> tuple[Any, Any]:
    """Of each cell what one of its discs tells, and whether it lies too far within what none tells
    to be halved."""
    middle = (cells.low + cells.high) / 2
    codes, is_open = np.zeros(len(middle), int), np.ones(len(middle), bool)
    for whole, point in zip(
        swept.lines(cells), swept.lines(BetweenLines(cells.gap, middle, middle)), strict=True
    ):
        told, here = judged(swept.scene, whole, part), judged(swept.scene, point, part)
        assert told
        assert here
        assert whole.radius is not None
        assert point.radius is not None
        codes = np.where(codes == 0, told.verdict, codes)
        with np.errstate(invalid="ignore"):
            moved = whole.radius - point.radius + np.abs(told.distance - here.distance)
            is_open &= point.radius - np.abs(here.distance) > 2 * moved
    return codes, is_open & (codes == 0)


MOST_AVERAGES = 1e6
"""More than anyone takes: a line that would need more lies at its threshold, as far as measuring
goes."""

MOST_COHERENCE = 1 - 1e-6
"""More than any bench gives."""


@dataclass(frozen=True)
class Remedy:
    """What resolves half of the open lines, and all of them; None where nothing sensible does."""

    half: float | None
    all: float | None

    def row(self) -> dict[str, Any]:
        """As a document has it."""
        return {"half": self.half, "all": self.all}


@dataclass(frozen=True)
class Needed:
    """What would resolve open lines if the estimates stay where they are, each quantity alone, the
    others as they are.

    ``radius`` : at most, relative to ``|H_env|``. ``coherence``, ``averages`` : at least; None
    where the discs do not come from them, or not from them alone.
    """

    lines: int
    radius: Remedy
    coherence: Remedy | None
    averages: Remedy | None


def needed(x: Lines, found: Sequence[JudgedLine]) -> Needed | None:
    """Of the lines that are open in some judgement; None if none is."""
    open_lines = np.any([one.verdict == 0 for one in found], axis=0)
    if not open_lines.any():
        return None
    margins = [np.where(one.verdict == 0, np.abs(one.distance), np.inf) for one in found]
    margin = np.min(margins, axis=0)[open_lines]
    felt, own = x.felt, x.own
    coherence = averages = None
    if felt.coherence is not None and (own is None or own.discs is None):
        coherence, averages = _of_coherence(felt, x, margin, open_lines)
    return Needed(int(open_lines.sum()), _shares(-margin, negated=True), coherence, averages)


def _of_coherence(felt: Measurement, x: Lines, margin: Reals, at: Any) -> tuple[Remedy, Remedy]:
    assert felt.averages is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = margin * np.abs(x.environment[at]) / np.abs(x.perceived[at])
    coherence = coherence_for(relative, felt.averages, felt.confidence)
    averages = averages_for(relative, felt.coherence[at], felt.confidence)
    return _shares(coherence, most=MOST_COHERENCE), _shares(averages, most=MOST_AVERAGES)


def _shares(values: Reals, *, most: float = np.inf, negated: bool = False) -> Remedy:
    """The value that is enough for at least half of the lines, and for all; None for one above
    ``most``."""
    row, middle = np.nan_to_num(values, nan=np.inf), (len(values) - 1) // 2
    found = (
        float(np.partition(row, middle)[middle]),
        float(row.max()),
    )  # as sorting all would give, in a fourth of the time
    half, every = (
        None if value > most or not np.isfinite(value) else -value if negated else value
        for value in found
    )
    return Remedy(half, every)


class LineResult(NamedTuple):
    """What is said of one line. ``radius`` : of the disc around the change, relative to
    ``|H_env|``; None where none is known."""

    omega: float
    ratio_real: float
    ratio_imag: float
    radius: float | None
    real: PartVerdict
    imag: PartVerdict
    joint: PartVerdict | None = None


class MeasuredPercept(NamedTuple):
    """What is felt of a part at one line, as far as the discs decide it.

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
        told = [
            f"{int((self.verdict[part] == code).sum())} {x.value}"
            for part in Part
            for code, x in CODES.items()
        ]
        lines = counted(len(self), "line")
        return (
            f"{titled(self.scene.title)}: {lines}, real {', '.join(told[:3])}, imaginary "
            f"{', '.join(told[3:])}"
        )

    def __len__(self) -> int:
        return len(self.lines.omega)

    @cached_property
    def between(self) -> Between | None:
        """What is told between the lines; None without a bound on the slope."""
        return between(self.scene, self.lines)

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
        """Whether the response is nearer to -H_env than to H_env at every line: the reaction to the
        force may be measured."""
        felt, wanted = self.lines.perceived, self.lines.environment
        return len(self) > 1 and bool((np.abs(felt + wanted) < np.abs(felt - wanted)).all())

    @cached_property
    def rows(self) -> tuple[LineResult, ...]:
        """Every line that is judged."""
        return tuple(self._rows())

    def _rows(self) -> Iterator[LineResult]:
        x = self.lines
        radius = [None] * len(self) if x.radius is None else x.radius.tolist()
        ratios = np.abs(x.change.real).tolist(), np.abs(x.change.imag).tolist()
        codes = [self.verdict[part] for part in Part] + ([self.joint.verdict] if self.joint else [])
        told = ((CODES[code] for code in row.tolist()) for row in codes)
        yield from map(LineResult, x.omega.tolist(), *ratios, radius, *told)

    def noticed(self, part: Part | None) -> Any:
        """Where step 2 asks how a part is felt, or None for both together, which neither is by
        itself."""
        if self.joint is None:
            return self.verdict[part] == 1 if part else np.zeros(len(self), dtype=bool)
        alone = [self.verdict[x] for x in Part]
        own = self.verdict[part] == 1 if part else (alone[0] == -1) & (alone[1] == -1)
        return (self.joint.verdict == 1) & own

    def named(self, part: Part | None) -> Any:
        """Where a property is named: the part is noticed, and its disc tells what it is felt as."""
        asked = Part if part is None else (part,)
        known = np.all([self.signs[x].known for x in asked], axis=0)
        found = self.noticed(part) & known
        if part is Part.REAL:
            return found
        return found & ~(
            self.signs[Part.IMAG].perceived < 0
        )  # what is active has no name in the model

    @cached_property
    def percepts(self) -> tuple[MeasuredPercept, ...]:
        """What is felt, at each line where the discs decide it."""
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
        """At which lines the real part's change is a larger share of its own limit than the
        imaginary part's."""
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
        """What was understood of each file."""
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
        """As text, one line for each measured line."""

        def told(key: str, value: Any) -> str:
            if key in ("rows", "percepts") and value:
                return "[\n    " + ",\n    ".join(map(json.dumps, value)) + "\n  ]"
            return json.dumps(value, indent=2, ensure_ascii=False).replace("\n", "\n  ")

        parts = (f"{json.dumps(key)}: {told(key, value)}" for key, value in self.to_dict().items())
        return "{\n  " + ",\n  ".join(parts) + "\n}"

    def kinds(self, part: Part | None) -> Any:
        """A number for each line: the same where a part, or None for both together, is felt
        alike."""
        found = np.zeros(len(self), dtype=int)
        for x in Part if part is None else (part,):
            own = self.signs[x]
            found = 1000 * found + 27 + 9 * own.environment + 3 * own.perceived + own.compared
        return found if part else 2 * found + self.real_nearer


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
    distance, found = (
        {part: getattr(one, key) for part, one in alone.items()} for key in ("distance", "verdict")
    )
    told = {part: signs(x, part) for part in Part}
    return MeasuredEvaluation(
        scene,
        x,
        distance,
        found,
        joint,
        told,
        needed(x, [joint] if joint else list(alone.values())),
    )
