"""The formulas of a scene for the parameters that a user wants to keep as symbols: closed, in steps, solved, dimensionless."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from operator import attrgetter
from pkgutil import resolve_name
from types import MappingProxyType
from typing import Any, ClassVar, TypeAlias

from sympy import Expr, Symbol, count_ops

from haptisym.judge.answers import Answer
from haptisym.judge.criteria import Criterion, noticed, opened
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.kernel.errors import SceneError
from haptisym.kernel.implicit import Equation
from haptisym.kernel.lattices import Lattice, Piece
from haptisym.kernel.response import RealFunction
from haptisym.kernel.shown import titled
from haptisym.kernel.solutions import Solution, solve
from haptisym.kernel.symbols import c
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, is_irrational_algebraic
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.programs.steps import Steps
from haptisym.verbs.derive.asymptotics import Expansion, expansion
from haptisym.verbs.derive.groups import Groups, groups

Factors: TypeAlias = tuple[tuple[Equation, int], ...]
"""Irreducible factors as equations, each with its order."""


@dataclass(frozen=True, repr=False)
class Derivation(Answer):
    """The formulas of a scene; ``kept``: the parameters that stay symbols, the others have the scene's values.

    ``derivation["Re dH"]`` is a closed form, under the names of ``QUANTITIES``; ``steps`` is the distortion in short named
    steps; ``crossings`` and ``changeovers`` are solved where a formula is readable, and otherwise the equation to solve.
    """

    scene: Scene
    kept: tuple[Symbol, ...]
    kept_thresholds: tuple[Part, ...] = tuple(Part)
    of: tuple[str, ...] = ()
    """The quantities that its page shows; none for all that it says unasked."""

    _schema: ClassVar[str] = "haptisym.derivation/1"
    _page: ClassVar[str] = "haptisym.pages.derive:page"

    def _line(self) -> str:
        kept = ", ".join(p.name for p in self.kept) or "nothing"
        return f"{titled(self.scene.title)}: {kept} as symbols"

    def _body(self) -> dict[str, Any]:
        found: dict[str, Any] = resolve_name("haptisym.pages.derive:body")(self)
        return found

    def to_latex(self) -> str:
        r"""LaTeX for a paper, a paragraph for each section: what ``haptisym derive --to latex`` prints."""
        return str(resolve_name("haptisym.pages.derive:latex")(self))

    @cached_property
    def chain(self) -> Chain:
        """The dynamics with the scene's values for all parameters that are not kept."""
        return self.scene.chain.at({p.symbol: p.value for p in self.scene.parameters if p.symbol not in self.kept})

    @cached_property
    def distortion(self) -> Distortion:
        """The closed forms, exact."""
        return Distortion.of(self.chain)

    @cached_property
    def environment(self) -> Distortion:
        """The closed forms of the environment alone, felt as it is: for these no chain is multiplied out."""
        own = self.chain.environment
        return Distortion.of(Chain(own, own, ()))

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
        """What is judged of a part, or by that name; SceneError for a JND of which there are no such formulas."""
        if self.kept_thresholds:
            self.scene.threshold.need_plain("formulas of crossings")
        name = of.value if isinstance(of, Part) else of.name
        return next(x for x in self.criteria if x.name == name)

    def threshold(self, of: Part | Criterion) -> Expr:
        """The threshold of a part: the symbol c, or the scene's number."""
        return self.criterion(of).threshold

    def excess(self, of: Part | Criterion) -> RealFunction:
        """r^2 - c^2: positive exactly where the ratio exceeds its threshold."""
        own = self.criterion(of)
        found = own.function(self.distortion)
        if isinstance(found, RealFunction):
            return found
        raise SceneError(
            f"a formula of what is judged: the JND is {self.scene.threshold.kind}, of several functions of omega"
        )

    def piece(self, of: Piece) -> RealFunction:
        """One of the functions of which a region asks that they are not all positive."""
        own = next(x for x in self.criteria if x == of.name)
        found = own.function(self.distortion)
        assert isinstance(found, Lattice)
        function = found.terms[of.term][of.place]
        assert isinstance(function, RealFunction)
        return function

    def crossings(self, of: Part | Criterion) -> tuple[Solution, ...]:
        """Where the ratio meets its threshold: formulas, or for factors without a readable one the equation itself."""
        return solve(self.excess(of))

    def stiffness(self, system: str) -> RealFunction:
        """Re H of the environment ("env") or of what is felt ("perc")."""
        return self.environment.env_response.real if system == "env" else self.distortion.perc_response.real

    def changeovers(self, system: str) -> tuple[Solution, ...]:
        """Where Re H of the environment ("env") or of what is felt ("perc") vanishes."""
        return solve(self.stiffness(system))

    def sensitivity(self, of: Part | Criterion, parameter: Symbol) -> Expr:
        """d omega/d parameter at a crossing: -(dF/d parameter)/(dF/d omega) for the equation F = 0 of the crossing.

        At a touch dF/d omega is 0 too and the derivative does not exist: the formula holds at simple crossings only.
        """
        return self.equation(of).slope(parameter).expression()

    def equation(self, of: Part | Criterion) -> Equation:
        """F = 0 at the crossings: F is the numerator of r^2 - c^2."""
        return _equation(self.excess(of))

    def factors(self, of: Criterion | Piece | str) -> Factors:
        """Of r^2 - c^2, of one function of a region, or of Re H of a system, the irreducible factors above and below the line."""
        f = self.stiffness(of) if isinstance(of, str) else self.piece(of) if isinstance(of, Piece) else self.excess(of)
        lines = (
            f.axis.factors(x, in_square=not f.axis.functions)[1] for x in (f.function.numerator, f.function.denominator)
        )
        pairs = ((f.axis.in_half_angles(factor), n) for factor, n in chain(*lines))
        return tuple((Equation(own.ring, own.numerator), n) for own, n in pairs)

    @cached_property
    def groups(self) -> Groups:
        """The scene in independent dimensionless groups; SceneError where the units do not tell."""
        return groups(self.scene)

    def expansion(self, order: int = 1) -> Expansion:
        """The leading terms for fast devices, with a proven bound on the rest; SceneError where no device has a speed."""
        return expansion(self.scene, order)

    def at(self, **values: Number) -> Evaluation:
        """Certified answers for values of the parameters, by name; what is not named keeps the scene's value.

        >>> from haptisym.verbs.derive.entry import derive
        >>> derive("fu2019").at(omega_n="160 rad/s").bandwidth is None
        False
        """
        return evaluate(self.scene.with_values(values))


