"""Held displaced, and let go: what the equations of motion do against the rightmost root of the closed form."""

from __future__ import annotations

import json
import random
from math import log

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from sympy import Expr, Integer, Rational, exp, pi

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s
from haptisym.verbs.simulate.pencil import modes
from haptisym.verbs.simulate.rightmost import Characteristic, rightmost_root

TURNED = hs.Hand("turned", m="0.01 kg*m^2", b="0.1 N*m*s/rad", k="2 N*m/rad")
LIGHT = hs.Hand("light", m="0.1 kg", b="0.3 N*s/m")
SLOW = ("organ-tissue", "four-channel-teleoperation", "virtual-wall", "sampled-wall")
CLOCKED = ("virtual-wall", "sampled-wall")


def own(m: object, b: object, k: object = 0) -> hs.Hand:
    return hs.Hand("own", m=m, b=b, k=k)


@pytest.mark.few(1)
@pytest.mark.parametrize(("b", "grows"), [("3.3 N*s/m", True), ("3.6 N*s/m", False)])
def test_a_delayed_spring_let_go_grows_below_the_critical_damping_and_dies_away_above(b: str, grows: bool) -> None:  # noqa: FBT001
    run = hs.release("delayed-spring", "1 cm", own("0.5 kg", b))
    assert run.grows is grows
    assert run.held.stable is not grows
    assert run.fitted is not None
    assert run.closed is not None
    # 0.5 s^2 + b s + 100 exp(-0.036 s), solved by another program
    root = mpmath.findroot(
        lambda z: 0.5 * z * z + float(b.split()[0]) * z + 100 * mpmath.exp(-0.036 * z), mpmath.mpc(0, 13.3)
    )
    assert run.fitted.rate == pytest.approx(float(root.real), rel=1e-7)
    assert run.fitted.omega == pytest.approx(float(root.imag), rel=1e-9)
    assert run.closed.root.certified
    assert run.agrees is True
    assert json.loads(run.to_json())["closed"]["digits"][1].startswith(mpmath.nstr(root.imag, 16)[:12])
    assert "agree in rate and frequency" in " ".join(str(run).split())


@pytest.mark.slow
def test_at_the_critical_damping_the_root_is_on_the_axis() -> None:
    [row] = hs.stability("delayed-spring", own("0.5 kg", "3.4635997327677037 N*s/m")).held
    assert row.stable is not None
    run = hs.release("delayed-spring", "1 cm", own("0.5 kg", "3.4635997327677037 N*s/m"))
    assert run.closed is not None
    assert abs(run.closed.rate) < 1e-14
    assert run.closed.omega == pytest.approx(13.320697368492448, rel=1e-14)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(x, marks=pytest.mark.slow) if x in SLOW else x
        for x in hs.scene_names()
        if x not in ("control-stick-in-detail", "fu2019-tolerances")
    ],
)
def test_every_shipped_scene_let_go_does_what_the_held_verdict_says(name: str) -> None:
    scene = hs.load_scene(name)
    turns = scene.motion is not None and scene.motion.name == "ROTATION"
    for hand in [TURNED] if turns else [hs.hands["postural-arm"], LIGHT]:
        run = hs.release(scene, "0.02 rad" if turns else "1 cm", hand)
        assert run.sign_agrees is not False, (name, hand.name)
        assert run.agrees is not False, (name, hand.name)
        if (
            run.held.stable is not None and name != "wave-variable-link"
        ):  # its chain of roots comes near the axis far up
            assert run.sign_agrees is True
        if run.closed is not None and not run.is_envelope and not run.approximate:
            assert run.agrees is True, (name, hand.name)


@pytest.mark.slow
def test_a_control_stick_in_detail_let_go_comes_to_rest() -> None:
    run = hs.release("control-stick-in-detail", "1 cm", "postural-arm")
    assert (run.grows, run.held.stable, run.agrees) == (False, True, True)


