"""The catalogue: environments, effects and hands, as values that a scene is made of.

A model is a function from parameters to a dynamics, ``H(s)`` or a chain matrix, entered under its
name in scene files by the decorator ``environment`` or ``effect``; its signature says what each
parameter measures and may be. Numbers, strings with units or symbols go in, an ``Environment`` or
an ``Effect`` comes out. A ``Hand`` is m s^2 + b s + k, which stands beside H_perc where both move
together; a shunt of that form, a ``DeviceImpedance``, stands beside it too.

A controller with a clock renders an environment as a difference equation: ``D(z)`` is its dynamics
with a difference in place of s, and a ``sampled-loop`` is the effect that makes of what would be
rendered what is: D - H beside it, then delay and hold.
"""

from __future__ import annotations

import inspect
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import cache, wraps
from numbers import Real
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple, TypeAlias, TypeVar, get_args, get_type_hints

from sympy import Expr, Integer, Poly, Pow, Symbol, exp, nan, pi, zoo

from haptisym.kernel.errors import SceneError, SignError, meant, need, quoted, several, within
from haptisym.kernel.objects import Shown
from haptisym.kernel.rings import PolynomialRing, RationalFunction, s
from haptisym.model.parameters import (
    NAMED,
    Parameter,
    Rule,
    Slot,
    chosen,
    enter_list,
    enter_parameter,
    free_name,
    in_place,
    read_parameter,
    refuse_references,
    renamed,
    tied_to,
    values,
    with_values,
)
from haptisym.model.quantities import (
    Dimension,
    MotionKind,
    Number,
    decimal,
    evaluate,
    in_laplace,
    number,
    quantity,
    refuse_units,
)

Matrix: TypeAlias = tuple[Expr, Expr, Expr, Expr]


@dataclass(frozen=True)
class Model:
    """One row of the catalogue: a model's name in scene files, its parameters, the function that
    builds an Environment or an Effect from their values, and a sentence about it."""

    name: str
    slots: Mapping[str, Slot]
    build: Callable[..., Any]
    summary: str


@dataclass(frozen=True, repr=False)
class Environment(Shown):
    """The environment to be felt, exact: its dynamic stiffness ``H_env(s) = F(s)/X(s)``, N/m or
    N m/rad.

    ``dynamics`` : in s and the symbols of ``parameters``; ``H`` : with their values, SI.
    Made by the functions of ``haptisym.environments``; SceneError for a value that breaks the rule
    of its parameter.

    >>> from haptisym import environments
    >>> environments.kelvin_voigt("100 N/m", "2 N*s/m").H
    2*s + 100
    """

    model: str
    parameters: tuple[Parameter, ...]
    dynamics: Expr

    def _line(self) -> str:
        return f"{self.model}: {'; '.join(p.stated() for p in self.parameters) or self.dynamics}"

    @property
    def H(self) -> Expr:
        """H_env(s) with the parameters' values in place, force per position."""
        return in_place(self.dynamics, values(self.parameters))

    def with_values(self, given: Mapping[str, Number]) -> Environment:
        """The same environment with other values for the parameters whose symbols have these
        names."""
        return replace(self, parameters=with_values(self.parameters, given))

    def renamed(self, names: Mapping[Symbol, Symbol]) -> Environment:
        """The same environment with other symbols for its parameters."""
        return replace(
            self, parameters=renamed(self.parameters, names), dynamics=self.dynamics.xreplace(names)
        )

    def seen_by(self, effects: Sequence[Effect]) -> Environment:
        """The environment in s: a difference equation, which the first effect computes at its
        period T, with z = exp(s T); any other one as it is."""
        if self.model != DIFFERENCE_EQUATION:
            return self
        T = effects[0].parameters[0]
        return replace(
            self,
            parameters=(*self.parameters, T),
            dynamics=self.dynamics.xreplace({BACK: exp(-s * T.symbol)}),
        )

    @property
    def own(self) -> tuple[Parameter, ...]:
        """The parameters of its own: all but those that are tied to another environment's."""
        return tuple(p for p in self.parameters if not p.tie)

    def tied_to(self, environment: Environment) -> Environment:
        """The rendered environment with its references resolved: a parameter given as
        "environment.k" becomes that environment's k, with its symbol, value and range.

        SceneError for a reference to what the environment does not have, or to what does not fit.

        >>> from haptisym.environments import kelvin_voigt
        >>> wall, felt = (kelvin_voigt(k, b) for k, b in ((500, 3), ("environment.k", 2)))
        >>> felt.tied_to(wall).H
        2*s + 500
        """
        known = {f"environment.{p.key}": p for p in environment.parameters}
        slots = ENVIRONMENTS[self.model].slots
        tied = {
            p.key: tied_to(p, known, slots.get(p.key.partition("[")[0], NAMED))
            for p in self.parameters
            if p.tie
        }
        # A parameter of its own whose symbol the tied one now has would become equal to it: it is
        # renamed before all symbols are replaced at once.
        names = {p.symbol: tied[p.key].symbol for p in self.parameters if p.tie}
        taken = {x.name for x in (*names.values(), *(p.symbol for p in self.own))}
        for x in (p.symbol for p in self.own if p.symbol in names.values()):
            names[x] = Symbol(free_name(f"{x.name}_rendered", taken), **x.assumptions0)
            taken.add(names[x].name)
        parameters = (
            tied.get(p.key, replace(p, symbol=names.get(p.symbol, p.symbol)))
            for p in self.parameters
        )
        return replace(self, parameters=tuple(parameters), dynamics=self.dynamics.xreplace(names))


