"""What becomes of conditions as a parameter goes to 0 or without bound.

Rational multiples of a few numbers, added: real numbers of which it is known where they cancel.

The coefficients of a condition at omega = 0 hold pi and the sines and cosines of constant angles, which are left as they are:
what is 0 whatever these may be is seen to be 0, and two sums that are in a rational ratio are seen to be.

Sums of powers of one number with exact coefficients: where they change signs, and where they touch 0.

Sums of monomials c X^a Y^b with real exponents, over boxes that may reach to X = 0 or Y = 0, in balls.

The sign of a sum of monomials c X^a Y^b with real exponents on a box that may reach to X = 0 or Y = 0, in balls.

Where no term is left at the corner X = Y = 0, two charts take its place, Y = X^p v and X = Y^(1/p) y, p a slope of Newton's
polygon: together they cover the box, and in both the sum is a simpler one of the same kind, times a power. Where what is left at
X = 0 has a double root v_0, a rational number, v = v_0 + w and v = v_0 - w: a corner again. That is exact, as coefficients are.

Taylor's coefficients of sums of waves at omega = 0, whatever their constant angles: exact.

What becomes of conditions as a parameter goes to 0 or without bound: the limit decides, also where it is not reached evenly.

A parameter t that is in no delay and no exponent is replaced by u = t, -t, 1/t or -1/t, which goes to 0 from above; the condition
times a power of u is then N(omega, u), a polynomial in u. Away from omega = 0 a ball tells the sign of N for 0 < u <= u_1. Near
omega = 0 the coefficient of each power of u is omega^e times a function that does not vanish, e exact: what is left is a sum of
monomials with balls for coefficients (``blowups``), however omega and u go to 0 together.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, lru_cache, reduce
from itertools import accumulate, groupby, pairwise, repeat
from math import lcm
from operator import mul
from typing import Any, TypeAlias

import flint
import numpy as np
from flint import arb, arb_mat, arb_poly, fmpq, fmpq_poly
from sympy import Expr, Rational, Symbol

from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, dyadic, expression_ball
from haptisym.kernel.rings import Polynomial, monomials
from haptisym.verbs.require.places import CellVerdict, Shape, Strip, Strips, places

Key: TypeAlias = tuple[int, ...]
"""The name of a number: the exponents of what it is a product of; without any, that of 1."""
Coefficient: TypeAlias = Any
"""A rational number of FLINT's, a ``Known``, or a ball."""


@dataclass(frozen=True, eq=False)
class Known:
    """The sum of rational multiples, none of them 0, of numbers that are told apart by names; ``units``: balls around these."""

    parts: Mapping[Key, fmpq]
    units: Mapping[Key, Ball] = field(repr=False)

    @cached_property
    def ball(self) -> Ball:
        """A ball around it, of the working precision that was the first."""
        return sum((self.units[key] * value for key, value in self.parts.items()), arb(0))


def ball(x: Coefficient) -> Ball:
    """A ball around a coefficient."""
    return x.ball if isinstance(x, Known) else arb(x)


def of_parts(parts: Mapping[Key, fmpq], units: Mapping[Key, Ball]) -> Coefficient:
    """The sum of some multiples: a rational number where it is one.

    >>> of_parts({(): fmpq(1, 2), (1,): fmpq(0)}, {(1,): arb.pi()})
    1/2
    """
    left = {key: value for key, value in parts.items() if value}
    return left.get((), fmpq(0)) if left.keys() <= {()} else Known(left, units)


def added(x: Coefficient, y: Coefficient) -> Coefficient:
    """The sum of two coefficients, a ball where one is.

    >>> pi = Known({(1,): fmpq(2)}, {(1,): arb.pi()})
    >>> added(pi, Known({(1,): fmpq(-2)}, {(1,): arb.pi()})), round(float(ball(added(pi, fmpq(1)))), 3)
    (0, 7.283)
    """
    if isinstance(x, fmpq) and isinstance(y, fmpq):
        return x + y
    if not is_exact(x) or not is_exact(y):
        return ball(x) + ball(y)
    parts = dict(parts_of(x))
    for key, value in parts_of(y).items():
        parts[key] = parts.get(key, fmpq(0)) + value
    return of_parts(parts, {**_units(x), **_units(y)})


