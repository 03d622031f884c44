"""Values of a free parameter q at which roots of a loop come from infinity, one by one or as a
chain of infinitely many; and the critical values next to such a chain.

C(s; q) is the characteristic function of the loop (``loops``). For large s it is s^n L(z; q) and
terms of lower order, n being its highest power of s, and L the coefficient of that power, a
polynomial in the products z of unit delays exp(-s lag).

- *L without delays* (retarded type): one root or some come from infinity where L(q) = 0.
- *L with delays* (neutral type): each zero z of L is the limit of a chain of infinitely many roots,
  with Re s near -log|z|/lag (Bellman and Cooke, Differential-Difference Equations, 1963, chapter
  12). A chain comes to the imaginary axis where L has a zero with |z| = 1, and then lies to the
  right for all values of an interval.

Three steps, in this order: ``from_infinity`` returns all values at which either happens.
``intervals_without_chain`` returns the intervals between these in which no chain lies on the right
or at the axis. ``BesideChains`` finds the critical values inside of one such interval, though roots
meet the axis at ever higher frequencies near its ends; what it cannot bound it returns as open.

A *row* is the list of coefficients of a polynomial in q, by ascending powers. *Exponents* are those
n_k of the unit delays in a product of them, z = product of exp(-s lag_k)^n_k; ``Loop.leading`` has
the row of each product in L by its exponents, all 0 for the term without delay.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby, pairwise, product, zip_longest
from typing import NamedTuple, TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer, Matrix, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, expression_ball, rational_between
from haptisym.kernel.rootcount import Row, positive_bound, single_delay, squares
from haptisym.kernel.roots import each_once, sign_of_number
from haptisym.kernel.sets import CriticalValues, Open
from haptisym.verbs.stability.crossingcurve import CrossingCurve
from haptisym.verbs.stability.loops import (
    CriticalRoot,
    Exponents,
    Loop,
    balls,
    horner,
    is_between,
    zeros,
)

ENDLESS = "where roots meet the imaginary axis at ever higher frequencies"
"""The reason of an open interval, and of an UndecidedError, where no highest frequency is known."""

# Delayed terms of L at most: each doubles the choices of signs that are tried, here up to 32.
_MOST_DELAYED = 5
# Cuts of an interval that has no upper end are at 1, or at numbers that double: 40 of them reach
# 10^12.
_FIRST_CUT = Integer(1)
# Phases of the delay, rad, at the frequency up to which roots are looked for beside a chain: first
# the nearer one, with few roots, then one with three times as many.
_PHASES = 40, 120
# How often an interval of q beside a chain is cut in two: parts next to its ends may be as short as
# 2^-40 of it.
_MOST_CUTS = 40
# Frequencies that are tried for a bound: _STEPS of them, from the highest one over _SPAN on, each
# _RATIO times the one before. The last is 1.25^31/1024 = 0.99 of the highest.
_STEPS, _RATIO, _SPAN = 32, Rational(5, 4), 1024
# Working precision of such a bound, bits.
_BITS = 192

_Interval: TypeAlias = tuple[RealNumber | None, RealNumber | None]
"""Two ends; None where there is none on that side."""


class _Part(NamedTuple):
    """An interval of q, to a ``high`` end of None if it has no end, and a ``bound``: a frequency,
    rad/s, above which no q in it puts a root on the axis; None where no such one was found."""

    low: RealNumber
    high: RealNumber | None
    bound: Rational | None


def from_infinity(loop: Loop) -> tuple[CriticalRoot, ...]:
    """All values of q at which a root or a chain of roots comes from infinity to the axis, and
    perhaps others.

    L = a + sum of d_i z_i, with real a and d_i, each z_i a product of unit delays. Let their phases
    take all values together as omega grows. Then L has a zero with |z_i| = 1 for all i exactly
    where none of |a|, |d_i| is larger than the sum of all others (they close as the sides of a
    polygon). So such zeros begin or end at values of q at which one is equal to that sum, which are
    zeros of a + sum of +-d_i for some choice of signs.

    The phases take all values together if the exponents of the z_i and the unit delays are linearly
    independent over the rational numbers (Kronecker's theorem). The first is tested: UndecidedError
    where it is not so. The second is not, as of 1, 2^(1/2) and 1 + 2^(1/2) s, or of delays that are
    large multiples of one time, which a ring keeps apart (``kernel.dynamics``). Without it L
    may have no zero with |z_i| = 1 where the sides close, but it still has none where they do not.
    So the values are right where |a| > sum of |d_i|; elsewhere more may be returned than there are,
    and ``Loop.roots_at`` decides nothing: it counts with several delays in L only where |a| is
    larger (``kernel.rootcount``).

    UndecidedError also where there are too many delayed terms, or where q is in one of several
    lags.
    """
    leading = loop.leading
    delayed = [exponents for exponents in leading if any(exponents)]
    units = {i for exponents in delayed for i, n in enumerate(exponents) if n}
    lags = [loop.ring.lags[i] for i in units]
    if len(lags) > 1 and any(loop.symbol in lag.free_symbols for lag in lags):
        raise UndecidedError(
            "where a chain of roots comes to the axis: its delays are no multiples of one"
        )
    # Where no coefficient of L holds q, its zeros z are the same for all q, also if q is the one
    # delay in L, z = exp(-s q).
    holds_q = any(c for row in leading.values() for c in row[1:])
    if not holds_q:
        return ()
    if _is_product(leading):
        first = next(iter(leading.values()))
        return tuple(CriticalRoot(q) for q in zeros(first))
    if len(delayed) > _MOST_DELAYED or Matrix(delayed).rank() < len(delayed):
        raise UndecidedError(
            "where a chain of roots comes to the axis: several delays are in the highest power of s"
        )
    undelayed = leading.get((0,) * len(loop.ring.lags), [Integer(0)])
    values = list[RealNumber]()
    for signs in product((1, -1), repeat=len(delayed)):
        rows = [undelayed]
        for sign, exponents in zip(signs, delayed, strict=True):
            rows.append([sign * c for c in leading[exponents]])
        # A sum that is 0 for all q has no end, and ``zeros`` none of it: sides are equal to the sum
        # of the others until a d_i changes its sign, and there the sum with -d_i is 0 too.
        values += zeros(_sum(rows))
    return tuple(CriticalRoot(q) for q in values)


def _is_product(leading: Mapping[Exponents, Row]) -> bool:
    """Whether L = c(q) A(z): the zeros z are the same for all q, and all are lost where c(q) =
    0."""
    first, *others = leading.values()
    # All rows are multiples of the first where all minors of two rows and two columns are 0.
    columns = list(combinations(range(len(first)), 2))
    minors = (first[i] * row[k] - first[k] * row[i] for row in others for i, k in columns)
    return not any(sign_of_number(x) for x in minors)


def _sum(rows: Sequence[Row]) -> Row:
    """The row of a sum of polynomials."""
    columns = zip_longest(*rows, fillvalue=Integer(0))
    return [sum(column, Integer(0)) for column in columns]


def intervals_without_chain(loop: Loop, far_roots: Sequence[CriticalRoot]) -> list[_Interval]:
    """The intervals of q, between neighbours among ``far_roots`` and the ends of q's range, in
    which no chain of roots lies on the right or at the axis.

    A chain passes the axis at one of these values alone, so that one count in each interval
    decides. UndecidedError where one is undecided.
    """
    low = None if loop.low is None else ExactNumber(loop.low)
    high = None if loop.high is None else ExactNumber(loop.high)
    inside = [x.value for x in far_roots if is_between(x.value, low, high)]
    ends = [low, *each_once(inside, lambda x: x), high]
    intervals = list[_Interval]()
    for interval in pairwise(ends):
        value = loop.value_between(*interval)
        if loop.roots_at(value).chain is None:
            intervals.append(interval)
    return intervals


@dataclass(frozen=True)
class BesideChains:
    """C = A + B exp(-s tau), of neutral type, for q in an interval at the ends of which a chain of
    roots comes to the axis.

    As q nears such an end, roots meet the axis at ever higher frequencies. But none does above a
    frequency from which on P = |A|^2 - |B|^2 > 0 at s = j omega, as on the axis C = 0 needs |A| =
    |B|. P is a polynomial in omega^2. At the end itself its leading coefficient is 0, and the
    further ones may prove that P > 0 all the same.

    ``rows`` : the coefficients of P by falling powers of omega^2, rows of one length.
    ``lag`` : tau, s.
    """

    rows: Sequence[Row]
    lag: Expr

    @classmethod
    def of(cls, loop: Loop) -> BesideChains | None:
        """The loop in this form; None where it has several delays or fractional powers of s, or
        where the highest power has no undelayed coefficient."""
        delayed = {x for group in loop.table.values() for x in group if any(x)}
        exponents = single_delay(delayed, [*loop.table])
        undelayed = (0,) * len(loop.ring.lags)
        if exponents is None or undelayed not in loop.leading:
            return None
        return cls(squares(loop.table, exponents), loop.lag(exponents))

    def critical(
        self, curve: CrossingCurve, low: RealNumber, high: RealNumber | None
    ) -> Iterator[CriticalValues]:
        """All critical values between two ends (``high`` None: no end), but for intervals that are
        ``open`` as no highest frequency was found for them.

        ``curve`` : of the same loop. Each yield replaces the one before and has no larger open
        intervals.
        """
        for phase in _PHASES:
            highest = Rational(phase) / Rational(str(float(self.lag)))
            parts = [*self._parts(low, high, highest, _MOST_CUTS)]
            bounds = [part.bound for part in parts if part.bound is not None]
            open_intervals = [*_open_runs(parts)]
            roots = curve.roots(max(bounds)) if bounds else ()
            yield CriticalValues(roots, open_intervals)
            if not open_intervals:
                return

    def _parts(
        self, low: RealNumber, high: RealNumber | None, highest: Rational, cuts: int
    ) -> Iterator[_Part]:
        """Parts that fill an interval, in ascending order, each with its bound; the interval is cut
        in two, up to that many times, where it has none as a whole."""
        bound = self._bound(low, high, highest)
        between = rational_between(low, high)
        if high is None:
            between = 2 * between if between > 0 else _FIRST_CUT
        middle = ExactNumber(between)
        # An interval of which no single value has a bound will have none in its parts either.
        values = [x for x in (low, middle, high) if x is not None]
        is_last = bound is not None or not cuts
        if is_last or not any(self._bound(x, x, highest) for x in values):
            yield _Part(low, high, bound)
            return
        yield from self._parts(low, middle, highest, cuts - 1)
        yield from self._parts(middle, high, highest, cuts - 1)

    def _bound(
        self, low: RealNumber, high: RealNumber | None, highest: Rational
    ) -> Rational | None:
        """A frequency of at most ``highest``, rad/s, above which P > 0 for all q between two ends
        (or at one q, if both are the same); None where none is proven.

        The coefficients of P for all of these q are in balls, and the leading one is not negative,
        as no chain is on the right. So where the lower bound of ``positive_bound`` is positive it
        is so at all higher frequencies, and bisection finds the least one that is tried.
        """
        with flint.ctx.workprec(_BITS):
            rows, start = self.rows, low.ball(_BITS)
            if high is not None:
                q = start.union(high.ball(_BITS))
            elif start > 0:
                # Without an upper end P is taken over its highest power q^n > 0, as a polynomial in
                # 1/q: as all rows have n + 1 entries, each is read backwards.
                rows = [row[::-1] for row in rows]
                q = (1 / start).union(arb(0))
            else:
                return None
            lower_bound = positive_bound([horner(balls(row), q)[0] for row in rows])
            least = expression_ball(highest) / _SPAN
            ratio = expression_ball(_RATIO)

            def is_positive(step: int) -> bool:
                omega = least * ratio**step
                return bool(lower_bound(omega**-2) > 0)

            # False for all steps below the first that is True: bisected as 0 ... 0 1 ... 1.
            step = bisect_left(range(_STEPS), 1, key=is_positive)
        return None if step == _STEPS else highest / _SPAN * _RATIO**step


def _open_runs(parts: Sequence[_Part]) -> Iterator[Open]:
    """The parts without a bound, neighbours as one open interval."""
    for is_open, run in groupby(parts, lambda part: part.bound is None):
        if is_open:
            neighbours = [*run]
            yield Open(neighbours[0].low, neighbours[-1].high, ENDLESS)
