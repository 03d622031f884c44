"""How true the intervals and boxes of ``identify`` are: models that bend, fitted to simulated lines whose truth is known.

    python benchmarks/intervals.py

Each draw is 30 lines with circular noise of a known size, its discs given or known from coherence. Counted: intervals of each
parameter that hold the truth, boxes that hold all of it, true models that are refuted; boxes by themselves among draws that give
ranges (every positive parameter told within a factor of two). Always the same draws; each search begins at the truth. Left out:
noise that is not Gaussian, lines that depend on each other, models that are wrong, where no interval means anything.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from timing import machine

import haptisym as hs
from haptisym.kernel.errors import SceneError
from haptisym.model.measured import Complexes, Measurement
from haptisym.verbs.identify.entry import estimates, verdict
from haptisym.verbs.identify.fitting import Wanted, fit, wanted

DRAWS = 1000
OMEGA = np.geomspace(1, 60, 30)
SIGMA_OF_DISC = np.sqrt(-2 * np.log(0.05))


class Case(NamedTuple):
    """A scene, the model that is fitted to its lines, and the true values of what is free."""

    name: str
    scene: str
    model: Wanted
    truth: tuple[float, ...]


def cases() -> list[Case]:
    """Two to five parameters."""
    paper, late = (
        wanted("mass-spring-damper", ["second-order-lowpass"], None, None),
        wanted("mass-spring-damper:k,b", ["first-order-lag", "delay"], None, None),
    )
    given = "mass-spring-damper:m=1.8,b=15,k=100"
    known = wanted(given, ["second-order-lowpass"], None, None)
    text = hs.load_scene("fu2019")
    lagging = hs.Scene(
        hs.environments.mass_spring_damper(b=2, k=100), [hs.effects.first_order_lag(40), hs.effects.delay("0.02")]
    )
    return [
        Case("filter of fu2019, known environment", text, known, (80, 0.5)),
        Case("fu2019, all five", text, paper, (1.8, 15, 100, 80, 0.5)),
        Case("spring and damper, lag, delay", lagging, late, (100, 2, 40, 0.02)),
    ]


def drawn(rng: np.random.Generator, H: Complexes, noise: float, averages: int | None) -> Measurement:
    """Lines with noise of that share: discs given, or of the estimate H1 from so many averages."""

    def normal(*shape: int) -> Complexes:
        return rng.normal(size=(*shape, len(H))) + 1j * rng.normal(size=(*shape, len(H)))

    if averages is None:
        sigma = noise * np.abs(H)
        return hs.measured(OMEGA, H + sigma * normal(), radius=sigma * SIGMA_OF_DISC)
    x, v = normal(averages), normal(averages)
    force = H * x + noise * np.sqrt(2 * averages) * np.abs(H) * v
    sxx, sff, sxf = (np.abs(x) ** 2).sum(axis=0), (np.abs(force) ** 2).sum(axis=0), (np.conj(x) * force).sum(axis=0)
    return hs.measured(OMEGA, sxf / sxx, coherence=np.abs(sxf) ** 2 / sxx / sff, averages=averages)


def row(case: Case, noise: float, averages: int | None, draws: int = DRAWS) -> str:
    """One line of the table."""
    rng, H = np.random.default_rng(2019), hs.sampled(case.scene, OMEGA).H
    held, boxes, ranged, refuted, errors, refused = [], [], [], [], [], 0
    for _ in range(draws):
        try:
            found = fit(case.model, drawn(rng, H, noise, averages), [np.array(case.truth)])
        except SceneError:
            refused += 1
            continue
        ends = estimates(found)
        held.append([e.low <= v <= e.high for e, v in zip(ends, case.truth, strict=True)])
        boxes.append(all(e.least <= v <= e.most for e, v in zip(ends, case.truth, strict=True)))
        ranged.append(all(e.told for e in ends))
        refuted.append(verdict(found).fits is False)
        errors.append(max(e.error / v for e, v in zip(ends, case.truth, strict=True)))
    own, box, some = np.mean(held, axis=0), np.mean(boxes), np.array(boxes)[np.array(ranged)]
    told = f"{100 * some.mean():6.1f}" if len(some) > draws / 10 else "     -"
    return (
        f"{case.name:<36} {100 * noise:5g} {averages or 'discs':>8} {100 * np.median(errors):8.1f} {100 * own.min():8.1f} "
        f"{100 * own.mean():6.1f} {100 * box:6.1f} {100 * np.mean(ranged):7.0f} {told} {100 * np.mean(refuted):8.1f} {refused:8d}"
    )


def main() -> None:
    """A table."""
    print(machine())
    print("=== coverage ===")
    print(f"{DRAWS} draws each; shares in %")
    print(f"{'model':<36} noise averages   error    worst   mean    box  ranged  its box  refuted  refused")
    for case in cases():
        for noise in (0.01, 0.05, 0.2):
            for averages in (None, 8):
                print(row(case, noise, averages), flush=True)


if __name__ == "__main__":
    main()
