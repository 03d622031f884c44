"""Llewellyn's criterion as a whole: its conditions on the axis at all frequencies, and those on the poles of the two-port."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Integer

from haptisym.judge.passivity import has_no_pole_right, most_charted, poles_allow
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.model.distortion import Distortion
from haptisym.verbs.metrics.judging import LLEWELLYN
from haptisym.verbs.metrics.twoport import TwoPort


@dataclass(frozen=True)
class Unconditional:
    """``axis`` : whether the conditions hold at every frequency. ``poles`` : whether h11, h22 and h12 h21 have none in
    Re s > 0, and h11 and h22 on the axis simple ones with positive residues alone. None where not decided."""

    axis: bool | None
    poles: bool | None

    @property
    def holds(self) -> bool | None:
        """Whether the two-port is absolutely stable: with every passive hand and every passive environment."""
        if self.axis is False or self.poles is False:
            return False
        return True if self.axis and self.poles else None


def unconditional(d: Distortion, port: TwoPort) -> Unconditional:
    """Llewellyn's criterion for the chain of a display; nothing is decided where D = 0."""
    return Unconditional(_on_axis(d, port), _poles(port))


def _on_axis(d: Distortion, port: TwoPort) -> bool | None:
    if port.least is None:
        return None
    functions = {x: x.function(d) for x in LLEWELLYN}
    high: Expr = Integer(1)
    try:
        for f in functions.values():
            assert isinstance(f, RealFunction)  # none is about a threshold
            beyond = far(f.axis.function(f.function.numerator * f.function.denominator))
            if beyond.sense is Sense.BOTH or (beyond.sense is Sense.POSITIVE and not f.is_zero):
                return False
            if beyond.sense is Sense.UNKNOWN:
                return None
            high = beyond.radius if sign_of_number(beyond.radius - high) > 0 else high
        seen = most_charted(d, high)
        points = chart(functions, Integer(0), seen).points
    except UndecidedError:
        return None
    if any(sign > 0 for p in points for sign in p.after.values()):
        return False
    return None if seen != high or any(p.undecided for p in points) else True


def _poles(port: TwoPort) -> bool | None:
    """Of h11 = B/(D s), of h22 = s C/D, and of their product's partner g."""
    least, leak, gain = port.least, port.leak, port.gain
    if least is None or leak is None or gain is None:
        return None
    s = port.ring.function(port.ring.variable)
    found = (poles_allow(least), poles_allow((leak * s * s).reduced()), has_no_pole_right(gain))
    return False if False in found else None if None in found else True
