"""What a certificate has room for is what a checker takes, and cells tell the zeros of polynomials with gaps, by hand."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import cos, pi
from typing import Any

import numpy as np
import pytest
from flint import Ordering, fmpq_mpoly_ctx

from haptisym.kernel.errors import SceneError
from haptisym.verbs.evaluate.waves import WaveFactor, wave_factor
from haptisym.verbs.evaluate.zeros import _cells
from haptisym_check import RefusedError
from haptisym_check import waves as checked
from haptisym_check.zeros import to_the_right

DELAYS = Fraction(5), Fraction(3), Fraction(2)
ORDERS = (Fraction(1, 2),)
NAMES = ("omega", "pi", "x", "y", "t0", "t1", "t2")


def fits(exponents: list[tuple[int, ...]]) -> bool:
    """Whether there is room for a sum of such products of x, y and three tangents; a checker is asked about the same sum."""
    context = fmpq_mpoly_ctx.get(NAMES, Ordering.lex)
    polynomial = context.from_dict({(0, 0, *x): 1 for x in exponents})
    most = tuple(max(x[4 - i] for x in exponents) for i in range(3))
    terms = tuple(sorted(((*x[:1:-1], *x[:2]), ((1,),)) for x in exponents))
    same = WaveFactor(terms, most, DELAYS, ORDERS)
    try:
        found = wave_factor(polynomial, 4, DELAYS, ORDERS)
    except SceneError:
        with pytest.raises(RefusedError):
            checked.WaveFactor(same.told(), DELAYS, ORDERS)
        return False
    assert found == same
    checked.WaveFactor(found.told(), DELAYS, ORDERS)
    return True


def test_a_factor_has_room_for_as_many_products_as_a_checker_takes() -> None:
    many = list(product(range(2), range(2), range(5), range(5), range(4)))
    assert fits(many[:299])
    assert fits(many[:300])
    assert not fits(many[:301])


@pytest.mark.parametrize("place", range(5))
def test_a_factor_has_room_for_powers_as_high_as_a_checker_takes(place: int) -> None:
    def alone(n: int) -> tuple[int, ...]:
        return tuple(n * (i == place) for i in range(5))

    assert fits([alone(0), alone(40)])
    assert not fits([alone(0), alone(41)])
    assert fits([alone(40), (1, 1, 1, 1, 1)])


# Zeros in the right half plane of polynomials in which powers are missing


def counted(p: list[int]) -> int:
    rows = tuple((n,) for n in p)
    cells = _cells(rows)
    assert cells == sorted(set(cells))
    assert all(x > 0 for x in cells)
    return to_the_right([[n] for n in p], [Fraction(0), *cells])


@pytest.mark.parametrize("c", [1, 2, 7])
def test_cells_tell_the_zeros_of_a_power_less_a_number(c: int) -> None:
    """s^n = -c where the angle is an odd multiple of pi/n, s^n = c where it is an even one; those on the axis count."""
    for n in range(1, 9):
        for sign in (1, -1):
            angles = [pi * (2 * k + (sign > 0)) / n for k in range(n)]
            assert counted([sign * c, *[0] * (n - 1), 1]) == sum(cos(x) > -1e-9 for x in angles)


def test_cells_tell_the_zeros_of_all_small_polynomials_with_gaps() -> None:
    for row in product((1, -3), (0, 2), (0, -1), (0, 5), (0, 1), (1, -2)):
        p: list[Any] = list(row)
        roots = np.roots(p[::-1])
        if min(abs(roots.real)) > 1e-6:
            assert counted(p) == sum(roots.real > 0), p
