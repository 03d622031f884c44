"""For which values of one parameter every passive hand may hold a sampled loop: Colgate and Schenkel's condition, exactly.

The damping that a device has left over is rational in tan(theta/2) and the parameter. It can become 0 at some angle, or the
controller's poles can reach the unit circle, at roots of resultants and discriminants alone, and the stiffness at rest at roots
of its numerator; between these one verdict tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import flint
from flint import arb
from sympy import Expr, Integer, pi

from haptisym.judge.colgate import SampledPassivity, loop_of, sampled_passivity
from haptisym.judge.criteria import PASSIVE
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.require.criticalvalues import allowed, critical, missing, real_roots, zeros_of
from haptisym.verbs.require.feasible import Binding, Kind, Solved
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.passive import turns_of_poles
from haptisym.verbs.require.verdicts import Question, Turn

_BITS, _PIECES, _MOST_PIECES = 256, 16, 2000


def solve_sampled(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values with which every passive hand may hold it. UndecidedError where the condition does not apply."""
    if free.is_of_hand or free.parts:
        return Question([], lambda _: sampled_verdict(scene), asked, closed=True).solve()
    loop = loop_of(scene.with_values({free.path: free.symbol}))
    if isinstance(loop, SampledPassivity):
        raise UndecidedError(f"whether every passive hand may hold it: {loop.reason}")
    ring = Ring.of([loop.T, loop.C, loop.damping])
    if ring.functions:
        raise UndecidedError("whether every passive hand may hold it, with a delay that is free beside a clock")
    margins = [RealFunction((f.axis.convert(loop.damping) - f.function).reduced()) for f in loop.sides(ring)]
    turns = [*_of_margins(margins, free), *turns_of_poles(ring.convert(loop.C).reduced(), free)]
    at_rest = loop.at_rest(ring)[1]
    if at_rest.has(free.symbol):
        turns += [Turn(x, (Binding(PASSIVE, None, Kind.START),)) for x in zeros_of(at_rest, free.symbol)]
    for held in (loop.mass, loop.stiffness, loop.damping):  # of a device they may be negative
        turns += [Turn(x, ()) for x in zeros_of(held, free.symbol)] if held.has(free.symbol) else []

    def verdict(value: Expr) -> bool | None:
        return sampled_verdict(free.put(scene, value))

    return Question(
        turns, verdict, asked, closed=False, spares=lambda x: _is_positive(margins, free, x.value),
        exists=lambda x: allowed(scene, free, x), gone=missing(scene, free),
    ).solve()  # fmt: skip


def sampled_verdict(scene: Scene) -> bool | None:
    """Of a scene with numbers. UndecidedError with the reason where the condition does not apply."""
    found = sampled_passivity(scene)
    assert found is not None
    if found.passive is None:
        raise UndecidedError(f"whether every passive hand may hold it: {found.reason}")
    return found.passive


def _of_margins(margins: Sequence[RealFunction], free: Knob) -> Iterator[Turn]:
    """Where the damping that is left over becomes 0 at some angle, or begins to have a pole there."""
    for margin, start in zip(margins, (Kind.START, Kind.FAR), strict=True):
        if free.symbol not in margin.axis.meanings:
            continue
        index = margin.axis.meanings.index(free.symbol)
        for reason, polynomial in critical(PASSIVE, [margin], (Integer(0), Integer(1))):
            kind = start if reason and reason[1] is Kind.START else Kind.TOUCH
            for factor, _ in polynomial.factor()[1] if polynomial else ():
                for value in real_roots(factor, index, negative=True):
                    yield Turn(value, (Binding(PASSIVE, None, kind),))


def _is_positive(margins: Sequence[RealFunction], free: Knob, value: RealNumber) -> bool:
    """Whether damping is left over at all angles, proven, at a value that is known by balls."""
    with flint.ctx.workprec(_BITS):
        known = {free.symbol: value.ball(_BITS), pi: arb.pi()}
        waiting = [(f, arb(k) / _PIECES, arb(k + 1) / _PIECES) for f in margins for k in range(_PIECES)]
        looked = 0
        while waiting:
            f, low, high = waiting.pop()
            looked += 1
            if looked > _MOST_PIECES:
                return False
            at = known | {f.axis.meanings[0]: low.union(high)}
            above, below = (f.axis.ball(x, at) for x in (f.function.numerator, f.function.denominator))
            if not above * below > 0:
                middle = (low + high) / 2
                waiting += [(f, low, middle), (f, middle, high)]
        return True
