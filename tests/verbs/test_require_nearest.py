"""Where no value of a parameter will do the one that comes nearest; and values that go to 0 or far out: against dense grids and evaluations."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from random import Random
from typing import Any

import numpy as np
import pytest
from sympy import Rational

import haptisym as hs
from haptisym.judge.bindings import Kind
from haptisym.model.jnd import Part
from haptisym.verbs.require.required import Requirement

E, F = hs.environments, hs.effects


def times_of(scene: hs.Scene) -> float:
    """By how much the worse ratio exceeds its threshold on a dense grid."""
    low, high = (float(x) for x in scene.band)
    f = scene.distortion().compile()(np.linspace(low, high, 2001)[1:])
    real, imag = (float(scene.threshold[part]) for part in Part)
    return float(max(np.max(f.ratio_real) / real, np.max(f.ratio_imag) / imag))


def ends_of(found: Requirement) -> list[tuple[float, float]]:
    return [(-inf if x.low is None else float(x.low), inf if x.high is None else float(x.high)) for x in found.feasible]


# --- the nearest value -------------------------------------------------------------------------------------------------------


NOWHERE: dict[str, tuple[str, str, tuple[int, int] | None, Any]] = {
    "mass": ("fu2019", "environment.m", None, np.geomspace(0.01, 100, 12)),
    "filter": ("fu2019", "effects.filter.omega_n", (50, 100), np.linspace(50, 100, 12)),
    "damping": ("fu2019", "effects.filter.zeta", (2, 5), np.linspace(2, 5, 12)),
    "wall": ("virtual-wall", "device.b", None, np.geomspace(1e-3, 1e3, 12)),
    "sampled wall": ("sampled-wall", "rendered.w", None, np.geomspace(1, 1e5, 12)),
    "master": ("position-force-teleoperation", "Mm", None, np.geomspace(1e-3, 10, 12)),
    "delay": ("position-force-teleoperation", "tau", None, np.geomspace(1e-3, 1, 12)),
}


@pytest.mark.slow
@pytest.mark.few("filter")
@pytest.mark.parametrize("case", NOWHERE)
def test_the_nearest_value_fails_by_what_is_said_and_none_by_less(case: str) -> None:
    name, path, asked, values = NOWHERE[case]
    scene = hs.load_scene(name)
    found = hs.require(scene, path, asked)
    assert (found.feasible, found.certified) == ((), True)
    x, knob = found.nearest, scene.knobs[scene.knobs.chosen([path])[0].path].path
    assert x is not None
    assert times_of(scene.with_values({knob: x.value})) == pytest.approx(x.times, rel=1e-4)
    assert 1 < x.at_least <= x.times
    assert x.times < (2 if case == "delay" else 1.1) * x.at_least
    assert min(times_of(scene.with_values({knob: str(v)})) for v in values) >= x.at_least * (1 - 1e-4)


def test_what_binds_at_the_nearest_value_is_said() -> None:
    x = hs.require("fu2019", "omega_n", (50, 100)).nearest
    assert x is not None
    assert (x.value, x.binding.part, x.binding.kind, x.binding.omega.digits(4)) == (100, Part.IMAG, Kind.EDGE, "15.00")


@pytest.mark.dear("tau-None")
@pytest.mark.parametrize(("path", "own"), [("tau", None), ("Mm", Rational(1, 2))])
def test_a_ratio_that_no_value_changes_bounds_them_all_and_the_scenes_own_is_as_near_as_any(
    path: str, own: Any
) -> None:
    """The ratio at 0 rad/s is 10/12 whatever the delay, also one without bound, or the master's mass."""
    x = hs.require("position-force-teleoperation", path).nearest
    assert x is not None
    assert float(x.ratio) == pytest.approx(10 / 12)
    assert 8 < x.at_least <= x.times
    assert own is None or x.value == own


def test_where_some_values_do_none_is_nearest() -> None:
    found = hs.require("fu2019", "omega_n")
    assert (found.nearest, "nearest" in found.to_dict()) == (None, False)


