"""Sets of values of one parameter for which something holds, with what binds at each end: values only."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import groupby

from haptisym.judge.crossings import Criterion, Judged
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import RealNumber


class Kind(Enum):
    """Where on the band a condition binds."""

    EDGE = "band-edge"
    """At the band's high end."""
    START = "start"
    """At the band's low end."""
    TOUCH = "tangency"
    """Inside: a ratio touches its threshold there."""
    AXIS = "axis"
    """Roots of a display in a hand lie on the imaginary axis."""
    FAR = "far-out"
    """At frequencies without bound: a root comes from infinity, or a condition fails there first."""


@dataclass(frozen=True)
class Binding(Judged):
    """A condition that holds with equality at the end of a set: which one, where on the band, rad/s.

    ``omega``: None where the frequency of a degenerate touch was not isolated.
    """

    criterion: Criterion
    omega: RealNumber | None
    kind: Kind


@dataclass(frozen=True)
class End:
    """An end of an interval of values; ``bindings``: what binds there, empty where the range that was asked about ends."""

    value: RealNumber | None
    closed: bool = False
    bindings: tuple[Binding, ...] = ()


@dataclass(frozen=True, repr=False)
class Span(Shown):
    """An interval of values of the parameter: a single value if both ends are the same."""

    low: End
    high: End

    def _line(self) -> str:
        return spanned(self)


@dataclass(frozen=True)
class Solved:
    """The values for which conditions hold, and those about which nothing was proven, in time or for a ``reason``."""

    feasible: tuple[Span, ...]
    undecided: tuple[tuple[RealNumber | None, RealNumber | None], ...] = ()
    reason: str = ""


def bound_ends(spans: Iterable[Span]) -> tuple[End, ...]:
    """The ends at which a condition binds, in order."""
    listed = (end for span in spans for end in dict.fromkeys((span.low, span.high)))
    return tuple(end for end in listed if end.bindings)


def spanned(span: Span) -> str:
    """``from 122.356 on``, ``0 to 3.5``, ``7``, ``any``."""
    low, high = (None if x.value is None else x.value.digits(6) for x in (span.low, span.high))
    if low is None or high is None:
        return "any" if low == high else f"up to {high}" if low is None else f"from {low} on"
    return low if span.low.value == span.high.value else f"{low} to {high}"


def runs(at: Sequence[bool], between: Sequence[bool]) -> list[tuple[int, int, bool, bool]]:
    """The longest runs of a set along a line of points, given whether it holds each point and each gap between two.

    Each run: the numbers of its first and last point, and whether these belong to it.

    >>> runs([False, True, False, True], [True, True, False])
    [(0, 2, False, False), (3, 3, True, True)]
    """
    line = [x for pair in zip(at, [*between, False], strict=True) for x in pair][:-1]
    found = []
    for inside, group in groupby(range(len(line)), key=lambda i: line[i]):
        places = list(group)
        if inside:
            first, last = places[0], places[-1]
            found.append((first // 2, (last + 1) // 2, first % 2 == 0, last % 2 == 0))
    return found
