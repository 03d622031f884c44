"""How large, and how small, the bandwidth can be in a box of parameters: proven bounds, by the
branch and bound of ``kernel.where``.

Let first(q) be the lowest frequency at which some criterion's excess F_i(omega, q) is positive: the
bandwidth at the values q, but for the band's high end where nothing is noticed. first(q) <= W for
all q of a box if the box is covered by cells each of which has one criterion and one omega_0 <= W
with F_i(omega_0, q) > 0 for all q of the cell (``LargestBandwidth``). What must be kept is judged
at places below all of the band, so that first(q) is negative where it is broken: such values are no
better than any others. Only *broken* must be proven of a cell: what stays open keeps the bound
true.

first(q) >= w for all q of a box if every F_i is negative on [0, w) in each of its cells
(``smallest``).

Frequencies are shares of the band, values shares of their ranges. ``LargestBandwidth`` is where to
begin reading. Derivation: 20_best_damping.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from sympy import Expr, Integer

from haptisym.judge.crossings import PASSIVE, noticed
from haptisym.judge.excess import Box, Excess, Side, excess_of
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.where import (
    Array,
    Cells,
    Judge,
    LineBound,
    Search,
    joined,
    no_better,
    no_worse,
)
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.scene import clocks
from haptisym.programs.taylormodels import Modelled, TaylorModel, valued

_PIECES, _BATCH = 16, 128
"""Pieces of the band to begin with; cells in a round."""
_NARROW = 2.0**-44
"""Share of the box down to which cells are cut."""
# Nearer to 0 rad/s -Im H_perc, which vanishes there, has no sign that models could show; the sign
# of its lowest coefficient decides.
_LOW = -1 + 1e-3
# Points of a round that are offered; rounds without success after which offers become rarer; cuts
# of pieces before the box is cut.
_OFFERED, _PATIENCE, _CUT_FIRST = 32, 8, 5
_SEEN, _CUT_POINTS = 1e-6, 8
"""How closely first(q) is bounded at single points, a share of the band; how often pieces are cut
for it."""
_WITHOUT_END = 10**12  # pieces: the time is the limit
_MOST_WORST = 10_000
"""Pieces that are looked at for the worst of one parameter: a threshold that is touched is never
settled."""
_REACH = 20
"""How many times the band's high end passivity is examined up to: above, the sign of the highest
coefficient decides."""


@dataclass(frozen=True)
class DesignBox(Box):
    """A scene and its free parameters, each between two values."""

    free: tuple[Side, ...] = ()

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """The free parameters."""
        return self.free

    def times(self, factors: Sequence[Expr]) -> DesignBox:
        """The box of all values that are so many times those of this one; a share of it is so many
        times the value at that share of this one."""
        scaled = (
            replace(x, low=x.low * f, high=x.high * f)
            for x, f in zip(self.free, factors, strict=True)
        )
        return replace(self, free=tuple(scaled))

    def around(self, relative: Expr) -> DesignBox:
        """The box of all values within that relative distance of the middle of this one."""
        sides = []
        for x in self.free:
            middle, away = (x.low + x.high) / 2, abs(x.low + x.high) / 2 * relative
            sides.append(replace(x, low=middle - away, high=middle + away))
        return replace(self, free=tuple(sides))

    @cached_property
    def criteria(self) -> list[Judge]:
        """What must not be positive on the band."""
        return self.criteria_of(None)

    def criteria_of(self, part: Part | None) -> list[Judge]:
        """What must not be positive on the band, of one part alone if it is given."""
        found = (
            excess_of(self, x) for x in noticed(self.scene.threshold) if part in (None, x.part)
        )
        return [x.curve for x in found if not x.is_zero]

    @property
    def passive(self) -> list[tuple[Judge, int]]:
        """Functions that are positive where a display generates energy, at places from -1 to 0,
        each with the number of pieces to begin with; none of sampled loops."""
        if clocks(self.scene):
            return []
        # Passivity is asked of all frequencies, not of the band alone: from 0 to far above it by
        # models, nearer to 0 and above that by the lowest and the highest coefficient.
        high = _REACH * self.scene.band[1]
        wide = replace(self, scene=replace(self.scene, band=(Integer(0), high)))
        return [
            (_Activity(wide).below, _PIECES),
            *((_Coefficient(self, x).curve, 1) for x in _at_both_ends(self)),
        ]


Offer: TypeAlias = Callable[[Array], float | None]
"""Is given points, shares of the box, at which the bandwidth may be large, and returns the largest
that is attained so far; None where there are more criteria now, and a new search has to begin."""


class LargestBandwidth:
    """The search for an upper bound on the bandwidth in a box, in shares of the band, by targets
    that come closer and closer to what is attained.

    ``criteria`` : judges of the band; ``kept`` : of what must be kept, at places from -1 to 0, each
    with the number of pieces of these to begin with; ``outer`` : the cells that hold all values
    that are allowed, (cells, parameters, 2).
    """

    def __init__(
        self, criteria: Sequence[Judge], kept: Sequence[tuple[Judge, int]], outer: Array
    ) -> None:
        self._criteria = len(criteria)
        # Of the band nothing is examined yet, only what must be kept (``_reach``).
        nothing = [np.empty((0, 1, 2))] * len(criteria)
        first = Cells.of(outer, [*nothing, *(_pieces(_LOW, 0.0, n) for _, n in kept)])
        self._reached = 0.0
        self._offered: set[bytes] = set()
        self._settled: list[Cells] = [first[:0]]
        self._search = Search(
            [*criteria, *(x for x, _ in kept)],
            first,
            wide=_wide,
            settled=no_better(0.0),
            rank=_by_size,
            batch=_BATCH,
            most=_WITHOUT_END,
            what="cells of the parameters",
        )

    def prove(self, aim: Callable[[float], float], offer: Offer) -> float | None:
        """A target that no values of the box exceed; 1, the whole band, if that is attained.

        None where cells became too narrow, the time was over, or an offer asks for a new search.

        ``aim`` : the target for what is attained; it rises where an offer is better than all
        before.
        """
        attained = offer(np.empty((0, self._search.left.outer.shape[1]))) or 0.0
        target = aim(attained)
        self._put_back(target)
        self._reach(target)
        missed = 0
        for n, done in enumerate(self._search):
            self._settled.append(done)
            # exact evaluations are costly: where nothing better was found for long, less often
            points = self._promising() if n % (1 + missed // _PATIENCE) == 0 else ()
            missed += len(points) > 0
            now = offer(points) if len(points) else attained
            if now is None:
                return None
            if now > attained:
                if now >= 1:
                    return 1.0
                attained, target, missed = now, aim(now), 0
                self._reach(target)
        if len(self._search.left):
            return None
        # where nothing is attained the cells may show that there is nothing
        return target if attained > 0 else max(joined(self._settled).ceiling.max(initial=0.0), 0.0)

    def _put_back(self, target: float) -> None:
        """Search those cells again that were settled for a larger target, and are not for this
        one."""
        cells = joined(self._settled)
        again = cells.ceiling > target
        self._settled = [cells[~again]]
        self._search.waiting.add(cells[again])

    def _reach(self, target: float) -> None:
        """Examine the band up to a target: above it nothing need be known, as a cell is settled by
        one frequency below at which a criterion is positive for all of it."""
        self._search.settled = no_better(target)
        if target > self._reached:
            more = _pieces(
                self._reached, target, max(1, round(_PIECES * (1 - self._reached / target)))
            )
            none = np.empty((0, 1, 2))
            inner = [more if i < self._criteria else none for i in range(len(self._search.judges))]
            self._search.restart(self._search.left.extended(inner))
            self._reached = target

    def _promising(self) -> Array:
        """The middles of the undecided cells whose criteria are proven to be negative up to the
        highest frequencies, each once."""
        cells = self._search.left
        floor = np.full(len(cells), self._reached)
        for pieces in cells.pieces[: self._criteria]:
            np.minimum.at(floor, pieces.owner, pieces.inner[:, 0, 0])
        middles = cells.outer[np.argsort(-floor, kind="stable")[:_OFFERED]].mean(-1)
        # by their bytes: the middles of cells are the same floats when cells come back
        new = [x for x in middles if x.tobytes() not in self._offered]
        self._offered |= {x.tobytes() for x in new}
        return np.array(new).reshape(len(new), middles.shape[1])

    def better_than(self, attained: float) -> Array:
        """The cells, (cells, parameters, 2), outside of which no values are better than what is
        attained."""
        cells = joined([*self._settled, self._search.left])
        return cells.outer[cells.ceiling > attained]


def _wide(outer: Array) -> Array:
    """Which sides of cells may be cut."""
    return outer[..., 1] - outer[..., 0] > _NARROW


def _uncut(outer: Array) -> Array:
    """No side may be cut: only pieces of the band are."""
    return np.zeros(outer.shape[:2], bool)


def _by_size(cells: Cells) -> Array:
    """The rank of cells by which the largest come first."""
    return -np.prod(cells.outer[..., 1] - cells.outer[..., 0], -1)


def _pieces(low: float, high: float, count: int) -> Array:
    ends = np.linspace(low, high, count + 1)
    return np.stack([ends[:-1], ends[1:]], -1)[:, None]


def _whole_box(criteria: Sequence[Judge], sides: int, end: float = 1.0) -> Cells:
    return Cells.of(
        np.tile([0.0, 1.0], (1, sides, 1)), [_pieces(0.0, end, _PIECES)] * len(criteria)
    )


def at_points(criteria: Sequence[Judge], points: Array) -> tuple[Array, Array]:
    """Lower and upper bounds on first(q) at points of a box, (points, parameters), in shares of the
    band.

    Both are 1 where nothing is positive. They stay apart where a criterion comes close to its
    threshold, or touches it.
    """
    first = Cells.of(
        np.repeat(points[:, :, None], 2, -1), [_pieces(0.0, 1.0, _PIECES)] * len(criteria)
    )
    search = Search(
        criteria,
        first,
        wide=_uncut,
        last=_CUT_POINTS,
        settled=lambda low, high: np.minimum(high, 1) - np.minimum(low, 1) <= _SEEN,
    )
    cells = joined([*search, search.left])
    # Cells come back in the order in which they were settled: both sides are sorted by their values
    # and put in pairs.
    order_of_points, order_of_cells = np.lexsort(points.T), np.lexsort(cells.outer[..., 0].T)
    bounds = np.empty((2, len(points)))
    shares = np.clip(np.stack([cells.floor, cells.ceiling]), 0.0, 1.0)
    bounds[:, order_of_points] = shares[:, order_of_cells]
    return bounds[0], bounds[1]


def smallest(
    criteria: Sequence[Judge], sides: int, relative: float, seen: float = 1.0
) -> Iterator[tuple[float, float, Array | None]]:
    """Bounds on the smallest first(q) in a box, in shares of the band, that come closer until they
    are within ``relative`` of each other.

    ``seen`` : what some values of the box are known to have, so that only the band below it is
    examined. With the bounds come values that have no more than the upper one, as shares of the
    box; None as long as that is ``seen``.
    """
    if not criteria or seen <= 0:
        yield seen, seen, None
        return
    end, where = seen if seen >= 1 else seen * (1 - relative), None
    first = Search(
        criteria,
        _whole_box(criteria, sides, end),
        wide=_uncut,
        settled=no_worse(np.inf),
        last=_CUT_FIRST,
    )
    # most pieces of the band need no cut of the box
    cells = joined([*first, first.left])
    search = Search(
        criteria,
        cells,
        wide=_wide,
        settled=no_worse(end),
        rank=lambda x: x.floor,
        batch=_BATCH,
        # each further parameter is allowed three times as many pieces
        most=_MOST_WORST * 3 ** (sides - 1),
    )
    for done in search:
        known = joined([done, search.left])
        least = int(np.argmin(known.ceiling))
        if known.ceiling[least] < seen:
            # All of this cell has no more than its ceiling, its middle too. What remains to be
            # shown is that nothing is noticed below that, but for the gap.
            seen, where = float(known.ceiling[least]), known.outer[least].mean(-1)
            end = seen * (1 - relative)
            search.settled = no_worse(end)
            search.restart(_below(search.left, end))
        yield min([end, *search.left.floor.tolist()]), seen, where


def _below(cells: Cells, end: float) -> Cells:
    """The cells without pieces above a place: what is there does not matter any more, and cells
    would be cut for it."""
    return replace(cells, pieces=tuple(x[x.inner[:, 0, 0] < end] for x in cells.pieces))


def profile(criteria: Sequence[Judge], sides: int, within: float, most: int) -> tuple[Array, Array]:
    """Cells that fill a box, (cells, parameters, 2), and bounds on first(q) in each, (cells, 2), in
    shares of the band.

    ``within`` : how far apart bounds are to be; ``most`` : pieces that are examined, after which
    some stay further apart.
    """
    search = Search(
        criteria,
        _whole_box(criteria, sides),
        wide=_wide,
        rank=_by_size,
        batch=_BATCH,
        most=most,
        settled=lambda low, high: np.minimum(high, 1) - np.minimum(low, 1) <= within,
    )
    cells = joined([*search, search.left])
    return cells.outer, np.clip(np.stack([cells.floor, cells.ceiling], -1), 0.0, 1.0)


def broken(judges: Sequence[tuple[Judge, int]], sides: int, finest: float, most: int) -> Array:
    """Cells, (cells, parameters, 2), for all values of which something that must be kept is proven
    to be broken.

    ``judges`` : as of ``LargestBandwidth``; ``finest`` : the share of a range down to which cells
    are cut.
    """
    first = Cells.of(np.tile([0.0, 1.0], (1, sides, 1)), [_pieces(_LOW, 0.0, n) for _, n in judges])
    search = Search(
        [x for x, _ in judges],
        first,
        wide=lambda x: x[..., 1] - x[..., 0] > finest,
        rank=_by_size,
        most=most,
    )
    cells = joined([first[:0], *search])
    return cells.outer[cells.ceiling < np.inf]


_FIELDS = ("imag", "environment_imag")


class _Activity(Excess):
    """-Im H_perc, positive where the display generates energy, on its box's band."""

    def __init__(self, box: Box) -> None:
        self._over(box)
        self._program = box.scene.chain.at(self._fixed).program(_FIELDS)
        self._inputs = self._places(self._program)

    def model(self, cells: Array, *, slopes: int | None = None) -> TaylorModel:
        """-Im H_perc over each cell."""
        with np.errstate(all="ignore"):
            inputs = [self._variable(i, cells, slopes=slopes or 0) for i in self._inputs]
            found = Modelled(self._program).run(inputs)
            x, y = (
                v if isinstance(v, TaylorModel) else inputs[0].number(v)
                for v in (found[name] for name in _FIELDS)
            )
            return -(x + y)

    def below(self, cells: Array) -> LineBound:
        """-Im H_perc at places from -1, for 0 rad/s, to 0, for the high end of its band: below all
        places of the bandwidth, so that a cell that is broken here has a negative first(q)."""
        cells = cells.copy()
        cells[:, 0] += 1.0
        return self.curve(cells)


