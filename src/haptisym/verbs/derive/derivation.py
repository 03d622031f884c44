"""The formulas of a haptic display for the parameters that a user wants to keep as symbols.

**Question.** A *scene* is a haptic display: an environment to be felt, with the dynamics H_env(s)
(force over motion), effects (filters, delays, samplers ...) behind which it is felt as H_perc(s), a
band of frequencies and a threshold c. Let dH = H_perc - H_env be the distortion. On s = j omega the
ratios

    r_r = abs(Re dH)/abs(H_env)   and   r_i = abs(Im dH)/abs(H_env)

decide what is noticed: a change where one of them exceeds c (Fu, van Paassen and Mulder 2019,
doi:10.1016/j.ifacol.2019.12.119). Which formulas have H_perc, dH and the ratios, and at which omega
is a threshold crossed, for the parameters as symbols?

**Returned.** ``derive`` makes a ``Derivation``. It has

- all closed forms by their names (``QUANTITIES``),
- the distortion in named steps, which stay short where closed forms do not,
- crossings, r = c, and changeovers, Re H = 0, as formulas for omega, each with the conditions under
  which it holds, or as equations where no formula is short enough to read.

All are exact: identities of rational functions of s or omega, the parameters, delays and fractional
powers of s. A crossing is found as a zero of the *excess* r^2 - c^2: for r >= 0 and c > 0 it has
the sign of r - c, without square roots and absolute values. Zeros at which the excess only touches
0 are among them. What has no formula raises SceneError, which says why.

**Words.** A *system* is "env", the environment, or "perc", what is felt. A *criterion* is one
condition r <= c of the JND, the just-noticeable difference (``judge.crossings``): that of the real
part, of the imaginary part, or of a *region* of both, whose excess may be a *lattice*, a maximum of
minima of functions. A ``RealFunction`` is a function of omega in lowest terms. Leading terms for
fast devices are in ``expansion``, the dimensionless form in ``groups``.

Begin with ``derive``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from pkgutil import resolve_name
from types import MappingProxyType
from typing import Any, ClassVar, TypeAlias

from sympy import Expr, Symbol, count_ops

from haptisym import effects, environments
from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, noticed, opened
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, meant, quoted, several
from haptisym.kernel.objects import titled
from haptisym.kernel.rings import c
from haptisym.kernel.roots import Lattice, LatticePiece
from haptisym.kernel.solutions import Equation, Solution, solve
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion, Elements
from haptisym.model.jnd import Part
from haptisym.model.parameters import dimensions
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.steps import Steps
from haptisym.verbs.derive.expansion import Expansion, expansion
from haptisym.verbs.derive.groups import Groups, groups


def derive(
    scene: Scene | Distortion | str | Path,
    keep: Iterable[str | Symbol] | str | Symbol | None = None,
) -> Derivation:
    """Derive the formulas of a scene, or of a distortion in its own symbols; ``print`` shows them
    as a page of text.

    ``scene`` : a scene, the name of one that comes with haptisym, a file, or a distortion.
    ``keep`` : the parameters that stay symbols, by symbol or name, thresholds among them; the
    others have the values of the scene. None for all of them, () for none. SceneError for a name
    that the scene does not have, and for names with a distortion, all of whose symbols stay.

    >>> found = derive("fu2019", keep=["omega_n"])
    >>> found
    <Derivation "Numerical example of Fu, van Paassen and ...": omega_n as symbols>
    >>> found["H_perc"]
    omega_n**2*(9*s**2 + 75*s + 500)/(5*omega_n**2 + 5*omega_n*s + 5*s**2)
    >>> [x.omega for x in derive("fu2019").changeovers("env")]
    [sqrt(k)/sqrt(m)]
    >>> from haptisym import distort, effects, environments, symbols
    >>> derive(distort(environments.mass_spring_damper(k=100), effects.first_order_lag(symbols("w"))))["Im dH"]
    -100*omega*w/(omega**2 + w**2)
    """
    if isinstance(scene, Distortion):
        return _derived(scene, keep)
    scene = as_scene(scene)
    if keep is None:
        return Derivation(scene, tuple(x.symbol for x in scene.parameters))
    listed = [keep] if isinstance(keep, str | Symbol) else keep
    names = several("keep", listed, "give names of parameters")
    # A knob is a parameter, or with ``parts`` a threshold: that of these parts.
    kept = [scene.knobs[str(name)].felt() for name in names]
    thresholds = tuple(part for part in Part if any(part in x.parts for x in kept))
    return Derivation(scene, tuple(x.symbol for x in kept if not x.parts), thresholds)


def _derived(d: Distortion, keep: Iterable[str] | None) -> Derivation:
    """The derivation of a distortion, of which all symbols stay symbols."""
    if keep is not None:
        raise SceneError("keep: a distortion keeps its symbols: leave it out")
    if d.value is not None:
        raise SceneError(f"omega is {d.value}: derive the distortion without it")
    environment, elements, rendered = d.elements or _elements(d.chain)
    made = Scene(environment, elements, rendered=rendered, title="Distortion")
    return Derivation(made, (), of_scene=False)


def _elements(chain: Chain) -> Elements:
    """The environment, the effects, and what is rendered in place of the environment (None: the
    environment), made from the dynamics of a chain.

    For a distortion that does not know its elements, as one into which values were put.
    """
    felt, rendered = map(environments.expression, (chain.environment, chain.rendered))
    ports = tuple(effects.two_port(*matrix) for matrix in chain.matrices)
    return felt, ports, None if chain.rendered == chain.environment else rendered


Factors: TypeAlias = tuple[tuple[Equation, int], ...]
"""Irreducible factors as equations, each with its multiplicity."""


@dataclass(frozen=True, repr=False)
class Derivation(Answer):
    """The formulas of a scene.

    ``kept`` : the parameters that stay symbols; the others have the values of the scene.
    ``kept_thresholds`` : the parts, real and imaginary, whose threshold stays the symbol c.

    ``derivation["Re dH"]`` is a closed form, under a name of ``QUANTITIES``. An argument ``of`` of
    a method is a criterion, or the part that names it, Part.REAL or Part.IMAG. (The field ``of`` is
    another thing: what the page shows.)
    """

    scene: Scene
    kept: tuple[Symbol, ...]
    kept_thresholds: tuple[Part, ...] = tuple(Part)
    of: tuple[str, ...] = ()
    """The quantities that its page shows; empty for those that it shows by default."""
    shows_groups: bool = False
    """Whether its page shows the dimensionless form, too."""
    of_scene: bool = True
    """Whether it is of a scene, and not of a distortion."""

    # What the base class needs: the schema of the document, and what writes the page and draws the
    # figure, by name.
    _schema: ClassVar[str] = "haptisym.derivation/1"
    _page: ClassVar[str] = "haptisym.pages.derive:page"
    _figure: ClassVar[str] = "haptisym.figures.evaluation:DERIVATION"

    def _line(self) -> str:
        """What ``repr`` shows."""
        # A derivation of a distortion keeps nothing, as it has no values: all symbols stay.
        symbols = self.kept or self.chain.parameters
        kept = ", ".join(p.name for p in symbols) or "nothing"
        return f"{titled(self.scene.title)}: {kept} as symbols"

    def _body(self) -> dict[str, Any]:
        """The document of ``to_json``."""
        body: dict[str, Any] = resolve_name("haptisym.pages.derive:body")(self)
        return body

    def to_latex(self) -> str:
        r"""LaTeX for a paper, a paragraph for each section: what ``haptisym derive --to latex``
        prints."""
        return str(resolve_name("haptisym.pages.derive:latex")(self))

    @cached_property
    def chain(self) -> Chain:
        """The dynamics with the scene's values for all parameters that are not kept."""
        return self.scene.chain.replaced(
            {p.symbol: p.value for p in self.scene.parameters if p.symbol not in self.kept}
        )

    @cached_property
    def distortion(self) -> Distortion:
        """H_perc, dH and the ratios of ``chain``, as closed forms."""
        # What each symbol or value measures, by which results have units.
        measured = dimensions(
            (p.symbol if p.symbol in self.kept else p.value, p.dimension)
            for p in self.scene.parameters
        )
        return replace(Distortion.of(self.chain), dimensions=measured)

    @cached_property
    def environment(self) -> Distortion:
        """The closed forms of the environment alone. They are those of ``distortion``, but need no
        product of chain matrices, which may be long."""
        H = self.chain.environment
        return Distortion.of(Chain(H, H, ()))

    @cached_property
    def steps(self) -> Steps:
        """The distortion in named steps, which stay short as devices are cascaded."""
        return self.chain.steps

    def __getitem__(self, name: str) -> Expr:
        key = listed_name(str(name))
        if key is None:
            raise SceneError(
                f"unknown quantity {quoted(name)}: {meant(str(name), QUANTITIES)}valid are "
                f"{', '.join(QUANTITIES)}"
            )
        return QUANTITIES[key](self)

    def __iter__(self) -> Iterator[str]:
        return iter(QUANTITIES)

    def __contains__(self, name: object) -> bool:
        """Whether ``derivation[name]`` is a closed form."""
        return isinstance(name, str) and listed_name(name) is not None

    def operations(self, name: str) -> int:
        """The number of operations of a closed form, expanded."""
        return int(count_ops(self[name]))

    @cached_property
    def criteria(self) -> tuple[Criterion, ...]:
        """The criteria of the scene's JND, each with the symbol c for its threshold where that is
        kept, else with the scene's number."""
        return opened(noticed(self.scene.threshold), self.kept_thresholds)

    def criterion(self, of: Part | Criterion) -> Criterion:
        """The criterion of a part, or of the name of a criterion, as it is in ``criteria``: with c
        in place of a threshold that is kept.

        SceneError where a threshold is kept as c although the JND is not one number for each part:
        c would have no meaning.
        """
        if self.kept_thresholds:
            self.scene.threshold.need_plain("formulas of crossings")
        name = of.value if isinstance(of, Part) else of.name
        return next(x for x in self.criteria if x.name == name)

    def threshold(self, of: Part | Criterion) -> Expr:
        """The threshold of a criterion: the symbol c, or the number of the scene."""
        return self.criterion(of).threshold

    def excess(self, of: Part | Criterion) -> RealFunction:
        """The excess r^2 - c^2: positive exactly where the ratio exceeds its threshold. SceneError
        for a criterion that is no single formula, as that of a polygon."""
        return self._excess(of, self.distortion)

    def _excess(self, of: Part | Criterion, d: Distortion) -> RealFunction:
        """As ``excess``, for a distortion that is equal to that of this derivation."""
        function = self.criterion(of).function(d)
        if isinstance(function, RealFunction):
            return function
        raise SceneError(
            f"no single formula: the JND is {self.scene.threshold.kind}; give one number for "
            f"each part, as jnd = 0.1"
        )

    def piece(self, of: LatticePiece) -> RealFunction:
        """One of the functions of which the excess of a region is the maximum of minima (a
        lattice).

        ``of`` : its key on a chart: the criterion of the region (``name``), which of the minima
        (``term``), and its ``place`` in that.
        """
        criterion = next(x for x in self.criteria if x == of.name)
        lattice = criterion.function(self.distortion)
        assert isinstance(lattice, Lattice)
        function = lattice.terms[of.term][of.place]
        assert isinstance(function, RealFunction)
        return function

    def crossings(self, of: Part | Criterion, *, readable: bool = False) -> tuple[Solution, ...]:
        """The positive frequencies at which the ratio equals its threshold, as formulas with their
        conditions.

        Where a factor of the excess has no formula that is short enough to read, its equation
        stands in place of one; with ``readable`` nothing does.
        """
        # Delays of which only the sum is felt are one delay there: an equal function, with fewer
        # angles to solve for.
        return solve(self._excess(of, self.distortion.with_one_delay), readable=readable)

    def stiffness(self, system: str) -> RealFunction:
        """Re H of a system, "env" or "perc", on s = j omega: k - m omega^2 of a spring and a mass.
        SceneError for any other name."""
        if system == "env":
            return self.environment.env_response.real
        if system != "perc":
            raise SceneError(f'system: "{system}" is none: give "env" or "perc"')
        return self.distortion.perc_response.real

    def changeovers(self, system: str) -> tuple[Solution, ...]:
        """The positive frequencies at which Re H of a system, "env" or "perc", is 0, as formulas or
        equations: there it changes from a spring to a mass, or back."""
        return solve(self.stiffness(system))

    def sensitivity(self, of: Part | Criterion, parameter: Symbol) -> Expr:
        """d omega/d parameter at a crossing, a formula in omega.

        By the implicit function theorem it is -(dF/d parameter)/(dF/d omega) for the equation F = 0
        of the crossing. The formula holds at simple crossings alone: where the ratio only touches
        its threshold dF/d omega is 0, and the derivative need not exist.
        """
        return self.equation(of).slope(parameter).expression()

    def equation(self, of: Part | Criterion) -> Equation:
        """The equation F = 0 of the crossings: F is the numerator of the excess."""
        return _equation(self.excess(of))

    def factors(self, of: Criterion | LatticePiece | str) -> Factors:
        """The irreducible factors of numerator and denominator of a function, as equations: it
        changes its sign only where one of them is 0, at a zero or, as Re H may, at a pole.

        ``of`` : for the excess, its criterion; for one function of a region, its key as of
        ``piece``; for Re H, the system, "env" or "perc".
        """
        if isinstance(of, str):
            f = self.stiffness(of)
        elif isinstance(of, LatticePiece):
            f = self.piece(of)
        else:
            f = self.excess(of)
        factors = []
        for polynomial in (f.function.numerator, f.function.denominator):
            # In omega^2, unless there are functions of omega, as cos(omega tau).
            _, pairs = f.axis.factors(polynomial, in_square=not f.axis.functions)
            for factor, multiplicity in pairs:
                # A factor is a polynomial in the tangents of half angles: as a reader has them, in
                # sines and cosines.
                written = f.axis.in_half_angles(factor)
                factors.append((Equation(written.ring, written.numerator), multiplicity))
        return tuple(factors)

    @cached_property
    def groups(self) -> Groups:
        """The scene in independent dimensionless groups, of all parameters, also of those that are
        not kept; SceneError where the units do not show them."""
        return groups(self.scene)

    def expansion(self, order: int = 1) -> Expansion:
        """The leading terms for fast devices in all parameters, with a proven bound on the rest at
        the scene's values; SceneError where no device has a speed."""
        return expansion(self.scene, order)

    def at(self, /, **values: Number) -> Evaluation:
        """Certified answers for values of the parameters, by name; what is not named keeps the
        scene's value.

        >>> from haptisym.verbs.derive.derivation import derive
        >>> derive("fu2019").at(omega_n="160 rad/s").bandwidth is None
        False
        """
        return evaluate(self.scene.with_values(values))


