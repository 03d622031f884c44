"""The answers of a sweep for batches of parameter sets: floats with bounds where they prove it,
exact where they do not.

**What is computed.** The zeros of functions of omega, with the swept parameters left symbolic and
all other numbers in place. A criterion is a difference of two products of functions, or, for a JND
region, the largest of the smallest of products (``kernel.roots.Lattice``), each of which keeps its
sign between the zeros of its factors.

On x = (omega/(high end of the band))^step each function is a ``Family`` (``delayterms``). The step
is 2 where all are polynomials in omega^2. With delays, holds and powers s^alpha it is 1, and forms
are read in half angles: with angles a each is a polynomial in x, cos(a/2), sin(a/2)/omega and
x^alpha.

r^2 = A/B in lowest terms is not negative for any real values of its variables, the tangents and
powers among them. So no factor of A or B of odd multiplicity changes its sign, and along any
frequency A and B have zeros of even order only: where B vanishes, A - c^2 B has no simple zero, and
nothing need be known of B.

**How a set is answered.** The zeros that are proven (``delayterms``) are put in order for each set,
and the answers are read off them (``Pass``). Where the criterion is a region's, its sign between
the zeros is that of the largest of the smallest of its functions (``changes``). Floats are doubles;
what these leave is tried in wider ones where there are no sines and powers, and what is left then
comes from the certified chart of an evaluation (``exact_answers``).

For each hand that holds the display the roots of H_perc + m s^2 + b s + k in Re s >= 0 are counted:
in floats where the characteristic function is a polynomial in s, by Routh's array. H_perc is in
lowest terms for symbols, but perhaps not for a set of values. A zero that both parts of the
quotient then share is no root; there is none in Re s >= 0 where the denominator is proven to have
all its zeros in Re s < 0, those at 0 apart, which the array does not allow. All other sets, and all
that are sampled or have delays or powers of s, are counted exactly. ``Kernel`` is where to begin
reading.
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
    """r^2 - c^2 times its denominator, as the difference ``above`` - ``below`` of two products."""

    above: FamilyProduct
    below: FamilyProduct


@dataclass(frozen=True)
class SignedProduct:
    """A function by its sign: ``sign`` times the signs of its factors. ``begins_at_0``: whether it
    vanishes at omega = 0."""

    sign: int
    factors: tuple[Family, ...]
    begins_at_0: bool


@dataclass(frozen=True)
class FamilyLattice:
    """The largest of the ``terms``, each the smallest of its functions: positive where for some
    term all of its functions are."""

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
    """The functions of a scene whose zeros are wanted, in the variable (omega/scale)^step.

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
        """All products of factors whose signs are needed."""
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
    forms = _closed_forms(scene, swept)
    if forms is None:
        return None
    functions = forms.functions
    has_waves = any(f.axis.functions for f in functions)
    if has_waves and not (is_trusted() and _is_readable(functions)):
        return None
    try:
        return _Curves(scene, swept, forms, has_waves=has_waves).read()
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
    """The functions of a scene with the swept parameters as symbols: by criterion what is judged,
    ``turning``, whose zeros are the changeovers, and ``present``, which is 0 everywhere only where
    there are no dynamics."""

    measures: Mapping[Criterion, Signed]
    turning: tuple[RealFunction, ...]
    present: tuple[RealFunction, ...] = ()

    @property
    def functions(self) -> list[RealFunction]:
        """All of them."""
        measured = [f for x in self.measures.values() for f in _functions(x)]
        return [*self.turning, *self.present, *measured]


def _closed_forms(scene: Scene, swept: Sequence[Knob]) -> _ClosedForms | None:
    """The closed forms of a scene; None where there are no dynamics, a delay needs a number, or a
    limit is not rational."""
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
    # A set without dynamics (H = 0 everywhere) has no answer. Where there is a real part, its zeros
    # are isolated anyway, which fails where it vanishes identically; else |H_env|^2 must not be 0.
    return _ClosedForms(
        measures, turning, () if any(not x.is_zero for x in turning) else (d.squared_modulus,)
    )


