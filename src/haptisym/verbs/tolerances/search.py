"""Branch and bound over band and box, on the excess of thresholds and regions in Taylor models.

The excess r^2 - c^2 over cells of band and box, in Taylor models: proven bounds on it and on its slopes.

Branch and bound over band and box: where r may equal its threshold, and which way such crossings move.

Cells in which the excess keeps its sign are left out, proven. What stays are leaves: crossings lie in them and nowhere else.
Leaves that touch form a ``Cluster``. Where the slope by omega keeps its sign on all of a cluster away from the ends of the
band, every crossing in it goes on through the whole box: the implicit function theorem continues it to all values, and it
cannot leave the cluster, whose surroundings hold none.

The largest of the smallest of functions over cells, as far as its sign and its zeros go, in one Taylor model.

The excess of a JND region, or of a limit that depends on the frequency, over cells of band and box, in Taylor models.

A region is the largest of the smallest of smooth functions (``joined``). Of an ellipse it is one, of a diamond two; a polygon has
one for each edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from sympy import Expr, Integer, S

from haptisym.judge.crossings import Criterion
from haptisym.judge.regions import Diamond, Ellipse, Polygon, Sided
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import LimitError, SceneError
from haptisym.kernel.rings import c, omega
from haptisym.model.jnd import Part
from haptisym.programs.program import Program
from haptisym.programs.taylormodels import Array, Model, Modelled, floated, halves, valued, variable
from haptisym.verbs.tolerances.box import Box

_BENT = 7  # sides: with more of them the curvature of all slopes costs more than the cells that it spares


class Excess:
    """r^2 - c^2 of a criterion of one part, for every frequency of the band and every set of values of the box.

    ``model`` takes cells, an array (cells, sides, 2): for omega, then for each side of the box, from which share of its way to
    which, 0 the low end and 1 the high end.
    """

    def __init__(self, box: Box, criterion: Criterion) -> None:
        part = criterion.part
        if part is None:
            raise SceneError(f"{criterion.words}: tolerances are told of criteria of one part alone")
        self._over(box)
        chain, exchanged = box.scene.chain.at(self._fixed).without_axis_zeros()
        seen = part if not exchanged else Part.IMAG if part is Part.REAL else Part.REAL
        self._name = f"squared_{seen.value}"
        self._program = chain.program([self._name])
        self._inputs = self._places(self._program)
        c = box.part_name(part)
        self._limit = 1 + self._names.index(c) if c in self._names else None
        self._c = floated(criterion.threshold)

    def _over(self, box: Box) -> None:
        """What varies, and within which ends."""
        self._names = [side.name for side in box.sides]
        self._fixed = {p.symbol: p.value for p in box.scene.parameters if p.symbol.name not in self._names}
        ends = [box.scene.band, *((side.low, side.high) for side in box.sides)]
        self._intervals = [(floated(low), floated(high - low)) for low, high in ends]
        self.sides = len(ends)
        self.order = 2 if self.sides <= _BENT else 1

    def _places(self, program: Program) -> list[int]:
        """Of each input of a program the number of its side, omega being that of 0."""
        return [0, *(1 + self._names.index(x.name) for x in program.inputs[1:])]

    @cached_property
    def is_zero(self) -> bool:
        """Whether r is 0 everywhere."""
        return bool(self._program.operations[self._program.results[self._name]].value == 0)

    def model(self, cells: Array, *, slopes: int | None = None) -> Model:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole may lie in the cell.

        ``slopes`` : of which order; none if 0, and whatever suits so many sides if not said.
        """
        slopes = self.order if slopes is None else slopes
        with np.errstate(all="ignore"):  # what is not finite is unknown, which every caller asks about
            inputs = [self._variable(i, cells, slopes=slopes) for i in self._inputs]
            square = self._square(inputs)
            c = inputs[0].number(self._c) if self._limit is None else self._variable(self._limit, cells, slopes=slopes)
            minus = -(c * c)
            return minus + square if isinstance(square, Model) else minus.plus(square)

    def _square(self, inputs: Sequence[Model]) -> Model | float:
        return Modelled(self._program).run(inputs)[self._name]

    @cached_property
    def matters(self) -> Array:
        """For omega and each side, whether the excess depends on it."""
        limit = np.array([i == self._limit for i in range(self.sides)])
        return limit | self._used(self._program)

    def _used(self, program: Program) -> Array:
        """For omega and each side, whether the results of a program depend on it; of omega it is said anyway."""
        steps = [program.operations[i] for i in program.needed(program.results.values())]
        used = {step.arguments[0] for step in steps if step.name == "input"}
        inputs = self._places(program)
        places = {0, *(inputs[i] for i in used)}
        return np.array([i in places for i in range(self.sides)])

    def _variable(self, i: int, cells: Array, *, slopes: int) -> Model:
        (low, width), (start, end) = self._intervals[i], cells[:, i].T
        middle, radius = low + width * (start + end) / 2, width * (end - start) / 2
        size = abs(low) + width * np.maximum(np.abs(start), np.abs(end))
        return variable(middle, radius, size, i, self.sides, slopes=slopes)


