"""Measured frequency responses in CSV files: what their columns mean."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.model.csvtable import Form, NumberTable, read_table
from haptisym.model.measured import CONFIDENCE, Measurement, check_certainty, check_lines
from haptisym.model.quantities import Dimension, MotionKind, quantity

COLUMNS = ("omega", "frequency_hz", "real", "imag", "magnitude", "phase_deg", "coherence", "radius")
_STIFF = ("real", "imag", "magnitude", "radius")
_PLAIN_UNITS = {
    "omega": {"rad/s": 1.0, "1/s": 1.0},
    "frequency_hz": {"Hz": 1.0, "kHz": 1000.0},
    "phase_deg": {"deg": 1.0, "°": 1.0, "degree": 1.0, "degrees": 1.0},
    "coherence": {"1": 1.0, "-": 1.0},
}


def read_measurement(path: Path, averages: float | None = None, confidence: float = CONFIDENCE) -> Measurement:
    """The response in a file; SceneError says what is wrong with it, and in which line."""
    try:
        table = read_table(path, _FORM)
        check_certainty("coherence" in table.column, "radius" in table.column, averages, confidence)
        return _measurement(table, averages, confidence)
    except SceneError as error:
        raise error.within(path.name or str(path)) from None


def _checked(names: Sequence[str]) -> tuple[str, ...]:
    if "t" in names:
        raise SceneError(
            'column "t": a record in time, not lines of a response: say how that is estimated, as --estimator H1 --segment '
            '"4 s", or with these as keys of [perceived]; H1, H2 and joint there are'
        )
    for name in names:
        if name not in COLUMNS:
            raise SceneError(f"unknown column {quoted(name)}: {meant(name, COLUMNS)}known are {', '.join(COLUMNS)}")
        if names.count(name) > 1:
            raise SceneError(f"column {name} is there twice")
    frequencies = [x for x in ("omega", "frequency_hz") if x in names]
    if len(frequencies) != 1:
        raise SceneError(
            f"{'two columns' if frequencies else 'no column'} of frequencies: give one, omega (rad/s) or frequency_hz"
        )
    forms = [pair for pair in (("real", "imag"), ("magnitude", "phase_deg")) if set(pair) & set(names)]
    if len(forms) != 1 or not set(forms[0]) <= set(names):
        raise SceneError(f"the response is written real, imag or magnitude, phase_deg: there are {', '.join(names)}")
    return tuple(names)


def _factor(column: str, unit: str) -> tuple[float, MotionKind | None]:
    """What the numbers of a column are multiplied by, and the motion that its unit implies."""
    if not unit or unit == "-":
        return 1.0, None
    known = _PLAIN_UNITS.get(column)
    if known is not None:
        if unit not in known:
            raise SceneError(
                f"{column}: the unit is {quoted(unit)}, and must be {next(iter(known))}{_otherwise(column, unit)}"
            )
        return known[unit], None
    if unit.lower().startswith("db"):
        raise SceneError(f"{column}: {quoted(unit)}: give the magnitude itself in N/m, 10^(dB/20) of what 0 dB is")
    try:
        read = quantity(f"1 {unit}", Dimension.STIFFNESS)
    except SceneError as error:
        raise SceneError(f"{column}: {error}{_velocity(unit)}") from None
    return float(read.value), read.motion


def _otherwise(column: str, unit: str) -> str:
    if column == "omega" and unit in _PLAIN_UNITS["frequency_hz"]:
        return ": call the column frequency_hz"
    return ": call the column omega" if column == "frequency_hz" and unit in _PLAIN_UNITS["omega"] else ""


def _velocity(unit: str) -> str:
    """A hint where the unit is that of force per velocity."""
    try:
        quantity(f"1 {unit}", Dimension.DAMPING)
    except SceneError:
        return ""
    return "; this is force per velocity: multiply by j omega to have force per position"


def _units(columns: Sequence[str], units: Sequence[str]) -> tuple[str, ...]:
    """A radius without a unit has that of H beside it; SceneError where one column of H has a unit and the other has none."""
    known = dict(zip(columns, units, strict=True))
    of_h = [x for x in ("real", "imag", "magnitude") if x in known]
    named, bare = [x for x in of_h if known[x]], [x for x in of_h if not known[x]]
    if named and bare:
        unit = known[named[0]]
        raise SceneError(
            f"{bare[0]} has no unit, and {named[0]} has {unit}: write {bare[0]} [{unit}], or whatever it is in"
        )
    if named and not known.get("radius", "is not there"):
        known["radius"] = known[named[0]]
    return tuple(known.values())


_FORM = Form(("omega", "frequency_hz"), _checked, _factor, "omega,real,imag,coherence", _units)


def _measurement(table: NumberTable, averages: float | None, confidence: float) -> Measurement:
    column = table.column
    omega = column["omega"] if "omega" in column else 2 * np.pi * column["frequency_hz"]
    lines: Any = _Rows(omega, _response(table), column.get("coherence"), column.get("radius"))
    check_lines(lines, table.place)
    motion, path = table.head.motion, table.path
    return Measurement(
        lines.omega, lines.H, lines.coherence, averages, confidence, lines.radius, motion, path.name, path
    )


class _Rows(NamedTuple):
    omega: Any
    H: Any
    coherence: Any
    radius: Any


def _response(table: NumberTable) -> Any:
    column = table.column
    if "real" in column:
        H = 1j * column["imag"]
        H += column["real"]
        return H
    size, phase = column["magnitude"], column["phase_deg"]
    if (size < 0).any():
        first = int(np.argmax(size < 0))
        raise SceneError(f"{table.place(first)}: magnitude: {size[first]:.6g} must be 0 or above")
    return size * np.exp(1j * np.deg2rad(phase))
