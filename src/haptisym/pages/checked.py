"""The certificate on a page, with a program that proves it anew where the page is read, if the scene is rational.

That program is ``data/checker.js``: it is for quotients of polynomials alone. Whatever else has a certificate is checked by
``python -m haptisym_check``, and the page says so.
"""

from __future__ import annotations

import json
import tomllib
from importlib.resources import files

from haptisym.judge.answers import Answer
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import HaptisymError
from haptisym.model.scene import Scene
from haptisym.verbs.evaluate.certificate import has_broken_powers, name_in_file
from haptisym.verbs.stability.held import ring_of
from haptisym.writing.html import Html, data, element, joined, script


def is_provable(e: Evaluation) -> bool:
    """Whether the page's checker can find the crossings anew, at other values too: of a rational scene as its file has it."""
    ring = ring_of(e.distortion.difference)
    if e.relevance or ring.lags or ring.orders or has_broken_powers(e.scene.text):
        return False
    try:
        name_in_file(e.scene)
    except HaptisymError:
        return False
    return True


def checked(answer: Answer, scene: Scene) -> Html:
    """Certificate, scene file, checker, and where it says what it found; where there is none, why."""
    checker = _checker(scene) if isinstance(answer, Evaluation) and is_provable(answer) else []
    try:
        certificate = answer.certificate()
    except HaptisymError as error:
        none = element("p", f"This page carries no certificate: {str(error).removeprefix('a certificate: ')}.")
        return joined([none, *checker])
    proof = json.loads(certificate)["proof"]
    if proof.get("delays") or proof.get("orders") or has_broken_powers(scene.text):
        return element("p", "The scene is not rational: its certificate (", element("code", "--certificate FILE"),
                       ") is checked with ", element("code", "python -m haptisym_check FILE SCENE.toml"), ".")  # fmt: skip
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
    own = data(json.dumps(certificate), "certificate")
    return joined([element("p", note), found, own, *(checker or _checker(scene)), _script("checked.js")])


def _checker(scene: Scene) -> list[Html]:
    """What finds crossings anew, and what it reads."""
    catalogue = tomllib.loads((files("haptisym_check") / "catalogue.toml").read_text(encoding="utf-8"))
    own = data(json.dumps(scene.text), "certificate-scene")
    return [own, data(json.dumps(catalogue), "certificate-catalogue"), _script("scene.js"), _script("checker.js")]


def _script(name: str) -> Html:
    return script((files("haptisym") / "data" / name).read_text(encoding="utf-8"))
