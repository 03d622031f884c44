"""The verb ``haptisym schemas``: what documents of JSON hold."""

from __future__ import annotations

from json import dumps

import click

from haptisym.commands.options import json_option, say_document, say_list, verb
from haptisym.kernel.errors import SceneError
from haptisym.writing.schemas import json_schema, schema_names, schema_text


@verb(pages=False)
@click.argument("name", required=False)
@json_option
def schemas(name: str | None, as_json: bool) -> None:
    """List the documents of --json, or print a JSON Schema.

    NAME is one of the list, or the value of the key "schema" of a document.

    \b
    Examples:
      haptisym schemas
      haptisym schemas evaluation > evaluation.schema.json
    """
    if name is not None:
        if as_json:
            raise SceneError("--json lists the documents: a schema is JSON already, leave out --json")
        say_document(schema_text(name).rstrip())
        return
    rows = [(x, str(json_schema(x)["description"])) for x in schema_names()]
    if as_json:
        listed = [{"name": x, "description": what} for x, what in rows]
        say_document(dumps({"schema": "haptisym.schemas/1", "schemas": listed}, indent=2, ensure_ascii=False))
        return
    say_list("Documents of --json", [(x, what.replace("`", "")) for x, what in rows])
