"""Questions beside the evaluation, asked with other JND regions: answered exactly, or refused in a sentence."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from regions import outside
from sympy import Rational

import haptisym as hs

PAPER = hs.load_scene("fu2019")
ELLIPSE = {"shape": "ellipse", "real": 0.1, "imag": 0.12, "tilt": 0.5}
DIAMOND = {"shape": "diamond", "real": 0.1, "imag": 0.12}
POLYGON = {"shape": "polygon", "corners": [[0.1, 0], [0, 0.1], [-0.1, 0], [0, -0.1]]}
FLOOR = {"real": 0.1, "imag": 0.1, "floor": 15}
SIDED = {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1}
FORMULA = "0.08 + 0.004*omega"


def with_jnd(jnd: Any, **values: Any) -> hs.Scene:
    return hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd).with_values(values)


def change(omega_n: float, omega: float) -> tuple[float, float]:
    """Re and Im of dH/|H_env| of the paper's example with another filter, written out."""
    s = 1j * omega
    H = 1.8 * s**2 + 15 * s + 100
    d = H * (omega_n**2 / (s**2 + omega_n * s + omega_n**2) - 1) / abs(H)
    return d.real, d.imag


@pytest.mark.parametrize("jnd", [ELLIPSE, DIAMOND, {**ELLIPSE, "imag": FORMULA}], ids=["ellipse", "diamond", "formula"])
def test_a_requirement_is_where_a_scan_of_the_band_leaves_the_region(jnd: dict[str, Any]) -> None:
    [span] = hs.require(with_jnd(jnd), "omega_n").feasible
    end = float(span.low.value)  # type: ignore[arg-type]
    band = np.linspace(1e-3, 15, 3001)

    def worst(omega_n: float) -> float:
        return max(outside(jnd, *change(omega_n, w), w) for w in band)

    assert worst(end * (1 + 1e-7)) < 0 < worst(end * (1 - 1e-7))
    assert span.high.value is None


@pytest.mark.parametrize("shape", ["ellipse", "diamond"])
def test_a_free_threshold_of_a_region_is_how_many_times_that_of_one_must_be_enlarged(shape: str) -> None:
    unit = (
        {"shape": shape, "real": 1, "imag": 1, "tilt": 0.5}
        if shape == "ellipse"
        else {"shape": shape, "real": 1, "imag": 1}
    )
    [span] = hs.require(with_jnd(unit), "jnd").feasible
    end = float(span.low.value)  # type: ignore[arg-type]
    scaled = {**unit, "real": end, "imag": end}
    found = max(outside(scaled, *change(80, w), w) for w in np.linspace(1e-3, 15, 3001))
    assert found == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("jnd", [ELLIPSE, FORMULA], ids=["ellipse", "formula"])
def test_slopes_are_those_of_certified_crossings_nearby(jnd: Any) -> None:
    [first, *_] = hs.sensitivity(with_jnd(jnd)).crossings
    for row in first.parameters:
        step = Rational(1, 10**8)
        value = with_jnd(jnd).knobs[row.path].value
        low, high = (
            sum(hs.evaluate(with_jnd(jnd, **{row.path: value * (1 + sign * step)})).crossings[0].omega.bounds(200)) / 2
            for sign in (-1, 1)
        )
        slope = (high - low) / (2 * Fraction(str(value * step)))
        assert float(row.derivative) == pytest.approx(float(slope), rel=1e-9)  # type: ignore[arg-type]


def test_a_disc_keeps_the_laws_of_units_that_the_square_keeps() -> None:
    """Force in other units moves no crossing, time in other units moves all of them alike."""
    [first] = hs.sensitivity(with_jnd(ELLIPSE)).crossings
    e = {x.name: float(x.elasticity) for x in first.parameters}  # type: ignore[arg-type]
    assert e["m"] + e["b"] + e["k"] == pytest.approx(0, abs=1e-14)
    assert e["b"] + 2 * e["k"] + e["omega_n"] == pytest.approx(1, abs=1e-14)


