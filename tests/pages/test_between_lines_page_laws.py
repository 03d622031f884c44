"""What is told between measured lines, and the digits of numbers that were identified, of answers put together by hand."""

from __future__ import annotations

import random
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from itertools import pairwise
from math import floor, log10
from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest

from haptisym.model.jnd import Part
from haptisym.pages import identify, measuredbetween
from haptisym.pages.measuredlines import _ratio, runs
from haptisym.writing.document import Document, Table
from haptisym.writing.plain import plain, said

E: Any = Made(scene=Made(slopes={"perceived": Made(bound=40.0, unit="N*s/m", relative=False), "environment": Made(bound=0.125, unit="s", relative=True)},
                         threshold=Made(region=Made(shape=Made(value="ellipse")))))  # fmt: skip


class Stretches:
    """From low to high, with a code each: 1 exceeds, -1 below, 0 unresolved."""

    def __init__(self, *rows: tuple[float, float, int]) -> None:
        self.low, self.high, self.code = (np.array(x) for x in zip(*rows, strict=True)) if rows else (np.array([]),) * 3

    def __len__(self) -> int:
        return len(self.code)

    def length(self, code: int) -> float:
        return float((self.high - self.low)[self.code == code].sum())


def drawn(pick: random.Random, count: int) -> Stretches:
    ends = np.cumsum([1.0] + [pick.randint(1, 30) / 8 for _ in range(count)])
    return Stretches(*((float(a), float(b), pick.choice([1, -1, 0])) for a, b in pairwise(ends)))


def found(real: Stretches, imag: Stretches, *, joint: Stretches | None = None, contradicted: Any = ()) -> Any:
    told: dict[Part | None, Stretches] = {Part.REAL: real, Part.IMAG: imag}
    return Made(told=({None: joint} if joint else {}) | told, contradicted=contradicted, grown=0.0625)


@pytest.mark.parametrize("count", [3, 20, 21, 60])
def test_of_many_stretches_the_twelve_longest_that_are_told_are_listed_in_order(count: int) -> None:
    pick = random.Random(count)
    real, imag = drawn(pick, count), drawn(pick, count)
    chosen = list(measuredbetween._chosen(found(real, imag)))
    if 2 * count <= 40:
        assert chosen == [(part, i) for part in Part for i in range(count)]
        return
    for part, own in ((Part.REAL, real), (Part.IMAG, imag)):
        mine = [i for x, i in chosen if x is part]
        told = [i for i in range(count) if own.code[i]]
        assert mine == sorted(mine)
        assert set(mine) <= set(told)
        assert len(mine) == min(12, len(told))
        length = own.high - own.low
        rest = [float(length[i]) for i in told if i not in mine]
        assert not rest or max(rest) <= min(float(length[i]) for i in mine)


def test_stretches_that_are_not_resolved_are_no_longest_ones() -> None:
    own = Stretches(
        *((float(n), float(n + 1), 1) for n in range(5)),
        (5.0, 50.0, 0),
        *((float(50 + n), float(51 + n), -1) for n in range(40)),
    )
    chosen = [i for part, i in measuredbetween._chosen(found(own, own)) if part is Part.REAL]
    assert 5 not in chosen
    assert len(chosen) == 12


def blocks(x: Any) -> str:
    return " ".join(plain(Document("T", (), tuple(measuredbetween._blocks(E, x)))).replace("\xa0", " ").split())


def test_how_much_of_the_band_is_told_is_summed_up_for_each_part_and_both() -> None:
    real = Stretches((1.0, 2.0, 1), (2.0, 2.5, 0), (2.5, 6.0, -1), (6.0, 8.0, 1))
    text = blocks(found(real, Stretches((1.0, 8.0, -1)), joint=Stretches((1.0, 3.0, 1), (3.0, 8.0, -1))))
    assert (
        "r_r (real part) exceeds its threshold on 3 of 7 rad/s, is below it on 3.5, and is unresolved on 0.5 rad/s."
        in text
    )
    assert (
        "r_i (imaginary part) exceeds its threshold on 0 of 7 rad/s, is below it on 7, and is unresolved on 0 rad/s."
        in text
    )
    assert "The change lies outside the ellipse on 2 of 7 rad/s, inside it on 5, and is unresolved on 0 rad/s." in text
    assert "half-way between lines its radius is at most 6.25 % of the environment's magnitude." in text
    assert text.startswith(
        "T With |dH/dω| at most 40 N·s/m; |dH/dω| at most 0.125 s times |H| of the environment the disc of each line holds on"
    )
    assert "CONTRADICTED" not in text
    assert "longest of each part" not in text


