"""What another JND region costs, in one run: whole evaluations of the same scenes, as multiples of those with the square.

    python benchmarks/regions.py [SCENE ...]

All contenders run interleaved, from scenes with nothing derived yet and with empty caches.
"""

from __future__ import annotations

import sys
from typing import Any

from evaluate import forget
from timing import machine, medians, table

import haptisym as hs

REGIONS: dict[str, Any] = {
    "square": 0.1,
    "formula in omega": "0.08 + 0.004*omega",
    "disc": {"shape": "ellipse", "real": 0.1, "imag": 0.1},
    "tilted ellipse": {"shape": "ellipse", "real": 0.1, "imag": 0.12, "tilt": 0.5},
    "diamond": {"shape": "diamond", "real": 0.1, "imag": 0.1},
    "hexagon": {
        "shape": "polygon",
        "corners": [[0.1, 0], [0.05, 0.09], [-0.05, 0.09], [-0.1, 0], [-0.05, -0.09], [0.05, -0.09]],
    },
    "higher and lower": {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1},
    "floor": {"real": 0.1, "imag": 0.1, "floor": 15},
}


def evaluated(scene: hs.Scene, jnd: Any) -> list[object]:
    """Everything that an Evaluation holds."""
    forget()
    found = hs.evaluate(hs.Scene(scene.environment, scene.effects, scene.band, jnd, scene.rendered))
    return [found.crossings, found.transparent, found.percepts]


def main() -> None:
    """A table for each scene."""
    print(machine())
    for name in sys.argv[1:] or ["fu2019", "position-force-teleoperation", "delayed-spring"]:
        scene = hs.load_scene(name)
        own = {region: (lambda jnd=jnd: evaluated(scene, jnd)) for region, jnd in REGIONS.items()}  # noqa: B023 - run at once
        table(f"{name}: evaluation (everything, certified)", medians(own, 9), "square")


if __name__ == "__main__":
    main()
