"""The certificate of a requirement, and the slabs that prove it.

Factors over a slab of values: sums, with positive weights, of functions of omega alone, whose signs show theirs.

Slabs of values of one parameter, and cells of the band, in which coefficients show the sign of what must not be positive.

The certificate of a requirement: for which values a display is transparent, with a proof (docs/certificates.md).
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, partial
from itertools import pairwise
from math import isqrt
from typing import Any, TypeAlias

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.model.scene import Scene
from haptisym.verbs.evaluate.certificate import TOO_LONG, afford, document, named
from haptisym.verbs.evaluate.products import Factor, Linked, Rows, WaveFactor, products, rectangular
from haptisym.verbs.require.feasible import End
from haptisym.verbs.require.freeparameter import conditions
from haptisym.verbs.require.required import Requirement

Pair: TypeAlias = tuple[int, int]
Held: TypeAlias = tuple[bool, bool] | None
"""Whether each end of the slab belongs to it, where a factor must not be zero for a value; None where it may."""


def moved(p: Sequence[int], low: Pair, high: Pair) -> list[int]:
    """The coefficients of p((a + b u)/(c + d u)) (c + d u)^n, low = a/c and high = b/d."""

    def stretched(q: Sequence[int], a: int, b: int) -> list[int]:
        return [a * x + b * y for x, y in zip([*q, 0], [0, *q], strict=True)]

    found, power = [p[-1]], [1]
    for c in p[-2::-1]:
        power = stretched(power, low[1], high[1])
        found = [x + c * y for x, y in zip(stretched(found, low[0], high[0]), power, strict=True)]
    return found


@dataclass(frozen=True)
class Slices:
    """The slices of a polynomial in omega^step, the first at the low end of the slab."""

    rows: Sequence[Sequence[int]]
    step: int

    def side(self, a: Fraction, b: Fraction, held: Held) -> int | None:
        """The sign from a to b for all values; None where it is not shown."""
        rows = [moved(q, (a**self.step).as_integer_ratio(), (b**self.step).as_integer_ratio()) for q in self.rows]
        signs = {(x > 0) - (x < 0) for row in rows for x in row} - {0}
        borders = [row for row, own in zip((rows[0], rows[-1]), held or (), strict=False) if own]
        return signs.pop() if len(signs) == 1 and all(map(any, borders)) else None


class WaveSlices:
    """The slices of a factor with waves; None for one that is zero everywhere."""

    def __init__(self, slices: Sequence[WaveFactor | None]) -> None:
        self.slices = slices
        self._known = lru_cache(maxsize=None)(self._found)
        self._asked = [x for x in slices if x]

    def side(self, a: Fraction, b: Fraction, held: Held) -> int | None:
        """The sign from a to b for all values; None where it is not shown."""
        borders = [x for x, own in zip((self.slices[0], self.slices[-1]), held or (), strict=False) if own]
        return self._known(a, b) if all(borders) else None

    def _found(self, a: Fraction, b: Fraction) -> int | None:
        """The sign that all slices have; the one that failed is asked first in the next cell."""
        found = 0
        for i, x in enumerate(self._asked):
            own = {*(x.moved(a, b) or (0,))} if a < b else {x.sign_at(a)}
            if own not in ([{found}] if found else [{1}, {-1}]):
                self._asked.insert(0, self._asked.pop(i))
                return None
            [found] = own
        return found or None


def cost(factor: Factor | WaveFactor) -> tuple[int, int]:
    """Of the signs of its slices, as the limits of the format have it: for each bit of a point, and with waves for each point."""
    count, most = len(_rows(factor)), width(factor)
    if isinstance(factor, Factor):
        return 2 * (count * most) ** 2 + 2000, 0
    return 2 * count * most**2, factor.cost * most


def width(factor: Factor | WaveFactor) -> int:
    """How many slices it has."""
    return max(map(len, _rows(factor)))


def _rows(factor: Factor | WaveFactor) -> Rows:
    return factor.rows if isinstance(factor, Factor) else tuple(row for _, rows in factor.terms for row in rows)


def sliced(factor: Factor | WaveFactor, low: Pair, high: Pair) -> Slices | WaveSlices:
    """A factor between two values; 1/0 and -1/0 where there is no bound."""
    if isinstance(factor, Factor):
        return Slices(_slices(factor.rows, low, high), factor.step)
    every = _slices(_rows(factor), low, high)
    return WaveSlices([_refilled(factor, found) for found in every])


def _slices(rows: Sequence[Sequence[int]], low: Pair, high: Pair) -> list[list[int]]:
    width = max(map(len, rows))
    every = [moved([*row, *[0] * (width - len(row))], low, high) for row in rows]
    return [list(x) for x in zip(*every, strict=True)]


def _refilled(factor: WaveFactor, coefficients: Sequence[int]) -> WaveFactor | None:
    """The factor with these coefficients; None where all are zero."""
    terms, place = list[tuple[tuple[int, ...], Rows]](), 0
    for turns, rows in factor.terms:
        own = coefficients[place : (place := place + len(rows))]
        if any(own):
            terms.append((turns, tuple((n,) for n in own)))
    return WaveFactor(tuple(terms), factor.waves, factor.delays, factor.orders) if terms else None


Value: TypeAlias = Fraction | None
"""A value of the parameter; None where it is unbounded."""

_MOST_CELLS, _MOST_SLABS = 50, 150
_MOST_WITH_WAVES = 40


@dataclass(frozen=True)
class Ends:
    """The ends of a slab of values, and whether each belongs to it."""

    low: Value
    high: Value
    holds_low: bool = False
    holds_high: bool = False

    def halves(self) -> tuple[Ends, Ends]:
        """Two of them that meet inside."""
        cut = _middle(self.low, self.high)
        return Ends(self.low, cut, self.holds_low, True), Ends(cut, self.high, True, self.holds_high)  # noqa: FBT003

    def slices(self, factors: Sequence[Factor | WaveFactor]) -> list[Slices | WaveSlices]:
        """Of each factor, over the slab."""
        low = (-1, 0) if self.low is None else self.low.as_integer_ratio()
        high = (1, 0) if self.high is None else self.high.as_integer_ratio()
        return [sliced(f, low, high) for f in factors]


def _middle(low: Value, high: Value) -> Fraction:
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


@dataclass(frozen=True)
class Problem:
    """Excesses as products of factors, on a band; ``starts`` : points of the band at which something binds."""

    factors: Sequence[Factor | WaveFactor]
    functions: Mapping[str, Mapping[str, Any]]
    band: tuple[Fraction, Fraction, Fraction, Fraction]
    starts: Sequence[Fraction]

    def slabs(self, ends: Ends, *, holds: bool) -> Iterator[dict[str, Any]]:
        """Slabs from end to end, each with its proof. UndecidedError where so many as a certificate may have do not suffice."""
        most = _MOST_WITH_WAVES if any(isinstance(f, WaveFactor) for f in self.factors) else _MOST_SLABS
        waiting, count = [*ends.halves()[::-1]] if ends.low is ends.high is None else [ends], 1
        while waiting:
            tick()
            here = waiting.pop()
            found = self._slab(here, holds=holds)
            if found is not None:
                yield {"from": _text(here.low), "to": _text(here.high), **found}
            elif count < most:
                waiting += here.halves()[::-1]
                count += 1
            else:
                raise UndecidedError(
                    "a certificate: so many slabs of values, and cells of the band, as it may have are not enough"
                )

    def _slab(self, ends: Ends, *, holds: bool) -> dict[str, Any] | None:
        slab = Slab(self, ends, ends.slices(self.factors))
        if not holds:
            found = next(((x, part) for x in self._tried for part in self.functions if slab.fails(part, x)), None)
            return None if found is None else {"points": [str(found[0])], "part": found[1].partition(".")[2]}
        points = slab.cells()
        return None if points is None else {"points": [str(x) for x in points], "part": None}

    @property
    def _tried(self) -> list[Fraction]:
        """Points of the band at which an excess may be positive: those that bind, and some between."""
        _, low, high, _ = self.band
        near_0 = [Fraction(1, 10**n) for n in (15, 40, 70)] if low == 0 and _have_powers(self.factors) else []
        return [*self.starts, *near_0, high, low, *(low + (high - low) * n / 16 for n in range(1, 16))]


def _have_powers(factors: Sequence[Factor | WaveFactor]) -> bool:
    """Whether there are powers of omega, which have no bounds at 0."""
    return any(isinstance(f, WaveFactor) and f.orders for f in factors)


def _text(x: Value) -> str | None:
    return None if x is None else str(x)


@dataclass(frozen=True)
class Slab:
    """Values between two, with the factors as sums, of positive weights, of functions of omega alone."""

    problem: Problem
    ends: Ends
    slices: Sequence[Slices | WaveSlices]

    def fails(self, name: str, x: Fraction) -> bool:
        """Whether an excess is positive at a point of the band for all values."""
        return self._sign(self.problem.functions[name], x, x, firm=True) == 1

    def cells(self) -> list[Fraction] | None:
        """Points between which no excess is positive; None where so many as a slab may have do not suffice."""
        low, *_, high = self.problem.band
        inner = sorted({x for x in self.problem.starts if low < x < high})
        found, waiting = [low], [high, *inner[::-1]]
        while waiting:
            if self._is_kept(found[-1], waiting[-1]):
                found.append(waiting.pop())
            elif len(found) + len(waiting) < _MOST_CELLS:
                waiting.append((found[-1] + waiting[-1]) / 2)
            else:
                return None
        return found

    def _is_kept(self, a: Fraction, b: Fraction) -> bool:
        return all(self._sign(told, a, b, firm=False) in (-1, 0) for told in self.problem.functions.values())

    def _sign(self, told: Mapping[str, Any], a: Fraction, b: Fraction, *, firm: bool) -> int | None:
        number = Fraction(told["number"])
        found = (number > 0) - (number < 0)
        held = self.ends.holds_low, self.ends.holds_high
        for i, n in told["powers"]:
            own = self.slices[i].side(a, b, held if firm or n < 0 else None)
            if own is None:
                return None
            found *= own ** (n % 2)
        return found


def ascending(values: Sequence[tuple[Value, Value, bool]]) -> bool:
    """Whether the intervals come one after the other, and no two neighbours say the same."""
    return all(a[1] is not None and b[0] is not None and a[1] <= b[0] and a[2] is not b[2] for a, b in pairwise(values))


Bounds: TypeAlias = tuple[Fraction, Fraction]

_MOST_AMONG_WAVES = 10**8  # of a checker: points times cost
_MOST_BITS = 10**5  # of the ends of a slab, times the highest width of a factor


def certificate(found: Requirement) -> str:
    """The document of JSON. SceneError, a sentence, where the format has no room for the question or the scene.

    >>> import json
    >>> from haptisym.verbs.require.entry import require
    >>> [x[2] for x in json.loads(certificate(require("fu2019", "omega_n")))["claim"]["values"]]
    [False, True]
    """
    scene = found.scene
    environment = named(scene)
    _refuse(found)
    path = _keys(scene, found, environment)
    functions = _functions(found)
    linked = products(functions, next(iter(functions.values())).axis.meanings.index(found.free.symbol))
    problem = Problem(linked.factors, linked.told, _band(scene), _starts(found))
    bounds = partial(_end, digits=found.digits, apart=any(isinstance(f, WaveFactor) for f in linked.factors))
    values = _values(found, bounds)
    slabs = [[*problem.slabs(Ends(low, high), holds=holds)] for low, high, holds in values]
    _afford([x for row in slabs for x in row], linked)
    others = {"delays": [str(x) for x in linked.delays], "orders": [str(x) for x in linked.orders]}
    proof = {key: told for key, told in others.items() if told} | {
        "factors": [f.told() for f in linked.factors],
        "functions": linked.told,
        "slabs": [x for row in slabs for x in row],
    }
    claim = {
        "question": "requirement",
        "free": path,
        "parts": [name.partition(".")[2] for name in functions],
        "values": [[None if x is None else str(x) for x in row[:2]] + [row[2]] for row in values],
        "binds": _binds({bounds(x): x for x in found.ends}, values, slabs),
    }
    return document(scene, environment, claim, proof)


def _afford(slabs: Sequence[dict[str, Any]], linked: Linked) -> None:
    """SceneError where a checker would refuse to find so many signs, or to look at slabs between so long numbers."""
    ends = [
        sum(n.bit_length() for x in (row["from"], row["to"]) for n in Fraction(x or 0).as_integer_ratio())
        for row in slabs
    ]
    if (max(ends, default=0) + 2) * max(map(width, linked.factors), default=0) >= _MOST_BITS:
        raise SceneError(TOO_LONG)
    triples = [(x["from"], x["to"], point) for x in slabs for point in x["points"]]
    costs = [cost(f) for f in linked.factors]
    afford((Fraction(x) for triple in triples for x in triple if x is not None), sum(x for x, _ in costs))
    if len(triples) * sum(x for _, x in costs) >= _MOST_AMONG_WAVES:
        raise SceneError(TOO_LONG)


def _binds(
    ends: Mapping[Any, End], values: Sequence[tuple[Value, Value, bool]], slabs: Sequence[Sequence[Any]]
) -> list[str]:
    """The part that binds at each end; of several the one that exceeds in the slab beside it."""
    beside = (
        (a[-1]["part"] or b[0]["part"], [found.criterion.name for found in ends[x[1], y[0]].bindings])
        for (a, x), (b, y) in pairwise(zip(slabs, values, strict=True))
    )
    return [part if part in names else names[0] for part, names in beside]


def _refuse(found: Requirement) -> None:
    found.scene.threshold.need_plain("a certificate")
    if found.that != ("transparent",) or any(x.name not in ("real", "imag") for x in found.criteria):
        raise SceneError("a certificate of a requirement is about what is transparent in this environment alone")
    if found.undecided:
        raise SceneError("a certificate is about a whole answer: this one left values undecided")


def _functions(found: Requirement) -> dict[str, RealFunction]:
    """The excess of each part, the parameter being free."""
    told = conditions(found.scene, [found.free], found.criteria, rectangular)
    functions = {f"excess.{x.name}": f for x, f in told.items() if isinstance(f, RealFunction)}
    axis = next(iter(functions.values())).axis
    if any(found.free.symbol in x.free_symbols for x in (*axis.lags, *getattr(axis, "powers", ()))):
        raise SceneError("a certificate of a requirement needs a free number that is no delay and no power of s")
    return functions


def _keys(scene: Scene, found: Requirement, environment: str | None) -> list[str | int]:
    """Where the scene's file has the number; of one of several environments as if it were the only one."""
    table, free = tomllib.loads(scene.text), found.free
    for one in table.get("environments", []):
        if one.get("name", one.get("model")) == environment:
            table |= {"environment": one, "rendered": one.get("rendered", {})}
    place: list[str | int] = [free.place]
    if free.place.startswith("effects."):
        place = ["effects", [f"effects.{x.name}" for x in scene.effects].index(free.place)]
    own: Any = table
    for key in place:
        own = own[key] if isinstance(key, int) or key in own else {}
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
    """Bounds of the low end, and of the high end."""
    low, high = (_bounds(ExactNumber(x)) for x in scene.band)
    return max(low[0], Fraction(0)), low[1], high[0], high[1]


