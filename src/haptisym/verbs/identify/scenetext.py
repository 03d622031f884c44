"""A scene file, written: tables to TOML, and what stands in a scene as the tables that it was read from."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from sympy import Expr, Rational, pi

from haptisym.kernel.errors import SceneError
from haptisym.model.catalogue import ENVIRONMENTS, Environment
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import Dimension

Table: TypeAlias = Mapping[str, Any]


def scene_text(title: str, source: str, remarks: Iterable[str], tables: Sequence[tuple[str, Table]]) -> str:
    """A scene file. ``remarks`` : comments at its head. ``tables`` : each with its heading, as ``[environment]``.

    >>> print(scene_text("Wall", "", ["fitted"], [("[environment]", {"model": "kelvin-voigt", "k": ["1 N/m", "3 N/m"]})]))
    # fitted
    title = "Wall"
    <BLANKLINE>
    [environment]
    model = "kelvin-voigt"
    k = ["1 N/m", "3 N/m"]
    <BLANKLINE>
    """
    head = [
        *(f"# {x}" for x in remarks),
        f"title = {_value(title)}",
        *([f"source = {_value(source)}"] if source else []),
    ]
    for heading, table in tables:
        head += ["", heading, *(f"{key} = {_value(x)}" for key, x in table.items())]
    return "\n".join(head) + "\n"


def _value(given: Any) -> str:
    if isinstance(given, str):
        return json.dumps(given, ensure_ascii=False).replace("\x7f", "\\u007f")  # which TOML reads as JSON does
    if isinstance(given, Mapping):
        return f"{{ {', '.join(f'{key} = {_value(x)}' for key, x in given.items())} }}"
    return f"[{', '.join(map(_value, given))}]" if isinstance(given, list | tuple) else str(given)


def environment_table(own: Environment) -> Table:
    """The table of an environment whose parameters are numbers."""
    slots = ENVIRONMENTS[own.model].slots
    table: dict[str, Any] = {"model": own.model}
    table |= {key: str(own.dynamics) for key, x in slots.items() if x.formula}
    for p in own.parameters:
        key = p.key.partition("[")[0]
        if key not in slots:
            table.setdefault("parameters", {})[p.key] = _quantity(p)
        elif slots[key].several:
            table.setdefault(key, []).append(_quantity(p))
        else:
            table[key] = _quantity(p)
    return table


def _quantity(p: Parameter) -> Any:
    low, high = p.interval or (p.value, p.value)
    unit = p.unit_in(p.motion) if p.motion or p.exponents else ""
    told = [exactly(x, p.dimension, unit) for x in (low, p.value, high)]
    return told if p.interval else told[1]


def exactly(value: Expr, dimension: Dimension, unit: str) -> str:
    """An exact number as a scene file has it, in Hz where it is a frequency that has pi in it."""
    if dimension is Dimension.FREQUENCY:
        turns = value / (2 * pi)
        return f"{turns} Hz" if turns.is_Rational else f"{value} rad/s"
    number = str(value) if isinstance(value, Rational) else repr(float(value))
    return f"{number} {unit}".rstrip()


def threshold_value(c: Threshold) -> Any:
    """What a scene file says of a threshold: its key ``jnd``."""
    if c.source:
        return {"like": c.source}
    own = c.region
    if own.shape is Shape.POLYGON:
        return {"shape": "polygon", "corners": [[str(x), str(y)] for x, y in own.corners], **_taken(c)}
    table: dict[str, Any] = {} if own.shape is Shape.SQUARE else {"shape": own.shape.value}
    table |= {part.value: _limit(c, part) for part in Part} | ({"tilt": str(own.tilt)} if own.tilt else {})
    if own.floor is not None:
        table["floor"] = str(own.floor)
    return table | _taken(c)


def _taken(c: Threshold) -> dict[str, Any]:
    return {} if c.proportion is None else {"proportion": str(c.proportion)}


def _limit(c: Threshold, part: Part) -> Any:
    interval, lower = c.interval(part), c.lower(part)
    if c[part].is_number and not c[part].is_Rational:
        raise SceneError(f"jnd: {c[part]} cannot be written in a scene file: give a rational number")
    if lower is not None:
        return {"higher": str(c[part]), "lower": str(lower)}
    return str(c[part]) if interval is None else [str(x) for x in (interval[0], c[part], interval[1])]


def band_value(low: float, high: float) -> list[str]:
    """What a scene file says of a band that ends at floats."""
    return [f"{x!r} rad/s" for x in (low, high)]
