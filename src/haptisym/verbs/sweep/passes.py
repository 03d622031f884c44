"""The answers of a sweep for batches of parameter sets: floats with bounds where they prove it, exact where they do not.

The zeros that are proven (``waves``) are put in order for each set, and the answers are read off them (``Pass``). Where the
criterion is a region's, its sign between the zeros is that of the largest of the smallest of its functions (``changes``).
Floats are doubles; what these leave is tried in wider ones where there are no waves, and what is left then comes from the
certified chart of an evaluation (``exact_answers``).

Held in a hand: how many roots H_perc + m s^2 + b s + k has in Re s >= 0. In floats where the characteristic function is a
polynomial in s, by Routh's array. H_perc is in lowest terms for symbols, but perhaps not for a set of values. A zero that both
parts of the quotient then share is no root; there is none in Re s >= 0 where the denominator is proven to have all its zeros
in Re s < 0, those at 0 apart, which the array does not allow. All other sets, and all with delays, powers of s or a clock, are
counted exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from sympy import Expr, Integer, Rational

from haptisym.judge.crossings import Curve, judged, kept, noticed
from haptisym.judge.percepts import changeovers
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import HaptisymError, SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, bounds
from haptisym.kernel.roots import Chart, Key, Point, Signed, chart
from haptisym.model.catalogue import Hand
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.parameters import values as values_of
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.verbs.stability.held import characteristic, unstable_roots
from haptisym.verbs.sweep.axes import ABSENT, EXACT, FLOAT, INFINITE, OPEN, SYSTEMS, UNKNOWN, Told, held_name
from haptisym.verbs.sweep.batch import Array, Powers, count_right, within_reach
from haptisym.verbs.sweep.curves import (
    Curves,
    Excess,
    FamilyLattice,
    FamilyProduct,
    FamilyReader,
    SignedProduct,
    curves_of,
)
from haptisym.verbs.sweep.waves import Factor, Family, Function, Zeros, isolate, refine


@dataclass(frozen=True)
class Found:
    """Frequencies, as fractions of the band's high end, in ascending order for each set."""

    sets: Array
    omega: Array
    first: Array
    """The sign at the band's low end, for each set."""


@dataclass(frozen=True)
class Ordered:
    """All zeros of some functions, for each set in ascending order behind a row for its low end.

    ``kinds`` : whose zero it is, -1 for a low end. ``signs``: in rows, of each function from there on.
    """

    sets: Array
    omega: Array
    kinds: Array
    signs: Array

    @classmethod
    def of(cls, zeros: list[Found], low: float, count: int) -> Ordered:
        """All zeros of all functions, after the band's low end, in ascending order for each set."""
        every = np.arange(count)
        sets = np.concatenate([every, *(x.sets for x in zeros)])
        omega = np.concatenate([np.full(count, low), *(x.omega for x in zeros)])
        kinds = np.repeat(np.arange(-1, len(zeros)), [count, *(len(x.sets) for x in zeros)])
        order = np.lexsort((kinds, omega, sets))
        sets, omega, kinds = sets[order], omega[order], kinds[order]
        start = np.searchsorted(sets, every)
        signs = np.empty((len(zeros), len(sets)), dtype=np.int8)
        for kind, x in enumerate(zeros):
            passed = np.cumsum(kinds == kind)
            odd = (passed - passed[start][sets]) % 2 == 1
            signs[kind] = np.where(odd, -x.first[sets], x.first[sets])
        return cls(sets, omega, kinds, signs)

    @property
    def begins(self) -> Array:
        """Which rows are those of low ends."""
        found: Array = self.kinds < 0
        return found


