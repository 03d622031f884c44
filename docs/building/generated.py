"""Pages of the site that are generated at every build from the package: options, schemas, derivations."""

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

import haptisym as hs
from haptisym.cli import VERBS, app
from haptisym.model.scenefile import scene_text
from haptisym.writing.schemas import json_schema, schema_names

Page = Callable[[], str]


def write(folder: Path) -> None:
    """Write all generated pages into a folder. An unchanged page keeps its date, so that Sphinx does not read it again."""
    import gallery

    folder.mkdir(exist_ok=True)
    pages: dict[str, Page] = {
        "verbs": verbs,
        "schemas": schemas,
        "thresholds": thresholds,
        "devices": devices,
        "derivations": derivations,
        "certificate-format": certificate_format,
        **api.PAGES,
    }
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
    """Return the page of every option: ``--help`` of each command."""
    helps = {"haptisym": _help(app, "haptisym")}
    with click.Context(app, info_name="haptisym") as context:
        for name in VERBS:
            command = app.get_command(context, name)
            assert command is not None
            helps[f"haptisym {name}"] = _help(command, name, context)
    blocks = [f"## {name}\n\n```text\n{text}\n```\n" for name, text in helps.items()]
    lead = "After this page you know every option of every command, as `--help` prints it. What they share is in [Command line](../command-line.md).\n"
    return "\n".join(["# Every option\n", lead, *blocks])


def _help(command: click.Command, name: str, parent: click.Context | None = None) -> str:
    with click.Context(command, info_name=name, parent=parent, max_content_width=96, terminal_width=96) as context:
        return command.get_help(context)


def schemas() -> str:
    """Return the page of JSON keys: a table for each document."""
    lead = (
        "After this page you know every key of every document of `--json`. Schemas are JSON Schema, 2020-12: "
        "`haptisym schemas NAME` prints one, `hs.json_schema(NAME)` returns it for a validator "
        "([Command line](../command-line.md#schemas)). Keys in *italics* are present only where they apply.\n"
    )
    return "\n".join(["# JSON keys\n", lead, *map(_schema, schema_names())])


def _schema(name: str) -> str:
    schema = json_schema(name)
    head = f"## {schema['title']}\n\n{schema['description']}\n\n| key | type | content |\n|---|---|---|"
    return "\n".join([head, *_rows(schema, "", schema.get("$defs", {})), ""])


def thresholds() -> str:
    """Return the page of published thresholds: a row for each, with how much of its source was read."""
    lead = (
        'After this page you can choose a published threshold by its name, `jnd = { like = "NAME" }`. '
        "[Evidence](../evidence.md#published-thresholds) compares them.\n"
    )
    head = "| name | JND | criterion | of what | reference | source | read |\n|---|---|---|---|---|---|---|"
    return "\n".join(["# Published thresholds\n", lead, head, *map(_threshold, hs.published()), ""])


def _threshold(x: hs.Published) -> str:
    criterion = f"{float(100 * x.criterion):g} %" if x.criterion else ""
    source = f"{x.source} [{x.doi}](https://doi.org/{x.doi})" if x.doi else x.source
    reference = f"{x.reference}; not for a scene: {x.apart}" if x.apart else x.reference
    cells = f"`{x.name}`", x.written, criterion, x.quantity, reference, source, x.read
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def devices() -> str:
    """Return the page of known devices: a row for each number, with its source and how much of it was read."""
    lead = (
        'After this page you can choose a device by its name, `[device]` with `like = "NAME"` ([scene files](../scenes.md)): the hand carries '
        "`m`, `b` and `friction`; `force`, `stiffness` and `damping` are the most that it renders. What was not read is not listed.\n"
    )
    head = "| device | number | value | source | read |\n|---|---|---|---|---|"
    rows = [
        f"| `{device.name}` | {key} | {x.written} | {x.source} | {x.read} |"
        for device in hs.devices.values()
        for key, x in device.numbers.items()
    ]
    return "\n".join(["# Devices\n", lead, head, *rows, ""])


def certificate_format() -> str:
    """Return the page of the format of certificates, which lies next to the checker."""
    return FORMAT.read_text(encoding="utf-8").replace("](../../docs/", "](../")


def derivations() -> str:
    """Return the page of derivations: the table of their folder, and its pages."""
    text = (DERIVATIONS / "README.md").read_text(encoding="utf-8")
    names = "\n".join(f"derivation-{path.stem}" for path in sorted(DERIVATIONS.glob("*.py")))
    return f"{linked(text)}\n```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{names}\n```\n"


def derivation(path: Path) -> str:
    """Return the page of a derivation: its text and its code. The tests run it."""
    script = path.read_text(encoding="utf-8")
    title = path.stem[3:].replace("_", " ").capitalize()
    lead = f"After this page you can repeat the derivation: `python derivations/{path.name}`. The tests run it.\n"
    claim = ast.get_docstring(ast.parse(script)) or ""
    parts = [text if kind == "markdown" else _code(text, claim) for kind, text in cells(script)]
    return "\n\n".join([f"# {title}\n", lead, _quoted(claim), *parts]) + "\n"


def _quoted(claim: str) -> str:
    """Return text verbatim."""
    return f"```text\n{claim}\n```\n"


def _code(text: str, claim: str) -> str:
    """Return a code cell, without the claim, which is above."""
    return f"```python\n{text}\n```" if claim[:60] not in text else ""


def scene_file(name: str) -> str:
    """Return the text of a shipped scene or family."""
    return scene_text(name)[0].rstrip()


DERIVATIONS = Path(__file__).parents[2] / "derivations"
FORMAT = Path(__file__).parents[2] / "src" / "haptisym_check" / "FORMAT.md"


def linked(text: str) -> str:
    """Point links to derivations to their pages, and replace links to other scripts by their names."""
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
    """Return the type of a JSON value in words."""
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
