"""Letting go, by laws: rightmost roots that are known, sampled loops by matrices, modes put together by hand, and what is said."""

from __future__ import annotations

import random
from dataclasses import replace
from math import log
from typing import Any

import mpmath
import numpy as np
import pytest
from flint import acb
from sympy import Expr, Integer, Mul, Rational, exp

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.symbols import s
from haptisym.verbs.simulate.clockroot import clocked_root
from haptisym.verbs.simulate.pencil import Mode, envelope, modes, slowest
from haptisym.verbs.simulate.propagate import NODES, Record
from haptisym.verbs.simulate.released import Closed, Release
from haptisym.verbs.simulate.rightmost import Characteristic, Rightmost, rightmost_pole, rightmost_root
from haptisym.verbs.stability.held import Held

SPRING = hs.environments.mass_spring_damper(k=100)


def rightmost(form: Expr, at_0: int = 0) -> Rightmost | None:
    ring = Ring.of([form])
    return rightmost_root(ring.convert(form).numerator, ring, at_0)


# Roots


def test_the_rightmost_root_of_a_polynomial_is_the_one_that_was_put_there() -> None:
    pick = random.Random(11)
    for n in range(12):
        pairs = [
            (Rational(pick.randint(-40, 40), 8), Rational(pick.randint(1, 90), 8)) for _ in range(pick.randint(0, 2))
        ]
        singles = [Rational(pick.randint(-40, 40), 8) or Rational(1, 3) for _ in range(pick.randint(1, 2))]
        form = Mul(*((s - a) ** 2 + b**2 for a, b in pairs), *(s - a for a in singles), Integer(1 + n)).expand()
        listed = [*((float(a), float(b)) for a, b in pairs), *((float(a), 0.0) for a in singles)]
        if len({a for a, _ in listed}) < len(listed):
            continue  # no root alone is rightmost
        found = rightmost(form)
        assert found is not None
        first = max(listed)
        assert (found.s.real, found.s.imag, found.certified) == (
            pytest.approx(first[0], abs=1e-13),
            pytest.approx(first[1], rel=1e-13),
            True,
        )
        assert found.enclosure.contains(acb(*first))
        ordered = sorted(found.others, key=lambda x: (x.real, x.imag))
        assert ordered == pytest.approx([complex(*x) for x in sorted(listed)], abs=1e-6)


@pytest.mark.parametrize(("a", "tau"), [("1", "1/2"), ("3", "1"), ("-2", "1/3"), ("1/10", "2"), ("30", "1/10")])
def test_the_rightmost_root_behind_a_delay_is_lamberts(a: str, tau: str) -> None:
    """s + a exp(-s tau) = 0: s = W(-a tau)/tau."""
    gain, lag = Rational(a), Rational(tau)
    found = rightmost(s + gain * exp(-s * lag))
    assert found is not None
    with mpmath.workdps(50):
        T = mpmath.mpf(int(lag.p)) / int(lag.q)
        known = mpmath.lambertw(-mpmath.mpf(int(gain.p)) / int(gain.q) * T) / T
        rate, omega = found.digits()
        assert found.certified
        assert rate == mpmath.nstr(known.real, 15) or abs(mpmath.mpf(rate) / known.real - 1) < 1e-14
        assert abs(mpmath.mpf(omega) - abs(known.imag)) <= 1e-14 * abs(known)
        assert found.s == pytest.approx(complex(known.real, abs(known.imag)), rel=1e-14)
        others = sorted(
            (mpmath.lambertw(-mpmath.mpf(int(gain.p)) / int(gain.q) * T, k) / T for k in range(-3, 3)),
            key=lambda x: -x.real,
        )
        upper = [complex(x) for x in others if x.imag >= 0][:3]
        assert list(found.others[: len(upper)]) == pytest.approx(upper, rel=1e-9)


