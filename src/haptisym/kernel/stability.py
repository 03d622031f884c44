"""Whether a dynamics is stable: all poles in the open left half plane, proven or said to be undecided."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import prod

from sympy import Expr, I, Integer, Rational

from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, degree_in
from haptisym.kernel.roots import Chart, Point, chart, sign_of_number


def is_stable(dynamics: RationalFunction) -> bool | None:
    """Whether all finite poles of a dynamics in lowest terms lie in the open left half plane; None where not decided.

    Rational dynamics: Routh's array, exact. With delays: the argument principle for the denominator, a quasi-polynomial
    D(s, exp(-s tau)); the turns of D(j omega) are counted on a chart of its real and imaginary part up to a frequency beyond
    which the leading term outweighs all others (Mikhailov's criterion). None where the leading term does not outweigh
    the others (some neutral equations) or does so only after thousands of turns, where s^alpha or the describing function
    of friction is in the denominator, or where the count stays open.

    >>> from haptisym.kernel.symbols import s
    >>> from sympy import exp
    >>> def of(expression): return is_stable(Ring.of([expression]).convert(expression).reduced())
    >>> of(1 / (s**3 + 2 * s**2 + 3 * s + 4)), of(1 / (s**2 + 1))
    (True, False)
    >>> of(1 / (s + exp(-s))), of(1 / (s + 2 * exp(-s)))        # s + a exp(-s) is stable for 0 < a < pi/2
    (True, False)
    """
    ring = dynamics.ring
    assert isinstance(ring, Ring)
    lags = range(ring.size, ring.size + len(ring.lags))
    if degree_in([dynamics.denominator], len(ring.meanings) - 1) and I in ring.generators:
        return None
    if any(degree_in([dynamics.denominator], i) for i in range(lags.stop, lags.stop + len(ring.orders))):
        return None
    order = int(ring.order_at_0(dynamics.denominator))
    if order > ring.order_at_0(dynamics.numerator):
        return False  # a pole at 0
    explicit = min(int(e[0]) for e in dynamics.denominator.monoms())
    shortened = dynamics.denominator / ring.variable**explicit
    if not any(degree_in([shortened], i) for i in lags):
        return _routh(RationalFunction(ring, dynamics.numerator, shortened))
    try:
        return _mikhailov(shortened, ring, order - explicit)
    except UndecidedError:
        return None


def _routh(dynamics: RationalFunction) -> bool:
    rows = _first_rows(dynamics)
    while rows[1]:
        # a zero in the first column already means a pole on or right of the imaginary axis
        if _sign(rows[0][0]) * _sign(rows[1][0]) <= 0:
            return False
        rows = rows[1], _next_row(*rows)
    return True


def _first_rows(dynamics: RationalFunction) -> tuple[list[RationalFunction], list[RationalFunction]]:
    coefficients = _by_power(dynamics.denominator, dynamics)[::-1]
    return coefficients[::2], coefficients[1::2]


def _by_power(polynomial: Polynomial, of: RationalFunction) -> list[RationalFunction]:
    """The coefficients of ascending powers of s, as elements of the same ring."""
    ring = of.ring
    rows: list[dict[tuple[int, ...], object]] = [{} for _ in range(int(polynomial.degrees()[0]) + 1)]
    for (power, *others), value in polynomial.to_dict().items():
        rows[int(power)][(0, *others)] = value
    return [ring.function(ring.context.from_dict(row)) for row in rows]


def _next_row(above: list[RationalFunction], row: list[RationalFunction]) -> list[RationalFunction]:
    factor = above[0] / row[0]
    padded = [*row[1:], *[row[0].ring.zero] * (len(above) - len(row))]
    return [(x - factor * y).reduced() for x, y in zip(above[1:], padded, strict=True)]


def _sign(constant: RationalFunction) -> int:
    return prod(_sign_of(p, constant.ring) for p in (constant.numerator, constant.denominator))


def _sign_of(constant: Polynomial, ring: PolynomialRing) -> int:
    if not constant.is_constant():  # it holds pi
        return sign_of_number(ring.expression(constant))
    number = constant.coeffs()[0] if constant else 0
    return int(number > 0) - int(number < 0)


# Delays

_MOST_TURNING = 2000  # radians that the delays turn up to that frequency: thousands of zeros take minutes


def _mikhailov(denominator: Polynomial, ring: Ring, removable: int) -> bool | None:
    """Whether no zero lies in the closed right half plane, but those at 0, that many, which the numerator has as well."""
    leading, degree = _leading(denominator, ring)
    if leading is None:
        return None
    if leading == 0:
        return False  # an advanced equation: chains of poles run off into the right half plane
    reach = _reach(denominator, ring)
    if sign_of_number(reach * max(ring.lags, key=float) - _MOST_TURNING) > 0:
        return None
    real, imag = _real_and_imag(denominator, ring)
    curve = chart({"real": real, "imag": imag}, Integer(0), reach)
    if _meets_zero(curve.points[1:] if removable else curve.points):
        return False
    start = (removable + (0 if _sign_at_0(denominator, ring, removable) > 0 else 2)) % 4
    return _quarter_turns(curve, start, degree, leading) == degree - removable


def _sign_at_0(polynomial: Polynomial, ring: Ring, order: int) -> int:
    """The sign of the first Taylor coefficient at 0 that is not 0, the one of that order."""
    for _ in range(order):
        polynomial = ring.slope(polynomial)
    return sign_of_number(ring.expression(ring.at_0(polynomial)))


def _leading(denominator: Polynomial, ring: Ring) -> tuple[int | None, int]:
    """Sign of the undelayed leading coefficient, 0 if there is none, None if delayed ones may outweigh it; the degree."""
    terms = _terms(denominator, ring)
    degree = max(power for power, _, _ in terms)
    own = sum((value for power, delayed, value in terms if power == degree and not delayed), Integer(0))
    others = sum((abs(value) for power, delayed, value in terms if power == degree and delayed), Integer(0))
    if sign_of_number(own) == 0:
        return 0, degree
    return (sign_of_number(own) if sign_of_number(abs_of(own) - others) > 0 else None), degree


def _terms(denominator: Polynomial, ring: Ring) -> list[tuple[int, bool, Expr]]:
    """Power of s, whether delayed, and exact coefficient of each term."""
    found: dict[tuple[int, tuple[int, ...]], Expr] = {}
    for exponents, value in denominator.to_dict().items():
        own = [int(n) for n in exponents]
        key = own[0], tuple(own[ring.size : ring.size + len(ring.lags)])
        found[key] = found.get(key, Integer(0)) + Rational(int(value.p), int(value.q)) * ring.meanings[1] ** own[1]
    return [(power, any(lags), value) for (power, lags), value in found.items()]


def abs_of(number: Expr) -> Expr:
    """The magnitude of an exact number."""
    return number * sign_of_number(number)


def _reach(denominator: Polynomial, ring: Ring) -> Expr:
    """A radius beyond which, for Re s >= 0, the undelayed leading term outweighs all others together (|exp(-s tau)| <= 1)."""
    terms = _terms(denominator, ring)
    degree = max(power for power, _, _ in terms)
    weights = [Integer(0)] * (degree + 1)
    for power, delayed, value in terms:
        weights[power] -= abs_of(value) if delayed or power < degree else -abs_of(value)
    # the weights change sign once, so that the leading one prevails beyond any radius at which it does
    radius = Rational(1, 1 << 20)
    while sign_of_number(sum((w * radius**n for n, w in enumerate(weights)), Integer(0))) <= 0:
        radius *= 2
    return radius


def _real_and_imag(denominator: Polynomial, ring: Ring) -> tuple[RealFunction, RealFunction]:
    """D(j omega) times a factor that is never 0 and turns with the half angles back: exact real and imaginary part."""
    axis: Axis = ring.axis
    (a, b), (c, d) = axis.parts([denominator, denominator.context().constant(1)])
    modulus = c * c + d * d
    return (
        RealFunction(axis.function(a * c + b * d, modulus).reduced()),
        RealFunction(axis.function(b * c - a * d, modulus).reduced()),
    )


def _meets_zero(points: Sequence[Point]) -> bool:
    """Whether D vanishes on the imaginary axis: real and imaginary part at once."""
    return any(p.orders.get("real", 0) > 0 and (p.orders.get("imag", 0) > 0 or p.after["imag"] == 0) for p in points)


def _quarter_turns(curve: Chart, start: int, degree: int, leading: int) -> int:
    """By how many quarter turns D(j omega) turns as omega goes from 0 to infinity: Mikhailov's count.

    Quadrants are numbered 0 to 3, each after the axis before it, and the count goes on beyond. D begins on the axis
    ``start`` (where D(0) is not 0, a real one), and ends up around the axis of j^n.
    """
    quadrants = [_quadrant(p.after["real"], p.after["imag"]) for p in curve.points[:-1]]
    # the first quadrant lies beside the axis on which D starts
    now = start if quadrants[0] == start else start - 1
    for before, after in pairwise(quadrants):
        step = (after - before) % 4
        if step == 2:
            raise UndecidedError("a turn of the denominator")
        now += {0: 0, 1: 1, 3: -1}[step]
    # there the leading term prevails: the last quadrant lies beside its axis, after it or before it
    target = degree % 4 if leading > 0 else (degree + 2) % 4
    return (now if now % 4 == target else now + 1) - start


def _quadrant(real: int, imag: int) -> int:
    if real == 0 or imag == 0:
        raise UndecidedError("a part of the denominator that is zero throughout")
    return {(1, 1): 0, (-1, 1): 1, (-1, -1): 2, (1, -1): 3}[real, imag]
