"""What certainty costs where there are delays, against the same questions put to mpmath's intervals, in one run.

    python benchmarks/delays.py

First the certified crossings of some delayed scenes. The contender does the same in mpmath.iv: it subdivides, with mean value
form, monotonicity, endpoint signs and interval Newton, on the same division-free equations. Then the whole evaluation of
every shipped scene with a delay, and the price of more digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy
from mpmath import iv
from timing import machine, medians, table

import haptisym as hs
from haptisym.judge.crossings import Criterion, PerceptFunction, find_crossings, noticed
from haptisym.kernel.budget import forget
from haptisym.kernel.roots import chart
from haptisym.model.distortion import part_of

Interval = Any  # mpmath's iv.mpf


def fresh(scene: hs.Scene) -> hs.Scene:
    """The scene with nothing derived yet."""
    forget()
    return hs.Scene(scene.environment, scene.effects, scene.band, scene.threshold, scene.rendered)


def questions(scene: hs.Scene) -> dict[object, object]:
    """What tells the crossings: where r^2 - c^2 vanishes, and the sign of dH."""
    d = scene.distortion()
    signs = {(PerceptFunction.DIFFERENCE, part): part_of(d.difference_response, part) for part in hs.Part}
    return {x: x.function(d) for x in noticed(scene.threshold)} | signs


def crossings(asked: dict[object, object], scene: hs.Scene) -> list[float]:
    """All crossings with sign, kind and multiplicity, caches empty."""
    forget()
    return sorted(float(c.omega) for c in find_crossings(chart(asked, *scene.band)))


def zeros_only(asked: dict[object, object], scene: hs.Scene) -> list[float]:
    """All frequencies at which r^2 - c^2 vanishes, each with its order, caches empty: what the contender is asked for, too."""
    forget()
    table_of_zeros = chart({key: f for key, f in asked.items() if isinstance(key, Criterion)}, *scene.band)
    return sorted(float(x.omega) for x in table_of_zeros.points if any(n > 0 for n in x.orders.values()))


Compiled = tuple[Callable[[Any], Any], Callable[[Any], Any]]


def compiled(asked: dict[object, object]) -> list[Compiled]:
    """The division-free threshold equations and their slopes as functions of an mpmath interval."""
    found = []
    for equation in (function.written for key, function in asked.items() if isinstance(key, Criterion)):
        f = equation.ring.expression(equation.numerator)
        found.append((on_intervals(f), on_intervals(f.diff(hs.omega))))
    return found


def by_intervals(equations: list[Compiled], scene: hs.Scene) -> list[float]:
    """The same crossings, without sign and kind, with mpmath's intervals of 53 bits."""
    iv.prec = 53
    low, high = (float(x) for x in scene.band)
    return sorted(x for value, slope in equations for x in zeros(value, slope, iv.mpf([low, high])))


def on_intervals(f: sympy.Expr) -> Callable[[Any], Any]:
    """A function of one interval; its fractions are intervals too, so that nothing is rounded silently."""
    fractions = [x for x in f.atoms(sympy.Rational) if not x.is_Integer]
    names = {x: sympy.Dummy() for x in fractions}
    run = sympy.lambdify([hs.omega, *names.values()], f.xreplace(names), [{"sin": iv.sin, "cos": iv.cos}], cse=True)
    return lambda x: run(x, *(iv.mpf(q.p) / q.q for q in fractions))


def zeros(value: Callable[[Any], Any], slope: Callable[[Any], Any], band: Interval) -> list[float]:
    """All zeros of a function on an interval whose ends are none, to the last bits of a float."""
    found, boxes = [], [band]
    while boxes:
        box = boxes.pop()
        steep = slope(box)
        bound = value(iv.mpf(box.mid)) + steep * (box - box.mid)
        if 0 not in bound or 0 not in value(box):
            continue
        if 0 in steep:
            boxes += [iv.mpf([box.a, box.mid]), iv.mpf([box.mid, box.b])]
        elif (value(iv.mpf(box.a)) * value(iv.mpf(box.b))).a < 0:
            found.append(newton(value, slope, box))
    return found


def newton(value: Callable[[Any], Any], slope: Callable[[Any], Any], box: Interval) -> float:
    """The zero of a monotone function in a box."""
    while True:
        step = iv.mpf(box.mid) - value(iv.mpf(box.mid)) / slope(box)
        closer = iv.mpf([max(step.a, box.a), min(step.b, box.b)])
        if closer.delta > box.delta / 2:
            return float(closer.mid)
        box = closer


def behind(*effects: hs.Effect) -> hs.Scene:
    """The environment of the paper's example behind other effects, on its band."""
    return hs.Scene(hs.load_scene("fu2019").environment, effects)


def versus(name: str, scene: hs.Scene) -> None:
    """Certified crossings of one scene, both ways; the equations are given to both."""
    asked = questions(scene)
    equations = compiled(asked)
    for found in (crossings(asked, scene), zeros_only(asked, scene)):
        assert all(abs(a - b) < 1e-9 for a, b in zip(found, by_intervals(equations, scene), strict=True))
    contenders = {
        "haptisym: certified crossings, equations given": lambda: zeros_only(asked, scene),
        "mpmath.iv: certified crossings, equations given": lambda: by_intervals(equations, scene),
        "haptisym: with kinds and the signs of dH": lambda: crossings(asked, scene),
        "haptisym: certified crossings, from the scene on": lambda: crossings(questions(fresh(scene)), scene),
    }
    table(f"{name}: {scene.band} rad/s", medians(contenders, 9), next(iter(contenders)))


def main() -> None:
    """Check that all find the same, then print the tables."""
    print(machine())
    delay = hs.effects.delay("5 ms")
    versus("delayed-spring", hs.load_scene("delayed-spring"))
    versus("fu2019's environment behind a lag and 5 ms", behind(hs.effects.first_order_lag("50 rad/s"), delay))
    versus("fu2019 with a delay of 5 ms", behind(*hs.load_scene("fu2019").effects, delay))
    versus("satellite-contact", hs.load_scene("satellite-contact"))
    delayed = [(name, hs.load_scene(name)) for name in hs.scene_names()]
    evaluations = {
        name: lambda scene=scene: hs.evaluate(fresh(scene)).percepts
        for name, scene in delayed
        if scene.distortion().env.ring.lags or scene.distortion().perc.ring.lags
    }
    table("Whole evaluations", medians(evaluations, 5), "delayed-spring")
    for name in ("delayed-spring", "position-force-teleoperation", "sampled-wall"):
        by_digits(name)


def by_digits(name: str) -> None:
    """What more digits of the crossings cost in a whole evaluation, output included."""
    scene = hs.load_scene(name)
    prices = {
        f"{bits:5d} bits: {count} digits of each crossing": lambda count=count: hs.evaluate(
            fresh(scene), digits=count
        ).to_json()
        for bits, count in ((53, 15), (200, 60), (1000, 300))
    }
    table(f"{name}, everything, with that many digits", medians(prices, 9), next(iter(prices)))


if __name__ == "__main__":
    main()
