"""Does it shake: whether a display is stable under imposed motion, in a hand, and in every passive hand."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.counts import whole
from haptisym.kernel.errors import SceneError, meant, several
from haptisym.model.caveats import clocks
from haptisym.model.hand import NOBODY, Hand, hands, how_to_give
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.stability.answer import WALL, Stability
from haptisym.verbs.stability.boxes import whole_box
from haptisym.verbs.stability.critical import Nearest, critical
from haptisym.verbs.stability.held import Held, held, imposed
from haptisym.verbs.stability.passive import every_passive_hand


def stability(
    scene: Scene | str | Path,
    hand: str | Hand | Iterable[str | Hand] | None = None,
    free: Iterable[str] = (),
    *,
    digits: int = 15,
    limit: float | None = SECONDS,
) -> Stability:
    """Whether a display is stable under imposed motion, in each hand, and in every passive hand: certified.

    ``hand`` : the hands to ask about: the scene's, or those that the package ships (``hs.hands``), by name, or each a ``Hand``;
    those of the scene if not given. ``free`` : numbers by path or symbol; for each, and for the hand's own, the nearest
    values are found at which the number of unstable roots changes; of a display with a clock, if none is given, those of the
    environment's stiffness and damping, which is what such a wall is asked about. ``digits`` : of each number in the document.
    ``limit`` : seconds after which what is not decided stays open; None for none.

    What stays open is None, and the answer is then not certified. SceneError where a hand is not known, is given twice or turns
    about an axis where the scene moves along a line.

    >>> found = stability("delayed-spring", "light-touch")
    >>> found.imposed.stable, found.held[0].stable, found.every_passive_hand.holds
    (True, False, False)
    """
    scene = as_scene(scene)
    digits = whole("digits", digits)
    scene = in_hands(scene, hand)
    scene.knobs.need_numbers()
    paths = [free] if isinstance(free, str) else several("free", free, "give paths or symbols of numbers")
    if not paths and scene.hands and clocks(scene):
        paths = [x.path for x in scene.knobs if x.path in WALL]
    asked_of = [_number(scene, x) for x in scene.knobs.chosen(paths)]
    with limited(limit):
        rows = tuple(held(scene, x) for x in scene.hands)
        near = tuple(_critical(scene, x, asked_of) for x in rows)
        boxes = tuple(whole_box(scene, x) for x in scene.hands)
        return Stability(scene, imposed(scene), rows, near, boxes, every_passive_hand(scene), digits)


def in_hands(scene: Scene, hand: str | Hand | Iterable[str | Hand] | None) -> Scene:
    """The scene in the hands that are asked about; as it is where none is. SceneError for one that is unknown, or there twice."""
    if hand is None:
        return scene
    asked = [
        chosen(scene, x)
        for x in ([hand] if isinstance(hand, str | Hand) else several("hand", hand, "give a name, a Hand, or several"))
    ]
    for name in (x.name for i, x in enumerate(asked) if x.name in [y.name for y in asked[:i]]):
        raise SceneError(f'the hand "{name}" is asked about twice')
    return scene.with_hands(*asked)


def _number(scene: Scene, x: Knob) -> Knob:
    if x.parts:
        raise SceneError(
            f"{x.path} is a threshold, which moves no root: ask for a number of the display or of the hand"
        )
    if not scene.hands:
        raise SceneError(f"{x.path}: how far it may go depends on the hand: {how_to_give()}")
    return x


def _critical(scene: Scene, x: Held, free: Iterable[Knob]) -> tuple[Nearest, ...]:
    """Of the hand's own numbers, and of those that were asked about."""
    if x.roots is None:
        return ()
    own = [knob for knob in scene.knobs if knob.is_of_hand and knob.symbol in {p.symbol for p in x.hand.parameters}]
    others = [knob for knob in free if not knob.is_of_hand]
    return tuple(critical(scene, x.hand, knob) for knob in (*own, *others))


def chosen(scene: Scene, given: str | Hand) -> Hand:
    """A hand by its name, the scene's own before one that the package ships; "none" is one that holds nothing."""
    if isinstance(given, Hand):
        return given
    own = {x.name: x for x in scene.hands}
    if given in own:
        return own[given]
    if given in hands:
        return hands[given]
    if given == NOBODY:
        return Hand(NOBODY)
    theirs = f"the scene has {', '.join(own)}; " if own else ""
    listed = f"{theirs}the package ships {', '.join(hands)}, and {NOBODY} is no hand"
    raise SceneError(f'there is no hand "{str(given)[:60]}": {meant(str(given), [*own, *hands])}{listed}')
