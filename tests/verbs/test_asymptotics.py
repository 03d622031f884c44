"""Leading terms for fast devices, and how wrong they are at most."""

from __future__ import annotations

import numpy as np
import pytest
from sympy import lambdify, symbols

import haptisym as hs
from haptisym.judge.peaks import largest
from haptisym.verbs.derive.asymptotics import expansion

NAMES = [name for name in hs.scene_names() if name not in ("admittance-display", "control-stick-in-detail")]


def test_a_fast_filter_adds_its_damping_and_takes_inertia_in_proportion() -> None:
    m, b, k, omega_n, zeta = symbols("m b k omega_n zeta", positive=True)
    found = expansion(hs.load_scene("fu2019"))
    assert found.part(hs.Part.REAL) == 2 * b * hs.omega**2 * zeta / omega_n
    assert (found.part(hs.Part.IMAG) - 2 * zeta * hs.omega * (m * hs.omega**2 - k) / omega_n).expand() == 0


def test_each_order_of_a_delayed_spring_is_that_of_the_exponential_series() -> None:
    k, tau = symbols("k tau", positive=True)
    found = expansion(hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"),)), order=5)
    assert found.part(hs.Part.REAL).expand() == -k * (hs.omega * tau) ** 2 / 2 + k * (hs.omega * tau) ** 4 / 24
    x = hs.omega * tau
    assert found.part(hs.Part.IMAG).expand() == (-k * x + k * x**3 / 6 - k * x**5 / 120).expand()


@pytest.mark.few(4)
@pytest.mark.parametrize("name", NAMES)
def test_no_frequency_of_the_band_has_a_larger_error_than_the_bound(name: str) -> None:
    scene = hs.load_scene(name)
    found = expansion(scene)
    values = {p.symbol: p.value for p in scene.parameters}
    low, high = (float(x) for x in scene.band)
    grid = np.append(np.linspace(low, high, 4001)[1:-1] + 1e-7 * high, high)  # beside the undamped resonance
    exact = scene.distortion().compile()(grid)
    modulus = np.hypot(exact.environment_real, exact.environment_imag)
    for part, own in ((hs.Part.REAL, exact.real), (hs.Part.IMAG, exact.imag)):
        terms = lambdify([hs.omega], found.part(part).xreplace(values).evalf(30), "numpy")(grid)
        error = np.max(np.abs(own - terms) / modulus)
        bound = found.bounds[part]
        assert bound is None or error <= float(bound) * (1 + 1e-9)
        assert bound is None or float(bound) == 0 or error > 0.99 * float(bound)  # and the bound is attained


def test_higher_orders_are_closer() -> None:
    scene = hs.load_scene("fu2019")
    errors = [float(expansion(scene, order).bounds[hs.Part.REAL]) for order in range(7)]
    assert all(later < earlier / 9 for earlier, later in zip(errors, errors[3:], strict=False))


def test_a_scene_without_time_constants_has_no_leading_terms() -> None:
    with pytest.raises(hs.SceneError, match="nothing that could be fast"):
        expansion(hs.Scene(hs.environments.mass_spring_damper(k=1), (hs.effects.shunt(m=1),)))


def test_the_largest_value_is_none_where_there_is_a_pole() -> None:
    d = hs.load_scene("undamped-resonance").distortion()
    low, high = hs.load_scene("undamped-resonance").band
    f = hs.load_scene("undamped-resonance").distortion().env_response.real
    assert largest(d.squared_ratios[hs.Part.REAL], low, high) is not None
    assert largest(type(f)(f.axis.one / f.function), low, high) is None
