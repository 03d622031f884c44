"""Whether a dynamics is stable: all poles in the open left half plane, decided exactly."""

from __future__ import annotations

from .response import RationalFunction
from .roots import sign_of_number


def is_stable(dynamics: RationalFunction) -> bool:
    """Whether all finite poles of a dynamics in lowest terms lie in the open left half plane: Routh's array, exact.

    >>> from .response import Ring
    >>> from .symbols import s
    >>> ring = Ring()
    >>> is_stable(ring.convert(1 / (s**3 + 2 * s**2 + 3 * s + 4))), is_stable(ring.convert(1 / (s**2 + 1)))
    (True, False)
    """
    rows = _first_rows(dynamics)
    while rows[1]:
        # a zero in the first column already means a pole on or right of the imaginary axis
        if _sign(rows[0][0]) * _sign(rows[1][0]) <= 0:
            return False
        rows = rows[1], _next_row(*rows)
    return True


def _first_rows(dynamics: RationalFunction) -> tuple[list[RationalFunction], list[RationalFunction]]:
    ring = dynamics.ring
    degree = int(dynamics.denominator.degrees()[0])
    coefficients = [ring.zero] * (degree + 1)
    for (power, *others), value in dynamics.denominator.to_dict().items():
        term = RationalFunction(ring, ring.context.from_dict({(0, *others): value}), ring.constant(1))
        coefficients[degree - int(power)] = coefficients[degree - int(power)] + term
    return coefficients[::2], coefficients[1::2]


def _next_row(above: list[RationalFunction], row: list[RationalFunction]) -> list[RationalFunction]:
    factor = above[0] / row[0]
    padded = [*row[1:], *[row[0].ring.zero] * (len(above) - len(row))]
    return [(x - factor * y).reduced() for x, y in zip(above[1:], padded, strict=True)]


def _sign(constant: RationalFunction) -> int:
    return sign_of_number(constant.expression())
