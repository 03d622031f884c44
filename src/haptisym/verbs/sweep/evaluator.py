"""How are 10^6 parameter sets of a scene evaluated without 10^6 evaluations?

A *set* is one value for each parameter that is swept. For each set a sweep answers what an
evaluation does: crossings of the JND, bandwidth, transparent share of the band, changeovers (sign
changes of Re H_env and Re H_perc), and the roots in each hand. Three ways, tried in this order:

1. *Floats with bounds*, for thousands of sets at once (``passes.Pass``): all zeros of the functions
   that decide these answers (``curves``). A set whose answers the bounds do not prove is left.
   Floats are doubles, then wider ones where there are no waves. Very many sets without waves go
   through machine code first, where Numba is installed (``compiled``).
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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

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
    ``many`` : whether there are so many sets that machine code is worth its compilation.
    """

    scene: Scene
    swept: tuple[Knob, ...]
    curves: Curves | None
    band: Band
    hands: tuple[HandCurve | None, ...] = ()
    many: bool = False

    @classmethod
    def of(cls, scene: Scene, swept: Sequence[Knob], *, many: bool = False) -> SetEvaluator:
        """The evaluator of a scene and the numbers that are swept."""
        curves = curves_of(scene, swept)
        band = Band.of(*scene.band, curves.step if curves else 1)
        # A copy has none of the scene's cached closed forms, which would travel to other processes.
        return cls(replace(scene), tuple(swept), curves, band, hand_curves(scene, swept), many)

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
        for each in self._passes:
            left = self._in_floats(each, values, columns, left)
        return columns, left

    @cached_property
    def _passes(self) -> list[Callable[[Array], Pass]]:
        """The kinds of passes, each for what the one before leaves."""
        if self.curves is None:
            return []
        if self.has_waves:
            # Only of doubles is the error of a sine known.
            return [partial(Pass, self.curves, self.band)]
        found: list[Callable[[Array], Pass]] = []
        if self.many:
            # Numba is an extra, each version of it takes some versions of NumPy alone, and it needs
            # a folder for what it has compiled: all of that is asked for by the import.
            try:
                from haptisym.verbs.sweep.compiled import compiled_passes
            except (ImportError, RuntimeError):
                pass
            else:
                found += compiled_passes(self.curves, self.band)
        # Passes in wider floats isolate zeros in another way. Of what pairs leave where values
        # range over many powers of ten they prove about half and more, in a third of the time of
        # exact arithmetic.
        kinds = FLOAT_KINDS[1:] if found else FLOAT_KINDS
        return [*found, *(partial(_in_kind, self.curves, self.band, kind) for kind in kinds)]

    def _in_floats(
        self, kind: Callable[[Array], Pass], values: Array, columns: Columns, sets: Array
    ) -> Array:
        """Answer those sets that passes of this kind can prove, in ``columns``; return the indices
        of the others. ``sets`` : which are to be answered."""
        left = [sets[:0]]
        for i in range(0, len(sets), _SETS_AT_ONCE):
            some = sets[i : i + _SETS_AT_ONCE]
            answers, decided = kind(values[:, some]).answers()
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


def _in_kind(curves: Curves, band: Band, kind: Any, values: Array) -> Pass:
    """A pass in floats of a kind."""
    return Pass(curves, band, values.astype(kind))


def _blank(variables: SweepVariables, sets: int) -> Columns:
    """Columns of sets without an answer, for exact arithmetic to fill."""
    columns: Columns = {}
    for name in variables.floats:
        columns[name] = np.full(sets, ABSENT)
    for name in variables.counts:
        columns[name] = np.full(sets, UNKNOWN, dtype=np.int16)
    columns["method"] = np.full(sets, EXACT, dtype=np.int8)
    return columns
