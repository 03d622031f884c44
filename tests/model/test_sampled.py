"""A controller with a clock: its closed form against sums over samples, its errors, and its way through every verb."""

from __future__ import annotations

import cmath
import json
import pickle
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import I, Integer, Symbol

import haptisym as hs
from haptisym.model.sampled import METHODS, controller
from haptisym.model.scenefile import parse_scene, parse_scenes
from haptisym.verbs.simulate.motions import sine

WALL = hs.environments.kelvin_voigt(500, 3)
S_OF_Z = {
    "backward-difference": lambda z, T: (1 - 1 / z) / T,
    "tustin": lambda z, T: 2 / T * (z - 1) / (z + 1),
    "forward-difference": lambda z, T: (z - 1) / T,
}


def held(H, T: float, method: str, delay: int, omega: float) -> complex:  # type: ignore[no-untyped-def]
    """The witness: the Fourier coefficient at omega of a staircase whose steps are D(z) z^-delay times samples of exp(j omega t)."""
    z = cmath.exp(1j * omega * T)
    step = H(S_OF_Z[method](z, T)) * z**-delay
    pieces = 2000  # of one step: midpoint rule for (1/T) int_0^T exp(-j omega t) dt
    return step * sum(cmath.exp(-1j * omega * T * (i + 0.5) / pieces) for i in range(pieces)) / pieces


@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["backward-difference", "tustin"])
@pytest.mark.parametrize("delay", [0, 1, 3])
@given(part=st.floats(0.01, 0.99))
def test_what_is_felt_is_the_staircase_at_its_own_frequency(method: str, delay: int, part: float) -> None:
    T = 0.004
    omega = part * pi / T
    perceived = hs.distort(WALL, hs.effects.sampled_loop("4 ms", method, delay)).perceived
    found = complex(perceived.subs(hs.s, I * omega).evalf(30))
    expected = held(lambda s: 500 + 3 * s, T, method, delay, omega)
    assert found == pytest.approx(expected, rel=1e-5)


def test_a_spring_is_rendered_alike_by_all_methods() -> None:
    spring = hs.environments.mass_spring_damper(k=500)
    felt = {hs.distort(spring, hs.effects.sampled_loop("4 ms", method)).perceived for method in METHODS}
    assert felt == {hs.distort(spring, hs.effects.zero_order_hold("4 ms")).perceived}


def test_a_damper_by_backward_difference_is_k_plus_b_over_T_less_one_sample_old_b_over_T() -> None:
    T, k, b = hs.symbols("T k b")
    scene = hs.Scene(hs.environments.kelvin_voigt(k, b), (hs.effects.sampled_loop(T, "backward-difference", 1),))
    D = controller(scene.effects[0])
    back = Symbol("z_back")
    assert (D.expression() - (k + b * (1 - back) / T) * back).expand() == 0


def test_what_is_left_without_the_clock_is_the_environment() -> None:
    """With the loop removed nothing is left of it: dH of the rest is that of a scene that never had it."""
    scene = hs.Scene(WALL, (hs.effects.sampled_loop("4 ms", "tustin"), hs.effects.shunt(m="0.1")))
    rest = scene.chain.perceived([1]).expression()
    assert rest == hs.Scene(WALL, (hs.effects.shunt(m="0.1"),)).chain.perceived([0]).expression()


@pytest.mark.few(2)
@pytest.mark.parametrize("method", ["backward-difference", "tustin"])
@pytest.mark.parametrize("rendered", ["k + b*s", "k + b*s*w/(s + w)"])
def test_the_simulated_clock_agrees_with_the_closed_form(method: str, rendered: str) -> None:
    """The difference equation in time, sample by sample, knows no exp(-s T)."""
    wall = hs.environments.expression(
        rendered, parameters={"k": 500, "b": 3, **({"w": 300} if "w" in rendered else {})}
    )
    run = hs.simulate(
        hs.Scene(wall, (hs.effects.sampled_loop("10 ms", method, 1), hs.effects.shunt(m="0.1"))), sine("1 cm", 20)
    )
    assert run.agrees
    assert run.built == ("sampled-loop", "shunt")


SCENE = """
[environment]
model = "mass-spring-damper"
k = 500
b = 3
{more}
[[effects]]
name = "loop"
model = "sampled-loop"
{loop}
"""
GOOD = 'T = "1 ms"\nmethod = "tustin"\n'


