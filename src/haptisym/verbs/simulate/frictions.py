"""Friction on one velocity in several places: one switch for all of them."""

from __future__ import annotations

from flint import fmpq

from haptisym.verbs.simulate.descriptor import state_space
from haptisym.verbs.simulate.network import Network, SignalSum, Switch


def join_frictions(net: Network) -> None:
    """Make switches of the frictions of a network; those whose velocities are in one ratio (rigid links, levers) stick as one.

    While they stick, any split of the force that holds them fulfils the laws of friction: it is split as the limits are, so that
    all of them reach their limits together.
    """
    first: dict[str, tuple[Switch, int]] = {}
    for friction, (velocity, sign) in zip(net.frictions, _velocities(net), strict=True):
        if not friction.limit:
            net.zero(SignalSum.of(friction.target))
        elif velocity in first:
            leading, way = first[velocity]
            share = fmpq(*friction.limit.as_integer_ratio()) / fmpq(*leading.limit.as_integer_ratio())
            net.equal(SignalSum.of(friction.target), sign * way * share * SignalSum.of(leading.target))
        else:
            first[velocity] = friction, sign
            net.switches.append(friction)


def _velocities(net: Network) -> list[tuple[str, int]]:
    """The velocities in terms of state and inputs, each divided by its first coefficient, as text; and the sign of that."""
    if len(net.frictions) < 2:
        return [(friction.driver, 1) for friction in net.frictions]
    system = state_space(net.equations, [*net.jumps, *(x.target for x in net.frictions)])
    found = []
    for friction in net.frictions:
        row = system.signal(friction.driver)
        numbers = [x for matrix in (row.state, *row.inputs) for x in matrix.entries()]
        head = next((x for x in numbers if x != 0), fmpq(1))
        found.append((str([x / head for x in numbers]), 1 if head > 0 else -1))
    return found
