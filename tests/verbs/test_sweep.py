"""Sweeps: every number against an evaluation, every engine against every other, and nothing lost when a sweep is killed."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import warnings
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
import xarray as xr
from hypothesis import given as drawn
from hypothesis import strategies as st
from strategies import Seeded, case, scene
from sympy import Expr, Integer, Rational, Symbol, pi

import haptisym as hs
from haptisym.cli import main
from haptisym.verbs.sweep import blocks, combined, kernel, passes, store
from haptisym.verbs.sweep.axes import axes, spaced
from haptisym.verbs.sweep.blocks import Pace, SweepGrid
from haptisym.verbs.sweep.exactly import exact_answers
from haptisym.verbs.sweep.kernel import Kernel
from haptisym.verbs.sweep.passes import TOLERANCE
from haptisym.verbs.sweep.swept import Swept
from haptisym.verbs.sweep.told import Told

PAPER = hs.load_scene("fu2019")
NATURAL, MASS = "effects.filter.omega_n", "environment.m"
TOLD = Told.of(PAPER)
SMALL = {NATURAL: np.linspace(25.0, 200.0, 30).tolist(), MASS: np.linspace(0.3, 5.0, 21).tolist()}


@pytest.fixture(scope="module")
def small() -> Any:
    return hs.sweep(PAPER, SMALL)


def exactly(x: float) -> Rational:
    return Rational(*Fraction(x).as_integer_ratio())


def evaluated(swept: hs.Scene) -> dict[str, float]:
    """The variables of a sweep, read off an evaluation."""
    e = hs.evaluate(swept)
    low, high = map(float, swept.band)
    row: dict[str, float] = {
        "bandwidth": np.nan if e.bandwidth is None else float(e.bandwidth),
        "transparent": sum(float(x.high.omega) - float(x.low.omega) for x in e.transparent) / (high - low),
    }
    for part in hs.Part:
        own = [float(c.omega) for c in e.crossings if c.part is part]
        row[f"crossings_{part.value}"], row[f"first_crossing_{part.value}"] = len(own), min(own, default=np.nan)
    for name, points in (("environment", e.changeovers_environment), ("perceived", e.changeovers_perceived)):
        row[f"changeovers_{name}"] = len(points)
        row[f"changeover_{name}"] = float(points[0].omega) if points else np.nan
    return row


def agrees(found: Any, truth: dict[str, float]) -> None:
    for name in TOLD.counts:
        assert int(found[name]) == truth[name], name
    for name in TOLD.floats:
        # a fraction is a sum over crossings that are each that accurate
        limit = 1e-10 if name == "transparent" else 1.0001 * TOLERANCE * abs(truth[name])
        assert np.isnan(truth[name]) == np.isnan(found[name]), name
        assert np.isnan(truth[name]) or abs(float(found[name]) - truth[name]) <= limit, name


# --- what is answered ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("band", "jnd"), [(("0", "15"), "0.1"), (("2 rad/s", "5 Hz"), "0.05"), (("1 Hz", "100 Hz"), "0.2")]
)
def test_every_set_is_what_its_evaluation_says(band: tuple[str, str], jnd: str) -> None:
    given = PAPER.with_band(*band).with_values({"c": jnd})
    found = hs.sweep(given, {NATURAL: [25.0, 55.1, 91.0, 160.0], MASS: [0.3, 1.8, 4.9]})
    assert (found.method == 0).all()
    for at in np.ndindex(4, 3):
        one = found[{NATURAL: at[0], MASS: at[1]}]
        values = {"omega_n": exactly(float(one[NATURAL])), "m": exactly(float(one[MASS]))}
        agrees(one, evaluated(given.with_values(values)))


@pytest.mark.parametrize("path", ["evaluation.jnd", "effects.filter.zeta"])
def test_values_without_a_unit_are_told_without_a_space_for_it(path: str) -> None:
    found = Swept(hs.load_scene("fu2019"), hs.sweep("fu2019", {path: [0.5, 0.7, 0.9]}))
    assert "0.5 to 0.9, 3 values" in str(found)


def test_thresholds_are_swept_together_or_apart() -> None:
    together = hs.sweep(PAPER, {"evaluation.jnd": [0.05, 0.125]})
    apart = hs.sweep(PAPER, {"evaluation.jnd.real": [0.05, 0.125], "evaluation.jnd.imag": [0.05, 0.125]})
    for i, c in enumerate((0.05, 0.125)):
        agrees(together[{"evaluation.jnd": i}], evaluated(PAPER.with_values({"c": exactly(c)})))
        diagonal = apart[{"evaluation.jnd.real": i, "evaluation.jnd.imag": i}]
        assert all(float(diagonal[name]) == float(together[name][i]) for name in TOLD.counts)


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(8))
def test_random_scenes_agree_with_the_exact_answers(seed: int) -> None:
    pick = Seeded(1000 + seed)
    given = scene(case(pick, order=5))
    names = [p.path for p in given.parameters if p.value.is_Rational and p.value > 0][:2]
    known = given.knobs
    ranges = {path: float(known[path].value) * np.geomspace(0.2, 5.0, 9) for path in names}
    checked = axes(given, ranges)
    kernel = Kernel.of(given, [axis.knob for axis in checked])
    mesh = np.stack([x.ravel() for x in np.meshgrid(*ranges.values(), indexing="ij")])
    columns = kernel.answers(mesh)
    assert kernel.is_polynomial
    assert (columns["method"] == 0).mean() > 0.5
    for i in (columns["method"] == 0).nonzero()[0][:: max(1, mesh.shape[1] // 12)]:
        truth = exact_answers(given, kernel.swept, mesh[:, i].tolist())
        agrees({name: column[i] for name, column in columns.items()}, truth)


@pytest.mark.parametrize("band", [(0, 15), (1, 9)])
def test_what_is_noticed_from_the_beginning_has_no_bandwidth_by_either_way(band: tuple[int, int]) -> None:
    """(s + a)/(s + 1): of a far from 1 noticed at low frequencies alone; a number of the scene decides how far up."""
    gain = hs.effects.series("(s + a)/(s + 1)*(1 + s/d)", parameters={"a": "1/2", "d": "90"})
    given = hs.Scene(hs.environments.kelvin_voigt(100, 3), (gain,), band)
    [knob] = [x.path for x in given.knobs if x.path.endswith(".a")]
    values = [0.25, 0.5, 0.9375, 1.25, 2.0, 8.0]
    grid = SweepGrid.of(given, axes(given, {knob: values}))
    floats, left = grid.kernel.in_floats(np.array([values]))
    assert not len(left)
    bandwidths = []
    for i, value in enumerate(values):
        truth = evaluated(given.with_values({knob: exactly(value)}))
        agrees({name: x[i] for name, x in floats.items()}, truth)
        agrees(exact_answers(given, grid.kernel.swept, [value]), truth)
        bandwidths.append((truth["bandwidth"], truth["transparent"]))
    assert any(np.isnan(x) and y > 0.1 for x, y in bandwidths)
    assert any(x > 0 for x, _ in bandwidths)


@pytest.mark.slow
def test_hard_parameters_are_never_counted_wrong() -> None:
    rng = np.random.default_rng(3)
    spans = {MASS: (1e-3, 1e3), "environment.b": (1e-6, 1e3), NATURAL: (1.0, 1e4), "effects.filter.zeta": (1e-3, 1.0)}
    checked = axes(PAPER, {path: list(span) for path, span in spans.items()})
    kernel = Kernel.of(PAPER.with_band(0, 300), [axis.knob for axis in checked])
    sets = np.exp([rng.uniform(*np.log(span), 120) for span in spans.values()])
    columns = kernel.answers(sets)
    in_floats = (columns["method"] == 0).nonzero()[0]
    assert len(in_floats) > 60
    for i in in_floats:
        agrees({n: x[i] for n, x in columns.items()}, exact_answers(kernel.scene, kernel.swept, sets[:, i].tolist()))


def test_values_are_the_binary_numbers_that_they_are() -> None:
    """With r = c exactly at the band's end for the decimal 0.1, the double next to it decides."""
    lag = hs.effects.series("g", parameters={"g": "9/10"})
    flat = hs.Scene(hs.environments.mass_spring_damper(k=100), (lag,), (0, 10), "0.1")
    found = hs.sweep(flat, {"effects.series.g": [0.9]})
    assert float(found.transparent[0]) == float(Fraction(0.9) >= Fraction(9, 10))


