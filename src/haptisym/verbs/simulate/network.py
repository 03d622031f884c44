"""The catalogue once more, from the physics: equations of motion in named signals, with exact
coefficients.

A ``Network`` is what a scene becomes before it is simulated: equations between signals, each a
``SignalSum`` of derivatives and delays that equals zero, and the elements that no linear equation
describes (``Hold``, ``Switch``, ``Step``). Nothing here is a transfer function of the whole: every
block adds its own equations, and only those of blocks that the scene names are ever made.
They are written from springs, masses, delay lines, clocks and sliding friction, not from the chain
matrices, which they are there to check. ``near`` and ``far`` are the ports towards the environment
and towards the hand, each with force ``F`` and displacement ``X``.

*Fractional order.* s^alpha is a bank of first-order relaxations: no history to carry along. In
s^(alpha-1) = sin(pi alpha)/pi * integral of lambda^(alpha-1)/(s + lambda) over lambda > 0, with
lambda = e^y, the integrand is analytic in a strip, so that the trapezoidal rule converges
exponentially (relative error about exp(-pi^2/step) on the imaginary axis). What lies below the
slowest and beyond the fastest relaxation is a spring and a damper, whose strengths are geometric
series and therefore known exactly.

*Rest.* In a stable scene each signal goes, long after a step of the hand, to the step times the
limit of its transfer function at s -> 0. That limit is taken from the equations of motion with a
tiny rational s: s = 0 itself would lose what delay lines hold (a line of wave variables keeps its
position error as a constant flow, and no equation without derivatives knows of it).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from math import ceil, floor, log, sin
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat
from sympy import Expr, I, Rational, exp, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, within
from haptisym.kernel.rings import Polynomial
from haptisym.model.catalogue import (
    EFFECTS,
    ENVIRONMENTS,
    Effect,
    Environment,
    Model,
    controller,
    device,
)
from haptisym.programs.values import Array

Exact: TypeAlias = fmpq
SignalKey: TypeAlias = tuple[str, int, fmpq]
"""The key of a term: a signal's name, how often it is differentiated, and its delay, s."""

MOTION = "motion"
"""The prescribed motion of the hand, the one signal that is known beforehand."""

# Equations are solved over the rational numbers, so pi must be one: 80 digits, far beyond floats.
_PI = Rational("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")
_ZERO = fmpq(0)


def exact(value: Expr | int) -> Exact:
    """Return an exact number of a scene as a rational; pi is cut after 80 digits, everywhere in
    the same way, so that it still cancels."""
    number = Rational(value) if isinstance(value, int) else Rational(value.xreplace({pi: _PI}))
    return fmpq(int(number.p), int(number.q))


@dataclass(frozen=True, slots=True, eq=False)
class SignalSum:
    """A linear combination of signals, of their derivatives and of delayed signals.

    >>> x = SignalSum.of("x")
    >>> (2 * x.d(2) - x.late(fmpq(1, 2))).terms == {("x", 2, fmpq(0)): 2, ("x", 0, fmpq(1, 2)): -1}
    True
    """

    terms: Mapping[SignalKey, Exact]

    @classmethod
    def of(cls, name: str) -> SignalSum:
        """Return one signal as a sum."""
        return cls({(name, 0, _ZERO): fmpq(1)})

    def __add__(self, other: SignalSum) -> SignalSum:
        merged = dict(self.terms)
        for key, value in other.terms.items():
            merged[key] = merged.get(key, _ZERO) + value
        return SignalSum({key: value for key, value in merged.items() if value != 0})

    def __rmul__(self, factor: Exact | int) -> SignalSum:
        return SignalSum({key: factor * value for key, value in self.terms.items() if factor != 0})

    def __neg__(self) -> SignalSum:
        return -1 * self

    def __sub__(self, other: SignalSum) -> SignalSum:
        return self + -other

    def renamed(self, old: tuple[str, Exact], new: tuple[str, Exact]) -> SignalSum:
        """Replace a signal, late by a time, by another signal and time; both are given as (name,
        lag)."""
        both = {old: new}
        each = (
            (both.get((name, x), (name, x)), k, value) for (name, k, x), value in self.terms.items()
        )
        return SignalSum({(name, k, x): value for (name, x), k, value in each})

    def d(self, times: int = 1) -> SignalSum:
        """The derivative with respect to time, that many times."""
        return SignalSum(
            {(name, order + times, lag): value for (name, order, lag), value in self.terms.items()}
        )

    def late(self, tau: Exact) -> SignalSum:
        """Return the sum delayed by ``tau`` seconds."""
        return SignalSum(
            {(name, order, lag + tau): value for (name, order, lag), value in self.terms.items()}
        )

    def through(self, *coefficients: Exact | int) -> SignalSum:
        """Return c0 x + c1 dx/dt + c2 d2x/dt2 + ... for the coefficients c0, c1, ..."""
        total = SignalSum({})
        for order, coefficient in enumerate(coefficients):
            total = total + coefficient * self.d(order)
        return total


