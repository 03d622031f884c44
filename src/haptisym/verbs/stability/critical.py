"""The critical values of a free parameter q of a display in a hand: those that put roots of the
loop on the imaginary axis, or let them come to it from infinity.

Between two neighbouring critical values the number of roots in Re s >= 0 is the same, so that one
count in each interval decides for which q the loop is stable (``limits`` counts). C(s; q) is the
characteristic function of the loop; what it looks like, and the words *unit delay*, *display* and
*hand*, are in ``loops``.

Begin with ``critical_values``. Which function is used when, tried in this order:

1. ``loops``: C does not depend on q. There is no critical value.
2. ``roots_at_0``: the display is passive and the hand has damping, so that for q > 0 roots can lie
   at s = 0 alone. These values are all; if there are delays, those of step 3 are added.
3. ``neutralchains.from_infinity``: values that let roots come from infinity, added to all that
   follows.
4. ``delayswitches``: q is one delay, C = A + B exp(-s q). All values, up to a bound.
5. ``crossingcurve``: q is in coefficients alone. One equation in omega is left by elimination.
   Where its sign is constant above some frequency, its zeros below that are all critical values.
   Where it changes sign for ever, they are all inside of a window of q that grows
   (``_by_size_of_q``), or, beside chains of roots, inside of each interval that has no chain
   (``neutralchains.BesideChains``).
6. ``cellsearch``: none of these decided. A search over cells of omega and q, in windows that grow.

Steps 4 to 6 cover omega > 0, and roots at s = 0 are added to them. So **every result is complete**:
all critical values are among those returned, but for those in the intervals that are ``open`` in
the result, each with its reason. There is one exception, on which no verdict depends: common
factors of Re C and Im C (``crossingcurve._by_resultant``). UndecidedError where nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

from sympy import Expr, Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.sets import CriticalValue, CriticalValues, Domain, Open
from haptisym.verbs.stability.cellsearch import NOT_TESTED, search
from haptisym.verbs.stability.characteristic import Characteristic
from haptisym.verbs.stability.crossingcurve import CrossingCurve, curve_of
from haptisym.verbs.stability.delayswitches import Switches
from haptisym.verbs.stability.loops import CriticalRoot, Loop, minus
from haptisym.verbs.stability.neutralchains import (
    ENDLESS,
    BesideChains,
    from_infinity,
    intervals_without_chain,
)

# Windows of |q| where roots meet the axis at ever higher frequencies: the last reaches 4^9 times as
# far as the value, and to 4^-10 of it.
_WINDOWS = 12
# The lower ends of the first two windows, as shares of the value; further ones are a quarter of the
# one before.
_FIRST_LOWS = (Rational(15, 16), Rational(1, 2))


def critical_values(loop: Loop, value: Expr, domain: Domain) -> Iterator[CriticalValues]:
    """The critical values of q: all of them at once, or in windows about ``value`` that grow.

    ``domain`` : the values that are asked about; others may be returned too. Each yield replaces
    the one before. UndecidedError where nothing, or nothing more, is known.
    """
    if not loop.depends_on_q:
        yield CriticalValues()
        return
    has_results = False
    try:
        for window in _by_elimination(loop, value):
            yield window
            has_results = True
    except LimitError:
        raise
    except UndecidedError as error:
        # A search may find less than elimination did before it ended: it must not replace that.
        if has_results:
            raise
        yield from search(loop, value, domain, str(error))


def _by_elimination(loop: Loop, value: Expr) -> Iterator[CriticalValues]:
    """The critical values where q can be eliminated from C(j omega; q) = 0; UndecidedError where
    not."""
    if loop.has_roots_at_0_alone and not loop.ring.lags:
        yield CriticalValues(roots_at_0(loop))
        return
    far_roots = from_infinity(loop)
    if loop.has_q_in_exponent:
        yield _of_exponent(loop, value, far_roots)
        return
    # With delays in the highest power of s a chain of roots may lie on the right for all values of
    # an interval: critical values are then looked for in the others, which are ``without_chain``.
    without_chain: list[Open] | None = None
    if any(any(exponents) for exponents in loop.leading):
        # An end of q's range is one more: the delayed terms of L may be lost at that value alone.
        ends = (ExactNumber(x) for x in (loop.low, loop.high) if x is not None)
        far_roots += tuple(CriticalRoot(x) for x in ends)
        intervals = intervals_without_chain(loop, far_roots)
        without_chain = [Open(low, high, ENDLESS) for low, high in intervals]
    roots = (*far_roots, *roots_at_0(loop))
    curve = None if loop.has_roots_at_0_alone else curve_of(loop)
    if curve is None:
        yield CriticalValues(roots)
    elif curve.condition.is_zero:
        # -A/B is one real number: it alone puts roots on the axis, at all omega, as at 1 rad/s.
        q = ValueAt(RealFunction(curve.value.reduced()), ExactNumber(Integer(1)))
        yield CriticalValues((*roots, CriticalRoot(q)))
    else:
        yield from _on_curve(loop, curve, value, roots, without_chain)


def _on_curve(
    loop: Loop,
    curve: CrossingCurve,
    value: Expr,
    roots: Sequence[CriticalRoot],
    without_chain: Sequence[Open] | None,
) -> Iterator[CriticalValues]:
    """The critical values of a curve, with ``roots`` that are known already. ``without_chain`` :
    the intervals that no chain of roots reaches; None where L has no delays, and so no chain."""
    radius = curve.radius
    if radius is not None:
        reach = _reach(radius, loop)
        yield CriticalValues((*roots, *curve.roots(reach)))
    elif without_chain is not None:
        yield from _beside_chains(loop, curve, value, roots, without_chain)
    else:
        yield from _by_size_of_q(loop, curve, value, roots)


def _reach(radius: Expr, loop: Loop) -> Expr:
    """The frequency up to which roots are looked for, at least 1 rad/s and at least ``radius``;
    UndecidedError where the delays have too large a phase there."""
    if loop.has_large_phase(radius):
        raise UndecidedError("where roots meet the imaginary axis: its delays turn very often")
    return max(radius, Integer(1))


def _of_exponent(loop: Loop, value: Expr, far_roots: tuple[CriticalRoot, ...]) -> CriticalValues:
    """The critical values of a q that is a delay, or a power of s."""
    if _has_chain(loop, value):
        # There is a chain at each delay > 0, and none at 0.
        return CriticalValues((*far_roots, CriticalRoot(ExactNumber(Integer(0)))))
    roots = (*far_roots, *roots_at_0(loop))
    if loop.has_roots_at_0_alone:
        return CriticalValues(roots)
    switches, last = Switches.of(loop).up_to(value)
    untested = [] if last is None else [Open(ExactNumber(last), None, NOT_TESTED)]
    return CriticalValues((*roots, *switches), untested)


def _has_chain(loop: Loop, value: Expr) -> bool:
    """Whether a chain of roots lies on the right or comes to the axis at a delay q > 0; False also
    where that is undecided.

    The zeros z = exp(-s q) of L(z) do not depend on q, so that it is so at all q > 0 or at none:
    any one will do where the value is 0 or not rational.
    """
    with suppress(UndecidedError):
        delay = Rational(value) if value.is_Rational and value else Integer(1)
        return loop.roots_at(delay).chain is not None
    return False


def roots_at_0(loop: Loop) -> tuple[CriticalRoot, ...]:
    """The values of q that put a root at s = 0; of a q in a power of s see
    ``Characteristic.at_0``."""
    at_0 = ExactNumber(Integer(0))
    return tuple(CriticalRoot(q, omega=at_0) for q in Characteristic(loop).at_0())


# Where roots meet the axis at ever higher frequencies


def _beside_chains(
    loop: Loop,
    curve: CrossingCurve,
    value: Expr,
    roots: Sequence[CriticalRoot],
    without_chain: Sequence[Open],
) -> Iterator[CriticalValues]:
    """The critical values in one after the other of the intervals that no chain reaches: the one
    with ``value`` first, the others being open until it is their turn."""
    here = ExactNumber(value)
    # False sorts before True.
    open_intervals = sorted(without_chain, key=lambda x: not x.covers(here, here))
    values: Sequence[CriticalValue] = roots
    yield CriticalValues(values, open_intervals)
    beside = BesideChains.of(loop)
    first = open_intervals[0] if open_intervals else None
    if beside is None or (first is not None and first.low is None):
        if first is not None and first.covers(here, here):
            yield from _by_size_of_q(loop, curve, value, roots)
        return
    for interval in [x for x in open_intervals if x.low is not None]:
        assert interval.low is not None
        others = [x for x in open_intervals if x is not interval]
        known = values
        for inside in beside.critical(curve, interval.low, interval.high):
            values = (*known, *inside.values)
            open_intervals = [*others, *inside.open]
            yield CriticalValues(values, open_intervals)


def _by_size_of_q(
    loop: Loop, curve: CrossingCurve, value: Expr, roots: Sequence[CriticalRoot]
) -> Iterator[CriticalValues]:
    """The critical values of a curve whose condition changes sign for ever, in windows of |q| about
    ``value`` that grow.

    If q^2 on the curve is proven to be larger than end^2 above some frequency, then all critical
    values with |q| <= end lie at or below that frequency, where they are found one by one. Likewise
    for q^2 < end^2 and |q| >= end. q^2 has a sign less end^2 at infinity although q itself swings
    with the phase of the delays. UndecidedError where neither is proven for any window.
    """
    reach, low, high = Integer(0), None, None
    for n in range(_WINDOWS):
        size = abs(value)
        largest = size + (1 + size) * Rational(4) ** (n - 2)
        smallest = value * _FIRST_LOWS[min(n, 1)] / 4 ** max(n - 1, 0)
        for end, sign in ((largest, Sense.POSITIVE), (smallest, Sense.NEGATIVE)):
            at_infinity = asymptotic_sign(minus(curve.square, end**2))
            if at_infinity.sense is sign and end > 0:
                reach = max(reach, _reach(at_infinity.radius, loop))
                if sign is Sense.POSITIVE:
                    high = end
                else:
                    low = end
        if high is not None or low is not None:
            # A bound of |q| holds for both signs: values are known from -high to high, or from low
            # upward.
            first = low if high is None else -high
            open_intervals = [Open(None, ExactNumber(first), ENDLESS)]
            if low is None:
                open_intervals.append(Open(ExactNumber(high), None, ENDLESS))
            yield CriticalValues((*roots, *curve.roots(reach)), open_intervals)
    if high is None and low is None:
        raise UndecidedError(ENDLESS)