def _equation(f: RealFunction) -> Equation:
    """The equation f = 0, by the numerator of f in the form in which it is written for a reader: in
    omega, sines and cosines."""
    written = f.written
    return Equation(written.ring, written.numerator)


def _threshold_polynomial(part: Part) -> Callable[[Derivation], Expr]:
    """Return what gives the threshold polynomial of a part, in factors: up to a positive number the
    numerator of the excess. It has the sign of the excess, whose denominator is abs(H_env)^2 times
    a square."""

    def polynomial(d: Derivation) -> Expr:
        f = d.excess(part).written
        unit, factors = f.ring.factors(f.numerator)
        # Of a constant factor the sign alone matters; it is 0 where the ratio is c everywhere.
        product = f.ring.one.expression() * (1 if unit > 0 else -1 if unit < 0 else 0)
        for factor, multiplicity in factors:
            product *= f.ring.expression(factor) ** multiplicity
        return product

    return polynomial


def _of_distortion(path: str) -> Callable[[Derivation], Expr]:
    """Return what gives an attribute of the distortion, by its path of attributes; of a real
    function the factored form."""

    def form(d: Derivation) -> Expr:
        value = attrgetter(path)(d.distortion)
        return value.factored() if isinstance(value, RealFunction) else value

    return form


def _jnd(name: str) -> Callable[[Derivation], Expr]:
    """Return what gives the change of a parameter, "stiffness", "damping" or "mass", that a threshold
    amounts to. It has the symbol c always, so that one formula holds for every threshold."""
    return lambda d: getattr(d.distortion.parameter_jnd(c), name)


