"""Dynamics from and to SymPy, python-control and SciPy.

In: anything that is a continuous-time system with one input and one output becomes an exact
expression in ``s``, floats read as the decimals that they are written as. Out: a rational dynamics
as a transfer function of the other package.
These packages are optional: one is imported only to export to it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from decimal import Decimal
from functools import reduce
from importlib import import_module
from numbers import Real
from operator import add, mul
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np
from sympy import Add, Expr, I, Integer, Matrix, Poly

from haptisym import effects, environments
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, quoted
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import PolynomialRing, RationalFunction, degree_in, s
from haptisym.model.catalogue import Effect, Environment
from haptisym.model.distortion import Distortion
from haptisym.model.measured import Measurement
from haptisym.model.quantities import constant, decimal, in_laplace

System: TypeAlias = Any
"""A dynamics in some form: see ``dynamics``."""


def dynamics(system: System) -> Expr:
    """The transfer function of a system, exact, as an expression in haptisym's ``s``.

    ``system`` : a SymPy expression in a symbol named s; a number; a system of
    ``sympy.physics.control``, ``control`` or
    ``scipy.signal`` (transfer function, zeros and poles, state space; SymPy's also in series,
    parallel or feedback); a pair of numerator and denominator, coefficients of the highest power
    first; an Environment, an Effect in series, or a Distortion, of which it is H_perc. Floats are
    read as their shortest decimals.
    Raises SceneError for several inputs or outputs, for discrete time, and for roots that are not
    in conjugate pairs.

    >>> dynamics(([1.8, 15, 100], [1]))
    9*s**2/5 + 15*s + 100
    >>> from sympy import Symbol
    >>> dynamics(2 / (Symbol("s", complex=True) + 0.1))
    2/(s + 1/10)
    """
    if isinstance(system, Environment):
        return system.H
    if isinstance(system, Effect):
        return _series_gain(system)
    if isinstance(system, Distortion):
        return system.perceived
    if isinstance(system, Real | Decimal) and not isinstance(system, bool):
        return _number(system)
    for read in (_sympy, _control, _scipy, _pair):
        found = read(system)
        if found is not None:
            return found
    raise SceneError(
        f"{_shown(system)} is not a system: give a SymPy expression in s, a pair of "
        f"numerator and denominator, or a "
        "continuous-time system of sympy.physics.control, control or scipy.signal"
    )


def environment(system: System) -> Environment:
    """The environment with H_env(s) = ``dynamics(system)``, exact: force per position, N/m or N
    m/rad; errors as there.

    >>> environment(([2, 0, 50], [1])).H
    2*s**2 + 50
    """
    return environments.expression(dynamics(system))


def series(system: System, name: str = "") -> Effect:
    """The effect that multiplies the force by G(s) = ``dynamics(system)``, exact, no unit: a
    filter, an actuator, a sensor.

    ``name`` : of the effect, as in paths of parameters. Errors as of ``dynamics``.

    >>> series(([20], [1, 20]), name="actuator").matrix
    (20/(s + 20), 0, 0, 1)
    """
    return effects.series(dynamics(system), name=name or "series")


def to_sympy(system: System, of: str = "H_perc") -> Any:
    """The system as a ``sympy.physics.control.TransferFunction``, exact, common factors cancelled;
    parameters may be symbols.

    ``system`` : as of ``dynamics``; units stay, SI. ``of`` : of a Distortion "H_env", "H_perc" or
    "dH". Raises SceneError for what is not rational in s, and for another name.

    >>> to_sympy(environments.maxwell(100, 5))
    TransferFunction(100*s, s + 20, s)
    >>> from haptisym.model.distortion import distort
    >>> to_sympy(distort(100, 20 / (s + 20)), "dH")
    TransferFunction(-100*s, s + 20, s)
    """
    if isinstance(system, Distortion):
        forms = {"H_env": system.environment, "H_perc": system.perceived, "dH": system.distortion}
        if of not in forms:
            raise SceneError(f"of: {quoted(of)}: give H_env, H_perc or dH")
        system = forms[of]
    above, below = _fraction(system)
    top, bottom = (Add(*(x * s**n for n, x in enumerate(reversed(row)))) for row in (above, below))
    return import_module("sympy.physics.control").TransferFunction(top, bottom, s)


def to_control(system: System) -> Any:
    """The system as a ``control.TransferFunction`` in continuous time, coefficients the nearest
    doubles.

    ``system`` : as of ``dynamics``; units stay, SI and rad/s. Common factors are cancelled; scaled
    so that ``dynamics`` of the result is the same system exactly where doubles allow it. Raises
    SceneError for parameters that are still symbols, for delays and other dynamics that are not
    rational, and where python-control is not installed.

    >>> to_control(environments.maxwell(100, 5)).num[0][0].tolist()
    [100.0, 0.0]
    """
    return _package("control", "python-control").TransferFunction(*_floats(system))


def to_scipy(system: System) -> Any:
    """The system as a ``scipy.signal.TransferFunction`` in continuous time; otherwise like
    ``to_control``.

    SciPy divides by the leading coefficient of the denominator, in doubles: the same system comes
    back where the quotients are exact. It has frequency responses of improper systems, such as a
    mass, but simulates proper ones only.

    >>> to_scipy(environments.maxwell(100, 5)).poles.tolist()
    [-20.0]
    """
    return _package("scipy.signal", "SciPy").TransferFunction(*_floats(system))


def to_frd(response: Measurement) -> Any:
    """A measured or sampled response as python-control's data (``control.FRD``): the same points, H
    in N/m over rad/s.

    ``response`` : a Measurement. Coherence and radius are lost: FRD has no place for them. Raises
    SceneError where python-control is not installed.

    >>> from haptisym.model.measuring import measured
    >>> to_frd(measured([1, 2], [3 + 4j, 5])).omega.tolist()
    [1.0, 2.0]
    """
    return _package("control", "python-control").frd(response.H, response.omega)


# In. A package that nobody has imported has made no system: it is looked up, not imported.


def _series_gain(effect: Effect) -> Expr:
    """G(s) of an effect in series, whose matrix is [[G, 0], [0, 1]]; SceneError for any other."""
    gain, *others = effect.matrix
    if others != [0, 0, 1]:
        raise SceneError(f"{effect.name} is not an effect in series: it has no transfer function")
    return gain


def _sympy(system: System) -> Expr | None:
    """The dynamics of an expression or system of SymPy; None for anything else."""
    if isinstance(system, Poly) and len(system.gens) == 1:
        return in_laplace(system.as_expr(), system.gen)
    if isinstance(system, Expr):
        return in_laplace(system)
    package = sys.modules.get("sympy.physics.control.lti")
    if package is None or not isinstance(system, package.LinearTimeInvariant):
        return None
    return _of_sympy(system, package)


def _of_sympy(system: System, package: ModuleType) -> Expr:
    """The transfer function of a system that may be made of others."""
    _one_channel(system.num_inputs, system.num_outputs)
    _continuous(getattr(system, "sampling_time", 0))
    if isinstance(system, package.StateSpace):
        return _state_space(system.A, system.B, system.C, system.D)
    if isinstance(system, package.TransferFunctionMatrix):
        return _of_sympy(system[0, 0], package)
    # Parts in series or parallel commute, as all have one input and one output.
    for kinds, operation in (
        (package.Series | package.MIMOSeries, mul),
        (package.Parallel | package.MIMOParallel, add),
    ):
        if isinstance(system, kinds):
            return reduce(operation, (_of_sympy(x, package) for x in system.args))
    if not isinstance(system, package.Feedback | package.MIMOFeedback):
        parts = (system.num, system.den)
        # SymPy takes systems as numerator and denominator, too.
        if any(isinstance(x, package.LinearTimeInvariant) for x in parts):
            above, below = (
                _of_sympy(x, package)
                if isinstance(x, package.LinearTimeInvariant)
                else in_laplace(x, system.var)
                for x in parts
            )
            return above / below
        return in_laplace(system.to_expr(), system.var)
    forward, back = (_of_sympy(x, package) for x in (system.sys1, system.sys2))
    # Where 1 - sign G1 G2 is 0 the loop has no solution, whatever enters it.
    loop = 1 - system.sign * forward * back
    if loop.together().expand() == 0:
        raise SceneError("a loop has no transfer function: 1 - sign*G1*G2 is 0 at every frequency")
    return forward / loop


def _control(system: System) -> Expr | None:
    """The dynamics of a system of python-control; None for anything else."""
    package = sys.modules.get("control")
    if package is None or not isinstance(system, package.TransferFunction | package.StateSpace):
        return None
    _one_channel(system.ninputs, system.noutputs)
    _continuous(system.dt)
    if isinstance(system, package.StateSpace):
        return _state_space(system.A, system.B, system.C, system.D)
    return _quotient(system.num[0][0], system.den[0][0])


def _scipy(system: System) -> Expr | None:
    """The dynamics of a system of ``scipy.signal``; None for anything else."""
    package = sys.modules.get("scipy.signal")
    if package is None or not isinstance(system, package.lti | package.dlti):
        return None
    _continuous(system.dt)
    if isinstance(system, package.StateSpace):
        _one_channel(system.B.shape[1], system.C.shape[0])
        return _state_space(system.A, system.B, system.C, system.D)
    if isinstance(system, package.ZerosPolesGain):
        return _number(system.gain) * _from_roots(system.zeros) / _from_roots(system.poles)
    # SciPy keeps several outputs as rows of numerators above one denominator.
    if np.ndim(system.num) != 1:
        raise SceneError("the system has several outputs: take one of them")
    return _quotient(system.num, system.den)


def _pair(system: System) -> Expr | None:
    """The dynamics of a pair of rows of coefficients; None for anything else."""
    if not (isinstance(system, tuple | list) and len(system) == 2):
        return None
    # Two texts are no rows of coefficients, though each is a sequence.
    if not all(isinstance(x, Sequence | np.ndarray) and not isinstance(x, str) for x in system):
        return None
    return _quotient(*system)


def _one_channel(inputs: int, outputs: int) -> None:
    """SceneError unless there is one input and one output."""
    if (inputs, outputs) != (1, 1):
        raise SceneError(
            f"the system has {inputs} inputs and {outputs} outputs: take one of each, or "
            f"write a two-port"
        )


def _continuous(dt: Any) -> None:
    """SceneError for discrete time; a sampling time of 0, or none at all, is continuous time."""
    if dt is not None and dt != 0:
        raise SceneError(
            f"the system is in discrete time (dt = {dt}): give its continuous-time dynamics "
            f"and, for sampling, the effects "
            "zero-order-hold and delay"
        )


def _quotient(above: Iterable[Any], below: Iterable[Any]) -> Expr:
    """The quotient of two polynomials, from coefficients of the highest power first."""
    top, bottom = (
        Add(*(_number(x) * s**n for n, x in enumerate(reversed([*row])))) for row in (above, below)
    )
    if bottom == 0:
        raise SceneError("the denominator is zero")
    return top / bottom


def _from_roots(roots: Any) -> Expr:
    """The monic polynomial with these roots; SceneError unless they are in conjugate pairs."""
    factors = (
        s - _number(x.real) - I * _number(x.imag) for x in map(complex, np.atleast_1d(roots))
    )
    product = reduce(mul, factors, Integer(1)).expand()
    # Parts are exact decimals, so those of a pair cancel to the last digit, or it is none.
    if product.has(I):
        raise SceneError(
            f"the roots {_shown(np.atleast_1d(roots).tolist())} are not in conjugate pairs"
        )
    return product


def _matrix(given: Any) -> Matrix:
    """A matrix with exact entries, from an array, a list or a number."""
    entries = np.array(given)
    shape = np.atleast_2d(entries).shape
    return Matrix(shape[0], shape[1], [_number(entry) for entry in entries.ravel()])


def _state_space(A: Any, B: Any, C: Any, D: Any) -> Expr:
    """C (sI - A)^-1 B + D, by det(sI - A + BC) = det(sI - A) (1 + C (sI - A)^-1 B)."""
    a, b, c, d = map(_matrix, (A, B, C, D))
    _one_channel(b.shape[1], c.shape[0])
    # Two characteristic polynomials instead of an inverse of a matrix of rational functions.
    below, above = (m.charpoly(s).as_expr() for m in (a, a - b * c))
    return d[0, 0] + (above - below).expand() / below


def _number(given: Any) -> Expr:
    """An exact number, or an expression in parameters; of a complex number, its real part if that
    is all."""
    if isinstance(given, complex | np.complexfloating):
        if given.imag != 0:
            raise SceneError(f"{given} is complex: give real coefficients")
        given = given.real
    return constant(given)


# Out.


def _fraction(system: System) -> tuple[list[Expr], list[Expr]]:
    """Numerator and denominator in lowest terms, the highest power first, scaled as doubles keep it
    best."""
    # The ring has a variable for each function, as exp(-s tau), that is not rational in s. Common
    # factors are cancelled first: a delay that cancels is no hindrance.
    expression = dynamics(system)
    ring = Ring.of([expression])
    function = ring.convert(expression).reduced()
    for index, other in enumerate(ring.functions, ring.size):
        if degree_in([function.numerator, function.denominator], index):
            raise SceneError(
                f"{other} is not rational in s: only rational dynamics can be exported (a "
                f"delay as the effect pade-delay)"
            )
    # Monic where doubles keep that: 1/3 is no double, and with integer coefficients instead the
    # exported system may be exactly this one.
    monic, whole = (_coefficients(ring, f) for f in (function, function.cleared()))
    return whole if not _kept(monic) and _kept(whole) else monic


def _coefficients(
    ring: PolynomialRing, function: RationalFunction
) -> tuple[list[Expr], list[Expr]]:
    """The coefficients of numerator and denominator, the highest power first."""
    above, below = (ring.coefficients(p)[::-1] for p in (function.numerator, function.denominator))
    return above, below


def _kept(rows: tuple[list[Expr], list[Expr]]) -> bool:
    """Whether each coefficient is exactly what its nearest double is written as."""
    return all(x.is_Rational and decimal(str(float(x))) == x for row in rows for x in row)


def _floats(system: System) -> tuple[list[float], list[float]]:
    """The coefficients of numerator and denominator as the nearest doubles; SceneError for
    symbols."""
    above, below = _fraction(system)
    symbols = sorted({x.name for e in [*above, *below] for x in e.free_symbols})
    if symbols:
        raise SceneError(
            f"{', '.join(symbols)} {'is a symbol' if len(symbols) == 1 else 'are symbols'}: "
            f"give values"
        )
    return [float(ExactNumber(x)) for x in above], [float(ExactNumber(x)) for x in below]


def _package(module: str, name: str) -> ModuleType:
    """A package that is optional; SceneError with its name where it is not installed."""
    try:
        return import_module(module)
    except ImportError:
        raise SceneError(f"{name} is not installed: pip install it") from None


def _shown(given: object) -> str:
    """What was given, as text of at most 60 characters."""
    text = str(given)
    return f"{text[:60]}..." if len(text) > 60 else text
