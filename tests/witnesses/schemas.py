"""A validator of its own (jsonschema) for the documents of ``--json``."""

from __future__ import annotations

import json
from functools import cache
from importlib.util import find_spec
from typing import Any

import haptisym as hs

IS_THERE = find_spec("jsonschema") is not None
"""Whether the validator is installed; the extra ``test`` brings it."""


@cache
def validator(name: str) -> Any:
    """Of one kind of document."""
    from jsonschema import Draft202012Validator

    return Draft202012Validator(hs.json_schema(name))


def faults(document: Any) -> list[str]:
    """What a document has that its schema forbids: where, and what; empty for a good one."""
    found = validator(document["schema"]).iter_errors(document)
    return [f"{document['schema']} {x.json_path}: {x.message[:200]}" for x in found]


def parsed(text: str) -> Any:
    """A document of strict JSON: NaN and infinities are none."""

    def refused(word: str) -> None:
        raise ValueError(f"{word} is not JSON")

    return json.loads(text, parse_constant=refused)
