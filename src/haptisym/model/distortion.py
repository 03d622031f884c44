"""Closed forms: what is felt instead of the environment, and by how much it differs.

A ``Distortion`` is H_env, H_perc and dH = H_perc - H_env in lowest terms, with all closed forms of
them: Re and Im of dH, the ratios r_r = |Re dH|/|H_env| and r_i = |Im dH|/|H_env| that the JND
judges, their crossings of a threshold, bandwidth, changeover frequencies and asymptotes. All is
exact; ``compile`` makes numbers of it. Begin with ``distort``.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, overload

from sympy import Abs, Add, Expr, I, Poly, Rational, Symbol, count_ops, im, lambdify, oo, re, sqrt

from haptisym.kernel.arrays import in_floats
from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import (
    RealFunction,
    Response,
    Ring,
    on_axis,
    over_squares,
    ring_of,
    squared_modulus,
)
from haptisym.kernel.errors import SceneError, meant, need, quoted, within
from haptisym.kernel.harmonics import computable, staircase
from haptisym.kernel.names import keywords
from haptisym.kernel.objects import Shown, copied, counted, viewed
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import Polynomial, RationalFunction, X, monomials, omega, s
from haptisym.kernel.rings import c as symbol_c
from haptisym.kernel.solutions import Solution, solve, solved_for
from haptisym.model.asymptotes import Asymptote, LowFrequency, asymptote, low_frequency
from haptisym.model.catalogue import (
    Effect,
    Environment,
    given_effects,
    given_environment,
    with_controller,
)
from haptisym.model.chain import Chain, real_factor, unused
from haptisym.model.closedforms import (
    part_of_distortion,
    part_of_relative,
    prefers_lowest,
    shortest,
)
from haptisym.model.frequencies import (
    bandwidth,
    crossings,
    excess,
    free_parameters,
    lowest_formula,
    sign_changes,
    threshold,
    threshold_polynomial,
    zeros,
)
from haptisym.model.jnd import Part
from haptisym.model.parameters import dimensions, in_place
from haptisym.model.properties import ParameterJND, Properties, properties
from haptisym.model.quantities import Dimension, Number, constant, in_laplace, quantity
from haptisym.programs.accuracy import Accuracy, Backend

if TYPE_CHECKING:
    from haptisym.programs.steps import Steps

    # Brings NumPy, which a certified answer does not need.
    from haptisym.programs.values import Compiled


def distort(
    environment: Any,
    *effects: Any,
    rendered: Any = None,
    omega: Symbol = omega,
    laplace: Symbol | None = None,
) -> Distortion:
    """Return the distortion of an environment by effects, nearest the environment first; without
    effects there is none.

    ``rendered`` is what the controller renders where that is not the environment itself: H_perc is
    built on it, while dH and the ratios compare with ``environment``; where it has
    ``k="environment.k"``, that is the environment's k. Parameters may be numbers or symbols. Each
    may be a system that ``interop.dynamics`` takes (an expression in s of SymPy, a transfer
    function of python-control or SciPy, a pair of coefficients), an effect then one in series.
    Floats are read as their shortest decimals, 1/3 as sixteen digits.
    ``omega`` : the symbol of the frequency in closed forms, ``hs.omega`` unless given; expressions
    may be written in I*omega, too, and are rewritten in s where that is exact. ``laplace`` : the
    letter that expressions have for s, s unless given. Raises SceneError where H_env is zero
    everywhere or H_perc is not a dynamics.

    >>> from haptisym import effects, environments
    >>> d = distort(environments.mass_spring_damper(k=100), effects.first_order_lag(20))
    >>> d.perceived, d.real
    (2000/(s + 20), -100*omega**2/(omega**2 + 400))
    >>> from sympy import Symbol
    >>> distort(Symbol("s") + 100, ([20], [1, 20])).perceived
    (20*s + 2000)/(s + 20)
    >>> w = Symbol("w", positive=True)
    >>> distort(I * w + 100, 20 / (I * w + 20), omega=w).imag
    -w*(w**2 + 2000)/(w**2 + 400)
    """
    need("omega", omega, Symbol, "give a symbol, as Symbol('w')")
    need("laplace", laplace, Symbol | None, "give a symbol, as Symbol('p')")

    def read(key: str, given: Any) -> Any:
        with within(key):
            return in_laplace(given, laplace, omega) if isinstance(given, Expr) else given

    elements = _elements(
        read("environment", environment),
        [read(f"effects[{i}]", x) for i, x in enumerate(effects, 1)],
        read("rendered", rendered),
    )
    chain = _chain_of(*elements)
    if omega.name in {s.name, *(x.name for x in chain.parameters)}:
        raise SceneError(
            f'omega: {quoted(omega)} is s or a parameter: give another symbol, as Symbol("w")'
        )
    found = Distortion.of(chain)
    return replace(found, frequency=omega, elements=elements, dimensions=_measured(elements))


def felt_instead(environment: Any, effects: Iterable[Any], rendered: Any = None) -> Distortion:
    """Return the distortion as ``distort`` does, but in free air too, where H_env is zero and the
    ratios do not exist: for questions about H_perc alone."""
    chain = _chain_of(*(elements := _elements(environment, effects, rendered)))
    env, perc = chain.dynamics(free_air=True)
    return Distortion(env, perc, chain, elements=elements, dimensions=_measured(elements))


Elements: TypeAlias = tuple[Environment, tuple[Effect, ...], Environment | None]


def _elements(environment: Any, effects: Iterable[Any], rendered: Any) -> Elements:
    """Return environment, effects, and what is rendered where that is another one."""
    given = given_environment("environment", environment)
    other = None if rendered is None else given_environment("rendered", rendered).tied_to(given)
    return given, tuple(with_controller(given_effects(effects), other or given)), other


def _measured(elements: Elements) -> dict[Symbol, Dimension]:
    """Return what the symbols measure that are values of parameters."""
    environment, effects, rendered = elements
    known: list[Environment | Effect] = [environment, *effects]
    known += [rendered] if rendered else []
    return dimensions((p.value, p.dimension) for element in known for p in element.parameters)


def _chain_of(
    environment: Environment, effects: tuple[Effect, ...], rendered: Environment | None
) -> Chain:
    """Return the chain of elements with their parameters' values."""
    H = environment.H
    seen = (rendered or environment).seen_by(effects)
    return Chain(H, H if seen is environment else seen.H, tuple(e.matrix for e in effects))