def spring(gain: str, band: tuple[int, int], real: Any, imag: Any, **more: str) -> hs.Scene:
    effect = F.series(gain, parameters={"t": "1/10", **more})
    return hs.Scene(E.mass_spring_damper(k=100), (effect,), band, hs.Threshold(str(real), str(imag)))


@pytest.mark.dear("2")
@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(24))
def test_of_parabolas_that_a_number_moves_up_and_down_the_middle_one_is_nearest(seed: int) -> None:
    """|t - c w^2| spans c w^2 over a band, and needs half of that, at the t halfway; |d w| at its end whatever t is."""
    pick = Random(seed)
    c, d, limit = Fraction(pick.randint(1, 5), 100), Fraction(pick.randint(0, 1), 20), Fraction(pick.randint(1, 9), 100)
    low = pick.choice([0, 1, 2])
    high = low + pick.randint(2, 5)
    half = c * (high**2 - low**2) / 2
    limit, other = half if seed % 4 == 0 else limit, Fraction(pick.randint(1, 9), 50)
    found = hs.require(spring(f"1 + t + ({c})*s^2 + ({d})*s", (low, high), limit, other), "t", (-9, 9))
    best = max(half / limit, d * high / other)
    assert found.undecided == ()
    if best <= 1:
        assert ends_of(found) == [pytest.approx((float(c * high**2 - limit), float(c * low**2 + limit)), rel=1e-14)]
        assert found.nearest is None
        return
    near = found.nearest
    assert found.feasible == ()
    assert near is not None
    own = Fraction(int(near.value.p), int(near.value.q))
    reals = {Kind.START: abs(own - c * low**2), Kind.EDGE: abs(own - c * high**2)}
    needed = max(*(x / limit for x in reals.values()), d * high / other)
    assert near.times == pytest.approx(float(needed), rel=1e-14)
    is_real = needed > d * high / other
    assert float(near.ratio) == pytest.approx(float(needed * (limit if is_real else other)), rel=1e-14)
    assert near.binding.criterion.name == ("real" if is_real else "imag")
    kinds = [kind for kind, x in reals.items() if x / limit == needed] if is_real else [Kind.EDGE]
    assert near.binding.kind in kinds
    assert 0.9 * best < near.at_least <= float(best) * (1 + 1e-14)
    assert float(best) <= near.times * (1 + 1e-14)


def test_of_a_number_that_nothing_depends_on_the_nearest_value_is_the_scenes_own() -> None:
    """A four-channel teleoperator without delay passes H_env on, whatever it weighs."""
    channels = F.four_channel_teleoperator(Mm="0.5", Bm=16, Km=10, Ms=2, Bs=64, Ks=40)
    found = hs.require(hs.Scene(E.kelvin_voigt(463, 3), (channels, F.first_order_lag(30)), (0, 15)), "Mm")
    assert not found.feasible
    wall = 463 + 45j
    assert found.nearest is not None
    assert float(found.nearest.value) == 0.5
    assert float(found.nearest.ratio) == pytest.approx(abs(((1 / (1 + 0.5j) - 1) * wall).imag) / abs(wall))


def test_of_several_things_that_no_value_does_together_each_is_told_alone() -> None:
    """Behind a lag of w the wall is stable in the hand for 2 + 0.28 w > 42 and fit for every passive hand for 300/w <= 1.8."""
    behind = F.first_order_lag(100), F.shunt(m="0.04 kg", b="0.8 N*s/m")
    own = hs.Hand("own", m="0.1 kg", b="0.2 N*s/m")
    scene = hs.Scene(E.kelvin_voigt(300, 1), behind, (0, 10), hs.Threshold.of("0.01"), hands=(own,))
    found = hs.require(scene, "omega_c", (20, 200), that=("transparent", "stable", "passive"))
    assert (found.feasible, found.undecided) == ((), ())
    assert [[x.name for x in r.criteria] for r in found.alone] == [["real", "imag"], ["stable"], ["passive"]]
    assert [ends_of(r) for r in found.alone] == [[], [(pytest.approx(1000 / 7), 200)], [(pytest.approx(500 / 3), 200)]]
    assert hs.require(scene, "omega_c", (180, 200), that=("stable", "passive")).alone == ()
    assert hs.require(scene, "omega_c", (20, 200)).alone == ()


