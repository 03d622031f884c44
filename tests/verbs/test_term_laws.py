"""Terms of Im H_perc over cells: powers, delays, turns by quarters, parts and products, against complex numbers."""

from __future__ import annotations

from itertools import product
from math import pi as turn
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from sympy import Integer, Rational, Symbol, exp, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s
from haptisym.programs.taylormodels import Model, constant, variable
from haptisym.verbs.require import energyterms
from haptisym.verbs.require.energyterms import (
    Term,
    add_to,
    beginnings,
    bent_sinc,
    ends_of,
    imaginary,
    powered,
    terms_in,
    variables,
)

Q, P = Symbol("q", positive=True), Symbol("p", positive=True)


# --- terms ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_a_polynomial_of_s_delays_powers_and_numbers_is_the_sum_of_its_terms_each_place_once(seed: int) -> None:
    pick = Random(seed)
    lags, orders = (Rational(1, 3), Q), (Rational(1, 2), Rational(2, 7))
    total = Integer(0)
    for _ in range(7):
        term = (
            Rational(pick.randint(-9, 9) or 1, 4)
            * pi ** pick.randint(0, 2)
            * Q ** pick.randint(0, 2)
            * P ** pick.randint(0, 1)
        )
        term *= s ** pick.randint(0, 3)
        for lag in lags:
            term *= exp(-s * lag) ** pick.randint(0, 2)
        for order in orders:
            term *= s ** (order * pick.randint(0, 2))
        total += term
    ring = Ring.of([total, Q, P, *(exp(-s * x) for x in lags), *(s**x for x in orders)])
    rows = terms_in(ring, ring.convert(total).numerator)
    scale = ring.convert(total).denominator
    places = [(x.power, x.lag) for x in rows]
    assert len(set(places)) == len(places)
    at = {s: mpmath.mpf("0.7"), Q: mpmath.mpf("1.3"), P: mpmath.mpf("0.4")}
    told = sum(complex((x.number * s**x.power * exp(-s * x.lag)).subs(at).evalf(30)) for x in rows)
    true = complex((total * ring.expression(scale)).subs(at).evalf(30))
    assert told == pytest.approx(true, rel=1e-12)


def test_with_delays_as_1_less_s_lag_a_term_begins_with_two_powers() -> None:
    """s^p exp(-s L) = s^p - L s^(p + 1), j^(p + 1) (-L) = j^(p - 1) L."""
    row = [Term(Rational(3, 2), Integer(0), Q), Term(Integer(2), P, 3 * Q)]
    assert [*beginnings(row)] == [(Rational(3, 2), Rational(3, 2), Q), (2, 2, 3 * Q), (3, 1, 3 * Q * P)]
    assert [*energyterms.endings(row)] == [(Rational(3, 2), Rational(3, 2), Q), (2, 2, None)]


def at_points(x: Model | None, shares: Any) -> Any:
    """What a model of first rows is at points of its one cell, and how far it may be off."""
    if x is None:
        return np.zeros(len(shares)), 0.0
    found = x.c0[0, 0] + shares @ x.c1[0, 0] + ((shares @ x.c2[0, 0]) * shares).sum(-1)
    return found, float(x.r[0, 0])


@pytest.mark.parametrize("seed", range(4))
def test_real_and_imaginary_parts_add_up_by_powers_and_multiply_as_complex_numbers(seed: int) -> None:
    """Im(a conj b), in all quarters of a turn: of parts that are 0 nothing is made."""
    pick = Random(seed)
    w, q = variables(np.array([[[1.0, 1.2], [2.0, 2.2]]]))
    shares = np.array([(x, y) for x in (-1, 0.3, 1) for y in (-1, 0, 1)], float)
    W, V = 1.1 + 0.1 * shares[:, 0], 2.1 + 0.1 * shares[:, 1]
    sums, plain = [], []
    for _ in range(2):
        parts: Any = {}
        own: dict[Any, Any] = {}
        for _ in range(5):
            p, C, S = (
                Integer(pick.randint(0, 2)),
                *pick.choice([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (0.6, 0.8)]),
            )
            k = pick.choice([0, 1])
            add_to(parts, p, (w, q)[k], C, S)
            own[p] = own.get(p, 0) + (W, V)[k] * complex(C, S)
            assert (parts[p][0] is None) <= (not np.any(own[p].real))
        sums.append(parts)
        plain.append(own)
    found = imaginary(*sums)
    for p in {x + y for x, y in product(*plain)}:
        true = sum(
            (a * np.conj(b)).imag for (x, a), (y, b) in product(plain[0].items(), plain[1].items()) if x + y == p
        )
        told, off = at_points(found.get(p), shares)
        assert np.allclose(told, true, atol=off + 1e-12)
    empty: Any = {}
    add_to(empty, Integer(1), w, 0.0, 0.0)
    assert empty == {1: [None, None]}
    assert imaginary(empty, sums[0]) == {}


def test_powers_of_frequency_over_a_cell() -> None:
    w, _ = variables(np.array([[[1.0, 1.5], [0.0, 1.0]], [[0.0, 0.5], [0.0, 1.0]]]))
    for p in (Integer(0), Integer(1), Integer(3), Rational(1, 2), Rational(7, 3)):
        low, high = (x[:, 0] for x in powered(w, p).bounds())
        for i, (a, b) in enumerate(((1.0, 1.5), (0.0, 0.5))):
            assert low[i] <= a ** float(p) <= b ** float(p) <= high[i] + 1e-15
            assert high[i] - low[i] <= 1.5 * (b ** float(p) - a ** float(p)) + 0.2 * (i == 1) + 1e-12


@pytest.mark.parametrize("most", [0.0, 0.01, 0.5, 2.0, 30.0])
def test_what_sinc_bends_away_from_1_over_the_square_lies_between_its_bounds(most: float) -> None:
    """(sin x/x - 1)/x^2 is between -1/6 and -1/6 + x^2/120."""
    for low in (-most, most / 2):
        angle = variable(np.array([(low + most) / 2]), np.array([(most - low) / 2]), np.array([most]), 0, 1, slopes=0)
        a, b = ends_of(bent_sinc(angle))
        for x in np.linspace(low, most, 9):
            with mpmath.workdps(40):
                true = (mpmath.sin(x) / x - 1) / mpmath.mpf(x) ** 2 if x else -mpmath.mpf(1) / 6
            assert a <= true <= b
        assert a >= -1 / 6 - 1e-11
        assert b <= -1 / 6 + most**2 / 120 + 1e-11


def test_ends_of_a_model_are_those_of_all_its_cells() -> None:
    rows = np.array([3.0, -2.0, 1.0])
    low, high = ends_of(variable(rows, np.array([0.5, 0.25, 2.0]), np.full(3, 4.0), 0, 1, slopes=0))
    assert [low, high] == pytest.approx([-2.25, 3.5], abs=1e-12)
    assert low <= -2.25 < 3.5 <= high
    assert list(ends_of(constant(2.0, 4, 1, slopes=0))) == pytest.approx([2.0, 2.0])


@pytest.mark.parametrize("power", [*range(-3, 6), "1/2", "-5/4"])
def test_a_power_of_j_is_a_turn_by_so_many_quarters(power: Any) -> None:
    found = Term(Rational(power), Integer(0), Integer(1)).turned
    true = np.exp(0.5j * turn * float(Rational(power)))
    assert list(found) == pytest.approx([true.real, true.imag], abs=1e-15)
    if isinstance(power, int):
        assert set(found) <= {0.0, 1.0, -1.0}
