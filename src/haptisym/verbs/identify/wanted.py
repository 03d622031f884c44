"""What is to be identified, and whether other values give the very same response.

What is to be identified: models of the catalogue, or fractions of given degrees, with parameters that are free.

Whether other values of a model's parameters give the very same response: a question of algebra, which no line answers.

Two responses are one where numerator and denominator are, but for one factor. With the values that were found (to three digits)
on the one side these are polynomial equations for the parameters, solved by a Groebner basis.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from math import lcm
from operator import mul
from typing import Any, TypeAlias

import numpy as np
from flint import fmpz_mpoly_ctx, fmpz_mpoly_vec, fmpz_poly
from sympy import Symbol

from haptisym.kernel.errors import SceneError, meant
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment, Model
from haptisym.model.distortion import distort
from haptisym.model.measured import Reals
from haptisym.model.parameters import NAMED, Rule, Slot, free_name
from haptisym.model.quantities import Dimension
from haptisym.verbs.identify.scenetext import Table

Degrees: TypeAlias = tuple[int, int]
HIGHEST = 12
"""Degree of a numerator or denominator."""
MOST = 16
"""Free parameters."""


@dataclass(frozen=True)
class Free:
    """A parameter to be found: its path in the scene that is written, and the symbol that it has until then."""

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
    """Tables of a scene file, in which a parameter may be ``Free``. ``degrees`` : where a fraction is wanted.

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
        for x in given.values() if isinstance(given, Mapping) else given if isinstance(given, list | tuple) else ():
            yield from _free(x)


def _built(catalogue: Mapping[str, Model], table: Table) -> Any:
    own = dict(table)
    return catalogue[str(own.pop("model"))].build(**own)


def wanted(
    environment: str | None, effects: Sequence[str], degrees: Degrees | None, known: tuple[Environment, Table] | None
) -> Wanted:
    """What the words of a call ask for. SceneError for models, keys and combinations that there are not.

    ``environment``, ``effects`` : a model each, as ``"shunt"``, ``"shunt:m,b"`` (with these parameters alone of those that may be
    absent) or ``"second-order-lowpass:zeta=0.5"`` (with a given value). ``degrees`` : of a numerator and a denominator, in place
    of a model of the environment; of a series effect where the environment is ``known``.

    >>> [x.path for x in wanted("mass-spring-damper:k,b", ["delay"], None, None).free]
    ['environment.k', 'environment.b', 'effects.delay.tau']
    """
    names = _Symbols()
    if known is not None:
        if environment is not None:
            raise SceneError(
                "environment: what should be felt is given by the scene: leave it out, or give the file itself"
            )
        own: Table = known[1]
    elif degrees is not None:
        if environment is not None:
            raise SceneError(f"degrees: a fraction stands in place of a model: leave out {environment} or the degrees")
        own = _fraction(degrees, "environment", names)
    elif environment is None:
        models = ", ".join(x for x in ENVIRONMENTS if x != "expression")
        raise SceneError(f"environment: say which model is wanted, or give degrees: models are {models}")
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
            "nothing is free: what should be felt is given; say what stands behind it, as --effect delay or --degrees 1 2; "
            f"effects are {', '.join(EFFECTS)}"
        )
    if not found.free:
        raise SceneError("nothing is free: every parameter is given a value; leave one of them out")
    if len(found.free) > MOST:
        raise SceneError(f"{len(found.free)} parameters are free: at most {MOST} can be found")
    own = [x for x in found.effects if x["model"] != "series"]
    if found.degrees and any(x["model"] != "delay" for x in own):
        raise SceneError("degrees: a fraction goes with a delay alone: leave out the other effects")


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
    if not all(isinstance(x, int) and not isinstance(x, bool) and 0 <= x <= HIGHEST for x in degrees):
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
            f'{kind}: unknown model "{name[:60]}": {meant(name, catalogue)}valid are {", ".join(catalogue)}'
        )
    slots = catalogue[name].slots
    formulas = [key for key, x in slots.items() if x.formula and x.required]
    if formulas:
        raise SceneError(
            f"{name}: a formula has no parameters to be found by themselves: choose another model, or degrees"
        )
    try:
        keys = _keys(listed, slots) if colon else dict.fromkeys(_usual(slots))
        found = {key: _entry(f"{place}.{key}", slots[key], given, names) for key, given in keys.items()}
    except SceneError as error:
        raise error.within(name) from None
    return {"model": name, **found}


def _usual(slots: Mapping[str, Slot]) -> list[str]:
    """The parameters of a model of which nothing is said: all, but settings that may be absent."""
    return [key for key, x in slots.items() if not x.formula and (x.required or not x.is_setting)]


