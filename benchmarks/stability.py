"""What a verdict in a hand costs, and what the usual ways get wrong, in one run.

    python benchmarks/stability.py         (needs the extra [bench] for python-control; without it its rows are left out)

Left out: MATLAB and Mathematica, which are not free software; Monte Carlo over hands, which proves nothing.
"""

from __future__ import annotations

import numpy as np
from timing import machine, medians, table

import haptisym as hs
from haptisym.kernel.budget import forget
from haptisym.model.scenefile import load_scene
from haptisym.verbs.stability.held import held, roots_in_hand

ARM = hs.hands["postural-arm"]
RATIONAL = ("fu2019", "sidestick", "helicopter-cyclic", "control-stick-in-detail", "zener-tissue")
DELAYED = ("delayed-spring", "position-force-teleoperation", "four-channel-teleoperation", "satellite-contact")
KNOWN = {name: load_scene(name).distortion().perc for name in (*RATIONAL, *DELAYED)}
SPRINGS = (190, 199.8, 199.9, 210, 5000, 50_000, 500_000)
"""N/m, 36 ms late, in that arm: stable up to 199.85210225871."""
ORDERS = (1, 2, 3, 5, 10)


def verdict(name: str) -> bool | None:
    """From the text of the scene on, with empty caches."""
    forget()
    return held(load_scene(name), ARM).stable


def counted(name: str) -> int | None:
    """The count alone, of a display whose H_perc is known, with empty caches."""
    forget()
    return roots_in_hand(KNOWN[name], ARM).number


def evaluated(name: str) -> int:
    """All that an evaluation answers, with empty caches."""
    forget()
    e = hs.evaluate(load_scene(name))
    return len(e.crossings) + len(e.percepts) + len(e.transparent)


def exact(spring: float) -> int | None:
    """The certified count of roots on the right, the delay as it is."""
    forget()
    scene = hs.Scene(hs.environments.mass_spring_damper(k=str(spring)), (hs.effects.delay("36 ms"),))
    return held(scene, ARM).unstable


def pade(spring: float, order: int) -> int:
    """Eigenvalues of the closed loop with a Pade approximant, in floats."""
    tau, up, down = 0.036, [1.0], [1.0]
    for i in range(1, order + 1):
        c = np.prod([(order - j) / ((2 * order - j) * (j + 1)) for j in range(i)])
        down.insert(0, c * tau**i)
        up.insert(0, c * (-tau) ** i)
    m, b, k = (float(p.value) for p in ARM.parameters)
    closed = np.polyadd(np.polymul([m, b, k], down), spring * np.array(up))
    return int((np.roots(closed).real > 0).sum())


def by_control(spring: float, order: int) -> int:
    """The same by python-control: ``pade``, ``feedback``, ``poles``."""
    import control

    m, b, k = (float(p.value) for p in ARM.parameters)
    loop = control.tf([1], [m, b, k]) * control.tf([spring], [1]) * control.tf(*control.pade(0.036, order))
    return int((control.feedback(loop, 1).poles().real > 0).sum())


def wrong(count: int | None, truth: int | None) -> str:
    """A count, marked where it is wrong."""
    return f"{count}" if count == truth else f"{count} WRONG"


def costs() -> None:
    """Ratios to an evaluation of the same scene, and milliseconds of delayed ones."""
    print("=== cost ===")
    for name in RATIONAL:
        own = {"evaluate": lambda n=name: evaluated(n), "held in the arm": lambda n=name: verdict(n)}
        table(name, medians(own, 9), "evaluate")
    own = {f"{name}, from its text on": lambda n=name: verdict(n) for name in DELAYED}
    own |= {f"{name}, the count": lambda n=name: counted(n) for name in DELAYED}
    table("with delays, held in the arm", medians(own, 9), f"{DELAYED[0]}, the count")


def counts() -> None:
    """How many roots each way finds on the right."""
    print("=== counts ===")
    print("roots on the right of a spring 36 ms late in a hand of 0.554 kg, 6.45 N s/m, 135 N/m")
    print(f"  {'N/m':>8} {'exact':>7}" + "".join(f"{f'Pade {n}':>10}" for n in ORDERS))
    for spring in SPRINGS:
        truth = exact(spring)
        print(f"  {spring:>8} {truth:>7}" + "".join(f"{wrong(pade(spring, n), truth):>10}" for n in ORDERS))
    try:
        rows = [(spring, [by_control(spring, n) for n in ORDERS]) for spring in SPRINGS]
    except ModuleNotFoundError:
        return
    print("python-control, pade, feedback and poles")
    for spring, row in rows:
        print(f"  {spring:>8} {exact(spring):>7}" + "".join(f"{wrong(x, exact(spring)):>10}" for x in row))
    ways = {
        "exact": lambda: exact(210),
        "Pade 5 and eigenvalues": lambda: pade(210, 5),
        "python-control, Pade 5": lambda: by_control(210, 5),
    }
    table("one verdict on a spring 36 ms late", medians(ways, 9), "exact")


def maps() -> None:
    """Maps of what is transparent and what is stable in the arm: as many slices as they need, and 41 even ones."""
    print("\n=== maps ===")
    asked = {
        "fu2019": (["omega_n", "zeta"], [(60, 200), ("0.1", 1)]),
        "delayed-spring": (["tau", "environment.k"], [("1 ms", "60 ms"), (10, 1000)]),
        "virtual-wall": (["environment.b", "environment.k"], [(0, 40), (10, 4000)]),
    }
    for name, (paths, ranges) in asked.items():
        for uniform in (False, True):

            def drawn() -> int:
                forget()
                both = ["transparent", "stable"]
                return len(hs.design_map(name, paths, ranges, that=both, hand=ARM, uniform=uniform).slices)  # noqa: B023

            ways = {"evaluate": lambda n=name: evaluated(n), "map": drawn}
            table(f"{name}, {drawn()} slices", medians(ways, 1), "evaluate")


def main() -> None:
    """Print costs, maps and counts."""
    print(machine())
    costs()
    maps()
    counts()


if __name__ == "__main__":
    main()
