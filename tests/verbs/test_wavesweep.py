"""Sweeps of scenes with delays, holds and powers s^alpha in floats: every bound against exact arithmetic, every count too."""

from __future__ import annotations

from functools import cache
from math import comb
from typing import Any

import flint
import numpy as np
import pytest
from flint import arb
from scan import FAMILIES, Draw
from sympy import Rational

import haptisym as hs
from haptisym.verbs.sweep import libm, wavecurves
from haptisym.verbs.sweep.axes import axes
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.chebyshev import halving, left_out, nodes
from haptisym.verbs.sweep.exactly import exact_answers
from haptisym.verbs.sweep.kernel import Kernel
from haptisym.verbs.sweep.passes import TOLERANCE
from haptisym.verbs.sweep.told import Told
from haptisym.verbs.sweep.wavepass import WavePass
from haptisym.verbs.sweep.waves import WaveFamily
from haptisym.verbs.sweep.wavevalues import WaveFunction

TOLD = Told.of(hs.load_scene("delayed-spring"))
SWEPT = {
    "satellite-contact": {"effects.loop-delay.tau": (1e-3, 0.3), "environment.k": (2e3, 4e4)},
    "delayed-spring": {"effects.delay.tau": (1e-3, 0.3), "environment.k": (10.0, 1e3)},
    "sampled-wall": {"effects.sampling.T": (1e-4, 2e-2), "environment.k": (50.0, 2e3)},
    "organ-tissue": {"effects.communication.tau": (1e-4, 0.05), "environment.k": (10.0, 1e3)},
    "four-channel-teleoperation": {"effects.teleoperator.tau": (1e-4, 0.1), "environment.k": (10.0, 1e3)},
}


@cache
def kernel_of(name: str, low: str = "") -> Kernel:
    given = hs.load_scene(name)
    if low:
        given = given.with_band(low, given.band[1])
    swept = {path: list(span) for path, span in SWEPT[name].items()}
    return Kernel.of(given, [axis.knob for axis in axes(given, swept)])


def drawn(name: str, sets: int, seed: int = 1) -> Array:
    rng = np.random.default_rng(seed)
    return np.exp([rng.uniform(*np.log(span), sets) for span in SWEPT[name].values()])


def agrees(found: Any, truth: dict[str, float]) -> None:
    for name in TOLD.counts:
        assert found[name] == truth[name], name
    for name in TOLD.floats:
        assert np.isnan(truth[name]) == np.isnan(found[name]), name
        limit = 1e-9 if name == "transparent" else 1.0001 * TOLERANCE * abs(truth[name])
        assert np.isnan(truth[name]) or abs(found[name] - truth[name]) <= limit, name


# --- the ground: libm, polynomials -------------------------------------------------------------------------------------


def test_sines_and_logarithms_are_as_near_as_is_assumed() -> None:
    errors = libm.ulp_errors()
    assert set(errors) == {"sin", "cos", "exp", "log"}
    assert all(0.4 < error < libm.ULPS for error in errors.values()), errors  # half a unit is what rounding alone takes
    assert libm.is_trusted()


@pytest.mark.parametrize("off", [2e-15, -2e-15])
def test_the_worst_error_is_seen_on_either_side_and_wherever_it_is(off: float) -> None:
    points = np.concatenate([np.linspace(-3, -0.1, 7), np.geomspace(1e-6, 50, 22)])
    assert libm._worst(np.sin, points, arb.sin) < 1
    for bad in points:
        found = libm._worst(lambda x, bad=bad: np.sin(x) * np.where(x == bad, 1 + off, 1.0), points, arb.sin)
        assert 4 < found < 20


def test_where_they_are_not_every_set_is_answered_exactly(monkeypatch: pytest.MonkeyPatch) -> None:
    true = np.sin
    monkeypatch.setattr(np, "sin", lambda x: true(x) * (1 + 2e-15))
    assert libm.ulp_errors()["sin"] > libm.ULPS
    monkeypatch.undo()
    monkeypatch.setattr(wavecurves, "is_trusted", lambda: False)
    found = hs.sweep("delayed-spring", {"effects.delay.tau": ["10 ms", "20 ms"]})
    assert (found.method == 1).all()
    assert "every set is answered exactly" in found.attrs["floats"]


@pytest.mark.parametrize("degree", [1, 5, 14])
def test_values_become_the_bernstein_coefficients_of_their_polynomial(degree: int) -> None:
    """Of polynomials with whole Bernstein coefficients, evaluated in fractions at the floats' own nodes."""
    rng, n = np.random.default_rng(degree), nodes(degree)
    coefficients = rng.integers(-50, 50, degree + 1).astype(float)
    basis = np.array([[_bernstein(degree, i, x) for i in range(degree + 1)] for x in n.high])
    found = n.matrix @ (basis @ coefficients)
    assert np.abs(found - coefficients).max() <= 100 * 2.0**-50 * n.amplified.max() * degree
    assert (n.amplified >= np.abs(n.matrix).sum(axis=1)).all()
    first, second = (w @ coefficients for w in halving(degree))
    for t in (0.0, 0.25, 0.8, 1.0):
        for half, x in ((first, t / 2), (second, (1 + t) / 2)):
            own = sum(c * _bernstein(degree, i, t) for i, c in enumerate(half))
            assert own == pytest.approx(sum(c * _bernstein(degree, i, x) for i, c in enumerate(coefficients)), abs=1e-9)


