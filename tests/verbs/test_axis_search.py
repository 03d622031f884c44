"""Critical values that no elimination finds: against winding numbers, roots by mpmath, and what scales and sums must keep."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import Expr, Integer, Rational, Symbol, exp, lambdify, pi
from windings import winding

import haptisym as hs
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import s
from haptisym.verbs.stability.boundary import meetings
from haptisym.verbs.stability.critical import critical
from haptisym.verbs.stability.curves import Meeting, Meetings
from haptisym.verbs.stability.held import held, roots_in_hand
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.pairs import Characteristic
from haptisym.verbs.stability.rightroot import RightRoots
from haptisym.verbs.stability.search import searched

q = Symbol("q", positive=True)
PLAIN = s**2 / 2 + 6 * s + 50
TWO = PLAIN + 100 * exp(-s * q) + 2 * s * exp(-2 * s * q)
ECHOES = (
    PLAIN
    + 60 * exp(-s * q)
    + 40 * exp(-2 * s * q - s * pi / 100)
    + 30 * exp(-s * pi**2 / 500)
    + 2 * s * exp(-3 * s * q)
)
IN_BOTH = PLAIN + 80 * exp(-s * q) + 100 * q * s * exp(-2 * s * q)
STIFFNESS = PLAIN + q * exp(-3 * s / 100) + q**2 / 200 * exp(-s * pi / 200) + q / 2 * exp(-s * pi**2 / 500)
TOUCHING = s**2 + (q - 2) ** 2 * s * (2 + exp(-s / 10) + exp(-s * pi / 40)) + 1


def loop_of(expression: Expr) -> Loop:
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), q, Integer(0))


def last(found: Loop, value: Expr) -> Meetings:
    """All that a search finds."""
    *_, window = searched(found, value, "")
    return window


def first(expression: Expr, value: Expr) -> Meeting:
    """The nearest above a value, of the first window that has one."""
    for window in searched(loop_of(expression), value, ""):
        above = [x for x in window.found if float(x.value) > float(value)]
        if above:
            return min(above, key=lambda x: float(x.value))
    raise AssertionError


def on_the_right(expression: Expr, value: float) -> int | None:
    return winding(lambdify(s, expression.subs(q, value), "numpy"), 400.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("expression", "value"),
    [(TWO, Rational(3, 100)), (ECHOES, Rational(3, 100)), (IN_BOTH, Rational(3, 100)), (STIFFNESS, Integer(100))],
)
def test_a_number_that_stands_in_several_delays_or_powers_turns_two_roots_to_the_right(
    expression: Expr, value: Expr
) -> None:
    found = first(expression, value)
    at = float(found.value)
    assert [on_the_right(expression, x) for x in (float(value), at * (1 - 1e-6), at * (1 + 1e-6))] == [0, 0, 2]
    assert loop_of(expression).at(Rational(str(round(at * 0.999, 6)))).number == 0
    assert loop_of(expression).at(Rational(str(round(at * 1.001, 6)))).number == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("expression", "value"), [(TWO, Rational(3, 100)), (ECHOES, Rational(3, 100)), (STIFFNESS, Integer(100))]
)
def test_fifty_digits_are_those_of_another_root_finder(expression: Expr, value: Expr) -> None:
    found = first(expression, value)
    f = lambdify((s, q), expression, "mpmath")
    with mpmath.workdps(70):

        def parts(omega: mpmath.mpf, x: mpmath.mpf) -> list[mpmath.mpf]:
            y = f(mpmath.mpc(0, omega), x)
            return [y.real, y.imag]

        assert found.omega is not None
        omega, x = mpmath.findroot(parts, (float(found.omega), float(found.value)))
        assert mpmath.almosteq(mpmath.mpf(found.value.digits(52)), x, rel_eps=mpmath.mpf(10) ** -50)
        assert mpmath.almosteq(mpmath.mpf(found.omega.digits(52)), omega, rel_eps=mpmath.mpf(10) ** -50)


@pytest.mark.slow
def test_in_a_slower_time_a_stiffness_stays_and_delays_grow_as_frequencies_fall() -> None:
    own, slow = first(STIFFNESS, Integer(100)), first(STIFFNESS.subs(s, 2 * s), Integer(100))
    assert own.value.digits(40) == slow.value.digits(40)
    assert own.omega is not None
    assert slow.omega is not None
    assert float(slow.omega) == float(own.omega) / 2
    quick = TWO.subs({s: s / 2, q: 2 * q}, simultaneous=True)
    assert float(first(quick, Rational(15, 1000)).value) == float(first(TWO, Rational(3, 100)).value) / 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "low", "high", "number"), [("environment.k", 2, 400, 1), ("tau", 0.0005, 0.7, 4), ("hand.b", 0.01, 6, 1)]
)
def test_both_ways_find_the_same_where_one_equation_is_enough(path: str, low: float, high: float, number: int) -> None:
    scene = hs.load_scene("delayed-spring").with_hands(hs.hands["light-touch"])
    free = scene.knobs[scene.knobs.chosen([path])[0].path]
    loop = Loop.of(scene, scene.hands[0], free)

    def inside(found: Meetings) -> set[str]:
        return {x.value.digits(30) for x in found.found if low < float(x.value) < high and x.omega and float(x.omega)}

    theirs = [*islice(meetings(loop, free.value), 4)][-1]
    mine = [*islice(searched(loop, free.value, ""), 5)][-1]
    assert inside(mine) == inside(theirs)
    assert len(inside(mine)) == number


def test_a_search_stops_when_its_time_is_over() -> None:
    with limited(1e-9), pytest.raises(LimitError):
        list(searched(loop_of(ECHOES), Rational(3, 100), ""))


@pytest.mark.slow
def test_a_touch_is_never_lost_but_told_as_open() -> None:
    """At q = 2 a root comes to the axis and goes back."""
    window = last(loop_of(TOUCHING), Integer(1))
    [gap] = [x for x in window.gaps if "left it open" in x.reason]
    assert gap.low is not None
    assert gap.high is not None
    assert float(gap.low) < 2 <= float(gap.high) < float(gap.low) + 1e-4
    assert not window.found


def test_a_root_passes_through_0_at_an_exact_value() -> None:
    expression = s + 2 - q**2 * exp(-s / 10) - q**3 * exp(-s * pi / 40)
    window = next(searched(loop_of(expression), Integer(1), ""))
    [zero] = [x for x in window.found if x.omega == ExactNumber(Integer(0))]
    assert (zero.value.digits(20), window.gaps) == ("1.0000000000000000000", ())


def test_beside_a_root_that_stays_at_0_another_one_passes_through_it() -> None:
    """C = s^2 + (q^2 - 2) (1 + pi) s + ... : over s it is 0 at s = 0 where q^2 = 2."""
    found = Characteristic(loop_of(s**2 + (q**2 - 2) * (2 - exp(-s) - exp(-s * pi)))).at_0()
    assert [x.digits(10) for x in found] == ["1.414213562", "-1.414213562"]


@pytest.mark.slow
def test_the_order_of_a_tissue_has_a_critical_value() -> None:
    """(80 s^alpha + 120) exp(-s/500) 50 pi/(s + 50 pi), held by 0.1 kg and 0.1 N s/m."""
    scene = hs.load_scene("organ-tissue").with_hands(hs.hands["light-touch"])
    found = critical(scene, scene.hands[0], scene.knobs["environment.alpha"])
    [value] = found.found
    assert (value.below, value.above, found.reason) == (2, 0, "")
    at = float(value.value)
    assert at == pytest.approx(0.461113, abs=1e-6)

    def roots(alpha: float) -> int | None:
        def f(x: np.ndarray) -> np.ndarray:
            tissue = (80 * x**alpha + 120) * np.exp(-x / 500) * 50 * np.pi
            return tissue + (x**2 / 10 + x / 10) * (x + 50 * np.pi)

        return winding(f, 5000.0)

    assert [roots(at * x) for x in (0.8, 0.9999, 1.0001, 1.2)] == [2, 2, 0, 0]
    allowed = hs.require(scene, "environment.alpha", that="stable")
    [(low, high)] = [(float(x.low.value or 0), float(x.high.value or 0)) for x in allowed.feasible]
    assert (low, high, allowed.certified) == (at, pytest.approx(0.808841, abs=1e-6), True)
    assert [roots(high * x) for x in (0.9999, 1.0001, 1.1)] == [0, 2, 2]


@pytest.mark.slow
def test_what_moves_together_is_critical_by_its_sum() -> None:
    """The master's mass and the hand's stand in one place: 0.1 kg and 0.5 kg in the scene."""
    scene = hs.load_scene("position-force-teleoperation").with_hands(hs.hands["light-touch"])
    masses = []
    for path, other in (("effects.teleoperator.Mm", "0.1"), ("hand.m", "0.5")):
        found = critical(scene, scene.hands[0], scene.knobs[path])
        [row] = found.found
        assert (row.below, row.above) == (2, 0)
        masses.append(mpmath.mpf(row.value.digits(15)) + mpmath.mpf(other))
    assert abs(masses[0] - masses[1]) < 1e-14


def test_what_was_found_stays_found_where_the_other_side_cannot_be_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def cut_short(loop: Loop, value: Expr) -> Iterator[Meetings]:
        yield from islice(meetings(loop, value), 5)
        raise UndecidedError("the rest")

    scene = hs.load_scene("delayed-spring").with_hands(hs.hands["light-touch"])
    monkeypatch.setattr("haptisym.verbs.stability.critical.meetings", cut_short)
    found = critical(scene, scene.hands[0], scene.knobs["environment.k"])
    assert ([x.value.digits(7) for x in found.found], found.reason) == (["2.794315"], "the rest")
    monkeypatch.setattr("haptisym.verbs.require.held.meetings", cut_short)
    own = hs.Scene(
        hs.environments.mass_spring_damper("250 g", 0, 282), (hs.effects.first_order_lag(348), hs.effects.delay("4 ms"))
    ).with_hands(hs.Hand("hand", m="1.8 kg", b=14, k=196))
    asked = hs.require(own, "hand.k", that="stable")
    [span] = asked.feasible
    assert (float(span.low.value or 0), span.high.value and float(span.high.value) > 3000) == (0, True)
    assert [low is not None for low, high in asked.undecided if high is None] == [True]
    assert asked.reason == "the rest"


delays = st.sampled_from([q, 2 * q, q + Rational(1, 5), Rational(3, 10), pi / 20, q * pi / 3, Integer(0)])
factors = st.sampled_from([q, q**2, Integer(1), q / 2, (q - 1) * q, -q / 3, Integer(-3)])
plain = st.sampled_from([3 * s**2 + s + 8, s**2 + 5 * s, s + 2, 8 * s**2 + 2 * s + 20, s**3 + 3 * s**2 + 24 * s + 5])


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(plain, st.lists(st.tuples(factors, delays), min_size=1, max_size=3))
def test_between_all_that_is_found_random_loops_keep_their_winding_numbers(
    own: Expr, terms: list[tuple[Expr, Expr]]
) -> None:
    expression = own + sum((c * exp(-s * lag) for c, lag in terms), Integer(0))
    if q not in expression.free_symbols:
        return
    window = [*islice(searched(loop_of(expression), Integer(1), ""), 2)][-1]
    assert window.above is not None
    assert window.below is not None
    inside = (float(x.value) for x in window.found if window.above < float(x.value) < window.below)
    places = [float(window.above), *sorted(inside), float(window.below)]
    open_ones = [(float(gap.low or 0), float(gap.high or 0)) for gap in window.gaps]
    for low, high in pairwise(places):
        if high - low > 1e-6 and not any(a <= high and low <= b for a, b in open_ones):
            counts = {
                winding(lambdify(s, expression.subs(q, low + (high - low) * x) + 0 * s, "numpy"), 60.0)
                for x in (0.01, 0.4, 0.99)
            }
            assert len(counts - {None}) <= 1, (expression, low, high, counts)


def late_link() -> hs.Scene:
    """Position-force teleoperation behind 13 ms: three products of delays."""
    link = hs.effects.position_force_teleoperator(Mm="0.5 kg", Ms="2 kg", Bs="64 N*s/m", Ks="40 N/m", tau="10 ms")
    scene = hs.Scene(hs.environments.kelvin_voigt("120 N/m", "3 N*s/m"), (hs.effects.delay("13 ms"), link))
    return scene.with_hands(hs.Hand("hand", m="0.6 kg", b="9 N*s/m", k="200 N/m"))


@pytest.mark.slow
def test_a_stiffness_behind_three_late_products_is_required_up_to_its_critical_value() -> None:
    scene = late_link()
    found = hs.require(scene, "environment.k", (50, 1000), that="stable")
    assert [float(x.low.value or 0) for x in found.feasible] == [50]
    [high] = [float(x.high.value or 0) for x in found.feasible]
    assert (high, found.undecided) == (pytest.approx(251.1710946, rel=1e-8), ())
    right = RightRoots(Loop.of(scene, scene.hands[0], scene.knobs["environment.k"]))
    assert right.everywhere(ExactNumber(Rational(252)), ExactNumber(Rational(253)))
    assert not right.everywhere(ExactNumber(Rational(250)), ExactNumber(Rational(252)))


@pytest.mark.slow
def test_where_no_search_went_is_told_with_its_reason() -> None:
    tissue, hand = hs.environments.spring_pot(60, "1/10"), hs.Hand("hand", m="0.75 kg", b=7, k=211)
    lags = (hs.effects.first_order_lag(436), hs.effects.compliance(k=7408), hs.effects.first_order_lag(499))
    found = hs.require(hs.Scene(tissue, lags), "environment.alpha", that="stable", hand=hand)
    assert "no search went there" in found.reason
    assert float(found.undecided[-1][1] or 0) == 1
    assert not found.certified


@pytest.mark.slow
def test_mass_in_the_hand_that_holds_three_late_products_is_told_without_end() -> None:
    scene = late_link()
    found = hs.require(scene, "hand.m", that="stable")
    assert found.certified
    inside = [(float(x.low.value or 0), float("inf" if x.high.value is None else x.high.value)) for x in found.feasible]
    for value in (0.003, 0.6, 40, 3000, 10**6, 10**9):
        moved = scene.with_hands(hs.Hand("hand", m=value, b="9 N*s/m", k="200 N/m"))
        counted = roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0
        assert counted == any(low < value < high for low, high in inside), value


@pytest.mark.slow
@pytest.mark.parametrize("path", ["hand.m", "environment.k"])
def test_late_friction_is_open_with_its_reason(path: str) -> None:
    scene = late_link()
    rough = hs.Scene(scene.environment, (*scene.effects, hs.effects.coulomb_friction("0.2 N", "5 mm")))
    found = hs.require(rough, path, that="stable", hand=scene.hands[0])
    assert (found.feasible, "sliding friction" in found.reason) == ((), True)


@pytest.mark.slow
def test_a_link_that_comes_back_late_holds_whatever_the_hand_damps() -> None:
    """Two multiples of one delay stand with the highest power of s, whose factor keeps clear of 0 on the unit circle."""
    link = hs.effects.wave_variables("10 N*s/m", "20 ms")
    chain = (link, hs.effects.shunt(m="0.3 kg", b="1 N*s/m", k="20 N/m"), hs.effects.delay("20 ms"))
    scene = hs.Scene(hs.environments.kelvin_voigt("120 N/m", "3 N*s/m"), chain)
    held_by = scene.with_hands(hs.Hand("hand", m="0.6 kg", b="9 N*s/m", k="200 N/m"))
    found = hs.require(held_by, "hand.b", (0, 2000), that="stable")
    assert [(float(x.low.value or 0), float(x.high.value or 0)) for x in found.feasible] == [(0, 2000)]
    assert found.certified
    for b in ("0", "0.5", "40", "700", "2000"):
        hand = hs.Hand("hand", m="0.6 kg", b=b, k="200 N/m")
        assert held(scene, hand).unstable == 0


def test_where_two_roots_are_in_common_at_once_the_value_is_not_that_of_one_alone() -> None:
    """An all-pass of second order: at 14.54 rad/s both tau, and another one, are roots of real and imaginary part."""
    chain = (hs.effects.pade_delay("10 ms", 2),)
    scene = hs.Scene(hs.environments.kelvin_voigt("120 N/m", "3 N*s/m"), chain)
    hand = hs.Hand("hand", m="0.6 kg", b="1 N*s/m")
    found = hs.require(scene, "effects.pade-delay.tau", ("1 ms", "100 ms"), that="stable", hand=hand)
    [high] = [float(x.high.value or 0) for x in found.feasible]
    assert (high, found.certified) == (pytest.approx(0.03182965, abs=1e-8), True)
    for tau, number in (("31.8 ms", 0), ("31.9 ms", 2)):
        assert held(scene.with_values({"effects.pade-delay.tau": tau}), hand).unstable == number


def test_a_number_that_is_squared_puts_a_root_at_0_where_the_sum_of_all_stiffnesses_does() -> None:
    """s^2 + (2 + q) s + q^2 + q/2 - 1: stable from the root of q^2 + q/2 = 1 on."""
    loop = loop_of(s**2 + (2 + q) * s + q**2 + q / 2 - 1)
    [zero] = [
        x for x in next(meetings(loop, Integer(1))).found if x.omega == ExactNumber(Integer(0)) and float(x.value) > 0
    ]
    assert zero.value.digits(12) == "0.780776406404"


@pytest.mark.slow
def test_a_long_delay_of_a_soft_display_is_told_though_the_rest_of_it_is_stiff() -> None:
    """5000 (200 + 2 s) exp(-s tau) + (5200 + 2 s) (0.7 s^2 + 31 s + 110): far out the rest has a root at -2600."""
    late, felt = hs.effects.delay("12 ms"), hs.effects.shunt(m="0.2 kg", b=1, k=10)
    own = hs.Scene(hs.environments.kelvin_voigt(200, 2), (hs.effects.compliance(k="5 kN/m"), late, felt))
    own = own.with_hands(hs.Hand("hand", m="0.5 kg", b=30, k=100))
    [found] = critical(own, own.hands[0], own.knobs["tau"]).found
    exact = mpmath.mp.clone()
    exact.dps = 30

    def loop(w: mpmath.mpf, tau: mpmath.mpf) -> list[mpmath.mpf]:
        z = exact.mpc(0, w)
        value = 5000 * (200 + 2 * z) * exact.exp(-z * tau) + (5200 + 2 * z) * (0.7 * z * z + 31 * z + 110)
        return [value.real, value.imag]

    w, tau = exact.findroot(loop, (5.5, 0.38))
    assert abs(exact.mpf(found.value.digits(14)) - tau) < 1e-13
    assert found.omega is not None
    assert abs(exact.mpf(found.omega.digits(14)) - w) < 1e-12
    for at, expected in ((0.379, 0), (0.383, 2)):
        f = lambda s, at=at: 5000 * (200 + 2 * s) * np.exp(-s * at) + (5200 + 2 * s) * (0.7 * s * s + 31 * s + 110)  # noqa: E731
        assert winding(f, 1000) == expected
    assert (found.below, found.above, found.stable_side) == (0, 2, "below")
    asked = hs.require(own, "tau", (0, 1), that="stable", hand="hand")
    assert [float(x.high.value or 0) for x in asked.feasible] == [pytest.approx(float(tau))]
    assert not asked.undecided
    longer = hs.require(own, "tau", that="stable", hand="hand")
    assert (longer.undecided, [float(x.high.value or 0) for x in longer.feasible]) == ((), [pytest.approx(float(tau))])
