"""Bandwidths of growing thresholds, local maxima of regions, and poles that passivity allows: against dense samples and sums of known parts."""

from __future__ import annotations

import random
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, exp, lambdify

import haptisym as hs
from haptisym.judge.bandwidths import _lower
from haptisym.judge.climb import Bandwidths, Climb, Jump
from haptisym.judge.criteria import noticed
from haptisym.judge.envelopes import Envelope
from haptisym.judge.peaks import greatest, largest, tops
from haptisym.judge.positivereal import has_no_pole_right, poles_allow, power
from haptisym.judge.regions import Term
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.roots import chart
from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s

SEEDS = range(20)
AXIS = Ring().axis
CRITERIA = noticed(hs.load_scene("fu2019").threshold)
GRID = np.linspace(1.0, 9.0, 8001)
BAND = (Integer(1), Integer(9))


def real(x: Expr) -> RealFunction:
    return RealFunction(AXIS.convert(x).reduced())


def samples(x: Expr) -> Any:
    return np.broadcast_to(lambdify(w, x, "numpy")(GRID), GRID.shape)


def hill(draw: random.Random) -> Expr:
    """A square of a ratio: a slope with resonances."""
    found = Rational(draw.randint(1, 9), 10) + w * Rational(draw.randint(-1, 6), 20)
    for _ in range(draw.randint(1, 2)):
        at, size = Rational(draw.randint(9, 80), 8), Rational(draw.randint(2, 20), 10)
        found += size / (1 + 4 * (w - at) ** 2)
    return found.together() ** 2


@pytest.mark.few("0", "5")
@pytest.mark.parametrize("seed", SEEDS)
def test_bandwidths_of_a_growing_threshold_are_those_of_samples_less_the_jumps(seed: int) -> None:
    draw = random.Random(seed)
    own = [hill(draw) for _ in range(draw.choice([1, 2]))]
    low, high = sorted(Rational(n, 10) for n in draw.sample(range(5, 40), 2))
    found = Climb(dict(zip(CRITERIA, map(real, own), strict=False)), (low, high), BAND, "jnd").found
    top = np.sqrt(np.maximum.accumulate(np.max([samples(x) for x in own], axis=0)))

    def bandwidth(c: float) -> float | None:
        return None if top[0] > c else float(GRID[np.searchsorted(top, c, side="right") - 1])

    values = [(c, bandwidth(c)) for c in np.linspace(float(low), float(high), 400)]
    given = [x for _, x in values if x is not None]
    most = bandwidth(float(high))
    assert (found.most is None) == (most is None)
    if found.most is None or most is None or found.least is None:
        assert not given
        return
    assert abs(float(found.most) - most) < 0.01
    start = bandwidth(float(low))
    if start is not None:
        assert found.blocked == {}
        assert abs(float(found.least) - start) < 0.01
    else:
        [(name, least)] = found.blocked.items()
        assert name == "jnd"
        assert abs(float(least) - top[0]) < 1e-3
        assert float(found.least) <= min(given) + 0.01
    assert all(not float(x.low) + 0.005 < y < float(x.high) - 0.005 for x in found.jumps for y in given)
    assert [float(x.low) for x in found.jumps] == sorted(float(x.low) for x in found.jumps)
    for x in found.jumps:
        assert x.threshold is not None
        c = float(x.threshold)
        before, after = bandwidth(c * 0.999999), bandwidth(c * 1.000001)
        assert before is not None
        assert after is not None
        assert abs(after - float(x.high)) < 0.01
        assert abs(before - float(x.low)) < 0.02
    gaps = sum(b - a > 0.3 for a, b in pairwise([float(found.least), *given]))
    assert (
        gaps <= sum(float(x.high) - float(x.low) > 0.2 for x in found.jumps)
        or len(given) < 20
        or max(np.diff(top)) < 1e-3
    )


