"""Controllers as they are in firmware: a difference equation in z against exactly sampled state space, and position loops that are late."""

from __future__ import annotations

import cmath
import math
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refusal
from scipy.linalg import expm

import haptisym as hs
from haptisym_check import RefusedError, check

LOOP = """
[environment]
model = "mass-spring-damper"
b = "2 N*s/m"
k = "500 N/m"
{rendered}
[[effects]]
model = "sampled-loop"
T = "1 ms"
{clock}
[[effects]]
model = "shunt"
m = "0.1 kg"
b = "0.3 N*s/m"
{behind}
[hand]
m = "0.2 kg"
b = "3 N*s/m"
k = "100 N/m"
[evaluation]
band = ["0 Hz", "10 Hz"]
"""
RENDERED = """
[rendered]
model = "difference-equation"
D = "{D}"
parameters = {{ k = "{k} N/m", b = "{b} N*s/m", T0 = "1 ms", a = {a} }}
"""
FILTERED = "k + b/T0*(1 - a)*(1 - 1/z)/(1 - a/z)"


def scene(k: float = 500, b: float = 2, a: float = 0.9, delay: int = 1, D: str = FILTERED) -> hs.Scene:
    return hs.parse_scene(
        LOOP.format(rendered=RENDERED.format(D=D, k=k, b=b, a=a), clock=f"delay = {delay}", behind="")
    )


def eigenvalues(k: float, b: float, a: float, delay: int) -> Any:
    """Of the loop from sample to sample: x, v, the filtered velocity's state, and the forces that are still computed.

    F = k x + b w, w = a w- + (1 - a)(x - x-)/T: the state is x, v, x-, w-, and F of the last samples.
    """
    T, m, d, s = 1e-3, 0.3, 3.3, 100.0
    plant = np.array([[0, 1, 0], [-s / m, -d / m, -1 / m], [0, 0, 0]])
    step = expm(plant * T)[:2]  # of x and v with a force that is held, exact
    size = 4 + delay
    M = np.zeros((size, size))
    w = np.zeros(size)
    w[[0, 2, 3]] = (1 - a) / T, -(1 - a) / T, a
    force = b * w
    force[0] += k
    held = np.eye(size)[size - 1] if delay else force
    M[:2] = step[:, :1] * np.eye(size)[0] + step[:, 1:2] * np.eye(size)[1] + step[:, 2:3] * held
    M[2, 0] = 1
    M[3] = w
    for i in range(delay):
        M[4 + i] = force if i == 0 else np.eye(size)[3 + i]
    return np.linalg.eigvals(M)


@pytest.mark.parametrize(
    ("k", "b", "a", "delay"),
    [(500, 2, 0.9, 1), (2800, 2, 0.9, 1), (2815, 2, 0.9, 1), (500, 60, 0.5, 0), (500, 400, 0.5, 0), (900, 90, 0.3, 2), (50, 4, 0.99, 3)],
)  # fmt: skip
def test_the_poles_of_a_difference_equation_are_those_of_the_exactly_sampled_state_space(
    k: float, b: float, a: float, delay: int
) -> None:
    sizes = np.abs(eigenvalues(k, b, a, delay))
    assert np.abs(sizes - 1).min() > 1e-6
    [held] = hs.stability(scene(k, b, a, delay)).to_dict()["held"]
    assert held["unstable"] == (sizes >= 1).sum()
    assert held["stable"] is not bool((sizes >= 1).any())


def test_limits_of_its_parameters_are_where_a_pole_is_on_the_circle() -> None:
    [held] = hs.stability(scene(), free=["rendered.k", "rendered.b"]).to_dict()["held"]
    found = {(x["path"], x["stable_side"]): x for x in held["critical"]}
    assert found["rendered.k", "above"]["value"] == pytest.approx(-100, rel=1e-12)  # against the hand's spring
    limits = [found["rendered.k", "below"], *(x for (path, _), x in found.items() if path == "rendered.b")]
    for limit in limits:
        values = {"k": 500.0, "b": 2.0, limit["path"].removeprefix("rendered."): limit["value"]}
        at = eigenvalues(values["k"], values["b"], 0.9, 1)
        nearest = at[np.argmin(np.abs(np.abs(at) - 1))]
        assert abs(nearest) == pytest.approx(1, abs=1e-9)
        assert abs(cmath.phase(nearest)) / 1e-3 == pytest.approx(limit["omega"], abs=1e-4)
    required = hs.require(scene(), "rendered.k", that=["stable"]).to_dict()
    assert required["feasible"] == [[pytest.approx(-100), pytest.approx(found["rendered.k", "below"]["value"])]]


def test_a_spring_and_damper_by_the_backward_difference_is_the_same_loop() -> None:
    text = LOOP.format(rendered="", clock='method = "backward-difference"\ndelay = 1', behind="")
    own, other = hs.parse_scene(text), scene(a=0, D="k + b*(1 - 1/z)/T0")
    one, two = ([(c.part, float(c.omega)) for c in hs.evaluate(x).crossings] for x in (own, other))
    assert one == two
    a, b = (hs.stability(x).to_dict() for x in (own, other))
    assert (a["sampled"], a["imposed"]) == (b["sampled"], b["imposed"])


def test_simulated_sample_by_sample_it_agrees_with_its_closed_form_and_fades_as_its_largest_pole() -> None:
    run = hs.simulate(scene(), hs.sine("1 cm", 20))
    assert run.agrees
    largest = max(eigenvalues(500, 2, 0.9, 1), key=abs)
    let_go = hs.release(scene(), "1 cm").to_dict()
    assert str(let_go).count(f"{math.log(abs(largest)) / 1e-3:.4f}"[:6]) >= 1