def test_roots_at_0_that_cancel_are_none_and_others_are() -> None:
    form = s * (s + 3) * (s + 5)
    assert rightmost(form.expand()).s == 0  # type: ignore[union-attr]
    assert rightmost(form.expand(), 1).s == pytest.approx(-3)  # type: ignore[union-attr]
    assert rightmost(form.expand(), 1).certified  # type: ignore[union-attr]
    assert rightmost(s + 0 * s, 1) is None
    assert rightmost((s - exp(-s) * s).expand()) is not None
    ring = Ring.of([exp(-s)])
    pole = rightmost_pole(ring.convert(s / (s * (s + 2 * exp(-s)) * (s - 9))))
    assert pole == pytest.approx(9)


def test_a_root_of_a_power_of_s_is_that_of_the_square_that_it_is() -> None:
    """With x = sqrt(s): x^2 - a x - b = 0, and only |arg x| < pi/2 counts; on the left the cut is in the way of a proof."""
    for a, b in ((1, 2), (3, 5)):
        found = rightmost(s - a * s ** Rational(1, 2) - b)
        x = (a + (a * a + 4 * b) ** 0.5) / 2
        assert found is not None
        assert found.s == pytest.approx(x * x, rel=1e-12)
    turned = rightmost(s - 2 * s ** Rational(1, 2) + 5)  # x = 1 +- 2j: s = -3 +- 4j
    assert turned is not None
    assert (turned.s, turned.certified) == (pytest.approx(-3 + 4j, rel=1e-12), False)


@pytest.mark.parametrize("share", ["1/2", "-1/4", "3/2"])
def test_a_chain_of_roots_tends_to_the_logarithm_of_what_comes_back(share: str) -> None:
    """s (1 + c exp(-s tau)) + 3: |c| exp(-Re s tau) = 1; with the delay doubled beside it, roots of a square."""
    c, tau = Rational(share), Rational(1, 4)
    assert chain(s * (1 + c * exp(-s * tau)) + 3) == pytest.approx(4 * log(abs(float(c))), rel=1e-12)
    two = s * (1 + exp(-s * tau) * 5 / 6 + exp(-2 * s * tau) / 6) + 3  # z = -1/2 and -1/3
    assert chain(two) == pytest.approx(4 * log(1 / 2), rel=1e-12)
    assert chain(s + exp(-s) + 3) is None
    assert chain(s * (1 + exp(-s) / 2 + exp(-s * Rational(7, 5)) / 9) + 3) is None


def chain(form: Expr) -> float | None:
    ring = Ring.of([form])
    return Characteristic.of(ring.convert(form).numerator, ring).chain


@pytest.mark.parametrize(("K", "k"), [(60000, 50), (200, 0), (9000, 300)])
@pytest.mark.parametrize("late", [False, True])
def test_the_largest_root_of_a_sampled_wall_is_an_eigenvalue_of_its_period(K: int, k: int, *, late: bool) -> None:
    """M x'' + b x' + k x = -F, F = K x held, or held one period later: exactly a matrix over one period."""
    T, M, b = mpmath.mpf("0.001"), mpmath.mpf("0.145"), 2
    if late:
        scene = hs.Scene(
            hs.environments.mass_spring_damper(k=K),
            (hs.effects.sampled_loop("1 ms", "tustin", 1), hs.effects.shunt(m="45 g")),
        )
    else:
        scene = hs.Scene(
            hs.environments.mass_spring_damper(k=K), (hs.effects.zero_order_hold("1 ms"), hs.effects.shunt(m="45 g"))
        )
    found = clocked_root(scene, hs.Hand("own", m="0.1 kg", b=b, k=k))
    with mpmath.workdps(40):
        free = mpmath.expm(mpmath.matrix([[0, 1, 0], [-k / M, -b / M, -1 / M], [0, 0, 0]]) * T)
        step = mpmath.zeros(4)
        step[:2, :2], step[3, 0] = free[:2, :2], K
        for i in range(2):
            if late:  # what was sampled a period ago is held now
                step[i, 3] = free[i, 2]
            else:
                step[i, 0] = free[i, 0] + K * free[i, 2]
        z = [x for x in mpmath.eig(step)[0] if abs(x) > 1e-9]
        known = max(z, key=abs)
        assert found is not None
        assert found.certified
        assert found.s == pytest.approx(complex(mpmath.log(known).real / T, abs(mpmath.arg(known)) / T), rel=1e-9)
        assert [x.real for x in found.others] == pytest.approx(
            sorted((float(mpmath.log(abs(x)) / T) for x in z), reverse=True), rel=1e-9
        )