class LargerExcess(Excess):
    """|G - 1|^2 - c^2 of a criterion of one part, for effects in series: r is never larger, whatever the environment."""

    def __init__(self, box: Box, criterion: Criterion) -> None:
        super().__init__(box, criterion)
        self._program = box.scene.chain.at(self._fixed).program(_RELATIVE)
        self._inputs = self._places(self._program)

    def _square(self, inputs: Sequence[Model]) -> Model:
        found = Modelled(self._program).run(inputs)
        x, y = (v if isinstance(v, Model) else inputs[0].number(v) for v in (found[name] for name in _RELATIVE))
        return x * x + y * y


_RELATIVE = ("relative_real", "relative_imag")


_BATCH = 256  # cells that are bounded together
_MOST_CELLS = 3000  # that are looked at for one part
_MOST_SPLITS = 6  # of a cell: then it is a leaf if crossings in it are regular, or move one way with each parameter
_MOST_BEYOND = 800  # cells that are looked at for one end
OVERLAP = 1e-8  # shares of the band: clusters nearer to each other are taken as one
_FIRST = 32  # pieces of the band to begin with


@dataclass(frozen=True)
class Cluster:
    """Leaves that hang together, (cells, sides, 2) in shares; ``signs``: of the slopes on all of them, 0 where not the same.

    ``regular``: the slope by omega keeps its sign. ``low``, ``high``: bounds on the crossings in it, shares of the band.
    """

    cells: Array
    signs: tuple[int, ...]
    low: float
    high: float

    @property
    def regular(self) -> bool:
        """Whether the slope by omega keeps its sign in it."""
        return self.signs[0] != 0

    @property
    def inside(self) -> bool:
        """Whether its crossings keep clear of both ends of the band."""
        return self.clear_of(highest=False) and self.clear_of(highest=True)

    def clear_of(self, *, highest: bool) -> bool:
        """Whether its crossings keep clear of the high, or the low, end of the band."""
        return self.high < 1 if highest else self.low > 0


@dataclass(frozen=True)
class _Bounded:
    """Cells with the signs of value and slopes (0: not known), where their crossings lie, and the side to split."""

    cells: Array
    signs: Array
    omega: Array
    split: Array


def clusters(excess: Excess, within: tuple[float, float] = (0, 1)) -> tuple[Cluster, ...]:
    """All clusters of one part, in ascending order of frequency: outside them no r equals its threshold, proven.

    ``within`` : between which shares of the band is looked.
    """
    if excess.is_zero:
        return ()
    leaves = _leaves(excess, within)
    if not len(leaves.cells):
        return ()
    label = together(leaves.cells)
    found = (_cluster(leaves, label == n) for n in np.unique(label))
    return tuple(_apart(sorted(found, key=lambda x: x.low)))


def _apart(found: list[Cluster]) -> Iterator[Cluster]:
    """Clusters whose frequencies overlap as one, so that a frequency tells to which a crossing belongs."""
    waiting = found[0]
    for x in found[1:]:
        if x.low > waiting.high + OVERLAP:
            yield waiting
            waiting = x
            continue
        signs = tuple(a if a == b else 0 for a, b in zip(waiting.signs, x.signs, strict=True))
        waiting = Cluster(np.concatenate([waiting.cells, x.cells]), signs, waiting.low, max(waiting.high, x.high))
    yield waiting


