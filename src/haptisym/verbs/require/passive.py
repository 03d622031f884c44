"""For which values of one parameter every passive hand may hold a display: exact verdicts between critical values."""

from __future__ import annotations

from collections.abc import Iterator

from sympy import Expr, Integer

from haptisym.judge.criteria import PASSIVE
from haptisym.judge.passivity import environment_alone, passivity
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.eliminants import resultant
from haptisym.kernel.monomials import monomials
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.model.distortion import Distortion
from haptisym.model.knobs import Knob
from haptisym.model.parameters import Rule, values
from haptisym.model.scene import Scene
from haptisym.verbs.require.criticalvalues import allowed, critical, irreducible, missing, real_roots
from haptisym.verbs.require.feasible import Binding, Kind, Solved
from haptisym.verbs.require.freeparameter import Domain, conditions, pieces
from haptisym.verbs.require.passivecells import solve_by_cells
from haptisym.verbs.require.verdicts import Question, Turn


def solve_passive(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values with which every passive hand may hold a display without a clock; with delays, as far as cells tell."""
    perceived = _perceived(scene, free)
    turns = list[Turn]()
    if free.symbol in perceived.expression().free_symbols:
        [condition] = pieces(conditions(scene, [free], [PASSIVE])[PASSIVE])
        if condition.axis.functions:
            if _is_of_passive_parts(scene, free, asked):
                return _all(scene, free, asked)
            return solve_by_cells(scene, free, asked)
        turns = [*_of_signs(condition, free), *turns_of_poles(perceived, free)]

    def verdict(value: Expr) -> bool | None:
        return passivity(free.put(scene, value)).holds

    return Question(
        turns, verdict, asked, closed=True, exists=lambda x: allowed(scene, free, x), gone=missing(scene, free)
    ).solve()


def _is_of_passive_parts(scene: Scene, free: Knob, asked: Domain) -> bool:
    """Whether the environment alone is passive for all values, and all effects take energy with each of them."""
    alone = environment_alone(scene)
    if alone is None or free.rule is Rule.ANY:  # a shunt's may be negative, and a formula may do anything with a number
        return False
    knob = next((x for x in alone.knobs if x.path == free.path), None)
    if knob is None:
        return passivity(alone).holds is True
    found = solve_passive(alone, knob, asked)
    return found == _all(alone, knob, asked)


def _all(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values with which there is a scene."""
    return Question(
        [], lambda _: True, asked, closed=True, exists=lambda x: allowed(scene, free, x), gone=missing(scene, free)
    ).solve()


def _of_signs(condition: RealFunction, free: Knob) -> Iterator[Turn]:
    """Where Im H_perc begins or ceases to be negative somewhere on (0, infinity)."""
    if free.symbol not in condition.axis.meanings:
        return
    index = condition.axis.meanings.index(free.symbol)
    found = [
        (x[1], p) for x, p in critical(PASSIVE, [condition], (Integer(0), Integer(1))) if x and x[1] is not Kind.EDGE
    ]
    found += [(Kind.FAR, _leading(f)) for f, _ in irreducible(condition.function.numerator)]
    for kind, polynomial in found:
        omega = None
        for factor, _ in polynomial.factor()[1]:
            for value in real_roots(factor, index, negative=True):
                yield Turn(value, (Binding(PASSIVE, omega, kind),))


def _end(polynomial: Polynomial, power: int) -> Polynomial:
    """The coefficient of one power of the ring's variable."""
    terms = {(0, *e[1:]): value for e, value in monomials(polynomial) if int(e[0]) == power}
    return polynomial.context().from_dict(terms)


def _leading(polynomial: Polynomial) -> Polynomial:
    return _end(polynomial, int(polynomial.degrees()[0]))


def _perceived(scene: Scene, free: Knob) -> RationalFunction:
    return Distortion.of(scene.chain.at(values(x for x in scene.parameters if x.path != free.path))).perc


def turns_of_poles(function: RationalFunction, free: Knob) -> Iterator[Turn]:
    """Where poles of a function cross the axis, or poles or zeros come from infinity or to 0."""
    ring = function.ring
    assert isinstance(ring, Ring)
    if free.symbol not in ring.meanings:
        return
    index, found = ring.meanings.index(free.symbol), list[tuple[Kind, Polynomial]]()
    for polynomial in (function.numerator, function.denominator):
        for f, _ in polynomial.factor()[1]:
            found += [(Kind.FAR, _leading(f)), (Kind.START, _end(f, min(int(e[0]) for e in f.monoms())))]
    for f, _ in function.denominator.factor()[1]:
        [(real, imag)] = ring.axis.parts([f])
        common = real.gcd(imag)
        if real and imag and f.degrees()[0]:
            found.append((Kind.AXIS, resultant(real / common, imag / common, 0)))
    for kind, polynomial in found:
        for factor, _ in polynomial.factor()[1] if polynomial else ():
            for value in real_roots(factor, index, negative=True):
                yield Turn(value, (Binding(PASSIVE, None, kind),))