@pytest.mark.slow
@pytest.mark.parametrize("K", [pytest.param(60000, id="diverges"), pytest.param(200, id="holds")])
def test_a_sampled_wall_let_go_grows_as_the_eigenvalues_of_its_sampled_loop_say(K: int) -> None:
    """Between samples M x'' + b x' + k x = -F, F = K x held: the exact solution of that over one period is a matrix."""
    wall = hs.Scene(
        hs.environments.mass_spring_damper(k=K),
        (hs.effects.zero_order_hold("1 ms"), hs.effects.shunt(m="45 g")),
        ("0 Hz", "20 Hz"),
    )
    run = hs.release(wall, "1 mm", own("0.1 kg", "2 N*s/m", "50 N/m"))
    M, T = mpmath.mpf("0.145"), mpmath.mpf("0.001")
    free = mpmath.matrix([[0, 1, 0], [-50 / M, -2 / M, -1 / M], [0, 0, 0]])
    step = mpmath.expm(free * T) * mpmath.matrix([[1, 0, 0], [0, 1, 0], [K, 0, 0]])
    sizes = [abs(x) for x in mpmath.eig(step)[0]]
    rate = log(float(max(sizes))) * 1000
    assert run.grows is (rate > 0)
    assert run.fitted is not None
    assert run.fitted.rate == pytest.approx(rate, rel=1e-6)
    assert run.closed is not None
    assert run.closed.rate == pytest.approx(rate, rel=1e-12)
    assert run.agrees is True
    assert run.sign_agrees is True


def test_a_mass_that_comes_late_grows_in_a_light_hand() -> None:
    run = hs.release("satellite-contact", "1 cm", "postural-arm")
    assert run.grows is True
    assert run.held.stable is False
    assert run.closed is not None
    assert run.closed.chain == pytest.approx(log(500 / 0.554) / 0.108, rel=1e-9)
    assert run.sign_agrees is True


def test_friction_holds_what_is_let_go() -> None:
    run = hs.release("stick-with-friction", "1 cm", "postural-arm")
    assert run.stopped == "come to rest"
    assert run.grows is False
    assert run.agrees is None


@pytest.mark.parametrize(
    ("scene", "displacement", "hand", "said"),
    [
        ("fu2019", "1 cm", None, "needs a hand"),
        ("fu2019", "1 cm", "nobody", 'no hand "nobody"'),
        ("fu2019", "-1 cm", "postural-arm", "must be > 0"),
        ("fu2019", "3 deg", "postural-arm", "rotation"),
        ("fu2019", "1 kg", "postural-arm", "release"),
        ("satellite-contact", "1 cm", hs.Hand("none"), "not determined"),
    ],
)
def test_what_cannot_be_let_go_is_said_in_one_sentence(
    scene: str, displacement: str, hand: str | hs.Hand | None, said: str
) -> None:
    with pytest.raises(hs.HaptisymError, match=said) as error:
        hs.release(scene, displacement, hand)
    assert "\n" not in str(error.value)


def test_without_a_static_stiffness_there_is_nothing_to_let_go() -> None:
    damper = hs.Scene(hs.environments.mass_spring_damper(b=5))
    with pytest.raises(hs.HaptisymError, match="no static stiffness|static stiffness"):
        hs.release(damper, "1 cm", own("1 kg", "1 N*s/m"))


@pytest.mark.slow
@examples(15)
@given(
    k=st.integers(1, 500),
    b=st.integers(0, 40),
    m=st.fractions(Rational(1, 20), 3, max_denominator=20),
    tau=st.fractions(Rational(1, 200), Rational(1, 10), max_denominator=200),
    c=st.fractions(0, 10, max_denominator=10),
)
def test_no_root_of_a_late_spring_and_damper_lies_right_of_the_one_that_is_called_rightmost(
    k: int, b: int, m: Rational, tau: Rational, c: Rational
) -> None:
    """(k + c s) exp(-s tau) + m s^2 + b s: eigenvalues of a Chebyshev discretisation, which is another way to its roots."""
    m, tau, c = (Rational(x.numerator, x.denominator) for x in (m, tau, c))
    formula = (k + c * s) * exp(-s * tau) + m * s**2 + b * s
    ring = Ring.of([formula])
    found = rightmost_root(ring.convert(formula).numerator, ring)
    assert found is not None
    n = 40
    x = np.cos(np.pi * np.arange(n + 1) / n)
    weights = np.r_[2, np.ones(n - 1), 2] * (-1.0) ** np.arange(n + 1)
    grid = np.tile(x, (n + 1, 1)).T
    D = np.outer(weights, 1 / weights) / (grid - grid.T + np.eye(n + 1))
    D = (D - np.diag(D.sum(axis=1))) * 2 / float(tau)  # on [-tau, 0], place 0 first
    A = np.kron(D, np.eye(2))
    A[:2] = 0
    A[0, 1], A[1, 1] = 1, -b / float(m)
    A[1, -2], A[1, -1] = -k / float(m), -float(c) / float(m)
    rightmost = max(np.linalg.eigvals(A).real)
    assert found.s.real == pytest.approx(rightmost, abs=1e-4 * max(1, abs(found.s)))


