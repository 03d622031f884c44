"""A controller with a clock: what an environment becomes when it is rendered as a difference equation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeAlias

from sympy import Expr, Integer, Symbol, exp

from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import PolynomialRing, RationalFunction, s
from haptisym.model.catalogue import Effect, Environment, Matrix

SAMPLED_LOOP, HOLD = "sampled-loop", "zero-order-hold"
CLOCKS = (SAMPLED_LOOP, HOLD)
BACK = Symbol("z_back")
"""1/z, what is one sample old."""

_METHODS = {
    "backward-difference": lambda T: (1 - BACK) / T,
    "tustin": lambda T: 2 * (1 - BACK) / (T * (1 + BACK)),
    "forward-difference": lambda T: (1 - BACK) / (T * BACK),
}
METHODS = tuple(_METHODS)

Effects: TypeAlias = Sequence[Effect]


def discretised(H: Expr, T: Expr, method: str) -> RationalFunction:
    """D(z) = H(s(z)) in lowest terms, a quotient of polynomials in 1/z.

    SceneError where H is not rational in s, and where D needs samples of the future.

    >>> discretised(3 + 2 * s, Integer(1), "backward-difference").expression()
    5 - 2*z_back
    >>> discretised(2 * s, Integer(1), "forward-difference")
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: forward-difference makes D(z) improper: it would need samples of the future
    """
    given = H.xreplace({s: _METHODS[method](T)})
    ring = PolynomialRing(BACK, given.free_symbols - {BACK})
    try:
        found = ring.convert(given).reduced()
    except SceneError:
        raise SceneError(f"a difference equation needs dynamics that are rational in s: {H} is not") from None
    if found.denominator.subs({0: 0}).is_zero():
        raise SceneError(f"{method} makes D(z) improper: it would need samples of the future")
    return found


def controller(effect: Effect) -> RationalFunction:
    """D(z) of a sampled loop that stands in a scene, with its delay, in numbers where its parameters have them."""
    assert effect.renders
    T = effect.parameters[0].value
    D = discretised(effect.renders.H, T, str(effect.setting("method")))
    return (D * D.ring.function(D.ring.variable) ** samples(effect)).reduced()


def samples(effect: Effect) -> int:
    """The whole samples that a sampled loop computes for."""
    return int(effect.setting("delay"))


def in_place(effects: Iterable[Effect], rendered: Environment) -> tuple[Effect, ...]:
    """The effects of a scene, a sampled loop among them rendering that environment.

    SceneError where it is not the first effect, where another clock stands behind it, and where it cannot render that.
    """
    listed = tuple(effects)
    at = next((i for i, effect in enumerate(listed) if effect.model == SAMPLED_LOOP), None)
    if at is None:
        return listed
    first, *others = listed[at:]
    for other in (x for x in (*others, *listed[:at]) if x.model in CLOCKS):
        raise SceneError(
            f"effects.{other.name}: a second clock beside {first.name}: with a {SAMPLED_LOOP} there is no other clock"
        )
    if at:
        raise SceneError(
            f"effects.{first.name}: a {SAMPLED_LOOP} must be the first effect: its controller renders the environment itself"
        )
    try:
        placed = replace(first, renders=rendered, dynamics=_matrix(first, rendered))
    except SceneError as error:
        raise error.within(f"effects.{first.name}") from None
    return placed, *others


def _matrix(effect: Effect, rendered: Environment) -> Matrix:
    """Between what would be rendered without a clock and what is: D - H beside it, then delay and hold."""
    T = effect.parameters[0].symbol
    D = discretised(rendered.dynamics, T, str(effect.setting("method"))).expression().xreplace({BACK: exp(-s * T)})
    G = exp(-s * T * samples(effect)) * (1 - exp(-s * T)) / (s * T)
    return G, G * (D - rendered.dynamics), Integer(0), Integer(1)
