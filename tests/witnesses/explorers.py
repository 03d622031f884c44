"""Reports of HTML without their drawings, which take seconds and change no word, and the explorer as a reader uses it."""

from __future__ import annotations

import json

from browser import Browser

from haptisym.judge.answers import Answer
from haptisym.writing.html import Html, html


def undrawn(answer: Answer) -> str:
    told = answer.to_dict()
    name = told["schema"].partition("/")[0].removeprefix("haptisym.")
    return html(answer.document(), lambda _: Html(), (name, json.dumps(told)), "Made by a test.")


def typed(opened: Browser, identity: str, value: str | float) -> None:
    """Replace the number in a box by another one, by the keyboard."""
    opened.value(f"(() => {{ const box = document.getElementById('{identity}-value'); box.focus(); box.select(); }})()")
    opened.call("Input.insertText", text=str(value))
