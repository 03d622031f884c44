"""What passivity says of random displays: held against dense samples of Im H_perc and of Colgate and Schenkel's right-hand side."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, lambdify

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.colgate import sampled_passivity
from haptisym.judge.criteria import noticed
from haptisym.judge.families import moved, nominal_of
from haptisym.judge.passivity import Beyond, passivity
from haptisym.kernel.symbols import s
from haptisym.verbs.require.freeparameter import Domain, domain
from haptisym.verbs.require.guesses import Guesses

SEEDS = range(24)
GRID = np.concatenate([np.logspace(-4, 7, 20_000), np.linspace(0.01, 400, 20_000)])


def display(draw: random.Random) -> hs.Scene:
    def some(low: int = 1, high: int = 50) -> Rational:
        return Rational(draw.randint(low, high), draw.choice([1, 2, 5]))

    environment = draw.choice(
        [
            environments.kelvin_voigt(some(), some()),
            environments.zener(some(), some(), some()),
            environments.mass_spring_damper(some(), some(), some()),
        ]
    )
    listed = [
        effects.first_order_lag(some(5, 90)), effects.second_order_lowpass(some(5, 90), Rational(draw.randint(1, 9), 5)), effects.shunt(m=some(), b=some(), k=some()),
        effects.shunt(b=-some()), effects.compliance(k=some(), b=some()), effects.series("1 + 1/(s + 7)"),
    ]  # fmt: skip
    return hs.Scene(environment, tuple(draw.sample(listed, draw.randint(1, 2))))


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_said_of_a_display_is_what_samples_of_its_energy_show(seed: int) -> None:
    own = display(random.Random(seed))
    found = passivity(own)
    with np.errstate(all="ignore"):
        imag = np.imag(lambdify(s, own.distortion().perc.expression())(1j * GRID))
    inside = float(found.high) >= GRID
    told = np.zeros(GRID.shape, bool)
    edge = np.zeros(GRID.shape, bool)
    for x in found.active:
        low, high = float(x.low.omega), float(x.high.omega)
        told |= (low < GRID) & (high > GRID)
        edge |= (abs(GRID - low) < 1e-3 * (1 + low)) | (abs(GRID - high) < 1e-3 * (1 + high))
    sure = inside & ~edge & (abs(imag) > 1e-9 * GRID)
    assert (told == (imag < 0))[sure].all()
    far = imag[float(found.high) * 1.001 < GRID]
    assert {Beyond.NEVER: (far >= 0).all(), Beyond.ALWAYS: (far < 0).all()}[found.beyond]
    assert found.is_active == bool((imag < -1e-9 * GRID).any())
    rate = -imag / GRID
    needed = found.damping
    if needed is None:
        assert found.is_unbounded or rate[GRID > 1e5].max() >= rate.max() * 0.99
    else:
        assert not found.is_unbounded
        assert abs(float(needed.value) - max(rate.max(), 0)) < 1e-3 * (1 + float(needed.value))
        if needed.omega is not None and float(needed.value) > 0:
            at = float(needed.omega) or 1e-6
            value = -np.imag(complex(lambdify(s, own.distortion().perc.expression())(1j * at))) / at
            assert abs(value - float(needed.value)) < 1e-6 * (1 + abs(value))
    most = found.most_given
    assert most is not None
    assert abs(float(most.value) - (-imag[inside]).max()) < 1e-2 * (1 + abs(float(most.value)))
    assert found.holds is not True or (imag > -1e-9 * GRID).all()


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_damping_that_a_sampled_loop_needs_is_the_largest_right_hand_side(seed: int) -> None:
    draw = random.Random(seed)
    k, b = Rational(draw.randint(1, 40), 2), Rational(draw.randint(1, 40), 9)
    T, late = Rational(1, draw.choice([5, 20, 100])), draw.randint(0, 2)
    method = draw.choice(["backward-difference", "tustin"])
    device = Rational(draw.randint(1, 200), 10)
    own = hs.Scene(
        environments.kelvin_voigt(k, b), (effects.sampled_loop(T, method, late), effects.shunt(m=1, b=device))
    )
    found = sampled_passivity(own)
    assert found is not None
    theta = np.linspace(1e-4, np.pi, 200_001)
    z = np.exp(1j * theta)
    rate = (z - 1) / (float(T) * z) if method == "backward-difference" else 2 / float(T) * (z - 1) / (z + 1 + 1e-18)
    side = float(T) / 2 * np.real((1 - 1 / z) * (float(k) + float(b) * rate) * z**-late) / (1 - np.cos(theta))
    assert found.is_settled == (method == "backward-difference")
    if method == "tustin":
        assert found.passive in (None, False)
        assert "unit circle" in found.row(5)["reason"]
        return
    assert found.needed is not None
    assert found.needed.omega is not None
    top = side.max()
    assert abs(float(found.needed.value) - top) < 1e-5 * (1 + abs(top))
    at = float(found.needed.omega)
    assert abs(np.interp(at, theta, side) - top) < 1e-5 * (1 + abs(top))
    assert found.passive == bool(float(device) > top)
    assert found.hand_needed is not None
    assert abs(float(found.hand_needed) - max(top - float(device), 0)) < 1e-5 * (1 + abs(top))
    told = found.row(5)
    assert (told["T"], told["passive"], "reason" in told) == (float(T), found.passive, False)
    assert told["damping_needed"] == float(found.needed.value)


# Ranges of a JND, and of a parameter


def test_what_moves_apart_in_a_jnd_has_its_range_relative_to_its_own_nominal_value() -> None:
    sided: Any = {"real": {"higher": ["0.1", "0.2"], "lower": ["0.3", "0.6"]}, "imag": "0.5"}
    given: dict[str, tuple[Any, dict[frozenset[str], tuple[str, str]]]] = {
        "alike": (["0.1", "0.3"], {frozenset({"real", "imag"}): ("1/2", "3/2")}),
        "two": (
            {"real": ["0.1", "0.3"], "imag": ["0.2", "0.3"]},
            {frozenset({"real"}): ("1/2", "3/2"), frozenset({"imag"}): ("4/5", "6/5")},
        ),
        "two that are as wide": (
            {"real": ["0.1", "0.3"], "imag": ["0.2", "0.6"]},
            {frozenset({"real"}): ("1/2", "3/2"), frozenset({"imag"}): ("1/2", "3/2")},
        ),
        "two about one number": (
            {"real": ["0.1", "0.3"], "imag": ["0.15", "0.25"]},
            {frozenset({"real"}): ("1/2", "3/2"), frozenset({"imag"}): ("3/4", "5/4")},
        ),
        "two that are alike where one has another limit besides": (
            {"real": {"higher": ["0.1", "0.3"], "lower": "0.2"}, "imag": ["0.1", "0.3"]},
            {frozenset({"real"}): ("1/2", "3/2"), frozenset({"imag"}): ("1/2", "3/2")},
        ),
        "one": ({"real": ["0.1", "0.3"], "imag": "0.2"}, {frozenset({"real"}): ("1/2", "3/2")}),
        "sided": (sided, {frozenset({"real"}): ("2/3", "4/3"), frozenset({"real.lower"}): ("2/3", "4/3")}),
    }
    for jnd, groups in given.values():
        threshold = hs.Scene(environments.kelvin_voigt(1, 1), (), (0, 9), jnd).threshold
        assert {key: tuple(map(str, x)) for key, x in moved(threshold).items()} == groups
    threshold = hs.Scene(environments.kelvin_voigt(1, 1), (), (0, 9), sided).threshold
    assert (nominal_of(threshold, "real"), nominal_of(threshold, "real.lower"), nominal_of(threshold, "imag")) == (
        Rational(3, 20),
        Rational(9, 20),
        Rational(1, 2),
    )


ALLOWED: dict[str, Any] = {
    "effects.shunt.b": lambda x: True, "effects.first-order-lag.omega_c": lambda x: x > 0, "environment.alpha": lambda x: 0 < x < 1,
}  # fmt: skip


@pytest.mark.parametrize("path", ALLOWED)
def test_the_values_that_are_asked_about_are_those_of_the_rule_within_the_range(path: str) -> None:
    own = hs.Scene(environments.spring_pot(5, "1/2"), (effects.shunt(b=2), effects.first_order_lag(9)))
    free = own.knobs[path]

    def holds(x: Domain, at: Fraction) -> bool:
        value: Expr = Rational(at.numerator, at.denominator)
        above = x.low is None or value > x.low or (x.holds_low and value == x.low)
        return bool(above and (x.high is None or value < x.high or (x.holds_high and value == x.high)))

    ends = [Fraction(n, 4) for n in range(-4, 9)]
    for low in ends:
        for high in ends:
            if low >= high:
                with pytest.raises(hs.SceneError):
                    domain(free, (str(low), str(high)))
                continue
            kept = [x for x in (Fraction(n, 8) for n in range(-16, 24)) if low <= x <= high and ALLOWED[path](x)]
            if not kept:
                with pytest.raises(hs.SceneError):
                    domain(free, (str(low), str(high)))
                continue
            found = domain(free, (str(low), str(high)))
            assert [x for x in (Fraction(n, 8) for n in range(-16, 24)) if holds(found, x)] == kept
    whole = domain(free, None)
    assert [holds(whole, Fraction(n, 8)) for n in range(-16, 24)] == [
        ALLOWED[path](Fraction(n, 8)) for n in range(-16, 24)
    ]


def test_guesses_are_about_the_least_of_the_largest_ratio_and_simple() -> None:
    own = hs.Scene(
        environments.kelvin_voigt(100, 1),
        (effects.shunt(b=-3), effects.shunt(m="1/10"), effects.first_order_lag(900)),
        (0, 10),
    )
    free = own.knobs["effects.shunt.b"]
    guesses = Guesses(own, free, domain(free, None), noticed(own.threshold))
    t = np.array([-3.0, -1.0, 0.0, 2.0])
    found = guesses.times(t)
    for value, told in zip(t, found, strict=True):
        omega = np.linspace(0, 10, 4001)[1:]
        changed = free.put(own, Rational(value))
        h, g = (lambdify(s, x.expression())(1j * omega) for x in (changed.distortion().env, changed.distortion().perc))
        ratios = np.maximum(abs(np.real(g - h)), abs(np.imag(g - h))) / abs(h) / 0.1
        assert abs(told - ratios.max()) < 0.02 * told
    best = [*guesses.best()]
    assert best
    fine = np.linspace(-5, 5, 2001)
    least = guesses.times(fine).min()
    assert guesses.times(np.array([float(x) for x in best])).min() <= 1.3 * least
    assert all(x.is_Rational for x in best)
    assert max(Integer(x.q) for x in best) < 1000
