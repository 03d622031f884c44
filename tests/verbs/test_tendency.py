"""Values without end: roots that cross one way only, ever more of them, or none: against winding numbers and counts far out."""

from __future__ import annotations

from itertools import pairwise
from math import factorial
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from sympy import Expr, Integer, Poly, Rational, Symbol, exp, lambdify, pi, sqrt
from windings import winding

import haptisym as hs
from haptisym.judge.passiveparts import takes_energy
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.far import far
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.symbols import s
from haptisym.verbs.stability.held import held, roots_in_hand
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.switches import Switches
from haptisym.verbs.stability.tendency import Tendency

E = hs.effects
q = Symbol("q", real=True)


def loop_of(expression: Expr, low: Expr | None = None) -> Loop:
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), q, low)


def number(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


def right(expression: Expr, value: float, reach: float) -> int | None:
    """Its zeros in Re s > 0, up to a size beyond which there are none."""
    return winding(lambdify(s, expression.subs(q, value) + 0 * s, "numpy"), reach)


# One way only


SPRING = (
    Rational(1, 2) * s**2 + 8 * s + 50 + q * exp(-s / 40)
)  # |s| <= 16 + sqrt(2 (50 + q)) for all roots on the right


def test_a_spring_behind_a_delay_that_shakes_shakes_however_much_stiffer_it_is() -> None:
    way = Tendency(loop_of(SPRING))
    end = 343
    assert (right(SPRING, end - 1, 200), right(SPRING, end, 200)) == (0, 2)
    assert way.everywhere(number(end), None)
    assert not way.everywhere(number(end - 1), None)
    assert not way.everywhere(ExactNumber(343 * sqrt(2)), None)  # no root is counted at what is no rational number
    counts = [right(SPRING, end * 4.0**n, 40 + 40 * 2.0**n) for n in range(7)]
    assert counts == sorted(x for x in counts if x is not None)
    assert (counts[0], (counts[-1] or 0) > 10) == (2, True)


def test_what_is_asked_about_must_hold_no_value_that_comes_from_below_the_frequency_from_which_on_it_is_one_way() -> (
    None
):
    """Stable between two values: (s^2 + s + 1) (1 - q/4 (s + 3)) + ... turns either way at first."""
    expression = SPRING.subs(s, s) + 0 * q
    way = Tendency(loop_of(expression))
    assert not way.everywhere(number(300), number(400))
    assert way.everywhere(number(400), number(500))
    assert not way.everywhere(None, number(400))
    for low, high in ((-1, None), (-1, 900), (None, 900), (-900, 1)):
        ends = [None if x is None else number(x) for x in (low, high)]
        assert not way.everywhere(*ends)  # of numbers of both signs nothing is told
        assert not Tendency(loop_of(expression.subs(q, -q))).everywhere(*ends)


@pytest.mark.parametrize(
    ("low", "high"), [(400, None), (300, None), (400, 500), (None, -400), (-400, -300), (None, 400), (-40, -9)]
)
def test_of_a_number_with_the_other_sign_all_is_mirrored(low: int | None, high: int | None) -> None:
    ends = [None if x is None else number(x) for x in (low, high)]
    mirrored = [None if x is None else number(-x) for x in (high, low)]
    told = Tendency(loop_of(SPRING)).everywhere(*ends)
    assert Tendency(loop_of(SPRING.subs(q, -q))).everywhere(*mirrored) == told
    if low is not None and low > 0:
        assert told == (low == 400)


@pytest.mark.parametrize(
    ("own", "late", "above", "below"),
    [
        (s**2 / 2 - 8 * s + 50, exp(-s / 40), True, False),
        (s**2 - 2 * s + 50, exp(-s / 200), True, False),
        (s**2 - 2 * s + 50, s * exp(-s / 40), False, True),
        (s**2 / 2 - 20 * s + 50, s * exp(-s / 40), True, True),
        (s**2 / 2 + 8 * s + 50, exp(-s / 40), False, False),
    ],
)
def test_from_0_on_what_shakes_there_shakes_for_all_numbers_of_one_sign_if_none_holds_it(
    own: Expr, late: Expr, *, above: bool, below: bool
) -> None:
    """Two roots on the right at 0, and how many there are further on: by winding numbers."""
    zero = number(0)
    for sign in (1, -1):
        expression = own + sign * q * late
        way = Tendency(loop_of(expression))
        told = [way.everywhere(zero, None), way.everywhere(None, zero)][::sign]
        assert told == [above, below]
        for is_told, side in zip(told, (sign, -sign), strict=True):
            counts = [right(expression, side * x, 3000) for x in (0.3, 1.7, 9.0, 44.0, 300.0)]
            assert not is_told or 0 not in counts


def test_from_a_critical_value_itself_on_its_own_root_is_enough() -> None:
    own = hs.load_scene("delayed-spring").with_hands(hs.hands["postural-arm"])
    found = hs.require(own, "environment.k", that="stable")
    [span] = found.feasible
    way = Tendency(Loop.of(own, own.hands[0], own.knobs["environment.k"]))
    assert span.high.value is not None
    assert span.high.value.digits(15) == "199.852102258710"
    assert way.everywhere(span.high.value, None)
    assert not way.everywhere(number(199), None)
    assert found.undecided == ()


def test_nothing_is_told_where_roots_go_both_ways_for_ever() -> None:
    """A mass behind a lag and a delay against a hand's stiffness: stable again and again further out."""
    late = 20 * s**2 * exp(-s / 100) / (s + 200)
    expression = 2 * s**2 + 4 * s + q + late
    top = Ring.of([expression])
    loop = Loop(top, top.convert(expression).numerator, top.convert(expression).denominator, q, Integer(0))
    way = Tendency(loop)
    assert not any(way.everywhere(number(x), None) for x in (10, 10**4, 10**7))
    tissue = hs.environments.mass_spring_damper("250 g", 0, 282)
    own = hs.Scene(tissue, (E.first_order_lag(348), E.delay("4 ms"))).with_hands(
        hs.Hand("hand", m="1.8 kg", b=14, k=196)
    )
    found = hs.require(own, "hand.k", that="stable")
    assert ([high for _, high in found.undecided], found.reason) == ([None], "further out was not looked at")


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(24))
def test_all_values_are_known_that_put_roots_on_the_axis_before_they_cross_one_way_alone(seed: int) -> None:
    """Where g = -A/B turns real, on a dense grid of frequencies; and beyond the last of these its phase goes one way."""
    pick = Random(seed)
    lag, own = Rational(pick.randint(1, 60), 1000), (s**2 + pick.randint(0, 9) * s + pick.randint(1, 400)) / 2
    own += pick.choice([0, pick.randint(1, 80) * exp(-2 * s * lag), 3 * s**3 / pick.randint(50, 90)])
    late = [1, s, 1 + s / pick.randint(5, 90), (s**2 + 3) / 50][seed % 4] * exp(-s * lag)
    found = Tendency(loop_of(own + q * late))._settled
    if found is None:
        return
    reach = float(far(found.rate).radius)
    grid = np.linspace(reach / 200_000, reach, 200_001)
    g = lambdify(s, -own / late, "numpy")(1j * grid)
    turned = np.flatnonzero((g.imag[1:] * g.imag[:-1] < 0) & (abs(g.imag[1:] - g.imag[:-1]) < 1e-2 * (1 + abs(g[1:]))))
    known = np.array([float(x) for x in found.known])
    for i in turned:
        share = g.imag[i] / (g.imag[i] - g.imag[i + 1])
        value = g.real[i] + share * (g.real[i + 1] - g.real[i])
        assert abs(known - value).min(initial=np.inf) < 1e-3 * (1 + abs(value))
    beyond = lambdify(s, -own / late, "numpy")(1j * np.linspace(reach * 1.0001, reach * 1.2 + 1, 20_001))
    assert (np.diff(np.unwrap(np.angle(beyond))) * found.sense > 0).all()


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(30))
def test_where_a_random_loop_is_said_to_have_roots_on_the_right_for_all_values_it_has_them(seed: int) -> None:
    pick = Random(seed)
    lag = Rational(pick.randint(1, 60), 1000)
    own = Rational(pick.randint(1, 20), 10) * s**2 + pick.randint(0, 30) * s + pick.randint(0, 400)
    late = [q, q * s, q * (1 + s / pick.randint(5, 90)), q * (s**2 + 3) / 50][seed % 4] * exp(-s * lag)
    expression = own + late + pick.choice([0, pick.randint(1, 80) * exp(-2 * s * lag)])
    way = Tendency(loop_of(expression))
    value = lambdify((s, q), expression, "numpy")
    for low in (Rational(pick.randint(1, 4000), 10) for _ in range(12)):
        high = low * pick.choice([2, 30])
        if not way.everywhere(ExactNumber(low), None) and not way.everywhere(ExactNumber(low), ExactNumber(high)):
            continue
        for share in (1.0001, 1.2, 1.7, 1.9999):
            x = float(low) * share
            count = winding(lambda at, x=x: value(at, x), 3e3)
            assert count is None or count > 0, (expression, low, x)


