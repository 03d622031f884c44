"""What a fit to a movement reports: published digits, mpmath's quadrature, sums over the lines of a recording, wrong input."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import haptisym as hs

FACTS = {
    "0:15": (99.8347809537, 16.8292036316, 1.60570315029),
    "velocity:1:15": (99.9639491593, 15.5758572891, 1.60745594847),
    "displacement:0:7.978916790174708": (99.9895907186, 14.6074571324, 1.61090746247),
}


@pytest.mark.parametrize("given", FACTS)
def test_the_papers_example(given):
    found = hs.evaluate("fu2019", movement=given).movement
    assert found
    assert [found.perceived[x] for x in "kbm"] == pytest.approx(FACTS[given], rel=1e-11)
    assert [found.environment[x] for x in "kbm"] == pytest.approx((100, 15, 1.8), rel=1e-14)
    assert found.change["m"] == pytest.approx(FACTS[given][2] / 1.8 - 1)


SCENES = {
    "a spring-pot": ("organ-tissue", lambda s: (80 * s ** mpmath.mpf("0.2") + 120) * 50 * mpmath.pi / (s + 50 * mpmath.pi) * mpmath.exp(-s / 500)),
    "a delay": ("delayed-spring", None),
    "a hold": ("virtual-wall", None),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("given", ["0.5:15", "velocity:2:9"])
def test_against_quadrature(name, given):
    scene, felt = SCENES[name]
    scene = hs.load_scene(scene)
    low, high = map(float, given.split(":")[-2:])
    power = -2 if given.startswith("velocity") else 0
    mpmath.mp.dps = 20
    if felt is None:
        f = scene.distortion().compile("certified", of=["real", "imag", "environment_real", "environment_imag"])

        def H(w):
            at = f([float(w)])
            return complex(at.environment_real[0] + at.real[0], at.environment_imag[0] + at.imag[0])

        nodes, weights = np.polynomial.legendre.leggauss(40)
        w = (high + low) / 2 + (high - low) / 2 * nodes
        weights = weights * (high - low) / 2 * w**power
        values = np.array([H(x) for x in w])
        rows = [(weights * w**n).sum() for n in (0, 2, 4)]
        re = [(weights * w**n * values.real).sum() for n in (0, 2)]
        im = (weights * w * values.imag).sum()
    else:

        def integral(g):
            return float(mpmath.quad(lambda x: x**power * g(x), np.linspace(low, high, 5)))

        rows = [integral(lambda x, n=n: x**n) for n in (0, 2, 4)]
        re = [integral(lambda x, n=n: x**n * felt(mpmath.mpc(0, x)).real) for n in (0, 2)]
        im = integral(lambda x: x * felt(mpmath.mpc(0, x)).imag)
    k, minus_m = np.linalg.solve([rows[:2], rows[1:]], re)
    found = hs.evaluate(scene, movement=given).movement
    assert found
    assert [found.perceived[x] for x in "kbm"] == pytest.approx([k, im / rows[1], -minus_m], rel=1e-8)


def test_a_recording_is_fitted_by_its_lines(tmp_path):
    """Two sines: what is reported lies where the fit to two lines with the squares of their amplitudes does."""
    t = np.arange(0, 40 * np.pi, 0.01)
    x = 0.01 * np.sin(5 * t) + 0.005 * np.sin(9 * t)
    path = tmp_path / "hand.csv"
    path.write_text("t [s],x [m]\n" + "\n".join(f"{a:.6f},{b:.9f}" for a, b in zip(t, x, strict=True)))
    found = hs.evaluate("fu2019", movement=str(path)).movement
    assert found
    w, S = np.array([5.0, 9.0]), np.array([1e-4, 25e-6])
    s = 1j * w
    H = (1.8 * s**2 + 15 * s + 100) * 6400 / (s**2 + 80 * s + 6400)
    m = -(H.real[1] - H.real[0]) / (w[1] ** 2 - w[0] ** 2)
    expected = (H.real[0] + m * 25, (S * w * H.imag).sum() / (S * w**2).sum(), m)
    assert [found.perceived[x] for x in "kbm"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    "given", ["5", "15:0", "velocity:0:3", "nope.csv", "a:b", "1 kg:2 kg", "acceleration:1:2", "-1:3"]
)
def test_what_is_no_movement(given):
    with pytest.raises((hs.SceneError, OSError)):
        hs.evaluate("fu2019", movement=given)


def test_a_pole_on_the_band_is_said():
    """A movement across the frequency of a compliance without damping that makes the force infinite."""
    scene = hs.Scene(hs.environments.expression("(s**2 + 4)/(s**2 + 9)", parameters={}), (), (0, 5))
    with pytest.raises(hs.UndecidedError, match="pole"):
        hs.evaluate(scene, movement="0:5")
