"""Where, in a box of omega and up to three numbers, is each of some functions positive, negative or
unknown: the one search.

Branch and bound. The sides of the box are of two kinds. *Outer* ones are values of parameters q,
which are settled cell by cell; *inner* ones stand behind each outer cell: omega first, then what
else a cell is to be settled for. For each function F_i an outer cell holds *pieces* of the inner
sides, those on which the sign of F_i is open.

**Guaranteed** of every outer cell, at any time, with first(q) the lowest omega from which on some
F_i > 0 (infinite if there is none)::

    floor <= first(q) <= ceiling  for all q of the cell;
    F_i(omega, q) < 0  for all q of the cell, all omega below the ceiling, and all else, outside of the pieces of F_i.

A cell is *kept* where its floor is infinite (no piece is left, and nothing is positive), *broken*
where its ceiling is not: F_i, i = ``by``, is positive at that omega for all q of the cell. What is
not settled is returned, always: cells that are too small to be cut, and those that waited when the
budget, or the time, was over. Nothing is claimed about F_i itself: what a judge says of it must be
proven. Cells are closed, and ends that are rounded are within what the judge must allow for (an ulp
of the box).

**A judge** tells of F_i, over many cells at once, a line along omega and how far F_i may be from
it::

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
(``Search``). The queue,
``Batches``, serves searches that have no outer cells too.

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
_CROWD = 16  # pieces of a cell that cannot be cut: with more it is most likely not settled by cutting them
_LOST = 64  # times all that F changes: a remainder that says nothing of the side that it is due to
_FINEST = 1e-10  # of an inner side: pieces are cut no further
_MOST, _BATCH = 100_000, 1024


@dataclass(frozen=True, eq=False)
class LineBound:
    """What a judge says of a function over n cells: |F - (middle + slope t + bend t^2)| <= rest, t
    from -1 to 1 along omega.

    ``middle``, ``slope``, ``bend``, ``rest`` : (n,); not finite where nothing is known. ``changes``
    : (n, sides), how much F changes along each side, in units of F, omega first; what cells are cut
    by, and no part of what is proven.
    """

    middle: Array
    slope: Array
    bend: Array
    rest: Array
    changes: Array

    @classmethod
    def of(cls, c0: Array, c1: Array, c2: Array, r: Array) -> LineBound:
        """Of a Taylor model c0 + c1.t + t.c2.t +- r over each cell, (n,), (n, sides), (n, sides,
        sides), (n,)."""
        with np.errstate(all="ignore"):  # what is not finite is unknown
            first, second = np.abs(c1), np.abs(c2).sum(-1)
            own, most = first + second, np.abs(c0) + first.sum(-1) + second.sum(-1)
            rest = first[:, 1:].sum(-1) + (second.sum(-1) - np.abs(c2[:, 0, 0])) + r
            share = (own / own.max(-1, keepdims=True)) ** 3
            changes = own + np.where(own.max(-1) > 0, r / share.sum(-1), 0.0)[:, None] * share
            changes[r > _LOST * own.max(-1)] = 0.0
            return cls(c0, c1[:, 0], c2[:, 0, 0], rest + _ROUNDING * (most + r), changes)

    @classmethod
    def between(cls, low: Array, high: Array, changes: Array) -> LineBound:
        """Of a function that lies between two numbers on each cell."""
        with np.errstate(all="ignore"):
            middle, rest = (low + high) / 2, (high - low) / 2
            none = np.zeros_like(middle)
            return cls(middle, none, none, rest + _ROUNDING * (np.abs(middle) + rest), changes)

    @property
    def known(self) -> Array:
        """Of which cells anything is known."""
        return (
            np.isfinite(self.middle)
            & np.isfinite(self.slope)
            & np.isfinite(self.bend)
            & np.isfinite(self.rest)
        )

    @property
    def negative(self) -> Array:
        """On which cells F < 0, for all that is in them."""
        low, high = _hull(self.bend, self.slope, self.middle + self.rest)
        return self.known & (low > high)

    def never_positive(self) -> LineBound:
        """The same of a function whose being positive would mean nothing."""
        with np.errstate(all="ignore"):
            sizes = np.abs(self.middle) + np.abs(self.slope) + np.abs(self.bend)
            top = self.middle + np.abs(self.slope) + np.maximum(self.bend, 0.0)
            return replace(self, rest=np.maximum(self.rest, top + _ROUNDING * sizes))

    def known_negative(self, which: Array) -> LineBound:
        """The same of a function that was shown to be negative on some cells in another way."""
        middle, slope, bend, rest = (
            x.copy() for x in (self.middle, self.slope, self.bend, self.rest)
        )
        middle[which], slope[which], bend[which], rest[which] = -1.0, 0.0, 0.0, 0.0
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
        """All of several."""
        names = ("middle", "slope", "bend", "rest", "changes")
        return cls(*(np.concatenate([getattr(x, name) for x in own]) for name in names))


def _roots(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """The zeros of a t^2 + b t + c in order, by the formula that loses nothing; infinite or nan
    where there are none.

    They are those of a parabola whose coefficients differ from these by some roundings, which
    ``rest`` allows for.
    """
    size = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(c))
    a, b, c = a / size, b / size, c / size
    q = -(b + np.where(b < 0, -1.0, 1.0) * np.sqrt(b * b - 4 * a * c)) / 2
    one, other = q / a, c / q
    return np.minimum(one, other), np.maximum(one, other)


def _hull(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """The least interval of [-1, 1] outside of which a t^2 + b t + c < 0; empty, with low > high,
    where it is so everywhere."""
    with np.errstate(all="ignore"):
        first, last = _roots(a, b, c)
        none, linear = b * b - 4 * a * c < 0, np.abs(a) <= 0
        at = -c / b
        low = np.where(
            linear,
            np.where(b > 0, at, -1.0),
            np.where(a < 0, first, np.where(first < -1, last, -1.0)),
        )
        high = np.where(
            linear, np.where(b < 0, at, 1.0), np.where(a < 0, last, np.where(last > 1, first, 1.0))
        )
        low, high = np.maximum(low - _SOLVED, -1.0), np.minimum(high + _SOLVED, 1.0)
        empty = np.where(linear & (b == 0), c < 0, np.where(none, c < 0, low > high))
        whole = none | ~(np.isfinite(low) & np.isfinite(high))
        return np.where(empty, 1.0, np.where(whole, -1.0, low)), np.where(
            empty, -1.0, np.where(whole, 1.0, high)
        )


def _first(a: Array, b: Array, c: Array) -> Array:
    """The lowest t of [-1, 1] at which a t^2 + b t + c > 0 shows; nan where none does."""
    with np.errstate(all="ignore"):
        at_start, at_end = a - b + c > 0, a + b + c > 0
        low, high = _roots(a, b, c)
        inside = np.where(np.abs(a) > 0, np.where(a < 0, low, high), -c / b) + _SOLVED
        top = np.clip(-b / (2 * a), -1.0, 1.0)  # where it is largest, if it bends down
        is_inside = (
            (inside > -1)
            & (inside < 1)
            & (at_end | ((a < 0) & (top > inside) & (c + top * (b + top * a) > 0)))
        )
        return np.where(at_start, -1.0, np.where(is_inside, inside, np.where(at_end, 1.0, np.nan)))


Judge: TypeAlias = Callable[[Array], LineBound]
"""Of cells (n, sides, 2): from where to where of omega, of each outer side, then of the other inner
sides."""


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
        """All of several."""
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
        self._size, self._rank, self._most, self._what = size, rank, most, what
        self._waiting: list[R] = [first]
        self._given: R = first[:0]

    def add(self, *cells: R) -> None:
        """Let cells wait, in place of those that were given last."""
        self._given = self._given[:0]
        self._waiting += [x for x in cells if len(x)]

    def replace(self, cells: R) -> None:
        """Let these wait, in place of all that did."""
        self._given, self._waiting = cells[:0], [cells]

    def __iter__(self) -> Iterator[R]:
        while sum(map(len, self._waiting)) and (self._most is None or self.examined < self._most):
            cells = joined(self._waiting)
            tick(min(self.examined, self._most or self.examined), self._most, self._what)
            order = (
                slice(None) if self._rank is None else np.argsort(self._rank(cells), kind="stable")
            )
            cells = cells[order]
            self._given, self._waiting = cells[: self._size], [cells[self._size :]]
            self.examined += len(self._given)
            yield self._given
            self._given = self._given[:0]

    @property
    def rest(self) -> R:
        """All that are not settled."""
        return joined([self._given, *self._waiting])


def joined(rows: Sequence[R]) -> R:
    """Rows one after the other; one of them at least, which may be empty."""
    own = [x for x in rows if len(x)] or [*rows[:1]]
    if len(own) == 1:
        return own[0]
    together: Any = np.concatenate if isinstance(own[0], np.ndarray) else type(own[0]).together  # type: ignore[attr-defined]
    found: R = together(own)
    return found


def halves(cells: Array, side: Array) -> Array:
    """Each cell (n, sides, 2) cut in two along a side: all lower halves, then all upper ones."""
    lower, upper, rows = cells.copy(), cells.copy(), np.arange(len(cells))
    middle = (cells[rows, side, 0] + cells[rows, side, 1]) / 2
    lower[rows, side, 1], upper[rows, side, 0] = middle, middle
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
            own = waiting.pop()
            near = (low[:, alone] <= high[:, own, None]).all(0) & (
                low[:, own, None] <= high[:, alone]
            ).all(0)
            label[alone[near]] = first
            waiting += alone[near].tolist()
            alone = alone[~near]
    return label


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of the inner sides, (pieces, inner, 2); ``owner`` : behind which outer cell,
    (pieces,), by number."""

    owner: Array
    inner: Array

    def __len__(self) -> int:
        return len(self.owner)

    def __getitem__(self, which: Array) -> Pieces:
        return Pieces(self.owner[which], self.inner[which])

    @classmethod
    def together(cls, own: Sequence[Pieces]) -> Pieces:
        """All of several."""
        return cls(np.concatenate([x.owner for x in own]), np.concatenate([x.inner for x in own]))

    def cells(self, outer: Array) -> Array:
        """With the outer sides, as a judge takes them."""
        return np.concatenate([self.inner[:, :1], outer[self.owner], self.inner[:, 1:]], 1)


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
        n, found = len(cells), list[Pieces]()
        for x in inner:
            first = np.asarray(x, float)
            found.append(Pieces(np.repeat(np.arange(n), len(first)), np.tile(first, (n, 1, 1))))
        return cls(cells, tuple(found), np.full(n, -np.inf), np.full(n, np.inf), np.full(n, -1))

    def __len__(self) -> int:
        return len(self.outer)

    def __getitem__(self, which: Any) -> Cells:
        """Some of them, by a slice, numbers (each once) or truth values."""
        chosen = np.arange(len(self))[which]
        number = np.full(len(self), -1)
        number[chosen] = np.arange(len(chosen))
        owners = [number[x.owner] for x in self.pieces]
        own = (Pieces(n[n >= 0], x.inner[n >= 0]) for n, x in zip(owners, self.pieces, strict=True))
        return Cells(
            self.outer[chosen],
            tuple(own),
            self.floor[chosen],
            self.ceiling[chosen],
            self.by[chosen],
        )

    @classmethod
    def together(cls, rows: Sequence[Cells]) -> Cells:
        """All of several."""
        starts = np.cumsum([0, *map(len, rows)])
        moved = [
            [replace(p, owner=p.owner + n) for p in x.pieces]
            for x, n in zip(rows, starts, strict=False)
        ]
        pieces = tuple(map(Pieces.together, zip(*moved, strict=True)))
        arrays = (
            np.concatenate([getattr(x, name) for x in rows])
            for name in ("outer", "floor", "ceiling", "by")
        )
        outer, floor, ceiling, by = arrays
        return cls(outer, pieces, floor, ceiling, by)

    @property
    def has_no_pieces(self) -> Array:
        """Of which cells no sign is open: cutting them tells no more."""
        owners = [np.zeros(0, int), *(x.owner for x in self.pieces)]
        return np.bincount(np.concatenate(owners), minlength=len(self)) == 0

    def extended(self, inner: Sequence[ArrayLike]) -> Cells:
        """With more pieces behind each, for each judge; what was proven of frequencies below holds
        on."""
        more = Cells.of(self.outer, inner).pieces
        pieces = tuple(Pieces.together(pair) for pair in zip(self.pieces, more, strict=True))
        least = min(
            (np.asarray(x)[:, 0, 0].min() for x in inner if len(np.asarray(x))), default=np.inf
        )
        return replace(self, pieces=pieces, floor=np.minimum(self.floor, least))

    def halves(self, side: Array) -> Cells:
        """Each cut along a side, with the same pieces behind either half."""
        both = Cells.together([self, self])
        return replace(both, outer=halves(self.outer, side))


