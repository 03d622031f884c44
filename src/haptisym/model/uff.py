"""Frequency responses in universal files, dataset 58 (UFF58), by pyuff."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import counted
from haptisym.model.csvtable import refuse
from haptisym.model.measured import Measurement, check_certainty, check_lines

_RESPONSE, _COHERENCE = 4, 6
"""What a dataset holds, its ``func_type``."""
_FORCES, _DISPLACEMENT, _UNKNOWN, _FREQUENCY = (9, 13), 8, 0, 18
"""What an axis holds, its ``spec_data_type``."""


def read_uff(path: Path, averages: float | None, confidence: float) -> Measurement:
    """The one frequency response in a file, force per displacement in SI, with its coherence if that is there.

    SceneError for a file with none or several, and for other quantities than force and displacement. It needs pyuff.
    """
    try:
        refuse(path, text=False)
        sets = _sets(path)
        found = [x for x in sets if x.get("func_type") == _RESPONSE]
        if len(found) != 1:
            raise SceneError(f"there are {counted(len(found), 'frequency response')} in it, and must be one")
        _check_axes(found[0])
        omega, H = 2 * np.pi * np.asarray(found[0]["x"], dtype=float), np.asarray(found[0]["data"], dtype=complex)
        coherence = _coherence(sets, found[0])
        check_certainty(coherence is not None, False, averages, confidence)  # noqa: FBT003
        check_lines(_Rows(omega, H, coherence, None), lambda i: f"line {i + 1}")  # type: ignore[arg-type]
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return Measurement(omega, H, coherence, averages, confidence, name=path.name, path=path)


class _Rows(NamedTuple):
    omega: Any
    H: Any
    coherence: Any
    radius: Any


def _sets(path: Path) -> list[dict[str, Any]]:
    """The datasets 58 of a file."""
    import pyuff

    try:
        with _files_left_open():
            file = pyuff.UFF(str(path))
            kinds = [int(x) for x in file.get_set_types()]
            return [file.read_sets(i) for i, kind in enumerate(kinds) if kind == 58]
    except Exception as error:  # noqa: BLE001  pyuff raises plain ones
        raise SceneError(f"not a universal file that can be read: {str(error).lower()}") from None


@contextmanager
def _files_left_open() -> Iterator[None]:
    """pyuff leaves files to be closed by the collector, which warns of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _check_axes(found: dict[str, Any]) -> None:
    above, below = found.get("ordinate_spec_data_type", 0), found.get("orddenom_spec_data_type", 0)
    if above not in (*_FORCES, _UNKNOWN) or below not in (_DISPLACEMENT, _UNKNOWN):
        raise SceneError(
            f"the response is not force per displacement (data types {above} over {below}): turn it over, or multiply it by "
            "powers of j omega, until it is"
        )


def _coherence(sets: list[dict[str, Any]], response: dict[str, Any]) -> Any:
    found = [x for x in sets if x.get("func_type") == _COHERENCE]
    if not found:
        return None
    if len(found) > 1 or not np.array_equal(found[0]["x"], response["x"]):
        raise SceneError("its coherence must be one dataset, at the frequencies of the response")
    return np.clip(np.real(found[0]["data"]), 0, 1)


def shown_hertz(hertz: Any) -> Any:
    """Frequencies with the six digits that a universal file has for them.

    >>> shown_hertz([1 / 3, 2]).tolist()
    [0.333333, 2.0]
    """
    return np.array([float(f"{x:.5e}") for x in hertz])


def write_uff(m: Measurement, path: str | Path) -> Path:
    """Write the lines, and their coherence, as datasets 58: twelve digits of each part, six of each frequency in Hz."""
    import pyuff

    rows = [(_RESPONSE, m.H)] + ([(_COHERENCE, m.coherence)] if m.coherence is not None else [])
    with _files_left_open():
        for i, (kind, data) in enumerate(rows):
            pyuff.UFF(str(path)).write_sets(_dataset(m, kind, data), "add" if i else "overwrite")
    return Path(path)


def _dataset(m: Measurement, kind: int, data: Any) -> dict[str, Any]:
    import pyuff

    hertz = m.omega / (2 * np.pi)
    above, below = (_FORCES[1], _DISPLACEMENT) if kind == _RESPONSE else (_UNKNOWN, _UNKNOWN)
    made: dict[str, Any] = pyuff.prepare_58(
        binary=0, func_type=kind, data=data, x=hertz, id1=m.name[:80] or "haptisym", id2="NONE", id3="NONE", id4="NONE",
        id5="NONE", ver_num=0, load_case_id=0, rsp_ent_name="NONE", rsp_node=1, rsp_dir=1, ref_ent_name="NONE", ref_node=1,
        ref_dir=1, ord_data_type=6 if kind == _RESPONSE else 4, num_pts=len(hertz), abscissa_spacing=0,
        abscissa_min=float(hertz[0]), abscissa_inc=0.0, z_axis_value=0.0, abscissa_spec_data_type=_FREQUENCY,
        ordinate_spec_data_type=above, orddenom_spec_data_type=below,
    )  # fmt: skip
    return made
