"""What code computes for a chain: its program, or its closed forms where that would leave limits undefined."""

from __future__ import annotations

from haptisym.kernel.dynamics import on_axis
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.programs.balls import BallPoint
from haptisym.programs.program import Program
from haptisym.programs.stable import closed_program
from haptisym.programs.values import Values


def computed(chain: Chain) -> Program:
    """The fields of ``Values``, in its order: the program that ``compile`` runs, if no value of it is a limit."""
    program = chain.program(Values._fields)
    return program if _has_no_limits(chain, program) else closed(chain)


def closed(chain: Chain) -> Program:
    """The same from the closed forms, in lowest terms."""
    d = Distortion.of(chain)
    dynamics = (d.env.numerator, d.env.denominator, d.perc.denominator)
    factors = [p for polynomial in dynamics for p, _ in d.env.ring.factors(polynomial, in_square=False)[1]]
    return closed_program(d.functions(Values._fields), factors, chain.parameters)


def _has_no_limits(chain: Chain, program: Program) -> bool:
    """Whether all values are values: Re and Im of H_env have no zero in common, and nothing is 0/0 at 0."""
    environment = on_axis(chain.ring.convert(chain.environment).reduced())
    R, X = (part_of(environment, part).function.numerator for part in Part)
    apart = R.is_zero() or X.is_zero() or R.gcd(X).is_constant()
    at_zero = BallPoint(program, (0.0, *(1.25 + n / 8 for n in range(len(program.inputs) - 1))))
    return apart and all(x.is_finite() for x in at_zero.balls(128).values())
