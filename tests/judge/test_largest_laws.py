"""The largest value of a function that is known by hand: beside poles of either sign, at zeros and at ends; and what passivity leaves open."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from sympy import Expr, Integer, Rational, Symbol, sqrt

import haptisym as hs
from haptisym.judge.criteria import PASSIVE
from haptisym.judge.passivity import Beyond, passivity
from haptisym.judge.peaks import greatest, largest, tops
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import Chart
from haptisym.kernel.symbols import omega as w

BAND = Integer(1), Integer(9)
POLES: dict[Expr, tuple[Rational, int] | None] = {
    1 / (w - 1): None, 1 / (9 - w): None, 1 / (w - 4): None, 1 / (4 - w): None, 1 / (w - 4) ** 2: None, 1 / (w - 1) ** 2: None, 1 / (w - 9) ** 2: None,
    1 / (1 - w): (Rational(-1, 8), 9), 1 / (w - 9): (Rational(-1, 8), 1), -1 / (w - 4) ** 2: (Rational(-1, 25), 9), -1 / (w - 6) ** 2: (Rational(-1, 25), 1),
    -1 / (w - 1) ** 2: (Rational(-1, 64), 9), -1 / (w - 9) ** 2: (Rational(-1, 64), 1), 1 / (w - 1) - 1 / (w - 9): None, 1 / (1 - w) + 1 / (w - 9): (Rational(-1, 2), 5),
    1 / (1 - w) - 1 / (w - 9): None, 1 / (w - 1) + 1 / (w - 9): None,
}  # fmt: skip
"""On [1, 9] with its largest value and where; None where it grows beyond everything in it."""
FINITE: dict[Expr, tuple[Expr, Expr]] = {
    -((w**2 - 3) ** 2): (Integer(0), sqrt(3)), -((w - 1) ** 2): (Integer(0), Integer(1)), w - 9: (Integer(0), Integer(9)), 1 - w: (Integer(0), Integer(1)),
    w * (8 - w): (Integer(16), Integer(4)), 7 + 0 * w: (Integer(7), Integer(1)), -w * (8 - w): (Integer(9), Integer(9)), 0 * w: (Integer(0), Integer(1)),
    (w - 5) ** 3: (Integer(64), Integer(9)), -((w - 5) ** 4) - 2: (Integer(-2), Integer(5)),
}  # fmt: skip


def real(x: Expr) -> RealFunction:
    return RealFunction(Ring().axis.convert(x.together()).reduced())


@pytest.mark.parametrize("x", POLES, ids=str)
def test_what_grows_beyond_everything_inside_of_a_band_has_no_largest_value_and_what_falls_there_has(x: Expr) -> None:
    expected, found = POLES[x], greatest(real(x), *BAND)
    assert tops(real(x), *BAND) is None
    assert largest(real(x), *BAND) is None
    if expected is None:
        assert found is None
        return
    assert found is not None
    assert found.omega is not None
    assert (float(found.value), float(found.omega)) == (pytest.approx(float(expected[0]), rel=1e-15), expected[1])


@pytest.mark.parametrize("x", FINITE, ids=str)
def test_the_largest_value_is_told_at_zeros_and_where_nothing_changes_too(x: Expr) -> None:
    value, place = FINITE[x]
    found, own = greatest(real(x), *BAND), largest(real(x), *BAND)
    assert found is not None
    assert found.omega is not None
    assert own is not None
    assert float(found.value) == float(own) == float(value)
    if x.has(w):
        assert float(found.omega) == pytest.approx(float(place), rel=1e-15)


def test_peaks_are_asked_of_numbers_alone() -> None:
    spring = hs.environments.mass_spring_damper(k=Symbol("k"))
    with pytest.raises(hs.SceneError, match="environment.k = k is a symbol where a number is needed"):
        hs.peaks(hs.Scene(spring, (hs.effects.first_order_lag(50),)))


# What is open of a display stays open


def test_a_display_is_passive_where_its_sign_is_known_everywhere_and_not_where_it_is_open_somewhere() -> None:
    found = passivity(hs.Scene(hs.environments.kelvin_voigt(100, 2), ()))
    assert (found.beyond, found.holds) == (Beyond.NEVER, True)
    for beyond in Beyond:
        held = {Beyond.NEVER: True, Beyond.ALWAYS: False, Beyond.AGAIN: False}.get(beyond)
        assert replace(found, beyond=beyond).holds is held, beyond
        assert replace(found, beyond=beyond).is_active is (held is False)
    doubtful: Any = Chart(tuple(replace(x, undecided=frozenset({PASSIVE})) for x in found.chart.points))
    assert replace(found, chart=doubtful).holds is None
    assert replace(found, chart=doubtful, beyond=Beyond.ALWAYS).holds is False


def test_what_gives_energy_to_imposed_motion_forbids_some_hand_unless_images_of_the_samples_come_back_to_the_clock() -> (
    None
):
    """Tustin's rule for a damper has a pole at z = -1, though the right-hand side is K T/2 - B = 0.71 N s/m at all angles."""
    felt, clock = hs.environments.kelvin_voigt(1500, "0.04"), hs.effects.sampled_loop("1 ms", "tustin")
    for b, active in (("0.1", True), ("9", False)):
        device = hs.effects.shunt(m="0.04", b=b)
        found = passivity(hs.Scene(felt, (clock, device)))
        assert found.sampled is not None
        assert found.sampled.needed is not None
        assert (float(found.sampled.needed.value), found.sampled.passive) == (0.71, None)
        assert found.is_active is active
        assert found.holds is (False if active else None)
        yielding = passivity(hs.Scene(felt, (clock, device, hs.effects.compliance(k=10**6, b=1))))
        assert (yielding.is_active, yielding.holds) == (active, None)
