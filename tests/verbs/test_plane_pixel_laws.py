"""The plane of a hand: pixels that a line crosses, how far it is followed, and the numbers of roots on both sides of it."""

from __future__ import annotations

import random
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

import haptisym as hs
from haptisym.verbs.stability import plane

E, F = hs.environments, hs.effects


@pytest.mark.parametrize("seed", range(8))
def test_the_pixels_that_a_broken_line_crosses_part_the_others_and_no_other_does(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each sample of the line that is in the window lies in a pixel of number 0, and each of these is beside the line."""
    draw, size = random.Random(seed), 40
    monkeypatch.setattr(plane, "_PIXELS", size)
    low, least = draw.choice([-7.0, 3.0]), draw.choice([-2.0, 5.0])
    wide, tall = draw.choice([4.0, 10.0]), draw.choice([3.0, 8.0])
    window = (low, low + wide, least, least + tall)
    for _ in range(3):
        k = low + wide * np.array([draw.uniform(-0.4, 1.4) for _ in range(5)])
        b = least + tall * np.array([draw.uniform(-0.4, 1.4) for _ in range(5)])
        at_0 = draw.choice([None, low + wide * draw.uniform(0.1, 0.9), low - 1, low + wide + 1])
        labels = plane._labels(k, b, at_0, window)
        t = np.linspace(0, 1, 3000)
        x = np.concatenate([a + (c - a) * t for a, c in pairwise(k)])
        y = np.concatenate([a + (c - a) * t for a, c in pairwise(b)])
        i, j = np.floor((x - low) / wide * size).astype(int), np.floor((y - least) / tall * size).astype(int)
        inside = (i >= 0) & (i < size) & (j >= 0) & (j < size)
        crossed = np.zeros((size, size), bool)
        crossed[i[inside], j[inside]] = True
        closed = labels == 0
        if at_0 is not None and low < at_0 < low + wide:
            column = int((at_0 - low) / wide * size)
            assert closed[column].all()
            closed[column] = crossed[column]
        beside = np.zeros((size + 2, size + 2), bool)  # with a rim around the window
        i, j = i.clip(-2, size + 1) + 1, j.clip(-2, size + 1) + 1
        known = (i >= 0) & (i < size + 2) & (j >= 0) & (j < size + 2)
        beside[i[known], j[known]] = True
        assert not (closed & ~ndimage.binary_dilation(beside, np.ones((3, 3)))[1:-1, 1:-1]).any()
        missed = crossed & ~closed
        assert (
            missed.sum() <= 0.35 * crossed.sum()
        )  # corners of pixels, which a line crosses for less than half a pixel
        assert not (missed & ~ndimage.binary_dilation(closed, np.ones((3, 3)))).any()
        assert labels.max() == ndimage.label(labels > 0)[1]


@pytest.mark.parametrize("side", range(4))
@pytest.mark.parametrize("window", [(-3.0, 8.0, -5.0, 9.0), (2.0, 50.0, 4.0, 7.0)])
def test_a_line_is_followed_a_fifth_beyond_the_last_frequency_at_which_it_is_in_the_window(
    side: int, window: Any
) -> None:
    """From the middle on it goes out by one of four sides, at 100 rad/s."""
    low, high, least, most = window
    middle = ((low + high) / 2, (least + most) / 2)
    end = window[side]

    def at(w: Any) -> Any:
        moved = middle[side // 2] + (end - middle[side // 2]) * w / 100
        still = middle[1 - side // 2] + 0 * w
        return (moved, still) if side < 2 else (still, moved)

    assert plane._end(at, window, []) == pytest.approx(120, rel=2e-3)
    assert plane._end(at, window, [0.01, 0.5]) == pytest.approx(120, rel=2e-3)  # 24 pi/0.5 is more
    assert plane._end(at, window, [0.01, 1.0, 0.3]) == pytest.approx(24 * np.pi)
    touching = plane._end(
        lambda w: (end + 0 * w, middle[1] + 0 * w) if side < 2 else (middle[0] + 0 * w, end + 0 * w), window, []
    )
    assert touching == 100


@pytest.mark.parametrize("tau", [0.05])
def test_the_line_is_where_mass_damping_and_stiffness_make_up_for_the_display(tau: float) -> None:
    """(200 + 3 s) exp(-s tau), held by 0.5 kg."""
    effects = (F.delay(f"{tau} s"),) if tau else ()
    scene = hs.Scene(E.kelvin_voigt(200, 3), effects)
    window = (-600.0, 900.0, -30.0, 40.0)
    found = plane.boundary(scene, hs.Hand("any", m="0.5 kg", b=1, k=1), window)
    assert (found.mass, found.at_0, found.window, found.cells) == (0.5, -200.0, window, ())
    spring = E.expression("k + c/s**2", parameters={"k": 2, "c": 3})
    assert plane.boundary(hs.Scene(spring, ()), hs.Hand("any", m=1), window).at_0 is None
    w = (found.k * 0).astype(complex)
    end = plane._end(
        lambda x: (
            0.5 * x**2 - ((200 + 3j * x) * np.exp(-1j * x * tau)).real,
            -((200 + 3j * x) * np.exp(-1j * x * tau)).imag / x,
        ),
        window,
        [tau] if tau else [],
    )
    w = np.unique(np.concatenate([np.geomspace(1e-5 * end, end, 4000), np.linspace(1e-5 * end, end, 4000)]))
    H = (200 + 3j * w) * np.exp(-1j * w * tau)
    assert found.k == pytest.approx(0.5 * w**2 - H.real, rel=1e-9, abs=1e-9)
    assert found.b == pytest.approx(-H.imag / w, rel=1e-9, abs=1e-9)


def test_the_count_of_a_cell_is_that_of_a_hand_with_three_digits() -> None:
    scene = hs.Scene(E.mass_spring_damper(m="0.2 kg", b=2, k=30), (F.first_order_lag(20),))
    hand = hs.Hand("any", m="0.4 kg")
    for k, b in ((12.3456, 4.5678), (300.49, 0.012345), (-45.0, 3.0), (900.0, -1.5), (0.0, -9.0)):
        near_k, near_b = float(f"{k:.3g}"), float(f"{b:.3g}")
        row = np.polyadd(np.polymul([1, 20], [0.4, near_b, near_k]), 20 * np.array([0.2, 2, 30]))
        found = plane._roots(scene, hand, k, b)
        assert found is not None
        assert found.number == int((np.roots(row).real > 0).sum())
    rough = hs.Scene(E.kelvin_voigt(20, 1), (F.coulomb_friction("0.2 N", "5 mm"),))
    assert plane._roots(rough, hand, 20.0, 3.0) is None
