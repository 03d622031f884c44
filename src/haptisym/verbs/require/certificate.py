"""The certificate of a requirement: for which values of one parameter a display is transparent
(haptisym_check/FORMAT.md, rule 6).

The proof are *slabs*, intervals of values: over one of them a factor is a sum, with positive
weights, of functions of omega alone, its slices, whose signs show its own. Either a point of the
band is named at which the excess of a part is positive for all values of the slab, or cells of the
band in which no excess is. Slabs are halved, and cells as well, until the checker's own objects
(``haptisym_check``) find the signs that they need.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise
from math import isqrt
from typing import Any, TypeAlias

from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.sets import SingleValue
from haptisym.model.scene import Scene
from haptisym.verbs.evaluate.certificate import TOO_LONG, afford, document, name_in_file, shown
from haptisym.verbs.evaluate.products import Linked, products, rectangular
from haptisym.verbs.require.freeparameter import conditions
from haptisym.verbs.require.required import Requirement
from haptisym_check.requirement import Slices, cost

Value: TypeAlias = Fraction | None
"""A value of the parameter; None where it is unbounded."""
Bounds: TypeAlias = tuple[Fraction, Fraction]

# Cells of the band in a slab, and slabs in a certificate: fewer where a checker must enclose sines.
_MOST_CELLS, _MOST_SLABS, _MOST_WITH_WAVES = 50, 150, 40
# What a checker takes on at most, as points times cost.
_MOST_AMONG_WAVES = 10**8


@dataclass(frozen=True)
class Problem:
    """Excesses as products of factors, on a band; ``starts`` : points of the band at which
    something binds."""

    linked: Linked
    band: tuple[Fraction, Fraction, Fraction, Fraction]
    starts: Sequence[Fraction]

    def slabs(self, low: Value, high: Value, *, holds: bool) -> Iterator[dict[str, Any]]:
        """Slabs from end to end, each with its proof. UndecidedError where so many as a certificate
        may have do not suffice."""
        most = _MOST_WITH_WAVES if self.linked.has_waves else _MOST_SLABS
        whole = Slab(self, low, high)
        waiting, count = Waiting(whole.halves() if low is high is None else [whole]), 1
        for here in waiting:
            found = here.kept() if holds else here.failed()
            if found is not None:
                yield {"from": _text(here.low), "to": _text(here.high), **found}
            elif count < most:
                waiting.add(*here.halves())
                count += 1
            else:
                raise UndecidedError(
                    "a certificate: so many slabs of values, and cells of the band, as it "
                    "may have are not enough"
                )

    @property
    def tried(self) -> list[Fraction]:
        """Points of the band at which an excess may be positive: those that bind first, as they
        most likely show it, and some between."""
        _, low, high, _ = self.band
        # Broken powers of omega have no bounds at 0 itself: points close to it stand in.
        near_0 = (
            [Fraction(1, 10**n) for n in (15, 40, 70)] if low == 0 and self.linked.orders else []
        )
        return [
            *self.starts,
            *near_0,
            high,
            low,
            *(low + (high - low) * n / 16 for n in range(1, 16)),
        ]


@dataclass(frozen=True)
class Slab:
    """Values between two, and whether each end belongs to them."""

    problem: Problem
    low: Value
    high: Value
    closed: tuple[bool, bool] = (False, False)

    def halves(self) -> tuple[Slab, Slab]:
        """Two slabs that meet inside of this one, both with the value where they meet."""
        cut, (first, last) = _middle(self.low, self.high), self.closed
        return Slab(self.problem, self.low, cut, (first, True)), Slab(
            self.problem, cut, self.high, (True, last)
        )

    @cached_property
    def slices(self) -> list[Slices]:
        """The slices of each factor over the slab. SceneError where a checker refuses such long
        ends."""
        low = (-1, 0) if self.low is None else self.low.as_integer_ratio()
        high = (1, 0) if self.high is None else self.high.as_integer_ratio()
        found: list[Slices] | None = shown(
            lambda: [Slices(x, low, high) for x in self.problem.linked.factors]
        )
        if found is None:
            raise SceneError(TOO_LONG)
        return found

    def failed(self) -> dict[str, Any] | None:
        """A point of the band at which an excess is positive for all values, and whose."""
        names = self.problem.linked.told
        tried = (
            (x, name) for x in self.problem.tried for name in names if self._sign(name, x, x) == 1
        )
        found = next(tried, None)
        return (
            None
            if found is None
            else {"points": [str(found[0])], "part": found[1].partition(".")[2]}
        )

    def kept(self) -> dict[str, Any] | None:
        """Points between which no excess is positive; None where so many as a slab may have do not
        suffice."""
        low, *_, high = self.problem.band
        starts = sorted(x for x in self.problem.starts if low < x < high)
        found, waiting = [low], Waiting(pairwise([low, *dict.fromkeys(starts), high]))
        for a, b in waiting:
            if all(self._sign(name, a, b) in (-1, 0) for name in self.problem.linked.told):
                found.append(b)
            elif len(found) + len(waiting.rest) < _MOST_CELLS:
                waiting.add((a, (a + b) / 2), ((a + b) / 2, b))
            else:
                return None
        return {"points": [str(x) for x in found], "part": None}

    def _sign(self, name: str, a: Fraction, b: Fraction) -> int | None:
        """The sign of an excess between two points of the band, or at one, for all values of the
        slab; None where it is not shown."""
        excess = self.problem.linked.told[name]
        number = Fraction(excess["number"])
        sign = (number > 0) - (number < 0)
        for i, n in excess["powers"]:
            # At a point an excess must be positive for the slab's own ends too, and nowhere may a
            # denominator vanish at them; else what holds inside holds there by continuity.
            closed = self.closed if a == b or n < 0 else (False, False)
            factor = shown(self.slices[i].side, a, b, closed)
            if factor is None:
                return None
            sign *= factor if n % 2 else 1
        return sign


def _text(x: Value) -> str | None:
    return None if x is None else str(x)


def _middle(low: Value, high: Value) -> Fraction:
    """A value inside of a slab, whose ends may be open: about the geometric mean where the ends
    differ much in size, so that no scale is skipped."""
    if high is None:
        return Fraction(0) if low is None else max(2 * low, low + 1) if low else Fraction(1)
    if low is None:
        return min(2 * high, high - 1)
    if low == 0:
        return high / 16
    if 0 < 8 * low < high:
        scale = 10**6
        while low * scale < 1:
            scale *= 1000
        return Fraction(isqrt(int(low * high * scale**2)) + 1, scale)
    return (low + high) / 2


def ascending(values: Sequence[tuple[Value, Value, bool]]) -> bool:
    """Whether the intervals come one after the other, and no two neighbours say the same."""
    return all(
        a[1] is not None and b[0] is not None and a[1] <= b[0] and a[2] is not b[2]
        for a, b in pairwise(values)
    )


def certificate(found: Requirement) -> str:
    """The document of JSON. SceneError, a sentence, where the format has no room for the question
    or the scene.

    >>> import json
    >>> from haptisym.verbs.require.required import require
    >>> [x[2] for x in json.loads(certificate(require("fu2019", "omega_n")))["claim"]["values"]]
    [False, True]
    """
    scene = found.scene
    _refuse(found)
    path = _keys(scene, found, name_in_file(scene))
    functions = _functions(found)
    linked = products(
        functions, next(iter(functions.values())).axis.meanings.index(found.free.symbol)
    )
    problem = Problem(linked, _band(scene), _starts(found))
    bounds = partial(_end, digits=found.digits, apart=linked.has_waves)
    values = _values(found, bounds)
    slabs = [[*problem.slabs(low, high, holds=holds)] for low, high, holds in values]
    every = [x for row in slabs for x in row]
    _afford(every, linked)
    claim = {
        "question": "requirement",
        "free": path,
        "parts": [name.partition(".")[2] for name in functions],
        "values": [[None if x is None else str(x) for x in row[:2]] + [row[2]] for row in values],
        "binds": _binds({bounds(x): x for x in found.ends}, values, slabs),
    }
    return document(
        scene, claim, {key: x for key, x in linked.proof().items() if x} | {"slabs": every}, linked
    )


def _afford(slabs: Sequence[dict[str, Any]], linked: Linked) -> None:
    """SceneError where a checker would refuse to find so many signs."""
    triples = [(x["from"], x["to"], point) for x in slabs for point in x["points"]]
    costs = [cost(f) for f in linked.factors]
    afford(
        (Fraction(x) for triple in triples for x in triple if x is not None),
        sum(x for x, _ in costs),
    )
    if len(triples) * sum(x for _, x in costs) >= _MOST_AMONG_WAVES:
        raise SceneError(TOO_LONG)


def _binds(
    ends: Mapping[Any, SingleValue],
    values: Sequence[tuple[Value, Value, bool]],
    slabs: Sequence[Sequence[Any]],
) -> list[str]:
    """The part that binds at each end; of several the one that exceeds in the slab beside it."""
    beside = (
        (
            a[-1]["part"] or b[0]["part"],
            [found.criterion.name for found in ends[x[1], y[0]].bindings],
        )
        for (a, x), (b, y) in pairwise(zip(slabs, values, strict=True))
    )
    return [part if part in names else names[0] for part, names in beside]


def _refuse(found: Requirement) -> None:
    """SceneError for a requirement about which the format can say nothing."""
    found.scene.threshold.need_plain("a certificate")
    if found.that != ("transparent",) or any(
        x.name not in ("real", "imag") for x in found.criteria
    ):
        raise SceneError(
            "a certificate of a requirement is about what is transparent in this environment alone"
        )
    if found.undecided:
        raise SceneError("a certificate is about a whole answer: this one left values undecided")


def _functions(found: Requirement) -> dict[str, RealFunction]:
    """The excess of each part, the parameter being free."""
    told = conditions(found.scene, [found.free], found.criteria, rectangular)
    functions = {f"excess.{x.name}": f for x, f in told.items() if isinstance(f, RealFunction)}
    axis = next(iter(functions.values())).axis
    if any(found.free.symbol in x.free_symbols for x in (*axis.lags, *getattr(axis, "powers", ()))):
        raise SceneError(
            "a certificate of a requirement needs a free number that is no delay and no power of s"
        )
    return functions


def _keys(scene: Scene, found: Requirement, environment: str | None) -> list[str | int]:
    """The keys under which the scene's file has the free number; one of several environments is
    read as if it were the only one. SceneError where it has none."""
    table, free = tomllib.loads(scene.text), found.free
    for one in table.get("environments", []):
        if one.get("name", one.get("model")) == environment:
            table |= {"environment": one, "rendered": one.get("rendered", {})}
    place: list[str | int] = [free.place]
    if free.place.startswith("effects."):
        place = ["effects", [f"effects.{x.name}" for x in scene.effects].index(free.place)]
    name, _, index = free.key.partition("[")
    keys: list[str | int] = [*name.split("."), *([int(index.rstrip("]")) - 1] if index else [])]
    for path in ([*place, *keys], [*place, "parameters", *keys]):
        if _number_at(table, path):
            return path
    raise SceneError(f"a certificate needs {free.path} as a number of its own in the scene file")


def _number_at(table: Any, path: list[Any]) -> bool:
    for key in path:
        try:
            table = table[key]
        except (LookupError, TypeError):
            return False
    return not isinstance(table, dict)


def _band(scene: Scene) -> tuple[Fraction, Fraction, Fraction, Fraction]:
    """Rational bounds of the band's low end, and of its high end: four numbers."""
    low, high = (_bounds(ExactNumber(x)) for x in scene.band)
    return max(low[0], Fraction(0)), low[1], high[0], high[1]


