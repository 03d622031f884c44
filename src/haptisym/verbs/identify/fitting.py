"""Models with free parameters, values at which a fit begins, and weighted least squares.

What is to be identified are models of the catalogue, or fractions of given degrees, with parameters
that are free (``wanted``). A fit begins at values that are drawn around the scales of the measured
response, and for a fraction at linear least squares, each time weighted with the denominator
before (``starts``). It ends where the sum of |H_model - H_measured|^2/sigma^2 is least, sigma from
the uncertainty disc of each frequency point (``fit``).

Whether other values of a model's parameters give the very same response is a question of algebra,
which no frequency point answers (``twins``). Two responses are equal where numerator and
denominator are, but for one common factor. With the values that were found (to three digits) on the
one side these are polynomial equations for the parameters, solved by a Groebner basis.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from math import lcm
from operator import mul
from typing import Any, TypeAlias

import numpy as np
from flint import fmpz_mpoly_ctx, fmpz_mpoly_vec, fmpz_poly
from sympy import Symbol

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError, meant, within
from haptisym.kernel.objects import counted
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment, Model
from haptisym.model.distortion import distort
from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.parameters import NAMED, Rule, Slot, free_name
from haptisym.model.quantities import Dimension

Table: TypeAlias = Mapping[str, Any]
Degrees: TypeAlias = tuple[int, int]
HIGHEST = 12
"""The highest degree of a numerator or denominator."""
MOST = 16
"""The largest number of free parameters."""


@dataclass(frozen=True)
class Free:
    """A free parameter: its path in the scene that will be written, and the symbol that stands
    for it until then."""

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
    """Tables of a scene file, in which a parameter may be ``Free``. ``degrees`` : where a fraction
    is wanted.

    ``known`` : what should be felt, where that is given and nothing in it is free.
    """

    environment: Table
    effects: tuple[Table, ...]
    degrees: Degrees | None = None
    known: Environment | None = None

    @property
    def free(self) -> tuple[Free, ...]:
        """The parameters to be fitted, environment first."""
        return tuple(_free((self.environment, *self.effects)))

    @property
    def words(self) -> str:
        """The names of the models, as ``mass-spring-damper, delay``."""
        return ", ".join(str(x.get("name", x["model"])) for x in (self.environment, *self.effects))

    def elements(self, value: Callable[[Free], Any]) -> tuple[Environment, tuple[Effect, ...]]:
        """Environment and effects with these values for what is free."""
        environment = self.known or _built(ENVIRONMENTS, filled(self.environment, value))
        return environment, tuple(_built(EFFECTS, filled(x, value)) for x in self.effects)


def filled(given: Any, value: Callable[[Free], Any]) -> Any:
    """Return a table with values in the places of what is free."""
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
    arguments = dict(table)
    return catalogue[str(arguments.pop("model"))].build(**arguments)


def wanted(
    environment: str | None,
    effects: Sequence[str],
    degrees: Degrees | None,
    known: tuple[Environment, Table] | None,
) -> Wanted:
    """Return the wanted model that the words of a call describe. SceneError for unknown models and
    keys, and combinations that cannot be.

    ``environment``, ``effects`` : a model each, as ``"shunt"``, ``"shunt:m,b"`` (with these
    parameters alone of those that may be absent) or ``"second-order-lowpass:zeta=0.5"`` (with a
    given value). ``degrees`` : of a numerator and a denominator, in place of a model of the
    environment; of a series effect where the environment is ``known``.

    >>> [x.path for x in wanted("mass-spring-damper:k,b", ["delay"], None, None).free]
    ['environment.k', 'environment.b', 'effects.delay.tau']
    """
    # Free parameters are numbered symbols, so that two effects of one model never share one.
    names = _Symbols()
    if known is not None:
        if environment is not None:
            raise SceneError(
                "environment: the scene gives it: leave it out, or give the file of the "
                "response instead of the scene"
            )
        felt: Table = known[1]
    elif degrees is not None:
        if environment is not None:
            raise SceneError(
                f"degrees: a fraction replaces the model: leave out {environment} or the degrees"
            )
        felt = _fraction(degrees, "environment", names)
    elif environment is None:
        models = ", ".join(x for x in ENVIRONMENTS if x != "expression")
        raise SceneError(f"environment: name a model to fit, or give degrees; models are {models}")
    else:
        felt = _model(environment, ENVIRONMENTS, "environment", names)
    rows = [_fraction(degrees, "effects.fraction", names)] if degrees and known else []
    taken = {"fraction"}
    for text in effects:
        model = text.partition(":")[0].strip()
        name = free_name(model, taken, "-")
        taken.add(name)
        row = _model(text, EFFECTS, f"effects.{name}", names)
        rows.append(row if name == model else {"name": name, **row})
    asked = Wanted(felt, tuple(rows), degrees, known[0] if known else None)
    _check(asked)
    return asked


def _check(asked: Wanted) -> None:
    """Raise SceneError where nothing, or too much, is free."""
    if not asked.free and asked.known and not asked.effects:
        raise SceneError(
            "no parameter is free: name the effects to fit, as --effect delay, or --degrees 1 2; "
            f"effects are {', '.join(EFFECTS)}"
        )
    if not asked.free:
        raise SceneError("no parameter is free: leave out the value of at least one")
    if len(asked.free) > MOST:
        raise SceneError(f"{len(asked.free)} parameters are free: at most {MOST} can be fitted")
    # A fraction has all zeros and poles of its degrees: another rational effect next to it could
    # not be told from it.
    others = [x for x in asked.effects if x["model"] != "series"]
    if asked.degrees and any(x["model"] != "delay" for x in others):
        raise SceneError(
            "degrees: a fraction is fitted with a delay only: leave out the other effects"
        )


class _Symbols:
    """Makes symbols, numbered in the order in which they are asked for."""

    def __init__(self) -> None:
        self.count = 0

    def free(self, path: str, slot: Slot) -> Free:
        self.count += 1
        signs = {"real": True} if slot.rule is Rule.ANY else {"positive": True}
        return Free(path, Symbol(f"free{self.count}", **signs), slot.dimension, slot.rule)


def _fraction(degrees: Degrees, place: str, names: _Symbols) -> Table:
    """Return the table of a fraction whose denominator begins with 1: a common factor of numerator
    and denominator would else be free."""
    above, below = degrees
    whole = [isinstance(x, int) and not isinstance(x, bool) for x in degrees]
    if not all(whole) or not all(0 <= x <= HIGHEST for x in degrees):
        raise SceneError(f"degrees: {above} and {below} must be whole numbers from 0 to {HIGHEST}")
    above_keys = [f"a{i}" for i in range(above + 1)]
    below_keys = [f"d{i}" for i in range(1, below + 1)]
    keys = above_keys, below_keys
    top, bottom = (" + ".join(_term(x) for x in part) for part in keys)
    formula = f"({top})/(1 + {bottom})" if bottom else top
    parameters = {key: names.free(f"{place}.{key}", NAMED) for part in keys for key in part}
    if place == "environment":
        return {"model": "expression", "H": formula, "parameters": parameters}
    return {"model": "series", "name": "fraction", "G": formula, "parameters": parameters}


def _term(key: str) -> str:
    power = int(key[1:])
    return key if power == 0 else f"{key}*s" if power == 1 else f"{key}*s^{power}"


def _model(text: str, catalogue: Mapping[str, Model], place: str, names: _Symbols) -> Table:
    """Return the table of a model that a text names, with what has no value free."""
    kind = place.partition(".")[0].rstrip("s")
    name, colon, listed = (x.strip() for x in str(text).partition(":"))
    if name not in catalogue:
        raise SceneError(
            f'{kind}: unknown model "{name[:60]}": {meant(name, catalogue)}valid are '
            f"{', '.join(catalogue)}"
        )
    slots = catalogue[name].slots
    formulas = [key for key, x in slots.items() if x.formula and x.required]
    if formulas:
        raise SceneError(
            f"{name}: a formula has no parameters to fit: choose another model, or degrees"
        )
    with within(name):
        if colon:
            keys = _keys(listed, slots)
        else:
            numbers = {key: x for key, x in slots.items() if not x.formula}
            keys = {key: None for key, x in numbers.items() if x.required or not x.is_setting}
        entries = {
            key: _entry(f"{place}.{key}", slots[key], given, names) for key, given in keys.items()
        }
    return {"model": name, **entries}


def _keys(listed: str, slots: Mapping[str, Slot]) -> dict[str, str | None]:
    """The parameters that a model has: those that are listed, each with its value if it has one,
    and the required ones."""
    given: dict[str, str | None] = {}
    for word in listed.split(","):
        key, equals, value = (x.strip() for x in word.partition("="))
        valid = [x for x, slot in slots.items() if not slot.formula]
        if key not in valid:
            raise SceneError(
                f'unknown parameter "{key[:60]}": {meant(key, valid)}valid are {", ".join(valid)}'
            )
        if key in given:
            raise SceneError(f"{key} is there twice")
        given[key] = value if equals else None
    required = {key: None for key, x in slots.items() if x.required and not x.formula}
    return given | {key: None for key in required if key not in given}


def _entry(path: str, slot: Slot, given: str | None, names: _Symbols) -> Any:
    """Return what stands for one parameter: its given value, a free symbol, or a list of these."""
    key = path.rpartition(".")[2]
    if slot.several:
        count = int(given) if given and re.fullmatch(r"[1-9]\d?", given) else 0
        if not count:
            raise SceneError(f"{key}: give the number of entries, as {key}=2")
        return [names.free(f"{path}[{i}]", slot) for i in range(1, count + 1)]
    if slot.is_setting:
        if given is None:
            raise SceneError(f"{key}: cannot be fitted: give it, as {key}={[*slot.choices, 1][0]}")
        return int(given) if given.isdigit() else given
    return names.free(path, slot) if given is None else given


_LIMITS = 60, 400, 20_000  # polynomials of a basis, terms of one, bits of a coefficient
# Relative: values and roots that differ by less are one. Solutions are roots of polynomials whose
# coefficients were computed from earlier roots, in floats.
_SAME = 1e-4


def twins(wanted: Wanted, values: Reals) -> tuple[Reals, ...] | None:
    """Return other positive values that give nearly the response of these; None where that was not
    decided.

    What stands in a delay or a power of s keeps its value.

    >>> from haptisym.verbs.identify.fitting import wanted
    >>> asked = wanted("maxwell", ["first-order-lag"], None, None)
    >>> [x.round(6).tolist() for x in twins(asked, np.array([300.0, 6.0, 12.0]))]
    [[72.0, 6.0, 50.0]]
    """
    environment, effects = wanted.elements(lambda x: x.symbol)
    perceived = distort(environment, *effects).perc.reduced()
    ring, parts = perceived.ring, (perceived.numerator, perceived.denominator)
    inside = {x for meaning in ring.meanings[ring.size :] for x in meaning.free_symbols}
    # Three digits keep the coefficients of the basis small: with all digits of floats it would not
    # be found within its limits.
    near = {
        x.symbol: Fraction(f"{value:.3g}")
        for x, value in zip(wanted.free, values.tolist(), strict=True)
    }
    free = [x for x in near if x not in inside]
    if not free or any(near[x] <= 0 for x in free):
        return None
    # Numerator and denominator equal those at the known values times one unknown factor:
    # coefficient by coefficient one polynomial equation in the free parameters and the factor.
    places = [ring.meanings.index(x) for x in near]
    context = fmpz_mpoly_ctx.get(["t", "factor", *map(str, free)], "lex")
    _, factor, *unknown = context.gens()
    # t times the factor times all unknowns is 1: none of them is 0, which would add whole families
    # of solutions that are no models.
    equations = [reduce(mul, unknown, context.gens()[0] * factor) - 1]
    for part in parts:
        # By the powers of s, delays and so on; below each, by the powers of the parameters.
        rows: dict[tuple[int, ...], dict[tuple[int, ...], Fraction]] = {}
        for powers, coefficient in part.to_dict().items():
            outer = tuple(0 if i in places else n for i, n in enumerate(powers))
            inner = tuple(powers[i] for i in places)
            number = Fraction(int(coefficient.p), int(coefficient.q))
            rows.setdefault(outer, {})[inner] = number
        generators = dict(zip(free, unknown, strict=True))
        for terms in rows.values():
            total, known = _equation(context.constant(0), terms, near, generators)
            equations.append(total * known.denominator - factor * known.numerator)
    basis, whole = fmpz_mpoly_vec(equations, context).buchberger_naive(limits=_LIMITS)
    if not whole:
        return None
    solutions = _solved([*basis.autoreduction()], len(unknown))
    if solutions is None:
        return None
    given = np.array([float(near[x]) for x in free])
    others = [x for x in solutions if not np.allclose(x, given, rtol=_SAME)]
    complete = []
    for other in others:
        row = [other[free.index(x)] if x in free else values[i] for i, x in enumerate(near)]
        complete.append(np.array(row))
    return tuple(complete)


def _equation(total: Any, terms: Any, near: Any, unknown: Any) -> tuple[Any, Fraction]:
    """Return a coefficient as a polynomial in the unknowns, times a whole number, and its value
    at the known values."""
    known, scale = Fraction(0), lcm(*(c.denominator for c in terms.values()))
    for powers, c in terms.items():
        term = total * 0 + int(c * scale)
        value = c * scale
        for (symbol, at), n in zip(near.items(), powers, strict=True):
            value *= at ** int(n)
            if n and symbol in unknown:
                term = term * unknown[symbol] ** int(n)
        known += value
        total = total + term
    return total, known


def _solved(basis: list[Any], count: int) -> list[Reals] | None:
    """Return the positive solutions of a basis in lexical order, from the last unknown on; None
    where there are infinitely many."""
    solutions: list[list[float]] = [[]]
    for k in range(count):
        place = 2 + count - 1 - k  # behind t and the factor
        eliminated = [p for p in basis if p.degrees()[place] and not any(p.degrees()[:place])]
        # There are finitely many solutions exactly if for each unknown some polynomial of the basis
        # has a pure power of it as its leading monomial.
        leading = [p.monomial(0) for p in eliminated]
        if not any(not any(n for i, n in enumerate(x) if i != place) for x in leading):
            return None
        solutions = [[x, *rest] for rest in solutions for x in _roots(eliminated, place, rest)]
    return [np.array(x) for x in solutions]


def _roots(polynomials: Sequence[Any], place: int, rest: Sequence[float]) -> Iterator[float]:
    """Yield the positive roots of the polynomial of least degree in one unknown, the later unknowns
    being known."""
    rows = []
    for p in polynomials:
        row = [Fraction(0)] * (p.degrees()[place] + 1)
        for powers, c in p.to_dict().items():
            later = zip(powers[place + 1 :], rest, strict=True)
            factor = float(np.prod([x ** int(n) for n, x in later]))
            row[int(powers[place])] += int(c) * Fraction(factor)
        rows.append(row)
    # The later unknowns are floats, so that no number is exactly a root of all polynomials: the one
    # of least degree decides.
    row = min((x for x in rows if any(x[1:])), key=len, default=[Fraction(1)])
    scale = lcm(*(x.denominator for x in row))
    for root, _ in fmpz_poly([int(x * scale) for x in row]).complex_roots():
        x, y = float(root.real.mid()), float(root.imag.mid())
        if x > 0 and abs(y) < _SAME * x:
            yield x


@dataclass(frozen=True, eq=False)
class WantedResponse:
    """H_perc of a wanted model at given frequencies, rad/s, as a function of its free
    parameters."""

    wanted: Wanted
    omega: Reals

    @cached_property
    def _compiled(self) -> Callable[..., Any]:
        environment, effects = self.wanted.elements(lambda x: x.symbol)
        return distort(environment, *effects).compile(of=["perceived_real", "perceived_imag"])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the free parameters' symbols, in their order."""
        return tuple(x.symbol.name for x in self.wanted.free)

    def __call__(self, values: Reals) -> Complexes:
        """Return the responses (sets, points) for sets of values (sets, parameters); NaN where
        there is none."""
        sets = np.atleast_2d(values)
        columns = {name: sets[:, i, None] for i, name in enumerate(self.names)}
        with np.errstate(all="ignore"):
            found = self._compiled(self.omega[None, :], **columns)
            H: Complexes = found.perceived_real + 1j * found.perceived_imag
        return np.broadcast_to(H, (len(sets), len(self.omega)))

    def at(self, values: Reals) -> Complexes:
        """Return the response for one set of values."""
        response: Complexes = self(values)[0]
        return response

    def slopes(self, values: Reals, steps: Reals) -> Complexes:
        """Return the slopes of the response by central differences, (points, parameters)."""
        # All shifted sets in one call: the compiled function's overhead is paid once.
        shifts = np.diag(steps)
        H = self(np.concatenate([values + shifts, values - shifts]))
        count = len(steps)
        slopes: Complexes = ((H[:count] - H[count:]) / (2 * steps[:, None])).T
        return slopes


