"""The certificate on a page, with a program that proves it anew where the page is read."""

from __future__ import annotations

import json
import tomllib
from importlib.resources import files

from haptisym.judge.answers import Answer
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import HaptisymError
from haptisym.model.scene import Scene
from haptisym.verbs.evaluate.certificate import named_in_file
from haptisym.verbs.stability.held import ring_of
from haptisym.writing.html import Html, data, element, joined, script


def is_provable(e: Evaluation) -> bool:
    """Whether the page's checker can find the crossings anew: with a certificate, or of a rational scene whatever its JND."""
    try:
        if e.scene.threshold.is_plain:
            e.certificate()
        else:
            named_in_file(e.scene)
            if e.scene.threshold.ranges:
                return False
    except HaptisymError:
        return False
    ring = ring_of(e.distortion.difference)
    if e.scene.threshold.is_plain:
        return not ring.lags and not ring.orders
    return not (e.relevance or ring.functions)


def checked(answer: Answer, scene: Scene) -> Html:
    """Certificate, scene file, checker, and where it says what it found; where there is none, why."""
    can_move = isinstance(answer, Evaluation) and is_provable(answer)
    try:
        proof = answer.certificate()
    except HaptisymError as error:
        none = element("p", f"This page carries no certificate: {str(error).removeprefix('a certificate: ')}.")
        return joined([none, *(_checker(scene) if can_move else ())])
    told = (
        "the table of crossings above"
        if isinstance(answer, Evaluation)
        else "the answer that this page carries as JSON"
    )
    note = (
        "This page carries a certificate, the scene's file, and a program that shares no line with haptisym. That program proves "
        f"the certificate anew in your browser, and compares it with {told}."
    )
    found = element("p", "Not checked here: that needs JavaScript.", given={"id": "checked", "role": "status"})
    return joined([
        element("p", note), found, data(json.dumps(proof), "certificate"), *_checker(scene), _script("checked.js"),
    ])  # fmt: skip


def _checker(scene: Scene) -> list[Html]:
    """What finds crossings anew, and what it reads."""
    catalogue = tomllib.loads((files("haptisym_check") / "catalogue.toml").read_text(encoding="utf-8"))
    own = data(json.dumps(scene.text), "certificate-scene")
    return [own, data(json.dumps(catalogue), "certificate-catalogue"), _script("checker.js")]


def _script(name: str) -> Html:
    return script((files("haptisym") / "data" / name).read_text(encoding="utf-8"))
