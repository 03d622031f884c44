"""How many roots in Re s >= 0 has a display in a hand, for many parameter sets at once?

The roots are those of H_perc + m s^2 + b s + k, of each hand that holds the display: in floats
where the characteristic function is a polynomial in s, by Routh's array (``batch.count_right``).
H_perc is in lowest terms for symbols, but perhaps not for a set of values. A zero that both parts
of the quotient then share is no root. There is none in Re s >= 0 where the denominator is proven to
have all its zeros in Re s < 0, but for those at 0, which are divided out, as the array allows none.
All other sets, and all that are sampled or have waves (delays, powers s^alpha), are counted exactly
(``exactanswers.exact_count``).

Begin with ``hand_curves``, which is for a scene, and ``hand_counts``, for sets.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from sympy import Integer

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import HaptisymError
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.verbs.sweep.axes import EXACT, FLOAT, OPEN, UNKNOWN, held_name
from haptisym.verbs.sweep.batch import FLOAT_KINDS, Array, Monomials, count_right, within_reach
from haptisym.verbs.sweep.curves import fixed_values
from haptisym.verbs.sweep.delayterms import Family
from haptisym.verbs.sweep.exactanswers import exact_count
from haptisym.verbs.sweep.familyreader import FamilyReader


@dataclass(frozen=True)
class HandCurve:
    """The characteristic polynomial in s of a display in a hand, and the denominator of H_perc
    without its zeros at 0, both as families in s."""

    characteristic: Family
    denominator: Family

    def count(self, values: Array) -> tuple[Array, Array]:
        """For each set the number of roots in Re s >= 0, and whether it is proven. ``values`` : of
        the parameters in rows, sets in columns."""
        powers = Monomials(values)
        families = [(self.characteristic.terms,), (self.denominator.terms,)]
        is_within_reach = within_reach(values, families)
        # A zero that both parts share for these values is no root. It cannot be one in Re s >= 0
        # where the denominator is proven to have none there: else the set is counted exactly.
        counts, is_counted = count_right(self.characteristic.polynomial(powers))
        poles, are_poles_counted = count_right(self.denominator.polynomial(powers))
        return counts, is_within_reach & is_counted & are_poles_counted & (poles == 0)


def hand_curves(scene: Scene, swept: Sequence[Knob]) -> tuple[HandCurve | None, ...]:
    """The characteristic polynomial for each hand of a scene; None for one that is no polynomial in
    s, as of sampled or delayed displays."""
    if clocks(scene):
        return (None,) * len(scene.hands)
    return tuple(_curve(scene, hand, swept) for hand in scene.hands)


def _curve(scene: Scene, hand: Hand, swept: Sequence[Knob]) -> HandCurve | None:
    """The characteristic polynomial of a display in one hand; None where it is no polynomial, or 0
    everywhere."""
    from haptisym.verbs.stability.held import characteristic

    chain = scene.chain.at(fixed_values(scene.parameters, swept))
    Z = hand.dynamics.xreplace(fixed_values(hand.parameters, swept))
    try:
        ring = Ring.of([*chain.entries(), Z])
        perceived = chain.perceived(range(len(chain.matrices)), ring)
    except HaptisymError:
        return None
    polynomial = characteristic(perceived, ring.convert(Z))
    if ring.functions or polynomial.is_zero():
        return None
    denominator = perceived.denominator
    # Zeros at s = 0 lie on the axis, where Routh's array counts nothing: of those that numerator
    # and denominator share, being no roots, exact arithmetic decides.
    lowest = min(int(exponents[0]) for exponents in denominator.monoms())
    reader = FamilyReader([x.symbol for x in swept], Integer(1))
    without_0 = reader.family(ring, denominator / ring.variable**lowest)
    return HandCurve(reader.family(ring, polynomial), without_0)


def hand_counts(
    scene: Scene, swept: Sequence[Knob], curves: Sequence[HandCurve | None], values: Array
) -> Iterator[tuple[str, Array, Array]]:
    """For each hand of a scene the name of its variable, and for each set the number of roots in Re
    s >= 0 and the method by which it was found: OPEN where it is UNKNOWN."""
    for index, (hand, curve) in enumerate(zip(scene.hands, curves, strict=True)):
        # EXACT also marks sets that are not counted yet.
        counts = np.full(values.shape[1], UNKNOWN)
        method = np.full(values.shape[1], EXACT, dtype=np.int8)
        for kind in FLOAT_KINDS if curve else ():
            assert curve
            left = np.flatnonzero(method == EXACT)
            some = values[:, left].astype(kind)
            numbers, is_proven = curve.count(some)
            proven = left[is_proven]
            counts[proven], method[proven] = numbers[is_proven], FLOAT
        for i in np.flatnonzero(method == EXACT):
            set_values = values[:, i].tolist()
            counts[i] = exact_count(scene, index, swept, set_values)
            if counts[i] == UNKNOWN:
                method[i] = OPEN
        yield held_name(scene, hand), counts, method