Settled: TypeAlias = Callable[[Array, Array], Array]
"""Which cells are settled, by floors and ceilings: as truth values. What a ceiling settles, a lower
one must too."""


def told(floor: Array, ceiling: Array) -> Array:
    """Which cells are kept, or broken: each function is negative everywhere, or one is positive for
    all of the cell."""
    return (floor == np.inf) | (ceiling < np.inf)


def no_better(bound: float) -> Settled:
    """For the largest first(q): which cells hold no larger one than is attained."""
    return lambda floor, ceiling: ceiling <= bound


def no_worse(bound: float) -> Settled:
    """For the smallest first(q): which cells hold no smaller one than was seen."""
    return lambda floor, ceiling: floor >= bound


class Search:
    """Cells that are cut until they are settled: iterating gives those that were settled, round by
    round.

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
        self.judges, self.settled, self.looked = judges, settled, 0
        self._wide, self._last, self._most, self._what = wide, last, most, what
        self._finest = [
            np.ptp(x.inner.reshape(-1, x.inner.shape[1], 2), (0, 2)) * _FINEST if len(x) else 0.0
            for x in first.pieces
        ]
        self.waiting = Batches(
            first, size=len(first) + most if rank is None else batch, rank=rank, what=what
        )
        self._small: list[Cells] = [first[:0]]

    def __iter__(self) -> Iterator[Cells]:
        try:
            for cells in self.waiting:
                if self.looked > self._most:
                    return
                found, changes = self._judged(cells)
                done = self.settled(found.floor, found.ceiling)
                open_, changes = found[~done], changes[~done]
                small = ~self._wide(open_.outer).any(-1) | open_.has_no_pieces
                self._small.append(open_[small])
                self.waiting.add(self._cut(open_[~small], changes[~small]))
                yield found[done]
        except LimitError:
            return

    @property
    def left(self) -> Cells:
        """All that is not settled."""
        return joined([*self._small, self.waiting.rest])

    def restart(self, cells: Cells) -> None:
        """Go on with these, in place of all that is left."""
        self._small = [cells[:0]]
        self.waiting.replace(cells)

    def _cut(self, cells: Cells, changes: Array) -> Cells:
        """Each along the side that changes most; of few into four, as few cost as much as many."""
        for _ in range(2 if sum(map(len, cells.pieces)) * 16 <= _BATCH else 1):
            own = (wide := self._wide(cells.outer) & (changes > 0)).any(-1)
            side = np.argmax(np.where(wide, changes, -1.0), -1)
            changes[np.arange(len(side)), side] /= 2
            cells = joined([cells[~own], cells[own].halves(side[own])])
            changes = np.concatenate([changes[~own], changes[own], changes[own]])
        return cells

    def _judged(self, cells: Cells) -> tuple[Cells, Array]:
        """What every judge shows of some cells, and how much each changes along their sides where
        that is open."""
        found, changes = (
            replace(cells, ceiling=cells.ceiling.copy(), by=cells.by.copy()),
            np.zeros(cells.outer.shape[:2]),
        )
        waiting, kept = [*cells.pieces], [list[Pieces]() for _ in cells.pieces]
        for n in range(2 + self._last):
            for i, own in enumerate(waiting):
                still, waiting[i] = self._open(i, n, found, own, changes)
                kept[i].append(still)
        floor = found.ceiling.copy()
        pieces = [Pieces.together(own) for own in kept]
        for i, own in enumerate(pieces):
            pieces[i] = own = own[own.inner[:, 0, 0] < found.ceiling[own.owner]]
            np.minimum.at(floor, own.owner, own.inner[:, 0, 0])
        return replace(found, pieces=tuple(pieces), floor=floor), changes

    def _open(
        self, i: int, n: int, found: Cells, pieces: Pieces, changes: Array
    ) -> tuple[Pieces, Pieces]:
        """On which pieces the sign of a judge stays open, and what others are cut into; lowers
        ceilings, and notes changes."""
        done = self.settled(found.floor, found.ceiling)[pieces.owner]
        idle, pieces = (
            pieces[done],
            pieces[~done],
        )  # what is settled now may not be under a stricter rule
        pieces = pieces[pieces.inner[:, 0, 0] < found.ceiling[pieces.owner]]
        if not len(pieces):
            return idle, pieces
        outer, small = found.outer.shape[1], ~self._wide(found.outer).any(-1)
        pieces, curve = _contracted(i, found, pieces, self._curve(i, pieces.cells(found.outer)))
        rates = _rates(pieces, curve, found.outer)
        own, along = np.delete(rates, range(1, 1 + outer), -1), rates[:, 1 : 1 + outer]
        unknown = np.bincount(pieces.owner[~curve.known], minlength=len(found))[pieces.owner]
        fine = (pieces.inner[..., 1] - pieces.inner[..., 0] <= self._finest[i]).all(-1)
        wider = (
            (own.max(-1) >= along.max(-1, initial=0.0) / 2)
            & (curve.known | (unknown <= _UNKNOWN))
            & ~fine
        )
        many = np.bincount(pieces.owner, minlength=len(found))[pieces.owner]
        more = (wider & (n == 0)) | (
            small[pieces.owner] & ~fine & (n < self._last) & (many <= _CROWD)
        )
        np.maximum.at(changes, pieces.owner[~wider], along[~wider] + 1e-300)
        owner = np.tile(pieces.owner[more], 2)
        still = Pieces.together([idle, pieces[~more]])
        return still, Pieces(owner, halves(pieces.inner[more], np.argmax(own[more], -1)))

    def _curve(self, i: int, cells: Array) -> LineBound:
        """What one judge says, some cells at a time."""
        found = list[LineBound]()
        for start in range(0, len(cells), _BATCH):
            tick(min(self.looked, self._most), self._most, self._what)
            found.append(self.judges[i](cells[start : start + _BATCH]))
        self.looked += len(cells)
        return found[0] if len(found) == 1 else LineBound.together(found)


def _contracted(i: int, found: Cells, pieces: Pieces, curve: LineBound) -> tuple[Pieces, LineBound]:
    """Pieces without what a curve shows to be negative; ceilings lowered to where it shows to be
    positive."""
    start, end = pieces.inner[:, 0].T
    radius = (end - start) / 2
    positive = _first(curve.bend, curve.slope, curve.middle - curve.rest)
    shown = curve.known & np.isfinite(positive)
    before = found.ceiling.copy()
    at = np.where(
        positive < 1, np.minimum(np.nextafter(start + radius * (1 + positive), np.inf), end), end
    )
    at = np.where(positive > -1, at, start)
    np.minimum.at(found.ceiling, pieces.owner[shown], at[shown])
    found.by[found.ceiling < before] = i
    low, high = _hull(curve.bend, curve.slope, curve.middle + curve.rest)
    inner, known = pieces.inner.copy(), curve.known
    inner[known, 0] = _along(inner[known, 0], low[known], high[known])
    left = ~known | (low <= high)
    return Pieces(pieces.owner[left], inner[left]), curve[left]


def _along(omega: Array, low: Array, high: Array) -> Array:
    """What t from ``low`` to ``high`` is of cells (n, 2), in which t goes from -1 to 1; rounded
    outward, but not out of them."""
    start, end = omega.T
    radius = (end - start) / 2
    first = np.nextafter(start + radius * (1 + low), -np.inf)
    last = np.nextafter(start + radius * (1 + high), np.inf)
    return np.stack([np.maximum(start, first), np.minimum(end, last)], -1)


def zeros(omega: Array, middle: Array, rest: Array, slope: tuple[Array, Array]) -> Array:
    """Where along omega F may vanish, within cells that go from where to where (n, 2): Newton's
    method for intervals, one step.

    For all else in a cell |F - ``middle``| <= ``rest`` in the middle of omega, and dF/dt lies
    between the two of ``slope`` all over it, t from -1 to 1. Nothing is left out where the slope
    may be 0, or is not known.
    """
    with np.errstate(all="ignore"):  # what is not finite is unknown
        reach = rest * (1 + _ROUNDING)
        ends = np.stack([(x - middle) / own for x in (-reach, reach) for own in slope])
        told = (slope[0] * slope[1] > 0) & np.isfinite(ends).all(0)
        low, high = (
            np.clip(ends.min(0) - _ROUNDING, -1.0, 1.0),
            np.clip(ends.max(0) + _ROUNDING, -1.0, 1.0),
        )
        return np.where(told[:, None], _along(omega, low, high), omega)


def _rates(pieces: Pieces, curve: LineBound, outer: Array) -> Array:
    """How much of the change of a function is along each side; of one that is unknown how wide each
    side is."""
    cells = pieces.cells(outer)
    with np.errstate(all="ignore"):
        spread = (cells[..., 1] - cells[..., 0]) / np.maximum(np.abs(cells).max(-1), 1e-300)
        known = np.isfinite(curve.changes).all(-1) & (curve.changes.max(-1, initial=0.0) > 0)
        rates = np.where(known[:, None], curve.changes, spread)
        return np.nan_to_num(rates / rates.sum(-1, keepdims=True))


@dataclass(frozen=True, eq=False)
class SearchResult:
    """All outer cells that there were, in three parts."""

    kept: Cells
    broken: Cells
    left: Cells

    @property
    def parts(self) -> tuple[Cells, Cells, Cells]:
        """All three."""
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
    """Outer cells that fill a domain as they are told: kept, broken, or neither; ``inner`` : the
    pieces of all judges alike.

    ``inner`` : (inner, 2), or (pieces, inner, 2). Else as of ``Search``.
    """
    first = np.asarray(inner, float)
    cells = Cells.of(outer, [first if first.ndim == 3 else first[None]] * len(judges))
    own = Search(judges, cells, wide=wide, last=last, most=most, what=what)
    settled = joined([cells[:0], *own])
    broken = settled.ceiling < np.inf
    return SearchResult(settled[~broken], settled[broken], own.left)
