"""Units by their names: value in SI, exact, and base dimensions. The usual ones are known by heart, all others by Pint."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from sympy import Expr, Integer, Rational, pi

from haptisym.kernel.errors import ExpressionError, SceneError, quoted
from haptisym.model.expressions import evaluate

if TYPE_CHECKING:
    import pint  # costs as much time as SymPy: loaded where a unit is not among the usual ones

_JUXTAPOSED = re.compile(r"(?<=[\w)°%])\s+(?=[^\W\d]|[(°%])")  # "N s/m" is N*s/m
_PLAIN = str.maketrans({"·": "*", "×": "*", "⋅": "*", "²": "^2", "³": "^3"})

_USUAL: dict[str, tuple[Expr, dict[str, int]]] = {
    "1": (Integer(1), {}),
    "%": (Rational(1, 100), {}),
    "rad": (Integer(1), {}),
    "kg": (Integer(1), {"mass": 1}),
    "g": (Rational(1, 1000), {"mass": 1}),
    "m": (Integer(1), {"length": 1}),
    "mm": (Rational(1, 1000), {"length": 1}),
    "s": (Integer(1), {"time": 1}),
    "ms": (Rational(1, 1000), {"time": 1}),
    "rad/s": (Integer(1), {"time": -1}),
    "Hz": (2 * pi, {"time": -1}),
    "N": (Integer(1), {"mass": 1, "length": 1, "time": -2}),
    "N/m": (Integer(1), {"mass": 1, "time": -2}),
    "N*s/m": (Integer(1), {"mass": 1, "time": -1}),
    "N*m": (Integer(1), {"mass": 1, "length": 2, "time": -2}),
    "N*m/rad": (Integer(1), {"mass": 1, "length": 2, "time": -2}),
    "N*m*s/rad": (Integer(1), {"mass": 1, "length": 2, "time": -1}),
    "kg*m^2": (Integer(1), {"mass": 1, "length": 2}),
}
"""The units that nearly every scene is written in, SI value and dimensions, as Pint has them."""


def read_unit(unit: str, text: str, hint: str) -> tuple[Expr, dict[str, Fraction]]:
    """Its value in SI and its base dimensions, exact. ``text``, ``hint``: what an error quotes, and how it ends."""
    plain = _JUXTAPOSED.sub("*", unit.translate(_PLAIN))
    if plain in _USUAL:
        factor, exponents = _USUAL[plain]
        return factor, {name: Fraction(power) for name, power in exponents.items()}
    return _measured(plain, unit, text, hint)


_OWN = {"": {}, "kg": {"mass": 1}, "kg*m^2": {"mass": 1, "length": 2}, "rad/s": {"time": -1}}
"""Units that are not written with newtons, metres and seconds."""


def si_unit(exponents: tuple[tuple[str, Fraction], ...]) -> str:
    """The SI unit with these base dimensions; empty where they have none that is written without fractions.

    >>> si_unit((("time", Fraction(-1)),)), si_unit((("length", Fraction(-1)), ("mass", Fraction(1))))
    ('rad/s', 'N*s^2/m^2')
    """
    left = dict(exponents)
    for name, own in _OWN.items():
        if left == own:
            return name
    newtons = left.pop("mass", Fraction(0))
    metres, seconds = left.pop("length", Fraction(0)) - newtons, left.pop("time", Fraction(0)) + 2 * newtons
    powers = {"N": newtons, "m": metres, "s": seconds}
    if left or any(x.denominator > 1 or abs(x) > 9 for x in powers.values()):
        return ""
    above, below = ([_power(name, x) for name, x in powers.items() if sign * x > 0] for sign in (1, -1))
    return "/".join(["*".join(above) or "1", *below])


def _power(name: str, exponent: Fraction) -> str:
    return name if abs(exponent) == 1 else f"{name}^{abs(exponent)}"


_SPELT = [
    f"{prefix}{unit}" for unit in ("Hz", "N", "J", "m", "s", "g", "rad") for prefix in ("", "k", "m", "M", "c", "u")
]
"""As they are meant by those who write them in other letters."""


def _measured(plain: str, unit: str, text: str, hint: str) -> tuple[Expr, dict[str, Fraction]]:
    """A unit's factor and dimensions from Pint's registry."""
    import pint

    try:
        measured = evaluate(plain, number=_unit_number, name=_named_unit, sums=False)
        base = measured.to_root_units()
    except (ExpressionError, pint.PintError, ArithmeticError):
        near = next((f'; did you mean "{x}"?' for x in _SPELT if x.lower() == unit.lower()), "")
        raise SceneError(f"{quoted(text)}: {quoted(unit)} is not a unit{hint}{near}") from None
    exponents = {name.strip("[]"): Fraction(power) for name, power in base.dimensionality.items()}
    turns = exponents.pop("circle", Fraction(0))
    if turns.denominator != 1 or (isinstance(base.magnitude, float) and base.magnitude != 1.0):
        raise SceneError(
            f"{quoted(text)}: only m, s, kg, N, rad and such, whose factor is 1, may have fractional powers"
        )
    exact = Fraction(base.magnitude)
    return Rational(exact.numerator, exact.denominator) * pi ** Integer(int(turns)), exponents


def _unit_number(text: str) -> pint.Quantity[Fraction]:
    if text != "1":
        raise ValueError("a unit holds no number but 1")
    return _registry().Quantity(Fraction(1))


def _named_unit(name: str) -> pint.Quantity[Fraction]:
    import pint

    try:
        return _registry().Quantity(Fraction(1), name)
    except (pint.PintError, ValueError):
        raise KeyError(name) from None


@cache
def _registry() -> pint.UnitRegistry:
    import pint

    units = Path(__file__).parents[1] / "data" / "units.txt"
    return pint.UnitRegistry(str(units), non_int_type=Fraction, cache_folder=None)