_MOST_LINES = 200
"""Frequency points that the choice of starts uses: more only cost time."""
_DRAWN, _REFINED = 64, 10
"""Sets of values for each parameter and one more, and how many of the best are refined."""
_DECADES = {
    Dimension.MASS: (-2.5, 1.0),
    Dimension.DAMPING: (-2.5, 1.0),
    Dimension.STIFFNESS: (-1.5, 1.5),
    Dimension.FREQUENCY: (-0.5, 2.5),
    Dimension.TIME: (-3.0, 0.3),
    Dimension.RATIO: (-1.0, 0.3),
}
"""Powers of ten between which a parameter is drawn, relative to its scale."""


def scales(free: tuple[Free, ...], m: Measurement) -> Reals:
    """Return how large each parameter is likely to be: median of |H| and mean frequency, in its
    unit."""
    size = float(np.median(np.abs(m.H))) or 1.0
    omega = float(np.exp(np.log(m.omega[m.omega > 0]).mean()))
    known = {
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
    return np.array([known[x.dimension] for x in free])


def starts(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    """Yield sets of values at which a fit begins."""
    few = m.at(np.unique(np.linspace(0, len(m) - 1, min(len(m), _MOST_LINES)).astype(int)))
    if wanted.degrees is not None:
        yield from _fractions(wanted, few)
    else:
        yield from _drawn(wanted, few)


# Models: sets of values drawn evenly on logarithmic scales, the best of them refined on the
# logarithm of the response.


def _drawn(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    """Yield the best of many drawn sets of values, each refined. The seed is fixed: a fit gives the
    same result each time."""
    free, scale = wanted.free, scales(wanted.free, m)
    curve = WantedResponse(wanted, m.omega)
    count = _DRAWN * (len(free) + 1)
    points = np.random.default_rng(2019).random((count, len(free)))
    columns = [_spread(x, c, u) for x, c, u in zip(free, scale, points.T, strict=True)]
    sets = np.stack(columns, axis=1)
    # On the logarithm: a start that is right but for its size is then close, and points of small
    # |H|, as at an antiresonance, count as much as large ones.
    distances = np.square(_logarithm(curve(sets), m.H)).sum(axis=1)
    misfit = np.nan_to_num(distances, nan=np.inf)
    for i in np.argsort(misfit)[:_REFINED]:
        if np.isfinite(misfit[i]):
            yield _refined(curve, m.H, sets[i], scale)


def _spread(x: Free, scale: float, share: Reals) -> Reals:
    """Return values of a parameter for shares from 0 to 1: evenly on a logarithmic scale; below one
    half negative where it may be of either sign."""
    if x.rule is Rule.FRACTION:
        return 0.02 + 0.96 * share
    low, high = _DECADES.get(x.dimension, (-2.0, 2.0))
    if x.rule is not Rule.ANY:
        values: Reals = scale * 10 ** (low + (high - low) * share)
        return values
    exponent = low + (high - low) * np.abs(2 * share - 1)
    return scale * np.sign(share - 0.5) * 10**exponent


def _logarithm(H: Complexes, measured: Complexes) -> Reals:
    """Return the logarithm of the magnitude of the quotient H/measured, then its phase in (-pi,
    pi]."""
    with np.errstate(all="ignore"):
        quotient = np.log(H / measured)
    parts: Reals = np.concatenate([quotient.real, quotient.imag], axis=-1)
    return parts


def _refined(curve: WantedResponse, measured: Complexes, begin: Reals, scale: Reals) -> Reals:
    """Return values near ``begin`` with a smaller distance on the logarithm of the response."""
    from scipy.optimize import least_squares  # of the extra simulate

    # A positive parameter moves on its logarithm, and cannot leave its range; one that may be of
    # either sign, or is a fraction, moves in units of its scale.
    signed = np.array([x.rule in (Rule.ANY, Rule.FRACTION) for x in curve.wanted.free])
    fraction = np.array([x.rule is Rule.FRACTION for x in curve.wanted.free])

    def values(u: Reals) -> Reals:
        return np.where(signed, u * scale, np.exp(np.clip(u, -300, 300)))

    def rest(u: Reals) -> Reals:
        return np.nan_to_num(
            _logarithm(curve.at(values(u)), measured), nan=1e3, posinf=1e3, neginf=-1e3
        )

    def slope(u: Reals) -> Reals:
        # d ln H/du = (dH/dx)/H dx/du, with dx/du = x for x = e^u.
        point = values(u)
        with np.errstate(all="ignore"):
            steps = 1e-5 * np.maximum(np.abs(point), 1e-3 * scale)
            by_value = curve.slopes(point, steps) / curve.at(point)[:, None]
            relative = by_value * np.where(signed, scale, point)
        stacked = np.concatenate([relative.real, relative.imag])
        finite: Reals = np.nan_to_num(stacked, nan=0.0, posinf=1e6, neginf=-1e6)
        return finite

    with np.errstate(all="ignore"):
        u = np.where(signed, begin / scale, np.log(np.abs(begin)))
    ends = np.where(fraction, 1e-3, -np.inf), np.where(fraction, 1 - 1e-3, np.inf)
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        end = least_squares(rest, u, slope, ends, max_nfev=40, x_scale=np.where(signed, 1.0, 0.5))
    refined: Reals = values(end.x)
    return refined


# Fractions: numerator and denominator by linear least squares, each time weighted with the
# denominator before.


def _fractions(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    """Yield the coefficients of a fraction for each of several delays."""
    assert wanted.degrees is not None
    ratio = m.H / _known(wanted, m.omega)
    has_delay = any(x["model"] == "delay" for x in wanted.effects)
    is_delayed = has_delay and any(x.name == "tau" for x in wanted.free)
    # A delay is no linear parameter: from a fiftieth of a radian at the highest frequency to a
    # whole turn there it is tried, and taken out of the response.
    top = float(m.omega[-1])
    for tau in [0.0, *np.geomspace(0.02, 6, 16) / top] if is_delayed else [0.0]:
        yield _linear(wanted, m.omega, ratio * np.exp(1j * m.omega * tau), tau)


def _known(wanted: Wanted, omega: Reals) -> Complexes:
    """Return what the fraction is multiplied by: H_env where it is known, else 1."""
    if wanted.known is None:
        return np.ones(len(omega), dtype=complex)
    parts = distort(wanted.known).compile(of=["environment_real", "environment_imag"])(omega)
    H: Complexes = parts.environment_real + 1j * parts.environment_imag
    return H


def _linear(wanted: Wanted, omega: Reals, ratio: Complexes, tau: float) -> Reals:
    """Return the coefficients of N/D nearest to a response, relative to it, and the delay."""
    assert wanted.degrees is not None
    above, below = wanted.degrees
    # Frequencies relative to a middle one: of columns (j omega)^12 in rad/s no digit would be left.
    middle = float(np.exp(np.log(omega[omega > 0]).mean()))
    powers = (1j * omega[:, None] / middle) ** np.arange(max(above, below) + 1)
    top, bottom = powers[:, : above + 1], powers[:, 1 : below + 1]
    # |N - H D| is linear in the coefficients, but weighs each point with |D|: divided by the D of
    # the round before, it tends to |N/D - H|.
    size = np.abs(ratio)
    weight = 1 / np.maximum(size, 1e-300)
    coefficients = np.zeros(above + below + 1)
    for _ in range(20):
        A = np.hstack([top, -ratio[:, None] * bottom]) * weight[:, None]
        b = ratio * weight
        rows = np.vstack([A.real, A.imag])
        right = np.concatenate([b.real, b.imag])
        coefficients = np.linalg.lstsq(rows, right, rcond=None)[0]
        denominator = np.abs(1 + bottom @ coefficients[above + 1 :])
        weight = 1 / np.maximum(size * denominator, 1e-300)
    above_keys = [f"a{i}" for i in range(above + 1)]
    below_keys = [f"d{i}" for i in range(1, below + 1)]
    scaled = dict(zip([*above_keys, *below_keys], coefficients, strict=True))
    values = {key: x / middle ** int(key[1:]) for key, x in scaled.items()}
    return np.array([values.get(x.name, tau) for x in wanted.free])


LEAST_AVERAGES = 4
_TOLD_APART = 1e-7
"""Ratio of the smallest to the largest singular value of the scaled slopes: below it the data do
not identify the parameters separately. Central differences have an error of some 1e-10."""
_SAME_FITTING = 1e-6
"""Sums of squares that differ by no more than this share count as equal."""


@dataclass(frozen=True, eq=False)
class Noise:
    """The noise of the measured points. ``sigma`` : standard deviation of the real and of the
    imaginary part of each, as estimated from its disc. ``freedom`` : degrees of freedom of that
    estimate, infinite where the disc is given; None where no disc is known and sigma is a share of
    ``|H|``."""

    sigma: Reals
    freedom: float | None

    def squares(self, residuals: Complexes) -> Reals:
        """Return for each point a number that has the distribution chi^2 of 2 degrees of freedom
        where the model holds.

        ``|r|^2/2`` has F(2, n), as sigma is estimated; n ln(1 + |r|^2/n) has the same quantile of
        chi^2.
        """
        size = np.square(np.abs(residuals))
        n = self.freedom
        # P(F(2, n) > x) = (1 + 2 x/n)^(-n/2) and P(chi^2 > y) = exp(-y/2): equal for this y.
        found: Reals = size if n is None or np.isinf(n) else n * np.log1p(size / n)
        return found

    @property
    def widening(self) -> float:
        """Factor n/(n - 4) of the variances, as weights that are estimated themselves are worth
        less than known ones."""
        n = self.freedom
        return 1.0 if n is None or np.isinf(n) else n / (n - 4)


def noise_of(m: Measurement) -> Noise:
    """Return the noise that the uncertainty discs of a response stand for. SceneError where they
    cannot be weights."""
    if m.coherence is not None and m.averages is not None:
        if m.averages < LEAST_AVERAGES:
            raise SceneError(
                f"averages: {m.averages:g} are too few: at least {LEAST_AVERAGES} are needed"
            )
        n = 2 * m.averages - 2
        sigma = np.abs(m.H) * np.sqrt((1 - m.coherence) / (n * m.coherence))
    elif m.radius is not None:
        # A Gaussian in the plane lies within r with probability 1 - exp(-r^2/(2 sigma^2)): solved
        # for sigma at the disc's confidence.
        n, sigma = np.inf, m.radius / np.sqrt(-2 * np.log1p(-m.confidence))
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
    return Noise(sigma, n)


def usable(m: Measurement) -> Measurement:
    """Return the frequency points that can be fitted: not that at 0, which has no phase, and
    none whose disc is the whole plane."""
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

    ``lines`` : those that were fitted. ``model`` : the response there; ``residuals`` : measured
    less model, in units of sigma.
    ``covariance`` : of the values, linearised. ``starts`` : from how many; ``agreeing`` : how many
    ended here. ``others`` : other values that give the same response; None where that is not known.
    ``period`` : s, by how much a delay may be longer on evenly spaced lines; None where no start
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
    """The values with which the sum of squares, weighted by the discs, is the least that was found.

    ``begins`` : sets of values to begin with, if not at many that are drawn.
    """
    lines = usable(m)
    free, noise, curve = wanted.free, noise_of(lines), WantedResponse(wanted, lines.omega)
    if 2 * len(lines) <= len(free):
        numbers = counted(len(free), "parameter")
        raise SceneError(
            f"{numbers} need at least {len(free) // 2 + 1} frequency points, not {len(lines)}"
        )
    minima: list[tuple[float, Reals]] = []
    for begin in begins or starts(wanted, lines):
        tick(len(minima), None, "starts")
        if (x := _least(curve, lines, noise, begin)) is not None:
            minima.append(x)
    if not minima:
        raise SceneError(
            "the model has no finite response at these frequencies for any values tried"
        )
    cost, values = min(minima, key=lambda x: x[0])
    # Values that fit as well may be others, as of two lags that change places; a delay may be
    # longer by a whole period. All of them are compared before one is chosen.
    alike = [x for sum_, x in minima if sum_ <= cost * (1 + _SAME_FITTING) + 1e-12]
    cost, values, period = _shortest(curve, lines, noise, (cost, values), alike)
    model = curve.at(values)
    residuals = (lines.H - model) / noise.sigma
    covariance = _covariance(curve, lines, noise, values) * noise.widening
    # No disc is known: the size of the noise is estimated from the residuals. Twice the half sum of
    # squares over the degrees of freedom is its variance.
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
        len(alike),
        period=period,
    )


def with_others(found: Fit) -> Fit:
    """Return a fit with all other values that give the same response, each fitted to the data."""
    # Equal fractions whose denominators begin with 1 have equal coefficients.
    if found.wanted.degrees is not None:
        return replace(found, others=())
    nearly = twins(found.wanted, found.values)
    if nearly is None:
        return found
    curve = WantedResponse(found.wanted, found.lines.omega)
    cost = float(np.square(np.abs(found.residuals)).sum() / 2)
    # The values were rounded to three digits: each is refined, and counts if it then fits as well.
    fitted = filter(None, (_least(curve, found.lines, found.noise, x) for x in nearly))
    others = tuple(x for sum_, x in fitted if sum_ <= cost * (1 + _SAME_FITTING) + 1e-12)
    return found if len(others) < len(nearly) and not others else replace(found, others=others)


def _shortest(
    curve: WantedResponse,
    m: Measurement,
    noise: Noise,
    best: tuple[float, Reals],
    alike: list[Reals],
) -> tuple[float, Reals, float | None]:
    """Return, of values that fit equally well, those with the shortest delays; and the period by
    which others are longer, or None.

    exp(-j omega tau) is the same at all points of spacing d, multiples of d, for a delay that is
    longer by 2 pi/d.
    """
    times = [(i, x) for i, x in enumerate(curve.wanted.free) if x.dimension is Dimension.TIME]
    late = [i for i, x in times if ".delay" in x.path]
    steps = np.diff(m.omega)
    if not late or len(steps) < 1 or np.ptp(steps) > 1e-6 * steps.min():
        return *best, None
    period = 2 * np.pi / float(steps.mean())
    candidates = [best, *((best[0], x) for x in alike)]
    cost, values = min(candidates, key=lambda x: float(x[1][late].sum()))
    # No start may have ended at the shortest delay: whole periods are taken off, and the fit is
    # made again, as points off the multiples would show a difference.
    for i in late:
        shorter = values.copy()
        shorter[i] %= period
        fitted = _least(curve, m, noise, shorter) if shorter[i] < values[i] else None
        if fitted is not None and fitted[0] <= cost * (1 + _SAME_FITTING) + 1e-12:
            cost, values = fitted
    is_longer = any(x[late].sum() > values[late].sum() + period / 2 for x in (best[1], *alike))
    return cost, values, period if is_longer else None


def _least(
    curve: WantedResponse, m: Measurement, noise: Noise, begin: Reals
) -> tuple[float, Reals] | None:
    """Return the least half sum of squares near a start and its values; None where the response
    is not finite there."""
    from scipy.optimize import least_squares  # of the extra simulate

    free = curve.wanted.free
    # The search moves in units of the start: stiffness and mass then count alike in its steps.
    size = np.maximum(np.abs(begin), scales(free, m) * 1e-3)

    def rest(u: Reals) -> Reals:
        return _stacked((curve.at(u * size) - m.H) / noise.sigma)

    def slope(u: Reals) -> Reals:
        return _stacked(_slopes(curve, u * size, size) * (size / noise.sigma[:, None]))

    # The start must lie inside the bounds, not on them.
    low, high = _ends(free, size)
    u = np.clip(begin / size, low + 1e-9, np.where(np.isinf(high), np.inf, high - 1e-9))
    if not np.isfinite(rest(u)).all():
        return None
    ways: dict[str, Any] = {"x_scale": "jac", "max_nfev": 100, "xtol": 1e-12, "ftol": 1e-12}
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        end = least_squares(_finite(rest), u, _finite(slope), (low, high), **ways)
    # The search comes near a bound, never to it: a parameter that fits as well at 0 is 0.
    at_bound = np.where((low == 0) & (end.x < 1e-6), 0.0, end.x)
    cost = float(np.square(_finite(rest)(at_bound)).sum() / 2)
    if cost <= end.cost * (1 + _SAME_FITTING):
        return cost, at_bound * size
    return float(end.cost), end.x * size


def _finite(f: Callable[[Reals], Reals]) -> Callable[[Reals], Reals]:
    """Return a function with large numbers in place of infinite ones: a search turns back there,
    where it would fail at a NaN."""
    return lambda u: np.nan_to_num(f(u), nan=1e9, posinf=1e9, neginf=-1e9)


def _stacked(z: Complexes) -> Reals:
    """Return the real parts, then the imaginary ones: least squares is over real numbers."""
    return np.concatenate([z.real, z.imag])


def _slopes(curve: WantedResponse, values: Reals, size: Reals) -> Complexes:
    """Return central differences with steps of 1e-5: truncation and rounding are both small."""
    return curve.slopes(values, 1e-5 * np.maximum(np.abs(values), 1e-3 * size))


def _ends(free: tuple[Free, ...], size: Reals) -> tuple[Reals, Reals]:
    """Return lower and upper bounds of each parameter, in units of its size."""
    least = {Rule.ANY: -np.inf, Rule.POSITIVE: 1e-9, Rule.FRACTION: 1e-4}
    low = np.array([least.get(x.rule, 0.0) for x in free])
    fraction = np.array([x.rule is Rule.FRACTION for x in free])
    return np.where(fraction, low / size, low), np.where(fraction, (1 - 1e-4) / size, np.inf)


def _covariance(curve: WantedResponse, m: Measurement, noise: Noise, values: Reals) -> Reals:
    """Return the covariance (J^T J)^-1 of the values, J the slopes of the response over sigma;
    SceneError where the data do not identify all parameters."""
    free = curve.wanted.free
    # Steps that are so small that rounding dominates the differences would make dependent columns
    # look independent: they are at least 1e-6 of the parameter's scale.
    size = np.maximum(np.abs(values), 1e2 * scales(free, m))
    J = _stacked(_slopes(curve, values, size) / noise.sigma[:, None])
    # Columns of length 1, so that the ratio of singular values does not depend on units.
    norms = np.linalg.norm(J, axis=0)
    blind = [x.path for x, norm in zip(free, norms, strict=True) if not norm > 0]
    if blind:
        raise SceneError(
            f"The data do not identify {' and '.join(blind)}. Fix it: model:key=value."
        )
    _, singular, directions = np.linalg.svd(J / norms, full_matrices=False)
    if singular[-1] < _TOLD_APART * singular[0]:
        # The direction in which the response does not change: whatever has a share in it.
        mixed = [x.path for x, share in zip(free, directions[-1], strict=True) if abs(share) > 0.1]
        raise SceneError(
            f"The data do not identify {' and '.join(mixed)} separately. Fix one: model:key=value."
        )
    # From the singular values and not from J^T J, whose inverse would lose twice the digits.
    root = directions.T / singular / norms[:, None]
    covariance: Reals = root @ root.T
    return covariance
