"""H_perc along the band of a scene, recovered from a simulation in time with other steps, settling times and periods."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from flint import arb

from haptisym.model.scene import Scene
from haptisym.verbs.cost.contenders import DOUBLE, Method, Score, right_digits
from haptisym.verbs.simulate.entry import STEP, band_frequencies, default_amplitude
from haptisym.verbs.simulate.motions import Sines, multisine
from haptisym.verbs.simulate.network import name_of
from haptisym.verbs.simulate.run import Run, lock, period_of

_STEPS = (7.2, 5.4, 3.6, 2.7, 1.8, STEP, 0.45)
"""Radians of the highest frequency on a step."""
_TOLERANCES = (1e-1, 1e-3, 1e-6, 1e-9)
"""What is left of the transient when the lock-in begins, if its slowest pole tells."""
_PERIODS = (1, 2, 3, 6)
"""Base periods that the lock-in looks at."""
_COUNT = 5  # frequencies along the band


@dataclass(frozen=True)
class Recovery:
    """H_perc along the band of a scene, recovered from a simulation under a multisine, against the closed form."""

    scene: Scene

    @cached_property
    def motion(self) -> Sines:
        """The multisine that the hand makes."""
        motion = multisine(default_amplitude(self.scene), band_frequencies(self.scene, _COUNT))
        assert isinstance(motion, Sines)
        return motion

    @cached_property
    def truth(self) -> Any:
        """The closed form, certified to the last digit."""
        values = self.scene.distortion().compile("certified", of=("perceived_real", "perceived_imag"))(
            np.array(self.motion.omegas)
        )
        return values.perceived_real + 1j * values.perceived_imag

    def recovered(self, scene: Scene, step: float, tolerance: float, periods: int) -> Any:
        """What a simulation of a scene, this one or a simpler one, gives back for H_perc."""
        run = Run(scene, self.motion, (), step, None)
        window = periods * period_of(self.motion)
        run.advance(self.motion.fade + run.settling(tolerance) + window)
        run.advance(np.ceil(run.engine.t / period_of(self.motion) - 1e-9) * period_of(self.motion))
        force = run.engine.signal(name_of(run.ports[-1].F))
        phasors = np.array([self.motion.phasor(omega) for omega in self.motion.omegas])
        return lock(run.engine.record, force, self.motion, window, 1).values / phasors

    def score(self, answer: Any) -> Score:
        """Right digits of the worst of the frequencies, from the error of the complex number as a fraction of its size."""
        return Score(
            min(right_digits(1 + abs(x / y - 1), arb(1), DOUBLE) for x, y in zip(answer, self.truth, strict=True))
        )

    def methods(self) -> Iterator[Method]:
        """The ways to simulate: one setting changed at a time, then each effect left out. SceneError where none is possible."""
        Run(self.scene, self.motion, (), STEP, None)
        for step in _STEPS:
            yield self._way(f"steps of {step:g} rad", step=step)
        for tolerance in _TOLERANCES:
            yield self._way(f"transient of {tolerance:.0e}", tolerance=tolerance)
        for periods in _PERIODS:
            yield self._way(f"{periods} period{'s' * (periods > 1)}", periods=periods)
        for i, effect in enumerate(self.scene.effects):
            rest = (*self.scene.effects[:i], *self.scene.effects[i + 1 :])
            yield self._way(f"without {effect.name}", replace(self.scene, effects=rest, hands=()))

    def _way(
        self, name: str, scene: Scene | None = None, *, step: float = STEP, tolerance: float = 1e-12, periods: int = 4
    ) -> Method:
        def prepare(question: Recovery) -> Callable[[], Any]:
            _ = question.truth
            return partial(question.recovered, scene or question.scene, step, tolerance, periods)

        return Method(name, prepare, packages=("scipy",), ours=True)