def test_a_row_tells_the_part_its_stretch_and_the_verdict() -> None:
    real = Stretches((1.0, 2.0, 1), (2.0, 2.5, 0))
    [table] = [
        x
        for x in measuredbetween._blocks(E, found(real, Stretches((1.0, 2.5, -1)), joint=Stretches((1.0, 2.5, 0))))
        if isinstance(x, Table)
    ]
    assert [[said(y) for y in row] for row in table.rows] == [
        ["ellipse", "1 to 2.5", "unresolved"], ["real", "1 to 2", "exceeds"], ["real", "2 to 2.5", "unresolved"], ["imaginary", "1 to 2.5", "below"],
    ]  # fmt: skip


def test_that_the_table_is_cut_and_that_the_bound_is_contradicted_is_noted() -> None:
    pick = random.Random(1)
    many = drawn(pick, 30)
    text = blocks(found(many, many, contradicted=[(2.0, 3.0), (5.0, 6.0)]))
    assert "The 12 longest of each part that are told, of 60 stretches in all; JSON has every one." in text
    assert "CONTRADICTED: in 2 gaps between lines, the first from 2 to 3 rad/s, lines differ by more" in text
    nothing = blocks(found(Stretches(), Stretches()))
    assert nothing.endswith("There are no two lines with discs that have an end: nothing is told.")


def test_runs_of_one_code_and_shares_that_are_not_known() -> None:
    assert list(runs(np.array([1, 1, 2, 2, 2, 1]))) == [(0, 1), (2, 4), (5, 5)]
    assert [said(_ratio(x)) for x in (None, 0.123456, float("inf"))] == ["", "0.1235", "unbounded"]


# Numbers that were identified


def estimate(error: float) -> Any:
    return Made(error=error)


def test_a_number_is_told_to_the_second_digit_of_its_error_and_never_more_than_eight_digits() -> None:
    pick = random.Random(5)
    for _ in range(300):
        value = pick.choice([1, -1]) * pick.random() * 10.0 ** pick.randint(-6, 6)
        error = abs(value) * 10.0 ** -pick.uniform(0, 12)
        last = max(floor(log10(error)) - 1, floor(log10(abs(value))) - 7)
        step = Decimal(1).scaleb(last)
        shown = identify._certain_digits(estimate(error), value)
        told = Decimal(shown.digits)
        assert abs(told - Decimal(value)) <= step / 2
        assert told % step == 0
        assert shown.value == value
        if last < 0:
            assert len(shown.digits.partition(".")[2]) == -last
        low, high = (
            Decimal(identify._certain_digits(estimate(error), value, way).digits)
            for way in (ROUND_FLOOR, ROUND_CEILING)
        )
        assert low <= Decimal(value) <= high
        assert high - low in (0, step)


def test_a_number_without_an_error_has_its_eight_digits_and_zero_twelve_places() -> None:
    assert identify._certain_digits(estimate(0.0), 0.5).digits == "0.50000000"
    assert identify._certain_digits(estimate(0.0), 123.456).digits == "123.45600"
    assert identify._certain_digits(estimate(0.0), 0.0).digits == "0.000000000000"
    assert identify._certain_digits(estimate(0.25), 0.0).digits == "0.00"
    assert identify._certain_digits(estimate(1.0), 9999999.0).digits == "9999999.0"
    assert identify._certain_digits(estimate(100.0), 12345678.0).digits == "12345680"
    assert identify._certain_digits(estimate(0.5), 10000000.0).digits == "10000000"


@pytest.mark.parametrize(
    ("shares", "digits"),
    [([1.0], 2), ([0.5], 2), ([0.1], 2), ([0.09], 3), ([0.01], 3), ([0.009, 0.5], 4), ([1e-5, 0.1], 6), ([1e-7], 8), ([1e-9], 8), ([1e-30, 1.0], 8), ([], 2), ([7.0], 2)],
)  # fmt: skip
def test_the_response_has_two_digits_more_than_the_best_told_parameter_has_certain_ones(
    shares: list[float], digits: int
) -> None:
    for sign in (1, -1):
        own = [Made(value=sign * 3.0, error=3.0 * x) for x in shares]
        assert identify._digits(Made(estimates=[*own, Made(value=0.0, error=1.0)])) == digits  # type: ignore[arg-type]
