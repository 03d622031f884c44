"""Friction on one velocity in several places: one switch for all of them."""

from __future__ import annotations

from flint import fmpq

from .descriptor import state_space
from .network import Network, Sum, Switch


def join_frictions(net: Network) -> None:
    """Make switches of the frictions of a network; those that rub on one velocity stick and slip as one.

    While they stick, any split of the force that holds them fulfils the laws of friction: it is split as the limits are, so that
    all of them reach their limits together.
    """
    velocities, first = _velocities(net), dict[str, Switch]()
    for friction, velocity in zip(net.frictions, velocities, strict=True):
        if not friction.limit:
            net.zero(Sum.of(friction.target))
        elif velocity in first:
            share = fmpq(*friction.limit.as_integer_ratio()) / fmpq(*first[velocity].limit.as_integer_ratio())
            net.equal(Sum.of(friction.target), share * Sum.of(first[velocity].target))
        else:
            first[velocity] = friction
            net.switches.append(friction)


def _velocities(net: Network) -> list[str]:
    """The velocities in terms of state and inputs: the same text for the same velocity."""
    if len(net.frictions) < 2:
        return [friction.driver for friction in net.frictions]
    system = state_space(net.equations, [*net.jumps, *(x.target for x in net.frictions)])
    rows = [system.signal(friction.driver) for friction in net.frictions]
    return [f"{row.state.tolist()} {[c.tolist() for c in row.inputs]}" for row in rows]
