"""How many roots lie on the right, and whether none does: against roots placed by hand, those of mpmath, and winding numbers of contours."""

from __future__ import annotations

import cmath
import random
from fractions import Fraction

import numpy as np
import pytest
import windings
from hypothesis import assume, given
from hypothesis import strategies as st
from marks import rarely
from oracles import MP, Case
from strategies import cases, evaluate
from sympy import Expr, I, Integer, Rational, exp, expand, lambdify, pi, sqrt
from windings import late_mass, winding

import haptisym as hs
from haptisym.effects import compliance, second_order_lowpass, series, zero_order_hold
from haptisym.environments import kelvin_voigt, mass_spring_damper
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import RootChain, Roots, count_roots, floor_of, is_stable

E = exp(-s)
LATE = exp(-pi * s)


def roots(expression: Expr) -> Roots:
    ring = Ring.of([expression])
    return count_roots(ring.convert(expression).numerator, ring)


whole = st.integers(-9, 9)


# Polynomials


@given(st.lists(whole, min_size=2, max_size=8).filter(lambda c: c[0]))
def test_roots_of_polynomials_are_counted_as_mpmath_finds_them(c: list[int]) -> None:
    real = [z.real for z in MP.polyroots(c, maxsteps=2000, extraprec=2000)]
    assume(all(abs(x) > MP.mpf(10) ** -9 for x in real))
    found = roots(sum(n * s**i for i, n in enumerate(reversed(c))))
    assert (found.number, found.right, found.on_axis) == (sum(x > 0 for x in real), sum(x > 0 for x in real), ())


rates = (
    st.fractions(Fraction(1, 9), 9, max_denominator=9).filter(bool).map(lambda x: Rational(x.numerator, x.denominator))
)


@given(
    st.lists(st.tuples(rates, rates, st.sampled_from([-1, 1])), max_size=2),
    st.lists(st.tuples(rates, st.integers(1, 2)), max_size=2, unique_by=lambda x: x[0]), st.integers(0, 3),
)  # fmt: skip
def test_roots_placed_on_the_axis_are_counted_as_often_as_they_are_there(
    pairs: list[tuple[Rational, Rational, int]], on_axis: list[tuple[Rational, int]], at_0: int
) -> None:
    f = s**at_0
    for a, b, side in pairs:
        f *= (s - side * a) ** 2 + b**2
    for w, times in on_axis:
        f *= (s**2 + w**2) ** times
    right = 2 * sum(side > 0 for _, _, side in pairs)
    found = roots(expand(f * (s + 3)))
    assert (found.right, found.number) == (right, right + at_0 + 2 * sum(times for _, times in on_axis))
    assert [float(x) for x in found.on_axis] == pytest.approx(
        sorted([0.0] * (at_0 > 0) + [float(w) for w, _ in on_axis])
    )


# Delays and powers


