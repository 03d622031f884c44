"""What becomes of conditions as a parameter goes to 0 or without bound: the limit decides, also where it is not reached evenly.

A parameter t that is in no delay and no exponent is replaced by u = t, -t, 1/t or -1/t, which goes to 0 from above; the condition
times a power of u is then N(omega, u), a polynomial in u. Away from omega = 0 a ball tells the sign of N for 0 < u <= u_1. Near
omega = 0 the coefficient of each power of u is omega^e times a function that does not vanish, e exact: what is left is a sum of
monomials with balls for coefficients (``blowups``), however omega and u go to 0 together.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce
from itertools import groupby, pairwise
from operator import mul

import flint
from flint import arb, fmpq
from sympy import Expr, Rational, Symbol

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.reals import Ball, dyadic, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.verbs.require.blowups import is_negative, positive_along
from haptisym.verbs.require.clusters import Strips, places
from haptisym.verbs.require.knownsums import Coefficient, Key, Known, added, of_parts
from haptisym.verbs.require.lowest import beginning
from haptisym.verbs.require.monomials import Terms
from haptisym.verbs.require.places import CellVerdict, Strip
from haptisym.verbs.require.strips import Shape

_SAMPLES, _KNOWN, _LENGTHS = 8, 6, (16, 40)
"""Of the band; Taylor's coefficients at omega = 0 that are taken apart, and how many are looked at for the first of them."""
_NEARER = (0, 2, 4)
"""How often u is taken four times as small for the band away from omega = 0, one number after the other."""
_TANGENTS = (0, 1, -1, 3, -3)
"""Of half a phase, that are tried."""
_PIECES, _FAR = 16, (16, 64, 256, 1024)
"""Of the band; and radians at its high end beyond which a delay counts as long."""


@dataclass(frozen=True)
class Limit:
    """Conditions near u = 0; ``inverse``: whether u is 1/t, ``sign`` that of t."""

    shapes: tuple[Shape, ...]
    band: tuple[Expr, Expr]
    inverse: bool
    sign: int
    _terms: dict[tuple[Shape, int], Terms] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def of(
        cls, functions: Sequence[RealFunction], free: Symbol, band: tuple[Expr, Expr], *, inverse: bool, sign: int
    ) -> Limit | None:
        """None where the parameter is in a delay or an exponent."""
        axis = functions[0].axis
        if any(a.rate.has(free) for a in axis.angles) or any(x.has(free) for x in axis.orders):
            return None
        shapes = []
        for f in functions:
            own = Shape.of(f, free)
            turned = _turned(own.polynomial, axis.meanings.index(free), inverse=inverse, sign=sign)
            shapes.append(Shape(turned, axis, free, own.degrees))
        return cls(tuple(shapes), band, inverse, sign)

    def verdict(self, reach: Fraction, parts: int) -> tuple[CellVerdict, Fraction]:
        """What is known for all 0 < u <= a number that is not larger than ``reach``, and that number.

        ``parts`` : of the band, of which the first one is taken as that near omega = 0.
        """
        wholes = [Strip(shape, shape.over(arb(0).union(dyadic(reach)))) for shape in self.shapes]
        if any(map(self._is_broken, wholes)):
            return CellVerdict.BROKEN, _exact(dyadic(reach))
        found = []
        for whole in wholes:
            found.append(self._of(whole, dyadic(reach), parts))
            if found[-1][0] is CellVerdict.BROKEN:
                return found[-1]
        is_kept = all(verdict is CellVerdict.KEPT for verdict, _ in found)
        return CellVerdict.KEPT if is_kept else CellVerdict.OPEN, min([reach, *(u for _, u in found)])

    def _is_broken(self, whole: Strip) -> bool:
        """Whether some frequency shows it at once."""
        low, high = (expression_ball(x) for x in self.band)
        return any(whole.value((low + (high - low) * i / _SAMPLES).mid()) > 0 for i in range(1, _SAMPLES))

    def _of(self, whole: Strip, reach: Ball, parts: int) -> tuple[CellVerdict, Fraction]:
        if self.band[0] != 0:
            return _alone(places(Strips((whole,)), self.band)), _exact(reach)
        shape, near = whole.shape, (expression_ball(self.band[1]) / parts).upper()
        try:
            if (shape, parts) not in self._terms:
                self._terms[shape, parts] = _terms(shape, near)
            terms = self._terms[shape, parts]
        except UndecidedError:
            return CellVerdict.OPEN, _exact(reach)
        broken = positive_along(terms, near, reach)
        if broken is not None and broken > 0:
            return CellVerdict.BROKEN, _exact(broken)
        if not is_negative(terms, near, reach):
            return CellVerdict.OPEN, _exact(reach)
        for n in _NEARER:  # all that is left is the band beyond
            own = Strip(shape, shape.over(arb(0).union(reach / 4**n)))
            found = _alone(places(Strips((own,)), (self.band[1] / parts, self.band[1])))
            if found is not CellVerdict.OPEN:
                return found, _exact(reach / 4**n)
        return CellVerdict.OPEN, _exact(reach)


