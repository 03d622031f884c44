"""What a chain of series effects does to every environment at once."""

from __future__ import annotations

import cmath

import numpy as np
import pytest
from mpmath import mp, mpf

import haptisym as hs
from haptisym.judge.bounds import ANY_ENVIRONMENT

E, F = hs.environments, hs.effects


def filtered(environment: hs.Environment, high: object = 15, c: object = 0.1) -> hs.Evaluation:
    return hs.evaluate(hs.Scene(environment, (F.second_order_lowpass("80 rad/s", "0.5"),), (0, high), c))


def test_the_papers_filter_is_noticed_with_no_environment_below_8_and_with_all_above_11() -> None:
    with mp.workdps(40):

        def length(w):  # type: ignore[no-untyped-def]
            s = 1j * w
            return abs(6400 / (s**2 + 80 * s + 6400) - 1)

        ends = [mp.findroot(lambda w, c=c: length(w) - c, 9) for c in (mpf("0.1"), mp.sqrt(2) / 10)]
    found = hs.load_scene("fu2019")
    answer = hs.evaluate(found).any_environment
    assert answer.transparent_below.digits(30) == mp.nstr(ends[0], 30)
    assert answer.opaque_above.digits(30) == mp.nstr(ends[1], 30)


@pytest.mark.parametrize("seed", range(40))
def test_no_environment_contradicts_the_bounds(seed: int) -> None:
    m, b, k = (seed % 5) / 2, 1 + seed % 7, 10 * (seed % 11)
    result = filtered(E.mass_spring_damper(m=m, b=b, k=k))
    below, above = (float(x) for x in (result.any_environment.transparent_below, result.any_environment.opaque_above))
    assert float(result.bandwidth) >= below
    assert all(float(x.high.omega) <= above * (1 + 1e-15) for x in result.transparent)


def test_both_bounds_are_attained() -> None:
    """By environments whose phase turns dH onto an axis, or halfway between both, at that frequency."""
    answer = hs.load_scene("fu2019")
    bounds = hs.evaluate(answer).any_environment
    for end, turn in ((float(bounds.transparent_below), 0), (float(bounds.opaque_above), cmath.pi / 4)):
        s = 1j * end
        phase = turn - cmath.phase(6400 / (s**2 + 80 * s + 6400) - 1)
        H = cmath.exp(1j * (phase % cmath.pi))
        environment = E.mass_spring_damper(m=max(0, -H.real) / end**2, b=H.imag / end, k=max(0, H.real))
        assert float(filtered(environment).bandwidth) == pytest.approx(end, rel=1e-9)


def test_a_shunt_has_no_such_bounds() -> None:
    assert hs.evaluate(hs.Scene(E.mass_spring_damper(k=100), (F.shunt(m=1),))).any_environment is None


def test_where_nothing_stands_between_every_environment_is_transparent() -> None:
    answer = hs.evaluate(hs.Scene(E.mass_spring_damper(k=100))).any_environment
    assert (float(answer.transparent_below), answer.opaque_above) == (15.0, None)


def test_a_gain_that_is_wrong_from_the_start_is_never_unnoticed() -> None:
    answer = hs.evaluate(hs.Scene(E.mass_spring_damper(k=100), (F.series("1.3"),))).any_environment
    assert (answer.transparent_below, float(answer.opaque_above)) == (None, 0.0)


def test_different_thresholds_bound_by_the_smaller_and_by_both_together() -> None:
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.delay("10 ms"),), (0, 60), hs.Threshold.of("0.06", "0.08"))
    answer = hs.evaluate(scene).any_environment
    with mp.workdps(30):
        ends = [200 * mp.asin(mpf(c) / 2) for c in ("0.06", "0.1")]
    assert [x.digits(15) for x in (answer.transparent_below, answer.opaque_above)] == [
        mp.nstr(x, 15, strip_zeros=False) for x in ends
    ]