# Delays


def counts_of(switches: Switches, tau: float, start: int) -> int:
    """By the senses, from the roots without a delay."""
    total = start
    for first, sense in zip(switches.firsts, switches.senses, strict=True):
        rate = float(first.omega) * float(first.multiple)
        a, b = (float(x.ball(first.omega.ball(80)).mid()) for x in first.ratio)
        angle = (-np.angle(complex(a, b))) % (2 * np.pi)
        total += 2 * sense * int(np.floor((rate * tau - angle) / (2 * np.pi)) + 1)
    return total


TWO = s**3 + 3 * s**2 + 60 * s + 90  # |A| = |B| at several frequencies with what comes late
LATE = [
    (s**2 / 2 + 6 * s + 50, Integer(120)),
    (s**2 / 2 + 2 * s + 50, 3 * s + 30),
    (TWO, 40 * s + 20),
    (TWO, 4 * s**2 + 150),
]


@pytest.mark.parametrize(("own", "late"), LATE)
@pytest.mark.parametrize("multiple", [1, 2])
def test_roots_are_as_many_as_have_come_less_those_that_have_gone(own: Expr, late: Expr, multiple: int) -> None:
    expression = own + late * exp(-multiple * s * q)
    switches = Switches.of(loop_of(expression))
    assert switches.senses[-1] == 1
    start = right(own + late, 0, 300)
    assert start is not None
    for tau in (0.013, 0.11, 0.37, 0.92, 1.7, 3.3):
        assert counts_of(switches, tau, start) == right(expression, tau, 300)


