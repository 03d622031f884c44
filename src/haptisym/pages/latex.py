"""LaTeX of a value, ready to paste into a paper: amsmath, and booktabs for tables; numbers are exact."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

from sympy import Basic

from haptisym.judge.answers import Answer
from haptisym.model.distortion import Distortion
from haptisym.pages.closedforms import ClosedForms
from haptisym.writing.document import DIGITS
from haptisym.writing.latex import align, formula, tables


@singledispatch
def latex(value: Any, *, digits: int = DIGITS) -> str:
    r"""LaTeX of a SymPy expression, of a Distortion (its formulas, an ``align*``) or of an answer (its tables).

    Formulas stand in descending powers of s or omega, ascending where that avoids a leading minus; nothing in them is rounded.
    ``digits`` : of the numbers of tables.
    Raises TypeError for anything else.

    >>> from sympy import Rational
    >>> from haptisym.kernel.rings import omega, s, symbols
    >>> m, b, k, omega_n, zeta = symbols("m b k omega_n zeta")
    >>> latex(Rational(9, 5) * s**2 + b * s + k), latex(k - m * omega**2)
    ('1.8 s^{2} + b s + k', 'k - m \\omega^{2}')
    >>> latex(omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2))
    '\\frac{\\omega_n^{2}}{s^{2} + 2 \\zeta \\omega_n s + \\omega_n^{2}}'
    """
    raise TypeError(f"no LaTeX for {type(value).__name__}: give an expression, a Distortion or an answer")


@latex.register
def _(value: Basic, *, digits: int = DIGITS) -> str:
    return formula(value)


@latex.register
def _(value: Distortion, *, digits: int = DIGITS) -> str:
    return align(ClosedForms(value).all())


@latex.register
def _(value: Answer, *, digits: int = DIGITS) -> str:
    return tables(value.document(), digits)
