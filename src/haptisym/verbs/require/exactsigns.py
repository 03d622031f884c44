"""The sign of a polynomial in one parameter, exactly: what Im H_perc has just above frequency 0, and far out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import flint
from sympy import Expr, Integer, Poly, Symbol

from haptisym.kernel.reals import ExactNumber, Negative, RealNumber, expression_ball
from haptisym.kernel.roots import sign_of_number
from haptisym.verbs.stability.loops import zeros

_BITS = 256


def zeros_of(form: Expr, symbol: Symbol) -> list[RealNumber]:
    """The real zeros of a polynomial that is not 0 everywhere, each once."""
    row = Poly(form, symbol).all_coeffs()[::-1]
    later = next(i for i, x in enumerate(row) if x != 0)
    row = row[later:]
    mirrored = (
        [-x if i % 2 else x for i, x in enumerate(row)] if len(row) > 2 else []
    )  # a linear one has its zero anyway
    below = (ExactNumber(-x.value) if isinstance(x, ExactNumber) else Negative(x) for x in zeros(mirrored))
    return [*[ExactNumber(Integer(0))] * (later > 0), *zeros(row), *below]


def keeps_sign(form: Expr, symbol: Symbol, low: Expr, high: Expr) -> bool:
    """Whether a polynomial has no zero between two values; at them it may have one."""
    if not form.is_polynomial(symbol) or form.expand() == 0:
        return False
    return not any(is_between(low, x, high) for x in zeros_of(form, symbol))


def is_between(low: Expr | None, x: RealNumber, high: Expr | None) -> bool:
    """Whether a number lies between two others (None: without bound), or so near to one that some hundred bits do not tell."""
    if isinstance(x, ExactNumber) and x.value.is_Rational:
        return (low is None or bool(low < x.value)) and (high is None or bool(x.value < high))
    with flint.ctx.workprec(_BITS):
        place = x.ball(_BITS)
        below = low is not None and bool(place <= expression_ball(low))
        return not below and not (high is not None and bool(place >= expression_ball(high)))


@dataclass(frozen=True)
class ExactSign:
    """The sign of a polynomial that is not 0 everywhere.

    >>> from sympy import symbols
    >>> q = symbols("q")
    >>> sign = ExactSign(q**2 - 4, q)
    >>> [sign.at(x) for x in map(Integer, (-3, 2, 0))], sign.between(Integer(2), None), sign.between(Integer(-3), Integer(3))
    ([1, 0, -1], 1, None)
    """

    form: Expr
    symbol: Symbol

    @cached_property
    def zeros(self) -> tuple[RealNumber, ...]:
        """Where it may change."""
        return tuple(zeros_of(self.form, self.symbol)) if self.form.has(self.symbol) else ()

    def at(self, value: Expr) -> int:
        """The sign for one value."""
        return sign_of_number(self.form.xreplace({self.symbol: value}))

    def between(self, low: Expr | None, high: Expr | None) -> int | None:
        """The sign for all values between two (None: without bound); None where it is not one."""
        if any(is_between(low, x, high) for x in self.zeros):
            return None
        if low is None:
            return self.at(Integer(0) if high is None else high - 1)
        return self.at(low + 1 if high is None else (low + high) / 2)
