"""What sweeps of scenes with delays, holds and spring-pots cost in floats, against exact arithmetic, in one run.

    OMP_NUM_THREADS=1 python benchmarks/wavesweep.py         (needs the extra [sweep])
    python benchmarks/wavesweep.py 10000                     count so many sets exactly too, for the wrong ones

Two parameters of each scene, a delay or a hold among them, are drawn evenly in the logarithm. Processor time, best of interleaved
rounds, on one core; the sweep of the paper's rational scene in the same rounds tells how fast the machine was.
"""

from __future__ import annotations

import sys

import numpy as np
from sweep import PAPER, TWO, drawn, seconds
from timing import machine

import haptisym as hs
from haptisym.verbs.sweep.axes import axes
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.delayterms import ulp_errors
from haptisym.verbs.sweep.evaluator import SetEvaluator
from haptisym.verbs.sweep.exactanswers import exact_answers

SWEPT = {
    "satellite-contact": {"effects.loop-delay.tau": (1e-3, 0.3), "environment.k": (2e3, 4e4)},
    "delayed-spring": {"effects.delay.tau": (1e-3, 0.3), "environment.k": (10.0, 1e3)},
    "sampled-wall": {"effects.sampling.T": (1e-4, 2e-2), "environment.k": (50.0, 2e3)},
    "organ-tissue": {"effects.communication.tau": (1e-4, 0.05), "environment.k": (10.0, 1e3)},
    "four-channel-teleoperation": {"effects.teleoperator.tau": (1e-4, 0.1), "environment.k": (10.0, 1e3)},
}
SETS, ROUNDS, EXACT = 16_384, 4, 20


def evaluator_for(scene: hs.Scene, spans: dict[str, tuple[float, float]]) -> SetEvaluator:
    return SetEvaluator.of(
        scene, [axis.knob for axis in axes(scene, {path: list(span) for path, span in spans.items()})]
    )


def exactly(evaluator: SetEvaluator, values: Array) -> list[dict[str, float]]:
    return [exact_answers(evaluator.scene, evaluator.swept, one.tolist()) for one in values.T]


def compare(name: str, spans: dict[str, tuple[float, float]], checked: int) -> None:
    """Speeds of floats and of exact arithmetic, what is left to it, and wrong counts."""
    evaluator, values = evaluator_for(hs.load_scene(name), spans), drawn(spans, SETS)
    rational, rows = evaluator_for(PAPER, TWO), drawn(TWO, SETS)
    times = [
        (
            seconds(evaluator.in_floats, values),
            seconds(exactly, evaluator, values[:, :EXACT]),
            seconds(rational.in_floats, rows),
        )
        for _ in range(ROUNDS + 1)
    ][1:]
    floats, exact, paper = (
        min(column) / n for column, n in zip(zip(*times, strict=True), (SETS, EXACT, SETS), strict=True)
    )
    columns, left = evaluator.in_floats(values)
    print(f"\n{name}: {', '.join(spans)}")
    print(
        f"  floats {1e-3 / floats:8.1f} thousand sets/s and core, {exact / floats:8.0f} x exact ({1 / exact:.0f} sets/s)"
    )
    print(
        f"  the paper's rational scene: {1e-3 / paper:.0f} thousand sets/s; left to exact: {100 * len(left) / SETS:.3f} %"
    )
    if checked:
        wrong = [
            i
            for i, truth in enumerate(exactly(evaluator, values[:, :checked]))
            if i not in left and any(columns[key][i] != truth[key] for key in evaluator.told.counts)
        ]
        print(f"  wrong counts: {len(wrong)} of {checked} sets")


def main() -> None:
    print(machine())
    print("ulp:", ", ".join(f"{name} {error:.2f}" for name, error in ulp_errors().items()), "| numpy", np.__version__)
    for name, spans in SWEPT.items():
        compare(name, spans, int(sys.argv[1]) if len(sys.argv) > 1 else 0)


if __name__ == "__main__":
    main()
