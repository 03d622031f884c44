"""A scene whose perceived dynamics was measured: what it is compared with, line by line, on which
band, by which threshold."""

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
        Measurement,  # needs NumPy, which a scene of formulas does not load
        SlopeBound,
    )


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredScene(Shown):
    """What is to be evaluated at measured frequencies alone. Valid by construction: SceneError
    names what is wrong.

    ``environment`` : what should be felt, a model or measured too. ``perceived`` : what is felt,
    measured. ``band`` : only lines from the one to the other frequency; all lines if None.
    ``threshold`` : as a Scene takes it.

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
        frame = self.frame  # which refuses what no scene may be
        frame.knobs.need_numbers()
        object.__setattr__(self, "threshold", frame.threshold)
        if self.band is not None:
            object.__setattr__(self, "band", frame.band)
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
                "units of both"
            )

    @property
    def frequency(self) -> Unit:
        """The unit of frequency in which pages print: the band's, as it was given."""
        return self.frame.frequency

    def _line(self) -> str:
        own = self.environment
        what = own.model if isinstance(own, Environment) else own.name
        return (
            f"{titled(self.title)}: {what}, felt as measured at "
            f"{counted(len(self.perceived), 'line')}"
        )

    @cached_property
    def frame(self) -> Scene:
        """The scene without effects on the band: all that is known exactly, with a spring where the
        environment is measured."""
        own = self.environment
        exact = own if isinstance(own, Environment) else environments.mass_spring_damper(k=1)
        last = float(self.perceived.omega[-1])
        band = self.band or (Integer(0), last or Integer(1))
        return Scene(exact, (), band, self.threshold, title=self.title, source=self.source)

    @property
    def slopes(self) -> dict[str, SlopeBound]:
        """The bounds that are stated, by which response they are of."""
        own = (
            {}
            if isinstance(self.environment, Environment)
            else {"environment": self.environment.slope}
        )
        return {
            key: x for key, x in {"perceived": self.perceived.slope, **own}.items() if x is not None
        }

    @property
    def _motion(self) -> MotionKind | None:
        return None if isinstance(self.environment, Environment) else self.environment.motion

    @property
    def motion(self) -> MotionKind | None:
        """Whether the hand moves along a line or about an axis; None if no unit tells."""
        return self.frame.motion or self.perceived.motion or self._motion

    @property
    def files(self) -> tuple[Path, ...]:
        """Those that its responses were read from."""
        return tuple(
            x.path
            for x in (self.environment, self.perceived)
            if not isinstance(x, Environment) and x.path
        )

    def asides(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> list[str]:
        """As ``Scene.asides``."""
        return self.frame.asides(besides, varied)

    def aside_keys(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> dict[str, Any]:
        """As ``Scene.aside_keys``."""
        return self.frame.aside_keys(besides, varied)
