"""Numbers that are told apart by bits: their order, and the first of those that are alike, against fractions."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest
from flint import arb
from sympy import Integer, Rational, sqrt

from haptisym.kernel.alike import ALIKE_BITS, ascending, each_once, is_told, ordered
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber


class Vague(RealNumber):
    """Known to some bits, or to none."""

    def __init__(self, known: Any) -> None:
        self.known = known

    def ball(self, bits: int) -> Ball:
        return self.known[bits > 128]


def exact(x: Fraction) -> ExactNumber:
    return ExactNumber(Rational(x.numerator, x.denominator))


@pytest.mark.parametrize("seed", range(3))
def test_things_stand_by_their_numbers_and_those_that_are_alike_as_they_were(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(10):
        values = [
            Fraction(draw.randint(1, 9), draw.randint(1, 4)) + draw.choice([0, Fraction(1, 10**150)]) for _ in range(9)
        ]
        named = list(enumerate(values))
        numbers = {name: exact(x) for name, x in named}
        row = sorted(named, key=lambda x: x[1])
        assert ascending([name for name, _ in named], numbers.__getitem__) == [name for name, _ in row]
        firsts = [name for i, (name, x) in enumerate(row) if x not in values[:name] or not i]
        assert each_once([name for name, _ in named], numbers.__getitem__) == firsts
        for a, b in ((draw.choice(named), draw.choice(named)) for _ in range(9)):
            assert ordered(numbers[a[0]], numbers[b[0]]) == (a[1] < b[1]) - (a[1] > b[1])


def test_what_differs_by_less_than_bits_tell_is_alike() -> None:
    root = ExactNumber(sqrt(2))
    for bits, order in ((100, 1), (ALIKE_BITS - 8, 1), (ALIKE_BITS + 8, 0)):
        beyond = ExactNumber(sqrt(2) + Rational(1, 2**bits))
        assert (ordered(root, beyond), ordered(beyond, root)) == (order, -order)
        assert each_once([beyond, root], lambda x: x) == ([root, beyond] if order else [beyond])
    assert ordered(root, root) == 0


def test_a_number_is_told_where_some_bits_bound_it() -> None:
    known, unknown = arb(1), arb("nan")
    assert [is_told(Vague(x)) for x in ((known, known), (unknown, known), (known, unknown), (unknown, unknown))] == [
        True, True, True, False,
    ]  # fmt: skip
    assert is_told(ExactNumber(Integer(3)))