def _leaves(excess: Excess, within: tuple[float, float]) -> _Bounded:
    waiting = [_start(excess.sides, *within)]
    depth = [np.zeros(_FIRST, int)]
    kept: list[_Bounded] = []
    looked = 0
    while waiting:
        cells, depths = np.concatenate(waiting), np.concatenate(depth)
        cells, later, depths, deeper = cells[:_BATCH], cells[_BATCH:], depths[:_BATCH], depths[_BATCH:]
        waiting, depth = ([later], [deeper]) if len(later) else ([], [])
        looked += len(cells)
        try:
            tick(min(looked, _MOST_CELLS), _MOST_CELLS, "cells of band and ranges")
            found = bounded(excess, cells)
            unclear = _unclear(excess, found)
        except LimitError:  # of what waits nothing is known: crossings may be anywhere in it
            kept.append(_unbounded(np.concatenate([cells, *waiting])))
            break
        steady = (found.signs[:, 2:] != 0)[:, excess.matters[1:]].all(-1)
        regular, tired = found.signs[:, 1] != 0, depths >= _MOST_SPLITS
        clear_of_ends = (found.omega[:, 0] > 0) & (found.omega[:, 1] < 1)
        leaf = unclear & ((steady & regular & clear_of_ends) | ((steady | regular) & tired) | (looked > _MOST_CELLS))
        kept.append(_chosen(found, leaf))
        rest = unclear & ~leaf
        if rest.any():
            waiting.append(halves(found.cells[rest], found.split[rest]))
            depth.append(np.tile(depths[rest] + 1, 2))
    return _Bounded(
        *(np.concatenate([getattr(x, name) for x in kept]) for name in ("cells", "signs", "omega", "split"))
    )


def _unbounded(cells: Array) -> _Bounded:
    """Cells of which nothing is known."""
    count, sides = cells.shape[:2]
    return _Bounded(cells, np.zeros((count, 1 + sides), int), cells[:, 0].copy(), np.zeros(count, int))


def _unclear(excess: Excess, found: _Bounded) -> Array:
    """Where the excess may vanish: not where it is > 0 at the corner where it is least, or < 0 where it is greatest."""
    unclear = found.signs[:, 0] == 0
    which = np.flatnonzero(unclear)
    if len(which):
        corners = [_corner(found.cells[which], found.signs[which, 2:], to) for to in (-1, 1)]
        low, high = (x[:, 0] for x in excess.model(np.concatenate(corners), slopes=0).bounds())
        unclear[which] = ~((low[: len(which)] > 0) | (high[len(which) :] < 0))
    return unclear


def _corner(cells: Array, signs: Array, to: int) -> Array:
    """Each cell with the parameters along which the excess is monotonic at the end where it is greatest (1) or least (-1)."""
    moved = cells.copy()
    at = np.where(signs * to > 0, cells[:, 1:, 1], cells[:, 1:, 0])
    moved[:, 1:] = np.where(signs[..., None] != 0, at[..., None], cells[:, 1:])
    return moved


def _start(sides: int, low: float, high: float) -> Array:
    cells = np.zeros((_FIRST, sides, 2))
    cells[:, :, 1] = 1
    cells[:, 0, 0], cells[:, 0, 1] = sliding_window_view(np.linspace(low, high, _FIRST + 1), 2).T
    return cells


def _chosen(x: _Bounded, which: Array) -> _Bounded:
    return _Bounded(x.cells[which], x.signs[which], x.omega[which], x.split[which])


def bounded(excess: Excess, cells: Array) -> _Bounded:
    """What is known about the excess over cells."""
    model = excess.model(cells)
    low, high = model.bounds()
    signs = np.where(low > 0, 1, np.where(high < 0, -1, 0))
    with np.errstate(all="ignore"):
        omega = _contracted(cells, model.c0[:, 0], model.c1[:, 0], model.c2[:, 0], model.r[:, 0], low[:, 1], high[:, 1])
        weight = np.where((signs == 0) & np.isfinite(high), 1 / (high - low), 0.0)
        changes = np.abs(model.c1)
        changes[:, : model.c2.shape[1]] += np.abs(model.c2).sum(-1)
        score = np.where(
            weight[:, :1] > 0, (weight[:, :, None] * changes).sum(1), changes[:, 0]
        )  # near a pole the value's alone
    width = cells[:, :, 1] - cells[:, :, 0]
    score = np.where(np.isfinite(score).all(-1, keepdims=True) & (score > 0).any(-1, keepdims=True), score, width)
    return _Bounded(cells, signs, omega, np.argmax(np.where(width > 0, score + 1e-300, -1), -1))


