"""Single sets of values of a box, each answered with certainty; some are drawn at random."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from random import Random
from typing import TypeVar

from sympy import Expr

from haptisym.judge.criteria import kept, noticed
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import chart
from haptisym.verbs.tolerances.box import Box


@dataclass(frozen=True)
class One:
    """One set of values, certified: the crossings by the names of criteria, without touches; whether it is transparent."""

    values: Mapping[str, Expr]
    crossings: Mapping[str, tuple[RealNumber, ...]]
    bandwidth: RealNumber | None
    transparent: bool | None

    @property
    def first(self) -> RealNumber | None:
        """The lowest crossing of any."""
        return min((x[0] for x in self.crossings.values() if x), key=float, default=None)


def drawn(box: Box, samples: int, seed: int) -> tuple[One, ...]:
    """Sets of values drawn uniformly from the box, each answered with certainty."""
    draw = Random(seed)
    shares = ({side.name: Fraction(draw.getrandbits(24), (1 << 24) - 1) for side in box.sides} for _ in range(samples))
    return tuple(in_time(_told(one(box, box.values(x)), n, samples) for n, x in enumerate(shares)))


def _told(found: One, n: int, samples: int) -> One:
    tick(n, samples, "sets of values")
    return found


_T = TypeVar("_T")


def in_time(found: Iterable[_T]) -> Iterator[_T]:
    """What is found before the time is over."""
    try:
        yield from found
    except LimitError:
        return


def one(box: Box, values: Mapping[str, Expr]) -> One:
    """What one set of values out of the box gives."""
    scene = box.scene.with_values(values)
    d = scene.distortion()
    criteria = noticed(scene.threshold)
    table = chart({x: x.function(d) for x in criteria}, *scene.band)
    crossings = {x.name: tuple(p.omega for p in table.points if _crosses(p.orders.get(x, 0))) for x in criteria}
    intervals = kept(table)
    first = intervals[0] if intervals and intervals[0].low is table.points[0] else None
    whole = first is not None and first.high is table.points[-1]
    shown = values or {side.name: box.scene.knobs[side.name].value for side in box.sides}
    return One(shown, crossings, first.high.omega if first else None, None if table.undecided else whole)


def _crosses(order: int) -> bool:
    """Whether a zero of this order, not a pole, changes the sign."""
    return order > 0 and order % 2 == 1
