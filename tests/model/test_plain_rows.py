"""Lines of numbers read many at once: each cell is the float that reading it alone gives, and a bad one is named wherever it stands."""

from __future__ import annotations

import struct
from collections.abc import Callable
from fractions import Fraction
from math import nextafter
from pathlib import Path
from random import Random

import numpy as np
import pytest
from benches import bench
from hypothesis import given
from hypothesis import strategies as st

import haptisym as hs
from haptisym.model.plainrows import plain_rows

Called = Callable[..., tuple[int, str, str]]


def bits(x: float) -> bytes:
    """All of a float, the sign of zero too."""
    return struct.pack("d", x)


def agrees(cells: list[str]) -> bool:
    """Whether cells of one column, whose numbers are few, are read as Python reads each alone."""
    rows = plain_rows("".join(f"{x}\n" for x in cells), ",", 1)
    return rows is not None and list(map(bits, rows[:, 0].tolist())) == [bits(float(x)) for x in cells]


WRITTEN = ["{!r}", "{:.9g}", "{:.18e}", "{:.3f}", "{:+.5E}", "{:.15g}", "{:.17g}", "{:.0f}", "{:.6e}"]


@pytest.mark.parametrize("form", WRITTEN)
def test_a_cell_is_the_nearest_float_however_it_is_written(form: str) -> None:
    chance = Random(form)
    values = [chance.choice([-1, 1]) * 10 ** chance.uniform(-8, 7) for _ in range(4000)]
    assert agrees([form.format(x) for x in [0.0, -0.0, 1.0, *values]])


digits = st.integers(0, 10**25).flatmap(lambda n: st.sampled_from([str(n), f"00{n}", f"{n % 1000}"]))
numbers = st.builds(
    "{}{}{}".format,
    st.sampled_from(["", "", "-", "+"]),
    digits
    | st.builds("{}.".format, digits)
    | st.builds(".{}".format, digits)
    | st.builds("{}.{}".format, digits, digits),
    st.just("") | st.builds("{}{}".format, st.sampled_from(["e", "E", "e+", "e-"]), st.integers(0, 400)),
)


@given(st.lists(numbers, min_size=1, max_size=8))
def test_any_number_of_the_grammar_is_the_nearest_float(cells: list[str]) -> None:
    rows = plain_rows("".join(f"{x}\n" for x in [*cells, *["1"] * 20 * len(cells)]), ",", 1)
    assert rows is not None
    assert [bits(x) for x in rows[: len(cells), 0].tolist()] == [bits(float(x)) for x in cells]


@pytest.mark.parametrize("cell", ["18446744073709551616", "18446744073709551617.5", "-36893488147419103232e-3",
                                  ".000000000000000000000018446744073709551616", "0.018446744073709551616", "0" * 30 + "7"])  # fmt: skip
def test_a_number_with_more_digits_than_a_word_holds_is_not_cut(cell: str) -> None:
    assert agrees([cell, *["1"] * 20])


def test_numbers_half_way_between_two_floats_and_beside_are_read_to_the_even_one_and_to_the_nearest() -> None:
    """Whole numbers from 2^53 to 10^19, and tenths, hundredths, ... of them: nothing that only looks close is taken for exact."""
    chance = Random(5)
    cells = []
    for _ in range(600):
        low = float(chance.randrange(2**53, 10 ** chance.randrange(16, 19)))
        middle = (Fraction(low) + Fraction(nextafter(low, 1e300))) / 2
        cells += [str(int(middle) + step) for step in (-1, 0, 1)]
    for digits, places in ((17, 3), (18, 9), (19, 15), (19, 18)):
        for _ in range(600):
            x = nextafter(chance.uniform(10 ** (digits - places - 1), 10 ** (digits - places)), 0)
            whole = int((Fraction(x) + Fraction(nextafter(x, 1e300))) / 2 * 10**places) + chance.randrange(2)
            cells.append(f"{whole // 10**places}.{whole % 10**places:0{places}}")
    for start in range(0, len(cells), 20):  # as few of them among others as may be read alone
        some = cells[start : start + 20]
        rows = plain_rows("".join(f"{x}\n" for x in [*some, *["1.5"] * 400]), ",", 1)
        assert rows is not None
        assert rows[: len(some), 0].tolist() == list(map(float, some))