@pytest.mark.parametrize(("own", "late"), LATE)
def test_beyond_the_delay_from_which_on_roots_are_on_the_right_they_are(own: Expr, late: Expr) -> None:
    expression = own + late * exp(-s * q)
    switches = Switches.of(loop_of(expression))
    last = switches.unstable_from
    assert last is not None
    way = Tendency(loop_of(expression))
    assert way.everywhere(ExactNumber(last), None)
    for share in (1.0001, 1.01, 1.1, 1.3, 2, 3.1, 4.7):
        count = right(expression, float(last) * share, 300)
        assert count is None or count > 0
    # it is no more than one turn of each frequency too late
    if len(switches.firsts) == 1:
        assert right(expression, float(last) * 0.999, 300) == 0


@pytest.mark.parametrize(("own", "late"), LATE)
@pytest.mark.parametrize("multiple", [1, 2])
def test_between_two_delays_as_many_pairs_have_come_as_lie_on_the_right(own: Expr, late: Expr, multiple: int) -> None:
    """These have none on the right without a delay, so that all that is there has come."""
    expression = own + late * exp(-multiple * s * q)
    start = right(own + late, 0, 300)
    switches, way = Switches.of(loop_of(expression)), Tendency(loop_of(expression, Integer(0)))
    found = sorted((x.value for x in switches.up_to(Rational(5, 2))[0]), key=float)
    ends = [ExactNumber(Integer(0)), *(x for x in found if float(x) < 2.5)]
    for low, high in pairwise(ends):
        inside = (float(low) + float(high)) / 2
        count = right(expression, inside, 300)
        assert (start or 0) + 2 * switches.come(low) == count
        assert switches.come(number(f"{inside:.12g}")) == switches.come(low)
        assert way.everywhere(low, high) == (switches.come(low) > 0 or inside > float(switches.unstable_from or 0))
    some = [x for x in found if x.turn == 0]
    for x in some:  # a number that cannot be told from it: one that comes is not counted, and one that goes is
        same = ExactNumber(Rational(x.digits(300)))
        assert switches.come(same) <= switches.come(x)


