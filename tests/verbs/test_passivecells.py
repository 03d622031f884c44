"""For which values every passive hand may hold a display with delays or powers of s: against conditions by hand, and single verdicts."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Integer, Rational

import haptisym as hs
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import values
from haptisym.verbs.require.energy import Energy
from haptisym.verbs.require.energyterms import Term
from haptisym.verbs.require.passivecells import _span

LATE = hs.Scene(
    hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"), hs.effects.shunt(m="0.1 kg", b="1 N*s/m"))
)
TISSUE = hs.Scene(
    hs.environments.spring_pot(k_alpha=20, alpha="0.5", k=100),
    (hs.effects.first_order_lag(80), hs.effects.shunt(b="1 N*s/m")),
)


def ends(r: Any) -> list[tuple[float | None, float | None]]:
    return [tuple(None if e.value is None else float(e.value) for e in (x.low, x.high)) for x in r.feasible]  # type: ignore[misc]


@pytest.mark.parametrize(
    ("free", "span"),
    [
        ("environment.k", (0, 200)),
        ("effects.shunt.b", (0.5, None)),
        ("effects.shunt.m", (0, None)),
        pytest.param("tau", (0, 0.01), marks=pytest.mark.slow),
    ],
)
def test_a_late_spring_is_passive_where_its_damper_makes_up_for_the_delay(free: str, span: Any) -> None:
    """b omega - k sin(omega tau) >= 0 for all omega: k tau <= b, ends included; no mass changes that, and none below 0 will do."""
    r = hs.require(LATE, free, that="passive")
    [found] = ends(r)
    assert [x for x in found if x is not None] == pytest.approx([x for x in span if x is not None], rel=1e-15)
    assert (found[1] is None) is (span[1] is None)
    turned = [x for x in r.ends if x.bindings]
    if free == "effects.shunt.m":
        assert not turned
        assert [(a, float(b)) for a, b in r.undecided if b] == [(None, -100)]  # a thousand times its value
    else:
        [end] = turned
        assert end.closed
        assert [(b.kind.value, float(b.omega)) for b in end.bindings if b.omega] == [("start", 0.0)]


def test_what_is_not_shown_is_said_to_be_open() -> None:
    r = hs.require(LATE, "tau", that="passive")
    assert [(float(a), b) for a, b in r.undecided if a] == [(5.0, None)]  # a thousand times its value
    assert not r.certified
    lossless = hs.require("wave-variable-link", "environment.m", that="passive")
    assert not lossless.feasible
    assert "too near to 0" in str(lossless)


@pytest.mark.parametrize("free", ["omega_c", pytest.param("environment.k_alpha", marks=pytest.mark.slow)])
def test_a_lagging_tissue_is_told_but_for_a_sliver_at_each_end(free: str) -> None:
    r = hs.require(TISSUE, free, (1, 1000), that="passive")
    [span] = r.feasible
    assert sum(float(b) - float(a) for a, b in r.undecided if a and b) < 0.2
    for at in np.linspace(1, 1000, 23).tolist() + [
        float(x) * y for x in (span.low.value, span.high.value) if x for y in (0.98, 1.02)
    ]:
        value = Rational(str(round(at, 6)))
        if not 1 <= value <= 1000:
            continue
        holds = hs.stability(TISSUE.with_values({free: value})).every_passive_hand.holds
        assert span.low.value is not None
        assert span.high.value is not None
        assert holds is (float(span.low.value) <= at <= float(span.high.value))


def test_friction_beside_a_delay_stays_open() -> None:
    rough = hs.Scene(
        hs.environments.mass_spring_damper(k=100),
        (hs.effects.delay("5 ms"), hs.effects.coulomb_friction("1 N", "1 cm")),
    )
    r = hs.require(rough, "environment.k", that="passive")
    assert (r.feasible, len(r.undecided)) == ((), 1)
    assert "friction" in str(r)


def test_a_pole_on_the_right_is_no_passivity_though_the_axis_shows_none() -> None:
    """-5/(s - 1) + ...: Im H > 0 at all frequencies, and a pole at 1."""
    lively = hs.environments.expression("k + 3*s + 5*s/(s - 1)", parameters={"k": "50 N/m"})
    found = hs.Scene(lively, (hs.effects.delay("1 ms"), hs.effects.shunt(b="100 N*s/m")))
    r = hs.require(found, "environment.k", (10, 100), that="passive")
    assert (r.feasible, len(r.undecided)) == ((), 1)


@pytest.mark.parametrize("seed", [2, *(pytest.param(n, marks=pytest.mark.slow) for n in range(3, 12))])
def test_single_verdicts_agree_with_the_cells(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, b, k, w, tau, B = (Rational(int(x), 100) for x in rng.integers(1, 2000, 6))
    late = hs.Scene(
        hs.environments.mass_spring_damper(b=b / 10, k=k),
        (hs.effects.first_order_lag(w * 20), hs.effects.delay(tau / 1000), hs.effects.shunt(m=m / 100, b=B / 10)),
    )
    free = ("environment.k", "environment.b", "omega_c", "effects.shunt.b")[seed % 4]
    at = late.knobs[free].value
    r = hs.require(late, free, (at / 10, at * 10), that="passive")
    for share in (2, 3, 8, 15, 40, 90):
        value = at * Rational(share, 10)
        if any(a is not None and b is not None and float(a) <= value <= float(b) for a, b in r.undecided):
            continue
        inside = any(
            float(s.low.value) <= value <= float(s.high.value) for s in r.feasible if s.low.value and s.high.value
        )
        assert hs.stability(late.with_values({free: value})).every_passive_hand.holds is inside


def test_the_function_of_the_cells_has_the_sign_of_the_imaginary_part() -> None:
    for scene, free, span in (
        (LATE, "tau", (0.004, 0.0042)),
        (TISSUE, "omega_c", (60.0, 62.0)),
        (LATE, "environment.k", (150.0, 160.0)),
    ):
        knob = scene.knobs[free]
        form = Energy(
            Distortion.of(scene.chain.at(values(x for x in scene.parameters if x.path != free))).perc, knob.symbol
        )
        for omega in (0.3, 7.0, 90.0, 700.0):
            low, high = form._bounds(np.array([omega]), span)
            for q in span:
                now = scene.with_values({free: q}).distortion().perceived
                s = next(iter(now.free_symbols))
                exact = mpmath.mpmathify(complex(now.subs(s, 1j * omega).evalf(30)).imag)
                assert low[0] * exact > 0 or high[0] * exact > 0 or low[0] <= 0 <= high[0]
                assert (low[0] <= 0) or exact > 0
                assert (high[0] >= 0) or exact < 0


@pytest.mark.parametrize("power", ["999999999/1000000000", "1/2", "13/3", "-7/5", "1000000001/1000000000"])
def test_the_turn_of_a_power_is_known_to_the_last_digits_near_an_odd_one_too(power: str) -> None:
    """cos(pi p/2) is some 1.6e-9 there, of which floats that come from pi p/2 have nine digits."""
    with mpmath.workdps(40):
        angle = mpmath.pi * mpmath.mpf(Rational(power).p) / Rational(power).q / 2
        expected = float(mpmath.cos(angle)), float(mpmath.sin(angle))
    found = Term(Rational(power), Integer(0), Integer(1)).turned
    assert found == pytest.approx(expected, rel=4e-16, abs=0)


@given(st.fractions(), st.fractions())
def test_the_floats_of_a_cell_hold_all_its_values_and_hardly_more(x: Fraction, y: Fraction) -> None:
    low, high = (Rational(z.numerator, z.denominator) for z in sorted((x, y)))
    a, b = (Fraction(z) for z in _span(low, high))
    assert a <= min(x, y) <= max(x, y) <= b
    assert min(x, y) - a <= abs(min(x, y)) * Fraction(1, 1 << 52)
