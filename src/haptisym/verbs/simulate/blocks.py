"""The catalogue once more, as equations of motion: what each environment and each effect does to force and motion in time.

Every function adds the equations of one element to a ``Network``. They are written from the physics (springs, masses,
delay lines, clocks, sliding friction), not from the chain matrices, which they are there to check. ``near`` and ``far`` are
the ports towards the environment and towards the hand, each with force ``F`` and displacement ``X``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple, TypeAlias

from flint import fmpq
from sympy import pi

from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment, Model
from haptisym.model.devices import device
from haptisym.model.sampled import controller
from haptisym.verbs.simulate.network import Exact, Hold, Network, SignalSum, Switch, exact, name_of
from haptisym.verbs.simulate.operators import combined, fractional, quotient

ExactValues: TypeAlias = Mapping[str, Exact]


class Port(NamedTuple):
    """A place between two elements."""

    F: SignalSum
    X: SignalSum


def build_environment(net: Network, environment: Environment, port: Port) -> None:
    """Add the equations of an environment that is felt at a port."""
    net.built.append(environment.model)
    ours = _ENVIRONMENTS.get(environment.model) if _is_ours(ENVIRONMENTS, environment.model) else None
    with _named(environment.model):
        (ours or _written)(net, environment, port)


def build_effect(net: Network, effect: Effect, near: Port, far: Port) -> None:
    """Add the equations of an effect between two ports; those of a user's own model follow from its chain matrix."""
    net.built.append(effect.model)
    ours = _EFFECTS.get(effect.model) if _is_ours(EFFECTS, effect.model) else None
    if ours is None:
        net.foreign.append(effect.name)
    with _named(effect.name):
        (ours or _two_port)(net, effect, near, far)


def _is_ours(catalogue: Mapping[str, Model], model: str) -> bool:
    """Whether a model is the package's own, not one that a user has entered, perhaps under the same name."""
    return model in catalogue and catalogue[model].build.__module__.startswith(__name__.partition(".")[0] + ".")


@contextmanager
def _named(element: str) -> Iterator[None]:
    try:
        yield
    except SceneError as error:
        raise error.within(element) from None


def _values(element: Environment | Effect) -> dict[str, Exact]:
    return {parameter.key: exact(parameter.value) for parameter in element.parameters}


def _msd(p: ExactValues, x: SignalSum) -> SignalSum:
    return x.through(p.get("k", fmpq(0)), p.get("b", fmpq(0)), p.get("m", fmpq(0)))


# Environments


def _mass_spring_damper(net: Network, element: Environment, port: Port) -> None:
    net.equal(port.F, _msd(_values(element), port.X))


def _branch(net: Network, k: Exact, b: Exact, x: SignalSum) -> SignalSum:
    """The force of a spring and a damper in a row: their velocities add up to that of x."""
    force = net.signal("branch")
    net.equal(force.through(1 / b, 1 / k), x.d())
    return force


def _maxwell(net: Network, element: Environment, port: Port) -> None:
    p = _values(element)
    net.equal(port.F, _branch(net, p["k"], p["b"], port.X))


def _zener(net: Network, element: Environment, port: Port) -> None:
    p = _values(element)
    net.equal(port.F, p["k0"] * port.X + _branch(net, p["k1"], p["b1"], port.X))


def _prony(net: Network, element: Environment, port: Port) -> None:
    p = _values(element)
    total, count = p["k0"] * port.X, sum(key.startswith("k[") for key in p)
    for i in range(1, count + 1):
        total = total + _branch(net, p[f"k[{i}]"], p[f"b[{i}]"], port.X)
    net.equal(port.F, total)


def _spring_pot(net: Network, element: Environment, port: Port) -> None:
    p = _values(element)
    net.equal(port.F, p.get("k", fmpq(0)) * port.X + p["k_alpha"] * fractional(net, port.X, p["alpha"]))


def _two_mass(net: Network, element: Environment, port: Port) -> None:
    p, hanging = _values(element), net.signal("hanging-mass")
    stretch = port.X - hanging
    pull = stretch.through(p["k2"], p["b2"])
    net.equal(p["m2"] * hanging.d(2), pull)
    net.equal(port.F, port.X.through(p["k1"], p["b1"], p["m1"]) + pull)


def _written(net: Network, element: Environment, port: Port) -> None:
    quotient(net, element.H, port.X, port.F)


# Formulas


# Effects


def _series(net: Network, element: Effect, near: Port, far: Port) -> None:
    net.equal(far.X, near.X)
    quotient(net, element.matrix[0], near.F, far.F)


def _first_order_lag(net: Network, element: Effect, near: Port, far: Port) -> None:
    omega_c = _values(element)["omega_c"]
    net.equal(far.X, near.X)
    net.equal(far.F.d(), omega_c * (near.F - far.F))


def _second_order_lowpass(net: Network, element: Effect, near: Port, far: Port) -> None:
    p = _values(element)
    net.equal(far.X, near.X)
    net.equal(far.F.through(p["omega_n"] ** 2, 2 * p["zeta"] * p["omega_n"], 1), p["omega_n"] ** 2 * near.F)


def _delay(net: Network, element: Effect, near: Port, far: Port) -> None:
    net.equal(far.X, near.X)
    net.equal(far.F, near.F.late(_values(element)["tau"]))


def _zero_order_hold(net: Network, element: Effect, near: Port, far: Port) -> None:
    net.equal(far.X, near.X)
    net.holds.append(Hold(name_of(near.F), name_of(far.F), float_of(_values(element)["T"]), element.name))