@dataclass(frozen=True)
class Hold:
    """A clock that samples ``source`` every ``T`` seconds, rounded to ``resolution``, and holds on
    ``target`` what it computes.

    sum of below_i target(n - i) = sum of above_i source(n - i), for the n-th sample.
    """

    source: str
    target: str
    T: Exact
    name: str
    resolution: float = 0.0
    above: tuple[Exact, ...] = (fmpq(1),)
    below: tuple[Exact, ...] = (fmpq(1),)

    @cached_property
    def period(self) -> float:
        """The period T as a float, s."""
        return float_of(self.T)

    @cached_property
    def _weights(self) -> tuple[list[tuple[int, float]], ...]:
        """Weights of samples and of held values, each as (1 + periods ago, weight), without those
        that are 0."""
        # Solved for the newest held value: the difference equation divided by its coefficient. The
        # division is exact; the floats are rounded once.
        first = self.below[0]
        rows = self.above, (fmpq(0), *self.below[1:])
        scaled = ([x / first for x in row] for row in rows)
        return tuple([(n + 1, float_of(x)) for n, x in enumerate(row) if x != 0] for row in scaled)

    def read(self, value: float) -> float:
        """Return a value as it is sampled: a whole multiple of the resolution, or the value
        itself."""
        return (
            self.resolution * float(np.rint(value / self.resolution)) if self.resolution else value
        )

    def computed(self, samples: Sequence[float], given: Sequence[float]) -> float:
        """Return the value to hold after these samples, and after the values that were held
        before."""
        above, below = self._weights
        return sum(x * samples[-n] for n, x in above) - sum(x * given[1 - n] for n, x in below)

    def equation(self, source: SignalSum) -> SignalSum:
        """Return a sum that is zero where the difference equation runs in continuous time, each
        period a delay: what a clock comes to where its source hardly changes."""
        total = SignalSum({})
        for coefficients, signal in (
            (self.below, SignalSum.of(self.target)),
            (self.above, -source),
        ):
            for n, coefficient in enumerate(coefficients):
                total = total + coefficient * signal.late(n * self.T)
        return total


@dataclass(frozen=True)
class Switch:
    """A force that is ``+limit`` or ``-limit`` or, in between, whatever keeps ``closed`` zero.

    Coulomb friction: ``closed`` is the velocity, and the force holds it at zero (stick) until it
    reaches the limit.
    Saturation: ``closed`` is input minus output, and beyond the limit the output stays there.
    ``driver`` is the signal whose sign keeps the switch open: the velocity, or the input beyond its
    limit.
    """

    target: str
    closed: SignalSum
    driver: str
    limit: float
    offset: float
    """What the magnitude of the driver must exceed to keep the switch open: 0 for friction, the
    limit for saturation."""
    name: str


@dataclass(frozen=True)
class Step:
    """A quantiser: ``target`` is ``source`` rounded to whole multiples of ``resolution``."""

    source: str
    target: str
    resolution: float
    name: str