@dataclass(frozen=True, repr=False)
class Effect(Shown):
    """An element between environment and hand, as a chain matrix, exact: ``[F_h; X_h] = [[A, B],
    [C, D]] [F_e; X_e]``.

    F is force, N or N m, X position, m or rad: of a dynamics H on the environment's side the hand
    feels ``(A H + B)/(C H + D)``.
    ``dynamics`` : A, B, C, D in s and the symbols of ``parameters``; ``matrix`` : with their
    values, SI.
    Made by the functions of ``haptisym.effects``; SceneError for a value that breaks the rule of
    its parameter.

    >>> from haptisym import effects
    >>> effects.first_order_lag("80 rad/s").matrix
    (80/(s + 80), 0, 0, 1)
    """

    model: str
    parameters: tuple[Parameter, ...]
    dynamics: Matrix = field(repr=False)
    name: str = ""
    settings: tuple[tuple[str, str | int], ...] = ()
    """Choices that are no numbers to vary, by key: a method, an order."""
    renders: Environment | None = field(default=None, repr=False)
    """The environment that a sampled loop renders, once it stands in a scene; None of others."""

    def _line(self) -> str:
        label = self.name if self.name in ("", self.model) else f"{self.name} "
        model = f"({self.model})" if label and label != self.model else self.model
        shown = [
            *(p.stated() for p in self.parameters),
            *(f"{key} = {value}" for key, value in self.settings),
        ]
        return f"{label if label != self.model else ''}{model}: {'; '.join(shown)}".rstrip(": ")

    def setting(self, key: str) -> str | int:
        """The choice for a key that is no parameter; empty where there is none."""
        return dict(self.settings).get(key, "")

    @property
    def matrix(self) -> Matrix:
        """The chain matrix (A, B, C, D) with the parameters' values in place."""
        numbers = values((*self.parameters, *(self.renders.parameters if self.renders else ())))
        a, b, c, d = (
            entry if entry.is_Integer else in_place(entry, numbers) for entry in self.dynamics
        )
        return a, b, c, d

    def with_values(self, given: Mapping[str, Number]) -> Effect:
        """The same effect with other values for the parameters whose symbols have these names."""
        return replace(self, parameters=with_values(self.parameters, given))

    def renamed(self, names: Mapping[Symbol, Symbol]) -> Effect:
        """The same effect with other symbols for its parameters."""
        a, b, c, d = (entry.xreplace(names) for entry in self.dynamics)
        return replace(self, parameters=renamed(self.parameters, names), dynamics=(a, b, c, d))


ENVIRONMENTS: dict[str, Model] = {}
EFFECTS: dict[str, Model] = {}


def environment(name: str) -> Callable[[Callable[..., Expr]], Callable[..., Environment]]:
    """Enter a model function, parameters to H(s), in the catalogue under its name in scene
    files."""

    def decorate(equation: Callable[..., Expr]) -> Callable[..., Environment]:
        slots = _slots(equation)

        @wraps(equation)
        def build(*args: Any, **kwargs: Any) -> Environment:
            try:
                parameters, arguments = _bind(equation, slots, args, kwargs)
            except SignError as error:
                way = "" if error.zero else f". {_signed(equation, slots, str(error), kwargs)}"
                raise SceneError(f"{name} needs {error.bound}{way}") from None
            except _MissingError as error:
                raise SceneError(f"{name} {error}") from None
            return Environment(name, parameters, _expression(equation(**arguments)))

        ENVIRONMENTS[name] = Model(name, slots, build, _summary(equation))
        return build

    return decorate


