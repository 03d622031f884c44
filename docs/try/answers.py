"""What the page asks of haptisym, in the worker: a question in, a document of JSON out. It runs in any Python."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import Any

import haptisym as hs
from haptisym.judge.answers import Answer
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import LimitError
from haptisym.model.quantities import MotionKind
from haptisym.model.scenefile import scene_text
from haptisym.pages.explorer import explorer
from haptisym.pages.scene import SceneForms
from haptisym.writing.html import fragment
from haptisym_check import RefusedError, UnreadableError, check

LIMIT = 120.0
"""Seconds (in a browser of the wall clock) after which a question prints what it has so far."""
ON_PAGE = {
    r"<p>Next: .*?</p>": "",
    r"none given: --hand NAME; the package ships": "none given: choose one below, or write [hand] in the scene; there are",
    r"; see <code>haptisym tolerances</code>": "; its ranges are for the command line",
    r"; for all values in the region: <code>haptisym tolerances</code>": "; its ranges are for the command line",
    r"see <code>haptisym derive</code>": "see the formulas that are derived below",
    r"haptisym stability decides (that|that loop) in a hand": r"the question about a hand, below, decides \1",
    r"a hand closes the loop \(haptisym stability\)": "a hand closes the loop (the question about a hand, below)",
    r", haptisym simulate runs the loop|; haptisym\.verify compares them with independent evaluations": "",
    r"; --of [^.;]*prints (it|one)(?=\.)|; --of &quot;[^.]*?&quot; prints (it|one)(?=\.)": "",
    r" --of prints one of: [^.]*\.": "",
    r" \(with_values in Python; haptisym compare [^)]*\)": "",
    r"in --json": "in the JSON",
    r"this needs NumPy[^<]*": "this needs NumPy, which the page lacks; install haptisym and ask its command line",
    r"this scene is measured: [^<]*|a table of lines, not a scene: [^<]*": "the page does not take measured responses; install "
    "haptisym, and haptisym evaluate SCENE.toml judges them",
    r"; a longer limit may decide it": "; on the command line a longer limit may decide it",
}
"""What answers say of the command line, and what that is on the page."""


def answer(question: str, told: Callable[[str], object] | None = None) -> str:
    """The answer to ``{"ask": ..., "scene": ...}``, or what is wrong: ``{"error": ...}``; ``told`` : of how far the work is."""

    def tell(done: float, total: float | None, what: str) -> None:
        if told and what:
            told(f"{done:g}{f' of {total:g}' if total else ''} {what}")

    try:
        asked = json.loads(question)
        with limited(LIMIT, tell):
            return json.dumps(ASKED[asked.pop("ask")](**asked))
    except hs.HaptisymError as error:
        return json.dumps({"error": _on_page(str(error))})


def listed() -> dict[str, Any]:
    """What there is to choose from."""
    return {"scenes": {name: scene_text(name)[0] for name in (*hs.scene_names(), *hs.family_names())}}


def evaluate(scene: str, environment: str = "") -> dict[str, Any]:
    """The evaluation, the explorer of one environment, the paths that ``require`` takes, and hands that fit."""
    family = hs.parse_scenes(scene)
    found = _asked(family, hs.evaluate) if len(family) == 1 else hs.evaluate_all(family)
    e = found.answers.get(environment, next(iter(found.answers.values()))) if len(family) > 1 else found
    paths = [{x.path for x in own.knobs.all} for own in family.scenes.values()]
    shown = _shown(found)
    return {
        **shown, **_parted(shown["html"]), "explorer": explorer(e, SceneForms(e)),
        "environments": list(family) if len(family) > 1 else [],
        "paths": [x.path for x in family.first.knobs.all if all(x.path in own for own in paths)],
        "hands": [] if family.first.motion is MotionKind.ROTATION else list(hs.hands),
    }  # fmt: skip


def stability(scene: str, hand: str = "", limit: float = LIMIT) -> dict[str, Any]:
    """In a hand, or in those of the scene; ``partial``: something was left undecided within the limit."""
    try:
        found = _asked(hs.parse_scenes(scene), lambda x: hs.stability(x, hand or None, limit=limit))
    except LimitError:
        if limit == LIMIT:
            raise
        return {"html": "", "partial": True}
    return {**_shown(found), "partial": not found.certified}


def require(scene: str, path: str) -> dict[str, Any]:
    """All values of a parameter for which nothing is noticed."""
    return _shown(_asked(hs.parse_scenes(scene), lambda x: hs.require(x, path, limit=LIMIT)))


def derive(scene: str) -> dict[str, Any]:
    """The closed forms."""
    return _shown(_asked(hs.parse_scenes(scene), hs.derive))


def certificate(scene: str) -> dict[str, Any]:
    """To save."""
    family = hs.parse_scenes(scene)
    if len(family) > 1:
        raise hs.SceneError("a certificate is about one environment: leave one in the scene")
    return {"text": hs.evaluate(family.first).certificate()}


def checked(scene: str, proof: str) -> dict[str, Any]:
    """What the checker says of a certificate."""
    try:
        return {"said": check(proof.encode(), scene.encode()), "proven": True}
    except (RefusedError, UnreadableError) as error:
        return {"said": f"NOT proven: {error}", "proven": False}


def _asked(family: hs.SceneFamily, question: Callable[[hs.Scene], Any]) -> Any:
    """The answer about the one scene, or one for each environment."""
    return question(family.first) if len(family) == 1 else hs.answer_each(family, question)


def _shown(found: Answer) -> dict[str, Any]:
    html = fragment(found.document(), formulas=True).replace("h2>", "h3>").replace("<h2", "<h3")
    return {"html": _on_page(html), "json": found.to_json()}


def _parted(html: str) -> dict[str, str]:
    """The lines of an answer, and what stands below the figures."""
    head, opened = '<div class="haptisym">', html.partition('<dl class="findings">')[1]
    lines, end, rest = html.partition("</dl>")
    return {"lines": f"{lines}{end}</div>", "html": head + rest} if opened else {"lines": "", "html": html}


def _on_page(text: str) -> str:
    for words, own in ON_PAGE.items():
        text = re.sub(words, own, text)
    return text


ASKED = {
    "listed": listed,
    "evaluate": evaluate,
    "stability": stability,
    "require": require,
    "derive": derive,
    "certificate": certificate,
    "checked": checked,
}
