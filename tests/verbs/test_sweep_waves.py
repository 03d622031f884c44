"""Sweeps of scenes with delays, holds and powers s^alpha in floats: every count against exact arithmetic, every bound against balls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import comb
from random import Random
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb
from scan import FAMILIES, Draw
from sympy import Rational, lambdify

import haptisym as hs
from haptisym.kernel.rings import s
from haptisym.verbs.sweep import delayterms as libm
from haptisym.verbs.sweep.axes import axes
from haptisym.verbs.sweep.batch import Array, Batch, Monomial, Monomials
from haptisym.verbs.sweep.curves import ThresholdPolynomial, curves_of
from haptisym.verbs.sweep.delayterms import (
    Family,
    FamilyFactor,
    Function,
    Interpolants,
    VariablePoints,
    Variables,
    halving,
    isolate,
    left_out,
    nodes,
    refine,
)

SWEPT = {
    "satellite-contact": {"effects.loop-delay.tau": (1e-3, 0.3), "environment.k": (2e3, 4e4)},
    "delayed-spring": {"effects.delay.tau": (1e-3, 0.3), "environment.k": (10.0, 1e3)},
    "sampled-wall": {"effects.sampling.T": (1e-4, 2e-2), "environment.k": (50.0, 2e3)},
    "organ-tissue": {"effects.communication.tau": (1e-4, 0.05), "environment.k": (10.0, 1e3)},
    "four-channel-teleoperation": {"effects.teleoperator.tau": (1e-4, 0.1), "environment.k": (10.0, 1e3)},
}


def agrees(found: Any, given: hs.Scene, every: int = 1) -> None:
    """Sets that floats answered with their evaluations: counts are equal, frequencies within a relative 1e-10."""
    for at in [*np.ndindex(*found.method.shape)][::every]:
        one = found[dict(zip(found.method.dims, at, strict=True))]
        if int(one.method):
            continue
        e = hs.evaluate(given.with_values({path: Rational(float(one[path])) for path in found.method.dims}))
        told = {x.name: [y.omega for y in e.crossings if y.criterion.name == x.name] for x in e.criteria}
        for name, own in told.items():
            assert int(one[f"crossings_{name}"]) == len(own), name
            first = float(own[0]) if own else np.nan
            assert float(one[f"first_crossing_{name}"]) == pytest.approx(first, rel=1.0001e-10, nan_ok=True)
        for name in ("environment", "perceived"):
            turns = getattr(e, f"changeovers_{name}")
            assert int(one[f"changeovers_{name}"]) == len(turns), name
            first = float(turns[0].omega) if turns else np.nan
            assert float(one[f"changeover_{name}"]) == pytest.approx(first, rel=1.0001e-10, nan_ok=True)
        width = np.nan if e.bandwidth is None else float(e.bandwidth)
        assert float(one.bandwidth) == pytest.approx(width, rel=1.0001e-10, nan_ok=True)
        low, high = (float(x) for x in given.band)
        clear = sum(float(x.high.omega) - float(x.low.omega) for x in e.transparent) / (high - low)
        assert float(one.transparent) == pytest.approx(clear, abs=1e-9)


@pytest.mark.dear("organ-tissue", "sampled-wall", "satellite-contact")
@pytest.mark.few("satellite-contact", "delayed-spring", "sampled-wall", "organ-tissue")
@pytest.mark.parametrize("name", SWEPT)
def test_floats_count_as_exact_arithmetic_does(name: str) -> None:
    given = hs.load_scene(name)
    found = hs.sweep(given, {path: np.geomspace(*span, 9)[1:-1:2].tolist() for path, span in SWEPT[name].items()})
    assert (found.method == 0).mean() > 0.9
    agrees(found, given, every=5)


@pytest.mark.slow
@pytest.mark.parametrize("name", SWEPT)
@pytest.mark.parametrize("low", ["", "1 rad/s", "0.3 Hz"])
def test_floats_count_as_exact_arithmetic_does_on_many_sets(name: str, low: str) -> None:
    given = hs.load_scene(name)
    given = given.with_band(low, given.band[1]) if low else given
    found = hs.sweep(given, {path: np.geomspace(*span, 11).tolist() for path, span in SWEPT[name].items()})
    assert (found.method == 0).mean() > 0.95
    agrees(found, given, every=3)


def two_delays() -> hs.Scene:
    late = (hs.effects.delay("5 ms", name="sent"), hs.effects.delay("8 ms", name="heard"))
    return hs.Scene(hs.environments.kelvin_voigt(100, 2), late, (0, 40))


@pytest.mark.few("given1-vary1-0")
@pytest.mark.parametrize(
    ("given", "vary", "method"),
    [
        (two_delays(), {"effects.heard.tau": [0.01, 0.125], "effects.sent.tau": [0.05]}, 0),
        (hs.load_scene("delayed-spring"), {"evaluation.jnd": [0.03, 0.5]}, 0),
        (hs.load_scene("organ-tissue"), {"evaluation.jnd.imag": [0.0625]}, 0),
        (hs.load_scene("organ-tissue"), {"environment.alpha": [0.25]}, 1),  # the order of a power is no number
    ],
)
def test_delays_limits_and_orders_are_swept_alone_and_together(given: hs.Scene, vary: Any, method: int) -> None:
    found = hs.sweep(given, vary)
    assert (found.method == method).all()
    agrees(found.assign(method=found.method * 0), given)


@pytest.mark.dear("jnd1", "jnd2")
@pytest.mark.few(3)
@pytest.mark.parametrize(
    "jnd",
    [
        {"shape": "ellipse", "real": 0.1, "imag": 0.1, "tilt": -0.5},
        {"shape": "polygon", "corners": [[0.12, 0.02], [0.03, 0.1], [-0.1, 0.05], [-0.04, -0.08], [0.05, -0.09]]},
        {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1},
        {"real": 0.1, "imag": 0.1, "floor": "15 N/m"},
        {"real": "0.08 + 0.004*omega", "imag": 0.1},
    ],
)
def test_a_delayed_scene_is_answered_in_floats_in_its_region_too(jnd: Any) -> None:
    plain = hs.load_scene("delayed-spring")
    asked = hs.Scene(plain.environment, plain.effects, plain.band, jnd)
    found = hs.sweep(asked, {"effects.delay.tau": [0.0078125, 0.25]})
    assert found.method.values[0] == 0  # at the longer delay parts change together for one region
    agrees(found.assign(method=found.method * 0), asked)


@pytest.mark.dear("3-position-force")
@pytest.mark.few("3-position-force", "2-two delays")
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [2, 3])
def test_random_scenes_are_never_counted_wrong(family: str, seed: int) -> None:
    """Around their own values of a delay, if there is one, and of another parameter."""
    given = hs.parse_scene(Draw(seed).case(family).text)
    varied = (p for p in given.parameters if p.key != "alpha" and p.symbol not in given.chain.harmonic_symbols)
    numbers = [p.path for p in varied if p.value.is_Rational and p.value > 0]
    numbers.sort(key=lambda path: path.rpartition(".")[2] not in ("tau", "T"))
    around = np.geomspace(0.5, 2, 5)
    found = hs.sweep(given, {x: (float(given.knobs[x].value) * around).tolist() for x in {numbers[0], numbers[-1]}})
    agrees(found, given, every=12)


@pytest.mark.few("delayed-spring")
@pytest.mark.parametrize("name", ["delayed-spring", "organ-tissue"])
def test_sets_do_not_feel_which_others_are_there(name: str) -> None:
    vary = {path: np.geomspace(*span, 6).tolist() for path, span in SWEPT[name].items()}
    together = hs.sweep(name, vary)
    for i in (0, 4):
        own = {path: values[i : i + 1] for path, values in vary.items()}
        assert hs.sweep(name, own).equals(together.isel({path: [i] for path in vary}))


# --- the ground: libm, polynomials -----------------------------------------------------------------------------------


def test_sines_and_logarithms_are_as_near_as_is_assumed_and_bad_ones_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = libm.ulp_errors()
    assert set(errors) == {"sin", "cos", "exp", "log"}
    assert all(0.4 < error < libm.ULPS for error in errors.values()), errors  # half a unit is what rounding alone takes
    true = np.sin
    monkeypatch.setattr(np, "sin", lambda x: true(x) * (1 + 2e-15))
    assert libm.ulp_errors()["sin"] > libm.ULPS


def bernstein(n: int, i: int, x: Any) -> Any:
    return comb(n, i) * x**i * (1 - x) ** (n - i)


@pytest.mark.parametrize("degree", [1, 5, 14])
def test_values_become_the_bernstein_coefficients_of_their_polynomial_and_of_its_halves(degree: int) -> None:
    rng, n = np.random.default_rng(degree), nodes(degree)
    coefficients = rng.integers(-50, 50, degree + 1).astype(float)
    basis = np.array([[bernstein(degree, i, x) for i in range(degree + 1)] for x in n.high])
    found = n.matrix @ (basis @ coefficients)
    assert np.abs(found - coefficients).max() <= 100 * 2.0**-50 * n.amplified.max() * degree
    assert (n.amplified >= np.abs(n.matrix).sum(axis=1)).all()
    for start, half in ((0.0, halving(degree)[0] @ coefficients), (0.5, halving(degree)[1] @ coefficients)):
        for t in (0.0, 0.25, 0.8, 1.0):
            own, whole = (
                sum(c * bernstein(degree, i, x) for i, c in enumerate(row))
                for row, x in ((half, t), (coefficients, start + t / 2))
            )
            assert own == pytest.approx(whole, abs=1e-9)


@pytest.mark.parametrize("degree", [5, 14])
@pytest.mark.parametrize("speed", [0.5, 3.0, 8.0])
def test_what_interpolation_leaves_out_is_bounded(degree: int, speed: float) -> None:
    """cos and its slope beside the polynomial through its values, in balls; and the bound is no more than a thousand times that."""
    with flint.ctx.workprec(300):
        y = [-(arb.pi() * i / degree).cos() for i in range(degree + 1)]
        p = flint.arb_poly.interpolate(y, [(speed * x + 1).cos() for x in y])
        apart, slopes = [], []
        for i in range(120):
            x = arb(2 * i) / 119 - 1
            apart.append(float(abs((speed * x + 1).cos() - p(x))))
            slopes.append(float(abs(-speed * (speed * x + 1).sin() - p.derivative()(x))))
    ratio = np.array([max(2.0, 2 * degree / speed)])
    value, slope = left_out(np.exp(speed * (ratio - 1 / ratio) / 2), ratio, degree)
    assert max(apart) <= value[0] <= 1e3 * max(apart)
    assert max(slopes) <= slope[0] <= 1e4 * max(slopes)


@pytest.mark.parametrize("degree", [2, 5, 14])
@pytest.mark.parametrize("ratio", [2.0, 17.5])
def test_what_interpolation_leaves_out_is_the_tail_of_a_series(degree: int, ratio: float) -> None:
    """The sum of 4 M r^-k over all k > n, and for the slope at least of k^2 times that."""
    value, slope = left_out(np.array([0.7]), np.array([ratio]), degree)
    terms = [4 * mpmath.mpf(0.7) * mpmath.mpf(ratio) ** -k for k in range(degree + 1, degree + 200)]
    assert mpmath.fsum(terms) <= value[0] <= 1.002 * mpmath.fsum(terms)
    assert mpmath.fsum(x * (degree + 1 + i) ** 2 for i, x in enumerate(terms)) <= slope[0]


# --- values and their errors -----------------------------------------------------------------------------------------


def function(families: Any, sets: Array) -> Function:
    """The product of some families at these sets."""
    powers, variables = Monomials(sets), families[0].variables
    rates = [powers.monomial(x.exponents) * x.constant for x in variables.rates]
    factors = tuple(FamilyFactor(f, f.at(powers)) for f in families)
    return Function(variables, np.array(rates).reshape(-1, sets.shape[1]), factors)


@cache
def functions(name: str) -> tuple[Array, list[Function]]:
    """Of some random sets of a scene all functions that are judged."""
    given, rng = hs.load_scene(name), np.random.default_rng(1)
    sets = np.exp([rng.uniform(*np.log(span), 5) for span in SWEPT[name].values()])
    swept = axes(given, {path: list(span) for path, span in SWEPT[name].items()})
    curves = curves_of(given, [axis.knob for axis in swept])
    assert curves is not None
    asked = [e for e in curves.excess.values() if isinstance(e, ThresholdPolynomial)]
    judged = [function(e.above, sets) - function(e.below, sets) for e in asked]
    return sets, judged + [function(x, sets) for x in curves.changeovers if x is not None]


@pytest.mark.few("delayed-spring")
@pytest.mark.parametrize("name", ["delayed-spring", "sampled-wall", "organ-tissue"])
def test_the_functions_of_a_sweep_have_the_signs_of_those_of_the_scene(name: str) -> None:
    """r^2 - c^2 from the closed forms in s, at complex numbers by mpmath, without half angles and without sines over omega."""
    given, (sets, asked) = hs.load_scene(name), functions(name)
    limits = [float(x.limit) for x in hs.evaluate(given).criteria]
    signs = set()
    for i in range(sets.shape[1]):
        values = {path: Rational(float(x)) for path, x in zip(SWEPT[name], sets[:, i], strict=True)}
        d = given.with_values(values).distortion()
        H, G = (lambdify(s, x.expression(), "mpmath") for x in (d.env, d.perc))
        for fraction in (0.013, 0.21, 0.5, 0.83, 0.999):
            z = mpmath.mpc(0, fraction * float(given.band[1]))
            change, size = mpmath.mpc(G(z)) - H(z), abs(H(z)) ** 2
            for f, part, limit in zip(asked, (change.real, change.imag), limits, strict=False):
                excess = part**2 / size - limit
                told = exact_value(f, sets[:, i].tolist(), arb(fraction))
                assert (told > 0) == (excess > 0)
                signs.add(excess > 0)
    assert signs == {True, False}


def exact_value(f: Function, params: list[float], x: arb) -> arb:
    """A wave function of one set at a frequency, in balls."""
    total = []
    for side in (f.above, f.below):
        value = arb(1)
        for factor in side:
            value *= family_value(factor.family, params, x)
        total.append(value if side else arb(0))
    return total[0] - total[1]


def family_value(family: Family, params: list[float], x: arb) -> arb:
    """Its own terms with 106-bit constants, without any Horner rule."""
    angles = [monomial_value(m, params) * x for m in family.variables.rates]
    waves = [w for a in angles for w in (a.cos(), a.sin() / a if a != 0 else arb(1))]
    waves += [(x.log() * arb(alpha)).exp() for alpha in family.variables.orders]
    total = arb(0)
    for term in family.terms:
        power, *exponents = family.exponents[term.power]
        value = monomial_value(term, params) * x**power
        for wave, n in zip(waves, exponents, strict=True):
            value *= wave**n
        total += value
    return total


def monomial_value(term: Monomial, params: list[float]) -> arb:
    value = arb(term.constant) + arb(term.rest)
    for p, n in zip(params, term.exponents, strict=True):
        value *= arb(p) ** n
    return value


@pytest.mark.dear("organ-tissue", "sampled-wall")
@pytest.mark.few("delayed-spring", "sampled-wall", "organ-tissue")
@pytest.mark.parametrize("name", SWEPT)
def test_values_lie_within_their_error_and_sizes_bound_them(name: str) -> None:
    """Every function of the scene, at random frequencies of random sets; errors are a small part of what they are bounded by."""
    rng, (sets, asked) = np.random.default_rng(5), functions(name)
    for f in asked:
        x = np.exp(rng.uniform(np.log(1e-4), 0.0, (3, sets.shape[1])))
        values, high = f.values(x), x.max(axis=0)
        sizes = f.sizes(high)
        wrong = f.error(sizes, x.min(axis=0), high)
        assert (wrong < 1e-11 * sizes).all()
        with flint.ctx.workprec(200):
            for row, i in np.ndindex(x.shape):
                truth = exact_value(f, sets[:, i].tolist(), arb(float(x[row, i])))
                assert abs(float(truth)) <= sizes[i] * (1 + 1e-9)
                assert float(abs(arb(float(values[row, i])) - truth)) <= wrong[i]


@pytest.mark.dear("four-channel-teleoperation", "sampled-wall")
@pytest.mark.parametrize("name", SWEPT)
def test_functions_stay_within_what_their_polynomials_leave_out(name: str) -> None:
    """On a segment in the middle of the band."""
    sets, asked = functions(name)
    low, high, n = np.full(sets.shape[1], 0.4), np.full(sets.shape[1], 0.6), nodes(6)
    for f in asked:
        value, slope = f.left_out(low, high, 6)
        coefficients = n.matrix @ f.values(low * n.low[:, None] + high * n.high[:, None])
        rounded = n.amplified.max() * f.error(f.sizes(high), low, high) * 2
        for t in np.linspace(0.01, 0.99, 17):
            p = sum(c * bernstein(6, i, t) for i, c in enumerate(coefficients))
            assert (np.abs(p - f.values((low + t * (high - low))[None])[0]) <= value + rounded).all()
        assert ((slope > value) | (value == 0)).all()  # nothing is left out of polynomials


def power(alpha: float, sets: int) -> Function:
    """x^alpha."""
    variables = Variables((), (alpha,))
    return function([Family((Monomial(0, 1.0, 0.0, (0,)),), variables, ((0, 1),))], np.ones((1, sets)))


@pytest.mark.parametrize("alpha", [0.5, 0.9, 1.7])
def test_powers_of_frequencies_of_any_size_lie_within_their_error(alpha: float) -> None:
    """The further x is from 1, the more of log x is lost; a small part of that bound is not enough."""
    x = 10.0 ** np.random.default_rng(3).uniform(-160, 0, 200)
    f = power(alpha, 200)
    values, wrong = f.values(x[None])[0], f.error(f.sizes(x), x, x)
    with flint.ctx.workprec(300):
        exact = [(arb(float(y)).log() * arb(alpha)).exp() for y in x]
        off = np.array([float(abs(arb(float(v)) - e)) for v, e in zip(values, exact, strict=True)])
    assert (off <= wrong).all()
    assert (off > wrong / 100).any()
    assert (wrong < 1e-11 * values + 1e-270).all()


@pytest.mark.parametrize("degree", [6, 12])
@pytest.mark.parametrize("alpha", [0.5, 1.5])
def test_what_polynomials_leave_out_of_powers_is_bounded_beside_0_or_said_to_be_unknown(
    alpha: float, degree: int
) -> None:
    """Powers are analytic right of 0 alone; further away from 0 little is left out."""
    low = np.array([1e-6, 1e-3, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.5, 0.9])
    high, y = np.ones_like(low), -np.cos(np.pi * np.arange(degree + 1) / degree)
    value, slope = power(alpha, len(low)).left_out(low, high, degree)
    for i, (a, b) in enumerate(zip(low, high, strict=True)):
        middle, half = (a + b) / 2, (b - a) / 2
        p = np.polynomial.Polynomial.fit(y, (middle + half * y) ** alpha, degree, domain=[-1, 1])
        t = np.linspace(-1, 1, 801)
        off = np.abs(p(t) - (middle + half * t) ** alpha).max()
        steep = np.abs(p.deriv()(t) - half * alpha * (middle + half * t) ** (alpha - 1)).max()
        assert not value[i] < off - 1e-12  # what floats do to the polynomial that is fitted here
        assert not slope[i] < steep - 1e-10
    assert not np.isfinite([value[:2], slope[:2]]).any()
    assert (value[-2:] < 1e-3).all()


class Rounded:
    """How often the terms of a number were rounded, at most: a product and a sum are, each."""

    def __init__(self, often: int) -> None:
        self.often = often

    def __mul__(self, other: Rounded) -> Rounded:
        return Rounded(self.often + other.often + 1)

    def __add__(self, other: Any) -> Rounded:
        return Rounded(max(self.often, other.often) + 1) if isinstance(other, Rounded) else self

    __radd__ = __add__


ORDERS = (0.25, 0.5)


@pytest.mark.parametrize("seed", range(4))
def test_no_term_of_a_sum_of_waves_is_rounded_more_often_than_is_counted(seed: int) -> None:
    """Samples rarely come near to a bound that is proven; so a number that counts is put in a float's place."""
    pick, unit = Random(seed), (0, 1)
    variables = Variables((Monomial(0, 1.0, 0.0, unit), Monomial(0, 2.0, 0.0, unit)), ORDERS)
    for _ in range(20):
        most = [pick.choice([0, 1, 2, 5, 9]), *(pick.choice([0, 1, 3]) for _ in range(6))]
        some = {tuple(pick.randint(0, n) for n in most) for _ in range(pick.randint(1, 12))}
        every = {(n, *row[1:]) for row in some for n in range(row[0])} if pick.random() < 0.5 else set()  # of x
        rows = sorted(some | every)
        terms = tuple(Monomial(i, 1.0, 0.0, unit) for i in range(len(rows)))
        known = np.full((len(rows), 1), Rounded(pick.randint(0, 30)), dtype=object)
        batch = Batch(known, known, max(x.often for x in known.ravel()))
        factor = FamilyFactor(Family(terms, variables, tuple(rows)), batch)
        x, waves = np.array([Rounded(3)], dtype=object), [np.array([Rounded(0)], dtype=object)] * 6
        [value] = factor.at(VariablePoints(x, waves), known)
        assert value.often <= factor.roundings