def build_controller(net: Network, effect: Effect, port: Port) -> None:
    """Add a sampled controller in the place of the environment that it renders: its difference equation, between samples held."""
    sampled, force = net.signal("sampled"), net.signal("computed")
    T = _values(effect)["T"]
    net.holds.append(Hold(name_of(port.X), name_of(sampled), float_of(T), effect.name))
    D = controller(effect)
    net.equal(_samples_ago(D.denominator, force, T), _samples_ago(D.numerator, sampled, T))
    net.equal(port.F, force)


def _samples_ago(polynomial: Polynomial, x: SignalSum, T: Exact) -> SignalSum:
    """A polynomial in 1/z, applied to a signal that changes with the clock alone."""
    total = SignalSum({})
    for (n, power_of_pi, *_), coefficient in polynomial.to_dict().items():
        total = total + coefficient * exact(pi) ** int(power_of_pi) * x.late(int(n) * T)
    return total


def _sampled_loop(net: Network, element: Effect, near: Port, far: Port) -> None:
    net.equal(far.X, near.X)
    net.equal(far.F, near.F)


def _shunt(net: Network, element: Effect, near: Port, far: Port) -> None:
    net.equal(far.X, near.X)
    beside = net.signal("beside")
    if own := device(element):
        net.equal(beside, near.X.through(*map(exact, own)))
    else:
        quotient(net, element.matrix[1], near.X, beside)
    net.equal(far.F, near.F + beside)


def _compliance(net: Network, element: Effect, near: Port, far: Port) -> None:
    p = _values(element)
    net.equal(far.F, near.F)
    net.equal(near.F, (far.X - near.X).through(p.get("k", fmpq(0)), p.get("b", fmpq(0))))


def _coulomb_friction(net: Network, element: Effect, near: Port, far: Port) -> None:
    force, velocity = net.signal("friction"), net.signal("velocity")
    net.equal(far.X, near.X)
    net.equal(far.F, near.F + force)
    net.equal(velocity, near.X.d())
    limit = float_of(_values(element)["force"])
    net.frictions.append(Switch(name_of(force), velocity, name_of(velocity), limit, 0.0, element.name))


def _admittance_display(net: Network, element: Effect, near: Port, far: Port) -> None:
    net.equal(far.X, near.X)
    quotient(net, 1 / element.matrix[0], far.F, near.F)  # what the hand's force is to the rendered one


def _wave_variables(net: Network, element: Effect, near: Port, far: Port) -> None:
    p = _values(element)
    outward, inward = net.signal("outward-wave"), net.signal("inward-wave")
    net.equal(inward, far.F + p["b"] * far.X.d())
    net.equal(outward, near.F - p["b"] * near.X.d())
    net.equal(near.F + p["b"] * near.X.d(), inward.late(p["tau"]))
    net.equal(far.F - p["b"] * far.X.d(), outward.late(p["tau"]))


def _position_force(net: Network, element: Effect, near: Port, far: Port) -> None:
    p, tau = _values(element), _values(element).get("tau", fmpq(0))
    control = (far.X.late(tau) - near.X).through(p["Ks"], p["Bs"])
    net.equal(p["Ms"] * near.X.d(2), control - near.F)
    net.equal(far.F, p["Mm"] * far.X.d(2) + near.F.late(tau))


def _position_position(net: Network, element: Effect, near: Port, far: Port) -> None:
    p, tau = _values(element), _values(element).get("tau", fmpq(0))
    net.equal(p["Ms"] * near.X.d(2), (far.X.late(tau) - near.X).through(p["Ks"], p["Bs"]) - near.F)
    net.equal(far.F, p["Mm"] * far.X.d(2) + (far.X - near.X.late(tau)).through(p["Km"], p["Bm"]))


def _four_channel(net: Network, element: Effect, near: Port, far: Port) -> None:
    p, tau = _values(element), _values(element).get("tau", fmpq(0))
    master, slave = (p["Km"], p["Bm"], p["Mm"]), (p["Ks"], p["Bs"], p["Ms"])
    to_slave, to_master = net.signal("to-slave"), net.signal("to-master")
    net.equal(to_slave, far.F + far.X.through(*slave))
    net.equal(to_master, near.F - near.X.through(*master))
    net.equal(near.X.through(*slave), to_slave.late(tau) - near.F)
    net.equal(far.F, far.X.through(*master) + to_master.late(tau))


def _two_port(net: Network, element: Effect, near: Port, far: Port) -> None:
    for row, signal in ((element.matrix[:2], far.F), (element.matrix[2:], far.X)):
        combined(net, row, near, signal)


def float_of(number: Exact) -> float:
    """The nearest float."""
    return int(number.p) / int(number.q)


_ENVIRONMENTS: dict[str, Callable[[Network, Environment, Port], None]] = {
    "mass-spring-damper": _mass_spring_damper,
    "kelvin-voigt": _mass_spring_damper,
    "maxwell": _maxwell,
    "zener": _zener,
    "prony": _prony,
    "spring-pot": _spring_pot,
    "two-mass": _two_mass,
}
_EFFECTS: dict[str, Callable[[Network, Effect, Port, Port], None]] = {
    "first-order-lag": _first_order_lag,
    "second-order-lowpass": _second_order_lowpass,
    "delay": _delay,
    "pade-delay": _series,
    "sampled-loop": _sampled_loop,
    "zero-order-hold": _zero_order_hold,
    "series": _series,
    "shunt": _shunt,
    "compliance": _compliance,
    "coulomb-friction": _coulomb_friction,
    "admittance-display": _admittance_display,
    "wave-variables": _wave_variables,
    "position-force-teleoperator": _position_force,
    "position-position-teleoperator": _position_position,
    "four-channel-teleoperator": _four_channel,
    "two-port": _two_port,
}
