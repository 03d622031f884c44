"""Processor time of a recorded motion at 1 kHz with encoder and limit of the force, as a ratio to the time that it lasts.

    python benchmarks/simulation.py       (needs SciPy)

The runs that give the error of the force (without extras, with the limit alone) are counted.
"""

from __future__ import annotations

from time import process_time

import numpy as np
from timing import machine, noted

import haptisym as hs
from haptisym.model.motions import Recording

TIMES = np.arange(2001) * 1e-3
MOTION = Recording(TIMES, 0.02 * np.sin(2 * np.pi * TIMES) + 0.004 * np.sin(6.6 * np.pi * TIMES))
EXTRAS = {
    "ideal": (),
    "encoder": (hs.EncoderQuantisation("0.05 mm"),),
    "encoder and limit": (hs.EncoderQuantisation("0.05 mm"), hs.ForceSaturation("15 N")),
}
LOOP = hs.effects.sampled_loop("1 ms", "backward-difference", 1)
SCENE = hs.Scene(
    hs.environments.mass_spring_damper(k=1000), (LOOP, hs.effects.shunt(m="45 g", b="0.5")), ("0 Hz", "20 Hz")
)


def main() -> None:
    print(machine())
    hs.simulate(SCENE, MOTION, duration="10 ms")  # loads SciPy
    print("processor time / time simulated, of a sampled spring at 1 kHz")
    for name, extras in EXTRAS.items():
        begin = process_time()
        run = hs.simulate(SCENE, MOTION, extras=extras, limit=None)
        spent = noted({name: process_time() - begin})[name]
        print(f"  {name:<20} {spent / run.time[-1]:.2f}")


if __name__ == "__main__":
    main()