# --- zeros -----------------------------------------------------------------------------------------------------------


@dataclass
class Placed:
    """Functions of one kind, one for each set, where they vanish beyond 0, and their signs just above it."""

    function: Function
    zeros: list[list[mpmath.mpf]]
    signs: list[int]


def placed(pick: Random, sets: int, lines: int, *, wave: bool, orders: tuple[int, ...] = ()) -> Placed:
    """Products of x - a, cos(k x) - b and x^alpha - c, with alpha of those ``orders``."""
    k = [pick.uniform(0.5, 12.0) for _ in range(sets)]
    factors = [((1, 0, 0, 0, 0), [pick.uniform(-0.5, 1.5) for _ in range(sets)]) for _ in range(lines)]
    factors += [((0, 1, 0, 0, 0), [pick.uniform(-1.2, 1.2) for _ in range(sets)])] if wave else []
    for i in orders:
        row = (0, 0, 0, int(i == 0), int(i == 1))
        factors.append((row, [pick.uniform(-0.3, 1.2) for _ in range(sets)]))
    count = 1 + len(factors)
    unit = [tuple(int(i == j) for j in range(count)) for i in range(count)]
    variables, families = Variables((Monomial(0, 1.0, 0.0, unit[0]),), ORDERS), []
    for i, (row, _) in enumerate(factors):
        terms = Monomial(0, -1.0, 0.0, unit[1 + i]), Monomial(1, 1.0, 0.0, (0,) * count)
        families.append(Family(terms, variables, ((0,) * 5, row)))
    own = [[(row, mpmath.mpf(x[n])) for row, x in factors] for n in range(sets)]
    return Placed(
        function(families, np.array([k, *(x for _, x in factors)])),
        [[z for row, y in own[n] for z in zeros_of(row, y, k[n])] for n in range(sets)],
        [int(np.prod([1 if (row[1] or 0) > y else -1 for row, y in own[n]])) for n in range(sets)],
    )


