"""The certificate on a page, with a program that proves it anew where the page is read."""

from __future__ import annotations

import json
import tomllib
from importlib.resources import files

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import HaptisymError
from haptisym.verbs.evaluate.certificate import named_in_file
from haptisym.verbs.stability.held import ring_of
from haptisym.writing.htmltext import Html, data, element, joined, script


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
    if e.scene.threshold.is_plain:
        return not ring_of(e.distortion.difference).lags
    return not (e.relevance or e.distortion.difference.ring.functions)


def checked(e: Evaluation) -> Html:
    """Certificate, scene file, checker, and where it says what it found; where there is none, why."""
    try:
        proof = e.certificate()
    except HaptisymError as error:
        none = element("p", f"This page carries no certificate: {str(error).removeprefix('a certificate: ')}.")
        return joined([none, *(_checker(e) if is_provable(e) else ())])
    note = (
        "This page carries a certificate, the scene's file, and a program that shares no line with haptisym. That program proves "
        "the certificate anew in your browser, and compares it with the table of crossings above."
    )
    found = element("p", "Not checked here: that needs JavaScript.", given={"id": "checked", "role": "status"})
    return joined([
        element("p", note), found, data(json.dumps(proof), "certificate"), *_checker(e), _script("checked.js"),
    ])  # fmt: skip


def _checker(e: Evaluation) -> list[Html]:
    """What finds crossings anew, and what it reads."""
    catalogue = tomllib.loads((files("haptisym_check") / "catalogue.toml").read_text(encoding="utf-8"))
    scene = data(json.dumps(e.scene.text), "certificate-scene")
    return [scene, data(json.dumps(catalogue), "certificate-catalogue"), _script("checker.js")]


def _script(name: str) -> Html:
    return script((files("haptisym") / "data" / name).read_text(encoding="utf-8"))
