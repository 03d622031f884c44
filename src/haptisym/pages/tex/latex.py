r"""LaTeX of an expression, of a distortion's formulas or of an evaluation's tables, ready to paste into a paper.

Packages that the result needs: amsmath, and booktabs for the tables. Numbers are exact (see ``numerals``).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import singledispatch
from typing import Any

from sympy import Basic, Expr, I, Mul, S, Symbol, sqrt

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel import response
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.kernel.symbols import X, omega
from haptisym.model.distortion import Distortion, magnitude, part_of
from haptisym.model.jnd import Part
from haptisym.pages.tex.results import RATIOS, crossing_tables, percept_tables, undecided_tables
from haptisym.writing.equations import QUANTITIES, quantity
from haptisym.writing.texlines import Row, align, is_long
from haptisym.writing.texnames import coded
from haptisym.writing.texprinter import formula, tex


@singledispatch
def latex(value: Any) -> str:
    r"""LaTeX of a SymPy expression, of a Distortion (its formulas, an ``align*``) or of an Evaluation (its tables).

    Formulas stand in descending powers of s or omega, ascending where that avoids a leading minus. Nothing is rounded.
    Raises TypeError for anything else.

    >>> from sympy import Rational
    >>> from haptisym.kernel.symbols import s, symbols
    >>> m, b, k, omega_n, zeta = symbols("m b k omega_n zeta")
    >>> latex(Rational(9, 5) * s**2 + b * s + k), latex(k - m * omega**2)
    ('1.8 s^{2} + b s + k', 'k - m \\omega^{2}')
    >>> latex(omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2))
    '\\frac{\\omega_n^{2}}{s^{2} + 2 \\zeta \\omega_n s + \\omega_n^{2}}'
    """
    raise TypeError(f"no LaTeX for {type(value).__name__}: give an expression, a Distortion or an Evaluation")


@latex.register(Basic)
def _(value: Basic) -> str:
    return formula(value)


@latex.register
def _(value: Distortion) -> str:
    forms = ClosedForms(value)
    return align(
        [*forms.dynamics(), *forms.difference(), *forms.ratios(), *forms.relative(), *forms.properties("env"),
         *forms.properties("perc"), *forms.parameter_jnds(), *forms.forces("env"), *forms.forces("perc")]
    )  # fmt: skip


@latex.register
def _(value: Evaluation) -> str:
    tables = [*crossing_tables(value), *undecided_tables(value), *percept_tables(value)]
    return "\n\n".join([*tables, *map(coded, value.given.asides())])


# The formulas of a distortion.


@dataclass(frozen=True)
class ClosedForms:
    """The formulas of a distortion as rows of an ``align*``, each denominator a sum of two squares where nothing cancels."""

    distortion: Distortion

    def dynamics(self) -> list[Row]:
        """H_env(s) and H_perc(s)."""
        d = self.distortion
        return [_row("H_env", d.environment), _row("H_perc", d.perceived)]

    def difference(self) -> list[Row]:
        """Re dH and Im dH (eq. 9), and what they are compared with, |H_env|^2."""
        change = [_row(f"{name} dH", on_axis(self.distortion.difference, part)) for part, name in _OPERATORS.items()]
        return [*change, _row("|H_env|^2", self._square)]

    def ratios(self) -> list[Row]:
        """r_r and r_i (eq. 10)."""
        return [_row(name, self._ratio(part), optional=True) for part, name in RATIOS.items()]

    def relative(self) -> list[Row]:
        """Re(dH/H_env) and Im(dH/H_env), which are not the ratios."""
        relative = (self.distortion.difference / self.distortion.env).reduced()
        return [_row(f"{name}(dH/H_env)", on_axis(relative, part)) for part, name in _OPERATORS.items()]

    def properties(self, system: str) -> list[Row]:
        """What is felt of a system (section 2.3): Re H and Im H; stiffness, mass and damping."""
        real, imag = self._parts(system)
        return [
            _row(f"k_{system}", real),
            _row(f"m_{system}", -real / omega**2, optional=True),
            _row(f"b_{system}", imag / omega),
        ]

    def parameter_jnds(self) -> list[Row]:
        """By how much a single parameter must change to be noticed."""
        least = Symbol("c", positive=True) * sqrt(self._square)
        powers = {"k": 0, "b": 1, "m": 2}
        return [_row(f"jnd {key}", least / omega**power, optional=True) for key, power in powers.items()]

    def forces(self, system: str) -> list[Row]:
        """The phasors of spring or inertia force and of damping force (eqs. 5 and 6) for a motion X."""
        real, imag = self._parts(system)
        return [_row(f"F_si_{system}", X * real, optional=True), _row(f"F_d_{system}", X * imag * I, optional=True)]

    @property
    def _square(self) -> Expr:
        return squared_modulus(self.distortion.env)

    def _parts(self, system: str) -> tuple[Expr, Expr]:
        function = self.distortion.env if system == "env" else self.distortion.perc
        return on_axis(function, Part.REAL), on_axis(function, Part.IMAG)

    def _ratio(self, part: Part) -> Expr:
        form, difference = on_axis(self.distortion.difference, part), self.distortion.difference
        return magnitude(form, difference, evaluate=not is_long(form)) / sqrt(self._square)


_OPERATORS = {Part.REAL: "Re", Part.IMAG: "Im"}


def _row(name: str, value: Expr, *, optional: bool = False) -> Row:
    """A row for a quantity by its name, with its meaning if it has one."""
    left, means = QUANTITIES[name]
    return Row(tex(left), value, tex(means) if means else "", optional)


def at_s(system: str) -> str:
    """H(s) of environment (``env``), of what is rendered or perceived (``perc``) in LaTeX."""
    return tex(quantity(f"H_{system}"))


def on_axis(function: RationalFunction, part: Part) -> Expr:
    """Real or imaginary part on s = j omega, over the squared modulus of the denominator.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.symbols import s
    >>> on_axis(Ring().convert(1 / (s**2 + s + 4)), Part.REAL)
    (4 - omega**2)/(omega**2 + (4 - omega**2)**2)
    """
    axis = _ring(function).axis
    if axis.functions or axis.complex:
        return part_of(response.on_axis(function), part).factored()
    whole = function.reduced().cleared()
    (a, b), (c, d) = axis.parts([whole.numerator, whole.denominator])
    above, below = (a * c + b * d if part is Part.REAL else b * c - a * d), c * c + d * d
    if not above.gcd(below).is_constant():
        return axis.function(above, below).factored()
    return axis.factored_expression(above) / _squares(whole, whole.denominator)


def squared_modulus(function: RationalFunction) -> Expr:
    """|f(j omega)|^2 as sums of two squares.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.symbols import s
    >>> squared_modulus(Ring().convert(s**2 + s + 4))
    omega**2 + (4 - omega**2)**2
    """
    if _ring(function).axis.functions or _ring(function).axis.complex:
        return response.squared_modulus(function).factored()
    reduced = function.reduced()
    whole = reduced if reduced.denominator.is_constant() else reduced.cleared()
    return _squares(whole, whole.numerator) / _squares(whole, whole.denominator)


def _squares(function: RationalFunction, polynomial: Polynomial) -> Expr:
    axis = _ring(function).axis
    unit, factors = function.ring.factors(polynomial)
    if len(factors) == 1 and factors[0][1] == 1:
        unit, factors = S.One, [(polynomial, 1)]
    moduli = []
    for factor, exponent in factors:
        real, imag = map(axis.expression, axis.parts([factor])[0])
        moduli.append((real**2 + imag**2) ** exponent)
    return Mul(unit**2, *moduli)


def _ring(function: RationalFunction) -> Ring:
    ring = function.ring
    assert isinstance(ring, Ring)
    return ring
