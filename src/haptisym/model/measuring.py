"""A measured response from wherever it is: arrays, data of python-control, a file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from haptisym.kernel.errors import SceneError
from haptisym.model.measured import CONFIDENCE, Measurement
from haptisym.model.measuredfile import read_measurement


def measured(
    omega: ArrayLike | str | Path | Any,
    H: ArrayLike | None = None,
    *,
    coherence: ArrayLike | None = None,
    averages: float | None = None,
    confidence: float = CONFIDENCE,
    radius: ArrayLike | None = None,
    name: str = "",
) -> Measurement:
    """A measured frequency response: of arrays, of python-control's data (FRD), or of a CSV file.

    ``omega`` : rad/s, with ``H``, force per position (N/m or N m/rad), complex; or an FRD object of one input and one output; or
    the path of a file, which has its own coherence or radius. ``coherence`` : with ``averages``, of the estimate H1, as
    ``scipy.signal.coherence`` gives it; ``radius`` : of discs that hold the truth with that ``confidence``, instead.
    Raises SceneError for what cannot be.

    >>> measured([1, 2, 3], [100 + 15j, 95 + 30j, 80 + 45j], coherence=[0.99, 0.98, 0.99], averages=20)
    <Measurement measured: 3 lines from 1 to 3 rad/s>
    """
    if isinstance(omega, str | Path):
        if H is not None or coherence is not None or radius is not None:
            raise SceneError("a file has its own columns: leave out H, coherence and radius")
        return read_measurement(Path(omega), averages, confidence)
    if H is None:
        omega, H = _frd(omega)
    return Measurement(omega, H, coherence, averages, confidence, radius, name=name or "measured")


def _frd(system: Any) -> tuple[Any, Any]:
    """Frequencies and responses of python-control's data."""
    package = sys.modules.get("control")
    if package is None or not isinstance(system, package.FrequencyResponseData):
        shown = type(system).__name__
        raise SceneError(
            f"{shown} is no measured response: give omega and H, a FRD object of python-control, or a file"
        )
    if (system.ninputs, system.noutputs) != (1, 1):
        raise SceneError(f"the FRD object has {system.ninputs} inputs and {system.noutputs} outputs: take one of each")
    return system.omega, system.frdata[0, 0]
