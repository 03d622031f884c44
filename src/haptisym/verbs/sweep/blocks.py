"""A sweep as a grid of parameter sets, cut into blocks that are computed one by one and in any order."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from itertools import product
from math import ceil, prod
from time import monotonic
from typing import Any, TypeAlias

import numpy as np

from haptisym.model.jnd import Part
from haptisym.model.scene import Scene
from haptisym.verbs.sweep.axes import SweepAxis
from haptisym.verbs.sweep.bernstein import Array
from haptisym.verbs.sweep.passes import TOLERANCE, Kernel
from haptisym.verbs.sweep.told import Told

SETS_IN_A_BLOCK = 65_536
PATIENCE = 1.0
"""Seconds after which, as nearly as one can tell, what is computed is written down and told."""
Region: TypeAlias = tuple[slice, ...]


@dataclass
class Pace:
    """How many sets are computed at a time: as many as ``PATIENCE`` allows, told by those before; a single one at first."""

    sets: int = 1

    def took(self, seconds: float, sets: int) -> None:
        """Choose the next block by how long this one took."""
        wanted = sets * PATIENCE / max(seconds, 1e-6)
        self.sets = max(1, int(min(wanted, 8 * self.sets)))


def size(region: Region) -> int:
    """How many sets there are in a block."""
    return prod(part.stop - part.start for part in region)


def _cut(region: Region, most: int) -> tuple[Region, Region]:
    """The first sets of a block, not many more than so many where one axis can be cut so, and the rest."""
    axis = next(i for i, part in enumerate(region) if part.stop - part.start > 1)
    part = region[axis]
    behind = size(region[axis + 1 :])
    at = part.start + min(max(1, most // behind), part.stop - part.start - 1)
    halves = slice(part.start, at), slice(at, part.stop)
    first, rest = ((*region[:axis], half, *region[axis + 1 :]) for half in halves)
    return first, rest


@dataclass(frozen=True)
class SweepGrid:
    """All sets of a sweep: every combination of the values of its axes."""

    scene: Scene
    axes: tuple[SweepAxis, ...]
    block: tuple[int, ...]
    """How many values of each axis a block holds at most."""

    @classmethod
    def of(cls, scene: Scene, axes: Sequence[SweepAxis], sets: int = SETS_IN_A_BLOCK) -> SweepGrid:
        """With blocks of about that many sets, as long as possible along the last axes."""
        shape, left = [], sets
        for axis in reversed(axes):
            shape.append(max(1, min(len(axis.values), left)))
            left //= shape[-1]
        return cls(replace(scene), tuple(axes), tuple(reversed(shape)))

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def sets(self) -> int:
        """How many sets of values there are."""
        return prod(self.shape)

    @property
    def variables(self) -> dict[str, tuple[np.dtype[Any], dict[str, str]]]:
        """Name and kind of what is told of each set, with what it says of itself."""
        return Told.of(self.scene).variables

    @cached_property
    def kernel(self) -> Kernel:
        """What judges a set."""
        return Kernel.of(self.scene, [axis.knob for axis in self.axes])

    def regions(self) -> Iterator[Region]:
        """The blocks, in the order of the grid."""
        starts = [range(ceil(n / size)) for n, size in zip(self.shape, self.block, strict=True)]
        for index in product(*starts):
            yield tuple(
                slice(i * b, min((i + 1) * b, n)) for i, b, n in zip(index, self.block, self.shape, strict=True)
            )

    def pieces(self, region: Region, pace: Pace) -> Iterator[tuple[Region, tuple[Array, ...]]]:
        """All variables of a block, in pieces that take about a second each; the results do not depend on how it is cut."""
        waiting = [region]
        while waiting:
            piece = waiting.pop()
            while size(piece) > pace.sets:
                piece, rest = _cut(piece, pace.sets)
                waiting.append(rest)
            began = monotonic()
            answers = compute(self.kernel, np.ix_(*self.values(piece)))
            pace.took(monotonic() - began, size(piece))
            yield piece, answers

    def values(self, region: Region) -> list[Array]:
        """The values of each axis in a block."""
        return [axis.values[part] for axis, part in zip(self.axes, region, strict=True)]

    def attributes(self) -> dict[str, Any]:
        """What a data set says about itself."""
        return {
            "schema": "haptisym.sweep/1",
            "title": self.scene.title,
            "source": self.scene.source,
            "band": [self.kernel.band.high * self.kernel.band.low_fraction, self.kernel.band.high],
            **_threshold(self.scene),
            "relative_accuracy": TOLERANCE,
            "certified": (
                "All counts are proven. Values of the swept parameters are taken as exactly the binary numbers stored here."
            ),
            "floats": self._how,
            "fingerprint": self.fingerprint,
            **self._asides(),
        }

    @property
    def _how(self) -> str:
        if not self.kernel.is_polynomial:
            return _ALL_EXACT
        return f"{_IN_FLOATS}{_WITH_SINES}" if self.kernel.has_waves else _IN_FLOATS

    def _asides(self) -> dict[str, Any]:
        """What is nominal or has a double, as text, which every kind of file holds."""
        swept = [axis.path for axis in self.axes]
        notes = self.scene.asides(swept, swept)
        keys = self.scene.aside_keys(swept, swept)
        return {key: json.dumps(x) for key, x in keys.items()} | ({"notes": "\n".join(notes)} if notes else {})

    @cached_property
    def fingerprint(self) -> str:
        """A digest of everything that the results depend on."""
        scene = self.scene
        told = [
            [
                place,
                x.model,
                [[p.key, str(p.value)] for p in x.parameters if not self._is_swept(p.symbol)],
                str(x.dynamics),
            ]
            for place, x in scene.elements()
        ]
        c = scene.threshold
        swept = {part for axis in self.axes for part in axis.knob.parts}
        plain = ["" if part in swept else str(x) for part, x in ((Part.REAL, c.real), (Part.IMAG, c.imag))]
        limits = plain if c.is_plain else [json.dumps(c.row(), sort_keys=True)]
        hands = [[x.name, [str(p.value) for p in x.parameters if not self._is_swept(p.symbol)]] for x in scene.hands]
        parts = [
            told,
            *([hands] if hands else []),
            [str(x) for x in scene.band],
            limits,
            [axis.path for axis in self.axes],
            TOLERANCE,
        ]
        digest = sha256(json.dumps(parts).encode())
        for axis in self.axes:
            digest.update(np.ascontiguousarray(axis.values).tobytes())
        return digest.hexdigest()

    def _is_swept(self, symbol: object) -> bool:
        return any(axis.knob.symbol == symbol for axis in self.axes)


def _threshold(scene: Scene) -> dict[str, Any]:
    """Both limits; of what is more than two numbers the whole region, as text."""
    c = scene.threshold
    if c.is_plain:
        return {"threshold": [str(c.real), str(c.imag)]}
    return {"threshold": json.dumps(c.row())}


_IN_FLOATS = "method 0 where floats with an error bound prove the counts, exact arithmetic elsewhere"
_WITH_SINES = (
    "; the bound rests on sines, cosines, exponentials and logarithms within 4 units in the last place, as tested here"
)
_ALL_EXACT = "floats do not answer this scene with these parameters: every set is answered exactly"


def compute(kernel: Kernel, values: Sequence[Array]) -> tuple[Array, ...]:
    """All variables, in their order, of every combination of values in arrays that broadcast together."""
    together = np.broadcast_arrays(*values)
    columns = kernel.answers(np.stack([np.ravel(x) for x in together]))
    shape = together[0].shape
    return tuple(
        columns[name].reshape(shape).astype(dtype, copy=False) for name, (dtype, _) in kernel.told.variables.items()
    )