def wrong(more: str = "", loop: str = GOOD) -> str:
    with pytest.raises(hs.SceneError) as error:
        parse_scene(SCENE.format(more=more, loop=loop))
    assert "\n" not in str(error.value).strip()
    return str(error.value)


def test_each_mistake_has_one_sentence() -> None:
    assert 'T: "0 ms" must be > 0' in wrong(loop='T = "0 ms"\nmethod = "tustin"')
    assert "valid are backward-difference, tustin, forward-difference" in wrong(loop='T = "1 ms"\nmethod = "euler"')
    assert "did you mean" in wrong(loop='T = "1 ms"\nmethod = "tustinn"')
    assert "parameter method is missing" in wrong(loop='T = "1 ms"')
    assert 'delay: "0.5" must be a whole number from 0 to 100' in wrong(loop=GOOD + "delay = 0.5")
    assert "must be a whole number" in wrong(loop=GOOD + "delay = -1")
    assert "must be a whole number" in wrong(loop=GOOD + "delay = [0, 2]")
    first = '[[effects]]\nname = "device"\nmodel = "shunt"\nm = 0.1\n'
    assert "effects.loop: a sampled-loop must be the first effect" in wrong(more=first)
    another = '\n[[effects]]\nname = "other"\nmodel = "{}"\nT = "2 ms"\n'
    assert "effects.other: a second clock beside loop" in wrong(loop=GOOD + another.format("zero-order-hold"))
    assert "a second clock beside loop" in wrong(loop=GOOD + another.format("sampled-loop") + 'method = "tustin"')
    early = '[[effects]]\nname = "other"\nmodel = "zero-order-hold"\nT = "2 ms"\n'
    assert "a second clock beside loop" in wrong(more=early)
    assert "effects.loop: forward-difference makes D(z) improper" in wrong(
        loop='T = "1 ms"\nmethod = "forward-difference"'
    )
    bent = '[rendered]\nmodel = "spring-pot"\nk_alpha = 80\nalpha = 0.5\n'
    assert "effects.loop: a difference equation needs dynamics that are rational in s" in wrong(more=bent)


def test_forward_difference_renders_what_is_proper() -> None:
    scene = hs.Scene(hs.environments.maxwell(100, 5), (hs.effects.sampled_loop("1 ms", "forward-difference"),))
    assert abs(complex(scene.distortion().perceived.subs(hs.s, 20j).evalf()) - (50 + 50j)) < 1


def test_a_change_of_a_value_changes_what_is_rendered() -> None:
    scene = parse_scene(SCENE.format(more="", loop=GOOD))
    other = scene.with_values({"environment.k": 200, "effects.loop.T": "2 ms"})
    assert (
        other.distortion().perceived
        == hs.distort(
            hs.environments.mass_spring_damper(k=200, b=3), hs.effects.sampled_loop("2 ms", "tustin")
        ).perceived
    )


def test_it_stays_a_clock_in_a_family_and_in_a_copy() -> None:
    text = SCENE.format(more="", loop=GOOD).replace("[environment]", '[[environments]]\nname = "a"')
    text = text.replace(
        "[[effects]]", '[[environments]]\nname = "b"\nmodel = "kelvin-voigt"\nk = 90\nb = 1\n[[effects]]', 1
    )
    family = parse_scenes(text)
    felt = [scene.distortion().perceived for scene in family.scenes.values()]
    assert len(set(felt)) == 2
    scene = family.scenes["b"]
    assert pickle.loads(pickle.dumps(scene)).distortion().perceived == scene.distortion().perceived


@pytest.mark.slow
def test_answers_of_other_verbs_hold_the_clock() -> None:
    scene = hs.Scene(
        WALL, (hs.effects.sampled_loop("4 ms", "backward-difference", 1, name="loop"),), (Integer(0), Integer(60))
    )
    found = hs.evaluate(scene)
    assert found.certified
    assert found.crossings
    omega = float(found.crossings[0].omega)
    z = held(lambda s: 500 + 3 * s, 0.004, "backward-difference", 1, omega) - (500 + 3j * omega)
    part = abs(z.real) if found.crossings[0].part.value == "real" else abs(z.imag)
    assert part / abs(500 + 3j * omega) == pytest.approx(0.1, rel=1e-5)
    assert json.loads(hs.require(scene, "environment.b").to_json())["schema"] == "haptisym.requirement/1"
    assert "loop" in str(hs.relevance(scene))
