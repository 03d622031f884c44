"""Where everything is when the hand has rested somewhere for long: the state in which a recording begins.

In a stable scene each signal goes, long after a step of the hand, to the step times the limit of its transfer function at
s -> 0. That limit is taken from the equations of motion with a tiny rational s: s = 0 itself would lose what delay lines hold
(a line of wave variables keeps its position error as a constant flow, and no equation without derivatives knows of it).
"""

from __future__ import annotations

from flint import fmpq, fmpq_mat

from haptisym.kernel.errors import SceneError
from haptisym.verbs.simulate.network import MOTION, Exact, Network, SignalKey, SignalSum

_S = fmpq(1, 10**40)
"""1/s. Numbers of the answer are wrong by about as little, relative to the time constants of the scene in s."""


def at_rest(net: Network, position: float) -> dict[str, float]:
    """Every signal of a network while the hand rests at a position, m or rad.

    Clocks let through what they sample, friction gives no force, a limited force is what it is without the limit or the limit,
    and a quantiser counts as exact. Raises SceneError where something moves on though the hand rests.

    >>> net, f, x = Network((1.0, 1.0)), SignalSum.of("f"), SignalSum.of("x")
    >>> net.equal(f, x.through(100, 15)), net.equal(x, SignalSum.of("motion"))
    (None, None)
    >>> at_rest(net, 0.5)["f"]
    50.0
    """
    ratios = _ratios(net)
    values = {name: position * _float(ratio) for name, ratio in ratios.items()}
    if not all(abs(value) < 1e15 for value in values.values()):
        raise SceneError("motion: it begins away from 0, where the scene does not come to rest; begin it at 0")
    return values


def _ratios(net: Network) -> dict[str, Exact]:
    """Each signal as a fraction of the hand's position."""
    held = [
        SignalSum.of(x.target) - SignalSum.of(x.source).late(fmpq(*x.period.as_integer_ratio()) / 2) for x in net.holds
    ]
    passed = [*held, *(SignalSum.of(x.target) - SignalSum.of(x.source) for x in net.steps)]
    switched = [switch.closed if switch.offset else SignalSum.of(switch.target) for switch in net.switches]
    equations = [*net.equations, *passed, *switched]
    names = list(dict.fromkeys(name for equation in equations for name, _, _ in equation.terms if name != MOTION))
    if len(equations) != len(names):
        raise SceneError("the effects do not determine the motion")
    place = {name: i for i, name in enumerate(names)}
    left, right = fmpq_mat(len(names), len(names)), fmpq_mat(len(names), 1)
    for row, equation in enumerate(equations):
        for key, value in equation.terms.items():
            if key[0] == MOTION:
                right[row, 0] -= value * _factor(key)
            else:
                left[row, place[key[0]]] += value * _factor(key)
    try:
        found = left.solve(right)
    except ZeroDivisionError:
        raise SceneError("motion: it begins away from 0, where the scene has no state of rest; begin it at 0") from None
    return {MOTION: fmpq(1), **{name: found[i, 0] for name, i in place.items()}}


def _factor(key: SignalKey) -> Exact:
    """s^n exp(-s lag) at the tiny s; three terms of the series are exact enough, as s^2 is 1e-80."""
    _, order, lag = key
    turned = _S * lag
    return _S**order * (1 - turned + turned * turned / 2)


def _float(number: Exact) -> float:
    return int(number.p) / int(number.q)