def changes(lattice: FamilyLattice, zeros: Mapping[Family, Found], low: float, near: float) -> tuple[Found, Array]:
    """Where the lattice changes its sign, and for which sets that is certain.

    Not where two zeros lie so near each other (relatively, ``near``) that their order is not known, nor where the lattice is 0
    between equal signs, as where several of its functions have one zero, nor where one that is 0 at omega = 0 decides there.
    """
    listed = list(zeros.values())
    count = len(listed[0].first)
    rows = Ordered.of(listed, low, count)
    signs = dict(zip(zeros, rows.signs, strict=True))
    positive = _positive(lattice, signs)
    changed = np.zeros(len(positive), dtype=bool)
    changed[1:] = positive[1:] != positive[:-1]
    changed &= ~rows.begins
    certain = np.ones(count, dtype=bool)
    close = np.diff(rows.omega) <= near * rows.omega[1:]
    certain[rows.sets[1:][close & ~rows.begins[1:] & ~rows.begins[:-1]]] = False
    for kind, f in enumerate(signs):
        own = rows.kinds == kind
        there = {g: row[own] for g, row in signs.items()} | {f: np.zeros(own.sum(), np.int8)}
        vanishes = _positive(lattice, there, or_0=True) & ~_positive(lattice, there)
        certain[rows.sets[own][vanishes != changed[own]]] = False
    begun = {f: row[rows.begins] for f, row in signs.items()}
    certain &= _positive(lattice, begun, at_0=1) == _positive(lattice, begun, at_0=-1)
    first = np.where(positive[rows.begins], 1, -1)
    return Found(rows.sets[changed], rows.omega[changed], first), certain


def _positive(
    lattice: FamilyLattice, signs: Mapping[Family, Array], *, or_0: bool = False, at_0: int | None = None
) -> Any:
    """Where the lattice is positive, ``or_0``; ``at_0`` : with that sign for what begins with 0."""

    def of(x: SignedProduct) -> Any:
        own = np.full_like(next(iter(signs.values())), x.sign if at_0 is None or not x.begins_at_0 else at_0)
        for f in x.factors if at_0 is None or not x.begins_at_0 else ():
            own = own * signs[f]
        return own >= 0 if or_0 else own > 0

    return np.logical_or.reduce([np.logical_and.reduce([of(x) for x in term]) for term in lattice.terms])


TOLERANCE = 1e-10
"""Relative: every frequency that is answered is proven to lie this close to the true one."""
NARROWER = 0.95 * TOLERANCE
"""Of (omega/scale)^step, step 1 or 2; the rest is for taking the root and scaling back."""
Columns: TypeAlias = dict[str, Array]


@dataclass(frozen=True)
class Band:
    """The band as fractions of its high end, to the power of the curves' variable.

    ``doubtful``: the exact low end is no double, and lies in the first segment.
    """

    high: float
    low_fraction: float
    ends: tuple[float, ...]
    doubtful: bool

    @classmethod
    def of(cls, low: Expr, high: Expr, step: int) -> Band:
        """The band as the unit interval; ends rounded outwards."""
        below, above = bounds(ExactNumber((low / high) ** step).tight_ball(200))
        first, last = _float_below(below), -_float_below(-above)
        ends = (first,) if first == last else (first, last)
        return cls(float(ExactNumber(high)), float(ExactNumber(low / high)), ends, len(ends) > 1)


def _float_below(x: Fraction) -> float:
    nearest = float(x)
    return nearest if Fraction(nearest) <= x else float(np.nextafter(nearest, -np.inf))


