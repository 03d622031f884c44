"""A model with free parameters as a function of numbers: the response at all lines, for many sets of values at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from haptisym.model.distortion import distort
from haptisym.model.measured import Complexes, Reals
from haptisym.verbs.identify.wanted import Wanted


@dataclass(frozen=True, eq=False)
class Curve:
    """H_perc of what is wanted at frequencies, rad/s."""

    wanted: Wanted
    omega: Reals

    @cached_property
    def _compiled(self) -> Callable[..., Any]:
        own, effects = self.wanted.elements(lambda x: x.symbol)
        return distort(own, *effects).compile(of=["perceived_real", "perceived_imag"])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the free parameters, in their order."""
        return tuple(x.symbol.name for x in self.wanted.free)

    def __call__(self, values: Reals) -> Complexes:
        """Of sets of values (sets, parameters) the responses (sets, lines); NaN where there is none."""
        sets = np.atleast_2d(values)
        columns = {name: sets[:, i, None] for i, name in enumerate(self.names)}
        with np.errstate(all="ignore"):
            found = self._compiled(self.omega[None, :], **columns)
            H: Complexes = found.perceived_real + 1j * found.perceived_imag
        return np.broadcast_to(H, (len(sets), len(self.omega)))

    def at(self, values: Reals) -> Complexes:
        """Of one set of values."""
        found: Complexes = self(values)[0]
        return found

    def slopes(self, values: Reals, steps: Reals) -> Complexes:
        """Central differences, (lines, parameters)."""
        shifts = np.diag(steps)
        H = self(np.concatenate([values + shifts, values - shifts]))
        count = len(steps)
        found: Complexes = ((H[:count] - H[count:]) / (2 * steps[:, None])).T
        return found