def short(functions: Sequence[RealFunction], free: Symbol, band: tuple[Expr, Expr], reach: Fraction) -> CellVerdict:
    """What is known for all 0 < t <= a number, t being part of delays: N is t^n times an n-th Taylor coefficient in between."""
    verdicts = set()
    for f in functions:
        shape: Shape | None = Shape.of(f, free)
        for _ in range(_order_in(f, free)):
            shape = shape.change if shape is not None else None
        if shape is None:
            return CellVerdict.OPEN
        whole = Strip(shape, shape.over(arb(0).union(dyadic(reach))))
        verdicts.add(_alone(places(Strips((whole,)), band)))
    return next(x for x in (CellVerdict.BROKEN, CellVerdict.OPEN, CellVerdict.KEPT) if x in verdicts)


def _order_in(f: RealFunction, free: Symbol) -> int:
    """A power of the parameter that every term holds, by itself or in tangents."""
    axis = f.axis
    own = [axis.meanings.index(free)]
    own += [i for i, a in enumerate(axis.angles, axis.size) if not a.constant and a.rate.has(free)]
    return min(sum(int(e[i]) for i in own) for e in f.function.numerator.monoms())


def long(functions: Sequence[RealFunction], free: Symbol, band: tuple[Expr, Expr]) -> Fraction | None:
    """A number beyond which a delay breaks a condition: at one phase it is broken on a piece of the band, which holds all phases.

    Holds, beyond the Nyquist frequency too: where the parameter stands beside its delay as well, by its inverse u.
    """
    axis = functions[0].axis
    turning = [i for i, a in enumerate(axis.angles) if a.rate.has(free)]
    if len(turning) != 1 or axis.angles[turning[0]].constant or any(x.has(free) for x in axis.orders):
        return None
    index, rate = turning[0], axis.angles[turning[0]].rate.diff(free)
    low, high = (expression_ball(x) for x in band)
    edges = [low + (high - low) * i / _PIECES for i in range(_PIECES + 1)]
    found: list[float] = []
    for far in _FAR:
        reach = float(far / (expression_ball(rate) * high))  # of the parameter
        for shape in (x for f in functions for x in _at_phases(f, free, index)):
            compiled = shape.over(arb(0).union(1 / arb(reach)))
            broken = [compiled.over(a.union(b))[0] > 0 for a, b in pairwise(edges)]
            longest = max(sum(1 for _ in run) if is_broken else 0 for is_broken, run in groupby(broken))
            if longest:
                length = (high - low) * longest / _PIECES
                found.append(max(reach, 1.01 * float(2 * arb.pi() / (expression_ball(rate) * length))))
    return Fraction(min(found)) if found else None


def _at_phases(f: RealFunction, free: Symbol, index: int) -> Iterator[Shape]:
    """A condition at some phases of a delay, by the inverse of what stands beside it."""
    axis, own = f.axis, Shape.of(f, free)
    degrees = tuple(0 if i == index else n for i, n in enumerate(own.degrees))
    for tangent in _TANGENTS:
        polynomial = own.polynomial.subs({f"x{axis.size + index}": tangent})
        if not polynomial.is_zero():
            turned = _turned(polynomial, axis.meanings.index(free), inverse=True, sign=1)
            yield Shape(turned, axis, free, degrees)