def effect(model: str) -> Callable[[Callable[..., Matrix]], Callable[..., Effect]]:
    """Enter a model function, parameters to chain matrix (A, B, C, D), in the catalogue under its
    name in scene files."""

    def decorate(equation: Callable[..., Matrix]) -> Callable[..., Effect]:
        slots = _slots(equation)

        @wraps(equation)
        def build(*args: Any, name: str = "", **kwargs: Any) -> Effect:
            try:
                parameters, arguments = _bind(equation, slots, args, kwargs)
            except SignError as error:
                raise SceneError(f"{model} needs {error.bound}") from None
            except _MissingError as error:
                raise SceneError(f"{model} {error}") from None
            # Only what is rendered for an environment may refer to a parameter of it.
            refuse_references(parameters)
            a, b, c, d = map(_expression, equation(**arguments))
            if any(x.has(zoo, nan) for x in (a, b, c, d)):
                zero = " and ".join(key for key, x in arguments.items() if x == 0)
                raise SceneError(f"{zero or model}: must not be 0")
            # Settings are recorded with the model's defaults, so that an effect says all of them.
            bound = inspect.signature(equation).bind(**arguments)
            bound.apply_defaults()
            settings = tuple(
                (x, bound.arguments[x])
                for x, slot in slots.items()
                if slot.is_setting and bound.arguments[x] != ""
            )
            return Effect(model, parameters, (a, b, c, d), name or model, settings)

        EFFECTS[model] = Model(model, slots, build, _summary(equation))
        return build

    return decorate


def _expression(entry: Expr | int) -> Expr:
    """A matrix entry as a SymPy expression; models write 0 and 1 as plain numbers."""
    return Integer(entry) if isinstance(entry, int) else entry


class _MissingError(SceneError):
    """Required parameters are absent; the message continues the name of the model."""


def _meaning(slot: Slot) -> str:
    """What a parameter measures, for a message: `` (damping)``; empty where that has no name."""
    if slot.formula:
        return " (a formula in z)" if slot.in_z else " (a formula in s)"
    return (
        ""
        if slot.dimension in (Dimension.ANY, Dimension.RATIO)
        else f" ({slot.dimension.name.lower()})"
    )


def _listed(names: Iterable[str]) -> str:
    """Names as a list in a sentence: ``a, b and c``."""
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last


_PARTS = {"m": "mass", "b": "damper", "k": "spring"}


def _signed(
    equation: Callable[..., Any], slots: Mapping[str, Slot], error: str, given: Mapping[str, Any]
) -> str:
    """A hint how to write an environment with a negative parameter: as a formula or as a shunt."""
    # Environments are passive by construction. The hint shows their own formula where that can be
    # written with the given parameters alone.
    key = error.partition(":")[0].partition("[")[0]
    symbols = {x: Symbol(x) for x in slots if x in given or x == key}
    H = "k"
    if not any(slots[x].several for x in slots) and all(
        x in symbols for x, slot in slots.items() if slot.required
    ):
        H = _in_powers(equation(**symbols))
    what = slots[key].dimension.name.lower() if key in slots else "value"
    return f'For a negative {what}: model = "expression" with H = "{H}", or an effect shunt.'


def _in_powers(H: Expr) -> str:
    """A formula as scene files have it, a polynomial with descending powers of s."""
    if not H.is_polynomial(s):
        return str(H).replace("**", "^")
    powers = {0: "", 1: "*s"}
    return " + ".join(f"{x}{powers.get(n, f'*s^{n}')}" for (n,), x in Poly(H, s).terms())


def _instead(slots: Mapping[str, Slot], given: Mapping[str, Any]) -> str:
    """A hint at another model of the same kind, environment or effect, for which the given
    parameters suffice; empty where there is none."""
    models = next(
        (x for x in (ENVIRONMENTS, EFFECTS) if any(y.slots is slots for y in x.values())), {}
    )
    for model in models.values():
        needed = {key for key, x in model.slots.items() if x.required}
        if (
            given
            and needed <= set(given) <= set(model.slots)
            and not any(x.formula for x in model.slots.values())
        ):
            what = _listed([_PARTS.get(key, key) for key in given])
            return f' For a {what} alone: model = "{model.name}" with {_listed(given)} only.'
    return ""


def _summary(equation: Callable[..., Any]) -> str:
    """The first line of a model's docstring."""
    return (inspect.getdoc(equation) or "").split("\n")[0]


def _slots(equation: Callable[..., Any]) -> dict[str, Slot]:
    """The parameters of a model, read off its signature: an argument with a default may be
    absent."""
    # A Slot is the annotation inside Annotated, which is an extra of the hint.
    hints = get_type_hints(equation, include_extras=True)
    slots = {}
    for name, argument in inspect.signature(equation).parameters.items():
        slot = next(x for x in get_args(hints[name]) if isinstance(x, Slot))
        slots[name] = replace(slot, required=argument.default is inspect.Parameter.empty)
    return slots


