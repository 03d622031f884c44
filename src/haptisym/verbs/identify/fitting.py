"""Least-squares fit of a haptic display's model to a measured frequency response.

Question: for which values x of its free parameters is a model's perceived dynamics H(j omega; x),
force over motion, nearest a measured response? Begin reading at ``fit``.

**Model** (``wanted``). An environment and effects of the catalogue (the elements of a scene, as a
scene file lists them), or a fraction (a0 + a1 s + ...)/(1 + d1 s + ...) of given degrees, in which
some parameters are free.

**Cost.** With measured H_i at omega_i and sigma_i the standard deviation of Re H_i and of Im H_i,
``fit`` minimises

    S(x) = 1/2 sum |(H_i - H(j omega_i; x))/sigma_i|^2,

the maximum likelihood for independent circular Gaussian errors. sigma_i comes from the uncertainty
disc of each frequency point, which holds the true response with a stated confidence
(``noise_of``). The covariance is that of the linearised model, (J^T J)^-1, where J has the real and
imaginary parts of the slopes dH/dx over sigma (Seber and Wild, Nonlinear Regression, 1989).

**Starts** (``starts``). S has several local minima. The search begins at the best of many sets of
values, drawn on logarithmic scales around what the size of |H| and the frequencies suggest; for a
fraction at linear least squares, weighted with the denominator of the round before (Sanathanan and
Koerner, IEEE Trans. Autom. Control 8, 1963, 56-58). The result is the least minimum that was found:
floats, without a proof that there is no lower one.

**Other values with the same response** (``twins``). Whether they exist is a question of algebra,
which no number of frequency points answers. Two fractions are equal where numerator and denominator
are, up to one common factor. With the fitted values (to three digits) on one side that is a system
of polynomial equations in the parameters, solved by a lexicographic Groebner basis and back
substitution (Cox, Little and O'Shea, Ideals, Varieties, and Algorithms, chapter 3).

Short names: ``m`` is a measurement; ``response`` a model's H at the measured frequencies as a
function of the values; arrays of responses are (sets of values, frequency points), of slopes
(frequency points, parameters).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from math import lcm
from operator import mul
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from flint import fmpz_mpoly_ctx, fmpz_mpoly_vec, fmpz_poly
from sympy import Symbol

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError, Setting, meant, within
from haptisym.kernel.objects import counted
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment, Model
from haptisym.model.distortion import distort
from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.parameters import NAMED, Rule, Slot, free_name
from haptisym.model.quantities import Dimension

Table: TypeAlias = Mapping[str, Any]
"""A table of a scene file: ``model`` and the parameters by their keys."""
Degrees: TypeAlias = tuple[int, int]
"""The degrees of a numerator and of a denominator."""

HIGHEST = 12
"""The highest degree of a numerator or denominator."""
MOST = 16
"""The largest number of free parameters."""
LEAST_AVERAGES = 4
"""The fewest averages whose coherence gives weights: of n = 2 averages - 2 degrees of freedom the
factor n/(n - 4) of the variances is finite only above n = 4."""

# Starts.
_MOST_START_POINTS = 200
"""Frequency points that the choice of starts uses: more only cost time."""
_DRAWN_PER_PARAMETER = 64
"""Sets of values that are drawn for each parameter, and for one more."""
_MOST_REFINED = 10
"""How many of the best drawn sets are refined."""
_DRAWN_DECADES = {
    Dimension.MASS: (-2.5, 1.0),
    Dimension.DAMPING: (-2.5, 1.0),
    Dimension.STIFFNESS: (-1.5, 1.5),
    Dimension.FREQUENCY: (-0.5, 2.5),
    Dimension.TIME: (-3.0, 0.3),
    Dimension.RATIO: (-1.0, 0.3),
}
"""Powers of ten between which a parameter is drawn, relative to its scale."""
_OTHER_DECADES = (-2.0, 2.0)
"""The same for other dimensions."""
_ROUNDS = 20
"""Rounds of weighted linear least squares for a fraction: the weights settle in a few."""
_TINY = 1e-300
"""The least number by which a weight divides: a response of 0 has a finite weight."""

# Least squares.
_STEP = 1e-5
"""Steps of central differences, relative to the values: errors of truncation, some _STEP^2, and of
rounding, some 1e-16/_STEP, are both about 1e-10."""
_LEAST_SINGULAR = 1e-7
"""Ratio of the smallest to the largest singular value of the scaled slopes: below it the data do
not identify the parameters separately. Central differences have an error of some 1e-10."""
_EQUAL_SHARE = 1e-6
"""Costs that differ by no more than this share count as equal."""
_EQUAL_COST = 1e-12
"""Costs up to this count as equal to 0, as of data without noise."""

# Other values with the same response.
_BASIS_LIMITS = 60, 400, 20_000
"""Where the search for a Groebner basis gives up: polynomials, terms of one, bits of a
coefficient."""
_SAME_ROOT = 1e-4
"""Relative: values and roots that differ by less are one. Solutions are roots of polynomials whose
coefficients were computed from earlier roots, in floats."""
_MAYBE_ROOT = 1e-2
"""Relative: what is a root up to this may be one, as roundings split a double root by their square
root, times the condition of the coefficients."""


# The model to be fitted.


@dataclass(frozen=True)
class Free:
    """A free parameter. ``path`` : its path in the scene file that will be written, as
    ``effects.delay.tau``; ``symbol`` : what stands for it until it has a value."""

    path: str
    symbol: Symbol
    dimension: Dimension
    rule: Rule

    @property
    def name(self) -> str:
        """The last word of its path."""
        return self.path.rpartition(".")[2]


@dataclass(frozen=True)
class Wanted:
    """The model to be fitted, as tables of a scene file in which a parameter may be ``Free``.

    ``environment``, ``effects`` : the tables, a model each. ``degrees`` : of numerator and
    denominator where a fraction is fitted, else None. ``known`` : the environment to be felt where
    that is given and nothing in it is free, else None.
    """

    environment: Table
    effects: tuple[Table, ...]
    degrees: Degrees | None = None
    known: Environment | None = None

    @property
    def free(self) -> tuple[Free, ...]:
        """The parameters to be fitted, the environment's first: values are in this order."""
        return tuple(_free((self.environment, *self.effects)))

    @property
    def words(self) -> str:
        """The names of the models, as ``mass-spring-damper, delay``."""
        return ", ".join(str(x.get("name", x["model"])) for x in (self.environment, *self.effects))

    def elements(self, value: Callable[[Free], Any]) -> tuple[Environment, tuple[Effect, ...]]:
        """Environment and effects, with ``value`` of each free parameter in its place."""
        environment = self.known or _built(ENVIRONMENTS, filled(self.environment, value))
        return environment, tuple(_built(EFFECTS, filled(x, value)) for x in self.effects)


