"""The symbols that every formula shares, and frequencies in Hz.

The symbols that every formula shares, each born once with its assumptions.

Frequencies in Hz.
"""

from __future__ import annotations

from dataclasses import dataclass

import flint
from sympy import Expr, Symbol

from haptisym.kernel.errors import need
from haptisym.kernel.reals import Ball, RealNumber

s = Symbol("s")
"""Laplace variable, rad/s; plain, so that an ordinary ``Symbol("s")`` of the user is the same one."""

omega = Symbol("omega", positive=True)
"""Angular frequency, rad/s."""

c = Symbol("c", positive=True)
"""JND threshold, a fraction of ``|H_env|`` (eq. 4)."""

X = Symbol("X")
"""Complex amplitude of the hand's motion, m or rad (eqs. 5 and 6)."""


def symbols(names: str) -> tuple[Symbol, ...] | Symbol:
    """Positive SymPy symbols, for parameters; one symbol if ``names`` holds one name.

    >>> m, b, k = symbols("m b k")
    >>> m.is_positive
    True
    >>> symbols("omega_n")
    omega_n
    """
    need("symbols", names, str, 'give names in one string, as "m b k"')
    made = tuple(Symbol(name, positive=True) for name in names.replace(",", " ").split())
    return made[0] if len(made) == 1 else made


def conflicting(expressions: list[Expr]) -> Symbol | None:
    """A symbol that shares its name, but not its assumptions, with another one; None if there is none.

    >>> conflicting([Symbol("m") + Symbol("m", positive=True)]) is None
    False
    """
    seen: dict[str, Symbol] = {}
    for symbol in {x for e in expressions for x in e.free_symbols}:
        if seen.setdefault(symbol.name, symbol) != symbol:
            return symbol
    return None


@dataclass(frozen=True, slots=True, repr=False)
class Hertz(RealNumber):
    """A frequency in Hz, as certain as the one in rad/s.

    >>> from sympy import pi
    >>> from haptisym.kernel.reals import ExactNumber
    >>> Hertz(ExactNumber(3 * pi)).digits(3)
    '1.50'
    """

    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.omega.ball(bits) / (2 * flint.arb.pi())
