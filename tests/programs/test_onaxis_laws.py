"""Zeros on the axis over boxes of values: radii, variations and cells that are known by hand."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Rational, Symbol, exp, pi, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s
from haptisym.programs import onaxis
from haptisym.programs.onaxis import OnAxis

P, Q, U = (Symbol(name, real=True) for name in "pqu")
ALPHA = Symbol("alpha", positive=True)
LATE = exp(-s)
Ranges = Mapping[Symbol, tuple[Any, Any]]


def form(D: Expr, ranges: Ranges) -> OnAxis:
    ring = Ring.of([D])
    exact = {x: (Rational(low), Rational(high)) for x, (low, high) in ranges.items()}
    return OnAxis(ring, ring.convert(D.expand()).numerator, exact)


EXPONENT: Ranges = {ALPHA: ("1/2", "3/4")}


@pytest.mark.parametrize(
    ("D", "ranges", "reach"),
    [
        (s**2 + 12, {}, 4), (s**2 - 12, {}, 4), (s**2 + 16, {}, 8), (2 * s**2 - 12, {}, 4), (3 * s**3 + 100, {}, 4), (s**2 - 3 * s - 2, {}, 4),
        # a s + b is as large as either of the two where both have one sign and neither comes late: 100/r > 1/r^2
        (s**2 + 100 * s + 1, {}, Rational(1, 64)), (-(s**2) - 100 * s + 1, {}, Rational(1, 64)), (s**2 + 100 * s - 1, {}, Rational(1, 64)),
        (s**2 - 100 * s + 1, {}, 128), (s**2 + 100 * s * LATE + 1, {}, 128), (s**2 + 100 * s + LATE, {}, Rational(1, 64)),
        (s**2 * (1 + LATE / 2) + 100 * s + 1, {}, 256), (s**2 * (1 - LATE / 2) + 100 * s + 1, {}, 256), (s**2 * LATE / 2 + s**2 + 100, {}, 16),
        (s**2 + 100 * s + 10 * sqrt(s) + 1, {}, Rational(1, 32)), (s**2 + 100 * s + 10 * s * sqrt(s) + 1, {}, 512),
        (s**2 + 100 * s + P * s + 1, {P: (0, 1)}, Rational(1, 64)), (s**2 + 100 * s + P * s + 1, {P: ("-1/9", 1)}, 128), (s + 1, {}, Rational(1, 2**20)), (s**2 + P * s + 1, {P: (1, 100)}, 2),
        # a power of s that is not known: r^(1/4) > 2, and r^(1/2) > 1/4
        (s + 2 * s**ALPHA, EXPONENT, 32), (s + s**ALPHA / 4, EXPONENT, Rational(1, 8)), (s**2 + 2 * s**ALPHA * s - s**ALPHA, EXPONENT, 32),
        (s**ALPHA + s ** Rational(5, 8), EXPONENT, None), (s ** Rational(3, 4) + s**ALPHA, EXPONENT, None), (s * (1 + 2 * LATE) + 1, {}, None), (s * (1 + LATE) + 1, {}, None),
        (P * s + 1, {P: (0, 1)}, Rational(1, 2**20)), (P * s - 1, {P: (0, 1)}, None), ((1 + P) * s - 1, {P: (0, 1)}, 2), (s - P, {P: (-3, 1)}, 4), (s - P, {P: (-1, 3)}, 4),
    ],
    ids=str,
)  # fmt: skip
def test_the_reach_is_the_first_power_of_two_at_which_the_highest_power_exceeds_all_others(
    D: Expr, ranges: Ranges, reach: Any
) -> None:
    assert form(D, ranges).reach == (None if reach is None else float(reach))


@pytest.mark.parametrize("order", [{P: (0, 2), Q: (0, 2)}, {Q: (0, 2), P: (0, 2)}])
def test_a_coefficient_is_bounded_over_pieces_of_all_ranges(order: Ranges) -> None:
    """3/4 (1 - p)^4 (1 - q)^4 is at most 3/4 where p and q are 0 to 2, and its terms together 192."""
    assert form(s - Rational(3, 4) * (1 - P) ** 4 * (1 - Q) ** 4, order).reach in (1, 2)


def test_what_varies_in_a_cell_is_told_by_side_in_shares_of_the_size_there() -> None:
    """p + j omega, 5 exp(j phi) in the middle of cells: along phi each part counts with its cosine."""
    found = form(s + P, {P: (2, 10)})
    found.reach = 8.0
    middle = 3.0, 4.0
    for half in ((0.5, 1.0), (0.25, 0.5), (0.0, 1.0), (0.5, 0.0)):
        omega = [(middle[1] - half[0]) / 8, (middle[1] + half[0]) / 8]
        p = [(middle[0] - half[1] - 2) / 8, (middle[0] + half[1] - 2) / 8]
        clear, rates = found.bounded(np.array([[omega, p]]))
        assert clear.tolist() == [True]
        assert rates[0] == pytest.approx([0.8 * half[0] / 5, 0.6 * half[1] / 5], abs=1e-11)
        assert [x > 0 for x in rates[0]] == [x > 0 for x in half]


@pytest.mark.parametrize(("low", "left"), [("1/8", False), ("0", True), ("-1/2", True)])
def test_cells_are_left_where_a_zero_is_on_the_axis_and_nowhere_else(
    low: str,
    *,
    left: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """s^2 + p s + 9, p up to 1: omega = 3 at p = 0."""
    monkeypatch.setattr(onaxis, "_MOST_CELLS", 1000)
    found = form(s**2 + P * s + 9, {P: (low, 1)})
    cells = found.left()
    assert (len(cells) > 0) is left
    if not left:
        return
    assert found.reach is not None
    place = np.array([3 / found.reach, float(-Rational(low) / (1 - Rational(low)))])
    holds = ((cells[:, :, 0] <= place) & (place <= cells[:, :, 1])).all(-1)
    assert holds.any()
    assert np.abs(cells.mean(-1) - place).max() < 0.01


def test_numbers_of_a_term_are_products_of_what_they_are_made_of() -> None:
    """(2 + p^2 q) s^2 + 3 pi p s exp(-s) - q at j omega, in points; u is in none."""
    found = form((2 + P**2 * Q) * s**2 + 3 * pi * P * s * LATE - Q, {U: (5, 9), P: (1, 3), Q: (-2, 2)})
    found.reach = 4.0
    at = np.array([[0.5, 0.5, 0.25, 0.75], [0.125, 0.0, 1.0, 0.0], [1.0, 1.0, 0.0, 1.0]])
    real, imag = found.parts(np.stack([at, at], -1))
    for n, (x, _, y, z) in enumerate(at.tolist()):
        w, p, q = 1j * 4 * x, 1 + 2 * y, -2 + 4 * z
        true = (2 + p**2 * q) * w**2 + 3 * np.pi * p * w * np.exp(-w) - q
        assert (real.c0[n, 0], imag.c0[n, 0]) == pytest.approx((true.real, true.imag), abs=1e-12)
