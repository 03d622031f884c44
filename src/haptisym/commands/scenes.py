"""The verb ``haptisym scenes``: what the package ships."""

from __future__ import annotations

from json import dumps

import click

from haptisym.commands.options import json_option, say, say_document, verb, write
from haptisym.kernel.errors import SceneError
from haptisym.model.scenefile import family_names, load_scenes, scene_names, scene_text


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
        write(scene_text(name)[0])
        return
    listed = [(name, load_scenes(name)) for name in (*scene_names(), *family_names())]
    if as_json:
        keys = [(name, x.title, x.source, [e.name for e in x.first.effects], len(x)) for name, x in listed]
        rows = [dict(zip(("name", "title", "source", "effects", "environments"), row, strict=True)) for row in keys]
        say_document(dumps({"schema": "haptisym.scenes/1", "scenes": rows}, indent=2, ensure_ascii=False))
        return
    from haptisym.writing.document import Document, Facts

    say(Document("Scenes to start from", (), (Facts(tuple((name, x.title) for name, x in listed)),)))
