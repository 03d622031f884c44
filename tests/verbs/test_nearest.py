"""Where no value of a parameter will do: the one that is said to come nearest, and what is said to be proven, on dense grids."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.model.jnd import Part
from haptisym.verbs.require.entry import require
from haptisym.verbs.require.feasible import Kind, spanned
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.guesses import Guesses


def _times(scene: hs.Scene) -> float:
    """By how much the worse ratio exceeds its threshold on a dense grid."""
    low, high = (float(x) for x in scene.band)
    f = scene.distortion().compile()(np.linspace(low, high, 2001)[1:])
    real, imag = (float(scene.threshold[part]) for part in Part)
    return float(max(np.max(f.ratio_real) / real, np.max(f.ratio_imag) / imag))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "asked", "values"),
    [
        ("environment.m", None, np.geomspace(0.01, 100, 200)),
        ("effects.filter.omega_n", (50, 100), np.linspace(50, 100, 100)),
        ("effects.filter.zeta", (2, 5), np.linspace(2, 5, 50)),
    ],
)
def test_the_nearest_value_fails_by_what_is_said_and_none_by_less(
    path: str, asked: tuple[int, int] | None, values: np.ndarray
) -> None:
    scene = hs.load_scene("fu2019")
    found = require(scene, path, asked)
    assert (found.feasible, found.certified) == ((), True)
    x = found.nearest
    assert x is not None
    name = path.rsplit(".", 1)[1]
    assert _times(scene.with_values({name: x.value})) == pytest.approx(x.times, rel=1e-4)
    assert float(x.ratio) == pytest.approx(x.times / 10)
    assert 1 < x.at_least <= x.times
    assert x.times < 1.1 * x.at_least
    assert min(_times(scene.with_values({name: str(v)})) for v in values) >= x.at_least * (1 - 1e-4)


def test_what_binds_at_the_nearest_value_is_said() -> None:
    found = require(hs.load_scene("fu2019"), "omega_n", (50, 100))
    x = found.nearest
    assert x is not None
    assert (x.value, x.binding.part, x.binding.kind, x.binding.omega.digits(4)) == (100, Part.IMAG, Kind.EDGE, "15.00")
    row = found.to_dict()["nearest"]
    assert (row["value"], row["part"], row["kind"]) == (100.0, "imag", "band-edge")
    page = " ".join(str(found).split())
    assert "ω_n = 100 rad/s" in page
    assert "Proven: no value that was asked about keeps all ratios below" in page


def test_a_ratio_that_no_delay_changes_bounds_them_all() -> None:
    """The ratio at 0 rad/s is 10/12 whatever the delay, also one without bound."""
    x = require(hs.load_scene("position-force-teleoperation"), "tau").nearest
    assert x is not None
    assert float(x.ratio) == pytest.approx(10 / 12)
    assert 8 < x.at_least <= x.times


def test_the_nearest_value_is_the_scenes_own_where_others_are_no_better_and_no_extreme_one() -> None:
    """r_r is 10/12 at 0 rad/s whatever the master's mass: as near as any is that of the scene."""
    x = require(hs.load_scene("position-force-teleoperation"), "Mm").nearest
    assert x is not None
    assert x.value == Rational(1, 2)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "path"), [("virtual-wall", "device.b"), ("sampled-wall", "rendered.w")])
def test_floats_find_what_comes_nearest_and_balls_prove_that_others_come_hardly_nearer(name: str, path: str) -> None:
    scene = hs.load_scene(name)
    x = require(scene, path).nearest
    assert x is not None
    assert x.times < 1.05 * x.at_least
    assert _times(scene.with_values({scene.knobs[path].path: x.value})) == pytest.approx(x.times, rel=1e-4)
    own = float(scene.knobs[path].value)
    tried = [_times(scene.with_values({scene.knobs[path].path: str(v)})) for v in own * np.geomspace(1e-3, 1e3, 40)]
    assert min(tried) >= x.at_least * (1 - 1e-4)


def test_where_some_values_do_none_is_nearest() -> None:
    found = require(hs.load_scene("fu2019"), "omega_n")
    assert found.nearest is None
    assert "nearest" not in found.to_dict()


