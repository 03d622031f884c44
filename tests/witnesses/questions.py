"""What the exact core is asked, wherever it runs: here, where packages are missing, and in a browser's WebAssembly.

As a program: ``python questions.py WITHOUT NAME ...`` prints the answers about shipped scenes while the packages WITHOUT
(separated by commas, "" for none) cannot be imported, with what of NumPy and the like was loaded all the same.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable
from typing import Any

ARRAYS = ("numpy", "matplotlib", "scipy")
REQUIRED = {
    "fu2019": ("effects.filter.omega_n", "effects.filter.zeta", "evaluation.jnd"),
    "sampled-wall": ("evaluation.jnd",),
}
"""Paths that are asked about: answers that exact arithmetic alone has within seconds."""


def answers(name: str) -> dict[str, str]:
    """Of a shipped scene, by question: documents of JSON, and what is read."""
    import haptisym as hs

    scene = hs.load_scene(name)
    asked: dict[str, Callable[[], Any]] = {
        "evaluate": lambda: hs.evaluate(scene),
        "stability": lambda: hs.stability(scene),
        "derive": lambda: hs.derive(scene),
    }
    asked |= {
        f"require {path}": lambda path=path: hs.require(scene, path, limit=None) for path in REQUIRED.get(name, ())
    }
    told, found = {}, {}
    for question, ask in asked.items():
        answer = told[question] = ask()
        found[question], found[f"{question}, as text"] = answer.to_json(), str(answer)
    if name == "fu2019":
        held = hs.stability(scene, "firm-grip")
        found["firm-grip"] = held.to_json()
        proven = {"evaluate": told["evaluate"], "stability": held, "require": told["require effects.filter.zeta"]}
        found |= {f"certificate of {question}": answer.certificate() for question, answer in proven.items()}
    return found


def main(without: str, names: Iterable[str]) -> None:
    for package in filter(None, without.split(",")):
        sys.modules[package] = None  # type: ignore[assignment]
    found = {name: answers(name) for name in names}
    print(json.dumps({"answers": found, "loaded": [x for x in ARRAYS if sys.modules.get(x)]}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