def test_a_touch_is_left_to_the_exact_path_and_counted_once() -> None:
    """r_i = omega/(omega^2 + 1) has its largest value 1/2 at 1 rad/s; 1/2 is a double."""
    given = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(1),), (0, 10), "1/2")
    found = hs.sweep(given, {"effects.first-order-lag.omega_c": [1.0, 2.0]})
    assert found.method.values.tolist() == [1, 1]
    assert found.crossings_imag.values.tolist() == [1, 1]
    assert found.first_crossing_imag.values.tolist() == [1.0, 2.0]


def test_where_the_environment_vanishes_the_exact_path_answers() -> None:
    """An undamped environment is zero at its resonance, where a shunt's ratio is unbounded."""
    given = hs.Scene(hs.environments.mass_spring_damper(m=1, b=0, k=100), (hs.effects.shunt(b=1),), (0, 20), "0.1")
    found = hs.sweep(given, {"environment.b": [0.0, 1.0]})
    assert found.method.values.tolist() == [1, 0]
    agrees(found[{"environment.b": 0}], evaluated(given))


def test_a_scene_with_a_delay_is_answered_in_floats_too() -> None:
    given = hs.load_scene("delayed-spring")
    [path] = [p.path for p in given.parameters if p.key == "tau"]
    found = hs.sweep(given, {path: ["10 ms", "20 ms"]})
    assert (found.method == 0).all()
    assert "sines" in found.attrs["floats"]
    agrees(found[{path: 1}], evaluated(given.with_values({"tau": exactly(float(found[path][1]))})))


def test_a_set_without_dynamics_says_so_and_stops_nothing() -> None:
    given = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(20),))
    found = hs.sweep(given, {"environment.k": [0.0, 100.0]})
    assert found.method.values.tolist() == [2, 0]
    assert found.crossings_real.values.tolist() == [-1, 1]
    assert np.isnan(found.bandwidth[0])


@pytest.mark.parametrize("jnd", [0.1, {"shape": "diamond", "real": 0.1, "imag": 0.1}])
def test_a_damper_of_no_damping_is_no_dynamics_though_its_number_cancels_in_the_ratios(jnd: Any) -> None:
    """Behind a gain all real parts are 0 whatever the damping, so that no changeover tells that nothing is left."""
    gain = hs.effects.series("g", parameters={"g": 1})
    given = hs.Scene(hs.environments.mass_spring_damper(b=3), (gain,), threshold=jnd)
    found = hs.sweep(given, {"environment.b": [0.0, 2.0]})
    assert found.method.values.tolist() == [2, 0]
    assert found.changeovers_environment.values.tolist() == [-1, 0]


def test_numbers_far_beyond_any_device_are_not_trusted_to_floats() -> None:
    kernel = Kernel.of(PAPER, [axis.knob for axis in axes(PAPER, {MASS: [1.0]})])
    assert kernel.answers(np.array([[1e-200, 1.0]]))["method"].tolist() == [1, 0]


def test_effects_that_cancel_are_transparent_in_every_set() -> None:
    damper = hs.environments.mass_spring_damper(b=3)
    found = hs.sweep(hs.Scene(damper, (hs.effects.series("(1+5*s)/(1+5*s)"),)), {"environment.b": [1.0, 2.0, 3.0]})
    assert found.bandwidth.values.tolist() == [15.0] * 3
    assert found.crossings_real.values.tolist() == found.crossings_imag.values.tolist() == [0] * 3


def test_units_are_read() -> None:
    found = hs.sweep(PAPER, {NATURAL: ["10 Hz", 80]})
    assert found[NATURAL].values.tolist() == [20 * np.pi, 80.0]
    assert found[NATURAL].attrs["units"] == "rad/s"
    assert spaced(f"{NATURAL}=40 rad/s:160:3:log", PAPER)[1] == pytest.approx([40, 80, 160], rel=1e-15)


# --- several crossings, blocks, bands --------------------------------------------------------------------------------