def _whole(key: str, given: Any, slot: Slot, period: Any) -> int:
    """Read a whole number; of a time, the error says how many sampling periods it is."""
    try:
        return int(read_parameter(key, given, slot, key).value)
    except SceneError as error:
        samples = ""
        with suppress(SceneError):
            times = [quantity(x, Dimension.TIME) for x in (given, period)]
            # A number without a unit is no time, though it may stand for one.
            if all(x.exponents for x in times):
                count = times[0].value / times[1].value
                samples = f": {given} are {float(count):.5g} samples of T = {period}"
        raise SceneError(*error.args, samples) from None


def _bind(
    equation: Callable[..., Any],
    slots: Mapping[str, Slot],
    args: tuple[Any, ...],
    kwargs: dict[str, Any],
) -> tuple[tuple[Parameter, ...], dict[str, Any]]:
    """The parameters of a call, checked, and the symbols (or formulas) to call the equation
    with."""
    formulas = any(slot.formula for slot in slots.values())
    named = kwargs.pop("parameters", {}) if formulas else {}
    given = _given(slots, args, kwargs, formulas=formulas)
    if not isinstance(named, Mapping):
        raise SceneError(
            f"parameters: {quoted(named)}: give names and values, as {{ w = '50 Hz' }}"
        )
    free = tuple(enter_parameter(key, value, NAMED, key) for key, value in dict(named).items())
    parameters: list[Parameter] = list(free)
    arguments: dict[str, Any] = {}
    for key, value in given.items():
        slot = slots[key]
        # A symbol of an expression that is no parameter yet becomes a free one of any value. In a
        # text such a name is an error, as it is most likely misspelt.
        if slot.formula:
            arguments[key] = _in_z(key, value, free) if slot.in_z else _formula(key, value, free)
            unknown = sorted(
                arguments[key].free_symbols - {s, BACK} - {p.symbol for p in parameters}, key=str
            )
            parameters += [
                Parameter(x, x, NAMED.dimension, key=x.name, rule=NAMED.rule) for x in unknown
            ]
        elif slot.choices:
            arguments[key] = chosen(key, value, slot.choices)
        elif slot.is_setting:
            arguments[key] = _whole(key, value, slot, given.get("T"))
        elif slot.several:
            entered = enter_list(key, value, slot)
            parameters += entered
            arguments[key] = [p.symbol for p in entered]
        else:
            entered = [enter_parameter(key, value, slot, key)]
            parameters += entered
            arguments[key] = entered[0].symbol
    if twice := [p.key for p in free if p.key in given and not slots[p.key].formula]:
        raise SceneError(
            f"parameters: {twice[0]}: the model has a parameter of this name: choose another"
        )
    return tuple(parameters), arguments


def _given(
    slots: Mapping[str, Slot], args: tuple[Any, ...], kwargs: dict[str, Any], *, formulas: bool
) -> dict[str, Any]:
    """What a call gives, by key, in the order of the slots; SceneError for unknown and missing
    parameters."""
    valid = [*slots, *(["parameters"] if formulas else [])]
    if len(args) > len(slots):
        raise SceneError(f"too many parameters: valid are {', '.join(valid)}")
    given = {**dict(zip(slots, args, strict=False)), **kwargs}
    # Where no key is spelt alike, a word for what is measured, "damping", leads to its key, b.
    for key in given:
        if key not in slots:
            hint = meant(key, valid) or next(
                (f'did you mean "{x}"? ' for x in slots if slots[x].dimension.name.lower() == key),
                "",
            )
            raise SceneError(f'unknown parameter "{key}": {hint}valid are {", ".join(valid)}')
    missing = [key for key, slot in slots.items() if slot.required and key not in given]
    if missing:
        needed = _listed([f"{key}{_meaning(slots[key])}" for key in missing])
        raise _MissingError(f"needs {needed}.{_instead(slots, given)}")
    return {key: given[key] for key in slots if key in given}


def is_system(given: object) -> bool:
    """Whether something is a number, a transfer function of another package, or a pair of
    coefficients."""
    # By the name of its package: an instance of python-control or SciPy exists only where that is
    # loaded already, and neither has to be loaded, or installed, to ask.
    if isinstance(given, Expr | Real | Decimal) and not isinstance(given, bool):
        return True
    if isinstance(given, tuple | list):
        # A row is a sequence or an array of NumPy, which need not be loaded.
        return len(given) == 2 and all(
            hasattr(x, "__len__") and not isinstance(x, str) for x in given
        )
    return type(given).__module__.partition(".")[0] in ("sympy", "control", "scipy")


