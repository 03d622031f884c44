"""Lines of plainly written numbers, thousands of cells at once: each cell is the nearest float, as one by one.

The digits of a cell are a whole number w, read eight letters at a time, and its value is w 10^e. Where w and the power of ten
are floats, their quotient is the nearest one; else double-doubles tell which it is, but for one cell in 10^13 or so that may
lie half-way between two floats. Those, and cells with more digits than w holds, are read one by one. Of lines that are written
in another way (quotes, comments, rows of different lengths, what is no number) nothing is said.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from haptisym.model.measured import Reals
from haptisym.programs.certified import Doubled, mul

_BEFORE = b"0" * 23 + b"\n"
"""Stands before the first cell, so that every word has its eight letters."""
_KEPT = np.array([0x0F0F0F0F0F0F0F0F >> 8 * (8 - n) << 8 * (8 - n) for n in range(9)], np.uint64)
"""Of a word of eight letters the values of the last n, which are digits."""
_SHIFTED = np.array([10**n for n in range(20)], np.uint64)
_TENS = 10.0 ** np.arange(23)
"""Powers of ten that floats hold exactly."""
_MOST_DIGITS, _FARTHEST = 19, 60
"""Of w, which has 64 bits; of e, where neither a product nor what it lacks can overflow or underflow."""
_DOUBT = 2.0**-100
"""Of a product in double-doubles, as a share: more than its error and that of the power of ten."""
_FEW = 0.05
"""The share of cells that are read one by one; where there are more, the table is not plain."""
_MINUS, _PLUS, _POINT, _E, _END = b"-+.e\n"
_LOWER = 32  # the bit that e has and E lacks


def plain_rows(text: str, delimiter: str, columns: int) -> Reals | None:
    """A row for each line; None where one is written in another way.

    >>> plain_rows("1,2\\n3,-.5e3\\n", ",", 2).tolist(), plain_rows("1,two\\n", ",", 2)
    ([[1.0, 2.0], [3.0, -500.0]], None)
    """
    if not text.isascii():
        return None
    if " " in text:
        text = text.replace(f"{delimiter} ", delimiter)
    cells = _cells(text.rstrip("\n").encode("ascii") + b"\n", ord(delimiter), columns)
    values = None if cells is None else _values(cells)
    return None if values is None else values.reshape(-1, columns)


class _Cells(NamedTuple):
    """w, e and sign of each, and where it stands among the letters; ``alone`` : has more digits than w holds, or a far e."""

    letters: Any
    start: Any
    stop: Any
    is_negative: Any
    digits: Any
    power: Any
    alone: Any


def _cells(text: bytes, delimiter: int, columns: int) -> _Cells | None:
    """All that is no digit has its place, or None: a sign first, a point, an e with its sign, the end."""
    letters = np.frombuffer(_BEFORE + text, np.uint8)
    marks = np.flatnonzero(letters - np.uint8(ord("0")) > 9)
    kinds = letters[marks]
    ends = np.flatnonzero((kinds == delimiter) | (kinds == _END))
    at, ends = ends[:-1] + 1, ends[1:]
    if not _is_table(kinds[ends], delimiter, columns):
        return None
    begin = marks[at - 1] + 1
    sign, is_negative = _signs(kinds, marks, at, begin)
    at += sign
    start, point = begin + sign, marks[at]
    has_point = kinds[at] == _POINT
    at += has_point
    stop, end = marks[at], marks[ends]
    words = np.ndarray(len(letters) - 7, "<u8", letters, strides=(1,))
    exponent: Any = 0
    if (has_e := kinds[at] | _LOWER == _E).any():
        at += has_e
        sign, is_below = _signs(kinds, marks, at, stop + 1)
        sign, count = sign & has_e, np.where(has_e, end - stop - 1 - (sign & has_e), 0)
        at += sign
        if (count[has_e] < 1).any() or (count > 8).any():
            return None
        exponent = _number(words, end, count).astype(np.int64)
        exponent = np.where(is_below & has_e, -exponent, exponent)
    whole, part = point - start, stop - point - has_point
    if (at != ends).any() or (whole + part < 1).any():
        return None
    left, right = _number(words, point, whole), _number(words, stop, part)
    digits, power = left * _SHIFTED.take(part, mode="clip") + right, exponent - part
    alone = whole + part > _MOST_DIGITS
    if alone.any():
        alone &= (
            (left > 0) | (whole > _MOST_DIGITS) | (part > 24) | (_word(words, stop - 16, part - 16) >= 1000)
        )  # but for zeros that lead
    alone |= np.abs(power) > _FARTHEST
    return _Cells(letters, begin, end, is_negative, digits, power, alone)


def _is_table(ends: Any, delimiter: int, columns: int) -> bool:
    """Whether cells end as those of a table do: with a delimiter, and the last of each row with its line."""
    if len(ends) % columns:
        return False
    rows = ends.reshape(-1, columns)
    return bool((rows[:, :-1] == delimiter).all() and (rows[:, -1] == _END).all())


def _signs(kinds: Any, marks: Any, at: Any, place: Any) -> tuple[Any, Any]:
    """Where a sign stands at its place, and where that is a minus."""
    own = kinds[at]
    here = marks[at] == place
    return ((own == _MINUS) | (own == _PLUS)) & here, (own == _MINUS) & here


def _number(words: Any, stop: Any, count: Any) -> Any:
    """That of the ``count`` digits before ``stop``."""
    found = _word(words, stop, count)
    for more in (8, 16):
        if count.max() > more:
            found += 10**more * _word(words, stop - more, count - more)
    return found


def _word(words: Any, stop: Any, count: Any) -> Any:
    """The same of up to eight, the bytes of a word, the first one lowest: pairs are put together, then fours, then all."""
    word = words[stop - 8] & _KEPT.take(count, mode="clip")
    for times, mask, bits in ((10, 0x00FF00FF00FF00FF, 8), (100, 0x0000FFFF0000FFFF, 16), (10_000, 0xFFFFFFFF, 32)):
        word = (times * word + (word >> bits)) & mask
    return word


def _values(x: _Cells) -> Reals | None:
    """The floats; None where too many would be read one by one."""
    alone, digits, power = x.alone, x.digits, x.power
    if alone.any():
        digits, power = (np.where(alone, 0, y) for y in (digits, power))
    if digits.max() <= 2**53 and power.min() > -len(_TENS) and power.max() <= 0:
        found: Reals = digits.astype(float) / _TENS[-power]
    else:
        found, sure = _product(digits, power)
        alone = alone | ~sure
    np.negative(found, out=found, where=x.is_negative)
    if (few := np.flatnonzero(alone)).size > _FEW * len(found) + 1:
        return None
    found[few] = [float(bytes(x.letters[x.start[i] : x.stop[i]])) for i in few.tolist()]
    return found


def _product(digits: Any, power: Any) -> tuple[Reals, Any]:
    """w 10^e, and where it is the nearest float for sure: no rounding of the double-doubles could have led to another one."""
    high = digits.astype(float)
    low = (digits - high.astype(np.uint64)).view(np.int64).astype(float)
    tens, rest = (x[power + _FARTHEST] for x in _powers())
    found, lacking, _ = mul(Doubled(high, low, None), Doubled(tens, rest, None))
    doubt = _DOUBT * found
    return found, (found + (lacking - doubt) == found) & (found + (lacking + doubt) == found)


@cache
def _powers() -> tuple[Reals, Reals]:
    """Powers of ten, as sums of two floats."""
    exact = [Fraction(10) ** e for e in range(-_FARTHEST, _FARTHEST + 1)]
    high = np.array([float(x) for x in exact])
    return high, np.array([float(x - Fraction(h)) for x, h in zip(exact, high.tolist(), strict=True)])