ODD = ["x", "", "nan", "inf", "1 2", "1_0", "--1", "+-1", "1-2", "1.2.3", ".", "-", "e5", "1e", "1e+", "1e1.5", "1e5e5", '"1"',
       "1#", "0x10", "\u0661", "1,2", "1;2", "  1", "1\t"]  # fmt: skip


@pytest.mark.parametrize("cell", ODD)
def test_of_lines_that_are_written_in_another_way_nothing_is_said(cell: str) -> None:
    assert plain_rows(f"1,2\n3,{cell}\n5,6\n", ",", 2) is None
    assert plain_rows(f"1,2\n{cell},4\n5,6\n", ",", 2) is None


@pytest.mark.parametrize("text", ["1,2,3\n", "1\n2\n", "1,2\n3\n4\n5,6\n", "1,2\n\n3,4\n", "\n", "1,2,3\n4,5,6\n"])
def test_of_lines_of_other_lengths_nothing_is_said(text: str) -> None:
    assert plain_rows(text, ",", 2) is None


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_blank_after_a_delimiter_and_empty_last_lines_are_passed_over(delimiter: str) -> None:
    rows = plain_rows(f"1{delimiter} -2\n3{delimiter}4\n\n", delimiter, 2)
    assert rows is not None
    assert rows.tolist() == [[1, -2], [3, 4]]


LINES = 20_000
"""More than are read at once."""


def long_table(special: dict[int, str]) -> str:
    """With other text in place of some lines of numbers, which begin with line 2."""
    return "omega,real,imag\n" + "".join(
        special.get(i, f"{i / 8!r},{100 - i / 7!r},{i / 3!r}\n") for i in range(2, LINES)
    )


def test_a_long_table_is_read_line_by_line_whatever_stands_between(tmp_path: Path) -> None:
    special = {
        900: "# a pause\n",
        901: "\n",
        7_000: '"875","-900","2333"\n',
        11_000: " 1375.0 ,\t-2900.0,7e3 # loud\n",
        19_000: "2375.0,-1.00000000000000000000001e3,1e-320\n",
    }
    table = long_table(special)
    felt = hs.evaluate(bench(tmp_path, table)).scene.perceived
    rows = [
        [float(cell.strip('" \t')) for cell in text.split(",")]
        for line in table.splitlines()[1:]
        if (text := line.partition("#")[0].strip())
    ]
    assert np.array_equal(np.column_stack([felt.omega, felt.H.real, felt.H.imag]), rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("2375,x,1\n", 'line 19000: real: "x" is not a number'),
        ("2375,,1\n", "line 19000: real: the cell is empty"),
        ("2375,1\n", "line 19000 has 2 cells, and the header names 3 columns"),
        ("2375,1,2,3\n", "line 19000 has 4 cells, and the header names 3 columns"),
        ("2375,1,2,3,4,5\n", "line 19000 has 6 cells, and the header names 3 columns; if these are decimal commas"),
        ("2375,nan,1\n", "line 19000: H: nan+1j must be finite"),
        ("2375,1e999,1\n", "line 19000: H: inf+1j must be finite"),
        ("-2375,1,1\n", "line 19000: omega: -2375 must be a finite frequency"),
        ("2374,1,1\n", "line 19000: the frequency 2374 rad/s comes after 2374.875"),
    ],
)
def test_a_bad_line_far_down_is_named_after_comments_and_empty_lines(
    tmp_path: Path, call: Called, line: str, words: str
) -> None:
    table = long_table({12: "# a pause\n", 7_000: "\n", 10_000: '"1250","1","1"\n', 19_000: line})
    status, out, err = call("evaluate", str(bench(tmp_path, table)))
    assert (status, out) == (2, "")
    assert words in err


def test_what_is_no_utf_8_far_down_is_said(tmp_path: Path, call: Called) -> None:
    path = bench(tmp_path, "")
    (tmp_path / "bench.csv").write_bytes(long_table({19_000: "2375,1,1\u00b0\n"}).encode("latin-1"))
    status, _, err = call("evaluate", str(path))
    assert (status, "not text in UTF-8" in err) == (2, True)
