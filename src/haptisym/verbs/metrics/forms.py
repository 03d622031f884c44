"""The closed forms of the measures of transparency: in the scene's symbols where that is short, else in its numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

from sympy import Expr

from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.shown import Shown
from haptisym.kernel.symbols import omega, s
from haptisym.model.distortion import Chain, Distortion
from haptisym.model.scene import Scene
from haptisym.verbs.metrics.twoport import TwoPort
from haptisym.writing.boxes import (
    Absolute,
    Applied,
    Box,
    Equation,
    Fenced,
    Fraction,
    Numeral,
    Operator,
    Power,
    Prefixed,
    Product,
    Sum,
    Titled,
)
from haptisym.writing.equations import meaning, quantity
from haptisym.writing.formula import readable
from haptisym.writing.layout import layout
from haptisym.writing.mathtext import text
from haptisym.writing.names import named
from haptisym.writing.texprinter import tex

MOST_SYMBOLS = 8
"""Parameters that a formula in symbols may have; with more it would fill pages."""
_MOST_LETTERS = 180
_TWO = Numeral("2")


@dataclass(frozen=True, repr=False)
class Form(Shown):
    """``left = means = value``: what a measure is, its closed form if it has one; ``relation`` stands before the last."""

    left: Box
    means: Box | None = None
    value: Expr | None = None
    relation: str = "="

    def _line(self) -> str:
        return text(self.equation)

    @property
    def equation(self) -> Equation:
        sides = [
            self.left,
            *([self.means] if self.means else []),
            *([] if self.value is None else [layout(self.value)]),
        ]
        relations = ["="] * (len(sides) - 1)
        return Equation(tuple(sides), (*relations[:-1], self.relation))

    def row(self) -> dict[str, str]:
        """As a row of a document."""
        return {"text": text(self.equation), "latex": tex(self.equation)}


@dataclass(frozen=True)
class System:
    """The dynamics of a chain: distortion and two-port in one ring."""

    chain: Chain

    @cached_property
    def d(self) -> Distortion:
        return self.chain.distortion()

    @cached_property
    def port(self) -> TwoPort:
        return TwoPort.of(self.chain, self.chain.ring)

    @property
    def rendered(self) -> RationalFunction:
        return self.chain.ring.convert(self.chain.rendered).reduced()


def _of_s(name: str) -> Box:
    return Titled(f"{name}(s)", Applied(named(name), (named("s"),)))


def _part(operator: str, of: Box) -> Box:
    return Prefixed(Operator(operator), of)


_H_ENV, _H_PERC, _DH = (quantity(x) for x in ("H_env", "H_perc", "dH"))
_A, _B, _C, _D, _G = (named(x) for x in "ABCDg")
_DET = Sum(((1, Product((_A, _D))), (-1, Product((_B, _C)))))


class Forms:
    """The closed forms of one scene."""

    def __init__(self, scene: Scene) -> None:
        self.numeric = System(scene.distortion().chain)
        self.symbolic = System(scene.chain) if len(scene.parameters) <= MOST_SYMBOLS else None

    def _form(self, left: Box, means: Box, of: Callable[[System], RationalFunction | None]) -> Form:
        """In symbols if that is short, in numbers if not, without a value where there is none (a division by 0)."""
        if self.symbolic is not None:
            known = of(self.symbolic)
            shown = None if known is None else known.factored()
            if shown is None or len(text(layout(shown))) <= _MOST_LETTERS:
                return Form(left, means, shown)
        function = of(self.numeric)
        if function is None:
            return Form(left, means)
        value, rounded = readable(function, s)
        return Form(left, means, value, "≈" if rounded else "=")

    def ratio(self) -> Form:
        """Gamma = H_perc/H_env."""
        return self._form(_of_s("Gamma"), Fraction(_H_PERC, _H_ENV), lambda x: (x.d.perc / x.d.env).reduced())

    def relative(self) -> Form:
        """Theta = dH/H_env = Gamma - 1."""
        return self._form(_of_s("Theta"), Fraction(_DH, _H_ENV), lambda x: (x.d.difference / x.d.env).reduced())

    def range(self) -> Iterator[Form]:
        """Z_min = B/D, Z_max = A/C and Z_width = det/(C D)."""
        yield self._form(_of_s("Z_min"), Fraction(_B, _D), lambda x: x.port.least)
        yield self._form(_of_s("Z_max"), Fraction(_A, _C), lambda x: x.port.most)
        yield self._form(_of_s("Z_width"), Fraction(_DET, Product((_C, _D))), lambda x: x.port.width)

    def sensitivity(self) -> Form:
        """det/(C H_env + D)^2."""
        below = Power(Fenced(Sum(((1, Product((_C, _H_ENV))), (1, _D)))), _TWO)
        left = Titled("dH_perc/dH_env", Fraction(Product((Operator("d"), _H_PERC)), Product((Operator("d"), _H_ENV))))
        return self._form(left, Fraction(_DET, below), lambda x: x.port.sensitivity(x.rendered))

    def passivity(self) -> Form:
        """Im H_perc >= 0."""
        return Form(_part("Im", quantity("H_perc")), Numeral("0"), None, "≥")

    def llewellyn(self) -> Iterator[Form]:
        """The four conditions, in the entries of the chain matrix."""
        first, second = _part("Im", Fraction(_B, _D)), _part("Im", Fraction(_C, _D))
        yield Form(first, Numeral("0"), None, "≥")
        yield Form(second, Numeral("0"), None, "≤")
        margin = Sum(((1, _part("Re", _G)), (-1, Product((_TWO, first, second)))))
        yield Form(margin, Absolute(_G), None, "≥")
        yield self._form(_G, Fraction(_DET, Power(_D, _TWO)), lambda x: x.port.gain)

    def effective(self) -> Iterator[Form]:
        """Stiffness, mass and damping of H_perc, functions of omega."""
        for name, of in _EFFECTIVE.items():
            yield self._on_axis(name, of)

    def _on_axis(self, name: str, of: Callable[[System], RealFunction]) -> Form:
        if self.symbolic is not None:
            shown = of(self.symbolic).factored()
            if len(text(layout(shown))) <= _MOST_LETTERS:
                return Form(quantity(name), meaning(name), shown)
        value, rounded = readable(of(self.numeric).written, omega)
        return Form(quantity(name), meaning(name), value, "≈" if rounded else "=")

    def free_response(self) -> Iterator[Form]:
        """First zero crossing, period and overshoots from sigma and omega_d."""
        sigma, omega_d, pi = named("sigma"), named("omega_d"), named("pi")
        angle = Applied(Operator("arctan"), (Fraction(omega_d, sigma),))
        yield Form(named("P_0"), Fraction(Sum(((1, pi), (-1, angle))), omega_d))
        yield Form(named("P_n"), Fraction(Product((_TWO, pi)), omega_d))
        decay = Sum(((-1, Fraction(Product((named("n"), pi, sigma)), omega_d)),))
        yield Form(Fraction(named("A_n"), named("A_d")), Applied(Operator("exp"), (decay,)))


def _stiffness(x: System) -> RealFunction:
    return on_axis(x.d.perc).real


def _mass(x: System) -> RealFunction:
    real = _stiffness(x)
    return RealFunction((-real.function / real.axis.convert(omega**2)).reduced())


def _damping(x: System) -> RealFunction:
    imag = on_axis(x.d.perc).imag
    return RealFunction((imag.function / imag.axis.convert(omega)).reduced())


_EFFECTIVE = {"k_perc": _stiffness, "m_perc": _mass, "b_perc": _damping}
