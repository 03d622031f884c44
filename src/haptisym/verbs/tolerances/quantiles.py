"""Quantiles over sets of values that were drawn at random: estimates, for comparison with what is proven."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

from haptisym.verbs.tolerances.single import One

LEVELS = (5, 50, 95)


@dataclass(frozen=True)
class Quantiles:
    """Per cent to rad/s, of the first crossing and of the bandwidth; None where there is none in so many of the sets.

    ``transparent`` : how many of the sets are transparent on the whole band.
    """

    first: Mapping[int, float | None]
    bandwidth: Mapping[int, float | None]
    transparent: int


def quantiles(samples: Sequence[One]) -> Quantiles:
    """The quantiles of an answer's samples, of which there must be one at least."""
    first = [None if x.first is None else float(x.first) for x in samples]
    width = [None if x.bandwidth is None else float(x.bandwidth) for x in samples]
    beyond, never = float("inf"), -float("inf")  # no crossing on the band: beyond it; no bandwidth: less than any
    return Quantiles(
        {p: _quantile([beyond if x is None else x for x in first], p) for p in LEVELS},
        {p: _quantile([never if x is None else x for x in width], p) for p in LEVELS},
        sum(x.transparent is True for x in samples),
    )


def _quantile(values: Sequence[float], per_cent: int) -> float | None:
    """The least of the values that so many per cent of them do not exceed; None where it is infinite."""
    found = sorted(values)[max(ceil(per_cent * len(values) / 100) - 1, 0)]
    return found if abs(found) < float("inf") else None
