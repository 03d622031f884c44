"""Branch and bound in floating point: where, in a box of omega and up to three parameters, is each
of some functions positive, negative or of unknown sign?

The sides of the box are of two kinds. *Outer* sides are values of parameters q, which are settled
cell by cell; *inner* sides are those over which a cell must be settled: omega first, then any other
number for all of whose values the verdict must hold. For each function F_i an outer cell holds
*pieces*, the boxes of inner sides on which the sign of F_i is still open.

**Guaranteed** of every outer cell, at any time, with first(q) the lowest omega from which on some
F_i > 0 (infinite if there is none)::

    floor <= first(q) <= ceiling  for all q of the cell;
    F_i(omega, q) < 0  for all q of the cell, all omega below the ceiling, and all other inner
                       sides, outside of the pieces of F_i.

A cell is *kept* where its floor is infinite (no piece is left, and nothing is positive), *broken*
where its ceiling is not: F_i, i = ``by``, is positive at that omega for all q of the cell. What is
not settled is returned, always: cells that are too small to be cut, and those that waited when the
budget, or the time, was over. Nothing is claimed about F_i itself: what a judge says of it must be
proven. Cells are closed, and ends that are rounded are within what the judge must allow for (an ulp
of the box).

**A judge** bounds F_i, over many cells at once, by a line along omega and the distance that F_i may
have from it::

    |F_i(omega, q) - (middle + slope t)| <= rest,  omega = m + h t,  t in [-1, 1],

and how much it changes along each side; where that is not finite nothing is known (a pole may lie
there). From the line a piece is *contracted* from both sides, as by Newton's method for intervals
but without a second derivative: the part on which middle + slope t + rest < 0 goes, which raises
floors, and from where on middle + slope t - rest > 0 the ceiling lies. A judge need not be smooth:
one that cannot be positive (``D(j omega) is on one side of a line through 0``) settles by pieces
alone.

**How cells are cut.** The remainder of a Taylor model is of third order, so the share of each side
in it is that of the cube of F's change along it (``LineBound.of``): all of it to omega, and pieces
without end are cut that only the parameters could settle; to each alike, and the parameters are. A
piece along whose inner sides F changes more than half as much as along the outer ones is cut there,
every other open piece wants its cell cut: along the side with the largest share of the change in
any piece. A remainder many times larger than all of F's change is one of numbers that cancel in F,
and says nothing of the side that it is due to: what is cut then is relatively widest. Of pieces
about which nothing is known 32 of a cell may be cut; then it is the cell that is too large.

**What is asked** is a reading: ``told`` settles a cell that is kept or broken (requirements, maps,
planes of hands), and a question about the best or the worst value settles what cannot be better
than a bound (``no_better``,
``no_worse``). The order is a rank: all at once if there is none, else the best ones first
(``Search``). The queue, ``Batches``, serves searches that have no outer cells too. Begin reading at
``search``, ``Search`` and ``LineBound``.

>>> def parabola(cells):  # q - (omega - 1/2)^2, of which only intervals are known
...     (a, b), (q, p) = cells[:, 0].T - 0.5, cells[:, 1].T
...     most, least = np.maximum(a * a, b * b), np.where(a * b < 0, 0, np.minimum(a * a, b * b))
...     return LineBound.between(q - most, p - least, np.stack([most - least, p - q], -1))
>>> found = search([parabola], [[[-1, 1]]], [[0, 1]], wide=lambda q: q[..., 1] - q[..., 0] > 1e-3)
>>> bool(found.kept.outer[:, 0, 1].max() < 0 < found.broken.outer[:, 0, 0].min() < 0.002)
True
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeAlias, TypeVar

from haptisym.kernel.arrays import np
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import LimitError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Array: TypeAlias = (
    Any  # numpy arrays of floats, or of whole numbers and truth values where that is said
)

_ROUNDING = 1e-13  # of a line, relative to the sizes that it is made of
_SOLVED = 1e-12  # of a piece: what a place on it that a line shows is rounded outward by
_UNKNOWN = 32  # pieces of a cell about which nothing is known that are cut
# Pieces of a cell that cannot be cut: with more it is most likely not settled by cutting them.
_CROWD = 16
_LOST = 64  # times all that F changes: a remainder that says nothing of the side that it is due to
_FINEST = 1e-10  # of an inner side: pieces are cut no further
_MOST = 100_000  # pieces that are looked at in a search, unless it is told otherwise
_BATCH = 1024  # cells that are bounded together


@dataclass(frozen=True, eq=False)
class LineBound:
    """A judge's bound of a function over n cells: |F - (middle + slope t + bend t^2)| <= rest, t
    from -1 to 1 along omega.

    ``middle``, ``slope``, ``bend``, ``rest`` : (n,); not finite where nothing is known. ``changes``
    : (n, sides), how much F changes along each side, in units of F, omega first. They choose the
    side that is cut, and are no part of what is proven.
    """

    middle: Array
    slope: Array
    bend: Array
    rest: Array
    changes: Array

    @classmethod
    def of(cls, c0: Array, c1: Array, c2: Array, r: Array) -> LineBound:
        """The bound that follows from a Taylor model c0 + c1.t + t.c2.t +- r over each cell; shapes
        (n,), (n, sides), (n, sides, sides), (n,)."""
        with np.errstate(all="ignore"):  # what is not finite is unknown
            slope = c1[:, 0]
            bend = c2[:, 0, 0]
            first = np.abs(c1)
            second = np.abs(c2).sum(-1)
            change = first + second
            largest = change.max(-1)
            all_second = second.sum(-1)
            size = np.abs(c0) + first.sum(-1) + all_second
            # Along every side |t| <= 1, so that a coefficient is the most that its term can be: all
            # but the line and the bend along omega goes into the rest.
            across = first[:, 1:].sum(-1)
            mixed = all_second - np.abs(bend)
            rest = across + mixed + r
            rest = rest + _ROUNDING * (size + r)
            # The remainder is of third order, so that a side's share in it goes by the cube.
            share = (change / largest[:, None]) ** 3
            unit = np.where(largest > 0, r / share.sum(-1), 0.0)
            changes = change + unit[:, None] * share
            # Such a remainder comes of cancellation, not of a side: with no change known at all,
            # ``_rates`` cuts the side that is relatively widest.
            changes[r > _LOST * largest] = 0.0
            return cls(c0, slope, bend, rest, changes)

    @classmethod
    def between(cls, low: Array, high: Array, changes: Array) -> LineBound:
        """The bound of a function that lies between two known numbers on each cell."""
        with np.errstate(all="ignore"):
            middle = (low + high) / 2
            rest = (high - low) / 2
            size = np.abs(middle) + rest
            none = np.zeros_like(middle)
            return cls(middle, none, none, rest + _ROUNDING * size, changes)

    @property
    def known(self) -> Array:
        """For each cell, whether the bound is finite: elsewhere nothing is known."""
        return (
            np.isfinite(self.middle)
            & np.isfinite(self.slope)
            & np.isfinite(self.bend)
            & np.isfinite(self.rest)
        )

    @property
    def negative(self) -> Array:
        """For each cell, whether F < 0 is proven all over it."""
        low, high = _hull(self.bend, self.slope, self.middle + self.rest)
        return self.known & (low > high)

    def never_positive(self) -> LineBound:
        """The bound with a rest so wide that it never shows F > 0; for functions whose positive
        sign proves nothing."""
        with np.errstate(all="ignore"):
            # With rest >= max(middle + slope t + bend t^2) the lower bound is nowhere positive.
            # Where that maximum is negative the rest stays as it is, so that F < 0 still shows.
            steepest = np.abs(self.slope)
            sizes = np.abs(self.middle) + steepest + np.abs(self.bend)
            top = self.middle + steepest + np.maximum(self.bend, 0.0)
            top = top + _ROUNDING * sizes
            return replace(self, rest=np.maximum(self.rest, top))

    def known_negative(self, which: Array) -> LineBound:
        """The bound with F < 0 on the chosen cells, where that was proven in another way."""
        middle = self.middle.copy()
        slope = self.slope.copy()
        bend = self.bend.copy()
        rest = self.rest.copy()
        middle[which] = -1.0
        slope[which] = 0.0
        bend[which] = 0.0
        rest[which] = 0.0
        return LineBound(middle, slope, bend, rest, self.changes)

    def __getitem__(self, which: Array) -> LineBound:
        return LineBound(
            self.middle[which],
            self.slope[which],
            self.bend[which],
            self.rest[which],
            self.changes[which],
        )

    @classmethod
    def together(cls, own: Sequence[LineBound]) -> LineBound:
        """Concatenate bounds into one that covers all of their cells."""
        arrays = []
        for name in ("middle", "slope", "bend", "rest", "changes"):
            parts = [getattr(x, name) for x in own]
            arrays.append(np.concatenate(parts))
        return cls(*arrays)


def _roots(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """The zeros of a t^2 + b t + c in order, by the formula that loses nothing; infinite or nan
    where there are none.

    They are those of a parabola whose coefficients differ from these by some roundings, which
    ``rest`` allows for.
    """
    # Scaled to at most 1, so that b^2 and 4 a c cannot overflow. With the root of the discriminant
    # taken with the sign of b nothing cancels in q; the other zero is c/q (Vieta).
    size = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(c))
    a = a / size
    b = b / size
    c = c / size
    sign = np.where(b < 0, -1.0, 1.0)
    root = np.sqrt(b * b - 4 * a * c)
    q = -(b + sign * root) / 2
    one = q / a
    other = c / q
    return np.minimum(one, other), np.maximum(one, other)


def _hull(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """The least interval of [-1, 1] outside of which a t^2 + b t + c < 0; empty, with low > high,
    where it is so everywhere."""
    with np.errstate(all="ignore"):
        first, last = _roots(a, b, c)
        has_no_zero = b * b - 4 * a * c < 0
        linear = np.abs(a) <= 0
        at = -c / b  # the zero of the line
        # Bent down, it is >= 0 between its zeros; bent up, outside of them, which leaves an end of
        # [-1, 1] as it is unless the outer part on that side lies beyond it.
        bent_up_low = np.where(first < -1, last, -1.0)
        bent_up_high = np.where(last > 1, first, 1.0)
        bent_low = np.where(a < 0, first, bent_up_low)
        bent_high = np.where(a < 0, last, bent_up_high)
        linear_low = np.where(b > 0, at, -1.0)
        linear_high = np.where(b < 0, at, 1.0)
        low = np.where(linear, linear_low, bent_low)
        high = np.where(linear, linear_high, bent_high)
        # Rounded outward by more than the rounding of a zero in [-1, 1], as what is cut is lost.
        low = np.maximum(low - _SOLVED, -1.0)
        high = np.minimum(high + _SOLVED, 1.0)
        # Without zeros the sign is that of c; where a zero is not finite nothing is cut off.
        constant = linear & (b == 0)
        empty = np.where(constant | has_no_zero, c < 0, low > high)
        whole = has_no_zero | ~(np.isfinite(low) & np.isfinite(high))
        low = np.where(whole, -1.0, low)
        high = np.where(whole, 1.0, high)
        return np.where(empty, 1.0, low), np.where(empty, -1.0, high)


def _first(a: Array, b: Array, c: Array) -> Array:
    """The lowest t of [-1, 1] at which a t^2 + b t + c > 0 shows; nan where none does."""
    with np.errstate(all="ignore"):
        at_start = a - b + c > 0
        at_end = a + b + c > 0
        low, high = _roots(a, b, c)
        # Not positive at -1, it becomes so at its lower zero if it bends down, at the upper one if
        # it bends up. The zero is rounded upward, since a ceiling may be too high, never too low.
        bent_zero = np.where(a < 0, low, high)
        inside = np.where(np.abs(a) > 0, bent_zero, -c / b) + _SOLVED
        top = np.clip(-b / (2 * a), -1.0, 1.0)  # where it is largest, if it bends down
        # A zero alone proves nothing: a value further on must be seen to be positive.
        at_top = c + top * (b + top * a) > 0
        shows_later = at_end | ((a < 0) & (top > inside) & at_top)
        is_inside = (inside > -1) & (inside < 1) & shows_later
        after_start = np.where(is_inside, inside, np.where(at_end, 1.0, np.nan))
        return np.where(at_start, -1.0, after_start)


Judge: TypeAlias = Callable[[Array], LineBound]
"""Bounds a function over cells (n, sides, 2), each given by the two ends of its sides: omega, the
outer sides, then the other inner sides."""


class Rows(Protocol):
    """Cells in arrays of one length, as a numpy array is."""

    def __len__(self) -> int: ...
    def __getitem__(self, which: Any) -> Any: ...


@dataclass(frozen=True, eq=False)
class Columns:
    """Arrays of one length as rows; unpacks into them."""

    arrays: tuple[Array, ...]

    def __len__(self) -> int:
        return len(self.arrays[0])

    def __iter__(self) -> Iterator[Array]:
        return iter(self.arrays)

    def __getitem__(self, which: Any) -> Columns:
        return Columns(tuple(x[which] for x in self.arrays))

    @classmethod
    def together(cls, rows: Sequence[Columns]) -> Columns:
        """Concatenate rows into one object that holds all of them."""
        return cls(tuple(map(np.concatenate, zip(*rows, strict=True))))


R = TypeVar("R", bound=Rows)


class Batches(Generic[R]):
    """The queue of cells in arrays, many at a time: ``kernel.budget.Waiting`` for what is bounded a
    thousand at once.

    Iterating gives up to ``size`` cells, ticks the budget, and ends when none waits or ``most``
    were given, or more. A loop that goes on has settled them, but for what it put back with
    ``add``. LimitError out of the iteration when the time is over.
    ``rest`` : all that is not settled, also what a loop was left with.

    ``rank`` : of rows an array, least for those to be given first; if there is none they come as
    they were added.

    >>> waiting, settled = Batches(np.array([[0, 8]]), size=2), []
    >>> for cells in waiting:
    ...     wide = cells[:, 1] - cells[:, 0] > 3
    ...     settled += cells[~wide].tolist()
    ...     waiting.add(halves(cells[wide, None], np.zeros(wide.sum(), int))[:, 0])
    >>> sorted(settled)
    [[0, 2], [2, 4], [4, 6], [6, 8]]
    """

    def __init__(
        self,
        first: R,
        *,
        size: int,
        rank: Callable[[R], Array] | None = None,
        most: int | None = None,
        what: str = "",
    ) -> None:
        self.examined = 0
        self._size = size
        self._rank = rank
        self._most = most
        self._what = what
        self._waiting: list[R] = [first]
        self._given: R = first[:0]

    def add(self, *cells: R) -> None:
        """Let cells wait, in place of those that were given last."""
        self._given = self._given[:0]
        self._waiting += [x for x in cells if len(x)]

    def replace(self, cells: R) -> None:
        """Replace the queue by these cells."""
        self._given = cells[:0]
        self._waiting = [cells]

    def __iter__(self) -> Iterator[R]:
        while any(map(len, self._waiting)):
            if self._most is not None and self.examined >= self._most:
                return
            cells = joined(self._waiting)
            # Before any cell leaves the queue: a LimitError here loses none of them from ``rest``.
            examined = min(self.examined, self._most or self.examined)
            tick(examined, self._most, self._what)
            if self._rank is not None:
                order = np.argsort(self._rank(cells), kind="stable")
                cells = cells[order]
            self._given = cells[: self._size]
            self._waiting = [cells[self._size :]]
            self.examined += len(self._given)
            yield self._given
            self._given = self._given[:0]

    @property
    def rest(self) -> R:
        """All cells that are not settled."""
        return joined([self._given, *self._waiting])


def joined(rows: Sequence[R]) -> R:
    """Concatenate rows; at least one must be given, which may be empty."""
    filled = [x for x in rows if len(x)] or [*rows[:1]]
    if len(filled) == 1:
        return filled[0]
    together: Any = np.concatenate
    if not isinstance(filled[0], np.ndarray):
        together = type(filled[0]).together  # type: ignore[attr-defined]
    all_rows: R = together(filled)
    return all_rows


def halves(cells: Array, side: Array) -> Array:
    """Each cell (n, sides, 2) cut in two along a side: all lower halves, then all upper ones."""
    lower = cells.copy()
    upper = cells.copy()
    rows = np.arange(len(cells))
    start, end = cells[rows, side].T
    middle = (start + end) / 2
    lower[rows, side, 1] = middle
    upper[rows, side, 0] = middle
    return np.concatenate([lower, upper])


def touching(cells: Array) -> Array:
    """A label for each cell, the same for cells that touch, directly or through others."""
    label = np.full(len(cells), -1)
    low, high = np.ascontiguousarray(cells.T)
    alone = np.arange(len(cells))
    while len(alone):
        first, waiting = alone[0], [alone[0]]
        label[first] = first
        while waiting:
            # Closed boxes meet where their intervals overlap along every side, ends included.
            current = waiting.pop()
            start = low[:, current, None]
            end = high[:, current, None]
            begins_before = (low[:, alone] <= end).all(0)
            ends_after = (start <= high[:, alone]).all(0)
            near = begins_before & ends_after
            label[alone[near]] = first
            waiting += alone[near].tolist()
            alone = alone[~near]
    return label


@dataclass(frozen=True, eq=False)
class Pieces:
    """Boxes of inner sides, (pieces, inner, 2); ``owner`` : (pieces,), the number of the outer cell
    that each belongs to."""

    owner: Array
    inner: Array

    def __len__(self) -> int:
        return len(self.owner)

    def __getitem__(self, which: Array) -> Pieces:
        return Pieces(self.owner[which], self.inner[which])

    @classmethod
    def together(cls, own: Sequence[Pieces]) -> Pieces:
        """Concatenate pieces of the same outer cells."""
        owner = np.concatenate([x.owner for x in own])
        inner = np.concatenate([x.inner for x in own])
        return cls(owner, inner)

    def cells(self, outer: Array) -> Array:
        """The cells that a judge takes: omega, the sides of the outer cell, the other inner
        sides."""
        omega, others = self.inner[:, :1], self.inner[:, 1:]
        return np.concatenate([omega, outer[self.owner], others], 1)


@dataclass(frozen=True, eq=False)
class Cells:
    """Outer cells (n, outer, 2), for each judge the pieces on which its sign is open, and what is
    proven of each cell.

    ``floor``, ``ceiling`` : (n,), bounds on the lowest omega from which on a judge is positive, as
    above; ``by`` : (n,), the number of the judge that is positive at the ceiling, for all of the
    cell; -1 where there is none.
    """

    outer: Array
    pieces: tuple[Pieces, ...]
    floor: Array
    ceiling: Array
    by: Array

    @classmethod
    def of(cls, outer: ArrayLike, inner: Sequence[ArrayLike]) -> Cells:
        """Outer cells of which nothing is known; ``inner`` : for each judge the pieces to begin
        with, (pieces, inner, 2)."""
        cells = np.asarray(outer, float)
        n = len(cells)
        pieces = []
        for boxes in inner:
            first = np.asarray(boxes, float)
            owner = np.repeat(np.arange(n), len(first))
            pieces.append(Pieces(owner, np.tile(first, (n, 1, 1))))
        floor = np.full(n, -np.inf)
        ceiling = np.full(n, np.inf)
        return cls(cells, tuple(pieces), floor, ceiling, np.full(n, -1))

    def __len__(self) -> int:
        return len(self.outer)

    def __getitem__(self, which: Any) -> Cells:
        """Some of the cells, chosen by a slice, by numbers (each once) or by truth values."""
        # Cells get new numbers, and pieces follow their owners; -1 marks a cell that was not
        # chosen.
        chosen = np.arange(len(self))[which]
        number = np.full(len(self), -1)
        number[chosen] = np.arange(len(chosen))
        pieces = []
        for x in self.pieces:
            owner = number[x.owner]
            is_kept = owner >= 0
            pieces.append(Pieces(owner[is_kept], x.inner[is_kept]))
        return Cells(
            self.outer[chosen],
            tuple(pieces),
            self.floor[chosen],
            self.ceiling[chosen],
            self.by[chosen],
        )

    @classmethod
    def together(cls, rows: Sequence[Cells]) -> Cells:
        """Concatenate cells; the owners of pieces are renumbered."""
        moved = []
        start = 0
        for x in rows:
            moved.append([replace(p, owner=p.owner + start) for p in x.pieces])
            start += len(x)
        return cls(
            outer=np.concatenate([x.outer for x in rows]),
            pieces=tuple(map(Pieces.together, zip(*moved, strict=True))),
            floor=np.concatenate([x.floor for x in rows]),
            ceiling=np.concatenate([x.ceiling for x in rows]),
            by=np.concatenate([x.by for x in rows]),
        )

    @property
    def has_no_pieces(self) -> Array:
        """For each cell, whether no sign is open in it, so that cutting it would show no more."""
        owners = [np.zeros(0, int), *(x.owner for x in self.pieces)]
        counts = np.bincount(np.concatenate(owners), minlength=len(self))
        return counts == 0

    def extended(self, inner: Sequence[ArrayLike]) -> Cells:
        """The cells with more pieces for each judge, at which nothing is known yet; what was proven
        at lower frequencies stays."""
        more = Cells.of(self.outer, inner).pieces
        pairs = zip(self.pieces, more, strict=True)
        pieces = tuple(map(Pieces.together, pairs))
        least = np.inf  # of all omega on the new pieces
        for x in inner:
            boxes = np.asarray(x)
            if len(boxes):
                least = min(least, boxes[:, 0, 0].min())
        return replace(self, pieces=pieces, floor=np.minimum(self.floor, least))

    def halves(self, side: Array) -> Cells:
        """Each cell cut in two along a side; both halves keep all of its pieces."""
        both = Cells.together([self, self])
        return replace(both, outer=halves(self.outer, side))


Settled: TypeAlias = Callable[[Array, Array], Array]
"""For each cell, whether it is settled, given floors and ceilings. What a ceiling settles, a lower
one must settle too."""


def told(floor: Array, ceiling: Array) -> Array:
    """For each cell, whether it is kept (every function is negative everywhere) or broken (one is
    positive for all of the cell)."""
    return (floor == np.inf) | (ceiling < np.inf)


def no_better(bound: float) -> Settled:
    """The rule for a search of the largest first(q): a cell is settled that holds no larger value
    than ``bound``, which is attained."""
    return lambda floor, ceiling: ceiling <= bound


def no_worse(bound: float) -> Settled:
    """The rule for a search of the smallest first(q): a cell is settled that holds no smaller value
    than ``bound``, which was seen."""
    return lambda floor, ceiling: floor >= bound


class Search:
    """The search: outer cells are cut until they are settled. Iterating gives, round by round,
    those that were settled.

    ``wide`` : of outer cells (n, outer, 2) which sides, (n, outer), may be cut: one that is wide
    along none is left.
    ``settled`` : which are settled; may be set to a stricter or a looser rule between rounds.
    ``rank`` : of ``Cells`` an array, least for those to be cut first, at most ``batch`` in a round;
    all at once if there is none. ``last`` : how often the pieces of cells that cannot be cut are
    cut once more, if they are few. ``most`` : pieces that are looked at, in all.

    ``left`` : what is not settled: what was too small, and what waited when it was enough or the
    time was over. Never a LimitError.
    """

    def __init__(
        self,
        judges: Sequence[Judge],
        first: Cells,
        *,
        wide: Callable[[Array], Array],
        settled: Settled = told,
        rank: Callable[[Cells], Array] | None = None,
        batch: int = _BATCH,
        last: int = 0,
        most: int = _MOST,
        what: str = "cells",
    ) -> None:
        self.judges = judges
        self.settled = settled
        self.looked = 0
        self._wide = wide
        self._last = last
        self._most = most
        self._what = what
        # For each judge the width of the domain along each inner side, times the share.
        self._finest: list[Array] = []
        for x in first.pieces:
            widths = np.ptp(x.inner, (0, 2)) if len(x) else 0.0
            self._finest.append(widths * _FINEST)
        size = len(first) + most if rank is None else batch
        self.waiting = Batches(first, size=size, rank=rank, what=what)
        self._small: list[Cells] = [first[:0]]

    def __iter__(self) -> Iterator[Cells]:
        try:
            for cells in self.waiting:
                if self.looked > self._most:
                    return
                judged, changes = self._judged(cells)
                done = self.settled(judged.floor, judged.ceiling)
                open_cells = judged[~done]
                changes = changes[~done]
                # Without an open piece no judge has anything to add, on however small a cell.
                is_wide = self._wide(open_cells.outer).any(-1)
                small = ~is_wide | open_cells.has_no_pieces
                self._small.append(open_cells[small])
                self.waiting.add(self._cut(open_cells[~small], changes[~small]))
                yield judged[done]
        except LimitError:
            return

    @property
    def left(self) -> Cells:
        """All cells that are not settled: too small to be cut, or still waiting."""
        return joined([*self._small, self.waiting.rest])

    def restart(self, cells: Cells) -> None:
        """Go on with these cells in place of all that is left."""
        self._small = [cells[:0]]
        self.waiting.replace(cells)

    def _cut(self, cells: Cells, changes: Array) -> Cells:
        """Cut each cell along the side on which the functions change most; into four where there
        are few, which cost as much as many."""
        is_few = sum(map(len, cells.pieces)) * 16 <= _BATCH
        for _ in range(2 if is_few else 1):
            # Without a change noted (``_open``) only pieces of a cell were cut: it waits as it is.
            wide = self._wide(cells.outer) & (changes > 0)
            is_cut = wide.any(-1)
            side = np.argmax(np.where(wide, changes, -1.0), -1)
            # About half as much is left along the side that is cut, which the second cut respects.
            changes[np.arange(len(side)), side] /= 2
            in_two = cells[is_cut].halves(side[is_cut])
            cells = joined([cells[~is_cut], in_two])
            cut = changes[is_cut]
            changes = np.concatenate([changes[~is_cut], cut, cut])
        return cells

    def _judged(self, cells: Cells) -> tuple[Cells, Array]:
        """The cells with what every judge shows of them, and the most that any function whose sign
        is open changes along each of their sides."""
        judged = replace(cells, ceiling=cells.ceiling.copy(), by=cells.by.copy())
        changes = np.zeros(cells.outer.shape[:2])
        waiting = [*cells.pieces]
        kept = [list[Pieces]() for _ in cells.pieces]
        # In the first round each judge sees all of its pieces, in the next ones the halves of those
        # that were cut. A ceiling that one judge lowers spares the others all pieces above it. In
        # the last round nothing is cut, so that none is left waiting.
        for n in range(2 + self._last):
            for i, open_pieces in enumerate(waiting):
                still, waiting[i] = self._open(i, n, judged, open_pieces, changes)
                kept[i].append(still)
        # Outside of the pieces every F_i is negative up to the ceiling: first(q) lies no lower than
        # the lowest piece. Pieces above the ceiling cannot change it, and are dropped.
        floor = judged.ceiling.copy()
        pieces = []
        for rounds in kept:
            below = _below_ceiling(Pieces.together(rounds), judged)
            np.minimum.at(floor, below.owner, below.inner[:, 0, 0])
            pieces.append(below)
        return replace(judged, pieces=tuple(pieces), floor=floor), changes

    def _open(
        self, i: int, n: int, judged: Cells, pieces: Pieces, changes: Array
    ) -> tuple[Pieces, Pieces]:
        """Judge the pieces of one function in round n: those on which its sign stays open, and the
        halves of those that are cut. Lowers ceilings of ``judged`` and raises ``changes`` in place.
        """
        done = self.settled(judged.floor, judged.ceiling)[pieces.owner]
        # Kept, not dropped: what is settled now may not be under a stricter rule.
        idle = pieces[done]
        pieces = _below_ceiling(pieces[~done], judged)
        if not len(pieces):
            return idle, pieces
        small = ~self._wide(judged.outer).any(-1)
        curve = self._curve(i, pieces.cells(judged.outer))
        pieces, curve = _contracted(i, judged, pieces, curve)
        rates = _rates(pieces, curve, judged.outer)
        # Omega comes first, then the outer sides, then the other inner ones.
        end = 1 + judged.outer.shape[1]
        outward = rates[:, 1:end]
        inward = np.delete(rates, range(1, end), -1)
        count = len(judged)
        unknown_of_cell = np.bincount(pieces.owner[~curve.known], minlength=count)
        unknown = unknown_of_cell[pieces.owner]
        start, stop = pieces.inner[..., 0], pieces.inner[..., 1]
        fine = (stop - start <= self._finest[i]).all(-1)
        # A piece is cut if F changes at least half as much inside as between the cell's values of
        # q. Where nothing is known of many pieces (a pole that moves with q), the cell is to blame.
        changes_inside = inward.max(-1) >= outward.max(-1, initial=0.0) / 2
        may_tell = curve.known | (unknown <= _UNKNOWN)
        wider = changes_inside & may_tell & ~fine
        of_cell = np.bincount(pieces.owner, minlength=count)
        few = of_cell[pieces.owner] <= _CROWD
        # Cells that cannot be cut have no other way left: their pieces are, a few times more.
        last_resort = small[pieces.owner] & ~fine & few & (n < self._last)
        more = (wider & (n == 0)) | last_resort
        # A change > 0 is what asks for a cut of the cell (``_cut``): it must not be exactly 0 here.
        np.maximum.at(changes, pieces.owner[~wider], outward[~wider] + 1e-300)
        still = Pieces.together([idle, pieces[~more]])
        side = np.argmax(inward[more], -1)
        owner = np.tile(pieces.owner[more], 2)
        return still, Pieces(owner, halves(pieces.inner[more], side))

    def _curve(self, i: int, cells: Array) -> LineBound:
        """The bound of one judge over all these cells, computed for a batch at a time."""
        bounds = list[LineBound]()
        for start in range(0, len(cells), _BATCH):
            tick(min(self.looked, self._most), self._most, self._what)
            batch = cells[start : start + _BATCH]
            bounds.append(self.judges[i](batch))
        self.looked += len(cells)
        return bounds[0] if len(bounds) == 1 else LineBound.together(bounds)


def _below_ceiling(pieces: Pieces, cells: Cells) -> Pieces:
    """The pieces that begin below the ceiling of their cell: the others cannot change it."""
    return pieces[pieces.inner[:, 0, 0] < cells.ceiling[pieces.owner]]


def _contracted(i: int, cells: Cells, pieces: Pieces, curve: LineBound) -> tuple[Pieces, LineBound]:
    """The pieces without the parts on which the curve is shown to be negative; lowers ceilings of
    ``cells`` to where it is shown to be positive."""
    start, end = pieces.inner[:, 0].T
    radius = (end - start) / 2
    positive = _first(curve.bend, curve.slope, curve.middle - curve.rest)
    shown = curve.known & np.isfinite(positive)
    before = cells.ceiling.copy()
    # A ceiling is rounded upward inside of the piece; the ends themselves are exact, and stay.
    above = np.nextafter(start + radius * (1 + positive), np.inf)
    at = np.where(positive < 1, np.minimum(above, end), end)
    at = np.where(positive > -1, at, start)
    # ``minimum.at``, as one cell may own several of the pieces.
    np.minimum.at(cells.ceiling, pieces.owner[shown], at[shown])
    cells.by[cells.ceiling < before] = i
    # Outside of the hull the upper bound is negative: that part goes, all of it if the hull is
    # empty.
    low, high = _hull(curve.bend, curve.slope, curve.middle + curve.rest)
    inner = pieces.inner.copy()
    known = curve.known
    inner[known, 0] = _along(inner[known, 0], low[known], high[known])
    left = ~known | (low <= high)
    return Pieces(pieces.owner[left], inner[left]), curve[left]


def _along(omega: Array, low: Array, high: Array) -> Array:
    """The part of intervals (n, 2) that t from ``low`` to ``high`` stands for, where t goes from -1
    to 1 over each; rounded outward, but not beyond their ends."""
    start, end = omega.T
    radius = (end - start) / 2
    first = start + radius * (1 + low)
    last = start + radius * (1 + high)
    first = np.nextafter(first, -np.inf)
    last = np.nextafter(last, np.inf)
    return np.stack([np.maximum(start, first), np.minimum(end, last)], -1)


def zeros(omega: Array, middle: Array, rest: Array, slope: tuple[Array, Array]) -> Array:
    """The part of intervals (n, 2) of omega on which F may vanish: one step of Newton's method for
    intervals.

    For all else in a cell |F - ``middle``| <= ``rest`` in the middle of omega, and dF/dt lies
    between the two of ``slope`` all over it, t from -1 to 1. Nothing is left out where the slope
    may be 0, or is not known.
    """
    with np.errstate(all="ignore"):  # what is not finite is unknown
        reach = rest * (1 + _ROUNDING)
        # By the mean value theorem a zero t obeys slope t = -middle +- rest for some slope in
        # between; the quotient is largest and smallest at ends, if the slope is not 0.
        ends = np.stack([(x - middle) / steep for x in (-reach, reach) for steep in slope])
        least, most = slope
        is_shown = (least * most > 0) & np.isfinite(ends).all(0)
        low = np.clip(ends.min(0) - _ROUNDING, -1.0, 1.0)
        high = np.clip(ends.max(0) + _ROUNDING, -1.0, 1.0)
        return np.where(is_shown[:, None], _along(omega, low, high), omega)


def _rates(pieces: Pieces, curve: LineBound, outer: Array) -> Array:
    """The share of each side in a function's change, adding up to 1; where its changes are unknown,
    the share in the relative widths."""
    cells = pieces.cells(outer)
    with np.errstate(all="ignore"):
        widths = cells[..., 1] - cells[..., 0]
        sizes = np.maximum(np.abs(cells).max(-1), 1e-300)
        spread = widths / sizes
        is_finite = np.isfinite(curve.changes).all(-1)
        known = is_finite & (curve.changes.max(-1, initial=0.0) > 0)
        rates = np.where(known[:, None], curve.changes, spread)
        return np.nan_to_num(rates / rates.sum(-1, keepdims=True))


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The result of a search: outer cells in three parts, which together fill the domain.

    ``kept`` : every function is negative all over them. ``broken`` : one function is positive for
    all of their parameters. ``left`` : undecided.
    """

    kept: Cells
    broken: Cells
    left: Cells

    @property
    def parts(self) -> tuple[Cells, Cells, Cells]:
        """Kept, broken and left cells, in this order."""
        return self.kept, self.broken, self.left


def search(
    judges: Sequence[Judge],
    outer: ArrayLike,
    inner: ArrayLike,
    *,
    wide: Callable[[Array], Array],
    last: int = 0,
    most: int = _MOST,
    what: str = "cells",
) -> SearchResult:
    """Search a domain that is filled by outer cells: where it is kept, where it is broken, and what
    is left undecided.

    ``inner`` : (inner, 2) or (pieces, inner, 2), the pieces to begin with, the same for all judges.
    The other arguments are those of ``Search``.
    """
    first = np.asarray(inner, float)
    boxes = first if first.ndim == 3 else first[None]
    cells = Cells.of(outer, [boxes] * len(judges))
    work = Search(judges, cells, wide=wide, last=last, most=most, what=what)
    settled = joined([cells[:0], *work])
    broken = settled.ceiling < np.inf
    return SearchResult(settled[~broken], settled[broken], work.left)