def number(x: int) -> ExactNumber:
    return ExactNumber(Integer(x))


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_smaller_of_two_bandwidths_is_any_of_either_up_to_what_the_other_reaches(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        each = []
        for _ in range(2):
            cuts = sorted(draw.sample(range(40), draw.choice([2, 4, 6])))
            jumps = tuple(Jump(number(a), number(b)) for a, b in zip(cuts[1:-1:2], cuts[2:-1:2], strict=True))
            each.append(Bandwidths(number(cuts[0]), number(cuts[-1]), jumps))

        def has(x: Bandwidths, at: float) -> bool:
            assert x.least is not None
            assert x.most is not None
            return float(x.least) <= at <= float(x.most) and not any(
                float(j.low) <= at < float(j.high) for j in x.jumps
            )

        found = _lower(*each)
        a, b = each
        for at in (n / 2 for n in range(-1, 82)):
            reaches = [at <= float(x.most) for x in each if x.most is not None]
            true = any(has(x, at) and other for x, other in ((a, reaches[1]), (b, reaches[0])))
            assert has(found, at) == true or at in (float(j.low) for x in each for j in x.jumps), (each, at)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_maxima_of_what_counts_are_those_of_samples(seed: int) -> None:
    draw = random.Random(seed)
    terms, counted = [], np.full(GRID.shape, -np.inf)
    for _ in range(draw.randint(1, 3)):
        squares = [hill(draw) for _ in range(draw.randint(1, 2))]
        where = [] if draw.random() < 0.6 else [draw.choice([1, -1]) * (w - Rational(draw.randint(16, 64), 8))]
        terms.append(Term(tuple(map(real, where)), tuple(map(real, squares))))
        own = np.min([samples(x) for x in squares], axis=0)
        holds = np.all([samples(x) > 0 for x in where], axis=0) if where else np.full(GRID.shape, True)  # noqa: FBT003
        counted = np.where(holds, np.maximum(counted, own), counted)
    envelope = Envelope(CRITERIA[0], tuple(terms))
    table = chart(envelope.functions(), *BAND)
    places = [(float(p.omega), top) for p in table.points[1:-1] if (top := envelope.top(p))]
    inside = np.isfinite(counted)
    rises = [
        counted[i] - counted[i - 1]
        if inside[i] and inside[i - 1]
        else (np.inf if inside[i] else -np.inf if inside[i - 1] else 0)
        for i in range(1, len(GRID))
    ]
    true = [
        GRID[i]
        for i in range(2, len(GRID) - 2)
        if rises[i - 1] > 0 > rises[i] and abs(rises[i - 1]) < 1 > abs(rises[i])
    ]
    smooth = [x for x, top in places if not top.jump]
    for x in smooth:
        assert min(abs(x - y) for y in true) < 0.003
    for y in true:
        assert min(abs(x - y) for x, _ in places) < 0.003
    for x, top in places:
        f = lambdify(w, top.square.expression(), "numpy")
        near = counted[np.abs(GRID - x) < 0.0021]
        assert abs(f(x) - near[np.isfinite(near)].max()) < 0.02


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_largest_value_on_a_band_is_that_of_samples(seed: int) -> None:
    draw = random.Random(seed)
    x = hill(draw) - hill(draw) + Rational(draw.randint(-9, 9), 3)
    f, own = real(x), samples(x)
    top = largest(f, *BAND)
    assert top is not None
    assert abs(float(top) - own.max()) < 1e-3
    best = greatest(f, *BAND)
    assert best is not None
    assert best.omega is not None
    assert abs(float(best.value) - own.max()) < 1e-3
    assert abs(float(lambdify(w, x)(float(best.omega))) - own.max()) < 1e-3
    listed = tops(f, *BAND)
    assert listed is not None
    assert [t.end for t in listed if t.end is not None] == [False, True]
    inside = [GRID[i] for i in range(1, len(GRID) - 1) if own[i - 1] < own[i] > own[i + 1]]
    told = [float(t.omega) for t in listed if t.end is None]
    assert len(told) == len(inside)
    assert np.allclose(told, inside, atol=0.002)
    for sign, bound in ((1, None), (-1, 0)):
        pole = real(x + sign / (w - 4) ** 2)
        assert largest(pole, *BAND) is None
        assert (greatest(pole, *BAND) is None) == (bound is None)
        one_sided = real(x + sign / (w - 4))
        assert greatest(one_sided, *BAND) is None
        assert (
            greatest(one_sided, Integer(4), Integer(9)) is None
            if sign > 0
            else greatest(one_sided, Integer(1), Integer(4)) is None
        )
        low, high = (1, 4) if sign > 0 else (4, 9)
        beside = greatest(one_sided, Integer(low), Integer(high))  # it falls without bound at one end
        assert beside is not None
        at = np.linspace(low, high, 20_001)[slice(0, -1) if sign > 0 else slice(1, None)]
        assert abs(float(beside.value) - lambdify(w, x + sign / (w - 4))(at).max()) < 1e-3


# What no passive hand can drive


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_sums_of_masses_dampers_springs_and_resonators_have_poles_that_passivity_allows_and_one_wrong_part_has_not(
    seed: int,
) -> None:
    draw = random.Random(seed)

    def some() -> Rational:
        return Rational(draw.randint(1, 20), draw.randint(1, 9))

    good = some() + some() * s
    good += draw.choice([Integer(0), some() * s**2])
    for _ in range(draw.randint(0, 2)):
        k, b = some(), some()
        good += draw.choice([k * s / (k + b * s), k * s**2 / (s**2 + some()), k * s**2 / (s**2 + b * s + some())])
    ring = Ring.of([s])

    def allowed(x: Expr) -> bool | None:
        return poles_allow(ring.convert(x.together()).reduced())

    assert allowed(good)
    assert has_no_pole_right(ring.convert(good.together()).reduced())
    a, b = some(), some()
    wrong = [
        -a * s**2 / (s**2 + b + 100), a * s / (s**2 + b + 100), a / (s - b), a * s**3, -some() * s**2 - 1000 * s**2, -good - a, a / s, a / (s**2 + 100) ** 2,
        -1000 + a, a * s / ((s - b) ** 2 + 1),
    ]  # fmt: skip
    for x in wrong:
        assert allowed((good + x).together()) is False, x
    right = ring.convert((good + a / ((s - b) * (s + 1))).together()).reduced()
    assert has_no_pole_right(right) is False


def test_the_highest_power_of_omega_counts_broken_powers_and_not_angles() -> None:
    for x, high in (
        (s**2 * s ** Rational(1, 2) + s**2 * exp(-s), Rational(5, 2)),
        (s ** Rational(1, 3) + 3, Rational(1, 3)),
        (s**3 * exp(-s / 2) + s, Integer(3)),
    ):
        raw = on_axis(Ring.of([x]).convert(x)).raw_real
        own = power(raw.numerator, raw) - power(raw.denominator, raw)
        assert own == high