def test_peaks_of_an_ellipse_are_where_it_must_be_enlarged_most() -> None:
    spring = hs.Scene(
        hs.environments.mass_spring_damper(k=100), (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"),), (0, 15),
        {"shape": "ellipse", "real": 0.1, "imag": 0.1},
    )  # fmt: skip
    [peak] = hs.peaks(spring)
    assert (peak.criterion.name, peak.omega.digits(5), peak.ratio.digits(5)) == ("joint", "3.0000", "2.0000")


def test_peaks_of_a_diamond_are_those_of_a_dense_scan() -> None:
    filters = (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9) - 0.2*s/(s^2 + 3*s + 60)"),)
    scene = hs.Scene(hs.environments.mass_spring_damper(1, 3, 20), filters, (0, 15), DIAMOND)
    band = np.linspace(0.01, 14.99, 300001)
    s = 1j * band
    H = s**2 + 3 * s + 20
    d = H * (0.4 * s / (s**2 + 2 * s + 9) - 0.2 * s / (s**2 + 3 * s + 60)) / abs(H)
    times = abs(d.real) / 0.1 + abs(d.imag) / 0.12
    tops = np.flatnonzero((times[1:-1] > times[:-2]) & (times[1:-1] > times[2:])) + 1
    found = hs.peaks(scene)
    assert [float(x.omega) for x in found] == pytest.approx(band[tops], abs=1e-4)
    assert [float(x.ratio) for x in found] == pytest.approx(times[tops], rel=1e-8)


def test_several_environments_take_a_region() -> None:
    family = hs.SceneFamily({"paper": with_jnd(ELLIPSE), "heavy": with_jnd(ELLIPSE, m="3 kg")})
    found = hs.evaluate_all(family)
    alone = [float(hs.evaluate(x).bandwidth or 0) for x in family.scenes.values()]
    assert float(found.bandwidth or 0) == min(alone)
    assert {x.criterion.name for x in found.binding} == {"joint"}


Asked = Callable[[hs.Scene], object]
REFUSED: dict[str, tuple[Asked, list[Any]]] = {
    "effects": (hs.relevance, [ELLIPSE, DIAMOND, POLYGON, FLOOR, SIDED]),
    "sensitivity": (hs.sensitivity, [DIAMOND, POLYGON, FLOOR, SIDED]),
    "require": (lambda s: hs.require(s, "omega_n"), [POLYGON, FLOOR, SIDED]),
    "one limit of a joint region": (lambda s: hs.require(s, "jnd.real"), [ELLIPSE, DIAMOND, POLYGON]),
    "any environment": (lambda s: hs.require(s, "omega_n", any_environment=True), [ELLIPSE, POLYGON, FORMULA]),
    "peaks": (hs.peaks, [POLYGON, FLOOR, SIDED]),
    "a formula of the crossings": (lambda s: hs.derive(s)["p_r"], [ELLIPSE, POLYGON, FORMULA]),
    "a certificate": (lambda s: hs.evaluate(s).certificate(), [ELLIPSE, FORMULA]),
    "a range": (lambda s: s.with_values({"jnd": "0.1 +- 10 %"}), [ELLIPSE, DIAMOND, FLOOR]),
}


@pytest.mark.parametrize("question", REFUSED)
def test_what_a_region_leaves_open_is_refused_and_never_answered_for_the_square(question: str) -> None:
    ask, jnds = REFUSED[question]
    for jnd in jnds:
        with pytest.raises(hs.SceneError) as refused:
            ask(with_jnd(jnd))
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("jnd", [ELLIPSE, DIAMOND, POLYGON, FLOOR, SIDED, FORMULA])
def test_the_disc_inside_a_region_is_where_no_environment_can_be_noticed(jnd: Any) -> None:
    """A filter's change behind environments of all phases: none leaves the region below, all do above."""
    found = hs.evaluate(with_jnd(jnd)).any_environment
    if found is None:  # where more than the length of a change matters
        assert jnd in (FLOOR, SIDED)
        return
    turns = np.exp(1j * np.linspace(0, 2 * np.pi, 721))
    table = jnd if isinstance(jnd, dict) else {"shape": "polygon", "corners": [[a, b] for a, b in (
        (FORMULA, FORMULA), (f"-({FORMULA})", FORMULA), (f"-({FORMULA})", f"-({FORMULA})"), (FORMULA, f"-({FORMULA})")
    )]}  # fmt: skip

    def outside_all(omega: float) -> list[bool]:
        s = 1j * omega
        d = 6400 / (s**2 + 80 * s + 6400) - 1
        return [outside(table, (d * turn).real, (d * turn).imag, omega) > 0 for turn in turns]

    below = float(found.transparent_below)  # type: ignore[arg-type]
    assert not any(outside_all(below * (1 - 1e-9)))
    assert any(outside_all(min(below * 1.02, 15)))
    if found.opaque_above is not None:
        above = float(found.opaque_above)
        assert all(outside_all(above * (1 + 1e-9)))
        assert not all(outside_all(above * 0.98))
