"""What pages say of several environments, and of effects that may be left out: springs behind lags, and dampers beside them."""

from __future__ import annotations

import re
from functools import cache
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from pagewords import flat, lines, row

import haptisym as hs

E, F = hs.environments, hs.effects
LAG = F.first_order_lag(20)
FIRST = 20 * (5 - sqrt(24))


def scene(environment: Any, *effects: Any, band: tuple[Any, Any] = (0, 15), jnd: Any = "0.1") -> hs.Scene:
    return hs.Scene(environment, effects, band, jnd)


@cache
def dampers() -> hs.FamilyEvaluation:
    """A damper of 1 N s/m beside springs of 50, 100 and 400 N/m: noticed from 5, 10 and never up to 15 rad/s."""
    springs = {"soft": 50, "firm": 100, "stiff": 400}
    return hs.evaluate_all(
        hs.SceneFamily({name: scene(E.mass_spring_damper(k=k), F.shunt(b=1)) for name, k in springs.items()})
    )


# Several environments


def test_each_environment_has_its_row_and_the_softest_binds() -> None:
    for name, told in (
        ("soft", "never 5 5 higher damping"),
        ("firm", "never 10 10 higher damping"),
        ("stiff", "never never whole band -"),
    ):
        assert row(dampers(), name) == told
    text = flat(dampers())
    assert f"Up to 5 rad/s ({5 / 2 / pi:.5g} Hz), the common bandwidth." in text
    assert "At 5 rad/s soft (imag part, r_i) binds." in text
    assert "All of it:" not in text
    assert "effects shunt" in lines(dampers())
    assert "threshold 10 % of |H_env|" in lines(dampers())
    assert row(dampers(), "band") == f"0 rad/s (0 Hz) to 15 rad/s ({15 / 2 / pi:.5g} Hz)"
    assert "UNDECIDED" not in text


def test_environments_that_bind_together_are_listed() -> None:
    """Behind a lag every spring is noticed at the same frequency."""
    two = hs.SceneFamily({name: scene(E.mass_spring_damper(k=k), LAG) for name, k in (("soft", 50), ("stiff", 400))})
    assert f"At {FIRST:.5g} rad/s soft (imag part, r_i) and stiff (imag part, r_i) bind." in flat(hs.evaluate_all(two))


@pytest.mark.parametrize(
    ("masses", "told"),
    [
        ((0, 0), "Nowhere on the band."),
        ((1, 1), "Only from 4.4721 to 15 rad/s."),
    ],
)
def test_where_no_common_band_starts_at_the_low_end_that_is_said(masses: tuple[int, int], told: str) -> None:
    """A spring of 2 N/m beside masses: noticed below sqrt(20) rad/s; a gain of 1.3 of springs, everywhere."""
    if masses[0]:
        family = {n: scene(E.mass_spring_damper(m=m), F.shunt(k=2)) for n, m in (("light", 1), ("heavy", 2))}
    else:
        family = {n: scene(E.mass_spring_damper(k=k), F.series("1.3")) for n, k in (("soft", 1), ("stiff", 2))}
    assert told in lines(hs.evaluate_all(hs.SceneFamily(family)))


def test_a_common_band_that_starts_again_is_told_with_all_of_it() -> None:
    """Of a spring of 50 N/m beside m s^2 + 1000: |1000 - w^2| < 500 is noticed, of all from sqrt(500) to sqrt(1500)."""
    family = {
        name: scene(E.mass_spring_damper(m=1, k=k), F.shunt(k=50), band=(0, 60))
        for name, k in (("one", 1000), ("two", 1100))
    }
    text = flat(hs.evaluate_all(hs.SceneFamily(family)))
    low, high = sqrt(500), sqrt(1600)
    assert f"Up to {low:.5g} rad/s ({low / 2 / pi:.5g} Hz), the common bandwidth. All of it: from 0 to {low:.5g} rad/s and from {high:.5g} to 60 rad/s." in text  # fmt: skip
    assert f"At {low:.5g} rad/s one (real part, r_r) binds." in text