RIPPLES = hs.effects.series("1 + 0.4*s/(s^2 + 0.2*s + 4) - 0.3*s/(s^2 + 0.3*s + 25) + 0.5*s/(s^2 + 0.5*s + 64)")
RIPPLED = hs.Scene(hs.environments.mass_spring_damper(m=1, b=2, k=90), (RIPPLES,), (0, 12))
LIMITS = [0.07, 3.0, 0.02, 0.61, 0.4, 0.11, 1.2]
"""The first set crosses many times, the next never."""


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("band", "pieces"),
    [
        (("0", "12"), 1), (("0", "12"), 3), (("0", "12"), 10_000),
        (("1.9 rad/s", "8.1 rad/s"), 100), (("1/3 Hz", "5/3 Hz"), 2), (("5.1", "5.3"), 100),
    ],
)  # fmt: skip
def test_sets_that_cross_several_times_are_all_there_whatever_stands_beside_them(
    band: tuple[str, str], pieces: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel, "_AT_ONCE", pieces)
    given = RIPPLED.with_band(*band)
    swept = [axis.knob for axis in axes(given, {"evaluation.jnd": LIMITS})]
    columns = Kernel.of(given, swept).answers(np.array([LIMITS]))
    assert (columns["method"] == 0).sum() >= len(LIMITS) - 1
    truths = [ripples(band, c) for c in LIMITS]
    for i, truth in enumerate(truths):
        agrees({name: column[i] for name, column in columns.items()}, truth)
    if band == ("0", "12"):
        assert truths[0]["crossings_real"] > 3
        assert truths[0]["crossings_imag"] > 3
        assert truths[1]["crossings_real"] == 0


@cache
def ripples(band: tuple[str, str], c: float) -> dict[str, float]:
    return evaluated(RIPPLED.with_band(*band).with_values({"c": exactly(c)}))


@pytest.mark.parametrize("seed", range(4))
def test_the_transparent_part_of_random_crossings_is_where_both_parts_are_below(seed: int) -> None:
    """Any number of crossings of two parts in each set, against a fine grid."""
    rng = np.random.default_rng(seed)
    low, count, grid = 0.2 * seed, 25, np.linspace(0.2 * seed, 1, 20_001)
    middle = (grid[1:] + grid[:-1]) / 2
    parts, columns, clear = [], {}, np.ones((count, middle.size), dtype=bool)
    for name in ("real", "imag"):
        counts = rng.integers(0, 5 if seed else 2, count)
        counts[0] = 4 if seed else 1
        omega = [np.sort(rng.choice(grid[1:-1], n, replace=False)) for n in counts]
        first = rng.choice([-1, 1], count)
        for i, x in enumerate(omega):
            clear[i] &= first[i] * (-1) ** np.searchsorted(x, middle) < 0
        parts.append(combined.Found(np.repeat(np.arange(count), counts), np.concatenate(omega), first))
        columns[f"crossings_{name}"] = counts
        columns[f"first_crossing_{name}"] = np.array([x[0] * 7 if len(x) else np.nan for x in omega])
    a_pass = passes.Pass.__new__(passes.Pass)
    a_pass.band, a_pass.sets = passes.Band(7.0, low, (low**2,), doubtful=False), count
    found = a_pass._transparency(dict(zip(("real", "imag"), parts, strict=True)), columns)
    assert found["transparent"] == pytest.approx(clear.mean(axis=1), abs=1e-9)
    for i in range(count):
        start = columns["first_crossing_real"][i], columns["first_crossing_imag"][i], 7.0
        expected = min(x for x in start if not np.isnan(x)) if clear[i, 0] else np.nan
        assert found["bandwidth"][i] == pytest.approx(expected, nan_ok=True)


@drawn(
    st.fractions(0, 1, max_denominator=10**6).filter(lambda x: x < 1),
    st.fractions("1/9", 9),
    st.sampled_from([1, 2]),
    st.sampled_from([Integer(1), pi]),
)
def test_the_band_s_low_end_lies_between_neighbouring_doubles(
    share: Fraction, high: Fraction, step: int, unit: Expr
) -> None:
    low, high = (Rational(x.numerator, x.denominator) * unit for x in (share * high, high))
    band = passes.Band.of(low, high, step)
    exact = share**step
    first, last = map(Fraction, (band.ends[0], band.ends[-1]))
    assert first <= exact <= last
    assert band.doubtful == (first < last)
    assert len(band.ends) == 1 + band.doubtful
    if band.doubtful:
        assert last == Fraction(float(np.nextafter(float(first), 2)))
    assert band.low_fraction == float(share)
    assert band.high == pytest.approx(float(high), rel=1e-15)
    for segments in (1, 4, 9):
        edges = band.edges(segments, step)
        assert edges[0] == band.ends[0]
        assert edges[-1] == 1.0
        assert all(a < b for a, b in pairwise(edges))
        assert len(edges) <= segments + len(band.ends)
        if float(share) < 0.9:
            in_frequency = np.diff(np.array(edges[len(band.ends) - 1 :]) ** (1 / step))
            assert in_frequency == pytest.approx((1 - float(share)) / segments)


def test_the_low_end_of_a_band_in_pi_beside_rational_numbers_is_enclosed() -> None:
    band = passes.Band.of(pi / 7, Integer(1), 1)
    low, high = band.ends
    with mpmath.workdps(50):
        assert mpmath.mpf(low) < mpmath.pi / 7 < mpmath.mpf(high)
    assert np.nextafter(low, 1) == high
    assert band.doubtful


def test_curves_of_too_high_a_degree_are_left_to_the_exact_path(monkeypatch: pytest.MonkeyPatch) -> None:
    swept = [axis.knob for axis in axes(PAPER, {MASS: [1.0]})]
    curves = Kernel.of(PAPER, swept).curves
    assert curves is not None
    degrees = [sum(f.degree for f in families) for families in curves.products]
    assert min(degrees) < max(degrees)
    monkeypatch.setattr(kernel, "MOST_DEGREE", max(degrees))
    assert Kernel.of(PAPER, swept).is_polynomial
    monkeypatch.setattr(kernel, "MOST_DEGREE", max(degrees) - 1)
    assert not Kernel.of(PAPER, swept).is_polynomial
    [method] = Kernel.of(PAPER, swept).answers(np.array([[1.0]]))["method"]
    assert method == 1