def _bernstein(n: int, i: int, x: float) -> float:
    return float(comb(n, i) * x**i * (1 - x) ** (n - i))


@pytest.mark.parametrize("degree", [5, 6, 14])
@pytest.mark.parametrize("speed", [0.5, 3.0, 8.0])
def test_what_interpolation_leaves_out_is_bounded(degree: int, speed: float) -> None:
    """cos and its slope beside the polynomial through its values, in balls; and the bound is no more than a thousand times that."""
    with flint.ctx.workprec(300):
        exact = [(1 - (arb.pi() * i / degree).cos()) for i in range(degree + 1)]
        y = [x - 1 for x in exact]
        p = flint.arb_poly.interpolate(y, [(speed * x + 1).cos() for x in y])
        apart, slopes = [], []
        for i in range(200):
            x = arb(2 * i) / 199 - 1
            apart.append(float(abs((speed * x + 1).cos() - p(x))))
            slopes.append(float(abs(-speed * (speed * x + 1).sin() - p.derivative()(x))))
    ratio = np.array([max(2.0, 2 * degree / speed)])
    value, slope = left_out(np.exp(speed * (ratio - 1 / ratio) / 2), ratio, degree)
    assert max(apart) <= value[0] <= 1e3 * max(apart)
    assert max(slopes) <= slope[0] <= 1e4 * max(slopes)


# --- values and their errors -------------------------------------------------------------------------------------------


def exact_value(f: WaveFunction, params: list[float], x: arb) -> Any:
    """A wave function of one set at a frequency, in balls."""
    total = []
    for side in (f.above, f.below):
        product = arb(1)
        for factor in side:
            product *= _family(factor.family, params, x)
        total.append(product if side else arb(0))
    return total[0] - total[1]


def _family(family: WaveFamily, params: list[float], x: arb) -> Any:
    """The family's own terms with 106-bit constants, without any Horner rule."""
    angles = [_monomial(m, params) * x for m in family.variables.rates]
    waves = [w for a in angles for w in (a.cos(), a.sin() / a if a != 0 else arb(1))]
    waves += [(x.log() * arb(alpha)).exp() for alpha in family.variables.orders]
    total = arb(0)
    for term in family.terms:
        power, *exponents = family.rows[term.power]
        value = _monomial(term, params) * x**power
        for wave, n in zip(waves, exponents, strict=True):
            value *= wave**n
        total += value
    return total


def _monomial(term: Any, params: list[float]) -> Any:
    value = arb(term.constant) + arb(term.rest)
    for p, n in zip(params, term.exponents, strict=True):
        value *= arb(p) ** n
    return value


@pytest.mark.parametrize("name", SWEPT)
def test_values_lie_within_their_error_and_sizes_bound_them(name: str) -> None:
    """Every function of the scene, at random frequencies of random sets; errors are a small part of what they are bounded by."""
    kernel, sets = kernel_of(name), drawn(name, 6)
    assert kernel.curves is not None
    a_pass = WavePass(kernel.curves, kernel.band, sets)
    asked = [a_pass._at(e.above) - a_pass._at(e.below) for e in kernel.curves.excess.values() if e]
    asked += [a_pass._at(x) for x in kernel.curves.changeovers if x]
    rng = np.random.default_rng(5)
    for f in asked:
        x = np.exp(rng.uniform(np.log(1e-4), 0.0, (5, 6)))
        values, high = f.values(x), x.max(axis=0)
        sizes = f.sizes(high)
        wrong = f.error(sizes, x.min(axis=0), high)
        assert (wrong < 1e-11 * sizes).all()
        with flint.ctx.workprec(200):
            for row, i in np.ndindex(x.shape):
                truth = exact_value(f, sets[:, i].tolist(), arb(float(x[row, i])))
                assert abs(float(truth)) <= sizes[i] * (1 + 1e-9)
                assert float(abs(arb(float(values[row, i])) - truth)) <= wrong[i]


@pytest.mark.parametrize("name", SWEPT)
def test_functions_stay_within_what_their_polynomials_leave_out(name: str) -> None:
    kernel, sets = kernel_of(name), drawn(name, 8, seed=2)
    assert kernel.curves is not None
    a_pass = WavePass(kernel.curves, kernel.band, sets)
    for e in kernel.curves.excess.values():
        assert e is not None
        f = a_pass._at(e.above) - a_pass._at(e.below)
        low, high = np.full(8, 0.4), np.full(8, 0.6)
        n = nodes(6)
        value, slope = f.left_out(low, high, 6)
        coefficients = n.matrix @ f.values(low * n.low[:, None] + high * n.high[:, None])
        rounded = n.amplified.max() * f.error(f.sizes(high), low, high) * 2
        for t in np.linspace(0.01, 0.99, 23):
            p = sum(c * _bernstein(6, i, t) for i, c in enumerate(coefficients))
            truth = f.values((low + t * (high - low))[None])[0]
            assert (np.abs(p - truth) <= value + rounded).all()
        assert (slope > value).all()


