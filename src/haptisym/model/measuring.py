"""Measured responses from arrays, from python-control's data or from a file; and responses sampled
from a scene of formulas. Begin with ``measured``."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import whole
from haptisym.model.measured import CONFIDENCE, Measurement, one_row
from haptisym.model.responsefile import read_file, refuse_universal
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene


def measured(
    omega: ArrayLike | str | Path | Any,
    H: ArrayLike | None = None,
    *,
    coherence: ArrayLike | None = None,
    averages: float | None = None,
    confidence: float | None = None,
    radius: ArrayLike | None = None,
    slope: str | None = None,
    name: str = "",
    **records: Any,
) -> Measurement:
    """A measured frequency response: of arrays, of python-control's data (FRD), or of a CSV file.

    ``omega`` : rad/s, with ``H``, force per position (N/m or N m/rad), complex; or an FRD object of
    one input and one output; or the path of a file, which has its own coherence or radius, in the
    columns that ``to_csv`` writes, where nothing else is given. ``coherence`` : with ``averages``,
    of the estimate H1, as ``scipy.signal.coherence`` gives it; ``radius`` : of discs that hold the
    truth with that ``confidence`` (0.95), instead. ``slope`` : a bound on ``|dH/domega|`` between
    the lines, "40 N*s/m", or as a share of ``|H|``, "20 ms".
    ``records`` : of a file its ``columns`` (role to header or number), ``unit`` (of a role),
    ``quantity`` and ``sign``, as in a scene, and ``minus``, the file of the rig without load; of
    records in time the ``estimator``, and ``segment``, ``overlap``,
    ``window``, ``every`` as of
    ``estimated``, which takes arrays. Raises SceneError for what cannot be.

    >>> measured([1, 2, 3], [100 + 15j, 95 + 30j, 80 + 45j], coherence=[0.99, 0.98, 0.99], averages=20)
    <Measurement measured: 3 lines from 1 to 3 rad/s>
    """
    if isinstance(omega, str | Path):
        if H is not None or coherence is not None or radius is not None:
            raise SceneError("a file has its own columns: leave out H, coherence and radius")
        response = read_file(Path(omega), averages, confidence, records)
        return response if slope is None else replace(response, slope=slope)
    if records:
        raise SceneError(
            f"{next(iter(records))}: goes with a file of records in time; for arrays there "
            f"is estimated"
        )
    if H is None:
        omega, H = _frd(omega)
    level = CONFIDENCE if confidence is None else confidence
    return Measurement(
        omega, H, coherence, averages, level, radius, name=name or "measured", slope=slope
    )


def _frd(system: Any) -> tuple[Any, Any]:
    """The frequencies and the response of a FrequencyResponseData of python-control; SceneError for
    anything else."""
    # Such an object exists only where the package is loaded: it need not be imported to ask.
    package = sys.modules.get("control")
    if package is None or not isinstance(system, package.FrequencyResponseData):
        shown = type(system).__name__
        raise SceneError(
            f"{shown} is no measured response: give omega and H, a FRD object of "
            f"python-control, or a file"
        )
    if (system.ninputs, system.noutputs) != (1, 1):
        raise SceneError(
            f"the FRD object has {system.ninputs} inputs and {system.noutputs} outputs: take "
            f"one of each"
        )
    return system.omega, system.frdata[0, 0]


def sampled(
    scene: Scene | str | Path, omega: ArrayLike | None = None, *, points: int = 200
) -> Measurement:
    """The exact H_perc of a scene at frequencies, as if it had been measured without error; each
    float is the nearest one.

    ``omega`` : rad/s, rising; without it that many ``points``, evenly on the band. Frequencies at
    which H_perc is infinite are left out. Raises SceneError for parameters that are still symbols.

    >>> sampled("fu2019", [0, 8]).H.tolist()[0]
    (100+0j)
    """
    given = as_scene(scene)
    given.knobs.need_numbers()
    points = whole("points", points, 2)
    low, high = (float(x) for x in given.band)
    at = one_row("omega", np.linspace(low, high, points) if omega is None else omega, float)
    # Refuses what no frequencies can be, before anything is computed at them.
    Measurement(at, np.zeros(len(at)), name="sampled")
    values = given.distortion().compile("certified", of=["perceived_real", "perceived_imag"])(at)
    real, imag = values.perceived_real, values.perceived_imag
    # At a pole on the axis H_perc is infinite: no measurement has such a line.
    known = np.isfinite(real) & np.isfinite(imag)
    return Measurement(
        at[known],
        real[known] + 1j * imag[known],
        motion=given.motion,
        name=given.title or "sampled",
    )


def write_sampled(scene: Scene, path: Path, points: int) -> Path:
    """Write the exact response of a scene at ``points`` frequencies to a CSV file; its path."""
    refuse_universal(path)
    return sampled(scene, points=points).to_csv(path)