class Pass:
    """One batch in floats of one kind."""

    def __init__(self, curves: Curves, band: Band, values: Array) -> None:
        self.curves, self.band, self.sets = curves, band, values.shape[1]
        self.powers = Powers(values)
        self.decided = within_reach(values, ([f.terms for f in x] for x in curves.products))
        self._factors: dict[Family, Factor] = {}

    def answers(self) -> tuple[Columns, Array]:
        """All variables, and for which sets they are proven."""
        with np.errstate(all="ignore"):
            self._no_zero_in(self.curves.definite)
            parts = {name: self._crossings(e) for name, e in self.curves.excess.items()}
            turns = [self._zeros(None if x is None else self._at(x)) for x in self.curves.changeovers]
        columns: Columns = {"method": np.full(self.sets, FLOAT, dtype=np.int8)}
        for name, found in parts.items():
            columns[f"crossings_{name}"], columns[f"first_crossing_{name}"] = self._told(found)
        for name, found in zip(SYSTEMS, turns, strict=True):
            columns[f"changeovers_{name}"], columns[f"changeover_{name}"] = self._told(found)
        return columns | self._transparency(parts, columns), self.decided

    def _at(self, families: FamilyProduct) -> Function:
        """A product for each set."""
        for f in families:
            if f not in self._factors:
                self._factors[f] = Factor(f, f.at(self.powers))
        variables = families[0].variables
        rates = [self.powers.monomial(x.exponents) * x.constant for x in variables.rates]
        rows = np.array(rates).reshape(-1, self.sets)
        return Function(variables, rows, tuple(self._factors[f] for f in families))

    def _no_zero_in(self, families: Sequence[Family]) -> None:
        for f in families:
            found = self._isolated(self._at((f,)))
            self.decided[found.sets] = False

    def _crossings(self, e: Excess | None) -> Found:
        """Where a criterion's sign changes."""
        if not isinstance(e, FamilyLattice):
            return self._zeros(None if e is None else self._at(e.above) - self._at(e.below))
        zeros = {f: self._zeros(self._at((f,))) for f in e.factors}
        if not zeros:
            return Found(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, e.sign))
        found, certain = changes(e, zeros, self.band.low_fraction, 4 * TOLERANCE)
        self.decided &= certain
        return found

    def _isolated(self, f: Function) -> Zeros:
        edges = (*self.band.ends, 1.0)
        found = isolate(f, edges, first_is_doubt=self.band.doubtful)
        self.decided &= found.decided
        return found

    def _zeros(self, f: Function | None) -> Found:
        if f is None:
            return Found(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, -1))
        found = self._isolated(f)
        x, proven = refine(f.of(found.sets), found.low, found.high, NARROWER)
        self.decided[found.sets[~proven]] = False
        omega = (np.sqrt(x) if self.curves.step == 2 else x).astype(float)
        # segments overlap by a unit in the last place, where a zero would be found twice
        close = np.diff(omega) < 4 * TOLERANCE * omega[1:]
        self.decided[found.sets[1:][close & (np.diff(found.sets) == 0)]] = False
        return Found(found.sets, omega, found.first)

    def _told(self, found: Found) -> tuple[Array, Array]:
        """How many, and the first one."""
        column = np.full(self.sets, ABSENT)
        begins = np.ones(len(found.sets), dtype=bool)
        begins[1:] = found.sets[1:] != found.sets[:-1]
        column[found.sets[begins]] = found.omega[begins] * self.band.high
        return np.bincount(found.sets, minlength=self.sets), column

    def _transparency(self, parts: Mapping[str, Found], columns: Columns) -> Columns:
        clear = np.logical_and.reduce([found.first < 0 for found in parts.values()])
        ends = np.fmin.reduce(
            [*(columns[f"first_crossing_{name}"] for name in parts), np.full(self.sets, self.band.high)]
        )
        return {
            "bandwidth": np.where(clear, ends, ABSENT),
            "transparent": _fraction(list(parts.values()), self.band.low_fraction),
        }


def _fraction(parts: list[Found], low: float) -> Array:
    """The part of the band on which all are negative, from all crossings in order."""
    count = len(parts[0].first)
    rows = Ordered.of(parts, low, count)
    following = np.append(rows.omega[1:], 1.0)
    following[:-1][rows.begins[1:]] = 1.0
    clear = (rows.signs < 0).all(axis=0)
    return np.bincount(rows.sets, weights=(following - rows.omega) * clear, minlength=count) / (1.0 - low)


AnswerRow: TypeAlias = dict[str, float]

LONGEST = 10.0  # s for one set


def exact_answers(scene: Scene, swept: Sequence[Knob], values: Sequence[float]) -> AnswerRow:
    """All variables of a sweep for one set of values, which are taken as exactly the binary numbers that the floats are.

    None of it where that takes longer than ``LONGEST`` seconds.
    """
    exact = [Rational(*Fraction(float(x)).as_integer_ratio()) for x in values]
    try:
        with limited(LONGEST):
            found = _chart(scene, swept, exact)
    except (SceneError, UndecidedError):  # no dynamics at all here (H_env = 0 everywhere, C H + D = 0), or a doubt
        return Told.of(scene).no_answer()
    return Told.of(scene).no_answer() if found.undecided else _row(found)