def is_exact(x: Coefficient) -> bool:
    """Whether a coefficient is not just a ball."""
    return isinstance(x, fmpq | Known)


def parts_of(x: Coefficient) -> Mapping[Key, fmpq]:
    """The multiples of a coefficient that is exact."""
    return x.parts if isinstance(x, Known) else {(): x} if x else {}


def _units(x: Coefficient) -> Mapping[Key, Ball]:
    return x.units if isinstance(x, Known) else {(): arb(1)}


@dataclass(frozen=True, eq=False)
class ExactPolynomial:
    """A polynomial with coefficients that are exact: for each number by its name a polynomial over the rational numbers."""

    parts: Mapping[Key, fmpq_poly]
    units: Mapping[Key, Ball] = field(repr=False)

    @classmethod
    def of(cls, coefficients: Mapping[int, Coefficient]) -> ExactPolynomial:
        """Of coefficients, none of them a mere ball, by their powers."""
        rows: dict[Key, list[fmpq]] = {}
        units: dict[Key, Ball] = {}
        for n, value in coefficients.items():
            units.update(_units(value))
            for key, part in parts_of(value).items():
                rows.setdefault(key, [fmpq(0)] * (max(coefficients) + 1))[n] = part
        return cls({key: fmpq_poly(row) for key, row in rows.items()}, units)

    def shifted(self, at: fmpq, sign: int) -> Iterable[tuple[int, Coefficient]]:
        """The coefficients that are not 0 in w of what it is at ``at + sign w``."""
        inside = fmpq_poly([at, sign])
        moved = {key: own(inside) for key, own in self.parts.items()}
        for n in range(max([0, *(own.degree() + 1 for own in moved.values())])):
            value = of_parts({key: own[n] for key, own in moved.items()}, self.units)
            if isinstance(value, Known) or value:
                yield n, value

    @cached_property
    def common(self) -> fmpq_poly:
        """The largest polynomial over the rational numbers that divides it: all of it, up to one irrational factor, or less."""
        return reduce(fmpq_poly.gcd, self.parts.values(), fmpq_poly([]))

    @cached_property
    def rest(self) -> arb_poly:
        """What is left of it over that polynomial, in balls."""
        return sum((arb_poly(own // self.common) * self.units[key] for key, own in self.parts.items()), arb_poly([]))


@dataclass(frozen=True, eq=False)
class Row:
    """A polynomial in Y^(1/below)."""

    polynomial: ExactPolynomial
    below: int

    @classmethod
    def of(cls, values: Mapping[Fraction, Coefficient]) -> Row | None:
        """Of coefficients by their exponents, which are not negative; None where one is but a ball."""
        if not all(map(is_exact, values.values())):
            return None
        below = lcm(*(b.denominator for b in values))
        return cls(ExactPolynomial.of({int(b * below): x for b, x in values.items()}), below)

    @cached_property
    def _factors(self) -> list[tuple[Any, int]]:
        """Those of what the row is up to an irrational factor."""
        common = self.polynomial.common
        return list(common.factor()[1]) if common else []

    @cached_property
    def touches(self) -> tuple[fmpq, ...]:
        """Rational numbers > 0 at which the row has a double root, or one of more; none where Y itself is not in it."""
        if self.below != 1:
            return ()
        linear = (-f[0] / fmpq(f[1]) for f, n in self._factors if n > 1 and f.degree() == 1)
        return tuple(sorted(x for x in linear if x > 0))

    @cached_property
    def _turns(self) -> list[Ball]:
        """About where the polynomial may change signs, up to the irrational factor."""
        odd = (root for f, n in self._factors if n % 2 for root, _ in f.complex_roots())
        return [root.real for root in odd if root.imag.contains(0)]

    def is_nowhere_positive(self, low: Ball, high: Ball) -> bool:
        """Whether the row shows to be positive at no Y^(1/below) between two numbers: what changes signs is squared."""
        common = self.polynomial.common
        if not common:
            return True
        if any(not root <= low and not root >= high for root in self._turns):
            return False
        rest = self.polynomial.rest(low.union(high))
        if not rest > 0 and not rest < 0:
            return False
        middle = arb_poly(common)(((3 * low + 4 * high) / 7).mid())
        return bool(middle * rest < arb(0))


Terms: TypeAlias = Mapping[tuple[Fraction, Fraction], Coefficient]
"""Coefficients by the exponents of X and Y."""
Side: TypeAlias = tuple[Ball, Ball]


@dataclass(frozen=True, eq=False)
class _Table:
    """Coefficients by the numbers of their rows and columns."""

    values: Mapping[tuple[int, int], Coefficient]
    shape: tuple[int, int]

    @cached_property
    def matrix(self) -> Any:
        """All of them, in balls of the working precision that was the first."""
        flat = [arb(0)] * (self.shape[0] * self.shape[1])
        for (i, j), value in self.values.items():
            flat[i * self.shape[1] + j] = ball(value)
        return arb_mat(*self.shape, flat)

    @cached_property
    def sizes(self) -> Any:
        """About the logarithms of the negative ones, -inf in place of others."""
        found = np.full(self.shape, -np.inf)
        for place, value in self.values.items():
            if ball(value) < 0:
                found[place] = float(abs(ball(value)).mid().log())
        return found


@dataclass(frozen=True, eq=False)
class Monomials:
    """A sum by its exponents of X and of Y, each in order.

    >>> from flint import fmpq
    >>> own = Monomials.of({(Fraction(1, 2), Fraction(0)): fmpq(3), (Fraction(1), Fraction(2)): fmpq(-1)})
    >>> float(own.over((arb(4), arb(4)), (arb(1), arb(1)))), own.reduced((arb(0), arb(1)), (arb(0), arb(1))).has_constant
    (2.0, True)
    """

    across: tuple[Fraction, ...]
    up: tuple[Fraction, ...]
    table: _Table
    _rows: dict[int, Row | None] = field(default_factory=dict, init=False, repr=False)
    _above: dict[int, Monomials | None] = field(default_factory=dict, init=False, repr=False)
    _shifted: dict[tuple[fmpq, int], Monomials] = field(default_factory=dict, init=False, repr=False)
    _risen: dict[Fraction, Monomials] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(cls, terms: Terms) -> Monomials:
        """Of the coefficients by the exponents."""
        below, under = (lcm(*(e[i].denominator for e in terms)) for i in (0, 1))
        return cls.on({(int(a * below), int(b * under)): value for (a, b), value in terms.items()}, below, under)

    @classmethod
    def on(cls, cells: Mapping[tuple[int, int], Coefficient], below: int, under: int) -> Monomials:
        """Of the coefficients by the numerators of the exponents, over two numbers."""
        across, up = (sorted({e[i] for e in cells}) for i in (0, 1))
        rows, columns = ({x: i for i, x in enumerate(own)} for own in (across, up))
        values = {(rows[a], columns[b]): value for (a, b), value in cells.items()}
        table = _Table(values, (len(across), len(up)))
        return cls(tuple(Fraction(x, below) for x in across), tuple(Fraction(y, under) for y in up), table)

    @cached_property
    def terms(self) -> Terms:
        """The coefficients by the exponents."""
        return {(self.across[i], self.up[j]): value for (i, j), value in self.table.values.items()}

    @property
    def has_constant(self) -> bool:
        """Whether there is a term without X and Y."""
        return (Fraction(0), Fraction(0)) in self.terms

    def row(self, n: int) -> Row | None:
        """What stands before the n-th power of X; None where a coefficient of it is but a ball."""
        if n not in self._rows:
            self._rows[n] = Row.of({self.up[j]: value for (i, j), value in self.table.values.items() if i == n})
        return self._rows[n]

    def above(self, n: int) -> Monomials | None:
        """The sum without the first powers of X up to the n-th; None where nothing is left."""
        if n not in self._above:
            (below, xs), (under, ys) = self._lattices
            left = {(xs[i], ys[j]): value for (i, j), value in self.table.values.items() if i > n}
            self._above[n] = Monomials.on(left, below, under) if left else None
        return self._above[n]

    @cached_property
    def touches(self) -> tuple[fmpq, ...]:
        """Rational Y > 0 at which what stands before the least power of X has a double root, or one of more."""
        first = self.row(0)
        return first.touches if first and all(b.denominator == 1 for b in self.up) else ()

    def shifted(self, at: fmpq, sign: int) -> Monomials:
        """The sum in X and w, Y = at + sign w, where Y is in whole powers: what cancels there is not in it."""
        if (at, sign) not in self._shifted:
            (below, xs), (_, ys) = self._lattices
            rows: dict[int, dict[int, Coefficient]] = {x: {} for x in xs}
            for (i, j), value in self.table.values.items():
                rows[xs[i]][ys[j]] = value
            found = {(x, n): value for x, row in rows.items() for n, value in _moved(row, at, sign).items()}
            self._shifted[at, sign] = Monomials.on(found, below, 1)
        return self._shifted[at, sign]

    @cached_property
    def slope(self) -> tuple[Fraction, Ball]:
        """The slope p of the edge of Newton's polygon next to X = 0, and about where along Y = X^p v its terms are alike.

        That is beyond where these touch 0, which is all on one side of it then.
        """
        b = min(b for a, b in self.terms if a == 0)
        others = [(a / (b - other), b - other, value) for (a, other), value in self.terms.items() if other < b]
        p, rise, value = min(others, key=lambda x: x[:2])
        first, last = (abs(float(ball(x).mid())) for x in (self.terms[Fraction(0), b], value))
        alike = (last / first) ** (1 / float(rise)) if first and last else 1.0
        return p, arb(max([alike, *(2 * float(arb(x)) for x in self.risen(p).touches)]))

    def risen(self, p: Fraction) -> Monomials:
        """The sum in X and v over a power of X, Y = X^p v."""
        if p not in self._risen:
            (below, xs), (under, ys) = self._lattices
            common = lcm(below, p.denominator * under)
            across, steps = [x * (common // below) for x in xs], [int(p * y * common / under) for y in ys]
            found = {(across[i] + steps[j], ys[j]): value for (i, j), value in self.table.values.items()}
            least = min(a for a, _ in found)
            self._risen[p] = Monomials.on({(a - least, b): value for (a, b), value in found.items()}, common, under)
        return self._risen[p]

    def along(self, v: Ball) -> tuple[Ball, ...]:
        """What stands before the powers of X, in order, at a number Y = v >= 0."""
        powers = arb_mat(len(self.up), 1, _ranges(self._lattices[1], (v, v), Fraction(0)))
        return tuple((self.table.matrix * powers).entries())

    def over_power(self, a: Fraction, b: Fraction) -> Monomials:
        """The sum over X^a Y^b."""
        if not a and not b:
            return self
        return Monomials(tuple(x - a for x in self.across), tuple(x - b for x in self.up), self.table)

    def reduced(self, across: Side, up: Side) -> Monomials:
        """Without the powers of X and Y that all terms have, where these may be 0."""
        return self.over_power(
            self.across[0] if across[0].is_zero() else Fraction(0), self.up[0] if up[0].is_zero() else Fraction(0)
        )

    def over(self, across: Side, up: Side, less: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))) -> Ball:
        """The values on a box, of the sum over X^a Y^b where such are given: exponents of its terms, or 0."""
        xs = arb_mat(1, len(self.across), _ranges(self._lattices[0], across, less[0]))
        ys = arb_mat(len(self.up), 1, _ranges(self._lattices[1], up, less[1]))
        return (xs * (self.table.matrix * ys))[0, 0]

    @cached_property
    def _lattices(self) -> tuple[_Lattice, _Lattice]:
        return _on_lattice(self.across), _on_lattice(self.up)

    @cached_property
    def _floats(self) -> tuple[Any, Any]:
        """The exponents, rounded."""
        return np.array(self.across, float)[:, None], np.array(self.up, float)

    def most_negative(self, x: Ball, y: Ball) -> tuple[Fraction, Fraction] | None:
        """The exponents of about the largest negative monomial at a point; None where none is negative."""
        sizes = self.table.sizes + self._floats[0] * float(x.log()) + self._floats[1] * float(y.log())
        i, j = np.unravel_index(int(np.argmax(sizes)), sizes.shape)
        return (self.across[i], self.up[j]) if sizes[i, j] > -np.inf else None


def _moved(row: Mapping[int, Coefficient], at: fmpq, sign: int) -> dict[int, Coefficient]:
    """The coefficients of a polynomial in w, Y = at + sign w."""
    found = dict(ExactPolynomial.of({n: value for n, value in row.items() if is_exact(value)}).shifted(at, sign))
    if not all(map(is_exact, row.values())):
        rest = [row[n] if n in row and not is_exact(row[n]) else arb(0) for n in range(max(row) + 1)]
        for n, value in enumerate(arb_poly(rest)(arb_poly([at, sign])).coeffs()):
            found[n] = added(found.get(n, fmpq(0)), value)
    return found


_Lattice: TypeAlias = tuple[int, tuple[int, ...]]
"""A denominator, and numerators over it."""


def _on_lattice(exponents: Sequence[Fraction]) -> _Lattice:
    below = lcm(*(x.denominator for x in exponents))
    return below, tuple(int(x * below) for x in exponents)


def _ranges(lattice: _Lattice, side: Side, less: Fraction) -> list[Ball]:
    """Powers of all numbers between two, which are not negative, with exponents less by one of them."""
    below, exponents = lattice
    if less:
        exponents = tuple([n - int(less * below) for n in exponents])
    low, high = (x if below == 1 else power(x, Fraction(1, below)) for x in side)
    if side[0] is side[1]:
        return [low**n for n in exponents]
    if side[0].is_zero():
        return [arb(0).union(high**n) if n else arb(1) for n in exponents]
    return [(low**n).union(high**n) for n in exponents]


def power(x: Ball, a: Fraction) -> Ball:
    """A number >= 0 to a power >= 0; of a positive one to any."""
    if a == 0:
        return arb(1)
    if a.denominator == 1:
        return x ** int(a)
    return arb(0) if x.is_zero() else (x.log() * a.numerator / a.denominator).exp()


_MOST_BOXES, _MOST_CHARTS, _MOST_HALVINGS = 300, 8, 20
_MOST_TOUCHES = 2
"""Curves beside a curve beside which the sum is positive."""


def is_negative(terms: Terms, x: Ball, y: Ball) -> bool:
    """Whether a sum shows to be negative for all 0 < X <= x and 0 < Y <= y."""
    given = Monomials.of(terms)
    return _is_negative(given, x, y, matching=False) or _is_negative(given, x, y, matching=True)


def _is_negative(given: Monomials, x: Ball, y: Ball, *, matching: bool) -> bool:
    """``matching`` : whether charts are taken of a corner whose far end lies on the curve on which they meet."""
    waiting: list[tuple[Monomials, Side, Side, int]] = [(given, (arb(0), x), (arb(0), y), 0)]
    for _ in range(_MOST_BOXES):
        if not waiting:
            return True
        tick()
        own, across, up, charts = waiting.pop()
        own = own.reduced(across, up)
        if _shows_negative(own, across, up) or _is_negative_above_rows(own, across, up):
            continue
        if any(own.over((a, a), (b, b)) > 0 for a in across for b in up if not _is_bare(own, a, b)):
            return False
        touched = _at_touch(own, across, up)
        if touched:
            waiting += [(*chart, charts) for chart in touched]
        elif not _is_bare(own, across[0], up[0]):
            waiting += [(own, a, b, charts) for a, b in _halves(own, across, up)]
        elif charts == _MOST_CHARTS:
            return False
        else:
            corner, rest = _matched(own, across[1], up[1]) if matching else ((across[1], up[1]), [])
            waiting += [(own, *box, charts) for box in rest]
            waiting += [(*chart, charts + 1) for chart in _charts(own, *corner)]
    return False


def _is_negative_above_rows(own: Monomials, across: Side, up: Side) -> bool:
    """Whether rows of like powers of X are nowhere positive, exactly so, and the sum of the others is negative on a box."""
    if not across[0].is_zero():
        return False
    for n in range(len(own.across)):
        row, left = own.row(n), own.above(n)
        if row is None or not row.is_nowhere_positive(*(power(y, Fraction(1, row.below)) for y in up)):
            return False
        if left and _shows_negative(left.reduced(across, up), across, up):
            return True
    return False


def _shows_negative(own: Monomials, across: Side, up: Side) -> bool:
    """By the values on a box; or by those over the largest negative monomial, as far as it does not vanish there."""
    if own.over(across, up) < 0:
        return True
    if across[0].is_zero() and up[0].is_zero():
        return False
    largest = own.most_negative(across[1], up[1])
    if largest is None:
        return False
    left, low = (Fraction(0) if side[0].is_zero() else n for side, n in zip((across, up), largest, strict=True))
    return bool(own.over(across, up, (left, low)) < 0)


def positive_along(terms: Terms, x: Ball, y: Ball) -> Ball | None:
    """A number such that for each 0 < Y <= it the sum is positive at some 0 < X <= x; None where none shows."""
    corner = (arb(0), x), (arb(0), y)
    own = Monomials.of(terms).reduced(*corner)
    if own.over(*corner) > 0:
        return y
    for curve, chart in _curves(own, _MOST_TOUCHES):
        values, reach = chart.along(curve.v), x
        along = Monomials.of({(a, Fraction(0)): c for a, c in zip(chart.across, values, strict=True)})
        for _ in range(_MOST_HALVINGS):
            height = curve.height(reach).lower()
            if height > 0 and along.over((arb(0), reach), (arb(1), arb(1))) > 0:
                return height.min(y)
            reach = reach / 4
    return None


@dataclass(frozen=True)
class _Curve:
    """Y = X^p v; or v = at + sign w in its place, w on a curve of the same kind, for each of ``outer`` (p, at, sign)."""

    p: Fraction
    v: Ball
    outer: tuple[tuple[Fraction, fmpq, int], ...] = ()

    def height(self, x: Ball) -> Ball:
        """Where the curve is at a number X > 0."""
        found = power(x, self.p) * self.v
        for p, at, sign in reversed(self.outer):
            found = power(x, p) * (found * sign + at)
        return found


def _is_bare(own: Monomials, a: Ball, b: Ball) -> bool:
    """Whether a corner of a box is X = Y = 0, and no term is left there."""
    return a.is_zero() and b.is_zero() and not own.has_constant


def _halves(own: Monomials, across: Side, up: Side) -> list[tuple[Side, Side]]:
    """A box in two pieces, along what changes the values more."""
    along_x = sum((own.over(across, (b, b)).rad() for b in up), arb(0))
    along_y = sum((own.over((a, a), up).rad() for a in across), arb(0))
    if along_x > along_y:
        middle = _middle(*across)
        return [((across[0], middle), up), ((middle, across[1]), up)]
    middle = _middle(*up)
    return [(across, (up[0], middle)), (across, (middle, up[1]))]


def _middle(low: Ball, high: Ball) -> Ball:
    return (high / 4 if low.is_zero() else (low * high).sqrt() if high > 2 * low else (low + high) / 2).mid()


def _at_touch(own: Monomials, across: Side, up: Side) -> list[tuple[Monomials, Side, Side]]:
    """A box beside X = 0 in two, from where the terms that are left at X = 0 touch 0: a corner of both, without a term.

    Not where one power of X after the other shows to be nowhere positive there, as it does in a smaller box.
    """
    inside = (x for x in own.touches if not up[0] > x and not up[1] < x) if across[0].is_zero() else ()
    at = next((x for x in inside if not _is_negative_by_rows(own.shifted(x, 1))), None)
    if at is None:
        return []
    sides = (-1, at - up[0]), (1, up[1] - at)
    return [(own.shifted(at, sign), across, (arb(0), size.upper())) for sign, size in sides if size > 0]


def _is_negative_by_rows(own: Monomials) -> bool:
    """Whether next to Y = 0, on both sides, the powers of X up to one with a constant go with what is nowhere positive."""
    for a in own.across:
        lowest = min(b for other, b in own.terms if other == a)
        if lowest % 2 or not ball(own.terms[a, lowest]) < 0:
            return False
        if not lowest:
            return True
    return False


def _matched(own: Monomials, x: Ball, y: Ball) -> tuple[tuple[Ball, Ball], list[tuple[Side, Side]]]:
    """The largest corner whose far end lies on the curve on which charts meet, and the rest of a box."""
    p, v = own.slope
    height = (v * power(x, p)).mid()
    if height < y:
        return (x, height), [((arb(0), x), (height, y))]
    width = ((y / v).log() * p.denominator / p.numerator).exp().mid()
    return (width, y), ([((width, x), (arb(0), y))] if width < x else [])


def _charts(own: Monomials, x: Ball, y: Ball) -> list[tuple[Monomials, Side, Side]]:
    """The two that take the place of a corner."""
    p, v = own.slope
    beyond = (-v.log() * p.denominator / p.numerator).exp().upper()
    return [
        (own.risen(p), (arb(0), x), (arb(0), v)),
        (Monomials.of({(a, b + a / p): c for (a, b), c in own.terms.items()}), (arb(0), beyond), (arb(0), y)),
    ]


def _curves(
    own: Monomials, touches: int, outer: tuple[tuple[Fraction, fmpq, int], ...] = ()
) -> Iterator[tuple[_Curve, Monomials]]:
    """Curves into the corner, of each slope of Newton's polygon, and beside where its terms touch 0; and the sum in X and v."""
    corner, total, chart = (arb(0), arb(1)), Fraction(0), own
    while not chart.has_constant:
        p, v = chart.slope
        total, chart = total + p, chart.risen(p)
        yield from ((_Curve(total, v * arb(2) ** n, outer), chart) for n in (0, 1, -1, 2, -2, 3, -3, 6, -6))
        for at in chart.touches if touches else ():
            for sign in (1, -1):
                beside = chart.shifted(at, sign).reduced(corner, corner)
                yield from _curves(beside, touches - 1, (*outer, (total, at, sign)))
        chart = chart.reduced(corner, corner)


def beginning(
    axis: Axis, polynomial: Polynomial, degrees: Sequence[int], length: int
) -> list[dict[tuple[int, ...], fmpq]]:
    """By the powers of omega, as many as asked for, numbers by the exponents of all else (pi, tangents of constant angles).

    The polynomial has neither parameters nor powers omega^alpha; a tangent^k stands for sin^k cos^(degree - k) of the half angle.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from sympy import Rational
    >>> axis = Ring([], [Rational(1, 10)]).axis
    >>> w, _, T = axis.context.gens()
    >>> beginning(axis, T - w / 20, [2], 4)[3]   # (sin(omega/20) - omega/20 cos(omega/20)) cos(omega/20)
    {(0, 0, 0): 1/24000}
    """
    turning = [i for i, angle in enumerate(axis.angles, axis.size) if not angle.constant]
    waves = {i: _waves(axis.angles[i - axis.size].rate, degrees[i - axis.size], length) for i in turning}
    rows: dict[tuple[tuple[int, ...], tuple[int, ...]], list[fmpq]] = {}
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        if own[0] < length:
            key = tuple(0 if i == 0 or i in waves else n for i, n in enumerate(own))
            row = rows.setdefault((key, tuple(own[i] for i in turning)), [fmpq(0)] * length)
            row[own[0]] += value
    total: dict[tuple[int, ...], fmpq_poly] = {}
    for (key, turns), row in rows.items():
        factors = (waves[i][k] for i, k in zip(turning, turns, strict=True))
        series = reduce(lambda x, y: x.mul_low(y, length), factors, fmpq_poly(row))
        total[key] = total[key] + series if key in total else series
    return [{key: series[n] for key, series in total.items()} for n in range(length)]


@lru_cache(maxsize=64)
def _waves(rate: Expr, degree: int, length: int) -> list[fmpq_poly]:
    """sin^k cos^(degree - k) of half an angle, as far as omega^length. Series of FLINT's in Python end at 10 terms: not these."""
    if not isinstance(rate, Rational):
        raise UndecidedError("how a condition begins at omega = 0")
    half = fmpq(int(rate.p), 2 * int(rate.q))
    terms = [fmpq(1)]
    for n in range(1, length):
        terms.append(terms[-1] * half / n)
    signs = (1, 1, -1, -1)
    sine, cosine = (fmpq_poly([x * signs[n % 4] if n % 2 == odd else 0 for n, x in enumerate(terms)]) for odd in (1, 0))
    sines, cosines = (_powers(x, degree, length) for x in (sine, cosine))
    return [x.mul_low(y, length) for x, y in zip(sines, reversed(cosines), strict=True)]


def _powers(x: fmpq_poly, degree: int, length: int) -> list[fmpq_poly]:
    """1, x, x^2, ..."""
    return list(accumulate(repeat(x, degree), lambda a, b: a.mul_low(b, length), initial=fmpq_poly([1])))


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
    units = _units_in_limits(part, {key for row in rows for key in row})
    for n in range(order, order + _KNOWN):
        value = of_parts({key if key in units else (): x for key, x in rows[n].items()}, units)
        if isinstance(value, Known) or value:
            yield n, value
    yield order + _KNOWN, part.over(arb(0)).taylor(arb(0).union(near), order + _KNOWN)


def _units_in_limits(part: Shape, keys: Iterable[Key]) -> dict[Key, Ball]:
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
