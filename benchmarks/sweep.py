"""What a sweep of the paper's scene costs and how often it is right, against a vectorised grid with bisection, in one run.

    OMP_NUM_THREADS=1 python benchmarks/sweep.py             (needs the extra [sweep])
    python benchmarks/sweep.py --million                     10^6 sets streamed to disk, with the peak memory

The grid has 128 points on the band, as is usual; it is the natural real form of the ratios in NumPy, in blocks that fit the
cache. haptisym runs as for very many sets, in machine code (the extra [fast]; without it in NumPy), and in NumPy. Processor
time, best of interleaved rounds, on one core. The truth for the wrong counts is exact arithmetic.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from timing import machine, noted

import haptisym as hs
from haptisym.verbs.sweep.axes import axes
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.evaluator import SetEvaluator
from haptisym.verbs.sweep.exactanswers import exact_answers

PAPER = hs.load_scene("fu2019")
PATHS = {
    "environment.m": (0.2, 6.0),
    "environment.b": (1.0, 60.0),
    "environment.k": (20.0, 500.0),
    "effects.filter.omega_n": (10.0, 200.0),
    "effects.filter.zeta": (0.05, 1.0),
}
TWO = {path: PATHS[path] for path in ("environment.m", "effects.filter.omega_n")}
HARD = {
    "environment.m": (1e-3, 1e3),
    "environment.b": (1e-6, 1e3),
    "environment.k": (1e-3, 1e3),
    "effects.filter.omega_n": (1.0, 1e4),
    "effects.filter.zeta": (1e-3, 1.0),
}
SETS, ROUNDS, CHECKED, POINTS = 65_536, 5, 1_000, 128


def drawn(spans: dict[str, tuple[float, float]], sets: int) -> Array:
    """Random sets, evenly in the logarithm."""
    rng = np.random.default_rng(2019)
    return np.exp(np.array([rng.uniform(*np.log(span), sets) for span in spans.values()]))


def excess(omega: Array, sets: Array) -> tuple[Array, Array]:
    """abs(Re dH) - c abs(H) and abs(Im dH) - c abs(H)."""
    m, b, k, w, z = sets
    H, D = (k - m * omega**2, b * omega), (w**2 - omega**2, 2 * z * w * omega)
    N = (omega**2, -D[1])
    square = D[0] ** 2 + D[1] ** 2
    x = (N[0] * D[0] + N[1] * D[1]) / square, (N[1] * D[0] - N[0] * D[1]) / square
    limit = 0.1 * np.sqrt(H[0] ** 2 + H[1] ** 2)
    return np.abs(H[0] * x[0] - H[1] * x[1]) - limit, np.abs(H[0] * x[1] + H[1] * x[0]) - limit


def grid_and_bisect(sets: Array, block: int = 512) -> Array:
    """The number of crossings of both parts, from 128 points; each is refined by 52 bisections."""
    grid = np.linspace(0, 15, POINTS)[:, None]
    counts = np.zeros((2, sets.shape[1]), dtype=int)
    for i in range(0, sets.shape[1], block):
        some = sets[:, i : i + block]
        for part, values in enumerate(excess(grid, some)):
            above = values > 0
            row, column = (above[1:] != above[:-1]).nonzero()
            counts[part, i : i + block] = np.bincount(column, minlength=some.shape[1])
            low, high, rises = grid[row, 0], grid[row + 1, 0], above[row + 1, column]
            for _ in range(52):
                middle = (low + high) / 2
                beyond = (excess(middle, some[:, column])[part] > 0) == rises
                low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return counts


def completed(spans: dict[str, tuple[float, float]], values: Array) -> Array:
    """All five parameters: those that are varied, and the scene's own numbers."""
    own = {p.path: float(p.value) for p in PAPER.parameters}
    rows = dict(zip(spans, values, strict=True))
    return np.array([rows.get(path, np.full(values.shape[1], own[path])) for path in PATHS])


def evaluator_for(spans: dict[str, tuple[float, float]]) -> SetEvaluator:
    return SetEvaluator.of(
        PAPER, [axis.knob for axis in axes(PAPER, {path: list(span) for path, span in spans.items()})]
    )


def seconds(run: object, *arguments: object) -> float:
    started = time.process_time()
    run(*arguments)  # type: ignore[operator]
    return time.process_time() - started


def compare(name: str, spans: dict[str, tuple[float, float]], sets: int) -> None:
    """Speed and wrong counts of both on random sets."""
    evaluator, values = evaluator_for(spans), drawn(spans, sets)
    rows = completed(spans, values)
    fast = replace(evaluator, many=True)
    runs = ((fast.in_floats, values), (evaluator.in_floats, values), (grid_and_bisect, rows))
    times = [[seconds(*run) for run in runs] for _ in range(ROUNDS + 1)][1:]
    compiled, ours, theirs = (min(column) / sets for column in zip(*times, strict=True))
    columns, left = fast.in_floats(values)
    noted({f"{name}, a set": ours, f"{name}, a set in machine code": compiled})
    print(f"\n{name}: {sets} sets of {len(spans)} parameters")
    for who, taken in (("haptisym, Numba", compiled), ("haptisym, NumPy", ours), ("grid and bisect", theirs)):
        print(
            f"  {who:16} {1e6 * taken:8.2f} us for a set {1e-3 / taken:8.0f} thousand sets/s; {theirs / taken:.2f} x the grid's"
        )
    print(f"  left to exact arithmetic: {len(left)} sets, {100 * len(left) / sets:.3f} %")
    wrong, at = {"haptisym": 0, "grid and bisect": 0}, slice(0, min(CHECKED, sets))
    grid, own = grid_and_bisect(rows[:, at]), np.array([columns["crossings_real"][at], columns["crossings_imag"][at]])
    for i in range(grid.shape[1]):
        truth = exact_answers(PAPER, evaluator.swept, values[:, i].tolist())
        counts = [truth["crossings_real"], truth["crossings_imag"]]
        wrong["haptisym"] += i not in left and own[:, i].tolist() != counts
        wrong["grid and bisect"] += grid[:, i].tolist() != counts
    for who, count in wrong.items():
        print(f"  wrong counts, {who}: {count} of {grid.shape[1]} sets")


def million() -> None:
    """10^6 sets streamed to a store in this one process."""
    vary = {"effects.filter.omega_n": np.linspace(20, 200, 1000), "environment.m": np.linspace(0.2, 6, 1000)}
    hs.sweep(PAPER, {path: values[:3] for path, values in vary.items()})
    with tempfile.TemporaryDirectory() as folder:
        for name, span in (("10^4", slice(0, 10)), ("10^6", slice(None))):
            started = time.perf_counter()
            some = {path: values[span] if path.startswith("eff") else values for path, values in vary.items()}
            found = hs.sweep(PAPER, some, out=Path(folder) / f"{name}.zarr")
            taken = time.perf_counter() - started
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            exact = int((found.method != 0).sum())
            print(f"{name} sets: {taken:.1f} s, peak memory so far {peak:.0f} MB, {exact} sets exact")


def main() -> None:
    print(machine())
    if "--million" in sys.argv:
        million()
        return
    compare("Mass and filter", TWO, SETS)
    compare("All parameters", PATHS, SETS)
    compare("Hard parameters", HARD, 4_096)


if __name__ == "__main__":
    main()
