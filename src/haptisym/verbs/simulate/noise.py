"""What a scene makes of the noise in a recorded motion."""

from __future__ import annotations

from math import pi

import numpy as np

from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.scene import Scene
from haptisym.verbs.simulate.motions import Motion

_NOISE = 1e-6  # m or rad
_MUCH = 10.0  # times the largest |H_perc| of the band: noise then matters before anything else does


def noise_notes(scene: Scene, motion: Motion) -> tuple[str, ...]:
    """A sentence for a recording where |H_perc| is far larger at its highest frequency than on the band; none otherwise.

    A mass differentiates a motion twice: what is a micrometre of noise grows with omega^2.
    """
    if motion.omegas or not hasattr(motion, "times"):
        return ()
    lowpass = getattr(motion, "lowpass", None)
    top = lowpass.cutoff if lowpass else motion.span[1]
    low, high = map(float, scene.band)
    values = scene.distortion().compile()(np.array([*np.linspace(low, high, 50), top]))
    sizes = np.hypot(values.perceived_real, values.perceived_imag)
    usual, most = float(np.nanmax(sizes[:-1])), float(sizes[-1])
    if not np.isfinite(most) or most <= _MUCH * usual:
        return ()
    length, force = ("µrad", "N m") if scene.motion is Kind.ROTATION else ("µm", "N")
    where = "the cutoff of its low-pass" if lowpass else "its Nyquist frequency"
    helps = "A lower cutoff removes more." if lowpass else "--lowpass FREQUENCY (zero phase) removes what is above it."
    note = (
        f"Noise of the recording is amplified: 1 {length} at {top / (2 * pi):.4g} Hz, {where}, is {_NOISE * most:.3g} {force} "
        f"at the hand, {most / usual:.3g} times what it is on the band. {helps}"
    )
    return (note,)