@pytest.mark.slow
def test_where_no_value_does_all_that_is_asked_each_thing_is_told_by_itself_and_what_is_nearest() -> None:
    """Slow filters are noticed, and held by the arm all the same: before, the page said no value, and nothing more."""
    found = require("fu2019", "omega_n", (1, 50), that=("transparent", "stable"), hand="postural-arm")
    plain = require("fu2019", "omega_n", (1, 50))
    assert not found.feasible
    assert (found.alone[0].feasible, found.alone[0].undecided) == ((), ())
    held = require("fu2019", "omega_n", (1, 50), that="stable", hand="postural-arm")
    assert [spanned(x) for x in found.alone[1].feasible] == [spanned(x) for x in held.feasible]
    assert [float(x.high.value) for x in held.feasible] == [50]
    said, known = (" ".join(str(x).split()) for x in (found, plain))
    assert "By itself: transparent on the whole band for no value and stable in postural-arm for 1 ≤ omega_n ≤ 50" in (
        said.replace("ω_n", "omega_n")
    )
    nearest = known[known.index("Nearest of those") : known.index("Certain")]
    assert nearest in said
    assert require("fu2019", "omega_n", (1, 500), that=("transparent", "stable"), hand="postural-arm").alone == ()


def test_of_several_things_that_no_value_does_together_each_is_told_alone() -> None:
    """Behind a lag of w the wall is stable in the hand for 2 + 0.28 w > 42 and fit for every passive hand for 300/w <= 1.8."""
    scene = hs.Scene(
        environments.kelvin_voigt(300, 1),
        (effects.first_order_lag(100), effects.shunt(m="0.04 kg", b="0.8 N*s/m")),
        (0, 10),
        hs.Threshold.of("0.01"),
        hands=(hs.Hand("own", m="0.1 kg", b="0.2 N*s/m"),),
    )
    found = require(scene, "omega_c", (20, 200), that=("transparent", "stable", "passive"))
    assert (found.feasible, found.undecided) == ((), ())
    assert [[x.name for x in r.criteria] for r in found.alone] == [["real", "imag"], ["stable"], ["passive"]]
    ends = [[(float(x.low.value), float(x.high.value)) for x in r.feasible] for r in found.alone]
    assert ends == [[], [(pytest.approx(1000 / 7), 200)], [(pytest.approx(500 / 3), 200)]]
    assert all(
        (r.that, r.undecided, r.scene, r.free, r.domain) == ((), (), scene, found.free, found.domain)
        for r in found.alone
    )
    assert require(scene, "omega_c", (180, 200), that=("stable", "passive")).alone == ()
    assert require(scene, "omega_c", (20, 200)).alone == ()


@pytest.mark.few("6")
@pytest.mark.parametrize("seed", range(7))
def test_of_parabolas_that_a_number_moves_up_and_down_the_middle_one_is_nearest(seed: int) -> None:
    """|t - c w^2| over a band needs at least half of what c w^2 spans, at the t halfway; with just that it is the only value."""
    pick = Random(seed)
    for _ in range(5 if seed < 6 else 2):
        c, limit = Fraction(pick.randint(1, 5), 100), Fraction(pick.randint(1, 9), 100)
        low = pick.choice([0, 1, 2])
        high = low + pick.randint(2, 5)
        half = c * (high**2 - low**2) / 2
        limit = pick.choice([limit, limit, half])
        gain = effects.series("1 + t + c*s^2", parameters={"t": "1/10", "c": str(c)})
        scene = hs.Scene(
            environments.mass_spring_damper(k=100), (gain,), (low, high), hs.Threshold(str(limit), str(limit))
        )
        found = hs.require(scene, "t", (-9, 9))
        if half <= limit:
            [span] = found.feasible
            ends = c * high**2 - limit, c * low**2 + limit
            for end, truth in zip((span.low, span.high), ends, strict=True):
                assert end.value is not None
                assert float(end.value) == pytest.approx(float(truth), rel=1e-14)
            assert (" to " in spanned(span)) is (half < limit)
            assert found.nearest is None
            continue
        best, near = float(half / limit), found.nearest
        assert (found.feasible, found.undecided) == ((), ())
        assert near is not None
        own = Fraction(int(near.value.p), int(near.value.q))
        needed = max(abs(own - c * low**2), abs(own - c * high**2))
        assert float(near.ratio) == pytest.approx(float(needed), rel=1e-14)
        assert near.times == pytest.approx(float(needed / limit), rel=1e-14)
        assert near.at_least <= best <= near.times * (1 + 1e-14)
        assert near.at_least > 0.9 * best


