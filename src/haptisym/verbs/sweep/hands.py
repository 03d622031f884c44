"""Held in a hand: how many roots H_perc + m s^2 + b s + k has in Re s >= 0, for many parameter sets at once.

In floats where the characteristic function is a polynomial in s, by Routh's array (``routh``). H_perc is in lowest terms for
symbols, but perhaps not for a set of values. A zero that both parts of the quotient then share is no root; there is none in
Re s >= 0 where the denominator is proven to have all its zeros in Re s < 0, those at 0 apart, which the array does not allow.
All other sets, and all with delays, powers of s or a clock, are counted exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from sympy import Integer, Rational

from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import HaptisymError, SceneError, UndecidedError
from haptisym.kernel.rings import Polynomial
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.knobs import Knob
from haptisym.model.parameters import values as values_of
from haptisym.model.scene import Scene
from haptisym.verbs.stability.held import characteristic, unstable_roots
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.exactly import LONGEST
from haptisym.verbs.sweep.families import Family, Powers, family, within_reach
from haptisym.verbs.sweep.routh import count_right
from haptisym.verbs.sweep.told import EXACT, FLOAT, INFINITE, OPEN, UNKNOWN, held_name


@dataclass(frozen=True)
class HandCurve:
    """The characteristic polynomial in s of a display in a hand, and the denominator of H_perc without its zeros at 0."""

    top: Family
    bottom: Family

    def count(self, values: Array) -> tuple[Array, Array]:
        """For each set the number of roots in Re s >= 0, and whether it is proven."""
        powers, decided = Powers(values), within_reach(values, [(self.top,), (self.bottom,)])
        counts, certain = count_right(self.top.at(powers))
        poles, proper = count_right(self.bottom.at(powers))
        return counts, decided & certain & proper & (poles == 0)


def hand_curves(scene: Scene, swept: Sequence[Knob]) -> tuple[HandCurve | None, ...]:
    """Of each hand of a scene; None where that is no polynomial."""
    return tuple(None if clocks(scene) else _curve(scene, hand, swept) for hand in scene.hands)


def _curve(scene: Scene, hand: Hand, swept: Sequence[Knob]) -> HandCurve | None:
    given = {x.symbol for x in swept}
    chain = scene.chain.at(values_of(p for p in scene.parameters if p.symbol not in given))
    Z = hand.dynamics.xreplace(values_of(p for p in hand.parameters if p.symbol not in given))
    try:
        ring = Ring.of([*chain.entries(), Z])
        perceived = chain.perceived(range(len(chain.matrices)), ring)
    except HaptisymError:
        return None
    top = characteristic(perceived, ring.convert(Z))
    if ring.functions or top.is_zero():
        return None
    bottom = perceived.denominator
    lowest = min(int(exponents[0]) for exponents in bottom.monoms())

    def of(p: Polynomial) -> Family:
        return family(ring, p, [x.symbol for x in swept], Integer(1), 1, Integer(1))

    return HandCurve(of(top), of(bottom / ring.variable**lowest))


def held(
    scene: Scene, swept: Sequence[Knob], curves: Sequence[HandCurve | None], values: Array
) -> Iterator[tuple[str, Array, Array]]:
    """For each hand of a scene the name of its variable, the numbers of roots, and by which method they were found."""
    for place, (hand, curve) in enumerate(zip(scene.hands, curves, strict=True)):
        counts, method = np.full(values.shape[1], UNKNOWN), np.full(values.shape[1], EXACT, dtype=np.int8)
        for wide in _KINDS if curve else ():
            assert curve
            left = np.flatnonzero(method == EXACT)
            found, proven = curve.count(values[:, left].astype(wide))
            counts[left[proven]], method[left[proven]] = found[proven], FLOAT
        for i in np.flatnonzero(method == EXACT):
            counts[i] = exact_count(scene, place, swept, values[:, i].tolist())
            method[i] = OPEN if counts[i] == UNKNOWN else EXACT
        yield held_name(scene, hand), counts, method


_KINDS = (np.float64, np.longdouble) if np.finfo(np.longdouble).nmant in (63, 112) else (np.float64,)


def exact_count(scene: Scene, place: int, swept: Sequence[Knob], values: Sequence[float]) -> int:
    """The same for one set, whose values are taken as exactly the binary numbers that the floats are."""
    given = {x.path: Rational(*Fraction(float(v)).as_integer_ratio()) for x, v in zip(swept, values, strict=True)}
    try:
        at = scene.with_values({x.path: given[x.path] for x in swept if not x.parts})
        with limited(LONGEST):
            found = unstable_roots(at, at.hands[place])
    except (SceneError, UndecidedError):
        return UNKNOWN
    return (INFINITE if found.chain else UNKNOWN) if found.number is None else found.number