def _contracted(cells: Array, c0: Array, c1: Array, c2: Array, r: Array, least: Array, most: Array) -> Array:
    """Where in each cell the excess may vanish, in shares of the band: F = F(t_0 = 0) + dF/dt_0 t_0 for one slope of the cell."""
    rest = np.abs(c1[:, 1:]).sum(-1) + np.abs(c2[:, 1:, 1:]).sum((-1, -2)) + r
    ends = np.stack([-(c0 + a * rest * (1 + 1e-13)) / g for a in (-1, 1) for g in (least, most)])
    steady = (least * most > 0) & np.isfinite(ends).all(0)
    low = np.where(steady, np.clip(ends.min(0) - 1e-13, -1, 1), -1)
    high = np.where(steady, np.clip(ends.max(0) + 1e-13, -1, 1), 1)
    middle, radius = cells[:, 0].mean(-1), (cells[:, 0, 1] - cells[:, 0, 0]) / 2
    return np.stack([middle + radius * low, middle + radius * high], -1) + np.array([-1e-15, 1e-15])


def together(cells: Array) -> Array:
    """A label for each cell, the same for cells that touch, directly or through others."""
    label = np.full(len(cells), -1)
    low, high = np.ascontiguousarray(cells.T)
    alone = np.arange(len(cells))
    while len(alone):
        first, waiting = alone[0], [alone[0]]
        label[first] = first
        while waiting:
            own = waiting.pop()
            near = (low[:, alone] <= high[:, own, None]).all(0) & (low[:, own, None] <= high[:, alone]).all(0)
            label[alone[near]] = first
            waiting += alone[near].tolist()
            alone = alone[~near]
    return label


def _cluster(leaves: _Bounded, own: Array) -> Cluster:
    signs = leaves.signs[own, 1:]
    same = np.where((signs == signs[0]).all(0), signs[0], 0)
    omega = leaves.omega[own]
    return Cluster(leaves.cells[own], tuple(int(x) for x in same), float(omega[:, 0].min()), float(omega[:, 1].max()))


def beyond(excess: Excess, cells: Array, reached: float, *, highest: bool) -> float:
    """A bound on how low (high) crossings in cells go, shares of the band: ``reached`` itself where none goes beyond."""
    out, looked = 1 if highest else -1, 0
    near, far = (0, 1) if highest else (1, 0)
    waiting = [cells]
    end = reached
    while waiting:
        own = np.concatenate(waiting)
        own = own[out * (own[:, 0, far] - reached) > 0].copy()
        own[:, 0, near] = out * np.maximum(out * own[:, 0, near], out * reached)
        if looked > _MOST_BEYOND or not len(own):
            return float(out * np.max(out * own[:, 0, far])) if len(own) else end
        order = np.argsort(-out * own[:, 0, far])
        own, later = own[order[:_BATCH]], own[order[_BATCH:]]
        looked += len(own)
        try:
            found = bounded(excess, own)
            found = _chosen(found, _unclear(excess, found))
        except LimitError:
            return float(out * np.max(out * np.concatenate([own, later])[:, 0, far]))
        own = found.cells.copy()
        own[:, 0, 0], own[:, 0, 1] = (
            np.maximum(own[:, 0, 0], found.omega[:, 0]),
            np.minimum(own[:, 0, 1], found.omega[:, 1]),
        )
        whole = own[:, 0, 0] <= own[:, 0, 1]
        waiting = [later, halves(own[whole], found.split[whole])]
    return end


def joined(terms: Sequence[Sequence[Model]]) -> Model:
    """A model with the sign and the zeros of max over ``terms`` of the min over each.

    In a cell only those functions count whose sign is not known there while it decides that of the whole. The model encloses
    each of them, value and slopes: a slope that keeps its sign is that of all of them, and so of what they make. Where none
    counts it is a number of the known sign.
    """
    signs = [[_sign(f) for f in term] for term in terms]
    alive = [np.logical_and.reduce([sign >= 0 for sign in term]) for term in signs]
    positive = np.logical_or.reduce([np.logical_and.reduce([sign > 0 for sign in term]) for term in signs])
    first = terms[0][0]
    found, known = first.number(1.0).where(positive, first.number(-1.0)), np.zeros(len(positive), dtype=bool)
    for own, term, of_term in zip(alive, terms, signs, strict=True):
        for f, sign in zip(term, of_term, strict=True):
            counts = own & (sign == 0) & ~positive
            found = f.where(counts & ~known, enclosing(found, f).where(counts & known, found))
            known |= counts
    return found


