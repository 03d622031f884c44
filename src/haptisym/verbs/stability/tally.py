"""How many roots shake at one value after another: counted once, and from there on by those that come and go.

Those in Re s >= 0 but for what drifts, as nothing holds the handle in place.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from sympy import Expr, Integer, Rational

from haptisym.kernel.alike import ordered
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain
from haptisym.verbs.stability.loops import Gap, Loop, Meetings


@dataclass
class Tally:
    """Of a loop and its open number; ``window`` : where that is known to put roots on the axis. None: nowhere.

    ``known`` : the numbers that were counted, by value. ``drifts`` : of a value, how many
    roots at 0 are not counted, as they only drift.
    """

    loop: Loop
    window: Meetings | None = None
    known: dict[Expr, int] = field(default_factory=dict)
    drifts: Callable[[Expr], int | None] = lambda _: 0

    def at(self, value: Expr) -> tuple[int | None, RootChain | None]:
        """The number of roots, None if they are infinitely many, or as near to the axis as one likes; and their chain."""
        if (found := self._from_another(value)) is not None:
            return found, None
        roots = self.loop.at(Rational(value))
        number = roots.number
        if number and roots.on_axis and not ordered(roots.on_axis[0], ExactNumber(Integer(0))):
            number -= _decided(self.drifts(value))
        if number is not None and roots.chain is None:
            self.known[value] = number
        return number, roots.chain

    def _from_another(self, value: Expr) -> int | None:
        """From the nearest value that was counted, where all that moves over the axis on the way there is known."""
        if value in self.known or not self.known or self.window is None or not self._is_inside(value, self.window):
            return self.known.get(value)
        nearest = min(self.known, key=lambda x: abs(x - value))
        low, high = (ExactNumber(x) for x in sorted((nearest, value)))
        if not self._is_inside(nearest, self.window) or any(_meets(gap, low, high) for gap in self.window.gaps):
            return None
        between = [x for x in self.window.found if ordered(low, x.value) >= 0 and ordered(x.value, high) >= 0]
        senses = [x.sense for x in between if x.sense is not None]
        if len(senses) < len(between) or any(not ordered(x.value, end) for x in between for end in (low, high)):
            return None
        return self.known[nearest] + (1 if value > nearest else -1) * 2 * sum(senses)

    @staticmethod
    def _is_inside(value: Expr, window: Meetings) -> bool:
        """Whether all that puts roots on the axis is known about there."""
        above, below = window.above, window.below
        return (above is None or value > above) and (below is None or value < below)


def _decided(drifts: int | None) -> int:
    if drifts is None:
        raise UndecidedError("how many roots at 0 only drift")
    return drifts


def _meets(gap: Gap, low: ExactNumber, high: ExactNumber) -> bool:
    before = gap.high is not None and ordered(gap.high, low) >= 0
    return not before and not (gap.low is not None and ordered(high, gap.low) >= 0)