def numbers(draw: random.Random, *, chain: bool) -> tuple[Expr, int, dict[tuple[int, Rational], Expr]]:
    """A characteristic function, its degree, and what stands before each power of s and delay: often of several powers of pi."""
    degree, lags = draw.randint(1, 4), [Integer(0), Rational(1, draw.randint(2, 9)), Rational(draw.randint(1, 9), 10)]
    table = {(degree, Integer(0)): draw.choice([Integer(1), Integer(3), 4 - pi, pi - 3, -2 - pi])}
    for n in range(degree):
        for lag in draw.sample(lags, draw.randint(0, 3)):
            table[n, lag] = Rational(draw.randint(-60, 60), draw.randint(1, 9)) + draw.choice([0, 0, -7 * pi])
    if chain:
        table[degree, lags[1]] = table[degree, Integer(0)] * Rational(draw.choice([-1, 1]) * draw.randint(1, 7), 8)
    formula = sum((c * s**n * exp(-s * lag) for (n, lag), c in table.items()), Integer(0))
    return formula, degree, table


@pytest.mark.parametrize("seed", range(8))
def test_beyond_its_radius_the_highest_power_outweighs_all_others_and_within_it_may_not(seed: int) -> None:
    draw = random.Random(seed)
    for n in range(6):
        formula, degree, table = numbers(draw, chain=n % 3 == 2)
        ring = Ring.of([formula])
        found = Characteristic.of(ring.convert(formula).numerator, ring)
        line = draw.uniform(-1, 0.5)
        radius = found._radius(line)
        own = [(abs(float(c)), k, float(lag)) for (k, lag), c in table.items() if c]
        floor = sum((-1) ** (lag > 0) * c * np.exp(-lag * line) for c, k, lag in own if k == degree)
        assert (radius is None) == (floor <= 0)
        if radius is None:
            continue

        def others(x: float, least: float = line) -> float:
            return sum(c * np.exp(-lag * least) * x ** (k - degree) for c, k, lag in own if k < degree)  # noqa: B023

        assert others(radius) < floor
        assert radius < 2e-3 or others(radius / 1.6) > 0.8 * floor
        for far in (1, 1.7, 30):
            phases = np.exp(1j * np.linspace(-np.pi, np.pi, 721)) * radius * far
            places = np.append(phases[phases.real >= line], [complex(max(line, 0), radius * far)])
            values = sum(float(c) * places**k * np.exp(-places * float(lag)) for (k, lag), c in table.items())
            assert (np.abs(values) > 0.05 * floor * np.abs(places) ** degree).all()


def test_several_powers_of_pi_before_one_power_of_s_are_one_number() -> None:
    """As where a frequency in Hz meets a stiffness: roots of a square by its formula, and a chain by its own."""
    formula = (4 - pi) * s**2 + (pi - 300) * s + 2
    ring = Ring.of([formula])
    found = rightmost_root(ring.convert(formula).numerator, ring)
    assert found is not None
    assert found.certified
    a, b = float(4 - pi), float(pi - 300)
    assert found.s == pytest.approx((-b + (b**2 - 8 * a) ** 0.5) / (2 * a), rel=1e-12)
    for tau in (Rational(1, 10), Rational(1, 3)):
        formula = (4 - pi) * s + (pi - 3) * s * exp(-s * tau) + 5
        ring = Ring.of([formula])
        chain = Characteristic.of(ring.convert(formula).numerator, ring).chain
        assert chain == pytest.approx(log(float((pi - 3) / (4 - pi))) / float(tau), rel=1e-12)


@pytest.mark.slow
def test_a_matrix_pencil_finds_two_modes_that_are_close() -> None:
    t = 0.01 * np.arange(240)
    x = np.exp(-0.5 * t) * np.cos(7 * t) + 0.3 * np.exp(-0.8 * t) * np.cos(7.5 * t)
    found, _ = modes(x, 0.01)
    assert min(abs(found - (-0.8 + 7.5j))) < 1e-4
    assert min(abs(found - (-0.5 + 7j))) < 1e-4