@pytest.mark.slow
def test_of_a_number_that_nothing_depends_on_the_nearest_value_is_the_scenes_own() -> None:
    """A four-channel teleoperator without delay passes H_env on, whatever it weighs; the answer was an error about parameters."""
    channels = hs.effects.four_channel_teleoperator(Mm="0.5", Bm=16, Km=10, Ms=2, Bs=64, Ks=40)
    scene = hs.Scene(hs.environments.kelvin_voigt(463, 3), (channels, hs.effects.first_order_lag(30)), (0, 15))
    found = require(scene, "Mm")
    nearest = found.nearest
    assert nearest is not None
    assert not found.feasible
    assert float(nearest.value) == 0.5
    wall = 463 + 45j
    assert float(nearest.ratio) == pytest.approx(abs(((1 / (1 + 0.5j) - 1) * wall).imag) / abs(wall))
    assert found.to_dict()["nearest"]["value"] == 0.5
    assert len(found.figure().axes) == 1


class Valley(Guesses):
    """1 + |t - a|/size, but for values below a limit, at which there is no scene."""

    @classmethod
    def at(cls, a: float, size: float, own: Rational, domain: Domain, least: float = -inf) -> Valley:
        found = cls(None, SimpleNamespace(value=own), domain, ())  # type: ignore[arg-type]
        found.__dict__.update(a=a, size=size, least=least)
        return found

    def times(self, t: Any) -> Any:
        return np.where(t < self.least, np.nan, 1 + np.abs(t - self.a) / self.size)  # type: ignore[attr-defined]


@pytest.mark.parametrize("seed", range(5))
def test_a_guess_is_as_good_as_any_value_of_the_range_simple_and_the_own_one_where_that_is_as_good(seed: int) -> None:
    pick = Random(seed)
    for _ in range(6):
        low, high = sorted(pick.sample(range(-20, 20), 2))
        ends = [pick.choice([None, Rational(low)]), pick.choice([None, Rational(high)])]
        asked = Domain(*ends, pick.random() < 0.5, pick.random() < 0.5)
        own = Rational(pick.choice([-3, 1, 2, 7, 0]), pick.choice([1, 4]))
        a = pick.uniform(-30, 30)
        valley = Valley.at(a, 10.0 ** pick.randint(0, 2), own, asked)
        best = min(max(a, float("-inf") if ends[0] is None else low), float("inf") if ends[1] is None else high)
        found = [*valley.best()]
        assert found
        for value in found[-1:]:
            assert value.is_Rational
            assert ends[0] is None or value > low or (value == low and asked.holds_low)
            assert ends[1] is None or value < high or (value == high and asked.holds_high)
            inside = float(valley.times(np.array(best)))
            assert float(valley.times(np.array(float(value)))) <= inside * 1.03
        flat = Valley.at(0.0, 1e18, own, asked)
        is_asked = (ends[0] is None or low < own) and (ends[1] is None or own < high)
        assert own == 0 or not is_asked or own in [*flat.best()]
    wide = Domain(None, None)
    assert [*Valley.at(0.0, 1.0, Rational(1), wide, least=inf).best()] == []  # there is no scene at all
    assert [*Valley.at(3.0, 1.0, Rational(1), wide).best()] == [3]
    assert [*Valley.at(-2.5, 1.0, Rational(1), wide).best()] == [Rational(-5, 2)]
    assert next(Valley.at(-2.5, 1.0, Rational(1), wide, least=0.25).best()) == pytest.approx(0.25, rel=1e-3)
    assert abs(next(Valley.at(0.0, 1.0, Rational(1), wide).best())) < 0.01


@pytest.mark.parametrize("own", [2, Rational(-1, 4), 0])
def test_values_are_tried_all_over_a_range_and_a_million_times_as_far_as_the_own_one_without_bound(own: Any) -> None:
    size = abs(float(own)) or 1.0
    for low, high in (
        (None, None),
        (Rational(1), None),
        (None, Rational(-1)),
        (Rational(-3), Rational(8)),
        (Rational(5), None),
    ):
        for holds in (True, False):
            grid = Valley.at(0.0, 1.0, Rational(own), Domain(low, high, holds, holds))._grid()
            start = -1e6 * size if low is None else float(low)
            end = float(high) if high is not None else max(1e6 * size, 2 * start)
            assert (np.diff(grid) > 0).all()
            assert not holds or {start, end} <= {*grid}
            assert start <= grid[0] <= start + 1.1 * (end - start) / 240
            assert end - 1.1 * (end - start) / 240 <= grid[-1] <= end
            assert (low is None) or holds or grid[0] > start
            assert (high is None) or holds or grid[-1] < end
            assert np.diff(grid).max() <= (end - start) / 240 * (1 + 1e-9)
            for near in (start, end):
                for n in range(-5, 6):
                    x = near + size * 10.0**n * (1 if near == start else -1)
                    if start < x < end:
                        assert np.abs(grid - x).min() <= 1e-9 * max(abs(x), size)