_LIMITS = {part: Symbol(f"c_{part.value}", positive=True) for part in Part}
"""The symbols of swept limits of regions; a variable that does not occur costs nothing."""


def _opened(x: Criterion, swept: Sequence[Knob]) -> Criterion:
    """The criterion with symbols for the limits of its region that are swept; a limit of one part
    alone is 1 here, and is multiplied in where the criterion is read."""
    limits = {part: _LIMITS[knob.parts[0]] for knob in swept for part in knob.parts}
    if x.region:
        return replace(x, region=x.region.opened(limits)) if limits else x
    return replace(x, threshold=Integer(1)) if x.part in limits else x


def _measure(x: Criterion, d: Distortion) -> Signed:
    """The square of the ratio, which is compared with one number; for a region, and for a limit
    that depends on the frequency, the function that must not be positive."""
    return x.function(d) if x.region or x.threshold.has(omega) else x.measure(d)


def _functions(x: Signed) -> Iterator[RealFunction]:
    yield from ((f for term in x.terms for f in term) if isinstance(x, Lattice) else (x,))


class _Curves:
    """Reads the families off the exact closed forms of a scene."""

    def __init__(
        self, scene: Scene, swept: Sequence[Knob], asked: _ClosedForms, *, has_waves: bool
    ) -> None:
        self.scene, self.swept, self.asked, self.has_waves = scene, swept, asked, has_waves
        forms = [f.half_angled for f in asked.functions]
        polynomials = [p for f in forms for p in (f.numerator, f.denominator)]
        # In omega^2 a polynomial has half the degree, and fewer roundings.
        is_even = not has_waves and all(int(e[0]) % 2 == 0 for p in polynomials for e in p.monoms())
        self.step = 2 if is_even else 1
        symbols = [_LIMITS[x.parts[0]] if x.parts else x.symbol for x in swept]
        self.reader = FamilyReader(
            symbols, scene.band[1], self.step, asked.turning[0] if has_waves else None
        )
        self.definite: list[Family] = []

    def read(self) -> Curves | None:
        """The curves; None where floats cannot count sign changes at omega = 0."""
        excess = {x.name: self._judged(f, x) for x, f in self.asked.measures.items()}
        environment, perceived = map(self._changeover, self.asked.turning)
        for form in (f.half_angled for f in self.asked.present):
            self.definite += self._all_but_zero(
                form.ring, (g for g, _ in form.ring.factors(form.numerator)[1])
            )
        turning = (f.half_angled for f in self.asked.turning)
        if self.step == 1 and self.scene.band[0] == 0 and any(map(_odd_at_zero, turning)):
            # a function that is odd in omega changes its sign at 0 itself, which no segment shows
            return None
        definite = tuple(dict.fromkeys(self.definite))
        return Curves(self.step, excess, (environment, perceived), definite, self.has_waves)

    def _judged(self, measure: Signed, criterion: Criterion) -> Excess | None:
        """The excess of a criterion as families: a difference of products for one number, else a
        lattice. None where nothing is ever noticed."""
        if (
            isinstance(measure, RealFunction)
            and not criterion.region
            and not criterion.threshold.has(omega)
        ):
            return self._excess(measure, criterion)
        terms = measure.terms if isinstance(measure, Lattice) else ((measure,),)
        # all of them are real functions: this is for the type checker
        listed = [[f for f in term if isinstance(f, RealFunction)] for term in terms]
        # where a function is 0 everywhere, the smallest of its term is nowhere positive
        positive = [term for term in listed if not any(f.is_zero for f in term)]
        read = tuple(tuple(map(self._signs, term)) for term in positive)
        return FamilyLattice(read) if read else None

    def _signs(self, f: RealFunction) -> SignedProduct:
        """The sign of a function as a product of those of its irreducible factors."""
        form = f.half_angled
        ring = form.ring
        (unit, above), (lower, below) = (
            ring.factors(p) for p in (form.numerator, form.denominator)
        )
        even = [g for g, n in above if n % 2 == 0]
        # A pole, and a zero of even order, at which the function is 0 between equal signs, do not
        # fit a list of sign changes: sets with one on the band are left to exact arithmetic.
        self.definite += self._all_but_zero(ring, [*(g for g, _ in below), *even])
        odd = [g for g, n in (*above, *below) if n % 2 and not self._is_trivial(ring, g)]
        factors = tuple(self.reader.family(ring, g) for g in odd)
        is_0 = self.scene.band[0] == 0 and any(self._is_0_at_0(ring, g) for g, _ in above)
        return SignedProduct(1 if unit * lower > 0 else -1, factors, is_0)

    def _excess(self, f: RealFunction, criterion: Criterion) -> ThresholdPolynomial | None:
        """r^2 - c^2 for f = r^2; None where r is 0 everywhere."""
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
            # the limit is swept: c^2 is a monomial in its parameter
            square = Monomial(0, 1.0, 0.0, tuple(2 * (i == column) for i in range(len(self.swept))))
            product = (self.reader.constant(square), *product)
        return ThresholdPolynomial(self._product(ring, above, unit), product)

    def _changeover(self, f: RealFunction) -> FamilyProduct | None:
        """A product whose zeros are those of odd order; None for a function that is 0 everywhere.

        A zero at omega = 0 is left out: an even function does not change its sign there.
        """
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
        """The families of those factors that may vanish at a frequency other than 0."""
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
        """The family of degree 0 in all variables whose only coefficient is this monomial."""
        return Family((value,), self._variables, ((0,) * (1 + self._variables.waves),))

    def family(self, ring: PolynomialRing, polynomial: Polynomial, factor: Expr = S.One) -> Family:
        """The family of ``factor``, a number, times a polynomial."""
        known = {x: i for i, x in enumerate(ring.meanings)}
        columns = [known.get(x) for x in self.parameters]
        with flint.ctx.workprec(BITS):
            unit, constants = expression_ball(factor), dict[tuple[Exponents, Exponents], arb]()
            # Several terms may have one monomial, as powers of pi are constants here. They are
            # added in balls: of floats that cancel no bound on the roundings would be left.
            for given, coefficient in polynomial.to_dict().items():
                row, exponents, ball = self._term([int(n) for n in given], columns, ring.size)
                key = row, exponents
                constants[key] = constants.get(key, arb(0)) + ball * arb(coefficient) * unit
            rows = sorted({row for row, _ in constants})
            place = {row: i for i, row in enumerate(rows)}
            terms = sorted(
                (place[row], exponents, ball)
                for (row, exponents), ball in constants.items()
                if ball != 0
            )
            return Family(tuple(monomial(*term) for term in terms), self._variables, tuple(rows))

    def _term(
        self, given: Sequence[int], columns: Sequence[int | None], start: int
    ) -> tuple[Exponents, Exponents, Any]:
        """The row that a monomial belongs to, its exponents of the parameters, and its constant."""
        assert not given[0] % self.step
        scale = expression_ball(self.scale)
        # a ring's variables are omega, pi, the parameters, then powers of s, then cosine and sine
        # of each angle; omega^n = scale^n x^(n/step)
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
            # The sine over its own angle is bounded at 0, where a family is evaluated too: sin(k
            # omega/2) over omega is k/2 of it.
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
        """The rates of the angles that depend on omega, over the band's high end, and the orders of
        powers."""
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
    """The sign changes of a function for many sets: frequencies, as fractions of the band's high
    end, in ascending order for each set."""

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
        # By set, then by frequency; at the low end itself its own row, of kind -1, comes before
        # zeros there.
        order = np.lexsort((kinds, omega, sets))
        sets, omega, kinds = sets[order], omega[order], kinds[order]
        # From where each set's rows begin: the sign of a function is its first one, turned once for
        # each of its zeros that was passed.
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
        is_low_end: Array = self.kinds < 0
        return is_low_end


