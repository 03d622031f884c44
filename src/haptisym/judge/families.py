"""JND regions that grow together with one number: how large that number must be so that a change is not noticed.

A change is outside at frequencies at which all ``where`` of a term are positive, as soon as all its squares exceed the square
of the number, relative to its nominal value. What of a term does not depend on the number belongs to its ``where``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias

from sympy import Expr

from haptisym.judge.criteria import Criterion, noticed
from haptisym.judge.regions import Change, Term
from haptisym.kernel.response import RealFunction
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import ExactRange

Group: TypeAlias = frozenset[str]
"""Numbers of a JND, by name, that grow together; empty: none of a term does."""

SCALE: Group = frozenset({"scale"})


def moved(threshold: Threshold) -> dict[Group, ExactRange]:
    """What moves apart, with the range of its size relative to the nominal one."""
    alike = threshold.real == threshold.imag and threshold.region.lower == (None, None)
    found: dict[Group, ExactRange] = {}
    for name, (low, high) in threshold.ranges.items():
        nominal = nominal_of(threshold, name)
        found[frozenset({name})] = low / nominal, high / nominal
    real, imag = frozenset({"real"}), frozenset({"imag"})
    if alike and real in found and found[real] == found.get(imag):
        own = found.pop(real)
        del found[imag]
        found[real | imag] = own
    return found


def nominal_of(threshold: Threshold, name: str) -> Expr:
    """The nominal value of what has a range."""
    named = {
        "scale": threshold.region.size,
        "real": threshold.real,
        "imag": threshold.imag,
        "floor": threshold.region.floor,
    }
    named |= dict(zip(("real.lower", "imag.lower"), threshold.region.lower, strict=True))
    found = named[name]
    assert found is not None
    return found


def split(d: Distortion, threshold: Threshold) -> dict[Group, tuple[Term, ...]] | None:
    """The terms by what moves them; None where one is moved by two ranges, or a region of several parts by one of its numbers."""
    groups = moved(threshold)
    if groups.keys() == {SCALE}:
        return {SCALE: tuple(t for x in noticed(threshold) for t in _scaled(d, threshold, x))}
    if threshold.region.shape is not Shape.SQUARE:
        return None
    found: dict[Group, list[Term]] = {}
    for part in Part:
        for where, limits in _sides(d, threshold, part):
            own = [group for group in groups if not group.isdisjoint(limits)]
            if len(own) > 1:
                return None
            group = own[0] if own else Group()
            squares = tuple(square for name, square in limits.items() if name in group)
            fixed = tuple(above_one(square) for name, square in limits.items() if name not in group)
            found.setdefault(group, []).append(Term((*where, *fixed), squares))
    return {group: tuple(terms) for group, terms in found.items()}


def _scaled(d: Distortion, threshold: Threshold, x: Criterion) -> Iterator[Term]:
    if x.part is None:
        assert x.region
        yield from x.region.terms(d)
        return
    for where, limits in _sides(d, threshold, x.part):
        yield Term(where, tuple(limits.values()))


def _sides(
    d: Distortion, threshold: Threshold, part: Part
) -> Iterator[tuple[tuple[RealFunction, ...], Mapping[str, RealFunction]]]:
    """Of one part, each way in which it changes: where it does, and the square of the change in each limit, by its name.

    Where a part is exactly as large as it was, at single frequencies, nothing is said: what is noticed is so beside it.
    """
    w = Change(d)
    square = w.part(part) * w.part(part)
    own, lower, floor = threshold[part], threshold.lower(part), threshold.region.floor
    least = {} if floor is None else {"floor": RealFunction((square / w.number(floor) ** 2).reduced())}

    def within(name: str, limit: Expr) -> dict[str, RealFunction]:
        return {name: w.over(square / w.number(limit) ** 2), **least}

    if lower is None:
        yield (), within(part.value, own)
        return
    env, perc = (part_of(x, part).function for x in (d.env_response, d.perc_response))
    growth = RealFunction((perc * perc - env * env).reduced())
    if growth.is_zero:  # the larger limit holds throughout
        yield (), within(part.value, own) | within(f"{part.value}.lower", lower)
        return
    yield (growth,), within(part.value, own)
    yield (RealFunction(-growth.function),), within(f"{part.value}.lower", lower)


def above_one(square: RealFunction) -> RealFunction:
    """Positive where a square is above 1."""
    f = square.function
    return RealFunction(f.ring.function(f.numerator - f.denominator, f.denominator))
