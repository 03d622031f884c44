"""A measured response from a file of any kind: lines, or records in time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from haptisym.kernel.errors import SceneError, meant
from haptisym.model.matfile import read_mat
from haptisym.model.measured import Measurement
from haptisym.model.measuredfile import read_measurement
from haptisym.model.recordfile import read_record
from haptisym.model.uff import read_uff

RECORDS = ("estimator", "segment", "overlap", "window", "every")
"""Keys of a response that is estimated from records in time."""


_LINES = {".uff": read_uff, ".unv": read_uff, ".mat": read_mat}
"""By the ending of a file what reads its lines; all other files are tables."""


def read_file(path: Path, averages: float | None, confidence: float, records: Mapping[str, Any]) -> Measurement:
    """The response in a file; of records in time where an estimator is named."""
    if not records:
        return _LINES.get(path.suffix.lower(), read_measurement)(path, averages, confidence)
    for key in records:
        if key not in RECORDS:
            raise SceneError(f'unknown key "{key}": {meant(key, RECORDS)}valid are {", ".join(RECORDS)}')
    if not isinstance(records.get("estimator"), str):
        raise SceneError(
            "estimator is missing: of records in time say by which, H1, H2 or joint, the response is estimated"
        )
    if averages is not None:
        raise SceneError("averages: of records in time they follow from the segments: leave it out")
    return read_record(path, confidence=confidence, **records)
