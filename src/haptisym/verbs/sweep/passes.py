"""The answers of a sweep for batches of parameter sets: floats with bounds where they prove it,
exact where they do not.

**What is asked.** Functions of omega whose zeros answer a set, with the swept parameters left
symbolic and all other numbers in place. A criterion is a difference of two products of functions,
or, for a JND region, the largest of the smallest of products (``kernel.roots.Lattice``), each of
which keeps its sign between the zeros of its factors.

On x = (omega/(high end of the band))^step each function is a ``Family`` (``waves``). The step is 2
where all are polynomials in omega^2. With delays, holds and powers s^alpha it is 1, and forms are
read in half angles: with angles a each is a polynomial in x, cos(a/2), sin(a/2)/omega and x^alpha.

r^2 = A/B in lowest terms is not negative for any real values of its variables, the tangents and
powers among them. So no factor of A or B of odd multiplicity changes its sign, and along any
frequency A and B have zeros of even order only: where B vanishes, A - c^2 B has no simple zero, and
nothing need be known of B.

**What is answered.** The zeros that are proven (``waves``) are put in order for each set, and the
answers are read off them (``Pass``). Where the criterion is a region's, its sign between the zeros
is that of the largest of the smallest of its functions (``changes``). Floats are doubles; what
these leave is tried in wider ones where there are no waves, and what is left then comes from the
certified chart of an evaluation (``exact_answers``).

Held in a hand: how many roots H_perc + m s^2 + b s + k has in Re s >= 0. In floats where the
characteristic function is a polynomial in s, by Routh's array. H_perc is in lowest terms for
symbols, but perhaps not for a set of values. A zero that both parts of the quotient then share is
no root; there is none in Re s >= 0 where the denominator is proven to have all its zeros in Re s <
0, those at 0 apart, which the array does not allow. All other sets, and all with delays, powers of
s or a clock, are counted exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

import flint
import numpy as np
from flint import arb
from sympy import Expr, Integer, Rational, S, Symbol

from haptisym.judge.crossings import Criterion, PerceptFunction, judged, kept, noticed
from haptisym.judge.percepts import changeovers
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import HaptisymError, SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, bounds, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, omega
from haptisym.kernel.roots import Chart, Key, Lattice, Point, Signed, chart
from haptisym.model.catalogue import Hand
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.parameters import values as values_of
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.verbs.stability.held import characteristic, unstable_roots
from haptisym.verbs.sweep.axes import (
    ABSENT,
    EXACT,
    FLOAT,
    INFINITE,
    OPEN,
    SYSTEMS,
    UNKNOWN,
    SweepVariables,
    held_name,
)
from haptisym.verbs.sweep.batch import (
    BITS,
    Array,
    Monomial,
    Monomials,
    count_right,
    monomial,
    within_reach,
)
from haptisym.verbs.sweep.delayterms import (
    Exponents,
    Family,
    FamilyFactor,
    Function,
    Variables,
    Zeros,
    is_trusted,
    isolate,
    refine,
)

FamilyProduct: TypeAlias = tuple[Family, ...]
_Factors: TypeAlias = list[tuple[Polynomial, int]]


@dataclass(frozen=True)
class ThresholdPolynomial:
    """r^2 - c^2 times its denominator: ``above`` - ``below``, each a product. None of it where r is
    0 everywhere."""

    above: FamilyProduct
    below: FamilyProduct


@dataclass(frozen=True)
class SignedProduct:
    """A function as the signs that make its own: ``sign`` times those of factors. ``begins_at_0``:
    it is 0 at omega = 0."""

    sign: int
    factors: tuple[Family, ...]
    begins_at_0: bool


@dataclass(frozen=True)
class FamilyLattice:
    """Positive where for some of the ``terms`` all of its functions are."""

    terms: tuple[tuple[SignedProduct, ...], ...]

    @property
    def factors(self) -> tuple[Family, ...]:
        """Each function once."""
        return tuple(dict.fromkeys(f for term in self.terms for x in term for f in x.factors))

    @property
    def sign(self) -> int:
        """Its sign where there are no functions in it."""
        return 1 if any(all(x.sign > 0 for x in term) for term in self.terms) else -1


Excess: TypeAlias = ThresholdPolynomial | FamilyLattice


@dataclass(frozen=True)
class Curves:
    """What is asked of a scene, as functions of (omega/scale)^step.

    ``excess`` : by the name of the criterion. ``changeovers``: of the environment and as perceived,
    a product whose zeros are the changeovers, None if there can be none. ``definite``: what must
    not vanish on the band, or the zeros of the others are not the answer (poles, double zeros).
    ``has_waves`` : whether there are delays, holds or powers s^alpha.
    """

    step: int
    excess: Mapping[str, Excess | None]
    changeovers: tuple[FamilyProduct | None, FamilyProduct | None]
    definite: tuple[Family, ...]
    has_waves: bool

    @property
    def products(self) -> Iterator[FamilyProduct]:
        """All products of factors whose signs are asked."""
        for e in self.excess.values():
            if isinstance(e, FamilyLattice):
                yield from ((f,) for f in e.factors)
            elif e is not None:
                yield from (e.above, e.below)
        yield from (x for x in self.changeovers if x is not None)
        yield from ((x,) for x in self.definite)


def curves_of(scene: Scene, swept: Sequence[Knob]) -> Curves | None:
    """The curves of a scene; None where it has none, a limit is not rational, or sines are needed
    and not to be trusted here.

    A power s^alpha needs a number for alpha, a delay a number times powers of parameters.
    """
    asked = _closed_forms(scene, swept)
    if asked is None:
        return None
    functions = asked.functions
    has_waves = any(f.axis.functions for f in functions)
    if has_waves and not (is_trusted() and _is_readable(functions)):
        return None
    try:
        return _Curves(scene, swept, asked, has_waves=has_waves).read()
    except HaptisymError:
        return None  # a constant of which too few digits are known


def _is_readable(functions: Sequence[RealFunction]) -> bool:
    """Whether every power of s is a number, and every delay a number times powers of parameters."""
    ring, axis = functions[0].half_angled.ring, functions[0].axis
    rates = [ring.convert(x).reduced() for x in axis.lags]
    return (
        len({f.half_angled.ring.meanings for f in functions}) == 1
        and all(x.is_number for x in axis.orders)
        and all(len(f.numerator) == 1 and f.denominator.is_constant() for f in rates)
    )


@dataclass(frozen=True)
class _ClosedForms:
    """What is judged, whose zeros are the changeovers, and the squares that must not vanish for
    there to be dynamics."""

    measures: Mapping[Criterion, Signed]
    turning: tuple[RealFunction, ...]
    present: tuple[RealFunction, ...] = ()

    @property
    def functions(self) -> list[RealFunction]:
        """All of them."""
        own = [f for x in self.measures.values() for f in _functions(x)]
        return [*self.turning, *self.present, *own]


def _closed_forms(scene: Scene, swept: Sequence[Knob]) -> _ClosedForms | None:
    """Those of a scene; None where there are no dynamics, a delay needs a number, or a limit is not
    rational."""
    given = {x.symbol for x in swept}
    chain = scene.chain.at({p.symbol: p.value for p in scene.parameters if p.symbol not in given})
    try:
        d = Distortion.of(chain, Ring.of([*chain.entries(), *_LIMITS.values()]))
        measures = {
            x: _measure(x, d) for x in (_opened(x, swept) for x in noticed(scene.threshold))
        }
    except HaptisymError:
        return None
    turning = tuple(part_of(r, Part.REAL) for r in (d.env_response, d.perc_response))
    # where there is a real part its changeovers tell that there are dynamics
    return _ClosedForms(
        measures, turning, () if any(not x.is_zero for x in turning) else (d.squared_modulus,)
    )


_LIMITS = {part: Symbol(f"c_{part.value}", positive=True) for part in Part}
"""The symbols of swept limits of regions; a variable that does not occur costs nothing."""


def _opened(x: Criterion, swept: Sequence[Knob]) -> Criterion:
    """With symbols for the limits of a region that are swept; of a part alone they come in as
    numbers."""
    limits = {part: _LIMITS[knob.parts[0]] for knob in swept for part in knob.parts}
    if x.region:
        return replace(x, region=x.region.opened(limits)) if limits else x
    return replace(x, threshold=Integer(1)) if x.part in limits else x


def _measure(x: Criterion, d: Distortion) -> Signed:
    """What is held against one number; of a region, and of a limit that depends on the frequency,
    what must not be positive."""
    return x.function(d) if x.region or x.threshold.has(omega) else x.measure(d)


def _functions(x: Signed) -> Iterator[RealFunction]:
    yield from ((f for term in x.terms for f in term) if isinstance(x, Lattice) else (x,))


class _Curves:
    """Reads the families off the exact closed forms."""

    def __init__(
        self, scene: Scene, swept: Sequence[Knob], asked: _ClosedForms, *, has_waves: bool
    ) -> None:
        self.scene, self.swept, self.asked, self.has_waves = scene, swept, asked, has_waves
        forms = [f.half_angled for f in asked.functions]
        polynomials = [p for f in forms for p in (f.numerator, f.denominator)]
        is_even = not has_waves and all(int(e[0]) % 2 == 0 for p in polynomials for e in p.monoms())
        self.step = 2 if is_even else 1
        symbols = [_LIMITS[x.parts[0]] if x.parts else x.symbol for x in swept]
        self.reader = FamilyReader(
            symbols, scene.band[1], self.step, asked.turning[0] if has_waves else None
        )
        self.definite: list[Family] = []

    def read(self) -> Curves | None:
        """What is judged, as functions of the swept numbers; None where floats cannot tell them."""
        excess = {x.name: self._judged(f, x) for x, f in self.asked.measures.items()}
        environment, perceived = map(self._changeover, self.asked.turning)
        for form in (f.half_angled for f in self.asked.present):
            self.definite += self._all_but_zero(
                form.ring, (g for g, _ in form.ring.factors(form.numerator)[1])
            )
        turning = (f.half_angled for f in self.asked.turning)
        if self.step == 1 and self.scene.band[0] == 0 and any(map(_odd_at_zero, turning)):
            return None  # a function that is odd in omega changes its sign at 0 itself
        definite = tuple(dict.fromkeys(self.definite))
        return Curves(self.step, excess, (environment, perceived), definite, self.has_waves)

    def _judged(self, measure: Signed, criterion: Criterion) -> Excess | None:
        if (
            isinstance(measure, RealFunction)
            and not criterion.region
            and not criterion.threshold.has(omega)
        ):
            return self._excess(measure, criterion)
        terms = measure.terms if isinstance(measure, Lattice) else ((measure,),)
        listed = [
            [f for f in term if isinstance(f, RealFunction)] for term in terms
        ]  # no other are there
        found = tuple(
            tuple(map(self._signs, term)) for term in listed if not any(f.is_zero for f in term)
        )
        return (
            FamilyLattice(found) if found else None
        )  # where a function is 0 everywhere its term is nowhere positive

    def _signs(self, f: RealFunction) -> SignedProduct:
        form = f.half_angled
        ring = form.ring
        (unit, above), (lower, below) = (
            ring.factors(p) for p in (form.numerator, form.denominator)
        )
        even = [g for g, n in above if n % 2 == 0]
        self.definite += self._all_but_zero(ring, [*(g for g, _ in below), *even])
        odd = [g for g, n in (*above, *below) if n % 2 and not self._is_trivial(ring, g)]
        factors = tuple(self.reader.family(ring, g) for g in odd)
        is_0 = self.scene.band[0] == 0 and any(self._is_0_at_0(ring, g) for g, _ in above)
        return SignedProduct(1 if unit * lower > 0 else -1, factors, is_0)

    def _excess(self, f: RealFunction, criterion: Criterion) -> ThresholdPolynomial | None:
        if f.is_zero:
            return None
        form = f.half_angled
        ring = form.ring
        (unit, above), (lower, below) = (
            ring.factors(p) for p in (form.numerator, form.denominator)
        )
        column = next((i for i, x in enumerate(self.swept) if criterion.depends_on(x.parts)), None)
        limit = lower * criterion.limit if column is None else lower
        product = self._product(ring, below, limit)
        if column is not None:
            square = Monomial(0, 1.0, 0.0, tuple(2 * (i == column) for i in range(len(self.swept))))
            product = (self.reader.constant(square), *product)
        return ThresholdPolynomial(self._product(ring, above, unit), product)

    def _changeover(self, f: RealFunction) -> FamilyProduct | None:
        """Zeros of odd order; a zero at omega = 0 of an even function is no change of sign."""
        if f.is_zero:
            return None
        form = f.half_angled
        ring = form.ring
        (_, above), (_, below) = (ring.factors(p) for p in (form.numerator, form.denominator))
        even = [g for g, n in above if n % 2 == 0]
        self.definite += self._all_but_zero(ring, [*(g for g, _ in below), *even])
        odd = [(g, 1) for g, n in above if n % 2 and not self._is_0_at_0(ring, g)]
        return self._product(ring, odd, Integer(1))

    def _product(self, ring: PolynomialRing, factors: _Factors, unit: Expr) -> FamilyProduct:
        """The families of a product, the unit in the first."""
        powers = [(g**n, 1) if g == ring.variable else (g, n) for g, n in factors] or [
            (ring.constant(1), 1)
        ]
        listed = [g for g, n in powers for _ in range(n)]
        return tuple(
            self.reader.family(ring, g, Integer(1) if i else unit) for i, g in enumerate(listed)
        )

    def _all_but_zero(self, ring: PolynomialRing, factors: Iterable[Polynomial]) -> list[Family]:
        return [self.reader.family(ring, g) for g in factors if not self._is_trivial(ring, g)]

    def _is_trivial(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        return bool(factor.is_constant()) or self._is_0_at_0(ring, factor)

    def _is_0_at_0(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        """Whether a factor vanishes at omega = 0, and nowhere else."""
        powers = ring.context.gens()[ring.size : ring.size + len(self.reader.orders)]
        return any(factor == x for x in [ring.variable, *powers])


def _odd_at_zero(f: RationalFunction) -> bool:
    """Whether the power of omega in a real function is odd."""
    powers = [
        n
        for p in (f.numerator, f.denominator)
        for g, n in f.ring.factors(p)[1]
        if g == f.ring.variable
    ]
    return sum(powers) % 2 == 1


class FamilyReader:
    """Reads polynomials of a ring, the ``parameters`` being the only symbols in them, as families
    on (omega/scale)^step.

    ``function`` : one whose axis has the angles and powers that are variables of the ring; None
    where there are none.
    """

    def __init__(
        self,
        parameters: Sequence[Symbol],
        scale: Expr,
        step: int = 1,
        function: RealFunction | None = None,
    ) -> None:
        self.parameters, self.scale, self.step = tuple(parameters), scale, step
        self.orders, self.angles = (
            (function.axis.orders, function.axis.angles) if function else ((), ())
        )
        self.ring = function.half_angled.ring if function else None

    def constant(self, value: Monomial) -> Family:
        """Of degree 0 in all variables."""
        return Family((value,), self._variables, ((0,) * (1 + self._variables.waves),))

    def family(self, ring: PolynomialRing, polynomial: Polynomial, factor: Expr = S.One) -> Family:
        """``factor``, a number, times a polynomial."""
        known = {x: i for i, x in enumerate(ring.meanings)}
        columns = [known.get(x) for x in self.parameters]
        with flint.ctx.workprec(BITS):
            unit, found = expression_ball(factor), dict[tuple[Exponents, Exponents], arb]()
            for given, coefficient in polynomial.to_dict().items():
                row, exponents, ball = self._term([int(n) for n in given], columns, ring.size)
                key = row, exponents
                found[key] = found.get(key, arb(0)) + ball * arb(coefficient) * unit
            rows = sorted({row for row, _ in found})
            place = {row: i for i, row in enumerate(rows)}
            terms = sorted(
                (place[row], exponents, ball)
                for (row, exponents), ball in found.items()
                if ball != 0
            )
            return Family(tuple(monomial(*term) for term in terms), self._variables, tuple(rows))

    def _term(
        self, given: Sequence[int], columns: Sequence[int | None], start: int
    ) -> tuple[Exponents, Exponents, Any]:
        """The row that a monomial belongs to, its exponents of the parameters, and its constant."""
        assert not given[0] % self.step
        scale = expression_ball(self.scale)
        exponents = [given[i] if i is not None else 0 for i in columns]
        ball = arb.pi() ** given[1] * scale ** given[0]
        powers, waves = given[start : start + len(self.orders)], given[start + len(self.orders) :]
        for order, n in zip(self.orders, powers, strict=True):
            ball *= (scale.log() * expression_ball(order)).exp() ** n
        turning: list[int] = []
        for angle, c, s in zip(self.angles, waves[::2], waves[1::2], strict=True):
            if angle.constant:
                half = expression_ball(angle.rate) / 2
                ball *= half.cos() ** c * half.sin() ** s
                continue
            constant, own = self._half_rate(angle.rate)
            ball *= constant**s
            exponents = [n + s * m for n, m in zip(exponents, own, strict=True)]
            turning += [c, s]
        return (given[0] // self.step, *turning, *powers), tuple(exponents), ball

    def _half_rate(self, rate: Expr) -> tuple[Any, Exponents]:
        """Half of a rate as a number times powers of the parameters."""
        assert self.ring
        known = {x: i for i, x in enumerate(self.ring.meanings)}
        f = self.ring.convert(rate).reduced()
        [(given, coefficient)] = f.numerator.to_dict().items()
        ball = (
            arb(coefficient)
            / arb(f.denominator.leading_coefficient())
            * arb.pi() ** int(given[1])
            / 2
        )
        return ball, tuple(int(given[known[x]]) if x in known else 0 for x in self.parameters)

    @cached_property
    def _variables(self) -> Variables:
        rates = []
        with flint.ctx.workprec(BITS):
            scale = expression_ball(self.scale)
            for angle in self.angles:
                if not angle.constant:
                    ball, exponents = self._half_rate(angle.rate)
                    rates.append(monomial(0, exponents, ball * scale))
        return Variables(tuple(rates), tuple(float(x) for x in self.orders))


@dataclass(frozen=True)
class PassFrequencies:
    """Frequencies, as fractions of the band's high end, in ascending order for each set."""

    sets: Array
    omega: Array
    first: Array
    """The sign at the band's low end, for each set."""