Element: TypeAlias = Hold | Switch | Step


@dataclass
class Network:
    """Equations and elements as the blocks of a scene add them; ``known`` are the signals that
    elements set."""

    span: tuple[float, float]
    """The frequencies, rad/s, that the motion holds: a fractional derivative is built for them."""
    equations: list[SignalSum] = field(default_factory=list)
    holds: list[Hold] = field(default_factory=list)
    switches: list[Switch] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    built: list[str] = field(default_factory=list)
    fractional: list[tuple[float, float, float]] = field(default_factory=list)
    """Order and quadrature range of each fractional derivative."""
    foreign: list[str] = field(default_factory=list)
    """The elements of which only a formula is known: users' own models."""
    _count: int = 0

    def signal(self, label: str) -> SignalSum:
        """Return a new signal, named by its label and a number."""
        self._count += 1
        return SignalSum.of(f"{label}.{self._count}")

    def hold_whole_delays(self) -> None:
        """Let what is held, and late by whole periods, be held by a clock of its own: no delay line
        keeps it."""
        # A delay line would store polynomials of what is constant between samples, and each jump in
        # it would be a break point. In a clock's memory the same delay is exact and costs nothing.
        for hold in tuple(self.holds):
            keys = [key for equation in self.equations for key in equation.terms]
            lags = {lag for name, _, lag in keys if name == hold.target and lag != 0}
            for lag in sorted(x for x in lags if (x / hold.T).q == 1):
                late = name_of(self.signal("late"))
                above = (_ZERO,) * int((lag / hold.T).p) + hold.above
                self.holds.append(replace(hold, target=late, above=above))
                self.equations = [
                    e.renamed((hold.target, lag), (late, _ZERO)) for e in self.equations
                ]

    def zero(self, equation: SignalSum) -> None:
        """Add an equation of motion: this sum is zero at all times."""
        self.equations.append(equation)

    def equal(self, one: SignalSum, other: SignalSum) -> None:
        """Let two sums be equal at all times."""
        self.zero(one - other)

    @property
    def elements(self) -> tuple[Element, ...]:
        """All elements that no linear equation describes."""
        return (*self.holds, *self.steps, *self.switches)

    @property
    def jumps(self) -> tuple[str, ...]:
        """The signals that elements set."""
        return tuple(element.target for element in self.elements)


def name_of(signal: SignalSum) -> str:
    """Return the name of a sum that is one signal."""
    [(name, _, _)] = signal.terms
    return name


