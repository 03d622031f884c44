"""Frequency responses in files of MATLAB, by SciPy: variables named as the columns of a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.model.csvtable import refuse
from haptisym.model.measured import Measurement, check_certainty, check_lines

_NAMES = ("omega", "frequency_hz", "H", "real", "imag", "coherence", "radius")


def read_mat(path: Path, averages: float | None, confidence: float) -> Measurement:
    """The response in a file: ``omega`` or ``frequency_hz``; ``H``, or ``real`` and ``imag``; ``coherence`` or ``radius``.

    SceneError says what is missing. It needs SciPy, which reads files up to version 7.
    """
    try:
        refuse(path, text=False)
        rows = _variables(path)
        if ("omega" in rows) == ("frequency_hz" in rows):
            raise SceneError("the variables must hold the frequencies once: omega (rad/s) or frequency_hz")
        if "H" not in rows and not {"real", "imag"} <= set(rows):
            raise SceneError("the variables must hold the response: H, or real and imag")
        if "H" in rows and (others := [x for x in ("real", "imag") if x in rows]):
            raise SceneError(
                f"the variables hold the response twice, as H and as {' and '.join(others)}: leave out one of them"
            )
        omega = rows["omega"] if "omega" in rows else 2 * np.pi * rows["frequency_hz"]
        H = rows["H"] if "H" in rows else rows["real"] + 1j * rows["imag"]
        coherence, radius = rows.get("coherence"), rows.get("radius")
        check_certainty(coherence is not None, radius is not None, averages, confidence)
        if any(x is not None and len(x) != len(omega) for x in (H, coherence, radius)):
            raise SceneError("the variables must have as many numbers as each other")
        check_lines(_Rows(omega, H, coherence, radius), lambda i: f"line {i + 1}")  # type: ignore[arg-type]
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return Measurement(omega, H, coherence, averages, confidence, radius, name=path.name, path=path)


class _Rows(NamedTuple):
    omega: Any
    H: Any
    coherence: Any
    radius: Any


def _variables(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        found = loadmat(path, variable_names=_NAMES)
    except NotImplementedError:
        raise SceneError("a file of version 7.3, which SciPy does not read: save it with -v7") from None
    except Exception as error:  # noqa: BLE001  whatever SciPy raises for what is none
        raise SceneError(f"not a file of MATLAB that can be read: {str(error).lower()}") from None
    return {key: _numbers(key, found[key]) for key in _NAMES if key in found}


def _numbers(key: str, given: Any) -> Any:
    row = np.asarray(given)
    if row.dtype.kind not in "biufc" or row.size != max(row.shape, default=0):
        raise SceneError(f"{key}: must be one row or column of numbers")
    if row.dtype.kind == "c" and key != "H":
        raise SceneError(f"{key}: must be real")
    return row.ravel().astype(complex if key == "H" else float)
