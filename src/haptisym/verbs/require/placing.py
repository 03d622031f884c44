"""Where the slices of a map go: few to begin with, more where the boundary bends, or where its kind changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

from sympy import Expr

from haptisym.kernel.budget import Budget, spared
from haptisym.verbs.require.slices import Slice, gaps

_FIRST = 9
"""Slices to begin with: what lies between two of them and shows on none is not seen."""
_WORST = 8
"""Gaps that are so many times better than the worst one wait: with more slices they may prove to be good."""


def even(low: Expr, high: Expr, count: int) -> list[Expr]:
    """That many places, as far from each other."""
    return [low + (high - low) * i / (count - 1) for i in range(count)]


def first_places(low: Expr, high: Expr, most: int) -> list[Expr]:
    """The places to begin with."""
    return even(low, high, min(_FIRST, most))


def refined(
    found: list[Slice],
    cut: Callable[[Expr, int], Slice],
    budget: Budget,
    most: int,
    size: tuple[float, float],
    share: float,
) -> list[Slice]:
    """More slices, halfway between two, until lines between them are off by no more than a share of the range, as estimated.

    Slices that differ in kind are to be no further from each other than that share of the first range. ``size`` : of both
    ranges. It ends at ``most`` slices, and where the time is over.
    """
    while len(found) < most and not budget.reached:
        with spared():
            worst = _worst(found, size, share)[: most - len(found)]
        if not worst:
            break
        more = list[Slice]()
        for i in worst:
            more.append(cut((found[i].at + found[i + 1].at) / 2, len(found) + len(more)))
            if budget.reached:  # what could be told apart is
                break
        found = sorted([*found, *more], key=lambda x: x.place)
    return found


def _worst(found: Sequence[Slice], size: tuple[float, float], share: float) -> list[int]:
    """The gaps that are worth a slice, the worst first."""
    scores = [
        (gap.high - gap.low) / size[0] if gap.deviation is None else gap.deviation / size[1] for gap in gaps(found)
    ]
    for i, (a, b) in enumerate(pairwise(found)):
        if None in (*a.ends, *b.ends):
            scores[i] = 0.0  # another slice would stay undecided too
    limit = max(share, max(scores, default=0.0) / _WORST)
    return sorted((i for i, x in enumerate(scores) if x > share and x >= limit), key=lambda i: -scores[i])
