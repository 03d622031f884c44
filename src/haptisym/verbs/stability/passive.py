"""Every passive hand: whether H_perc/s is positive real, where the display is active, and the damping that stops it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from haptisym.judge.colgate import SampledPassivity
from haptisym.judge.passivity import Beyond, Passivity, passivity
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import RealNumber
from haptisym.model.scene import Scene


@dataclass(frozen=True)
class EveryPassiveHand:
    """Whether every passive hand holds the display, by its ``passivity``; None where that stayed open, for the ``reason``.

    ``sampled`` : with a clock Colgate and Schenkel's condition, which then decides, but where Im H_perc < 0 tells already.
    """

    passivity: Passivity | None
    reason: str = ""
    sampled: SampledPassivity | None = None

    @property
    def holds(self) -> bool | None:
        """Of H_perc/s: positive real; with a clock, Colgate and Schenkel's condition."""
        return None if self.passivity is None else self.passivity.holds

    @property
    def is_decided(self) -> bool:
        """Whether both that and b* were decided."""
        p = self.passivity
        if self.sampled is not None:
            return self.holds is not None
        return p is not None and p.holds is not None and (p.damping is not None or p.is_unbounded)

    def row(self, digits: int) -> dict[str, Any]:
        """As documents have it."""
        p = self.passivity
        if self.sampled is not None:
            return self._sampled(self.sampled, digits)
        if p is None:
            return {"holds": None, "active": [], **_number(None, digits), "omega": None, "reason": self.reason}
        found = p.row()
        best = p.damping
        omega = float(best.omega) if best and best.omega is not None else None
        key = {Beyond.AGAIN: "active_again_beyond", Beyond.LATE: "not_looked_at_beyond"}.get(p.beyond)
        again = {key: found["reach"]} if key else {}
        why = {"reason": p.beyond.value} if p.holds is None and p.beyond is not Beyond.NEVER else {}
        number = _number(best.value if best else None, digits)
        own = {"holds": p.holds, "active": found["active"], **number, "omega": omega, "poles_allow": p.poles_allow}
        return own | again | why

    def _sampled(self, x: SampledPassivity, digits: int) -> dict[str, Any]:
        """With a clock: ``active`` below its Nyquist frequency, for imposed motion."""
        theta = x.needed.omega if x.needed else None
        omega = None if theta is None or x.hand_needed is None or self.holds else float(theta) / float(x.T)
        active = self.passivity.row()["active"] if self.passivity else []
        return {"holds": self.holds, "active": active, **_number(x.hand_needed, digits), "omega": omega}


def _number(x: RealNumber | None, digits: int) -> dict[str, Any]:
    return {"damping": None if x is None else float(x), "digits": None if x is None else x.digits(digits)}


def every_passive_hand(scene: Scene) -> EveryPassiveHand:
    """Whether a display is stable in every passive hand: the one place where that is decided."""
    try:
        found = passivity(scene)
        sampled = found.sampled
        # what either asks may stay open
        _ = (found.holds, found.damping) if sampled is None else (found.holds, sampled.hand_needed)
    except UndecidedError as error:
        return EveryPassiveHand(None, str(error))
    return EveryPassiveHand(found, sampled.reason if sampled else "", sampled)