def _chart(scene: Scene, swept: Sequence[Knob], values: Sequence[Expr]) -> Chart:
    given = {x.symbol: value for x, value in zip(swept, values, strict=True)}
    limits = {part: value for x, value in zip(swept, values, strict=True) for part in x.parts}
    known = {p.symbol: p.value for p in scene.parameters}
    d = Distortion.of(scene.chain.at({**known, **given}))
    threshold = scene.threshold.with_limits(limits)
    asked: dict[Key, Signed] = {x: x.function(d) for x in noticed(threshold)}
    asked[Curve.ENVIRONMENT, Part.REAL] = part_of(d.env_response, Part.REAL)
    asked[Curve.PERCEIVED, Part.REAL] = part_of(d.perc_response, Part.REAL)
    return chart(asked, *scene.band)


def _row(found: Chart) -> AnswerRow:
    row: AnswerRow = {"method": EXACT, **_step(found)}
    places: Mapping[str, Sequence[Point]] = {
        "environment": changeovers(found, Curve.ENVIRONMENT),
        "perceived": changeovers(found, Curve.PERCEIVED),
    }
    for name, points in places.items():
        row[f"changeovers_{name}"] = len(points)
        row[f"changeover_{name}"] = _first(points)
    return row


def _step(found: Chart) -> AnswerRow:
    """When: crossings and what is transparent."""
    row: AnswerRow = {}
    for x in judged(found):
        points = [p for p in found.points if p.orders.get(x, 0) > 0]
        row[f"crossings_{x.name}"] = len(points)
        row[f"first_crossing_{x.name}"] = _first(points)
    intervals = kept(found)
    low, high = (float(found.points[i].omega) for i in (0, -1))
    clear = sum(float(x.high.omega) - float(x.low.omega) for x in intervals)
    begins = intervals and intervals[0].low is found.points[0]
    row["transparent"] = clear / (high - low)
    row["bandwidth"] = float(intervals[0].high.omega) if begins else ABSENT
    return row


def _first(points: Sequence[Point]) -> float:
    return float(points[0].omega) if points else ABSENT


@dataclass(frozen=True)
class HandCurve:
    """The characteristic polynomial in s of a display in a hand, and the denominator of H_perc without its zeros at 0."""

    top: Family
    bottom: Family

    def count(self, values: Array) -> tuple[Array, Array]:
        """For each set the number of roots in Re s >= 0, and whether it is proven."""
        powers, decided = Powers(values), within_reach(values, [(self.top.terms,), (self.bottom.terms,)])
        counts, certain = count_right(self.top.polynomial(powers))
        poles, proper = count_right(self.bottom.polynomial(powers))
        return counts, decided & certain & proper & (poles == 0)


def hand_curves(scene: Scene, swept: Sequence[Knob]) -> tuple[HandCurve | None, ...]:
    """Of each hand of a scene; None where that is no polynomial."""
    return tuple(None if clocks(scene) else _curve(scene, hand, swept) for hand in scene.hands)


def _curve(scene: Scene, hand: Hand, swept: Sequence[Knob]) -> HandCurve | None:
    given = {x.symbol for x in swept}
    chain = scene.chain.at(values_of(p for p in scene.parameters if p.symbol not in given))
    Z = hand.dynamics.xreplace(values_of(p for p in hand.parameters if p.symbol not in given))
    try:
        ring = Ring.of([*chain.entries(), Z])
        perceived = chain.perceived(range(len(chain.matrices)), ring)
    except HaptisymError:
        return None
    top = characteristic(perceived, ring.convert(Z))
    if ring.functions or top.is_zero():
        return None
    bottom = perceived.denominator
    lowest = min(int(exponents[0]) for exponents in bottom.monoms())

    reader = FamilyReader([x.symbol for x in swept], Integer(1))
    return HandCurve(reader.family(ring, top), reader.family(ring, bottom / ring.variable**lowest))


def held(
    scene: Scene, swept: Sequence[Knob], curves: Sequence[HandCurve | None], values: Array
) -> Iterator[tuple[str, Array, Array]]:
    """For each hand of a scene the name of its variable, the numbers of roots, and by which method they were found."""
    for place, (hand, curve) in enumerate(zip(scene.hands, curves, strict=True)):
        counts, method = np.full(values.shape[1], UNKNOWN), np.full(values.shape[1], EXACT, dtype=np.int8)
        for wide in _KINDS if curve else ():
            assert curve
            left = np.flatnonzero(method == EXACT)
            found, proven = curve.count(values[:, left].astype(wide))
            counts[left[proven]], method[left[proven]] = found[proven], FLOAT
        for i in np.flatnonzero(method == EXACT):
            counts[i] = exact_count(scene, place, swept, values[:, i].tolist())
            method[i] = OPEN if counts[i] == UNKNOWN else EXACT
        yield held_name(scene, hand), counts, method


