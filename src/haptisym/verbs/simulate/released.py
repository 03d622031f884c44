"""What a release hands over: the run, the rate and frequency read from it, and those of the closed form."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.shown import titled
from haptisym.model.hand import Hand
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.simulate.pencil import Mode
from haptisym.verbs.simulate.rightmost import Rightmost
from haptisym.verbs.stability.held import Held

_FAST = 1e3  # rad/s
_NEAR = 1e-6  # relative: how well a mode is read at best


@dataclass(frozen=True)
class Closed:
    """The rightmost root of H_perc(s) + m s^2 + b s + k, as far as it is proven (``root.certified``).

    With a clock: ln z/T of the largest root z of the loop through controller, hold and what moves.
    """

    root: Rightmost

    @property
    def s(self) -> complex:
        """The root."""
        return self.root.s

    @property
    def rate(self) -> float:
        """1/s: > 0 grows."""
        return self.root.s.real

    @property
    def omega(self) -> float:
        """rad/s."""
        return self.root.s.imag

    @property
    def chain(self) -> float | None:
        """To which rate infinitely many roots tend, of a neutral system."""
        return self.root.function.chain if self.root.function else None

    @property
    def is_endless(self) -> bool:
        """Whether infinitely many roots lie, or end, right of all that are not fast: no one of them lasts longest."""
        chain = self.chain
        slow = [x.real for x in self.root.others if abs(x) < _FAST]
        return chain is not None and chain > max(slow, default=-inf) - _NEAR


@dataclass(frozen=True, eq=False, repr=False)
class Release(Answer):
    """A display that a hand held at ``displacement`` and let go. ``hand_motion`` and ``force`` over ``time``, s.

    ``fitted`` : what lasts longest in the motion, None where nothing is left to read; ``error`` its estimated error, 1/s.
    ``closed`` : the closed form's, None where it has no root, or that of a loop with a clock is not known. ``stopped`` : why the
    run ended early.
    ``approximate`` : why the closed form is not what was simulated; empty where it is. ``held`` : the certified verdict.
    """

    _schema: ClassVar[str] = "haptisym.release/1"
    _page: ClassVar[str] = "haptisym.pages.release:page"
    _figure: ClassVar[str] = "haptisym.figures.release:release_figure"

    scene: Scene
    hand: Hand
    displacement: float
    time: Array
    hand_motion: Array
    force: Array
    fitted: Mode | None
    error: float
    closed: Closed | None
    stopped: str
    built: tuple[str, ...]
    approximate: str
    held: Held

    def _line(self) -> str:
        told = {True: "grows", False: "dies away", None: "is left open"}[self.grows]
        return f"{titled(self.scene.title)} in {self.hand.name}, let go: {told}"

    @property
    def certified(self) -> bool:
        """False: what is read from a simulation is estimated."""
        return False

    @property
    def sign_agrees(self) -> bool | None:
        """Whether the motion grows exactly if the display is not stable in this hand; None where either is open."""
        near = (
            self.held.roots is not None and self.held.roots.chain is RootChain.NEAR
        )  # far beyond what a release moves
        return None if self.grows is None or self.held.stable is None or near else self.grows is not self.held.stable

    @property
    def unit(self) -> str:
        """Of the displacement."""
        return "rad" if self.scene.motion is Kind.ROTATION else "m"

    @property
    def grows(self) -> bool | None:
        """Whether the simulated motion grows; None where it neither grows nor dies away for certain."""
        if self.fitted is None:
            return False if self.stopped == "come to rest" else None
        return None if abs(self.fitted.rate) <= self.error else self.fitted.rate > 0

    @property
    def is_envelope(self) -> bool:
        """Whether what was read is the rate of the largest values: of a chain of infinitely many roots none lasts longest."""
        return self.closed is not None and self.closed.is_endless

    @property
    def agrees(self) -> bool | None:
        """Whether rate and frequency are the closed form's; None where there is none to compare with, or nothing to read.

        Of a chain of infinitely many roots it is the sign of the rate that is compared, where it is clear of 0.
        """
        if self.closed is None or self.fitted is None or self.approximate:
            return None
        if self.is_envelope:
            chain = self.closed.chain or 0.0
            return self.grows == (chain > 0) if abs(chain) > _NEAR and self.grows is not None else None
        return bool(abs(self.closed.s - self.fitted.s) <= 3 * self.error + _NEAR * abs(self.closed.s))

    def to_csv(self) -> str:
        """The run in time as a table, units in its header."""
        force = "N m" if self.unit == "rad" else "N"
        rows = (
            ",".join(map(repr, map(float, row))) for row in zip(self.time, self.hand_motion, self.force, strict=True)
        )
        return "\n".join([f"time [s],displacement [{self.unit}],force [{force}]", *rows]) + "\n"

    def _body(self) -> dict[str, Any]:
        fitted = self.fitted and {"rate": self.fitted.rate, "omega": self.fitted.omega, "error": self.error}
        return {
            "hand": {"name": self.hand.name, **{p.key: float(p.value) for p in self.hand.parameters}},
            "displacement": self.displacement,
            "time": [0.0, float(self.time[-1])],
            "samples": len(self.time),
            "built": list(self.built),
            "stopped": self.stopped or None,
            "grows": self.grows,
            "simulated": fitted,
            "closed": self._closed(),
            "held": self.held.stable,
            "agrees": self.agrees,
            **({"approximate": self.approximate} if self.approximate else {}),
        }

    def _closed(self) -> dict[str, Any] | None:
        if self.closed is None:
            return None
        rate, omega = self.closed.root.digits()
        found = {"rate": self.closed.rate, "omega": self.closed.omega, "digits": [rate, omega]}
        return {**found, "chain": self.closed.chain, "certified": self.closed.root.certified}
