"""The command ``stability``: whether a display is stable under prescribed motion, in each hand, and
with any passive operator; and the certificate of such an answer.

The three are decided separately (``held``), then how far each parameter may go (``limits``), then
margins (``margins``). Proven, for the model as written; what is not is None, with a reason. Begin
with ``stability``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.judge.bindings import STABLE, STEADY, stable_in
from haptisym.judge.colgate import SampledPassivity
from haptisym.kernel.budget import SECONDS, limited, share, tick
from haptisym.kernel.dynamics import ring_of
from haptisym.kernel.errors import SceneError, several
from haptisym.kernel.objects import titled
from haptisym.kernel.reals import RealNumber, whole
from haptisym.kernel.sets import ValueSet
from haptisym.model.catalogue import Hand, how_to_give
from haptisym.model.scene import Knob, Scene, clocks, first_harmonics, in_hands
from haptisym.model.scenefile import as_scene, read_scenes
from haptisym.model.valueranges import ALLOWED
from haptisym.verbs.evaluate.certificate import document, inverse, name_in_file, zeros
from haptisym.verbs.evaluate.products import NOT_RATIONAL
from haptisym.verbs.stability.held import (
    EveryPassiveHand,
    HandsOfBox,
    Held,
    Imposed,
    every_passive_hand,
    held,
    imposed,
    whole_box,
)
from haptisym.verbs.stability.limitcycles import LimitCycle, cycle_caveats, limit_cycles
from haptisym.verbs.stability.limits import looked_at, open_beside, stable_values
from haptisym.verbs.stability.margins import Margins, margins

WALL = ("environment.k", "environment.b")
"""What is asked about a display with a clock, and what its plane shows."""
# The share of the time that is left which one parameter, or passivity, may take: so that one that
# is slow leaves time for the others.
_PART = 0.5


def has_plane(scene: Scene) -> bool:
    """Whether there is a plane to draw: of a hand, or with a clock of a wall of stiffness and
    damping."""
    return not clocks(scene) or {*WALL} <= {x.path for x in scene.knobs}


@dataclass(frozen=True, repr=False)
class Stability(Answer):
    """Three statements about a display, decided separately: under prescribed motion, in each hand,
    for any passive operator.

    Stable in a hand: H_perc(s) + m s^2 + b s + k has no zero in Re s >= 0; sampled: no pole of the
    loop has abs(z) >= 1. Stable for any passive operator: H_perc/s is positive real.

    ``imposed`` : under prescribed motion: ``stable``, ``unstable`` (number of poles). ``held`` :
    for each hand ``stable``,
    ``unstable``, ``shakes``, ``drifts`` (poles at 0, where nothing holds the handle in place).
    ``critical`` : for each hand, by the path of each free parameter, its values for which the
    display is stable, SI, with the pole at each end, rad/s: up to the ends next to the present
    value. ``margins`` : for each hand the factors, the delays and the angles of the rendered force
    for which it is stable; None where it is not, or that is undecided.
    ``boxes`` : in which part of a hand's ranges it is stable; None without ranges.
    ``every_passive_hand`` : passivity, with the active frequencies and the damping that
    compensates. ``digits`` : of JSON. ``scene`` : with the hands.

    Proven: all counts and limits, for the model as written. None is undecided; ``certified`` :
    nothing is.

    >>> import haptisym as hs
    >>> found = hs.stability("delayed-spring", "postural-arm", free=["tau"])
    >>> found.held[0].stable, found.every_passive_hand.holds, found.critical[0]["effects.delay.tau"]
    (True, False, <ValueSet 0 to 0.102549>)
    """

    _schema: ClassVar[str] = "haptisym.stability/1"
    _page: ClassVar[str] = "haptisym.pages.stability:page"
    _figure: ClassVar[str] = "haptisym.figures.stability:STABILITY"
    _certificate: ClassVar[str] = "haptisym.verbs.stability.entry:certificate"

    scene: Scene
    imposed: Imposed
    held: tuple[Held, ...]
    critical: tuple[Mapping[str, ValueSet], ...]
    boxes: tuple[HandsOfBox | None, ...]
    every_passive_hand: EveryPassiveHand
    margins: tuple[Margins | None, ...] = ()
    digits: int = 15
    limit_cycles: tuple[tuple[LimitCycle, ...] | None, ...] = ()
    """Of each hand, None where they are not known; estimated by the describing function of the one
    element that is not linear."""

    def _line(self) -> str:
        said = {None: "undecided", True: "holds", False: "does not hold"}
        rows = (
            ("imposed", self.imposed.stable),
            *((f"held in {x.hand.name}", x.stable) for x in self.held),
        )
        told = ", ".join(f"{what} {said[is_so]}" for what, is_so in rows)
        return (
            f"{titled(self.scene.title)}: {told}, every passive hand "
            f"{said[self.every_passive_hand.holds]}"
        )

    @property
    def sampled(self) -> SampledPassivity | None:
        """Colgate and Schenkel's condition of a sampled display; else None."""
        return self.every_passive_hand.sampled

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        held = all(x.is_decided for x in self.held)
        decided = self.imposed.stable is not None and held and self.every_passive_hand.is_decided
        knobs = self.scene.knobs
        left = [
            why
            for sets in self.critical
            for path, x in sets.items()
            for why in open_beside(knobs[path], x)
        ]
        open_boxes = any(x.reason for x in self.boxes if x)
        return (
            decided
            and not left
            and not open_boxes
            and not any(x.undecided for x in self.margins if x)
        )

    def _body(self) -> dict[str, Any]:
        together = zip(self.held, self.critical, self.boxes, self.margins, strict=True)
        rows = [self._held(*row) for row in together]
        for row, cycles in zip(rows, self.limit_cycles, strict=True):
            if cycles:
                row["limit_cycles"] = [x.row() for x in cycles]
        return {
            "imposed": self.imposed.row(),
            "held": rows,
            "every_passive_hand": self.every_passive_hand.row(self.digits),
            "sampled": None if self.sampled is None else self.sampled.row(self.digits),
            "certified": self.certified,
            **({"caveats": list(caveats)} if (caveats := self.caveats) else {}),
        }

    @property
    def caveats(self) -> tuple[str, ...]:
        """Sentences on what the describing functions in the scene leave out, and on limit cycles
        that are not known."""
        cycles = zip((x.hand.name for x in self.held), self.limit_cycles, strict=True)
        return (
            *first_harmonics(self.scene, in_hand=bool(self.held)),
            *cycle_caveats(self.scene, dict(cycles)),
        )

    def _held(
        self, x: Held, sets: Mapping[str, ValueSet], box: HandsOfBox | None, margin: Margins | None
    ) -> dict[str, Any]:
        reason = {"reason": x.reason} if x.reason else {}
        chain = {"chain": x.roots.chain.value} if x.roots and x.roots.chain else {}
        verdict = {
            "stable": x.stable,
            "shakes": x.shakes,
            "drifts": x.drifts,
            "unstable": x.unstable,
        }
        knobs = self.scene.knobs
        own: dict[str, Any] = {
            "hand": _hand(x.hand),
            **verdict,
            "critical": [
                row for path, values in sets.items() for row in self._critical(path, values)
            ],
            "margins": margin and margin.row(),
        }
        left = [
            {"path": path, "reason": why}
            for path, values in sets.items()
            for why in open_beside(knobs[path], values)
        ]
        left += (
            [{"path": f"margins.{name}", "reason": why} for name, why in margin.undecided]
            if margin
            else []
        )
        if box is not None:
            own["whole_box"] = box.share.value if box.share else None
            left += [{"path": x.hand.name, "reason": box.reason}] if box.reason else []
        ends = ((path, *looked_at(knobs[path], values)) for path, values in sets.items())
        looked = [
            {"path": path, "from": _end(low), "to": _end(high)}
            for path, low, high in ends
            if low or high
        ]
        own |= {"looked_at": looked} if looked else {}
        return own | ({"undecided": left} if left else {}) | chain | reason

    def _critical(self, path: str, values: ValueSet) -> Iterator[dict[str, Any]]:
        """The rows of a document for the ends of what is stable next to the present value."""
        for piece in values.feasible:
            for x in (x for x in piece.ends if x in values.ends):
                value = {
                    "value": float(x.value),
                    "digits": x.value.digits(self.digits),
                    "enclosure": list(x.value.enclosure(self.digits)),
                }
                omega = x.bindings[0].omega
                side = None if piece.is_single else "above" if x is piece.first else "below"
                yield {
                    "path": path,
                    **value,
                    "omega": None if omega is None else float(omega),
                    "stable_side": side,
                }


