"""The largest root of a loop with a clock, as rate and frequency of the motion that lasts longest."""

from __future__ import annotations

import flint
from flint import acb, acb_poly, arb

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import expression_ball
from haptisym.model.hand import Hand
from haptisym.model.scene import Scene
from haptisym.verbs.simulate.rightmost import Rightmost
from haptisym.verbs.stability.clocked import loop_of

_BITS = 256
_TINY = 1e-12


def clocked_root(scene: Scene, hand: Hand) -> Rightmost | None:
    """ln z/T of the largest root z, all of them being enclosed; None where that loop is not known."""
    try:
        loop = loop_of(scene, hand)
        if any(loop.hidden):
            return None
        with flint.ctx.workprec(_BITS):
            found = acb_poly(loop.balls()).roots(tol=arb(2) ** -100, maxprec=8 * _BITS)
            T = expression_ball(loop.T)
            rows = [(-w.log() / T) for w in found if abs(w) > _TINY]  # w = 1/z
    except (UndecidedError, ValueError):
        return None
    if not rows:
        return None
    rows.sort(key=lambda s: -float(s.real.mid()))
    first = next(s for s in rows if not s.real < rows[0].real)
    # an isolated root near the real axis is real, as its conjugate is a root too
    upper = acb(first.real) if first.imag.contains(0) else acb(first.real, abs(first.imag))
    apart = all(s.real < first.real or s.real.overlaps(first.real) for s in rows)
    return Rightmost(complex(upper.mid()), upper, certified=apart, others=tuple(complex(s.mid()) for s in rows))
