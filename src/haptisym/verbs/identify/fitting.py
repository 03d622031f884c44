"""Models with free numbers, where a fit begins, and weighted least squares.

What is to be identified are models of the catalogue, or fractions of given degrees, with parameters
that are free. A fit begins at values drawn from units and the lines' own scales, a fraction at
linear least squares, each time weighted with the denominator before; it ends where a model lies
nearest to the lines, weighted by their discs.

Whether other values of a model's parameters give the very same response is a question of algebra,
which no line answers. Two responses are one where numerator and denominator are, but for one
factor. With the values that were found (to three digits) on the one side these are polynomial
equations for the parameters, solved by a Groebner basis.
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
"""Degree of a numerator or denominator."""
MOST = 16
"""Free parameters."""


@dataclass(frozen=True)
class Free:
    """A parameter to be found: its path in the scene that is written, and the symbol that it has
    until then."""

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
        """``mass-spring-damper, delay``."""
        return ", ".join(str(x.get("name", x["model"])) for x in (self.environment, *self.effects))

    def elements(self, value: Callable[[Free], Any]) -> tuple[Environment, tuple[Effect, ...]]:
        """Environment and effects with these values for what is free."""
        own = self.known or _built(ENVIRONMENTS, filled(self.environment, value))
        return own, tuple(_built(EFFECTS, filled(x, value)) for x in self.effects)


def filled(given: Any, value: Callable[[Free], Any]) -> Any:
    """A table with values in the places of what is free."""
    if isinstance(given, Free):
        return value(given)
    if isinstance(given, Mapping):
        return {key: filled(x, value) for key, x in given.items()}
    return [filled(x, value) for x in given] if isinstance(given, list) else given


def _free(given: Any) -> Iterator[Free]:
    if isinstance(given, Free):
        yield given
    elif not isinstance(given, str):
        for x in (
            given.values()
            if isinstance(given, Mapping)
            else given
            if isinstance(given, list | tuple)
            else ()
        ):
            yield from _free(x)


def _built(catalogue: Mapping[str, Model], table: Table) -> Any:
    own = dict(table)
    return catalogue[str(own.pop("model"))].build(**own)


def wanted(
    environment: str | None,
    effects: Sequence[str],
    degrees: Degrees | None,
    known: tuple[Environment, Table] | None,
) -> Wanted:
    """What the words of a call ask for. SceneError for models, keys and combinations that there are
    not.

    ``environment``, ``effects`` : a model each, as ``"shunt"``, ``"shunt:m,b"`` (with these
    parameters alone of those that may be absent) or ``"second-order-lowpass:zeta=0.5"`` (with a
    given value). ``degrees`` : of a numerator and a denominator, in place of a model of the
    environment; of a series effect where the environment is ``known``.

    >>> [x.path for x in wanted("mass-spring-damper:k,b", ["delay"], None, None).free]
    ['environment.k', 'environment.b', 'effects.delay.tau']
    """
    names = _Symbols()
    if known is not None:
        if environment is not None:
            raise SceneError(
                "environment: the scene gives it: leave it out, or give the file of the "
                "response instead of the scene"
            )
        own: Table = known[1]
    elif degrees is not None:
        if environment is not None:
            raise SceneError(
                f"degrees: a fraction replaces the model: leave out {environment} or the degrees"
            )
        own = _fraction(degrees, "environment", names)
    elif environment is None:
        models = ", ".join(x for x in ENVIRONMENTS if x != "expression")
        raise SceneError(f"environment: name a model to fit, or give degrees; models are {models}")
    else:
        own = _model(environment, ENVIRONMENTS, "environment", names)
    rows = [_fraction(degrees, "effects.fraction", names)] if degrees and known else []
    taken = {"fraction"}
    for text in effects:
        model = text.partition(":")[0].strip()
        name = free_name(model, taken, "-")
        taken.add(name)
        row = _model(text, EFFECTS, f"effects.{name}", names)
        rows.append(row if name == model else {"name": name, **row})
    found = Wanted(own, tuple(rows), degrees, known[0] if known else None)
    _check(found)
    return found


def _check(found: Wanted) -> None:
    if not found.free and found.known and not found.effects:
        raise SceneError(
            "no parameter is free: name the effects to fit, as --effect delay, or --degrees 1 2; "
            f"effects are {', '.join(EFFECTS)}"
        )
    if not found.free:
        raise SceneError("no parameter is free: leave out the value of at least one")
    if len(found.free) > MOST:
        raise SceneError(f"{len(found.free)} parameters are free: at most {MOST} can be fitted")
    own = [x for x in found.effects if x["model"] != "series"]
    if found.degrees and any(x["model"] != "delay" for x in own):
        raise SceneError(
            "degrees: a fraction is fitted with a delay only: leave out the other effects"
        )


class _Symbols:
    """Symbols by number."""

    def __init__(self) -> None:
        self.count = 0

    def free(self, path: str, slot: Slot) -> Free:
        self.count += 1
        signs = {"real": True} if slot.rule is Rule.ANY else {"positive": True}
        return Free(path, Symbol(f"free{self.count}", **signs), slot.dimension, slot.rule)


def _fraction(degrees: Degrees, place: str, names: _Symbols) -> Table:
    """A fraction whose denominator begins with 1."""
    above, below = degrees
    if not all(
        isinstance(x, int) and not isinstance(x, bool) and 0 <= x <= HIGHEST for x in degrees
    ):
        raise SceneError(f"degrees: {above} and {below} must be whole numbers from 0 to {HIGHEST}")
    keys = [f"a{i}" for i in range(above + 1)], [f"d{i}" for i in range(1, below + 1)]
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
        keys = (
            _keys(listed, slots)
            if colon
            else {
                key: None
                for key, x in slots.items()
                if not x.formula and (x.required or not x.is_setting)
            }
        )
        found = {
            key: _entry(f"{place}.{key}", slots[key], given, names) for key, given in keys.items()
        }
    return {"model": name, **found}


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
_SAME = (
    1e-4  # relative: values and roots that differ by less are one, as the values have three digits
)


def twins(wanted: Wanted, values: Reals) -> tuple[Reals, ...] | None:
    """Other positive values that give the response of these, nearly; None where that was not
    decided.

    What stands in a delay or a power of s is left as it is.

    >>> from haptisym.verbs.identify.fitting import wanted
    >>> asked = wanted("maxwell", ["first-order-lag"], None, None)
    >>> [x.round(6).tolist() for x in twins(asked, np.array([300.0, 6.0, 12.0]))]
    [[72.0, 6.0, 50.0]]
    """
    own, effects = wanted.elements(lambda x: x.symbol)
    perceived = distort(own, *effects).perc.reduced()
    ring, parts = perceived.ring, (perceived.numerator, perceived.denominator)
    inside = {x for meaning in ring.meanings[ring.size :] for x in meaning.free_symbols}
    near = {
        x.symbol: Fraction(f"{value:.3g}")
        for x, value in zip(wanted.free, values.tolist(), strict=True)
    }
    free = [x for x in near if x not in inside]
    if not free or any(near[x] <= 0 for x in free):
        return None
    places = [ring.meanings.index(x) for x in near]
    context = fmpz_mpoly_ctx.get(["t", "factor", *map(str, free)], "lex")
    _, factor, *unknown = context.gens()
    equations = [reduce(mul, unknown, context.gens()[0] * factor) - 1]  # none of them is 0
    for part in parts:
        rows: dict[tuple[int, ...], dict[tuple[int, ...], Fraction]] = {}
        for powers, coefficient in part.to_dict().items():
            beside = tuple(0 if i in places else n for i, n in enumerate(powers))
            rows.setdefault(beside, {})[tuple(powers[i] for i in places)] = Fraction(
                int(coefficient.p), int(coefficient.q)
            )
        for terms in rows.values():
            total, known = _equation(
                context.constant(0), terms, near, dict(zip(free, unknown, strict=True))
            )
            equations.append(total * known.denominator - factor * known.numerator)
    basis, whole = fmpz_mpoly_vec(equations, context).buchberger_naive(limits=_LIMITS)
    if not whole:
        return None
    found = _solved([*basis.autoreduction()], len(unknown))
    if found is None:
        return None
    given = np.array([float(near[x]) for x in free])
    others = [x for x in found if not np.allclose(x, given, rtol=_SAME)]
    return tuple(
        np.array([x[free.index(y)] if y in free else values[i] for i, y in enumerate(near)])
        for x in others
    )


def _equation(total: Any, terms: Any, near: Any, unknown: Any) -> tuple[Any, Fraction]:
    """A coefficient as a polynomial in what is unknown, times a whole number, and its value at the
    values that were found."""
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
    """The positive solutions of a basis in lexical order, from the last unknown on; None where
    there is no end of them."""
    found: list[list[float]] = [[]]
    for k in range(count):
        at = 2 + count - 1 - k  # its place in the context
        own = [p for p in basis if p.degrees()[at] and not any(p.degrees()[:at])]
        if not any(all(not n for i, n in enumerate(p.monomial(0)) if i != at) for p in own):
            return None
        found = [[x, *rest] for rest in found for x in _roots(own, at, rest)]
    return [np.array(x) for x in found]


def _roots(own: Sequence[Any], at: int, rest: Sequence[float]) -> Iterator[float]:
    """The positive numbers at which polynomials in one unknown, the later ones being known, vanish
    together."""
    rows = []
    for p in own:
        row = [Fraction(0)] * (p.degrees()[at] + 1)
        for powers, c in p.to_dict().items():
            later = zip(powers[at + 1 :], rest, strict=True)
            row[int(powers[at])] += int(c) * Fraction(
                float(np.prod([x ** int(n) for n, x in later]))
            )
        rows.append(row)
    row = min((x for x in rows if any(x[1:])), key=len, default=[Fraction(1)])
    scale = lcm(*(x.denominator for x in row))
    for root, _ in fmpz_poly([int(x * scale) for x in row]).complex_roots():
        x, y = float(root.real.mid()), float(root.imag.mid())
        if x > 0 and abs(y) < _SAME * x:
            yield x


@dataclass(frozen=True, eq=False)
class WantedResponse:
    """H_perc of what is wanted at frequencies, rad/s."""

    wanted: Wanted
    omega: Reals

    @cached_property
    def _compiled(self) -> Callable[..., Any]:
        own, effects = self.wanted.elements(lambda x: x.symbol)
        return distort(own, *effects).compile(of=["perceived_real", "perceived_imag"])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the free parameters, in their order."""
        return tuple(x.symbol.name for x in self.wanted.free)

    def __call__(self, values: Reals) -> Complexes:
        """Of sets of values (sets, parameters) the responses (sets, lines); NaN where there is
        none."""
        sets = np.atleast_2d(values)
        columns = {name: sets[:, i, None] for i, name in enumerate(self.names)}
        with np.errstate(all="ignore"):
            found = self._compiled(self.omega[None, :], **columns)
            H: Complexes = found.perceived_real + 1j * found.perceived_imag
        return np.broadcast_to(H, (len(sets), len(self.omega)))

    def at(self, values: Reals) -> Complexes:
        """Of one set of values."""
        found: Complexes = self(values)[0]
        return found

    def slopes(self, values: Reals, steps: Reals) -> Complexes:
        """Central differences, (lines, parameters)."""
        shifts = np.diag(steps)
        H = self(np.concatenate([values + shifts, values - shifts]))
        count = len(steps)
        found: Complexes = ((H[:count] - H[count:]) / (2 * steps[:, None])).T
        return found


