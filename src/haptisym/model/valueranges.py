"""The range of a parameter's values that a question is about, and the part of it that is searched.

The rule of a parameter allows a set of values; a question without a range is about all of these.
Searched are the values from a millionth to a million times the scene's own, and 0; of times, such
as delays and periods, up to a thousand times it, as a longer one needs more frequencies than a
question is worth. An answer says which values were not searched.
"""

from __future__ import annotations

from collections.abc import Mapping

from sympy import Expr, Integer, S

from haptisym.kernel.errors import SceneError, several
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.sets import Domain
from haptisym.model.parameters import Rule
from haptisym.model.quantities import Dimension, Number
from haptisym.model.scene import Knob

ALLOWED: Mapping[Rule, Domain] = {
    Rule.POSITIVE: Domain(Integer(0), None, holds_low=False, holds_high=False),
    Rule.NONNEGATIVE: Domain(Integer(0), None),
    Rule.ANY: Domain(None, None),
    Rule.FRACTION: Domain(Integer(0), Integer(1), holds_low=False, holds_high=False),
}
"""The values that a rule allows."""

_REACH, _REACH_OF_TIMES = 10**6, 10**3
"""The largest value that is searched, over the scene's own value; an own value of 0 counts as 1 in
SI, a time of 0 as 1 ms."""


def domain(free: Knob, given: tuple[Number, Number] | None) -> Domain:
    """The values of a parameter that its rule allows, within the range that is given; SceneError
    where there is none."""
    allowed = ALLOWED[free.rule]
    if given is None:
        return allowed
    ends = several(free.path, given, "the range has two ends, as (20, 200)")
    if len(ends) != 2:
        raise SceneError(f"{free.path}: a range has two ends, not {len(ends)}")
    start, end = (free.number(x) for x in ends)
    if sign_of_number(end - start) <= 0:
        raise SceneError(f"{free.path}: the range must go up, not from {given[0]} to {given[1]}")
    # Above 0: that end of the rule cuts into the given range. 0: both ends are the same, and the
    # rule says whether it belongs to the domain. Below 0: the given end is inside, and belongs.
    below = -1 if allowed.low is None else sign_of_number(allowed.low - start)
    above = -1 if allowed.high is None else sign_of_number(end - allowed.high)
    is_beyond = (allowed.low is not None and sign_of_number(end - allowed.low) <= 0) or (
        allowed.high is not None and sign_of_number(allowed.high - start) <= 0
    )
    if is_beyond:
        raise SceneError(
            f"{free.path} {free.rule.value}: no value from {given[0]} to {given[1]} does"
        )
    return Domain(
        allowed.low if below > 0 else start,
        allowed.high if above > 0 else end,
        holds_low=allowed.holds_low or below < 0,
        holds_high=allowed.holds_high or above < 0,
    )


def searched(free: Knob, asked: Domain) -> tuple[Expr, Expr]:
    """The lowest and the highest value that are searched: the given ends, or else a multiple of the
    scene's own value, for signed values on both sides of 0.

    0 is examined by itself where a domain begins or ends there: next to it, what holds at the least
    value that is searched is taken to hold.
    """
    # The value of a threshold may be a formula in omega: it counts as 1, as 0 does.
    size = S.One if free.value.free_symbols or not free.value else abs(free.value)
    largest = _REACH * size
    if free.dimension is Dimension.TIME:
        largest = _REACH_OF_TIMES * size if free.value else S.One
    low = -largest if asked.low is None else asked.low
    high = max(largest, _REACH * low) if asked.high is None else asked.high
    if low == 0:
        return min(size, high) / _REACH, high
    return low, -min(size, -low) / _REACH if high == 0 else high