Frequencies = tuple[Solution, ...] | tuple[RealNumber, ...]
"""Formulas, each with the conditions under which it is in force; or, where all are numbers,
certified frequencies."""


class Changeovers(NamedTuple):
    """All frequencies at which Re H_env and Re H_perc change their sign."""

    environment: Frequencies
    perceived: Frequencies

    def _repr_latex_(self) -> str | None:
        return viewed(self, "latex")


class CrossingSolutions(NamedTuple):
    """All values at which r_r, and at which r_i, equals a threshold."""

    real: tuple[Solution, ...]
    imag: tuple[Solution, ...]

    def _repr_latex_(self) -> str | None:
        return viewed(self, "latex")


@dataclass(frozen=True, repr=False, eq=False)
class Distortion(Shown):
    """A distortion holds the environment H_env, the perceived dynamics H_perc and their difference
    ``dH = H_perc - H_env`` (eq. 9), exact.

    Closed forms are SymPy expressions in ``s`` or ``omega`` (rad/s), factored, with common factors
    cancelled. Two that have the same H_env and H_perc are equal, whatever they are made of.
    ``real``, ``imag`` : Re dH and Im dH, N/m or N m/rad. ``ratio_real``, ``ratio_imag`` : ``r_r =
    |Re dH|/|H_env|`` and
    ``r_i = |Im dH|/|H_env|`` (eq. 10), which the JND judges. ``relative_real``, ``relative_imag`` :
    Re and Im of dH/H_env, which are *not* the ratios. ``compile`` makes NumPy functions of them.
    Made by ``distort``, which raises SceneError.
    Source: Fu, van Paassen and Mulder (2019); derivation 01_paper_example.

    >>> from haptisym import effects, environments, symbols
    >>> k, w = symbols("k w")
    >>> distort(environments.mass_spring_damper(k=k), effects.first_order_lag(w)).ratio_real
    omega**2/(omega**2 + w**2)
    """

    env: RationalFunction = field(repr=False)
    perc: RationalFunction = field(repr=False)
    chain: Chain
    frequency: Symbol = omega
    """The symbol of omega in closed forms."""
    value: Expr | None = None
    """The frequency at which closed forms are taken, rad/s; None where it stays a symbol."""
    elements: Elements | None = field(default=None, repr=False)
    """The environment, effects and rendered environment of which the chain is made; None where it
    was given as dynamics."""
    dimensions: Mapping[Symbol, Dimension] = field(default_factory=dict, repr=False)
    """What its symbols measure, as far as that is known: those of expressions measure anything."""

    @classmethod
    def of(cls, chain: Chain, ring: Ring | None = None) -> Distortion:
        """Return the closed forms of a chain, in a ring that holds it (the smallest one unless
        given).

        Raises SceneError where H_env is zero everywhere or H_perc is not a dynamics.
        """
        return cls(*chain.dynamics(ring), chain)

    __reduce__ = copied

    @cached_property
    def _known(self) -> tuple[object, ...]:
        """Return what is equal where distortions are: in lowest terms, whatever ring they are
        in."""
        parts = (f.cleared() for f in (self.env, self.perc))
        forms = (f.ring.expression(p) for f in parts for p in (f.numerator, f.denominator))
        return (*forms, self.frequency, self.value)

    def __eq__(self, other: object) -> bool:
        return self._known == other._known if isinstance(other, Distortion) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._known)

    def _line(self) -> str:
        here = "" if self.value is None else f", at {self.frequency} = {self.value}"
        made = counted(len(self.chain.matrices), "effect")
        return f"of H_env = {self.chain.environment}, {made}{here}"

    @cached_property
    def difference(self) -> RationalFunction:
        """Return dH with common factors cancelled: the one place where they are."""
        return (self.perc - self.env).reduced()

    @cached_property
    def env_response(self) -> Response:
        """Return H_env on s = j omega."""
        return on_axis(self.env)

    @cached_property
    def perc_response(self) -> Response:
        """Return H_perc on s = j omega."""
        return on_axis(self.perc)

    @cached_property
    def difference_response(self) -> Response:
        """Return dH on s = j omega."""
        return on_axis(self.difference)

    @cached_property
    def relative_response(self) -> Response:
        """Return dH/H_env on s = j omega."""
        return on_axis((self.difference / self.env).reduced())

    @cached_property
    def squared_modulus(self) -> RealFunction:
        """Return ``|H_env(j omega)|^2``."""
        return squared_modulus(self.env)

    @cached_property
    def squared_ratios(self) -> dict[Part, RealFunction]:
        """Return r_r^2 and r_i^2 with common factors cancelled: limits at zeros of H_env are
        values, damping-free resonances cancel."""
        return {
            part: part_of(self.difference_response, part).square_over(self.squared_modulus)
            for part in Part
        }

    @property
    def free_symbols(self) -> frozenset[Symbol]:
        """Return the parameters that are still symbols."""
        return frozenset(
            self.env.expression().free_symbols | self.perc.expression().free_symbols
        ) - {s}

    # Closed forms for people.

    def _told(self, form: Expr) -> Expr:
        """Return the form with omega replaced by what was given for it."""
        return form if self.here == omega else in_place(form, {omega: self.here})

    @property
    def here(self) -> Expr:
        """Return what stands for omega in closed forms: a symbol, or a value."""
        return self.frequency if self.value is None else self.value

    @property
    def environment(self) -> Expr:
        """Return H_env(s)."""
        return self.env.factored()

    @property
    def perceived(self) -> Expr:
        """Return H_perc(s)."""
        return self.perc.factored()

    @property
    def distortion(self) -> Expr:
        """Return dH(s) = H_perc - H_env."""
        return self.difference.factored()

    @property
    def real(self) -> Expr:
        """Return Re dH(j omega), N/m or N m/rad: the shortest form known, a reduced fraction or in
        magnitudes and angles of the chain."""
        return self._told(self.form(Part.REAL)[0])

    @property
    def imag(self) -> Expr:
        """Return Im dH(j omega), N/m or N m/rad."""
        return self._told(self.form(Part.IMAG)[0])

    @property
    def ratio_real(self) -> Expr:
        """Return r_r = ``|Re dH|/|H_env|``."""
        return self._told(self._ratio(Part.REAL))

    @property
    def ratio_imag(self) -> Expr:
        """Return r_i = ``|Im dH|/|H_env|``."""
        return self._told(self._ratio(Part.IMAG))

    @property
    def relative_real(self) -> Expr:
        """Return Re(dH/H_env), which is not r_r."""
        return self._told(self.relative_form(Part.REAL)[0])

    @property
    def relative_imag(self) -> Expr:
        """Return Im(dH/H_env), which is not r_i."""
        return self._told(self.relative_form(Part.IMAG)[0])

    def form(self, part: Part) -> tuple[Expr, bool]:
        """Return Re or Im dH in ``kernel.rings.omega``, as short as is known; and whether all
        common factors are cancelled."""
        if self.with_one_delay is not self:
            return self.with_one_delay.form(part)

        def others() -> Expr:
            return part_of_distortion(self.chain, part, part_of(self.env_response, part).factored())

        def lowest() -> Expr:
            return _shorter(self.difference, part)

        return shortest(self.difference, lowest, others, in_series=self.chain.in_series)

    def _ratio(self, part: Part) -> Expr:
        """Return |Re dH|/|H_env| or |Im dH|/|H_env| in ``kernel.rings.omega``."""
        if self.over_real_factor is not self:
            return self.over_real_factor._ratio(part)
        form, is_lowest = self.form(part)
        # SymPy's Abs looks at every factor, which takes long for a form that is not in lowest
        # terms.
        size = magnitude(form, self.difference) if is_lowest else Abs(form, evaluate=False)
        return size / sqrt(self.squared_modulus.factored())

    @cached_property
    def over_real_factor(self) -> Distortion:
        """Return the distortion with all dynamics divided by what dH and H_env share that is real
        on s = j omega, as k + m s^2, which leaves the ratios as they are; the same object where
        there is none."""
        ring = ring_of(self.env)
        if self.difference.is_zero:
            return self
        shared = real_factor(ring, self.env.numerator).gcd(self.difference.numerator)
        if not int(shared.degrees()[0]):
            return self
        Z = ring.function(shared)
        env, perc = ((f / Z).reduced() for f in (self.env, self.perc))
        return replace(self, env=env, perc=perc, chain=self.chain.over(Z))

    def relative_form(self, part: Part) -> tuple[Expr, bool]:
        """Return Re or Im of dH/H_env in ``kernel.rings.omega``, as short as is known; and whether
        all common factors are cancelled."""
        if self.with_one_delay is not self:
            return self.with_one_delay.relative_form(part)
        change = (self.difference / self.env).reduced()

        def lowest() -> Expr:
            return _shorter(change, part)

        return shortest(
            change,
            lowest,
            lambda: part_of_relative(self.chain, part),
            in_series=self.chain.in_series,
        )

    def steps(self, *of: str) -> Steps:
        """Return some closed forms in short named steps, ``definitions`` and ``results``: Re dH and
        Im dH if none is named.

        ``of`` : "real", "imag", "ratio_real", "ratio_imag", "relative_real", "relative_imag". They
        grow by some twenty operations with each effect, and are what code should compute.
        SceneError for another name.

        >>> from haptisym import effects, environments
        >>> from haptisym.kernel.rings import symbols
        >>> found = distort(environments.mass_spring_damper(k=symbols("k")), effects.first_order_lag(symbols("w"))).steps("real")
        >>> found.definitions, found.results
        (((M, omega**2 + w**2), (E, -k*omega**2)), {'real': E/M})
        """
        names = of or ("real", "imag")
        known = [x for x in self.chain.steps.results if not x.startswith("perceived")]
        for name in (x for x in names if x not in known):
            raise SceneError(
                f"steps: unknown quantity {quoted(name)}: {meant(str(name), known)}valid are "
                f"{', '.join(known)}"
            )
        steps = self.chain.steps.only(names)
        if self.here == omega:
            return steps
        # A step may have the very name that the user gave the frequency: it is renamed.
        taken = {x for x, _ in steps.definitions if x.name == self.frequency.name}
        put = {omega: self.here, **{x: Symbol(f"{x.name}x") for x in taken}}
        pairs = tuple((put.get(name, name), x.xreplace(put)) for name, x in steps.definitions)
        return replace(
            steps,
            definitions=pairs,
            results={name: x.xreplace(put) for name, x in steps.results.items()},
        )

    @property
    def modulus(self) -> Expr:
        """Return ``|H_env(j omega)|``."""
        return self._told(sqrt(self.squared_modulus.factored()))

    @cached_property
    def environment_properties(self) -> Properties:
        """Return stiffness, mass, damping and force phasors of the environment."""
        return properties(self.env_response, self.here, unused(X, self.chain.parameters))

    @cached_property
    def perceived_properties(self) -> Properties:
        """Return stiffness, mass, damping and force phasors of what is felt."""
        return properties(self.perc_response, self.here, unused(X, self.chain.parameters))

    def compile(
        self,
        accuracy: Accuracy | str = Accuracy.FAST,
        of: Sequence[str] | None = None,
        engine: Backend | str = Backend.NUMPY,
    ) -> Compiled:
        """Return a NumPy function ``f(omega, m=..., ...)`` of frequencies (rad/s) and the
        parameters that are still symbols (SI).

        It returns a named tuple of arrays (``real``, ``imag``, ``ratio_real``, ``ratio_imag``, ...)
        of the broadcast shape of its arguments, constants included. At a zero of H_env the ratios
        are their limits.

        accuracy : what is promised of each float, an ``Accuracy`` or its name ("fast",
        "double-double", "certified").
        of : the fields wanted, all by default; the named tuple has just these.
        engine : what runs the level fast, a ``Backend`` or its name: "numpy", or "numba" (the extra
        ``fast``).
        ``f.digits(omega, count, ...)`` gives decimal digits instead. Raises SceneError for a choice
        that there is not.

        >>> from haptisym.environments import kelvin_voigt
        >>> from haptisym.effects import first_order_lag
        >>> f = distort(kelvin_voigt(100, 2), first_order_lag(20)).compile(of=["real"])
        >>> f([0.0, 20.0]).real.tolist()
        [0.0, -30.0]
        """
        from haptisym.programs.values import chosen, compiled

        names = chosen(of)
        program = self.needed_chain.program(names)
        return compiled(program, lambda values: self.at(values).functions(names), accuracy, engine)

    @cached_property
    def needed_chain(self) -> Chain:
        """Return the chain with numbers for parameters that cancel: those of effects that undo each
        other may be any number."""
        # H_perc does not depend on these parameters, so that any values will do.
        others = sorted(set(self.chain.parameters) - self.free_symbols, key=str)
        return self.chain.replaced({x: Rational(n + 7, 5) for n, x in enumerate(others)})

    def at(self, values: Mapping[Symbol | str, Number]) -> Distortion:
        """Return the distortion with values for some parameters, by symbol or name; the others stay
        symbols.

        A value is a number, read exactly (a float as its decimal), a string with or without a unit,
        or an expression in parameters. A value for omega is put into all closed forms. SceneError
        for a name that is none of the parameters, for a value with a sign that its symbol is
        declared not to have, and for a unit that is none of what the parameter of a model measures;
        in an expression a symbol may have any unit, and is its number in SI.

        >>> from haptisym import effects, environments, symbols
        >>> d = distort(environments.mass_spring_damper(k=symbols("k")), effects.first_order_lag(symbols("w")))
        >>> d.at({"k": 0.1}).real, d.at({"k": 100, "w": "20 rad/s"}).bandwidth(0.1).digits(5)
        (-omega**2/(10*omega**2 + 10*w**2), '2.0204')
        >>> d.at({"omega": 8, "w": 6}).ratio_real
        16/25
        """
        known = values_of(values, self._measures(), self.frequency)
        here = known.pop(omega, self.value)
        # Without values of parameters the object itself, with all that it has computed so far.
        found = Distortion.of(self.chain.replaced(known)) if known else self
        # A symbol that is put in for another measures what that one does.
        renamed = ((known.get(x, x), kind) for x, kind in self.dimensions.items())
        measured = dimensions((*self.dimensions.items(), *renamed))
        return replace(found, frequency=self.frequency, value=here, dimensions=measured)

    def _measures(self) -> dict[Symbol, Dimension]:
        """Return what each parameter measures."""
        return {x: self.dimensions.get(x, Dimension.ANY) for x in self.chain.parameters}

    def subs(self, *given: Any) -> Distortion:
        """Return the same as ``at``, written as in SymPy: ``subs(k, 100)``, ``subs({k: 100})`` or
        ``subs([(k, 100), (T, 0.02)])``; all at once.

        >>> from sympy.abc import k, s, T
        >>> distort(k, 1 / (1 + T * s)).subs(T, "20 ms").perceived
        50*k/(s + 50)
        """
        try:
            values = dict([given]) if len(given) == 2 else dict(*given)
        except (TypeError, ValueError):
            raise SceneError("subs: give a symbol and its value, or a mapping of them") from None
        return self.at(values)

    def functions(self, names: Sequence[str]) -> dict[str, RealFunction]:
        """Return the real functions behind the fields of ``programs.values.Values``, reduced; of
        the ratios their squares."""
        responses = {
            "relative": "relative_response",
            "environment": "env_response",
            "perceived": "perc_response",
        }
        functions = {}
        for name in names:
            kind, _, part = name.rpartition("_")
            if kind == "ratio":
                functions[name] = self.squared_ratios[Part(part)]
            else:
                functions[name] = part_of(
                    getattr(self, responses.get(kind, "difference_response")), Part(part)
                )
        return functions

    def parameter_jnd(self, c: Expr) -> ParameterJND:
        """Return the JNDs of stiffness, damping and mass for a threshold c."""
        return ParameterJND.of(self.modulus, c, self.here)

    def crossings(
        self, part: Part | str, c: Any = None, *, band: tuple[Any, Any] | None = None
    ) -> tuple[Solution, ...] | tuple[RealNumber, ...]:
        """Return all frequencies at which a ratio equals a threshold c: the positive zeros of r^2 -
        c^2.

        ``part`` : "real" or "imag". ``c`` : a symbol, or a fraction > 0; a symbol c (c_ where that
        is a parameter) unless given. With symbols each is a ``Solution``: a closed form ``omega``
        with the ``conditions`` under which it is in force, or None and the ``equation`` where none
        is readable; a delay's come again with ``period``. With numbers alone, and where all symbols
        cancel from such an equation, they are certified frequencies (``float(x)``,
        ``x.digits(50)``), on a ``band`` if one is given, as a display with a delay needs.

        >>> from haptisym import effects, environments
        >>> from haptisym.kernel.rings import symbols
        >>> lag = effects.first_order_lag(symbols("w"))
        >>> [x.omega for x in distort(environments.mass_spring_damper(k=symbols("k")), lag).crossings("real")]
        [sqrt(c)*w/sqrt(1 - c)]
        >>> own = distort(environments.mass_spring_damper(k=100), effects.first_order_lag(20))
        >>> [x.digits(8) for x in own.crossings("real", 0.2)]
        ['10.000000']
        """
        # Formulas can invert an angle in one delay only, and numbers need the delays as they are.
        level = self._threshold(c)
        squared = self.with_one_delay.squared_ratios[part_named(part)]
        free = level.free_symbols | free_parameters(squared)
        if band is not None and free:
            named = ", ".join(sorted(map(str, free)))
            raise SceneError(
                f"band: formulas hold on every band: leave it out, or give values for "
                f"{named} with at()"
            )
        if band is None and level.free_symbols | self.free_symbols:
            found = crossings(squared, level, self.chain.threshold_symbol)
            # Where all symbols cancel an equation without a formula has proven numbers for it.
            turning = any(not x.constant for x in squared.axis.angles)
            if free or turning or all(x.omega is not None for x in found):
                return self._in_own_frequency(found)
        return zeros(excess(self.squared_ratios[part_named(part)], level), band)

    def _threshold(self, c: Any) -> Expr:
        """Read a threshold, a symbol unless given; raise SceneError where a symbol in it is a
        frequency, a parameter or s."""
        if c is None:
            return unused(symbol_c, [*self.chain.parameters, self.frequency])
        taken = {x.name: "a parameter" for x in self.free_symbols}
        frequencies = {x.name: "the frequency" for x in (omega, self.frequency)}
        return threshold(c, {**taken, **frequencies, s.name: "the Laplace variable"})

    @cached_property
    def with_one_delay(self) -> Distortion:
        """Return the distortion with one delay in place of several that only act together, as in
        exp(-s tau_1) exp(-s tau_2); the same object where they act apart."""
        ring = ring_of(self.env)
        first, last = ring.size, ring.size + len(ring.lags)
        parts = [p for f in (self.env, self.perc) for p in (f.numerator, f.denominator)]
        # Each monomial has a vector of exponents of the delays. They act together where all vectors
        # are multiples of the least one, which then is the unit delay.
        delays = {tuple(map(int, exponents[first:last])) for p in parts for exponents in p.monoms()}
        delays.discard((0,) * len(ring.lags))
        unit = min(delays, default=())
        multiples = {tuple(n * x for x in unit): n for n in range(sum(max(delays, default=())) + 1)}
        # A unit with a single exponent 1 is one delay already.
        if sum(unit) < 2 or not delays <= multiples.keys():
            return self
        other = Ring(
            ring.symbols,
            [Add(*(n * lag for n, lag in zip(unit, ring.lags, strict=True)))],
            ring.orders,
            j=I in ring.generators,
        )

        def same(p: Polynomial) -> Polynomial:
            """Return the polynomial in the ring with the unit delay in place of the others."""
            terms = ((tuple(map(int, e)), x) for e, x in monomials(p))
            return other.context.from_dict(
                {(*e[:first], multiples[e[first:last]], *e[last:]): x for e, x in terms}
            )

        env, perc = (
            other.function(same(f.numerator), same(f.denominator)) for f in (self.env, self.perc)
        )
        return replace(self, env=env, perc=perc)

    def _in_own_frequency(self, solutions: Iterable[Solution]) -> tuple[Solution, ...]:
        """Return the solutions with their equations in the symbol that was given for the
        frequency, and with the parameters that they may be asked with."""
        own, known = {omega: self.frequency}, self._measures()
        return tuple(replace(x, equation=x.equation.xreplace(own), known=known) for x in solutions)

    @property
    def changeovers(self) -> Changeovers:
        """Return all frequencies at which Re H_env and Re H_perc change their sign: formulas, or
        proven numbers, as ``crossings`` does."""
        if not self.free_symbols:
            return Changeovers(
                *(sign_changes(x.real) for x in (self.env_response, self.perc_response))
            )
        return Changeovers(
            *(self._in_own_frequency(self._sign_changes(x)) for x in ("env", "perc"))
        )

    def _sign_changes(self, system: str) -> tuple[Solution, ...]:
        """Return formulas of all zeros and poles of odd order of Re H; ``system`` : "env" or
        "perc"."""
        reduced = self.with_one_delay
        H = getattr(reduced, system)
        real = on_axis(H).real
        if real.is_zero:
            return ()
        # A denominator is a squared modulus, which changes its sign only where the numerator takes
        # part of it away.
        poles = () if _is_definite(H) else solve(RealFunction(real.axis.one / real.function))
        # At a zero or pole of even order the sign stays.
        return tuple(x for x in (*solve(real), *poles) if x.order % 2)

    def changeover(self, system: str, values: Mapping[Symbol, Expr] | None = None) -> Expr | None:
        """Return the lowest frequency at which Re H of "env" or "perc" changes its sign, as a
        formula; None where it is not known.

        ``values`` : of all parameters; the formula is then the one that is in force for them.
        """
        # With s^alpha the sign of a root depends on the order, which may be a symbol.
        if ring_of(self.env).orders:
            return None
        return lowest_formula(self._sign_changes(system), values)

    def threshold_polynomial(self, part: Part | str, c: Any = None) -> Poly | Expr:
        """Return the polynomial in W = omega^2 that vanishes where a ratio equals a threshold; with
        delays an expression in omega.

        >>> from haptisym import effects, environments
        >>> distort(environments.mass_spring_damper(k=1), effects.first_order_lag(1)).threshold_polynomial("imag").all_coeffs()
        [-c**2, 1 - 2*c**2, -c**2]
        """
        squared = self.with_one_delay.squared_ratios[part_named(part)]
        polynomial = threshold_polynomial(squared, self._threshold(c), self.chain.threshold_symbol)
        own = {omega: self.frequency}
        return polynomial if isinstance(polynomial, Poly) else polynomial.xreplace(own)

    def bandwidth(self, c: Any, *, band: tuple[Any, Any] | None = None) -> RealNumber | Expr:
        """Return the end of the interval from 0 (or the band's low end) on which neither ratio
        exceeds c; 0 for none, oo for all.

        Certified. SceneError where the ratios depend on symbols, and without a band behind a delay
        where no ratio exceeds c within some eighty turns of it.
        """
        return bandwidth(self.squared_ratios, self._threshold(c), band)

    def asymptote(self, at: Any = 0) -> Asymptote:
        """Return the leading terms of dH, Re dH and Im dH ``at`` 0 or oo.

        >>> from haptisym import effects, environments
        >>> from haptisym.kernel.rings import symbols
        >>> distort(environments.mass_spring_damper(k=symbols("k")), effects.delay(symbols("tau"))).asymptote().imag
        -k*omega*tau
        """
        return Asymptote(*map(self._told, asymptote(self.difference, at)))

    @property
    def low_frequency(self) -> LowFrequency:
        """Return stiffness, damping and mass that a slow hand feels: H_perc(s) = stiffness +
        damping s + mass s^2 + ..., exactly.

        SceneError where H_perc is infinite at s = 0, or not rational in s but for delays.

        >>> from haptisym import effects, environments
        >>> from haptisym.kernel.rings import symbols
        >>> k, b, tau = symbols("k b tau")
        >>> distort(environments.mass_spring_damper(k=k), effects.wave_variables(b, tau)).low_frequency.stiffness
        b*k/(b + k*tau)
        """
        return low_frequency(self.perc)

    def lambdify(
        self, quantity: str = "ratio_real", modules: Any = "numpy", *, steps: bool = False
    ) -> Callable[..., Any]:
        """Return a plain function of omega and the parameters by name, as ``sympy.lambdify`` does:
        for NumPy, mpmath, JAX or math.

        ``quantity`` : any closed form here, by name. A parameter that no argument can be called is
        spelt as in generated code: ``lambda_``, ``sqrt_``, and ``mu`` for ``\\mu``. With ``steps``
        it computes the quantity by ``steps(quantity)``, and returns each step and the result by
        their names. NumPy computes in floats, whole numbers and lists too, and a constant for each
        frequency. ``compile`` is more accurate, and knows the limits at zeros of H_env.

        >>> from haptisym import effects, environments
        >>> d = distort(environments.mass_spring_damper(k=100), effects.first_order_lag(20))
        >>> d.lambdify("real", "math")(20.0), d.lambdify("real", "math", steps=True)(20.0)
        (-50.0, {'M': 800.0, 'E': -40000.0, 'real': -50.0})
        """
        if quantity not in _QUANTITIES:
            hint = meant(str(quantity), _QUANTITIES)
            raise SceneError(
                f"unknown quantity {quoted(quantity)}: {hint}valid are {', '.join(_QUANTITIES)}"
            )
        named = self.steps(quantity).named if steps else {quantity: getattr(self, quantity)}
        names = sorted(self.free_symbols, key=str)
        # H_env(s), H_perc(s) and dH(s) are functions of s, all others of omega.
        variable = s if any(x.has(s) for x in named.values()) else self.frequency
        # A form that is left as Re or Im of H_perc(j omega) has complex numbers inside, for which
        # math has no functions.
        if modules == "math" and any(x.has(re, im) for x in named.values()):
            modules = [
                {
                    "re": lambda z: complex(z).real,
                    "im": lambda z: complex(z).imag,
                    "exp": cmath.exp,
                },
                "math",
            ]
        called = keywords(x.name for x in names)
        spelt = {x: Symbol(called[x.name]) for x in names if called[x.name] != x.name}
        forms = {name: computable(x).xreplace(spelt) for name, x in named.items()}
        *before, result = forms.items()
        # The named steps stand in for the common subexpressions that SymPy would look for.
        pairs = [(Symbol(name, real=True), x) for name, x in before]
        results = [*(name for name, _ in pairs), result[1]]
        try:
            function: Callable[..., Any] = lambdify(
                [variable, *(spelt.get(x, x) for x in names)],
                results if steps else result[1],
                [{"staircase": staircase}, *(modules if isinstance(modules, list) else [modules])],
                cse=(lambda _: (pairs, results)) if steps else True,
            )
        except (NameError, ImportError):
            raise SceneError(
                f"modules: {quoted(modules)}: give a package that is installed, as numpy, mpmath "
                f"or math"
            ) from None
        if modules in ("numpy", "scipy", ["numpy"], ["scipy"]):
            function = in_floats(function)
        if not steps:
            return function
        return lambda *x, **y: dict(zip(forms, function(*x, **y), strict=True))

    @property
    def changeover_environment(self) -> Expr | None:
        """Return the lowest frequency at which Re H_env changes sign, in square roots; None where
        it has no such form.

        With symbols it is given where one formula is the lowest for all values of them, and holds
        while it is real (``changeovers`` has all, with conditions).

        >>> from haptisym.environments import mass_spring_damper
        >>> from haptisym.kernel.rings import symbols
        >>> distort(mass_spring_damper(*symbols("m b k"))).changeover_environment
        sqrt(k)/sqrt(m)
        """
        return self.changeover("env")

    @property
    def changeover_perceived(self) -> Expr | None:
        """Return the lowest frequency at which Re H_perc changes sign, in square roots; None where
        it has no such form."""
        return self.changeover("perc")


