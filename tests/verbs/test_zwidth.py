"""A device fitted to the walls at which it began to shake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from refusals import refusal

import haptisym as hs
from haptisym import effects, environments
from haptisym.verbs.identify.zwidth import ZWidth, read_walls

CLOCK = effects.sampled_loop("1 ms", "backward-difference")
DISPLAY = hs.Scene(environments.kelvin_voigt(100, 1), (CLOCK, effects.shunt(m="0.1 kg", b="1 N*s/m", name="device")))
M, B = "effects.device.m", "effects.device.b"
DAMPINGS = np.array([0.0, 1.0, 2.0, 5.0, 10.0, 20.0])
OFF = DISPLAY.with_values({M: "0.3 kg", B: "0.4 N*s/m"})


def limits(scene: hs.Scene) -> np.ndarray:
    return ZWidth.of(scene, ()).limits([], DAMPINGS)


@pytest.mark.parametrize("damping", [0, "0.5", 5])
def test_the_limit_of_a_wall_is_the_proven_one(damping: str) -> None:
    scene = DISPLAY.with_values({"environment.b": damping, "environment.k": 10})
    [piece] = hs.require(scene, "environment.k", that="stable", hand="none").feasible
    assert ZWidth.of(scene, ()).limit([], float(damping)) == pytest.approx(float(piece.last.value), rel=1e-9)


def test_a_device_is_found_again_from_its_walls() -> None:
    found = hs.fit_zwidth(OFF, list(zip(limits(DISPLAY), DAMPINGS, strict=True)), [M, B])
    assert [x.path for x in found.estimates] == [M, B]
    assert [x.value for x in found.estimates] == pytest.approx([0.1, 1.0], rel=1e-5)
    assert found.fitted == pytest.approx(limits(DISPLAY), rel=1e-6)
    assert found.settled
    assert not found.certified
    assert found.error < 1e-6


def test_the_intervals_hold_the_device_about_as_often_as_they_say() -> None:
    random, true = np.random.default_rng(5), limits(DISPLAY)
    held = 0
    for _ in range(6):
        walls = list(zip(true * np.exp(0.05 * random.normal(size=len(true))), DAMPINGS, strict=True))
        [x] = hs.fit_zwidth(DISPLAY, walls, [B]).estimates
        held += x.low <= 1.0 <= x.high
    assert held >= 4  # 95 % are promised, of many walls; resampled sets of six are a little narrow


def test_what_the_walls_do_not_tell_apart_is_said() -> None:
    """At no damping the limit is about 2 b/T: the mass is in none of it, and b and T only in their quotient."""
    walls = [(1950, 0), (2050, 0), (2000, 0)]
    clock = "effects.sampled-loop.T"
    found = hs.fit_zwidth(DISPLAY, walls, [B, clock])
    assert set(found.together) == {B, clock}
    assert not found.settled
    assert " ".join(str(found).split()).count("separately: fix one") == 1
    assert hs.fit_zwidth(OFF, walls, [M, B]).together == (M,)
    assert hs.fit_zwidth(OFF, walls, [B]).settled


def test_walls_are_read_from_two_columns_in_either_order(tmp_path: Path) -> None:
    path = tmp_path / "walls.csv"
    path.write_text("B [N s/m],K [N/m]\n0,1950\n1,4100\n", encoding="utf-8")
    assert read_walls(path) == [(1950.0, 0.0), (4100.0, 1.0)]
    found = hs.fit_zwidth(OFF.with_values({M: ["0.05 kg", "0.3 kg"]}), path)
    assert [x.path for x in found.estimates] == [M]  # what has a range is free
    path.write_text("K,B\n1950\n", encoding="utf-8")
    assert "two numbers" in refusal(read_walls, path)
    path.write_text("x,y\n1,2\n", encoding="utf-8")
    assert "must name two columns" in refusal(read_walls, path)


def test_what_cannot_be_fitted_is_refused_in_a_sentence() -> None:
    walls = [(1950.0, 0.0)]
    assert "nothing is free" in refusal(hs.fit_zwidth, DISPLAY, walls)
    assert "1 walls for 2" in refusal(hs.fit_zwidth, DISPLAY, walls, [M, B])
    assert "K must be > 0" in refusal(hs.fit_zwidth, DISPLAY, [(-1.0, 0.0)], [M])
    assert "give a sampled scene" in refusal(hs.fit_zwidth, "fu2019", walls, ["environment.m"])
    assert "not the wall" in refusal(hs.fit_zwidth, DISPLAY, walls, ["environment.b"])