def _equation(f: RealFunction) -> Equation:
    written = f.written
    return Equation(written.ring, written.numerator)


def _threshold_polynomial(part: Part) -> Callable[[Derivation], Expr]:
    def polynomial(d: Derivation) -> Expr:
        f = d.excess(part).written
        unit, factors = f.ring.factors(f.numerator)
        found = f.ring.one.expression() * (1 if unit > 0 else -1)
        for factor, n in factors:
            found *= f.ring.expression(factor) ** n
        return found

    return polynomial


def _of_distortion(path: str) -> Callable[[Derivation], Expr]:
    """What the distortion has under this name; of a real function its factored form."""

    def found(d: Derivation) -> Expr:
        value = attrgetter(path)(d.distortion)
        return value.factored() if isinstance(value, RealFunction) else value

    return found


def _jnd(name: str) -> Callable[[Derivation], Expr]:
    return lambda d: getattr(d.distortion.parameter_jnd(c), name)


_PERCEIVED = {"k": "stiffness", "m": "mass", "b": "damping", "F_si": "spring_inertia_force", "F_d": "damping_force"}
_SYSTEMS = {"env": "environment_properties", "perc": "perceived_properties"}

QUANTITIES: Mapping[str, Callable[[Derivation], Expr]] = MappingProxyType(
    {
        "H_env": lambda d: d.environment.environment,
        "H_perc": _of_distortion("perceived"),
        "dH": _of_distortion("distortion"),
        "Re dH": _of_distortion("real"),
        "Im dH": _of_distortion("imag"),
        "|H_env|^2": _of_distortion("squared_modulus"),
        "r_r": _of_distortion("ratio_real"),
        "r_i": _of_distortion("ratio_imag"),
        "Re(dH/H_env)": _of_distortion("relative_real"),
        "Im(dH/H_env)": _of_distortion("relative_imag"),
        "p_r": _threshold_polynomial(Part.REAL),
        "p_i": _threshold_polynomial(Part.IMAG),
        **{
            f"{x}_{of}": _of_distortion(f"{own}.{name}")
            for of, own in _SYSTEMS.items()
            for x, name in _PERCEIVED.items()
        },
        **{f"jnd {x}": _jnd(_PERCEIVED[x]) for x in ("k", "b", "m")},
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