@overload
def solve_for(
    d: Distortion, what: Literal["crossing"], parameter: Symbol | str, c: Any = None
) -> CrossingSolutions: ...
@overload
def solve_for(
    d: Distortion, what: Literal["changeover"], parameter: Symbol | str, c: Any = None
) -> Changeovers: ...
def solve_for(
    d: Distortion, what: str, parameter: Symbol | str, c: Any = None
) -> CrossingSolutions | Changeovers:
    """Return the values of a parameter at which omega is a frequency of a distortion: the
    designer's way round.

    ``what`` : "crossing", where r_r or r_i equals the threshold ``c`` (a symbol unless given), or
    "changeover", where Re H_env or Re H_perc changes its sign. ``parameter`` : by symbol or name.
    Each is a ``Solution`` whose ``omega`` is the formula of its ``parameter``, in the frequency and
    all other symbols, positive, or None where none is readable. ``d.at({"omega": 5})`` asks about 5
    rad/s. SceneError for another name.

    >>> from haptisym import effects, environments, symbols
    >>> k, w = symbols("k w")
    >>> d = distort(environments.mass_spring_damper(k=k), effects.first_order_lag(w))
    >>> solve_for(d, "crossing", w).real
    (<Solution w = omega*sqrt(1 - c)/sqrt(c)>,)
    >>> [x.omega for x in solve_for(d.at({"omega": 5}), "crossing", "w", 0.1).real]
    [15]
    """
    if what not in ("crossing", "changeover"):
        raise SceneError(f"what: {quoted(what)}: give crossing or changeover")
    level, by_name = d._threshold(c), {x.name: x for x in d.chain.parameters}
    # A threshold that is a symbol is one of those that can be solved for.
    if level.is_Symbol and what == "crossing":
        by_name[level.name] = d.chain.threshold_symbol
    if str(parameter) not in by_name:
        hint = meant(str(parameter), by_name)
        raise SceneError(
            f"unknown parameter {quoted(parameter)}: {hint}valid are {', '.join(by_name)}"
        )
    free = by_name[str(parameter)]

    def by(f: RealFunction) -> tuple[Solution, ...]:
        known = d._measures()
        found = (replace(x, known=known).replaced({omega: d.here}) for x in solved_for(f, free))
        return tuple(x for x in found if x is not None)

    reduced = d.with_one_delay
    if what == "crossing":
        squares = (reduced.squared_ratios[part] for part in Part)
        return CrossingSolutions(
            *(crossings(f, level, d.chain.threshold_symbol, by) for f in squares)
        )
    stiffness = (reduced.env_response.real, reduced.perc_response.real)
    return Changeovers(*(tuple(x for x in by(f) if x.order % 2) for f in stiffness))


