"""Does it shake: whether a display is stable under imposed motion, in a hand, and in every passive hand."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from haptisym.kernel.errors import SceneError, meant
from haptisym.model.hand import Hand, hands
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.stability.answer import Stability
from haptisym.verbs.stability.held import held, imposed
from haptisym.verbs.stability.passive import every_passive_hand


def stability(
    scene: Scene | str | Path, hand: str | Hand | Iterable[str | Hand] | None = None, *, digits: int = 15
) -> Stability:
    """Whether a display is stable under imposed motion, in each hand, and in every passive hand: certified.

    ``hand`` : the hands to ask about: the scene's, or those that the package ships (``hs.hands``), by name, or each a ``Hand``;
    those of the scene if not given. ``digits`` : of each number in the document.

    What stays open is None, and the answer is then not certified. SceneError where a hand is not known, is given twice or turns
    about an axis where the scene moves along a line.

    >>> found = stability("delayed-spring", "light-touch")
    >>> found.imposed.stable, found.held[0].stable, found.every_passive_hand.holds
    (True, False, False)
    """
    scene = as_scene(scene)
    if not isinstance(digits, int) or digits < 1:
        raise SceneError(f"digits: {digits} must be a whole number, at least 1")
    if hand is not None:
        asked = [chosen(scene, x) for x in ([hand] if isinstance(hand, str | Hand) else hand)]
        for name in (x.name for i, x in enumerate(asked) if x.name in [y.name for y in asked[:i]]):
            raise SceneError(f'the hand "{name}" is asked about twice')
        scene = scene.with_hands(*asked)
    scene.knobs.need_numbers()
    rows = tuple(held(scene, x) for x in scene.hands)
    return Stability(scene, imposed(scene), rows, every_passive_hand(scene), digits)


def chosen(scene: Scene, given: str | Hand) -> Hand:
    """A hand by its name, the scene's own before one that the package ships."""
    if isinstance(given, Hand):
        return given
    own = {x.name: x for x in scene.hands}
    if given in own:
        return own[given]
    if given in hands:
        return hands[given]
    theirs = f"the scene has {', '.join(own)}; " if own else ""
    raise SceneError(
        f'there is no hand "{str(given)[:60]}": {meant(str(given), [*own, *hands])}{theirs}the package ships {", ".join(hands)}'
    )
