"""What certificates cost: writing one against evaluating, and checking it, for every shipped rational scene.

    python benchmarks/certificates.py

Writing may cost three times what evaluating costs, checking the paper's example 50 ms of Python.
"""

from __future__ import annotations

from pathlib import Path

from timing import machine, medians

import haptisym as hs
from haptisym.kernel.caches import forget
from haptisym_check import check

SCENES = Path(hs.__file__).parent / "scenes"


def costs(name: str) -> dict[str, float] | None:
    """Seconds to evaluate, to write and to check; None of a scene that is not rational."""
    text = (SCENES / f"{name}.toml").read_bytes()

    def evaluate() -> None:
        forget()
        hs.evaluate(hs.load_scene(name)).to_json()

    found = hs.evaluate(hs.load_scene(name))
    found.to_json()
    try:
        proof = found.certificate().encode()
    except hs.SceneError:
        return None
    return medians({"evaluate": evaluate, "write": found.certificate, "check": lambda: check(proof, text)}, 7)


def main() -> None:
    print(machine())
    print("\n=== what certificates cost ===")
    print(f"{'scene':<28}{'evaluate, ms':>14}{'write, ms':>11}{'write/evaluate':>16}{'check, ms':>11}")
    for name in hs.scene_names():
        if found := costs(name):
            ratio = found["write"] / found["evaluate"]
            evaluate, write, check_ = (1000 * found[x] for x in ("evaluate", "write", "check"))
            print(f"{name:<28}{evaluate:>14.1f}{write:>11.1f}{ratio:>16.2f}{check_:>11.1f}")


if __name__ == "__main__":
    main()
