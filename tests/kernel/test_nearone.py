"""Roots on the axis of polynomials whose coefficients lie in balls: against roots of polynomials within them."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb

from haptisym.kernel.nearone import has_no_pair, hurwitz


@pytest.mark.parametrize(
    ("c", "none"),
    [
        ([1, 1, 1], True), ([1, 0, 1], False), ([1, 1, 1, 1], False),  # (v + 1)(v^2 + 1)
        ([-1, 0, 1], True), ([-1, -1, 1, 1], True),  # v = +-1 is no pair on the axis
        ([0, 1, 1], True), ([0, 0, 1], False), ([4, 0, 5, 0, 1], False), ([1, 1], True), ([0], True),
        ([float("nan"), 1, 1], False), ([1, 1, float("inf")], False),
    ],
)  # fmt: skip
def test_a_pair_on_the_axis_is_seen_and_no_other(c: list[float], *, none: bool) -> None:
    assert has_no_pair([arb(x) for x in c]) is none


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(12))
def test_no_polynomial_within_balls_without_a_pair_has_one(seed: int) -> None:
    """Where one does, its number of roots with Re v > 0 is not that of another: the two are joined within the balls."""
    rng = np.random.default_rng(seed)
    told = 0
    for _ in range(40):
        roots = rng.normal(size=5) * 10.0 ** rng.uniform(-3, 1, 5)
        middle = np.real(
            np.poly(np.concatenate([roots[:1], *((x + 1j * y, x - 1j * y) for x, y in roots[1:].reshape(2, 2))]))
        )
        width = abs(middle) * 10.0 ** rng.uniform(-2, -0.5)
        if has_no_pair([arb(m, w) for m, w in zip(middle[::-1], width[::-1], strict=True)]):
            told += 1
            counts = {int((np.roots(middle + width * x).real > 0).sum()) for x in rng.choice([-1.0, 0.3, 1.0], (30, 6))}
            assert len(counts) == 1
    assert told > 3


def test_of_wide_balls_more_is_known_than_by_the_determinant() -> None:
    """(v + 1)^5, each coefficient by 10 %."""
    wide = [arb(x, 0.1 * x) for x in (1, 5, 10, 10, 5, 1)]
    assert hurwitz(wide).contains(0)
    assert has_no_pair(wide)
