"""What a sweep asks of a scene: functions of omega whose zeros answer it, with the swept parameters left symbolic.

All other numbers are in place. A criterion is a difference of two products of functions, or, for a JND region, the largest of
the smallest of products (``kernel.lattices``), each of which keeps its sign between the zeros of its factors.

On x = (omega/(high end of the band))^step each function is a ``Family`` (``waves``). The step is 2 where all are polynomials
in omega^2. With delays, holds and powers s^alpha it is 1, and forms are read in half angles: with angles a each is a
polynomial in x, cos(a/2), sin(a/2)/omega and x^alpha.

r^2 = A/B in lowest terms is not negative for any real values of its variables, the tangents and powers among them. So no
factor of A or B of odd multiplicity changes its sign, and along any frequency A and B have zeros of even order only: where B
vanishes, A - c^2 B has no simple zero, and nothing need be known of B.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer, S, Symbol

from haptisym.judge.crossings import Criterion, noticed
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.factors import Level
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, omega
from haptisym.kernel.roots import Lattice, Signed
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.sweep.batch import BITS, Monomial, monomial
from haptisym.verbs.sweep.waves import Exponents, Family, Variables, is_trusted

FamilyProduct: TypeAlias = tuple[Family, ...]
_Factors: TypeAlias = list[tuple[Polynomial, int]]


@dataclass(frozen=True)
class ThresholdPolynomial:
    """r^2 - c^2 times its denominator: ``above`` - ``below``, each a product. None of it where r is 0 everywhere."""

    above: FamilyProduct
    below: FamilyProduct


@dataclass(frozen=True)
class SignedProduct:
    """A function as the signs that make its own: ``sign`` times those of factors. ``begins_at_0``: it is 0 at omega = 0."""

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

    ``excess`` : by the name of the criterion. ``changeovers``: of the environment and as perceived, a product whose zeros are the
    changeovers, None if there can be none. ``definite``: what must not vanish on the band, or the zeros of the others are not the
    answer (poles, double zeros). ``has_waves`` : whether there are delays, holds or powers s^alpha.
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
    """The curves of a scene; None where it has none, a limit is not rational, or sines are needed and not to be trusted here.

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
    """What is judged, whose zeros are the changeovers, and the squares that must not vanish for there to be dynamics."""

    measures: Mapping[Criterion, Signed]
    turning: tuple[RealFunction, ...]
    present: tuple[RealFunction, ...] = ()

    @property
    def functions(self) -> list[RealFunction]:
        """All of them."""
        own = [f for x in self.measures.values() for f in _functions(x) if isinstance(f, RealFunction)]
        return [*self.turning, *self.present, *own]


def _closed_forms(scene: Scene, swept: Sequence[Knob]) -> _ClosedForms | None:
    """Those of a scene; None where there are no dynamics, a delay needs a number, or a limit is not rational."""
    given = {x.symbol for x in swept}
    chain = scene.chain.at({p.symbol: p.value for p in scene.parameters if p.symbol not in given})
    try:
        d = Distortion.of(chain, Ring.of([*chain.entries(), *_LIMITS.values()]))
        measures = {x: _measure(x, d) for x in (_opened(x, swept) for x in noticed(scene.threshold))}
    except HaptisymError:
        return None
    if any(isinstance(f, Level) for x in measures.values() for f in _functions(x)):
        return None
    turning = tuple(part_of(r, Part.REAL) for r in (d.env_response, d.perc_response))
    # where there is a real part its changeovers tell that there are dynamics
    return _ClosedForms(measures, turning, () if any(not x.is_zero for x in turning) else (d.squared_modulus,))


_LIMITS = {part: Symbol(f"c_{part.value}", positive=True) for part in Part}
"""The symbols of swept limits of regions; a variable that does not occur costs nothing."""


def _opened(x: Criterion, swept: Sequence[Knob]) -> Criterion:
    """With symbols for the limits of a region that are swept; of a part alone they come in as numbers."""
    limits = {part: _LIMITS[knob.parts[0]] for knob in swept for part in knob.parts}
    if x.region:
        return replace(x, region=x.region.opened(limits)) if limits else x
    return replace(x, threshold=Integer(1)) if x.part in limits else x