def _sign(f: Model) -> Array:
    """Of the value: 0 where it is not known."""
    low, high = (x[:, 0] for x in f.bounds())
    return np.where(low > 0, 1, np.where(high < 0, -1, 0))


def enclosing(f: Model, g: Model) -> Model:
    """A model within which both lie, with their slopes."""
    middle = [(a + b) / 2 for a, b in zip(f.arrays[:3], g.arrays[:3], strict=True)]
    c0, c1, c2 = (np.abs(a - b) / 2 for a, b in zip(f.arrays[:3], g.arrays[:3], strict=True))
    r = (c0 + Model(c0, c1, c2, np.maximum(f.r, g.r)).deviation) * (1 + 1e-14)
    return Model(middle[0], middle[1], middle[2], r + 1e-14 * (np.abs(middle[0]) + np.abs(f.c0)))


Terms: TypeAlias = list[list[Model]]
_FIELDS = ("real", "imag", "environment_real", "environment_imag")
_SQUARED = ("squared_real", "squared_imag")


def excess_of(box: Box, criterion: Criterion) -> Excess:
    """What must not be positive of a criterion, over cells."""
    is_plain = criterion.region is None and not criterion.threshold.has(omega)
    return Excess(box, criterion) if is_plain else RegionalExcess(box, criterion)