def changes(
    lattice: FamilyLattice, zeros: Mapping[Family, PassFrequencies], low: float, near: float
) -> tuple[PassFrequencies, Array]:
    """The frequencies at which the lattice changes its sign, and for which sets these are proven.

    They are not where two zeros lie so near each other (relatively, ``near``) that their order is
    not known, nor where the lattice is 0 between equal signs, as where several of its functions
    have one zero, nor where a function that is 0 at omega = 0 decides there.
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
    # Frequencies are known to ``near`` alone, so that two that close may be in either order, or
    # one.
    close = np.diff(rows.omega) <= near * rows.omega[1:]
    certain[rows.sets[1:][close & ~rows.begins[1:] & ~rows.begins[:-1]]] = False
    for kind, f in enumerate(signs):
        is_zero_of_f = rows.kinds == kind
        there = {g: row[is_zero_of_f] for g, row in signs.items()}
        there[f] = np.zeros(is_zero_of_f.sum(), np.int8)
        # At a zero of f the lattice is 0 exactly where it would be >= 0 but is not > 0 with f = 0.
        # It must be so where its sign changes, and only there: 0 between equal signs is a touch.
        vanishes = _positive(lattice, there, or_0=True) & ~_positive(lattice, there)
        certain[rows.sets[is_zero_of_f][vanishes != changed[is_zero_of_f]]] = False
    begun = {f: row[rows.begins] for f, row in signs.items()}
    # What is 0 at omega = 0 counts there as one sign and as the other: where both give the same,
    # the sign of the lattice does not depend on it.
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
    """Where the lattice is positive; with ``or_0``, where it is positive or 0.

    ``at_0`` : the sign that functions have which vanish at omega = 0; None where that is not meant.
    """

    def of(x: SignedProduct) -> Any:
        has_given_sign = at_0 is not None and x.begins_at_0
        sign = np.full_like(next(iter(signs.values())), at_0 if has_given_sign else x.sign)
        for f in () if has_given_sign else x.factors:
            sign = sign * signs[f]
        return sign >= 0 if or_0 else sign > 0

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
    """A frequency band in the variable of the curves, (omega/high)^step, in which it ends at 1.

    ``high``: rad/s. ``low_fraction``: low end over high end. ``ends``: the low end in the variable,
    or two floats about it.

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
    """The largest float that is not above a number."""
    nearest = float(x)
    return nearest if Fraction(nearest) <= x else float(np.nextafter(nearest, -np.inf))