def zeros_of(row: tuple[int, ...], y: mpmath.mpf, k: float) -> list[mpmath.mpf]:
    """Beyond 0, as far as twice the end."""
    line, wave, _, *orders = row
    if wave:
        first = mpmath.acos(y) / k if abs(y) <= 1 else mpmath.inf
        return [z for n in range(5) for e in (1, -1) if 0 < (z := 2 * n * mpmath.pi / k + e * first) < mpmath.inf]
    return [y if line else y ** (1 / mpmath.mpf(ORDERS[orders.index(1)]))] if y > 0 else []


def share_found(given: Placed, low: float) -> float:
    """What is decided and proven is right; how large a share is, of functions whose zeros are well apart."""
    f = given.function
    found = isolate(f, (low, 0.4, 1.0))
    told = {accuracy: refine(f.of(found.sets), found.low, found.high, accuracy) for accuracy in (1e-9, 1e-14, 1e-16)}
    doubt = isolate(f, (low, 0.4, 1.0), first_is_doubt=True)  # somewhere below 0.4 the band begins
    for i in np.flatnonzero(doubt.decided):
        assert not any(low < z < 0.4 for z in given.zeros[i])
        assert (doubt.sets == i).sum() == sum(0.4 < z < 1 for z in given.zeros[i])
    clear = decided = asked = shown = 0
    for i in range(f.sets):
        inside = sorted(z for z in given.zeros[i] if low < z < 1)
        marks = sorted([mpmath.mpf(low), mpmath.mpf("0.4"), mpmath.mpf(1), *given.zeros[i]])
        apart = min(b - a for a, b in pairwise(marks)) > 1e-3
        clear += apart
        if not found.decided[i]:
            continue
        decided += apart
        own = np.flatnonzero(found.sets == i)
        assert len(own) == len(inside)
        for j, z in zip(own, inside, strict=True):
            assert found.low[j] <= z <= found.high[j]
            for accuracy, (x, sure) in told.items():
                assert not sure[j] or abs(mpmath.mpf(float(x[j])) - z) <= mpmath.mpf(accuracy) * z
            asked, shown = asked + apart, shown + (apart and told[1e-9][1][j])
        assert found.first[i] == given.signs[i] * (-1) ** sum(z <= low for z in given.zeros[i])
    return min(decided / max(clear, 1), shown / max(asked, 1))


