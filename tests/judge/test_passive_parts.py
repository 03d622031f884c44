"""Displays of parts that only take energy, clocks that sample a spring's force, and clocks in which imposed motion gains energy."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from sympy import Rational
from windings import winding

import haptisym as hs
from haptisym.judge.imposed import force_is_stable
from haptisym.judge.passivity import passivity
from haptisym.kernel.rootcount import RootChain
from haptisym.verbs.stability.held import held

LINK = hs.effects.wave_variables(10, "20 ms", name="link")
SECOND = hs.effects.wave_variables(10, "20 ms", name="second")
DEVICE = hs.effects.shunt(m=1, b=1, name="device")
TORSION = hs.effects.compliance(k=5000)
OBJECT = hs.environments.mass_spring_damper("0.5 kg", "4 N*s/m", "300 N/m")
HOLD = hs.effects.zero_order_hold("1 ms")


@pytest.mark.parametrize("effects", [(LINK,), (LINK, DEVICE), (LINK, DEVICE, SECOND), (LINK, TORSION)])
def test_what_is_made_of_passive_parts_suits_every_passive_hand(effects: tuple[hs.Effect, ...]) -> None:
    scene = hs.Scene(OBJECT, effects)
    found = passivity(scene)
    assert found.holds is True
    assert force_is_stable(scene, scene.distortion()) is True
    s = 1j * np.geomspace(1e-2, 1e4, 20_001)  # the chain multiplied out in floats
    F, X = 0.5 * s**2 + 4 * s + 300, np.ones_like(s)
    for effect in effects:
        if effect.model == "wave-variables":
            c, t = np.cosh(s * 0.02), np.sinh(s * 0.02)
            F, X = c * F + 10 * s * t * X, t / (10 * s) * F + c * X
        elif effect.model == "shunt":
            F = F + (s**2 + s) * X
        else:
            X = X + F / 5000
    assert (np.imag(F / X) > -1e-6 * np.abs(F / X)).all()


def test_an_active_part_proves_nothing_by_parts() -> None:
    lighter = hs.effects.shunt(m=-2, name="lighter")
    assert not passivity(hs.Scene(OBJECT, (LINK, lighter))).has_passive_parts
    assert not passivity(hs.Scene(OBJECT, (hs.effects.delay("1 ms"),))).has_passive_parts
    assert not passivity(hs.Scene(hs.environments.expression("-s"), (DEVICE,))).has_passive_parts


@pytest.mark.parametrize("own", [{"k": 100}, {"m": 2}, {"m": "1/2", "k": 40}])
@pytest.mark.parametrize("behind", [(), (TORSION,)])
def test_a_lossless_display_is_not_stable_as_its_poles_lie_on_the_axis(
    own: dict[str, Any], behind: tuple[hs.Effect, ...]
) -> None:
    """A spring behind a line without losses rings for ever; where, it is seen by the sign of a real function."""
    scene = hs.Scene(hs.environments.mass_spring_damper(**own), (LINK, *behind))
    assert force_is_stable(scene, scene.distortion()) is False
    assert passivity(scene).holds is True
    omega = np.linspace(1e-3, 60 * np.pi, 100_001)
    F, X = (lambda m=0, k=0: float(Rational(k)) - float(Rational(m)) * omega**2)(**own), np.ones_like(omega)
    c, t = np.cos(0.02 * omega), np.sin(0.02 * omega)
    F, X = c * F - 10 * omega * t * X, t / (10 * omega) * F + c * X
    X = X + F / 5000 if behind else X
    found = hs.stability(scene)
    assert ((X[1:] * X[:-1] < 0) & (np.abs(F[1:]) > 0)).any()
    assert "H_perc has poles on the imaginary axis" in str(found)
    assert (found.imposed.stable, found.imposed.unstable, found.certified) == (False, None, True)


@pytest.mark.parametrize("k", [0, 20])
@pytest.mark.parametrize("alpha", ["1/2", "0.3", "2/3"])
def test_a_spring_pot_behind_a_line_is_stable_as_it_damps_at_every_frequency(alpha: str, k: int) -> None:
    scene = hs.Scene(hs.environments.spring_pot(80, alpha, k=k), (LINK,))
    found = hs.stability(scene).imposed
    assert (found.stable, found.chain) == (True, RootChain.NEAR)
    order = float(Rational(alpha))

    def poles(s: Any, lib: Any = np) -> Any:
        return 10 * s * lib.cosh(0.02 * s) + (k + 80 * s**order) * lib.sinh(0.02 * s)

    assert winding(lambda s: poles(s + 1e-6) / (s + 1e-6), 1000.0) == 0
    for n in range(8):  # of the chain, near the zeros of cosh
        near = mpmath.findroot(lambda s: poles(s, mpmath), mpmath.mpc(-1, (n + 0.5) * np.pi / 0.02))
        assert near.real < 0


def test_what_damps_nowhere_or_only_without_the_line_is_not_called_stable_by_its_parts() -> None:
    still = hs.Scene(hs.environments.expression("100"), (LINK,))
    assert force_is_stable(still, still.distortion()) is False
    gives = hs.Scene(hs.environments.spring_pot(80, "1/2"), (LINK, hs.effects.delay("20 ms")))
    assert force_is_stable(gives, gives.distortion()) is not True


def test_the_shipped_wave_variable_link_is_decided() -> None:
    found = hs.stability("wave-variable-link")
    assert (found.imposed.stable, found.imposed.unstable, found.every_passive_hand.holds) == (True, 0, True)
    assert found.certified
    text = " ".join(str(found).split())
    assert "lie in Re s < 0; infinitely many come as near to the imaginary axis as one likes" in text
    assert hs.evaluate("wave-variable-link").stable is True
    held = hs.stability("wave-variable-link", "light-touch")
    assert held.held[0].stable is False
    assert "none of them grows, as all parts only take energy" in " ".join(str(held).split())


@pytest.mark.parametrize("late", [0, 1, 2])
def test_a_clock_that_samples_the_force_of_a_spring_is_colgate_and_schenkel(late: int) -> None:
    """b > K (T/2 + d T): 100 N/m and 1 ms, d samples late."""
    delay = (hs.effects.delay(f"{late} ms"),) if late else ()
    needed = Rational(100) * (Rational(1, 2) + late) / 1000
    for share, holds in ((Rational(101, 100), True), (Rational(99, 100), False)):
        device = hs.effects.shunt(m="0.04 kg", b=needed * share)
        found = passivity(hs.Scene(hs.environments.mass_spring_damper(k=100), (HOLD, *delay, device)))
        assert found.holds is holds
        assert found.sampled is not None
        assert float(found.sampled.needed.value) == pytest.approx(float(needed))  # type: ignore[union-attr]


def test_a_clock_that_gives_energy_to_imposed_motion_does_not_suit_every_passive_hand() -> None:
    """A heavy hand whose spring resonates where Im H_perc < 0 is passive, and shakes."""
    found = hs.stability("sampled-wall")
    assert found.every_passive_hand.holds is False
    assert found.certified
    assert "there is a passive hand in which a motion grows" in " ".join(str(found).split())
    assert held(hs.load_scene("sampled-wall"), hs.Hand("heavy", m=5, k=5 * 1144**2)).stable is False


def test_what_a_filter_made_in_continuous_time_is_said_to_be_open() -> None:
    device = hs.effects.shunt(m="0.04 kg", b="8 N*s/m")
    found = hs.stability(hs.Scene(hs.environments.kelvin_voigt(400, 2), (HOLD, device)))
    assert found.every_passive_hand.holds is None
    assert "made in continuous time from more than the position at that instant" in " ".join(str(found).split())


def test_an_evaluation_says_what_colgate_and_schenkel_prove() -> None:
    text = " ".join(str(hs.evaluate("virtual-wall")).split())
    assert "Every passive hand may hold it: Colgate and Schenkel's condition is met" in text


@pytest.mark.few(1)
@pytest.mark.parametrize("order", ["0.23", "0.5", "1/3"])
def test_spring_pots_of_any_order_are_judged(order: str) -> None:
    """k s^alpha takes energy at every frequency; behind a filter of second order it gives some back."""
    pot: Any = hs.environments.spring_pot(100, order)
    found = hs.stability(hs.Scene(pot, (hs.effects.second_order_lowpass(80, 0.5),)), "light-touch")
    assert found.imposed.stable is True
    assert found.every_passive_hand.holds is False
    assert passivity(hs.Scene(pot, (hs.effects.shunt(m=1, b=1),))).holds is True