def test_of_a_loop_that_is_not_known_there_is_no_root() -> None:
    two = hs.Scene(SPRING, (hs.effects.zero_order_hold("1 ms"), hs.effects.zero_order_hold("2 ms", name="second")))
    assert clocked_root(two, hs.Hand("own", m=1, b=1)) is None


# Modes


def recorded(f: Any, end: float, steps: int = 400) -> Record:
    record, h = Record(1), end / steps
    times = h * (np.arange(steps)[:, None] + NODES)
    record.append(0.0, h, f(times)[..., None])
    return record


def test_what_lasts_longest_is_read_from_what_is_left_at_the_end() -> None:
    def f(t: Any) -> Any:
        return np.exp(-0.5 * t) * np.cos(7 * t) + 30 * np.exp(-4 * t) * np.cos(11 * t)

    late = slowest(recorded(f, 8.0), 0, 0.5, 0.0)
    assert late is not None
    assert (late.rate, late.omega) == (pytest.approx(-0.5, abs=1e-6), pytest.approx(7, abs=1e-6))
    assert 235 <= late.samples <= 241
    # on a clock: each sample a whole number of periods, as many as tell the turn
    clocked = slowest(recorded(f, 8.0), 0, 0.5, 0.01)
    assert clocked is not None
    assert (clocked.s, clocked.samples) == (pytest.approx(-0.5 + 7j, abs=1e-6), pytest.approx(400, abs=1))
    seldom = slowest(recorded(f, 8.0), 0, 0.5, 0.01, turn=15.0)
    assert seldom is not None
    assert (seldom.s, seldom.samples) == (pytest.approx(-0.5 + 7j, abs=1e-6), pytest.approx(400, abs=1))
    many = slowest(recorded(f, 8.0), 0, 0.1, 0.001, turn=30.0)
    assert many is not None
    assert many.samples == pytest.approx(240, abs=1) or many.samples == pytest.approx(480, abs=1)
    assert slowest(recorded(lambda t: 0 * t, 8.0), 0, 0.5, 0.0) is None
    assert slowest(recorded(f, 8.0), 0, 0.99, 0.02) is None  # 4 samples are too few


def test_beside_a_creep_that_fades_as_a_power_of_time_what_waves_is_told() -> None:
    def f(t: Any) -> Any:
        return np.exp(-1.0 * t) * np.cos(9 * t) + 1e-3 / (1 + t)

    found = slowest(recorded(f, 6.0), 0, 0.2, 0.0, waving=True)
    creeps = slowest(recorded(f, 6.0), 0, 0.2, 0.0)
    assert found is not None
    assert creeps is not None
    assert found.s == pytest.approx(-1 + 9j, rel=1e-3)
    assert creeps.omega < 1
    assert slowest(recorded(lambda t: 1 / (1 + t) + 0 * t, 6.0), 0, 0.2, 0.0, waving=True) is None


def test_the_rate_of_largest_values_and_how_far_it_varies() -> None:
    steady, spread = envelope(recorded(lambda t: np.exp(-0.3 * t) * np.sign(np.sin(40 * t)), 12.0, 4000), 0, 0.25)
    assert (steady.rate, steady.omega, steady.samples) == (pytest.approx(-0.3, abs=0.01), 0, 6)
    assert spread < 0.05
    # exp(-t) until half of it, and constant from then: six windows, of which two fall
    bent, spread = envelope(recorded(lambda t: np.exp(-np.minimum(t, 6.0)), 12.0, 4000), 0, 0.25)
    assert bent.rate == pytest.approx(-3 / 7.5 * 1.0, abs=0.02)
    assert spread == pytest.approx(1 - 0.4, abs=0.02)
    nothing, _ = envelope(recorded(lambda t: 0 * t, 12.0), 0, 0.25)
    assert nothing.rate == 0


