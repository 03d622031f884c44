"""Interleaved timing: every contender once per round, so that a machine whose speed drifts slows all of them alike."""

from __future__ import annotations

import json
import os
import platform
import resource
import statistics
import time
from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def medians(contenders: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median seconds of each contender over that many interleaved rounds, after one round to warm up."""
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(rounds + 1):
        for name, run in contenders.items():
            started = time.perf_counter()
            run()
            if turn:
                seconds[name].append(time.perf_counter() - started)
    return noted({name: statistics.median(found) for name, found in seconds.items()})


def shortest(contenders: Mapping[str, Callable[[], object]], rounds: int, in_a_row: int) -> dict[str, float]:
    """The shortest run of each contender over that many interleaved rounds, of several runs in a row, on the wall clock: for
    what takes microseconds, of which a busy machine leaves the shortest as it is."""
    seconds: dict[str, float] = {}
    for _ in range(rounds):
        for name, run in contenders.items():
            for _ in range(in_a_row):
                started = time.perf_counter()
                run()
                seconds[name] = min(seconds.get(name, float("inf")), time.perf_counter() - started)
    return noted(seconds)


def processor() -> float:
    """Seconds of processor time that this process and those that it has waited for have taken."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(x.ru_utime + x.ru_stime for x in both)


def least(contenders: Mapping[str, Callable[[], Callable[[], object]]], rounds: int) -> dict[str, float]:
    """The least processor time of each contender over that many interleaved rounds, of a few runs each.

    Each run is made ready anew, which is not timed. Of several in a row the later ones find the machine's caches warm.
    """
    seconds: dict[str, float] = {}
    for _ in range(rounds):
        for name, ready in contenders.items():
            for _ in range(_IN_A_ROW):
                run = ready()
                started = processor()
                run()
                seconds[name] = min(seconds.get(name, float("inf")), processor() - started)
    return noted(seconds)


_IN_A_ROW = 3


def noted(seconds: dict[str, float]) -> dict[str, float]:
    """The same seconds, which ``all.py`` keeps with their date and commit where it runs the script."""
    if place := os.environ.get(NOTES):
        with Path(place).open("a", encoding="utf-8") as file:
            print(json.dumps(seconds), file=file)
    return seconds


NOTES = "HAPTISYM_BENCHMARK_NOTES"
"""The variable of the environment with the file to which ``noted`` adds a line."""


def yardstick() -> float:
    """The least processor time, of nine, of a fixed computation in Python: how fast the machine is just now."""
    spent = []
    for _ in range(9):
        started = time.process_time()
        sum(i * i % 7 for i in range(200_000))
        spent.append(time.process_time() - started)
    return min(spent)


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