def _formula(key: str, given: Any, parameters: Sequence[Parameter]) -> Expr:
    """A formula as an expression in ``s`` and the parameters' symbols; SceneError for fractional
    powers of anything but s, and for a second 2 pi."""
    form = _read(key, given, parameters)
    # s^alpha has a ring of its own; a root of a polynomial in s has none. Of SymPy expressions the
    # root of a constant >= 0 is real and is allowed, as sqrt(k) in a critical damping.
    for x in form.atoms(Pow):
        is_constant = not isinstance(given, str) and not x.base.has(s)
        is_root = is_constant and x.base.is_nonnegative
        if x.exp.is_Rational and not x.exp.is_Integer and x.base != s and not is_root:
            base = str(x.base).replace("**", "^")
            rule = (
                "fractional powers need what is under them declared positive"
                if is_constant
                else "only s has fractional powers, as in 0.17*s^0.5"
            )
            raise SceneError(f"{key}: ({base})^({x.exp}): {rule}")
    # A frequency in Hz has its 2 pi in its value already: with pi in the formula too, somebody has
    # most likely converted it twice.
    for p in parameters if isinstance(given, str) and form.has(pi) else ():
        if p.symbol in form.free_symbols and p.value.has(pi):
            rule = f"leave pi out of the formula, or give {p.key} in 1/s"
            raise SceneError(
                f"{key}: {p.key} in Hz already contains 2 pi ({p.value} rad/s): {rule}"
            )
    return form


def _read(key: str, given: Any, parameters: Sequence[Parameter]) -> Expr:
    """An expression in ``s`` from a text, a SymPy expression, or whatever ``interop`` takes."""
    if isinstance(given, Expr):
        by_name = {p.symbol.name: p.symbol for p in parameters}
        with within(key):
            form = in_laplace(given)
        return form.xreplace({x: by_name[x.name] for x in form.free_symbols if x.name in by_name})
    if not isinstance(given, str):
        if not is_system(given):
            raise SceneError(
                f"{key}: {quoted(given)} is not a formula: write it as a string, or give a "
                f"transfer function"
            )
        # interop stands above this module and is loaded by name, only where a system needs it.
        try:
            return _read(key, resolve_name("haptisym.interop:dynamics")(given), parameters)
        except SceneError as error:
            raise error if str(error).startswith(f"{key}:") else error.within(key) from None
    names: dict[str, Expr] = {"s": s, "pi": pi, **{p.symbol.name: p.symbol for p in parameters}}
    with within(key):
        return evaluate(given, number=decimal, name=lambda name: _known(name, names))


def _in_z(key: str, given: Any, parameters: Sequence[Parameter]) -> Expr:
    """A formula in z as an expression in 1/z and the parameters' symbols."""
    text = str(given) if isinstance(given, int | float | Expr) else given
    if not isinstance(text, str):
        raise SceneError(f"{key}: {quoted(given)} is not a formula in z: write it as a string")
    names: dict[str, Expr] = {
        "z": 1 / BACK,
        "pi": pi,
        **{p.symbol.name: p.symbol for p in parameters},
    }
    with within(key):
        form = evaluate(text, number=decimal, name=lambda name: _known(name, names))
        try:
            PolynomialRing(BACK, form.free_symbols - {BACK}).convert(form)
        except SceneError:
            raise SceneError(f"{quoted(text)} must be rational in z") from None
    return form


def _known(name: str, names: Mapping[str, Expr]) -> Expr:
    """What a name in a formula means; ValueError for an unknown one, which ``evaluate`` makes an
    error with a caret."""
    if name not in names:
        raise ValueError(
            f'unknown name "{name}": {meant(name, names)}valid are {", ".join(names)}; '
            f"define others in parameters"
        )
    return names[name]


# Sampled loops: a controller with a clock that renders an environment as a difference equation.


SAMPLED_LOOP, HOLD, DIFFERENCE_EQUATION = "sampled-loop", "zero-order-hold", "difference-equation"
CLOCKS = (SAMPLED_LOOP, HOLD)
FRICTION, ENCODER = "coulomb-friction", "encoder"
DESCRIBED = (FRICTION, ENCODER, "backlash", "dead-zone", "saturation")
"""Effects that are not linear, of which a matrix has the first harmonic at one amplitude."""
BACK = Symbol("z_back")
"""1/z, what is one sample old."""

_METHODS = {
    # s as a difference over one period T; D(z) = H(s(z)).
    "backward-difference": lambda T: (1 - BACK) / T,
    "tustin": lambda T: 2 * (1 - BACK) / (T * (1 + BACK)),
    "forward-difference": lambda T: (1 - BACK) / (T * BACK),
}
METHODS = tuple(_METHODS)