class Pass:
    """The answers for one batch of parameter sets, in floats of one kind.

    ``decided``: for each set, whether all that is computed of it is proven so far.
    """

    def __init__(self, curves: Curves, band: Band, values: Array) -> None:
        self.curves, self.band, self.sets = curves, band, values.shape[1]
        self.powers = Monomials(values)
        self.decided = within_reach(values, ([f.terms for f in x] for x in curves.products))
        self._factors: dict[Family, FamilyFactor] = {}

    def answers(self) -> tuple[Columns, Array]:
        """All variables, and for which sets they are proven."""
        # what is not finite has no sign, so that the set is not decided
        with np.errstate(all="ignore"):
            self._no_zero_in(self.curves.definite)
            parts = {name: self._crossings(e) for name, e in self.curves.excess.items()}
            turns = [
                self._zeros(None if x is None else self._at(x)) for x in self.curves.changeovers
            ]
        columns: Columns = {"method": np.full(self.sets, FLOAT, dtype=np.int8)}
        for name, crossings in parts.items():
            columns[f"crossings_{name}"], columns[f"first_crossing_{name}"] = self._told(crossings)
        for name, zeros in zip(SYSTEMS, turns, strict=True):
            columns[f"changeovers_{name}"], columns[f"changeover_{name}"] = self._told(zeros)
        return columns | self._transparency(parts, columns), self.decided

    def _at(self, families: FamilyProduct) -> Function:
        """The product of some families, with coefficients and rates for each set."""
        for f in families:
            if f not in self._factors:
                self._factors[f] = FamilyFactor(f, f.at(self.powers))
        variables = families[0].variables
        rates = [self.powers.monomial(x.exponents) * x.constant for x in variables.rates]
        rows = np.array(rates).reshape(-1, self.sets)
        return Function(variables, rows, tuple(self._factors[f] for f in families))

    def _no_zero_in(self, families: Sequence[Family]) -> None:
        """Leave those sets undecided for which one of these functions has a zero on the band."""
        for f in families:
            zeros = self._isolated(self._at((f,)))
            self.decided[zeros.sets] = False

    def _crossings(self, e: Excess | None) -> PassFrequencies:
        """The frequencies at which the sign of a criterion changes."""
        if not isinstance(e, FamilyLattice):
            return self._zeros(None if e is None else self._at(e.above) - self._at(e.below))
        zeros = {f: self._zeros(self._at((f,))) for f in e.factors}
        if not zeros:
            return PassFrequencies(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, e.sign))
        crossings, certain = changes(e, zeros, self.band.low_fraction, 4 * TOLERANCE)
        self.decided &= certain
        return crossings

    def _isolated(self, f: Function) -> Zeros:
        """The zeros of a function on the band, each alone in its enclosure."""
        edges = (*self.band.ends, 1.0)
        zeros = isolate(f, edges, first_is_doubt=self.band.doubtful)
        self.decided &= zeros.decided
        return zeros

    def _zeros(self, f: Function | None) -> PassFrequencies:
        """The zeros of a function to the promised accuracy; None stands for one that is negative
        everywhere, as r^2 - c^2 for r = 0."""
        if f is None:
            return PassFrequencies(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, -1))
        isolated = self._isolated(f)
        x, proven = refine(f.of(isolated.sets), isolated.low, isolated.high, NARROWER)
        self.decided[isolated.sets[~proven]] = False
        omega = (np.sqrt(x) if self.curves.step == 2 else x).astype(float)
        # segments overlap by a unit in the last place, where a zero would be found twice
        close = np.diff(omega) < 4 * TOLERANCE * omega[1:]
        is_same_set = np.diff(isolated.sets) == 0
        self.decided[isolated.sets[1:][close & is_same_set]] = False
        return PassFrequencies(isolated.sets, omega, isolated.first)

    def _told(self, zeros: PassFrequencies) -> tuple[Array, Array]:
        """For each set the number of zeros and the first one, rad/s."""
        column = np.full(self.sets, ABSENT)
        begins = np.ones(len(zeros.sets), dtype=bool)
        begins[1:] = zeros.sets[1:] != zeros.sets[:-1]
        column[zeros.sets[begins]] = zeros.omega[begins] * self.band.high
        return np.bincount(zeros.sets, minlength=self.sets), column

    def _transparency(self, parts: Mapping[str, PassFrequencies], columns: Columns) -> Columns:
        """Bandwidth and transparent share of the band: a criterion that is positive at the low end
        leaves no bandwidth; else it ends at the first crossing of any, or with the band."""
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