def part_named(given: Any) -> Part:
    """Return the part that is given itself or by its name, "real" or "imag"; SceneError for anything
    else."""
    if given in [x.value for x in Part]:
        return Part(given)
    if not isinstance(given, Part):
        raise SceneError(f"part: {quoted(given)}: give real or imag")
    return given


_QUANTITIES = (
    "real",
    "imag",
    "ratio_real",
    "ratio_imag",
    "relative_real",
    "relative_imag",
    "modulus",
    "environment",
    "perceived",
    "distortion",
)


def values_of(
    values: Any, measured: Mapping[Symbol, Dimension | None], frequency: Symbol | None = None
) -> dict[Symbol, Expr]:
    """Return values for symbols as ``Distortion.at`` takes them.

    ``measured`` : the symbols, and what each of them measures. ``frequency`` : the one of omega, if
    that may have a value.
    """
    need("values", values, Mapping, 'give names and values, as {"k": 100}')
    by_name = {x.name: x for x in measured}
    valid = [*by_name, *((frequency.name,) if frequency else ())]
    if frequency:
        by_name = {omega.name: omega, frequency.name: omega, **by_name}
    known = {}
    for key, given in values.items():
        x = by_name.get(name := str(key))
        if x is None:
            hint = meant(name, valid)
            raise SceneError(
                f"unknown parameter {quoted(name)}: {hint}valid are {', '.join(valid)}"
            )
        with within(name):
            if isinstance(given, Expr) and given in (oo, -oo):
                way = f"limit(expand_trig(d.real), {name}, {given})"
                raise SceneError(f"{quoted(given)} is not finite: take a limit, as {way}")
            measures = {**measured, omega: Dimension.FREQUENCY}[x] or Dimension.ANY
            is_text = isinstance(given, str)
            value = quantity(given, measures).value if is_text else constant(given)
            known[x] = _allowed(x, value)
    return known