def discretised(H: Expr, T: Expr, method: str) -> RationalFunction:
    """D(z) = H(s(z)) with common factors cancelled, a quotient of polynomials in 1/z.

    SceneError where H is not rational in s, and where D would need future samples.

    >>> discretised(3 + 2 * s, Integer(1), "backward-difference").expression()
    5 - 2*z_back
    >>> discretised(2 * s, Integer(1), "forward-difference")
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: forward-difference would need future samples: use backward-difference or tustin
    """
    in_z = H.xreplace({s: _METHODS[method](T)})
    ring = PolynomialRing(BACK, in_z.free_symbols - {BACK})
    try:
        D = ring.convert(in_z).reduced()
    except SceneError:
        raise SceneError(f"a sampled loop needs dynamics that are rational in s, not {H}") from None
    # A denominator without a constant term in 1/z has the factor 1/z: the newest output would be
    # computed from an input that comes later.
    if D.denominator.subs({0: 0}).is_zero():
        raise SceneError(f"{method} would need future samples: use backward-difference or tustin")
    return D


def controller(effect: Effect) -> RationalFunction:
    """D(z) of a sampled loop that stands in a scene, with its delay, in numbers where its
    parameters have them."""
    assert effect.renders
    D = _difference(effect, effect.renders.H, effect.parameters[0].value)
    return (D * D.ring.function(D.ring.variable) ** samples(effect)).reduced()


def _difference(effect: Effect, H: Expr, T: Expr) -> RationalFunction:
    """D(z) in lowest terms: of dynamics by the method, or as it is written. SceneError where it
    needs future samples."""
    if effect.renders is not None and effect.renders.model != DIFFERENCE_EQUATION:
        return discretised(H, T, str(effect.setting("method")))
    D = PolynomialRing(BACK, H.free_symbols - {BACK}).convert(H).reduced()
    if D.denominator.subs({0: 0}).is_zero():
        raise SceneError("D needs future samples: divide it by a power of z")
    return D


def samples(effect: Effect) -> int:
    """The computing delay of a sampled loop, in whole samples."""
    return int(effect.setting("delay"))


def with_controller(effects: Iterable[Effect], rendered: Environment) -> tuple[Effect, ...]:
    """The effects of a scene; a sampled loop among them has the rendered environment in its matrix.

    SceneError where it is not the first effect, where there is another sampler, and where it cannot
    render that environment.
    """
    listed = tuple(effects)
    at = next((i for i, effect in enumerate(listed) if effect.model == SAMPLED_LOOP), None)
    if at is None:
        if rendered.model == DIFFERENCE_EQUATION:
            raise SceneError(
                f"rendered: {DIFFERENCE_EQUATION} needs {SAMPLED_LOOP} as the first effect: "
                f"add it, with T"
            )
        return listed
    first, *others = listed[at:]
    for other in (x for x in (*others, *listed[:at]) if x.model in CLOCKS):
        raise SceneError(
            f"effects.{other.name}: a second sampler: {SAMPLED_LOOP} is the only one of a "
            f"scene; leave it out"
        )
    if at:
        raise SceneError(
            f"effects.{first.name}: {SAMPLED_LOOP} must be the first effect, as its "
            f"controller renders the environment"
        )
    with within(f"effects.{first.name}"):
        is_written = rendered.model == DIFFERENCE_EQUATION
        if bool(first.setting("method")) is is_written:
            raise SceneError(
                f"method: leave it out, as [rendered] is a {DIFFERENCE_EQUATION}"
                if is_written
                else (
                    f"{SAMPLED_LOOP} needs method: {', '.join(METHODS)}; or [rendered] with a "
                    f"{DIFFERENCE_EQUATION}"
                )
            )
        # First alone, as ``_difference`` looks at what the effect renders.
        first = replace(first, renders=rendered)
        placed = replace(first, renders=rendered, dynamics=_sampled_matrix(first, rendered))
    return placed, *others


def _sampled_matrix(effect: Effect, rendered: Environment) -> Matrix:
    """The chain matrix that makes of the rendered H what the hand feels of the sampled loop: G D,
    with D = D(exp(s T)) and G = exp(-s n T) (1 - exp(-s T))/(s T), delay and hold."""
    T = effect.parameters[0].symbol
    one_sample = exp(-s * T)
    D = _difference(effect, rendered.dynamics, T).expression().xreplace({BACK: one_sample})
    G = exp(-s * T * samples(effect)) * (1 - one_sample) / (s * T)
    # A difference equation is D itself: of it G is left.
    if rendered.model == DIFFERENCE_EQUATION:
        return G, Integer(0), Integer(0), Integer(1)
    # (A H + B)/(C H + D) of this matrix is G H + G (D - H) = G D: the rendered H,
    # which stands at the end of every chain, is taken off again.
    return G, G * (D - rendered.dynamics), Integer(0), Integer(1)


