"""The certificate of an answer about stability: poles and roots in Re s >= 0, with a proof (docs/certificates.md)."""

from __future__ import annotations

from typing import Any

from haptisym.kernel.errors import SceneError
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.scenetables import read_scenes
from haptisym.verbs.evaluate.certificate import document, inverse, named
from haptisym.verbs.evaluate.products import NOT_RATIONAL
from haptisym.verbs.evaluate.zeros import zeros
from haptisym.verbs.stability.answer import Stability
from haptisym.verbs.stability.held import ring_of


def certificate(found: Stability) -> str:
    """The document of JSON. SceneError, a sentence, where the format has no room for the scene.

    >>> import json
    >>> from haptisym.verbs.stability.entry import stability
    >>> json.loads(certificate(stability("fu2019", "firm-grip")))["claim"]["held"][0]["unstable"]
    0
    """
    scene = found.scene
    if clocks(scene):
        raise SceneError(NOT_RATIONAL)
    perceived, environment = scene.closed.perc, named(scene)
    own = [x for one in read_scenes(scene.text).scenes.values() for x in one.hands]
    ring = ring_of(perceived)
    claim = {
        "question": "stability",
        "imposed": found.imposed.unstable,
        "held": [{"hand": _told(x.hand, own), "unstable": x.unstable} for x in found.held],
    }
    proof = {
        "imposed": zeros(inverse(perceived)),
        "held": [zeros((perceived + ring.convert(x.hand.Z)).reduced()) for x in found.held],
    }
    return document(scene, environment, claim, proof)


def _told(hand: Hand, own: list[Hand]) -> str | dict[str, Any]:
    """By its name where the scene file has it, else by its numbers."""
    numbers = {p.key: p.value for p in hand.parameters}
    if any(x.name == hand.name and {p.key: p.value for p in x.parameters} == numbers for x in own):
        return hand.name
    if not all(x.is_Rational for x in numbers.values()):
        raise SceneError(
            f"a certificate needs the hand {hand.name} in the scene file, or rational numbers for it in SI"
        )
    return {key: str(x) for key, x in numbers.items()}
