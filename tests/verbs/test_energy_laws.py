"""Im(N conj D) of one number over cells: reach, what prevails at rest and far out, what is clear and what is active."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import product
from math import pi
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from sympy import Expr, I, Integer, Rational, Symbol, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.symbols import s
from haptisym.verbs.require.energy import Energy
from haptisym.verbs.require.energyterms import Term

Q = Symbol("q", real=True)
MP = mpmath.mp.clone()
MP.dps = 60
Row = list[tuple[Fraction, int, int, Fraction]]
"""c q^i s^p exp(-s lag), as (c, i, p, lag)."""


def energy(above: Row, below: Row) -> Energy:
    return Energy([[Term(Integer(p), frac(lag), frac(c) * Q**i) for c, i, p, lag in row] for row in (above, below)], Q)


def frac(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def value(row: Row, omega: Any, q: Any) -> Any:
    z = MP.mpc(0, omega)
    return MP.fsum(number(c) * q**i * z**p * MP.exp(-z * number(lag)) for c, i, p, lag in row)


def number(x: Fraction) -> Any:
    return MP.mpf(x.numerator) / x.denominator


def imag(above: Row, below: Row, omega: Any, q: Any) -> Any:
    return (value(above, omega, q) * MP.conj(value(below, omega, q))).imag


def drawn(pick: Random, powers: Iterable[int], late: Iterable[int]) -> Row:
    found = [(Fraction(pick.choice([-3, -1, 2, 5]), 2), pick.randint(0, 1), p, Fraction(0)) for p in powers]
    late_ones = [(pick.choice([-1, 1, 2]), pick.randint(0, 1), p, pick.randint(1, 4)) for p in late]
    return found + [(Fraction(c, 4), i, p, Fraction(lag, 8)) for c, i, p, lag in late_ones]


# --- far out ----------------------------------------------------------------------------------------------------------


def plain_reach(above: Row, below: Row, q: Fraction) -> float | None:
    """The first power of two from 2^-20 on from which the highest power outweighs the sizes of all others, in fractions."""
    sure, doubt = dict[int, Fraction](), dict[int, Fraction]()
    for (c, i, p, x), (d, k, n, y) in product(above, below):
        size = c * q**i * d * q**k
        turn = (0, 1, 0, -1)[(p - n) % 4]
        if not x and not y:
            sure[p + n] = sure.get(p + n, Fraction(0)) + turn * size
        else:
            doubt[p + n] = doubt.get(p + n, Fraction(0)) + abs(size)
    pairs = [(x, y) for x, y in product(above, below) if not x[3] and not y[3] and (x[2] - y[2]) % 2]
    sure = {p: x for p, x in sure.items() if any(x[2] + y[2] == p for x, y in pairs)}
    powers = sorted({*sure, *doubt})
    if not powers or powers[-1] not in sure:
        return None
    top = powers[-1]
    least = sure[top] - doubt.get(top, Fraction(0))
    radius = Fraction(1, 2**20)
    while radius < 2**60 and least > 0:
        if least > sum(
            (abs(sure.get(p, Fraction(0))) + doubt.get(p, Fraction(0))) * radius ** (p - top) for p in powers[:-1]
        ):
            return float(radius)
        radius *= 2
    return None


@pytest.mark.parametrize("seed", range(12))
def test_what_is_beyond_the_reach_is_outweighed_by_the_highest_power(seed: int) -> None:
    """Of early and late terms; each of its own power, so that sizes are those of single terms: the least power of two."""
    pick = Random(seed)
    above = drawn(pick, range(pick.randint(1, 3) + 1), pick.sample(range(4), pick.randint(0, 2)))
    below = drawn(pick, range(pick.randint(0, 1) + 1), [pick.randint(0, 1)] * pick.randint(0, 1))
    q = Fraction(5, 4)
    found = energy(above, below)._reach((1.25, 1.25))
    assert found == plain_reach(above, below, q)
    if found is not None:
        assert all(imag(above, below, found * MP.mpf(1.1) ** n, MP.mpf(1.25)) > 0 for n in range(60))
        wide = energy(above, below)._reach((1.0, 1.5))
        assert wide is None or wide >= found


@pytest.mark.parametrize("seed", range(8))
def test_what_prevails_far_out_and_at_rest_has_the_sign_that_digits_say(seed: int) -> None:
    """At 10^30 and 10^-30 rad/s, for many numbers q; where all terms are early it is known unless all of it is 0."""
    pick = Random(seed)
    late = pick.sample(range(2), pick.randint(0, 1))
    above = drawn(pick, pick.sample(range(4), pick.randint(1, 3)), late)
    below = drawn(pick, pick.sample(range(3), pick.randint(1, 2)), [])
    form = energy(above, below)
    if form.far is not None:
        top, sign = form.far
        for q in (-3, -1, 1, 2):
            here = imag(above, below, MP.mpf(10) ** 30, MP.mpf(q)) / MP.mpf(10) ** (30 * int(top))
            assert abs(here - number(Fraction(int(sign.form.subs(Q, q).p), int(sign.form.subs(Q, q).q)))) < 1e-20
            assert sign.at(Integer(q)) == MP.sign(here if abs(here) > 1e-20 else 0)
    odd = any((x[2] - y[2]) % 2 for x, y in product(above, below))
    assert (form.far is not None) or bool(late) or not odd
    try:
        at_rest = form.at_0
    except UndecidedError:
        assert late or not odd
        return
    for q in (-3, 2):
        near = imag(above, below, MP.mpf(10) ** -30, MP.mpf(q)) / MP.mpf(10) ** (-30 * int(form._lowest))
        known = at_rest.subs(Q, q)
        assert abs(near - number(Fraction(int(known.p), int(known.q)))) < 1e-20


@pytest.mark.parametrize("seed", range(5))
def test_where_all_that_prevails_comes_late_it_turns_and_is_negative_somewhere_far_out(seed: int) -> None:
    """Of the highest powers of N all late, of D one that is not: at frequencies of some turns Im(N conj D) < 0."""
    pick = Random(seed)
    above = drawn(pick, range(2), []) + drawn(pick, [], [2] * pick.randint(1, 2))
    above = [(c, i, p, lag + Fraction(n, 16)) if lag else (c, i, p, lag) for n, (c, i, p, lag) in enumerate(above)]
    below = drawn(pick, range(pick.randint(1, 2)), [])
    if pick.random() < 0.4:
        above.append((Fraction(1), 1, 2, Fraction(0)))
    form = energy(above, below)
    early = any(not lag for _, _, p, lag in above if p == 2)
    assert (form.turning is None) is early
    if early:
        return
    assert form.turning is not None
    for q in (-2, 1, 3):
        assert form.turning.at(Integer(q)) == -1
        far = [imag(above, below, MP.mpf(10) ** 4 + MP.mpf(n) / 3, MP.mpf(q)) for n in range(200)]
        assert min(far) < 0 < max(far)


def test_where_one_of_the_late_terms_is_there_for_every_number_it_turns_for_all_of_them() -> None:
    one, two, early = (
        (Fraction(1), 1, 2, Fraction(1)),
        (Fraction(1), 0, 2, Fraction(2)),
        (Fraction(1), 0, 0, Fraction(0)),
    )
    for above, below, signs in (
        ([one], [early], [0, -1]),
        ([one, two], [early], [-1, -1]),
        ([two, one], [early], [-1, -1]),
        ([two], [(Fraction(1), 1, 1, Fraction(0)), early], [0, -1]),
        ([two], [two], None),
        ([two], [(Fraction(1), 0, 2, Fraction(0)), two], None),
    ):
        sign = energy(above, below).turning
        assert (sign and [sign.at(Integer(n)) for n in (0, 2)]) == signs


@pytest.mark.parametrize("seed", range(6))
def test_for_large_positive_s_the_sign_is_that_of_the_highest_early_powers(seed: int) -> None:
    """N D at s = 10^9, where what is late has faded to nothing; nothing is told where all of either is late."""
    pick = Random(seed)
    above, below = (drawn(pick, pick.sample(range(4), pick.randint(0, 2)), [pick.randint(0, 4)]) for _ in range(2))
    sign = energy(above, below).far_right
    known = [[x for x in row if not x[3]] for row in (above, below)]
    assert (sign is None) is not all(known)
    if sign is not None:
        for q in (-3, 1, 2):
            at = [sum(float(c) * q**i * 1e9**p for c, i, p, _ in row) for row in known]
            assert sign.at(Integer(q)) == np.sign(at[0] * at[1])


def test_the_number_before_the_highest_power_is_known_where_none_of_it_is_late() -> None:
    early, late = (Fraction(3), 1, 2, Fraction(0)), (Fraction(1), 0, 2, Fraction(1))
    low = [(Fraction(7), 0, 1, Fraction(0)), (Fraction(7), 0, 0, Fraction(1))]
    assert energy([early, *low], low).top == 3 * Q
    assert energy([early, (Fraction(2), 0, 2, Fraction(0)), *low], low).top == 3 * Q + 2
    assert energy([early, late, *low], low).top is None
    assert energy([late, *low], low).top is None


# --- cells ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(2))
def test_what_is_clear_or_active_with_some_room_is_told_to_be(seed: int) -> None:
    """A spring k late by tau, a damper b and a mass: Im H/omega = b - k tau sinc(omega tau), from rest or from a frequency on."""
    pick = Random(seed)
    k, tau = Fraction(pick.randint(1, 40)), Fraction(pick.randint(1, 20), 10)
    m = Fraction(pick.randint(0, 2))
    above: Row = [(m, 0, 2, Fraction(0)), (Fraction(1), 1, 1, Fraction(0)), (k, 0, 0, tau)]
    form = energy(above, [(Fraction(2), 0, 0, Fraction(0))])
    worst = float(k * tau)
    for share, wide in product((0.5, 0.9, 1.05, 1.5, 4.0), (0.0, 0.02)):
        span = worst * share, worst * (share + wide)
        is_clear, is_active = share > 1, share + wide < 1
        assert form.clear(span) is is_clear
        active = form.active_at(span)
        assert (active is not None) is is_active
        if active is not None:
            assert active >= 0
            assert all(
                b - worst * (np.sin(active * float(tau)) / (active * float(tau)) if active else 1) < 0 for b in span
            )
    # beyond 3 pi/(2 tau) sinc is 0.13 at most, and beyond 5 pi/(2 tau) it is again, before it is less
    start = 3 * pi / 2 / float(tau)
    assert form.clear((0.2 * worst, 0.25 * worst), start)
    assert not form.clear((0.05 * worst, 0.06 * worst), start)
    assert not form.clear((0.2 * worst, 0.25 * worst), 0.3 * start)
    reach = form._reach((0.2 * worst, 0.25 * worst))
    assert reach is not None
    assert reach > start
    assert form.clear((0.2 * worst, 0.25 * worst), reach)


@pytest.mark.parametrize("seed", range(4))
def test_of_polynomials_all_frequencies_are_clear_where_all_roots_of_im_h_keep_off(seed: int) -> None:
    """(s^2 + a s + w^2) (s + g) over s + h and a number before it: by roots of Im(N conj D)/omega in numpy."""
    pick = Random(seed)
    a, w, g, h = (pick.uniform(0.2, 4) for _ in range(4))
    above: Row = [
        (Fraction(x).limit_denominator(1000), i, p, Fraction(0))
        for x, i, p in ((1, 0, 3), (a + g, 0, 2), (w + a * g, 1, 1), (w * g, 0, 0))
    ]
    below: Row = [(Fraction(1), 0, 1, Fraction(0)), (Fraction(h).limit_denominator(1000), 0, 0, Fraction(0))]
    form, told = energy(above, below), 0
    for q in (0.25, 1.0, 4.0, 16.0):
        c3, c2, c1, c0 = (float(c) * q**i for c, i, _, _ in above)
        d = float(below[1][0])
        # Im((-j w^3 c3 - c2 w^2 + j w c1 + c0)(d - j w))/w = (c2 - c3 d) w^2 + c1 d - c0, in x = w^2
        slope, start = c2 - c3 * d, c1 * d - c0
        clear = slope >= 0 and start > 0
        if min(abs(slope), abs(start)) < 0.05:
            continue
        told += 1
        assert form.clear((q, q)) is clear
        active = form.active_at((q, q))
        if start < 0:
            assert active is not None
        if active is not None:
            assert slope * active**2 + start < 0
        low, high = (x[0] for x in form._bounds(np.array([1.5]), (q, q)))
        assert low <= slope * 2.25 + start <= high
        assert high - low < 1e-9 * (1 + abs(low))
    assert told


def test_some_turns_of_the_longest_delay_are_looked_at_where_nothing_settles_the_sign() -> None:
    row: list[Term] = [
        Term(Integer(1), Q / 3, Integer(1)),
        Term(Integer(0), Q, Integer(1)),
        Term(Integer(2), Integer(0), Q),
    ]
    assert Energy([row, []], Q)._turns((1.0, 3.0)) == 10
    assert Energy([[], row], Q)._turns((3.0, 5.0)) == 5
    assert Energy([row[2:], []], Q)._turns((1.0, 3.0)) == 20
    assert Energy([row[1:], []], Q)._turns((-4.0, 2.0)) == 20  # no delay is negative
    late = energy([(Fraction(1), 0, 1, Fraction(2))], [(Fraction(1), 1, 0, Fraction(0))])
    active = late.active_at((1.0, 2.0))
    assert active is not None
    assert np.cos(2 * active) < 0  # Im(j w exp(-2 j w)) = w cos 2 w


def test_what_has_friction_or_a_power_that_changes_is_not_told() -> None:
    ring = Ring.of([Q, exp(-s), s**Q])
    with pytest.raises(UndecidedError, match="power of s changes"):
        Energy.of(ring.convert(s**Q + s * Q), Q)
    ring = Ring.of([Q, exp(-s), I * Q])
    with pytest.raises(UndecidedError, match="friction"):
        Energy.of(ring.convert(s + I * Q), Q)
    ring = Ring.of([Q, exp(-s), s ** Rational(1, 2)])
    rows = Energy.of(
        ring.convert(3 * Q * s ** Rational(3, 2) * exp(-2 * s) + 5) / ring.convert(s + Integer(1)), Q
    )._rows
    told: list[set[tuple[Expr, Expr, Expr]]] = [{(x.power, x.lag, x.number) for x in row} for row in rows]
    assert told == [{(Rational(3, 2), 2, 3 * Q), (0, 0, 5)}, {(1, 0, 1), (0, 0, 1)}]
