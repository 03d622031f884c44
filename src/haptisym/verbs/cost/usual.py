"""The usual ways to the ratios and the crossings, as their users go them: nothing here is proven, and none of it is haptisym's.

Floats of H_perc - H_env as they are written, transfer functions with expanded coefficients, grids, eigenvalues of a companion
matrix.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from sympy import Expr, Float, Integer, Rational, lambdify

from haptisym.interop import to_control, to_scipy
from haptisym.judge.criteria import Criterion
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import s
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, is_irrational_algebraic
from haptisym.programs.values import Array
from haptisym.verbs.cost.margins import margin
from haptisym.verbs.cost.questions import Attempt, Crossings, Found, RatioQuestion

_BLOCK = 1 << 14  # points that stay in the processor's cache


class RefusedError(HaptisymError):
    """A method does not fit a question, or a package that it needs is missing; the text says which."""


# The ratios at frequencies: they answer with a pair (r_r, r_i) for each frequency.


def naive(distortion: Distortion, free: Sequence[Expr] = ()) -> Callable[..., tuple[Any, Any]]:
    """H_env and H_perc - H_env on s = j omega, in complex floats as the formulas are written; of omega and what is ``free``."""
    chain = distortion.chain
    perceived = chain.rendered
    for a, b, c, d in chain.matrices:
        perceived = (a * perceived + b) / (c * perceived + d)
    both = lambdify([s, *free], [_with_floats(x) for x in (chain.environment, perceived)], "numpy", cse=True)

    def functions(omega: Array, *values: Array) -> tuple[Any, Any]:
        H, G = both(1j * omega, *values)
        return H, G - H

    return functions


def _with_floats(form: Expr) -> Expr:
    """Numbers as floats, but for small whole ones: NumPy has no whole numbers as large as SymPy's."""
    numbers = {x: Float(x, 17) for x in form.atoms(Rational) if not (isinstance(x, Integer) and abs(x) < 100)}
    return form.xreplace(numbers)


def _ratios(H: Any, dH: Any, omega: Array) -> Array:
    """Both ratios, one row for each frequency."""
    size = np.abs(H)
    rows: Array = np.stack(
        [np.broadcast_to(np.abs(x) / size, omega.shape) for x in (np.real(dH), np.imag(dH))], axis=-1
    )
    return rows


def _quietly(function: Callable[[], Any]) -> Any:
    with np.errstate(all="ignore"):  # what overflows or divides by zero is judged by its value
        return function()


def _silently(function: Callable[[], Any]) -> Any:
    """Without the warnings of other packages, which are not about a user's own call."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return function()


def naive_way(question: RatioQuestion) -> Attempt:
    """H_perc - H_env in floats, as SymPy's ``lambdify`` writes it."""
    function, omega = naive(question.distortion), np.array(question.omegas)
    return lambda: _quietly(lambda: _ratios(*function(omega), omega))


def control_way(question: RatioQuestion) -> Attempt:
    """The difference of two transfer functions of python-control."""
    H, G = _silently(lambda: [to_control(x.expression()) for x in _rational(question.distortion)])
    difference, omega = G - H, np.array(question.omegas)
    return lambda: _silently(lambda: _ratios(H(1j * omega), difference(1j * omega), omega))


def scipy_way(question: RatioQuestion) -> Attempt:
    """The difference of two frequency responses of ``scipy.signal``."""
    from scipy import signal

    H, G = _silently(lambda: [to_scipy(x.expression()) for x in _rational(question.distortion)])
    omega = np.array(question.omegas)

    def attempt() -> Array:
        felt, given = (signal.freqs(x.num, x.den, omega)[1] for x in (G, H))
        return _ratios(given, felt - given, omega)

    return lambda: _silently(attempt)


def _rational(distortion: Distortion) -> tuple[Any, Any]:
    if distortion.perc.ring.functions:
        raise RefusedError("transfer functions know no delays and no fractional powers")
    return distortion.env, distortion.perc


# Crossings: they answer with ``Found``.


def grid_way(question: Crossings, count: int, *, brent: bool = False) -> Attempt:
    """Changes of sign between the points of a grid, each by a straight line, or found by Brent's method."""
    function = naive(question.distortion)
    low, high = (float(x) for x in question.band)

    def excess(omega: Any, criterion: Criterion) -> Any:
        return margin(criterion, omega, *function(omega))

    def attempt() -> Found:
        grid = np.linspace(low, high, count)
        found: dict[str, list[float]] = {x.name: [] for x in question.criteria}
        for start in range(0, count - 1, _BLOCK):
            block = grid[start : start + _BLOCK + 1]  # neighbouring blocks share a point, which counts once
            H, dH = function(block)
            for x in question.criteria:
                values = np.broadcast_to(margin(x, block, H, dH), block.shape)
                refine = partial(_brent, partial(excess, criterion=x)) if brent else _straight
                found[x.name] += _changes(block, values, refine, is_last=start + _BLOCK >= count - 1)
        return Found(found)

    return lambda: _quietly(attempt)


Refine: TypeAlias = Callable[[float, float, float, float], float]


def _changes(grid: Array, values: Array, refine: Refine, *, is_last: bool) -> list[float]:
    at = [float(grid[i]) for i in np.flatnonzero(values == 0) if is_last or i < len(grid) - 1]
    between = np.flatnonzero(values[1:] * values[:-1] < 0)
    rows = zip(grid[between], grid[between + 1], values[between], values[between + 1], strict=True)
    return sorted([*at, *(refine(*(float(x) for x in row)) for row in rows)])


def _straight(a: float, b: float, at_a: float, at_b: float) -> float:
    return a - at_a * (b - a) / (at_b - at_a)


def _brent(function: Callable[[Any], Any], a: float, b: float, at_a: float, at_b: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(lambda omega: float(function(np.float64(omega))), a, b, xtol=1e-300, rtol=1e-15))


def companion_way(question: Crossings) -> Attempt:
    """numpy.roots on the float coefficients of the exact polynomial in omega^2, or omega: the eigenvalues that are real."""
    low, high = (float(x) for x in question.band)
    rows = {x.name: _polynomial(question, x) for x in question.criteria}

    def attempt() -> Found:
        found = {}
        for name, row in rows.items():
            is_even = not row[1::2].any()
            zeros = np.roots((row[::2] if is_even else row)[::-1])
            omegas = zeros[np.isreal(zeros) & (zeros.real >= 0)].real
            omegas = np.sqrt(omegas) if is_even else omegas
            found[name] = sorted(float(x) for x in omegas[(omegas >= low) & (omegas <= high)])
        return Found(found)

    return lambda: _quietly(attempt)


def _polynomial(question: Crossings, criterion: Criterion) -> Array:
    """The coefficients, ascending."""
    if any(is_irrational_algebraic(question.threshold[x]) for x in Part):
        raise RefusedError("the threshold is not rational")
    excess = question.functions[criterion]
    if not isinstance(excess, RealFunction):
        raise RefusedError("the border of the region is not that of one polynomial")
    row = None if excess.axis.functions else excess.axis.univariate(excess.function.cleared().numerator)
    if row is None:
        raise RefusedError("the equation is not a polynomial with rational coefficients")
    return np.array([float(int(x.p) / int(x.q)) for x in row])