def _bounds(x: RealNumber, digits: int = 60) -> tuple[Fraction, Fraction]:
    value = x.value if isinstance(x, ExactNumber) else None
    if value is not None and value.is_Rational:
        return (Fraction(int(value.p), int(value.q)),) * 2
    low, high = x.enclosure(digits)
    return Fraction(low), Fraction(high)


def _starts(found: Requirement) -> list[Fraction]:
    """The frequencies at which something binds, nearly."""
    _, low, high, _ = _band(found.scene)
    places = [_bounds(b.omega)[0] for end in found.ends for b in end.bindings if b.omega is not None]
    return sorted({min(max(x, low), high) for x in places})


def _values(found: Requirement, bounds: Callable[[End], Bounds | None]) -> list[tuple[Value, Value, bool]]:
    """Intervals of values, ascending, each with whether it is feasible."""
    first, last = (None if x is None else _bounds(ExactNumber(x)) for x in (found.domain.low, found.domain.high))
    here, rows = None if first is None else first[1], list[tuple[Value, Value, bool]]()
    for span in found.feasible:
        low, high = bounds(span.low), bounds(span.high)
        if low and high and low[1] >= high[0]:
            raise SceneError("a certificate of a requirement has no room for a single value")
        if span.low.bindings and low is not None:
            rows.append((here, low[0], False))
        rows.append((None if low is None else low[1], None if high is None else high[0], True))
        here = None if high is None else high[1]
    if not found.feasible or found.feasible[-1].high.bindings:
        rows.append((here, None if last is None else last[0], False))
    rows = [x for x in rows if x[0] is None or x[1] is None or x[0] < x[1]]
    if not ascending(rows):
        raise SceneError("a certificate of a requirement needs ends that are told apart")
    return rows


def _end(x: End, *, digits: int, apart: bool) -> Bounds | None:
    """Bounds of an end; ``apart`` : where something binds it is neither of them, as no bounds of sines show that zero."""
    if x.value is None:
        return None
    low, high = _bounds(x.value, digits)
    beside = (abs(low) or 1) / Fraction(10) ** digits if apart and low == high and x.bindings else Fraction(0)
    return low - beside, high + beside
