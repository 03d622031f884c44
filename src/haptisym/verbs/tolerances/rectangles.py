"""A plane of two numbers in rectangles, cut until each is told, with what stays in doubt of all that stands behind them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from haptisym.kernel.errors import LimitError
from haptisym.programs.taylormodels import Array, halves

_FIRST = 8  # of each range, to begin with


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of the frequencies, and of what else varies, (pieces, 1 + others, 2); ``owner`` : in which rectangle."""

    owner: Array
    rest: Array

    @classmethod
    def all(cls, count: int, first: Array) -> Pieces:
        """The same ones of so many rectangles."""
        return cls(np.repeat(np.arange(count), len(first)), np.tile(first, (count, 1, 1)))

    def where(self, which: Array) -> Pieces:
        """Those that a mask picks."""
        return Pieces(self.owner[which], self.rest[which])

    def cells(self, plane: Array) -> Array:
        """Of frequency, plane and the rest."""
        return np.concatenate([self.rest[:, :1], plane[self.owner], self.rest[:, 1:]], 1)

    def cut(self, which: Array, side: Array) -> Pieces:
        """Some in halves, each along its side."""
        owner = np.concatenate([self.owner[~which], *[self.owner[which]] * 2])
        return Pieces(owner, np.concatenate([self.rest[~which], halves(self.rest[which], side[which])]))

    def within(self, which: Array, count: int) -> Pieces:
        """Those of some of so many rectangles, once for each half of these."""
        number = np.full(count, -1)
        number[which] = np.arange(len(which))
        own = number[self.owner]
        owner, rest = own[own >= 0], self.rest[own >= 0]
        return Pieces(np.concatenate([owner, owner + len(which)]), np.concatenate([rest, rest]))


@dataclass
class RectangleSearch(ABC):
    """Rectangles in shares of both ranges, as they are told; ``left`` are those that are small, or too many."""

    finest: float
    most: int
    left: list[Array] = field(default_factory=list, kw_only=True)
    looked: int = field(default=0, kw_only=True)

    @abstractmethod
    def _round(self, plane: Array, pieces: Sequence[Pieces]) -> tuple[Array, list[Pieces]]:
        """What is left of some rectangles, ``_cut``."""

    def _search(self, first: Sequence[Array]) -> None:
        """Cut until all is told, is small, or too much was looked at; ``first`` : pieces of a rectangle, for each question."""
        steps = np.arange(_FIRST + 1) / _FIRST
        sides = np.stack([steps[:-1], steps[1:]], -1)
        plane = np.array([[a, b] for a in sides for b in sides])
        pieces = [Pieces.all(len(plane), x) for x in first]
        while len(plane):
            try:
                plane, pieces = self._round(plane, pieces)
            except LimitError:
                self.left.append(plane)
                break

    def _cut(
        self, plane: Array, doubtful: Array, changes: Array, pieces: Sequence[Pieces]
    ) -> tuple[Array, list[Pieces]]:
        """Those in doubt in halves, along what changes more, if they may be."""
        widths = plane[..., 1] - plane[..., 0]
        done = self._small(plane) | (self.looked > self.most)
        self.left.append(plane[doubtful & done])
        which = np.flatnonzero(doubtful & ~done)
        side = np.argmax(np.where(widths > self.finest, changes + 1e-300 * widths, -1.0), -1)
        return halves(plane[which], side[which]), [x.within(which, len(plane)) for x in pieces]

    def _small(self, plane: Array) -> Array:
        """Those that are cut no further."""
        return (plane[..., 1] - plane[..., 0] <= self.finest).all(-1)
