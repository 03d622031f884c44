"""The verb ``haptisym scenes``: what the package ships."""

from __future__ import annotations

import tomllib
from json import dumps

import click

from haptisym.commands.options import json_option, say_document, say_list, verb, write
from haptisym.kernel.errors import SceneError
from haptisym.model.shipped import family_names, scene_names, shipped_text


@verb(pages=False)
@click.argument("name", required=False)
@json_option
def scenes(name: str | None, as_json: bool) -> None:
    """List the shipped scenes, or print one to start from.

    \b
    Examples:
      haptisym scenes
      haptisym scenes fu2019 > my-device.toml
    """
    if name is not None:
        if as_json:
            raise SceneError("--json lists the scenes: a scene file is TOML, leave out --json")
        write(shipped_text(name) or _file(name))
        return
    listed = [(name, tomllib.loads(shipped_text(name) or "")) for name in (*scene_names(), *family_names())]
    if as_json:
        rows = [
            {
                "name": name,
                "title": x["title"],
                "source": x["source"],
                "effects": [e.get("name", e["model"]) for e in x.get("effects", ())],
                "environments": len(x.get("environments", [x])),
            }
            for name, x in listed
        ]
        say_document(dumps({"schema": "haptisym.scenes/1", "scenes": rows}, indent=2, ensure_ascii=False))
        return
    say_list("Scenes to start from", [(name, x["title"]) for name, x in listed])


def _file(name: str) -> str:
    from haptisym.model.scenefile import scene_text  # SymPy, which a list does not need

    return scene_text(name)[0]