def _measure(x: Criterion, d: Distortion) -> Signed:
    """What is held against one number; of a region, and of a limit that depends on the frequency, what must not be positive."""
    return x.function(d) if x.region or x.threshold.has(omega) else x.measure(d)


def _functions(x: Signed) -> Iterator[RealFunction | Level]:
    yield from ((f for term in x.terms for f in term) if isinstance(x, Lattice) else (x,))


class _Curves:
    """Reads the families off the exact closed forms."""

    def __init__(self, scene: Scene, swept: Sequence[Knob], asked: _ClosedForms, *, has_waves: bool) -> None:
        self.scene, self.swept, self.asked, self.has_waves = scene, swept, asked, has_waves
        forms = [f.half_angled for f in asked.functions]
        polynomials = [p for f in forms for p in (f.numerator, f.denominator)]
        is_even = not has_waves and all(int(e[0]) % 2 == 0 for p in polynomials for e in p.monoms())
        self.step = 2 if is_even else 1
        symbols = [_LIMITS[x.parts[0]] if x.parts else x.symbol for x in swept]
        self.reader = FamilyReader(symbols, scene.band[1], self.step, asked.turning[0] if has_waves else None)
        self.definite: list[Family] = []

    def read(self) -> Curves | None:
        """What is judged, as functions of the swept numbers; None where floats cannot tell them."""
        excess = {x.name: self._judged(f, x) for x, f in self.asked.measures.items()}
        environment, perceived = map(self._changeover, self.asked.turning)
        for form in (f.half_angled for f in self.asked.present):
            self.definite += self._all_but_zero(form.ring, (g for g, _ in form.ring.factors(form.numerator)[1]))
        turning = (f.half_angled for f in self.asked.turning)
        if self.step == 1 and self.scene.band[0] == 0 and any(map(_odd_at_zero, turning)):
            return None  # a function that is odd in omega changes its sign at 0 itself
        definite = tuple(dict.fromkeys(self.definite))
        return Curves(self.step, excess, (environment, perceived), definite, self.has_waves)

    def _judged(self, measure: Signed, criterion: Criterion) -> Excess | None:
        if isinstance(measure, RealFunction) and not criterion.region and not criterion.threshold.has(omega):
            return self._excess(measure, criterion)
        terms = measure.terms if isinstance(measure, Lattice) else ((measure,),)
        listed = [[f for f in term if isinstance(f, RealFunction)] for term in terms]  # no other are there
        found = tuple(tuple(map(self._signs, term)) for term in listed if not any(f.is_zero for f in term))
        return FamilyLattice(found) if found else None  # where a function is 0 everywhere its term is nowhere positive

    def _signs(self, f: RealFunction) -> SignedProduct:
        form = f.half_angled
        ring = form.ring
        (unit, above), (lower, below) = (ring.factors(p) for p in (form.numerator, form.denominator))
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
        (unit, above), (lower, below) = (ring.factors(p) for p in (form.numerator, form.denominator))
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
        powers = [(g**n, 1) if g == ring.variable else (g, n) for g, n in factors] or [(ring.constant(1), 1)]
        listed = [g for g, n in powers for _ in range(n)]
        return tuple(self.reader.family(ring, g, Integer(1) if i else unit) for i, g in enumerate(listed))

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
    powers = [n for p in (f.numerator, f.denominator) for g, n in f.ring.factors(p)[1] if g == f.ring.variable]
    return sum(powers) % 2 == 1


class FamilyReader:
    """Reads polynomials of a ring, the ``parameters`` being the only symbols in them, as families on (omega/scale)^step.

    ``function`` : one whose axis has the angles and powers that are variables of the ring; None where there are none.
    """

    def __init__(
        self, parameters: Sequence[Symbol], scale: Expr, step: int = 1, function: RealFunction | None = None
    ) -> None:
        self.parameters, self.scale, self.step = tuple(parameters), scale, step
        self.orders, self.angles = (function.axis.orders, function.axis.angles) if function else ((), ())
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
            terms = sorted((place[row], exponents, ball) for (row, exponents), ball in found.items() if ball != 0)
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
        ball = arb(coefficient) / arb(f.denominator.leading_coefficient()) * arb.pi() ** int(given[1]) / 2
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