def test_a_matrix_pencil_takes_a_sum_of_exponentials_apart_with_its_amplitudes() -> None:
    t = 0.02 * np.arange(180)
    known = {-0.4 + 6j: 1.0 - 0.5j, -1.0 + 2j: 0.3j, -0.2: 0.7}
    x = sum((2 if z.imag else 1) * (c * np.exp(z * t)).real for z, c in known.items())
    found, weights = modes(x, 0.02)
    assert len(found) == 5
    for z, c in known.items():
        i = int(np.argmin(abs(found - z)))
        assert (found[i], weights[i]) == (pytest.approx(z, abs=1e-6), pytest.approx(c, abs=1e-6))


def test_what_is_over_after_one_sample_is_no_exponential() -> None:
    found, weights = modes(np.eye(1, 24)[0], 0.1)
    assert np.isfinite(found).all()
    assert len(found) == len(weights)


# What is said


def let_go(**given: Any) -> Release:
    """A release as if it had gone so: read at -2 + 30j, with the closed form's root there."""
    scene = given.pop("scene", hs.Scene(SPRING, (hs.effects.delay("10 ms"),)))
    hand = hs.Hand("own", m="0.5 kg", b=3, k=7)
    root = Rightmost(-2 + 30j, acb(-2, 30), certified=True, others=(-2 + 30j,))
    held = Held(hand, given.pop("roots", Roots(0, 0)), "nobody counted them")
    t = np.array([0.0, 1.0, 2.0])
    made = Release(
        scene,
        hand,
        0.01,
        t,
        0.01 * t,
        3 * t,
        Mode(-2 + 30j, 240),
        1e-6,
        Closed(root),
        "",
        ("kelvin-voigt", "delay"),
        "",
        held,
    )
    return replace(made, **given)


def said(r: Release) -> str:
    return " ".join(str(r).split())


def endless(c: Rational, *others: complex) -> Closed:
    """A closed form whose chain of roots tends to ln |c|, beside single ones."""
    found = rightmost(s * (1 + c * exp(-s)) + 3)
    assert found is not None
    return Closed(replace(found, s=others[0], others=others))


@pytest.mark.parametrize(
    ("given", "grows", "sign", "agrees", "verdict"),
    [
        ({}, False, True, True, "After letting go the motion dies away. Simulation and closed form agree in rate and frequency."),
        ({"fitted": Mode(2 + 30j, 9)}, True, False, False, "After letting go the motion GROWS. Simulation and closed form DISAGREE."),
        ({"fitted": Mode(2 + 30j, 9), "roots": Roots(2, 2), "closed": None}, True, True, None, "GROWS. Simulation and closed form agree in the sign of the rate."),
        ({"fitted": Mode(1e-6 + 30j, 9)}, None, None, False, "Whether the motion grows or dies away cannot be read from this run."),
        ({"fitted": Mode(1.1e-6 + 30j, 9)}, True, False, False, "GROWS. Simulation and closed form DISAGREE."),
        ({"fitted": None}, None, None, None, "cannot be read from this run."),
        ({"fitted": None, "stopped": "come to rest"}, False, True, None, "dies away. Simulation and closed form agree in the sign of the rate."),
        ({"fitted": None, "stopped": "come to rest", "roots": Roots(2, 2)}, False, False, None, "dies away. Simulation and closed form DISAGREE."),
        ({"fitted": None, "stopped": "grown ten million times"}, None, None, None, "cannot be read from this run."),
        ({"roots": None, "closed": None}, False, None, None, "dies away. There is nothing to compare it with."),
        ({"roots": Roots(None, None, (), RootChain.NEAR)}, False, None, True, "dies away. Simulation and closed form agree in rate and frequency."),
        ({"approximate": "a clock nobody knows"}, False, True, None, "dies away. The closed form is not what was simulated here: a clock nobody knows."),
        ({"fitted": Mode(-2 + 30.00003j, 9)}, False, True, True, "agree in rate and frequency."),  # 1e-6 of its size and three times the error
        ({"fitted": Mode(-2 + 30.00004j, 9)}, False, True, False, "Simulation and closed form DISAGREE."),
        ({"closed": endless(Rational(1, 2), -0.8 + 5j)}, False, True, True, "agree in the sign of the rate."),  # the chain is right of it
        ({"closed": endless(Rational(1, 2), -0.6 + 5j)}, False, True, False, "DISAGREE."),  # it is not: rates are compared
        ({"closed": endless(Rational(3, 2), -0.8 + 5j)}, False, True, False, "DISAGREE."),
        ({"closed": endless(Rational(1), -0.8 + 5j)}, False, True, None, "agree in the sign of the rate."),
        ({"closed": endless(Rational(1, 2), -0.1 + 2000j)}, False, True, True, "agree in the sign of the rate."),  # what is so fast does not count
    ],
)  # fmt: skip
def test_what_a_release_says_of_motion_and_closed_form(
    given: dict[str, Any], grows: object, sign: object, agrees: object, verdict: str
) -> None:
    r = let_go(**given)
    assert (r.grows, r.sign_agrees, r.agrees) == (grows, sign, agrees)
    assert said(r).endswith(verdict)
    word = {True: "grows", False: "dies away", None: "is left open"}[grows]  # type: ignore[index]
    assert repr(r) == f'<Release "Untitled scene" in own, let go: {word}>'
    document = r.to_dict()
    assert (document["grows"], document["agrees"], document["held"]) == (grows, agrees, r.held.stable)
    assert document.get("approximate") == (given.get("approximate") or None)
    assert document["stopped"] == (given.get("stopped") or None)


