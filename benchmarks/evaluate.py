"""What an evaluation costs, against the usual ways to the same crossings, in one run: least processor time of many rounds.

    python benchmarks/evaluate.py          (needs the extra [bench] for python-control; without it that row is left out)

Before each run, outside of its time, the caches of certified zeros are emptied, and scenes are read anew: nothing is remembered
of the run before but what SymPy and flint keep (interned numbers, contexts of polynomials), as in any process that has evaluated
another scene. Each way computes a response once.

Left out: SymPy's solve on the ratios, which takes minutes; Mathematica and MATLAB, which are not free software.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable

import sympy
from timing import least, machine, table

import haptisym as hs
from haptisym.judge.crossings import PerceptFunction, find_crossings, noticed
from haptisym.kernel.budget import forget
from haptisym.kernel.roots import chart
from haptisym.model.distortion import part_of

SCENE = hs.load_scene("fu2019")
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
NUMBERS = {"m": "9/5", "b": "15", "k": "100", "w": "80", "z": "1/2"}


def evaluate() -> list[float]:
    """Everything that an Evaluation holds."""
    scene = hs.Scene(SCENE.environment, SCENE.effects, SCENE.band, SCENE.threshold)
    result = hs.evaluate(scene)
    return [float(c.omega) for c in result.crossings if result.percepts and result.transparent]


def crossings_only() -> list[float]:
    """The certified crossings alone, from the scene's text values on."""
    d = hs.distort(SCENE.environment, *SCENE.effects)
    asked = {x: x.function(d) for x in noticed(SCENE.threshold)}
    asked |= {(PerceptFunction.DIFFERENCE, part): part_of(d.difference_response, part) for part in hs.Part}
    return [float(c.omega) for c in find_crossings(chart(asked, *SCENE.band))]


def sympy_roots() -> list[float]:
    """The obvious exact route: split dH with SymPy, form the threshold polynomials, isolate their real roots."""
    w, s = sympy.symbols("w s", positive=True)
    m, b, k, wn, z = (sympy.Rational(v) for v in NUMBERS.values())
    H = m * s**2 + b * s + k
    dH = H * (wn**2 / (s**2 + 2 * z * wn * s + wn**2) - 1)
    value, modulus = dH.subs(s, sympy.I * w), sympy.Abs(H.subs(s, sympy.I * w)) ** 2
    found = []
    for part in value.as_real_imag():
        ratio = sympy.together(part**2 / modulus - sympy.Rational(1, 100))
        polynomial = sympy.Poly(sympy.numer(sympy.cancel(ratio)), w)
        found += [float(root.evalf(15)) for root in polynomial.real_roots() if 0 < root <= 15]
    return sorted(found)


def grid_and_brent() -> list[float]:
    """python-control's frequency response on 2000 points, then Brent's method on each sign change. Nothing is proven."""
    import control
    import numpy as np
    from scipy.optimize import brentq

    H, D = control.tf([1.8, 15, 100], [1]), control.tf([6400], [1, 80, 6400])
    dH, grid = H * D - H, np.linspace(1e-3, 15, 2000)
    response, size = control.frequency_response(dH, grid).frdata[0, 0], abs(H(1j * grid))
    found = []
    for part in (np.real, np.imag):

        def excess(w: float, part: object = part) -> float:
            return float(abs(part(dH(1j * w))) / abs(H(1j * w)) - 0.1)  # type: ignore[operator]

        values = abs(part(response)) / size - 0.1
        found += [brentq(excess, *grid[i : i + 2]) for i in np.flatnonzero(np.diff(np.sign(values)))]
    return sorted(found)


def main() -> None:
    """Check that all find the same, then print the tables."""
    print(machine())
    contenders = {
        "haptisym: crossings only, certified": crossings_only,
        "haptisym evaluate(fu2019): everything, certified": evaluate,
        "SymPy real_roots: crossings only": sympy_roots,
    }
    try:
        grid_and_brent()
        contenders["python-control grid + brentq: crossings only, not proven"] = grid_and_brent
    except ImportError:
        print("python-control or SciPy is missing: its row is left out")
    for name, run in contenders.items():
        assert all(abs(a - b) < 1e-9 for a, b in zip(run(), evaluate(), strict=True)), name
    timed = least({name: lambda run=run: forgetful(run) for name, run in contenders.items()}, 40)
    table("Crossings of the paper's example on [0, 15] rad/s", timed, next(iter(contenders)))
    scenes = {name: lambda name=name: ready(name) for name in hs.scene_names()}
    table("Everything that evaluate finds, each shipped scene read anew", least(scenes, 8), "fu2019")
    command = [sys.executable, "-m", "haptisym", "evaluate", "fu2019"]
    processes = {
        'python -c "import sympy"': [sys.executable, "-c", "import sympy"],
        "haptisym evaluate fu2019": command,
        "haptisym evaluate fu2019 --json": [*command, "--json"],
    }
    starts = {name: lambda words=words: lambda: silent(words) for name, words in processes.items()}
    for words in processes.values():
        silent(words)  # byte code is written, as an installer does
    table("Whole processes, byte code in place", least(starts, 6), 'python -c "import sympy"')


def forgetful(run: Callable[[], object]) -> Callable[[], object]:
    """The same, with empty caches."""
    forget()
    return run


def ready(name: str) -> Callable[[], object]:
    """The whole evaluation of a scene that has just been read, with empty caches, and the crossings as doubles."""
    forget()
    scene = hs.load_scene(name)

    def run() -> object:
        found = hs.evaluate(scene)
        return [float(c.omega) for c in found.crossings], found.percepts, found.transparent

    return run


def silent(words: list[str]) -> None:
    """A process, without what it prints."""
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, env=ENVIRONMENT)


if __name__ == "__main__":
    main()
