"""What the best values cost, proven, beside a grid with local refinement and SciPy's ``differential_evolution``, in one run.

    python benchmarks/design.py

All maximise the same function, the bandwidth. The others have it from compiled NumPy: the first of 2,000 frequencies at which
|Re dH| or |Im dH| exceeds its threshold. Neither says how much better other values may be; ``short`` is by how much what they
found, evaluated exactly, stays below what ``design`` attains, ``bound`` what design proves that nothing exceeds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from time import process_time
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution, minimize
from sympy import Integer, Rational
from timing import machine, noted

import haptisym as hs
from haptisym.model.distortion import Distortion

Box = dict[str, tuple[float, float]]
QUESTIONS: dict[str, tuple[str, int, Box]] = {
    "paper, zeta": ("fu2019", 60, {"zeta": (0.01, 1)}),
    "paper, omega_n and zeta": ("fu2019", 300, {"omega_n": (8, 800), "zeta": (0.01, 1)}),
    "paper, omega_n, zeta and b": ("fu2019", 300, {"omega_n": (8, 800), "zeta": (0.01, 1), "b": (1.5, 150)}),
    "virtual wall, T and m": ("virtual-wall", 120, {"T": (2e-4, 2e-3), "device.m": (4e-3, 0.4)}),
}
_GRID, _FREQUENCIES = {1: 200, 2: 30, 3: 12}, 2000


def minus_bandwidth(scene: hs.Scene, paths: list[str]) -> Callable[[Any], float]:
    """As a function of values, in NumPy."""
    free = [scene.knobs[x].symbol for x in paths]
    chain = scene.chain.at({p.symbol: p.value for p in scene.parameters if p.symbol not in free})
    function = Distortion.of(chain).compile(of=["ratio_real", "ratio_imag"])
    omega = np.linspace(*map(float, scene.band), _FREQUENCIES + 1)[1:]
    c = float(scene.threshold.real)

    def found(values: Any) -> float:
        ratios = function(omega, **{x.name: float(v) for x, v in zip(free, values, strict=True)})
        beyond = np.flatnonzero(np.maximum(ratios.ratio_real, ratios.ratio_imag) > c)
        return -float(omega[beyond[0]] if len(beyond) else omega[-1])

    return found


def grid(f: Callable[[Any], float], box: list[tuple[float, float]]) -> Any:
    """The best of a grid by ratios, then Nelder and Mead's simplex from there."""
    axes = [np.geomspace(*ends, _GRID[len(box)]) for ends in box]
    start = min(product(*axes), key=f)
    return minimize(f, start, method="Nelder-Mead", bounds=box).x


def evolution(f: Callable[[Any], float], box: list[tuple[float, float]]) -> Any:
    """SciPy's global search, with its defaults and a fixed seed."""
    return differential_evolution(f, box, seed=1).x


def exact(scene: hs.Scene, paths: list[str], values: Any) -> float:
    """The bandwidth that values attain."""
    own = {path: Rational(*float(v).as_integer_ratio()) for path, v in zip(paths, values, strict=True)}
    found = hs.evaluate(scene.with_values(own)).bandwidth
    return 0.0 if found is None else float(found)


def main() -> None:
    """Print a table."""
    print(machine())
    print("\nquestion                          by                       s    bandwidth      short      bound")
    for name, (scene_name, high, free) in QUESTIONS.items():
        scene = replace(hs.load_scene(scene_name), band=(Integer(0), Integer(high)))
        paths, box = list(free), list(free.values())
        started = process_time()
        answer = hs.design(scene, free)
        spent = noted({name: process_time() - started})[name]
        low, most = answer.bandwidth
        print(f"{name:<33} design           {spent:9.2f} {low:12.4f} {'':10} {most:10.4f}")
        f = minus_bandwidth(scene, paths)
        for label, search in (("grid and simplex", grid), ("evolution", evolution)):
            started = process_time()
            values = search(f, box)
            spent, attained = process_time() - started, exact(scene, paths, values)
            print(f"{'':<33} {label:<16} {spent:9.2f} {attained:12.4f} {1 - attained / low:10.2%}")


if __name__ == "__main__":
    main()