RIGHT: list[tuple[Expr, int]] = [
    (s + exp(-s), 0), (s + 2 * exp(-s), 2), (s - exp(-s), 1), (s - 5 * exp(-s), 3), (s + 8 * exp(-s), 4), (s + 1 + exp(-s) / 2, 0),
    (2 * s + 1 + s * exp(-s), 0), (s + 2 + exp(-s), 0), (1 + exp(-s) / 2, 0), (s + 1 + s ** Rational(1, 2), 0), (s - s ** Rational(1, 2) + 1, 0),
    (s - Rational(3, 2) * s ** Rational(1, 2) + 1, 2),
]  # fmt: skip
"""Functions whose roots are known: s + a exp(-s) has none up to a = pi/2, then two more with every turn; s - a exp(-s) one up to 3 pi/2."""


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(40))
def test_roots_of_products_are_those_of_their_factors(seed: int) -> None:
    draw = random.Random(seed)
    total, right, axis = Integer(draw.choice([1, -2])), 0, list[Expr]()
    late, own = draw.choice(RIGHT)
    if draw.random() < 0.6:
        total, right = total * late, own
    at_0 = draw.choice([0, 0, 1, 2])
    for _ in range(draw.randint(0, 2)):
        a, b, n = Rational(draw.choice([-3, -1, 1, 2]), 2), draw.randint(1, 6), draw.choice([1, 1, 2])
        match draw.randint(0, 2):
            case 0:
                total, right = total * (s - a) ** n, right + n * bool(a > 0)
            case 1:
                total, right = total * ((s - a) ** 2 + b**2) ** n, right + 2 * n * bool(a > 0)
            case _:
                if b not in axis:
                    total, right, axis = total * (s**2 + b**2) ** n, right, [*axis, *[Integer(b)] * n]
    total *= s**at_0
    ring = Ring.of([late, total.expand()])
    try:
        found = count_roots(ring.convert(total.expand()).numerator, ring)
    except UndecidedError:
        assert (axis and late.has(exp)) or late.has(s ** Rational(1, 2)), total  # whether it is zero just there
        return
    assert found.chain is None
    assert (found.number, found.right) == (right + at_0 + 2 * len(axis), right), total
    expected = sorted({*axis, *([Integer(0)] if at_0 else [])}, key=float)
    assert [round(float(x), 9) for x in found.on_axis] == [float(x) for x in expected]
    stable = is_stable(ring.convert(1 / total.expand()).reduced())
    assert stable in (found.number == 0, None)
    assert stable is not None or ring.functions


LOOPS = [
    s**2 + s + 1 + 5 * E, s**3 + 2 * s**2 + 40 * s * E + 7, s**2 - 3 * s + 2 + E, s + 1 + 20 * E, s**2 + 100 * E + 5 * s,
    s * (2 + E) + 30 * exp(-3 * s), s**2 * (3 - E - E**2) - 8 * s + 50, s**2 * (5 + E + LATE) + 90 * LATE + s,
    # |L| > 0 on the disc though the delayed terms outweigh the undelayed one: z = -1 +- j/sqrt(3) are its zeros
    s * (1 + Rational(3, 2) * E + Rational(3, 4) * E**2) + 1, s**2 * (1 + Rational(3, 2) * E + Rational(3, 4) * E**2) + 400,
    s - 3 * sqrt(s) + 1, s**2 + 5 * sqrt(s) * E + 1, s**2 + 30 * E * sqrt(s) + s, s**2 - 7 * s ** Rational(4, 5) + 9,
]  # fmt: skip


@pytest.mark.dear("s**2*(1 + 3*exp(-s)/2 + 3*exp(-2*s)/4) + 400")
@pytest.mark.parametrize("loop", LOOPS, ids=str)
def test_roots_of_loops_with_delays_and_powers_are_those_that_a_sampled_contour_winds_around(loop: Expr) -> None:
    f = lambdify(s, loop)
    assert roots(loop).right == winding(lambda z: f(z + 1e-3), 60.0)