def _alone(found: CellVerdict | Sequence[object]) -> CellVerdict:
    if isinstance(found, CellVerdict):
        return found
    return CellVerdict.OPEN if found else CellVerdict.KEPT


def _exact(x: Ball) -> Fraction:
    """A double that is not larger."""
    with flint.ctx.workprec(53):
        return Fraction(float(x.lower()))


def _turned(polynomial: Polynomial, index: int, *, inverse: bool, sign: int) -> Polynomial:
    """A polynomial in t as one in u, without the powers of u that all terms have: of the same sign."""
    rows = dict(monomials(polynomial))
    powers = [int(e[index]) for e in rows]
    least, most = min(powers), max(powers)
    found = {}
    for e, value in rows.items():
        n = int(e[index])
        key = [int(x) for x in e]
        key[index] = most - n if inverse else n - least
        found[tuple(key)] = -value if sign < 0 and n % 2 else value
    return polynomial.context().from_dict(found)


def _terms(shape: Shape, near: Ball) -> Terms:
    """The condition from omega = 0 to a number, as a sum of monomials in omega and u: the first ones exact, then with balls."""
    axis, index = shape.axis, shape.axis.meanings.index(shape.free)
    first = axis.size + len(axis.angles)
    groups: dict[tuple[int, ...], dict[tuple[int, ...], fmpq]] = {}
    for e, value in monomials(shape.polynomial):
        own = [int(n) for n in e]
        key = (own[index], *own[first:])
        bare = tuple(0 if i == index or i >= first else n for i, n in enumerate(own))
        groups.setdefault(key, {})[bare] = value
    found: dict[tuple[Fraction, Fraction], Coefficient] = {}
    for (power, *orders), own_terms in groups.items():
        part = Shape(axis.context.from_dict(own_terms), axis, shape.free, shape.degrees)
        start = sum((_rational(a) * n for a, n in zip(axis.orders, orders, strict=True)), Fraction(0))
        for n, value in _expanded(part, near):
            place = start + n, Fraction(power)
            found[place] = added(found.get(place, fmpq(0)), value)
    return found


def _expanded(part: Shape, near: Ball) -> Iterator[tuple[int, Coefficient]]:
    """Taylor's coefficients at omega = 0 of a function without powers: those that are not 0, the last one a ball."""
    order, rows = _first(part)
    units = _units(part, {key for row in rows for key in row})
    for n in range(order, order + _KNOWN):
        value = of_parts({key if key in units else (): x for key, x in rows[n].items()}, units)
        if isinstance(value, Known) or value:
            yield n, value
    yield order + _KNOWN, part.over(arb(0)).taylor(arb(0).union(near), order + _KNOWN)


def _units(part: Shape, keys: Iterable[Key]) -> dict[Key, Ball]:
    """Balls around the products of pi and of waves of constant angles that numbers of such keys are multiplied with."""
    axis, waves = part.axis, dict[int, list[Ball]]()
    for i, (angle, degree) in enumerate(zip(axis.angles, part.degrees, strict=True), axis.size):
        if angle.constant and degree:
            sine, cosine = (expression_ball(angle.rate) / 2).sin_cos()
            waves[i] = [sine**k * cosine ** (degree - k) for k in range(degree + 1)]
    found: dict[Key, Ball] = {(): arb(1)}
    for key in keys:
        if waves or any(key):
            found[key] = reduce(mul, (own[key[i]] for i, own in waves.items()), arb.pi() ** key[1])
    return found


def _first(part: Shape) -> tuple[int, list[dict[tuple[int, ...], fmpq]]]:
    """The order of the first coefficient that is not 0, and enough of them."""
    for length in _LENGTHS:
        rows = beginning(part.axis, part.polynomial, part.degrees, length)
        order = next((n for n, row in enumerate(rows) if any(row.values())), length)
        if order + _KNOWN < length:
            return order, rows
    raise UndecidedError("how a condition begins at omega = 0")


def _rational(x: Expr) -> Fraction:
    if not isinstance(x, Rational):
        raise UndecidedError("powers of omega whose order is no rational number")
    return Fraction(int(x.p), int(x.q))