def test_a_release_is_told_in_numbers_on_its_page_and_in_its_document() -> None:
    r = let_go()
    document = r.to_dict()
    assert document["hand"] == {"name": "own", "m": 0.5, "b": 3.0, "k": 7.0}
    assert (document["displacement"], document["time"], document["samples"], document["built"]) == (
        0.01,
        [0.0, 2.0],
        3,
        ["kelvin-voigt", "delay"],
    )
    assert document["simulated"] == {"rate": -2.0, "omega": 30.0, "error": 1e-6}
    assert document["closed"] == {
        "rate": -2.0,
        "omega": 30.0,
        "digits": ["-2.00000000000000", "30.0000000000000"],
        "chain": None,
        "certified": True,
    }
    assert (let_go(closed=None).to_dict()["closed"], let_go(fitted=None).to_dict()["simulated"], r.certified) == (
        None,
        None,
        False,
    )
    floats = Closed(Rightmost(-2.123456789123 + 30j, None, certified=False))
    assert let_go(closed=floats).to_dict()["closed"]["digits"] == ["-2.12345679", "30"]
    lines = [" ".join(line.split()) for line in str(r).splitlines()]
    for line in (
        "simulated kelvin-voigt, delay", "hand own: m = 0.5 kg, b = 3 N·s/m, k = 7 N/m", "held at 0.01 m, at rest, then let go",
        "time 0 to 2 s", "what lasts longest rate (1/s) rad/s error", "read from the motion -2 30 1e-06",
        "rightmost root -2.00000000000000 30.0000000000000 proven",
    ):  # fmt: skip
        assert lines.count(line) == 1, line
    assert "Held in this hand, by the closed form (H_perc + m s^2 + b s + k): stable, no root has Re s ≥ 0." in said(
        r
    ).replace("\xa0", " ")
    assert "not proven to be the rightmost" in said(let_go(closed=floats))
    assert "time 0 to 2 s, when it had come to rest" in said(let_go(stopped="come to rest"))
    assert "NOT stable." in said(let_go(roots=Roots(2, 2)))
    assert "not decided (nobody counted them)." in said(let_go(roots=None))
    assert "NOT stable, infinitely many roots come as near" in said(let_go(roots=Roots(None, None, (), RootChain.NEAR)))
    assert "whose rates tend to -0.693147 1/s" in said(let_go(closed=endless(Rational(1, 2), -0.8 + 5j)))
    assert "read from the motion -2 - 1e-06" in said(let_go(closed=endless(Rational(1, 2), -0.8 + 5j)))
    assert "rightmost root" not in said(let_go(closed=None))
    clocked = said(let_go(scene=hs.Scene(SPRING, (hs.effects.zero_order_hold("1 ms"),)))).replace("\xa0", " ")
    assert "largest root z, ln z/T -2.00" in clocked
    assert "the closed form (the loop with its clock): stable, no root has |z| ≥ 1." in clocked
    assert r.to_csv() == "time [s],displacement [m],force [N]\n0.0,0.0,0.0\n1.0,0.01,3.0\n2.0,0.02,6.0\n"
    wheel = replace(r, scene=hs.load_scene("steering-wheel"))
    assert wheel.to_csv().startswith("time [s],displacement [rad],force [N m]\n")
    assert "held at 0.01 rad" in said(wheel)


