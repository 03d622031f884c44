"""Reports of HTML without their drawings, which take seconds and change no word."""

from __future__ import annotations

import json

from haptisym.judge.answers import Answer
from haptisym.writing.html import Html, html


def undrawn(answer: Answer) -> str:
    told = answer.to_dict()
    name = told["schema"].partition("/")[0].removeprefix("haptisym.")
    return html(answer.document(), lambda _: Html(), (name, json.dumps(told)), "Made by a test.")