def delays_of(own: Expr, late: Expr, limit: float) -> list[float]:
    """All from 0 to a limit at which own + late exp(-s tau) has roots on the axis, by NumPy."""
    A, B = (np.poly1d([float(c) for c in Poly(x, s).all_coeffs()]) for x in (own, late))
    mirrored = [np.poly1d([c * (-1) ** (len(x) - n) for n, c in enumerate(x.coeffs)]) for x in (A, B)]
    roots = (A * mirrored[0] - B * mirrored[1]).roots
    found: list[float] = []
    for w in (x.imag for x in roots if abs(x.real) < 1e-7 and x.imag > 1e-7):
        angle = np.angle(-B(1j * w) / A(1j * w))
        found += [(angle + 2 * np.pi * n) / w for n in range(int(limit * w) + 2)]
    return sorted(x for x in found if 0 <= x < limit)


@pytest.mark.parametrize(("own", "late"), [*LATE, ((s + 20) * (s**2 / 400 + s / 9 + 30), 3 * s**2 / 40 + 4 * s + 700)])
@pytest.mark.parametrize("scale", [1, 30])
def test_delays_are_all_there_up_to_the_one_that_is_told_also_of_frequencies_far_apart(
    own: Expr, late: Expr, scale: int
) -> None:
    """In units of time of another size all is as many times as long."""
    expression = own.xreplace({s: s * scale}) + late.xreplace({s: s * scale}) * exp(-s * q)
    switches = Switches.of(loop_of(expression))
    known, last = switches.up_to(Rational(scale, 100))
    assert last is not None
    assert switches.unstable_from is not None
    assert float(last) > max(scale / 100, float(switches.unstable_from))
    assert float(switches.unstable_from) / scale == pytest.approx(
        float(Switches.of(loop_of(own + late * exp(-s * q))).unstable_from or 0)
    )
    found = sorted(float(x.value) for x in known)
    true = [scale * x for x in delays_of(own, late, float(last) / scale - 1e-9)]
    assert found[: len(true)] == pytest.approx(true, rel=1e-9)
    assert all(x > float(last) - 1e-6 for x in found[len(true) :])


def test_without_a_frequency_at_which_both_are_of_one_size_no_delay_changes_anything() -> None:
    switches = Switches.of(loop_of(s**2 + 20 * s + 50 + 3 * exp(-s * q)))
    assert (switches.firsts, switches.up_to(Integer(1)), switches.unstable_from) == ((), ((), None), None)


def test_where_both_are_of_one_size_at_rest_nothing_is_told_of_all_delays() -> None:
    switches = Switches.of(loop_of(s**2 + 2 * s + 50 - 50 * exp(-s * q)))
    assert (switches.is_still, switches.unstable_from) == (False, None)
    known, last = switches.up_to(Integer(1))
    assert last is not None
    assert last > 1
    true = delays_of(s**2 + 2 * s + 50, Integer(-50), float(last))
    assert [float(x.value) for x in known if x.value != 0][: len(true)] == pytest.approx(true)