@dataclass(frozen=True)
class Ordered:
    """All zeros of some functions, for each set in ascending order behind a row for its low end.

    ``kinds`` : whose zero it is, -1 for a low end. ``signs``: in rows, of each function from there
    on.
    """

    sets: Array
    omega: Array
    kinds: Array
    signs: Array

    @classmethod
    def of(cls, zeros: list[PassFrequencies], low: float, count: int) -> Ordered:
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


def changes(
    lattice: FamilyLattice, zeros: Mapping[Family, PassFrequencies], low: float, near: float
) -> tuple[PassFrequencies, Array]:
    """Where the lattice changes its sign, and for which sets that is certain.

    Not where two zeros lie so near each other (relatively, ``near``) that their order is not known,
    nor where the lattice is 0 between equal signs, as where several of its functions have one zero,
    nor where one that is 0 at omega = 0 decides there.
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
    return PassFrequencies(rows.sets[changed], rows.omega[changed], first), certain


def _positive(
    lattice: FamilyLattice,
    signs: Mapping[Family, Array],
    *,
    or_0: bool = False,
    at_0: int | None = None,
) -> Any:
    """Where the lattice is positive, ``or_0``; ``at_0`` : with that sign for what begins with 0."""

    def of(x: SignedProduct) -> Any:
        own = np.full_like(
            next(iter(signs.values())), x.sign if at_0 is None or not x.begins_at_0 else at_0
        )
        for f in x.factors if at_0 is None or not x.begins_at_0 else ():
            own = own * signs[f]
        return own >= 0 if or_0 else own > 0

    return np.logical_or.reduce(
        [np.logical_and.reduce([of(x) for x in term]) for term in lattice.terms]
    )


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
        self.powers = Monomials(values)
        self.decided = within_reach(values, ([f.terms for f in x] for x in curves.products))
        self._factors: dict[Family, FamilyFactor] = {}

    def answers(self) -> tuple[Columns, Array]:
        """All variables, and for which sets they are proven."""
        with np.errstate(all="ignore"):
            self._no_zero_in(self.curves.definite)
            parts = {name: self._crossings(e) for name, e in self.curves.excess.items()}
            turns = [
                self._zeros(None if x is None else self._at(x)) for x in self.curves.changeovers
            ]
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
                self._factors[f] = FamilyFactor(f, f.at(self.powers))
        variables = families[0].variables
        rates = [self.powers.monomial(x.exponents) * x.constant for x in variables.rates]
        rows = np.array(rates).reshape(-1, self.sets)
        return Function(variables, rows, tuple(self._factors[f] for f in families))

    def _no_zero_in(self, families: Sequence[Family]) -> None:
        for f in families:
            found = self._isolated(self._at((f,)))
            self.decided[found.sets] = False

    def _crossings(self, e: Excess | None) -> PassFrequencies:
        """Where a criterion's sign changes."""
        if not isinstance(e, FamilyLattice):
            return self._zeros(None if e is None else self._at(e.above) - self._at(e.below))
        zeros = {f: self._zeros(self._at((f,))) for f in e.factors}
        if not zeros:
            return PassFrequencies(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, e.sign))
        found, certain = changes(e, zeros, self.band.low_fraction, 4 * TOLERANCE)
        self.decided &= certain
        return found

    def _isolated(self, f: Function) -> Zeros:
        edges = (*self.band.ends, 1.0)
        found = isolate(f, edges, first_is_doubt=self.band.doubtful)
        self.decided &= found.decided
        return found

    def _zeros(self, f: Function | None) -> PassFrequencies:
        if f is None:
            return PassFrequencies(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, -1))
        found = self._isolated(f)
        x, proven = refine(f.of(found.sets), found.low, found.high, NARROWER)
        self.decided[found.sets[~proven]] = False
        omega = (np.sqrt(x) if self.curves.step == 2 else x).astype(float)
        # segments overlap by a unit in the last place, where a zero would be found twice
        close = np.diff(omega) < 4 * TOLERANCE * omega[1:]
        self.decided[found.sets[1:][close & (np.diff(found.sets) == 0)]] = False
        return PassFrequencies(found.sets, omega, found.first)

    def _told(self, found: PassFrequencies) -> tuple[Array, Array]:
        """How many, and the first one."""
        column = np.full(self.sets, ABSENT)
        begins = np.ones(len(found.sets), dtype=bool)
        begins[1:] = found.sets[1:] != found.sets[:-1]
        column[found.sets[begins]] = found.omega[begins] * self.band.high
        return np.bincount(found.sets, minlength=self.sets), column

    def _transparency(self, parts: Mapping[str, PassFrequencies], columns: Columns) -> Columns:
        clear = np.logical_and.reduce([found.first < 0 for found in parts.values()])
        ends = np.fmin.reduce(
            [
                *(columns[f"first_crossing_{name}"] for name in parts),
                np.full(self.sets, self.band.high),
            ]
        )
        return {
            "bandwidth": np.where(clear, ends, ABSENT),
            "transparent": _fraction(list(parts.values()), self.band.low_fraction),
        }


