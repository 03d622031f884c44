"""What do floats prove of a sweep's answers, for one batch of parameter sets?

A *set* has one value for each swept parameter. For each set all answers follow from the signs on
the band of a few real functions of omega: the *excess* r^2 - c^2 of each criterion, positive where
the ratio r of the distortion exceeds its threshold c, and Re H_env and Re H_perc, whose signs
change at *changeovers*. A continuous function changes its sign at zeros alone (intermediate value
theorem). So three steps prove an answer for many sets at once:

1. ``delayterms.isolate`` encloses all zeros of a function on the band, each alone in its enclosure,
   or leaves a set undecided.
2. ``delayterms.refine`` makes enclosures as small as ``TOLERANCE``.
3. The zeros of each set are put in order (``signchanges``). Crossings, bandwidth, transparent share
   and changeovers are read off the signs in between.

With the answers comes, for each set, whether they are proven; a set for which they are not is left
to exact arithmetic (``exactanswers``).

Begin with ``Pass.answers``. Functions come as ``Curves``: a *family* is one polynomial whose
coefficients depend on the parameters, a product of some is a function, and a *lattice* the maximum
of minima of functions, as a JND region has. Frequencies are in rad/s unless they are said to be
fractions of the band's high end; x = (omega/(high end))^step is the variable of the curves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from sympy import Expr

from haptisym.kernel.reals import ExactNumber, bounds
from haptisym.verbs.sweep.axes import ABSENT, FLOAT, SYSTEMS
from haptisym.verbs.sweep.batch import MOST_EXPONENT, Array, Monomials, within_reach
from haptisym.verbs.sweep.curves import Curves, Excess, FamilyProduct, ThresholdPolynomial
from haptisym.verbs.sweep.delayterms import Family, FamilyFactor, Function, Zeros, isolate, refine
from haptisym.verbs.sweep.signchanges import SignChanges, lattice_changes, transparent_share

TOLERANCE = 1e-10
"""Relative: every frequency that is answered is proven to lie this close to the true one."""
VARIABLE_TOLERANCE = 0.95 * TOLERANCE
"""The same for x = (omega/scale)^step, step 1 or 2: the rest is for taking the root and scaling
back."""
_CLOSE = 4 * TOLERANCE
"""Relative: two computed frequencies, each within the tolerance, that are this close may be in
either order, or one."""

Columns: TypeAlias = dict[str, Array]
"""By the name of a variable its values, one for each set."""


@dataclass(frozen=True)
class Band:
    """A frequency band in the variable of the curves, (omega/high)^step, in which it ends at 1.

    ``high``: rad/s. ``low_fraction``: low end over high end. ``ends``: the low end in the variable,
    or two floats about it.

    ``doubtful``: whether the exact low end is no double: it then lies in the first segment, between
    the two ``ends``.
    """

    high: float
    low_fraction: float
    ends: tuple[float, ...]
    doubtful: bool

    @classmethod
    def of(cls, low: Expr, high: Expr, step: int) -> Band:
        """The band as the unit interval; ends rounded outwards."""
        exact = ExactNumber((low / high) ** step)
        lower, upper = bounds(exact.tight_ball(200))
        first, last = _float_below(lower), -_float_below(-upper)
        ends = (first,) if first == last else (first, last)
        low_fraction = float(ExactNumber(low / high))
        return cls(float(ExactNumber(high)), low_fraction, ends, doubtful=len(ends) > 1)


def _float_below(x: Fraction) -> float:
    """The largest float that is not above a number."""
    nearest = float(x)
    if Fraction(nearest) <= x:
        return nearest
    return float(np.nextafter(nearest, -np.inf))


class Pass:
    """The answers for one batch of parameter sets, in floats of one kind, for one call of
    ``answers``.

    ``decided``: for each set, whether all that is computed of it is proven so far.
    """

    most_exponent = MOST_EXPONENT

    def __init__(self, curves: Curves, band: Band, values: Array) -> None:
        """``values`` : of the parameters in rows, sets in columns."""
        self.curves, self.band = curves, band
        self.sets = values.shape[1]
        self.powers = Monomials(values)
        products = (product for function in curves.functions for product in function)
        terms = ([f.terms for f in product] for product in products if product)
        self.decided = within_reach(values, terms, self.most_exponent)
        self._factors: dict[Family, FamilyFactor] = {}

    def answers(self) -> tuple[Columns, Array]:
        """The columns of all answers but those for hands, and for which sets all of them are
        proven; the answers of another set mean nothing."""
        # What is not finite has no sign, so that the set is not decided.
        with np.errstate(all="ignore"):
            self._need_nonzero(self.curves.nonzero)
            crossings = dict[str, SignChanges]()
            for name, excess in self.curves.excess.items():
                crossings[name] = self._crossings(excess)
            changeover_changes = [
                self._no_changes(-1) if x is None else self._sign_changes(x)
                for x in self.curves.changeovers
            ]
        columns: Columns = {"method": np.full(self.sets, FLOAT, dtype=np.int8)}
        for name, changes in crossings.items():
            count, first = self._count_and_first(changes)
            columns[f"crossings_{name}"] = count
            columns[f"first_crossing_{name}"] = first
        for name, changes in zip(SYSTEMS, changeover_changes, strict=True):
            count, first = self._count_and_first(changes)
            columns[f"changeovers_{name}"] = count
            columns[f"changeover_{name}"] = first
        return columns | self._transparency(crossings, columns), self.decided

    def _function(self, above: FamilyProduct, below: FamilyProduct) -> Function:
        """The product of some families minus that of others, which may be none."""
        return self._at(above) - self._at(below) if below else self._at(above)

    def _at(self, families: FamilyProduct) -> Function:
        """The product of some families, with coefficients and rates for each set."""
        for f in families:
            if f not in self._factors:
                self._factors[f] = FamilyFactor(f, f.at(self.powers))
        variables = families[0].variables
        rates = [self.powers.monomial(x.exponents) * x.constant for x in variables.rates]
        rows = np.array(rates).reshape(-1, self.sets)
        return Function(variables, rows, tuple(self._factors[f] for f in families))

    def _need_nonzero(self, families: Sequence[Family]) -> None:
        """Leave those sets undecided for which one of these functions has a zero on the band:
        denominators, and factors at whose zeros no sign changes (``Curves.nonzero``)."""
        for f in families:
            self.decided[self._sets_with_zero(f)] = False

    def _sets_with_zero(self, f: Family) -> Array:
        """The sets for which a function has a zero on the band; some may be there several times."""
        sets: Array = self._isolated(self._at((f,))).sets
        return sets

    def _crossings(self, excess: Excess | None) -> SignChanges:
        """The sign changes of a criterion's excess; None stands for one that is negative
        everywhere."""
        if excess is None:
            return self._no_changes(-1)
        if isinstance(excess, ThresholdPolynomial):
            return self._sign_changes(excess.above, excess.below)
        changes = {f: self._sign_changes((f,)) for f in excess.factors}
        if not changes:
            return self._no_changes(excess.sign)
        crossings, decided = lattice_changes(excess, changes, self.band.low_fraction, _CLOSE)
        self.decided &= decided
        return crossings

    def _isolated(self, f: Function) -> Zeros:
        """The zeros of a function on the band, each alone in its enclosure."""
        edges = (*self.band.ends, 1.0)
        zeros = isolate(f, edges, first_is_doubt=self.band.doubtful)
        self.decided &= zeros.decided
        return zeros

    def _sign_changes(self, above: FamilyProduct, below: FamilyProduct = ()) -> SignChanges:
        """The zeros of a function, all simple, to the promised accuracy."""
        f = self._function(above, below)
        isolated = self._isolated(f)
        x, is_refined = refine(f.of(isolated.sets), isolated.low, isolated.high, VARIABLE_TOLERANCE)
        self.decided[isolated.sets[~is_refined]] = False
        return self._changes(isolated.sets, x, isolated.first)

    def _changes(self, sets: Array, x: Array, first: Array) -> SignChanges:
        """The sign changes of a function from all its zeros x, ascending for each set."""
        root = np.sqrt(x) if self.curves.step == 2 else x
        fractions = root.astype(float)
        # Segments overlap by a unit in the last place, where a zero would be found twice.
        is_close = np.diff(fractions) < _CLOSE * fractions[1:]
        is_same_set = np.diff(sets) == 0
        self.decided[sets[1:][is_close & is_same_set]] = False
        return SignChanges(sets, fractions, first)

    def _no_changes(self, sign: int) -> SignChanges:
        """Those of a function that has one sign on the whole band for all sets, as r^2 - c^2 for
        r = 0, which is negative."""
        no_sets, no_frequencies = np.zeros(0, dtype=int), np.zeros(0)
        return SignChanges(no_sets, no_frequencies, np.full(self.sets, sign))

    def _count_and_first(self, changes: SignChanges) -> tuple[Array, Array]:
        """For each set the number of sign changes and the first one, rad/s."""
        is_first = np.ones(len(changes.sets), dtype=bool)
        is_first[1:] = changes.sets[1:] != changes.sets[:-1]
        omega = changes.omega[is_first] * self.band.high
        first = np.full(self.sets, ABSENT)
        first[changes.sets[is_first]] = omega
        return np.bincount(changes.sets, minlength=self.sets), first

    def _transparency(self, crossings: Mapping[str, SignChanges], columns: Columns) -> Columns:
        """Bandwidth, rad/s, and transparent share of the band: a criterion that is positive at the
        low end leaves no bandwidth; else it ends at the first crossing of any, or with the band."""
        excesses = list(crossings.values())
        is_transparent_at_low = np.logical_and.reduce([x.first < 0 for x in excesses])
        # fmin passes over sets without a crossing, whose first one is nan.
        ends = np.full(self.sets, self.band.high)
        for name in crossings:
            ends = np.fmin(ends, columns[f"first_crossing_{name}"])
        return {
            "bandwidth": np.where(is_transparent_at_low, ends, ABSENT),
            "transparent": transparent_share(excesses, self.band.low_fraction),
        }
