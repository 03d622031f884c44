"""What an exact requirement costs, against one discriminant of SymPy, in one run.

    python benchmarks/requirement.py

The paper's mass, damper and spring behind one, two and three second-order low-passes (device orders 2, 4 and 6), the first one's
natural frequency free, the others' fixed. The whole answer, both parts, all values, proven, is timed beside SymPy's
``discriminant`` in omega^2 of the same threshold polynomial (of the imaginary part): one of the several steps of the answer.
"""

from __future__ import annotations

import sympy
from timing import machine, medians

import haptisym as hs
from haptisym.judge.crossings import noticed
from haptisym.kernel.rings import omega
from haptisym.verbs.require.freeparameter import conditions

FILTERS = (("80", "0.5"), ("800", "0.5"), ("1200", "0.5"))


def cascade(count: int) -> hs.Scene:
    """The paper's example behind that many filters."""
    paper = hs.load_scene("fu2019")
    filters = (hs.effects.second_order_lowpass(*given, name=f"filter{i}") for i, given in enumerate(FILTERS[:count], 1))
    return hs.Scene(paper.environment, tuple(filters), paper.band, paper.threshold)


def threshold_polynomial(scene: hs.Scene) -> sympy.Poly:
    """The polynomial in omega^2 and the free parameter that is positive where r_i > c."""
    free = scene.knobs["effects.filter1.omega_n"]
    [condition] = conditions(scene, [free], [x for x in noticed(scene.threshold) if x.name == "imag"]).values()
    expression = condition.axis.expression(condition.function.numerator).expand()
    W = sympy.Symbol("W", positive=True)
    return sympy.Poly(expression.subs(omega, sympy.sqrt(W)), W, free.symbol)


def main() -> None:
    """Print one table."""
    print(machine())
    print("\norder    require       SymPy discriminant of one polynomial    ratio    end")
    for count in (1, 2, 3):
        scene, polynomial = cascade(count), threshold_polynomial(cascade(count))
        contenders = {
            "require": lambda scene=scene: hs.require(scene, "effects.filter1.omega_n"),
            "sympy": polynomial.discriminant,
        }
        found = medians(contenders, {1: 9, 2: 5, 3: 1}[count])
        [span] = hs.require(scene, "effects.filter1.omega_n").feasible or [None]
        end = "none" if span is None else span.low.digits(12)
        print(
            f"{2 * count:5d} {1000 * found['require']:9.1f} ms {1000 * found['sympy']:20.1f} ms"
            f" {found['sympy'] / found['require']:24.2f}    {end}"
        )


if __name__ == "__main__":
    main()
