"""What is said of a box of values: a verdict on the whole of it, and where its crossings lie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from sympy import Expr

from haptisym.judge.criteria import Criterion, Judged
from haptisym.kernel.reals import RealNumber


class Verdict(Enum):
    """Whether the display is transparent on the whole band."""

    ALL = "all"
    NONE = "none"
    DEPENDS = "depends"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Enclosure(Judged):
    """Where crossings of a criterion lie: between ``low`` and ``high``, rad/s, whatever the values; guaranteed.

    ``count`` : how many there are for every set of values; None if that depends or is not known. ``at_low``, ``at_high``: the
    corner of the box at which the end is reached, which then is exact; None for an end that is a bound only, at most
    ``TOLERANCE`` or what the budget allowed beyond. ``monotonic``: for each parameter 1 if the crossing grows with it
    throughout the box, -1 if it falls, 0 if neither is proven.
    """

    criterion: Criterion
    low: RealNumber
    high: RealNumber
    count: int | None
    at_low: Mapping[str, Expr] | None
    at_high: Mapping[str, Expr] | None
    monotonic: Mapping[str, int]