def _allowed(x: Symbol, value: Expr) -> Expr:
    """Return a value for a symbol; raise SceneError where it has a sign that the symbol is declared
    not to have."""
    if (x.is_nonnegative and value.is_negative) or (x.is_nonpositive and value.is_positive):
        raise SceneError(
            f"{quoted(value)} must be {'>=' if x.is_nonnegative else '<='} 0: the symbol is "
            f"declared so"
        )
    return value


def part_of(response: Response, part: Part) -> RealFunction:
    """Return the real or the imaginary part of a response."""
    return response.real if part is Part.REAL else response.imag


def _shorter(dynamics: RationalFunction, part: Part) -> Expr:
    """Return Re or Im of a dynamics with common factors cancelled: in factors, over sums of two
    squares, or in products of its parts, where that is shorter."""
    real = part is Part.REAL
    factored = part_of(on_axis(dynamics), part).factored()
    reduced = min(factored, over_squares(dynamics, real=real), key=count_ops)
    products = over_squares(dynamics, real=real, multiplied=False)
    return reduced if prefers_lowest(reduced, products) else products


def magnitude(form: Expr, dynamics: RationalFunction, *, evaluate: bool = True) -> Expr:
    """Return the magnitude of a form of Re or Im of a dynamics, with bars below the line only where
    the sign changes there.

    ``evaluate`` : whether SymPy may look at what stands above, which takes long for a long form.

    >>> ring = Ring()
    >>> lossless, lossy = (ring.convert(1 / (s**2 + b * s + 4)) for b in (0, 1))
    >>> magnitude(1 / (4 - omega**2), lossless), magnitude(1 / (omega**2 + (4 - omega**2)**2), lossy)
    (1/Abs(omega**2 - 4), 1/(omega**2 + (4 - omega**2)**2))
    """
    above, below = form.as_numer_denom()
    if not _is_definite(dynamics):
        return Abs(above, evaluate=evaluate) / Abs(below)
    # Below is definite: its sign at one point, no symbol of which is 0, is its sign everywhere.
    known = {x: Rational(n + 7, 5) for n, x in enumerate(sorted(below.free_symbols, key=str))}
    return Abs(above, evaluate=evaluate) / (
        below if below.xreplace(known).evalf(30) >= 0 else -below
    )


def _is_definite(dynamics: RationalFunction) -> bool:
    """Return whether no factor of |denominator|^2 on s = j omega, as it stands below Re or Im in
    lowest terms, can change its sign; False where one might.

    The square itself is nowhere negative; so a factor of odd multiplicity in it keeps its sign. Of
    an even one, part may have been cancelled.
    """
    axis = on_axis(dynamics).raw_real.ring
    assert isinstance(axis, Axis)
    # |D|^2 = c^2 + d^2 with D = c + j d on the axis. Delays are written in tangents of half angles;
    # the factors 1 + tan^2 that this brings are positive and do not count.
    c, d = axis.parts([dynamics.denominator])[0]
    _, factors = axis.factors(axis.without_circles(c * c + d * d)[0])
    return all(n % 2 or factor == axis.variable for factor, n in factors)
