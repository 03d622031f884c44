"""The closed forms of the measures of transparency, in the scene's symbols where these are few, and in its numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from sympy import Expr

from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.shown import Shown
from haptisym.kernel.symbols import omega
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene
from haptisym.verbs.metrics.twoport import TwoPort

MOST_SYMBOLS = 8
"""Parameters that a formula in symbols may have; with more it would fill pages."""


@dataclass(frozen=True)
class ChainSystem:
    """The dynamics of a chain: distortion and two-port in one ring."""

    chain: Chain

    @cached_property
    def d(self) -> Distortion:
        """What is felt instead of the environment."""
        return Distortion.of(self.chain)

    @cached_property
    def port(self) -> TwoPort:
        """The chain as a two-port."""
        return TwoPort.of(self.chain, self.chain.ring)

    @property
    def rendered(self) -> RationalFunction:
        """The dynamics that is rendered, in the ring of the chain."""
        return self.chain.ring.convert(self.chain.rendered).reduced()


Function: TypeAlias = RationalFunction | RealFunction


@dataclass(frozen=True, repr=False)
class Form(Shown):
    """A closed form by its name, of s or of omega."""

    name: str
    numbers: ChainSystem
    symbols: ChainSystem | None

    def _line(self) -> str:
        return f"{self.name} = {self.value}"

    @cached_property
    def symbolic(self) -> Function | None:
        """In the scene's symbols; None with too many of them, and where there is none (a division by 0)."""
        return None if self.symbols is None else _FORMS[self.name](self.symbols)

    @cached_property
    def numeric(self) -> Function | None:
        """In the scene's numbers; None where there is none."""
        return _FORMS[self.name](self.numbers)

    @property
    def value(self) -> Expr | None:
        """In symbols if it can be, else in numbers."""
        found = self.symbolic or self.numeric
        return None if found is None else found.factored()


class MeasureForms:
    """The closed forms of one scene, by their names."""

    def __init__(self, scene: Scene) -> None:
        self.numeric = ChainSystem(scene.distortion().chain)
        self.symbolic = ChainSystem(scene.chain) if len(scene.parameters) <= MOST_SYMBOLS else None

    def __call__(self, *names: str) -> tuple[Form, ...]:
        """Some of them."""
        return tuple(Form(name, self.numeric, self.symbolic) for name in names)


def _stiffness(x: ChainSystem) -> RealFunction:
    return on_axis(x.d.perc).real


def _mass(x: ChainSystem) -> RealFunction:
    real = _stiffness(x)
    return RealFunction((-real.function / real.axis.convert(omega**2)).reduced())


def _damping(x: ChainSystem) -> RealFunction:
    imag = on_axis(x.d.perc).imag
    return RealFunction((imag.function / imag.axis.convert(omega)).reduced())


_FORMS: dict[str, Callable[[ChainSystem], Function | None]] = {
    "Gamma": lambda x: (x.d.perc / x.d.env).reduced(),
    "Theta": lambda x: (x.d.difference / x.d.env).reduced(),
    "Z_min": lambda x: x.port.least,
    "Z_max": lambda x: x.port.most,
    "Z_width": lambda x: x.port.width,
    "dH_perc/dH_env": lambda x: x.port.sensitivity(x.rendered),
    "g": lambda x: x.port.gain,
    "k_perc": _stiffness,
    "m_perc": _mass,
    "b_perc": _damping,
}
