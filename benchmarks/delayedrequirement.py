"""Random requirements on scenes with delays, holds and powers of s: seconds, what stays undecided, and contradictions.

    python benchmarks/delayedrequirement.py [--count N] [--seed S] [--limit SECONDS] [--only K ...]

A scene is drawn with an environment, one to three effects, one of them at least with a delay or a hold, and a number of it that
is free. Each question is asked once, for all values that the model allows, in a process that has asked those before; seconds are
the processor's, while the limit is of time that passes. ``wrong``: of values beside each end and of random ones, at how many an
evaluation of the scene with that value contradicts the answer: the witness, which is not timed.
"""

from __future__ import annotations

import argparse
import math
import time
from collections import Counter
from collections.abc import Iterator
from random import Random

from sympy import Rational
from timing import machine

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.verbs.require.required import Requirement

BAND = (0.5, 2.3)
"""Powers of ten between which the band ends, rad/s."""


def number(draw: Random, low: float, high: float) -> str:
    """A number of two digits between those powers of ten."""
    return f"{10 ** draw.uniform(low, high):.1e}"


def environment(draw: Random) -> hs.Environment:
    """What should be felt."""
    m, b, k = number(draw, -1, 1), number(draw, -1, 2), number(draw, 1, 3.5)
    kind = draw.randrange(5)
    if kind == 0:
        return environments.mass_spring_damper(m, b, k)
    if kind == 1:
        return environments.kelvin_voigt(k, b)
    if kind == 2:
        return environments.maxwell(k, b)
    if kind == 3:
        return environments.zener(k, number(draw, 1, 3), b)
    return environments.spring_pot(number(draw, 1, 3), f"0.{draw.randint(1, 9)}", k=k)


def late(draw: Random) -> hs.Effect:
    """An effect with a delay."""
    tau, kind = number(draw, -3.5, -1), draw.randrange(6)
    if kind < 2:
        return effects.delay(tau)
    if kind == 2:
        return effects.zero_order_hold(tau)
    if kind == 3:
        return effects.wave_variables(number(draw, 0, 2), tau)
    if kind == 4:
        given = number(draw, -1, 0), number(draw, -1, 0), number(draw, 0, 2), number(draw, 1, 4)
        return effects.position_force_teleoperator(*given, tau)
    master = number(draw, -1, 0), number(draw, 0, 2), number(draw, 1, 2)
    slave = number(draw, -1, 1), number(draw, 0, 2), number(draw, 1, 2)
    return effects.four_channel_teleoperator(*master, *slave, tau)


def other(draw: Random) -> hs.Effect:
    """An effect without."""
    kind = draw.randrange(4)
    if kind == 0:
        return effects.first_order_lag(number(draw, 1, 3.5))
    if kind == 1:
        return effects.second_order_lowpass(number(draw, 1, 3.5), number(draw, -0.7, 0.2))
    if kind == 2:
        return effects.shunt(m=number(draw, -2.5, 0), b=number(draw, -1, 1))
    return effects.compliance(number(draw, 3, 5), number(draw, 0, 2))


def question(seed: int) -> tuple[hs.Scene, str]:
    """A scene and the path of what is free."""
    draw = Random(seed)
    chain = [late(draw), *(late(draw) if draw.randrange(5) == 0 else other(draw) for _ in range(draw.randint(0, 2)))]
    draw.shuffle(chain)
    felt, high = environment(draw), number(draw, *BAND)
    scene = hs.Scene(felt, tuple(chain), (0, high), hs.Threshold.of(draw.choice(["0.1", "0.2", "0.5", "1"])))
    paths = [p.path for p in scene.parameters if p.value is not None]
    return scene, draw.choice(paths)


def holds(found: Requirement, value: float) -> bool | None:
    """Whether a number lies in the set that was found; None where that stayed undecided."""
    for low, high in ((p.low, p.high) for p in found.undecided):
        if (low is None or float(low) <= value) and (high is None or value <= float(high)):
            return None
    spans = [(x.low, x.high) for x in found.feasible]
    return any((a is None or float(a) < value) and (b is None or value < float(b)) for a, b in spans)


def tried(found: Requirement, draw: Random) -> Iterator[Rational]:
    """Values beside each end, and some all over the decades."""
    ends = [float(x.value) for x in found.ends if x.value is not None]
    listed = [x * f for x in ends for f in (1 - 1e-6, 1 + 1e-6)]
    listed += [float(found.free.value) * 10 ** draw.uniform(-2, 2) for _ in range(3)]
    low, high = (None if x is None else float(x) for x in (found.domain.low, found.domain.high))
    yield from (Rational(x) for x in listed if (low is None or x > low) and (high is None or x < high))


def contradictions(scene: hs.Scene, found: Requirement, seed: int) -> int:
    """How many values an evaluation judges otherwise."""
    wrong = 0
    for value in tried(found, Random(seed)):
        said = holds(found, float(value))
        if said is None:
            continue
        try:
            e = hs.evaluate(found.free.put(scene, value))
        except (SceneError, UndecidedError):
            continue
        ends = e.chart.points[0], e.chart.points[-1]
        wrong += ([(x.low, x.high) for x in e.transparent] == [ends]) is not said
    return wrong


def main() -> None:
    """A line for each question that is slow, open or contradicted, and what they come to."""
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("--count", type=int, default=100)
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--limit", type=float, default=20.0)
    reader.add_argument("--only", type=int, nargs="*")
    asked = reader.parse_args()
    print(machine())
    taken, said = list[float](), Counter[str]()
    for seed in asked.only or range(asked.seed, asked.seed + asked.count):
        scene, path = question(seed)
        start = time.process_time()
        found = hs.require(scene, path, limit=asked.limit)
        taken.append(time.process_time() - start)
        wrong = contradictions(scene, found, seed)
        said.update({"undecided": bool(found.undecided), "wrong": wrong, "with an end": bool(found.ends)})
        if taken[-1] > 1 or found.undecided or wrong or asked.only:
            line = f"{seed:5d} {taken[-1]:7.2f} s  {path}: {told(scene)}: {found._line()}"
            print(f"{line}, {found.rows()['undecided']}, wrong {wrong}", flush=True)
    taken.sort()
    shares = {"half": 0.5, "90 %": 0.9, "95 %": 0.95, "99 %": 0.99, "all": 1}
    within = (f"{x} {taken[max(0, math.ceil(q * len(taken)) - 1)]:.2f} s" for x, q in shares.items())
    print(f"{len(taken)} questions: under 1 s {sum(x < 1 for x in taken)}; {', '.join(within)}")
    print(", ".join(f"{k} {v}" for k, v in said.items()))


def told(scene: hs.Scene) -> str:
    """The elements of a scene with their numbers."""
    listed = (scene.environment, *scene.effects)
    numbers = [", ".join(f"{p.key}={float(p.value):.3g}" for p in x.parameters) for x in listed]
    return " ".join(f"{x.model}({n})" for x, n in zip(listed, numbers, strict=True)) + f" to {float(scene.band[1]):.3g}"


if __name__ == "__main__":
    main()
