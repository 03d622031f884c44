"""The formulas of a scene for the parameters that a user wants to keep as symbols: closed, in steps, solved, dimensionless."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from sympy import Expr, I, Symbol, count_ops

from haptisym.judge.criteria import Criterion, noticed, opened
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.kernel.errors import SceneError
from haptisym.kernel.implicit import Equation
from haptisym.kernel.response import RealFunction
from haptisym.kernel.shown import Shown, titled
from haptisym.kernel.solutions import Solution, solve
from haptisym.kernel.symbols import X, c, omega
from haptisym.model.distortion import Chain, Distortion, part_of
from haptisym.model.jnd import Part, is_irrational_algebraic
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.steps import Steps
from haptisym.verbs.derive.asymptotics import Expansion, expansion
from haptisym.verbs.derive.groups import Groups, groups

Factors: TypeAlias = tuple[tuple[Equation, int], ...]
"""Irreducible factors as equations, each with its order."""


@dataclass(frozen=True, repr=False)
class Derivation(Shown):
    """The formulas of a scene; ``kept``: the parameters that stay symbols, the others have the scene's values.

    ``derivation["Re dH"]`` is a closed form, under the names of ``QUANTITIES``; ``steps`` is the distortion in short named
    steps; ``crossings`` and ``changeovers`` are solved where a formula is readable, and otherwise the equation to solve.
    """

    scene: Scene
    kept: tuple[Symbol, ...]
    kept_thresholds: tuple[Part, ...] = tuple(Part)

    def _line(self) -> str:
        kept = ", ".join(p.name for p in self.kept) or "nothing"
        return f"{titled(self.scene.title)}: {kept} as symbols"

    @cached_property
    def chain(self) -> Chain:
        """The dynamics with the scene's values for all parameters that are not kept."""
        return self.scene.chain.at({p.symbol: p.value for p in self.scene.parameters if p.symbol not in self.kept})

    @cached_property
    def distortion(self) -> Distortion:
        """The closed forms, exact."""
        return self.chain.distortion()

    @cached_property
    def steps(self) -> Steps:
        """The distortion in named steps, which stay short as devices are cascaded."""
        return self.chain.steps

    def __getitem__(self, name: str) -> Expr:
        key = listed_name(name)
        if key is None:
            raise SceneError(f'"{name}" is not a quantity: these are {", ".join(QUANTITIES)}')
        return QUANTITIES[key](self)

    def operations(self, name: str) -> int:
        """How many operations a closed form takes, written out."""
        return int(count_ops(self[name]))

    @cached_property
    def criteria(self) -> tuple[Criterion, ...]:
        """What is judged, each with the symbol c for its threshold, or with the scene's number."""
        limits = self.scene.threshold
        free = [x for x in Part if x in self.kept_thresholds or is_irrational_algebraic(limits[x] ** 2)]
        return opened(noticed(limits), free)

    def criterion(self, of: Part | Criterion) -> Criterion:
        """What is judged of a part, or by that name."""
        name = of.value if isinstance(of, Part) else of.name
        return next(x for x in self.criteria if x.name == name)

    def threshold(self, of: Part | Criterion) -> Expr:
        """The threshold of a part: the symbol c, or the scene's number."""
        return self.criterion(of).threshold

    def excess(self, of: Part | Criterion) -> RealFunction:
        """r^2 - c^2: positive exactly where the ratio exceeds its threshold."""
        found = self.criterion(of).function(self.distortion)
        assert isinstance(found, RealFunction)
        return found

    def crossings(self, of: Part | Criterion) -> tuple[Solution, ...]:
        """Where the ratio meets its threshold: formulas, or for factors without a readable one the equation itself."""
        return solve(self.excess(of))

    def changeovers(self, system: str) -> tuple[Solution, ...]:
        """Where Re H of the environment ("env") or of what is felt ("perc") vanishes."""
        response = self.distortion.env_response if system == "env" else self.distortion.perc_response
        return solve(response.real)

    def sensitivity(self, of: Part | Criterion, parameter: Symbol) -> Expr:
        """d omega/d parameter at a crossing: -(dF/d parameter)/(dF/d omega) for the equation F = 0 of the crossing.

        At a touch dF/d omega is 0 too and the derivative does not exist: the formula holds at simple crossings only.
        """
        return self.equation(of).slope(parameter).expression()

    def equation(self, of: Part | Criterion) -> Equation:
        """F = 0 at the crossings: F is the numerator of r^2 - c^2."""
        return _equation(self.excess(of))

    def factors(self, of: Part | Criterion, *, pole: bool = False) -> Factors:
        """The irreducible factors of r^2 - c^2 above the line (below it, with ``pole``), each an equation, with its order."""
        return _factors(self.excess(of), pole=pole)

    def changeover_factors(self, system: str, *, pole: bool = False) -> Factors:
        """The same of Re H of "env" or "perc"."""
        response = self.distortion.env_response if system == "env" else self.distortion.perc_response
        return _factors(response.real, pole=pole)

    @cached_property
    def groups(self) -> Groups:
        """The scene in independent dimensionless groups; SceneError where the units do not tell."""
        return groups(self.scene)

    def expansion(self, order: int = 1) -> Expansion:
        """The leading terms for fast devices, with a proven bound on the rest; SceneError where no device has a speed."""
        return expansion(self.scene, order)

    def at(self, **values: Number) -> Evaluation:
        """Certified answers for values of the parameters, by name; what is not named keeps the scene's value.

        >>> from haptisym.model.scenefile import load_scene
        >>> derive(load_scene("fu2019")).at(omega_n="160 rad/s").bandwidth is None
        False
        """
        return evaluate(self.scene.with_values(values))


