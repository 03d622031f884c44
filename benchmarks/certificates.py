"""What certificates cost: writing one against answering, and checking it, for every shipped scene that has one.

    python benchmarks/certificates.py

Writing may cost three times what evaluating costs, checking the paper's example 50 ms of Python.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from timing import machine, medians

import haptisym as hs
from haptisym.kernel.budget import forget
from haptisym_check import check

SCENES = Path(hs.__file__).parent / "scenes"
SCENE_NAMES = [path.stem for path in sorted(SCENES.glob("*.toml"))]


QUESTIONS: dict[str, Callable[[hs.Scene], Any]] = {
    "evaluate": hs.evaluate,
    "stability": hs.stability,
    "require jnd": lambda scene: hs.require(scene, "evaluation.jnd"),
}


def costs(ask: Callable[[hs.Scene], Any], name: str) -> dict[str, float] | None:
    """Seconds to answer, to write and to check; None where there is no certificate."""
    text = (SCENES / f"{name}.toml").read_bytes()

    def answer() -> None:
        forget()
        ask(hs.load_scene(name)).to_json()

    try:
        found = ask(hs.load_scene(name))
        found.to_json()
        proof = found.certificate().encode()
    except (hs.SceneError, hs.UndecidedError):
        return None
    return medians({"answer": answer, "write": found.certificate, "check": lambda: check(proof, text)}, 5)


def main() -> None:
    print(machine())
    for question, ask in QUESTIONS.items():
        print(f"\n=== what certificates cost: {question} ===")
        print(f"{'scene':<28}{'answer, ms':>14}{'write, ms':>11}{'write/answer':>16}{'check, ms':>11}")
        for name in SCENE_NAMES:
            if found := costs(ask, name):
                ratio = found["write"] / found["answer"]
                answer, write, check_ = (1000 * found[x] for x in ("answer", "write", "check"))
                print(f"{name:<28}{answer:>14.1f}{write:>11.1f}{ratio:>16.2f}{check_:>11.1f}")


if __name__ == "__main__":
    main()
