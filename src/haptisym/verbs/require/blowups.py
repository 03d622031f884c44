"""The sign of a sum of monomials c X^a Y^b with real exponents on a box that may reach to X = 0 or Y = 0, in balls.

Where no term is left at the corner X = Y = 0, two charts take its place, Y = X^p v and X = Y^(1/p) y, p a slope of Newton's
polygon: together they cover the box, and in both the sum is a simpler one of the same kind, times a power.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import lcm

from flint import arb, arb_poly, fmpq, fmpq_poly

from haptisym.kernel.budget import tick
from haptisym.kernel.reals import Ball
from haptisym.verbs.require.monomials import Coefficient, Monomials, Side, Terms, power

_MOST_BOXES, _MOST_CHARTS, _MOST_HALVINGS = 300, 8, 20


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
        if not _is_bare(own, across[0], up[0]):
            waiting += [(own, a, b, charts) for a, b in _halves(own, across, up)]
        elif charts == _MOST_CHARTS:
            return False
        else:
            corner, rest = _matched(own, across[1], up[1]) if matching else ((across[1], up[1]), [])
            waiting += [(own, *box, charts) for box in rest]
            waiting += [(*chart, charts + 1) for chart in _charts(own, *corner)]
    return False


def _is_negative_above_rows(given: Monomials, across: Side, up: Side) -> bool:
    """Whether rows of like powers of X are nowhere positive, exactly so, and the sum of the others is negative on a box."""
    if not across[0].is_zero():
        return False
    left = dict(given.terms)
    for least in given.across:
        if not _is_nowhere_positive({b: value for (a, b), value in left.items() if a == least}, up):
            return False
        left = {(a, b): value for (a, b), value in left.items() if a > least}
        if left and _shows_negative(Monomials.of(left).reduced(across, up), across, up):
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


def _is_nowhere_positive(row: Mapping[Fraction, Coefficient], up: Side) -> bool:
    """Whether a sum of powers of Y with exact coefficients is not positive between two numbers: what changes signs is squared."""
    if not all(isinstance(x, fmpq) for x in row.values()):
        return False
    below = lcm(*(b.denominator for b in row))
    powers = {int(b * below): value for b, value in row.items()}
    found = fmpq_poly([powers.get(n, fmpq(0)) for n in range(max(powers) + 1)])
    if not found:
        return True
    low, high = (power(y, Fraction(1, below)) for y in up)
    odd = (root for f, n in found.factor()[1] if n % 2 for root, _ in f.complex_roots())
    if any(root.imag.contains(0) and not root.real <= low and not root.real >= high for root in odd):
        return False
    middle = ((3 * low + 4 * high) / 7).mid()
    return bool(arb_poly(found)(middle) < 0)


def positive_along(terms: Terms, x: Ball, y: Ball) -> Ball | None:
    """A number such that for each 0 < Y <= it the sum is positive at some 0 < X <= x; None where none shows."""
    corner = (arb(0), x), (arb(0), y)
    own = Monomials.of(terms).reduced(*corner)
    if own.over(*corner) > 0:
        return y
    for p, v in _curves(own):
        found: dict[tuple[Fraction, Fraction], Ball] = {}
        for (a, b), value in own.terms.items():
            place = a + p * b, Fraction(0)
            found[place] = found.get(place, arb(0)) + value * power(v, b)
        along = Monomials.of(found).reduced(*corner)
        reach = x
        for _ in range(_MOST_HALVINGS):
            if along.over((arb(0), reach), (arb(1), arb(1))) > 0:
                return (v * power(reach, p)).lower().min(y)
            reach = reach / 4
    return None


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


def _slope(own: Monomials) -> tuple[Fraction, Ball]:
    """The slope p of the edge of Newton's polygon next to X = 0, and about where along Y = X^p v its terms are alike."""
    b = min(b for a, b in own.terms if a == 0)
    others = [(a / (b - other), b - other, value) for (a, other), value in own.terms.items() if other < b]
    p, rise, value = min(others, key=lambda x: x[:2])
    first, last = (abs(float(arb(x).mid())) for x in (own.terms[Fraction(0), b], value))
    return p, arb((last / first) ** (1 / float(rise))) if first and last else arb(1)


def _matched(own: Monomials, x: Ball, y: Ball) -> tuple[tuple[Ball, Ball], list[tuple[Side, Side]]]:
    """The largest corner whose far end lies on the curve on which charts meet, and the rest of a box."""
    p, v = _slope(own)
    height = (v * power(x, p)).mid()
    if height < y:
        return (x, height), [((arb(0), x), (height, y))]
    width = ((y / v).log() * p.denominator / p.numerator).exp().mid()
    return (width, y), ([((width, x), (arb(0), y))] if width < x else [])


def _charts(own: Monomials, x: Ball, y: Ball) -> list[tuple[Monomials, Side, Side]]:
    """The two that take the place of a corner."""
    p, v = _slope(own)
    beyond = (-v.log() * p.denominator / p.numerator).exp().upper()
    return [
        (Monomials.of({(a + p * b, b): c for (a, b), c in own.terms.items()}), (arb(0), x), (arb(0), v)),
        (Monomials.of({(a, b + a / p): c for (a, b), c in own.terms.items()}), (arb(0), beyond), (arb(0), y)),
    ]


def _curves(own: Monomials) -> Iterator[tuple[Fraction, Ball]]:
    """Curves Y = X^p v into the corner, of each slope of Newton's polygon."""
    corner, total = (arb(0), arb(1)), Fraction(0)
    while not own.has_constant:
        p, v = _slope(own)
        total += p
        yield from ((total, v * arb(2) ** n) for n in (0, 1, -1, 2, -2, 3, -3, 6, -6))
        own = Monomials.of({(a + p * b, b): c for (a, b), c in own.terms.items()}).reduced(corner, corner)
