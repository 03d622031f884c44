"""The schemas of what ``--json`` prints: one file of JSON Schema (2020-12) for each kind of
document."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from haptisym.kernel.errors import HaptisymError, meant, quoted

_FOLDER = files("haptisym") / "schemas"


class SchemaError(HaptisymError):
    """There is no document of that name."""


def schema_names() -> list[str]:
    """The kinds of documents, as ``evaluation`` of ``haptisym.evaluation/1``.

    >>> schema_names()[:3]
    ['answers', 'comparison', 'controlloading']
    """
    return sorted(
        x.name.removesuffix(".json") for x in _FOLDER.iterdir() if x.name.endswith(".json")
    )


def schema_text(name: str) -> str:
    """The text of a schema's file. ``name`` : the schema's own, or what the key ``schema`` of a
    document says; SchemaError for any other."""
    kind = name.removeprefix("haptisym.").removesuffix("/1")
    known = schema_names()
    # Only a known name becomes part of a path.
    if kind not in known:
        raise SchemaError(
            f"no document is called {quoted(name)}: {meant(kind, known)}these are "
            f"{', '.join(known)}"
        )
    return (_FOLDER / f"{kind}.json").read_text(encoding="utf-8")


def json_schema(name: str) -> dict[str, Any]:
    """The schema of a kind of document, for any validator: keys that it does not name may be there
    as well.

    ``name`` : as ``evaluation``, or as ``haptisym.evaluation/1``, the key ``schema`` of the
    document.

    >>> json_schema("haptisym.evaluation/1")["properties"]["band"]
    {'$ref': '#/$defs/interval', 'description': 'The frequencies asked about, rad/s.'}
    """
    schema: dict[str, Any] = json.loads(schema_text(name))
    return schema