# --- ends of the bands, touches --------------------------------------------------------------------------------------


def any_environment(gain: str, c: object, imag: object = None, band: tuple[object, object] = (0, 15)):  # type: ignore[no-untyped-def]
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.series(gain),), band, hs.Threshold.of(c, imag))
    return hs.evaluate(scene).any_environment


def test_a_touch_from_below_leaves_every_environment_transparent() -> None:
    """|G - 1| of a band-pass on a circle peaks at half its gain, at 3 rad/s."""
    found = any_environment("1 + 0.2*s/(s^2 + 2*s + 9)", "0.1")
    assert (float(found.transparent_below), found.opaque_above) == (15.0, None)
    above = any_environment("1 + 0.2000001*s/(s^2 + 2*s + 9)", "0.1")
    assert 2.9 < float(above.transparent_below) < 3


def test_a_touch_from_above_is_the_last_frequency_that_some_environment_passes() -> None:
    """|G - 1| of a notch dips to half its gain at 3 rad/s: to sqrt(c_real^2 + c_imag^2) there, and nowhere else."""
    found = any_environment("1 + 0.2*(s^2 + s + 9)/(s^2 + 2*s + 9)", "0.06", "0.08")
    assert (found.transparent_below, float(found.opaque_above)) == (None, 3.0)
    never = any_environment("1 + 0.2*(s^2 + s + 9)/(s^2 + 2*s + 9)", "0.06", "0.0799")
    assert (never.transparent_below, float(never.opaque_above)) == (None, 0.0)


def test_only_the_first_transparent_and_the_last_opaque_interval_count() -> None:
    """Transparent up to about 2.5 and again from about 3.6 on; opaque only in between, which is not up to the end."""
    found = any_environment("1 + 2*s/(s^2 + 2*s + 9)", "0.5")
    assert 1 < float(found.transparent_below) < 3
    assert found.opaque_above is None
    later = any_environment("1 + 2*s/(s^2 + 2*s + 9)", "0.5", band=(3, 15))
    assert (later.transparent_below, later.opaque_above) == (None, None)
    middle = any_environment("1 + 2*s/(s^2 + 2*s + 9)", "0.5", band=("2.9", "3.1"))
    assert (middle.transparent_below, float(middle.opaque_above)) == (None, 2.9)
    twice = any_environment("1 + 0.2*s^2/9", "0.1", band=(0, 15))  # opaque from a frequency inside up to the end
    assert float(twice.transparent_below) == pytest.approx(4.5**0.5)
    assert float(twice.opaque_above) == pytest.approx((4.5 * 2**0.5) ** 0.5)


def test_effects_that_are_not_all_in_series_and_another_rendering_have_no_such_bounds() -> None:
    spring, lag, shunt, soft = E.mass_spring_damper(k=100), F.first_order_lag(20), F.shunt(m=1), F.compliance(k=1000)
    for chain in ((lag, shunt), (shunt, lag), (soft, lag), (lag, soft), (soft,), (shunt, soft)):
        assert hs.evaluate(hs.Scene(spring, chain)).any_environment is None
    rendered = hs.Scene(spring, (lag,), rendered=E.mass_spring_damper(k=101))
    assert hs.evaluate(rendered).any_environment is None
    same = hs.Scene(spring, (lag,), rendered=E.mass_spring_damper(k=100))
    assert float(hs.evaluate(same).any_environment.transparent_below) == pytest.approx(20 / 99**0.5)


def test_what_is_drawn_for_any_environment_is_how_far_the_effects_are_from_one() -> None:
    s = 9j
    values = hs.load_scene("fu2019").distortion().compile()(np.array([9.0]))
    assert ANY_ENVIRONMENT.sampled is not None
    found = ANY_ENVIRONMENT.sampled(values)
    assert found[0] == pytest.approx(abs(6400 / (s**2 + 80 * s + 6400) - 1), rel=1e-14)
    assert not np.iscomplexobj(found)
