"""Sets of values of one parameter as plain numbers, and what an evaluation at single values says of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from random import Random
from typing import Any, TypeVar

from sympy import Expr, Rational

import haptisym as hs
from haptisym.model.parameters import values

Place = TypeVar("Place")


def shown(found: Any) -> list[tuple[float | None, float | None, bool, bool]]:
    """Of each interval both ends, and whether they belong to it."""
    return [(*(None if e is None else float(e) for e in (x.low, x.high)), *x.closed) for x in found.feasible]  # type: ignore[misc]


def ends(found: Any) -> list[tuple[float | None, float | None]]:
    return [x[:2] for x in shown(found)]


def within(pairs: Iterable[Sequence[Any]], value: Any) -> bool:
    """Whether a number lies in one of some intervals; None: without bound."""
    return any((x[0] is None or x[0] <= value) and (x[1] is None or value <= x[1]) for x in pairs)


def undecided(found: Any) -> list[tuple[float | None, ...]]:
    return [tuple(None if x is None else float(x) for x in pair) for pair in ((p.low, p.high) for p in found.undecided)]


def closed_sets(marks: Sequence[Place], holds: Callable[[Any], bool]) -> list[tuple[Place, Place]]:
    """A closed set of numbers between the first and the last of all places where it may begin or end."""
    found: list[tuple[Place, Place]] = []
    for before, x in zip([None, *marks], marks, strict=False):
        if holds(x):
            joined = before is not None and holds((before + x) / 2)  # type: ignore[operator]
            found[-1:] = [(found[-1][0], x)] if joined else [*found[-1:], (x, x)]
    return found


def is_transparent(scene: hs.Scene, parts: Sequence[hs.Part] = tuple(hs.Part)) -> bool:
    """By an evaluation at this one value, exact: no ratio rises above its threshold, nor is above it at the low end."""
    loose = [scene.threshold[x] if x in parts else Rational(10**9) for x in hs.Part]
    if len(parts) == 1:
        scene = hs.Scene(scene.environment, scene.effects, scene.band, hs.Threshold.of(*loose))
    e = hs.evaluate(scene)
    whole = e.chart.points[0], e.chart.points[-1]
    return len(e.transparent) == 1 and (e.transparent[0].low, e.transparent[0].high) == whole


def contradictions(scene: hs.Scene, found: Any, random: Random, count: int = 6) -> list[tuple[float, bool]]:
    """Values close to each end on both sides, and random ones, at which an evaluation says otherwise."""
    marks = sorted({x for pair in ends(found) for x in pair if x is not None})
    bases = [*marks, float(values(scene.parameters).get(found.free.symbol, Rational(1, 10))), 1.0]
    drawn = [random.choice(bases) * random.choice((1, 1, 1, -1)) * 10 ** random.uniform(-1, 1) for _ in range(count)]
    tried = {Rational(end * f).limit_denominator(10**15) for end in marks for f in (1 - 1e-7, 1 + 1e-7)}
    tried |= {Rational(x).limit_denominator(10**6) for x in drawn}
    asked = [x for x in tried if x and within([(found.domain.low, found.domain.high)], x)]
    return [x for x in (_wrong(scene, found, value) for value in asked) if x] + wrong_edges(scene, found)


def wrong_edges(scene: hs.Scene, found: Any) -> list[tuple[float, bool]]:
    """The ends of what was asked about, 0 among them, of which an evaluation there says otherwise."""
    domain = found.domain
    edges = [
        x for x, holds in ((domain.low, domain.holds_low), (domain.high, domain.holds_high)) if holds and x is not None
    ]
    known = [x for x in edges if not within(undecided(found), float(x))]
    rows = [_wrong(scene, found, x, inside=_belongs(shown(found), float(x))) for x in known]
    return [x for x in rows if x]


def _belongs(rows: Iterable[tuple[float | None, float | None, bool, bool]], x: float) -> bool:
    """Whether a number is in one of some intervals, as they are shown."""
    return any(
        (a is None or a < x or (a == x and has_low)) and (b is None or x < b or (b == x and has_high))
        for a, b, has_low, has_high in rows
    )


def _wrong(scene: hs.Scene, found: Any, value: Expr, *, inside: bool | None = None) -> tuple[float, bool] | None:
    told = within(ends(found), value) if inside is None else inside
    try:
        expected = is_transparent(found.free.put(scene, value), tuple(x.part for x in found.criteria))
    except hs.SceneError:  # no scene
        return (float(value), False) if inside else None
    return None if told is expected else (float(value), expected)
