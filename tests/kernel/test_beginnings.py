"""Functions with powers of omega near omega = 0: what cancels there is seen to cancel; crossings against mpmath."""

from __future__ import annotations

import random
from collections.abc import Callable
from math import comb

import mpmath
import pytest
from flint import arb
from marks import spread
from sympy import Rational, pi

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.beginnings import beginning, clear_of_zero
from haptisym.kernel.wavesums import WaveSum, WaveTerm
from haptisym.model.jnd import Part

MEETING = {"1/2": 8, "2/3": 6, "4/3": 3, "4/5": 5}
"""Orders, and of how many half angles alpha pi/4 the sum is a whole number of half turns: there Im (cos + j sin)^m is 0."""


def _sum(draw: random.Random) -> tuple[WaveSum, Callable[[mpmath.mpf], mpmath.mpf]]:
    """Sums of powers omega^(alpha l) of which some begin with what cancels, behind a delay; and the same in mpmath."""
    order, m = draw.choice(list(MEETING.items()))
    alpha, lag = Rational(order), Rational(draw.randint(1, 9), 7)
    nothing = [(-1) ** (k // 2) * comb(m, k) if k % 2 else 0 for k in range(m + 1)]
    terms: dict[tuple[tuple[int, int], int], list[int]] = {}
    for power in range(draw.randint(1, 3)):
        for _ in range(2):
            low, late, size = draw.randint(0, 2), draw.randint(0, 1), draw.choice([-3, 1, 2])
            for k in range(m + 1):
                row = terms.setdefault(((k, late), power), [0] * 5)
                row[low] += size * nothing[k]
                row[low + draw.randint(0, 2)] += draw.randint(-2, 2) * (draw.random() < 0.2 and low > 0)
    kept = {key: row for key, row in terms.items() if any(row)}
    found = WaveSum(
        tuple(WaveTerm(turns, (power,), tuple((c,) for c in row)) for (turns, power), row in kept.items()),
        ((pi * alpha / 2, True), (lag, False)),
        (m, 1),
        (alpha,),
    )

    def value(w: mpmath.mpf) -> mpmath.mpf:
        exponent = mpmath.mpf(alpha.p) / alpha.q
        (c, s), late = (f(mpmath.pi * exponent / 4) for f in (mpmath.cos, mpmath.sin)), w * lag.p / lag.q / 2
        delayed, raised = (mpmath.cos(late), mpmath.sin(late)), w**exponent
        return mpmath.fsum(
            mpmath.polyval(row[::-1], w) * raised**power * s**k * c ** (m - k) * delayed[turn]
            for ((k, turn), power), row in kept.items()
        )

    return found, value


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(20))
def test_the_first_term_that_stays_is_found_and_no_zero_lies_before_the_place_that_is_said_to_be_clear(
    seed: int,
) -> None:
    draw, seen = random.Random(seed), 0
    for _ in range(6):
        f, value = _sum(draw)
        with mpmath.workdps(260):
            near = [value(mpmath.mpf(10) ** n) for n in (-20, -25)]
            if abs(near[0]) < mpmath.mpf(10) ** -200:
                continue  # nothing at all
            exponent = mpmath.log(abs(near[0] / near[1]), 10) / 5
            assert abs(exponent - float(beginning(f).exponent)) < 1e-2
            reach = mpmath.mpf(float(clear_of_zero(f, arb(2))))
            points = [reach * mpmath.mpf(10) ** -n for n in (20, 5, 2, 1)] + [reach * n / 12 for n in range(1, 13)]
            assert {value(x) > 0 for x in points} == {near[0] > 0}
            assert reach > 0
            seen += bool(beginning(f).exponent > 0)
    assert seen > 1


Dynamics = Callable[[mpmath.mpc, mpmath.mpc], mpmath.mpc]
"""What is felt of a dynamics, and s."""
ORDERS = ("1/2", "1/4", "3/4", "1/3", "2/3", "1/8", "2/5", "0.3", "0.37")


def _effect(draw: random.Random) -> tuple[hs.Effect, Dynamics]:
    k, b = draw.choice([200, 500, 900]), draw.choice([1, 2, 10])
    power = Rational(draw.choice(ORDERS))
    exponent = mpmath.mpf(power.p) / power.q
    return draw.choice(
        [
            (effects.compliance(k=k), lambda h, s: h / (1 + h / k)),
            (effects.compliance(b=k), lambda h, s: h / (1 + h / (k * s))),
            (effects.compliance(k=k, b=b), lambda h, s: h / (1 + h / (k + b * s))),
            (effects.shunt(b=b), lambda h, s: h + b * s),
            (effects.shunt(m="0.1", b=b), lambda h, s: h + s * s / 10 + b * s),
            (effects.shunt(k=-b), lambda h, s: h - b),
            (effects.first_order_lag(k), lambda h, s: h * k / (k + s)),
            (effects.series(10 / (10 + hs.s**power)), lambda h, s: h * 10 / (10 + s**exponent)),
        ]
    )


def _scene(draw: random.Random) -> tuple[hs.Scene, Callable[[mpmath.mpf], dict[Part, mpmath.mpf]]]:
    """A scene with a spring-pot, and the excess r - c of both parts at a frequency, written out once more."""
    order, size, k = Rational(draw.choice(ORDERS)), draw.choice([1, 5, 80]), draw.choice([0, 0, 50])
    chain = [_effect(draw) for _ in range(draw.randint(1, 2))]
    environment = environments.spring_pot(size, order, k) if k else environments.spring_pot(size, order)

    def excess(w: mpmath.mpf) -> dict[Part, mpmath.mpf]:
        s = mpmath.mpc(0, w)
        own = felt = k + size * s ** (mpmath.mpf(order.p) / order.q)
        for _, change in chain:
            felt = change(felt, s)
        d = felt - own
        return {part: abs(x) / abs(own) - mpmath.mpf("0.1") for part, x in zip(Part, (d.real, d.imag), strict=True)}

    return hs.Scene(environment, tuple(effect for effect, _ in chain), (0, 15)), excess


def _agrees(seed: int) -> None:
    scene, excess = _scene(random.Random(seed))
    found = [x for x in hs.evaluate(scene).crossings if x.kind.value != "touches"]
    with mpmath.workdps(30):
        grid = sorted(
            {mpmath.mpf(10) ** (mpmath.mpf(n) / 20 - mpmath.mpf("8.0123")) for n in range(180)}
            | {mpmath.mpf(n) / 20 - mpmath.mpf("0.00123") for n in range(1, 301)}
        )
        grid = [w for w in grid if w <= 15]
        values = [excess(w) for w in grid]
        for part in Part:
            signs = [v[part] > 0 for v in values]
            turns = [(a, b) for a, b, x, y in zip(grid, grid[1:], signs, signs[1:], strict=False) if x != y]
            own = [float(x.omega) for x in found if x.part is part and float(x.omega) >= grid[0]]
            assert len(own) == len(turns), (part, own, turns)
            assert all(a <= w <= b for w, (a, b) in zip(own, turns, strict=True))


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(12))
def test_scenes_with_powers_are_decided_from_zero_on(seed: int) -> None:
    _agrees(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", spread(range(12, 200), 2))
def test_many_scenes_with_powers_are_decided_from_zero_on(seed: int) -> None:
    _agrees(seed)


def test_the_real_part_of_s_is_seen_to_vanish_where_s_is_the_square_of_its_root() -> None:
    """Re dH of a spring-pot sqrt(s) behind a compliance k: -80^2/k Re s is no part of its expansion, -905.1 omega^1.5 begins it."""
    found = hs.evaluate(hs.Scene(environments.spring_pot(80, "1/2"), (effects.compliance(k=500),), (0, 15)))
    assert [(x.part, x.omega.digits(12)) for x in found.crossings] == [
        (Part.IMAG, "0.457264930490"),
        (Part.REAL, "11.3360688383"),
    ]
    with mpmath.workdps(40):

        def excess(w: mpmath.mpf) -> mpmath.mpf:
            felt = 80 * mpmath.sqrt(mpmath.mpc(0, w))
            return abs((felt * felt / (felt + 500)).imag) / abs(felt) - mpmath.mpf("0.1")

        assert abs(mpmath.findroot(excess, 0.457) - float(found.crossings[0].omega)) < 1e-12


@pytest.mark.parametrize(
    ("order", "gain"), [("1/2", "1/2"), ("1/3", "2/3"), ("1/4", "3/4"), ("1/7", "6/7"), ("0.37", "0.63")]
)
@pytest.mark.parametrize("delay", ["0 ms", "2 ms"])
def test_what_a_spring_pot_and_a_power_of_s_make_a_damper_has_no_real_part(order: str, gain: str, delay: str) -> None:
    """80 s^a (s^b/10) is 8 s where a + b = 1, as cos(a pi/2 + b pi/2) is 0: r_i = |omega^b/10 - sin(a pi/2)|, late or not."""
    a, b = Rational(order), Rational(gain)
    late = () if delay == "0 ms" else (effects.delay(delay),)
    found = hs.evaluate(hs.Scene(environments.spring_pot(80, a), (effects.series(hs.s**b / 10), *late), (0, 15)))
    assert not found.undecided
    if late:
        assert [x.part for x in found.crossings] == [Part.IMAG] * len(found.crossings)
        return
    assert not found.changeovers_perceived
    assert {x.property.value for x in found.percepts if x.part is Part.REAL} == {"stiffness"}
    with mpmath.workdps(30):
        sine = mpmath.sin(mpmath.pi * a.p / a.q / 2)
        places = [(10 * (sine + mpmath.mpf(c) / 10)) ** (mpmath.mpf(b.q) / b.p) for c in (-1, 1)]
        expected = [w for w in places if w <= 15]
        assert [x.part for x in found.crossings] == [Part.IMAG] * len(expected)
        assert all(
            abs(mpmath.mpf(x.omega.digits(25)) / w - 1) < 1e-23 for x, w in zip(found.crossings, expected, strict=True)
        )


def test_orders_that_meet_sixty_times_between_two_powers_of_omega_are_followed_to_the_first_that_stays() -> None:
    """s^(1/5) and s^(1/4) behind a wave-variable link: what begins there at omega = 0 is found beyond many that cancel."""
    pot, link = environments.spring_pot(1, "1/5", 50), effects.wave_variables(1, "1 ms")
    scene = hs.Scene(pot, (link, effects.series(10 / (10 + hs.s ** Rational(1, 4)))), (0, 15))
    found = hs.evaluate(scene).crossings

    def excess(w: mpmath.mpf, part: Part) -> mpmath.mpf:
        s = mpmath.mpc(0, w)
        own = 50 + mpmath.root(s, 5)
        sent, returned = (own + s) / 2 * mpmath.exp(s / 1000), (s - own) / 2 * mpmath.exp(-s / 1000)
        d = (sent - returned) * s / (sent + returned) * 10 / (10 + mpmath.root(s, 4)) - own
        return abs(d.real if part is Part.REAL else d.imag) / abs(own) - mpmath.mpf("0.1")

    with mpmath.workdps(30):
        grid = [mpmath.mpf(10) ** (mpmath.mpf(n) / 20) for n in range(-160, 24)]
        for part in Part:
            signs = [excess(w, part) > 0 for w in grid]
            turns = [(x, y) for x, y, p, q in zip(grid, grid[1:], signs, signs[1:], strict=False) if p != q]
            own = [float(x.omega) for x in found if x.part is part]
            assert len(own) == len(turns)
            assert all(x <= w <= y for w, (x, y) in zip(own, turns, strict=True))


def test_next_to_the_exact_case_the_real_part_is_seen() -> None:
    """cos(a pi/2 + b pi/2) < 0 where a + b is a little above 1: the real part is that of a mass, however small."""
    scene = hs.Scene(environments.spring_pot(80, "1/3"), (effects.series(hs.s ** Rational("0.666667") / 10),), (0, 15))
    found = hs.evaluate(scene)
    assert {x.property.value for x in found.percepts if x.part is Part.REAL} == {"stiffness-to-mass"}


def test_powers_of_s_that_make_up_one_another_are_nothing_or_everything() -> None:
    """s^(1/2) s^(1/3) s^(1/6)/s is 1, at every frequency: it is seen, although each power is a variable of its own."""
    chain = [effects.series(hs.s ** Rational(x)) for x in ("1/2", "1/3", "1/6", "-1")]
    found = hs.evaluate(hs.Scene(environments.spring_pot(80, "1/2"), tuple(chain), (0, 15)))
    assert (found.crossings, found.percepts, found.undecided) == ((), (), ())
    [whole] = found.transparent
    assert (float(whole.low.omega), float(whole.high.omega)) == (0, 15)
