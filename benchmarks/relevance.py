"""What leaving out the effects that do not matter saves, in one run: evaluation, formulas, simulation.

    python benchmarks/relevance.py [SCENE] [TOLERANCE]

All contenders run interleaved, from scenes with nothing derived yet and with empty caches. The price of the proof, paid
once, is a row of its own.
"""

from __future__ import annotations

import sys

from evaluate import forget
from timing import machine, medians, table

import haptisym as hs


def fresh(scene: hs.Scene) -> hs.Scene:
    """The scene with nothing derived yet."""
    forget()
    return hs.Scene(scene.environment, scene.effects, scene.band, scene.threshold, scene.rendered)


def evaluated(scene: hs.Scene) -> list[object]:
    """Everything that an Evaluation holds."""
    found = hs.evaluate(fresh(scene))
    return [found.crossings, found.transparent, found.percepts]


def main() -> None:
    """Check that the pruned scene encloses the full one's crossings, then print the tables."""
    given = dict(enumerate(sys.argv))
    name, tolerance = given.get(1, "control-stick-in-detail"), given.get(2, "0.01")
    scene = hs.load_scene(name)
    found = hs.relevance(scene, tolerance)
    pruned = found.pruned
    for c in hs.evaluate(scene).crossings:
        assert any(x.part is c.part and x.bounds[0] <= float(c.omega) <= x.bounds[1] for x in found.crossings)
    print(machine())
    full, kept = found.operations
    print(f"{name}, tolerance {tolerance}: {len(pruned.effects)} of {len(scene.effects)} effects kept")
    print(f"operations in steps: {full} and {kept}, {full / kept:.2f} times fewer")
    table(
        "Evaluation (everything, certified)",
        medians(
            {
                "kept effects": lambda: evaluated(pruned),
                "all effects": lambda: evaluated(scene),
                "finding and proving which are kept (once)": lambda: hs.relevance(fresh(scene), tolerance),
            },
            9,
        ),
        "kept effects",
    )
    table(
        "Formulas in named steps, symbolic",
        medians(
            {"kept effects": lambda: fresh(pruned).chain.steps, "all effects": lambda: fresh(scene).chain.steps}, 5
        ),
        "kept effects",
    )
    motion, time = hs.sine("1 cm", 10), "2 s"
    table(
        "Simulation of 2 s",
        medians(
            {
                "kept effects": lambda: hs.simulate(pruned, motion, duration=time),
                "all effects": lambda: hs.simulate(scene, motion, duration=time),
            },
            5,
        ),
        "kept effects",
    )


if __name__ == "__main__":
    main()
