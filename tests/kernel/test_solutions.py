"""Formulas of frequencies with their conditions, against the signs of a device on a dense grid, computed in complex numbers."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, Symbol, atan2, exp, lambdify, sqrt

import haptisym as hs
from haptisym.kernel.rings import c, s
from haptisym.kernel.solutions import Solution
from haptisym.model.frequencies import lowest_formula

k, b, m, n, w, zeta, tau, T = hs.symbols("k b m n w zeta tau T")
a = Symbol("a", real=True)
LAG, FILTER = w / (s + w), w**2 / (s**2 + 2 * zeta * w * s + w**2)
ONE, NONE = Integer(1), Integer(0)


def series(G: Expr) -> hs.Effect:
    return hs.effects.two_port(G, NONE, NONE, ONE)


def beside(Z: Expr) -> hs.Effect:
    return hs.effects.two_port(ONE, Z, NONE, ONE)


def behind(Z: Expr) -> hs.Effect:
    return hs.effects.two_port(ONE, NONE, 1 / Z, ONE)


DEVICES = {
    "lag on mass, spring and damper": (m * s**2 + b * s + k, series(LAG)),
    "lag and device mass": (k + b * s, series(LAG), beside(m * s**2)),
    "filter and device mass": (k + b * s, series(FILTER), beside(m * s**2)),
    "compliance, spring and damper": (k + b * s, behind(m + n * s)),
    "gain of either sign in a lag": (m * s**2 + b * s + k, series(1 + a * LAG)),
    "lead of either sign": (k + b * s, series(1 + a * s)),
    "resonance without damping": (k + n * m * s**2 / (m * s**2 + n), beside(m * s**2)),
    "fourth order of either sign": (m * s**4 + a * s**2 + k, series(1 + a * LAG)),
    "delay on a spring": (k + 0 * s, series(exp(-s * tau))),
    "delay and gain of either sign": (k + 0 * s, series(a * exp(-s * tau))),
    "delayed force beside a spring": (k + 0 * s, series(1 + a * exp(-s * tau))),
    "predictor": (k + 0 * s, series(1 / (2 - exp(-s * tau)))),
    "predictor of either sign": (k + 0 * s, series(1 / (5 + a * exp(-s * tau)))),
    "two delays": (k + 0 * s, series(exp(-s * tau)), series(exp(-s * T))),
    "delay there and back": (k + 0 * s, series(exp(-s * tau)), series(a + exp(-2 * s * tau)), series(exp(s * tau))),
}


def turns(d: tuple[Expr, ...], values: dict[Symbol, Rational], grid: np.ndarray) -> dict[str, np.ndarray]:
    """Between which points of a grid the ratios cross their threshold and real parts change their sign."""
    chain = lambdify(s, [d[0].xreplace(values), *(tuple(x.xreplace(values) for x in e.matrix) for e in d[1:])])
    env, *rows = chain(1j * grid)
    felt = env
    for A, B, C, D in rows:
        felt = (A * felt + B) / (C * felt + D)
    change, size, most = felt - env, abs(env) + 0 * grid, float(values[c])
    parts = {"real": abs(change.real) / size - most, "imag": abs(change.imag) / size - most}
    parts |= {"environment": env.real / size, "perceived": felt.real / abs(felt)}
    return {x: np.flatnonzero(np.diff(np.sign(np.where(abs(y) < 1e-12, 0, y)))) for x, y in parts.items()}


@pytest.mark.few("lag and device mass", "delay and gain of either sign")
@pytest.mark.parametrize("name", DEVICES)
def test_exactly_the_formulas_whose_conditions_hold_are_frequencies(name: str) -> None:
    device = DEVICES[name]
    d, draw = hs.distort(*device), Random(name)
    asked = {part.value: d.crossings(part) for part in hs.Part}
    asked |= dict(zip(("environment", "perceived"), d.changeovers, strict=True))
    is_late = d.perceived.has(exp)
    grid = np.linspace(1e-4, 12, 40_001) if is_late else np.geomspace(1e-4, 1e5, 40_001)
    for _ in range(6):
        values = {x: Rational(draw.uniform(0.05, 5)) * (draw.choice((-1, 1)) if x == a else 1) for x in d.free_symbols}
        values[c] = Rational(draw.uniform(0.02, 1.6))
        seen = turns(device, values, grid)
        for kind, found in asked.items():
            told = []
            for x in found:
                if x.omega is not None and all(y.xreplace(values).evalf() >= 0 for y in x.conditions):
                    first, period = (complex(y.xreplace(values).evalf()) for y in (x.omega, x.period))
                    assert abs(first.imag) < 1e-9 * abs(first), (kind, x)
                    assert first.real >= 0 <= period.real
                    told += [first.real + i * period.real for i in range(60 if period else 1)]
            places = sorted({int(i) for x in told for i in [np.searchsorted(grid, x) - 1] if 0 <= i < len(grid) - 1})
            if all(x.omega is not None for x in found):
                assert places == seen[kind].tolist(), (kind, values, found)
            else:
                assert set(places) <= set(seen[kind].tolist()), (kind, values, found)


def test_a_changeover_is_the_root_that_is_in_force() -> None:
    """k + b w^2/(w^2 + W) ... - m W: one root of m W^2 + (m w^2 - b w) W - k w^2 is positive, whatever the values."""
    d = hs.distort(k + b * s, LAG, hs.effects.shunt(m=m))
    values = {k: 200, b: 5, w: 60, m: Rational(1, 10)}
    [positive] = [x for x in np.roots([0.1, 0.1 * 3600 - 300, -200 * 3600]) if x > 0]
    assert float(d.changeover_perceived.xreplace(values)) == pytest.approx(positive**0.5)
    fourth = hs.distort(n * s**4 + m * s**2 - k)
    assert float(fourth.changeover_environment.xreplace({k: 1, m: 1, n: 1})) == pytest.approx(((1 + 5**0.5) / 2) ** 0.5)
    either = hs.distort(m * s**4 + a * s**2 + k)
    for values, low in ((3, 1, 2), 1), ((-3, 1, 2), None), ((2, 1, 1), None):  # the last one is touched: (W - 1)^2
        known = dict(zip((a, m, k), map(Integer, values), strict=True))
        found = either.changeover("env", known)
        assert (found and found.xreplace(known)) == low
    resonant = hs.distort(k + 0 * s, series(1 / (s**2 + w**2)))
    assert (resonant.changeover_perceived, float(resonant.at({k: 1, w: 7}).changeovers.perceived[0])) == (w, 7.0)


def test_a_formula_is_the_lowest_only_if_the_others_are_proven_to_lie_above() -> None:
    u, v = Symbol("u", real=True), Symbol("v", real=True)
    fixed, moving = Solution(Integer(2), u), Solution(sqrt(4 + sqrt(u) * sqrt(v)), u)
    # sqrt(u) sqrt(v) is real and negative where both are negative.
    below, above = (moving.omega.xreplace({u: i, v: 4 * i}) for i in (-ONE, ONE))
    assert below < 2 < above
    assert lowest_formula([fixed, moving]) is None
    assert lowest_formula([fixed, Solution(sqrt(4 + sqrt(u)), u)]) == 2


def test_a_formula_that_is_0_is_no_changeover() -> None:
    """Re H = k - n - m W is -m W where k = n: negative at every positive frequency."""
    d = hs.distort(m * s**2 + b * s + k - n)
    assert d.changeover("env", {k: Integer(5), n: Integer(1), m: Integer(1), b: ONE}).xreplace({k: 5, n: 1, m: 1}) == 2
    assert d.changeover("env", {k: Integer(5), n: Integer(5), m: Integer(1), b: ONE}) is None


def test_frequencies_below_the_least_double_are_frequencies() -> None:
    tiny = Rational(1, 10**400)
    spring = hs.distort(s**2 + tiny**2)
    assert [x.digits(3) for x in spring.changeovers.environment] == ["1.00E-400"]
    # r_r of a lag is W/(W + w^2): 1/10 at W = w^2/9.
    [crossing] = hs.distort(1 + 0 * s, hs.effects.first_order_lag(tiny)).crossings("real", Rational(1, 10))
    assert crossing.digits(3) == "3.33E-401"


@pytest.mark.parametrize("frequency", [5, 4, 6])
def test_a_long_formula_has_a_value_at_a_resonance_without_damping(frequency: int) -> None:
    """In magnitudes and angles: k - m W has no angle where it is 0, at W = 25."""
    values = {k: 100, m: 4, w: 3, n: 7, zeta: Rational(1, 2), b: 11}
    gains = FILTER, FILTER.xreplace({w: n}), b / (s + b)
    d = hs.distort(m * s**2 + k, *map(series, gains))
    assert d.real.has(atan2)
    H, *factors = (lambdify(s, x.xreplace(values))(1j * frequency) for x in (m * s**2 + k, *gains))
    value = d.real.xreplace({hs.omega: Integer(frequency)}).xreplace(values)
    assert float(value) == pytest.approx((H * (np.prod(factors) - 1)).real, abs=1e-12)
