"""Where poles may lie of what no passive hand can drive, told of sums of known parts: residues, growth and zeros by hand."""

from __future__ import annotations

import pytest
from sympy import Expr, Integer, Rational, exp, pi, sqrt

from haptisym.judge.positivereal import has_no_pole_right, poles_allow
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s

ALLOWED: tuple[Expr, ...] = (
    Integer(0) * s, Integer(5) + 0 * s, 3 * s, 2 * s**2, s**2 + s + 1, s**2 / (s**2 + 4) * 3, 3 * s / (s + 2), s**2 + 5 * s**2 / (s**2 + 9),
    2 * s**2 / (s**2 + 4) + s**2 / (s**2 + 9) + 7, s**2 * (s**2 + 4) / ((s**2 + 1) * (s**2 + 9)) * 2, s * sqrt(s), sqrt(s) * 3, pi * s**2 + 1,
    s**2 * 2 + s * exp(-s), 3 + exp(-s), s**2 / (s**2 + pi**2),
)  # fmt: skip
FORBIDDEN: dict[str, tuple[Expr, ...]] = {
    "to the right": (s / (s - 1), s**2 / (s - 1) / (s + 1), s / (s**2 - s + 4), 1 / (s - 3) + 1, s / ((s - 1) * (s + 1) ** 2)),
    "at 0, of F": (1 / s + 0 * s, 1 / s**2, -1 / s, 1 / (s * (s + 1)), (s + 1) / (s**2 * (s + 3))),
    "at 0, of F/s, with a residue below 0": (-1 + 0 * s, s - 2, (s - 1) / (s + 1), -2 + exp(-s), 3 * s**2 - Rational(1, 10**9)),
    "twice on the axis": (s**2 / (s**2 + 4) ** 2, s**3 / (s**2 + 1) ** 2, s**2 * (1 + s) / (s**2 + 9) ** 2),
    "on the axis, with a residue below 0": (-(s**2) / (s**2 + Rational(1, 4)), 3 - s**2 / (s**2 + 5), 2 * s**2 / (s**2 + 1) - s**2 / (s**2 + 30),-(s**2) / (s**2 + 4), 9 + 2 * s**2 / (s**2 + 4) - s**2 / (s**2 + 9), 1 + s**2 - 2 * s**2 / (s**2 + 1)),
    "on the axis, with a residue that is not real": (s / (s**2 + 4), -s / (s**2 + 4), s + s**2 / (s**2 + 4) + s / (s**2 + 4)),
    "far out": (s**3, -(s**2), s**4, 1 - s**2 / 1000, s**2 * sqrt(s), 5 + 3 * s**3 / (s + 1) - 4 * s**2, s**4 / (s + 1)),
}  # fmt: skip


def allowed(x: Expr) -> bool | None:
    x = x.together()
    return poles_allow(Ring.of([x]).convert(x).reduced())


@pytest.mark.parametrize("x", ALLOWED, ids=str)
def test_simple_poles_with_positive_residues_are_allowed(x: Expr) -> None:
    """Springs, dampers, masses, and resonators r s^2/(s^2 + a^2): the residues of F/s are r/2 there."""
    assert allowed(x) is True


@pytest.mark.parametrize("where", FORBIDDEN)
def test_no_other_poles_are_allowed(where: str) -> None:
    for x in FORBIDDEN[where]:
        assert allowed(x) is False, x


def test_poles_to_the_right_are_told_from_those_on_the_axis() -> None:
    for x, clear in (
        (1 / (s**2 + 4), True), (1 / s**3, True), (1 / (s + 1), True), (s**5, True), (1 / (s**2 - s + 4), False), (1 / (s - 1), False),
        (1 / (s**2 + 4) / (s - 3), False), (1 / (2 + exp(-s)), True), (1 / (1 + s + exp(-s) / 2), True),
    ):  # fmt: skip
        assert has_no_pole_right(Ring.of([x]).convert(x.together()).reduced()) is clear, x
