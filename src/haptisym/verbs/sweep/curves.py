"""Which functions of omega decide the answers of a sweep, for all parameter sets at once?

**The functions** (``Curves``). Swept parameters are symbols in them; all other numbers are in
place. H_env and H_perc are the dynamics (force over position) of the environment and as it is felt
at the hand, (A H_env + B)/(C H_env + D) with the entries A to D of the scene's chain matrix.

- The *excess* of each criterion changes its sign at a crossing. It is r^2 - c^2, with the ratio r
  = |Re (H_perc - H_env)|/|H_env| (or Im) and the JND c; or, for a JND region, a *lattice*: the
  maximum over terms of the minimum of several functions, positive outside of the region
  (``kernel.roots.Lattice``).
- The real parts of H_env and H_perc change their signs at *changeovers*.

Each is a product of irreducible factors, or for r^2 - c^2 a difference of two products, and keeps
its sign between the zeros of its factors. Each factor is a *family* (``delayterms.Family``): a
polynomial in x = (omega/(high end of the band))^step, and in waves, whose coefficients are
polynomials in the parameters (``familyreader``). The step is 2 where all factors are polynomials in
omega^2, else 1. *Waves* are delays, holds and powers s^alpha.

**Why the denominator of r^2 is not needed.** Let r^2 = A/B in lowest terms, the leading coefficient
of B being 1. For all real values of its variables, the tangents and powers among them, A/B is not
negative. So no irreducible factor of A or B of odd multiplicity changes its sign: A/B would be
negative on one side. Hence B >= 0, r^2 - c^2 has the sign of A - c^2 B, and along the frequency
axis A and B have zeros of even order only. At a zero of B there are two cases. If A > 0, A - c^2 B
is positive too. If A vanishes as well (A and B have no common factor, but a common point), then to
an even order, so that A - c^2 B has there at least order 2, or 3 and more if the leading terms
cancel: no simple zero, and a set with a zero that is not simple is left undecided by
``delayterms.isolate``. So nothing need be known of B.

**Guaranteed**: the functions are those of the scene exactly, up to positive factors; constants are
balls around the true numbers. Begin with ``curves_of``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

from sympy import Expr, Integer, Rational, Symbol

from haptisym.judge.crossings import Criterion, noticed
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, omega
from haptisym.kernel.roots import Lattice, Signed
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.parameters import Parameter
from haptisym.model.parameters import values as values_of
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.sweep.batch import Monomial
from haptisym.verbs.sweep.delayterms import Family, is_trusted
from haptisym.verbs.sweep.familyreader import FamilyReader

_LIMIT_SYMBOLS = {part: Symbol(f"c_{part.value}", positive=True) for part in Part}
"""Symbols for the swept limits of regions; a variable that does not occur costs nothing."""

FamilyProduct: TypeAlias = tuple[Family, ...]
"""The factors of a product, each as often as it stands there."""
TwoProducts: TypeAlias = tuple[FamilyProduct, FamilyProduct]
"""A function whose sign is asked for: a product, minus another one, which is 0 if it is empty."""
_Factors: TypeAlias = Sequence[tuple[Polynomial, int]]
"""Irreducible polynomials of a ring with their multiplicities."""


# The functions, as families.


@dataclass(frozen=True)
class ThresholdPolynomial:
    """r^2 - c^2 times its denominator, which is not negative: the difference ``above`` - ``below``
    of two products."""

    above: FamilyProduct
    below: FamilyProduct


@dataclass(frozen=True)
class SignedProduct:
    """A function by its sign: ``sign``, 1 or -1, times the signs of its factors. ``vanishes_at_0``
    : whether it vanishes at omega = 0, where the band begins."""

    sign: int
    factors: FamilyProduct
    vanishes_at_0: bool


@dataclass(frozen=True)
class FamilyLattice:
    """The maximum over ``terms`` of the minimum of the functions of each: positive where for some
    term all of its functions are."""

    terms: tuple[tuple[SignedProduct, ...], ...]

    @property
    def factors(self) -> FamilyProduct:
        """All factors of all functions, each once."""
        factors: dict[Family, None] = {}
        for term in self.terms:
            for function in term:
                factors.update(dict.fromkeys(function.factors))
        return tuple(factors)

    @property
    def sign(self) -> int:
        """Its sign, 1 or -1, where no function has a factor."""
        has_positive_term = any(all(x.sign > 0 for x in term) for term in self.terms)
        return 1 if has_positive_term else -1


Excess: TypeAlias = ThresholdPolynomial | FamilyLattice
"""What is positive where a criterion is broken."""


@dataclass(frozen=True)
class Curves:
    """The functions of a scene whose zeros are wanted, in the variable (omega/scale)^step.

    ``excess`` : by the name of the criterion; None where nothing is ever noticed. ``changeovers`` :
    of the environment and as perceived, a product whose zeros are the changeovers; None if there
    can be none. ``nonzero`` : families that must not vanish on the band, or the zeros of the others
    are not the answer (poles, zeros of even order).
    ``has_waves`` : whether there are delays, holds or powers s^alpha.
    """

    step: int
    excess: Mapping[str, Excess | None]
    changeovers: tuple[FamilyProduct | None, FamilyProduct | None]
    nonzero: FamilyProduct
    has_waves: bool

    @property
    def functions(self) -> Iterator[TwoProducts]:
        """All functions whose signs are needed."""
        for excess in self.excess.values():
            if isinstance(excess, FamilyLattice):
                yield from (((f,), ()) for f in excess.factors)
            elif excess is not None:
                yield excess.above, excess.below
        yield from ((x, ()) for x in self.changeovers if x is not None)
        yield from (((x,), ()) for x in self.nonzero)


def curves_of(scene: Scene, swept: Sequence[Knob]) -> Curves | None:
    """The curves of a scene. None where exact arithmetic is left alone: where the scene has no
    closed forms, a limit is not rational, too few digits of a constant are known, or there are
    waves and floats are not to be trusted with them here.

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
        return _CurveReader(scene, swept, forms, has_waves=has_waves).read()
    # Too few digits of a constant are known, or a polynomial is too large to expand.
    except HaptisymError:
        return None


