"""The sign of a sum of monomials c X^a Y^b with real exponents on a box that may reach to X = 0 or Y = 0, in balls.

Where no term is left at the corner X = Y = 0, two charts take its place, Y = X^p v and X = Y^(1/p) y, p a slope of Newton's
polygon: together they cover the box, and in both the sum is a simpler one of the same kind, times a power. Where what is left at
X = 0 has a double root v_0, a rational number, v = v_0 + w and v = v_0 - w: a corner again. That is exact, as coefficients are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, fmpq

from haptisym.kernel.budget import tick
from haptisym.kernel.reals import Ball
from haptisym.verbs.require.knownsums import ball
from haptisym.verbs.require.monomials import Monomials, Side, Terms, power

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
