"""The steps that code takes for a chain: its program, or its closed forms where that would leave limits undefined."""

from __future__ import annotations

from sympy import Integer, Rational

from haptisym.kernel.response import on_axis
from haptisym.kernel.symbols import omega
from haptisym.model.distortion import Chain, part_of
from haptisym.model.jnd import Part
from haptisym.programs.closed import closed_program
from haptisym.programs.steps import Steps, code_steps
from haptisym.programs.values import Values


def chain_steps(chain: Chain) -> Steps:
    """The fields of ``Values``, in its order: by the program that ``compile`` runs, if no value of it is a limit.

    >>> from haptisym.effects import first_order_lag
    >>> from haptisym.environments import kelvin_voigt
    >>> from haptisym.model.distortion import distort
    >>> steps = chain_steps(distort(kelvin_voigt(100, 2), first_order_lag(20)).chain)
    >>> steps.at({omega: Integer(10)})["relative_real"], steps.operations < 40
    (-1/5, True)
    """
    steps = code_steps(chain.program(Values._fields))
    return steps if _has_no_limits(chain, steps) else closed_steps(chain)


def closed_steps(chain: Chain) -> Steps:
    """The same from the closed forms, in lowest terms."""
    d = chain.distortion()
    dynamics = (d.env.numerator, d.env.denominator, d.perc.denominator)
    factors = [p for polynomial in dynamics for p, _ in d.env.ring.factors(polynomial, in_square=False)[1]]
    return code_steps(closed_program(d.functions(Values._fields), factors, chain.parameters))


def _has_no_limits(chain: Chain, steps: Steps) -> bool:
    """Whether all values are values: Re and Im of H_env have no zero in common, and nothing is 0/0 at 0."""
    environment = on_axis(chain.ring.convert(chain.environment).reduced())
    R, X = (part_of(environment, part).function.numerator for part in Part)
    apart = R.is_zero() or X.is_zero() or R.gcd(X).is_constant()
    known = {x: Rational(n + 7, 5) for n, x in enumerate(sorted(steps.free_symbols - {omega}, key=str))}
    return apart and all(x.is_finite for x in steps.at({**known, omega: Integer(0)}).values())