# s for one set. A sweep has very many: one that is harder is left without an answer.
LONGEST = 10.0


def exact_answers(scene: Scene, swept: Sequence[Knob], values: Sequence[float]) -> AnswerRow:
    """All variables of a sweep for one set of values, which are taken as exactly the binary numbers
    that the floats are; the row of a set without answers where that takes longer than ``LONGEST``
    seconds.
    """
    exact = [Rational(*Fraction(float(x)).as_integer_ratio()) for x in values]
    try:
        with limited(LONGEST):
            table = _chart(scene, swept, exact)
    # no dynamics at all here (H_env = 0 everywhere, C H + D = 0), or a doubt
    except (SceneError, UndecidedError):
        return SweepVariables.of(scene).no_answer()
    return SweepVariables.of(scene).no_answer() if table.undecided else _row(table)


def _chart(scene: Scene, swept: Sequence[Knob], values: Sequence[Expr]) -> Chart:
    """The certified zeros and signs of all functions of a scene for one set of values."""
    pairs = list(zip(swept, values, strict=True))
    given = {x.symbol: value for x, value in pairs}
    limits = {part: value for x, value in pairs for part in x.parts}
    known = {p.symbol: p.value for p in scene.parameters}
    chain = scene.chain.at({**known, **given})
    d = Distortion.of(chain)
    threshold = scene.threshold.with_limits(limits)
    asked: dict[Key, Signed] = {x: x.function(d) for x in noticed(threshold)}
    environment, perceived = d.env_response, d.perc_response
    asked[PerceptFunction.ENVIRONMENT, Part.REAL] = part_of(environment, Part.REAL)
    asked[PerceptFunction.PERCEIVED, Part.REAL] = part_of(perceived, Part.REAL)
    return chart(asked, *scene.band)


