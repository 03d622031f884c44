"""How are 10^6 parameter sets of a scene evaluated without 10^6 evaluations?

A *set* is one value for each parameter that is swept. For each set a sweep answers what an
evaluation does: crossings of the JND, bandwidth, transparent share of the band, changeovers (sign
changes of Re H_env and Re H_perc), and the roots in each hand. Three ways, tried in this order:

1. *Floats with bounds*, for thousands of sets at once (``passes.Pass``): all zeros of the functions
   that decide these answers (``curves``). A set whose answers the bounds do not prove is left.
   Floats are doubles, then wider ones where there are no waves.
2. *Exact arithmetic*, for one set that is left: the certified chart of an evaluation
   (``exactanswers``).
3. *No answer*, where that stays undecided or takes too long.

Roots in hands are counted likewise (``hands``). Values of parameters are taken as exactly the
binary numbers that the floats are. Guaranteed: counts and signs are proven, by whichever way, and a
frequency lies within ``passes.TOLERANCE`` of the true one.

*Waves* are delays, holds and powers s^alpha. Frequencies are in rad/s. Begin with
``SetEvaluator.of`` and ``SetEvaluator.answers``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptisym.model.scene import Knob, Scene
from haptisym.verbs.sweep.axes import ABSENT, EXACT, UNKNOWN, SweepVariables
from haptisym.verbs.sweep.batch import FLOAT_KINDS, Array
from haptisym.verbs.sweep.curves import Curves, curves_of
from haptisym.verbs.sweep.exactanswers import exact_answers
from haptisym.verbs.sweep.hands import HandCurve, hand_counts, hand_curves
from haptisym.verbs.sweep.passes import Band, Columns, Pass

_SETS_AT_ONCE = 4096
"""Sets of a pass: so many that the work arrays stay in the processor's cache."""


@dataclass(frozen=True)
class SetEvaluator:
    """Computes the variables of a sweep for any values of the swept parameters; can be sent to
    other processes.

    ``curves`` : the functions whose zeros are computed in floats; None where exact arithmetic alone
    is left. ``hands`` : of each hand of the scene, likewise.
    """

    scene: Scene
    swept: tuple[Knob, ...]
    curves: Curves | None
    band: Band
    hands: tuple[HandCurve | None, ...] = ()

    @classmethod
    def of(cls, scene: Scene, swept: Sequence[Knob]) -> SetEvaluator:
        """The evaluator of a scene and the numbers that are swept."""
        curves = curves_of(scene, swept)
        band = Band.of(*scene.band, curves.step if curves else 1)
        # A copy has none of the scene's cached closed forms, which would travel to other processes.
        return cls(replace(scene), tuple(swept), curves, band, hand_curves(scene, swept))

    @property
    def sweep_variables(self) -> SweepVariables:
        """The variables that are computed for each set."""
        return SweepVariables.of(self.scene)

    @property
    def has_waves(self) -> bool:
        """Whether there are delays, holds or powers s^alpha: these need sines, which only doubles
        have with a bound."""
        return self.curves is not None and self.curves.has_waves

    def answers(self, values: Array) -> Columns:
        """All variables, for values of the swept parameters in rows and sets in columns."""
        columns, left = self.in_floats(values)
        for i in left:
            set_values = values[:, i].tolist()
            row = exact_answers(self.scene, self.swept, set_values)
            for name, value in row.items():
                columns[name][i] = value
        return self._with_hands(values, columns)

    def in_floats(self, values: Array) -> tuple[Columns, Array]:
        """The variables but for hands, where floats prove them, and the indices of the sets that
        floats leave undecided."""
        count = values.shape[1]
        columns = _blank(self.sweep_variables, count)
        left = np.arange(count)
        # Doubles first, wider floats for what is left; with waves only doubles have a known error.
        for kind in FLOAT_KINDS if self.curves else ():
            if kind is np.float64 or not self.has_waves:
                left = self._in_floats(values.astype(kind), columns, left)
        return columns, left

    def _in_floats(self, values: Array, columns: Columns, sets: Array) -> Array:
        """Answer those sets that floats of this kind can prove, in ``columns``; return the indices
        of the others. ``sets`` : which are to be answered."""
        assert self.curves is not None
        left = [sets[:0]]
        for i in range(0, len(sets), _SETS_AT_ONCE):
            some = sets[i : i + _SETS_AT_ONCE]
            batch = Pass(self.curves, self.band, values[:, some])
            answers, decided = batch.answers()
            for name, column in answers.items():
                columns[name][some[decided]] = column[decided]
            left.append(some[~decided])
        return np.concatenate(left)

    def _with_hands(self, values: Array, columns: Columns) -> Columns:
        """The columns with the root counts in each hand. The method of a set is the slowest that
        any of its numbers took."""
        for name, counts, method in hand_counts(self.scene, self.swept, self.hands, values):
            columns[name] = counts
            columns["method"] = np.maximum(columns["method"], method)
        return columns


def _blank(variables: SweepVariables, sets: int) -> Columns:
    """Columns of sets without an answer, for exact arithmetic to fill."""
    columns: Columns = {}
    for name in variables.floats:
        columns[name] = np.full(sets, ABSENT)
    for name in variables.counts:
        columns[name] = np.full(sets, UNKNOWN, dtype=np.int16)
    columns["method"] = np.full(sets, EXACT, dtype=np.int8)
    return columns
