"""The rows of a document with a million lines as text: as ``json.dumps`` has them, in a tenth of the time."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np

from haptisym.model.measured import Reals

_TOGETHER = 20_000
"""Rows that are joined at once: a list of all would need as much memory as the document."""


def row_texts(columns: Sequence[tuple[str, Reals | None]], kinds: Any, end: Callable[[int], str]) -> Iterator[str]:
    """A row for each line: ``columns`` by name, None for null, and what ends it.

    ``kinds`` : a number for each line; ``end`` : of the first line of a kind what all of that kind end with.

    >>> list(row_texts([("omega", np.array([1.0])), ("radius", None)], np.array([7]), lambda line: '"real": "below"'))
    ['{"omega": 1.0, "radius": null, "real": "below"}']
    """
    form = f"{{{{{', '.join(f'{json.dumps(name)}: {{}}' for name, _ in columns)}, {{}}}}}}".format
    names, first = np.unique(kinds, return_index=True)
    known = {name: end(line) for name, line in zip(names.tolist(), first.tolist(), strict=True)}
    ends = map(known.__getitem__, kinds.tolist())
    return map(form, *(_numbers(row, len(kinds)) for _, row in columns), ends)


def _numbers(row: Reals | None, count: int) -> Iterator[str]:
    if row is None:
        return iter(["null"] * count)
    if np.isfinite(row).all():
        return map(repr, row.tolist())
    return (repr(x) if told else "null" for x, told in zip(row.tolist(), np.isfinite(row).tolist(), strict=True))


def listed(rows: Iterator[str]) -> Iterator[str]:
    """A list with a row to a line, in parts.

    >>> print("".join(listed(iter(["1", "2"]))), "".join(listed(iter([]))))
    [
        1,
        2
      ] []
    """
    between, start = ",\n    ", "[\n    "
    while part := between.join(islice(rows, _TOGETHER)):
        yield start + part
        start = between
    yield "[]" if start != between else "\n  ]"
