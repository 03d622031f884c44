"""The verbs that list what the package ships, ``haptisym scenes`` and ``schemas``: they load no
SymPy."""

from __future__ import annotations

import tomllib
from json import dumps
from typing import Any

from haptisym.commands.options import JSON, Ask, optional, verb
from haptisym.commands.terminal import say_document, say_list, write
from haptisym.kernel.errors import SceneError
from haptisym.model.shipped import family_names, scene_names, shipped_text
from haptisym.writing.characters import printable


@verb(optional("name"), JSON, pages=False)
def scenes(ask: Ask) -> None:
    """List the shipped scenes, or print one to start from.

    \b
    Examples:
      haptisym scenes
      haptisym scenes fu2019 > my-device.toml
    """
    if ask.name is not None:
        if ask.json:
            raise SceneError("--json lists the scenes: a scene file is TOML, leave out --json")
        write(shipped_text(ask.name) or printable(_file(ask.name)))
        return
    # The tables as they stand in the files: to load a scene would take SymPy.
    shipped = [
        (name, tomllib.loads(shipped_text(name) or ""))
        for name in (*scene_names(), *family_names())
    ]
    rows = [
        {
            "name": name,
            "title": x["title"],
            "source": x["source"],
            "effects": [
                *(e.get("name", e["model"]) for e in x.get("effects", ())),
                *({"device"} & x.keys()),
            ],
            "environments": len(x.get("environments", [x])),
        }
        for name, x in shipped
    ]
    title = "Scenes to start from; haptisym scenes NAME > my.toml copies one"
    _list(ask, "scenes", rows, title, [(name, x["title"]) for name, x in shipped])


def _file(name: str) -> str:
    """The text of a scene file that is not shipped."""
    from haptisym.model.scenefile import scene_text  # SymPy, which a list does not need

    return scene_text(name)[0]


@verb(optional("name"), JSON, pages=False)
def schemas(ask: Ask) -> None:
    """List the documents of --json, or print a JSON Schema.

    NAME is one of the list, or the value of the key "schema" of a document.

    \b
    Examples:
      haptisym schemas
      haptisym schemas evaluation > evaluation.schema.json
    """
    from haptisym.writing.schemas import json_schema, schema_names, schema_text

    if ask.name is not None:
        if ask.json:
            raise SceneError(
                "--json lists the documents: a schema is JSON already, leave out --json"
            )
        say_document(schema_text(ask.name).rstrip())
        return
    described = [(x, str(json_schema(x)["description"])) for x in schema_names()]
    rows = [{"name": x, "description": what} for x, what in described]
    _list(
        ask,
        "schemas",
        rows,
        "Documents of --json",
        [(x, what.replace("`", "")) for x, what in described],
    )


def _list(
    ask: Ask, kind: str, rows: list[dict[str, Any]], title: str, shown: list[tuple[str, str]]
) -> None:
    """Print a list of what the package ships, as a document or as a page."""
    if ask.json:
        say_document(
            dumps({"schema": f"haptisym.{kind}/1", kind: rows}, indent=2, ensure_ascii=False)
        )
        return
    say_list(title, shown)
