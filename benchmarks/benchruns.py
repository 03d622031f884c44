"""The bench runs that the package ships: shipped scenes as if they stood on a bench, and the truth beside them.

    python benchmarks/benchruns.py          writes src/haptisym/benches, always the same

Records are periodic, so that each line of the force is the exact H_perc times that of the motion; then comes what a bench adds:
noise, a force sensor that saturates, quantised readings of both, samples at 40 Hz. In the third run the actuator itself gives
steps of half a newton and no more than 9 N. That is not linear: beside its truth, which the scene is, lies what H1 tends to,
H_perc times the gain that steps and limits leave of a Gaussian signal (Bussgang). Left out: quantisation inside a loop, for which
there is no such formula.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.stats import norm

import haptisym as hs

FOLDER = Path(hs.__file__).parent / "benches"
RATE, SECONDS = 40, 128
COUNT = RATE * SECONDS
OMEGA = 2 * np.pi * np.fft.rfftfreq(COUNT, 1 / RATE)
HAND = 0.5 * (1j * OMEGA) ** 2 + 5 * 1j * OMEGA + 150
"""The hand that holds the second display: kg, N s/m, N/m."""


def response(scene: str) -> np.ndarray:
    """H_perc at all lines."""
    return hs.sampled(scene, OMEGA).H


def coloured(rng: np.random.Generator, size: float, low: float, high: float) -> np.ndarray:
    """Lines of Gaussian noise of that standard deviation between two frequencies, Hz."""
    lines = rng.normal(size=OMEGA.size) + 1j * rng.normal(size=OMEGA.size)
    lines *= (2 * np.pi * low <= OMEGA) & (2 * np.pi * high >= OMEGA)
    return lines * size / np.fft.irfft(lines, COUNT).std()


def sensed(rng: np.random.Generator, lines: np.ndarray, *, noise: float, step: float, most: float) -> np.ndarray:
    """What a sensor reads: noise, saturation, whole multiples of a step."""
    signal = np.fft.irfft(lines, COUNT) + noise * rng.normal(size=COUNT)
    return np.round(np.clip(signal, -most, most) / step)


def imposed(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """fu2019, moved by a shaker."""
    x = coloured(rng, 0.01, 0.1, 3.5)
    force = response("fu2019") * x
    position = sensed(rng, x, noise=5e-6, step=1e-5, most=0.2)
    return {"position [mm]": position / 100, "force [N]": sensed(rng, force, noise=0.3, step=0.01, most=14) / 100}


STEP, LIMIT = 0.5, 9.0
"""Of the actuator, N."""


def actuated(command: np.ndarray) -> np.ndarray:
    """What the actuator gives: steps, up to its limit."""
    return np.clip(STEP * np.round(command / STEP), -LIMIT, LIMIT)


def gain_left(spread: float) -> float:
    """Of a Gaussian command of that standard deviation: the mean slope, which is each step times the density where it stands."""
    edges = np.arange(-LIMIT + STEP / 2, LIMIT, STEP)
    return float(STEP * norm.pdf(edges, scale=spread).sum())


def clipped(rng: np.random.Generator, size: float = 0.01) -> dict[str, np.ndarray]:
    """fu2019, moved by a shaker, with a weak actuator: ``size`` of the motion in metres."""
    x = coloured(rng, size, 0.1, 3.5)
    force = actuated(np.fft.irfft(response("fu2019") * x, COUNT)) + 0.05 * rng.normal(size=COUNT)
    return {"position [mm]": sensed(rng, x, noise=5e-6, step=1e-5, most=0.2) / 100, "force [N]": np.round(force, 2)}


def held(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """delayed-spring, held: the display's own disturbances move the hand, too."""
    H, r, n = response("delayed-spring"), coloured(rng, 4, 0.1, 6), coloured(rng, 1.5, 0.1, 12)
    x = (r - n) / (HAND + H)
    force = H * x + n
    return {
        "position [mm]": sensed(rng, x, noise=2e-6, step=1e-5, most=0.2) / 100,
        "force [N]": sensed(rng, force, noise=0.02, step=0.01, most=12) / 100,
        "reference": np.round(np.fft.irfft(r, COUNT), 3),
    }


RUNS = {
    "fu2019": ("fu2019", imposed),
    "delayed-spring": ("delayed-spring", held),
    "fu2019-clipped": ("fu2019", clipped),
}


def main() -> None:
    """Write all files."""
    FOLDER.mkdir(exist_ok=True)
    at = np.linspace(1, 15, 57)
    for seed, (title, (scene, run)) in enumerate(RUNS.items(), 2026):
        columns = run(np.random.default_rng(seed))
        rows = zip(*(x.tolist() for x in columns.values()), strict=True)
        text = [f"{i / RATE:.6g},{','.join(f'{x:.6g}' for x in row)}" for i, row in enumerate(rows)]
        name = f"{title}-bench"
        (FOLDER / f"{name}.csv").write_text("\n".join([f"t [s],{','.join(columns)}", *text, ""]), encoding="utf-8")
        hs.sampled(scene, at).to_csv(FOLDER / f"{name}.truth.csv")
        print(name, {key: f"{np.abs(x).max():.4g}" for key, x in columns.items()})
    lines = response("fu2019") * coloured(np.random.default_rng(seed), 0.01, 0.1, 3.5)
    left = gain_left(float(np.fft.irfft(lines, COUNT).std()))
    hs.measured(at, left * hs.sampled("fu2019", at).H).to_csv(FOLDER / f"{name}.nearest.csv")


if __name__ == "__main__":
    main()
