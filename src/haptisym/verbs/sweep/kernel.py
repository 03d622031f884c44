"""The answers of a sweep for a batch of parameter sets: floats with bounds where they prove it, exact where they do not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.bernstein import MOST_DEGREE
from haptisym.verbs.sweep.curves import Curves, sweep_curves
from haptisym.verbs.sweep.exactly import exact_answers
from haptisym.verbs.sweep.hands import HandCurve, hand_curves, held
from haptisym.verbs.sweep.passes import Band, Columns, Pass
from haptisym.verbs.sweep.told import ABSENT, EXACT, UNKNOWN, Told
from haptisym.verbs.sweep.wavecurves import wave_curves
from haptisym.verbs.sweep.wavepass import WavePass
from haptisym.verbs.sweep.waves import WaveFamily

_AT_ONCE, _WAVES_AT_ONCE = 8192, 4096
"""Sets: so many that the work arrays stay in the processor's cache."""
_IS_WIDER = np.finfo(np.longdouble).nmant in (63, 112)
"""Whether NumPy's longdouble is a wider IEEE format, and neither a double by another name nor a pair of doubles."""


@dataclass(frozen=True)
class Kernel:
    """What a sweep computes, for any values of the swept parameters; can be sent to other processes."""

    scene: Scene
    swept: tuple[Knob, ...]
    curves: Curves | None
    band: Band
    hands: tuple[HandCurve | None, ...] = ()

    @classmethod
    def of(cls, scene: Scene, swept: Sequence[Knob]) -> Kernel:
        """Of a scene and the numbers that are swept: curves in floats where there are such, else the exact machinery alone."""
        curves = sweep_curves(scene, swept) or wave_curves(scene, swept)
        if curves is not None and _degree(curves) > MOST_DEGREE:
            curves = None
        band = Band.of(*scene.band, curves.step if curves else 1)
        return cls(replace(scene), tuple(swept), curves, band, hand_curves(scene, swept))

    @property
    def told(self) -> Told:
        """The variables."""
        return Told.of(self.scene)

    @property
    def is_polynomial(self) -> bool:
        """Whether sets may be answered in floats; if not, each is answered exactly."""
        return self.curves is not None

    @property
    def has_waves(self) -> bool:
        """Whether there are delays, holds or powers s^alpha: these need sines, which only doubles have with a bound."""
        return self.curves is not None and any(isinstance(f, WaveFamily) for p in self.curves.products for f in p)

    def answers(self, values: Array) -> Columns:
        """All variables, for values of the swept parameters in rows and sets in columns."""
        columns, left = self.in_floats(values)
        for i in left:
            for name, value in exact_answers(self.scene, self.swept, values[:, i].tolist()).items():
                columns[name][i] = value
        return self._in_hands(values, columns)

    def _in_hands(self, values: Array, columns: Columns) -> Columns:
        """With what is told of each hand; the method is that of what took most."""
        for name, counts, method in held(self.scene, self.swept, self.hands, values):
            columns[name] = counts
            columns["method"] = np.maximum(columns["method"], method)
        return columns

    def in_floats(self, values: Array) -> tuple[Columns, Array]:
        """The same as far as floats prove it, and the numbers of the sets that they leave open."""
        columns, left = _blank(self.told, values.shape[1]), np.arange(values.shape[1])
        if self.curves is not None:
            left = self._in_floats(values, columns, left)
            if _IS_WIDER and not self.has_waves:
                left = self._in_floats(values.astype(np.longdouble), columns, left)
        return columns, left

    def _in_floats(self, values: Array, columns: Columns, sets: Array) -> Array:
        """Answer those sets that floats of this kind can prove; the others are returned."""
        assert self.curves is not None
        rest = [sets[:0]]
        at_once, kind = (_WAVES_AT_ONCE, WavePass) if self.has_waves else (_AT_ONCE, Pass)
        for i in range(0, len(sets), at_once):
            some = sets[i : i + at_once]
            found, decided = kind(self.curves, self.band, values[:, some]).answers()
            for name, column in found.items():
                columns[name][some[decided]] = column[decided]
            rest.append(some[~decided])
        return np.concatenate(rest)


def _degree(curves: Curves) -> int:
    return max((sum(f.degree for f in families) for families in curves.products), default=0)


def _blank(told: Told, sets: int) -> Columns:
    floats = {name: np.full(sets, ABSENT) for name in told.floats}
    counts = {name: np.full(sets, UNKNOWN, dtype=np.int16) for name in told.counts}
    return {**floats, **counts, "method": np.full(sets, EXACT, dtype=np.int8)}