# The closed forms by name.

_PERCEIVED = {
    "k": "stiffness",
    "m": "mass",
    "b": "damping",
    "F_si": "spring_inertia_force",
    "F_d": "damping_force",
}
"""Attributes of ``model.properties.Properties`` by the letter in a quantity's name: as which stiffness,
mass and damping a system is felt."""
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
            f"{letter}_{system}": _of_distortion(f"{properties}.{name}")
            for system, properties in _SYSTEMS.items()
            for letter, name in _PERCEIVED.items()
        },
        **{f"jnd {x}": _jnd(_PERCEIVED[x]) for x in ("k", "b", "m")},
    }
)
"""The closed forms that a derivation has, by name."""


def bare(name: str) -> str:
    """A name in lower-case letters and digits alone, as it may be typed in a shell.

    >>> bare("|H_env|^2"), bare("Re dH")
    ('henv2', 'redh')
    """
    return "".join(x for x in name.casefold() if x.isalnum())


def listed_name(name: str) -> str | None:
    """The quantity that a name stands for, as QUANTITIES lists it; None if it is none.

    Signs may be left out in a shell. Those that are there count: ``|dH|`` is not dH.

    >>> listed_name("re_dh"), listed_name("henv2"), listed_name("|H_env|"), listed_name("-dH")
    ('Re dH', '|H_env|^2', None, None)
    """
    signs = _signs(name)
    return next((x for x in QUANTITIES if bare(x) == bare(name) and signs in ("", _signs(x))), None)


def _signs(name: str) -> str:
    """The bars and powers of a name, and a minus before it: they change what it means."""
    return "-" * name.lstrip().startswith("-") + "".join(x for x in name if x in "|^")