@pytest.mark.slow
def test_where_no_value_does_all_that_is_asked_what_one_of_them_asked_alone_says_is_told() -> None:
    """Slow filters are noticed, and held by the arm all the same."""
    both, plain, held = (
        hs.require("fu2019", "omega_n", (1, 50), that=x, hand="postural-arm") for x in (("transparent", "stable"), "transparent", "stable")
    )  # fmt: skip
    assert (both.feasible, both.alone[0].feasible, both.alone[0].undecided) == ((), (), ())
    assert ends_of(both.alone[1]) == ends_of(held) == [(1, 50)]
    assert plain.nearest is not None
    assert both.alone[0].nearest is not None
    assert both.alone[0].nearest.value == plain.nearest.value


# --- values that go to 0 or without bound ------------------------------------------------------------------------------------


def is_unnoticed(scene: hs.Scene) -> bool:
    e = hs.evaluate(scene)
    return [(x.low, x.high) for x in e.transparent] == [(e.chart.points[0], e.chart.points[-1])]


def need_evaluated(found: Requirement, values: Any) -> None:
    """What is said of values is what evaluations at them say."""
    for value in values:
        said = any(low < float(value) < high for low, high in ends_of(found))
        assert is_unnoticed(found.free.put(found.scene, value)) is said, value


TELEOPERATOR = "effects.four-channel-teleoperator.Mm"
HEAVY = hs.Scene(E.spring_pot(90, "0.9", k=1000), (F.four_channel_teleoperator("0.25", "2.6", 66, "3.3", 25, 11, "2.7 ms"), F.first_order_lag(43)), (0, 23), hs.Threshold.of("0.5"))  # fmt: skip
FAR: dict[str, tuple[str, hs.Scene, int, list[float] | None]] = {  # decades to both sides that are evaluated; ends that are known
    "mass": ("environment.m", hs.Scene(E.mass_spring_damper("0.4", 50, 170), (F.delay("0.49 ms"),), (0, "4.8"), hs.Threshold.of("0.1")), 5, None),
    "link": ("effects.wave-variables.b", hs.Scene(E.kelvin_voigt(1100, 28), (F.wave_variables("9.2", "8.5 ms"),), (0, "3.6"), hs.Threshold.of("0.5")), 5, None),
    "hold": ("effects.zero-order-hold.T", hs.Scene(E.maxwell(13, "4.7"), (F.zero_order_hold("0.97 ms"),), (0, 15), hs.Threshold.of("0.1")), 1, None),
    "spring": ("environment.k", hs.Scene(E.maxwell(150, "0.82"), (F.delay("2.8 ms"),), (0, "3.7"), hs.Threshold.of("0.2")), 5, None),
    "pot": ("environment.k_alpha", hs.Scene(E.spring_pot(27, "0.5", k=380), (F.delay("4.6 ms"),), (0, 34), hs.Threshold.of("0.2")), 5, None),
    "a limit at omega = 0, and damping without bound": ("effects.second-order-lowpass.zeta", hs.Scene(E.spring_pot(25, "0.9", k=320), (F.second_order_lowpass(36, "0.92"), F.first_order_lag(300), F.delay("13 ms")), (0, 18), hs.Threshold.of(1)), 2, [0.781069, 1.93020]),
    "a light resonance": ("environment.m", hs.Scene(E.mass_spring_damper("9.8", "4.5", 170), (F.first_order_lag(1500), F.zero_order_hold("31 ms")), (0, "3.7"), hs.Threshold.of("0.5")), 2, []),
    "what binds at omega = 0": ("environment.k", hs.Scene(E.mass_spring_damper("0.34", "9.3", 360), (F.zero_order_hold("3.4 ms"), F.compliance(8300, "7.7"), F.compliance(63000, "1.4")), (0, "9.2"), hs.Threshold.of("0.2")), 1, [1833.45]),
    "a heavy master": (TELEOPERATOR, HEAVY, 4, [1.46758]),
    "a heavy master that is noticed": (TELEOPERATOR, hs.Scene(E.zener(2400, 67, "0.91"), (F.second_order_lowpass(12, "0.46"), F.four_channel_teleoperator("0.61", 58, 14, "2.2", 50, 13, "58 ms")), (0, "7.2"), hs.Threshold.of("0.5")), 4, []),
    "a pot behind a hold": ("environment.k", hs.Scene(E.spring_pot(170, "0.2", k=1200), (F.shunt(m="0.5", b="6.6"), F.delay("0.73 ms"), F.zero_order_hold("1.6 ms")), (0, 74), hs.Threshold.of("0.2")), 1, [13344.85]),
    "a damped slave": ("effects.teleoperator.Bs", hs.load_scene("four-channel-teleoperation"), 2, [14.8962]),
    "a heavy slave": ("effects.teleoperator.Ms", hs.load_scene("four-channel-teleoperation"), 2, []),
    "a clock": ("effects.sampling.T", hs.load_scene("sampled-wall"), 1, []),
}  # fmt: skip


