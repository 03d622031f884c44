"""What a float costs: nanoseconds a frequency for both ratios of fu2019, and what the levels of accuracy cost and leave open.

Run: python benchmarks/throughput.py [frequencies ...]

Contenders run interleaved, some times in a row; the shortest run of each. Every contender computes both ratios at 10^3 and 10^6
frequencies from 1e-2 to 1e3 rad/s, with the scene's numbers in place. The essential traffic is 24 bytes a frequency: one double
read, two written. "memory" is that stream alone, written by Numba. control.frequency_response gives the two responses H_env and
H_perc, from which the ratios are one line of NumPy that is counted too.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from sympy import lambdify
from timing import machine, shortest

import haptisym as hs
from haptisym.kernel.rings import omega

RATIOS = ("ratio_real", "ratio_imag")
BYTES = 24


def by_hand(w: Any, block: int = 8192) -> Any:
    """What a person who knows the structured form and NumPy's cache would write."""
    m, b, k, omega_n, zeta = 1.8, 15.0, 100.0, 80.0, 0.5
    out, rows = np.empty((2, w.size)), np.empty((10, block))
    for start in range(0, w.size, block):
        given = w[start : start + block]
        n = given.size
        x, q, t, den, P, Q, R, X, size, y = (row[:n] for row in rows)
        np.multiply(given, 1 / omega_n, x), np.multiply(x, x, q), np.multiply(x, 2 * zeta, t)
        np.subtract(1, q, den), np.multiply(den, den, den), np.multiply(t, t, y), np.add(den, y, den)
        (
            np.subtract((1 - 2 * zeta) * (1 + 2 * zeta), q, P),
            np.multiply(P, q, P),
            np.divide(P, den, P),
            np.divide(t, den, Q),
        )
        np.multiply(given, given, R), np.multiply(R, -m, R), np.add(R, k, R), np.multiply(given, b, X)
        np.multiply(R, R, size), np.multiply(X, X, y), np.add(size, y, size), np.sqrt(size, size)
        real, imag = out[:, start : start + n]
        np.multiply(R, P, y), np.multiply(X, Q, t), np.add(y, t, y), np.divide(y, size, y), np.abs(y, real)
        np.multiply(X, P, y), np.multiply(R, Q, t), np.subtract(y, t, y), np.divide(y, size, y), np.abs(y, imag)
    return out


def plain_lambdify(distortion: Any) -> Callable[[Any], Any]:
    """The structured steps, all put in, as SymPy compiles them with its own common subexpressions."""
    steps = distortion.chain.steps
    shown = steps.at({})
    forms = [shown[name].subs(list(reversed(steps.definitions))) for name in RATIOS]
    return lambdify(omega, forms, "numpy", cse=True)


def by_control(w: Any) -> Any:
    import control

    felt = control.tf([1.8, 15, 100], [1])
    perceived = felt * control.tf([6400], [1, 80, 6400])
    H, G = (control.frequency_response(x, w).frdata[0, 0] for x in (felt, perceived))
    return abs((G - H).real) / abs(H), abs((G - H).imag) / abs(H)


def numba_contenders(distortion: Any, w: Any) -> dict[str, Callable[[], object]]:
    if find_spec("numba") is None:
        return {}
    import numba

    def stream(x: Any, first: Any, second: Any) -> None:
        for i in range(x.size):
            first[i] = x[i]
            second[i] = x[i]

    memory, out = numba.njit(stream), np.empty((2, w.size))
    f, rows = distortion.compile(of=RATIOS, engine="numba"), [*out]
    return {
        "memory: 1 read, 2 written": lambda: memory(w, out[0], out[1]),
        "numba, into given arrays": lambda: f.floats.run([w], w.size, rows),
        "numba": lambda: f(w),
    }


def speed(count: int) -> None:
    distortion = hs.load_scene("fu2019").distortion()
    w = np.geomspace(1e-2, 1e3, count)
    some = w[:: max(1, count // 20_000)].copy()
    fast, double, certified = (distortion.compile(x, RATIOS) for x in ("fast", "double-double", "certified"))
    plain, copied = plain_lambdify(distortion), np.empty(count)
    whole: dict[str, Callable[[], object]] = {
        "copy": lambda: np.copyto(copied, w),
        "by hand, NumPy in blocks": lambda: by_hand(w),
        "fast": lambda: fast(w),
        **numba_contenders(distortion, w),
        "lambdify, cse": lambda: plain(w),
    }
    if find_spec("control") is not None:
        whole["control.frequency_response"] = lambda: by_control(w)
    part = {"double-double": lambda: double(some), "certified": lambda: certified(some)}
    seconds = shortest({**whole, **part}, 4 if count > 1e5 else 60, 2 if count > 1e5 else 10)
    print(f"\nboth ratios of fu2019, {count:.0e} frequencies (the last two levels: {some.size})")
    print(f"  {'':<30} {'ns/point':>9} {'GB/s':>7} {'of hand-written':>16}")
    hand = seconds["by hand, NumPy in blocks"] / count
    for name, found in seconds.items():
        each = found / (some.size if name in part else count)
        size = 16 if name == "copy" else BYTES
        print(f"  {name:<30} {1e9 * each:9.2f} {size / each / 1e9:7.2f} {each / hand:16.2f}")


def openness(count: int) -> None:
    """What share of random points double-doubles leave to balls, and the price of proof."""
    print(
        f"\n{count} random points a scene, omega from 1e-9 to 1e9 rad/s: price in times of fast, share that needed balls"
    )
    print(f"  {'':<30} {'double-double':>14} {'certified':>10} {'balls':>9}")
    w = 10 ** np.random.default_rng(1).uniform(-9, 9, count)
    for name in hs.scene_names():
        levels = {
            x: hs.load_scene(name).distortion().compile(x, RATIOS) for x in ("fast", "double-double", "certified")
        }
        _, left = levels["certified"].certified.run([w], count)
        times = shortest({x: partial(f, w) for x, f in levels.items()}, 2, 3)
        double, certified = (times[x] / times["fast"] for x in ("double-double", "certified"))
        print(f"  {name:<30} {double:14.0f} {certified:10.0f} {100 * left / count:7.2f} %")


def main() -> None:
    """As many frequencies as a chart has, and as many as a sweep, or those that are named."""
    print(machine())
    for count in map(float, sys.argv[1:] or ("1e3", "1e6")):
        speed(int(count))
    openness(2000)


if __name__ == "__main__":
    main()