@pytest.mark.skipif(not kernel._IS_WIDER, reason="no wider floats on this machine")
def test_wider_floats_prove_what_doubles_leave_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """A damping of 1e-7: two crossings so close beside the resonance that doubles cannot tell them apart."""
    given = PAPER.with_values({"c": "0.05"})
    swept = [axis.knob for axis in axes(given, {"environment.b": [1.0]})]
    found = Kernel.of(given, swept)
    values = np.geomspace(1e-5, 1e-2, 40)[None]
    wide, left = found.in_floats(values)
    monkeypatch.setattr(kernel, "_IS_WIDER", False)
    _, more = found.in_floats(values)
    assert len(left) < len(more)
    for i in sorted(set(more) - set(left))[::5]:
        agrees({name: x[i] for name, x in wide.items()}, exact_answers(given, found.swept, values[:, i].tolist()))


# --- every engine gives the same -------------------------------------------------------------------------------------


@pytest.mark.parametrize("block", [1, 37, 10_000])
def test_blocks_change_nothing(small: Any, block: int) -> None:
    part = {path: values[:7] for path, values in SMALL.items()}
    assert hs.sweep(PAPER, part, block=block).equals(small.isel({path: slice(7) for path in SMALL}))


@pytest.mark.slow
def test_dask_threads_give_the_same(small: Any) -> None:
    lazy = hs.sweep(PAPER, SMALL, lazy=True, block=100)
    assert lazy.bandwidth.chunks is not None
    assert lazy.compute(scheduler="threads").identical(small)


@pytest.fixture
def cluster() -> Iterator[Any]:
    import distributed  # half a second for each process that collects tests

    quiet = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    with distributed.LocalCluster(**quiet) as found, distributed.Client(found) as client:
        yield client


@pytest.mark.slow  # starting the processes takes longer than all other tests
@pytest.mark.filterwarnings("ignore")  # of the cluster's own making
def test_two_processes_of_a_cluster_give_the_same(small: Any, cluster: Any, tmp_path: Path) -> None:
    assert hs.sweep(PAPER, SMALL, lazy=True, block=100).compute().identical(small)
    told: list[tuple[int, int]] = []
    stored = hs.sweep(PAPER, SMALL, out=tmp_path / "a.zarr", block=100, progress=lambda *x: told.append(x))
    assert stored.load().identical(small)
    assert told[-1] == (630, 630)


# --- files -----------------------------------------------------------------------------------------------------------


FEW = {NATURAL: [40.0, 80.0, 120.0], MASS: [0.5, 1.0, 2.0, 4.0]}


@pytest.fixture(scope="module")
def few() -> Any:
    return hs.sweep(PAPER, FEW)


