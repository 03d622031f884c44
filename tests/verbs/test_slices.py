"""Where the slices of a map go, and how far lines between them are off: an estimate, held against closed forms."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from sympy import Rational

import haptisym as hs
from haptisym.cli import app
from haptisym.kernel.errors import SceneError

PLANE, RANGES = ["omega_c", "evaluation.jnd"], [(20, 300), ("0.01", "0.6")]


def lag() -> hs.Scene:
    """Behind a lag the imaginary part is W omega_c/(W^2 + omega_c^2) at the end W = 15 of the band, and the real part is less."""
    return hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(50),), (0, 15))


def least(omega_c: np.ndarray) -> np.ndarray:
    return 15 * omega_c / (225 + omega_c**2)


def test_slices_go_where_the_boundary_bends() -> None:
    found = hs.design_map(lag(), PLANE, RANGES)
    steps = [x.high - x.low for x in found.gaps]
    assert len(found.slices) < 20
    assert steps[0] < steps[-1] / 3  # it bends below 60 rad/s
    for x in found.slices:
        assert float(x.requirement.feasible[0].low.value) == pytest.approx(least(x.place), rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("within", ["0.02", "0.5 %", "0.002"])
def test_lines_are_off_by_about_what_is_estimated(within: str) -> None:
    found = hs.design_map(lag(), PLANE, RANGES, within=within)
    for (a, b), gap in zip(pairwise(found.slices), found.gaps, strict=True):
        at = np.linspace(a.place, b.place, 101)
        off = np.abs(np.interp(at, [a.place, b.place], least(np.array([a.place, b.place]))) - least(at)).max()
        assert gap.deviation is not None
        assert off <= 1.1 * gap.deviation
    assert found.deviation is not None
    assert found.within is not None
    assert found.deviation <= float(found.within) * found.height
    assert not found.is_coarse


def test_too_few_slices_are_said_to_be_too_few() -> None:
    found = hs.design_map(lag(), PLANE, RANGES, slices=5)
    assert (len(found.slices), found.is_coarse) == (5, True)
    assert (
        "as estimated from how its boundary bends at the slices; that is not proven. --slices N gives more"
        in " ".join(str(found).split())
    )


@pytest.mark.slow
@pytest.mark.parametrize("span", [("0.2", "0.5"), ("0.01", "0.6")])
def test_slices_are_too_few_where_lines_may_be_off_by_more_than_the_share_of_the_range_between_its_ends(
    span: tuple[str, str],
) -> None:
    """Not of its high end."""
    coarse = set()
    for within in ("0.01", "0.05", "0.07", "0.12", "0.3"):
        found = hs.design_map(lag(), PLANE, [(20, 100), span], slices=5, within=within)
        assert found.deviation is not None
        assert found.is_coarse is (found.deviation > float(within) * (float(span[1]) - float(span[0])))
        coarse.add(found.is_coarse)
    assert coarse == {False, True}


def test_even_slices_are_as_many_as_are_asked_for() -> None:
    found = hs.design_map(lag(), PLANE, RANGES, slices=8, uniform=True)
    assert [x.at for x in found.slices] == [20 + Rational(280, 7) * i for i in range(8)]
    assert "bends at the slices; that is not proven. --slices N gives more" in " ".join(str(found).split())


def test_slices_that_differ_in_kind_are_near_each_other_and_nothing_is_said_between() -> None:
    """With c = 0.1 nothing will do below some omega_c, and from there on every k."""
    found = hs.design_map(lag(), ["omega_c", "environment.k"], [(20, 300), (10, 1000)])
    [gap] = [x for x in found.gaps if x.deviation is None]
    edge = 15 * (5 + np.sqrt(24))  # W omega_c/(W^2 + omega_c^2) = 1/10
    assert gap.low < edge < gap.high
    assert gap.high - gap.low <= 280 * 0.005
    assert "Between one pair of slices, which differ in kind" in " ".join(str(found).split())


def test_a_delay_that_is_noticed_whatever_the_stiffness_is_decided_beside_its_threshold() -> None:
    """A spring late by tau is noticed where sin(15 tau) > 1/10, whatever k: 1e-6 s beside that all of them are decided."""
    spring = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"),), (0, 15))
    for tau, count in (("6.677 ms", 1), ("6.679 ms", 0)):  # asin(0.1)/15 = 6.67781 ms
        found = hs.require(spring.with_values({"tau": tau}), "environment.k", (10, 1000))
        assert (len(found.feasible), found.undecided) == (count, ())


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"slices": 1}, "slices: 1 must be a whole number, at least 2"),
        ({"slices": 2.5}, "slices: 2.5 must be a whole number"),
        ({"within": 0}, "within: 0 must be > 0"),
        ({"within": "3 N"}, "3 N"),
    ],
)
def test_what_makes_no_sense_is_said(asked: dict[str, object], said: str) -> None:
    with pytest.raises(SceneError, match=said):
        hs.design_map(lag(), PLANE, RANGES, **asked)  # type: ignore[arg-type]


def test_the_command_line_takes_one_way_to_place_slices() -> None:
    plane = ["--free", "zeta", "--free", "omega_n", "--range", "0.4", "0.6", "--range", "50", "500"]
    said = CliRunner().invoke(app, ["require", "fu2019", *plane, "--uniform", "--within", "0.01"])
    assert "leave out one of them" in str(said.exception)
    said = CliRunner().invoke(app, ["require", "fu2019", "--free", "zeta", "--uniform"])
    assert "--uniform is about a map of two parameters" in str(said.exception)
