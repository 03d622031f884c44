"""What a simulation hands over: the run itself, H_perc as recovered from it, and both as a document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.kernel.objects import counted, titled
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.simulate.motions import Motion


@dataclass(frozen=True)
class EncoderQuantisation:
    """The display measures the hand's motion only in whole multiples of ``resolution``, m or rad (or with a unit)."""

    resolution: Number


@dataclass(frozen=True)
class ForceSaturation:
    """The display can render no force beyond ``limit``, N or N m (or with a unit)."""

    limit: Number


Extra = EncoderQuantisation | ForceSaturation
"""What only simulation knows: neither has a describing function here, and no closed form holds it."""


@dataclass(frozen=True)
class Estimate:
    """H_perc at one excited frequency, rad/s: recovered from the simulated force, and by its closed form. N/m or N m/rad.

    ``error`` bounds the numerical error of ``simulated`` (steps, transient, images; an estimate, not a proof).
    ``agrees`` is None where the closed form itself is an approximation; ``approximate`` then says why.
    """

    omega: float
    simulated: complex
    closed: complex
    error: float
    approximate: str = ""

    @property
    def difference(self) -> float:
        """Between simulation and closed form."""
        return abs(self.simulated - self.closed)

    @property
    def agrees(self) -> bool | None:
        """Whether it is within the error of the estimate; None where the simulation approximates."""
        return None if self.approximate else self.difference <= self.error


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Answer):
    """A simulated run. Arrays over time, s: the hand's ``displacement``, m or rad, and ``force``, N or N m, and the same of
    the environment (``environment_displacement``, ``environment_force``). ``estimates``: H_perc at each excited frequency,
    none for a chirp or a recording or where the run is too short. ``built``: the models that were simulated.
    """

    _schema: ClassVar[str] = "haptisym.simulation/1"
    _page: ClassVar[str] = "haptisym.pages.simulate:page"

    scene: Scene
    motion: Motion
    time: Array
    displacement: Array
    force: Array
    environment_displacement: Array
    environment_force: Array
    estimates: tuple[Estimate, ...]
    built: tuple[str, ...]
    extras: tuple[Extra, ...] = ()
    notes: tuple[str, ...] = ()
    """What a reader of the force should know."""

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {self.motion.name}, {counted(len(self.estimates), 'frequency', 'frequencies')}"

    @property
    def runs(self) -> tuple[Simulation, ...]:
        """This one alone: ``Simulations`` are several."""
        return (self,)

    @property
    def certified(self) -> bool:
        """False: errors of a simulation are estimated."""
        return False

    def _body(self) -> dict[str, Any]:
        return _body(self.runs)

    def to_csv(self) -> str:
        """The run in time as a table, units in its header; rows are as far apart as the steps of the simulation want them."""
        length, force = ("rad", "N m") if self.scene.motion is Kind.ROTATION else ("m", "N")
        heads = (
            "time [s]", f"displacement [{length}]", f"force [{force}]",
            f"environment displacement [{length}]", f"environment force [{force}]",
        )  # fmt: skip
        columns = (self.time, self.displacement, self.force, self.environment_displacement, self.environment_force)
        rows = (",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True))
        return "\n".join([",".join(heads), *rows]) + "\n"

    @property
    def agrees(self) -> bool | None:
        """Whether all estimates agree with the closed forms; None where no exact closed form could be compared."""
        verdicts = [x.agrees for x in self.estimates if x.agrees is not None]
        return all(verdicts) if verdicts else None


class Simulations(Answer, tuple[Simulation, ...]):
    """Runs of one scene, one for each frequency: as a page and as a document they are one answer."""

    _schema: ClassVar[str] = Simulation._schema
    _page: ClassVar[str] = Simulation._page

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {counted(len(self), 'run')}"

    @property
    def scene(self) -> Scene:
        """That of each of them."""
        return self[0].scene

    @property
    def runs(self) -> tuple[Simulation, ...]:
        """All of them."""
        return tuple(self)

    @property
    def certified(self) -> bool:
        """False: errors of a simulation are estimated."""
        return False

    @property
    def agrees(self) -> bool | None:
        """Whether all estimates agree with the closed forms; None where no exact closed form could be compared."""
        verdicts = [x.agrees for x in self if x.agrees is not None]
        return all(verdicts) if verdicts else None

    def _body(self) -> dict[str, Any]:
        return _body(self.runs)


def _body(runs: Sequence[Simulation]) -> dict[str, Any]:
    first, rows = runs[0], [x for run in runs for x in run.estimates]
    verdicts = [x.agrees for x in rows if x.agrees is not None]
    return {
        "motion": {
            "kind": first.motion.name,
            "amplitude": first.motion.amplitude,
            "omega": [omega for run in runs for omega in run.motion.omegas],
            **_smoothing(first.motion),
        },
        "time": [0.0, max(float(run.time[-1]) for run in runs)],
        "samples": sum(len(run.time) for run in runs),
        "built": list(first.built),
        "force": {"least": min(float(r.force.min()) for r in runs), "most": max(float(r.force.max()) for r in runs)},
        "estimates": [_estimate_row(x) for x in rows],
        "agrees": all(verdicts) if verdicts else None,
        **({"notes": list(first.notes)} if first.notes else {}),
    }


def _smoothing(motion: Motion) -> dict[str, Any]:
    lowpass = getattr(motion, "lowpass", None)  # of recordings alone
    if lowpass is None:
        return {}
    return {"lowpass": {"cutoff": lowpass.cutoff, "order": lowpass.order, "phase": "zero"}}


def _estimate_row(x: Estimate) -> dict[str, Any]:
    return {
        "omega": x.omega,
        "simulated": {"real": x.simulated.real, "imag": x.simulated.imag},
        "closed": {"real": x.closed.real, "imag": x.closed.imag},
        "difference": x.difference,
        "error": x.error,
        "agrees": x.agrees,
        **({"approximate": x.approximate} if x.approximate else {}),
    }