# Parts that only take energy


@pytest.mark.parametrize("seed", range(80))
def test_an_environment_that_is_said_to_take_energy_does_for_all_values_that_are_open(seed: int) -> None:
    pick = Random(seed)
    a, b, c = (Rational(pick.randint(0, 900), pick.randint(1, 9)) for _ in range(3))
    alpha = Rational(pick.randint(1, 9), 10)
    H = pick.choice([a + q * s, c * s**2 + b * s + q, q * s**2 + b * s + a, a + q * s**alpha, a + (b + 1) * s**q,
                     q + a * (b + 1) * s / (a + 1 + (b + 1) * s), (a + 1) * q * s / (a + 1 + q * s), a - q * s, q / (s + a + 1),
                     (s + q) / (s + a + 1), (s**2 + q) / (s**2 + a + 1), q * s / (s**2 + b * s + 1), s**4 + b * s + q,
                     q * s**4 + s + a, (s**4 + q * s + 1) / (s**2 + 3 * s + 1), s**Rational(9, 2) + q * s])  # fmt: skip
    told = takes_energy(H)
    value = lambdify((s, q), H, "mpmath")
    largest = 1 if H.has(s**q) else 1000
    points = [(pick.uniform(1e-3, 1) * largest, 10.0 ** pick.uniform(-3, 4)) for _ in range(200)]
    parts = [mpmath.im(value(mpmath.mpc(0, w), x)) for x, w in points]
    assert not told or min(parts) >= -1e-12 * max(abs(x) for x in parts)
    inside = [mpmath.mpc(10.0 ** pick.uniform(-3, 3), w) for _, w in points]
    assert not told or all(
        mpmath.re(value(x, points[0][0]) / x) >= -1e-12 * abs(value(x, points[0][0]) / x) for x in inside
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(16))
def test_in_a_hand_that_damps_passive_parts_are_stable_for_all_values_or_where_a_chain_allows_it(seed: int) -> None:
    pick = Random(seed)
    tissue = pick.choice([hs.environments.kelvin_voigt(pick.randint(0, 900), pick.randint(1, 9)),
                          hs.environments.zener(pick.randint(10, 500), pick.randint(10, 500), pick.randint(1, 9)),
                          hs.environments.maxwell(pick.randint(10, 500), pick.randint(1, 9))])  # fmt: skip
    parts = [pick.choice([E.wave_variables(pick.randint(2, 40), Rational(pick.randint(1, 30), 1000)),
                          E.compliance(k=pick.randint(100, 9000), b=pick.randint(1, 9)),
                          E.shunt(m=Rational(pick.randint(0, 20), 10), b=pick.randint(0, 4))]) for _ in range(pick.randint(1, 3))]  # fmt: skip
    hand = hs.Hand("hand", m=Rational(pick.randint(1, 30), 10), b=pick.randint(1, 40), k=pick.randint(0, 500))
    own = hs.Scene(tissue, tuple(parts)).with_hands(hand)
    for knob in (x for x in own.knobs if "jnd" not in x.path and "shunt" not in x.path and "hand.b" not in x.path):
        found = hs.require(own, knob.path, that="stable", limit=10)
        passive = hs.require(own, knob.path, that="passive", limit=10)
        assert passive.undecided == (), knob.path
        for factor in (Rational(1, 300), Rational(1, 7), 1, Rational(9, 2), 130):
            moved = own.with_values({knob.path: knob.value * factor})
            try:
                with limited(1):
                    told = roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0  # counted on a contour
            except HaptisymError:
                continue
            inside = any(
                (x.low.value is None or float(x.low.value) <= float(knob.value * factor))
                and (x.high.value is None or float(knob.value * factor) <= float(x.high.value))
                for x in found.feasible
            )
            if not found.undecided:
                assert told == inside, (knob.path, factor)