@rarely(st.lists(whole, min_size=2, max_size=4).filter(lambda c: c[0]), st.lists(whole, min_size=1, max_size=3), rates)
def test_random_loops_with_a_delay_are_counted_as_their_contour_winds(
    a: list[int], b: list[int], lag: Rational
) -> None:
    assume(len(b) < len(a))
    loop = sum(n * s**i for i, n in enumerate(reversed(a))) + exp(-s * lag) * sum(n * s**i for i, n in enumerate(b))
    f = lambdify(s, loop)
    above, below = (winding(lambda z, left=left: f(z + left) + 0 * z, 60.0) for left in (1e-4, -1e-4))
    assume(above is not None and above == below)  # no root on the axis, or hardly beside it
    assert roots(loop).number == above


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", [x for x in range(30) if x != 20])  # 20 has roots on the axis
def test_roots_on_the_right_are_those_that_a_contour_winds_around(seed: int) -> None:
    """Several delays, fractional orders, a delay that comes twice; the highest power of s outweighs what is late in it."""
    draw = random.Random(seed)
    lags = draw.choice([[Rational(1, 2)], [Rational(1, 3), Rational(1, 2)], [Rational(1, 4), pi / 9], [Integer(0)]])
    x = (
        4 * s**2
        + sum(
            (draw.randint(-6, 6) * s**n * exp(-s * draw.choice(lags)) for n in range(2) for _ in range(2)), Integer(0)
        )
        + draw.randint(-5, 5) * s
        + draw.randint(1, 9)
    )
    if seed % 3 == 0:
        x += draw.choice([-2, 3]) * s ** draw.choice([Rational(1, 2), Rational(3, 2), Rational(5, 3)])
    if seed % 4 == 0:
        x += draw.choice([-3, -1, 1, 3]) * s**2 * exp(-s * lags[0])
    ring = Ring.of([x.expand()])
    found = count_roots(ring.convert(x.expand()).numerator, ring)
    assert (found.chain, found.on_axis) == (None, ())
    assert found.right == found.number == winding(lambdify(s, x, "numpy"), 60.0)


@pytest.mark.dear("1 + 3*exp(-s)/2 + 3*exp(-2*s)/4-None", "1 + exp(-pi*s)/3 + exp(-s)/2-None")
@pytest.mark.parametrize(
    ("chain", "where"),
    [
        (1 + 2 * E, RootChain.RIGHT), (2 + 3 * LATE, RootChain.RIGHT), (E, RootChain.RIGHT), (1 + E, RootChain.NEAR), (1 - E**2, RootChain.NEAR),
        (1 + E - E**2, RootChain.RIGHT), (1 - E + E**2, RootChain.NEAR),
        (1 + E / 2 + LATE / 3, None), (1 + Rational(3, 2) * E + Rational(3, 4) * E**2, None),
    ],
    ids=str,
)  # fmt: skip
def test_the_chain_of_a_neutral_function_is_recognised(chain: Expr, where: RootChain | None) -> None:
    found = roots(expand(chain * s**2) + 3 * s + 1)
    assert found.chain is where
    assert (found.number is None) is (where is not None)


def test_a_delay_that_all_terms_share_has_no_roots() -> None:
    assert roots(100 * E).number == 0
    assert roots(expand(E**2 * LATE * (s**2 - s + 4))).right == 2
    assert roots(expand(E * (s + 1 + 2 * s * E))).chain is RootChain.RIGHT


@pytest.mark.parametrize("hand", ["400", "499.9999", "500", "2000"])
def test_a_delayed_mass_is_held_by_no_lighter_one(hand: str) -> None:
    """(500 s^2 + 100) exp(-s/2) + m s^2 + 40 s + 900: the chain lies at Re s = 2 log(500/m)."""
    found = roots((500 * s**2 + 100) * exp(-s / 2) + Rational(hand) * s**2 + 40 * s + 900)
    expected = RootChain.RIGHT if float(hand) < 500 else RootChain.NEAR if hand == "500" else None
    assert found.chain is expected


@pytest.mark.dear("0.5-4")
@pytest.mark.parametrize(("gap", "number"), [("0.5", 4), ("2", 2), ("9.8", 2), ("9.9", 0), ("652", 2)])
def test_beside_a_chain_roots_are_counted_up_to_where_the_late_terms_are_outweighed(gap: str, number: int) -> None:
    """500 kg late by 0.108 s in a slightly heavier hand: A + B exp(-s tau) turns with A from where |A| > |B| on."""
    late = (500 * s**2 + Rational("131.4") * s + 11691) * exp(-s * Rational("0.108"))
    loop = late + (500 + Rational(gap)) * s**2 + 100 * s + 20000
    sampled = late_mass((500, 131.4, 11691), (500 + float(gap), 100, 20000), 0.108)
    assert sampled is not None
    assert (roots(loop).number, windings.winding(*sampled)) == (number, number)
    placed = roots(expand(loop * s * (s**2 + 49) ** 2))  # three roots more, on the axis, two of them double
    assert (placed.number, placed.right, [float(x) for x in placed.on_axis]) == (number + 5, number, [0, 7])


