"""Records in time in CSV files: columns t, position, force and, of a closed loop, the reference that drove it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.model.csvtable import Form, NumberTable, read_table
from haptisym.model.estimating import estimated
from haptisym.model.measured import Measurement
from haptisym.model.quantities import Dimension, MotionKind, quantity
from haptisym.model.welch import Estimator

COLUMNS = {
    "t": Dimension.TIME,
    "position": Dimension.DISPLACEMENT,
    "force": Dimension.FORCE,
    "reference": Dimension.ANY,
}
_OFF = 0.75
"""Of the spacing: how far a sample may stand from its even place, or a step be from the mean step; times are rounded in files."""


def read_record(path: Path, estimator: str, **settings: Any) -> Measurement:
    """The response of the records in a file; ``settings`` : as of ``estimated``. SceneError says what is wrong, and where."""
    try:
        table = read_table(path, _FORM)
        column = table.column
        joint = estimator.lower() == Estimator.JOINT.value
        if joint and "reference" not in column:
            raise SceneError("estimator: joint needs a column reference: the signal that drove the loop")
        taken = column["reference"] if joint else None
        found = estimated(
            column["position"], column["force"], _rate(table), estimator=estimator, reference=taken, name=path.name,
            motion=table.head.motion, **settings,
        )  # fmt: skip
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return replace(found, path=path)


def _checked(names: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        if name not in COLUMNS:
            raise SceneError(
                f"unknown column {quoted(name)}: {meant(name, COLUMNS)}of records are known {', '.join(COLUMNS)}"
            )
        if names.count(name) > 1:
            raise SceneError(f"column {name} is there twice")
    missing = [x for x in COLUMNS if x not in names and x != "reference"]
    if missing:
        raise SceneError(f"no column {missing[0]}: records in time have t, position and force")
    return tuple(names)


def _factor(column: str, unit: str) -> tuple[float, MotionKind | None]:
    if not unit or unit == "-" or column == "reference":
        return 1.0, None
    try:
        read = quantity(f"1 {unit}", COLUMNS[column])
    except SceneError as error:
        raise SceneError(f"{column}: {error}") from None
    return float(read.value), read.motion


_FORM = Form(("t",), _checked, _factor, "t,position,force")


def _rate(table: NumberTable) -> float:
    """Samples a second. SceneError where samples are not even."""
    t = table.column["t"]
    for key, row in table.column.items():
        if not np.isfinite(row).all():
            raise SceneError(f"{table.place(int(np.argmin(np.isfinite(row))))}: {key}: must be finite")
    if len(t) < 2 or t[-1] <= t[0]:
        raise SceneError("t: must rise from sample to sample")
    step = (t[-1] - t[0]) / (len(t) - 1)
    even = t[0] + step * np.arange(len(t))
    off = np.abs(t - even) > _OFF * step
    jumps = np.abs(np.diff(t) - step) > _OFF * step
    if jumps.any() or off.any():
        first = int(np.argmax(jumps)) + 1 if jumps.any() else int(np.argmax(off))
        told = f"{t[first]:.6g} s follows {t[first - 1]:.6g} s, and samples are {step:.4g} s apart"
        raise SceneError(f"{table.place(first)}: t: {told}: a gap, or not sampled evenly; resample the record first")
    return float(1 / step)
