"""What is left of a distortion when the devices are fast: its leading terms.

An *effect* stands between a rendered environment, H_env(s), and the hand, which feels H_perc(s); dH
= H_perc - H_env is the distortion. Every time constant of an effect (a delay, a sampling period,
one over a corner frequency) is multiplied by epsilon: dH is then a power series in epsilon, dH =
dH_0 + dH_1 epsilon + ..., whose coefficients are rational functions of s. At epsilon = 1 it is the
scene's own distortion.

The series is found by replacing each exponential by its Taylor polynomial, and by division of
polynomials in epsilon. Nothing is said of convergence: what the terms leave out is bounded on the
scene's band by its certified largest value (``Expansion.bounds``).

Begin with ``expansion``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, reduce
from operator import add

from sympy import Add, Dummy, Expr, Poly, Symbol, cosh, exp, factorial, sinh, together

from haptisym.judge.peaks import largest_value
from haptisym.kernel.dynamics import on_axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber, SquareRoot
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, coefficients
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Scene

# The power of epsilon by which a parameter of this dimension is multiplied.
_POWER_OF_EPSILON = {Dimension.TIME: 1, Dimension.FREQUENCY: -1}
# The order up to which exponentials in a denominator are expanded: no effect divides by more than a
# few powers of a time.
_MOST_DIVISIONS = 20


@dataclass(frozen=True)
class Expansion:
    """An expansion writes a distortion as dH = terms[0] + terms[1] + ... + remainder, for fast
    devices.

    ``terms`` : in the scene's symbols, of ascending order in the devices' time constants; the
    first, of order 0, is what devices without any delay would do. ``fast`` : the parameters in
    which it is expanded, time constants and frequencies of effects.
    """

    scene: Scene = field(repr=False)
    terms: tuple[RationalFunction, ...] = field(repr=False)
    fast: tuple[Symbol, ...]

    def part(self, part: Part) -> Expr:
        """Return Re or Im of the terms together, a closed form in omega."""
        return Add(*(part_of(on_axis(term), part).factored() for term in self.terms))

    @cached_property
    def bounds(self) -> Mapping[Part, RealNumber | None]:
        """Return the largest error that the terms make in r_r and in r_i on the scene's band:
        proven; None where it is infinite.

        Empty where a parameter has no number.
        """
        values = {p.symbol: p.value for p in self.scene.parameters}
        if any(value.free_symbols for value in values.values()):
            return {}
        exact = self.scene.distortion()
        ring = exact.chain.ring
        terms = [ring.convert(term.expression().xreplace(values)) for term in self.terms]
        # The bound is on the difference itself, in the scene's numbers: it needs no estimate of the
        # next terms of the series, and holds where this does not converge.
        remainder = on_axis((exact.difference - reduce(add, terms)).reduced())
        bounds: dict[Part, RealNumber | None] = {}
        for part in Part:
            error = part_of(remainder, part)
            square = largest_value(error * error / exact.squared_modulus, *self.scene.band)
            bounds[part] = None if square is None else SquareRoot(square)
        return bounds


def expansion(scene: Scene, order: int = 1) -> Expansion:
    """Return the distortion of a scene to some order in the time constants of its effects.

    Raises SceneError where no effect has a time constant, or where the distortion of infinitely
    fast devices is infinite.

    >>> from haptisym import effects, environments
    >>> from haptisym.kernel.rings import symbols
    >>> k, tau = symbols("k tau")
    >>> scene = Scene(environments.mass_spring_damper(k=100), (effects.delay("5 ms"),))
    >>> found = expansion(scene)
    >>> found.part(Part.IMAG), found.bounds[Part.IMAG].digits(3), found.bounds[Part.REAL].digits(3)
    (-k*omega*tau, '0.0000703', '0.00281')
    """
    fast: dict[Symbol, Dimension] = {}
    parameters = [p for effect in scene.effects for p in effect.parameters]
    for p in parameters:
        if p.dimension in _POWER_OF_EPSILON:
            fast[p.symbol] = p.dimension
    if not fast:
        unknown = sorted({p.symbol.name for p in parameters if p.dimension is Dimension.ANY})
        if unknown:
            raise SceneError(
                f"which of {', '.join(unknown)} are time constants of an effect is not known of an "
                f"expression: use models, as effects.delay(tau) or effects.first_order_lag(omega_c)"
            )
        raise SceneError(
            "no effect of this scene has a time constant: there is no high-bandwidth approximation"
        )
    epsilon = Dummy("epsilon", positive=True)
    powers = {x: x * epsilon ** _POWER_OF_EPSILON[dimension] for x, dimension in fast.items()}
    in_epsilon = scene.chain.replaced(powers)
    # A division by epsilon, as that of a hold by its period, costs an order each time. Two more for
    # each time constant are left for a common factor of a matrix, which cancels.
    divisions = (_divisions(entry, epsilon) for entry in in_epsilon.entries())
    depth = order + 2 + 2 * len(fast) + sum(divisions)
    cut = Distortion.of(in_epsilon.map(lambda entry: _truncated(entry, epsilon, depth)))
    terms = _series(cut.difference, epsilon, order)
    return Expansion(scene, tuple(terms), tuple(fast))


def _divisions(entry: Expr, epsilon: Symbol) -> int:
    """Return how often an entry divides by epsilon where it is not in lowest terms: the lowest
    power in its denominator."""
    denominator = together(entry).as_numer_denom()[1]
    if not denominator.has(epsilon):
        return 0
    terms = Poly(_truncated(denominator, epsilon, _MOST_DIVISIONS).expand(), epsilon).monoms()
    return min(int(power) for (power,) in terms)


def _truncated(entry: Expr, epsilon: Symbol, depth: int) -> Expr:
    """Return the entry with a Taylor polynomial of degree ``depth`` for each exp, cosh and sinh
    that holds epsilon."""
    # With polynomials in place of exponentials the entries are rational in epsilon, and the ring
    # has no functions of it; terms of an order above ``depth`` do not reach the order that is
    # wanted.
    for function, first, step in ((exp, 0, 1), (cosh, 0, 2), (sinh, 1, 2)):
        powers = range(first, depth + 1, step)
        for call in entry.atoms(function):
            if call.has(epsilon):
                x = call.args[0]
                polynomial = Add(*(x**n / factorial(n) for n in powers))
                entry = entry.xreplace({call: polynomial})
    return entry


def _series(f: RationalFunction, epsilon: Symbol, order: int) -> Iterator[RationalFunction]:
    """Yield the coefficients of the power series of ``f``, in lowest terms, in epsilon, from order
    0 up to an order; SceneError where f has a pole at epsilon = 0."""
    numerator = _by_powers(f.numerator, f.ring, epsilon)
    denominator = _by_powers(f.denominator, f.ring, epsilon)
    # In lowest terms a denominator without a term of order 0 is divided by epsilon, and the
    # numerator is not: a pole.
    if 0 not in denominator:
        raise SceneError(
            "the distortion increases without bound with the bandwidth of the effects: there "
            "is no high-bandwidth approximation"
        )
    # (sum of b_j e^j)(sum of t_n e^n) = sum of a_n e^n gives t_n from those before it.
    terms: list[RationalFunction] = []
    for n in range(order + 1):
        remainder = numerator.get(n, f.ring.zero)
        for j, term in enumerate(terms):
            remainder = remainder - denominator.get(n - j, f.ring.zero) * term
        terms.append((remainder / denominator[0]).reduced())
        yield terms[-1]


def _by_powers(
    polynomial: Polynomial, ring: PolynomialRing, variable: Symbol
) -> dict[int, RationalFunction]:
    """Return the coefficients of a polynomial by the powers of one variable, without those that are
    0."""
    if variable not in ring.meanings:  # nothing depends on it
        return {0: ring.function(polynomial)}
    rows = coefficients(polynomial, ring.meanings.index(variable))
    return {power: ring.function(row) for power, row in enumerate(rows) if row}