@pytest.mark.slow
def test_two_wave_variable_links_are_passive_and_stable_for_every_delay_and_impedance() -> None:
    links = E.wave_variables(13, "19 ms"), E.wave_variables(4, "15 ms")
    own = hs.Scene(hs.environments.kelvin_voigt(400, 3), links).with_hands(hs.Hand("hand", m="1.8 kg", b=14, k=196))
    for path in ("effects.wave-variables.tau", "effects.wave-variables-2.b", "environment.b", "hand.b"):
        for that in ("stable", "passive"):
            found = hs.require(own, path, that=that)
            assert (found.undecided, [x.high.value for x in found.feasible]) == ((), [None]), (path, that)


def test_a_link_with_nothing_that_damps_its_waves_is_stable_for_no_impedance() -> None:
    """A spring-pot reflects ever more, the higher the frequency: a chain comes to the axis, whatever the link's impedance is."""
    own = hs.Scene(hs.environments.spring_pot(30, "1/2"), (E.wave_variables(21, "2 ms"), E.compliance(k=5809)))
    found = hs.require(own, "effects.wave-variables.b", that="stable", hand=hs.Hand("hand", m="0.4 kg", b=3, k=391))
    assert (found.feasible, found.undecided) == ((), ())


@pytest.mark.parametrize("alpha", ["1/10", "1/2"])
def test_fractional_tissue_behind_a_cable_is_stable_for_every_order(alpha: str) -> None:
    own = hs.Scene(hs.environments.spring_pot(30, alpha), (E.compliance(k=5809), E.shunt(m="0.3 kg")))
    own = own.with_hands(hs.Hand("hand", m="0.4 kg", b=3, k=391))
    for path, high in (("environment.alpha", 1), ("environment.k_alpha", None)):
        found = hs.require(own, path, that="stable")
        [span] = found.feasible
        assert (
            found.undecided,
            span.low.value and float(span.low.value),
            span.high.value and float(span.high.value),
        ) == ((), 0, high)
    for order in ("1/50", "0.3", "0.97"):
        moved = own.with_values({"environment.alpha": order})
        assert roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0


def test_a_chain_that_reflects_all_is_at_the_axis_for_every_order_and_delay() -> None:
    tissue, hand = hs.environments.spring_pot(30, "1/2"), hs.Hand("hand", m="1.8 kg", b=14, k=196)
    link, other = E.wave_variables(13, "19 ms"), E.wave_variables(4, "15 ms")
    one = hs.Scene(tissue, (link,)).with_hands(hand)
    two = hs.Scene(hs.environments.mass_spring_damper("0.2 kg", 2, 30), (link, other)).with_hands(hand)
    for own, path in (
        (one, "environment.alpha"),
        (two, "effects.wave-variables.tau"),
        (two, "effects.wave-variables-2.tau"),
    ):
        found = hs.require(own, path, that="stable")
        assert (found.feasible, found.undecided) == ((), ()), path
        counted = roots_in_hand(
            own.distortion().perc, hand
        )  # of delays that are multiples of one, without what is known of parts
        assert counted.chain is RootChain.NEAR
        assert counted == held(own, hand).roots
    far_apart = two.with_values({"effects.wave-variables.tau": "0.0193711"})
    assert [x and x.chain for x in (held(far_apart, hand).roots,)] == [RootChain.NEAR]


@pytest.mark.few(1)
@pytest.mark.parametrize(("free", "low"), [("hand.b", 8.819064481568287), ("effects.shunt.b", 5.0)])
def test_damping_without_end_is_told_though_two_delays_have_a_fine_common_unit(free: str, low: float) -> None:
    """9 ms and 14 ms are nine and fourteen times 1 ms: powers of a tangent of 0.5 ms that nearly cancel."""
    wall = hs.environments.kelvin_voigt(300, 3)
    parts = (E.delay("14 ms"), E.first_order_lag(543), E.delay("24 ms"))
    own = hs.Scene(wall, (*parts, E.shunt(b=5)) if "shunt" in free else parts)
    hand = hs.Hand("hand", m="1.75 kg", b=39, k=9)
    found = hs.require(own, free, that="stable", hand=hand)
    assert found.undecided == ()
    last = found.feasible[-1] if free == "hand.b" else found.feasible[0]
    if free == "hand.b":
        assert last.high.value is None
        assert float(last.low.value or 0) == pytest.approx(low, rel=1e-12)
    for value in (1, 7, 30, 1000, 10**6, 10**9):
        moved = own.with_hands(hand).with_values({free: value})
        told = roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0
        inside = any(
            float(x.low.value or 0) < value < float("inf" if x.high.value is None else x.high.value)
            for x in found.feasible
        )
        assert told == inside, value