def test_what_is_not_counted_says_so() -> None:
    for loop in (s + 2 + I, s + 3 + E + exp(-1000 * pi * s), s * (1 + E + E * LATE) + 1):
        with pytest.raises(hs.UndecidedError):
            roots(loop)


def test_beside_a_chain_a_delay_that_turns_thousands_of_times_is_not_counted() -> None:
    for mass in (Rational(1001, 1000), Integer(3)):
        with pytest.raises(UndecidedError, match="thousands of times"):
            roots((s**2 + s + 9) * exp(-(10**6) * s) + mass * s**2 + s + 4)


def test_a_delayed_spring_in_a_hand_is_stable_from_the_damping_that_the_field_knows() -> None:
    """100 N/m late by 36 ms in a hand of 0.5 kg: at b the pair is at omega, m omega^2 = k cos, b omega = k sin of omega tau."""

    def spring(b: str) -> int | None:
        return roots(100 * exp(-s * Rational(36, 1000)) + s**2 / 2 + Rational(b) * s).number

    with MP.workdps(30):
        w = MP.findroot(lambda w: w**2 / 2 - 100 * MP.cos(w * MP.mpf("0.036")), 13)
        critical = 100 * MP.sin(w * MP.mpf("0.036")) / w
        assert MP.nstr(critical, 17) == "3.4635997327677041"
        assert (
            spring(MP.nstr(critical - MP.mpf(10) ** -12, 25)),
            spring(MP.nstr(critical + MP.mpf(10) ** -12, 25)),
        ) == (2, 0)


@pytest.mark.dear("0")
@pytest.mark.parametrize("seed", range(2))
def test_what_is_known_to_have_no_root_on_the_right_is_counted_like_anything_else(seed: int) -> None:
    """None but one at 0; and a chain that comes near to the axis is seen."""
    draw = random.Random(seed)
    for _ in range(6):
        total, _ = draw.choice([x for x in RIGHT if not x[1]])
        for _ in range(draw.randint(0, 2)):
            a, b = (Rational(draw.randint(1, 9), 2) for _ in range(2))
            total *= draw.choice([s + a, s**2 + a * s + b])
        at_0 = draw.choice([0, 1])
        ring = Ring.of([total])
        polynomial = ring.convert((total * s**at_0).expand()).numerator
        known, counted = count_roots(polynomial, ring, rests=True), count_roots(polynomial, ring)
        assert (known.number, known.right, known.chain) == (at_0, 0, None)
        assert (counted.number, counted.right, counted.chain) == (at_0, 0, None)
        assert [float(x) for x in known.on_axis] == [float(x) for x in counted.on_axis] == [0.0] * at_0
        late = Ring.of([exp(-s)])
        a, b = draw.randint(1, 9), draw.randint(1, 9)
        mirrored = late.convert(s * (1 + exp(-s)) + a - b * exp(-s) / 10).numerator
        assert count_roots(mirrored, late, rests=True).chain is RootChain.NEAR


