"""What is left of a distortion when the devices are fast: its leading terms, and a proven bound on all the rest.

Every time constant of an effect (a delay, a sampling period, one over a corner frequency) is multiplied by epsilon: dH is then a
power series in epsilon, whose terms are rational functions of s. At epsilon = 1 it is the scene's own distortion, and what
the terms leave is bounded on the scene's band by its certified largest value.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, reduce
from operator import add

from sympy import Add, Dummy, Expr, Symbol, cosh, exp, factorial, sinh

from haptisym.judge.peaks import largest
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber, SquareRoot
from haptisym.kernel.response import on_axis
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Scene


@dataclass(frozen=True)
class Expansion:
    """dH = terms[0] + terms[1] + ... + remainder, for fast devices.

    ``terms`` : in the scene's symbols, of ascending order in the devices' time constants; the first, of order 0, is what
    devices without any delay would do. ``fast`` : the parameters that make them fast.
    """

    scene: Scene = field(repr=False)
    terms: tuple[RationalFunction, ...] = field(repr=False)
    fast: tuple[Symbol, ...]

    def part(self, part: Part) -> Expr:
        """Re or Im of the terms together, a closed form in omega."""
        return Add(*(part_of(on_axis(term), part).factored() for term in self.terms))

    @cached_property
    def bounds(self) -> Mapping[Part, RealNumber | None]:
        """The largest error that the terms make in r_r and r_i on the scene's band: certified; None where it is infinite.

        Empty where a parameter has no number.
        """
        values = {p.symbol: p.value for p in self.scene.parameters}
        if any(value.free_symbols for value in values.values()):
            return {}
        exact = self.scene.distortion()
        ring = exact.chain.ring
        kept = [ring.convert(term.expression().xreplace(values)) for term in self.terms]
        rest = on_axis((exact.difference - reduce(add, kept)).reduced())
        found: dict[Part, RealNumber | None] = {}
        for part in Part:
            error = part_of(rest, part)
            square = largest(error * error / exact.squared_modulus, *self.scene.band)
            found[part] = None if square is None else SquareRoot(square)
        return found


def expansion(scene: Scene, order: int = 1) -> Expansion:
    """The distortion of a scene to some order in the time constants of its effects.

    Raises SceneError where no effect has a time constant, or where the distortion of infinitely fast devices is infinite.

    >>> from haptisym import effects, environments
    >>> from haptisym.kernel.symbols import symbols
    >>> k, tau = symbols("k tau")
    >>> scene = Scene(environments.mass_spring_damper(k=100), (effects.delay("5 ms"),))
    >>> found = expansion(scene)
    >>> found.part(Part.IMAG), found.bounds[Part.IMAG].digits(3), found.bounds[Part.REAL].digits(3)
    (-k*omega*tau, '0.0000703', '0.00281')
    """
    fast = {p.symbol: p.dimension for e in scene.effects for p in e.parameters if p.dimension in _SPEED}
    if not fast:
        raise SceneError("no effect of this scene has a time constant: there is nothing that could be fast")
    epsilon = Dummy("epsilon", positive=True)
    slowed = scene.chain.at({x: x * epsilon ** _SPEED[dimension] for x, dimension in fast.items()})
    depth = order + 2 + 2 * len(fast)  # a hold divides by its period, which costs an order each time
    cut = Distortion.of(slowed.map(lambda entry: _truncated(entry, epsilon, depth)))
    terms = _series(cut.difference, epsilon, order)
    return Expansion(scene, tuple(terms), tuple(fast))


_SPEED = {Dimension.TIME: 1, Dimension.FREQUENCY: -1}
"""How a parameter that measures this grows with the time constants."""


def _truncated(entry: Expr, epsilon: Symbol, depth: int) -> Expr:
    """The entry with a Taylor polynomial for each exponential that holds epsilon."""

    def polynomial(x: Expr, powers: range) -> Expr:
        return Add(*(x**n / factorial(n) for n in powers))

    for function, first, step in ((exp, 0, 1), (cosh, 0, 2), (sinh, 1, 2)):
        powers = range(first, depth + 1, step)
        for found in entry.atoms(function):
            if found.has(epsilon):
                entry = entry.xreplace({found: polynomial(found.args[0], powers)})
    return entry


def _series(f: RationalFunction, epsilon: Symbol, order: int) -> Iterator[RationalFunction]:
    """The coefficients of a power series in epsilon, up to an order; ``f`` in lowest terms."""
    above, below = (_by_powers(p, f.ring, epsilon) for p in (f.numerator, f.denominator))
    if 0 not in below:  # then it is in the numerator: a power of epsilon is left below the line
        raise SceneError("the distortion grows without bound as the effects get faster: it has no leading terms")
    terms: list[RationalFunction] = []
    for n in range(order + 1):
        total = above.get(n, f.ring.zero)
        for j, term in enumerate(terms):
            total = total - below.get(n - j, f.ring.zero) * term
        terms.append((total / below[0]).reduced())
        yield terms[-1]


def _by_powers(polynomial: Polynomial, ring: PolynomialRing, variable: Symbol) -> dict[int, RationalFunction]:
    """The coefficients of the powers of a variable."""
    index = ring.meanings.index(variable)
    found: dict[int, dict[tuple[int, ...], object]] = {}
    for exponents, value in polynomial.to_dict().items():
        own = list(map(int, exponents))
        power, own[index] = own[index], 0
        found.setdefault(power, {})[tuple(own)] = value
    return {n: ring.function(ring.context.from_dict(terms)) for n, terms in found.items()}
