"""What the page asks of haptisym, in the worker: a question in, a document of JSON out. It runs in any Python."""

from __future__ import annotations

import json
from typing import Any

import haptisym as hs
from haptisym.judge.answers import Answer
from haptisym.model.scenefile import scene_text
from haptisym.pages.explorer import explorer
from haptisym.pages.scene import SceneForms
from haptisym.writing.html import fragment
from haptisym_check import RefusedError, UnreadableError, check

LIMIT = 120.0
"""Seconds after which a requirement says what it has so far."""


def answer(question: str) -> str:
    """The answer to ``{"ask": ..., "scene": ...}``, or what is wrong: ``{"error": ...}``."""
    try:
        asked = json.loads(question)
        return json.dumps(ASKED[asked.pop("ask")](**asked))
    except hs.HaptisymError as error:
        return json.dumps({"error": str(error)})


def listed() -> dict[str, Any]:
    """What there is to choose from."""
    return {"scenes": {name: scene_text(name)[0] for name in hs.scene_names()}, "hands": list(hs.hands)}


def evaluate(scene: str) -> dict[str, Any]:
    """The evaluation, its explorer, and the paths that ``require`` takes."""
    e = hs.evaluate(hs.parse_scene(scene))
    return {
        **_shown(e), "explorer": explorer(e, SceneForms(e), proving=False),
        "paths": [x.path for x in e.scene.knobs.all],
    }  # fmt: skip


def stability(scene: str, hand: str = "") -> dict[str, Any]:
    """In a hand, or in those of the scene."""
    return _shown(hs.stability(hs.parse_scene(scene), hand or None))


def require(scene: str, path: str) -> dict[str, Any]:
    """All values of a parameter for which nothing is noticed."""
    return _shown(hs.require(hs.parse_scene(scene), path, limit=LIMIT))


def certificate(scene: str) -> dict[str, Any]:
    """To save."""
    return {"text": hs.evaluate(hs.parse_scene(scene)).certificate()}


def checked(scene: str, proof: str) -> dict[str, Any]:
    """What the checker says of a certificate."""
    try:
        return {"said": check(proof.encode(), scene.encode()), "proven": True}
    except (RefusedError, UnreadableError) as error:
        return {"said": f"NOT proven: {error}", "proven": False}


def _shown(found: Answer) -> dict[str, Any]:
    return {
        "html": fragment(found.document(), formulas=True).replace("h2>", "h3>").replace("<h2", "<h3"),
        "json": found.to_json(),
    }


ASKED = {
    "listed": listed,
    "evaluate": evaluate,
    "stability": stability,
    "require": require,
    "certificate": certificate,
    "checked": checked,
}