def _is_readable(functions: Sequence[RealFunction]) -> bool:
    """Whether every exponent of a power of s is a number, every delay a number times powers of
    parameters, and all functions are in one ring."""
    ring, axis = functions[0].half_angled.ring, functions[0].axis
    if len({f.half_angled.ring.meanings for f in functions}) != 1:
        return False
    if not all(x.is_number for x in axis.orders):
        return False
    lags = [ring.convert(x).reduced() for x in axis.lags]
    return all(len(f.numerator) == 1 and f.denominator.is_constant() for f in lags)


@dataclass(frozen=True)
class _ClosedForms:
    """The functions of a scene with the swept parameters as symbols.

    ``judged`` : by criterion the function that is judged. ``real_parts`` : of H_env and H_perc,
    whose sign changes are the changeovers. ``present`` : functions that are 0 everywhere only where
    there are no dynamics, if the real parts do not show that.
    """

    judged: Mapping[Criterion, Signed]
    real_parts: tuple[RealFunction, ...]
    present: tuple[RealFunction, ...] = ()

    @property
    def functions(self) -> list[RealFunction]:
        """All of them."""
        of_criteria = [f for x in self.judged.values() for f in _functions(x)]
        return [*self.real_parts, *self.present, *of_criteria]


def _closed_forms(scene: Scene, swept: Sequence[Knob]) -> _ClosedForms | None:
    """The closed forms of a scene; None where there are no dynamics, a delay needs a number, or a
    limit is not rational."""
    chain = scene.chain.at(fixed_values(scene.parameters, swept))
    judged_functions: dict[Criterion, Signed] = {}
    try:
        ring = Ring.of([*chain.entries(), *_LIMIT_SYMBOLS.values()])
        d = Distortion.of(chain, ring)
        for x in noticed(scene.threshold):
            criterion = _with_limit_symbols(x, swept)
            judged_functions[criterion] = _judged_function(criterion, d)
    # No dynamics at all (H_env = 0 everywhere, or a chain divided by 0), a delay that is a symbol
    # in a sum, a limit that is not rational, or a formula too large to expand: exact arithmetic
    # says which, for each set.
    except HaptisymError:
        return None
    responses = (d.env_response, d.perc_response)
    real_parts = tuple(part_of(x, Part.REAL) for x in responses)
    # A set without dynamics (H = 0 everywhere) has no answer. Where there is a real part, its zeros
    # are isolated anyway, which fails where it vanishes identically; else |H_env|^2 must not be 0.
    has_real_part = any(not x.is_zero for x in real_parts)
    return _ClosedForms(judged_functions, real_parts, () if has_real_part else (d.squared_modulus,))


def fixed_values(parameters: Iterable[Parameter], swept: Sequence[Knob]) -> dict[Symbol, Expr]:
    """The values of those parameters that are not swept, by their symbols."""
    given = {x.symbol for x in swept}
    return values_of(p for p in parameters if p.symbol not in given)


