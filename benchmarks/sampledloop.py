"""What a verdict on a loop with a clock costs, and what the usual ways get wrong, in one run.

    python benchmarks/sampledloop.py       (needs SciPy)

Each usual way counts unstable eigenvalues in floats: of the sampled matrix (SciPy's cont2discrete), of a continuous loop in which
delay and hold, T (d + 1/2), are a Pade approximant of order 3, and of one that leaves the clock out.
Left out: MATLAB's c2d, which is not free software; simulation in time, which proves nothing.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import cont2discrete
from timing import machine, medians, table

import haptisym as hs
from haptisym.judge.colgate import sampled_passivity
from haptisym.kernel.budget import forget
from haptisym.verbs.stability.held import held

FREE, GRIP = hs.Hand("let go"), hs.Hand("grip", b=8, k=400)
M, B = "0.04", "0.8"
CASES = {  # what is known: the stiffness up to which a wall is stable; T (s), d, the virtual damping, the hand
    "let go": (1605.35113477512, "0.001", 0, "0", FREE),
    "one sample late": (536.278559788946, "0.001", 1, "0", FREE),
    "T = 5 ms": (325.422809758905, "0.005", 0, "0", FREE),
    "in a hand, T = 5 ms": (4387.83474049539, "0.005", 0, "0", GRIP),
    "virtual damping 0.4": (2384.3034697805, "0.001", 0, "0.4", FREE),
}
OFF = (-1e-2, -1e-6, -1e-12, 1e-12, 1e-6, 1e-2)
"""How far from that stiffness, relatively, a verdict is asked for."""


def scene(case: str, off: float) -> hs.Scene:
    K, T, d, damping, _ = CASES[case]
    wall = hs.environments.expression("k + b*s", parameters={"k": repr(K * (1 + off)), "b": damping})
    loop = hs.effects.sampled_loop(f"{T} s", "backward-difference", d)
    return hs.Scene(wall, (loop, hs.effects.shunt(m=M, b=B)))


def exact(case: str, off: float) -> int | None:
    """The certified count of roots with |z| >= 1, with empty caches."""
    forget()
    return held(scene(case, off), CASES[case][4]).unstable


def sampled_matrix(case: str, off: float) -> int:
    """Eigenvalues of the matrix from one sample to the next, in floats."""
    K, T, d, damping, hand = CASES[case]
    K, step, virtual = K * (1 + off), float(T), float(damping)
    m, b, k = (float(p.value) + x for p, x in zip(hand.parameters, (float(M), float(B), 0), strict=True))
    plant = np.array([[0, 1], [-k / m, -b / m]]), np.array([[0], [1 / m]]), np.eye(2), np.zeros((2, 1))
    A, G, *_ = cont2discrete(plant, step, "zoh")
    size = 3 + d  # position, speed, the position before, forces on their way
    loop = np.zeros((size, size))
    force = np.zeros(size)
    force[0], force[2] = -(K + virtual / step), virtual / step
    loop[:2, :2] = A
    loop[:2] += np.outer(G[:, 0], force if d == 0 else np.eye(size)[size - 1])
    loop[2, 0] = 1
    if d:
        loop[3] = force
        for i in range(4, size):
            loop[i, i - 1] = 1
    return int((np.abs(np.linalg.eigvals(loop)) >= 1).sum())


def continuous(case: str, off: float, order: int) -> int:
    """Eigenvalues of a continuous loop with a Pade approximant of that order for delay and hold; order 0 leaves both out."""
    K, T, d, damping, hand = CASES[case]
    tau, up, down = float(T) * (d + 0.5), [1.0], [1.0]
    for i in range(1, order + 1):
        c = np.prod([(order - j) / ((2 * order - j) * (j + 1)) for j in range(i)])
        down.insert(0, c * tau**i)
        up.insert(0, c * (-tau) ** i)
    m, b, k = (float(p.value) + x for p, x in zip(hand.parameters, (float(M), float(B), 0), strict=True))
    wall = [float(damping), K * (1 + off)]
    closed = np.polyadd(np.polymul([m, b, k], down), np.polymul(wall, up))
    return int((np.roots(closed).real >= 0).sum())


WAYS = {
    "SciPy": sampled_matrix,
    "Pade 3": lambda case, off: continuous(case, off, 3),
    "no clock": lambda case, off: continuous(case, off, 0),
}


def wrong(count: int, truth: int | None) -> str:
    return f"{count}" if count == truth else f"{count} WRONG"


def costs() -> None:
    """A verdict from the scene on, with empty caches."""
    print("=== cost ===")
    own = {f"exact: {case}": lambda case=case: exact(case, -1e-2) for case in CASES}
    own["SciPy: one sample late"] = lambda: sampled_matrix("one sample late", -1e-2)
    own["Colgate and Schenkel's condition: one sample late"] = lambda: sampled_passivity(scene("one sample late", 0))
    table("one verdict", medians(own, 21), "exact: let go")


def counts() -> None:
    """How many roots each way finds on or outside the circle."""
    print("=== counts ===")
    print("unstable roots of a wall that is K (1 + off) stiff, K its exact limit")
    print(f"  {'':<22} {'off':>8} {'exact':>6}" + "".join(f"{name:>10}" for name in WAYS))
    for case in CASES:
        for off in OFF:
            truth = exact(case, off)
            print(
                f"  {case:<22} {off:>8.0e} {truth:>6}"
                + "".join(f"{wrong(f(case, off), truth):>10}" for f in WAYS.values())
            )
    free = hs.Scene(hs.environments.mass_spring_damper(b=3), scene("one sample late", 0).effects)
    print(f"  a damper alone, one root exactly at 1: exact {held(free, FREE).unstable}")


def main() -> None:
    """Print costs and counts."""
    print(machine())
    costs()
    counts()


if __name__ == "__main__":
    main()