def _fraction(parts: list[PassFrequencies], low: float) -> Array:
    """The part of the band on which all are negative, from all crossings in order."""
    count = len(parts[0].first)
    rows = Ordered.of(parts, low, count)
    following = np.append(rows.omega[1:], 1.0)
    following[:-1][rows.begins[1:]] = 1.0
    clear = (rows.signs < 0).all(axis=0)
    return np.bincount(rows.sets, weights=(following - rows.omega) * clear, minlength=count) / (
        1.0 - low
    )


AnswerRow: TypeAlias = dict[str, float]

LONGEST = 10.0  # s for one set


def exact_answers(scene: Scene, swept: Sequence[Knob], values: Sequence[float]) -> AnswerRow:
    """All variables of a sweep for one set of values, which are taken as exactly the binary numbers
    that the floats are.

    None of it where that takes longer than ``LONGEST`` seconds.
    """
    exact = [Rational(*Fraction(float(x)).as_integer_ratio()) for x in values]
    try:
        with limited(LONGEST):
            found = _chart(scene, swept, exact)
    except (
        SceneError,
        UndecidedError,
    ):  # no dynamics at all here (H_env = 0 everywhere, C H + D = 0), or a doubt
        return SweepVariables.of(scene).no_answer()
    return SweepVariables.of(scene).no_answer() if found.undecided else _row(found)


