"""What a certificate has room for is what a checker takes, and cells tell the zeros of polynomials with gaps, by hand."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from math import cos, factorial, pi, sin
from random import Random
from typing import Any

import flint
import numpy as np
import pytest
from flint import Ordering, fmpq_mpoly_ctx, fmpz_poly
from mpmath import mp

from haptisym.kernel.errors import SceneError, UndecidedError
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


def joined(even: Sequence[int], odd: Sequence[int]) -> list[int]:
    """The polynomial p with p(j omega) = E + j omega O, of those of E and O in omega^2."""
    p = [0] * (2 * max(len(even), len(odd)))
    for i, row in enumerate((even, odd)):
        for k, n in enumerate(row):
            p[2 * k + i] = (-1) ** k * n
    return p if p[-1] else p[:-1]


def told(p: list[int]) -> None:
    roots = np.roots(p[::-1])
    assert min(abs(roots.real)) > 1e-9
    assert counted(p) == sum(roots.real > 0), p


def test_cells_end_beside_the_zeros_of_e_where_halves_would_end_at_them() -> None:
    """E = (x - 1)(10 (x - 1)^2 + 1) between 0 and 2, and from there to what O has."""
    even = [-11, 31, -30, 10]
    told(joined(even, [-3, 1]))
    told(joined(even, [3, -1]))
    told(joined([n * 2**k for k, n in enumerate(even)], [-3, 2]))


@pytest.mark.parametrize("seed", range(3))
def test_cells_part_what_has_zeros_near_the_axis_as_often_as_it_takes(seed: int) -> None:
    pick = Random(seed)
    for _ in range(12):
        each = []
        for _ in range(2):
            row = fmpz_poly([pick.choice([-1, 1, 2])])
            for _ in range(pick.randint(0, 2)):
                a, n = pick.randint(1, 40), pick.choice([4, 10])
                row *= pick.choice([fmpz_poly([-a, n]), fmpz_poly([a, n]), fmpz_poly([a * a + 1, -2 * a * n, n * n])])
            each.append([int(c) for c in row.coeffs()])
        p = joined(*each)
        roots = np.roots(p[::-1])
        if len(p) > 1 and min(abs(roots.real)) > 1e-6:
            told(p)


def test_where_a_sign_is_beyond_the_digits_of_pi_no_cells_suffice() -> None:
    far = 10**120
    with mp.workdps(150):
        near = -int(mp.pi * far), far
    for rows in ((near, (1,), (1,)), ((1,), near, (1,), (1,))):
        with pytest.raises(UndecidedError, match="the cells of a certificate"):
            _cells(rows)


# Signs of factors with waves, in cells that are wide or end at a zero


def test_a_cell_that_ends_at_a_zero_tells_no_signs_and_one_around_it_both() -> None:
    line = WaveFactor((((0,), ((-2,), (1,))),), (0,), (Fraction(2),))
    for low, high, signs in ((1, 3, (-1, 1)), (1, 2, None), (2, 3, None), (3, 4, (1,)), (1, Fraction(3, 2), (-1,))):
        assert line.moved(Fraction(low), Fraction(high)) == signs
        if signs is None:
            with pytest.raises(RefusedError):
                checked.WaveFactor(line.told(), line.delays).signs(Fraction(low), Fraction(high))


@pytest.mark.parametrize("sines", range(3))
def test_what_taylors_sum_leaves_of_products_of_waves_is_as_large_as_it_may_be_in_a_wide_cell(sines: int) -> None:
    """Of cos^2, sin cos and sin^2 of omega the 14th term is 2^13 h^14/14! times a wave: 1/650 for h = 2."""
    own = WaveFactor((((sines,), ((1,),)),), (2,), (Fraction(2),))
    for low in (Fraction(1), Fraction(3), Fraction(9, 2)):
        with flint.ctx.workprec(280):
            model, rest = own._model(own._balls, low, low + 4)
        assert float(rest.rad()) >= 2**27 / factorial(14)
        for v in (-1, Fraction(-1, 2), 1):
            x = float(low + 2 + 2 * v)
            true = sin(x) ** sines * cos(x) ** (2 - sines)
            sum_ = sum(float(c.mid()) * float(v) ** n for n, c in enumerate(model))
            assert abs(sum_ - true) <= float(rest.rad())
