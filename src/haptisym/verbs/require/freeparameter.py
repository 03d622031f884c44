"""Knobs of a scene left open: which values are asked about, and the threshold conditions as functions of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import TypeAlias

from sympy import Expr, Integer

from haptisym.judge.bounds import for_any_environment
from haptisym.judge.crossings import Criterion, noticed, opened
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, several
from haptisym.kernel.rings import Polynomial, monomials
from haptisym.kernel.roots import Lattice, sign_of_number
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.parameters import Rule, values
from haptisym.model.quantities import Number
from haptisym.model.scene import THRESHOLD, Knob, Scene


@dataclass(frozen=True)
class Domain:
    """The values that are asked about: an interval, None where it is unbounded, and whether its ends belong to it."""

    low: Expr | None
    high: Expr | None
    holds_low: bool = True
    holds_high: bool = True


def domain(free: Knob, given: tuple[Number, Number] | None) -> Domain:
    """The values that the rule of a parameter allows, within the range that is given."""
    low, high, closed = _ALLOWED[free.rule]
    if given is None:
        return Domain(low, high, closed, closed)
    ends = several(free.path, given, "the range has two ends, as (20, 200)")
    if len(ends) != 2:
        raise SceneError(f"{free.path}: a range has two ends, not {len(ends)}")
    start, end = (free.number(x) for x in ends)
    if sign_of_number(end - start) <= 0:
        raise SceneError(f"{free.path}: the range must go up, not from {given[0]} to {given[1]}")
    if (low is not None and sign_of_number(end - low) <= 0) or (high is not None and sign_of_number(high - start) <= 0):
        raise SceneError(f"{free.path} {free.rule.value}: no value from {given[0]} to {given[1]} does")
    below = low is not None and sign_of_number(start - low)
    above = high is not None and sign_of_number(high - end)
    return Domain(
        low if below is not False and below < 0 else start,
        high if above is not False and above < 0 else end,
        closed or below is False or below > 0,
        closed or above is False or above > 0,
    )


_ALLOWED: Mapping[Rule, tuple[Expr | None, Expr | None, bool]] = {
    Rule.POSITIVE: (Integer(0), None, False),
    Rule.NONNEGATIVE: (Integer(0), None, True),
    Rule.ANY: (None, None, True),
    Rule.FRACTION: (Integer(0), Integer(1), False),
}


def asked_of(scene: Scene, free: Sequence[Knob], part: Part | None, *, any_environment: bool) -> tuple[Criterion, ...]:
    """What is to hold on the whole band: what is judged of one part, or of both, or |G - 1| <= c."""
    if not any_environment:
        return tuple(x for x in noticed(scene.threshold) if part in (None, x.part))
    if part is not None:
        raise SceneError("for any environment there are no parts: ask for one or the other")
    if any(x.path.startswith("environment.") for x in free):
        raise SceneError("for any environment no parameter of the environment can be free")
    if any(len(x.parts) == 1 for x in free):
        raise SceneError(f"for any environment the thresholds are one: leave {THRESHOLD} free")
    return (for_any_environment(scene.threshold),)


Condition: TypeAlias = RealFunction | Lattice
"""A function of omega and the free parameters that must not be positive; of a lattice of one term one of several."""
Conditions: TypeAlias = Mapping[Criterion, Condition]


def pieces(condition: Condition) -> tuple[RealFunction, ...]:
    """The functions that must not all be positive: one, or those of a term."""
    if isinstance(condition, RealFunction):
        return (condition,)
    [term] = condition.terms
    return tuple(map(_rational, term))


def conditions(
    scene: Scene,
    free: Iterable[Knob],
    criteria: Iterable[Criterion],
    seen: Callable[[Distortion], Distortion] = lambda d: d,
) -> dict[Criterion, Condition]:
    """What criteria ask, with the free parameters left as symbols; of a region with several terms each of them.

    ``seen`` : as what the distortion is taken, where not as it is.
    """
    listed = [x.felt() for x in free]
    d, parts = seen(_distortion(scene, listed)), {part for x in listed for part in x.parts}
    found: dict[Criterion, Condition] = {}
    for x in opened(criteria, parts):
        own = x.function(d)
        terms = own.terms if isinstance(own, Lattice) else ((own,),)
        for i, term in enumerate(terms, 1):
            name = each(x, i) if len(terms) > 1 else x
            found[name] = Lattice((tuple(map(_upright, term)),)) if len(term) > 1 else _rational(term[0])
    return found


def each(x: Criterion, place: int) -> Criterion:
    """One of several conditions that a criterion is."""
    return replace(x, rule=f"{x.rule} ({place})")


def _distortion(scene: Scene, free: list[Knob]) -> Distortion:
    scene.knobs.need_numbers(free)
    return Distortion.of(scene.chain.at(values(x for x in scene.parameters if x not in free)))


def _rational(found: object) -> RealFunction:
    if not isinstance(found, RealFunction):
        raise SceneError("a requirement needs thresholds that are rational numbers")
    return found


def _upright(found: object) -> RealFunction:
    """With what changes the sign below the line brought above it."""
    f = _rational(found).function
    constant, factors = f.denominator.factor()
    turning = [factor for factor, n in factors if n % 2 and not _is_positive(factor)]
    if not turning and constant > 0:
        return RealFunction(f)
    top = prod(turning, start=f.numerator * constant)
    return RealFunction(f.ring.function(top, f.denominator * prod(turning, start=f.ring.constant(constant))))


def _is_positive(polynomial: Polynomial) -> bool:
    """Whether a factor shows to be positive: by even powers with positive coefficients, or as |f(j omega)|^2."""
    even = not any(n % 2 for row in polynomial.monoms() for n in row)
    return (even and all(x > 0 for x in polynomial.coeffs())) or _is_modulus(polynomial)


def _is_modulus(polynomial: Polynomial) -> bool:
    """Whether an irreducible polynomial is that of omega which f(s) f(-s) becomes, and not one in s^2 that is its own f."""
    rows = dict(monomials(polynomial))
    if any(row[0] % 2 for row in rows) or polynomial.leading_coefficient() < 0:
        return False
    in_s = polynomial.context().from_dict({row: -x if row[0] % 4 else x for row, x in rows.items()})
    return len(in_s.factor()[1]) > 1
