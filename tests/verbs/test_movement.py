"""What a fit to a movement reports: against SciPy's quadrature, and least squares over a recording by NumPy.

The closed forms, and the digits of the paper's example: derivation 21_fitted_movement.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import periodogram

import haptisym as hs

NAMES = ("k", "b", "m")


def felt(name, w):
    """H_perc(j w) of some scenes, by hand."""
    s = 1j * w
    if (
        name == "virtual-wall"
    ):  # k + b s by backward difference, one sample late, held; 40 g and 0.8 N s/m of the device
        T = 1e-3
        z = np.exp(s * T)
        D = (400 + 0.4 * (1 - 1 / z) / T) / z
        hold = -np.expm1(-s * T) / (s * T)
        return D * hold + 0.04 * s**2 + 0.8 * s
    if name == "stick-with-friction":
        G = 6400 / (s**2 + 80 * s + 6400)
        return (1.8 * s**2 + 15 * s + 100) * G + 4j * 0.26 / (np.pi * 0.05)
    assert name == "a spring-pot"
    return (200 + 30 * s**0.3) * 40 / (s + 40)


def scene(name):
    if name != "a spring-pot":
        return hs.load_scene(name)
    return hs.Scene(hs.environments.spring_pot(30, "0.3", k=200), (hs.effects.first_order_lag(40),), (0, 20))


def normal_equations(M, X, Y):
    k, minus_m = np.linalg.solve([[M[0], M[2]], [M[2], M[4]]], X)
    return {"k": k, "b": Y / M[2], "m": -minus_m}


@pytest.mark.parametrize("name", ["virtual-wall", "stick-with-friction", "a spring-pot"])
@pytest.mark.parametrize("movement", ["0:12", "3:12", "velocity:1:12"])
def test_a_flat_band_against_quadrature(name, movement):
    """Holds and powers of s from 0 rad/s on, where their formulas are 0/0 or have no derivative."""
    *kind, low, high = movement.split(":")
    low, high, weight = float(low), float(high), -2 if kind else 0

    def moment(f, n):
        return quad(lambda w: f(w) * w ** (n + weight), low, high, epsabs=0, epsrel=1e-10)[0]

    expected = normal_equations(
        {n: moment(lambda _: 1.0, n) for n in (0, 2, 4)},
        [moment(lambda w: felt(name, w).real, n) for n in (0, 2)],
        moment(lambda w: felt(name, w).imag, 1),
    )
    found = hs.evaluate(scene(name), movement=movement).movement
    for x in NAMES:
        assert found.perceived[x] == pytest.approx(expected[x], rel=1e-7)


def test_the_papers_example():
    rows = {
        "0:15": ("99.8347809537", "16.8292036316", "1.60570315029"),
        "velocity:1:15": ("99.9639491593", "15.5758572891", "1.60745594847"),
        "0:7.978916790174708": ("99.9895907186", "14.6074571324", "1.61090746247"),
    }
    for movement, printed in rows.items():
        found = hs.evaluate("fu2019", movement=movement).movement
        assert [f"{found.perceived[x]:.12g}" for x in NAMES] == list(printed)
        assert found.environment == {"k": 100.0, "b": 15.0, "m": 1.8}
    assert found.row()["change"]["m"] == pytest.approx(-0.105, abs=1e-4)


def test_a_recording(tmp_path):
    """By weighted least squares over the lines of SciPy's spectrum, of another form than the normal equations."""
    t = np.linspace(0, 20, 2001)
    x = 0.05 * np.sin(2 * t) + 0.02 * np.sin(5 * t + 1) + 0.01 * np.sin(9 * t)
    path = tmp_path / "hand.csv"
    np.savetxt(path, np.c_[t, x], delimiter=",", header="t,x", comments="")
    f, power = periodogram(x, 1 / (t[1] - t[0]), window="hann", detrend="linear")
    w = 2 * np.pi * f
    own = (w > 0) & (w <= 15)
    w, root = w[own], np.sqrt(power[own])
    s = 1j * w
    H = (1.8 * s**2 + 15 * s + 100) * 6400 / (s**2 + 80 * s + 6400)
    (k, m), *_ = np.linalg.lstsq(root[:, None] * np.stack([np.ones_like(w), -(w**2)], -1), root * H.real)
    [b], *_ = np.linalg.lstsq((root * w)[:, None], root * H.imag)
    found = hs.evaluate("fu2019", movement=path).movement
    assert [found.perceived[x] for x in NAMES] == pytest.approx([k, b, m], rel=1e-6)
    wall = hs.evaluate("virtual-wall", movement=path).movement
    assert (wall.environment["m"], wall.change["m"]) == (0.0, None)  # what rounding leaves is no mass


@pytest.mark.parametrize(
    ("movement", "said"),
    [
        ("15:0", "must go up"),
        ("-1:5", "must go up"),
        ("velocity:0:15", "no end at 0 rad/s"),
        ("acceleration:1:5", "is no movement"),
        ("0 kg:1 kg", "not a frequency"),
        ("nowhere.csv", "no such file"),
    ],
)
def test_what_is_no_movement(movement, said):
    with pytest.raises(hs.SceneError, match=said):
        hs.evaluate("fu2019", movement=movement)


def test_a_pole_on_the_band_has_no_fit():
    resonance = hs.effects.series("a/(s^2 + a)", parameters={"a": 9})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (resonance,), (0, 2))
    with pytest.raises(hs.UndecidedError, match="pole on its band"):
        hs.evaluate(scene, movement="0:5")
