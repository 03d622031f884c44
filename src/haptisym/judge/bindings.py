"""What limits the allowed values of a parameter: a criterion that holds with equality at the end of
a set of values, and the frequency at which it does."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from haptisym.judge.crossings import Criterion, Judged
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber
from haptisym.model.catalogue import Hand


class Kind(Enum):
    """Where on the band a condition holds with equality."""

    EDGE = "band-edge"
    """At the band's high end."""
    START = "start"
    """At the band's low end."""
    TOUCH = "tangency"
    """Inside: a ratio touches its threshold there."""
    AXIS = "axis"
    """Roots of a display in a hand lie on the imaginary axis."""
    FAR = "far-out"
    """At frequencies without bound: a root comes from infinity, or a condition fails there
    first."""


@dataclass(frozen=True)
class Binding(Judged):
    """A condition that holds with equality at the end of a set of values: which one, and at which
    frequency, rad/s.

    ``omega``: None where the frequency of a degenerate tangency was not isolated.
    """

    criterion: Criterion
    omega: RealNumber | None
    kind: Kind


STABLE, STEADY = IN_HANDS = "stable", "steady"


def stable_in(hand: Hand, what: str = STABLE) -> Criterion:
    """The criterion that the display is stable in this hand, or, for ``STEADY``, that it does not
    oscillate while a drift is allowed. It has no function of frequency."""
    name = f"{what} in {hand.name}"
    return Criterion(what, name, "H_perc + Z_hand", name, _none, kept=name)


def _none(_: object) -> Any:
    raise SceneError("whether a display is stable in a hand is no condition at one frequency")