def combined(
    net: Network, formulas: Sequence[Expr], signals: Sequence[SignalSum], y: SignalSum
) -> None:
    """y = G_1 x_1 + G_2 x_2 + ... over one denominator: what the formulas share is one motion in
    time, not several."""
    ring = Ring.of(formulas)
    quotients = [ring.convert(formula).reduced() for formula in formulas]
    # The least common denominator: with the product of all, modes that the formulas share would be
    # states twice, and unstable ones among them would not cancel.
    common = reduce(lambda x, y: x * (y // x.gcd(y)), (q.denominator for q in quotients))
    total = SignalSum({})
    for q, x in zip(quotients, signals, strict=True):
        total = total + operator(net, q.numerator * (common // q.denominator), ring, x)
    net.equal(operator(net, common, ring, y), total)


def operator(net: Network, polynomial: Polynomial, ring: Ring, x: SignalSum) -> SignalSum:
    """Apply a polynomial in s, delays and powers s^alpha to a signal."""
    total = SignalSum({})
    powers: dict[tuple[Any, int], SignalSum] = {}
    for exponents, coefficient in polynomial.to_dict().items():
        term = x
        factor = coefficient
        for meaning, n in zip(ring.meanings[1:], map(int, exponents[1:]), strict=True):
            # j comes from a describing function, and free symbols have no value: no motion in time
            # has either.
            if n and (meaning == I or meaning.free_symbols - {ring.meanings[0]}):
                raise SceneError(f"{meaning} cannot be simulated in time")
            if isinstance(meaning, exp):
                term = term.late(n * exact(-meaning.args[0].coeff(ring.meanings[0])))
            elif n and meaning.is_number:
                factor = factor * exact(meaning) ** n
            elif n:
                term = _powers(net, powers, term, exact(meaning.exp), n)
        total = total + factor * term.d(int(exponents[0]))
    return total


def _powers(
    net: Network, made: dict[tuple[Any, int], SignalSum], x: SignalSum, alpha: Exact, times: int
) -> SignalSum:
    """The derivative of order alpha, taken that many times; each is built once."""
    for n in range(1, times + 1):
        # Each power is a bank of some hundred relaxations: the same one is not built again.
        key = ((tuple(x.terms), alpha), n)
        if key not in made:
            made[key] = fractional(net, x, alpha)
        x = made[key]
    return x


class Port(NamedTuple):
    """A port between two elements: force ``F`` and displacement ``X``."""

    F: SignalSum
    X: SignalSum


def build_environment(net: Network, environment: Environment, port: Port) -> None:
    """Add the equations of an environment that is felt at a port."""
    net.built.append(environment.model)
    ours = (
        _ENVIRONMENTS.get(environment.model) if _is_ours(ENVIRONMENTS, environment.model) else None
    )
    with within(environment.model):
        (ours or _written)(net, environment, port)


def build_effect(net: Network, effect: Effect, near: Port, far: Port) -> None:
    """Add the equations of an effect between two ports; those of a user's own model follow from its
    chain matrix."""
    net.built.append(effect.model)
    ours = _EFFECTS.get(effect.model) if _is_ours(EFFECTS, effect.model) else None
    if ours is None:
        net.foreign.append(effect.name)
    with within(effect.name):
        (ours or _two_port)(net, effect, near, far)


def _is_ours(catalogue: Mapping[str, Model], model: str) -> bool:
    """Whether a model is the package's own, not one that a user has entered, perhaps under the same
    name."""
    return model in catalogue and catalogue[model].build.__module__.startswith(
        __name__.partition(".")[0] + "."
    )


def _values(element: Environment | Effect) -> dict[str, Exact]:
    return {parameter.key: exact(parameter.value) for parameter in element.parameters}


# Environments


def _maxwell_branches(net: Network, element: Environment, port: Port) -> None:
    """Branches of a spring and a damper in series, whose velocities add up to that of x; perhaps
    with a spring k0 in parallel."""
    # The velocity of a branch is the sum of its damper's and its spring's: F/b + F'/k = x'.
    p = _values(element)
    total = p.get("k0", fmpq(0)) * port.X
    for key in p.keys() - {"k0"}:
        if key.startswith("k"):
            force = net.signal("branch")
            net.equal(force.through(1 / p["b" + key[1:]], 1 / p[key]), port.X.d())
            total = total + force
    net.equal(port.F, total)


def _two_mass(net: Network, element: Environment, port: Port) -> None:
    """A mass that is held, and a second one that hangs on it by a spring and a damper."""
    p, hanging = _values(element), net.signal("hanging-mass")
    stretch = port.X - hanging
    pull = stretch.through(p["k2"], p["b2"])
    net.equal(p["m2"] * hanging.d(2), pull)
    net.equal(port.F, port.X.through(p["k1"], p["b1"], p["m1"]) + pull)


def _written(net: Network, element: Environment, port: Port) -> None:
    """Springs, masses and dampers, also of fractional order, and users' own."""
    combined(net, [element.H], [port.X], port.F)


# Effects


def _series(net: Network, element: Effect, near: Port, far: Port) -> None:
    """Every filter is its own differential equation."""
    net.equal(far.X, near.X)
    combined(net, [element.matrix[0]], [near.F], far.F)


def _zero_order_hold(net: Network, element: Effect, near: Port, far: Port) -> None:
    """A clock that samples the force and holds it until the next sample."""
    net.equal(far.X, near.X)
    net.holds.append(Hold(name_of(near.F), name_of(far.F), _values(element)["T"], element.name))


def build_controller(net: Network, effect: Effect, port: Port, resolution: float = 0.0) -> None:
    """Add a sampled controller in the place of the environment that it renders: its difference
    equation, between samples held.

    ``resolution`` : of its encoder, m or rad; rounding a sample is sampling what was rounded,
    without an event for each step.
    """
    D, T = controller(effect), _values(effect)["T"]
    both = (_in_delays(p) for p in (D.numerator, D.denominator))
    net.holds.append(Hold(name_of(port.X), name_of(port.F), T, effect.name, resolution, *both))


def _in_delays(polynomial: Polynomial) -> tuple[Exact, ...]:
    """The coefficients of a polynomial in 1/z, ascending."""
    row: dict[int, Exact] = {}
    for (n, power_of_pi, *_), number in polynomial.to_dict().items():
        coefficient = number * exact(pi) ** int(power_of_pi)
        row[int(n)] = row.get(int(n), _ZERO) + coefficient
    return tuple(row.get(n, _ZERO) for n in range(max(row, default=0) + 1))


def join(net: Network, near: Port, far: Port) -> None:
    """Let two ports be one."""
    net.equal(far.X, near.X)
    net.equal(far.F, near.F)


def _sampled_loop(net: Network, element: Effect, near: Port, far: Port) -> None:
    """Nothing but a joint: ``build_controller`` has added the clock in the environment's place."""
    join(net, near, far)


def _shunt(net: Network, element: Effect, near: Port, far: Port) -> None:
    """A dynamic stiffness next to the port: it shares the motion, and its force is added."""
    net.equal(far.X, near.X)
    beside = net.signal("beside")
    if coefficients := device(element):
        net.equal(beside, near.X.through(*map(exact, coefficients)))
    else:
        combined(net, [element.matrix[1]], [near.X], beside)
    net.equal(far.F, near.F + beside)


def _compliance(net: Network, element: Effect, near: Port, far: Port) -> None:
    """A spring and a damper between hand and display: both ends feel the same force."""
    p = _values(element)
    net.equal(far.F, near.F)
    net.equal(near.F, (far.X - near.X).through(p.get("k", fmpq(0)), p.get("b", fmpq(0))))


def _coulomb_friction(net: Network, element: Effect, near: Port, far: Port) -> None:
    force, velocity = net.signal("friction"), net.signal("velocity")
    net.equal(far.X, near.X)
    net.equal(far.F, near.F + force)
    net.equal(velocity, near.X.d())
    # Without a force there is nothing to switch: a guard on a limit of 0 would fall all the time.
    if limit := float_of(_values(element)["force"]):
        net.switches.append(
            Switch(name_of(force), velocity, name_of(velocity), limit, 0.0, element.name)
        )
    else:
        net.zero(force)


def size_of(element: Effect) -> float:
    """Return the size of an element that is not linear, SI: its step, gap, width or limit."""
    return float_of(exact(next(x.value for x in element.parameters if x.key != "amplitude")))


def _encoder(net: Network, element: Effect, near: Port, far: Port) -> None:
    net.equal(far.F, near.F)
    step = Step(name_of(far.X), name_of(near.X), size_of(element), element.name)
    net.steps.append(step)


def _backlash(net: Network, element: Effect, near: Port, far: Port) -> None:
    # Coulomb's law of a distance in place of a force: the play is open to one side while the driven
    # side moves one way, and what is in between while that rests.
    play, velocity = net.signal("play"), net.signal("velocity")
    net.equal(far.F, near.F)
    net.equal(far.X, near.X + play)
    net.equal(velocity, near.X.d())
    half = size_of(element) / 2
    net.switches.append(Switch(name_of(play), velocity, name_of(velocity), half, 0.0, element.name))


def _dead_zone(net: Network, element: Effect, near: Port, far: Port) -> None:
    lost, width = net.signal("lost"), size_of(element)
    net.equal(far.F, near.F)
    net.equal(far.X, near.X + lost)
    net.switches.append(
        Switch(name_of(lost), far.X - lost, name_of(far.X), width, width, element.name)
    )


def limit_force(net: Network, limit: float, name: str, near: Port, far: Port) -> None:
    """Add a limit of the force between two ports, N or N m."""
    net.equal(far.X, near.X)
    closed = near.F - far.F
    net.switches.append(Switch(name_of(far.F), closed, name_of(near.F), limit, limit, name))


def _saturation(net: Network, element: Effect, near: Port, far: Port) -> None:
    limit_force(net, size_of(element), element.name, near, far)


def _admittance_display(net: Network, element: Effect, near: Port, far: Port) -> None:
    # From the hand's force to the rendered one: that way is causal, as the display measures the
    # force and moves. The inverse would differentiate.
    net.equal(far.X, near.X)
    combined(net, [1 / element.matrix[0]], [far.F], near.F)


def _wave_variables(net: Network, element: Effect, near: Port, far: Port) -> None:
    # F + b v runs from the hand to the environment and F - b v back, each delayed by tau. Power is
    # F v = ((F + b v)^2 - (F - b v)^2)/(4 b), so that the line stores energy and makes none.
    p = _values(element)
    tau = p["tau"]
    outward = net.signal("outward-wave")
    inward = net.signal("inward-wave")
    near_flow = p["b"] * near.X.d()
    far_flow = p["b"] * far.X.d()
    net.equal(inward, far.F + far_flow)
    net.equal(outward, near.F - near_flow)
    net.equal(near.F + near_flow, inward.late(tau))
    net.equal(far.F - far_flow, outward.late(tau))


def _arm(p: Mapping[str, Exact], side: str, motion: SignalSum) -> SignalSum:
    """The force that moves an arm of a teleoperator: that of its mass and its damping."""
    return motion.through(0, p.get(f"D{side}", fmpq(0)), p[f"M{side}"])


def _scale(p: Mapping[str, Exact], of: str) -> Exact:
    """A scale of a teleoperator, of positions or of forces."""
    return p.get(f"scale_{of}", fmpq(1))


def _position_force(net: Network, element: Effect, near: Port, far: Port) -> None:
    # The slave follows the delayed position of the master, which feels the delayed force of the
    # environment: there is no coupling back to the master's own controller.
    p = _values(element)
    tau = p.get("tau", fmpq(0))
    control = (_scale(p, "x") * far.X.late(tau) - near.X).through(p["Ks"], p["Bs"])
    net.equal(_arm(p, "s", near.X), control - near.F)
    net.equal(far.F, _arm(p, "m", far.X) + _scale(p, "f") * near.F.late(tau))


def _position_position(net: Network, element: Effect, near: Port, far: Port) -> None:
    # Each side is pulled by a spring and a damper to the delayed position of the other.
    p = _values(element)
    tau = p.get("tau", fmpq(0))
    slave_error = far.X.late(tau) - near.X
    slave_control = slave_error.through(p["Ks"], p["Bs"])
    net.equal(_arm(p, "s", near.X), slave_control - near.F)
    master_error = far.X - near.X.late(tau)
    master_control = master_error.through(p["Km"], p["Bm"])
    net.equal(far.F, _arm(p, "m", far.X) + master_control)


def _four_channel(net: Network, element: Effect, near: Port, far: Port) -> None:
    # Each side sends force and motion, the latter through the other side's device. Without a delay
    # the last two equations give (master + slave)(near.X - far.X) = 0: ideal transparency.
    p = _values(element)
    tau = p.get("tau", fmpq(0))
    x, f = _scale(p, "x"), _scale(p, "f")
    to_slave = net.signal("to-slave")
    to_master = net.signal("to-master")

    def held(side: str, motion: SignalSum) -> SignalSum:
        """The force that an arm and its own controller need for a motion."""
        return _arm(p, side, motion) + motion.through(p[f"K{side}"], p[f"B{side}"])

    net.equal(to_slave, 1 / f * far.F + held("s", x * far.X))
    net.equal(to_master, f * near.F - held("m", 1 / x * near.X))
    net.equal(held("s", near.X), to_slave.late(tau) - near.F)
    net.equal(far.F, held("m", far.X) + to_master.late(tau))


def _two_port(net: Network, element: Effect, near: Port, far: Port) -> None:
    """A chain matrix as it is given: [far.F; far.X] = matrix [near.F; near.X]."""
    for row, signal in ((element.matrix[:2], far.F), (element.matrix[2:], far.X)):
        combined(net, row, near, signal)


def float_of(number: Exact) -> float:
    """Return a rational as a float."""
    return int(number.p) / int(number.q)


_ENVIRONMENTS: dict[str, Callable[[Network, Environment, Port], None]] = {
    **dict.fromkeys(("maxwell", "zener", "prony"), _maxwell_branches),
    "two-mass": _two_mass,
}
_EFFECTS: dict[str, Callable[[Network, Effect, Port, Port], None]] = {
    "sampled-loop": _sampled_loop,
    "zero-order-hold": _zero_order_hold,
    **dict.fromkeys(
        ("series", "first-order-lag", "second-order-lowpass", "delay", "pade-delay"), _series
    ),
    "shunt": _shunt,
    "compliance": _compliance,
    "coulomb-friction": _coulomb_friction,
    "encoder": _encoder,
    "backlash": _backlash,
    "dead-zone": _dead_zone,
    "saturation": _saturation,
    "admittance-display": _admittance_display,
    "wave-variables": _wave_variables,
    "position-force-teleoperator": _position_force,
    "position-position-teleoperator": _position_position,
    "four-channel-teleoperator": _four_channel,
    "two-port": _two_port,
}


_STEP = 0.4  # in ln(lambda): exp(-pi^2/0.4) is 2e-11
_ACCURACY = 1e-9  # of the two ends


def rates_and_weights(
    alpha: float, span: tuple[float, float]
) -> tuple[list[float], list[float], float, float]:
    """Rates, 1/s, and weights of the bank, and the spring and the damper that stand for the rest.

    s^alpha is about spring + damper s + sum of weight s/(s + rate), for frequencies of ``span``,
    rad/s.

    >>> rates, weights, spring, damper = rates_and_weights(0.5, (1.0, 10.0))
    >>> value = spring + damper * 3j + sum(w * 3j / (3j + r) for r, w in zip(rates, weights))
    >>> abs(value / 3j**0.5 - 1) < 1e-8
    True
    """
    # A relaxation much slower than s is a constant, but for (rate/s)^(1 + alpha) of s^alpha; one
    # much faster is a damper, but for (s/rate)^(2 - alpha). So far the bank must reach.
    slowest = span[0] * _ACCURACY ** (1 / (1 + alpha))
    fastest = span[1] * _ACCURACY ** (-1 / (2 - alpha))
    first = floor(log(slowest) / _STEP)
    last = ceil(log(fastest) / _STEP)
    scale = _STEP * sin(math.pi * alpha) / math.pi
    rates = [math.exp(_STEP * n) for n in range(first, last + 1)]
    weights = [scale * rate**alpha for rate in rates]
    # The sums of all slower and of all faster relaxations, which are geometric series.
    slower = math.exp(_STEP * alpha) - 1
    faster = math.exp(_STEP * (1 - alpha)) - 1
    spring = scale * rates[0] ** alpha / slower
    damper = scale * rates[-1] ** (alpha - 1) / faster
    return rates, weights, spring, damper


def fractional(net: Network, x: SignalSum, alpha: Exact) -> SignalSum:
    """A signal that is the derivative of order alpha, 0 < alpha < 1, of a sum."""
    order = int(alpha.p) / int(alpha.q)
    net.fractional.append((order, *net.span))
    rates, weights, spring, damper = rates_and_weights(order, net.span)
    total = x.through(_rational(spring), _rational(damper))
    for rate, weight in zip(rates, weights, strict=True):
        lagging = net.signal("relaxation")
        net.equal(lagging.d(), _rational(rate) * (x - lagging))
        total = total + _rational(weight) * (x - lagging)
    result = net.signal("fractional")
    net.equal(result, total)
    return result


def _rational(number: float) -> Exact:
    return fmpq(*number.as_integer_ratio())


def bank_error(alpha: float, span: tuple[float, float], omegas: Array) -> float:
    """The largest relative deviation of the bank from (j omega)^alpha at given frequencies,
    rad/s."""
    rates, weights, spring, damper = rates_and_weights(alpha, span)
    s = 1j * np.asarray(omegas)[:, None]
    value = spring + damper * s[:, 0] + (np.array(weights) * s / (s + np.array(rates))).sum(axis=1)
    return float(np.abs(value / s[:, 0] ** alpha - 1).max())


_S = fmpq(1, 10**40)
"""1/s. Numbers of the answer are wrong by about as little, relative to the time constants of the
scene in s."""


def at_rest(net: Network, position: float) -> dict[str, float]:
    """Every signal of a network while the hand rests at a position, m or rad.

    Clocks let through what they sample, friction gives no force, a limited force is what it is
    without the limit or the limit, and a quantiser counts as exact. Raises SceneError where
    something moves on though the hand rests.

    >>> net, f, x = Network((1.0, 1.0)), SignalSum.of("f"), SignalSum.of("x")
    >>> net.equal(f, x.through(100, 15)), net.equal(x, SignalSum.of("motion"))
    (None, None)
    >>> at_rest(net, 0.5)["f"]
    50.0
    """
    ratios = _ratios(net, {})
    values = {name: position * float_of(ratio) for name, ratio in ratios.items()}
    # First as if no force were limited; then those beyond their limit are set to it.
    beyond = [x for x in net.switches if x.offset and abs(values[x.driver]) > x.limit]
    if beyond:
        limits = {
            x.target: _rational(math.copysign(x.limit, values[x.driver]) / position) for x in beyond
        }
        values = {name: position * float_of(ratio) for name, ratio in _ratios(net, limits).items()}
    # A signal that moves on grows as 1/s, at this s as 1e40: far beyond whatever rests.
    if not all(abs(value) < 1e15 for value in values.values()):
        raise SceneError("motion: the scene does not rest at the first sample: begin at 0")
    return values


def _ratios(net: Network, limits: Mapping[str, Exact]) -> dict[str, Exact]:
    """Return each signal as a fraction of the hand's position; ``limits`` : the same for the
    forces that are at their limit."""
    # For s -> 0 a hold is (1 - exp(-s T))/(s T) = exp(-s T/2) to first order. That order matters
    # where a loop integrates, as what delay lines hold then depends on it.
    held = [x.equation(SignalSum.of(x.source).late(x.T / 2)) for x in net.holds]
    passed = [*held, *(SignalSum.of(x.target) - SignalSum.of(x.source) for x in net.steps)]
    at_limit = {
        target: SignalSum.of(target) - ratio * SignalSum.of(MOTION)
        for target, ratio in limits.items()
    }
    switched = [
        at_limit.get(x.target, x.closed if x.offset else SignalSum.of(x.target))
        for x in net.switches
    ]
    equations = [*net.equations, *passed, *switched]
    keys = [key for equation in equations for key in equation.terms]
    names = list(dict.fromkeys(name for name, _, _ in keys if name != MOTION))
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
        solution = left.solve(right)
    except ZeroDivisionError:
        raise SceneError(
            "motion: the scene has no state of rest at the first sample: begin at 0"
        ) from None
    return {MOTION: fmpq(1), **{name: solution[i, 0] for name, i in place.items()}}


def _factor(key: SignalKey) -> Exact:
    """s^n exp(-s lag) at the tiny s; three terms of the series are exact enough, as s^2 is
    1e-80."""
    _, order, lag = key
    turned = _S * lag
    return _S**order * (1 - turned + turned * turned / 2)
