"""The certificate on a page, with a program that proves it anew where the page is read."""

from __future__ import annotations

import json
import tomllib
from importlib.resources import files

from haptisym.judge.answers import Answer
from haptisym.kernel.errors import HaptisymError
from haptisym.writing.htmltext import Html, data, element, joined, script


def has_certificate(answer: Answer) -> bool:
    """Whether there is one."""
    try:
        answer.certificate()
    except HaptisymError:
        return False
    return True


def checked(answer: Answer, text: str) -> Html:
    """Certificate, scene file, checker, and where it says what it found; where there is none, why. ``text`` : of the scene."""
    try:
        proof = answer.certificate()
    except HaptisymError as error:
        return element("p", f"This page carries no certificate: {str(error).removeprefix('a certificate: ')}.")
    note = (
        "This page carries a certificate, the scene's file, and a program that shares no line with haptisym. That program proves "
        "the certificate anew in your browser, and compares it with the table of crossings above."
    )
    found = element("p", "Not checked here: that needs JavaScript.", given={"id": "checked", "role": "status"})
    catalogue = tomllib.loads((files("haptisym_check") / "catalogue.toml").read_text(encoding="utf-8"))
    own = files("haptisym") / "data"
    return joined([
        element("p", note), found,
        data(json.dumps(proof), "certificate"), data(json.dumps(text), "certificate-scene"),
        data(json.dumps(catalogue), "certificate-catalogue"),
        *(script((own / name).read_text(encoding="utf-8")) for name in ("checker.js", "checked.js")),
    ])  # fmt: skip