def test_what_a_clock_felt_below_its_nyquist_frequency_is_the_equation_delayed_and_held() -> None:
    d = scene().distortion()
    for w in (3.0, 40.0, 900.0):
        z, T = cmath.exp(1j * w * 1e-3), 1e-3
        D = 500 + 2 / T * 0.1 * (1 - 1 / z) / (1 - 0.9 / z)
        expected = D / z * (1 - 1 / z) / (1j * w * T) + 0.3j * w - 0.1 * w * w
        assert complex(d.perceived.subs(hs.s, 1j * w).evalf(30)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("rendered", "clock", "behind", "told"),
    [
        (RENDERED.format(D="k", k=1, b=1, a=0), 'method = "tustin"', "", "method: leave it out, as [rendered] is a difference-equation"),
        ("", "", "", "sampled-loop needs method"), (RENDERED.format(D="k*z", k=1, b=1, a=0), "", "", "D needs future samples"),
        (RENDERED.format(D="k*s", k=1, b=1, a=0), "", "", 'unknown name "s"'), (RENDERED.format(D="k*z^0.5", k=1, b=1, a=0), "", "", "rational in z"),
        (RENDERED.format(D="k", k=1, b=1, a=0), "", '[[effects]]\nmodel = "zero-order-hold"\nT = "2 ms"\n', "a second sampler: sampled-loop is the only one"),
    ],
)  # fmt: skip
def test_what_no_controller_computes_is_refused(rendered: str, clock: str, behind: str, told: str) -> None:
    assert told in refusal(hs.parse_scene, LOOP.format(rendered=rendered, clock=clock, behind=behind))


def test_it_stands_behind_a_clock_and_is_never_what_should_be_felt() -> None:
    D = hs.environments.difference_equation("1 - 1/z")
    assert "needs sampled-loop as the first effect" in refusal(hs.Scene, hs.environments.kelvin_voigt(1, 1), rendered=D)
    assert "is for [rendered]" in refusal(hs.Scene, D)


def test_crossings_of_a_difference_equation_are_proven_again_by_the_second_checker(tmp_path: Path) -> None:
    for name, text in (("z", LOOP.format(rendered=RENDERED.format(D=FILTERED, k=500, b=2, a=0.9), clock="delay = 1", behind="")), ("late", LATE)):  # fmt: skip
        path = tmp_path / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        certificate = hs.evaluate(path).certificate()
        other = text.replace("a = 0.9", "a = 0.91").replace("60 1/s", "61 1/s")
        assert "crossings" in check(certificate.encode(), text.encode())
        forged = certificate.replace(*(sha256(x.encode()).hexdigest() for x in (text, other)))
        with pytest.raises(RefusedError, match="not that of the scene"):
            check(forged.encode(), other.encode())


# --- position loops that are late --------------------------------------------------------------------------------------

LATE = """
[environment]
model = "mass-spring-damper"
m = "6 kg"
b = "20 N*s/m"
k = "100 N/m"
[[effects]]
model = "admittance-display"
P = "w^2/(s^2 + 2*z*w*s + w^2)"
parameters = { w = "60 1/s", z = 0.8 }
tau = 0.005
[hand]
m = "0.5 kg"
b = "6 N*s/m"
k = "100 N/m"
[evaluation]
band = ["0 rad/s", "30 rad/s"]
"""


def turns(tau: float) -> int:
    """Zeros of H/P + (0.5 s^2 + 6 s + 100) exp(-s tau) in the right half plane: how often it goes around 0 on a large half circle."""
    corner = 3000.0
    up = 1j * np.concatenate([-np.geomspace(corner, 1e-3, 60000), np.geomspace(1e-3, corner, 60000)])
    arc = corner * np.exp(1j * np.linspace(np.pi / 2, -np.pi / 2, 20000))
    s = np.concatenate([up, arc])
    f = (6 * s**2 + 20 * s + 100) * (s**2 + 96 * s + 3600) / 3600 + (0.5 * s**2 + 6 * s + 100) * np.exp(-s * tau)
    return -round(float(np.diff(np.unwrap(np.angle(f))).sum() + np.angle(f[0] / f[-1])) / (2 * math.pi))


@pytest.mark.parametrize("tau", [0, 0.005, 0.3, 0.328, 0.331, 0.6])
def test_a_late_position_loop_has_as_many_unstable_poles_as_the_argument_principle_counts(tau: float) -> None:
    [held] = hs.stability(hs.parse_scene(LATE).with_values({"tau": tau})).to_dict()["held"]
    assert held["unstable"] == turns(tau)
    assert held["stable"] is (tau < 0.33)


def test_its_crossings_are_those_of_exp_s_tau_over_p_and_its_delay_is_a_free_parameter() -> None:
    late = hs.parse_scene(LATE)
    for crossing in hs.evaluate(late).crossings:
        s = 1j * float(crossing.omega)
        ratio = (s * s + 96 * s + 3600) / 3600 * cmath.exp(s * 0.005) - 1
        h = 6 * s**2 + 20 * s + 100
        change = ratio * h / abs(h)
        assert abs(change.real if crossing.part is hs.Part.REAL else change.imag) == pytest.approx(0.1, rel=1e-9)
    [(low, high)] = hs.require(late, "tau", ("0 s", "1 s"), that=["stable"]).to_dict()["feasible"]
    assert (low, turns(high * 0.999), turns(high * 1.001)) == (0, 0, 2)
    assert hs.release(late, "5 cm").to_dict()["agrees"]
    assert "would precede a prescribed motion" in refusal(hs.simulate, late, hs.sine("1 cm", 5))
