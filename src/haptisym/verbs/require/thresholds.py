"""For which thresholds a display is transparent: from the largest value of its ratio on, exact, whatever the environment.

The condition r <= c on the whole band holds for c at least as large as the supremum of r there. That is the value at an end of
the band or at one of its local maxima, which are certified zeros of the slope: no value of c needs to be tried.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import flint
from sympy import Expr

from haptisym.judge.criteria import Criterion
from haptisym.judge.peaks import Largest, Top, tops
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.lattices import Signed
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart
from haptisym.verbs.require.feasible import Binding, End, Kind, Span
from haptisym.verbs.require.freeparameter import Domain

_TOLD_APART = (64, 256, 1024)
"""Bits with which the values of two local maxima are compared; what is alike to the last of them binds with the other."""


@dataclass(frozen=True)
class ThresholdProblem:
    """Squared ratios that one threshold judges on a band; ``kept``: what must not be positive besides, as it is."""

    squares: Mapping[Criterion, RealFunction]
    kept: Mapping[Criterion, Signed]
    band: tuple[Expr, Expr]
    domain: Domain

    def solve(self) -> tuple[Span, ...]:
        """All thresholds of the domain with which every ratio is kept on the whole band: one interval, or none."""
        low, high = self.domain.low, self.domain.high
        assert low is not None
        if self._exceeds(self.kept):
            return ()
        if high is not None and self._exceeds(self._excess(high)):
            return ()
        top = End(None if high is None else ExactNumber(high), self.domain.holds_high and high is not None)
        if not self._exceeds(self._excess(low)):
            return (Span(End(ExactNumber(low), self.domain.holds_low), top),)
        found = self._tops()
        if found is None:
            return ()
        bottom = End(SquareRoot(Largest(tuple(x.value for _, x in found))), closed=True, bindings=_bindings(found))
        if high is not None and self._touches(high):
            return (Span(bottom, bottom),) if self.domain.holds_high else ()
        return (Span(bottom, top),)

    def _excess(self, limit: Expr) -> dict[Criterion, Signed]:
        return {x: replace(x, threshold=limit).exceeded(square) for x, square in self.squares.items()}

    def _exceeds(self, conditions: Mapping[Criterion, Signed]) -> bool:
        table = chart(conditions, *self.band)
        exceeds = bool(table.where(lambda signs: any(sign > 0 for sign in signs.values())))
        if not exceeds and table.undecided:
            raise UndecidedError("whether a ratio that touches an end of the range goes beyond it")
        return exceeds

    def _touches(self, limit: Expr) -> bool:
        """Whether a ratio that does not exceed a limit meets it."""
        excess = self._excess(limit)
        if any(isinstance(x, RealFunction) and x.is_zero for x in excess.values()):
            return True  # at every frequency
        table = chart(excess, *self.band)
        return any(n > 0 for point in table.points for n in point.orders.values())

    def _tops(self) -> list[tuple[Criterion, Top]] | None:
        """The places at which the largest ratio is reached; None where one has no bound."""
        found: list[tuple[Criterion, Top]] = []
        for criterion, square in self.squares.items():
            own = tops(square, *self.band)
            if own is None:
                return None
            found += [(criterion, x) for x in own]
        for bits in _TOLD_APART:
            with flint.ctx.workprec(bits):
                balls = [x.value.ball(bits) for _, x in found]
                most = Largest(tuple(x.value for _, x in found)).ball(bits)
                found = [x for x, ball in zip(found, balls, strict=True) if not ball < most]
        return found


def _bindings(found: list[tuple[Criterion, Top]]) -> tuple[Binding, ...]:
    return tuple(Binding(criterion, x.omega, _KINDS[x.end]) for criterion, x in found)


_KINDS = {None: Kind.TOUCH, False: Kind.START, True: Kind.EDGE}
