"""Timing on a machine that others use too: contenders take turns, so that a slow moment slows all of them alike."""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter
from typing import Any, TypeVar

from haptisym.kernel.budget import forget, limited, spared
from haptisym.kernel.errors import HaptisymError

Key = TypeVar("Key", bound=Hashable)
_PACKAGES = ("numpy", "sympy", "python-flint", "scipy", "control", "numba")


@dataclass(frozen=True)
class Timed:
    """The median of the seconds that an attempt took, and what it answered.

    ``spread`` : half of the range in which the middle half of its turns lies, over the median; None of fewer than four turns.
    """

    seconds: float
    answer: Any
    spread: float | None = None


def interleaved(
    attempts: Mapping[Key, Callable[[], Any]],
    budget: float,
    *,
    rounds: int = 15,
    told: Callable[[Key, int], None] = lambda key, at: None,
) -> dict[Key, Timed]:
    """Every attempt once to warm up, then in turns: at most so many rounds, and none begun after ``budget`` seconds.

    An attempt whose first run took more than an eighth of the budget, or was cut short by a limit in time, is not repeated. In a
    turn short ones run several times in a row, and the quickest counts: the first pays for what was left behind before it.
    ``told`` is called with each key and its place as its first run begins. An attempt that raises a HaptisymError has that for
    its answer. No attempt profits from certified zeros that another one found.

    >>> found = interleaved({"sum": lambda: sum(range(100)), "constant": lambda: 1}, 0.01)
    >>> found["sum"].answer, found["sum"].seconds > found["constant"].seconds
    (4950, True)
    """
    began, answers, first, short = perf_counter(), {}, {}, []
    for at, (key, attempt) in enumerate(attempts.items()):
        told(key, at)
        with limited() as within:
            first[key], answers[key] = _once(attempt)
        if first[key] <= budget / 8 and not within.reached:
            short.append(key)
    seconds: dict[Key, list[float]] = {key: [] for key in attempts}
    with spared():
        for _ in range(rounds):
            if perf_counter() - began > budget:
                break
            for key in short:
                seconds[key].append(
                    min(_once(attempts[key])[0] for _ in range(_IN_A_ROW if first[key] < _SHORT else 1))
                )
    return {
        key: Timed(statistics.median(x := seconds[key] or [first[key]]), answers[key], _spread(x)) for key in attempts
    }


_IN_A_ROW, _SHORT = 3, 0.01  # s


def _spread(turns: list[float]) -> float | None:
    if len(turns) < 4:
        return None
    low, middle, high = statistics.quantiles(turns, n=4)
    return (high - low) / (2 * middle)


def _once(attempt: Callable[[], Any]) -> tuple[float, Any]:
    forget()
    started = perf_counter()
    try:
        answer = attempt()
    except HaptisymError as refusal:
        answer = refusal
    return perf_counter() - started, answer


def machine() -> dict[str, str]:
    """What is measured on: interpreter, processor count and versions; "absent" for a package that is not installed."""
    return {
        platform.python_implementation(): platform.python_version(),
        "processors": f"{os.cpu_count()} x {platform.machine()}",
        **{name: _version(name) for name in _PACKAGES},
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"