def _with_limit_symbols(x: Criterion, swept: Sequence[Knob]) -> Criterion:
    """The criterion with symbols for the limits of its region that are swept.

    A limit c of one part alone is 1 here, and c^2 a factor of its own in
    ``_CurveReader._threshold_polynomial``: r^2 then holds no c, and is factored once. The reader's
    parameters are, in the order of ``swept``, these symbols and those of the scene.
    """
    limits = {part: _LIMIT_SYMBOLS[knob.parts[0]] for knob in swept for part in knob.parts}
    if x.region:
        return replace(x, region=x.region.opened(limits)) if limits else x
    return replace(x, threshold=Integer(1)) if x.part in limits else x


def _judged_function(x: Criterion, d: Distortion) -> Signed:
    """The square of the ratio, which is compared with one number; for a region, and for a limit
    that depends on the frequency, the function that must not be positive."""
    if x.region or x.threshold.has(omega):
        return x.function(d)
    return x.measure(d)


def _functions(x: Signed) -> Iterator[RealFunction]:
    """The real functions that a judged function is made of: those of a lattice, or it alone."""
    if isinstance(x, Lattice):
        for term in x.terms:
            yield from term
    else:
        yield x


class _CurveReader:
    """Reads the families off the exact closed forms of a scene, for one call of ``read``.

    ``nonzero`` : gathers the families that must not vanish on the band.
    """

    def __init__(
        self, scene: Scene, swept: Sequence[Knob], forms: _ClosedForms, *, has_waves: bool
    ) -> None:
        self.scene, self.swept = scene, swept
        self.forms, self.has_waves = forms, has_waves
        self.begins_at_0 = scene.band[0] == 0
        polynomials: list[Polynomial] = []
        for f in forms.functions:
            form = f.half_angled
            polynomials += [form.numerator, form.denominator]
        # In omega^2 a polynomial has half the degree, and fewer roundings.
        self.step = 2 if not has_waves and all(map(_is_even, polynomials)) else 1
        symbols = [_LIMIT_SYMBOLS[x.parts[0]] if x.parts else x.symbol for x in swept]
        self.reader = FamilyReader(
            symbols, scene.band[1], self.step, forms.real_parts[0] if has_waves else None
        )
        self.nonzero: list[Family] = []

    def read(self) -> Curves | None:
        """The curves; None where floats cannot count sign changes at omega = 0."""
        excess = {x.name: self._excess(f, x) for x, f in self.forms.judged.items()}
        environment, perceived = map(self._changeovers, self.forms.real_parts)
        for form in (f.half_angled for f in self.forms.present):
            factors = form.ring.factors(form.numerator)[1]
            self._need_nonzero(form.ring, (g for g, _ in factors))
        if self.step == 1 and self.begins_at_0:
            # A function that is odd in omega changes its sign at 0 itself, which no segment shows.
            real_parts = (f.half_angled for f in self.forms.real_parts)
            if any(map(_is_odd_at_0, real_parts)):
                return None
        nonzero = tuple(dict.fromkeys(self.nonzero))
        return Curves(self.step, excess, (environment, perceived), nonzero, self.has_waves)

    def _excess(self, function: Signed, criterion: Criterion) -> Excess | None:
        """The excess of a criterion as families: a difference of products where r^2 is compared
        with one number, else a lattice. None where nothing is ever noticed."""
        if (
            isinstance(function, RealFunction)
            and not criterion.region
            and not criterion.threshold.has(omega)
        ):
            return self._threshold_polynomial(function, criterion)
        terms = function.terms if isinstance(function, Lattice) else ((function,),)
        read: list[tuple[SignedProduct, ...]] = []
        for term in terms:
            # All of them are real functions: this is for the type checker.
            listed = [f for f in term if isinstance(f, RealFunction)]
            # Where a function is 0 everywhere, the minimum of its term is nowhere positive.
            if not any(f.is_zero for f in listed):
                read.append(tuple(map(self._signed_product, listed)))
        return FamilyLattice(tuple(read)) if read else None

    def _signed_product(self, f: RealFunction) -> SignedProduct:
        """The sign of a function as a product of those of its irreducible factors."""
        x = _FactoredForm.of(f)
        self._need_sign_changes_alone(x)
        factors: list[Family] = []
        for g, n in (*x.numerator, *x.denominator):
            if n % 2 and not self._has_no_zero_above_0(x.ring, g):
                factors.append(self.reader.family(x.ring, g))
        has_power = any(self._is_power(x.ring, g) for g, _ in x.numerator)
        sign = 1 if x.unit * x.lower_unit > 0 else -1
        return SignedProduct(sign, tuple(factors), self.begins_at_0 and has_power)

    def _threshold_polynomial(
        self, f: RealFunction, criterion: Criterion
    ) -> ThresholdPolynomial | None:
        """r^2 - c^2 for f = r^2; None where r is 0 everywhere."""
        if f.is_zero:
            return None
        x = _FactoredForm.of(f)
        is_limit = [criterion.depends_on(knob.parts) for knob in self.swept]
        if not any(is_limit):
            below = self._product(x.ring, x.denominator, x.lower_unit * criterion.limit)
        else:
            # The limit c is swept: c^2 is a monomial in its parameter, the first one of these, with
            # the constant 1, which is exact.
            exponents = [0] * len(self.swept)
            exponents[is_limit.index(True)] = 2
            c_squared = Monomial(power=0, constant=1.0, rest=0.0, exponents=tuple(exponents))
            square = self.reader.constant(c_squared)
            below = (square, *self._product(x.ring, x.denominator, x.lower_unit))
        return ThresholdPolynomial(self._product(x.ring, x.numerator, x.unit), below)

    def _changeovers(self, f: RealFunction) -> FamilyProduct | None:
        """A product whose zeros are those of odd order of f; None for a function that is 0
        everywhere.

        A zero at omega = 0 is left out: an even function does not change its sign there.
        """
        if f.is_zero:
            return None
        x = _FactoredForm.of(f)
        self._need_sign_changes_alone(x)
        odd: list[tuple[Polynomial, int]] = []
        for g, n in x.numerator:
            if n % 2 and not self._is_power(x.ring, g):
                odd.append((g, 1))
        return self._product(x.ring, odd, Integer(1))

    def _product(self, ring: PolynomialRing, factors: _Factors, unit: Expr) -> FamilyProduct:
        """The families of a product of factors and a number, the ``unit``, which is in the first
        one."""
        listed: list[Polynomial] = []
        for g, n in factors:
            # A power of omega is one monomial, and so one family in place of n.
            listed += [g**n] if g == ring.variable else [g] * n
        first, *others = listed or [ring.constant(1)]
        families = [self.reader.family(ring, first, unit)]
        families += [self.reader.family(ring, g) for g in others]
        return tuple(families)

    def _need_sign_changes_alone(self, x: _FactoredForm) -> None:
        """Note that poles, and zeros of even order, at which a function is 0 between equal signs,
        must not lie on the band, but at omega = 0: they do not fit a list of sign changes. Sets
        with one are left to exact arithmetic."""
        even = (g for g, n in x.numerator if n % 2 == 0)
        self._need_nonzero(x.ring, (g for g, _ in x.denominator))
        self._need_nonzero(x.ring, even)

    def _need_nonzero(self, ring: PolynomialRing, factors: Iterable[Polynomial]) -> None:
        """Note that these factors must not vanish on the band, but for a zero at omega = 0."""
        for g in factors:
            if not self._has_no_zero_above_0(ring, g):
                self.nonzero.append(self.reader.family(ring, g))

    def _has_no_zero_above_0(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        """Whether a factor is a number, omega or a power omega^alpha."""
        return bool(factor.is_constant()) or self._is_power(ring, factor)

    def _is_power(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        """Whether a factor is omega or a power omega^alpha: it vanishes at 0, and nowhere else."""
        end = ring.size + len(self.reader.orders)
        powers = ring.context.gens()[ring.size : end]
        return any(factor == x for x in [ring.variable, *powers])


class _FactoredForm(NamedTuple):
    """A real function in half angles as ``unit`` * ``numerator``/(``lower_unit`` *
    ``denominator``): numbers, and irreducible polynomials of ``ring`` with their multiplicities."""

    ring: PolynomialRing
    unit: Rational
    numerator: _Factors
    lower_unit: Rational
    denominator: _Factors

    @classmethod
    def of(cls, f: RealFunction) -> _FactoredForm:
        """A real function taken apart."""
        form = f.half_angled
        numerator, denominator = map(form.ring.factors, (form.numerator, form.denominator))
        return cls(form.ring, *numerator, *denominator)


def _is_even(polynomial: Polynomial) -> bool:
    """Whether a polynomial has even powers of omega alone."""
    return all(int(exponents[0]) % 2 == 0 for exponents in polynomial.monoms())


def _is_odd_at_0(f: RationalFunction) -> bool:
    """Whether the power of omega in a real function is odd."""
    exponent = 0
    for polynomial in (f.numerator, f.denominator):
        for factor, n in f.ring.factors(polynomial)[1]:
            if factor == f.ring.variable:
                exponent += n
    return exponent % 2 == 1