# Runs


def test_a_mass_on_a_spring_let_go_swings_as_its_formula_says_from_where_it_was_held() -> None:
    """0.5 x'' + 2 x' + 107 x = 0 after a moment; before that 1 cm is held by 1.07 N, of which the display gives 1 N."""
    scene = hs.Scene(SPRING, (), (0, 15))
    run = hs.release(scene, "1 cm", hs.Hand("own", m="0.5 kg", b=2, k=7))
    assert run.fitted is not None
    assert run.closed is not None
    root = complex(-2, (4 * 0.5 * 107 - 4) ** 0.5)
    assert run.fitted.s == pytest.approx(root, rel=1e-7)
    assert run.closed.s == pytest.approx(root, rel=1e-13)
    assert (run.agrees, run.sign_agrees, run.grows, run.built, run.approximate) == (
        True,
        True,
        False,
        ("mass-spring-damper",),
        "",
    )
    assert (run.hand_motion[0], run.force[0]) == (pytest.approx(0.01, rel=1e-3), pytest.approx(1, rel=1e-3))
    assert run.force == pytest.approx(100 * run.hand_motion, abs=1e-9)
    assert run.stopped in ("", "come to rest")
    # from 16 powers of e that it falls by, at the rate of its closed form
    assert 16 / 2 * 0.98 < run.time[-1] <= 16 / 2 * 1.001
    early = run.time > 0.5 / root.imag + 1e-6
    at = int(np.argmax(early))
    state = np.array([run.hand_motion[at], np.gradient(run.hand_motion, run.time)[at]])
    t = run.time[early] - run.time[at]
    wave = np.exp(root * t)
    a = state[0] - 1j * (state[1] - root.real * state[0]) / root.imag
    assert run.hand_motion[early] == pytest.approx((a * wave).real, abs=2e-5)


@pytest.mark.parametrize(
    ("scene", "hand", "said"),
    [
        (hs.Scene(SPRING), None, r"letting go needs a hand, of this scene nothing tells which"),
        (hs.Scene(SPRING, hands=(hs.Hand("a", m=1), hs.Hand("b", m=1))), None, r"letting go needs a hand, which one of a, b"),
        (hs.Scene(hs.environments.mass_spring_damper(k="100 N/m")), hs.Hand("own", m="1 kg*m^2"), r"hand own: its unit is rotational, but the scene is translational"),
    ],
)  # fmt: skip
def test_a_release_needs_one_hand_that_moves_as_the_scene_does(
    scene: hs.Scene, hand: hs.Hand | None, said: str
) -> None:
    with pytest.raises(hs.HaptisymError, match=said):
        hs.release(scene, "1 cm", hand)


def test_the_scenes_own_hand_is_taken_and_a_run_lasts_as_long_as_is_asked() -> None:
    scene = hs.Scene(SPRING, (hs.effects.first_order_lag(200),), (0, 15), hands=(hs.Hand("mine", m="0.5 kg", b=12),))
    watched: list[tuple[float, float]] = []
    run = hs.release(scene, "1 cm", duration="400 ms", progress=lambda *x: watched.append(x))
    assert (run.hand.name, run.displacement) == ("mine", 0.01)
    assert run.time[-1] == pytest.approx(0.4, abs=0.02)
    assert {until for _, until in watched} == {0.4}
    assert [now for now, _ in watched] == sorted(now for now, _ in watched)
    assert watched[0][0] == 0