# --- answers -----------------------------------------------------------------------------------------------------------


@pytest.mark.few("satellite-contact", "delayed-spring", "sampled-wall", "four-channel-teleoperation")
@pytest.mark.parametrize("name", SWEPT)
def test_floats_count_as_exact_arithmetic_does(name: str) -> None:
    kernel, sets = kernel_of(name), drawn(name, 400)
    columns, left = kernel.in_floats(sets)
    assert len(left) <= 4
    for i in range(6):
        if i not in left:
            truth = exact_answers(kernel.scene, kernel.swept, sets[:, i].tolist())
            agrees({key: column[i] for key, column in columns.items()}, truth)


@pytest.mark.slow
@pytest.mark.parametrize("name", SWEPT)
@pytest.mark.parametrize("low", ["", "1 rad/s", "0.3 Hz"])
def test_floats_count_as_exact_arithmetic_does_on_many_sets(name: str, low: str) -> None:
    kernel, sets = kernel_of(name, low), drawn(name, 300, seed=3)
    columns, left = kernel.in_floats(sets)
    assert len(left) <= 6
    for i in set(range(300)) - set(left.tolist()):
        truth = exact_answers(kernel.scene, kernel.swept, sets[:, i].tolist())
        agrees({key: column[i] for key, column in columns.items()}, truth)


def random_kernel(family: str, seed: int) -> tuple[Kernel, Array]:
    """A random scene of that kind, and sets around its own values of a delay, if there is one, and of another parameter."""
    given = hs.parse_scene(Draw(seed).case(family).text)
    numbers = [p.path for p in given.parameters if p.value.is_Rational and p.value > 0 and p.key != "alpha"]
    numbers.sort(key=lambda path: path.rpartition(".")[2] not in ("tau", "T"))
    chosen, rng = [*dict.fromkeys([numbers[0], numbers[-1]])], np.random.default_rng(seed)
    around = np.exp(rng.uniform(-0.7, 0.7, (len(chosen), 60)))
    sets = np.array([[float(given.knobs[path].value)] for path in chosen]) * around
    swept = axes(given, {path: row.tolist() for path, row in zip(chosen, sets, strict=True)})
    return Kernel.of(given, [axis.knob for axis in swept]), sets


@pytest.mark.parametrize(
    ("family", "seed"),
    [("delay", 3), ("two delays", 2), ("position-force", 3)],
)
def test_resonances_steep_terms_and_high_degrees_are_counted_in_floats(family: str, seed: int) -> None:
    kernel, sets = random_kernel(family, seed)
    columns, left = kernel.in_floats(sets)
    assert len(left) <= 3
    i = next(i for i in range(60) if i not in left)
    agrees(
        {key: column[i] for key, column in columns.items()},
        exact_answers(kernel.scene, kernel.swept, sets[:, i].tolist()),
    )


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(100, 106))
def test_random_scenes_are_never_counted_wrong(family: str, seed: int) -> None:
    kernel, sets = random_kernel(family, seed)
    columns, left = kernel.in_floats(sets)
    for i in sorted(set(range(60)) - set(left.tolist()))[:4]:
        truth = exact_answers(kernel.scene, kernel.swept, sets[:, i].tolist())
        if truth["method"] == 1:
            agrees({key: column[i] for key, column in columns.items()}, truth)


@pytest.mark.parametrize("name", ["delayed-spring", "organ-tissue"])
def test_sets_do_not_feel_which_others_are_there(name: str) -> None:
    kernel, sets = kernel_of(name), drawn(name, 37)
    together, _ = kernel.in_floats(sets)
    for i in (0, 17, 36):
        alone, _ = kernel.in_floats(sets[:, [i]])
        for key, column in together.items():
            assert np.array_equal(column[[i]], alone[key], equal_nan=True), key


@pytest.mark.slow
@pytest.mark.parametrize("name", ["delayed-spring", "organ-tissue", "satellite-contact"])
def test_a_threshold_that_is_swept_beside_waves_is_counted_in_floats_as_each_evaluation_counts_it(name: str) -> None:
    scene, limits = hs.load_scene(name), [0.03, 0.0625, 0.125, 0.5]
    found = hs.sweep(scene, {"evaluation.jnd": limits})
    assert (found["method"] == 0).all()
    for i, limit in enumerate(limits):
        alone = hs.evaluate(scene.with_values({"evaluation.jnd": Rational(limit)}))
        for part in ("real", "imag"):
            own = [x for x in alone.crossings if x.part.value == part and x.kind.value != "touches"]
            assert int(found[f"crossings_{part}"][i]) == len(own)
            first = float(own[0].omega) if own else float("nan")
            assert float(found[f"first_crossing_{part}"][i]) == pytest.approx(first, rel=1e-9, nan_ok=True)
