"""The free response of zeros that were put there: which pair outlasts all others, its numbers and its tolerances."""

from __future__ import annotations

import random
from itertools import product
from math import atan, exp, pi
from types import SimpleNamespace
from typing import Any

import mpmath
import pytest
from sympy import Expr, Integer, Poly, Rational
from sympy import exp as late

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s
from haptisym.verbs.metrics.disagreements import _ACTIVE, _BLIND, _COARSE, _SLACK, _STRICT, disagreements
from haptisym.verbs.metrics.freeresponse import (
    ComplexPair,
    FreeResponse,
    _checks,
    _dominant,
    _same_zeros,
    free_response,
)
from haptisym.verbs.metrics.unconditional import Unconditional, _poles


def pair_of(sigma: Any, omega: Any, *others: Any) -> ComplexPair:
    shape = (s + Rational(sigma)) ** 2 + Rational(omega) ** 2
    for x in others:
        shape *= s + Rational(x)
    return ComplexPair(tuple(Poly(shape.expand(), s).all_coeffs()[::-1]))


@pytest.mark.parametrize(("sigma", "omega"), [("1/2", 3), (2, 1), ("1/10", 40), ("1/1000", "1/7")])
def test_the_numbers_of_a_pair_are_closed_forms_to_any_digits(sigma: Any, omega: Any) -> None:
    pair = pair_of(sigma, omega, 700)
    with mpmath.workdps(60):
        a, w = (mpmath.mpf(Rational(x).p) / Rational(x).q for x in (sigma, omega))
        known = {
            pair.sigma: a, pair.omega_d: w, pair.period: 2 * mpmath.pi / w,
            pair.first_crossing: (mpmath.pi - mpmath.atan(w / a)) / w,
            pair.overshoot(1): mpmath.exp(-mpmath.pi * a / w), pair.overshoot(3): mpmath.exp(-3 * mpmath.pi * a / w),
        }  # fmt: skip
        for number, true in known.items():
            assert abs(mpmath.mpf(number.digits(45)) / true - 1) < mpmath.mpf(10) ** -44
    count = 0
    while count < 1000 and exp(-(count + 1) * pi * float(a) / float(w)) > 0.05:
        count += 1
    assert pair.significant == count


NONE_SWINGS = "not offered: no zero is complex"
NONE_LASTS = "not offered: no complex pair of zeros decays 3 times as slowly"
STAYS = "not offered: the free response does not die out"


@pytest.mark.parametrize("seed", range(3))
def test_a_pair_is_the_dominant_one_if_all_others_decay_more_than_three_times_as_fast(seed: int) -> None:
    draw = random.Random(seed)
    ring, told = Ring.of([s]), set[str]()
    for _ in range(14):
        places = draw.sample([Rational(n, 4) for n in (-1, 1, 2, 3, 5, 6, 7, 13, 20, 25)], draw.randint(1, 3))
        zeros: list[complex] = []
        shape: Expr = Integer(draw.choice([-2, 1]))
        for x in places:
            w = draw.choice([0, 1, 3])
            shape *= (s + x) ** 2 + w**2 if w else s + x
            zeros += [complex(-x, w), complex(-x, -w)] if w else [complex(-x)]
        found = _dominant(ring.convert(shape.expand()))
        slowest = max(zeros, key=lambda z: (z.real, z.imag))
        swinging = [z for z in zeros if z.imag > 0]
        first = max(swinging, key=lambda z: z.real) if swinging else None
        if slowest.real >= 0:
            words = STAYS
        elif first is None:
            words = NONE_SWINGS
        elif all(z.real < 3 * first.real for z in zeros if z not in (first, first.conjugate())):
            words = ""
        else:
            words = NONE_LASTS
        told.add(words)
        if words:
            assert isinstance(found, str)
            assert found.startswith(words), (zeros, found)
        else:
            assert isinstance(found, ComplexPair)
            assert first is not None
            assert [float(found.sigma), float(found.omega_d)] == pytest.approx([-first.real, first.imag])
    assert len(told) >= 3


