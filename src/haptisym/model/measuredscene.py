"""A scene whose perceived dynamics was measured: the environment with which it is compared, line by
line, on a band, by a threshold.

Between the lines nothing is known, unless the responses have a bound on their slope.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sympy import Integer

from haptisym import environments
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.model.catalogue import Environment
from haptisym.model.jnd import Threshold
from haptisym.model.quantities import MotionKind, Unit
from haptisym.model.scene import Scene

if TYPE_CHECKING:
    from haptisym.model.measured import (
        # Needs NumPy, which a scene of formulas does not load.
        Measurement,
        SlopeBound,
    )


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredScene(Shown):
    """A scene that is evaluated at measured frequencies alone. Valid by construction: SceneError
    names what is wrong.

    ``environment`` : what should be felt, a model or measured too. ``perceived`` : what is felt,
    measured. ``band`` : only lines from its low to its high end; all lines if None. ``threshold`` :
    as a Scene takes it.

    >>> from haptisym.model.measuring import measured
    >>> felt = measured([2, 8], [92.8 + 30j, -10 + 120j], radius=[2, 2])
    >>> MeasuredScene(environments.mass_spring_damper(1.8, 15, 100), felt)
    <MeasuredScene "Untitled scene": mass-spring-damper, felt as measured at 2 lines>
    """

    environment: Environment | Measurement
    perceived: Measurement
    band: tuple[Any, Any] | None = None
    threshold: Any = Threshold()
    title: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        from haptisym.model.measured import Measurement

        for key, kinds in (("environment", Environment | Measurement), ("perceived", Measurement)):
            if not isinstance(given := getattr(self, key), kinds):
                wanted = "a measured response: make one with measured(omega, H)"
                also = "an environment or " if key == "environment" else ""
                raise SceneError(f"{key}: {type(given).__name__} is not {also}{wanted}")
        # Building the frame refuses whatever no scene may have.
        frame = self.frame
        frame.knobs.need_numbers()
        object.__setattr__(self, "threshold", frame.threshold)
        if self.band is not None:
            object.__setattr__(self, "band", frame.band)
        # dH is bounded between the lines only where both of its terms are.
        slope = self.perceived.slope
        if not isinstance(self.environment, Environment) and (slope is None) != (
            self.environment.slope is None
        ):
            other = "perceived" if slope is None else "environment"
            raise SceneError(
                f"{other}: slope is missing: give it for both measured responses, or for none"
            )
        motions = {
            motion
            for motion in (
                frame.motion,
                self.perceived.motion,
                self._motion,
                slope and slope.motion,
            )
            if motion
        }
        if len(motions) > 1:
            raise SceneError(
                "translation and rotation cannot be mixed: environment and perceived have "
                "units of both; Nm is read as N*m/rad: along a line write N/m"
            )

    @property
    def frequency(self) -> Unit:
        """The unit of frequency in which pages print: the band's, as it was given."""
        return self.frame.frequency

    def _line(self) -> str:
        felt = self.environment
        what = felt.model if isinstance(felt, Environment) else felt.name
        return (
            f"{titled(self.title)}: {what}, felt as measured at "
            f"{counted(len(self.perceived), 'line')}"
        )

    @cached_property
    def frame(self) -> Scene:
        """A Scene of the parts that are exact: the environment (a spring in place of a measured
        one), band and threshold, without effects."""
        # Without a band its end is the last line; a single line at 0 needs some band all the same.
        felt = self.environment
        exact = felt if isinstance(felt, Environment) else environments.mass_spring_damper(k=1)
        last = float(self.perceived.omega[-1])
        band = self.band or (Integer(0), last or Integer(1))
        return Scene(exact, (), band, self.threshold, title=self.title, source=self.source)

    @property
    def slopes(self) -> dict[str, SlopeBound]:
        """The bounds on slopes that are stated, by the response that they are of."""
        of_environment = (
            {}
            if isinstance(self.environment, Environment)
            else {"environment": self.environment.slope}
        )
        return {
            key: x
            for key, x in {"perceived": self.perceived.slope, **of_environment}.items()
            if x is not None
        }

    @property
    def _motion(self) -> MotionKind | None:
        """The motion that a measured environment's units imply; None of a model."""
        return None if isinstance(self.environment, Environment) else self.environment.motion

    @property
    def motion(self) -> MotionKind | None:
        """The kind of motion that the units imply, along a line or about an axis; None where none
        does."""
        return self.frame.motion or self.perceived.motion or self._motion

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that its responses were read from."""
        return tuple(
            x.path
            for x in (self.environment, self.perceived)
            if not isinstance(x, Environment) and x.path
        )

    def asides(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> list[str]:
        """The notes to print with an answer, as ``Scene.asides``."""
        return self.frame.asides(besides, varied)

    def aside_keys(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> dict[str, Any]:
        """The notes as keys of a JSON document, as ``Scene.aside_keys``."""
        return self.frame.aside_keys(besides, varied)