# Which effects matter


@cache
def relevance(tolerance: str = "0.02") -> hs.Relevance:
    return hs.relevance(
        scene(E.mass_spring_damper(k=100), LAG, F.shunt(b=1), F.first_order_lag("1 MHz", name="cable"), band=(1, 15)),
        tolerance,
    )


def test_effects_that_matter_are_kept_and_the_others_are_bounded() -> None:
    text = flat(relevance())
    assert (
        "2 of 3 effects matter: first-order-lag and shunt. Leaving out all others together changes r_r by at most "
        in text
    )
    assert "anywhere on the band (tolerance 0.02)." in text
    told = re.search(r"The distortion then takes (\d+) operations, written in steps, where it took (\d+)\.", text)
    assert told
    assert 0 < int(told[1]) < int(told[2])
    kept = {name: row(relevance(), name).endswith("kept") for name in ("first-order-lag", "shunt", "cable")}
    assert kept == {"first-order-lag": True, "shunt": True, "cable": False}
    assert float(row(relevance(), "shunt").split()[1]) <= 1e-4  # of the real part; w/100 of the imaginary one at 15
    assert 0.15 <= float(row(relevance(), "shunt").split()[2]) <= 0.152
    assert [x.split()[0] for x in lines(relevance()) if x.split()[:1] in (["first-order-lag"], ["shunt"], ["cable"])][:3] == ["first-order-lag", "shunt", "cable"]  # fmt: skip


def test_the_crossings_of_the_full_scene_are_enclosed_and_what_is_known_of_them_is_told() -> None:
    """w^2/(w^2 + 400) is a tenth at 20/3, and 20 w/(w^2 + 400) - w/100 at the least root of w^3 + 10 w^2 - 1600 w + 4000."""
    text, shown = flat(relevance()), lines(relevance())
    rows = [x for x in shown if x.startswith(("imag ", "real ")) and ("at least one" in x or "none, one" in x)]
    assert any(x.startswith("real 6.666") for x in rows)
    least = min(x.real for x in np.roots([1, 10, -1600, 4000]) if x.real > 0)
    assert any(abs(float(x.split()[1]) - least) < 1e-3 for x in rows if x.startswith("imag "))
    assert "Where the full scene's crossings are" in shown
    assert "No smaller set of effects stays within the tolerance, 0.02." in text
    assert "The full scene has no crossing on the band." not in text


def test_a_single_effect_dominates_without_a_table_and_none_leaves_nothing_to_say() -> None:
    one = hs.relevance(scene(E.mass_spring_damper(k=100), F.shunt(b=1), band=(1, 15)), "0.02")
    assert "1 of 1 effects matter: shunt." in flat(one)
    assert "Leaving out" not in flat(one)
    assert "Which one changes the ratios most" not in lines(one)
    assert "Unbounded" not in flat(one)


def test_where_the_environment_vanishes_a_change_has_no_bound_and_that_is_said() -> None:
    at_ten = hs.relevance(scene(E.mass_spring_damper(m=1, k=100), F.shunt(b=1), band=(1, 15)), "0.02")
    assert "Unbounded: near a frequency where H_env = 0 or a dynamics is infinite, no bound exists." in flat(at_ten)
    assert "unbounded" in row(at_ten, "shunt")


def test_what_other_regions_say_of_each_environment_and_of_all_is_told() -> None:
    """A change of the imaginary part alone leaves square, disc and diamond at the same frequency, a tenth of the spring's."""
    springs = {"soft": 50, "firm": 100}
    family = hs.SceneFamily({name: scene(E.mass_spring_damper(k=k), F.shunt(b=1)) for name, k in springs.items()})
    shown = lines(hs.evaluate_all(family, regions=True))
    for told in ("soft 5 5 5 5", "firm 10 10 10 10", "all 5 5 5 5"):
        assert shown.count(told) == 1, told
    assert "All regions give the same common bandwidth, 5 rad/s." in shown
    assert "Does it survive another JND model?" not in lines(dampers())
