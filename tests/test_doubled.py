"""Double-doubles: exact transformations are exact, and every bound of an error holds."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import isqrt

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Symbol

from haptisym.numeric import doubled
from haptisym.numeric.doubled import Doubled, two_product, two_sum
from haptisym.numeric.floats import Floats
from haptisym.numeric.magnitudes import judge
from haptisym.numeric.program import Writer

numbers = st.floats(min_value=-1e100, max_value=1e100).filter(lambda x: x == 0 or abs(x) > 1e-100)
pairs = st.tuples(numbers, st.floats(-0.5, 0.5), st.floats(0, 1e-20))


def number(pair: tuple[float, float, float]) -> tuple[Doubled, list[Fraction]]:
    """A double-double with a bound, and the ends of what it stands for."""
    hi, low, relative = pair
    lo = low * float(np.spacing(abs(hi)))
    error = relative * abs(hi)
    middle = Fraction(hi) + Fraction(lo)
    x = Doubled(np.float64(hi), np.float64(lo), np.float64(error))
    return x, [middle - Fraction(error), middle + Fraction(error)]


@given(numbers, numbers)
def test_sums_and_products_of_two_doubles_are_exact(a: float, b: float) -> None:
    assert sum(map(Fraction, two_sum(a, b))) == Fraction(a) + Fraction(b)
    assert sum(map(Fraction, two_product(a, b))) == Fraction(a) * Fraction(b)


OPERATIONS: list[tuple[Callable[..., Doubled], Callable[[Fraction, Fraction], Fraction]]] = [
    (doubled.add, lambda x, y: x + y),
    (doubled.sub, lambda x, y: x - y),
    (doubled.mul, lambda x, y: x * y),
    (doubled.div, lambda x, y: x / y),
]


@pytest.mark.parametrize("place", range(4), ids=["sum", "difference", "product", "quotient"])
@given(pairs, pairs)
def test_the_bound_of_the_error_holds_for_all_that_the_operands_may_be(
    place: int, first: tuple[float, float, float], second: tuple[float, float, float]
) -> None:
    ours, exact = OPERATIONS[place]
    (x, ends), (y, others) = number(first), number(second)
    assume(place < 3 or y.hi != 0)
    with np.errstate(all="ignore"):
        found = ours(x, y)
    assume(np.isfinite(found.error))
    middle = Fraction(float(found.hi)) + Fraction(float(found.lo))
    for a in ends:
        for c in others:
            assert abs(middle - exact(a, c)) <= Fraction(float(found.error))


@given(pairs)
def test_the_bound_of_a_root_holds(given_pair: tuple[float, float, float]) -> None:
    x, (low, high) = number(given_pair)
    assume(x.hi > 0 and low > 0)
    with np.errstate(all="ignore"):
        found = doubled.sqrt(x)
    assume(np.isfinite(found.error))
    scale = 1 << 800
    for end in (low, high):
        root = Fraction(isqrt(int(end * scale * scale)), scale)
        assert abs(Fraction(float(found.hi)) + Fraction(float(found.lo)) - root) <= Fraction(
            float(found.error)
        ) + Fraction(2, scale)


def test_what_overflows_has_no_bound() -> None:
    huge = Doubled(np.float64(1e300), np.float64(0), np.float64(0))
    with np.errstate(all="ignore"):
        assert not np.isfinite(doubled.mul(huge, huge).error)


X = Symbol("X")


@given(
    st.lists(st.sampled_from(["square", "add one", "less one", "invert", "root"]), max_size=6), st.floats(1e-300, 1e300)
)
def test_what_is_judged_safe_neither_overflows_nor_underflows(steps: list[str], at: float) -> None:
    write = Writer((X,))
    y = write.input(X)
    one = write.constant(1)
    for step in steps:
        y = {
            "square": lambda y: write.mul(y, y), "add one": lambda y: write.add(y, one), "less one": lambda y: write.sub(y, one),
            "invert": lambda y: write.div(one, y), "root": lambda y: write.sqrt(write.abs(y)),
        }[step](y)  # fmt: skip
    program = write.program({f"y{n}": n for n in range(len(write.operations))})
    if not judge(program, [at], 53, 1020).safe:
        return
    out = np.empty((len(program.results), 1))
    Floats(program).run([np.array([at])], 1, out)
    value = {step: float(out[n, 0]) for n, step in enumerate(program.results.values())}
    for i, step in enumerate(program.operations):
        assert value[i] == 0 or not np.isfinite(value[i]) or 2.0**-1020 <= abs(value[i]) <= 2.0**1020
        operands = [value[x] for x in step.arguments] if step.name in ("mul", "div") else []
        if operands and all(np.isfinite(operands)) and (step.name == "mul" or operands[1]):
            assert np.isfinite(value[i])  # nothing but a division by 0 makes infinity
            assert (value[i] == 0) == (operands[0] == 0 or (step.name == "mul" and operands[1] == 0))
