"""Whether a display shakes, as an answer: imposed, held, every passive hand, each said apart."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.judge.colgate import SampledPassivity
from haptisym.kernel.shown import titled
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.scene import Scene
from haptisym.verbs.stability.boxes import Box
from haptisym.verbs.stability.critical import Critical, Nearest
from haptisym.verbs.stability.held import Held, Imposed
from haptisym.verbs.stability.passive import EveryPassiveHand

WALL = ("environment.k", "environment.b")
"""What is asked about a display with a clock, and what its plane shows."""


def has_plane(scene: Scene) -> bool:
    """Whether there is a plane to draw: of a hand, or with a clock of a wall of stiffness and damping."""
    return not clocks(scene) or {*WALL} <= {x.path for x in scene.knobs}


@dataclass(frozen=True, repr=False)
class Stability(Answer):
    """Three statements about a display, that are never mixed.

    ``imposed`` : the force under imposed motion is stable. ``held`` : it is stable in this hand, for each hand, and whether it
    shakes, which a handle that nothing holds in place need not: it drifts; ``critical`` : for each hand, and each number that
    was asked about, the nearest values at which the number of roots that shake changes.
    ``boxes`` : of each hand with ranges, in which of its hands it is stable. ``every_passive_hand`` : it is stable in every one.
    ``scene`` : with the hands that were asked about.
    """

    _schema: ClassVar[str] = "haptisym.stability/1"
    _page: ClassVar[str] = "haptisym.pages.stability:page"
    _figure: ClassVar[str] = "haptisym.figures.stability:stability_figure"
    _certificate: ClassVar[str] = "haptisym.verbs.stability.certificate:certificate"

    scene: Scene
    imposed: Imposed
    held: tuple[Held, ...]
    critical: tuple[tuple[Nearest, ...], ...]
    boxes: tuple[Box | None, ...]
    every_passive_hand: EveryPassiveHand
    digits: int = 15

    def _line(self) -> str:
        said = {None: "undecided", True: "holds", False: "does not hold"}
        rows = (("imposed", self.imposed.stable), *((f"held in {x.hand.name}", x.stable) for x in self.held))
        told = ", ".join(f"{what} {said[is_so]}" for what, is_so in rows)
        return f"{titled(self.scene.title)}: {told}, every passive hand {said[self.every_passive_hand.holds]}"

    @property
    def sampled(self) -> SampledPassivity | None:
        """With a clock, Colgate and Schenkel's condition."""
        return self.every_passive_hand.sampled

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        held = all(x.is_decided for x in self.held)
        decided = self.imposed.stable is not None and held and self.every_passive_hand.is_decided
        left = [x.reason for rows in self.critical for x in rows] + [x.reason for x in self.boxes if x]
        return decided and not any(left)

    def _body(self) -> dict[str, Any]:
        return {
            "imposed": {"stable": self.imposed.stable, "unstable": self.imposed.unstable},
            "held": [self._held(*row) for row in zip(self.held, self.critical, self.boxes, strict=True)],
            "every_passive_hand": self.every_passive_hand.row(self.digits),
            "sampled": None if self.sampled is None else self.sampled.row(self.digits),
            "certified": self.certified,
        }

    def _held(self, x: Held, rows: tuple[Nearest, ...], box: Box | None) -> dict[str, Any]:
        reason = {"reason": x.reason} if x.reason else {}
        chain = {"chain": x.roots.chain.value} if x.roots and x.roots.chain else {}
        critical = [self._critical(found) for near in rows for found in near.found]
        left = [{"path": near.path, "reason": near.reason} for near in rows if near.reason]
        verdict = {"stable": x.stable, "shakes": x.shakes, "drifts": x.drifts, "unstable": x.unstable}
        own: dict[str, Any] = {"hand": _hand(x.hand), **verdict, "critical": critical}
        if box is not None:
            own["whole_box"] = box.share.value if box.share else None
            left += [{"path": x.hand.name, "reason": box.reason}] if box.reason else []
        looked = [
            {"path": y.path, "from": _end(y.low), "to": _end(y.high)}
            for y in rows
            if y.low is not None or y.high is not None
        ]
        own |= {"looked_at": looked} if looked else {}
        return own | ({"undecided": left} if left else {}) | chain | reason

    def _critical(self, x: Critical) -> dict[str, Any]:
        value = {
            "value": float(x.value),
            "digits": x.value.digits(self.digits),
            "enclosure": list(x.value.enclosure(self.digits)),
        }
        omega = None if x.omega is None else float(x.omega)
        return {"path": x.path, **value, "omega": omega, "stable_side": x.stable_side}


def _end(x: Fraction | None) -> float | None:
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
