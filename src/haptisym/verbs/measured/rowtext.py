"""The rows of a document with a million lines as text, a table of characters at once: every number reads back as itself."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from haptisym.model.measured import Reals

Letters: TypeAlias = NDArray[np.uint8]

_TOGETHER = 20_000
"""Rows that are written at once: a table of all would need as much memory as the document."""
_FEW = 1000
"""Up to so many lines numbers are the shortest that read back; more have 17 digits, which takes a tenth of the time."""
_EXACT = 10.0 ** np.arange(23)
"""Powers of ten that floats hold exactly."""
_LEAST = -6
_DECADES = 10.0 ** np.arange(_LEAST, 17)
"""Between which numbers are written by their digits; a product with a power of ``_EXACT`` is then a whole number of 17."""
_SPLIT = 134217729.0
_FOUR = np.frombuffer("".join(f"{i:04}" for i in range(10_000)).encode(), np.uint32)
"""Four digits as one number of 32 bits."""
_EXPONENTS = np.frombuffer("".join(f"e{i:+03}" for i in range(_LEAST, 17)).encode(), np.uint32)


def row_texts(
    columns: Sequence[tuple[str, Reals | None]], kinds: Any, end: Callable[[int], str], between: str
) -> Iterator[str]:
    """Rows, many at once, with ``between`` after each: ``columns`` by name, None for null, and what ends a row.

    ``kinds`` : a number for each line; ``end`` : of the first line of a kind what all of that kind end with.

    >>> columns = [("omega", np.array([1, 0.25])), ("radius", None)]
    >>> list(row_texts(columns, np.array([7, 7]), lambda line: '"real": "below"', "; "))
    ['{"omega":  1.0, "radius": null, "real": "below"}; {"omega": 0.25, "radius": null, "real": "below"}; ']
    """
    names, first, own = np.unique(kinds, return_index=True, return_inverse=True)
    told = {name: end(int(line)) for name, line in zip(names.tolist(), first.tolist(), strict=True)}
    ends, last = _left([f", {x}" for x in told.values()]), _left([f"}}{between}"])
    for start in range(0, len(own), _TOGETHER):
        some = slice(start, start + _TOGETHER)
        parts: list[Letters] = []
        for i, (name, row) in enumerate(columns):
            label = f"{', ' if i else '{'}{json.dumps(name)}: "
            parts += [_left([label]), _left(["null"]) if row is None else numerals(row[some], few=len(own) <= _FEW)]
        yield _joined([*parts, ends[own[some]], last], len(own[some]))


def _left(texts: Sequence[str]) -> Letters:
    """A table of texts, a row each; spaces fill it."""
    width = max(map(len, texts), default=0)
    return np.frombuffer("".join(x.ljust(width) for x in texts).encode("ascii"), np.uint8).reshape(len(texts), width)


def _joined(parts: Sequence[Letters], count: int) -> str:
    """Tables side by side, one row after the other."""
    whole = np.empty((count, sum(x.shape[1] for x in parts)), np.uint8)
    at = 0
    for x in parts:
        whole[:, at : at + x.shape[1]] = x
        at += x.shape[1]
    return whole.tobytes().decode("ascii")


def numerals(x: Reals, *, few: bool) -> Letters:
    """Numbers as text, a row each, null for what is not finite.

    >>> [bytes(row).decode() for row in numerals(np.array([0.1, 1 / 3, np.inf]), few=False)]
    ['1.0000000000000000e-01', '3.3333333333333331e-01', '                  null']
    """
    x = np.asarray(x, dtype=float)
    if few:
        texts = [repr(v) if np.isfinite(v) else "null" for v in x.tolist()]
        width = max(map(len, texts), default=0)
        return _left([t.rjust(width) for t in texts])
    plain = (x == 0) | ((x >= _DECADES[0]) & (x < _DECADES[-1]))
    found = _by_digits(np.where(plain, x, 0.0))
    if not plain.all():
        others = numerals(x[~plain], few=True)
        wide = max(found.shape[1], others.shape[1])
        found, others = (np.pad(t, ((0, 0), (wide - t.shape[1], 0)), constant_values=ord(" ")) for t in (found, others))
        found[~plain] = others
    return found


def _by_digits(x: Reals) -> Letters:
    """``d.dddddddddddddddde+dd`` of numbers from 10^-6 to 10^16, and of 0; 17 digits, the nearest, 15 where they read back."""
    decade = np.where(x == 0, -_LEAST, np.searchsorted(_DECADES, x, "right") - 1)
    shift = 16 - _LEAST - decade
    digits = _product(x, _EXACT[shift])
    short = (digits + 50) // 100
    digits = np.where(short / _EXACT[np.maximum(shift - 2, 0)] == x, np.where(shift >= 2, 100 * short, digits), digits)
    found = np.empty((len(x), 22), np.uint8)
    fours = [np.ndarray(len(x), np.uint32, found, at, (22,)) for at in (2, 6, 10, 14, 18)]  # columns of four letters
    fours.pop()[:] = _EXPONENTS.take(decade)
    while fours:
        above = digits // 10_000
        fours.pop()[:] = _FOUR.take(digits - 10_000 * above)
        digits = above
    found[:, 0], found[:, 1] = digits + ord("0"), ord(".")
    return found


def _product(x: Reals, power: Reals) -> Any:
    """The whole number nearest to a product from 10^16 to 10^17: its float, which is whole, and what that lacks (Dekker)."""
    found = x * power
    (a, b), (c, d) = _halves(x), _halves(power)
    return found.astype(np.int64) + np.rint(((a * c - found) + a * d + b * c) + b * d).astype(np.int64)


def _halves(x: Reals) -> tuple[Reals, Reals]:
    high = _SPLIT * x - (_SPLIT * x - x)
    return high, x - high


def listed(rows: Iterator[str], between: str) -> Iterator[str]:
    """A list, in parts, of rows that end with ``between``; what is after the last is left out.

    >>> "".join(listed(iter(["1,2,", "3,"]), ",")), "".join(listed(iter([]), ","))
    ('[\\n    1,2,3\\n  ]', '[]')
    """
    last = None
    for part in rows:
        yield "[\n    " if last is None else last
        last = part
    yield "[]" if last is None else f"{last.removesuffix(between)}\n  ]"
