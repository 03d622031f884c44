"""The formulas of a distortion as lines of equations, each denominator a sum of two squares where nothing cancels."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Abs, Expr, I, Mul, S, Symbol, sqrt

from haptisym.kernel import dynamics as response
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial, RationalFunction, X, omega
from haptisym.model.distortion import Distortion, magnitude, part_of
from haptisym.model.jnd import Part
from haptisym.writing.document import Line
from haptisym.writing.equations import QUANTITIES
from haptisym.writing.latex import is_long


@dataclass(frozen=True)
class ClosedForms:
    """The formulas of a distortion by their subjects."""

    distortion: Distortion

    def all(self) -> list[Line]:
        """All of them."""
        return [
            *self.dynamics(), *self.difference(), *self.ratios(), *self.relative(), *self.properties("env"),
            *self.properties("perc"), *self.parameter_jnds(), *self.forces("env"), *self.forces("perc"),
        ]  # fmt: skip

    def dynamics(self) -> list[Line]:
        """H_env(s) and H_perc(s)."""
        d = self.distortion
        return [_row("H_env", d.environment), _row("H_perc", d.perceived)]

    def difference(self) -> list[Line]:
        """Re dH and Im dH (eq. 9), and what they are compared with, |H_env|^2."""
        change = [_row(f"{name} dH", self._change(part)) for part, name in _OPERATORS.items()]
        return [*change, _row("|H_env|^2", self._square)]

    def ratios(self) -> list[Line]:
        """r_r and r_i (eq. 10)."""
        return [_row(name, self._ratio(part), optional=True) for part, name in _RATIOS.items()]

    def relative(self) -> list[Line]:
        """Re(dH/H_env) and Im(dH/H_env), which are not the ratios."""
        relative = (self.distortion.difference / self.distortion.env).reduced()
        forms = {part: self.distortion.relative_form(part) for part in Part}
        return [
            _row(f"{name}(dH/H_env)", on_axis(relative, part) if forms[part][1] else forms[part][0])
            for part, name in _OPERATORS.items()
        ]

    def properties(self, system: str) -> list[Line]:
        """What is felt of a system (section 2.3): Re H and Im H; stiffness, mass and damping."""
        real, imag = self._parts(system)
        return [
            _row(f"k_{system}", real),
            _row(f"m_{system}", -real / omega**2, optional=True),
            _row(f"b_{system}", imag / omega),
        ]

    def parameter_jnds(self) -> list[Line]:
        """By how much a single parameter must change to be noticed."""
        least = Symbol("c", positive=True) * sqrt(self._square)
        powers = {"k": 0, "b": 1, "m": 2}
        return [_row(f"jnd {key}", least / omega**power, optional=True) for key, power in powers.items()]

    def forces(self, system: str) -> list[Line]:
        """The phasors of spring or inertia force and of damping force (eqs. 5 and 6) for a motion X."""
        real, imag = self._parts(system)
        return [_row(f"F_si_{system}", X * real, optional=True), _row(f"F_d_{system}", X * imag * I, optional=True)]

    @property
    def _square(self) -> Expr:
        return squared_modulus(self.distortion.env)

    def _change(self, part: Part) -> Expr:
        """Re or Im dH."""
        form, is_lowest = self.distortion.form(part)
        return on_axis(self.distortion.difference, part) if is_lowest else form

    def _parts(self, system: str) -> tuple[Expr, Expr]:
        real, imag = (on_axis(self.distortion.env, part) for part in Part)
        if system == "env":
            return real, imag
        if all(self.distortion.form(part)[1] for part in Part):
            return on_axis(self.distortion.perc, Part.REAL), on_axis(self.distortion.perc, Part.IMAG)
        return real + self._change(Part.REAL), imag + self._change(Part.IMAG)

    def _ratio(self, part: Part) -> Expr:
        form, difference = self._change(part), self.distortion.difference
        if not self.distortion.form(part)[1]:
            return Abs(form, evaluate=False) / sqrt(self._square)
        return magnitude(form, difference, evaluate=not is_long(form)) / sqrt(self._square)


_RATIOS = {Part.REAL: "r_r", Part.IMAG: "r_i"}
_OPERATORS = {Part.REAL: "Re", Part.IMAG: "Im"}


def _row(name: str, value: Expr, *, optional: bool = False) -> Line:
    """A row for a quantity by its name, with its meaning if it has one."""
    left, means = QUANTITIES[name]
    return Line(left, value, meaning=means, optional=optional)


def on_axis(function: RationalFunction, part: Part) -> Expr:
    """Real or imaginary part on s = j omega, over the squared modulus of the denominator.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.rings import s
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
    >>> from haptisym.kernel.rings import s
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