def _chart(scene: Scene, swept: Sequence[Knob], values: Sequence[Expr]) -> Chart:
    given = {x.symbol: value for x, value in zip(swept, values, strict=True)}
    limits = {part: value for x, value in zip(swept, values, strict=True) for part in x.parts}
    known = {p.symbol: p.value for p in scene.parameters}
    d = Distortion.of(scene.chain.at({**known, **given}))
    threshold = scene.threshold.with_limits(limits)
    asked: dict[Key, Signed] = {x: x.function(d) for x in noticed(threshold)}
    asked[PerceptFunction.ENVIRONMENT, Part.REAL] = part_of(d.env_response, Part.REAL)
    asked[PerceptFunction.PERCEIVED, Part.REAL] = part_of(d.perc_response, Part.REAL)
    return chart(asked, *scene.band)


def _row(found: Chart) -> AnswerRow:
    row: AnswerRow = {"method": EXACT, **_step(found)}
    places: Mapping[str, Sequence[Point]] = {
        "environment": changeovers(found, PerceptFunction.ENVIRONMENT),
        "perceived": changeovers(found, PerceptFunction.PERCEIVED),
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
    """The characteristic polynomial in s of a display in a hand, and the denominator of H_perc
    without its zeros at 0."""

    top: Family
    bottom: Family

    def count(self, values: Array) -> tuple[Array, Array]:
        """For each set the number of roots in Re s >= 0, and whether it is proven."""
        powers, decided = (
            Monomials(values),
            within_reach(values, [(self.top.terms,), (self.bottom.terms,)]),
        )
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
    """For each hand of a scene the name of its variable, the numbers of roots, and by which method
    they were found."""
    for place, (hand, curve) in enumerate(zip(scene.hands, curves, strict=True)):
        counts, method = (
            np.full(values.shape[1], UNKNOWN),
            np.full(values.shape[1], EXACT, dtype=np.int8),
        )
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
    """The same for one set, whose values are taken as exactly the binary numbers that the floats
    are."""
    given = {
        x.path: Rational(*Fraction(float(v)).as_integer_ratio())
        for x, v in zip(swept, values, strict=True)
    }
    try:
        at = scene.with_values({x.path: given[x.path] for x in swept if not x.parts})
        with limited(LONGEST):
            found = unstable_roots(at, at.hands[place])
    except (SceneError, UndecidedError):
        return UNKNOWN
    return (INFINITE if found.chain else UNKNOWN) if found.number is None else found.number


_AT_ONCE = 4096
"""Sets: so many that the work arrays stay in the processor's cache."""
_KINDS = (
    (np.float64, np.longdouble) if np.finfo(np.longdouble).nmant in (63, 112) else (np.float64,)
)
"""Of floats: NumPy's longdouble where it is a wider IEEE format, and neither a double by another
name nor a pair of doubles."""


@dataclass(frozen=True)
class Kernel:
    """What a sweep computes, for any values of the swept parameters; can be sent to other
    processes."""

    scene: Scene
    swept: tuple[Knob, ...]
    curves: Curves | None
    band: Band
    hands: tuple[HandCurve | None, ...] = ()

    @classmethod
    def of(cls, scene: Scene, swept: Sequence[Knob]) -> Kernel:
        """Of a scene and the numbers that are swept: curves in floats where there are such, else
        the exact machinery alone."""
        curves = curves_of(scene, swept)
        band = Band.of(*scene.band, curves.step if curves else 1)
        return cls(replace(scene), tuple(swept), curves, band, hand_curves(scene, swept))

    @property
    def told(self) -> SweepVariables:
        """The variables."""
        return SweepVariables.of(self.scene)

    @property
    def has_waves(self) -> bool:
        """Whether there are delays, holds or powers s^alpha: these need sines, which only doubles
        have with a bound."""
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


def _blank(told: SweepVariables, sets: int) -> Columns:
    floats = {name: np.full(sets, ABSENT) for name in told.floats}
    counts = {name: np.full(sets, UNKNOWN, dtype=np.int16) for name in told.counts}
    return {**floats, **counts, "method": np.full(sets, EXACT, dtype=np.int8)}