# What stands before the highest power


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(12))
def test_a_floor_is_below_what_stands_before_the_highest_power_and_a_chain_is_where_its_zeros_are(seed: int) -> None:
    """L(z) = c_0 + ... + c_n z^n, |z| <= 1; its zeros with |z| < 1 are roots far out on the right."""
    draw = random.Random(seed)
    ring = Ring.of([exp(-s)])
    for _ in range(4):
        c = [draw.randint(-4, 4) for _ in range(draw.randint(2, 4))]
        c[0], c[-1] = c[0] or 3, c[-1] or -1
        group = {(i,): Integer(x) for i, x in enumerate(c) if x}
        zeros = np.roots(c[::-1])
        found = floor_of(group, ring)
        if min(abs(zeros)) < 1 - 1e-6:
            assert found is RootChain.RIGHT
        elif min(abs(zeros)) < 1 + 1e-6:
            assert found is RootChain.NEAR
        else:
            least = min(
                abs(sum(x * cmath.exp(2j * cmath.pi * k * i / 2000) for i, x in enumerate(c))) for k in range(2000)
            )
            assert not isinstance(found, RootChain)
            assert 0 < found <= least + 1e-9
            assert (
                least < 2.01 * found
                or found == c[0] - sum(map(abs, c[1:]))
                or found == abs(c[0]) - sum(map(abs, c[1:]))
                or found == 1
            )
    assert floor_of({(1,): Integer(1)}, ring) is RootChain.RIGHT


def test_two_delays_are_outweighed_or_said_to_be_open() -> None:
    ring = Ring.of([exp(-s), exp(-pi * s)])
    both = {(1, 0): Integer(1), (0, 1): Integer(1)}
    assert floor_of({(0, 0): Integer(3), **both}, ring) == 1
    assert floor_of({(0, 0): -pi, **both}, ring) == pi - 2
    assert floor_of(both, ring) is RootChain.RIGHT
    for group in ({(0, 0): Integer(2), **both}, {(0, 0): Integer(1), (1, 1): Integer(1), (1, 0): Integer(1)}):
        with pytest.raises(UndecidedError):
            floor_of(group, ring)


def test_roots_with_delays_that_are_no_multiples_of_one_are_counted_where_these_cannot_make_a_chain() -> None:
    """s (14 + 3 z1 - 5 z2 - z1 z2) + 1, z1 = exp(-s), z2 = exp(-1.0313 s): no sum of one, as these come as a product too."""
    z1, z2 = exp(-s), exp(-s * Rational(10313, 10000))
    ring = Ring.of([z1, z2])

    def roots(expression: Expr) -> object:
        found = count_roots(ring.convert(expression).numerator, ring)
        return found.chain or found.number

    product_of_two = (5 + z1) * (3 - z2) - 1
    assert roots(s * product_of_two + 1) == 0
    assert roots(s * product_of_two - 1) == 1
    with pytest.raises(UndecidedError):
        roots(s * ((1 + 5 * z1) * (3 - 2 * z2) - 1) + 1)


# Stability


def stable(denominator: Expr, numerator: Expr = 1) -> bool:
    return is_stable(Ring().convert(numerator / denominator).reduced())


@given(st.lists(rates, max_size=3), st.lists(st.tuples(rates, rates), max_size=3))
def test_poles_placed_on_the_left_are_stable(real: list[Rational], pairs: list[tuple[Rational, Rational]]) -> None:
    denominator = expand(placed(real, pairs))
    assert stable(denominator)
    assert stable(-denominator)


@given(
    st.lists(rates, max_size=2), st.lists(st.tuples(rates, rates), max_size=2),
    st.sampled_from([s, s - Rational(1, 3), s**2 + 4, s**2 - s + 1, (s**2 + 1) ** 2, s**4 + 1, s**2 - 2, s**2]),
)  # fmt: skip
def test_one_pole_on_the_axis_or_to_its_right_is_enough_to_be_unstable(
    real: list[Rational], pairs: list[tuple[Rational, Rational]], bad: Expr
) -> None:
    assert not stable(expand(placed(real, pairs) * bad))


def placed(real: list[Rational], pairs: list[tuple[Rational, Rational]]) -> Expr:
    result = s**0
    for a in real:
        result *= s + a
    for a, b in pairs:
        result *= (s + a) ** 2 + b**2
    return result


@pytest.mark.parametrize("digits", [3, 20, 100])
def test_a_hair_beside_the_axis_decides(digits: int) -> None:
    hair = Rational(1, 10**digits)
    assert stable(s**2 + hair * s + 1)
    assert not stable(s**2 - hair * s + 1)
    assert not stable(s**2 + 1)
    # s^3 + s^2 + s + k: stable for k < 1
    assert stable(s**3 + s**2 + s + 1 - hair)
    assert not stable(s**3 + s**2 + s + 1 + hair)
    assert not stable(s**3 + s**2 + s + 1)


