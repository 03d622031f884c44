"""Published thresholds, by name: what was measured, of whom, at which criterion, and how far the source was read."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from sympy import Expr

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.shown import Shown
from haptisym.model.parameters import ExactRange
from haptisym.model.quantities import decimal


@dataclass(frozen=True, repr=False)
class Published(Shown):
    """A just-noticeable difference as its source gives it: a fraction, or from the least to the most.

    ``criterion`` : the share of answers at which it was taken, None where that is not known. ``read`` : how far the source was
    read. ``apart`` : why it is no threshold for a scene; empty where it may be one.
    """

    name: str
    quantity: str
    low: Expr
    high: Expr
    criterion: Expr | None
    reference: str
    source: str
    doi: str
    read: str
    apart: str

    def _line(self) -> str:
        return f"{self.name}: {self.written}, {self.quantity}"

    @property
    def written(self) -> str:
        """In per cent."""
        low, high = (f"{float(100 * x):.4g}" for x in (self.low, self.high))
        return f"{low} %" if low == high else f"{low} to {high} %"

    @property
    def given(self) -> Expr | ExactRange:
        """As a threshold is given: a number, or the pair of its ends."""
        return self.low if self.low == self.high else (self.low, self.high)


@cache
def published_by_name() -> Mapping[str, Published]:
    """All of them, in the order of the shipped table."""
    table = tomllib.loads((files("haptisym") / "data" / "published.toml").read_text(encoding="utf-8"))
    return {name: _read(name, row) for name, row in table.items()}


def _read(name: str, row: Mapping[str, Any]) -> Published:
    value, criterion = row["value"], row.get("criterion")
    low, high = map(decimal, (value, value) if isinstance(value, str) else value)
    return Published(
        name, row["quantity"], low, high, None if criterion is None else decimal(criterion), row["reference"], row["source"],
        row.get("doi", ""), row["read"], row.get("apart", ""),
    )  # fmt: skip


def like(name: object) -> Published:
    """The one of that name, fit for a scene; SceneError for any other name, and where it is not one."""
    known = published_by_name()
    if not isinstance(name, str) or name not in known:
        shown = str(name)[:60]
        raise SceneError(f'like: no published threshold "{shown}": {meant(shown, known)}valid are {", ".join(known)}')
    found = known[name]
    if found.apart:
        raise SceneError(f'like: "{name}" is no threshold for a scene: {found.apart}')
    return found