def _bounds(x: RealNumber, digits: int = 60) -> tuple[Fraction, Fraction]:
    value = x.value if isinstance(x, ExactNumber) else None
    if value is not None and value.is_Rational:
        return (Fraction(int(value.p), int(value.q)),) * 2
    low, high = x.enclosure(digits)
    return Fraction(low), Fraction(high)


def _starts(found: Requirement) -> list[Fraction]:
    """The frequencies at which something binds, as rational numbers next to them on the band."""
    _, low, high, _ = _band(found.scene)
    places = [
        _bounds(b.omega)[0] for end in found.ends for b in end.bindings if b.omega is not None
    ]
    return sorted({min(max(x, low), high) for x in places})


def _values(
    found: Requirement, bounds: Callable[[SingleValue | None], Bounds | None]
) -> list[tuple[Value, Value, bool]]:
    """The intervals of values that the certificate speaks of, ascending, each with whether it is
    feasible. The slivers between them, as wide as the digits of an end, are left out.

    SceneError for what the format has no room for: single values, ends that are not separated.
    """
    low_end, high_end = (None if x is None else _bounds(x) for x in found.domain.ends)
    here, rows = None if low_end is None else low_end[1], list[tuple[Value, Value, bool]]()
    for piece in found.feasible:
        low, high = bounds(piece.first), bounds(piece.last)
        if low and high and low[1] >= high[0]:
            raise SceneError("a certificate of a requirement has no room for a single value")
        if piece.first and piece.first.bindings and low is not None:
            rows.append((here, low[0], False))
        rows.append((None if low is None else low[1], None if high is None else high[0], True))
        here = None if high is None else high[1]
    last = found.feasible[-1].last if found.feasible else None
    if not found.feasible or (last and last.bindings):
        rows.append((here, None if high_end is None else high_end[0], False))
    rows = [x for x in rows if x[0] is None or x[1] is None or x[0] < x[1]]
    if not ascending(rows):
        raise SceneError("a certificate of a requirement needs ends that are separated")
    return rows


def _end(x: SingleValue | None, *, digits: int, apart: bool) -> Bounds | None:
    """Bounds of an end; ``apart`` : where something binds it is neither of them, as no bounds of
    sines show that zero."""
    if x is None:
        return None
    low, high = _bounds(x.value, digits)
    beside = (
        (abs(low) or 1) / Fraction(10) ** digits
        if apart and low == high and x.bindings
        else Fraction(0)
    )
    return low - beside, high + beside
