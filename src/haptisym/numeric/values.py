"""NumPy functions of closed forms: shape kept, limits at 0 by value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sympy import Expr, Float, Integer, Rational, Symbol, lambdify, pi

from haptisym.errors import SceneError
from haptisym.symbols import omega

Array: TypeAlias = NDArray[np.float64]


class Values(NamedTuple):
    """Values of the closed forms at the given frequencies, each of the shape of the broadcast arguments."""

    real: Array
    imag: Array
    ratio_real: Array
    ratio_imag: Array
    relative_real: Array
    relative_imag: Array
    environment_real: Array
    environment_imag: Array
    perceived_real: Array
    perceived_imag: Array


_SQUARED = ("ratio_real", "ratio_imag")


def compiled(forms: Mapping[str, Expr], parameters: list[Symbol]) -> Callable[..., Values]:
    """A function ``f(omega, name=value, ...)`` of frequencies in rad/s and parameters in SI, all of them broadcast.

    ``forms``: a closed form for each field of ``Values``, of the ratios their squares. The function raises SceneError for a
    missing or unknown parameter.
    Values have the relative accuracy of floats except near zeros of numerators and denominators.
    """
    names = sorted(str(p) for p in parameters)
    ordered = [omega, *sorted(parameters, key=str)]
    evaluate = lambdify(ordered, [_floats(forms[name]) for name in Values._fields], "numpy", cse=True)

    def function(omega: ArrayLike, **values: ArrayLike) -> Values:
        if sorted(values) != names:
            raise SceneError(
                f"parameters needed are {', '.join(names) or 'none'}; given are {', '.join(sorted(values)) or 'none'}"
            )
        arguments = [np.asarray(x, dtype=float) for x in (omega, *(values[name] for name in names))]
        shape = np.broadcast_shapes(*(x.shape for x in arguments))
        with np.errstate(divide="ignore", invalid="ignore"):  # a pole is inf by value, not a warning
            results = evaluate(*arguments)
            rooted = [np.sqrt(x) if name in _SQUARED else x for name, x in zip(Values._fields, results, strict=True)]
        return Values(*(np.broadcast_to(np.asarray(x, dtype=float), shape).copy() for x in rooted))

    return function


def _floats(form: Expr) -> Expr:
    """The form with its numbers as floats, so that NumPy never meets a whole number larger than its own."""
    numbers: dict[Any, Expr] = {
        x: Float(x, 17) for x in form.atoms(Rational) if not (isinstance(x, Integer) and abs(x) < 100)
    }
    return form.xreplace({**numbers, pi: Float(pi, 17)})