def _keys(listed: str, slots: Mapping[str, Slot]) -> dict[str, str | None]:
    """The parameters that a model has: those that are listed, each with its value if it has one, and the required ones."""
    given: dict[str, str | None] = {}
    for word in listed.split(","):
        key, equals, value = (x.strip() for x in word.partition("="))
        valid = [x for x, slot in slots.items() if not slot.formula]
        if key not in valid:
            raise SceneError(f'unknown parameter "{key[:60]}": {meant(key, valid)}valid are {", ".join(valid)}')
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
            raise SceneError(f"{key}: say how many, as in {key}=2")
        return [names.free(f"{path}[{i}]", slot) for i in range(1, count + 1)]
    if slot.is_setting:
        if given is None:
            raise SceneError(f"{key}: is no number to be found: give it, as in {key}={_example(slot)}")
        return int(given) if given.isdigit() else given
    return names.free(path, slot) if given is None else given


def _example(slot: Slot) -> str:
    return slot.choices[0] if slot.choices else "1"


_LIMITS = 60, 400, 20_000  # polynomials of a basis, terms of one, bits of a coefficient
_SAME = 1e-4  # relative: values and roots that differ by less are one, as the values have three digits


def twins(wanted: Wanted, values: Reals) -> tuple[Reals, ...] | None:
    """Other positive values that give the response of these, nearly; None where that was not decided.

    What stands in a delay or a power of s is left as it is.

    >>> from haptisym.verbs.identify.wanted import wanted
    >>> asked = wanted("maxwell", ["first-order-lag"], None, None)
    >>> [x.round(6).tolist() for x in twins(asked, np.array([300.0, 6.0, 12.0]))]
    [[72.0, 6.0, 50.0]]
    """
    own, effects = wanted.elements(lambda x: x.symbol)
    perceived = distort(own, *effects).perc.reduced()
    ring, parts = perceived.ring, (perceived.numerator, perceived.denominator)
    inside = {x for meaning in ring.meanings[ring.size :] for x in meaning.free_symbols}
    near = {x.symbol: Fraction(f"{value:.3g}") for x, value in zip(wanted.free, values.tolist(), strict=True)}
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
            total, known = _equation(context.constant(0), terms, near, dict(zip(free, unknown, strict=True)))
            equations.append(total * known.denominator - factor * known.numerator)
    basis, whole = fmpz_mpoly_vec(equations, context).buchberger_naive(limits=_LIMITS)
    if not whole:
        return None
    found = _solved([*basis.autoreduction()], len(unknown))
    if found is None:
        return None
    given = np.array([float(near[x]) for x in free])
    others = [x for x in found if not np.allclose(x, given, rtol=_SAME)]
    return tuple(np.array([x[free.index(y)] if y in free else values[i] for i, y in enumerate(near)]) for x in others)


def _equation(total: Any, terms: Any, near: Any, unknown: Any) -> tuple[Any, Fraction]:
    """A coefficient as a polynomial in what is unknown, times a whole number, and its value at the values that were found."""
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
    """The positive solutions of a basis in lexical order, from the last unknown on; None where there is no end of them."""
    found: list[list[float]] = [[]]
    for k in range(count):
        at = 2 + count - 1 - k  # its place in the context
        own = [p for p in basis if p.degrees()[at] and not any(p.degrees()[:at])]
        if not any(all(not n for i, n in enumerate(_leading(p)) if i != at) for p in own):
            return None
        found = [[x, *rest] for rest in found for x in _roots(own, at, rest)]
    return [np.array(x) for x in found]


def _leading(p: Any) -> tuple[int, ...]:
    powers: tuple[int, ...] = tuple(p.monomial(0))
    return powers


def _roots(own: Sequence[Any], at: int, rest: Sequence[float]) -> Iterator[float]:
    """The positive numbers at which polynomials in one unknown, the later ones being known, vanish together."""
    rows = []
    for p in own:
        row = [Fraction(0)] * (p.degrees()[at] + 1)
        for powers, c in p.to_dict().items():
            later = zip(powers[at + 1 :], rest, strict=True)
            row[int(powers[at])] += int(c) * Fraction(float(np.prod([x ** int(n) for n, x in later])))
        rows.append(row)
    row = min((x for x in rows if any(x[1:])), key=len, default=[Fraction(1)])
    scale = lcm(*(x.denominator for x in row))
    for root, _ in fmpz_poly([int(x * scale) for x in row]).complex_roots():
        x, y = float(root.real.mid()), float(root.imag.mid())
        if x > 0 and abs(y) < _SAME * x:
            yield x