def test_zeros_that_are_repeated_or_not_finitely_many_are_not_judged_and_at_three_times_it_is_no_outlasting() -> None:
    ring = Ring.of([s, late(-s), s ** Rational(1, 2)])
    for expression, words in (
        ((s**2 + s + 5) * (s + 4) ** 2, "a zero is repeated"),
        (s**2 + s + 5 + late(-s), "not finitely many"),
        (s**2 + s ** Rational(1, 2) + 5, "not finitely many"),
        ((s**2 + 2 * s + 5) * (s + 3), NONE_LASTS),  # exactly three times
        (s**2 + 4, STAYS),
        (s + 3, NONE_SWINGS),
        (Integer(5) + 0 * s, NONE_SWINGS),
    ):
        found = _dominant(ring.convert(expression.expand()))
        assert isinstance(found, str)
        assert words in found
    for expression in ((s**2 + 2 * s + 5) * (s + Rational(301, 100)), (s**2 + 2 * s + 5) * late(-s)):
        assert isinstance(_dominant(ring.convert(expression.expand())), ComplexPair)


@pytest.mark.parametrize("seed", range(3))
def test_each_tolerance_is_kept_or_broken_as_floats_say(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(6):
        w = Rational(draw.randint(8, 60), 4)
        sigma = w * draw.choice([Rational(1, 3), Rational(1, 7), Rational(1, 12), Rational(3, 2)])
        w2, sigma2 = (x * Rational(draw.randint(76, 130), 100) for x in (w, sigma))
        pairs = pair_of(sigma, w), pair_of(sigma2, w2)
        rows = _checks(*pairs)
        a, b = [(float(sigma), float(w)), (float(sigma2), float(w2))]

        def numbers(x: tuple[float, float], n: int) -> list[float]:
            return [
                (pi - atan(x[1] / x[0])) / x[1],
                2 * pi / x[1],
                *(exp(-k * pi * x[0] / x[1]) for k in range(1, n + 1)),
            ]

        counts = [p.significant for p in pairs]
        most = max(*counts, 1)
        one, other = numbers(a, most), numbers(b, most)
        kept = [abs(other[0] / one[0] - 1) <= 0.1, abs(other[1] / one[1] - 1) <= 0.2]
        swings = [abs(y - x) / one[2] <= 0.1 for x, y in zip(one[2:], other[2:], strict=True)]
        kept += [*swings[:3], *([all(swings[3:])] if most > 3 else []), abs(counts[0] - counts[1]) <= 1]
        assert [x.passes for x in rows] == kept
        shown = [(float(x.environment), float(x.perceived)) for x in rows[: 2 + min(most, 3)]]
        assert shown == [pytest.approx(x) for x in list(zip(one, other, strict=True))[: len(shown)]]
        assert (rows[-1].environment, rows[-1].perceived) == (counts[0], counts[1])
        names = [x.name for x in rows]
        assert names[2 : 2 + min(most, 3)] == [f"A_{n}/A_d" for n in range(1, min(most, 3) + 1)]
        if most > 3:
            assert names[-2] == f"A_4/A_d to A_{most}/A_d"
            assert (float(rows[-2].environment), float(rows[-2].perceived)) == pytest.approx((one[5], other[5]))
        assert FreeResponse(tuple(rows), "", blind=False).passes is all(kept)
    assert FreeResponse((), "why", blind=False).passes is None


def test_two_dynamics_have_the_same_zeros_whatever_stands_before_them_below_them_or_late() -> None:
    ring = Ring.of([s, late(-s)])
    shape = s**2 + 3 * s + 7
    for expression, same in (
        (5 * shape, True), (-shape / (s + 2), True), (shape * late(-s), True),
        (shape * (s + 1), False), (shape + 1, False), (shape + late(-s), False),
    ):  # fmt: skip
        assert _same_zeros(ring.convert(shape), ring.convert(expression)) is same
    swings: Any = SimpleNamespace(env=ring.convert(shape), perc=ring.convert(shape * (s + 9)))
    found = free_response(swings)
    assert (found.passes, found.blind, found.refused) == (True, False, "")
    for env, perc, name in ((s + 1, shape, "environment"), (shape, s + 1, "perceived dynamics")):
        found = free_response(SimpleNamespace(env=ring.convert(env), perc=ring.convert(perc)))  # type: ignore[arg-type]
        assert found.refused.endswith(f"(in the {name})")
        assert (found.checks, found.passes) == ((), None)


def test_what_one_measure_says_and_another_does_not_follows_a_table() -> None:
    end, inner = SimpleNamespace(), SimpleNamespace()
    points = {n: SimpleNamespace(omega=n) for n in (1, 2)}
    band, single = SimpleNamespace(low=points[1], high=points[2]), SimpleNamespace(low=points[1], high=points[1])
    chart = SimpleNamespace(points=[points[1], SimpleNamespace(omega=end), points[2]])
    chart.points[-1] = SimpleNamespace(omega=end)
    whole = SimpleNamespace(low=SimpleNamespace(omega=1), high=SimpleNamespace(omega=end))
    cases: Any = product(
        (False, True),
        (False, True),
        (None, False, True),
        (False, True),
        (False, True),
        (None, (), (single,), (band,), (single, band)),
    )
    for noticed, blind, passes, inside, transparent, llewellyn in cases:
        evaluation = SimpleNamespace(bandwidth=inner if noticed else end, chart=chart, transparent=transparent)
        m: Any = SimpleNamespace(
            evaluation=evaluation, free=SimpleNamespace(blind=blind, passes=passes),
            inside=(whole,) if inside else (band,), llewellyn=llewellyn
        )  # fmt: skip
        expected = [_BLIND] if noticed and blind else [_SLACK] if noticed and passes else []
        expected += [_STRICT] if not noticed and passes is False else []
        expected += [_COARSE] if noticed and inside else []
        expected += [_ACTIVE] if transparent and llewellyn is not None and band not in llewellyn else []
        assert [*disagreements(m)] == expected


def test_a_two_port_is_absolutely_stable_where_both_axis_and_poles_allow_it() -> None:
    for axis, poles in product((None, False, True), repeat=2):
        expected = False if False in (axis, poles) else None if None in (axis, poles) else True
        assert Unconditional(axis, poles).holds is expected


def test_poles_of_three_functions_are_asked_for_and_one_that_forbids_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    ring = Ring.of([s])
    least, leak, gain = (ring.convert(x) for x in (s + 1, 1 / (s + 2), s / (s + 3)))
    for answers in product((None, False, True), repeat=3):
        told = dict(zip(("least", "leak", "gain"), answers, strict=True))
        asked: list[Any] = []

        def allow(f: Any, told: Any = told, asked: Any = asked) -> Any:
            asked.append(f)
            return told["least"] if f is least else told["leak"]

        monkeypatch.setattr("haptisym.verbs.metrics.unconditional.poles_allow", allow)
        monkeypatch.setattr("haptisym.verbs.metrics.unconditional.has_no_pole_right", lambda f, told=told: told["gain"])
        port: Any = SimpleNamespace(least=least, leak=leak, gain=gain, ring=ring)
        expected = False if False in answers else None if None in answers else True
        assert _poles(port) is expected
        [_, other] = asked
        assert (ring.expression(other.numerator) / ring.expression(other.denominator) - s**2 / (s + 2)).cancel() == 0
        for missing in ("least", "leak", "gain"):
            setattr(port, missing, None)
            assert _poles(port) is None
            setattr(port, missing, {"least": least, "leak": leak, "gain": gain}[missing])