def filled(given: Any, value: Callable[[Free], Any]) -> Any:
    """Return a table, or an entry of one, with ``value`` of each free parameter in its place."""
    if isinstance(given, Free):
        return value(given)
    if isinstance(given, Mapping):
        return {key: filled(x, value) for key, x in given.items()}
    return [filled(x, value) for x in given] if isinstance(given, list) else given


def _free(given: Any) -> Iterator[Free]:
    """Yield what is free in nested tables, in their order."""
    if isinstance(given, Free):
        yield given
    elif isinstance(given, Mapping):
        for x in given.values():
            yield from _free(x)
    elif isinstance(given, list | tuple):
        for x in given:
            yield from _free(x)


def _built(catalogue: Mapping[str, Model], table: Table) -> Any:
    """Return the environment or effect of a table: ``model`` names it in the catalogue, the other
    keys are its parameters."""
    arguments = dict(table)
    return catalogue[str(arguments.pop("model"))].build(**arguments)


def wanted(
    environment: str | None,
    effects: Sequence[str],
    degrees: Degrees | None,
    known: tuple[Environment, Table] | None,
) -> Wanted:
    """Return the model that the words of a call describe. SceneError for unknown models and keys,
    and combinations that cannot be.

    ``environment``, ``effects`` : a model each, as ``"shunt"``, ``"shunt:m,b"`` (with these
    parameters alone of those that may be absent) or ``"second-order-lowpass:zeta=0.5"`` (with a
    given value). ``degrees`` : of a numerator and a denominator, in place of a model of the
    environment; of a series effect where the environment is ``known``. ``known`` : the environment
    of a scene, and its table. None of each: not given.

    >>> [x.path for x in wanted("mass-spring-damper:k,b", ["delay"], None, None).free]
    ['environment.k', 'environment.b', 'effects.delay.tau']
    """
    # Free parameters are numbered symbols, so that two effects of one model never share one.
    numbered = _Symbols()
    environment_table: Table
    if known is not None:
        if environment is not None:
            raise SceneError(
                "environment: the scene gives it: leave it out, or give the file of the "
                "response instead of the scene"
            )
        environment_table = known[1]
    elif degrees is not None:
        if environment is not None:
            raise SceneError(
                f"degrees: a fraction replaces the model: leave out {environment} or the degrees"
            )
        environment_table = _fraction(degrees, "environment", numbered)
    elif environment is None:
        models = [x for x in ENVIRONMENTS if x != "expression"]
        raise SceneError(
            "name a model to fit, as ",
            Setting("environment", models[0]),
            f", or give degrees; models are {', '.join(models)}",
        )
    else:
        environment_table = _model(environment, ENVIRONMENTS, "environment", numbered)
    effect_tables = []
    if degrees and known:
        effect_tables.append(_fraction(degrees, "effects.fraction", numbered))
    taken = {"fraction"}
    for text in effects:
        model = text.partition(":")[0].strip()
        name = free_name(model, taken, "-")
        taken.add(name)
        table = _model(text, EFFECTS, f"effects.{name}", numbered)
        effect_tables.append(table if name == model else {"name": name, **table})
    model_to_fit = Wanted(
        environment_table, tuple(effect_tables), degrees, known[0] if known else None
    )
    _check(model_to_fit)
    return model_to_fit


def _check(model: Wanted) -> None:
    """Raise SceneError where nothing, or too much, is free."""
    if not model.free and model.known and not model.effects:
        raise SceneError(
            "no parameter is free: name the effects to fit, as --effect delay, or --degrees 1 2; "
            f"effects are {', '.join(EFFECTS)}"
        )
    if not model.free:
        raise SceneError("no parameter is free: leave out the value of at least one")
    if len(model.free) > MOST:
        raise SceneError(f"{len(model.free)} parameters are free: at most {MOST} can be fitted")
    # A fraction has all zeros and poles that its degrees allow: those of another rational effect
    # could not be told from its own.
    others = [x for x in model.effects if x["model"] != "series"]
    if model.degrees and any(x["model"] != "delay" for x in others):
        raise SceneError(
            "degrees: a fraction is fitted with a delay only: leave out the other effects"
        )


class _Symbols:
    """Makes free parameters, with symbols free1, free2, ... in the order in which they are asked
    for."""

    def __init__(self) -> None:
        self.count = 0

    def free(self, path: str, slot: Slot) -> Free:
        """Return the next free parameter: positive unless the rule of its slot allows any sign."""
        self.count += 1
        signs = {"real": True} if slot.rule is Rule.ANY else {"positive": True}
        return Free(path, Symbol(f"free{self.count}", **signs), slot.dimension, slot.rule)


def _fraction(degrees: Degrees, place: str, numbered: _Symbols) -> Table:
    """Return the table of a fraction (a0 + a1 s + ...)/(1 + d1 s + ...) with free coefficients, as
    an environment or a series effect.

    The denominator begins with 1: else a common factor of both would be free.
    """
    numerator_degree, denominator_degree = degrees
    are_whole = all(isinstance(x, int) and not isinstance(x, bool) for x in degrees)
    if not are_whole or not all(0 <= x <= HIGHEST for x in degrees):
        raise SceneError(
            f"degrees: {numerator_degree} and {denominator_degree} must be whole numbers from 0 to "
            f"{HIGHEST}"
        )
    numerator_keys, denominator_keys = _coefficient_keys(degrees)
    numerator = " + ".join(map(_monomial, numerator_keys))
    formula = numerator
    if denominator_keys:
        denominator = " + ".join(map(_monomial, denominator_keys))
        formula = f"({numerator})/(1 + {denominator})"
    keys = [*numerator_keys, *denominator_keys]
    parameters = {key: numbered.free(f"{place}.{key}", NAMED) for key in keys}
    if place == "environment":
        return {"model": "expression", "H": formula, "parameters": parameters}
    return {"model": "series", "name": "fraction", "G": formula, "parameters": parameters}


