"""What accuracy costs, and how the hard cases fare: the tables and figures of docs/accuracy.md, in one run.

    python benchmarks/cost.py          (needs SciPy and python-control for the usual ways; what is missing is named and left out)

Three scenes: the paper's example, one with a delay, one with hardly any damping; the hard cases. The figures go to docs/figures.
"""

from __future__ import annotations

from pathlib import Path

from timing import machine

import haptisym as hs

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
SCENES = {
    "fu2019": "fu2019",
    "satellite-contact": "satellite-contact",
    "light-damping": str(FIGURES / "light-damping.toml"),
}


def main() -> None:
    """Measure, print and draw."""
    print(machine())
    for name, place in SCENES.items():
        found = hs.cost(hs.load_scene(place))
        found.save_figure(FIGURES / f"cost-{name}.svg")
        print(f"\n=== {name} ===\n\n{found}")
    hard = hs.hard_costs()
    hard.save_figure(FIGURES / "hard-cases.svg")
    print(f"\n=== hard cases ===\n\n{hard}")


if __name__ == "__main__":
    main()
