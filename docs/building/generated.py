"""The pages of the site that are written anew for every build, from what the package says of itself."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import api
import click
from make_notebook import cells

from haptisym.cli import VERBS, app
from haptisym.model.scenefile import scene_text
from haptisym.writing.schemas import json_schema, schema_names

Page = Callable[[], str]


def write(folder: Path) -> None:
    """All of them; a page that says what it said is left as it is, so that it is not read again."""
    import gallery

    folder.mkdir(exist_ok=True)
    pages: dict[str, Page] = {"verbs": verbs, "schemas": schemas, "derivations": derivations, **api.PAGES}
    pages |= {f"derivation-{path.stem}": partial(derivation, path) for path in DERIVATIONS.glob("*.py")}
    pages |= gallery.pages(folder)
    for path in folder.glob("*.md"):
        if path.stem not in pages:
            path.unlink()
    for name, page in pages.items():
        _keep(folder / f"{name}.md", page())


def _keep(path: Path, text: str) -> None:
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def verbs() -> str:
    """What ``--help`` of every verb says."""
    helps = {"haptisym": _help(app, "haptisym")}
    with click.Context(app, info_name="haptisym") as context:
        for name in VERBS:
            command = app.get_command(context, name)
            assert command is not None
            helps[f"haptisym {name}"] = _help(command, name, context)
    blocks = [f"## {name}\n\n```text\n{text}\n```\n" for name, text in helps.items()]
    lead = "What `--help` says of each verb; what it means, and what the documents of `--json` hold, is in [Command line](../command-line.md).\n"
    return "\n".join(["# Every option\n", lead, *blocks])


def _help(command: click.Command, name: str, parent: click.Context | None = None) -> str:
    with click.Context(command, info_name=name, parent=parent, max_content_width=96, terminal_width=96) as context:
        return command.get_help(context)


def schemas() -> str:
    """A table of keys for each document."""
    lead = (
        "What each document of `--json` holds, as its schema says it. The schemas themselves (JSON Schema, 2020-12) are in the package: "
        "`haptisym schemas NAME` prints one, `hs.json_schema(NAME)` gives it to a validator "
        "([Command line](../command-line.md#schemas)). Keys in *italics* are there only where they say something.\n"
    )
    return "\n".join(["# Documents of JSON\n", lead, *map(_schema, schema_names())])


def _schema(name: str) -> str:
    schema = json_schema(name)
    head = f"## {schema['title']}\n\n{schema['description']}\n\n| key | type | content |\n|---|---|---|"
    return "\n".join([head, *_rows(schema, "", schema.get("$defs", {})), ""])


def derivations() -> str:
    """The table of the folder ``derivations``, and its pages."""
    text = (DERIVATIONS / "README.md").read_text(encoding="utf-8")
    names = "\n".join(f"derivation-{path.stem}" for path in sorted(DERIVATIONS.glob("*.py")))
    return f"{linked(text)}\n```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{names}\n```\n"


def derivation(path: Path) -> str:
    """A derivation to read: its words, and its code as it stands. The tests run it."""
    script = path.read_text(encoding="utf-8")
    title = path.stem[3:].replace("_", " ").capitalize()
    lead = f"`python derivations/{path.name}` runs it; the tests do.\n"
    claim = ast.get_docstring(ast.parse(script)) or ""
    parts = [text if kind == "markdown" else _code(text, claim) for kind, text in cells(script)]
    return "\n\n".join([f"# {title}\n", lead, _quoted(claim), *parts]) + "\n"


def _quoted(claim: str) -> str:
    """Words as they stand."""
    return f"```text\n{claim}\n```\n"


def _code(text: str, claim: str) -> str:
    """Without the claim, which stands above."""
    return f"```python\n{text}\n```" if claim[:60] not in text else ""


def scene_file(name: str) -> str:
    """The text of a shipped scene or family."""
    return scene_text(name)[0].rstrip()


DERIVATIONS = Path(__file__).parents[2] / "derivations"


def linked(text: str) -> str:
    """Links to derivations lead to their pages; other scripts beside ``docs`` are named, as a site has no page of them."""
    named = re.sub(r"\[([^\]]+)\]\(\.\./((?!derivations/)[\w/]+\.py)\)", r"\1 (`\2`)", text)
    return re.sub(r"\]\((?:\.\./derivations/)?(\d\d_\w+)\.py\)", r"](/generated/derivation-\1.md)", named)


def _rows(schema: dict[str, Any], within: str, named: dict[str, Any]) -> Iterator[str]:
    needed = schema.get("required", ())
    for key, value in schema.get("properties", {}).items():
        path = f"`{within}{key}`" if key in needed else f"*`{within}{key}`*"
        meant = named.get(value.get("$ref", "").rpartition("/")[2], {})
        told = value.get("description", meant.get("description", "")).replace("|", "\\|")
        yield f"| {path} | {_type(value)} | {told} |"
        inner = value if "properties" in value else value.get("items", {})
        if isinstance(inner, dict) and "properties" in inner and within.count(".") < 2:
            yield from _rows(inner, f"{within}{key}.", named)


def _type(value: dict[str, Any]) -> str:
    """In words."""
    if "$ref" in value:
        return str(value["$ref"].rpartition("/")[2])
    if "enum" in value:
        return ", ".join(f"`{json.dumps(x)}`" for x in value["enum"])
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "anyOf" in value:
        return " or ".join(dict.fromkeys(map(_type, value["anyOf"])))
    kinds = value.get("type", "any")
    kinds = [kinds] if isinstance(kinds, str) else kinds
    return " or ".join(f"list of {_type(value['items'])}" if x == "array" and "items" in value else x for x in kinds)