def _end(x: RealNumber | None) -> float | None:
    return None if x is None else float(x)


def _hand(x: Hand) -> dict[str, Any]:
    ranges = {p.key: [float(end) for end in p.interval] for p in x.parameters if p.interval}
    source = {"source": x.source} if x.source else {}
    return {
        "name": x.name,
        **{p.key: float(p.value) for p in x.parameters},
        **({"ranges": ranges} if ranges else {}),
        **source,
    }


def stability(
    scene: Scene | str | Path,
    hand: str | Hand | Iterable[str | Hand] | None = None,
    free: Iterable[str] = (),
    *,
    digits: int = 15,
    limit: float | None = SECONDS,
) -> Stability:
    """Whether a display is stable under prescribed motion, in each hand, and with any passive
    operator: proven.

    ``hand`` : the hands to ask about: the scene's, or those that the package ships (``hs.hands``),
    by name, or each a ``Hand``; those of the scene if not given. ``free`` : numbers by path or
    symbol; for each, and for the hand's own, it is found where what is stable ends next to the
    present value; if none is given, all numbers of the display, of a sampled one in a shorter
    search.
    ``digits`` : of each number in the document.
    ``limit`` : seconds of processor time after which the rest is undecided; None for none.
    Verdicts come first, then limits, then margins; LimitError where not even one verdict is there
    by then.

    What is undecided is None, and the answer is then not certified. SceneError where a hand is not
    known, is given twice or turns about an axis where the scene moves along a line.

    >>> found = stability("delayed-spring", "light-touch")
    >>> found.imposed.stable, found.held[0].stable, found.every_passive_hand.holds
    (True, False, False)
    """
    scene = as_scene(scene)
    digits = whole("digits", digits)
    scene = in_hands(scene, hand)
    scene.knobs.need_numbers()
    paths = (
        [free]
        if isinstance(free, str)
        else several("free", free, "give paths or symbols of numbers")
    )
    asked_of = [_number(scene, x) for x in scene.knobs.chosen(paths)]
    if not paths and scene.hands:
        asked_of = [x for x in scene.parameters if x.symbol not in scene.chain.harmonic_symbols]
    with limited(
        limit
    ) as budget:  # verdicts first: each part tells itself where the time for it is over
        under = imposed(scene)
        rows = tuple(held(scene, x) for x in scene.hands)
        with share(_PART):
            every = every_passive_hand(scene)
        if (
            budget.reached
            and under.stable is every.holds is None
            and not any(x.roots for x in rows)
        ):
            tick()  # nothing is known: LimitError
        boxes = tuple(whole_box(scene, x) for x in scene.hands)
        near = tuple(
            _critical(scene, x, asked_of, after=len(rows) - 1 - i) for i, x in enumerate(rows)
        )
        nearby = tuple(margins(scene, x.hand) if x.shakes is False else None for x in rows)
        cycles = tuple(limit_cycles(scene, x) for x in scene.hands)
        return Stability(scene, under, rows, near, boxes, every, nearby, digits, cycles)


