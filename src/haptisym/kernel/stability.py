"""Whether a dynamics is stable: all poles in the open left half plane, proven or said to be undecided."""

from __future__ import annotations

from math import ceil, prod

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, degree_in
from haptisym.kernel.rootcount import RootChain, count_roots
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.terms import order_at_0


def is_stable(dynamics: RationalFunction) -> bool | None:
    """Whether all finite poles of a dynamics in lowest terms lie in the open left half plane; None where not decided.

    Rational dynamics: Routh's array, exact. With delays and powers of s: by ``count_roots`` of the denominator, and None where
    that stays open, or a chain of poles comes as near to the axis as one likes.

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
    try:
        order = order_at_0(dynamics.denominator, ring)
        if order and order > order_at_0(dynamics.numerator, ring):
            return False  # a pole at 0
        if not any(degree_in([dynamics.denominator], i) for i in range(ring.size, len(ring.meanings))):
            explicit = min(int(e[0]) for e in dynamics.denominator.monoms())
            return _routh(RationalFunction(ring, dynamics.numerator, dynamics.denominator / ring.variable**explicit))
        found = count_roots(dynamics.denominator, ring)
    except UndecidedError:
        return None
    if found.number is None:
        return False if found.chain is RootChain.RIGHT else None
    return bool(found.number == ceil(order))


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
    for (power, *others), value in monomials(polynomial):
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
