"""What a sweep found, as a short page of text and as a JSON document."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import pi
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from haptisym.pages.lines import WIDTH
from haptisym.verbs.sweep.exactly import COUNTS, EXACT, FLOAT, FLOATS, OPEN

if TYPE_CHECKING:
    import xarray as xr

_NAMES = {
    "bandwidth": "bandwidth",
    "first_crossing_real": "first crossing, real part",
    "first_crossing_imag": "first crossing, imaginary part",
    "changeover_environment": "changeover of the environment",
    "changeover_perceived": "changeover as felt",
}


def document(data: xr.Dataset, out: Path | None = None) -> dict[str, Any]:
    """The document of ``haptisym sweep --json``, schema ``haptisym.sweep/1``: axes, ranges and counts, not the sets."""
    methods = [int((data.method == kind).sum()) for kind in (FLOAT, EXACT, OPEN)]
    found: dict[str, Any] = {
        "schema": "haptisym.sweep/1",
        "title": data.attrs["title"],
        "band": [float(x) for x in data.attrs["band"]],
        "vary": [_axis(data, str(name)) for name in data.method.dims],
        "sets": int(data.method.size),
        **dict(zip(("certified_in_floats", "exact", "open"), methods, strict=True)),
        "ranges": {name: _range(data[name]) for name in FLOATS},
        "counts": {name: _counts(data[name]) for name in COUNTS},
        "out": None if out is None else str(out),
    }
    asides = {key: json.loads(data.attrs[key]) for key in ("nominal", "untied") if key in data.attrs}
    notes = {"notes": data.attrs["notes"].split("\n")} if "notes" in data.attrs else {}
    return found | asides | notes | ({"open_at": _places(data)} if found["open"] else {})


def _axis(data: xr.Dataset, name: str) -> dict[str, Any]:
    x = data[name].values
    ends = {"low": float(x.min()), "high": float(x.max())}
    return {"path": name, "unit": data[name].attrs["units"], **ends, "values": len(x)}


def _range(column: xr.DataArray) -> list[float] | None:
    low, high = float(column.fillna(np.inf).min()), float(column.fillna(-np.inf).max())
    return None if low > high else [low, high]  # dask warns of blocks that hold NaN alone


def _counts(column: xr.DataArray) -> dict[str, int]:
    """How many sets have that many."""
    low, high = int(column.min()), int(column.max())
    return {str(n): found for n in range(max(low, 0), high + 1) if (found := int((column == n).sum()))}


def _places(data: xr.Dataset, most: int = 5) -> list[dict[str, float]]:
    """The parameters of the first few sets that have no answer."""
    where = np.argwhere((data.method == OPEN).values)[:most]
    names = [str(name) for name in data.method.dims]
    return [{name: float(data[name].values[i]) for name, i in zip(names, index, strict=True)} for index in where]


def page(told: Mapping[str, Any]) -> str:
    """The page of text for a document."""
    heading = "\n".join(fill(line, WIDTH) for line in (told["title"] or "Untitled scene", *told.get("notes", ())))
    parts = [heading, _varied(told), _found(told), _certain(told)]
    if told["out"]:
        parts.append(f"Written to {told['out']}.")
    return "\n\n".join(parts) + "\n"


def _varied(told: Mapping[str, Any]) -> str:
    width = max(len(x["path"]) for x in told["vary"])
    rows = [
        f"  {x['path']:<{width}}  {x['low']:.6g} to {x['high']:.6g} {'' if x['unit'] == '1' else x['unit']}".rstrip()
        + f", {x['values']:,} values"
        for x in told["vary"]
    ]
    low, high = told["band"]
    return "\n".join([*rows, f"  {'band':<{width}}  {low:.6g} to {high:.6g} rad/s"])


def _found(told: Mapping[str, Any]) -> str:
    rows = [f"  {'':<32}rad/s{'':<19}Hz"]
    for key, name in _NAMES.items():
        span = told["ranges"][key]
        rows.append(f"  {name:<32}{_span(span):<24}{_span(span, 2 * pi) if span else ''}".rstrip())
    clear = told["ranges"]["transparent"]
    rows.append(f"  {'transparent part of the band':<32}{'none' if clear is None else _span(clear, 0.01) + ' %'}")
    for part in ("real", "imag"):
        counts = ", ".join(f"{n}: {sets:,}" for n, sets in told["counts"][f"crossings_{part}"].items())
        rows.append(
            f"  {'crossings, ' + ('real' if part == 'real' else 'imaginary') + ' part':<32}{counts or 'none'} sets"
        )
    return "\n".join(rows)


def _span(span: list[float] | None, unit: float = 1.0) -> str:
    return "none" if span is None else f"{span[0] / unit:.5g} to {span[1] / unit:.5g}"


def _certain(told: Mapping[str, Any]) -> str:
    methods = f"{told['certified_in_floats']:,} certified in floats, {told['exact']:,} exact"
    lines = [
        fill(
            f"Certain: {told['sets']:,} sets, {methods}. All counts are proven, and all frequencies to a relative 1e-10, for "
            "parameters that are exactly the binary numbers stored with the results.",
            WIDTH,
        )
    ]
    if told["open"]:
        first = ", ".join(f"{name} = {x:.17g}" for name, x in told["open_at"][0].items())
        lines.append(f"NOT ANSWERED: {told['open']:,} sets (undecided, or no dynamics), the first at {first}.")
    return "\n".join(lines)