_MOST_LINES = 200
"""Looked at for a start."""
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
"""Of a parameter around its scale."""


def scales(free: tuple[Free, ...], m: Measurement) -> Reals:
    """How large each parameter is likely to be: the middle of the lines in its unit."""
    size, omega = (
        float(np.median(np.abs(m.H))) or 1.0,
        float(np.exp(np.log(m.omega[m.omega > 0]).mean())),
    )
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
    """Values to begin with."""
    few = m.at(np.unique(np.linspace(0, len(m) - 1, min(len(m), _MOST_LINES)).astype(int)))
    if wanted.degrees is not None:
        yield from _fractions(wanted, few)
    else:
        yield from _drawn(wanted, few)


# Models: sets of values drawn evenly on logarithmic scales, the best of them refined on the
# logarithm of the response.


def _drawn(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    free, curve, scale = wanted.free, WantedResponse(wanted, m.omega), scales(wanted.free, m)
    count = _DRAWN * (len(free) + 1)
    points = np.random.default_rng(2019).random((count, len(free)))
    sets = np.stack(
        [_spread(x, c, u) for x, c, u in zip(free, scale, points.T, strict=True)], axis=1
    )
    misfit = np.nan_to_num(np.square(_logarithm(curve(sets), m.H)).sum(axis=1), nan=np.inf)
    for i in np.argsort(misfit)[:_REFINED]:
        if np.isfinite(misfit[i]):
            yield _refined(curve, m.H, sets[i], scale)


def _spread(x: Free, scale: float, share: Reals) -> Reals:
    if x.rule is Rule.FRACTION:
        return 0.02 + 0.96 * share
    low, high = _DECADES.get(x.dimension, (-2.0, 2.0))
    if x.rule is not Rule.ANY:
        found: Reals = scale * 10 ** (low + (high - low) * share)
        return found
    return scale * np.sign(share - 0.5) * 10 ** (low + (high - low) * np.abs(2 * share - 1))


def _logarithm(H: Complexes, measured: Complexes) -> Reals:
    """Logarithm of magnitude, and phase, of the quotient."""
    with np.errstate(all="ignore"):
        quotient = np.log(H / measured)
    found: Reals = np.concatenate([quotient.real, quotient.imag], axis=-1)
    return found


def _refined(curve: WantedResponse, measured: Complexes, begin: Reals, scale: Reals) -> Reals:
    from scipy.optimize import least_squares  # of the extra simulate

    signed = np.array([x.rule in (Rule.ANY, Rule.FRACTION) for x in curve.wanted.free])
    fraction = np.array([x.rule is Rule.FRACTION for x in curve.wanted.free])

    def values(u: Reals) -> Reals:
        return np.where(signed, u * scale, np.exp(np.clip(u, -300, 300)))

    def rest(u: Reals) -> Reals:
        return np.nan_to_num(
            _logarithm(curve.at(values(u)), measured), nan=1e3, posinf=1e3, neginf=-1e3
        )

    def slope(u: Reals) -> Reals:
        at = values(u)
        with np.errstate(all="ignore"):
            steps = 1e-5 * np.maximum(np.abs(at), 1e-3 * scale)
            relative = curve.slopes(at, steps) / curve.at(at)[:, None] * np.where(signed, scale, at)
        told: Reals = np.nan_to_num(
            np.concatenate([relative.real, relative.imag]), nan=0.0, posinf=1e6, neginf=-1e6
        )
        return told

    with np.errstate(all="ignore"):
        u = np.where(signed, begin / scale, np.log(np.abs(begin)))
    ends = np.where(fraction, 1e-3, -np.inf), np.where(fraction, 1 - 1e-3, np.inf)
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        found = least_squares(rest, u, slope, ends, max_nfev=40, x_scale=np.where(signed, 1.0, 0.5))
    refined: Reals = values(found.x)
    return refined


# Fractions: numerator and denominator by linear least squares, each time weighted with the
# denominator before.


def _fractions(wanted: Wanted, m: Measurement) -> Iterator[Reals]:
    assert wanted.degrees is not None
    ratio = m.H / _known(wanted, m.omega)
    is_delayed = any(x["model"] == "delay" for x in wanted.effects) and any(
        x.name == "tau" for x in wanted.free
    )
    top = float(m.omega[-1])
    for tau in [0.0, *np.geomspace(0.02, 6, 16) / top] if is_delayed else [0.0]:
        yield _linear(wanted, m.omega, ratio * np.exp(1j * m.omega * tau), tau)


def _known(wanted: Wanted, omega: Reals) -> Complexes:
    """What the fraction is multiplied by."""
    if wanted.known is None:
        return np.ones(len(omega), dtype=complex)
    found = distort(wanted.known).compile(of=["environment_real", "environment_imag"])(omega)
    H: Complexes = found.environment_real + 1j * found.environment_imag
    return H


def _linear(wanted: Wanted, omega: Reals, ratio: Complexes, tau: float) -> Reals:
    assert wanted.degrees is not None
    above, below = wanted.degrees
    middle = float(np.exp(np.log(omega[omega > 0]).mean()))
    powers = (1j * omega[:, None] / middle) ** np.arange(max(above, below) + 1)
    weight, found = 1 / np.maximum(np.abs(ratio), 1e-300), np.zeros(above + below + 1)
    for _ in range(20):
        A = (
            np.hstack([powers[:, : above + 1], -ratio[:, None] * powers[:, 1 : below + 1]])
            * weight[:, None]
        )
        b = ratio * weight
        found = np.linalg.lstsq(
            np.vstack([A.real, A.imag]), np.concatenate([b.real, b.imag]), rcond=None
        )[0]
        bottom = np.abs(1 + powers[:, 1 : below + 1] @ found[above + 1 :])
        weight = 1 / np.maximum(np.abs(ratio) * bottom, 1e-300)
    values = dict(
        zip(
            [*(f"a{i}" for i in range(above + 1)), *(f"d{i}" for i in range(1, below + 1))],
            found,
            strict=True,
        )
    )
    own = {key: x / middle ** int(key[1:]) for key, x in values.items()}
    return np.array([own.get(x.name, tau) for x in wanted.free])


LEAST_AVERAGES = 4
_TOLD_APART = 1e-7
"""Of the directions in which parameters move, the least told against the best told: below it they
cannot be told apart."""
_SAME_FITTING = 1e-6
"""Sums of squares that differ by no more than this share are one."""


@dataclass(frozen=True, eq=False)
class Noise:
    """``sigma`` : of the real and of the imaginary part of each line, as estimated from its disc.
    ``freedom`` : degrees of freedom of that estimate, infinite where the disc is given; None where
    no disc is known and sigma is a share of ``|H|``."""

    sigma: Reals
    freedom: float | None

    def squares(self, residuals: Complexes) -> Reals:
        """Of each line a number that has the distribution chi^2 of 2 degrees of freedom where the
        model holds.

        ``|r|^2/2`` has F(2, n); n ln(1 + |r|^2/n) is its quantile, carried over.
        """
        size = np.square(np.abs(residuals))
        n = self.freedom
        found: Reals = size if n is None or np.isinf(n) else n * np.log1p(size / n)
        return found

    @property
    def widening(self) -> float:
        """Of variances: weights that are estimated themselves tell less than known ones, by n/(n -
        4)."""
        n = self.freedom
        return 1.0 if n is None or np.isinf(n) else n / (n - 4)


def noise_of(m: Measurement) -> Noise:
    """The noise that the discs of a response speak of. SceneError where they cannot be weights."""
    if m.coherence is not None and m.averages is not None:
        if m.averages < LEAST_AVERAGES:
            raise SceneError(
                f"averages: {m.averages:g} are too few: at least {LEAST_AVERAGES} are needed"
            )
        n = 2 * m.averages - 2
        sigma = np.abs(m.H) * np.sqrt((1 - m.coherence) / (n * m.coherence))
    elif m.radius is not None:
        n, sigma = np.inf, m.radius / np.sqrt(-2 * np.log1p(-m.confidence))
    else:
        size = np.abs(m.H)
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
    """The lines that can be fitted: not that at frequency 0, which has no phase, and none whose
    disc is the whole plane."""
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
    """What least squares found.

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
        """Numbers that were measured, less those that were found."""
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
    found: list[tuple[float, Reals]] = []
    for begin in begins or starts(wanted, lines):
        tick(len(found), None, "starts")
        if (x := _least(curve, lines, noise, begin)) is not None:
            found.append(x)
    if not found:
        raise SceneError(
            "the model has no finite response at these frequencies for any values tried"
        )
    cost, values = min(found, key=lambda x: x[0])
    alike = [x for sum_, x in found if sum_ <= cost * (1 + _SAME_FITTING) + 1e-12]
    cost, values, period = _shortest(curve, lines, noise, (cost, values), alike)
    model = curve.at(values)
    residuals = (lines.H - model) / noise.sigma
    covariance = _covariance(curve, lines, noise, values) * noise.widening
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
        len(found),
        len(alike),
        period=period,
    )


def with_others(found: Fit) -> Fit:
    """The same, with all other values that give the same response, each fitted to the lines."""

    if found.wanted.degrees is not None:
        return replace(found, others=())  # a fraction has its coefficients
    nearly = twins(found.wanted, found.values)
    if nearly is None:
        return found
    curve = WantedResponse(found.wanted, found.lines.omega)
    cost = float(np.square(np.abs(found.residuals)).sum() / 2)
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
    """Of values that fit alike those with the shortest delays; and by how much others are longer.

    A delay that is longer by 2 pi over the spacing of lines at multiples of it is the same to all
    of them.
    """
    late = [
        i
        for i, x in enumerate(curve.wanted.free)
        if x.dimension is Dimension.TIME and ".delay" in x.path
    ]
    steps = np.diff(m.omega)
    if not late or len(steps) < 1 or np.ptp(steps) > 1e-6 * steps.min():
        return *best, None
    period = 2 * np.pi / float(steps.mean())
    cost, values = min(
        [best, *((best[0], x) for x in alike)], key=lambda x: float(x[1][late].sum())
    )
    for i in late:
        shorter = values.copy()
        shorter[i] %= period
        found = _least(curve, m, noise, shorter) if shorter[i] < values[i] else None
        if found is not None and found[0] <= cost * (1 + _SAME_FITTING) + 1e-12:
            cost, values = found
    is_longer = any(x[late].sum() > values[late].sum() + period / 2 for x in (best[1], *alike))
    return cost, values, period if is_longer else None


def _least(
    curve: WantedResponse, m: Measurement, noise: Noise, begin: Reals
) -> tuple[float, Reals] | None:
    """The least half sum of squares near a start, and its values."""
    from scipy.optimize import least_squares  # of the extra simulate

    free = curve.wanted.free
    size = np.maximum(np.abs(begin), scales(free, m) * 1e-3)

    def rest(u: Reals) -> Reals:
        return _stacked((curve.at(u * size) - m.H) / noise.sigma)

    def slope(u: Reals) -> Reals:
        return _stacked(_slopes(curve, u * size, size) * (size / noise.sigma[:, None]))

    low, high = _ends(free, size)
    u = np.clip(begin / size, low + 1e-9, np.where(np.isinf(high), np.inf, high - 1e-9))
    if not np.isfinite(rest(u)).all():
        return None
    ways: dict[str, Any] = {"x_scale": "jac", "max_nfev": 100, "xtol": 1e-12, "ftol": 1e-12}
    with np.errstate(all="ignore"):  # a step of no length divides by zero in there
        found = least_squares(_finite(rest), u, _finite(slope), (low, high), **ways)
    at_end = np.where(
        low == 0, np.where(found.x < 1e-6, 0.0, found.x), found.x
    )  # the search comes near an end, never to it
    cost = float(np.square(_finite(rest)(at_end)).sum() / 2)
    if cost <= found.cost * (1 + _SAME_FITTING):
        return cost, at_end * size
    return float(found.cost), found.x * size


def _finite(f: Callable[[Reals], Reals]) -> Callable[[Reals], Reals]:
    return lambda u: np.nan_to_num(f(u), nan=1e9, posinf=1e9, neginf=-1e9)


def _stacked(z: Complexes) -> Reals:
    return np.concatenate([z.real, z.imag])


def _slopes(curve: WantedResponse, values: Reals, size: Reals) -> Complexes:
    return curve.slopes(values, 1e-5 * np.maximum(np.abs(values), 1e-3 * size))


def _ends(free: tuple[Free, ...], size: Reals) -> tuple[Reals, Reals]:
    """Between which numbers each parameter may lie, in its own size."""
    least = {Rule.ANY: -np.inf, Rule.POSITIVE: 1e-9, Rule.FRACTION: 1e-4}
    low = np.array([least.get(x.rule, 0.0) for x in free])
    fraction = np.array([x.rule is Rule.FRACTION for x in free])
    return np.where(fraction, low / size, low), np.where(fraction, (1 - 1e-4) / size, np.inf)


def _covariance(curve: WantedResponse, m: Measurement, noise: Noise, values: Reals) -> Reals:
    """Of the values, by the slopes of the response; SceneError where the lines do not tell
    parameters apart."""
    free = curve.wanted.free
    size = np.maximum(
        np.abs(values), 1e2 * scales(free, m)
    )  # steps so small as rounding hides would tell apart what is one
    J = _stacked(_slopes(curve, values, size) / noise.sigma[:, None])
    norms = np.linalg.norm(J, axis=0)
    blind = [x.path for x, norm in zip(free, norms, strict=True) if not norm > 0]
    if blind:
        raise SceneError(
            f"The data do not identify {' and '.join(blind)}. Fix it: model:key=value."
        )
    _, singular, directions = np.linalg.svd(J / norms, full_matrices=False)
    if singular[-1] < _TOLD_APART * singular[0]:
        mixed = [x.path for x, share in zip(free, directions[-1], strict=True) if abs(share) > 0.1]
        raise SceneError(
            f"The data do not identify {' and '.join(mixed)} separately. Fix one: model:key=value."
        )
    root = directions.T / singular / norms[:, None]
    found: Reals = root @ root.T
    return found
