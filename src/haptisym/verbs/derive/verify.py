"""Symbolic against numeric: several ways to one value compared at random frequencies and
parameters.

The reference is the chain itself in complex arithmetic of 60 digits (mpmath): H_perc(j omega) built
effect by effect, then the parts. Compared with it are the closed form and the named steps (60
digits), ball arithmetic on lowest terms, and what ``compile`` makes in floats. The differences are
in units in the last place of a double.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isfinite, isnan, log10, ulp
from pathlib import Path
from random import Random
from typing import Any

import mpmath
from flint import fmpq
from sympy import Abs, Integer, Rational, Symbol, lambdify

from haptisym.kernel.budget import SECONDS, limited, tick
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.harmonics import computable, staircase
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import whole
from haptisym.kernel.rings import s
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.balls import PointValue
from haptisym.programs.steps import DISTORTION

# Of 60 digits ten are left for cancellation between H_perc and H_env: what is smaller than 1e-50 of
# the modulus is rounding.
_DIGITS, _NOISE = 60, 1e-50
_MODULES = [{"staircase": staircase}, "mpmath"]
_TRIES = 1000  # to draw a number that a symbol may be
# Products of small doubles underflow below it and lose digits: such a value has no last place.
_SMALLEST = 1e-250
WAYS = ("closed form", "named steps", "ball arithmetic", "compiled")


@dataclass(frozen=True)
class Disagreement:
    """The largest difference of a way from the reference, in units in the last place of the value.
    ``omega``, ``values`` : the frequency, rad/s, and the parameters at which it was found."""

    quantity: str
    way: str
    ulp: float
    omega: float
    values: Mapping[str, float]


@dataclass(frozen=True, repr=False)
class Verification(Shown):
    """The differences of each way to each quantity from complex arithmetic of 60 digits, at random
    points. Made by ``verify``.

    ``worst`` : for each way the largest difference, in units in the last place of a double;
    ``rows`` : for each way and quantity, with the frequency, rad/s, and the values there.
    ``points`` : how many; ``undefined`` : at how many others there is no value.
    Computed: it finds a wrong formula, and proves none right.
    """

    points: int
    undefined: int
    rows: tuple[Disagreement, ...]

    def _line(self) -> str:
        found = self.worst
        return f"{self.points} points: " + ", ".join(
            f"{way} within {found[way]:.3g} ulp" for way in WAYS
        )

    @property
    def worst(self) -> dict[str, float]:
        """The largest difference of each way, ulp, of all quantities."""
        return {way: max((x.ulp for x in self.rows if x.way == way), default=0.0) for way in WAYS}

    def __str__(self) -> str:
        names = "".join(f"{way:>17}" for way in WAYS)
        lines = [f"{'ulp of a double, at most':<26}{names}"]
        for name in dict.fromkeys(x.quantity for x in self.rows):
            errors = {x.way: x.ulp for x in self.rows if x.quantity == name}
            columns = "".join(f"{errors[way]:>17.2g}" for way in WAYS)
            lines.append(f"{name:<26}{columns}")
        lines.append(f"at {self.points} points; at {self.undefined} others there is no value")
        return "\n".join(lines)


def verify(
    given: Distortion | Scene | str | Path,
    points: int = 100,
    *,
    seed: int = 0,
    limit: float | None = SECONDS,
) -> Verification:
    """Re dH, Im dH, the ratios and Re and Im(dH/H_env) by four ways, at random points against
    complex arithmetic of 60 digits.

    ``given`` : a distortion, whose symbols get random values from 0.1 to 10 in size (orders from
    0.1 to 0.9), each of the kind that the symbol is declared to be, or a scene with its numbers.
    Frequencies are drawn from a hundredth to a hundred rad/s, evenly in their logarithm. ``limit``
    : seconds.

    >>> from haptisym import distort, effects, environments, symbols
    >>> found = verify(distort(environments.mass_spring_damper(*symbols("m b k")), effects.first_order_lag(symbols("w"))), 20)
    >>> found.worst["closed form"] < 1e-9, found.worst["ball arithmetic"] <= 0.5, found.worst["compiled"] < 100
    (True, True, True)
    """
    d = given if isinstance(given, Distortion) else as_scene(given).distortion()
    d = replace(d, value=None)
    draw, ways = Random(seed), _Ways(d)
    worst: dict[tuple[str, str], Disagreement] = {}
    defined, count = 0, whole("points", points)
    with limited(limit), mpmath.workdps(_DIGITS):
        for n in range(count):
            tick(n, count, "points")
            omega, values = _frequency(draw), ways.draw(draw)
            rows = ways.at(omega, values)
            defined += rows is not None
            for name, way, error in _errors(rows or {}):
                if (name, way) not in worst or error > worst[name, way].ulp:
                    by_name = {x.name: float(v) for x, v in values.items()}
                    worst[name, way] = Disagreement(name, way, error, float(omega), by_name)
    return Verification(
        defined,
        count - defined,
        tuple(worst[name, way] for name in DISTORTION for way in WAYS if worst),
    )


def _frequency(draw: Random) -> Rational:
    """A double, so that all ways have the same one."""
    return Rational(10 ** draw.uniform(-2, 2))


def _drawn(draw: Random, x: Symbol, most: float) -> Rational:
    """A random double up to that size, or whole number, that is what the symbol is declared to be;
    positive if nothing is."""
    for _ in range(_TRIES):
        size = 10 ** draw.uniform(-1, log10(most))
        sign = draw.choice((-1, 1)) if x.is_real and not x.is_positive else 1
        value = sign * (Integer(round(size)) if x.is_integer else Rational(size))
        if all(getattr(value, f"is_{word}") is told for word, told in x.assumptions0.items()):
            return value
    raise SceneError(
        f"{x}: no number is found that it is declared to be: declare it positive or real"
    )


def _errors(found: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, str, float]]:
    """The quantity, the way and its error in units in the last place; infinite where it is nan."""
    for name, row in found.items():
        exact = row["complex"]
        unit = ulp(max(abs(float(exact)), _SMALLEST))
        for way in WAYS:
            off = row[way] - exact
            yield name, way, inf if isnan(float(off)) else abs(float(off)) / unit


@dataclass(frozen=True)
class _Ways:
    """Evaluates the quantities of a distortion at a point in each of the ways.

    Each has code of its own, so that a mistake in one shows against the others.
    """

    d: Distortion

    @cached_property
    def _symbols(self) -> list[Symbol]:
        return sorted({*self.d.needed_chain.parameters}, key=str)

    @cached_property
    def _orders(self) -> set[Symbol]:
        """The symbols in powers of s, whose values stay below 1."""
        return {x for order in self.d.needed_chain.ring.orders for x in order.free_symbols}

    def draw(self, draw: Random) -> dict[Symbol, Rational]:
        """Random doubles."""
        return {x: _drawn(draw, x, 0.9 if x in self._orders else 10) for x in self._symbols}

    def at(
        self, omega: Rational, values: Mapping[Symbol, Rational]
    ) -> dict[str, dict[str, Any]] | None:
        """The value of each quantity by each way; None where the chain has a pole, or no value."""
        point = [mpmath.mpf(int(x.p)) / int(x.q) for x in (omega, *values.values())]
        try:
            exact = self._complex(*point)
            forms, steps = (
                dict(zip(DISTORTION, f(*point), strict=True)) for f in (self._closed, self._steps)
            )
            balls = self._balls(omega, values)
        except (ZeroDivisionError, UndecidedError):
            return None
        compiled = self._compiled(float(omega), **{x.name: float(v) for x, v in values.items()})
        found = {}
        for name in DISTORTION:
            row = (
                exact[name],
                forms[name],
                steps[name],
                balls[name],
                mpmath.mpf(float(getattr(compiled, name))),
            )
            found[name] = dict(zip(("complex", *WAYS), row, strict=True))
        return found if all(isfinite(float(x["complex"])) for x in found.values()) else None

    def _complex(self, omega: Any, *values: Any) -> dict[str, Any]:
        """Direct complex evaluation of the chain: each effect [[a, b], [c, d]] takes H to
        (a H + b)/(c H + d)."""
        env, H, *rows = self._entries(mpmath.mpc(0, omega), *values)
        for a, b, c, d in rows:
            H = (a * H + b) / (c * H + d)
        change, size = _without_noise(H - env), abs(env)
        relative = _without_noise((H - env) / env)
        parts = (
            change.real,
            change.imag,
            abs(change.real) / size,
            abs(change.imag) / size,
            relative.real,
            relative.imag,
        )
        return dict(zip(DISTORTION, map(mpmath.mpf, parts), strict=True))

    @cached_property
    def _entries(self) -> Callable[..., Any]:
        chain = self.d.needed_chain
        return _made([s, *self._symbols], [chain.environment, chain.rendered, *chain.matrices])

    @cached_property
    def _closed(self) -> Callable[..., Any]:
        d = self.d
        return _made([d.frequency, *self._symbols], [getattr(d, name) for name in DISTORTION])

    @cached_property
    def _steps(self) -> Callable[..., Any]:
        named = self.d.steps(*DISTORTION)
        arguments = [self.d.frequency, *self._symbols]
        put = _plainly([*arguments, *(x for x, _ in named.definitions)])
        results = [computable(named.results[name]).xreplace(put) for name in DISTORTION]
        steps = [(put[x], computable(value).xreplace(put)) for x, value in named.definitions]
        # the named steps stand in for the common subexpressions that lambdify would look for
        made: Callable[..., Any] = lambdify(
            [put[x] for x in arguments], results, _MODULES, cse=lambda _: (steps, results)
        )
        return made

    def _balls(self, omega: Rational, values: Mapping[Symbol, Rational]) -> dict[str, Any]:
        """Correctly rounded doubles from balls around lowest terms."""
        at = fmpq(int(omega.p), int(omega.q))
        here = self.d.at({x.name: v for x, v in values.items()})
        functions = here.functions(DISTORTION)
        return {
            name: mpmath.mpf(float(PointValue(f, at, rooted=name.startswith("ratio"))))
            for name, f in functions.items()
        }

    @cached_property
    def _compiled(self) -> Callable[..., Any]:
        return self.d.compile(of=DISTORTION)


def _without_noise(z: Any) -> Any:
    """A part that is only what 60 digits lost is 0, as of a gain that turns no phase."""
    least = _NOISE * abs(z)
    return mpmath.mpc(*(0 if abs(x) < least else x for x in (z.real, z.imag)))


def _made(arguments: list[Symbol], forms: Any) -> Callable[..., Any]:
    """A function of mpmath; numbers in the forms stay exact."""
    put = _plainly(arguments)

    def plain(form: Any) -> Any:
        if isinstance(form, list | tuple):
            return [plain(x) for x in form]
        # Abs multiplies out what it is given, which may take minutes
        if isinstance(form, Abs):
            return Abs(computable(form.args[0]).xreplace(put), evaluate=False)
        if form.has(Abs):
            return form.func(*map(plain, form.args))
        return computable(form).xreplace(put)

    made: Callable[..., Any] = lambdify([put[x] for x in arguments], plain(forms), _MODULES)
    return made


def _plainly(symbols: list[Symbol]) -> dict[Symbol, Symbol]:
    """Plain symbols p0, p1, ... in place of some: names that no function of mpmath has."""
    return {x: Symbol(f"p{n}", positive=x.is_positive) for n, x in enumerate(symbols)}
