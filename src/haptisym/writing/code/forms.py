"""The closed forms of a distortion as a computation in floats: few operations, and digits kept.

Parts are quotients of polynomials in lowest terms, so that a limit at 0 or at a zero of H_env is a value. Where a
denominator is the squared modulus of a factor R + j X of the dynamics, it is computed as R^2 + X^2, which is never
negative, and keeps its digits at a resonance; other polynomials by Horner's rule in omega^2. Delays are written in the
half angle x = omega tau/2 as cos x and (sin x)/omega, so that 1 - cos 2x is never a difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, count
from typing import Any

from sympy import Abs, Add, Expr, Integer, Mul, Rational, Symbol, cos, sqrt

from haptisym.kernel.axis import Axis
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.kernel.symbols import omega
from haptisym.model.distortion import Chain, Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.programs.program import sincm1
from haptisym.programs.stable import without_sinc_less_one
from haptisym.programs.steps import Steps, code_steps
from haptisym.programs.values import Values


def chain_steps(chain: Chain) -> Steps:
    """Re and Im of dH, of dH/H_env, of H_env and of H_perc, and both ratios: the fields of ``numeric.Values``, in its order.

    The stable straight-line program that ``compile`` runs; closed forms in lowest terms where Re and Im of H_env vanish
    together or something is infinite at 0, so that limits there are values.

    >>> from haptisym.effects import first_order_lag
    >>> from haptisym.environments import kelvin_voigt
    >>> from haptisym.model.distortion import distort
    >>> steps = chain_steps(distort(kelvin_voigt(100, 2), first_order_lag(20)).chain)
    >>> steps.at({omega: Integer(10)})["relative_real"], steps.operations < 40
    (-1/5, True)
    """
    steps = code_steps(chain.program(Values._fields))
    return steps if _has_no_limits(chain, steps) else closed_steps(chain.distortion())


def _has_no_limits(chain: Chain, steps: Steps) -> bool:
    """Whether all values are values, none of them a limit: Re and Im of H_env have no zero in common, and nothing is 0/0 at 0."""
    environment = on_axis(chain.ring.convert(chain.environment).reduced())
    R, X = (part_of(environment, part).function.numerator for part in Part)
    apart = R.is_zero() or X.is_zero() or R.gcd(X).is_constant()
    known = {x: Rational(n + 7, 5) for n, x in enumerate(sorted(steps.free_symbols - {omega}, key=str))}
    return apart and all(x.is_finite for x in steps.at({**known, omega: Integer(0)}).values())


def closed_steps(distortion: Distortion) -> Steps:
    """The same from the closed forms, in lowest terms."""
    forms = _Forms.of(distortion)
    plain = (
        distortion.difference_response,
        distortion.relative_response,
        distortion.env_response,
        distortion.perc_response,
    )
    real_imag, *others = ([forms.quotient(part_of(response, part)) for part in Part] for response in plain)
    ratios = [forms.root(distortion.squared_ratios[part]) for part in Part]
    values = [*real_imag, *ratios, *(value for pair in others for value in pair)]
    return Steps(forms.definitions(values), dict(zip(Values._fields, values, strict=True))).shared()


@dataclass(frozen=True)
class _Forms:
    """How the polynomials of one scene are written: names for its functions, and the moduli that its denominators are."""

    axis: Axis
    dynamics: tuple[Polynomial, ...]
    """The irreducible factors of H_env and of the denominators, polynomials in s."""
    names: Mapping[Expr, Symbol]
    """What stands for the further functions: names for cosines, sines and powers."""

    @classmethod
    def of(cls, distortion: Distortion) -> _Forms:
        axis = distortion.env_response.raw_real.ring
        assert isinstance(axis, Axis)
        whole = (distortion.env.numerator, distortion.env.denominator, distortion.perc.denominator)
        factors = [p for polynomial in whole for p, _ in distortion.env.ring.factors(polynomial, in_square=False)[1]]
        return cls(axis, tuple(factors), _names(axis))

    def definitions(self, values: Sequence[Expr]) -> tuple[tuple[Symbol, Expr], ...]:
        """What the names in these values stand for."""
        used = {x for e in values for x in e.free_symbols}
        return tuple((name, meaning) for meaning, name in self.names.items() if name in used)

    def quotient(self, f: RealFunction) -> Expr:
        """A real function as numerator over denominator."""
        hold = without_sinc_less_one(f)
        if hold is not None:
            angle, rest = hold
            return sincm1(angle) * self.quotient(rest)
        top, bottom = (
            Mul(unit, *(form**n for form, n, _ in factors)) for unit, factors in map(self._factors, self._parted(f))
        )
        return top / bottom

    def root(self, square: RealFunction) -> Expr:
        """The root of a real function that is nowhere negative: of each square, its magnitude."""
        hold = without_sinc_less_one(square)
        twice = hold and without_sinc_less_one(hold[1])
        if twice:
            angle, rest = twice
            return Abs(sincm1(angle)) * self.root(rest)
        top, bottom = (
            Mul(sqrt(unit), *(_root(form if positive else Abs(form), n) for form, n, positive in factors))
            for unit, factors in map(self._factors, self._parted(square))
        )
        return top / bottom

    def _parted(self, f: RealFunction) -> tuple[Polynomial, Polynomial]:
        """Numerator and denominator in half angles, without common factors, with whole coefficients."""
        reduced = self._half_angles(f.function).reduced().cleared()
        return reduced.numerator, reduced.denominator

    def _half_angles(self, function: RationalFunction) -> RationalFunction:
        return self.axis.half_angles(function) if self.axis.angles else function

    @cached_property
    def _ring(self) -> PolynomialRing:
        return self._half_angles(self.axis.one).ring

    def _factors(self, polynomial: Polynomial) -> tuple[Rational, list[tuple[Expr, int, bool]]]:
        """A number, and each factor with its exponent, and whether it is nowhere negative as it is written."""
        unit, factors = self._ring.factors(polynomial)
        written = []
        for factor, n in factors:
            lead = factor.leading_coefficient()
            known = next((x for x in self._moduli if x.monic * lead == factor), None)
            if known is None:
                written.append((self._horner(factor), n, False))
            else:
                unit *= _rational(lead / known.lead) ** n
                written.append((known.form, n, True))
        return unit, written

    @cached_property
    def _moduli(self) -> list[_Modulus]:
        """What |R + j X|^2 is as a polynomial, for each factor of the dynamics."""
        return list(self._squares())

    def _squares(self) -> Iterator[_Modulus]:
        for p in self.dynamics:
            R, X = self.axis.parts([p])[0]
            if R.is_zero() or X.is_zero():
                continue  # a square already
            halves = self._half_angles(self.axis.function(R, X))
            common = halves.numerator.gcd(halves.denominator)
            R, X = halves.numerator / common, halves.denominator / common
            whole = R**2 + X**2
            lead = whole.leading_coefficient()
            yield _Modulus(whole / lead, lead, Add(*(_unsigned(self._horner(p)) ** 2 for p in (R, X))))

    def _horner(self, polynomial: Polynomial) -> Expr:
        """A polynomial by Horner's rule: in W = omega^2 times a power of omega where it can be, else in omega."""
        powers: dict[int, list[Expr]] = {}
        for (power, *rest), coefficient in polynomial.to_dict().items():
            factors = [self._name(x) ** int(n) for x, n in zip(self._ring.meanings[1:], rest, strict=True) if n]
            powers.setdefault(int(power), []).append(Mul(_rational(coefficient), *factors))
        lowest = min(powers)
        step = 2 if all((n - lowest) % 2 == 0 for n in powers) else 1
        variable, value = (self.names[omega**2] if step == 2 else omega), Integer(0)
        for n in range(max(powers), lowest - 1, -step):
            value = value * variable + Add(*powers.get(n, []))
        return self._power(lowest) * value

    def _power(self, n: int) -> Expr:
        return Mul(self.names[omega**2] ** (n // 2), omega ** (n % 2))

    def _name(self, meaning: Expr) -> Expr:
        return self.names.get(meaning, meaning)


@dataclass(frozen=True)
class _Modulus:
    """A squared modulus: as a polynomial with leading coefficient 1, that coefficient, and as it is computed."""

    monic: Polynomial
    lead: Any
    form: Expr


def _rational(x: Any) -> Rational:
    return Rational(int(x.p), int(x.q))


def _unsigned(form: Expr) -> Expr:
    """Of a form and its negative, the one that is written first: other parts of the computation have it too."""
    return -form if form.could_extract_minus_sign() else form


def _root(form: Expr, n: int) -> Expr:
    """The root of the n-th power of what is not negative."""
    return form ** (n // 2) * sqrt(form) if n % 2 else form ** (n // 2)


def _names(axis: Axis) -> dict[Expr, Symbol]:
    """Names for omega^2 and for the cosines, sines and powers that are not plain numbers; none that a parameter has."""
    functions = axis.half_angles(axis.one).ring.functions if axis.angles else ()
    taken = {x.name for x in axis.symbols}
    names = {}
    for function in (omega**2, *functions):
        if function.free_symbols:
            stem = (
                "W"
                if function == omega**2
                else "cos"
                if function.func == cos
                else "power"
                if function.is_Pow
                else "sin"
            )
            names[function] = Symbol(_free_name(stem, taken), real=True)
            taken.add(names[function].name)
    return names


def _free_name(stem: str, taken: set[str]) -> str:
    """W, or the first of cos_1, cos_2, ... that nothing has."""
    plain = ["W"] if stem == "W" else []
    return next(x for x in chain(plain, (f"{stem}_{n}" for n in count(1))) if x not in taken)