def _row(table: Chart) -> AnswerRow:
    """All variables of a set but those of hands, read off its chart."""
    row: AnswerRow = {"method": EXACT, **_step(table)}
    places: Mapping[str, Sequence[Point]] = {
        "environment": changeovers(table, PerceptFunction.ENVIRONMENT),
        "perceived": changeovers(table, PerceptFunction.PERCEIVED),
    }
    for name, points in places.items():
        row[f"changeovers_{name}"] = len(points)
        row[f"changeover_{name}"] = _first(points)
    return row


def _step(table: Chart) -> AnswerRow:
    """The variables of step 1, when something is noticed: crossings, bandwidth, transparent
    share."""
    row: AnswerRow = {}
    for x in judged(table):
        points = [p for p in table.points if p.orders.get(x, 0) > 0]
        row[f"crossings_{x.name}"] = len(points)
        row[f"first_crossing_{x.name}"] = _first(points)
    intervals = kept(table)
    low, high = (float(table.points[i].omega) for i in (0, -1))
    clear = sum(float(x.high.omega) - float(x.low.omega) for x in intervals)
    begins = intervals and intervals[0].low is table.points[0]
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
        powers = Monomials(values)
        decided = within_reach(values, [(self.top.terms,), (self.bottom.terms,)])
        # A zero that both parts share for these values is no root. It cannot be one in Re s >= 0
        # where the denominator is proven to have none there: else the set is counted exactly.
        counts, certain = count_right(self.top.polynomial(powers))
        poles, proper = count_right(self.bottom.polynomial(powers))
        return counts, decided & certain & proper & (poles == 0)


def hand_curves(scene: Scene, swept: Sequence[Knob]) -> tuple[HandCurve | None, ...]:
    """The characteristic polynomial for each hand of a scene; None for one that is no polynomial in
    s, as of sampled or delayed displays."""
    return tuple(None if clocks(scene) else _curve(scene, hand, swept) for hand in scene.hands)


def _curve(scene: Scene, hand: Hand, swept: Sequence[Knob]) -> HandCurve | None:
    """The characteristic polynomial of a display in one hand; None where it is no polynomial, or 0
    everywhere."""
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
    # Zeros at s = 0 lie on the axis, where Routh's array counts nothing: of those that numerator
    # and denominator share, being no roots, exact arithmetic decides.
    lowest = min(int(exponents[0]) for exponents in bottom.monoms())

    reader = FamilyReader([x.symbol for x in swept], Integer(1))
    return HandCurve(reader.family(ring, top), reader.family(ring, bottom / ring.variable**lowest))