def _coefficient_keys(degrees: Degrees) -> tuple[list[str], list[str]]:
    """Return the names of a fraction's coefficients: a0, a1, ... of the numerator and d1, d2, ...
    of the denominator."""
    numerator_degree, denominator_degree = degrees
    return (
        [f"a{i}" for i in range(numerator_degree + 1)],
        [f"d{i}" for i in range(1, denominator_degree + 1)],
    )


def _monomial(key: str) -> str:
    """Return a coefficient times its power of s: a0, a1*s, a2*s^2."""
    power = int(key[1:])
    return key if power == 0 else f"{key}*s" if power == 1 else f"{key}*s^{power}"


def _model(text: str, catalogue: Mapping[str, Model], place: str, numbered: _Symbols) -> Table:
    """Return the table of a model that a text such as "shunt:m,b=2" names, in which every parameter
    without a value is free.

    With a colon: the parameters that are listed, and the required ones. Without: all that are no
    settings (as an order or a method, which cannot be fitted), and the required settings.
    """
    kind = place.partition(".")[0].rstrip("s")
    name, colon, listed = (x.strip() for x in str(text).partition(":"))
    if name not in catalogue:
        raise SceneError(
            f'{kind}: unknown model "{name[:60]}": {meant(name, catalogue)}valid are '
            f"{', '.join(catalogue)}"
        )
    slots = catalogue[name].slots
    if any(x.formula and x.required for x in slots.values()):
        raise SceneError(
            f"{name}: a formula has no parameters to fit: choose another model, or degrees"
        )
    with within(name):
        given: dict[str, str | None] = {}
        if colon:
            given = _listed(listed, slots)
        else:
            for key, slot in slots.items():
                if not slot.formula and (slot.required or not slot.is_setting):
                    given[key] = None
        entries = {
            key: _entry(f"{place}.{key}", slots[key], value, numbered)
            for key, value in given.items()
        }
    return {"model": name, **entries}


def _listed(listed: str, slots: Mapping[str, Slot]) -> dict[str, str | None]:
    """Return the parameters of a text such as "m,b=2" and those that the model requires; the value
    is None where the text gives none."""
    valid = [key for key, slot in slots.items() if not slot.formula]
    given: dict[str, str | None] = {}
    for word in listed.split(","):
        key, equals, value = (x.strip() for x in word.partition("="))
        if key not in valid:
            raise SceneError(
                f'unknown parameter "{key[:60]}": {meant(key, valid)}valid are {", ".join(valid)}'
            )
        if key in given:
            raise SceneError(f"{key} is there twice")
        given[key] = value if equals else None
    for key in valid:
        if slots[key].required:
            given.setdefault(key, None)
    return given


def _entry(path: str, slot: Slot, given: str | None, numbered: _Symbols) -> Any:
    """Return what a table has for one parameter: the value ``given``, where that is None a free
    parameter, or a list of free parameters for a slot of several entries."""
    key = path.rpartition(".")[2]
    if slot.several:
        count = int(given) if given and re.fullmatch(r"[1-9]\d?", given) else 0
        if not count:
            raise SceneError(f"{key}: give the number of entries, as {key}=2")
        return [numbered.free(f"{path}[{i}]", slot) for i in range(1, count + 1)]
    if slot.is_setting:
        if given is None:
            raise SceneError(f"{key}: cannot be fitted: give it, as {key}={[*slot.choices, 1][0]}")
        return int(given) if given.isdigit() else given
    return numbered.free(path, slot) if given is None else given


# Other values with the same response. FLINT's polynomials have no types: they are Any.


def twins(wanted: Wanted, values: Reals) -> tuple[Reals, ...] | None:
    """Return all other sets of positive values that give nearly the response of ``values``, which
    are rounded to three digits.

    () : there are none. None : not decided, as the basis exceeds its limits, a value is not
    positive, nothing is free outside of delays, or there is a whole family of solutions. What
    stands in a delay or a power of s keeps its value.

    >>> from haptisym.verbs.identify.fitting import wanted
    >>> model = wanted("maxwell", ["first-order-lag"], None, None)
    >>> [x.round(6).tolist() for x in twins(model, np.array([300.0, 6.0, 12.0]))]
    [[72.0, 6.0, 50.0]]
    """
    environment, effects = wanted.elements(lambda x: x.symbol)
    perceived = distort(environment, *effects).perc.reduced()
    ring = perceived.ring
    in_functions = {x for meaning in ring.meanings[ring.size :] for x in meaning.free_symbols}
    # Three digits keep the coefficients of the basis small: with all digits of floats it would not
    # be found within its limits.
    rounded: dict[Symbol, Fraction] = {}
    for parameter, value in zip(wanted.free, values.tolist(), strict=True):
        rounded[parameter.symbol] = Fraction(f"{value:.3g}")
    unknown = [x for x in rounded if x not in in_functions]
    if not unknown or any(rounded[x] <= 0 for x in unknown):
        return None
    # Generators in lexicographic order: t, the common factor, the unknown parameters.
    context = fmpz_mpoly_ctx.get(["t", "factor", *map(str, unknown)], "lex")
    t, factor, *generators = context.gens()
    # t times the factor times all unknowns is 1: none of them is 0, which would add whole families
    # of solutions that are no models.
    equations = [reduce(mul, generators, t * factor) - 1]
    by_symbol = dict(zip(unknown, generators, strict=True))
    # Both parts equal those at the rounded values times one unknown factor: coefficient by
    # coefficient of s and the delays one polynomial equation.
    for part in (perceived.numerator, perceived.denominator):
        for terms in _coefficients(part, ring, list(rounded)):
            polynomial, at_rounded = _equation(context.constant(0), terms, rounded, by_symbol)
            equations.append(polynomial * at_rounded.denominator - factor * at_rounded.numerator)
    basis, is_whole = fmpz_mpoly_vec(equations, context).buchberger_naive(limits=_BASIS_LIMITS)
    if not is_whole:
        return None
    solutions = _positive_solutions([*basis.autoreduction()], len(unknown))
    if solutions is None:
        return None
    itself = np.array([float(rounded[x]) for x in unknown])
    complete = []
    for solution in solutions:
        if np.allclose(solution, itself, rtol=_SAME_ROOT, atol=0):
            continue
        by_symbol_found = dict(zip(unknown, solution, strict=True))
        others = [by_symbol_found.get(x, value) for x, value in zip(rounded, values, strict=True)]
        complete.append(np.array(others))
    return tuple(complete)