_HAND_SLOTS = {
    "m": Slot(Dimension.MASS, Rule.NONNEGATIVE, required=False),
    "b": Slot(Dimension.DAMPING, Rule.NONNEGATIVE, required=False),
    "k": Slot(Dimension.STIFFNESS, Rule.NONNEGATIVE, required=False),
}


@dataclass(frozen=True, repr=False)
class Hand(Shown):
    """A hand of mass ``m``, damping ``b`` and stiffness ``k``, each >= 0: quantities or ranges; 0
    where it is not given.

    Valid by construction: SceneError names what is wrong. ``m``, ``b`` and ``k`` are then
    parameters, with symbols of their own.

    >>> Hand("mine", m="0.5 kg", b=["5 N*s/m", "7 N*s/m"]).dynamics
    b_h*s + k_h + m_h*s**2
    """

    name: str
    m: Any = 0
    b: Any = 0
    k: Any = 0
    source: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError(f'hand: name: "{self.name}": give a name, as "mine"')
        for key, slot in _HAND_SLOTS.items():
            given = getattr(self, key)
            if not isinstance(given, Parameter):
                object.__setattr__(self, key, read_parameter(key, given, slot, f"{key}_h"))
        kinds = {p.motion: p for p in self.parameters if p.motion}
        if len(kinds) > 1:
            units = ", ".join(f"{p.key} is {motion.value}" for motion, p in kinds.items())
            raise SceneError(f"hand {self.name}: translation and rotation cannot be mixed: {units}")

    def _line(self) -> str:
        return f"{self.name}: {'; '.join(p.stated() for p in self.parameters)}"

    model = "hand"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters m, b and k: mass, damping, stiffness."""
        return self.m, self.b, self.k

    @property
    def motion(self) -> MotionKind | None:
        """The kind of motion that its units imply, along a line or about an axis; None where none
        does."""
        return next((p.motion for p in self.parameters if p.motion), None)

    @property
    def has_ranges(self) -> bool:
        """Whether a parameter has a range, so that it stands for a set of hands."""
        return any(p.interval for p in self.parameters)

    @property
    def dynamics(self) -> Expr:
        """Z_h(s) = m s^2 + b s + k in the symbols of its parameters."""
        return self.m.symbol * s**2 + self.b.symbol * s + self.k.symbol

    @property
    def Z(self) -> Expr:
        """Z_h(s) with the parameters' values, force per position as H_perc."""
        return self.dynamics.xreplace(values(self.parameters))

    def with_values(self, given: Mapping[str, Number]) -> Hand:
        """The same hand with other values for the parameters whose symbols have these names."""
        m, b, k = with_values(self.parameters, given)
        return replace(self, m=m, b=b, k=k)

    def renamed(self, names: Mapping[Symbol, Symbol]) -> Hand:
        """The same hand with other symbols for its parameters."""
        m, b, k = renamed(self.parameters, names)
        return replace(self, m=m, b=b, k=k)

    def on_lever(self, length: Number) -> Hand:
        """The hand at a distance from an axis: m l^2, b l^2 and k l^2 about it, for small angles.

        ``length`` : l > 0, m or with a unit. SceneError for another, and for a hand that turns.

        >>> Hand("mine", m="2 kg").on_lever("50 cm").m
        <Parameter m_h = 1/2 kg*m^2>
        """
        with within("lever"):
            arm = number(length, Dimension.DISPLACEMENT)
            if arm.motion is MotionKind.ROTATION or not arm.value > 0:
                raise SceneError(f"{quoted(length)} must be a length > 0")
            if self.motion is MotionKind.ROTATION:
                raise SceneError(f"hand {self.name} is rotational already: leave it out")
        m, b, k = (p.on_lever(arm.value) for p in self.parameters)
        return replace(self, name=f"{self.name}{AT}{length}", m=m, b=b, k=k)


AT = " at "
"""What stands between the name of a hand and the lever that it holds: ``postural-arm at 15 cm``."""


def read_hand(name: str, given: Mapping[str, Any]) -> Hand:
    """Read a hand from a table of a scene file. SceneError names key, value and rule."""
    valid = (*_HAND_SLOTS, "source", "lever")
    for key in given:
        if key not in valid:
            raise SceneError(
                f'unknown key "{str(key)[:60]}": {meant(str(key), valid)}valid are '
                f"{', '.join(valid)}"
            )
    if not isinstance(given.get("source", ""), str):
        raise SceneError(f'source: "{given["source"]}" must be a string')
    hand = Hand(name, **{key: x for key, x in given.items() if key != "lever"})
    return replace(hand.on_lever(given["lever"]), name=name) if "lever" in given else hand


def _hands() -> Mapping[str, Hand]:
    """The hands of the shipped table."""
    tables = tomllib.loads((Path(__file__).parents[1] / "hands.toml").read_text(encoding="utf-8"))
    return {name: read_hand(name, table) for name, table in tables.items()}


