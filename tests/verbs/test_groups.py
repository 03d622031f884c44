"""The dimensionless form says exactly what the scene says, with fewer parameters."""

from __future__ import annotations

import pytest
from marks import QUICK_SCENES, often
from sympy import Rational, sqrt, symbols

import haptisym as hs
from haptisym.verbs.derive.groups import groups

SPRING_MASS = hs.environments.mass_spring_damper


def test_the_papers_five_parameters_become_three_groups() -> None:
    m, b, k, omega_n, zeta = symbols("m b k omega_n zeta", positive=True)
    found = groups(hs.load_scene("fu2019"))
    assert {g.symbol.name: g.value for g in (found.frequency, *found.groups)} == {
        "x": hs.omega * sqrt(m) / sqrt(k), "zeta_env": b / (2 * sqrt(k * m)), "rho": omega_n * sqrt(m) / sqrt(k), "zeta": zeta,
    }  # fmt: skip


@pytest.mark.parametrize("name", often(hs.scene_names(), QUICK_SCENES.__contains__))
def test_the_ratios_of_the_dimensionless_scene_are_the_scenes_own_at_other_values(name: str) -> None:
    """Exact: squares of all units, so that the roots in the groups come out even."""
    scene = hs.load_scene(name)
    found = groups(scene)
    fixed = {
        p.symbol: p.value
        for p in scene.parameters
        if p.symbol in {x for o in scene.chain.ring.orders for x in o.free_symbols}
    }
    numbers = {p.symbol: Rational(n + 2, 3) ** 10 for n, p in enumerate(scene.parameters)} | fixed
    own = scene.chain.steps.at({**numbers, hs.omega: Rational(7, 5) ** 10})
    values = {
        g.symbol: g.value.xreplace({**numbers, hs.omega: Rational(7, 5) ** 10})
        for g in (found.frequency, *found.groups)
    }
    steps = found.chain.at(found.values).steps.at({**values, hs.omega: values[found.frequency.symbol]})
    scale = found.stiffness.xreplace(numbers)
    for key in ("ratio_real", "ratio_imag", "relative_real"):
        assert abs((own[key] - steps[key]).evalf(40)) < 10**-30
    assert abs((own["perceived_real"] - scale * steps["perceived_real"]).evalf(40)) < 10**-25 * abs(
        own["perceived_real"].evalf()
    )


@pytest.mark.few(5)
@pytest.mark.parametrize("name", hs.scene_names())
def test_there_are_as_many_groups_as_buckingham_counts(name: str) -> None:
    scene = hs.load_scene(name)
    found = groups(scene)
    orders = {x for o in scene.chain.ring.orders for x in o.free_symbols}
    assert len(found.groups) == len(scene.parameters) - len(found.units) - len(orders)
    assert len({g.symbol for g in (found.frequency, *found.groups)}) == len(found.groups) + 1
    assert all(g.value.free_symbols <= {p.symbol for p in scene.parameters} for g in found.groups)


def test_there_and_back_is_the_same_formula() -> None:
    scene = hs.load_scene("fu2019")
    found = groups(scene)
    form = found.forwards(found.distortion.relative_imag)
    original = scene.symbolic_distortion().relative_imag
    assert (found.back(form) ** 2 - original**2).together().expand() == 0


def test_units_that_do_not_fit_are_an_error_that_says_so() -> None:
    environment = hs.environments.expression("k + b*s", parameters={"k": "100 N/m", "b": 3})
    with pytest.raises(hs.SceneError, match="give every parameter in it its unit"):
        groups(hs.Scene(environment, (hs.effects.delay("1 ms"),)))


def test_a_scene_without_any_scale_of_time_keeps_omega() -> None:
    found = groups(hs.Scene(SPRING_MASS(k="100 N/m"), (hs.effects.shunt(k="5 N/m"),)))
    assert found.frequency.value == hs.omega
    assert [g.symbol.name for g in found.groups] == ["kappa"]