def held(
    scene: Scene, swept: Sequence[Knob], curves: Sequence[HandCurve | None], values: Array
) -> Iterator[tuple[str, Array, Array]]:
    """For each hand of a scene the name of its variable, the numbers of roots, and by which method
    they were found."""
    for place, (hand, curve) in enumerate(zip(scene.hands, curves, strict=True)):
        counts = np.full(values.shape[1], UNKNOWN)
        method = np.full(values.shape[1], EXACT, dtype=np.int8)
        for wide in _KINDS if curve else ():
            assert curve
            left = np.flatnonzero(method == EXACT)
            numbers, proven = curve.count(values[:, left].astype(wide))
            counts[left[proven]], method[left[proven]] = numbers[proven], FLOAT
        for i in np.flatnonzero(method == EXACT):
            counts[i] = exact_count(scene, place, swept, values[:, i].tolist())
            method[i] = OPEN if counts[i] == UNKNOWN else EXACT
        yield held_name(scene, hand), counts, method


def exact_count(scene: Scene, place: int, swept: Sequence[Knob], values: Sequence[float]) -> int:
    """The number of roots in Re s >= 0 in one hand for one set, whose values are taken as exactly
    the binary numbers that the floats are; UNKNOWN where it stays undecided."""
    given = {
        x.path: Rational(*Fraction(float(v)).as_integer_ratio())
        for x, v in zip(swept, values, strict=True)
    }
    try:
        at = scene.with_values({x.path: given[x.path] for x in swept if not x.parts})
        with limited(LONGEST):
            roots = unstable_roots(at, at.hands[place])
    except (SceneError, UndecidedError):
        return UNKNOWN
    if roots.number is not None:
        return roots.number
    return INFINITE if roots.chain else UNKNOWN


_AT_ONCE = 4096
"""Sets: so many that the work arrays stay in the processor's cache."""
_KINDS = (
    (np.float64, np.longdouble) if np.finfo(np.longdouble).nmant in (63, 112) else (np.float64,)
)
"""Of floats: NumPy's longdouble where it is a wider IEEE format, and neither a double by another
name nor a pair of doubles."""


@dataclass(frozen=True)
class Kernel:
    """Computes the variables of a sweep for any values of the swept parameters; can be sent to
    other processes."""

    scene: Scene
    swept: tuple[Knob, ...]
    curves: Curves | None
    band: Band
    hands: tuple[HandCurve | None, ...] = ()

    @classmethod
    def of(cls, scene: Scene, swept: Sequence[Knob]) -> Kernel:
        """The kernel of a scene and the numbers that are swept: with curves in floats where there
        are such, else for exact arithmetic alone."""
        curves = curves_of(scene, swept)
        band = Band.of(*scene.band, curves.step if curves else 1)
        return cls(replace(scene), tuple(swept), curves, band, hand_curves(scene, swept))

    @property
    def told(self) -> SweepVariables:
        """The variables that are computed of each set."""
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
        """The columns with the root counts in each hand; the method of a set is the slowest that
        any of its numbers took."""
        for name, counts, method in held(self.scene, self.swept, self.hands, values):
            columns[name] = counts
            columns["method"] = np.maximum(columns["method"], method)
        return columns

    def in_floats(self, values: Array) -> tuple[Columns, Array]:
        """The variables but for hands, where floats prove them, and the numbers of the sets that
        floats leave undecided."""
        # doubles first, wider floats for what is left; with sines only doubles have a known error
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
            answers, decided = Pass(self.curves, self.band, values[:, some]).answers()
            for name, column in answers.items():
                columns[name][some[decided]] = column[decided]
            rest.append(some[~decided])
        return np.concatenate(rest)


def _blank(told: SweepVariables, sets: int) -> Columns:
    floats = {name: np.full(sets, ABSENT) for name in told.floats}
    counts = {name: np.full(sets, UNKNOWN, dtype=np.int16) for name in told.counts}
    return {**floats, **counts, "method": np.full(sets, EXACT, dtype=np.int8)}