def _number(scene: Scene, x: Knob) -> Knob:
    if x.parts:
        raise SceneError(
            f"{x.path} is a threshold, which moves no root: ask for a number of the display "
            f"or of the hand"
        )
    if x.symbol in scene.chain.harmonic_symbols:
        raise SceneError(
            f"{x.path}: a size in a describing function, which is set, not varied: write another "
            f"value into the scene (with_values), and ask again"
        )
    if not scene.hands:
        raise SceneError(f"{x.path}: its limits depend on the hand: {how_to_give()}")
    return x


def _critical(scene: Scene, x: Held, free: Iterable[Knob], *, after: int) -> dict[str, ValueSet]:
    """The stable values of the hand's own parameters and of those that were asked about, by path.

    ``after`` : how many hands still follow, which share the time that is left.
    """
    if x.roots is None:
        return {}
    own = [
        knob
        for knob in scene.knobs
        if knob.is_of_hand and knob.symbol in {p.symbol for p in x.hand.parameters}
    ]
    others = [knob for knob in free if not knob.is_of_hand]
    # Where the display drifts at its present value it is never stable: steady is asked for instead.
    criterion = stable_in(x.hand, STABLE if x.drifts == 0 else STEADY)
    found = dict[str, ValueSet]()
    numbers = [*own, *others]
    for i, knob in enumerate(numbers):
        # An equal share of the time that is left for each parameter still to come, of further
        # hands too, and one for the margins after them.
        left = len(numbers) * (1 + after) - i
        with share(1 / (left + 1)):
            found[knob.path] = stable_values(
                scene, x.hand, knob, ALLOWED[knob.rule], criterion, near=True
            )
    return found


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
    name_in_file(scene)
    perceived = scene.closed.perc
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
    return document(scene, claim, proof)


def _told(hand: Hand, own: list[Hand]) -> str | dict[str, Any]:
    """A hand as the certificate names it: by its name where the scene file has it, else by its
    numbers. SceneError where these are not rational."""
    numbers = {p.key: p.value for p in hand.parameters}
    if any(x.name == hand.name and {p.key: p.value for p in x.parameters} == numbers for x in own):
        return hand.name
    if not all(x.is_Rational for x in numbers.values()):
        raise SceneError(
            f"a certificate needs the hand {hand.name} in the scene file, or rational "
            f"numbers for it in SI"
        )
    return {key: str(x) for key, x in numbers.items()}