def test_pi_decides_exactly() -> None:
    # s^3 + pi s^2 + pi s + k: stable for k < pi^2
    assert stable(s**3 + pi * s**2 + pi * s + Rational("9.8696044010893586188"))
    assert not stable(s**3 + pi * s**2 + pi * s + Rational("9.8696044010893586189"))
    assert not stable(s**3 + pi * s**2 + pi * s + pi**2)


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ((1, 2, 3, 4), True),
        ((-1, -2, -3, -4), True),
        ((1, 2, -3, 4), False),
        ((1, 1, 1, 1), False),
        ((1, 0, 2), False),
        ((3,), True),
        ((1, 1), True),
        ((1, -1), False),
        ((1, 0), False),
    ],
)
def test_few_coefficients_decide_as_by_hand(numbers: tuple[int, ...], expected: object) -> None:
    for scale in (Rational(1), Rational(1, 7), pi, -pi):
        assert stable(sum(scale * c * s**n for n, c in enumerate(reversed(numbers)))) is expected


def test_a_pole_that_cancels_does_not_count() -> None:
    assert stable((s - 1) * (s + 2), s - 1)
    assert not stable((s - 1) ** 2 * (s + 2), s - 1)


def test_the_evaluation_says_whether_what_is_felt_is_stable() -> None:
    spring = mass_spring_damper(k=1)
    for effect, expected in (
        (second_order_lowpass(80, "0.5"), True),
        (second_order_lowpass(80, 0), False),
        (series("1/(s - 1)"), False),
        (series("s + 1"), True),
    ):
        assert hs.evaluate(hs.Scene(spring, (effect,))).stable is expected


@rarely(cases(order=4))
def test_scenes_are_judged_as_mpmath_does(case: Case) -> None:
    real = max((z.real for z in case.poles), default=MP.mpf(-1))
    assume(abs(real) > MP.mpf(10) ** -12)
    assert evaluate(case).stable is bool(real < 0)


def poles_on_the_right(scene: hs.Scene) -> int | None:
    """Zeros of the denominator of H_perc, but for one at 0, by the turns of a dense sample."""
    d = scene.distortion().perc
    D = lambdify([s], d.ring.expression(d.denominator) / s, "numpy")
    return winding(lambda z: D(z + 1e-7), 4000.0)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(12))
def test_the_closed_form_of_a_hold_in_a_loop_is_judged_as_the_winding_number_says(seed: int) -> None:
    """Its pole at 0 is removable: 1 - exp(-s T) vanishes there as well. (An evaluation leaves the sampled loop open.)"""
    k, b, T = 100 * (1 + seed % 6), 1 + 3 * (seed % 4), Rational(1 + 7 * (seed % 5), 200)
    coupling = compliance(k=300 + 400 * (seed % 3), b=1 + 9 * (seed % 2))
    scene = hs.Scene(kelvin_voigt(k, b), (zero_order_hold(T), coupling))
    assert is_stable(scene.distortion().perc) == (poles_on_the_right(scene) == 0)
    assert hs.evaluate(scene).stable is None


def delayed(denominator: Expr, numerator: Expr = 1) -> bool | None:
    f = numerator / denominator
    return is_stable(Ring.of([f]).convert(f).reduced())