@pytest.mark.slow
def test_a_delay_behind_tissue_of_a_broken_order_is_told_without_end() -> None:
    """At rest tissue of order 1/2 does not pull, so that |A| > |B| there, and one frequency alone brings roots over."""
    own = hs.Scene(hs.environments.spring_pot(100, "1/2"), (E.first_order_lag(352), E.delay("40 ms")))
    own = own.with_hands(hs.Hand("hand", m="0.8 kg", b=4, k=109))
    found = hs.require(own, "effects.delay.tau", that="stable")
    [span] = found.feasible
    assert found.undecided == ()
    last = float(span.high.value or 0)
    for value in (last * 0.9999, last * 1.0001, 3 * last, 0.9, 1.3):
        moved = own.with_values({"effects.delay.tau": f"{value:.12g}"})
        assert (roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0) == (value < last)


def test_where_all_vanishes_at_rest_whatever_the_number_is_no_value_is_left_out() -> None:
    """Line and shunt share a zero at s = 0 that is no root: no value of the shunt has one there."""
    tissue, link = hs.environments.kelvin_voigt(100, 1), E.wave_variables(10, "5 ms")
    own = hs.Scene(tissue, (link, E.shunt(Z="(10-a)*s", parameters={"a": 5})))
    [(low, high)] = ends_of(own, "effects.shunt.a", range=(0, 100))
    assert (low, high) == (0, pytest.approx(15.909426991833095, rel=1e-14))


@pytest.mark.slow
def test_a_highest_power_that_comes_late_in_all_its_terms_is_unstable_for_every_delay() -> None:
    """A late mass behind a line without losses: s^4 comes with exp(-s tau) alone."""
    block = hs.environments.mass_spring_damper("0.3 kg", 2, 100)
    own = hs.Scene(block, (E.delay("29 ms"), E.wave_variables(21, "5 ms"))).with_hands(
        hs.Hand("hand", m="1.55 kg", b=19, k=56)
    )
    for free in ("effects.delay.tau", "effects.wave-variables.tau"):
        found = hs.require(own, free, that="stable")
        assert (found.feasible, found.undecided) == ((), ())
    assert held(own, own.hands[0]).roots.chain is RootChain.RIGHT
    words = str(hs.stability(own))
    assert "advanced" in words


@pytest.mark.parametrize("mass", ["0 kg", "0.4 kg"])
def test_an_order_behind_a_delay_is_answered_though_it_is_a_power_that_changes(mass: str) -> None:
    """The highest power of s is 2, whatever the order is; with a mass that comes late it is so twice."""
    own = hs.Scene(hs.environments.spring_pot(300, "1/2"), (E.shunt(m=mass, b=1), E.delay("13 ms")))
    own = own.with_hands(hs.Hand("hand", m="1.8 kg", b=14, k=196))
    found = hs.require(own, "environment.alpha", that="stable")
    assert found.undecided == ()
    inside = [(float(x.low.value or 0), float(x.high.value or 1)) for x in found.feasible]
    for order in ("0.02", "0.2", "0.35", "0.5", "0.65", "0.8", "0.9", "0.98"):
        moved = own.with_values({"environment.alpha": order})
        told = roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0
        assert told == any(low < float(order) < high for low, high in inside), (order, inside)


