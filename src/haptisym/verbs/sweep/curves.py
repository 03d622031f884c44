"""What a sweep asks of a scene: polynomials, or families of functions, with the swept parameters left symbolic.

The polynomials whose zeros answer a sweep, with the swept parameters left symbolic and all other numbers in place.

A criterion is one polynomial, or, for a JND region, the largest of the smallest of functions (``kernel.roots``), each a
product of polynomials that keep their signs between their zeros.

What a sweep asks of a scene with delays, holds or powers s^alpha: the families of functions whose zeros answer it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from sympy import Expr, Integer, Symbol

from haptisym.judge.crossings import Criterion, noticed
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.factors import Level
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, omega
from haptisym.kernel.roots import Lattice, Signed
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.sweep.bernstein import Family, Monomial, family
from haptisym.verbs.sweep.waves import WaveFamily, WaveReader, is_readable, is_trusted

FamilyProduct: TypeAlias = tuple[Family, ...]
_Factors: TypeAlias = list[tuple[Polynomial, int]]


@dataclass(frozen=True)
class ThresholdPolynomial:
    """r^2 - c^2 times its denominator: ``above`` - ``below``, each a product. None of it where r is 0 everywhere."""

    above: FamilyProduct
    below: FamilyProduct


@dataclass(frozen=True)
class SignedProduct:
    """A function as the signs that make its own: ``sign`` times those of polynomials. ``begins_at_0``: it is 0 at omega = 0."""

    sign: int
    factors: tuple[Family, ...]
    begins_at_0: bool


@dataclass(frozen=True)
class FamilyLattice:
    """Positive where for some of the ``terms`` all of its functions are."""

    terms: tuple[tuple[SignedProduct, ...], ...]

    @property
    def factors(self) -> tuple[Family, ...]:
        """Each polynomial once."""
        return tuple(dict.fromkeys(f for term in self.terms for x in term for f in x.factors))

    @property
    def sign(self) -> int:
        """Its sign where there are no polynomials in it."""
        return 1 if any(all(x.sign > 0 for x in term) for term in self.terms) else -1


Excess: TypeAlias = ThresholdPolynomial | FamilyLattice


@dataclass(frozen=True)
class Curves:
    """What is asked of a scene, as polynomials in (omega/scale)^step, or in that and waves (``waves``) with step 1.

    ``excess`` : by the name of the criterion. ``changeovers``: of the environment and as perceived, a product whose zeros are the
    changeovers, None if there can be none.
    ``definite``: what must not vanish on the band, or the zeros of the others are not the answer (poles, double zeros).
    """

    step: int
    excess: Mapping[str, Excess | None]
    changeovers: tuple[FamilyProduct | None, FamilyProduct | None]
    definite: tuple[Family, ...]

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


def sweep_curves(scene: Scene, swept: Sequence[Knob]) -> Curves | None:
    """The curves of a scene; None where they are no polynomials (delays, powers s^alpha), or not for all of the sweep."""
    asked = closed_forms(scene, swept)
    if asked is None or any(f.axis.functions for f in asked.functions):
        return None
    return Reader(scene, swept, asked).curves()


@dataclass(frozen=True)
class ClosedForms:
    """What is judged, whose zeros are the changeovers, and the squares that must not vanish for there to be dynamics."""

    measures: Mapping[Criterion, Signed]
    turning: tuple[RealFunction, ...]
    present: tuple[RealFunction, ...] = ()

    @property
    def functions(self) -> list[RealFunction]:
        """All of them."""
        own = [f for x in self.measures.values() for f in _functions(x) if isinstance(f, RealFunction)]
        return [*self.turning, *self.present, *own]


def closed_forms(scene: Scene, swept: Sequence[Knob]) -> ClosedForms | None:
    """Those of a scene; None where there are no dynamics, a delay needs a number, or a limit is not rational."""
    given = {x.symbol for x in swept}
    chain = scene.chain.at({p.symbol: p.value for p in scene.parameters if p.symbol not in given})
    try:
        d = Distortion.of(chain, Ring.of([*chain.entries(), *LIMITS.values()]))
        measures = {x: _measure(x, d) for x in (_opened(x, swept) for x in noticed(scene.threshold))}
    except HaptisymError:
        return None
    if any(isinstance(f, Level) for x in measures.values() for f in _functions(x)):
        return None
    turning = tuple(part_of(r, Part.REAL) for r in (d.env_response, d.perc_response))
    # where there is a real part its changeovers tell that there are dynamics
    return ClosedForms(measures, turning, () if any(not x.is_zero for x in turning) else (d.squared_modulus,))


LIMITS = {part: Symbol(f"c_{part.value}", positive=True) for part in Part}
"""The symbols of swept limits of regions; a variable that does not occur costs nothing."""


def _opened(x: Criterion, swept: Sequence[Knob]) -> Criterion:
    """With symbols for the limits of a region that are swept; of a part alone they come in as numbers."""
    limits = {part: LIMITS[knob.parts[0]] for knob in swept for part in knob.parts}
    if x.region:
        return replace(x, region=x.region.opened(limits)) if limits else x
    return replace(x, threshold=Integer(1)) if x.part in limits else x


def _measure(x: Criterion, d: Distortion) -> Signed:
    """What is held against one number; of a region, and of a limit that depends on the frequency, what must not be positive."""
    return x.function(d) if x.region or x.threshold.has(omega) else x.measure(d)


def _functions(x: Signed) -> Iterator[RealFunction | Level]:
    yield from ((f for term in x.terms for f in term) if isinstance(x, Lattice) else (x,))


class Reader:
    """Reads the families off the exact closed forms."""

    needs_bounded_ratios = True
    """Whether the denominators of r^2 must not vanish for the zeros found to be crossings."""

    def __init__(self, scene: Scene, swept: Sequence[Knob], asked: ClosedForms) -> None:
        self.scene, self.swept, self.measures, self.turning = scene, swept, asked.measures, asked.turning
        self.present = asked.present
        self.symbols = [LIMITS[x.parts[0]] if x.parts else x.symbol for x in swept]
        self.step = self._step([self._form(f) for f in asked.functions])
        self.definite: list[Family] = []

    def _step(self, forms: Sequence[RationalFunction]) -> int:
        polynomials = [p for f in forms for p in (f.numerator, f.denominator)]
        return 2 if all(int(e[0]) % 2 == 0 for p in polynomials for e in p.monoms()) else 1

    def _form(self, f: RealFunction) -> RationalFunction:
        """The quotient of polynomials that is read."""
        return f.function

    def curves(self) -> Curves | None:
        """What is judged, as functions of the swept numbers; None where floats cannot tell them."""
        excess = {x.name: self._judged(f, x) for x, f in self.measures.items()}
        environment, perceived = map(self._changeover, self.turning)
        for form in map(self._form, self.present):
            self.definite += self._all_but_zero(form.ring, (g for g, _ in form.ring.factors(form.numerator)[1]))
        if self.step == 1 and self.scene.band[0] == 0 and any(map(_odd_at_zero, map(self._form, self.turning))):
            return None  # a function that is odd in omega changes its sign at 0 itself
        return Curves(self.step, excess, (environment, perceived), tuple(dict.fromkeys(self.definite)))

    def _judged(self, measure: Signed, criterion: Criterion) -> Excess | None:
        if isinstance(measure, RealFunction) and not criterion.region and not criterion.threshold.has(omega):
            return self._excess(measure, criterion)
        terms = measure.terms if isinstance(measure, Lattice) else ((measure,),)
        listed = [[f for f in term if isinstance(f, RealFunction)] for term in terms]  # no other are there
        found = tuple(tuple(map(self._signs, term)) for term in listed if not any(f.is_zero for f in term))
        return FamilyLattice(found) if found else None  # where a function is 0 everywhere its term is nowhere positive

    def _signs(self, f: RealFunction) -> SignedProduct:
        form = self._form(f)
        ring = form.ring
        (unit, above), (lower, below) = (ring.factors(p) for p in (form.numerator, form.denominator))
        even = [g for g, n in above if n % 2 == 0]
        self.definite += self._all_but_zero(ring, [*(g for g, _ in below), *even])
        odd = [g for g, n in (*above, *below) if n % 2 and not self._is_trivial(ring, g)]
        factors = tuple(self._family(ring, g, Integer(1)) for g in odd)
        is_0 = self.scene.band[0] == 0 and any(self._is_0_at_0(ring, g) for g, _ in above)
        return SignedProduct(1 if unit * lower > 0 else -1, factors, is_0)

    def _excess(self, f: RealFunction, criterion: Criterion) -> ThresholdPolynomial | None:
        if f.is_zero:
            return None
        form = self._form(f)
        ring = form.ring
        (unit, above), (lower, below) = (ring.factors(p) for p in (form.numerator, form.denominator))
        self.definite += self._all_but_zero(ring, (g for g, _ in below if self.needs_bounded_ratios))
        column = next((i for i, x in enumerate(self.swept) if criterion.depends_on(x.parts)), None)
        if column is None:
            return ThresholdPolynomial(
                self._product(ring, above, unit), self._product(ring, below, lower * criterion.limit)
            )
        square = self._constant(Monomial(0, 1.0, 0.0, tuple(2 * (i == column) for i in range(len(self.swept)))))
        return ThresholdPolynomial(self._product(ring, above, unit), (square, *self._product(ring, below, lower)))

    def _constant(self, value: Monomial) -> Family:
        """Of degree 0."""
        return Family((value,))

    def _changeover(self, f: RealFunction) -> FamilyProduct | None:
        """Zeros of odd order; a zero at omega = 0 of an even function is no change of sign."""
        if f.is_zero:
            return None
        form = self._form(f)
        ring = form.ring
        _, above = ring.factors(form.numerator)
        _, below = ring.factors(form.denominator)
        even = [g for g, n in above if n % 2 == 0]
        self.definite += self._all_but_zero(ring, [*(g for g, _ in below), *even])
        odd = [(g, 1) for g, n in above if n % 2 and not self._is_0_at_0(ring, g)]
        return self._product(ring, odd, Integer(1))

    def _product(self, ring: PolynomialRing, factors: _Factors, unit: Expr) -> FamilyProduct:
        """The families of a product, the unit in the first."""
        powers = [(g**n, 1) if g == ring.variable else (g, n) for g, n in factors] or [(ring.constant(1), 1)]
        numbers = [unit] + [Integer(1)] * sum(n for _, n in powers)
        listed = [g for g, n in powers for _ in range(n)]
        return tuple(self._family(ring, g, number) for g, number in zip(listed, numbers, strict=False))

    def _all_but_zero(self, ring: PolynomialRing, factors: Iterable[Polynomial]) -> list[Family]:
        return [self._family(ring, g, Integer(1)) for g in factors if not self._is_trivial(ring, g)]

    def _is_trivial(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        return bool(factor.is_constant()) or self._is_0_at_0(ring, factor)

    def _is_0_at_0(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        """Whether a factor vanishes at omega = 0, and nowhere else."""
        return bool(factor == ring.variable)

    def _family(self, ring: PolynomialRing, polynomial: Polynomial, number: Expr) -> Family:
        return family(ring, polynomial, self.symbols, self.scene.band[1], self.step, number)


def _odd_at_zero(f: RationalFunction) -> bool:
    """Whether the power of omega in a real function is odd."""
    powers = [n for p in (f.numerator, f.denominator) for g, n in f.ring.factors(p)[1] if g == f.ring.variable]
    return sum(powers) % 2 == 1


def wave_curves(scene: Scene, swept: Sequence[Knob]) -> Curves | None:
    """The curves of a scene; None where they are not made of such functions, or sines are not to be trusted here.

    A power s^alpha needs a number for alpha, a delay a number times powers of parameters.
    """
    asked = closed_forms(scene, swept)
    if asked is None or not is_trusted():
        return None
    functions = asked.functions
    if len({f.half_angled.ring.meanings for f in functions}) > 1 or not is_readable(functions[0]):
        return None
    try:
        return _Reader(scene, swept, asked).curves()
    except HaptisymError:
        return None  # a constant of which too few digits are known


class _Reader(Reader):
    """Reads half-angled forms.

    r^2 = A/B in lowest terms is not negative for any real values of its variables, the tangents and powers among them. So
    no factor of A or B of odd multiplicity changes its sign, and along any frequency A and B have zeros of even order only:
    where B vanishes, A - c^2 B has no simple zero, and nothing need be known of B (``needs_bounded_ratios``).
    """

    needs_bounded_ratios = False

    def __init__(self, scene: Scene, swept: Sequence[Knob], asked: ClosedForms) -> None:
        super().__init__(scene, swept, asked)
        self._waves = WaveReader(self.turning[0], self.symbols, scene.band[1])

    def _step(self, forms: Sequence[RationalFunction]) -> int:
        return 1

    def _form(self, f: RealFunction) -> RationalFunction:
        return f.half_angled

    def _family(self, ring: PolynomialRing, polynomial: Polynomial, number: Expr) -> WaveFamily:
        return self._waves.family(polynomial, number)

    def _constant(self, value: Monomial) -> Family:
        return self._waves.constant(value)

    def _is_0_at_0(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        powers = ring.context.gens()[ring.size : ring.size + len(self._waves.orders)]
        return any(factor == x for x in [ring.variable, *powers])
