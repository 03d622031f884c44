"""Published thresholds, by name, and at another criterion.

Published thresholds, by name: what was measured, of whom, at which criterion, and how far the source was read.

A threshold at another criterion: at which proportion of right answers it was taken, by a cumulative Gaussian.

A change of size x is told with the probability Phi(x/sigma), so that the change told with probability p is z(p) sigma, z the
inverse of Phi: thresholds at two proportions are to each other as their z. The quotient is transcendental; it is rounded to a
decimal number of DIGITS digits, each proven, so that everything that follows is exact for that number.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import flint
from flint import arb
from sympy import Expr, Rational

from haptisym.kernel.errors import SceneError, meant
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.model.parameters import ExactRange
from haptisym.model.quantities import Dimension, Number, decimal, number


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


DIGITS = 30


@dataclass(frozen=True, repr=False)
class Quotient(RealNumber):
    """z(q)/z(p): the threshold at the proportion q, for one of 1 at p.

    >>> Quotient(Rational(3, 4), Rational(21, 25)).digits(17)
    '1.4743854638571648'
    """

    start: Expr
    end: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits + 16):
            one, other = (2 * expression_ball(x) - arb(1) for x in (self.start, self.end))
            return other.erfinv() / one.erfinv()


@dataclass(frozen=True)
class Conversion:
    """From one proportion of right answers to another: times ``factor``, which is ``exact`` rounded to DIGITS digits."""

    start: Expr
    end: Expr

    @property
    def exact(self) -> RealNumber:
        """The factor of a threshold, as a number that can be enclosed."""
        return Quotient(self.start, self.end)

    @property
    def factor(self) -> Rational:
        """The factor of a threshold, as the decimal that is said; 1 where nothing is converted."""
        return decimal(self.exact.digits(DIGITS)) if self.start != self.end else Rational(1)

    def row(self) -> dict[str, object]:
        """As documents have it."""
        shown = {"factor": self.exact.digits(DIGITS), "enclosure": list(self.exact.enclosure(DIGITS))}
        return {"from": float(self.start), "to": float(self.end), **shown}


def read_proportion(key: str, given: Number) -> Expr:
    """A proportion of right answers, above one half and below 1; SceneError for any other."""
    try:
        value = number(given, Dimension.RATIO).value
    except SceneError as error:
        raise error.within(key) from None
    if not value.is_Rational or not Rational(1, 2) < value < 1:
        raise SceneError(f'{key}: "{given}" must be rational, above 0.5, where answers are guesses, and below 1')
    return value
