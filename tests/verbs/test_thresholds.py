"""For which thresholds a display is transparent: the largest ratio, against critical values and against a dense scan."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from marks import often
from sympy import Integer, Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.criteria import noticed
from haptisym.model.jnd import Part
from haptisym.verbs.require.criticalvalues import Problem
from haptisym.verbs.require.entry import require
from haptisym.verbs.require.feasible import Kind, Span
from haptisym.verbs.require.freeparameter import conditions, domain
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.solving import allowed

TWO_PEAKS = hs.Scene(environments.mass_spring_damper(k=100), (effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"),), (0, 15))
"""r_r has its peak of 1/5 at 3 rad/s, r_i two of 1/10."""
QUICK = {"fu2019", "sidestick", "undamped-resonance", "helicopter-cyclic", "zener-tissue"}


def _ends(spans: tuple[Span, ...]) -> list[tuple[str | None, bool, str | None, bool]]:
    def text(end: object) -> str | None:
        return None if end.value is None else end.value.digits(12)  # type: ignore[attr-defined]

    return [(text(x.low), x.low.closed, text(x.high), x.high.closed) for x in spans]


def _by_critical_values(scene: hs.Scene, path: str, asked: tuple[object, object] | None) -> tuple[Span, ...]:
    free = scene.knobs[path]
    found = conditions(scene, [free], noticed(scene.threshold))
    return Problem(found, free.symbol, scene.band, domain(free, asked), partial(allowed, scene, free)).solve().feasible  # type: ignore[arg-type]


RATIONAL = [n for n in hs.scene_names() if n in {*QUICK, "two-mass-resonance", "steering-wheel"}]


@pytest.mark.few(
    "fu2019-evaluation.jnd",
    "fu2019-evaluation.jnd.real",
    "fu2019-evaluation.jnd.imag",
    "sidestick-evaluation.jnd.imag",
    "undamped-resonance-evaluation.jnd",
    "undamped-resonance-evaluation.jnd.real",
    "undamped-resonance-evaluation.jnd.imag",
)
@pytest.mark.parametrize("path", ["evaluation.jnd", "evaluation.jnd.real", "evaluation.jnd.imag"])
@pytest.mark.parametrize("name", often(RATIONAL, lambda name: name in QUICK and name != "helicopter-cyclic"))
def test_a_free_threshold_is_what_critical_values_say(name: str, path: str) -> None:
    scene = hs.load_scene(name)
    for asked in (None, ("0.01", "0.05"), ("0.05", "0.9"), (2, 5)):
        assert _ends(require(scene, path, asked).feasible) == _ends(_by_critical_values(scene, path, asked))


@pytest.mark.parametrize(
    ("asked", "ends"),
    [
        ((Rational(1, 10), Rational(1, 5)), [("0.200000000000", True, "0.200000000000", True)]),
        ((Rational(1, 5), Rational(3, 10)), [("0.200000000000", True, "0.300000000000", True)]),
        ((Rational(1, 10), Rational(19, 100)), []),
        ((Rational(1, 4), Rational(3, 10)), [("0.250000000000", True, "0.300000000000", True)]),
        (None, [("0.200000000000", True, None, False)]),
    ],
)
def test_a_range_may_end_at_the_largest_ratio_itself(asked: object, ends: object) -> None:
    assert _ends(require(TWO_PEAKS, "c", asked).feasible) == ends  # type: ignore[arg-type]


def test_what_binds_a_threshold_is_its_peak() -> None:
    [end] = require(TWO_PEAKS, "evaluation.jnd").ends
    assert [(b.part, b.kind, b.omega.digits(8)) for b in end.bindings] == [(Part.REAL, Kind.TOUCH, "3.0000000")]
    [end] = require(TWO_PEAKS, "evaluation.jnd", part=Part.IMAG).ends
    assert [(b.part, b.kind) for b in end.bindings] == [(Part.IMAG, Kind.TOUCH)] * 2  # two peaks of 1/10 each


def test_the_other_threshold_is_kept_or_nothing_helps() -> None:
    """r_i reaches 1/10 and no more, so that c_imag = 0.1 leaves c_real free, and c_imag = 0.09 leaves nothing."""
    assert _ends(require(TWO_PEAKS, "evaluation.jnd.real").feasible) == [("0.200000000000", True, None, False)]
    strict = hs.Scene(TWO_PEAKS.environment, TWO_PEAKS.effects, TWO_PEAKS.band, hs.Threshold("0.5", "0.09"))
    assert require(strict, "evaluation.jnd.real").feasible == ()


def test_no_distortion_needs_no_threshold_and_an_infinite_one_has_none() -> None:
    plain = hs.Scene(environments.mass_spring_damper(k=100), (), (0, 15))
    assert _ends(require(plain, "c").feasible) == [("0", False, None, False)]
    resonant = hs.Scene(environments.mass_spring_damper(m=1, k=100), (effects.shunt(b=1),), (0, 15))
    assert require(resonant, "c").feasible == ()  # H_env is 0 at 10 rad/s, what is felt is not


@pytest.mark.parametrize(
    "name", ["control-stick-in-detail", "delayed-spring", "organ-tissue", "wave-variable-link", "sampled-wall"]
)
def test_a_free_threshold_is_the_largest_ratio_on_a_dense_grid(name: str) -> None:
    scene = hs.load_scene(name)
    low, high = (float(x) for x in scene.band)
    grid = np.linspace(low, high, 4001)[1:]
    sampled = scene.distortion().compile()(grid)
    most = max(float(np.max(sampled.ratio_real)), float(np.max(sampled.ratio_imag)))
    found = require(scene, "evaluation.jnd")
    assert found.certified
    [span] = found.feasible
    assert most <= float(span.low.value) * (1 + 1e-9)  # type: ignore[arg-type]
    assert float(span.low.value) <= most * (1 + 1e-4)  # type: ignore[arg-type]


def test_for_any_environment_the_threshold_is_the_largest_relative_change() -> None:
    """|G - 1| of a first-order lag is omega/sqrt(omega^2 + omega_c^2), largest at the high end: 15/25 for 20 rad/s."""
    scene = hs.Scene(environments.mass_spring_damper(k=100), (effects.first_order_lag(20),), (0, 15))
    found: Requirement = require(scene, "evaluation.jnd", any_environment=True)
    assert _ends(found.feasible) == [("0.600000000000", True, None, False)]
    assert require(scene, "evaluation.jnd", (Rational(3, 5), Integer(1)), any_environment=True).ends == ()