class RegionalExcess(Excess):
    """Of a criterion with a region, or with a formula in omega as its limit; has the sign and the zeros of what it judges."""

    def __init__(self, box: Box, criterion: Criterion) -> None:
        self._over(box)
        self._criterion, self._limit = criterion, None
        threshold = box.scene.threshold
        if criterion.region and threshold.interval(Part.REAL):  # one for both half widths
            self._criterion = replace(criterion, region=criterion.region.opened(dict.fromkeys(Part, c)))
            self._limit = 1 + self._names.index(box.part_name(Part.REAL))
        chain = box.scene.chain.at(self._fixed)
        relative, _ = chain.without_axis_zeros()
        environments = (chain.ring.convert(x.environment) for x in (chain, relative))
        powers = [int(n) for n, *_ in (next(environments) / next(environments)).reduced().numerator.monoms()]
        if len(powers) > 1 and isinstance(criterion.region, Polygon):  # changes its side where H_env changes its sign
            relative, powers = chain, [0]
        self._turns, self._from_rest = max(powers) % 4, len(powers) == 1
        self._relative, self._plain = relative.program([*_SQUARED, *_FIELDS]), chain.program(_FIELDS)

    @cached_property
    def is_zero(self) -> bool:
        """Whether nothing of what is judged changes anywhere."""
        parts = [self._criterion.part] if self._criterion.part else list(Part)
        steps, results = self._relative.operations, self._relative.results
        return all(steps[results[f"squared_{seen_as(part, self._turns).value}"]].value == 0 for part in parts)

    @cached_property
    def matters(self) -> Array:
        """For omega and each side, whether the excess may depend on it."""
        limit = np.array([i == self._limit for i in range(self.sides)])
        return limit | self._used(self._relative) | self._used(self._plain)

    def model(self, cells: Array, *, slopes: int | None = None) -> Model:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole may lie in the cell."""
        slopes = self.order if slopes is None else slopes
        with np.errstate(all="ignore"):  # what is not finite is unknown, which every caller asks about
            at = self._variable(0, cells, slopes=slopes)
            relative, plain = (self._run(x, cells, at, slopes=slopes) for x in (self._relative, self._plain))
            known: dict[Expr, Model] = {omega: at}
            if self._limit is not None:
                known[c] = self._variable(self._limit, cells, slopes=slopes)
            return joined(Changes(relative, plain, known, self._turns, self._from_rest).terms(self._criterion))

    def _run(self, program: Program, cells: Array, at: Model, *, slopes: int) -> dict[str, Model]:
        found = Modelled(program).run([self._variable(i, cells, slopes=slopes) for i in self._places(program)])
        return {name: x if isinstance(x, Model) else at.number(x) for name, x in found.items()}


def seen_as(part: Part, turns: int) -> Part:
    """Which part shows a part of what was turned by a number of quarters."""
    return part if turns % 2 == 0 else Part.IMAG if part is Part.REAL else Part.REAL


@dataclass(frozen=True)
class Changes:
    """x = Re dH/|H_env| and y = Im dH/|H_env| over cells, and what a criterion makes of them.

    ``relative`` : fields of a chain with the same ratios, in which all is ``turns`` quarters behind; ``plain``: of the chain.
    ``known`` : what omega, and the half width c where it varies, are over the cells. ``from_rest`` : whether these chains differ
    by a power of s alone.
    """

    relative: Mapping[str, Model]
    plain: Mapping[str, Model]
    known: Mapping[Expr, Model]
    turns: int
    from_rest: bool = False

    def terms(self, criterion: Criterion) -> Terms:
        """The functions of which the largest of the smallest is positive where a change is noticed."""
        region = criterion.region
        if isinstance(region, Ellipse):
            return [[self._ellipse(region)]]
        if isinstance(region, Diamond):
            return [[self._quadric(region.real, region.imag, Integer(sign))] for sign in (1, -1)]
        if isinstance(region, Polygon):
            x, y = self._xy
            return [[(self._times(p, x) + self._times(q, y)).plus(-1.0)] for p, q in region.edges]
        if isinstance(region, Sided):
            return self._sided(region)
        assert criterion.part
        return [[self._beyond(criterion.part, criterion.threshold)]]

    def _ellipse(self, region: Ellipse) -> Model:
        root = 1 - region.tilt**2
        return self._quadric(region.real, region.imag, -region.tilt, root)

    def _quadric(self, a: Expr, b: Expr, t: Expr, whole: Expr = S.One) -> Model:
        """a b times (x/a)^2 + 2 t (x/a)(y/b) + (y/b)^2 - whole."""
        squares = self._times(b / a, self._square(Part.REAL)) + self._times(a / b, self._square(Part.IMAG))
        found = squares - self._constant(a * b * whole)
        return found if t == 0 else found + self._times(2 * t, self._product)

    def _sided(self, region: Sided) -> Terms:
        own = self.plain[region.part.value]
        larger, smaller = (self._beyond(region.part, x) for x in (region.higher, region.lower))
        least = [] if region.floor is None else [own * own - self._constant(region.floor**2)]
        if not region.has_sides:
            return [[larger, *least]]
        growth = self._growth(region.part)
        return [[growth, larger, *least], [-growth, smaller, *least], [larger, smaller, *least]]

    def _growth(self, part: Part) -> Model:
        """|H_perc|^2 - |H_env|^2 of a part: of what H_env vanishes with at omega = 0 alone nothing is left in it."""
        fields, seen = (self.relative, seen_as(part, self.turns)) if self.from_rest else (self.plain, part)
        return fields[seen.value] * (fields[seen.value] + fields[f"environment_{seen.value}"].times(2.0))

    def _beyond(self, part: Part, limit: Expr) -> Model:
        return self._square(part) - self._constant(limit**2)

    def _square(self, part: Part) -> Model:
        return self.relative[f"squared_{seen_as(part, self.turns).value}"]

    @cached_property
    def _product(self) -> Model:
        """x y."""
        found = self.relative["real"] * self.relative["imag"] / self._modulus
        return -found if self.turns % 2 else found

    @cached_property
    def _modulus(self) -> Model:
        R, X = self.relative["environment_real"], self.relative["environment_imag"]
        return R * R + X * X

    @cached_property
    def _xy(self) -> tuple[Model, Model]:
        size = self._modulus.to_the(self._at.number(0.5))
        x, y = self.relative["real"] / size, self.relative["imag"] / size
        for _ in range(self.turns):
            x, y = -y, x
        return x, y

    def _times(self, factor: Expr, x: Model) -> Model:
        return x * self._constant(factor) if factor.free_symbols else x.times(floated(factor))

    def _constant(self, x: Expr) -> Model:
        return valued(x, self.known, self._at)

    @property
    def _at(self) -> Model:
        return self.known[omega]
