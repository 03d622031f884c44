"""All bandwidths of a scene whose threshold is only known as a range: an interval, less the jumps at peaks of the ratios.

The bandwidth as a function of c is the generalised inverse of the running maximum of the ratio r: it grows with c, and
jumps where c reaches a peak that is higher than all before it. So a range of c maps exactly onto a set of bandwidths, without
sampling.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from itertools import product

from sympy import Expr, S

from haptisym.judge.climb import Bandwidths, Climb, Jump
from haptisym.judge.criteria import Criterion, kept, noticed
from haptisym.judge.families import SCALE, moved, nominal_of, split
from haptisym.judge.growth import Growth, bandwidth_of
from haptisym.judge.landings import above
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, Threshold
from haptisym.model.parameters import ExactRange


def bandwidths(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> Bandwidths | None:
    """The bandwidths for all thresholds of a range; None where the threshold is no range.

    Thresholds of both parts that are alike are one number, as everywhere; else each takes all values of its range. The ends are
    exact in any case. Undecided may stay whether two peaks are equally high, and whether a ratio touches an end of the range.
    """
    if not threshold.ranges:
        return None
    least: RealNumber | None = None
    most: RealNumber | None = None
    try:
        least, most = (_at(d, threshold.at_end(i), band) for i in (0, 1))
        if threshold.is_box:
            ranges = {part: threshold.interval(part) or (threshold[part], threshold[part]) for part in Part}
            found = _inside(_squares(d, threshold), ranges, band)
        else:
            found = _grown(d, threshold, band, Bandwidths(least, most, ends_alone=True))
        return replace(found, least=least or found.least, most=most)
    except LimitError:
        raise
    except UndecidedError as error:
        return Bandwidths(least, most, undecided=str(error))


def _at(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> RealNumber | None:
    """The bandwidth for one threshold."""
    table = chart({x: x.function(d) for x in noticed(threshold)}, *band)
    if table.undecided:
        raise UndecidedError("whether a ratio touches an end of the range of thresholds")
    first = next(iter(kept(table)), None)
    return first.high.omega if first and first.low is table.points[0] else None


def _squares(d: Distortion, threshold: Threshold) -> dict[Criterion, RealFunction]:
    """What must not exceed the square of a threshold; of a region, how many times one of half widths 1 must be enlarged."""
    criteria = noticed(threshold)
    if not any(x.joint for x in criteria):
        return {x: x.measure(d) for x in criteria}
    [x] = criteria
    assert x.joint
    squares = x.joint.opened(dict.fromkeys(Part, S.One)).squares(d)
    return {replace(x, name=f"{x.name} {i}", region=None): square for i, square in enumerate(squares)}


def _inside(
    squares: Mapping[Criterion, RealFunction], ranges: Mapping[Part, ExactRange], band: tuple[Expr, Expr]
) -> Bandwidths:
    if ranges[Part.REAL] == ranges[Part.IMAG]:
        return replace(Climb(squares, ranges[Part.REAL], band, "jnd").found, one=True)
    each = [Climb({x: square}, ranges[x.part], band, x.name).found for x, square in squares.items() if x.part]
    return reduce(_lower, each)


def _grown(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr], ends: Bandwidths) -> Bandwidths:
    """Those of a region that grows with several numbers: all of them where no way to be outside depends on two, else the ends."""
    groups = split(d, threshold)
    if groups is None or ends.most is None:
        return ends
    ranges, criterion = moved(threshold), noticed(threshold)[0]
    each = []
    for group, terms in groups.items():
        if group:
            name = min(group) if len(group) == 1 else "jnd"
            each.append(Growth(terms, ranges[group], band, criterion, name, nominal_of(threshold, min(group))).found)
        else:
            width = bandwidth_of(Lattice(tuple(x.where for x in terms)), band)
            each.append(Bandwidths(width, width))
    return replace(reduce(_lower, each), one=groups.keys() == {SCALE})


def _lower(a: Bandwidths, b: Bandwidths) -> Bandwidths:
    """All smaller ones of two bandwidths, each of a set of its own."""
    if a.most is None or b.most is None or a.least is None or b.least is None:
        return Bandwidths(None, None)
    least, most = _least(a.least, b.least), _least(a.most, b.most)
    pairs = product(_unreached(a, least), _unreached(b, least))
    jumps = [x for one, other in pairs if (x := _common(one, other, most)) is not None]
    return Bandwidths(least, most, tuple(jumps), {**a.blocked, **b.blocked})


def _unreached(x: Bandwidths, least: RealNumber) -> list[Jump]:
    """What a set leaves out between the least of both and its own most."""
    assert x.least is not None
    return [*([] if x.least is least else [Jump(least, x.least)]), *x.jumps]


def _common(a: Jump, b: Jump, most: RealNumber) -> Jump | None:
    low = b.low if a.low is not b.low and above(b.low, a.low) else a.low
    high = _least(_least(a.high, b.high), most)
    reached = any(x.includes_low for x in (a, b) if low is x.low)  # by one set: then by the smaller of both
    return Jump(low, high, includes_low=reached) if low is not high and above(high, low) else None


def _least(a: RealNumber, b: RealNumber) -> RealNumber:
    return a if a is b or above(b, a) else b