@pytest.mark.parametrize(
    ("denominator", "expected"),
    [
        # s + a E is stable for 0 < a < pi/2; at pi/2 a pair on the axis, of two parts that vanish at once: left open
        (s + E, True), (s + pi / 2 * E, None), (s + Rational("1.5707") * E, True), (s + Rational("1.5709") * E, False),
        (s - E, False), (-s - E, True), (s**2 * E + s + 1, False),
        # s + a + b E: stable whatever the delay for |b| < a; a zero at s = 0 for b = -a
        (s + 2 + E, True), (s + 2 - E, True), (s + 2 + 2 * E, True), (s + 2 - 2 * E, False), (s + 2 - 3 * E, False),
        # (s + 1)^2 + 2 E and more: against the first crossing of the axis
        ((s + 1) ** 2 + 2 * E, True), ((s + 1) ** 2 + 9 * E, False), ((s + 1) ** 3 + E, True), ((s + 1) ** 3 + 9 * E, False),
        (s**2 + 1 + E / 10, False), (s**2 + s / 10 + 1, True), ((s**2 + 1) * (s + 2 + E), False),
        # neutral: s (2 + E) + 1 has an undelayed leading term that prevails; s (1 + 2 E) + 1 has a chain on the right
        (s * (2 + E) + 1, True), (s * (2 - E) + 1, True), (s * (2 - E) - 1, False), (s * (1 + 2 * E) + 1, False),
        (s * (2 - 3 * E) + 1, False), (s * (1 + E - exp(-2 * s)) + 1, False),
        # neutral, with roots as near to the axis as one likes
        (s * (1 - E) + 1, None), (s * (E - 1 - exp(-2 * s)) - 1, None), (-s * (2 + E) - 1, True), (s * (3 + E - exp(-2 * s)) + 1, True),
        # advanced: only a delayed term leads
        (s * E + 1, False), (s**2 * E + s + 3, False),
    ],
)  # fmt: skip
def test_delayed_loops_are_judged_as_the_literature_does(denominator: Expr, expected: object) -> None:
    assert delayed(denominator) is expected


@pytest.mark.parametrize("b", [-6, -1, 2, 7])
def test_first_order_loops_with_a_delay_are_judged_by_their_rightmost_root(b: int) -> None:
    """s + a/2 + b/2 exp(-s): the rightmost root is -a/2 + W_0(-b/2 exp(a/2)), by the Lambert function."""
    for a in range(-3, 12, 3):
        with MP.workdps(40):
            root = -MP.mpf(a) / 2 + MP.lambertw(-MP.mpf(b) / 2 * MP.exp(MP.mpf(a) / 2))
        assert delayed(s + Rational(a, 2) + Rational(b, 2) * E) is bool(root.real < 0 and a != -b)


def test_a_pole_at_rest_counts_unless_the_numerator_has_it_too() -> None:
    hold = (1 - E) / s
    assert delayed(s, 1 - E) is True
    assert delayed(s**2, 1 - E) is False
    assert delayed(s**2, (1 - E) ** 2) is True
    assert delayed(s * (s + 1), 1 - E) is True
    assert delayed(s * (s - 1), 1 - E) is False
    assert delayed((s + 1 + E / 2) * s, 1 - E) is True
    assert delayed((s + 1 + 3 * E) * s, 1 - E) is False
    assert delayed(1 - E, s) is None  # a chain of poles on the axis: the leading terms do not outweigh each other
    assert delayed(s + 1 + hold) is True
    assert delayed(s + hold * 9) is False


def test_delays_of_very_different_length_and_friction_below_the_line_are_left_open_and_powers_are_not() -> None:
    assert delayed(s + 3 + E + exp(-pi * s / 1000)) is True
    assert delayed(s + 3 + E + exp(-pi * 1000 * s)) is None
    assert delayed(s + 2 + sqrt(s)) is True
    assert delayed(s + 2 - 3 * sqrt(s)) is False  # s = 1, and s = 4
    assert delayed(s + 2, sqrt(s)) is True
    assert delayed(s + 2 + I) is None
    assert delayed(s + 2, I) is True
    assert delayed(s - 2, I * sqrt(s)) is False
    assert delayed(s + E + sqrt(s) ** 3) is True
    assert delayed(s + 3 * E + sqrt(s) ** 3) is False
