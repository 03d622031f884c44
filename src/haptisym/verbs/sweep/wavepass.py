"""One batch of parameter sets of a scene with delays, holds or powers s^alpha, in floats: where its zeros come from."""

from __future__ import annotations

import numpy as np

from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.bernstein import Zeros
from haptisym.verbs.sweep.combined import Found
from haptisym.verbs.sweep.curves import Curves, FamilyProduct
from haptisym.verbs.sweep.families import Family
from haptisym.verbs.sweep.passes import NARROWER, TOLERANCE, Band, Pass
from haptisym.verbs.sweep.waves import Factor, WaveFamily, WaveFunction, isolate, refine


class WavePass(Pass):
    """One batch in doubles."""

    def __init__(self, curves: Curves, band: Band, values: Array) -> None:
        super().__init__(curves, band, values)
        self._factors: dict[WaveFamily, Factor] = {}

    def _product(self, families: FamilyProduct) -> WaveFunction:
        above = tuple(map(self._factor, families))
        variables = above[0].family.variables
        rates = [self.powers.monomial(x.exponents) * x.constant for x in variables.rates]
        return WaveFunction(variables, np.array(rates).reshape(-1, self.sets), above)

    def _factor(self, family: Family) -> Factor:
        assert isinstance(family, WaveFamily)
        if family not in self._factors:
            self._factors[family] = Factor(family, family.at(self.powers))
        return self._factors[family]

    def _all_zeros(self, p: WaveFunction) -> Zeros:
        if p.is_polynomial:
            return super()._all_zeros(p.polynomial)
        return isolate(p, self.band.edges(1, 1), first_is_doubt=self.band.doubtful)

    def _zeros(self, p: WaveFunction | None) -> Found:
        found = super()._zeros(p)
        # segments overlap by a unit in the last place, where a zero would be found twice
        close = np.diff(found.omega) < 4 * TOLERANCE * found.omega[1:]
        self.decided[found.sets[1:][close & (np.diff(found.sets) == 0)]] = False
        return found

    def _refined(self, p: WaveFunction, low: Array, high: Array) -> tuple[Array, Array]:
        return super()._refined(p.polynomial, low, high) if p.is_polynomial else refine(p, low, high, NARROWER)