_Monomials: TypeAlias = dict[tuple[int, ...], Fraction]
"""A polynomial in the parameters: its coefficients by their exponents."""


def _coefficients(
    polynomial: Polynomial, ring: PolynomialRing, parameters: list[Symbol]
) -> Iterable[_Monomials]:
    """Return the coefficients of all monomials in s, delays and so on, each a polynomial in the
    parameters."""
    columns = [ring.meanings.index(x) for x in parameters]
    coefficients: dict[tuple[int, ...], _Monomials] = {}
    for exponents, value in polynomial.to_dict().items():
        of_parameters = tuple(exponents[i] for i in columns)
        others = list(exponents)
        for i in columns:
            others[i] = 0
        coefficient = coefficients.setdefault(tuple(others), {})
        coefficient[of_parameters] = Fraction(int(value.p), int(value.q))
    return coefficients.values()


def _equation(
    zero: Any,
    terms: _Monomials,
    rounded: Mapping[Symbol, Fraction],
    generators: Mapping[Symbol, Any],
) -> tuple[Any, Fraction]:
    """Return a polynomial in the parameters, cleared of denominators, as one in the unknowns'
    generators (FLINT's), and its value at the rounded values."""
    # A parameter that keeps its value is part of the coefficient in both.
    fixed = dict[tuple[int, ...], Fraction]()
    for powers, c in terms.items():
        for (symbol, number), n in zip(rounded.items(), powers, strict=True):
            if symbol not in generators:
                c *= number ** int(n)
        fixed[powers] = c
    scale = lcm(*(c.denominator for c in fixed.values()))
    total, at_rounded = zero, Fraction(0)
    for powers, c in fixed.items():
        term = zero + int(c * scale)
        value = c * scale
        for (symbol, number), n in zip(rounded.items(), powers, strict=True):
            if n and symbol in generators:
                value *= number ** int(n)
                term = term * generators[symbol] ** int(n)
        at_rounded += value
        total = total + term
    return total, at_rounded


def _positive_solutions(basis: list[Any], count: int) -> list[Reals] | None:
    """Return the positive solutions of a lexicographic Groebner basis in t, the factor and
    ``count`` unknowns, values of these alone; None where there are infinitely many.

    The elimination theorem: the elements without the first generators are a basis in the others, so
    that the last unknown has an equation by itself, and each one before it one in those behind it.
    """
    solutions: list[list[float]] = [[]]
    for column in reversed(range(2, 2 + count)):  # before the unknowns: t and the factor
        eliminated = []
        for p in basis:
            degrees = p.degrees()
            if degrees[column] and not any(degrees[:column]):
                eliminated.append(p)
        # There are finitely many solutions exactly if for each unknown some polynomial of the basis
        # has a pure power of it as its leading monomial.
        pure = [p for p in eliminated if _is_pure_power(p.monomial(0), column)]
        if not pure:
            return None
        longer = []
        for later in solutions:
            roots = _positive_roots(pure[0], eliminated, column, later)
            if roots is None:
                return None
            longer += [[x, *later] for x in roots]
        solutions = longer
    return [np.array(x) for x in solutions]


def _is_pure_power(exponents: Sequence[int], column: int) -> bool:
    """Whether a monomial has no generator but the one of a column."""
    return not any(n for i, n in enumerate(exponents) if i != column)


def _positive_roots(
    pure: Any, polynomials: Sequence[Any], column: int, later: Sequence[float]
) -> list[float] | None:
    """Return the positive roots in the unknown of a column that some polynomials share, where the
    unknowns behind it have the values ``later``; None where rounding leaves it open whether one is
    real.

    ``pure`` : one whose leading monomial is a power of the unknown alone. Its degree is the same
    whatever the later values are, so that all that is shared is among its roots; one of lower
    degree may vanish at the exact values, and has arbitrary roots at rounded ones.
    """
    coefficients, _ = _in_unknown(pure, column, later)
    scale = lcm(*(x.denominator for x in coefficients))
    roots = []
    for root, _ in fmpz_poly([int(x * scale) for x in coefficients]).complex_roots():
        x, y = float(root.real.mid()), float(root.imag.mid())
        if x <= 0 or abs(y) >= _MAYBE_ROOT * x:
            continue
        residuals = []
        for p in polynomials:
            powers = [Fraction(x) ** n for n in range(p.degrees()[column] + 1)]
            value, size = (
                sum(map(mul, row, powers), Fraction(0)) for row in _in_unknown(p, column, later)
            )
            residuals.append(abs(value) <= Fraction(_MAYBE_ROOT) * size)
        if not all(residuals):
            continue
        # A multiple root that rounding splits leaves the axis by much more than a simple one.
        if abs(y) >= _SAME_ROOT * x:
            return None
        roots.append(x)
    return roots


def _in_unknown(
    p: Any, column: int, later: Sequence[float]
) -> tuple[list[Fraction], list[Fraction]]:
    """Return the coefficients, ascending, of a polynomial in the unknown of a column, where the
    unknowns behind it have the values ``later``, and the sums of the sizes of their terms."""
    coefficients = [Fraction(0)] * (p.degrees()[column] + 1)
    sizes = list(coefficients)
    for powers, c in p.to_dict().items():
        known = Fraction(int(c))
        for n, x in zip(powers[column + 1 :], later, strict=True):
            known *= Fraction(x) ** int(n)
        coefficients[int(powers[column])] += known
        sizes[int(powers[column])] += abs(known)
    return coefficients, sizes


# The response of a model, and values at which a search begins.


