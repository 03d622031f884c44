"""The methods whose accuracy and time are compared: one table, each with what it needs and whether it proves its answer.

Ours are there beside the usual ones: floats of H_perc - H_env as they are written, transfer functions with expanded
coefficients, grids, eigenvalues of a companion matrix. ``prepare`` makes what a method may know beforehand (its formulas, its
coefficients); only what it returns is timed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np

from haptisym.verbs.cost.questions import DOUBLE, Attempt, Crossings, RatioQuestion
from haptisym.verbs.cost.usual import RefusedError, companion_way, control_way, grid_way, naive_way, scipy_way

_BOTH = ("ratio_real", "ratio_imag")

Prepare: TypeAlias = Callable[[Any], Attempt]


@dataclass(frozen=True)
class Method:
    """A way to an answer.

    ``proves`` : whether its answers are certified. ``ours`` : whether it is haptisym's. ``held`` : decimal digits that its
    numbers hold. ``packages`` : what must be installed. ``prepare`` takes the question and raises
    RefusedError where it does not fit. ``at_once`` : whether it answers for many frequencies at once, and should be timed so.
    """

    name: str
    prepare: Prepare
    proves: bool = False
    ours: bool = False
    held: float = DOUBLE
    packages: tuple[str, ...] = ()
    at_once: bool = True

    def ready(self, question: Any) -> Attempt:
        """The method, ready to answer the question."""
        for package in self.packages:
            try:
                import_module(package)
            except ImportError:
                raise RefusedError(f"{package.partition('.')[0]} is not installed") from None
        try:
            return self.prepare(question)
        except OverflowError:
            raise RefusedError("a coefficient is beyond the range of floats") from None


def _level(question: RatioQuestion, accuracy: str) -> Attempt:
    function, omega = question.distortion.compile(accuracy, of=_BOTH), np.array(question.omegas)
    return lambda: np.stack([(v := function(omega)).ratio_real, v.ratio_imag], axis=-1)


def _digits(question: RatioQuestion, count: int) -> Attempt:
    function, omega = question.distortion.compile(of=_BOTH), np.array(question.omegas)

    def attempt() -> list[tuple[str, str]]:
        found = function.digits(omega, count + 1)  # rounding takes up to one
        return [(str(x), str(y)) for x, y in zip(found.ratio_real, found.ratio_imag, strict=True)]

    return attempt


def _certified(question: Crossings, digits: int) -> Attempt:
    return lambda: question.certified(digits)


NAIVE = Method("H_perc - H_env in floats", naive_way)
RATIO_METHODS: Mapping[str, Method] = {
    x.name: x
    for x in (
        NAIVE,
        Method("python-control", control_way, packages=("control",)),
        Method("scipy.signal", scipy_way, packages=("scipy.signal",)),
        *(
            Method(x, partial(_level, accuracy=x), proves=x == "certified", ours=True)
            for x in ("fast", "double-double", "certified")
        ),
        *(
            Method(f"{n} digits", partial(_digits, count=n), proves=True, ours=True, held=n, at_once=False)
            for n in (30, 100, 300)
        ),
    )
}
"""Ways to the ratios at given frequencies."""

CROSSINGS: Mapping[str, Method] = {
    x.name: x
    for x in (
        *(Method(f"grid of 10^{n}", partial(grid_way, count=10**n)) for n in range(2, 7)),
        Method("grid of 10^4 + Brent", partial(grid_way, count=10**4, brent=True), packages=("scipy.optimize",)),
        Method("numpy.roots", companion_way),
        *(
            Method(f"certified, {n} digits", partial(_certified, digits=n), proves=True, ours=True, held=n)
            for n in (15, 50, 100, 300, 1000)
        ),
    )
}
"""Ways to the crossings on a band."""
