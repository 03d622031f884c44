"""Linear equations of motion in named signals, and dynamics as such equations.

Linear equations of motion in named signals: sums of derivatives and delays with exact coefficients.

A ``Network`` is what a scene becomes before it is simulated: equations between signals, each a ``Sum`` that equals zero, and
the elements that no linear equation describes (``Hold``, ``Switch``, ``Step``). Nothing here is a transfer function of
the whole: every block adds its own equations, and only those of blocks that the scene names are ever made.

Dynamics as equations: a rational function of s, powers of s and delays between signals of a network.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any, TypeAlias

from flint import fmpq
from sympy import Expr, I, Rational, exp, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial

Exact: TypeAlias = fmpq
SignalKey: TypeAlias = tuple[str, int, fmpq]
"""A signal's name, how often it is differentiated, and by how many seconds it is late."""

MOTION = "motion"
"""The prescribed motion of the hand, the one signal that is known beforehand."""

_PI = Rational("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")
_ZERO = fmpq(0)


def exact(value: Expr | int) -> Exact:
    """An exact number of a scene as a rational one; pi is cut after 80 digits, everywhere alike, so that it still cancels."""
    number = Rational(value) if isinstance(value, int) else Rational(value.xreplace({pi: _PI}))
    return fmpq(int(number.p), int(number.q))


@dataclass(frozen=True, slots=True, eq=False)
class SignalSum:
    """A linear combination of signals, of their derivatives and of what they were some time ago.

    >>> x = SignalSum.of("x")
    >>> (2 * x.d(2) - x.late(fmpq(1, 2))).terms == {("x", 2, fmpq(0)): 2, ("x", 0, fmpq(1, 2)): -1}
    True
    """

    terms: Mapping[SignalKey, Exact]

    @classmethod
    def of(cls, name: str) -> SignalSum:
        """One signal alone."""
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

    def d(self, times: int = 1) -> SignalSum:
        """The derivative with respect to time, that many times."""
        return SignalSum({(name, order + times, lag): value for (name, order, lag), value in self.terms.items()})

    def late(self, tau: Exact) -> SignalSum:
        """What it was ``tau`` seconds ago."""
        return SignalSum({(name, order, lag + tau): value for (name, order, lag), value in self.terms.items()})

    def through(self, *coefficients: Exact | int) -> SignalSum:
        """c0 x + c1 dx/dt + c2 d2x/dt2 + ..."""
        total = SignalSum({})
        for order, coefficient in enumerate(coefficients):
            total = total + coefficient * self.d(order)
        return total


@dataclass(frozen=True)
class Hold:
    """A clock that samples ``source`` every ``period`` seconds and holds the value on ``target``."""

    source: str
    target: str
    period: float
    name: str


@dataclass(frozen=True)
class Switch:
    """A force that is ``+limit`` or ``-limit`` or, in between, whatever keeps ``closed`` zero.

    Coulomb friction: ``closed`` is the velocity, and the force holds it at zero (stick) until it reaches the limit.
    Saturation: ``closed`` is input minus output, and beyond the limit the output stays there. ``driver`` is the signal
    whose sign keeps the switch open: the velocity, or the input beyond its limit.
    """

    target: str
    closed: SignalSum
    driver: str
    limit: float
    offset: float
    """What the magnitude of the driver must exceed to keep the switch open: 0 for friction, the limit for saturation."""
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
    """Equations and elements as the blocks of a scene add them; ``known`` are the signals that elements set."""

    span: tuple[float, float]
    """The frequencies, rad/s, that the motion holds: a fractional derivative is built for them."""
    equations: list[SignalSum] = field(default_factory=list)
    holds: list[Hold] = field(default_factory=list)
    switches: list[Switch] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    frictions: list[Switch] = field(default_factory=list)
    """Those of the switches that are friction, as built: where several act on one velocity, ``switches`` has only the first."""
    built: list[str] = field(default_factory=list)
    fractional: list[tuple[float, float, float]] = field(default_factory=list)
    """Order and quadrature range of each fractional derivative."""
    foreign: list[str] = field(default_factory=list)
    """The elements of which only a formula is known: users' own models."""
    _count: int = 0

    def signal(self, label: str) -> SignalSum:
        """A new signal."""
        self._count += 1
        return SignalSum.of(f"{label}.{self._count}")

    def zero(self, equation: SignalSum) -> None:
        """One more equation of motion: this sum is zero."""
        self.equations.append(equation)

    def equal(self, one: SignalSum, other: SignalSum) -> None:
        """Let two sums be equal at all times."""
        self.zero(one - other)

    @property
    def elements(self) -> tuple[Element, ...]:
        """Whatever is not a linear equation."""
        return (*self.holds, *self.steps, *self.switches)

    @property
    def jumps(self) -> tuple[str, ...]:
        """The signals that elements set."""
        return tuple(element.target for element in self.elements)


def name_of(signal: SignalSum) -> str:
    """The name of a plain signal."""
    [(name, _, _)] = signal.terms
    return name


def quotient(net: Network, formula: Expr, x: SignalSum, y: SignalSum) -> None:
    """y = (numerator/denominator) x as a differential equation: denominator(d/dt) y = numerator(d/dt) x."""
    combined(net, [formula], [x], y)


def combined(net: Network, formulas: Sequence[Expr], signals: Sequence[SignalSum], y: SignalSum) -> None:
    """y = G_1 x_1 + G_2 x_2 + ... over one denominator: what the formulas share is one motion in time, not several."""
    ring = Ring.of(formulas)
    quotients = [ring.convert(formula).reduced() for formula in formulas]
    common = reduce(_least_multiple, (q.denominator for q in quotients))
    total = SignalSum({})
    for q, x in zip(quotients, signals, strict=True):
        total = total + operator(net, q.numerator * (common // q.denominator), ring, x)
    net.equal(operator(net, common, ring, y), total)


def _least_multiple(one: Polynomial, other: Polynomial) -> Polynomial:
    return one * (other // one.gcd(other))


def operator(net: Network, polynomial: Polynomial, ring: Ring, x: SignalSum) -> SignalSum:
    """A polynomial in s, delays and powers s^alpha, applied to a signal."""
    total = SignalSum({})
    powers: dict[tuple[Any, int], SignalSum] = {}
    for exponents, coefficient in polynomial.to_dict().items():
        term = x
        factor = coefficient
        for meaning, n in zip(ring.meanings[1:], map(int, exponents[1:]), strict=True):
            if n and (meaning == I or meaning.free_symbols - {ring.meanings[0]}):
                raise SceneError(f"{meaning} has no meaning in time: this formula cannot be simulated")
            if isinstance(meaning, exp):
                term = term.late(n * exact(-meaning.args[0].coeff(ring.meanings[0])))
            elif n and meaning.is_number:
                factor = factor * exact(meaning) ** n
            elif n:
                term = _powers(net, powers, term, exact(meaning.exp), n)
        total = total + factor * term.d(int(exponents[0]))
    return total


def _powers(net: Network, made: dict[tuple[Any, int], SignalSum], x: SignalSum, alpha: Exact, times: int) -> SignalSum:
    """The derivative of order alpha, taken that many times; each is built once."""
    for n in range(1, times + 1):
        key = ((tuple(x.terms), alpha), n)
        if key not in made:
            made[key] = fractional(net, x, alpha)
        x = made[key]
    return x


def fractional(net: Network, x: SignalSum, alpha: Exact) -> SignalSum:
    """The derivative of an order that is not whole."""
    from haptisym.verbs.simulate.blocks import derivative  # only scenes with a power of s that is not whole need it

    return derivative(net, x, alpha)
