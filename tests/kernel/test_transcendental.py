"""Scenes with delays, sampling, links, friction and fractional tissue, against a scan that knows only the physics."""

from __future__ import annotations

import numpy as np
import pytest
from marks import often
from scan import FAMILIES, Draw, disagreements
from sympy import Integer, Rational, pi

import haptisym as hs
from haptisym.kernel import factoring
from haptisym.kernel.analytic import AnalyticFactor
from haptisym.kernel.stability import is_stable

E, F = hs.environments, hs.effects
PAPER = E.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
FILTER = F.second_order_lowpass("80 rad/s", "0.5")


@pytest.mark.few(10)
@pytest.mark.parametrize("turn", often(range(20), lambda turn: turn < 3, 2))
@pytest.mark.parametrize("family", FAMILIES)
def test_a_scan_in_floats_and_mpmath_finds_nothing_to_deny(family: str, turn: int) -> None:
    """Three hundred random scenes: every crossing, cell, percept and active band is confirmed at hundreds of frequencies."""
    case = Draw(1000 * list(FAMILIES).index(family) + turn).case(family)
    try:
        result = hs.evaluate(hs.parse_scene(case.text))
    except hs.UndecidedError:  # an honest answer, but not one of a random scene
        pytest.fail("a random scene stayed undecided")
    assert disagreements(case, result, count=300) == []


@pytest.mark.slow
@pytest.mark.parametrize("k", range(13))
def test_the_pair_beside_a_lightly_damped_resonance_is_found(k: int) -> None:
    environment = E.mass_spring_damper("1.8 kg", Rational(1, 10**k), "100 N/m")
    scene = hs.Scene(environment, (FILTER, F.delay("1 ms")), (0, 15), hs.Threshold.of("0.05"))
    result = hs.evaluate(scene)
    near = [
        c
        for c in result.crossings
        if c.part is hs.Part.REAL and abs(float(c.omega) - np.sqrt(100 / 1.8)) < 2 * 10.0**-k
    ]
    if k >= 2:
        assert [c.kind.value for c in near] == ["exceeds", "returns"]
        [low, high] = (c.omega.bounds(200)[0] for c in near)
        assert 0.3 * 10.0**-k < float(high - low) < 3 * 10.0**-k
    if k == 6:
        f = scene.distortion().compile()
        assert not (f(np.linspace(1e-3, 15, 1_000_000)).ratio_real > 0.05).any(), "a grid of a million points misses it"


@pytest.mark.parametrize("turns", [1, 10, 1000])
def test_a_long_delay_on_a_spring_crosses_at_all_its_inverse_sines(turns: int) -> None:
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.delay(1),), (0, turns))
    found = [float(c.omega) for c in hs.evaluate(scene).crossings if c.part is hs.Part.IMAG]
    first = np.arcsin(0.1)
    expected = sorted(x for n in range(turns + 2) for x in (n * np.pi + first, n * np.pi - first) if 0 < x < turns)
    assert found == pytest.approx(expected, rel=1e-13)


def test_commensurable_delays_add_up() -> None:
    one = hs.evaluate(hs.Scene(PAPER, (FILTER, F.delay("3 ms")), (0, 150)))
    two = hs.evaluate(hs.Scene(PAPER, (F.delay("1 ms"), FILTER, F.delay("2 ms")), (0, 150)))
    assert [c.omega.digits(40) for c in one.crossings] == [c.omega.digits(40) for c in two.crossings]


def test_a_delay_of_zero_is_no_delay() -> None:
    assert hs.distort(PAPER, FILTER, F.delay(0)).perceived == hs.distort(PAPER, FILTER).perceived


def test_a_four_channel_teleoperator_without_delay_is_the_environment() -> None:
    m, b, k = hs.symbols("m b k")
    names = hs.symbols("M_m B_m K_m M_s B_s K_s")
    assert hs.distort(E.mass_spring_damper(m, b, k), F.four_channel_teleoperator(*names)).distortion == 0


@pytest.mark.parametrize(("c", "crossings"), [("2", None), ("1.999999999999", 2), ("2.000000000001", 0)])
def test_a_tangency_of_a_delayed_scene_is_said_to_be_open(c: str, crossings: int | None) -> None:
    """r_r = 1 - cos(omega tau) has its maximum 2 at pi/tau."""
    scene = hs.Scene(E.mass_spring_damper(k=1), (F.delay(1),), (0, 6), hs.Threshold.of(c, 5))
    result = hs.evaluate(scene)
    if crossings is None:
        [touch] = [x.omega for x in result.crossings] or [point.omega for _, point in result.undecided]
        assert float(touch) == pytest.approx(np.pi, rel=1e-12)
        assert [x.kind.value for x in result.crossings] in ([], ["touches"])
    else:
        assert result.certified
        assert len(result.crossings) == crossings


@pytest.mark.parametrize("a", ["0.5", "1", "1.5", "1.57", "1.58", "2", "7"])
def test_a_delayed_loop_is_stable_up_to_a_quarter_turn(a: str) -> None:
    """s + a exp(-s) has all its zeros in the open left half plane exactly for 0 < a < pi/2."""
    from sympy import exp

    from haptisym.kernel.dynamics import Ring

    f = 1 / (hs.s + Rational(a) * exp(-hs.s))
    assert is_stable(Ring.of([f]).convert(f).reduced()) is (float(a) < np.pi / 2)


def test_sample_and_hold_alone_is_stable() -> None:
    assert hs.evaluate(hs.Scene(PAPER, (F.zero_order_hold("5 ms"),))).stable is True