@dataclass(frozen=True, eq=False)
class WantedResponse:
    """H_perc of a wanted model at the frequencies ``omega``, rad/s, as a function of the values of
    its free parameters: complex, in N/m or N m/rad; NaN or infinite where there is no response."""

    wanted: Wanted
    omega: Reals

    @cached_property
    def _compiled(self) -> Callable[..., Any]:
        """The compiled function of omega and the parameters by their names."""
        environment, effects = self.wanted.elements(lambda x: x.symbol)
        return distort(environment, *effects).compile(of=["perceived_real", "perceived_imag"])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the free parameters' symbols, in their order."""
        return tuple(x.symbol.name for x in self.wanted.free)

    def __call__(self, values: Reals) -> Complexes:
        """Return the responses (sets, points) for sets of values (sets, parameters)."""
        sets = np.atleast_2d(values)
        columns = {name: sets[:, i, None] for i, name in enumerate(self.names)}
        with np.errstate(all="ignore"):
            parts = self._compiled(self.omega[None, :], **columns)
            H: Complexes = parts.perceived_real + 1j * parts.perceived_imag
        # A model that does not depend on a parameter, or on omega, has fewer entries.
        return np.broadcast_to(H, (len(sets), len(self.omega)))

    def at(self, values: Reals) -> Complexes:
        """Return the response for one set of values."""
        response: Complexes = self(values)[0]
        return response

    def slopes(self, values: Reals, steps: Reals) -> Complexes:
        """Return the slopes dH/dx (points, parameters) by central differences, a step for each
        parameter."""
        # All shifted sets in one call: the compiled function's overhead is paid once.
        shifts = np.diag(steps)
        H = self(np.concatenate([values + shifts, values - shifts]))
        ahead, behind = H[: len(steps)], H[len(steps) :]
        slopes: Complexes = ((ahead - behind) / (2 * steps[:, None])).T
        return slopes


def scales(free: tuple[Free, ...], m: Measurement) -> Reals:
    """Return how large each parameter is likely to be, in its unit (SI): from the median of |H| and
    the geometric mean of the frequencies."""
    size = float(np.median(np.abs(m.H))) or 1.0
    omega = _middle_frequency(m.omega)
    by_dimension = {
        Dimension.MASS: size / omega**2,
        Dimension.DAMPING: size / omega,
        Dimension.STIFFNESS: size,
        Dimension.FREQUENCY: omega,
        Dimension.TIME: 1 / omega,
        Dimension.RATIO: 1.0,
        Dimension.FORCE: size,
        Dimension.DISPLACEMENT: 1.0,
        Dimension.ANY: size,
    }
    return np.array([by_dimension[x.dimension] for x in free])


def _middle_frequency(omega: Reals) -> float:
    """Return the geometric mean of the positive frequencies, rad/s."""
    return float(np.exp(np.log(omega[omega > 0]).mean()))