_T = TypeVar("_T")


class Named(Mapping[str, _T]):
    """A mapping of what the package ships of a ``kind``, by name; its file is read at the first use
    and then kept. SceneError for an unknown name."""

    def __init__(self, kind: str, read: Callable[[], Mapping[str, _T]]) -> None:
        # Read late and once: most commands need no published hand and no device.
        self.kind, self._read = kind, cache(read)

    def __getitem__(self, name: str) -> _T:
        if name not in self:
            unknown = f'unknown {self.kind} "{str(name)[:60]}"'
            raise SceneError(
                f"{unknown}: {meant(str(name), self)}the package ships {', '.join(self)}"
            )
        return self._read()[name]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._read()

    def __iter__(self) -> Iterator[str]:
        return iter(self._read())

    def __len__(self) -> int:
        return len(self._read())

    def __repr__(self) -> str:
        return f"<{self.kind}s {', '.join(self)}>"


hands: Mapping[str, Hand] = Named("hand", _hands)
"""The published hands that the package ships, each with its source.

>>> hands["postural-arm"].b.value
129/20
"""


NOBODY = "none"
"""The name of no hand: the display moves in free air."""


def how_to_give() -> str:
    """How a hand is given to a question, for an error that lacks one."""
    listed = f"shipped are {', '.join(hands)}; {NOBODY} is free air"
    return f"--hand NAME (in Python hand=NAME), or [hand] in the scene; {listed}"


class DeviceImpedance(NamedTuple):
    """The impedance Z = k + b s + m s^2 of a device, force per position."""

    k: Expr = Integer(0)
    b: Expr = Integer(0)
    m: Expr = Integer(0)


def device(effect: Effect) -> DeviceImpedance | None:
    """The impedance of a shunt with its parameters' values; None of another effect, and where Z is
    no polynomial in s of degree two or less.

    >>> from haptisym.effects import compliance, shunt
    >>> device(shunt(Z="b*s^2 + 3*s", parameters={"b": 5}))
    DeviceImpedance(k=0, b=3, m=5)
    >>> device(shunt(Z="s^3")) is device(compliance(k=500)) is None
    True
    """
    Z = effect.matrix[1]
    if effect.model != "shunt" or not Z.is_polynomial(s):
        return None
    # Ascending powers, the order of the fields; missing high ones are 0 by their defaults.
    row = Poly(Z, s).all_coeffs()[::-1]
    return DeviceImpedance(*row) if len(row) <= len(DeviceImpedance._fields) else None


_ENVIRONMENT = (
    "give one of haptisym.environments, as environments.kelvin_voigt(100, 2), or a system, as "
    "3*s + 100 of SymPy"
)
_EFFECTS = (
    "give effects of haptisym.effects, or systems in series, in a tuple, as (effects.delay(0.01),)"
)
_HANDS = "give hands in a tuple, as (Hand(...),)"
_BAND = "give its two ends, as (0, 15)"


def given_environment(key: str, given: object) -> Environment:
    """An environment, or any system that ``interop`` takes; SceneError for anything else."""
    with within(key):
        refuse_units(given)
    read = (
        given
        if isinstance(given, Environment) or not is_system(given)
        else _system_read(key, "environment", given)
    )
    need(key, read, Environment, _ENVIRONMENT)
    assert isinstance(read, Environment)
    return read


def given_effects(given: Iterable[Any]) -> tuple[Effect, ...]:
    """Effects in their order, a system being one in series; SceneError for anything else among
    them, or for one alone."""
    listed = several("effects", given, _EFFECTS)
    read = [
        _system_read(f"effects[{i}]", "series", x) if is_system(x) else x
        for i, x in enumerate(listed, 1)
    ]
    for x in read:
        need("effects", x, Effect, _EFFECTS)
    return tuple(read)


def _system_read(key: str, how: str, given: object) -> Any:
    """What the function ``how`` of ``interop`` makes of a system: an environment, or an effect."""
    with within(key):
        return resolve_name(f"haptisym.interop:{how}")(given)


def given_hands(given: Iterable[Hand]) -> tuple[Hand, ...]:
    """Hands; SceneError for anything else among them, or for one alone."""
    listed = several("hands", given, _HANDS)
    for x in listed:
        need("hands", x, Hand, _HANDS)
    return listed


def given_band(given: Iterable[Any]) -> tuple[Any, Any]:
    """The two ends of a band, as they were given; SceneError unless there are two."""
    ends = several("band", given, _BAND)
    if len(ends) != 2:
        raise SceneError(f"band: {ends}: give a low and a high end, as (0, 15)")
    return ends[0], ends[1]