def _equation(f: RealFunction) -> Equation:
    written = f.written
    return Equation(written.ring, written.numerator)


def _factors(f: RealFunction, *, pole: bool) -> Factors:
    whole = f.function.denominator if pole else f.function.numerator
    _, factors = f.axis.factors(whole, in_square=not f.axis.functions)
    return tuple((_equation(RealFunction(f.axis.function(factor))), n) for factor, n in factors)


def derive(scene: Scene | str | Path, keep: Iterable[str] | None = None) -> Derivation:
    """The formulas of a scene.

    ``keep`` : the names of the parameters that stay symbols; None for all of them and the threshold, () for none. A name
    that the scene does not have raises SceneError.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = derive(load_scene("fu2019"), keep=["omega_n"])
    >>> found["H_perc"]
    omega_n**2*(9*s**2 + 75*s + 500)/(5*omega_n**2 + 5*omega_n*s + 5*s**2)
    >>> [x.omega for x in derive(load_scene("fu2019")).changeovers("env")]
    [sqrt(k)/sqrt(m)]
    """
    scene = as_scene(scene)
    if keep is None:
        return Derivation(scene, tuple(x.symbol for x in scene.parameters))
    kept = [scene.knobs[name] for name in ([keep] if isinstance(keep, str) else keep)]
    thresholds = tuple(part for part in Part if any(part in x.parts for x in kept))
    return Derivation(scene, tuple(x.symbol for x in kept if not x.parts), thresholds)


def _threshold_polynomial(part: Part) -> Callable[[Derivation], Expr]:
    def polynomial(d: Derivation) -> Expr:
        f = d.excess(part).written
        unit, factors = f.ring.factors(f.numerator)
        found = f.ring.one.expression() * (1 if unit > 0 else -1)
        for factor, n in factors:
            found *= f.ring.expression(factor) ** n
        return found

    return polynomial


def _jnd(power: int) -> Callable[[Derivation], Expr]:
    return lambda d: c * d.distortion.modulus / omega**power


def _properties(system: str) -> dict[str, Callable[[Derivation], Expr]]:
    def of(d: Derivation) -> tuple[Expr, Expr]:
        response = d.distortion.env_response if system == "env" else d.distortion.perc_response
        return part_of(response, Part.REAL).factored(), part_of(response, Part.IMAG).factored()

    return {
        f"k_{system}": lambda d: of(d)[0],
        f"m_{system}": lambda d: -of(d)[0] / omega**2,
        f"b_{system}": lambda d: of(d)[1] / omega,
        f"F_si_{system}": lambda d: X * of(d)[0],
        f"F_d_{system}": lambda d: I * X * of(d)[1],
    }


QUANTITIES: Mapping[str, Callable[[Derivation], Expr]] = MappingProxyType(
    {
        "H_env": lambda d: d.distortion.environment,
        "H_perc": lambda d: d.distortion.perceived,
        "dH": lambda d: d.distortion.distortion,
        "Re dH": lambda d: d.distortion.real,
        "Im dH": lambda d: d.distortion.imag,
        "|H_env|^2": lambda d: d.distortion.squared_modulus.factored(),
        "r_r": lambda d: d.distortion.ratio_real,
        "r_i": lambda d: d.distortion.ratio_imag,
        "Re(dH/H_env)": lambda d: d.distortion.relative_real,
        "Im(dH/H_env)": lambda d: d.distortion.relative_imag,
        "p_r": _threshold_polynomial(Part.REAL),
        "p_i": _threshold_polynomial(Part.IMAG),
        **_properties("env"),
        **_properties("perc"),
        "jnd k": _jnd(0),
        "jnd b": _jnd(1),
        "jnd m": _jnd(2),
    }
)
"""The closed forms that a derivation has, by name."""


def bare(name: str) -> str:
    """A name without what a shell or a typist leaves out.

    >>> bare("|H_env|^2"), bare("Re dH")
    ('henv2', 'redh')
    """
    return "".join(x for x in name.casefold() if x.isalnum())


def listed_name(name: str) -> str | None:
    """The quantity that a name stands for, as it is listed; None if it is none."""
    return next((known for known in QUANTITIES if bare(known) == bare(name)), None)