@pytest.mark.few("pot", "a light resonance")
@pytest.mark.parametrize("case", FAR)
def test_nothing_stays_open_beside_a_limit_or_a_resonance_for_a_thousand_times_the_value(case: str) -> None:
    path, scene, reach, ends = FAR[case]
    found = hs.require(scene, path)
    assert all(
        low is not None and float(low) > 1000 * float(found.free.value)
        for low, _ in ((p.low, p.high) for p in found.undecided)
    )
    near = 1000 * float(found.free.value)
    told = [x for span in ends_of(found) for x in span if 0 < x < inf and (x < near or not found.undecided)]
    assert ends is None or told == pytest.approx(ends, rel=1e-5)
    draw = Random(case)
    need_evaluated(found, [Rational(10 ** draw.uniform(-reach, reach)) * found.free.value for _ in range(4)])


@pytest.mark.slow
def test_where_a_hold_is_kept_at_frequency_0_the_ends_are_found_beyond() -> None:
    found = hs.require("virtual-wall", "environment.b")
    assert found.undecided == ()
    assert ends_of(found) == [pytest.approx((14.2773, 35.4501), rel=1e-5)]
    need_evaluated(found, [Rational(x) for x in ("14", "14.3", "35.4", "35.5")])


@pytest.mark.slow
def test_what_binds_at_frequency_0_behind_a_hold_is_known_to_all_digits() -> None:
    """1/k = (1/8300 + 1/63000) (1/0.2 - 1)."""
    path, scene, *_ = FAR["what binds at omega = 0"]
    [span] = hs.require(scene, path, (1000, 3000), part=hs.Part.REAL).feasible
    exact = Rational(1, 4) / (Rational(1, 8300) + Rational(1, 63000))
    assert span.high.digits(30) == str(exact.evalf(30))
    assert [x.kind for x in span.last.bindings] == [Kind.START]


@pytest.mark.slow
def test_beyond_an_end_no_sliver_is_left_at_the_frequencies_that_were_tried() -> None:
    """Where one of these is on the border for a value, the maximum beside it is not: the condition is broken there."""
    behind = F.wave_variables("1.8", "1.2 ms"), F.second_order_lowpass(100, "0.21"), F.delay("0.52 ms")
    scene = hs.Scene(E.zener(1800, 15, "5.2"), behind, (0, "8.3"), hs.Threshold.of("0.1"))
    found = hs.require(scene, "effects.wave-variables.tau")
    [span] = found.feasible
    end = Rational(span.high.digits(15))
    assert found.undecided == ()
    need_evaluated(found, [end * (1 + Rational(x, 10**8)) for x in (-1, 1, 4)])
