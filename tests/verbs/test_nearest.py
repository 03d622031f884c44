"""Where no value of a parameter will do: the one that is said to come nearest, and what is said to be proven, on dense grids."""

from __future__ import annotations

import numpy as np
import pytest

import haptisym as hs
from haptisym.model.jnd import Part
from haptisym.verbs.require.entry import require
from haptisym.verbs.require.feasible import Kind


def _times(scene: hs.Scene) -> float:
    """By how much the worse ratio exceeds its threshold on a dense grid."""
    low, high = (float(x) for x in scene.band)
    f = scene.distortion().compile()(np.linspace(low, high, 2001)[1:])
    real, imag = (float(scene.threshold[part]) for part in Part)
    return float(max(np.max(f.ratio_real) / real, np.max(f.ratio_imag) / imag))


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


@pytest.mark.slow
def test_where_nothing_is_proven_of_other_values_that_is_said() -> None:
    """The ratio at 0 rad/s is 10/12 whatever the delay; with arbitrarily long delays balls cannot tell how much more it is."""
    found = require(hs.load_scene("position-force-teleoperation"), "tau")
    x = found.nearest
    assert x is not None
    assert float(x.ratio) == pytest.approx(10 / 12)
    assert x.at_least <= x.times
    if x.at_least == 1:
        assert "How near other values come was not proven." in " ".join(str(found).split())


def test_where_some_values_do_none_is_nearest() -> None:
    found = require(hs.load_scene("fu2019"), "omega_n")
    assert found.nearest is None
    assert "nearest" not in found.to_dict()