KINDS = [
    (3, False, (), 0.0), (4, False, (), 0.25), (1, True, (), 0.0), (2, True, (), 0.03125), (2, False, (1,), 0.0), (1, True, (0,), 0.0), (1, True, (1,), 0.25), (0, False, (0, 1), 0.0),
]  # fmt: skip


@pytest.mark.parametrize(
    ("sets", "seed"), [(40, 0), *(pytest.param(200, n, marks=pytest.mark.slow) for n in (1, 2, 3))]
)
@pytest.mark.parametrize(("lines", "wave", "orders", "low"), KINDS)
def test_zeros_that_were_placed_are_found_each_alone(
    lines: int, wave: bool, orders: tuple[int, ...], low: float, sets: int, seed: int  # noqa: FBT001
) -> None:  # fmt: skip
    """Also where a power makes x = 0 a place at which no polynomial comes near to the function."""
    with mpmath.workdps(40):
        given = placed(Random(f"{lines} {orders} {low} {seed}"), sets, lines, wave=wave, orders=orders)
        share = share_found(given, low)
    assert share > 0.9 or (share == 0 and len(orders) > 1)  # two powers at once are left open at 0


def test_what_is_told_of_polynomials_holds_for_all_that_they_may_stand_for() -> None:
    """No zero, however they are moved by what they leave out; and one, a simple one, however they are bent by it."""
    pick, degree, sets = np.random.default_rng(3), 5, 3000
    b = np.sort(pick.uniform(-1, 1, (degree + 1, sets)), axis=0) * pick.choice([-1, 1], sets) + pick.uniform(-1, 1, sets)  # fmt: skip
    b[:, ::7] = pick.uniform(-1, 1, (degree + 1, len(b[0, ::7])))
    wrong, value, slope = (10.0 ** pick.uniform(-4, -0.3, sets) for _ in range(3))
    curves = Interpolants(b, wrong, (value, slope))
    ends = curves.end_signs()
    none, one = curves.judged(ends)
    t = np.linspace(0, 1, 81)[:, None]
    p = sum(bernstein(degree, k, t) * b[k] for k in range(degree + 1))
    rate = sum(bernstein(degree - 1, k, t) * np.diff(b, axis=0)[k] for k in range(degree))
    moved, bent = wrong + value, 2 * wrong + slope
    assert (ends == np.where(np.abs(b[[0, -1]]) > moved, np.sign(b[[0, -1]]), 0)).all()
    keeps = (np.abs(p).min(axis=0) > moved) & (np.sign(p).min(axis=0) == np.sign(p).max(axis=0))
    rises = (np.abs(rate).min(axis=0) > bent) & (np.sign(rate).min(axis=0) == np.sign(rate).max(axis=0))
    known, opposite = (ends != 0).all(axis=0), ends[0] != ends[1]
    assert (keeps | (rises & known & ~opposite))[none].all()
    assert (rises & known & opposite)[one].all()
    assert min(none.sum(), one.sum()) > 100
    halved = curves.of(np.arange(50)).halves()
    for side, start in ((slice(50), 0.0), (slice(50, 100), 0.5)):
        whole = sum(bernstein(degree, k, start + t / 2) * b[k, :50] for k in range(degree + 1))
        part = sum(bernstein(degree, k, t) * halved.coefficients[k, side] for k in range(degree + 1))
        assert np.abs(whole - part).max() < 1e-14
        assert (halved.left_out[0][side] == value[:50]).all()
        assert (halved.left_out[1][side] == slope[:50] / 2).all()  # of a function on half the way