def starts(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    """Yield sets of values at which the search for a minimum begins: the same ones each time."""
    count = min(len(m), _MOST_START_POINTS)
    few = m.at(np.unique(np.linspace(0, len(m) - 1, count).astype(int)))
    if wanted.degrees is not None:
        yield from _fraction_starts(wanted, few)
    else:
        yield from _drawn_starts(wanted, few)


# Models: sets of values drawn evenly on logarithmic scales, the best of them refined on the
# logarithm of the response.


def _drawn_starts(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    """Yield the best of many drawn sets of values, best first, each refined by ``_refined``."""
    free, scale = wanted.free, scales(wanted.free, m)
    response = WantedResponse(wanted, m.omega)
    count = _DRAWN_PER_PARAMETER * (len(free) + 1)
    # The seed is fixed: a fit gives the same result each time.
    shares = np.random.default_rng(2019).random((count, len(free)))
    columns = []
    for i, x in enumerate(free):
        columns.append(_from_share(x, scale[i], shares[:, i]))
    sets = np.stack(columns, axis=1)
    # On the logarithm: a start that is right but for its size is then close, and points of small
    # |H|, as at an antiresonance, count as much as large ones.
    distances = np.square(_log_ratio(response(sets), m.H)).sum(axis=1)
    misfit = np.nan_to_num(distances, nan=np.inf, posinf=np.inf)
    for i in np.argsort(misfit)[:_MOST_REFINED]:
        if np.isfinite(misfit[i]):
            yield _refined(response, m.H, sets[i], scale)


def _from_share(x: Free, scale: float, share: Reals) -> Reals:
    """Return values of a parameter for shares in [0, 1): evenly on a logarithmic scale around its
    ``scale``; a parameter of either sign is negative for shares below one half; a fraction lies
    evenly in (0.02, 0.98)."""
    if x.rule is Rule.FRACTION:
        return 0.02 + 0.96 * share
    low, high = _DRAWN_DECADES.get(x.dimension, _OTHER_DECADES)
    if x.rule is not Rule.ANY:
        exponent = low + (high - low) * share
        values: Reals = scale * 10**exponent
        return values
    exponent = low + (high - low) * np.abs(2 * share - 1)
    return scale * np.sign(share - 0.5) * 10**exponent


def _log_ratio(H: Complexes, measured: Complexes) -> Reals:
    """Return ln(H/measured) on the last axis: all real parts, which are logarithms of the ratio of
    magnitudes, then all phases, in (-pi, pi]; not finite where one of them is 0."""
    with np.errstate(all="ignore"):
        logarithm = np.log(H / measured)
    parts: Reals = np.concatenate([logarithm.real, logarithm.imag], axis=-1)
    return parts


def _refined(response: WantedResponse, measured: Complexes, start: Reals, scale: Reals) -> Reals:
    """Return values near ``start`` at which the sum of |ln(H/measured)|^2 is less."""
    from scipy.optimize import least_squares  # of the extra simulate

    # The unknowns u: a positive parameter is e^u, so that it cannot leave its range; one that may
    # be of either sign, or is a fraction, is u times its scale.
    rules = [x.rule for x in response.wanted.free]
    is_fraction = np.array([rule is Rule.FRACTION for rule in rules])
    is_linear = np.array([rule in (Rule.ANY, Rule.FRACTION) for rule in rules])

    def values(u: Reals) -> Reals:
        return np.where(is_linear, u * scale, np.exp(np.clip(u, -300, 300)))

    def residuals(u: Reals) -> Reals:
        log_ratio = _log_ratio(response.at(values(u)), measured)
        return np.nan_to_num(log_ratio, nan=1e3, posinf=1e3, neginf=-1e3)

    def jacobian(u: Reals) -> Reals:
        # d ln H/du = (dH/dx)/H dx/du, with dx/du = x for x = e^u.
        x = values(u)
        with np.errstate(all="ignore"):
            by_value = _central_slopes(response, x, scale) / response.at(x)[:, None]
            relative = by_value * np.where(is_linear, scale, x)
        finite: Reals = np.nan_to_num(_stacked(relative), nan=0.0, posinf=1e6, neginf=-1e6)
        return finite

    low = np.where(is_fraction, 1e-3, -np.inf)
    high = np.where(is_fraction, 1 - 1e-3, np.inf)
    # Logarithms move by half as much as a scale in a first step.
    step_sizes = np.where(is_linear, 1.0, 0.5)
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        u = np.where(is_linear, start / scale, np.log(np.abs(start)))
        end = least_squares(residuals, u, jacobian, (low, high), max_nfev=40, x_scale=step_sizes)
    refined: Reals = values(end.x)
    return refined


# Fractions: numerator and denominator by linear least squares, each time weighted with the
# denominator before.


def _fraction_starts(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    """Yield the values of a fraction's coefficients, and of a free delay beside it, for each of
    several delays."""
    ratio = m.H / _known_factor(wanted, m.omega)
    has_delay = any(x["model"] == "delay" for x in wanted.effects)
    is_delay_free = has_delay and any(x.name == "tau" for x in wanted.free)
    # A delay is no linear parameter: it is tried, from a fiftieth of a radian at the highest
    # frequency to a whole turn there, and taken out of the response.
    delays = [0.0]
    if is_delay_free:
        delays += list(np.geomspace(0.02, 6, 16) / float(m.omega[-1]))
    for tau in delays:
        undelayed = ratio * np.exp(1j * m.omega * tau)
        yield _fraction_for_delay(wanted, m.omega, undelayed, tau)


def _known_factor(wanted: Wanted, omega: Reals) -> Complexes:
    """Return what the fraction is multiplied by: H_env(j omega) where it is known, else 1."""
    if wanted.known is None:
        return np.ones(len(omega), dtype=complex)
    parts = distort(wanted.known).compile(of=["environment_real", "environment_imag"])(omega)
    H: Complexes = parts.environment_real + 1j * parts.environment_imag
    return H


def _fraction_for_delay(wanted: Wanted, omega: Reals, ratio: Complexes, tau: float) -> Reals:
    """Return the values of a wanted fraction: the coefficients of the N/D nearest the response
    ``ratio``, relative to its size, by the iteration of Sanathanan and Koerner; and ``tau`` for
    what is no coefficient."""
    assert wanted.degrees is not None
    numerator_keys, denominator_keys = _coefficient_keys(wanted.degrees)
    # Frequencies relative to a middle one: of columns (j omega)^12 in rad/s no digit would be left.
    middle = _middle_frequency(omega)
    powers = (1j * omega[:, None] / middle) ** np.arange(max(wanted.degrees) + 1)
    of_numerator = powers[:, : len(numerator_keys)]
    of_denominator = powers[:, 1 : 1 + len(denominator_keys)]
    # |N - H D| is linear in the coefficients, but weighs each point with |D|: divided by the D of
    # the round before, it tends to |N/D - H|. With D = 1 + ..., the 1 is the right-hand side H.
    size = np.abs(ratio)
    weight = 1 / np.maximum(size, _TINY)
    equations: Complexes = np.hstack([of_numerator, -ratio[:, None] * of_denominator])
    coefficients: Any = np.zeros(equations.shape[1])
    for _ in range(_ROUNDS):
        left = _stacked(equations * weight[:, None])
        right = _stacked(ratio * weight)
        coefficients = np.linalg.lstsq(left, right, rcond=None)[0]
        denominator = np.abs(1 + of_denominator @ coefficients[len(numerator_keys) :])
        weight = 1 / np.maximum(size * denominator, _TINY)
    scaled = zip([*numerator_keys, *denominator_keys], coefficients, strict=True)
    values = {key: x / middle ** int(key[1:]) for key, x in scaled}
    return np.array([values.get(x.name, tau) for x in wanted.free])


# Noise and weighted least squares.


@dataclass(frozen=True, eq=False)
class Noise:
    """The noise of the measured points.

    ``sigma`` : standard deviation of the real and of the imaginary part of each, as estimated from
    its disc. ``freedom`` : degrees of freedom of that estimate: infinite where the disc is given,
    so that sigma is no estimate; None where no disc is known and sigma is a share of |H| of unknown
    size.
    """

    sigma: Reals
    freedom: float | None

    def squares(self, residuals: Complexes) -> Reals:
        """Return for each point a number that has the distribution chi^2 of 2 degrees of freedom
        where the model holds.

        |r|^2/2 of residuals r in units of an estimated sigma has F(2, n), n = ``freedom``; then n
        ln(1 + |r|^2/n) has chi^2.
        """
        size = np.square(np.abs(residuals))
        n = self.freedom
        # P(F(2, n) > x) = (1 + 2 x/n)^(-n/2) and P(chi^2 > y) = exp(-y/2) are equal for this y.
        if n is None or np.isinf(n):
            return size
        squares: Reals = n * np.log1p(size / n)
        return squares

    @property
    def widening(self) -> float:
        """The factor of the variances of fitted values: n/(n - 4), as weights 1/sigma^2 that are
        estimated themselves are worth less than known ones; 1 where sigma is no estimate."""
        n = self.freedom
        return 1.0 if n is None or np.isinf(n) else n / (n - 4)


def noise_of(m: Measurement) -> Noise:
    """Return the noise that the uncertainty discs of a response stand for.

    With coherence g^2 and n = 2 averages - 2: sigma = |H| sqrt((1 - g^2)/(n g^2)) (Bendat and
    Piersol, Random Data). With a radius that holds the truth with probability p: sigma =
    radius/sqrt(-2 ln(1 - p)). Without either: sigma = |H|. SceneError where sigma cannot be a
    weight: too few averages, or a disc of radius 0.
    """
    if m.coherence is not None and m.averages is not None:
        if m.averages < LEAST_AVERAGES:
            raise SceneError(
                f"averages: {m.averages:g} are too few: at least {LEAST_AVERAGES} are needed"
            )
        freedom = 2 * m.averages - 2
        relative = np.sqrt((1 - m.coherence) / (freedom * m.coherence))
        sigma = np.abs(m.H) * relative
    elif m.radius is not None:
        # A Gaussian in the plane lies within r with probability 1 - exp(-r^2/(2 sigma^2)): solved
        # for sigma at the disc's confidence.
        freedom = np.inf
        sigma = m.radius / np.sqrt(-2 * np.log1p(-m.confidence))
    else:
        size = np.abs(m.H)
        # Without discs all points weigh alike, relative to |H|; one of size 0 weighs as the middle
        # one.
        return Noise(np.where(size > 0, size, np.median(size) or 1.0), None)
    if (sigma <= 0).any():
        i = int(np.argmax(sigma <= 0))
        raise SceneError(
            f"the disc at {m.omega[i]:.6g} rad/s has radius 0: a frequency point without "
            f"error cannot be weighted; "
            "leave out coherence and radius if there is no noise"
        )
    return Noise(sigma, freedom)


def usable(m: Measurement) -> Measurement:
    """Return the frequency points that can be fitted: not that at 0, which has no phase, and none
    whose disc is the whole plane. SceneError where none is left."""
    kept = m.omega > 0
    if m.coherence is not None:
        kept &= m.coherence > 0
    if m.radius is not None:
        kept &= np.isfinite(m.radius)
    if not kept.any():
        raise SceneError(
            f"{m.name}: no frequency point above 0 rad/s has a bounded uncertainty disc"
        )
    return m.at(kept)


@dataclass(frozen=True, eq=False)
class Fit:
    """A fit by weighted least squares.

    ``lines`` : the frequency points that were fitted. ``values`` : of the free parameters, in the
    order of ``wanted.free``, SI. ``covariance`` : of these, linearised. ``model`` : the response
    there; ``residuals`` : measured less model, in units of sigma. ``starts`` : from how many the
    search ended at a minimum; ``agreeing`` : how many ended at one as low as this. ``others`` :
    other values that give the same response; () where there are none, None where that is not known.
    ``period`` : s, by how much a delay may be longer on evenly spaced points; None where no start
    found a longer one.
    """

    wanted: Wanted
    lines: Measurement
    noise: Noise
    values: Reals
    covariance: Reals
    model: Complexes
    residuals: Complexes
    starts: int
    agreeing: int
    others: tuple[Reals, ...] | None = None
    period: float | None = None

    @property
    def freedom(self) -> int:
        """Degrees of freedom: numbers that were measured, less those that were fitted."""
        return 2 * len(self.lines) - len(self.values)


def fit(wanted: Wanted, m: Measurement, begins: Iterable[Reals] | None = None) -> Fit:
    """Return the values of the free parameters with the least cost S that was found: nothing proves
    that there is no lower minimum.

    ``begins`` : sets of values at which the search begins; None for those of ``starts``. SceneError
    where there are fewer numbers than parameters, the model has no finite response, the data do not
    identify all parameters, or discs cannot be weights.
    """
    lines = usable(m)
    free, noise = wanted.free, noise_of(lines)
    response = WantedResponse(wanted, lines.omega)
    if 2 * len(lines) <= len(free):
        numbers = counted(len(free), "parameter")
        raise SceneError(
            f"{numbers} need at least {len(free) // 2 + 1} frequency points, not {len(lines)}"
        )
    minima: list[_Minimum] = []
    for start in begins or starts(wanted, lines):
        tick(len(minima), None, "starts")
        minimum = _local_minimum(response, lines, noise, start)
        if minimum is not None:
            minima.append(minimum)
    if not minima:
        raise SceneError(
            "the model has no finite response at these frequencies for any values tried"
        )
    least = min(minima, key=lambda x: x.cost)
    # Values that fit as well may be others, as of two lags that change places; a delay may be
    # longer by a whole period. All of them are compared before one is chosen.
    as_low = [x.values for x in minima if _is_as_low(x.cost, least.cost)]
    (cost, values), period = _with_shortest_delays(response, lines, noise, least, as_low)
    model = response.at(values)
    residuals = (lines.H - model) / noise.sigma
    covariance = _covariance(response, lines, noise, values) * noise.widening
    # Where no disc is known sigma is right up to a factor, which is estimated from the residuals:
    # its square is the sum of squares, 2 S, over the degrees of freedom.
    if noise.freedom is None:
        covariance = covariance * 2 * cost / (2 * len(lines) - len(free))
    return Fit(
        wanted,
        lines,
        noise,
        values,
        covariance,
        model,
        residuals,
        len(minima),
        len(as_low),
        period=period,
    )


def with_others(found: Fit) -> Fit:
    """Return a fit with ``others``: all other values that give the same response, each fitted to
    the data; with None where that is not decided."""
    # Equal fractions whose denominators begin with 1 have equal coefficients.
    if found.wanted.degrees is not None:
        return replace(found, others=())
    approximate = twins(found.wanted, found.values)
    if approximate is None:
        return found
    response = WantedResponse(found.wanted, found.lines.omega)
    cost = float(np.square(np.abs(found.residuals)).sum() / 2)
    # The values were rounded to three digits: each is refined, and counts if it then fits as well.
    others = []
    for start in approximate:
        minimum = _local_minimum(response, found.lines, found.noise, start)
        if minimum is not None and _is_as_low(minimum.cost, cost):
            others.append(minimum.values)
    # Where every one was lost in refining, it is not known whether there are others.
    if approximate and not others:
        return found
    return replace(found, others=tuple(others))


class _Minimum(NamedTuple):
    """The end of a search: the cost S and the values."""

    cost: float
    values: Reals


def _is_as_low(cost: float, least: float) -> bool:
    """Whether a cost counts as equal to the least one, or is lower."""
    return cost <= least * (1 + _EQUAL_SHARE) + _EQUAL_COST


def _with_shortest_delays(
    response: WantedResponse, m: Measurement, noise: Noise, least: _Minimum, as_low: list[Reals]
) -> tuple[_Minimum, float | None]:
    """Return, of the minima that fit equally well, the one with the shortest delays; and the
    period by which others are longer, None where none is.

    exp(-j omega tau) is the same at all points of spacing d, multiples of d, for a delay that is
    longer by 2 pi/d.
    """
    delays = []
    for i, x in enumerate(response.wanted.free):
        if x.dimension is Dimension.TIME and ".delay" in x.path:
            delays.append(i)
    spacings = np.diff(m.omega)
    if not delays or len(spacings) < 1 or np.ptp(spacings) > 1e-6 * spacings.min():
        return least, None
    period = 2 * np.pi / float(spacings.mean())

    def total_delay(values: Reals) -> float:
        return float(values[delays].sum())

    candidates = [least]
    candidates += [_Minimum(least.cost, values) for values in as_low]
    shortest = min(candidates, key=lambda x: total_delay(x.values))
    # No start may have ended at the shortest delay: whole periods are taken off, and the fit is
    # made again, as points off the multiples would show a difference.
    for i in delays:
        shorter = shortest.values.copy()
        shorter[i] %= period
        if not shorter[i] < shortest.values[i]:
            continue
        fitted = _local_minimum(response, m, noise, shorter)
        if fitted is not None and _is_as_low(fitted.cost, shortest.cost):
            shortest = fitted
    bound = total_delay(shortest.values) + period / 2
    is_longer = any(total_delay(x) > bound for x in (least.values, *as_low))
    return shortest, period if is_longer else None


def _local_minimum(
    response: WantedResponse, m: Measurement, noise: Noise, start: Reals
) -> _Minimum | None:
    """Return the minimum of the cost that a search from ``start`` ends at; None where the response
    is not finite there."""
    from scipy.optimize import least_squares  # of the extra simulate

    free = response.wanted.free
    # The search moves in units of the start: stiffness and mass then count alike in its steps.
    unit = np.maximum(np.abs(start), scales(free, m) * 1e-3)

    def residuals(u: Reals) -> Reals:
        return _stacked((response.at(u * unit) - m.H) / noise.sigma)

    def jacobian(u: Reals) -> Reals:
        slopes = _central_slopes(response, u * unit, unit)
        return _stacked(slopes * (unit / noise.sigma[:, None]))

    # The start must lie inside the bounds, not on them.
    low, high = _bounds(free, unit)
    u = np.clip(start / unit, low + 1e-9, high - 1e-9)
    if not np.isfinite(residuals(u)).all():
        return None
    settings: dict[str, Any] = {"x_scale": "jac", "max_nfev": 100, "xtol": 1e-12, "ftol": 1e-12}
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        end = least_squares(_finite(residuals), u, _finite(jacobian), (low, high), **settings)
    # The search comes near a bound, never to it: a parameter that fits as well at 0 is 0.
    at_bound = np.where((low == 0) & (end.x < 1e-6), 0.0, end.x)
    cost = float(np.square(_finite(residuals)(at_bound)).sum() / 2)
    if cost <= end.cost * (1 + _EQUAL_SHARE):
        return _Minimum(cost, at_bound * unit)
    return _Minimum(float(end.cost), end.x * unit)


def _finite(f: Callable[[Reals], Reals]) -> Callable[[Reals], Reals]:
    """Return a function with large numbers in place of infinite ones: a search turns back there,
    where it would fail at a NaN."""
    return lambda u: np.nan_to_num(f(u), nan=1e9, posinf=1e9, neginf=-1e9)


def _stacked(z: Complexes) -> Reals:
    """Return the real parts, then the imaginary ones, along the first axis: least squares is over
    real numbers."""
    return np.concatenate([z.real, z.imag])


def _central_slopes(response: WantedResponse, values: Reals, unit: Reals) -> Complexes:
    """Return the slopes dH/dx (points, parameters) at values whose usual size is ``unit``."""
    return response.slopes(values, _STEP * np.maximum(np.abs(values), 1e-3 * unit))


def _bounds(free: tuple[Free, ...], unit: Reals) -> tuple[Reals, Reals]:
    """Return lower and upper bounds of each parameter, in its ``unit``."""
    low, high = [], []
    for x, size in zip(free, unit, strict=True):
        # A fraction is bounded by itself; other bounds only say that a value is not negative.
        if x.rule is Rule.FRACTION:
            low.append(1e-4 / size)
            high.append((1 - 1e-4) / size)
        else:
            low.append({Rule.ANY: -np.inf, Rule.POSITIVE: 1e-9}.get(x.rule, 0.0))
            high.append(np.inf)
    return np.array(low), np.array(high)


def _covariance(response: WantedResponse, m: Measurement, noise: Noise, values: Reals) -> Reals:
    """Return the covariance (J^T J)^-1 of the values, where J (2 points, parameters) has the real
    and imaginary parts of the slopes over sigma; SceneError where the data do not identify all
    parameters."""
    free = response.wanted.free
    # Steps that are so small that rounding dominates the differences would make dependent columns
    # look independent: they are at least 1e-6 of the parameter's scale.
    unit = np.maximum(np.abs(values), 1e2 * scales(free, m))
    J = _stacked(_central_slopes(response, values, unit) / noise.sigma[:, None])
    # Columns of length 1, so that the ratio of singular values does not depend on units.
    norms = np.linalg.norm(J, axis=0)
    without_effect = [x.path for x, norm in zip(free, norms, strict=True) if not norm > 0]
    if without_effect:
        raise SceneError(
            f"The data do not identify {' and '.join(without_effect)}. Fix it: model:key=value."
        )
    _, singular, directions = np.linalg.svd(J / norms, full_matrices=False)
    if singular[-1] < _LEAST_SINGULAR * singular[0]:
        # The direction in which the response does not change: whatever has a share in it.
        shares = np.abs(directions[-1])
        mixed = [x.path for x, share in zip(free, shares, strict=True) if share > 0.1]
        raise SceneError(
            f"The data do not identify {' and '.join(mixed)} separately. Fix one: model:key=value."
        )
    # J = U S V^T with the norms N beside it: the covariance is R R^T with R = N^-1 V S^-1. J^T J
    # itself is not formed: its inverse would lose twice the digits.
    R = directions.T / singular / norms[:, None]
    covariance: Reals = R @ R.T
    return covariance