class Engine:
    """A scheduler that does one thing after the other, on a clock that stands still, with so many workers."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, workers: int, patience: float) -> None:
        monkeypatch.setattr(blocks, "monotonic", lambda: 0.0)
        monkeypatch.setattr(store, "PATIENCE", patience)
        self.given = {"scheduler": "synchronous", "num_workers": workers}
        self.told: list[tuple[int, int]] = []

    def swept(self, out: Path, **named: Any) -> Any:
        import dask

        self.told.clear()
        with dask.config.set(self.given):
            return hs.sweep(PAPER, FEW, out=out, block=4, progress=lambda *x: self.told.append(x), **named)

    @property
    def done(self) -> list[int]:
        assert {sets for _, sets in self.told} == {12}
        return [done for done, _ in self.told]


@pytest.mark.parametrize(
    ("workers", "patience", "done"),
    [(2, 0.0, [0, 2, 4, 8, 12]), pytest.param(0, 1e9, [0, 12], marks=pytest.mark.slow)],
)
def test_a_store_is_filled_block_by_block_and_a_block_that_takes_long_is_handed_back(
    few: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int, patience: float, done: list[int]
) -> None:
    """A set at first, then eight times as many: of a block of four the others in a row."""
    (tmp_path / "a.zarr.new" / "left").mkdir(parents=True)
    engine = Engine(monkeypatch, workers, patience)
    found = engine.swept(tmp_path / "a.zarr")
    assert engine.done == done
    assert [x.name for x in tmp_path.iterdir()] == ["a.zarr"]
    assert found.bandwidth.chunks == ((1, 1, 1), (4,))
    assert found.load().identical(few)


def test_what_is_there_is_not_computed_again_and_what_is_missing_is(
    few: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import zarr

    engine = Engine(monkeypatch, 1, 1e9)
    engine.swept(tmp_path / "a.zarr")
    group = zarr.open_group(tmp_path / "a.zarr", mode="r+")
    assert (group["method"].fill_value, group["crossings_real"].fill_value) == (-1, -1)
    assert np.isnan(group["bandwidth"].fill_value)
    assert list(group["bandwidth"].chunks) == [1, 4]
    group["bandwidth"][:] = np.full((3, 4), 77.0)
    group["method"][1, 1:3] = -1
    group["method"][2, 3] = -1
    found = engine.swept(tmp_path / "a.zarr").load()
    assert engine.done == [9, 11, 12]
    fresh = np.zeros((3, 4), bool)
    fresh[1, 1:3] = fresh[2, 3] = True
    assert (np.where(fresh, few.bandwidth, 77.0) == found.bandwidth).all()
    assert found.method.equals(few.method)
    assert found.crossings_real.equals(few.crossings_real)


def test_what_is_no_store_of_this_sweep_is_told(tmp_path: Path) -> None:
    (tmp_path / "empty.zarr").mkdir()
    (tmp_path / "text.zarr").write_text("x")
    (tmp_path / "text.nc").write_text("x")
    for name, words in (
        ("empty.zarr", "is there, but is not a Zarr store"), ("text.zarr", "is there, but is not a Zarr store"), ("text.nc", "is there, but is not a NetCDF file"),
        ("a.csv", "the name must end in .zarr"), ("a", "the name must end in .zarr"),
    ):  # fmt: skip
        with pytest.raises(hs.SceneError, match=words):
            hs.sweep(PAPER, FEW, out=tmp_path / name)


@pytest.mark.slow
def test_a_netcdf_file_is_made_of_a_store_and_read_again(
    few: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = Engine(monkeypatch, 1, 1e9)
    with engine.swept(tmp_path / "a.nc") as found:
        assert found.bandwidth.chunks == ((1, 1, 1), (4,))
        assert found.load().identical(few)
        encoding = found.bandwidth.encoding
    assert engine.done == [0, 4, 8, 12]
    assert (encoding["chunksizes"], encoding["zlib"]) == ((1, 4), True)
    assert [x.name for x in tmp_path.iterdir()] == ["a.nc"]
    with engine.swept(tmp_path / "a.nc") as again:
        assert again.load().identical(few)
    assert engine.told == []
    with pytest.raises(hs.SceneError, match="holds another sweep"):
        hs.sweep(PAPER, {MASS: [1.0, 2.0]}, out=tmp_path / "a.nc")


def test_lazily_blocks_are_computed_when_they_are_asked_for(few: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    counted: list[int] = []
    own = Kernel.answers
    monkeypatch.setattr(Kernel, "answers", lambda self, x: counted.append(x.shape[1]) or own(self, x))
    found = hs.sweep(PAPER, FEW, lazy=True, block=4)
    assert found.bandwidth.chunks == ((1, 1, 1), (4,))
    counted.clear()  # dask looks at an empty one
    assert found.compute(scheduler="synchronous").identical(few)
    assert counted == [4, 4, 4]


class Cluster:
    """What a sweep asks of a dask client, done at once; of what is added, the last first."""

    def __init__(self) -> None:
        self.asked: list[tuple[Any, ...]] = []
        self.waiting: list[tuple[Any, Any]] = []

    def scatter(self, grid: Any, *, broadcast: bool, hash: bool) -> Any:  # noqa: A002
        assert (broadcast, hash) == (True, False)
        return grid

    def submit(self, function: Any, *given: Any, pure: bool) -> Any:
        assert not pure
        self.asked.append(given[2:])
        return SimpleNamespace(key=str(len(self.asked)), run=lambda: function(*given))

    def as_completed(self, futures: list[Any], *, with_results: bool) -> Any:
        assert with_results
        self.waiting = futures
        return self

    def add(self, future: Any) -> None:
        self.waiting.append(future)

    def __iter__(self) -> Iterator[tuple[Any, Any]]:
        while self.waiting:
            future = self.waiting.pop()
            yield future, future.run()


def test_a_cluster_gets_a_block_again_until_it_is_done(
    few: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine, cluster = Engine(monkeypatch, 1, 0.0), Cluster()
    there = SimpleNamespace(default_client=lambda: cluster, as_completed=cluster.as_completed)
    monkeypatch.setitem(sys.modules, "distributed", there)
    assert engine.swept(tmp_path / "a.zarr").load().identical(few)
    regions = [(slice(i, i + 1), slice(0, 4)) for i in range(3)]
    assert cluster.asked[:3] == [(x, 1) for x in regions]
    assert cluster.asked[3:] == [(x, sets) for x in regions[::-1] for sets in (8, 64)]
    assert engine.done == [0, 1, 2, 4, 5, 6, 8, 9, 10, 12]

    def none() -> Any:
        raise ValueError

    there.default_client = none
    assert store._client() is None


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a.zarr", "a.nc"])
def test_a_file_holds_the_same(small: Any, tmp_path: Path, name: str) -> None:
    with hs.sweep(PAPER, SMALL, out=tmp_path / name, block=100) as stored:
        assert stored.load().identical(small)
    with hs.sweep(PAPER, SMALL, out=tmp_path / name) as again:
        assert again.load().identical(small)
    assert [x.name for x in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("seed", range(6))
def test_boxes_of_what_is_missing_are_those_sets_each_once(seed: int) -> None:
    """Of blocks that begin anywhere, with nothing, all, or any sets missing: of all of it there is one box."""
    pick = random.Random(seed)
    for _ in range(30):
        lengths = [pick.choice([1, 1, 2, 3, 5, 8]) for _ in range(pick.randint(1, 3))]
        starts = [pick.choice([0, 3, 10]) for _ in lengths]
        region = tuple(slice(a, a + n) for a, n in zip(starts, lengths, strict=True))
        share = pick.choice([0.0, 0.3, 0.9, 1.0])
        missing = np.array([pick.random() < share for _ in range(int(np.prod(lengths)))]).reshape(lengths)
        seen = np.zeros([a + n for a, n in zip(starts, lengths, strict=True)], int)
        boxes = list(store._missing(missing, region))
        for box in boxes:
            assert all(own.start <= x.start < x.stop <= own.stop for own, x in zip(region, box, strict=True))
            seen[box] += 1
        assert (seen[region] == missing).all()
        assert seen.sum() == missing.sum()
        assert not missing.all() or boxes == [region]


@pytest.mark.slow
def test_a_killed_sweep_continues_where_it_was(small: Any, tmp_path: Path) -> None:
    out = tmp_path / "killed.zarr"
    script = (
        "import sys, time, haptisym as hs, dask\n"
        "dask.config.set(scheduler='synchronous', num_workers=1)\n"
        f"vary = {SMALL!r}\n"
        "def slowly(done, sets):\n"
        "    print(done, flush=True)\n"
        "    time.sleep(0.05)\n"
        f"hs.sweep(hs.load_scene('fu2019'), vary, out={str(out)!r}, block=21, progress=slowly)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    with child, child.stdout as lines:
        for line in lines:
            if int(line) >= 150:
                os.kill(child.pid, signal.SIGKILL)
                break
    half = xr.open_zarr(out, consolidated=False)
    done = int((half.method != -1).sum())
    half.close()
    assert 150 <= done < 630
    told: list[int] = []
    found = hs.sweep(PAPER, SMALL, out=out, progress=lambda n, _: told.append(n), block=21)
    assert told[0] == done
    assert found.load().identical(small)


DELAYED = hs.load_scene("delayed-spring")
TAUS = {"effects.delay.tau": [0.001 * i for i in range(1, 25)], "environment.k": [50.0, 80.0]}


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "vary"), [(PAPER, SMALL), (DELAYED, TAUS)])
def test_blocks_are_cut_by_time_and_a_sweep_interrupted_anywhere_ends_with_the_same_bits(
    scene: hs.Scene, vary: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = hs.sweep(scene, vary)
    monkeypatch.setattr("haptisym.verbs.sweep.blocks.PATIENCE", 0.0)
    monkeypatch.setattr("haptisym.verbs.sweep.store.PATIENCE", 0.0)

    def interrupted(done: int, _sets: int) -> None:
        told.append(done)
        if len(told) % 2 == 0:
            raise KeyboardInterrupt

    out, told = tmp_path / "a.zarr", []
    for _ in range(3):
        with pytest.raises(KeyboardInterrupt):
            hs.sweep(scene, vary, out=out, progress=interrupted)
    assert told == [0, 1, 1, 2, 2, 3]  # one block of 65 536 sets would hold them all
    monkeypatch.undo()
    assert hs.sweep(scene, vary, out=out).load().identical(whole)


@drawn(st.integers(1, 60), st.lists(st.integers(1, 5), min_size=1, max_size=3))
def test_pieces_of_a_block_hold_each_set_once_however_it_is_cut(sets: int, shape: list[int]) -> None:
    grid = SweepGrid(PAPER, (), tuple(shape))
    pace = Pace(sets)
    pace.took = lambda *_: None  # type: ignore[method-assign]
    seen = np.zeros(shape, dtype=int)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "compute", lambda *_: ())
        patch.setattr(SweepGrid, "values", lambda *_: [])
        patch.setattr(SweepGrid, "kernel", None)
        for piece, _ in grid.pieces(tuple(slice(0, n) for n in shape), pace):
            assert seen[piece].size <= sets
            seen[piece] += 1
    assert (seen == 1).all()


def test_the_pace_follows_the_time_that_pieces_take() -> None:
    pace = Pace()
    for _ in range(7):
        pace.took(0.001, pace.sets)
    assert pace.sets == 8**7
    pace.took(20 * blocks.PATIENCE, pace.sets)
    assert pace.sets == 8**7 // 20
    pace.took(1e9, 1)
    assert pace.sets == 1


@pytest.mark.slow
def test_a_store_is_opened_and_told_without_a_warning(tmp_path: Path) -> None:
    hs.sweep(PAPER, {MASS: np.linspace(1, 2, 40), "evaluation.jnd": [0.9, 0.99]}, out=tmp_path / "a.zarr", block=8)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = xr.open_zarr(tmp_path / "a.zarr")
        told = Swept(PAPER, found).to_dict()
    assert np.isnan(found.first_crossing_real).all()
    assert told["ranges"]["first_crossing_real"] is None
    assert told["ranges"]["bandwidth"] == [15.0, 15.0]


def test_more_sets_than_memory_holds_are_refused_at_once_and_may_be_streamed(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    many = {MASS: np.linspace(1, 2, 100_000), "environment.k": np.linspace(1, 2, 100_000)}
    with pytest.raises(
        hs.SceneError, match=r"10,000,000,000 sets take 570 GB of memory: let them be streamed to a file"
    ):
        hs.sweep(PAPER, many)
    words = ["sweep", "fu2019", "--vary", f"{MASS}=1:2:100000", "--vary", "environment.k=1:2:100000"]
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    assert "--out FILE.zarr" in err


def test_another_sweep_is_not_mixed_in(tmp_path: Path) -> None:
    hs.sweep(PAPER, {MASS: [1.0, 2.0]}, out=tmp_path / "a.zarr")
    with pytest.raises(hs.SceneError, match="another sweep"):
        hs.sweep(PAPER, {MASS: [1.0, 3.0]}, out=tmp_path / "a.zarr")
    with pytest.raises(hs.SceneError, match="another sweep"):
        hs.sweep(PAPER.with_values({"c": "0.2"}), {MASS: [1.0, 2.0]}, out=tmp_path / "a.zarr")


HELD = PAPER.with_hands(hs.Hand("one", m=1, b=5, k=40))


@pytest.mark.parametrize(
    "vary",
    [
        {"effects.filter.zeta": [0.4, 0.6]},
        {"evaluation.jnd": [0.1, 0.2], "environment.m": [1.0, 2.0]},
        {"evaluation.jnd.imag": [0.1, 0.2]},
        {"hand.b": [4.0, 5.0]},
    ],
)
def test_a_sweep_is_another_one_if_anything_differs_but_the_own_values_of_what_is_swept(vary: dict[str, Any]) -> None:
    def mark(scene: hs.Scene, values: dict[str, Any] = vary) -> str:
        return SweepGrid.of(scene, axes(scene, values)).fingerprint

    swept = {*vary, *(["evaluation.jnd.real", "evaluation.jnd.imag"] if "evaluation.jnd" in vary else [])}
    paths = [
        *(p.path for p in HELD.parameters),
        "evaluation.jnd.real",
        "evaluation.jnd.imag",
        "hand.m",
        "hand.b",
        "hand.k",
    ]
    for path in paths:
        other = HELD.with_values({path: HELD.knobs[path].value * Fraction(6, 5)})
        assert (mark(other) == mark(HELD)) is (path in swept), path
    others = [
        HELD.with_band(1, 15), HELD.with_band(0, 14), PAPER.with_hands(hs.Hand("two", m=1, b=5, k=40)), PAPER.with_hands(hs.Hand("one", m=2, b=5, k=40)),
        hs.Scene(HELD.environment, HELD.effects * 2, HELD.band, HELD.threshold, hands=HELD.hands),
        hs.Scene(HELD.environment, HELD.effects, HELD.band, HELD.threshold, HELD.environment, hands=HELD.hands),
    ]  # fmt: skip
    marks = [mark(x) for x in (HELD, *others)]
    further = {path: [*x, 3.0] for path, x in vary.items()}
    backward = dict(reversed(vary.items())) if len(vary) > 1 else {path: x[:1] for path, x in vary.items()}
    marks += [mark(HELD, further), mark(HELD, backward)]
    assert len(set(marks)) == len(marks)


# --- what is refused -------------------------------------------------------------------------------------------------


def test_what_is_left_open_beside_what_is_swept_needs_a_number() -> None:
    free = PAPER.with_values({MASS: Symbol("m", positive=True), NATURAL: Symbol("w", positive=True)})
    with pytest.raises(hs.SceneError, match="environment.m = m is a symbol where a number is needed"):
        hs.sweep(free, {NATURAL: [40.0]})


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({}, "needs something to vary"),
        (
            {"effects.filter.omega": [1.0]},
            'has no parameter "effects.filter.omega": did you mean "effects.filter.omega_n"',
        ),
        ([MASS], "give values by path"),
        ({MASS: []}, "no values"),
        ({MASS: [1.0, float("inf")]}, "finite"),
        ({MASS: [1.0, -0.5]}, "must be >= 0"),
        ({MASS: ["x"]}, "x"),
        ({MASS: [None]}, "is not a number, nor a string"),
        ({MASS: [1.0, 1.0]}, "only once"),
        ({MASS: [-1.0, 1.0]}, "must be >= 0"),
        ({MASS: [float("nan")]}, "finite"),
        ({MASS: ["1 N/m"]}, "not a mass"),
        ({MASS: ["1 kg*m^2"]}, "rotational"),
        ({NATURAL: [0.0]}, "must be > 0"),
        ({"evaluation.jnd": [0.1], "evaluation.jnd.real": [0.1]}, "both thresholds"),
    ],
)
def test_what_cannot_be_swept_is_told(vary: dict[str, Any], message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.sweep(PAPER, vary)


@pytest.mark.parametrize("text", ["environment.m", "environment.m=1:2", "environment.m=1:2:x", "environment.m=1:2:1",
                                  "environment.m=0:2:3:log", "environment.m=1:2:3:4"])  # fmt: skip
def test_a_span_that_is_none_is_told(text: str) -> None:
    with pytest.raises(hs.SceneError):
        spaced(text, PAPER)


def test_a_missing_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(hs.SceneError, match=r"pip install haptisym\[sweep\]"):
        hs.sweep(PAPER, {MASS: [1.0]})


@pytest.mark.slow
def test_importing_the_package_loads_neither_xarray_nor_dask() -> None:
    # Pint itself loads dask.base wherever dask is installed; it is hidden here, so that what is left is our own doing
    probe = (
        "import sys; sys.modules['dask'] = None; import haptisym; from haptisym import cli\n"
        "assert not {'xarray', 'distributed', 'zarr'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", probe], check=True)


# --- the command -----------------------------------------------------------------------------------------------------


def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["haptisym", "sweep", *words])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    return int(ended.value.code or 0), out, err


@pytest.mark.slow
def test_the_command_writes_document_store_and_chart(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    vary = ["--vary", f"{NATURAL}=40 rad/s:20 Hz:4", "--vary", f"{MASS}=0.5:2:3:log"]
    files = ["--out", str(tmp_path / "a.zarr"), "--figure", str(tmp_path / "a.svg")]
    status, out, _ = run(monkeypatch, capsys, "fu2019", *vary, *files, "--json")
    told = json.loads(out)
    assert status == 0
    assert told["schema"] == "haptisym.sweep/1"
    assert told["sets"] == told["certified_in_floats"] == 12
    assert (tmp_path / "a.svg").read_text(encoding="utf-8").startswith("<?xml")
    stored = xr.open_zarr(tmp_path / "a.zarr", consolidated=False)
    assert told["ranges"]["bandwidth"] == [float(stored.bandwidth.min()), float(stored.bandwidth.max())]
    stored.close()


def test_the_command_tells_sets_without_answer_with_status_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "spring.toml"
    file.write_text(
        '[environment]\nmodel = "mass-spring-damper"\nk = 100\n[[effects]]\nmodel = "first-order-lag"\nomega_c = 20\n',
        encoding="utf-8",
    )
    status, out, _ = run(monkeypatch, capsys, str(file), "--vary", "environment.k=0:100:2")
    assert status == 3
    assert "NOT ANSWERED: 1 sets" in out
    assert "environment.k = 0" in out


@pytest.mark.parametrize(
    "words",
    [
        ("fu2019", "--vary", "environment.m=1:2"),
        ("fu2019", "--vary", "environment.q=1:2:3"),
        ("fu2019", "--vary", "environment.m=1:2:3", "--workers", "2"),
        ("fu2019", "--vary", "environment.m=1:2:3", "--figure", "a.gif"),
        ("fu2019", "--vary", "environment.m=1:2:3", "--out", "a.csv"),
        ("fu2019", "--vary", "environment.m=1:2:3", "--vary", "environment.m=1:2:3"),
        ("fu2019",),
    ],
)
def test_a_wrong_command_line_is_one_message_and_status_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: tuple[str, ...]
) -> None:
    status, out, err = run(monkeypatch, capsys, *words)
    assert (status, out) == (2, "")
    assert "rror" in err


def test_charts_are_drawn_on_the_axes_given(small: Any) -> None:
    from matplotlib.figure import Figure

    from haptisym.figures.sweep import draw_curves, draw_map

    ax = Figure().add_subplot()
    draw_map(ax, small)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$m$ (kg)", r"$\omega_n$ (rad/s)")
    assert ax.get_xlim() == (0.3, 5.0)
    ax = Figure().add_subplot()
    draw_curves(ax, small.isel({MASS: 3}, drop=True))
    drawn = np.asarray(ax.get_lines()[0].get_ydata())
    assert drawn[~np.isnan(drawn)].tolist() == small.bandwidth.isel({MASS: 3}).values.tolist()
    with pytest.raises(hs.SceneError, match="one or two parameters"):
        draw_map(ax, small.isel({MASS: 3}, drop=True))


@pytest.mark.slow
def test_the_bandwidth_is_drawn_in_pieces_that_end_where_crossings_come_or_go() -> None:
    """Witness: exact evaluations at both sides of each break, ever closer, and in the middle of every step that is drawn."""
    from matplotlib.figure import Figure

    from haptisym.figures.sweep import draw_curves

    def exact(m: float) -> tuple[float, int]:
        found = hs.evaluate(PAPER.with_values({"m": m}))
        assert found.bandwidth is not None
        return float(found.bandwidth), len(found.crossings)

    ax = Figure().add_subplot()
    [line, *_] = draw_curves(ax, hs.sweep(PAPER, {MASS: np.linspace(0.5, 5, 46)}))
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    jumps = []
    for i in np.flatnonzero(np.isnan(x)):
        low, high = float(x[i - 1]), float(x[i + 1])
        count = exact(high)[1]
        for _ in range(24):
            middle = (low + high) / 2
            low, high = (low, middle) if exact(middle)[1] == count else (middle, high)
        assert high - low < 1e-6
        assert abs(exact(low)[1] - exact(high)[1]) == 2
        jumps.append(abs(exact(low)[0] - exact(high)[0]))
        dots = [z for dot in ax.lines if dot.get_marker() == "o" for z in zip(*dot.get_data(), strict=True)]
        assert {(x[i - 1], y[i - 1]), (x[i + 1], y[i + 1])} <= set(dots)
    assert max(jumps) > 0.9  # rad/s: what a line would have hidden
    for a, b, low, high in zip(x[:-1], x[1:], y[:-1], y[1:], strict=True):
        if not np.isnan([a, b]).any():
            assert min(low, high) - 0.2 < exact(float(a + b) / 2)[0] < max(low, high) + 0.2


def test_charts_are_in_hz_where_the_scene_or_the_sweep_is() -> None:
    from matplotlib.figure import Figure

    from haptisym.figures.sweep import draw_curves

    ax = Figure().add_subplot()
    lines = draw_curves(ax, hs.sweep(hs.load_scene("sidestick"), {"environment.k": [1.0, 3.0, 9.0]}))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$k$ (N·m/rad)", "frequency (Hz)")
    exact = hs.evaluate(hs.load_scene("sidestick").with_values({"k": 3})).bandwidth
    assert exact is not None
    assert np.asarray(lines[0].get_ydata())[1] == pytest.approx(float(exact) / (2 * np.pi))
    ax = Figure().add_subplot()
    draw_curves(ax, hs.sweep(PAPER, {NATURAL: ["5 Hz", "20 Hz", "50 Hz"]}))
    assert (ax.get_xlabel(), ax.get_xlim()) == (r"$\omega_n$ (Hz)", (5, 50))
    assert ax.get_ylabel() == r"$\omega$ (rad/s)"


def test_two_sweeps_are_drawn_in_one_axes() -> None:
    from matplotlib.figure import Figure

    from haptisym.figures.sweep import draw_curves

    ax = Figure().add_subplot()
    for b in (15, 30):
        draw_curves(ax, hs.sweep(PAPER.with_values({"b": b}), {NATURAL: np.linspace(20, 200, 10)}), label=f"b = {b}")
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert len(labels) == len(set(labels))
    assert {"bandwidth, b = 15", "bandwidth, b = 30", "end of the band"} <= set(labels)
    assert sum(line.get_label() == "end of the band" for line in ax.lines) == 1


@pytest.mark.slow
def test_the_exact_boundary_divides_the_sets_of_a_sweep() -> None:
    """Two engines on one plane: critical values slice by slice, and Bernstein coefficients set by set."""
    scene = hs.load_scene("fu2019")
    exact = hs.design_map(scene, ["environment.m", "effects.filter.omega_n"], [(0.5, 5), (20, 200)], slices=7)
    masses = [float(x.at) for x in exact.slices]
    found = hs.sweep(scene, {"environment.m": masses, "effects.filter.omega_n": np.linspace(21, 199, 90)})
    for x in exact.slices:
        [span] = x.requirement.feasible
        column = found.bandwidth.sel({"environment.m": float(x.at)})
        above = column["effects.filter.omega_n"].values >= float(span.low.value)
        assert ((column.values == 15) == above).all()


@pytest.mark.slow
def test_a_map_draws_the_exact_boundary_where_that_is_quick(tmp_path: Path) -> None:
    from haptisym.figures.sweep import sweep_figure

    scene = hs.load_scene("fu2019")
    found = hs.sweep(scene, {"effects.filter.omega_n": [60, 100, 140, 180], "environment.m": [0.5, 1, 2, 4]})
    [ax] = sweep_figure(found, scene).axes
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert {"real part, band-edge", "imaginary part, band-edge"} <= set(labels)
    [ax] = sweep_figure(found).axes
    assert not any("band-edge" in text.get_text() for text in ax.get_legend().get_texts())


def test_two_coefficients_of_unknown_sign_between_two_runs_are_not_one_change() -> None:
    """They may bring three zeros: here 0.098, 2.2373 and 2.2513 rad/s, of which floats once saw the first alone, as proven."""
    given = hs.Scene(
        hs.environments.two_mass(m1="8.1", b1="5.8", k1="41", m2="0.041", b2="2.7", k2="45"),
        (
            hs.effects.admittance_display("w^2/(s^2+w*s+w^2)", parameters={"w": "4.9"}),
            hs.effects.series("g", parameters={"g": "0.045"}),
            hs.effects.series("g", parameters={"g": "0.02"}),
        ),
        (0, 4000),
        hs.Threshold.of(1, 1),
    )
    w, b = 882710825641131 / 2**53, 8887457865645333 / 2**56
    found = hs.sweep(given, {"effects.admittance-display.w": [w], "environment.b1": [b]})
    values = {"w": Rational(*Fraction(w).as_integer_ratio()), "b1": Rational(*Fraction(b).as_integer_ratio())}
    real = [c for c in hs.evaluate(given.with_values(values)).crossings if c.part is hs.Part.REAL]
    assert found.crossings_real.item() == len(real) == 3
    assert found.first_crossing_real.item() == pytest.approx(float(real[0].omega), rel=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_a_block_is_cut_into_first_sets_of_about_a_number_and_the_rest(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        starts = [draw.randint(0, 5) for _ in range(draw.randint(1, 3))]
        region = tuple(slice(x, x + draw.randint(1, 5)) for x in starts)
        whole = blocks.size(region)
        if whole == 1:
            continue
        most = draw.randint(1, whole - 1)
        first, rest = blocks._cut(region, most)
        sets = [[*product(*(range(x.start, x.stop) for x in part))] for part in (first, rest)]
        assert sorted(sets[0] + sets[1]) == [*product(*(range(x.start, x.stop) for x in region))]
        assert sets[0]
        assert sets[1]
        longest = next(x for x in region if x.stop - x.start > 1)
        behind = whole // (longest.stop - longest.start)
        assert len(sets[0]) == max(most // behind, 1) * behind
