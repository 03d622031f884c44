"""Polynomials are analytic functions: on every rational scene the certified search for zeros agrees with the exact roots."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest
import strategies
from marks import often
from strategies import Seeded

import haptisym as hs
from haptisym.kernel import factoring
from haptisym.kernel.analytic import AnalyticFactor
from haptisym.kernel.polynomials import PolynomialFactor, polynomial_factors
from haptisym.kernel.wavesums import WaveTerm

RATIONAL = [name for name in hs.scene_names() if not hs.load_scene(name).distortion().perc.ring.functions]


def as_analytic(factor: PolynomialFactor) -> AnalyticFactor:
    """The same function of omega, to be searched like one with delays."""
    rows = [[(0,)] * (factor.step - 1) + [row] for row in factor.coefficients[1:]]
    coefficients = (factor.coefficients[0], *(row for group in rows for row in group))
    return AnalyticFactor((WaveTerm((), (), coefficients),), (), (), ())


@pytest.fixture
def searched(monkeypatch: pytest.MonkeyPatch) -> list[AnalyticFactor]:
    """Sends every polynomial down the other path; the factors that went it."""
    went: list[AnalyticFactor] = []

    def other(factor: PolynomialFactor) -> AnalyticFactor:
        went.append(as_analytic(factor))
        return went[-1]

    def in_factors(coefficients: list[Any], **how: bool) -> tuple[int, int, list[tuple[AnalyticFactor, int]]]:
        sign, lowest, found = polynomial_factors(coefficients, **how)
        return sign, lowest, [(other(f), n) for f, n in found]

    exact = factoring._polynomial_factor
    monkeypatch.setattr(factoring, "polynomial_factors", in_factors)
    monkeypatch.setattr(factoring, "_polynomial_factor", lambda factor: other(exact(factor)))
    return went


def answers(scene: hs.Scene) -> dict[str, Any]:
    return {**hs.evaluate(scene, digits=30).to_dict(), "stable": None}


def both(scene: hs.Scene, request: pytest.FixtureRequest) -> None:
    expected = answers(scene)
    went = request.getfixturevalue("searched")
    fresh = partial(hs.Scene, scene.environment, scene.effects, scene.band, scene.threshold, scene.rendered)
    found = answers(fresh(title=scene.title))
    assert went, "no polynomial went the other path"
    for answer in (expected, found):  # enclosures depend on the way, and both are right
        for crossing in answer["crossings"]:
            del crossing["enclosure"]
    assert found == expected


@pytest.mark.parametrize("name", RATIONAL)
def test_both_paths_agree_on_every_shipped_rational_scene(name: str, request: pytest.FixtureRequest) -> None:
    both(hs.load_scene(name), request)


@pytest.mark.few(7)
@pytest.mark.parametrize("seed", often(range(120), lambda seed: seed < 30))
def test_both_paths_agree_on_random_rational_scenes(seed: int, request: pytest.FixtureRequest) -> None:
    both(strategies.scene(strategies.case(Seeded(1000 + seed), order=3)), request)
