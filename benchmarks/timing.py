"""Interleaved timing: every contender once per round, so that a machine whose speed drifts slows all of them alike."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, version


def medians(contenders: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median seconds of each contender over that many interleaved rounds, after one round to warm up."""
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(rounds + 1):
        for name, run in contenders.items():
            started = time.perf_counter()
            run()
            if turn:
                seconds[name].append(time.perf_counter() - started)
    return {name: statistics.median(found) for name, found in seconds.items()}


def table(title: str, seconds: Mapping[str, float], reference: str) -> None:
    """Print milliseconds and the ratio to a reference."""
    print(f"\n{title}")
    for name, found in seconds.items():
        print(f"  {name:<58} {1000 * found:10.2f} ms {found / seconds[reference]:10.2f} x")


def machine() -> str:
    """What was measured on."""
    names = ("sympy", "python-flint", "numpy", "numba", "control", "mpmath")
    found = []
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} absent")
    return f"{platform.python_implementation()} {platform.python_version()}, {os.cpu_count()} cores; {', '.join(found)}"