class _Coefficient(Excess):
    """A formula of the parameters alone, the same at all frequencies; positive where the display is
    not passive."""

    def __init__(self, box: Box, formula: Expr) -> None:
        self._over(box)
        self._formula = formula

    def model(self, cells: Array, *, slopes: int | None = None) -> TaylorModel:
        """The formula over each cell."""
        with np.errstate(all="ignore"):
            sides = {
                name: self._variable(1 + i, cells, slopes=0) for i, name in enumerate(self._names)
            }
            known = {x: sides[x.name] for x in self._formula.free_symbols}
            return valued(self._formula, known, self._variable(0, cells, slopes=0))


def _at_both_ends(box: DesignBox) -> list[Expr]:
    """Formulas with the sign of -Im H_perc near 0 rad/s, and at high frequency; none where it is no
    rational function."""
    scene, names = box.scene, [x.name for x in box.free]
    chain = scene.chain.at(
        {p.symbol: p.value for p in scene.parameters if p.symbol.name not in names}
    )
    activity = PASSIVE.function(Distortion.of(chain))
    if (
        not isinstance(activity, RealFunction)
        or activity.axis.functions
        or activity.axis.orders
        or activity.function.is_zero
    ):
        return []
    rows = []
    for polynomial in (activity.function.numerator, activity.function.denominator):
        row = activity.axis.coefficients(polynomial)
        rows.append([x for x in row if not x.is_zero])
    above, below = rows
    # near 0 the lowest powers of omega decide the sign of a quotient, at high frequency the highest
    return [above[0] * below[0], above[-1] * below[-1]]
