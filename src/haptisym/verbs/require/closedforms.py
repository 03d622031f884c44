"""What a parameter must be, as a formula: the condition at the band's edge, solved for the parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from sympy import Abs, Expr, Float, Symbol

from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.monomials import monomials
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.solutions import Solution, solve
from haptisym.kernel.symbols import omega

_DIGITS = 60
_MOST_TERMS, _MOST_OPERATIONS = 600, 80


def closed_form(
    condition: RealFunction, free: Symbol, place: Symbol, known: Mapping[Symbol, Expr], value: str
) -> Expr | None:
    """The formula for a parameter at which a condition binds at a frequency; None where there is no readable one.

    ``condition``: with symbols for all parameters; ``place``: the name of the frequency; ``known``: what all of them are
    worth; ``value``: decimal digits of the one solution that is meant, at least 60.
    """
    turned = _turned(condition, free, place)
    if turned is None:
        return None
    for solution in _solved(_Posed.of(turned)):
        form = solution.omega
        if form is not None and form.count_ops() <= _MOST_OPERATIONS and _is(form.xreplace(dict(known)), value):
            return form
    return None


@dataclass(frozen=True)
class _Posed:
    """A function whose zeros are asked for, with what tells it from others: the slices of a map all pose the same one."""

    told: tuple[object, ...]
    function: RealFunction = field(compare=False)

    @classmethod
    def of(cls, function: RealFunction) -> _Posed:
        axis, parts = function.axis, (function.function.numerator, function.function.denominator)
        terms = (frozenset((tuple(map(int, e)), x) for e, x in monomials(p)) for p in parts)
        return cls((axis.meanings, tuple(axis.angles), tuple(axis.orders), *terms), function)


@lru_cache(maxsize=32)
def _solved(posed: _Posed) -> tuple[Solution, ...]:
    return solve(posed.function)


def _is(number: Expr, value: str) -> bool:
    found = number.evalf(_DIGITS)
    return bool(found.is_real and Abs(found - Float(value, _DIGITS)) <= Abs(found) * Float(10) ** (8 - _DIGITS))


def _turned(condition: RealFunction, free: Symbol, place: Symbol) -> RealFunction | None:
    """The condition as a function of the parameter, which takes the place of omega; None where it is no such function."""
    axis, numerator = condition.axis, condition.function.numerator
    rates = [(angle.rate / free).cancel() * place for angle in axis.angles]
    if axis.orders or any(rate.has(free) for rate in rates) or len(numerator.to_dict()) > _MOST_TERMS:
        return None
    target = Ring([*(x for x in axis.symbols if x != free), place], rates).axis
    return RealFunction(target.function(_exchanged(numerator, axis, target, free, place)))


def _exchanged(polynomial: Polynomial, axis: Axis, target: Axis, free: Symbol, place: Symbol) -> Polynomial:
    """The polynomial with omega called ``place`` and the parameter called omega."""
    names = {omega: place, free: omega}
    where = [target.meanings.index(names.get(x, x)) for x in axis.meanings[: axis.size]]
    where += [target.size + i for i in range(len(axis.angles))]
    terms = {}
    for exponents, value in monomials(polynomial):
        own = [0] * len(target.meanings)
        for i, n in zip(where, exponents, strict=True):
            own[i] = int(n)
        terms[tuple(own)] = value
    return target.context.from_dict(terms)