def exact_count(scene: Scene, place: int, swept: Sequence[Knob], values: Sequence[float]) -> int:
    """The same for one set, whose values are taken as exactly the binary numbers that the floats are."""
    given = {x.path: Rational(*Fraction(float(v)).as_integer_ratio()) for x, v in zip(swept, values, strict=True)}
    try:
        at = scene.with_values({x.path: given[x.path] for x in swept if not x.parts})
        with limited(LONGEST):
            found = unstable_roots(at, at.hands[place])
    except (SceneError, UndecidedError):
        return UNKNOWN
    return (INFINITE if found.chain else UNKNOWN) if found.number is None else found.number


_AT_ONCE = 4096
"""Sets: so many that the work arrays stay in the processor's cache."""
_KINDS = (np.float64, np.longdouble) if np.finfo(np.longdouble).nmant in (63, 112) else (np.float64,)
"""Of floats: NumPy's longdouble where it is a wider IEEE format, and neither a double by another name nor a pair of doubles."""


@dataclass(frozen=True)
class Kernel:
    """What a sweep computes, for any values of the swept parameters; can be sent to other processes."""

    scene: Scene
    swept: tuple[Knob, ...]
    curves: Curves | None
    band: Band
    hands: tuple[HandCurve | None, ...] = ()

    @classmethod
    def of(cls, scene: Scene, swept: Sequence[Knob]) -> Kernel:
        """Of a scene and the numbers that are swept: curves in floats where there are such, else the exact machinery alone."""
        curves = curves_of(scene, swept)
        band = Band.of(*scene.band, curves.step if curves else 1)
        return cls(replace(scene), tuple(swept), curves, band, hand_curves(scene, swept))

    @property
    def told(self) -> Told:
        """The variables."""
        return Told.of(self.scene)

    @property
    def has_waves(self) -> bool:
        """Whether there are delays, holds or powers s^alpha: these need sines, which only doubles have with a bound."""
        return self.curves is not None and self.curves.has_waves

    def answers(self, values: Array) -> Columns:
        """All variables, for values of the swept parameters in rows and sets in columns."""
        columns, left = self.in_floats(values)
        for i in left:
            for name, value in exact_answers(self.scene, self.swept, values[:, i].tolist()).items():
                columns[name][i] = value
        return self._in_hands(values, columns)

    def _in_hands(self, values: Array, columns: Columns) -> Columns:
        """With what is told of each hand; the method is that of what took most."""
        for name, counts, method in held(self.scene, self.swept, self.hands, values):
            columns[name] = counts
            columns["method"] = np.maximum(columns["method"], method)
        return columns

    def in_floats(self, values: Array) -> tuple[Columns, Array]:
        """The same as far as floats prove it, and the numbers of the sets that they leave open."""
        columns, left = _blank(self.told, values.shape[1]), np.arange(values.shape[1])
        for wide in _KINDS if self.curves else ():
            if wide is np.float64 or not self.has_waves:
                left = self._in_floats(values.astype(wide), columns, left)
        return columns, left

    def _in_floats(self, values: Array, columns: Columns, sets: Array) -> Array:
        """Answer those sets that floats of this kind can prove; the others are returned."""
        assert self.curves is not None
        rest = [sets[:0]]
        for i in range(0, len(sets), _AT_ONCE):
            some = sets[i : i + _AT_ONCE]
            found, decided = Pass(self.curves, self.band, values[:, some]).answers()
            for name, column in found.items():
                columns[name][some[decided]] = column[decided]
            rest.append(some[~decided])
        return np.concatenate(rest)


def _blank(told: Told, sets: int) -> Columns:
    floats = {name: np.full(sets, ABSENT) for name in told.floats}
    counts = {name: np.full(sets, UNKNOWN, dtype=np.int16) for name in told.counts}
    return {**floats, **counts, "method": np.full(sets, EXACT, dtype=np.int8)}
