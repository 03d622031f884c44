"""Why a model is fitted on request: what AAA makes of a noisy response, beside a fraction of degrees 2 and 2 by least squares.

    python benchmarks/fitters.py

400 lines of fu2019's H_perc from 0.5 to 60 rad/s, with circular noise of a known size. AAA is SciPy's, with at most 100 terms, or
with a tolerance of five times the noise; both see each line and its conjugate. Left out: vector fitting, for which there is no
package among ours; it has the same freedom as AAA, as many poles as it is given.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from timing import machine

import haptisym as hs

OMEGA = np.linspace(0.5, 60, 400)
NOISES = (0.0, 1e-6, 1e-3, 1e-2)
SIGMA_OF_DISC = np.sqrt(-2 * np.log(0.05))
WANTED = 7.978916790174708


def crossing(perceived: Any) -> str:
    """Where r_r first exceeds 0.1, on a fine grid of the band from 1 rad/s."""
    at = np.linspace(1, 15, 28_001)
    env = hs.sampled(hs.Scene(hs.load_scene("fu2019").environment), at).H
    over = np.abs((perceived(1j * at) - env).real) > 0.1 * np.abs(env)
    return f"{at[np.argmax(over)]:9.4f}" if over.any() else "     none"


def by_aaa(H: Any, **ways: Any) -> str:
    """Poles, those in the right half plane, and the crossing."""
    from scipy.interpolate import AAA

    s = 1j * OMEGA
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = AAA(np.concatenate([s, -s]), np.concatenate([H, H.conj()]), **ways)
        poles = found.poles()
    return f"{len(poles):5d} {int((poles.real > 0).sum()):8d} {crossing(found)}"


def by_least_squares(H: Any, noise: float) -> str:
    """The same of the fitted fraction."""
    radius = noise * np.abs(H) / np.sqrt(2) * SIGMA_OF_DISC if noise else None
    found = hs.identify(hs.measured(OMEGA, H, radius=radius), degrees=(2, 2))
    value = {x.parameter.name: x.value for x in found.estimates}
    bottom = [value["d2"], value["d1"], 1.0]
    poles = np.roots(bottom)
    top = [value["a2"], value["a1"], value["a0"]]
    return f"{len(poles):5d} {int((poles.real > 0).sum()):8d} {crossing(lambda s: np.polyval(top, s) / np.polyval(bottom, s))}"


def main() -> None:
    """A table of the three ways for each size of noise."""
    print(machine())
    print("=== noise ===")
    print(f"{'noise':>8}  {'way':<26} poles unstable  crossing (true {WANTED:.4f} rad/s)")
    exact = hs.sampled("fu2019", OMEGA).H
    for noise in NOISES:
        rng = np.random.default_rng(2019)
        error = (rng.normal(size=OMEGA.size) + 1j * rng.normal(size=OMEGA.size)) / np.sqrt(2)
        H = exact * (1 + noise * error)
        print(f"{noise:8.0e}  {'AAA':<26} {by_aaa(H, max_terms=100)}")
        print(f"{noise:8.0e}  {'AAA, rtol 5 times the noise':<26} {by_aaa(H, rtol=max(5 * noise, 1e-13))}")
        print(f"{noise:8.0e}  {'least squares, degrees 2, 2':<26} {by_least_squares(H, noise)}")


if __name__ == "__main__":
    main()