def test_three_hundred_digits_of_a_delayed_crossing_are_those_of_the_inverse_sine() -> None:
    import mpmath

    scene = hs.Scene(E.mass_spring_damper(k=100), (F.delay("0.25"),), (0, 5))
    [crossing] = [c for c in hs.evaluate(scene, 300).crossings if c.part is hs.Part.IMAG]
    with mpmath.workdps(320):
        assert crossing.omega.digits(300) == mpmath.nstr(4 * mpmath.asin(mpmath.mpf(1) / 10), 300, strip_zeros=False)


def test_a_band_may_end_where_the_delay_has_made_half_a_turn() -> None:
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.delay("10 ms"),)).with_band(0, "50 Hz")
    assert hs.evaluate(scene).certified


def test_fractional_tissue_has_no_changeover() -> None:
    assert hs.evaluate(hs.Scene(E.spring_pot(100, "1/4"), (), (Integer(0), Integer(5)))).changeovers_environment == ()


@pytest.mark.parametrize("places", [("0", "15"), ("1", "400"), ("20*pi", "60*pi")])
def test_functions_of_one_angle_have_the_zeros_that_a_search_finds(
    places: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A delayed spring: arctangents on one path, subdivision and interval Newton on the other."""
    low, high = (Rational(x) if "pi" not in x else Rational(x[:2]) * pi for x in places)
    asked = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("0.05"),), (low, high), "0.3")
    by_angle = [c.omega.digits(20) for c in hs.evaluate(asked).crossings]
    monkeypatch.setattr(factoring, "PeriodicFactor", AnalyticFactor)
    searched = hs.evaluate(hs.Scene(asked.environment, asked.effects, asked.band, asked.threshold))
    assert [c.omega.digits(20) for c in searched.crossings] == by_angle
    assert by_angle


@pytest.mark.parametrize(("long", "short"), [("10 ms", "0.01 ms"), ("10 s", "1 ns")])
def test_a_delay_that_is_thousands_of_another_one_keeps_a_variable_of_its_own(long: str, short: str) -> None:
    """Not a power of the short one's, of degree 1000 and more: a delay of next to nothing moves the crossings by as little."""
    wall = hs.environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    both, alone = (
        hs.evaluate(hs.Scene(wall, effects, (0, 3))).crossings
        for effects in ((hs.effects.delay(long), hs.effects.delay(short)), (hs.effects.delay(long),))
    )
    assert [c.part for c in both] == [c.part for c in alone]
    for one, other in zip(both, alone, strict=True):
        assert float(one.omega) == pytest.approx(float(other.omega), rel=2e-3)


@pytest.mark.parametrize("band", [("25 Hz", "75 Hz"), ("0 Hz", "25 Hz"), ("12.5 Hz", "100 Hz")])
@pytest.mark.parametrize(
    "environment", [hs.environments.mass_spring_damper(k=100), hs.environments.spring_pot(100, "0.3")]
)
def test_a_band_may_end_where_the_phase_of_a_delay_is_a_quarter_turn(
    environment: hs.Environment, band: tuple[str, str]
) -> None:
    """There Re H_perc of a spring vanishes exactly: an end of the band is a zero, not an undecided sign."""
    found = hs.evaluate(hs.Scene(environment, (hs.effects.delay("10 ms"),), band))
    assert found.certified
    wider = hs.evaluate(hs.Scene(environment, (hs.effects.delay("10 ms"),), ("0 Hz", "101 Hz"))).crossings
    low, high = (float(x) for x in found.scene.band)
    inside = [float(c.omega) for c in wider if low <= float(c.omega) <= high]
    assert [float(c.omega) for c in found.crossings] == pytest.approx(inside, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("order", "c"), [("0.5", 19), ("0.5", -19), ("1.5", 2), ("1.5", -2)])
def test_half_orders_that_change_both_parts_alike_are_noticed_in_both_at_once(order: str, c: int) -> None:
    """Re = +-Im of c (j omega)^(n + 1/2): both ratios meet 10 % where 50 c^2 omega^(2 n + 1) = k^2 + b^2 omega^2."""
    k, b = 341, Rational("16.2")
    scene = hs.Scene(E.kelvin_voigt(k, b), (F.shunt(Z=f"{c}*s^{order}"),), (0, 15))
    found = hs.evaluate(scene)
    equation = (
        [float(-(b**2)), 50.0 * c**2, float(-(k**2))] if order == "0.5" else [50.0 * c**2, float(-(b**2)), 0, -(k**2)]
    )
    expected = sorted(x.real for x in np.roots(equation) if abs(x.imag) < 1e-9 and 0 < x.real < 15)
    for part, sign in ((hs.Part.REAL, c if order == "0.5" else -c), (hs.Part.IMAG, c)):
        of_part = [x for x in found.crossings if x.part is part]
        assert [float(x.omega) for x in of_part] == pytest.approx(expected, rel=1e-12)
        assert [x.kind.value for x in of_part] == ["exceeds"]
        assert [x.sign * sign > 0 for x in of_part] == [True]
    assert found.certified
    floor = hs.evaluate(
        hs.Scene(scene.environment, scene.effects, (0, 15), {"real": 0.001, "imag": 0.001, "floor": "5 N/m"})
    )
    [first, second, *_] = floor.crossings
    assert {first.part, second.part} == {hs.Part.REAL, hs.Part.IMAG}
    assert (
        float(first.omega)
        == float(second.omega)
        == pytest.approx((5 * 2**0.5 / abs(c)) ** (1 / float(order)), rel=1e-12)
    )
