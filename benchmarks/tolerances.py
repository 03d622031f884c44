"""Tolerances of the shipped scenes: seconds, verdicts and widths, and how they compare with another checkout, in one run.

    python benchmarks/tolerances.py [--against CHECKOUT] [--limit SECONDS] [--drawn N] [SCENE ...]

A row is a scene with a tolerance of 5 % on some of its numbers, its threshold among them: at most four at a time, all of
them in turn, and of the ten effects all at once. Each row is run here and in the other checkout by turns, each in a process of
its own that has warmed up; seconds are the processor's. ``width``: all enclosures together, as a share of the band; ``wider``:
what the worst enclosure here adds to those there, likewise;
``out``: how many crossings of members of the box, drawn at random, lie in no enclosure.

Left out: quantiles, which are single evaluations (``evaluate.py``).
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from sympy import Rational
from timing import machine, noted

import haptisym as hs

AT_ONCE, DEVIATION = 4, Rational(5, 100)
WHOLE = ("control-stick-in-detail",)
"""Scenes with a row of all numbers of their effects at once, and one of all numbers."""


def rows(name: str) -> Iterator[list[str]]:
    """The numbers of a scene by their symbols, at most four at a time; the threshold comes last."""
    scene = hs.load_scene(name)
    numbers = [*dict.fromkeys(p.symbol.name for p in scene.parameters if p.value and p.key != "order"), "c"]
    yield from (numbers[i : i + AT_ONCE] for i in range(0, len(numbers), AT_ONCE))
    if name in WHOLE:
        yield [p.symbol.name for p in scene.parameters if p.value and p.path.startswith("effects.")]
        yield numbers[:-1]


def around(value: Any) -> list[Any]:
    """A value with its tolerance."""
    return sorted([value * (1 - DEVIATION), value * (1 + DEVIATION)])


def ranged(name: str, numbers: list[str]) -> hs.Scene:
    """The scene in which these numbers are known to 5 %."""
    scene = hs.load_scene(name)
    known = {p.symbol.name: p.value for p in scene.parameters}
    ranges = {x: around(known[x]) for x in numbers if x != "c"}
    threshold = hs.Threshold.of(
        *(around(scene.threshold[part]) if "c" in numbers else scene.threshold[part] for part in hs.Part)
    )
    return replace(scene.with_values(ranges), threshold=threshold)


def answered(name: str, numbers: list[str], limit: float, drawn: int) -> dict[str, Any]:
    """One row in this process."""
    scene = ranged(name, numbers)
    started = time.process_time()
    found = hs.tolerances(scene, samples=0, limit=limit)
    seconds = time.process_time() - started
    enclosures = [(x.part.value, float(x.low), float(x.high)) for x in found.enclosures]
    out = sum(outside(member, enclosures) for member in members(scene, numbers, drawn))
    band = [float(x) for x in scene.band]
    row = {"seconds": seconds, "verdict": found.verdict.value, "enclosures": enclosures, "band": band}
    return {**row, "cut": found.limit is not None, "out": out}


def members(scene: hs.Scene, numbers: list[str], count: int) -> Iterator[hs.Scene]:
    """Scenes of the box, drawn at random, half of them at its corners."""
    draw = random.Random(14)
    for n in range(count):

        def value(low: Any, high: Any, n: int = n) -> Any:
            return low + (high - low) * (Rational(draw.randint(0, 1 << 20), 1 << 20) if n % 2 else draw.randint(0, 1))

        values = {p.symbol.name: value(*p.interval) for p in scene.parameters if p.interval}
        limits = (scene.threshold.real_interval, scene.threshold.imag_interval)
        c = [value(*x) if x else scene.threshold[part] for x, part in zip(limits, hs.Part, strict=True)]
        yield replace(scene.with_values(values), threshold=hs.Threshold.of(*c if c[0] != c[1] else c[:1]))


def outside(scene: hs.Scene, enclosures: list[tuple[str, float, float]]) -> int:
    """How many crossings of a scene lie in none of them."""
    crossings = [(x.part.value, float(x.omega)) for x in hs.evaluate(scene).crossings]
    return sum(
        not any(p == q and a * (1 - 1e-12) <= w <= b * (1 + 1e-12) for q, a, b in enclosures) for p, w in crossings
    )


class Checkout:
    """A process that answers rows with the package of a checkout."""

    def __init__(self, folder: Path) -> None:
        paths = [str(folder / "src"), os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
        command = [sys.executable, __file__, "--serve"]
        self.process = subprocess.Popen(
            command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def ask(self, *question: Any) -> dict[str, Any]:
        """One row."""
        assert self.process.stdin
        assert self.process.stdout
        self.process.stdin.write(json.dumps(question) + "\n")
        self.process.stdin.flush()
        found: dict[str, Any] = json.loads(self.process.stdout.readline())
        return found


def serve() -> None:
    """Answer what is asked on standard input, a row a line."""
    answered("fu2019", ["m"], 60, 1)
    for line in sys.stdin:
        print(json.dumps(answered(*json.loads(line))), flush=True)


def width(row: dict[str, Any]) -> float:
    """All enclosures together, a share of the band."""
    low, high = row["band"]
    return sum(b - a for _, a, b in row["enclosures"]) / (high - low)


def wider(here: dict[str, Any], there: dict[str, Any]) -> float:
    """What the worst enclosure here has that none there has, a share of the band."""
    low, high = here["band"]
    worst = 0.0
    for part, a, b in here["enclosures"]:
        shared = sum(max(0.0, min(b, y) - max(a, x)) for other, x, y in there["enclosures"] if other == part)
        worst = max(worst, (b - a - shared) / (high - low))
    return worst


def shown(name: str, numbers: list[str], here: dict[str, Any], there: dict[str, Any] | None) -> str:
    """One line of the table."""
    mark = "*" if here["cut"] else " "
    line = f"{name:<28} {' '.join(numbers):<40.40} {here['seconds']:8.2f}{mark} {here['verdict']:<9}"
    line = f"{line} {width(here):6.3f} {here['out']:3d}"
    if there is None:
        return line
    mark = "*" if there["cut"] else " "
    compared = f"{there['seconds']:8.2f}{mark} {there['verdict']:<9} {width(there):6.3f} {wider(here, there):7.4f}"
    return f"{line} | {compared} {there['seconds'] / here['seconds']:6.1f} x"


def main() -> None:
    """Print the table, a line as soon as it is known."""
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("scenes", nargs="*", default=[], help="all that are shipped if none is named")
    reader.add_argument("--against", type=Path)
    reader.add_argument("--limit", type=float, default=60.0)
    reader.add_argument("--drawn", type=int, default=10)
    reader.add_argument("--serve", action="store_true")
    asked = reader.parse_args()
    if asked.serve:
        serve()
        return
    print(machine())
    folders = [Path(__file__).parent.parent, *([asked.against] if asked.against else [])]
    checkouts = [Checkout(folder) for folder in folders]
    print(
        f"\n=== tolerances ===\n{'scene':<28} {'5 % on':<40} {'seconds':>8}  {'verdict':<9} {'width':>6} {'out':>3}",
        end="",
    )
    print(f" | {'seconds':>8}  {'verdict':<9} {'width':>6} {'wider':>7} {'faster':>8}" if asked.against else "")
    total = [0.0] * len(checkouts)
    for name in asked.scenes or hs.scene_names():
        for numbers in rows(name):
            drawn = (asked.drawn, 0)
            found = [x.ask(name, numbers, asked.limit, n) for x, n in zip(checkouts, drawn, strict=False)]
            noted({f"{name}, {' '.join(numbers)}": found[0]["seconds"]})
            total = [a + row["seconds"] for a, row in zip(total, found, strict=True)]
            print(shown(name, numbers, found[0], found[1] if asked.against else None), flush=True)
    print("together: " + " against ".join(f"{x:.1f} s" for x in total) + "; * cut short by the limit")


if __name__ == "__main__":
    main()