def ends_of(own: hs.Scene, path: str, **asked: Any) -> list[tuple[float | None, float | None]]:
    found = hs.require(own, path, that="stable", hand=hs.Hand("hand", m=1, b=5, k=20), **asked)
    return [(x.low.value and float(x.low.value), x.high.value and float(x.high.value)) for x in found.feasible]


def test_a_number_that_may_be_negative_is_not_told_by_what_positive_ones_do() -> None:
    """(m + m_h) s^2 + (b + 6) s + 120 of a shunt, and of a formula b s (s^2 + 5 s + 20)/5000 to the third power."""
    tissue = hs.environments.kelvin_voigt(100, 1)
    assert ends_of(hs.Scene(tissue, (E.shunt(b=1),)), "effects.shunt.b") == [(-6, None)]
    assert ends_of(hs.Scene(tissue, (E.shunt(m=1),)), "effects.shunt.m") == [(-1, None)]
    formula = hs.environments.expression("k+b*s", parameters={"k": 100, "b": 3})
    assert ends_of(hs.Scene(formula, (E.compliance(k=5000),)), "environment.b") == [(0, None)]


@pytest.mark.slow
def test_a_number_in_the_formula_of_a_shunt_is_none_of_a_part_that_only_takes_energy() -> None:
    tissue, link = hs.environments.kelvin_voigt(100, 1), E.wave_variables(10, "5 ms")
    own = hs.Scene(tissue, (link, E.shunt(Z="(10-a)*s", parameters={"a": 5})))
    [(low, high)] = ends_of(own, "effects.shunt.a", range=(0, 100))
    assert (low, high and 12 < high < 20) == (0, True)
    found = hs.require(own, "effects.shunt.a", that="passive", range=(0, 100))
    assert all(x.high.value is not None and float(x.high.value) < 12.6 for x in found.feasible)
    hand = hs.Hand("hand", m=1, b=5, k=20)
    for value, stable in ((12, True), (20, False), (50, False)):
        assert held(own.with_values({"effects.shunt.a": value}), hand).stable is stable


def test_an_environment_that_grows_too_fast_makes_a_hand_shake() -> None:
    """With H = k + c s^4 behind a cable two roots lie on the right, as NumPy finds them: Im H is nowhere negative."""
    c, k, cable = 1, 100, 5000
    own = hs.Scene(hs.environments.expression("k+c*s^4", parameters={"k": k, "c": c}), (E.compliance(k=cable),))
    hand = np.array([1, 5, 20])
    tissue = np.array([c, 0, 0, 0, k])
    roots = np.roots(np.polyadd(np.polymul(hand, np.polyadd(tissue, [cable])), cable * tissue))
    assert held(own, hs.Hand("hand", m=1, b=5, k=20)).unstable == (roots.real >= 0).sum() == 2


@pytest.mark.slow
@pytest.mark.parametrize("lag", [Rational(7, 640), Rational(28767, 781250)])
def test_a_highest_power_that_turns_by_more_than_half_a_turn_is_followed(lag: Rational) -> None:
    """m_h s^2 + s + 5 with masses that come late, (3.3 z)^n/n! of 1 kg: exp(3.3 z) has no zero, and turns by 3.3 rad."""
    masses = [Rational(round(3.3**n / factorial(n) * 10**6), 10**6) for n in range(14)]
    behind = [E.delay(pi * lag / 30)]
    for mass in masses[:0:-1]:
        behind += [E.shunt(m=mass), E.delay(lag)]
    own = hs.Scene(hs.environments.mass_spring_damper("1 g", 0, 0), tuple(behind))

    def characteristic(at: Any) -> Any:
        z = np.exp(-at * float(lag))
        late = sum(float(m) * z**n for n, m in enumerate(masses) if n)
        last = 1e-3 * z**13 * np.exp(-at * float(pi * lag / 30))
        return (1 + late + last) * at**2 + at + 5

    assert held(own, hs.Hand("hand", m=1, b=1, k=5)).unstable == winding(characteristic, 1000.0) == 0
