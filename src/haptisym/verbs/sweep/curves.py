"""The polynomials whose zeros answer a sweep, with the swept parameters left symbolic and all other numbers in place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from sympy import Expr, Integer, Symbol

from haptisym.judge.criteria import Criterion, noticed
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.sweep.families import Family, Monomial, family

FamilyProduct: TypeAlias = tuple[Family, ...]
_Factors: TypeAlias = list[tuple[Polynomial, int]]


@dataclass(frozen=True)
class ThresholdPolynomial:
    """r^2 - c^2 times its denominator: ``above`` - ``below``, each a product. None of it where r is 0 everywhere."""

    above: FamilyProduct
    below: FamilyProduct


@dataclass(frozen=True)
class Curves:
    """What is asked of a scene, as polynomials in (omega/scale)^step.

    ``excess`` : by the name of the criterion. ``changeovers``: of the environment and as perceived, a product whose zeros are the
    changeovers, None if there can be none.
    ``definite``: what must not vanish on the band, or the zeros of the others are not the answer (poles, double zeros).
    """

    step: int
    excess: Mapping[str, ThresholdPolynomial | None]
    changeovers: tuple[FamilyProduct | None, FamilyProduct | None]
    definite: tuple[Family, ...]

    @property
    def products(self) -> Iterator[FamilyProduct]:
        for e in self.excess.values():
            if e is not None:
                yield from (e.above, e.below)
        yield from (x for x in self.changeovers if x is not None)
        yield from ((x,) for x in self.definite)


def sweep_curves(scene: Scene, swept: Sequence[Knob]) -> Curves | None:
    """The curves of a scene; None where they are no polynomials (delays, powers s^alpha), or not for all of the sweep."""
    given = {x.symbol for x in swept}
    try:
        d = Distortion.of(scene.chain.at({p.symbol: p.value for p in scene.parameters if p.symbol not in given}))
    except HaptisymError:
        return None  # no dynamics at all, or a delay that needs a number
    measures = {x: x.measure(d) for x in noticed(scene.threshold)}
    if d.env.ring.functions or any(f.axis.functions for f in (*measures.values(), *_turning(d))):
        return None
    return _Reader(scene, swept, measures, _turning(d)).curves()


def _turning(d: Distortion) -> list[RealFunction]:
    """Whose zeros are the changeovers."""
    return [part_of(r, Part.REAL) for r in (d.env_response, d.perc_response)]


class _Reader:
    """Reads the families off the exact closed forms."""

    def __init__(
        self,
        scene: Scene,
        swept: Sequence[Knob],
        measures: Mapping[Criterion, RealFunction],
        turning: Sequence[RealFunction],
    ) -> None:
        self.scene, self.swept, self.measures, self.turning = scene, swept, measures, turning
        self.symbols = [Symbol("") if x.parts else x.symbol for x in swept]
        polynomials = [
            p for f in (*measures.values(), *turning) for p in (f.function.numerator, f.function.denominator)
        ]
        self.step = 2 if all(int(e[0]) % 2 == 0 for p in polynomials for e in p.monoms()) else 1
        self.definite: list[Family] = []

    def curves(self) -> Curves | None:
        excess = {x.name: self._excess(f, x) for x, f in self.measures.items()}
        environment, perceived = map(self._changeover, self.turning)
        if self.step == 1 and self.scene.band[0] == 0 and any(map(_odd_at_zero, self.turning)):
            return None  # a function that is odd in omega changes its sign at 0 itself
        return Curves(self.step, excess, (environment, perceived), tuple(dict.fromkeys(self.definite)))

    def _excess(self, f: RealFunction, criterion: Criterion) -> ThresholdPolynomial | None:
        if f.is_zero:
            return None
        ring = f.axis
        (unit, above), (lower, below) = (ring.factors(p) for p in (f.function.numerator, f.function.denominator))
        self.definite += self._all_but_zero(ring, (g for g, _ in below))
        column = next((i for i, x in enumerate(self.swept) if criterion.depends_on(x.parts)), None)
        if column is None:
            return ThresholdPolynomial(
                self._product(ring, above, unit), self._product(ring, below, lower * criterion.limit)
            )
        square = Family((Monomial(0, 1.0, 0.0, tuple(2 * (i == column) for i in range(len(self.swept)))),))
        return ThresholdPolynomial(self._product(ring, above, unit), (square, *self._product(ring, below, lower)))

    def _changeover(self, f: RealFunction) -> FamilyProduct | None:
        """Zeros of odd order; a zero at omega = 0 of an even function is no change of sign."""
        if f.is_zero:
            return None
        ring = f.axis
        _, above = ring.factors(f.function.numerator)
        _, below = ring.factors(f.function.denominator)
        even = [g for g, n in above if n % 2 == 0]
        self.definite += self._all_but_zero(ring, [*(g for g, _ in below), *even])
        odd = [(g, 1) for g, n in above if n % 2 and g != ring.variable]
        return self._product(ring, odd, Integer(1))

    def _product(self, ring: PolynomialRing, factors: _Factors, unit: Expr) -> FamilyProduct:
        """The families of a product, the unit in the first."""
        powers = [(g**n, 1) if g == ring.variable else (g, n) for g, n in factors] or [(ring.constant(1), 1)]
        numbers = [unit] + [Integer(1)] * sum(n for _, n in powers)
        listed = [g for g, n in powers for _ in range(n)]
        return tuple(self._family(ring, g, number) for g, number in zip(listed, numbers, strict=False))

    def _all_but_zero(self, ring: PolynomialRing, factors: Iterable[Polynomial]) -> list[Family]:
        return [self._family(ring, g, Integer(1)) for g in factors if g != ring.variable and not g.is_constant()]

    def _family(self, ring: PolynomialRing, polynomial: Polynomial, number: Expr) -> Family:
        return family(ring, polynomial, self.symbols, self.scene.band[1], self.step, number)


def _odd_at_zero(f: RealFunction) -> bool:
    """Whether the power of omega in a real function is odd."""
    ring = f.axis
    powers = [
        n for p in (f.function.numerator, f.function.denominator) for g, n in ring.factors(p)[1] if g == ring.variable
    ]
    return sum(powers) % 2 == 1
